//! Names that are not known: what was probably meant, and how that is written here.

use super::calls::{ARRAY_METHODS, OBSERVED_ACCELERATION, RATE};
use super::*;
use crate::syntax::words::{CHOICE, GREEK, PERIODIC};

/// Words for accelerations.
const SECOND_DERIVATIVES: [&str; 5] = ["ddot", "dotdot", "ddt2", "diff2", "d2"];

/// Words of other languages, with what is written instead of them.
const FOREIGN: &[(&[&str], &str)] = &[
    (
        &SECOND_DERIVATIVES,
        "accelerations follow from the energies, and are not written; a velocity is `dot(x)`",
    ),
    (
        &[
            "diff",
            "Diff",
            "der",
            "derivative",
            "Derivative",
            "D",
            "d",
            "dt",
            "ddt",
            "d_dt",
            "Dt",
            "deriv",
            "prime",
        ],
        "the time derivative is `dot(x)`; derivatives by coordinates are taken by the compiler",
    ),
    (
        &["pow", "power", "Power", "Pow", "powerf", "powr", "expt"],
        "a power is `x.powi(2)`, with any exponent `x.powf(y)`",
    ),
    (&["square", "sq", "sqr", "squared"], "a square is `x.powi(2)`"),
    (&["cube", "cubed"], "a cube is `x.powi(3)`"),
    (&["sign", "sgn", "Sign"], "the sign of a number is `signum(x)`"),
    (&["log", "Log"], "the natural logarithm is `ln(x)`, that to base 10 `log10(x)`"),
    (&["sec"], "write `1 / cos(x)`"),
    (&["csc", "cosec"], "write `1 / sin(x)`"),
    (&["cot", "ctg", "cotan"], "write `1 / tan(x)`"),
    (&["fabs", "absolute"], "the absolute value is `abs(x)`"),
    (&["heaviside", "Heaviside", "step", "Piecewise", "piecewise", "where", "ifelse", "select"], CHOICE),
    (
        &["sat", "saturate", "saturation", "limiter", "limit", "bound", "clip", "constrain"],
        "a number between bounds is `clamp(u, low, high)`, or `u.clamp(low, high)`; any other choice is `if u > high { … } else { … }`",
    ),
    (
        &["deadzone", "dead_zone", "deadband", "dead_band"],
        "outside a dead zone from -d to d it is `u - clamp(u, -d, d)`",
    ),
    (
        &[
            "interp1",
            "interp",
            "interp2",
            "interpolate",
            "lookup",
            "lookup_table",
            "lut",
            "table",
            "pchip",
            "spline",
        ],
        "measured data are a function with data, `extern name: Curve(x);`, in a formula `name(x)`; those of two variables `extern name: Surface(x, y);`",
    ),
    (
        &["delay", "Delay", "transport_delay", "deadtime", "dead_time", "unit_delay", "memory"],
        "the equations have no memory: a delay by whole periods is a queue in the sampled control law, `stepper.every(period, …)`; one in the system is a state with its rate, in Padé's approximation `state p; rate(p) = 2 * (u - p) / delay; let y = 2 * p - u;`",
    ),
    (
        &["integral", "integrate", "Integral", "cumtrapz"],
        "an integral over time is a state with its rate, `state z; rate(z) = …;`",
    ),
    (
        &["int"],
        "an integral over time is a state with its rate, `state z; rate(z) = …;`; functions that jump everywhere are not part of the language",
    ),
    (&["rate"], RATE),
    (&["ramp"], "a ramp that begins at t0 is `max(t - t0, 0)`"),
    (&["lerp", "mix"], "between a and b it is `a + (b - a) * s`"),
    (
        &["mean", "average", "avg"],
        "the mean of two numbers is `0.5 * (a + b)`, that of an array of N numbers `x.sum() / N`",
    ),
    (&["sinc"], "it is `sin(x) / x`, which has no value at 0"),
    (
        &["erf", "erfc", "gamma", "tgamma", "lgamma", "bessel", "besselj"],
        "a function of your own is declared, `extern fn name(x);`, and written in Rust beside the system, `fn name<S: Scalar>(x: S) -> S`",
    ),
    (
        &["rand", "random", "randn", "noise", "white_noise"],
        "the equations have no chance in them: a random number is a parameter, of which each sample has its own, or an input that is set between steps",
    ),
    (
        &["euler", "Euler", "euler_angles", "from_euler", "rpy"],
        "a rotation by three angles is a product, `rotation_z(a) * rotation_x(b) * rotation_z(c)`",
    ),
    (
        &[
            "rotx", "roty", "rotz", "rotX", "rotY", "rotZ", "rot_x", "rot_y", "rot_z", "Rx", "Ry", "Rz",
            "rotate", "rotate_x", "rotate_y", "rotate_z", "rotateX", "rotateY", "rotateZ",
        ],
        "rotations about the axes are `rotation_x(a)`, `rotation_y(a)` and `rotation_z(a)`",
    ),
    (
        &["omega", "ang_vel", "angvel"],
        "the angular velocity of a frame, in its axes, is `angular_velocity(f)`",
    ),
    (&["floor", "ceil", "round", "trunc", "fract", "modulo", "fmod", "rem", "rem_euclid"], PERIODIC),
    (&["not"], "write `!(x < 0)`"),
    (&["and"], "conditions are joined by `&&`, `x > 0 && t < 1`"),
    (&["or"], "conditions are joined by `||`, `x > 0 || t < 1`"),
    (&["Rational", "Fraction", "rational", "frac"], "a fraction is `1.0 / 2.0`"),
    (
        &["transpose", "inner", "matmul", "dotproduct"],
        "the inner product of arrays is `a.dot(b)`, the square of a length `a.norm_squared()`",
    ),
    (&["sum", "Sum", "prod", "Product"], "a sum over a range is `(0..N).map(|i| …).sum()`"),
    (&["range", "linspace", "arange"], "a range is `0..N`"),
    (&["rad", "radians", "deg2rad", "deg_to_rad"], "degrees become radians by `to_radians(x)`"),
    (&["deg", "degrees", "rad2deg", "rad_to_deg"], "radians become degrees by `to_degrees(x)`"),
    (
        &["Matrix", "matrix", "array", "Array", "vec", "Vector"],
        "an array is `[a, b, c]`, a matrix `[[a, b], [c, d]]`",
    ),
    (&["magnitude", "length", "mag"], "the length of a vector is `[x, y, z].norm()`"),
    (
        &["norm2", "norm_sq", "normsq", "magnitude_squared"],
        "the square of the length of a vector is `[x, y, z].norm_squared()`",
    ),
];

/// Functions that Matlab has for degrees, too, with a `d` behind their names.
const TRIGONOMETRIC: [&str; 6] = ["sin", "cos", "tan", "asin", "acos", "atan"];

/// Modules of other languages, which a function is called through.
const MODULES: [&str; 13] =
    ["np", "numpy", "math", "Math", "sp", "sympy", "sm", "torch", "jnp", "casadi", "ca", "scipy", "Modelica"];

/// Changes of `theta`, the name of a coordinate, by which its velocity and its acceleration are written.
const VELOCITIES: [&str; 18] = [
    "_dot", "dot", "_d", "d", "Dot", "_prime", "_v", "_vel", "_t", "\u{307}", "d|", "d_|", "dot_|", "dot|",
    "v|", "v_|", "d|dt", "d|_dt",
];
const ACCELERATIONS: [&str; 11] =
    ["_ddot", "ddot", "_dd", "dd", "_dotdot", "_dot_dot", "dotdot", "\u{308}", "dd|", "d2|", "d2|dt2"];

/// Letters with a dot, and with two, which rustc makes of a letter and a combining mark.
const DOTTED: [(char, char); 20] = [
    ('ȧ', 'a'),
    ('ḃ', 'b'),
    ('ċ', 'c'),
    ('ḋ', 'd'),
    ('ė', 'e'),
    ('ḟ', 'f'),
    ('ġ', 'g'),
    ('ḣ', 'h'),
    ('ṁ', 'm'),
    ('ṅ', 'n'),
    ('ȯ', 'o'),
    ('ṗ', 'p'),
    ('ṙ', 'r'),
    ('ṡ', 's'),
    ('ṫ', 't'),
    ('ẇ', 'w'),
    ('ẋ', 'x'),
    ('ẏ', 'y'),
    ('ż', 'z'),
    ('Ẋ', 'X'),
];
const TWICE_DOTTED: [(char, char); 8] =
    [('ä', 'a'), ('ë', 'e'), ('ï', 'i'), ('ö', 'o'), ('ü', 'u'), ('ẅ', 'w'), ('ẍ', 'x'), ('ÿ', 'y')];

/// Letters of two code points each, of which keyboards and fonts have one or the other.
const LOOK_ALIKE: [[char; 2]; 5] = [['µ', 'μ'], ['ϕ', 'φ'], ['ϵ', 'ε'], ['ϑ', 'θ'], ['ϱ', 'ρ']];

/// A name in small Latin letters, with Greek letters by their names.
fn folded(name: &str) -> String {
    let letter = |c: char| {
        let c = LOOK_ALIKE.iter().find(|[other, _]| *other == c).map_or(c, |[_, letter]| *letter);
        GREEK
            .iter()
            .find(|(greek, _)| *greek == c)
            .map_or_else(|| c.to_string(), |(_, latin)| (*latin).into())
    };
    name.chars().map(letter).collect::<String>().to_lowercase()
}

/// A name with a combining mark in place of letters that have it.
fn decomposed(name: &str) -> String {
    let letter = |c: char| {
        let plain = |table: &[(char, char)], mark: char| {
            table.iter().find(|(dotted, _)| *dotted == c).map(|(_, plain)| format!("{plain}{mark}"))
        };
        plain(&DOTTED, '\u{307}').or_else(|| plain(&TWICE_DOTTED, '\u{308}')).unwrap_or_else(|| c.to_string())
    };
    name.chars().map(letter).collect()
}

/// Is `name` what one of these changes makes of `base`?
fn is_changed(name: &str, base: &str, changes: &[&str]) -> bool {
    changes.iter().any(|change| match change.split_once('|') {
        Some((before, after)) => {
            name.strip_prefix(before).and_then(|rest| rest.strip_suffix(after)) == Some(base)
        }
        None => name.strip_suffix(change) == Some(base),
    })
}

/// Returns how a word of another language is written here.
fn foreign(word: &str) -> Option<String> {
    if let Some((_, help)) = FOREIGN.iter().find(|(words, _)| words.contains(&word)) {
        return Some((*help).to_string());
    }
    // sind, acosd
    if let Some(name) = word.strip_suffix('d').filter(|name| TRIGONOMETRIC.contains(name)) {
        return Some(match name.starts_with('a') {
            false => format!("angles are in radians: write `{name}(x.to_radians())`"),
            true => format!("angles are in radians: write `{name}(x).to_degrees()`"),
        });
    }
    // arcsin, Sin
    let small = word.to_lowercase();
    let known = |name: &str| is_method(name).then(|| format!("write `{name}`"));
    match small.strip_prefix("arc").or_else(|| small.strip_prefix("ar")) {
        Some(rest) => known(&format!("a{rest}")),
        None if small != word => known(&small),
        None => None,
    }
}

impl Elaborator<'_> {
    /// The error of a name that is none.
    pub(super) fn unknown_name(&mut self, name: &Ident) -> Reported {
        let text = name.to_string();
        // A keyword has been refused where it was declared, and was read as the name that was proposed.
        let refused =
            text.strip_prefix("r#").is_some_and(|raw| self.scope.names.contains_key(&format!("{raw}_")));
        if refused || self.scope.unread.contains_key(&text) {
            return Reported;
        }
        if self.scope.later.contains(&text) {
            let message = format!(
                "`{text}` is not known yet: this statement, or one below it, defines it\nhelp: `let` and `const` use what stands above them; move the definition of `{text}` up"
            );
            return self.errors.push(name, message);
        }
        if self.scope.inputs.contains(&text) {
            let message = format!(
                "`{text}` is an input, and no constant\nhelp: a constant, a length or a default is a number, or the name of a `const`"
            );
            return self.errors.push(name, message);
        }
        if self.scope.outputs.contains(&text) {
            let message = format!(
                "`{text}` is an output, which no expression sees\nhelp: name its value first, `let {text} = …; observe {text};`"
            );
            return self.errors.push(name, message);
        }
        if text == "dot" || is_method(&text) {
            let message = format!("`{text}` is a function\nhelp: call it, `{text}(x)`");
            return self.errors.push(name, message);
        }
        if let Some(known) = self.spelt_otherwise(&text) {
            let differing = text.chars().zip(known.chars()).find(|(a, b)| a != b);
            let help = match differing {
                Some((a, b)) if LOOK_ALIKE.iter().any(|pair| pair.contains(&a) && pair.contains(&b)) => {
                    format!(
                        "\nhelp: the letters look alike: U+{:04X} is written here, U+{:04X} where it is declared",
                        u32::from(a),
                        u32::from(b)
                    )
                }
                _ => String::new(),
            };
            return self.errors.push(name, format!("unknown name `{text}`; did you mean `{known}`?{help}"));
        }
        if text.contains('·') {
            let product = text.replace('·', " * ");
            let message =
                format!("`{text}` is one name: `·` is a letter to Rust\nhelp: a product is `{product}`");
            return self.errors.push(name, message);
        }
        if text == self.system {
            let help = "parameters and coordinates are known by their names alone";
            return self.errors.push(name, format!("unknown name `{text}`\nhelp: {help}"));
        }
        let meant = self.velocity_meant(&text).or_else(|| meant_by(&text));
        if let Some(help) = meant {
            return self.errors.push(name, format!("unknown name `{text}`\nhelp: {help}"));
        }
        let locals = self.scope.locals.iter().map(|(local, _)| local.as_str());
        let hint =
            did_you_mean(&text, self.scope.names.keys().map(String::as_str).chain(locals).chain(["t"]));
        let help = match hint.is_empty() {
            true => {
                "\nhelp: declare it with `param`, `coord`, `const` or, above its first use, `let`; names of the program around the system are not seen: a value from there is a `param`"
            }
            false => "",
        };
        self.errors.push(name, format!("unknown name `{text}`{hint}{help}"))
    }

    /// The known name that differs by capital letters, or by the way in which Greek letters are written.
    fn spelt_otherwise(&self, text: &str) -> Option<String> {
        if ["T", "V", "L"].contains(&text) {
            return None;
        }
        let locals = self.scope.locals.iter().map(|(local, _)| local);
        let wanted = folded(text);
        self.scope.names.keys().chain(locals).find(|known| folded(known) == wanted).cloned()
    }

    /// `theta_dot` and the like.
    fn velocity_meant(&self, text: &str) -> Option<String> {
        let text = decomposed(text);
        let moves =
            |entry: &Entry| matches!(entry, Entry::Coordinate { .. } | Entry::Prescribed(_) | Entry::Let(_));
        let bases = || self.scope.names.iter().filter(|(_, (_, entry))| moves(entry)).map(|(name, _)| name);
        let changed = |changes: &[&str]| bases().find(|base| is_changed(&text, base, changes));
        if let Some(base) = changed(&ACCELERATIONS) {
            return Some(format!(
                "accelerations follow from the energies, and are not written; the velocity of `{base}` is `dot({base})`"
            ));
        }
        changed(&VELOCITIES).map(|base| format!("the velocity of `{base}` is `dot({base})`"))
    }

    /// The error of a function that is none.
    pub(super) fn unknown_function(&mut self, name: &Ident) -> Reported {
        let text = name.to_string();
        if self.scope.unread.contains_key(&text) {
            return Reported;
        }
        if ARRAY_METHODS.contains(&text.as_str()) {
            let example = match text.as_str() {
                "sum" | "product" => format!("`(0..N).map(|i| …).{text}()`"),
                _ => format!("`x.{text}(…)`"),
            };
            let message = format!("`{text}` is called as a method\nhelp: write {example}");
            return self.errors.push(name, message);
        }
        if self.observing && SECOND_DERIVATIVES.contains(&text.as_str()) {
            return self.errors.push(
                name,
                format!("unknown function `{text}`: {OBSERVED_ACCELERATION}; remove this statement"),
            );
        }
        if let Some(help) = foreign(&text) {
            return self.errors.push(name, format!("unknown function `{text}`\nhelp: {help}"));
        }
        let mut known: Vec<String> = self.scope.functions.iter().map(|f| f.name.to_string()).collect();
        known.extend(self.found.externals.iter().map(|f| f.name.to_string()));
        known.extend(TABLE.iter().map(|row| row.name.to_string()));
        known.extend(FUNCTIONS.into_iter().chain(ROTATIONS).map(String::from));
        known.extend(["dot", "min", "max", "powi"].map(String::from));
        let hint = did_you_mean(&text, known.iter().map(String::as_str));
        let help = match hint.is_empty() {
            true => format!(
                "\nhelp: define it with `fn {text}(x) = …;`, or declare a Rust function of your own with `extern fn {text}(x);`"
            ),
            false => String::new(),
        };
        self.errors.push(name, format!("unknown function `{text}`{hint}{help}"))
    }

    /// The error of `x.name` without parentheses.
    pub(super) fn unknown_field(&mut self, name: &Ident, base: &Val, written: &Expr) -> Reported {
        let text = name.to_string();
        let items = if let Val::Array(items) = base { items.as_slice() } else { &[] };
        let component = ["x", "y", "z"].iter().take(items.len()).position(|component| text == *component);
        let help = match (text.as_str(), component) {
            _ if matches!(items.first(), Some(Val::Rotation(_))) => {
                let base = plain(written);
                format!("`{base}` is an array of rotations, of which the first is `{base}[0]`")
            }
            (_, Some(i)) => {
                format!("components are the elements of an array, `{}[{i}]`", plain(written))
            }
            ("dot", _) => "the time derivative is `dot(x)`".into(),
            _ if is_method(&text) && method_arity(&text) == 0 => {
                format!("a function is called, `x.{text}()`")
            }
            _ if is_method(&text) => format!("a function is called, `x.{text}(…)`"),
            _ if ARRAY_METHODS.contains(&text.as_str()) => format!("a method is called, `x.{text}(…)`"),
            _ => foreign(&text).unwrap_or_else(|| {
                "tuples have the fields `.0`, `.1` and so on; an element of an array is `x[0]`".into()
            }),
        };
        self.errors.push(name, format!("there is no such field\nhelp: {help}"))
    }

    /// The error of a method of numbers that is none.
    pub(super) fn unknown_method(&mut self, name: &Ident) -> Reported {
        let text = name.to_string();
        if text == "dot" {
            let message = "a number has no inner product\nhelp: the time derivative is `dot(x)`; the inner product of arrays is `a.dot(b)`";
            return self.errors.push(name, message);
        }
        if let Some(help) = foreign(&text).filter(|_| !ARRAY_METHODS.contains(&text.as_str())) {
            return self.errors.push(name, format!("unknown function `{text}`\nhelp: {help}"));
        }
        let hint = did_you_mean(&text, METHODS.into_iter().chain(TABLE.iter().map(|row| row.name)));
        let help = match ARRAY_METHODS.contains(&text.as_str()) {
            true => "\nhelp: this is a method of arrays",
            false if hint.is_empty() => "\nhelp: a function of your own is called as `f(x)`",
            false => "",
        };
        self.errors.push(name, format!("unknown function `{text}`{hint}{help}"))
    }
}

/// Returns how a word that everybody knows is written.
fn meant_by(name: &str) -> Option<String> {
    Some(match name {
        "pi" | "Pi" | "π" | "M_PI" | "pi_" => "this number is `PI`".into(),
        "tau" | "TAU" | "Tau" | "τ" => {
            "2π is `2 * PI`, or `f64::consts::TAU`; a time constant is declared, `param tau;`"
                .replace("param tau", &format!("param {name}"))
        }
        "E" | "e" => format!(
            "Euler's number is `f64::consts::E`, and its power `exp(x)`; a parameter is declared, `param {name};`"
        ),
        "inf" | "Inf" | "infinity" | "Infinity" | "INFINITY" | "oo" => {
            "numbers are finite: a wall is a stiff spring, or an event of the run with an `impulse`".into()
        }
        "nan" | "NaN" | "NAN" | "None" | "null" | "nil" => {
            "every expression has a value: write a number".into()
        }
        "end" => "the last of N elements is `x[N - 1]`".into(),
        "g" => "declare it, `param g = 9.81;`".into(),
        "time" | "Time" => "time is `t`".into(),
        "dt" | "d_dt" | "ddt" => "the time derivative is `dot(x)`".into(),
        "q" | "qd" | "qdot" | "q_dot" | "dq" => {
            "coordinates are known by their names, velocities as `dot(name)`".into()
        }
        "T" | "V" | "L" | "U" | "K" => {
            format!(
                "energies are not names: name the expression, `let kinetic = …;`, and use that; L = T − V is formed by itself, and T + V is the function `energy`; a parameter is declared, `param {name};`"
            )
        }
        "energy" | "kinetic" | "potential" | "energies" => format!(
            "energies are functions of the system, `system.energy_at(&state)`; one that is an output is written out, or named by a `let` above: `let {name} = …;`"
        ),
        "self" | "Self" | "this" => "parameters and coordinates are known by their names alone".into(),
        "True" | "False" => format!("write `{}`", name.to_lowercase()),
        _ if MODULES.contains(&name) => {
            "functions need no module: write `sin(x)` or `x.sin()`; π is `PI`".into()
        }
        _ if constant(name).is_some() => format!("this number is `f64::consts::{name}`"),
        _ => return None,
    })
}
