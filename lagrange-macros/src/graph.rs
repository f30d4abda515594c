//! The expression graph: an append-only list of hash-consed nodes, operands before users.
//!
//! An expression is a [`Value`]: an exact coefficient times a node, so that signs and rational factors never cost a
//! node. Sums and products are binary, in the association in which they were first built: flattening them would lose
//! the partial sums that a chain of bodies shares (docs/decisions/0002). What canonical n-ary forms give is had by
//! the constructors in `graph/build.rs`.

pub mod build;
pub mod differentiate;
pub mod evaluate;
pub mod factor;
pub mod fourier;
pub mod function;
pub mod gather;
mod kinks;
mod literal;
pub mod modular;
pub mod normal;
pub mod number;
#[cfg(test)]
mod properties;
pub mod roots;
pub mod stable_map;
pub mod substitute;
pub mod trigonometry;

pub use function::Function;
pub use number::Number;
pub use stable_map::Id;
use stable_map::{IdMap, StableMap};
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;

/// A coefficient times a node; without a node, the coefficient itself.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Value {
    pub k: Number,
    pub node: Option<Id>,
}

/// A variable that an expression can depend on.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Symbol {
    /// Time t.
    Time,
    /// Generalized coordinate qᵢ.
    Coordinate(usize),
    /// Generalized velocity q̇ᵢ.
    Velocity(usize),
    /// Generalized acceleration q̈ᵢ, while a Jacobian is being derived.
    Acceleration(usize),
    /// Generalized momentum pᵢ, as the argument of the inverse Legendre transformation.
    Momentum(usize),
    /// Multiplier λⱼ of a constraint, until the equations are solved.
    Multiplier(usize),
    /// Reaction at a prescribed coordinate, until the equations are solved.
    Reaction(usize),
    /// A component of the last argument of an emitted function.
    Given(usize),
    /// Momentum of an ignorable coordinate: a number for as long as a Taylor series holds.
    Conserved(usize),
    /// d = c + ½ and v of half the quaternions of the attitudes, four of each, which have series of their own.
    Quaternion(usize),
    /// A number of the parameters, arrays counted one by one.
    Parameter(usize),
    /// The side of a switch on which the motion is, ±1: a number for as long as a Taylor series holds.
    Side(usize),
    /// A binding u = φ(q, t) of the user (`let`, or a prescribed coordinate), kept opaque.
    Binding(usize),
    /// Its rate u̇.
    Rate(usize),
    /// An input of the recurrences of a Taylor series.
    Order(Coefficient),
}

/// Inputs of the coefficients of order k of a Taylor series, beside those of order 0.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Coefficient {
    /// The order k.
    Level,
    /// Its reciprocal 1/k.
    Over,
    /// Coefficient k of t.
    Clock,
    /// Coefficient k of a coordinate.
    Coordinate(usize),
    /// k times the coefficient k of a coordinate, which is the coefficient k − 1 of its velocity.
    Rate(usize),
    /// Coefficient k of a velocity.
    Velocity(usize),
    /// Coefficient 1 of a factor of convolutions.
    First(usize),
    /// Coefficient k − 1 of a factor of convolutions.
    Last(usize),
    /// `Σ_{1<j<k−1} a_j b_{k−j}` of a convolution.
    Inner(usize),
    /// Coefficient k − 1 of a series that is kept for one order.
    Before(usize),
}

/// The condition of a [`Node::Select`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Comparison {
    Less,
    LessEqual,
    Equal,
}

#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Node {
    Symbol(Symbol),
    /// Two terms; the second may be a constant.
    Sum(Value, Value),
    Product(Id, Id),
    Inverse(Id),
    /// An elementary function; the second argument is 0 for functions of one.
    Call(Function, Value, Value),
    /// A function of the user's, differentiated `orders[i]` times by its argument i.
    Extern(usize, Box<[u8]>, Box<[Value]>),
    /// `if a ∘ b { yes } else { no }` of `[a, b, yes, no]`.
    Select(Comparison, Box<[Value; 4]>),
}

/// For how long a node is a number.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Constancy {
    /// It moves with the state.
    Moving,
    /// Inputs, which change between steps, are below it, and nothing that moves.
    Held,
    /// Parameters and sides alone are below it.
    Fixed,
}

/// Factors with their exponents, sorted by id.
type Monomial = Rc<[(Id, i32)]>;

#[derive(Clone, Default)]
pub struct Graph {
    nodes: Vec<Node>,
    index: StableMap<Node, Id>,
    /// The multiplied-out forms of products and inverses.
    monomials: Vec<Option<Monomial>>,
    products: StableMap<Monomial, Id>,
    /// The common factor of all terms of a node, where it has been computed.
    contents: IdMap<Monomial>,
    /// Dependence of each node, besides constants.
    fixed: Vec<Constancy>,
    /// The numbers of the parameters that are inputs.
    pub inputs: Range<usize>,
    /// The walk in which each node was seen last.
    walks: RefCell<(u32, Vec<u32>)>,
    /// Parsed derivatives of the function table.
    derivatives: StableMap<(Function, usize), Rc<syn::Expr>>,
}

impl Value {
    pub const ZERO: Value = Value { k: Number::ZERO, node: None };
    pub const ONE: Value = Value { k: Number::ONE, node: None };

    pub fn constant(k: impl Into<Number>) -> Value {
        Value { k: k.into(), node: None }
    }

    pub fn is_zero(self) -> bool {
        self.k.is_zero()
    }

    pub fn is_constant(self) -> bool {
        self.node.is_none()
    }

    pub fn scaled(self, k: Number) -> Value {
        let k = self.k.mul(k);
        if k.is_zero() { Value::ZERO } else { Value { k, node: self.node } }
    }
}

impl std::ops::Neg for Value {
    type Output = Value;
    fn neg(self) -> Value {
        Value { k: self.k.neg(), node: self.node }
    }
}

impl From<Id> for Value {
    fn from(id: Id) -> Value {
        Value { k: Number::ONE, node: Some(id) }
    }
}

impl Id {
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl Graph {
    pub fn node(&self, id: Id) -> &Node {
        // Without optimisation a look into a vector takes two calls, one into a slice none.
        &self.nodes.as_slice()[id.0 as usize]
    }

    /// Does the node depend on parameters, inputs and constants alone?
    pub fn is_fixed(&self, id: Id) -> bool {
        self.fixed.as_slice()[id.0 as usize] != Constancy::Moving
    }

    /// Number of nodes ever made: the measure of the expansion budget.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }

    /// The node, made if it is new.
    fn intern(&mut self, node: Node) -> Id {
        let id = Id(u32::try_from(self.nodes.len()).expect("the node budget is far below 2^32"));
        let known = *self.index.get_or_insert(node.clone(), id);
        if known != id {
            return known;
        }
        self.monomials.push(None);
        let mut fixed = match node {
            Node::Symbol(Symbol::Parameter(i)) if self.inputs.contains(&i) => Constancy::Held,
            Node::Symbol(Symbol::Parameter(_) | Symbol::Side(_) | Symbol::Conserved(_)) => Constancy::Fixed,
            Node::Symbol(_) => Constancy::Moving,
            _ => Constancy::Fixed,
        };
        self.nodes.push(node);
        self.operands(id, |v| {
            if let Some(n) = v.node {
                fixed = fixed.min(self.fixed[n.index()]);
            }
        });
        self.fixed.push(fixed);
        id
    }

    pub fn symbol(&mut self, symbol: Symbol) -> Value {
        self.intern(Node::Symbol(symbol)).into()
    }

    /// The symbol that an expression is; none of any other expression.
    pub fn alone(&self, v: Value) -> Option<Symbol> {
        match self.node(v.node.filter(|_| v.k == Number::ONE)?) {
            Node::Symbol(symbol) => Some(*symbol),
            _ => None,
        }
    }

    /// Calls `visit` with each operand of a node that is not a constant.
    pub fn operands(&self, id: Id, mut visit: impl FnMut(Value)) {
        // Without optimisation an iterator over two operands takes several times as long as the two, and so do calls
        // of closures.
        match self.node(id) {
            Node::Symbol(_) => {}
            Node::Sum(a, b) | Node::Call(_, a, b) => {
                if a.node.is_some() {
                    visit(*a);
                }
                if b.node.is_some() {
                    visit(*b);
                }
            }
            Node::Product(a, b) => {
                visit(Value { k: Number::ONE, node: Some(*a) });
                visit(Value { k: Number::ONE, node: Some(*b) });
            }
            Node::Inverse(a) => visit((*a).into()),
            Node::Extern(_, _, arguments) => {
                arguments.iter().copied().filter(|v| !v.is_constant()).for_each(visit);
            }
            Node::Select(_, values) => values.iter().copied().filter(|v| !v.is_constant()).for_each(visit),
        }
    }

    /// The different terms of a sum, in the order in which they stand, however they are grouped.
    pub fn terms(&self, v: Value) -> Vec<Value> {
        let (mut terms, mut places): (Vec<Value>, IdMap<usize>) = (Vec::new(), IdMap::default());
        let mut left = vec![v];
        while let Some(v) = left.pop() {
            let Some(id) = v.node else {
                terms.push(v);
                continue;
            };
            match (self.node(id), places.get(&id)) {
                (Node::Sum(a, b), _) => left.extend([b.scaled(v.k), a.scaled(v.k)]),
                (_, Some(&place)) => terms[place].k = terms[place].k.add(v.k),
                _ => {
                    places.insert(id, terms.len());
                    terms.push(v);
                }
            }
        }
        terms.retain(|term| !term.is_zero());
        terms
    }

    /// Is it a number that parameters alone decide, and no input, at some cost?
    pub fn is_derived(&self, v: Value) -> bool {
        v.node.is_some_and(|id| {
            self.fixed.as_slice()[id.index()] == Constancy::Fixed
                && !(v.k.is_unit() && matches!(self.node(id), Node::Symbol(_)))
        })
    }

    /// All nodes below the roots, in ascending order, that is operands first.
    pub fn live(&self, roots: &[Value]) -> Vec<Id> {
        self.live_without(roots, |_| false)
    }

    /// The same without what is below certain values.
    pub fn live_without(&self, roots: &[Value], known: impl Fn(Value) -> bool) -> Vec<Id> {
        let (walk, seen) = &mut *self.walks.borrow_mut();
        *walk += 1;
        seen.resize(self.nodes.len(), 0);
        let (walk, seen) = (*walk, seen.as_mut_slice());
        let mut live: Vec<Id> = Vec::new();
        let (mut first, mut last) = (u32::MAX, 0);
        let mut meet = |live: &mut Vec<Id>, v: Value| {
            if let Some(id) = v.node
                && seen[id.0 as usize] != walk
                && !known(v)
            {
                seen[id.0 as usize] = walk;
                if id.0 < first {
                    first = id.0;
                }
                if id.0 > last {
                    last = id.0;
                }
                live.push(id);
            }
        };
        for v in roots {
            meet(&mut live, *v);
        }
        // The list is its own queue.
        let mut at = 0;
        while at < live.len() {
            let id = live[at];
            at += 1;
            self.operands(id, |v| meet(&mut live, v));
        }
        // Without optimisation, sorting costs some hundred times what a look at a node does.
        if (last as usize).saturating_sub(first as usize) < 64 * live.len() {
            live.clear();
            let mut id = first;
            while id <= last {
                if seen[id as usize] == walk {
                    live.push(Id(id));
                }
                id += 1;
            }
        } else {
            live.sort_unstable();
        }
        live
    }

    /// The nodes below the roots that depend on symbols of this kind.
    pub fn dependent(&self, roots: &[Value], wanted: impl Fn(Symbol) -> bool) -> IdMap<()> {
        let mut dependent: IdMap<()> = IdMap::default();
        for id in self.live(roots) {
            let mut depends = matches!(self.node(id), Node::Symbol(s) if wanted(*s));
            self.operands(id, |v| depends |= v.node.is_some_and(|n| dependent.get(&n).is_some()));
            if depends {
                dependent.insert(id, ());
            }
        }
        dependent
    }

    /// Does any of the roots depend on a symbol of this kind?
    pub fn depends(&self, roots: &[Value], wanted: impl Fn(Symbol) -> bool) -> bool {
        self.live(roots).into_iter().any(|id| matches!(self.node(id), Node::Symbol(s) if wanted(*s)))
    }

    /// An upper bound of the degree of `v` as a polynomial in the symbols of this kind, read off the graph; `None`
    /// where `v` is not written as such a polynomial.
    pub fn degree(&self, v: Value, variable: impl Fn(Symbol) -> bool) -> Option<u32> {
        fn known(degrees: &IdMap<u32>, v: Value) -> Option<u32> {
            v.node.map_or(Some(0), |id| degrees.get(&id).copied())
        }
        let mut degrees = IdMap::default();
        for id in self.live(&[v]) {
            let of = |v: Value| known(&degrees, v);
            let degree = match self.node(id) {
                Node::Symbol(s) => Some(u32::from(variable(*s))),
                &Node::Sum(a, b) => of(a).zip(of(b)).map(|(a, b)| a.max(b)),
                &Node::Product(a, b) => of(a.into()).zip(of(b.into())).and_then(|(a, b)| a.checked_add(b)),
                Node::Select(_, parts) if parts[..2].iter().all(|side| of(*side) == Some(0)) => {
                    of(parts[2]).zip(of(parts[3])).map(|(yes, no)| yes.max(no))
                }
                // Functions of constants are constants, and others no polynomials.
                _ => {
                    let mut fixed = true;
                    self.operands(id, |v| fixed &= of(v) == Some(0));
                    fixed.then_some(0)
                }
            };
            if let Some(degree) = degree {
                degrees.insert(id, degree);
            }
        }
        known(&degrees, v)
    }

    /// The symbols below the roots.
    pub fn symbols(&self, roots: &[Value]) -> Vec<Symbol> {
        let symbol = |id| match self.node(id) {
            Node::Symbol(s) => Some(*s),
            _ => None,
        };
        self.live(roots).into_iter().filter_map(symbol).collect()
    }
}
