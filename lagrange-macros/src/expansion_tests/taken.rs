//! Names that a system may not use: the table of them in the guide is that of the compiler.

use super::names::ROLES;
use crate::compile::compile_with;
use crate::diagnostics::Errors;
use crate::graph::function::TABLE;
use crate::model::{ATTITUDE_FUNCTIONS, DIRECTION_FUNCTIONS, METHODS, RESERVED};
use crate::syntax::words::{KEYWORDS, PRIMITIVES};
use crate::table::{CONSTANTS, TRAITS, Trait};
use proc_macro2::TokenStream;
use quote::quote;
use std::fmt::Write;

/// A row of the table.
struct Group {
    names: Vec<String>,
    /// The roles for which they are taken, in words.
    of: &'static str,
    /// The same as definitions in which NAME has the role.
    templates: Vec<&'static str>,
    /// The first line of the error, about NAME.
    says: String,
}

/// Roles whose name a formula may say.
const VALUES: [&str; 16] = [
    "param",
    "param array",
    "param default",
    "input",
    "input array",
    "coord",
    "coord array",
    "prescribed",
    "const",
    "let",
    "let array",
    "fn",
    "extern fn",
    "constraint",
    "state",
    "state array",
];
const OUTPUTS: [&str; 4] = ["observe", "impulse", "state", "state array"];
const OF_VALUES: &str = "parameter, input, coordinate, state, `const`, `let`, function, constraint";
const OF_OUTPUTS: &str = "output (`observe`, `impulse`, `state`)";

const HELD: [&str; 1] = [
    "system A { coord z, w; T = dot(z).powi(2) + dot(w).powi(2); V = z.cos() + w.cos(); observe NAME = z; restriction B: w = 0; }",
];
const ROTATION: [&str; 1] = [
    "system A { coord R: rotation; T = body(1, [1, 2, 3], frame(world, [0, 0, 0], R)); V = 0; observe NAME = dot(R); }",
];
const DIRECTION: [&str; 1] =
    ["system A { coord n: direction; T = 0.5 * dot(n).norm_squared(); V = n[2]; observe NAME = n; }"];
const REDUCED: [&str; 1] = [
    "system A { param NAME; coord r, phi; T = dot(r).powi(2) + (r * dot(phi)).powi(2); V = NAME * r; routhian B; }",
];

fn of_roles(roles: &[&str]) -> Vec<&'static str> {
    let of = |name: &&str| ROLES.into_iter().find(|(role, _)| role == name).expect("a role").1;
    roles.iter().map(of).collect()
}

fn groups() -> Vec<Group> {
    let owned = |names: &mut dyn Iterator<Item = &'static str>| {
        let mut names: Vec<String> = names.map(String::from).collect();
        names.sort_unstable();
        names
    };
    let mut groups: Vec<Group> = Vec::new();
    let mut add = |names, of, templates, says: &str| {
        groups.push(Group { names, of, templates, says: says.into() });
    };
    let all: Vec<&str> = ROLES.iter().map(|(role, _)| *role).filter(|role| *role != "closure").collect();
    add(owned(&mut KEYWORDS.into_iter()), "anything", of_roles(&all), "`NAME` is a keyword of Rust");
    for (name, is) in RESERVED {
        add(vec![name.to_string()], OF_VALUES, of_roles(&VALUES), &format!("`NAME` {is}"));
    }
    add(
        owned(&mut TABLE.iter().map(|row| row.name).chain(METHODS)),
        OF_VALUES,
        of_roles(&VALUES),
        "`NAME` is an elementary function",
    );
    let of_traits = |restricted: bool| {
        let of_trait = TRAITS.iter().filter(|of| (of.name == "Restricted") == restricted);
        owned(&mut of_trait.flat_map(Trait::names))
    };
    let says = "systems have a function `NAME` already";
    add(of_traits(false), OF_OUTPUTS, of_roles(&OUTPUTS), says);
    add(of_traits(true), "output of a definition with `restriction` or `simplified`", HELD.to_vec(), says);
    let functions = |prefixes: &[&str], name: &str| prefixes.iter().map(|of| format!("{of}{name}")).collect();
    add(
        functions(&ATTITUDE_FUNCTIONS, "R"),
        "output beside `coord R: rotation;`",
        ROTATION.to_vec(),
        "`NAME` reads or sets the rotation `R` already",
    );
    add(
        functions(&DIRECTION_FUNCTIONS, "n"),
        "output beside `coord n: direction;`",
        DIRECTION.to_vec(),
        "`NAME` reads or sets the direction `n` already",
    );
    add(
        owned(&mut CONSTANTS.into_iter()).iter().map(|name| name.to_lowercase()).collect(),
        "event, in small or capital letters",
        of_roles(&["event"]),
        "systems have a constant `CONSTANT` already",
    );
    add(
        vec!["p_phi".into()],
        "parameter of a system with `routhian B;` and the ignorable coordinate `phi`",
        REDUCED.to_vec(),
        "`NAME` is the momentum of `phi` in `B`",
    );
    let system = of_roles(&["system"]);
    add(
        vec!["S".into()],
        "system or derived type",
        system.clone(),
        "a system cannot be called `NAME`: every system calls the type of its numbers so",
    );
    add(
        owned(&mut PRIMITIVES.into_iter()),
        "system or derived type",
        system,
        "a system cannot be called `NAME`: this is a type of Rust",
    );
    groups
}

/// Is a name taken in the system of one of the roles?
pub fn is_taken(name: &str, template: &str) -> bool {
    let name = name.strip_prefix("r#").unwrap_or(name);
    groups().iter().filter(|g| g.templates.contains(&template)).any(|g| {
        // (The constant of an event is in capital letters.)
        let is =
            |taken: &String| taken == name || g.says.contains("CONSTANT") && *taken == name.to_lowercase();
        g.names.iter().any(is)
    })
}

/// A new role belongs to one of the lists, whatever the samples of the other tests.
#[test]
fn every_role_is_of_values_or_outputs() {
    for (role, _) in ROLES {
        let is_other = ["event", "system", "argument", "closure"].contains(&role);
        assert!(is_other || VALUES.contains(&role) || OUTPUTS.contains(&role), "{role}");
    }
}

/// Each name is refused with the message of its row, in one of the roles, and the first one in all of them.
#[test]
fn taken_names_are_refused() {
    for Group { names, templates, says, .. } in groups() {
        for (i, name) in names.iter().enumerate() {
            for (j, template) in templates.iter().enumerate() {
                // (`let mut x` has a message of its own.)
                if i != 0 && j != i % templates.len() || name == "mut" && template.contains("let NAME") {
                    continue;
                }
                let definition = template.replace("NAME", name);
                let tokens: TokenStream = definition.parse().expect("tokens of Rust");
                let mut errors = Errors::default();
                compile_with(quote!(@crate [::lagrange_runtime] #tokens), &mut errors);
                let said = errors.said();
                let Some((at, message)) = said.first() else { panic!("accepted: {definition}") };
                let expected = says.replace("NAME", name).replace("CONSTANT", &name.to_uppercase());
                assert_eq!(message.lines().next(), Some(expected.as_str()), "{definition}");
                assert!(message.contains("\nhelp: "), "{message}");
                assert_eq!(at.source_text().as_ref(), Some(name), "{message}");
            }
        }
    }
}

#[test]
fn the_guide_lists_taken_names() {
    let page = include_str!("../../../docs/guide/src/glossary.md");
    let mut table = String::from("| Names | Taken as the name of | The error says |\n|---|---|---|\n");
    for Group { names, of, says, .. } in groups() {
        let says = match &names[..] {
            [name] => says.replace("NAME", name),
            _ => says.replace("NAME", "…").replace("CONSTANT", "…"),
        };
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(table, "| {} | {of} | {says} |", names.join(", "));
    }
    assert!(page.contains(&table), "the table of docs/guide/src/glossary.md has to read:\n{table}");
}
