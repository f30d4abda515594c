//! Motions of a disk, a hoop and a coin that roll without slip, against closed forms, and digits from these.
//!
//! With lean φ, heading ψ and turn θ, n = ψ̇ cos φ and s = ψ̇ sin φ + θ̇, moments of inertia k m r² about the axle and
//! h m r² across, steady motions obey `h n² tan φ = (k + 1) n s + (g/r) sin φ` (Routh, *Advanced Dynamics of Rigid
//! Bodies*, 1905, §244).
#![allow(clippy::excessive_precision)]

use crate::systems::*;
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

/// A wheel at the origin, headed along x, with this lean, ψ̇ = n/cos φ and θ̇ = s − n tan φ.
fn rolls(wheel: &Wheel, phi: f64, n: f64, s: f64) -> State<f64, 5> {
    let (heading, turn) = (n / phi.cos(), s - n * phi.tan());
    State::new(0.0, [0.0, 0.0, 0.0, phi, 0.0], [wheel.r * turn, 0.0, heading, 0.0, turn])
}

/// `s` of the steady motion with this lean and n.
fn steady(wheel: &Wheel, phi: f64, n: f64) -> f64 {
    (wheel.h * n * n * phi.tan() - wheel.g / wheel.r * phi.sin()) / ((wheel.k + 1.0) * n)
}

/// Centre of the wheel, on the left of its heading where it leans by φ < 0.
fn centre(wheel: &Wheel, at: &State<f64, 5>) -> [f64; 2] {
    let aside = wheel.r * at.q[3].sin();
    [at.q[0] + aside * at.q[2].sin(), at.q[1] - aside * at.q[2].cos()]
}

/// On circles for ten turns of the heading: the point of contact on a circle of radius |r θ̇/ψ̇|, the centre on one of
/// r |s/ψ̇|, and the friction that keeps it there is m r |s ψ̇|.
#[test]
fn steady_circles() {
    for (k, h, r, phi, n) in
        [(0.5, 0.25, 0.4, 0.3, 1.7), (1.0, 0.5, 0.4, 0.3, 1.7), (0.5, 0.25, 1.1, -0.6, 2.5)]
    {
        let wheel = Wheel::new(1.3, r, k, h);
        let s = steady(&wheel, phi, n);
        let start = rolls(&wheel, phi, n, s);
        let (heading, turn) = (start.qd[2], start.qd[4]);
        let friction = wheel.multipliers(&start.q, &start.qd, 0.0).norm();
        assert!((friction / (1.3 * r * (s * heading).abs()) - 1.0).abs() < 1e-14, "{friction}");
        let end = std::f64::consts::TAU * 10.3 / heading;
        let found = integrate(&wheel, Verner9, PiController::tolerance(1e-13), start)
            .until(end)
            .final_state()
            .unwrap();
        let psi = heading * end;
        let radius = r * turn / heading;
        let exact = [radius * psi.sin(), radius * (1.0 - psi.cos()), psi, phi, turn * end];
        for (i, exact) in exact.into_iter().enumerate() {
            assert!((found.q[i] - exact).abs() < 2e-11, "{i}: {} {exact}", found.q[i]);
        }
        let [x, y] = centre(&wheel, &found);
        let around = (x.powi(2) + (y - radius).powi(2)).sqrt();
        assert!((around - r * (s / heading).abs()).abs() < 2e-12, "{around}");
    }
}

/// Euler's disk: its centre rests where ψ̇² = g/(h r cos φ), and it wobbles about that at
/// n √((1 + 3 h tan² φ)/(1 + h)), however flat it lies. The force on it is its weight alone.
#[test]
fn eulers_disk() {
    for (k, h, r, phi) in [
        (0.5, 0.25, 0.0375, 1.2f64),
        (0.5, 0.25, 0.0125, 1.5),
        (1.0, 0.5, 0.2, 0.7),
        (0.5, 0.25, 0.0375, 1.56),
    ] {
        let disk = Wheel::new(0.4, r, k, h);
        let heading = (disk.g / (h * r * phi.cos())).sqrt();
        let n = heading * phi.cos();
        let start = rolls(&disk, phi, n, 0.0);
        assert!(steady(&disk, phi, n).abs() < 1e-14 * heading);
        let friction = disk.multipliers(&start.q, &start.qd, 0.0).norm();
        assert!(friction < 1e-13 * disk.m * disk.g / phi.cos(), "{friction}");
        let small = SmallMotion::steady(&disk, &start).unwrap();
        let frequency = small.spectrum().unwrap().frequencies();
        let exact = n * ((1.0 + 3.0 * h * phi.tan().powi(2)) / (1.0 + h)).sqrt();
        let off = (frequency.last().unwrap() / exact - 1.0).abs();
        assert!(off < 1e-12, "{phi}: {frequency:?} {exact} {off:e}");
        let end = 100.0 / heading;
        let found =
            integrate(&disk, Dop853, PiController::tolerance(1e-13), start).until(end).final_state().unwrap();
        let ([x, y], [x0, y0]) = (centre(&disk, &found), centre(&disk, &start));
        assert!((x - x0).hypot(y - y0) < 3e-12 * r, "{phi}: {:e}", (x - x0).hypot(y - y0) / r);
        // Rates of heading and turn cancel to one part in tan φ.
        let cancelled = phi.tan().powi(2) * 1e-14;
        assert!((found.q[2] / 100.0 - 1.0).abs() < 1e-12 + cancelled, "{phi}: {}", found.q);
        assert!((found.q[3] - phi).abs() < 1e-12 + cancelled, "{phi}: {}", found.q);
    }
}

/// Spun on its edge about a diameter, with its centre at rest, a coin stays up where n² > g/((h + 1) r).
#[test]
fn a_coin_spun_on_its_edge() {
    for (k, h, r) in [(0.5, 0.25, 0.0125), (1.0, 0.5, 0.4)] {
        let coin = Wheel::new(0.4, r, k, h);
        let small = |n: f64| SmallMotion::steady(&coin, &rolls(&coin, 0.0, n, 0.0));
        let critical = (coin.g / ((h + 1.0) * r)).sqrt();
        for part in [0.5, 0.99, 1.01, 3.0] {
            let n = part * critical;
            let square = coin.g / r / (h + 1.0) - n * n;
            let spectrum = small(n).unwrap().spectrum().unwrap();
            let largest =
                spectrum.eigenvalues.iter().map(|z| z * z).max_by(|a, b| a.norm().total_cmp(&b.norm()));
            let off = (largest.unwrap() - square).norm() / (n * n);
            assert!(off < 1e-13, "{part}: {spectrum:?} {square} {off:e}");
        }
        let found = stability_threshold(small, 0.5 * critical, 2.0 * critical).unwrap();
        assert!((found / critical - 1.0).abs() < 1e-12, "{found} {critical}");
    }
}

/// (t, ψ, θ, x, y, φ, n, s).
type Digits = [f64; 8];

/// After five wobbles and a half, by Legendre functions and quadratures in 50 digits (`benches/references/rolling.py`).
const DISK: Digits = [
    6.9746795109517765141,
    -5.3349163919272214762,
    -34.758860819709693833,
    2.0420797705519272468,
    0.46659728654214891254,
    -0.6942507513711961318,
    -5.0266422614726507981,
    -4.4543471728351437671,
];
const HOOP: Digits = [
    3.8542652975340881322,
    1.2953312712085300948,
    -23.580893149195256557,
    -6.8974053483359747017,
    -5.3194079595065827496,
    0.022974614281948918735,
    -1.3272150725371443632,
    -5.9557304085955242868,
];
const COIN: Digits = [
    0.40405311993955455541,
    45.13109693918288785,
    -42.640905305790927987,
    -0.012454084280413915031,
    -0.0047655091104672118765,
    1.4016090009211001923,
    41.393454226104699583,
    0.2718778056062674435,
];

/// A disk that wobbles through the upright position, a hoop that nearly does, and a coin that lies almost flat.
fn wobbles() -> [(Wheel, State<f64, 5>, Digits); 3] {
    let [disk, hoop] = [(0.5, 0.25), (1.0, 0.5)].map(|(k, h)| Wheel::new(1.3, 0.4, k, h));
    let coin = Wheel::new(0.0075, 0.0125, 0.5, 0.25);
    [
        (disk, rolls(&disk, 0.25, 3.0, -4.0), DISK),
        (hoop, rolls(&hoop, 0.3, 2.0, -6.0), HOOP),
        (coin, rolls(&coin, 1.2, 20.0, 4.0), COIN),
    ]
}

/// Distance of a state from its digits: coordinates in radians and radii, and n and s in units of the rates.
fn off(wheel: &Wheel, at: &State<f64, 5>, digits: &Digits) -> f64 {
    let [_, psi, theta, x, y, phi, n, s] = *digits;
    let r = wheel.r;
    let own = at.qd[2] * at.q[3].cos();
    let turning = at.qd[2] * at.q[3].sin() + at.qd[4];
    let all = [
        (at.q[0] - x) / r,
        (at.q[1] - y) / r,
        at.q[2] - psi,
        at.q[3] - phi,
        at.q[4] - theta,
        (own - n) / n,
        (turning - s) / n,
        at.qd[3] / n,
    ];
    all.into_iter().fold(0.0, |most, x| most.max(x.abs()))
}

#[test]
#[cfg_attr(not(feature = "long"), ignore = "long")]
fn wobbles_by_legendre_functions() {
    for (wheel, start, digits) in wobbles() {
        // Rates of 240/s for a wobble of 80/s, and their phase, in the coin.
        let most = if wheel.r < 0.1 { 4e-11 } else { 3e-12 };
        let fine = PiController::tolerance(1e-13);
        let end = digits[0];
        let taylor = (Taylor, TaylorController::tolerance(1e-13));
        let ends = [
            integrate(&wheel, Verner9, fine, start).until(end).final_state(),
            integrate(&wheel, Dop853, fine, start).until(end).final_state(),
            integrate(&wheel, taylor.0, taylor.1, start).until(end).final_state(),
            integrate(&wheel, Radau5, PiController::tolerance(1e-11), start).until(end).final_state(),
        ];
        for (k, found) in ends.into_iter().enumerate() {
            let error = off(&wheel, &found.unwrap(), &digits);
            assert!(error < most, "{k}: {error:e}");
        }
    }
}
