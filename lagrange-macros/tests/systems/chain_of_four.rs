lagrangian! {
    /// Four unit links.
    pub system ChainOfFour {
        const N = 4;
        coord theta: [N];
        let x: [N] = |i| (0..i + 1).map(|j| theta[j].sin()).sum();
        let y: [N] = |i| -(0..i + 1).map(|j| theta[j].cos()).sum();
        T = (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2))).sum();
        V = (0..N).map(|i| 9.81 * y[i]).sum();
    }
}
