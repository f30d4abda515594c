//! The attitudes of a series by what has few products: their quaternions and the angular velocities of all frames.
//!
//! The parameters σ of an attitude enter the equations by its axes and its ω alone. With half its quaternion (c, v)
//! (`model/attitude.rs`)
//!
//! ```text
//!   ḋ = ċ = −½ v·ω,    v̇ = ½ (c ω + v × ω),    d σ = v,    d = c + ½,
//! ```
//!
//! which are 12 products of series, and 3 for the parameters that a state is made of; R is of second degree in (c, v).
//! ω is the integral of ω̇, which is among the unknowns of the equations at the bindings, as the angular accelerations
//! of all frames are: so none of them is ever written in σ and σ̇. Order 0 is what the state says.

use super::form::Known;
use super::orders::Orders;
use crate::equations::assemble::{Form, flattened};
use crate::equations::common::is_number;
use crate::graph::{Graph, Node, Number, Symbol, Value};
use crate::model::attitude::{axes, matrix, rates, turning};
use crate::model::frames::{Motion, Vector};

/// The attitudes of a system, and the angular velocities that have series of their own.
#[derive(Default)]
pub struct Attitudes {
    turns: Vec<Turn>,
    /// Angular velocities of frames in others, by their bindings.
    pub spins: Vec<usize>,
}

/// An attitude.
struct Turn {
    /// The first of its coordinates.
    first: usize,
    /// The bindings that are its angular velocity ω.
    spin: [usize; 3],
    /// d and v
    half: [Symbol; 4],
}

impl Turn {
    /// c and v
    fn half(&self, g: &mut Graph) -> (Value, Vector) {
        let [d, v @ ..] = self.half.map(|symbol| g.symbol(symbol));
        (g.sub(d, Value::ONE.scaled(Number::Ratio(1, 2))), v)
    }
}

impl Attitudes {
    pub fn new(known: &Known) -> Attitudes {
        let turns = known.formed.unreduced.attitudes.iter().enumerate().map(|(i, attitude)| Turn {
            first: attitude.first,
            spin: attitude.spin,
            half: [0, 1, 2, 3].map(|k| Symbol::Quaternion(4 * i + k)),
        });
        Attitudes { turns: turns.collect(), spins: Vec::new() }
    }

    pub fn is_empty(&self) -> bool {
        self.turns.is_empty()
    }

    /// Is this binding a component of the ω of an attitude?
    pub fn is_turn(&self, binding: usize) -> bool {
        self.turns.iter().any(|turn| turn.spin.contains(&binding))
    }

    /// Is this the parameter of an attitude, or its rate?
    pub fn is_parameter(&self, symbol: Symbol) -> bool {
        match symbol {
            Symbol::Coordinate(i) | Symbol::Velocity(i) => self.turned_by(i).is_some(),
            _ => false,
        }
    }

    /// The component of ω whose rate takes the place of the acceleration of this coordinate.
    pub fn turned_by(&self, coordinate: usize) -> Option<Symbol> {
        let turn = self.turns.iter().find(|turn| (turn.first..turn.first + 3).contains(&coordinate))?;
        Some(Symbol::Rate(turn.spin[coordinate - turn.first]))
    }

    /// Writes the axes of the attitudes by quaternions and angular velocities, in which there is nothing else left of
    /// their parameters.
    pub fn write(&self, g: &mut Graph, form: &mut Form) {
        for turn in &self.turns {
            let (c, v) = turn.half(g);
            let omega = turn.spin.map(|k| g.symbol(Symbol::Rate(k)));
            for (symbols, row) in axes(turn.spin).into_iter().zip(matrix(g, c, &v)) {
                let [rates, seconds] = turning(g, &row, &omega);
                for (i, symbol) in symbols.into_iter().enumerate() {
                    if let Symbol::Binding(k) = symbol {
                        form.bindings[k] = [row[i], rates[i]];
                        form.motions[k] = Motion::Turning(seconds[i]);
                    }
                }
            }
        }
    }

    /// Values and rates of the bindings in terms of quaternions and angular velocities.
    pub fn flat(&mut self, g: &mut Graph, form: &Form) -> Vec<[Value; 2]> {
        let mut flat: Vec<[Value; 2]> = Vec::new();
        for (k, pair) in form.bindings.iter().enumerate() {
            if self.is_turn(k) {
                flat.push([Value::ZERO, g.symbol(Symbol::Rate(k))]);
                continue;
            }
            let mut pair = flattened(g, &flat, pair);
            let of_frame = form.frames.spins.iter().flatten().any(|spin| *spin == Some(k));
            let is_symbol = |id| matches!(g.node(id), Node::Symbol(_));
            if of_frame && !is_number(g, pair[1]) && !pair[1].node.is_some_and(is_symbol) {
                self.spins.push(k);
                pair[1] = g.symbol(Symbol::Rate(k));
            }
            flat.push([pair[0], pair[1]]);
        }
        flat
    }

    /// The rates of all quaternions.
    pub fn values(&self, g: &mut Graph) -> Vec<Value> {
        let mut values = Vec::new();
        for turn in &self.turns {
            let omega = turn.spin.map(|k| g.symbol(Symbol::Rate(k)));
            let (c, v) = turn.half(g);
            values.extend(rates(g, c, &v, &omega));
        }
        values
    }

    /// Says what the quaternions are in an order, by their rates.
    pub fn turn(&self, rates: &[Value], orders: &mut Orders) {
        for (symbol, rate) in self.turns.iter().flat_map(|turn| turn.half).zip(rates) {
            let before = orders.before(*rate);
            let coefficient = orders.over(before);
            orders.set(symbol, coefficient);
        }
    }

    /// The parameters of an order, and their coordinates.
    pub fn parameters(&self, orders: &mut Orders) -> Vec<(usize, Value)> {
        let mut found = Vec::new();
        for turn in &self.turns {
            let [d, v @ ..] = turn.half.map(|symbol| orders.g.symbol(symbol));
            for (i, v) in (turn.first..).zip(v) {
                let parameter = orders.fraction(Symbol::Coordinate(i), v, d);
                orders.set(Symbol::Coordinate(i), parameter);
                found.push((i, parameter));
            }
        }
        found
    }

    /// Order 0 of a symbol that an attitude has its own series of.
    pub fn at_start(known: &Known, symbol: Symbol) -> Option<Value> {
        match symbol {
            Symbol::Rate(k) => Some(known.formed.flat[k][1]),
            Symbol::Quaternion(i) => {
                let at = &known.formed.unreduced.attitudes[i / 4].at;
                Some(if i % 4 == 0 { at.inverse } else { at.vector[i % 4 - 1] })
            }
            _ => None,
        }
    }
}
