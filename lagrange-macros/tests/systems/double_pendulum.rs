lagrangian! {
    /// By its angles.
    pub system DoublePendulum {
        param m1, m2, l1, l2, g = 9.81;
        coord th1, th2;
        T = 0.5 * (m1 + m2) * (l1 * dot(th1)).powi(2)
            + 0.5 * m2 * (l2 * dot(th2)).powi(2)
            + m2 * l1 * l2 * dot(th1) * dot(th2) * (th1 - th2).cos();
        V = -(m1 + m2) * g * l1 * th1.cos() - m2 * g * l2 * th2.cos();
    }
}
