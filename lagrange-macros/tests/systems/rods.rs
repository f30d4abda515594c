lagrangian! {
    /// Two constraints on positions, one of which moves.
    pub system Rods {
        param m, l, a, omega, g = 9.81;
        coord x: [2], y: [2];
        coord pivot = a * cos(omega * t);
        T = 0.5 * m * (0..2).map(|i| dot(x[i]).powi(2) + dot(y[i]).powi(2)).sum();
        V = m * g * y.sum();
        constraint upper: x[0].powi(2) + (y[0] - pivot).powi(2) == l * l;
        constraint lower: (x[1] - x[0]).powi(2) + (y[1] - y[0]).powi(2) == l * l;
        observe tension = [-2 * l * reaction(upper), -2 * l * reaction(lower)];
        observe pull = reaction(pivot);
    }
}
