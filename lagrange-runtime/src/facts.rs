//! Facts that the compiler found out about a system.

/// Facts that the compiler proved about a system. `false` means "not proved", never "disproved".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Facts {
    /// Name of the system.
    pub name: &'static str,
    /// Names of the generalized coordinates, in the order of every vector, and then those of the [states of first
    /// order](crate::traits::States).
    pub coordinates: &'static [&'static str],
    /// Kind of each coordinate, as declared; empty where nothing is known.
    pub kinds: &'static [CoordinateKind],
    /// Names of the inputs, in the order of every vector of them. What the other facts say of the motion holds while
    /// inputs are held.
    pub inputs: &'static [&'static str],
    /// Time does not appear in the kinematics: no prescribed coordinate, no explicit t in L.
    pub scleronomic: bool,
    /// Time does not appear in the equations of motion: neither in M, nor in `f − b`, nor in the constraints.
    pub autonomous: bool,
    /// `h = p·q̇ − L` is conserved, if functions of the program (`extern fn`) are continuous.
    pub conservative: bool,
    /// The forces besides those of L are `−C q̇` with a constant matrix C, and time does not appear in L: h changes
    /// at the rate `−q̇ᵀC q̇`, as it does with a dissipation function of constant coefficients.
    pub linear_damping: bool,
    /// Coordinates (by index) that appear in neither L, D nor Q and whose momenta are conserved.
    pub ignorable: &'static [usize],
    /// Constant inertia, and forces that do not depend on the velocities.
    pub separable: bool,
    /// The inertia matrix does not depend on the state.
    pub constant_inertia: bool,
    /// L is quadratic in the velocities.
    pub quadratic: bool,
    /// `f − b` is a polynomial of degree 2 at most in the velocities: L is quadratic in them, and so are `Q − ∂D/∂q̇`.
    pub quadratic_forces: bool,
    /// Linear equations of motion with constant coefficients, `M q̈ + C q̇ + K q = f(t)`.
    pub linear: bool,
    /// The motion has Taylor series wherever the accelerations have derivatives: recurrences are emitted for them,
    /// and there are no choices (`if`, `abs`, …). Where the argument of a root vanishes, as that of `v.norm()` does
    /// at rest, the motion has one-sided series at most: [`Taylor`](const@crate::Taylor) makes the step from there by
    /// collocation.
    pub analytic: bool,
    /// Groups of coordinates that move independently of each other.
    pub blocks: &'static [&'static [usize]],
    /// Groups of coordinates in an order in which each is driven by those before it at most: their accelerations
    /// depend on time, on coordinates and velocities of the own group, and on those of groups before it. More groups
    /// than blocks are a coupling in one way: the first ones may be computed without the others, and what they do to
    /// these is given.
    pub cascade: &'static [&'static [usize]],
    /// Dimensionless groups of the parameters: products of powers, by name and exponent. Systems that agree in all of
    /// them have the same motions but for units, so a study has to vary these alone (Buckingham, Phys. Rev. 4 (1914)
    /// 345). Numbers in the text of the system count as dimensionless. Each parameter is a group where the compiler
    /// does not know better, as in systems of tens of thousands of operations.
    pub dimensionless_groups: &'static [&'static [(&'static str, i32)]],
    /// Changes of scale that take motions to motions of the same system.
    pub similarities: &'static [Similarity],
    /// Its constraints, in the order of the multipliers.
    pub constraints: &'static [Constraint],
    /// Dependence of constraints on others, if there is one: then multipliers are those of least norm.
    pub redundancy: Option<Redundancy>,
    /// Names of its prescribed coordinates, in the order of the reactions.
    pub prescribed: &'static [&'static str],
    /// Operations of one call of `accel`.
    pub operations: Operations,
}

impl Facts {
    /// Independent velocities: coordinates less independent constraints. Where their rank is known only at run time,
    /// 0 if there may be none. States of first order are none of them.
    pub const fn degrees_of_freedom(&self) -> usize {
        let rank = match self.redundancy {
            Some(Redundancy { rank: Some(rank), .. }) => rank,
            _ => self.constraints.len(),
        };
        (self.coordinates.len() - self.states()).saturating_sub(rank)
    }

    /// Number of states of first order, which are the last of the coordinates.
    pub const fn states(&self) -> usize {
        let (mut states, mut i) = (0, 0);
        while i < self.kinds.len() {
            if let CoordinateKind::State = self.kinds[i] {
                states += 1;
            }
            i += 1;
        }
        states
    }

    /// Nothing is known.
    pub const UNKNOWN: Facts = Facts {
        name: "",
        coordinates: &[],
        kinds: &[],
        inputs: &[],
        scleronomic: false,
        autonomous: false,
        conservative: false,
        linear_damping: false,
        ignorable: &[],
        separable: false,
        constant_inertia: false,
        quadratic: false,
        quadratic_forces: false,
        linear: false,
        analytic: false,
        blocks: &[],
        cascade: &[],
        dimensionless_groups: &[],
        similarities: &[],
        constraints: &[],
        redundancy: None,
        prescribed: &[],
        operations: Operations { additions: 0, multiplications: 0, divisions: 0, sin_cos: 0, functions: 0 },
    };
}

/// A change of scale that takes each motion to another one, with the same parameters: time by λ^`time`, and coordinate
/// i by a power of λ, as [`State::scaled`](crate::State::scaled) does. Kepler's third law is one, time 3 and distance
/// 2 (Landau and Lifshitz, *Mechanics*, 3rd ed. 1976, §10).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Similarity {
    /// Exponent of time.
    pub time: i32,
    /// Exponents of the coordinates.
    pub coordinates: &'static [i32],
}

/// A constant component of the angular momentum of a rotation that is a coordinate: a first integral by Noether's
/// theorem, where neither L nor forces, dissipation and constraints change as the rotation alone is turned further
/// about an axis of its parent (a free body: all three; a heavy one on a joint: the vertical), or about an axis of
/// its own (a symmetric top). The system has the momentum as an output, `angular_momentum_R`, in the axes of the
/// parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Symmetry {
    /// Name of the rotation.
    pub rotation: &'static str,
    /// Index of its first coordinate.
    pub first: usize,
    /// Number of the axis: 0, 1, 2 for x, y and z.
    pub axis: usize,
    /// Is it an axis of the turned body, and not of the parent?
    pub own: bool,
}

/// A constant component of the angular momentum of rotations, directions and positions that turn together: a first
/// integral by Noether's theorem, where neither L nor forces, dissipation and constraints change as they are turned
/// about an axis of the world, each about its origin. (A rotation in another frame than the world turns about the axis
/// of that frame.) Positions are arrays of three coordinates. The system has the momenta as an output,
/// `common_angular_momenta`, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct CommonSymmetry {
    /// Names of the parts that turn together.
    pub turned: &'static [&'static str],
    /// Number of the axis: 0, 1, 2 for x, y and z.
    pub axis: usize,
}

/// Kind of a coordinate: `coord theta: angle, x: length, R: rotation, s;`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum CoordinateKind {
    /// An angle in radians. It grows through whole turns while a system is integrated;
    /// [`State::wrapped`](crate::State::wrapped) shows it between −π and π.
    Angle,
    /// A length.
    Length,
    /// One of the three parameters of a rotation, see [`lagrangian!`](crate::lagrangian).
    Rotation,
    /// One of the three components of a unit vector, see [`lagrangian!`](crate::lagrangian).
    Direction,
    /// Nothing in particular.
    #[default]
    Plain,
    /// The time integral of a [state of first order](crate::traits::States), whose velocity is the state. Nothing
    /// depends on it.
    State,
}

/// Operations of a straight-line function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Operations {
    /// Additions and subtractions.
    pub additions: usize,
    /// Multiplications.
    pub multiplications: usize,
    /// Divisions.
    pub divisions: usize,
    /// Sine–cosine pairs.
    pub sin_cos: usize,
    /// Other elementary functions.
    pub functions: usize,
}

impl Operations {
    /// `+ − × ÷` together.
    pub const fn arithmetic(&self) -> usize {
        self.additions + self.multiplications + self.divisions
    }
}

/// A constraint of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Constraint {
    /// Its name.
    pub name: &'static str,
    /// Kind of the restriction.
    pub kind: ConstraintKind,
    /// An input appears in it: what it admits changes with the input.
    pub has_input: bool,
}

/// Constraints of which some follow from others wherever all of them hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Redundancy {
    /// Number of independent ones in all positions but singular ones, in that of the assemblies that the compiler found
    /// from arbitrary places which has the fewest freedoms; `None` if it depends on the parameters. At run time pivots
    /// find more where there are more: in a scissors lift with both bars of each stage on each other fewer are
    /// independent than in the lift.
    pub rank: Option<usize>,
    /// Names of those whose multipliers, and so the reactions of their joints, are not determined.
    pub undetermined: &'static [&'static str],
    /// Sets of constraints that may be left out, as many as there are too many; not all where there are thousands.
    pub superfluous: &'static [&'static [&'static str]],
}

/// Kind of a constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub enum ConstraintKind {
    /// Positions: `f(q, t) = 0`.
    Holonomic,
    /// Velocities, but so that it follows from a relation between positions (Frobenius' theorem), which its start
    /// fixes.
    Integrable,
    /// Velocities, and no relation between positions follows.
    Nonholonomic,
}
