//! The system whose ensembles are killed, run out of disk, and are spread over ranks.

use lagrange_runtime::prelude::*;

lagrangian! {
    pub system Pendulum {
        param l;
        coord theta;
        T = 0.5 * (l * dot(theta)).powi(2);
        V = -9.81 * l * cos(theta);
    }
}
