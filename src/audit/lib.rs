//! Is it right, and how do we know? Numbers judged against oracles that share as little with them as possible, by a bound that
//! follows from the conditioning of the state. Mutants of the same numbers prove that the check would have spoken.
//!
//! A *case* ([`Case`]) is a connector, its history and a state. Its *numbers* ([`Quantity`]) are compared with what *oracles*
//! ([`Oracle`]) say, within the *bound* ([`judge::bound`]); *laws* ([`Invariant`]) relate the numbers to each other and need no
//! reference. Each check is re-run on *mutants* ([`mutants`]): one that survives fails the audit itself.
//!
//! Independence is per claim:
//!
//! | claim | rests on |
//! |---|---|
//! | the derivative is that of the function | another mechanism and other elementary functions, state by state |
//! | the formula is the manual's | JAX, certified per type ([`oracles::certificate`]) |
//! | the declaration is the manual's | its summary table, transcribed a second time, certified per type |

pub mod behavior;
mod candidate;
pub mod case;
mod engine;
pub mod friction;
pub mod illustration;
pub mod judge;
pub mod laws;
mod measured;
pub mod model;
pub mod mpc;
pub mod mutants;
pub mod oracles;
pub mod relation;
pub mod replay;
pub mod sampling;
mod scene;
pub mod settings;
mod share;
pub mod singular;

pub use candidate::{
    Candidate, ConstraintCandidate, Domain, FrictionCandidate, Given, Question, Right, Tangent,
};
pub use case::failing::{Failing, FrictionCase, MpcCase, RelationCase};
pub use case::hex::Hex;
pub use case::quantity::{Entries, Numbers, Quantity};
pub use case::{Case, Step, initial_places, values_before};
pub use engine::{audit_case, audit_cases, audit_catalogue};
pub use friction::{FrictionNumbers, FrictionSubject, friction_cases};
pub use illustration::{Illustration, Steps, illustrate_catalogue, illustrate_scene};
pub use judge::bound::{Bound, C};
pub use judge::comparison::{Compared, Comparison};
pub use judge::outcome::{Against, Check, Report, Subject};
pub use judge::verdict::{Fared, Finding, Judgement, Score, Verdict};
pub use laws::Invariant;
pub use measured::{AgainstTruth, Measured, against_truth, others_against_truth};
pub use mpc::ConstraintNumbers;
pub use mutants::diagnosis::{Cause, Diagnosis, Explained};
pub use oracles::force::product_with_forces as product;
pub use oracles::oracle::Oracle;
pub use pintle_kinematics::scalar::U;
pub use replay::again::Found;
pub use replay::counterexample::{About, CounterExample};
pub use replay::handover::ExportError;
pub use sampling::coverage::{Coverage, Exercise, Sample};
pub use scene::{Progress, Target, audit_scenes, connector_at, constraint_at, drawn_coverage};
pub use settings::{Budget, Planted, Settings};
pub use share::Share;
pub use singular::atlas::Approach;
pub use singular::near::{Sites, has_sites, near_initial};
pub use singular::sides::Sides;
