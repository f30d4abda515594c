//! The book of all motions: measures each, draws it, and writes the page anew.

use crate::long::drifts;
use crate::measure::{Record, WRONG, measure};
use crate::methods::{Parameter, Sweep};
use crate::options::{Known, Options};
use crate::page::{self, Chapter, fewest, shown};
use crate::problems::Problem;
use crate::{report, support};
use comfy_table::{CellAlignment, Table, presets};
use lagrange_runtime::testing::work_precision::Decade;
use std::error::Error;
use std::io::{self, Write as _, stdout};
use std::path::Path;

/// A motion with the methods that fit it, whatever its system.
pub trait Motion {
    /// Its name on the command line, and the methods that fit it.
    fn known(&self) -> Known;

    /// Measures the chosen methods, writes the charts and prints a table.
    fn measure(&self, options: &Options, folder: &Path) -> Result<(Chapter, Vec<Record>), Box<dyn Error>>;
}

/// The methods that fit a system.
type Fitting<Sys, const N: usize> = fn(&Problem<Sys, N>) -> Vec<Sweep<'_, N>>;

struct Fitted<Sys, const N: usize>(Problem<Sys, N>, Fitting<Sys, N>);

/// A motion with the methods that fit it.
pub fn motion<Sys: 'static, const N: usize>(
    problem: Problem<Sys, N>,
    methods: Fitting<Sys, N>,
) -> Box<dyn Motion> {
    Box::new(Fitted(problem, methods))
}

impl<Sys, const N: usize> Motion for Fitted<Sys, N> {
    fn known(&self) -> Known {
        let Fitted(problem, fitting) = self;
        (problem.stem, fitting(problem).iter().map(|sweep| sweep.method).collect())
    }

    fn measure(&self, options: &Options, folder: &Path) -> Result<(Chapter, Vec<Record>), Box<dyn Error>> {
        let Fitted(problem, fitting) = self;
        let mut sweeps = fitting(problem);
        let fit = sweeps.len();
        sweeps.retain(|sweep| options.wants_method(sweep.method));
        let adaptive = sweeps.iter_mut().filter(|sweep| sweep.parameter == Parameter::Tolerance);
        if !options.tolerances.is_empty() {
            adaptive.for_each(|sweep| sweep.values.clone_from(&options.tolerances));
        }
        let records = measure(problem, &sweeps);
        let winners = report::winners(&records);
        let mut out = stdout();
        writeln!(out, "{}: {}", problem.name, problem.motion)?;
        writeln!(out, "Reference: {}", problem.reference)?;
        let mut pictures = report::charts(problem, &records, folder)?;
        match pictures.is_empty() {
            true => {
                writeln!(out, "No run ended within an error of {WRONG}: `work-precision.csv` says why.\n")?
            }
            false => writeln!(out, "{}\n", table(&winners))?,
        }
        if let Some(long) = &problem.long {
            let drifts = drifts(problem, long, &sweeps, options.decades(long.decades));
            let csv = folder.join(format!("long-run-{}.csv", problem.stem));
            support::write(&csv, report::long_csv(long, &drifts))?;
            pictures.extend(report::long_charts(problem, long, &drifts, folder)?);
        }
        let chapter = Chapter {
            name: problem.name,
            stem: problem.stem,
            motion: problem.motion.clone(),
            reference: problem.reference,
            methods: sweeps.len(),
            fit,
            tolerances: options.tolerances.clone(),
            winners,
            pictures,
        };
        Ok((chapter, records))
    }
}

/// Measures the chosen motions. The page is written after each, so that there is something to look at from the first
/// on. Where nobody reads any more (`| head`), it ends.
pub fn write(motions: &[Box<dyn Motion>], options: &Options) -> Result<(), Box<dyn Error>> {
    let is_unread = |error: &(dyn Error + 'static)| {
        error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
    };
    match written(motions, options) {
        Err(error) if is_unread(&*error) => Ok(()),
        result => result,
    }
}

fn written(motions: &[Box<dyn Motion>], options: &Options) -> Result<(), Box<dyn Error>> {
    let folder = support::charts()?;
    let (page, csv) = (folder.join("work-precision.html"), folder.join("work-precision.csv"));
    let (mut chapters, mut records) = (Vec::new(), Vec::new());
    for motion in motions.iter().filter(|motion| options.wants_motion(motion.known().0)) {
        let (chapter, measured) = motion.measure(options, &folder)?;
        chapters.push(chapter);
        records.extend(measured);
        support::write(&csv, report::csv(&records))?;
        support::write(&page, page::page(&chapters))?;
    }
    let mut out = stdout();
    let equal = records.iter().any(|record| record.parameter == Parameter::Step);
    if !options.tolerances.is_empty() && equal {
        writeln!(out, "Methods of equal steps have no tolerance: each was tried over its range of steps.")?;
    }
    writeln!(out, "All of it on one page: {}", page.display())?;
    writeln!(out, "Its charts (.svg, .png, .csv) and all numbers (work-precision.csv) are beside it.")?;
    Ok(())
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
