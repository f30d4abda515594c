//! The command line.

use clap::error::ErrorKind;
use clap::{CommandFactory, FromArgMatches, Parser};
use std::ffi::OsString;

/// Measures error against time: methods on motions that are known to the last digit.
#[derive(Parser)]
#[command(version)]
pub struct Options {
    /// Measure the whole atlas: ten motions, each by every method that fits (compiled by a program of its own, which
    /// takes minutes).
    #[arg(long)]
    pub all: bool,

    /// Motions to measure; all unless given.
    #[arg(long = "motion", value_name = "NAME", value_delimiter = ',')]
    motions: Vec<String>,

    /// Methods to measure, by their names or a part of them: `gauss` stands for each of Gauss's; all unless given.
    #[arg(long = "method", value_name = "NAME", value_delimiter = ',')]
    methods: Vec<String>,

    /// Tolerances of the adaptive methods, instead of 1, 1e-1, … 1e-15. Methods of equal steps have a range of those.
    #[arg(long = "tolerance", value_name = "X", value_delimiter = ',', value_parser = tolerance, allow_negative_numbers = true)]
    pub tolerances: Vec<f64>,

    /// Follow energy and momenta over 10⁵ periods.
    #[arg(long)]
    long: bool,
}

/// Decades of periods with `--long`.
const LONG: u32 = 5;

/// Motions of the atlas.
pub const ATLAS: [&str; 10] = [
    "pendulum",
    "kepler",
    "kepler-eccentric",
    "kepler-polar",
    "henon-heiles",
    "double-pendulum",
    "top",
    "spring-pendulum",
    "driven-pendulum",
    "chain",
];

/// Name of a motion, and the methods that fit it.
pub type Known = (&'static str, Vec<&'static str>);

impl Options {
    /// The options of this program's call. The program ends here if they ask for help, or for a name that it does not
    /// know. With `more` they may be for the atlas, which knows more names.
    pub fn of(known: &[Known], more: bool) -> Options {
        Options::checked(known, more, std::env::args_os()).unwrap_or_else(|error| error.exit())
    }

    pub fn checked(
        known: &[Known],
        more: bool,
        call: impl IntoIterator<Item = impl Into<OsString> + Clone>,
    ) -> Result<Options, clap::Error> {
        let motions = listed(known.iter().map(|(motion, _)| *motion));
        let methods = listed(known.iter().flat_map(|(_, methods)| methods.iter().copied()));
        let more_motions = listed(ATLAS.into_iter());
        let atlas = if more { format!("\n\nMotions with --all: {more_motions}") } else { String::new() };
        let help = format!("Motions: {motions}\n\nMethods: {methods}{atlas}");
        let mut command = Options::command().after_help(help);
        let mut options = Options::from_arg_matches(&command.try_get_matches_from_mut(call)?)?;
        // From coarse to fine, as sweeps are.
        options.tolerances.sort_by(|a, b| b.total_cmp(a));
        let is_for_atlas = options.all && more;
        let hint = if more && !is_for_atlas { "\n\n`--all` has more" } else { "" };
        let mut unknown = |what: String, there_are: &str| {
            command.error(ErrorKind::InvalidValue, format!("{what}; there are: {there_are}{hint}"))
        };
        let (all, there_are): (Vec<&str>, _) = match is_for_atlas {
            true => (ATLAS.into(), &more_motions),
            false => (known.iter().map(|(motion, _)| *motion).collect(), &motions),
        };
        let is_motion = |name: &&String| all.iter().any(|motion| plain(motion) == plain(name));
        if let Some(name) = options.motions.iter().find(|name| !is_motion(name)) {
            return Err(unknown(format!("no motion `{name}`"), there_are));
        }
        if is_for_atlas {
            return Ok(options);
        }
        let chosen = known.iter().filter(|(motion, _)| options.wants_motion(motion));
        let fitting: Vec<&str> = chosen.flat_map(|(_, methods)| methods.iter().copied()).collect();
        let is_method = |name: &&String| fitting.iter().any(|method| named(method, name));
        match options.methods.iter().find(|name| !is_method(name)) {
            Some(name) => {
                let mut others = known.iter().flat_map(|(_, methods)| methods);
                let what = match others.any(|method| named(method, name)) {
                    true => format!("the method `{name}` fits none of these motions"),
                    false => format!("no method `{name}`"),
                };
                Err(unknown(what, &listed(fitting.into_iter())))
            }
            None => Ok(options),
        }
    }

    pub fn wants_motion(&self, stem: &str) -> bool {
        self.motions.is_empty() || self.motions.iter().any(|name| plain(name) == plain(stem))
    }

    pub fn wants_method(&self, method: &str) -> bool {
        self.methods.is_empty() || self.methods.iter().any(|name| named(method, name))
    }

    /// Decades of periods in long runs of a motion that has so many by itself.
    pub fn decades(&self, own: u32) -> u32 {
        if self.long { LONG } else { own }
    }
}

/// The letters and digits of a name, which count.
fn plain(text: &str) -> String {
    text.to_lowercase().replace('ö', "o").chars().filter(char::is_ascii_alphanumeric).collect()
}

/// Is this the name of a method, or a part of it?
fn named(method: &str, name: &str) -> bool {
    let name = plain(name);
    !name.is_empty() && plain(method).contains(&name)
}

/// Each name once, in order of appearance.
fn listed<'a>(names: impl Iterator<Item = &'a str>) -> String {
    let mut listed: Vec<&str> = Vec::new();
    for name in names {
        if !listed.contains(&name) {
            listed.push(name);
        }
    }
    listed.join(", ")
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(tolerance) if tolerance > 0.0 && tolerance <= 1.0 => Ok(tolerance),
        _ => {
            Err("a tolerance is a number above 0 and up to 1, as 1e-6; a comma stands between two of them"
                .into())
        }
    }
}
