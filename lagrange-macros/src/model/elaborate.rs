//! Expressions to nodes: the only place that knows scope, and the meaning of Rust's words in the language.

mod calls;
mod control;
mod equality;
mod events;
mod frames;
mod operators;
mod statements;
mod submodels;
mod unknown;

use super::frames::Motion;
use super::submodel::{Held, Submodel, Variation};
use super::value::{Closure, Condition, Frame, IntegerType, Spin, Turn, Val};
use super::{
    Attitude, Binding, Bound, Constraint, Coordinate, Entry, External, FirstOrder, FunctionDefinition, Names,
    Observed, Parameter, Prescribed, Struck, indexed, is_function_of,
};
use crate::diagnostics::{Errors, Reported, did_you_mean, plain};
use crate::graph::function::TABLE;
use crate::graph::stable_map::IdMap;
use crate::graph::{Comparison, Function, Graph, Number, Symbol, Value};
use crate::syntax::spelling::has_known_suffix;
use crate::syntax::{Declaration, Header, Statement};
pub use calls::METHODS;
use equality::Equality;
use frames::{FUNCTIONS, ROTATIONS, Space};
use proc_macro2::{Ident, TokenStream, TokenTree};
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
pub(super) use submodels::Place;
use syn::{BinOp, Expr, Lit, Pat, UnOp};

/// Nodes that one system may make.
const MAX_NODES: usize = 400_000;
/// Expressions that may be evaluated while it is read.
const MAX_EXPRESSIONS: usize = 1_000_000;
/// Elements of arrays that may be made and copied while it is read.
const MAX_COPIED_ELEMENTS: usize = 4_000_000;
/// Expressions within expressions, and functions within functions.
const MAX_NESTED_EXPRESSIONS: usize = 96;

pub(super) type Result<T = Val> = std::result::Result<T, Reported>;

/// Expressions to nodes, statement by statement.
pub(super) struct Elaborator<'e> {
    pub errors: &'e mut Errors,
    /// The name of the system.
    pub system: String,
    pub graph: Graph,
    pub scope: Scope,
    pub found: Found,
    pub space: Space,
    /// The differences from the system as it was written.
    pub variation: Option<Variation<'e>>,
    /// Number of the coordinates that have been declared, those that are held included.
    pub declared: usize,
    /// Arrays of coordinates some of which are held, by their indices in the whole system.
    pub mixed: Vec<(String, Vec<usize>)>,
    /// Meanings of the numbers of the parameters of the whole system.
    pub numbers: Vec<Value>,
    /// Is this an output? Reactions are known only there.
    observing: bool,
    bound: Bound,
    /// Terms of bindings that are sums of two, by the binding and the other term.
    terms: Bound,
    /// Bindings that are sums, with all their terms.
    sums: Vec<(Value, Vec<Value>)>,
    /// Index in `sums` of the last one that has a node among its terms.
    sums_with: IdMap<usize>,
    depth: usize,
    steps: usize,
    elements: usize,
    /// Inside `[…]` an integer quotient is Rust's.
    indexing: bool,
    /// The family whose elements are being made.
    family: Option<String>,
    /// The binding that is being defined, for the names of what frames bind.
    naming: Option<String>,
    /// The place of what is being read, if kinetic energies have none there.
    not_kinetic: Option<&'static str>,
    /// Comparisons by `==` and `!=` of values that move.
    equalities: Vec<Equality>,
    over_budget: bool,
}

/// Meanings of names at a statement.
#[derive(Default)]
pub(super) struct Scope {
    pub names: Names,
    pub used: BTreeSet<String>,
    /// Constants of events.
    pub events: BTreeSet<String>,
    /// Names that some statement declares, wherever it stands.
    pub later: BTreeSet<String>,
    /// Names of inputs, which are no constants.
    pub inputs: BTreeSet<String>,
    /// Names of outputs, which no expression sees; not those that are observed by their names alone.
    pub outputs: BTreeSet<String>,
    /// Words of statements that could not be read: what they mean is not known, which has been reported.
    pub unread: BTreeMap<String, Ident>,
    /// Is there such a statement?
    pub incomplete: bool,
    pub functions: Vec<FunctionDefinition>,
    /// Arguments of functions and closures, the innermost last.
    pub locals: Vec<(String, Val)>,
    /// Functions being expanded.
    pub calls: Vec<usize>,
}

/// Results of the statements so far; `Model` explains each.
#[derive(Default)]
pub(super) struct Found {
    pub parameters: Vec<Parameter>,
    pub coordinates: Vec<Coordinate>,
    pub states: Vec<FirstOrder>,
    pub attitudes: Vec<Attitude>,
    pub bindings: Vec<Binding>,
    pub prescribed: Vec<Prescribed>,
    pub constraints: Vec<Constraint>,
    pub externals: Vec<External>,
    /// T, V, L, D
    pub energies: [Option<(Ident, Value)>; 4],
    pub applied: Vec<Option<Value>>,
    pub forces: Vec<(Value, Value)>,
    pub frame_forces: Vec<(Value, Value)>,
    pub moved: Vec<Value>,
    /// Definitions of frames, and energies.
    pub written: Vec<(String, TokenStream)>,
    pub framed: bool,
    pub observed: Vec<Observed>,
    pub events: Vec<super::NamedEvent>,
    pub struck: Vec<Struck>,
    pub routhian: Option<Header>,
    pub submodels: Vec<Submodel>,
    pub held: Vec<Held>,
}

impl<'e> Elaborator<'e> {
    pub fn new(errors: &'e mut Errors, system: &Ident, variation: Option<Variation<'e>>) -> Self {
        Elaborator {
            errors,
            system: system.to_string(),
            graph: Graph::default(),
            scope: Scope::default(),
            found: Found::default(),
            space: Space::default(),
            variation,
            declared: 0,
            mixed: Vec::new(),
            numbers: Vec::new(),
            observing: false,
            bound: Bound::default(),
            terms: Bound::default(),
            sums: Vec::new(),
            sums_with: IdMap::default(),
            depth: 0,
            steps: 0,
            elements: 0,
            indexing: false,
            family: None,
            naming: None,
            not_kinetic: None,
            equalities: Vec::new(),
            over_budget: false,
        }
    }

    pub fn exhausted(&self) -> bool {
        self.over_budget
    }

    pub fn define(&mut self, name: &Ident, entry: Entry) {
        let text = name.to_string();
        if let Some(message) = reserved(&text) {
            self.errors.push(name, message);
        } else if self.scope.names.contains_key(&text) {
            self.errors.push(name, format!("`{text}` is defined twice\nhelp: give one of them another name"));
        }
        self.scope.names.insert(text, (name.clone(), entry));
    }

    pub fn check_arguments(&mut self, arguments: &[Ident]) {
        for (i, argument) in arguments.iter().enumerate() {
            if arguments[..i].contains(argument) {
                self.errors.push(
                    argument,
                    format!("two arguments are called `{argument}`\nhelp: give one of them another name"),
                );
            }
        }
    }

    // Values of a kind.

    /// The declared length of an array.
    pub fn length(&mut self, d: &Declaration) -> Result<Option<usize>> {
        let Some(expression) = &d.length else { return Ok(None) };
        match usize::try_from(self.whole(expression)?) {
            Ok(n @ 1..=10_000) => Ok(Some(n)),
            Ok(0) => Err(self.errors.push(
                expression,
                "an array of no elements\nhelp: a length is an integer from 1, or a `const`",
            )),
            _ => {
                let message =
                    "this is no length\nhelp: a length is an integer between 1 and 10000, or a `const`";
                Err(self.errors.push(expression, message))
            }
        }
    }

    /// A compile-time integer.
    pub fn whole(&mut self, expression: &Expr) -> Result<i64> {
        let val = self.evaluate(expression)?;
        self.known(val, expression)
    }

    fn known(&mut self, val: Val, expression: &Expr) -> Result<i64> {
        match val.integer_of(IntegerType::USIZE) {
            Some(n) => Ok(n),
            None => {
                let message = format!(
                    "expected an integer that is known at compile time, found {}\nhelp: write an integer such as `3`, or the name of a `const`",
                    val.kind()
                );
                Err(self.errors.push(expression, message))
            }
        }
    }

    /// Defaults of a parameter: constants.
    pub fn defaults(&mut self, expression: &Expr, length: Option<usize>) -> Result<Vec<f64>> {
        let val = self.evaluate(expression)?;
        let vals = match (val, length) {
            (Val::Array(items), Some(n)) if items.len() == n => items,
            (Val::Array(items), _) => {
                let message = format!(
                    "expected {}, found an array of {}",
                    length.map_or("a number".into(), |n| format!("an array of {n}")),
                    items.len()
                );
                return Err(self.errors.push(expression, message));
            }
            (scalar, n) => vec![scalar; n.unwrap_or(1)],
        };
        let mut numbers = Vec::new();
        for val in vals {
            let value = self.number(val, expression)?;
            if !value.is_constant() && !self.graph.symbols(&[value]).is_empty() {
                let help = match self.graph.depends(&[value], |s| s == Symbol::Time) {
                    true => "a function of time is `let name = …;`",
                    false => "a number that follows from parameters is `let name = …;`",
                };
                return Err(self.errors.push(expression, format!("a default is a constant\nhelp: {help}")));
            }
            let number = self.graph.evaluate(&[value], |_| f64::NAN)[0];
            if !number.is_finite() {
                let message = format!("this default is {number}\nhelp: a default is a finite number");
                return Err(self.errors.push(expression, message));
            }
            numbers.push(number);
        }
        Ok(numbers)
    }

    /// The parts of `name` or `name[index]`: the name as an expression, the index, and the entry of the scope that
    /// the name has.
    fn named<'x>(&self, expression: &'x Expr) -> (&'x Expr, Option<&'x Expr>, Option<Entry>) {
        let (base, index) = match expression {
            Expr::Index(index) => (&*index.expr, Some(&*index.index)),
            other => (other, None),
        };
        let name = match base {
            Expr::Path(path) => path.path.get_ident(),
            _ => None,
        };
        let known = name.and_then(|name| self.scope.names.get(&name.to_string()));
        (base, index, known.map(|(_, entry)| entry.clone()))
    }

    fn index(&mut self, expression: &Expr, length: usize) -> Result<usize> {
        let before = std::mem::replace(&mut self.indexing, true);
        let i = self.evaluate(expression);
        self.indexing = before;
        let i = i?;
        match i.integer_of(IntegerType::USIZE) {
            Some(i) if usize::try_from(i).is_ok_and(|i| i < length) => Ok(i as usize),
            Some(i) => Err(self.errors.push(
                expression,
                match length {
                    0 => format!("index {i} is out of range: this array has no elements"),
                    1 => format!("index {i} is out of range: this array has one element\nhelp: its index is 0"),
                    _ => format!(
                        "index {i} is out of range: this array has {length} elements\nhelp: their indices are 0 to {}",
                        length - 1
                    ),
                },
            )),
            None => {
                let message = match expression {
                    Expr::Range(syn::ExprRange { start: Some(start), end: Some(end), .. }) => {
                        let (start, end) = (plain(start), plain(end));
                        format!(
                            "an index is one integer, not a range\nhelp: a part of an array is `({start}..{end}).map(|i| x[i])`"
                        )
                    }
                    _ => format!(
                        "an index is an integer that is known at compile time, not {}\nhelp: in `(0..N).map(|i| …)` it is `i`",
                        i.kind()
                    ),
                };
                Err(self.errors.push(expression, message))
            }
        }
    }

    /// An expression that must be a number.
    pub fn scalar(&mut self, expression: &Expr) -> Result<Value> {
        let val = self.evaluate(expression)?;
        self.number(val, expression)
    }

    fn number(&mut self, val: Val, at: impl ToTokens) -> Result<Value> {
        match val {
            Val::Int(n) => Ok(Value::constant(n)),
            Val::Number(value) => Ok(value),
            other => {
                let rate = at.to_token_stream();
                let help = match other {
                    Val::Array(items) if items.len() == 3 && is_rate(&rate) => {
                        let message = format!(
                            "expected a number, found an array of 3\nhelp: take a component, `{0}[0]`, or the square of its length, `{0}.norm_squared()`",
                            plain(&rate)
                        );
                        return Err(self.errors.push(rate, message));
                    }
                    Val::Array(_) => "\nhelp: take an element, `x[0]`, or the sum over them, `x.sum()`",
                    Val::Frame(_) => {
                        "\nhelp: a point of a frame is `link.point([x, y, z])`, its origin `link.origin()`"
                    }
                    Val::Rotation(_) => {
                        "\nhelp: a rotation turns frames, `frame(parent, [x, y, z], rotation)`, and vectors, `rotation * [x, y, z]`: its matrix has the columns `rotation * [1, 0, 0]`, …"
                    }
                    Val::Closure(_) => {
                        "\nhelp: the absolute value is `abs(x)`; a function is `fn name(x) = …;`, and is called, `name(x)`"
                    }
                    Val::Tuple(_) => {
                        "\nhelp: take a part of it, `x.0`; an array is `[a, b]`; a decimal fraction is written with a point, `0.5`"
                    }
                    Val::Reference(_) => {
                        "\nhelp: remove the `&`; the value that a reference `x` refers to is `*x`"
                    }
                    Val::Typed(..) => "\nhelp: write it without a type, `3`, or convert it, `3u8 as f64`",
                    _ => "\nhelp: a number that depends on a condition is `if … { … } else { … }`",
                };
                Err(self.errors.push(at, format!("expected a number, found {}{help}", other.kind())))
            }
        }
    }

    // Expressions.

    pub fn evaluate(&mut self, expression: &Expr) -> Result {
        self.steps += 1;
        if self.over_budget {
            return Err(Reported);
        }
        if self.steps > MAX_EXPRESSIONS || self.graph.len() > MAX_NODES {
            self.over_budget = true;
            let nodes = self.graph.len();
            let what = if nodes > MAX_NODES {
                format!("more than {MAX_NODES} nodes ({nodes} so far)")
            } else {
                format!("more than {MAX_EXPRESSIONS} expressions ({} so far, {nodes} nodes)", self.steps)
            };
            let message = format!(
                "this system expands to {what}\nhelp: fewer elements, or `let` bindings for what repeats"
            );
            return Err(self.errors.push(expression, message));
        }
        if self.depth > MAX_NESTED_EXPRESSIONS {
            return Err(self
                .errors
                .push(expression, "this expression is nested too deeply\nhelp: name its parts with `let`"));
        }
        self.depth += 1;
        let val = self.expression(expression);
        self.depth -= 1;
        if let Ok(Val::Number(value)) = &val
            && !value.k.is_finite()
        {
            let message = "this constant overflows\nhelp: numbers are below 1.8e308";
            return Err(self.errors.push(expression, message));
        }
        // A node that has been bound is written with its binding.
        if let Ok(Val::Number(Value { k, node: Some(node) })) = val
            && let Some(&symbol) = self.bound.get(&node)
        {
            return Ok(Val::Number(symbol.scaled(k)));
        }
        val
    }

    fn expression(&mut self, expression: &Expr) -> Result {
        match expression {
            Expr::Lit(lit) => self.literal(lit),
            Expr::Path(path) => self.path(path),
            Expr::Paren(inner) => self.evaluate(&inner.expr),
            Expr::Group(inner) => self.evaluate(&inner.expr),
            Expr::Reference(syn::ExprReference { mutability: Some(mutable), .. }) => {
                Err(self.errors.push(mutable, "nothing is changed by an expression\nhelp: remove `mut`"))
            }
            Expr::Reference(inner) => Ok(control::reference(self.evaluate(&inner.expr)?)),
            Expr::Unary(unary) => {
                let val = self.evaluate(&unary.expr)?;
                match (&unary.op, val) {
                    (UnOp::Neg(_), val) => self.negated(val.referred(), &unary.expr),
                    (UnOp::Not(_), Val::Bool(b)) => Ok(Val::Bool(!b)),
                    (UnOp::Not(_), Val::Condition(c)) => Ok(Val::Condition(Rc::new(Condition::Not(c)))),
                    (UnOp::Deref(_), Val::Reference(val)) => Ok(Rc::unwrap_or_clone(val)),
                    (UnOp::Deref(star), other) => {
                        let message = format!(
                            "a `*` without a left side follows a reference, and this is {}\nhelp: remove it; a power is `x.powi(2)`",
                            other.kind()
                        );
                        Err(self.errors.push(star, message))
                    }
                    (_, other) => {
                        let message = format!(
                            "`!` negates conditions, and this is {}\nhelp: a comparison is a condition, `!({} > 0)`",
                            other.kind(),
                            plain(&unary.expr)
                        );
                        Err(self.errors.push(unary, message))
                    }
                }
            }
            Expr::Binary(_) => self.chain(expression),
            Expr::Call(call) => self.function_call(call),
            Expr::MethodCall(call) => self.method_call(call),
            Expr::Index(index) => self.element(index),
            Expr::Array(array) => {
                let items = array.elems.iter().map(|e| self.evaluate(e)).collect::<Result<_>>()?;
                self.list(items, array)
            }
            Expr::Tuple(tuple) => {
                Ok(Val::Tuple(tuple.elems.iter().map(|e| self.evaluate(e)).collect::<Result<_>>()?))
            }
            Expr::Repeat(repeat) => {
                let item = self.evaluate(&repeat.expr)?;
                let n = self.evaluate(&repeat.len)?;
                if let Val::Number(_) = n {
                    let (first, second) = (plain(&repeat.expr), plain(&repeat.len));
                    let message = format!(
                        "`[x; n]` repeats an element, and this is no number of elements\nhelp: an array is `[{first}, {second}]`"
                    );
                    return Err(self.errors.push(&repeat.len, message));
                }
                let n = self.known(n, &repeat.len)?;
                let n = self.count(n, &repeat.len)?;
                self.spend(n.saturating_mul(item.size()), repeat)?;
                Ok(Val::Array(vec![item; n]))
            }
            Expr::Range(range) => self.range(range),
            Expr::Closure(closure) if closure.asyncness.is_some() || closure.lifetimes.is_some() => {
                let message = "this kind of closure is not part of the language\nhelp: write `|x| …`";
                Err(self.errors.push(closure, message))
            }
            Expr::Closure(closure) => {
                let expression = Rc::new(closure.clone());
                Ok(Val::Closure(Rc::new(Closure { expression, scope: self.scope.locals.clone() })))
            }
            Expr::If(conditional) => self.conditional(conditional),
            Expr::Block(syn::ExprBlock { label: Some(label), .. }) => {
                Err(self.errors.push(label, "nothing leaves a block early\nhelp: remove this label"))
            }
            Expr::Block(block) => self.block(&block.block),
            Expr::Cast(cast) => self.cast(cast),
            Expr::Field(field) => match (&field.member, self.evaluate(&field.base)?.dereferenced()) {
                (syn::Member::Unnamed(i), Val::Tuple(items)) if (i.index as usize) < items.len() => {
                    Ok(items[i.index as usize].clone())
                }
                (member, Val::Rotation(_)) => Err(self.field_of_rotation(member)),
                (syn::Member::Named(name), base) => Err(self.unknown_field(name, &base, &field.base)),
                _ => Err(self.errors.push(&field.member, "there is no such field\nhelp: tuples have the fields `.0`, `.1` and so on; an element of an array is `x[0]`")),
            },
            other => Err(self.not_of_the_language(other)),
        }
    }

    /// Expressions of Rust that are none of the language.
    fn not_of_the_language(&mut self, expression: &Expr) -> Reported {
        match expression {
            Expr::Assign(assign) => self
                .errors
                .push(assign.eq_token, "nothing is assigned in an expression\nhelp: to compare, write `==`"),
            Expr::Macro(mac) => self.errors.push(
                mac,
                "macros are not expanded inside a system\nhelp: write the expression out, or define a function, `fn name(x) = …;`",
            ),
            Expr::ForLoop(_) | Expr::While(_) | Expr::Loop(_) => self.errors.push(
                expression,
                "a loop has no value\nhelp: a sum over a range is `(0..N).map(|i| …).sum()`; an array is `let x: [N] = |i| …;`",
            ),
            Expr::Try(_) => self.errors.push(
                expression,
                "`?` does not choose\nhelp: a number that depends on a condition is `if x < 0 { … } else { … }`",
            ),
            Expr::Match(_) => self.errors.push(
                expression,
                "`match` is not part of the language\nhelp: a number that depends on a condition is `if … { … } else { … }`",
            ),
            Expr::Struct(call) if call.path.get_ident().is_some_and(|name| self.is_call_in_brackets(name)) => {
                let braces = call.to_token_stream().into_iter().last();
                let argument = match &braces {
                    Some(TokenTree::Group(group)) => plain(group.stream()),
                    _ => "x".into(),
                };
                let Some(name) = call.path.get_ident() else { return Reported };
                self.call_in_brackets(name, &argument, "braces")
            }
            Expr::Return(value) => {
                let help = value.expr.as_ref().map_or_else(|| "…".into(), plain);
                let message =
                    format!("nothing returns: a block ends in its value\nhelp: write `{help}`");
                self.errors.push(value.return_token, message)
            }
            other => self.errors.push(
                other,
                "this kind of expression is not part of the language\nhelp: write it with numbers, names, operators, functions and `if … { … } else { … }`",
            ),
        }
    }

    /// Elements of one kind.
    fn list(&mut self, items: Vec<Val>, at: impl ToTokens) -> Result {
        match items.iter().skip(1).find(|item| !item.is_like(&items[0])) {
            None => Ok(Val::Array(items)),
            Some(other) => {
                let message = format!(
                    "the elements of a list are of one kind, and these are {} and {}\nhelp: several kinds are a tuple, `(a, b)`",
                    items[0].kind(),
                    other.kind()
                );
                Err(self.errors.push(at, message))
            }
        }
    }

    fn literal(&mut self, lit: &syn::ExprLit) -> Result {
        if !has_known_suffix(&lit.lit) {
            // Found among the tokens of the statement.
            return Err(Reported);
        }
        match &lit.lit {
            Lit::Int(int) => match int.base10_parse::<i64>() {
                Ok(n) if int.suffix() == "f64" => Ok(Val::Number(Value::constant(n))),
                Ok(n) => match IntegerType::named(int.suffix()) {
                    Some(ty) if ty.holds(n) => Ok(Val::Typed(n, ty)),
                    Some(ty) => {
                        Err(self.errors.push(lit, format!("this literal overflows its type `{}`", ty.name())))
                    }
                    None => Ok(Val::Int(n)),
                },
                Err(_) if IntegerType::named(int.suffix()).is_some() => Err(self.errors.push(lit, OVERFLOW)),
                Err(_) => match Number::parse(int.base10_digits()) {
                    Some(k) => Ok(Val::Number(Value { k, node: None })),
                    None => Err(self.errors.push(lit, OVERFLOW)),
                },
            },
            Lit::Float(float) => match Number::parse(float.base10_digits()) {
                Some(k) if k.is_zero() => Ok(Val::Number(Value::ZERO)),
                Some(k) => Ok(Val::Number(Value { k, node: None })),
                None => Err(self.errors.push(lit, OVERFLOW)),
            },
            Lit::Bool(b) => Ok(Val::Bool(b.value)),
            _ => Err(self.errors.push(lit, "expected a number\nhelp: write it in digits, such as `9.81`")),
        }
    }

    fn path(&mut self, path: &syn::ExprPath) -> Result {
        if let Some(name) = path.path.get_ident() {
            return self.name(name);
        }
        let segments: Vec<String> =
            path.path.segments.iter().map(|s| s.to_token_stream().to_string()).collect();
        let segments: Vec<&str> = segments.iter().map(String::as_str).collect();
        let constant = match segments.as_slice() {
            ["std" | "core", "f64", "consts", name] | ["f64", "consts", name] | ["consts", name]
                if path.qself.is_none() =>
            {
                constant(name)
            }
            _ => None,
        };
        match constant {
            Some(x) => Ok(Val::Number(x)),
            None => Err(self.errors.push(
                path,
                match segments.last() {
                    Some(&"PI" | &"pi" | &"Pi") => "unknown constant\nhelp: this number is `PI`",
                    _ => "unknown constant\nhelp: constants are those of `f64::consts`, such as `f64::consts::PI`",
                },
            )),
        }
    }

    fn name(&mut self, name: &Ident) -> Result {
        let text = name.to_string();
        if let Some((_, val)) = self.scope.locals.iter().rev().find(|(local, _)| *local == text) {
            let (val, size) = (val.clone(), val.size());
            self.spend(size, name)?;
            return Ok(val);
        }
        self.scope.used.insert(text.clone());
        let symbols =
            |g: &mut Graph, symbol: fn(usize) -> Symbol, first: usize, length: Option<usize>| match length {
                None => Val::Number(g.symbol(symbol(first))),
                Some(n) => Val::Array((first..first + n).map(|i| Val::Number(g.symbol(symbol(i)))).collect()),
            };
        let entry = self.scope.names.get(&text).map(|(_, entry)| entry.clone());
        let size = match &entry {
            Some(Entry::Let(val) | Entry::Prescribed(val)) => val.size(),
            Some(Entry::Parameter(i)) => self.found.parameters[*i].numbers().len(),
            Some(
                Entry::Coordinate { length, .. }
                | Entry::Mixed { length, .. }
                | Entry::State { length, .. }
                | Entry::Rotation { length, .. },
            ) => length.unwrap_or(1),
            _ => 1,
        };
        self.spend(size, name)?;
        match entry {
            Some(Entry::Const(n)) => Ok(Val::Int(n)),
            Some(Entry::Parameter(i)) => {
                let Parameter { first, length, rotation, .. } = self.found.parameters[i];
                if rotation {
                    let sigma = [0, 1, 2].map(|k| self.graph.symbol(Symbol::Parameter(first + k)));
                    return Ok(frames::fixed(&mut self.graph, sigma));
                }
                Ok(symbols(&mut self.graph, Symbol::Parameter, first, length))
            }
            Some(Entry::Coordinate { first, length }) => {
                Ok(symbols(&mut self.graph, Symbol::Coordinate, first, length))
            }
            Some(Entry::Mixed { places, length }) => {
                let mut all: Vec<Val> = places.into_iter().map(|place| self.placed(place)).collect();
                Ok(if length.is_none() { all.remove(0) } else { Val::Array(all) })
            }
            Some(Entry::State { first, length }) => {
                Ok(symbols(&mut self.graph, Symbol::Velocity, first, length))
            }
            Some(Entry::Rotation { first, length: None }) => Ok(self.space.attitude(first)),
            Some(Entry::Rotation { first, length: Some(n) }) => {
                Ok(Val::Array((first..first + n).map(|i| self.space.attitude(i)).collect()))
            }
            Some(Entry::Let(val) | Entry::Prescribed(val)) => Ok(val),
            Some(Entry::Broken) => Err(Reported),
            Some(Entry::Function(_) | Entry::External(_)) => {
                Err(self.errors.push(name, format!("`{text}` is a function\nhelp: call it, `{text}(…)`")))
            }
            Some(Entry::Constraint { .. }) => {
                let message = format!(
                    "`{text}` is a constraint\nhelp: its multiplier, which is observed, is `reaction({text})`"
                );
                Err(self.errors.push(name, message))
            }
            None if text == "world" => Ok(Val::Frame(Frame::World)),
            None if text == "t" => Ok(Val::Number(self.graph.symbol(Symbol::Time))),
            None if text == "PI" => Ok(Val::Number(pi())),
            None => Err(self.unknown_name(name)),
        }
    }

    fn negated(&mut self, val: Val, at: &Expr) -> Result {
        match val {
            Val::Int(_) | Val::Typed(..) => {
                let (n, ty) = val.integer().unwrap_or_default();
                self.integer_in(n.checked_neg(), ty, at)
            }
            Val::Number(value) => Ok(Val::Number(-value)),
            Val::Array(items) => {
                Ok(Val::Array(items.into_iter().map(|v| self.negated(v, at)).collect::<Result<_>>()?))
            }
            other => Err(self.errors.push(at, format!("expected a number, found {}", other.kind()))),
        }
    }
}

const OVERFLOW: &str = "this literal overflows\nhelp: numbers are below 1.8e308";

/// Arguments of a method of numbers.
fn method_arity(name: &str) -> usize {
    match name {
        "powi" | "min" | "max" => 1,
        "mul_add" | "clamp" => 2,
        _ => Function::named(name).map_or(0, |f| f.row().arguments.len() - 1),
    }
}

/// `3 forces`, `1 force`
fn counted(n: usize, what: &str) -> String {
    if n == 1 { format!("1 {what}") } else { format!("{n} {what}s") }
}

fn is_method(name: &str) -> bool {
    METHODS.contains(&name) || Function::named(name).is_some()
}

/// Is this `dot(…)`?
fn is_rate(tokens: &TokenStream) -> bool {
    let mut tokens = tokens.clone().into_iter();
    let called = matches!(tokens.next(), Some(TokenTree::Ident(word)) if word == "dot");
    called && matches!(tokens.next(), Some(TokenTree::Group(_))) && tokens.next().is_none()
}

fn is_literal(expression: &Expr) -> bool {
    match expression {
        Expr::Lit(_) => true,
        Expr::Paren(inner) => is_literal(&inner.expr),
        Expr::Unary(inner) => is_literal(&inner.expr),
        _ => false,
    }
}

fn pi() -> Value {
    constant("PI").expect("is one")
}

fn constant(name: &str) -> Option<Value> {
    Number::named(name).map(|k| Value { k, node: None })
}

/// Names that mean something in every system, beside elementary functions.
pub const RESERVED: [(&str, &str); 3] =
    [("t", "is time"), ("dot", "is the time derivative"), ("reaction", "gives the force of a constraint")];

/// Names that mean something already.
fn reserved(name: &str) -> Option<String> {
    let is = match RESERVED.iter().find(|(word, _)| *word == name) {
        Some((_, is)) => is,
        None if is_method(name) => "is an elementary function",
        None => return None,
    };
    Some(format!("`{name}` {is}\nhelp: choose another name"))
}

pub(super) fn numbers(val: &Val) -> Vec<Value> {
    match val {
        Val::Int(n) => vec![Value::constant(*n)],
        Val::Number(value) => vec![*value],
        Val::Array(items) | Val::Tuple(items) => items.iter().flat_map(numbers).collect(),
        Val::Reference(val) => numbers(val),
        _ => Vec::new(),
    }
}
