//! Straight-line programs: slots, and the operations that fill them. `accel`, every other output and the recurrences
//! of series are programs, lowered from the graph (`program/lower.rs`), counted (`program/count.rs`), evaluated here,
//! and printed by `emit/body.rs`.

pub mod count;
pub mod lower;

use crate::graph::{Coefficient, Comparison, Function, Id, Number, Symbol, Value, evaluate};

/// A straight-line function.
#[derive(Default)]
pub struct Program {
    /// Numbers that the function is given beside its inputs, without their signs.
    pub constants: Vec<Value>,
    /// Symbols that it reads.
    pub inputs: Vec<Symbol>,
    /// Operations that fill the slots, operands first.
    pub slots: Vec<Slot>,
    pub outputs: Vec<Operand>,
}

pub struct Slot {
    pub operation: Operation,
    /// The node that the slot has the value of, but for a sign that its only user asked for.
    pub node: Id,
    /// Written inside its only user.
    pub inline: bool,
}

/// A coefficient times what a program knows. Coefficients other than ±1 are multiplications, and the optimizer shares
/// equal ones.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Operand {
    pub k: Number,
    pub of: Source,
}

#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Source {
    /// Nothing: the operand is its coefficient.
    One,
    Symbol(Symbol),
    /// A constant of the program.
    Constant(usize),
    Slot(usize),
}

pub enum Operation {
    /// a + b; a is not subtracted unless both are.
    Sum(Operand, Operand),
    /// x y + rest, as a fused multiply-add.
    Fused([Operand; 2], Operand),
    Product(Operand, Operand),
    Quotient(Operand, Operand),
    /// Quotient of x by the order of the series.
    OverOrder(Operand),
    /// Quotient of x by the order of the series, plus the rest.
    OverOrderPlus(Operand, Operand),
    /// An elementary function; the second argument is 0 for functions of one.
    Call(Function, Operand, Operand),
    /// A function of the user's, differentiated `orders[i]` times by its argument i.
    Extern(usize, Box<[u8]>, Vec<Operand>),
    /// `if a ∘ b { yes } else { no }` of `[a, b, yes, no]`
    Select(Comparison, [Operand; 4]),
    /// Sines and cosines of these angles at once; the slots that follow are the sine and the cosine of each.
    Circle(Vec<Operand>),
    Sine(Operand),
    Cosine(Operand),
}

impl std::ops::Neg for Operand {
    type Output = Operand;

    fn neg(self) -> Operand {
        Operand { k: self.k.neg(), ..self }
    }
}

impl Operation {
    pub fn operands(&self, mut visit: impl FnMut(Operand)) {
        use Operation::*;
        match self {
            Sum(a, b) | Product(a, b) | Quotient(a, b) | OverOrderPlus(a, b) | Call(_, a, b) => {
                visit(*a);
                visit(*b);
            }
            Fused([x, y], rest) => [*x, *y, *rest].into_iter().for_each(visit),
            OverOrder(x) | Sine(x) | Cosine(x) => visit(*x),
            Extern(_, _, all) | Circle(all) => all.iter().copied().for_each(visit),
            Select(_, all) => all.iter().copied().for_each(visit),
        }
    }
}

impl Program {
    /// The number of statements: what is written inside its user is none, and sines and cosines at once are one.
    pub fn statements(&self) -> usize {
        let is_part = |slot: &&Slot| matches!(slot.operation, Operation::Sine(_) | Operation::Cosine(_));
        self.slots.iter().filter(|slot| !slot.inline && !is_part(slot)).count()
    }

    /// The outputs in floating point, with the result of every operation rounded in some way.
    pub fn evaluate(
        &self,
        constants: &[f64],
        symbol: impl Fn(Symbol) -> f64,
        rounded: impl Fn(f64) -> f64,
    ) -> Vec<f64> {
        let mut slots: Vec<f64> = Vec::with_capacity(self.slots.len());
        let of = |slots: &[f64], v: Operand| {
            let x = match v.of {
                Source::One => 1.0,
                Source::Symbol(s) => symbol(s),
                Source::Constant(i) => constants[i],
                Source::Slot(i) => slots[i],
            };
            v.k.to_f64() * x
        };
        for slot in &self.slots {
            let at = |v: Operand| of(&slots, v);
            let over = |x: Operand| at(x) * symbol(Symbol::Order(Coefficient::Over));
            let value = match &slot.operation {
                Operation::Sum(a, b) => at(*a) + at(*b),
                Operation::Fused([x, y], rest) => rounded(at(*x) * at(*y)) + at(*rest),
                Operation::Product(a, b) => at(*a) * at(*b),
                Operation::Quotient(a, b) => at(*a) / at(*b),
                Operation::OverOrder(x) => over(*x),
                Operation::OverOrderPlus(x, rest) => rounded(over(*x)) + at(*rest),
                Operation::Call(f, a, b) => (f.row().value)(&[at(*a), at(*b)]),
                Operation::Extern(f, orders, arguments) => {
                    evaluate::external(*f, orders, arguments.iter().map(|a| at(*a)))
                }
                Operation::Select(comparison, [a, b, yes, no]) => {
                    at(if comparison.holds(at(*a), at(*b)) { *yes } else { *no })
                }
                Operation::Circle(_) => 0.0,
                Operation::Sine(angle) => at(*angle).sin(),
                Operation::Cosine(angle) => at(*angle).cos(),
            };
            slots.push(rounded(value));
        }
        self.outputs.iter().map(|v| of(&slots, *v)).collect()
    }
}
