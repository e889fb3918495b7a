//! What is wrong with an input, where, and what to do about it.

use crate::label::Label;
use crate::span::Span;
use crate::wording::Words;
use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents, SourceCode,
    SourceSpan, SpanContents,
};
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt::{self, Display};
use std::io::BufRead;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Nothing is wrong, and it is worth knowing: what an audit found of a model.
    Note,
    /// The input was read, but something in it deserves a look.
    Warning,
    /// The input was not read.
    Error,
}

/// How the explanation of a code ends that declares how bad it is.
macro_rules! ending {
    (Note) => {
        " A note."
    };
    (Warning) => {
        " A warning."
    };
}

macro_rules! codes {
    ($($variant:ident = $text:literal: $explanation:literal $(, $severity:ident)?;)+) => {
        /// The stable codes of diagnostics. They never change their meaning.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum Code {
            $(#[doc = concat!("`", $text, "`: ", $explanation $(, ending!($severity))?)] $variant,)+
        }

        impl Code {
            /// Every code, in the order in which they are listed.
            pub const ALL: &'static [Self] = &[$(Self::$variant),+];

            /// The code as it is printed, such as `deck::unknown-parameter`.
            #[must_use]
            pub fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $text),+ }
            }

            /// What the code means, in one or two sentences.
            #[must_use]
            pub fn explanation(self) -> &'static str {
                match self { $(Self::$variant => concat!($explanation $(, ending!($severity))?)),+ }
            }

            /// How bad it is where that is not as of others of its group.
            const fn declared(self) -> Option<Severity> {
                match self { $($(Self::$variant => Some(Severity::$severity),)?)+ _ => None }
            }
        }
    };
}

codes! {
    Unreadable = "scene::unreadable": "The file could not be opened or read.";
    UnknownFormat = "scene::unknown-format": "The ending of the file name does not say how to read the file.";

    SceneMalformed = "scene::malformed": "A scene in TOML or JSON is not well-formed.";
    SceneTooDeep = "scene::too-deep": "Values of a scene in TOML or JSON lie more than 32 deep within each other.";
    SceneUnknownSchema = "scene::unknown-schema": "A scene in TOML or JSON says that it has another form than this version of pintle reads.";
    SceneUnknownField = "scene::unknown-field": "A scene in TOML or JSON has a field that does not exist there.";
    SceneMissingField = "scene::missing-field": "A scene in TOML or JSON lacks a field that must be there.";
    SceneRepeatedField = "scene::repeated-field": "A scene in TOML or JSON gives one field or name twice.";
    SceneWrongType = "scene::wrong-type": "A value of a scene in TOML or JSON is of another kind than the field takes, such as a text where a number is wanted.";
    SceneUnknownWord = "scene::unknown-word": "A field of a scene in TOML or JSON takes one of a few words, and has another one.";

    LineTooLong = "deck::line-too-long": "A line of a deck is longer than 65 535 bytes.";
    NotUtf8 = "deck::not-utf8": "A line that has to be read contains bytes that are not UTF-8. Comments, headings and skipped lines may.";
    UnclosedQuote = "deck::unclosed-quote": "A quotation mark opens a name and none closes it on the same line.";
    DanglingContinuation = "deck::dangling-continuation": "A keyword line ends in a comma, so the next line should continue it, but that is another keyword or the end of the deck.";
    EmptyKeyword = "deck::empty-keyword": "An asterisk without a keyword.";
    StrayData = "deck::stray-data": "A data line that belongs to no keyword.";
    UnexpectedData = "deck::unexpected-data": "A data line under a keyword that takes none, or takes fewer.";
    MissingKeywords = "deck::missing-keywords": "The deck has no keyword at all.";

    IncludeUnreadable = "deck::include-unreadable": "A file that a deck includes is not there or cannot be opened.";
    IncludeCycle = "deck::include-cycle": "A file includes itself, directly or through others.";
    IncludeLimit = "deck::include-limit": "Includes nest too deep, or are too many or too large altogether.";

    UnsupportedKeyword = "deck::unsupported-keyword": "A keyword or parameter that acts on nodes of connectors or constraints, or changes the deck itself, and is not understood; skipping it would give another model.";
    NotFollowed = "deck::not-followed": "A keyword changes connectors, or where their nodes are, and that is not followed: *MODEL CHANGE, *IMPERFECTION, *BOUNDARY and *CLOAD with a parameter that is not read, an *EQUATION of displacements and a degree of freedom of other physics, or a model that stands in another deck (*RESTART, READ; *IMPORT).", Warning;
    ItemsAfterCoordinates = "deck::items-after-coordinates": "A line of *NODE goes on after the third coordinate, and what follows is no normal: of numbers with decimal commas the digits become further items.", Warning;
    MisspeltKeyword = "deck::misspelt-keyword": "A keyword was skipped that looks like a misspelt one.", Warning;
    MisplacedKeyword = "deck::misplaced-keyword": "A keyword that must follow another one, such as a suboption outside a connector behaviour.";
    ModelDataInStep = "deck::model-data-in-step": "A keyword that defines the model stands after the first *STEP.";
    HistoryOutsideStep = "deck::history-outside-step": "A keyword that belongs to a step stands outside every step.";
    UnfinishedBlock = "deck::unfinished-block": "A *PART, *INSTANCE or *ASSEMBLY does not end.";
    MissingAssembly = "deck::missing-assembly": "A deck defines parts and has no *ASSEMBLY, so that it has no model.";
    UnusedPart = "deck::unused-part": "A part that no instance uses: nothing of it is in the model.", Warning;
    UnknownPart = "deck::unknown-part": "An instance is one of a part that is not defined above it.";
    UnknownInstance = "deck::unknown-instance": "An instance is named that is not defined above.";
    DegenerateRotation = "deck::degenerate-rotation": "The two points of the axis about which an instance is turned coincide.";
    TwoTransforms = "deck::two-transforms": "A node is in the sets of two *TRANSFORMs.";
    NodesOfSkipped = "deck::nodes-of-skipped": "A node set takes the nodes of elements of types that are not read, so that it lacks them. Where the set must be complete, the deck is not read.", Warning;
    UnfinishedStep = "deck::unfinished-step": "A *STEP has no *END STEP.";
    TwoProcedures = "deck::two-procedures": "A step has two procedures.";
    MixedSolvers = "deck::mixed-solvers": "Some steps are explicit dynamics and others are not.";

    UnknownParameter = "deck::unknown-parameter": "A keyword that is understood has a parameter that is not.";
    MissingParameter = "deck::missing-parameter": "A parameter that the keyword needs is not there.";
    RepeatedParameter = "deck::repeated-parameter": "A parameter stands twice on one keyword line.";
    BadParameterValue = "deck::bad-parameter-value": "The value of a parameter is missing, superfluous or not one of those allowed.";
    RepeatedSuboption = "deck::repeated-suboption": "A suboption that may stand once in a behaviour, or once for a component, stands twice.";
    ConflictingParameters = "deck::conflicting-parameters": "Two parameters exclude each other.";

    MissingData = "deck::missing-data": "A data line, or an item of it, is not there.";
    SurplusData = "deck::surplus-data": "A data line has more items than its keyword takes.";
    MalformedNumber = "deck::malformed-number": "An item is not a number. Allowed are 1, 1., .5, 1.E-3 and 1.D-3, without blanks inside.";
    MalformedInteger = "deck::malformed-integer": "An item is not a whole number.";
    NumberOutOfRange = "deck::number-out-of-range": "A number is too large or too small for a double, or outside the range that is allowed here.";
    MalformedName = "deck::malformed-name": "A name is empty or has a quotation mark inside.";
    BadComponent = "deck::bad-component": "A component of relative motion is not one of 1 to 6.";
    BadDegreeOfFreedom = "deck::bad-degree-of-freedom": "A degree of freedom is not one of 1 to 6, or 10 (material flow); of boundary conditions and loads those of other physics, up to 30, are skipped.";
    BadValue = "deck::bad-value": "An item is not one of those allowed here.";

    DuplicateNode = "deck::duplicate-node": "A node is defined twice, at different places.";
    DuplicateElement = "deck::duplicate-element": "An element is defined twice, and differently.";
    DuplicateName = "deck::duplicate-name": "Two definitions of one kind have the same name.";
    BadLabel = "deck::bad-label": "The number of a node or element is 0 or larger than 2^53.";
    BadConnectivity = "deck::bad-connectivity": "An element has too few, too many or equal nodes.";
    GenerateRange = "deck::generate-range": "A GENERATE range is empty, endless or larger than ten million, or all sets together are too large.";
    GenerateGaps = "deck::generate-gaps": "A GENERATE range names numbers that do not exist.", Warning;
    EmptySet = "deck::empty-set": "A set that is used has no members of the kind that is needed.";
    SetCycle = "deck::set-cycle": "A set contains itself, directly or through others.";

    UnknownNode = "deck::unknown-node": "A node is used that is not defined.";
    UnknownElement = "deck::unknown-element": "An element is used that is not defined.";
    UnknownNodeSet = "deck::unknown-node-set": "A node set is used that is not defined.";
    UnknownElementSet = "deck::unknown-element-set": "An element set is used that is not defined.";
    UnknownOrientation = "deck::unknown-orientation": "An orientation is used that is not defined.";
    UnknownBehavior = "deck::unknown-behavior": "A connector behaviour is used that is not defined.";
    UnknownAmplitude = "deck::unknown-amplitude": "An amplitude is used that is not defined.";
    UnknownDerivedComponent = "deck::unknown-derived-component": "A derived component is used that its behaviour does not define.";
    UnknownSurface = "deck::unknown-surface": "A surface is used that is not defined.";
    TieApart = "deck::tie-apart": "Nodes of the dependent surface of a *TIE are farther from the other one than its position tolerance, and are not tied.", Warning;
    UnknownMpc = "deck::unknown-mpc": "A multi-point constraint type that does not exist.";
    MpcNotEvaluated = "deck::mpc-not-evaluated": "A multi-point constraint type that is kept but not evaluated.", Warning;
    WrongElementType = "deck::wrong-element-type": "A property is given to elements of another type.";
    MissingSection = "deck::missing-section": "A connector element has no *CONNECTOR SECTION.";
    TwoSections = "deck::two-sections": "A connector element has two *CONNECTOR SECTIONs.";
    MissingFriction = "deck::missing-friction": "A *CONNECTOR FRICTION has no *FRICTION, so no friction coefficient.";
    DegenerateOrientation = "deck::degenerate-orientation": "The points of an orientation do not define three directions.";
    UnsupportedOrientation = "deck::unsupported-orientation": "An orientation that a connector uses comes from a user subroutine or a *DISTRIBUTION.";
    LimitsReversed = "deck::limits-reversed": "A lower limit lies above the upper one.";
    LimitsMissing = "deck::limits-missing": "A stop, lock or failure without any limit.", Warning;
    TableOrder = "deck::table-order": "The independent variable of a table does not increase.";
    NonzeroModelBoundary = "deck::nonzero-model-boundary": "A boundary condition before the first step has a magnitude other than zero.", Warning;

    UnknownConnectionType = "rule::unknown-connection-type": "A connector section names no connection type, one that does not exist, or two that do not pair.";
    OrientationRequired = "rule::orientation-required": "An orientation is missing where the connection type requires one.";
    OrientationIgnored = "rule::orientation-ignored": "An orientation is given where the connection type does not use one.";
    NotInTwoDimensions = "rule::not-in-two-dimensions": "A CONN2D2 element has a connection type without a two-dimensional form.";
    NotInProcedure = "rule::not-in-procedure": "The connection type is not available for the solver of the steps.";
    StopNotAvailable = "rule::stop-not-available": "A stop on a component that cannot have one.";
    ReferenceNotAvailable = "rule::reference-not-available": "A constitutive reference for a component that cannot have one.";
    ActionNotAvailable = "rule::action-not-available": "A behaviour, motion or load on a component that is not available.";
    FrictionNotPredefined = "rule::friction-not-predefined": "Predefined friction for a connection type that has none.";
    FrictionParameters = "rule::friction-parameters": "More or fewer parameters of predefined friction than the connection type takes.";
    SectionDataUnused = "rule::section-data-unused": "Section data for a connection type that takes none, or less.";
    ConvertedInStandard = "rule::converted-in-standard": "The connection type is another one in a Standard analysis, and is evaluated as such.", Warning;
    DofEliminated = "rule::dof-eliminated": "A degree of freedom is made dependent by two multi-point constraints, or by one and prescribed besides.";
    MpcAxes = "rule::mpc-axes": "The axes of an MPC UNIVERSAL are not orthogonal, or parallel.", Warning;
    CoincidentNodes = "rule::coincident-nodes": "A length or direction is needed, and the nodes coincide initially.";
    ZRectangularNotInExplicit = "rule::z-rectangular-not-in-explicit": "An orientation with SYSTEM=Z RECTANGULAR in an Explicit analysis.";
    DirectionNotInExplicit = "rule::direction-not-in-explicit": "An orientation cannot stand in for the direction between coincident nodes in an Explicit analysis.", Warning;
    ControlsNotInExplicit = "rule::controls-not-in-explicit": "CONTROLS on a connector section in an Explicit analysis.", Warning;
    EliminationNotInStandard = "rule::elimination-not-in-standard": "ELIMINATION on a connector section in a Standard analysis.", Warning;
    IntegrationNotInStandard = "rule::integration-not-in-standard": "INTEGRATION on a connector behaviour in a Standard analysis.", Warning;
    FrequencyNotInExplicit = "rule::frequency-not-in-explicit": "Elasticity or damping that depends on frequency in an Explicit analysis.";
    UnsymmetricNotInExplicit = "rule::unsymmetric-not-in-explicit": "Elasticity or damping with UNSYMM in an Explicit analysis.";
    StructuralDampingNotInExplicit = "rule::structural-damping-not-in-explicit": "Structural damping in an Explicit analysis.", Warning;
    FailureNotAvailable = "rule::failure-not-available": "A failure is triggered by, or releases, a component that the connector does not have; or, in a Standard analysis, one that is not available.";
    LockNotAvailable = "rule::lock-not-available": "A lock is triggered by a component that the connector does not have, or locks one that is not available.";
    ContactAngleDefault = "rule::contact-angle-default": "A SLIPRING with friction has no contact angle, which in a Standard analysis is then zero.", Warning;
    MpcNotInExplicit = "deck::mpc-not-in-explicit": "A multi-point constraint REVOLUTE or UNIVERSAL in an Explicit analysis.";
    OutOfPlane = "rule::out-of-plane": "A node of a CONN2D2 element lies out of the plane z = 0, or an orientation does not have e3 along the global z; at a and b the same way. A warning: an equation of a two-dimensional model has degree of freedom 3, 4 or 5.";
    NegativeRadius = "rule::negative-radius": "A node of a CONN2D2 element in an axisymmetric model has a negative coordinate 1, which is the radius.";
    RepeatedConstraint = "rule::repeated-constraint": "Two connectors between the same nodes, with the same orientations, constrain the same components.", Warning;
    CrowdedSliprings = "rule::crowded-sliprings": "More than two SLIPRINGs share a node.";
    FrictionParameterUnused = "rule::friction-parameter-unused": "A number of predefined friction is given that no criterion holds in our reading.", Warning;
    LockVelocity = "rule::lock-velocity": "A lock in an Explicit analysis has items after its limits, which are read as temperature and field variables.", Warning;
    OpposedSliprings = "rule::opposed-sliprings": "Two SLIPRINGs with friction both end, or both begin, at the node that they share.", Warning;
    NoRotation = "rule::no-rotation": "A rotation is prescribed at a node of a connector that has no rotational degrees of freedom.", Warning;

    StatesMalformed = "states::malformed": "The file is not well-formed CSV or JSON of the documented form.";
    StatesUnknownColumn = "states::unknown-column": "A column of a CSV file of states or forces, or a force in a JSON file, has a name that is not known.";
    StatesRepeatedColumn = "states::repeated-column": "Two columns of a CSV file of states or forces have the same name or meaning, or a JSON file gives a force twice.";
    StatesMissingColumn = "states::missing-column": "A CSV file of states has no column `node`, or one of forces no column `element`.";
    StatesUnknownNode = "states::unknown-node": "A state moves a node that the scene does not have.";
    StatesRepeatedNode = "states::repeated-node": "A state gives one node twice.";
    StatesMalformedNumber = "states::malformed-number": "An item is not a number.";
    StatesNumberOutOfRange = "states::number-out-of-range": "A number is too large or too small for a double.";
    StatesTwoRotations = "states::two-rotations": "A node has a rotation vector and a quaternion in one state.";
    StatesQuaternionNorm = "states::quaternion-norm": "The norm of a quaternion differs from 1 by more than 1e-6.";
    StatesRotationTooLarge = "states::rotation-too-large": "A rotation vector is longer than 1e8 rad, where a double no longer resolves 1e-8 rad.";
    StatesNoRotation = "states::no-rotation": "A state turns a node of a connector that has no rotational degrees of freedom. A node has them where a connector permits an orientation (not JOIN, AXIAL or LINK), or from ROTARYI, springs and dashpots in 4 to 6, the constraints BEAM, REVOLUTE, UNIVERSAL and TIE to a node that has them, beams, shells, rigid and user elements, or as the reference node of a rigid body or coupling.";
    StatesOutOfPlane = "states::out-of-plane": "A state moves a node of a CONN2D2 element along 3, or turns it about 1 or 2.";
    StatesOrder = "states::order": "The numbers of the states do not increase, or the rows of one state have different times.";
    StatesEmpty = "states::empty": "The file has no state.";

    ForcesUnknownElement = "forces::unknown-element": "Forces are given for a connector element that the scene does not have.";
    ForcesRepeatedElement = "forces::repeated-element": "A state is given the forces of one element twice.";
    ForcesUnknownState = "forces::unknown-state": "Forces are given for a state, by number or time, that there is not, or for a time that several states have.";
    ForcesAbsentComponent = "forces::absent-component": "A force that is not zero is given for a component that the connector does not have, or that has no force.";
    ForcesNotATotal = "forces::not-a-total": "Of an available component only the reaction CRF or CRM is given, which is a part of its total force.";
    ForcesContradiction = "forces::contradiction": "The total force and the reaction of a constrained component are given and differ.";

    DiagnosisRotationAsLocal = "diagnosis::rotation-as-local": "The rotation columns of a node are the expected ones in its own triad, Aᵀ g instead of g: the derivatives are by rotations about the axes of the node, where spatial ones, about the global axes, are expected.";
    DiagnosisRotationTurnedTwice = "diagnosis::rotation-turned-twice": "The rotation columns of a node are the expected ones multiplied by its triad, A g instead of g: what is spatial already was taken for local and turned once more.";
    DiagnosisBlockTransposed = "diagnosis::block-transposed": "A 3 × 3 block of the matrix, or a matrix of second derivatives, is transposed: rows were written where columns belong.";
    DiagnosisNodesSwapped = "diagnosis::nodes-swapped": "The columns of the two nodes are exchanged.";
    DiagnosisComponentsSwapped = "diagnosis::components-swapped": "Two components, or two equations of a constraint, have each other's numbers.";
    DiagnosisFlowColumn = "diagnosis::flow-column": "The number of a material flow, such as β_s, stands in the column of another degree of freedom, or in two.";
    DiagnosisColumnsSwapped = "diagnosis::columns-swapped": "Two neighbouring columns have each other's numbers.";
    DiagnosisDegrees = "diagnosis::degrees": "Angles are in degrees where radians are expected, or the other way round.";
    DiagnosisRotationHalved = "diagnosis::rotation-halved": "The rotation columns of a node, or all second derivatives by rotations, are half of what is expected, as from a half angle or half a skew-symmetric part.";
    DiagnosisRotationDoubled = "diagnosis::rotation-doubled": "The rotation columns of a node are twice what is expected, as from a quaternion taken for a rotation vector.";
    DiagnosisSign = "diagnosis::sign": "A component, equation or part has the opposite sign throughout: another convention, a minus b for b minus a.";
    DiagnosisSignOfA = "diagnosis::sign-of-a": "The columns of the first node, a of a connector or S of a multi-point constraint, have the sign of those of the second.";
    DiagnosisGeometricTerm = "diagnosis::geometric-term-missing": "The lever is missing: g × d in the rotation columns of node a, which turns the directions in which the separation is measured; of second derivatives, the second variation of the map from the nodes.";
    DiagnosisLeverReversed = "diagnosis::geometric-term-reversed": "The lever g × d in the rotation columns of node a has the wrong sign: d × g.";
    DiagnosisOtherAxis = "diagnosis::other-axis": "Formulas are right with the axes of both nodes in another order: e1 where e3 is meant, for example.";
    DiagnosisHalfway = "diagnosis::not-halfway": "What a flow converter or retractor sums up is the increment along e3a in the middle of it; the axis is that at its end, at its beginning, or their mean.";
    DiagnosisNotSymmetrised = "diagnosis::not-symmetrised": "The second derivatives by rotations of one node are derivatives of the row, not symmetric, without the half bracket that makes them those of the function.";
    DiagnosisHalfTurn = "diagnosis::half-turn": "An angle is half a turn off: nπ of the wrong parity.";
    DiagnosisTurnsForgotten = "diagnosis::turns-forgotten": "The whole turns that an angle had made before are forgotten.";
    DiagnosisRatesOfA = "diagnosis::rates-of-a-ignored": "The velocities or accelerations of the first node, a of a connector or S of a multi-point constraint, do not count.";
    DiagnosisQuadraticPart = "diagnosis::quadratic-part-missing": "An acceleration lacks the part that is quadratic in the rates, J̇ q̇.";
    DiagnosisNotANumber = "diagnosis::not-a-number": "A number is none at special states only, such as no rotation, half a turn, or coincident nodes: 0/0, or acos of more than 1. A series or atan2 goes through.";
    DiagnosisLimited = "diagnosis::limited": "A number stops at a bound, and stays there wherever more is expected: a clamp, as min or max.";
    DiagnosisNearOnly = "diagnosis::near-only": "Numbers are wrong within a distance of special states, such as no rotation or coincident nodes, and right beyond it: a guard, a clamp, a small number added to a divisor, a series that breaks off too early.";
    DiagnosisDigitsLost = "diagnosis::digits-lost": "The nearer a state is to a special one, the fewer digits are right: acos(x) near 1, asin(x) near 1, 1 − cos x of a small x. atan2 of sine and cosine, and 2 sin²(x/2), keep them.";
    DiagnosisDisplacementAsLocal = "diagnosis::displacement-as-local": "The displacement columns are the expected ones along the axes of a node, Aᵀ g instead of g, where global ones are expected.";
    DiagnosisTotalVector = "diagnosis::total-vector": "The rotation columns are derivatives by the total rotation vector of the node, or turned from them, where variations are spatial, δC = δθ^ C.";
    DiagnosisBodyRates = "diagnosis::body-rates": "The angular velocities and accelerations of nodes are taken along the axes of the node, where they are along global axes.";
    DiagnosisUnitOfLength = "diagnosis::unit-of-length": "Numbers or columns are a thousand times, or a thousandth of, what is expected: millimetres and metres.";
    DiagnosisInitialKept = "diagnosis::initial-value-kept": "The initial value is not subtracted: a position, where the change since the initial state is expected.";
    DiagnosisInitialTwice = "diagnosis::initial-value-twice": "The initial value is subtracted twice.";
    DiagnosisReference = "diagnosis::reference-subtracted": "The constitutive reference is subtracted in place of the initial value, or besides it.";
    DiagnosisInitialTurned = "diagnosis::initial-separation-turned": "The difference of the displacements of the nodes is resolved along the present axes of a, e_a · (u_b − u_a). Expected is the present coordinate less the initial one.";
    DiagnosisAxesOfA = "diagnosis::axes-of-a": "The separation is resolved along the axes of a, where those midway between a and b are expected.";
    DiagnosisAxesMidway = "diagnosis::axes-midway": "The separation is resolved along axes midway between those of a and b, where those of a are expected.";
    DiagnosisAxesOfB = "diagnosis::axes-of-b": "The separation is resolved along the axes of b, where those of a are expected.";
    DiagnosisGlobalAxes = "diagnosis::global-axes": "The separation or the rotation is resolved along the global axes, where those of a are expected.";
    DiagnosisInitialAxes = "diagnosis::initial-axes": "The separation is resolved along the initial axes of a, which do not turn with the node.";
    DiagnosisTriadsTransposed = "diagnosis::triads-transposed": "The rows of a triad are taken for its columns: directions of global axes in the node for those of the node.";
    DiagnosisMotionIgnored = "diagnosis::motion-ignored": "A rotation or displacement of one node does not count: the node stands as it did initially.";
    DiagnosisStateBefore = "diagnosis::state-before": "The numbers are those of the state before: an increment late.";
    DiagnosisTurnsAdded = "diagnosis::turns-added": "An angle has whole turns that were not made, as one that is taken from 0 to 2π.";
    DiagnosisSignLost = "diagnosis::sign-lost": "A number is the magnitude of what is expected: acos and norms have no sign.";
    DiagnosisFolded = "diagnosis::folded": "An angle beyond a right one is folded back: asin or atan, where atan2 tells the quadrant.";
    DiagnosisOtherParameters = "diagnosis::other-parameters": "The numbers are a sine, a tangent, a quaternion's vector or Rodrigues parameters of the rotation, where angles or the rotation vector are expected.";
    DiagnosisOtherOrder = "diagnosis::other-order": "The angles are those of another sequence of axes, or of the transposed rotation.";
    DiagnosisAxisForGradient = "diagnosis::axis-for-gradient": "Rotation columns, or a rate, are those about a direction of a node, where the gradient of the angle is expected. The two are alike only where the other angles are zero.";
    DiagnosisConjugate = "diagnosis::conjugate-for-printed": "The moment is the one conjugate to the component, where the manual's page prints another loading for this type, or the other way round.";
    DiagnosisLeverDoubled = "diagnosis::geometric-term-doubled": "The lever g × d in the rotation columns of node a is counted twice; of second derivatives, the second variation of the map from the nodes.";
    DiagnosisLeverAtB = "diagnosis::lever-at-b": "The lever stands in the rotation columns of node b instead of those of a: the moment is taken about the wrong node.";
    DiagnosisFrameHeld = "diagnosis::frame-held": "Second derivatives, or the geometric stiffness, leave out that the directions turn with a node: its rotation columns are zero.";
    DiagnosisOneTriangle = "diagnosis::one-triangle": "One triangle of a symmetric matrix is zero, or half of the sum: the other half was not filled.";
    DiagnosisNodeLeftOut = "diagnosis::node-left-out": "All columns of one node are zero, or a force acts on one node only.";
    DiagnosisQuadraticDoubled = "diagnosis::quadratic-part-multiple": "The part of an acceleration that is quadratic in the rates, J̇ q̇, counts twice, half, or with the wrong sign.";
    DiagnosisCoriolis = "diagnosis::coriolis": "Of the part of an acceleration that is quadratic in the rates, the centripetal term, in the angular velocities alone, or the Coriolis term, in their product with the others, is missing, halved or doubled.";
    DiagnosisDerivative = "diagnosis::derivative-for-resolved": "A rate is the time derivative of the component, where the type gives the nodal rates resolved along the axes of b.";
    DiagnosisLinearPart = "diagnosis::linear-part-missing": "An acceleration lacks the part that is linear in the accelerations, J q̈.";
    DiagnosisComponentZero = "diagnosis::component-zero": "All numbers of a component are zero: it was not computed.";
    DiagnosisSignOfBlock = "diagnosis::sign-of-block": "The columns of one kind have the wrong sign.";
    DiagnosisBlockMissing = "diagnosis::block-missing": "The columns of one kind are zero.";
    DiagnosisOffset = "diagnosis::offset": "A value is off by the same constant at every state.";
    DiagnosisRegularised = "diagnosis::regularised": "A number is the root of its square and one constant: a norm that was made smooth at zero.";
    DiagnosisQuadratic = "diagnosis::quadratic": "A value is off by one constant times its square: an expansion that breaks off, or a term too much.";
    DiagnosisFactor = "diagnosis::factor": "A component, or a block of columns, is off by the same factor at every state.";
    DiagnosisOtherLength = "diagnosis::other-length": "The numbers are a square, a logarithm, or the length of another vector than the one that is meant.";
    DiagnosisLinearised = "diagnosis::linearised": "The numbers are those of small motions about the initial state: its rows, and these times the displacements and rotations.";
    DiagnosisIncremental = "diagnosis::incremental": "The value is summed up from increments, a row times the motion since the state before, which is right for small ones only.";
    DiagnosisIncrement = "diagnosis::increment": "The value is the change since the state before, where that since the initial state is expected.";
    DiagnosisNotNormalised = "diagnosis::not-normalised": "A row, or a rate, is off by a length or the cosine of an angle at the state: a vector that was not normalised, or a division that is missing.";
    DiagnosisOtherJacobian = "diagnosis::other-jacobian": "The rows are formed with another Jacobian of the rotation vector: not inverted, transposed, or that of the other side.";
    DiagnosisOfItsRow = "diagnosis::of-its-row": "A rate, or an acceleration, is what the row given makes of the motion: once the row is mended, it is right too.";
    DiagnosisRateForAcceleration = "diagnosis::rate-for-acceleration": "A rate is formed with accelerations, or an acceleration with rates.";
    DiagnosisSymmetrised = "diagnosis::symmetrised": "A matrix that is not symmetric was made so, as half of the sum with its transpose.";
    DiagnosisSinglePrecision = "diagnosis::single-precision": "Every number fits 24 bits: it was computed, or written, in single precision.";
    DiagnosisRounded = "diagnosis::rounded": "Every number has twelve decimal digits or fewer: it was rounded, or written with too few.";
    DiagnosisDifferences = "diagnosis::differences": "All derivatives are wrong in their last digits at every state: differences with a step, or constants with few digits.";
    DiagnosisNumberLeftOut = "diagnosis::number-left-out": "A friction criterion lacks the number of a factor, such as 1/L where β = 2/L presses.";
    DiagnosisMultiplied = "diagnosis::multiplied": "A friction criterion multiplies by a radius or length that must divide, such as m · R for m/R.";
    DiagnosisStickForSlip = "diagnosis::stick-for-slip": "The tangent of a friction is that of stick where it slips, or of slip where it sticks.";
    DiagnosisContactForceHeld = "diagnosis::contact-force-held": "The tangent of a friction lacks the derivatives by the forces that press: the contact force was held.";
    DiagnosisParametersSwapped = "diagnosis::parameters-swapped": "Two parameters of a friction, such as R_r and L, are exchanged.";
    DiagnosisSumForNorm = "diagnosis::sum-for-norm": "The magnitudes of forces are added where their norm is meant.";
    DiagnosisTermLeftOut = "diagnosis::term-left-out": "A friction criterion lacks one of several norms, or one force of a norm.";
    DiagnosisOtherCoefficient = "diagnosis::other-coefficient": "The coefficient of friction counts twice, or not at all.";
    DiagnosisContinuumTangent = "diagnosis::continuum-tangent": "The tangent is that of an increment that goes to zero, not of the increment that was made.";
    DiagnosisElasticForViscous = "diagnosis::elastic-for-viscous": "The slopes of a behaviour by displacements and by velocities have each other's numbers.";
    DiagnosisSecant = "diagnosis::secant": "A slope is force / displacement, or force / velocity, of a law that is not proportional; or, of a friction, what a whole increment of displacement changes, divided by it: the secant instead of the tangent.";
    DiagnosisDropped = "diagnosis::dropped": "Entries that are not zero are missing.";
    DiagnosisSignOfEntry = "diagnosis::sign-of-entry": "Single entries have the wrong sign.";
    DiagnosisSpurious = "diagnosis::spurious": "An entry that must be zero is not.";
    DiagnosisScaled = "diagnosis::scaled": "A single entry is wrong by a factor, and all others are right.";
    DiagnosisUnknown = "diagnosis::unknown": "No known mistake explains what is wrong, or not with the certainty that is asked for: chance would do it more than once in a thousand times.";

    ModelOrientationDefault = "model::orientation-default": "A connector whose type measures along directions of its nodes is given none: those of a are the global ones, those of b are those of a.", Note;
    ModelOrientationNotOrthogonal = "model::orientation-not-orthogonal": "The two directions by which an orientation is given are not at right angles. The first is kept, the plane of both is kept, and the second is turned within it. A note where they are far from right angles, for any point of the plane may be given; a warning where they are within 10 degrees of them, which looks like an error.";
    ModelOrientationIllConditioned = "model::orientation-ill-conditioned": "The points of an orientation lie so close together, or so nearly in a line, that the rounding of their coordinates turns the directions by more than 1e-8 rad.", Warning;
    ModelNegativeStiffness = "model::negative-stiffness": "A stiffness or damping coefficient is negative: the force pushes away from where it is zero, or feeds energy in. Where that is meant, allow the code.", Warning;
    ModelDegrees = "model::degrees": "An angle is a round number of degrees, such as 90. or 360.: angles of motions, stops, locks, boundary conditions and states are in radians. Where most angles of the states are so, nothing else is said of them, unless this code is allowed. What rates lead to is in radians.", Warning;
    ModelNodeVanishes = "model::node-vanishes": "A state leaves out a node that the state before moved: it is taken for at rest in its initial place, and jumps there.", Warning;
    ModelMisalignedAxes = "model::misaligned-axes": "The directions of a and b differ initially, and the connection type holds rotations between them: the angles are frozen at what they are initially.", Warning;
    ModelAxesApart = "model::axes-apart": "Connectors that each leave one rotation free, HINGE say, join the same two bodies about nearly parallel axes that are not one line. So the bodies do not turn, and what holds them is not determined. Bodies are nodes that rigid bodies, multi-point constraints, connectors without a free component or boundary conditions hold together: nodes of elements that are not read count as bodies of their own.", Warning;
    ModelNearlyCoincident = "model::nearly-coincident-nodes": "A length or direction is needed, and the nodes are so close to each other that its direction has lost half of its digits.", Warning;
    ModelSingular = "model::singular": "A state lies on a singular set of a component: derivatives, and at a true singularity the value, do not exist.", Warning;
    ModelIllConditioned = "model::ill-conditioned": "A state is so close to a singular set of a component that derivatives lose half of their digits or more.", Warning;
    ModelNearSingular = "model::near-singular": "The states come near a singular set of a component: closer than 0.05 rad, or 5 hundredths of the largest length of the connector.", Note;
    ModelLargeIncrement = "model::large-increment": "An angle moves by so much from one state to the next that its turns cannot be counted with certainty.", Warning;
    ModelAmbiguousTurn = "model::ambiguous-turn": "The rotation vectors of a node at two states fit two turns, neither of them unlikely: one of 2.6 rad and one of 3.7 rad the other way, say. Which is taken stands in the reference of conventions.", Warning;
    ModelPathDependent = "model::path-dependent": "The value of a component depends on the path between two states, which they do not tell.", Warning;
    ModelStateNotFinite = "model::not-finite": "A number at a given state is infinite or not a number, or coordinates are so large that the squares of distances overflow.", Warning;
    ModelConstraintViolated = "model::constraint-violated": "A given state does not satisfy a constraint of the model.", Warning;
    ModelHeldNodeMoves = "model::held-node-moves": "A given state moves a node in a degree of freedom that a boundary condition of its step holds, by more than 1e-4 rad, or 1e-4 of the mean length of the connectors: it is none that the model can come to.", Warning;
    ModelStopViolated = "model::stop-violated": "A component lies beyond its stop initially or at the first state given, by more than the rounding of coordinates explains. Or it does so at a later state, by more than a thousandth of a radian or of the length of the connector; or a connector motion leads it there. Of several states the worst is named. A warning; a note where the digits of coordinates, of that state and of the limit leave open whether it does.";
    ModelLockMet = "model::lock-met": "The limit of a lock or failure is passed initially, by more than the rounding of coordinates explains. A warning; a note where the digits of coordinates and of the limit leave open whether it is, or where it is at some temperatures or field variables only.";
    ModelEntriesIgnored = "model::entries-ignored": "A coupled elasticity or damping has entries that are not zero for components that are not available, constrained ones say: they do nothing.", Warning;
    ModelUnusedBehavior = "model::unused-behavior": "No section names a behaviour: it acts on no connector.", Warning;
    ModelLimitUnreachable = "model::limit-unreachable": "A lock or failure is triggered by nothing but the position of a constrained component, which stays within the limits, at every temperature and field variable: it never acts.", Warning;
    ModelFrictionVanishes = "model::friction-vanishes": "A parameter of a friction is zero, or is left out, so that a term of it, or all of it, vanishes, at rest or in fast slip; a belt wraps no angle; or what presses has no force, or one that its table makes zero.", Warning;
    ModelDuplicateConnector = "model::duplicate-connector": "Two connectors of one type and behaviour join the same nodes with the same orientations, so that what each does counts twice.", Warning;
    ModelDuplicateMpc = "model::duplicate-mpc": "A multi-point constraint of one kind is given twice for the same nodes: all of its equations are redundant.", Warning;

    AssemblyRedundant = "assembly::redundant": "A constraint follows from the others initially, and at every state that the assembly can come to: without it the assembly moves as it does with it, and how they share the force is not determined. The finding says what that rests on: that what belongs to it cannot move, which is certain to rounding; or that it was the same at other states that the assembly was moved to, which is judged. These may all be singular positions, at which motions that it leaves free to first order are excluded to second order.", Warning;
    AssemblyRedundantHere = "assembly::redundant-here": "A constraint follows from the others at this state, the initial one or one given, because of its position and not of how the assembly is built: the position is singular. To first order the assembly can move in more ways there than its constraints allow elsewhere. Either it can go on to states at which the constraint follows no more, as at a change point: one was found; or second order excludes these motions, and it stands still there, movable to first order only (two bars in line, held at both ends). Elsewhere the constraint is needed: to leave it out makes another assembly.", Warning;
    AssemblyRedundantUnjudged = "assembly::redundant-unjudged": "A constraint follows from the others at this state, and whether it does elsewhere was not judged: the assembly could not be moved, its connected component is too large to be, or the operations that may be spent on it were spent (audit its loop as a scene of its own); its rank is not certain, so that the constraint is redundant only if what was taken for zero is zero; or there are more that are counted and not named.", Warning;
    AssemblyOverdriven = "assembly::overdriven": "A prescribed motion acts, initially, on what the constraints or other prescribed motions determine already: throughout, or at this position alone, a dead centre say.", Warning;
    AssemblyMechanism = "assembly::mechanism": "The assembly can move in ways that no constraint prevents to first order and no prescribed motion drives. Springs, friction, stops and other elements are not looked at, and at a singular position second order may exclude some of them.", Note;
    AssemblyUndecided = "assembly::undecided": "The rank of the constraints is not known, or not certain: a singular value, or pivot, is larger than rounding explains and smaller than the digits of a model warrant; a constraint has no derivative at a state, or one without digits; the elimination of a connected component would take more than 1e9 operations, so that it was not looked at (audit smaller pieces of it as scenes of their own); or a state given does not satisfy the constraints, or moves what boundary conditions hold, and was not looked at.", Warning;
    AssemblyNearSingular = "assembly::near-singular": "The digits of a state do not tell whether it is a singular position (a change point, say), or close to one: constraints nearly depend on each other there, and at another state, of no smaller rank, that is certain.", Warning;
    AssemblyConstraintsUnread = "assembly::constraints-unread": "A keyword that constrains nodes (*EQUATION, *RIGID BODY, *COUPLING, *TIE, *EMBEDDED ELEMENT …), or a multi-point constraint of a kind that is not evaluated, is not read. The rank of the assembly is that of what was read: with all constraints, nodes of connectors may move in fewer ways, and more constraints may be redundant.", Warning;
    AssemblyNotAssembled = "assembly::not-assembled": "The Jacobian of the constraints could not be assembled at a state, so that the assembly is not judged from there on: a mistake of this program.", Warning;

    CoverageIdentity = "coverage::identity": "The states saw only the neighbourhood of the initial one, of every connector of a type: turned by no more than 0.1 rad, and displaced by no more than 0.05 lengths. An error in terms that vanish there would not show. A warning; a note of connectors that stay there while others of their type do not.";
    CoverageOneNode = "coverage::one-node": "In no state were both nodes of a connector rotated: terms in which the rotations of both meet were never exercised.", Note;
    CoverageUndeformed = "coverage::undeformed": "No component that is free to move was moved in any state: the nodes moved together, as one rigid body.", Note;
    CoverageSmallAngles = "coverage::small-angles": "No relative rotation in the states exceeds 0.1 rad: formulas that agree for small angles cannot be told apart.", Note;
}

impl Code {
    /// How bad what the code means is, unless the place says otherwise.
    #[must_use]
    pub fn severity(self) -> Severity {
        self.declared().unwrap_or(if self.is_finding() { Severity::Warning } else { Severity::Error })
    }

    /// Whether it is what an audit finds in a model that can be read and evaluated.
    #[must_use]
    pub fn is_finding(self) -> bool {
        ["model", "assembly", "coverage", "diagnosis"].contains(&self.group())
    }

    /// Whether it names the cause of a number that is wrong.
    #[must_use]
    pub fn names_a_cause(self) -> bool {
        self.group() == "diagnosis"
    }

    /// Whether an audit may take what it says for something else than it is, where it is asked to. Not of what names the cause of a
    /// wrong number, which fails whatever its cause. Nor of an error that is no rule, which leaves nothing to audit. Of some rules
    /// too it stays an error ([`Code::leaves_numbers`]), which is told where one is broken.
    #[must_use]
    pub fn takes_level(self) -> bool {
        !self.names_a_cause() && (self.severity() < Severity::Error || self.group() == "rule")
    }

    /// Whether every number of a scene that breaks it is defined all the same: a rule of a solver, of what is written in vain, or of who
    /// eliminates what. Compiling refuses such a scene, too. An audit that takes it for less than an error goes on.
    #[must_use]
    pub const fn leaves_numbers(self) -> bool {
        matches!(
            self,
            Self::NotInProcedure
                | Self::OrientationIgnored
                | Self::SectionDataUnused
                | Self::ZRectangularNotInExplicit
                | Self::FrequencyNotInExplicit
                | Self::UnsymmetricNotInExplicit
                | Self::DofEliminated
        )
    }

    /// What stands before `::`.
    #[must_use]
    pub fn group(self) -> &'static str {
        self.as_str().split_once("::").map_or("", |(group, _)| group)
    }

    /// The code that a misspelt name was meant to be, if one is near enough.
    ///
    /// ```
    /// use pintle_scene::Code;
    /// assert_eq!(Code::nearest("model::near-singlar").map(Code::as_str), Some("model::near-singular"));
    /// assert_eq!(Code::nearest("HINGE"), None);
    /// ```
    #[must_use]
    pub fn nearest(name: &str) -> Option<Self> {
        let near = nearest(name, Self::ALL.iter().map(|code| code.as_str()))?;
        Self::ALL.iter().copied().find(|code| code.as_str() == near)
    }

    /// The groups of codes, each once, in the order in which they are listed.
    pub fn groups() -> Vec<&'static str> {
        let mut found: Vec<&str> = Vec::new();
        Self::ALL.iter().map(|code| code.group()).for_each(|group| {
            if !found.contains(&group) {
                found.push(group);
            }
        });
        found
    }
}

impl Serialize for Code {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl Display for Code {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.as_str())
    }
}

/// One error or warning about an input file: code, message, place and remedy.
///
/// It implements [`miette::Diagnostic`], and [`render`](Self::render) prints it with the source line, as rustc does.
#[derive(Debug, Clone)]
pub struct Diagnostic(Box<Parts>);

/// What reading an input yields.
pub type Result<T, E = Diagnostic> = std::result::Result<T, E>;

#[derive(Debug, Clone)]
struct Parts {
    severity: Severity,
    code: Code,
    message: Words,
    label: Words,
    remedy: Words,
    file: String,
    span: Span,
    /// Another place, of which the label gives the line at its end.
    other: Option<Span>,
    excerpt: Option<Excerpt>,
    /// The connectors that it is about.
    elements: Vec<Label>,
    /// Further errors of the same file.
    further: Vec<Diagnostic>,
    /// Those that are counted only.
    unsaid: usize,
}

/// How many errors of one file are told; the others are counted.
pub const MAX_ERRORS: usize = 20;

/// The longest message, label or remedy, in bytes: what is quoted in it may be as long as a line.
const LONGEST_TEXT: usize = 600;

/// The text, or its beginning.
fn shortened(words: impl Into<Words>) -> Words {
    words.into().each(|text| {
        if text.len() > LONGEST_TEXT {
            let end = (0..=LONGEST_TEXT).rev().find(|place| text.is_char_boundary(*place));
            text.truncate(end.unwrap_or(0));
            text.push('…');
        }
    })
}

impl Diagnostic {
    /// An error at `span`. `label` stands under the marked text.
    #[must_use]
    pub fn error(code: Code, span: Span, message: impl Into<Words>, label: impl Into<Words>) -> Self {
        Self::new(Severity::Error, code, span, shortened(message), shortened(label))
    }

    /// A warning at `span`. `label` stands under the marked text.
    #[must_use]
    pub fn warning(code: Code, span: Span, message: impl Into<Words>, label: impl Into<Words>) -> Self {
        Self::new(Severity::Warning, code, span, shortened(message), shortened(label))
    }

    /// What an audit found at `span`, as bad as its code says.
    #[must_use]
    pub fn finding(code: Code, span: Span, message: impl Into<Words>, label: impl Into<Words>) -> Self {
        Self::new(code.severity(), code, span, shortened(message), shortened(label))
    }

    /// The same, as bad as that.
    #[must_use]
    pub fn of_severity(mut self, severity: Severity) -> Self {
        self.0.severity = severity;
        self
    }

    /// The same, with more words at the end of the message.
    pub fn with_more(mut self, words: &str) -> Self {
        self.0.message = self.0.message.each(|text| text.push_str(words));
        self
    }

    /// The same, with words before the message.
    pub fn with_words_before(mut self, words: &str) -> Self {
        self.0.message = self.0.message.each(|text| text.insert_str(0, words));
        self
    }

    fn new(severity: Severity, code: Code, span: Span, message: Words, label: Words) -> Self {
        let (remedy, file) = (Words::default(), String::new());
        Self(Box::new(Parts {
            severity,
            code,
            message,
            label,
            remedy,
            file,
            span,
            other: None,
            excerpt: None,
            elements: Vec::new(),
            further: Vec::new(),
            unsaid: 0,
        }))
    }

    /// Several errors as the first of them, which carries the others: at most [`MAX_ERRORS`], the rest are counted. None without any.
    #[must_use]
    pub fn joined(errors: impl IntoIterator<Item = Self>) -> Option<Self> {
        errors.into_iter().reduce(Self::and)
    }

    /// The same, and another one of the same file, with those that either carries.
    #[must_use]
    pub fn and(mut self, mut other: Self) -> Self {
        let rest = std::mem::take(&mut other.0.further);
        let parts = &mut self.0;
        parts.unsaid += std::mem::take(&mut other.0.unsaid);
        for error in std::iter::once(other).chain(rest) {
            // Of each code one is told at least.
            let is_new =
                error.0.code != parts.code && parts.further.iter().all(|told| told.0.code != error.0.code);
            if parts.further.len() + 1 < MAX_ERRORS || is_new {
                parts.further.push(error);
            } else {
                parts.unsaid += 1;
            }
        }
        self
    }

    /// The other errors of the same file that are told.
    #[must_use]
    pub fn further(&self) -> &[Self] {
        &self.0.further
    }

    /// How many more errors of the file there are.
    #[must_use]
    pub fn unsaid(&self) -> usize {
        self.0.unsaid
    }

    /// Itself alone, the others, and the count of those that are not told.
    pub(crate) fn apart(mut self) -> (Vec<Self>, usize) {
        let rest = std::mem::take(&mut self.0.further);
        let unsaid = std::mem::take(&mut self.0.unsaid);
        (std::iter::once(self).chain(rest).collect(), unsaid)
    }

    /// The same, with so many that are counted only.
    pub(crate) fn with_unsaid(mut self, count: usize) -> Self {
        self.0.unsaid += count;
        self
    }

    /// The same without the count of those that are not told, and that count.
    #[must_use]
    pub fn without_unsaid(mut self) -> (Self, usize) {
        let unsaid = std::mem::take(&mut self.0.unsaid);
        (self, unsaid)
    }

    /// Counts another that is not told.
    pub(crate) fn count_another(&mut self) {
        self.0.unsaid += 1;
    }

    /// The same, with what to do about it.
    #[must_use]
    pub fn help(mut self, remedy: impl Into<Words>) -> Self {
        self.0.remedy = shortened(remedy);
        self
    }

    /// The same, and those that it carries, in the words of documents.
    pub(crate) fn of_document(mut self) -> Self {
        let parts = &mut self.0;
        for words in [&mut parts.message, &mut parts.label, &mut parts.remedy] {
            *words = std::mem::take(words).of_document();
        }
        let further = std::mem::take(&mut parts.further).into_iter();
        parts.further = further.map(Self::of_document).collect();
        self
    }

    /// The same, in the file of that name.
    #[must_use]
    pub fn in_file(mut self, name: &str) -> Self {
        if self.0.file.is_empty() {
            self.0.file = name.to_owned();
        }
        self
    }

    /// The same, where the label ends with the line of another place.
    #[must_use]
    pub(crate) fn beside(mut self, other: Span) -> Self {
        self.0.other = Some(other);
        self
    }

    /// The same, about a connector.
    #[must_use]
    pub fn concerning(mut self, element: Label) -> Self {
        self.concern(&[element]);
        self
    }

    /// Connectors that it is about too.
    pub fn concern(&mut self, elements: &[Label]) {
        self.0.elements.extend_from_slice(elements);
    }

    /// The connectors that it is about, as far as it is told when the scene is resolved: the one that the message names first.
    #[must_use]
    pub fn elements(&self) -> &[Label] {
        &self.0.elements
    }

    /// The connectors that it is about besides the one that the message names, in words.
    #[must_use]
    pub fn others(&self) -> String {
        let mut elements = self.elements().to_vec();
        elements.dedup();
        crate::grammar::and_others("element", elements.get(1..).unwrap_or_default())
    }

    /// Names the file, and that of the other place where it is a different one.
    pub(crate) fn name_files(&mut self, names: &[String]) {
        let name = |span: Span| names.get(usize::from(span.file())).or(names.first());
        if self.0.file.is_empty()
            && let Some(name) = name(self.0.span)
        {
            self.0.file.clone_from(name);
        }
        if let Some(other) = self.0.other.take()
            && other.file() != self.0.span.file()
            && let Some(name) = name(other)
        {
            self.0.label = std::mem::take(&mut self.0.label).each(|label| *label += &format!(" of {name}"));
        }
    }

    /// Error or warning.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.0.severity
    }

    /// The stable code.
    #[must_use]
    pub fn code(&self) -> Code {
        self.0.code
    }

    /// What is wrong, in one sentence.
    #[must_use]
    pub fn message(&self) -> &str {
        &self.0.message.text
    }

    /// What stands under the marked text.
    #[must_use]
    pub fn label(&self) -> &str {
        &self.0.label.text
    }

    /// What to do about it.
    #[must_use]
    pub fn remedy(&self) -> &str {
        &self.0.remedy.text
    }

    /// The name of the file.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// The place in the file.
    #[must_use]
    pub fn span(&self) -> Span {
        self.0.span
    }

    /// The 1-based line, if the diagnostic has a place.
    #[must_use]
    pub fn line(&self) -> Option<u32> {
        self.0.span.is_known().then(|| self.0.span.line())
    }

    /// The diagnostic with its source line, at most `width` columns wide, with ANSI colours on request.
    #[must_use]
    pub fn render(&self, width: usize, colour: bool) -> String {
        let theme = if colour { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        let mut text = String::new();
        let handler = GraphicalReportHandler::new_themed(theme).with_width(width).with_links(false);
        match handler.render_report(&mut text, self) {
            Ok(()) => text,
            Err(_) => format!("{}: {self}", self.code()),
        }
    }

    /// The same, with the source lines that [`render`](Self::render) shows, fetched from the text of its file.
    #[must_use]
    pub fn with_source(self, source: impl BufRead) -> Self {
        let name = self.0.file.clone();
        self.shown_in(&name, source)
    }

    /// The same, and those that it carries, in the file `name` with this text.
    pub(crate) fn shown_in(self, name: &str, source: impl BufRead) -> Self {
        let (mut all, unsaid) = self.apart();
        Self::attach(&mut all, name, source);
        let first = all.remove(0);
        all.into_iter().fold(first, Self::and).with_unsaid(unsaid)
    }

    /// Fetches the source lines of all `diagnostics` in one pass over their file: of each line the [`WINDOW`] that is nearest to the mark.
    pub(crate) fn attach(diagnostics: &mut [Self], name: &str, mut source: impl BufRead) {
        let mut wanted: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
        for (index, diagnostic) in diagnostics.iter_mut().enumerate() {
            diagnostic.0.file = name.to_owned();
            if let Some(line) = diagnostic.line() {
                for near in line.saturating_sub(CONTEXT).max(1)..=line.saturating_add(CONTEXT) {
                    wanted.entry(near).or_default().push(index);
                }
            }
        }
        let Some(last) = wanted.keys().next_back().copied() else { return };
        let mut start = 0;
        for number in 1..=last {
            let mut windows: Vec<Window> = wanted
                .get(&number)
                .into_iter()
                .flatten()
                .map(|&index| {
                    let marked = diagnostics[index].0.span;
                    let middle =
                        if marked.line() == number { marked.start().saturating_sub(start) } else { 0 };
                    Window { index, from: middle.saturating_sub(WINDOW / 2), bytes: Vec::new() }
                })
                .collect();
            let Some([shown, length]) = pass_line(&mut source, &mut windows) else { return };
            for window in windows {
                let parts = &mut diagnostics[window.index].0;
                let excerpt = parts.excerpt.get_or_insert_with(|| Excerpt {
                    name: name.to_owned(),
                    first_line: number,
                    mark: 0,
                    column: 0,
                    bytes: Vec::new(),
                });
                let is_marked = parts.span.line() == number;
                excerpt.add(&window, shown, is_marked.then(|| parts.span.start().saturating_sub(start)));
            }
            start += length;
        }
    }
}

/// Lines shown before and after the one that is marked.
const CONTEXT: u32 = 1;

/// How many bytes of a line are shown.
const WINDOW: u64 = 200;

/// The part of a line that one diagnostic shows.
struct Window {
    /// Which diagnostic.
    index: usize,
    /// Its first byte in the line.
    from: u64,
    bytes: Vec<u8>,
}

/// Whether a line that came to CR ends with LF later: at once, after another CR, or because the file ends here.
pub(crate) fn ends_with_line_feed(rest: &[u8]) -> bool {
    matches!(rest, [] | [b'\n', ..] | [b'\r', b'\n', ..])
}

/// Reads one line, fills the windows, and gives its length to its first end, and to the last; nothing at the end of the file. A line of any
/// length needs no memory.
fn pass_line(source: &mut impl BufRead, windows: &mut [Window]) -> Option<[u64; 2]> {
    let mut length = 0;
    loop {
        let chunk = source.fill_buf().ok()?;
        if chunk.is_empty() {
            return (length > 0).then_some([length; 2]);
        }
        let end = chunk.iter().position(|byte| b"\r\n".contains(byte)).map(|end| end + 1);
        let is_open = end.is_some_and(|end| chunk[end - 1] == b'\r');
        let part = &chunk[..end.unwrap_or(chunk.len())];
        for window in &mut *windows {
            let inside = |place: u64| {
                usize::try_from(place.saturating_sub(length)).unwrap_or(usize::MAX).min(part.len())
            };
            let (from, to) = (inside(window.from), inside(window.from + WINDOW));
            window.bytes.extend_from_slice(&part[from..to]);
        }
        let taken = part.len();
        length += taken as u64;
        source.consume(taken);
        if end.is_some() {
            let mut more = 0;
            if is_open {
                let rest = source.fill_buf().ok()?;
                more = if !ends_with_line_feed(rest) {
                    0
                } else if rest.first() == Some(&b'\r') {
                    2
                } else {
                    rest.len().min(1)
                };
                source.consume(more);
            }
            return Some([length, length + more as u64]);
        }
    }
}

/// The few lines of a file that a diagnostic shows.
#[derive(Debug, Clone)]
struct Excerpt {
    name: String,
    first_line: u32,
    /// Where in the bytes the mark begins.
    mark: usize,
    /// How far the marked line is cut at its beginning, less what stands for it.
    column: usize,
    bytes: Vec<u8>,
}

impl Excerpt {
    /// What stands where a line is cut.
    const CUT: &'static str = "…";

    /// Adds a line of that `length`, whose mark, if it has one, begins at `mark`.
    fn add(&mut self, window: &Window, length: u64, mark: Option<u64>) {
        let is_part = |byte: &u8| (0x80..0xc0).contains(byte);
        let torn = window.bytes.iter().take_while(|byte| window.from > 0 && is_part(byte)).count();
        let shown = String::from_utf8_lossy(&window.bytes[torn..]);
        let from = window.from as usize + torn;
        if from > 0 {
            self.bytes.extend_from_slice(Self::CUT.as_bytes());
        }
        if let Some(mark) = mark {
            let before = usize::try_from(mark)
                .unwrap_or(usize::MAX)
                .saturating_sub(from)
                .min(window.bytes.len() - torn);
            // What is not UTF-8 may be longer when it is shown.
            let before = String::from_utf8_lossy(&window.bytes[torn..torn + before]).len();
            self.mark = self.bytes.len() + before;
            self.column = from.saturating_sub(Self::CUT.len());
        }
        self.bytes.extend_from_slice(shown.trim_end_matches(['\n', '\r']).as_bytes());
        if (from + window.bytes.len() - torn) < usize::try_from(length).unwrap_or(usize::MAX) {
            self.bytes.extend_from_slice(Self::CUT.as_bytes());
        }
        self.bytes.push(b'\n');
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.bytes.as_slice().read_span(span, lines_before, lines_after)?;
        let cut = if lines_before + lines_after == 0 { self.column } else { 0 };
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            inner.data(),
            *inner.span(),
            inner.line() + self.first_line as usize - 1,
            inner.column() + cut,
            inner.line_count(),
        )))
    }
}

/// The message; before it the file, and the line, unless [`render`](Diagnostic::render) shows them with an excerpt.
impl Display for Diagnostic {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let parts = &self.0;
        if parts.excerpt.is_none() && !parts.file.is_empty() {
            write!(formatter, "{}:", parts.file)?;
            if let Some(line) = self.line() {
                write!(formatter, "{line}:")?;
            }
            formatter.write_str(" ")?;
        }
        write!(formatter, "{}{}", self.message(), self.others())
    }
}

impl std::error::Error for Diagnostic {}

impl miette::Diagnostic for Diagnostic {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(self.0.code))
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.0.severity {
            Severity::Note => miette::Severity::Advice,
            Severity::Warning => miette::Severity::Warning,
            Severity::Error => miette::Severity::Error,
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        (!self.remedy().is_empty()).then(|| Box::new(self.remedy()) as Box<dyn Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.excerpt.as_ref().map(|excerpt| excerpt as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let excerpt = self.0.excerpt.as_ref()?;
        let offset = excerpt.mark;
        let rest = excerpt.bytes.get(offset..).unwrap_or_default();
        let line = rest.iter().position(|&byte| byte == b'\n').unwrap_or(rest.len());
        let length = usize::try_from(self.0.span.end() - self.0.span.start()).unwrap_or(usize::MAX);
        let label = LabeledSpan::new(Some(self.label().to_owned()), offset, length.min(line));
        Some(Box::new(std::iter::once(label)))
    }
}

/// The candidate closest to `word`, if it is close enough to be what was meant: at most one edit in three letters.
pub(crate) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word: Vec<char> =
        word.chars().take(LONGEST_COMPARED).map(|letter| letter.to_ascii_uppercase()).collect();
    let limit = (word.len() / 3).clamp(1, 3);
    candidates
        .into_iter()
        .filter_map(|candidate| {
            let other: Vec<char> =
                candidate.chars().take(LONGEST_COMPARED).map(|letter| letter.to_ascii_uppercase()).collect();
            let distance = edits(&word, &other);
            (distance <= limit && distance < other.len()).then_some((distance, candidate))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

const LONGEST_COMPARED: usize = 64;

/// Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours.
fn edits(a: &[char], b: &[char]) -> usize {
    if a.len().abs_diff(b.len()) > 3 {
        return usize::MAX;
    }
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let substitution = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = substitution.min(last[j] + 1).min(row[j - 1] + 1);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

/// "; did you mean X?" when a candidate is close, otherwise the remedy alone.
pub(crate) fn suggest<'a, T: From<String>>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
    otherwise: impl FnOnce() -> T,
) -> T {
    nearest(word, candidates).map_or_else(otherwise, |near| format!("did you mean {near}?").into())
}

/// The same for names that belong to instances: one that is called so in an instance is meant before one that is
/// called almost so.
pub(crate) fn suggest_scoped<'a, T: From<String>>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
    otherwise: impl FnOnce() -> T,
) -> T {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let bare = word.rsplit('.').next().unwrap_or(word);
    let scoped = candidates.iter().find(|candidate| {
        candidate
            .strip_suffix(bare)
            .is_some_and(|rest| rest.ends_with('.') || (rest.is_empty() && bare != word))
    });
    match scoped {
        Some(scoped) => format!("did you mean {scoped}?").into(),
        None => suggest(word, candidates, otherwise),
    }
}

#[cfg(test)]
mod tests {
    use super::{Code, nearest};
    use std::collections::BTreeSet;

    #[test]
    fn codes_are_distinct_and_explained() {
        let texts: BTreeSet<_> = Code::ALL.iter().map(|code| code.as_str()).collect();
        assert_eq!(texts.len(), Code::ALL.len());
        for code in Code::ALL {
            assert!(code.as_str().contains("::"), "{code}");
            assert!(code.explanation().ends_with('.'), "{code}");
        }
    }

    #[test]
    fn close_names_are_found() {
        let names = ["HAXIS", "DRUM", "HZ"];
        assert_eq!(nearest("HAXSI", names), Some("HAXIS"));
        assert_eq!(nearest("haxis", names), Some("HAXIS"));
        assert_eq!(nearest("DRUMM", names), Some("DRUM"));
        assert_eq!(nearest("SOMETHING", names), None);
        assert_eq!(nearest("", names), None);
    }
}
