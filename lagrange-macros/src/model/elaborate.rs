//! Expressions to nodes: the only place that knows scope, and the meaning of Rust's words in the language.

use super::value::{Closure, Condition, Val};
use super::{
    Binding, Bound, Coordinate, Entry, External, FunctionDefinition, Names, Observed, Parameter, indexed,
};
use crate::diagnostics::{Errors, Reported, did_you_mean};
use crate::graph::function::TABLE;
use crate::graph::{Comparison, Function, Graph, Number, Symbol, Value};
use crate::syntax::{Declaration, Statement};
use proc_macro2::Ident;
use quote::ToTokens;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use syn::{BinOp, Expr, Lit, Pat, UnOp};

/// Nodes that one system may make.
const NODE_BUDGET: usize = 400_000;
/// Expressions that may be evaluated while it is read.
const STEP_BUDGET: usize = 1_000_000;
/// Elements of arrays that may be made and copied while it is read.
const ELEMENT_BUDGET: usize = 20_000_000;
/// Expressions within expressions, and functions within functions.
const DEEPEST: usize = 96;

pub(super) type Result<T = Val> = std::result::Result<T, Reported>;

pub(super) struct Elaborator<'e> {
    pub errors: &'e mut Errors,
    pub graph: Graph,
    pub names: Names,
    pub used: BTreeSet<String>,
    /// Names that some statement declares, wherever it stands.
    pub later: BTreeSet<String>,
    /// Words of statements that could not be read: what they mean is not known, which has been reported.
    pub unread: BTreeMap<String, Ident>,
    /// Is there such a statement?
    pub incomplete: bool,
    pub parameters: Vec<Parameter>,
    pub coordinates: Vec<Coordinate>,
    pub bindings: Vec<Binding>,
    pub functions: Vec<FunctionDefinition>,
    pub externals: Vec<External>,
    /// T, V, L, D
    pub energies: [Option<(Ident, Value)>; 4],
    pub applied: Vec<Option<Value>>,
    pub forces: Vec<(Value, Value)>,
    pub observed: Vec<Observed>,
    bound: Bound,
    locals: Vec<(String, Val)>,
    /// Functions being expanded.
    calls: Vec<usize>,
    depth: usize,
    steps: usize,
    elements: usize,
    /// Inside `[…]` an integer quotient is Rust's.
    indexing: bool,
    /// The family whose elements are being made.
    family: Option<String>,
    over_budget: bool,
}

impl<'e> Elaborator<'e> {
    pub fn new(errors: &'e mut Errors) -> Self {
        Elaborator {
            errors,
            graph: Graph::default(),
            names: Names::default(),
            used: BTreeSet::new(),
            later: BTreeSet::new(),
            unread: BTreeMap::new(),
            incomplete: false,
            parameters: Vec::new(),
            coordinates: Vec::new(),
            bindings: Vec::new(),
            functions: Vec::new(),
            externals: Vec::new(),
            energies: [None, None, None, None],
            applied: Vec::new(),
            forces: Vec::new(),
            observed: Vec::new(),
            bound: Bound::default(),
            locals: Vec::new(),
            calls: Vec::new(),
            depth: 0,
            steps: 0,
            elements: 0,
            indexing: false,
            family: None,
            over_budget: false,
        }
    }

    pub fn exhausted(&self) -> bool {
        self.over_budget
    }

    // Statements.

    pub fn statement(&mut self, statement: &Statement) {
        match statement {
            Statement::Coord(list) => {
                list.iter().filter(|d| d.value.is_some()).for_each(|d| self.prescribe(d))
            }
            Statement::Let(d) => self.bind(d),
            Statement::Energy { keyword, value } => self.energy(keyword, value),
            Statement::Applied { keyword, coordinate, value } => {
                let _ = self.generalized_force(keyword, coordinate, value);
            }
            Statement::Force { force, at } => {
                let _ = self.force(force, at);
            }
            Statement::Observe(d) => self.observe(d),
            Statement::Constraint { name } => {
                let message = "constraints are not part of the language yet\nhelp: choose independent coordinates, and write the others with `let`";
                self.errors.push(name, message);
            }
            Statement::Const(_)
            | Statement::Param(_)
            | Statement::Function { .. }
            | Statement::Extern { .. }
            | Statement::Unread(_) => {}
        }
    }

    pub fn define(&mut self, name: &Ident, entry: Entry) {
        let text = name.to_string();
        if let Some(message) = reserved(&text) {
            self.errors.push(name, message);
        } else if self.names.contains_key(&text) {
            self.errors.push(name, format!("`{text}` is defined twice\nhelp: give one of them another name"));
        }
        self.names.insert(text, (name.clone(), entry));
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

    /// `coord phi = omega * t;`
    fn prescribe(&mut self, d: &Declaration) {
        let Some(expression) = &d.value else { return };
        let entry = match self.whole_or_family(d, expression) {
            Err(_) => Entry::Broken,
            Ok(val @ (Val::Closure(_) | Val::Bool(_) | Val::Condition(_))) => {
                let message = format!(
                    "a prescribed coordinate is a number, and this is {}\nhelp: write its motion as an expression of `t`",
                    val.kind()
                );
                self.errors.push(expression, message);
                Entry::Broken
            }
            Ok(val) => {
                let numbers = numbers(&val);
                if self.graph.depends(&numbers, |s| {
                    !matches!(s, Symbol::Time | Symbol::Parameter(_) | Symbol::Binding(_))
                }) || self.moves_with_coordinates(&numbers)
                {
                    let message = format!(
                        "a prescribed coordinate is a function of time and parameters alone\nhelp: if `{0}` follows from the coordinates, write `let {0} = …;`",
                        d.name
                    );
                    self.errors.push(expression, message);
                    Entry::Broken
                } else if !self.graph.depends(&numbers, |s| matches!(s, Symbol::Time | Symbol::Binding(_))) {
                    let message = format!(
                        "this does not depend on time\nhelp: a constant is a `param`, or `let {} = …;`",
                        d.name
                    );
                    self.errors.push(expression, message);
                    Entry::Broken
                } else {
                    Entry::Prescribed(self.bound_value(&d.name.to_string(), None, val))
                }
            }
        };
        self.define(&d.name, entry);
    }

    fn bind(&mut self, d: &Declaration) {
        let entry = match &d.value {
            None => {
                self.errors
                    .push(&d.name, format!("a binding needs its value\nhelp: write `let {} = …;`", d.name));
                Entry::Broken
            }
            Some(value) => self.whole_or_family(d, value).map_or(Entry::Broken, Entry::Let),
        };
        match entry {
            Entry::Let(Val::Closure(_) | Val::Bool(_) | Val::Condition(_)) => {
                let message =
                    "a binding is a number or an array of numbers\nhelp: a function is `fn name(x) = …;`";
                self.errors.push(&d.value, message);
                self.define(&d.name, Entry::Broken);
            }
            // The elements of a family are bound one by one, as they are made.
            Entry::Let(val) if d.length.is_none() => {
                let val = self.bound_value(&d.name.to_string(), None, val);
                self.define(&d.name, Entry::Let(val));
            }
            entry => self.define(&d.name, entry),
        }
    }

    /// The value of a declaration: an expression, or, with a length, an array or a closure of the index.
    fn whole_or_family(&mut self, d: &Declaration, value: &Expr) -> Result {
        let Some(length) = self.length(d)? else { return self.evaluate(value) };
        let name = d.name.to_string();
        match self.evaluate(value)? {
            Val::Closure(closure) => self.family(&name, length, &closure, value),
            Val::Array(items) if items.len() == length => {
                let items = items.into_iter().enumerate();
                Ok(Val::Array(items.map(|(i, item)| self.bound_value(&name, Some(i), item)).collect()))
            }
            other => {
                let message = format!(
                    "expected an array of {length}, found {}\nhelp: write `|i| …` for the element i",
                    other.kind()
                );
                Err(self.errors.push(value, message))
            }
        }
    }

    /// `let x: [N] = |i| …;`: elements see those before them under the family's own name.
    fn family(&mut self, name: &str, length: usize, closure: &Closure, at: &Expr) -> Result {
        let mut items = Vec::new();
        let before = self.family.replace(name.to_string());
        for i in 0..length {
            let mut scope = closure.scope.clone();
            scope.push((name.to_string(), Val::Array(items.clone())));
            let closure = Closure { expression: Rc::clone(&closure.expression), scope };
            let item = self.apply(&closure, vec![Val::Int(i as i64)], at);
            match item {
                Ok(item) => items.push(self.bound_value(name, Some(i), item)),
                Err(reported) => {
                    self.family = before;
                    return Err(reported);
                }
            }
        }
        self.family = before;
        Ok(Val::Array(items))
    }

    /// Makes bindings of the positions in a value. Velocities and constants stay plain expressions.
    fn bound_value(&mut self, name: &str, index: Option<usize>, val: Val) -> Val {
        let label = indexed(name, index);
        match val {
            Val::Number(value) => Val::Number(self.bound_number(&label, value)),
            Val::Array(items) => {
                let items = items.into_iter().enumerate();
                Val::Array(items.map(|(i, item)| self.bound_value(&label, Some(i), item)).collect())
            }
            other => other,
        }
    }

    fn bound_number(&mut self, name: &str, value: Value) -> Value {
        let symbols = self.graph.symbols(&[value]);
        let moves =
            symbols.iter().any(|s| matches!(s, Symbol::Coordinate(_) | Symbol::Time | Symbol::Binding(_)));
        let has_rates = symbols.iter().any(|s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_)));
        // Another name for a symbol needs no symbol of its own.
        if !moves
            || has_rates
            || symbols.len() == 1
                && value.node.is_some_and(|n| matches!(self.graph.node(n), crate::graph::Node::Symbol(_)))
        {
            return value;
        }
        let rate = self.rate(value);
        let k = self.bindings.len();
        self.bindings.push(Binding { name: name.to_string(), value, rate });
        let symbol = self.graph.symbol(Symbol::Binding(k));
        self.graph.symbol(Symbol::Rate(k));
        if let Some(node) = value.node {
            self.bound.insert(node, symbol.scaled(value.k.recip()));
        }
        symbol
    }

    /// Total time derivative.
    pub fn rate(&mut self, value: Value) -> Value {
        let mut rates = std::collections::BTreeMap::new();
        for symbol in self.graph.symbols(&[value]) {
            match symbol {
                Symbol::Coordinate(i) => rates.insert((0, i), self.graph.symbol(Symbol::Velocity(i))),
                Symbol::Binding(k) => rates.insert((1, k), self.graph.symbol(Symbol::Rate(k))),
                Symbol::Time => rates.insert((2, 0), Value::ONE),
                _ => None,
            };
        }
        let seed = |symbol| match symbol {
            Symbol::Coordinate(i) => rates.get(&(0, i)).copied(),
            Symbol::Binding(k) => rates.get(&(1, k)).copied(),
            Symbol::Time => Some(Value::ONE),
            _ => None,
        };
        self.graph.forward(&[value], seed)[0]
    }

    /// Do these depend on coordinates through bindings?
    fn moves_with_coordinates(&mut self, numbers: &[Value]) -> bool {
        let symbols = self.graph.symbols(numbers);
        symbols.into_iter().any(|s| match s {
            Symbol::Coordinate(_) => true,
            Symbol::Binding(k) => self.moves_with_coordinates(&[self.bindings[k].value]),
            _ => false,
        })
    }

    fn energy(&mut self, keyword: &Ident, expression: &Expr) {
        let slot = ["T", "V", "L", "D"].iter().position(|name| keyword == name).unwrap_or(0);
        let Ok(value) = self.scalar(expression) else {
            self.energies[slot].get_or_insert((keyword.clone(), Value::ZERO));
            return;
        };
        if self.energies[slot].is_some() {
            let help = format!("add them in one statement, `{keyword} = … + …;`");
            self.errors.push(keyword, format!("a second `{keyword}`\nhelp: {help}"));
        }
        super::check::energy(self, keyword, expression, value);
        self.energies[slot] = Some((keyword.clone(), value));
    }

    /// `Q[theta] = …;`, or for a whole array of coordinates at once.
    fn generalized_force(&mut self, keyword: &Ident, coordinate: &Expr, value: &Expr) -> Result<()> {
        let _ = keyword;
        let targets = self.targets(coordinate)?;
        let values = match self.evaluate(value)? {
            Val::Array(items) => {
                items.into_iter().map(|item| self.number(item, value)).collect::<Result<Vec<_>>>()?
            }
            scalar => vec![self.number(scalar, value)?],
        };
        if values.len() != targets.len() {
            let message = format!(
                "{} for {}\nhelp: one force for each coordinate, as in `Q[x] = [f, g];`",
                counted(values.len(), "force"),
                counted(targets.len(), "coordinate")
            );
            return Err(self.errors.push(value, message));
        }
        for (i, q) in targets.into_iter().zip(values) {
            if self.applied[i].is_some() {
                let label = self.coordinates[i].label();
                let message = format!(
                    "a second `Q[{label}]`\nhelp: add the two forces in one statement, `Q[{label}] = … + …;`"
                );
                self.errors.push(coordinate, message);
            }
            self.applied[i] = Some(q);
        }
        Ok(())
    }

    /// The coordinates that an expression names.
    fn targets(&mut self, expression: &Expr) -> Result<Vec<usize>> {
        let (base, index) = match expression {
            Expr::Index(index) => (&*index.expr, Some(&*index.index)),
            other => (other, None),
        };
        let name = match base {
            Expr::Path(path) => path.path.get_ident().cloned(),
            _ => None,
        };
        let known = name.as_ref().and_then(|n| self.names.get(&n.to_string()).cloned());
        match (known, index) {
            (Some((_, Entry::Coordinate { first, length: None })), None) => Ok(vec![first]),
            (Some((_, Entry::Coordinate { first, length: Some(n) })), None) => {
                Ok((first..first + n).collect())
            }
            (Some((_, Entry::Coordinate { first, length: Some(n) })), Some(index)) => {
                Ok(vec![first + self.index(index, n)?])
            }
            (Some((_, Entry::Broken)), _) => Err(Reported),
            (Some((_, Entry::Coordinate { length: None, .. })), Some(_)) => {
                let name = base.to_token_stream();
                let message =
                    format!("the coordinate `{name}` has no elements\nhelp: write `Q[{name}] = …;`");
                Err(self.errors.push(expression, message))
            }
            (Some((_, Entry::Prescribed(_))), _) => {
                let message = "the motion of a prescribed coordinate is given, whatever forces act on it\nhelp: remove this `Q`";
                Err(self.errors.push(expression, message))
            }
            _ => {
                let text = base.to_token_stream().to_string();
                if self.unread.contains_key(&text) {
                    return Err(Reported);
                }
                let mut coordinates: Vec<String> =
                    self.coordinates.iter().map(|c| c.name.to_string()).collect();
                coordinates.dedup();
                let hint = did_you_mean(&text, coordinates.iter().map(String::as_str));
                let list: Vec<String> = coordinates.iter().map(|c| format!("`{c}`")).collect();
                let help = match list.as_slice() {
                    [] => String::new(),
                    [one] => format!("\nhelp: the coordinate of this system is {one}"),
                    all => format!("\nhelp: the coordinates of this system are {}", all.join(", ")),
                };
                Err(self.errors.push(base, format!("`{text}` is not a coordinate{hint}{help}")))
            }
        }
    }

    /// `force F at x;`
    fn force(&mut self, force: &Expr, at: &Expr) -> Result<()> {
        let (f, x) = (self.evaluate(force), self.evaluate(at));
        let (f, x) = (f?, x?);
        let mut components = |val: Val, at: &Expr| match val {
            Val::Array(items) => items.into_iter().map(|item| self.number(item, at)).collect(),
            scalar => self.number(scalar, at).map(|v| vec![v]),
        };
        let (f, x) = (components(f, force)?, components(x, at)?);
        if f.len() != x.len() {
            let message = format!(
                "a force of {} at a point of {}\nhelp: give both the same components, `force [fx, fy] at [x, y];`",
                counted(f.len(), "component"),
                counted(x.len(), "component")
            );
            return Err(self.errors.push(force, message));
        }
        if self.graph.depends(&x, |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_))) {
            let message = "the point of application depends on velocities\nhelp: it is a position, such as `[x, y]`; a force may depend on velocities";
            return Err(self.errors.push(at, message));
        }
        if !self.graph.depends(&x, |s| matches!(s, Symbol::Coordinate(_) | Symbol::Binding(_))) {
            let message = "this point does not move with the coordinates: a force there does no work\nhelp: remove this statement, or give the point that the force moves";
            return Err(self.errors.push(at, message));
        }
        self.forces.extend(f.into_iter().zip(x));
        Ok(())
    }

    fn observe(&mut self, d: &Declaration) {
        if let Some((_, Entry::Broken)) = self.names.get(&d.name.to_string()) {
            return;
        }
        let text = d.name.to_string();
        if let Some(length) = &d.length {
            let message = "the length of an output is that of its value\nhelp: remove this length";
            self.errors.push(length, message);
        }
        if let Some(message) = super::check::reserved_output(&text) {
            self.errors.push(&d.name, message);
        } else if self.observed.iter().any(|o| o.name == d.name) {
            let message = format!("`{text}` is observed twice\nhelp: give one of them another name");
            self.errors.push(&d.name, message);
        }
        let val = match &d.value {
            Some(value) => self.evaluate(value).map(|val| (val, value.to_token_stream())),
            // `observe tip;` names a binding.
            None => self.name(&d.name).map(|val| (val, d.name.to_token_stream())),
        };
        let Ok((val, tokens)) = val else { return };
        let scalar = !matches!(val, Val::Array(_));
        let values = match val {
            Val::Array(items) => {
                items.into_iter().map(|item| self.number(item, &tokens)).collect::<Result<Vec<_>>>()
            }
            scalar => self.number(scalar, &tokens).map(|v| vec![v]),
        };
        if let Ok(values) = values {
            let attributes = d.attributes.clone();
            self.observed.push(Observed { attributes, name: d.name.clone(), values, scalar });
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
        match self.evaluate(expression)? {
            Val::Int(n) => Ok(n),
            other => {
                let message = format!(
                    "expected an integer that is known at compile time, found {}\nhelp: write an integer such as `3`, or the name of a `const`",
                    other.kind()
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
                return Err(self.errors.push(
                    expression,
                    "a default is a constant\nhelp: a number that follows from parameters is `let name = …;`",
                ));
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

    fn index(&mut self, expression: &Expr, length: usize) -> Result<usize> {
        let before = std::mem::replace(&mut self.indexing, true);
        let i = self.evaluate(expression);
        self.indexing = before;
        match i? {
            Val::Int(i) if usize::try_from(i).is_ok_and(|i| i < length) => Ok(i as usize),
            Val::Int(i) => Err(self.errors.push(
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
            other => {
                let message = format!(
                    "an index is an integer that is known at compile time, not {}\nhelp: in `(0..N).map(|i| …)` it is `i`",
                    other.kind()
                );
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
                let help = match other {
                    Val::Array(_) => "\nhelp: take an element, `x[0]`, or the sum over them, `x.sum()`",
                    Val::Closure(_) => "\nhelp: a function is `fn name(x) = …;`, and is called, `name(x)`",
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
        if self.steps > STEP_BUDGET || self.graph.len() > NODE_BUDGET {
            self.over_budget = true;
            let nodes = self.graph.len();
            let what = if nodes > NODE_BUDGET {
                format!("more than {NODE_BUDGET} nodes ({nodes} so far)")
            } else {
                format!("more than {STEP_BUDGET} expressions ({} so far, {nodes} nodes)", self.steps)
            };
            let message = format!(
                "this system expands to {what}\nhelp: fewer elements, or `let` bindings for what repeats"
            );
            return Err(self.errors.push(expression, message));
        }
        if self.depth > DEEPEST {
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
            Expr::Reference(inner) => self.evaluate(&inner.expr),
            Expr::Unary(unary) => {
                let val = self.evaluate(&unary.expr)?;
                match (&unary.op, val) {
                    (UnOp::Neg(_), val) => self.negated(val, &unary.expr),
                    (UnOp::Not(_), Val::Bool(b)) => Ok(Val::Bool(!b)),
                    (UnOp::Not(_), Val::Condition(c)) => Ok(Val::Condition(Rc::new(Condition::Not(c)))),
                    (UnOp::Deref(_), val) => Ok(val),
                    (_, other) => {
                        Err(self.errors.push(unary, format!("this does not apply to {}", other.kind())))
                    }
                }
            }
            Expr::Binary(_) => self.chain(expression),
            Expr::Call(call) => self.function_call(call),
            Expr::MethodCall(call) => self.method_call(call),
            Expr::Index(index) => self.element(index),
            Expr::Array(array) => {
                Ok(Val::Array(array.elems.iter().map(|e| self.evaluate(e)).collect::<Result<_>>()?))
            }
            Expr::Tuple(tuple) => {
                Ok(Val::Array(tuple.elems.iter().map(|e| self.evaluate(e)).collect::<Result<_>>()?))
            }
            Expr::Repeat(repeat) => {
                let item = self.evaluate(&repeat.expr)?;
                let n = self.whole(&repeat.len)?;
                let n = self.count(n, &repeat.len)?;
                self.spend(n.saturating_mul(item.size()), repeat)?;
                Ok(Val::Array(vec![item; n]))
            }
            Expr::Range(range) => self.range(range),
            Expr::Closure(closure) => {
                let expression = Rc::new(closure.clone());
                Ok(Val::Closure(Rc::new(Closure { expression, scope: self.locals.clone() })))
            }
            Expr::If(conditional) => self.conditional(conditional),
            Expr::Block(block) => self.block(&block.block),
            Expr::Cast(cast) => {
                let val = self.evaluate(&cast.expr)?;
                match &*cast.ty {
                    syn::Type::Path(ty) if ty.path.is_ident("f64") || ty.path.is_ident("f32") => {
                        Ok(Val::Number(self.number(val, &cast.expr)?))
                    }
                    _ => match val {
                        Val::Int(_) => Ok(val),
                        other => Err(self.errors.push(cast, format!("{} is not an integer", other.kind()))),
                    },
                }
            }
            Expr::Field(field) => match (&field.member, self.evaluate(&field.base)?) {
                (syn::Member::Unnamed(i), Val::Array(items)) if (i.index as usize) < items.len() => {
                    Ok(items[i.index as usize].clone())
                }
                _ => Err(self.errors.push(&field.member, "there is no such field")),
            },
            Expr::Assign(assign) => Err(self
                .errors
                .push(assign.eq_token, "nothing is assigned in an expression\nhelp: to compare, write `==`")),
            Expr::Macro(mac) => Err(self.errors.push(
                mac,
                "macros are not expanded inside a system\nhelp: write the expression out, or define a function, `fn name(x) = …;`",
            )),
            other => Err(self.errors.push(
                other,
                "this kind of expression is not part of the language\nhelp: write it with numbers, names, operators, functions and `if … { … } else { … }`",
            )),
        }
    }

    fn literal(&mut self, lit: &syn::ExprLit) -> Result {
        match &lit.lit {
            Lit::Int(int) => match int.base10_parse::<i64>() {
                Ok(n) if matches!(int.suffix(), "f64" | "f32") => Ok(Val::Number(Value::constant(n))),
                Ok(n) => Ok(Val::Int(n)),
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
        let segments: Vec<String> = path.path.segments.iter().map(|s| s.ident.to_string()).collect();
        let constant = match segments.last().map(String::as_str) {
            Some(name) if segments.iter().any(|s| s == "consts") => constant(name),
            _ => None,
        };
        match constant {
            Some(x) => Ok(Val::Number(Value { k: Number::float(x), node: None })),
            None => Err(self.errors.push(
                path,
                "unknown constant\nhelp: constants are those of `f64::consts`, such as `f64::consts::PI`",
            )),
        }
    }

    fn name(&mut self, name: &Ident) -> Result {
        let text = name.to_string();
        if let Some((_, val)) = self.locals.iter().rev().find(|(local, _)| *local == text) {
            let (val, size) = (val.clone(), val.size());
            self.spend(size, name)?;
            return Ok(val);
        }
        self.used.insert(text.clone());
        let symbols =
            |g: &mut Graph, symbol: fn(usize) -> Symbol, first: usize, length: Option<usize>| match length {
                None => Val::Number(g.symbol(symbol(first))),
                Some(n) => Val::Array((first..first + n).map(|i| Val::Number(g.symbol(symbol(i)))).collect()),
            };
        let entry = self.names.get(&text).map(|(_, entry)| entry.clone());
        let size = match &entry {
            Some(Entry::Let(val) | Entry::Prescribed(val)) => val.size(),
            Some(Entry::Parameter(i)) => self.parameters[*i].numbers().len(),
            Some(Entry::Coordinate { length, .. }) => length.unwrap_or(1),
            _ => 1,
        };
        self.spend(size, name)?;
        match entry {
            Some(Entry::Const(n)) => Ok(Val::Int(n)),
            Some(Entry::Parameter(i)) => {
                let Parameter { first, length, .. } = self.parameters[i];
                Ok(symbols(&mut self.graph, Symbol::Parameter, first, length))
            }
            Some(Entry::Coordinate { first, length }) => {
                Ok(symbols(&mut self.graph, Symbol::Coordinate, first, length))
            }
            Some(Entry::Let(val) | Entry::Prescribed(val)) => Ok(val),
            Some(Entry::Broken) => Err(Reported),
            Some(Entry::Function(_) | Entry::External(_)) => {
                Err(self.errors.push(name, format!("`{text}` is a function\nhelp: call it, `{text}(…)`")))
            }
            None if text == "t" => Ok(Val::Number(self.graph.symbol(Symbol::Time))),
            None if text == "PI" => {
                Ok(Val::Number(Value { k: Number::float(std::f64::consts::PI), node: None }))
            }
            None => Err(self.unknown(name)),
        }
    }

    fn unknown(&mut self, name: &Ident) -> Reported {
        let text = name.to_string();
        if self.unread.contains_key(&text) {
            return Reported;
        }
        if self.later.contains(&text) {
            let message = format!(
                "`{text}` is not known yet: this statement, or one below it, defines it\nhelp: `let` and `const` use what stands above them; move the definition of `{text}` up"
            );
            return self.errors.push(name, message);
        }
        let locals = self.locals.iter().map(|(local, _)| local.as_str());
        let hint = did_you_mean(&text, self.names.keys().map(String::as_str).chain(locals).chain(["t"]));
        let help = match text.as_str() {
            "q" | "qd" => "\nhelp: coordinates are known by their names, velocities as `dot(name)`",
            _ if hint.is_empty() => {
                "\nhelp: declare it with `param`, `coord`, `const` or, above its first use, `let`"
            }
            _ => "",
        };
        self.errors.push(name, format!("unknown name `{text}`{hint}{help}"))
    }

    fn negated(&mut self, val: Val, at: &Expr) -> Result {
        match val {
            Val::Int(n) => n.checked_neg().map(Val::Int).ok_or_else(|| self.errors.push(at, OVERFLOW)),
            Val::Number(value) => Ok(Val::Number(-value)),
            Val::Array(items) => {
                Ok(Val::Array(items.into_iter().map(|v| self.negated(v, at)).collect::<Result<_>>()?))
            }
            other => Err(self.errors.push(at, format!("expected a number, found {}", other.kind()))),
        }
    }

    /// A left-deep chain `a + b − c …`, without recursing for each of its terms.
    fn chain(&mut self, expression: &Expr) -> Result {
        let mut links = Vec::new();
        let mut first = expression;
        while let Expr::Binary(binary) = first {
            links.push(binary);
            first = &binary.left;
        }
        let mut left = self.evaluate(first);
        for binary in links.into_iter().rev() {
            let right = self.evaluate(&binary.right);
            left = match (left, right) {
                _ if matches!(binary.op, BinOp::BitXor(_)) => Err(self.caret(binary)),
                (Ok(a), Ok(b)) => self.binary(binary, a, b),
                _ => Err(Reported),
            };
        }
        left
    }

    fn caret(&mut self, binary: &syn::ExprBinary) -> Reported {
        let base = match &*binary.left {
            // The left side is all that binds more strongly, such as `0.5 * m * x`.
            Expr::Binary(inner) => &*inner.right,
            other => other,
        };
        let message = format!(
            "`^` is exclusive or in Rust, and binds more weakly than `+`\nhelp: a power is written `{}.powi(2)`",
            base.to_token_stream()
        );
        self.errors.push(binary.op, message)
    }

    fn binary(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
        match binary.op {
            BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_) => self.arithmetic(binary, a, b),
            BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) | BinOp::Eq(_) | BinOp::Ne(_) => {
                self.comparison(binary, a, b)
            }
            BinOp::And(_) | BinOp::Or(_) => {
                let and = matches!(binary.op, BinOp::And(_));
                match (a, b) {
                    (Val::Bool(decided), other) | (other, Val::Bool(decided))
                        if matches!(other, Val::Bool(_) | Val::Condition(_)) =>
                    {
                        Ok(if decided == and { other } else { Val::Bool(decided) })
                    }
                    (Val::Condition(p), Val::Condition(q)) => Ok(Val::Condition(Rc::new(if and {
                        Condition::And(p, q)
                    } else {
                        Condition::Or(p, q)
                    }))),
                    _ => Err(self.errors.push(binary, "expected conditions on both sides")),
                }
            }
            BinOp::Rem(op) => match (a, b) {
                (Val::Int(a), Val::Int(b)) if b != 0 => Ok(Val::Int(a.wrapping_rem(b))),
                _ => Err(self.errors.push(
                    op,
                    "`%` is for compile-time integers: a remainder has no derivative at its jumps\nhelp: for an angle, use its sine and cosine",
                )),
            },
            _ => Err(self.errors.push(
                binary.op,
                "this operator is not part of the language\nhelp: operators are `+ - * /`, comparisons, `&&` and `||`",
            )),
        }
    }

    fn arithmetic(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
        match (a, b) {
            (Val::Int(a), Val::Int(b)) => self.integers(binary, a, b),
            (Val::Array(a), Val::Array(b)) if matches!(binary.op, BinOp::Add(_) | BinOp::Sub(_)) => {
                if a.len() != b.len() {
                    let message = format!(
                        "one array has {}, the other {}\nhelp: arrays are added element by element",
                        counted(a.len(), "element"),
                        counted(b.len(), "element")
                    );
                    return Err(self.errors.push(binary, message));
                }
                let pairs = a.into_iter().zip(b);
                Ok(Val::Array(pairs.map(|(a, b)| self.arithmetic(binary, a, b)).collect::<Result<_>>()?))
            }
            (Val::Array(a), b @ (Val::Int(_) | Val::Number(_)))
                if matches!(binary.op, BinOp::Mul(_) | BinOp::Div(_)) =>
            {
                Ok(Val::Array(
                    a.into_iter().map(|a| self.arithmetic(binary, a, b.clone())).collect::<Result<_>>()?,
                ))
            }
            (a @ (Val::Int(_) | Val::Number(_)), Val::Array(b)) if matches!(binary.op, BinOp::Mul(_)) => {
                Ok(Val::Array(
                    b.into_iter().map(|b| self.arithmetic(binary, a.clone(), b)).collect::<Result<_>>()?,
                ))
            }
            (Val::Array(_), Val::Array(_)) => Err(self.errors.push(
                binary,
                "arrays are not multiplied elementwise\nhelp: the inner product is `a.dot(b)`",
            )),
            (a, b) => {
                let (a, b) = (self.number(a, &binary.left)?, self.number(b, &binary.right)?);
                let g = &mut self.graph;
                Ok(Val::Number(match binary.op {
                    BinOp::Add(_) => g.add(a, b),
                    BinOp::Sub(_) => g.sub(a, b),
                    BinOp::Mul(_) => g.mul(a, b),
                    _ if b.is_zero() => return Err(self.errors.push(&binary.right, "division by zero")),
                    _ => g.div(a, b),
                }))
            }
        }
    }

    fn integers(&mut self, binary: &syn::ExprBinary, a: i64, b: i64) -> Result {
        let result = match binary.op {
            BinOp::Add(_) => a.checked_add(b),
            BinOp::Sub(_) => a.checked_sub(b),
            BinOp::Mul(_) => a.checked_mul(b),
            _ if b == 0 => return Err(self.errors.push(&binary.right, "division by zero")),
            _ if is_literal(&binary.left) && is_literal(&binary.right) => {
                let message = format!(
                    "`{a} / {b}` is an integer division, {} in Rust\nhelp: write `{a}.0 / {b}.0`",
                    a.wrapping_div(b)
                );
                return Err(self.errors.push(binary, message));
            }
            _ if self.indexing || a.wrapping_rem(b) == 0 => a.checked_div(b),
            _ => {
                let message = format!(
                    "an integer division with a remainder, {a} / {b}\nhelp: for a quotient write `… as f64 / …`"
                );
                return Err(self.errors.push(binary, message));
            }
        };
        result.map(Val::Int).ok_or_else(|| self.errors.push(binary, "this integer overflows"))
    }

    fn comparison(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
        if let (Val::Int(a), Val::Int(b)) = (&a, &b) {
            return Ok(Val::Bool(match binary.op {
                BinOp::Lt(_) => a < b,
                BinOp::Le(_) => a <= b,
                BinOp::Gt(_) => a > b,
                BinOp::Ge(_) => a >= b,
                BinOp::Eq(_) => a == b,
                _ => a != b,
            }));
        }
        let (a, b) = (self.number(a, &binary.left)?, self.number(b, &binary.right)?);
        let compare = |c, a, b| Rc::new(Condition::Compare(c, a, b));
        Ok(Val::Condition(match binary.op {
            BinOp::Lt(_) => compare(Comparison::Less, a, b),
            BinOp::Le(_) => compare(Comparison::LessEqual, a, b),
            BinOp::Gt(_) => compare(Comparison::Less, b, a),
            BinOp::Ge(_) => compare(Comparison::LessEqual, b, a),
            BinOp::Eq(_) => compare(Comparison::Equal, a, b),
            _ => Rc::new(Condition::Not(compare(Comparison::Equal, a, b))),
        }))
    }

    fn conditional(&mut self, conditional: &syn::ExprIf) -> Result {
        let condition = self.evaluate(&conditional.cond)?;
        let Some((_, otherwise)) = &conditional.else_branch else {
            let message = "an `if` needs its `else`: an expression has a value either way\nhelp: add `else { 0.0 }`, or the other value";
            return Err(self.errors.push(conditional.if_token, message));
        };
        match condition {
            Val::Bool(true) => self.block(&conditional.then_branch),
            Val::Bool(false) => self.evaluate(otherwise),
            Val::Condition(condition) => {
                let yes = self.block(&conditional.then_branch)?;
                let no = self.evaluate(otherwise)?;
                self.selected(&condition, yes, no, conditional)
            }
            other => Err(self
                .errors
                .push(&conditional.cond, format!("expected a condition, found {}", other.kind()))),
        }
    }

    fn selected(&mut self, condition: &Condition, yes: Val, no: Val, at: &syn::ExprIf) -> Result {
        match (yes, no) {
            (Val::Array(yes), Val::Array(no)) if yes.len() == no.len() => {
                let pairs = yes.into_iter().zip(no);
                Ok(Val::Array(pairs.map(|(y, n)| self.selected(condition, y, n, at)).collect::<Result<_>>()?))
            }
            (yes, no) => {
                let (yes, no) = (self.number(yes, at)?, self.number(no, at)?);
                Ok(Val::Number(condition.select(&mut self.graph, yes, no)))
            }
        }
    }

    /// `{ let a = …; let b = …; value }`
    fn block(&mut self, block: &syn::Block) -> Result {
        let scope = self.locals.len();
        let val = self.block_value(block);
        self.locals.truncate(scope);
        val
    }

    fn block_value(&mut self, block: &syn::Block) -> Result {
        let Some((last, lets)) = block.stmts.split_last() else {
            return Err(self.errors.push(block, "an empty block has no value"));
        };
        for statement in lets {
            match statement {
                syn::Stmt::Local(syn::Local { pat, init: Some(init), .. }) => {
                    let val = self.evaluate(&init.expr)?;
                    self.matched(pat, val)?;
                }
                other => return Err(self.errors.push(other, "a block holds `let`s and, last, its value")),
            }
        }
        match last {
            syn::Stmt::Expr(value, None) => self.evaluate(value),
            other => Err(self.errors.push(other, "a block ends in its value, without `;`")),
        }
    }

    /// Binds a pattern of a closure or a local `let`.
    fn matched(&mut self, pattern: &Pat, val: Val) -> Result<()> {
        match (pattern, val) {
            (Pat::Ident(name), val) => {
                self.locals.push((name.ident.to_string(), val));
                Ok(())
            }
            (Pat::Type(typed), val) => self.matched(&typed.pat, val),
            (Pat::Paren(inner), val) => self.matched(&inner.pat, val),
            (Pat::Reference(inner), val) => self.matched(&inner.pat, val),
            (Pat::Wild(_), _) => Ok(()),
            (
                Pat::Tuple(syn::PatTuple { elems, .. }) | Pat::Slice(syn::PatSlice { elems, .. }),
                Val::Array(items),
            ) if elems.len() == items.len() => {
                elems.iter().zip(items).try_for_each(|(pattern, item)| self.matched(pattern, item))
            }
            (pattern, val) => {
                Err(self.errors.push(pattern, format!("this pattern does not fit {}", val.kind())))
            }
        }
    }

    pub fn apply(&mut self, closure: &Closure, arguments: Vec<Val>, at: impl ToTokens) -> Result {
        let inputs = &closure.expression.inputs;
        if inputs.len() != arguments.len() {
            let message = format!("a closure of {} arguments, given {}", inputs.len(), arguments.len());
            return Err(self.errors.push(at, message));
        }
        let before = std::mem::replace(&mut self.locals, closure.scope.clone());
        let val = match inputs.iter().zip(arguments).try_for_each(|(pattern, val)| self.matched(pattern, val))
        {
            Ok(()) => self.evaluate(&closure.expression.body),
            Err(reported) => Err(reported),
        };
        self.locals = before;
        val
    }

    fn range(&mut self, range: &syn::ExprRange) -> Result {
        let start = range.start.as_ref().map_or(Ok(0), |e| self.whole(e))?;
        let Some(end) = &range.end else {
            return Err(self.errors.push(range, "a range needs its end"));
        };
        let end = self.whole(end)?;
        let end =
            if matches!(range.limits, syn::RangeLimits::Closed(_)) { end.saturating_add(1) } else { end };
        let n = self.count(end.saturating_sub(start).max(0), range)?;
        Ok(Val::Array((0..n as i64).map(|i| Val::Int(start + i)).collect()))
    }

    /// A length that is within reason.
    fn count(&mut self, n: i64, at: impl ToTokens) -> Result<usize> {
        match usize::try_from(n) {
            Ok(n) if n <= 100_000 => {
                self.spend(n, at)?;
                Ok(n)
            }
            _ => {
                let message = format!(
                    "{n} elements are more than a system can have\nhelp: the budget is 100000 in one array"
                );
                Err(self.errors.push(at, message))
            }
        }
    }

    /// Elements made or copied; an error where there is no end of them.
    fn spend(&mut self, elements: usize, at: impl ToTokens) -> Result<()> {
        self.elements = self.elements.saturating_add(elements);
        if self.elements <= ELEMENT_BUDGET {
            return Ok(());
        }
        if std::mem::replace(&mut self.over_budget, true) {
            return Err(Reported);
        }
        let message = format!(
            "this system makes more than {ELEMENT_BUDGET} elements of arrays\nhelp: use smaller arrays, or fewer arrays within arrays"
        );
        Err(self.errors.push(at, message))
    }

    /// `x[i]`; of a named array without a copy of the whole.
    fn element(&mut self, index: &syn::ExprIndex) -> Result {
        let name = match &*index.expr {
            Expr::Path(path) => path.path.get_ident().map(ToString::to_string),
            _ => None,
        };
        if let Some(name) = name
            && let Some(length) = self.array_length(&name)
        {
            if self.family.as_ref() == Some(&name) {
                self.known_in_family(&name, length, &index.index)?;
            }
            let i = self.index(&index.index, length)?;
            return Ok(self.array_element(&name, i));
        }
        let Val::Array(items) = self.evaluate(&index.expr)? else {
            let message = "a number has no elements\nhelp: remove the index";
            return Err(self.errors.push(&index.expr, message));
        };
        let i = self.index(&index.index, items.len())?;
        Ok(items[i].clone())
    }

    fn known_in_family(&mut self, name: &str, length: usize, index: &Expr) -> Result<()> {
        let before = std::mem::replace(&mut self.indexing, true);
        let i = self.whole(index);
        self.indexing = before;
        let i = i?;
        if usize::try_from(i).is_ok_and(|i| i < length) {
            return Ok(());
        }
        let message = format!(
            "`{name}[{i}]` is not known here: an element of a family can use those before it\nhelp: write `if i == 0 {{ … }} else {{ … {name}[i - 1] … }}`"
        );
        Err(self.errors.push(index, message))
    }

    fn array_length(&self, name: &str) -> Option<usize> {
        let items = |val: &Val| match val {
            Val::Array(items) => Some(items.len()),
            _ => None,
        };
        if let Some((_, val)) = self.locals.iter().rev().find(|(local, _)| local == name) {
            return items(val);
        }
        match &self.names.get(name)?.1 {
            Entry::Let(val) | Entry::Prescribed(val) => items(val),
            Entry::Parameter(i) => self.parameters[*i].length,
            Entry::Coordinate { length, .. } => *length,
            _ => None,
        }
    }

    /// Element i of the array of that name, which has so many.
    fn array_element(&mut self, name: &str, i: usize) -> Val {
        let item = |val: &Val| match val {
            Val::Array(items) => items[i].clone(),
            other => other.clone(),
        };
        if let Some((_, val)) = self.locals.iter().rev().find(|(local, _)| local == name) {
            return item(val);
        }
        self.used.insert(name.to_string());
        let symbol = match self.names.get(name).map(|(_, entry)| entry) {
            Some(Entry::Let(val) | Entry::Prescribed(val)) => return item(val),
            Some(Entry::Parameter(p)) => Symbol::Parameter(self.parameters[*p].first + i),
            Some(Entry::Coordinate { first, .. }) => Symbol::Coordinate(first + i),
            _ => unreachable!("only arrays have a length"),
        };
        Val::Number(self.graph.symbol(symbol))
    }

    // Calls.

    fn function_call(&mut self, call: &syn::ExprCall) -> Result {
        let Expr::Path(path) = &*call.func else {
            return match self.evaluate(&call.func)? {
                Val::Closure(closure) => {
                    let arguments = call.args.iter().map(|a| self.evaluate(a)).collect::<Result<Vec<_>>>()?;
                    self.apply(&closure, arguments, call)
                }
                other => Err(self.errors.push(&call.func, format!("{} is not a function", other.kind()))),
            };
        };
        let Some(name) = path.path.segments.last().map(|s| s.ident.clone()) else { return Err(Reported) };
        let text = name.to_string();
        if text == "dot" {
            return self.dot(call);
        }
        let arguments: Vec<Result> = call.args.iter().map(|a| self.evaluate(a)).collect();
        if !self.is_function(&text) {
            return Err(self.no_function(&name));
        }
        let arguments: Vec<Val> = arguments.into_iter().collect::<Result<_>>()?;
        if let Some((_, Val::Closure(closure))) =
            self.locals.iter().rev().find(|(local, _)| *local == text).cloned()
        {
            return self.apply(&closure, arguments, call);
        }
        self.used.insert(text.clone());
        match self.names.get(&text).map(|(_, entry)| entry.clone()) {
            Some(Entry::Function(f)) => self.own_function(f, arguments, call),
            Some(Entry::External(f)) => {
                let arity = self.externals[f].arity;
                self.arity(&text, arity, arguments.len(), &name)?;
                let arguments = arguments
                    .into_iter()
                    .map(|a| self.number(a, &call.args))
                    .collect::<Result<Vec<Value>>>()?;
                let orders = vec![0; arity].into();
                Ok(Val::Number(self.graph.external(f, orders, arguments.into())))
            }
            Some(Entry::Broken) => Err(Reported),
            Some(_) => Err(self.errors.push(
                &name,
                format!("`{text}` is not a function\nhelp: for a product write `{text} * (…)`"),
            )),
            None => {
                self.arity(&text, 1 + method_arity(&text), arguments.len(), &name)?;
                match arguments.split_first() {
                    Some((receiver, rest)) => self.method(&name, receiver.clone(), rest.to_vec(), &call.args),
                    None => Err(Reported),
                }
            }
        }
    }

    fn is_function(&self, name: &str) -> bool {
        is_method(name)
            || self.names.contains_key(name)
            || self.locals.iter().any(|(local, val)| local == name && matches!(val, Val::Closure(_)))
    }

    fn no_function(&mut self, name: &Ident) -> Reported {
        let text = name.to_string();
        if self.unread.contains_key(&text) {
            return Reported;
        }
        if ARRAY_METHODS.contains(&text.as_str()) {
            let message = format!("`{text}` is called as a method\nhelp: write `x.{text}(…)`");
            return self.errors.push(name, message);
        }
        let mut known: Vec<String> = self.functions.iter().map(|f| f.name.to_string()).collect();
        known.extend(self.externals.iter().map(|f| f.name.to_string()));
        known.extend(TABLE.iter().map(|row| row.name.to_string()));
        known.extend(["dot", "min", "max", "powi"].map(String::from));
        let hint = did_you_mean(&text, known.iter().map(String::as_str));
        let help = match hint.is_empty() {
            true => "\nhelp: define it with `fn`, or declare a function of your own with `extern fn`",
            false => "",
        };
        self.errors.push(name, format!("unknown function `{text}`{hint}{help}"))
    }

    fn arity(&mut self, name: &str, expected: usize, found: usize, at: impl ToTokens) -> Result<()> {
        if expected == found {
            return Ok(());
        }
        let plural = if expected == 1 { "" } else { "s" };
        let help = if name == "dot" && expected == 1 { "\nhelp: an inner product is `a.dot(b)`" } else { "" };
        Err(self.errors.push(at, format!("`{name}` takes {expected} argument{plural}, not {found}{help}")))
    }

    fn own_function(&mut self, f: usize, arguments: Vec<Val>, call: &syn::ExprCall) -> Result {
        let definition = &self.functions[f];
        let (name, parameters, body) =
            (definition.name.to_string(), definition.arguments.clone(), definition.body.clone());
        self.arity(&name, parameters.len(), arguments.len(), &call.func)?;
        if self.calls.contains(&f) {
            let message = format!(
                "`{name}` calls itself{}: a recursion has no end\nhelp: a sum over a range is `(0..N).map(|i| …).sum()`",
                match self.calls.last() {
                    Some(last) if *last != f => format!(" through `{}`", self.functions[*last].name),
                    _ => String::new(),
                }
            );
            return Err(self.errors.push(&call.func, message));
        }
        let before = std::mem::take(&mut self.locals);
        self.locals.extend(parameters.iter().map(ToString::to_string).zip(arguments));
        self.calls.push(f);
        let val = self.evaluate(&body);
        self.calls.pop();
        self.locals = before;
        val
    }

    /// `dot(e)`: total time derivative.
    fn dot(&mut self, call: &syn::ExprCall) -> Result {
        self.arity("dot", 1, call.args.len(), &call.func)?;
        let argument = &call.args[0];
        let val = self.evaluate(argument)?;
        self.dotted(val, argument, call)
    }

    fn dotted(&mut self, val: Val, argument: &Expr, call: &syn::ExprCall) -> Result {
        if let Val::Array(items) = val {
            return Ok(Val::Array(
                items.into_iter().map(|v| self.dotted(v, argument, call)).collect::<Result<_>>()?,
            ));
        }
        let value = self.number(val, argument)?;
        if self.graph.depends(&[value], |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_))) {
            let message = "a second time derivative: accelerations follow from the energies, they are not part of them\nhelp: `dot` applies to coordinates and positions";
            return Err(self.errors.push(call, message));
        }
        if !self
            .graph
            .depends(&[value], |s| matches!(s, Symbol::Coordinate(_) | Symbol::Binding(_) | Symbol::Time))
        {
            let message = format!(
                "`{}` does not depend on a coordinate or on time, so its rate is 0\nhelp: remove this term, or declare what moves with `coord`",
                argument.to_token_stream()
            );
            return Err(self.errors.push(call, message));
        }
        Ok(Val::Number(self.rate(value)))
    }

    fn method_call(&mut self, call: &syn::ExprMethodCall) -> Result {
        let receiver = self.evaluate(&call.receiver);
        let arguments = call.args.iter().map(|a| self.evaluate(a)).collect::<Result<Vec<_>>>();
        let (receiver, arguments) = (receiver?, arguments?);
        let at: &dyn ToTokens = if call.args.is_empty() { &call.method } else { &call.args };
        self.method(&call.method, receiver, arguments, at)
    }

    fn method(
        &mut self,
        name: &Ident,
        receiver: Val,
        arguments: Vec<Val>,
        at: impl ToTokens + Copy,
    ) -> Result {
        match receiver {
            Val::Array(items) => self.array_method(name, items, arguments, at),
            Val::Int(_) | Val::Number(_) => {
                let x = self.number(receiver, at)?;
                self.number_method(name, x, arguments, at)
            }
            other => {
                let message = format!(
                    "{} has no method `{name}`\nhelp: methods are of numbers and arrays",
                    other.kind()
                );
                Err(self.errors.push(name, message))
            }
        }
    }

    fn number_method(
        &mut self,
        name: &Ident,
        x: Value,
        arguments: Vec<Val>,
        at: impl ToTokens + Copy,
    ) -> Result {
        let text = name.to_string();
        if !is_method(&text) {
            let hint = did_you_mean(&text, METHODS.into_iter().chain(TABLE.iter().map(|row| row.name)));
            let help = match ARRAY_METHODS.contains(&text.as_str()) {
                true => "\nhelp: this is a method of arrays",
                false if hint.is_empty() => "\nhelp: a function of your own is called as `f(x)`",
                false => "",
            };
            return Err(self.errors.push(name, format!("unknown function `{text}`{hint}{help}")));
        }
        self.arity(&text, method_arity(&text), arguments.len(), name)?;
        self.check_constant(name, x, &arguments)?;
        if text == "powi" {
            let Val::Int(n) = arguments[0] else {
                let message = "`powi` takes an integer that is known at compile time\nhelp: other powers are `x.powf(y)`";
                return Err(self.errors.push(at, message));
            };
            let Some(n) = i32::try_from(n).ok().filter(|n| n.abs() <= 1000) else {
                let message = "this exponent is too large\nhelp: an exponent is between -1000 and 1000";
                return Err(self.errors.push(at, message));
            };
            if x.is_zero() && n < 0 {
                return Err(self.errors.push(at, "division by zero"));
            }
            return Ok(Val::Number(self.graph.powi(x, n)));
        }
        let arguments = arguments.into_iter().map(|a| self.number(a, at)).collect::<Result<Vec<_>>>()?;
        let g = &mut self.graph;
        let degree = Value { k: Number::float(std::f64::consts::PI / 180.0), node: None };
        Ok(Val::Number(match (text.as_str(), arguments.as_slice()) {
            ("recip", []) if x.is_zero() => return Err(self.errors.push(at, "division by zero")),
            ("recip", []) => g.recip(x),
            ("tan", []) => {
                // As a quotient it shares the sine and cosine of the same angle.
                let (s, c) = (g.call(Function::sin, x), g.call(Function::cos, x));
                if c.is_zero() { g.call(Function::tan, x) } else { g.div(s, c) }
            }
            ("sin_cos", []) => {
                let pair = [Function::sin, Function::cos].map(|f| Val::Number(g.call(f, x)));
                return Ok(Val::Array(pair.to_vec()));
            }
            ("to_radians", []) => g.mul(x, degree),
            ("to_degrees", []) => g.div(x, degree),
            ("min", &[y]) => g.choose(true, x, y),
            ("max", &[y]) => g.choose(false, x, y),
            ("clamp", &[low, high]) => {
                let above = g.choose(false, x, low);
                g.choose(true, above, high)
            }
            ("mul_add", &[a, b]) => {
                let product = g.mul(x, a);
                g.add(product, b)
            }
            (_, []) => g.call(Function::named(&text).expect("a method of the table"), x),
            (_, &[y]) => g.call2(Function::named(&text).expect("a method of the table"), x, y),
            _ => unreachable!("the arity was checked"),
        }))
    }

    /// A function of constants that has no value there.
    fn check_constant(&mut self, name: &Ident, x: Value, arguments: &[Val]) -> Result<()> {
        let Some(function) = Function::named(&name.to_string()) else { return Ok(()) };
        let constants: Option<Vec<f64>> = std::iter::once(Some(x))
            .chain(arguments.iter().map(|a| match a {
                Val::Int(n) => Some(Value::constant(*n)),
                Val::Number(value) => Some(*value),
                _ => None,
            }))
            .map(|value| value.filter(|v| v.is_constant()).map(|v| v.k.to_f64()))
            .collect();
        let Some(constants) = constants else { return Ok(()) };
        let value = (function.row().value)(&constants);
        if value.is_finite() {
            return Ok(());
        }
        let arguments: Vec<String> = constants.iter().map(f64::to_string).collect();
        let message = format!(
            "`{name}` of {} is {value}\nhelp: the result of a function of constants is a finite number",
            arguments.join(", ")
        );
        Err(self.errors.push(name, message))
    }

    fn array_method(
        &mut self,
        name: &Ident,
        items: Vec<Val>,
        arguments: Vec<Val>,
        at: impl ToTokens + Copy,
    ) -> Result {
        let text = name.to_string();
        let arity =
            usize::from(matches!(text.as_str(), "map" | "zip" | "dot" | "cross" | "chain" | "take" | "skip"));
        if !ARRAY_METHODS.contains(&text.as_str()) {
            let hint = did_you_mean(&text, ARRAY_METHODS);
            let help = match is_method(&text) {
                true => format!("\nhelp: of each element, `x.map(|x| x.{text}(…))`"),
                false => String::new(),
            };
            return Err(self.errors.push(name, format!("an array has no method `{text}`{hint}{help}")));
        }
        self.arity(&text, arity, arguments.len(), name)?;
        let numbers = |e: &mut Self, items: Vec<Val>| {
            items.into_iter().map(|v| e.number(v, at)).collect::<Result<Vec<_>>>()
        };
        match (text.as_str(), arguments.into_iter().next()) {
            ("iter" | "into_iter" | "collect" | "copied" | "cloned", None) => Ok(Val::Array(items)),
            ("len" | "count", None) => Ok(Val::Int(items.len() as i64)),
            ("rev", None) => Ok(Val::Array(items.into_iter().rev().collect())),
            ("enumerate", None) => {
                let pair = |(i, item)| Val::Array(vec![Val::Int(i as i64), item]);
                Ok(Val::Array(items.into_iter().enumerate().map(pair).collect()))
            }
            ("map", Some(Val::Closure(closure))) => Ok(Val::Array(
                items.into_iter().map(|item| self.apply(&closure, vec![item], at)).collect::<Result<_>>()?,
            )),
            ("zip", Some(Val::Array(others))) => {
                let pairs = items.into_iter().zip(others);
                Ok(Val::Array(pairs.map(|(a, b)| Val::Array(vec![a, b])).collect()))
            }
            ("chain", Some(Val::Array(others))) => Ok(Val::Array(items.into_iter().chain(others).collect())),
            ("take" | "skip", Some(Val::Int(n))) => {
                let n = self.count(n, at)?.min(items.len());
                Ok(Val::Array(if text == "take" { items[..n].to_vec() } else { items[n..].to_vec() }))
            }
            // A sum of whole numbers stays whole.
            ("sum", None) if items.iter().all(|item| matches!(item, Val::Int(_))) => {
                let total = items.iter().try_fold(0i64, |sum, item| match item {
                    Val::Int(n) => sum.checked_add(*n),
                    _ => None,
                });
                total.map(Val::Int).ok_or_else(|| self.errors.push(at, "this integer overflows"))
            }
            ("sum", None) => {
                let mut total = items[0].clone();
                for item in &items[1..] {
                    total = self.added(total, item.clone(), at)?;
                }
                Ok(total)
            }
            ("product", None) => {
                let numbers = numbers(self, items)?;
                Ok(Val::Number(numbers.into_iter().fold(Value::ONE, |p, x| self.graph.mul(p, x))))
            }
            ("norm" | "norm_squared", None) => {
                let numbers = numbers(self, items)?;
                let square = self.inner(&numbers, &numbers);
                Ok(Val::Number(if text == "norm" { self.graph.call(Function::sqrt, square) } else { square }))
            }
            ("dot", Some(Val::Array(others))) if others.len() == items.len() => {
                let (a, b) = (numbers(self, items)?, numbers(self, others)?);
                Ok(Val::Number(self.inner(&a, &b)))
            }
            ("cross", Some(Val::Array(others))) if others.len() == 3 && items.len() == 3 => {
                let (a, b) = (numbers(self, items)?, numbers(self, others)?);
                let component = |i: usize| {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    let (p, m) = (self.graph.mul(a[j], b[k]), self.graph.mul(a[k], b[j]));
                    Val::Number(self.graph.sub(p, m))
                };
                Ok(Val::Array((0..3).map(component).collect()))
            }
            (_, Some(other)) => Err(self.errors.push(at, format!("`{text}` does not take {}", other.kind()))),
            (_, None) => Err(self.errors.push(at, format!("`{text}` needs its argument"))),
        }
    }

    fn added(&mut self, a: Val, b: Val, at: impl ToTokens + Copy) -> Result {
        match (a, b) {
            (Val::Array(a), Val::Array(b)) if a.len() == b.len() => {
                let pairs = a.into_iter().zip(b);
                Ok(Val::Array(pairs.map(|(a, b)| self.added(a, b, at)).collect::<Result<_>>()?))
            }
            (a, b) => {
                let (a, b) = (self.number(a, at)?, self.number(b, at)?);
                let sum = self.graph.add(a, b);
                // A partial sum may be a binding of the user's.
                let bound = sum.node.and_then(|n| self.bound.get(&n)).map(|symbol| symbol.scaled(sum.k));
                Ok(Val::Number(bound.unwrap_or(sum)))
            }
        }
    }

    fn inner(&mut self, a: &[Value], b: &[Value]) -> Value {
        a.iter().zip(b).fold(Value::ZERO, |sum, (a, b)| {
            let product = self.graph.mul(*a, *b);
            self.graph.add(sum, product)
        })
    }
}

const METHODS: [&str; 9] =
    ["powi", "recip", "sin_cos", "to_radians", "to_degrees", "min", "max", "clamp", "mul_add"];
const ARRAY_METHODS: [&str; 20] = [
    "map",
    "sum",
    "product",
    "iter",
    "into_iter",
    "collect",
    "copied",
    "cloned",
    "len",
    "count",
    "rev",
    "enumerate",
    "zip",
    "chain",
    "take",
    "skip",
    "dot",
    "cross",
    "norm",
    "norm_squared",
];

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

fn is_literal(expression: &Expr) -> bool {
    match expression {
        Expr::Lit(_) => true,
        Expr::Paren(inner) => is_literal(&inner.expr),
        Expr::Unary(inner) => is_literal(&inner.expr),
        _ => false,
    }
}

fn constant(name: &str) -> Option<f64> {
    use std::f64::consts;
    Some(match name {
        "PI" => consts::PI,
        "TAU" => consts::TAU,
        "E" => consts::E,
        "SQRT_2" => consts::SQRT_2,
        "LN_2" => consts::LN_2,
        "LN_10" => consts::LN_10,
        "FRAC_PI_2" => consts::FRAC_PI_2,
        "FRAC_PI_3" => consts::FRAC_PI_3,
        "FRAC_PI_4" => consts::FRAC_PI_4,
        "FRAC_PI_6" => consts::FRAC_PI_6,
        "FRAC_PI_8" => consts::FRAC_PI_8,
        "FRAC_1_PI" => consts::FRAC_1_PI,
        "FRAC_2_PI" => consts::FRAC_2_PI,
        "FRAC_1_SQRT_2" => consts::FRAC_1_SQRT_2,
        _ => return None,
    })
}

/// Names that mean something already.
fn reserved(name: &str) -> Option<String> {
    match name {
        "t" => Some("`t` is time\nhelp: choose another name".into()),
        "dot" => Some("`dot` is the time derivative\nhelp: choose another name".into()),
        _ if name.starts_with("r#") => {
            Some(format!("`{name}` is a keyword of Rust\nhelp: choose another name"))
        }
        _ if is_method(name) => {
            Some(format!("`{name}` is an elementary function\nhelp: choose another name"))
        }
        _ => None,
    }
}

pub(super) fn numbers(val: &Val) -> Vec<Value> {
    match val {
        Val::Int(n) => vec![Value::constant(*n)],
        Val::Number(value) => vec![*value],
        Val::Array(items) => items.iter().flat_map(numbers).collect(),
        _ => Vec::new(),
    }
}
