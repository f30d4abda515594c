//! Systems by their address: what runs many of them by many methods is compiled once for all with as many coordinates
//! and switches.

use lagrange_runtime::traits::{Facts, Jacobian, Lagrangian, Restored, Separable, System};
use lagrange_runtime::{Failure, State};
use nalgebra::{SMatrix, SVector};
use std::rc::Rc;

type V<const N: usize> = SVector<f64, N>;

macro_rules! objects {
    ($($name:ident -> $result:ty;)*) => {
        /// A system, as an object.
        trait Object<const N: usize> {
            fn accel(&self, q: &V<N>, qd: &V<N>, t: f64) -> V<N>;
            fn restored(&self, at: &State<f64, N>) -> Result<Option<Restored<f64, N>>, Failure>;
            fn switches(&self, at: &State<f64, N>, a: &V<N>, each: &mut dyn FnMut(usize, [f64; 2]));
            fn explained(&self, start: &State<f64, N>, last: &State<f64, N>, failure: Failure) -> Failure;
            fn resolved(&self, start: &State<f64, N>, at: &State<f64, N>) -> Result<(), Failure>;
            $(fn $name(&self, q: &V<N>, qd: &V<N>, t: f64) -> $result;)*
        }

        impl<Sys: Lagrangian<N, Scalar = f64>, const N: usize> Object<N> for Sys {
            fn accel(&self, q: &V<N>, qd: &V<N>, t: f64) -> V<N> {
                System::accel(self, q, qd, t)
            }
            fn restored(&self, at: &State<f64, N>) -> Result<Option<Restored<f64, N>>, Failure> {
                System::restored(self, at)
            }
            fn switches(&self, at: &State<f64, N>, a: &V<N>, each: &mut dyn FnMut(usize, [f64; 2])) {
                System::switches(self, at, a, each);
            }
            fn explained(&self, start: &State<f64, N>, last: &State<f64, N>, failure: Failure) -> Failure {
                System::explained(self, start, last, failure)
            }
            fn resolved(&self, start: &State<f64, N>, at: &State<f64, N>) -> Result<(), Failure> {
                System::resolved(self, start, at)
            }
            $(fn $name(&self, q: &V<N>, qd: &V<N>, t: f64) -> $result {
                Lagrangian::$name(self, q, qd, t)
            })*
        }

        impl<const N: usize, const SWITCHES: usize, const AUTONOMOUS: bool> Lagrangian<N>
            for Any<N, SWITCHES, AUTONOMOUS>
        {
            const FACTS: Facts = Facts::UNKNOWN;
            $(fn $name(&self, q: &V<N>, qd: &V<N>, t: f64) -> $result {
                self.0.$name(q, qd, t)
            })*
        }
    };
}

objects! {
    lagrangian -> f64;
    momenta -> V<N>;
    energy_function -> f64;
    inertia -> SMatrix<f64, N, N>;
    convective_momentum_rate -> V<N>;
    momentum_rate -> V<N>;
    dissipation -> f64;
    power -> f64;
    jacobian -> Jacobian<f64, N>;
}

/// A system with so many coordinates and switches.
#[derive(Clone)]
pub struct Any<const N: usize, const SWITCHES: usize, const AUTONOMOUS: bool = true>(Rc<dyn Object<N>>);

impl<const N: usize, const SWITCHES: usize, const AUTONOMOUS: bool> Any<N, SWITCHES, AUTONOMOUS> {
    pub fn new<Sys: Lagrangian<N, Scalar = f64> + 'static>(system: Sys) -> Self {
        const { assert!(Sys::SWITCHES == SWITCHES && Sys::AUTONOMOUS == AUTONOMOUS && Sys::ATTITUDES.is_empty()) }
        Any(Rc::new(system))
    }
}

/// Nobody asks here whether it is.
impl<const N: usize, const SWITCHES: usize, const AUTONOMOUS: bool> Separable<N>
    for Any<N, SWITCHES, AUTONOMOUS>
{
}

impl<const N: usize, const SWITCHES: usize, const AUTONOMOUS: bool> System<N>
    for Any<N, SWITCHES, AUTONOMOUS>
{
    type Scalar = f64;
    const SWITCHES: usize = SWITCHES;
    const AUTONOMOUS: bool = AUTONOMOUS;

    fn accel(&self, q: &V<N>, qd: &V<N>, t: f64) -> V<N> {
        self.0.accel(q, qd, t)
    }
    fn restored(&self, at: &State<f64, N>) -> Result<Option<Restored<f64, N>>, Failure> {
        self.0.restored(at)
    }
    fn switches(&self, at: &State<f64, N>, a: &V<N>, mut each: impl FnMut(usize, [f64; 2])) {
        self.0.switches(at, a, &mut each);
    }
    fn explained(&self, start: &State<f64, N>, last: &State<f64, N>, failure: Failure) -> Failure {
        self.0.explained(start, last, failure)
    }
    fn resolved(&self, start: &State<f64, N>, at: &State<f64, N>) -> Result<(), Failure> {
        self.0.resolved(start, at)
    }
}
