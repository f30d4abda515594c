//! Motion under an inverse-square central force on an ellipse.

use crate::scalar::double_double::{DoubleDouble as Double, PI, round};

/// An elliptic Kepler orbit in polar coordinates from any point of it: `r̈ − rφ̇² = −μ/r²`, `r²φ̇ = h`.
///
/// With the semi-major axis a from `1/a = 2/r₀ − v₀²/μ` and the mean motion `n = √(μ/a³)`, Kepler's equation is
/// solved for the difference x of eccentric anomaly since the start (Battin, *An Introduction to the Mathematics and
/// Methods of Astrodynamics*, 1999, eq. 4.43),
///
/// ```text
/// n t = x − C sin x + S (1 − cos x),    C = e cos E₀ = 1 − r₀/a,    S = e sin E₀ = r₀ṙ₀/√(μa)
/// ```
///
/// so that neither pericentre nor its argument has to be known: a circle is no special case. Lagrange's coefficients
/// (eq. 4.41) `f = 1 − (a/r₀)(1 − cos x)`, `g = r₀√(a/μ) sin x + (a r₀ṙ₀/μ)(1 − cos x)` give the position
/// `f r₀ + g v₀`. As x→0 and e→1 nothing cancels: `1 − C` is `r₀/a`, `1 − cos x` is `2 sin²(x/2)`. The root lies
/// within 2e of n t; Newton's iterations that would leave the bracket are replaced by bisection.
///
/// Against mpmath (60 digits), in 300 random cases with 1 − e down to 1e-8, from a millionth of a period to 1e5
/// periods and backwards in time, all four results, the period and e were wrong by 1.1e-16 relative at most: half a
/// unit in the last place.
///
/// ```
/// # use lagrange_runtime::testing::reference::KeplerOrbit;
/// let orbit = KeplerOrbit::new(1.7, [0.8, 0.0], [0.0, 2.0]).unwrap();
/// let ([r, phi], _) = orbit.state(14.585);
/// assert!((r - 0.800000056333531875).abs() < 1e-15 && (phi - 18.8486455286676092).abs() < 1e-14);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeplerOrbit {
    mu: Double,
    r: Double,
    phi: Double,
    rd: Double,
    /// `r₀φ̇₀`.
    transverse: Double,
    /// Semi-major axis.
    a: Double,
}

impl KeplerOrbit {
    /// The orbit through `(r, φ)`, φ in rad, with velocity `(ṙ, φ̇)` about a centre of attraction `mu/r²`. `None`
    /// unless it is an ellipse: `v²/2 < μ/r` with positive μ and r, all of them finite.
    pub fn new(mu: f64, [r, phi]: [f64; 2], [rd, phid]: [f64; 2]) -> Option<Self> {
        let (mu, r, phi, rd) = (Double::from(mu), Double::from(r), Double::from(phi), Double::from(rd));
        Self::of(mu, r, phi, rd, r * phid)
    }

    /// The same from Cartesian coordinates and velocities.
    pub fn from_cartesian(mu: f64, [x, y]: [f64; 2], [xd, yd]: [f64; 2]) -> Option<Self> {
        let (mu, x, y) = (Double::from(mu), Double::from(x), Double::from(y));
        let r = (x.square() + y.square()).sqrt();
        Self::of(mu, r, y.atan2(x), (x * xd + y * yd) / r, (x * yd - y * xd) / r)
    }

    fn of(mu: Double, r: Double, phi: Double, rd: Double, transverse: Double) -> Option<Self> {
        let inverse = Double::from(2.0) / r - (rd.square() + transverse.square()) / mu;
        let a = Double::ONE / inverse;
        let elliptic =
            mu.hi > 0.0 && r.hi > 0.0 && inverse.hi > 0.0 && a.hi.is_finite() && phi.hi.is_finite();
        elliptic.then_some(Self { mu, r, phi, rd, transverse, a })
    }

    /// Period `2π√(a³/μ)`.
    pub fn period(&self) -> f64 {
        (PI * 2.0 / self.mean_motion()).value()
    }

    /// Semi-major axis a.
    pub fn semi_major_axis(&self) -> f64 {
        self.a.value()
    }

    /// Eccentricity `e = √((e cos E₀)² + (e sin E₀)²)`.
    pub fn eccentricity(&self) -> f64 {
        let (c, s) = self.start();
        (c.square() + s.square()).sqrt().value()
    }

    /// `([r, φ], [ṙ, φ̇])` at time `t` after the start (before it, for t < 0). Revolutions are counted in φ.
    pub fn state(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        let Place { x, turns, r, rd, along, across } = self.at(t);
        let sense = if self.transverse.hi < 0.0 { -1.0 } else { 1.0 };
        let angle = (across * sense).atan2(along);
        // |x| ≤ π, yet φ may have moved by more than half a turn, in the direction of x.
        let beyond = if x.hi > 0.0 && angle.hi < 0.0 {
            1.0
        } else if x.hi < 0.0 && angle.hi > 0.0 {
            -1.0
        } else {
            0.0
        };
        let phi = self.phi + (angle + PI * 2.0 * (turns + beyond)) * sense;
        let phid = self.r * self.transverse / r.square();
        ([r.value(), phi.value()], [rd.value(), phid.value()])
    }

    /// `([x, y], [ẋ, ẏ])` at time `t` after the start, with x along φ = 0.
    ///
    /// ```
    /// # use lagrange_runtime::testing::reference::KeplerOrbit;
    /// let circle = KeplerOrbit::from_cartesian(1.0, [1.0, 0.0], [0.0, 1.0]).unwrap();
    /// assert_eq!(circle.cartesian(0.5), ([0.5f64.cos(), 0.5f64.sin()], [-0.5f64.sin(), 0.5f64.cos()]));
    /// ```
    pub fn cartesian(&self, t: f64) -> ([f64; 2], [f64; 2]) {
        let Place { r, rd, along, across, .. } = self.at(t);
        let (sin, cos) = self.phi.sin_cos();
        // The radial direction, turned by φ₀.
        let (ex, ey) = ((along * cos - across * sin) / r, (along * sin + across * cos) / r);
        let transverse = self.r * self.transverse / r;
        let velocity = [rd * ex - transverse * ey, rd * ey + transverse * ex];
        ([r * ex, r * ey].map(Double::value), velocity.map(Double::value))
    }

    fn at(&self, t: f64) -> Place {
        let turn = PI * 2.0;
        let mean = self.mean_motion() * t;
        let turns = round(mean.hi / turn.hi);
        let x = self.anomaly(mean - turn * turns);

        let (c, s) = self.start();
        let (sin, cos) = x.sin_cos();
        let versine = versine(x);
        let r = self.a * (self.r / self.a + c * versine + s * sin);
        let rd = (self.mu * self.a).sqrt() / r * (c * sin + s * cos);
        let f = Double::ONE - self.a / self.r * versine;
        let g = self.r * (self.a / self.mu).sqrt() * sin + self.a * self.r * self.rd / self.mu * versine;
        Place { x, turns, r, rd, along: self.r * f + self.rd * g, across: self.transverse * g }
    }

    /// `n = √(μ/a³)`.
    fn mean_motion(&self) -> Double {
        (self.mu / self.a).sqrt() / self.a
    }

    /// `e cos E₀` and `e sin E₀`.
    fn start(&self) -> (Double, Double) {
        (Double::ONE - self.r / self.a, self.r * self.rd / (self.mu * self.a).sqrt())
    }

    /// The root x of Kepler's equation for `mean` in [−π, π].
    fn anomaly(&self, mean: Double) -> Double {
        let (c, s) = self.start();
        let near = self.r / self.a;
        let reach = (c.square() + s.square()).sqrt() * 2.0;
        let (mut low, mut high, mut x) = (mean - reach, mean + reach, mean);
        for _ in 0..200 {
            let (sin, _) = x.sin_cos();
            // x − C sin x = (1 − C)x + C(x − sin x)
            let value = near * x + c * (x - sin) + s * versine(x) - mean;
            let slope = near + c * versine(x) + s * sin;
            if value.hi > 0.0 {
                high = x
            } else {
                low = x
            }
            let newton = x - value / slope;
            let inside = (newton - low).hi >= 0.0 && (high - newton).hi >= 0.0 && slope.hi > 0.0;
            let next = if inside { newton } else { (low + high) * 0.5 };
            let step = (next - x).hi;
            x = next;
            // Newton's iteration is quadratic: a step in the 20th digit was the last.
            if step * step <= 1e-40 * x.hi * x.hi {
                break;
            }
        }
        x
    }
}

/// Position on the orbit.
struct Place {
    /// Difference of eccentric anomaly since the start, in [−π, π], beyond that many whole turns.
    x: Double,
    turns: f64,
    r: Double,
    rd: Double,
    /// Position along the direction of the start and across it.
    along: Double,
    across: Double,
}

/// `1 − cos x = 2 sin²(x/2)`.
fn versine(x: Double) -> Double {
    (x * 0.5).sin_cos().0.square() * 2.0
}

#[cfg(test)]
#[allow(clippy::excessive_precision)] // the digits as computed, to be compared with their source
mod tests {
    use super::*;

    fn relative(value: f64, expected: f64) -> f64 {
        if expected == 0.0 { value.abs() } else { ((value - expected) / expected).abs() }
    }

    #[test]
    fn state_against_an_independent_taylor_integration() {
        // Order 40, 170 bits; 30 digits.
        let orbit = KeplerOrbit::new(1.7, [0.8, 0.0], [0.0, 2.0]).unwrap();
        let ([r, phi], [rd, phid]) = orbit.state(14.585);
        assert!(relative(r, 0.800000056333531875231682320942) < 2.3e-16);
        assert!(relative(phi, 18.8486455286676091919489952920) < 2.3e-16);
        assert!(relative(rd, -0.000247513027653542367072947353816) < 2.3e-16);
        assert!(relative(phid, 1.99999971833237059713474564375) < 2.3e-16);
        // Given for μ = 17/10, r = 8/10, not for the nearest doubles.
        assert!(relative(orbit.period(), 4.86181839881897941934253054433) < 1e-15);
        assert!(relative(orbit.eccentricity(), 0.20470588235294121) < 1e-15);
        assert!(relative(orbit.semi_major_axis(), 1.0059171597633136) < 1e-15);
    }

    #[test]
    fn cartesian_states_are_the_polar_ones() {
        let (position, velocity) = ([0.05, 0.02], [-3.5, 4.8]);
        let orbit = KeplerOrbit::from_cartesian(1.0, position, velocity).unwrap();
        assert!(orbit.eccentricity() > 0.9);
        for t in [0.0, 0.01, 1.0, -3.7, 1e4] {
            let ([r, phi], [rd, phid]) = orbit.state(t);
            let ([x, y], [xd, yd]) = orbit.cartesian(t);
            let (sin, cos) = phi.sin_cos();
            let (size, speed) = (r * phi.abs().max(1.0), rd.hypot(r * phid) * phi.abs().max(1.0));
            for (value, expected, unit) in [
                (x, r * cos, size),
                (y, r * sin, size),
                (xd, rd * cos - r * phid * sin, speed),
                (yd, rd * sin + r * phid * cos, speed),
            ] {
                assert!((value - expected).abs() < 5e-16 * unit, "t = {t}: {value} for {expected}");
            }
        }
        let (back, again) = orbit.cartesian(0.0);
        for (value, expected) in back.into_iter().chain(again).zip(position.into_iter().chain(velocity)) {
            assert!(relative(value, expected) < 2.3e-16);
        }
    }

    #[test]
    #[rustfmt::skip]
    fn states_on_every_kind_of_ellipse() {
        // mpmath, 60 digits, at these exact doubles: μ, start, t, end. e = 0.198, 0.842, 0, 0.998 (three), 0.998
        // long, 0.820 long, 1 − 5e-9 (past pericentre)
        let rows = [
            (1.7, [1.167, 0.854, -0.164, 1.102], 20.0,
             [1.649873762644340724758, 17.26871254124671926313, 0.0251665923891370460887, 0.551343011750458348543]),
            (1.7, [0.53, -1.043, 0.959, -1.48], 20.0,
             [0.6347337425108540473139, -126.9257839250197554027, 0.2178535014878075091304, -1.031882583813845173657]),
            (1.0, [1.0, 0.0, 0.0, 1.0], 123.456, [1.0, 123.4560000000000030695, 0.0, 1.0]),
            (1.0, [1.0, 0.5, 0.0, 0.04], 1.0,
             [0.3524676941698571195911, 0.5767538861980157899365, -1.913896528995206445384, 0.3219744103628362819091]),
            (1.0, [1.0, 0.5, 0.0, 0.04], 1.1,
             [0.08448818767426454002896, 0.6866324533628156878418, -4.631350097169434398211, 5.603611303859530383825]),
            (1.0, [1e-3, 0.0, 0.0, 44699.0], 1e-5,
             [0.001048329510703590077292, 0.4330150356683909964528, 9.368677172096492962072, 40672.62329575884235486]),
            (1.0, [1e-3, 0.0, 0.0, 44699.0], 5.0,
             [0.8357471552786146471325, 15.67996018135931770426, 0.6251469793584679108775, 0.06399528731654111282379]),
            (1.0, [0.6, 1.0, -0.9, 1.1], 12345.678,
             [0.0876345604149627499646, 37243.85688701414744746, -0.5613147833026529073541, 51.56373417848946555039]),
            (1.0, [1.0, 0.0, 0.3, 1e-4], 3.0,
             [1.005334134202336284198, 6.283243483115936516697, -0.2817593578623151008951, 0.00009894164874922865257927]),
        ];
        let mut worst: f64 = 0.0;
        for (mu, [r, phi, rd, phid], t, expected) in rows {
            let orbit = KeplerOrbit::new(mu, [r, phi], [rd, phid]).unwrap();
            let ([r, phi], [rd, phid]) = orbit.state(t);
            for (value, expected) in [r, phi, rd, phid].into_iter().zip(expected) {
                let error = relative(value, expected);
                assert!(error < 2.3e-16, "t = {t}: {value} for {expected}, {error:e}");
                worst = worst.max(error);
            }
        }
        assert!(worst < 1.2e-16, "{worst:e}");
    }

    #[test]
    fn any_point_of_the_orbit_is_a_start() {
        let orbit = KeplerOrbit::new(1.0, [0.6, 1.0], [-0.9, 1.1]).unwrap();
        let end = orbit.state(7.0).0;
        for i in 0..40 {
            let t = f64::from(i) * 0.17;
            let (q, qd) = orbit.state(t);
            let again = KeplerOrbit::new(1.0, q, qd).unwrap().state(7.0 - t).0;
            // The rounding of the intermediate state is magnified by the motion, not by the solution.
            assert!((again[0] - end[0]).abs() < 2e-13 && (again[1] - end[1]).abs() < 2e-13, "{t}");
        }
    }

    #[test]
    fn time_runs_backwards_too() {
        let orbit = KeplerOrbit::new(1.0, [1.0, 0.0], [0.3, 0.9]).unwrap();
        let mirror = KeplerOrbit::new(1.0, [1.0, 0.0], [-0.3, 0.9]).unwrap();
        for i in 1..30 {
            let t = f64::from(i) * 0.7;
            let ((q, _), (p, _)) = (orbit.state(-t), mirror.state(t));
            assert_eq!((q[0], q[1]), (p[0], -p[1]));
        }
    }

    #[test]
    fn other_conics_and_nonsense_are_refused() {
        let escape = 2.0_f64.sqrt() * 1.000_001;
        for (mu, r, phid) in
            [(1.0, 1.0, escape), (-1.0, 1.0, 0.5), (1.0, -1.0, 0.5), (1.0, f64::NAN, 0.5), (0.0, 1.0, 0.0)]
        {
            assert!(KeplerOrbit::new(mu, [r, 0.0], [0.0, phid]).is_none());
        }
    }
}
