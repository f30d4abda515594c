// Functions with data: types of the runtime and of the program, with paths and generic arguments.
use lagrange_runtime::prelude::*;

pub mod gusts {
    use lagrange_runtime::prelude::*;
    use lagrange_runtime::traits::ExternFunction;

    #[derive(Clone, Debug, PartialEq)]
    pub struct Sum<const K: usize>(pub [f64; K]);

    impl<const K: usize> ExternFunction<1> for Sum<K> {
        fn value<S: Scalar>(&self, [t]: [S; 1]) -> S {
            self.0.iter().fold(S::zero(), |sum, w| sum + (t * S::from_f64(*w)).sin())
        }
    }
}

lagrangian! {
    pub system Mast {
        coord x;
        /// The wind against it.
        extern scalar: gusts::Sum<2>(t);
        extern lanes: lagrange_runtime::traits::Curve(height);
        T = 0.5 * dot(x).powi(2);
        V = 0.5 * x.powi(2);
        Q[x] = scalar(2 * t) * lanes(x);
    }
}

fn main() {
    let profile = Curve::linear(&[0.0, 2.0], &[1.0, 5.0], Beyond::Held).unwrap();
    let mast = Mast::new(gusts::Sum([1.0, 3.0]), profile);
    let (q, rest) = (SVector::from([0.5]), SVector::from([0.0]));
    let found = mast.accel(&q, &rest, 0.25)[0];
    assert!((found - (2.0 * (0.5f64.sin() + 1.5f64.sin()) - 0.5)).abs() < 1e-15);
    let doubled = mast.clone().map(|x: f64| x as f32);
    assert_eq!(doubled.lanes, mast.lanes);
}
