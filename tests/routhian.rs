//! Reduced systems against the whole ones that they came from, at reproducible random states.

use lagrange_runtime::prelude::*;

/// Errors are measured against the sizes of what is compared; the inertia matrices here are well conditioned.
const TOLERANCE: f64 = 1e-12;

/// Reproducible numbers in [lo, hi) (SplitMix64: Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self, lo: f64, hi: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        lo + (hi - lo) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
}

#[track_caller]
fn assert_close(what: &str, a: &[f64], b: &[f64], terms: &[f64]) {
    let size = a.iter().chain(b).chain(terms).fold(1.0, |most: f64, x| most.max(x.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= TOLERANCE * size, "{what}: {a} against {b}, of terms up to {size}");
    }
}

/// The coordinates of the whole system at these indices.
fn at<const N: usize>(v: &SVector<f64, N>, indices: &[usize]) -> Vec<f64> {
    indices.iter().map(|&i| v[i]).collect()
}

/// All that a reduced system has in common with the whole one.
fn check<Whole, Reduced, const N: usize, const I: usize, const WHOLE: usize>(
    whole: &Whole,
    reduce: impl Fn(&State<f64, WHOLE>) -> (Reduced, State<f64, N>),
) where
    Whole: Lagrangian<WHOLE, Scalar = f64>,
    Reduced: Routhian<N, I, WHOLE, Scalar = f64>,
{
    let ignorable = Whole::FACTS.ignorable;
    let kept: Vec<usize> = (0..WHOLE).filter(|i| !ignorable.contains(i)).collect();
    assert_eq!((kept.len(), ignorable.len()), (N, I));
    assert_eq!(Reduced::FACTS.conservative, Whole::FACTS.conservative);
    let mut random = Random(11);
    for _ in 0..50 {
        let mut numbers = |lo, hi| std::array::from_fn(|_| random.next(lo, hi));
        let start = State::new(0.0, numbers(0.4, 1.4), numbers(-1.5, 1.5));
        let start = State { t: random.next(-2.0, 2.0), ..start };
        let (reduced, State { q, qd, t }) = reduce(&start);
        let out = SVector::from_fn(|k, _| start.q[ignorable[k]]);
        let back = reduced.expand(&State { t, q, qd }, &out);
        assert_eq!((back.t, back.q), (start.t, start.q), "the way back");
        assert_close("velocities", back.qd.as_slice(), start.qd.as_slice(), &[]);

        let (p, p_kept) = (whole.momenta(&start.q, &start.qd, t), reduced.momenta(&q, &qd, t));
        assert_close("momenta", p_kept.as_slice(), &at(&p, &kept), p.as_slice());
        let forces = whole.momentum_rate(&start.q, &start.qd, t);
        let acceleration = whole.accel(&start.q, &start.qd, t);
        let found = reduced.accel(&q, &qd, t);
        assert_close("accelerations", found.as_slice(), &at(&acceleration, &kept), forces.as_slice());
        let work: f64 = ignorable.iter().map(|&i| p[i] * start.qd[i]).sum();
        let l = whole.lagrangian(&start.q, &start.qd, t);
        assert_close("R = L − p·q̇", &[reduced.lagrangian(&q, &qd, t)], &[l - work], &[l, work]);
        let h = whole.energy_function(&start.q, &start.qd, t);
        assert_close("h", &[reduced.energy_function(&q, &qd, t)], &[h], &[l, work]);
        assert_close("power", &[reduced.power(&q, &qd, t)], &[whole.power(&start.q, &start.qd, t)], &[]);
    }
}

/// The energies of a natural reduced system: the apparent potential is −R at rest.
fn check_energies<Reduced: Energies<N, Scalar = f64>, const N: usize>(reduced: &Reduced) {
    let mut random = Random(12);
    for _ in 0..50 {
        let mut vector = |lo, hi| SVector::from_fn(|_, _| random.next(lo, hi));
        let (q, qd) = (vector(0.4, 1.4), vector(-1.5, 1.5));
        let t = random.next(-2.0, 2.0);
        let rest = SVector::from([0.0; N]);
        let apparent = -reduced.lagrangian(&q, &rest, t);
        assert_close("V_eff", &[reduced.potential(&q, t)], &[apparent], &[]);
        assert_close("T at rest", &[reduced.kinetic(&q, &rest, t)], &[0.0], &[]);
        let h = reduced.energy_function(&q, &qd, t);
        assert_close("T + V_eff", &[reduced.energy(&q, &qd, t)], &[h], &[apparent]);
    }
}

#[test]
fn pendulum_on_a_string_of_given_length() {
    lagrangian! {
        pub system Conical {
            param m, a, omega, c, g = 9.81;
            coord theta: angle, phi: angle;
            coord l = 1 + a * sin(omega * t);
            let x = l * sin(theta) * cos(phi);
            let y = l * sin(theta) * sin(phi);
            let z = -l * cos(theta);
            T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
            V = m * g * z;
            D = 0.5 * c * dot(theta).powi(2);
            routhian Swing;
        }
    }
    let whole = Conical::new(0.7, 0.2, 1.3, 0.1);
    check::<_, Swing, 1, 1, 2>(&whole, |s| whole.reduce(s));
    check_energies(&Swing::new(0.7, 0.2, 1.3, 0.1, 0.4));
}

/// A wind that depends on the velocity of the ignorable coordinate, by virtual work.
#[test]
fn beads_on_a_wheel() {
    lagrangian! {
        pub system Wheel {
            const N = 3;
            param I, m, k: [N], c, b;
            coord x: [length; N], turn: angle;
            let px: [N] = |i| x[i] * cos(turn);
            let py: [N] = |i| x[i] * sin(turn);
            T = 0.5 * I * dot(turn).powi(2)
                + (0..N).map(|i| 0.5 * m * (dot(px[i]).powi(2) + dot(py[i]).powi(2))).sum();
            V = (0..N).map(|i| 0.5 * k[i] * (x[i] - 1).powi(2)).sum();
            D = 0.5 * c * dot(x[0]).powi(2);
            force [-b * dot(turn) * cos(turn), -b * dot(turn) * sin(turn)] at [px[1], py[1]];
            Q[x[2]] = b * sin(t) * dot(turn);
            routhian Beads;
        }
    }
    let whole = Wheel::new(1.0, 0.5, [2.0, 3.0, 4.0], 0.1, 0.3);
    check::<_, Beads, 3, 1, 4>(&whole, |s| whole.reduce(s));
    check_energies(&Beads::new(1.0, 0.5, [2.0, 3.0, 4.0], 0.1, 0.3, 1.2));
}

/// Coupled velocities: R has terms linear in q̇, the inertia of what is left is a Schur complement.
#[test]
fn ignorable_coordinates_coupled_with_all_others() {
    lagrangian! {
        pub system Coupled {
            param a, b, c;
            coord u: [3], x, v, y;
            T = 0.5 * (u.map(|u| dot(u)).norm_squared() * (2 + x.sin()) + 3 * dot(v).powi(2) * (1 + y * y)
                + 4 * dot(x).powi(2) + 5 * dot(y).powi(2))
                + 0.3 * dot(u[0]) * dot(u[1]) + 0.2 * a * dot(u[2]) * dot(v) * cos(y)
                + 0.4 * b * dot(x) * dot(u[1]) * x + 0.5 * c * dot(y) * dot(v) + 0.3 * dot(x) * dot(y);
            V = x.powi(2) * y + y.powi(4);
            routhian Rest;
        }
    }
    let whole = Coupled::new(0.8, 0.7, 0.6);
    check::<_, Rest, 2, 4, 6>(&whole, |s| whole.reduce(s));
}

/// A charge in a magnetic field, with terms of the first degree in the velocities.
#[test]
fn charge_in_a_magnetic_field() {
    lagrangian! {
        pub system Charge {
            param m, b, e;
            coord r: length, phi: angle, z: length;
            L = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2) + dot(z).powi(2))
                + 0.5 * b * r.powi(2) * dot(phi) + e * r * dot(z) - r.powi(2) * sin(t);
            Q[r] = -e * dot(phi) * dot(r);
            routhian Radial;
        }
    }
    let whole = Charge::new(1.1, 0.8, 0.3);
    check::<_, Radial, 1, 2, 3>(&whole, |s| whole.reduce(s));
}

/// D depends on the velocity of the ignorable coordinate, but Q takes the force back.
#[test]
fn friction_without_a_force_on_the_ignorable_coordinate() {
    lagrangian! {
        pub system Belt {
            param m, c, k;
            coord x: length, s: length;
            T = 0.5 * m * (dot(x).powi(2) + 2 * dot(s).powi(2)) + 0.5 * dot(x) * dot(s);
            V = 0.5 * k * x.powi(2);
            D = 0.5 * c * (dot(x) - dot(s)).powi(2);
            Q[s] = -c * (dot(x) - dot(s));
            routhian Block;
        }
    }
    let whole = Belt::new(1.0, 0.4, 2.0);
    check::<_, Block, 1, 1, 2>(&whole, |s| whole.reduce(s));
    let (block, state) = whole.reduce(&State::new(0.0, [0.3, 0.0], [0.5, -0.4]));
    assert_eq!(block.dissipation(&state.q, &state.qd, 0.0), 0.0, "the friction is in Q");
}
