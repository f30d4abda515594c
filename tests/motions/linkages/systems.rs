//! The mechanisms, and their twins of independent coordinates.

use lagrange_runtime::prelude::*;

lagrangian! {
    /// A parallelogram with three cranks at 0, ½ and 1 of its base: a loop more than it needs.
    pub system ThreeCranks {
        param l = 1, g = 9.81;
        coord a: [3], b;
        let x = l * cos(a[0]) + 0.5 * cos(b);
        let y = l * sin(a[0]) + 0.5 * sin(b);
        T = l * l / 6 * (0..3).map(|i| dot(a[i]).powi(2)).sum() + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * l * (0..3).map(|i| sin(a[i])).sum() + y);
        redundant constraint end: [l * cos(a[0]) + cos(b), l * sin(a[0]) + sin(b)] == [l * cos(a[1]) + 1, l * sin(a[1])];
        redundant constraint middle: [l * cos(a[0]) + 0.5 * cos(b), l * sin(a[0]) + 0.5 * sin(b)] == [l * cos(a[2]) + 0.5, l * sin(a[2])];
    }
}

lagrangian! {
    /// The same with four cranks, at thirds.
    pub system FourCranks {
        param l = 1, g = 9.81;
        coord a: [4], b;
        let x = l * cos(a[0]) + 0.5 * cos(b);
        let y = l * sin(a[0]) + 0.5 * sin(b);
        T = l * l / 6 * (0..4).map(|i| dot(a[i]).powi(2)).sum() + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * l * (0..4).map(|i| sin(a[i])).sum() + y);
        redundant constraint pin: [l * cos(a[0]) + cos(b) / 3, l * cos(a[0]) + 2 * cos(b) / 3, l * cos(a[0]) + cos(b)]
            == [l * cos(a[1]) + 1.0 / 3.0, l * cos(a[2]) + 2.0 / 3.0, l * cos(a[3]) + 1];
        redundant constraint level: [l * sin(a[0]) + sin(b) / 3, l * sin(a[0]) + 2 * sin(b) / 3, l * sin(a[0]) + sin(b)]
            == [l * sin(a[1]), l * sin(a[2]), l * sin(a[3])];
    }
}

lagrangian! {
    /// Bennett's linkage: four bars of lengths a, b, a, b in space, whose joints are twisted by α, β, α, β with
    /// `a/sin α = b/sin β`. The angles of the bars at the first, second and fourth joint are coordinates; at the
    /// third two points and two axes coincide. Unit masses at the joints, that at the third in halves on both sides.
    pub system Bennett {
        param a = 1, alpha = 0.6, beta = 1.1, g = 9.81;
        coord t1: angle, t2: angle, t4: angle;
        let b = a * sin(beta) / sin(alpha);
        let ux = b * cos(t2);
        let uy = b * sin(t2) * cos(alpha);
        let x = a * cos(t1) + cos(t1) * ux - sin(t1) * uy;
        let y = a * sin(t1) + sin(t1) * ux + cos(t1) * uy;
        let z = b * sin(t2) * sin(alpha);
        let x4 = -b - a * cos(t4);
        let y4 = a * sin(t4) * cos(beta);
        let z4 = -a * sin(t4) * sin(beta);
        let vx = sin(t2) * sin(beta);
        let vy = -cos(t2) * sin(beta) * cos(alpha) - cos(beta) * sin(alpha);
        let vz = -cos(t2) * sin(beta) * sin(alpha) + cos(beta) * cos(alpha);
        T = 0.5 * a * a * dot(t1).powi(2) + 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(z).powi(2))
            + 0.5 * (dot(x4).powi(2) + dot(y4).powi(2) + dot(z4).powi(2));
        V = g * (a * sin(t1) + y + y4);
        redundant constraint joint: [x, y, z] == [x4, y4, z4];
        redundant constraint axis: [cos(t1) * vx - sin(t1) * vy, sin(t1) * vx + cos(t1) * vy, vz] == [
            sin(alpha) * sin(t4),
            sin(alpha) * cos(t4) * cos(beta) + cos(alpha) * sin(beta),
            -sin(alpha) * cos(t4) * sin(beta) + cos(alpha) * cos(beta),
        ];
        observe axis_moments = reaction(axis);
    }
}

lagrangian! {
    /// Sarrus's linkage (1853): a plate on two chains of three hinges, those of one across those of the other, which
    /// lead it along a straight line.
    pub system Sarrus {
        param l = 0.4, d = 0.1, m = 0.2, plate = 1, j = 0.01, g = 9.81;
        coord a: [2], p, b: [2], r;
        let ya = -d + l * cos(a[0]) + l * cos(a[1]) + d * cos(p);
        let za = l * sin(a[0]) + l * sin(a[1]) + d * sin(p);
        let xb = -d + l * cos(b[0]) + l * cos(b[1]) + d * cos(r);
        let zb = l * sin(b[0]) + l * sin(b[1]) - d * sin(r);
        T = 0.5 * m * l * l * (dot(a[0]).powi(2) + dot(b[0]).powi(2)) + 0.5 * j * (dot(p).powi(2) + dot(r).powi(2))
            + 0.25 * plate * (dot(ya).powi(2) + dot(za).powi(2) + dot(xb).powi(2) + dot(zb).powi(2));
        V = g * (m * l * (sin(a[0]) + sin(b[0])) + 0.5 * plate * (za + zb));
        redundant constraint place: [0, ya, za] == [xb, 0, zb];
        redundant constraint attitude: [sin(p), sin(r), sin(p) * sin(r)] == [0, 0, 0];
    }
}

lagrangian! {
    /// A slider-crank: uniform crank and rod.
    pub system SliderCrank {
        param r = 0.3, l = 0.8, crank = 1, rod = 0.5, slider = 0.7, g = 9.81;
        coord phi: angle, psi: angle;
        let x = r * cos(phi) + 0.5 * l * cos(psi);
        let y = 0.5 * l * sin(psi);
        let s = r * cos(phi) + l * cos(psi);
        T = crank * r * r / 6 * dot(phi).powi(2) + 0.5 * slider * dot(s).powi(2)
            + 0.5 * rod * (dot(x).powi(2) + dot(y).powi(2) + l * l / 12 * dot(psi).powi(2));
        V = g * (0.5 * crank * r * sin(phi) + rod * y);
        constraint guide: r * sin(phi) == l * sin(psi);
    }
}

lagrangian! {
    /// A scissors lift of six stages: bars of length 2 l that are pinned in their middles, from a pivot and from a
    /// slider at x, which is pulled.
    pub system Scissors {
        const N = 6;
        param l = 0.5, m = 0.2, slider = 0.3, load = 1, pull = 150, g = 9.81;
        coord x, th: [N], ph: [N];
        // The i-th bar that rises to the right begins at (px, py), the other one at (qx, qy): each on the end of the
        // other one of the stage below.
        let px: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { -2 * l * cos(ph[k]) } else { 2 * l * cos(th[k]) }).sum() + i % 2 * x;
        let py: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { 2 * l * sin(ph[k]) } else { 2 * l * sin(th[k]) }).sum();
        let qx: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { 2 * l * cos(th[k]) } else { -2 * l * cos(ph[k]) }).sum() + (i + 1) % 2 * x;
        let qy: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { 2 * l * sin(th[k]) } else { 2 * l * sin(ph[k]) }).sum();
        let ax: [N] = |i| px[i] + l * cos(th[i]);
        let ay: [N] = |i| py[i] + l * sin(th[i]);
        let bx: [N] = |i| qx[i] - l * cos(ph[i]);
        let by: [N] = |i| qy[i] + l * sin(ph[i]);
        let top = py[N - 1] + 2 * l * sin(th[N - 1]);
        T = 0.5 * slider * dot(x).powi(2) + 0.5 * load * dot(top).powi(2) + 0.5 * m * (0..N).map(|i| dot(ax[i]).powi(2) + dot(ay[i]).powi(2)
            + dot(bx[i]).powi(2) + dot(by[i]).powi(2) + l * l / 3 * (dot(th[i]).powi(2) + dot(ph[i]).powi(2))).sum();
        V = m * g * (0..N).map(|i| ay[i] + by[i]).sum() + load * g * top + pull * x;
        constraint pin: [ax[0], ax[1], ax[2], ax[3], ax[4], ax[5]] == [bx[0], bx[1], bx[2], bx[3], bx[4], bx[5]];
        constraint height: [ay[0], ay[1], ay[2], ay[3], ay[4], ay[5]] == [by[0], by[1], by[2], by[3], by[4], by[5]];
    }
}

lagrangian! {
    /// The same, whose joints are led as well: those of each stage at one height, and every second one above the pivot.
    pub system GuidedScissors {
        const N = 6;
        param l = 0.5, m = 0.2, slider = 0.3, load = 1, pull = 150, g = 9.81;
        coord x, th: [N], ph: [N];
        // The i-th bar that rises to the right begins at (px, py), the other one at (qx, qy): each on the end of the
        // other one of the stage below.
        let px: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { -2 * l * cos(ph[k]) } else { 2 * l * cos(th[k]) }).sum() + i % 2 * x;
        let py: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { 2 * l * sin(ph[k]) } else { 2 * l * sin(th[k]) }).sum();
        let qx: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { 2 * l * cos(th[k]) } else { -2 * l * cos(ph[k]) }).sum() + (i + 1) % 2 * x;
        let qy: [N] = |i| (0..i).map(|k| if (i - k) % 2 == 1 { 2 * l * sin(th[k]) } else { 2 * l * sin(ph[k]) }).sum();
        let ax: [N] = |i| px[i] + l * cos(th[i]);
        let ay: [N] = |i| py[i] + l * sin(th[i]);
        let bx: [N] = |i| qx[i] - l * cos(ph[i]);
        let by: [N] = |i| qy[i] + l * sin(ph[i]);
        let top = py[N - 1] + 2 * l * sin(th[N - 1]);
        T = 0.5 * slider * dot(x).powi(2) + 0.5 * load * dot(top).powi(2) + 0.5 * m * (0..N).map(|i| dot(ax[i]).powi(2) + dot(ay[i]).powi(2)
            + dot(bx[i]).powi(2) + dot(by[i]).powi(2) + l * l / 3 * (dot(th[i]).powi(2) + dot(ph[i]).powi(2))).sum();
        V = m * g * (0..N).map(|i| ay[i] + by[i]).sum() + load * g * top + pull * x;
        redundant constraint pin: [ax[0], ax[1], ax[2], ax[3], ax[4], ax[5]] == [bx[0], bx[1], bx[2], bx[3], bx[4], bx[5]];
        redundant constraint height: [ay[0], ay[1], ay[2], ay[3], ay[4], ay[5]] == [by[0], by[1], by[2], by[3], by[4], by[5]];
        redundant constraint level: [py[1], py[2], py[3], py[4], py[5]] == [qy[1], qy[2], qy[3], qy[4], qy[5]];
        redundant constraint plumb: [px[2], px[4]] == [0, 0];
    }
}

macro_rules! loops {
    ($name:ident, $n:literal) => {
        lagrangian! {
            /// Parallelograms of uniform bars of unit mass and length side by side, between cranks at 0, 1, 2, … of
            /// the base.
            pub system $name {
                const N = $n;
                param g = 9.81;
                coord a: [N + 1], b: [N];
                let x: [N] = |i| i + cos(a[i]) + 0.5 * cos(b[i]);
                let y: [N] = |i| sin(a[i]) + 0.5 * sin(b[i]);
                T = (0..N + 1).map(|i| dot(a[i]).powi(2)).sum() / 6
                    + (0..N).map(|i| 0.5 * (dot(x[i]).powi(2) + dot(y[i]).powi(2)) + dot(b[i]).powi(2) / 24).sum();
                V = g * (0.5 * (0..N + 1).map(|i| sin(a[i])).sum() + (0..N).map(|i| y[i]).sum());
                constraint across: [N] = |i| cos(a[i]) + cos(b[i]) == cos(a[i + 1]) + 1;
                constraint up: [N] = |i| sin(a[i]) + sin(b[i]) == sin(a[i + 1]);
            }
        }
    };
}

loops!(TwoLoops, 2);
loops!(TwelveLoops, 12);

lagrangian! {
    /// A parallelogram of uniform bars of unit mass and length: cranks at (0, 0) and (1, 0), and the coupler.
    pub system Rhombus {
        param g = 9.81;
        coord a: [2], b;
        let x = cos(a[0]) + 0.5 * cos(b);
        let y = sin(a[0]) + 0.5 * sin(b);
        T = (dot(a[0]).powi(2) + dot(a[1]).powi(2)) / 6 + 0.5 * (dot(x).powi(2) + dot(y).powi(2)) + dot(b).powi(2) / 24;
        V = g * (0.5 * sin(a[0]) + 0.5 * sin(a[1]) + y);
        constraint horizontal: cos(a[0]) + cos(b) == cos(a[1]) + 1;
        constraint vertical: sin(a[0]) + sin(b) == sin(a[1]);
    }
}

lagrangian! {
    /// A bead on two parabolas that touch.
    pub system Touching {
        param g = 1;
        coord x, y;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2));
        V = g * x;
        constraint parabolas: y.powi(2) == x.powi(4);
    }
}

lagrangian! {
    /// A pendulum by its place.
    pub system Rod {
        param m, l, g = 9.81;
        coord x, y;
        T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
        V = m * g * y;
        constraint rod: x.powi(2) + y.powi(2) == l.powi(2);
    }
}

lagrangian! {
    /// A slab that slides on legs in a row, at the places s; their conditions times √k are those of legs of
    /// stiffness k.
    pub system Slab {
        param s: [4], k: [4], load, moment;
        coord x, y, phi;
        T = 0.5 * (dot(x).powi(2) + dot(y).powi(2) + dot(phi).powi(2));
        V = load * y + moment * sin(phi);
        redundant constraint leg: [4] = |i| sqrt(k[i]) * (y + s[i] * sin(phi)) == 0;
        observe force = reaction(leg);
    }
}
