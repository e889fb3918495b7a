//! What the commands write: to the terminal, to files, and when they fail.

mod failure;
pub(crate) mod npz;
mod save;
mod show;
pub(crate) mod tell;

pub(crate) use failure::Failure;
pub(crate) use save::Files;
pub(crate) use show::Show;
