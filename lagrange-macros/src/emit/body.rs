//! A program as Rust over `S: Scalar`.

use crate::graph::{Comparison, Graph, Id, Node, Number, Symbol, Value, stable_map::StableMap};
use crate::model::{External, Model};
use crate::schedule::{Circular, Program, Step};
use proc_macro2::{Ident, Literal, Span, TokenStream};
use quote::{format_ident, quote};
use std::collections::BTreeSet;

/// Names of symbols and of the user's bindings in emitted functions.
pub struct Names {
    runtime: TokenStream,
    parameters: Vec<(Ident, TokenStream)>,
    coordinates: Vec<Ident>,
    velocities: Vec<Ident>,
    momenta: Vec<Ident>,
    given: Vec<Ident>,
    externals: Vec<External>,
    /// What the user called the value of a node.
    bindings: StableMap<Id, Ident>,
    taken: BTreeSet<String>,
}

impl Names {
    /// `bindings` are nodes with the names of the user's bindings.
    pub fn new(model: &Model, bindings: &[(String, Value)]) -> Names {
        let reserved = [
            "q",
            "qd",
            "p",
            "t",
            "given",
            "impulse",
            "rates",
            "rows",
            "motion",
            "unknowns",
            "solver",
            "over",
            "level",
            "order",
            "at",
            "constants",
            "self",
            "S",
            "Self",
            "numbers",
            "reciprocals",
            "zeroth",
            "before",
            "ends",
            "products",
            "squares",
            "accelerations",
            "found",
            "changes",
            "columns",
            "unit",
            "advance",
            "respond",
        ];
        let mut taken: BTreeSet<String> = reserved.into_iter().map(String::from).collect();
        // A variable would hide a function of the user's.
        taken.extend(model.externals.iter().map(|f| f.name.to_string()));
        let mut parameters = Vec::new();
        for parameter in &model.parameters {
            let field = &parameter.name;
            for i in 0..parameter.length.unwrap_or(1) {
                parameters.push(match parameter.length {
                    None => (unique(&mut taken, &field.to_string()), quote!(self.#field)),
                    Some(_) => {
                        let (name, at) = (format!("{field}_{i}"), Literal::usize_unsuffixed(i));
                        (unique(&mut taken, &name), quote!(self.#field[#at]))
                    }
                });
            }
        }
        let mut all = |suffix: &str| -> Vec<Ident> {
            let name = |c: &crate::model::Coordinate| {
                let index = c.index.map_or(String::new(), |i| format!("_{i}"));
                unique(&mut taken, &format!("{}{index}{suffix}", c.name))
            };
            model.coordinates.iter().map(name).collect()
        };
        let (coordinates, velocities, momenta) = (all(""), all("_dot"), all("_momentum"));
        let bordered = model.coordinates.len() + model.constraints.len();
        let longest = model.struck.iter().map(|s| s.position.len()).chain([bordered]).max().unwrap_or(0);
        let given = (0..longest).map(|i| unique(&mut taken, &format!("given_{i}"))).collect();
        let mut named: StableMap<Id, Ident> = StableMap::default();
        for (name, value) in bindings {
            if let Some(node) = value.node.filter(|n| named.get(n).is_none() && value.k.is_one()) {
                let text: String = name.replace('[', "_").replace(']', "");
                named.insert(node, unique(&mut taken, &text));
            }
        }
        let runtime = model.runtime.clone();
        let externals = model.externals.clone();
        Names {
            runtime,
            parameters,
            coordinates,
            velocities,
            momenta,
            given,
            externals,
            bindings: named,
            taken,
        }
    }

    fn symbol(&self, symbol: Symbol) -> Ident {
        match symbol {
            Symbol::Time => format_ident!("t"),
            Symbol::Parameter(i) => self.parameters[i].0.clone(),
            Symbol::Coordinate(i) => self.coordinates[i].clone(),
            Symbol::Velocity(i) => self.velocities[i].clone(),
            Symbol::Momentum(i) => self.momenta[i].clone(),
            Symbol::Given(i) => self.given[i].clone(),
            Symbol::Acceleration(_)
            | Symbol::Multiplier(_)
            | Symbol::Reaction(_)
            | Symbol::Binding(_)
            | Symbol::Rate(_) => {
                unreachable!("substituted before emission")
            }
        }
    }
}

/// The wanted name, with underscores until it is new.
fn unique(taken: &mut BTreeSet<String>, wanted: &str) -> Ident {
    let mut name = wanted.to_string();
    while !taken.insert(name.clone()) {
        name.push('_');
    }
    // A raw identifier of the user's keeps its prefix out of composed names.
    Ident::new(name.trim_start_matches("r#"), Span::call_site())
}

/// An expression and how tightly its outermost operator binds.
pub struct Written(TokenStream, Binding);

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Binding {
    Sum,
    Product,
    Minus,
    Atom,
}

impl Written {
    fn atom(tokens: TokenStream) -> Written {
        Written(tokens, Binding::Atom)
    }

    fn in_parentheses_below(self, binding: Binding) -> TokenStream {
        let tokens = self.0;
        if self.1 < binding { quote!((#tokens)) } else { tokens }
    }

    /// Left of `*` and `/`, right of `+` and `-`.
    fn factor(self) -> TokenStream {
        self.in_parentheses_below(Binding::Product)
    }

    /// Right of `*` and `/`, after a minus sign, before a method.
    fn receiver(self) -> TokenStream {
        self.in_parentheses_below(Binding::Atom)
    }
}

/// The statements of a program; `outputs` afterwards gives its results.
pub struct Body<'a> {
    g: &'a Graph,
    names: &'a Names,
    program: &'a Program,
    lets: StableMap<Id, Ident>,
    constants: StableMap<Value, Ident>,
    taken: BTreeSet<String>,
}

/// Statements and output expressions. The constants of the program are those of an array `constants`.
pub fn body(g: &Graph, names: &Names, program: &Program) -> (TokenStream, Vec<TokenStream>) {
    let mut body = Body {
        g,
        names,
        program,
        lets: StableMap::default(),
        constants: StableMap::default(),
        taken: names.taken.clone(),
    };
    let loads: TokenStream = program.inputs.iter().map(|s| body.load(*s)).collect();
    let constants: Vec<Ident> = (0..program.constants.len()).map(|i| body.fresh(&format!("k{i}"))).collect();
    for (v, name) in program.constants.iter().zip(&constants) {
        body.constants.insert(*v, name.clone());
    }
    let constants = (!constants.is_empty()).then(|| quote!(let [#(#constants),*] = *constants;));
    let steps: TokenStream = program.steps.iter().enumerate().map(|(i, step)| body.step(i, step)).collect();
    let outputs = program.outputs.iter().map(|v| body.value(*v).0).collect();
    (quote!(#loads #constants #steps), outputs)
}

impl Body<'_> {
    fn load(&self, symbol: Symbol) -> TokenStream {
        let name = self.names.symbol(symbol);
        let at = Literal::usize_unsuffixed;
        match symbol {
            Symbol::Parameter(i) => {
                let field = &self.names.parameters[i].1;
                quote!(let #name = #field;)
            }
            Symbol::Coordinate(i) => {
                let i = at(i);
                quote!(let #name = q[#i];)
            }
            Symbol::Velocity(i) => {
                let i = at(i);
                quote!(let #name = qd[#i];)
            }
            Symbol::Momentum(i) => {
                let i = at(i);
                quote!(let #name = p[#i];)
            }
            Symbol::Given(i) => {
                let i = at(i);
                quote!(let #name = given[#i];)
            }
            _ => TokenStream::new(),
        }
    }

    fn step(&mut self, i: usize, step: &Step) -> TokenStream {
        match step {
            &Step::Let(id) => {
                let name = match self.names.bindings.get(&id) {
                    Some(name) => name.clone(),
                    None => self.fresh(&format!("w{i}")),
                };
                let expression = self.node(id).0;
                self.lets.insert(id, name.clone());
                quote!(let #name = #expression;)
            }
            Step::SinCos(pairs) => {
                let angles: Vec<TokenStream> =
                    pairs.iter().map(|pair| self.value(pair.angle).receiver()).collect();
                let names = pairs.iter().enumerate().map(|(k, pair)| self.circular(i + k, pair));
                let (s, c): (Vec<Ident>, Vec<Ident>) = names.unzip();
                match angles[..] {
                    [ref angle] => quote!(let (#(#s)*, #(#c)*) = #angle.sin_cos();),
                    _ => quote!(let ([#(#s),*], [#(#c),*]) = S::sin_cos_array([#(#angles),*]);),
                }
            }
        }
    }

    /// Names for a sine and a cosine.
    fn circular(&mut self, i: usize, &Circular { angle, sine, cosine }: &Circular) -> (Ident, Ident) {
        let suffix = match angle.node.map(|n| self.g.node(n)) {
            Some(Node::Symbol(s)) if angle.k.is_one() => self.names.symbol(*s).to_string(),
            _ => i.to_string(),
        };
        let (s, c) = (self.fresh(&format!("sin_{suffix}")), self.fresh(&format!("cos_{suffix}")));
        self.lets.insert(sine, s.clone());
        self.lets.insert(cosine, c.clone());
        (s, c)
    }

    fn fresh(&mut self, wanted: &str) -> Ident {
        unique(&mut self.taken, wanted)
    }

    /// The expression of a node.
    fn node(&self, id: Id) -> Written {
        match self.g.node(id) {
            Node::Symbol(s) => {
                let name = self.names.symbol(*s);
                Written::atom(quote!(#name))
            }
            Node::Sum(a, b) => self.sum(*a, *b),
            Node::Product(a, b) => match (self.inverse(*a), self.inverse(*b)) {
                (_, Some(under)) => self.quotient((*a).into(), under),
                (Some(under), None) => self.quotient((*b).into(), under),
                (None, None) => {
                    let (a, b) = (self.value((*a).into()).factor(), self.value((*b).into()).receiver());
                    Written(quote!(#a * #b), Binding::Product)
                }
            },
            Node::Inverse(a) => self.quotient(Value::ONE, *a),
            Node::Call(f, a, b) => {
                let name = Ident::new(f.row().name, Span::call_site());
                let a = self.value(*a).receiver();
                let b = (f.row().arguments.len() == 2).then(|| self.value(*b).0);
                Written::atom(quote!(#a.#name(#b)))
            }
            Node::Extern(f, orders, arguments) => Written::atom(self.external(*f, orders, arguments)),
            Node::Select(comparison, values) => {
                let runtime = &self.names.runtime;
                let comparison = match comparison {
                    Comparison::Less => quote!(Less),
                    Comparison::LessEqual => quote!(LessEqual),
                    Comparison::Equal => quote!(Equal),
                };
                let values = values.iter().map(|v| self.value(*v).0);
                Written::atom(quote!(S::select(#runtime::Comparison::#comparison, #(#values),*)))
            }
        }
    }

    fn quotient(&self, over: Value, under: Id) -> Written {
        let (over, under) = (self.value(over).factor(), self.value(under.into()).receiver());
        Written(quote!(#over / #under), Binding::Product)
    }

    /// What an inverse written inside its user inverts.
    fn inverse(&self, id: Id) -> Option<Id> {
        match self.g.node(id) {
            Node::Inverse(under) if self.program.is_inline(id) => Some(*under),
            _ => None,
        }
    }

    /// `a + b`, as one fused operation where one of them is a product that is needed nowhere else.
    fn sum(&self, a: Value, b: Value) -> Written {
        for (product, rest) in [(b, a), (a, b)] {
            if let Some((x, y)) = self.fusible(product) {
                let rest = self.value(rest).0;
                return Written::atom(quote!(#x.mul_add(#y, #rest)));
            }
        }
        let (a, b) = if a.k.is_negative() && !b.k.is_negative() { (b, a) } else { (a, b) };
        let left = self.value(a).0;
        if b.k.is_negative() {
            let right = self.value(-b).factor();
            Written(quote!(#left - #right), Binding::Sum)
        } else {
            let right = self.value(b).factor();
            Written(quote!(#left + #right), Binding::Sum)
        }
    }

    /// The factors of a product that can be fused with an addition.
    fn fusible(&self, v: Value) -> Option<(TokenStream, TokenStream)> {
        let id = v.node.filter(|_| self.constant(v).is_none())?;
        if !v.k.is_unit() {
            let one = Value { k: Number::ONE, ..v };
            return Some((self.value(one).receiver(), constant(v.k)));
        }
        match *self.g.node(id) {
            Node::Product(x, y)
                if self.program.is_inline(id) && self.inverse(x).is_none() && self.inverse(y).is_none() =>
            {
                Some((self.value(Value { k: v.k, node: Some(x) }).receiver(), self.value(y.into()).0))
            }
            _ => None,
        }
    }

    /// The name of a constant of the program, whatever its sign.
    fn constant(&self, v: Value) -> Option<&Ident> {
        self.constants.get(&Value { k: v.k.abs(), ..v })
    }

    /// A value as it stands.
    pub fn value(&self, v: Value) -> Written {
        let Some(id) = v.node else { return Written::atom(constant(v.k)) };
        if let Some(name) = self.constant(v) {
            return if v.k.is_negative() {
                Written(quote!(-#name), Binding::Minus)
            } else {
                Written::atom(quote!(#name))
            };
        }
        // −(a − b) is b − a: rustc may not say so, for the sake of the sign of zero.
        if let (Node::Sum(a, b), true) =
            (self.g.node(id), self.program.is_inline(id) && v.k == Number::MINUS_ONE)
        {
            return self.sum(-*a, -*b);
        }
        let node = match self.lets.get(&id) {
            Some(name) => Written::atom(quote!(#name)),
            None => self.node(id),
        };
        if v.k.is_one() {
            node
        } else if v.k.is_unit() {
            let node = node.receiver();
            Written(quote!(-#node), Binding::Minus)
        } else {
            let (k, node) = (constant(v.k), node.receiver());
            Written(quote!(#k * #node), Binding::Product)
        }
    }

    /// A call of the user's function; its derivatives by nested dual numbers.
    fn external(&self, f: usize, orders: &[u8], arguments: &[Value]) -> TokenStream {
        let (runtime, name) = (&self.names.runtime, &self.names.externals[f].name);
        let levels: Vec<usize> =
            orders.iter().enumerate().flat_map(|(i, o)| std::iter::repeat_n(i, usize::from(*o))).collect();
        let arguments = arguments.iter().enumerate().map(|(i, argument)| {
            levels.iter().fold(self.value(*argument).0, |inner, level| {
                if *level == i {
                    quote!(#runtime::Dual::variable(#inner))
                } else {
                    quote!(#runtime::Dual::constant(#inner))
                }
            })
        });
        let slopes = levels.iter().map(|_| quote!(.slope));
        quote!(#name(#(#arguments),*) #(#slopes)*)
    }
}

/// A constant of the scalar's type.
pub fn constant(k: Number) -> TokenStream {
    match k.to_f64() {
        1.0 => quote!(S::one()),
        0.0 => quote!(S::zero()),
        // Constants may overflow where they are multiplied.
        x if !x.is_finite() => {
            let infinite = if x.is_nan() { quote!(f64::NAN) } else { quote!(f64::INFINITY) };
            let sign = (x < 0.0).then(|| quote!(-));
            quote!(S::from_f64(#sign ::core::#infinite))
        }
        x => {
            let (sign, size) = ((x < 0.0).then(|| quote!(-)), Literal::f64_unsuffixed(x.abs()));
            quote!(S::from_f64(#sign #size))
        }
    }
}
