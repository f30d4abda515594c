//! Systems with coordinates held cost what those cost that a person would have written.

use super::{defined, solved};
use crate::compile::submodels;
use crate::diagnostics::Errors;
use crate::equations::Derived;
use crate::equations::check::sample;
use crate::equations::restriction::invariant;
use crate::equations::solve::entry;
use crate::graph::{Symbol, Value};
use quote::quote;

/// A chain of so many links from `s` on, in space or in a plane.
fn chain(coordinates: &str, x: &str, y: Option<&str>, z: &str, held: &str) -> proc_macro2::TokenStream {
    let (binding, square) = y.map_or(Default::default(), |y| {
        (format!("let y: [N] = |i| if i == 0 {{ 0 }} else {{ y[i - 1] }} + l * {y};"), "+ dot(y[i]).powi(2)")
    });
    let text = format!(
        "system Chain {{ const N = 12; param m, l, g; coord {coordinates};
            let x: [N] = |i| if i == 0 {{ 0 }} else {{ x[i - 1] }} + l * {x}; {binding}
            let z: [N] = |i| if i == 0 {{ 0 }} else {{ z[i - 1] }} - l * {z};
            T = (0..N).map(|i| 0.5 * m * (dot(x[i]).powi(2) {square} + dot(z[i]).powi(2))).sum();
            V = (0..N).map(|i| m * g * z[i]).sum(); {held} }}"
    );
    let system: proc_macro2::TokenStream = text.parse().expect("tokens");
    quote!(@crate [::lagrange_runtime] #system)
}

#[test]
fn a_planar_chain_costs_what_it_costs_by_hand() {
    let by_hand = solved(chain("theta: [N]", "theta[i].sin()", None, "theta[i].cos()", ""));
    let spatial = chain(
        "theta: [N], phi: [N]",
        "theta[i].sin() * phi[i].cos()",
        Some("phi[i].sin()"),
        "theta[i].cos() * phi[i].cos()",
        "restriction Planar: phi = 0;",
    );
    let whole = solved(spatial.clone());
    let mut errors = Errors::default();
    let small = submodels(&defined(spatial), &whole, &mut errors);
    assert!(errors.is_empty(), "{:?}", errors.messages());
    let [small] = &small[..] else { panic!("one restriction") };
    assert_eq!(small.equations.solved.operations, by_hand.equations.solved.operations);
    assert!(
        whole.equations.solved.operations.arithmetic() > 5 * by_hand.equations.solved.operations.arithmetic()
    );
}

#[test]
fn sets_are_invariant_by_proof() {
    let of = |text: &str| {
        let system: proc_macro2::TokenStream = text.parse().expect("tokens");
        invariant(&solved(quote!(@crate [::lagrange_runtime] system A { #system })))
    };
    let pendulum = "coord a, b; T = dot(a).powi(2) + (a.cos() * dot(b)).powi(2); V = a.cos() * b.cos();";
    assert_eq!(of(pendulum), [0, 1]);
    assert_eq!(of("coord a, b; T = dot(a).powi(2) + dot(a) * dot(b) + dot(b).powi(2); V = a * a;"), []);
    assert_eq!(of("coord a, b; T = dot(a).powi(2) + dot(b).powi(2); V = a * a + b;"), [0]);
    // At 0 this one has no value.
    assert_eq!(of("coord a, b; T = dot(a).powi(2) + dot(b).powi(2) / a; V = b * b;"), [1]);
}

/// The first lines of the documentation of the type that a system asks for.
fn documentation(text: &str) -> String {
    let system: proc_macro2::TokenStream = text.parse().expect("tokens");
    let input = quote!(@crate [::lagrange_runtime] #system);
    let mut errors = Errors::default();
    let all = submodels(&defined(input.clone()), &solved(input), &mut errors);
    assert!(errors.is_empty(), "{:?}", errors.messages());
    let lines = crate::emit::docs::documentation(&all[0]);
    lines.into_iter().skip(1).take_while(|line| line != "# Lagrangian").collect::<Vec<_>>().join("\n")
}

/// Formulas without their markup.
fn plain(text: &str) -> String {
    let text = text.replace("&#x2062;", "");
    text.split('<').map(|part| part.split_once('>').map_or(part, |(_, rest)| rest)).collect()
}

#[test]
fn what_is_left_out_is_in_the_documentation() {
    let small = documentation(
        "system A { param m, k, n; coord x, y; let stiff = 0.25 * n * y.powi(4);
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * n * y * y * dot(y).powi(2); V = k * (2 - x.cos()) * (1 - y.cos()) + stiff + k * x * x;
            simplified Small: lock x = 0, neglect stiff, neglect n, expand y to 2 about 0; }",
    );
    assert_eq!(
        plain(&small),
        "[`A`] at `x` = 0, simplified. The error of this system grows with the terms that these moves leave out:\n\n\
         - `lock x = 0`\n- `neglect stiff`, without \u{2212}14ny4 of L\n- `neglect n`, without 12ny2y˙2 of L\n\
         - `expand y to 2 about 0`, without terms that begin with \u{2212}124ky4 of V\n",
        "{small}"
    );
}

/// Random systems in all words of the language, read again with a coordinate held: L, D, momenta, forces and M are
/// those of the whole system there.
#[test]
fn random_systems_with_a_coordinate_held() {
    let (mut compared, mut refused) = (0, Vec::new());
    let seeds = crate::differential::few() / 2;
    for seed in 0..seeds {
        let text = crate::differential::written(seed);
        let tokens = |text: &str| -> proc_macro2::TokenStream {
            let system: proc_macro2::TokenStream = text.parse().expect("tokens");
            quote!(@crate [::lagrange_runtime] #system)
        };
        let mut errors = Errors::default();
        let Some(whole) = crate::compile::system(&defined(tokens(&text)), &mut errors) else { continue };
        let (n, k) = (whole.model.mechanical(), seed as usize % whole.model.mechanical());
        if n < 2 {
            continue;
        }
        let end = text.rfind('}').expect("the end of the system");
        let text = format!("{} simplified Held: lock q{k} = 0.3; }}", &text[..end]);
        let definition = defined(tokens(&text));
        let whole = crate::compile::system(&definition, &mut errors).expect("as before");
        let all = submodels(&definition, &whole, &mut errors);
        let [small] = &all[..] else {
            refused.push(errors.messages().concat());
            continue;
        };
        compared += 1;
        compare(&whole, small, k, seed);
    }
    // Without that coordinate some have singular inertia, or contradict a constraint.
    assert!(2 * compared > seeds as usize && refused.len() < compared, "{compared}, {refused:#?}");
}

fn compare(whole: &Derived, small: &Derived, held: usize, seed: u64) {
    let n = whole.model.coordinates.len();
    let kept: Vec<usize> = (0..n).filter(|i| *i != held).collect();
    for trial in 0..3 {
        let place = |i: usize| kept.iter().position(|k| *k == i);
        let of = |s: Symbol| sample(s, trial, seed);
        let at = |s: Symbol| match s {
            Symbol::Coordinate(i) => place(i).map_or(0.3, |k| of(Symbol::Coordinate(k))),
            Symbol::Velocity(i) => place(i).map_or(0.0, |k| of(Symbol::Velocity(k))),
            other => of(other),
        };
        let parts = |d: &Derived, all: &[usize]| -> Vec<Value> {
            let (f, s) = (&d.equations.formed, &d.equations.solved);
            let rows =
                [&f.momenta, &f.bias, &f.force].into_iter().flat_map(|row| all.iter().map(|i| row[*i]));
            let inertia = all.iter().flat_map(|i| all.iter().map(|j| entry(&s.inertia, *i, *j)));
            [f.lagrangian, f.dissipation].into_iter().chain(rows).chain(inertia).collect()
        };
        let expected = whole.graph.evaluate(&parts(whole, &kept), at);
        let found = small.graph.evaluate(&parts(small, &(0..n - 1).collect::<Vec<_>>()), of);
        let size = expected.iter().filter(|x| x.is_finite()).fold(1.0, |size: f64, x| size.max(x.abs()));
        for (i, (a, b)) in found.iter().zip(&expected).enumerate() {
            assert!((a - b).abs() <= 1e-9 * size || !b.is_finite(), "seed {seed}, {i}: {a} against {b}");
        }
    }
}
