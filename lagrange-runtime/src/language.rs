//! The macro and its reference.

/// Compiles a mechanical system, written as its energies and forces, to a type with its equations of motion.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A block on a spring, dragged through air; a pendulum hangs from it.
///     pub system Crane {
///         /// Mass of the block.
///         param M;
///         param m, l, k, c, g = 9.81;
///         coord x, theta;
///
///         let tip_x = x + l * theta.sin();
///         let tip_y = -l * theta.cos();
///
///         T = 0.5 * M * dot(x).powi(2) + 0.5 * m * (dot(tip_x).powi(2) + dot(tip_y).powi(2));
///         V = 0.5 * k * x.powi(2) + m * g * tip_y;
///         D = 0.5 * c * dot(x).powi(2);
///         observe tip = [tip_x, tip_y];
///     }
/// }
///
/// let crane = Crane { c: 0.2, ..Crane::new(5.0, 1.0, 2.0, 40.0, 0.0) };
/// let (q, qd) = ([0.1, 0.5].into(), [0.0, 0.0].into());
/// let qdd = crane.accel(&q, &qd, 0.0);
/// let residual = crane.inertia(&q, &qd, 0.0) * qdd + crane.convective_momentum_rate(&q, &qd, 0.0) - crane.momentum_rate(&q, &qd, 0.0);
/// assert!(residual.amax() < 1e-14 * crane.momentum_rate(&q, &qd, 0.0).amax());
/// assert_eq!(crane.tip(&q, &qd, 0.0)[0], 0.1 + 2.0 * 0.5f64.sin());
/// ```
///
/// # What is generated
///
/// `pub struct Name<S = f64>` with the parameters and inputs as public fields; `Name::new` of those that have no
/// default, as `f64`; [`Default`] if all have one; `map`, which puts other numbers (lanes, [`Dual`](crate::Dual)s,
/// `f32`) into the parameters. For every [`Scalar`](crate::Scalar) `S` it implements [`System`](crate::System) and
/// [`Lagrangian`](crate::Lagrangian), [`Energies`](crate::Energies) if T and V were given,
/// [`LegendreTransform`](crate::traits::LegendreTransform) if L is quadratic in the velocities, and the markers that
/// were proved ([`Separable`](crate::traits::Separable), [`Conservative`](crate::traits::Conservative), …). With
/// constraints it implements [`Constrained`](crate::Constrained), with prescribed coordinates
/// [`Prescribed`](crate::traits::Prescribed), with inputs [`Inputs`](crate::Inputs) and
/// [`InputJacobian`](crate::traits::InputJacobian), with states of first order [`States`](crate::traits::States).
/// Facts about the motion hold while inputs are constant. Its documentation shows L, the equations of motion and
/// all facts found.
///
/// # Statements
///
/// | Statement | Meaning |
/// |---|---|
/// | `const N = 8;` | an integer for lengths and ranges |
/// | `param m, g = 9.81, k: [N];` | parameters, with optional defaults and lengths |
/// | `param R: rotation;` | a rotation that is given to `new`, in axes that are measured: by [`rotation::by_matrix`](crate::traits::rotation::by_matrix), which checks that the matrix is orthonormal, or [`rotation::by_quaternion`](crate::traits::rotation::by_quaternion); in expressions a [rotation](#frames-and-rigid-bodies) |
/// | `input u, tau: [N] = 0;` | [inputs](#inputs), 0 by default: held within a step, changed between steps ([`Stepper`](crate::Stepper)); `∂q̈/∂u` is emitted |
/// | `coord theta, x: [N];` | generalized coordinates, in the order of all vectors |
/// | `coord theta: angle, r: length, phi: [angle; N];` | the same with what they measure, for display: [`State::wrapped`](crate::State::wrapped) |
/// | `coord R: rotation, P: [rotation; N];` | attitudes in space without singular ones, of three [parameters](#rotations-as-coordinates) each; read and set as quaternions by `attitude_R(&state)`, `angular_velocity_R(&state)`, `angular_acceleration_R(&state)` and `with_attitude_R(state, &attitude, &omega)` (of arrays with an index first) |
/// | `coord n: direction, p: [direction; N];` | points of the unit sphere: [vectors of length 1](#directions-as-coordinates) with two degrees of freedom each; read and set by `direction_n(&state)` and `with_direction_n(state, &direction, &velocity)` (of arrays with an index first) |
/// | `coord phi = omega * t;` | a prescribed coordinate: a given motion, no unknown; what enforces it is `reaction(phi)` |
/// | `state i: [M] = 0; rate(i) = …;` | [states](#states) of first order, ż = r(q, q̇, z, t), beside the coordinates, with their values at the start |
/// | `let y = -l * theta.cos();` | kinematics; equations are formed in terms of it, so name what repeats |
/// | `let touches = y < 0;` | a condition with a name, for `if touches { … } else { … }` |
/// | `let y: [N] = \|i\| …;` | an indexed family; element `i` may use `y[i - 1]` |
/// | `fn gust(s) = a * (-s * s).exp();` | a function |
/// | `extern fn mu(t);` | a Rust function `fn mu<S: Scalar>(t: S) -> S` in scope, continuous with continuous derivatives; these are taken by duals |
/// | `extern wind: Curve(t);` | a function with data: a field `wind` of this type, given with the value of the system, which is an [`ExternFunction`](crate::traits::ExternFunction): a measured curve, a map of two arguments (`Surface`), or a type of the program |
/// | `T = …; V = …;` | kinetic and potential energy, `L = T − V` |
/// | `L = …;` | the Lagrangian whole, instead of T and V, where V depends on velocities |
/// | `D = …;` | Rayleigh's dissipation function: a quadratic form in the velocities; the force is `−∂D/∂q̇` |
/// | `Q[theta] = …;` | nonconservative generalized force, any expression; `Q[R] = [Mx, My, Mz];` of a rotation moments about the turned axes |
/// | `force [fx, fy] at [x, y];` | an applied force, by virtual work: `Qₖ += F·∂x/∂qₖ` |
/// | `couple [mx, my, mz] on link;` | an applied couple, in the axes of a frame; in the plane `couple M on link;` |
/// | `constraint rod: x * x + y * y == l * l;` | a constraint between positions, or, linear in them, between velocities; arrays make several, and so does a family, `constraint rods: [N] = \|i\| … == …;` |
/// | `impulse blow at [x, y];` | where impulses act: a method that gives the generalized impulse `Pₖ = F̂·∂x/∂qₖ` of one, for [`jump`](crate::Impulsive::jump) |
/// | `observe tip = [x, y];` | a named output, a method of the type; of rows, `[[a, b], [c, d]]`, a matrix |
/// | `redundant constraint c: …;` | a constraint that may follow from others; without the word, the compiler warns where one does |
/// | `event ground: y, falling, terminal;` | an [event](#events): where a function of the state passes zero, the constant `GROUND` of the type |
/// | `observe R = reaction(phi);` | the generalized force that enforces a prescribed motion, or the multiplier of a constraint |
/// | `pub routhian Reduced;` | a second type: the system without its ignorable coordinates |
/// | `pub restriction Planar: phi = 0, x = [0, a];` | a further type: the system with [coordinates held](#coordinates-that-are-held), exact |
/// | `pub simplified Small: neglect m2, expand theta to 2 about 0;` | a further type: a system with [simpler energies](#simpler-energies) |
///
/// # Rotations as coordinates
///
/// `coord R: rotation;` is an attitude in space without singular ones. A [`State`](crate::State) has three numbers for
/// it:
///
/// | what | is |
/// |---|---|
/// | R | takes components in the turned axes to those in the axes that they are turned in: `x_parent = R x`, its columns are the turned axes |
/// | quaternion | of Hamilton, `q = w + i x + j y + k z` with `x_parent = q x q*`, as nalgebra's `q * x`; `UnitQuaternion` keeps it as (x, y, z, w) |
/// | sign | q and −q are the same attitude; the functions that read an attitude return w ≥ 0 where \|σ\| ≤ 1 |
/// | products | `A * B` turns by B in the axes that A has turned |
/// | angular velocity ω | of the turned axes in those that they are turned in, by its components in the turned axes ("body axes"): Ṙ = R \[ω\]×; `R * ω` are those in the axes of the parent |
/// | coordinates | Rodrigues' modified parameters σ = n tan(θ/4) of a turn by θ about the unit vector n |
/// | velocities | σ̇ |
///
/// nalgebra converts a [`UnitQuaternion`](crate::traits::UnitQuaternion) from and to an axis with an angle and a
/// matrix, and [`EulerAngles`](crate::traits::rotation::EulerAngles) Euler's angles in any order of axes.
///
/// σ and −σ/|σ|² are the same attitude. A run may change between them after a step, never within one: compare
/// attitudes, not parameters. An event on a parameter also occurs where it jumps, so make events of the attitude, such
/// as `R * [1, 0, 0]`. Near R = 1 a parameter is a quarter of an angle in rad, and so are derivatives by it: the rows
/// of B that belong to σ̇ are a quarter of those that belong to ω.
///
/// # Directions as coordinates
///
/// `coord n: direction;` is a point of the unit sphere: the rod of a spherical pendulum, the axis of a top, a line of
/// sight. In expressions it is a vector, `n[2]`, `l * n`, `n.cross([0, 0, 1])`, and `dot(n)` is its velocity. It has
/// two degrees of freedom and no poles.
///
/// | what | is |
/// |---|---|
/// | coordinates | the three components of n, whose length a run keeps at 1 to rounding: a constraint ½ (n·n − 1) = 0, which [`Facts`](crate::Facts) lists as `n` |
/// | velocities | ṅ, across n |
/// | `reaction(n)` | λ, the force λ n that keeps its length; of `let bob = l * n;` the rod has the thrust λ/l |
/// | `Q[n] = [Fx, Fy, Fz];` | a generalized force, which does the work F·ṅ; what it has along n does none |
///
/// Methods are those of systems with [constraints](#constraints): all on (q, q̇), in lanes, with Taylor series,
/// events and all analysis in two degrees of freedom; those on (q, p) are a compile error but for
/// [`ConstrainedMidpoint`](crate::method::variational::ConstrainedMidpoint).
///
/// # Frames and rigid bodies
///
/// Bodies are written as in a textbook: a frame for each, and its kinetic energy. A value of the language can be a
/// frame or a rotation:
///
/// | Expression | Meaning |
/// |---|---|
/// | `world` | the axes at rest |
/// | `rotation_x(a)`, `rotation_y(a)`, `rotation_z(a)` | the rotation by an angle about an axis; any expression of coordinates and time |
/// | `rotation([nx, ny, nz], a)` | about an axis of parameters and numbers, of any length |
/// | `rotation([[…], […], […]])` | by a matrix of numbers, `x_parent = R x` |
/// | `R`, of `coord R: rotation;` or `param R: rotation;` | a rotation with three degrees of freedom, or one that is a parameter |
/// | `dot(R)` | of any rotation: angular velocity of the turned axes in those that they are turned in, by three components in the turned axes |
/// | `A * B`, `A.inverse()`, `A * [x, y, z]` | first A, then B about the axes that A has turned: Euler's angles are `rotation_z(psi) * rotation_x(theta) * rotation_z(phi)` |
/// | `frame(parent, [x, y, z], rotation)` | axes at a point of the parent, turned in it; without a rotation they stay parallel. The point may move |
/// | `frame(parent, [x, y], angle)` | the same in the plane |
/// | `link.point([x, y, z])`, `link.origin()` | coordinates in the world of a point given in the frame |
/// | `link.vector([x, y, z])` | components in the world of a vector given in the axes of the frame |
/// | `angular_velocity(link)` | ω in the axes of the frame; in the plane a number |
/// | `velocity(link)` | velocity of the origin, in the axes of the frame; in those of the world it is `dot(link.origin())` |
/// | `body(m, I, link)` | ½ m v² + ½ ω·I ω, the mass centre in the origin, I about it in the axes of the frame: `[Ixx, Iyy, Izz]` or a symmetric matrix `[[Ixx, Ixy, Ixz], …]`; in the plane one number |
/// | `particle(m, link)` | ½ m v² of a mass in the origin |
/// | `force F at link;` | a force in the axes of the frame, at its origin; `force F at link.point([…]);` has its components in the world |
/// | `couple M on link;` | a couple in the axes of the frame |
///
/// A body whose mass centre lies elsewhere has it at `frame(link, [x, y, z])`. These words are ordinary names: a
/// `let body = …;` of the system hides the built-in one. Equations are formed at the velocities of the frames
/// (Euler–Poincaré), not in angles, so that a chain of bodies costs what the recursive algorithms of robotics cost.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A top on its point, with a rotor of its own on the axis that a motor drives.
///     pub system Top {
///         param m, l, A, C, rotor, torque, g = 9.81;
///         coord psi: angle, theta: angle, phi: angle, spin: angle;
///         let top = frame(world, [0, 0, 0], rotation_z(psi) * rotation_x(theta) * rotation_z(phi));
///         let centre = frame(top, [0, 0, l]);
///         let wheel = frame(centre, [0, 0, 0], rotation_z(spin));
///         T = body(m, [A, A, C], centre) + body(m, [rotor / 2, rotor / 2, rotor], wheel);
///         V = 2 * m * g * centre.origin()[2];
///         couple [0, 0, torque] on wheel;
///         couple [0, 0, -torque] on top;
///         observe tip = top.point([0, 0, 2 * l]);
///     }
/// }
///
/// let top = Top::new(0.3, 0.1, 1e-4, 2e-4, 1e-4, 0.0);
/// let start = State::new(0.0, [0.0, 0.4, 0.0, 0.0], [0.0, 0.0, 200.0, 0.0]);
/// let end = integrate(&top, Dop853, PiController::tolerance(1e-10), start).until(1.0).final_state()?;
/// let energy = |s: &State<f64, 4>| top.energy(&s.q, &s.qd, s.t);
/// assert!((energy(&end) - energy(&start)).abs() < 1e-7 * energy(&start));
/// assert!((top.tip(&end.q, &end.qd, end.t).norm() - 0.2).abs() < 1e-12);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// # Constraints
///
/// Independent coordinates are best: they make the smallest system. Where they are awkward, write the constraints.
/// Their multipliers λ give the generalized forces `λ ∂f/∂q` (of a constraint on velocities `λ ∂f/∂q̇`), a run stays
/// on them to rounding, and [`consistent`](crate::consistent()) finds a start that satisfies them:
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A skate on an inclined plane, which glides along its heading φ and does not slip across it.
///     pub system Skate {
///         param m, I, alpha, g = 9.81;
///         coord x, y, phi;
///         T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2)) + 0.5 * I * dot(phi).powi(2);
///         V = -m * g * sin(alpha) * x;
///         constraint blade: dot(x) * phi.sin() == dot(y) * phi.cos();
///         observe grip = reaction(blade);
///     }
/// }
/// let skate = Skate::new(1.0, 0.2, 0.3);
/// assert_eq!(Skate::<f64>::FACTS.constraints[0].kind, ConstraintKind::Nonholonomic);
/// let start = State::new(0.0, [0.0; 3], [0.0, 0.0, 2.0]);
/// let end = integrate(&skate, Dop853, PiController::tolerance(1e-10), start).until(10.0).final_state()?;
/// // It does not go downhill for long: x = g sin α sin² φ / (2 φ̇²).
/// let x = 9.81 * 0.3f64.sin() * 20f64.sin().powi(2) / (2.0 * 4.0);
/// assert!((end.q[0] - x).abs() < 1e-8);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// # States
///
/// `state i;` is a value with an equation of first order, `rate(i) = …;`: the current of a motor, a filter, the
/// integrator of a controller, a temperature. V, D, Q, forces, rates and outputs may depend on it, as on time; T,
/// places and constraints may not. It is also an output under its name; [`States`](crate::traits::States) documents its
/// place in a [`State`](crate::State).
///
/// # Inputs
///
/// An input is constant between changes: `dot(u)` is 0, as for a parameter. When it changes, positions and velocities
/// stay as they are, and momenta and energy jump if T depends on it. This models a change without an impulse, such as a
/// mass that is added with the velocity of the body. If the momentum is conserved instead, set the velocities as well
/// ([`Stepper::set_state`](crate::Stepper::set_state)). A reduced system of `routhian Reduced;` has the momentum for a
/// parameter and keeps it: after a change of an input in T, the whole system and the reduced one are two different
/// motions.
///
/// # Events
///
/// `event name: g;` names a function g(q, q̇, t) of the parameters and inputs, whose roots are events. It is compiled
/// with its derivatives ġ and, where g depends on positions and time alone, g̈ along a motion, by which a run proves
/// that there is no event in a step. `rising` or `falling` after g choose a direction, `terminal` ends a run there, in
/// any order; an event without a direction occurs in both. The type has the constant `NAME`, an [`Event`](crate::Event)
/// as one that is made of a closure; an array of functions makes an array of events, `WALLS[0]`. The value of g at a
/// state is `Name::NAME.value(&system, &state)`. A reduced system has those events that do not depend on the ignorable
/// coordinates. g may use `reaction(…)`: where a rope goes slack, the multiplier of its constraint passes zero.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A ball that is thrown at a wall.
///     pub system Ball {
///         param m, wall, g = 9.81;
///         coord x, y;
///         T = 0.5 * m * (dot(x).powi(2) + dot(y).powi(2));
///         V = m * g * y;
///         /// It lands.
///         event ground: y, falling, terminal;
///         event apex: dot(y), falling;
///         event hit: x - wall, rising;
///     }
/// }
/// let ball = Ball::new(0.1, 3.0);
/// let start = State::new(0.0, [0.0, 0.0], [4.0, 9.81]);
/// let run = integrate(&ball, Dop853, PiController::tolerance(1e-10), start).until(10.0);
/// let met: Vec<_> = run.events((Ball::GROUND, Ball::APEX, Ball::HIT)).collect::<Result<_, _>>()?;
/// let seen: Vec<_> = met.iter().map(|event| event.name).collect();
/// assert_eq!(seen, ["hit", "apex", "ground"]);
/// assert!((met[0].state.t - 0.75).abs() < 1e-12 && (met[2].state.t - 2.0).abs() < 1e-12);
/// # Ok::<(), Failure>(())
/// ```
///
/// # Ignorable coordinates
///
/// A coordinate is ignorable if it appears in neither L, D nor Q and no force acts on it: its momentum `pᵢ = ∂L/∂q̇ᵢ`
/// is constant. The compiler proves which ones are, also through bindings such as `let x = r * phi.cos();`. With
/// `pub routhian Reduced;`, which takes attributes and a visibility as a type does, it derives the equations of the
/// other coordinates from the Routhian `R = L − Σ pᵢ q̇ᵢ` and emits them as the type `Reduced`. Its parameters are
/// those of the system and the momenta, `p_phi` for a coordinate `phi`; it implements all that a system implements,
/// and [`Routhian`](crate::Routhian); of the outputs it has those that do not depend on the ignorable coordinates.
/// The system's `reduce` makes it from a state, [`Run::recover`](crate::Run::recover) gives the whole motion back. It
/// keeps its momenta when an [input](#inputs) changes, where the whole system keeps its velocities: if T depends on
/// the input, `reduce` the state of the whole system again after the change to get its motion.
///
/// ```
/// use lagrange_runtime::prelude::*;
///
/// lagrangian! {
///     /// A particle on a sphere, hanging: θ from the downward vertical.
///     pub system SphericalPendulum {
///         param m, l, g = 9.81;
///         coord theta: angle, phi: angle;
///         T = 0.5 * m * l.powi(2) * (dot(theta).powi(2) + (dot(phi) * theta.sin()).powi(2));
///         V = -m * g * l * theta.cos();
///         /// Its motion up and down.
///         pub routhian Swing;
///     }
/// }
///
/// let pendulum = SphericalPendulum::new(1.0, 0.5);
/// let start = State::new(0.0, [1.0, 0.0], [0.0, 3.0]);
/// let (swing, state): (Swing, State<f64, 1>) = pendulum.reduce(&start);
/// let run = integrate(&swing, Dop853, PiController::tolerance(1e-11), state).until(2.0);
/// let end = run.recover([0.0]).last().unwrap()?;
/// let whole = integrate(&pendulum, Dop853, PiController::tolerance(1e-11), start).until(2.0).final_state()?;
/// assert!((end.q - whole.q).amax() < 1e-9);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// # Coordinates that are held
///
/// `pub restriction Planar: phi = 0;` emits the system in which `phi` is 0 as a type of its own, which takes attributes
/// and a visibility; there may be several. What is held is a coordinate, an array of them or an element,
/// `theta[1] = 0`, at a number or an expression of parameters. The type has the other coordinates, the same parameters,
/// inputs, states and outputs, and those events and constraints that the held coordinates do not decide. It is exact:
/// the compiler proves that a motion that starts there stays there. Otherwise the statement is a compile error that
/// names what drives the coordinate away. [`Restricted`](crate::traits::Restricted) makes the smaller system from the
/// whole one and a state, and lifts states back.
///
/// # Simpler energies
///
/// `pub simplified Small: …;` changes the energies by moves, derives the equations afterwards, and emits them as a
/// type that has all that a system has:
///
/// | Move | Effect |
/// |---|---|
/// | `lock x = 0` | the coordinate is held, as by a restriction, but whether that is exact or not |
/// | `neglect m2`, `neglect coupling` | a parameter, or a term with a name, `let coupling = …;`, is 0 |
/// | `neglect dissipation`, `neglect gyroscopic` | D, or the terms of T that are linear in the velocities, are left out |
/// | `expand [theta, phi] to 2 about 0` | T, V and D to order N in the deviations of these coordinates and their velocities, counted together; forces to order N − 1. To order 2 about an equilibrium they are small oscillations, whose equations are linear |
/// | `inertia at theta = 0` | the inertia matrix with these coordinates at these values |
/// | `quasistatic x` | x follows the others by ∂V/∂x = Q with all velocities 0, where that is linear in x (static condensation): a stiff spring without its vibration |
/// | `average omega * t` | the mean over the phase of a fast given motion, to leading order in 1/ω: Kapitza's effective potential. `lift` adds the fast part of the velocities |
///
/// Coordinates are held and terms neglected first, then statics are solved, then the rest is done as it is written. The
/// documentation of the type says what was left out. A move that changes nothing, makes M singular or removes the last
/// term in which a coordinate appears is an error, and so is a type that costs more than the whole one.
/// [`Restricted`](crate::traits::Restricted) converts systems and states to the type and back.
///
/// # Expressions
///
/// Rust's own: `0.5 * m * l.powi(2)`, blocks with `let`, `if … else`, arrays, `(0..N).map(|i| …).sum()`, `.rev()`,
/// `.zip()`, `.enumerate()`, tuples and closures. `.iter()` gives references, as in `x.iter().map(|x| *x * 2.0)`.
/// `t` is time, `dot(e)` the total time derivative of any expression of coordinates and time. Elementary functions are
/// those of [`Functions`](crate::Functions), and `powi`, `recip`, `sin_cos`, `min`, `max`, `clamp`, `mul_add`,
/// `to_radians`, `to_degrees`. A power is `x.powi(2)`. A literal has the suffixes of Rust alone, `2f64`, and no unit.
///
/// An expression that the language accepts has the value that it has in Rust over `f64`, to rounding. rustc accepts
/// it as well, but for these extensions:
///
/// | Extension | Example |
/// |---|---|
/// | An integer without a written type is a number where a number is expected, and serves as an index, a length and an exponent; it has 64 bits, one of them for the sign | `2 * l`, `i * x[i]`, `x.powi(N)` |
/// | Methods apply to literals of numbers, which are of the system's own type | `2.0.sqrt()` |
/// | Elementary functions are functions, too | `sin(theta)` |
/// | Constants need no `use`: they are those of `f64::consts`, and `PI` | `f64::consts::TAU` |
/// | Arrays add, subtract and scale, and have `.dot(b)`, `.cross(b)`, `.norm()`, `.norm_squared()` | `0.5 * (a + b)` |
/// | Arrays and iterators are one kind of list, with the methods and indices of both; a sum needs no type | `x.sum()`, `x.zip(y)[0]` |
/// | Code that is never evaluated is not checked: the other branch where integers decide an `if`, a function that is not called | `if i == 0 { 0 } else { x[i - 1] }` |
///
/// A quotient of two integer literals, which Rust rounds, is a compile error, and so is a quotient of integers with a
/// remainder outside of an index. Numbers are exact before they are rounded: zero has no sign, and `0 * x` is 0, also
/// where x is infinite. Formulas are simplified where they have a value, and may have one elsewhere: `x / x` is 1, also
/// at 0, and `sqrt(x).powi(2)` is x, also below 0. `min` and `max` may return a NaN argument, which Rust's ignore.
/// `clamp` returns NaN if its number is NaN, and ignores a bound that is NaN. If its bounds are in the wrong order it
/// returns the upper one, where Rust's panics.
///
/// # Names
///
/// Parameters, coordinates, bindings and outputs have names of their own: a system does not see constants or
/// variables of the program around it, and a value from there is a parameter. Any identifier is a name, but for
/// keywords of Rust, time `t`, `dot`, `reaction` and the elementary functions; outputs also have other names than the
/// functions of a system (the chapter "Words" of the guide lists all names that are taken). A parameter that nothing
/// depends on is a warning, unless its name begins with `_`.
///
/// # Mistakes
///
/// A malformed system is a compile error at the token that is wrong:
///
/// ```compile_fail
/// # use lagrange_runtime::prelude::*;
/// lagrangian! {
///     pub system Pendulum {
///         param m, l, g = 9.81;
///         coord theta;
///         T = 0.5 * m * (l * dot(theta))^2;   // `^` is exclusive or: a power is `x.powi(2)`
///         V = -m * g * l * cos(teta);         // unknown name `teta`; did you mean `theta`?
///     }
/// }
/// ```
#[macro_export]
macro_rules! lagrangian {
    ($($definition:tt)*) => { $crate::__private::lagrangian! { @crate [$crate::__private] $($definition)* } };
}
