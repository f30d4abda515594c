//! Checks of the results of an example.

use comfy_table::{CellAlignment, Table, presets};

/// Conditions that have to hold. One that does not is an error, lest it be a line to overlook.
#[derive(Default)]
pub struct Checks {
    rows: Vec<[String; 3]>,
    failed: Vec<String>,
}

impl Checks {
    /// That a figure is no larger than allowed.
    pub fn at_most(&mut self, what: impl Into<String>, found: f64, allowed: f64) {
        let ordinary = |x: f64| x == 0.0 || (0.1..1e3).contains(&x);
        let written = if ordinary(found) { format!("{found:.1}") } else { format!("{found:.1e}") };
        let limit = if ordinary(allowed) { format!("{allowed}") } else { format!("{allowed:.0e}") };
        // NaN is no larger than anything, and not allowed.
        self.add(what.into(), written, limit, found <= allowed);
    }

    /// That this is true.
    pub fn holds(&mut self, what: impl Into<String>, is_so: bool) {
        self.add(what.into(), if is_so { "yes" } else { "no" }.into(), String::new(), is_so);
    }

    fn add(&mut self, what: String, found: String, allowed: String, passed: bool) {
        if !passed {
            self.failed.push(format!("{what}: {found}"));
        }
        self.rows.push([what, found, allowed]);
    }

    /// Prints them all.
    ///
    /// # Errors
    /// Those that failed.
    pub fn report(self) -> Result<(), String> {
        println!("{}", table(["check", "found", "allowed"], self.rows.into_iter()));
        if self.failed.is_empty() { Ok(()) } else { Err(self.failed.join("; ")) }
    }
}

/// A table whose columns but the first are numbers.
pub fn table<const C: usize>(header: [&str; C], rows: impl Iterator<Item = [String; C]>) -> Table {
    let mut table = Table::new();
    table.load_style(presets::NOTHING).set_header(header).add_rows(rows);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
