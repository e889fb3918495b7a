//! Parts, instances and assemblies, includes, generated meshes, and the axes of nodes.

use super::n;
use pintle_kinematics::connector::Request;
use pintle_model::evaluate::{Model, Plan, Selection, Sequence};
use pintle_scene::{Code, Files, Label, NoFiles, NodeMotion, Rotation, Scene, State, Triad};
use std::collections::BTreeMap;

fn read(text: &str) -> Scene {
    Scene::parse("deck.inp", text).unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)))
}

/// All that a scene has, but for the number of its comments.
fn content(scene: &Scene) -> serde_json::Value {
    let mut content = serde_json::to_value(scene).unwrap();
    content["skipped"].as_object_mut().unwrap().remove("comments");
    content
}

fn label(text: &str) -> Label {
    text.parse().unwrap()
}

/// Everything that the connectors of a scene give, in the order of their elements, after two states.
fn results(scene: &Scene, node: &dyn Fn(u64) -> Label) -> String {
    let model = Model::compile(scene).unwrap_or_else(|error| panic!("{}", error.render(110, false)));
    let plan = Plan::compile(&model, &Selection::All, Request::everything(2)).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    let motion = |shift: f64| NodeMotion {
        displacement: [0.1 * shift, -0.3, 0.2],
        rotation: Rotation::Vector([0.4, -0.2 * shift, 0.7]),
        velocity: [1.0, 2.0, shift],
        angular_velocity: [0.3, shift, -0.1],
        ..NodeMotion::default()
    };
    let mut text = String::new();
    for step in 1..=2_u8 {
        let step = f64::from(step);
        let nodes = [(node(1), motion(step)), (node(4), motion(-0.7 * step))];
        let result = walk.step(&State { nodes: nodes.into(), ..State::default() });
        for (place, connector) in result.connectors.iter().enumerate() {
            text += &format!("{place}: {:?}\n", connector.evaluation);
        }
        for joint in &result.mpcs {
            text += &format!("{:?}\n", joint.evaluation);
        }
    }
    text
}

/// Two links and a joint between them: once flat, once as two instances of one part.
const FLAT: &str = "\
*NODE
1, 1., 2., 3.
2, 2., 2., 3.
3, 1.5, -2., 0.25
4, 1.5, -1., 0.25
9, 8., 8., 8.
*ELEMENT, TYPE=CONN3D2, ELSET=A
1, 1, 2
*ELEMENT, TYPE=CONN3D2, ELSET=B
2, 3, 4
*ELEMENT, TYPE=CONN3D2, ELSET=J
3, 2, 4
4, 9, 1
*ORIENTATION, NAME=OA
0., 1., 0., 0., 0., 1.
*ORIENTATION, NAME=OB
-1., 0., 0., 0., 0., 1.
*ORIENTATION, NAME=CA, SYSTEM=CYLINDRICAL
1., 1., 3., 1., 1., 5.
*ORIENTATION, NAME=CB, SYSTEM=CYLINDRICAL
2.5, -2., 0.25, 2.5, -2., 2.25
*ORIENTATION, NAME=OJ, DEFINITION=NODES
2, 3, 1
*CONNECTOR SECTION, ELSET=A
CARTESIAN, CARDAN
OA, CA
*CONNECTOR SECTION, ELSET=B
CARTESIAN, CARDAN
OB, CB
*CONNECTOR SECTION, ELSET=J
BUSHING
OJ,
*MPC
REVOLUTE, 1, 4, 2
";

/// The part is the first link moved back to the origin; its second instance is turned by 90 degrees about z.
const ASSEMBLED: &str = "\
*Heading
*Part, name=Link
*Node
      1,           0.,           0.,           0.
      2,           1.,           0.,           0.
*Element, type=CONN3D2, elset=Wire
1, 1, 2
*Nset, nset=Ends, generate
 1, 2, 1
*Orientation, name=Axes
0., 1., 0., 0., 0., 1.
*Orientation, name=\"Round it\", system=CYLINDRICAL
0., -1., 0., 0., -1., 2.
*Connector Section, elset=Wire
Cartesian, Cardan
Axes, \"Round it\"
*Material, name=Steel
*End Part
**
*Assembly, name=Assembly
**
*Instance, name=Link-1, part=Link
1., 2., 3.
*End Instance
**
*Instance, name=\"Second link\", part=Link
          1.5,           -2.,           0.25
          1.5,           -2.,           0.25, 1.5, -2., 1.25, 90.
*End Instance
*Node
      9,           8.,           8.,           8.
*Nset, nset=Tips, internal, instance=Link-1
 2,
*Nset, nset=Tips, internal, instance=\"Second link\"
 2,
*Nset, nset=Everything
 Tips, Link-1.Ends, \"Second link\".Ends, 9
*Element, type=CONN3D2, elset=J
3, Link-1.2, \"Second link\".2
4, 9, Link-1.1
*Orientation, name=OJ, definition=NODES
Link-1.2, \"Second link\".1, Link-1.1
*Connector Section, elset=J
Bushing,
OJ,
*MPC
Revolute, Link-1.1, \"Second link.2\", Link-1.2
*End Assembly
";

#[test]
fn a_deck_of_parts_is_the_flat_deck() {
    let (flat, assembled) = (read(FLAT), read(ASSEMBLED));
    let place = |number: u64| match number {
        1 | 2 => label(&format!("Link-1.{number}")),
        3 | 4 => label(&format!("\"Second link\".{}", number - 2)),
        _ => n(number),
    };
    for number in [1, 2, 3, 4, 9] {
        let (flat, own) = (flat.nodes[&n(number)], assembled.nodes[&place(number)]);
        assert_eq!(flat.coordinates, own.coordinates, "node {number}");
    }
    assert_eq!(assembled.nodes.len(), 5);
    let flat = results(&flat, &n);
    assert_eq!(flat.lines().count(), 2 * 5);
    assert_eq!(flat, results(&assembled, &place));
}

#[test]
fn names_of_instances_are_scoped() {
    let scene = read(ASSEMBLED);
    let members =
        |name: &str| scene.node_sets[name].labels.iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(members("TIPS"), ["LINK-1.2", "\"Second link\".2"]);
    assert_eq!(members("LINK-1.ENDS"), ["LINK-1.1", "LINK-1.2"]);
    assert_eq!(members("EVERYTHING").first().map(String::as_str), Some("9"));
    assert_eq!(members("EVERYTHING").len(), 5);
    let sections: Vec<_> =
        scene.connector_sections.iter().map(|section| section.element_set.value.as_str()).collect();
    assert_eq!(sections, ["LINK-1.WIRE", "Second link.WIRE", "J"]);
    let skipped = scene.skipped.keywords["MATERIAL"];
    assert_eq!((skipped.count, skipped.first_line), (1, 17));
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

/// The translation comes first: the rotation turns the node that has been moved, about an axis that has not.
#[test]
fn an_instance_is_moved_and_then_turned() {
    let at = |lines: &str| {
        let text = format!(
            "*PART, NAME=P\n*NODE\n1, 1., 2., 3.\n*END PART\n*ASSEMBLY\n*INSTANCE, NAME=I, PART=P\n{lines}*END INSTANCE\n*END ASSEMBLY\n"
        );
        read(&text).nodes[&label("I.1")].coordinates
    };
    assert_eq!(at(""), [1.0, 2.0, 3.0]);
    assert_eq!(at("10., , 5.\n"), [11.0, 2.0, 8.0]);
    assert_eq!(at("10., 0., 0.\n0., 0., 0., 0., 0., 1., 90.\n"), [-2.0, 11.0, 3.0]);
    assert_eq!(at("0., 0., 0.\n1., 0., 0., 1., 0., 7., -90.\n"), [3.0, 0.0, 3.0]);
    assert_eq!(at("\n0., 0., 0., 0., 0., -3., 180.\n"), [-1.0, -2.0, 3.0]);
    // A third of a turn about the space diagonal exchanges the axes.
    for (got, wanted) in at("1., 0., 0.\n0., 0., 0., 2., 2., 2., 120.\n").iter().zip([3.0, 2.0, 2.0]) {
        assert!((got - wanted).abs() < 2e-15, "{got} is not {wanted}");
    }
    for (got, wanted) in at("\n0., 0., 0., 1., 0., 0., 30.\n").iter().zip([
        1.0,
        2.0 * 0.75_f64.sqrt() - 1.5,
        1.0 + 3.0 * 0.75_f64.sqrt(),
    ]) {
        assert!((got - wanted).abs() < 2e-15, "{got} is not {wanted}");
    }
}

/// Directions of a part are turned without loss where the instance stands far from the origin.
#[test]
fn orientations_keep_their_digits_far_away() {
    let scene = read(
        "*PART, NAME=P\n*NODE\n1, 1., 2., 3.\n2, 0.5, 0., 0.\n*ORIENTATION, NAME=R\n0.3, 0.4, 0., -0.4, 0.3, 0.\n*ORIENTATION, NAME=C, SYSTEM=CYLINDRICAL\n0., 0., 0., 0.3, 0.4, 0.\n*ORIENTATION, NAME=N, DEFINITION=NODES\n1, 2\n*TRANSFORM, NSET=ALL\n0.3, 0.4, 0., -0.4, 0.3, 0.\n*NSET, NSET=ALL\n1, 2\n*END PART\n*ASSEMBLY\n*INSTANCE, NAME=I, PART=P\n1.E9, 3.E9, -2.E9\n1.E9, 3.E9, -2.E9, 1.E9, 3.E9, -1.E9, 90.\n*END INSTANCE\n*END ASSEMBLY\n",
    );
    let close = |got: [f64; 3], wanted: [f64; 3], what: &str| {
        for (got, wanted) in got.iter().zip(wanted) {
            assert!((got - wanted).abs() < 4e-16, "{what}: {got} is not {wanted}");
        }
    };
    let triad = |name: &str| {
        scene.orientations[name].triad(name, &scene, scene.nodes[&label("I.1")].coordinates, &[]).unwrap()
    };
    let [e1, e2, e3] = triad("I.R");
    close(e1, [-0.8, 0.6, 0.0], "rectangular");
    close(e2, [-0.6, -0.8, 0.0], "rectangular");
    close(e3, [0.0, 0.0, 1.0], "rectangular");
    close(triad("I.C")[2], [-0.8, 0.6, 0.0], "axis of a cylinder");
    // The origin of the part, not of the assembly: (1, 2, 3) turned is (−2, 1, 3).
    let length = 14.0_f64.sqrt();
    close(triad("I.N")[0], [-2.0 / length, 1.0 / length, 3.0 / length], "by nodes");
    close(scene.nodal_axes(label("I.2")).unwrap()[0], [-0.8, 0.6, 0.0], "transform");
}

#[test]
fn an_instance_may_have_a_mesh_of_its_own() {
    let scene = read(
        "*PART, NAME=P\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I-1, PART=P\n0., 0., 5.\n*NODE\n1, 1., 0., 0.\n2, 2., 0., 0.\n*NSET, NSET=N\n1, 2\n*ELEMENT, TYPE=MASS, ELSET=M\n7, 2\n*MASS, ELSET=M\n3.\n*END INSTANCE\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n1, I-1.1, I-1.2\n*CONNECTOR SECTION, ELSET=C\nBEAM\n*END ASSEMBLY\n*BOUNDARY\nI-1.N, 1, 3\nI-1.1, 4, 6\n*STEP\n*STATIC\n*CLOAD\nI-1.2, 1, 3.\n*END STEP\n",
    );
    assert_eq!(scene.nodes[&label("I-1.2")].coordinates, [2.0, 0.0, 5.0]);
    assert_eq!(scene.masses[0].element_set.value, "I-1.M");
    assert_eq!(scene.point_elements[&label("i-1.7")].node, label("I-1.2"));
    assert_eq!(scene.connectors[&n(1)].a, Some(label("I-1.1")));
}

#[test]
fn nodes_of_element_sets() {
    let scene = read(
        "*NODE\n1\n2\n3\n4\n*ELEMENT, TYPE=MASS, ELSET=E\n1, 4\n*ELEMENT, TYPE=SPRINGA, ELSET=E\n2, 2, 4\n*NSET, NSET=N, ELSET=E\n*NSET, NSET=M, ELSET=E\n1\n",
    );
    assert_eq!(scene.node_sets["N"].labels, [2, 4]);
    assert_eq!(scene.node_sets["M"].labels, [1, 2, 4]);
}

#[test]
fn nodes_and_elements_are_generated() {
    let scene = read(
        "*NODE\n1, 0., 0., 0.\n9, 4., 8., -2.\n101, 0., 1., 0.\n109, 4., 1., 0.\n*NGEN, NSET=LINE\n1, 9, 2\n*NGEN\n109, 101, 2\n*ELEMENT, TYPE=CONN3D2, ELSET=FIRST\n1, 1, 3\n*ELGEN, ELSET=ALL\n1, 2, 4, 1, 2, 100, 10\n*ELEMENT, TYPE=MASS, ELSET=M\n51, 1\n*ELGEN, ELSET=M\n51, 5, 2\n*ELEMENT, TYPE=T3D2, ELSET=T\n61, 1, 3\n*ELGEN, ELSET=U\n61, 4, 2\n*CONNECTOR SECTION, ELSET=ALL\nBEAM\n",
    );
    assert_eq!(scene.node_sets["LINE"].labels, [1, 3, 5, 7, 9]);
    assert_eq!(scene.nodes[&n(5)].coordinates, [2.0, 4.0, -1.0]);
    assert_eq!(scene.nodes[&n(103)].coordinates, [1.0, 1.0, 0.0]);
    assert_eq!(scene.nodes.len(), 10);
    let elements: Vec<_> =
        scene.connectors.iter().map(|(label, element)| (label.number(), element.a, element.b)).collect();
    let ends = |number, a, b| (number, Some(n(a)), Some(n(b)));
    assert_eq!(elements, [ends(1, 1, 3), ends(2, 5, 7), ends(11, 101, 103), ends(12, 105, 107)]);
    assert_eq!(scene.point_elements[&n(55)].node, n(9));
    assert_eq!((scene.element_sets["T"].unmodelled, scene.element_sets["U"].unmodelled), (1, 4));
}

/// The same lines in one file and in four.
#[test]
fn included_lines_stand_where_they_are_included() {
    let deck = b"\xef\xbb\xbf*HEADING\r\n included\r\n*NODE\r\n*Include ,\r\n input = mesh/nodes.inp\r\n3, 3., 0., 0.\r\n*INCLUDE, INPUT=\"mesh/elements.inp\"\r\n*CONNECTOR SECTION, ELSET=E\r\nBEAM\r\n";
    let files = BTreeMap::from([
        ("mesh/nodes.inp".to_owned(), "** the nodes\n1, 0., 0., 0.\n*INCLUDE, INPUT=more.inp\n"),
        ("more.inp".to_owned(), "\u{feff}2, 2., 0., 0."),
        ("mesh/elements.inp".to_owned(), "*ELEMENT, TYPE=CONN3D2, ELSET=E\n1, 1, 2\n2, 2, 3\n"),
    ]);
    let split = Scene::parse_with("deck.inp", deck, &files).unwrap();
    let whole = read(
        "*HEADING\n included\n*NODE\n1, 0., 0., 0.\n2, 2., 0., 0.\n3, 3., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n1, 1, 2\n2, 2, 3\n*CONNECTOR SECTION, ELSET=E\nBEAM\n",
    );
    assert_eq!(content(&split), content(&whole));
    assert_eq!(split.files, ["deck.inp", "mesh/nodes.inp", "more.inp", "mesh/elements.inp"]);
    let span = split.nodes[&n(2)].span;
    assert_eq!((span.file(), span.line(), span.start()), (2, 1, 3));
    let with_input = Scene::parse_with("deck.inp", b"*NODE, INPUT=more.inp\n*NODE\n7\n", &files).unwrap();
    assert_eq!(with_input.nodes.keys().copied().collect::<Vec<_>>(), [2, 7]);
}

#[test]
fn faults_of_included_files_are_told_there() {
    let files = BTreeMap::from([
        ("nodes.inp".to_owned(), "1, 0., 0., 0.\n2, x, 0., 0.\n"),
        ("again.inp".to_owned(), "*NODE\n1, 1., 0., 0.\n"),
        ("a.inp".to_owned(), "*INCLUDE, INPUT=b.inp\n"),
        ("b.inp".to_owned(), "*INCLUDE, INPUT=a.inp\n"),
        ("twice.inp".to_owned(), "*FILM\n"),
    ]);
    let fails = |deck: &str| Scene::parse_with("deck.inp", deck.as_bytes(), &files).unwrap_err();
    let error = fails("*HEADING\n*NODE\n*INCLUDE, INPUT=nodes.inp\n*MPC\nTIE, 1, 2\n");
    assert_eq!((error.code(), error.file(), error.line()), (Code::MalformedNumber, "nodes.inp", Some(2)));
    let shown = error.render(110, false);
    assert!(shown.contains("nodes.inp:2:4") && shown.contains("2, x, 0., 0."), "{shown}");
    let error = fails("*NODE\n1, 2., 0., 0.\n5, 9.\n*INCLUDE, INPUT=again.inp\n*MPC\nTIE, 1, 5\n");
    assert_eq!((error.code(), error.file(), error.line()), (Code::DuplicateNode, "again.inp", Some(2)));
    assert_eq!(error.label(), "first defined on line 2 of deck.inp");
    let error = fails("*INCLUDE, INPUT=a.inp\n");
    assert_eq!((error.code(), error.file(), error.line()), (Code::IncludeCycle, "b.inp", Some(1)));
    assert!(error.message().contains("deck.inp → a.inp → b.inp → a.inp"), "{error}");
    let error = fails("*INCLUDE, INPUT=deck.inp\n");
    assert_eq!((error.code(), error.file()), (Code::IncludeCycle, "deck.inp"));
    let error = fails("*NODE\n1\n*INCLUDE, INPUT=none.inp\n");
    assert_eq!((error.code(), error.file(), error.line()), (Code::IncludeUnreadable, "deck.inp", Some(3)));
    let error = Scene::parse_with("deck.inp", b"*NODE\n1\n*INCLUDE, INPUT=none.inp\n", &NoFiles).unwrap_err();
    assert_eq!(error.code(), Code::UnsupportedKeyword);
    let many = "*INCLUDE, INPUT=twice.inp\n".repeat(10_001);
    let error = fails(&many);
    assert_eq!((error.code(), error.line()), (Code::IncludeLimit, Some(10_001)));
    let deep: BTreeMap<String, String> =
        (0..40).map(|k| (format!("{k}.inp"), format!("*INCLUDE, INPUT={}.inp\n", k + 1))).collect();
    let error = Scene::parse_with("deck.inp", b"*INCLUDE, INPUT=0.inp\n", &deep).unwrap_err();
    assert_eq!((error.code(), error.file()), (Code::IncludeLimit, "15.inp"));
}

/// Keywords that are skipped may have names in any encoding; those that are read may not.
#[test]
fn latin_1_names_of_materials_do_not_matter() {
    let scene =
        Scene::parse_bytes("deck.inp", b"*NODE\n1, 2.\n*MATERIAL, NAME=St\xe4hl\n*ELASTIC\n2.1E5, 0.3\n")
            .unwrap();
    assert_eq!(scene.skipped.keywords["MATERIAL"].count, 1);
    let error = Scene::parse_bytes("deck.inp", b"*NODE\n1, 2.\n*NSET, NSET=Tr\xe4ger\n1\n").unwrap_err();
    assert_eq!((error.code(), error.line(), error.span().start()), (Code::NotUtf8, Some(3), 26));
}

#[test]
fn a_deck_may_be_written_in_any_way() {
    let plain = read(FLAT);
    let ugly: String = FLAT
        .lines()
        .map(|line| {
            let line = line.to_ascii_lowercase();
            match line.strip_prefix('*') {
                Some(keyword) if keyword.contains(',') => {
                    let keyword = keyword.replace(", ", " ,\r\n\t ").replace('=', "\t= ");
                    format!("**** comment\r\n * {keyword} \r\n")
                }
                Some(keyword) => format!("*{keyword}\t\r\n"),
                None => format!("\t{} ,\r\n", line.replace(',', " ,\t")),
            }
        })
        .collect();
    let strange = Scene::parse("deck.inp", &format!("\u{feff}{ugly}"))
        .unwrap_or_else(|error| panic!("{}", error.render(110, false)));
    assert_eq!(content(&plain), content(&strange));
}

#[test]
fn axes_of_nodes_against_hand_values() {
    let scene = read(
        "*NODE\n1, 3., 0., 0.\n2, 0., 2., 5.\n3, 1., 0., 1.\n4\n*NSET, NSET=R\n4\n*NSET, NSET=C\n1, 2\n*NSET, NSET=S, UNSORTED\n3\n*TRANSFORM, NSET=R\n0., 0., 2., 0., 3., 1.\n*TRANSFORM, NSET=C, TYPE=C\n0., 0., 0., 0., 0., 1.\n*TRANSFORM, NSET=S, TYPE=S\n0., 0., 0., 0., 0., 1.\n",
    );
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let minus = |v: [f64; 3]| v.map(|part: f64| -part);
    let same = |number: u64, wanted: Triad| {
        let got = scene.nodal_axes(n(number)).unwrap();
        for (got, wanted) in got.iter().flatten().zip(wanted.iter().flatten()) {
            assert!((got - wanted).abs() < 3e-16, "node {number}: {got} is not {wanted}");
        }
    };
    same(1, [x, y, z]);
    same(2, [y, minus(x), z]);
    same(4, [z, y, minus(x)]);
    let slant = 0.5_f64.sqrt();
    same(3, [[slant, 0.0, slant], y, [-slant, 0.0, slant]]);
    let scene = read("*NODE\n1, 3., 0., 0.\n");
    assert_eq!(scene.nodal_axes(n(1)).unwrap(), [x, y, z]);
}

/// Paths count from the file that includes, with either kind of slash.
#[test]
fn files_on_disk_include_their_neighbours() {
    let disk = pintle_scene::Disk;
    assert_eq!(disk.name("mesh\\nodes.inp", "decks/a/deck.inp").unwrap(), "decks/a/mesh/nodes.inp");
    assert_eq!(disk.name("nodes.inp", "deck.inp").unwrap(), "nodes.inp");
}
