// The words that begin statements are names elsewhere.
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Words {
        param L, T, V, D, G, param, coord, force, observe, system, at;
        coord q, qd;
        let p = q + qd * at;
        T = 0.5 * L * (dot(q).powi(2) + T * dot(qd).powi(2) + system * dot(p).powi(2));
        V = V * q.powi(2) + param * coord * qd.powi(2) + G * p;
        D = 0.5 * D * dot(q).powi(2);
        Q[q] = force;
        observe S = [p, observe];
    }
}

fn main() {
    let words = Words::new(1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0);
    let zero = SVector::from([0.0, 0.0]);
    assert_eq!(words.S(&zero, &zero, 0.0), SVector::from([0.0, 1.0]));
    assert!(words.accel(&zero, &zero, 0.0).iter().all(|a| a.is_finite()));
}
