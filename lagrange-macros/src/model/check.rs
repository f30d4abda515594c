//! What a definition must satisfy as a whole, one function a rule.

use super::elaborate::Elaborator;
use crate::graph::{Symbol, Value};
use crate::syntax::Statement;
use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::Expr;

/// Velocities stand where the meaning of an energy allows them.
pub(super) fn energy(e: &mut Elaborator, keyword: &Ident, expression: &Expr, value: Value) {
    let moving = e.graph.depends(&[value], |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_)));
    match keyword.to_string().as_str() {
        "V" if moving => {
            let message = "the potential energy depends on velocities\nhelp: a velocity-dependent potential belongs into the whole Lagrangian, `L = …;` instead of `T` and `V`";
            match first_dot(expression.to_token_stream()) {
                Some(dot) => e.errors.push(dot, message),
                None => e.errors.push(keyword, message),
            };
        }
        "T" | "L" if !moving => {
            let message = format!(
                "`{keyword}` does not depend on any velocity\nhelp: velocities are `dot(coordinate)`"
            );
            e.errors.push(expression, message);
        }
        "D" if !moving && !value.is_zero() => {
            let message = "the dissipation function does not depend on any velocity\nhelp: Rayleigh's function is a quadratic form in the velocities, such as `0.5 * c * dot(x).powi(2)`";
            e.errors.push(expression, message);
        }
        _ => {}
    }
}

/// The first `dot(…)` in an expression.
fn first_dot(tokens: TokenStream) -> Option<TokenStream> {
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        match (&token, tokens.peek()) {
            (TokenTree::Ident(word), Some(TokenTree::Group(argument))) if word == "dot" => {
                return Some([token.clone(), argument.clone().into()].into_iter().collect());
            }
            (TokenTree::Group(group), _) => {
                if let Some(dot) = first_dot(group.stream()) {
                    return Some(dot);
                }
            }
            _ => {}
        }
    }
    None
}

/// Rules about what is there and what is missing.
pub(super) fn complete(e: &mut Elaborator, name: &Ident, statements: &[Statement]) {
    if statements.is_empty() {
        if e.errors.is_empty() {
            e.errors.push(name, "this system is empty\nhelp: it needs at least a coordinate and its energies, `coord x; T = …; V = …;`");
        }
        return;
    }
    coordinates(e, name, statements);
    energies(e, name);
    unused_parameters(e);
}

fn coordinates(e: &mut Elaborator, name: &Ident, statements: &[Statement]) {
    if !statements.iter().any(|s| matches!(s, Statement::Coord(_))) {
        e.errors.push(name, "this system has no coordinates\nhelp: declare them with `coord theta;`");
    } else if e.coordinates.is_empty() && e.errors.is_empty() {
        e.errors.push(name, "all coordinates of this system are prescribed: there is no motion to find\nhelp: declare a free coordinate with `coord theta;`");
    }
}

fn energies(e: &mut Elaborator, name: &Ident) {
    let [t, v, l, _] = std::array::from_fn(|i| e.energies[i].as_ref().map(|(keyword, _)| keyword.clone()));
    match (t, v, l) {
        (Some(_), Some(_), None) | (None, None, Some(_)) => {}
        (None, None, None) => {
            e.errors.push(
                name,
                "this system has no energies\nhelp: write `T = …; V = …;`, or the whole Lagrangian `L = …;`",
            );
        }
        (Some(t), None, None) => {
            e.errors.push(t, "`V` is missing\nhelp: without a potential write `V = 0;`");
        }
        (None, Some(v), None) => {
            e.errors.push(v, "`T` is missing\nhelp: write the kinetic energy, `T = …;`");
        }
        (t, v, Some(l)) => {
            let other = t.or(v).map_or(String::new(), |k| format!("`{k}`"));
            e.errors.push(l, format!("`L` is the whole Lagrangian, and {other} is given too\nhelp: keep either `L` or `T` and `V`"));
        }
    }
}

fn unused_parameters(e: &mut Elaborator) {
    // After an error the use may be in what was not understood.
    if !e.errors.is_empty() {
        return;
    }
    for parameter in &e.parameters {
        if !e.used.contains(&parameter.name.to_string()) {
            let message =
                format!("the parameter `{}` is not used\nhelp: remove it, or use it", parameter.name);
            e.errors.push(&parameter.name, message);
        }
    }
}

/// Outputs must not hide what every system has.
pub(super) fn reserved_output(name: &str) -> Option<String> {
    const TAKEN: [&str; 17] = [
        "new",
        "accel",
        "lagrangian",
        "kinetic",
        "potential",
        "energy",
        "jacobi",
        "momenta",
        "inertia",
        "bias",
        "force",
        "dissipation",
        "power",
        "jacobian",
        "velocities",
        "default",
        "lift",
    ];
    TAKEN
        .contains(&name)
        .then(|| format!("every system has a function `{name}` already\nhelp: choose another name"))
}
