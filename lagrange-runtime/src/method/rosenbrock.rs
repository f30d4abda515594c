//! Rosenbrock methods for stiff systems: linearly implicit, no iteration, L-stable, with the emitted Jacobian.
//!
//! In the variables that need no product with the Jacobian (Hairer, Wanner, *Solving Ordinary Differential Equations
//! II*, 1996, IV.7, eq. 7.25), for y = (q, q̇), `f = (q̇, q̈)` and `J = ∂f/∂y`,
//!
//! `(1/(γh) − J) uᵢ = f(t₀ + αᵢh, y₀ + Σⱼ aᵢⱼ uⱼ) + Σⱼ (cᵢⱼ/h) uⱼ + h γᵢ ∂f/∂t`, `y₁ = y₀ + Σᵢ mᵢ uᵢ`.
//!
//! Both pairs here are stiffly accurate: the last stage is the step's end, `y₁ = y₀ + Σⱼ aₛⱼ uⱼ + uₛ`, and its increment
//! uₛ is the error estimate. One real N × N factorization serves all stages.

use super::newton::{Linearized, Resolvent, accelerations, unsolvable};
use super::{Dense, Method, Step};
use crate::failure::Failure;
use crate::scalar::{Numbers, Scalar};
use crate::state::{State, Tangent};
use crate::system::Lagrangian;

/// Coefficients of a method with `K` stages and an interpolant of `D` terms.
trait Tableau<const K: usize, const D: usize> {
    const GAMMA: f64;
    /// `aᵢⱼ`, i > j. The last three rows are equal but for ones.
    const A: [[f64; K]; K];
    /// `cᵢⱼ`, i > j.
    const C: [[f64; K]; K];
    /// `αᵢ`.
    const ALPHA: [f64; K];
    /// `γᵢ`.
    const D: [f64; K];
    /// Of the interpolant.
    const DENSE: [[f64; K]; D];
}

macro_rules! rosenbrock {
    ($(
        $(#[$doc:meta])*
        $name:ident($stages:literal stages, order $order:literal, $terms:literal terms) {
            gamma $gamma:expr; a $a:expr; c $c:expr; alpha $alpha:expr; d $d:expr; dense $dense:expr;
        }
    )*) => {$(
        $(#[$doc])*
        ///
        /// The Jacobian counts as one evaluation. A step whose linear equations are singular fails with
        /// [`Failure::SingularStep`], and a controller then tries a shorter one.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name;

        impl Tableau<$stages, $terms> for $name {
            const GAMMA: f64 = $gamma;
            const A: [[f64; $stages]; $stages] = lower($a);
            const C: [[f64; $stages]; $stages] = lower($c);
            const ALPHA: [f64; $stages] = $alpha;
            const D: [f64; $stages] = $d;
            const DENSE: [[f64; $stages]; $terms] = $dense;
        }

        impl<Sys: Lagrangian<N>, const N: usize> Method<Sys, N> for $name
        where
            Sys::Scalar: Numbers,
        {
            type Memory = ();
            /// The terms of the interpolant.
            type Stages = [Tangent<Sys::Scalar, N>; $terms];
            type Error = Tangent<Sys::Scalar, N>;
            type Dense = Interpolant<Sys::Scalar, N, $terms>;

            fn order(&self) -> u32 {
                $order
            }

            fn implicit(&self) -> bool {
                true
            }

            fn start(&self, system: &Sys, at: &State<Sys::Scalar, N>) -> Result<(), Failure<Sys::Scalar>> {
                accelerations(system, at).map(|_| ())
            }

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn step(
                &self,
                system: &Sys,
                _: &(),
                from: &State<Sys::Scalar, N>,
                h: Sys::Scalar,
                _: &mut (),
            ) -> Result<Step<Sys, Self, N>, Failure<Sys::Scalar>> {
                let (to, error, stages) = step::<$name, Sys, $stages, $terms, N>(system, from, h)?;
                Ok(Step { from: *from, to, h, error, stages, evaluations: $stages + 1 })
            }

            #[inline(always)]
            fn dense(&self, _: &Sys, step: &Step<Sys, Self, N>) -> Self::Dense {
                Interpolant { from: step.from, h: step.h, whole: step.to.minus(&step.from), terms: step.stages }
            }
        }
    )*};
}

/// A square array whose row i begins with the numbers of `rows[i]`, the rest zero.
const fn lower<const K: usize>(rows: [&[f64]; K]) -> [[f64; K]; K] {
    let mut square = [[0.0; K]; K];
    let mut i = 0;
    while i < K {
        let mut j = 0;
        while j < rows[i].len() {
            square[i][j] = rows[i][j];
            j += 1;
        }
        i += 1;
    }
    square
}

rosenbrock! {
    /// Rodas4: order 4 with an embedded one of order 3, six stages, L-stable, γ = 1/4, and an interpolant of order 3
    /// (Hairer and Wanner 1996, IV.7, and the coefficients of their code `RODAS`).
    Rodas4(6 stages, order 4, 2 terms) {
        gamma 0.25;
        a [
            &[],
            &[1.544],
            &[0.9466785280815826, 0.2557011698983284],
            &[3.314825187068521, 2.896124015972201, 0.9986419139977817],
            &[1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895],
            &[1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1.0]
        ];
        c [
            &[],
            &[-5.6688],
            &[-2.430093356833875, -0.2063599157091915],
            &[-0.1073529058151375, -9.594562251023355, -20.47028614809616],
            &[7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616],
            &[8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054]
        ];
        alpha [0.0, 0.386, 0.21, 0.63, 1.0, 1.0];
        d [0.25, -0.1043, 0.1035, -0.03620000000000023, 0.0, 0.0];
        dense [
            [
                10.12623508344586, -7.487995877610167, -34.80091861555747, -7.992771707568823,
                1.025137723295662, 0.0
            ],
            [
                -0.6762803392801253, 6.087714651680015, 16.43084320892478, 24.76722511418386,
                -6.594389125716872, 0.0
            ]
        ];
    }

    /// Rodas5P: order 5 with an embedded one of order 4, eight stages, L-stable, and an interpolant of order 4; made
    /// to keep its order on stiff problems with forces of time (Steinebach, *Construction of Rosenbrock–Wanner method
    /// Rodas5P and numerical benchmarks within the Julia Differential Equations package*, BIT 63, 2023).
    Rodas5P(8 stages, order 5, 3 terms) {
        gamma 0.21193756319429014;
        a [
            &[],
            &[3.0],
            &[2.849394379747939, 0.45842242204463923],
            &[-6.954028509809101, 2.489845061869568, -10.358996098473584],
            &[2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641],
            &[
                -7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
                0.030198172008377946
            ],
            &[
                -7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
                0.030198172008377946, 1.0
            ],
            &[
                -7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256,
                0.030198172008377946, 1.0, 1.0
            ]
        ];
        c [
            &[],
            &[-14.155112264123755],
            &[-17.97296035885952, -2.859693295451294],
            &[147.12150275711716, -1.41221402718213, 71.68940251302358],
            &[165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306],
            &[
                24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125,
                -0.6610691825249471
            ],
            &[
                30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783,
                -19.097331116725623, -28.087943162872662
            ],
            &[
                37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047,
                -40.06618937091002, -54.66780262877968, -9.48861652309627
            ]
        ];
        alpha [
            0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664, 1.0, 1.0, 1.0
        ];
        d [
            0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734,
            2.325825639765069, 0.0, 0.0, 0.0
        ];
        dense [
            [
                25.948786856663858, -2.5579724845846235, 10.433815404888879, -2.3679251022685204,
                0.524948541321073, 1.1241088310450404, 0.4272876194431874, -0.17202221070155493
            ],
            [
                -9.91568850695171, -0.9689944594115154, 3.0438037242978453, -24.495224566215796,
                20.176138334709044, 15.98066361424651, -6.789040303419874, -6.710236069923372
            ],
            [
                11.419903575922262, 2.8879645146136994, 72.92137995996029, 80.12511834622643,
                -52.072871366152654, -59.78993625266729, -0.15582684282751913, 4.883087185713722
            ]
        ];
    }
}

type Outcome<S, const D: usize, const N: usize> =
    Result<(State<S, N>, Tangent<S, N>, [Tangent<S, N>; D]), Failure<S>>;

#[cfg_attr(not(debug_assertions), inline(always))]
fn step<T: Tableau<K, D>, Sys: Lagrangian<N>, const K: usize, const D: usize, const N: usize>(
    system: &Sys,
    from: &State<Sys::Scalar, N>,
    h: Sys::Scalar,
) -> Outcome<Sys::Scalar, D, N>
where
    Sys::Scalar: Numbers,
{
    let number = Sys::Scalar::from_f64;
    let jacobian = Sys::Scalar::evaluate(Linearized { system, at: from });
    let resolvent = Resolvent::new(Sys::Scalar::one() / (h * number(T::GAMMA)), &jacobian)
        .map_err(|singular| unsolvable(system, from, h, &jacobian, singular))?;
    let mut u = [Tangent::zero(); K];
    let mut at = *from;
    for i in 0..K {
        let (mut increment, mut right) = (Tangent::zero(), Tangent::zero());
        for j in 0..i {
            if T::A[i][j] != 0.0 {
                increment = increment.plus_scaled(number(T::A[i][j]), &u[j]);
            }
            right = right.plus_scaled(number(T::C[i][j]) / h, &u[j]);
        }
        at = from.moved(from.t + h * number(T::ALPHA[i]), Sys::Scalar::one(), &increment);
        right.q += at.qd;
        right.qd += system.accel(&at.q, &at.qd, at.t) + jacobian.t * (h * number(T::D[i]));
        u[i] = resolvent.apply(&right);
    }
    let error = u[K - 1];
    let mut terms = [Tangent::zero(); D];
    for (term, row) in terms.iter_mut().zip(T::DENSE) {
        for j in 0..K {
            *term = term.plus_scaled(number(row[j]), &u[j]);
        }
    }
    Ok((at.moved(from.t + h, Sys::Scalar::one(), &error), error, terms))
}

/// `y₀ + θ(y₁ − y₀ + (1 − θ)(d₁ + θ(d₂ + …)))` with `θ = (t − t₀)/h` (Hairer and Wanner 1996, IV.7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interpolant<S, const N: usize, const D: usize> {
    from: State<S, N>,
    h: S,
    whole: Tangent<S, N>,
    terms: [Tangent<S, N>; D],
}

impl<S: Scalar, const N: usize, const D: usize> Dense<S, N> for Interpolant<S, N, D> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn at(&self, t: S) -> State<S, N> {
        let theta = (t - self.from.t) / self.h;
        let mut inner = Tangent::zero();
        for term in self.terms.iter().rev() {
            inner = term.plus_scaled(theta, &inner);
        }
        self.from.moved(t, theta, &self.whole.plus_scaled(S::one() - theta, &inner))
    }
}

#[cfg(test)]
mod tests;
