//! Step-size laws with more memory than [`PiController`]'s: PI and PID controllers and digital filters with published
//! constants.

use super::{AbsoluteTolerance, Controller, ErrorEstimate, FirstStep, LEAST, PiController, Verdict};
use crate::failure::Failure;
use crate::scalar::{Functions, Real};
use crate::state::{State, Tangent};

/// The general recursive step-size law (Söderlind, "Digital filters in adaptive time-stepping", *ACM Transactions on
/// Mathematical Software* 29, 2003, eq. 43; Söderlind and Wang, *Journal of Computational and Applied Mathematics*
/// 185, 2006, table 1): with the errors `eₙ` over the tolerance, p the order and `ε = 0.9ᵖ` the error aimed at,
///
/// `hₙ₊₁/hₙ = (ε/eₙ)^(β₁/p) (ε/eₙ₋₁)^(β₂/p) (ε/eₙ₋₂)^(β₃/p) (hₙ/hₙ₋₁)^(−α₂) (hₙ₋₁/hₙ₋₂)^(−α₃)`.
///
/// Filters ([`h211b`](Self::h211b), [`h312b`](Self::h312b)) make step sequences smooth, and with them the error as a
/// function of the tolerance; [`pi42`](Self::pi42) reacts faster and is for steps that stability limits. For most
/// purposes [`PiController`] is as good. Norm, limits of the ratio and what follows a rejection are those of
/// [`PiController`].
///
/// ```
/// use lagrange_runtime::{PidController, prelude::*};
/// # struct Oscillator;
/// # impl System<1> for Oscillator {
/// #     type Scalar = f64;
/// #     fn accel(&self, q: &SVector<f64, 1>, _: &SVector<f64, 1>, _: f64) -> SVector<f64, 1> {
/// #         -q
/// #     }
/// # }
/// let start = State::new(0.0, [1.0], [0.0]);
/// let end = integrate(&Oscillator, Dop853, PidController::h211b(PiController::tolerance(1e-9)), start).until(10.0).final_state()?;
/// assert!((end.q[0] - 10f64.cos()).abs() < 1e-8);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PidController<A = f64> {
    /// Tolerances, first step and limits.
    pi: PiController<A>,
    beta: [f64; 3],
    alpha: [f64; 2],
    /// `ln eₙ₋₁/ε` and `ln eₙ₋₂/ε`.
    errors: [f64; 2],
    /// `ln hₙ/hₙ₋₁` and `ln hₙ₋₁/hₙ₋₂`.
    ratios: [f64; 2],
}

macro_rules! laws {
    ($($(#[$doc:meta])* $name:ident [$($beta:expr),*] [$($alpha:expr),*];)*) => {
        impl<A: Copy> PidController<A> {
            $(
                $(#[$doc])*
                pub const fn $name(pi: PiController<A>) -> Self {
                    PidController::new(pi, [$($beta),*], [$($alpha),*])
                }
            )*
        }
    };
}

laws! {
    /// The elementary controller, `β = 1`: each step as long as its error would have allowed.
    elementary [1.0, 0.0, 0.0] [0.0, 0.0];
    /// PI 4.2 (Söderlind 2003; Söderlind and Wang 2006), `β = (3/5, −1/5)`.
    pi42 [0.6, -0.2, 0.0] [0.0, 0.0];
    /// PI 3.3 (Söderlind 2003; Söderlind and Wang 2006), `β = (2/3, −1/3)`.
    pi33 [2.0 / 3.0, -1.0 / 3.0, 0.0] [0.0, 0.0];
    /// PI 3.4 (Gustafsson 1991), `β = (7/10, −2/5)`.
    pi34 [0.7, -0.4, 0.0] [0.0, 0.0];
    /// The first-order filter H211b with b = 4 (Söderlind 2003), `β = (1/4, 1/4)`, `α₂ = 1/4`.
    h211b [0.25, 0.25, 0.0] [0.25, 0.0];
    /// The filter H211 PI (Söderlind 2003), `β = (1/6, 1/6)`.
    h211_pi [1.0 / 6.0, 1.0 / 6.0, 0.0] [0.0, 0.0];
    /// The second-order filter H312b with b = 8 (Söderlind 2003), `β = (1/8, 1/4, 1/8)`, `α = (3/8, 1/8)`.
    h312b [0.125, 0.25, 0.125] [0.375, 0.125];
    /// The filter H312 PID (Söderlind 2003), `β = (1/18, 1/9, 1/18)`.
    h312_pid [1.0 / 18.0, 1.0 / 9.0, 1.0 / 18.0] [0.0, 0.0];
}

impl<A: Copy> PidController<A> {
    /// The law with the given `(β₁, β₂, β₃)` and `(α₂, α₃)`, and with the tolerances, the first step and the limits
    /// of `pi`.
    pub const fn new(pi: PiController<A>, beta: [f64; 3], alpha: [f64; 2]) -> Self {
        PidController { pi, beta, alpha, errors: [0.0; 2], ratios: [0.0; 2] }
    }
}

impl<A> PidController<A> {
    /// Tolerances and norm.
    #[inline(always)]
    pub(crate) fn tolerances(&self) -> &PiController<A> {
        &self.pi
    }

    /// Verdict from the square of an error.
    #[inline]
    pub(crate) fn decide(&mut self, square: f64, order: u32) -> Verdict {
        let size = Functions::sqrt(square);
        let PiController { safety, smallest, largest, most, .. } = self.pi;
        if !size.is_finite() {
            self.pi.most = 1.0;
            self.ratios[0] += Functions::ln(smallest);
            return Verdict::Reject { factor: smallest };
        }
        let p = f64::from(order);
        let ln_size = Functions::ln(size.max(LEAST));
        if size > 1.0 {
            self.pi.most = 1.0;
            let factor = (safety * Functions::exp(-ln_size / p)).max(smallest).min(safety);
            self.ratios[0] += Functions::ln(factor);
            return Verdict::Reject { factor };
        }
        let ln_error = ln_size - p * Functions::ln(safety);
        let [beta, alpha] = [&self.beta[..], &self.alpha[..]];
        let errors = beta[0] * ln_error + beta[1] * self.errors[0] + beta[2] * self.errors[1];
        let ratios = alpha[0] * self.ratios[0] + alpha[1] * self.ratios[1];
        let factor = Functions::exp(-errors / p - ratios).max(smallest).min(most);
        self.pi.most = largest;
        self.errors = [ln_error, self.errors[0]];
        self.ratios = [Functions::ln(factor), self.ratios[0]];
        Verdict::Accept { factor }
    }
}

impl<S, A, E, const N: usize> Controller<S, N, E> for PidController<A>
where
    S: Real,
    A: AbsoluteTolerance<N>,
    E: ErrorEstimate<S, N>,
{
    const EQUAL_STEPS: Option<bool> = Some(false);

    fn first_step(&self) -> FirstStep<S> {
        Controller::<S, N, E>::first_step(&self.pi)
    }

    fn with_first_step(&self, h: f64) -> Option<Self> {
        Some(PidController { pi: PiController::first_step(self.pi, h), ..*self })
    }

    fn check(&self) -> Result<(), Failure<S>> {
        Controller::<S, N, E>::check(&self.pi)
    }

    #[inline(always)]
    fn max_step(&self) -> f64 {
        Controller::<S, N, E>::max_step(&self.pi)
    }

    fn norm(&self, difference: &Tangent<S, N>, a: &State<S, N>, b: &State<S, N>) -> f64 {
        Controller::<S, N, E>::norm(&self.pi, difference, a, b)
    }

    #[inline]
    fn judge(&mut self, from: &State<S, N>, to: &State<S, N>, error: &E, order: u32) -> Verdict {
        let square = self.pi.square(S::to_f64, from, to, error);
        self.decide(square, order)
    }

    fn after_failure(&mut self) -> Option<f64> {
        self.pi.most = 1.0;
        self.ratios[0] += Functions::ln(self.pi.smallest);
        Some(self.pi.smallest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::integrate;
    use crate::method::explicit_rk::{Dop853, DormandPrince5, Tsitouras5, Verner9};
    use crate::system::System;
    use crate::testing::bank::*;
    use crate::testing::reference::SimplePendulum;
    use crate::testing::{distance, slope};
    use nalgebra::SVector;

    const LAWS: [fn(PiController) -> PidController; 8] = [
        PidController::elementary,
        PidController::pi42,
        PidController::pi33,
        PidController::pi34,
        PidController::h211b,
        PidController::h211_pi,
        PidController::h312b,
        PidController::h312_pid,
    ];

    /// In a model of a step whose error is `(h/H)ᵖ` with constant H, the step settles at `h = 0.9 H` from any start:
    /// every law is stable, and aims at the same error.
    #[test]
    fn every_law_settles_at_the_error_aimed_at() {
        for law in LAWS {
            for start in [0.3, 0.99] {
                let (mut h, mut law) = (start, law(PiController::tolerance(1.0).rtol(0.0)));
                for _ in 0..100 {
                    let at = State::new(0.0, [0.0], [0.0]);
                    let size = Functions::powf(h, 5.0);
                    let error = Tangent { q: [size].into(), qd: [size].into() };
                    match Controller::<f64, 1, _>::judge(&mut law, &at, &at, &error, 5) {
                        Verdict::Accept { factor } | Verdict::Reject { factor } => h *= factor,
                    }
                }
                assert!((h - 0.9).abs() < 1e-6, "{law:?}: {h}");
            }
        }
    }

    /// The elementary law swings about the limit where stability limits the step, and the other PI laws find it
    /// (Hairer and Wanner 1996, IV.2).
    #[test]
    fn steps_are_smooth_where_stability_limits_them() {
        struct Stiff;
        impl System<1> for Stiff {
            type Scalar = f64;
            fn accel(&self, q: &SVector<f64, 1>, qd: &SVector<f64, 1>, t: f64) -> SVector<f64, 1> {
                -qd * 200.0 - q * 200.0 + SVector::from([200.0 * t.sin()])
            }
        }
        let roughness = |law: fn(PiController) -> PidController| {
            let start = State::new(0.0, [0.5], [0.0]);
            let run =
                integrate(&Stiff, DormandPrince5, law(PiController::tolerance(1e-4)), start).until(10.0);
            let steps: Vec<f64> = run.map(|step| step.unwrap().h).collect();
            let late = &steps[steps.len() / 2..steps.len() - 2];
            late.windows(2).map(|h| (h[1] / h[0]).ln().abs()).sum::<f64>() / late.len() as f64
        };
        let elementary = roughness(PidController::elementary);
        for law in [PidController::pi42, PidController::pi33, PidController::pi34] {
            assert!(roughness(law) < 0.5 * elementary, "{elementary} {}", roughness(law));
        }
    }

    /// The largest error on the way follows the tolerance: on smooth motions the slope of its logarithm is 1 ± 0.15.
    #[test]
    fn errors_are_proportional_to_tolerances() {
        let swing = SimplePendulum::new(1.0, 1.0, 1.5, 0.0);
        let pendulum = |t: f64| {
            let (theta, thetad) = swing.state(t);
            State::new(t, [theta], [thetad])
        };
        macro_rules! proportional {
            ($method:ident, $controller:expr) => {{
                macro_rules! on {
                    ($system:expr, $exact:expr) => {{
                        let system = $system;
                        let error = |tolerance: f64| {
                            let run =
                                integrate(&system, $method, $controller(tolerance), $exact(0.0)).until(10.0);
                            let errors = run
                                .map(|step| step.map(|step| distance(&step.to, &$exact(step.to.t))).unwrap());
                            (tolerance, errors.fold(0.0, f64::max))
                        };
                        let each = if crate::long() { 1 } else { 2 };
                        let exponents = (0..=20).step_by(each).map(|k| -6.0 - 0.25 * f64::from(k));
                        let tolerances = exponents.map(|exponent| Functions::powf(10.0, exponent));
                        let slope = slope(tolerances.map(error), 0.0);
                        let names = [stringify!($method), stringify!($system)];
                        assert!((0.85..1.15).contains(&slope), "{names:?}: {slope}");
                    }};
                }
                on!(Plane::default(), ellipse);
                // On the pendulum, Tsitouras5's terms of order 5 nearly cancel: its error falls faster than the
                // tolerance.
                if crate::long() && stringify!($method) != "Tsitouras5" {
                    on!(Pendulum::default(), pendulum);
                }
            }};
        }
        for law in LAWS {
            let law = |tolerance| law(PiController::tolerance(tolerance));
            proportional!(DormandPrince5, law);
            proportional!(Tsitouras5, law);
            proportional!(Dop853, law);
            proportional!(Verner9, law);
        }
        proportional!(DormandPrince5, PiController::tolerance);
        proportional!(Tsitouras5, PiController::tolerance);
        proportional!(Dop853, PiController::tolerance);
        proportional!(Verner9, PiController::tolerance);
    }
}
