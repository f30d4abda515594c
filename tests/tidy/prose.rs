//! Checks of documentation and documents as prose: sentences with a subject, whole comments, widths, and units of
//! quantities.

use super::{documents, prose, texts};

/// Folders whose documentation and comments are read as prose.
const DOCUMENTED: [&str; 5] = ["lagrange-runtime/src", "lagrange-macros/src", "examples", "tests", "benches"];

/// Words with which a clause without a subject begins.
const HEADLESS: [&str; 18] = [
    "As",
    "At which",
    "By",
    "For which",
    "How",
    "Of",
    "On which",
    "So many",
    "That of",
    "That on",
    "That which",
    "Those",
    "What",
    "When",
    "Where",
    "Whether",
    "Which",
    "Why",
];

/// First lines of documentation that begin with one of `HEADLESS`, with their places.
fn headless(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (name, text) in prose(folder) {
        let mut before = "";
        for (i, line) in text.lines().map(str::trim).enumerate() {
            let marks = ["///", "//!"].into_iter().find(|marks| line.starts_with(marks));
            let first =
                marks.filter(|marks| !before.starts_with(marks)).map(|marks| line[marks.len()..].trim());
            let begins = |text: &str, word: &str| {
                text.strip_prefix(word).is_some_and(|rest| rest.starts_with([' ', ',']))
            };
            if let Some(first) = first.filter(|text| HEADLESS.iter().any(|word| begins(text, word))) {
                found.push(format!("{folder}/{name}:{}: {first}", i + 1));
            }
            before = line;
        }
    }
    found
}

/// An IDE shows the first sentence of documentation, which therefore begins with what the thing is or does: "Returns
/// …", "Double buffer of …".
#[test]
fn documentation_begins_with_a_subject() {
    for folder in DOCUMENTED {
        let found = headless(folder);
        assert!(found.is_empty(), "{folder}: {found:#?}");
    }
}

/// One block of documentation: consecutive lines with the same marks, without them, and its place.
struct Block {
    place: String,
    lines: Vec<String>,
}

/// Blocks of documentation in the sources below a folder.
fn blocks(folder: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    for (name, text) in prose(folder) {
        let mut before = None;
        for (i, line) in text.lines().map(str::trim).enumerate() {
            let marks = ["///", "//!"].into_iter().find(|marks| line.starts_with(marks));
            if let Some(marks) = marks {
                if before != Some(marks) {
                    found.push(Block { place: format!("{folder}/{name}:{}", i + 1), lines: Vec::new() });
                }
                let block = found.last_mut().expect("the block of this line");
                block.lines.push(line[marks.len()..].trim().into());
            }
            before = marks;
        }
    }
    found
}

/// Does a text begin as a sentence or with a symbol? A word of one or two letters that is not a common one is a symbol
/// (`x`, `dθ`), and so is the name of an elementary function.
fn begins_a_sentence(text: &str) -> bool {
    const COMMON: [&str; 18] = [
        "a", "an", "as", "at", "be", "by", "do", "if", "in", "is", "it", "no", "of", "on", "or", "so", "to",
        "we",
    ];
    const NAMES: [&str; 6] = ["cos", "exp", "log", "rustc", "sin", "tan"];
    if !text.starts_with(|c: char| c.is_ascii_lowercase()) {
        return true;
    }
    let word: String = text.chars().take_while(char::is_ascii_lowercase).collect();
    // (In `a b + c` and `a / b`, `a` is a symbol: no word follows.)
    let rest = text[word.len()..].trim_start();
    let is_followed = rest.chars().take_while(char::is_ascii_lowercase).count() > 1;
    NAMES.contains(&word.as_str()) || word.len() <= 2 && !(COMMON.contains(&word.as_str()) && is_followed)
}

/// Does the last line of a block end a sentence, a listing, a table or a formula?
fn ends_a_sentence(line: &str) -> bool {
    let bare = line.trim_end_matches(['"', '”', '’', ')', '`', '*', '_']);
    let is_definition = line.starts_with('[') && line.contains("]: ");
    // A formula has no words beside names in backticks.
    let is_formula = || {
        let outside: String = line.split('`').step_by(2).collect::<Vec<_>>().join(" ");
        let mut words = outside.split(|c: char| !c.is_ascii_alphabetic());
        words.all(|word| word.len() <= 2 || ["and", "cos", "exp", "sin"].contains(&word))
    };
    bare.ends_with(['.', ':', '!', '?'])
        || line.ends_with("```")
        || line.ends_with('|')
        || is_definition
        || is_formula()
}

/// A tooltip shows one comment: half a sentence, if that goes on in the comment of the next field.
#[test]
fn a_doc_comment_stands_alone() {
    assert!(begins_a_sentence("a b + c") && begins_a_sentence("ġ and g̈") && begins_a_sentence("`x`"));
    assert!(
        !begins_a_sentence("and the same") && !begins_a_sentence("a matrix") && !begins_a_sentence("by rows")
    );
    assert!(ends_a_sentence("`a < b`") && ends_a_sentence("(see there.)") && ends_a_sentence("M⁻¹ x"));
    assert!(!ends_a_sentence("Its row of A,") && !ends_a_sentence("Number of shots"));
    let mut wrong = Vec::new();
    for folder in DOCUMENTED {
        for Block { place, lines } in blocks(folder) {
            let mut lines = lines.iter().filter(|line| !line.is_empty());
            let Some(first) = lines.next() else { continue };
            let last = lines.next_back().unwrap_or(first);
            if !begins_a_sentence(first) || !ends_a_sentence(last) {
                wrong.push(format!("{place}: {first} … {last}"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}: {wrong:#?}", wrong.len());
}

/// Paragraphs and rows of tables of a Markdown text, each in one line with the number of its first one. Listings are
/// left out.
fn paragraphs<'a>(lines: impl Iterator<Item = &'a str>) -> Vec<(usize, String)> {
    let (mut found, mut code, mut open) = (Vec::<(usize, String)>::new(), false, false);
    for (i, line) in lines.map(str::trim).enumerate() {
        let is_fence = line.starts_with("```");
        code ^= is_fence;
        let is_item = line.starts_with("- ") || line.starts_with("| ");
        if is_fence || code || line.is_empty() {
            open = false;
        } else if let Some((_, text)) = found.last_mut().filter(|_| open && !is_item) {
            *text = format!("{text} {line}");
        } else {
            found.push((i, line.trim_start_matches("- ").into()));
            open = true;
        }
    }
    found
}

/// Participles that do not end in -ed.
const PARTICIPLES: [&str; 20] = [
    "begun", "chosen", "done", "drawn", "found", "given", "held", "kept", "known", "left", "lost", "made",
    "meant", "said", "shown", "sought", "taken", "thought", "told", "written",
];

/// Passive predicates that end in "of", with nobody who acts.
const OF_NOBODY: [&str; 11] = [
    "asked", "demanded", "expected", "known", "looked", "required", "said", "spoken", "thought", "told",
    "wanted",
];

/// Predicates of a text that stand before their subject ("Told apart are …"), or are passive and end in "of" ("is
/// wanted" with "of it").
fn turned_round(text: &str) -> Vec<String> {
    const IS: [&str; 5] = ["is", "are", "was", "were", "be"];
    const PARTICLES: [&str; 16] = [
        "alone", "also", "apart", "at", "by", "for", "from", "in", "of", "on", "out", "over", "there", "to",
        "too", "up",
    ];
    const NOUNS: [&str; 8] = ["bed", "feed", "hundred", "need", "red", "seed", "shed", "speed"];
    let words: Vec<&str> = text.split_whitespace().collect();
    let bare = |word: &str| word.trim_matches(|c: char| !c.is_alphanumeric()).to_lowercase();
    let is_participle =
        |word: &str| PARTICIPLES.contains(&word) || word.ends_with("ed") && !NOUNS.contains(&word);
    let mut found = Vec::new();
    for i in 0..words.len() {
        let at = |k: usize| words.get(i + k).copied().unwrap_or_default();
        let begins = i == 0 || words[i - 1].ends_with(['.', '!', '?', ':', ';', '|', ')']);
        let is_plain = |word: &str| word.chars().all(|c| c.is_ascii_alphabetic());
        if begins && is_plain(at(0)) && is_participle(&bare(at(0))) {
            let next = if PARTICLES.contains(&at(1)) { 2 } else { 1 };
            if IS[..4].contains(&at(next)) {
                found.push(words[i..(i + 8).min(words.len())].join(" "));
            }
        }
        let is_of_nobody = IS.contains(&at(0)) && OF_NOBODY.contains(&at(1)) && bare(at(2)) == "of"
            || ["what", "that"].contains(&bare(at(0)).as_str())
                && IS.contains(&at(1))
                && ["left", "made"].contains(&at(2))
                && bare(at(3)) == "of"
                && !(bare(at(0)) == "that" && at(2) == "made");
        if is_of_nobody {
            found.push(words[i.saturating_sub(3)..(i + 6).min(words.len())].join(" "));
        }
    }
    found
}

/// A sentence has its subject first, and says who acts.
#[test]
fn predicates_follow_their_subjects() {
    for wrong in [
        "Told apart are the name and the source.",
        "It is 1. Missed is the first one.",
        "A function that gives what is wanted of it.",
        "What is made of each.",
    ] {
        assert_eq!(turned_round(wrong).len(), 1, "{wrong}");
    }
    for right in ["Speed is a ratio.", "Angles are in radians.", "It is made of the samples.", "Seed is 1."] {
        assert!(turned_round(right).is_empty(), "{right}");
    }
    let mut wrong = Vec::new();
    let mut look = |place: &str, text: &str| {
        wrong.extend(turned_round(text).into_iter().map(|found| format!("{place}: {found}")));
    };
    for folder in DOCUMENTED {
        for Block { place, lines } in blocks(folder) {
            for (_, text) in paragraphs(lines.iter().map(String::as_str)) {
                look(&place, &text);
            }
        }
    }
    let is_read =
        |name: &str| name == "README.md" || name.starts_with("docs/") && !name.starts_with("docs/lab/");
    for (name, text) in documents().iter().filter(|(name, _)| is_read(name)) {
        for (i, text) in paragraphs(text.lines()) {
            look(&format!("{name}:{}", i + 1), &text);
        }
    }
    assert!(wrong.is_empty(), "{}: {wrong:#?}", wrong.len());
}

/// Files of the runtime whose public functions return physical quantities. (Statistics of ensembles have the units of
/// the outputs that they are given.)
const QUANTITIES: [&str; 21] = [
    "analysis/equilibrium.rs",
    "analysis/lyapunov.rs",
    "analysis/modal.rs",
    "analysis/modes.rs",
    "analysis/periodic.rs",
    "analysis/small.rs",
    "analysis/spectrum.rs",
    "analysis/state_space.rs",
    "analysis/steady.rs",
    "analysis/variational.rs",
    "constraint.rs",
    "controller.rs",
    "event/definition.rs",
    "external.rs",
    "impulse.rs",
    "input.rs",
    "integrate.rs",
    "integrate/stepper.rs",
    "quadrature.rs",
    "state.rs",
    "system.rs",
];

/// Public functions and functions of public traits in a text, each with its line, the type that it returns, and its
/// documentation; without those that rustdoc hides.
fn returning(text: &str) -> Vec<(usize, String, String, String)> {
    let (mut found, mut docs, mut hidden, mut in_trait) = (Vec::new(), String::new(), false, false);
    let lines: Vec<&str> = text.lines().collect();
    for (i, line) in lines.iter().enumerate() {
        let code = line.trim();
        if let Some(doc) = code.strip_prefix("///") {
            docs += doc.trim();
            docs.push(' ');
            continue;
        }
        if code.starts_with('#') {
            hidden |= code.contains("doc(hidden)");
            continue;
        }
        in_trait = line.starts_with("pub trait ") || in_trait && !line.starts_with('}');
        let is_public = code.starts_with("pub fn ") || code.starts_with("pub const fn ");
        if !hidden && (is_public || in_trait && line.starts_with("    fn ")) {
            let name =
                code.split("fn ").nth(1).unwrap_or_default().split(['(', '<']).next().unwrap_or_default();
            let end = |line: &&&str| !line.ends_with(['{', ';']) && !line.trim().starts_with("where");
            let mut signature =
                lines[i..].iter().take_while(end).map(|line| line.trim()).collect::<Vec<_>>().join(" ");
            signature += lines.iter().skip(i).find(|line| !end(line)).copied().unwrap_or_default();
            let result = signature.rsplit_once("-> ").map_or("", |(_, result)| result);
            let result =
                result.split(" where").next().unwrap_or_default().trim_end_matches([' ', '{', ';', ',']);
            found.push((i + 1, name.to_string(), result.to_string(), docs.clone()));
        }
        if !code.is_empty() && !code.starts_with("//") {
            (docs, hidden) = (String::new(), false);
        }
    }
    found
}

/// Is a type a number, a vector or a matrix, also by reference, in an array or where there may be none?
fn is_quantity(result: &str) -> bool {
    const NUMBERS: [&str; 9] = [
        "DMatrix<",
        "DVector<",
        "S",
        "SMatrix<",
        "SVector<",
        "Self::Scalar",
        "Sys::Scalar",
        "f64",
        "Vec<f64>",
    ];
    let mut inner = result;
    while let Some(rest) =
        ["&", "[", "Option<", "Result<"].into_iter().find_map(|wrapper| inner.strip_prefix(wrapper))
    {
        inner = rest;
    }
    NUMBERS.into_iter().any(|number| {
        let rest = inner.strip_prefix(number);
        rest.is_some_and(|rest| {
            number.ends_with('<') || !rest.starts_with(|c: char| c.is_alphanumeric() || c == ':')
        })
    })
}

/// Does documentation say in which unit or shape a quantity is, or name the function whose documentation does?
fn has_unit_or_shape(docs: &str) -> bool {
    const WORDS: [&str; 37] = [
        "× N",
        "× M",
        "× R",
        "× n",
        "× K",
        "N × ",
        "M × ",
        "n × ",
        "1/s",
        "/s",
        "J",
        "J s",
        "N",
        "N m",
        "N s",
        "W",
        "kg",
        "m",
        "m/s",
        "rad",
        "rad/s",
        "s",
        "column",
        "component",
        "components",
        "dimensionless",
        "elements",
        "entry",
        "evaluations",
        "length",
        "number",
        "radians",
        "relative",
        "seconds",
        "unit",
        "units",
        "probability",
    ];
    let is_end = |c: Option<char>| c.is_none_or(|c| !c.is_alphanumeric() && c != '_');
    let has = |word: &str| {
        docs.match_indices(word).any(|(i, _)| {
            word.contains('×')
                || is_end(docs[..i].chars().next_back()) && is_end(docs[i + word.len()..].chars().next())
        })
    };
    docs.starts_with("[`") || WORDS.into_iter().any(has)
}

/// Whoever uses a number needs its unit, and whoever uses a vector or a matrix its length or shape.
#[test]
fn quantities_have_units_or_shapes() {
    assert!(
        is_quantity("Option<&[f64]>")
            && is_quantity("Result<SVector<S, N>, Failure<S>>")
            && !is_quantity("State<S, N>")
    );
    assert!(!is_quantity("Self") && !is_quantity("Result<(), Failure<S>>") && is_quantity("[S; 3]"));
    assert!(has_unit_or_shape("Energy, in J.") && !has_unit_or_shape("The accelerations."));
    let texts = texts("lagrange-runtime/src");
    let (mut wrong, mut count) = (Vec::new(), 0);
    for file in QUANTITIES {
        for (line, name, result, docs) in returning(&texts[file]) {
            if is_quantity(&result) {
                count += 1;
                if !has_unit_or_shape(&docs) {
                    wrong.push(format!("{file}:{line}: {name} -> {result}: {docs}"));
                }
            }
        }
    }
    assert!(wrong.is_empty() && count > 80, "{} of {count}: {wrong:#?}", wrong.len());
}

/// Columns of a comment, but for tables and for code in documentation.
const COLUMNS: usize = 120;

/// Comments are read beside code, and are as wide.
#[test]
fn comments_are_no_wider_than_code() {
    let mut wide = Vec::new();
    for folder in ["lagrange-runtime", "lagrange-macros", "examples", "tests", "benches"] {
        for (name, text) in prose(folder) {
            let mut code = false;
            for (i, line) in text.lines().enumerate() {
                let comment = line.trim_start();
                let words = comment.trim_start_matches(['/', '!']).trim_start();
                code ^= comment.starts_with("//") && words.starts_with("```");
                let is_prose =
                    comment.starts_with("//") && !code && !words.starts_with('|') && words.contains(' ');
                if is_prose && line.chars().count() > COLUMNS {
                    wide.push(format!("{folder}/{name}:{}", i + 1));
                }
            }
        }
    }
    assert!(wide.is_empty(), "{wide:#?}");
}

/// Documents are read in an editor, too, and their changes line by line. Tables, pictures and code keep their lines.
#[test]
fn documents_are_no_wider_than_code() {
    let mut wide = Vec::new();
    for (name, text) in documents() {
        let mut code = false;
        for (i, line) in text.lines().enumerate() {
            let words = line.trim_start();
            code ^= words.starts_with("```");
            let is_prose = !code && !words.starts_with(['|', '!', '<']);
            if is_prose && line.chars().count() > COLUMNS {
                wide.push(format!("{name}:{}", i + 1));
            }
        }
    }
    assert!(wide.is_empty(), "{wide:#?}");
}
