//! A program as Rust over `S: Scalar`.
//!
//! It is written as text, and read once by the compiler's own lexer: bodies are most of what is emitted, and macros are
//! built without optimisation, so that tokens made one by one would take several times as long. The path of the runtime keeps
//! its spans: a name in its place stands for it until then.

use crate::graph::{
    Coefficient, Comparison, Graph, Id, Node, Number, Symbol, Value,
    stable_map::{IdMap, StableMap},
};
use crate::model::Model;
use crate::schedule::{Circular, Program, Step};
use crate::table::OUTPUTS;
use proc_macro2::{Group, TokenStream, TokenTree};
use std::collections::BTreeSet;
use std::fmt::{Display, Write};
use std::ops::Range;

/// Stands for the path of the runtime. That this is not ASCII is seen sooner than where in a text it is.
pub const RUNTIME: &str = "ℓ_runtime";

/// Names in emitted functions beside those of arguments and of the recurrences.
const VARIABLES: [&str; 8] = ["given", "constants", "self", "S", "Self", "at", "each", "impulse"];

/// Names of symbols and of the user's bindings in emitted functions.
pub struct Names {
    runtime: TokenStream,
    /// Variable and field.
    parameters: Vec<(String, String)>,
    coordinates: Vec<String>,
    velocities: Vec<String>,
    momenta: Vec<String>,
    given: Vec<String>,
    sides: Vec<String>,
    /// Functions through which those of the user's are called.
    externals: Vec<String>,
    /// What the user called the value of a node.
    bindings: IdMap<String>,
    taken: BTreeSet<String>,
}

impl Names {
    /// `bindings` are nodes with the names of the user's bindings.
    pub fn new(model: &Model, bindings: &[(String, Value)], switches: usize) -> Names {
        let arguments = OUTPUTS.iter().flat_map(|output| output.takes).map(|argument| argument.name);
        let taken =
            arguments.chain(VARIABLES.iter().copied()).chain(super::taylor::VARIABLES.iter().copied());
        let mut taken: BTreeSet<String> = taken.map(String::from).collect();
        let externals =
            model.externals.iter().map(|f| unique(&mut taken, &format!("extern_{}", f.name))).collect();
        let mut parameters = Vec::new();
        for parameter in &model.parameters {
            let (field, name) = (&parameter.name, variable(&parameter.name.to_string()));
            for i in 0..parameter.length.unwrap_or(1) {
                parameters.push(match parameter.length {
                    None => (unique(&mut taken, &name), format!("self.{field}")),
                    Some(_) => (unique(&mut taken, &format!("{name}_{i}")), format!("self.{field}[{i}]")),
                });
            }
        }
        let mut all = |suffix: &str| -> Vec<String> {
            let name = |c: &crate::model::Coordinate| {
                let index = c.index.map_or(String::new(), |i| format!("_{i}"));
                unique(&mut taken, &format!("{}{index}{suffix}", variable(&c.name.to_string())))
            };
            model.coordinates.iter().map(name).collect()
        };
        let (coordinates, velocities, momenta) = (all(""), all("_dot"), all("_momentum"));
        let bordered = model.coordinates.len() + model.constraints.len();
        let longest = model.struck.iter().map(|s| s.position.len()).fold(bordered, usize::max);
        let given = (0..longest).map(|i| unique(&mut taken, &format!("given_{i}"))).collect();
        let sides = (0..switches).map(|i| unique(&mut taken, &format!("side_{i}"))).collect();
        let mut named: IdMap<String> = IdMap::default();
        for (name, value) in bindings {
            if let Some(node) = value.node.filter(|n| named.get(n).is_none() && value.k.is_one()) {
                let text: String = name.replace('[', "_").replace(']', "");
                named.insert(node, unique(&mut taken, &variable(&text)));
            }
        }
        let runtime = model.runtime.clone();
        Names {
            runtime,
            parameters,
            coordinates,
            velocities,
            momenta,
            given,
            sides,
            externals,
            bindings: named,
            taken,
        }
    }

    fn symbol(&self, symbol: Symbol) -> String {
        let name: &str = match symbol {
            Symbol::Time => "t",
            Symbol::Parameter(i) => &self.parameters[i].0,
            Symbol::Coordinate(i) => &self.coordinates[i],
            Symbol::Velocity(i) => &self.velocities[i],
            Symbol::Momentum(i) => &self.momenta[i],
            Symbol::Given(i) => &self.given[i],
            Symbol::Side(i) => &self.sides[i],
            Symbol::Order(input) => return coefficient(input),
            Symbol::Acceleration(_)
            | Symbol::Multiplier(_)
            | Symbol::Reaction(_)
            | Symbol::Binding(_)
            | Symbol::Rate(_)
            | Symbol::Conserved(_) => {
                unreachable!("substituted before emission")
            }
        };
        name.to_string()
    }

    /// Text of ours as tokens.
    pub fn tokens(&self, text: &str) -> TokenStream {
        let tokens = read(text);
        let replaces = !text.is_ascii() && text.contains(RUNTIME);
        if replaces { self.replaced(tokens) } else { tokens }
    }

    /// The function through which the user's function of this index is called.
    pub fn external(&self, index: usize) -> &str {
        &self.externals[index]
    }

    /// With the tokens that names stand for.
    fn replaced(&self, tokens: TokenStream) -> TokenStream {
        let replaced = |tree: TokenTree| -> TokenStream {
            match tree {
                TokenTree::Group(group) => {
                    let inner = Group::new(group.delimiter(), self.replaced(group.stream()));
                    TokenTree::from(inner).into()
                }
                TokenTree::Ident(name) if name == RUNTIME => self.runtime.clone(),
                other => other.into(),
            }
        };
        tokens.into_iter().map(replaced).collect()
    }
}

/// The variable of an input of recurrences.
fn coefficient(input: Coefficient) -> String {
    match input {
        Coefficient::Level => "weight".into(),
        Coefficient::Over => "over".into(),
        Coefficient::Clock => "clock".into(),
        Coefficient::Coordinate(i) => format!("q_{i}"),
        Coefficient::Rate(i) => format!("slower_{i}"),
        Coefficient::Velocity(i) => format!("qd_{i}"),
        Coefficient::First(i) => format!("first_{i}"),
        Coefficient::Last(i) => format!("last_{i}"),
        Coefficient::Inner(i) => format!("inner_{i}"),
        Coefficient::Before(i) => format!("before_{i}"),
    }
}

/// By the compiler's lexer, where there is a compiler. `proc_macro2` would read the text with its own before, to see whether it is
/// valid, which takes longer than everything else in the emission.
fn read(text: &str) -> TokenStream {
    const VALID: &str = "what is emitted are tokens";
    if proc_macro::is_available() {
        text.parse::<proc_macro::TokenStream>().expect(VALID).into()
    } else {
        text.parse().expect(VALID)
    }
}

/// The wanted name, with underscores until it is new.
fn unique(taken: &mut BTreeSet<String>, wanted: &str) -> String {
    let mut name = wanted.to_string();
    while !taken.insert(name.clone()) {
        name.push('_');
    }
    name
}

/// The variable for a name of the user's. A `let` of a name such as `K` or `Some` would be a pattern where a constant, a unit
/// structure or a variant is called so; by Rust's conventions none of them begins with a small letter.
pub fn variable(name: &str) -> String {
    if name.starts_with(char::is_lowercase) { name.to_string() } else { format!("var_{name}") }
}

/// An expression and how tightly its outermost operator binds.
pub struct Written(String, Binding);

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Sum,
    Product,
    Minus,
    Atom,
}

impl Written {
    fn atom(text: impl Into<String>) -> Written {
        Written(text.into(), Binding::Atom)
    }

    fn in_parentheses_below(self, binding: Binding) -> String {
        if self.1 < binding { format!("({})", self.0) } else { self.0 }
    }

    /// Left of `*` and `/`, right of `+` and `-`.
    fn factor(self) -> String {
        self.in_parentheses_below(Binding::Product)
    }

    /// Right of `*` and `/`, after a minus sign, before a method.
    fn receiver(self) -> String {
        self.in_parentheses_below(Binding::Atom)
    }
}

/// The expressions that an emitted function results in.
pub struct Results<'a> {
    names: &'a Names,
    written: Vec<String>,
}

impl Results<'_> {
    /// One of them.
    pub fn one(&self, i: usize) -> TokenStream {
        self.names.tokens(&self.written[i])
    }

    /// All of them: `[a, b, …]`.
    pub fn array(&self) -> TokenStream {
        self.part(0..self.written.len())
    }

    /// Some of them: `[a, b, …]`.
    pub fn part(&self, range: Range<usize>) -> TokenStream {
        self.names.tokens(&list(&self.written[range]))
    }

    /// Some of them by columns: `[[a, b], [c, d], …]`.
    pub fn columns(&self, range: Range<usize>, rows: usize) -> TokenStream {
        let columns: Vec<String> = self.written[range].chunks(rows).map(list).collect();
        self.names.tokens(&list(&columns))
    }

    /// Each as text.
    pub fn written(&self) -> &[String] {
        &self.written
    }
}

/// `[a, b, …]`
pub fn list<T: Display>(items: impl IntoIterator<Item = T>) -> String {
    let mut text = String::from("[");
    for (i, item) in items.into_iter().enumerate() {
        let separator = if i == 0 { "" } else { ", " };
        // Writing to a string cannot fail.
        let _ = write!(text, "{separator}{item}");
    }
    text + "]"
}

/// The statements of a program; `outputs` afterwards gives its results.
struct Body<'a> {
    g: &'a Graph,
    names: &'a Names,
    program: &'a Program,
    lets: IdMap<String>,
    constants: StableMap<Value, String>,
    taken: BTreeSet<String>,
    text: String,
    /// Names that are declared before all statements, in a program of many.
    declared: Option<Vec<String>>,
}

/// Each `let` is a scope within the one before. Where variables are described for debuggers, as they are in an ordinary build, LLVM walks
/// through scopes by recursion, and some thousands of them overflow the compiler's stack. In programs of more statements than this,
/// variables are declared many at a time, and assigned once.
const SCOPES: usize = 400;

/// Variables that are declared together.
const TOGETHER: usize = 64;

/// Statements and results. The constants of the program are those of an array `constants`.
pub fn body<'a>(g: &Graph, names: &'a Names, program: &Program) -> (TokenStream, Results<'a>) {
    let mut body = Body {
        g,
        names,
        program,
        lets: IdMap::default(),
        constants: StableMap::default(),
        taken: names.taken.clone(),
        text: String::new(),
        declared: (program.steps.len() > SCOPES).then(Vec::new),
    };
    let constants: Vec<String> = (0..program.constants.len()).map(|i| body.fresh(format!("k{i}"))).collect();
    for (v, name) in program.constants.iter().zip(&constants) {
        body.constants.insert(*v, name.clone());
    }
    // What sines that are computed together do not need is read after them: their kernel has use for all registers, and what was read
    // before would have to be put aside for it.
    let together = program.steps.iter().enumerate().find_map(|(i, step)| match step {
        Step::SinCos(pairs) if pairs.len() > 1 => {
            Some((i + 1, pairs.iter().map(|pair| pair.angle).collect::<Vec<_>>()))
        }
        _ => None,
    });
    let (split, angles) = together.unwrap_or_default();
    let needed = g.live(&angles);
    let is_needed = |id: &Id| needed.binary_search(id).is_ok();
    let constants_needed = program.constants.iter().any(|v| v.node.is_some_and(|id| is_needed(&id)));
    for (first, range) in [(true, 0..split), (false, split..program.steps.len())] {
        body.load(program.inputs.iter().copied().filter(|id| is_needed(id) == first));
        if constants_needed == first && !constants.is_empty() {
            body.bind(list(&constants), "*constants");
        }
        range.for_each(|i| body.step(i, &program.steps[i]));
    }
    let written = program.outputs.iter().map(|v| body.value(*v).0).collect();
    let mut text = String::new();
    for names in body.declared.iter().flat_map(|all| all.chunks(TOGETHER)) {
        let _ = writeln!(text, "let ({},);", names.join(", "));
    }
    text += &body.text;
    (names.tokens(&text), Results { names, written })
}

impl Body<'_> {
    /// `let name = value;`, where the name may be a pattern.
    fn bind(&mut self, name: impl Display, value: impl Display) {
        let name = name.to_string();
        // Writing to a string cannot fail.
        let _ = match &mut self.declared {
            Some(declared) => {
                let names =
                    name.split(|c: char| "[](), ".contains(c)).filter(|name| !["", "_"].contains(name));
                declared.extend(names.map(String::from));
                writeln!(self.text, "{name} = {value};")
            }
            None => writeln!(self.text, "let {name} = {value};"),
        };
    }

    /// Reads symbols, vectors at once: each look into one costs the compiler as much as ten looks at variables.
    fn load(&mut self, ids: impl Iterator<Item = Id>) {
        let names = self.names;
        let mut vectors = [("q", &names.coordinates), ("qd", &names.velocities), ("p", &names.momenta)]
            .map(|(vector, names)| (vector, names, Vec::new()));
        for id in ids {
            let Node::Symbol(symbol) = *self.g.node(id) else { continue };
            let from = match symbol {
                Symbol::Coordinate(i) => {
                    vectors[0].2.push(i);
                    continue;
                }
                Symbol::Velocity(i) => {
                    vectors[1].2.push(i);
                    continue;
                }
                Symbol::Momentum(i) => {
                    vectors[2].2.push(i);
                    continue;
                }
                Symbol::Parameter(i) => names.parameters[i].1.clone(),
                Symbol::Given(i) => format!("given[{i}]"),
                Symbol::Side(i) => format!("sides.0[{i}]"),
                _ => continue,
            };
            self.bind(names.symbol(symbol), from);
        }
        for (vector, names, mut read) in vectors {
            match read[..] {
                [] => {}
                [i] => self.bind(&names[i], format!("{vector}[{i}]")),
                _ => {
                    read.sort_unstable();
                    let is_read = |i: usize| read.binary_search(&i).is_ok();
                    let all = names.iter().enumerate();
                    let all = list(all.map(|(i, name)| if is_read(i) { name } else { "_" }));
                    self.bind(format!("[{all}]"), format!("{vector}.data.0"));
                }
            }
        }
    }

    fn step(&mut self, i: usize, step: &Step) {
        match step {
            &Step::Let(id) => {
                let name = match self.names.bindings.get(&id) {
                    Some(name) => name.clone(),
                    None => self.fresh(format!("w{i}")),
                };
                let expression = self.node(id).0;
                self.bind(&name, expression);
                self.lets.insert(id, name);
            }
            Step::SinCos(pairs) => {
                let angles: Vec<String> =
                    pairs.iter().map(|pair| self.value(pair.angle).receiver()).collect();
                let names = pairs.iter().enumerate().map(|(k, pair)| self.circular(i + k, pair));
                let (s, c): (Vec<String>, Vec<String>) = names.unzip();
                match &angles[..] {
                    [angle] => self.bind(format!("({}, {})", s[0], c[0]), format!("{angle}.sin_cos()")),
                    _ => {
                        let names = format!("({}, {})", list(&s), list(&c));
                        self.bind(names, format!("S::sin_cos_array({})", list(&angles)));
                    }
                }
            }
        }
    }

    /// Names for a sine and a cosine.
    fn circular(&mut self, i: usize, &Circular { angle, sine, cosine }: &Circular) -> (String, String) {
        let suffix = match angle.node.map(|n| self.g.node(n)) {
            Some(Node::Symbol(s)) if angle.k.is_one() => self.names.symbol(*s).to_string(),
            _ => i.to_string(),
        };
        let (s, c) = (self.fresh(format!("sin_{suffix}")), self.fresh(format!("cos_{suffix}")));
        self.lets.insert(sine, s.clone());
        self.lets.insert(cosine, c.clone());
        (s, c)
    }

    fn fresh(&mut self, wanted: String) -> String {
        unique(&mut self.taken, &wanted)
    }

    /// The expression of a node.
    fn node(&self, id: Id) -> Written {
        match self.g.node(id) {
            Node::Symbol(s) => Written::atom(self.names.symbol(*s)),
            Node::Sum(a, b) => self.sum(*a, *b),
            Node::Product(a, b) => match (self.inverse(*a), self.inverse(*b)) {
                (_, Some(under)) => self.quotient((*a).into(), under),
                (Some(under), None) => self.quotient((*b).into(), under),
                (None, None) if self.is_over(*a) || self.is_over(*b) => {
                    let x = if self.is_over(*a) { *b } else { *a };
                    Written::atom(format!("over.of({})", self.value(x.into()).0))
                }
                (None, None) => {
                    let (a, b) = (self.value((*a).into()).factor(), self.value((*b).into()).receiver());
                    Written(format!("{a} * {b}"), Binding::Product)
                }
            },
            Node::Inverse(a) => self.quotient(Value::ONE, *a),
            Node::Call(f, a, b) => {
                let a = self.value(*a).receiver();
                let b = if f.row().arguments.len() == 2 { self.value(*b).0 } else { String::new() };
                Written::atom(format!("{a}.{}({b})", f.row().name))
            }
            Node::Extern(f, orders, arguments) => Written::atom(self.external(*f, orders, arguments)),
            Node::Select(comparison, values) => {
                let comparison = match comparison {
                    Comparison::Less => "Less",
                    Comparison::LessEqual => "LessEqual",
                    Comparison::Equal => "Equal",
                };
                let values: Vec<String> = values.iter().map(|v| self.value(*v).0).collect();
                let values = values.join(", ");
                Written::atom(format!("S::select({RUNTIME}::Comparison::{comparison}, {values})"))
            }
        }
    }

    fn quotient(&self, over: Value, under: Id) -> Written {
        let (over, under) = (self.value(over).factor(), self.value(under.into()).receiver());
        Written(format!("{over} / {under}"), Binding::Product)
    }

    /// What an inverse written inside its user inverts.
    fn inverse(&self, id: Id) -> Option<Id> {
        match self.g.node(id) {
            Node::Inverse(under) if self.program.is_inline(id) => Some(*under),
            _ => None,
        }
    }

    /// `a + b`, as one fused operation where one of them is a product that is needed nowhere else.
    fn sum(&self, a: Value, b: Value) -> Written {
        for (quotient, rest) in [(b, a), (a, b)] {
            if let Some(over) = self.by_order(quotient) {
                return Written::atom(format!("over.add({over}, {})", self.value(rest).0));
            }
        }
        for (product, rest) in [(b, a), (a, b)] {
            if let Some((x, y)) = self.fusible(product) {
                let rest = self.value(rest).0;
                return Written::atom(format!("{x}.mul_add({y}, {rest})"));
            }
        }
        let (a, b) = if a.k.is_negative() && !b.k.is_negative() { (b, a) } else { (a, b) };
        let left = self.value(a).0;
        if b.k.is_negative() {
            let right = self.value(-b).factor();
            Written(format!("{left} - {right}"), Binding::Sum)
        } else {
            let right = self.value(b).factor();
            Written(format!("{left} + {right}"), Binding::Sum)
        }
    }

    fn is_over(&self, id: Id) -> bool {
        matches!(self.g.node(id), Node::Symbol(Symbol::Order(Coefficient::Over)))
    }

    /// What is divided by the order, in a quotient that is needed nowhere else.
    fn by_order(&self, v: Value) -> Option<String> {
        let id = v.node.filter(|id| v.k.is_unit() && self.program.is_inline(*id))?;
        let Node::Product(a, b) = *self.g.node(id) else { return None };
        let x = if self.is_over(a) { b } else { Some(a).filter(|_| self.is_over(b))? };
        Some(self.value(Value { k: v.k, node: Some(x) }).0)
    }

    /// The factors of a product that can be fused with an addition.
    fn fusible(&self, v: Value) -> Option<(String, String)> {
        let id = v.node.filter(|_| self.constant(v).is_none())?;
        if !v.k.is_unit() {
            let one = Value { k: Number::ONE, ..v };
            return Some((self.value(one).receiver(), constant(v.k)));
        }
        match *self.g.node(id) {
            Node::Product(x, y)
                if self.program.is_inline(id)
                    && ![x, y].into_iter().any(|id| self.inverse(id).is_some() || self.is_over(id)) =>
            {
                Some((self.value(Value { k: v.k, node: Some(x) }).receiver(), self.value(y.into()).0))
            }
            _ => None,
        }
    }

    /// The name of a constant of the program, whatever its sign.
    fn constant(&self, v: Value) -> Option<&String> {
        self.constants.get(&Value { k: v.k.abs(), ..v })
    }

    /// A value as it stands.
    fn value(&self, v: Value) -> Written {
        let Some(id) = v.node else { return Written::atom(constant(v.k)) };
        if let Some(name) = self.constant(v) {
            return if v.k.is_negative() {
                Written(format!("-{name}"), Binding::Minus)
            } else {
                Written::atom(name.as_str())
            };
        }
        // −(a − b) is b − a: rustc may not say so, for the sake of the sign of zero.
        if let (Node::Sum(a, b), true) =
            (self.g.node(id), self.program.is_inline(id) && v.k == Number::MINUS_ONE)
        {
            return self.sum(-*a, -*b);
        }
        let node = match self.lets.get(&id) {
            Some(name) => Written::atom(name.as_str()),
            None => self.node(id),
        };
        if v.k.is_one() {
            node
        } else if v.k.is_unit() {
            Written(format!("-{}", node.receiver()), Binding::Minus)
        } else {
            Written(format!("{} * {}", constant(v.k), node.receiver()), Binding::Product)
        }
    }

    /// A call of the user's function; its derivatives by nested dual numbers.
    fn external(&self, f: usize, orders: &[u8], arguments: &[Value]) -> String {
        let levels: Vec<usize> =
            orders.iter().enumerate().flat_map(|(i, o)| std::iter::repeat_n(i, usize::from(*o))).collect();
        let argument = |(i, argument): (usize, &Value)| {
            levels.iter().fold(self.value(*argument).0, |inner, level| {
                let kind = if *level == i { "variable" } else { "constant" };
                format!("{RUNTIME}::Dual::{kind}({inner})")
            })
        };
        let arguments: Vec<String> = arguments.iter().enumerate().map(argument).collect();
        let function = self.names.external(f);
        format!("{function}({}){}", arguments.join(", "), ".slope".repeat(levels.len()))
    }
}

/// A constant of the scalar's type.
pub fn constant(k: Number) -> String {
    match (k.to_f64(), k.rest()) {
        (1.0, 0.0) => "S::one()".into(),
        (0.0, _) => "S::zero()".into(),
        // Constants may overflow where they are multiplied.
        (x, _) if x.is_nan() => "S::from_f64(::core::f64::NAN)".into(),
        (x, _) if x.is_infinite() => {
            format!("S::from_f64({}::core::f64::INFINITY)", if x < 0.0 { "-" } else { "" })
        }
        // (With a point, also where the number is whole.)
        (x, 0.0) => format!("S::from_f64({x:?})"),
        (x, rest) => format!("S::from_sum({x:?}, {rest:e})"),
    }
}
