lagrangian! {
    /// The azimuth of the tube is prescribed.
    pub system BeadInTube {
        param m, a, om, g = 9.81;
        coord theta;
        coord phi = om * t;
        let x = a * theta.sin() * phi.cos();
        let y = a * theta.sin() * phi.sin();
        let z = a * (1 - theta.cos());
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        observe bead = [x, y, z];
    }
}
