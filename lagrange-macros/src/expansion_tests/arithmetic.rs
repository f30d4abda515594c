//! Operations of emitted code, counted in its tokens: a second opinion on `program/count.rs`, which counts in programs.

use super::{emit, file, input, reduced, solved, systems};
use crate::equations::Derived;
use crate::graph::Function;
use crate::program::count::Operations;
use proc_macro2::TokenStream;
use quote::ToTokens;
use std::collections::BTreeSet;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr};

/// Operations of a function body, as it is written.
#[derive(Default)]
struct Counter {
    count: Operations,
    /// Multiplications of a name by a constant that have been written before, up to the sign.
    repeated: usize,
    scaled: BTreeSet<(String, String)>,
}

/// The constant of `S::from_f64(±k)` or `S::from_sum(±k, rest)`, without its sign.
fn constant(e: &Expr) -> Option<String> {
    match e {
        Expr::Paren(inner) => constant(&inner.expr),
        Expr::Unary(minus) => constant(&minus.expr),
        Expr::Lit(lit) => Some(lit.to_token_stream().to_string()),
        Expr::Call(call)
            if matches!(
                call.func.to_token_stream().to_string().as_str(),
                "S :: from_f64" | "S :: from_sum"
            ) =>
        {
            constant(&call.args[0])
        }
        _ => None,
    }
}

/// An operand without its sign and its parentheses.
fn bare(e: &Expr) -> String {
    match e {
        Expr::Paren(inner) => bare(&inner.expr),
        Expr::Unary(minus) => bare(&minus.expr),
        _ => e.to_token_stream().to_string(),
    }
}

impl Counter {
    fn product(&mut self, a: &Expr, b: &Expr) {
        self.count.multiplications += 1;
        let scaling = match (constant(a), constant(b)) {
            (Some(k), None) => (k, bare(b)),
            (None, Some(k)) => (k, bare(a)),
            _ => return,
        };
        self.repeated += usize::from(!self.scaled.insert(scaling));
    }
}

impl Visit<'_> for Counter {
    fn visit_expr_binary(&mut self, e: &syn::ExprBinary) {
        match e.op {
            BinOp::Add(_) | BinOp::Sub(_) => self.count.additions += 1,
            BinOp::Mul(_) => self.product(&e.left, &e.right),
            BinOp::Div(_) => self.count.divisions += 1,
            _ => panic!("{}", e.to_token_stream()),
        }
        visit::visit_expr_binary(self, e);
    }

    fn visit_expr_method_call(&mut self, e: &syn::ExprMethodCall) {
        match e.method.to_string().as_str() {
            "mul_add" => {
                self.product(&e.receiver, &e.args[0]);
                self.count.additions += 1;
            }
            "sin_cos" | "sin" | "cos" => self.count.sin_cos += 1,
            name => {
                assert!(Function::named(name).is_some(), "{name}");
                self.count.functions += 1;
            }
        }
        visit::visit_expr_method_call(self, e);
    }

    fn visit_expr_call(&mut self, e: &syn::ExprCall) {
        match e.func.to_token_stream().to_string().as_str() {
            "S :: one" | "S :: zero" | "S :: from_f64" | "S :: from_sum" => {}
            // A comparison and a choice cost an addition.
            "S :: select" => self.count.additions += 1,
            "S :: sin_cos_array" => match &e.args[0] {
                Expr::Array(angles) => self.count.sin_cos += angles.elems.len(),
                other => panic!("{}", other.to_token_stream()),
            },
            name if name.starts_with(":: lagrange_runtime") => {}
            // A function of the user's.
            _ => self.count.functions += 1,
        }
        visit::visit_expr_call(self, e);
    }
}

/// The operations of `accel` as emitted.
fn written(items: TokenStream) -> Counter {
    struct Find(Option<syn::Block>);
    impl Visit<'_> for Find {
        fn visit_impl_item_fn(&mut self, f: &syn::ImplItemFn) {
            if f.sig.ident == "accel_inlined" {
                self.0 = Some(f.block.clone());
            }
        }
    }
    let mut find = Find(None);
    find.visit_file(&file(items));
    let mut counter = Counter::default();
    counter.visit_block(&find.0.expect("accel is emitted"));
    counter
}

/// Asserts that the two counts agree; returns what is claimed and the number of scalings that are written again.
pub(super) fn agreed(name: &str, system: &Derived) -> (Operations, usize) {
    let claimed = system.equations.solved.operations;
    let Counter { mut count, repeated, .. } = written(emit::emit(system));
    count.multiplications -= repeated;
    count.path = claimed.path;
    assert_eq!(count, claimed, "{name}, with {repeated} repeated scalings");
    (claimed, repeated)
}

#[test]
fn tokens_cost_what_the_graph_says() {
    for (name, input) in systems() {
        let system = solved(input);
        let reduced = reduced(&system);
        for system in [&system].into_iter().chain(&reduced) {
            let (_, repeated) = agreed(&name, system);
            println!("{name}: {repeated} scalings repeated");
        }
    }
}

/// n bobs of unit mass on unit links, by their positions.
pub(super) fn chain(n: usize) -> TokenStream {
    input(&format!(
        "lagrangian! {{
            pub system Chain {{
                const N = {n};
                coord theta: [N];
                let x: [N] = |i| (0..i + 1).map(|j| theta[j].sin()).sum();
                let y: [N] = |i| -(0..i + 1).map(|j| theta[j].cos()).sum();
                T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                V = (0..N).map(|i| 9.81 * y[i]).sum();
            }}
        }}"
    ))
}

/// Long functions are cut into parts, short ones are not.
#[test]
fn long_lines_are_cut() {
    let cuts = |n: usize| emit::emit(&solved(chain(n))).to_string().matches("cut ()").count();
    assert_eq!([1, 8].map(cuts), [0, 0]);
    let long = cuts(120);
    assert!(long >= 12, "{long}");
}

#[test]
fn chains_cost_as_much_as_is_known() {
    for (n, known) in [(2, 24), (3, 47), (4, 66), (6, 104), (8, 142)] {
        let (operations, repeated) = agreed("chain", &solved(chain(n)));
        println!("{n} links: {operations:?}, {repeated} scalings repeated");
        let found = [operations.arithmetic(), operations.sin_cos, operations.functions];
        assert_eq!(found, [known, n, 0], "{n} links");
    }
}
