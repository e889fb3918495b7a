//! What the commands write, and what programs make of it.

pub(crate) mod bench; // whether times are told of right numbers, with their errors
mod check; // somebody's routine in a process
pub(crate) mod cli; // the command line
mod compare; // results of other programs, with faults drawn into them
pub(crate) mod convert; // scenes in other forms
mod doors; // one verdict through every door
pub(crate) mod export; // exported programs, compiled and run
pub(crate) mod files; // whether files are whole, and none is overwritten
pub(crate) mod handover; // counter-examples in other forms, each one run
mod own; // states of one's own, constraints of a scene, answers as bytes
pub(crate) mod pages; // whether the pages show what their commands print
pub(crate) mod reports; // whether reports of an audit show what was found
mod solve; // mechanisms in time
pub(crate) mod states; // states for other harnesses, read back
mod sweep; // one digest, whoever computes what and whoever is killed
