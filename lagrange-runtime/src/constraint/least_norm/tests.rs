use super::*;
use crate::prelude::*;

lagrangian! {
    /// A parallelogram with three cranks: a loop too many, whose conditions follow from those of the other.
    pub(crate) system ThreeCranks {
        param l = 1, g = 9.81;
        coord a: [3], b;
        let x = l * cos(a[0]) + 0.5 * l * cos(b);
        let y = l * sin(a[0]) + 0.5 * l * sin(b);
        T = l * l / 6 * (0..3).map(|i| dot(a[i]).powi(2)).sum() + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + l * l * dot(b).powi(2) / 24;
        V = g * (0.5 * l * (sin(a[0]) + sin(a[1]) + sin(a[2])) + y);
        redundant constraint end: [cos(a[0]) + cos(b), sin(a[0]) + sin(b)] == [cos(a[1]) + 1, sin(a[1])];
        redundant constraint middle: [cos(a[0]) + 0.5 * cos(b), sin(a[0]) + 0.5 * sin(b)] == [cos(a[2]) + 0.5, sin(a[2])];
        observe pull = reaction(middle);
    }
}

/// With all cranks at the angle a, T is ½ (2 · ½ + 1) ȧ².
#[test]
fn a_third_crank_turns_with_the_others() {
    let system = ThreeCranks::new();
    let facts = ThreeCranks::<f64>::FACTS;
    let redundancy = facts.redundancy.expect("one loop follows from the other");
    assert_eq!((redundancy.rank, facts.degrees_of_freedom()), (Some(3), 1), "{redundancy:?}");
    assert!(redundancy.superfluous.len() > 1, "{redundancy:?}");
    for k in 0..2001 {
        let angle = -3.1 + 0.0031 * f64::from(k);
        let (q, qd) = ([angle, angle, angle, 0.0].into(), [0.7, 0.7, 0.7, 0.0].into());
        if angle.sin().abs() < 1e-3 {
            continue;
        }
        let found = system.accel(&q, &qd, 0.0);
        let expected = -9.81 * 2.5 * angle.cos() / 2.0;
        let off = (found - SVector::from([expected, expected, expected, 0.0])).amax();
        assert!(off < 1e-11 / angle.sin().abs(), "{angle}: {off:e}");
    }
}
