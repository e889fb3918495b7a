//! Why a scene is not solved.

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
    pub(crate) fn of(what: &str, why: &str, remedy: &str) -> Self {
        Self::Of { what: what.to_string(), why: why.to_string(), remedy: remedy.to_string() }
    }
}
