lagrangian! {
    /// A bob on a massless rod, θ from the downward vertical.
    pub system Pendulum {
        param m, l, g = 9.81;
        coord theta;
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * theta.cos();
    }
}
