//! M, C, K, natural frequencies, shapes, damped eigenvalues and stability against the digits.

use crate::reference::{Reference, close, matrix, numbers};
use crate::systems::*;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::traits::Linearize;

const TOLERANCE: f64 = 1e-13;

/// Every linearization of a file.
fn agrees<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    file: &str,
    system: impl Fn(&dyn Fn(&str) -> f64) -> Sys,
) {
    let reference = Reference::read(file);
    let system = system(&|name| reference.parameter(name));
    for expected in reference.small() {
        let q: [f64; N] = numbers(&expected["q_eq"]).try_into().expect("N coordinates");
        let small = small_vibrations(&system, &q).unwrap_or_else(|e| panic!("{file}: {e}"));
        for (name, found) in [("M", small.inertia()), ("C", small.velocity_terms()), ("K", small.stiffness())]
        {
            let digits = matrix(&expected[name]);
            let size = digits.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
            for (i, row) in digits.iter().enumerate() {
                for (j, x) in row.iter().enumerate() {
                    let off = (found[(i, j)] - x).abs();
                    assert!(off <= TOLERANCE * size, "{file}: {name}[{i}, {j}] is off by {off:e}");
                }
            }
        }
        let modes = small.modes().unwrap();
        let shapes = expected["modes"].as_array().unwrap();
        for (k, omega2) in numbers(&expected["omega2"]).into_iter().enumerate() {
            close(modes.squares()[k], omega2, TOLERANCE);
            match expected["omega"][k].as_f64() {
                Some(omega) => close(modes.frequency(k), omega, TOLERANCE),
                None => assert_eq!(modes.kind(k), ModeKind::Unstable),
            }
            for (found, x) in modes.shape(k).iter().zip(numbers(&shapes[k])) {
                assert!((found - x).abs() <= TOLERANCE, "{file}: shape {k} has {found} and not {x}");
            }
        }
        if let Some(eigenvalues) = expected["eigenvalues"].as_array() {
            let spectrum = small.spectrum().unwrap();
            assert_eq!(spectrum.eigenvalues.len(), eigenvalues.len());
            for pair in eigenvalues {
                let expected = Complex::new(pair[0].as_f64().unwrap(), pair[1].as_f64().unwrap());
                let off =
                    spectrum.eigenvalues.iter().map(|e| (e - expected).norm()).fold(f64::INFINITY, f64::min);
                assert!(off <= TOLERANCE * expected.norm(), "{file}: {expected} is off by {off:e}");
            }
            assert!(spectrum.is_stable());
        }
        assert_eq!(
            small.energy_criterion().unwrap().is_stable(),
            expected["stable"].as_bool().unwrap(),
            "{file}"
        );
    }
}

#[test]
fn two_masses_between_springs() {
    agrees("ex-11.6i-two-mass-chain", |p| TwoMasses::new(p("m1"), p("m2"), p("k1"), p("k2")));
    agrees("ex-11.6ii-two-mass-symmetric", |p| TwoMasses::new(p("m"), p("m"), p("k"), p("k")));
}

#[test]
fn wheel_and_block() {
    agrees("ex-11.9-wheel-cable-block", |p| WheelAndBlock::new(p("m"), p("I"), p("a"), p("k1"), p("k2")));
}

#[test]
fn generic_system_of_two_coordinates() {
    agrees("ex-11.11-generic-two-dof", |p| {
        Generic::new(p("M11"), p("M12"), p("M22"), p("K11"), p("K12"), p("K22"))
    });
}

#[test]
fn body_on_a_wire() {
    for file in ["ex-11.12i-wire-suspended-body", "ex-11.12ii-disk-on-wire"] {
        agrees(file, |p| WireBody::new(p("M"), p("a"), p("l"), p("IG"), p("g")));
    }
    agrees("ex-11.12-small", |p| WireBodySmall::new(p("M"), p("a"), p("l"), p("IH"), p("g")));
}

/// (11.92i), (11.92l) and (11.92o), whose first mode is the faster one.
#[test]
fn printed_normal_coordinates_of_the_disk() {
    let reference = Reference::read("ex-11.12ii-disk-on-wire");
    let p = |name: &str| reference.parameter(name);
    let disk = WireBody::new(p("M"), p("a"), p("l"), p("IG"), p("g"));
    let modes = small_vibrations(&disk, &[0.0, 0.0]).unwrap().modes().unwrap();
    close(modes.frequency(1), reference.special("/frequencies_11_92i/0/value"), TOLERANCE);
    close(modes.frequency(0), reference.special("/frequencies_11_92i/1/value"), TOLERANCE);
    close(modes.amplitude_ratio(1, 1, 0), reference.special("/amplitude_ratios_11_92l/C21~1C11"), TOLERANCE);
    close(modes.amplitude_ratio(0, 0, 1), reference.special("/amplitude_ratios_11_92l/C12~1C22"), TOLERANCE);
    let [phi, theta, xi1, xi2] =
        ["phi", "theta", "xi1", "xi2"].map(|x| reference.special(&format!("/normal_coordinates_11_92o/{x}")));
    let normal = modes.normal(&DVector::from_vec(vec![phi, theta])).unwrap();
    // The text measures the first by φ and the second by θ.
    close(normal[1] * modes.normalized(1)[0], xi1, TOLERANCE);
    close(normal[0] * modes.normalized(0)[1], xi2, TOLERANCE);
}

#[test]
fn motions_in_one_mode() {
    let reference = Reference::read("ex-11.6ii-two-mass-symmetric");
    let p = |name: &str| reference.parameter(name);
    let small = small_vibrations(&TwoMasses::new(p("m"), p("m"), p("k"), p("k")), &[0.0; 2]).unwrap();
    let modes = small.modes().unwrap();
    let still = DVector::zeros(2);
    for (mode, sign) in [("mode1_11_40q", 1.0), ("mode2_11_40r", -1.0)] {
        let special = |x: &str| reference.special(&format!("/{mode}/{x}"));
        let start = DVector::from_vec(vec![sign * 0.25, 0.25]);
        let end = modes.free_motion(&start, &still, special("t")).unwrap();
        assert!((end[0] - special("x1")).abs() < 1e-15 && (end[1] - special("x2")).abs() < 1e-15);
    }
}

#[test]
fn problems_of_two_coordinates() {
    agrees("prob-11.27-dumbbell-on-springs", |p| Dumbbell::new(p("m"), p("l"), p("b"), p("k")));
    agrees("prob-11.32-bounce-pitch", |p| {
        BouncePitch::new(p("m"), p("IC"), p("k1"), p("k2"), p("l1"), p("l2"))
    });
    agrees("prob-11.33-slider-spring-rod", |p| SliderRod::new(p("M"), p("m"), p("l"), p("k"), p("g")));
    agrees("prob-11.34-coupled-pendula", |p| {
        CoupledPendula::new(p("m"), p("l"), p("a"), p("k"), p("g"), 0.0)
    });
    agrees("prob-11.35-double-pendulum", |p| DoublePendulum::new(p("m1"), p("m2"), p("l1"), p("l2"), p("g")));
    agrees("prob-11.36-metronome", |p| Metronome::new(p("m1"), p("m2"), p("l1"), p("l2"), p("k"), p("g")));
}

#[test]
fn damped_systems() {
    agrees("ex-11.14-damped-two-dof", |p| {
        Damped::new(p("m1"), p("m2"), p("k1"), p("k2"), p("c1"), p("c12"), p("c2"))
    });
    agrees("prob-11.37-coupled-pendula-stokes", |p| {
        CoupledPendula::new(p("m"), p("l"), p("a"), p("k"), p("g"), p("c"))
    });
    agrees("sec-11.12.3-gyrocompass-small", |p| {
        let k = p("I22") * p("Om") * p("w0") * p("lam").cos();
        Oscillator::new(p("I11"), 2.0 * p("I11") * p("nu"), k)
    });
    agrees("sec-11.12.1-inertia-table", |p| Oscillator::new(p("IS"), 0.0, 2.0 * p("k") * p("a").powi(2)));
}

/// K is the second derivative of V − T₀.
#[test]
fn relative_equilibrium_of_the_bead_in_the_spinning_tube() {
    let file = "ex-11.5a-bead-in-spinning-tube";
    agrees(file, |p| Bead::new(p("m"), p("a"), p("g"), p("om")));
    let reference = Reference::read(file);
    let p = |name: &str| reference.parameter(name);
    let bead = Bead::new(p("m"), p("a"), p("g"), p("om"));
    let all = equilibria(&bead, &[-0.1], &[3.5], 30).unwrap();
    let places: Vec<f64> = all.iter().map(|e| e.q[0]).collect();
    let stable: Vec<bool> = all.iter().map(|e| e.stability.is_stable()).collect();
    assert_eq!(stable, [false, true, false]);
    assert!(places[0].abs() < 1e-15 && (places[2] - std::f64::consts::PI).abs() < 1e-15);
    close(places[1], reference.special("/relative_equilibria/2/theta"), TOLERANCE);
    close(
        all[1].small.modes().unwrap().squares()[0],
        reference.special("/relative_equilibria/2/omega2"),
        TOLERANCE,
    );
}

#[test]
fn all_four_equilibria_of_the_double_pendulum_with_their_directions() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let all = equilibria(&pendulum, &[-1.0; 2], &[4.0; 2], 60).unwrap();
    assert_eq!(all.len(), 4);
    assert_eq!(all.iter().filter(|e| e.stability.is_stable()).count(), 1);
    let Stability::Unstable { direction } = &all[2].stability else { panic!("{:?}", all[2]) };
    assert!((all[2].q[0] - std::f64::consts::PI).abs() < 1e-14 && all[2].q[1].abs() < 1e-14);
    assert!(
        (direction[1] / direction[0] - 0.634088568142752).abs() < 1e-12,
        "the first falls, the second follows"
    );
}

#[test]
fn steady_state_of_a_forced_vibration() {
    let reference = Reference::read("exer-11.7-forced-vibration");
    let p = |name: &str| reference.parameter(name);
    let small = small_vibrations(&Oscillator::new(p("m"), p("c"), p("k")), &[0.0]).unwrap();
    let force = DVector::from_element(1, Complex::new(p("F0"), 0.0));
    let x = small.frequency_response(p("Om"), &force).unwrap()[0];
    close(x.norm(), reference.special("/steady_state/A"), TOLERANCE);
    close(-x.arg(), reference.special("/steady_state/delta"), TOLERANCE);
    let spectrum = small.spectrum().unwrap();
    close(spectrum.natural_frequency(1), reference.special("/undamped_frequency"), TOLERANCE);
    close(spectrum.damped_frequency(1), reference.special("/damped_frequency"), TOLERANCE);
    close(
        spectrum.damping_ratio(1) * spectrum.natural_frequency(1),
        reference.special("/decay_rate"),
        TOLERANCE,
    );
}

/// Without damping the response is the sum of those of the modes.
#[test]
fn the_frequency_response_is_the_sum_over_modes() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let small = small_vibrations(&pendulum, &[0.0; 2]).unwrap();
    let modes = small.modes().unwrap();
    let force = DVector::from_vec(vec![0.3, -1.2]);
    for omega in [0.0, 1.0, 4.2, 9.0] {
        let direct = small.frequency_response(omega, &force.map(|x| Complex::new(x, 0.0))).unwrap();
        let mut sum = DVector::zeros(2);
        for k in 0..2 {
            let shape = modes.normalized(k);
            sum += &shape * (shape.dot(&force) / (modes.squares()[k] - omega * omega));
        }
        assert!((direct.map(|x| x.re) - &sum).amax() <= 1e-13 * sum.amax());
    }
}

/// Damping in proportion to M and K leaves the shapes as they are: ζₖ = (α/ωₖ + β ωₖ)/2.
#[test]
fn proportional_damping_has_its_ratios() {
    let m = DMatrix::from_row_slice(3, 3, &[2.0, 0.3, 0.0, 0.3, 1.0, 0.1, 0.0, 0.1, 0.5]);
    let k = DMatrix::from_row_slice(3, 3, &[40.0, -10.0, 0.0, -10.0, 30.0, -15.0, 0.0, -15.0, 25.0]);
    let (alpha, beta) = (0.2, 0.01);
    let small = SmallMotion::new(m.clone(), &m * alpha + &k * beta, k).unwrap();
    let (modes, spectrum) = (small.modes().unwrap(), small.spectrum().unwrap());
    for k in 0..3 {
        let omega = modes.frequency(k);
        close(spectrum.natural_frequency(2 * k), omega, TOLERANCE);
        close(spectrum.damping_ratio(2 * k), 0.5 * (alpha / omega + beta * omega), TOLERANCE);
        let shape = modes.shape(k);
        assert!(spectrum.shapes[2 * k].iter().zip(&shape).all(|(z, x)| (z - x).norm() < 1e-12));
    }
}

/// Two free masses with a spring and a damper between them: a rigid motion, and one oscillation with the reduced mass.
#[test]
fn a_rigid_motion_among_damped_ones() {
    let relative = |x: f64| DMatrix::from_row_slice(2, 2, &[x, -x, -x, x]);
    let m = DMatrix::from_row_slice(2, 2, &[2.0, 0.0, 0.0, 3.0]);
    let small = SmallMotion::new(m, relative(0.4), relative(5.0)).unwrap();
    let spectrum = small.spectrum().unwrap();
    let reduced = 6.0 / 5.0;
    let decay = 0.4 / (2.0 * reduced);
    let frequency = (5.0f64 / reduced - decay * decay).sqrt();
    assert_eq!(spectrum.eigenvalues.len(), 4);
    assert_eq!(spectrum.eigenvalues[..2], [Complex::new(0.0, 0.0); 2]);
    close(spectrum.damped_frequency(3), frequency, TOLERANCE);
    close(-spectrum.eigenvalues[3].re, decay, TOLERANCE);
    assert!((spectrum.shapes[0][0] - spectrum.shapes[0][1]).norm() < 1e-13, "both move alike");
    assert!(matches!(small.energy_criterion(), Ok(Stability::Neutral { .. })) && spectrum.is_stable());
}

/// However rounding moves the double zero of the rigid motion, along either axis, all eigenvalues are there.
#[test]
fn no_eigenvalue_is_lost() {
    for i in 0..200 {
        let [a, b, c] = [0.7, 1.3, 2.1].map(|x| 1.0 + 0.9 * (x * f64::from(i)).sin());
        let chain = |x: f64, y: f64| DMatrix::from_row_slice(3, 3, &[x, -x, 0.0, -x, x + y, -y, 0.0, -y, y]);
        let m = DMatrix::from_diagonal(&DVector::from_vec(vec![a, b, c]));
        let small = SmallMotion::new(m, chain(0.1 * b, 0.3), chain(5.0 * a, 7.0 * c)).unwrap();
        let spectrum = small.spectrum().unwrap();
        assert_eq!(spectrum.eigenvalues.len(), 6);
        assert_eq!(spectrum.eigenvalues[..2], [Complex::new(0.0, 0.0); 2], "{a} {b} {c}");
        let sum: Complex<f64> = spectrum.eigenvalues.iter().sum();
        let trace = -0.1 * b / a - (0.1 * b + 0.3) / b - 0.3 / c;
        assert!((sum - trace).norm() < 1e-12, "{sum} {trace}");
    }
}

/// M, K from the Jacobian of the accelerations and from the forces themselves.
#[test]
fn about_any_state_and_about_an_equilibrium_agree() {
    let pendulum = DoublePendulum::new(0.7, 0.4, 0.8, 0.6, 9.81);
    let at = State::new(0.0, [std::f64::consts::PI, 0.0], [0.0; 2]);
    let [forces, jacobian] =
        [SmallMotion::steady(&pendulum, &at).unwrap(), SmallMotion::about(&pendulum, &at).unwrap()];
    assert!((forces.stiffness() - jacobian.stiffness()).amax() < 1e-13 * forces.stiffness().amax());
    assert!(forces.velocity_terms().amax() < 1e-14 && jacobian.velocity_terms().amax() < 1e-14);
}
