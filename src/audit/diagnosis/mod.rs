//! Why is it wrong? Wrong numbers are matched against what known mistakes make of the right ones: those of the self-test
//! ([`super::mutant`]) and changes of convention.
//!
//! Numbers of a connector's components are [`Symptoms`]; those of multi-point constraints, frictions and slopes of behaviour stand in
//! a [`Sheet`](super::sheet::Sheet).
//!
//! A mistake *fits* where every entry that it makes is the one given, within the tolerance. One that fits is believed where chance
//! would not do it: an entry off by n tolerances is met by chance once in n, so that it is worth log₂ n bits, and all entries
//! explained must be worth log₂(1000 N) bits together, N being the number of mistakes tried. A mistake explains more than another
//! where the entries that only it explains are worth log₂ 1000 bits; those that explain as much are named beside it, for at this
//! state they make the same numbers. Where nothing is believed, that is said. Numbers that have lost digits besides are tried
//! again with tolerances so much wider.

mod component;
mod matching;
mod sheet;

use super::mutant::Mistake;
use crate::grammar::count;
use crate::scene::Code;
use serde::Serialize;

pub use component::{Symptoms, diagnose};
pub use sheet::diagnose_sheet;

macro_rules! causes {
    ($($variant:ident = $code:ident, $relation:literal, $meaning:literal;)+) => {
        /// What makes wrong numbers of right ones. Where two make the same, the first is named first.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Cause {
            $(#[doc = concat!("The numbers equal ", $relation, ": ", $meaning, ".")] $variant,)+
        }

        impl Cause {
            /// The code, which `pintle explain` explains.
            pub const fn code(self) -> Code {
                match self { $(Self::$variant => Code::$code),+ }
            }

            /// What the numbers equal.
            const fn relation(self) -> &'static str {
                match self { $(Self::$variant => $relation),+ }
            }

            /// What that means, in a few words.
            pub const fn meaning(self) -> &'static str {
                match self { $(Self::$variant => $meaning),+ }
            }
        }
    };
}

causes! {
    NodesSwapped = DiagnosisNodesSwapped, "what is expected with a and b exchanged", "nodes swapped";
    RowsSwapped = DiagnosisComponentsSwapped, "what is expected of each other", "components swapped";
    Reversed = DiagnosisSign, "minus what is expected", "opposite sign convention";
    SameSignForBoth = DiagnosisSignOfA, "minus what is expected", "sign of the first node";
    RotationTakenAsLocal = DiagnosisRotationAsLocal, "Rᵀ × expected", "rotation degrees of freedom taken as local";
    RotationTurnedTwice = DiagnosisRotationTurnedTwice, "R × expected", "rotation degrees of freedom turned forth instead of back";
    BlockTransposed = DiagnosisBlockTransposed, "the transpose of what is expected", "block transposed";
    DegreesForRadians = DiagnosisDegrees, "what is expected × 180/π or × π/180", "degrees for radians";
    RotationHalved = DiagnosisRotationHalved, "half of what is expected", "rotation block halved";
    RotationDoubled = DiagnosisRotationDoubled, "twice what is expected", "rotation block doubled";
    GeometricTermMissing = DiagnosisGeometricTerm, "what is expected without the term of the lever d × δθ", "geometric term missing";
    LeverReversed = DiagnosisLeverReversed, "what is expected with minus the term of the lever d × δθ", "geometric term with the wrong sign";
    BracketKept = DiagnosisNotSymmetrised, "the derivatives of the rows", "second derivatives not symmetrised by half the bracket";
    ColumnsSwapped = DiagnosisColumnsSwapped, "what is expected of each other", "columns swapped";
    TurnForgotten = DiagnosisTurnsForgotten, "what is expected less whole turns", "previous turns forgotten";
    WrongParity = DiagnosisHalfTurn, "what is expected and half a turn", "nπ of the wrong parity";
    RatesOfAIgnored = DiagnosisRatesOfA, "what the rates of the second node alone give", "rates of the first node ignored";
    QuadraticPartMissing = DiagnosisQuadraticPart, "what the accelerations alone give", "the part quadratic in the rates missing";
    NumberLeftOut = DiagnosisNumberLeftOut, "what the criterion gives without the number of a factor", "1/L for 2/L";
    MultipliedInsteadOfDivided = DiagnosisMultiplied, "what the criterion gives with a radius multiplied", "a moment times its radius, which must divide it";
    StickForSlip = DiagnosisStickForSlip, "the tangent of the other state", "stick for slip, or slip for stick";
    CouplingMissing = DiagnosisContactForceHeld, "what is expected with the contact force held", "coupling to what presses missing";
    ElasticForViscous = DiagnosisElasticForViscous, "what is expected of each other", "elastic and viscous slopes exchanged";
    SecantForTangent = DiagnosisSecant, "force / displacement over the whole motion or increment", "the secant instead of the tangent";
    Dropped = DiagnosisDropped, "zero", "entry dropped";
    Sign = DiagnosisSignOfEntry, "minus what is expected", "sign of an entry";
    Spurious = DiagnosisSpurious, "what must be zero", "entry that must be zero";
    Scaled = DiagnosisScaled, "what is expected times a factor", "entry scaled";
}

impl Serialize for Cause {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.code().serialize(serializer)
    }
}

impl Cause {
    /// The cause that a mistake of the self-test is.
    pub const fn of(mistake: Mistake) -> Self {
        match mistake {
            Mistake::Scaled(_) => Self::Scaled,
            Mistake::Dropped => Self::Dropped,
            Mistake::Sign => Self::Sign,
            Mistake::Spurious => Self::Spurious,
            Mistake::RowsSwapped => Self::RowsSwapped,
            Mistake::ColumnsSwapped => Self::ColumnsSwapped,
            Mistake::BlockTransposed => Self::BlockTransposed,
            Mistake::RotationTakenAsLocal => Self::RotationTakenAsLocal,
            Mistake::NodesSwapped => Self::NodesSwapped,
            Mistake::SameSignForBoth => Self::SameSignForBoth,
            Mistake::RotationHalved => Self::RotationHalved,
            Mistake::DegreesForRadians => Self::DegreesForRadians,
            Mistake::GeometricTermMissing => Self::GeometricTermMissing,
            Mistake::BracketKept => Self::BracketKept,
            Mistake::WrongParity => Self::WrongParity,
            Mistake::TurnForgotten => Self::TurnForgotten,
            Mistake::RatesOfAIgnored => Self::RatesOfAIgnored,
            Mistake::QuadraticPartMissing => Self::QuadraticPartMissing,
            Mistake::NumberLeftOut => Self::NumberLeftOut,
            Mistake::MultipliedInsteadOfDivided => Self::MultipliedInsteadOfDivided,
            Mistake::StickForSlip => Self::StickForSlip,
            Mistake::CouplingMissing => Self::CouplingMissing,
            Mistake::ElasticForViscous => Self::ElasticForViscous,
            Mistake::SecantForTangent => Self::SecantForTangent,
        }
    }

    /// By how much rounding of what is expected grows in it.
    const fn gain(self) -> f64 {
        match self {
            Self::DegreesForRadians => 180.0 / std::f64::consts::PI,
            Self::RotationDoubled | Self::LeverReversed => 2.0,
            _ => 1.0,
        }
    }

    /// Whether it says something of single entries only.
    const fn is_of_an_entry(self) -> bool {
        matches!(self, Self::Dropped | Self::Sign | Self::Spurious | Self::Scaled)
    }
}

/// One mistake that explains wrong entries.
#[derive(Clone, Debug, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Explained {
    /// The mistake.
    #[serde(skip)]
    pub cause: Cause,
    /// Its code.
    #[schemars(with = "String")]
    pub code: Code,
    /// What equals what, and what that means.
    pub sentence: String,
    /// Others that make the same numbers at this state.
    #[schemars(with = "Vec<String>")]
    pub also: Vec<Code>,
}

/// Why numbers are wrong.
#[derive(Clone, Debug, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Diagnosis {
    /// The mistakes that explain wrong entries, the one that explains most first.
    pub causes: Vec<Explained>,
    /// Wrong entries that no known mistake explains.
    pub unexplained: usize,
}

impl Diagnosis {
    /// One line for each mistake, and one for what nothing explains, with codes.
    pub fn lines(&self) -> Vec<(String, Code)> {
        let mut lines: Vec<(String, Code)> =
            self.causes.iter().map(|found| (found.said(), found.code)).collect();
        if self.unexplained > 0 {
            let besides = if self.causes.is_empty() { "" } else { " besides" };
            let entries = count(self.unexplained, "wrong entry");
            lines.push((format!("no known mistake explains {entries}{besides}"), Code::DiagnosisUnknown));
        }
        lines
    }

    /// Whether known mistakes explain all that is wrong.
    pub fn is_whole(&self) -> bool {
        self.unexplained == 0 && !self.causes.is_empty()
    }

    /// Whether it says more than another about the same check: all is explained, by fewer mistakes, with fewer alternatives.
    pub(super) fn is_clearer_than(&self, other: &Self) -> bool {
        let rank = |one: &Self| {
            let also: usize = one.causes.iter().map(|found| found.also.len()).sum();
            (one.causes.is_empty(), one.unexplained > 0, one.causes.len(), also)
        };
        rank(self) < rank(other)
    }
}

impl Explained {
    fn said(&self) -> String {
        if self.also.is_empty() {
            return self.sentence.clone();
        }
        let others: Vec<&str> = self.also.iter().map(|code| code.as_str()).collect();
        format!("{} (at this state the same as {})", self.sentence, others.join(", "))
    }
}
