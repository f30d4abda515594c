//! Chains and trees of links: what their accelerations cost, by number of links.

use super::{arithmetic::agreed, input, solved};
use proc_macro2::{TokenStream, TokenTree};

/// Which links, with unit masses and lengths or with parameters for them.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Kind {
    /// A chain by the angles of the links with the vertical,
    Absolute,
    /// or with the link before,
    Relative,
    /// on a cart,
    Cart,
    /// the same with each position written as a sum from the cart on,
    FromCart,
    /// and a binary tree: link i hangs on link (i − 1)/2.
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

const KINDS: [Kind; 5] = [Kind::Absolute, Kind::Relative, Kind::Cart, Kind::FromCart, Kind::Tree];

/// The operations that a link may cost with unit masses and lengths: what an expert's hand-written link tensions need, and
/// a little more where a branch or a cart is to be paid for.
fn most(kind: Kind, n: usize) -> usize {
    match kind {
        Kind::Absolute => 19 * n - 8,
        Kind::Relative => 22 * n,
        Kind::Cart | Kind::FromCart => 20 * n,
        Kind::Tree => 29 * n,
    }
}

#[test]
fn links_cost_what_they_cost_by_hand() {
    for symbolic in [false, true] {
        for kind in KINDS {
            let costs = [3, 4, 6, 8, 12, 16, 32].map(|n| {
                let (operations, _) = agreed("links", &solved(links(kind, n, symbolic)));
                let o = operations.arithmetic();
                println!("{n:2} links, {kind:?}, {}: {o}", if symbolic { "symbolic" } else { "unit" });
                assert!(symbolic || o <= most(kind, n), "{kind:?}, {n} links: {operations:?}");
                assert_eq!((operations.sin_cos, operations.functions), (n, 0), "{kind:?}, {n} links");
                (n, o)
            });
            for (n, o) in costs.into_iter().filter(|c| c.0 >= 8) {
                // A tree costs the same for each link from 8 on, less what its root does not need: of 8 links that is a sixth, which 16
                // save but once. So twice as many cost up to 2.15 times as much.
                if kind == Kind::Tree {
                    assert_eq!(4 * o, if symbolic { 143 * n - 148 } else { 117 * n - 120 }, "{n} links");
                    continue;
                }
                let Some((_, twice)) = costs.into_iter().find(|c| c.0 == 2 * n) else { continue };
                assert!(10 * twice <= 21 * o, "{kind:?}: {o} for {n}, {twice} for twice as many");
            }
        }
    }
}

/// A chain of 32 links, free and with what acts in its hinges, with unit masses and lengths and with parameters for all but the springs.
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

/// However the terms of a position from the base on are grouped, a link costs what it costs when it is written from the one before.
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
