//! What an audit is to do.

use crate::oracles::oracle::Oracle;
use pintle_model::behavior::Conditions;
use serde::Serialize;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// What an audit is to do.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Settings {
    /// States per type for the oracles on doubles.
    pub states: usize,
    /// States per type near its singular sets, besides.
    pub near_singular_states: usize,
    /// States per type for the oracles on 237 bits, one from every region before any other, right angles last; without any the claim on derivatives is undecided.
    pub wide_states: usize,
    /// States on 237 bits of a scene in all: at least one of each connector, at most `wide_states`; none where that is 0.
    pub wide_states_of_a_scene: usize,
    /// States drawn about the initial one of a connector whose scene gives no states.
    pub drawn_states: usize,
    /// The time that the numbers of scenes may take; without it, the share of a scene that is judged does not depend on the machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<Budget>,
    /// The oracles asked.
    pub oracles: BTreeSet<Oracle>,
    /// What the random states are drawn from.
    pub seed: String,
    /// The temperature and the field variables of scenes: forces that depend on others are undecided.
    pub conditions: Conditions,
    /// Whether the singular points of the catalogue are approached.
    pub atlas: bool,
    /// Whether what is undecided fails.
    pub strict: bool,
    /// A fault planted on purpose, which the audit must tell of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planted: Option<Planted>,
}

/// A time that runs.
#[derive(Clone, Copy, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Budget {
    /// How much there was (s).
    pub seconds: f64,
    #[serde(skip)]
    end: Option<Instant>,
}

impl Budget {
    /// So much time (s) from now on; what is beyond all clocks never ends.
    pub fn from_now(seconds: f64) -> Self {
        let end = Duration::try_from_secs_f64(seconds).ok().and_then(|time| Instant::now().checked_add(time));
        Self { seconds, end }
    }

    /// What is left of it (s).
    pub fn left(&self) -> f64 {
        self.end.map_or(f64::INFINITY, |end| end.saturating_duration_since(Instant::now()).as_secs_f64())
    }
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            states: 800,
            near_singular_states: 200,
            wide_states: 30,
            wide_states_of_a_scene: 3000,
            drawn_states: 20,
            budget: None,
            oracles: Oracle::ALL.into(),
            seed: "pintle".into(),
            conditions: Conditions::default(),
            atlas: true,
            strict: false,
            planted: None,
        }
    }
}

impl Settings {
    /// Whether the oracle that answers for every quantity is asked at any state: without it numbers lack a witness anyway.
    pub fn asks_for_everything(&self) -> bool {
        self.wide_states > 0 && self.oracles.contains(&Oracle::WideDifferences)
    }
}

pintle_kinematics::named! {
    /// A fault planted on purpose: whoever doubts that the audit can fail sees it fail.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
    #[serde(rename_all = "kebab-case")]
    pub enum Planted {
        /// The largest first derivative of the first component of a connector, of a constraint, of a friction's forces, or the largest slope
        /// of a behaviour is multiplied by 1 + 1e-6.
        WrongEntry = "wrong-entry",
        /// The same derivative has the wrong sign: a mutant that changes it once more is right.
        WrongSign = "wrong-sign",
        /// The largest second derivative of the first component of a connector, or of a constraint, and the largest nodal force of that
        /// component are multiplied by 1 + 1e-6.
        WrongSecond = "wrong-second",
        /// The largest value of a connector, or of a constraint, is multiplied by 1 + 1e-6.
        WrongValue = "wrong-value",
        /// The largest rate is.
        WrongRate = "wrong-rate",
        /// The largest acceleration is.
        WrongAcceleration = "wrong-acceleration",
        /// The largest nodal force of the first component that has any is.
        WrongForce = "wrong-force",
        /// The largest slope of a friction force is multiplied by 1 + 1e-6.
        WrongFriction = "wrong-friction",
        /// The oracles on 237 bits lose the last entry of every row: what nobody compares cannot be noticed.
        LostAnswer = "lost-answer",
        /// The oracles on 237 bits lose the last component: numbers that no independent oracle judges are undecided.
        LostWitness = "lost-witness",
        /// The last component of the product's numbers is lost.
        LostComponent = "lost-component",
        /// The traced formulas on 237 bits have the wrong sign in the first row: one of two witnesses who contradict each other lies.
        WrongAnswer = "wrong-answer",
    }
}
