// Functions with data in the wrong form.

// A function without arguments.
pub mod missing_arguments {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drifter {
            param m;
            coord x;
            extern wind: Curve;
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = wind(t);
        }
    }

    pub fn main(wind: Curve) {
        let _ = Drifter::new(1.0, wind);
    }
}

// Parentheses without arguments.
pub mod empty_arguments {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drifter {
            param m;
            coord x;
            extern wind: Curve();
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = wind(t);
        }
    }
}

// A function without a type.
pub mod missing_type {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drifter {
            param m;
            coord x;
            extern wind: (t);
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = wind(t);
        }
    }
}

// A function whose word `fn` or type is missing.
pub mod neither_form {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drifter {
            param m;
            coord x;
            extern wind(t);
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = wind(t);
        }
    }
}

// The colon is missing.
pub mod missing_colon {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drifter {
            param m;
            coord x;
            extern wind Curve(t);
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = wind(t);
        }
    }
}

// A call with the wrong number of arguments, and a name that a parameter has.
pub mod calls_and_names {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Drifter {
            param m, gust;
            coord x;
            extern wind: Curve(t);
            extern gust: Curve(t);
            T = 0.5 * m * dot(x).powi(2);
            V = 0;
            Q[x] = wind(t, x) + m * wind;
        }
    }

    pub fn main(wind: Curve) {
        let system = Drifter::new(1.0, 2.0, wind);
        println!("{} {:?}", system.energy(&SVector::from([0.1]), &SVector::from([0.1]), 0.0), system.wind);
    }
}

fn main() {}
