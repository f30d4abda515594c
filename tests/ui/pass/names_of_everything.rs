// Names that constants, variants, traits, types and what is emitted have, of parameters, coordinates, functions, outputs and systems.
#![deny(warnings)]
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

const K: f64 = 40.0;
const PAIRS: usize = 3;
const G: f64 = 9.81;
struct Unit;

lagrangian! {
    pub system Stiffness {
        param K, PAIRS, SQUARED, Some, None, Ok, S, R, N, Unit, Dop853, Self_, M: [2];
        coord G, Err, I: [2];
        let Energy = K * G.powi(2) + None * Err.sin() + M[0] * I[1];
        T = 0.5 * PAIRS * dot(G).powi(2) + SQUARED * dot(Err).powi(2) + Some * (dot(I[0]).powi(2) + dot(I[1]).powi(2)) + Dop853 * dot(Energy).powi(2);
        V = K * G.powi(2) + Ok * Err.powi(4) + S * R * N * I[0].cos() + Unit * Self_ * M[1];
        observe Vec = [Energy, G];
        impulse Option at [G, Err];
        event some: G;
        event S: [Energy, Err - K];
    }
}

lagrangian! {
    pub system K {
        extern fn q(t, q);
        extern fn numbers(t);
        param t_, numbers_, at, order, motion, level, zeroth, found, solver, unknowns, given, f, w0, k0, constants, x0, event, accelerations;
        coord p: [2], clock, weight, x3;
        T = at * dot(p[0]).powi(2) + order * dot(p[1]).powi(2) + motion * dot(clock).powi(2) + (level + p[0].sin()) * dot(weight).powi(2) + zeroth * dot(x3).powi(2);
        V = found * solver * unknowns * given * f * w0 * k0 * constants * x0 * event * accelerations * (p[0] + clock) + t_ * numbers_ * q(x3, weight);
        Q[x3] = numbers(t);
        event at: at * event * clock + given - accelerations * p[0].sin();
    }
}

fn q<S: Scalar>(t: S, q: S) -> S {
    t * q
}

fn numbers<S: Scalar>(t: S) -> S {
    t
}

/// Systems by the names of what they are made of.
mod systems {
    pub mod one {
        lagrange_runtime::lagrangian! { pub system Lagrangian { coord x; T = dot(x).powi(2); V = if x < 0 { x * x } else { 0 }; } }
    }
    pub mod two {
        lagrange_runtime::lagrangian! { pub system R { coord x; T = dot(x).powi(2); V = x.cos(); } }
    }
    pub mod three {
        lagrange_runtime::lagrangian! { pub system FnMut { coord x, y; T = dot(x).powi(2) + (1 + x * x) * dot(y).powi(2); V = 0; pub routhian Option; } }
    }
    pub mod four {
        lagrange_runtime::lagrangian! { pub system Clone { param Default; coord x; T = Default * dot(x).powi(2); V = 0; } }
    }
    pub mod five {
        lagrange_runtime::lagrangian! { #[allow(non_camel_case_types)] pub system core { param lagrange_runtime; coord x; T = lagrange_runtime * dot(x).powi(2); V = 0; } }
    }
}

fn main() {
    let one = Stiffness::new(K, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 1.0, [1.0, 2.0]);
    let zero = SVector::from([0.0; 4]);
    assert_eq!(one.Vec(&zero, &zero, 0.0), SVector::from([0.0, 0.0]));
    assert_eq!(one.Option(&zero, 0.0, &SVector::from([1.0, 2.0])), SVector::from([1.0, 2.0, 0.0, 0.0]));
    let stretched = SVector::from([0.5, 0.0, 0.0, 0.0]);
    assert_eq!(one.accel(&stretched, &zero, 0.0)[0], -2.0 * K * 0.5);
    assert_eq!((PAIRS, G), (3, 9.81));
    let _ = Unit;
    let two = systems::two::R::new();
    assert_eq!(two.accel(&SVector::from([0.0]), &SVector::from([0.0]), 0.0)[0], 0.0);
    let _ = (systems::one::Lagrangian::new(), systems::three::FnMut::new(), systems::four::Clone::new(1.0));
    let _ = (systems::five::core::new(1.0), systems::three::Option::new(0.0));
    let mut fields =
        K::new(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0);
    fields.at = 2.0;
    let zero = SVector::from([0.0; 5]);
    assert_eq!(fields.accel(&zero, &zero, 4.0), SVector::from([-0.25, 0.0, -0.5, 0.0, 2.0]));
}
