//! A verification workbench for connector (joint) elements of finite-element and multibody codes: REVOLUTE, TRANSLATOR,
//! SLIDE-PLANE, RETRACTOR, ROTATION … and of the multi-point constraints BEAM, LINK, PIN, REVOLUTE, TIE, UNIVERSAL.
//!
//! What should this connector give here? Positions, displacements, rates, constraint residuals, Jacobians, Hessians: every
//! number is exact to rounding, or comes with a flag that says why it is not.
//!
//! # Notation
//!
//! | symbol | meaning |
//! |---|---|
//! | a, b | the first and second node of a connector |
//! | X, U, x = X + U | reference position, displacement, current position of a node; global components |
//! | φ, C = exp(φ^) | total rotation vector of a node and its rotation; v^ w = v × w |
//! | e1a, e2a, e3a | local directions carried by a: the columns of A = C(φ_a) A₀; likewise e1b … of B |
//! | d = Aᵀ(x_b − x_a) | the position of b from a, components along e_i^a |
//! | Q = AᵀB | Q_ij = e_i^a · e_j^b |
//! | Ψ | material flow of a node, degree of freedom 10 |
//! | u1 u2 u3 ur1 ur2 ur3 | components of relative motion; f1 … m3 are their conjugate forces and moments |
//! | δθ, ω, α | spatial variation, angular velocity, angular acceleration: C → exp(δθ^) C, Ċ = ω^ C |
//! | ∂ur1/∂θb3 | how ur1 changes as b turns about the global 3-axis |
//!
//! Indices are 1-based, as the manual's. Angles are in radians; lengths and times in the units of the scene. Two inputs are
//! in degrees, as the manual has them: constitutive reference angles and the additional rotation of an orientation.
//!
//! # Components
//!
//! A component is *available* (free, can carry behaviour), *constrained* (enforced by the connection), *measured* (output
//! only) or absent. For each there is a position (output CP: a length, a coordinate, an angle with its turns), the
//! displacement from the initial position (CU) and from a reference (CCU), and for constrained ones the residual, what the
//! connection enforces to be zero. Rows of the Jacobian belong to the residual of a constrained component and to the
//! displacement of any other.
//!
//! # Signs
//!
//! A reported component force is internal: positive resists growth of its component. Nodal forces are residual-side, the
//! transposed rows times the component forces; the force on the body is minus that. FLOW-CONVERTER alone measures a minus
//! b: e3a·(δθ_a − δθ_b) − β_s δΨ_b.
//!
//! # Map
//!
//! Each module uses those above it in the table alone, but for two words: a flag of a connector has the code of a diagnostic ([`scene`]),
//! and a failed assertion of an [`audit`] prints its [`report`].
//!
//! | module | question |
//! |---|---|
//! | [`scalar`] | what is a number, and how do its functions keep their derivatives? |
//! | [`vector`], [`so3`] | how are vectors and rotations handled? |
//! | [`node`] | what does a measure see of two nodes, and how do its derivatives reach their degrees of freedom? |
//! | [`measure`] | what is measured? The mathematics |
//! | [`catalog`] | which connection types are there? The data |
//! | [`connector`] | what does one connector give at one state, after its history? |
//! | [`batch`] | what do many connectors of one type give, four at a time? |
//! | [`force`] | what do the forces of its components do to its nodes? |
//! | [`mpc`] | what does one multi-point constraint give at one state? |
//! | [`scene`] | what does a deck or a state file say? |
//! | [`behavior`] | which forces follow from a motion: springs, dampers, stops, locks, drives? |
//! | [`symbolic`] | which formulas are computed, and what are their derivatives? |
//! | [`evaluate`] | what is to be computed for a scene, and in which order? |
//! | [`audit`] | is it right, and how do we know? |
//! | [`mod@bench`] | what does it cost, at which error? |
//! | [`report`] | how is it shown? |
//!
//! ```
//! use pintle::catalog::ConnectionType;
//! use pintle::connector::{Connector, Definition, Increment, Request, State, Tally};
//! use pintle::node::{DOFS, Node, Pair};
//! use pintle::{so3, vector};
//!
//! // A REVOLUTE whose node b has turned by 0.3 rad about the shared axis e1.
//! let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
//! let initial = Pair { reference: [0.0; 3], a: node(vector::identity()), b: node(vector::identity()) };
//! let definition = Definition::new(ConnectionType::named("REVOLUTE", None)?, initial);
//! let connector = Connector::<f64>::new(&definition);
//! let turned = Pair { b: node(so3::matrix(so3::exp([0.3, 0.0, 0.0]))), ..initial };
//! let state = State { pair: turned, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
//! let (branch, mut tally) = (connector.initial_branch(), Tally::default());
//! let result = connector.evaluate(&state, &Increment::none(), &branch, &Request::everything(1), &mut tally);
//! assert_eq!(result.displacement[3], Some(0.3)); // ur1
//! let row = result.jacobian[3].ok_or("ur1 has a row")?;
//! assert_eq!(row[10..13], [1.0, 0.0, 0.0]); // ∂ur1/∂θb1, ∂ur1/∂θb2, ∂ur1/∂θb3
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod audit;
pub mod batch;
pub mod behavior;
pub mod bench;
pub mod catalog;
pub mod connector;
pub mod evaluate;
pub mod force;
mod grammar;
pub mod measure;
pub mod mpc;
pub mod node;
pub mod report;
pub mod scalar;
pub mod scene;
pub mod so3;
pub mod symbolic;
pub mod vector;

/// The version of this crate, as every report states it.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// The commit of its repository that a release of this crate was built from, with a mark where its sources had changes; none of a build for
/// development (debug), and of a crate from a registry.
pub const COMMIT: Option<&str> = option_env!("PINTLE_COMMIT");
