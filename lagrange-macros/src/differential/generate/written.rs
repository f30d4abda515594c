//! Systems in the words of the language, and in those of SymPy.

use super::*;
use std::fmt;

/// An expression as it is written in a system of `n` coordinates.
struct Written<'e>(&'e Expr, usize);

impl fmt::Display for Written<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Written(e, n) = *self;
        let w = |e| Written(e, n);
        match e {
            Expr::Constant(k) => write!(f, "({:?})", f64::from(*k) / 8.0),
            Expr::Parameter(i) => write!(f, "p{i}"),
            Expr::Position(i) if *i < n => write!(f, "q{i}"),
            Expr::Position(i) => write!(f, "s{}", i - n),
            Expr::Time => write!(f, "t"),
            Expr::Binding(k) => write!(f, "u{k}"),
            Expr::Unit(_) => write!(f, "1"),
            Expr::Sum(a, b) => write!(f, "({} + {})", w(a), w(b)),
            Expr::Difference(a, b) => write!(f, "({} - {})", w(a), w(b)),
            Expr::Product(a, b) => write!(f, "{} * {}", w(a), w(b)),
            Expr::Quotient(a, b) => write!(f, "({} / ({}))", w(a), w(b)),
            Expr::Power(a, k) => write!(f, "({}).powi({k})", w(a)),
            // The literal is a real number, whatever its value.
            Expr::Root(a, k) => write!(f, "({}).powf({:?})", w(a), f64::from(*k) / 8.0),
            // By both forms of a call.
            Expr::Call(c @ (Call::Recip | Call::Signum | Call::Degrees), a) => {
                write!(f, "({}).{}()", w(a), c.name())
            }
            Expr::Call(c, a) => write!(f, "{}({})", c.name(), w(a)),
            Expr::Pair(c, a, b) => write!(f, "({}).{}({})", w(a), c.name(), w(b)),
            Expr::Fused(parts) => {
                let [x, a, b] = &**parts;
                write!(f, "({}).mul_add({}, {})", w(x), w(a), w(b))
            }
            Expr::Choice(test, parts) => {
                let [a, b, yes, no] = &**parts;
                let (a, b) = (w(a), w(b));
                let condition = match test {
                    Test::Neither => format!("!(({a}) > 0 || ({b}) > 0)"),
                    Test::Both => format!("({a}) < 1 && ({b}) < ({a})"),
                    Test::Either => format!("({a}) < ({b}) || ({b}) <= 0"),
                    _ => format!("({a}) {} ({b})", test.name()),
                };
                write!(f, "(if {condition} {{ {} }} else {{ {} }})", w(yes), w(no))
            }
            Expr::Rate(a) => write!(f, "dot({})", w(a)),
        }
    }
}

/// An expression in the words of SymPy, for `tests/peers/sympy_systems.py`.
struct Python<'e>(&'e Expr);

impl fmt::Display for Python<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let p = |e| Python(e);
        match self.0 {
            Expr::Constant(k) => write!(f, "Rational({k}, 8)"),
            Expr::Parameter(i) => write!(f, "p[{i}]"),
            Expr::Position(i) => write!(f, "x[{i}]"),
            Expr::Time => write!(f, "t"),
            Expr::Binding(k) => write!(f, "u[{k}]"),
            Expr::Unit(_) => write!(f, "1"),
            Expr::Sum(a, b) => write!(f, "({} + {})", p(a), p(b)),
            Expr::Difference(a, b) => write!(f, "({} - {})", p(a), p(b)),
            Expr::Product(a, b) => write!(f, "({} * {})", p(a), p(b)),
            Expr::Quotient(a, b) => write!(f, "({} / {})", p(a), p(b)),
            Expr::Power(a, k) => write!(f, "(({})**{k})", p(a)),
            Expr::Root(a, k) => write!(f, "(({})**Rational({k}, 8))", p(a)),
            Expr::Call(c, a) => write!(f, "{}({})", c.name(), p(a)),
            Expr::Pair(c, a, b) => write!(f, "{}({}, {})", c.name(), p(a), p(b)),
            Expr::Fused(parts) => {
                let [x, a, b] = &**parts;
                write!(f, "({} * {} + {})", p(x), p(a), p(b))
            }
            // Systems with choices are not written for SymPy.
            Expr::Choice(..) => write!(f, "nan"),
            Expr::Rate(a) => write!(f, "diff({}, t)", p(a)),
        }
    }
}

impl System {
    /// The entries of a JSON object that say what the system is.
    pub fn json(&self) -> String {
        let one = |e: &Expr| format!("{:?}", Python(e).to_string());
        let many = |all: &[Expr]| all.iter().map(one).collect::<Vec<_>>().join(", ");
        let pairs: Vec<String> =
            self.forces.iter().map(|(force, at)| format!("[{}, {}]", one(force), one(at))).collect();
        let applied: Vec<String> = self.applied.iter().map(|(i, q)| format!("[{i}, {}]", one(q))).collect();
        let constraints: Vec<String> = self
            .constraints
            .iter()
            .map(|c| format!("[{}, {}]", one(&(c.left.clone() - c.right.clone())), c.on_velocities))
            .collect();
        format!(
            "\"coordinates\": {}, \"prescribed\": [{}], \"bindings\": [{}], \"T\": {}, \"V\": {}, \"D\": {}, \
             \"applied\": [{}], \"forces\": [{}], \"constraints\": [{}]",
            self.coordinates,
            many(&self.prescribed),
            many(&self.bindings),
            one(&self.kinetic),
            one(&self.potential),
            self.dissipation.as_ref().map_or("\"0\"".into(), one),
            applied.join(", "),
            pairs.join(", "),
            constraints.join(", ")
        )
    }

    /// Its statements, called `name`.
    pub fn written(&self, name: &str) -> String {
        let w = |e| Written(e, self.coordinates);
        let mut lines = vec![
            format!(
                "param {};",
                (0..self.parameters).map(|i| format!("p{i}")).collect::<Vec<_>>().join(", ")
            ),
            format!(
                "coord {};",
                (0..self.coordinates).map(|i| format!("q{i}")).collect::<Vec<_>>().join(", ")
            ),
        ];
        let mut line = |text: String| lines.push(text);
        for (k, motion) in self.prescribed.iter().enumerate() {
            line(format!("coord s{k} = {};", w(motion)));
        }
        if let Some(frames) = &self.frames {
            line(frames.written(self.coordinates));
        } else {
            self.own_words(&mut line);
        }
        for (i, q) in &self.applied {
            line(format!("Q[q{i}] = {};", w(q)));
        }
        if self.ignorable {
            line("pub routhian Reduced;".into());
        }
        format!("pub system {name} {{\n    {}\n}}", lines.join("\n    "))
    }

    /// Bindings, energies and what acts, as expressions.
    fn own_words(&self, line: &mut impl FnMut(String)) {
        let w = |e| Written(e, self.coordinates);
        for (k, value) in self.bindings.iter().enumerate() {
            line(format!("let u{k} = {};", w(value)));
        }
        match self.whole {
            true => line(format!("L = {} - ({});", w(&self.kinetic), w(&self.potential))),
            false => line(format!("T = {}; V = {};", w(&self.kinetic), w(&self.potential))),
        }
        if let Some(d) = &self.dissipation {
            line(format!("D = {};", w(d)));
        }
        for (force, at) in &self.forces {
            line(format!("force {} at {};", w(force), w(at)));
        }
        for (j, c) in self.constraints.iter().enumerate() {
            line(format!("constraint c{j}: {} == {};", w(&c.left), w(&c.right)));
        }
        for (j, place) in self.struck.iter().enumerate() {
            let place: Vec<String> = place.iter().map(|x| w(x).to_string()).collect();
            line(format!("impulse blow{j} at [{}];", place.join(", ")));
        }
        for (j, value) in self.observed.iter().enumerate() {
            line(format!("observe seen{j} = {};", w(value)));
            // With time, so that it moves.
            line(format!("event hit{j}: t + ({}), rising;", w(value)));
        }
    }
}

impl Frames {
    /// With its expressions in it.
    fn written(&self, coordinates: usize) -> String {
        let mut rest = self.statements.as_str();
        let mut text = String::new();
        while let Some((before, after)) = rest.split_once('«') {
            let (k, after) = after.split_once('»').expect("a number in quotes");
            let k: usize = k.parse().expect("a number");
            text += before;
            text += &Written(&self.said[k], coordinates).to_string();
            rest = after;
        }
        text + rest
    }
}
