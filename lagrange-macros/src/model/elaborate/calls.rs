//! Functions and methods: those of the system, of the table, of the user, and of arrays; and `dot`.

use super::control::reference;
use super::*;
use crate::syntax::choices::between;
use proc_macro2::TokenTree;

impl Elaborator<'_> {
    pub(super) fn function_call(&mut self, call: &syn::ExprCall) -> Result {
        let Expr::Path(path) = &*call.func else {
            return self.call_of_value(call);
        };
        let Some(name) = path.path.get_ident().cloned() else { return self.associated(path, call) };
        let text = name.to_string();
        if text == "dot" {
            return self.dot(call);
        }
        if text == "reaction" {
            return self.reaction(&name, call);
        }
        if !self.is_function(&text) {
            return Err(self.unknown_function(&name));
        }
        let arguments: Vec<Result> = call.args.iter().map(|a| self.evaluate(a)).collect();
        let arguments: Vec<Val> = arguments.into_iter().collect::<Result<_>>()?;
        if let Some((_, Val::Closure(closure))) =
            self.scope.locals.iter().rev().find(|(local, _)| *local == text).cloned()
        {
            return self.apply(&closure, arguments, call);
        }
        self.scope.used.insert(text.clone());
        match self.scope.names.get(&text).map(|(_, entry)| entry.clone()) {
            Some(Entry::Function(f)) => self.own_function(f, arguments, call),
            Some(Entry::External(f)) => {
                let arity = self.found.externals[f].arity;
                self.arity(&text, arity, arguments.len(), &name)?;
                let arguments = arguments
                    .into_iter()
                    .map(|a| self.number(a, &call.args))
                    .collect::<Result<Vec<Value>>>()?;
                let orders = vec![0; arity].into();
                Ok(Val::Number(self.graph.external(f, orders, arguments.into())))
            }
            Some(Entry::Broken) => Err(Reported),
            Some(entry) => {
                let help = self.help_for_value(&text, &entry, call);
                Err(self.errors.push(&name, format!("`{text}` is not a function\nhelp: {help}")))
            }
            None if is_rigid(&text) => {
                let arguments = arguments.into_iter().map(Val::dereferenced).collect();
                self.rigid_function(&name, arguments, call)
            }
            None => {
                if matches!(text.as_str(), "min" | "max") && arguments.len() != 2 {
                    return Err(self.extreme(&name, call, &arguments));
                }
                self.arity(&text, 1 + method_arity(&text), arguments.len(), &name)?;
                if text == "clamp" {
                    self.bounds_behind(call, &arguments)?;
                }
                match arguments.split_first() {
                    Some((receiver, rest)) => self.method(&name, receiver.clone(), rest.to_vec(), &call.args),
                    None => Err(Reported),
                }
            }
        }
    }

    /// A call of what has no name: a closure.
    fn call_of_value(&mut self, call: &syn::ExprCall) -> Result {
        match self.evaluate(&call.func)? {
            Val::Closure(closure) => {
                let arguments = call.args.iter().map(|a| self.evaluate(a)).collect::<Result<Vec<_>>>()?;
                self.apply(&closure, arguments, call)
            }
            other => {
                let product = match other {
                    Val::Int(_) | Val::Number(_) => {
                        let (left, right) = (plain(&call.func), plain(&call.args));
                        format!("\nhelp: for a product write `{left} * ({right})`")
                    }
                    _ => String::new(),
                };
                Err(self.errors.push(&call.func, format!("{} is not a function{product}", other.kind())))
            }
        }
    }

    /// Help for a call of a name that is no function.
    fn help_for_value(&self, text: &str, entry: &Entry, call: &syn::ExprCall) -> String {
        let of_time = matches!(call.args.first(), Some(Expr::Path(t)) if t.path.is_ident("t"));
        let is_index = call.args.len() == 1 && call.args.first().is_some_and(is_literal);
        let of_time_is = format!(
            "a function of time is a formula of `t`, `fn {text}(t) = …;`, or has data, `extern {text}: Curve(t);`"
        );
        match *entry {
            _ if is_rigid(text) || METHODS.contains(&text) || TABLE.iter().any(|row| row.name == text) => {
                format!("your `{text}` hides the function of that name: give it another name")
            }
            Entry::Parameter(i) if of_time && self.found.parameters[i].input => {
                format!("an input is a value that is held between steps: write `{text}`; {of_time_is}")
            }
            Entry::Parameter(_) if of_time => {
                format!("a parameter is constant: write `{text}`; {of_time_is}")
            }
            Entry::Parameter(_) | Entry::Coordinate { .. } | Entry::State { .. } | Entry::Let(_)
                if is_index =>
            {
                format!(
                    "an element of an array is `{text}[{}]`; for a product write `{text} * ({0})`",
                    plain(&call.args)
                )
            }
            _ if of_time => format!("it is a function of time already: write `{text}`"),
            _ => format!("for a product write `{text} * ({})`", plain(&call.args)),
        }
    }

    /// `f64::sin(x)`
    fn associated(&mut self, path: &syn::ExprPath, call: &syn::ExprCall) -> Result {
        let name = path.path.segments.last().map(|s| s.ident.clone()).filter(|name| {
            let written: Vec<String> =
                path.path.segments.iter().map(|s| s.to_token_stream().to_string()).collect();
            path.qself.is_none()
                && path.path.leading_colon.is_none()
                && written == ["f64", &name.to_string()]
                && is_method(&written[1])
        });
        let Some(name) = name else {
            let message = "a path to a function that the language does not have\nhelp: elementary functions are `x.sin()`, `sin(x)` and `f64::sin(x)`; a function of your own is declared by `extern fn name(x);`";
            return Err(self.errors.push(path, message));
        };
        let arguments = call.args.iter().map(|a| self.evaluate(a)).collect::<Result<Vec<_>>>()?;
        self.arity(&name.to_string(), 1 + method_arity(&name.to_string()), arguments.len(), &name)?;
        let mut arguments = arguments.into_iter().zip(&call.args);
        let Some((receiver, at)) = arguments.next() else { return Err(Reported) };
        let receiver = self.number(receiver, at)?;
        self.number_method(&name, receiver, arguments.map(|(argument, _)| argument).collect(), &call.args)
    }

    pub(super) fn is_function(&self, name: &str) -> bool {
        is_method(name)
            || is_rigid(name)
            || self.scope.names.contains_key(name)
            || self.scope.locals.iter().any(|(local, val)| local == name && matches!(val, Val::Closure(_)))
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
        let help = arguments_meant(name).map_or(String::new(), |help| format!("\nhelp: {help}"));
        Err(self.errors.push(at, format!("`{name}` takes {expected} argument{plural}, not {found}{help}")))
    }

    /// The error of `min(x, y, z)` and `min([x, y])`.
    fn extreme(&mut self, name: &Ident, call: &syn::ExprCall, arguments: &[Val]) -> Reported {
        let written: Vec<String> = match (call.args.first(), arguments) {
            (Some(Expr::Array(array)), [_]) => array.elems.iter().map(plain).collect(),
            (Some(array), [Val::Array(items)]) => {
                (0..items.len()).map(|i| format!("{}[{i}]", plain(array))).collect()
            }
            (Some(x), [_]) => vec![plain(x), "0".into()],
            _ => call.args.iter().map(plain).collect(),
        };
        let nested = nested(&name.to_string(), &written);
        let message = format!("`{name}` takes 2 arguments, not {}\nhelp: write `{nested}`", arguments.len());
        self.errors.push(name, message)
    }

    /// Refuses `clamp(-1, 1, u)`, which is 1, or u below it.
    fn bounds_behind(&mut self, call: &syn::ExprCall, arguments: &[Val]) -> Result<()> {
        let are_written = call.args.iter().map(is_literal).eq([true, true, false]);
        let given: Vec<Value> = arguments.iter().flat_map(numbers).collect();
        let [low, high, _] = given[..] else { return Ok(()) };
        if !are_written || low.k.compare(high.k).is_gt() {
            return Ok(());
        }
        let [low, high, x] = [0, 1, 2].map(|i| plain(&call.args[i]));
        let message =
            format!("the bounds of `clamp` come behind the number\nhelp: write `clamp({x}, {low}, {high})`");
        Err(self.errors.push(&call.args, message))
    }

    /// Is this a function, or the word of another language for one, and no name?
    pub(super) fn is_call_in_brackets(&self, name: &Ident) -> bool {
        let text = name.to_string();
        let small = text.to_lowercase();
        let is_local = self.scope.locals.iter().any(|(local, _)| *local == text);
        (text == "dot" || is_method(&small)) && !is_local && !self.scope.names.contains_key(&text)
    }

    /// The error of `Cos[x]` and `sqrt{x}`.
    pub(super) fn call_in_brackets(&mut self, name: &Ident, argument: &str, brackets: &str) -> Reported {
        let small = name.to_string().to_lowercase();
        let message = format!(
            "the argument of a function is in parentheses, not in {brackets}\nhelp: write `{small}({argument})`"
        );
        self.errors.push(name, message)
    }

    pub(super) fn own_function(&mut self, f: usize, arguments: Vec<Val>, call: &syn::ExprCall) -> Result {
        let definition = &self.scope.functions[f];
        let (name, parameters, body) =
            (definition.name.to_string(), definition.arguments.clone(), definition.body.clone());
        self.arity(&name, parameters.len(), arguments.len(), &call.func)?;
        if self.scope.calls.contains(&f) {
            let message = format!(
                "`{name}` calls itself{}: a recursion has no end\nhelp: a sum over a range is `(0..N).map(|i| …).sum()`",
                match self.scope.calls.last() {
                    Some(last) if *last != f => format!(" through `{}`", self.scope.functions[*last].name),
                    _ => String::new(),
                }
            );
            return Err(self.errors.push(&call.func, message));
        }
        let before = std::mem::take(&mut self.scope.locals);
        self.scope.locals.extend(parameters.iter().map(ToString::to_string).zip(arguments));
        self.scope.calls.push(f);
        let val = self.evaluate(&body);
        self.scope.calls.pop();
        self.scope.locals = before;
        val
    }

    /// `dot(e)`: total time derivative.
    pub(super) fn dot(&mut self, call: &syn::ExprCall) -> Result {
        self.arity("dot", 1, call.args.len(), &call.func)?;
        let argument = &call.args[0];
        let val = self.evaluate(argument)?.dereferenced();
        self.dotted(val, argument, call)
    }

    pub(super) fn dotted(&mut self, val: Val, argument: &Expr, call: &syn::ExprCall) -> Result {
        if let Val::Array(items) = val {
            return Ok(Val::Array(
                items
                    .into_iter()
                    .map(|v| self.dotted(v.dereferenced(), argument, call))
                    .collect::<Result<_>>()?,
            ));
        }
        if let Val::Frame(_) = val {
            let frame = argument.to_token_stream();
            let message = format!(
                "a frame has no rate of its own\nhelp: it has the velocities `angular_velocity({frame})` and `velocity({frame})` in its axes; in those of the world its origin moves with `dot({frame}.origin())`"
            );
            return Err(self.errors.push(argument, message));
        }
        if let Val::Rotation(turns) = &val {
            return self.rate_of_rotation(turns, argument);
        }
        let value = self.number(val, argument)?;
        if self.of_states(&[value]) {
            let message =
                format!("the rate of a state of first order is no term of the others\nhelp: {RATE}");
            return Err(self.errors.push(call, message));
        }
        if self.graph.depends(&[value], |s| matches!(s, Symbol::Velocity(_) | Symbol::Rate(_))) {
            let message = match self.observing {
                true => format!(
                    "a second time derivative: {OBSERVED_ACCELERATION}; remove this `dot`, or this statement"
                ),
                false => {
                    "a second time derivative: accelerations follow from the energies, they are not part of them\nhelp: `dot` applies to coordinates and positions".into()
                }
            };
            return Err(self.errors.push(call, message));
        }
        if self.graph.depends(&[value], |s| matches!(s, Symbol::Multiplier(_) | Symbol::Reaction(_))) {
            let message = "the rate of a reaction is not available: it follows from the accelerations, which have none here\nhelp: name the reaction itself, as in `event slack: reaction(rod), terminal;`, and difference its samples for a rate";
            return Err(self.errors.push(call, message));
        }
        if !self
            .graph
            .depends(&[value], |s| matches!(s, Symbol::Coordinate(_) | Symbol::Binding(_) | Symbol::Time))
        {
            if self.is_derived() {
                return Ok(Val::Number(Value::ZERO));
            }
            let message = format!(
                "`{}` does not depend on a coordinate or on time, so its rate is 0\nhelp: remove this term, or declare what moves with `coord`",
                argument.to_token_stream()
            );
            return Err(self.errors.push(call, message));
        }
        Ok(Val::Number(self.velocity(value)))
    }

    pub(super) fn method_call(&mut self, call: &syn::ExprMethodCall) -> Result {
        if let (true, Some(argument)) = (call.method == "contains", call.args.first()) {
            let range: Vec<TokenTree> = call.receiver.to_token_stream().into_iter().collect();
            let name = plain(argument);
            if let Some(help) = between(name.trim_start_matches("& "), &range) {
                let message = format!("a range of numbers is not part of the language\nhelp: {help}");
                return Err(self.errors.push(&call.method, message));
            }
        }
        let receiver = self.evaluate(&call.receiver);
        let arguments = call.args.iter().map(|a| self.evaluate(a)).collect::<Result<Vec<_>>>();
        let (receiver, arguments) = (receiver?, arguments?);
        let at: &dyn ToTokens = if call.args.is_empty() { &call.method } else { &call.args };
        let val = self.method(&call.method, receiver, arguments, at)?;
        let Some(generics) = &call.turbofish else { return Ok(val) };
        let of =
            |arguments: &syn::AngleBracketedGenericArguments| match arguments.args.iter().collect::<Vec<_>>()
                [..]
            {
                [syn::GenericArgument::Type(ty)] => Some(ty.clone()),
                _ => None,
            };
        let message = "this type has no place here\nhelp: remove it, or write `.sum::<f64>()` or `.collect::<Vec<_>>()`";
        match (call.method.to_string().as_str(), of(generics), val) {
            ("sum" | "product", Some(ty), val @ (Val::Int(_) | Val::Typed(..) | Val::Number(_))) => {
                self.ascribed(val, &ty)
            }
            ("collect", Some(syn::Type::Path(ty)), Val::Array(items)) if ty.qself.is_none() => {
                let element = match ty.path.segments.iter().collect::<Vec<_>>()[..] {
                    [vec] if vec.ident == "Vec" => match &vec.arguments {
                        syn::PathArguments::AngleBracketed(arguments) => of(arguments),
                        _ => None,
                    },
                    _ => None,
                };
                let Some(element) = element else { return Err(self.errors.push(generics, message)) };
                let items = items.into_iter().map(|item| self.ascribed(item, &element));
                Ok(Val::Array(items.collect::<Result<_>>()?))
            }
            _ => Err(self.errors.push(generics, message)),
        }
    }

    pub(super) fn method(
        &mut self,
        name: &Ident,
        receiver: Val,
        arguments: Vec<Val>,
        at: impl ToTokens + Copy,
    ) -> Result {
        if let (Val::Reference(referred), "into_iter") = (&receiver, name.to_string().as_str()) {
            return self.method(&Ident::new("iter", name.span()), Val::clone(referred), arguments, at);
        }
        match receiver.dereferenced() {
            Val::Array(items) => self.array_method(name, items, arguments, at),
            Val::Frame(frame) => self.frame_method(name, &frame, arguments, at),
            Val::Rotation(turns) => self.rotation_method(name, &turns, &arguments),
            receiver @ (Val::Int(_) | Val::Number(_)) => {
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
            return Err(self.unknown_method(name));
        }
        self.arity(&text, method_arity(&text), arguments.len(), name)?;
        self.check_constant(name, x, &arguments)?;
        if text == "powi" {
            let Some(n) = arguments[0].integer_of(IntegerType::I32) else {
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
                return Ok(Val::Tuple(pair.to_vec()));
            }
            ("to_radians", []) => g.mul(x, degree),
            ("to_degrees", []) => g.div(x, degree),
            ("min", &[y]) => g.choose(true, x, y),
            ("max", &[y]) => g.choose(false, x, y),
            ("clamp", &[low, high])
                if low.is_constant() && high.is_constant() && low.k.compare(high.k).is_gt() =>
            {
                let [low, high] = [low, high].map(|bound| bound.k.to_f64());
                let message = format!(
                    "the lower bound of `clamp` is {low}, and the upper one {high}\nhelp: the lower bound comes first, `x.clamp({high}, {low})`"
                );
                return Err(self.errors.push(at, message));
            }
            ("clamp", &[low, high]) => {
                // A value that is not a number is neither below a bound nor above one, and stays what it is.
                let above = g.choose(false, x, low);
                g.select(Comparison::Less, high, above, high, above)
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
            return Err(self.unknown_array_method(name, items.len()));
        }
        self.arity(&text, arity, arguments.len(), name)?;
        let numbers = |e: &mut Self, items: Vec<Val>| {
            items.into_iter().map(|v| e.number(v.referred(), at)).collect::<Result<Vec<_>>>()
        };
        let joins = matches!(text.as_str(), "zip" | "chain");
        let argument = arguments.into_iter().next().map(|list| if joins { joined(list) } else { list });
        match (text.as_str(), argument) {
            ("into_iter" | "collect", None) => Ok(Val::Array(items)),
            ("iter", None) => Ok(Val::Array(items.into_iter().map(reference).collect())),
            ("copied" | "cloned", None) => {
                let copied = items.into_iter().map(|item| match item {
                    Val::Reference(item) => Ok(Rc::unwrap_or_clone(item)),
                    other => {
                        let message = format!(
                            "`{text}` copies what references refer to, and this is {}\nhelp: remove it",
                            other.kind()
                        );
                        Err(self.errors.push(name, message))
                    }
                });
                Ok(Val::Array(copied.collect::<Result<_>>()?))
            }
            ("len" | "count", None) => Ok(Val::Int(items.len() as i64)),
            ("rev", None) => Ok(Val::Array(items.into_iter().rev().collect())),
            ("enumerate", None) => {
                let pair = |(i, item)| Val::Tuple(vec![Val::Int(i as i64), item]);
                Ok(Val::Array(items.into_iter().enumerate().map(pair).collect()))
            }
            ("map", Some(Val::Closure(closure))) => {
                let items = items
                    .into_iter()
                    .map(|item| self.apply(&closure, vec![item], at))
                    .collect::<Result<_>>()?;
                self.list(items, at)
            }
            ("zip", Some(Val::Array(others))) => {
                let pairs = items.into_iter().zip(others);
                Ok(Val::Array(pairs.map(|(a, b)| Val::Tuple(vec![a, b])).collect()))
            }
            ("chain", Some(Val::Array(others))) => self.list(items.into_iter().chain(others).collect(), at),
            ("take" | "skip", Some(n)) if n.integer_of(IntegerType::USIZE).is_some() => {
                let n = n.integer_of(IntegerType::USIZE).unwrap_or_default();
                let n = self.count(n, at)?.min(items.len());
                Ok(Val::Array(if text == "take" { items[..n].to_vec() } else { items[n..].to_vec() }))
            }
            // A sum of integers stays an integer.
            ("sum", None) if items.iter().all(|item| item.referred_integer().is_some()) => {
                items.into_iter().try_fold(Val::Int(0), |sum, item| {
                    let (a, b) =
                        (sum.integer().unwrap_or_default(), item.referred_integer().unwrap_or_default());
                    let ty = self.common_type(name, a.1, b.1)?;
                    self.integer_in(a.0.checked_add(b.0), ty, name)
                })
            }
            ("sum", None) => {
                let mut items = items.into_iter().map(Val::referred);
                let first = items.next().unwrap_or(Val::Int(0));
                items.try_fold(first, |total, item| self.added(total, item, at))
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

    fn unknown_array_method(&mut self, name: &Ident, length: usize) -> Reported {
        let text = name.to_string();
        let hint = did_you_mean(&text, ARRAY_METHODS);
        let help = match text.as_str() {
            _ if !is_method(&text) => String::new(),
            "min" | "max" => {
                let elements: Vec<String> = (0..length).map(|i| format!("x[{i}]")).collect();
                let message = format!(
                    "an array has no method `{text}`\nhelp: of its elements, `{}`",
                    nested(&text, &elements)
                );
                return self.errors.push(name, message);
            }
            "powi" => "\nhelp: the square of its length is `x.norm_squared()`; of each element, `x.map(|x| x.powi(…))`".into(),
            _ => format!("\nhelp: of each element, `x.map(|x| x.{text}(…))`"),
        };
        self.errors.push(name, format!("an array has no method `{text}`{hint}{help}"))
    }

    pub(super) fn added(&mut self, a: Val, b: Val, at: impl ToTokens + Copy) -> Result {
        match (a.referred(), b.referred()) {
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

/// The least or the greatest of several numbers.
fn nested(function: &str, numbers: &[String]) -> String {
    match numbers {
        [] => format!("{function}(x, y)"),
        [only] => only.clone(),
        [first, ..] if numbers.len() > 4 => {
            let array = first.trim_end_matches("[0]");
            format!(
                "let so_far: [{}] = |i| if i == 0 {{ {array}[0] }} else {{ {function}(so_far[i - 1], {array}[i]) }};",
                numbers.len()
            )
        }
        [first, rest @ ..] => {
            rest.iter().fold(first.clone(), |so_far, next| format!("{function}({so_far}, {next})"))
        }
    }
}

/// The help for a function that is given another number of arguments than it takes.
fn arguments_meant(name: &str) -> Option<&'static str> {
    Some(match name {
        "dot" => "`dot(x)` is the derivative by time; an inner product is `a.dot(b)`",
        "atan" | "atan2" => "the angle of a point is `atan2(y, x)`, that of a quotient `atan(y / x)`",
        "hypot" => "the length of a vector is `[x, y, z].norm()`",
        "sqrt" | "cbrt" => "other roots are powers, `x.powf(1.0 / 4.0)`; a cube root is `cbrt(x)`",
        "ln" | "log2" | "log10" => "a logarithm to any base is `ln(x) / ln(b)`",
        "exp" => "any other power is `x.powf(y)`",
        "min" | "max" => "of three numbers it is `x.max(y).max(z)`, or `x.min(y).min(z)`",
        _ => return None,
    })
}

/// Functions of frames; a name of the user's own comes first.
fn is_rigid(name: &str) -> bool {
    FUNCTIONS.contains(&name) || ROTATIONS.contains(&name)
}

/// The help for rates of states.
pub(super) const RATE: &str = "name what `rate(…)` is, `let name = …;`, and write that name here";

/// The reason and the help for accelerations in outputs and events.
pub(super) const OBSERVED_ACCELERATION: &str = "accelerations are known only when the equations are solved, and in no output or event\nhelp: `system.accel_at(&state)` gives those of all coordinates, of a running stepper `stepper.system().accel_at(stepper.state())`";

pub const METHODS: [&str; 9] =
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

/// Items that an iterator joins: given by reference, they are references.
fn joined(list: Val) -> Val {
    match list {
        Val::Reference(list) if matches!(*list, Val::Array(_)) => match Rc::unwrap_or_clone(list) {
            Val::Array(items) => Val::Array(items.into_iter().map(reference).collect()),
            other => other,
        },
        other => other,
    }
}
