//! Compiled systems against Lagrange's equations by automatic differentiation: L, D and Q are written a second time in
//! plain Rust, differentiated by nested dual numbers, and compared with what `lagrangian!` emitted, at random states.
//!
//! Tolerances are computed: every number carries a bound of its own rounding error ([`Bounded`]), on both sides.

// Potentials of these systems jump, which makes no difference at a state.
#![allow(deprecated)]

mod bounded;
mod check;

use check::{Written, check, check_velocities};
use lagrange_runtime::prelude::*;
use lagrange_runtime::scalar::Comparison;
use std::ops::Range;

fn k<S: Scalar>(x: f64) -> S {
    S::from_f64(x)
}

fn half<S: Scalar>(x: S) -> S {
    k::<S>(0.5) * x
}

lagrangian! {
    /// Every elementary function of one argument, in a potential.
    pub system Potentials {
        param m = 1.3, a = 0.7;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = x.sin() + 2 * y.cos() + 0.3 * tan(a * x) + asin(x * y) - 0.4 * acos(y) + atan(3 * x)
            + sinh(x - y) + 0.2 * y.cosh() + tanh(x / a) + 0.6 * asinh(2 * y) + acosh(1.5 + x) + atanh(x * y)
            + a * (-x * x).exp() + exp_m1(y) + 0.1 * exp2(x + y) + x * y.ln() + ln_1p(x) + log2(y) + log10(x)
            + (x + y).sqrt() + cbrt(y) * x + abs(x - 0.5) + signum(y - 0.4) * x;
    }
}

impl Written<2> for Potentials {
    type Over<S: Scalar> = Potentials<S>;
    fn system() -> Self {
        Potentials::new()
    }
    fn over<S: Scalar>(self) -> Potentials<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, [x, y]: [S; 2], [xd, yd]: [S; 2], _: S) -> S {
        let (m, a) = (k::<S>(self.m), k::<S>(self.a));
        let mut v = x.sin() + k::<S>(2.0) * y.cos() + k::<S>(0.3) * (a * x).tan() + (x * y).asin();
        v += -k::<S>(0.4) * y.acos() + (k::<S>(3.0) * x).atan() + (x - y).sinh() + k::<S>(0.2) * y.cosh();
        v += (x / a).tanh()
            + k::<S>(0.6) * (k::<S>(2.0) * y).asinh()
            + (k::<S>(1.5) + x).acosh()
            + (x * y).atanh();
        v += a * (-x * x).exp()
            + y.exp_m1()
            + k::<S>(0.1) * (x + y).exp2()
            + x * y.ln()
            + x.ln_1p()
            + y.log2();
        v += x.log10() + (x + y).sqrt() + y.cbrt() * x + (x - k(0.5)).abs() + (y - k(0.4)).signum() * x;
        half(m * (xd * xd + yd * yd)) - v
    }
    fn ranges() -> [Range<f64>; 2] {
        [0.1..0.9, 0.1..0.9]
    }
}

lagrangian! {
    /// Powers and functions of two arguments.
    pub system Powers {
        param m = 0.8, n = 2.3;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * x.powi(-2) * dot(x).powi(2);
        V = x.powf(n) + x.powf(y) + y.powf(-1.5) + powf(y, 2.5) + x.powi(-3) + hypot(x, y) + atan2(y, x)
            + 1 / (x * y) + (2 * y).recip() + x.powi(7) / y.powi(5) + (x * y).powf(0.25) + x.mul_add(y, n);
    }
}

impl Written<2> for Powers {
    type Over<S: Scalar> = Powers<S>;
    fn system() -> Self {
        Powers::new()
    }
    fn over<S: Scalar>(self) -> Powers<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, [x, y]: [S; 2], [xd, yd]: [S; 2], _: S) -> S {
        let (m, n, one) = (k::<S>(self.m), k::<S>(self.n), S::one());
        let x3 = x * x * x;
        let v = x.powf(n)
            + x.powf(y)
            + y.powf(k(-1.5))
            + y.powf(k(2.5))
            + one / x3
            + x.hypot(y)
            + y.atan2(x)
            + one / (x * y)
            + one / (y + y)
            + x3 * x3 * x / (y * y * y * y * y)
            + (x * y).powf(k(0.25))
            + x * y
            + n;
        half(m * (xd * xd + yd * yd)) + half(xd * xd / (x * x)) - v
    }
    fn ranges() -> [Range<f64>; 2] {
        [0.4..1.6, 0.4..1.6]
    }
}

lagrangian! {
    /// Choices: a contact, a limited spring, dry and viscous friction.
    pub system Choices {
        param m = 0.9, c = 0.4, stiff = 30.0;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.1 * dot(x) * dot(y);
        V = 0.4 * stiff * max(-y, 0.0).powf(2.5)
            + if x > 0.5 { (x - 0.5).powf(1.5) } else if x < -0.5 && y < 1.0 { 2 * x * x } else { x }
            + y * x.clamp(-1, 1) + min(x, y).powi(2);
        D = 0.5 * c * (if y < 0.0 { 3 } else { 1 }) * (dot(x) - dot(y)).powi(2);
        Q[x] = if dot(x).abs() <= 0.3 { -dot(x) } else { -0.3 * dot(x).signum() };
        Q[y] = -c * dot(y) * dot(y).abs();
    }
}

fn max<S: Scalar>(a: S, b: S) -> S {
    S::select(Comparison::Less, a, b, b, a)
}

fn min<S: Scalar>(a: S, b: S) -> S {
    S::select(Comparison::Less, a, b, a, b)
}

fn less<S: Scalar>(a: S, b: f64, yes: S, no: S) -> S {
    S::select(Comparison::Less, a, k(b), yes, no)
}

impl Written<2> for Choices {
    type Over<S: Scalar> = Choices<S>;
    fn system() -> Self {
        Choices::new()
    }
    fn over<S: Scalar>(self) -> Choices<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, [x, y]: [S; 2], [xd, yd]: [S; 2], _: S) -> S {
        let (m, stiff) = (k::<S>(self.m), k::<S>(self.stiff));
        let contact = max(-y, S::zero()).powf(k(2.5));
        let (steep, left) = ((max(x, k(0.5)) - k(0.5)).powf(k(1.5)), less(y, 1.0, (x + x) * x, x));
        let spring = less(-x, -0.5, steep, less(x, -0.5, left, x));
        let v =
            k::<S>(0.4) * stiff * contact + spring + y * min(max(x, k(-1.0)), k(1.0)) + min(x, y) * min(x, y);
        half(m * (xd * xd + yd * yd)) + k::<S>(0.1) * xd * yd - v
    }
    fn dissipation<S: Scalar>(&self, [_, y]: [S; 2], [xd, yd]: [S; 2], _: S) -> S {
        half(k::<S>(self.c) * less(y, 0.0, k(3.0), S::one()) * (xd - yd) * (xd - yd))
    }
    fn applied<S: Scalar>(&self, _: [S; 2], [xd, yd]: [S; 2], _: S) -> [S; 2] {
        let dry = less(xd.abs(), 0.3, -xd, -k::<S>(0.3) * xd.signum());
        [dry, -k::<S>(self.c) * yd * yd.abs()]
    }
    fn ranges() -> [Range<f64>; 2] {
        [-1.5..1.5, -1.5..1.5]
    }
}

lagrangian! {
    /// Curved kinematics with named functions, forces at points, outputs.
    pub system Kinematics {
        param m = 0.7, a = 1.2, w = 0.9;
        coord u, v;
        fn bump(s) = a * (-s * s).exp();
        fn twist(r, s) = r * cos(s) + bump(r - s);
        let px = twist(u, v) + u;
        let py = ln(2 + u * u) * cosh(v / 2) + v;
        let pz = sqrt(1 + px * px) + 0.3 * t * sin(w * t);
        T = 0.5 * m * (dot(px).powi(2) + dot(py).powi(2) + dot(pz).powi(2)) + 0.5 * dot(u).powi(2);
        V = m * 9.81 * pz + bump(py);
        D = 0.1 * (dot(px) - dot(py)).powi(2);
        force [sin(w * t) - 0.2 * dot(px), -0.1 * py] at [px, py];
        force 2 * u at pz;
        Q[v] = -0.05 * dot(v).powi(3);
        observe place = [px, py, pz];
        observe speeds = [dot(px), dot(py), dot(pz)];
    }
}

impl Kinematics {
    fn point<S: Scalar>(&self, u: S, v: S, t: S) -> [S; 3] {
        let bump = |s: S| k::<S>(self.a) * (-s * s).exp();
        let px = u * v.cos() + bump(u - v) + u;
        let py = (k::<S>(2.0) + u * u).ln() * half(v).cosh() + v;
        let pz = (S::one() + px * px).sqrt() + k::<S>(0.3) * t * (k::<S>(self.w) * t).sin();
        [px, py, pz]
    }

    /// The place and its rate.
    fn moving<S: Scalar>(&self, [u, v]: [S; 2], [ud, vd]: [S; 2], t: S) -> [Dual<S>; 3] {
        let dual = |value, slope| Dual { value, slope };
        Kinematics::point(self, dual(u, ud), dual(v, vd), Dual::variable(t))
    }
}

impl Written<2> for Kinematics {
    type Over<S: Scalar> = Kinematics<S>;
    fn system() -> Self {
        Kinematics::new()
    }
    fn over<S: Scalar>(self) -> Kinematics<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, q: [S; 2], qd: [S; 2], t: S) -> S {
        let place = self.moving(q, qd, t);
        let square = place.iter().fold(S::zero(), |sum, p| sum + p.slope * p.slope);
        let [_, py, pz] = place.map(|p| p.value);
        let v = k::<S>(self.m * 9.81) * pz + k::<S>(self.a) * (-py * py).exp();
        half(k::<S>(self.m) * square) + half(qd[0] * qd[0]) - v
    }
    fn dissipation<S: Scalar>(&self, q: [S; 2], qd: [S; 2], t: S) -> S {
        let [px, py, _] = self.moving(q, qd, t);
        k::<S>(0.1) * (px.slope - py.slope) * (px.slope - py.slope)
    }
    fn applied<S: Scalar>(&self, [u, v]: [S; 2], qd: [S; 2], t: S) -> [S; 2] {
        let [px, py, _] = self.moving([u, v], qd, t);
        let force = [(k::<S>(self.w) * t).sin() - k::<S>(0.2) * px.slope, -k::<S>(0.1) * py.value, u + u];
        let along = |ud, vd| {
            let dual = |value, slope| Dual { value, slope };
            let moved = Kinematics::point(self, dual(u, ud), dual(v, vd), Dual::constant(t));
            moved.iter().zip(force).fold(S::zero(), |sum, (p, f)| sum + p.slope * f)
        };
        let (one, zero) = (S::one(), S::zero());
        [along(one, zero), along(zero, one) - k::<S>(0.05) * qd[1] * qd[1] * qd[1]]
    }
    fn ranges() -> [Range<f64>; 2] {
        [-1.2..1.2, -1.2..1.2]
    }
}

fn drive<S: Scalar>(t: S) -> S {
    t.sin() + S::from_f64(0.25) * t * t
}

fn field<S: Scalar>(x: S, y: S) -> S {
    (x * y).sin() * x + (S::one() + y * y).ln()
}

lagrangian! {
    /// The support moves as the user's function says, in a field that the user computes.
    pub system Prescribed {
        param m = 1.1, l = 0.6, c = 0.2;
        coord theta;
        coord s = drive(t), lift = 0.2 * cos(3 * t);
        extern fn drive(t);
        extern fn field(x, y);
        let x = s + l * theta.sin();
        let y = lift - l * theta.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * 9.81 * y + field(x, y);
        D = 0.5 * c * dot(theta).powi(2);
        Q[theta] = -0.1 * drive(t) * dot(x) + field(theta, dot(theta));
        observe bob = [x, y];
        observe speed = [dot(x), dot(y)];
    }
}

impl Prescribed {
    fn point<S: Scalar>(&self, theta: S, t: S) -> [S; 2] {
        let l = k::<S>(self.l);
        [drive(t) + l * theta.sin(), k::<S>(0.2) * (k::<S>(3.0) * t).cos() - l * theta.cos()]
    }

    fn moving<S: Scalar>(&self, theta: S, slope: S, t: S) -> [Dual<S>; 2] {
        Prescribed::point(self, Dual { value: theta, slope }, Dual::variable(t))
    }
}

impl Written<1> for Prescribed {
    type Over<S: Scalar> = Prescribed<S>;
    fn system() -> Self {
        Prescribed::new()
    }
    fn over<S: Scalar>(self) -> Prescribed<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, [q]: [S; 1], [qd]: [S; 1], t: S) -> S {
        let [x, y] = self.moving(q, qd, t);
        let v = k::<S>(self.m * 9.81) * y.value + field(x.value, y.value);
        half(k::<S>(self.m) * (x.slope * x.slope + y.slope * y.slope)) - v
    }
    fn dissipation<S: Scalar>(&self, _: [S; 1], [qd]: [S; 1], _: S) -> S {
        half(k::<S>(self.c) * qd * qd)
    }
    fn applied<S: Scalar>(&self, [q]: [S; 1], [qd]: [S; 1], t: S) -> [S; 1] {
        let [x, _] = self.moving(q, qd, t);
        [-k::<S>(0.1) * drive(t) * x.slope + field(q, qd)]
    }
    fn ranges() -> [Range<f64>; 1] {
        [-3.0..3.0]
    }
}

lagrangian! {
    /// Families: bobs on a chain, tied to each other by springs.
    pub system Chain {
        const N = 3;
        param m: [N] = [0.5, 0.8, 0.3], l: [N] = [1.0, 0.6, 0.9], stiff: [N - 1] = [2.0, 3.0], g = 9.81;
        coord th: [N];
        let x: [N] = |i| (0..i + 1).map(|j| l[j] * th[j].sin()).sum();
        let y: [N] = |i| -(0..=i).map(|j| l[j] * th[j].cos()).sum();
        T = (0..N).map(|i| 0.5 * m[i] * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| m[i] * g * y[i]).sum()
            + (1..N).map(|i| 0.5 * stiff[i - 1] * (th[i] - th[i - 1]).powi(2)).sum();
        D = (0..N).map(|i| 0.05 * (i + 1) * dot(th[i]).powi(2)).sum();
        Q[th] = (0..N).map(|i| 0.1 * i * cos(th[i])).collect();
        observe tip = [x[N - 1], y[N - 1]];
        observe speed = [dot(x[N - 1]), dot(y[N - 1])];
    }
}

impl Written<3> for Chain {
    type Over<S: Scalar> = Chain<S>;
    fn system() -> Self {
        Chain::new()
    }
    fn over<S: Scalar>(self) -> Chain<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, th: [S; 3], thd: [S; 3], _: S) -> S {
        let (mut place, mut speed) = ([S::zero(); 2], [S::zero(); 2]);
        let mut total = S::zero();
        for i in 0..3 {
            let l = k::<S>(self.l[i]);
            let (s, c) = th[i].sin_cos();
            place = [place[0] + l * s, place[1] - l * c];
            speed = [speed[0] + l * thd[i] * c, speed[1] + l * thd[i] * s];
            let square = speed[0] * speed[0] + speed[1] * speed[1];
            total += k::<S>(self.m[i]) * (half(square) - k::<S>(self.g) * place[1]);
        }
        for i in 0..2 {
            let angle = th[i + 1] - th[i];
            total += -half(k::<S>(self.stiff[i]) * angle * angle);
        }
        total
    }
    fn dissipation<S: Scalar>(&self, _: [S; 3], qd: [S; 3], _: S) -> S {
        (0..3).fold(S::zero(), |sum, i| sum + k::<S>(0.05 * (i + 1) as f64) * qd[i] * qd[i])
    }
    fn applied<S: Scalar>(&self, q: [S; 3], _: [S; 3], _: S) -> [S; 3] {
        std::array::from_fn(|i| k::<S>(0.1 * i as f64) * q[i].cos())
    }
    fn ranges() -> [Range<f64>; 3] {
        [-3.0..3.0, -3.0..3.0, -3.0..3.0]
    }
}

lagrangian! {
    /// L given, with the potential of a magnetic field.
    pub system Charged {
        param m = 0.6, e = 1.4, B = 2.0;
        coord x, y, z;
        L = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2))
            + 0.5 * e * B * (1 + 0.2 * z * z) * (x * dot(y) - y * dot(x)) + e * sin(t) * dot(z) - e * x * z;
        D = 0.02 * (dot(x).powi(2) + dot(z).powi(2));
    }
}

impl Written<3> for Charged {
    type Over<S: Scalar> = Charged<S>;
    fn system() -> Self {
        Charged::new()
    }
    fn over<S: Scalar>(self) -> Charged<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, [x, y, z]: [S; 3], [xd, yd, zd]: [S; 3], t: S) -> S {
        let (m, e, eb) = (k::<S>(self.m), k::<S>(self.e), k::<S>(self.e * self.B));
        half(m * (xd * xd + yd * yd + zd * zd))
            + half(eb * (S::one() + k::<S>(0.2) * z * z) * (x * yd - y * xd))
            + e * t.sin() * zd
            - e * x * z
    }
    fn dissipation<S: Scalar>(&self, _: [S; 3], [xd, _, zd]: [S; 3], _: S) -> S {
        k::<S>(0.02) * (xd * xd + zd * zd)
    }
    fn ranges() -> [Range<f64>; 3] {
        [-2.0..2.0, -2.0..2.0, -2.0..2.0]
    }
}

lagrangian! {
    /// L given and not quadratic: the relativistic oscillator.
    pub system Relativistic {
        param m = 1.2, c = 4.0, stiff = 3.0;
        coord x, y;
        L = -m * c.powi(2) * (1 - (dot(x).powi(2) + dot(y).powi(2)) / c.powi(2)).sqrt()
            - 0.5 * stiff * (x * x + 2 * y * y);
    }
}

impl Written<2> for Relativistic {
    type Over<S: Scalar> = Relativistic<S>;
    fn system() -> Self {
        Relativistic::new()
    }
    fn over<S: Scalar>(self) -> Relativistic<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, [x, y]: [S; 2], [xd, yd]: [S; 2], _: S) -> S {
        let (m, cc) = (k::<S>(self.m), k::<S>(self.c * self.c));
        let root = (S::one() - (xd * xd + yd * yd) / cc).sqrt();
        -m * cc * root - half(k::<S>(self.stiff) * (x * x + (y + y) * y))
    }
    fn ranges() -> [Range<f64>; 2] {
        [-2.0..2.0, -2.0..2.0]
    }
}

lagrangian! {
    /// Rotating and rolling: spherical pendulum on an arm that turns, in a let of lets.
    pub system Arm {
        param m = 0.8, M = 1.5, r = 0.7, l = 0.5, om = 1.7;
        coord al, th, ph;
        let turn = al + om * t;
        let elbow = [r * cos(turn), r * sin(turn)];
        let rod = [l * sin(th) * cos(ph), l * sin(th) * sin(ph), -l * cos(th)];
        let bob = [elbow[0] + rod[0], elbow[1] + rod[1], rod[2]];
        T = 0.5 * M * dot(elbow).norm_squared() + 0.5 * m * dot(bob).norm_squared() + 0.1 * dot(al).powi(2);
        V = m * 9.81 * bob[2] + 0.3 * bob.norm();
        force dot(bob) * (-0.4) at bob;
        observe bob;
        observe speed = dot(bob);
    }
}

impl Arm {
    fn point<S: Scalar>(&self, [al, th, ph]: [S; 3], t: S) -> [S; 5] {
        let (r, l, turn) = (k::<S>(self.r), k::<S>(self.l), al + k::<S>(self.om) * t);
        let elbow = [r * turn.cos(), r * turn.sin()];
        let [x, y, z] = [l * th.sin() * ph.cos(), l * th.sin() * ph.sin(), -l * th.cos()];
        [elbow[0], elbow[1], elbow[0] + x, elbow[1] + y, z]
    }

    fn moving<S: Scalar>(&self, q: [S; 3], qd: [S; 3], t: Dual<S>) -> [Dual<S>; 5] {
        Arm::point(self, std::array::from_fn(|i| Dual { value: q[i], slope: qd[i] }), t)
    }
}

impl Written<3> for Arm {
    type Over<S: Scalar> = Arm<S>;
    fn system() -> Self {
        Arm::new()
    }
    fn over<S: Scalar>(self) -> Arm<S> {
        self.map(S::from_f64)
    }
    fn lagrangian<S: Scalar>(&self, q: [S; 3], qd: [S; 3], t: S) -> S {
        let p = self.moving(q, qd, Dual::variable(t));
        let speed = |p: &[Dual<S>]| p.iter().fold(S::zero(), |sum, p| sum + p.slope * p.slope);
        let far = p[2..].iter().fold(S::zero(), |sum, p| sum + p.value * p.value).sqrt();
        half(k::<S>(self.M) * speed(&p[..2]))
            + half(k::<S>(self.m) * speed(&p[2..]))
            + k::<S>(0.1) * qd[0] * qd[0]
            - k::<S>(self.m * 9.81) * p[4].value
            - k::<S>(0.3) * far
    }
    fn applied<S: Scalar>(&self, q: [S; 3], qd: [S; 3], t: S) -> [S; 3] {
        let speed = self.moving(q, qd, Dual::variable(t)).map(|p| p.slope);
        std::array::from_fn(|i| {
            let along = std::array::from_fn(|j| if i == j { S::one() } else { S::zero() });
            let moved = self.moving(q, along, Dual::constant(t)).map(|p| p.slope);
            (2..5).fold(S::zero(), |sum, j| sum - k::<S>(0.4) * speed[j] * moved[j])
        })
    }
    fn ranges() -> [Range<f64>; 3] {
        [-3.0..3.0, 0.4..2.7, -3.0..3.0]
    }
}

/// One test for each system; where a place and its velocity are observed, these too.
macro_rules! systems {
    ($($name:ident: $system:ident $(, $place:ident -> $speed:ident)?;)*) => {$(
        #[test]
        fn $name() {
            check::<$system, _>();
            $(check_velocities::<$system, _, _>(
                |system, q, qd, t| system.$place(q, qd, t),
                |system, q, qd, t| system.$speed(q, qd, t),
            );)?
        }
    )*};
}

systems! {
    elementary_functions_of_one_argument: Potentials;
    powers_and_functions_of_two_arguments: Powers;
    choices: Choices;
    curved_kinematics: Kinematics, place -> speeds;
    prescribed_motion_and_functions_of_the_user: Prescribed, bob -> speed;
    families: Chain, tip -> speed;
    a_magnetic_field: Charged;
    a_lagrangian_that_is_not_quadratic: Relativistic;
    arrays_of_bindings: Arm, bob -> speed;
}
