lagrangian! {
    /// A planet in polar coordinates.
    pub system Kepler {
        param m, k;
        coord r, phi;
        T = 0.5 * m * (dot(r).powi(2) + (r * dot(phi)).powi(2));
        V = -k / r;
    }
}
