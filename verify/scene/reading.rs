//! How decks are read: syntax, sets, orientations, behaviours, steps; and any text without a panic.

use super::n;
use pintle_kinematics::mpc::MpcType;
use pintle_scene::{
    Affected, Basis, Code, DamageEvolutionKind, DampingKind, Dimension, End, Extrapolation, FrictionKind,
    FrictionLaw, GALLERY, HardeningDefinition, Integration, Law, MpcKind, Operation, Operator,
    PotentialFunction, PotentialOperator, Procedure, Scene, Solver, Source, Target, Triad,
};
use proptest::prelude::*;

fn read(text: &str) -> Scene {
    Scene::parse("deck.inp", text).unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)))
}

#[test]
fn syntax_is_that_of_decks() {
    let scene = read(
        "** a comment\r\n*Heading\r\n free text, with \"a quote\r\n*node , nset = All\r\n 1, 0, 0\r\n 2,1.D0,,+2.5d-1,\r\n\r\n*Element,\r\n** between\r\n type=conn3d2,\r\n elset=\"My Set, 1\"\r\n101, 1,\r\n102, , 2\r\n*Orientation, name=\"Datum csys-1\"\r\n 1., 0., 0., 0., 1., 0.\r\n*Connector  Section, elset=\"My Set, 1\"\r\nAlign, Join,\r\n\"Datum csys-1\",\r\n*ENDSTEPPING, foo\r\n1,2\r\n3\r\n",
    );
    assert_eq!(scene.heading, "free text, with \"a quote");
    assert_eq!(scene.nodes[&n(1)].coordinates, [0.0; 3]);
    assert_eq!(scene.nodes[&n(2)].coordinates, [1.0, 0.0, 0.25]);
    assert_eq!(scene.node_sets["ALL"].labels, [1, 2]);
    assert_eq!(scene.element_sets["My Set, 1"].labels, [101, 102]);
    let [first, second] = [scene.connectors[&n(101)], scene.connectors[&n(102)]];
    assert_eq!((first.a, first.b, first.dimension), (Some(n(1)), None, Dimension::Three));
    assert_eq!((second.a, second.b), (None, Some(n(2))));
    assert_eq!(scene.position(&second, End::A), Some([1.0, 0.0, 0.25]));
    assert_eq!(scene.position(&first, End::B), Some([0.0; 3]));
    let section = scene.section(&first).unwrap();
    let names: Vec<_> = section.type_names.iter().map(|name| name.value.as_str()).collect();
    assert_eq!(names, ["ALIGN", "JOIN"]);
    assert_eq!(section.orientation_a.as_ref().unwrap().value, "Datum csys-1");
    let skipped = scene.skipped.keywords["ENDSTEPPING"];
    assert_eq!((skipped.count, skipped.data_lines, skipped.first_line), (1, 2, 19));
    assert_eq!(scene.nodes[&n(2)].span.line(), 6);
}

#[test]
fn a_byte_order_mark_and_other_encodings_in_comments_do_not_matter() {
    let mut bytes = b"\xef\xbb\xbf*HEADING\n caf\xe9\n** d\xe9but\n*NODE\n1, 2.\n*FILM\n\xff\n".to_vec();
    let scene = Scene::parse_bytes("deck.inp", &bytes).unwrap();
    assert_eq!(scene.nodes[&n(1)].coordinates, [2.0, 0.0, 0.0]);
    let error = Scene::parse("deck.inp", "\u{feff}*NODE, SET=N\n*MPC\n").unwrap_err();
    assert_eq!((error.code(), error.span().start(), error.span().end()), (Code::UnknownParameter, 10, 15));
    bytes.extend_from_slice(b"*NODE\n1, 3.\n5, 9.\n*MPC\nTIE, 1, 5\n");
    let error = Scene::parse_bytes("deck.inp", &bytes).unwrap_err();
    assert_eq!((error.code(), error.line()), (Code::DuplicateNode, Some(9)));
}

#[test]
fn sets_generate_nest_and_merge() {
    let scene = read(
        "*NSET, NSET=OUTER\nINNER, 9\n*NSET, NSET=ODD, GENERATE\n1, 9, 2\n*NSET, NSET=FREE, UNSORTED\n5, 3, 5, 1\n*NODE, NSET=MADE\n1\n2\n3\n4\n5\n6\n7\n8\n9\n*NSET, NSET=INNER\n7, 2, 7\n*NSET, NSET=INNER\n4\n*NSET, NSET=ALL, GENERATE\n1, 9\n",
    );
    let labels = |name: &str| scene.node_sets[name].labels.clone();
    assert_eq!(labels("OUTER"), [2, 4, 7, 9]);
    assert_eq!(labels("ODD"), [1, 3, 5, 7, 9]);
    assert_eq!(labels("FREE"), [5, 3, 1]);
    assert_eq!(labels("MADE"), labels("ALL"));
}

/// A range takes as long as it has members, however wide it is and however often it stands there.
#[test]
fn wide_ranges_cost_what_they_contain() {
    let ranges = "1, 10000000\n".repeat(10_000);
    let scene = Scene::parse("deck.inp", &format!("*NODE\n1\n*NSET, NSET=N, GENERATE\n{ranges}")).unwrap();
    assert_eq!(scene.node_sets["N"].labels, [1]);
}

#[test]
fn sets_have_a_largest_size() {
    let nodes: String = (1..=4_000).map(|node| format!("{node}\n")).collect();
    let names = "ALL, ALL, ALL, ALL, ALL, ALL, ALL, ALL\n".repeat(320);
    let deck = format!("*NODE, NSET=ALL\n{nodes}*NSET, NSET=MANY\n{names}*MPC\n");
    let error = Scene::parse("deck.inp", &deck).unwrap_err();
    assert_eq!((error.code(), error.line()), (Code::GenerateRange, Some(4_002)));
}

#[test]
fn other_elements_are_counted_and_known_to_sets() {
    let scene = read(
        "*NODE\n1\n*ELEMENT, TYPE=C3D20R, ELSET=SOLID\n1, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15,\n16, 17, 18, 19, 20\n2, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15,\n16, 17, 18, 19, 20\n*ELEMENT, TYPE=MASS, ELSET=POINT\n7, 1\n*ELSET, ELSET=BOTH\nSOLID, POINT, 2\n*SOLID SECTION, ELSET=SOLID, MATERIAL=STEEL\n*MATERIAL, NAME=STEEL\n*ELASTIC\n2.1E5, 0.3\n*MATERIAL, NAME=IRON\n",
    );
    let both = &scene.element_sets["BOTH"];
    assert_eq!((both.labels.as_slice(), both.unmodelled), ([n(7)].as_slice(), 3));
    let solid = scene.skipped.element_types["C3D20R"];
    assert_eq!((solid.count, solid.data_lines, solid.first_line), (2, 4, 3));
    assert_eq!(scene.skipped.keywords["MATERIAL"].count, 2);
    assert_eq!(scene.skipped.keywords["ELASTIC"].data_lines, 1);
    assert!(scene.warnings.is_empty());
}

#[test]
fn the_ends_of_a_connector_stand_where_their_nodes_do() {
    let scene = read(&format!("{MESH}*ELSET, ELSET=E\n"));
    let connector = scene.connectors[&n(101)];
    assert_eq!(scene.position(&connector, End::A), Some([0.0; 3]));
    assert_eq!(scene.position(&connector, End::B), Some([1.0, 0.0, 0.0]));
}

#[test]
fn cylindrical_nodes_are_exact_at_right_angles() {
    let scene = read("*NODE, SYSTEM=C\n1, 2., 90., 3.\n2, 2., -180., 0.\n3, 1., 30., 0.\n");
    assert_eq!(scene.nodes[&n(1)].coordinates, [0.0, 2.0, 3.0]);
    assert_eq!(scene.nodes[&n(2)].coordinates, [-2.0, 0.0, 0.0]);
    let [x, y, _] = scene.nodes[&n(3)].coordinates;
    assert!((x - 0.75f64.sqrt()).abs() < 2e-16 && (y - 0.5).abs() < 2e-16);
}

fn triad(definition: &str, point: [f64; 3]) -> Triad {
    let scene = read(&format!(
        "*NODE\n1, 1., 1., 1.\n2, 1., 1., 3.\n3, 1., 4., 1.\n4, 2., 1., 1.\n*ORIENTATION, NAME=O, {definition}\n"
    ));
    let nodes = [scene.nodes[&n(1)].coordinates, scene.nodes[&n(3)].coordinates];
    scene.orientations["O"]
        .triad("O", &scene, point, &nodes)
        .unwrap_or_else(|error| panic!("{}", error.render(110, false)))
}

#[test]
fn orientations_against_hand_values() {
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let minus = |v: [f64; 3]| v.map(|part: f64| -part);
    let same = |got: Triad, wanted: Triad, what: &str| {
        for (got, wanted) in got.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((got - wanted).abs() < 3e-16, "{what}: {got} is not {wanted}");
        }
    };
    let origin = [0.0; 3];
    same(triad("SYSTEM=RECTANGULAR\n0, 0, 5, 7, 0, 3", origin), [z, x, y], "rectangular");
    same(triad("SYSTEM=RECTANGULAR\n1, 1, 2, 1, 2, 9, 1, 1, 1", origin), [z, y, minus(x)], "origin c");
    same(triad("SYSTEM=Z RECTANGULAR\n0, 2, 0, 0, 1, 1", origin), [z, x, y], "z rectangular");
    same(triad("DEFINITION=NODES\n2, 3, 1", origin), [z, y, minus(x)], "nodes");
    same(triad("SYSTEM=CYLINDRICAL\n1, 1, 0, 1, 1, 5", [1.0, 4.0, 2.0]), [y, minus(x), z], "cylindrical");
    same(
        triad("SYSTEM=CYLINDRICAL, DEFINITION=OFFSET TO NODES\n1, 2", [1.0, 0.0, 9.0]),
        [z, x, y],
        "offset to nodes",
    );
    same(triad("SYSTEM=SPHERICAL\n0, 0, 0, 0, 0, 1", [3.0, 0.0, 0.0]), [x, y, z], "spherical at the equator");
    let tilted = 0.5f64.sqrt();
    same(
        triad("SYSTEM=SPHERICAL\n0, 0, 0, 0, 0, 1", [2.0, 0.0, 2.0]),
        [[tilted, 0.0, tilted], y, [-tilted, 0.0, tilted]],
        "spherical between equator and pole",
    );
    let (sine, cosine) = (0.5, 0.75f64.sqrt());
    same(
        triad("SYSTEM=RECTANGULAR\n1, 0, 0, 0, 1, 0\n3, 30.", origin),
        [[cosine, sine, 0.0], [-sine, cosine, 0.0], z],
        "30 degrees about 3",
    );
    same(
        triad("SYSTEM=RECTANGULAR\n1, 0, 0, 0, 1, 0\n1, 90.", origin),
        [x, z, minus(y)],
        "90 degrees about 1",
    );
    same(
        triad("SYSTEM=RECTANGULAR\n1, 0, 0, 0, 1, 0\n, -90.", origin),
        [x, minus(z), y],
        "axis 1 by default",
    );
    same(
        triad("SYSTEM=RECTANGULAR\n1, 0, 0, 0, 1, 0\n2, 90.", origin),
        [minus(z), y, x],
        "90 degrees about 2",
    );
    assert_eq!(triad("SYSTEM=RECTANGULAR\n1e300, 0, 0, 0, 1e-300, 0", origin), [x, y, z]);
    let third = [2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0];
    same(
        triad("SYSTEM=RECTANGULAR\n2, 1, 2, 1, 2, -2", origin),
        [third, [1.0 / 3.0, 2.0 / 3.0, -2.0 / 3.0], [-2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0]],
        "oblique",
    );
}

proptest! {
    #[test]
    fn triads_are_right_handed_and_orthonormal(
        a in prop::array::uniform3(-1e3..1e3_f64),
        b in prop::array::uniform3(-1e3..1e3_f64),
        c in prop::array::uniform3(-1e3..1e3_f64),
        point in prop::array::uniform3(-1e3..1e3_f64),
        system in prop::sample::select(vec!["RECTANGULAR", "Z RECTANGULAR", "CYLINDRICAL", "SPHERICAL"]),
        axis in 1..=3_u8,
        angle in -720.0..720.0_f64,
    ) {
        let [a, b, c] = [a, b, c].map(|p| format!("{:?}, {:?}, {:?}", p[0], p[1], p[2]));
        let got = triad(&format!("SYSTEM={system}\n{a}, {b}, {c}\n{axis}, {angle:?}"), point);
        for i in 0..3 {
            for j in 0..3 {
                let dot: f64 = (0..3).map(|k| got[i][k] * got[j][k]).sum();
                prop_assert!((dot - if i == j { 1.0 } else { 0.0 }).abs() < 2e-15, "e{}·e{} = {dot}", i + 1, j + 1);
            }
        }
        let [e1, e2, e3] = got;
        let cross = [e1[1] * e2[2] - e1[2] * e2[1], e1[2] * e2[0] - e1[0] * e2[2], e1[0] * e2[1] - e1[1] * e2[0]];
        for k in 0..3 {
            prop_assert!((cross[k] - e3[k]).abs() < 2e-15);
        }
    }
}

const MESH: &str = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E, BEHAVIOR=B, CONTROLS=SC, ELIMINATION=YES\nBUSHING\n*CONNECTOR BEHAVIOR, NAME=B, EXTRAPOLATION=LINEAR, INTEGRATION=EXPLICIT, REGULARIZE=OFF, RTOL=0.05\n";

#[test]
fn suboptions_are_kept() {
    let scene = read(&format!(
        "{MESH}\
*CONNECTOR CONSTITUTIVE REFERENCE
1.5, , , 90.
*CONNECTOR ELASTICITY, UNSYMM
1., 2., 3., 4., 5., 6., 7., 8.
1., 2., 3., 4., 5., 6., 7., 8.
1., 2., 3., 4., 5., 6., 7., 8.
1., 2., 3., 4., 5., 6., 7., 8.
1., 2., 3., 4., 20.
*CONNECTOR ELASTICITY, COMPONENT=2, DEPENDENCIES=2
100., , 20., 0.1, 0.2
*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR, INDEPENDENT COMPONENTS=POSITION
1, 4
0., 0., 0.5
5., 1., 0.5
*CONNECTOR ELASTICITY, RIGID
5, 6
*CONNECTOR DAMPING, COMPONENT=3, TYPE=STRUCTURAL
0.02
*CONNECTOR DERIVED COMPONENT, NAME=normal
2, 3
1., 2.
*CONNECTOR DERIVED COMPONENT, NAME=NORMAL, OPERATOR=MACAULEY SUM, SIGN=NEGATIVE
1
*CONNECTOR FRICTION, CONTACT FORCE=NORMAL, STICK STIFFNESS=1.E4
, 0.5
*CONNECTOR POTENTIAL, OPERATOR=MAX, EXPONENT=1.
1
NORMAL, 2., 1., MACAULEY, 0.1, -1.
*FRICTION, EXPONENTIAL DECAY, TAUMAX=50.
0.3, 0.2, 4.
*CONNECTOR FRICTION, COMPONENT=4, CONTACT FORCE=3
*FRICTION
0.1, 0.
0.2, 1.
*CONNECTOR PLASTICITY, COMPONENT=1
*CONNECTOR HARDENING, TYPE=ISOTROPIC, DEFINITION=EXPONENTIAL LAW
10., 5., 2.
*CONNECTOR HARDENING, TYPE=KINEMATIC
10., 0.
12., 0.1
*CONNECTOR DAMAGE INITIATION, COMPONENT=1
-1.E36, 40.
*CONNECTOR DAMAGE EVOLUTION, TYPE=ENERGY, AFFECTED COMPONENTS
1, 2
0.7
*CONNECTOR UNIAXIAL BEHAVIOR, COMPONENT=6
*LOADING DATA
1., 0.1
*CONNECTOR LOCK, COMPONENT=4, LOCK=4
, 3.0
*CONNECTOR FAILURE, COMPONENT=2, RELEASE=ALL
, , -5., 5.
*CONNECTOR STOP, COMPONENT=1
, 2.
"
    ));
    let section = &scene.connector_sections[0];
    assert_eq!((section.elimination, section.controls.as_ref().unwrap().value.as_str()), (Some(true), "SC"));
    let behavior = &scene.behaviors["B"];
    assert_eq!(behavior.table.extrapolation, Some(Extrapolation::Linear));
    assert_eq!(
        (behavior.table.regularize, behavior.table.rtol, behavior.integration),
        (Some(false), Some(0.05), Some(Integration::Explicit))
    );
    assert_eq!(behavior.constitutive_reference, [Some(1.5), None, None, Some(90.0), None, None]);
    let Law::Coupled { unsymmetric: true, frequency: false, rows } = &behavior.elasticity[0].law else {
        panic!()
    };
    assert_eq!((rows[0].values.len(), rows[0].values[35], rows[0].temperature), (36, Some(4.0), Some(20.0)));
    let Law::Linear { component: 2, rows } = &behavior.elasticity[1].law else { panic!() };
    assert_eq!(
        (rows[0].temperature, rows[0].fields.as_slice()),
        (Some(20.0), [Some(0.1), Some(0.2)].as_slice())
    );
    let Law::Nonlinear { component: 1, independent: Some(independent), rows } = &behavior.elasticity[2].law
    else {
        panic!()
    };
    assert_eq!((independent.basis, independent.components.as_slice()), (Basis::Position, [1, 4].as_slice()));
    assert_eq!(rows[1].values, [Some(5.0), Some(1.0), Some(0.5)]);
    assert_eq!(behavior.elasticity[3].law, Law::Rigid { components: vec![5, 6] });
    assert_eq!(behavior.damping[0].kind, DampingKind::Structural);
    let terms = &behavior.derived_components["NORMAL"];
    assert_eq!(
        (terms.len(), terms[0].operator, terms[1].operator, terms[1].sign),
        (2, Operator::Norm, Operator::MacauleySum, -1.0)
    );
    let FrictionKind::User {
        component: None,
        potential: Some(potential),
        contact_force: Some(force),
        rows,
        ..
    } = &behavior.friction[0].kind
    else {
        panic!("{:?}", behavior.friction[0])
    };
    assert_eq!(
        (potential.operator, potential.exponent, potential.terms.len()),
        (PotentialOperator::Max, 1.0, 2)
    );
    let term = &potential.terms[1];
    assert_eq!(term.source.value, Source::Derived("NORMAL".to_owned()));
    assert_eq!(
        (term.scale, term.function, term.shift, term.sign),
        (2.0, PotentialFunction::Macauley, 0.1, -1.0)
    );
    assert_eq!(force.value, Source::Derived("NORMAL".to_owned()));
    assert_eq!(rows[0][..2], [None, Some(0.5)]);
    let coefficient = behavior.friction[0].coefficient.as_ref().unwrap();
    assert_eq!(coefficient.maximum, Some(50.0));
    assert_eq!(
        coefficient.law,
        FrictionLaw::Exponential { static_coefficient: 0.3, kinetic_coefficient: 0.2, decay: 4.0 }
    );
    let FrictionLaw::Table(rows) = &behavior.friction[1].coefficient.as_ref().unwrap().law else { panic!() };
    assert_eq!(rows[1].values, [Some(0.2), Some(1.0), None]);
    let hardening = &behavior.plasticity[0].hardening;
    assert_eq!(
        (hardening[0].definition.columns(), hardening[1].definition),
        (["F0", "Q_inf", "b"].as_slice(), HardeningDefinition::HalfCycle)
    );
    let evolution = behavior.damage[0].evolution.as_ref().unwrap();
    assert_eq!(
        (evolution.kind, evolution.affected.as_slice()),
        (DamageEvolutionKind::Energy, [1, 2].as_slice())
    );
    let lock = &behavior.locks[0];
    assert_eq!(
        (lock.locked, lock.limits[0].lower_position, lock.limits[0].upper_position),
        (Affected::Component(4), None, Some(3.0))
    );
    let failure = &behavior.failures[0];
    assert_eq!((failure.released, failure.limits[0].upper_force), (Affected::All, Some(5.0)));
    assert_eq!((behavior.stops[0].lower, behavior.stops[0].upper), (None, Some(2.0)));
    let skipped: Vec<_> = scene.skipped.keywords.keys().map(String::as_str).collect();
    assert_eq!(skipped, ["CONNECTOR UNIAXIAL BEHAVIOR", "LOADING DATA"]);
    assert_eq!(behavior.uniaxial, [6]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn friction_outside_behaviours_belongs_to_contact() {
    let scene = read(&format!("{MESH}*SURFACE INTERACTION, NAME=I\n*FRICTION, ROUGH\n"));
    assert_eq!(scene.skipped.keywords["FRICTION"].count, 1);
}

#[test]
fn constraints_take_nodes_and_sets() {
    let scene = read(&format!(
        "{MESH}*NSET, NSET=LEFT\n2, 1\n*NSET, NSET=RIGHT, UNSORTED\n3\n*MPC\nTIE, LEFT, RIGHT\nuniversal, 1, 2,\n0, 3, 2\n"
    ));
    let all: Vec<_> = scene.mpcs.iter().map(|mpc| (mpc.kind.clone(), mpc.nodes.clone())).collect();
    assert_eq!(
        all,
        [
            (MpcKind::Evaluated(MpcType::Tie), [1, 3].map(n).to_vec()),
            (MpcKind::Evaluated(MpcType::Tie), [2, 3].map(n).to_vec()),
            (MpcKind::Evaluated(MpcType::Universal), [1, 2, 3, 2].map(n).to_vec()),
        ]
    );
}

#[test]
fn steps_keep_what_acts_in_them() {
    let scene = read(&format!(
        "{MESH}*CONNECTOR MOTION\nE, 2\n*BOUNDARY\n1, PINNED\n3, 1, 10\n2, 4\n*STEP, NAME=First, NLGEOM, PERTURBATION\n what it does\n*DYNAMIC, EXPLICIT\n, 0.5\n*CONNECTOR LOAD, OP=NEW\n101, 1, 5.\n*CLOAD, FOLLOWER\n2, 10, 3.\n*DSLOAD\nS, P, 1.\n*END STEP\n*STEP\n*ANNEAL\n*END STEP\n"
    ));
    assert_eq!(scene.solver, Some(Solver::Explicit));
    assert_eq!(scene.connector_motions[0].magnitude, None);
    assert_eq!(scene.boundaries[0].degrees_of_freedom, [1, 2, 3]);
    assert_eq!(scene.boundaries[1].degrees_of_freedom, [1, 2, 3, 4, 5, 6, 10]);
    assert_eq!(scene.boundaries[2].degrees_of_freedom, [4]);
    let [first, second] = scene.steps.as_slice() else { panic!("{:?}", scene.steps) };
    assert_eq!((first.name.as_deref(), first.nlgeom, first.perturbation), (Some("FIRST"), Some(true), true));
    let Some(Procedure::Dynamic { explicit: true, times }) = &first.procedure else { panic!("{first:?}") };
    assert_eq!((times.initial, times.total), (None, Some(0.5)));
    assert_eq!(first.connector_loads[0].applied.operation, Operation::New);
    assert_eq!(first.connector_loads[0].target.value, Target::Label(n(101)));
    assert!(first.concentrated_loads[0].applied.follower);
    assert_eq!(second.procedure, Some(Procedure::Other("ANNEAL".to_owned())));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

#[test]
fn scenes_serialise() {
    for example in GALLERY {
        let scene = example.scene().unwrap();
        let json = serde_json::to_value(&scene).unwrap();
        assert_eq!(json["nodes"].as_object().unwrap().len(), scene.nodes.len());
        assert!(
            json["connectors"].as_object().unwrap().values().all(|connector| connector["section"].is_u64())
        );
    }
}

#[test]
fn files_and_texts_give_the_same() {
    let directory = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("decks");
    for example in GALLERY {
        let read = Scene::read(directory.join(format!("{}.inp", example.name))).unwrap();
        let parsed = example.scene().unwrap();
        let value = |scene: &Scene| {
            let mut value = serde_json::to_value(scene).unwrap();
            value["name"] = serde_json::Value::Null;
            value
        };
        assert_eq!(value(&read), value(&parsed));
    }
}

/// Lines that look like those of decks.
fn deck_lines() -> impl Strategy<Value = String> {
    let line = prop_oneof![
        4 => prop::sample::select(GALLERY.iter().flat_map(|example| example.deck.lines()).map(str::to_owned).collect::<Vec<_>>()),
        1 => r#"\*[A-Z ]{0,12}(, ?[A-Z]{1,8}(=[A-Z0-9."-]{0,6})?){0,3},?"#,
        1 => r#"[0-9A-Z.,"*+eEdD =-]{0,24}"#,
        1 => "\\PC{0,16}",
    ];
    prop::collection::vec(line, 0..40).prop_map(|lines| lines.join("\n"))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        if let Err(error) = Scene::parse_bytes("deck.inp", &bytes) {
            prop_assert!(!error.render(80, false).is_empty());
        }
    }

    #[test]
    fn any_lines_are_read_or_refused(text in deck_lines()) {
        if let Err(error) = Scene::parse("deck.inp", &text) {
            prop_assert!(!error.remedy().is_empty() && !error.render(80, false).is_empty());
        }
    }

    /// A gallery deck with one byte changed or one line dropped.
    #[test]
    fn damaged_decks_are_read_or_refused(which in 0..GALLERY.len(), at in any::<prop::sample::Index>(), byte in any::<u8>(), drop in any::<bool>()) {
        let deck = GALLERY[which].deck;
        let bytes = if drop {
            let at = at.index(deck.lines().count());
            deck.lines().enumerate().filter(|(index, _)| *index != at).map(|(_, line)| format!("{line}\n")).collect::<String>().into_bytes()
        } else {
            let mut bytes = deck.as_bytes().to_vec();
            let at = at.index(bytes.len());
            bytes[at] = byte;
            bytes
        };
        if let Err(error) = Scene::parse_bytes("deck.inp", &bytes) {
            prop_assert!(!error.remedy().is_empty() && !error.render(80, true).is_empty());
        }
    }
}
