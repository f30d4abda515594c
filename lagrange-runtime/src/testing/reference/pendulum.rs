//! The simple pendulum `θ̈ + (g/l) sin θ = 0` in closed form.

use super::elliptic::{add, complete, functions, whole_periods};
use crate::scalar::double_double::{DoubleDouble as Double, PI, round};

/// The motion of a simple pendulum from any start: libration, rotation, and the separatrix between them.
///
/// With `ω₀² = g/l` and `k² = sin²(θ₀/2) + (θ̇₀/2ω₀)²` (Whittaker, *Analytical Dynamics*, 4th ed. 1937, §44; DLMF
/// 22.19(i)):
///
/// - libration, k < 1: `sin(θ/2) = k sn(u, k)`, `cos(θ/2) = dn(u, k)`, `θ̇ = 2kω₀ cn(u, k)`, `u = u₀ + ω₀t`, period
///   `4K(k)/ω₀`;
/// - rotation, k > 1: `sin(θ/2) = ±sn(u, 1/k)`, `cos(θ/2) = cn(u, 1/k)`, `θ̇ = ±2kω₀ dn(u, 1/k)`, `u = u₀ + kω₀t`,
///   one turn in `2K(1/k)/(kω₀)`.
///
/// Whole periods are taken off `u`, and u₀ enters by the addition theorem, never as a number. Against mpmath (60
/// digits), in 300 random cases of libration and rotation, from 1e-8 rad to 1e-7 rad below the top and for times up
/// to 1e5 s, θ, θ̇ and the period were wrong by 1.1e-16 relative at most: half a unit in the last place. On the
/// separatrix itself, by some units.
///
/// ```
/// # use lagrange_runtime::testing::reference::SimplePendulum;
/// let (g, l) = (9.81, 0.85);
/// let motion = SimplePendulum::new(g, l, 1.0, 0.0);
/// let (theta, thetad) = motion.state(18.5);
/// assert!((theta + 0.738374350117548115).abs() < 1e-15 && (thetad + 2.14462647472244085).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimplePendulum {
    theta: Double,
    /// ω₀ = √(g/l).
    omega: Double,
    /// `k`, the sine of half the amplitude in libration.
    k: Double,
    /// Modulus κ of the elliptic functions and its complement: k in libration, 1/k in rotation.
    modulus: Double,
    complement: Double,
    /// sn, cn and dn of u₀.
    start: (Double, Double, Double),
    /// Sense of a rotation; 0 of a libration.
    sense: f64,
}

impl SimplePendulum {
    /// A pendulum of length `l` (or reduced length) under gravity `g`, started at the angle `theta` in rad from the
    /// downward vertical with the angular velocity `thetad` in rad/s. Unless `g/l > 0`, every result is NaN.
    pub fn new(g: f64, l: f64, theta: f64, thetad: f64) -> Self {
        let omega2 = Double::from(g) / l;
        // NaN rather than the square root's own treatment of 0: without gravity there is no k.
        let omega = if omega2.hi > 0.0 { omega2.sqrt() } else { Double::from(f64::NAN) };
        let theta = Double::from(theta);
        let turns = PI * 2.0 * round(theta.hi / core::f64::consts::TAU);
        let (s, c) = ((theta - turns) * 0.5).sin_cos();
        let w = Double::from(thetad) * 0.5 / omega;
        let k = (s.square() + w.square()).sqrt();
        let speed = if w.hi < 0.0 { -w } else { w };
        // 1 − k²
        let below_separatrix = (c - speed) * (c + speed);
        if below_separatrix.hi > 0.0 {
            let at_rest = k.hi == 0.0;
            let start = if at_rest { (Double::ZERO, Double::ONE, Double::ONE) } else { (s / k, w / k, c) };
            let complement = below_separatrix.sqrt();
            Self { theta, omega, k, modulus: k, complement, start, sense: 0.0 }
        } else {
            let sense = if w.hi < 0.0 { -1.0 } else { 1.0 };
            let complement = (-below_separatrix).sqrt() / k;
            let start = (s * sense, c, speed / k);
            Self { theta, omega, k, modulus: Double::ONE / k, complement, start, sense }
        }
    }

    /// Returns whether the pendulum goes over the top (or, on the separatrix, up to it).
    pub fn rotates(&self) -> bool {
        self.sense != 0.0
    }

    /// Period `4K(k)/ω₀` of a libration, or the time `2K(1/k)/(kω₀)` of one turn of a rotation; infinite on the
    /// separatrix.
    pub fn period(&self) -> f64 {
        let quarter = complete(self.complement);
        if self.complement.hi == 0.0 {
            f64::INFINITY
        } else if self.rotates() {
            (quarter * 2.0 / (self.k * self.omega)).value()
        } else {
            (quarter * 4.0 / self.omega).value()
        }
    }

    /// `(θ, θ̇)` in rad and rad/s at time `t` after the start (before it, for t < 0). Turns are counted: θ of a
    /// rotation keeps growing.
    pub fn state(&self, t: f64) -> (f64, f64) {
        let quarter = complete(self.complement);
        let phase = self.omega * t;
        if self.rotates() {
            let (turns, u) = whole_periods(phase * self.k, quarter, 2.0);
            let (sn, cn, dn) = self.at(u);
            let (s0, c0, _) = self.start;
            // θ/2 moves by less than half a turn while |u| ≤ K, so its difference from the start is unambiguous.
            let half = (sn * c0 - cn * s0).atan2(cn * c0 + sn * s0);
            let theta = self.theta + (half + PI * turns) * (2.0 * self.sense);
            (theta.value(), (self.k * self.omega * dn * (2.0 * self.sense)).value())
        } else {
            let (_, u) = whole_periods(phase, quarter, 4.0);
            let (sn, cn, dn) = self.at(u);
            let turns = PI * 2.0 * round(self.theta.hi / core::f64::consts::TAU);
            let theta = (self.k * sn).atan2(dn) * 2.0 + turns;
            (theta.value(), (self.k * self.omega * cn * 2.0).value())
        }
    }

    fn at(&self, u: Double) -> (Double, Double, Double) {
        add(self.modulus, self.start, functions(u, self.modulus, self.complement))
    }
}

#[cfg(test)]
#[allow(clippy::excessive_precision)] // the digits as computed, to be compared with their source
mod tests {
    use super::*;

    const G: f64 = 9.81;
    const L: f64 = 0.85;

    fn relative(value: f64, expected: f64) -> f64 {
        ((value - expected) / expected).abs()
    }

    #[test]
    fn periods_to_the_last_digit() {
        for (theta, period) in [
            (0.1, 1.85065869621068248754588249660),
            (0.5, 1.87882138418915071805643694974),
            (1.0, 1.97218742086176653422362933772),
            (2.0, 2.45781156748719040712960377737),
            (3.0, 4.75550257546570147430843691824),
        ] {
            assert!(relative(SimplePendulum::new(G, L, theta, 0.0).period(), period) < 2.3e-16);
        }
    }

    #[test]
    fn states_against_an_independent_taylor_integration() {
        // Order 40, 170 bits; 30 digits.
        let (theta, thetad) = SimplePendulum::new(G, L, 1.0, 0.0).state(18.5);
        assert!(relative(theta, -0.738374350117548115340057105745) < 2.3e-16);
        assert!(relative(thetad, -2.14462647472244085404000515148) < 2.3e-16);
        let (theta, _) = SimplePendulum::new(G, L, 1.0, 0.0).state(0.7);
        assert!(relative(theta, -0.62105515138356263) < 2.3e-16);
    }

    #[test]
    #[rustfmt::skip]
    fn states_from_every_kind_of_start() {
        // mpmath, 60 digits, at these exact doubles: θ₀, θ̇₀, t, θ, θ̇, period
        let rows = [
            (0.1, 0.0, 18.5, 0.09997500527756578752242, 0.007588835102521594581434, 1.850658696210682487674),
            (-1.106, 1.42, 3.0, 1.161692936061172540582, -0.9229332757882807174846, 2.0316651059966104622),
            (2.421, 0.021, 1e6, -1.143209901308044349798, 5.188116662447886389133, 2.915641581830883103771),
            (3.0, 0.0, 18.5, 2.71487595700779212014, 1.356026545283663535284, 4.755502575465701474308),
            (3.1414, 0.0, 25.0, 3.141398062634721000431, 0.00009305151530301983370919, 12.52085517740551887263),
            (0.8, -6.0, 2.5, 2.601151475594264978075, 0.3545037755608489854875, 3.246347798137033732776),
            (0.509, 7.5, 4.0, 22.12459384097830645399, 3.635465362033652283545, 1.151380562034529304652),
            (-0.678, -9.0, 100.0, -773.5400296468097553622, -8.975192315077099045141, 0.812980778373728452172),
            (1e-8, 0.0, 7.3, 9.450799894614452241051e-9, 1.110347910832631479571e-8, 1.849502094710578931733),
            (0.3, 6.7, 40.0, 0.7275311263412570370258, -6.330633084759535707566, 4.724030879532138045869),
        ];
        let mut worst: f64 = 0.0;
        for (theta0, thetad0, t, theta, thetad, period) in rows {
            let motion = SimplePendulum::new(G, L, theta0, thetad0);
            let state = motion.state(t);
            for error in [relative(state.0, theta), relative(state.1, thetad), relative(motion.period(), period)] {
                assert!(error < 2.3e-16, "{theta0} {thetad0}: {error:e}");
                worst = worst.max(error);
            }
        }
        assert!(worst < 1.2e-16, "{worst:e}");
    }

    #[test]
    fn the_start_is_kept_and_turns_are_counted() {
        for (theta, thetad) in [(7.0, 0.3), (-20.0, -9.0), (4.0, 6.0)] {
            let motion = SimplePendulum::new(G, L, theta, thetad);
            let state = motion.state(0.0);
            assert!(relative(state.0, theta) < 2.3e-16 && relative(state.1, thetad) < 2.3e-16);
        }
        assert_eq!(SimplePendulum::new(G, L, 0.0, 0.0).state(3.0), (0.0, 0.0));
    }

    #[test]
    fn the_separatrix_creeps_up_to_the_top() {
        // ω₀ = 2: θ = 2 gd(2t), with no period.
        let motion = SimplePendulum::new(4.0, 1.0, 0.0, 4.0);
        let (theta, thetad) = motion.state(1.0);
        assert!(relative(theta, 4.0 * (1.0_f64).tanh().atan()) < 1e-15);
        assert!(relative(thetad, 4.0 / (2.0_f64).cosh()) < 1e-15);
        assert_eq!(motion.period(), f64::INFINITY);
    }

    #[test]
    fn no_gravity_is_not_a_number() {
        assert!(SimplePendulum::new(0.0, 1.0, 1.0, 0.0).state(1.0).0.is_nan());
        assert!(SimplePendulum::new(-9.8, 1.0, 1.0, 0.0).period().is_nan());
    }
}
