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

    /// Tolerances of the adaptive methods, instead of 1, 1e-1, … 1e-15.
    #[arg(long = "tolerance", value_name = "X", value_delimiter = ',', value_parser = positive)]
    pub tolerances: Vec<f64>,

    /// Follow energy and momenta over 10⁵ periods.
    #[arg(long)]
    long: bool,
}

/// Decades of periods with `--long`.
const LONG: u32 = 5;

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
        let mut command = Options::command().after_help(format!("Motions: {motions}\n\nMethods: {methods}"));
        let mut options = Options::from_arg_matches(&command.try_get_matches_from_mut(call)?)?;
        // From coarse to fine, as sweeps are.
        options.tolerances.sort_by(|a, b| b.total_cmp(a));
        if options.all && more {
            return Ok(options);
        }
        let hint = if more { "\n\n`--all` has more" } else { "" };
        let mut unknown = |what: &str, name: &str, there_are: &str| {
            command
                .error(ErrorKind::InvalidValue, format!("no {what} `{name}`; there are: {there_are}{hint}"))
        };
        let is_motion = |name: &&String| known.iter().any(|(motion, _)| motion == name);
        if let Some(name) = options.motions.iter().find(|name| !is_motion(name)) {
            return Err(unknown("motion", name, &motions));
        }
        let chosen = known.iter().filter(|(motion, _)| options.wants_motion(motion));
        let fitting: Vec<&str> = chosen.flat_map(|(_, methods)| methods.iter().copied()).collect();
        let is_method = |name: &&String| fitting.iter().any(|method| named(method, name));
        match options.methods.iter().find(|name| !is_method(name)) {
            Some(name) => Err(unknown("method", name, &listed(fitting.into_iter()))),
            None => Ok(options),
        }
    }

    pub fn wants_motion(&self, stem: &str) -> bool {
        self.motions.is_empty() || self.motions.iter().any(|name| name == stem)
    }

    pub fn wants_method(&self, method: &str) -> bool {
        self.methods.is_empty() || self.methods.iter().any(|name| named(method, name))
    }

    /// Decades of periods in long runs of a motion that has so many by itself.
    pub fn decades(&self, own: u32) -> u32 {
        if self.long { LONG } else { own }
    }
}

/// Is this the name of a method, or a part of it? Letters and digits count.
fn named(method: &str, name: &str) -> bool {
    let plain = |text: &str| -> String {
        let text = text.to_lowercase().replace('ö', "o");
        text.chars().filter(char::is_ascii_alphanumeric).collect()
    };
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

fn positive(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(tolerance) if tolerance > 0.0 && f64::is_finite(tolerance) => Ok(tolerance),
        _ => Err("a tolerance is a positive number".into()),
    }
}
