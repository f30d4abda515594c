//! Rules that a definition must satisfy as a whole, one function per rule.

use super::Entry;
use super::elaborate::{Elaborator, numbers};
use crate::graph::{Symbol, Value};
use crate::syntax::{Header, Statement};
use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use syn::Expr;

/// Velocities stand where the meaning of an energy allows them.
pub(super) fn energy(e: &mut Elaborator, keyword: &Ident, expression: &Expr, value: Value) {
    let moving = moves_with(e, &[value]);
    match keyword.to_string().as_str() {
        "T" if e.of_states(&[value]) => {
            let message = "the kinetic energy depends on a state of first order, whose rate would be part of the momenta\nhelp: `V`, `D`, forces, rates and outputs may depend on states; a mass that changes is a function of time, or a force";
            e.errors.push(expression, message);
        }
        "V" if moving => {
            let message = "the potential energy depends on velocities\nhelp: a damper is `D = 0.5 * c * dot(x).powi(2);`, another force `Q[x] = …;`; a velocity-dependent potential belongs in the whole Lagrangian, `L = …;` instead of `T` and `V`";
            match moving_word(e, expression.to_token_stream()) {
                Some(word) => e.errors.push(word, message),
                None => e.errors.push(expression, message),
            };
        }
        // Without coordinates there are no velocities, which is reported for the whole.
        "T" | "L" if !moving && !e.found.coordinates.is_empty() => {
            let example = e.found.coordinates[0].label();
            let message = format!(
                "`{keyword}` does not depend on any velocity\nhelp: the velocity of `{example}` is `dot({example})`, and is not declared"
            );
            e.errors.push(expression, message);
        }
        "D" if !moving && !value.is_zero() && !e.is_derived() => {
            let message = "the dissipation function does not depend on any velocity\nhelp: Rayleigh's function is a quadratic form in the velocities, such as `0.5 * c * dot(x).powi(2)`";
            e.errors.push(expression, message);
        }
        _ => {}
    }
}

/// The first `dot(…)` in an expression, or name of something that has a velocity in it.
fn moving_word(e: &Elaborator, tokens: TokenStream) -> Option<TokenStream> {
    let mut tokens = tokens.into_iter().peekable();
    while let Some(token) = tokens.next() {
        match (&token, tokens.peek()) {
            (TokenTree::Ident(word), Some(TokenTree::Group(argument))) if word == "dot" => {
                return Some([token.clone(), argument.clone().into()].into_iter().collect());
            }
            (TokenTree::Ident(word), _) if moves(e, &word.to_string()) => return Some(token.into()),
            (TokenTree::Group(group), _) => {
                if let Some(word) = moving_word(e, group.stream()) {
                    return Some(word);
                }
            }
            _ => {}
        }
    }
    None
}

fn moves(e: &Elaborator, name: &str) -> bool {
    match e.scope.names.get(name) {
        Some((_, Entry::Let(val))) => moves_with(e, &numbers(val)),
        Some((_, Entry::Function(f))) => {
            let body = e.scope.functions[*f].body.to_token_stream();
            body.into_iter().any(|token| matches!(token, TokenTree::Ident(word) if word == "dot"))
        }
        _ => false,
    }
}

/// Do these depend on velocities? A state of first order is none.
fn moves_with(e: &Elaborator, values: &[Value]) -> bool {
    let states = e.found.states.first().map_or(usize::MAX, |state| state.first);
    e.graph.depends(values, |s| match s {
        Symbol::Velocity(i) => i < states,
        Symbol::Rate(_) => true,
        _ => false,
    })
}

/// Rules about what is there and what is missing.
pub(super) fn complete(e: &mut Elaborator, header: &Header, statements: &[Statement]) {
    let name = &header.name;
    if statements.is_empty() {
        if e.errors.is_empty() {
            e.errors.push(name, "this system is empty\nhelp: it needs at least a coordinate and its energies, `coord x; T = …; V = …;`");
        }
        return;
    }
    if e.scope.incomplete && e.scope.unread.is_empty() {
        return;
    }
    coordinates(e, name, statements);
    energies(e, name);
    rates(e);
    unused(e);
    names(e, name);
    visibilities(e, header);
}

/// A derived system has a velocity in its kinetic energy; the other requirements are checked when its
/// equations are formed.
pub(super) fn derived(e: &mut Elaborator, header: &Header) {
    rates(e);
    if e.found.coordinates.is_empty() {
        e.errors.push(&header.name, "nothing is left to move\nhelp: leave a coordinate free");
    }
}

/// A derived system names the whole one in a public trait, so that it is no more visible than that.
fn visibilities(e: &mut Elaborator, header: &Header) {
    if header.is_public() {
        return;
    }
    for derived in e.found.submodels.iter().map(|s| &s.header).filter(|derived| derived.is_public()) {
        let (name, whole) = (&derived.name, &header.name);
        let message = format!(
            "`{name}` is public, and `{whole}`, which it is derived from, is not\nhelp: write `pub system {whole}`, or leave out this `pub`"
        );
        e.errors.push(&derived.visibility, message);
    }
}

/// Two types cannot have one name.
fn names(e: &mut Elaborator, name: &Ident) {
    let routhian = e.found.routhian.iter().map(|header| &header.name);
    let derived: Vec<Ident> =
        routhian.chain(e.found.submodels.iter().map(|s| &s.header.name)).cloned().collect();
    for (i, same) in derived.iter().enumerate() {
        let message = if same == name {
            format!(
                "the system is called `{same}` already\nhelp: give the reduced system another name, such as `Reduced{same}`"
            )
        } else if derived[..i].contains(same) {
            format!("a second type `{same}`\nhelp: give one of them another name")
        } else {
            continue;
        };
        e.errors.push(same, message);
    }
}

fn coordinates(e: &mut Elaborator, name: &Ident, statements: &[Statement]) {
    if !statements.iter().any(|s| matches!(s, Statement::Coord(_)))
        && !["coord", "variable"].iter().any(|word| e.scope.unread.contains_key(*word))
    {
        e.errors.push(name, "this system has no coordinates\nhelp: declare them with `coord theta;`");
    } else if e.found.coordinates.is_empty() && e.errors.is_empty() {
        e.errors.push(name, "all coordinates of this system are prescribed: there is no motion to find\nhelp: declare a free coordinate with `coord theta;`");
    }
}

/// Each state has a rate, and there are no derived systems of them.
fn rates(e: &mut Elaborator) {
    if e.scope.incomplete {
        return;
    }
    for state in &e.found.states {
        let places = state.first..state.first + state.initial.len();
        if let Some(i) = places.clone().find(|i| e.found.applied[*i].is_none()) {
            let label = e.found.coordinates[i].label();
            let message = format!(
                "the state `{label}` has no rate\nhelp: write `rate({label}) = …;`; a value that is held is a `param`, or an `input`"
            );
            e.errors.push(&state.name, message);
        }
    }
    if let (Some(header), Some(_)) = (&e.found.routhian, e.found.states.first()) {
        let message = "systems with states of first order are not reduced\nhelp: remove this statement, and write the system without its ignorable coordinates";
        e.errors.push(&header.name, message);
    }
}

fn energies(e: &mut Elaborator, name: &Ident) {
    // What could not be read may have been an energy.
    let [t, v, l] = [0, 1, 2].map(|i| {
        let read = e.found.energies[i].as_ref().map(|(keyword, _)| keyword);
        read.or_else(|| e.scope.unread.get(["T", "V", "L"][i])).cloned()
    });
    match (t, v, l) {
        (Some(_), Some(_), None) | (None, None, Some(_)) => {}
        (None, None, None) if e.scope.incomplete => {}
        (None, None, None) => {
            e.errors.push(
                name,
                "this system has no energies\nhelp: write `T = …;` and `V = …;`, or the whole Lagrangian `L = …;`",
            );
        }
        (Some(t), None, None) => missing(e, &t, "V", "without a potential write `V = 0;`"),
        (None, Some(v), None) => missing(e, &v, "T", "write the kinetic energy, `T = …;`"),
        (t, v, Some(l)) => {
            let other = t.or(v).map_or(String::new(), |k| format!("`{k}`"));
            e.errors.push(l, format!("`L` is the whole Lagrangian, and {other} is given too\nhelp: keep either `L` or `T` and `V`"));
        }
    }
}

/// `energy` is missing beside the one at `other`.
fn missing(e: &mut Elaborator, other: &Ident, energy: &str, help: &str) {
    match e.scope.names.get(energy) {
        Some((name, Entry::Let(_))) => {
            let message = format!(
                "`let {energy}` names an expression, and is no energy of the system\nhelp: remove `let`"
            );
            e.errors.push(name.clone(), message);
        }
        _ => {
            e.errors.push(other, format!("`{energy}` is missing\nhelp: {help}"));
        }
    }
}

/// Bindings and parameters that nothing depends on, unless their names say so: `let D = …;` is no dissipation function.
fn unused(e: &mut Elaborator) {
    // After an error the use may be in what was not understood.
    if !e.errors.is_empty() {
        return;
    }
    let bindings = e.scope.names.values().filter(|(_, entry)| matches!(entry, Entry::Let(_)));
    let bindings = bindings.map(|(name, _)| ("unused_binding", name));
    let parameters = e.found.parameters.iter().map(|parameter| ("unused_parameter", &parameter.name));
    for (about, name) in bindings.chain(parameters) {
        let text = name.to_string();
        if e.scope.used.contains(&text) || text.starts_with('_') {
            continue;
        }
        let help = match text.as_str() {
            "T" | "V" | "L" | "D" if about == "unused_binding" => {
                format!("that of the system is `{text} = …;`, without `let`")
            }
            "Q" | "F" | "force" | "f" | "tau" if about == "unused_binding" => {
                "a generalized force is `Q[x] = …;`, one at a point `force [fx, fy] at [x, y];`".into()
            }
            _ => format!(
                "remove it, or let an energy or a force depend on it; if it is meant to be unused, call it `_{text}`"
            ),
        };
        e.errors.warn(name.span(), about, format!("nothing depends on `{text}`\nhelp: {help}"));
    }
}
