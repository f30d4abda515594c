//! The methods, ours and theirs, as functions of one kind.

use differential_equations::prelude::{
    ControlFlag, ExplicitRungeKutta, IVP, Interpolation, ODE, Solout, Solution,
};
use lagrange_runtime::prelude::{Dop853, DormandPrince5, PiController, Verner9, integrate};
use lagrange_runtime::{SVector, State, System};
use ode_solvers::OutputType;

/// The state at the end of a run from `start`, with the absolute and relative tolerance given last.
pub type Run<Sys, const N: usize> = fn(&Sys, State<f64, N>, f64, f64) -> State<f64, N>;

/// For coarse and for fine tolerances.
#[derive(Clone, Copy, PartialEq)]
pub enum Class {
    Order5,
    Order8And9,
}

pub struct Contestant<Sys, const N: usize> {
    pub name: &'static str,
    pub ours: bool,
    /// Class within which contestants are compared.
    pub class: Class,
    pub run: Run<Sys, N>,
}

/// Accelerations as a system of first order, `y = (q, q̇)`.
struct FirstOrder<'a, Sys, const N: usize>(&'a Sys);

impl<Sys: System<N, Scalar = f64>, const N: usize> FirstOrder<'_, Sys, N> {
    #[inline(always)]
    fn derivative(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        let q = SVector::from_fn(|i, _| y[i]);
        let qd = SVector::from_fn(|i, _| y[N + i]);
        let qdd = self.0.accel(&q, &qd, t);
        for i in 0..N {
            (dy[i], dy[N + i]) = (qd[i], qdd[i]);
        }
    }
}

impl<Sys: System<N, Scalar = f64>, const N: usize, const D: usize> ODE<f64, [f64; D]>
    for FirstOrder<'_, Sys, N>
{
    #[inline]
    fn diff(&self, t: f64, y: &[f64; D], dy: &mut [f64; D]) {
        self.derivative(t, y, dy);
    }
}

impl<Sys: System<N, Scalar = f64>, const N: usize, const D: usize>
    ode_solvers::System<f64, ode_solvers::SVector<f64, D>> for FirstOrder<'_, Sys, N>
{
    #[inline]
    fn system(&self, t: f64, y: &ode_solvers::SVector<f64, D>, dy: &mut ode_solvers::SVector<f64, D>) {
        self.derivative(t, y.as_slice(), dy.as_mut_slice());
    }
}

fn flat<const N: usize, const D: usize>(state: &State<f64, N>) -> [f64; D] {
    std::array::from_fn(|i| if i < N { state.q[i] } else { state.qd[i - N] })
}

fn state<const N: usize>(t: f64, y: &[f64]) -> State<f64, N> {
    State::new(t, std::array::from_fn(|i| y[i]), std::array::from_fn(|i| y[N + i]))
}

/// Keeps the last state of a run of `differential-equations` and nothing else.
struct Last<'a, const D: usize>(&'a mut [f64; D]);

impl<const D: usize> Solout<f64, [f64; D]> for Last<'_, D> {
    #[inline]
    fn solout<I: Interpolation<f64, [f64; D]> + ?Sized>(
        &mut self,
        _: f64,
        _: f64,
        y: &[f64; D],
        _: &[f64; D],
        _: &mut I,
        _: &mut Solution<f64, [f64; D]>,
    ) -> ControlFlag<f64, [f64; D]> {
        *self.0 = *y;
        ControlFlag::Continue
    }
}

/// The contestants. `D` is 2N.
pub fn contestants<Sys: System<N, Scalar = f64>, const N: usize, const D: usize>() -> Vec<Contestant<Sys, N>>
{
    macro_rules! ours {
        ($name:literal, $class:ident, $method:expr) => {
            Contestant {
                name: $name,
                ours: true,
                class: Class::$class,
                run: |system: &Sys, start: State<f64, N>, end: f64, tolerance: f64| {
                    let run = integrate(system, $method, PiController::tolerance(tolerance), start).until(end);
                    run.final_state().unwrap_or_else(|failed| panic!("{failed}"))
                },
            }
        };
    }
    macro_rules! differential_equations {
        ($class:ident, $method:ident) => {
            Contestant {
                name: concat!("differential-equations ", stringify!($method)),
                ours: false,
                class: Class::$class,
                run: |system: &Sys, start: State<f64, N>, end: f64, tolerance: f64| {
                    let method = ExplicitRungeKutta::$method().rtol(tolerance).atol(tolerance);
                    let y = flat::<N, D>(&start);
                    let mut last = y;
                    IVP::ode(&FirstOrder::<_, N>(system), start.t, end, y)
                        .method(method.max_steps(1_000_000))
                        .solout(Last(&mut last))
                        .solve()
                        .unwrap_or_else(|error| panic!("{error:?}"));
                    state(end, &last)
                },
            }
        };
    }
    macro_rules! ode_solvers {
        ($class:ident, $method:ident) => {
            Contestant {
                name: concat!("ode_solvers ", stringify!($method)),
                ours: false,
                class: Class::$class,
                run: |system: &Sys, start: State<f64, N>, end: f64, tolerance: f64| {
                    let y = ode_solvers::SVector::from(flat::<N, D>(&start));
                    let system = FirstOrder::<_, N>(system);
                    let mut run = ode_solvers::$method::new(
                        system,
                        start.t,
                        end,
                        end - start.t,
                        y,
                        tolerance,
                        tolerance,
                    );
                    // Its dense output ends at a wrong time.
                    run.set_output(OutputType::Sparse);
                    run.integrate().unwrap_or_else(|error| panic!("{error}"));
                    state(end, run.y_out().last().expect("a state").as_slice())
                },
            }
        };
    }
    vec![
        ours!("DOP853", Order8And9, Dop853),
        ours!("Verner9", Order8And9, Verner9),
        differential_equations!(Order8And9, dop853),
        differential_equations!(Order8And9, rkv878e),
        differential_equations!(Order8And9, rkv988e),
        ode_solvers!(Order8And9, Dop853),
        ours!("DP5", Order5, DormandPrince5),
        differential_equations!(Order5, dopri5),
        ode_solvers!(Order5, Dopri5),
    ]
}
