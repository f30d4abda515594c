//! Links that hang together.

use super::*;

/// Ends of links, in terms of earlier bindings.
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

/// Links that hang from a base and from each other as chains or trees, some of them closed to loops: in a plane by
/// their angles, in space by two angles each, or by the coordinates of their ends with rods as constraints.
pub(super) fn linkage(random: &mut Random) -> System {
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
        kind: "linkages",
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
        frames: None,
    }
}
