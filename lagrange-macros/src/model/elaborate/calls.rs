//! Functions and methods: those of the system, of the table, of the user, and of arrays; and `dot`.

use super::*;

impl Elaborator<'_> {
    pub(super) fn function_call(&mut self, call: &syn::ExprCall) -> Result {
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
        if text == "reaction" {
            return self.reaction(&name, call);
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
            None if is_rigid(&text) => self.rigid_function(&name, arguments, call),
            None => {
                self.arity(&text, 1 + method_arity(&text), arguments.len(), &name)?;
                match arguments.split_first() {
                    Some((receiver, rest)) => self.method(&name, receiver.clone(), rest.to_vec(), &call.args),
                    None => Err(Reported),
                }
            }
        }
    }

    pub(super) fn is_function(&self, name: &str) -> bool {
        is_method(name)
            || is_rigid(name)
            || self.names.contains_key(name)
            || self.locals.iter().any(|(local, val)| local == name && matches!(val, Val::Closure(_)))
    }

    pub(super) fn no_function(&mut self, name: &Ident) -> Reported {
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
        known.extend(FUNCTIONS.into_iter().chain(ROTATIONS).map(String::from));
        known.extend(["dot", "min", "max", "powi"].map(String::from));
        let hint = did_you_mean(&text, known.iter().map(String::as_str));
        let help = match hint.is_empty() {
            true => "\nhelp: define it with `fn`, or declare a function of your own with `extern fn`",
            false => "",
        };
        self.errors.push(name, format!("unknown function `{text}`{hint}{help}"))
    }

    pub(super) fn arity(
        &mut self,
        name: &str,
        expected: usize,
        found: usize,
        at: impl ToTokens,
    ) -> Result<()> {
        if expected == found {
            return Ok(());
        }
        let plural = if expected == 1 { "" } else { "s" };
        let help = if name == "dot" && expected == 1 { "\nhelp: an inner product is `a.dot(b)`" } else { "" };
        Err(self.errors.push(at, format!("`{name}` takes {expected} argument{plural}, not {found}{help}")))
    }

    pub(super) fn own_function(&mut self, f: usize, arguments: Vec<Val>, call: &syn::ExprCall) -> Result {
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
    pub(super) fn dot(&mut self, call: &syn::ExprCall) -> Result {
        self.arity("dot", 1, call.args.len(), &call.func)?;
        let argument = &call.args[0];
        let val = self.evaluate(argument)?;
        self.dotted(val, argument, call)
    }

    pub(super) fn dotted(&mut self, val: Val, argument: &Expr, call: &syn::ExprCall) -> Result {
        if let Val::Array(items) = val {
            return Ok(Val::Array(
                items.into_iter().map(|v| self.dotted(v, argument, call)).collect::<Result<_>>()?,
            ));
        }
        if let Val::Frame(_) = val {
            let frame = argument.to_token_stream();
            let message = format!(
                "a frame has no rate of its own\nhelp: it has the velocities `angular_velocity({frame})` and `velocity({frame})` in its axes; in those of the world its origin moves with `dot({frame}.origin())`"
            );
            return Err(self.errors.push(argument, message));
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

    pub(super) fn method_call(&mut self, call: &syn::ExprMethodCall) -> Result {
        let receiver = self.evaluate(&call.receiver);
        let arguments = call.args.iter().map(|a| self.evaluate(a)).collect::<Result<Vec<_>>>();
        let (receiver, arguments) = (receiver?, arguments?);
        let at: &dyn ToTokens = if call.args.is_empty() { &call.method } else { &call.args };
        self.method(&call.method, receiver, arguments, at)
    }

    pub(super) fn method(
        &mut self,
        name: &Ident,
        receiver: Val,
        arguments: Vec<Val>,
        at: impl ToTokens + Copy,
    ) -> Result {
        match receiver {
            Val::Array(items) => self.array_method(name, items, arguments, at),
            Val::Frame(frame) => self.frame_method(name, &frame, arguments, at),
            Val::Rotation(turns) => self.rotation_method(name, &turns, &arguments),
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

    pub(super) fn number_method(
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
        let degree = pi().scaled(Number::Ratio(1, 180));
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
    pub(super) fn check_constant(&mut self, name: &Ident, x: Value, arguments: &[Val]) -> Result<()> {
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

    pub(super) fn array_method(
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

    pub(super) fn added(&mut self, a: Val, b: Val, at: impl ToTokens + Copy) -> Result {
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

    pub(super) fn inner(&mut self, a: &[Value], b: &[Value]) -> Value {
        a.iter().zip(b).fold(Value::ZERO, |sum, (a, b)| {
            let product = self.graph.mul(*a, *b);
            self.graph.add(sum, product)
        })
    }
}

/// Functions of frames; a name of the user's own comes first.
fn is_rigid(name: &str) -> bool {
    FUNCTIONS.contains(&name) || ROTATIONS.contains(&name)
}

pub(super) const METHODS: [&str; 9] =
    ["powi", "recip", "sin_cos", "to_radians", "to_degrees", "min", "max", "clamp", "mul_add"];
pub(super) const ARRAY_METHODS: [&str; 20] = [
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
