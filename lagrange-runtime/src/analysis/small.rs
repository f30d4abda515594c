//! The equations of small motions about an equilibrium or a steady motion, `M δq̈ + C δq̇ + K δq = f`.

use super::constrained;
use super::hypotheses::{autonomous, coordinate_names, next, second_order};
use super::motion::{antisymmetric, symmetric};
use super::quadratic::equilibrated;
use super::switch::{linearized, smooth};
use super::{AnalysisError, Modes, SmallMotion, Spectrum, modes, quadratic, spectrum};
use crate::failure::Coordinate;
use crate::state::State;
use crate::system::{Lagrangian, Linearize};
use nalgebra::{Complex, DMatrix, DVector, SymmetricEigen};

/// Entries of symmetric and antisymmetric parts up to this, relative to the entries of their row and column, are
/// rounding errors of the emitted derivatives.
const ROUNDING: f64 = 256.0 * f64::EPSILON;

/// Displacement, relative to `1 + |q|`, up to whose effect forces may be left at a steady motion.
const UNSTEADY: f64 = 1e-6;

/// Hypothesis that an instant without accelerations does not fulfil.
const STEADY: &str = "a motion along which accelerations stay 0, and are not so for an instant, as those of an attitude \
                      that turns";

impl SmallMotion {
    /// The equations with these matrices, all `n × n`, n ≥ 1.
    ///
    /// # Hypotheses
    /// - M is symmetric and positive definite.
    /// - All entries are finite.
    ///
    /// # Errors
    /// [`AnalysisError::UnsymmetricInertia`], [`AnalysisError::Inertia`], [`AnalysisError::NotFinite`],
    /// [`AnalysisError::Dimension`].
    pub fn new(m: DMatrix<f64>, c: DMatrix<f64>, k: DMatrix<f64>) -> Result<Self, AnalysisError> {
        let names = (0..m.nrows()).map(|i| format!("q{i}")).collect();
        Self::named(m, c, k, names)
    }

    pub(super) fn named(
        m: DMatrix<f64>,
        c: DMatrix<f64>,
        k: DMatrix<f64>,
        names: Vec<String>,
    ) -> Result<Self, AnalysisError> {
        let expected = m.nrows();
        if expected == 0 {
            return Err(AnalysisError::Dimension { expected: 1, found: 0 });
        }
        for found in [&m, &c, &k].into_iter().flat_map(|a| [a.nrows(), a.ncols()]) {
            if found != expected {
                return Err(AnalysisError::Dimension { expected, found });
            }
        }
        if [&m, &c, &k].into_iter().any(|a| a.iter().any(|x| !x.is_finite())) {
            return Err(AnalysisError::NotFinite);
        }
        let (odd, rounding) = (antisymmetric(&m), rounding(&m));
        if (0..expected).any(|i| (0..i).any(|j| odd[(i, j)].abs() > rounding(i, j))) {
            return Err(AnalysisError::UnsymmetricInertia { largest: odd.amax() });
        }
        let lower = factored(&m)?;
        let blur = [(); 3].map(|()| DMatrix::zeros(expected, expected));
        let (basis, constants, drifting) = (DMatrix::identity(expected, expected), Vec::new(), Vec::new());
        let [m, c, k] = [symmetric(&m), cleaned(&c), cleaned(&k)];
        Ok(SmallMotion { m, c, k, lower, blur, names, basis, constants, drifting })
    }

    /// With M, C and K at the next state, see [`next`], too: these matrices are known to the difference only. A jump
    /// is none.
    pub(super) fn blurred(mut self, beside: [DMatrix<f64>; 3]) -> Self {
        for ((blur, other), own) in self.blur.iter_mut().zip(&beside).zip([&self.m, &self.c, &self.k]) {
            let largest = own.amax();
            *blur = (own - other).abs().map(|x| if x <= f64::EPSILON.sqrt() * largest { x } else { 0.0 });
        }
        // Damping of a coordinate that is a rounding of its gyroscopic coupling to others may have either sign.
        let n = self.dimension();
        for i in 0..n {
            let coupled = |j: usize| self.c[(i, j)].abs().max(self.c[(j, i)].abs()) / self.m[(j, j)].sqrt();
            let largest = (0..n).filter(|&j| j != i).map(coupled).fold(0.0, f64::max) * self.m[(i, i)].sqrt();
            if self.c[(i, i)].abs() <= self.blur[1][(i, i)].max(quadratic::ROUNDING * largest) {
                self.c[(i, i)] = 0.0;
            }
        }
        self
    }

    /// Takes the symmetric part of C and the antisymmetric one of K for rounding, if h is conserved: both matrices
    /// follow from a Lagrangian then.
    pub(super) fn conservative(mut self, so: bool) -> Self {
        if so {
            (self.c, self.k) = (antisymmetric(&self.c), symmetric(&self.k));
        }
        self
    }

    /// With K beside an equilibrium that is not known better: K is known to the difference only.
    pub(super) fn doubted(mut self, aside: &DMatrix<f64>) -> Self {
        self.blur[2] += (&self.k - aside).abs().map(|x| if x.is_finite() { x } else { 0.0 });
        self
    }

    /// Uncertainties of M, C and K.
    pub(super) fn blur(&self) -> &[DMatrix<f64>; 3] {
        &self.blur
    }

    /// Small motions about a state without accelerations: an equilibrium at rest, or a steady motion, as
    /// [`small_vibrations`](super::small_vibrations) and [`steady`](super::Steady) find them.
    ///
    /// # Hypotheses
    /// - Accelerations vanish at the state, and stay so: the residual of a force is at most its change under a
    ///   displacement by 1e-6. Parameters of an attitude that turns are no coordinates of a steady motion.
    /// - Time does not appear in the equations of motion ([`Facts::autonomous`](crate::Facts::autonomous)).
    /// - M is positive definite.
    /// - The state is not on a switch of the forces at which these or their derivatives jump.
    ///
    /// With constraints the small motions are in minimal coordinates, some of those of the system
    /// ([`SmallMotion::names`], [`SmallMotion::basis`]), and also:
    /// - The state is on the constraints, and these are independent there.
    /// - Accelerations may be left of coordinates that follow from the others (the place of a wheel that rolls on a
    ///   circle). No coordinate that moves acts on the small motions.
    /// - Coordinates whose velocities alone follow from others do not act on these ([`SmallMotion::constants`]), or
    ///   rest.
    ///
    /// # Errors
    /// Those of [`SmallMotion::new`], [`AnalysisError::TimeDependent`], [`AnalysisError::NotEquilibrium`],
    /// [`AnalysisError::Switch`], [`AnalysisError::Kink`], [`AnalysisError::OffConstraints`],
    /// [`AnalysisError::DependentConstraints`], and [`AnalysisError::NotApplicable`] where one of the last two
    /// hypotheses does not hold.
    pub fn steady<Sys: Linearize<N, Scalar = f64>, const N: usize>(
        system: &Sys,
        at: &State<f64, N>,
    ) -> Result<Self, AnalysisError> {
        second_order::<Sys, N>()?;
        autonomous::<Sys, N>()?;
        if !Sys::FACTS.constraints.is_empty() {
            return constrained::steady(system, at);
        }
        smooth(system, at, 0.0, linearized)?;
        let [rest, _, c, k] = linearized(system, at);
        let rounding = ROUNDING * k.amax() * at.qd.amax();
        for coordinate in 0..N {
            let change = |j: usize| {
                k[(coordinate, j)].abs() * (1.0 + at.q[j].abs()) + (c[(coordinate, j)] * at.qd[j]).abs()
            };
            let residual = rest[coordinate].abs();
            if residual > UNSTEADY * (0..N).map(change).sum::<f64>() {
                let coordinate = Coordinate::of::<Sys, N>(coordinate);
                return Err(AnalysisError::NotEquilibrium { residual, coordinate, nearest: None });
            }
            let rate = |j: usize| k[(coordinate, j)] * at.qd[j];
            let size = (0..N).map(|j| rate(j).abs()).sum::<f64>();
            if (0..N).map(rate).sum::<f64>().abs() > (UNSTEADY * size).max(rounding) {
                return Err(AnalysisError::NotApplicable { needs: STEADY });
            }
        }
        Self::at(system, at)
    }

    /// Variant of [`steady`](Self::steady) about a state that an iteration found.
    pub(super) fn at<Sys: Linearize<N, Scalar = f64>, const N: usize>(
        system: &Sys,
        at: &State<f64, N>,
    ) -> Result<Self, AnalysisError> {
        smooth(system, at, 0.0, linearized)?;
        let [_, m, c, k] = linearized(system, at);
        let [_, beside @ ..] = linearized(system, &next(at));
        let small = Self::named(m, c, k, coordinate_names::<Sys, N>())?.blurred(beside);
        Ok(small.conservative(Sys::FACTS.conservative))
    }

    /// Small deviations from the motion through any state, as they begin: `C = −M ∂q̈/∂q̇` and `K = −M ∂q̈/∂q` from the
    /// emitted Jacobian. Where the motion is accelerated or time appears, the matrices hold at that moment only.
    ///
    /// # Hypotheses
    /// - M is positive definite.
    /// - The state is not on a switch of the forces at which these or their derivatives jump.
    /// - With constraints: the state is on them, they are independent there, and coordinates whose velocities alone
    ///   follow from others do not act on these. `C = −M ∂ẅ/∂ẇ` and `K = −M ∂ẅ/∂w` are in the coordinates of
    ///   [`SmallMotion::names`].
    ///
    /// # Errors
    /// Those of [`SmallMotion::steady`].
    pub fn about<Sys: Lagrangian<N, Scalar = f64>, const N: usize>(
        system: &Sys,
        at: &State<f64, N>,
    ) -> Result<Self, AnalysisError> {
        second_order::<Sys, N>()?;
        let look = |system: &Sys, at: &State<f64, N>| {
            let jacobian = system.jacobian(&at.q, &at.qd, at.t);
            let [m, c, k] = [system.inertia(&at.q, &at.qd, at.t), -jacobian.qd, -jacobian.q]
                .map(|a| DMatrix::from_fn(N, N, |i, j| a[(i, j)]));
            let forces = -&m * DVector::from_column_slice(system.accel(&at.q, &at.qd, at.t).as_slice());
            let [c, k] = [&m * c, &m * k];
            [DMatrix::from_column_slice(N, 1, forces.as_slice()), m, c, k]
        };
        if !Sys::FACTS.constraints.is_empty() {
            let small = constrained::about(system, at)?;
            return smooth(system, at, 0.0, look).map(|()| small);
        }
        let [_, m, c, k] = look(system, at);
        Self::new(m.clone(), DMatrix::zeros(N, N), DMatrix::zeros(N, N))?;
        smooth(system, at, 0.0, look)?;
        Self::named(m, c, k, coordinate_names::<Sys, N>())
    }

    /// Number n of coordinates.
    pub fn dimension(&self) -> usize {
        self.m.nrows()
    }

    /// Names of the n coordinates, in the order of rows and columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Velocities of all N coordinates of the system by those of these n, `δq̇ = B δẇ`, N × n: a basis of what
    /// constraints on velocities and positions admit at the state. The unit matrix where the coordinates are
    /// independent. With constraints on positions alone it is the same for displacements.
    pub fn basis(&self) -> &DMatrix<f64> {
        &self.basis
    }

    /// Names of coordinates whose velocities follow from the others by constraints on velocities. Their deviations
    /// follow but for a constant each, as equilibria and steady motions of such systems come in families: so many
    /// roots are 0, which [`SmallMotion::spectrum`] leaves out.
    pub fn constants(&self) -> &[String] {
        &self.constants
    }

    /// M, `n × n`: kg of lengths, kg m² of angles.
    pub fn inertia(&self) -> &DMatrix<f64> {
        &self.m
    }

    /// C, `n × n`, damping and gyroscopic terms together: N s/m of lengths, N m s of angles.
    pub fn velocity_terms(&self) -> &DMatrix<f64> {
        &self.c
    }

    /// K, `n × n`, with its circulatory part: N/m of lengths, N m of angles.
    pub fn stiffness(&self) -> &DMatrix<f64> {
        &self.k
    }

    /// Damping matrix, `n × n`, the symmetric part of C.
    pub fn damping(&self) -> DMatrix<f64> {
        symmetric(&self.c)
    }

    /// Gyroscopic matrix G, `n × n`, the antisymmetric part of C.
    pub fn gyroscopic(&self) -> DMatrix<f64> {
        antisymmetric(&self.c)
    }

    /// Circulatory matrix, `n × n`, the antisymmetric part of K: forces without a potential.
    pub fn circulatory(&self) -> DMatrix<f64> {
        antisymmetric(&self.k)
    }

    /// Natural frequencies and mode shapes of `M δq̈ + K δq = 0`: damping is left out.
    ///
    /// # Hypotheses
    /// - C has no gyroscopic part, and K no circulatory one.
    ///
    /// # Errors
    /// [`AnalysisError::Gyroscopic`] and [`AnalysisError::Circulatory`], whose modes are not real.
    pub fn modes(&self) -> Result<Modes, AnalysisError> {
        let largest = self.gyroscopic().amax();
        if largest > 0.0 {
            return Err(AnalysisError::Gyroscopic { largest });
        }
        self.modes_of_potential()
    }

    /// Eigenvalues and complex shapes of the full equations, damping, gyroscopic and circulatory terms included.
    ///
    /// # Hypotheses
    /// Those of [`Spectrum`].
    ///
    /// # Errors
    /// [`AnalysisError::NotConverged`], [`AnalysisError::NotFinite`].
    pub fn spectrum(&self) -> Result<Spectrum, AnalysisError> {
        if self.c.amax() == 0.0 && self.circulatory().amax() == 0.0 {
            return Ok(spectrum::undamped(&self.modes_of_potential()?));
        }
        spectrum::spectrum(self)
    }

    pub(super) fn modes_of_potential(&self) -> Result<Modes, AnalysisError> {
        let largest = self.circulatory().amax();
        match largest > 0.0 {
            true => Err(AnalysisError::Circulatory { largest }),
            false => modes::modes(self),
        }
    }

    /// Steady response to a harmonic force: the complex amplitudes `x = (K + iωC − ω²M)⁻¹ f` of `δq = Re(x e^{iωt})`
    /// for the force `Re(f e^{iωt})` (frequency response; Meirovitch, *Fundamentals of Vibrations*, 2001, 7.12). Here
    /// ω = `omega` is in rad/s, `force` has the n generalized forces f, and the n entries of x are in the units of the
    /// coordinates.
    ///
    /// # Hypotheses
    /// - The matrix is regular, to rounding of its terms: otherwise [`AnalysisError::Resonance`].
    /// - Free motions decay, for others to end in this one. That is not checked; [`Spectrum::growth`] says it.
    ///
    /// # Errors
    /// [`AnalysisError::Resonance`] where the matrix is singular; [`AnalysisError::NotFinite`] where frequency,
    /// force, a term of the matrix or the response is not finite; [`AnalysisError::Dimension`].
    ///
    /// ```
    /// use lagrange_runtime::analysis::{Complex, DMatrix, DVector, SmallMotion};
    /// let [m, c, k] = [1.1, 0.5, 7.0].map(|x| DMatrix::from_element(1, 1, x));
    /// let x = SmallMotion::new(m, c, k)?.frequency_response(1.9, &DVector::from_element(1, Complex::new(1.4, 0.0)))?;
    /// assert!((x[0].norm() - 1.4 / (7.0f64 - 1.1 * 1.9 * 1.9).hypot(0.5 * 1.9)).abs() < 1e-15);
    /// # Ok::<(), lagrange_runtime::analysis::AnalysisError>(())
    /// ```
    pub fn frequency_response(
        &self,
        omega: f64,
        force: &DVector<Complex<f64>>,
    ) -> Result<DVector<Complex<f64>>, AnalysisError> {
        let n = self.dimension();
        if force.len() != n {
            return Err(AnalysisError::Dimension { expected: n, found: force.len() });
        }
        if !(omega.is_finite() && force.iter().all(|f| f.re.is_finite() && f.im.is_finite())) {
            return Err(AnalysisError::NotFinite);
        }
        let dynamic = DMatrix::from_fn(n, n, |i, j| {
            Complex::new(self.k[(i, j)] - omega * omega * self.m[(i, j)], omega * self.c[(i, j)])
        });
        // In units in which the terms of all coordinates are of one size.
        let sizes = self.k.abs() + self.m.abs() * (omega * omega) + self.c.abs() * omega.abs();
        if sizes.iter().any(|x| !x.is_finite()) {
            return Err(AnalysisError::NotFinite);
        }
        let (rows, columns) = equilibrated(sizes);
        let factors = DMatrix::from_fn(n, n, |i, j| dynamic[(i, j)] * rows[i] * columns[j]).lu();
        let u = factors.u();
        let smallest = (0..n).map(|i| u[(i, i)].norm()).fold(f64::INFINITY, f64::min);
        if smallest <= n as f64 * f64::EPSILON {
            return Err(AnalysisError::Resonance { omega });
        }
        let force = DVector::from_fn(n, |i, _| force[i] * rows[i]);
        let response = factors.solve(&force).ok_or(AnalysisError::Resonance { omega })?;
        let response = DVector::from_fn(n, |i, _| response[i] * columns[i]);
        match response.iter().all(|x| x.re.is_finite() && x.im.is_finite()) {
            true => Ok(response),
            false => Err(AnalysisError::NotFinite),
        }
    }

    /// `L⁻¹ a L⁻ᵀ` with `M = L Lᵀ`: in the coordinates `Lᵀ δq` the inertia matrix is 1.
    pub(super) fn reduced(&self, a: &DMatrix<f64>) -> DMatrix<f64> {
        let half = self.forward(a.clone());
        self.forward(half.transpose()).transpose()
    }

    /// `M⁻¹`
    pub(super) fn inverse(&self) -> DMatrix<f64> {
        let half = self.forward(DMatrix::identity(self.dimension(), self.dimension()));
        half.transpose() * half
    }

    /// L of `M = L Lᵀ`.
    pub(super) fn lower(&self) -> &DMatrix<f64> {
        &self.lower
    }

    /// `L⁻¹ a`
    fn forward(&self, mut a: DMatrix<f64>) -> DMatrix<f64> {
        for mut column in a.column_iter_mut() {
            for i in 0..column.len() {
                for j in 0..i {
                    column[i] -= self.lower[(i, j)] * column[j];
                }
                column[i] /= self.lower[(i, i)];
            }
        }
        a
    }

    /// `L⁻ᵀ y`: back from the coordinates in which the inertia matrix is 1.
    pub(super) fn restored<T: nalgebra::ComplexField<RealField = f64>>(&self, y: &DVector<T>) -> DVector<T> {
        let (l, n) = (&self.lower, y.len());
        let mut x = y.clone();
        for i in (0..n).rev() {
            for j in i + 1..n {
                let part = x[j].clone().scale(l[(j, i)]);
                x[i] -= part;
            }
            x[i] = x[i].clone().unscale(l[(i, i)]);
        }
        x
    }

    /// Accelerations of small motions without forces.
    pub(super) fn acceleration(&self, q: &DVector<f64>, qd: &DVector<f64>) -> DVector<f64> {
        let force = -(&self.k * q + &self.c * qd);
        let half = self.forward(DMatrix::from_column_slice(force.len(), 1, force.as_slice()));
        self.restored(&half.column(0).into_owned())
    }
}

/// `M = L Lᵀ`, refused where M is singular but for rounding, in whatever units.
fn factored(m: &DMatrix<f64>) -> Result<DMatrix<f64>, AnalysisError> {
    let n = m.nrows();
    let scale = DVector::from_fn(n, |i, _| if m[(i, i)] > 0.0 { 1.0 / m[(i, i)].sqrt() } else { 1.0 });
    let scaled = DMatrix::from_fn(n, n, |i, j| 0.5 * (m[(i, j)] + m[(j, i)]) * scale[i] * scale[j]);
    let eigen = SymmetricEigen::try_new(scaled, f64::EPSILON, 1000 * n).ok_or(AnalysisError::NotFinite)?;
    let (place, eigenvalue) = eigen
        .eigenvalues
        .iter()
        .copied()
        .enumerate()
        .fold((0, f64::INFINITY), |least, next| if next.1 < least.1 { next } else { least });
    let refused = || {
        let coordinate = Coordinate::unnamed(eigen.eigenvectors.column(place).iamax());
        AnalysisError::Inertia { eigenvalue, coordinate }
    };
    if eigenvalue <= n as f64 * f64::EPSILON {
        return Err(refused());
    }
    symmetric(m).cholesky().map(|factors| factors.l()).ok_or_else(refused)
}

/// Rounding error of the entry (i, j) of a matrix, by the largest entries of its row and its column: stiff
/// coordinates do not hide forces between soft ones.
fn rounding(a: &DMatrix<f64>) -> impl Fn(usize, usize) -> f64 {
    let size: Vec<f64> = (0..a.nrows()).map(|i| a.row(i).amax().max(a.column(i).amax()).sqrt()).collect();
    move |i, j| ROUNDING * size[i] * size[j]
}

/// Without entries of the symmetric and antisymmetric parts that are rounding errors.
fn cleaned(a: &DMatrix<f64>) -> DMatrix<f64> {
    let (even, odd, rounding) = (symmetric(a), antisymmetric(a), rounding(a));
    DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| {
        match (even[(i, j)].abs() <= rounding(i, j), odd[(i, j)].abs() <= rounding(i, j)) {
            _ if i == j => a[(i, j)],
            (false, false) => a[(i, j)],
            (true, false) => odd[(i, j)],
            // Where both are, no gyroscopic or circulatory force is made of what may be the rounding of a 0.
            (_, true) => even[(i, j)],
        }
    })
}
