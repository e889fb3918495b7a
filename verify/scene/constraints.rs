//! Constraints beside connectors and `*MPC`: what decks say, what they require in closed form, and what an assembly makes of them.

use super::n;
use pintle_assembly::analyse;
use pintle_kinematics::connector::{Request, Tally};
use pintle_kinematics::mpc::{Body, Constraint, MpcType, State as MpcState, Turning};
use pintle_kinematics::relation::{Point, Relation};
use pintle_kinematics::so3;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Vector, add, apply, apply_transposed, cross, dot, product, sub};
use pintle_model::evaluate::{Fixed, Jacobian, Model, Plan, Selection, Sequence, StepResult};
use pintle_scene::{Format, Label, NodeMotion, Rotation, Scene, State};

fn read(text: &str) -> Scene {
    Scene::parse("deck.inp", text).unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)))
}

fn model(scene: &Scene) -> Model {
    Model::compile(scene).unwrap_or_else(|error| panic!("{}", error.render(110, false)))
}

fn evaluate(scene: &Scene, state: &State) -> (Model, StepResult) {
    let model = model(scene);
    let plan = Plan::compile(&model, &Selection::All, Request::everything(1)).unwrap();
    let result = Sequence::new(&model, &plan).step(state);
    (model, result)
}

/// A frame of nodes, a beam that gives 5 and 6 rotations, and one constraint of each kind.
const ALL: &str = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 0., 1., 0.
4, 0., 0., 1.
5, 2., 0., 0.
6, 2., 1., 0.
7, 0.25, 0.25, 3.
8, 2., 0., 0.
9, 1., 1., 1.
*ELEMENT, TYPE=B31
50, 5, 6
*ELEMENT, TYPE=C3D4
51, 2, 3, 4, 9
*NSET, NSET=CLOUD
1, 2, 3
*NSET, NSET=REF
7
*NSET, NSET=PINS
3, 9
*NSET, NSET=TIES
5
*SURFACE, TYPE=NODE, NAME=TOP
CLOUD, 2.
4, 1.
*SURFACE, TYPE=NODE, NAME=ENDS
6,
9,
*SURFACE, TYPE=NODE, NAME=LEFT
8,
*SURFACE, TYPE=NODE, NAME=RIGHT
5,
*ORIENTATION, NAME=TURNED
0., 1., 0., -1., 0., 0.
*EQUATION
3
2, 1, 1., 3, 2, -2., 4, 3, 0.5
*COUPLING, CONSTRAINT NAME=MEAN, REF NODE=REF, SURFACE=TOP
*DISTRIBUTING
*COUPLING, CONSTRAINT NAME=HOLD, REF NODE=1, SURFACE=ENDS, ORIENTATION=TURNED
*KINEMATIC
1, 1
5, 6
*RIGID BODY, REF NODE=7, PIN NSET=PINS, TIE NSET=TIES
*TIE, NAME=GLUE
LEFT, RIGHT
";

fn titles(model: &Model) -> Vec<String> {
    model.relations.iter().map(|element| element.title()).collect()
}

/// The older keyword for a coupling, and CalculiX's for a rigid body, are what the newer ones are.
#[test]
fn older_keywords_are_read() {
    let nodes = ALL.split("*EQUATION").next().unwrap();
    let pairs = [
        (
            "*KINEMATIC COUPLING, REF NODE=1, ORIENTATION=TURNED\n6, 1, 1\n9, 1, 1\n6, 5, 6\n",
            "*COUPLING, CONSTRAINT NAME=A, REF NODE=1, SURFACE=ENDS, ORIENTATION=TURNED\n*KINEMATIC\n1, 1\n5, 6\n",
            2 + 2,
        ),
        (
            "*KINEMATIC COUPLING, REF NODE=1\nTIES\n",
            "*SURFACE, TYPE=NODE, NAME=IT\nTIES,\n*COUPLING, CONSTRAINT NAME=A, REF NODE=1, SURFACE=IT\n*KINEMATIC\n",
            6,
        ),
        ("*RIGID BODY, NSET=PINS, REF NODE=7\n", "*RIGID BODY, PIN NSET=PINS, REF NODE=7\n", 6),
        (
            "*ELEMENT, TYPE=DCOUP3D, ELSET=D\n50, 7\n*DISTRIBUTING COUPLING, ELSET=D\nCLOUD, 2.\n5, 0.5\n",
            "*SURFACE, TYPE=NODE, NAME=IT\nCLOUD, 2.\n5, 0.5\n*COUPLING, CONSTRAINT NAME=A, REF NODE=7, SURFACE=IT\n*DISTRIBUTING\n",
            6,
        ),
    ];
    for (older, newer, count) in pairs {
        let rows = |text: &str| {
            let scene = read(&format!("{nodes}{text}"));
            assert!(scene.skipped.constraints.is_empty(), "{text}: {:?}", scene.skipped.constraints);
            let mut rows: Vec<String> = Vec::new();
            for element in &model(&scene).relations {
                let of = element.relation.rows().into_iter();
                rows.extend(of.map(|(name, _)| format!("{} {name}", element.title())));
            }
            rows.sort();
            rows
        };
        assert_eq!(rows(older), rows(newer));
        assert_eq!(rows(older).len(), count, "{older}");
    }
}

/// Each becomes what it says, with the degrees of freedom that its nodes have; nothing of it is skipped.
#[test]
fn every_kind_is_read() {
    let scene = read(ALL);
    let model = model(&scene);
    assert_eq!(
        titles(&model),
        [
            "EQUATION 2(1)-3(2)-4(3)",
            "RIGID BODY 5-7",
            "RIGID BODY 3-7",
            "RIGID BODY 9-7",
            "DISTRIBUTING COUPLING 7",
            "KINEMATIC COUPLING 6-1",
            "KINEMATIC COUPLING 9-1",
            "TIE 8(1)-5(1)",
            "TIE 8(2)-5(2)",
            "TIE 8(3)-5(3)",
        ]
    );
    let rows = |title: &str| {
        let element = model.relations.iter().find(|element| element.title() == title).unwrap();
        element.relation.rows().into_iter().map(|(name, _)| name).collect::<Vec<_>>()
    };
    // A solid's node has no rotations, and a beam's has.
    assert_eq!(rows("KINEMATIC COUPLING 9-1"), ["δ1"]);
    assert_eq!(rows("KINEMATIC COUPLING 6-1"), ["δ1", "ρ2", "ρ3"]);
    assert_eq!(rows("RIGID BODY 3-7"), ["δ1", "δ2", "δ3"]);
    assert_eq!(rows("RIGID BODY 5-7").len(), 6);
    assert_eq!(rows("DISTRIBUTING COUPLING 7").len(), 6);
    assert!(scene.skipped.constraints.is_empty(), "{:?}", scene.skipped.constraints);
    assert_eq!(scene.skipped.keywords.len(), 0, "{:?}", scene.skipped.keywords);
}

/// Deck, TOML, JSON and back: the same scene, to the last bit of every factor.
#[test]
fn conversions_keep_constraints() {
    let scene = read(&ALL.replace("0.5", "0.30000000000000004"));
    let content = |scene: &Scene| {
        let mut content = serde_json::to_value(scene).unwrap();
        for key in ["name", "skipped"] {
            content.as_object_mut().unwrap().remove(key);
        }
        content
    };
    let want = content(&scene);
    for key in ["equations", "surfaces", "rigid_bodies", "couplings", "ties"] {
        assert!(want[key].as_array().map_or_else(|| !want[key].is_null(), |all| !all.is_empty()), "{key}");
    }
    let names = |scene: &Scene| titles(&model(scene));
    let mut last = scene.clone();
    for format in [Format::Toml, Format::Json, Format::Toml] {
        let text = last.write(format).unwrap().text;
        last = match format {
            Format::Toml => Scene::parse_toml("scene.toml", &text),
            _ => Scene::parse_json("scene.json", &text),
        }
        .unwrap_or_else(|error| panic!("{text}\n{}", error.render(110, false)));
        assert_eq!(content(&last), want, "{format:?}");
        assert_eq!(names(&last), names(&scene), "{format:?}");
    }
    let mut back = read(&last.write(Format::Deck).unwrap().text);
    // A deck says by elements which nodes rotate.
    back.rotating_nodes.clone_from(&scene.rotating_nodes);
    assert_eq!(content(&back), want);
}

/// What stands in a part is of each instance.
#[test]
fn instances_have_their_constraints() {
    let deck = "\
*PART, NAME=P
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
*NSET, NSET=S
2, 3
*SURFACE, TYPE=NODE, NAME=F
S,
*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=F
*KINEMATIC
1, 3
*EQUATION
2
2, 2, 1., 3, 2, -1.
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=L, PART=P
*END INSTANCE
*INSTANCE, NAME=R, PART=P
0., 5., 0.
*END INSTANCE
*RIGID BODY, REF NODE=L.1, PIN NSET=R.S
*END ASSEMBLY
";
    let scene = read(deck);
    let want = [
        "EQUATION L.2(2)-L.3(2)",
        "EQUATION R.2(2)-R.3(2)",
        "RIGID BODY R.2-L.1",
        "RIGID BODY R.3-L.1",
        "KINEMATIC COUPLING L.2-L.1",
        "KINEMATIC COUPLING L.3-L.1",
        "KINEMATIC COUPLING R.2-R.1",
        "KINEMATIC COUPLING R.3-R.1",
    ];
    assert_eq!(titles(&model(&scene)), want);
    let again = read(&scene.write(Format::Deck).unwrap().text);
    assert_eq!(titles(&model(&again)), want);
}

/// Elements of types that are not read give their nodes to sets, surfaces and rigid bodies. Of a rigid mesh the nodes that bear on nothing are
/// left out; a generated element has the nodes of its master, counted on.
#[test]
fn elements_that_are_not_read_give_their_nodes() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n5, 0., 0., 1.\n6, 1., 0., 1.\n7, 1., 1., 1.\n8, 0., 1., 1.\n\
        11, 0., 0., 1.\n12, 1., 0., 1.\n13, 1., 1., 1.\n14, 0., 1., 1.\n15, 0., 0., 2.\n16, 1., 0., 2.\n17, 1., 1., 2.\n18, 0., 1., 2.\n20, 5., 5., 5.\n21, 6., 5., 5.\n\
        *ELEMENT, TYPE=C3D8R, ELSET=LOW\n1, 1, 2, 3, 4, 5, 6,\n7, 8\n*ELGEN, ELSET=ALL\n1, 2, 10, 1\n*ELSET, ELSET=HIGH\n2,\n\
        *SURFACE, NAME=TOP\nLOW, S2\n*SURFACE, TYPE=ELEMENT, NAME=BOTTOM\n2, S1\n*SURFACE, NAME=ROOF\nHIGH, S2\n\
        *NSET, NSET=UP, ELSET=HIGH\n*NSET, NSET=ENDS\n15, 16\n\
        *TIE, NAME=GLUE\nBOTTOM, TOP\n*COUPLING, CONSTRAINT NAME=C, REF NODE=20, SURFACE=ROOF\n*KINEMATIC\n1, 3\n\
        *RIGID BODY, REF NODE=21, ELSET=LOW\n";
    let scene = read(deck);
    assert_eq!(scene.skipped.constraints, [], "{:?}", scene.skipped);
    assert!(!scene.skipped.keywords.contains_key("SURFACE"), "{:?}", scene.skipped);
    let numbers: Vec<u64> = scene.node_sets["UP"].labels.iter().map(|label| label.number()).collect();
    assert_eq!(numbers, [11, 12, 13, 14, 15, 16, 17, 18]);
    let found = titles(&model(&scene));
    let pairs = [[11, 5], [12, 6], [13, 7], [14, 8]];
    let ties = pairs.iter().flat_map(|[s, m]| (1..=3).map(move |dof| format!("TIE {s}({dof})-{m}({dof})")));
    let bodies = [5, 6, 7, 8].map(|node| format!("RIGID BODY {node}-21"));
    let couplings = [15, 18, 17, 16].map(|node| format!("KINEMATIC COUPLING {node}-20"));
    let want: Vec<String> = bodies.into_iter().chain(couplings).chain(ties).collect();
    assert_eq!(found, want);
    // What is written gives the same nodes.
    let again = read(&scene.write(Format::Deck).unwrap().text);
    let without = |titles: Vec<String>| {
        titles.into_iter().filter(|title| !title.starts_with("RIGID")).collect::<Vec<_>>()
    };
    assert_eq!(without(titles(&model(&again))), without(want));
}

/// A node that lies on a face of a solid moves with its shape functions. A linear motion of the nodes of the face is its own in its place, and by
/// faces of second order a quadratic one. That is along the global axes, whatever `*TRANSFORM` the nodes have.
#[test]
fn ties_hold_within_faces() {
    let high = |[x, y]: [f64; 2]| 3.0 + 0.3 * x - 0.2 * y;
    let mut compared = 0;
    for (of_type, count) in [("C3D8R", 8), ("C3D20", 20), ("C3D4", 4), ("C3D10", 10)] {
        let is_second = count == 20 || count == 10;
        let sides = if matches!(count, 4 | 10) { 3 } else { 4 };
        // A quadratic field is of the shape functions where the map of the face is affine.
        let last = if is_second { [0.3, 1.7] } else { [-0.1, 1.7] };
        let corners = [[0.0, 0.0], [2.0, 0.2], [2.3, 1.9], last];
        let middle = |i: usize, j: usize| [0, 1].map(|k| (corners[i][k] + corners[j][k]) / 2.0);
        let mut face: Vec<[f64; 2]> = corners[..sides].to_vec();
        if is_second {
            face.extend((0..sides).map(|i| middle(i, (i + 1) % sides)));
        }
        // The face is S1; the other nodes lie anywhere.
        let order: Vec<usize> = match count {
            8 => (0..4).collect(),
            20 => (0..4).chain(8..12).collect(),
            4 => (0..3).collect(),
            _ => (0..3).chain(4..7).collect(),
        };
        let mut nodes = vec![[9.0; 3]; count];
        for (place, [x, y]) in order.iter().zip(&face) {
            nodes[*place] = [*x, *y, high([*x, *y])];
        }
        let mut deck = String::from("*NODE\n");
        for (place, [x, y, z]) in nodes.iter().enumerate() {
            deck += &format!("{}, {x}, {y}, {z}\n", place + 1);
        }
        let slaves = [[1.2, 0.6], [1.3, 0.7], [1.9, 1.2]];
        for (place, [x, y]) in slaves.iter().enumerate() {
            deck += &format!("{}, {x}, {y}, {}\n", 50 + place, high([*x, *y]));
        }
        let numbers: Vec<String> = (1..=count).map(|number| number.to_string()).collect();
        deck += &format!(
            "*TRANSFORM, NSET=TURNED\n0.3, 1., -0.2, -1., 0.4, 0.1\n*NSET, NSET=TURNED\n50, 2\n\
             *ELEMENT, TYPE={of_type}, ELSET=SOLID\n1, {}\n*SURFACE, NAME=FACE\nSOLID, S1\n\
             *SURFACE, TYPE=NODE, NAME=DOTS\n50,\n51,\n52,\n*TIE, NAME=GLUE\nDOTS, FACE\n",
            numbers.join(", ").replacen("16, ", "16,\n", 1),
        );
        let scene = read(&deck);
        assert!(scene.skipped.constraints.is_empty(), "{of_type} {:?}", scene.skipped.constraints);
        assert_eq!(scene.equations.len(), 9);
        let moved = |[x, y, _]: Vector<f64>| {
            let bent = if is_second { x * y - 0.5 * y * y } else { 0.0 };
            [0.1 + 0.2 * x - y, x + 0.3 * bent, bent - 0.7 * y]
        };
        let motions = scene.nodes.iter().map(|(label, node)| {
            (*label, NodeMotion { displacement: moved(node.coordinates), ..NodeMotion::default() })
        });
        let state = State { nodes: motions.collect(), ..State::default() };
        for scene in [&scene, &read(&scene.write(Format::Deck).unwrap().text)] {
            let (model, result) = evaluate(scene, &state);
            for result in &result.relations {
                let residual = result.rows[0].residual;
                assert!(
                    residual.abs() < 1e-12,
                    "{of_type} {} {residual}",
                    model.relations[result.index].title()
                );
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 4 * 2 * 9);
    // A tie of a surface of faces to another takes a mean around each node unless it says otherwise; what lies off the face is not read.
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0.3, 0.3, 1.\n11, 0.2, 0.2, 0.\n12, 0.6, 0.2, 0.\n13, 0.2, 0.6, 0.\n14, 0.3, 0.3, -1.\n15, 0.2, 0.2, 0.01\n16, 1., 0., 0.\n\
        21, 1e6, 0., 0.\n22, 1000001., 0., 0.\n23, 1e6, 1., 0.\n24, 1e6, 0., 1.\n26, 1000000.3, 0.3, 0.\n27, 1000000.3, 0.3, 0.5\n\
        *ELEMENT, TYPE=C3D4, ELSET=C\n3, 21, 22, 23, 24\n*SURFACE, NAME=FAR\nC, S1\n\
        *ELEMENT, TYPE=C3D4, ELSET=A\n1, 1, 2, 3, 4\n*ELEMENT, TYPE=C3D4, ELSET=B\n2, 11, 12, 13, 14\n\
        *SURFACE, NAME=MASTER\nA, S1\n*SURFACE, NAME=SLAVE\nB, S1\n*SURFACE, TYPE=NODE, NAME=OFF\n15,\n";
    for (text, equations) in [
        ("*TIE, NAME=T\nSLAVE, MASTER\n", 0),
        ("*TIE, NAME=T, TYPE=SURFACE TO SURFACE\nSLAVE, MASTER\n", 0),
        ("*TIE, NAME=T, TYPE=NODE TO SURFACE\nSLAVE, MASTER\n", 9),
        ("*TIE, NAME=T\nOFF, MASTER\n", 0),
        // A node of the face, and one that is off it by less than six digits of its place, but more than is allowed.
        ("*SURFACE, TYPE=NODE, NAME=AT\n16,\n11,\n*TIE, NAME=T\nAT, MASTER\n", 6),
        ("*SURFACE, TYPE=NODE, NAME=AT\n26,\n*TIE, NAME=T\nAT, FAR\n", 3),
        ("*SURFACE, TYPE=NODE, NAME=AT\n27,\n*TIE, NAME=T\nAT, FAR\n", 0),
    ] {
        let scene = read(&format!("{nodes}{text}"));
        assert_eq!(scene.equations.len(), equations, "{text}");
        assert_eq!(scene.skipped.constraints.len(), usize::from(equations == 0), "{text}");
    }
}

/// Displacements that are tied are equal along the global axes, whatever axes the nodes have them in.
#[test]
fn ties_are_along_global_axes() {
    let scene = read(
        "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*TRANSFORM, NSET=T\n0., 1., 0., -1., 0., 0.\n*NSET, NSET=T\n2,\n\
         *SURFACE, TYPE=NODE, NAME=S\n1,\n*SURFACE, TYPE=NODE, NAME=M\n2,\n*TIE, NAME=GLUE, POSITION TOLERANCE=0.1\nS, M\n",
    );
    let alike = NodeMotion { displacement: [0.3, -0.5, 0.9], ..NodeMotion::default() };
    let nodes = [1, 2].map(|node| (Label::from(node), alike)).into();
    let (_, result) = evaluate(&scene, &State { nodes, ..State::default() });
    let residuals: Vec<f64> = result.relations.iter().map(|result| result.rows[0].residual).collect();
    assert_eq!(residuals, [0.0; 3]);
}

/// What cannot be read is named, and refuses nothing; what is wrong is an error.
#[test]
fn what_is_left_out_is_named() {
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0.3, 0.3, 0.2\n\
         *ELEMENT, TYPE=C3D8, ELSET=SOLID\n7, 1, 2, 3, 1, 2, 3, 1, 2\n";
    let surfaces = "*SURFACE, NAME=FACES\nSOLID, S1\n*SURFACE, TYPE=NODE, NAME=DOTS, INTERNAL, NOBODY KNOWS=7\n2,\n3,\n\
         *SURFACE, TYPE=NODE, NAME=APART\n4,\n";
    let left_out = [
        (
            "*ELEMENT, TYPE=C3D10, ELSET=CURVED\n9, 1, 2, 3, 4, 1, 2, 3, 4, 1, 2\n*SURFACE, NAME=SKIN\nCURVED, S1\n\
             *COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=SKIN\n*DISTRIBUTING",
            "COUPLING",
        ),
        (
            "*SURFACE, NAME=SKIN\nSOLID,\n*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=SKIN\n*KINEMATIC",
            "COUPLING",
        ),
        ("*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=DOTS\n*DISTRIBUTING\n1, 3", "COUPLING"),
        (
            "*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=DOTS\n*DISTRIBUTING, COUPLING=STRUCTURAL",
            "COUPLING",
        ),
        ("*TIE, NAME=T\nAPART, FACES", "TIE"),
        (
            "*ELEMENT, TYPE=DCOUP3D, ELSET=D\n50, 1\n*DISTRIBUTING COUPLING, ELSET=D\n2, 0.\n3, 0.",
            "DISTRIBUTING COUPLING",
        ),
        (
            "*ELEMENT, TYPE=C3D8, ELSET=TORN\n8, 1, 2, 3, SPOT, 1, 2, 3, 1\n*RIGID BODY, REF NODE=1, ELSET=TORN",
            "RIGID BODY",
        ),
        ("*RIGID BODY, NSET=N, REF NODE=1, ROT NODE=2", "RIGID BODY"),
        ("*FASTENER", "FASTENER"),
        ("*STEP\n*STATIC\n0.1, 1.\n*EQUATION, REMOVE\n2\n*END STEP", "EQUATION"),
        // An edge has no area.
        (
            "*ELEMENT, TYPE=CPS8, ELSET=FLAT\n9, 1, 2, 3, 4, 1, 2, 3, 4\n*SURFACE, NAME=SKIN\nFLAT, S1\n\
             *COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=SKIN\n*DISTRIBUTING",
            "COUPLING",
        ),
        (
            "*ELEMENT, TYPE=S8R, ELSET=FLAT\n9, 1, 2, 3, 4, 1, 2, 3, 4\n*SURFACE, NAME=SKIN\nFLAT, E2\n\
             *COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=SKIN\n*DISTRIBUTING",
            "COUPLING",
        ),
    ];
    for (text, keyword) in left_out {
        let scene = read(&format!("{nodes}{surfaces}{text}\n"));
        let found: Vec<_> = scene.skipped.constraints.iter().map(|skipped| skipped.keyword).collect();
        assert_eq!(found, [keyword], "{text}");
        assert!(model(&scene).relations.is_empty(), "{text}");
    }
    // Equations of temperatures constrain no motion.
    let other = read(&format!("{nodes}*EQUATION\n2\n2, 11, 1., 3, 11, -1.\n"));
    assert!(other.skipped.constraints.is_empty() && other.equations.is_empty());
    assert_eq!(other.skipped.parameters.len(), 1);
    let wrong = [
        ("*EQUATION\n2\n2, 1, 1.\n", "deck::missing-data"),
        ("*EQUATION\n1\n2, 1, 1., 3, 1, 1.\n", "deck::surplus-data"),
        ("*EQUATION\n2\n2, 1, 1., 9, 1, 1.\n", "deck::unknown-node"),
        ("*EQUATION\n2\n2, 0, 1., 3, 1, 1.\n", "deck::bad-degree-of-freedom"),
        ("*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=DOT\n*KINEMATIC\n", "deck::unknown-surface"),
        ("*KINEMATIC\n", "deck::misplaced-keyword"),
    ];
    for (text, code) in wrong {
        let error = Scene::parse("deck.inp", &format!("{nodes}{surfaces}{text}")).unwrap_err();
        assert_eq!(error.code().as_str(), code, "{text}: {error}");
    }
}

/// A mean over faces weighs each node by what of their areas falls to it: a rectangle gives each corner a quarter, a triangle a third. A
/// trapezium of height h and sides a, b gives the ends of a (2a + b) h / 12 each.
#[test]
fn faces_weigh_a_mean_by_their_areas() {
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 2., 0., 0.\n3, 2., 1., 0.\n4, 0., 1., 0.\n5, 5., 0., 0.\n6, 4., 1., 0.\n7, 1., 3., 0.\n\
         20, 2., 0.5, -1.\n*ELEMENT, TYPE=S4R, ELSET=SKIN\n1, 1, 2, 3, 4\n2, 2, 5, 6, 3\n*ELEMENT, TYPE=S3, ELSET=SKIN\n3, 4, 3, 7\n\
         *SURFACE, NAME=TOP\nSKIN, SPOS\n*COUPLING, CONSTRAINT NAME=C, REF NODE=20, SURFACE=TOP\n*DISTRIBUTING\n";
    let scene = read(nodes);
    let (long, short) = ((2.0 * 3.0 + 2.0) / 12.0, (2.0 * 2.0 + 3.0) / 12.0);
    let third = 2.0 / 3.0;
    let want = [
        (1, 0.5),
        (2, 0.5 + long),
        (3, 0.5 + short + third),
        (4, 0.5 + third),
        (5, long),
        (6, short),
        (7, third),
    ];
    let found = scene.coupling_nodes(&scene.couplings[0]);
    assert_eq!(found.len(), want.len());
    for (node, weight) in want {
        let (_, found) = found.iter().find(|(label, _)| *label == n(node)).unwrap();
        assert!((found - weight).abs() < 1e-15, "node {node}: {found}, not {weight}");
    }
    assert!(scene.skipped.constraints.is_empty() && !scene.skipped.keywords.contains_key("SURFACE"));
    // A face has its area once, whatever sets and sides name it.
    let twice = read(&nodes.replace("SKIN, SPOS\n", "SKIN, SPOS\nSKIN, SNEG\n1, SPOS\n"));
    assert_eq!(twice.coupling_nodes(&twice.couplings[0]), found);
    // What is written weighs the same.
    let again = read(&scene.write(Format::Deck).unwrap().text);
    assert_eq!(again.coupling_nodes(&again.couplings[0]), found);
}

const ROTATED: Vector<f64> = [0.7, -0.4, 1.1];

/// Everything turned about the origin and moved.
fn rigid(x: Vector<f64>) -> NodeMotion {
    let moved = add(apply(&exp(ROTATED), x), [3.0, -2.0, 5.0]);
    NodeMotion { displacement: sub(moved, x), rotation: Rotation::Vector(ROTATED), ..NodeMotion::default() }
}

/// What moves as one body meets every rigid body and coupling, and rows are blind to it.
#[test]
fn rigid_motion_is_met() {
    let scene = read(ALL);
    let motions = scene.nodes.iter().map(|(label, node)| (*label, rigid(node.coordinates)));
    let (model, result) = evaluate(&scene, &State { nodes: motions.collect(), ..State::default() });
    let mut compared = 0;
    for result in &result.relations {
        let element = &model.relations[result.index];
        if matches!(element.type_name, "EQUATION" | "TIE") {
            continue;
        }
        for row in &result.rows {
            assert!(row.residual.abs() < 1e-14, "{} {}", element.title(), row.residual);
            compared += 1;
        }
    }
    assert_eq!(compared, 6 + 3 + 3 + 6 + 3 + 1);
}

fn point(displacement: Vector<f64>, phi: Vector<f64>) -> Point<f64> {
    Point { displacement, rotation: so3::matrix(so3::exp_quaternion(phi)), vector: phi, ..Point::at_rest() }
}

const AXES: [Vector<f64>; 3] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];

/// What decks of others have: an instance whose name keeps its case, faces within a radius, several reference nodes, a surface that moves with
/// its reference node alone.
#[test]
fn constraints_of_other_decks() {
    let quoted = read(
        "*PART, NAME=P\n*NODE\n2, 1., 0., 0.\n*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=\"Part 1\", PART=P\n*END INSTANCE\n*NODE\n\
         1, 0., 0., 0.\n*NSET, NSET=T\n1,\n*RIGID BODY, REF NODE=\"Part 1\".2, TIE NSET=T\n*END ASSEMBLY\n",
    );
    assert_eq!(quoted.rigid_bodies[0].reference.to_string(), "\"Part 1\".2");
    let written = quoted.write(Format::Json).unwrap().text;
    let again = Scene::parse_json("deck.json", &written).unwrap();
    assert_eq!(again.rigid_bodies[0].reference, quoted.rigid_bodies[0].reference);
    let cube = |radius: &str| {
        read(&format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 1., 0.\n4, 0., 1., 0.\n5, 0., 0., 1.\n6, 1., 0., 1.\n7, 1., 1., 1.\n8, 0., 1., 1.\n\
             9, 0., 0., 1.2\n*ELEMENT, TYPE=C3D8, ELSET=E\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*SURFACE, NAME=TOP\nE, S2\n\
             *COUPLING, CONSTRAINT NAME=C, REF NODE=9, SURFACE=TOP, INFLUENCE RADIUS={radius}\n*KINEMATIC\n"
        ))
    };
    // The whole top, or a part of it: which nodes that takes is a question of its facets.
    let [whole, part] = [cube("2."), cube("0.5")];
    assert_eq!((whole.couplings.len(), whole.skipped.constraints.len()), (1, 0));
    assert_eq!((part.couplings.len(), part.skipped.constraints.len()), (0, 1));
    let several = read(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 0., 1.\n4, 1., 0., 1.\n*NSET, NSET=R\n3, 4\n*SURFACE, TYPE=NODE, NAME=S\n1,\n2,\n\
         *COUPLING, CONSTRAINT NAME=C, REF NODE=R, SURFACE=S, INFLUENCE RADIUS=1.1\n*KINEMATIC\n",
    );
    assert_eq!((several.couplings.len(), several.skipped.constraints.len()), (0, 1));
    let road = read(
        "*NODE\n3, 0., -1.\n*SURFACE, TYPE=SEGMENTS, NAME=ROAD\nSTART, -5., -1.\nLINE, 5., -1.\n\
         *RIGID BODY, ANALYTICAL SURFACE=ROAD, REF NODE=3\n",
    );
    assert!(road.skipped.constraints.is_empty() && road.skipped.keywords.contains_key("RIGID BODY"));
    let blank = read("*AMPLITUDE, NAME=A, DEFINITION=PERIODIC\n1, 6.5, 0.\n0., 1.\n*NODE\n1, 0., 0., 0.\n");
    assert_eq!(blank.amplitudes["A"].data, [Some(1.0), Some(6.5), Some(0.0), None, Some(0.0), Some(1.0)]);
}

/// All six degrees of freedom fixed are a BEAM: the same residuals and rows, along axes that M carries.
#[test]
fn a_whole_kinematic_coupling_is_a_beam() {
    let (slave, master) = ([0.3, -1.2, 0.5], [1.0, 0.2, -0.7]);
    let [s, m] = [point([0.1, 0.4, -0.2], [0.5, 1.0, -0.3]), point([-0.3, 0.2, 0.6], [0.4, 1.1, -0.2])];
    let relation = Relation::<f64>::carried(slave, master, AXES, [true; 6]);
    let rows = relation.evaluate(&[s, m], &Request::everything(1), &mut Tally::default());
    let beam = Constraint::<f64>::new(MpcType::Beam, slave, master, [[0.0; 3]; 2]);
    let body =
        |point: &Point<f64>| Body { displacement: point.displacement, rotation: point.rotation, flow: 0.0 };
    let state = MpcState { slave: body(&s), master: body(&m), ..MpcState::at_rest() };
    let start = [pintle_kinematics::connector::Turns { turns: 0.0, principal: 0.0 }; 2];
    let found =
        beam.evaluate(&state, &start, &Turning::none(), &Request::everything(1), &mut Tally::default());
    let mut compared = 0;
    for (k, row) in rows.iter().enumerate() {
        let axis = apply(&m.rotation, AXES[k % 3]);
        let along = |of: &dyn Fn(usize) -> f64| {
            let first = k - k % 3;
            dot(axis, [of(first), of(first + 1), of(first + 2)])
        };
        let residual = along(&|i| found.residual[i].unwrap());
        assert!((row.residual - residual).abs() < 4e-16, "{k}: {} {residual}", row.residual);
        for (at, (place, number)) in relation.columns().iter().enumerate() {
            let j = 7 * place + usize::from(*number) - 1;
            let mut want = along(&|i| found.jacobian[i].unwrap()[j]);
            if *place == 1 && *number > 3 {
                // The axes turn with M: e × r along them.
                let first = k - k % 3;
                let r = [0, 1, 2].map(|i| found.residual[first + i].unwrap());
                let mut e = [0.0; 3];
                e[usize::from(*number) - 4] = 1.0;
                want += dot(cross(e, axis), r);
            }
            assert!((row.gradient[at] - want).abs() < 1e-15, "{k} {place} {number}");
            compared += 1;
        }
    }
    assert_eq!(compared, 72);
}

/// One and two fixed rotations: those of a universal and of a revolute joint. Free turns cost nothing, and fixed ones their sine.
#[test]
fn free_rotations_are_free() {
    let mut compared = 0;
    for mask in 1..7_u8 {
        let fixed = [false, false, false, mask & 1 != 0, mask & 2 != 0, mask & 4 != 0];
        let relation = Relation::<f64>::carried([0.0; 3], [0.0; 3], AXES, fixed);
        let master = point([0.0; 3], [0.3, -0.8, 0.4]);
        let free: Vec<usize> = (0..3).filter(|i| !fixed[3 + i]).collect();
        let at = |turns: &[(usize, f64)]| {
            let by = turns.iter().fold(so3::matrix(so3::exp_quaternion([0.0; 3])), |by, (i, angle)| {
                product(&by, &exp(AXES[*i].map(|x| x * angle)))
            });
            let slave = Point { rotation: product(&master.rotation, &by), ..Point::at_rest() };
            relation.evaluate(&[slave, master], &Request::everything(1), &mut Tally::default())
        };
        // First about the axis of M, then about that of S.
        let turns: Vec<(usize, f64)> = free.iter().copied().zip([0.9, -0.6]).collect();
        for row in at(&turns) {
            assert!(row.residual.abs() < 2e-16, "{mask}: {}", row.residual);
            compared += 1;
        }
        for (row, i) in (0..3).filter(|i| fixed[3 + i]).enumerate() {
            let rows = at(&[(i, 0.2)]);
            for (other, got) in rows.iter().enumerate() {
                let want = if other == row { 0.2_f64.sin() } else { 0.0 };
                assert!((got.residual - want).abs() < 4e-16, "{mask} {i} {other}: {}", got.residual);
                compared += 1;
            }
            // δρ_i = e_i·(δθ_S − δθ_M) where the constraint holds.
            let rest = at(&[]);
            let axis = apply(&master.rotation, AXES[i]);
            for (at, (place, number)) in relation.columns().iter().enumerate() {
                let sign = if *place == 0 { 1.0 } else { -1.0 };
                let want = if *number > 3 { sign * axis[usize::from(*number) - 4] } else { 0.0 };
                assert!((rest[row].gradient[at] - want).abs() < 4e-16, "{mask} {i}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 78);
}

/// A mean in closed form: of two nodes, of three with weights; of a cloud that moved as a body M is carried exactly.
#[test]
fn means_in_closed_form() {
    let mean = |master: Vector<f64>, nodes: &[(f64, Vector<f64>)]| Relation::<f64>::mean(master, nodes);
    let rows = |relation: &Relation<f64>, points: &[Point<f64>]| {
        relation.evaluate(points, &Request::everything(1), &mut Tally::default())
    };
    // Two nodes on the 1-axis at ±1, M above their middle. One goes up by h: the middle by h/2, and the line turns by −atan(h/2).
    let pair = mean([0.0, 0.0, 1.0], &[(1.0, [-1.0, 0.0, 0.0]), (1.0, [1.0, 0.0, 0.0])]);
    assert_eq!(pair.rows().len(), 5);
    let (h, angle) = (0.5, -(0.25_f64.atan()));
    let lifted = [angle.sin(), 0.0, h / 2.0 + angle.cos() - 1.0];
    let points = [point(lifted, [0.0, angle, 0.0]), Point::at_rest(), point([0.0, 0.0, h], [0.0; 3])];
    let found = rows(&pair, &points);
    assert!(found.iter().all(|row| row.residual.abs() < 2e-16), "{found:?}");
    // Turned about the line as well: nobody minds, but M stays on its circle.
    let also = product(&points[0].rotation, &exp([0.4, 0.0, 0.0]));
    let swung = apply(&also, [0.0, 0.0, 1.0]);
    let about = Point {
        displacement: sub(add(swung, [0.0, 0.0, h / 2.0]), [0.0, 0.0, 1.0]),
        rotation: also,
        ..Point::at_rest()
    };
    let found = rows(&pair, &[about, points[1], points[2]]);
    assert!(found.iter().all(|row| row.residual.abs() < 2e-16), "{found:?}");
    // Three nodes with weights 1, 1, 2 at rest: the rows are those of the theory, δθ − T⁻¹ Σ ŵ r × δx.
    let places = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let triangle = mean([1.0, 1.0, 1.0], &[(1.0, places[0]), (1.0, places[1]), (2.0, places[2])]);
    // Centre (1, 1, 0); r = (−1, −1), (3, −1), (−1, 1); T = [[1, 1, 0], [1, 3, 0], [0, 0, 4]].
    let still = rows(&triangle, &[Point::at_rest(); 4]);
    let arms = [[-1.0, -1.0, 0.0], [3.0, -1.0, 0.0], [-1.0, 1.0, 0.0]];
    let inverse = [[1.5, -0.5, 0.0], [-0.5, 0.5, 0.0], [0.0, 0.0, 0.25]];
    let mut compared = 0;
    for (i, line) in inverse.iter().enumerate() {
        for (node, (arm, weight)) in arms.iter().zip([0.25, 0.25, 0.5]).enumerate() {
            for j in 0..3 {
                let mut unit = [0.0; 3];
                unit[j] = 1.0;
                let want = -weight * dot(*line, cross(*arm, unit));
                let at = triangle.columns().binary_search(&(node + 1, 1 + j as u8)).unwrap();
                assert!((still[3 + i].gradient[at] - want).abs() < 1e-15, "{i} {node} {j}");
                let slid = if i == j { -weight } else { 0.0 };
                assert!((still[i].gradient[at] - slid).abs() < 1e-15);
                compared += 2;
            }
        }
        let at = triangle.columns().binary_search(&(0, 4 + i as u8)).unwrap();
        assert!((still[3 + i].gradient[at] - 1.0).abs() < 1e-15);
        compared += 1;
    }
    assert_eq!(compared, 57);
    // Any cloud that moved as a body.
    let body = |x: Vector<f64>| {
        let NodeMotion { displacement, .. } = rigid(x);
        point(displacement, ROTATED)
    };
    let all = [body([1.0, 1.0, 1.0]), body(places[0]), body(places[1]), body(places[2])];
    assert!(rows(&triangle, &all).iter().all(|row| row.residual.abs() < 4e-15));
}

/// The row of an equation is its coefficients, along the axes of a node that has some; rotations beyond half a turn keep their turns.
#[test]
fn the_row_of_an_equation_is_its_coefficients() {
    let deck = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
3, 2., 0., 0.
*NSET, NSET=T
2
*TRANSFORM, NSET=T
0., 1., 0., -1., 0., 0.
*EQUATION
3
1, 3, 2., 2, 1, -3., 3, 6, 0.5
*BOUNDARY
T, 3
";
    let scene = read(deck);
    let nodes = [
        (n(1), NodeMotion { displacement: [5.0, 5.0, 1.5], ..NodeMotion::default() }),
        (n(2), NodeMotion { displacement: [7.0, 0.25, 7.0], ..NodeMotion::default() }),
        (n(3), NodeMotion { rotation: Rotation::Vector([0.0, 0.0, 9.0]), ..NodeMotion::default() }),
    ];
    let state = State { nodes: nodes.into(), ..State::default() };
    let (model, result) = evaluate(&scene, &state);
    // The local 1-axis of node 2 is the global 2-axis.
    assert_eq!(result.relations[0].rows[0].residual, 2.0 * 1.5 - 3.0 * 0.25 + 0.5 * 9.0);
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::of(&scene).unwrap());
    let mut values = Vec::new();
    let care = Sequence::new(&model, &plan).assemble(&state, &jacobian, &mut values).unwrap();
    let names: Vec<_> = jacobian
        .row(0)
        .iter()
        .map(|at| jacobian.freedoms()[*at as usize])
        .map(|f| (f.node, f.number))
        .collect();
    assert_eq!(names, [(n(1), 3), (n(2), 1), (n(3), 6)]);
    assert_eq!(values, [2.0, -3.0, 0.5]);
    // The state violates it.
    let flags: Vec<&str> = care.iter().map(|(_, flag)| flag.name()).collect();
    assert_eq!(flags, ["off-constraint"]);
    assert_eq!(jacobian.equations()[0].title(&model), "EQUATION 1(3)-2(1)-3(6) g");
}

/// Redundancy, mobility and over-constraint are those of the model.
#[test]
fn assemblies_count_them() {
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n*NSET, NSET=ALL\n2, 3, 4\n\
                 *SURFACE, TYPE=NODE, NAME=S\nALL,\n";
    let rank = |text: &str| {
        let scene = read(&format!("{nodes}{text}"));
        let found = analyse(&scene, &model(&scene), &[], 1).unwrap();
        assert!(found.unread.is_empty(), "{text}");
        let position = found.positions.first().unwrap();
        (found.degrees_of_freedom, found.constraints, position.mobility, found.redundant.len())
    };
    // A body of three pinned nodes and its reference node moves as one.
    assert_eq!(rank("*RIGID BODY, REF NODE=1, PIN NSET=ALL\n"), (15, 9, Some(6), 0));
    // So does the mean, whose nodes are free.
    let mean = "*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=S\n*DISTRIBUTING\n";
    assert_eq!(rank(mean), (15, 6, Some(9), 0));
    // An equation that the body meets already is redundant: the 1-distance of nodes 3 and 4 in the first order.
    let twice = "*RIGID BODY, REF NODE=1, PIN NSET=ALL\n*COUPLING, CONSTRAINT NAME=C, REF NODE=1, SURFACE=S\n*KINEMATIC\n2, 2\n";
    assert_eq!(rank(twice), (15, 12, Some(6), 3));
    let equation = "*RIGID BODY, REF NODE=1, PIN NSET=ALL\n*EQUATION\n2\n1, 1, 1., 2, 1, -1.\n";
    assert_eq!(rank(equation), (15, 10, Some(6), 1));
}

/// A body of many nodes costs linear time, and so does a mean of them.
#[test]
fn large_bodies_cost_linear_time() {
    let deck = |count: usize, text: &str| {
        let mut deck = String::from("*NODE\n");
        for i in 1..=count {
            let x = i as f64;
            deck += &format!("{i}, {x}, {}, {}\n", (0.1 * x).sin(), (0.1 * x).cos());
        }
        deck += &format!("{}, 0., 0., 5.\n*NSET, NSET=ALL, GENERATE\n1, {count}\n", count + 1);
        deck + "*SURFACE, TYPE=NODE, NAME=S\nALL,\n" + &text.replace('@', &(count + 1).to_string())
    };
    for text in [
        "*RIGID BODY, REF NODE=@, TIE NSET=ALL\n",
        "*COUPLING, CONSTRAINT NAME=C, REF NODE=@, SURFACE=S\n*DISTRIBUTING\n",
    ] {
        let time = |count: usize| {
            let begun = std::time::Instant::now();
            let scene = read(&deck(count, text));
            let motions = scene.nodes.iter().map(|(label, node)| (*label, rigid(node.coordinates)));
            let state = State { nodes: motions.collect(), ..State::default() };
            let (_, result) = evaluate(&scene, &state);
            let worst = result.relations.iter().flat_map(|result| &result.rows);
            let worst = worst.map(|row| row.residual.abs()).fold(0.0_f64, f64::max);
            // Roundings of the coordinates, which grow with the length of the row.
            assert!(worst < 1e-15 * count as f64, "{worst}");
            begun.elapsed().as_secs_f64()
        };
        let (short, long) = (time(1_000), time(10_000));
        assert!(long < 60.0 * short.max(0.01), "{text}: {short} s of 1,000 nodes, {long} s of 10,000");
    }
}

/// Where a cloud is bent M takes the best fit: no other turn brings the cloud nearer.
#[test]
fn the_mean_rotation_is_the_best_fit() {
    let places = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.5, 3.0]];
    let weights = [1.0, 1.0, 2.0, 0.5];
    let nodes: Vec<(f64, Vector<f64>)> = weights.into_iter().zip(places).collect();
    let relation = Relation::<f64>::mean([0.0; 3], &nodes);
    let moved = [[0.3, 0.1, -0.4], [-0.2, 0.9, 0.5], [0.1, -0.3, 0.8], [0.7, 0.2, -0.6]];
    let mut points = vec![Point::at_rest()];
    points.extend(moved.map(|u| point(u, [0.0; 3])));
    // Newton with the relation's own rows, on the rotation of M.
    for _ in 0..30 {
        let rows = relation.evaluate(&points, &Request::everything(1), &mut Tally::default());
        let matrix = [3, 4, 5].map(|k| [rows[k].gradient[3], rows[k].gradient[4], rows[k].gradient[5]]);
        let [a, b, c] = [0, 1, 2].map(|j| [matrix[0][j], matrix[1][j], matrix[2][j]]);
        let right = [3, 4, 5].map(|k| -rows[k].residual);
        let volume = dot(a, cross(b, c));
        let step = [
            dot(right, cross(b, c)) / volume,
            dot(a, cross(right, c)) / volume,
            dot(a, cross(b, right)) / volume,
        ];
        points[0].rotation = product(&exp(step), &points[0].rotation);
    }
    let misfit = |rotation: &[Vector<f64>; 3]| {
        let sum: f64 = weights.iter().sum();
        let mean = |of: &dyn Fn(usize) -> Vector<f64>| {
            (0..4).fold([0.0; 3], |all, k| add(all, of(k).map(|x| x * weights[k] / sum)))
        };
        let (before, after) = (mean(&|k| places[k]), mean(&|k| add(places[k], moved[k])));
        (0..4)
            .map(|k| {
                let now = sub(add(places[k], moved[k]), after);
                let off = sub(apply_transposed(rotation, now), sub(places[k], before));
                weights[k] * dot(off, off)
            })
            .sum::<f64>()
    };
    let best = misfit(&points[0].rotation);
    for n in 0..26 {
        let by = [n % 3, n / 3 % 3, n / 9].map(|i| 1e-3 * (f64::from(i) - 1.0));
        if by != [0.0; 3] {
            assert!(misfit(&product(&exp(by), &points[0].rotation)) > best, "{by:?}");
        }
    }
}
