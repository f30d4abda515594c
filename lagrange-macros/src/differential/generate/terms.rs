//! Sums, products and functions of anything.

use super::*;

/// Names that an expression may use.
pub(super) struct Scope<'r> {
    pub random: &'r mut Random,
    pub parameters: usize,
    pub positions: Vec<usize>,
    pub bindings: usize,
    /// Is there anything without a Taylor series?
    pub choices: bool,
}

impl Scope<'_> {
    pub fn position(&mut self) -> Expr {
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
    pub fn place(&mut self, depth: usize) -> Expr {
        if depth == 0 || self.random.once_in(8) {
            return self.leaf();
        }
        let one = self.place(depth - 1);
        match self.random.below(24) {
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
                one.with([Pair::Atan2, Pair::Hypot][self.random.below(2)], self.place(depth - 1).positive())
            }
            17 | 18 if self.choices => self.choice(one, depth),
            17..=20 => self.rarely(one, depth),
            _ => one.call([Call::Tanh, Call::Atan, Call::Asinh][self.random.below(3)]),
        }
    }

    /// Functions that have no values or derivatives everywhere, where they have, and those that grow fast.
    fn rarely(&mut self, one: Expr, depth: usize) -> Expr {
        let inside = |x: Expr| Expr::Constant(6) * x.call(Call::Sin);
        match self.random.below(14) {
            0 => inside(one).call([Call::Asin, Call::Acos, Call::Atanh][self.random.below(3)]),
            1 => one.call(Call::Sin).call([Call::Sinh, Call::Cosh][self.random.below(2)]),
            2 => (Expr::Constant(8) + one.positive()).call(Call::Acosh),
            3 => one.call(Call::Sin).call([Call::ExpM1, Call::Exp2][self.random.below(2)]),
            4 => one.power(2).call(Call::Ln1p),
            5 => inside(one).call(Call::Ln1p),
            6 => one.positive().call([Call::Log2, Call::Log10][self.random.below(2)]),
            7 => (Expr::Constant([8, -8][self.random.below(2)]) * one.positive()).call(Call::Cbrt),
            8 => one.positive().call(Call::Recip),
            9 => one.call(Call::Radians).call(Call::Sin),
            10 => Expr::Constant(1) * one.call(Call::Degrees).call(Call::Cos),
            11 => Expr::Fused(Box::new([one, self.leaf(), self.place(depth - 1)])),
            // The angle of a point on any side.
            12 => one.clone().call(Call::Cos).with(Pair::Atan2, Expr::Constant(2) + one),
            _ if self.choices => one.positive().with(Pair::Powf, self.place(depth - 1).call(Call::Sin)),
            _ => one.call(Call::Cos).with(Pair::Hypot, Expr::Constant(3)),
        }
    }

    /// An expression without a Taylor series.
    fn choice(&mut self, one: Expr, depth: usize) -> Expr {
        match self.random.below(6) {
            0 => one.call(Call::Abs),
            1 => one.call(Call::Signum) * self.place(depth - 1),
            2 => one.with([Pair::Min, Pair::Max][self.random.below(2)], self.place(depth - 1)),
            _ => {
                let test = Test::ALL[self.random.below(Test::ALL.len())];
                let leaf = self.leaf();
                Expr::Choice(test, Box::new([one, leaf, self.place(depth - 1), self.place(depth - 1)]))
            }
        }
    }

    /// A positive coefficient.
    pub fn mass(&mut self) -> Expr {
        match self.random.below(4) {
            0 => Expr::Constant(1 + self.random.below(16) as i32),
            1 => self.place(1).positive(),
            _ => Expr::Parameter(self.random.below(self.parameters)),
        }
    }
}

/// Sums, products and functions of anything.
pub(super) fn terms(random: &mut Random) -> System {
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
        kind: "terms",
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
        frames: None,
    }
}
