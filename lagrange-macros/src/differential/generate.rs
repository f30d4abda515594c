//! Random systems as a user would write them.

use std::fmt;

/// Reproducible random numbers: SplitMix64 (Steele, Lea and Flood 2014).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d))
    }

    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// True once in `n` times.
    fn once_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }
}

/// An expression of the language.
#[derive(Clone)]
pub enum Expr {
    /// In eighths, so that its digits are its value.
    Constant(i32),
    Parameter(usize),
    /// A free coordinate, or after those a prescribed one.
    Position(usize),
    Time,
    Binding(usize),
    Sum(Box<Expr>, Box<Expr>),
    Difference(Box<Expr>, Box<Expr>),
    Product(Box<Expr>, Box<Expr>),
    Quotient(Box<Expr>, Box<Expr>),
    Power(Box<Expr>, i32),
    Call(Call, Box<Expr>),
    Rate(Box<Expr>),
}

#[derive(Clone, Copy)]
pub enum Call {
    Sin,
    Cos,
    Tan,
    Exp,
    Ln,
    Sqrt,
    Tanh,
    Atan,
    Asinh,
}

impl Call {
    fn name(self) -> &'static str {
        match self {
            Call::Sin => "sin",
            Call::Cos => "cos",
            Call::Tan => "tan",
            Call::Exp => "exp",
            Call::Ln => "ln",
            Call::Sqrt => "sqrt",
            Call::Tanh => "tanh",
            Call::Atan => "atan",
            Call::Asinh => "asinh",
        }
    }
}

impl Expr {
    fn rate(self) -> Expr {
        Expr::Rate(Box::new(self))
    }

    fn power(self, n: i32) -> Expr {
        Expr::Power(Box::new(self), n)
    }

    fn call(self, f: Call) -> Expr {
        Expr::Call(f, Box::new(self))
    }

    fn over(self, other: Expr) -> Expr {
        Expr::Quotient(Box::new(self), Box::new(other))
    }

    /// 1 + x², whatever x.
    fn positive(self) -> Expr {
        Expr::Constant(8) + self.power(2)
    }
}

impl std::ops::Add for Expr {
    type Output = Expr;
    fn add(self, other: Expr) -> Expr {
        Expr::Sum(Box::new(self), Box::new(other))
    }
}

impl std::ops::Sub for Expr {
    type Output = Expr;
    fn sub(self, other: Expr) -> Expr {
        Expr::Difference(Box::new(self), Box::new(other))
    }
}

impl std::ops::Mul for Expr {
    type Output = Expr;
    fn mul(self, other: Expr) -> Expr {
        Expr::Product(Box::new(self), Box::new(other))
    }
}

/// A constraint: the difference of its sides vanishes.
pub struct Constraint {
    pub left: Expr,
    pub right: Expr,
    pub on_velocities: bool,
}

/// A system; its potential and kinetic energies are written as one Lagrangian if `whole`.
pub struct System {
    pub coordinates: usize,
    pub parameters: usize,
    /// Motions of the prescribed coordinates, in terms of time and parameters.
    pub prescribed: Vec<Expr>,
    pub bindings: Vec<Expr>,
    pub kinetic: Expr,
    pub potential: Expr,
    pub whole: bool,
    pub dissipation: Option<Expr>,
    /// Q of some coordinates.
    pub applied: Vec<(usize, Expr)>,
    /// Forces and where they act.
    pub forces: Vec<(Expr, Expr)>,
    pub constraints: Vec<Constraint>,
    /// The last coordinate appears nowhere but in rates, and a reduced system is asked for.
    pub ignorable: bool,
}

/// What an expression may name.
struct Scope<'r> {
    random: &'r mut Random,
    parameters: usize,
    positions: Vec<usize>,
    bindings: usize,
}

impl Scope<'_> {
    fn position(&mut self) -> Expr {
        Expr::Position(self.positions[self.random.below(self.positions.len())])
    }

    fn leaf(&mut self) -> Expr {
        match self.random.below(10) {
            0 => Expr::Constant(self.random.below(33) as i32 - 16),
            1 => Expr::Parameter(self.random.below(self.parameters)),
            2 => Expr::Time,
            3 | 4 if self.bindings > 0 => Expr::Binding(self.random.below(self.bindings)),
            _ if self.positions.is_empty() => Expr::Time,
            _ => self.position(),
        }
    }

    /// A function of positions and time.
    fn place(&mut self, depth: usize) -> Expr {
        if depth == 0 || self.random.once_in(8) {
            return self.leaf();
        }
        let one = self.place(depth - 1);
        match self.random.below(16) {
            0 | 1 => one + self.place(depth - 1),
            2 => one - self.place(depth - 1),
            3..=5 => one * self.place(depth - 1),
            6 => one.over(self.place(depth - 1).positive()),
            7 | 8 => one.call(Call::Sin),
            9 => one.call(Call::Cos),
            10 => one.power(2 + self.random.below(2) as i32),
            11 => (Expr::Constant(-8) * one.power(2)).call(Call::Exp),
            12 => one.call(Call::Sin).call(Call::Exp),
            13 => one.positive().call([Call::Ln, Call::Sqrt][self.random.below(2)]),
            // Far from the poles of the tangent.
            14 => one.call(Call::Sin).call(Call::Tan),
            _ => one.call([Call::Tanh, Call::Atan, Call::Asinh][self.random.below(3)]),
        }
    }

    /// A positive coefficient.
    fn mass(&mut self) -> Expr {
        match self.random.below(4) {
            0 => Expr::Constant(1 + self.random.below(16) as i32),
            1 => self.place(1).positive(),
            _ => Expr::Parameter(self.random.below(self.parameters)),
        }
    }
}

/// The n-th random system.
pub fn system(random: &mut Random) -> System {
    let n = 1 + random.below(6);
    let parameters = 1 + random.below(4);
    let ignorable = n > 1 && random.once_in(5);
    let prescribed = if random.once_in(3) { 1 + random.below(2) } else { 0 };
    let mut scope = Scope { random, parameters, positions: Vec::new(), bindings: 0 };
    let prescribed: Vec<Expr> = (0..prescribed)
        .map(|_| {
            (Expr::Parameter(scope.random.below(parameters)) * Expr::Time).call(Call::Sin) + scope.place(1)
        })
        .collect();
    let seen = if ignorable { n - 1 } else { n };
    scope.positions = (0..seen).chain(n..n + prescribed.len()).collect();
    let mut bindings = Vec::new();
    for _ in 0..scope.random.below(4) {
        bindings.push(scope.place(2));
        scope.bindings += 1;
    }
    let half = || Expr::Constant(4);
    let velocity = |i: usize| Expr::Position(i).rate();

    // Every coordinate has inertia of its own; what is added to it is a square.
    let mut kinetic = half() * scope.mass() * velocity(0).power(2);
    for i in 1..n {
        kinetic = kinetic + half() * scope.mass() * velocity(i).power(2);
    }
    for _ in 0..scope.random.below(4) {
        let moving = match scope.random.below(3) {
            0 => scope.place(1) * velocity(scope.random.below(n)) + velocity(scope.random.below(n)),
            // The rate of a constant would be refused.
            _ => (scope.position() + scope.place(2)).rate(),
        };
        kinetic = kinetic + half() * scope.mass() * moving.power(2);
    }
    let whole = scope.random.once_in(4);
    if whole {
        kinetic = kinetic + scope.place(2) * velocity(scope.random.below(n));
    }
    if !ignorable && scope.random.once_in(10) {
        kinetic = kinetic + scope.mass() * velocity(scope.random.below(n)).power(4);
    }
    // Every parameter is used.
    let mut potential = scope.place(3);
    for i in 0..parameters {
        potential = potential + Expr::Parameter(i) * scope.place(1);
    }
    let dissipation = scope.random.once_in(3).then(|| {
        let (i, j) = (scope.random.below(seen), scope.random.below(seen));
        let slip = scope.place(1) * velocity(i) - velocity(j);
        half() * scope.mass() * slip.power(2) + half() * scope.mass() * velocity(i).power(2)
    });
    let mut applied = Vec::new();
    for i in 0..seen {
        if scope.random.once_in(4) {
            applied.push((i, scope.place(2) - scope.place(1) * velocity(scope.random.below(n))));
        }
    }
    let mut forces = Vec::new();
    if scope.random.once_in(4) {
        let at = Expr::Position(scope.random.below(seen)) + scope.place(2);
        forces.push((scope.place(2) * velocity(scope.random.below(n)) + scope.place(1), at));
    }
    let mut constraints = Vec::new();
    let most = if n > 1 && !ignorable && scope.random.once_in(3) { 1 + scope.random.below(n - 1) } else { 0 };
    for j in 0..most {
        // The j-th coordinate leads the j-th constraint, so that none follows from the others.
        let on_velocities = scope.random.once_in(2);
        let (lead, other) = (Expr::Position(j), scope.random.below(n));
        let (lead, rest) = match on_velocities {
            false => (lead, scope.place(2)),
            true => (lead.rate(), scope.place(1) * velocity(other) + scope.place(1)),
        };
        let factor = Expr::Constant(16 + scope.random.below(16) as i32);
        constraints.push(Constraint { left: factor * lead, right: rest, on_velocities });
    }
    System {
        coordinates: n,
        parameters,
        prescribed,
        bindings,
        kinetic,
        potential,
        whole,
        dissipation,
        applied,
        forces,
        constraints,
        ignorable,
    }
}

/// An expression as it is written in a system of `n` coordinates.
struct Written<'e>(&'e Expr, usize);

impl fmt::Display for Written<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Written(e, n) = *self;
        let w = |e| Written(e, n);
        match e {
            Expr::Constant(k) => write!(f, "({:?})", f64::from(*k) / 8.0),
            Expr::Parameter(i) => write!(f, "p{i}"),
            Expr::Position(i) if *i < n => write!(f, "q{i}"),
            Expr::Position(i) => write!(f, "s{}", i - n),
            Expr::Time => write!(f, "t"),
            Expr::Binding(k) => write!(f, "u{k}"),
            Expr::Sum(a, b) => write!(f, "({} + {})", w(a), w(b)),
            Expr::Difference(a, b) => write!(f, "({} - {})", w(a), w(b)),
            Expr::Product(a, b) => write!(f, "{} * {}", w(a), w(b)),
            Expr::Quotient(a, b) => write!(f, "({} / ({}))", w(a), w(b)),
            Expr::Power(a, k) => write!(f, "({}).powi({k})", w(a)),
            Expr::Call(c, a) => write!(f, "{}({})", c.name(), w(a)),
            Expr::Rate(a) => write!(f, "dot({})", w(a)),
        }
    }
}

impl System {
    /// Its statements, called `name`.
    pub fn written(&self, name: &str) -> String {
        let w = |e| Written(e, self.coordinates);
        let mut lines = vec![
            format!(
                "param {};",
                (0..self.parameters).map(|i| format!("p{i}")).collect::<Vec<_>>().join(", ")
            ),
            format!(
                "coord {};",
                (0..self.coordinates).map(|i| format!("q{i}")).collect::<Vec<_>>().join(", ")
            ),
        ];
        let mut line = |text: String| lines.push(text);
        for (k, motion) in self.prescribed.iter().enumerate() {
            line(format!("coord s{k} = {};", w(motion)));
        }
        for (k, value) in self.bindings.iter().enumerate() {
            line(format!("let u{k} = {};", w(value)));
        }
        match self.whole {
            true => line(format!("L = {} - ({});", w(&self.kinetic), w(&self.potential))),
            false => line(format!("T = {}; V = {};", w(&self.kinetic), w(&self.potential))),
        }
        if let Some(d) = &self.dissipation {
            line(format!("D = {};", w(d)));
        }
        for (i, q) in &self.applied {
            line(format!("Q[q{i}] = {};", w(q)));
        }
        for (force, at) in &self.forces {
            line(format!("force {} at {};", w(force), w(at)));
        }
        for (j, c) in self.constraints.iter().enumerate() {
            line(format!("constraint c{j}: {} == {};", w(&c.left), w(&c.right)));
        }
        if self.ignorable {
            line("routhian Reduced;".into());
        }
        format!("pub system {name} {{\n    {}\n}}", lines.join("\n    "))
    }
}
