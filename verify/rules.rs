//! Every documented rule of the catalogue, broken once by a deck: the code, whether it refuses or warns, and a message that
//! names the element, the type and the source.

use pintle::evaluate::Model;
use pintle::scene::{Code, Diagnostic, Scene, Severity};

/// Two nodes one length apart, a third on the first, and one connector section.
fn deck(section: &str, rest: &str) -> String {
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C{section}\n{rest}"
    )
}

fn compile(text: &str) -> Result<Vec<Diagnostic>, Diagnostic> {
    let scene = Scene::parse("deck.inp", text)?;
    Model::compile(&scene).map(|model| model.warnings)
}

/// (code, severity, deck, a word of the message, a word of the remedy).
fn broken() -> Vec<(Code, Severity, String, &'static str, &'static str)> {
    use Severity::{Error, Warning};
    let behavior = |suboptions: &str, types: &str| {
        deck(", BEHAVIOR=B", &format!("{types}\nO,\n*CONNECTOR BEHAVIOR, NAME=B\n{suboptions}\n"))
    };
    let planar = deck("", "REVOLUTE\nO,\n").replace("CONN3D2", "CONN2D2");
    let standard = "*STEP\n*STATIC\n0.1, 1.\n*END STEP\n";
    let coincident = deck("", "LINK\n").replace("7, 1, 2", "7, 1, 3");
    vec![
        (Code::UnknownConnectionType, Error, deck("", "REVOLUT\nO,\n"), "REVOLUT", "REVOLUTE"),
        (Code::UnknownConnectionType, Error, deck("", "HINGE, JOIN\nO,\n"), "do not pair", "several"),
        (Code::OrientationRequired, Error, deck("", "REVOLUTE\n"), "REVOLUTE requires", "*ORIENTATION"),
        (Code::OrientationRequired, Warning, deck("", "CARDAN\n"), "CARDAN requires", "our reading"),
        (Code::OrientationIgnored, Warning, deck("", "SLOT\nO, O\n"), "node b", "leave it out"),
        (Code::NotInTwoDimensions, Error, planar, "REVOLUTE", "CONN3D2"),
        (
            Code::NotInProcedure,
            Error,
            deck("", &format!("ROTATION-ACCELEROMETER\n{standard}")),
            "Explicit",
            "*DYNAMIC, EXPLICIT",
        ),
        (
            Code::ConvertedInStandard,
            Warning,
            deck("", &format!("ACCELEROMETER\n{standard}")),
            "ACCELEROMETER is CARTESIAN",
            "*DYNAMIC, EXPLICIT",
        ),
        (
            Code::StopNotAvailable,
            Error,
            behavior("*CONNECTOR STOP, COMPONENT=5\n-1., 1.", "REVOLUTE"),
            "component 5",
            "ur1",
        ),
        (
            Code::ReferenceNotAvailable,
            Error,
            behavior("*CONNECTOR CONSTITUTIVE REFERENCE\n, , , , 10.", "REVOLUTE"),
            "component 5",
            "ur1",
        ),
        (
            Code::ActionNotAvailable,
            Error,
            behavior("*CONNECTOR ELASTICITY, COMPONENT=2\n5.", "SLOT"),
            "component 2",
            "u1",
        ),
        (
            Code::FrictionNotPredefined,
            Error,
            behavior("*CONNECTOR FRICTION, PREDEFINED\n1.\n*FRICTION\n0.1", "REVOLUTE"),
            "REVOLUTE",
            "PREDEFINED",
        ),
        (
            Code::FrictionParameters,
            Error,
            behavior("*CONNECTOR FRICTION, PREDEFINED\n1., 2., 3., 4.\n*FRICTION\n0.1", "TRANSLATOR"),
            "0 to 3 numbers, not 4",
            "R_r, L, F_C^int",
        ),
        (Code::SectionDataUnused, Error, deck("", "RETRACTOR\nO,\n50., 1.\n"), "takes 1 numbers", "remove"),
        (Code::CoincidentNodes, Error, coincident, "LINK needs", "JOIN"),
    ]
}

#[test]
fn each_broken_rule_names_element_rule_and_source() {
    for (code, severity, text, word, remedy) in broken() {
        let found = match compile(&text) {
            Ok(warnings) => {
                assert_eq!(severity, Severity::Warning, "nothing refuses {text}");
                warnings
            }
            Err(error) => {
                assert_eq!(severity, Severity::Error, "{error} refuses {text}");
                vec![error]
            }
        };
        let diagnostic =
            found.iter().find(|d| d.code() == code).unwrap_or_else(|| panic!("{code} for {text}"));
        assert!(diagnostic.message().contains(word), "{diagnostic}");
        assert!(diagnostic.remedy().contains(remedy), "{diagnostic}: {}", diagnostic.remedy());
        assert!(diagnostic.line().is_some(), "{diagnostic} has no line");
        if code != Code::UnknownConnectionType {
            assert!(diagnostic.message().contains("element 7"), "{diagnostic}");
            assert!(diagnostic.label().starts_with("by "), "{diagnostic} names no source");
        }
    }
}

/// An ACCELEROMETER is evaluated as CARTESIAN in a Standard analysis and as itself in an Explicit one; so is half of a pair.
#[test]
fn an_accelerometer_depends_on_the_procedure() {
    for (types, procedure, evaluated) in [
        ("ACCELEROMETER\n", "*STATIC\n0.1, 1.", "CARTESIAN"),
        ("ACCELEROMETER, CARDAN\nO,\n", "*STATIC\n0.1, 1.", "CARTESIAN + CARDAN"),
        ("ACCELEROMETER\n", "*DYNAMIC, EXPLICIT\n, 1.", "ACCELEROMETER"),
    ] {
        let text = deck("", &format!("{types}*STEP\n{procedure}\n*END STEP\n"));
        let model = Model::compile(&Scene::parse("deck.inp", &text).unwrap()).unwrap();
        assert_eq!(model.connectors[0].connector.connection().name, evaluated, "{text}");
        assert_eq!(model.warnings.is_empty(), types.starts_with(evaluated), "{text}");
    }
}

#[test]
fn every_rule_is_broken_here() {
    let here: Vec<Code> = broken().into_iter().map(|(code, ..)| code).collect();
    for code in Code::ALL.iter().filter(|code| code.as_str().starts_with("rule::")) {
        assert!(here.contains(code), "no deck breaks {code}");
    }
}

#[test]
fn sound_sections_break_none() {
    for rest in ["REVOLUTE\nO,\n", "SLOT\nO,\n", "AXIAL\n", "CARTESIAN, CARDAN\nO,\n", "RETRACTOR\nO,\n50.\n"]
    {
        let found = compile(&deck("", rest)).unwrap();
        assert!(found.is_empty(), "{rest}: {}", found[0]);
    }
}
