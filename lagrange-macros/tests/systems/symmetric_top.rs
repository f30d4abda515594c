lagrangian! {
    /// φ precession, θ inclination from the upward vertical, ψ spin.
    pub system SymmetricTop {
        param m, l, I1, I3, g = 9.81;
        coord phi, theta, psi;
        let spin = dot(psi) + dot(phi) * cos(theta);
        T = 0.5 * I1 * (dot(theta).powi(2) + (dot(phi) * sin(theta)).powi(2)) + 0.5 * I3 * spin.powi(2);
        V = m * g * l * cos(theta);
    }
}
