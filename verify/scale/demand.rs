//! Cost follows the request: the counter shows that what is not asked for is not computed, along a history too, and that what is asked for
//! does not depend on what is not.

use super::{chain, model};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Mask, Output, Request, Tally};
use pintle_model::evaluate::{Fixed, Freedom, Item, Jacobian, Model, Plan, Selection, Sequence};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State};
use std::convert::Infallible;
use std::fmt::Write;

const STATES: u64 = 20;

/// One radian of turning from state to state.
fn state(number: u64, nodes: usize) -> State {
    chain::state(16 * number, nodes)
}

fn only(k: usize) -> Mask {
    std::array::from_fn(|other| other == k)
}

/// The work of a history.
fn work(model: &Model, selection: &Selection, request: Request, nodes: usize) -> Tally {
    let plan = Plan::compile(model, selection, request).unwrap();
    let mut sequence = Sequence::new(model, &plan);
    (0..STATES).for_each(|number| drop(sequence.step(&state(number, nodes))));
    sequence.tally()
}

/// Components of every type, each alone, have the same values over several turns as all together.
#[test]
fn what_is_asked_for_does_not_depend_on_what_is_not() {
    const CONNECTORS: usize = 70;
    let (_, model) = model(CONNECTORS, "");
    let plan = |mask| {
        Plan::compile(&model, &Selection::All, Request::new(&[Output::CU, Output::CV, Output::RES], mask, 1))
    };
    let whole = plan([true; 6]).unwrap();
    let mut all = Sequence::new(&model, &whole);
    let steps: Vec<_> = (0..STATES).map(|number| all.step(&state(number, CONNECTORS + 1))).collect();
    let turned =
        steps.iter().flat_map(|step| &step.connectors).flat_map(|result| result.evaluation.branch.turns);
    assert!(turned.filter(|turns| turns.turns != 0.0).count() > 100, "angles must wind");
    for k in 0..6 {
        let part = plan(only(k)).unwrap();
        let mut one = Sequence::new(&model, &part);
        for (number, whole) in (0..STATES).zip(&steps) {
            let step = one.step(&state(number, CONNECTORS + 1));
            for (got, want) in step.connectors.iter().zip(&whole.connectors) {
                let title = model.connectors[got.index].title();
                let (got, want) = (&got.evaluation, &want.evaluation);
                let bits = |value: Option<f64>| value.map(|value| (value + 0.0).to_bits());
                let place = format!("state {number}, {title}, {}", COMPONENT[k]);
                assert_eq!(bits(got.displacement[k]), bits(want.displacement[k]), "{place}");
                assert_eq!(bits(got.velocity[k]), bits(want.velocity[k]), "{place}");
                assert_eq!(bits(got.residual[k]), bits(want.residual[k]), "{place}");
                let rows =
                    [got, want].map(|of| of.jacobian[k].map(|row| row.map(|entry| (entry + 0.0).to_bits())));
                assert_eq!(rows[0], rows[1], "{place}");
            }
        }
    }
}

fn cardan(rest: &str) -> Model {
    let deck = format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n8, 2, 3\n*CONNECTOR SECTION, ELSET=C{rest}"
    );
    let scene =
        Scene::parse("cardan.inp", &deck).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    Model::compile(&scene).unwrap_or_else(|error| panic!("{}", error.render(100, false)))
}

/// Through a Cardan lock, where the third angle depends on the first, the third alone is what it is in the whole.
#[test]
fn a_lock_is_passed_alike() {
    let model = cardan("\nCARTESIAN, CARDAN\nO,\n");
    let run = |mask| {
        let plan = Plan::compile(&model, &Selection::All, Request::new(&[Output::CU], mask, 0)).unwrap();
        let mut sequence = Sequence::new(&model, &plan);
        let quarter = std::f64::consts::FRAC_PI_2;
        let turns =
            [[1.2, 0.0, 0.0], [0.0, quarter, 0.0], [0.0, quarter, 0.0], [0.4, 0.2, 3.0], [0.0, quarter, 0.0]];
        turns.map(|turn| {
            let mut state = State::default();
            let motion = NodeMotion { rotation: Rotation::Vector(turn), ..NodeMotion::default() };
            state.nodes.insert(Label::from(2), motion);
            sequence.step(&state).connectors[0].evaluation.displacement[5].unwrap().to_bits()
        })
    };
    assert_eq!(run(only(5)), run([true; 6]));
}

/// Results that are handed on in room that is used again are those that are owned: nothing of another type, or of the state before, is left.
#[test]
fn results_hold_nothing_of_those_before() {
    let connectors = 2 * chain::types().len();
    let (_, model) = model(connectors, "");
    let plan = Plan::compile(&model, &Selection::All, Request::everything(2)).unwrap();
    let (mut owning, mut visiting) = (Sequence::new(&model, &plan), Sequence::new(&model, &plan));
    for number in 0..3 {
        let state = state(number, connectors + 1);
        let owned = owning.step(&state);
        assert!(!owned.connectors.is_empty());
        let mut owned = owned.connectors.iter();
        let Ok(()) = visiting.visit(&state, |item| -> Result<(), Infallible> {
            let Item::Connector(result) = item else { panic!("a chain has no MPC") };
            let title = model.connectors[result.index].title();
            let own = owned.next().map(|own| format!("{own:?}"));
            assert!(own == Some(format!("{result:?}")), "state {number}, {title}");
            Ok(())
        });
        assert!(owned.next().is_none());
    }
}

/// Twice the connectors, twice the work, to the last count; orders that are not asked for are not computed.
#[test]
fn work_is_proportional_to_connectors_and_order() {
    let types = chain::types();
    let (_, model) = model(2 * types.len(), "");
    let nodes = 2 * types.len() + 1;
    // One connector of each type, and another.
    let named =
        |range: std::ops::Range<usize>| Selection::Named(range.map(|at| (at + 1).to_string()).collect());
    let request = || Request::new(&[Output::CP, Output::CV, Output::RES], [true; 6], 1);
    let [first, second, both] = [0..types.len(), types.len()..2 * types.len(), 0..2 * types.len()]
        .map(|range| work(&model, &named(range), request(), nodes));
    let mut sum = first;
    sum += second;
    // The node between the halves is theirs in common.
    assert_eq!(both, Tally { rotations: sum.rotations - STATES, ..sum });
    for order in 0..=2 {
        let Tally { gradients, hessians, .. } =
            work(&model, &Selection::All, Request::new(&[], [true; 6], order), nodes);
        assert_eq!([gradients > 0, hessians > 0], [order > 0, order == 2]);
    }
    let nothing = work(&model, &Selection::All, Request::nothing(2), nodes);
    assert_eq!(nothing, Tally { rotations: nodes as u64 * STATES, ..Tally::default() });
}

/// Histories, margins and rotations follow what is asked for.
#[test]
fn histories_follow_the_request() {
    let model = cardan("\nCARTESIAN, CARDAN\nO,\n");
    let of = |outputs: &[Output], mask, order| {
        work(&model, &Selection::Named(vec!["7".into()]), Request::new(outputs, mask, order), 3)
    };
    // u1 needs no angle; ur2 does not wind; ur1 and ur3 are unwound together.
    assert_eq!(of(&[Output::CP], only(0), 1).histories, 0);
    assert_eq!(of(&[Output::CP], only(4), 1).histories, 0);
    assert_eq!(of(&[Output::CP], only(5), 1).histories, 2 * STATES);
    assert_eq!(of(&[Output::CP], [true; 6], 1).histories, 2 * STATES);
    // A Cardan angle has a singular set, a coordinate has none.
    assert_eq!(of(&[Output::CP], only(0), 0).margins, 0);
    assert_eq!(of(&[Output::CP], only(3), 0).margins, STATES);
    // A node that is never turned costs nothing, nor does the ground.
    let plan = Plan::compile(&model, &Selection::All, Request::new(&[Output::CU], [true; 6], 0)).unwrap();
    let mut sequence = Sequence::new(&model, &plan);
    let mut state = State::default();
    let turned = NodeMotion { rotation: Rotation::Vector([0.0, 0.1, 0.0]), ..NodeMotion::default() };
    let moved = NodeMotion { displacement: [1.0, 2.0, 3.0], ..NodeMotion::default() };
    state.nodes.extend([(Label::from(1), turned), (Label::from(2), moved)]);
    (0..STATES).for_each(|_| drop(sequence.step(&state)));
    assert_eq!(sequence.tally().rotations, STATES);
}

/// Springs, dampers, friction, stops and locks that nobody asks about leave the work as it is without them.
#[test]
fn an_unused_behaviour_costs_nothing() {
    let mut behavior = String::from(", BEHAVIOR=B\nCARTESIAN, CARDAN\nO,\n*CONNECTOR BEHAVIOR, NAME=B\n");
    for component in 1..=6 {
        writeln!(behavior, "*CONNECTOR ELASTICITY, COMPONENT={component}\n10.").unwrap();
        writeln!(behavior, "*CONNECTOR DAMPING, COMPONENT={component}\n1.").unwrap();
    }
    behavior.push_str(
        "*CONNECTOR FRICTION, COMPONENT=1\n, 5.\n*FRICTION\n0.1\n*CONNECTOR STOP, COMPONENT=2\n-9., 9.\n",
    );
    let (plain, laden) = (cardan("\nCARTESIAN, CARDAN\nO,\n"), cardan(&behavior));
    for outputs in [&[Output::CP, Output::CU][..], &[Output::CV, Output::CA], &[Output::RES], &[]] {
        for order in 0..=2 {
            let request = || Request::new(outputs, [true; 6], order);
            let [without, with] = [&plain, &laden].map(|model| work(model, &Selection::All, request(), 3));
            assert_eq!(with, without, "{outputs:?}, order {order}");
            assert_eq!(with.behaviors, 0);
        }
    }
    // What is asked for is computed, for the connectors that are named.
    let one = Selection::Named(vec!["8".into()]);
    let elastic = work(&laden, &one, Request::new(&[Output::CEF], [true; 6], 0), 3);
    assert_eq!(elastic.behaviors, STATES);
}

/// Friction that nobody asks about is not followed, also where springs, dampers and stops of the same connector are evaluated.
#[test]
fn unrequested_friction_costs_nothing() {
    let springs = ", BEHAVIOR=B\nCARTESIAN, CARDAN\nO,\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1\n10.\n\
                   *CONNECTOR DAMPING, COMPONENT=1\n1.\n*CONNECTOR STOP, COMPONENT=2\n-9., 9.\n";
    let friction = format!("{springs}*CONNECTOR FRICTION, COMPONENT=1\n, 5.\n*FRICTION\n0.1\n");
    let (without, with) = (cardan(springs), cardan(&friction));
    for output in [Output::CEF, Output::CVF, Output::CSLST] {
        let [without, with] = [&without, &with]
            .map(|model| work(model, &Selection::All, Request::new(&[output], [true; 6], 1), 3));
        assert_eq!(with, without, "{output:?}");
        assert_eq!(with.behaviors, 2 * STATES);
    }
    // What slips is worked out where it is asked for, and only there.
    let slips = |output| {
        let request = Request::new(&[output], [true; 6], 0);
        let plan = Plan::compile(&with, &Selection::All, request).unwrap();
        let step = Sequence::new(&with, &plan).step(&state(1, 3));
        step.connectors.iter().map(|result| result.behavior.as_ref().unwrap().slips.len()).sum::<usize>()
    };
    assert_eq!([Output::CEF, Output::CSLST, Output::CSF].map(slips), [0, 0, 2]);
}

/// Rows between fixed nodes are not computed.
#[test]
fn fixed_nodes_cost_no_rows() {
    let model = cardan("\nCARTESIAN, CARDAN\nO,\n");
    let work = |fixed: &[u64]| {
        let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
        let freedom = |node: &u64| {
            (1..=6).map(|number| Freedom { node: Label::from(*node), number }).collect::<Vec<_>>()
        };
        let fixed: Fixed = fixed.iter().flat_map(freedom).collect();
        let jacobian = Jacobian::new(&model, &plan, &fixed, |_, _| true);
        let mut sequence = Sequence::new(&model, &plan);
        let mut values = Vec::new();
        sequence.assemble(&state(1, 3), &jacobian, &mut values).unwrap();
        (sequence.tally().gradients, values.len())
    };
    let (all, entries) = work(&[]);
    assert_eq!(work(&[1, 2]).0 * 2, all, "two connectors, of which one joins fixed nodes");
    assert!(work(&[2]).1 < entries && work(&[2]).0 == all);
    assert_eq!(work(&[1, 2, 3]), (0, 0));
}

/// Branches that were saved without the turns of a component cannot be continued by who asks for them.
#[test]
fn turns_that_were_not_followed_are_not_continued() {
    let model = cardan("\nCARTESIAN, CARDAN\nO,\n");
    let plan = |mask| Plan::compile(&model, &Selection::All, Request::new(&[Output::CU], mask, 0)).unwrap();
    let (translations, angles) = (plan(only(0)), plan(only(3)));
    let mut sequence = Sequence::new(&model, &translations);
    sequence.step(&state(1, 3));
    let saved = serde_json::to_string(&sequence.branches()).unwrap();
    let branches: pintle_model::evaluate::Branches = serde_json::from_str(&saved).unwrap();
    assert_eq!(branches.check(&model, &translations), Ok(()));
    let refusal = branches.check(&model, &angles).unwrap_err();
    assert!(refusal.contains("the turns of ur1 of connector 7 were not followed"), "{refusal}");
    // Unless everything was followed.
    let mut sequence = Sequence::new(&model, &translations);
    sequence.follow_everything();
    sequence.step(&state(1, 3));
    assert_eq!(sequence.branches().check(&model, &angles), Ok(()));
}
