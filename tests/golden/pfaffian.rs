//! Differential constraints A dx + B dy + C dz = 0: whether they can be integrated. Exercise 11.1 and Problem 11.1.
//!
//! Erratum of the source: the form of Exercise 11.1 is called holonomic, but (P11.1) vanishes on one surface alone,
//! which is its only integral surface; from a start off that surface the constraint is nonholonomic.

use super::harness::{Reference, Row, evaluate, list, number};
use lagrange_runtime::Dual;
use serde_json::Value;

/// The name of the file, which is also that of the row of the exercise.
const FILE: &str = "exer-11.1-pfaffian";

/// A form, by the texts of A, B and C.
struct Form<'a>([&'a str; 3]);

/// A number with its three partial derivatives.
struct Gradient {
    value: f64,
    by: [f64; 3],
}

impl Gradient {
    fn of(text: &str, point: [f64; 3]) -> Self {
        let along = |axis: usize| {
            let lookup = |name: &str, _| {
                let k = ["x", "y", "z"].iter().position(|known| *known == name).expect("x, y or z");
                if k == axis { Dual::variable(point[k]) } else { Dual::constant(point[k]) }
            };
            evaluate(text, &lookup)
        };
        Gradient { value: along(0).value, by: [0, 1, 2].map(|axis| along(axis).slope) }
    }
}

impl<'a> Form<'a> {
    fn new(case: &'a Value) -> Self {
        Form(["A", "B", "C"].map(|name| case[name].as_str().expect("a text")))
    }

    /// The terms of (P11.1): A (B_z − C_y) + B (C_x − A_z) + C (A_y − B_x).
    fn terms(&self, point: [f64; 3]) -> [f64; 6] {
        let [a, b, c] = self.0.map(|text| Gradient::of(text, point));
        [
            a.value * b.by[2],
            -a.value * c.by[1],
            b.value * c.by[0],
            -b.value * a.by[2],
            c.value * a.by[1],
            -c.value * b.by[0],
        ]
    }

    /// The terms of (11.6) for dz = C₁ dx + C₂ dy, times C²: ∂C₁/∂y + C₂ ∂C₁/∂z − ∂C₂/∂x − C₁ ∂C₂/∂z.
    fn terms_11_6(&self, point: [f64; 3]) -> [f64; 4] {
        let [a, b, c] = self.0;
        let [first, second] = [a, b].map(|numerator| Gradient::of(&format!("-({numerator})/({c})"), point));
        let square = Gradient::of(c, point).value.powi(2);
        [first.by[1], second.value * first.by[2], -second.by[0], -first.value * second.by[2]]
            .map(|term| term * square)
    }
}

pub fn rows() -> Vec<Row> {
    vec![exercise(), symmetric_form()]
}

fn point(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|k| number(&list(value)[k]))
}

/// On z = e^{2x} + sin² y − e^x sin y the test is passed, and the relation solves the constraint.
fn exercise() -> Row {
    let file = Reference::file(FILE);
    let case = &list(&file["cases"])[0];
    let form = Form::new(case);
    let relation = case["relation"].as_str().and_then(|text| text.strip_prefix("z = ")).expect("z = …");
    let mut row = Row::statement(FILE);
    for at in list(&case["surface_points"]) {
        let [x, y, z] = ["x", "y", "z"].map(|name| number(&at[name]));
        let surface = Gradient::of(relation, [x, y, f64::NAN]);
        let [a, b, c] = form.0.map(|text| Gradient::of(text, [x, y, z]).value);
        row = row
            .special("z of the surface", surface.value, z)
            .balance("(P11.1) on the surface", &form.terms([x, y, z]))
            .balance("A + C ∂z/∂x", &[a, c * surface.by[0]])
            .balance("B + C ∂z/∂y", &[b, c * surface.by[1]]);
    }
    let off = point(&list(&case["points"])[0]["point"]);
    row.holds("(P11.1) off the surface", form.terms(off).iter().sum::<f64>().abs() > 1.0)
}

/// (P11.1) and (11.6) are the same but for the factor −C²; where C = 0 only the former can be used. Five forms: the one
/// of the exercise, an exact one, one with an integrating factor, and two that are nonholonomic.
fn symmetric_form() -> Row {
    let file = Reference::file(FILE);
    let mut row = Row::statement("prob-11.1-frobenius-form");
    for case in list(&file["cases"]) {
        let form = Form::new(case);
        let mut largest = 0.0f64;
        for at in list(&case["points"]) {
            let place = point(&at["point"]);
            let terms = form.terms(place);
            let size: f64 = terms.iter().map(|term| term.abs()).sum();
            let (found, expected) = (terms.iter().sum::<f64>(), number(&at["P11.1"]));
            largest = largest.max(found.abs() / size.max(f64::MIN_POSITIVE));
            row = row.within("(P11.1)", found, expected, 1e-13 * size);
            if case["C"] != "0" {
                row = row.balance("(11.6)", &[&form.terms_11_6(place)[..], &terms[..]].concat());
            }
            if case["case"] == "exercise-11.1" {
                row = row.show("(P11.1)", found, expected);
            }
        }
        row = row.holds("vanishes identically", (largest < 1e-13) == (case["identically_zero"] == true));
    }
    row
}
