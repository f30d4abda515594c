lagrangian! {
    /// A load on a rope under a trolley, which are driven from outside.
    pub system Crane {
        param M, m, l, g = 9.81;
        /// Force of the drive.
        input force;
        input gust: [2] = 0;
        coord x: length, theta: angle;
        let px = x + l * sin(theta);
        let py = -l * cos(theta);
        T = 0.5 * M * dot(x).powi(2) + 0.5 * m * (dot(px).powi(2) + dot(py).powi(2));
        V = m * g * py;
        Q[x] = force;
        force gust at [px, py];
    }
}
