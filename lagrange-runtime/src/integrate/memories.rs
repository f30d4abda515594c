//! Double buffer for the method's state between steps.

#[cfg(feature = "std")]
use crate::lanes::Lanewise;

/// State with which a step begins, and room for that of the one after it. Large ones change places, since the next
/// step would wait for a copy of them. Small ones are copied, and stay in registers: of these the step writes a
/// variable, as a second place in the run would take registers from step to step (a quarter of RK4's time on Kepler's
/// problem).
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct DoubleBuffer<T> {
    places: [T; 2],
    /// Steps begin with the second one.
    turned: bool,
}

impl<T: Clone> DoubleBuffer<T> {
    const LARGE: bool = size_of::<T>() > 128;

    #[inline(always)]
    pub fn new(memory: T) -> Self {
        DoubleBuffer { places: [memory.clone(), memory], turned: false }
    }

    #[inline(always)]
    pub fn now(&self) -> &T {
        &self.places[usize::from(Self::LARGE && self.turned)]
    }

    /// The variable that [`of_step`](Self::of_step) asks for.
    #[inline(always)]
    pub fn variable(&self) -> T {
        self.now().clone()
    }

    /// State with which a step begins, and the place to which it writes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn of_step<'a>(&'a mut self, variable: &'a mut T) -> (&'a T, &'a mut T) {
        let [first, second] = &mut self.places;
        match (Self::LARGE, self.turned) {
            (false, _) => (first, variable),
            (true, false) => (first, second),
            (true, true) => (second, first),
        }
    }

    /// The step was taken.
    #[inline(always)]
    pub fn turn(&mut self, variable: T) {
        if Self::LARGE {
            self.turned = !self.turned;
        } else {
            self.places[0] = variable;
        }
    }
}

#[cfg(feature = "std")]
impl<T: Clone> DoubleBuffer<T> {
    #[inline(always)]
    pub fn now_mut(&mut self) -> &mut T {
        &mut self.places[usize::from(Self::LARGE && self.turned)]
    }

    /// The step was taken in the chosen lanes; the others are where they were.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub fn turn_lanes<const L: usize>(&mut self, chosen: &[bool; L], variable: &T)
    where
        T: Lanewise<L>,
    {
        if !Self::LARGE {
            self.places[0].take(chosen, variable);
            return;
        }
        if chosen.contains(&false) {
            let [first, second] = &mut self.places;
            let (before, after) = if self.turned { (second, first) } else { (first, second) };
            let mut others = [false; L];
            for i in 0..L {
                others[i] = !chosen[i];
            }
            after.take(&others, before);
        }
        self.turned = !self.turned;
    }
}
