//! Is it right, and how do we know? Numbers judged against oracles that share as little with them as possible, by a bound that
//! follows from the conditioning of the state, with mutants of the same numbers as proof that the check would have spoken.
//!
//! A *case* ([`Case`]) is a connector, its history and a state. Its *numbers* ([`Quantity`]) are compared with what *oracles*
//! ([`Oracle`]) say, within the *bound* ([`bound`]); *laws* ([`Invariant`]) relate the numbers to each other and need no
//! reference. Each check is re-run on *mutants* ([`mutant`]): one that survives fails the audit itself.
//!
//! Independence is per claim:
//!
//! | claim | rests on |
//! |---|---|
//! | the derivative is that of the function | another mechanism and other elementary functions, state by state |
//! | the formula is the manual's | JAX, certified per type ([`certificate`]) |
//! | the declaration is the manual's | its summary table, transcribed a second time, certified per type |

pub mod assembly;
pub mod atlas;
pub mod behavior;
mod beside;
pub mod bound;
mod candidate;
pub mod case;
pub mod certificate;
pub mod conditioned;
pub mod counterexample;
pub mod coverage;
pub mod diagnosis;
mod differences;
mod engine;
mod examined;
mod failing;
mod force;
pub mod friction;
mod golden;
pub mod handover;
mod hex;
pub mod illustration;
pub mod invariant;
pub mod model;
pub mod mpc;
pub mod mutant;
mod near;
pub mod oracle;
mod outcome;
mod planted;
pub mod quantity;
mod recorded;
mod referee;
#[cfg(test)]
mod right_angles;
pub mod sample;
mod scene;
mod second;
pub mod sheet;
pub mod shrink;
mod sides;
mod singular;
mod slopes;
mod stage;
mod standing;
#[cfg(feature = "proptest")]
pub mod strategies;
mod sums;
pub mod truth;
pub mod verdict;

pub use atlas::Approach;
pub use bound::{Bound, C, U};
pub use candidate::{Candidate, Given};
pub use case::{Case, Step};
pub use counterexample::CounterExample;
pub use coverage::{Coverage, Exercise, Sample};
pub use diagnosis::{Cause, Diagnosis, Explained};
pub use engine::{Settings, audit_case, audit_cases, audit_catalogue};
pub use failing::{Example, Failing};
pub use force::product_with_forces as product;
pub use friction::{FrictionCase, friction_cases};
pub use handover::ExportError;
pub use hex::Hex;
pub use illustration::{Compared, Comparison, Illustration, Steps, illustrate_catalogue, illustrate_scene};
pub use invariant::Invariant;
pub use mpc::MpcCase;
pub use oracle::Oracle;
pub use outcome::{Against, Check, Found, Report, Subject};
pub use planted::Planted;
pub use quantity::{Entries, Numbers, Quantity};
pub use recorded::{FoundIn, Kind, Recorded};
pub use scene::{Target, audit_scenes, drawn_coverage};
pub use sides::Sides;
pub use verdict::{Fared, Finding, Judgement, Score, Verdict};
