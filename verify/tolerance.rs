//! Every tolerance of the tests, in one table, with the cause of the odd ones.

/// The largest allowed errors of a function: value, first, second derivative.
pub(crate) struct Gate {
    /// The name under which the test measures.
    pub(crate) function: &'static str,
    /// In units u = 2⁻⁵³ of the conditioned scale.
    pub(crate) orders: [f64; 3],
}

const fn gate(function: &'static str, value: f64, first: f64, second: f64) -> Gate {
    Gate { function, orders: [value, first, second] }
}

/// Errors in units u of the conditioned scale |f| + Σ|x_i||∂f/∂x_i|, of the value and of each derivative.
pub(crate) const NUMERICS: &[Gate] = &[
    // √x and 0.5/√x: two roundings, over a scale of 3/2.
    gate("sqrt", 1.0, 1.5, 2.0),
    gate("inverse_sqrt", 2.0, 2.0, 3.0),
    gate("recip", 1.0, 2.0, 3.0),
    gate("sin_cos", 1.0, 1.0, 2.0),
    gate("atan2", 1.0, 2.0, 3.0),
    gate("norm2", 1.0, 2.0, 4.0),
    gate("norm3", 1.0, 2.0, 4.0),
    gate("direction3", 2.0, 4.0, 5.0),
    gate("exp_quaternion", 4.0, 4.0, 5.0),
    gate("exp_matrix", 4.0, 4.0, 5.0),
    gate("log_quaternion", 4.0, 5.0, 6.0),
    gate("log_matrix", 4.0, 5.0, 6.0),
    // One more rounded vector than the log, and a multiple of 2π; to 1e4 turns.
    gate("continuous_log", 4.0, 6.0, 12.0),
    gate("continuous_log_matrix", 4.0, 6.0, 12.0),
    // In the norm of the array, as the vectors above.
    gate("cardan", 1.0, 2.0, 3.0),
    gate("euler", 1.0, 2.0, 3.0),
    // Near the lock the first and third angle outweigh the second in the norm of the array; by itself the derivative of the second
    // is a chain of ten roundings over a scale of hardly more than its own size.
    gate("cardan, each angle", 1.0, 3.0, 3.0),
    gate("euler, each angle", 1.0, 3.0, 3.0),
    // Absolute, in u over 1, |r₁|, |r₂| + |r₁|²: two exps, two products and a log.
    gate("chain of quaternions", 16.0, 12.0, 12.0),
    gate("ROTATION connector", 16.0, 12.0, 12.0),
    // Two rounded matrices and their product, with derivatives, besides.
    gate("chain of matrices", 16.0, 16.0, 16.0),
    // The columns are the third, the fourth and the second derivative.
    gate("jerk, quaternions", 60.0, 150.0, 12.0),
    gate("jerk, matrices", 60.0, 150.0, 16.0),
];

/// Those of lanes, where they differ: reciprocals are refined from estimates, and both sides of a choice are formed.
pub(crate) const NUMERICS_ON_LANES: &[Gate] = &[
    gate("norm2", 1.0, 3.0, 4.0),
    gate("norm3", 1.0, 3.0, 4.0),
    gate("direction3", 3.0, 4.0, 5.0),
    gate("continuous_log", 5.0, 6.0, 12.0),
    gate("continuous_log_matrix", 5.0, 6.0, 12.0),
    gate("cardan, each angle", 1.0, 5.0, 3.0),
    gate("euler", 2.0, 2.0, 3.0),
    gate("euler, each angle", 2.0, 5.0, 3.0),
];

/// Exported programs against `eval`, in units of the audit's bound on either.
pub(crate) const EXPORT: f64 = 2.0;

/// Numbers of a counter-example written as a deck, absolute, over 1 + their size: triads to some roundings, times second derivatives.
pub(crate) const HANDOVER: f64 = 1e-9;

/// What a law allows.
pub(crate) struct Law {
    /// Its name.
    pub(crate) name: &'static str,
    /// In units u = 2⁻⁵³ of the scale that the law states.
    pub(crate) units: f64,
}

const fn law(name: &'static str, units: f64) -> Law {
    Law { name, units }
}

/// Laws of the catalogue (`verify/laws.rs`), in roundings of the conditioned scale of what is compared.
pub(crate) const LAWS: &[Law] = &[
    law("value", 3.0),
    law("first derivatives", 3.0),
    law("second derivatives", 2.0),
    law("symmetry", 1.0),
    law("rigid modes", 4.0),
    // Second derivatives of a norm carry 4 u themselves (NUMERICS), and the sum adds a rounding for each of its products.
    law("rigid rotations, second order", 6.0),
    law("rigid motion, values", 8.0),
    law("rigid motion, rates", 2.0),
    // The inputs are turned by a rounded matrix: three roundings in each direction of each triad.
    law("frames, values", 16.0),
    law("frames, rows", 10.0),
    law("frames, second derivatives", 10.0),
    law("rates from rows", 1.0),
    // Twice an angle of a quaternion (torsion): the quaternion's accelerations hold |ω|²/4, which the angle's do not, but for their
    // roundings; the scale knows |ω|² only as far as second derivatives carry it.
    law("rates in time", 2.0),
    // B₀ = A₀Q₀ is itself a rounded product, of a rounded A₀.
    law("initial residuals", 8.0),
    law("exchanged nodes, values", 3.0),
    law("exchanged nodes, rows", 4.0),
    law("angles along paths", 5.0),
    law("accumulated turns", 2.0),
    // Rotation vectors of some tens of radians, rounded; the scale grows with the states.
    law("forms of input", 64.0),
    // Sums of a few products with 14 entries each, over a scale of all of them.
    law("equilibrium", 4.0),
    law("nodal forces", 4.0),
    law("stiffness", 4.0),
    // The inputs are turned by a rounded matrix.
    law("carried forces", 16.0),
    // The formulas take the triads to be orthonormal, which they are to a few roundings.
    law("rows by hand", 8.0),
    law("forces by hand", 8.0),
    law("plane, values", 3.0),
    law("plane, rows", 2.0),
    law("plane, second derivatives", 2.0),
    law("plane, rates", 1.0),
    law("mpc, value", 3.0),
    law("mpc, first derivatives", 3.0),
    law("mpc, second derivatives", 2.0),
    law("mpc, rates from rows", 1.0),
    law("mpc, rates in time", 2.0),
    law("mpc, rigid motion", 8.0),
    law("mpc, turns", 3.0),
    law("mpc, compositions", 8.0),
    law("mpc, allowed motions", 1.0),
    law("mpc, as connectors", 16.0),
    law("mpc, forces", 8.0),
    law("mpc, power", 1.0),
    law("mpc, stiffness", 1.0),
    law("mpc, springs", 2.0),
];

/// What 237-bit numbers leave of an identity, over its scale: 71 digits less the triads' distance from orthonormal, which is that of
/// doubles, where an identity rests on it.
pub(crate) const WIDE: f64 = 1e-60;

/// Agreement with JAX, in units of the error that the golden file states for each of its numbers: twice its distance from 110
/// digits plus two roundings of the natural size.
pub(crate) const GOLDEN: f64 = 4.0;

/// Forces of behaviour and their slopes against JAX, over 1 + |value|. They are sums of a dozen products of numbers below 500, and tables
/// of a few segments, by other formulas. The steepest segment of a table multiplies the rounding of its argument.
pub(crate) const BEHAVIOR_JAX: f64 = 1e-11;

/// Slopes of forces against wide differences, and energies' against forces, over 1 + |value|: a slope is one quotient, or a sum of
/// six products.
pub(crate) const BEHAVIOR_SLOPE: f64 = 1e-14;

/// The belt's nodal balance, over its tension: the known solution is given with ten digits.
pub(crate) const BELT_BALANCE: f64 = 1e-9;

/// Friction (`verify/friction.rs`), in roundings of what each test compares.
const FRICTION: &[Law] = &[
    // Hypotenuses and their sums, here and there.
    law("formulas", 8.0),
    law("gradients", 16.0),
    law("hessians", 64.0),
    law("range", 8.0),
    // Measured 168 for a shifted potential at a small limit, where forces away from zero lie on a surface that is small beside them;
    // 40 where a traction is returned along itself.
    law("tangents", 256.0),
    law("forces", 64.0),
    law("violation", 16.0),
    law("energy", 16.0),
    law("JAX", 256.0),
];

/// What friction is allowed under a name.
pub(crate) fn friction(name: &str) -> f64 {
    FRICTION.iter().find(|law| law.name == name).expect(name).units
}

/// Agreement of multi-point constraints with JAX, absolute: lengths, angles and rates of size 1, second derivatives and accelerations
/// up to 100, both computed in doubles.
pub(crate) const GOLDEN_MPC: f64 = 2e-13;

/// Friction along a history of 12 states against the same formulas worked out apart, relative to trial force and limit: a few
/// roundings of each state, which stick carries on to the next.
pub(crate) const FRICTION_HISTORY: f64 = 1e-13;

/// Rows of turned triads against those of the triads themselves, over the square of what is larger than one: an angle beside a lock
/// grows by 1/cos β, its row by the square.
pub(crate) const ROWS_OF_TURNS: f64 = 1e-13;

/// Four lanes against one element at a time, in roundings of the conditioned scale: value, first, second derivatives.
pub(crate) const BATCH: [f64; 3] = [2.0, 2.5, 1.5];

/// The same beside singular points. Lanes take triads as they are, not the rotation nearest to them. Triads there are products with
/// errors of two roundings, which a rotation vector of length π has for roundings of its length.
pub(crate) const BATCH_NEAR: [f64; 3] = [3.0, 2.5, 1.5];

/// Arrays of states of a scene against a walk through them, in roundings of what a number is computed from: values, rows. Lanes add fused
/// products to [`BATCH`], and the angles of a history their own.
pub(crate) const ARRAYS: [f64; 2] = [3.0, 2.5];

/// Consistent tangents of component forces against wide differences, relative to the largest slope.
pub(crate) const TANGENT: f64 = 1e-13;

/// Tangents of nodal forces against wide differences, relative to the largest entry: lengths and angles are about 1 there.
pub(crate) const NODAL_TANGENT: f64 = 1e-13;

/// CSF2 of a belt that slips against T2 − T1 of the known solution, over T2. The deck gives the angle of wrap to eight digits, and both
/// sides use them. What is left is 1e5 times the rounding of strains.
pub(crate) const BELT_FRICTION: f64 = 1e-12;

/// Slopes of an angle of wrap against central differences on doubles with a step of 1e-5: its square, and rounding over the step.
pub(crate) const BELT_ANGLE: f64 = 1e-9;

/// Slopes of a belt's friction, over the stiffness of its segments: a slope is that of a table times e^(μα) − 1.
pub(crate) const BELT_SLOPE: f64 = 1e-14;

/// Moments on hinges and what constraints transmit, over 1 + the number: sums of a few products of unit vectors.
pub(crate) const HINGE: f64 = 1e-14;

/// What is left at free degrees of freedom of the decks, over the forces there: sums of some ten products.
pub(crate) const DECK_BALANCE: f64 = 2e-14;
