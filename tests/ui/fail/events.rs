// Events that are none.

// A function that does not change along a motion.
pub mod constant {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Ball {
            param m, floor, g = 9.81;
            coord y;
            T = 0.5 * m * dot(y).powi(2);
            V = m * g * y;
            event never: 3;
            event fixed: floor - 1, falling;
            event some: [y, floor];
            event nothing: [];
        }
    }

    pub fn main() {
        let start = State::new(0.0, [1.0], [0.0]);
        let ball = Ball::new(1.0, 0.0);
        let run = integrate(&ball, Rk4, FixedStep::new(0.1), start).until(1.0);
        println!("{:?}", run.events((Ball::NEVER, Ball::SOME[1])).next());
    }
}

// A name that another event has, in capital letters, or an output, or every system.
pub mod names {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Ball {
            param m, g = 9.81;
            coord y;
            T = 0.5 * m * dot(y).powi(2);
            V = m * g * y;
            event ground: y, falling;
            event ground: y - 1;
            event Ground: y - 2;
            observe APEX = y;
            event apex: dot(y), falling;
            event facts: y;
            event type: y;
            observe event_value = y;
        }
    }
}

// Options that are none, or stand twice.
pub mod options {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Ball {
            param m, g = 9.81;
            coord y;
            T = 0.5 * m * dot(y).powi(2);
            V = m * g * y;
            event a: y, faling;
            event b: y, down, terminal;
            event c: y, rising, falling;
            event d: y, terminal, terminal;
            event e: y, rising, rising;
            event f: y, both;
            event h: y, direction = -1;
            event i: y, 1e-6;
        }
    }
}

// Conditions are no functions that pass zero.
pub mod conditions {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Ball {
            param m, r, g = 9.81;
            coord y;
            let below = y < 0;
            T = 0.5 * m * dot(y).powi(2);
            V = m * g * y;
            event ground: y == 0;
            event touch: y == r + 1, terminal;
            event falls: dot(y) < 0;
            event high: y >= r;
            event under: below;
        }
    }
}

// Forms that are not those of an event.
pub mod forms {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Ball {
            param m, g = 9.81;
            coord y;
            T = 0.5 * m * dot(y).powi(2);
            V = m * g * y;
            event ground = y;
            event y, falling;
            event floor;
            event stopped: dot(dot(y));
            event energy: particle(m, world);
        }
    }
}

// Families, as those of bindings and constraints are written.
pub mod families {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Beads {
            const N = 2;
            param m, wall;
            coord x: [N];
            T = 0.5 * m * (0..N).map(|i| dot(x[i]).powi(2)).sum();
            V = 0;
            event hit: [N] = |i| x[i] - wall, rising, terminal;
            event back: [2] = [x[0], x[1]], falling;
        }
    }

    pub fn main() {
        let (beads, start) = (Beads::new(1.0, 2.0), State::new(0.0, [0.0; 2], [1.0; 2]));
        let run = integrate(&beads, Rk4, FixedStep::new(0.1), start);
        println!("{:?}", run.until(1.0).events((Beads::HIT[1], Beads::BACK[1])).next());
    }
}

// An event of one system at another, and of a system that has none.
pub mod elsewhere {
    use lagrange_runtime::prelude::*;

    lagrangian! {
        pub system Ball {
            param m;
            coord y;
            T = 0.5 * m * dot(y).powi(2);
            V = 0;
            event ground: y;
        }
    }

    lagrangian! {
        pub system Disc {
            param m;
            coord y;
            T = 0.5 * m * dot(y).powi(2);
            V = 0;
            event ground: y;
        }
    }

    lagrangian! {
        pub system Point {
            param m;
            coord y;
            T = 0.5 * m * dot(y).powi(2);
            V = 0;
        }
    }

    pub fn main() {
        let start = State::new(0.0, [1.0], [0.0]);
        let _ = integrate(&Disc::new(1.0), Rk4, FixedStep::new(0.1), start).until(1.0).events(Ball::GROUND);
        let _ = integrate(&Point::new(1.0), Rk4, FixedStep::new(0.1), start).until(1.0).events(Ball::GROUND);
    }
}

pub mod option_without_a_comma {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Without {
            coord x;
            T = 0.5 * dot(x).powi(2);
            V = x;
            event ground: x falling terminal;
        }
    }
}

pub mod options_of_other_forms {
    use lagrange_runtime::prelude::*;
    lagrangian! {
        system Others {
            coord x;
            T = 0.5 * dot(x).powi(2);
            V = x;
            event before: falling x;
            event value: x, terminal = true;
            event equation: x = 0;
            event terminal first: x;
        }
    }
}

fn main() {}
