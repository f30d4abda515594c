//! Expected behaviour of a system, by dual numbers of what the generator wrote, and linear algebra.
//!
//! Prescribed coordinates are positions x = (q, s) like the others, whose motion is known, so that the forces which
//! enforce it are the residuals of their own equations: the relaxed system.

use super::generate::{Call, Expr, Pair, System, Test};
use super::rounding::{Noise, Noisy};
use nalgebra::{DMatrix, DVector};
use num_dual::{Dual, Dual3, HyperDual};
use std::any::Any;
use std::cell::{Cell, OnceCell};

/// State of a system: its free coordinates, their velocities, and time.
#[derive(Clone)]
pub struct State<T> {
    pub q: Vec<T>,
    pub qd: Vec<T>,
    pub t: T,
}

/// Values of all that an expression can name.
struct Point<T> {
    x: Vec<T>,
    /// Rates of the positions.
    xd: Vec<T>,
    t: T,
    /// Bindings as far as they have been asked for.
    bound: Vec<Cell<Option<T>>>,
    /// The same point as it moves, likewise: a `Point<Dual<T>>`.
    moved: OnceCell<Box<dyn Any>>,
}

impl<T: Copy> Point<T> {
    fn new(x: Vec<T>, xd: Vec<T>, t: T, bindings: usize) -> Point<T> {
        Point { x, xd, t, bound: vec![Cell::new(None); bindings], moved: OnceCell::new() }
    }
}

/// A direction in which derivatives are taken.
#[derive(Clone, Copy)]
enum Along<'a, T> {
    Nothing,
    Position(usize),
    Velocity(usize),
    /// Time passes, with these accelerations of the free coordinates.
    Motion(&'a [T]),
}

impl<T: Noisy> Along<'_, T> {
    fn of_position(&self, i: usize, velocity: T) -> T {
        match self {
            Along::Position(j) if *j == i => T::one(),
            Along::Motion(_) => velocity,
            _ => T::zero(),
        }
    }

    fn of_velocity(&self, i: usize) -> T {
        match self {
            Along::Velocity(j) if *j == i => T::one(),
            Along::Motion(a) => a[i],
            _ => T::zero(),
        }
    }

    fn of_time(&self) -> T {
        if matches!(self, Along::Motion(_)) { T::one() } else { T::zero() }
    }
}

/// A system with numbers for its parameters, and the noise with which it is evaluated.
pub struct Reference<'s> {
    pub system: &'s System,
    pub parameters: &'s [f64],
    pub noise: &'s Noise,
}

/// Taylor coefficients of the accelerations beyond themselves.
pub const ORDERS: usize = 3;

/// Everything that is compared, by name.
pub type Named = Vec<(String, f64)>;

impl Reference<'_> {
    /// 1 − 2/(e²ˣ + 1). That of num-dual is a quotient, inside of whose derivative cosh² − sinh² cancels without
    /// being disturbed, so that too little is granted at large arguments.
    fn tanh<T: Noisy>(&self, x: T) -> T {
        let grown = (x + x).exp().noisy(self.noise);
        let under = (grown + T::one()).noisy(self.noise).recip().noisy(self.noise);
        T::one() - (under + under)
    }

    /// The angle of (x, y). That of num-dual is the arc tangent of y/x, whose derivatives cancel undisturbed where x
    /// is small.
    fn angle<T: Noisy>(&self, y: T, x: T) -> T {
        let turned = |by: f64, angle: T| T::from(by * std::f64::consts::FRAC_PI_2) - angle;
        match (y.re().abs() > x.re().abs(), y.re() < 0.0, x.re() < 0.0) {
            (true, down, _) => turned(if down { -1.0 } else { 1.0 }, (x / y).noisy(self.noise).atan()),
            (false, down, true) => turned(if down { -2.0 } else { 2.0 }, (-y / x).noisy(self.noise).atan()),
            (false, ..) => (y / x).noisy(self.noise).atan(),
        }
    }

    /// An expression of positions and time; `rate` knows rates.
    fn value<T: Noisy>(&self, e: &Expr, at: &Point<T>, rate: &dyn Fn(&Expr) -> T) -> T {
        let of = |e: &Expr| self.value(e, at, rate);
        let value = match e {
            Expr::Constant(k) => return T::from(f64::from(*k) / 8.0),
            Expr::Parameter(i) => T::from(self.parameters[*i]),
            Expr::Position(i) => at.x[*i],
            Expr::Time => at.t,
            Expr::Binding(k) => {
                let known = &at.bound[*k];
                if known.get().is_none() {
                    known.set(Some(of(&self.system.bindings[*k])));
                }
                return known.get().expect("has been computed");
            }
            Expr::Unit(_) => return T::one(),
            Expr::Sum(a, b) => of(a) + of(b),
            Expr::Difference(a, b) => of(a) - of(b),
            Expr::Product(a, b) => of(a) * of(b),
            Expr::Quotient(a, b) => of(a) / of(b),
            Expr::Power(a, k) => of(a).powi(*k),
            Expr::Root(a, k) => of(a).powf(f64::from(*k) / 8.0),
            Expr::Pair(f, a, b) => {
                let (a, b) = (of(a), of(b));
                match f {
                    Pair::Atan2 => self.angle(a, b),
                    Pair::Hypot => {
                        let [a, b] = [a, b].map(|x| (x * x).noisy(self.noise));
                        (a + b).noisy(self.noise).sqrt()
                    }
                    Pair::Powf => (a.ln().noisy(self.noise) * b).noisy(self.noise).exp(),
                    Pair::Min => {
                        if a < b {
                            a
                        } else {
                            b
                        }
                    }
                    Pair::Max => {
                        if a < b {
                            b
                        } else {
                            a
                        }
                    }
                }
            }
            Expr::Fused(parts) => {
                let [x, a, b] = parts.each_ref().map(of);
                (x * a).noisy(self.noise) + b
            }
            Expr::Choice(test, parts) => {
                let [a, b, yes, no] = &**parts;
                let (a, b) = (of(a), of(b));
                let met = match test {
                    Test::Less => a < b,
                    Test::AtMost => a <= b,
                    Test::More => a > b,
                    Test::AtLeast => a >= b,
                    Test::Unlike => a != b,
                    Test::Neither => a <= T::zero() && b <= T::zero(),
                    Test::Both => a < T::one() && b < a,
                    Test::Either => a < b || b <= T::zero(),
                };
                if met { of(yes) } else { of(no) }
            }
            Expr::Call(f, a) => {
                let a = of(a);
                match f {
                    Call::Abs => a.abs(),
                    // That of num-dual is 0 at 0.
                    Call::Signum => {
                        if a < T::zero() {
                            -T::one()
                        } else {
                            T::one()
                        }
                    }
                    Call::Sin => a.sin(),
                    Call::Cos => a.cos(),
                    Call::Tan => a.tan(),
                    Call::Asin => a.asin(),
                    Call::Acos => a.acos(),
                    Call::Atan => a.atan(),
                    Call::Sinh => a.sinh(),
                    Call::Cosh => a.cosh(),
                    Call::Tanh => self.tanh(a),
                    Call::Asinh => a.asinh(),
                    Call::Acosh => a.acosh(),
                    Call::Atanh => a.atanh(),
                    Call::Exp => a.exp(),
                    Call::ExpM1 => a.exp_m1(),
                    Call::Exp2 => a.exp2(),
                    Call::Ln => a.ln(),
                    Call::Ln1p => a.ln_1p(),
                    Call::Log2 => a.log2(),
                    Call::Log10 => a.log10(),
                    Call::Sqrt => a.sqrt(),
                    Call::Cbrt => a.cbrt(),
                    Call::Recip => a.recip(),
                    Call::Radians => a * T::from(std::f64::consts::PI / 180.0),
                    Call::Degrees => a * T::from(180.0 / std::f64::consts::PI),
                }
            }
            Expr::Rate(a) => rate(a),
        };
        value.noisy(self.noise)
    }

    /// An expression with rates in it.
    fn moving<T: Noisy>(&self, e: &Expr, at: &Point<T>) -> T {
        self.value(e, at, &|e| self.rate(e, at))
    }

    /// d/dt of an expression of positions and time.
    fn rate<T: Noisy>(&self, e: &Expr, at: &Point<T>) -> T {
        let moved = at.moved.get_or_init(|| {
            let x = at.x.iter().zip(&at.xd).map(|(x, xd)| Dual::new(*x, *xd)).collect();
            Box::new(Point::new(x, Vec::new(), Dual::new(at.t, T::one()), at.bound.len()))
        });
        let moved: &Point<Dual<T>> = moved.downcast_ref().expect("the point in duals");
        self.value(e, moved, &|_| unreachable!("rates of rates are not generated")).eps
    }

    /// The state with its prescribed coordinates, in numbers that know of directions: `varied` makes one of a value
    /// and of how much it changes along each of them.
    fn placed<T: Noisy, U: Noisy, const D: usize>(
        &self,
        at: &State<T>,
        along: [Along<T>; D],
        varied: impl Fn(T, [T; D]) -> U,
    ) -> Point<U> {
        let n = at.q.len();
        let t = varied(at.t, along.map(|a| a.of_time()));
        let bindings = self.system.bindings.len();
        let mut point = Point::new(Vec::new(), Vec::new(), t, bindings);
        for i in 0..n {
            let (x, v) = (at.q[i], at.qd[i]);
            point.x.push(varied(x, along.map(|a| a.of_position(i, v))));
            point.xd.push(varied(v, along.map(|a| a.of_velocity(i))));
        }
        // Given motions depend on time alone; beside that they may be varied, in one direction.
        let nowhere = Point::new(Vec::new(), Vec::new(), t, bindings);
        let by = |hit: [bool; D]| varied(T::zero(), hit.map(|hit| if hit { T::one() } else { T::zero() }));
        for (k, motion) in self.system.prescribed.iter().enumerate() {
            let by_position = by(along.map(|a| matches!(a, Along::Position(i) if i == n + k)));
            let by_velocity = by(along.map(|a| matches!(a, Along::Velocity(i) if i == n + k)));
            point.x.push(self.moving(motion, &nowhere) + by_position);
            point.xd.push(self.rate(motion, &nowhere) + by_velocity);
        }
        point
    }

    /// The state as it moves in one direction.
    fn sloped<T: Noisy>(&self, at: &State<T>, along: Along<T>) -> Point<Dual<T>> {
        self.placed(at, [along], |value, [slope]| Dual::new(value, slope))
    }

    /// The state as it moves in two directions.
    fn point<T: Noisy>(&self, at: &State<T>, one: Along<T>, two: Along<T>) -> Point<HyperDual<T>> {
        self.placed(at, [one, two], |value, [one, two]| HyperDual::new(value, one, two, T::zero()))
    }

    fn lagrangian<T: Noisy>(&self, at: &Point<T>) -> T {
        self.moving(&self.system.kinetic, at) - self.moving(&self.system.potential, at)
    }

    fn dissipation<T: Noisy>(&self, at: &Point<T>) -> T {
        self.system.dissipation.as_ref().map_or(T::zero(), |d| self.moving(d, at))
    }

    /// Q − ∂D/∂ẋ of position i.
    fn nonconservative<T: Noisy>(&self, at: &State<T>, i: usize) -> T {
        let mut sum = -self.dissipation(&self.sloped(at, Along::Velocity(i))).eps;
        let point = self.sloped(at, Along::Position(i));
        for (_, q) in self.system.applied.iter().filter(|(target, _)| *target == i) {
            sum += self.moving(q, &point).re;
        }
        for (force, place) in &self.system.forces {
            sum += self.moving(force, &point).re * self.moving(place, &point).eps;
        }
        sum
    }

    /// ∂L/∂x + Q − ∂D/∂ẋ of position i.
    fn force<T: Noisy>(&self, at: &State<T>, i: usize) -> T {
        let slope = self.lagrangian(&self.sloped(at, Along::Position(i))).eps;
        slope + self.nonconservative(at, i)
    }

    /// A of constraint j at position i.
    fn row<T: Noisy>(&self, at: &State<T>, j: usize, i: usize) -> T {
        let along = match self.system.constraints[j].on_velocities {
            true => Along::Velocity(i),
            false => Along::Position(i),
        };
        self.constraint(&self.sloped(at, along), j).eps
    }

    fn constraint<T: Noisy>(&self, at: &Point<T>, j: usize) -> T {
        let c = &self.system.constraints[j];
        self.moving(&c.left, at) - self.moving(&c.right, at)
    }

    /// d/dt ∂L/∂ẋ − ∂L/∂x + ∂D/∂ẋ − Q − Aᵀ λ of position i.
    fn balance<T: Noisy>(&self, at: &State<T>, a: &[T], multipliers: &[T], i: usize) -> T {
        let inertial = self.lagrangian(&self.point(at, Along::Velocity(i), Along::Motion(a))).eps1eps2;
        let held = (0..multipliers.len()).map(|j| multipliers[j] * self.row(at, j, i)).sum::<T>();
        inertial - self.force(at, i) - held
    }

    /// A q̈ + γ of constraint j.
    fn drift<T: Noisy>(&self, at: &State<T>, a: &[T], j: usize) -> T {
        if self.system.constraints[j].on_velocities {
            return self.constraint(&self.sloped(at, Along::Motion(a)), j).eps;
        }
        let mut point = self.point(at, Along::Motion(a), Along::Motion(a));
        // The second derivative of a position by time is its acceleration.
        for (x, a) in point.x.iter_mut().zip(a) {
            x.eps1eps2 = *a;
        }
        self.constraint(&point, j).eps1eps2
    }

    /// Residuals along the motion: the balance of the free coordinates, and the constraints.
    fn residual<T: Noisy>(&self, at: &State<T>, a: &[T], multipliers: &[T]) -> Vec<T> {
        let balance = (0..a.len()).map(|i| self.balance(at, a, multipliers, i));
        balance.chain((0..multipliers.len()).map(|j| self.drift(at, a, j))).collect()
    }

    /// All that is compared, and the condition number of the bordered inertia. `given` is a right-hand side.
    pub fn named(&self, at: &State<f64>, given: &[f64]) -> Option<(Named, f64)> {
        let (n, m) = (at.q.len(), self.system.constraints.len());
        let mut named = Named::new();
        let mut add = |name: &str, values: &[f64]| {
            named.extend(values.iter().enumerate().map(|(i, v)| (format!("{name}[{i}]"), *v)));
        };
        let still = self.sloped(at, Along::Nothing);
        let (lagrangian, dissipation) = (self.lagrangian(&still).re, self.dissipation(&still).re);
        let momentum = |i| self.lagrangian(&self.sloped(at, Along::Velocity(i))).eps;
        let momenta: Vec<f64> = (0..n).map(momentum).collect();
        let none = vec![0.0; n];
        let bias = |i| self.lagrangian(&self.point(at, Along::Velocity(i), Along::Motion(&none))).eps1eps2;
        let bias: Vec<f64> = (0..n).map(bias).collect();
        let force: Vec<f64> = (0..n).map(|i| self.force(at, i)).collect();
        let power: f64 = (0..n).map(|i| self.nonconservative(at, i) * at.qd[i]).sum();
        let energy_function = momenta.iter().zip(&at.qd).map(|(p, v)| p * v).sum::<f64>() - lagrangian;
        let second = |i, k| self.lagrangian(&self.point(at, Along::Velocity(i), Along::Velocity(k))).eps1eps2;
        let mut matrix = DMatrix::zeros(n + m, n + m);
        for i in 0..n {
            for k in 0..=i {
                let entry = second(i, k);
                (matrix[(i, k)], matrix[(k, i)]) = (entry, entry);
            }
            for j in 0..m {
                let a = self.row(at, j, i);
                (matrix[(n + j, i)], matrix[(i, n + j)]) = (a, -a);
            }
        }
        let inertia: Vec<f64> = (0..n).flat_map(|k| (0..n).map(move |i| (i, k))).map(|e| matrix[e]).collect();
        // Not `singular_values`, whose iteration does not end for some matrices.
        let singular =
            matrix.clone().try_svd(false, false, f64::EPSILON, 1000).map(|svd| svd.singular_values);
        let condition = singular.map_or(f64::NAN, |s| s.max() / s.min());
        // Elimination is exact for a matrix whose entries are off by roundings of the largest one (Higham, *Accuracy
        // and Stability of Numerical Algorithms*, 2002, Theorem 9.3).
        let largest = matrix.amax();
        matrix.iter_mut().for_each(|x| *x += self.noise.apply(largest) - largest);
        let lu = matrix.full_piv_lu();
        let solve = |right: Vec<f64>| lu.solve(&DVector::from(right));
        let right = self.residual(at, &none, &vec![0.0; m]).into_iter().map(|r| -r).collect();
        let solution = solve(right)?;
        let (a, multipliers) = solution.as_slice().split_at(n);
        let reactions = (n..n + self.system.prescribed.len()).map(|i| self.balance(at, a, multipliers, i));
        let reactions: Vec<f64> = reactions.collect();

        add("lagrangian", &[lagrangian]);
        add("dissipation", &[dissipation]);
        add("energy_function", &[energy_function]);
        add("power", &[power]);
        add("momenta", &momenta);
        add("convective_momentum_rate", &bias);
        add("momentum_rate", &force);
        add("inertia", &inertia);
        add("accel", a);
        add("multipliers", multipliers);
        add("reactions", &reactions);
        add("response", solve(given[..n + m].to_vec())?.as_slice());
        // ∂(q̈, λ)/∂x = −K⁻¹ ∂residual/∂x at constant q̈ and λ.
        let constant = |values: &[f64]| values.iter().map(|x| Dual::from_re(*x)).collect::<Vec<_>>();
        let mut columns = Vec::new();
        for k in 0..=2 * n {
            let mut state = State { q: constant(&at.q), qd: constant(&at.qd), t: Dual::from_re(at.t) };
            let variable = match k {
                k if k < n => &mut state.q[k],
                k if k < 2 * n => &mut state.qd[k - n],
                _ => &mut state.t,
            };
            variable.eps = 1.0;
            let moved = self.residual(&state, &constant(a), &constant(multipliers));
            let column = solve(moved.into_iter().map(|r| -r.eps).collect())?;
            columns.extend(&column.as_slice()[..n]);
        }
        add("jacobian", &columns);
        // ∂(b − f)/∂x: the residual without accelerations.
        let mut columns = Vec::new();
        for k in 0..2 * n {
            let mut state = State { q: constant(&at.q), qd: constant(&at.qd), t: Dual::from_re(at.t) };
            let variable = if k < n { &mut state.q[k] } else { &mut state.qd[k - n] };
            variable.eps = 1.0;
            let moved = self.residual(&state, &constant(&none), &constant(&vec![0.0; m]));
            columns.extend(moved[..n].iter().map(|r| r.eps));
        }
        add("linearize", &columns);
        let series = self.series(at, a, multipliers, solve)?;
        for (order, coefficients) in series.iter().enumerate() {
            add(&format!("series {}", order + 1), coefficients);
        }
        let columns: Vec<f64> =
            (0..n).flat_map(|i| (0..m).map(move |j| (i, j))).map(|(i, j)| self.row(at, j, i)).collect();
        add("constraint_jacobian", &columns);
        let held = (0..m).map(|j| {
            let on_velocities = self.system.constraints[j].on_velocities;
            let value = self.constraint(&still, j).re;
            let rate = self.constraint(&self.sloped(at, Along::Motion(&none)), j).eps;
            if on_velocities { (0.0, value) } else { (value, rate) }
        });
        let (values, rates): (Vec<f64>, Vec<f64>) = held.unzip();
        add("constraints", &values);
        add("constraint_rates", &rates);
        for (j, place) in self.system.struck.iter().enumerate() {
            let hit = |i: usize| {
                let point = self.sloped(at, Along::Position(i));
                let parts = place.iter().zip(given);
                parts.map(|(x, p)| self.noise.apply(p * self.moving(x, &point).eps)).sum::<f64>()
            };
            add(&format!("blow {j}"), &(0..n).map(hit).collect::<Vec<f64>>());
        }
        for (j, value) in self.system.observed.iter().enumerate() {
            add(&format!("seen {j}"), &[self.moving(value, &still).re]);
            let moved = self.moving(value, &self.sloped(at, Along::Motion(&given[..n])));
            let time = self.noise.apply(at.t);
            add(&format!("hit {j}"), &[self.noise.apply(time + moved.re), self.noise.apply(1.0 + moved.eps)]);
        }
        let [kinetic, potential] = [&self.system.kinetic, &self.system.potential];
        add("kinetic", &[self.moving(kinetic, &still).re]);
        add("potential", &[self.moving(potential, &still).re]);
        Some((named, condition))
    }

    /// Taylor coefficients 1, 2 and 3 of the accelerations: the residual vanishes all along the motion, so
    /// K (q̈, λ)⁽ᵏ⁾ = −dᵏ/dtᵏ residual with the derivatives up to the (k − 1)-th in it.
    fn series(
        &self,
        at: &State<f64>,
        a: &[f64],
        multipliers: &[f64],
        solve: impl Fn(Vec<f64>) -> Option<DVector<f64>>,
    ) -> Option<[Vec<f64>; ORDERS]> {
        let mut derivatives: Vec<Vec<f64>> = vec![[a, multipliers].concat()];
        for order in 1..=ORDERS {
            // The k-th derivative of q is the (k − 2)-th of q̈.
            let of = |i: usize, k: usize| derivatives.get(k).map_or(0.0, |d| d[i]);
            let dual = |x: [f64; 4]| Dual3::new(x[0], x[1], x[2], x[3]);
            let q = |i: usize| dual([at.q[i], at.qd[i], of(i, 0), of(i, 1)]);
            let qd = |i: usize| dual([at.qd[i], of(i, 0), of(i, 1), of(i, 2)]);
            let n = a.len();
            let state = State {
                q: (0..n).map(q).collect(),
                qd: (0..n).map(qd).collect(),
                t: dual([at.t, 1.0, 0.0, 0.0]),
            };
            let unknown: Vec<Dual3<f64>> =
                (0..n + multipliers.len()).map(|i| dual([0, 1, 2, 3].map(|k| of(i, k)))).collect();
            let moved = self.residual(&state, &unknown[..n], &unknown[n..]);
            let right = moved.into_iter().map(|r| -[r.v1, r.v2, r.v3][order - 1]).collect();
            derivatives.push(solve(right)?.as_slice().to_vec());
        }
        let over =
            |k: usize, factorial: f64| derivatives[k][..a.len()].iter().map(|x| x / factorial).collect();
        Some([over(1, 1.0), over(2, 2.0), over(3, 6.0)])
    }
}
