use super::*;
use crate::prelude::*;
use crate::testing::slope;
use crate::{BlanesMoan4, KahanLi8, Nystrom6, Nystrom8, Nystrom12};

#[test]
fn rules_are_exact_to_their_degree() {
    for n in 1..=MOST {
        let rule = GaussLegendre::of_nodes(n);
        for degree in 0..2 * n as i32 {
            let sum: f64 = rule.nodes().iter().map(|(x, w)| w * x.powi(degree)).sum();
            let exact = 1.0 / f64::from(degree + 1);
            assert!((sum - exact).abs() < 4.0 * f64::EPSILON, "{n} nodes, degree {degree}: {sum}");
        }
        // And no further: the error of the next even power is the square of the monic polynomial, integrated.
        let sum: f64 = rule.nodes().iter().map(|(x, w)| w * x.powi(2 * n as i32)).sum();
        assert!(1.0 / (2.0 * n as f64 + 1.0) - sum > 1e-10, "{n} nodes");
    }
    assert_eq!(GaussLegendre::of_order(u32::MAX).nodes().len(), MOST);
}

lagrangian! {
    /// An orbit, whose angle is to be recovered.
    system Orbit {
        coord r: length, phi: angle;
        T = 0.5 * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -1 / r;
        routhian Radial;
    }
}

/// The angle by quadrature against the angle integrated as a coordinate, by the number of steps.
fn errors_of<M>(method: &M, steps: [u32; 3]) -> Vec<(f64, f64)>
where
    M: Method<Radial, 1> + Clone,
    Fixed<f64>: Controller<f64, 1, M::Error>,
{
    let start = State::new(0.0, [1.0, 0.0], [0.3, 1.1]);
    let end = 6.0;
    let (radial, state) = Orbit::new().reduce(&start);
    let exact = integrate(&Orbit::new(), Verner9, Pi::tolerance(1e-15), start).until(end).finish().unwrap();
    let error = |n: u32| {
        let h = end / f64::from(n);
        let run = integrate(&radial, method.clone(), Fixed::new(h), state).until(end);
        let recovered: State<f64, 2> = run.recover([0.0]).last().unwrap().unwrap();
        (h, (recovered.q[1] - exact.q[1]).abs())
    };
    steps.into_iter().map(error).collect()
}

#[test]
fn integrals_are_as_accurate_as_said() {
    macro_rules! check {
        ($($method:expr, $steps:expr, $order:expr;)*) => {$(
            let errors = errors_of(&$method, $steps);
            let order = slope(errors.iter().copied(), 1e-13);
            assert!(order > $order - 0.3, "{}: order {order} of {errors:?}", stringify!($method));
        )*};
    }
    check! {
        Euler, [400, 800, 1600], 1.0;
        Verlet, [60, 120, 240], 2.0;
        ImplicitMidpoint, [60, 120, 240], 2.0;
        Rk4, [60, 120, 240], 4.0;
        Gauss4, [60, 120, 240], 4.0;
        BlanesMoan4, [40, 80, 160], 4.0;
        DormandPrince5, [40, 80, 160], 5.0;
        Tsitouras5, [40, 80, 160], 5.0;
        Rodas5P, [40, 80, 160], 5.0;
        Radau5, [40, 80, 160], 5.0;
        Gauss6, [40, 80, 160], 6.0;
        Nystrom6, [12, 18, 27], 6.0;
        Nystrom8, [8, 12, 16], 8.0;
        Compose(Verlet, KahanLi8), [40, 60, 80], 8.0;
        Dop853, [20, 30, 40], 8.0;
        Verner9, [12, 16, 20], 8.0;
        Nystrom12, [6, 8, 10], 10.0;
    }
}
