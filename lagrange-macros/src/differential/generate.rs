//! Random systems as a user would write them.

mod bodies;
mod driven;
mod linkage;
mod terms;
mod written;

use crate::graph::modular::{INCREMENT, mixed};
use bodies::bodies;
pub use driven::driven;
use linkage::linkage;
use terms::{Scope, terms};

/// Reproducible random numbers, by SplitMix64.
#[derive(Clone)]
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(INCREMENT);
        mixed(self.0)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// True once in `n` times.
    fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// An expression of the language.
#[derive(Clone)]
pub enum Expr {
    /// In eighths, so that its digits are its value.
    Constant(i32),
    Parameter(usize),
    /// A free coordinate, or after those a prescribed one.
    Position(usize),
    Time,
    Binding(usize),
    /// 1 of some dimension, for changes of units.
    Unit(Unit),
    Sum(Box<Expr>, Box<Expr>),
    Difference(Box<Expr>, Box<Expr>),
    Product(Box<Expr>, Box<Expr>),
    Quotient(Box<Expr>, Box<Expr>),
    Power(Box<Expr>, i32),
    /// With an exponent in eighths.
    Root(Box<Expr>, i32),
    Call(Call, Box<Expr>),
    Pair(Pair, Box<Expr>, Box<Expr>),
    /// `x.mul_add(a, b)`, x a + b
    Fused(Box<[Expr; 3]>),
    /// `if condition { c } else { d }`, with the condition made of a and b.
    Choice(Test, Box<[Expr; 4]>),
    Rate(Box<Expr>),
}

/// Unit of a number.
#[derive(Clone, Copy)]
pub enum Unit {
    Time,
    Frequency,
    Energy,
}

/// Functions of one and of two numbers, with their names.
macro_rules! functions {
    ($($(#[$doc:meta])* $kind:ident: $($function:ident = $name:literal),+;)+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq)]
        pub enum $kind {
            $($function),+
        }

        impl $kind {
            #[allow(dead_code)]
            pub const ALL: &[$kind] = &[$($kind::$function),+];

            pub fn name(self) -> &'static str {
                match self {
                    $($kind::$function => $name),+
                }
            }
        }
    )+};
}

functions! {
    Call: Abs = "abs", Signum = "signum", Sin = "sin", Cos = "cos", Tan = "tan", Asin = "asin", Acos = "acos", Atan = "atan",
        Sinh = "sinh", Cosh = "cosh", Tanh = "tanh", Asinh = "asinh", Acosh = "acosh", Atanh = "atanh", Exp = "exp",
        ExpM1 = "exp_m1", Exp2 = "exp2", Ln = "ln", Ln1p = "ln_1p", Log2 = "log2", Log10 = "log10", Sqrt = "sqrt",
        Cbrt = "cbrt", Recip = "recip", Radians = "to_radians", Degrees = "to_degrees";
    Pair: Atan2 = "atan2", Hypot = "hypot", Powf = "powf", Min = "min", Max = "max";
    /// Conditions on a and b.
    Test: Less = "<", AtMost = "<=", More = ">", AtLeast = ">=", Unlike = "!=", Neither = "!", Both = "&&", Either = "||";
}

impl Expr {
    fn rate(self) -> Expr {
        Expr::Rate(Box::new(self))
    }

    fn power(self, n: i32) -> Expr {
        Expr::Power(Box::new(self), n)
    }

    fn call(self, f: Call) -> Expr {
        Expr::Call(f, Box::new(self))
    }

    fn over(self, other: Expr) -> Expr {
        Expr::Quotient(Box::new(self), Box::new(other))
    }

    fn with(self, f: Pair, other: Expr) -> Expr {
        Expr::Pair(f, Box::new(self), Box::new(other))
    }

    /// 1 + x², whatever x.
    fn positive(self) -> Expr {
        Expr::Constant(8) + self.power(2)
    }
}

impl std::ops::Add for Expr {
    type Output = Expr;
    fn add(self, other: Expr) -> Expr {
        Expr::Sum(Box::new(self), Box::new(other))
    }
}

impl std::ops::Sub for Expr {
    type Output = Expr;
    fn sub(self, other: Expr) -> Expr {
        Expr::Difference(Box::new(self), Box::new(other))
    }
}

impl std::ops::Mul for Expr {
    type Output = Expr;
    fn mul(self, other: Expr) -> Expr {
        Expr::Product(Box::new(self), Box::new(other))
    }
}

/// A constraint: the difference of its sides vanishes.
pub struct Constraint {
    pub left: Expr,
    pub right: Expr,
    pub on_velocities: bool,
}

/// A system; its potential and kinetic energies are written as one Lagrangian if `whole`.
pub struct System {
    /// Kind of what is written.
    pub kind: &'static str,
    pub coordinates: usize,
    pub parameters: usize,
    /// Motions of the prescribed coordinates, in terms of time and parameters.
    pub prescribed: Vec<Expr>,
    pub bindings: Vec<Expr>,
    pub kinetic: Expr,
    pub potential: Expr,
    pub whole: bool,
    pub dissipation: Option<Expr>,
    /// Q of some coordinates.
    pub applied: Vec<(usize, Expr)>,
    /// Forces and where they act.
    pub forces: Vec<(Expr, Expr)>,
    pub constraints: Vec<Constraint>,
    /// Places at which impulses may act.
    pub struck: Vec<Vec<Expr>>,
    pub observed: Vec<Expr>,
    /// A coordinate appears nowhere but in rates, and a reduced system is asked for.
    pub ignorable: bool,
    /// The system by frames and bodies, if it is written so: then bindings, T, V, D, forces, constraints, impulses and
    /// what is observed are what that amounts to, and are not written.
    pub frames: Option<Frames>,
}

/// Statements about frames, in which `«k»` stands for the k-th expression.
#[derive(Clone)]
pub struct Frames {
    pub statements: String,
    pub said: Vec<Expr>,
}

/// A random system: terms of any kind, links that hang together, or bodies on frames.
pub fn system(random: &mut Random) -> System {
    match random.below(6) {
        0 => linkage(random),
        1 | 2 => bodies(random),
        _ => terms(random),
    }
}
