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
            pub(crate) const fn relation(self) -> &'static str {
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
    NotANumber = DiagnosisNotANumber, "no number", "0/0 or a root of less than zero at special states";
    Limited = DiagnosisLimited, "one bound wherever more is expected", "clamped";
    OfItsRow = DiagnosisOfItsRow, "what the row given makes of the rates", "wrong because the row is";
    NearOnly = DiagnosisNearOnly, "something else near special states", "a guard, a clamp, a series or another formula that begins there";
    DigitsLost = DiagnosisDigitsLost, "what is expected to fewer and fewer digits", "a formula that loses digits there";
    SinglePrecision = DiagnosisSinglePrecision, "what is expected to 24 bits", "single precision";
    Rounded = DiagnosisRounded, "what is expected to few decimal digits", "rounded, or written with too few digits";
    Differences = DiagnosisDifferences, "what is expected but for the last digits", "differences with a step, or constants with few digits";
    ComponentZero = DiagnosisComponentZero, "zero throughout", "not computed";
    SignLost = DiagnosisSignLost, "the magnitude of what is expected", "sign lost, as by acos or a norm";
    Reversed = DiagnosisSign, "minus what is expected", "opposite sign convention";
    NodesSwapped = DiagnosisNodesSwapped, "what is expected with a and b exchanged", "nodes swapped";
    RowsSwapped = DiagnosisComponentsSwapped, "what is expected of each other", "components swapped";
    SameSignForBoth = DiagnosisSignOfA, "minus what is expected", "sign of the first node";
    OtherJacobian = DiagnosisOtherJacobian, "the row of another Jacobian of the rotation vector", "Jacobian transposed, not inverted, or of the other side";
    RotationTakenAsLocal = DiagnosisRotationAsLocal, "Rᵀ × expected", "rotation degrees of freedom taken as local";
    RotationTurnedTwice = DiagnosisRotationTurnedTwice, "R × expected", "rotation degrees of freedom turned forth instead of back";
    DisplacementTakenAsLocal = DiagnosisDisplacementAsLocal, "Rᵀ × expected", "displacements of nodes taken along the axes of a node";
    TotalVector = DiagnosisTotalVector, "the derivative by the total rotation vector", "not spatial variations";
    BodyRates = DiagnosisBodyRates, "what rates along the axes of the node give", "angular velocities and accelerations taken along body axes";
    BlockTransposed = DiagnosisBlockTransposed, "the transpose of what is expected", "block transposed";
    DegreesForRadians = DiagnosisDegrees, "what is expected × 180/π or × π/180", "degrees for radians";
    LengthUnit = DiagnosisUnitOfLength, "what is expected × 1000 or × 0.001", "another unit of length";
    InitialKept = DiagnosisInitialKept, "what is expected and its initial value", "initial value not subtracted";
    InitialTwice = DiagnosisInitialTwice, "what is expected less its initial value", "initial value subtracted twice";
    ReferenceSubtracted = DiagnosisReference, "what is expected less the constitutive reference", "constitutive reference for the initial value, or besides it";
    InitialTurned = DiagnosisInitialTurned, "the relative displacement u_b − u_a along the axes of a", "the initial separation turned with a";
    AxesOfA = DiagnosisAxesOfA, "what is expected along the axes of a", "axes of a for those that are meant";
    AxesMidway = DiagnosisAxesMidway, "what is expected along axes midway between those of a and b", "axes midway for those of a";
    AxesOfB = DiagnosisAxesOfB, "what is expected along the axes of b", "axes of b for those of a";
    GlobalAxes = DiagnosisGlobalAxes, "what is expected along the global axes", "global axes for those of a";
    InitialAxes = DiagnosisInitialAxes, "what is expected along the initial axes of a", "axes that do not turn with a";
    AxisOfIncrement = DiagnosisHalfway, "the value before and the increment along another axis than e3a halfway", "an axis that is not that in the middle of the increment";
    TriadsTransposed = DiagnosisTriadsTransposed, "what is expected with triads transposed", "rows of triads taken for their columns";
    MotionIgnored = DiagnosisMotionIgnored, "what is expected with a motion left out", "a motion of a node does not count";
    StateBefore = DiagnosisStateBefore, "what was expected at the state before", "an increment late";
    TurnForgotten = DiagnosisTurnsForgotten, "what is expected less whole turns", "previous turns forgotten";
    TurnAdded = DiagnosisTurnsAdded, "what is expected and whole turns", "turns that were not made, or a range from 0 to 2π";
    WrongParity = DiagnosisHalfTurn, "what is expected and half a turn", "nπ of the wrong parity";
    Folded = DiagnosisFolded, "what is expected folded back at a right angle", "asin or atan for atan2";
    OtherParameters = DiagnosisOtherParameters, "another function of the same rotation", "another set of rotation parameters";
    OtherOrder = DiagnosisOtherOrder, "the angles of another sequence of axes", "another order of rotations";
    OtherLength = DiagnosisOtherLength, "another measure of length", "a square, a logarithm, a strain, or the length of another vector";
    Incremental = DiagnosisIncremental, "the value before and a row times the increment", "increments summed up";
    Increment = DiagnosisIncrement, "the change since the state before", "an increment for the total";
    RateForAcceleration = DiagnosisRateForAcceleration, "the row times rates of the other order", "rates for accelerations, or the other way round";
    Symmetrised = DiagnosisSymmetrised, "the symmetric part of what is expected", "a matrix made symmetric";
    AxisForGradient = DiagnosisAxisForGradient, "a direction of a triad", "an axis for the gradient of the angle";
    ConjugateForPrinted = DiagnosisConjugate, "the row of the component", "conjugate moment for the printed one, or the other way round";
    GeometricTermMissing = DiagnosisGeometricTerm, "what is expected without the term of the lever d × δθ", "geometric term missing";
    GeometricTermDoubled = DiagnosisLeverDoubled, "what is expected with twice the term of the lever d × δθ", "geometric term counted twice";
    LeverReversed = DiagnosisLeverReversed, "what is expected with minus the term of the lever d × δθ", "geometric term with the wrong sign";
    LeverAtB = DiagnosisLeverAtB, "what is expected with the lever d at b", "moment about the wrong node";
    FrameHeld = DiagnosisFrameHeld, "what is expected with the directions held", "directions do not turn in the second derivatives";
    BracketKept = DiagnosisNotSymmetrised, "the derivatives of the rows", "second derivatives not symmetrised by half the bracket";
    OneTriangle = DiagnosisOneTriangle, "one triangle of what is expected", "the other half of a symmetric matrix not filled";
    NodeLeftOut = DiagnosisNodeLeftOut, "zero", "one node left out";
    RotationHalved = DiagnosisRotationHalved, "half of what is expected", "rotation block halved";
    RotationDoubled = DiagnosisRotationDoubled, "twice what is expected", "rotation block doubled";
    FlowColumn = DiagnosisFlowColumn, "what is expected with a flow in another column", "flow, or β_s, in the wrong column";
    ColumnsSwapped = DiagnosisColumnsSwapped, "what is expected of each other", "columns swapped";
    RatesOfAIgnored = DiagnosisRatesOfA, "what the rates of the second node alone give", "rates of the first node ignored";
    QuadraticPartMissing = DiagnosisQuadraticPart, "what the accelerations alone give", "the part quadratic in the rates missing";
    QuadraticPartDoubled = DiagnosisQuadraticDoubled, "what is expected with another multiple of the part quadratic in the rates", "the part quadratic in the rates doubled, halved or reversed";
    Coriolis = DiagnosisCoriolis, "what is expected without a part of that quadratic in the rates", "the centripetal or the Coriolis part missing, halved or doubled";
    DerivativeForResolved = DiagnosisDerivative, "the time derivative of the component", "derivatives for nodal rates resolved along b";
    LinearPartMissing = DiagnosisLinearPart, "what the rates alone give", "the part linear in the accelerations missing";
    Linearised = DiagnosisLinearised, "what is expected of small motions about the initial state", "linearised";
    NotNormalised = DiagnosisNotNormalised, "what is expected times a length or cosine of the state", "not normalised";
    BlockReversed = DiagnosisSignOfBlock, "minus what is expected", "sign of a block";
    BlockMissing = DiagnosisBlockMissing, "zero", "block missing";
    NumberLeftOut = DiagnosisNumberLeftOut, "what the criterion gives without the number of a factor", "1/L for 2/L";
    MultipliedInsteadOfDivided = DiagnosisMultiplied, "what the criterion gives with a radius multiplied", "a moment times its radius, which must divide it";
    StickForSlip = DiagnosisStickForSlip, "the tangent of the other state", "stick for slip, or slip for stick";
    CouplingMissing = DiagnosisContactForceHeld, "what is expected with the contact force held", "coupling to what presses missing";
    ElasticForViscous = DiagnosisElasticForViscous, "what is expected of each other", "elastic and viscous slopes exchanged";
    SecantForTangent = DiagnosisSecant, "force / displacement over the whole motion or increment", "the secant instead of the tangent";
    ParametersSwapped = DiagnosisParametersSwapped, "what is expected with two lengths exchanged", "parameters exchanged";
    SumForNorm = DiagnosisSumForNorm, "what is expected with the sum of magnitudes for their norm", "a norm taken as a sum";
    TermLeftOut = DiagnosisTermLeftOut, "what is expected without one of its terms", "a term, a norm or a force left out, or of the other sign";
    OtherCoefficient = DiagnosisOtherCoefficient, "what is expected with another coefficient", "μ twice, or not at all";
    ContinuumForConsistent = DiagnosisContinuumTangent, "the tangent of an increment that goes to zero", "continuum for consistent tangent";
    OtherAxis = DiagnosisOtherAxis, "what is expected with the axes of both nodes in another order", "another axis of the nodes";
    Factor = DiagnosisFactor, "what is expected times a constant", "a constant factor";
    Regularised = DiagnosisRegularised, "the root of what is expected squared and a constant", "a regularised norm";
    Quadratic = DiagnosisQuadratic, "what is expected and a constant times its square", "an expansion that breaks off, or a term too much";
    Offset = DiagnosisOffset, "what is expected and a constant", "a constant offset";
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
            Self::RotationDoubled | Self::LeverReversed | Self::GeometricTermDoubled => 2.0,
            _ => 1.0,
        }
    }

    /// Whether it is one number, which an entry tells and the others confirm.
    pub(super) const fn is_constant(self) -> bool {
        matches!(
            self,
            Self::Factor | Self::Offset | Self::Scaled | Self::Limited | Self::Regularised | Self::Quadratic
        )
    }

    /// Whether it says something of single entries only, or that numbers are off by one constant: any other cause says more.
    pub(super) const fn says_little(self) -> bool {
        self.is_of_an_entry()
            || matches!(self, Self::Offset | Self::Factor | Self::BlockMissing | Self::BlockReversed)
            || matches!(self, Self::Regularised | Self::Quadratic)
    }

    /// Whether it says something of single entries only.
    pub(super) const fn is_of_an_entry(self) -> bool {
        matches!(self, Self::Dropped | Self::Sign | Self::Spurious | Self::Scaled)
    }
}
