//! Random linear systems of every kind.

use lagrange_runtime::analysis::{DMatrix, DVector};

/// Random numbers (Steele, Lea and Flood, *Fast splittable pseudorandom number generators*, 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Random(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// Uniform between the two.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 * 2f64.powi(-53))
    }

    /// An integer from `low` to `high`.
    fn integer(&mut self, low: i32, high: i32) -> f64 {
        f64::from(low) + (self.bits() % (high - low + 1) as u64) as f64
    }

    fn matrix(&mut self, n: usize) -> DMatrix<f64> {
        DMatrix::from_fn(n, n, |_, _| self.between(-1.0, 1.0))
    }

    /// `A Aᵀ + x 1`
    fn definite(&mut self, n: usize, x: f64) -> DMatrix<f64> {
        let a = self.matrix(n);
        symmetric(&a * a.transpose() + DMatrix::identity(n, n) * x)
    }

    fn antisymmetric(&mut self, n: usize) -> DMatrix<f64> {
        let a = self.matrix(n);
        &a - a.transpose()
    }

    /// An integer matrix of determinant 1.
    fn unimodular(&mut self, n: usize) -> DMatrix<f64> {
        let mut lower = DMatrix::identity(n, n);
        let mut upper = DMatrix::identity(n, n);
        for i in 0..n {
            for j in 0..i {
                lower[(i, j)] = self.integer(-1, 1);
                upper[(j, i)] = self.integer(-1, 1);
            }
        }
        lower * upper
    }

    fn size(&mut self) -> usize {
        self.integer(1, 5) as usize
    }
}

fn symmetric(a: DMatrix<f64>) -> DMatrix<f64> {
    let mut a = a;
    a.fill_lower_triangle_with_upper_triangle();
    a
}

pub struct System {
    pub m: DMatrix<f64>,
    pub c: DMatrix<f64>,
    pub k: DMatrix<f64>,
}

impl System {
    /// In other coordinates, `Tᵀ A T`.
    fn turned(self, t: &DMatrix<f64>) -> Self {
        let turned = |a: DMatrix<f64>| {
            let (even, odd) = ((&a + a.transpose()) * 0.5, (&a - a.transpose()) * 0.5);
            let odd = (t.transpose() * odd * t).lower_triangle();
            symmetric(t.transpose() * even * t) + &odd - odd.transpose()
        };
        System { m: turned(self.m), c: turned(self.c), k: turned(self.k) }
    }
}

impl System {
    /// Each entry off by a part of itself, symmetric ones alike.
    pub fn rounded(&self, random: &mut Random, part: f64) -> Self {
        let mut rounded = |a: &DMatrix<f64>| {
            let n = a.nrows();
            let mut other = a.clone();
            for j in 0..n {
                for i in 0..=j {
                    let x = 1.0 + random.between(-part, part);
                    other[(i, j)] *= x;
                    other[(j, i)] = if a[(j, i)] == a[(i, j)] { other[(i, j)] } else { a[(j, i)] * x };
                }
            }
            other
        };
        System { m: rounded(&self.m), c: rounded(&self.c), k: rounded(&self.k) }
    }
}

type Family = (&'static str, fn(&mut Random) -> System);

pub const FAMILIES: [Family; 13] = [
    ("damped", damped),
    ("light", light),
    ("gyroscopic", gyroscopic),
    ("circulatory", circulatory),
    ("unstable", unstable),
    ("free", free),
    ("free, rounded", free_rounded),
    ("overdamped", overdamped),
    ("partly so", partly_overdamped),
    ("repeated", repeated),
    ("defective", defective),
    ("units", units),
    ("integers", integers),
];

fn damped(random: &mut Random) -> System {
    let n = random.size();
    let c = random.between(0.01, 2.0);
    System { m: random.definite(n, 0.1), c: random.definite(n, 0.0) * c, k: random.definite(n, 0.01) }
}

fn light(random: &mut Random) -> System {
    let c = 10f64.powf(random.between(-20.0, -2.0));
    let system = damped(random);
    System { c: system.c * c, ..system }
}

fn gyroscopic(random: &mut Random) -> System {
    let n = random.integer(2, 5) as usize;
    let g = 10f64.powf(random.between(-2.0, 3.0));
    let k = if random.between(0.0, 1.0) < 0.5 { 1.0 } else { -1.0 };
    System { m: random.definite(n, 0.1), c: random.antisymmetric(n) * g, k: random.definite(n, 0.01) * k }
}

fn circulatory(random: &mut Random) -> System {
    let n = random.integer(2, 5) as usize;
    let k = random.definite(n, 0.01) + random.antisymmetric(n) * 0.3;
    System { m: random.definite(n, 0.1), c: random.matrix(n), k }
}

fn unstable(random: &mut Random) -> System {
    let n = random.size();
    let a = random.matrix(n);
    System { m: random.definite(n, 0.1), c: random.matrix(n), k: symmetric(&a + a.transpose()) }
}

/// A chain of masses in a row that nothing holds, with springs and dampers between them, in random order.
fn chain(random: &mut Random, number: impl Fn(&mut Random) -> f64) -> System {
    let n = random.integer(2, 5) as usize;
    let mut order: Vec<usize> = (0..n).collect();
    for i in 1..n {
        order.swap(i, random.integer(0, i as i32) as usize);
    }
    let m = DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| number(random)));
    let [mut c, mut k] = [DMatrix::zeros(n, n), DMatrix::zeros(n, n)];
    for pair in order.windows(2) {
        for a in [&mut c, &mut k] {
            let x = number(random);
            let (i, j) = (pair[0], pair[1]);
            a[(i, i)] += x;
            a[(j, j)] += x;
            a[(i, j)] -= x;
            a[(j, i)] -= x;
        }
    }
    // Some of them slide in oil.
    if random.between(0.0, 1.0) < 0.3 {
        c[(0, 0)] += number(random);
    }
    System { m, c, k }
}

fn free(random: &mut Random) -> System {
    chain(random, |random| random.integer(1, 9))
}

fn free_rounded(random: &mut Random) -> System {
    chain(random, |random| random.between(0.1, 9.0))
}

fn overdamped(random: &mut Random) -> System {
    let c = 10f64.powf(random.between(1.0, 8.0));
    let system = damped(random);
    let n = system.c.nrows();
    System { c: (system.c + DMatrix::identity(n, n) * 0.1) * c, ..system }
}

/// Dampers on some of the coordinates.
fn partly_overdamped(random: &mut Random) -> System {
    let c = 10f64.powf(random.between(1.0, 8.0));
    let system = damped(random);
    let mut dampers = DMatrix::zeros(system.c.nrows(), system.c.nrows());
    for i in 0..dampers.nrows() {
        if random.between(0.0, 1.0) < 0.5 {
            dampers[(i, i)] = c * random.between(0.1, 1.0);
        }
    }
    System { c: system.c + dampers, ..system }
}

/// Two or three alike, in other coordinates.
fn repeated(random: &mut Random) -> System {
    let [m, c, k] = [random.integer(1, 4), random.integer(0, 3), random.integer(1, 9)];
    let copies = random.integer(2, 3) as usize;
    let others = random.integer(0, 2) as usize;
    let n = copies + others;
    let diagonal = |random: &mut Random, x: f64| {
        DMatrix::from_diagonal(&DVector::from_fn(n, |i, _| if i < copies { x } else { random.integer(1, 9) }))
    };
    let system = System { m: diagonal(random, m), c: diagonal(random, c), k: diagonal(random, k) };
    system.turned(&random.unimodular(n))
}

/// A critically damped oscillator, or a top at the threshold of sleep, among others.
fn defective(random: &mut Random) -> System {
    let others = random.integer(0, 2) as usize;
    let top = random.between(0.0, 1.0) < 0.5;
    let n = others + if top { 2 } else { 1 };
    let a = random.integer(1, 5);
    let diagonal =
        |random: &mut Random| DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| random.integer(1, 9)));
    let [mut m, mut c, mut k] = [diagonal(random), diagonal(random), diagonal(random)];
    if top {
        // (λ² − a²)² + 4 a² λ² = (λ² + a²)²
        for i in 0..2 {
            (m[(i, i)], c[(i, i)], k[(i, i)]) = (1.0, 0.0, -a * a);
        }
        (c[(0, 1)], c[(1, 0)]) = (2.0 * a, -2.0 * a);
    } else {
        (m[(0, 0)], c[(0, 0)], k[(0, 0)]) = (1.0, 2.0 * a, a * a);
    }
    System { m, c, k }.turned(&random.unimodular(n))
}

/// Coordinates and time in odd units.
fn units(random: &mut Random) -> System {
    let system = damped(random);
    let n = system.m.nrows();
    let t = DMatrix::from_diagonal(&DVector::from_fn(n, |_, _| 10f64.powf(random.between(-30.0, 30.0))));
    let time = 10f64.powf(random.between(-40.0, 40.0));
    let System { m, c, k } = system.turned(&t);
    System { m, c: c * time, k: k * time * time }
}

/// Matrices of small integers: roots are integers too, `P(λ)` has rows and columns of zeros, and null vectors on the
/// left and on the right are at right angles.
fn integers(random: &mut Random) -> System {
    let n = random.integer(2, 3) as usize;
    let mut m = DMatrix::zeros(n, n);
    let [mut c, mut k] = [m.clone(), m.clone()];
    let [coupled, damped] = [0, 1].map(|_| random.between(0.0, 1.0) < 0.3);
    for i in 0..n {
        (m[(i, i)], k[(i, i)]) = (random.integer(1, 4), random.integer(-10, 10));
        c[(i, i)] = if damped { random.integer(0, 3) } else { 0.0 };
        for j in 0..i {
            c[(i, j)] = random.integer(-2, 2);
            c[(j, i)] = -c[(i, j)];
            k[(i, j)] = if coupled { random.integer(-2, 2) } else { 0.0 };
            k[(j, i)] = k[(i, j)];
        }
    }
    System { m, c, k }
}
