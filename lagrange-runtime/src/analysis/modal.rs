//! A system kept to some of its modes about an equilibrium.

use super::equilibrium::resting;
use super::{AnalysisError, LinearModel, SmallMotion, Stability, StateSpace};
use crate::attitude;
use crate::choice::{self, RecommendedMethods};
use crate::input::{InputJacobian, Inputs};
use crate::state::State;
use crate::system::{
    Autonomous, Conservative, ConstantInertia, Facts, Independent, Jacobian, Lagrangian, LegendreTransform,
    Linear, Linearization, Linearize, Separable, System, lagrangian_functions, pass_on,
};
use nalgebra::{DMatrix, SMatrix, SVector};

/// A system of `WHOLE` coordinates about an equilibrium q₀, kept to `R` of its modes (modal truncation; Rayleigh, *The
/// Theory of Sound* I, 1877, ch. IV–V; Craig and Kurdila, *Fundamentals of Structural Dynamics*, 2006, ch. 11).
///
/// With the mode shapes that are kept as the columns of Φ, `WHOLE × R`, `Φᵀ M Φ = 1` and `Φᵀ K Φ = Λ = diag(ωₖ²)`, it
/// has the coordinates η of `q = q₀ + Φ η + S (u − u₀)`, and the equations
///
/// `η̈ + Φᵀ C Φ η̇ + Λ η = Φᵀ B (u − u₀)`,
///
/// in which C is damping and gyroscopic terms together, as a full matrix: it may couple the modes that are kept, and
/// what couples them with the others is left out ([`coupling`](Self::coupling) says how much that is). η has the unit
/// of q times the root of the unit of M (m kg^½), ωₖ² the unit 1/s².
///
/// The equations are [`Linear`] and [`Autonomous`]: [`MatrixExponential`](crate::MatrixExponential) propagates them
/// exactly in one step of any length. The energy is conserved where that of the system is. Every run,
/// [`Stepper`](crate::Stepper) and study takes the model; [`restrict`](Self::restrict) and [`lift`](Self::lift) lead
/// there and back. How good it is, over a scene, says a `Certification`, and
/// [`InRange`](crate::lanes::InRange) watches how large η becomes in a run.
///
/// With inputs u ([`with_inputs`](Self::with_inputs)), B = M ∂q̈/∂u, and the modes that are left out follow them as in
/// statics: `S = Σ φₖ φₖᵀ B / ωₖ²` over these modes (static correction, or mode-acceleration method; Craig and Kurdila
/// 2006, ch. 11). So a deflection at rest under a constant load is exact for every R, but for round-off in the lowest
/// modes: ωₖ² is known to the rounding of the largest one of all modes, and counts as 0 below that. Velocities that are
/// lifted are Φ η̇, without the rate at which S follows a load that changes.
///
/// ```
/// use lagrange_runtime::analysis::ModalModel;
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// Equal masses between springs, the ends held.
///     pub system Chain {
///         const N = 12;
///         param m, k;
///         coord x: [length; N];
///         T = (0..N).map(|i| 0.5 * m * dot(x[i]).powi(2)).sum();
///         V = 0.5 * k * (x[0].powi(2) + x[N - 1].powi(2)) + (1..N).map(|i| 0.5 * k * (x[i] - x[i - 1]).powi(2)).sum();
///     }
/// }
/// let chain = Chain::new(0.5, 200.0);
/// let model = ModalModel::<_, 12, 3>::about(&chain, &[0.0; 12])?;
/// // ωₖ = 2 √(k/m) sin(k π / (2 (N + 1)))
/// assert!((model.frequencies()[1] - 40.0 * (std::f64::consts::PI / 13.0).sin()).abs() < 1e-12);
///
/// // A parabola has most of its energy in the first mode, and 0.18 % in those that are left out.
/// let pulled = State::new(0.0, std::array::from_fn(|i| 1e-3 * ((i + 1) * (12 - i)) as f64), [0.0; 12]);
/// let (start, left) = model.restrict(&pulled);
/// assert!((left.part() - 1.758e-3).abs() < 1e-6);
/// let end = integrate(&model, MatrixExponential, FixedStep::new(10.0), start).until(10.0).final_state()?;
/// let whole = integrate(&chain, Dop853, PiController::tolerance(1e-10), pulled).until(10.0).final_state()?;
/// assert!((model.lift(&end).q - whole.q).amax() < 0.012 * pulled.q.amax());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ModalModel<Sys, const WHOLE: usize, const R: usize, const K: usize = 0> {
    whole: Sys,
    /// q₀
    place: SVector<f64, WHOLE>,
    /// Φ
    shapes: SMatrix<f64, WHOLE, R>,
    /// Φᵀ M
    weights: SMatrix<f64, R, WHOLE>,
    all: Shapes,
    kept: [usize; R],
    equations: LinearModel<R>,
    /// Φᵀ B
    by_inputs: SMatrix<f64, R, K>,
    /// S
    statics: SMatrix<f64, WHOLE, K>,
    /// u₀
    at_rest: SVector<f64, K>,
    /// u − u₀
    raised: SVector<f64, K>,
}

/// All modes of a system, in all of its coordinates.
#[derive(Clone, Debug, PartialEq)]
struct Shapes {
    /// ωₖ²
    squares: Vec<f64>,
    /// φₖ, by columns.
    shapes: DMatrix<f64>,
    /// φₖᵀ M, by rows.
    weights: DMatrix<f64>,
    /// `φᵢᵀ C φₖ`
    damping: DMatrix<f64>,
}

impl Shapes {
    /// `½ (ξ̇ₖ² + ωₖ² ξₖ²)` of a mode in a deviation.
    fn energy<const N: usize>(&self, k: usize, q: &SVector<f64, N>, qd: &SVector<f64, N>) -> f64 {
        let part = |x: &SVector<f64, N>| self.weights.row(k).iter().zip(x).map(|(w, x)| w * x).sum::<f64>();
        0.5 * (part(qd).powi(2) + self.squares[k] * part(q).powi(2))
    }

    /// Indices of the modes that are not among these.
    fn others<'a>(&'a self, kept: &'a [usize]) -> impl Iterator<Item = usize> + 'a {
        (0..self.squares.len()).filter(|k| !kept.contains(k))
    }
}

/// The part of a state that a [`ModalModel`] does not have: the difference between the state and [`ModalModel::lift`]
/// of its projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remainder<const N: usize> {
    /// Deviations of the coordinates of the whole system.
    pub q: SVector<f64, N>,
    /// Deviations of their velocities.
    pub qd: SVector<f64, N>,
    /// Energy of the modes that are left out, `½ Σ (ξ̇ₖ² + ωₖ² ξₖ²)`, in J.
    pub energy: f64,
    /// Energy of all modes in the deviation from the equilibrium, that of the remainder included, in J.
    pub whole: f64,
}

impl<const N: usize> Remainder<N> {
    /// The part of the energy of small motions that is left out, from 0 to 1; 0 at rest in the equilibrium that belongs
    /// to the inputs. Not a number for a state that is none, or whose energy overflows.
    pub fn part(&self) -> f64 {
        if self.whole == 0.0 { 0.0 } else { self.energy / self.whole }
    }
}

fn rest<const N: usize>(q: SVector<f64, N>) -> State<f64, N> {
    State { t: 0.0, q, qd: SVector::zeros() }
}

impl<Sys, const WHOLE: usize, const R: usize> ModalModel<Sys, WHOLE, R>
where
    Sys: Linearize<WHOLE, Scalar = f64> + Clone,
{
    /// The model of the `R` modes of lowest frequency about the equilibrium `q`, which may be given to half its digits.
    /// Inputs, if the system has any, are held as they are.
    ///
    /// # Hypotheses
    /// - Those of [`small_vibrations`](super::small_vibrations): `q` is an equilibrium, and time does not appear.
    /// - K is symmetric and has no negative eigenvalue, and damping is nowhere negative. Modes with ω = 0 are modes as
    ///   others, rigid ones; higher orders along them (`V = −x⁴`) are not checked.
    /// - Constraints, if there are any, are between positions. The model moves on their tangent space: what it lifts is
    ///   on them to first order in η.
    /// - The system has R modes at least.
    ///
    /// # Errors
    /// Those of [`small_vibrations`](super::small_vibrations); [`AnalysisError::Circulatory`],
    /// [`AnalysisError::NegativeDamping`], [`AnalysisError::Unstable`]; [`AnalysisError::NotApplicable`] where one of
    /// the last two hypotheses does not hold.
    pub fn about(system: &Sys, q: &[f64; WHOLE]) -> Result<Self, AnalysisError> {
        Self::of_modes(system, q, std::array::from_fn(|k| k))
    }

    /// The model of these modes, by their indices in [`Modes`](super::Modes), the lowest frequency being number 0.
    ///
    /// # Errors
    /// Those of [`about`](Self::about); [`AnalysisError::NotApplicable`] unless each index is that of a mode, and given
    /// once.
    pub fn of_modes(system: &Sys, q: &[f64; WHOLE], kept: [usize; R]) -> Result<Self, AnalysisError> {
        let found = resting(system, q)?;
        let small = &found.small;
        if !small.constants().is_empty() {
            let needs =
                "constraints between positions: of one between velocities the coordinates do not follow";
            return Err(AnalysisError::NotApplicable { needs });
        }
        let modes = small.modes_of_potential()?;
        if !matches!(small.energy_criterion()?, Stability::Stable | Stability::Neutral { .. }) {
            return Err(AnalysisError::Unstable { square: modes.squares()[0] });
        }
        let is_mode = |i: usize| kept[i] < modes.len() && !kept[..i].contains(&kept[i]);
        if R == 0 || !(0..R).all(is_mode) {
            let needs = "modes that the system has, one at least and each of them once";
            return Err(AnalysisError::NotApplicable { needs });
        }
        let minimal =
            DMatrix::from_columns(&(0..modes.len()).map(|k| modes.normalized(k)).collect::<Vec<_>>());
        let damping = minimal.tr_mul(&(small.velocity_terms() * &minimal));
        let squares = modes.squares().to_vec();
        let reduced = SmallMotion::new(
            DMatrix::identity(R, R),
            damping.select_columns(&kept).select_rows(&kept),
            DMatrix::from_fn(R, R, |i, j| if i == j { squares[kept[i]] } else { 0.0 }),
        )?;
        let at = rest(found.q);
        let inertia = system.inertia(&at.q, &at.qd, at.t);
        let inertia = DMatrix::from_fn(WHOLE, WHOLE, |i, j| inertia[(i, j)]);
        let shapes = small.basis() * minimal;
        let weights = shapes.tr_mul(&inertia);
        Ok(ModalModel {
            whole: system.clone(),
            place: found.q,
            shapes: SMatrix::from_fn(|i, k| shapes[(i, kept[k])]),
            weights: SMatrix::from_fn(|k, i| weights[(kept[k], i)]),
            all: Shapes { squares, shapes, weights, damping },
            kept,
            equations: LinearModel::new(&reduced)?,
            by_inputs: SMatrix::zeros(),
            statics: SMatrix::zeros(),
            at_rest: SVector::zeros(),
            raised: SVector::zeros(),
        })
    }

    /// The model with the inputs of the system, which act on the modes that are kept, and in statics on the others.
    ///
    /// # Hypotheses
    /// - Those of [`StateSpace::about`].
    /// - No input acts on a rigid mode that is left out: it has no deflection at rest.
    ///
    /// # Errors
    /// Those of [`StateSpace::about`]; [`AnalysisError::NotApplicable`] where the last hypothesis does not hold.
    ///
    /// ```
    /// use lagrange_runtime::analysis::ModalModel;
    /// use lagrange_runtime::prelude::*;
    /// lagrangian! {
    ///     /// Five masses on a string of springs, the last one pulled.
    ///     pub system Rail {
    ///         const N = 5;
    ///         param k;
    ///         input pull;
    ///         coord x: [length; N];
    ///         T = (0..N).map(|i| 0.5 * dot(x[i]).powi(2)).sum();
    ///         V = 0.5 * k * x[0].powi(2) + (1..N).map(|i| 0.5 * k * (x[i] - x[i - 1]).powi(2)).sum();
    ///         D = (0..N).map(|i| 0.5 * dot(x[i]).powi(2)).sum();
    ///         Q[x[N - 1]] = pull;
    ///     }
    /// }
    /// let mut model = ModalModel::<_, 5, 2>::about(&Rail::new(10.0), &[0.0; 5])?.with_inputs()?;
    /// model.set_inputs(&[3.0].into());
    /// let start = State::new(0.0, [0.0; 2], [0.0; 2]);
    /// let end = integrate(&model, MatrixExponential, FixedStep::new(100.0), start).until(100.0).final_state()?;
    /// // Each spring is pulled by 3 N.
    /// let at_rest = model.lift(&end).q;
    /// assert!((0..5).all(|i| (at_rest[i] - 0.3 * (i as f64 + 1.0)).abs() < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_inputs<const K: usize>(self) -> Result<ModalModel<Sys, WHOLE, R, K>, AnalysisError>
    where
        Sys: InputJacobian<WHOLE, K>,
    {
        let at = rest(self.place);
        StateSpace::about(&self.whole, &at)?;
        let by = self.whole.input_jacobian(&at.q, &at.qd, at.t);
        let by = DMatrix::from_fn(WHOLE, K, |i, j| by[(i, j)]);
        let forces = &self.all.weights * &by;
        let sizes = self.all.weights.abs() * by.abs();
        let mut statics = SMatrix::<f64, WHOLE, K>::zeros();
        for k in self.all.others(&self.kept) {
            let square = self.all.squares[k];
            for j in 0..K {
                match forces[(k, j)] {
                    force if force.abs() <= sizes[(k, j)] * ROUNDING => (),
                    _ if square == 0.0 => {
                        let needs =
                            "every rigid mode that an input acts on: it has no deflection at rest, keep it";
                        return Err(AnalysisError::NotApplicable { needs });
                    }
                    force => {
                        (0..WHOLE).for_each(|i| statics[(i, j)] += self.all.shapes[(i, k)] * force / square)
                    }
                }
            }
        }
        let ModalModel { whole, place, shapes, weights, all, kept, equations, .. } = self;
        let by_inputs = SMatrix::from_fn(|k, j| forces[(kept[k], j)]);
        let (at_rest, raised) = (whole.inputs(), SVector::zeros());
        Ok(ModalModel {
            whole,
            place,
            shapes,
            weights,
            all,
            kept,
            equations,
            by_inputs,
            statics,
            at_rest,
            raised,
        })
    }
}

/// Forces on modes up to this part of their terms are rounding.
const ROUNDING: f64 = 1e-13;

impl<Sys, const WHOLE: usize, const R: usize, const K: usize> ModalModel<Sys, WHOLE, R, K> {
    /// The system.
    pub fn whole(&self) -> &Sys {
        &self.whole
    }

    /// The equilibrium q₀, of length `WHOLE`, in the units of the coordinates.
    pub fn equilibrium(&self) -> &SVector<f64, WHOLE> {
        &self.place
    }

    /// Φ, `WHOLE × R`: the shapes of the kept modes, one per column, with `Φᵀ M Φ = 1`: in the units of q over the root
    /// of the unit of M (kg^−½ for lengths).
    pub fn shapes(&self) -> &SMatrix<f64, WHOLE, R> {
        &self.shapes
    }

    /// Angular frequencies ωₖ of the modes that are kept, without damping, in rad/s; 0 of rigid ones.
    pub fn frequencies(&self) -> [f64; R] {
        self.kept.map(|k| self.all.squares[k].sqrt())
    }

    /// The lowest angular frequency that is left out, in rad/s: inputs and loads have to be slower. `None` if no mode
    /// is left out. One that a mode which is kept has, too, says that the pair was split: such modes belong together,
    /// since any combination of them is a mode, and the smallest change of the system turns one into another.
    pub fn left_out(&self) -> Option<f64> {
        self.all.others(&self.kept).next().map(|k| self.all.squares[k].sqrt())
    }

    /// The largest amplitude, to first order, of a mode that is left out, relative to the kept one that moves it by
    /// damping and gyroscopic terms: `|cₗₖ s| / |ωₗ² − ωₖ² + i cₗₗ s|` with `cₗₖ = φₗᵀ C φₖ` and `s = ωₖ`, or `cₖₖ` of
    /// a rigid mode, which these slow down. 0 where C is diagonal in modes, as with Rayleigh's damping; what is not
    /// small beside 1 says that the modes belong together.
    pub fn coupling(&self) -> f64 {
        let Shapes { squares, damping, .. } = &self.all;
        let part = |l: usize, k: usize| {
            let s = if squares[k] > 0.0 { squares[k].sqrt() } else { damping[(k, k)].abs() };
            let force = damping[(l, k)].abs() * s;
            if force > 0.0 { force / (squares[l] - squares[k]).hypot(damping[(l, l)] * s) } else { 0.0 }
        };
        let pairs = self.all.others(&self.kept).flat_map(|l| self.kept.map(|k| part(l, k)));
        pairs.fold(0.0, f64::max)
    }

    /// The state of the whole system, `q = q₀ + Φ η + S (u − u₀)` and `q̇ = Φ η̇`.
    pub fn lift(&self, state: &State<f64, R>) -> State<f64, WHOLE> {
        let q = self.place + self.shapes * state.q + self.statics * self.raised;
        State { t: state.t, q, qd: self.shapes * state.qd }
    }
}

impl<Sys, const WHOLE: usize, const R: usize, const K: usize> ModalModel<Sys, WHOLE, R, K>
where
    Sys: System<WHOLE, Scalar = f64>,
{
    /// The state of the model that is nearest to one of the system, in the norm of M, `η = Φᵀ M (q − q₀)` and
    /// `η̇ = Φᵀ M q̇`, and the remainder. Where a state is beside the constraints, so are the coordinates of the
    /// remainder; its energy is that of admissible motions alone.
    pub fn restrict(&self, state: &State<f64, WHOLE>) -> (State<f64, R>, Remainder<WHOLE>) {
        // Attitudes by those parameters that are nearer to the equilibrium.
        let near = state.turned(attitude::steps::astray(Sys::ATTITUDES, state, &rest(self.place)));
        let moved = near.q - self.place - self.statics * self.raised;
        let kept = State { t: state.t, q: self.weights * moved, qd: self.weights * near.qd };
        let lifted = self.lift(&kept);
        let (q, qd) = (near.q - lifted.q, near.qd - lifted.qd);
        let others = self.all.others(&self.kept);
        let energy = others.map(|k| self.all.energy(k, &q, &qd)).fold(0.0, |sum, one| sum + one);
        let own = self.kept.iter().map(|&k| self.all.energy(k, &moved, &near.qd)).sum::<f64>();
        (kept, Remainder { q, qd, energy, whole: own + energy })
    }
}

type S = f64;
type V<const N: usize> = SVector<f64, N>;

impl<Sys, const WHOLE: usize, const N: usize, const K: usize> System<N> for ModalModel<Sys, WHOLE, N, K> {
    type Scalar = f64;
    const AUTONOMOUS: bool = true;

    pass_on! { equations: accel -> V<N>; }
}

impl<Sys, const WHOLE: usize, const N: usize, const K: usize> Lagrangian<N> for ModalModel<Sys, WHOLE, N, K>
where
    Sys: Lagrangian<WHOLE>,
{
    const FACTS: Facts = Facts {
        name: "modal truncation",
        inputs: if K == 0 { &[] } else { Sys::FACTS.inputs },
        conservative: Sys::FACTS.conservative,
        ..LinearModel::<N>::FACTS
    };

    lagrangian_functions! { pass_on! { equations: jacobian -> Jacobian<f64, N>; } }
}

impl<Sys, const WHOLE: usize, const N: usize, const K: usize> Inputs<N, K> for ModalModel<Sys, WHOLE, N, K>
where
    Sys: Inputs<WHOLE, K, Scalar = f64>,
{
    const INPUTS: [&'static str; K] = Sys::INPUTS;

    fn inputs(&self) -> SVector<f64, K> {
        self.whole.inputs()
    }

    fn set_inputs(&mut self, inputs: &SVector<f64, K>) {
        self.whole.set_inputs(inputs);
        self.raised = inputs - self.at_rest;
        self.equations.push(self.by_inputs * self.raised);
    }
}

/// `∂η̈/∂u = Φᵀ B`.
impl<Sys, const WHOLE: usize, const N: usize, const K: usize> InputJacobian<N, K>
    for ModalModel<Sys, WHOLE, N, K>
where
    Sys: Inputs<WHOLE, K, Scalar = f64>,
{
    fn input_jacobian(&self, _: &V<N>, _: &V<N>, _: f64) -> SMatrix<f64, N, K> {
        self.by_inputs
    }
}

/// Traits that the model has if its system has those behind `if`.
macro_rules! has {
    ($($trait:ident if $($own:ident)+ { $($item:item)* })*) => {$(
        #[diagnostic::do_not_recommend]
        impl<Sys, const WHOLE: usize, const N: usize, const K: usize> $trait<N>
            for ModalModel<Sys, WHOLE, N, K>
        where
            Sys: $($own<WHOLE> +)+,
        {
            $($item)*
        }
    )*};
}

has! {
    Linearize if Lagrangian {
        fn linearize(&self, q: &V<N>, qd: &V<N>, t: f64) -> Linearization<f64, N> {
            self.equations.linearize(q, qd, t)
        }
    }
    LegendreTransform if Lagrangian {
        fn velocities(&self, q: &V<N>, p: &V<N>, t: f64) -> V<N> {
            self.equations.velocities(q, p, t)
        }
    }
    Independent if Lagrangian {}
    ConstantInertia if Lagrangian {}
    Autonomous if Lagrangian {}
    Linear if Lagrangian {}
    Conservative if Conservative {}
    Separable if Separable {}
    RecommendedMethods if Lagrangian {
        type Accurate = choice::Accurate<false>;
        type Fine = choice::Fine<false, false>;
        type FineControl = choice::FineControl<false>;
        type Geometric = choice::Geometric<true, false, false>;
    }
}
