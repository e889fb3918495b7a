//! The sparse Jacobian holds the rows of the elements, each number in its place, and nothing else.

use super::{chain, model};
use pintle_kinematics::connector::{Flag, Request};
use pintle_kinematics::mpc::MpcType;
use pintle_kinematics::node::{DOF_NUMBER, DOFS};
use pintle_model::evaluate::{
    Fixed, Freedom, Jacobian, Model, Plan, Selection, Sequence, Source, StepResult,
};
use pintle_scene::{Label, Scene};
use std::collections::BTreeMap;

const CONNECTORS: usize = 160;

/// Boundary conditions on single degrees of freedom, some of them along turned axes, and constraints of every kind.
const REST: &str = "*NODE\n900, 0.5, 1., 0.\n901, 1.5, 1., 0.25\n902, 2., 1., 1.\n903, 3., 0., 1.\n904, 2., 2., 0.\n\
905, 3., 3., 0.\n906, 1., 4., 0.\n907, 1., 5., 0.\n908, 2., 5., 0.5\n909, 2., 6., 0.\n910, 3., 6., 0.\n\
*MPC\nBEAM, 900, 10\nTIE, 901, 20\nPIN, 902, 30\nLINK, 903, 40\nREVOLUTE, 904, 50, 905\nUNIVERSAL, 906, 60, 907, 908\n\
*NSET, NSET=TURNED\n21, 22, 50\n*TRANSFORM, NSET=TURNED\n0.6, 0.8, 0., -0.8, 0.6, 0.\n\
*BOUNDARY\n1, 1, 6\n21, 2\n22, 4, 6\n33, 3\n50, 6\n44, 10\n905, 6\n\
*STEP\n*STATIC\n1., 1.\n*BOUNDARY\n70, 1, 2\n*END STEP\n";

/// A matrix by row and column; entries that are not there are not in it.
type Entries = BTreeMap<(usize, Freedom), f64>;

/// The rows of the elements, put together entry by entry.
fn of_elements(model: &Model, jacobian: &Jacobian, step: &StepResult, axes: &Fixed) -> Entries {
    let mut entries = Entries::new();
    let mut add = |row: usize, node: Label, number: u8, value: f64| {
        // Along the axes of the node: column i is the sum over the global components j of e_i·e_j.
        let group = if number <= 3 { 0 } else { 3 };
        match axes.axes(node).filter(|_| number <= 6) {
            Some(axes) => (0..3_u8).for_each(|i| {
                let cosine = axes[usize::from(i)][usize::from(number - 1 - group)];
                *entries.entry((row, Freedom { node, number: group + i + 1 })).or_insert(0.0) +=
                    cosine * value;
            }),
            None => *entries.entry((row, Freedom { node, number })).or_insert(0.0) += value,
        }
    };
    for (row, equation) in jacobian.equations().iter().enumerate() {
        match equation.source {
            Source::Connector(index) => {
                let result = step.connectors.iter().find(|result| result.index == index).unwrap();
                let values = result.evaluation.jacobian[equation.component].unwrap();
                for j in 0..DOFS {
                    if let Some(node) = model.connectors[index].nodes[j / 7] {
                        add(row, node, DOF_NUMBER[j], values[j]);
                    }
                }
            }
            Source::Mpc(index) => {
                let result = step.mpcs.iter().find(|result| result.index == index).unwrap();
                let values = result.evaluation.jacobian[equation.component].unwrap();
                for (j, value) in values.into_iter().enumerate() {
                    let (place, number) = MpcType::column_dof(j);
                    if let Some(node) = model.mpcs[index].nodes.get(place) {
                        add(row, *node, number, value);
                    }
                }
            }
            Source::Relation(index) => {
                let result = step.relations.iter().find(|result| result.index == index).unwrap();
                let element = &model.relations[index];
                let values = &result.rows[equation.component].gradient;
                for ((place, number), value) in element.relation.columns().iter().zip(values) {
                    add(row, element.nodes[*place], *number, *value);
                }
            }
        }
    }
    entries
}

/// The sparse matrix against the rows of the elements; the number of entries compared.
fn assert_same(scene: &Scene, model: &Model, fixed: &Fixed, all: bool) -> usize {
    let mut everything = Request::nothing(1);
    everything.add_rows([true; 6]);
    let plan = Plan::compile(model, &Selection::All, everything).unwrap();
    let jacobian = match all {
        true => Jacobian::new(model, &plan, fixed, |_, _| true),
        false => Jacobian::of_constraints(model, &plan, fixed),
    };
    let (mut sparse, mut dense) = (Sequence::new(model, &plan), Sequence::new(model, &plan));
    let mut values = Vec::new();
    let mut compared = 0;
    for number in 0..6 {
        let state = chain::state(number, scene.nodes.len().min(CONNECTORS + 1));
        sparse.assemble(&state, &jacobian, &mut values).unwrap();
        let step = dense.step(&state);
        assert_eq!(sparse.branches(), dense.branches());
        let mut wanted = of_elements(model, &jacobian, &step, fixed);
        wanted.retain(|(_, freedom), _| !fixed.contains(*freedom));
        assert_eq!(values.len(), jacobian.entries());
        for row in 0..jacobian.rows() {
            let columns = jacobian.row(row);
            assert!(columns.is_sorted_by(|a, b| a < b), "row {row}: {columns:?}");
            for (column, place) in columns.iter().zip(jacobian.range(row).unwrap()) {
                let freedom = jacobian.freedoms()[*column as usize];
                let want = wanted.remove(&(row, freedom)).unwrap();
                let error = (values[place] - want).abs();
                // Turned entries are sums of three products, here in another order; lanes have products with one rounding.
                let allowed = 4.0 * f64::EPSILON * want.abs().max(1.0);
                assert!(
                    error <= allowed,
                    "state {number}, row {row}, {freedom:?}: {} for {want}",
                    values[place]
                );
                compared += 1;
            }
        }
        // What has no place is zero.
        for ((row, freedom), value) in wanted {
            assert!(value.abs() < 1e-15, "state {number}, row {row}, {freedom:?}: {value} has no place");
        }
    }
    compared
}

/// Free, fixed, and fixed along turned axes; constraints alone, and the rows of every component.
#[test]
fn the_sparse_jacobian_is_that_of_the_elements() {
    let (scene, model) = model(CONNECTORS, REST);
    for fixed in [Fixed::none(), Fixed::in_step(&scene, 0).unwrap(), Fixed::of(&scene).unwrap()] {
        for all in [false, true] {
            assert!(assert_same(&scene, &model, &fixed, all) > 10_000);
        }
    }
}

/// A row whose end b is on the ground: the columns of a are what they are with a node there.
#[test]
fn rows_to_the_ground_are_rows() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 2., 1., 0.\n*ORIENTATION, NAME=A\n0.6, 0.8, 0., -0.8, 0.6, 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, \n8, , 2\n9, 1, 2\n*CONNECTOR SECTION, ELSET=C\nHINGE\nA,\n";
    let scene = Scene::parse("ground.inp", deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    assert_eq!(model.connectors.iter().filter(|element| element.nodes[1].is_none()).count(), 1);
    for all in [false, true] {
        assert!(assert_same(&scene, &model, &Fixed::none(), all) > 100);
    }
}

/// Grounded ends and fixed nodes have no columns; numbers increase by node.
#[test]
fn what_is_fixed_has_no_column() {
    let (scene, model) = model(CONNECTORS, REST);
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let columns = |fixed: &Fixed| Jacobian::of_constraints(&model, &plan, fixed).freedoms().to_vec();
    let (free, before, fixed) = (
        columns(&Fixed::none()),
        columns(&Fixed::in_step(&scene, 0).unwrap()),
        columns(&Fixed::of(&scene).unwrap()),
    );
    assert!(free.is_sorted_by(|a, b| a < b));
    let is_of = |columns: &[Freedom], node: u64| {
        let of_node = columns.iter().filter(|freedom| freedom.node == Label::from(node));
        of_node.map(|freedom| freedom.number).collect::<Vec<_>>()
    };
    assert!(!is_of(&free, 1).is_empty() && is_of(&before, 1).iter().all(|number| *number == 10));
    assert!(is_of(&free, 905).contains(&6) && !is_of(&before, 905).contains(&6));
    assert_eq!(is_of(&before, 70)[..3], [1, 2, 3]);
    assert_eq!(is_of(&fixed, 70)[0], 3);
    // A matrix of free nodes can be reached from a list as well.
    let listed: Fixed = [Freedom { node: Label::from(2), number: 1 }].into_iter().collect();
    assert_eq!(columns(&listed).len() + 1, free.len());
}

/// A singular state is told, and a pattern of another plan is refused.
#[test]
fn assembly_tells_what_needs_care() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n8, 2, 3\n\
                *CONNECTOR SECTION, ELSET=C\nLINK,\n";
    let scene = Scene::parse("links.inp", deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::none());
    let mut values = Vec::new();
    let mut state = pintle_scene::State::default();
    let mut moved = pintle_scene::NodeMotion::default();
    moved.displacement[0] = -1.0;
    state.nodes.insert(Label::from(2), moved);
    let care = Sequence::new(&model, &plan).assemble(&state, &jacobian, &mut values).unwrap();
    let [(title, flag)] = care.as_slice() else { panic!("{care:?}") };
    assert_eq!(title, "LINK 7");
    assert!(matches!(flag, Flag::Singular { .. }), "{flag:?}");
    let one = Plan::compile(&model, &Selection::Named(vec!["8".into()]), Request::nothing(0)).unwrap();
    let refused = Sequence::new(&model, &one).assemble(&state, &jacobian, &mut values);
    assert!(refused.unwrap_err().to_string().contains("another plan"));
}

/// What leaves its plane is told of planar connectors with rows and without.
#[test]
fn assembly_tells_what_leaves_its_plane() {
    let state = {
        let mut state = pintle_scene::State::default();
        let moved = pintle_scene::NodeMotion { displacement: [0.0, 0.0, 0.1], ..Default::default() };
        state.nodes.insert(Label::from(1), moved);
        state
    };
    for (kind, rows) in [("JOIN", 2), ("CARTESIAN", 0)] {
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN2D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\n{kind},\n"
        );
        let scene = Scene::parse("plane.inp", &deck).unwrap();
        let model = Model::compile(&scene).unwrap();
        let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
        let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::none());
        assert_eq!(jacobian.rows(), rows);
        let care = Sequence::new(&model, &plan).assemble(&state, &jacobian, &mut Vec::new()).unwrap();
        assert!(care.iter().any(|(_, flag)| flag.name() == "out-of-plane"), "{kind}: {care:?}");
    }
}

/// The Matrix Market file says what it holds, and holds it to the last bit.
#[test]
fn matrix_market_reads_back() {
    let (scene, model) = model(40, "");
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::of(&scene).unwrap());
    let mut values = Vec::new();
    Sequence::new(&model, &plan).assemble(&chain::state(3, 41), &jacobian, &mut values).unwrap();
    let mut text = Vec::new();
    pintle_report::matrix_market::write(&mut text, "chain.inp", &model, &jacobian, &values).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert_eq!(text.lines().next(), Some("%%MatrixMarket matrix coordinate real general"));
    let first = jacobian.equations()[0].title(&model);
    assert!(text.contains(&format!("% row 1: {first}\n")) && text.contains("% column 1: 1 1\n"), "{first}");
    let mut lines = text.lines().filter(|line| !line.starts_with('%'));
    let size = format!("{} {} {}", jacobian.rows(), jacobian.columns(), jacobian.entries());
    assert_eq!(lines.next(), Some(size.as_str()));
    for row in 0..jacobian.rows() {
        for (column, place) in jacobian.row(row).iter().zip(jacobian.range(row).unwrap()) {
            let words: Vec<&str> = lines.next().unwrap().split(' ').collect();
            assert_eq!(words[..2], [(row + 1).to_string(), (column + 1).to_string()]);
            assert_eq!(words[2].parse::<f64>().unwrap().to_bits(), values[place].to_bits());
        }
    }
    assert_eq!(lines.next(), None);
}

/// What is not finite is told, of a constraint as of a connector.
#[test]
fn entries_that_are_no_numbers_are_told() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 2., 0., 0.\n3, 0., 0., 0.\n4, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 3, 4\n\
                *CONNECTOR SECTION, ELSET=C\nLINK,\n*MPC\nLINK, 1, 2\n";
    let scene = Scene::parse("far.inp", deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let jacobian = Jacobian::of_constraints(&model, &plan, &Fixed::none());
    let far = |x: f64| pintle_scene::NodeMotion { displacement: [x, 1e308, 0.0], ..Default::default() };
    let nodes = [(1, far(-1.5e308)), (2, far(1.5e308)), (3, far(-1.5e308)), (4, far(1.5e308))];
    let nodes = nodes.map(|(node, motion)| (node.into(), motion)).into();
    let state = pintle_scene::State { nodes, ..Default::default() };
    let mut values = Vec::new();
    let care = Sequence::new(&model, &plan).assemble(&state, &jacobian, &mut values).unwrap();
    assert!(values.iter().any(|x| !x.is_finite()));
    for title in ["LINK 7", "MPC LINK 1-2"] {
        let is_it = |flag: &Flag| matches!(flag, Flag::NotFinite { quantity: "derivative", .. });
        assert!(care.iter().any(|(of, flag)| of == title && is_it(flag)), "{title}: {values:?} {care:?}");
    }
}
