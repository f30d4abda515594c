lagrangian! {
    /// In a uniform magnetic field along z with the potential A = B × r / 2, and an electric field along x.
    pub system ChargedParticle {
        param m, e, B, E;
        coord x, y, z;
        L = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2))
            + 0.5 * e * B * (x * dot(y) - y * dot(x))
            + e * E * x;
    }
}
