//! A program as Rust over `S: Scalar`.

use crate::graph::{Comparison, Graph, Id, Node, Number, Symbol, Value, stable_map::StableMap};
use crate::model::{External, Model};
use crate::schedule::{Program, Step};
use proc_macro2::{Ident, Span, TokenStream};
use quote::{format_ident, quote};
use std::collections::BTreeSet;

/// Names of symbols and of the user's bindings in emitted functions.
pub struct Names {
    runtime: TokenStream,
    parameters: Vec<(Ident, TokenStream)>,
    coordinates: Vec<Ident>,
    velocities: Vec<Ident>,
    momenta: Vec<Ident>,
    externals: Vec<External>,
    /// What the user called the value of a node.
    bindings: StableMap<Id, Ident>,
    taken: BTreeSet<String>,
}

impl Names {
    /// `bindings` are nodes with the names of the user's bindings.
    pub fn new(model: &Model, bindings: &[(String, Value)]) -> Names {
        let reserved = ["q", "qd", "p", "t", "self", "S", "Self"];
        let mut taken: BTreeSet<String> = reserved.into_iter().map(String::from).collect();
        let mut parameters = Vec::new();
        for parameter in &model.parameters {
            let field = &parameter.name;
            for i in 0..parameter.length.unwrap_or(1) {
                parameters.push(match parameter.length {
                    None => (unique(&mut taken, &field.to_string()), quote!(self.#field)),
                    Some(_) => (unique(&mut taken, &format!("{field}_{i}")), quote!(self.#field[#i])),
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
        let mut named: StableMap<Id, Ident> = StableMap::default();
        for (name, value) in bindings {
            if let Some(node) = value.node.filter(|n| named.get(n).is_none() && value.k.is_one()) {
                let text: String = name.replace('[', "_").replace(']', "");
                named.insert(node, unique(&mut taken, &text));
            }
        }
        let runtime = model.runtime.clone();
        let externals = model.externals.clone();
        Names { runtime, parameters, coordinates, velocities, momenta, externals, bindings: named, taken }
    }

    fn symbol(&self, symbol: Symbol) -> Ident {
        match symbol {
            Symbol::Time => format_ident!("t"),
            Symbol::Parameter(i) => self.parameters[i].0.clone(),
            Symbol::Coordinate(i) => self.coordinates[i].clone(),
            Symbol::Velocity(i) => self.velocities[i].clone(),
            Symbol::Momentum(i) => self.momenta[i].clone(),
            Symbol::Acceleration(_) | Symbol::Binding(_) | Symbol::Rate(_) => {
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

/// The statements of a program; `outputs` afterwards gives its results.
pub struct Body<'a> {
    g: &'a Graph,
    names: &'a Names,
    program: &'a Program,
    lets: StableMap<Id, Ident>,
    taken: BTreeSet<String>,
}

/// Statements and output expressions.
pub fn body(g: &Graph, names: &Names, program: &Program) -> (TokenStream, Vec<TokenStream>) {
    let mut body = Body { g, names, program, lets: StableMap::default(), taken: names.taken.clone() };
    let loads: TokenStream = program.inputs.iter().map(|s| body.load(*s)).collect();
    let steps: TokenStream = program.steps.iter().enumerate().map(|(i, step)| body.step(i, step)).collect();
    let outputs = program.outputs.iter().map(|v| body.value(*v)).collect();
    (quote!(#loads #steps), outputs)
}

impl Body<'_> {
    fn load(&self, symbol: Symbol) -> TokenStream {
        let name = self.names.symbol(symbol);
        match symbol {
            Symbol::Parameter(i) => {
                let field = &self.names.parameters[i].1;
                quote!(let #name = #field;)
            }
            Symbol::Coordinate(i) => quote!(let #name = q[#i];),
            Symbol::Velocity(i) => quote!(let #name = qd[#i];),
            Symbol::Momentum(i) => quote!(let #name = p[#i];),
            _ => TokenStream::new(),
        }
    }

    fn step(&mut self, i: usize, step: &Step) -> TokenStream {
        match *step {
            Step::Let(id) => {
                let name = match self.names.bindings.get(&id) {
                    Some(name) => name.clone(),
                    None => self.fresh(&format!("w{i}")),
                };
                let expression = self.node(id);
                self.lets.insert(id, name.clone());
                quote!(let #name = #expression;)
            }
            Step::SinCos { angle, sine, cosine } => {
                let suffix = match angle.node.map(|n| self.g.node(n)) {
                    Some(Node::Symbol(s)) if angle.k.is_one() => self.names.symbol(*s).to_string(),
                    _ => i.to_string(),
                };
                let (s, c) = (self.fresh(&format!("sin_{suffix}")), self.fresh(&format!("cos_{suffix}")));
                let angle = self.operand(angle);
                self.lets.insert(sine, s.clone());
                self.lets.insert(cosine, c.clone());
                quote!(let (#s, #c) = #angle.sin_cos();)
            }
        }
    }

    fn fresh(&mut self, wanted: &str) -> Ident {
        unique(&mut self.taken, wanted)
    }

    /// The expression of a node.
    fn node(&self, id: Id) -> TokenStream {
        match self.g.node(id) {
            Node::Symbol(s) => {
                let name = self.names.symbol(*s);
                quote!(#name)
            }
            Node::Sum(a, b) => self.sum(*a, *b),
            Node::Product(a, b) => match (self.inverse(*a), self.inverse(*b)) {
                (_, Some(under)) => {
                    let (over, under) = (self.operand((*a).into()), self.operand(under.into()));
                    quote!(#over / #under)
                }
                (Some(under), None) => {
                    let (over, under) = (self.operand((*b).into()), self.operand(under.into()));
                    quote!(#over / #under)
                }
                (None, None) => {
                    let (a, b) = (self.operand((*a).into()), self.operand((*b).into()));
                    quote!(#a * #b)
                }
            },
            Node::Inverse(a) => {
                let a = self.operand((*a).into());
                quote!(S::one() / #a)
            }
            Node::Call(f, a, b) => {
                let name = Ident::new(f.row().name, Span::call_site());
                let a = self.operand(*a);
                if f.row().arguments.len() == 2 {
                    let b = self.value(*b);
                    quote!(#a.#name(#b))
                } else {
                    quote!(#a.#name())
                }
            }
            Node::Extern(f, orders, arguments) => self.external(*f, orders, arguments),
            Node::Select(comparison, values) => {
                let runtime = &self.names.runtime;
                let comparison = match comparison {
                    Comparison::Less => quote!(Less),
                    Comparison::LessEqual => quote!(LessEqual),
                    Comparison::Equal => quote!(Equal),
                };
                let values = values.iter().map(|v| self.value(*v));
                quote!(S::select(#runtime::Comparison::#comparison, #(#values),*))
            }
        }
    }

    /// What an inverse written inside its user inverts.
    fn inverse(&self, id: Id) -> Option<Id> {
        match self.g.node(id) {
            Node::Inverse(under) if self.program.is_inline(id) => Some(*under),
            _ => None,
        }
    }

    /// `a + b`, as one fused operation where one of them is a product that is needed nowhere else.
    fn sum(&self, a: Value, b: Value) -> TokenStream {
        for (product, rest) in [(b, a), (a, b)] {
            if let Some((x, y)) = self.fusible(product) {
                let rest = self.value(rest);
                return quote!(#x.mul_add(#y, #rest));
            }
        }
        let left = self.term(a);
        if b.k.is_negative() {
            let right = self.term(-b);
            quote!(#left - #right)
        } else {
            let right = self.term(b);
            quote!(#left + #right)
        }
    }

    /// The factors of a product that can be fused with an addition.
    fn fusible(&self, v: Value) -> Option<(TokenStream, TokenStream)> {
        let id = v.node?;
        if !v.k.is_unit() {
            let one = Value { k: Number::ONE, ..v };
            return Some((self.operand(one), constant(v.k)));
        }
        match *self.g.node(id) {
            Node::Product(x, y)
                if self.program.is_inline(id) && self.inverse(x).is_none() && self.inverse(y).is_none() =>
            {
                Some((self.operand(Value { k: v.k, node: Some(x) }), self.value(y.into())))
            }
            _ => None,
        }
    }

    /// A value as a term of a sum.
    fn term(&self, v: Value) -> TokenStream {
        match v.node {
            Some(id) if v.k.is_one() && matches!(self.g.node(id), Node::Product(..) | Node::Call(..)) => {
                self.atom(id)
            }
            _ => self.operand(v),
        }
    }

    /// A value as it stands.
    pub fn value(&self, v: Value) -> TokenStream {
        match v.node {
            Some(id) if v.k.is_one() => self.atom(id),
            _ => self.signed(v),
        }
    }

    /// A value as a factor or receiver: in parentheses if it is more than a name.
    fn operand(&self, v: Value) -> TokenStream {
        let named = v.node.is_some_and(|id| !self.program.is_inline(id));
        match v.node {
            Some(id) if v.k.is_one() && named => self.atom(id),
            None if !v.k.is_negative() => constant(v.k),
            _ => {
                let tokens = self.value(v);
                quote!((#tokens))
            }
        }
    }

    fn signed(&self, v: Value) -> TokenStream {
        let Some(id) = v.node else { return constant(v.k) };
        let inner = self.operand(id.into());
        if v.k.is_unit() {
            return quote!(-#inner);
        }
        let k = constant(v.k);
        quote!(#k * #inner)
    }

    /// The name of a node, or its expression if it is inline.
    fn atom(&self, id: Id) -> TokenStream {
        match (self.lets.get(&id), self.g.node(id)) {
            (Some(name), _) => quote!(#name),
            (None, Node::Symbol(s)) => {
                let name = self.names.symbol(*s);
                quote!(#name)
            }
            (None, _) => self.node(id),
        }
    }

    /// A call of the user's function; its derivatives by nested dual numbers.
    fn external(&self, f: usize, orders: &[u8], arguments: &[Value]) -> TokenStream {
        let (runtime, name) = (&self.names.runtime, &self.names.externals[f].name);
        let levels: Vec<usize> =
            orders.iter().enumerate().flat_map(|(i, o)| std::iter::repeat_n(i, usize::from(*o))).collect();
        let arguments = arguments.iter().enumerate().map(|(i, argument)| {
            levels.iter().fold(self.value(*argument), |inner, level| {
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
fn constant(k: Number) -> TokenStream {
    match k.to_f64() {
        1.0 => quote!(S::one()),
        0.0 => quote!(S::zero()),
        x if x < 0.0 => {
            let x = -x;
            quote!(S::from_f64(-#x))
        }
        x => quote!(S::from_f64(#x)),
    }
}
