//! Everything that is emitted for a system against automatic differentiation of its L, D and Q.

use crate::bounded::Bounded;
use lagrange_runtime::prelude::*;
use nalgebra::SVector;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use std::cell::Cell;
use std::ops::Range;

/// A system and, independently, what it should be.
pub trait Written<const N: usize>: Copy {
    type Over<S: Scalar>: Lagrangian<N, Scalar = S>;

    fn system() -> Self;

    fn over<S: Scalar>(self) -> Self::Over<S>;

    fn lagrangian<S: Scalar>(&self, q: [S; N], qd: [S; N], t: S) -> S;

    fn dissipation<S: Scalar>(&self, _: [S; N], _: [S; N], _: S) -> S {
        S::zero()
    }

    fn applied<S: Scalar>(&self, _: [S; N], _: [S; N], _: S) -> [S; N] {
        [S::zero(); N]
    }

    /// Ranges of the coordinates; velocities and time are between −2 and 2.
    fn ranges() -> [Range<f64>; N];
}

/// All that a system depends on.
#[derive(Clone, Copy)]
struct State<S, const N: usize> {
    q: [S; N],
    qd: [S; N],
    t: S,
}

/// A direction in the space of states.
#[derive(Clone, Copy)]
enum Along {
    Coordinate(usize),
    Velocity(usize),
    Time,
}

impl<S: Scalar, const N: usize> State<S, N> {
    fn map<R: Scalar>(self, f: impl Fn(S) -> R) -> State<R, N> {
        State { q: self.q.map(&f), qd: self.qd.map(&f), t: f(self.t) }
    }

    /// The state as it moves along one direction.
    fn along(self, direction: Along) -> State<Dual<S>, N> {
        let mut moving = self.map(Dual::constant);
        match direction {
            Along::Coordinate(i) => moving.q[i].slope = S::one(),
            Along::Velocity(i) => moving.qd[i].slope = S::one(),
            Along::Time => moving.t.slope = S::one(),
        }
        moving
    }

    /// The state as time goes on, with these accelerations.
    fn in_time(self, a: [S; N]) -> State<Dual<S>, N> {
        let dual = |values: [S; N], slopes: [S; N]| {
            std::array::from_fn(|i| Dual { value: values[i], slope: slopes[i] })
        };
        State { q: dual(self.q, self.qd), qd: dual(self.qd, a), t: Dual::variable(self.t) }
    }

    fn vectors(&self) -> (SVector<S, N>, SVector<S, N>, S) {
        (SVector::from(self.q), SVector::from(self.qd), self.t)
    }
}

fn states<W: Written<N>, const N: usize>() -> impl Strategy<Value = ([f64; N], [f64; N], f64)> {
    let coordinates: Vec<_> = W::ranges().into_iter().collect();
    let array = |numbers: Vec<f64>| -> [f64; N] { numbers.try_into().expect("one for each coordinate") };
    (coordinates.prop_map(array), prop::collection::vec(-2.0..2.0f64, N).prop_map(array), -2.0..2.0f64)
}

/// Runs a check at random states, the same ones each time. (`LAGRANGE_SEED` asks for others, `LAGRANGE_STATES` for
/// more.)
fn at_random_states<W: Written<N>, const N: usize>(check: impl Fn(State<Bounded, N>)) {
    let number = |name, usual| std::env::var(name).map_or(usual, |text| text.parse().expect("a number"));
    let config = ProptestConfig {
        rng_seed: RngSeed::Fixed(number("LAGRANGE_SEED", 7)),
        failure_persistence: None,
        ..ProptestConfig::with_cases(number("LAGRANGE_STATES", 1000) as u32)
    };
    let run = TestRunner::new(config).run(&states::<W, N>(), |(q, qd, t)| {
        check(State { q: q.map(Bounded::exact), qd: qd.map(Bounded::exact), t: Bounded::exact(t) });
        Ok(())
    });
    if let Err(error) = run {
        panic!("{error}");
    }
}

pub fn check<W: Written<N>, const N: usize>() {
    let written = W::system();
    let [compared, all] = [Cell::new(0), Cell::new(0)];
    at_random_states::<W, N>(|state| {
        check_equations(&written, state);
        check_energy(&written, state);
        check_jacobian(&written, state);
        compared.set(compared.get() + check_slopes(&written, state));
        all.set(all.get() + 2 * N * N);
    });
    println!("{} of {} slopes compared", compared.get(), all.get());
    assert!(10 * compared.get() > 9 * all.get(), "{} of {} slopes", compared.get(), all.get());
}

/// L, D, p, M, bias and force; and M q̈ + b = f.
fn check_equations<W: Written<N>, const N: usize>(written: &W, state: State<Bounded, N>) {
    let system = written.over::<Bounded>();
    let (q, qd, t) = state.vectors();
    let lagrangian = |s: State<Dual<Bounded>, N>| written.lagrangian(s.q, s.qd, s.t).slope;
    let dissipation = |s: State<Dual<Bounded>, N>| written.dissipation(s.q, s.qd, s.t).slope;
    let second = |outer: Along, inner: State<Dual<Bounded>, N>| {
        let s = inner.along(outer);
        written.lagrangian(s.q, s.qd, s.t).slope.slope
    };

    let value = written.lagrangian(state.q, state.qd, state.t);
    system.lagrangian(&q, &qd, t).assert_agrees(value, || "L".into());
    let value = written.dissipation(state.q, state.qd, state.t);
    system.dissipation(&q, &qd, t).assert_agrees(value, || "D".into());

    let (momenta, inertia) = (system.momenta(&q, &qd, t), system.inertia(&q, &qd, t));
    let (bias, force) = (system.convective_momentum_rate(&q, &qd, t), system.momentum_rate(&q, &qd, t));
    let accel = system.accel(&q, &qd, t);
    let applied = written.applied(state.q, state.qd, state.t);
    assert_eq!(inertia, inertia.transpose(), "M is symmetric to the last bit");
    for i in 0..N {
        let p = lagrangian(state.along(Along::Velocity(i)));
        momenta[i].assert_agrees(p, || format!("p[{i}]"));
        let drift = second(Along::Velocity(i), state.in_time([Bounded::exact(0.0); N]));
        bias[i].assert_agrees(drift, || format!("bias[{i}]"));
        let slope = lagrangian(state.along(Along::Coordinate(i)));
        let total = slope - dissipation(state.along(Along::Velocity(i))) + applied[i];
        force[i].assert_agrees(total, || format!("force[{i}]"));
        let mut inertial = drift;
        for j in 0..N {
            let m = second(Along::Velocity(i), state.along(Along::Velocity(j)));
            inertia[(i, j)].assert_agrees(m, || format!("M[{i}, {j}]"));
            inertial += m * accel[j];
        }
        inertial.assert_agrees(total, || format!("M q̈ + b = f, {i}"));
    }
}

/// h = p·q̇ − L, and dh/dt = power − ∂L/∂t along the motion.
fn check_energy<W: Written<N>, const N: usize>(written: &W, state: State<Bounded, N>) {
    let (q, qd, t) = state.vectors();
    let system = written.over::<Bounded>();
    let accel = system.accel(&q, &qd, t);
    let applied = written.applied(state.q, state.qd, state.t);
    let (mut h, mut power) = (-written.lagrangian(state.q, state.qd, state.t), Bounded::exact(0.0));
    for i in 0..N {
        let s = state.along(Along::Velocity(i));
        h += written.lagrangian(s.q, s.qd, s.t).slope * state.qd[i];
        power += (applied[i] - written.dissipation(s.q, s.qd, s.t).slope) * state.qd[i];
    }
    system.energy_function(&q, &qd, t).assert_agrees(h, || "h".into());
    system.power(&q, &qd, t).assert_agrees(power, || "power".into());
    let moving = written.over::<Dual<Bounded>>();
    let (mq, mqd, mt) = state.in_time(std::array::from_fn(|i| accel[i])).vectors();
    let s = state.along(Along::Time);
    let rate = power - written.lagrangian(s.q, s.qd, s.t).slope;
    moving.energy_function(&mq, &mqd, mt).slope.assert_agrees(rate, || "dh/dt".into());
}

/// The emitted Jacobian against duals of the emitted accelerations.
fn check_jacobian<W: Written<N>, const N: usize>(written: &W, state: State<Bounded, N>) {
    let (q, qd, t) = state.vectors();
    let jacobian = written.over::<Bounded>().jacobian(&q, &qd, t);
    let moving = written.over::<Dual<Bounded>>();
    let column = |direction| {
        let (q, qd, t) = state.along(direction).vectors();
        moving.accel(&q, &qd, t).map(|a| a.slope)
    };
    for j in 0..N {
        let (by_q, by_qd) = (column(Along::Coordinate(j)), column(Along::Velocity(j)));
        for i in 0..N {
            jacobian.q[(i, j)].assert_agrees(by_q[i], || format!("∂q̈[{i}]/∂q[{j}]"));
            jacobian.qd[(i, j)].assert_agrees(by_qd[i], || format!("∂q̈[{i}]/∂q̇[{j}]"));
        }
    }
    let by_t = column(Along::Time);
    for i in 0..N {
        jacobian.t[i].assert_agrees(by_t[i], || format!("∂q̈[{i}]/∂t"));
    }
}

/// The emitted Jacobian against difference quotients. Their truncation error is of second order, so it is a quarter
/// at half the step; where the quotients do not behave so, a kink or a jump is near, and they say nothing. Returns
/// how many were compared.
fn check_slopes<W: Written<N>, const N: usize>(written: &W, state: State<Bounded, N>) -> usize {
    let mut compared = 0;
    let system = written.over::<Bounded>();
    let (q, qd, t) = state.vectors();
    let jacobian = system.jacobian(&q, &qd, t);
    for j in 0..2 * N {
        let quotient = |h: f64| {
            let [ahead, behind] = [h, -h].map(|h| {
                let (mut q, mut qd) = (q, qd);
                let moved = if j < N { &mut q[j] } else { &mut qd[j - N] };
                moved.value += h;
                (moved.value, system.accel(&q, &qd, t))
            });
            (ahead.1 - behind.1) / SVector::<_, N>::from([Bounded::exact(ahead.0 - behind.0); N])[0]
        };
        let [coarse, middle, fine] = [4e-4, 2e-4, 1e-4].map(quotient);
        for i in 0..N {
            let truncation = (middle[i].value - fine[i].value).abs();
            let noise = fine[i].error + middle[i].error + coarse[i].error;
            if truncation <= 0.5 * (coarse[i].value - middle[i].value).abs() + noise {
                compared += 1;
                let exact = if j < N { jacobian.q[(i, j)] } else { jacobian.qd[(i, j - N)] };
                let allowed = noise + truncation + exact.error;
                let difference = (exact.value - fine[i].value).abs();
                assert!(
                    difference <= allowed,
                    "slope {j} of q̈[{i}]: {exact:?}, {:?} by differences",
                    fine[i]
                );
            }
        }
    }
    compared
}

/// An observed velocity is the rate of the observed place.
pub fn check_velocities<W: Written<N>, const N: usize, const K: usize>(
    place: impl Fn(
        &W::Over<Dual<Bounded>>,
        &SVector<Dual<Bounded>, N>,
        &SVector<Dual<Bounded>, N>,
        Dual<Bounded>,
    ) -> SVector<Dual<Bounded>, K>,
    speed: impl Fn(&W::Over<Bounded>, &SVector<Bounded, N>, &SVector<Bounded, N>, Bounded) -> SVector<Bounded, K>,
) {
    let written = W::system();
    at_random_states::<W, N>(|state| {
        let (q, qd, t) = state.vectors();
        let speed = speed(&written.over(), &q, &qd, t);
        let (q, qd, t) = state.in_time([Bounded::exact(0.0); N]).vectors();
        for (i, place) in place(&written.over(), &q, &qd, t).iter().enumerate() {
            speed[i].assert_agrees(place.slope, || format!("velocity {i}"));
        }
    });
}
