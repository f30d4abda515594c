//! The digits in `tests/golden/reference`.

use serde_json::Value;
use std::path::Path;

/// One file.
pub struct Reference(pub Value);

impl Reference {
    pub fn read(file: &str) -> Self {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden/reference");
        let text = std::fs::read_to_string(folder.join(format!("{file}.json"))).expect("the file");
        Reference(serde_json::from_str(&text).expect("JSON"))
    }

    /// A parameter.
    pub fn parameter(&self, name: &str) -> f64 {
        self.0["params"][name].as_f64().unwrap_or_else(|| panic!("no parameter {name}"))
    }

    /// A number of `special`, by a JSON pointer.
    pub fn special(&self, pointer: &str) -> f64 {
        self.0["special"].pointer(pointer).and_then(Value::as_f64).unwrap_or_else(|| panic!("no {pointer}"))
    }

    /// The linearizations of the file.
    pub fn small(&self) -> Vec<&Value> {
        match self.0["small_list"].as_array() {
            Some(list) => list.iter().collect(),
            None => vec![&self.0["small"]],
        }
    }
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|x| x.as_f64().expect("a number")).collect()
}

pub fn matrix(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().expect("rows").iter().map(numbers).collect()
}

/// Relative difference.
pub fn off(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()) }
}

/// Agreement to this many parts.
#[track_caller]
pub fn close(found: f64, expected: f64, relative: f64) {
    assert!(
        off(found, expected) <= relative,
        "{found:e} and not {expected:e}, off by {:e}",
        off(found, expected)
    );
}
