//! Chains and trees of links: what their accelerations cost, by number of links.

use super::{arithmetic::agreed, input, solved};
use crate::differential::LONG;
use proc_macro2::{TokenStream, TokenTree};

/// Kind of links, with unit masses and lengths or with parameters for them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Kind {
    /// A chain by the angles of the links with the vertical.
    Absolute,
    /// A chain by the angles of each link with the previous one.
    Relative,
    /// A chain on a cart.
    Cart,
    /// A chain on a cart, with each position written as a sum from the cart on.
    FromCart,
    /// A binary tree: link i hangs on link (i − 1)/2.
    Tree,
}

pub fn links(kind: Kind, n: usize, symbolic: bool) -> TokenStream {
    loaded(kind, n, symbolic, ["", ""])
}

/// With statements of what acts on them, and terms of V in front of their weight.
fn loaded(kind: Kind, n: usize, symbolic: bool, [acting, springs]: [&str; 2]) -> TokenStream {
    let (parameters, m, l, g) = if symbolic {
        ("param m: [N], l: [N], g = 9.81;", "m[i]", "l[i]", "g")
    } else {
        ("", "1", "1", "9.81")
    };
    let parent = match kind {
        Kind::Tree => "(i - 1) / 2",
        _ => "i - 1",
    };
    let (base, cart) = match kind {
        Kind::Cart | Kind::FromCart => ("s", "coord s;"),
        _ => ("0", ""),
    };
    let cart_energy =
        if kind == Kind::Cart || kind == Kind::FromCart { "0.5 * dot(s).powi(2) +" } else { "" };
    let angle = match kind {
        Kind::Relative => "let phi: [N] = |i| (0..i + 1).map(|j| theta[j]).sum();",
        _ => "let phi: [N] = |i| theta[i];",
    };
    let positions = match kind {
        Kind::FromCart => format!(
            "let x: [N] = |i| s + (0..i + 1).map(|j| {} * theta[j].sin()).sum();
             let y: [N] = |i| -(0..i + 1).map(|j| {} * theta[j].cos()).sum();",
            l.replace('i', "j"),
            l.replace('i', "j")
        ),
        _ => format!(
            "let x: [N] = |i| if i == 0 {{ {base} }} else {{ x[{parent}] }} + {l} * phi[i].sin();
             let y: [N] = |i| if i == 0 {{ 0 }} else {{ y[{parent}] }} - {l} * phi[i].cos();"
        ),
    };
    input(&format!(
        "lagrangian! {{
            pub system Links {{
                const N = {n};
                {parameters}
                {cart}
                coord theta: [N];
                {angle}
                {positions}
                T = {cart_energy} (0..N).map(|i| 0.5 * {m} * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                {acting}
                V = {springs} (0..N).map(|i| {m} * {g} * y[i]).sum();
            }}
        }}"
    ))
}

/// Numbers of links.
const LENGTHS: [usize; 7] = [3, 4, 6, 8, 12, 16, 32];

/// Operations by number of links, with unit masses and lengths and with parameters for them. An expert's link
/// tensions take 19 n − 8 by hand for unit masses and lengths, 22 n for angles with the link before, 20 n on a cart
/// and 29 n for a tree.
const KNOWN: [(Kind, [[usize; 7]; 2]); 5] = [
    (Kind::Absolute, [[47, 66, 104, 142, 218, 294, 598], [65, 92, 146, 196, 296, 396, 796]]),
    (Kind::Relative, [[53, 75, 119, 163, 251, 339, 691], [71, 101, 161, 217, 329, 441, 889]]),
    (Kind::Cart, [[58, 77, 115, 153, 229, 305, 609], [79, 103, 153, 203, 303, 403, 803]]),
    (Kind::FromCart, [[58, 77, 115, 153, 229, 305, 609], [79, 103, 153, 203, 303, 403, 803]]),
    (Kind::Tree, [[39, 81, 144, 204, 321, 438, 906], [54, 105, 182, 249, 392, 535, 1107]]),
];

#[test]
fn links_cost_what_they_cost_by_hand() {
    for (kind, known) in KNOWN {
        for (symbolic, known) in [false, true].into_iter().zip(known) {
            // Every second length, unless there is time. (Chains of 32 links are in the next test, too.)
            let (each, longest) = if *LONG { (1, 32) } else { (2, if symbolic { 6 } else { 12 }) };
            for (&n, known) in LENGTHS.iter().zip(known).step_by(each).take_while(|(n, _)| **n <= longest) {
                let (operations, _) = agreed("links", &solved(links(kind, n, symbolic)));
                assert_eq!((operations.sin_cos, operations.functions), (n, 0), "{kind:?}, {n} links");
                assert_eq!(operations.arithmetic(), known, "{kind:?}, {n} links, {symbolic}");
            }
        }
    }
}

/// A chain of 32 links, free and with what acts in its hinges, with unit masses and lengths and with parameters for
/// all but the springs.
#[test]
fn what_acts_in_hinges_costs_a_constant_a_link() {
    const BENT: &str = "let bent: [N] = |i| theta[i] - if i == 0 { 0 } else { theta[i - 1] };";
    let torques = "param tau: [N]; Q[theta] = tau;".to_string();
    let friction = |c: &str| format!("{BENT} D = (0..N).map(|i| 0.5 * {c} * dot(bent[i]).powi(2)).sum();");
    let springs = "(0..N).map(|i| 0.5 * bent[i].powi(2)).sum() +";
    let rows = [
        ("free", [String::new(), String::new()], "", [598, 796]),
        ("torques", [torques.clone(), torques], "", [878, 1105]),
        ("friction", [friction("1"), format!("param c: [N]; {}", friction("c[i]"))], "", [972, 1355]),
        ("springs", [BENT.to_string(), BENT.to_string()], springs, [972, 1324]),
    ];
    for (name, acting, springs, known) in rows {
        let cost = |symbolic: bool| {
            let definition = loaded(Kind::Absolute, 32, symbolic, [&acting[usize::from(symbolic)], springs]);
            agreed("links", &solved(definition)).0.arithmetic()
        };
        let found = [cost(false), cost(true)];
        println!("{name}: {found:?}, {:.1?} a link", found.map(|o| o as f64 / 32.0));
        assert_eq!(found, known, "{name}");
    }
}

/// Parallelograms side by side: n loops are closed by 2 n constraints, as a family or one by one.
#[test]
fn loops_cost_a_constant_each() {
    let cost = |n: usize, constraints: &str| {
        let text = format!(
            "lagrangian! {{
                pub system Loops {{
                    const N = {n};
                    param g = 9.81;
                    coord a: [N + 1], b: [N];
                    let x: [N] = |i| i + cos(a[i]) + 0.5 * cos(b[i]);
                    let y: [N] = |i| sin(a[i]) + 0.5 * sin(b[i]);
                    T = (0..N + 1).map(|i| dot(a[i]).powi(2)).sum() / 6
                        + (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2)) + dot(b[i]).powi(2) / 24).sum();
                    V = g * (0.5 * (0..N + 1).map(|i| sin(a[i])).sum() + (0..N).map(|i| y[i]).sum());
                    {constraints}
                }}
            }}"
        );
        agreed("loops", &solved(input(&text))).0.arithmetic()
    };
    let family = "constraint across: [N] = |i| cos(a[i]) + cos(b[i]) == cos(a[i + 1]) + 1;
                  constraint up: [N] = |i| sin(a[i]) + sin(b[i]) == sin(a[i + 1]);";
    let found = [1, 2, 3, 6, 12].map(|n| cost(n, family));
    println!("{found:?}");
    let by_hand =
        "constraint across: [cos(a[0]) + cos(b[0]), cos(a[1]) + cos(b[1])] == [cos(a[1]) + 1, cos(a[2]) + 1];
                   constraint up: [sin(a[0]) + sin(b[0]), sin(a[1]) + sin(b[1])] == [sin(a[1]), sin(a[2])];";
    assert_eq!(found[1], cost(2, by_hand));
    let (doubled, once) = (found[4] as f64, found[3] as f64);
    assert!(doubled <= 2.1 * once, "{found:?}");
}

/// However the terms of a position from the base on are grouped, a link costs what it costs when it is written from
/// the one before.
#[test]
fn groupings_of_sums_do_not_matter() {
    let cost = |x: &str, y: &str| {
        let text = format!(
            "lagrangian! {{
                pub system Links {{
                    const N = 12;
                    param l: [N];
                    coord s, theta: [N];
                    let x: [N] = |i| {x};
                    let y: [N] = |i| {y};
                    T = 0.5 * dot(s).powi(2) + (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                    V = (0..N).map(|i| 9.81 * y[i]).sum();
                }}
            }}"
        );
        solved(input(&text)).equations.solved.operations.arithmetic()
    };
    let by_links = cost(
        "if i == 0 { s } else { x[i - 1] } + l[i] * theta[i].sin()",
        "if i == 0 { 0 } else { y[i - 1] } - l[i] * theta[i].cos()",
    );
    let y = "-(0..i + 1).map(|j| l[j] * theta[j].cos()).sum()";
    for (name, x) in [
        ("base first", "s + (0..i + 1).map(|j| l[j] * theta[j].sin()).sum()"),
        ("base last", "(0..i + 1).map(|j| l[j] * theta[j].sin()).sum() + s"),
        ("from the end", "s + (0..i + 1).map(|j| l[i - j] * theta[i - j].sin()).sum()"),
        ("in one sum", "(0..i + 2).map(|j| if j == 0 { s } else { l[j - 1] * theta[j - 1].sin() }).sum()"),
        ("term by term", "(0..i + 1).map(|j| l[j] * theta[j].sin() + s / (i + 1)).sum()"),
    ] {
        let found = cost(x, y);
        println!("{name}: {found}, {by_links} from link to link");
        assert_eq!(found, by_links, "{name}");
    }
}

/// For profiles of the compiler: `LINKS=32 valgrind --tool=callgrind … expand_once --ignored`.
#[test]
#[ignore = "a measurement"]
fn expand_once() {
    let n: usize = std::env::var("LINKS").map_or(6, |n| n.parse().unwrap());
    let system = solved(links(Kind::Absolute, n, std::env::var("SYMBOLIC").is_ok()));
    drop(super::emit::emit(&system));
}

/// Statements that declare something, one scope within the other.
fn scopes(tokens: TokenStream) -> usize {
    let (mut own, mut within) = (0, 0);
    for tree in tokens {
        match tree {
            TokenTree::Ident(word) if word == "let" => own += 1,
            TokenTree::Group(group) => within = within.max(own + scopes(group.stream())),
            _ => {}
        }
    }
    within.max(own)
}

/// Some thousands of scopes overflow the stack of rustc, where it describes variables for debuggers.
#[test]
fn scopes_are_not_nested_without_end() {
    for (n, symbolic) in [(4, false), (40, false), (40, true), (100, true)] {
        let found = scopes(super::emit::emit(&solved(links(Kind::Absolute, n, symbolic))));
        println!("{n} links: {found} scopes");
        assert!(found < 1000, "{n} links: {found} scopes");
    }
}
