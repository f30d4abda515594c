//! Arithmetic, comparisons and conditions.

use super::*;
use crate::syntax::signs::hundredth;

impl Elaborator<'_> {
    /// A left-deep chain `a + b − c …`, without recursing for each of its terms.
    pub(super) fn chain(&mut self, expression: &Expr) -> Result {
        let mut links = Vec::new();
        let mut first = expression;
        while let Expr::Binary(binary) = first {
            links.push(binary);
            first = &binary.left;
        }
        if let Expr::Unary(syn::ExprUnary { op: UnOp::Not(not), expr, .. }) = first
            && let Some(compared) = links.iter().rev().find(|binary| opposite(&binary.op).is_some())
            && matches!(self.evaluate(expr)?.dereferenced(), Val::Int(_) | Val::Number(_))
        {
            return Err(self.negated_number(not, compared));
        }
        let mut left = self.evaluate(first);
        for binary in links.into_iter().rev() {
            let right = match percentage(binary) {
                Some((percent, of)) => match self.evaluate(of)? {
                    Val::Reference(_) => self.evaluate(&binary.right),
                    _ => {
                        let message = format!(
                            "`%` is the remainder of a division, not a percentage\nhelp: write `{percent} * {}`",
                            plain(of)
                        );
                        return Err(self.errors.push(binary.op, message));
                    }
                },
                None => self.evaluate(&binary.right),
            };
            left = match (left, right) {
                _ if matches!(binary.op, BinOp::BitXor(_)) => Err(self.caret(binary)),
                (Ok(a), Ok(b)) => self.binary(binary, a, b),
                _ => Err(Reported),
            };
        }
        left
    }

    pub(super) fn caret(&mut self, binary: &syn::ExprBinary) -> Reported {
        // The left side is all that binds more strongly, such as `0.5 * m * x`, or an earlier power.
        let mut base = &*binary.left;
        while let Expr::Binary(inner) = base {
            base = &inner.right;
        }
        // The right side is all that binds more strongly, too.
        let mut exponent = &*binary.right;
        while let Expr::Binary(inner) = exponent {
            exponent = &inner.left;
        }
        let (base, exponent) = (plain(base), plain(exponent));
        let exponent = match exponent.strip_prefix(['(', '{']).and_then(|rest| rest.strip_suffix([')', '}']))
        {
            Some(inside) if !inside.contains(['(', ')']) => inside.trim().to_string(),
            _ => exponent,
        };
        let written = match (base.as_str(), exponent.parse::<i32>()) {
            ("10", Ok(n)) => format!("1e{n}"),
            ("e" | "E", _) => format!("exp({exponent})"),
            _ if exponent == "1 / 2" => format!("sqrt({})", base.trim_matches(['(', ')'])),
            _ if exponent == "1 / 3" => format!("cbrt({})", base.trim_matches(['(', ')'])),
            (_, Ok(n)) => format!("{base}.powi({n})"),
            _ => format!("{base}.powf({exponent})"),
        };
        let message = format!(
            "`^` is exclusive or in Rust, and binds more weakly than `+`\nhelp: a power is written `{written}`"
        );
        self.errors.push(binary.op, message)
    }

    pub(super) fn binary(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
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
                    (Val::Bool(_) | Val::Condition(_), other) => Err(self.no_condition(&other, &binary.right)),
                    (other, _) => Err(self.no_condition(&other, &binary.left)),
                }
            }
            BinOp::Rem(op) => match (a.referred(), b.referred()) {
                (a, b) if a.integer().is_some() && b.integer().is_some() => self.arithmetic(binary, a, b),
                _ => Err(self.errors.push(
                    op,
                    "`%` is for compile-time integers: a remainder has no derivative at its jumps\nhelp: a periodic function is made of `sin` and `cos`, such as `sin(2 * PI * t)`",
                )),
            },
            BinOp::BitAnd(_) | BinOp::BitOr(_)
                if [&a, &b].iter().any(|side| matches!(side, Val::Bool(_) | Val::Condition(_))) =>
            {
                let operator = plain(binary.op);
                let message = format!(
                    "`{operator}` does not join conditions\nhelp: conditions are joined by `{operator}{operator}`"
                );
                Err(self.errors.push(binary.op, message))
            }
            _ => Err(self.errors.push(
                binary.op,
                "this operator is not part of the language\nhelp: operators are `+ - * /`, comparisons, `&&` and `||`",
            )),
        }
    }

    pub(super) fn arithmetic(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
        let (a, b) = (a.referred(), b.referred());
        if let (Some(a), Some(b)) = (a.integer(), b.integer()) {
            return self.integers(binary, a, b);
        }
        match (a, b) {
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
            (Val::Rotation(a), Val::Rotation(b)) if matches!(binary.op, BinOp::Mul(_)) => {
                Ok(Val::Rotation(Rc::new(a.iter().chain(b.iter()).cloned().collect())))
            }
            (Val::Rotation(turns), x @ Val::Array(_)) if matches!(binary.op, BinOp::Mul(_)) => {
                let x = self.vector(x, &binary.right)?;
                Ok(self.rotated(&turns, x))
            }
            (Val::Array(a), Val::Array(b)) => {
                let message = match (a.first(), b.first()) {
                    (Some(Val::Array(_)), Some(Val::Int(_) | Val::Number(_))) => {
                        let (a, b) = (plain(&binary.left), plain(&binary.right));
                        format!(
                            "arrays are not multiplied by `*`\nhelp: a matrix times a vector is `{a}.map(|row| row.dot({b}))`"
                        )
                    }
                    _ => {
                        "arrays are not multiplied elementwise\nhelp: the inner product is `a.dot(b)`".into()
                    }
                };
                Err(self.errors.push(binary, message))
            }
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

    pub(super) fn integers(
        &mut self,
        binary: &syn::ExprBinary,
        (a, left): (i64, Option<IntegerType>),
        (b, right): (i64, Option<IntegerType>),
    ) -> Result {
        let ty = self.common_type(binary, left, right)?;
        let result = match binary.op {
            BinOp::Add(_) => a.checked_add(b),
            BinOp::Sub(_) => a.checked_sub(b),
            BinOp::Mul(_) => a.checked_mul(b),
            _ if b == 0 => return Err(self.errors.push(&binary.right, "division by zero")),
            BinOp::Rem(_) => a.checked_rem(b),
            _ if ty.is_some() => a.checked_div(b),
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
                    "an integer division with a remainder, {a} / {b}\n\
                     help: for a quotient write `… as f64 / …`; within an index, `x[… / {b}]`, it is rounded as in Rust"
                );
                return Err(self.errors.push(binary, message));
            }
        };
        self.integer_in(result, ty, binary)
    }

    /// The type of two integers that an operator joins: the one that was written.
    pub(super) fn common_type(
        &mut self,
        at: impl ToTokens,
        left: Option<IntegerType>,
        right: Option<IntegerType>,
    ) -> Result<Option<IntegerType>> {
        match (left, right) {
            (Some(left), Some(right)) if left != right => {
                let message = format!(
                    "integers of the types `{0}` and `{1}`, which Rust does not mix\nhelp: convert one of them, `… as {0}`",
                    left.name(),
                    right.name()
                );
                Err(self.errors.push(at, message))
            }
            _ => Ok(left.or(right)),
        }
    }

    /// The result of an operation with integers; an error where it overflows.
    pub(super) fn integer_in(
        &mut self,
        n: Option<i64>,
        ty: Option<IntegerType>,
        at: impl ToTokens,
    ) -> Result {
        match (n, ty) {
            (Some(n), None) => Ok(Val::Int(n)),
            (Some(n), Some(ty)) if ty.holds(n) => Ok(Val::Typed(n, ty)),
            (_, ty) => {
                let ty = ty.map_or("64 bits".into(), |ty| format!("its type `{}`", ty.name()));
                Err(self
                    .errors
                    .push(at, format!("this integer overflows {ty}\nhelp: compute with numbers, `2.0`")))
            }
        }
    }

    /// `e as type`
    pub(super) fn cast(&mut self, cast: &syn::ExprCast) -> Result {
        let val = self.evaluate(&cast.expr)?;
        let name = match &*cast.ty {
            syn::Type::Path(ty) if ty.qself.is_none() => ty.path.get_ident().map(ToString::to_string),
            _ => None,
        };
        let integer = name.as_deref().and_then(IntegerType::named);
        match (integer, val.integer(), name.as_deref()) {
            (None, Some((n, _)), Some("f64")) => Ok(Val::Number(Value::constant(n))),
            (None, None, Some("f64")) => Ok(Val::Number(self.number(val, &cast.expr)?)),
            (Some(ty), Some((n, _)), _) if ty.holds(n) => Ok(Val::Typed(n, ty)),
            (Some(ty), Some((n, _)), _) => Err(self
                .errors
                .push(cast, format!("`{}` does not hold {n}\nhelp: remove this conversion", ty.name()))),
            (Some(_), None, _) => {
                let message = format!(
                    "{} is not an integer\nhelp: integers are known at compile time, such as `3` or the name of a `const`",
                    val.kind()
                );
                Err(self.errors.push(cast, message))
            }
            _ => {
                let message = "numbers are converted to `f64`, which stands for the type of the system's numbers, and integers to types of integers\nhelp: write `… as f64`";
                Err(self.errors.push(&cast.ty, message))
            }
        }
    }

    pub(super) fn comparison(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
        let (mut a, mut b) = (a, b);
        while let (Val::Reference(_), Val::Reference(_)) = (&a, &b) {
            (a, b) = (a.referred(), b.referred());
        }
        if let (Some((a, left)), Some((b, right))) = (a.integer(), b.integer()) {
            self.common_type(binary, left, right)?;
            return Ok(Val::Bool(match binary.op {
                BinOp::Lt(_) => a < b,
                BinOp::Le(_) => a <= b,
                BinOp::Gt(_) => a > b,
                BinOp::Ge(_) => a >= b,
                BinOp::Eq(_) => a == b,
                _ => a != b,
            }));
        }
        let is_condition = |val: &Val| matches!(val, Val::Bool(_) | Val::Condition(_));
        if is_condition(&a) && is_condition(&b) {
            return Err(self.compared_conditions(binary, &a, &b));
        }
        let (a, b) = (self.number(a, &binary.left)?, self.number(b, &binary.right)?);
        self.equality(binary, a, b);
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

    /// The error of a number where a condition is expected.
    pub(super) fn no_condition(&mut self, val: &Val, at: &Expr) -> Reported {
        let help = match val {
            Val::Int(_) | Val::Number(_) => {
                format!("\nhelp: a number is compared, such as `{} > 0`", plain(at))
            }
            _ => String::new(),
        };
        self.errors.push(at, format!("expected a condition, found {}{help}", val.kind()))
    }

    /// The error of `!x > 0`.
    fn negated_number(&mut self, not: &syn::token::Not, compared: &syn::ExprBinary) -> Reported {
        let (left, operator, right) = (plain(&compared.left), plain(compared.op), plain(&compared.right));
        let left = left.trim_start_matches('!').trim_start();
        let opposite = opposite(&compared.op).unwrap_or_default();
        let message = format!(
            "`!` binds more strongly than `{operator}`, and does not apply to a number\nhelp: write `!({left} {operator} {right})`, or `{left} {opposite} {right}`"
        );
        self.errors.push(not, message)
    }

    /// The error of `c == true`, and of `c == d` for two conditions.
    fn compared_conditions(&mut self, binary: &syn::ExprBinary, a: &Val, b: &Val) -> Reported {
        let (left, right) = (plain(&binary.left), plain(&binary.right));
        let literal = |e: &Expr| matches!(e, Expr::Lit(lit) if matches!(lit.lit, Lit::Bool(_)));
        let (condition, decided) = match (a, b) {
            (_, Val::Bool(decided)) if literal(&binary.right) => (&left, Some(*decided)),
            (Val::Bool(decided), _) if literal(&binary.left) => (&right, Some(*decided)),
            _ => (&left, None),
        };
        let is_equal = matches!(binary.op, BinOp::Eq(_));
        let help = match decided {
            Some(decided) if decided == is_equal => format!("write `{condition}`"),
            Some(_) if matches!(binary.op, BinOp::Eq(_) | BinOp::Ne(_)) => format!("write `!{condition}`"),
            _ => format!("conditions are joined by `&&` and `||`, such as `{left} && {right}`"),
        };
        self.errors.push(binary.op, format!("a condition is used by itself, and not compared\nhelp: {help}"))
    }
}

/// The comparison that holds where this one does not.
fn opposite(op: &BinOp) -> Option<&'static str> {
    Some(match op {
        BinOp::Lt(_) => ">=",
        BinOp::Le(_) => ">",
        BinOp::Gt(_) => "<=",
        BinOp::Ge(_) => "<",
        BinOp::Eq(_) => "!=",
        BinOp::Ne(_) => "==",
        _ => return None,
    })
}

/// The number and the rest of `5% * x`, which Rust reads as `5 % (*x)`.
fn percentage(binary: &syn::ExprBinary) -> Option<(String, &Expr)> {
    let (BinOp::Rem(_), Expr::Unary(syn::ExprUnary { op: UnOp::Deref(_), expr, .. })) =
        (&binary.op, &*binary.right)
    else {
        return None;
    };
    let last = match &*binary.left {
        Expr::Binary(inner) => &*inner.right,
        other => other,
    };
    match last {
        Expr::Lit(lit) => Some((hundredth(&plain(lit))?, expr)),
        _ => None,
    }
}
