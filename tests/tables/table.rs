//! Tables of docs/lab/reliability.md that tests print: each holds what was seen when it was written anew by
//! `LAGRANGE_TABLES=write`.

use std::fmt::Write;
use std::path::Path;

/// Outcome where a hypothesis is violated alone, or the reason why there is no such hypothesis. A result that is not
/// right says "wrong".
pub enum Cell {
    Seen(String),
    None(&'static str),
}

/// Hypotheses, one a column, each of which is violated alone.
const VIOLATIONS: [&str; 16] = [
    "time",
    "negative damping",
    "circulatory forces",
    "gyroscopic forces",
    "kink or jump",
    "constraints",
    "degenerate M",
    "other degree in q̇",
    "forcing",
    "symmetry O(2)",
    "imperfection",
    "stiffness 1e12",
    "long steps",
    "late onset",
    "`f32`",
    "`DoubleDouble`",
];

/// A table of functions, one a row, against violations of hypotheses.
pub struct Table {
    rows: Vec<(&'static str, [Cell; VIOLATIONS.len()])>,
}

impl Table {
    pub fn new() -> Self {
        Table { rows: vec![] }
    }

    pub fn row(&mut self, name: &'static str, cells: [Cell; VIOLATIONS.len()]) {
        self.rows.push((name, cells));
    }

    /// In Markdown; reasons are letters, which are explained below.
    fn render(&self) -> String {
        let mut reasons: Vec<&str> = vec![];
        let mut text =
            format!("| | {} |\n|---{}|\n", VIOLATIONS.join(" | "), "|---".repeat(VIOLATIONS.len()));
        for (name, cells) in &self.rows {
            let cells = cells.iter().map(|cell| match cell {
                Cell::Seen(seen) => seen.clone(),
                Cell::None(reason) => {
                    let known = reasons.iter().position(|known| known == reason);
                    let at = known.unwrap_or_else(|| {
                        reasons.push(reason);
                        reasons.len() - 1
                    });
                    format!("– {}", (b'a' + at as u8) as char)
                }
            });
            let cells: Vec<String> = cells.collect();
            assert!(cells.iter().all(|cell| !cell.is_empty() && !cell.contains('?')), "{name}");
            writeln!(text, "| {name} | {} |", cells.join(" | ")).unwrap();
        }
        for (at, reason) in reasons.iter().enumerate() {
            write!(text, "\n– {}: {reason}.", (b'a' + at as u8) as char).unwrap();
            text.push_str(if at + 1 < reasons.len() { "\\" } else { "\n" });
        }
        text
    }

    /// Compares with the table of this name in docs/lab/reliability.md, or writes it there.
    pub fn check(&self, name: &str) {
        let mut wrong = vec![];
        for (row, cells) in &self.rows {
            for (column, cell) in VIOLATIONS.iter().zip(cells) {
                if let Cell::Seen(text) = cell
                    && text.contains("wrong")
                {
                    wrong.push(format!("{row}, {column}: {text}"));
                }
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        let from = Path::new(env!("CARGO_MANIFEST_DIR"));
        let mut pages = from.ancestors().map(|folder| folder.join("docs/lab/reliability.md"));
        let path = &pages.find(|page| page.exists()).expect("the page");
        let page = std::fs::read_to_string(path).unwrap();
        let mark = format!("<!-- {name}: printed by its test, LAGRANGE_TABLES=write -->\n");
        let begin = page.find(&mark).unwrap_or_else(|| panic!("no table {name}")) + mark.len();
        let end = begin + page[begin..].find("\n<!-- end -->").expect("the end of the table");
        let printed = format!("\n{}", self.render());
        if std::env::var("LAGRANGE_TABLES").is_ok_and(|what| what == "write") {
            std::fs::write(path, format!("{}{printed}{}", &page[..begin], &page[end..])).unwrap();
        } else {
            assert!(
                page[begin..end] == printed,
                "docs/lab/reliability.md has another table {name}; printed:\n{printed}"
            );
        }
    }
}
