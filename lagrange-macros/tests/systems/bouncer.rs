lagrangian! {
    /// A ball on an elastic floor: Hertz' contact while it presses, free flight above.
    pub system Bouncer {
        param m, k, c, g = 9.81;
        coord y;
        T = 0.5 * m * dot(y).powi(2);
        V = m * g * y + if y < 0.0 { 0.4 * k * (-y).powf(2.5) } else { 0.0 };
        Q[y] = if y < 0.0 { -c * dot(y) } else { 0.0 };
    }
}
