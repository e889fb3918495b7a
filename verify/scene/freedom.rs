//! Which degrees of freedom nodes have, and connectors that share nodes: from a deck to the columns of its rows.

use crate::laws::{Check, assert_bits};
use crate::numbers::manual::rotating;
use crate::states::{Draw, Ends, Extent, cases, types};
use pintle_kinematics::catalog::{Orientation, TABLE};
use pintle_kinematics::connector::Request;
use pintle_kinematics::node::{DOF, DOFS};
use pintle_kinematics::vector;
use pintle_kinematics::vector::Matrix;
use pintle_model::evaluate::{Model, Plan, Selection, Sequence, StepResult};
use pintle_scene::{Label, Scene, StateFile};

/// Nodes 1 to 4 of which 1 and 2 are those of connector 7, with whatever else.
fn deck(types: &str, rest: &str) -> String {
    format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0.3, 0.\n3, 0., 2., 0.\n4, 1., 2., 0.\n*NSET, NSET=FIRST\n1\n\
         *ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
         *CONNECTOR SECTION, ELSET=C\n{types}\n{rest}\n"
    )
}

fn model(text: &str) -> Model {
    let scene = Scene::parse("deck.inp", text).unwrap_or_else(|error| panic!("{}", error.render(110, false)));
    Model::compile(&scene).unwrap_or_else(|error| panic!("{}", error.render(110, false)))
}

/// Whether a and b of connector 7 have rotations.
fn rotates(text: &str) -> [bool; 2] {
    let model = model(text);
    let label = Label::from(7);
    let element = model.connectors.iter().find(|element| element.label == label).unwrap();
    let active = element.connector.active();
    let of = |at: usize| {
        assert!(active[at] == active[at + 1] && active[at] == active[at + 2], "{text}");
        active[at]
    };
    assert_eq!([of(3), of(10)], element.definition().rotates, "{text}");
    element.definition().rotates
}

#[test]
fn every_type_gives_the_rotations_of_its_page() {
    let mut asked = 0;
    for (name, expected) in rotating() {
        let entry = TABLE.iter().find(|entry| entry.name == name).expect(name);
        assert_eq!(entry.rotations, expected, "{name}");
        asked += 1;
        let permitted = entry.orientation[0].orientation != Orientation::Ignored;
        let section = if permitted { format!("{name}\nO,") } else { name.to_string() };
        assert_eq!(rotates(&deck(&section, "")), expected, "{name}");
    }
    assert_eq!(asked, TABLE.len());
    // A pair gives what either half gives; ACCELEROMETER in Standard is CARTESIAN, which uses no orientation at b.
    assert_eq!(rotates(&deck("JOIN, CARDAN\nO,", "")), [true, true]);
    assert_eq!(rotates(&deck("SLOT, FLOW-CONVERTER\nO,", "")), [true, false]);
    let standard = "*STEP\n*STATIC\n0.1, 1.\n*END STEP";
    assert_eq!(rotates(&deck("ACCELEROMETER", standard)), [true, false]);
}

/// Everything else that gives a node of a JOIN rotations, and what gives none.
#[test]
fn rotations_come_from_elsewhere() {
    let element = |kind: &str, nodes: &str| format!("*ELEMENT, TYPE={kind}, ELSET=E\n9, {nodes}");
    let spring = |dofs: &str| format!("*SPRING, ELSET=E\n{dofs}\n5.");
    let given = [
        (element("ROTARYI", "1"), [true, false]),
        (element("MASS", "1"), [false, false]),
        (format!("{}\n{}", element("SPRING1", "2"), spring("6")), [false, true]),
        (format!("{}\n{}", element("SPRING1", "2"), spring("3")), [false, false]),
        (format!("{}\n{}", element("SPRING2", "1, 2"), spring("4, 1")), [true, false]),
        (format!("{}\n*DASHPOT, ELSET=E\n5\n2.", element("DASHPOT1", "2")), [false, true]),
        ("*MPC\nBEAM, 1, 3".to_string(), [true, false]),
        ("*MPC\nREVOLUTE, 3, 2, 4".to_string(), [false, true]),
        ("*MPC\nPIN, 1, 3".to_string(), [false, false]),
        ("*MPC\nLINK, 1, 3".to_string(), [false, false]),
        ("*MPC\nTIE, 1, 3".to_string(), [false, false]),
        (format!("{}\n*MPC\nTIE, 1, 3\nTIE, 4, 3", element("ROTARYI", "4")), [true, false]),
        // Elements and constraints that are skipped.
        (element("B31", "1, 3"), [true, false]),
        (element("S4R", "1, 2,\n 3, 4"), [true, true]),
        (element("S4R", "3, 4,\n 2, 1"), [true, true]),
        (element("SC8R", "1, 2, 3, 4, 1, 2, 3, 4"), [false, false]),
        (element("C3D4", "1, 2, 3, 4"), [false, false]),
        (element("T3D2", "1, 2"), [false, false]),
        (element("R3D4", "1, 3, 4, 3"), [true, false]),
        (element("U1", "2, 3"), [false, true]),
        ("*RIGID BODY, REF NODE=2, PIN NSET=FIRST".to_string(), [false, true]),
        ("*RIGID BODY, REF NODE=3, TIE NSET=FIRST".to_string(), [true, false]),
        ("*SURFACE, TYPE=NODE, NAME=S\n2\n*COUPLING, CONSTRAINT NAME=K, REF NODE=FIRST, SURFACE=S\n*KINEMATIC".to_string(), [true, false]),
        ("*SURFACE, NAME=S\nE, S1\n*COUPLING, CONSTRAINT NAME=K, REF NODE=FIRST, SURFACE=S\n*KINEMATIC".to_string(), [true, false]),
        // A boundary condition acts on what there is.
        ("*BOUNDARY\n1, 4, 6\n2, ENCASTRE".to_string(), [false, false]),
    ];
    for (rest, expected) in given {
        assert_eq!(rotates(&deck("JOIN", &rest)), expected, "{rest}");
    }
    // Another connector on the node.
    let other = "*ELEMENT, TYPE=CONN3D2, ELSET=D\n8, 1, 3\n*CONNECTOR SECTION, ELSET=D\nROTATION";
    assert_eq!(rotates(&deck("JOIN", other)), [true, false]);
    let ground = deck("JOIN", "").replace("7, 1, 2", "7, , 2");
    assert_eq!(rotates(&ground), [false, false]);
}

/// The last of some states of a deck, in CSV.
fn evaluate(text: &str, states: &str, order: u8) -> (Model, StepResult) {
    let scene = Scene::parse("deck.inp", text).unwrap_or_else(|error| panic!("{}", error.render(110, false)));
    let states = StateFile::parse_csv("states.csv", states, &scene)
        .unwrap_or_else(|error| panic!("{}", error.render(110, false)));
    let model = model(text);
    let plan = Plan::compile(&model, &Selection::All, Request::everything(order)).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    let last = states.states.iter().map(|state| walk.step(state)).last().unwrap();
    (model, last)
}

/// The directions of a JOIN stay fixed where a has no rotations: rows have no columns θ, so no moment acts on a. With rotations from
/// elsewhere they follow a, and the force f on b has the moment f × d on a.
#[test]
fn a_join_turns_only_with_a_node_that_turns() {
    let moved = "node,u1,u2\n2,0.2,-0.1\n";
    let (_, fixed) = evaluate(&deck("JOIN\nO,", ""), moved, 1);
    let (_, turned) = evaluate(
        &deck("JOIN\nO,", "*ELEMENT, TYPE=ROTARYI, ELSET=E\n9, 1"),
        "node,u1,u2,ur3\n1,,,0.5\n2,0.2,-0.1,\n",
        1,
    );
    let residual = |result: &StepResult| [0, 1].map(|k| result.connectors[0].evaluation.residual[k].unwrap());
    assert_eq!(residual(&fixed), [1.2 - 1.0, 0.3 - 0.1 - 0.3]);
    let (sin, cos) = 0.5f64.sin_cos();
    let (x, y) = (1.2, 0.3 - 0.1);
    for (got, want) in residual(&turned).into_iter().zip([cos * x + sin * y - 1.0, cos * y - sin * x - 0.3]) {
        assert!((got - want).abs() < 1e-15, "{got}, not {want}");
    }
    for k in 0..3 {
        let row = fixed.connectors[0].evaluation.jacobian[k].unwrap();
        for j in 0..DOFS {
            let along = if j == k {
                -1.0
            } else if j == k + 7 {
                1.0
            } else {
                0.0
            };
            assert_eq!(row[j], along, "component {}, {}", k + 1, DOF[j]);
        }
        // e_k × d on θ_a.
        let row = turned.connectors[0].evaluation.jacobian[k].unwrap();
        let direction = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]][k];
        let moment = vector::cross(direction, [x, y, 0.0]);
        for i in 0..3 {
            assert!(
                (row[3 + i] - moment[i]).abs() < 1e-15 && row[10 + i] == 0.0,
                "component {}, θa{}",
                k + 1,
                i + 1
            );
        }
    }
}

/// θ_b of a FLOW-CONVERTER counts only where b has rotations from elsewhere; then it counts in full.
#[test]
fn a_drum_feels_b_only_where_it_turns() {
    let columns = |rest: &str| {
        let (_, result) = evaluate(&deck("FLOW-CONVERTER\nO,\n2.", rest), "node,flow\n2,0.25\n", 1);
        result.connectors[0].evaluation.jacobian[5].unwrap()
    };
    let alone = columns("");
    assert_eq!([alone[5], alone[12], alone[13]], [1.0, 0.0, -2.0]);
    let with = columns("*ELEMENT, TYPE=ROTARYI, ELSET=E\n9, 2");
    assert_eq!([with[5], with[12], with[13]], [1.0, -1.0, -2.0]);
    let (_, turned) = evaluate(
        &deck("FLOW-CONVERTER\nO,\n2.", "*ELEMENT, TYPE=ROTARYI, ELSET=E\n9, 2"),
        "node,ur3,flow\n1,0.75,\n2,0.5,0.25\n",
        1,
    );
    assert_eq!(turned.connectors[0].evaluation.residual[5], Some(0.75 - 0.5 - 2.0 * 0.25));
}

/// A node without rotations has no columns θ, in any type; the other columns are the same bit for bit.
#[test]
fn nodes_without_rotations_have_no_columns() {
    let mut compared = 0;
    for connection in types() {
        for case in cases(&connection, Extent::Brief) {
            let (free, _) = case.evaluate(&Request::everything(2));
            for rotates in [[false, true], [true, false], [false, false]] {
                let mut fixed = case.clone();
                fixed.definition.rotates = rotates;
                let (got, _) = fixed.evaluate(&Request::everything(2));
                let live = |j: usize| rotates[j / 7] || !matches!(j % 7, 3..=5);
                for c in 0..6 {
                    let Some(row) = got.jacobian[c] else { continue };
                    let place = format!("{}, component {}, rotates {rotates:?}", case.name, c + 1);
                    let (all, whole) = (free.jacobian[c].unwrap(), free.hessian[c].as_ref().unwrap());
                    let matrix = got.hessian[c].as_ref().unwrap();
                    for j in 0..DOFS {
                        assert_bits(&place, row[j], if live(j) { all[j] } else { 0.0 });
                        for k in 0..DOFS {
                            let want = if live(j) && live(k) { whole[j][k] } else { 0.0 };
                            assert!(matrix[j][k] == want, "{place}: ∂{j}∂{k}");
                            compared += usize::from(want != 0.0);
                        }
                    }
                }
            }
        }
    }
    assert!(compared > 30_000, "{compared}");
}

/// Two elements between the same nodes are evaluated side by side: JOIN and REVOLUTE have the rows of one HINGE.
#[test]
fn connectors_on_one_pair_of_nodes_add_up() {
    let nodes = "*NODE\n1, 0., 0., 0.\n2, 0.4, 0.3, 0.\n*ORIENTATION, NAME=O\n1., 2., 0.5, 0., 1., 0.\n";
    let element = |label: u64, set: &str, types: &str| {
        format!(
            "*ELEMENT, TYPE=CONN3D2, ELSET={set}\n{label}, 1, 2\n*CONNECTOR SECTION, ELSET={set}\n{types}\nO,\n"
        )
    };
    let motion = "node,u1,u2,u3,ur1,ur2,ur3\n1,0.1,0.2,-0.1,0.3,0.4,-0.2\n2,-0.2,0.1,0.2,0.5,0.1,0.7\n";
    let (one, whole) = evaluate(&format!("{nodes}{}", element(7, "H", "HINGE")), motion, 2);
    let text = format!("{nodes}{}{}", element(8, "J", "JOIN"), element(9, "R", "REVOLUTE"));
    let (two, halves) = evaluate(&text, motion, 2);
    assert!(one.warnings.is_empty() && two.warnings.is_empty(), "they share no constraint");
    let [join, revolute] = [0, 1].map(|i| &halves.connectors[i].evaluation);
    let hinge = &whole.connectors[0].evaluation;
    for k in 0..6 {
        let part = if k < 3 { join } else { revolute };
        assert_eq!(
            hinge.position[k].map(f64::to_bits),
            part.position[k].map(f64::to_bits),
            "component {}",
            k + 1
        );
        for j in 0..DOFS {
            assert_bits(
                format!("component {}, ∂{j}", k + 1),
                part.jacobian[k].unwrap()[j],
                hinge.jacobian[k].unwrap()[j],
            );
        }
    }
    // A force shared by two CARTESIANs with different directions does to the nodes what it does through one.
    let second = "*ORIENTATION, NAME=Q\n-1., 0.3, 2., 1., 1., 0.\n";
    let text = format!(
        "{nodes}{second}{}{}",
        element(8, "J", "CARTESIAN"),
        element(9, "R", "CARTESIAN").replace("\nO,", "\nQ,")
    );
    let (pair, result) =
        evaluate(&text, "node,u1,u2,u3,ur1,ur2,ur3\n1,0.1,0.2,-0.1,0.3,0.4,-0.2\n2,-0.2,0.1,0.2,,,\n", 2);
    let mut check = Check::of("rows by hand");
    let draw = &mut Draw::new("shared");
    let force = draw.vector(1.0);
    let nodal = |i: usize| -> [f64; DOFS] {
        let a: Matrix<f64> = current_triad(&pair, i);
        let f = vector::apply_transposed(&a, force);
        std::array::from_fn(|j| {
            (0..3).map(|k| result.connectors[i].evaluation.jacobian[k].unwrap()[j] * f[k]).sum()
        })
    };
    let (first, other) = (nodal(0), nodal(1));
    for j in 0..DOFS {
        check.against(|| DOF[j].to_string(), first[j], other[j], 2.0);
    }
    check.finish();
    assert!(first[7] != 0.0 && first[3] != 0.0, "forces on b, moments on a");
}

/// The directions of a at the state of [`connectors_on_one_pair_of_nodes_add_up`].
fn current_triad(model: &Model, i: usize) -> Matrix<f64> {
    vector::product(&crate::states::exp([0.3, 0.4, -0.2]), model.connectors[i].triads()[0])
}
