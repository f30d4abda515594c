lagrangian! {
    /// With friction in the pivot and a moment that the user computes.
    pub system DrivenPendulum {
        param m, l, c, g = 9.81;
        coord theta;
        extern fn moment(t);
        T = 0.5 * m * (l * dot(theta)).powi(2);
        V = -m * g * l * theta.cos();
        D = 0.5 * c * dot(theta).powi(2);
        Q[theta] = moment(t);
    }
}
