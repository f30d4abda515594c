//! THE table of elementary functions: adding a row adds a function to the language, its derivative to the
//! differentiator, and a method to the runtime's `Scalar` (for floats, lanes and duals alike).

/// One elementary function.
pub struct Row {
    /// Name in the language, both as a method `x.sin()` and as a function `sin(x)`; also the method of `Scalar`.
    pub name: &'static str,
    /// Names of the arguments in `derivatives`.
    pub arguments: &'static [&'static str],
    /// Method of `f64` and `f32` in the standard library.
    pub std: &'static str,
    /// Function of the `libm` crate, for builds without the standard library.
    pub libm: &'static str,
    /// Value, for folding and for the interpreter of tests.
    pub value: fn(&[f64]) -> f64,
    /// Partial derivatives by each argument, written in the language itself.
    pub derivatives: &'static [&'static str],
    /// First sentence of the documentation.
    pub doc: &'static str,
}

/// Index of a row of [`TABLE`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, PartialOrd, Ord)]
pub struct Function(pub u8);

macro_rules! table {
    ($($name:ident($($argument:ident),+) = $std:ident, $libm:ident, [$($derivative:literal),+], $doc:literal;)*) => {
        pub const TABLE: &[Row] = &[$(Row {
            name: stringify!($name),
            arguments: &[$(stringify!($argument)),+],
            std: stringify!($std),
            libm: stringify!($libm),
            value: |a| table!(@call $std a $($argument)+),
            derivatives: &[$($derivative),+],
            doc: $doc,
        }),*];

        #[allow(non_upper_case_globals, dead_code)]
        impl Function {
            table!(@index 0u8; $($name)*);
        }
    };
    (@call $std:ident $a:ident $x:ident) => { f64::$std($a[0]) };
    (@call $std:ident $a:ident $x:ident $y:ident) => { f64::$std($a[0], $a[1]) };
    (@index $i:expr;) => {};
    (@index $i:expr; $name:ident $($rest:ident)*) => {
        pub const $name: Function = Function($i);
        table!(@index $i + 1; $($rest)*);
    };
}

// Abramowitz and Stegun 1964, 4.3.105 ff. (circular), 4.5.71 ff. (hyperbolic), 4.1 and 4.2 (logarithm, exponential).
table! {
    sin(x)      = sin, sin,      ["x.cos()"],                          "Sine.";
    cos(x)      = cos, cos,      ["-x.sin()"],                         "Cosine.";
    tan(x)      = tan, tan,      ["1.0 + x.tan() * x.tan()"],          "Tangent.";
    asin(x)     = asin, asin,    ["1.0 / (1.0 - x * x).sqrt()"],       "Arc sine, in [−π/2, π/2].";
    acos(x)     = acos, acos,    ["-1.0 / (1.0 - x * x).sqrt()"],      "Arc cosine, in [0, π].";
    atan(x)     = atan, atan,    ["1.0 / (1.0 + x * x)"],              "Arc tangent, in (−π/2, π/2).";
    atan2(y, x) = atan2, atan2,  ["x / (x * x + y * y)", "-y / (x * x + y * y)"],
                                                                       "Angle of the point (x, y), as `y.atan2(x)`.";
    sinh(x)     = sinh, sinh,    ["x.cosh()"],                         "Hyperbolic sine.";
    cosh(x)     = cosh, cosh,    ["x.sinh()"],                         "Hyperbolic cosine.";
    tanh(x)     = tanh, tanh,    ["1.0 - x.tanh() * x.tanh()"],        "Hyperbolic tangent.";
    asinh(x)    = asinh, asinh,  ["1.0 / (1.0 + x * x).sqrt()"],       "Inverse hyperbolic sine.";
    acosh(x)    = acosh, acosh,  ["1.0 / (x * x - 1.0).sqrt()"],       "Inverse hyperbolic cosine.";
    atanh(x)    = atanh, atanh,  ["1.0 / (1.0 - x * x)"],              "Inverse hyperbolic tangent.";
    exp(x)      = exp, exp,      ["x.exp()"],                          "Exponential function.";
    exp_m1(x)   = exp_m1, expm1, ["x.exp()"],                          "exp(x) − 1, accurate near 0.";
    exp2(x)     = exp2, exp2,    ["0.693147180559945309417232121458176568 * x.exp2()"],    "Power of 2.";
    ln(x)       = ln, log,       ["1.0 / x"],                          "Natural logarithm.";
    ln_1p(x)    = ln_1p, log1p,  ["1.0 / (1.0 + x)"],                  "ln(1 + x), accurate near 0.";
    log2(x)     = log2, log2,    ["1.44269504088896340735992468100189214 / x"],           "Logarithm to base 2.";
    log10(x)    = log10, log10,  ["0.434294481903251827651128918916605082 / x"],           "Logarithm to base 10.";
    sqrt(x)     = sqrt, sqrt,    ["0.5 / x.sqrt()"],                   "Square root.";
    cbrt(x)     = cbrt, cbrt,    ["1.0 / (3.0 * x.cbrt() * x.cbrt())"], "Cube root.";
    abs(x)      = abs, fabs,     ["x.signum()"],                       "Absolute value.";
    signum(x)   = signum, copysign_one, ["0.0"],                       "Sign of x: 1 or −1, with 0 counted by its sign bit.";
    hypot(x, y) = hypot, hypot,  ["x / x.hypot(y)", "y / x.hypot(y)"], "√(x² + y²).";
    powf(x, y)  = powf, pow,     ["y * x.powf(y - 1.0)", "x.powf(y) * x.ln()"],
                                                                       "x to the power y.";
}

impl Function {
    /// The function of that name.
    pub fn named(name: &str) -> Option<Function> {
        TABLE.iter().position(|row| row.name == name).map(|i| Function(i as u8))
    }

    /// Its row.
    pub fn row(self) -> &'static Row {
        &TABLE[usize::from(self.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_complete() {
        for row in TABLE {
            assert_eq!(row.arguments.len(), row.derivatives.len(), "{}", row.name);
        }
        assert_eq!(Function::sin.row().name, "sin");
        assert_eq!(Function::powf.row().name, "powf");
        assert_eq!(Function::named("exp_m1"), Some(Function::exp_m1));
        assert_eq!(Function::named("gamma"), None);
    }
}
