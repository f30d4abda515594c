lagrangian! {
    /// A piston on a column of gas, at the height x: compressed without exchange of heat, the gas has p ∝ x^−7/5
    /// (Poisson 1823).
    pub system Piston {
        param m, k, g = 9.81;
        coord x;
        T = 0.5 * m * dot(x).powi(2);
        V = k * x.powf(-0.4) + m * g * x;
    }
}
