//! Every legitimate deck is read: what bears on no connector is skipped and counted, and what makes nodes makes them.

use pintle_model::evaluate::Model;
use pintle_scene::{Code, ForceFile, ForceSign, Format, Label, Scene, Severity, State, StateFile};
use std::collections::BTreeMap;

/// A HINGE between nodes 1 and 2.
const HINGE: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=OZ\n0., 0., 1., 1., 0., 0.\n\
    *ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\nHINGE\nOZ,\n";

fn read(text: &str) -> Scene {
    Scene::parse("deck.inp", text).unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)))
}

/// Lines that a deck with a HINGE may have, and what is counted of them.
#[test]
fn what_bears_on_no_connector_is_skipped_and_counted() {
    let solid =
        "*NODE, NSET=FAR\n11, 5., 0., 0.\n12, 6., 0., 0.\n*ELEMENT, TYPE=T3D2, ELSET=BARS\n1, 11, 12\n";
    let cases = [
        ("*BOUNDARY\nFAR, 11, 11, 20.\n1, 8\n", "*BOUNDARY of degree of freedom"),
        ("*BOUNDARY\n11, 8, 9\n", "*BOUNDARY of degrees of freedom 8 to 9"),
        ("*BOUNDARY\n11, NOWARP\n12, NOOVAL\n", "*BOUNDARY NOWARP"),
        ("*PARAMETER\nw = 2*sqrt(2.)\n*NODE\n700, <w>, 0., 0.\n", ""),
        ("*STEP\n*CLOAD\n1, 9, 2.\n11, 11, 1.\n*END STEP\n", "*CLOAD of degree of freedom"),
        ("*INITIAL CONDITIONS, TYPE=TEMPERATURE\nFAR, 20.\n", "INITIAL CONDITIONS"),
        ("*ORIENTATION, NAME=D\nField\n3, 0.\n", "*ORIENTATION by a distribution"),
        ("*STEP, NLGEO, UNSYM=YES, FLAVOUR=SWEET\n*END STEP\n", "*STEP, FLAVOUR"),
        ("*STEP\n*STATIC, SOLVER=PARDISO\n*BOUNDARY, AMP=A\n1, 1\n*END STEP\n*AMP", ""),
        (
            "*AMPLITUDE, NAME=A, INPUT=not there\n*STEP\n*DLOAD, AMP=A\nBARS, P1, 1.\n*END STEP\n",
            "*DLOAD with an amplitude",
        ),
        (
            "*AMPLITUDE, NAME=A, USER\n*STEP\n*BOUNDARY, AMPLITUDE=A\nFAR, 1\n*END STEP\n",
            "*BOUNDARY with an amplitude",
        ),
        ("*STEP\n*BOUNDARY, SUBMODEL, STEP=1\nFAR, 1, 3\n*END STEP\n", "*BOUNDARY, SUBMODEL"),
        ("*STEP\n*BOUNDARY, MASS FLOW\n11, 1, 1, 2.\n*END STEP\n", "*BOUNDARY, MASS FLOW"),
        (
            "*EQUATION\n2\n11, 1, 1., 12, 1, -3.\n*STEP\n*BOUNDARY, MASS FLOW\n11, 1, 1, 2.\n*END STEP\n",
            "*BOUNDARY, MASS FLOW",
        ),
        ("*NSET, NSET=SLAVES, FREQUENCY=100\n11\n", "*NSET, FREQUENCY"),
        ("*STEP\n*CLOAD, SECTOR=3\n11, 1, 2.\n*END STEP\n", "*CLOAD, SECTOR"),
        ("*STEP\n*DLOAD, SECTOR=3\nBARS, P1, 2.\n*END STEP\n", "*DLOAD, SECTOR"),
        ("*JOINT, ELSET=BARS\nOZ,\n*SPRING\n1, 1\n2.\n*DASHPOT\n1, 1\n2.\n*SPRING\n2, 2\n3.\n", "JOINT"),
        ("*STEP\n*MODEL CHANGE, REMOVE\nBARS,\n*END STEP\n", "MODEL CHANGE"),
        ("*MPC\nBARREL, 11, 12\n", ""),
        ("*RESTART, WRITE, FREQUENCY=3\n", "RESTART"),
        ("*NMAP, NSET=FAR, TYPE=CYLINDRICAL\n0., 0., 0., 0., 0., 1.\n1., 0., 0.\n", "NMAP"),
        ("*PARAMETER\nfar = 3\nname = 7/2\n", "PARAMETER"),
        ("*TRANSFORM, NSET=FAR, TYPE=C\n5., 0., 0., 5., 0., 1.\n", ""),
        ("*ORIENTATION, NAME=UNUSED\n1., 0., 0., 2., 0., 0.\n", ""),
        ("*BOUNDARY,\n11, 1, 3\n", ""),
        ("*NSET, NSET=GHOST\n77\n", ""),
        ("*ELEMENT, TYPE=SPRINGA, ELSET=S\n21, 11, 12\n*SPRING, ELSET=S\n100.\n", ""),
    ];
    let mut counted = 0;
    for (lines, what) in cases {
        // The first lines before the model, which may use their names.
        let lines = lines
            .strip_suffix("*AMP")
            .map_or(lines.to_owned(), |lines| format!("*AMPLITUDE, NAME=A\n0., 0., 1., 1.\n{lines}"));
        let scene = read(&format!("{HINGE}{solid}{lines}"));
        let skipped = scene.skipped.parameters.keys().chain(scene.skipped.keywords.keys());
        assert!(what.is_empty() || skipped.clone().any(|name| name.contains(what)), "{lines}: {skipped:?}");
        assert!(scene.orientation_errors().is_empty() && scene.connectors.len() == 1, "{lines}");
        counted += 1;
    }
    assert_eq!(counted, 28);
}

/// What acts on a node of a connector is an error, or read.
#[test]
fn what_bears_on_a_connector_is_not_skipped() {
    let cases = [
        "*STEP\n*BOUNDARY\n2, 1, 1, <u>\n*END STEP\n",
        "*STEP\n*CLOAD\n2, 1, 1, 5.\n*END STEP\n",
        "*AMPLITUDE, NAME=A\n0., <a>\n*STEP\n*CLOAD, AMPLITUDE=A\n1, 1, 2.\n*END STEP\n",
        "*NODE\n3, <x>\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n102, 1, 3\n",
        "*ELEMENT, TYPE=MASS, ELSET=M\n7, 1\n*MASS, ELSET=M\n<m>\n",
        "*TRANSFORM, NSET=N\n<x>, 0., 0., 0., 1., 0.\n*NSET, NSET=N\n2\n",
        "*STEP\n*DLOAD\n, GRAV, <g>, 0., 0., -1.\n*END STEP\n",
        "*AMPLITUDE, NAME=A, USER\n*STEP\n*CLOAD, AMPLITUDE=A\n1, 1, 2.\n*END STEP\n",
        "*STEP\n*BOUNDARY, AMPLITDE=A\n2, 1\n*END STEP\n",
        "*NSET, NSET=N\n1\n*NMAP, NSET=N\n",
        // A mass or a spring is solved with the connectors.
        "*NODE\n11, 5., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n31, 11\n*MASS, ELSET=M\n<m>\n",
        "*NODE\n11, 5., 0., 0.\n*ELEMENT, TYPE=SPRING1, ELSET=S\n31, 11\n*SPRING, ELSET=S\n1\n<k>\n",
        "*NODE\n11, 5., 0., 0.\n*ELEMENT, TYPE=MASS, ELSET=M\n31, 11\n*MASS, ELSET=M\n1.\n*STEP\n*CLOAD\n11, 1, <f>\n*END STEP\n",
        // Nodes that nothing but a coupling or a body names.
        "*NODE\n11, 5., 0., 0.\n*SURFACE, TYPE=NODE, NAME=S\n2,\n*COUPLING, CONSTRAINT NAME=C, REF NODE=11, SURFACE=S\n*KINEMATIC\n*STEP\n*CLOAD\n11, 1, <f>\n*END STEP\n",
        "*NODE, NSET=B\n11, 5., 0., 0.\n*NODE\n12, 5., 0., 0.\n*RIGID BODY, REF NODE=12, PIN NSET=B\n*STEP\n*CLOAD\n12, 1, <f>\n*END STEP\n",
        // What gravity is cannot be told.
        "*AMPLITUDE, NAME=A\n0., <a>\n*STEP\n*DLOAD, AMPLITUDE=A\n, GRAV, 9.81, 0., 0., -1.\n*END STEP\n",
        "*STEP\n*DLOAD, AMPLITUDE=<a>\n, GRAV, 9.81, 0., 0., -1.\n*END STEP\n",
        "*STEP, AMPLITUDE=<a>\n*CLOAD\n1, 1, 2.\n*END STEP\n",
    ];
    for lines in cases {
        let error = Scene::parse("deck.inp", &format!("{HINGE}{lines}")).expect_err(lines);
        let codes = [Code::UnsupportedKeyword, Code::UnknownAmplitude, Code::UnknownParameter];
        let of_lines = [Code::MalformedNumber, Code::SurplusData, Code::BadParameterValue];
        assert!(codes.contains(&error.code()) || of_lines.contains(&error.code()), "{lines}: {error}");
        assert!(error.further().is_empty(), "{lines}: {:?}", error.further());
    }
    let scene = read(&format!("{HINGE}*BOUNDARY\n1, 4, 11\n"));
    assert_eq!(scene.boundaries[0].degrees_of_freedom, [4, 5, 6, 10]);
}

/// Loads and conditions with parameters that are not read are named where they act on a connector's nodes, and refuse nothing.
#[test]
fn what_acts_in_ways_that_are_not_read_is_named() {
    let cases = [
        ("*STEP\n*CLOAD, CYCLIC MODE=3\n1, 1, 2.\n*END STEP\n", "*CLOAD, CYCLIC MODE acts on node 1", 0),
        ("*STEP\n*BOUNDARY, TIME DELAY=1.\n2, 1\n*END STEP\n", "*BOUNDARY, TIME DELAY acts on node 2", 1),
        ("*NSET, NSET=N\n2\n*BOUNDARY, MASS FLOW\nN, 1\n", "*BOUNDARY, MASS FLOW acts on node 2", 1),
        ("*STEP\n*BOUNDARY, SUBMODEL\n2, 1\n*END STEP\n", "*BOUNDARY, SUBMODEL acts on node 2", 1),
    ];
    for (lines, message, constraints) in cases {
        let scene = read(&format!("{HINGE}{lines}"));
        let [warning] = scene.warnings.as_slice() else { panic!("{lines}: {:?}", scene.warnings) };
        assert_eq!(warning.code(), Code::NotFollowed, "{lines}");
        assert!(warning.message().contains(message), "{warning}");
        assert_eq!(
            scene.skipped.constraints.len(),
            constraints,
            "what may hold a node is a constraint that is not read"
        );
    }
}

/// A faulty line of what bears on no connector is a warning and a count; so is every fault of a deck without a connector or a constraint.
#[test]
fn faults_that_bear_on_no_connector_refuse_nothing() {
    let far = "*NODE, NSET=FAR\n11, 5., 0., 0.\n12, 6., 0., 0.\n*ELEMENT, TYPE=T3D2, ELSET=BARS\n1, 11, 12\n";
    let cases = [
        "*MATERIAL, NAME=M\n*ELASTIC\n<e>, <nu>\n",
        "*STEP, INC=<inc>\n*STATIC\n<dt>, 1., <min>\n*END STEP\n",
        "*STEP\n*NODE OUTPUT, NSET=<set>\n<v>\n*ELEMENT OUTPUT, ELSET=PINS\nS\n*END STEP\n",
        "*STEP\n*DLOAD, AMPLITUDE=<a>\nBARS, P1, <p>\n99, P1, 2.\nNONE, P2, 2.\n*END STEP\n",
        "*STEP\n*CLOAD\nFAR, 1, <f>\n11, 3, 3, 0.\n*BOUNDARY\nFAR, 1, 1, <u>\n*END STEP\n",
        "*STEP\n*CLOAD, AMPLITUDE=<a>\nFAR, 1, 2.\n*END STEP\n",
        "*AMPLITUDE, NAME=A\n0., <a>\n*STEP\n*CLOAD, AMPLITUDE=A\n11, 1, 2.\n*END STEP\n",
        "*INITIAL CONDITIONS, TYPE=VELOCITY\nFAR, 1, <v>\n",
        "*NODE\n21, <x>\n",
        "*ORIENTATION, NAME=Q\n<x>, 0., 1.\n*TRANSFORM, NSET=FAR\n<x>, 0., 1.\n",
        "*EQUATION\n2\n11, 0, 1., 12, 0, -1.\n",
        "*STEP,\n*STATIC\n*END STEP,\n",
        "*ELEMENT, TYPE=C3D8, PARENT=3\n5, 11, 12\n*NODE, FLAVOUR=SWEET\n41\n",
        "*\n*MATERIAL, NAME=M\n",
        "*NSET, NSET=Q, GENERATE\n11, <n>\n",
        "*NSET, NSET=Q\n11, 1.5\nNONE,\n*ELSET, ELSET=FEW\n<e>, 1.5\nNONE,\n",
    ];
    for lines in cases {
        let scene = read(&format!("{HINGE}{far}{lines}"));
        assert_eq!(scene.connectors.len(), 1, "{lines}");
    }
    let counted = read(&format!("{HINGE}{far}*STEP\n*CLOAD\nFAR, 1, <f>\n*END STEP\n"));
    assert!(counted.skipped.parameters.contains_key("lines that cannot be read"), "{:?}", counted.skipped);
    assert_eq!(
        counted.warnings.iter().map(pintle_scene::Diagnostic::code).collect::<Vec<_>>(),
        [Code::MalformedNumber]
    );
    let alone = [
        "*STEP\n*DYNAMIC, EXPLICIT\n,1.\n*END STEP\n*STEP\n*STATIC\n*END STEP\n",
        ">**\n*STEP\n*BOUNDARY\n98, 1\nGHOST, 2\n*END STEP\n",
        "*NSET, NSET=N, INSTANCE=PART-1\n11\n*END ASSEMBLY\n",
        "*PART, NAME=P\n*NODE\n1\n*END PART\n",
    ];
    for lines in alone {
        assert!(!read(lines).warnings.is_empty(), "{lines}");
        let error = Scene::parse("deck.inp", &format!("{lines}*MPC\n")).expect_err("a constraint is meant");
        assert!(error.file() == "deck.inp", "{error}");
    }
    for used in ["*NSET, NSET=Q\n1, 1.5\n", "*NSET, NSET=Q\n1\nNONE,\n", "*NSET, NSET=Q, GENERATE\n1, <n>\n"]
    {
        let lines = format!("{HINGE}{far}{used}*BOUNDARY\nQ, 1, 1\n");
        let error = Scene::parse("deck.inp", &lines).expect_err("a set of a node of the hinge");
        assert_eq!(error.further().len(), 0, "{used}: {error}");
    }
    // Lines without any keyword are no deck, and a file that is not there may have connectors.
    for lines in ["1, 2., 3.\n", "*NODE\n1\n*INCLUDE, INPUT=none.inp\n"] {
        assert!(Scene::parse("deck.inp", lines).is_err(), "{lines}");
    }
}

/// Other ends of lines, blanks, and beginnings of words: each deck is the same one.
#[test]
fn spelling_does_not_matter() {
    let plain = format!(
        "{HINGE}*AMPLITUDE, NAME=A, TIME=TOTAL TIME\n0., 0., 1., 1.\n*STEP\n*STATIC\n*CONNECTOR MOTION, AMPLITUDE=A, TYPE=DISPLACEMENT\nE, 4, 1.\n*END STEP\n"
    );
    let known = read(&plain);
    let spelt = [
        plain.replace('\n', "\r\n"),
        plain.replace('\n', "\r"),
        plain.replacen('\n', "\r", 9),
        plain.replace(", ", ",\u{a0}"),
        plain.replace(", ", ",\t"),
        format!("{plain}\u{1a}"),
        format!("{plain}*\n"),
        plain.replace("*END STEP\n", "*END STEP,\n"),
        plain.replace("TYPE=DISPLACEMENT", "TYP=Disp"),
        plain.replace("NAME=", "NAM=").replace("TOTAL TIME", "total").replace("ELSET=", "ELS="),
    ];
    for text in spelt {
        let scene = read(&text);
        assert_eq!(scene.nodes.len(), 2, "{text:?}");
        let motion = &scene.steps[0].connector_motions[0];
        let expected = &known.steps[0].connector_motions[0];
        assert_eq!((motion.magnitude, motion.kind), (expected.magnitude, expected.kind), "{text:?}");
        assert_eq!(scene.amplitudes["A"].time, known.amplitudes["A"].time, "{text:?}");
        assert_eq!(scene.warnings.len(), 0, "{text:?}: {:?}", scene.warnings);
    }
    let words: Vec<u8> = plain.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let error = Scene::parse_bytes("deck.inp", &[&b"\xff\xfe"[..], &words].concat()).unwrap_err();
    assert_eq!((error.code(), error.message()), (Code::NotUtf8, "the file is encoded as UTF-16"));
    // Every separator another one: no connector is lost without an error.
    let error = Scene::parse("deck.inp", &HINGE.replace(',', ";")).unwrap_err();
    assert_eq!(error.code(), Code::MalformedInteger);
    // Decimal commas make normals of zeros, which is said.
    let commas = read(&HINGE.replace("2, 1., 0., 0.", "2, 1,5, 0,0, 0,0"));
    assert_eq!(commas.warnings[0].code(), Code::ItemsAfterCoordinates);
}

/// What foreign decks have and what is not wrong with them.
#[test]
fn no_false_warnings() {
    let cases = [
        // More items than nodes, and a comma at the end: the next line is the next element.
        "*NODE, NSET=FAR\n11\n12\n*ELEMENT, TYPE=C3D4, ELSET=S\n1, 11, 12, 11, 12, 7, 8,\n2, 11, 12, 11, 12, 7, 8,\n*ELSET, ELSET=ALL, GENERATE\n1, 2\n",
        "*STEP, INCF=100\n*STATIC\n*END STEP\n",
        // Not of a connector's node, and not of its motion.
        "*NODE\n11\n12\n*BOUNDARY\n11, 1, 1, 293.\n12, 11, 11, 20.\n",
        "*NODE\n11\n12\n13\n*ELEMENT, TYPE=D\n1, 11, 12, 13\n*EQUATION\n2\n11, 1, 1., 13, 1, -1.\n",
        "*NODE\n11\n12\n*NSET, NSET=B\n12\n*RIGID BODY, PIN NSET=B, REFNODE=11\n",
    ];
    for lines in cases {
        let scene = read(&format!("{HINGE}{lines}"));
        assert!(scene.warnings.is_empty(), "{lines}: {:?}", scene.warnings);
        assert!(scene.equations.is_empty(), "an equation of a network is not one of motions");
    }
    // The tie of stages of a rotor joins what turns at another angle.
    let tie = "*NODE\n11\n12\n*SURFACE, TYPE=NODE, NAME=S\n11\n*SURFACE, TYPE=NODE, NAME=M\n12\n*TIE, NAME=T, MULTISTAGE\nS, M\n";
    let scene = read(&format!("{HINGE}{tie}"));
    assert_eq!((scene.skipped.constraints.len(), scene.ties.len()), (1, 0));
}

fn places(text: &str, expected: &[(u64, [f64; 3])]) {
    let scene = read(text);
    for (label, place) in expected {
        let found = scene.nodes.get(&Label::from(*label)).map(|node| node.coordinates);
        let found = found.unwrap_or_else(|| panic!("{text}: no node {label}"));
        let near = (0..3).all(|k| (found[k] - place[k]).abs() < 1e-14 * (1.0 + place[k].abs()));
        assert!(near, "{text}: node {label} is at {found:?}, not {place:?}");
    }
}

/// Positions worked out by hand from the rules of the manual.
#[test]
fn nodes_are_generated_where_the_manual_says() {
    let (half, root) = (0.5_f64.sqrt(), 2.0_f64.sqrt());
    let ends = "*NODE\n1, 1., 0., 0.\n5, 0., 1., 0.\n9, -1., 0., 0.\n20, 0., 0., 0.\n";
    places(&format!("{ends}*NGEN, LINE=C\n1, 5, 2, 20\n"), &[(3, [half, half, 0.0])]);
    places(&format!("{ends}*NGEN, LINE=C\n1, 5, 2, , 0., 0., 0.\n"), &[(3, [half, half, 0.0])]);
    let other_way = format!("{ends}*NGEN, LINE=C\n1, 9, 4, 20, , , , 0., 0., -1.\n*MPC\n");
    assert!(Scene::parse("deck.inp", &other_way).is_err(), "node 5 lies on the other half");
    places(
        &format!("{ends}*NGEN, LINE=C\n1, 9, 2, 20, , , , 0., 0., 1.\n"),
        &[(3, [half, half, 0.0]), (7, [-half, half, 0.0])],
    );
    places(
        "*NODE\n1, 1., 0., 0.\n3, 0., 2., 4.\n*NGEN, LINE=C\n1, 3, 1, , 0., 0., 0., 0., 0., 1.\n",
        &[(2, [1.5 * half, 1.5 * half, 2.0])],
    );
    places(
        "*NODE\n1, 0., 0., 0.\n5, 4., 0., 0.\n*NGEN, LINE=P\n1, 5, 1, , 2., 1., 0.\n",
        &[(2, [1.0, 0.75, 0.0]), (3, [2.0, 1.0, 0.0]), (4, [3.0, 0.75, 0.0])],
    );
    places(
        "*NODE\n1, 2., 0., 0.\n5, 0., 2., 0.\n*NGEN, LINE=P, SYSTEM=C\n1, 5, 2, , 2., 45., 0.\n",
        &[(3, [root, root, 0.0])],
    );
    let bounds =
        "*NODE, NSET=A\n1, 0., 0., 0.\n2, 0., 1., 0.\n*NODE, NSET=B\n101, 7., 0., 0.\n102, 7., 8., 0.\n";
    places(&format!("{bounds}*NFILL\nA, B, 4, 25\n"), &[(26, [1.75, 0.0, 0.0]), (77, [5.25, 6.25, 0.0])]);
    places(
        &format!("{bounds}*NFILL, BIAS=0.5, NSET=ALL\nA, B, 3, 10\n"),
        &[(11, [1.0, 0.0, 0.0]), (21, [3.0, 0.0, 0.0])],
    );
    let copied = |how: &str| format!("{bounds}*NCOPY, CHANGE NUMBER=1000, OLD SET=B, {how}");
    places(&copied("SHIFT\n1., 2., 3.\n"), &[(1101, [8.0, 2.0, 3.0]), (1102, [8.0, 10.0, 3.0])]);
    places(
        &copied("SHIFT, MULTIPLE=2\n, ,\n0., 0., 0., 0., 0., 1., 90.\n"),
        &[(1102, [-8.0, 7.0, 0.0]), (2102, [-7.0, -8.0, 0.0])],
    );
    places(&copied("REFLECT=LINE\n0., 0., 0., 1., 0., 0.\n"), &[(1102, [7.0, -8.0, 0.0])]);
    places(&copied("REFLECT=MIRROR\n1., 0., 0., 1., 1., 0.\n1., 0., 1.\n"), &[(1102, [-5.0, 8.0, 0.0])]);
    places(&copied("REFLECT=POINT\n1., 1., 1.\n"), &[(1102, [-5.0, -6.0, 2.0])]);
    places(&copied("POLE\n2,\n"), &[(1102, [14.0, 15.0, 0.0])]);
    places(
        "*SYSTEM\n1., 2., 3.\n*NODE\n1, 1., 0., 0.\n*SYSTEM\n*NODE\n2, 1., 0., 0.\n",
        &[(1, [2.0, 2.0, 3.0]), (2, [1.0, 0.0, 0.0])],
    );
    places("*SYSTEM\n1., 0., 0., 1., 1., 5.\n*NODE\n1, 2., 3., 4.\n", &[(1, [-2.0, 2.0, 4.0])]);
    places(
        "*SYSTEM\n0., 0., 0., 0., 0., 1.\n1., 0., 0.\n*NODE, SYSTEM=C\n1, 2., 90., 1.\n",
        &[(1, [2.0, 1.0, 0.0])],
    );
    places("*NODE, SYSTEM=S\n1, 2., 90., 30.\n", &[(1, [0.0, 3.0_f64.sqrt(), 1.0])]);
    places("*PARAMETER\na = 2\nb = a*1.5 + 1\n*NODE\n<a>, <b>, 0., <a>\n", &[(2, [4.0, 0.0, 2.0])]);
}

#[test]
fn elements_are_copied_with_their_nodes() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n11, 0., 1., 0.\n12, 1., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n\
        *ELEMENT, TYPE=T3D2, ELSET=E\n7, 1, 2\n*ELCOPY, ELEMENT SHIFT=100, OLD SET=E, SHIFT NODES=10, NEW SET=F\n\
        *ELSET, ELSET=PINS\n101, 201\n*CONNECTOR SECTION, ELSET=PINS\nBEAM\n";
    let scene = read(deck);
    let copy = &scene.connectors[&Label::from(201)];
    assert_eq!((copy.a, copy.b), (Some(Label::from(11)), Some(Label::from(12))));
    assert_eq!((scene.element_sets["F"].labels.len(), scene.element_sets["F"].unmodelled), (1, 1));
}

#[test]
fn parameters_may_be_shortened_to_any_unambiguous_beginning() {
    let deck = format!(
        "{HINGE}*NSET, NSET=ALL, GEN\n1, 2\n*AMPLITUDE, NAME=A, DEF=TABULAR, TI=TOTAL TIME\n0., 0., 1., 1.\n\
        *STEP, NLGEO, INC=7\n*CONNECTOR MOTION, AMP=A\nE, 4, 1.\n*END STEP\n"
    );
    let scene = read(&deck);
    assert_eq!(scene.node_sets["ALL"].labels.len(), 2);
    assert_eq!((scene.steps[0].nlgeom, scene.steps[0].increments), (Some(true), Some(7)));
    assert_eq!(scene.steps[0].connector_motions[0].applied.amplitude.as_ref().unwrap().value, "A");
    // EXTRAPOLATION, but REGULARIZE and RTOL begin alike.
    let ambiguous = format!("{HINGE}*CONNECTOR BEHAVIOR, NAME=B, R=ON\n");
    assert_eq!(Scene::parse("deck.inp", &ambiguous).unwrap_err().code(), Code::UnknownParameter);
}

#[test]
fn names_may_be_qualified_by_the_assembly() {
    let deck = "*PART, NAME=Link\n*NODE, NSET=Ends\n1, 0., 0., 0.\n2, 1., 0., 0.\n*END PART\n*ASSEMBLY, NAME=Whole\n\
        *INSTANCE, NAME=Link-1, PART=Link\n*END INSTANCE\n*INSTANCE, NAME=Link-2, PART=Link\n1., 0., 0.\n*END INSTANCE\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=Pin\n1, Whole.Link-1.2, Link-2.1\n*CONNECTOR SECTION, ELSET=Pin\nBEAM\n*END ASSEMBLY\n\
        *NSET, NSET=Outside, INSTANCE=Whole.Link-1\n1, 2\n*NSET, NSET=Both\nWHOLE.LINK-1.ENDS, Outside\n\
        *BOUNDARY\nWHOLE.LINK-1.1, 1\nwhole.link-2.Ends, 1\n";
    let scene = read(deck);
    assert_eq!(scene.connectors[&Label::from(1)].a.unwrap().to_string(), "LINK-1.2");
    assert_eq!((scene.node_sets["BOTH"].labels.len(), scene.boundaries.len()), (2, 2));
}

/// Keywords of programs that are skipped and resemble ones that are read are no misspelling; what is one is told, each with a remedy.
#[test]
fn keywords_of_other_subjects_are_no_misspelling() {
    let others =
        ["DISTRIBUTION", "DISTRIBUTION TABLE", "BOUNDARYF", "TRANSFORMF", "FILE OUTPUT", "POST OUTPUT"];
    let misspelt = ["CONECTOR SECTION", "ORIENTATON", "BOUNDRY"];
    let of = |keyword: &str| read(&format!("{HINGE}*{keyword}, NAME=D\n1, 2\n")).warnings.len();
    for keyword in others {
        assert_eq!(of(keyword), 0, "{keyword}");
    }
    for keyword in misspelt {
        assert_eq!(of(keyword), 1, "{keyword}");
    }
    // Of these, what holds or drives connectors is missing among their constraints; springs and loads are not.
    let unread = |keyword: &str| {
        let scene = read(&format!("{HINGE}*{keyword}\n1, 2\n"));
        (scene.warnings.len(), scene.unread_constraints().len())
    };
    for (keyword, held) in [
        ("CONECTOR SECTION, ELSET=E", 1),
        ("BOUNDRY", 1),
        ("CONECTOR ELASTICITY, COMPONENT=4", 0),
        ("CONECTOR ELASTICITY, RIGID, COMPONENT=4", 1),
        ("CONECTOR STOP, COMPONENT=4", 0),
        ("CONNECTR LOAD", 0),
    ] {
        assert_eq!(unread(keyword), (1, held), "{keyword}");
    }
}

/// However many warnings of one code there are, those of others are kept, and the first counts the rest.
#[test]
fn a_flood_of_one_warning_hides_no_other() {
    let deck = format!("{HINGE}{}*CONECTOR STOP\n1\n", "*CONNECTR LOAD\n1, 1, 1.\n".repeat(300));
    let deck = deck + "*STEP\n*MODEL CHANGE, REMOVE\nE\n*END STEP\n";
    let scene = read(&deck);
    let [misspelt, removed]: [Vec<_>; 2] = [Code::MisspeltKeyword, Code::NotFollowed]
        .map(|code| scene.warnings.iter().filter(|warning| warning.code() == code).collect());
    assert_eq!((misspelt.len(), removed.len()), (pintle_scene::MAX_WARNINGS, 1));
    assert_eq!(misspelt[0].unsaid() + misspelt.len(), 301);
}

/// Paths of files that an included file includes count from it, or from the deck.
#[test]
fn included_files_are_found_from_the_deck() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("nested-include");
    std::fs::create_dir_all(folder.join("a/b")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    write("a/b/from_deck.inp", "*NODE\n21, 1., 0., 0.\n");
    write("a/b/from_file.inp", "*NODE\n22, 2., 0., 0.\n");
    write("a/mesh.inp", "*INCLUDE, INPUT=a/b/from_deck.inp\n*INCLUDE, INPUT=b/from_file.inp\n");
    write("deck.inp", &format!("{HINGE}*INCLUDE, INPUT=a/mesh.inp\n"));
    let scene = Scene::read(folder.join("deck.inp")).unwrap();
    assert_eq!((scene.nodes.len(), scene.files.len()), (4, 4));
    write("a/mesh.inp", "*INCLUDE, INPUT=b/not_there.inp\n");
    assert_eq!(Scene::read(folder.join("deck.inp")).unwrap_err().code(), Code::IncludeUnreadable);
}

/// Where nothing is left to evaluate, what was not read is named; what is skipped of a keyword is said by `eval`, too.
#[test]
fn what_is_skipped_is_said() {
    let pintle = |name: &str, text: &str| {
        let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::write(&file, text).unwrap();
        let mut command = assert_cmd::Command::new(env!("CARGO_BIN_EXE_pintle"));
        let output = command.args(["eval", "-v", file.to_str().unwrap()]).output().unwrap();
        let told = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        (output.status.code(), told)
    };
    let (code, told) = pintle("only-unread.inp", "*NODE\n1, 0., 0., 0.\n*EMBEDDED ELEMENT\nA\n");
    assert!(code == Some(4) && told.contains("not read: *EMBEDDED ELEMENT (line 3)"), "{code:?} {told}");
    let (code, told) = pintle("skipped.inp", &format!("{HINGE}*BOUNDARY\n1, 8, 9\n1, 11\n"));
    assert!(code == Some(0) && told.contains("2 skipped parameters and lines"), "{code:?} {told}");
    assert!(told.contains("*BOUNDARY of degrees of freedom 8 to 9"), "{told}");
}

#[test]
fn a_deck_that_goes_on_from_another_says_so() {
    let scene =
        read("*HEADING\n*RESTART, READ, STEP=1\n*STEP\n*BOUNDARY\nLEFT, 1, 3\n*CLOAD\n7, 1, 2.\n*END STEP\n");
    let codes: Vec<Code> = scene.warnings.iter().map(pintle_scene::Diagnostic::code).collect();
    assert_eq!(codes, [Code::NotFollowed]);
    assert_eq!(scene.skipped.parameters["what acts on the model of another deck"].count, 2);
    let scene = read(&format!("{HINGE}*STEP\n*MODEL CHANGE, REMOVE\nE\n*END STEP\n"));
    assert!(scene.warnings[0].message().contains("removes connector 101"), "{:?}", scene.warnings);
}

/// A scene as it is after it was written.
fn read_back(scene: &Scene, format: Format) -> Scene {
    let written = scene.write(format).unwrap().text;
    let back = match format {
        Format::Deck => Scene::parse("deck.inp", &written),
        Format::Toml => Scene::parse_toml("deck.toml", &written),
        Format::Json => Scene::parse_json("deck.json", &written),
    };
    back.unwrap_or_else(|error| panic!("{format:?}:\n{written}\n{}", error.render(100, false)))
}

/// Requests of output and loads outside every step are skipped; what acts on a node that cannot be read is not written.
#[test]
fn what_is_skipped_is_not_written() {
    for lines in ["*OUTPUT, FIELD\n*NODE OUTPUT\nU\n", "*DLOAD\nBARS, P1, 2.\n*NODE PRINT\nU\n"] {
        let scene = read(&format!("{HINGE}{lines}"));
        assert!(scene.warnings.iter().all(|warning| warning.severity() == Severity::Warning), "{lines}");
        assert!(!scene.skipped.keywords.is_empty(), "{lines}");
        read_back(&scene, Format::Deck);
    }
    let outside = Scene::parse("deck.inp", &format!("{HINGE}*CLOAD\n1, 1, 2.\n")).unwrap_err();
    assert_eq!(outside.code(), Code::HistoryOutsideStep);
    let lost = "*NODE\n77, x, 2.\n*INITIAL CONDITIONS, TYPE=VELOCITY\n77, 1, 1.\n\
                *STEP\n*STATIC\n*CLOAD\n77, 1, 2.\n*BOUNDARY\n77, 1, 1\n1, 1, 6\n*END STEP\n";
    let scene = read(&format!("{HINGE}{lost}"));
    assert_eq!(scene.steps[0].boundaries.len(), 1);
    assert_eq!(scene.skipped.parameters["conditions on nodes that cannot be read"].count, 3);
    for format in [Format::Deck, Format::Toml, Format::Json] {
        assert_eq!(read_back(&scene, format).steps[0].boundaries.len(), 1);
    }
}

/// Zeros fill the places of components that can have no reference, and a table that falls through zero is told.
#[test]
fn references_and_tables_are_read_as_they_are_meant() {
    let axial = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=H\n1, 1, 2\n*CONNECTOR SECTION, ELSET=H, BEHAVIOR=B\n\
                 AXIAL\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR CONSTITUTIVE REFERENCE\nITS NUMBERS\n\
                 *CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\nITS TABLE";
    let told = |reference: &str, table: &str| {
        let scene = read(&axial.replace("ITS NUMBERS", reference).replace("ITS TABLE", table));
        let (model, broken) = Model::examine(&scene);
        let codes = broken.iter().chain(&model.warnings).map(pintle_scene::Diagnostic::code);
        codes.collect::<Vec<_>>()
    };
    let rises = "-10., -1.\n0., 0.\n10., 1.\n";
    assert_eq!(told("0.9, 0., 0., 0., 0., 0.", rises), []);
    assert_eq!(told("0.9, 0., 0., 30., 0., 0.", rises), [Code::ReferenceNotAvailable]);
    assert_eq!(told("0.9", "10., -1.\n0., 0.\n-10., 1.\n"), [Code::ModelNegativeStiffness]);
    assert_eq!(told("0.9", "-5., -1.\n10., 1.\n0., 2.\n0., 3.\n"), [], "it softens");
}

#[test]
fn a_deck_without_nodes_converts_to_files_that_read_back() {
    for text in ["*HEADING\n", "*MATERIAL, NAME=STEEL\n*ELASTIC\n210000., 0.3\n", "*STEP\n*END STEP\n"] {
        let scene = read(text);
        for format in [Format::Deck, Format::Toml, Format::Json] {
            let back = read_back(&scene, format);
            assert_eq!((back.nodes.len(), back.steps.len()), (0, scene.steps.len()), "{text} as {format:?}");
        }
    }
}

#[test]
fn columns_are_in_any_case_and_forces_in_any_order_with_gaps() {
    let scene = read(&HINGE.replace("101, 1, 2", "101, 1, 2\n102, 2, 1"));
    let upper = StateFile::parse_csv("s.csv", "STATE,Time,NODE,U1,uR3\n0,0,2,0.5,0.25\n", &scene).unwrap();
    let lower = StateFile::parse_csv("s.csv", "state,time,node,u1,ur3\n0,0,2,0.5,0.25\n", &scene).unwrap();
    assert_eq!(upper.states, lower.states);
    let head = "State,Element,F1,f2,F3,m1,M2,m3\n";
    let rows = |rows: &[(u64, u64, &str)]| {
        let lines = rows.iter().map(|(state, element, f1)| match *f1 {
            "" => format!("{state},{element},,,,,,\n"),
            f1 => format!("{state},{element},{f1},0,0,0,0,0\n"),
        });
        let text = head.to_owned() + &lines.collect::<String>();
        let mut states = vec![State::default(), State::default(), State::default()];
        let file = ForceFile::parse_csv("f.csv", &text, &scene, ForceSign::Internal);
        file.unwrap_or_else(|error| panic!("{text}\n{}", error.render(100, false)))
            .attach(&mut states, 0)
            .unwrap();
        let of = |state: &State| -> BTreeMap<String, Option<f64>> {
            state.forces.iter().map(|(label, forces)| (label.to_string(), forces.total[0])).collect()
        };
        states.iter().map(of).collect::<Vec<_>>()
    };
    let by_state = rows(&[(0, 101, "1"), (0, 102, "2"), (2, 101, "3"), (2, 102, "4")]);
    let by_element =
        rows(&[(2, 101, "3"), (0, 101, "1"), (1, 101, ""), (0, 102, "2"), (1, 102, ""), (2, 102, "4")]);
    assert_eq!(by_state, by_element);
    assert_eq!(by_state.iter().map(BTreeMap::len).collect::<Vec<_>>(), [2, 0, 2]);
    // What is not given is not zero: a blank cell, a column that is not there, null.
    let blank = ("f.csv", "state,element,F1,m3,f2\n0,101,2.5,,\n");
    let absent = ("f.csv", "f1,element\n2.5,101\n");
    let null = (
        "f.json",
        "{\"schema\": \"pintle-forces/1\", \"states\": [{\"forces\": {\"101\": {\"m3\": null, \"f1\": 2.5}}}]}",
    );
    let model = Model::compile(&scene).unwrap();
    for (name, text) in [blank, absent, null] {
        let mut states = vec![State::default()];
        let parse = if name == "f.csv" { ForceFile::parse_csv } else { ForceFile::parse_json };
        parse(name, text, &scene, ForceSign::Internal).unwrap().attach(&mut states, 0).unwrap();
        model.check_forces(&states, 0, name).unwrap();
        let given = &states[0].forces[&Label::from(101)];
        assert_eq!(given.total, [Some(2.5), None, None, None, None, None], "{text}");
    }
}

/// Files of the old Macintosh end lines with CR alone: blank lines count, and an error shows the line that it names.
#[test]
fn lines_that_end_with_cr_are_counted_and_shown() {
    let text = format!("** a\n\n\n{HINGE}\n*CONNECTOR MOTION\nE, 9, 1.\n");
    let lines: Vec<&str> = text.lines().collect();
    let line = lines.iter().position(|line| *line == "E, 9, 1.").unwrap() + 1;
    for end in ["\n", "\r\n", "\r"] {
        let written = text.replace('\n', end);
        let error = Scene::parse("deck.inp", &written).expect_err("a component that is none");
        assert_eq!(error.span().line() as usize, line, "{end:?}: {error}");
        let folder = crate::commands::cli::folder("cr");
        let deck = folder.join("deck.inp");
        std::fs::write(&deck, &written).unwrap();
        let shown = std::process::Command::new(env!("CARGO_BIN_EXE_pintle")).arg("eval").arg(&deck).output();
        let shown = String::from_utf8(shown.unwrap().stderr).unwrap();
        assert!(
            shown.contains(&format!("deck.inp:{line}")) && shown.contains("E, 9, 1."),
            "{end:?}: {shown}"
        );
        assert!(
            shown.contains("│ *CONNECTOR MOTION\n") && shown.contains("│ E, 9, 1.\n"),
            "{end:?}: {shown}"
        );
    }
}

/// Gaps in the forces of a constraint: each component that lacks says of each output that it is not known.
#[test]
fn gaps_in_forces_of_a_constraint_are_named() {
    let folder = crate::commands::cli::folder("gaps-of-mpc");
    let (deck, forces) = (folder.join("deck.inp"), folder.join("forces.csv"));
    std::fs::write(&deck, "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*MPC\nBEAM, 1, 2\n").unwrap();
    std::fs::write(&forces, "element,f1,f2,f3,m1,m2,m3\n1-2,1.5,,2.,0.5,,0.\n").unwrap();
    let flags = |outputs: &str| {
        let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_pintle"));
        run.arg("eval").arg(&deck).arg("--forces").arg(&forces);
        let output = run.args(["--outputs", outputs, "--format", "json"]).output().unwrap();
        let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        let state = &document["scenes"][0]["states"][0];
        let found = state["mpcs"][0]["flags"].to_string();
        ["f2", "m2", "f1"].map(|k| found.matches(&format!("\"component\":\"{k}\"")).count())
    };
    assert_eq!(flags("NF"), [1, 1, 0]);
    assert_eq!(flags("NF,CU"), [1, 1, 0]);
}

/// Gaps in the forces of a connector: what is given is used, and a sum of what is not given is not known.
#[test]
fn forces_with_gaps_are_known_as_far_as_they_are_given() {
    let folder = crate::commands::cli::folder("gaps");
    let (deck, forces) = (folder.join("deck.inp"), folder.join("forces.csv"));
    std::fs::write(&deck, HINGE).unwrap();
    std::fs::write(&forces, "element,f1,f2\n101,2.5,\n").unwrap();
    let mut run = std::process::Command::new(env!("CARGO_BIN_EXE_pintle"));
    run.arg("eval").arg(&deck).arg("--forces").arg(&forces);
    let output = run.args(["--outputs", "CTF,NF", "--format", "json"]).output().unwrap();
    let document: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let connector = &document["scenes"][0]["states"][0]["connectors"][0];
    assert_eq!(connector["components"]["u1"]["CTF"], 2.5);
    assert!(connector["components"]["u2"].get("CTF").is_none_or(serde_json::Value::is_null), "{connector}");
    assert!(connector.get("nodal_forces").is_none(), "{connector}");
    assert!(connector["flags"].to_string().contains("not-known"), "{connector}");
}

/// Copies of a set without nodes are none, however many are asked for.
#[test]
fn copies_of_nothing_are_nothing() {
    let deck = "*NODE\n1, 0., 0., 0.\n*NSET, NSET=E\n5\n\
                *NCOPY, CHANGE NUMBER=1, OLD SET=E, MULTIPLE=9000000000000000000, SHIFT\n0., 0., 0.\n\n";
    let scene = Scene::parse("copies.inp", deck);
    assert!(scene.is_ok_and(|scene| scene.nodes.len() == 1));
}

/// Lines that bear on no connector, each in a deck with a hinge: read, and the hinge is what it was.
#[test]
fn what_others_write_refuses_nothing() {
    let plain = read(HINGE);
    let ends = |scene: &Scene| -> Vec<_> {
        scene.connectors.iter().map(|(label, element)| (*label, element.a, element.b)).collect()
    };
    let step = |lines: &str| format!("*STEP\n*STATIC\n0.1, 1.\n{lines}*END STEP\n");
    let solid = "*NODE\n11, 5., 0., 0.\n12, 6., 0., 0.\n";
    let decks = [
        "*NSET, NSET=TIP\n2,\n*STEP\n*STATIC, RIKS\n0.1, 1., 1e-5, 0.5, 2., TIP, 2, -0.3\n*END STEP\n".to_string(),
        "*STEP\n*STATIC, RIKS\n0.1, 1., 1e-5, 0.5, 2., ASSEMBLY.TIP, 2, -0.3\n*END STEP\n".to_string(),
        step("*DLOAD\nE, GRAV, 9.81, 0., -1.\n"),
        step("*DLOAD\nE, GRAV, 9.81, , , -1.\n"),
        step("*NSET, NSET=IN\n1, 2\n*ELSET, ELSET=OUT\n101,\n*NODE OUTPUT, NSET=IN\nU,\n"),
        format!("{solid}*NODE\n12, 6.5, 0., 0.\n"),
        "*CONNECTOR SECTION, ELSET=SPOTS\nBEAM\n*FASTENER, INTERACTION NAME=F, ELSET=SPOTS\n\nS1, S2\n".to_string(),
        "*STEP, PERTURBATION\n*STEADY STATE DYNAMICS, DIRECT\n10., 100., 20\n*BOUNDARY, IMAGINARY\n2, 6, 6, 0.05\n*END STEP\n"
            .to_string(),
        "*ELEMENT, TYPE=ITSUNI, ELSET=ITS\n901, 1, 2\n*ITS, ELSET=ITS\n0.5, 0.1\n1., 0., 0.\n*DASHPOT\n1,\n10.\n\
         *FRICTION\n0.3,\n*SPRING, NONLINEAR\n1,\n-1., -0.1\n1., 0.1\n"
            .to_string(),
        format!("{solid}*ELEMENT, TYPE=Z101, FILE=sub1, ELSET=SUB\n802, 11, 12\n"),
        format!("{solid}{}", step("*CLOAD\n11, 1\n12, 2,\n")),
        format!("{solid}*INITIAL CONDITIONS, TYPE=VELOCITY\n11, 1,\n"),
        format!("{solid}*IMPERFECTION\n11, 0.1, 0., 0.\n"),
    ];
    for deck in &decks {
        let text = format!("{HINGE}{deck}");
        let scene = Scene::parse("deck.inp", &text)
            .unwrap_or_else(|error| panic!("{text}\n{}", error.render(100, false)));
        assert_eq!(ends(&scene), ends(&plain), "{deck}");
        assert!(scene.warnings.is_empty(), "{deck}: {:?}", scene.warnings);
    }
    // What bears on the hinge is said, or refused.
    let told = read(&format!("{HINGE}*IMPERFECTION\n2, 0.1, 0., 0.\n"));
    assert_eq!(
        told.warnings.iter().map(pintle_scene::Diagnostic::code).collect::<Vec<_>>(),
        [Code::NotFollowed]
    );
    let twice = Scene::parse("deck.inp", &format!("{HINGE}*NODE\n2, 9., 0., 0.\n")).unwrap_err();
    assert_eq!(twice.code(), Code::DuplicateNode);
}

/// Of the model of another deck nothing is here: what acts on it is counted, and a connector that needs it says where it is.
#[test]
fn what_acts_on_another_deck_is_counted() {
    for start in ["*RESTART, READ, STEP=1\n", "*IMPORT, STATE=YES\nOLD\n"] {
        let steps = "*STEP\n*STATIC\n*CONNECTOR LOAD\nWIRE, 4, 0.3\n*CONNECTOR MOTION\n77, 1, 0.1\n*BOUNDARY\n1, 1\nOLD, 1, 3\n\
                     *NODE OUTPUT, NSET=OLD\nU,\n*END STEP\n";
        let scene = read(&format!("{start}{HINGE}{steps}"));
        let what = "what acts on the model of another deck";
        assert_eq!(scene.skipped.parameters[what].count, 4, "{start}");
        assert_eq!((scene.steps[0].boundaries.len(), scene.connectors.len()), (1, 1), "{start}");
    }
    let deck = "*ASSEMBLY, NAME=A\n*INSTANCE, LIBRARY=Job-1, INSTANCE=Part-1-1\n*IMPORT, STATE=YES\n*END INSTANCE\n*NODE\n1, 0., 0., 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=W\n1, 1, Part-1-1.4\n*CONNECTOR SECTION, ELSET=W\nBEAM,\n*END ASSEMBLY\n";
    let error = Scene::parse("deck.inp", deck).unwrap_err();
    let told = error.render(100, false);
    assert!(error.code() == Code::UnknownNode && told.contains("the model is in another deck"), "{told}");
}

/// A rigid body keeps the nodes of elements that are not read, in every format.
#[test]
fn a_rigid_body_of_elements_that_are_not_read_is_kept() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n8, 0., 0., 2.\n9, 0.5, 0.5, 0.\n\
                *ELEMENT, TYPE=R3D4, ELSET=RR\n70, 1, 2, 3, 4\n*ELEMENT, TYPE=CONN3D2, ELSET=LK\n191, 2, 8\n*CONNECTOR SECTION, ELSET=LK\n\
                BEAM\n*RIGID BODY, ELSET=RR, REF NODE=9\n*BOUNDARY\n9, 1, 6\n";
    let scene = read(deck);
    assert_eq!(scene.rigid_bodies[0].others.len(), 1);
    for format in [Format::Deck, Format::Toml, Format::Json] {
        let back = read_back(&scene, format);
        let set = back.rigid_bodies[0].tie_set.as_ref().map(|set| back.node_sets[&set.value].labels.clone());
        let kept = set.unwrap_or_default().len() + back.rigid_bodies[0].others.len();
        assert_eq!(kept, 1, "{format:?}");
    }
}

/// Keywords written by their beginning say what they say whole; one that could be several, or is another, is named, and makes nothing certain.
#[test]
fn keywords_may_be_shortened_to_any_unambiguous_beginning() {
    let whole = "*HEADING\nbars\n*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
                 *ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nAXIAL\n\
                 *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1\n10.,\n*RIGID BODY, REF NODE=2, PIN NSET=P\n\
                 *EQUATION\n2\n2, 2, 1., 3, 2, -1.\n*AMPLITUDE, NAME=A\n0., 0., 1., 1.\n*NSET, NSET=P\n3\n*BOUNDARY\n1, 1, 3\n";
    let mut short = whole.to_owned();
    for (name, by) in [
        ("HEADING", "HEAD"),
        ("ELEMENT", "ELEM"),
        ("ORIENTATION", "orie"),
        ("CONNECTOR SECTION", "CONNECTOR SECT"),
        ("CONNECTOR BEHAVIOR", "ConnectorBeh"),
        ("CONNECTOR ELASTICITY", "CONNECTOR ELAS"),
        ("RIGID BODY", "RIGID B"),
        ("EQUATION", "EQUA"),
        ("AMPLITUDE", "AMPL"),
        ("BOUNDARY", "BOUN"),
    ] {
        short = short.replace(&format!("*{name}"), &format!("*{by}"));
    }
    let [whole, short] = [whole, &short].map(read);
    assert!(short.warnings.is_empty(), "{:?}", short.warnings);
    assert_eq!(short.boundaries.len(), 1);
    assert_eq!(whole.write(Format::Toml).unwrap().text, short.write(Format::Toml).unwrap().text);
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nAXIAL\n";
    for (text, keyword) in [
        ("*RIGID, REF NODE=1\n", "RIGID BODY"),
        ("*COUP, REF NODE=1\n", "COUPLING"),
        ("*EQUATON\n2\n1, 1, 1., 2, 1, -1.\n", "EQUATION"),
        ("*BOUNDRY\n1, 1, 3\n", "BOUNDARY"),
        ("*KIN COUP, REF NODE=1\n2\n", "KINEMATIC COUPLING"),
        ("*EQUATION\n2\n1, 1, 1., 2, 7, -1.\n", "EQUATION"),
    ] {
        let scene = read(&format!("{nodes}{text}"));
        assert_eq!(scene.warnings.len(), 1, "{text}: {:?}", scene.warnings);
        let unread: Vec<_> = scene.skipped.constraints.iter().map(|skipped| skipped.keyword).collect();
        assert_eq!(unread, [keyword], "{text}");
    }
    // Of other physics throughout it holds nothing.
    let scene = read(&format!("{nodes}*EQUATION\n2\n1, 11, 1., 2, 11, -1.\n"));
    assert!(scene.warnings.is_empty() && scene.skipped.constraints.is_empty());
    let error =
        Scene::parse("deck.inp", &format!("{nodes}*EQUATION\n2\n1, 1, 1., 2, 33, -1.\n")).unwrap_err();
    assert!(error.message().contains("no degree of freedom 33"), "{}", error.message());
}

/// Another number of nodes than a constraint takes is told beside a node that is not known.
#[test]
fn constraints_that_are_miscounted_are_all_told() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*NSET\n1, 2\n*MPC\nBEAM, 1, 99\nTIE, 3\n";
    let error = Scene::parse("deck.inp", text).unwrap_err();
    let all: Vec<&str> =
        std::iter::once(&error).chain(error.further()).map(|error| error.message()).collect();
    assert_eq!(all.len(), 3, "{all:?}");
    assert!(all.iter().any(|message| message.contains("TIE takes 2 nodes")), "{all:?}");
}
