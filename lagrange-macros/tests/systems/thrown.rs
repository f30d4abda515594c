lagrangian! {
    /// A stick that is thrown, with named events.
    pub system Stick {
        param m, l, c, wall = 2.0, g = 9.81;
        coord x, y, a: angle;
        let tip = y - 0.5 * l * a.cos();
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2) + l.powi(2) / 12 * dot(a).powi(2));
        V = m * g * y;
        Q[x] = -c * dot(x);
        /// The tip touches the ground.
        event ground: tip, falling, terminal;
        event apex: dot(y), falling;
        event walls: [x - wall, x + wall * t];
    }
}
