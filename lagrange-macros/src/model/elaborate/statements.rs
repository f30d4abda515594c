//! What each statement of a system means.

use super::*;

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
                let _ = self.force(force, at);
            }
            Statement::Observe(d) => self.observe(d),
            Statement::Constraint { name } => {
                let message = "constraints are not part of the language yet\nhelp: choose independent coordinates, and write the others with `let`";
                self.errors.push(name, message);
            }
            Statement::Routhian(header) => self.routhian(header),
            Statement::Const(_)
            | Statement::Param(_)
            | Statement::Function { .. }
            | Statement::Extern { .. }
            | Statement::Unread(_) => {}
        }
    }

    /// `routhian Reduced;`
    fn routhian(&mut self, header: &Header) {
        if self.routhian.is_some() {
            let message = "a second `routhian`\nhelp: remove it; all ignorable coordinates leave at once";
            self.errors.push(&header.name, message);
        }
        self.routhian = Some(header.clone());
    }

    /// `coord phi = omega * t;`
    pub(super) fn prescribe(&mut self, d: &Declaration) {
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

    pub(super) fn bind(&mut self, d: &Declaration) {
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
    pub(super) fn moves_with_coordinates(&mut self, numbers: &[Value]) -> bool {
        let symbols = self.graph.symbols(numbers);
        symbols.into_iter().any(|s| match s {
            Symbol::Coordinate(_) => true,
            Symbol::Binding(k) => self.moves_with_coordinates(&[self.bindings[k].value]),
            _ => false,
        })
    }

    pub(super) fn energy(&mut self, keyword: &Ident, expression: &Expr) {
        let slot = ["T", "V", "L", "D"].iter().position(|name| keyword == name).unwrap_or(0);
        let Ok(value) = self.scalar(expression) else {
            self.energies[slot].get_or_insert((keyword.clone(), Value::ZERO));
            return;
        };
        if self.energies[slot].is_some() {
            let help = format!("add them in one statement, `{keyword} = … + …;`");
            self.errors.push(keyword, format!("a second `{keyword}`\nhelp: {help}"));
        }
        crate::model::check::energy(self, keyword, expression, value);
        self.energies[slot] = Some((keyword.clone(), value));
    }

    /// `Q[theta] = …;`, or for a whole array of coordinates at once.
    pub(super) fn generalized_force(
        &mut self,
        keyword: &Ident,
        coordinate: &Expr,
        value: &Expr,
    ) -> Result<()> {
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
    pub(super) fn targets(&mut self, expression: &Expr) -> Result<Vec<usize>> {
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
    pub(super) fn force(&mut self, force: &Expr, at: &Expr) -> Result<()> {
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

    pub(super) fn observe(&mut self, d: &Declaration) {
        if let Some((_, Entry::Broken)) = self.names.get(&d.name.to_string()) {
            return;
        }
        let text = d.name.to_string();
        if let Some(length) = &d.length {
            let message = "the length of an output is that of its value\nhelp: remove this length";
            self.errors.push(length, message);
        }
        if let Some(message) = crate::model::check::reserved_output(&text) {
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
}
