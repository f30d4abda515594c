//! Speed against accuracy: the methods that one would choose among, on the four best known motions.
//!
//! ```text
//! cargo run --release --example work_precision
//! cargo run --release --example work_precision -- --motion pendulum,kepler --method verner,taylor --tolerance 1e-6,1e-9
//! cargo run --release --example work_precision -- --all
//! ```
//!
//! `--long` follows energy and momenta over 10⁵ periods, and `--all` measures the atlas: ten motions by every method
//! that fits. `--help` lists what there is.
//!
//! Each method runs over a range of step sizes or tolerances until its error no longer falls. The error is that of
//! the final state, against a reference that no method here had a part in: closed forms, or digits computed
//! elsewhere. The results are under `target/charts`: for each system a chart of error against time, one of error
//! against evaluations of the right-hand side and, where something is conserved, of its error over many periods at
//! equal cost (SVG, PNG, CSV); one CSV file with all numbers; on the screen the fastest method for each digit of
//! accuracy; and all of it on one page, `work-precision.html`, from the first motion on.
//!
//! | file | concern |
//! |---|---|
//! | `main.rs`, `known.rs`, `dozen.rs` | the four best known motions and the dozen methods |
//! | `atlas.rs`, `further.rs`, `every.rs` | the example `atlas`: ten motions and every method |
//! | `options.rs`, `book.rs` | the command line; the order of what is done |
//! | `problems.rs`, `digits.rs` | a motion with a known end; what an error is |
//! | `methods.rs` | methods over ranges of steps and tolerances |
//! | `measure.rs` | runs and times |
//! | `long.rs` | runs over many periods |
//! | `report.rs`, `page.rs` | charts and CSV; the page |

mod book;
mod digits;
mod dozen;
mod known;
mod long;
mod measure;
mod methods;
mod options;
mod page;
mod problems;
mod report;
#[path = "../support/mod.rs"]
mod support;

use book::{Motion, motion};
#[allow(unused_imports)]
use dozen::Unmarked;
use options::Options;
use std::error::Error;
use std::process::{Command, exit};

/// A motion with its methods. A macro, since the methods are chosen where the system is known by name.
macro_rules! dozen {
    ($problem:expr) => {
        motion($problem, |problem| [problem.general(), problem.separable()].into_iter().flatten().collect())
    };
}

fn main() -> Result<(), Box<dyn Error>> {
    let motions: [Box<dyn Motion>; 4] = [
        dozen!(known::pendulum()),
        dozen!(known::kepler()?),
        dozen!(known::double_pendulum()?),
        dozen!(known::top()?),
    ];
    let options = Options::of(&motions.each_ref().map(|motion| motion.known()), true);
    if options.all { atlas() } else { book::write(&motions, &options) }
}

/// Builds the example `atlas` and runs it with the options of this call.
fn atlas() -> Result<(), Box<dyn Error>> {
    println!("The atlas is a program of its own: cargo builds it first, which takes minutes.");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let run = ["run", "--release", "--example", "atlas", "--features", "atlas", "--manifest-path"];
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");
    let status =
        Command::new(cargo).args(run).args([manifest, "--"]).args(std::env::args_os().skip(1)).status()?;
    if status.success() { Ok(()) } else { exit(status.code().unwrap_or(1)) }
}
