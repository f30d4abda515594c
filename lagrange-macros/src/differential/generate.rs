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

    pub fn below(&mut self, n: usize) -> usize {
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
    /// With an exponent in eighths.
    Root(Box<Expr>, i32),
    Call(Call, Box<Expr>),
    Atan2(Box<Expr>, Box<Expr>),
    Hypot(Box<Expr>, Box<Expr>),
    /// `if a < b { c } else { d }`
    Choice(Box<[Expr; 4]>),
    Rate(Box<Expr>),
}

#[derive(Clone, Copy)]
pub enum Call {
    Abs,
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
            Call::Abs => "abs",
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
    /// Places at which impulses may act.
    pub struck: Vec<Vec<Expr>>,
    pub observed: Vec<Expr>,
    /// A coordinate appears nowhere but in rates, and a reduced system is asked for.
    pub ignorable: bool,
}

/// What an expression may name.
struct Scope<'r> {
    random: &'r mut Random,
    parameters: usize,
    positions: Vec<usize>,
    bindings: usize,
    /// Is there anything without a Taylor series?
    choices: bool,
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
        match self.random.below(19) {
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
            15 => Expr::Root(Box::new(one.positive()), self.random.below(33) as i32 - 16),
            16 => {
                let other = Box::new(self.place(depth - 1).positive());
                match self.random.below(2) {
                    0 => Expr::Atan2(Box::new(one), other),
                    _ => Expr::Hypot(Box::new(one), other),
                }
            }
            17 if self.choices && self.random.once_in(2) => one.call(Call::Abs),
            17 if self.choices => {
                let leaf = self.leaf();
                Expr::Choice(Box::new([one, leaf, self.place(depth - 1), self.place(depth - 1)]))
            }
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

/// A random system: terms of any kind, or links that hang together.
pub fn system(random: &mut Random) -> System {
    match random.below(3) {
        0 => linkage(random),
        _ => terms(random),
    }
}

/// Sums, products and functions of anything.
fn terms(random: &mut Random) -> System {
    let n = 1 + random.below(6);
    let parameters = 1 + random.below(4);
    let ignorable = n > 1 && random.once_in(5);
    let prescribed = if random.once_in(3) { 1 + random.below(2) } else { 0 };
    let choices = random.once_in(3);
    let mut scope = Scope { random, parameters, positions: Vec::new(), bindings: 0, choices };
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
    let mut struck = Vec::new();
    for _ in 0..scope.random.below(3) {
        let moving = |scope: &mut Scope| Expr::Position(scope.random.below(seen)) + scope.place(1);
        struck.push((0..1 + scope.random.below(3)).map(|_| moving(&mut scope)).collect());
    }
    let observed = (0..scope.random.below(3))
        .map(|_| scope.place(2) * (scope.position() + scope.place(1)).rate() + scope.place(1))
        .collect();
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
        struck,
        observed,
        ignorable,
    }
}

/// Where the ends of links are, in terms of earlier bindings.
struct Links<'r> {
    random: &'r mut Random,
    parameters: usize,
    bindings: Vec<Expr>,
    /// Binding of the angle of each link, and of the coordinates of its end.
    angles: Vec<Expr>,
    ends: Vec<Vec<Expr>>,
    /// The one before, nearer to the base.
    parents: Vec<Option<usize>>,
}

impl Links<'_> {
    fn bind(&mut self, value: Expr) -> Expr {
        self.bindings.push(value);
        Expr::Binding(self.bindings.len() - 1)
    }

    /// A length, mass or moment of inertia: a number or a parameter.
    fn size(&mut self) -> Expr {
        match self.random.once_in(2) {
            true => Expr::Constant(2 + self.random.below(15) as i32),
            false => Expr::Parameter(self.random.below(self.parameters)),
        }
    }

    /// The way from the base to a link.
    fn depth(&self, k: usize) -> usize {
        1 + self.parents[k].map_or(0, |parent| self.depth(parent))
    }
}

/// Links that hang from a base and from each other as chains or trees, some of them closed to loops: in a plane by their angles,
/// in space by two angles each, or by the coordinates of their ends with rods as constraints.
fn linkage(random: &mut Random) -> System {
    let spatial = random.once_in(5);
    let most = if spatial { 3 } else { 7 };
    let count = 1 + random.below(most);
    let parameters = 1 + random.below(4);
    let (slides, shaken) = (random.once_in(3), random.once_in(5));
    let cartesian = !spatial && random.once_in(5);
    let relative = random.once_in(2);
    let branched = random.once_in(3);
    // Links of equal lengths and masses leave common factors.
    let equal = random.once_in(3);
    let each = if spatial || cartesian { 2 } else { 1 };
    let first = usize::from(slides);
    let n = first + each * count;
    let dimensions = if spatial { 3 } else { 2 };
    let mut links =
        Links { random, parameters, bindings: vec![], angles: vec![], ends: vec![], parents: vec![] };
    let half = || Expr::Constant(4);
    let nothing = || Expr::Constant(0);

    let prescribed = match shaken {
        true => vec![(Expr::Parameter(links.random.below(parameters)) * Expr::Time).call(Call::Sin)],
        false => vec![],
    };
    let mut base = vec![nothing(); dimensions];
    if slides {
        base[0] = Expr::Position(0);
    }
    if shaken {
        base[1] = Expr::Position(n);
    }
    let (mut kinetic, mut potential) = (Vec::new(), Vec::new());
    let mut constraints = Vec::new();
    if slides {
        kinetic.push(half() * links.size() * Expr::Position(0).rate().power(2));
    }
    let same = [links.size(), links.size(), links.size()];
    for k in 0..count {
        let parent = match k {
            0 => None,
            k if branched => Some(links.random.below(k + 1)).filter(|p| *p < k),
            k => Some(k - 1),
        };
        links.parents.push(parent);
        let [length, mass, moment] = match equal {
            true => same.clone(),
            false => [links.size(), links.size(), links.size()],
        };
        let from = parent.map_or(base.clone(), |p| links.ends[p].clone());
        let at = |i: usize| Expr::Position(first + each * k + i);
        if cartesian {
            let end = vec![at(0), at(1)];
            let apart = (at(0) - from[0].clone()).power(2) + (at(1) - from[1].clone()).power(2);
            constraints.push(Constraint { left: apart, right: length.power(2), on_velocities: false });
            kinetic.push(half() * mass.clone() * (at(0).rate().power(2) + at(1).rate().power(2)));
            potential.push(mass * at(1));
            links.ends.push(end);
            links.angles.push(at(0));
            continue;
        }
        let (angle, direction) = match spatial {
            true => {
                let out = links.bind(at(0).call(Call::Sin));
                let along = [
                    out.clone() * at(1).call(Call::Cos),
                    out * at(1).call(Call::Sin),
                    Expr::Constant(-8) * at(0).call(Call::Cos),
                ];
                (at(0), along.to_vec())
            }
            false => {
                let angle = match parent {
                    Some(p) if relative => {
                        let before = links.angles[p].clone();
                        links.bind(before + at(0))
                    }
                    _ => at(0),
                };
                let (sine, cosine) = (angle.clone().call(Call::Sin), angle.clone().call(Call::Cos));
                (angle, vec![sine, Expr::Constant(-8) * cosine])
            }
        };
        let end: Vec<Expr> = (0..dimensions)
            .map(|d| match parent.is_none() && matches!(base[d], Expr::Constant(_)) {
                true => links.bind(length.clone() * direction[d].clone()),
                false => links.bind(from[d].clone() + length.clone() * direction[d].clone()),
            })
            .collect();
        // A point at the end; or a body with its centre on the way there, which turns.
        let centre = match links.random.once_in(2) {
            true => end.clone(),
            false => {
                let part = Expr::Constant(1 + links.random.below(8) as i32);
                let mut centre = Vec::new();
                for d in 0..dimensions {
                    let sum = from[d].clone() + part.clone() * (length.clone() * direction[d].clone());
                    centre.push(if links.random.once_in(2) { links.bind(sum) } else { sum });
                }
                kinetic.push(half() * moment * angle.clone().rate().power(2));
                centre
            }
        };
        let squares = centre.iter().map(|x| x.clone().rate().power(2)).reduce(|a, b| a + b);
        kinetic.push(half() * mass.clone() * squares.expect("dimensions"));
        potential.push(mass * Expr::Constant(78) * centre[dimensions - 1].clone());
        links.ends.push(end);
        links.angles.push(angle);
    }
    for i in 0..parameters {
        // A spring at a joint, so that every parameter is used.
        let k = links.random.below(count);
        let bent = match links.parents[k] {
            Some(p) => links.angles[k].clone() - links.angles[p].clone(),
            None => links.angles[k].clone(),
        };
        potential.push(half() * Expr::Parameter(i) * bent.power(2));
    }
    if links.random.once_in(4) && count > 1 {
        // A spring between two ends.
        let (a, b) = (links.random.below(count), links.random.below(count - 1));
        let b = if b >= a { b + 1 } else { b };
        let stiffness = links.size();
        let apart = (0..dimensions).map(|d| (links.ends[a][d].clone() - links.ends[b][d].clone()).power(2));
        potential.push(half() * stiffness * apart.reduce(|a, b| a + b).expect("dimensions"));
    }
    let dissipation = links.random.once_in(3).then(|| {
        let k = links.random.below(count);
        let turn = match links.parents[k] {
            Some(p) => links.angles[k].clone().rate() - links.angles[p].clone().rate(),
            None => links.angles[k].clone().rate(),
        };
        half() * links.size() * turn.power(2)
    });
    let mut applied = Vec::new();
    if links.random.once_in(4) {
        applied.push((n - 1, links.size() * Expr::Time.call(Call::Cos) - Expr::Position(n - 1).rate()));
    }
    let mut forces = Vec::new();
    let mut struck = Vec::new();
    let hit = links.random.below(count);
    if links.random.once_in(4) {
        let end = links.ends[hit].clone();
        let air = |x: Expr, size: Expr| Expr::Constant(-8) * size * x.rate();
        for x in end {
            forces.push((air(x.clone(), links.size()), x));
        }
    }
    if links.random.once_in(3) {
        struck.push(links.ends[hit].clone());
    }
    let observed = match links.random.once_in(3) {
        true => vec![links.ends[hit][0].clone().rate() * links.ends[hit][1].clone()],
        false => vec![],
    };
    // A loop: the end of a long enough branch is held, or led, or tied to the end of another.
    let far = (0..count).rev().find(|k| links.depth(*k) >= dimensions + usize::from(cartesian));
    let closed = match far {
        Some(k) if links.random.once_in(2) => {
            let held = links.random.once_in(2);
            for d in 0..dimensions {
                let room = n > constraints.len() + 1 && (d == 0 || !cartesian);
                if room && (held || d == 0) {
                    let right = match links.random.below(3) {
                        0 => links.size(),
                        1 => half() * Expr::Time,
                        _ => Expr::Constant(8),
                    };
                    constraints.push(Constraint {
                        left: links.ends[k][d].clone(),
                        right,
                        on_velocities: false,
                    });
                }
            }
            true
        }
        _ => false,
    };
    let ignorable =
        slides && !closed && !cartesian && count > 0 && forces.is_empty() && prescribed.is_empty();
    let ignorable = ignorable && (n > 2 || each > 1);
    let sum = |terms: Vec<Expr>| terms.into_iter().reduce(|a, b| a + b).expect("a link");
    System {
        coordinates: n,
        parameters,
        prescribed,
        bindings: links.bindings,
        kinetic: sum(kinetic),
        potential: sum(potential),
        whole: links.random.once_in(6),
        dissipation,
        applied,
        forces,
        constraints,
        struck,
        observed,
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
            // The literal is a real number, whatever its value.
            Expr::Root(a, k) => write!(f, "({}).powf({:?})", w(a), f64::from(*k) / 8.0),
            Expr::Call(c, a) => write!(f, "{}({})", c.name(), w(a)),
            Expr::Atan2(a, b) => write!(f, "({}).atan2({})", w(a), w(b)),
            Expr::Hypot(a, b) => write!(f, "({}).hypot({})", w(a), w(b)),
            Expr::Choice(parts) => {
                let [a, b, yes, no] = &**parts;
                write!(f, "(if ({}) < ({}) {{ {} }} else {{ {} }})", w(a), w(b), w(yes), w(no))
            }
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
        for (j, place) in self.struck.iter().enumerate() {
            let place: Vec<String> = place.iter().map(|x| w(x).to_string()).collect();
            line(format!("impulse blow{j} at [{}];", place.join(", ")));
        }
        for (j, value) in self.observed.iter().enumerate() {
            line(format!("observe seen{j} = {};", w(value)));
        }
        if self.ignorable {
            line("pub routhian Reduced;".into());
        }
        format!("pub system {name} {{\n    {}\n}}", lines.join("\n    "))
    }
}
