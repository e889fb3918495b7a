//! The tests, in one binary: each module asks one question of the whole.
#![expect(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test fails by panicking")]

mod assembly; // what assemblies of known mobility can do
mod audit; // whether the audit notices what is wrong, and nothing else
mod behavior; // forces that follow from motions
mod commands; // the command line: what each command writes
mod diagnosis; // whether what is wrong is told why
mod findings; // what an audit finds in models
mod friction; // what sticks and slips
mod golden; // what JAX computes by other formulas
mod golden_mpc; // the same of multi-point constraints
mod golden_relation; // the same of equations, rigid bodies, couplings and ties
mod laws; // what holds for every connection type
mod numbers; // whether numbers are right
mod scale; // large models: sparse matrices, threads, memory
mod scene; // what decks and state files mean
mod states; // where laws are tried
mod tolerance; // every tolerance, with the cause of the odd ones
