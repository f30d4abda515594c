//! A program as Rust over `S: Scalar`.
//!
//! It is written as text, and read once by the compiler's own lexer: bodies are most of what is emitted, and macros
//! are built without optimisation, so that tokens made one by one would take several times as long. The path of the
//! runtime keeps its spans: a name in its place stands for it until then.

use crate::graph::{Coefficient, Number, Symbol, Value, stable_map::IdMap};
use crate::model::{External, Model};
use crate::program::{Operand, Operation, Program, Slot, Source};
use crate::syntax::Kind;
use crate::table::OUTPUTS;
use proc_macro2::{Group, TokenStream, TokenTree};
use std::collections::BTreeSet;
use std::fmt::{Display, Write};
use std::ops::Range;

/// Stands for the path of the runtime. That this is not ASCII is seen sooner than where in a text it is.
pub const RUNTIME: &str = "ℓ_runtime";

/// Names in emitted functions beside those of arguments and of the recurrences.
const VARIABLES: [&str; 9] =
    ["given", "constants", "self", "S", "Self", "at", "each", "impulse", "multipliers"];

/// Names of variables and functions of the recurrences.
const OF_RECURRENCES: [&str; 24] = [
    "motion",
    "sides",
    "switching",
    "over",
    "weight",
    "clock",
    "level",
    "order",
    "before",
    "ends",
    "products",
    "squares",
    "product",
    "square",
    "factors",
    "accelerations",
    "velocities",
    "further",
    "known",
    "newest",
    "first",
    "last",
    "advance",
    "rates",
];

/// The field with the data that functions have in lanes.
pub const IN_LANES: &str = "__lanes";

/// Names of symbols and of the user's bindings in emitted functions.
pub struct Names {
    runtime: TokenStream,
    /// Variable and field.
    parameters: Vec<(String, String)>,
    coordinates: Vec<String>,
    velocities: Vec<String>,
    momenta: Vec<String>,
    given: Vec<String>,
    /// Names of accelerations and multipliers, which the runtime finds where constraints follow from others.
    accelerations: Vec<String>,
    multipliers: Vec<String>,
    sides: Vec<String>,
    /// Functions through which those of the user's are called, each with what begins its arguments: its data.
    externals: Vec<(String, String)>,
    /// User's names of the values of nodes.
    bindings: IdMap<String>,
    taken: BTreeSet<String>,
}

impl Names {
    /// `bindings` are nodes with the names of the user's bindings.
    pub fn new(model: &Model, bindings: &[(String, Value)], switches: usize) -> Names {
        let arguments = OUTPUTS.iter().flat_map(|output| output.takes).map(|argument| argument.name);
        let taken = arguments.chain(VARIABLES.iter().copied()).chain(OF_RECURRENCES.iter().copied());
        let mut taken: BTreeSet<String> = taken.map(String::from).collect();
        let called = |f: &External| {
            let data = |_| format!("&self.{}, &self.{IN_LANES}, ", f.name);
            let data = f.data.as_ref().map_or(String::new(), data);
            (unique(&mut taken, &format!("extern_{}", f.name)), data)
        };
        let externals = model.externals.iter().map(called).collect();
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
        let mut all = |suffix: &str, of_states: &str| -> Vec<String> {
            let name = |c: &crate::model::Coordinate| {
                let index = c.index.map_or(String::new(), |i| format!("_{i}"));
                let suffix = if c.kind == Kind::State { of_states } else { suffix };
                unique(&mut taken, &format!("{}{index}{suffix}", variable(&c.name.to_string())))
            };
            model.coordinates.iter().map(name).collect()
        };
        let (coordinates, velocities) = (all("", "_integral"), all("_dot", ""));
        let momenta = all("_momentum", "_momentum");
        let mut numbered = |name: &str, n: usize| -> Vec<String> {
            (0..n).map(|i| unique(&mut taken, &format!("{name}_{i}"))).collect()
        };
        let accelerations = numbered("acceleration", model.coordinates.len());
        let multipliers = numbered("multiplier", model.constraints.len());
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
            accelerations,
            multipliers,
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
            Symbol::Acceleration(i) => &self.accelerations[i],
            Symbol::Multiplier(i) => &self.multipliers[i],
            Symbol::Reaction(_)
            | Symbol::Binding(_)
            | Symbol::Rate(_)
            | Symbol::Conserved(_)
            | Symbol::Quaternion(_) => unreachable!("substituted before emission"),
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
        &self.externals[index].0
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

/// Reads a text by the compiler's lexer, where there is a compiler. `proc_macro2` would read the text with its own
/// before, to see whether it is valid, which takes longer than everything else in the emission.
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

/// The variable for a name of the user's. A `let` of a name such as `K` or `Some` would be a pattern where a
/// constant, a unit structure or a variant is called so; by Rust's conventions none of them begins with a small
/// letter.
pub fn variable(name: &str) -> String {
    if name.starts_with(char::is_lowercase) { name.to_string() } else { format!("var_{name}") }
}

/// An expression and how tightly its outermost operator binds.
#[derive(Clone)]
pub struct Written(String, Precedence);

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Precedence {
    Sum,
    Product,
    Minus,
    Atom,
}

impl Written {
    fn atom(text: impl Into<String>) -> Written {
        Written(text.into(), Precedence::Atom)
    }

    fn in_parentheses_below(self, outer: Precedence) -> String {
        if self.1 < outer { format!("({})", self.0) } else { self.0 }
    }

    /// Left of `*` and `/`, right of `+` and `-`.
    fn factor(self) -> String {
        self.in_parentheses_below(Precedence::Product)
    }

    /// Right of `*` and `/`, after a minus sign, before a method.
    fn receiver(self) -> String {
        self.in_parentheses_below(Precedence::Atom)
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

/// The statements of a program.
struct Body<'a> {
    names: &'a Names,
    constants: Vec<String>,
    /// Expressions of slots: names, and what is written inside its user.
    slots: Vec<Written>,
    taken: BTreeSet<String>,
    text: String,
    /// Number of statements so far.
    statements: usize,
    /// Names that are declared before all statements, in a program of many.
    declared: Option<Vec<String>>,
    /// It is so long that it is cut into parts.
    is_cut: bool,
}

/// Each `let` is a scope within the one before. Where variables are described for debuggers, as they are in an
/// ordinary build, LLVM walks through scopes by recursion, and some thousands of them overflow the compiler's stack.
/// In programs of more statements than this, variables are declared many at a time, and assigned once.
const MAX_SCOPES: usize = 400;

/// Programs of more statements are cut into parts of some: what the optimiser does with a straight line takes more
/// time than in proportion to its length. (Calls of 6300 operations took 0.15 % more instructions, and a quarter less
/// time to compile.)
const MAX_STRAIGHT_STATEMENTS: usize = 1000;
const STATEMENTS_PER_PART: usize = 80;

/// Maximum number of variables in one declaration.
const MAX_DECLARED_VARIABLES: usize = 64;

/// Statements and results. The constants of the program are those of an array `constants`.
pub fn body<'a>(names: &'a Names, program: &Program) -> (TokenStream, Results<'a>) {
    let mut body = Body {
        names,
        constants: Vec::new(),
        slots: Vec::with_capacity(program.slots.len()),
        taken: names.taken.clone(),
        text: String::new(),
        statements: 0,
        declared: (program.statements() > MAX_SCOPES).then(Vec::new),
        is_cut: program.statements() > MAX_STRAIGHT_STATEMENTS,
    };
    body.constants = (0..program.constants.len()).map(|i| body.fresh(format!("k{i}"))).collect();
    // Inputs that the batched sine kernel does not need are read after it, which spares it the spilling of registers.
    let is_batch = |slot: &Slot| matches!(&slot.operation, Operation::Circle(angles) if angles.len() > 1);
    let split = program.slots.iter().position(is_batch).map_or(0, |i| i + 1);
    let (mut read, mut constants_read) = (Vec::new(), false);
    for slot in &program.slots[..split] {
        slot.operation.operands(|v| match v.of {
            Source::Symbol(symbol) => read.push(symbol),
            Source::Constant(_) => constants_read = true,
            Source::One | Source::Slot(_) => {}
        });
    }
    for (first, range) in [(true, 0..split), (false, split..program.slots.len())] {
        body.load(program.inputs.iter().copied().filter(|symbol| read.contains(symbol) == first));
        if constants_read == first && !body.constants.is_empty() {
            body.bind(list(&body.constants), "*constants");
        }
        range.for_each(|i| body.slot(&program.slots[i]));
    }
    let written = program.outputs.iter().map(|v| body.value(*v).0).collect();
    let mut text = String::new();
    for names in body.declared.iter().flat_map(|all| all.chunks(MAX_DECLARED_VARIABLES)) {
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
    fn load(&mut self, symbols: impl Iterator<Item = Symbol>) {
        let names = self.names;
        let mut vectors = [("q", &names.coordinates), ("qd", &names.velocities), ("p", &names.momenta)]
            .map(|(vector, names)| (vector, names, Vec::new()));
        for symbol in symbols {
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
                Symbol::Acceleration(i) => format!("accelerations[{i}]"),
                Symbol::Multiplier(i) => format!("multipliers[{i}]"),
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

    /// Writes a slot: a statement, or an expression for its user.
    fn slot(&mut self, Slot { operation, node, inline }: &Slot) {
        match operation {
            Operation::Circle(angles) => self.circle(angles),
            // Named by their circle.
            Operation::Sine(_) | Operation::Cosine(_) => return,
            operation if *inline => self.slots.push(self.operation(operation)),
            operation => {
                let name = match self.names.bindings.get(node) {
                    Some(name) => name.clone(),
                    None => self.fresh(format!("w{}", self.statements)),
                };
                let expression = self.operation(operation).0;
                self.bind(&name, expression);
                self.slots.push(Written::atom(name));
            }
        }
        self.statements += usize::from(!inline);
        if self.is_cut && !inline && self.statements.is_multiple_of(STATEMENTS_PER_PART) {
            self.text += &format!("{RUNTIME}::series::cut();\n");
        }
    }

    /// Sines and cosines at once, whose names fill the slots after this one.
    fn circle(&mut self, angles: &[Operand]) {
        let written: Vec<String> = angles.iter().map(|angle| self.value(*angle).receiver()).collect();
        self.slots.push(Written::atom(""));
        let (mut sines, mut cosines) = (Vec::new(), Vec::new());
        for (i, angle) in angles.iter().enumerate() {
            let suffix = match angle.of {
                Source::Symbol(s) if angle.k.is_one() => self.names.symbol(s),
                _ => (self.statements + i).to_string(),
            };
            for (names, function) in [(&mut sines, "sin"), (&mut cosines, "cos")] {
                let name = self.fresh(format!("{function}_{suffix}"));
                self.slots.push(Written::atom(name.as_str()));
                names.push(name);
            }
        }
        match &written[..] {
            [angle] => self.bind(format!("({}, {})", sines[0], cosines[0]), format!("{angle}.sin_cos()")),
            _ => {
                let names = format!("({}, {})", list(&sines), list(&cosines));
                self.bind(names, format!("S::sin_cos_array({})", list(&written)));
            }
        }
    }

    fn fresh(&mut self, wanted: String) -> String {
        unique(&mut self.taken, &wanted)
    }

    fn operation(&self, operation: &Operation) -> Written {
        let binary = |left: Operand, sign: &str, right: String| {
            let left = self.value(left);
            match sign {
                "+" | "-" => Written(format!("{} {sign} {right}", left.0), Precedence::Sum),
                _ => Written(format!("{} {sign} {right}", left.factor()), Precedence::Product),
            }
        };
        match operation {
            Operation::Sum(a, b) if b.k.is_negative() => binary(*a, "-", self.value(-*b).factor()),
            Operation::Sum(a, b) => binary(*a, "+", self.value(*b).factor()),
            Operation::Fused([x, y], rest) => {
                let (x, [y, rest]) = (self.value(*x).receiver(), [y, rest].map(|v| self.value(*v).0));
                Written::atom(format!("{x}.mul_add({y}, {rest})"))
            }
            Operation::Product(a, b) => binary(*a, "*", self.value(*b).receiver()),
            Operation::Quotient(a, b) => binary(*a, "/", self.value(*b).receiver()),
            Operation::OverOrder(x) => Written::atom(format!("over.of({})", self.value(*x).0)),
            Operation::OverOrderPlus(x, rest) => {
                let [x, rest] = [x, rest].map(|v| self.value(*v).0);
                Written::atom(format!("over.add({x}, {rest})"))
            }
            Operation::Call(f, a, b) => {
                let a = self.value(*a).receiver();
                let b = if f.row().arguments.len() == 2 { self.value(*b).0 } else { String::new() };
                Written::atom(format!("{a}.{}({b})", f.row().name))
            }
            Operation::Extern(f, orders, arguments) => Written::atom(self.external(*f, orders, arguments)),
            Operation::Select(comparison, values) => {
                let values = values.map(|v| self.value(v).0).join(", ");
                Written::atom(format!("S::select({RUNTIME}::Comparison::{comparison:?}, {values})"))
            }
            Operation::Circle(_) | Operation::Sine(_) | Operation::Cosine(_) => {
                unreachable!("statements of their own")
            }
        }
    }

    fn value(&self, v: Operand) -> Written {
        let written = match v.of {
            Source::One => return Written::atom(constant(v.k)),
            Source::Symbol(symbol) => Written::atom(self.names.symbol(symbol)),
            Source::Constant(i) => Written::atom(self.constants[i].as_str()),
            Source::Slot(i) => self.slots[i].clone(),
        };
        if v.k.is_one() {
            written
        } else if v.k.is_unit() {
            Written(format!("-{}", written.receiver()), Precedence::Minus)
        } else {
            Written(format!("{} * {}", constant(v.k), written.receiver()), Precedence::Product)
        }
    }

    /// A call of the user's function; its derivatives by nested dual numbers.
    fn external(&self, f: usize, orders: &[u8], arguments: &[Operand]) -> String {
        let levels: Vec<usize> =
            orders.iter().enumerate().flat_map(|(i, o)| std::iter::repeat_n(i, usize::from(*o))).collect();
        let argument = |(i, argument): (usize, &Operand)| {
            levels.iter().fold(self.value(*argument).0, |inner, level| {
                let kind = if *level == i { "variable" } else { "constant" };
                format!("{RUNTIME}::Dual::{kind}({inner})")
            })
        };
        let arguments: Vec<String> = arguments.iter().enumerate().map(argument).collect();
        let (function, data) = &self.names.externals[f];
        format!("{function}({data}{}){}", arguments.join(", "), ".slope".repeat(levels.len()))
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
