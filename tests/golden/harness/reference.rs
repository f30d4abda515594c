//! The files in `reference/`; its README describes the fields.

use super::State;
use nalgebra::SVector;
use serde_json::Value;

/// One file: parameters and rows.
pub struct Reference {
    /// Names of the parameters.
    pub names: Vec<String>,
    /// Their values, in the same order.
    pub values: Vec<f64>,
    /// The rows of `states`.
    pub rows: Vec<Row>,
    file: Value,
}

/// One row of `states`.
pub struct Row(Value);

impl Reference {
    /// Reads `reference/<name>.json`. Numbers are parsed to the nearest double.
    pub fn read(name: &str) -> Self {
        let path = format!("{}/tests/golden/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{path}: {error}"));
        let file: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{path}: {error}"));
        let (names, values) = file["params"]
            .as_object()
            .expect("params is an object")
            .iter()
            .map(|(name, value)| (name.clone(), number(value)))
            .unzip();
        let rows = file["states"].as_array().expect("states is a list").iter().cloned().map(Row).collect();
        Reference { names, values, rows, file }
    }

    /// A parameter by its name.
    pub fn parameter(&self, name: &str) -> f64 {
        number(&self.file["params"][name])
    }

    /// A result in `special`, as JSON.
    pub fn special(&self, name: &str) -> &Value {
        &self.file["special"][name]
    }

    /// The integrated motion: start, quarters, end.
    pub fn trajectory<const N: usize>(&self) -> Vec<State<N>> {
        let motion = &self.file["trajectory"];
        let start = state(&motion["q0"], &motion["qd0"], &motion["t0"]);
        let samples = motion["samples"].as_array().expect("samples is a list");
        std::iter::once(start).chain(samples.iter().map(|at| state(&at["q"], &at["qd"], &at["t"]))).collect()
    }
}

impl Row {
    /// One number.
    pub fn number(&self, field: &str) -> f64 {
        number(&self.0[field])
    }

    /// A list of numbers.
    pub fn numbers(&self, field: &str) -> Vec<f64> {
        numbers(&self.0[field])
    }

    /// A matrix by columns.
    pub fn matrix(&self, field: &str) -> Vec<f64> {
        let rows: Vec<_> = self.0[field].as_array().expect("a list of rows").iter().map(numbers).collect();
        (0..rows.len()).flat_map(|column| rows.iter().map(move |row| row[column])).collect()
    }

    /// `t`, `q`, `qd`.
    pub fn state<const N: usize>(&self) -> State<N> {
        state(&self.0["q"], &self.0["qd"], &self.0["t"])
    }
}

/// A number of the file.
pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is not a number"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap_or_else(|| panic!("{value} is not a list")).iter().map(number).collect()
}

fn state<const N: usize>(q: &Value, qd: &Value, t: &Value) -> State<N> {
    let vector = |value| {
        let entries = numbers(value);
        assert_eq!(entries.len(), N, "number of coordinates");
        SVector::from_vec(entries)
    };
    State { q: vector(q), qd: vector(qd), t: number(t) }
}
