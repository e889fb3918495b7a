//! Multi-point constraints: BEAM, LINK, PIN, REVOLUTE, TIE, UNIVERSAL.
//!
//! Node S (the first, dependent) follows node M (the second). A kind ([`MpcType`], [`TABLE`]) says what becomes of translations
//! (free, equal, at a constant distance, carried by M as by a rigid beam) and of rotations (free, or tied but for hinges). With
//! x = X + u and C = C(φ), the residuals are
//!
//! - `δ = u_S − u_M` (PIN, TIE);
//! - `δ = x_S − x_M − C_M (X_S − X_M)` (BEAM);
//! - `δl = |x_S − x_M| − |X_S − X_M|` (LINK);
//! - ρ, the rotation vector of `C_S [C_M C(φ_1 a1₀) C(φ_2 a2₀)]ᵀ`;
//! - `δΨ = Ψ_S − Ψ_M` (TIE),
//!
//! in global components. The product `C_M C(φ_1 a1₀) C(φ_2 a2₀)` has the axes of the initial geometry, and needs no turned axis.
//! With the axes as they are carried, `a1 = C_M a1₀` and `a2 = C(φ_1 a1) C_M a2₀`, it is `C(φ_2 a2) C(φ_1 a1) C_M` (seed Revolute
//! joint, Eq. 1; Theory Guide, universal MPC). The angles φ_1 (REVOLUTE: φ_J) and φ_2 of the hinges are degree of freedom 6 of
//! nodes of their own. A REVOLUTE has φ_1 alone, BEAM and TIE have none. ρ is regular wherever the constraint nearly holds, and
//! there its rows are ω_S − ω_M − φ̇_1 a1 − φ̇_2 a2.
//!
//! | module | question |
//! |---|---|
//! | `kind` | which kinds are there, and what is declared of each? |
//! | `residual` | the mathematics, for every scalar |
//! | `evaluate` | what does one constraint give at one state? |
//! | `care` | what needs care there? |
//! | [`force`] | what forces does it transmit, and what does it leave to be solved for? |
//!
//! ```
//! use pintle_kinematics::connector::{Request, Tally, Turns};
//! use pintle_kinematics::mpc::{Body, Constraint, DOFS, MpcType, PHI, State, Turning};
//! use pintle_kinematics::{so3, vector};
//!
//! // A universal joint with the axes 3 and 1, bent by 0.4 rad about the first and 0.3 rad about the second.
//! let joint = Constraint::<f64>::new(MpcType::Universal, [0.0; 3], [0.0; 3], [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]);
//! let [first, second] = [[0.0, 0.0, 0.4], [0.3, 0.0, 0.0]].map(|turn| so3::matrix(so3::exp_quaternion(turn)));
//! let slave = Body { rotation: vector::product(&first, &second), ..Body::at_rest() };
//! let state = State { slave, ..State::at_rest() };
//! let start = [Turns { turns: 0.0, principal: 0.0 }; 2];
//! let result = joint.evaluate(&state, &start, &Turning::none(), &Request::everything(1), &mut Tally::default());
//! assert!((result.angles[0].principal - 0.4).abs() < 1e-15 && (result.angles[1].principal - 0.3).abs() < 1e-15);
//! let row = result.jacobian[3].ok_or("ρ1 has a row")?; // δθS1 − δθM1 − a1 δφ1 − a2 δφ2
//! assert!((row[PHI + 1] + 0.4_f64.cos()).abs() < 1e-15); // a2 has turned with the first hinge
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod care;
mod evaluate;
pub mod force;

mod kind;
mod residual;

pub use care::Margins;
pub use evaluate::Evaluation;
pub use kind::{Entry, MpcType, TABLE, Translation};
pub(crate) use residual::turned;

use crate::catalog::{PLANE, in_plane};
use crate::scalar::{Duals, Real};
use crate::vector;
use crate::vector::{Matrix, Vector, cross, dot, sub};

/// The number of degrees of freedom that a constraint may have: x, θ and Ψ of S, those of M, and the angles of two hinges.
pub const DOFS: usize = 16;

/// The number of nodes that a constraint may have: S, M, and those of which degree of freedom 6 is the angle of a hinge.
pub const NODES: usize = 4;

/// Where the displacements of S begin.
pub const XS: usize = 0;
/// Where the rotations of S begin.
pub const THETA_S: usize = 3;
/// Material flow of S.
pub const PSI_S: usize = 6;
/// Where the displacements of M begin.
pub const XM: usize = 7;
/// Where the rotations of M begin.
pub const THETA_M: usize = 10;
/// Material flow of M.
pub const PSI_M: usize = 13;
/// Where the angles of the hinges begin: degree of freedom 6 of the third and fourth node.
pub const PHI: usize = 14;

/// The number of equations that a constraint may have: three of translation, three of rotation, one of material flow.
pub const ROWS: usize = 7;
/// Where the equations of rotation begin.
pub const RHO: usize = 3;
/// The equation of material flow.
pub const FLOW: usize = 6;

/// A number for each degree of freedom.
pub type Dofs<R> = [R; DOFS];

/// Something for each equation that there is.
pub type Rows<T> = [Option<T>; ROWS];

/// A multi-point constraint on numbers of type R.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
#[serde(bound(serialize = "R: serde::Serialize", deserialize = "R: serde::Deserialize<'de>"))]
pub struct Constraint<R: Duals> {
    kind: MpcType,
    /// X_S − X_M.
    arm: Vector<R>,
    /// a1₀ and a2₀, of unit length.
    axes: [Vector<R>; 2],
    flow: bool,
    #[serde(default)]
    planar: bool,
}

/// One of the nodes S and M at one instant.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Body<R> {
    /// u.
    pub displacement: Vector<R>,
    /// C(φ).
    pub rotation: Matrix<R>,
    /// Ψ, degree of freedom 10.
    pub flow: R,
}

/// The nodes of a constraint at one instant.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct State<R> {
    /// S.
    pub slave: Body<R>,
    /// M.
    pub master: Body<R>,
    /// The angles of the hinges where they are given; otherwise they are taken from the rotations ([`Evaluation::angles`]).
    pub angles: [Option<R>; 2],
    /// v_S, ω_S, Ψ̇_S, v_M, ω_M, Ψ̇_M, φ̇_1, φ̇_2.
    pub velocity: Dofs<R>,
    /// Their rates: a_S, α_S, …
    pub acceleration: Dofs<R>,
}

impl<R: Real> Body<R> {
    /// Where it is initially.
    pub fn at_rest() -> Self {
        let zero = R::ZERO;
        Self { displacement: [zero; 3], rotation: vector::identity(), flow: zero }
    }
}

impl<R: Real> State<R> {
    /// The initial state, at rest.
    pub fn at_rest() -> Self {
        let body = Body::at_rest();
        let still = [R::ZERO; DOFS];
        Self { slave: body, master: body, angles: [None; 2], velocity: still, acceleration: still }
    }
}

/// How S turned against M since the state before, global components (rad).
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Turning<R> {
    /// Whole turns, of S less those of M: what rotation vectors beyond half a turn tell besides the rotations.
    pub whole: Vector<R>,
    /// The rest of the increment of S less that of M.
    pub rest: Vector<R>,
}

impl<R: Real> Turning<R> {
    /// None that is known of.
    pub fn none() -> Self {
        Self { whole: [R::ZERO; 3], rest: [R::ZERO; 3] }
    }
}

impl<R: Duals> Constraint<R> {
    /// A constraint between nodes with these initial positions. The third and fourth, where the kind has them, give its axes, from
    /// M to J (UNIVERSAL: J1 and J2). Where they coincide with M the first is along the global z and the second along the global x
    /// (keyword *MPC). What the kind does not have is not looked at.
    ///
    /// ```
    /// use pintle_kinematics::mpc::{Constraint, MpcType};
    /// let axis = |joint| {
    ///     Constraint::<f64>::new(MpcType::Revolute, [1.0; 3], [0.0; 3], [joint, [0.0; 3]]).initial_axes()[0]
    /// };
    /// assert_eq!(axis([0.0, 2.0, 0.0]), Some([0.0, 1.0, 0.0]));
    /// assert_eq!(axis([0.0; 3]), Some([0.0, 0.0, 1.0]));
    /// ```
    pub fn new(kind: MpcType, slave: Vector<f64>, master: Vector<f64>, hinges: [Vector<f64>; 2]) -> Self {
        let (zero, one) = (R::ZERO, R::integer(1));
        let from_master = |to: Vector<f64>| sub(vector::exact::<R>(to), vector::exact(master));
        let axis = |to: Vector<f64>, otherwise: Vector<R>| {
            let (axis, length) = R::direction_and_norm(from_master(to));
            R::choose(zero.less(length), || axis, || otherwise)
        };
        let axes = [axis(hinges[0], [zero, zero, one]), axis(hinges[1], [one, zero, zero])];
        Self { kind, arm: from_master(slave), axes, flow: false, planar: false }
    }

    /// Between nodes that are X_S − X_M = `arm` apart initially, with hinges about `axes`, of unit length, which are taken as they are.
    ///
    /// ```
    /// use pintle_kinematics::mpc::{Constraint, MpcType};
    /// let axes = [[0.6, 0.8, 0.0], [1.0, 0.0, 0.0]];
    /// let joint = Constraint::<f64>::with_axes(MpcType::Revolute, [1.0, 2.0, 3.0], axes);
    /// assert_eq!((joint.arm(), joint.initial_axes()), ([1.0, 2.0, 3.0], [Some(axes[0]), None]));
    /// ```
    pub const fn with_axes(kind: MpcType, arm: Vector<R>, axes: [Vector<R>; 2]) -> Self {
        Self { kind, arm, axes, flow: false, planar: false }
    }

    /// The same, where both nodes have material flow: a TIE makes that equal too.
    #[must_use]
    pub const fn with_flow(self) -> Self {
        Self { flow: true, ..self }
    }

    /// The same in a two-dimensional model, whose nodes have the degrees of freedom 1, 2, 6 and 10: without δ3, ρ1 and ρ2, and the columns by
    /// x3, θ1 and θ2.
    ///
    /// ```
    /// use pintle_kinematics::mpc::{Constraint, MpcType};
    /// let beam = Constraint::<f64>::new(MpcType::Beam, [1.0, 0.0, 0.0], [0.0; 3], [[0.0; 3]; 2]).in_plane();
    /// assert_eq!(beam.rows(), [true, true, false, false, false, true, false]);
    /// ```
    #[must_use]
    pub const fn in_plane(self) -> Self {
        Self { planar: true, ..self }
    }

    /// Whether its nodes have the degrees of freedom of the plane alone ([`Constraint::in_plane`]).
    pub const fn is_planar(&self) -> bool {
        self.planar
    }

    /// The same on another real number; exactly so from doubles.
    pub fn exact<S: Duals>(&self) -> Constraint<S>
    where
        R: Into<f64>,
    {
        let exact = |v: Vector<R>| vector::exact(v.map(Into::into));
        let Self { kind, flow, planar, .. } = *self;
        Constraint { kind, arm: exact(self.arm), axes: self.axes.map(exact), flow, planar }
    }

    /// Its kind.
    pub const fn kind(&self) -> MpcType {
        self.kind
    }

    /// The number of its hinges.
    pub(crate) fn hinges(&self) -> usize {
        self.kind.entry().angles.len()
    }

    /// X_S − X_M.
    pub const fn arm(&self) -> Vector<R> {
        self.arm
    }

    /// a1₀ and a2₀ of the hinges that there are: the axes in the initial geometry, of unit length, global components.
    pub fn initial_axes(&self) -> [Option<Vector<R>>; 2] {
        [0, 1].map(|i| Some(self.axes[i]).filter(|_| i < self.hinges()))
    }

    /// The equations that it has.
    pub fn rows(&self) -> [bool; ROWS] {
        let rows = self.kind.rows(self.flow);
        std::array::from_fn(|row| rows[row] && (!self.planar || PLANE.get(row).is_none_or(|is| *is)))
    }

    /// The degrees of freedom that enter it.
    pub fn columns(&self) -> [bool; DOFS] {
        let columns = self.kind.columns(self.flow);
        std::array::from_fn(|j| columns[j] && (!self.planar || in_plane(MpcType::column_dof(j).1)))
    }

    /// The angle between the axes of two hinges in the initial geometry, in [0, π] (rad).
    pub fn axes_angle(&self) -> Option<R> {
        (self.hinges() == 2).then(|| angle_between(self.axes[0], self.axes[1]))
    }
}

/// The angle between two vectors, in [0, π].
fn angle_between<R: Real>(u: Vector<R>, v: Vector<R>) -> R {
    let (_, sine) = R::direction_and_norm(cross(u, v));
    sine.arctangent(dot(u, v))
}
