lagrangian! {
    pub system Top {
        param m, l, I1, I3, g = 9.81;
        coord phi: angle, theta: angle, psi: angle;
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2))
            + 0.5 * I3 * (dot(psi) + dot(phi) * theta.cos()).powi(2);
        V = m * g * l * theta.cos();
        observe height = l * theta.cos();
        observe direction = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
        observe spin = dot(psi) + dot(phi) * theta.cos();
        /// The nutation of a top.
        pub routhian Nutation;
    }
}
