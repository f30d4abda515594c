lagrangian! {
    /// A constraint on velocities, and where it is struck.
    pub system Skate {
        param m, I, a, g = 9.81;
        coord x, y, phi;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * I * dot(phi).powi(2);
        V = -m * g * x;
        constraint blade: dot(x) * phi.sin() == dot(y) * phi.cos();
        impulse blow at [x + a * cos(phi), y + a * sin(phi)];
        observe grip = reaction(blade);
    }
}
