//! The Taylor series of a motion, order by order, from the same graph that `accel` comes from.
//!
//! With x_k the k-th Taylor coefficient of x(t), each node of the graph gives its k-th coefficient from those of its
//! operands up to k (Moore 1966; Jorba and Zou 2005; Griewank and Walther 2008, ch. 13):
//!
//! ```text
//! (a b)_k = Σ a_j b_{k−j}                  (a/b)_k = (a_k − Σ_{j≥1} b_j (a/b)_{k−j}) / b_0
//! f(a)_k  = (1/k) Σ j a_j f'(a)_{k−j}      (a^r)_k = Σ_{j≥1} (r j − (k − j)) a_j (a^r)_{k−j} / (k a_0)
//! (√a)_k  = (a_k − Σ_{0<j<k} (√a)_j (√a)_{k−j}) / (2 (√a)_0)
//! ```
//!
//! The rule for functions needs the series of the derivative one order behind, so the formulas of the function table
//! serve for all of them, and sine and cosine are each other's. What depends on parameters alone is a number, and is not
//! convolved.
//!
//! The motion comes from whichever has the least work: the expressions of the accelerations; M q̈ = right as a series,
//! M_0 a_k = right_k − Σ_{j≥1} M_j a_{k−j}; or ṗ = f with p = ∂L/∂q̇(q, q̇, t) and f = ∂L/∂q − ∂D/∂q̇ + Q, which are as long as
//! what was written: k p_k = f_{k−1}, and p_k is what it is without q̇_k, and M_0 q̇_k more. Both are solved as it is done for the
//! accelerations, with what cancels in the pivots of M_0 cancelled by symbols: by numbers a body near a pole of its angles, at an
//! inclination of θ, has coefficients that are wrong by ε/θ².
//!
//! Or it comes from the equations where they were written ([`Balance`]), with the accelerations of the bindings and the forces that
//! hold them among the unknowns: `series/balance.rs`. Of chains and trees that has the fewest products.
//!
//! Or velocities of ignorable coordinates come from their momenta, and only the others have accelerations (`series/conserved.rs`).
//!
//! Products are all that counts here, and what is added is cheap: so all but the equations at the bindings are also tried with as few products
//! as common factors and common parts leave of them (`graph/gather.rs`). The accelerations of the symmetric top by Euler's angles have 14, and 10
//! so; by its momenta it needs 7.

mod balance;
mod conserved;
mod substitution;
pub mod switches;

pub use balance::{Balance, Right, term_pair};
pub use conserved::Ignorable;
pub use substitution::{Base, Substitution};

use super::elimination::MAX_DENSE_COORDINATES;
use super::formed::Formed;
use super::outputs::Quantities;
use super::solve::{Symmetric, entry};
use super::solved::Solved;
use super::structure::Facts;
use super::{MAX_EXPANDED_COORDINATES, check, symbols};
use crate::graph::{
    Comparison, Function, Graph, Id, Node, Number, Symbol, Value,
    stable_map::{IdMap, StableMap},
};
use crate::model::Model;

/// Systems of more products of series have none emitted: it would cost more to compile than it saves.
const LONGEST: usize = 20_000;

/// How the coefficients of a node follow from those of others.
pub enum Rule {
    /// A sum of series and numbers, each with a factor that is a number.
    Linear(Vec<(Value, Value)>),
    Product(Id, Id),
    Square(Id),
    Quotient(Value, Id),
    Root(Value),
    /// A power with a number for its exponent.
    Power(Id, Value),
    /// A function by its arguments that move, and its partial derivatives.
    Function(Vec<Slope>),
    /// What numbers decide: `if a ∘ b { yes } else { no }`.
    Choice(Comparison, Box<[Value; 4]>),
}

/// ∂f/∂a times what a moves by.
pub enum Slope {
    /// The slope is a number.
    Number(Value, Value),
    /// A product of a velocity and the slope, which the equations have anyway: that of the order before, times a constant.
    Known(Number, Id),
    /// The rate of a node and the slope, times a constant.
    Rate(Number, Id, Id),
}

/// A series in a product.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Debug)]
pub enum Factor {
    Of(Id),
    /// Of `j x_j`.
    Rate(Id),
    /// Of an unknown of the system of equations.
    Unknown(usize),
}

/// What is known of each order in the end.
pub enum Outputs {
    Accelerations(Vec<Value>),
    /// The bordered matrix and its right-hand side.
    System {
        matrix: Symmetric,
        right: Vec<Value>,
    },
    /// p and f of ṗ = f.
    Momenta {
        momenta: Vec<Value>,
        force: Vec<Value>,
    },
    /// The equations at the bindings.
    Bindings(Balance),
    /// Velocities of ignorable coordinates, each made of those before it, and accelerations of the others.
    Conserved {
        velocities: Vec<Ignorable>,
        accelerations: Vec<(usize, Value)>,
    },
}

/// The recurrences of a system: nodes that move, operands first.
pub struct Series {
    pub rules: Vec<(Id, Rule)>,
    pub outputs: Outputs,
    /// Functions whose signs are the sides that the outputs name.
    pub switches: Vec<Value>,
    /// The unknowns of an order, accelerations or velocities first, for what is `Given`. Empty where nothing has to be solved.
    pub solution: Substitution,
    /// Momenta that are conserved are numbers that the first state gives: what is made of them, in its terms.
    started: IdMap<Value>,
    /// The different products of series, and squares.
    pub products: Vec<[Factor; 2]>,
    pub squares: Vec<Factor>,
    /// Where each of them is.
    places: StableMap<[Factor; 2], Place>,
}

/// The recurrences with the least work; none for systems with functions of the user's or powers whose exponents move.
pub fn series(
    g: &mut Graph,
    model: &Model,
    formed: &Formed,
    solved: &Solved,
    quantities: &Quantities,
    facts: &Facts,
) -> Option<Series> {
    let Solved { inertia, right, accel, .. } = solved;
    let mut outputs = Vec::new();
    let solution = solution(g, formed, solved);
    if solution.is_some() && accel.len() > 1 {
        let (matrix, right) = formed.rows.border(inertia, right);
        outputs.push(Outputs::System { matrix, right });
    }
    let free = solution.is_some() && formed.rows.is_empty();
    let solution = solution.unwrap_or_default();
    if !switches::sided(g, accel).1.is_empty() {
        return switching(g, accel, outputs, &solution);
    }
    if free {
        outputs.extend(momenta(g, formed));
    }
    outputs.extend(balance::balance(g, model, formed, solved).map(Outputs::Bindings));
    outputs.push(Outputs::Accelerations(accel.clone()));
    if accel.len() <= MAX_EXPANDED_COORDINATES {
        outputs.extend(conserved::outputs(g, formed, solved, quantities, facts));
    }
    if accel.len() <= MAX_EXPANDED_COORDINATES {
        let gathered: Vec<Outputs> = outputs.iter().filter_map(|outputs| outputs.gathered(g)).collect();
        outputs.extend(gathered);
    }
    let all = outputs
        .into_iter()
        .filter_map(|outputs| Some((with_switches(g, outputs, Vec::new())?, solution.clone())));
    let all: Vec<(Series, Vec<Value>)> = all.collect();
    let (mut best, solution) = cheapest(g, all)?;
    // No inverse of what may be nearly singular, nor of what constraints border.
    best.solution = match &best.outputs {
        Outputs::System { .. } | Outputs::Momenta { .. }
            if free && check::is_regular(g, inertia, &model.coordinates) =>
        {
            Substitution::explicit(g, &solution)
        }
        outputs => outputs.solved(g, &solution)?,
    };
    best.start(g, &quantities.momenta);
    Some(best)
}

/// The series with the least work, with what M is solved by on its sides, if its products are not too many.
fn cheapest(g: &Graph, all: Vec<(Series, Vec<Value>)>) -> Option<(Series, Vec<Value>)> {
    let best = all.into_iter().min_by_key(|(series, _)| (series.cost(g), series.rules.len()));
    best.filter(|(best, _)| best.products.len() <= LONGEST).map(|(best, solution)| (best.filled(), solution))
}

/// The same of a system with choices, by accelerations or the matrix.
fn switching(
    g: &mut Graph,
    accel: &[Value],
    mut outputs: Vec<Outputs>,
    solution: &[Value],
) -> Option<Series> {
    outputs.push(Outputs::Accelerations(accel.to_vec()));
    let mut all = Vec::new();
    for outputs in outputs {
        let written = outputs.values();
        let (mut values, switches) = switches::sided(g, &[&written[..], solution].concat());
        let solution = values.split_off(written.len());
        let series = outputs.made_of(values).and_then(|outputs| with_switches(g, outputs, switches));
        all.extend(series.map(|series| (series, solution)));
    }
    let (mut best, solution) = cheapest(g, all)?;
    best.solution = best.outputs.solved(g, &solution)?;
    Some(best)
}

/// What M x = given is solved by, M bordered, as it is for the accelerations; none of a matrix so large that it would be long.
fn solution(g: &mut Graph, formed: &Formed, solved: &Solved) -> Option<Vec<Value>> {
    let size = solved.accel.len() + formed.rows.len();
    if size > MAX_DENSE_COORDINATES {
        return None;
    }
    let given = symbols(g, Symbol::Given, size);
    let solution = solved.solver.solve(g, &[given])?.pop()?;
    Some(g.share_angles(&solution))
}

/// ṗ = f as it follows from what was written, and with angles' sines and cosines from each other's.
fn momenta(g: &mut Graph, formed: &Formed) -> [Outputs; 2] {
    let n = formed.momenta.len();
    let all: Vec<Symbol> = (0..n).map(Symbol::Velocity).chain((0..n).map(Symbol::Coordinate)).collect();
    let mut gradient = g.gradient(formed.lagrangian, &all);
    for (slope, rest) in gradient[n..].iter_mut().zip(&formed.nonconservative) {
        *slope = g.add(*slope, *rest);
    }
    let shared = g.share_angles(&gradient);
    [gradient, shared].map(|mut momenta| {
        let force = momenta.split_off(n);
        Outputs::Momenta { momenta, force }
    })
}

/// Does it depend on nothing but parameters?
pub fn is_number(g: &Graph, v: Value) -> bool {
    v.node.is_none_or(|id| g.is_fixed(id))
}

/// Operations of one order in a sum of products and its ends, at the order where most time goes.
const TYPICAL: usize = 12;

/// What momenta cost beside their operations: velocities wait for them, and they for velocities. Of the symmetric top they need
/// 11 products of series in place of 14, and a tenth more time.
const WAITING: usize = 64;

/// Products whose sums are formed together, as vectors, and so many systems have that few: from three on.
pub const SIDE: usize = 4;

/// Systems of at most this many products and squares of series have their orders written out one by one by the optimiser, which makes
/// of sums straight lines; others loop.
pub const STRAIGHT: usize = 32;

impl Series {
    /// Are its orders written out one by one?
    pub fn straight(&self) -> bool {
        self.products.len() + self.squares.len() <= STRAIGHT
    }

    /// Squares take half the operations of products, but no more time where a vector of products has room for all of them.
    fn filled(mut self) -> Self {
        let products = self.products.len();
        let room = products.next_multiple_of(SIDE) - products;
        if self.straight() && products > SIDE / 2 && self.squares.len() <= room {
            for factor in std::mem::take(&mut self.squares) {
                self.places.insert([factor; 2], Place::Product(self.products.len()));
                self.products.push([factor; 2]);
            }
        }
        self
    }

    /// Operations of an order, about.
    fn cost(&self, g: &Graph) -> usize {
        let convolved = TYPICAL * self.products.len() + TYPICAL / 2 * self.squares.len();
        let solved = match &self.outputs {
            Outputs::Accelerations(_) => 0,
            // An order more.
            Outputs::Conserved { .. } => self.products.len(),
            Outputs::System { right, .. } => right.len() * right.len(),
            // And what moves with the velocities is corrected, and once a step for each column of the matrix.
            Outputs::Momenta { momenta, .. } => {
                let n = momenta.len();
                WAITING + n * n + self.moved(g, Some(momenta)).len() * (TYPICAL + n) / TYPICAL
            }
            Outputs::Bindings(balance) => balance.cost(g),
        };
        convolved + solved
    }

    /// Says what is made of momenta that are conserved.
    fn start(&mut self, g: &mut Graph, momenta: &[Value]) {
        let Outputs::Conserved { .. } = &self.outputs else { return };
        let momentum = |s| if let Symbol::Conserved(i) = s { Some(momenta[i]) } else { None };
        let nodes = self.rules.iter().map(|(id, _)| (*id).into());
        let all: Vec<Value> = nodes.chain(self.numbers(g)).chain(self.outputs.values()).collect();
        let live = g.live(&all).into_iter().map(Value::from);
        let made: Vec<Value> = live.filter(|v| g.depends(&[*v], |s| momentum(s).is_some())).collect();
        let started = g.substitute(&made, momentum);
        made.iter()
            .zip(started)
            .for_each(|(v, started)| v.node.into_iter().for_each(|id| self.started.insert(id, started)));
    }

    /// What a value is in terms of the first state.
    pub fn started(&self, v: Value) -> Value {
        let known = v.node.and_then(|id| self.started.get(&id));
        known.map_or(v, |known| known.scaled(v.k))
    }

    /// Numbers of the rules that are not constants.
    pub fn numbers(&self, g: &Graph) -> Vec<Value> {
        let mut numbers: Vec<Value> = Vec::new();
        let mut note = |v: Value| {
            if !v.is_constant() && is_number(g, v) && !numbers.contains(&v) {
                numbers.push(v);
            }
        };
        for (_, rule) in &self.rules {
            match rule {
                Rule::Linear(terms) => terms.iter().for_each(|(factor, _)| note(*factor)),
                Rule::Power(_, r) => note(*r),
                Rule::Choice(_, values) => values[..2].iter().for_each(|v| note(*v)),
                Rule::Function(slopes) => {
                    for slope in slopes {
                        if let Slope::Number(slope, _) = slope {
                            note(*slope);
                        }
                    }
                }
                Rule::Product(..) | Rule::Square(_) | Rule::Quotient(..) | Rule::Root(_) => {}
            }
        }
        if let Outputs::Momenta { .. } | Outputs::Bindings(_) = &self.outputs {
            self.outputs.values().into_iter().for_each(note);
        }
        numbers
    }

    /// How many numbers the solution of an order is given.
    pub fn given(&self) -> usize {
        if let Outputs::Bindings(balance) = &self.outputs {
            balance.rights.len()
        } else {
            self.solution.unknowns.len()
        }
    }

    /// Are there states with finite accelerations at which it does not exist?
    pub fn has_roots(&self, g: &Graph) -> bool {
        g.has_roots(&self.outputs.values())
    }

    /// Rows of the nodes that move with the velocities; below `roots`, if these are given.
    pub fn moved(&self, g: &Graph, roots: Option<&[Value]>) -> Vec<usize> {
        let below = roots.map(|roots| g.live(roots));
        let mut moved: IdMap<()> = IdMap::default();
        let mut rows = Vec::new();
        for (row, (id, rule)) in self.rules.iter().enumerate() {
            let mut moves = false;
            rule.operands(|v| {
                moves |= v.node.is_some_and(|id| moved.get(&id).is_some() || is_velocity(g, id))
            });
            // Sines and cosines of coordinates do not, though their rates do.
            moves &= !matches!(rule, Rule::Function(slopes) if slopes.iter().all(|s| !s.moves(g, &moved)));
            if moves && below.as_ref().is_none_or(|below| below.binary_search(id).is_ok()) {
                moved.insert(*id, ());
                rows.push(row);
            }
        }
        rows
    }
}

fn is_velocity(g: &Graph, id: Id) -> bool {
    matches!(symbol(g, id), Some(Symbol::Velocity(_)))
}

impl Slope {
    /// Does the last coefficient of a velocity enter?
    fn moves(&self, g: &Graph, moved: &IdMap<()>) -> bool {
        let moves = |id: Id| is_velocity(g, id) || moved.get(&id).is_some();
        match self {
            Slope::Number(_, x) => x.node.is_some_and(moves),
            Slope::Known(..) => false,
            Slope::Rate(_, a, _) => moves(*a),
        }
    }
}

impl Outputs {
    /// What solves the equations of an order, of which `solution` are those of M.
    fn solved(&self, g: &mut Graph, solution: &[Value]) -> Option<Substitution> {
        match self {
            Outputs::Accelerations(_) | Outputs::Conserved { .. } => Some(Substitution::default()),
            Outputs::Bindings(balance) => Substitution::new(g, &balance.solution),
            Outputs::System { .. } | Outputs::Momenta { .. } => Substitution::new(g, solution),
        }
    }

    pub fn values(&self) -> Vec<Value> {
        match self {
            Outputs::Accelerations(values) => values.clone(),
            Outputs::Momenta { momenta, force } => [&momenta[..], force].concat(),
            Outputs::System { matrix, right } => matrix.iter().flatten().chain(right).copied().collect(),
            Outputs::Bindings(balance) => balance.values(),
            Outputs::Conserved { velocities, accelerations } => {
                let velocities = velocities.iter().flat_map(|v| [v.over, v.under]);
                velocities.chain(accelerations.iter().map(|a| a.1)).collect()
            }
        }
    }

    /// The same made of other values, but for the equations at the bindings.
    fn made_of(&self, mut values: Vec<Value>) -> Option<Outputs> {
        Some(match self {
            Outputs::Accelerations(_) => Outputs::Accelerations(values),
            Outputs::Momenta { momenta, .. } => {
                let force = values.split_off(momenta.len());
                Outputs::Momenta { momenta: values, force }
            }
            Outputs::System { matrix, right } => {
                let right = values.split_off(values.len() - right.len());
                let mut matrix = matrix.clone();
                matrix.iter_mut().flatten().zip(values).for_each(|(own, new)| *own = new);
                Outputs::System { matrix, right }
            }
            Outputs::Bindings(_) => return None,
            Outputs::Conserved { velocities, accelerations } => {
                let mut values = values.into_iter();
                let mut next = || values.next().expect("each output has its value");
                let velocities =
                    velocities.iter().map(|v| Ignorable { over: next(), under: next(), ..v.clone() });
                let velocities = velocities.collect();
                let accelerations = accelerations.iter().map(|(i, _)| (*i, next())).collect();
                Outputs::Conserved { velocities, accelerations }
            }
        })
    }

    /// The same with fewer products of what moves.
    fn gathered(&self, g: &mut Graph) -> Option<Outputs> {
        if let Outputs::Bindings(_) = self {
            return None;
        }
        let values = g.gathered(&self.values());
        self.made_of(values)
    }
}

fn with_switches(g: &mut Graph, outputs: Outputs, switches: Vec<Value>) -> Option<Series> {
    let mut rules: IdMap<Rule> = IdMap::default();
    // Derivatives of functions are new roots, and are made of the function itself or of nodes that end soon.
    let mut stack: Vec<Id> = outputs.values().iter().chain(&switches).filter_map(|v| v.node).collect();
    while let Some(id) = stack.pop() {
        if g.is_fixed(id) || matches!(g.node(id), Node::Symbol(_)) || rules.get(&id).is_some() {
            continue;
        }
        let rule = rule(g, id)?;
        rule.operands(|v| stack.extend(v.node));
        rules.insert(id, rule);
    }
    let mut rules = rules.in_order();
    if let Outputs::Conserved { velocities, .. } = &outputs {
        rules = conserved::ordered(g, rules, velocities);
    }
    use_known_rates(g, &mut rules);

    let mut series = Series {
        rules,
        solution: Substitution::default(),
        started: IdMap::default(),
        outputs,
        switches,
        products: Vec::new(),
        squares: Vec::new(),
        places: StableMap::default(),
    };
    let all: Vec<[Factor; 2]> = series.rules.iter().flat_map(|(id, rule)| rule.convolutions(*id)).collect();
    all.into_iter().for_each(|pair| series.convolve(pair));
    if let Outputs::System { matrix, right } = &series.outputs {
        let n = right.len();
        let pairs: Vec<[Factor; 2]> =
            (0..n * n).filter_map(|at| tail(g, entry(matrix, at / n, at % n), at % n)).collect();
        pairs.into_iter().for_each(|pair| series.convolve(pair));
    }
    if let Outputs::Bindings(balance) = &series.outputs {
        let pairs = balance.convolutions(g);
        pairs.into_iter().for_each(|pair| series.convolve(pair));
    }
    Some(series)
}

/// The factors of M_ij a_j, unless M_ij is a number.
pub fn tail(g: &Graph, m: Value, j: usize) -> Option<[Factor; 2]> {
    m.node.filter(|_| !is_number(g, m)).map(|id| [Factor::Of(id), Factor::Unknown(j)])
}

/// Where a sum of products is found.
#[derive(Clone, Copy)]
pub enum Place {
    Product(usize),
    Square(usize),
}

impl Series {
    fn convolve(&mut self, pair: [Factor; 2]) {
        let key = unordered(pair);
        if self.places.get(&key).is_some() {
            return;
        }
        let place = if pair[0] == pair[1] {
            self.squares.push(pair[0]);
            Place::Square(self.squares.len() - 1)
        } else {
            self.products.push(pair);
            Place::Product(self.products.len() - 1)
        };
        self.places.insert(key, place);
    }

    /// Where `Σ_{0<j<k}` of a pair of factors is.
    pub fn place(&self, pair: [Factor; 2]) -> Place {
        *self.places.get(&unordered(pair)).expect("every product of a rule has a place")
    }
}

/// The same for both orders of the factors.
fn unordered([a, b]: [Factor; 2]) -> [Factor; 2] {
    if a < b { [a, b] } else { [b, a] }
}

/// Where a function's argument is a coordinate and the product of its velocity and the slope has a rule, that is the rate.
fn use_known_rates(g: &Graph, rules: &mut [(Id, Rule)]) {
    let mut known: StableMap<[Id; 2], Id> = StableMap::default();
    for (id, rule) in rules.iter() {
        if let Rule::Product(a, b) = rule {
            known.insert([*a, *b], *id);
            known.insert([*b, *a], *id);
        }
    }
    let mut velocities: Vec<(usize, Id)> = Vec::new();
    for (_, rule) in rules.iter() {
        rule.operands(|v| {
            if let Some((id, Some(Symbol::Velocity(i)))) = v.node.map(|id| (id, symbol(g, id))) {
                velocities.push((i, id));
            }
        });
    }
    for (_, rule) in rules {
        let Rule::Function(slopes) = rule else { continue };
        for slope in slopes {
            let Slope::Rate(k, argument, slope_of) = *slope else { continue };
            let Some(Symbol::Coordinate(i)) = symbol(g, argument) else { continue };
            let Some((_, velocity)) = velocities.iter().find(|(of, _)| *of == i) else { continue };
            if let Some(product) = known.get(&[*velocity, slope_of]) {
                *slope = Slope::Known(k, *product);
            }
        }
    }
}

impl Rule {
    /// Calls `visit` with each series that the rule is about.
    pub fn operands(&self, mut visit: impl FnMut(Value)) {
        match self {
            Rule::Linear(terms) => terms.iter().for_each(|(_, x)| visit(*x)),
            Rule::Product(a, b) => [*a, *b].into_iter().for_each(|id| visit(id.into())),
            Rule::Square(a) | Rule::Power(a, _) => visit((*a).into()),
            Rule::Quotient(a, b) => [*a, (*b).into()].into_iter().for_each(visit),
            Rule::Root(a) => visit(*a),
            Rule::Choice(_, values) => values[2..].iter().for_each(|v| visit(*v)),
            Rule::Function(slopes) => slopes.iter().for_each(|slope| match slope {
                Slope::Number(_, x) => visit(*x),
                Slope::Known(_, product) => visit((*product).into()),
                Slope::Rate(_, a, b) => [*a, *b].into_iter().for_each(|id| visit(id.into())),
            }),
        }
    }

    /// The products of series in the rule of the node `own`.
    pub fn convolutions(&self, own: Id) -> Vec<[Factor; 2]> {
        use Factor::{Of, Rate};
        match self {
            Rule::Linear(_) | Rule::Choice(..) => Vec::new(),
            Rule::Product(a, b) => vec![[Of(*a), Of(*b)]],
            Rule::Square(a) => vec![[Of(*a); 2]],
            Rule::Quotient(_, b) => vec![[Of(*b), Of(own)]],
            Rule::Root(_) => vec![[Of(own); 2]],
            Rule::Power(a, _) => vec![[Rate(*a), Of(own)], [Of(*a), Of(own)]],
            Rule::Function(slopes) => slopes
                .iter()
                .filter_map(|slope| match slope {
                    Slope::Rate(_, a, b) => Some([Rate(*a), Of(*b)]),
                    Slope::Number(..) | Slope::Known(..) => None,
                })
                .collect(),
        }
    }
}

/// The rule of a node that moves.
fn rule(g: &mut Graph, id: Id) -> Option<Rule> {
    Some(match g.node(id).clone() {
        Node::Sum(a, b) => Rule::Linear(vec![(Value::ONE, a), (Value::ONE, b)]),
        Node::Product(a, b) => match (g.node(a).clone(), g.node(b).clone()) {
            _ if g.is_fixed(a) => Rule::Linear(vec![(a.into(), b.into())]),
            _ if g.is_fixed(b) => Rule::Linear(vec![(b.into(), a.into())]),
            _ if a == b => Rule::Square(a),
            (_, Node::Inverse(under)) => Rule::Quotient(a.into(), under),
            (Node::Inverse(under), _) => Rule::Quotient(b.into(), under),
            _ => Rule::Product(a, b),
        },
        Node::Inverse(under) => Rule::Quotient(Value::ONE, under),
        Node::Call(Function::sqrt, a, _) => Rule::Root(a),
        // A constant factor of the base is one of all its coefficients.
        Node::Call(Function::powf, Value { node: Some(a), .. }, r) if is_number(g, r) => Rule::Power(a, r),
        // Its derivatives have ever more powers; and the others are not smooth.
        Node::Call(Function::powf | Function::abs | Function::signum, ..) => return None,
        Node::Call(..) => {
            let partials = g.partials(id);
            let slopes =
                partials.into_iter().filter(|(a, _)| !is_number(g, *a)).filter_map(|(argument, slope)| {
                    if is_number(g, slope) {
                        return Some(Slope::Number(slope, argument));
                    }
                    Some(Slope::Rate(argument.k.mul(slope.k), argument.node?, slope.node?))
                });
            Rule::Function(slopes.collect())
        }
        Node::Select(comparison, values) if values[..2].iter().all(|v| is_number(g, *v)) => {
            Rule::Choice(comparison, values)
        }
        Node::Symbol(_) | Node::Extern(..) | Node::Select(..) => return None,
    })
}

/// The symbol of a node, if it is one.
pub fn symbol(g: &Graph, id: Id) -> Option<Symbol> {
    match g.node(id) {
        Node::Symbol(symbol) => Some(*symbol),
        _ => None,
    }
}
