//! Changes of scale that the compiler states, tried on the accelerations.

use super::{Case, DEGENERATE, SINGULAR};
use crate::compile::system as system_of;
use crate::diagnostics::Errors;
use crate::emit::docs::documentation;
use crate::equations::Derived;
use crate::equations::check::sample;
use crate::graph::{Number, Symbol};
use crate::syntax;

/// Factors of the parameters, of time and of the coordinates.
struct Change {
    parameters: Vec<f64>,
    moving: Vec<f64>,
}

impl Change {
    /// New units: every parameter that gives one has a factor of its own, and those of groups follow.
    fn of_units(d: &Derived) -> Change {
        let scalings = d.equations.scalings.as_ref().expect("a small system");
        let count = d.model.parameters.iter().map(|p| p.numbers().len()).sum();
        let mut parameters: Vec<f64> = (0..count).map(|i| 1.2 + 0.3 * i as f64).collect();
        for group in &scalings.groups {
            let (head, rest) = group.split_first().expect("a group has a parameter");
            let rest = rest.iter().map(|(i, k)| parameters[*i].powf(k.to_f64()));
            parameters[head.0] = rest.product::<f64>().powf(-1.0 / head.1.to_f64());
        }
        let unit = |unit: &Option<Vec<(usize, Number)>>| {
            let powers = unit.iter().flatten().map(|(i, k)| parameters[*i].powf(k.to_f64()));
            powers.product()
        };
        let moving = scalings.units.iter().map(unit).collect();
        Change { parameters, moving }
    }

    fn similar(d: &Derived, exponents: &[Number]) -> Change {
        let count = d.model.parameters.iter().map(|p| p.numbers().len()).sum();
        let moving = exponents.iter().map(|k| 1.3f64.powf(k.to_f64())).collect();
        Change { parameters: vec![1.0; count], moving }
    }

    /// Asserts that accelerations change as they should.
    fn check(&self, d: &Derived, text: &str) {
        let n = d.model.coordinates.len();
        let time = self.moving[0];
        let accel = |factor: &dyn Fn(Symbol) -> f64| {
            d.graph.evaluate(&d.equations.solved.accel, |s| sample(s, 5, 0) * factor(s))
        };
        let plain = accel(&|_| 1.0);
        let scaled = accel(&|s| match s {
            Symbol::Time => time,
            Symbol::Coordinate(i) => self.moving[1 + i],
            Symbol::Velocity(i) => self.moving[1 + i] / time,
            Symbol::Parameter(i) => self.parameters[i],
            _ => 1.0,
        });
        for i in 0..n {
            let expected = plain[i] * self.moving[1 + i] / (time * time);
            let granted = 1e-8 * (1.0 + expected.abs());
            let right = (scaled[i] - expected).abs() <= granted || !plain[i].is_finite();
            assert!(right, "{i}: {} {expected}\n{text}", scaled[i]);
        }
    }
}

fn check(d: &Derived, text: &str) {
    let scalings = d.equations.scalings.as_ref().expect("a small system");
    if scalings.units.iter().all(Option::is_some) {
        Change::of_units(d).check(d, text);
    }
    for exponents in &scalings.similar {
        Change::similar(d, exponents).check(d, text);
    }
}

fn derived(text: &str) -> Result<Derived, Vec<String>> {
    let mut errors = Errors::default();
    let tokens = format!("@crate [::lagrange_runtime] {text}").parse().expect("tokens");
    let d = syntax::parse(tokens, &mut errors).and_then(|definition| system_of(&definition, &mut errors));
    d.filter(|_| errors.is_empty()).ok_or_else(|| errors.messages())
}

/// Groups, units and similarities of a system, in words.
fn found(text: &str) -> [Vec<String>; 3] {
    let text = format!("system A {{ {text} }}");
    let d = derived(&text).expect(&text);
    check(&d, &text);
    let labels = d.model.parameter_labels();
    let word = |name: &str, k: &Number| match k {
        Number::Ratio(n, 1) => format!("{name}^{n}"),
        Number::Ratio(n, d) => format!("{name}^{n}/{d}"),
        Number::Float(..) => format!("{name}^{}", k.to_f64()),
    };
    let product =
        |m: &Vec<(usize, Number)>| m.iter().map(|(i, k)| word(&labels[*i], k)).collect::<Vec<_>>().join(" ");
    let scalings = d.equations.scalings.as_ref().expect("a small system");
    let units = scalings.units.iter().map(|unit| unit.as_ref().map_or("free".into(), product));
    let similar = scalings
        .similar
        .iter()
        .map(|exponents| exponents.iter().map(|k| k.to_f64().to_string()).collect::<Vec<_>>().join(" "));
    [scalings.groups.iter().map(product).collect(), units.collect(), similar.collect()]
}

#[test]
fn groups_of_known_systems() {
    for (text, groups, units, similar) in [
        (
            "param m, l, g; coord a: angle; T = 0.5 * m * (l * dot(a)).powi(2); V = -m * g * l * cos(a);",
            &[][..],
            &["l^1/2 g^-1/2", ""][..],
            &[][..],
        ),
        // Numbers have no units: here lengths and times hang together.
        (
            "param m, l; coord a: angle; T = 0.5 * m * (l * dot(a)).powi(2); V = -m * 9.81 * l * cos(a);",
            &[],
            &["l^1/2", ""],
            &[],
        ),
        (
            "param m, l, k, c, g; coord a: angle, r: length; T = 0.5 * m * (dot(r).powi(2) + (r * dot(a)).powi(2)); \
             V = 0.5 * k * (r - l).powi(2) - m * g * r * cos(a); D = 0.5 * c * dot(r).powi(2);",
            &["c^2 m^-1 k^-1", "g^1 m^1 l^-1 k^-1"],
            &["m^1/2 k^-1/2", "", "l^1"],
            &[],
        ),
        // Kepler's third law.
        (
            "param mu; coord r, a; T = 0.5 * (dot(r).powi(2) + (r * dot(a)).powi(2)); V = -mu / r;",
            &[],
            &["free", "free", ""],
            &["3 2 0"],
        ),
        // An oscillator has one period; drag in the square of the velocity has a length.
        (
            "param m, k; coord x; T = 0.5 * m * dot(x).powi(2); V = 0.5 * k * x.powi(2);",
            &[],
            &["m^1/2 k^-1/2", "free"],
            &["0 1"],
        ),
        (
            "param m, k, c; coord x; T = 0.5 * m * dot(x).powi(2); V = 0.5 * k * x.powi(2); Q[x] = -c * dot(x) * abs(dot(x));",
            &[],
            &["m^1/2 k^-1/2", "m^1 c^-1"],
            &[],
        ),
        // A power with an exponent that is no fraction leaves no unit.
        (
            "param m, k, e; coord x; T = 0.5 * m * dot(x).powi(2); V = k * x.powf(PI) + k * x.powf(2.5) * e;",
            &["e^1"],
            &["m^1/2 k^-1/2", ""],
            &[],
        ),
        // Friction turns where the velocity does; a choice by a length.
        (
            "param m, f, d; coord x; T = 0.5 * m * dot(x).powi(2); V = 0; Q[x] = -f * signum(dot(x)) + if x > d { f } else { 0 };",
            &[],
            &["m^1/2 f^-1/2 d^1/2", "d^1"],
            &[],
        ),
        // A constraint and a state of first order.
        (
            "param m, g, l, tau; coord x, y; state u = 0; rate(u) = (x - u) / tau; T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)); \
             V = m * g * y + 0 * u; constraint rod: x.powi(2) + y.powi(2) == l.powi(2);",
            &["tau^2 g^1 l^-1"],
            &["g^-1/2 l^1/2", "l^1", "l^1", "g^-1/2 l^3/2"],
            &[],
        ),
    ] {
        let strings = |all: &[&str]| all.iter().map(|s| s.to_string()).collect::<Vec<_>>();
        let all = found(text);
        assert_eq!(all, [strings(groups), strings(units), strings(similar)], "{text}");
    }
}

#[test]
fn documentation_shows_groups_and_units() {
    let shown = |text: &str| -> Vec<String> {
        let d = derived(&format!("system A {{ {text} }}")).expect(text);
        let lines = documentation(&d).into_iter();
        lines.filter(|line| line.contains("Dimensionless") || line.contains("Similar")).collect()
    };
    assert_eq!(
        shown(
            "param m, l, g, k; coord a: angle, r: length; T = 0.5 * m * (dot(r).powi(2) + (r * dot(a)).powi(2)); \
             V = 0.5 * k * (r - l).powi(2) - m * g * r * cos(a);"
        ),
        [
            "- Dimensionless groups of parameters: `k l / (m g)`.",
            "- Dimensionless variables: `t √(g / l)`, `r / l`."
        ]
    );
    assert_eq!(
        shown("param mu; coord r, a; T = 0.5 * (dot(r).powi(2) + (r * dot(a)).powi(2)); V = -mu / r;"),
        ["- Similar motions, for each λ > 0: `t` × λ³, `r` × λ²."]
    );
    assert_eq!(
        shown("param k, w; coord x; coord y = sin(w * t); T = dot(x).powi(2); V = k * (x - y).powi(4);"),
        ["- Dimensionless groups of parameters: `w² / k`.", "- Dimensionless variables: `t √k`."]
    );
}

#[test]
fn random_systems_scale() {
    let (mut stated, mut tried) = (0, 0);
    let seeds = crate::differential::few();
    for seed in 0..seeds {
        let text = Case::new(seed).text();
        match derived(&text) {
            Ok(d) => {
                check(&d, &text);
                tried += 1;
                let scalings = d.equations.scalings.as_ref().expect("a small system");
                stated += u64::from(!scalings.similar.is_empty() || !scalings.groups.is_empty());
            }
            Err(messages) => {
                let known = DEGENERATE.iter().chain(&SINGULAR);
                assert!(messages.iter().all(|m| known.clone().any(|part| m.contains(part))), "{messages:?}");
            }
        }
    }
    assert!(4 * tried > 3 * seeds && 4 * stated > seeds, "{stated} of {tried}");
}
