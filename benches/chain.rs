//! Emitted `accel` of the chain of n links against an expert's loop: ratios of times in one run.
//!
//! `cargo bench --bench chain`, also with `RUSTFLAGS="-C target-cpu=native"`; a word after `--` selects rows by name.
//!
//! The expert solves a tridiagonal system for the tensions of the massless links: link i pulls bob i towards bob i − 1,
//! and the acceleration of one relative to the other along the link is −l θ̇². It is eliminated from the tip, or from
//! both ends at once, which halves the way through it; sines and cosines are the standard library's, or a branch-free
//! polynomial that becomes vector instructions. The quickest of the four counts. Inverse masses and lengths are
//! computed beforehand. Inputs are independent of each other (256 states in turn), or each is made dependent on the
//! result before.
//!
//! With `-- steps rk4 unit 1000` (or `dop853`; `symbolic`, `precomputed`) it makes that many steps of a chain of 8
//! links and ends, for counting instructions: the difference of two counts is free of everything but steps.

#![allow(missing_docs)]

mod support;

use lagrange_runtime::prelude::*;
use nalgebra::SVector;
use std::hint::black_box;
use support::{Random, consume, ratio};

type Vector<const N: usize> = SVector<f64, N>;

const G: f64 = 9.81;

/// Chains of that many links, with unit masses and lengths and with parameters for them.
macro_rules! chains {
    ($($module:ident $n:tt),*) => {$(
        mod $module {
            use super::*;

            lagrangian! {
                pub system Unit {
                    const N = $n;
                    coord th: [N];
                    let x: [N] = |i| if i == 0 { 0 } else { x[i - 1] } + th[i].sin();
                    let y: [N] = |i| if i == 0 { 0 } else { y[i - 1] } - th[i].cos();
                    T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                    V = (0..N).map(|i| 9.81 * y[i]).sum();
                }
            }

            lagrangian! {
                pub system Symbolic {
                    const N = $n;
                    param m: [N], l: [N], g = 9.81;
                    coord th: [N];
                    let x: [N] = |i| if i == 0 { 0 } else { x[i - 1] } + l[i] * th[i].sin();
                    let y: [N] = |i| if i == 0 { 0 } else { y[i - 1] } - l[i] * th[i].cos();
                    T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
                    V = (0..N).map(|i| m[i] * g * y[i]).sum();
                }
            }

            /// Masses and lengths.
            pub fn parameters() -> ([f64; $n], [f64; $n]) {
                (std::array::from_fn(|i| 0.5 + 0.1 * i as f64), std::array::from_fn(|i| 1.2 - 0.02 * i as f64))
            }

            pub fn run(only: &str) {
                let (m, l) = parameters();
                compare::<_, $n>(only, concat!("unit, n = ", $n), Unit::new(), &UnitLinks);
                compare::<_, $n>(only, concat!("symbolic, n = ", $n), Symbolic::new(m, l).precomputed(), &Links::new(m, l));
            }
        }
    )*

        fn chains(only: &str) {
            $($module::run(only);)*
        }
    };
}

chains!(two 2, three 3, four 4, six 6, eight 8, twelve 12, sixteen 16, twenty_four 24, thirty_two 32);

/// Quantities on which the tensions depend: u = 1/m, l and 1/l of each link.
trait Chain {
    fn u(&self, i: usize) -> f64;
    fn l(&self, i: usize) -> f64;
    fn r(&self, i: usize) -> f64;
}

struct UnitLinks;

impl Chain for UnitLinks {
    #[inline(always)]
    fn u(&self, _: usize) -> f64 {
        1.0
    }
    #[inline(always)]
    fn l(&self, _: usize) -> f64 {
        1.0
    }
    #[inline(always)]
    fn r(&self, _: usize) -> f64 {
        1.0
    }
}

struct Links<const N: usize> {
    u: [f64; N],
    l: [f64; N],
    r: [f64; N],
}

impl<const N: usize> Links<N> {
    fn new(m: [f64; N], l: [f64; N]) -> Self {
        Links { u: m.map(f64::recip), l, r: l.map(f64::recip) }
    }
}

impl<const N: usize> Chain for Links<N> {
    #[inline(always)]
    fn u(&self, i: usize) -> f64 {
        self.u[i]
    }
    #[inline(always)]
    fn l(&self, i: usize) -> f64 {
        self.l[i]
    }
    #[inline(always)]
    fn r(&self, i: usize) -> f64 {
        self.r[i]
    }
}

/// a b + c, fused where the target has the instruction.
#[inline(always)]
fn mul_add(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(target_feature = "fma") { a.mul_add(b, c) } else { a * b + c }
}

/// Sine and cosine without branches, to about 1 ulp for |x| < 1e5: reduction by π/2 in parts (Cody and Waite),
/// polynomials of fdlibm (Sun, 1993).
#[inline(always)]
#[allow(clippy::excessive_precision)]
fn sin_cos(x: f64) -> (f64, f64) {
    const ROUND: f64 = 1.5 * (1u64 << 52) as f64;
    let shifted = mul_add(x, std::f64::consts::FRAC_2_PI, ROUND);
    let (k, quarters) = (shifted - ROUND, shifted.to_bits());
    let r = if cfg!(target_feature = "fma") {
        mul_add(k, -6.12323399573676603587e-17, mul_add(k, -std::f64::consts::FRAC_PI_2, x))
    } else {
        ((x - k * 1.57079632673412561417e+00) - k * 6.07710050630396597660e-11)
            - k * 2.02226624879595063154e-21
    };
    let z = r * r;
    let mut s = 1.58969099521155010221e-10;
    for c in [-2.50507602534068634195e-08, 2.75573137070700676789e-06, -1.98412698298579493134e-04] {
        s = mul_add(s, z, c);
    }
    let s = mul_add(s, z, 8.33333333332248946124e-03);
    let s = mul_add(s, z, -1.66666666666666324348e-01);
    let s = mul_add(r * z, s, r);
    let mut c = -1.13596475577881948265e-11;
    for k in [2.08757232129817482790e-09, -2.75573143513906633035e-07, 2.48015872894767294178e-05] {
        c = mul_add(c, z, k);
    }
    let c = mul_add(c, z, -1.38888888888741095749e-03);
    let c = mul_add(c, z, 4.16666666666666019037e-02);
    let c = mul_add(z * z, c, mul_add(-0.5, z, 1.0));
    let (s, c) = (s.to_bits(), c.to_bits());
    let change = (s ^ c) & (quarters & 1).wrapping_neg();
    (
        f64::from_bits(s ^ change ^ (quarters & 2) << 62),
        f64::from_bits(c ^ change ^ (quarters.wrapping_add(1) & 2) << 62),
    )
}

/// Accelerations by the tensions, eliminated from the tip, or from both ends; the sines the standard library's or
/// branch-free.
#[inline(always)]
fn by_hand<const N: usize, const BOTH_ENDS: bool, const BRANCH_FREE: bool>(
    p: &impl Chain,
    q: &Vector<N>,
    w: &Vector<N>,
) -> Vector<N> {
    let (mut s, mut c) = ([0.0; N], [0.0; N]);
    for i in 0..N {
        (s[i], c[i]) = if BRANCH_FREE { sin_cos(q[i]) } else { q[i].sin_cos() };
    }
    // Rows −u[i−1] cos t[i−1] + (u[i−1] + u[i]) t[i] − u[i] cos t[i+1] = l[i] θ̇[i]², the first one with gravity and
    // without u[−1].
    let (mut off, mut across, mut y, mut d) = ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
    for i in 1..N {
        off[i] = p.u(i - 1) * mul_add(c[i], c[i - 1], s[i] * s[i - 1]);
        across[i] = p.u(i - 1) * mul_add(s[i], c[i - 1], -(c[i] * s[i - 1]));
    }
    for i in 0..N {
        y[i] = p.l(i) * w[i] * w[i];
    }
    y[0] = mul_add(G, c[0], y[0]);
    let diagonal = |i: usize| if i == 0 { p.u(0) } else { p.u(i - 1) + p.u(i) };
    let mut t = [0.0; N];
    // From the tip down to where the two meet, from the root up to there, and back.
    let middle = if BOTH_ENDS { N / 2 } else { 0 };
    for k in 0..N {
        if N - 1 - k > middle {
            let i = N - 1 - k;
            let (mut under, mut right) = (diagonal(i), y[i]);
            if i + 1 < N {
                let e = off[i + 1] * d[i + 1];
                (under, right) = (mul_add(-e, off[i + 1], under), mul_add(e, y[i + 1], right));
            }
            (d[i], y[i]) = (1.0 / under, right);
        }
        if k < middle {
            let (mut under, mut right) = (diagonal(k), y[k]);
            if k > 0 {
                let e = off[k] * d[k - 1];
                (under, right) = (mul_add(-e, off[k], under), mul_add(e, y[k - 1], right));
            }
            (d[k], y[k]) = (1.0 / under, right);
        }
    }
    let (mut under, mut right) = (diagonal(middle), y[middle]);
    if middle > 0 {
        let e = off[middle] * d[middle - 1];
        (under, right) = (mul_add(-e, off[middle], under), mul_add(e, y[middle - 1], right));
    }
    if middle + 1 < N {
        let e = off[middle + 1] * d[middle + 1];
        (under, right) = (mul_add(-e, off[middle + 1], under), mul_add(e, y[middle + 1], right));
    }
    t[middle] = right / under;
    for k in 1..N {
        if k <= middle {
            let i = middle - k;
            t[i] = mul_add(off[i + 1], t[i + 1], y[i]) * d[i];
        }
        if middle + k < N {
            let i = middle + k;
            t[i] = mul_add(off[i], t[i - 1], y[i]) * d[i];
        }
    }
    // `across` has u[i−1]; what pulls bob i at its far end needs u[i], which is that of the next.
    Vector::from_fn(|i, _| {
        let near = if i == 0 { -G * s[0] } else { -t[i - 1] * across[i] };
        let far = if i + 1 < N { t[i + 1] * across[i + 1] } else { 0.0 };
        p.r(i) * (near + far)
    })
}

/// Calls for all states: with their own, or each with what the result before adds, which is nothing.
#[inline(always)]
fn all<const N: usize>(
    dependent: bool,
    states: &[(Vector<N>, Vector<N>)],
    accel: impl Fn(&Vector<N>, &Vector<N>) -> Vector<N>,
) {
    let states = black_box(states);
    if dependent {
        let mut before = Vector::zeros();
        for (q, w) in states {
            before = accel(&(q + before * 1e-200), w);
        }
        consume(before);
    } else {
        for (q, w) in states {
            consume(accel(q, w));
        }
    }
}

/// Measures one system against the four ways by hand and prints its row.
fn compare<Sys, const N: usize>(only: &str, name: &str, system: Sys, links: &impl Chain)
where
    Sys: Lagrangian<N, Scalar = f64>,
{
    if !name.contains(only) {
        return;
    }
    const STATES: usize = 256;
    let mut random = Random(17);
    let mut state = || {
        let q = Vector::from_fn(|_, _| std::f64::consts::PI * random.next());
        (q, Vector::from_fn(|_, _| 2.0 * random.next()))
    };
    let states: Vec<(Vector<N>, Vector<N>)> = (0..STATES).map(|_| state()).collect();
    let mut cells = Vec::new();
    for dependent in [false, true] {
        macro_rules! against {
            ($both_ends:literal, $branch_free:literal) => {{
                for (q, w) in &states {
                    let (ours, theirs) =
                        (system.accel(q, w, 0.0), by_hand::<N, $both_ends, $branch_free>(links, q, w));
                    let difference = (ours - theirs).amax() / theirs.amax();
                    assert!(difference < 1e-11, "{name}: the two sides differ by {difference:e}");
                }
                let ours = || {
                    let system = black_box(&system);
                    all(dependent, &states, |q, w| system.accel(q, w, 0.0));
                };
                let theirs = || {
                    let links = black_box(links);
                    all(dependent, &states, |q, w| by_hand::<N, $both_ends, $branch_free>(links, q, w));
                };
                let by = ["one end", "both ends"][usize::from($both_ends)];
                let sines = ["library", "vector"][usize::from($branch_free)];
                (ratio(STATES, ours, theirs), format!("{by}, {sines}"))
            }};
        }
        let all =
            [against!(false, false), against!(false, true), against!(true, false), against!(true, true)];
        let quickest = all.into_iter().max_by(|(a, _), (b, _)| a.median.total_cmp(&b.median));
        let Some((r, way)) = quickest else { unreachable!("there are four") };
        cells.push(format!(
            "{:.3} | {:.3} – {:.3} | {:.1} | {:.1} | {way}",
            r.median, r.quartiles[0], r.quartiles[1], r.nanoseconds[0], r.nanoseconds[1]
        ));
    }
    println!("| {name} | {} | {} |", cells[0], cells[1]);
}

/// The state after `count` equal steps.
fn steps<Sys, M>(system: &Sys, method: M, count: u32)
where
    Sys: System<8, Scalar = f64>,
    M: Method<Sys, 8>,
    FixedStep<f64>: lagrange_runtime::Controller<f64, 8, M::Error>,
{
    const H: f64 = 1e-3;
    let start = State::new(0.0, [0.3; 8], [0.1; 8]);
    consume(
        integrate(black_box(system), method, FixedStep::new(H), start)
            .until(f64::from(count) * H)
            .final_state(),
    );
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    if let [mode, method, which, count, ..] = words.as_slice()
        && mode == "steps"
        && let Ok(count) = count.parse()
    {
        let ((m, l), unit) = (eight::parameters(), eight::Unit::new());
        let symbolic = eight::Symbolic::new(m, l);
        let prepared = symbolic.precomputed();
        return match (method.as_str(), which.as_str()) {
            ("rk4", "unit") => steps(&unit, Rk4, count),
            ("rk4", "symbolic") => steps(&symbolic, Rk4, count),
            ("rk4", _) => steps(&prepared, Rk4, count),
            (_, "unit") => steps(&unit, Dop853, count),
            (_, "symbolic") => steps(&symbolic, Dop853, count),
            _ => steps(&prepared, Dop853, count),
        };
    }
    let only = std::env::args().skip(1).find(|word| !word.starts_with('-')).unwrap_or_default();
    let columns = "emitted / hand | quartiles | ns emitted | ns hand | by hand";
    println!("| links | independent: {columns} | dependent: {columns} |");
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    chains(&only);
}
