//! What makes wrong numbers of right ones, each cause with its code.

use crate::mutants::mutant::Mistake;
use pintle_scene::Code;
use serde::Serialize;

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
            pub(super) const fn relation(self) -> &'static str {
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
    pub(super) const fn gain(self) -> f64 {
        match self {
            Self::DegreesForRadians => 180.0 / std::f64::consts::PI,
            Self::RotationDoubled | Self::LeverReversed => 2.0,
            _ => 1.0,
        }
    }

    /// Whether it says something of single entries only.
    pub(super) const fn is_of_an_entry(self) -> bool {
        matches!(self, Self::Dropped | Self::Sign | Self::Spurious | Self::Scaled)
    }
}
