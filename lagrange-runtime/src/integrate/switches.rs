//! Adaptive steps end where the equations switch (`if`, `abs`, `signum`, `min`, `max`): the error estimate and the
//! interpolant of a step hold only where the accelerations are smooth.
//!
//! A step that crosses a switch is forgotten, and a shorter one is made that ends just before it. The switch itself
//! is crossed by a step so short that the accelerations on the wrong side change its end by less than [`SHARE`] of
//! the tolerance (Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, 1993, II.6). The step
//! after it begins anew, with the size that the controller chose before.

use crate::event::scan::{Crossings, Grid};
use crate::event::within::Within;
use crate::failure::Failure;
use crate::method::explicit_rk::Rk4;
use crate::method::hermite::Hermite;
use crate::method::{Interpolant, Method};
use crate::scalar::{Real, Scalar};
use crate::state::{State, Tangent};
use crate::system::System;
use nalgebra::SVector;

/// Largest change of the end of a step across a switch by accelerations of the wrong side, over the tolerance.
const SHARE: f64 = 0.01;

/// A step across a switch goes beyond it by this share, and by four times the share if it did not get there.
const BEYOND: f64 = 1.0 / 64.0;

/// The first step towards a switch ends before it by this share, each one after that by the square of the share before.
const MARGIN: f64 = 1.0 / 16.0;

/// Roundings of time that are the shortest step across a switch.
const ROUNDINGS: f64 = 64.0;

/// Roundings of coordinates and velocities that the shortest step across a switch has to exceed, and how much longer
/// that may make it.
const BLUR: f64 = 4.0;
const LARGEST: f64 = 1_048_576.0;

/// Number of steps that are tried in place of one that ended on a switch itself.
const MOST_BESIDE: u32 = 8;

/// Number of times that the shortest step across a switch is doubled if the method cannot make it.
const DOUBLINGS: u32 = 10;

/// Successive crossings, each within so many shortest steps of the one before, after which the motion counts as
/// sliding.
const CHATTER: u32 = 50;
const CHATTERING: f64 = 1024.0;

/// Switching functions that are looked at together in a step, and the places at which their values are kept.
const TOGETHER: usize = 8;
const PLACES: usize = 32;

/// State of the approach of a run to a switch.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Approach {
    /// Size of the step that is to end before the switch or to cross it, in the direction of the run; 0 far from
    /// switches.
    pub h: f64,
    /// The last so many steps that were tried crossed the switch.
    crossed: u32,
    /// Share of the next step by which it is to end before the switch.
    margin: f64,
    /// Share of the next step by which it is to end beyond the switch.
    beyond: f64,
    /// The shortest step that is tried, and how often it has been doubled.
    least: f64,
    doublings: u32,
    /// Successive crossings shortly after each other, and the time of the last one.
    crossings: u32,
    #[cfg_attr(feature = "serde", serde(with = "crate::saved::number"))]
    last: f64,
}

impl Approach {
    /// Far from all switches.
    pub const NONE: Approach = Approach {
        h: 0.0,
        crossed: 0,
        margin: MARGIN,
        beyond: BEYOND,
        least: 0.0,
        doublings: 0,
        crossings: 0,
        last: f64::NAN,
    };

    /// A step is being tried on the way to a switch.
    pub fn is_near(&self) -> bool {
        self.h != 0.0
    }

    /// Returns whether another step from `at` is to be tried, to a switch or across it, after one of size h that the
    /// method could not make: iterations of implicit methods need not converge where a stage falls on a switch.
    ///
    /// # Errors
    /// [`Failure::Sliding`] as [`passage`].
    pub fn after_failure<Sys: System<N>, const N: usize>(
        &mut self,
        system: &Sys,
        at: &State<Sys::Scalar, N>,
        h: f64,
    ) -> Result<bool, Failure<Sys::Scalar>>
    where
        Sys::Scalar: Real,
    {
        if !self.is_near() {
            let time = ahead(system, at, &system.accel(&at.q, &at.qd, at.t), h);
            self.begin(at.t.to_f64(), h, Sys::Scalar::EPSILON);
            if time == 0.0 && is_held(system, at, &system.accel(&at.q, &at.qd, at.t), self.least.copysign(h))
            {
                return Err(Failure::Sliding { t: at.t });
            }
            self.crossed = 1;
            self.h = time * (1.0 - self.margin);
            return Ok(self.is_near());
        }
        let long = self.h.abs() > self.least;
        if self.crossed > 0 && long {
            return Ok(false);
        }
        if long {
            self.aim(self.h * (1.0 - self.margin) / (1.0 + self.beyond));
            self.crossed = 1;
        } else if self.doublings < DOUBLINGS {
            self.doublings += 1;
            self.least *= 2.0;
            self.aim(self.h);
        } else {
            let accelerations = system.accel(&at.q, &at.qd, at.t);
            return if is_held(system, at, &accelerations, self.h) {
                Err(Failure::Sliding { t: at.t })
            } else {
                Ok(false)
            };
        }
        Ok(true)
    }

    /// Begins at the time t, with a step of size h that did not end before a switch.
    fn begin(&mut self, t: f64, h: f64, epsilon: f64) {
        let least = shortest(t, h, epsilon);
        let &mut Approach { crossings, last, .. } = self;
        *self = Approach { least, crossings, last, ..Approach::NONE };
    }

    /// Tries a step of this size, or the shortest one.
    fn aim(&mut self, h: f64) {
        let size = h.abs().max(self.least);
        // (Of 0, too: a step from a switch begins with the shortest one, in the direction of the run.)
        self.h = if h.is_sign_negative() { -size } else { size };
    }

    /// Tries a step of another size, if not too often, in the place of one of size h that ended on a switch itself:
    /// it would be across it for neither the step to it nor the one from it, and neighbouring motions would not be
    /// told so.
    pub fn beside(&mut self, h: f64) -> Option<Passage> {
        if !self.is_near() || self.crossed >= MOST_BESIDE {
            return None;
        }
        if h.abs() <= self.least {
            self.least *= 1.0 + 8.0 * BEYOND;
        }
        Some(self.again(h * (1.0 - BEYOND)))
    }

    /// Tries a step of this size in the place of one that crossed a switch.
    fn again(&mut self, h: f64) -> Passage {
        self.aim(h);
        self.crossed += 1;
        Passage::Again
    }
}

/// The shortest step that is tried about the time t, after one of size h.
fn shortest(t: f64, h: f64, epsilon: f64) -> f64 {
    ROUNDINGS * epsilon * t.abs().max((t + h).abs()).max(h.abs())
}

/// A decision on a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Passage {
    /// The controller decides.
    Free,
    /// Another one is made in its place, of the size in the approach.
    Again,
    /// It is taken, whatever the controller says, and the next one begins anew beyond this switch.
    Across { switch: usize },
}

/// Decides on a step with regard to the switches of the system. `rejected` is the factor of the next step if the
/// controller rejects this one, and `norm` is that of the controller.
///
/// # Errors
/// [`Failure::Sliding`] if the accelerations on both sides of a switch lead back to it.
pub(super) fn passage<Sys, const N: usize>(
    approach: &mut Approach,
    system: &Sys,
    step: &impl Within<Sys::Scalar, N>,
    rejected: Option<f64>,
    norm: impl Fn(&Tangent<Sys::Scalar, N>, &State<Sys::Scalar, N>, &State<Sys::Scalar, N>) -> f64,
) -> Result<Passage, Failure<Sys::Scalar>>
where
    Sys: System<N>,
    Sys::Scalar: Real,
{
    let [from, to] = step.ends();
    let h = step.size().to_f64();
    if !approach.is_near() {
        approach.begin(from.t.to_f64(), h, Sys::Scalar::EPSILON);
    }
    let accel = |at: &State<Sys::Scalar, N>| system.accel(&at.q, &at.qd, at.t);
    let before = accel(&from);
    // Slopes of the accelerations jump at a kink of the forces, and each slope has the tolerance of its own size.
    let effect = |after: SVector<Sys::Scalar, N>| {
        let jump = (after - before) * step.size();
        let by = Tangent { q: jump * step.size(), qd: jump };
        (0..Sys::Scalar::SLOPES).fold(norm(&by, &from, &to), |most, direction| {
            let slope = |x: &SVector<_, N>| x.map(|x: Sys::Scalar| Scalar::from_f64(x.slope(direction)));
            let of = |at: &State<_, N>| State { t: at.t, q: slope(&at.q), qd: slope(&at.qd) };
            most.max(norm(&Tangent { q: slope(&by.q), qd: slope(&by.qd) }, &of(&from), &of(&to)))
        })
    };
    // A step from a switch has accelerations of another side at its start where they jump. Coordinates may be rounded
    // more than time is.
    let mut off = 2.0 * step.resolution();
    let mut left = None;
    if changed(system, &from, &to, |a, _| a == 0.0).is_some() {
        let leaves = |x: &f64| changed(system, &from, &step.at(*x), |a, b| a == 0.0 && b != 0.0).is_some();
        let places = core::iter::successors(Some(off), |x| Some(2.0 * x));
        if let Some(x) = places.take_while(|x| *x < 1.0).find(leaves) {
            let next = step.at(x);
            off = x;
            left = changed(system, &from, &next, |a, b| a == 0.0 && b != 0.0);
            left = left.filter(|_| effect(accel(&next)) > SHARE);
        }
    }
    let crossing = match left {
        Some(switch) => Some((switch, 0.0)),
        None => first(system, step, approach.crossings > 0),
    };
    if crossing.is_none() && rejected.is_none() && h.abs() > approach.least {
        // A stage of the interpolant alone that falls into what all others step over ruins the interpolant, and hides
        // the switch. The motion that the ends alone determine shows it then.
        let by_ends = by_ends([from, to], step.size(), step.parts(), [before, accel(&to)]);
        let differs = norm(&step.at(0.5).minus(&by_ends.at(0.5)), &from, &to) > 1.0;
        if differs && first(system, &by_ends, false).is_some() {
            return Ok(approach.again(0.5 * h));
        }
    }
    if crossing.is_none() && rejected.is_none() {
        // Stages that a force throws to and fro about a switch say nothing of a motion that the switch holds, and the
        // step ends where it began, within the tolerance. One that ends before the switch has no such stages.
        let soon = CHATTERING * approach.least;
        match held_within(system, &from, &before, h.abs().max(soon).copysign(h)) {
            Some(time) if time.abs() <= soon => {
                return Err(Failure::Sliding { t: from.t + Sys::Scalar::from_f64(time) });
            }
            Some(time) if time.abs() < h.abs() => return Ok(approach.again((1.0 - BEYOND) * time)),
            _ => {}
        }
    }
    let Some((switch, x)) = crossing else {
        if rejected.is_none() && approach.is_near() {
            if approach.crossed == 0 {
                approach.beyond *= 4.0;
            }
            approach.crossed = 0;
            approach.margin *= approach.margin;
            let time = ahead(system, &to, &accel(&to), h);
            if time == 0.0 { approach.h = 0.0 } else { approach.aim(time * (1.0 + approach.beyond)) }
        } else if rejected.is_none() {
            approach.crossings = 0;
        }
        return Ok(Passage::Free);
    };
    // Coordinates and velocities may be rounded more than time is: a shorter step would not move them.
    let time = blurred(system, &from, &before, switch)
        .min(LARGEST * shortest(from.t.to_f64(), h, Sys::Scalar::EPSILON));
    approach.least = approach.least.max(time);
    // Right after the switch, in the middle of what is beyond it, and at the end.
    let after = |x: f64| accel(&step.at(x.min(1.0)));
    let after = [after(x + off), after(0.5 * (1.0 + x)), after(1.0)];
    // (A step that ends on the side that it came from has been through all that is on the other side.)
    let side = |at| evaluated(system, at, &before, switch)[0][0];
    let through = side(&from) * side(&to) > 0.0;
    let short = approach.is_near()
        && switch >= Sys::IMPULSES
        && rejected.is_none()
        && !through
        && after.iter().all(|after| effect(*after) <= SHARE);
    if h.abs() <= approach.least || short {
        let last = to.t.to_f64();
        let soon = (last - approach.last).abs() <= CHATTERING * approach.least;
        let crossings = if soon { approach.crossings + 1 } else { 1 };
        if crossings > CHATTER || is_led_back(system, [&from, &to], [&before, &after[0]], switch, h) {
            return Err(Failure::Sliding { t: to.t });
        }
        *approach = Approach { crossings, last, ..Approach::NONE };
        return Ok(Passage::Across { switch });
    }
    // The root of the interpolant of a step beyond the switch is not that of the motion; the second time it counts as
    // a bound, and of what is beyond it twice as much is left out each time. And states within a step are less
    // accurate than its end, by the square of its size: that much before the switch it ends.
    let part = match approach.crossed {
        0 => x * (1.0 - approach.margin),
        times => 1.0 - (1u64 << times.min(62)) as f64 * (1.0 - x).max(step.resolution()),
    };
    let part = part.max(0.5 * x).min(1.0 - step.resolution());
    match rejected {
        Some(factor) if !approach.is_near() && factor < part => Ok(Passage::Free),
        _ => Ok(approach.again(part * h)),
    }
}

/// The motion within a step, by its interpolant.
pub(super) struct Interpolated<S, F, const N: usize> {
    pub ends: [State<S, N>; 2],
    pub h: S,
    pub parts: u32,
    /// The state of the interpolant at a part of the step.
    pub between: F,
}

impl<S: Real, F: Fn(f64) -> State<S, N>, const N: usize> Within<S, N> for Interpolated<S, F, N> {
    fn parts(&self) -> u32 {
        self.parts
    }

    fn ends(&self) -> [State<S, N>; 2] {
        self.ends
    }

    fn size(&self) -> S {
        self.h
    }

    fn between(&self, x: f64) -> State<S, N> {
        (self.between)(x)
    }
}

/// The motion within a step by the states and accelerations at its ends: the polynomials of Hermite, of degree 5 for
/// coordinates and of degree 3 for velocities. (The derivative of the first one has the rounding of coordinates,
/// divided by the size of the step.)
fn by_ends<S: Real, const N: usize>(
    [from, to]: [State<S, N>; 2],
    h: S,
    parts: u32,
    [before, after]: [SVector<S, N>; 2],
) -> Interpolated<S, impl Fn(f64) -> State<S, N>, N> {
    let hermite = Hermite::new(&from, &to, h, &before, &after);
    let change = to.qd - from.qd;
    let bends = [before, after].map(|accel| accel * h - change);
    let between = move |x: f64| {
        let [x, rest] = [x, 1.0 - x].map(S::from_f64);
        let qd = from.qd + change * x + (bends[0] * rest - bends[1] * x) * (x * rest);
        State { qd, ..hermite.at(h.mul_add(x, from.t)) }
    };
    Interpolated { ends: [from, to], h, parts, between }
}

/// The time in which a switching function changes by its rounding: by [`BLUR`] roundings of each coordinate and
/// velocity.
fn blurred<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    accelerations: &SVector<Sys::Scalar, N>,
    switch: usize,
) -> f64
where
    Sys::Scalar: Real,
{
    const PART: f64 = 1.0 / (1u64 << 20) as f64;
    let value = |at: &State<Sys::Scalar, N>| evaluated(system, at, accelerations, switch)[0];
    let [g, rate] = value(at);
    let more = Sys::Scalar::from_f64(1.0 + PART);
    let moved = (0..N).flat_map(|i| {
        let [mut in_q, mut in_qd] = [*at; 2];
        in_q.q[i] *= more;
        in_qd.qd[i] *= more;
        [in_q, in_qd]
    });
    let changes: f64 = moved.map(|at| (value(&at)[0] - g).abs()).sum();
    BLUR * Sys::Scalar::EPSILON * changes / (PART * rate.abs())
}

/// Do the accelerations before and after a switch lead the state after it in opposite directions, both of them to the
/// switch? The time goes on by h.
fn is_led_back<Sys: System<N>, const N: usize>(
    system: &Sys,
    [from, to]: [&State<Sys::Scalar, N>; 2],
    [before, after]: [&SVector<Sys::Scalar, N>; 2],
    switch: usize,
    h: f64,
) -> bool
where
    Sys::Scalar: Real,
{
    let [side, _] = evaluated(system, from, before, switch)[0];
    let [inwards, outwards] = [before, after].map(|accel| evaluated(system, to, accel, switch)[0][1] * h);
    side * inwards < 0.0 && side * outwards > 0.0
}

/// The time in which the motion from `at` comes to a switch that holds it, by its rates, if there is one within h.
fn held_within<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    accel: &SVector<Sys::Scalar, N>,
    h: f64,
) -> Option<f64>
where
    Sys::Scalar: Real,
{
    let time = Some(ahead(system, at, accel, h)).filter(|time| *time != 0.0)?;
    is_held(system, &by_rates(at, accel, time), accel, BEYOND * time).then_some(time)
}

/// The state after a time by the rates alone.
fn by_rates<S: Real, const N: usize>(
    at: &State<S, N>,
    accelerations: &SVector<S, N>,
    time: f64,
) -> State<S, N> {
    let time = S::from_f64(time);
    at.moved(at.t + time, time, &Tangent { q: at.qd, qd: *accelerations })
}

/// Does the motion through `at` with these accelerations cross a switch within the time h of it that it is led back to
/// on both sides?
fn is_held<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    accelerations: &SVector<Sys::Scalar, N>,
    h: f64,
) -> bool
where
    Sys::Scalar: Real,
{
    let sides = [-h, h].map(|h| by_rates(at, accelerations, h));
    let [before, after] = sides.map(|at| system.accel(&at.q, &at.qd, at.t));
    (0..Sys::SWITCHES).any(|switch| {
        let [a, b] = [&sides[0], &sides[1]].map(|at| evaluated(system, at, &before, switch)[0][0]);
        a * b < 0.0 && is_led_back(system, [&sides[0], &sides[1]], [&before, &after], switch, h)
    })
}

/// The time from `at` to the first switch that the motion meets within `h` by its rates; 0 if there is none.
fn ahead<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    accel: &SVector<Sys::Scalar, N>,
    h: f64,
) -> f64
where
    Sys::Scalar: Real,
{
    let mut nearest = 0.0f64;
    system.switches(at, accel, |_, [g, rate]| {
        let time = -g.to_f64() / rate.to_f64();
        if time * h > 0.0 && time.abs() <= h.abs() && (nearest == 0.0 || time.abs() < nearest.abs()) {
            nearest = time;
        }
    });
    nearest
}

/// Do the signs of any switching function differ?
pub(super) fn differ<Sys: System<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
) -> bool
where
    Sys::Scalar: Real,
{
    changed(system, from, to, |a, b| a * b < 0.0 || a == 0.0 && b != 0.0).is_some()
}

/// Do two states lie on different sides of a switch?
pub fn crossed<Sys: System<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
) -> bool
where
    Sys::Scalar: Real,
{
    changed(system, from, to, |a, b| a * b < 0.0).is_some()
}

/// Did a step cross a switch at which an impulse acts?
#[cold]
pub(super) fn needs_impulse<Sys: System<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
) -> bool
where
    Sys::Scalar: Real,
{
    let acts = |switch: usize, a: f64, b: f64| {
        switch < Sys::IMPULSES && crosses(a, b) && system.decides(switch, &between(from, to, a / (a - b)))
    };
    found(system, from, to, acts).is_some()
}

/// Is the side of the first of these values left, be it onto the switch itself?
fn crosses(a: f64, b: f64) -> bool {
    a < 0.0 && b >= 0.0 || a > 0.0 && b <= 0.0
}

/// Equal steps between two looks for a switch that holds the motion. It need not be crossed: stages on both sides of it
/// may cancel in each step, and the motion creeps. A look goes so many steps ahead, in parts of a step: where one of
/// the accelerations is small, it leads back to the switch in several steps, and the other one throws the motion off
/// before it is there.
const LOOK: u64 = 16;
const AHEAD: f64 = 8.0;
const PART: f64 = 0.125;
const MOST_PARTS: u32 = 256;

/// Part of the way across a switch, beside it, at which the accelerations are looked at.
const BESIDE: f64 = 1.0 / (1u64 << 20) as f64;

/// Fails if a switch holds the motion that this step, after so many equal ones, has brought to it.
///
/// # Errors
/// [`Failure::Sliding`].
#[cfg_attr(not(debug_assertions), inline(always))]
pub(super) fn not_held<Sys: System<N>, const N: usize>(
    system: &Sys,
    [from, to]: [&State<Sys::Scalar, N>; 2],
    h: Sys::Scalar,
    count: u64,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    if !Sys::HOLDS || !count.is_multiple_of(LOOK) {
        return Ok(());
    }
    looked_at(system, [*from, *to], h)
}

/// A look after one of many steps. (By values: addresses of its ends would keep the run in memory.)
#[cold]
#[inline(never)]
fn looked_at<Sys: System<N>, const N: usize>(
    system: &Sys,
    [from, to]: [State<Sys::Scalar, N>; 2],
    h: Sys::Scalar,
) -> Result<(), Failure<Sys::Scalar>>
where
    Sys::Scalar: Real,
{
    if is_held_between(system, &from, &to) {
        return Err(Failure::Sliding { t: to.t });
    }
    let accelerations = system.accel(&to.q, &to.qd, to.t);
    let [whole, beside] = [AHEAD, BESIDE].map(|steps| steps * h.to_f64());
    let is_on_one = changed(system, &to, &to, |g, _| g == 0.0).is_some();
    if is_on_one && is_held(system, &to, &accelerations, beside) {
        return Err(Failure::Sliding { t: to.t });
    }
    let time = ahead(system, &to, &accelerations, whole);
    let around = (BEYOND * time.abs()).max(beside.abs()).copysign(whole);
    if time == 0.0 || !is_held(system, &by_rates(&to, &accelerations, time), &accelerations, around) {
        return Ok(());
    }
    // By its rates alone the motion comes to a switch that holds it; its parts tell whether it does. They do not go
    // beyond half of the way that the rates say, since one across a switch has stages on both sides of it.
    let (mut at, mut gone) = (to, 0.0);
    for _ in 0..MOST_PARTS {
        let accelerations = system.accel(&at.q, &at.qd, at.t);
        let time = ahead(system, &at, &accelerations, whole - gone);
        if time != 0.0 && time.abs() <= beside.abs() {
            let met = by_rates(&at, &accelerations, time);
            return match is_held(system, &met, &accelerations, beside) {
                true => Err(Failure::Sliding { t: met.t }),
                false => Ok(()),
            };
        }
        let part = if time == 0.0 { whole - gone } else { 0.5 * time };
        let part = part.abs().min(PART * h.to_f64().abs()).copysign(whole);
        let memory = Rk4.start(system, &at)?;
        let next = Rk4.last_step(system, &memory, &at, Sys::Scalar::from_f64(part))?.to;
        if is_held_between(system, &at, &next) {
            return Err(Failure::Sliding { t: next.t });
        }
        (at, gone) = (next, gone + part);
        if gone.abs() >= whole.abs() || differ(system, &to, &at) {
            break;
        }
    }
    Ok(())
}

/// Do the accelerations on both sides of a switch between two states lead back to it?
fn is_held_between<Sys: System<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
) -> bool
where
    Sys::Scalar: Real,
{
    let h = (to.t - from.t).to_f64();
    let holds = |switch: usize, a: f64, b: f64| {
        if !crosses(a, b) {
            return false;
        }
        let part = a / (a - b);
        let sides = [part - BESIDE, part + BESIDE].map(|part| between(from, to, part));
        let [before, after] = [&sides[0], &sides[1]].map(|at| system.accel(&at.q, &at.qd, at.t));
        is_led_back(system, [&sides[0], &sides[1]], [&before, &after], switch, h)
    };
    found(system, from, to, holds).is_some()
}

/// The state at a part of the straight line from one to another.
fn between<S: Real, const N: usize>(from: &State<S, N>, to: &State<S, N>, part: f64) -> State<S, N> {
    let part = S::from_f64(part);
    from.moved((to.t - from.t).mul_add(part, from.t), part, &to.minus(from))
}

/// The start of a motion that begins within rounding of a switch at which an impulse acts, moved to the side that its
/// velocities lead to: it goes on with what the impulse left.
#[cold]
pub(super) fn beyond_impulses<Sys: System<N>, const N: usize>(
    system: &Sys,
    start: &State<Sys::Scalar, N>,
    backward: bool,
) -> State<Sys::Scalar, N>
where
    Sys::Scalar: Real,
{
    let rest = SVector::repeat(Scalar::zero());
    (0..Sys::IMPULSES).fold(*start, |at, switch| {
        let [g, rate] = evaluated(system, &at, &rest, switch)[0];
        if !system.decides(switch, &at) {
            return at;
        }
        let rounding = shortest(at.t.to_f64(), 0.0, Sys::Scalar::EPSILON);
        let time = rounding.max(blurred(system, &at, &rest, switch));
        let time = if g == 0.0 { time.max(Sys::Scalar::EPSILON) } else { time };
        let back = if backward { -1.0 } else { 1.0 };
        if rate == 0.0 || g * rate * back > 0.0 || g.abs() > rate.abs() * time {
            return at;
        }
        let time = back * (time + (g / rate).abs());
        State { q: at.q + at.qd * Sys::Scalar::from_f64(time), ..at }
    })
}

/// The first switching function that vanishes at the end of a step, and not at its start.
pub(super) fn landed_on<Sys: System<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
) -> Option<usize>
where
    Sys::Scalar: Real,
{
    changed(system, from, to, |a, b| a.abs() > 0.0 && b == 0.0)
}

/// The first switching function whose values at both states satisfy `condition`. It has to be false of a first value
/// that is NaN.
fn changed<Sys: System<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
    condition: impl Fn(f64, f64) -> bool,
) -> Option<usize>
where
    Sys::Scalar: Real,
{
    found(system, from, to, |_, a, b| condition(a, b))
}

/// The same by its index, too.
fn found<Sys: System<N>, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    to: &State<Sys::Scalar, N>,
    condition: impl Fn(usize, f64, f64) -> bool,
) -> Option<usize>
where
    Sys::Scalar: Real,
{
    (0..Sys::SWITCHES).step_by(TOGETHER).find_map(|begin| {
        let of = |at| evaluated(system, at, &SVector::repeat(Scalar::zero()), begin);
        let (a, b) = (of(from), of(to));
        (0..TOGETHER).find(|i| condition(begin + i, a[*i][0], b[*i][0])).map(|i| begin + i)
    })
}

/// Values and rates of the switching functions from the index `begin` on; NaN beyond the last one.
fn evaluated<Sys: System<N>, const N: usize>(
    system: &Sys,
    at: &State<Sys::Scalar, N>,
    accelerations: &SVector<Sys::Scalar, N>,
    begin: usize,
) -> [[f64; 2]; TOGETHER]
where
    Sys::Scalar: Real,
{
    let mut found = [[f64::NAN; 2]; TOGETHER];
    system.switches(at, accelerations, |i, both| {
        if let Some(found) = i.checked_sub(begin).and_then(|i| found.get_mut(i)) {
            *found = [both[0].to_f64(), both[1].to_f64()];
        }
    });
    found
}

/// The first switch that is crossed within a step, and where, as a part of the step. The step may be the first one
/// after a crossing.
fn first<Sys: System<N>, const N: usize>(
    system: &Sys,
    step: &impl Within<Sys::Scalar, N>,
    anew: bool,
) -> Option<(usize, f64)>
where
    Sys::Scalar: Real,
{
    let rest = SVector::repeat(Scalar::zero());
    let grid = Grid::new(step.parts(), anew, Sys::Scalar::EPSILON);
    let mut first: Option<(usize, f64)> = None;
    for begin in (0..Sys::SWITCHES).step_by(TOGETHER) {
        // Values at the places of the grid, which all of them ask for.
        let (mut known, mut count) = ([(f64::NAN, [[f64::NAN; 2]; TOGETHER]); PLACES], 0);
        for switch in begin..Sys::SWITCHES.min(begin + TOGETHER) {
            let g = |x: f64| {
                if let Some((_, values)) = known[..count].iter().find(|(place, _)| *place == x) {
                    return values[switch - begin][0];
                }
                let values = evaluated(system, &step.at(x), &rest, begin);
                if count < PLACES {
                    known[count] = (x, values);
                    count += 1;
                }
                values[switch - begin][0]
            };
            let mut crossings = Crossings::new(grid, step.resolution(), g);
            if let Some(x) = crossings.find(|x| system.decides(switch, &step.at(*x)))
                && first.is_none_or(|(_, earlier)| x < earlier)
            {
                first = Some((switch, x));
            }
        }
    }
    first
}
