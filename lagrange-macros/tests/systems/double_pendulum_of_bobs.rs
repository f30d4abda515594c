lagrangian! {
    /// By the positions of its bobs.
    pub system DoublePendulumOfBobs {
        param m1, m2, l1, l2, g = 9.81;
        coord th1, th2;
        let x1 = l1 * th1.sin();
        let y1 = -l1 * th1.cos();
        let x2 = x1 + l2 * th2.sin();
        let y2 = y1 - l2 * th2.cos();
        T = 0.5 * m1 * (dot(x1).powi(2) + dot(y1).powi(2)) + 0.5 * m2 * (dot(x2).powi(2) + dot(y2).powi(2));
        V = m1 * g * y1 + m2 * g * y2;
    }
}
