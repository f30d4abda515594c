//! Everything as one page that needs nothing else: tables and pictures inside, no network.

use crate::report::Picture;
use lagrange_runtime::testing::work_precision::{Decade, Standing};
use std::fmt::Write as _;

/// Digits of accuracy in the tables.
const DIGITS: std::ops::RangeInclusive<u32> = 2..=14;

/// Text and charts about one system.
pub struct Chapter {
    pub name: &'static str,
    pub stem: &'static str,
    pub motion: String,
    pub reference: &'static str,
    /// Numbers of the methods that were tried, and of those that fit.
    pub methods: usize,
    pub fit: usize,
    /// Tolerances of the adaptive ones, unless it is their range.
    pub tolerances: Vec<f64>,
    pub winners: Vec<Decade>,
    pub pictures: Vec<Picture>,
}

/// The whole page.
pub fn page(chapters: &[Chapter]) -> String {
    let contents: String = chapters
        .iter()
        .map(|chapter| format!("<li><a href=\"#{}\">{}</a></li>\n", chapter.stem, escaped(chapter.name)))
        .collect();
    let body: String = chapters.iter().map(section).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>Work and precision</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<h1>Work and precision</h1>\n{INTRODUCTION}</header>\n\
         <nav><h2>Systems</h2><ol>\n{contents}</ol></nav>\n\
         <section id=\"winners\"><h2>The fastest method for each digit</h2>\n{}</section>\n{body}</body>\n</html>\n",
        summary(chapters)
    )
}

const INTRODUCTION: &str = "<p>Each method runs over a range of step sizes or tolerances, unless these are chosen, until its error no longer falls. \
The error is that of the final state, the largest over all coordinates and velocities, each in units of its largest magnitude \
along the motion, against a reference that no method here had a part in, not even as Taylor series in more digits; \
those, in double-double arithmetic, end in the same double-precision numbers. Costs between two runs are interpolated on \
logarithmic axes. Below and left is better. Where there are many methods, a panel has one family in colour, and all other \
methods behind it in grey.</p>\n<p>Which methods fit a system was decided by the compiler: splitting and Nyström methods need \
T(q̇) + V(q, t), projection needs a conserved energy, modal propagation a linear system with constant coefficients.</p>\n";

const STYLE: &str = "
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #222; background: #fff; max-width: 1400px; margin: 0 auto; padding: 2rem 1.5rem 6rem; }
h1 { font-weight: 300; font-size: 2.6rem; margin: 0 0 .5rem; }
h2 { font-weight: 400; font-size: 1.7rem; margin: 3.5rem 0 .5rem; }
h3 { font-weight: 500; font-size: 1.1rem; margin: 2rem 0 .5rem; }
p, dl { max-width: 46rem; }
nav ol { columns: 3 16rem; padding-left: 1.3rem; }
nav h2 { font-size: 1.1rem; margin: 1.5rem 0 0; }
a { color: #0072b2; text-decoration: none; }
a:hover { text-decoration: underline; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: .2rem 1rem; margin: .5rem 0 1rem; }
dt { color: #777; }
dd { margin: 0; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .85rem; font-variant-numeric: tabular-nums; }
th, td { text-align: left; vertical-align: top; padding: .3rem .7rem .3rem 0; border-bottom: 1px solid #e4e4e4; white-space: nowrap; }
th { font-weight: 500; color: #555; }
table.summary { font-size: .8rem; }
table.summary td { white-space: normal; min-width: 5rem; line-height: 1.25; }
td.number { text-align: right; }
small { color: #777; }
figure { margin: 0; }
figure > svg { width: 100%; height: auto; }
svg text { font-family: 'DejaVu Sans', Verdana, sans-serif; }
summary { cursor: pointer; color: #0072b2; }
";

fn section(chapter: &Chapter) -> String {
    let pictures: String = chapter
        .pictures
        .iter()
        .map(|Picture { heading, svg }| format!("<h3>{}</h3>\n<figure>{svg}</figure>\n", escaped(heading)))
        .collect();
    let tolerances = match chapter.tolerances.as_slice() {
        [] => String::new(),
        chosen => {
            let chosen: Vec<String> = chosen.iter().map(|x| format!("{x:e}")).collect();
            format!("; adaptive ones with the tolerances {}", chosen.join(", "))
        }
    };
    format!(
        "<section id=\"{}\">\n<h2>{}</h2>\n<dl><dt>Motion</dt><dd>{}</dd><dt>Reference</dt><dd>{}</dd>\
         <dt>Methods</dt><dd>{} of {} that fit{tolerances}</dd></dl>\n<h3>Winners</h3>\n{}{pictures}</section>\n",
        chapter.stem,
        escaped(chapter.name),
        escaped(&chapter.motion),
        escaped(chapter.reference),
        chapter.methods,
        chapter.fit,
        ranking(&chapter.winners)
    )
}

/// For each digit the fastest three methods of one system, and the one with the fewest evaluations.
fn ranking(winners: &[Decade]) -> String {
    let mut rows = String::new();
    for decade in shown(winners) {
        let first = &decade.ranking[0];
        let behind = |place: usize| {
            decade.ranking.get(place).map_or_else(String::new, |next| {
                format!("{} <small>{:.2}×</small>", escaped(&next.method), next.seconds / first.seconds)
            })
        };
        let fewest = fewest(decade);
        let _ = writeln!(
            rows,
            "<tr><td>{}</td><td><b>{}</b></td><td class=\"number\">{}</td><td>{}</td><td>{}</td>\
             <td>{} <small>{:.0}</small></td></tr>",
            power(decade.digits),
            escaped(&first.method),
            duration(first.seconds),
            behind(1),
            behind(2),
            escaped(&fewest.method),
            fewest.evaluations
        );
    }
    format!(
        "<div class=\"wide\"><table><tr><th>error ≤</th><th>fastest</th><th>time</th><th>second</th><th>third</th>\
         <th>fewest evaluations</th></tr>\n{rows}</table></div>\n"
    )
}

/// The winners of all systems.
fn summary(chapters: &[Chapter]) -> String {
    let head: String = DIGITS.map(|digits| format!("<th>{}</th>", power(digits))).collect();
    let mut rows = String::new();
    for chapter in chapters {
        let cell = |digits| {
            let decade = chapter.winners.iter().find(|decade| decade.digits == digits);
            let name = decade.map_or("–", |decade| &decade.ranking[0].method);
            format!("<td>{}</td>", escaped(name))
        };
        let cells: String = DIGITS.map(cell).collect();
        let (stem, name) = (chapter.stem, escaped(chapter.name));
        let _ = writeln!(rows, "<tr><th><a href=\"#{stem}\">{name}</a></th>{cells}</tr>");
    }
    format!(
        "<div class=\"wide\"><table class=\"summary\"><tr><th>error ≤</th>{head}</tr>\n{rows}</table></div>\n"
    )
}

/// The decades of the tables.
pub fn shown(winners: &[Decade]) -> impl Iterator<Item = &Decade> {
    winners.iter().filter(|decade| DIGITS.contains(&decade.digits))
}

/// The method with the fewest evaluations.
pub fn fewest(decade: &Decade) -> &Standing {
    let fewer = |a: &&Standing, b: &&Standing| a.evaluations.total_cmp(&b.evaluations);
    decade.ranking.iter().min_by(fewer).unwrap_or(&decade.ranking[0])
}

fn power(digits: u32) -> String {
    format!("10<sup>−{digits}</sup>")
}

fn duration(seconds: f64) -> String {
    if seconds < 1e-3 { format!("{:.1} µs", 1e6 * seconds) } else { format!("{:.2} ms", 1e3 * seconds) }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
