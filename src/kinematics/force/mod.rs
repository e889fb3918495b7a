//! Virtual work: from the forces of components to nodal forces, their derivatives, constraint multipliers and printed moments.
//!
//! The virtual work of a connector is Σ f_k G_k·δq over its components, with one row G_k for each force ([`crate::catalog::Loading`]); nodal forces
//! are Σ f_k G_kᵀ, in the order of [`crate::node::DOF`]. [`ForceRows`] holds the rows at one state.
//!
//! *Signs.* f_k is internal: positive resists growth of its component. Nodal forces are residual-side; the forces on the nodes are
//! minus that. Forces and moments of a [`Wrench`] are those at b, residual-side; constraint forces act at b.
//!
//! *Two kinds of moments.* The reported moments of a constrained rotation are those that the manual prints (m2 e2a + m3 e3a of
//! REVOLUTE). The [`ForceRows::multipliers`] λ are those of the equations enforced (e1a·e3b = 0, log(Q Q₀ᵀ) = 0 …). Both stand for
//! the same moment M.
//!
//! ```
//! use pintle_kinematics::catalog::ConnectionType;
//! use pintle_kinematics::connector::{Connector, Definition, State, Tally};
//! use pintle_kinematics::force::Want;
//! use pintle_kinematics::node::{DOFS, Node, Pair};
//! use pintle_kinematics::vector;
//!
//! // A CARTESIAN whose b is 2 away along e1 resists along e2 with 3.
//! let node = Node { displacement: [0.0; 3], triad: vector::identity(), flow: 0.0 };
//! let initial = Pair { reference: [2.0, 0.0, 0.0], a: node, b: node };
//! let connector = Connector::<f64>::new(&Definition::new(ConnectionType::named("CARTESIAN", None)?, initial));
//! let state = State { pair: initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
//! let branch = connector.initial_branch();
//! let rows = connector.force_rows(&state, &branch, [true; 6], Want::default(), &mut Tally::default());
//! let nodal = rows.nodal(&[None, Some(3.0), None, None, None, None]);
//! assert_eq!(nodal[7..10], [0.0, 3.0, 0.0]); // on b
//! assert_eq!(nodal[0..3], [0.0, -3.0, 0.0]); // on a
//! assert_eq!(nodal[3..6], [0.0, 0.0, -6.0]); // the moment f × d on a
//! # Ok::<(), pintle_kinematics::catalog::NameError>(())
//! ```

mod dual;
mod rows;

pub use rows::{ForceRow, ForceRows, Want};

use crate::scalar::Real;
use crate::vector::{Vector, cross, sub};

/// A force and a moment about a point, global components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrench<R> {
    /// F.
    pub force: Vector<R>,
    /// M, about the point.
    pub moment: Vector<R>,
}

impl<R: Real> Wrench<R> {
    /// The same about a point that lies `by` away (global components): M − by × F.
    ///
    /// ```
    /// use pintle_kinematics::force::Wrench;
    /// let at_b = Wrench { force: [0.0, 3.0, 0.0], moment: [0.0; 3] };
    /// assert_eq!(at_b.shifted([-2.0, 0.0, 0.0]).moment, [0.0, 0.0, 6.0]);
    /// ```
    #[must_use]
    pub fn shifted(&self, by: Vector<R>) -> Self {
        Self { force: self.force, moment: sub(self.moment, cross(by, self.force)) }
    }
}
