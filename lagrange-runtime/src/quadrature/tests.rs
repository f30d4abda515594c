use super::*;

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
