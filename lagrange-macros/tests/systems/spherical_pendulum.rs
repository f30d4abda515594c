lagrangian! {
    /// A bob on a rod in space, by two angles of which none is singular below, and in a plane.
    pub system Spherical {
        param m, l, g = 9.81;
        coord theta: angle, phi: angle;
        let x = l * theta.sin() * phi.cos();
        let y = l * phi.sin();
        let z = -l * theta.cos() * phi.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2));
        V = m * g * z;
        observe bob = [x, y, z];
        /// What starts in a plane stays in it.
        pub restriction Planar: phi = 0;
    }
}
