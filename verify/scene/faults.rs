//! Every fault gives one error: its code, its line, and a remedy that helps.

use pintle::scene::{Code, Diagnostic, GALLERY, Scene, Severity, StateFile};
use std::collections::BTreeSet;

/// A sound deck of 13 lines, which the faults below spoil.
const SOUND: &str = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
*ORIENTATION, NAME=OZ
0., 0., 1., 1., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=E
101, 1, 2
*CONNECTOR SECTION, ELSET=E, BEHAVIOR=B
HINGE
OZ,
*CONNECTOR BEHAVIOR, NAME=B
*CONNECTOR STOP, COMPONENT=4
-1., 1.
";

/// A fault: code, line, a word of the remedy, what is replaced (nothing: appended from line 14 on) and by what.
type Fault = (Code, u32, &'static str, &'static str, &'static str);

#[rustfmt::skip]
const DECKS: &[Fault] = &[
    // lines
    (Code::UnclosedQuote, 10, "close the name", "OZ,", "\"OZ,"),
    (Code::DanglingContinuation, 4, "comma", "NAME=OZ\n", "NAME=OZ,\n*NODE\n"),
    (Code::DanglingContinuation, 14, "comma", "", "*END STEP,\n"),
    (Code::EmptyKeyword, 14, "**", "", "* , X\n"),
    (Code::StrayData, 1, "*HEADING", "*NODE\n1", "1"),
    (Code::UnexpectedData, 12, "suboptions", "NAME=B\n", "NAME=B\n1., 2.\n"),
    (Code::UnexpectedData, 14, "lower, upper", "", "-2., 2.\n"),
    // keywords
    (Code::UnsupportedKeyword, 14, "included file", "", "*INCLUDE, INPUT=mesh.inp\n"),
    (Code::UnsupportedKeyword, 14, "without parts", "", "*PART, NAME=P\n"),
    (Code::UnsupportedKeyword, 14, "under *NODE", "", "*NGEN\n1, 2\n"),
    (Code::UnsupportedKeyword, 1, "copy the lines", "*NODE\n", "*NODE, INPUT=nodes.txt\n"),
    (Code::MisplacedKeyword, 16, "*CONNECTOR BEHAVIOR", "", "*MASS, ELSET=M\n1.\n*CONNECTOR LOCK, COMPONENT=4\n1.\n"),
    (Code::MisplacedKeyword, 14, "directly below *CONNECTOR FRICTION", "", "*FRICTION\n0.1\n"),
    (Code::MisplacedKeyword, 14, "PLASTICITY", "", "*CONNECTOR HARDENING\n1., 0.\n"),
    (Code::MisplacedKeyword, 14, "without COMPONENT", "", "*CONNECTOR POTENTIAL\n1\n"),
    (Code::MisplacedKeyword, 14, "INITIATION", "", "*CONNECTOR DAMAGE EVOLUTION\n1.\n"),
    (Code::ModelDataInStep, 15, "before the first *STEP", "", "*STEP\n*NODE\n3, 0., 0., 0.\n*END STEP\n"),
    (Code::HistoryOutsideStep, 14, "between *STEP", "", "*STATIC\n0.1, 1.\n"),
    (Code::HistoryOutsideStep, 14, "begin the step", "", "*END STEP\n"),
    (Code::HistoryOutsideStep, 17, "between *STEP", "", "*STEP\n*STATIC\n*END STEP\n*BOUNDARY\n1, 1, 6\n"),
    (Code::UnfinishedStep, 14, "*END STEP", "", "*STEP\n*STATIC\n"),
    (Code::UnfinishedStep, 16, "*END STEP", "", "*STEP\n*STATIC\n*STEP\n*END STEP\n"),
    (Code::TwoProcedures, 16, "another one", "", "*STEP\n*STATIC\n*DYNAMIC\n*END STEP\n"),
    (Code::TwoProcedures, 16, "another one", "", "*STEP\n*STATIC\n*FREQUENCY\n5\n*END STEP\n"),
    (Code::MixedSolvers, 18, "two decks", "", "*STEP\n*STATIC\n*END STEP\n*STEP\n*DYNAMIC, EXPLICIT\n*END STEP\n"),
    // parameters
    (Code::UnknownParameter, 8, "BEHAVIOR", "BEHAVIOR=B", "BEHAVIOUR=B"),
    (Code::UnknownParameter, 6, "*ELEMENT takes", "ELSET=E\n101", "ELSET=E, COLOUR=RED\n101"),
    (Code::UnknownParameter, 14, "ELSET", "", "*ELSET, ELST=F\n101\n"),
    (Code::UnknownParameter, 13, "no parameters", "*CONNECTOR STOP, COMPONENT=4\n-1., 1.\n", "*CONNECTOR CONSTITUTIVE REFERENCE,\n1., 2.\n"),
    (Code::MissingParameter, 4, "NAME=", "*ORIENTATION, NAME=OZ", "*ORIENTATION"),
    (Code::MissingParameter, 12, "COMPONENT=", "*CONNECTOR STOP, COMPONENT=4", "*CONNECTOR STOP"),
    (Code::MissingParameter, 14, "COMPONENT=", "", "*CONNECTOR ELASTICITY, NONLINEAR\n1., 1.\n"),
    (Code::MissingParameter, 14, "PREDEFINED", "", "*CONNECTOR FRICTION, CONTACT FORCE=1\n*FRICTION\n0.1\n"),
    (Code::MissingParameter, 14, "POTENTIAL", "", "*CONNECTOR PLASTICITY\n"),
    (Code::MissingParameter, 15, "EXPONENTIAL DECAY", "", "*CONNECTOR FRICTION, PREDEFINED\n*FRICTION, TEST DATA\n0.1\n"),
    (Code::RepeatedParameter, 4, "keep one", "NAME=OZ", "NAME=OZ, NAME=OY"),
    (Code::BadParameterValue, 4, "RECTANGULAR", "NAME=OZ", "NAME=OZ, SYSTEM=RECTANGULER"),
    (Code::BadParameterValue, 6, "CONN3D2", "CONN3D2", "CONN3D"),
    (Code::BadParameterValue, 8, "ELIMINATION", "BEHAVIOR=B", "BEHAVIOR=B, ELIMINATION"),
    (Code::BadParameterValue, 8, "write BEHAVIOR", "BEHAVIOR=B", "BEHAVIOR="),
    (Code::BadParameterValue, 14, "GENERATE alone", "", "*NSET, NSET=N, GENERATE=YES\n1, 2\n"),
    (Code::BadParameterValue, 14, "ALL or a component", "", "*CONNECTOR LOCK, COMPONENT=4, LOCK=SOME\n1.\n"),
    (Code::BadParameterValue, 1, "cylindrical", "*NODE\n", "*NODE, SYSTEM=S\n"),
    (Code::ConflictingParameters, 14, "NONLINEAR or RIGID", "", "*CONNECTOR ELASTICITY, COMPONENT=4, RIGID, NONLINEAR\n"),
    (Code::ConflictingParameters, 14, "PREDEFINED or COMPONENT", "", "*CONNECTOR FRICTION, PREDEFINED, COMPONENT=4\n"),
    (Code::ConflictingParameters, 15, "KINEMATIC", "", "*CONNECTOR PLASTICITY, COMPONENT=4\n*CONNECTOR HARDENING, TYPE=KINEMATIC, DEFINITION=TABULAR\n1., 0.\n"),
    (Code::RepeatedSuboption, 14, "another behaviour", "", "*CONNECTOR STOP, COMPONENT=4\n0., 1.\n"),
    (Code::RepeatedSuboption, 16, "keep one", "", "*CONNECTOR CONSTITUTIVE REFERENCE\n1.\n*CONNECTOR CONSTITUTIVE REFERENCE\n2.\n"),
    (Code::UnknownElement, 16, "under *ELEMENT", "", "*STEP\n*DLOAD\n55, GRAV, 9.81, 0., 0., -1.\n*END STEP\n"),
    (Code::BadComponent, 12, "6 rotations", "COMPONENT=4", "COMPONENT=7"),
    // data
    (Code::MissingData, 5, "point b", "0., 0., 1., 1., 0., 0.", "0., 0., 1."),
    (Code::MissingData, 8, "connection types", "HINGE\nOZ,\n", ""),
    (Code::MissingData, 9, "connection type", "HINGE", ""),
    (Code::MissingData, 12, "lower position", "-1., 1.\n", ""),
    (Code::MissingData, 15, "stiffness", "", "*CONNECTOR ELASTICITY, COMPONENT=4\n , 1.\n"),
    (Code::MissingData, 15, "8 numbers", "", "*CONNECTOR ELASTICITY\n1., 1., 1., 1., 1., 1., 1., 1.\n"),
    (Code::MissingData, 16, "set, GRAV", "", "*STEP\n*DLOAD\n, GRAV, 9.81\n*END STEP\n"),
    (Code::MissingData, 15, "time, value", "", "*AMPLITUDE, NAME=A\n0., 0., 1.\n"),
    (Code::MissingData, 14, "CONTACT FORCE", "", "*CONNECTOR FRICTION, COMPONENT=4\n*FRICTION\n0.1\n"),
    (Code::SurplusData, 3, "three coordinates", "2, 1., 0., 0.", "2, 1., 0., 0., 0., 0., 1., 5."),
    (Code::SurplusData, 7, "two nodes", "101, 1, 2", "101, 1, 2, 3"),
    (Code::SurplusData, 9, "translational", "HINGE", "SLOT, REVOLUTE, ALIGN"),
    (Code::SurplusData, 13, "upper position", "-1., 1.", "-1., 1., 2."),
    (Code::MalformedNumber, 3, "commas", "2, 1., 0., 0.", "2, 1. 0., 0."),
    (Code::MalformedNumber, 13, "1.D-3", "-1., 1.", "-1., one"),
    (Code::MalformedNumber, 3, "1.D-3", "2, 1., 0., 0.", "2, nan, 0., 0."),
    (Code::MalformedNumber, 11, "1.D-3", "NAME=B\n", "NAME=B, RTOL=small\n"),
    (Code::MalformedInteger, 7, "write 2,", "101, 1, 2", "101, 1, 2."),
    (Code::MalformedInteger, 7, "digits", "101, 1, 2", "101, 1, N2"),
    (Code::MalformedInteger, 14, "digits", "", "*STEP, INC=many\n*END STEP\n"),
    (Code::NumberOutOfRange, 3, "1.8e308", "2, 1., 0., 0.", "2, 1e999, 0., 0."),
    (Code::NumberOutOfRange, 17, "positive", "", "*CONNECTOR FRICTION, PREDEFINED\n0.1\n*FRICTION\n-0.1\n"),
    (Code::NumberOutOfRange, 16, "initial, total", "", "*STEP\n*STATIC\n-0.1, 1.\n*END STEP\n"),
    (Code::NumberOutOfRange, 14, "at most 100", "", "*CONNECTOR ELASTICITY, COMPONENT=4, DEPENDENCIES=1000\n1.\n"),
    (Code::MalformedName, 10, "quotation marks", "OZ,", "O\"Z\","),
    (Code::BadComponent, 16, "translations", "", "*STEP\n*CONNECTOR MOTION\nE, 0, 1.\n*END STEP\n"),
    (Code::BadComponent, 15, "once", "", "*CONNECTOR DERIVED COMPONENT, NAME=D\n2, 2\n"),
    (Code::BadDegreeOfFreedom, 15, "material flow", "", "*BOUNDARY\n1, 1, 7\n"),
    (Code::BadDegreeOfFreedom, 15, "first, last", "", "*BOUNDARY\n1, 6, 1\n"),
    (Code::BadValue, 6, "axis, additional", "1., 0., 0.\n*ELEMENT", "1., 0., 0.\n4, 30.\n*ELEMENT"),
    (Code::BadValue, 15, "ENCASTRE", "", "*BOUNDARY\n1, ENCASTER\n"),
    (Code::BadValue, 16, "MACAULEY", "", "*CONNECTOR PLASTICITY, COMPONENT=4\n*CONNECTOR POTENTIAL\n4, 1., 2., MACAULAY\n"),
    // numbers and names
    (Code::DuplicateNode, 4, "another number", "2, 1., 0., 0.\n", "2, 1., 0., 0.\n2, 1., 0., 1.\n"),
    (Code::DuplicateElement, 8, "another number", "101, 1, 2\n", "101, 1, 2\n101, 2, 1\n"),
    (Code::DuplicateElement, 7, "another number", "", "*ELEMENT, TYPE=T3D2\n101, 1, 2\n"),
    (Code::DuplicateName, 14, "rename", "", "*ORIENTATION, NAME=oz\n0., 0., 1., 1., 0., 0.\n"),
    (Code::DuplicateName, 14, "rename", "", "*CONNECTOR BEHAVIOR, NAME=B\n"),
    (Code::BadLabel, 2, "upwards", "1, 0., 0., 0.", "0, 0., 0., 0."),
    (Code::BadConnectivity, 7, "ground", "101, 1, 2", "101, 1, 1"),
    (Code::BadConnectivity, 7, "ground", "101, 1, 2", "101,"),
    (Code::BadConnectivity, 15, "dependent", "", "*MPC\nREVOLUTE, 1, 2\n"),
    (Code::BadConnectivity, 15, "dependent", "", "*MPC\nPIN, 1, 1\n"),
    (Code::GenerateRange, 15, "smaller number", "", "*NSET, NSET=N, GENERATE\n2, 1\n"),
    (Code::GenerateRange, 15, "at least 1", "", "*NSET, NSET=N, GENERATE\n1, 2, 0\n"),
    (Code::GenerateRange, 15, "split", "", "*NSET, NSET=N, GENERATE\n1, 99999999\n"),
    (Code::EmptySet, 14, "connector elements", "", "*CONNECTOR SECTION, ELSET=F\nBEAM\n*ELSET, ELSET=F\n"),
    (Code::SetCycle, 17, "remove", "", "*NSET, NSET=N\n1, M\n*NSET, NSET=M\nN, 2\n"),
    // references
    (Code::UnknownNode, 7, "under *NODE", "101, 1, 2", "101, 1, 3"),
    (Code::UnknownNode, 15, "under *NODE", "", "*NSET, NSET=N\n1, 2, 3\n"),
    (Code::UnknownNode, 15, "under *NODE", "", "*NSET, NSET=N, GENERATE\n5, 9\n"),
    (Code::UnknownNode, 15, "under *NODE", "", "*MPC\nPIN, 1, 9\n"),
    (Code::UnknownNode, 4, "COORDINATES", "NAME=OZ\n0., 0., 1., 1., 0., 0.\n", "NAME=OZ, DEFINITION=NODES\n2, 9\n"),
    (Code::UnknownElement, 16, "under *ELEMENT", "", "*STEP\n*CONNECTOR LOAD\n102, 4, 1.\n*END STEP\n"),
    (Code::UnknownElement, 15, "under *ELEMENT", "", "*ELSET, ELSET=F\n101, 102\n"),
    (Code::UnknownNodeSet, 15, "*NSET, NSET=GROUND", "", "*BOUNDARY\nGROUND, 1, 6\n"),
    (Code::UnknownNodeSet, 15, "FIXED", "", "*BOUNDARY\nFIXD, 1, 6\n*NSET, NSET=FIXED\n1\n"),
    (Code::UnknownElementSet, 8, "*ELSET", "SECTION, ELSET=E", "SECTION, ELSET=PINS"),
    (Code::UnknownElementSet, 17, "*ELSET", "", "*STEP\n*STATIC\n*OUTPUT, HISTORY\n*ELEMENT OUTPUT, ELSET=PINS\nCU\n*END STEP\n"),
    (Code::UnknownOrientation, 10, "did you mean OZ", "OZ,", "OX,"),
    (Code::UnknownOrientation, 10, "blank", "OZ,", "0.06, 1.57"),
    (Code::UnknownBehavior, 8, "NAME=FRICTIONAL", "BEHAVIOR=B", "BEHAVIOR=FRICTIONAL"),
    (Code::UnknownAmplitude, 15, "*AMPLITUDE", "", "*STEP\n*CONNECTOR MOTION, AMPLITUDE=RAMP\nE, 4, 1.\n*END STEP\n"),
    (Code::UnknownDerivedComponent, 14, "*CONNECTOR DERIVED", "", "*CONNECTOR FRICTION, COMPONENT=4, CONTACT FORCE=N\n*FRICTION\n0.1\n"),
    (Code::UnknownMpc, 15, "REVOLUTE", "", "*MPC\nREVOLUT, 1, 2\n"),
    (Code::UnknownMpc, 15, "begin with", "", "*MPC\n0, 1, 2\n"),
    (Code::WrongElementType, 16, "CONN3D2", "", "*ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*CONNECTOR SECTION, ELSET=M\nBEAM\n"),
    (Code::WrongElementType, 14, "MASS elements", "", "*MASS, ELSET=E\n1.\n"),
    (Code::WrongElementType, 18, "connector", "", "*ELEMENT, TYPE=MASS, ELSET=M\n201, 2\n*STEP\n*CONNECTOR LOAD\nM, 1, 1.\n*END STEP\n"),
    (Code::MissingData, 16, "one degree of freedom", "", "*ELEMENT, TYPE=SPRING1, ELSET=S\n201, 2\n*SPRING, ELSET=S\n\n2.5\n"),
    (Code::MissingSection, 9, "*CONNECTOR SECTION", "101, 1, 2\n", "101, 1, 2\n*ELEMENT, TYPE=CONN3D2\n102, 1,\n"),
    (Code::TwoSections, 14, "take the element out", "", "*CONNECTOR SECTION, ELSET=E\nBEAM\n"),
    (Code::MissingFriction, 14, "*FRICTION", "", "*CONNECTOR FRICTION, PREDEFINED\n0.1\n"),
    (Code::DegenerateOrientation, 4, "off the line", "0., 0., 1., 1., 0., 0.", "0., 0., 1., 0., 0., 2."),
    (Code::DegenerateOrientation, 4, "away from c", "0., 0., 1., 1., 0., 0.", "0., 0., 0., 1., 0., 0."),
    (Code::DegenerateOrientation, 4, "RECTANGULAR", "NAME=OZ\n0., 0., 1., 1., 0., 0.\n", "NAME=OZ, SYSTEM=CYLINDRICAL\n-1., 0., 0., 1., 0., 0.\n"),
    (Code::DegenerateOrientation, 4, "number the nodes", "NAME=OZ\n0., 0., 1., 1., 0., 0.\n", "NAME=OZ, DEFINITION=OFFSET TO NODES\n2, 3\n"),
    (Code::UnsupportedOrientation, 4, "RECTANGULAR", "NAME=OZ\n0., 0., 1., 1., 0., 0.\n", "NAME=OZ, SYSTEM=USER\n"),
    (Code::LimitsReversed, 13, "lower limit first", "-1., 1.", "1., -1."),
    (Code::LimitsReversed, 15, "lower limit first", "", "*CONNECTOR FAILURE, COMPONENT=4\n , , 5., -5.\n"),
    (Code::TableOrder, 16, "increases", "", "*CONNECTOR ELASTICITY, COMPONENT=4, NONLINEAR\n0., 0.\n1., 0.\n"),
    (Code::TableOrder, 15, "increases", "", "*AMPLITUDE, NAME=A\n0., 0., 1., 1., 0.5, 0.\n"),
];

/// Warnings: the deck is read.
#[rustfmt::skip]
const WARNINGS: &[Fault] = &[
    (Code::MisspeltKeyword, 14, "CONNECTOR STOP", "", "*CONECTOR STOP, COMPONENT=4\n1.\n"),
    (Code::MisspeltKeyword, 14, "MASS", "", "*ELEMENT, TYPE=MAS, ELSET=M\n201, 2\n"),
    (Code::GenerateGaps, 15, "range", "", "*NSET, NSET=N, GENERATE\n1, 3\n"),
    (Code::MpcNotEvaluated, 15, "REVOLUTE", "", "*MPC\nSLIDER, 1, 2\n"),
    (Code::LimitsMissing, 13, "limit", "-1., 1.", ","),
    (Code::NonzeroModelBoundary, 15, "step", "", "*BOUNDARY\n1, 1, 1, 0.5\n"),
];

fn spoiled((_, _, _, old, new): &Fault) -> String {
    if old.is_empty() {
        return format!("{SOUND}{new}");
    }
    assert_eq!(SOUND.matches(old).count(), 1, "{old:?} must occur once");
    SOUND.replacen(old, new, 1)
}

/// What is wrong with a diagnostic for a fault, if anything is.
fn complaint(diagnostic: &Diagnostic, (code, line, word, ..): &Fault, text: &str) -> Option<String> {
    let shown = diagnostic.render(110, false);
    let place = diagnostic.span();
    let (start, end) = (place.start() as usize, place.end() as usize);
    let lines = || text.as_bytes()[..start].iter().filter(|&&byte| byte == b'\n').count() + 1;
    let checks = [
        (diagnostic.code() == *code, "code"),
        (diagnostic.line() == Some(*line), "line"),
        (diagnostic.remedy().contains(word), "remedy"),
        (!diagnostic.message().is_empty() && !diagnostic.label().is_empty(), "text"),
        (diagnostic.file() == "deck.inp", "file"),
        (
            (start < end || text[start..].starts_with('\n'))
                && end <= text.len()
                && lines() == *line as usize,
            "place",
        ),
        (shown.contains(code.as_str()) && shown.contains(&format!("deck.inp:{line}:")), "rendering"),
    ];
    let failed: Vec<_> = checks.iter().filter(|(passed, _)| !passed).map(|(_, what)| *what).collect();
    (!failed.is_empty())
        .then(|| format!("wrong {}; wanted {code}, line {line}, `{word}`:\n{shown}", failed.join(", ")))
}

#[test]
fn the_sound_deck_is_sound() {
    let scene = Scene::parse("deck.inp", SOUND).unwrap();
    assert!(scene.warnings.is_empty());
}

#[test]
fn faulty_decks_are_refused() {
    assert!(DECKS.len() >= 100);
    let complaints: Vec<_> = DECKS
        .iter()
        .filter_map(|fault| {
            let text = spoiled(fault);
            match Scene::parse("deck.inp", &text) {
                Ok(_) => Some(format!("not refused: {fault:?}")),
                Err(error) => {
                    assert_eq!(error.severity(), Severity::Error);
                    complaint(&error, fault, &text)
                }
            }
        })
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn doubtful_decks_are_read_with_a_warning() {
    for fault in WARNINGS {
        let text = spoiled(fault);
        let scene = Scene::parse("deck.inp", &text)
            .unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)));
        let [warning] = scene.warnings.as_slice() else { panic!("{text}\n{:?}", scene.warnings) };
        assert_eq!(warning.severity(), Severity::Warning);
        assert_eq!(complaint(warning, fault, &text), None);
    }
}

/// Faulty files of states: code, line (0: none), a word of the remedy, the text; CSV unless it begins with a brace.
#[rustfmt::skip]
const STATES: &[(Code, u32, &str, &str)] = &[
    (Code::StatesEmpty, 0, "header line", ""),
    (Code::StatesEmpty, 0, "at least one row", "node,u1\n"),
    (Code::StatesMalformed, 2, "as many fields", "node,u1\n1,2,3\n"),
    (Code::StatesUnknownColumn, 1, "ur1", "node,ur11\n1,0\n"),
    (Code::StatesUnknownColumn, 1, "columns are", "node,temperature\n1,0\n"),
    (Code::StatesRepeatedColumn, 1, "remove", "node,u1,u1\n1,0,0\n"),
    (Code::StatesMissingColumn, 1, "`node`", "state,u1\n1,0\n"),
    (Code::StatesUnknownNode, 3, "node numbers of deck.inp", "node,u1\n1,0\n7,0\n"),
    (Code::StatesRepeatedNode, 3, "state number", "node,u1\n1,0\n1,0\n"),
    (Code::StatesMalformedNumber, 2, "finite", "node,u1\n1,NaN\n"),
    (Code::StatesMalformedNumber, 2, "finite", "node,u1\n1,inf\n"),
    (Code::StatesMalformedNumber, 4, "finite", "node,u1\n\n# note\n1,1 2\n"),
    (Code::StatesMalformedNumber, 2, "digits", "node,u1\n1.5,0\n"),
    (Code::StatesMalformedNumber, 2, "`node`", "node,u1\n,0\n"),
    (Code::StatesNumberOutOfRange, 2, "1.8e308", "node,u1\n1,1e400\n"),
    (Code::StatesTwoRotations, 2, "not both", "node,ur1,q0\n1,0,1\n"),
    (Code::StatesQuaternionNorm, 2, "norm", "node,q0,q1,q2,q3\n1,1,0,0,0.1\n"),
    (Code::StatesRotationTooLarge, 2, "radians", "node,ur1\n1,2e8\n"),
    (Code::StatesOrder, 3, "upwards", "state,node\n1,1\n0,1\n"),
    (Code::StatesOrder, 3, "same time", "state,time,node\n0,0,1\n0,1,2\n"),
    (Code::StatesMalformed, 1, "pintle-states/1", "{"),
    (Code::StatesMalformed, 1, "pintle-states/1", "{\"schema\": \"other/1\", \"states\": []}"),
    (Code::StatesMalformed, 2, "pintle-states/1", "{\"schema\": \"pintle-states/1\",\n\"stats\": []}"),
    (Code::StatesMalformed, 1, "the form is", "{\"states\": []}"),
    (Code::StatesEmpty, 0, "initial state", "{\"schema\": \"pintle-states/1\", \"states\": []}"),
    (Code::StatesUnknownNode, 2, "node numbers", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\":\n {\"7\": {}}}]}"),
    (Code::StatesRepeatedNode, 2, "one of the two", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\": {\"1\": {},\n \"1\": {}}}]}"),
    (Code::StatesMalformedNumber, 1, "node number", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\": {\"one\": {}}}]}"),
    (Code::StatesMalformed, 1, "the form is", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\": {\"1\": {\"displacement\": [1, 2]}}}]}"),
    (Code::StatesMalformed, 1, "the form is", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\": {\"1\": {\"flow\": 1e400}}}]}"),
    (Code::StatesMalformed, 1, "the form is", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\": {\"1\": {\"flux\": 1}}}]}"),
    (Code::StatesTwoRotations, 1, "not both", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\": {\"1\": {\"rotation\": [0,0,0], \"quaternion\": [1,0,0,0]}}}]}"),
    (Code::StatesQuaternionNorm, 1, "1, 0, 0, 0", "{\"schema\": \"pintle-states/1\", \"states\": [{\"nodes\": {\"1\": {\"quaternion\": [0,0,0,0]}}}]}"),
];

#[test]
fn faulty_states_are_refused() {
    let scene = Scene::parse("deck.inp", SOUND).unwrap();
    for (code, line, word, text) in STATES {
        let result = if text.starts_with('{') {
            StateFile::parse_json("states", text, &scene)
        } else {
            StateFile::parse_csv("states", text, &scene)
        };
        let error = result.expect_err(text);
        let shown = error.render(110, false);
        assert_eq!(error.code(), *code, "{text}\n{shown}");
        assert_eq!(error.line().unwrap_or(0), *line, "{text}\n{shown}");
        assert!(error.remedy().contains(word), "no `{word}` in the remedy\n{text}\n{shown}");
        assert_eq!(error.file(), "states");
        if error.label().starts_with("column ") {
            let (start, end) = (error.span().start() as usize, error.span().end() as usize);
            assert!(error.message().contains(&text[start..end]) && start < end, "{shown}");
        }
    }
}

#[test]
fn files_that_cannot_be_read_are_refused() {
    let error = Scene::read("no/such/deck.inp").unwrap_err();
    assert_eq!((error.code(), error.line(), error.file()), (Code::Unreadable, None, "no/such/deck.inp"));
    let scene = GALLERY[0].scene().unwrap();
    assert_eq!(StateFile::read("no/such/states.csv", &scene).unwrap_err().code(), Code::Unreadable);
    assert_eq!(StateFile::read("states.xlsx", &scene).unwrap_err().code(), Code::UnknownFormat);
    assert_eq!(Scene::parse("empty.inp", "** nothing\n").unwrap_err().code(), Code::MissingKeywords);
    assert_eq!(Scene::parse_bytes("x.inp", b"*NODE\n\xff, 1.\n").unwrap_err().code(), Code::NotUtf8);
    let long = format!("*NODE\n{}\n", "1".repeat(70_000));
    assert_eq!(Scene::parse("long.inp", &long).unwrap_err().code(), Code::LineTooLong);
}

#[test]
fn every_code_is_provoked_here() {
    use Code::{LineTooLong, MissingKeywords, NotUtf8, UnknownFormat, Unreadable};
    let mut provoked: BTreeSet<&str> = DECKS.iter().chain(WARNINGS).map(|fault| fault.0.as_str()).collect();
    provoked.extend(STATES.iter().map(|fault| fault.0.as_str()));
    provoked.extend([Unreadable, UnknownFormat, MissingKeywords, NotUtf8, LineTooLong].map(Code::as_str));
    // The rules of connection types are broken in verify/rules.rs.
    let all = Code::ALL.iter().map(|code| code.as_str()).filter(|code| !code.starts_with("rule::"));
    let all: BTreeSet<&str> = all.collect();
    assert_eq!(provoked, all);
}

#[test]
fn messages_read_like_rustc() {
    let render = |old: &str, new: &str| {
        let text = SOUND.replacen(old, new, 1);
        Scene::parse("deck.inp", &text).unwrap_err().render(100, false)
    };
    insta::assert_snapshot!("misspelt_parameter", render("BEHAVIOR=B", "BEHAVIOUR=B"));
    insta::assert_snapshot!("reversed_stop", render("-1., 1.", "1., -1."));
    let scene = Scene::parse("deck.inp", SOUND).unwrap();
    let states = "state,node,u1\n0,1,0.5\n0,3,1.5\n1,1,0\n";
    insta::assert_snapshot!(
        "unknown_node",
        StateFile::parse_csv("run.csv", states, &scene).unwrap_err().render(100, false)
    );
}
