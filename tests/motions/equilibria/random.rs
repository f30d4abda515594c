//! Random potentials with and without symmetries, in curved coordinates that move with the parameter, against closed
//! forms.

use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A polynomial potential of (X, Y), which are curved coordinates in the plane of (u, v), turned by the angle
    /// `turn` and shifted with the parameter.
    system Landscape {
        param mu, a, c: [2], m: [2], g: [2], beta, cubic, tilt, slope, turn, bend, shift: [2];
        coord u, v;
        let p = u - shift[0] * mu;
        let r = v - shift[1] * mu - 0.3;
        let Y = turn.sin() * p + turn.cos() * r;
        let X = turn.cos() * p - turn.sin() * r + bend * Y.powi(2);
        T = 0.5 * (dot(u).powi(2) + dot(v).powi(2)) + 0.1 * dot(u) * dot(v);
        V = 0.5 * (c[0] - (mu - a) * m[0]) * X.powi(2) + 0.5 * (c[1] - (mu - a) * m[1]) * Y.powi(2)
            + 0.25 * g[0] * X.powi(4) + 0.25 * g[1] * Y.powi(4) + 0.5 * beta * X.powi(2) * Y.powi(2)
            + cubic / 3.0 * X.powi(3) + (tilt - slope * mu) * X;
    }
}

/// Numbers in [0, 1), by a generator of its own for each seed (Steele et al. 2014, SplitMix64).
struct Draw(u64);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }
}

/// One landscape, and how finely its curves are followed.
struct Case {
    system: Landscape,
    step: f64,
}

impl Case {
    /// Coordinates of the point (X, Y).
    fn at(&self, mu: f64, [x, y]: [f64; 2]) -> [f64; 2] {
        let Landscape { turn, bend, shift, .. } = self.system;
        let along = x - bend * y * y;
        let (sin, cos) = turn.sin_cos();
        [cos * along + sin * y + shift[0] * mu, -sin * along + cos * y + shift[1] * mu + 0.3]
    }

    /// (X, Y) of a point.
    fn curved(&self, mu: f64, q: &[f64]) -> [f64; 2] {
        let Landscape { turn, bend, shift, .. } = self.system;
        let (p, r) = (q[0] - shift[0] * mu, q[1] - shift[1] * mu - 0.3);
        let (sin, cos) = turn.sin_cos();
        let y = sin * p + cos * r;
        [cos * p - sin * r + bend * y * y, y]
    }

    /// Follows the curve through (X, Y), and compares its bifurcations with those given: kinds, parameters and places
    /// (X, Y).
    fn follows(
        &self,
        name: &str,
        start: (f64, [f64; 2]),
        heading: &Heading,
        mut expected: Vec<(BifurcationKind, f64, [f64; 2])>,
        on_curve: impl Fn(f64, [f64; 2]) -> f64,
    ) {
        let family = |mu: Dual<f64>| Landscape { mu, ..self.system.map(Dual::constant) };
        let a = self.system.a;
        let path = Path { range: (a - 1.0, a + 1.0), step: self.step, steps: 20_000 };
        let branch = follow(&family, &self.at(start.0, start.1), start.0, heading, &path)
            .unwrap_or_else(|error| panic!("{name}, step {}: {error}", self.step));
        assert!(branch.complete, "{name}, step {}: {} points", self.step, branch.points.len());
        for point in &branch.points {
            let [x, y] = self.curved(point.parameter, point.q.as_slice());
            let off = on_curve(point.parameter, [x, y]).abs();
            assert!(
                off < 1e-9,
                "{name}, step {}: off by {off:e} at μ − a = {:e}, X = {x}, Y = {y}",
                self.step,
                point.parameter - a
            );
        }
        let mut found: Vec<_> =
            branch.bifurcations.iter().map(|b| (b, self.curved(b.parameter, b.q.as_slice()))).collect();
        // Of two at one parameter the one with the lesser X first.
        let order = |a: (f64, f64), b: (f64, f64)| {
            if (a.0 - b.0).abs() < 1e-9 { a.1.total_cmp(&b.1) } else { a.0.total_cmp(&b.0) }
        };
        found.sort_by(|a, b| order((a.0.parameter, a.1[0]), (b.0.parameter, b.1[0])));
        expected.sort_by(|a, b| order((a.1, a.2[0]), (b.1, b.2[0])));
        let kinds = || found.iter().map(|(b, _)| (b.kind, b.parameter - a)).collect::<Vec<_>>();
        let wanted = || expected.iter().map(|e| (e.0, e.1 - a)).collect::<Vec<_>>();
        assert_eq!(
            found.len(),
            expected.len(),
            "{name}, step {}: {:?} for {:?}",
            self.step,
            kinds(),
            wanted()
        );
        for ((found, [x, y]), (kind, parameter, place)) in found.iter().zip(&expected) {
            let off = (found.parameter - parameter).abs();
            let aside = (x - place[0]).hypot(y - place[1]);
            assert!(
                found.kind == *kind && off < 1e-11 && aside < 2e-6,
                "{name}, step {}: {:?} off by {off:e} and {aside:e} for {kind:?} at {:e}",
                self.step,
                found.kind,
                parameter - a
            );
        }
    }
}

/// A landscape of a kind, otherwise random.
fn landscape(draw: &mut Draw) -> Landscape {
    Landscape {
        mu: 0.0,
        a: draw.between(-0.5, 0.5),
        c: [0.0; 2],
        m: [0.0; 2],
        g: [draw.between(0.3, 3.0); 2],
        beta: 0.0,
        cubic: 0.0,
        tilt: 0.0,
        slope: 0.0,
        turn: draw.between(0.0, 6.2),
        bend: draw.between(-0.3, 0.3),
        shift: [draw.between(-0.4, 0.4), draw.between(-0.4, 0.4)],
    }
}

/// Follows the curves of the random potential of this number.
fn landscape_is_followed(seed: u64) {
    use BifurcationKind::*;
    let draw = &mut Draw(seed);
    let mut system = landscape(draw);
    let step = 10f64.powf(draw.between(-2.0, -0.4));
    let Landscape { a, g: [g, _], .. } = system;
    match seed % 6 {
        // A pitchfork, from below, from above, and from its own curve.
        0 => {
            system.m = [1.0, 0.0];
            system.c = [0.0, draw.between(0.2, 4.0)];
            system.g = [g * draw.sign(), 0.0];
            let case = Case { system, step };
            let all = || vec![(Pitchfork, a, [0.0; 2])];
            let trivial = |_: f64, [x, y]: [f64; 2]| x.abs().max(y.abs());
            case.follows("pitchfork", (a - 0.93, [0.0; 2]), &Heading::Up, all(), trivial);
            case.follows("pitchfork", (a + 0.87, [0.0; 2]), &Heading::Down, all(), trivial);
            let g = system.g[0];
            let mu = a + 0.8 * g.signum();
            let heading = if g > 0.0 { Heading::Down } else { Heading::Up };
            let x = draw.sign() * ((mu - a) / g).sqrt();
            case.follows("pitchfork aside", (mu, [x, 0.0]), &heading, all(), |mu, [x, y]| {
                (mu - a - g * x * x).abs().max(y.abs())
            });
        }
        // An imperfect pitchfork has none, and a fold on one curve.
        1 => {
            system.m = [1.0, 0.0];
            system.c = [0.0, draw.between(0.2, 4.0)];
            let e = draw.sign() * 10f64.powf(draw.between(-11.0, -1.0));
            system.tilt = e;
            let case = Case { system, step };
            let on = |side: f64| {
                move |mu: f64, [x, y]: [f64; 2]| {
                    let here = if x * side > 0.0 { 0.0 } else { 1.0 };
                    (((a - mu) * x + g * x.powi(3) + e).abs() + here).max(y.abs())
                }
            };
            let first = {
                // (μ − a) X = g X³ + e at μ = a − 0.9.
                let mut x = e / -0.9;
                for _ in 0..60 {
                    x -= (0.9 * x + g * x.powi(3) + e) / (0.9 + 3.0 * g * x * x);
                }
                x
            };
            case.follows("imperfect", (a - 0.9, [first, 0.0]), &Heading::Up, vec![], on(-e));
            let mut x = e.signum() * (0.9 / g).sqrt();
            for _ in 0..60 {
                x -= (-0.9 * x + g * x.powi(3) + e) / (-0.9 + 3.0 * g * x * x);
            }
            let fold = (e / (2.0 * g)).cbrt();
            let expected = vec![(Fold, a + 3.0 * g * fold * fold, [fold, 0.0])];
            case.follows("beside", (a + 0.9, [x, 0.0]), &Heading::Down, expected, on(e));
        }
        2 => {
            system.m = [1.0, 0.0];
            system.c = [0.0, draw.between(0.2, 4.0)];
            system.g = [0.0; 2];
            let f = draw.sign() * draw.between(0.3, 2.0);
            system.cubic = f;
            let case = Case { system, step };
            let all = || vec![(Transcritical, a, [0.0; 2])];
            case.follows("transcritical", (a - 0.9, [0.0; 2]), &Heading::Up, all(), |_, [x, y]| {
                x.abs().max(y.abs())
            });
            case.follows(
                "transcritical aside",
                (a - 0.8, [-0.8 / f, 0.0]),
                &Heading::Up,
                all(),
                |mu, [x, y]| (mu - a - f * x).abs().max(y.abs()),
            );
        }
        // μ = a + (g X³ − w X + e)/l turns back twice.
        3 => {
            system.m = [0.0; 2];
            let w = 10f64.powf(draw.between(-1.5, -0.3));
            let l = draw.sign() * draw.between(0.5, 1.5);
            system.c = [-w, draw.between(0.2, 4.0)];
            system.g = [g, 0.0];
            system.slope = l;
            system.tilt = l * a;
            let case = Case { system, step };
            let fold = (w / (3.0 * g)).sqrt();
            let mu = |x: f64| a + (g * x.powi(3) - w * x) / l;
            if mu(fold).abs() > 10.0 || (mu(fold) - a).abs() > 0.95 {
                return;
            }
            let all = vec![(Fold, mu(fold), [fold, 0.0]), (Fold, mu(-fold), [-fold, 0.0])];
            let mut x = -l.signum() * (0.98 * l.abs() / g).cbrt();
            for _ in 0..200 {
                x -= (mu(x) - a + 0.98) * l / (3.0 * g * x * x - w);
            }
            case.follows("folds", (a - 0.98, [x, 0.0]), &Heading::Up, all, |at, [x, y]| {
                (mu(x) - at).abs().max(y.abs())
            });
        }
        // Two eigenvalues vanish at once: of symmetric squares.
        4 => {
            system.m = [1.0; 2];
            system.beta = g * draw.between(-0.5, 2.5);
            let case = Case { system, step };
            let all = || vec![(Multiple, a, [0.0; 2])];
            let trivial = |_: f64, [x, y]: [f64; 2]| x.abs().max(y.abs());
            case.follows("double", (a - 0.9, [0.0; 2]), &Heading::Up, all(), trivial);
            case.follows("double", (a + 0.9, [0.0; 2]), &Heading::Down, all(), trivial);
            case.follows(
                "double aside",
                (a + 0.9, [(0.9 / g).sqrt(), 0.0]),
                &Heading::Down,
                all(),
                |mu, [x, y]| (mu - a - g * x * x).abs().max(y.abs()),
            );
        }
        // The same, nearly: two pitchforks, and a third where a curve from one is crossed by one to the other.
        _ => {
            system.m = [1.0; 2];
            let delta = 10f64.powf(draw.between(-5.0, -1.0));
            system.c = [0.0, delta];
            let ratio = draw.between(-0.5, 1.9);
            system.beta = g * ratio;
            let case = Case { system, step };
            let trivial = |_: f64, [x, y]: [f64; 2]| x.abs().max(y.abs());
            let both = vec![(Pitchfork, a, [0.0; 2]), (Pitchfork, a + delta, [0.0; 2])];
            case.follows("nearly double", (a - 0.9, [0.0; 2]), &Heading::Up, both, trivial);
            let mut all = vec![(Pitchfork, a, [0.0; 2])];
            let second = delta / (1.0 - ratio);
            if ratio < 1.0 && second < 0.99 {
                let x = (second / g).sqrt();
                all.extend([(Pitchfork, a + second, [x, 0.0]), (Pitchfork, a + second, [-x, 0.0])]);
            }
            if ratio < 1.0 && (0.89..1.01).contains(&second) {
                return;
            }
            case.follows(
                "nearly double aside",
                (a + 0.9, [(0.9 / g).sqrt(), 0.0]),
                &Heading::Down,
                all,
                |mu, [x, y]| (mu - a - g * x * x).abs().max(y.abs()),
            );
        }
    }
}

#[test]
fn random_potentials() {
    (0..if cfg!(feature = "long") { 12 } else { 4 }).for_each(landscape_is_followed);
}

/// `cargo test --release -p lagrange-motions --test equilibria -- --ignored many_random`
#[test]
#[ignore = "takes a minute"]
fn many_random_potentials() {
    (0..200).for_each(landscape_is_followed);
}
