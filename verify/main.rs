//! The tests, in one binary: each module asks one question of the whole.
#![expect(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod assembly; // what assemblies of known mobility can do
mod audit; // whether the audit notices what is wrong, and nothing else
mod audit_candidate; // routines of one's own: one-forms, components that are too many, what is undecided
mod audit_command; // the audit and replay through the command line: exit codes, formats, counter-examples
mod audit_counterexample; // counter-examples of constraints, frictions and slopes
mod audit_edges; // states within rounding of a singular set, routines near one, files made by hand
mod audit_evidence; // whether nothing passes without evidence, and nothing hides behind a kink
mod audit_friction; // whether friction of scenes is audited, along its history
mod audit_jax; // JAX as an oracle of the audit
mod audit_laws; // whether the laws are asked of every connector, and speak
mod audit_model; // whether findings are told of the right thing, and as bad as they are taken to be
mod audit_structured; // states as models have them: one axis turns, shafts are aligned, forces are exactly zero
mod audit_units; // whether units and axes change a verdict
mod audit_verdict; // verdicts that differ by little: nearly right formulas, singular sets
mod batch; // whether four lanes give what one element at a time gives
mod behavior; // forces that follow from motions
mod bench; // whether times are told of right numbers, with their errors
mod cli; // the command line
mod closed; // rows derived by hand
mod convert; // scenes in other forms
mod diagnosis; // whether what is wrong is told why
mod export; // exported programs, compiled and run
mod faults; // what is said about every faulty input
mod findings; // what an audit finds in models
mod freedom; // which degrees of freedom nodes have
mod friction; // what sticks and slips
mod fuzzing; // what holds of any bytes whatever
mod golden; // what JAX computes by other formulas
mod golden_mpc; // the same of multi-point constraints
mod handover; // counter-examples in other forms, each one run
mod laws; // what holds for every connection type
mod manual; // the manual's summary tables, transcribed apart
mod numerics; // how exact the elementary functions and the rotations are
mod plane; // the two-dimensional forms
mod reports; // whether reports of an audit show what was found
mod rules; // what a connector section may do
mod scale; // large models: sparse matrices, threads, memory
mod scene; // what decks and state files mean
mod states; // where laws are tried
mod tolerance; // every tolerance, with the cause of the odd ones
mod wide; // the 237-bit scalar against mpmath
