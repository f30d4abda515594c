lagrangian! {
    /// The cart is pushed by a force, the tip of the pole is observed.
    pub system CartPole {
        param M, m, l, push, g = 9.81;
        coord x, theta;
        let px = x + l * theta.sin();
        let py = -l * theta.cos();
        T = 0.5 * M * dot(x).powi(2) + 0.5 * m * (dot(px).powi(2) + dot(py).powi(2));
        V = m * g * py;
        force push at x;
        observe tip = [px, py];
    }
}
