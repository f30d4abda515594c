//! Arithmetic, comparisons and conditions.

use super::*;

impl Elaborator<'_> {
    /// A left-deep chain `a + b − c …`, without recursing for each of its terms.
    pub(super) fn chain(&mut self, expression: &Expr) -> Result {
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

    pub(super) fn caret(&mut self, binary: &syn::ExprBinary) -> Reported {
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

    pub(super) fn arithmetic(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
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
            (Val::Rotation(a), Val::Rotation(b)) if matches!(binary.op, BinOp::Mul(_)) => {
                Ok(Val::Rotation(Rc::new(a.iter().chain(b.iter()).cloned().collect())))
            }
            (Val::Rotation(turns), x @ Val::Array(_)) if matches!(binary.op, BinOp::Mul(_)) => {
                let x = self.vector(x, &binary.right)?;
                Ok(self.rotated(&turns, x))
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

    pub(super) fn integers(&mut self, binary: &syn::ExprBinary, a: i64, b: i64) -> Result {
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
                    "an integer division with a remainder, {a} / {b}\n\
                     help: for a quotient write `… as f64 / …`; within an index, `x[… / {b}]`, it is rounded as in Rust"
                );
                return Err(self.errors.push(binary, message));
            }
        };
        result.map(Val::Int).ok_or_else(|| self.errors.push(binary, "this integer overflows"))
    }

    pub(super) fn comparison(&mut self, binary: &syn::ExprBinary, a: Val, b: Val) -> Result {
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
}
