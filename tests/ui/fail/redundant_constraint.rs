// Constraints that follow from others wherever the mechanism can be are a warning, which says which of them are enough; the word `redundant` says
// that they are meant.
#![deny(warnings)]
use lagrange_runtime::prelude::*;

lagrangian! {
    /// A parallelogram with a third crank.
    pub system Cranks {
        param m, g = 9.81;
        coord a, b, c, d;
        let x = cos(a) + 0.5 * cos(d);
        let y = sin(a) + 0.5 * sin(d);
        T = m / 6 * (dot(a).powi(2) + dot(b).powi(2) + dot(c).powi(2)) + 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + m / 24 * dot(d).powi(2);
        V = m * g * y;
        constraint end: [cos(a) + cos(d), sin(a) + sin(d)] == [cos(b) + 1, sin(b)];
        constraint middle: [cos(a) + 0.5 * cos(d), sin(a) + 0.5 * sin(d)] == [cos(c) + 0.5, sin(c)];
    }
}

lagrangian! {
    /// A point that is led twice, as is meant.
    pub system Twice {
        param m;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = 0;
        redundant constraint level: y == 0;
        redundant constraint again: sin(y) == 0;
    }
}

fn main() {
    println!("{:?} {:?}", Cranks::new(1.0), Twice::new(1.0));
}
