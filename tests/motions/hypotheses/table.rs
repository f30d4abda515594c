//! Each function of `analysis`, and quadratures, where each hypothesis is violated alone: what is seen is the table
//! of docs/lab/reliability.md. What is right is right against a closed form, or by another route.

use crate::printed::{Cell, Table};
use crate::systems::{
    Cartesian, Dragged, Follower, Gust, Nearly, Notched, Orbit, Pair, Plain, Polar, Pulsed, Resonant, Round,
    Rubbing, Swing, Tied, Top, VanDerPol, Vee,
};
use crate::{Cubic, Driven, Hoop, Pushed, Shaken};
use lagrange_runtime::analysis::*;
use lagrange_runtime::prelude::*;
use lagrange_runtime::{DoubleDouble, Gradient, traits::Linearize};
use std::fmt::Debug;

const NO_STEPS: Cell = Cell::None("it takes no steps");
const MATRICES: Cell =
    Cell::None("it takes matrices, which are constant; those of a system are refused where they are made");
const TYPE: Cell = Cell::None("its type says `f64`, and rustc rejects another scalar");
const BY_TOLERANCE: Cell =
    Cell::None("a tolerance chooses the steps; those of one size over switches are `Unsuitable`");

fn variant(name: &str) -> String {
    format!("`{name}`")
}

/// The error, or "right" if it is.
fn right<T: Debug>(result: Result<T, AnalysisError>, is: impl FnOnce(&T) -> bool) -> Cell {
    Cell::Seen(match result {
        Ok(found) if is(&found) => "right".into(),
        Ok(found) => format!("wrong: {:.300}", format!("{found:?}")),
        Err(AnalysisError::Run(failure)) => variant(failure.name()),
        Err(error) => variant(error.name()),
    })
}

/// The verdict on stability, or the error.
fn verdict(result: Result<Stability, AnalysisError>) -> Cell {
    Cell::Seen(match result {
        Ok(stability) => variant(format!("{stability:?}").split([' ', '(', '{']).next().unwrap()),
        Err(error) => variant(error.name()),
    })
}

/// A cell of several cases of one violation, in which a common outcome stands once.
fn both(cells: [Cell; 2]) -> Cell {
    let seen: Vec<String> = cells
        .into_iter()
        .map(|cell| match cell {
            Cell::Seen(seen) => seen,
            Cell::None(_) => panic!("no case"),
        })
        .collect();
    Cell::Seen(if seen[0] == seen[1] { seen[0].clone() } else { seen.join(", ") })
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * (1.0 + b.abs())
}

/// `equilibrium`, with which `small_vibrations` and `equilibria` agree, and its place.
fn at_rest<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    guess: [f64; N],
    is: impl FnOnce(&[f64]) -> bool,
) -> [Cell; 3] {
    let found = equilibrium(system, &guess);
    let place = found.as_ref().is_ok_and(|found| is(found.q.as_slice())) || found.is_err();
    let at = found.as_ref().map_or(guess, |found| found.q.into());
    let small = small_vibrations(system, &at);
    if let (Ok(found), Ok(small)) = (&found, &small) {
        assert!((found.small.stiffness() - small.stiffness()).amax() <= 1e-9 * small.stiffness().amax());
    }
    let all = equilibria(system, &at.map(|x| x - 1e-3), &at.map(|x| x + 1e-3), 4);
    // A start from which none is reached is left out.
    let counted = match &all {
        Ok(all) if all.is_empty() => Cell::Seen("left out".into()),
        _ => right(all, |all| !all.is_empty()),
    };
    [verdict(found.map(|found| found.stability)), right(small, |_| place), counted]
}

fn equilibria_of_all(table: &mut Table) {
    let anywhere = |_: &[f64]| true;
    let origin = |q: &[f64]| q.iter().all(|x| x.abs() < 1e-12);
    let pushed = at_rest(&Pair::new(1e12, 1.0), [0.3, 0.3], anywhere);
    let stiff = at_rest(&Plain::new(1e12, 1.0, 0.1, 0.0, 0.0), [0.1, 0.1], origin);
    let cases = [
        at_rest(&Pulsed::default(), [0.1], anywhere),
        at_rest(&Plain::new(1.0, 2.0, -0.1, 0.0, 0.0), [0.1, 0.1], origin),
        at_rest(&Follower::new(0.7), [0.1, 0.1], origin),
        at_rest(&Plain::new(-1.0, -1.0, 0.0, 3.0, 0.0), [0.1, 0.1], origin),
        at_rest(&Vee::new(), [0.0], anywhere),
        at_rest(&Cartesian::default(), [0.0, -1.0], |q| near(q[0], 0.0) && near(q[1], -1.0)),
        at_rest(&Polar::new(1.0), [0.0, 0.3], anywhere),
        at_rest(&Dragged::new(1.0, 1.0), [0.1], origin),
        at_rest(&Resonant::new(0.3), [0.1], anywhere),
        at_rest(&Round::new(1.0), [0.8, 0.5], |q| near(q[0].hypot(q[1]), 1.0)),
        at_rest(&Nearly::new(0.0, 1e-9, 1.0), [-0.01, 0.1], |q| (q[0] + 1e-3).abs() < 1e-15),
    ];
    let mut rows = cases.map(|cells| cells.map(Some));
    let mut stiff: Vec<Option<Cell>> =
        stiff.into_iter().zip(pushed).map(|(a, b)| Some(both([a, b]))).collect();
    let late = at_rest(&Gust::default(), [0.1], anywhere).map(|cell| cell);
    let mut late: Vec<Option<Cell>> = late.into_iter().map(Some).collect();
    let names = ["`equilibrium`", "`small_vibrations`", "`equilibria`"];
    for (k, name) in names.into_iter().enumerate() {
        let [a, b, c, d, e, f, g, h, i, j, l] = rows.each_mut().map(|cells| cells[k].take().unwrap());
        let (stiff, late) = (stiff[k].take().unwrap(), late[k].take().unwrap());
        table.row(name, [a, b, c, d, e, f, g, h, i, j, l, stiff, NO_STEPS, late, TYPE, TYPE]);
    }
}

/// Small motions about a state, by `steady` and by `about`: K is that of the system.
fn about<Sys: Linearize<N, Scalar = f64>, const N: usize>(
    system: &Sys,
    at: [f64; N],
    stiffness: f64,
) -> [Cell; 2] {
    let at = State::new(0.0, at, [0.0; N]);
    let right = |small| right(small, |small: &SmallMotion| near(small.stiffness()[(0, 0)], stiffness));
    [right(SmallMotion::steady(system, &at)), right(SmallMotion::about(system, &at))]
}

fn small_motions(table: &mut Table) {
    let mut cases = [
        about(&Pulsed::default(), [0.0], 1.0),
        about(&Plain::new(1.0, 2.0, -0.1, 0.0, 0.0), [0.0; 2], 1.0),
        about(&Follower::new(0.7), [0.0; 2], 1.0),
        about(&Plain::new(-1.0, -1.0, 0.0, 3.0, 0.0), [0.0; 2], -1.0),
        about(&Vee::new(), [0.0], 0.0),
        about(&Cartesian::default(), [0.0, -1.0], 9.81),
        about(&Polar::new(1.0), [0.0; 2], 1.0),
        about(&Dragged::new(1.0, 1.0), [0.0], 1.0),
        about(&Resonant::new(0.3), [0.0], 1.0),
        about(&Round::new(1.0), [1.0, 0.0], 2.0),
        about(&Nearly::new(-1.0, 0.0, 1.0), [0.0; 2], 1.0),
        about(&Plain::new(1e12, 1.0, 0.1, 0.0, 0.0), [0.0; 2], 1e12),
        about(&Gust::default(), [0.0], 1.0),
    ]
    .map(|cells| cells.map(Some));
    for (k, name) in ["`SmallMotion::steady`", "`SmallMotion::about`"].into_iter().enumerate() {
        let [a, b, c, d, e, f, g, h, i, j, l, m, late] =
            cases.each_mut().map(|cells| cells[k].take().unwrap());
        table.row(name, [a, b, c, d, e, f, g, h, i, j, l, m, NO_STEPS, late, TYPE, TYPE]);
    }
}

fn square(rows: [[f64; 2]; 2]) -> DMatrix<f64> {
    DMatrix::from_fn(2, 2, |i, j| rows[i][j])
}

/// M = 1, C = c + g (0, 1; −1, 0), K = diag(k) + p (0, 1; −1, 0).
fn matrices(k: [f64; 2], c: f64, g: f64, p: f64) -> SmallMotion {
    SmallMotion::new(DMatrix::identity(2, 2), square([[c, g], [-g, c]]), square([[k[0], p], [-p, k[1]]]))
        .unwrap()
}

/// Residual of `(λ² M + λ C + K) x = 0`, and the sum and the product of all roots, −tr C and det K.
fn spectrum_is_right(small: &SmallMotion) -> bool {
    let spectrum = small.spectrum().unwrap();
    let complex = |a: &DMatrix<f64>| a.map(|x| Complex::new(x, 0.0));
    let [m, c, k] = [small.inertia(), small.velocity_terms(), small.stiffness()].map(complex);
    let solved = spectrum.eigenvalues.iter().zip(&spectrum.shapes).all(|(value, x)| {
        let rest = (&m * (value * value) + &c * *value + &k) * x;
        let size = m.camax() * value.norm_sqr() + c.camax() * value.norm() + k.camax();
        rest.camax() <= 1e-13 * size * x.camax()
    });
    let sum: Complex<f64> = spectrum.eigenvalues.iter().sum();
    let product: Complex<f64> = spectrum.eigenvalues.iter().product();
    let size = spectrum.eigenvalues.iter().map(|x| x.norm()).sum::<f64>();
    solved
        && (sum.re + small.velocity_terms().trace()).abs() <= 1e-13 * size
        && (product.re / small.stiffness().determinant() - 1.0).abs() < 1e-12
}

fn of_matrices(table: &mut Table) {
    let cases = [
        matrices([1.0, 2.0], -0.1, 0.0, 0.0),
        matrices([1.0, 2.0], 0.0, 0.0, 0.7),
        matrices([-1.0, -1.0], 0.0, 3.0, 0.0),
        matrices([1.0, 1.0], 0.1, 0.0, 0.0),
        matrices([1.0, 1.0 + 1e-9], 0.1, 0.0, 0.0),
        matrices([1e12, 1.0], 0.1, 0.0, 0.0),
    ];
    let mut add = |name, of: &dyn Fn(&SmallMotion) -> Cell| {
        let [negative, circulatory, gyroscopic, symmetric, imperfect, stiff] = cases.each_ref().map(of);
        let indefinite = SmallMotion::new(
            square([[1.0, 1.0], [1.0, 1.0]]),
            square([[0.0; 2]; 2]),
            square([[1.0, 0.0], [0.0, 1.0]]),
        );
        table.row(
            name,
            [
                MATRICES,
                negative,
                circulatory,
                gyroscopic,
                MATRICES,
                MATRICES,
                right(indefinite, |_| false),
                MATRICES,
                MATRICES,
                symmetric,
                imperfect,
                stiff,
                NO_STEPS,
                MATRICES,
                TYPE,
                TYPE,
            ],
        );
    };
    add("`SmallMotion::energy_criterion`", &|small| verdict(small.energy_criterion()));
    add("`SmallMotion::first_approximation`", &|small| verdict(small.first_approximation()));
    add("`SmallMotion::spectrum`", &|small| {
        right(small.spectrum().map(|_| ()), |()| spectrum_is_right(small))
    });
    add("`SmallMotion::modes`", &|small| {
        right(small.modes(), |modes| {
            let k = small.stiffness().diagonal();
            [k.min(), k.max()]
                .iter()
                .zip(modes.squares())
                .all(|(exact, found)| (found / exact - 1.0).abs() < 1e-15)
        })
    });
    add("`SmallMotion::frequency_response`", &|small| {
        let force = DVector::from_vec(vec![Complex::new(1.0, 0.0), Complex::new(0.3, 0.0)]);
        let omega = 1.7;
        right(small.frequency_response(omega, &force), |x| {
            let complex = |a: &DMatrix<f64>, by: Complex<f64>| a.map(|x| by * x);
            let dynamic = complex(small.inertia(), Complex::new(-omega * omega, 0.0))
                + complex(small.velocity_terms(), Complex::new(0.0, omega))
                + complex(small.stiffness(), Complex::new(1.0, 0.0));
            (&dynamic * x - &force).camax() <= 1e-14 * dynamic.camax() * x.camax()
        })
    });
    // Where λ² + c λ + k first grows, k = 0 or c = 0; circulatory forces p beside k = 1, 2 at p = ½.
    let threshold = |of: &dyn Fn(f64) -> SmallMotion, [low, high]: [f64; 2], exact: f64| {
        right(stability_threshold(|x| Ok(of(x)), low, high), |x| (x - exact).abs() < 1e-12)
    };
    table.row(
        "`stability_threshold`",
        [
            MATRICES,
            threshold(&|x| matrices([1.0, 2.0], x, 0.0, 0.0), [-0.3, 0.1], 0.0),
            threshold(&|x| matrices([1.0, 2.0], 0.0, 0.0, x), [0.1, 0.9], 0.5),
            threshold(&|x| matrices([-1.0, -1.0], 0.0, x, 0.0), [1.0, 3.0], 2.0),
            MATRICES,
            MATRICES,
            right(
                stability_threshold(
                    |_| {
                        SmallMotion::new(
                            square([[0.0; 2]; 2]),
                            square([[0.0; 2]; 2]),
                            square([[1.0, 0.0], [0.0, 1.0]]),
                        )
                    },
                    0.0,
                    1.0,
                ),
                |_| false,
            ),
            MATRICES,
            MATRICES,
            threshold(&|x| matrices([x, x], 0.1, 0.0, 0.0), [-0.3, 0.1], 0.0),
            threshold(&|x| matrices([x, x - 1e-9], 0.1, 0.0, 0.0), [-0.3, 0.1], 1e-9),
            threshold(&|x| matrices([1e12, x], 0.1, 0.0, 0.0), [-0.3, 0.1], 0.0),
            NO_STEPS,
            MATRICES,
            TYPE,
            TYPE,
        ],
    );
}

const PATH: Path = Path { range: (-1.0, 1.0), step: 0.07, steps: 10_000 };

/// The bifurcations of the curve from the parameter −0.9 on: their kinds and places, and stability of the last point.
fn curve<Sys: Linearize<N, Scalar = Dual<f64>>, const N: usize>(
    family: impl Fn(Dual<f64>) -> Sys,
    guess: [f64; N],
    path: &Path,
    expected: &[(BifurcationKind, f64)],
) -> Cell {
    let found = follow(&family, &guess, -0.9, &Heading::Up, path);
    right(found, |branch| {
        let found: Vec<_> = branch.bifurcations.iter().map(|b| (b.kind, b.parameter)).collect();
        let met = found.iter().zip(expected).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-9);
        branch.complete && met && found.len() == expected.len()
    })
}

fn curves(table: &mut Table) {
    use BifurcationKind::{Flutter, Multiple, Pitchfork};
    let d = Dual::constant;
    let plain = Plain::new(1.0, 2.0, 0.0, 0.0, 0.0).map(d);
    let nearly = |e: f64, k: f64| move |mu| Nearly { mu, e: d(e), k: d(k) };
    table.row(
        "`follow`",
        [
            curve(|_| Pulsed::default().map(d), [0.0], &PATH, &[]),
            curve(|mu| VanDerPol { mu }, [0.0], &PATH, &[(Flutter, 0.0)]),
            curve(|p| Follower { p }, [0.0; 2], &PATH, &[(Flutter, -0.5), (Flutter, 0.5)]),
            // x = y = 0 is stable by gyroscopic forces beside two falling potentials, while g² > 4.
            curve(
                |mu| Plain { k: d(-1.0), l: d(-1.0), g: mu + d(2.1), ..plain },
                [0.0; 2],
                &PATH,
                &[(Flutter, -0.1)],
            ),
            curve(|_| Vee::new().map(d), [0.0], &PATH, &[]),
            curve(|_| Cartesian::default().map(d), [0.0, -1.0], &PATH, &[]),
            curve(|k| Polar { k: k * k + d(1.0) }, [0.0; 2], &PATH, &[]),
            curve(|c| Dragged { k: d(1.0), c }, [0.1], &PATH, &[]),
            curve(|f| Resonant { f }, [0.0], &PATH, &[]),
            curve(|mu| Round { mu }, [0.0; 2], &PATH, &[(Multiple, 0.0)]),
            both([
                curve(nearly(1e-9, 1.0), [0.0; 2], &PATH, &[]),
                // Within rounding of the forces it is none.
                curve(nearly(1e-16, 1.0), [0.0; 2], &PATH, &[(Pitchfork, 0.0)]),
            ]),
            both([
                curve(nearly(0.0, 1e12), [0.0; 2], &PATH, &[(Pitchfork, 0.0)]),
                curve(|k| Pair { k: (k + d(2.0)) * d(1e12), f: d(1.0) }, [0.0; 2], &PATH, &[]),
            ]),
            curve(nearly(0.0, 1.0), [0.0; 2], &Path { step: 0.9, ..PATH }, &[(Pitchfork, 0.0)]),
            curve(|_| Gust::default().map(d), [0.0], &PATH, &[]),
            TYPE,
            TYPE,
        ],
    );
}

/// The steady motion of a bead about θ = 1, and what vanishes then.
fn steady<Sys: Linearize<2, Scalar = f64>>(system: &Sys, momentum: f64) -> Cell {
    let found = Reduced::new(system, &[momentum]).and_then(|reduced| reduced.steady(&[1.0, 0.0]));
    right(found, |steady| {
        let left = system.accel(&steady.at.q, &steady.at.qd, 0.0)[0].abs();
        left < 1e-12 * (1.0 + steady.small.stiffness().amax())
    })
}

fn rates<Sys: Linearize<2, Scalar = f64>>(system: &Sys) -> Cell {
    let reduced = Reduced::new(system, &[1.0]);
    right(reduced.and_then(|reduced| reduced.steady_rates(&[1.0, 0.0], 1)), |all| {
        !all.is_empty() && all.iter().all(|s| system.accel(&s.at.q, &s.at.qd, 0.0)[0].abs() < 1e-12)
    })
}

fn potential<Sys: Linearize<2, Scalar = f64>>(system: &Sys, exact: f64) -> Cell {
    let reduced = Reduced::new(system, &[1.0]);
    right(reduced.and_then(|reduced| reduced.potential(&[1.0, 0.0])), |v| near(*v, exact))
}

fn steady_motions(table: &mut Table) {
    use crate::{Damped, Square};
    let driven = Driven::new(9.81, 0.3, 0.7);
    let falling = Damped::new(9.81, 0.3, -0.7);
    let pushed = Pushed::new(9.81, 0.3, 0.7);
    let cubic = Cubic::new(9.81, 0.3, 0.7);
    let square = Square::new(9.81, 0.3, 0.2);
    let notched = Notched::new(9.81, 0.3);
    let stiff = Hoop::new(1e12, 0.3, 0.0);
    let of_hoop = |g: f64| 0.5 / (0.3 + 1f64.sin().powi(2)) - g * 1f64.cos();
    let string = Tied::new(9.81);
    let tied = || Reduced::new(&string, &[1.0]).unwrap();
    let tied_at = [0.6, -0.8, 0.0];
    let top = Top::new(0.5, 9.81, 0.1, 0.01, 0.005);
    let pole = |of: &dyn Fn(&Reduced<Top, 3>) -> Result<(), AnalysisError>| {
        right(Reduced::new(&top, &[0.1, 0.1]).and_then(|reduced| of(&reduced)), |()| false)
    };
    let at = [0.0; 3];
    let gyro = || {
        Cell::None(
            "rates and momenta of ignorable coordinates are gyroscopic forces: the other cells have them",
        )
    };
    let circle = || Cell::None("ignorable coordinates are the symmetry: the other cells have it");
    let exact = || Cell::None("equations are solved as they are, a symmetry is not used");
    table.row(
        "`Reduced::potential`, `slope`, `turning_points`",
        [
            potential(&driven, of_hoop(9.81)),
            potential(&falling, of_hoop(9.81)),
            potential(&pushed, of_hoop(9.81)),
            gyro(),
            potential(&notched, of_hoop(9.81)),
            both([
                right(tied().potential(&tied_at), |v| near(*v, 0.5 / 0.36 - 9.81 * 0.8)),
                right(tied().slope(&tied_at), |_| false),
            ]),
            pole(&|reduced| reduced.potential(&at).map(|_| ())),
            potential(&cubic, of_hoop(9.81)),
            potential(&driven, of_hoop(9.81)),
            circle(),
            exact(),
            potential(&stiff, of_hoop(1e12)),
            NO_STEPS,
            potential(&driven, of_hoop(9.81)),
            TYPE,
            TYPE,
        ],
    );
    table.row(
        "`Reduced::steady`",
        [
            steady(&driven, 3.0),
            steady(&falling, 3.0),
            steady(&pushed, 3.0),
            gyro(),
            // g sin θ = p² sin θ cos θ/(I + sin²θ)² at θ = 1, where the kink is.
            steady(&notched, (9.81 / 1f64.cos()).sqrt() * (0.3 + 1f64.sin().powi(2))),
            // g r⁴ = p² cos θ on the string.
            right(tied().steady(&tied_at), |steady| near(9.81 * steady.at.q[0].powi(4), -steady.at.q[1])),
            pole(&|reduced| reduced.steady(&at).map(|_| ())),
            steady(&cubic, 3.0),
            steady(&driven, 3.0),
            circle(),
            exact(),
            steady(&stiff, 2e6),
            NO_STEPS,
            steady(&driven, 3.0),
            TYPE,
            TYPE,
        ],
    );
    table.row(
        "`Reduced::steady_rates`, `thresholds`",
        [
            rates(&driven),
            rates(&falling),
            rates(&pushed),
            gyro(),
            rates(&notched),
            right(tied().steady_rates(&tied_at, 2), |_| false),
            pole(&|reduced| reduced.steady_rates(&at, 0).map(|_| ())),
            both([rates(&cubic), rates(&square)]),
            rates(&driven),
            circle(),
            exact(),
            rates(&stiff),
            NO_STEPS,
            rates(&driven),
            TYPE,
            TYPE,
        ],
    );
}

/// The fundamental matrix of a system of one coordinate by each flow.
macro_rules! flows {
    ($system:expr, $start:expr, $duration:expr, $exact:expr) => {{
        let (system, start, exact) = ($system, $start, DMatrix::from_row_slice(2, 2, &$exact));
        let by_gradients = ByGradients::new(system.map(Gradient::<_, 2>::constant), 1e-13);
        let is = |found: &(State<f64, 1>, DMatrix<f64>)| {
            (&found.1 - &exact).amax() <= 1e-9 * exact.amax().max(1.0)
        };
        [
            right(
                fundamental_matrix(&ByVariationalEquations::<_, 3>::new(&system, 1e-12), &start, $duration),
                is,
            ),
            right(fundamental_matrix(&by_gradients, &start, $duration), is),
        ]
    }};
}

/// The same of two coordinates: both ways agree; of a linear system they do with its motions from each unit vector.
macro_rules! flows_of_two {
    ($system:expr, $start:expr, $duration:expr) => {{
        let (system, start) = ($system, $start);
        let by_equations =
            fundamental_matrix(&ByVariationalEquations::<_, 10>::new(&system, 1e-12), &start, $duration);
        let by_gradients = ByGradients::new(system.map(Gradient::<_, 4>::constant), 1e-13);
        let by_gradients = fundamental_matrix(&by_gradients, &start, $duration);
        let other =
            [&by_gradients, &by_equations].map(|found| found.clone().map_or(DMatrix::zeros(4, 4), |x| x.1));
        let close = |a: &DMatrix<f64>, b: &DMatrix<f64>| (a - b).amax() <= 1e-8 * b.amax();
        let cells = [
            right(by_equations, |found| close(&found.1, &other[0])),
            right(by_gradients, |found| close(&found.1, &other[1])),
        ];
        cells
    }};
}

/// `exp(A t)` of `ẍ + c ẋ + k x = 0`.
fn exponential(k: f64, c: f64, t: f64) -> [f64; 4] {
    let (a, w) = (-0.5 * c, (k - 0.25 * c * c).sqrt());
    let (sin, cos) = (w * t).sin_cos();
    [cos - a / w * sin, sin / w, -k / w * sin, cos + a / w * sin].map(|x| x * (a * t).exp())
}

/// Flows of linear motions by the whole matrix; derivatives of the motion along a string of length 1 are those by its
/// angle.
fn tied_flows() -> [Cell; 2] {
    let system = Cartesian::default();
    let (sin, cos) = 0.7f64.sin_cos();
    let start = State::new(0.0, [sin, -cos], [0.0; 2]);
    let angle = crate::systems::Pendulum::new(1.0, 9.81);
    let by_angle = ByVariationalEquations::<_, 3>::new(&angle, 1e-12);
    let (end, exact) = fundamental_matrix(&by_angle, &State::new(0.0, [0.7], [0.0]), 1.3).unwrap();
    // δ(x, y) = (cos θ, sin θ) δθ at both ends, at rest at the first.
    let is = |found: &(State<f64, 2>, DMatrix<f64>)| {
        let moved = &found.1 * DVector::from_vec(vec![cos, sin, 0.0, 0.0]);
        let (sin, cos) = end.q[0].sin_cos();
        (moved[0] - cos * exact[(0, 0)]).abs() < 1e-8 && (moved[1] - sin * exact[(0, 0)]).abs() < 1e-8
    };
    let by_gradients = ByGradients::new(system.map(Gradient::<_, 4>::constant), 1e-13);
    [
        right(fundamental_matrix(&ByVariationalEquations::<_, 10>::new(&system, 1e-12), &start, 1.3), is),
        right(fundamental_matrix(&by_gradients, &start, 1.3), is),
    ]
}

fn derivatives(table: &mut Table) {
    let at = |x: f64, v: f64| State::new(0.0, [x], [v]);
    let pulsed = flows!(Pulsed::default(), at(0.3, 0.0), 12.0, exponential(1.0, 0.0, 12.0));
    let negative = flows!(Swing::new(1.0, -0.1), at(0.3, 0.0), 5.0, exponential(1.0, -0.1, 5.0));
    let circulatory = flows_of_two!(Follower::new(0.7), State::new(0.0, [0.3, 0.1], [0.0; 2]), 3.0);
    let gyroscopic =
        flows_of_two!(Plain::new(-1.0, -1.0, 0.0, 3.0, 0.0), State::new(0.0, [0.3, 0.1], [0.0; 2]), 3.0);
    let kink = flows!(Vee::new(), at(0.5, 0.0), 1.6, [-0.2, 0.4, -2.0, -1.0]);
    let polar = flows_of_two!(Polar::new(1.0), State::new(0.0, [0.0, 0.3], [1.0, 0.0]), 1.0);
    // v = v₀/√(1 + 2 c v₀² t)
    let (v, t) = (0.8f64, 2.0f64);
    let root = (1.0 + 2.0 * v * v * t).sqrt();
    // x − x₀ = (√(1 + 2 c v₀² t) − 1)/(c v₀)
    let (late, by_velocity) = (1.0 / root.powi(3), 2.0 * t / root - (root - 1.0) / (v * v));
    let dragged = flows!(Dragged::new(0.0, 1.0), at(0.3, v), t, [1.0, by_velocity, 0.0, late]);
    let forced = flows!(Shaken::new(0.4), at(0.3, 0.0), 5.0, exponential(2.0, 0.4, 5.0));
    let round = flows_of_two!(Round::new(1.0), State::new(0.0, [0.8, 0.1], [0.0, 0.5]), 3.0);
    let nearly = flows_of_two!(Nearly::new(0.0, 1e-9, 1.0), State::new(0.0, [0.3, 0.1], [0.0; 2]), 3.0);
    let stiff = flows!(Swing::new(1e12, 0.0), at(0.3, 0.0), 1e-5, exponential(1e12, 0.0, 1e-5));
    let gust = flows!(Gust::default(), at(0.0, 0.0), 60.0, exponential(1.0, 0.0, 60.0));
    let tied = tied_flows();
    let mut cases = [
        pulsed,
        negative,
        circulatory,
        gyroscopic,
        kink,
        tied,
        polar,
        dragged,
        forced,
        round,
        nearly,
        stiff,
        gust,
    ]
    .map(|cells| cells.map(Some));
    let names = ["`fundamental_matrix`, `ByVariationalEquations`", "`fundamental_matrix`, `ByGradients`"];
    for (k, name) in names.into_iter().enumerate() {
        let [a, b, c, d, e, f, g, h, i, j, l, m, late] =
            cases.each_mut().map(|cells| cells[k].take().unwrap());
        table.row(name, [a, b, c, d, e, f, g, h, i, j, l, m, BY_TOLERANCE, late, TYPE, TYPE]);
    }
}

/// The slope of the end by a parameter, against a difference of fourth order of ends.
macro_rules! slope {
    ($of:expr, $at:expr, $start:expr, $duration:expr) => {{
        let (of, start) = ($of, $start);
        let found = sensitivity(
            |[x]: [_; 1]| of(x),
            [$at],
            Dop853,
            PiController::tolerance(1e-12),
            &start,
            $duration,
        );
        let end = |x: f64| {
            let system = of(Gradient::<f64, 1>::constant(x));
            let run =
                integrate(&system, Dop853, PiController::tolerance(1e-13), start.map(Gradient::constant));
            run.until(Gradient::constant($duration)).final_state().unwrap().map(|x| x.value)
        };
        right(found.map_err(AnalysisError::Run), |found| {
            let h = 1e-3 * $at;
            let [a, b, c, d] = [2.0 * h, h, -h, -2.0 * h].map(|h| end($at + h).q);
            let quotient = ((b - c) * 8.0 - (a - d)) / (12.0 * h);
            (quotient - found.slopes[0].q).amax() < 1e-5 * (quotient.amax() + 1.0 / $at)
        })
    }};
}

fn parameters(table: &mut Table) {
    type G = Gradient<f64, 1>;
    let d = G::constant;
    let at = |x: f64, v: f64| State::new(0.0, [x], [v]);
    let two = State::new(0.0, [0.3, 0.1], [0.0, 0.2]);
    let plain = Plain::new(1.0, 2.0, 0.0, 0.0, 0.0).map(d);
    table.row(
        "`sensitivity`",
        [
            slope!(|c| Shaken { c }, 0.4, at(0.3, 0.0), 5.0),
            slope!(|c: G| Swing { k: d(1.0), c: -c }, 0.1, at(0.3, 0.0), 5.0),
            slope!(|p| Follower { p }, 0.7, two, 3.0),
            slope!(|g| Plain { k: d(-1.0), l: d(-1.0), g, ..plain }, 3.0, two, 3.0),
            slope!(|mu| Rubbing { mu }, 0.3, at(2.0, -0.3), 3.0),
            slope!(|g| Cartesian { g }, 9.81, State::new(0.0, [0.6, -0.8], [0.0; 2]), 1.0),
            slope!(|k| Polar { k }, 1.0, State::new(0.0, [0.0, 0.3], [1.0, 0.0]), 1.0),
            slope!(|c| Dragged { k: d(1.0), c }, 0.5, at(0.3, 0.8), 2.0),
            slope!(|f| Resonant { f }, 0.3, at(0.3, 0.0), 5.0),
            slope!(|mu| Round { mu }, 1.0, two, 3.0),
            slope!(|e| Nearly { mu: d(0.0), e, k: d(1.0) }, 1e-3, two, 3.0),
            slope!(|k| Swing { k, c: d(0.0) }, 1e12, at(0.3, 0.0), 1e-6),
            right(
                sensitivity(
                    |[mu]: [G; 1]| Rubbing { mu },
                    [0.3],
                    Dop853,
                    FixedStep::new(d(0.1)),
                    &at(2.0, -0.3),
                    3.0,
                )
                .map_err(AnalysisError::Run),
                |_| false,
            ),
            slope!(|w| Onset { w }, 0.5, at(0.0, 0.0), 60.0),
            TYPE,
            TYPE,
        ],
    );
}

lagrangian! {
    /// A force that sets in at t = 50, in the time w.
    pub system Onset {
        param w;
        coord x;
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = exp(-((t - 50) / w).powi(2));
    }
}

/// An orbit by variational equations of T variables, its period and the product of its multipliers.
macro_rules! orbit {
    ($system:expr, $many:literal, $guess:expr, $period:expr, $duration:expr, $product:expr) => {{
        let system = $system;
        let flow = ByVariationalEquations::<_, $many>::new(&system, 1e-12);
        right(periodic_orbit(&flow, &$guess, $period, 1e-8), |orbit| {
            let product: Complex<f64> = orbit.multipliers.iter().product();
            (orbit.period - $duration).abs() < 1e-6
                && (product - $product).norm() < 1e-4 * (1.0f64).max($product)
        })
    }};
}

fn orbits(table: &mut Table) {
    use Period::{About, Given};
    let turn = std::f64::consts::TAU;
    let at = |x: f64, v: f64| State::new(0.0, [x], [v]);
    let two = |q: [f64; 2], qd: [f64; 2]| State::new(0.0, q, qd);
    let hangs = two([0.6, -0.8], [0.0; 2]);
    let swing =
        lagrange_runtime::testing::reference::SimplePendulum::new(9.81, 1.0, 0.6f64.asin(), 0.0).period();
    let (vee, edge) = (Vee::new(), 4.0 * 2f64.sqrt());
    let plain = || Plain::new(-1.0, -1.0, 0.0, 3.0, 0.0);
    let round = two([1.2, 0.0], [0.0, 1.2 * 0.44f64.sqrt()]);
    let circle = turn / 0.44f64.sqrt();
    let one = 1.0;
    let van_der_pol = 6.663_286_859_323_13;
    let damped = |c: f64, t: f64| (-c * t).exp();
    table.row(
        "`periodic_orbit`, `Period::Given`",
        [
            orbit!(Pulsed::default(), 3, at(0.3, 0.0), Given(7.0), 7.0, one),
            orbit!(Swing::new(1.0, -0.1), 3, at(0.0, 0.0), Given(2.5), 2.5, damped(-0.1, 2.5)),
            orbit!(Follower::new(0.7), 10, two([0.0; 2], [0.0; 2]), Given(2.5), 2.5, one),
            orbit!(plain(), 10, two([0.0; 2], [0.0; 2]), Given(2.5), 2.5, one),
            orbit!(Vee::new(), 3, at(0.5, 0.0), Given(edge), edge, one),
            orbit!(Cartesian::default(), 10, hangs, Given(swing), swing, one),
            orbit!(Polar::new(1.0), 10, two([0.0, 0.3], [1.0, 0.0]), Given(turn), turn, one),
            orbit!(Dragged::new(1.0, 1.0), 3, at(0.0, 0.0), Given(2.5), 2.5, one),
            both([
                orbit!(Shaken::new(0.4), 3, at(0.3, 0.1), Given(turn), turn, damped(0.4, turn)),
                orbit!(Shaken::new(0.4), 3, at(0.3, 0.1), Given(4.0), 4.0, one),
            ]),
            orbit!(Round::new(1.0), 10, round, Given(circle), circle, one),
            orbit!(Nearly::new(-1.0, 1e-9, 1.0), 10, two([0.0; 2], [0.0; 2]), Given(2.5), 2.5, one),
            orbit!(Swing::new(1e12, 0.0), 3, at(0.0, 0.0), Given(1e-5), 1e-5, one),
            BY_TOLERANCE,
            orbit!(Gust::default(), 3, at(0.0, 0.0), Given(20.0), 20.0, one),
            TYPE,
            TYPE,
        ],
    );
    table.row(
        "`periodic_orbit`, `Period::About`",
        [
            orbit!(Pulsed::default(), 3, at(0.3, 0.0), About(7.0), 7.0, one),
            both([
                orbit!(VanDerPol::new(1.0), 3, at(2.0, 0.0), About(6.6), van_der_pol, 0.000_859_5),
                orbit!(Swing::new(1.0, -0.1), 3, at(0.1, 0.0), About(6.3), 6.3, one),
            ]),
            orbit!(Follower::new(0.3), 10, two([0.01, 0.0], [0.0; 2]), About(6.3), 6.3, one),
            orbit!(
                plain(),
                10,
                two([1.0, 0.0], [0.0, (3.0 - 5f64.sqrt()) / 2.0]),
                About(16.0),
                2.0 * turn / (3.0 - 5f64.sqrt()),
                one
            ),
            {
                // Of energy E in 4 √(2E), or a multiple: all of them are orbits.
                let flow = ByVariationalEquations::<_, 3>::new(&vee, 1e-12);
                right(periodic_orbit(&flow, &at(0.5, 0.0), About(5.5), 1e-8), |orbit| {
                    let energy = orbit.start.q[0].abs() + 0.5 * orbit.start.qd[0].powi(2);
                    let turns = orbit.period / (4.0 * (2.0 * energy).sqrt());
                    turns > 0.5 && (turns - turns.round()).abs() < 1e-6
                })
            },
            orbit!(Cartesian::default(), 10, hangs, About(swing), swing, one),
            orbit!(Polar::new(1.0), 10, two([0.0, 0.3], [1.0, 0.0]), About(turn), turn, one),
            orbit!(Dragged::new(1.0, 1.0), 3, at(0.1, 0.0), About(6.3), 6.3, one),
            orbit!(Shaken::new(0.4), 3, at(0.3, 0.1), About(turn), turn, one),
            orbit!(Round::new(1.0), 10, round, About(circle), circle, one),
            orbit!(
                Nearly::new(-1.0, 1e-9, 4.0),
                10,
                two([0.0, 0.1], [0.0; 2]),
                About(0.5 * turn),
                0.5 * turn,
                one
            ),
            orbit!(Swing::new(1e12, 0.0), 3, at(1e-6, 0.0), About(1e-6 * turn), 1e-6 * turn, one),
            BY_TOLERANCE,
            orbit!(Gust::default(), 3, at(0.3, 0.0), About(turn), turn, one),
            TYPE,
            TYPE,
        ],
    );
}

/// Exponents over 40 intervals of length `interval`: all of them, and the largest by two trajectories.
macro_rules! exponents {
    ($system:expr, $many:literal, $start:expr, $interval:expr, $largest:expr, $within:expr) => {{
        let system = $system;
        let flow = ByVariationalEquations::<_, $many>::new(&system, 1e-11);
        let how = Measurement { transient: 20.0 * $interval, interval: $interval, intervals: 200 };
        let is = |found: f64| (found - $largest).abs() < $within;
        [
            right(lyapunov_spectrum(&flow, &$start, &how), |all| is(all[0].value)),
            right(
                lyapunov_by_two_trajectories(
                    &system,
                    Dop853,
                    PiController::tolerance(1e-11),
                    &$start,
                    1e-6,
                    &how,
                ),
                |found| is(found.value),
            ),
        ]
    }};
}

fn lyapunov(table: &mut Table) {
    let at = |x: f64, v: f64| State::new(0.0, [x], [v]);
    let two = |q: [f64; 2], qd: [f64; 2]| State::new(0.0, q, qd);
    let small = two([1e-2, 0.0], [0.0; 2]);
    let round = two([0.5, 0.0], [0.0, 0.3]);
    let mut cases = [
        exponents!(Pulsed::default(), 3, at(0.3, 0.0), 0.5, 0.0, 0.03),
        exponents!(Swing::new(1.0, -0.1), 3, at(0.01, 0.0), 0.1, 0.05, 0.03),
        // λ⁴ + 3λ² + 2 + p² with p = 1.
        exponents!(Follower::new(1.0), 10, two([1e-6, 0.0], [0.0; 2]), 0.1, 0.340_625, 0.05),
        exponents!(Plain::new(-1.0, -1.0, 0.0, 3.0, 0.0), 10, small, 0.5, 0.0, 0.03),
        exponents!(Vee::new(), 3, at(0.5, 0.0), 1.0, 0.0, 0.05),
        exponents!(Cartesian::default(), 10, two([0.6, -0.8], [0.0; 2]), 0.3, 0.0, 0.15),
        exponents!(Polar::new(1.0), 10, two([0.0, 0.3], [1.0, 0.0]), 0.5, 0.0, 0.03),
        exponents!(Dragged::new(1.0, 0.1), 3, at(0.3, 0.0), 0.5, 0.0, 0.03),
        exponents!(Shaken::new(0.4), 3, at(0.3, 0.0), 0.5, -0.2, 0.02),
        exponents!(Round::new(1.0), 10, round, 0.5, 0.0, 0.06),
        exponents!(Nearly::new(-1.0, 1e-9, 1.0), 10, small, 0.5, 0.0, 0.03),
        exponents!(Swing::new(1e12, 0.0), 3, at(1.0, 0.0), 3e-6, 0.0, 1e5),
        exponents!(Gust::default(), 3, at(0.0, 0.0), 0.5, 0.0, 0.03),
    ]
    .map(|cells| cells.map(Some));
    for (k, name) in ["`lyapunov_spectrum`", "`lyapunov_by_two_trajectories`"].into_iter().enumerate() {
        let [a, b, c, d, e, f, g, h, i, j, l, m, late] =
            cases.each_mut().map(|cells| cells[k].take().unwrap());
        table.row(name, [a, b, c, d, e, f, g, h, i, j, l, m, BY_TOLERANCE, late, TYPE, TYPE]);
    }
}

/// The work along a run is the change of energy, to a bound.
fn work<Sys, M, C, const N: usize>(
    system: &Sys,
    method: M,
    control: C,
    start: State<Sys::Scalar, N>,
    end: Sys::Scalar,
    bound: f64,
) -> Cell
where
    Sys: Lagrangian<N> + lagrange_runtime::Energies<N>,
    Sys::Scalar: Real,
    M: lagrange_runtime::method::Method<Sys, N>,
    C: lagrange_runtime::controller::Controller<Sys::Scalar, N, M::Error>,
{
    let energy = |s: &State<Sys::Scalar, N>| system.energy(&s.q, &s.qd, s.t);
    let run = integrate(system, method, control, start).until(end);
    let found = run.integrals([Scalar::zero()], |s| [system.power(&s.q, &s.qd, s.t)]).total();
    match found {
        Ok(total) => {
            let off = (energy(&total.state) - energy(&start) - total.integrals[0]).to_f64();
            let off = if off < 0.0 { -off } else { off };
            Cell::Seen(if off < bound { "right".into() } else { format!("wrong by {off:e}") })
        }
        Err(failed) => Cell::Seen(variant(failed.failure.name())),
    }
}

fn quadratures(table: &mut Table) {
    let at = |x: f64, v: f64| State::new(0.0, [x], [v]);
    let two = State::new(0.0, [0.3, 0.1], [0.0, 0.2]);
    let pi = || PiController::tolerance(1e-11);
    let double = |x: f64| DoubleDouble::from(x);
    table.row(
        "`Run::integrals`: work against energy",
        [
            work(&Pulsed::default(), Dop853, pi(), at(0.3, 0.0), 12.0, 1e-9),
            work(&Swing::new(1.0, -0.1), Dop853, pi(), at(0.3, 0.0), 5.0, 1e-9),
            work(&Follower::new(0.7), Dop853, pi(), two, 5.0, 1e-9),
            work(&Plain::new(-1.0, -1.0, 0.0, 3.0, 0.0), Dop853, pi(), two, 5.0, 1e-9),
            work(&Rubbing::new(0.3), Dop853, pi(), at(2.0, -0.3), 5.0, 1e-9),
            work(&Cartesian::default(), Dop853, pi(), State::new(0.0, [0.6, -0.8], [0.0; 2]), 3.0, 1e-8),
            work(&Polar::new(1.0), Dop853, pi(), State::new(0.0, [0.0, 0.3], [1.0, 0.0]), 1.0, 1e-9),
            work(&Dragged::new(1.0, 1.0), Dop853, pi(), at(0.3, 0.8), 5.0, 1e-9),
            work(&Shaken::new(0.4), Dop853, pi(), at(0.3, 0.0), 10.0, 1e-9),
            Cell::None("an integral of a motion, whose row says so"),
            Cell::None("an integral of a motion, whose row says so"),
            work(&Swing::new(1e12, 1e3), Dop853, pi(), at(1e-6, 0.0), 1e-5, 1e-9),
            work(&Swing::new(1.0, 0.1), MatrixExponential, FixedStep::new(20.0), at(1.0, 0.0), 20.0, 1e-13),
            work(&Onset::new(1.0), Dop853, pi(), at(0.0, 0.0), 60.0, 1e-8),
            work(
                &Swing::new(1.0, 0.1).map(|x| x as f32),
                Dop853,
                PiController::tolerance(1e-5),
                at(1.0, 0.0).map(|x| x as f32),
                5.0,
                1e-4,
            ),
            work(
                &Swing::new(1.0, 0.1).map(double),
                Verner9,
                PiController::tolerance(1e-20),
                at(1.0, 0.0).map(double),
                double(2.0),
                1e-18,
            ),
        ],
    );
    // A circle at the rate 1: the angle is the time.
    let circle = |duration: f64, control: PiController| {
        let (radial, start) = Orbit::new().reduce(&State::new(0.0, [1.0, 0.5], [0.0, 1.0]));
        let run = integrate(&radial, Dop853, control, start).until(duration);
        let last: Result<State<f64, 2>, _> = run.recover([0.5]).last().unwrap();
        right(last.map_err(AnalysisError::Run), |last| (last.q[1] - 0.5 - duration).abs() < 1e-8)
    };
    let reduced = || {
        Cell::None(
            "what is reduced has a momentum that is conserved; the compiler forms no `routhian` where forces change it",
        )
    };
    table.row(
        "`Run::recover`, `reduce`",
        [
            reduced(),
            reduced(),
            reduced(),
            reduced(),
            reduced(),
            reduced(),
            {
                let (radial, start) = Orbit::new().reduce(&State::new(0.0, [1.0, 0.5], [-1.0, 0.0]));
                let run = integrate(&radial, Dop853, pi(), start).until(5.0);
                let last: Result<State<f64, 2>, _> = run.recover([0.5]).last().unwrap();
                right(last.map_err(AnalysisError::Run), |_| false)
            },
            reduced(),
            reduced(),
            Cell::None("ignorable coordinates are the symmetry: the other cells have it"),
            Cell::None("equations are solved as they are, a symmetry is not used"),
            Cell::None("an integral of a motion, whose row says so"),
            circle(60.0, PiController::tolerance(1e-11)),
            reduced(),
            {
                let (radial, start) =
                    Orbit::new().map(|x: f64| x as f32).reduce(&State::new(0.0, [1.0, 0.5], [0.0, 1.0]));
                let run = integrate(&radial, Dop853, PiController::tolerance(1e-6), start).until(3.0);
                let last: State<f32, 2> = run.recover([0.5]).last().unwrap().unwrap();
                right(Ok(last), |last| (last.q[1] - 3.5).abs() < 1e-4)
            },
            {
                let (radial, start) =
                    Orbit::new().map(double).reduce(&State::new(0.0, [1.0, 0.5], [0.0, 1.0]).map(double));
                let run =
                    integrate(&radial, Verner9, PiController::tolerance(1e-20), start).until(double(1.0));
                let last: State<DoubleDouble, 2> = run.recover([double(0.5)]).last().unwrap().unwrap();
                right(Ok(last), |last| (last.q[1] - double(1.5)).value().abs() < 1e-18)
            },
        ],
    );
}

#[test]
fn the_table_of_functions() {
    let mut table = Table::new();
    equilibria_of_all(&mut table);
    small_motions(&mut table);
    of_matrices(&mut table);
    curves(&mut table);
    steady_motions(&mut table);
    derivatives(&mut table);
    parameters(&mut table);
    orbits(&mut table);
    lyapunov(&mut table);
    quadratures(&mut table);
    table.check("functions");
}
