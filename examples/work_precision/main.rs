//! Speed against accuracy: an atlas of every method that fits, on ten motions known to the last digit.
//!
//! ```text
//! cargo run --release --example work_precision
//! cargo run --release --example work_precision -- pendulum kepler
//! cargo run --release --example work_precision -- --long
//! ```
//!
//! Names choose systems, `--long` follows all that conserve something over 10⁵ periods (otherwise the pendulum
//! and Kepler's problem, and the others over 10³).
//!
//! Each method runs over a range of step sizes or tolerances until its error no longer falls. The error is that of the
//! final state, against a reference that no method here had a part in: closed forms, or digits computed elsewhere. (Taylor series in
//! double-double have to end there too, or the program fails; by themselves they would do for all methods but the Taylor series in
//! `f64`, whose recurrences they share.) What comes out, under `target/charts`: for each system a chart of error against time, one of
//! error against evaluations of the right-hand side and, where something is conserved, of its error over many periods at equal cost (SVG,
//! PNG, CSV); one CSV file with all numbers; on the screen the fastest method for each digit of accuracy; and all of it on one page,
//! `work-precision.html`.
//!
//! | file | concern |
//! |---|---|
//! | `systems.rs` | the systems, as their energies |
//! | `problems.rs`, `digits.rs` | where each starts and where exactly it ends; what an error is |
//! | `methods.rs` | which methods fit a system (the compiler decides), with which steps and tolerances |
//! | `measure.rs` | runs and times |
//! | `long.rs` | runs over many periods |
//! | `report.rs`, `page.rs` | charts and CSV; the page |

mod digits;
mod long;
mod measure;
mod methods;
mod page;
mod problems;
mod report;
#[path = "../support/mod.rs"]
mod support;
mod systems;

use comfy_table::{CellAlignment, Table, presets};
use lagrange_runtime::work_precision::Decade;
use measure::{Record, measure};
use methods::{Sweep, every_method};
use page::{Chapter, fewest, shown};
use problems::Problem;
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let mut atlas = Atlas::new()?;
    macro_rules! add {
        ($($problem:expr),* $(,)?) => {$(
            let problem = $problem;
            if atlas.wants(problem.stem) {
                atlas.add(&problem, &every_method!(problem))?;
            }
        )*};
    }
    add![
        problems::pendulum()?,
        problems::kepler()?,
        problems::eccentric()?,
        problems::polar_kepler()?,
        problems::henon_heiles()?,
        problems::double_pendulum()?,
        problems::top()?,
        problems::spring_pendulum()?,
        problems::driven_pendulum()?,
        problems::chain()?,
    ];
    atlas.finish()
}

/// Decades of periods with `--long`.
const LONGEST: u32 = 5;

/// The chapters so far.
struct Atlas {
    folder: PathBuf,
    /// Chosen on the command line; none: all.
    names: Vec<String>,
    /// Names that there are.
    known: Vec<&'static str>,
    longest: bool,
    records: Vec<Record>,
    chapters: Vec<Chapter>,
}

impl Atlas {
    fn new() -> Result<Self, Box<dyn Error>> {
        let (options, names): (Vec<_>, Vec<_>) =
            std::env::args().skip(1).partition(|word| word.starts_with('-'));
        if let Some(option) = options.iter().find(|option| *option != "--long") {
            return Err(format!("unknown option {option}; there is --long").into());
        }
        let (folder, longest) = (support::charts()?, !options.is_empty());
        Ok(Atlas { folder, names, known: Vec::new(), longest, records: Vec::new(), chapters: Vec::new() })
    }

    fn wants(&mut self, stem: &'static str) -> bool {
        self.known.push(stem);
        self.names.is_empty() || self.names.iter().any(|name| name == stem)
    }

    /// Measures one system, writes its charts and prints its table.
    fn add<Sys, const N: usize>(
        &mut self,
        problem: &Problem<Sys, N>,
        sweeps: &[Sweep<'_, N>],
    ) -> Result<(), Box<dyn Error>> {
        let records = measure(problem, sweeps);
        let winners = report::winners(&records);
        println!("{}: {}", problem.name, problem.motion);
        println!("Reference: {}", problem.reference);
        println!("{}\n", table(&winners));

        let mut pictures = Vec::from(report::charts(problem, &records, &self.folder)?);
        if let Some(long) = &problem.long {
            let decades = if self.longest { LONGEST } else { long.decades };
            let drifts = long::drifts(problem, long, sweeps, decades);
            let csv = self.folder.join(format!("long-run-{}.csv", problem.stem));
            std::fs::write(csv, report::long_csv(long, &drifts))?;
            pictures.extend(report::long_charts(problem, long, &drifts, &self.folder)?);
        }
        self.chapters.push(Chapter {
            name: problem.name,
            stem: problem.stem,
            motion: problem.motion.clone(),
            reference: problem.reference,
            methods: sweeps.len(),
            winners,
            pictures,
        });
        self.records.extend(records);
        Ok(())
    }

    fn finish(self) -> Result<(), Box<dyn Error>> {
        if let Some(name) = self.names.iter().find(|name| !self.known.contains(&name.as_str())) {
            return Err(format!("no system {name}; there are {}", self.known.join(", ")).into());
        }
        std::fs::write(self.folder.join("work-precision.csv"), report::csv(&self.records))?;
        let page = self.folder.join("work-precision.html");
        std::fs::write(&page, page::page(&self.chapters))?;
        println!("The atlas: {}", page.display());
        println!("Its charts (.svg, .png, .csv) and all numbers (work-precision.csv) are beside it.");
        Ok(())
    }
}

/// For each digit of accuracy the methods in order of time, and the one with the fewest evaluations.
fn table(winners: &[Decade]) -> Table {
    let mut table = Table::new();
    table.load_style(presets::ASCII_MARKDOWN);
    table.set_header(["error ≤", "fastest", "time", "second", "third", "fewest evaluations"]);
    for decade in shown(winners) {
        let first = &decade.ranking[0];
        let behind = |place: usize| {
            decade.ranking.get(place).map_or_else(String::new, |next| {
                format!("{}, {:.1}×", next.method, next.seconds / first.seconds)
            })
        };
        let fewest = fewest(decade);
        table.add_row([
            format!("1e-{}", decade.digits),
            first.method.clone(),
            format!("{:.3} ms", 1e3 * first.seconds),
            behind(1),
            behind(2),
            format!("{}, {:.0}", fewest.method, fewest.evaluations),
        ]);
    }
    if let Some(times) = table.column_mut(2) {
        times.set_cell_alignment(CellAlignment::Right);
    }
    table
}
