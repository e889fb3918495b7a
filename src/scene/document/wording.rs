//! Messages of the reader of decks, in the words of documents.

use crate::diagnostic::Diagnostic;

/// What decks call things, and what documents call them; longer names first.
const WORDS: &[(&str, &str)] = &[
    ("name an *ORIENTATION as item 1 of the line after the type", "give orientation_a"),
    ("name an *ORIENTATION as item 2 of the line after the type", "give orientation_b"),
    ("name an *ORIENTATION on the line after the type", "give orientation_a"),
    (
        "define the friction with COMPONENT= or *CONNECTOR POTENTIAL, or remove PREDEFINED",
        "describe the friction with component or potential instead of predefined",
    ),
    ("use a *DYNAMIC, EXPLICIT step", "use a step with procedure = \"dynamic_explicit\""),
    ("write: set, GRAV, g, x, y, z", "write values = [g, x, y, z]"),
    ("write *FRICTION, EXPONENTIAL DECAY, TEST DATA", "give test_data"),
    (
        "put *FRICTION with the coefficient directly below *CONNECTOR FRICTION",
        "give the friction its `coefficient`",
    ),
    ("close the step by *END STEP and begin another one", "make two steps of it"),
    ("leave the first data line blank", "leave degrees_of_freedom out"),
    ("on the first data line", "in degrees_of_freedom"),
    ("give a line with ", "give a row with "),
    ("order the lines so that", "order the rows so that"),
    ("must be larger than on the line before", "must be larger than in the row before"),
    ("a data line should follow", "here"),
    ("has no data line", "has no rows"),
    ("; items of a data line are separated by commas", ""),
    (
        "give CONTACT FORCE=…, or a line with the internal contact force, or PREDEFINED",
        "give contact_force, or rows with the internal contact force, or predefined",
    ),
    ("neither data nor CONTACT FORCE", "neither rows nor contact_force"),
    (
        "give COMPONENT=…, or *CONNECTOR POTENTIAL below, or PREDEFINED",
        "give component, potential or predefined",
    ),
    ("give COMPONENT=…, or *CONNECTOR POTENTIAL below", "give component or potential"),
    ("neither COMPONENT nor a potential", "neither component nor potential"),
    ("*CONNECTOR CONSTITUTIVE REFERENCE", "constitutive_reference"),
    ("*CONNECTOR DERIVED COMPONENT", "derived_components"),
    ("*CONNECTOR DAMAGE INITIATION", "damage"),
    ("*CONNECTOR DAMAGE EVOLUTION", "evolution"),
    ("*CONNECTOR ELASTICITY", "elasticity"),
    ("*CONNECTOR PLASTICITY", "plasticity"),
    ("*CONNECTOR HARDENING", "hardening"),
    ("*CONNECTOR POTENTIAL", "potential"),
    ("*CONNECTOR BEHAVIOR", "behaviors"),
    ("*CONNECTOR FRICTION", "friction"),
    ("*CONNECTOR DAMPING", "damping"),
    ("*CONNECTOR SECTION", "connector_sections"),
    ("*CONNECTOR FAILURE", "failures"),
    ("*CONNECTOR MOTION", "connector_motions"),
    ("*CONNECTOR STOP", "stops"),
    ("*CONNECTOR LOCK", "locks"),
    ("*CONNECTOR LOAD", "connector_loads"),
    ("*DYNAMIC, EXPLICIT", "dynamic_explicit"),
    ("*ROTARY INERTIA", "rotary_inertias"),
    ("*INITIAL CONDITIONS", "initial_velocities"),
    ("*ORIENTATION", "orientations"),
    ("*AMPLITUDE", "amplitudes"),
    ("*TRANSFORM", "transforms"),
    ("*BOUNDARY", "boundaries"),
    ("*FRICTION", "coefficient"),
    ("*DASHPOT", "dashpots"),
    ("*ELEMENT", "connectors or point_elements"),
    ("*SPRING", "springs"),
    ("*CLOAD", "concentrated_loads"),
    ("*DLOAD", "distributed_loads"),
    ("*ELSET, ELSET=", "element_sets."),
    ("*NSET, NSET=", "node_sets."),
    ("*ELSET", "element_sets"),
    ("*NSET", "node_sets"),
    ("*NODE", "nodes"),
    ("*MASS", "masses"),
    ("*STEP", "steps"),
    ("*MPC", "mpcs"),
    (", NAME=", "."),
    ("COMPONENT=…", "component"),
    ("TYPE=CONN", "dimension = CONN"),
    ("UNSYMM and COMPONENT", "unsymmetric and component"),
    ("UNSYMM or COMPONENT", "unsymmetric or component"),
    ("NONLINEAR and RIGID", "nonlinear and rigid"),
    ("NONLINEAR or RIGID", "nonlinear or rigid"),
    ("PREDEFINED and ", "predefined and "),
    ("PREDEFINED or ", "predefined or "),
    (" SYSTEM=", " system = "),
    (" DEFINITION=", " definition = "),
    ("make two decks of it", "make two scenes of it"),
    ("one deck cannot", "one scene cannot"),
];

/// The same diagnostic, in words that fit a document.
pub(super) fn of_document(diagnostic: Diagnostic) -> Diagnostic {
    diagnostic.reworded(&|text| {
        let mut text = text.to_owned();
        for (deck, document) in WORDS {
            if text.contains(deck) {
                text = text.replace(deck, document);
            }
        }
        text
    })
}
