//! A bicycle without a rider's hands on it: for which speeds does it stay upright by itself?
//!
//! Its wheels roll without slip, which four constraints on velocities say, and the front wheel touches the ground,
//! which is one on positions. About straight riding it has small motions in lean and steer, whose eigenvalues are
//! held against the published ones (J. P. Meijaard, J. M. Papadopoulos, A. Ruina and A. L. Schwab, *Linearized
//! dynamics equations for the balance and steer of a bicycle: a benchmark and review*, Proc. R. Soc. A 463, 2007).
//!
//! `cargo run --release --example bicycle` draws the eigenvalues against speed.
#![allow(clippy::excessive_precision)]

#[path = "support/checks.rs"]
mod checks;
#[path = "support/mod.rs"]
mod support;

use checks::Checks;
use lagrange_runtime::analysis::{Complex, SmallMotion, stability_threshold};
use lagrange_runtime::chart::{Axis, Chart, Series};
use lagrange_runtime::prelude::*;
use std::error::Error;

lagrangian! {
    /// Whipple's bicycle: a rear frame with a rigid rider, a fork that turns about a tilted axis, and two wheels that
    /// roll without slip. (x, y), point of contact of the rear wheel; z is up.
    pub system Bicycle {
        /// Radii of the wheels, wheelbase, trail, and tilt of the steering axis.
        param rR, rF, w, c, lambda;
        param mR, mB, mH, mF;
        /// Moments of inertia: of the wheels across and along their axles, of the frame and of the fork about axes of
        /// the upright bicycle.
        param iRx, iRy, iFx, iFy, bx, by, bz, bxz, hx, hy, hz, hxz;
        /// Mass centres of frame and fork.
        param xB, zB, xH, zH;
        param g = 9.81;
        coord x, y, psi: angle, phi: angle, pitch: angle, delta: angle, turnR: angle, turnF: angle;
        let lean = frame(world, [x, y, 0], rotation_z(psi) * rotation_x(phi));
        let axle = frame(lean, [0, 0, rR]);
        let rear = frame(axle, [0, 0, 0], rotation_y(pitch));
        let frame_mass = frame(rear, [xB, 0, zB - rR]);
        let head = frame(rear, [w + c, 0, -rR], rotation([-sin(lambda), 0, cos(lambda)], delta));
        let fork_mass = frame(head, [xH - w - c, 0, zH]);
        let wheel = frame(head, [-c, 0, rF]);
        let wR = angular_velocity(axle);
        let wF = angular_velocity(wheel);
        let v = velocity(wheel);
        let up = [wheel.point([1, 0, 0])[2] - wheel.origin()[2], wheel.point([0, 0, 1])[2] - wheel.origin()[2]];
        let s = sqrt(up[0].powi(2) + up[1].powi(2));
        T = particle(mR, axle) + 0.5 * iRx * (wR[0].powi(2) + wR[2].powi(2)) + 0.5 * iRy * (wR[1] + dot(turnR)).powi(2)
            + body(mB, [[bx, 0, bxz], [0, by, 0], [bxz, 0, bz]], frame_mass)
            + body(mH, [[hx, 0, hxz], [0, hy, 0], [hxz, 0, hz]], fork_mass)
            + particle(mF, wheel) + 0.5 * iFx * (wF[0].powi(2) + wF[2].powi(2)) + 0.5 * iFy * (wF[1] + dot(turnF)).powi(2);
        V = g * (mR * axle.origin()[2] + mB * frame_mass.origin()[2] + mH * fork_mass.origin()[2] + mF * wheel.origin()[2]);
        constraint rear_rolls: [dot(x), dot(y)] == [rR * dot(turnR) * cos(psi), rR * dot(turnR) * sin(psi)];
        constraint front_touches: wheel.origin()[2] == rF * s;
        constraint front_rolls: (v[0] * up[1] - v[2] * up[0]) / s == rF * (wF[1] + dot(turnF));
        constraint front_holds: v[1] + rF * (wF[0] * up[1] - wF[2] * up[0]) / s == 0;
    }
}

/// The benchmark of Meijaard, Papadopoulos, Ruina and Schwab, *Proc. R. Soc. A* 463, 2007, table 1; their z is down.
pub(crate) fn benchmark() -> Bicycle {
    Bicycle {
        rR: 0.3,
        rF: 0.35,
        w: 1.02,
        c: 0.08,
        lambda: std::f64::consts::PI / 10.0,
        mR: 2.0,
        mB: 85.0,
        mH: 4.0,
        mF: 3.0,
        iRx: 0.0603,
        iRy: 0.12,
        iFx: 0.1405,
        iFy: 0.28,
        bx: 9.2,
        by: 11.0,
        bz: 2.8,
        bxz: -2.4,
        hx: 0.05892,
        hy: 0.06,
        hz: 0.00708,
        hxz: 0.00756,
        xB: 0.3,
        zB: 0.9,
        xH: 0.9,
        zH: 0.7,
        g: 9.81,
    }
}

/// Table 2 of Meijaard, Papadopoulos, Ruina and Schwab, *Proc. R. Soc. A* 463, 2007: speed (m/s), weave, capsize and
/// castering (1/s).
pub(crate) const PUBLISHED: [(f64, [f64; 2], f64, f64); 10] = [
    (1.0, [3.526_961_709_900_70, 0.807_740_275_199_30], -3.134_231_250_665_78, -7.110_080_146_374_42),
    (2.0, [2.682_345_175_127_45, 1.680_662_965_906_75], -3.071_586_456_415_14, -8.673_879_848_317_35),
    (3.0, [1.706_756_056_639_75, 2.315_824_473_843_25], -2.633_661_372_536_67, -10.351_014_672_459_20),
    (4.0, [0.413_253_315_211_25, 3.079_108_186_032_06], -1.429_444_273_613_26, -12.158_614_265_764_47),
    (5.0, [-0.775_341_882_195_85, 4.464_867_713_788_23], -0.322_866_429_004_09, -14.078_389_692_798_22),
    (6.0, [-1.526_444_865_841_42, 5.876_730_605_987_09], -0.004_066_900_769_70, -16.085_371_230_980_26),
    (7.0, [-2.138_756_442_583_62, 7.195_259_133_298_05], 0.102_681_705_747_66, -18.157_884_661_252_62),
    (8.0, [-2.693_486_835_810_97, 8.460_379_713_969_31], 0.143_278_797_657_13, -20.279_408_943_945_69),
    (9.0, [-3.216_754_022_524_85, 9.693_773_515_317_91], 0.157_901_840_309_17, -22.437_885_590_408_58),
    (10.0, [-3.720_168_404_372_87, 10.906_811_394_762_87], 0.161_053_386_531_72, -24.624_596_350_174_04),
];

/// Straight ahead at this speed.
pub(crate) fn rides(v: f64) -> State<f64, 8> {
    State::new(0.0, [0.0; 8], [v, 0.0, 0.0, 0.0, 0.0, 0.0, v / 0.3, v / 0.35])
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let bicycle = benchmark();
    let small = |v: f64| SmallMotion::steady(&bicycle, &rides(v));
    let mut checks = Checks::default();
    let straight = small(5.0)?;
    println!("small motions in {:?}; {:?} follow", straight.names(), straight.constants());

    let mut off = 0.0f64;
    for (v, [growth, frequency], capsize, castering) in PUBLISHED {
        let found = small(v)?.spectrum()?.eigenvalues;
        for exact in
            [Complex::new(growth, frequency), Complex::new(capsize, 0.0), Complex::new(castering, 0.0)]
        {
            off = off.max(found.iter().map(|z| (z - exact).norm()).fold(f64::INFINITY, f64::min));
        }
    }
    checks.at_most("published eigenvalues (1/s)", off, 1e-12);
    checks.holds("stable by itself at 5 m/s", straight.spectrum()?.is_stable());
    let weave = stability_threshold(small, 4.0, 5.0)?;
    let capsize = stability_threshold(small, 5.0, 7.0)?;
    println!("stable by itself from {weave:.9} to {capsize:.9} m/s");
    checks.at_most("published weave speed (m/s)", (weave - 4.292_382_536_341_11).abs(), 1e-12);
    checks.at_most("published capsize speed (m/s)", (capsize - 6.024_262_015_388_37).abs(), 1e-12);

    // Real parts of the weave, two real roots until they meet, of capsize and castering; the frequency of the weave.
    let mut curves: [Vec<(f64, f64)>; 5] = Default::default();
    for k in 0..=400 {
        let v = 0.025 * f64::from(k);
        let mut all = small(v)?.spectrum()?.eigenvalues;
        all.retain(|z| z.norm() > 0.0);
        all.sort_by(|a, b| a.re.total_cmp(&b.re));
        let real: Vec<f64> = all.iter().filter(|z| z.im == 0.0).map(|z| z.re).collect();
        let oscillates = all.iter().find(|z| z.im > 0.0);
        let roots = match oscillates {
            Some(z) => [Some(z.re), None, real.last().copied(), real.first().copied(), Some(z.im)],
            None => [
                real.get(3).copied(),
                real.get(2).copied(),
                real.get(1).copied(),
                real.first().copied(),
                None,
            ],
        };
        for (curve, root) in curves.iter_mut().zip(roots) {
            curve.extend(root.filter(|x| *x > -10.0).map(|x| (v, x)));
        }
    }
    let [upper, lower, tips, casters, frequency] = curves;
    let folder = support::charts()?;
    Chart::new(
        "Eigenvalues of a bicycle that rides straight ahead",
        Axis::linear("speed", "m/s"),
        Axis::linear("real part, or frequency", "1/s"),
    )
    .subtitle(format!("stable by itself from {weave:.3} to {capsize:.3} m/s"))
    .with(Series::line("weave", upper))
    .with(Series::line("weave, second real root", lower))
    .with(Series::line("capsize", tips))
    .with(Series::line("castering", casters))
    .with(Series::line("frequency of the weave", frequency))
    .write(&folder, "bicycle")?;
    println!("{}", folder.display());
    checks.report()?;
    Ok(())
}
