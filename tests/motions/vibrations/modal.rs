//! Systems kept to some of their modes, against closed forms and independent digits.

use crate::chain::{Chain, with_stack};
use crate::reference::off;
use crate::systems::{Cartesian, Damped, DoublePendulum, Follower, Plain, Shaken, Swing, TwoMasses};
use lagrange_runtime::analysis::*;
use lagrange_runtime::lanes::{FinalState, InRange};
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::LegendreTransform;
use lagrange_runtime::traits::{Autonomous, Conservative, Linear, Linearize, Separable};
use std::f64::consts::PI;

lagrangian! {
    /// Three wagons on a level track, the last one pulled.
    pub system Train {
        param k, c;
        input pull;
        coord x: [length; 3];
        T = (0..3).map(|i| 0.5 * dot(x[i]).powi(2)).sum();
        V = 0.5 * k * ((x[1] - x[0]).powi(2) + (x[2] - x[1]).powi(2));
        D = 0.5 * c * ((dot(x[1]) - dot(x[0])).powi(2) + (dot(x[2]) - dot(x[1])).powi(2));
        Q[x[2]] = pull;
    }
}

fn exactly<Sys, const N: usize>(model: &Sys, start: State<f64, N>, end: f64) -> State<f64, N>
where
    Sys: Linear<N, Scalar = f64> + Autonomous<N>,
{
    integrate(model, MatrixExponential, FixedStep::new(end), start).until(end).final_state().unwrap()
}

/// Standing waves of 200 masses between springs: x_i = Σ aⱼ sin(j i π / 201) cos ωⱼ t, ωⱼ = 2 √(k/m) sin(j π / 402).
#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn four_of_two_hundred_modes() {
    with_stack(|| {
        let (m, k) = (0.7, 3.1);
        let omega = |j: usize| 2.0 * (k / m).sqrt() * (j as f64 * PI / 402.0).sin();
        let waves = |amplitudes: [f64; 5], t: f64| -> [f64; 200] {
            let shape = |i: usize, j: usize| ((j * (i + 1)) as f64 * PI / 201.0).sin();
            let waves = amplitudes.into_iter().zip([1, 2, 3, 4, 7]);
            let wave = |i| move |(a, j): (f64, usize)| a * shape(i, j) * (omega(j) * t).cos();
            std::array::from_fn(|i| waves.clone().map(wave(i)).sum())
        };
        let model = ModalModel::<_, 200, 4>::about(&Chain::new(m, k), &[0.0; 200]).unwrap();
        let worst = (0..4).map(|j| off(model.frequencies()[j], omega(j + 1))).fold(0.0, f64::max);
        assert!(worst < 1e-15, "{worst:e}");
        assert!(off(model.left_out().unwrap(), omega(5)) < 1e-15);

        let amplitudes = [1.0, -0.5, 0.25, 2.0, 0.0];
        // Rounding of K turns shapes by ε ω²₂₀₀ / (ω₂² − ω₁²).
        let turned = f64::EPSILON * omega(200).powi(2) / (omega(2).powi(2) - omega(1).powi(2));
        let rounding = turned * amplitudes.map(f64::abs).iter().sum::<f64>();
        let (start, left) = model.restrict(&State::new(0.0, waves(amplitudes, 0.0), [0.0; 200]));
        assert!(left.q.amax() < rounding && left.part() < 1e-24, "{:e} {:e}", left.q.amax(), left.part());
        let end = exactly(&model, start, 100.0);
        let error = (model.lift(&end).q - SVector::from(waves(amplitudes, 100.0))).amax();
        assert!(error < rounding, "{error:e}");
        println!("four of 200 modes: frequencies off by {worst:.1e}, a motion over 100 by {error:.1e}");

        // The seventh wave is left out, with its energy ½ ω² a² m (N + 1) / 2, and the state but for it is the same.
        let amplitudes = [1.0, -0.5, 0.25, 2.0, 0.1];
        let (same, left) = model.restrict(&State::new(0.0, waves(amplitudes, 0.0), [0.0; 200]));
        assert!((same.q - start.q).amax() < rounding);
        let energies = amplitudes.into_iter().zip([1, 2, 3, 4, 7]);
        let energies = energies.map(|(a, j)| 0.5 * (omega(j) * a).powi(2) * m * 100.5).collect::<Vec<_>>();
        assert!(off(left.energy, energies[4]) < 1e-12, "{}", left.energy);
        assert!(off(left.whole, energies.iter().sum()) < 1e-12, "{}", left.whole);
    });
}

/// Damping that couples the modes is kept as a matrix: digits of exp(A t) in 40-digit arithmetic.
#[test]
fn damping_couples_the_modes() {
    let system = Damped::new(1.25, 0.75, 5.0, 9.0, 0.25, 0.0625, 0.5);
    let start = State::new(0.0, [0.5, -0.25], [0.0, 1.0]);
    let whole = ModalModel::<_, 2, 2>::about(&system, &[0.0; 2]).unwrap();
    let (kept, left) = whole.restrict(&start);
    assert!(left.energy.to_bits() == 0 && whole.left_out().is_none());
    for none in [f64::NAN, f64::INFINITY] {
        assert!(whole.restrict(&State::new(0.0, [none, 0.0], [0.0; 2])).1.part().is_nan());
    }
    let end = whole.lift(&exactly(&whole, kept, 3.0));
    let digits = [0.345_372_591_120_085_3, -0.023_052_039_521_553_43];
    let rates = [0.197_251_151_373_239_78, -0.430_074_032_599_504_5];
    assert!((end.q - SVector::from(digits)).amax() < 1e-14, "{}", end.q);
    assert!((end.qd - SVector::from(rates)).amax() < 1e-14, "{}", end.qd);

    // One mode is a damped oscillator; which one, is chosen by its index.
    for (kept, [m, k, c, x, v]) in [(0, [1.25, 5.0, 0.25, 0.5, 0.0]), (1, [0.75, 9.0, 0.5, -0.25, 1.0])] {
        let model = ModalModel::<_, 2, 1>::of_modes(&system, &[0.0; 2], [kept]).unwrap();
        let (at, left) = model.restrict(&start);
        let energies = [0.5 * 5.0 * 0.25, 0.5 * 9.0 * 0.0625 + 0.5 * 0.75];
        assert!((left.energy - energies[1 - kept]).abs() < 1e-15, "{}", left.energy);
        let (decay, t) = (0.5 * c / m, 3.0);
        let rate = f64::sqrt(k / m - decay * decay);
        let exact = f64::exp(-decay * t) * (x * (rate * t).cos() + (v + decay * x) / rate * (rate * t).sin());
        let end = model.lift(&exactly(&model, at, t));
        assert!((end.q[kept] - exact).abs() < 1e-14 && end.q[1 - kept] == 0.0, "{} {exact}", end.q);
    }
}

/// A damper on one of two masses between three springs of 1 N/m: `C = c/2 [1 1; 1 1]` in modes with ω² = 1 and 3. The
/// amplitude of the other mode, to first order, is that in the eigenvector of the whole.
#[test]
fn coupling_is_the_amplitude_of_the_other_mode() {
    let system = |c| Damped::new(1.0, 1.0, 1.0, 3.0, 0.5 * c, 0.5 * c, 0.5 * c);
    let coupling =
        |c, kept| ModalModel::<_, 2, 1>::of_modes(&system(c), &[0.0; 2], [kept]).unwrap().coupling();
    for c in [1e-3, 0.2] {
        let exact = [0.5 * c, 0.5 * c * 3f64.sqrt()].map(|force| force / force.hypot(2.0));
        assert!((coupling(c, 0) - exact[0]).abs() < 1e-15 && (coupling(c, 1) - exact[1]).abs() < 1e-15);
        let start = State::new(0.0, [1.0, 0.0], [0.0; 2]);
        let whole = ModalModel::<_, 2, 2>::about(&system(c), &[0.0; 2]).unwrap();
        assert_eq!(whole.coupling().to_bits(), 0);
        let other = (1..4000).map(|k| exactly(&whole, start, 0.01 * f64::from(k)).q[1].abs());
        // Two amplitudes, as its own vibration is as large at the start and as slow to end.
        let most = other.fold(0.0, f64::max);
        assert!(most < 2.0 * exact[0] && most > 0.9 * exact[0], "{c}: {most} {}", exact[0]);
    }
    // A rigid mode that a damper slows down: c/2 over (ω² = 2, c/2).
    let sled = Damped::new(1.0, 1.0, 0.0, 2.0, 0.1, 0.1, 0.1);
    let rigid = ModalModel::<_, 2, 1>::of_modes(&sled, &[0.0; 2], [0]).unwrap();
    assert!((rigid.coupling() - 0.01 / 2f64.hypot(0.01)).abs() < 1e-15, "{}", rigid.coupling());
    // Gyroscopic terms of a size of the stiffness: one mode says nothing.
    let gyroscopic = Plain::new(1.0, 1.5, 0.0, 2.0, 0.0);
    assert!(ModalModel::<_, 2, 1>::about(&gyroscopic, &[0.0; 2]).unwrap().coupling() > 3.0);
}

/// With all modes a linear system is itself, gyroscopic terms included, and keeps its energies and its trait.
#[test]
fn all_modes_are_the_system() {
    fn is_conservative<Sys: Conservative<2> + Separable<2> + Linear<2>>(_: &Sys) {}
    let system = Plain::new(3.0, 5.0, 0.2, 1.5, 0.0);
    let model = ModalModel::<_, 2, 2>::about(&system, &[0.0; 2]).unwrap();
    let at = State::new(0.0, [0.3, -0.4], [1.1, 0.7]);
    let (kept, _) = model.restrict(&at);
    let lifted = model.shapes() * model.accel_at(&kept);
    assert!((lifted - system.accel_at(&at)).amax() < 1e-14);
    assert!((model.energy_function_at(&kept) - system.energy_function_at(&at)).abs() < 1e-14);
    assert!((model.power_at(&kept) + 0.2 * at.qd.norm_squared()).abs() < 1e-14);
    let rest = model.inertia_at(&kept) * model.accel_at(&kept) + model.convective_momentum_rate_at(&kept);
    assert!((rest - model.momentum_rate_at(&kept)).amax() < 1e-14);
    let momenta = model.momenta_at(&kept);
    assert!((model.velocities(&kept.q, &momenta, 0.0) - kept.qd).amax() < 1e-14);

    let two = TwoMasses::new(1.0, 2.0, 3.0, 4.0);
    let free = ModalModel::<_, 2, 2>::about(&two, &[0.0; 2]).unwrap();
    is_conservative(&free);
    const { assert!(<ModalModel<TwoMasses, 2, 1> as Lagrangian<1>>::FACTS.conservative) };
    const { assert!(!<ModalModel<Plain, 2, 1> as Lagrangian<1>>::FACTS.conservative) };
}

/// Modes that are left out follow inputs as in statics; a rigid one has no statics.
#[test]
fn inputs_act_on_all_modes() {
    let (train, rest) = (Train { pull: 0.0, ..Train::new(4.0, 0.6) }, [0.0; 3]);
    let mut model = ModalModel::<_, 3, 2>::about(&train, &rest).unwrap().with_inputs().unwrap();
    assert_eq!(<ModalModel<Train, 3, 2, 1> as Lagrangian<2>>::FACTS.inputs, ["pull"]);
    model.set_inputs(&[1.5].into());
    // All are accelerated by 0.5, the first spring is stretched by 0.5 / k and the second one by 1.0 / k.
    let end = model.lift(&exactly(&model, State::new(0.0, [0.0; 2], [0.0; 2]), 80.0));
    let stretched = [end.q[1] - end.q[0], end.q[2] - end.q[1]];
    assert!((stretched[0] - 0.125).abs() < 1e-9 && (stretched[1] - 0.25).abs() < 1e-9, "{stretched:?}");
    assert!((end.q.mean() - 0.25 * 80.0 * 80.0).abs() < 1e-9, "{}", end.q.mean());
    // A state that was lifted leaves nothing.
    let (_, left) = model.restrict(&end);
    assert!(left.q.amax() < 1e-11 && left.energy < 1e-20, "{:?}", left);
    assert_eq!((model.inputs()[0], model.whole().pull), (1.5, 1.5));

    // A sampled control law drives all modes as it drives the train.
    let law = |at: &State<f64, 3>, u: &mut SVector<f64, 1>| u[0] = (3.0 * at.t).sin();
    let all = ModalModel::<_, 3, 3>::about(&train, &rest).unwrap().with_inputs::<1>().unwrap();
    let still = State::new(0.0, rest, rest);
    let mut driven = Stepper::new(train, Dop853, PiController::tolerance(1e-12), still).every(0.1, law);
    let mut modes = Stepper::new(all, MatrixExponential, FixedStep::new(0.1), still).every(0.1, law);
    driven.advance_to(20.0).unwrap();
    modes.advance_to(20.0).unwrap();
    let error = (modes.system().lift(modes.state()).q - driven.state().q).amax();
    assert!(error < 1e-11 && driven.state().q.amax() > 1.0, "{error:e} {}", driven.state().q);

    let bent = ModalModel::<_, 3, 2>::of_modes(&train, &rest, [1, 2]).unwrap();
    let refused = bent.with_inputs::<1>().unwrap_err();
    assert!(refused.to_string().contains("rigid mode"), "{refused}");
}

/// A pendulum by x and y: one mode, on the tangent of the circle.
#[test]
fn constraints_leave_the_tangent_space() {
    let pendulum = Cartesian::default();
    let model = ModalModel::<_, 2, 1>::about(&pendulum, &[0.0, -1.0]).unwrap();
    assert!(off(model.frequencies()[0], 9.81f64.sqrt()) < 1e-14);
    let a: f64 = 1e-3;
    let (start, left) = model.restrict(&State::new(0.0, [a.sin(), -a.cos()], [0.0; 2]));
    let end = model.lift(&exactly(&model, start, 2.0));
    assert!((end.q[0] - a * (9.81f64.sqrt() * 2.0).cos()).abs() < a.powi(3) && end.q[1] == -1.0);
    assert!(left.q[0].abs() < 1e-18 && (left.q[1] - 0.5 * a * a).abs() < 1e-12, "{}", left.q);
}

#[test]
fn a_run_watches_its_range() {
    let model = ModalModel::<_, 1, 1>::about(&Swing::new(4.0, 0.0), &[0.0]).unwrap();
    let watched = InRange::new([-0.3..=0.3], FinalState(|_: &_, end: &State<f64, 1>| end.q[0]));
    let run = |speed: f64| {
        let (start, _) = model.restrict(&State::new(0.0, [0.0], [speed]));
        integrate(&model, MatrixExponential, FixedStep::new(5.0), start).until(5.0).observe(&watched)
    };
    assert!(run(0.59).is_ok());
    let failure = run(0.61).unwrap_err().failure;
    let exact = (0.6f64 / 0.61).asin() / 2.0;
    assert!(matches!(failure, Failure::OutsideModel { t, .. } if (t - exact).abs() < 1e-9), "{failure}");
}

#[test]
fn what_has_no_such_model_is_refused() {
    fn refused<const WHOLE: usize, const R: usize>(
        system: &(impl Linearize<WHOLE, Scalar = f64> + Clone),
        q: [f64; WHOLE],
        kept: [usize; R],
    ) -> AnalysisError {
        ModalModel::of_modes(system, &q, kept).map(|_| ()).unwrap_err()
    }
    use AnalysisError::*;
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    assert!(matches!(refused(&pendulum, [0.1, 0.0], [0]), NotEquilibrium { .. }));
    assert!(matches!(refused(&pendulum, [PI, 0.0], [0]), Unstable { square } if square < 0.0));
    // Gyroscopic forces may hold it, and no vibration tells.
    assert!(matches!(refused(&Plain::new(-1.0, -1.0, 0.0, 4.0, 0.0), [0.0; 2], [0]), Unstable { .. }));
    assert!(matches!(refused(&Follower::new(0.3), [0.0; 2], [0]), Circulatory { .. }));
    assert!(matches!(refused(&Swing::new(1.0, -0.1), [0.0], [0]), NegativeDamping { .. }));
    assert_eq!(refused(&Shaken::new(0.02, 30.0), [0.0], [0]), TimeDependent);
    for kept in [[0, 0], [0, 2]] {
        assert!(matches!(refused(&pendulum, [0.0; 2], kept), NotApplicable { .. }));
    }
    let more = ModalModel::<_, 2, 3>::about(&pendulum, &[0.0; 2]).map(|_| ()).unwrap_err();
    assert!(more.to_string().contains("modes that the system has"), "{more}");
}
