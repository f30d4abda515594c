lagrangian! {
    /// A pendulum on a motor, the current of its armature, and a controller that integrates its error.
    pub system Drive {
        param m, l, c, R, L, k, kp, ki, g = 9.81;
        /// Voltage beside that of the controller.
        input u;
        coord theta: angle;
        /// The current.
        state i = 0.1, e: [2];
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * cos(theta);
        D = 0.5 * c * dot(theta).powi(2);
        Q[theta] = k * i;
        let voltage = u - kp * theta + ki * e[0];
        rate(i) = (voltage - R * i - k * dot(theta)) / L;
        rate(e) = [-theta, e[0] - e[1]];
    }
}
