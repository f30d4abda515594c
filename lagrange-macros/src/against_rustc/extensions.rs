//! Extensions of Rust by the language, and translations of expressions that use them. The documentation of the language
//! contains these sentences. Nothing else that rustc refuses may be accepted.

use std::collections::BTreeSet;
use syn::visit_mut::VisitMut;
use syn::{BinOp, Expr, Lit, Member, Pat, UnOp};

/// The extensions, as `lagrange_runtime::lagrangian` documents them.
pub const EXTENSIONS: [(Extension, &str); 7] = [
    (Extension::Integers, "An integer without a written type is a number where a number is expected"),
    (Extension::Literals, "Methods apply to literals of numbers"),
    (Extension::Functions, "Elementary functions are functions, too"),
    (Extension::Constants, "Constants need no `use`"),
    (Extension::Arithmetic, "Arrays add, subtract and scale"),
    (Extension::Lists, "Arrays and iterators are one kind of list"),
    (Extension::Unevaluated, "Code that is never evaluated is not checked"),
];

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Extension {
    Integers,
    Literals,
    Functions,
    Constants,
    Arithmetic,
    Lists,
    Unevaluated,
}

/// Kind of a value, as far as the translation depends on it.
#[derive(Clone, PartialEq, Debug)]
enum Kind {
    /// An integer without a written type: `i64`.
    Int,
    /// A literal without a written type.
    Number {
        literal: bool,
    },
    /// An integer of this type.
    Typed(String),
    /// A condition.
    Other,
    Reference(Box<Kind>),
    /// A `Vec`
    List(Box<Kind>),
    Tuple(Vec<Kind>),
}

const NUMBER: Kind = Kind::Number { literal: false };

#[derive(Clone)]
enum Meaning {
    Value(String, Kind),
    /// Expanded where it is called.
    Closure(Box<syn::ExprClosure>, Vec<(String, Meaning)>),
}

pub struct Translation {
    scope: Vec<(String, Meaning)>,
    names: usize,
    pub used: BTreeSet<Extension>,
}

/// Counts bodies of closures and branches, and replaces the one of this index.
struct Replaced {
    next: usize,
    at: usize,
    by: Expr,
}

impl Replaced {
    fn visit(&mut self, body: &mut Expr) -> bool {
        let here = self.next == self.at;
        self.next += 1;
        if here {
            *body = self.by.clone();
        }
        here
    }
}

impl VisitMut for Replaced {
    fn visit_expr_closure_mut(&mut self, closure: &mut syn::ExprClosure) {
        if !self.visit(&mut closure.body) {
            self.visit_expr_mut(&mut closure.body);
        }
    }

    fn visit_expr_if_mut(&mut self, conditional: &mut syn::ExprIf) {
        self.visit_expr_mut(&mut conditional.cond);
        let block = conditional.then_branch.clone();
        let mut yes = Expr::Block(syn::ExprBlock { attrs: Vec::new(), label: None, block });
        let replaced = self.visit(&mut yes);
        conditional.then_branch = match yes {
            Expr::Block(block) => block.block,
            other => syn::parse_quote!({ #other }),
        };
        if !replaced {
            self.visit_block_mut(&mut conditional.then_branch);
        }
        if let Some((_, no)) = &mut conditional.else_branch {
            if self.visit(no) {
                **no = syn::parse_quote!({ #no });
            } else {
                self.visit_expr_mut(no);
            }
        }
    }
}

/// The expression with 0.0 for bodies and branches that the language never evaluates: they may be anything.
fn evaluated(mut expression: Expr, accepted: impl Fn(&str) -> bool) -> (Expr, bool) {
    let (mut at, mut changed) = (0, false);
    loop {
        let replaced = |by: Expr| {
            let mut copy = expression.clone();
            let mut replaced = Replaced { next: 0, at, by };
            replaced.visit_expr_mut(&mut copy);
            (copy, replaced.next)
        };
        let (unknown, count) = replaced(syn::parse_quote!(an_unknown_name));
        if at >= count {
            return (expression, changed);
        }
        if accepted(&quote::quote!(#unknown).to_string()) {
            expression = replaced(syn::parse_quote!(0.0)).0;
            changed = true;
        }
        at += 1;
    }
}

/// The expression in Rust, with the extensions that it uses; `None` for what no extension explains. `accepted` says
/// what the language accepts.
pub fn translated(text: &str, accepted: impl Fn(&str) -> bool) -> Option<(String, BTreeSet<Extension>)> {
    let (expression, unevaluated) = evaluated(syn::parse_str(text).ok()?, accepted);
    let mut translation = Translation { scope: Vec::new(), names: 0, used: BTreeSet::new() };
    if unevaluated {
        translation.used(Extension::Unevaluated);
    }
    for name in ["x", "y", "z"] {
        translation.scope.push((name.into(), Meaning::Value(name.into(), NUMBER)));
    }
    translation.scope.push(("a".into(), Meaning::Value("a.to_vec()".into(), Kind::List(Box::new(NUMBER)))));
    translation.scope.push(("N".into(), Meaning::Value("3i64".into(), Kind::Int)));
    let (text, kind) = translation.expression(&expression)?;
    let text = translation.number(text, &kind)?;
    Some((text, translation.used))
}

impl Translation {
    fn used(&mut self, extension: Extension) {
        self.used.insert(extension);
    }

    /// A value where a number is expected.
    fn number(&mut self, text: String, kind: &Kind) -> Option<String> {
        match kind {
            Kind::Int => {
                self.used(Extension::Integers);
                Some(format!("(({text}) as f64)"))
            }
            Kind::Number { .. } => Some(text),
            _ => None,
        }
    }

    /// A value as one of this kind.
    fn converted(&mut self, text: String, from: &Kind, to: &Kind) -> Option<String> {
        match (from, to) {
            (Kind::Int, Kind::Number { .. }) => self.number(text, from),
            (Kind::Int, Kind::Typed(ty)) => {
                self.used(Extension::Integers);
                Some(format!("{ty}::try_from({text}).unwrap()"))
            }
            _ => Some(text),
        }
    }

    fn integer(&mut self, expression: &Expr, ty: &str) -> Option<String> {
        match self.expression(expression)? {
            (text, Kind::Int) => {
                self.used(Extension::Integers);
                Some(format!("{ty}::try_from({text}).unwrap()"))
            }
            (text, Kind::Typed(own)) if own == ty => Some(text),
            _ => None,
        }
    }

    fn joined(a: &Kind, b: &Kind) -> Option<Kind> {
        Some(match (a, b) {
            (a, b) if a == b => a.clone(),
            (Kind::Number { .. } | Kind::Int, Kind::Number { .. } | Kind::Int) => NUMBER,
            (Kind::Int, Kind::Typed(ty)) | (Kind::Typed(ty), Kind::Int) => Kind::Typed(ty.clone()),
            (Kind::List(a), Kind::List(b)) => Kind::List(Box::new(Self::joined(a, b)?)),
            _ => return None,
        })
    }

    /// Elements of one kind.
    fn elements(&mut self, items: &[&Expr]) -> Option<(Vec<String>, Kind)> {
        let items = items.iter().map(|e| self.expression(e)).collect::<Option<Vec<_>>>()?;
        let kinds: Vec<&Kind> = items.iter().map(|(_, kind)| kind).collect();
        let first = (*kinds.first()?).clone();
        let kind = kinds.iter().try_fold(first, |a, b| Self::joined(&a, b))?;
        let texts = items.into_iter().map(|(text, own)| self.converted(text, &own, &kind));
        Some((texts.collect::<Option<_>>()?, kind))
    }

    fn expression(&mut self, expression: &Expr) -> Option<(String, Kind)> {
        Some(match expression {
            Expr::Paren(inner) => {
                let (text, kind) = self.expression(&inner.expr)?;
                (format!("({text})"), kind)
            }
            Expr::Group(inner) => self.expression(&inner.expr)?,
            Expr::Lit(lit) => match &lit.lit {
                Lit::Int(int) if int.suffix().is_empty() && int.base10_parse::<i64>().is_ok() => {
                    if int.base10_parse::<i32>().is_err() {
                        self.used(Extension::Integers);
                    }
                    (format!("{}i64", int.base10_digits()), Kind::Int)
                }
                Lit::Int(int) if int.suffix().is_empty() => {
                    self.used(Extension::Integers);
                    (format!("{}.0f64", int.base10_digits()), NUMBER)
                }
                Lit::Int(int) if int.suffix() == "f64" => (format!("{}f64", int.base10_digits()), NUMBER),
                Lit::Int(int) => (int.to_string(), Kind::Typed(int.suffix().into())),
                Lit::Float(float) => {
                    let literal = float.suffix().is_empty();
                    let digits = float.base10_digits();
                    let point = if digits.ends_with('.') { "0" } else { "" };
                    (format!("{digits}{point}_f64"), Kind::Number { literal })
                }
                other => (quote::quote!(#other).to_string(), Kind::Other),
            },
            Expr::Path(path) => self.path(path)?,
            Expr::Reference(inner) => {
                let (text, kind) = self.expression(&inner.expr)?;
                (format!("(&{text})"), Kind::Reference(Box::new(kind)))
            }
            Expr::Unary(unary) => {
                let (text, kind) = self.expression(&unary.expr)?;
                match (&unary.op, kind) {
                    (UnOp::Deref(_), Kind::Reference(kind)) => (format!("(*{text})"), *kind),
                    (UnOp::Neg(_), Kind::Reference(kind)) => (format!("(-{text})"), *kind),
                    (UnOp::Neg(_), Kind::List(kind)) => {
                        self.used(Extension::Arithmetic);
                        (format!("scaled({text}, -1.0)"), Kind::List(kind))
                    }
                    (UnOp::Neg(_), kind) => {
                        if kind == Kind::Int {
                            self.used(Extension::Integers);
                        }
                        let negated = format!("(-{text})");
                        (
                            if matches!(kind, Kind::Number { .. }) {
                                format!("seen{negated}")
                            } else {
                                negated
                            },
                            kind,
                        )
                    }
                    (UnOp::Not(_), kind) => (format!("(!{text})"), kind),
                    _ => return None,
                }
            }
            Expr::Binary(binary) => {
                let (left, right) = (self.expression(&binary.left)?, self.expression(&binary.right)?);
                self.binary(&binary.op, left, right)?
            }
            Expr::Cast(cast) => {
                let (text, _) = self.expression(&cast.expr)?;
                let ty = &cast.ty;
                let ty = quote::quote!(#ty).to_string();
                let kind = if ty == "f64" { NUMBER } else { Kind::Typed(ty.clone()) };
                (format!("({text} as {ty})"), kind)
            }
            Expr::If(conditional) => {
                let (condition, _) = self.expression(&conditional.cond)?;
                let (yes, a) = self.block(&conditional.then_branch)?;
                let (no, b) = self.expression(&conditional.else_branch.as_ref()?.1)?;
                let kind = Self::joined(&a, &b)?;
                let (yes, no) = (self.converted(yes, &a, &kind)?, self.converted(no, &b, &kind)?);
                (format!("(if {condition} {{ {yes} }} else {{ {no} }})"), kind)
            }
            Expr::Block(block) => self.block(&block.block)?,
            Expr::Array(array) => {
                let (items, kind) = self.elements(&array.elems.iter().collect::<Vec<_>>())?;
                (format!("vec![{}]", items.join(", ")), Kind::List(Box::new(kind)))
            }
            Expr::Repeat(repeat) => {
                let (item, kind) = self.expression(&repeat.expr)?;
                let n = self.integer(&repeat.len, "usize")?;
                (format!("vec![{item}; {n}]"), Kind::List(Box::new(kind)))
            }
            Expr::Tuple(tuple) => {
                let items = tuple.elems.iter().map(|e| self.expression(e)).collect::<Option<Vec<_>>>()?;
                let (texts, kinds): (Vec<_>, Vec<_>) = items.into_iter().unzip();
                (format!("({},)", texts.join(", ")), Kind::Tuple(kinds))
            }
            Expr::Field(field) => {
                let (text, kind) = self.expression(&field.base)?;
                match (&field.member, referred(kind)) {
                    (Member::Unnamed(i), Kind::Tuple(kinds)) => {
                        (format!("{text}.{}", i.index), kinds.get(i.index as usize)?.clone())
                    }
                    _ => return None,
                }
            }
            Expr::Index(index) => {
                let (text, kind) = self.expression(&index.expr)?;
                let i = self.integer(&index.index, "usize")?;
                match referred(kind) {
                    // (What is referred to outlives its block.)
                    Kind::List(item) if matches!(*item, Kind::Number { .. } | Kind::Int | Kind::Typed(_)) => {
                        (format!("kept({text})[{i}]"), *item)
                    }
                    Kind::List(item) => (format!("({text})[{i}]"), *item),
                    _ => return None,
                }
            }
            Expr::Range(range) => {
                let (from, a) = self.expression(range.start.as_ref()?)?;
                let (to, b) = self.expression(range.end.as_ref()?)?;
                let kind = Self::joined(&a, &b)?;
                let (from, to) = (self.converted(from, &a, &kind)?, self.converted(to, &b, &kind)?);
                let dots = if matches!(range.limits, syn::RangeLimits::Closed(_)) { "..=" } else { ".." };
                (format!("({from}{dots}{to}).collect::<Vec<_>>()"), Kind::List(Box::new(kind)))
            }
            Expr::Call(call) => self.call(call)?,
            Expr::MethodCall(call) => {
                let receiver = self.expression(&call.receiver)?;
                let arguments: Vec<&Expr> = call.args.iter().collect();
                self.method(receiver, &call.method.to_string(), &arguments, call.turbofish.is_none())?
            }
            _ => return None,
        })
    }

    fn path(&mut self, path: &syn::ExprPath) -> Option<(String, Kind)> {
        if let Some(name) = path.path.get_ident() {
            let found = self.scope.iter().rev().find(|(known, _)| name == known).map(|(_, m)| m.clone());
            return match found {
                Some(Meaning::Value(text, kind)) => Some((text, kind)),
                Some(Meaning::Closure(..)) => None,
                None => {
                    self.used(Extension::Constants);
                    Some((format!("seen(std::f64::consts::{name})"), NUMBER))
                }
            };
        }
        self.used(Extension::Constants);
        let last = &path.path.segments.last()?.ident;
        Some((format!("seen(std::f64::consts::{last})"), NUMBER))
    }

    fn binary(
        &mut self,
        op: &BinOp,
        (a, left): (String, Kind),
        (b, right): (String, Kind),
    ) -> Option<(String, Kind)> {
        let sign = quote::quote!(#op).to_string();
        let arithmetic =
            matches!(op, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_) | BinOp::Rem(_));
        let (plain_left, plain_right) = (referred(left.clone()), referred(right.clone()));
        Some(match (&plain_left, &plain_right) {
            (Kind::List(_), Kind::List(_)) => {
                self.used(Extension::Arithmetic);
                let f = if sign == "+" { "added" } else { "subtracted" };
                (format!("{f}({a}, {b})"), Kind::List(Box::new(NUMBER)))
            }
            (Kind::List(_), _) if matches!(op, BinOp::Mul(_) | BinOp::Div(_)) => {
                self.used(Extension::Arithmetic);
                let b = self.number(behind(b, &right), &plain_right)?;
                let f = if sign == "*" { "scaled" } else { "divided" };
                (format!("{f}({a}, {b})"), Kind::List(Box::new(NUMBER)))
            }
            (_, Kind::List(_)) if matches!(op, BinOp::Mul(_)) => {
                self.used(Extension::Arithmetic);
                let a = self.number(behind(a, &left), &plain_left)?;
                (format!("scaled({b}, {a})"), Kind::List(Box::new(NUMBER)))
            }
            (Kind::Int, Kind::Number { .. }) | (Kind::Number { .. }, Kind::Int) => {
                let a = self.number(behind(a, &left), &plain_left)?;
                let b = self.number(behind(b, &right), &plain_right)?;
                match arithmetic {
                    true => (format!("seen({a} {sign} {b})"), NUMBER),
                    false => (format!("({a} {sign} {b})"), Kind::Other),
                }
            }
            (Kind::Int, Kind::Int) => {
                self.used(Extension::Integers);
                (format!("({a} {sign} {b})"), if arithmetic { Kind::Int } else { Kind::Other })
            }
            (Kind::Number { literal: a_literal }, Kind::Number { literal: b_literal }) => {
                let literal = *a_literal && *b_literal;
                match arithmetic {
                    true => (format!("seen({a} {sign} {b})"), Kind::Number { literal }),
                    false => (format!("({a} {sign} {b})"), Kind::Other),
                }
            }
            (Kind::Typed(ty), Kind::Int | Kind::Typed(_)) | (Kind::Int, Kind::Typed(ty)) => {
                let kind = Kind::Typed(ty.clone());
                let (a, b) =
                    (self.converted(a, &plain_left, &kind)?, self.converted(b, &plain_right, &kind)?);
                (format!("({a} {sign} {b})"), if arithmetic { kind } else { Kind::Other })
            }
            _ => (format!("({a} {sign} {b})"), Kind::Other),
        })
    }

    fn block(&mut self, block: &syn::Block) -> Option<(String, Kind)> {
        let before = self.scope.len();
        let mut text = String::new();
        let (last, lets) = block.stmts.split_last()?;
        for statement in lets {
            let syn::Stmt::Local(syn::Local { pat, init: Some(init), .. }) = statement else { return None };
            if let (Pat::Ident(name), Expr::Closure(closure)) = (pat, &*init.expr) {
                let meaning = Meaning::Closure(Box::new(closure.clone()), self.scope.clone());
                self.scope.push((name.ident.to_string(), meaning));
                continue;
            }
            let (value, kind) = self.expression(&init.expr)?;
            text += &self.bound(pat, value, kind)?;
        }
        let syn::Stmt::Expr(value, None) = last else { return None };
        let (value, kind) = self.expression(value)?;
        self.scope.truncate(before);
        Some((format!("{{ {text}{value} }}"), kind))
    }

    /// `let pattern = value;` with names of their own.
    fn bound(&mut self, pattern: &Pat, value: String, kind: Kind) -> Option<String> {
        let (pattern, value) = match pattern {
            Pat::Type(typed) => {
                let ty = &typed.ty;
                let kind = match (quote::quote!(#ty).to_string().as_str(), kind) {
                    ("_", kind) => kind,
                    ("f64", kind) => {
                        let value = self.number(value, &kind)?;
                        return self.bound(&typed.pat, value, NUMBER);
                    }
                    (ty, Kind::Int) => {
                        let to = Kind::Typed(ty.into());
                        let value = self.converted(value, &Kind::Int, &to)?;
                        return self.bound(&typed.pat, value, to);
                    }
                    (_, kind) => kind,
                };
                return self.bound(&typed.pat, value, kind);
            }
            other => (other, value),
        };
        let pattern = self.pattern(pattern, kind)?;
        Some(format!("let {pattern} = {value}; "))
    }

    fn pattern(&mut self, pattern: &Pat, kind: Kind) -> Option<String> {
        Some(match (pattern, kind) {
            (Pat::Ident(name), kind) => {
                self.names += 1;
                let own = format!("{}_{}", name.ident, self.names);
                let (own_kind, text) = match kind {
                    Kind::List(item) => (Kind::List(item), format!("{own}.clone()")),
                    kind => (kind, own.clone()),
                };
                self.scope.push((name.ident.to_string(), Meaning::Value(text, own_kind)));
                own
            }
            (Pat::Type(typed), kind) => self.pattern(&typed.pat, kind)?,
            (Pat::Paren(inner), kind) => self.pattern(&inner.pat, kind)?,
            (Pat::Wild(_), _) => "_".into(),
            (Pat::Reference(inner), Kind::Reference(kind)) => {
                format!("&{}", self.pattern(&inner.pat, *kind)?)
            }
            (Pat::Tuple(tuple), kind) => {
                let (kinds, referred) = match kind {
                    Kind::Tuple(kinds) => (kinds, false),
                    Kind::Reference(kind) => match *kind {
                        Kind::Tuple(kinds) => (kinds, true),
                        _ => return None,
                    },
                    _ => return None,
                };
                let of = |kind: Kind| if referred { Kind::Reference(Box::new(kind)) } else { kind };
                let parts = tuple.elems.iter().zip(kinds).map(|(p, kind)| self.pattern(p, of(kind)));
                format!("({},)", parts.collect::<Option<Vec<_>>>()?.join(", "))
            }
            _ => return None,
        })
    }

    fn call(&mut self, call: &syn::ExprCall) -> Option<(String, Kind)> {
        let arguments: Vec<&Expr> = call.args.iter().collect();
        let closure = |c: &Expr| match c {
            Expr::Paren(inner) => match &*inner.expr {
                Expr::Closure(closure) => Some(closure.clone()),
                _ => None,
            },
            _ => None,
        };
        if let Some(closure) = closure(&call.func) {
            let scope = self.scope.clone();
            return self.expanded(&closure, scope, &arguments);
        }
        let Expr::Path(path) = &*call.func else { return None };
        let name = path.path.segments.last()?.ident.to_string();
        if path.path.get_ident().is_some() {
            let local = self.scope.iter().rev().find(|(known, _)| *known == name).map(|(_, m)| m.clone());
            if let Some(Meaning::Closure(closure, scope)) = local {
                return self.expanded(&closure, scope, &arguments);
            }
            if name == "f" && local.is_none() {
                let (text, kind) = self.expression(arguments.first()?)?;
                return Some((format!("seen(f({}))", self.number(text, &kind)?), NUMBER));
            }
            self.used(Extension::Functions);
        }
        let (first, rest) = arguments.split_first()?;
        let receiver = self.expression(first)?;
        self.method(receiver, &name, rest, true)
    }

    fn expanded(
        &mut self,
        closure: &syn::ExprClosure,
        scope: Vec<(String, Meaning)>,
        arguments: &[&Expr],
    ) -> Option<(String, Kind)> {
        let arguments = arguments.iter().map(|e| self.expression(e)).collect::<Option<Vec<_>>>()?;
        let before = std::mem::replace(&mut self.scope, scope);
        let mut text = String::new();
        for (pattern, (value, kind)) in closure.inputs.iter().zip(arguments) {
            text += &self.bound(pattern, value, kind)?;
        }
        let (body, kind) = self.expression(&closure.body)?;
        self.scope = before;
        Some((format!("{{ {text}{body} }}"), kind))
    }

    fn method(
        &mut self,
        (receiver, kind): (String, Kind),
        name: &str,
        arguments: &[&Expr],
        untyped: bool,
    ) -> Option<(String, Kind)> {
        if let Kind::List(item) = referred(kind.clone()) {
            let list =
                if matches!(kind, Kind::Reference(_)) { format!("({receiver}).clone()") } else { receiver };
            return self.list_method(
                list,
                *item,
                name,
                arguments,
                untyped,
                matches!(kind, Kind::Reference(_)),
            );
        }
        let plain = referred(kind.clone());
        match plain {
            Kind::Int => self.used(Extension::Integers),
            Kind::Number { literal: true } => self.used(Extension::Literals),
            Kind::Number { .. } => {}
            _ => return None,
        }
        let receiver = if plain == Kind::Int {
            format!("(({}{receiver}).to_owned() as f64)", "*".repeat(references(&kind).saturating_sub(1)))
        } else {
            format!("({receiver})")
        };
        if name == "powi" {
            let n = self.integer(arguments.first()?, "i32")?;
            return Some((format!("seen({receiver}.powi({n}))"), NUMBER));
        }
        let mut texts = Vec::new();
        for argument in arguments {
            let (text, kind) = self.expression(argument)?;
            texts.push(self.number(text, &kind)?);
        }
        if name == "sin_cos" {
            return Some((format!("{receiver}.sin_cos()"), Kind::Tuple(vec![NUMBER, NUMBER])));
        }
        Some((format!("seen({receiver}.{name}({}))", texts.join(", ")), NUMBER))
    }

    fn list_method(
        &mut self,
        list: String,
        item: Kind,
        name: &str,
        arguments: &[&Expr],
        untyped: bool,
        referred_list: bool,
    ) -> Option<(String, Kind)> {
        self.used(Extension::Lists);
        let by_reference = |item: Kind| Kind::List(Box::new(Kind::Reference(Box::new(item))));
        let collect = "collect::<Vec<_>>()";
        let all = |list: String| format!("leaked({list})");
        Some(match (name, arguments) {
            ("into_iter", []) if !referred_list => (list, Kind::List(Box::new(item))),
            ("iter" | "into_iter", []) => (all(list), by_reference(item)),
            ("collect", []) => (list, Kind::List(Box::new(item))),
            ("copied" | "cloned", []) => match item {
                Kind::Reference(item) => (format!("{list}.into_iter().{name}().{collect}"), Kind::List(item)),
                _ => return None,
            },
            ("rev", []) => (format!("{list}.into_iter().rev().{collect}"), Kind::List(Box::new(item))),
            ("len" | "count", []) => (format!("({list}.len() as i64)"), Kind::Int),
            ("enumerate", []) => (
                format!("{list}.into_iter().enumerate().map(|(i, v)| (i as i64, v)).{collect}"),
                Kind::List(Box::new(Kind::Tuple(vec![Kind::Int, item]))),
            ),
            ("take" | "skip", [n]) => {
                let n = self.integer(n, "usize")?;
                (format!("{list}.into_iter().{name}({n}).{collect}"), Kind::List(Box::new(item)))
            }
            ("zip" | "chain", [other]) => {
                let (other, kind) = self.expression(other)?;
                let (other, theirs) = match kind {
                    Kind::List(theirs) => (other, *theirs),
                    Kind::Reference(list) => match *list {
                        Kind::List(theirs) => (all(format!("({other}).clone()")), Kind::Reference(theirs)),
                        _ => return None,
                    },
                    _ => return None,
                };
                let kind = if name == "zip" {
                    Kind::Tuple(vec![item, theirs])
                } else {
                    Self::joined(&item, &theirs)?
                };
                (format!("{list}.into_iter().{name}({other}).{collect}"), Kind::List(Box::new(kind)))
            }
            ("map", [Expr::Closure(closure)]) => {
                let before = self.scope.len();
                let pattern = self.pattern(closure.inputs.first()?, item)?;
                let (body, kind) = self.expression(&closure.body)?;
                self.scope.truncate(before);
                (format!("{list}.into_iter().map(|{pattern}| {body}).{collect}"), Kind::List(Box::new(kind)))
            }
            ("sum" | "product", []) => {
                let plain = referred(item.clone());
                let (ty, kind) = match plain {
                    Kind::Int if untyped && name == "sum" => ("i64", Kind::Int),
                    Kind::Int => {
                        let list = format!("{list}.into_iter().map(|v| v.to_owned() as f64)");
                        return Some((format!("{list}.{name}::<f64>()"), NUMBER));
                    }
                    Kind::Number { .. } => ("f64", NUMBER),
                    Kind::List(item) if name == "sum" => {
                        self.used(Extension::Arithmetic);
                        let _ = self.numbers(String::new(), &item)?;
                        let added = format!("{list}.into_iter().reduce(|a, b| added(a, b)).unwrap()");
                        return Some((added, Kind::List(Box::new(NUMBER))));
                    }
                    _ => return None,
                };
                (format!("{list}.into_iter().{name}::<{ty}>()"), kind)
            }
            ("norm" | "norm_squared", []) => (format!("{name}({})", self.numbers(list, &item)?), NUMBER),
            ("dot" | "cross", [other]) => {
                let (other, kind) = self.expression(other)?;
                let Kind::List(theirs) = kind else { return None };
                let (a, b) = (self.numbers(list, &item)?, self.numbers(other, &theirs)?);
                let kind = if name == "dot" { NUMBER } else { Kind::List(Box::new(NUMBER)) };
                (format!("{name}({a}, {b})"), kind)
            }
            _ => return None,
        })
    }

    /// The list with its integers converted.
    fn numbers(&mut self, list: String, item: &Kind) -> Option<String> {
        match referred(item.clone()) {
            Kind::Int => Some(format!("{list}.into_iter().map(|v| v.to_owned() as f64).collect::<Vec<_>>()")),
            Kind::Number { .. } => Some(list),
            _ => None,
        }
    }
}

/// The number of references to what is referred to.
fn references(kind: &Kind) -> usize {
    if let Kind::Reference(kind) = kind { 1 + references(kind) } else { 0 }
}

fn referred(kind: Kind) -> Kind {
    match kind {
        Kind::Reference(kind) => referred(*kind),
        kind => kind,
    }
}

/// The value that a reference refers to.
fn behind(text: String, kind: &Kind) -> String {
    if matches!(kind, Kind::Reference(_)) { format!("(*{text})") } else { text }
}
