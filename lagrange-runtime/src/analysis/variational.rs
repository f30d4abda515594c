//! Neighbouring motions: the variational equations along a trajectory, as a system of their own or as derivatives
//! carried through every step.

use super::AnalysisError;
use super::tangent::deviations;
use crate::attitude;
use crate::controller::{Controller, FirstStep, PiController};
use crate::failure::{Failure, Requirement};
use crate::integrate::integrate;
use crate::lanes::Rescale;
use crate::method::Method;
use crate::method::explicit_rk::Dop853;
use crate::method::taylor::{Taylor, TaylorController};
use crate::scalar::{Dual, Gradient, Real, Scalar, SimdScalar};
use crate::state::{Restored, State, Tangent};
use crate::system::{Lagrangian, System};
use nalgebra::{DMatrix, SVector};

/// A system together with deviations from its motion: `δq̈ = (∂q̈/∂q) δq + (∂q̈/∂q̇) δq̇` with the emitted Jacobian
/// along the trajectory (Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, 1993, I.14). A
/// system of T coordinates: the N of the system, then N for each deviation. Any method integrates it, and its error
/// control covers the deviations too.
///
/// ```
/// use lagrange_runtime::analysis::Variational;
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Oscillator {
///         param omega;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * (omega * x).powi(2);
///     }
/// }
/// let oscillator = Oscillator::new(2.0);
/// let all = Variational::<_, 1>::new(&oscillator);
/// // x = 0.3, and two deviations: of x, and of ẋ.
/// let start = State::new(0.0, [0.3, 1.0, 0.0], [0.0, 0.0, 1.0]);
/// let end = integrate(&all, Dop853, PiController::tolerance(1e-12), start).until(1.0).final_state()?;
/// assert!((end.q[1] - 2.0f64.cos()).abs() < 1e-11 && (end.q[2] - 2.0f64.sin() / 2.0).abs() < 1e-11);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Variational<'a, Sys, const N: usize> {
    system: &'a Sys,
}

impl<'a, Sys, const N: usize> Variational<'a, Sys, N> {
    /// The system with deviations.
    pub fn new(system: &'a Sys) -> Self {
        Variational { system }
    }
}

impl<S: Scalar, Sys: Lagrangian<N, Scalar = S> + Rescale<N>, const N: usize, const T: usize> System<T>
    for Variational<'_, Sys, N>
{
    type Scalar = S;

    const AUTONOMOUS: bool = Sys::AUTONOMOUS;
    const SWITCHES: usize = Sys::SWITCHES;
    const IMPULSES: usize = Sys::IMPULSES;
    const HOLDS: bool = Sys::HOLDS;
    const ATTITUDES: &'static [usize] = Sys::ATTITUDES;

    fn shortened(&self, at: &State<S, T>, equal: Option<S>) -> Option<State<S, T>>
    where
        S: Real,
    {
        let own = part::<_, N, T>(at, 0);
        let equal = equal.map(|h| (h, self.system.accel(&own.q, &own.qd, own.t)));
        let far = attitude::steps::far(Sys::ATTITUDES, &own, equal);
        far.clone().next()?;
        let mut all = *at;
        for first in (0..T).step_by(N) {
            let turned = match first {
                0 => own.turned(far.clone()),
                _ => attitude::steps::turned_deviation(far.clone(), &own, &part(at, first)),
            };
            for i in 0..N {
                (all.q[first + i], all.qd[first + i]) = (turned.q[i], turned.qd[i]);
            }
        }
        Some(all)
    }

    fn switches(&self, at: &State<S, T>, accelerations: &SVector<S, T>, each: impl FnMut(usize, [S; 2])) {
        self.system.switches(&part(at, 0), &coordinates(accelerations, 0), each);
    }

    fn decides(&self, switch: usize, at: &State<S, T>) -> bool
    where
        S: Real,
    {
        self.system.decides(switch, &part(at, 0))
    }

    /// Saltation of each deviation: switching functions over dual numbers have its slope.
    fn saltated(&self, switch: usize, from: &State<S, T>, to: &State<S, T>) -> Option<SVector<S, T>>
    where
        S: Real,
    {
        let [own_from, own_to] = [from, to].map(|at| part::<_, N, T>(at, 0));
        let [before, after] = [&own_from, &own_to].map(|at| self.system.accel(&at.q, &at.qd, at.t));
        let system = self.system.over(Dual::constant);
        let mut qd = to.qd;
        for first in (N..T).step_by(N) {
            let deviation = part::<_, N, T>(to, first);
            let along = |value: &SVector<S, N>, slope: &SVector<S, N>| {
                SVector::<_, N>::from_fn(|i, _| Dual { value: value[i], slope: slope[i] })
            };
            let at = State {
                t: Dual::constant(to.t),
                q: along(&own_to.q, &deviation.q),
                qd: along(&own_to.qd, &deviation.qd),
            };
            let mut later = S::zero();
            system.switches(&at, &before.map(Dual::constant), |index, [g, rate]| {
                if index == switch {
                    later = -g.slope / rate.value;
                }
            });
            for i in 0..N {
                qd[first + i] += (before[i] - after[i]) * later;
            }
        }
        Some(qd)
    }

    /// The constraints hold for the motion, and their linearized equations for each deviation.
    fn restored(&self, at: &State<S, T>) -> Result<Option<Restored<S, T>>, Failure<S>>
    where
        S: SimdScalar,
    {
        let Some(Restored { state: own, constraint, violation }) = self.system.restored(&part(at, 0))? else {
            return Ok(None);
        };
        let system = self.system.over(Dual::constant);
        let along = |value: &SVector<S, N>, slope: &SVector<S, N>| {
            SVector::<_, N>::from_fn(|i, _| Dual { value: value[i], slope: slope[i] })
        };
        let mut state = *at;
        for i in 0..N {
            (state.q[i], state.qd[i]) = (own.q[i], own.qd[i]);
        }
        for first in (N..T).step_by(N) {
            let deviation = part::<_, N, T>(at, first);
            let (q, qd) = (along(&own.q, &deviation.q), along(&own.qd, &deviation.qd));
            let admitted = system.toward_constraints(&State { t: Dual::constant(at.t), q, qd });
            for i in 0..N {
                (state.q[first + i], state.qd[first + i]) = (admitted.q[i].slope, admitted.qd[i].slope);
            }
        }
        Ok(Some(Restored { state, constraint, violation }))
    }

    fn explained(&self, start: &State<S, T>, last: &State<S, T>, failure: Failure<S>) -> Failure<S>
    where
        S: Real,
    {
        self.system.explained(&part(start, 0), &part(last, 0), failure)
    }

    fn resolved(&self, start: &State<S, T>, at: &State<S, T>) -> Result<(), Failure<S>>
    where
        S: Real,
    {
        self.system.resolved(&part(start, 0), &part(at, 0))
    }

    fn accel(&self, q: &SVector<S, T>, qd: &SVector<S, T>, t: S) -> SVector<S, T> {
        const { assert!(N > 0 && T >= N && T.is_multiple_of(N), "T is a multiple of the number of coordinates") };
        let [at, speed] = [q, qd].map(|x| coordinates::<S, N, T>(x, 0));
        let mut all = SVector::from_fn(|_, _| S::zero());
        let acceleration = self.system.accel(&at, &speed, t);
        for i in 0..N {
            all[i] = acceleration[i];
        }
        let jacobian = self.system.jacobian(&at, &speed, t);
        for first in (N..T).step_by(N) {
            for i in 0..N {
                let mut sum = S::zero();
                for j in 0..N {
                    sum = jacobian.q[(i, j)].mul_add(q[first + j], sum);
                    sum = jacobian.qd[(i, j)].mul_add(qd[first + j], sum);
                }
                all[first + i] = sum;
            }
        }
        all
    }
}

/// The N components from the one at `first` on.
fn coordinates<S: Scalar, const N: usize, const T: usize>(
    all: &SVector<S, T>,
    first: usize,
) -> SVector<S, N> {
    SVector::from_fn(|i, _| all[first + i])
}

/// The system, or a deviation from it, of a system together with deviations.
fn part<S: Scalar, const N: usize, const T: usize>(at: &State<S, T>, first: usize) -> State<S, N> {
    State { t: at.t, q: coordinates(&at.q, first), qd: coordinates(&at.qd, first) }
}

/// Fails where steps do not end at the switches of a system.
fn ends_at_switches<Sys, M, C, const N: usize>(method: &M, controller: &C) -> Result<(), Failure<Sys::Scalar>>
where
    Sys: System<N, Scalar: Real>,
    M: Method<Sys, N>,
    C: Controller<Sys::Scalar, N, M::Error>,
{
    let fixed = matches!(controller.first_step(), FirstStep::Fixed(_));
    match Sys::SWITCHES > 0 && fixed && !method.ends_at_switches() {
        true => Err(Failure::Unsuitable { chosen: "FixedStep", requirement: Requirement::Smooth }),
        false => Ok(()),
    }
}

/// The flow of a system and its derivative: how neighbours move, for [`fundamental_matrix`],
/// [`periodic_orbit`](super::periodic_orbit) and [`lyapunov_spectrum`](super::lyapunov_spectrum).
///
/// # Hypotheses
/// - Steps end where the accelerations [switch](System::switches): those of adaptive methods and of [`const@Taylor`]
///   do. Where forces jump, deviations get the saltation of [`System::saltated`]; [`Requirement::Smooth`] rejects steps
///   of one size over switches.
/// - The motion crosses switches at a rate that is not 0, and one at a time: where it touches one, or meets two at
///   once, it has no derivative.
/// - The motion does not slide on a switch ([`Failure::Sliding`]).
///
/// With `x = (q, q̇)`, `ẋ = f(x, t)` and its flow `x(t + τ) = Φ_τ(x)` a deviation δ becomes `DΦ_τ(x) δ`, which is the
/// solution of `δ̇ = Df δ` (Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, 1993, I.14).
///
/// | | deviations | methods |
/// |---|---|---|
/// | [`ByVariationalEquations`] | more coordinates, by the emitted Jacobian | any; DOP853 |
/// | [`ByGradients`] | derivatives in every number | any; Taylor series |
pub trait TangentFlow<const N: usize> {
    /// Number of deviations that are carried along: 2N for all of them.
    const DEVIATIONS: usize;

    /// True if time is proved not to appear in the equations of motion ([`System::AUTONOMOUS`]).
    const AUTONOMOUS: bool;

    /// Number of states of first order ([`System::FIRST_ORDER`]), whose time integrals have no part in orbits and
    /// exponents.
    const FIRST_ORDER: usize = 0;
    /// The first coordinates of the attitudes among the coordinates ([`System::ATTITUDES`]).
    const ATTITUDES: &'static [usize] = &[];

    /// The accelerations q̈, of length N, in the units of q over the square of the unit of t.
    fn accel(&self, at: &State<f64, N>) -> SVector<f64, N>;

    /// The state near `at` that satisfies the constraints, and an orthonormal basis of the deviations that they
    /// admit, 2N × n; where the coordinates are independent, the columns of the unit matrix. Time integrals of states
    /// of first order are left out.
    ///
    /// # Errors
    /// [`AnalysisError::Run`] where no such state is near; [`AnalysisError::DependentConstraints`].
    fn admissible(&self, at: &State<f64, N>) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError> {
        Ok((*at, unrestricted::<N>(Self::FIRST_ORDER)))
    }

    /// The state after `duration`, in units of t, and what has become of the deviations: the columns of a
    /// `2N × DEVIATIONS` matrix, q above q̇.
    ///
    /// # Errors
    /// [`AnalysisError::Run`]; [`AnalysisError::Dimension`] for a matrix of another size.
    fn follow(
        &self,
        start: &State<f64, N>,
        deviations: &DMatrix<f64>,
        duration: f64,
    ) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError>;
}

/// Deviations of independent coordinates, the last of which are integrals of so many states.
fn unrestricted<const N: usize>(first_order: usize) -> DMatrix<f64> {
    let kept: Vec<usize> = (0..N - first_order).chain(N..2 * N).collect();
    DMatrix::identity(2 * N, 2 * N).select_columns(&kept)
}

/// Returns whether a matrix holds the deviations of a flow of N coordinates.
fn fits<Flow: TangentFlow<N>, const N: usize>(deviations: &DMatrix<f64>) -> Result<(), AnalysisError> {
    for (expected, found) in [(2 * N, deviations.nrows()), (Flow::DEVIATIONS, deviations.ncols())] {
        if found != expected {
            return Err(AnalysisError::Dimension { expected, found });
        }
    }
    Ok(())
}

/// A [`TangentFlow`] by [`Variational`] equations: `T = N (1 + D)` coordinates for D deviations, so `N (1 + 2N)` for
/// all of them.
///
/// ```
/// use lagrange_runtime::analysis::{ByVariationalEquations, fundamental_matrix};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Oscillator {
///         param omega;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * (omega * x).powi(2);
///     }
/// }
/// let oscillator = Oscillator::new(2.0);
/// let start = State::new(0.0, [0.3], [0.0]);
/// let (_, matrix) = fundamental_matrix(&ByVariationalEquations::<_, 3>::new(&oscillator, 1e-12), &start, 1.0)?;
/// assert!((matrix[(0, 0)] - 2.0f64.cos()).abs() < 1e-11 && (matrix[(0, 1)] - 2.0f64.sin() / 2.0).abs() < 1e-11);
/// // By another method.
/// let verner = ByVariationalEquations::<_, 3, _, _>::with(&oscillator, Verner9, PiController::tolerance(1e-12));
/// assert!((fundamental_matrix(&verner, &start, 1.0)?.1 - matrix).amax() < 1e-11);
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ByVariationalEquations<'a, Sys, const T: usize, M = Dop853, C = PiController> {
    system: &'a Sys,
    method: M,
    controller: C,
}

impl<'a, Sys, const T: usize> ByVariationalEquations<'a, Sys, T> {
    /// Integrates by DOP853 with an absolute and relative tolerance, which holds for the deviations too. The absolute
    /// one is in the units of each component of q and q̇.
    pub fn new(system: &'a Sys, tolerance: f64) -> Self {
        Self::with(system, Dop853, PiController::tolerance(tolerance))
    }
}

impl<'a, Sys, const T: usize, M, C> ByVariationalEquations<'a, Sys, T, M, C> {
    /// Integrates by a method and with a controller, as in [`integrate`].
    pub fn with(system: &'a Sys, method: M, controller: C) -> Self {
        ByVariationalEquations { system, method, controller }
    }
}

impl<'a, Sys, M, C, const N: usize, const T: usize> TangentFlow<N>
    for ByVariationalEquations<'a, Sys, T, M, C>
where
    Sys: Lagrangian<N, Scalar = f64> + Rescale<N>,
    M: Method<Variational<'a, Sys, N>, T> + Clone,
    C: Controller<f64, T, M::Error> + Clone,
{
    const DEVIATIONS: usize = T / N - 1;
    const AUTONOMOUS: bool = Sys::AUTONOMOUS;
    const FIRST_ORDER: usize = Sys::FIRST_ORDER;
    const ATTITUDES: &'static [usize] = Sys::ATTITUDES;

    fn accel(&self, at: &State<f64, N>) -> SVector<f64, N> {
        self.system.accel(&at.q, &at.qd, at.t)
    }

    fn admissible(&self, at: &State<f64, N>) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError> {
        let at = self.system.restored(at)?.map_or(*at, |restored| restored.state);
        let all = || unrestricted::<N>(Sys::FIRST_ORDER);
        Ok((at, deviations(self.system, &at)?.unwrap_or_else(all)))
    }

    fn follow(
        &self,
        start: &State<f64, N>,
        deviations: &DMatrix<f64>,
        duration: f64,
    ) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError> {
        fits::<Self, N>(deviations)?;
        let component = |i: usize, own: &SVector<f64, N>, row: usize| {
            if i < N { own[i] } else { deviations[(row + i % N, i / N - 1)] }
        };
        let from = State {
            t: start.t,
            q: SVector::from_fn(|i, _| component(i, &start.q, 0)),
            qd: SVector::from_fn(|i, _| component(i, &start.qd, N)),
        };
        ends_at_switches::<Variational<Sys, N>, M, C, T>(&self.method, &self.controller)?;
        let all = Variational::new(self.system);
        let run = integrate(&all, self.method.clone(), self.controller.clone(), from);
        let end: State<f64, T> =
            run.until(start.t + duration).final_state().map_err(|failed| failed.failure)?;
        let at = part(&end, 0);
        let matrix = DMatrix::from_fn(2 * N, deviations.ncols(), |i, d| {
            let first = N * (1 + d);
            if i < N { end.q[first + i] } else { end.qd[first + i - N] }
        });
        Ok((at, matrix))
    }
}

/// A [`TangentFlow`] by the derivatives of every step, in a system over [`Gradient`]s of D directions, 2N for all
/// deviations.
///
/// Taylor series of gradients are those of the variational equations: the recurrences of `qₖ` differentiated, order
/// by order (Biscani and Izzo, *MNRAS* 504, 2021, 2614, section 2.4; Gröbner 1960). So the derivative is as accurate
/// as the motion, and nothing is linearized but elementary operations.
///
/// ```
/// use lagrange_runtime::Gradient;
/// use lagrange_runtime::analysis::{ByGradients, fundamental_matrix};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Oscillator {
///         param omega;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * (omega * x).powi(2);
///     }
/// }
/// // The system over gradients by two directions, x and ẋ at the start.
/// let oscillator = Oscillator::new(2.0).map(Gradient::<_, 2>::constant);
/// let start = State::new(0.0, [0.3], [0.0]);
/// let (_, matrix) = fundamental_matrix(&ByGradients::new(oscillator, 1e-15), &start, 1.0)?;
/// assert!((matrix[(0, 0)] - 2.0f64.cos()).abs() < 1e-14 && (matrix[(0, 1)] - 2.0f64.sin() / 2.0).abs() < 1e-14);
/// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ByGradients<Sys, M = Taylor, C = TaylorController> {
    system: Sys,
    method: M,
    controller: C,
}

impl<Sys> ByGradients<Sys> {
    /// Integrates by Taylor series with an absolute and relative tolerance, which holds for the derivatives too. The
    /// absolute one is in the units of each component of q and q̇.
    pub fn new(system: Sys, tolerance: f64) -> Self {
        Self::with(system, Taylor, TaylorController::tolerance(tolerance))
    }
}

impl<Sys, M, C> ByGradients<Sys, M, C> {
    /// Integrates by a method and with a controller, as in [`integrate`].
    pub fn with(system: Sys, method: M, controller: C) -> Self {
        ByGradients { system, method, controller }
    }
}

impl<Sys, M, C, const N: usize, const D: usize> TangentFlow<N> for ByGradients<Sys, M, C>
where
    Sys: System<N, Scalar = Gradient<f64, D>>,
    M: Method<Sys, N> + Clone,
    C: Controller<Gradient<f64, D>, N, M::Error> + Clone,
{
    const DEVIATIONS: usize = D;
    const AUTONOMOUS: bool = Sys::AUTONOMOUS;
    const FIRST_ORDER: usize = Sys::FIRST_ORDER;
    const ATTITUDES: &'static [usize] = Sys::ATTITUDES;

    fn accel(&self, at: &State<f64, N>) -> SVector<f64, N> {
        let State { t, q, qd } = at.map(Gradient::constant);
        self.system.accel(&q, &qd, t).map(|x| x.value)
    }

    fn admissible(&self, at: &State<f64, N>) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError> {
        let over = at.map(Gradient::constant);
        let restored = self.system.restored(&over).map_err(|failure| failure.map(|x| x.value))?;
        let at = restored.map_or(over, |restored| restored.state).map(|x| Gradient::constant(x.value));
        let all = || unrestricted::<N>(Sys::FIRST_ORDER);
        Ok((at.map(|x| x.value), deviations(&self.system, &at)?.unwrap_or_else(all)))
    }

    fn follow(
        &self,
        start: &State<f64, N>,
        deviations: &DMatrix<f64>,
        duration: f64,
    ) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError> {
        fits::<Self, N>(deviations)?;
        let suitable = ends_at_switches::<Sys, M, C, N>(&self.method, &self.controller);
        suitable.map_err(|failure| failure.map(|x| x.value))?;
        let slopes = |row: usize| core::array::from_fn(|d| deviations[(row, d)]);
        let mut from = start.map(Gradient::constant);
        for i in 0..N {
            (from.q[i].slopes, from.qd[i].slopes) = (slopes(i), slopes(N + i));
        }
        let run = integrate(&self.system, self.method.clone(), self.controller.clone(), from);
        let end = run.until(Gradient::constant(start.t + duration)).final_state();
        let end = end.map_err(|failed| failed.failure.map(|x| x.value))?;
        let end: State<_, N> = self.system.toward_constraints(&end);
        let matrix = DMatrix::from_fn(2 * N, D, |i, d| {
            let number = if i < N { end.q[i] } else { end.qd[i - N] };
            number.slopes[d]
        });
        Ok((end.map(|x| x.value), matrix))
    }
}

/// The end of a motion of this duration, in units of t, and its derivative by the start: the matrix `∂(q, q̇)(end)/∂(q,
/// q̇)(start)`, `2N × 2N`. With constraints it maps the deviations that they admit, and is 0 on deviations orthogonal
/// to these.
///
/// # Errors
/// [`AnalysisError::Run`], [`AnalysisError::DependentConstraints`].
pub fn fundamental_matrix<Flow: TangentFlow<N>, const N: usize>(
    flow: &Flow,
    start: &State<f64, N>,
    duration: f64,
) -> Result<(State<f64, N>, DMatrix<f64>), AnalysisError> {
    const { assert!(Flow::DEVIATIONS == 2 * N, "a fundamental matrix takes 2N deviations") };
    let (_, basis) = flow.admissible(start)?;
    let admitted = match basis.ncols() == 2 * N - Flow::FIRST_ORDER {
        true => DMatrix::identity(2 * N, 2 * N),
        false => &basis * basis.transpose(),
    };
    flow.follow(start, &admitted, duration)
}

/// Sensitivity of a motion to parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity<const N: usize, const D: usize> {
    /// The end of the motion.
    pub end: State<f64, N>,
    /// Its derivatives (∂q/∂p, ∂q̇/∂p) by each parameter, in the order given.
    pub slopes: [Tangent<f64, N>; D],
}

/// The end of a motion and its derivatives by parameters, by gradients through every step: `family` makes the system
/// with the parameters' values. `s = ∂x/∂p` is the solution of `ṡ = (∂f/∂x) s + ∂f/∂p` from `s(0) = 0`, where no
/// parameter moves a constraint (Hairer, Nørsett and Wanner, I.14).
///
/// ```
/// use lagrange_runtime::analysis::{Sensitivity, sensitivity};
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     system Oscillator {
///         param omega;
///         coord x;
///         T = 0.5 * dot(x).powi(2);
///         V = 0.5 * (omega * x).powi(2);
///     }
/// }
/// let (start, family) = (State::new(0.0, [1.0], [0.0]), |[omega]: [_; 1]| Oscillator { omega });
/// let (method, control) = (Taylor, TaylorController::tolerance(1e-15));
/// let Sensitivity { end, slopes: [slope] } = sensitivity(family, [2.0], method, control, &start, 3.0)?;
/// assert!((end.q[0] - 6.0f64.cos()).abs() < 1e-14 && (slope.q[0] + 3.0 * 6.0f64.sin()).abs() < 1e-13);
/// # Ok::<(), Failure>(())
/// ```
///
/// A parameter that moves a constraint moves the start with it: by the smallest change, measured by the inertia
/// matrix, that keeps it on the constraints.
///
/// # Errors
/// That of the run; [`Failure::ConstraintViolated`] where no state on the constraints is near the start.
pub fn sensitivity<Sys, M, C, const N: usize, const D: usize>(
    family: impl Fn([Gradient<f64, D>; D]) -> Sys,
    parameters: [f64; D],
    method: M,
    controller: C,
    start: &State<f64, N>,
    duration: f64,
) -> Result<Sensitivity<N, D>, Failure>
where
    Sys: System<N, Scalar = Gradient<f64, D>>,
    M: Method<Sys, N>,
    C: Controller<Gradient<f64, D>, N, M::Error>,
{
    ends_at_switches::<Sys, M, C, N>(&method, &controller).map_err(|failure| failure.map(|x| x.value))?;
    let system = family(Gradient::variables(parameters));
    let from = start.map(Gradient::constant);
    let from = match system.restored(&from).map_err(|failure| failure.map(|x| x.value))? {
        Some(restored) => system.toward_constraints(&restored.state),
        None => from,
    };
    let run = integrate(&system, method, controller, from);
    let end = run.until(Gradient::constant(start.t + duration)).final_state();
    let end = end.map_err(|failed| failed.failure.map(|x| x.value))?;
    let end = system.toward_constraints(&end);
    let slopes = core::array::from_fn(|d| {
        let part = end.map(|x| x.slopes[d]);
        Tangent { q: part.q, qd: part.qd }
    });
    Ok(Sensitivity { end: end.map(|x| x.value), slopes })
}
