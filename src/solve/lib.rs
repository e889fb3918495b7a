//! Reference solutions of small mechanisms of connectors: friction on the connector's own reaction, stick that is stick, and an error
//! beside every digit.
//!
//! Bodies are nodes with mass and inertia; connectors, multi-point constraints and relations join them. At each instant accelerations a and
//! forces f follow from
//!
//! > M a + Gᵀ f + Σ T_s g_s = F,  J a = −J̇ q̇,  T_s = μ F_N(f) of every friction that slips
//!
//! with rows J, forces G and biases of the connectors themselves ([`pintle_kinematics`]). A friction that sticks is an equation: its components
//! stand where they are. What slips is solved for with exact derivatives, for its limit depends on the forces that it changes.
//!
//! Steps are of high order, positions and rates return to their equations after each, and events are met by whole steps. Two methods
//! witness each other ([`Method`]); a solution on 237 bits ([`pintle_kinematics::scalar::Wide`]) shows what both have in common.
//!
//! | module | question |
//! |---|---|
//! | `motion` | the mechanics at one instant |
//! | `time` | steps, events, modes |
//! | `estimate` | how far from the truth, where rounding grows? |
//! | [`REFERENCES`] | decks to begin with |
//! | `number` | doubles, or 237 bits |
//!
//! ```
//! use pintle_scene::Scene;
//! use pintle_solve::{Options, solve};
//!
//! let deck = "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n9, , 1\n*CONNECTOR SECTION, ELSET=C\nCARTESIAN\n\
//!             *ELEMENT, TYPE=MASS, ELSET=M\n8, 1\n*MASS, ELSET=M\n2.\n\
//!             *STEP\n*DYNAMIC\n0.1, 3.\n*CLOAD\n1, 1, 4.\n*END STEP\n";
//! let scene = Scene::parse("mass.inp", deck)?;
//! let solution = solve::<f64>(&scene, &Options::default()).map_err(|ended| ended.why)?;
//! let last = solution.frames.last().ok_or("no frame")?;
//! assert!((last.nodes[0].displacement[0] - 9.0).abs() < 1e-13); // ½ (4/2) 3²
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod estimate;
mod fault;
mod motion;
mod number;
mod references;
mod refusal;
mod time;

pub use estimate::estimate;
pub use number::Number;
pub use references::REFERENCES;
pub use refusal::Refusal;
pub use time::integrate::Method;
pub use time::keep::{Keeping, Kept};
pub use time::run::{Ended, Options, Solvable, Stick, solve, solve_keeping};
pub use time::solution::{
    ConnectorFrame, Difference, Energies, Event, Frame, NodeFrame, Scales, Solution, What,
};

#[cfg(test)]
mod begin_tests;
#[cfg(test)]
mod carried_tests;
#[cfg(test)]
mod chains_tests;
#[cfg(test)]
mod tests;
