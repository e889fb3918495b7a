//! What a connector section may do. What it may not is in verify/faults/deck.

use pintle_model::evaluate::Model;
use pintle_scene::{Diagnostic, Scene};

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
fn sound_sections_break_none() {
    for rest in ["REVOLUTE\nO,\n", "SLOT\nO,\n", "AXIAL\n", "CARTESIAN, CARDAN\nO,\n", "RETRACTOR\nO,\n50.\n"]
    {
        let found = compile(&deck("", rest)).unwrap();
        assert!(found.is_empty(), "{rest}: {}", found[0]);
    }
}
