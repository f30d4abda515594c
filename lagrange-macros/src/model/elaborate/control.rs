//! Choices, blocks, closures, ranges and elements of arrays.

use super::*;
use crate::syntax::words::is_keyword;

impl Elaborator<'_> {
    pub(super) fn conditional(&mut self, conditional: &syn::ExprIf) -> Result {
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
                self.check_equality(&condition, &yes, &no);
                self.selected(&condition, yes, no, conditional)
            }
            other => Err(self.no_condition(&other, &conditional.cond)),
        }
    }

    pub(super) fn selected(&mut self, condition: &Condition, yes: Val, no: Val, at: &syn::ExprIf) -> Result {
        match (yes, no) {
            (Val::Reference(yes), Val::Reference(no)) => {
                let (yes, no) = (Rc::unwrap_or_clone(yes), Rc::unwrap_or_clone(no));
                Ok(Val::Reference(Rc::new(self.selected(condition, yes, no, at)?)))
            }
            (Val::Array(yes), Val::Array(no)) if yes.len() == no.len() => {
                let pairs = yes.into_iter().zip(no);
                Ok(Val::Array(pairs.map(|(y, n)| self.selected(condition, y, n, at)).collect::<Result<_>>()?))
            }
            (Val::Tuple(yes), Val::Tuple(no)) if yes.len() == no.len() => {
                let pairs = yes.into_iter().zip(no);
                Ok(Val::Tuple(pairs.map(|(y, n)| self.selected(condition, y, n, at)).collect::<Result<_>>()?))
            }
            (Val::Frame(_) | Val::Rotation(_), _) | (_, Val::Frame(_) | Val::Rotation(_)) => {
                let message = "which frame this is would depend on the motion\nhelp: a frame or a rotation is chosen by integers that are known at compile time, such as `i == 0`";
                Err(self.errors.push(&at.cond, message))
            }
            (yes, no) => {
                let (yes, no) = (self.number(yes, at)?, self.number(no, at)?);
                Ok(Val::Number(condition.select(&mut self.graph, yes, no)))
            }
        }
    }

    /// `{ let a = …; let b = …; value }`
    pub(super) fn block(&mut self, block: &syn::Block) -> Result {
        let scope = self.scope.locals.len();
        let val = self.block_value(block);
        self.scope.locals.truncate(scope);
        val
    }

    pub(super) fn block_value(&mut self, block: &syn::Block) -> Result {
        let Some((last, lets)) = block.stmts.split_last() else {
            return Err(self.errors.push(block, "an empty block has no value"));
        };
        for statement in lets {
            match statement {
                syn::Stmt::Local(syn::Local { pat, init: Some(init), .. }) if init.diverge.is_none() => {
                    let val = self.evaluate(&init.expr)?;
                    self.matched(pat, val)?;
                }
                other => return Err(self.errors.push(other, "a block holds `let`s and, last, its value")),
            }
        }
        match last {
            syn::Stmt::Expr(value, None) => self.evaluate(value),
            syn::Stmt::Expr(Expr::Return(value), Some(_)) => self.evaluate(&Expr::Return(value.clone())),
            syn::Stmt::Expr(value, Some(semicolon)) => {
                let message =
                    format!("a block ends in its value, without `;`\nhelp: write `{}`", plain(value));
                Err(self.errors.push(semicolon, message))
            }
            other => Err(self.errors.push(other, "a block ends in its value, without `;`")),
        }
    }

    /// Binds a pattern of a closure or a local `let`.
    pub(super) fn matched(&mut self, pattern: &Pat, val: Val) -> Result<()> {
        match (pattern, val) {
            (Pat::Ident(name), _) if is_keyword(&name.ident.to_string()) => {
                let message = format!(
                    "`{0}` is a keyword of Rust\nhelp: choose another name, such as `{0}_`",
                    name.ident
                );
                Err(self.errors.push(pattern, message))
            }
            (Pat::Ident(name), _) if self.is_constant(&name.ident) => {
                let message = format!(
                    "`{0}` is a constant, with which a pattern compares\nhelp: choose another name, such as `{0}_`",
                    name.ident
                );
                Err(self.errors.push(pattern, message))
            }
            (Pat::Ident(name), val) if name.subpat.is_none() => {
                let val = if name.by_ref.is_some() { reference(val) } else { val };
                self.scope.locals.push((name.ident.to_string(), val));
                Ok(())
            }
            (Pat::Type(typed), val) => {
                let val = self.ascribed(val, &typed.ty)?;
                self.matched(&typed.pat, val)
            }
            (Pat::Paren(inner), val) => self.matched(&inner.pat, val),
            (Pat::Reference(inner), Val::Reference(val)) if inner.mutability.is_none() => {
                self.matched(&inner.pat, Rc::unwrap_or_clone(val))
            }
            (Pat::Wild(_), _) => Ok(()),
            // The parts of what is referred to are referred to.
            (Pat::Tuple(_) | Pat::Slice(_), Val::Reference(val)) => {
                let referred = |items: Vec<Val>| items.into_iter().map(reference).collect();
                let val = match Rc::unwrap_or_clone(val) {
                    Val::Array(items) => Val::Array(referred(items)),
                    Val::Tuple(items) => Val::Tuple(referred(items)),
                    val => val,
                };
                self.matched(pattern, val)
            }
            (Pat::Tuple(syn::PatTuple { elems, .. }), Val::Tuple(items))
            | (Pat::Slice(syn::PatSlice { elems, .. }), Val::Array(items))
                if elems.len() == items.len() =>
            {
                elems.iter().zip(items).try_for_each(|(pattern, item)| self.matched(pattern, item))
            }
            (pattern, val) => {
                let message = format!(
                    "this pattern does not fit {}\nhelp: a pattern is a name that is no keyword of Rust, as in `|i| …`, or several names, as in `|(i, x)| …`",
                    val.kind()
                );
                Err(self.errors.push(pattern, message))
            }
        }
    }

    fn is_constant(&self, name: &syn::Ident) -> bool {
        matches!(self.scope.names.get(&name.to_string()), Some((_, Entry::Const(_))))
    }

    /// A value that is said to have this type. An integer without a type takes it.
    pub(super) fn ascribed(&mut self, val: Val, ty: &syn::Type) -> Result {
        let name = match ty {
            syn::Type::Path(path) if path.qself.is_none() => path.path.get_ident().map(ToString::to_string),
            _ => None,
        };
        let name = name.unwrap_or_default();
        match (ty, val) {
            (syn::Type::Infer(_), val) => Ok(val),
            (syn::Type::Paren(inner), val) => self.ascribed(val, &inner.elem),
            (syn::Type::Group(inner), val) => self.ascribed(val, &inner.elem),
            (syn::Type::Reference(to), Val::Reference(val))
                if to.mutability.is_none() && to.lifetime.is_none() =>
            {
                Ok(reference(self.ascribed(Rc::unwrap_or_clone(val), &to.elem)?))
            }
            (syn::Type::Tuple(types), Val::Tuple(items)) if types.elems.len() == items.len() => {
                let parts = items.into_iter().zip(&types.elems);
                Ok(Val::Tuple(parts.map(|(item, ty)| self.ascribed(item, ty)).collect::<Result<_>>()?))
            }
            (_, val @ (Val::Int(_) | Val::Number(_))) if name == "f64" => {
                Ok(Val::Number(self.number(val, ty)?))
            }
            (_, val @ (Val::Bool(_) | Val::Condition(_))) if name == "bool" => Ok(val),
            (_, val) => match (IntegerType::named(&name), val.integer()) {
                (Some(ty_written), Some((n, own))) if own.is_none_or(|own| own == ty_written) => {
                    self.integer_in(Some(n), Some(ty_written), ty)
                }
                _ => {
                    let message = format!(
                        "{} is not known to have the type `{}`\nhelp: remove the type",
                        val.kind(),
                        ty.to_token_stream()
                    );
                    Err(self.errors.push(ty, message))
                }
            },
        }
    }

    pub fn apply(&mut self, closure: &Closure, arguments: Vec<Val>, at: impl ToTokens) -> Result {
        let inputs = &closure.expression.inputs;
        if inputs.len() != arguments.len() {
            let message = format!("a closure of {} arguments, given {}", inputs.len(), arguments.len());
            return Err(self.errors.push(at, message));
        }
        let before = std::mem::replace(&mut self.scope.locals, closure.scope.clone());
        let val = match inputs.iter().zip(arguments).try_for_each(|(pattern, val)| self.matched(pattern, val))
        {
            Ok(()) => match &closure.expression.output {
                syn::ReturnType::Default => self.evaluate(&closure.expression.body),
                syn::ReturnType::Type(_, ty) => {
                    self.evaluate(&closure.expression.body).and_then(|val| self.ascribed(val, ty))
                }
            },
            Err(reported) => Err(reported),
        };
        self.scope.locals = before;
        val
    }

    pub(super) fn range(&mut self, range: &syn::ExprRange) -> Result {
        let (Some(start), Some(end)) = (&range.start, &range.end) else {
            return Err(self.errors.push(range, "a range has a start and an end\nhelp: write `0..N`"));
        };
        let mut whole = |e: &Expr| match self.evaluate(e)? {
            val if val.integer().is_some() => Ok(val.integer().unwrap_or_default()),
            other => {
                let message = format!(
                    "expected an integer that is known at compile time, found {}\nhelp: write an integer such as `3`, or the name of a `const`",
                    other.kind()
                );
                Err(self.errors.push(e, message))
            }
        };
        let ((start, left), (end, right)) = (whole(start)?, whole(end)?);
        let ty = self.common_type(range, left, right)?;
        let end =
            if matches!(range.limits, syn::RangeLimits::Closed(_)) { end.saturating_add(1) } else { end };
        let n = self.count(end.saturating_sub(start).max(0), range)?;
        let item = |i| ty.map_or(Val::Int(start + i), |ty| Val::Typed(start + i, ty));
        Ok(Val::Array((0..n as i64).map(item).collect()))
    }

    /// A length that is within reason.
    pub(super) fn count(&mut self, n: i64, at: impl ToTokens) -> Result<usize> {
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
    pub(super) fn spend(&mut self, elements: usize, at: impl ToTokens) -> Result<()> {
        self.elements = self.elements.saturating_add(elements);
        if self.elements <= MAX_COPIED_ELEMENTS {
            return Ok(());
        }
        if std::mem::replace(&mut self.over_budget, true) {
            return Err(Reported);
        }
        let message = format!(
            "this system makes more than {MAX_COPIED_ELEMENTS} elements of arrays\nhelp: use smaller arrays, or fewer arrays within arrays"
        );
        Err(self.errors.push(at, message))
    }

    /// `x[i]`; of a named array without a copy of the whole.
    pub(super) fn element(&mut self, index: &syn::ExprIndex) -> Result {
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
        if let Expr::Path(path) = &*index.expr
            && let Some(name) = path.path.get_ident()
            && self.is_call_in_brackets(name)
        {
            return Err(self.call_in_brackets(name, &plain(&index.index), "brackets"));
        }
        let items = match self.evaluate(&index.expr)?.dereferenced() {
            Val::Array(items) => items,
            other => {
                let help = match other {
                    Val::Rotation(_) => {
                        format!(
                            "an axis of what it turns has them: write `({} * [1, 0, 0])[0]`",
                            plain(&index.expr)
                        )
                    }
                    Val::Frame(_) => "the coordinates of its origin are `link.origin()[0]` and so on".into(),
                    _ if matches!(&*index.index, Expr::Path(t) if t.path.is_ident("t")) => {
                        let name = plain(&index.expr);
                        format!("it is a function of time already: write `{name}`")
                    }
                    _ => "remove the index".to_string(),
                };
                let message = format!("{} has no elements\nhelp: {help}", other.kind());
                return Err(self.errors.push(&index.expr, message));
            }
        };
        let i = self.index(&index.index, items.len())?;
        Ok(items[i].clone())
    }

    pub(super) fn known_in_family(&mut self, name: &str, length: usize, index: &Expr) -> Result<()> {
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

    pub(super) fn array_length(&self, name: &str) -> Option<usize> {
        fn items(val: &Val) -> Option<usize> {
            match val {
                Val::Array(items) => Some(items.len()),
                Val::Reference(val) => items(val),
                _ => None,
            }
        }
        if let Some((_, val)) = self.scope.locals.iter().rev().find(|(local, _)| local == name) {
            return items(val);
        }
        match &self.scope.names.get(name)?.1 {
            Entry::Let(val) | Entry::Prescribed(val) => items(val),
            Entry::Parameter(i) => {
                self.found.parameters[*i].length.filter(|_| !self.found.parameters[*i].rotation)
            }
            Entry::Coordinate { length, .. }
            | Entry::Mixed { length, .. }
            | Entry::State { length, .. }
            | Entry::Rotation { length, .. } => *length,
            _ => None,
        }
    }

    /// Element i of the array of that name, which has so many.
    pub(super) fn array_element(&mut self, name: &str, i: usize) -> Val {
        fn item(val: &Val, i: usize) -> Val {
            match val {
                Val::Array(items) => items[i].clone(),
                Val::Reference(val) => item(val, i),
                other => other.clone(),
            }
        }
        if let Some((_, val)) = self.scope.locals.iter().rev().find(|(local, _)| local == name) {
            return item(val, i);
        }
        self.scope.used.insert(name.to_string());
        let symbol = match self.scope.names.get(name).map(|(_, entry)| entry) {
            Some(Entry::Let(val) | Entry::Prescribed(val)) => return item(val, i),
            Some(Entry::Parameter(p)) => Symbol::Parameter(self.found.parameters[*p].first + i),
            Some(Entry::Coordinate { first, .. }) => Symbol::Coordinate(first + i),
            Some(Entry::Mixed { places, .. }) => {
                let place = places[i];
                return self.placed(place);
            }
            Some(Entry::State { first, .. }) => Symbol::Velocity(first + i),
            Some(Entry::Rotation { first, .. }) => return self.space.attitude(first + i),
            _ => unreachable!("only arrays have a length"),
        };
        Val::Number(self.graph.symbol(symbol))
    }
}

/// `&val`
pub(super) fn reference(val: Val) -> Val {
    Val::Reference(Rc::new(val))
}
