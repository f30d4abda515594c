// One mistake, and every use of the system: none of them is an error.
use lagrange_runtime::SVector;
use lagrange_runtime::prelude::*;

lagrangian! {
    #[derive(PartialOrd)]
    pub system Pendulum {
        param m, l: [2], g = 9.81;
        coord theta: [2];
        let tip = [l[0] * theta[0].sin(), -l[0] * theta[0].cos()];
        T = 0.5 * m * (0..2).map(|i| (l[i] * dot(theta[i])).powi(2)).sum();
        V = -m * g * l[0] * tehta[0].cos();
        observe tip;
        observe height = tip[1];
    }
}

const PENDULUM: Pendulum = Pendulum::new(1.0, [0.5, 0.25]);

fn drift<S: Energies<2> + Legendre<2> + Separable<2>>(_: &S) -> usize {
    S::FACTS.coordinates.len()
}

fn main() {
    let (q, qd) = (SVector::from([0.1, 0.2]), SVector::zeros());
    let heavy = Pendulum { m: 2.0, ..PENDULUM };
    let tip: SVector<f64, 2> = heavy.tip(&q, &qd, 0.0);
    let height: f64 = heavy.height(&q, &qd, 0.0);
    let a = heavy.map(|x| x as f32).accel(&q.map(|x| x as f32), &SVector::zeros(), 0.0);
    println!("{tip} {height} {a} {} {}", drift(&heavy), heavy > PENDULUM);
}
