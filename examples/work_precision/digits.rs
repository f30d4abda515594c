//! Files of reference digits.

use lagrange_runtime::State;
use serde_json::Value;
use std::error::Error;

/// A file of reference digits.
pub struct Digits(Value);

impl Digits {
    pub fn of(json: &str) -> Result<Self, Box<dyn Error>> {
        Ok(Digits(serde_json::from_str(json)?))
    }

    pub fn parameter(&self, name: &str) -> Result<f64, Box<dyn Error>> {
        self.0["params"][name].as_f64().ok_or_else(|| format!("no parameter {name}").into())
    }

    /// The start of its trajectory, and the end from 30 digits.
    pub fn ends<const N: usize>(&self) -> Result<[State<f64, N>; 2], Box<dyn Error>> {
        let motion = &self.0["trajectory"];
        let number = |value: &Value| match value {
            Value::String(digits) => digits.parse().ok(),
            other => other.as_f64(),
        };
        let state = |t: &str, q: &str, qd: &str| {
            let vector = |field: &str| -> Option<[f64; N]> {
                let entries: Option<Vec<f64>> = motion[field].as_array()?.iter().map(number).collect();
                entries?.try_into().ok()
            };
            Some(State::new(number(&motion[t])?, vector(q)?, vector(qd)?))
        };
        let start = state("t0", "q0", "qd0").ok_or("no start in the reference")?;
        let end = state("t_end", "q_end_str", "qd_end_str").ok_or("no end in the reference")?;
        Ok([start, end])
    }
}
