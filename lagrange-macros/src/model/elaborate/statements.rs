//! Elaboration of each statement of a system.

use super::*;
use crate::graph::Node;
use crate::model::Layout;
use crate::syntax::Kind;

impl Elaborator<'_> {
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
                self.not_kinetic = Some("a force");
                let _ = self.force(force, at);
                self.not_kinetic = None;
            }
            Statement::Couple { couple, on } => {
                self.not_kinetic = Some("a couple");
                let _ = self.couple(couple, on);
                self.not_kinetic = None;
            }
            Statement::Observe(d) => self.observe(d),
            Statement::Event(event) => {
                let _ = self.event(event);
            }
            Statement::Constraint { declared, sides, redundant } => {
                let name = &declared.name;
                let entry = match sides {
                    Some((left, right)) => {
                        self.constraint(declared, left, right, *redundant).unwrap_or(Entry::Broken)
                    }
                    // Without `:` the name may be the first word of the equation.
                    None if self.scope.names.contains_key(&name.to_string()) => return,
                    None => Entry::Broken,
                };
                self.define(name, entry);
            }
            Statement::Impulse { attributes, name, at } => {
                let _ = at.as_ref().map(|at| self.impulse(attributes, name, at));
            }
            Statement::Routhian(header) => self.routhian(header),
            Statement::Const(_)
            | Statement::Submodel(_)
            | Statement::Param(_)
            | Statement::State(_)
            | Statement::Function { .. }
            | Statement::Extern { .. }
            | Statement::Unread(_) => {}
        }
    }

    /// `routhian Reduced;`
    fn routhian(&mut self, header: &Header) {
        if self.found.routhian.is_some() {
            let message = "a second `routhian`\nhelp: remove it; all ignorable coordinates leave at once";
            self.errors.push(&header.name, message);
        }
        self.found.routhian = Some(header.clone());
    }

    /// `coord phi = omega * t;`
    pub(super) fn prescribe(&mut self, d: &Declaration) {
        let Some(expression) = &d.value else { return };
        if d.kind == Kind::Direction {
            let message = format!(
                "a direction that is given is no coordinate\nhelp: write `let {} = [x, y, z];`, with components that are functions of time",
                d.name
            );
            self.errors.push(expression, message);
            return self.define(&d.name, Entry::Broken);
        }
        if d.kind == Kind::Rotation {
            let message = format!(
                "a rotation that is given is no coordinate\nhelp: write `let {} = rotation_z(omega * t);`, with angles that are functions of time",
                d.name
            );
            self.errors.push(expression, message);
            return self.define(&d.name, Entry::Broken);
        }
        let entry = match self.whole_or_family(d, expression) {
            Err(_) => Entry::Broken,
            Ok(
                val @ (Val::Closure(_)
                | Val::Bool(_)
                | Val::Condition(_)
                | Val::Reference(_)
                | Val::Typed(..)
                | Val::Tuple(_)),
            ) => {
                let message = format!(
                    "a prescribed coordinate is a number, and this is {}\nhelp: write its motion as an expression of `t`",
                    val.kind()
                );
                self.errors.push(expression, message);
                Entry::Broken
            }
            Ok(val) => {
                let numbers = numbers(&val);
                let of_states = self.independent_of_states(&numbers, "a prescribed coordinate", expression);
                if of_states.is_err() {
                    Entry::Broken
                } else if self.graph.depends(&numbers, |s| {
                    !matches!(s, Symbol::Time | Symbol::Parameter(_) | Symbol::Binding(_))
                }) || self.moves_with_coordinates(&numbers)
                {
                    let name = d.name.to_string();
                    let help = match name.as_str() {
                        "T" | "V" | "L" | "D" => {
                            format!("an energy is a statement of its own, with `;` before `{name} = …`")
                        }
                        _ => format!("if `{name}` follows from the coordinates, write `let {name} = …;`"),
                    };
                    let message = format!(
                        "a prescribed coordinate is a function of time and parameters alone\nhelp: {help}"
                    );
                    self.errors.push(expression, message);
                    Entry::Broken
                } else if !self.graph.depends(&numbers, |s| matches!(s, Symbol::Time | Symbol::Binding(_))) {
                    if self.is_derived() {
                        return self.define(&d.name, Entry::Let(val));
                    }
                    if let Some(input) = self.an_input(&numbers) {
                        let message = format!(
                            "`coord {0} = …` prescribes a motion, and `{input}` is an input, which is held between steps and jumps there\nhelp: a drive that follows a command has a stiffness, `coord {0}; V = 0.5 * k * ({0} - {input}).powi(2);`, and a damper in `D`; a motion that is known beforehand is a function of time, `coord {0} = a * sin(w * t);`, or `extern path: Curve(t); coord {0} = path(t);`; an ideal drive is `coord {0}; constraint drive: {0} == {input};`, for which each new command is followed by `consistent`",
                            d.name
                        );
                        self.errors.push(expression, message);
                        return self.define(&d.name, Entry::Broken);
                    }
                    let message = format!(
                        "`coord {0} = …` prescribes a motion, and this does not depend on time\nhelp: where a motion starts is said when it is integrated, `State::new(t, [q, …], [velocity, …])`; a constant is a `param`, or `let {0} = …;`",
                        d.name
                    );
                    self.errors.push(expression, message);
                    Entry::Broken
                } else {
                    Entry::Prescribed(self.given_motion(d, val))
                }
            }
        };
        self.define(&d.name, entry);
    }

    /// The name of an input that these depend on.
    fn an_input(&self, values: &[Value]) -> Option<String> {
        let symbols = self.graph.symbols(values);
        let is_used = |p: &&Parameter| {
            p.input && symbols.iter().any(|s| matches!(s, Symbol::Parameter(i) if p.numbers().contains(i)))
        };
        self.found.parameters.iter().find(is_used).map(|p| p.name.to_string())
    }

    /// Bindings for a prescribed motion. It is not what an equal expression elsewhere is written with: the reaction is
    /// found by letting this coordinate go, which must not move that expression.
    fn given_motion(&mut self, d: &Declaration, val: Val) -> Val {
        let name = d.name.to_string();
        let given = |e: &mut Self, label: String, value: Value| {
            let rate = e.rate(value);
            let binding = e.found.bindings.len();
            e.found.bindings.push(Binding { name: label.clone(), value, rate, motion: Motion::Position });
            e.found.prescribed.push(Prescribed { name: label, binding });
            e.graph.symbol(Symbol::Rate(binding));
            Val::Number(e.graph.symbol(Symbol::Binding(binding)))
        };
        match val {
            Val::Array(_) => {
                let values = numbers(&val).into_iter().enumerate();
                Val::Array(values.map(|(i, v)| given(self, indexed(&name, Some(i)), v)).collect())
            }
            Val::Number(value) => given(self, name, value),
            other => other,
        }
    }

    /// One side of a constraint; of a family of them an array.
    fn side(&mut self, declared: &Declaration, side: &Expr) -> Result {
        let length = self.length(declared)?;
        match (length, self.evaluate(side)?) {
            (Some(length), Val::Closure(closure)) => {
                let items = (0..length).map(|i| self.apply(&closure, vec![Val::Int(i as i64)], side));
                Ok(Val::Array(items.collect::<Result<_>>()?))
            }
            (_, other) => Ok(other),
        }
    }

    /// `constraint name: left == right;`, or `constraint name: [N] = |i| left == right;`.
    fn constraint(
        &mut self,
        declared: &Declaration,
        left: &Expr,
        right: &Expr,
        redundant: bool,
    ) -> Result<Entry> {
        let name = &declared.name;
        let (l, r) = (self.side(declared, left), self.side(declared, right));
        let (l, r) = (l?, r?);
        for (side, at) in [(&l, left), (&r, right)] {
            if let Val::Frame(_) | Val::Rotation(_) = side {
                self.number(side.clone(), at)?;
            }
        }
        let length = |val: &Val| match val {
            Val::Array(items) => Some(items.len()),
            _ => None,
        };
        let shape = length(&l);
        if shape != length(&r) {
            let of = |n: Option<usize>| n.map_or("a number".into(), |n| format!("an array of {n}"));
            let message = format!(
                "{} cannot equal {}\nhelp: both sides have the same shape, as in `[x, y] == [0, 0]`",
                of(shape),
                of(length(&r))
            );
            return Err(self.errors.push(right, message));
        }
        let sides = |e: &mut Self, val: Val, at: &Expr| match val {
            Val::Array(items) => items.into_iter().map(|item| e.number(item, at)).collect::<Result<Vec<_>>>(),
            scalar => e.number(scalar, at).map(|v| vec![v]),
        };
        let (l, r) = (sides(self, l, left)?, sides(self, r, right)?);
        if l.is_empty() {
            return Err(self.errors.push(left, "a constraint of no elements\nhelp: remove it"));
        }
        let (first, mut dropped) = (self.found.constraints.len(), false);
        let equals = <syn::Token![==]>::default();
        let written: TokenStream =
            [left.to_token_stream(), equals.to_token_stream(), right.to_token_stream()].into_iter().collect();
        for (i, (l, r)) in l.into_iter().zip(r).enumerate() {
            let value = self.graph.sub(l, r);
            if value.is_zero() && self.is_derived() {
                // It holds where the coordinates are held, and has no multiplier there.
                dropped = true;
                continue;
            }
            let index = shape.map(|_| i);
            let label = indexed(&name.to_string(), index);
            if value.is_constant() {
                let message = match value.is_zero() {
                    true => format!("the constraint `{label}` always holds\nhelp: remove it"),
                    false => format!(
                        "the constraint `{label}` can never hold\nhelp: let it depend on the coordinates"
                    ),
                };
                return Err(self.errors.push(&written, message));
            }
            self.independent_of_states(&[value], "a constraint", &written)?;
            let moving = self.graph.depends(&[value], |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_)));
            if !moving && !self.moves_with_coordinates(&[value]) {
                let message = format!(
                    "the constraint `{label}` does not depend on any coordinate\nhelp: a relation between parameters is `let`; a given motion is `coord name = f(t);`"
                );
                return Err(self.errors.push(&written, message));
            }
            self.found.constraints.push(Constraint {
                name: name.clone(),
                index,
                value,
                written: written.clone(),
                redundant,
            });
        }
        Ok(if dropped { Entry::Broken } else { Entry::Constraint { first, length: shape } })
    }

    /// The constraints that give directions of this name the length 1.
    pub(super) fn length_of_direction(&self, name: &str) -> Option<Entry> {
        let is_direction = |c: &Coordinate| c.kind == Kind::Direction && c.name == name;
        self.found.coordinates.iter().find(|c| is_direction(c))?;
        let first = self.found.constraints.iter().position(|c| c.name == name)?;
        let all = self.found.constraints[first..].iter().take_while(|c| c.name == name).count();
        Some(Entry::Constraint { first, length: self.found.constraints[first].index.map(|_| all) })
    }

    /// `reaction(name)`: the generalized force at a prescribed coordinate, or the multiplier of a constraint.
    pub(super) fn reaction(&mut self, name: &Ident, call: &syn::ExprCall) -> Result {
        self.arity("reaction", 1, call.args.len(), name)?;
        let of = &call.args[0];
        if !self.observing {
            let message = "a reaction is known only when the equations are solved\nhelp: it may be observed, as in `observe R = reaction(phi);`";
            return Err(self.errors.push(call, message));
        }
        let (base, index, mut known) = self.named(of);
        if let Some(direction) = self.length_of_direction(&base.to_token_stream().to_string()) {
            known = Some(direction);
        }
        match known {
            Some(Entry::Constraint { first, length }) => {
                let symbol = |g: &mut Graph, i| Val::Number(g.symbol(Symbol::Multiplier(first + i)));
                match (length, index) {
                    (None, None) => Ok(symbol(&mut self.graph, 0)),
                    (Some(n), None) => Ok(Val::Array((0..n).map(|i| symbol(&mut self.graph, i)).collect())),
                    (n, Some(index)) => {
                        let i = self.index(index, n.unwrap_or(0))?;
                        Ok(symbol(&mut self.graph, i))
                    }
                }
            }
            Some(Entry::Prescribed(_)) => {
                let val = self.evaluate(of)?;
                let prescribed = &self.found.prescribed;
                let graph = &mut self.graph;
                let mut symbol = |value: &Value| {
                    let node = value.node.map(|n| graph.node(n).clone());
                    let at = prescribed
                        .iter()
                        .position(|p| node == Some(crate::graph::Node::Symbol(Symbol::Binding(p.binding))));
                    Val::Number(graph.symbol(Symbol::Reaction(at.expect("it is prescribed"))))
                };
                let symbols: Vec<Val> = numbers(&val).iter().map(&mut symbol).collect();
                match val {
                    Val::Array(_) => Ok(Val::Array(symbols)),
                    _ => Ok(symbols[0].clone()),
                }
            }
            Some(Entry::Broken) => Err(Reported),
            // The motion is neglected, and with it this output.
            _ if self.is_derived() => Err(Reported),
            _ => {
                let mut all: Vec<String> = self.found.prescribed.iter().map(|p| p.name.clone()).collect();
                all.extend(self.found.constraints.iter().map(|c| c.name.to_string()));
                all.dedup();
                let text = base.to_token_stream().to_string();
                if self.scope.unread.contains_key(&text) {
                    return Err(Reported);
                }
                let hint = did_you_mean(&text, all.iter().map(String::as_str));
                let help = match all.is_empty() {
                    true => "no prescribed coordinate and no constraint stands above this statement".into(),
                    false => {
                        let all: Vec<String> = all.iter().map(|name| format!("`{name}`")).collect();
                        format!("those above this statement are {}", all.join(", "))
                    }
                };
                let message = format!(
                    "`{text}` is neither a prescribed coordinate nor a constraint{hint}\nhelp: {help}"
                );
                Err(self.errors.push(of, message))
            }
        }
    }

    /// `impulse blow at [x, y];`
    fn impulse(&mut self, attributes: &[syn::Attribute], name: &Ident, at: &Expr) -> Result<()> {
        self.output_name(name);
        let val = self.evaluate(at)?;
        let scalar = !matches!(val, Val::Array(_));
        let position = match val {
            Val::Array(items) => items.into_iter().map(|v| self.number(v, at)).collect::<Result<Vec<_>>>()?,
            scalar => vec![self.number(scalar, at)?],
        };
        self.check_point(&position, at)?;
        self.found.struck.push(Struck {
            attributes: attributes.to_vec(),
            name: name.clone(),
            position,
            scalar,
        });
        Ok(())
    }

    pub(super) fn bind(&mut self, d: &Declaration) {
        if let Some(zero) = self.neglected(&d.name) {
            return self.define(&d.name, Entry::Let(zero));
        }
        let entry = match &d.value {
            None => {
                self.errors
                    .push(&d.name, format!("a binding needs its value\nhelp: write `let {} = …;`", d.name));
                Entry::Broken
            }
            Some(value) => {
                self.naming = Some(d.name.to_string());
                let val = self.whole_or_family(d, value);
                self.naming = None;
                val.map_or(Entry::Broken, Entry::Let)
            }
        };
        if let (Entry::Let(val), Some(value)) = (&entry, &d.value) {
            self.found.framed |= val.has_frames();
            let length = d.length.as_ref().map_or(String::new(), |n| format!(": [{}]", n.to_token_stream()));
            self.found.written.push((format!("let {}{length}", d.name), value.to_token_stream()));
        }
        match entry {
            Entry::Let(val @ (Val::Reference(_) | Val::Typed(..))) => {
                let _ = self.number(val, &d.value);
                self.define(&d.name, Entry::Broken);
            }
            Entry::Let(Val::Closure(closure)) => {
                let arguments = plain(&closure.expression.inputs);
                let message = format!(
                    "a binding is a number, a condition or an array of numbers\nhelp: a function is `fn {}({arguments}) = …;`",
                    d.name
                );
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
    pub(super) fn whole_or_family(&mut self, d: &Declaration, value: &Expr) -> Result {
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
    pub(super) fn family(&mut self, name: &str, length: usize, closure: &Closure, at: &Expr) -> Result {
        let mut items = Vec::new();
        let before = self.family.replace(name.to_string());
        for i in 0..length {
            let mut scope = closure.scope.clone();
            scope.push((name.to_string(), Val::Array(items.clone())));
            let closure = Closure { expression: Rc::clone(&closure.expression), scope };
            self.naming = self.naming.is_some().then(|| indexed(name, Some(i)));
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
    pub(super) fn bound_value(&mut self, name: &str, index: Option<usize>, val: Val) -> Val {
        let label = indexed(name, index);
        match val {
            Val::Number(value) => Val::Number(self.bound_number(&label, value)),
            Val::Array(items) => {
                let items = items.into_iter().enumerate();
                Val::Array(items.map(|(i, item)| self.bound_value(&label, Some(i), item)).collect())
            }
            Val::Tuple(items) => {
                let items = items.into_iter().enumerate();
                Val::Tuple(items.map(|(i, item)| self.bound_value(&label, Some(i), item)).collect())
            }
            other => other,
        }
    }

    pub(super) fn bound_number(&mut self, name: &str, value: Value) -> Value {
        let symbols = self.graph.symbols(&[value]);
        let moves =
            symbols.iter().any(|s| matches!(s, Symbol::Coordinate(_) | Symbol::Time | Symbol::Binding(_)));
        let has_rates = symbols.iter().any(|s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_)));
        // Another name for a symbol needs no symbol of its own.
        if !moves
            || has_rates
            || symbols.len() == 1 && value.node.is_some_and(|n| matches!(self.graph.node(n), Node::Symbol(_)))
        {
            return value;
        }
        let written = value;
        let value = self.by_earlier(value);
        let rate = self.rate(value);
        let k = self.found.bindings.len();
        self.found.bindings.push(Binding { name: name.to_string(), value, rate, motion: Motion::Position });
        let symbol = self.graph.symbol(Symbol::Binding(k));
        self.graph.symbol(Symbol::Rate(k));
        for v in [written, value] {
            let Some(node) = v.node else { continue };
            let whole = symbol.scaled(v.k.recip());
            self.bound.insert(node, whole);
            let terms = self.graph.terms(node.into());
            if terms.len() > 1 {
                terms
                    .iter()
                    .filter_map(|term| term.node)
                    .for_each(|id| self.sums_with.insert(id, self.sums.len()));
                self.sums.push((whole, terms));
            }
            let &Node::Sum(a, b) = self.graph.node(node) else { continue };
            for (term, rest) in [(a, b), (b, a)] {
                if let Some(node) = term.node.filter(|n| !matches!(self.graph.node(*n), Node::Symbol(_))) {
                    let term_by_whole = self.graph.sub(whole, rest).scaled(term.k.recip());
                    self.terms.insert(node, term_by_whole);
                }
            }
        }
        symbol
    }

    /// A definition by earlier bindings, where that makes it shorter: of x₁ = s + l sin θ₁ and x₂ = s + l sin θ₁ + l
    /// sin θ₂ the second is x₁ + l sin θ₂, however its terms are grouped. A chain that is written from its base for
    /// each link is so written from link to link. A common factor in front of a sum hides its terms. Elsewhere, as in
    /// l sin θ₁ cos θ₂, one of two terms is the binding less the other.
    fn by_earlier(&mut self, value: Value) -> Value {
        let terms = &self.terms;
        let term_by_term = self.graph.replace(&[value], |id, _| terms.get(&id).copied())[0];
        let whole = by_another(&mut self.graph, value, &self.sums, &self.sums_with);
        let length = |v: &Value| self.graph.live(&[*v]).len();
        if term_by_term == value && whole.is_none() {
            return value;
        }
        [value, term_by_term].into_iter().chain(whole).min_by_key(length).unwrap_or(value)
    }

    /// The velocity of a position.
    pub fn velocity(&mut self, position: Value) -> Value {
        let is_written = position.node.is_some_and(|n| {
            !matches!(self.graph.node(n), Node::Symbol(Symbol::Coordinate(_) | Symbol::Time))
        });
        if !self.observing && is_written {
            self.found.moved.push(position);
        }
        self.rate(position)
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

    /// Do these depend on states of first order?
    pub(in crate::model) fn of_states(&self, values: &[Value]) -> bool {
        let states = self.found.states.first().map_or(usize::MAX, |state| state.first);
        self.graph.depends(values, |s| matches!(s, Symbol::Velocity(i) if i >= states))
    }

    /// Refuses positions that states of first order move: their accelerations would need rates of rates.
    pub(super) fn independent_of_states(
        &mut self,
        values: &[Value],
        what: &str,
        at: impl ToTokens,
    ) -> Result<()> {
        if !self.of_states(values) {
            return Ok(());
        }
        let message = format!(
            "{what} depends on a state of first order\nhelp: positions are made of coordinates, parameters and time; `V`, `D`, forces, rates and outputs may depend on states"
        );
        Err(self.errors.push(at, message))
    }

    /// Do these depend on coordinates through bindings?
    pub(super) fn moves_with_coordinates(&mut self, numbers: &[Value]) -> bool {
        let symbols = self.graph.symbols(numbers);
        symbols.into_iter().any(|s| match s {
            Symbol::Coordinate(_) => true,
            Symbol::Binding(k) => self.moves_with_coordinates(&[self.found.bindings[k].value]),
            _ => false,
        })
    }

    pub(super) fn energy(&mut self, keyword: &Ident, expression: &Expr) {
        let slot = ["T", "V", "L", "D"].iter().position(|name| keyword == name);
        let slot = slot.expect("the statement begins with one of them");
        if keyword == "L" && self.is_of_energies(expression) {
            let message = "L = T − V is formed already\nhelp: remove this statement";
            self.errors.push(keyword, message);
            return;
        }
        self.not_kinetic = [None, Some("`V`"), None, Some("`D`")][slot];
        let value = self.scalar(expression);
        self.not_kinetic = None;
        let Ok(value) = value else {
            self.found.energies[slot].get_or_insert((keyword.clone(), Value::ZERO));
            return;
        };
        if self.found.energies[slot].is_some() {
            let help = format!("add them in one statement, `{keyword} = … + …;`");
            self.errors.push(keyword, format!("a second `{keyword}`\nhelp: {help}"));
        }
        crate::model::check::energy(self, keyword, expression, value);
        self.found.written.push((keyword.to_string(), expression.to_token_stream()));
        self.found.energies[slot] = Some((keyword.clone(), value));
    }

    /// `T - V`, where these are not names of something else.
    fn is_of_energies(&self, expression: &Expr) -> bool {
        let energy = |e: &Expr, keyword: &str| {
            matches!(e, Expr::Path(path) if path.path.is_ident(keyword))
                && !self.scope.names.contains_key(keyword)
        };
        matches!(expression, Expr::Binary(b) if energy(&b.left, "T") && energy(&b.right, "V"))
    }

    /// `Q[theta] = …;`, or for a whole array of coordinates at once.
    pub(super) fn generalized_force(
        &mut self,
        keyword: &Ident,
        coordinate: &Expr,
        value: &Expr,
    ) -> Result<()> {
        let rate = keyword == "rate";
        if let Some(attitudes) = self.turned_targets(coordinate)?.filter(|_| !rate) {
            return self.moments_on(&attitudes, coordinate, value);
        }
        if self.applied_where_held(coordinate, value)? {
            return Ok(());
        }
        let targets = if rate { self.rated(coordinate)? } else { self.targets(coordinate)? };
        let values = self.evaluate(value).and_then(|val| match val {
            Val::Closure(_) if targets.len() > 1 => {
                let message = format!(
                    "expected an array, found a closure\nhelp: an array is `(0..{}).map(|i| …)`",
                    targets.len()
                );
                Err(self.errors.push(value, message))
            }
            Val::Array(items) => items.into_iter().map(|item| self.number(item, value)).collect(),
            scalar => Ok(vec![self.number(scalar, value)?]),
        });
        let values = values.inspect_err(|_| self.given(&targets))?;
        if values.len() != targets.len() {
            self.given(&targets);
            let (given, of) = (values.len(), targets.len());
            let message = match rate {
                true => format!(
                    "{} for {}\nhelp: one rate for each state, as in `rate(z) = [f, g];`",
                    counted(given, "rate"),
                    counted(of, "state")
                ),
                false => format!(
                    "{} for {}\nhelp: one force for each coordinate, as in `Q[x] = [f, g];`",
                    counted(given, "force"),
                    counted(of, "coordinate")
                ),
            };
            return Err(self.errors.push(value, message));
        }
        for (i, q) in targets.into_iter().zip(values) {
            if self.found.applied[i].is_some() {
                let label = self.found.coordinates[i].label();
                let message = match rate {
                    true => format!(
                        "a second `rate({label})`\nhelp: add the two in one statement, `rate({label}) = … + …;`"
                    ),
                    false => format!(
                        "a second `Q[{label}]`\nhelp: add the two forces in one statement, `Q[{label}] = … + …;`"
                    ),
                };
                self.errors.push(coordinate, message);
            }
            self.found.applied[i] = Some(q);
        }
        Ok(())
    }

    /// Something is written for these, though what it is could not be read.
    fn given(&mut self, targets: &[usize]) {
        for i in targets {
            self.found.applied[*i].get_or_insert(Value::ZERO);
        }
    }

    /// The coordinates that an expression names.
    pub(super) fn targets(&mut self, expression: &Expr) -> Result<Vec<usize>> {
        let (base, index, known) = self.named(expression);
        match (known, index) {
            (Some(Entry::Coordinate { first, length: None }), None) => Ok(vec![first]),
            (Some(Entry::Coordinate { first, length: Some(n) }), None) => Ok((first..first + n).collect()),
            (Some(Entry::Coordinate { first, length: Some(n) }), Some(index)) => {
                Ok(vec![first + self.index(index, n)?])
            }
            (Some(Entry::Broken), _) => Err(Reported),
            (Some(Entry::Coordinate { length: None, .. }), Some(_)) => {
                let name = base.to_token_stream();
                let message =
                    format!("the coordinate `{name}` has no elements\nhelp: write `Q[{name}] = …;`");
                Err(self.errors.push(expression, message))
            }
            (Some(Entry::State { .. }), _) => {
                let state = plain(expression);
                let message = format!(
                    "`{state}` is a state of first order, on which no force acts\nhelp: its rate is `rate({state}) = …;`"
                );
                Err(self.errors.push(expression, message))
            }
            (Some(Entry::Prescribed(_)), _) => {
                let message = "the motion of a prescribed coordinate is given, whatever forces act on it\nhelp: remove this `Q`";
                Err(self.errors.push(expression, message))
            }
            _ => {
                let text = base.to_token_stream().to_string();
                if self.scope.unread.contains_key(&text) {
                    return Err(Reported);
                }
                let states = self.found.states.first().map_or(usize::MAX, |state| state.first);
                let mut coordinates: Vec<String> =
                    self.found.coordinates.iter().take(states).map(|c| c.name.to_string()).collect();
                coordinates.dedup();
                let hint = did_you_mean(&text, coordinates.iter().map(String::as_str));
                let list: Vec<String> = coordinates.iter().map(|c| format!("`{c}`")).collect();
                let help = match list.as_slice() {
                    [] => String::new(),
                    [one] => format!("\nhelp: the coordinate of this system is {one}"),
                    all => format!("\nhelp: the coordinates of this system are {}", all.join(", ")),
                };
                Err(self.errors.push(base, format!("`{}` is not a coordinate{hint}{help}", plain(base))))
            }
        }
    }

    /// The states that the parentheses of `rate(…)` name, as indices of their coordinates.
    fn rated(&mut self, expression: &Expr) -> Result<Vec<usize>> {
        let (base, index, known) = self.named(expression);
        let text = plain(base);
        match (known, index) {
            (Some(Entry::State { first, length }), None) => {
                Ok((first..first + length.unwrap_or(1)).collect())
            }
            (Some(Entry::State { first, length: Some(n) }), Some(index)) => {
                Ok(vec![first + self.index(index, n)?])
            }
            (Some(Entry::State { .. }), Some(_)) => {
                let message = format!("the state `{text}` has no elements\nhelp: write `rate({text}) = …;`");
                Err(self.errors.push(expression, message))
            }
            (Some(Entry::Broken), _) => Err(Reported),
            (Some(Entry::Coordinate { .. }), _) => {
                let coordinate = plain(expression);
                let message = format!(
                    "`{coordinate}` is a coordinate: its velocity is `dot({coordinate})`, and its acceleration follows from the energies\nhelp: a force along it is `Q[{coordinate}] = …;`"
                );
                Err(self.errors.push(expression, message))
            }
            (Some(Entry::Rotation { .. }), _) => {
                let message = format!(
                    "`{text}` is a coordinate: its angular velocity is `dot({text})`, and its acceleration follows from the energies\nhelp: a torque on a body is `couple [mx, my, mz] on frame;`"
                );
                Err(self.errors.push(expression, message))
            }
            _ if self.scope.unread.contains_key(&text) => Err(Reported),
            _ => {
                let states: Vec<String> = self.found.states.iter().map(|s| s.name.to_string()).collect();
                let hint = did_you_mean(&text, states.iter().map(String::as_str));
                let message = format!(
                    "`{text}` is not a state of first order{hint}\nhelp: declare it with `state {text};`"
                );
                Err(self.errors.push(base, message))
            }
        }
    }

    /// `force F at x;`
    pub(super) fn force(&mut self, force: &Expr, at: &Expr) -> Result<()> {
        let (f, x) = (self.evaluate(force), self.evaluate(at));
        let (f, x) = (f?, x?);
        if let Val::Frame(frame) = x {
            return self.force_on_frame(f, &frame, [force, at]);
        }
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
        self.check_point(&x, at)?;
        self.found.forces.extend(f.into_iter().zip(x));
        Ok(())
    }

    /// The point of application of a force is a position that moves with the coordinates.
    fn check_point(&mut self, x: &[Value], at: &Expr) -> Result<()> {
        self.independent_of_states(x, "the point of application", at)?;
        if self.graph.depends(x, |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_))) {
            let message = "the point of application depends on velocities\nhelp: it is a position, such as `[x, y]`; a force may depend on velocities";
            return Err(self.errors.push(at, message));
        }
        if !self.graph.depends(x, |s| matches!(s, Symbol::Coordinate(_) | Symbol::Binding(_))) {
            if self.is_derived() {
                return Ok(());
            }
            let message = "this point does not move with the coordinates: a force there does no work\nhelp: remove this statement, or give the point that the force moves";
            return Err(self.errors.push(at, message));
        }
        Ok(())
    }

    /// Outputs have names of their own.
    fn output_name(&mut self, name: &Ident) {
        let reads = |c: &&Coordinate| is_function_of(name, c.kind, &c.name);
        if let Some(Coordinate { name: of, kind, .. }) = self.found.coordinates.iter().find(reads) {
            let what = if *kind == Kind::Rotation { "rotation" } else { "direction" };
            let message =
                format!("`{name}` reads or sets the {what} `{of}` already\nhelp: choose another name");
            self.errors.push(name, message);
        }
        if self.found.observed.iter().any(|o| o.name == *name)
            || self.found.struck.iter().any(|s| s.name == *name)
        {
            let message = format!("duplicate output `{name}`\nhelp: give one of them another name");
            self.errors.push(name, message);
        }
    }

    pub(super) fn observe(&mut self, d: &Declaration) {
        if let Some((_, Entry::Broken)) = self.scope.names.get(&d.name.to_string()) {
            return;
        }
        if let Some(length) = &d.length {
            let message = "the length of an output is that of its value\nhelp: remove this length";
            self.errors.push(length, message);
        }
        self.output_name(&d.name);
        self.observing = true;
        let val = match &d.value {
            Some(value) => self.evaluate(value).map(|val| (val, value.to_token_stream())),
            // `observe tip;` names a binding.
            None => self.name(&d.name).map(|val| (val, d.name.to_token_stream())),
        };
        self.observing = false;
        let Ok((val, tokens)) = val else { return };
        if let Ok((values, layout)) = self.laid_out(val, &tokens) {
            let attributes = d.attributes.clone();
            self.found.observed.push(Observed { attributes, name: d.name.clone(), values, layout });
        }
    }

    /// The numbers of a value, those of a matrix by columns.
    fn laid_out(&mut self, val: Val, at: &TokenStream) -> Result<(Vec<Value>, Layout)> {
        let Val::Array(items) = val else {
            return self.number(val, at).map(|value| (vec![value], Layout::Scalar));
        };
        if !items.iter().any(|item| matches!(item, Val::Array(_))) {
            let values = items.into_iter().map(|item| self.number(item, at)).collect::<Result<Vec<_>>>()?;
            return Ok((values, Layout::Vector));
        }
        let row = |item| match item {
            Val::Array(row) => row,
            number => vec![number],
        };
        let rows: Vec<Vec<Val>> = items.into_iter().map(row).collect();
        let columns = rows[0].len();
        if rows.iter().any(|row| row.len() != columns) {
            let lengths: Vec<String> = rows.iter().map(|row| row.len().to_string()).collect();
            let message = format!(
                "rows of a matrix have one length, but these have {}\nhelp: write as many elements in each, `[[a, b], [c, d]]`",
                lengths.join(", ")
            );
            return Err(self.errors.push(at, message));
        }
        let mut values = Vec::new();
        for j in 0..columns {
            for row in &rows {
                values.push(self.number(row[j].clone(), at)?);
            }
        }
        Ok((values, Layout::Matrix(rows.len())))
    }
}

/// A sum by the longest earlier one all of whose terms it has, times a number.
fn by_another(g: &mut Graph, v: Value, sums: &[(Value, Vec<Value>)], with: &IdMap<usize>) -> Option<Value> {
    let terms = g.terms(v);
    let mut factors: IdMap<Number> = IdMap::default();
    let mut candidates: Vec<usize> = Vec::new();
    for term in &terms {
        let Some(node) = term.node else { continue };
        factors.insert(node, term.k);
        candidates.extend(with.get(&node).filter(|at| !candidates.contains(at)));
    }
    let factor = |term: &Value| term.node.and_then(|id| factors.get(&id).copied());
    let contained = candidates.into_iter().filter_map(|at| {
        let (whole, known) = &sums[at];
        let by = known.iter().find_map(|term| Some(factor(term)?.mul(term.k.recip())))?;
        let shared = known.iter().all(|term| factor(term) == Some(term.k.mul(by)));
        shared.then(|| (known, whole.scaled(by)))
    });
    let (known, whole) = contained.max_by_key(|(known, _)| known.len())?;
    let rest = terms.into_iter().filter(|term| known.iter().all(|k| k.node != term.node));
    Some(rest.fold(whole, |sum, term| g.add(sum, term)))
}
