//! Relations: the constraints of decks beside connectors and `*MPC`, between any number of nodes.
//!
//! With x = X + u, C = C(φ) and axes e₁, e₂, e₃ that are given initially and carried by the reference node M:
//!
//! | form | of | requires to vanish |
//! |---|---|---|
//! | [`Form::Linear`] | `*EQUATION`, `*TIE` | g = Σ A q, where q is a displacement, a component of the rotation vector, or a material flow |
//! | [`Form::Carried`] | `*RIGID BODY`, `*COUPLING` with `*KINEMATIC` | δ_i = e_i·\[x_S − x_M − C_M (X_S − X_M)\], and ρ_i, for the degrees of freedom that are fixed |
//! | [`Form::Mean`] | `*COUPLING` with `*DISTRIBUTING` | δ_i = e_i·\[x_M − x̄ − C_M (X_M − X̄)\], and ρ_i = g_i·Σ ŵ_n (C_Mᵀ r_n) × R_n |
//!
//! *Rotations of a kinematic coupling.* They are those of a BEAM, a revolute joint, a universal joint or a pin, as three, two, one or none
//! is fixed (Theory Guide, kinematic coupling). With Q = C_Mᵀ C_S:
//! - three: ρ_i = e_i·log Q;
//! - two, e_k free: ρ_i = e_i·(e_k × Q e_k);
//! - one, e_i, with e_j and e_k free, j < k: ρ_i = ∓ e_j·Q e_k, − for i = 1 and 3. That e_j is carried by M and e_k by S is our reading.
//!
//! *Means.* x̄ = Σ ŵ_n x_n is the weighted centre of the coupling nodes, ŵ_n = w_n/Σ w, r_n = x_n − x̄, and R_n is r_n initially. The mean
//! rotation is the C that brings the R_n nearest to the r_n, Σ ŵ_n |r_n − C R_n|² = min. There Σ ŵ_n (Cᵀ r_n) × R_n = 0, which is what ρ
//! states of C_M. Here T = Σ ŵ_n (|R_n|² 1 − R_n R_nᵀ) and g_i = T⁻¹ e_i. For every cloud that has moved as a rigid body the rows are those of
//! Abaqus' theory, δρ = δθ_M − T⁻¹ Σ ŵ_n r_n × δx_n. For one that has not, finite rotations are our reading: the theory prints rates only.
//! Nodes on one line leave the rotation about it free, and so two equations; one node leaves all three free.
//!
//! All δ and ρ are components along carried axes, and so are numbers that no rigid motion of everything changes.
//!
//! ```
//! use pintle_kinematics::connector::{Request, Tally};
//! use pintle_kinematics::relation::{Form, Point, Relation};
//! // u1 of one node is twice that of another.
//! let relation = Relation::<f64>::linear(&[(0, [1.0, 0.0, 0.0], 0, 1.0), (1, [1.0, 0.0, 0.0], 0, -2.0)]);
//! let at = |x| Point { displacement: [x, 0.0, 0.0], ..Point::at_rest() };
//! let result = relation.evaluate(&[at(3.0), at(1.0)], &Request::everything(1), &mut Tally::default());
//! assert_eq!(result[0].residual, 1.0);
//! assert_eq!(result[0].gradient, [1.0, -2.0]);
//! assert_eq!(relation.columns(), [(0, 1), (1, 1)]);
//! ```

mod build;
mod evaluate;

pub use evaluate::ConstraintRow;

use crate::catalog::PLANE;
use crate::measure::Unit;
use crate::scalar::Real;
use crate::vector;
use crate::vector::{Matrix, Vector};

/// What a term of a linear equation is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Quantity {
    /// A displacement along an axis.
    Displacement,
    /// The component of the total rotation vector along an axis, of a node that turns in space.
    Rotation,
    /// One angle of a node that has no others: it is a number of its own, not part of a rotation.
    Angle,
    /// Material flow, degree of freedom 10.
    Flow,
}

/// A term A q of a linear equation.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Term<R> {
    /// The place of its node.
    pub place: usize,
    /// What q is.
    pub quantity: Quantity,
    /// Which component of that, 0 to 2.
    pub component: usize,
    /// The direction of q; one of the global axes unless the node has a `*TRANSFORM`.
    pub axis: Vector<R>,
    /// A.
    pub factor: R,
}

/// A coupling node of a mean.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Share<R> {
    /// ŵ.
    pub weight: R,
    /// R, the initial position from the centre.
    pub arm: Vector<R>,
}

/// What a relation says. Axes are rows.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub enum Form<R> {
    /// Σ A q = 0 between its nodes.
    Linear(Vec<Term<R>>),
    /// S, the first node, is carried by M, the second, in the degrees of freedom that are fixed.
    Carried {
        /// X_S − X_M.
        arm: Vector<R>,
        /// The axes initially.
        axes: Matrix<R>,
        /// Which of δ1 … ρ3 there are.
        fixed: [bool; 6],
    },
    /// M, the first node, moves with the mean of the others.
    Mean {
        /// X_M − X̄.
        lever: Vector<R>,
        /// The other nodes.
        shares: Vec<Share<R>>,
        /// The axes of δ initially.
        axes: Matrix<R>,
        /// g of each ρ that there is.
        turns: Vec<Vector<R>>,
    },
}

/// A constraint between any number of nodes.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Relation<R> {
    form: Form<R>,
    /// Whether its nodes have the degrees of freedom 1, 2, 6 and 10 alone.
    #[serde(default)]
    planar: bool,
    /// The degrees of freedom that enter it, by the place of the node, ascending.
    columns: Vec<(usize, u8)>,
}

/// A node at one instant.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Point<R> {
    /// u.
    pub displacement: Vector<R>,
    /// C(φ).
    pub rotation: Matrix<R>,
    /// φ, with its turns.
    pub vector: Vector<R>,
    /// Ψ.
    pub flow: R,
    /// v, ω, Ψ̇.
    pub velocity: [R; 7],
    /// Their rates.
    pub acceleration: [R; 7],
}

impl<R: Real> Point<R> {
    /// Where it is initially.
    pub fn at_rest() -> Self {
        let zero = R::ZERO;
        Self {
            displacement: [zero; 3],
            rotation: vector::identity(),
            vector: [zero; 3],
            flow: zero,
            velocity: [zero; 7],
            acceleration: [zero; 7],
        }
    }

    /// The same on another real number; exactly so from doubles.
    pub fn exact<S: Real>(&self) -> Point<S>
    where
        R: Into<f64>,
    {
        let number = |x: R| S::from_f64(x.into());
        Point {
            displacement: self.displacement.map(number),
            rotation: self.rotation.map(|row| row.map(number)),
            vector: self.vector.map(number),
            flow: number(self.flow),
            velocity: self.velocity.map(number),
            acceleration: self.acceleration.map(number),
        }
    }
}

/// Where a degree of freedom stands among those of a node: x, θ, Ψ.
pub const fn place_of(number: u8) -> usize {
    if number > 6 { 6 } else { number as usize - 1 }
}

impl<R> Relation<R> {
    /// What it says.
    pub const fn form(&self) -> &Form<R> {
        &self.form
    }

    /// Whether its nodes have the degrees of freedom of the plane alone ([`Relation::in_plane`]).
    pub const fn is_planar(&self) -> bool {
        self.planar
    }

    /// The degrees of freedom that enter it: the place of the node, and the number there, in global axes.
    pub fn columns(&self) -> &[(usize, u8)] {
        &self.columns
    }

    /// The same along the axes of a node that has some of its own. Terms of a linear equation are along these.
    pub fn own_columns(&self, has_axes: impl Fn(usize) -> bool) -> Vec<(usize, u8)> {
        let Form::Linear(terms) = &self.form else { return self.columns.clone() };
        let mut found: Vec<(usize, u8)> =
            self.columns.iter().copied().filter(|(place, _)| !has_axes(*place)).collect();
        for term in terms.iter().filter(|term| has_axes(term.place)) {
            let own = 1 + term.component as u8;
            let numbers = match term.quantity {
                Quantity::Displacement => own..=own,
                Quantity::Rotation => 4..=6,
                Quantity::Angle => 3 + own..=3 + own,
                Quantity::Flow => 10..=10,
            };
            found.extend(numbers.map(|number| (term.place, number)));
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// The names of its equations, δ1 … δ3, ρ1 … ρ3, g, and their units.
    pub fn rows(&self) -> Vec<(&'static str, Unit)> {
        const NAMES: [&str; 6] = ["δ1", "δ2", "δ3", "ρ1", "ρ2", "ρ3"];
        let named = |i: usize| (NAMES[i], if i < 3 { Unit::Length } else { Unit::Angle });
        match &self.form {
            Form::Linear(terms) => {
                let is_angle = |term: &Term<R>| matches!(term.quantity, Quantity::Rotation | Quantity::Angle);
                let unit = if terms.iter().all(is_angle) { Unit::Angle } else { Unit::Length };
                vec![("g", unit)]
            }
            Form::Carried { .. } => self.carried_rows().map(named).collect(),
            Form::Mean { .. } if self.planar => {
                self.mean_rows().map(|i| named(if i == 3 { 5 } else { i })).collect()
            }
            Form::Mean { .. } => self.mean_rows().map(named).collect(),
        }
    }

    /// Whether S, the first node, follows M in all displacements that there are, and in all rotations; no mean and no equation says so.
    pub fn follows(&self) -> [bool; 2] {
        let Form::Carried { fixed, .. } = &self.form else { return [false; 2] };
        [0..3, 3..6].map(|mut these| these.all(|i| fixed[i] || (self.planar && !PLANE[i])))
    }

    /// Which of δ1 … ρ3 are equations of what is carried.
    fn carried_rows(&self) -> impl Iterator<Item = usize> + use<R> {
        let (planar, fixed) = match &self.form {
            Form::Carried { fixed, .. } => (self.planar, *fixed),
            _ => (self.planar, [false; 6]),
        };
        (0..6).filter(move |i| fixed[*i] && (!planar || PLANE[*i]))
    }

    /// Which of δ1 … δ3 and Σ of each g are equations of a mean.
    fn mean_rows(&self) -> impl Iterator<Item = usize> + use<R> {
        let (planar, count) = match &self.form {
            Form::Mean { turns, .. } => (self.planar, 3 + turns.len()),
            _ => (self.planar, 0),
        };
        (0..count).filter(move |i| !planar || *i != 2)
    }

    /// The names of its nodes by role: S and M of what is carried, M and the nodes n of a mean, the nodes of an equation.
    pub const fn role(&self, place: usize) -> &'static str {
        match (&self.form, place) {
            (Form::Linear(_), _) => "node",
            (Form::Carried { .. }, 0) => "S",
            (Form::Carried { .. }, _) | (Form::Mean { .. }, 0) => "M",
            (Form::Mean { .. }, _) => "n",
        }
    }

    /// The name of a degree of freedom: xS1, θM3, Ψ.
    pub const fn column_name(&self, place: usize, number: u8) -> &'static str {
        const SLAVE: [&str; 7] = ["xS1", "xS2", "xS3", "θS1", "θS2", "θS3", "ΨS"];
        const MASTER: [&str; 7] = ["xM1", "xM2", "xM3", "θM1", "θM2", "θM3", "ΨM"];
        const OTHER: [&str; 7] = ["x1", "x2", "x3", "θ1", "θ2", "θ3", "Ψ"];
        match self.role(place).as_bytes() {
            b"S" => SLAVE[place_of(number)],
            b"M" => MASTER[place_of(number)],
            _ => OTHER[place_of(number)],
        }
    }
}
