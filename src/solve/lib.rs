//! Reference solutions of small mechanisms of connectors.
mod dense;
mod equations;
mod integrate;
mod layout;
mod mechanism;
mod mode;
mod number;
mod run;
mod slide;
mod solution;
mod state;

pub use integrate::Method;
pub use number::Number;
pub use run::{Ended, Options, solve};
pub use solution::{ConnectorFrame, Difference, Energies, Event, Frame, NodeFrame, Solution, What};

use pintle_scene::Diagnostic;

/// Why a scene is not solved.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Refusal {
    /// The scene itself.
    #[error(transparent)]
    Scene(#[from] Diagnostic),
    /// What it asks for.
    #[error("{what}: {why}")]
    Of {
        /// The element or node.
        what: String,
        /// Why it is not solved.
        why: String,
        /// What can be done.
        remedy: String,
    },
}

impl Refusal {
    fn of(what: &str, why: &str, remedy: &str) -> Self {
        Self::Of { what: what.to_string(), why: why.to_string(), remedy: remedy.to_string() }
    }
}

#[cfg(test)]
mod tests;
