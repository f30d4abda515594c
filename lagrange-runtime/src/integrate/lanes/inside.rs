//! The motion within the step of one lane.

use crate::event::search::Within;
use crate::failure::Failure;
use crate::lanes::Motion;
use crate::state::State;

/// Step of one lane, as its observer sees it.
pub struct Inside<'a, const N: usize> {
    pub ends: [State<f64, N>; 2],
    pub h: f64,
    pub parts: u32,
    pub between: &'a dyn Fn(f64) -> State<f64, N>,
    pub stepped: &'a dyn Fn(f64) -> Result<State<f64, N>, Failure>,
}

impl<const N: usize> Within<f64, N> for Inside<'_, N> {
    fn parts(&self) -> u32 {
        self.parts
    }

    fn ends(&self) -> [State<f64, N>; 2] {
        self.ends
    }

    fn size(&self) -> f64 {
        self.h
    }

    fn between(&self, x: f64) -> State<f64, N> {
        (self.between)(x)
    }
}

impl<const N: usize> Motion<N> for Inside<'_, N> {
    fn stepped(&self, x: f64) -> Result<State<f64, N>, Failure> {
        (self.stepped)(x)
    }
}
