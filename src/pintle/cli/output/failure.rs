//! What ends a command early, and its exit code.

use pintle_scene::Diagnostic;
use std::io;

/// What ends a command early.
#[derive(Debug, thiserror::Error)]
pub(crate) enum Failure {
    /// The command line asks for what there is not.
    #[error("{0}")]
    Usage(String),
    /// At least one verified mismatch; the report names it.
    #[error("at least one number is verified to be wrong")]
    Mismatch,
    /// A finding of a model is an error; the report names it.
    #[error("a finding of a model is an error")]
    Findings,
    /// Something is undecided, and that was asked to be an error.
    #[error("something is undecided")]
    Undecided,
    /// A mutant survived, or oracles contradict each other: the audit cannot be relied on.
    #[error("the self-test failed: a mutant was not noticed, or oracles contradict each other")]
    SelfTest,
    /// A fault was planted, and nothing of it was seen.
    #[error(
        "the self-test failed: the fault planted in {0} was not noticed, or changed nothing that is compared"
    )]
    Unnoticed(&'static str),
    /// Nothing was evaluated.
    #[error("nothing was evaluated: {0}")]
    Nothing(String),
    /// A scene or file of states that cannot be read or evaluated.
    #[error(transparent)]
    Scene(#[from] Diagnostic),
    /// Another file that cannot be read.
    #[error("{0}")]
    Input(String),
    /// Something would be lost, and may not be.
    #[error("{0}")]
    Lost(String),
    /// A file that cannot be written, or may not be.
    #[error("{0}")]
    Unwritten(String),
    /// The results cannot be written.
    #[error("cannot write the results: {0}")]
    Output(#[from] io::Error),
}

impl Failure {
    /// Whether the reader of the output has gone, as `head` does: no failure at all.
    fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }

    /// Says on stderr what is wrong, and gives the exit code.
    pub(crate) fn report(&self) -> u8 {
        if self.is_closed_pipe() {
            return 0;
        }
        match self {
            Self::Scene(diagnostic) => crate::cli::tell::show_diagnostic(diagnostic),
            other => crate::cli::tell::complain("error", &other.to_string()),
        }
        match self {
            Self::Lost(_) => 1,
            Self::Mismatch | Self::Findings => 1,
            Self::Usage(_) => 2,
            Self::Undecided => 3,
            Self::SelfTest | Self::Unnoticed(_) => 5,
            Self::Nothing(_) => 4,
            Self::Scene(_) | Self::Input(_) => 6,
            Self::Unwritten(_) | Self::Output(_) => 7,
        }
    }
}
