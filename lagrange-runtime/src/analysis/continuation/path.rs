//! Steps along a curve of equilibria.

use super::bifurcation::bifurcation;
use super::branch::{Bifurcation, BifurcationKind, Branch, BranchPoint, Path};
use super::curve::{Curve, Place, cubic, flat};
use crate::analysis::AnalysisError;
use crate::event::first_zero;
use nalgebra::DMatrix;

/// Shortest step, relative to the longest.
const SHORTEST: f64 = 1e-9;

/// Steps longer than this part of the longest are shortened where a sign nearly changes.
const CLOSE: f64 = 1e-3;

/// Distance from the start, relative to `1 + |z|`, within which a bifurcation is the one that the curve starts at.
const START: f64 = 1e-8;

/// Largest real part of a root, relative to the root, right where it begins to grow.
const ONSET: f64 = 1e-4;

pub(super) fn followed(curve: &Curve, start: Place, path: &Path) -> Result<Branch, AnalysisError> {
    let n = start.z.len() - 1;
    let origin = start.z.clone();
    let mut branch = Branch { points: vec![curve.point(&start)?], bifurcations: Vec::new(), complete: false };
    let (mut from, mut h) = (start, path.step);
    // A start at a branch point has more null vectors than its neighbours, and no signs.
    let beside = &from.z + &from.tangent * (CLOSE * CLOSE * path.step);
    let beside = curve.corrected(beside, &from.tangent, &DMatrix::zeros(n + 1, 0))?;
    let beside = curve.place(beside, &from.tangent)?;
    let mut signed = beside.nullity() >= from.nullity();
    let mut idle = beside.idle();
    for _ in 0..path.steps {
        let ([middle, to], found) = loop {
            match curve.step(&from, h, signed, &idle, path.step) {
                Some(step) => break step,
                None if h > SHORTEST * path.step => h *= 0.5,
                None => return Err(curve.stuck(&from, h)),
            }
        };
        curve.no_switch([&from, &middle, &to])?;
        let point = curve.point(&to)?;
        let near = |found: &Bifurcation| {
            let away = (found.q.clone() - origin.rows(0, n)).norm().hypot(found.parameter - origin[n]);
            away <= (CLOSE * CLOSE * path.step).min(START * (1.0 + origin.amax()))
        };
        branch.bifurcations.extend(found.into_iter().filter(|found| !near(found)));
        branch.bifurcations.extend(curve.flutter(&from, &to)?);
        branch.bifurcations.extend(curve.dependent([&from, &middle, &to]));
        branch.points.push(point);
        from = match curve.equations.turned(&to.z, &to.tangent) {
            Some([z, tangent]) => curve.place(z, &tangent.normalize())?,
            None => to,
        };
        (idle, signed) = (from.idle(), true);
        if !(path.range.0..=path.range.1).contains(&from.z[n]) {
            branch.complete = true;
            break;
        }
        h = (1.5 * h).min(path.step);
    }
    let inside = |found: &Bifurcation| (path.range.0..=path.range.1).contains(&found.parameter);
    branch.bifurcations.retain(inside);
    Ok(branch)
}

impl Curve<'_> {
    /// Is the place far enough from a branch point for its signs to be known?
    fn known(&self, at: &Place, idle: usize) -> bool {
        idle < at.z.len() && at.volume(idle).abs() > 16.0 * flat(at.z.len()) * at.size()
    }

    /// A step of the length h: the places in its middle and at its end, and the bifurcations between. None where it
    /// is too long for what the curve does there. `signed`: the signs at its start are known; `idle`: equilibria lie
    /// beside it there.
    fn step(
        &self,
        from: &Place,
        h: f64,
        signed: bool,
        idle: &DMatrix<f64>,
        length: f64,
    ) -> Option<([Place; 2], Vec<Bifurcation>)> {
        let to = self.corrected(&from.z + &from.tangent * h, &from.tangent, idle).ok()?;
        let to = self.place(to, &from.tangent).ok()?;
        // A curve that bends evenly leaves along the chord as much as it arrives; one beside it is reached across.
        let bend = to.tangent.dot(&from.tangent);
        let chord = (&to.z - &from.z).normalize() - (&to.tangent + &from.tangent).normalize();
        if !(bend > 0.95 && chord.norm() < 0.02) {
            return None;
        }
        let (guess, direction) = cubic(from, &to, 0.5);
        let middle = self.corrected(guess.clone(), &direction, idle).ok()?;
        let middle = self.place(middle, &direction).ok()?;
        if (&middle.z - &guess).norm() > 2e-3 * h || middle.tangent.dot(&direction) < 0.999 {
            return None;
        }
        // Likewise of each coordinate, whatever its unit.
        let strays = |i: usize| {
            let tangents = [&from.tangent, &middle.tangent, &to.tangent].map(|tangent| tangent[i].abs());
            let motion = h * tangents.into_iter().fold(0.0, f64::max);
            (middle.z[i] - guess[i]).abs() > 0.01 * motion + CLOSE * SHORTEST * (1.0 + guess[i].abs())
        };
        if (0..guess.len()).any(strays) {
            return None;
        }
        let idle = middle.nullity().min(to.nullity());
        if !(self.known(&middle, idle) && self.known(&to, idle)) {
            return None;
        }
        let mut found = Vec::new();
        if signed {
            let close = |g: [f64; 3]| h > CLOSE * length && nearly_zero(g);
            let turns = [from, &middle, &to].map(Place::turn);
            let volumes = [from, &middle, &to].map(|place| place.volume(idle));
            if close(turns) || close(volumes) {
                return None;
            }
            found.extend(self.bifurcations(from, &middle, length)?);
        }
        found.extend(self.bifurcations(&middle, &to, length)?);
        Some(([middle, to], found))
    }

    /// Reason why there is no step from here, however short.
    fn stuck(&self, from: &Place, h: f64) -> AnalysisError {
        let [here, there] = [0.0, 16.0 * h].map(|h| self.equations.switching(&(&from.z + &from.tangent * h)));
        if let Some(index) = (0..here.len()).find(|&k| here[k] * there[k] <= 0.0) {
            return AnalysisError::Switch { index };
        }
        if let Some(dependent) = self.equations.nearly_dependent(&from.z) {
            return dependent;
        }
        AnalysisError::Unresolved { parameter: from.z[from.z.len() - 1], step: h }
    }

    /// The point that is handed out.
    fn point(&self, at: &Place) -> Result<BranchPoint, AnalysisError> {
        let n = at.z.len() - 1;
        self.equations.smooth(&at.z)?;
        let stability = self.equations.stability(&at.z, &self.equations.small(&at.z)?)?;
        Ok(BranchPoint {
            parameter: at.z[n],
            q: at.z.rows(0, n).into_owned(),
            negative: at.negative,
            stability,
        })
    }

    /// Refuses a step across a switch at which the forces are not smooth.
    fn no_switch(&self, places: [&Place; 3]) -> Result<(), AnalysisError> {
        let values = places.map(|place| self.equations.switching(&place.z));
        for (k, pair) in [(0, 1), (1, 2)] {
            for index in 0..values[k].len() {
                let ends = [values[k][index], values[pair][index]];
                if ends[0] * ends[1] < 0.0 {
                    let (a, b) = (places[k], places[pair]);
                    let mut value = |x: f64| {
                        self.between(a, b, x)
                            .map_or(f64::NAN, |place| self.equations.switching(&place.z)[index])
                    };
                    let x = first_zero(&mut value, (0.0, ends[0]), (1.0, ends[1]), f64::EPSILON);
                    match self.between(a, b, x) {
                        Ok(at) => self.equations.smooth(&at.z)?,
                        Err(_) => return Err(AnalysisError::Switch { index }),
                    }
                }
            }
        }
        Ok(())
    }

    /// Positions between places at which constraints are dependent.
    fn dependent(&self, [from, middle, to]: [&Place; 3]) -> impl Iterator<Item = Bifurcation> {
        [(from, middle), (middle, to)].into_iter().filter_map(|(a, b)| {
            // (Where constraints are dependent, corrections may lead astray.)
            let at = |x: f64| self.between(a, b, x).map_or_else(|_| cubic(a, b, x), |at| (at.z, at.tangent));
            let mut alike = |x: f64| if self.equations.oriented_alike(&a.z, &at(x).0) { 1.0 } else { -1.0 };
            (!self.equations.oriented_alike(&a.z, &b.z)).then(|| {
                let x = first_zero(&mut alike, (0.0, 1.0), (1.0, -1.0), f64::EPSILON);
                let (z, direction) = at(x);
                bifurcation(BifurcationKind::DependentConstraints, &z, direction, Vec::new())
            })
        })
    }

    /// Bisects for the point between two places at which a pair of complex roots begins or ceases to grow.
    fn flutter(&self, a: &Place, b: &Place) -> Result<Option<Bifurcation>, AnalysisError> {
        let growing = |place: &Place| self.equations.small(&place.z)?.growing_oscillation();
        let (before, after) = (growing(a)?.is_some(), growing(b)?.is_some());
        if before == after {
            return Ok(None);
        }
        let (mut calm, mut wild) = if before { (1.0, 0.0) } else { (0.0, 1.0) };
        loop {
            let middle: f64 = 0.5 * (calm + wild);
            if middle == calm || middle == wild {
                break;
            }
            match growing(&self.between(a, b, middle)?)? {
                Some(_) => wild = middle,
                None => calm = middle,
            }
        }
        let at = self.between(a, b, wild)?;
        // Two growing roots that become a pair have grown before.
        let onset = growing(&at)?.filter(|root| root.re <= ONSET * root.norm());
        Ok(onset.map(|_| bifurcation(BifurcationKind::Flutter, &at.z, at.tangent.clone(), Vec::new())))
    }
}

/// Does the parabola through values at the ends and in the middle nearly vanish between them, without a change of sign?
fn nearly_zero([a, m, b]: [f64; 3]) -> bool {
    let (slope, bend) = (b - a, 2.0 * (a + b - 2.0 * m));
    let x = 0.5 - 0.5 * slope / bend;
    let least = m - 0.25 * slope * slope / bend;
    let same = a * m > 0.0 && m * b > 0.0;
    same && x > 0.0 && x < 1.0 && least * a.signum() < 0.1 * a.abs().min(b.abs())
}
