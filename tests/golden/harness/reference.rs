//! The files in `reference/`; its README describes the fields.

use super::State;
use serde_json::Value;
use std::path::Path;

/// One file: parameters and rows.
#[derive(Clone)]
pub struct Reference {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Their values, in the same order.
    pub values: Vec<f64>,
    /// The rows of `states`.
    pub states: Vec<Fields>,
    file: Value,
}

/// One object of named numbers.
#[derive(Clone)]
pub struct Fields(Value);

impl Reference {
    /// Reads `reference/<name>.json`. Numbers are parsed to the nearest double.
    pub fn file(name: &str) -> Value {
        // The example `chapter11` compiles this file in a package of its own.
        let package = Path::new(env!("CARGO_MANIFEST_DIR"));
        let workspace = package.ancestors().find(|folder| folder.join("Cargo.lock").exists());
        let path = workspace.unwrap_or(package).join(format!("tests/golden/reference/{name}.json"));
        let text =
            std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    }

    /// The file of a system.
    pub fn read(name: &str) -> Self {
        let file = Self::file(name);
        let (names, values) = file["params"]
            .as_object()
            .expect("params is an object")
            .iter()
            .map(|(name, value)| (name.clone(), number(value)))
            .unzip();
        let states = list(&file["states"]).iter().cloned().map(Fields).collect();
        Reference { names, values, states, file }
    }

    /// A parameter by its name.
    pub fn parameter(&self, name: &str) -> f64 {
        number(&self.file["params"][name])
    }

    /// Names of the coordinates.
    pub fn coordinates(&self) -> Vec<&str> {
        list(&self.file["coords"]).iter().map(text).collect()
    }

    /// The given functions of time, by name and as text.
    pub fn time_functions(&self) -> Vec<(&str, &str)> {
        let functions = self.file["time_functions"].as_object();
        functions.into_iter().flatten().map(|(name, function)| (&name[..], text(function))).collect()
    }

    /// The equations and integrals of one kind: where they stand in the source, and as text.
    pub fn formulas(&self, kind: &str) -> Vec<(&str, &str)> {
        let ofkind = list(&self.file["checks"]).iter().filter(|check| check["what"] == kind);
        ofkind.map(|check| (text(&check["ref"]), text(&check["expr"]))).collect()
    }

    /// The linearizations at equilibria.
    pub fn small(&self) -> Vec<Fields> {
        let one = self.file.get("small").into_iter();
        let many = self.file.get("small_list").into_iter().flat_map(list);
        one.chain(many).cloned().map(Fields).collect()
    }

    /// A result in `special`, as JSON.
    pub fn special(&self, name: &str) -> &Value {
        &self.file["special"][name]
    }

    /// The integrated motion: start, quarters, end.
    pub fn trajectory(&self) -> Vec<State> {
        let motion = &self.file["trajectory"];
        let start = state(&motion["q0"], &motion["qd0"], &motion["t0"]);
        let samples = list(&motion["samples"]).iter().map(|at| state(&at["q"], &at["qd"], &at["t"]));
        std::iter::once(start).chain(samples).collect()
    }

    /// The end of the motion, `q` and `q̇`, as texts of 30 digits, and when that is.
    #[cfg(test)]
    pub fn end(&self) -> (Vec<&str>, Vec<&str>, f64) {
        let motion = &self.file["trajectory"];
        let texts = |field: &str| list(&motion[field]).iter().map(text).collect();
        (texts("q_end_str"), texts("qd_end_str"), number(&motion["t_end"]))
    }
}

impl Fields {
    /// Returns whether there is such a field.
    pub fn has(&self, field: &str) -> bool {
        !self.0[field].is_null()
    }

    /// One number.
    pub fn number(&self, field: &str) -> f64 {
        number(&self.0[field])
    }

    /// A list of numbers; NaN for what is left out.
    pub fn numbers(&self, field: &str) -> Vec<f64> {
        numbers(&self.0[field])
    }

    /// A list of lists of numbers.
    pub fn lists(&self, field: &str) -> Vec<Vec<f64>> {
        list(&self.0[field]).iter().map(numbers).collect()
    }

    /// A matrix by columns.
    pub fn matrix(&self, field: &str) -> Vec<f64> {
        let rows = self.lists(field);
        (0..rows.len()).flat_map(|column| rows.iter().map(move |row| row[column])).collect()
    }

    /// `t`, `q`, `qd`.
    pub fn state(&self) -> State {
        state(&self.0["q"], &self.0["qd"], &self.0["t"])
    }
}

/// A number of the file, given as such or as the `value` of an object.
pub fn number(value: &Value) -> f64 {
    let value = value.get("value").unwrap_or(value);
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

/// A list of the file.
pub fn list(value: &Value) -> &[Value] {
    value.as_array().unwrap_or_else(|| panic!("{value} is not a list"))
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_else(|| panic!("{value} is not a text"))
}

fn numbers(value: &Value) -> Vec<f64> {
    list(value).iter().map(|entry| if entry.is_null() { f64::NAN } else { number(entry) }).collect()
}

fn state(q: &Value, qd: &Value, t: &Value) -> State {
    State { q: numbers(q), qd: numbers(qd), t: number(t) }
}
