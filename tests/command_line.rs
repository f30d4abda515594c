//! The command lines of the examples `work_precision` and `monte_carlo`.

#![allow(missing_docs, dead_code)]

#[path = "../examples/monte_carlo/options.rs"]
mod monte_carlo;
#[path = "../examples/work_precision/options.rs"]
mod options;

use clap::error::ErrorKind;
use options::Options;

/// Options of a program that has two motions.
fn call(words: &str, more: bool) -> Result<Options, clap::Error> {
    let known =
        [("pendulum", vec!["RK4", "Nyström 12", "Verner 9(8)"]), ("top", vec!["RK4", "Gauss 4", "Gauss 6"])];
    Options::checked(&known, more, format!("work_precision {words}").split_whitespace())
}

fn refusal(words: &str) -> (ErrorKind, String) {
    let error = call(words, true).err().unwrap_or_else(|| panic!("`{words}` is accepted"));
    (error.kind(), error.to_string())
}

#[test]
fn help_lists_options_motions_and_methods() {
    let (kind, help) = refusal("--help");
    assert_eq!(kind, ErrorKind::DisplayHelp);
    let words = [
        "--all",
        "--motion <NAME>",
        "--method <NAME>",
        "--tolerance <X>",
        "--long",
        "pendulum, top",
        "RK4, Nyström 12",
        "Motions with --all: pendulum, kepler, kepler-eccentric",
    ];
    for word in words {
        assert!(help.contains(word), "{word}: {help}");
    }
}

#[test]
fn unknown_names_are_answered_with_those_that_there_are() {
    for (words, answer) in [
        ("--motion chain", "no motion `chain`; there are: pendulum, top"),
        ("--motion top,chain", "no motion `chain`; there are: pendulum, top"),
        ("--method heun", "no method `heun`; there are: RK4, Nyström 12, Verner 9(8), Gauss 4, Gauss 6"),
        (
            "--motion top --method verner",
            "the method `verner` fits none of these motions; there are: RK4, Gauss 4, Gauss 6",
        ),
        ("--method (", "no method `(`; there are: RK4"),
        ("--tolerance 0", "a tolerance is a number above 0 and up to 1"),
        ("--tolerance -1", "a tolerance is a number above 0 and up to 1"),
        ("--tolerance 1e-6,x", "a tolerance is a number above 0 and up to 1"),
        ("--tolerance 1,5", "a comma stands between two of them"),
        ("--tolerance 1e400", "a tolerance is a number above 0 and up to 1"),
        ("--all --motion nosuch", "no motion `nosuch`; there are: pendulum, kepler, kepler-eccentric"),
        ("--tolerances 1", "a similar argument exists: '--tolerance'"),
        ("pendulum", "unexpected argument 'pendulum'"),
    ] {
        let (_, message) = refusal(words);
        assert!(message.contains(answer), "{words}: {message}");
    }
    assert!(refusal("--motion chain").1.contains("`--all` has more"));
    assert!(!call("--motion chain", false).err().expect("refused").to_string().contains("--all` has"));
    // The atlas says what it knows.
    assert!(call("--all --motion chain", true).is_ok_and(|options| options.all));
    assert!(call("--all --motion chain", false).is_err());
}

#[test]
fn names_choose() {
    let options = call("--motion top --method gauss,verner9(8)", false);
    assert!(options.is_err(), "Verner does not fit the top here");
    let options =
        call("--method gauss --method nystrom,VERNER --tolerance 1e-6,1e-9 --tolerance 1e-3", true).unwrap();
    assert!(options.wants_motion("pendulum") && options.wants_motion("top"));
    let wanted = ["RK4", "Nyström 12", "Verner 9(8)", "Gauss 4"].map(|method| options.wants_method(method));
    assert_eq!(wanted, [false, true, true, true]);
    assert_eq!(options.tolerances, [1e-3, 1e-6, 1e-9], "from coarse to fine");
    assert_eq!((options.decades(3), call("--long", true).unwrap().decades(3)), (3, 5));
    assert!(!call("--motion top", true).unwrap().wants_motion("pendulum"));
    assert!(call("--motion Top", true).unwrap().wants_motion("top"));
    assert!(call("--all --motion Henon_Heiles", true).unwrap().wants_motion("henon-heiles"));
}

fn monte_carlo(words: &str) -> Result<monte_carlo::Arguments, String> {
    let words = format!("monte_carlo {words}");
    monte_carlo::Arguments::checked(words.split_whitespace().map(String::from))
        .map_err(|error| error.to_string())
}

#[test]
fn options_of_monte_carlo_are_checked_together() {
    let arguments = monte_carlo("--confidence 0.02 --multifidelity --samples 1000").expect("accepted");
    assert_eq!((arguments.confidence, arguments.multifidelity, arguments.samples), (Some(0.02), true, 1000));
    assert!(monte_carlo("--samples 1000 --shard 2/3").is_ok_and(|arguments| arguments.shard == Some((2, 3))));
    assert!(monte_carlo("merge 3").is_ok_and(|arguments| arguments.command.is_some()));
    for (words, answer) in [
        ("--multifidelity", "--confidence <SECONDS>"),
        ("--confidence 0", "a positive number is wanted"),
        ("--confidence -1", "-1"),
        ("--confidence inf", "a positive number is wanted"),
        ("--tolerance 0", "a positive number is wanted"),
        ("--confidence 0.1 --shard 1/2", "cannot be used with"),
        ("--confidence 0.1 --multifidelity --csv tops.csv", "cannot be used with"),
        ("--confidence 0.1 merge 2", "leave out --confidence"),
        ("--shard 1/2 merge 2", "leave out --shard"),
        ("--shard 3/2", "there is no shard 3 of 2"),
        ("--samples 1", "1"),
    ] {
        let message = monte_carlo(words).err().unwrap_or_else(|| panic!("`{words}` is accepted"));
        assert!(message.contains(answer), "{words}: {message}");
    }
    assert!(monte_carlo("--help").err().is_some_and(|help| help.contains("--multifidelity")));
}
