//! Expressions as presentation MathML, which browsers and rustdoc show without scripts.

use crate::graph::{Comparison, Function, Graph, Id, Node, Number, Symbol, Value};
use crate::model::Model;
use std::cell::Cell;
use std::cmp::Ordering;

/// Maximum number of elements of a printed formula.
const MAX_PRINTED_ELEMENTS: usize = 12_000;

/// Maximum number of terms of a printed sum.
const MAX_PRINTED_TERMS: usize = 120;
/// Maximum depth of a printed formula.
const MAX_PRINTED_LEVELS: usize = 16;

/// Writes values in the names of a model.
pub struct Writer<'a> {
    g: &'a Graph,
    depth: Cell<usize>,
    parameters: Vec<String>,
    coordinates: Vec<String>,
    /// Index of the first coordinate of a state of first order.
    states: usize,
    constraints: Vec<String>,
    externals: Vec<String>,
}

impl<'a> Writer<'a> {
    pub fn new(g: &'a Graph, model: &'a Model) -> Self {
        // What was neglected may have parameters that are no fields any more.
        let gone = model.origin.as_ref().map_or(Vec::new(), |origin| origin.gone.clone());
        Writer {
            g,
            depth: Cell::new(0),
            parameters: [model.parameter_labels(), gone].concat(),
            coordinates: model.coordinates.iter().map(|c| c.label()).collect(),
            states: model.mechanical(),
            constraints: model.constraints.iter().map(|c| c.label()).collect(),
            externals: model.externals.iter().map(|f| f.name.to_string()).collect(),
        }
    }

    /// `left = value` as a displayed formula, or `None` if it is too long to be read.
    pub fn equation(&self, left: &str, value: Value) -> Option<String> {
        let mut budget = MAX_PRINTED_ELEMENTS;
        let right = self.sum(value, &mut budget)?;
        Some(displayed(&format!("{left}<mo>=</mo>{right}")))
    }

    /// `value = 0` as a displayed formula.
    pub fn vanishing(&self, value: Value) -> Option<String> {
        let mut budget = MAX_PRINTED_ELEMENTS;
        let left = self.sum(value, &mut budget)?;
        Some(displayed(&format!("{left}<mo>=</mo><mn>0</mn>")))
    }

    /// A multiplier within a line.
    pub fn multiplier(&self, j: usize) -> String {
        format!("<math>{}</math>", self.symbol(Symbol::Multiplier(j)))
    }

    /// Length of a formula, in characters of its markup.
    pub fn length(&self, value: Value) -> usize {
        self.sum(value, &mut MAX_PRINTED_ELEMENTS.clone()).map_or(usize::MAX, |text| text.len())
    }

    /// A formula within a line.
    pub fn inline(&self, value: Value) -> Option<String> {
        let mut budget = MAX_PRINTED_ELEMENTS / 10;
        Some(format!("<math><mrow>{}</mrow></math>", self.sum(value, &mut budget)?))
    }

    /// A symbol within a line.
    pub fn coordinate(&self, i: usize) -> String {
        format!("<math>{}</math>", self.symbol(Symbol::Coordinate(i)))
    }

    pub fn symbol(&self, symbol: Symbol) -> String {
        match symbol {
            Symbol::Time => "<mi>t</mi>".into(),
            Symbol::Parameter(i) => identifier(&self.parameters[i]),
            Symbol::Coordinate(i) => identifier(&self.coordinates[i]),
            Symbol::Velocity(i) if i >= self.states => identifier(&self.coordinates[i]),
            Symbol::Acceleration(i) if i >= self.states => velocity(&self.coordinates[i]),
            Symbol::Velocity(i) => velocity(&self.coordinates[i]),
            Symbol::Acceleration(i) => dotted(&self.coordinates[i], "¨"),
            Symbol::Momentum(i) => format!("<msub><mi>p</mi>{}</msub>", identifier(&self.coordinates[i])),
            Symbol::Multiplier(j) => format!("<msub><mi>λ</mi>{}</msub>", identifier(&self.constraints[j])),
            Symbol::Binding(_)
            | Symbol::Rate(_)
            | Symbol::Reaction(_)
            | Symbol::Given(_)
            | Symbol::Conserved(_)
            | Symbol::Quaternion(_)
            | Symbol::Order(_)
            | Symbol::Side(_) => "<mi>?</mi>".into(),
        }
    }

    /// Terms of a nested sum, if they are few enough to be read.
    fn terms(&self, v: Value) -> Option<Vec<Value>> {
        let (mut terms, mut left) = (Vec::new(), vec![v]);
        while let Some(v) = left.pop() {
            match v.node.map(|n| self.g.node(n)) {
                Some(Node::Sum(a, b)) => left.extend([b.scaled(v.k), a.scaled(v.k)]),
                _ => terms.push(v),
            }
            if terms.len() + left.len() > MAX_PRINTED_TERMS {
                return None;
            }
        }
        Some(terms)
    }

    fn sum(&self, v: Value, budget: &mut usize) -> Option<String> {
        let depth = self.depth.get();
        if depth > MAX_PRINTED_LEVELS {
            return None;
        }
        self.depth.set(depth + 1);
        let text = self.flat_sum(v, budget);
        self.depth.set(depth);
        text
    }

    fn flat_sum(&self, v: Value, budget: &mut usize) -> Option<String> {
        *budget = budget.checked_sub(8)?;
        let mut terms = self.terms(v)?;
        terms.sort_by(|a, b| self.order(*a, *b));
        let mut text = String::new();
        for (i, term) in terms.iter().enumerate() {
            match (i, term.k.is_negative()) {
                (0, false) => {}
                (_, true) => text += "<mo>−</mo>",
                (_, false) => text += "<mo>+</mo>",
            }
            text += &self.term(Value { k: term.k.abs(), ..*term }, budget)?;
        }
        *budget = budget.checked_sub(text.len() / 8)?;
        Some(text)
    }

    /// Accelerations first, then velocities, then the rest; longer products before shorter ones never matters.
    fn order(&self, a: Value, b: Value) -> Ordering {
        let rank = |v: Value| {
            let Some(id) = v.node else { return 9 };
            let factors = self.g.factors(id);
            let has = |wanted: fn(&Symbol) -> bool| {
                factors.iter().any(|f| matches!(self.g.node(f.0), Node::Symbol(s) if wanted(s)))
            };
            match () {
                () if has(|s| matches!(s, Symbol::Acceleration(_))) => 0,
                () if has(|s| matches!(s, Symbol::Velocity(_))) => 1,
                () => 2,
            }
        };
        rank(a).cmp(&rank(b)).then(a.k.is_negative().cmp(&b.k.is_negative())).then(a.node.cmp(&b.node))
    }

    /// A product with a positive coefficient.
    fn term(&self, v: Value, budget: &mut usize) -> Option<String> {
        let Some(id) = v.node else { return Some(number(v.k)) };
        let factors = self.g.factors(id);
        let mut over: Vec<(Id, i32)> = factors.iter().copied().filter(|f| f.1 > 0).collect();
        let mut under: Vec<(Id, i32)> =
            factors.iter().filter(|f| f.1 < 0).map(|&(base, e)| (base, -e)).collect();
        for half in [&mut over, &mut under] {
            half.sort_by_key(|f| (self.rank(f.0), f.0));
        }
        let product = |w: &Self, factors: &[(Id, i32)], alone: bool, budget: &mut usize| -> Option<String> {
            let mut text = String::new();
            for (i, &(base, e)) in factors.iter().enumerate() {
                if i > 0 {
                    // Functions and words stand apart from their neighbours.
                    let long = |id: Id| match w.g.node(id) {
                        Node::Symbol(s) => is_word(&w.symbol(*s)),
                        node => matches!(node, Node::Call(..)),
                    };
                    let apart = long(base) || long(factors[i - 1].0);
                    text += if apart { "<mspace width=\"0.2em\"/>" } else { "<mo>&#x2062;</mo>" };
                }
                text += &w.power(base, e, alone && factors.len() == 1, budget)?;
            }
            Some(text)
        };
        let (n, d) = match v.k {
            Number::Ratio(n, d) if d <= 64 => (n, d),
            _ => (1, 1),
        };
        let decimal = matches!(v.k, Number::Ratio(_, d) if d > 64) || matches!(v.k, Number::Float(..));
        let prefix = if decimal { format!("{}<mo>&#x2062;</mo>", number(v.k)) } else { String::new() };
        if under.is_empty() {
            let k = match (n, d) {
                (1, 1) => String::new(),
                (n, 1) => format!("<mn>{n}</mn><mo>&#x2062;</mo>"),
                (n, d) => format!("<mfrac><mn>{n}</mn><mn>{d}</mn></mfrac><mo>&#x2062;</mo>"),
            };
            let alone = k.is_empty() && prefix.is_empty();
            return Some(format!("{prefix}{k}{}", product(self, &over, alone, budget)?));
        }
        let whole = |n: i64, factors: String| match (n, factors.is_empty()) {
            (1, false) => factors,
            (n, true) => format!("<mn>{n}</mn>"),
            (n, false) => format!("<mn>{n}</mn><mo>&#x2062;</mo>{factors}"),
        };
        let top = whole(n, product(self, &over, n == 1, budget)?);
        let bottom = whole(d, product(self, &under, d == 1, budget)?);
        Some(format!("{prefix}<mfrac><mrow>{top}</mrow><mrow>{bottom}</mrow></mfrac>"))
    }

    /// Parameters, then coordinates, functions, sums, velocities, accelerations.
    fn rank(&self, id: Id) -> usize {
        match self.g.node(id) {
            Node::Symbol(Symbol::Parameter(_)) => 0,
            Node::Symbol(Symbol::Acceleration(_)) => 6,
            Node::Symbol(Symbol::Velocity(_)) => 5,
            Node::Symbol(_) => 1,
            Node::Sum(..) => 4,
            Node::Call(..) => 3,
            _ => 2,
        }
    }

    /// A factor raised to a positive power.
    fn power(&self, base: Id, e: i32, alone: bool, budget: &mut usize) -> Option<String> {
        let exponent = |text: String| if e == 1 { text } else { format!("<msup>{text}<mn>{e}</mn></msup>") };
        Some(match self.g.node(base) {
            Node::Symbol(s) => exponent(self.symbol(*s)),
            Node::Sum(..) if e == 1 && alone => self.sum(base.into(), budget)?,
            Node::Call(f @ (Function::sqrt | Function::abs | Function::exp), x, _) => {
                let x = self.sum(*x, budget)?;
                match *f {
                    Function::sqrt => exponent(format!("<msqrt>{x}</msqrt>")),
                    Function::abs => exponent(format!("<mrow><mo>|</mo>{x}<mo>|</mo></mrow>")),
                    _ if e == 1 => format!("<msup><mi>e</mi><mrow>{x}</mrow></msup>"),
                    _ => format!("<msup><mi>e</mi><mrow><mn>{e}</mn><mo>(</mo>{x}<mo>)</mo></mrow></msup>"),
                }
            }
            Node::Call(Function::powf, x, y) => {
                let (x, y) = (self.sum(*x, budget)?, self.sum(*y, budget)?);
                exponent(format!(
                    "<mrow><mo>(</mo><msup><mrow><mo>(</mo>{x}<mo>)</mo></mrow><mrow>{y}</mrow></msup><mo>)</mo></mrow>"
                ))
            }
            Node::Call(f, x, y) => {
                let name = format!("<mi>{}</mi>", f.row().name);
                let name = if e == 1 { name } else { format!("<msup>{name}<mn>{e}</mn></msup>") };
                let simple = f.row().arguments.len() == 1
                    && x.k.is_one()
                    && x.node.is_some_and(|n| matches!(self.g.node(n), Node::Symbol(_)));
                let argument = self.sum(*x, budget)?;
                if simple {
                    format!("{name}<mo>&#x2061;</mo>{argument}")
                } else if f.row().arguments.len() == 2 {
                    let second = self.sum(*y, budget)?;
                    format!(
                        "{name}<mo>&#x2061;</mo><mrow><mo>(</mo>{argument}<mo>,</mo>{second}<mo>)</mo></mrow>"
                    )
                } else {
                    format!("{name}<mo>&#x2061;</mo><mrow><mo>(</mo>{argument}<mo>)</mo></mrow>")
                }
            }
            Node::Extern(f, orders, arguments) => {
                let primes: usize = orders.iter().map(|o| usize::from(*o)).sum();
                let list: Option<Vec<String>> = arguments.iter().map(|a| self.sum(*a, budget)).collect();
                let name = format!("{}{}", identifier(&self.externals[*f]), "<mo>′</mo>".repeat(primes));
                exponent(format!("<mrow>{name}<mo>(</mo>{}<mo>)</mo></mrow>", list?.join("<mo>,</mo>")))
            }
            Node::Select(comparison, values) => {
                let [a, b, yes, no] = **values;
                let sign = match comparison {
                    Comparison::Less => "&lt;",
                    Comparison::LessEqual => "≤",
                    Comparison::Equal => "=",
                };
                let [a, b, yes, no] = [a, b, yes, no].map(|v| self.sum(v, budget));
                exponent(format!(
                    "<mrow><mo>{{</mo><mtable columnalign=\"left\"><mtr><mtd>{}</mtd><mtd>{}<mo>{sign}</mo>{}</mtd></mtr><mtr><mtd>{}</mtd><mtd><mtext>otherwise</mtext></mtd></mtr></mtable></mrow>",
                    yes?, a?, b?, no?
                ))
            }
            _ => exponent(format!("<mrow><mo>(</mo>{}<mo>)</mo></mrow>", self.sum(base.into(), budget)?)),
        })
    }
}

/// Has the name of this symbol more than one letter?
fn is_word(symbol: &str) -> bool {
    let name = symbol.split("<mi>").nth(1).and_then(|rest| rest.split('<').next());
    name.is_some_and(|name| name.chars().count() > 1)
}

/// A formula on a line of its own, which scrolls where it is too wide.
fn displayed(formula: &str) -> String {
    format!(
        "<div style=\"overflow-x:auto;overflow-y:hidden;padding:0.4em 0\">\n<math display=\"block\" style=\"overflow:visible\"><mrow>{formula}</mrow></math>\n</div>"
    )
}

/// A positive constant: a small fraction as it is, anything else as a decimal.
fn number(k: Number) -> String {
    match k {
        Number::Ratio(n, 1) => format!("<mn>{n}</mn>"),
        Number::Ratio(n, d) if d <= 64 => format!("<mfrac><mn>{n}</mn><mn>{d}</mn></mfrac>"),
        _ => format!("<mn>{}</mn>", k.to_f64()),
    }
}

/// A name and its index: `th1` and `x[2]` and `m_a` have one, `A[0][1]` two in one.
fn split(name: &str) -> (&str, Option<&str>) {
    if let Some((base, index)) = name.split_once('[') {
        return (base, Some(index.trim_end_matches(']')));
    }
    if let Some((base, index)) = name.split_once('_')
        && !base.is_empty()
        && !index.is_empty()
    {
        return (base, Some(index));
    }
    let base = name.trim_end_matches(|c: char| c.is_ascii_digit());
    if base.is_empty() || base.len() == name.len() { (name, None) } else { (base, Some(&name[base.len()..])) }
}

/// The rate of what has this name.
pub fn velocity(name: &str) -> String {
    dotted(name, "˙")
}

/// Base and index apart, so that the dot stands over the letter.
fn dotted(name: &str, dot: &str) -> String {
    match split(name) {
        (_, None) => format!("<mover>{}<mo>{dot}</mo></mover>", identifier(name)),
        (base, Some(index)) => {
            format!("<msub><mover>{}<mo>{dot}</mo></mover>{}</msub>", letters(base), index_text(index))
        }
    }
}

/// A name with its index as a subscript.
pub fn identifier(name: &str) -> String {
    match split(name) {
        (base, None) => letters(base),
        (base, Some(index)) => format!("<msub>{}{}</msub>", letters(base), index_text(index)),
    }
}

fn index_text(index: &str) -> String {
    if let Some((first, second)) = index.split_once("][") {
        return format!("<mrow>{}<mo>,</mo>{}</mrow>", index_text(first), index_text(second));
    }
    if index.chars().all(|c| c.is_ascii_digit()) { format!("<mn>{index}</mn>") } else { letters(index) }
}

/// Names of Greek letters as the letters.
fn letters(name: &str) -> String {
    const GREEK: [(&str, &str); 36] = [
        ("alpha", "α"),
        ("beta", "β"),
        ("gamma", "γ"),
        ("delta", "δ"),
        ("epsilon", "ε"),
        ("zeta", "ζ"),
        ("eta", "η"),
        ("theta", "θ"),
        ("iota", "ι"),
        ("kappa", "κ"),
        ("lambda", "λ"),
        ("mu", "μ"),
        ("nu", "ν"),
        ("xi", "ξ"),
        ("pi", "π"),
        ("rho", "ρ"),
        ("sigma", "σ"),
        ("tau", "τ"),
        ("phi", "φ"),
        ("chi", "χ"),
        ("psi", "ψ"),
        ("omega", "ω"),
        ("Gamma", "Γ"),
        ("Delta", "Δ"),
        ("Theta", "Θ"),
        ("Lambda", "Λ"),
        ("Xi", "Ξ"),
        ("Pi", "Π"),
        ("Sigma", "Σ"),
        ("Phi", "Φ"),
        ("Psi", "Ψ"),
        ("Omega", "Ω"),
        ("th", "θ"),
        ("ph", "φ"),
        ("om", "ω"),
        ("ps", "ψ"),
    ];
    let text = GREEK.iter().find(|g| g.0 == name).map_or(name, |g| g.1);
    format!("<mi>{text}</mi>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names() {
        assert_eq!(identifier("theta"), "<mi>θ</mi>");
        assert_eq!(identifier("th1"), "<msub><mi>θ</mi><mn>1</mn></msub>");
        assert_eq!(identifier("x[2]"), "<msub><mi>x</mi><mn>2</mn></msub>");
        assert_eq!(
            identifier("A[0][1]"),
            "<msub><mi>A</mi><mrow><mn>0</mn><mo>,</mo><mn>1</mn></mrow></msub>"
        );
        assert_eq!(identifier("I3"), "<msub><mi>I</mi><mn>3</mn></msub>");
        assert_eq!(identifier("mass"), "<mi>mass</mi>");
    }
}
