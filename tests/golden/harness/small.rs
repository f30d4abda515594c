//! Small vibrations: what the emitted derivatives say at an equilibrium, against the linearization in the file.

use super::reference::Fields;
use super::row::{Finding, Kind};
use super::subject::Quantity;
use super::{BALANCE, INPUT, State, Subject, TOLERANCE};
use nalgebra::{Complex, DMatrix, DVector};

/// Rest at each equilibrium; M, C = −M ∂q̈/∂q̇, K = −M ∂q̈/∂q; K v = ω² M v for each mode; det(λ²M + λC + K) = 0 for
/// each damped eigenvalue; stability, that is K positive definite.
pub fn check_small(subject: &Subject) -> Vec<Finding> {
    let files = subject.reference.small();
    files.iter().enumerate().flat_map(|(index, small)| check_one(subject, small, index)).collect()
}

fn check_one(subject: &Subject, small: &Fields, index: usize) -> Vec<Finding> {
    let n = subject.n;
    let rest = State { q: small.numbers("q_eq"), qd: vec![0.0; n], t: 0.0 };
    let point = subject.at(format!("equilibrium {index}"), &rest);
    let place = |what: &str| format!("equilibrium {index}: {what}");
    let compare = |what, got: &DMatrix<f64>, expected: &DMatrix<f64>, bound| {
        Finding::compare(Kind::Digits, place(what), got.as_slice(), expected.as_slice(), bound)
    };
    let digits = |field| DMatrix::from_vec(n, n, small.matrix(field));

    let inertia = point.inertia();
    let derivative = |quantity| -(&inertia * point.matrix(quantity));
    let (stiffness, damping) = (derivative(Quantity::JacobianQ), derivative(Quantity::JacobianQd));
    let slack = |quantity| {
        let terms = inertia.abs() * point.matrix(quantity).abs();
        let condition = inertia.abs() * DMatrix::repeat(n, n, point.condition(quantity));
        TOLERANCE * terms.amax() + INPUT * condition.amax() + TOLERANCE * point.condition(Quantity::Force)
    };
    let bound = slack(Quantity::JacobianQ);
    // A driving force may be left out of the linearization. The place of equilibrium is rounded, too.
    let gradient = DVector::from_fn(n, |k, _| point.partial(Quantity::Lagrangian, k)[0]);
    let still = gradient - DVector::from_vec(point.value(Quantity::Bias));
    let missed = bound * (1.0 + point.x[..n].iter().map(|x| x.abs()).sum::<f64>());
    let mut findings = vec![
        Finding::residue(Kind::Equation, place("rest"), still.amax(), missed / TOLERANCE, missed),
        compare("M", &inertia, &digits("M"), point.bound(Quantity::Inertia, 0.0)),
        compare("C", &damping, &digits("C"), slack(Quantity::JacobianQd)),
        compare("K", &stiffness, &digits("K"), bound),
    ];
    for (square, mode) in small.numbers("omega2").into_iter().zip(small.lists("modes")) {
        let mode = DVector::from_vec(mode);
        let residual = (&stiffness - &inertia * square) * &mode;
        let size = (stiffness.abs() + inertia.abs() * square.abs()) * mode.abs();
        let what = place(&format!("mode of ω² = {square}"));
        let size = size.amax();
        findings.push(Finding::residue(Kind::Equation, what, residual.amax(), size, BALANCE * size));
    }
    if small.has("eigenvalues") {
        for value in small.lists("eigenvalues") {
            let value = Complex::new(value[0], value[1]);
            let matrix = inertia.map(|m| value * value * m)
                + damping.map(|c| value * c)
                + stiffness.map(Complex::from);
            let size = inertia.abs() * value.norm_sqr() + damping.abs() * value.norm() + stiffness.abs();
            // Hadamard: a determinant is at most the product of the lengths of its rows.
            let size: f64 = size.row_iter().map(|row| row.norm()).product();
            let residual = matrix.determinant().norm();
            let what = place(&format!("eigenvalue {value}"));
            findings.push(Finding::residue(Kind::Equation, what, residual, size, BALANCE * size));
        }
    }
    let stable = nalgebra::linalg::Cholesky::new(stiffness).is_some();
    let expected = small.numbers("omega2").iter().all(|square| *square > 0.0);
    findings.push(Finding::holds(place("stability"), stable == expected));
    findings
}

/// The lowest frequency of the first equilibrium: Rayleigh's quotient with the emitted matrices, and the digits.
pub fn lowest_frequency(subject: &Subject) -> Option<(String, f64, f64)> {
    let small = subject.reference.small().into_iter().next()?;
    let frequency = small.numbers("omega")[0];
    let mode = DVector::from_vec(small.lists("modes").remove(0));
    let point = subject.at("", &State { q: small.numbers("q_eq"), qd: vec![0.0; subject.n], t: 0.0 });
    let moved = point.inertia() * &mode;
    let pulled = point.inertia() * point.matrix(Quantity::JacobianQ) * &mode;
    Some(("ω₁".to_owned(), (-mode.dot(&pulled) / mode.dot(&moved)).sqrt(), frequency))
}
