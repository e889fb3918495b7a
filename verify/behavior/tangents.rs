//! The consistent tangent: slopes of component forces and of nodal forces against differences on 237 bits, where every force is
//! formed anew from motions, springs, dampers and friction.

use crate::tolerance::{NODAL_TANGENT, TANGENT};
use pintle_kinematics::connector::{Components, Connector, Increment, Output, Request, State, Tally};
use pintle_kinematics::force::Want;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector, product};
use pintle_model::behavior::friction::{Branch, Context, Friction, Input, State as FrictionState};
use pintle_model::behavior::state::Velocities;
use pintle_model::behavior::{Conditions, Motion, Unknown};
use pintle_model::evaluate::{ConnectorElement, ConnectorResult, Model, Plan, Selection, Sequence, request};
use pintle_scene::{ElementForces, NodeMotion, Rotation, Scene, State as SceneState};
use std::collections::BTreeMap;

/// Connectors with springs, dampers and friction, and what holds or moves them: name, type and section data, behaviour, steps.
const SCENES: [(&str, &str, &str, &str); 12] = [
    (
        "springs and dampers of every component",
        "CARTESIAN, CARDAN\nO,",
        "*CONNECTOR ELASTICITY\n4., 1., 5., 0.5, -1., 6., 0., 0.25\n0.75, 7., 0.1, 0.2, 0.3, 0.4, 8., -0.5\n0.6, 0.7, 0.8, 0.9, 9.\n\
         *CONNECTOR DAMPING, UNSYMM\n1., 2., 3., 4., 5., 6., 7., 8.\n9., 1., 2., 3., 4., 5., 6., 7.\n8., 9., 1., 2., 3., 4., 5., 6.\n\
         7., 8., 9., 1., 2., 3., 4., 5.\n6., 7., 8., 9.\n",
        "",
    ),
    (
        "midway",
        "BUSHING\nO,",
        "*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\n-3., -9.\n1., 0.3\n70., 9.\n*CONNECTOR ELASTICITY, COMPONENT=5\n3.\n\
         *CONNECTOR DAMPING, COMPONENT=6\n2.\n*CONNECTOR DAMPING, COMPONENT=2\n0.5\n",
        "",
    ),
    ("a slot", "SLOT\nO,", "*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=9.\n0.5\n*FRICTION\n0.1\n", ""),
    (
        "a guide with a spring",
        "TRANSLATOR\nO,",
        "*CONNECTOR ELASTICITY, COMPONENT=1\n3.\n*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=9.\n0.3, 0.7, 0.4\n*FRICTION\n0.1\n",
        "",
    ),
    (
        "a sleeve, by the rate of slip",
        "CYLINDRICAL\nO,",
        "*CONNECTOR DAMPING, COMPONENT=4\n0.3\n*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=30.\n0.5, 0.8, 1.\n\
         *FRICTION, EXPONENTIAL DECAY\n0.2, 0.1, 0.7\n",
        "",
    ),
    (
        "a puck",
        "PLANAR\nO,",
        "*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=25.\n0.4, 1., 0.2\n*FRICTION\n0.15\n",
        "",
    ),
    (
        "a cross",
        "UJOINT\nO,",
        "*CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=20.\n0.05, 0.3, 0.02, 0.1, 0.1, 0.2\n*FRICTION\n0.3\n",
        "",
    ),
    (
        "pressed by a spring and a damper",
        "CARTESIAN, CARDAN\nO,",
        "*CONNECTOR ELASTICITY, COMPONENT=2\n8.\n*CONNECTOR DAMPING, COMPONENT=2\n0.7\n*CONNECTOR ELASTICITY, COMPONENT=1\n2.\n\
         *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=2, STICK STIFFNESS=40.\n*FRICTION\n0.4\n",
        "",
    ),
    (
        "pressed by what is held, on an ellipsoid",
        "CARTESIAN, CARDAN\nO,",
        "*CONNECTOR ELASTICITY, COMPONENT=3\n8.\n*CONNECTOR FRICTION, CONTACT FORCE=3, STICK STIFFNESS=40.\n\
         *CONNECTOR POTENTIAL\n1, 2.\n2, 0.5\n*FRICTION\n0.4\n",
        "*STEP\n*STATIC\n1., 9.\n*CONNECTOR MOTION\n7, 3, 1.\n*END STEP\n",
    ),
    (
        "a belt",
        "SLIPRING\n\n0.06, 1.5",
        "*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\n0., -1.\n0., 0.\n50., 1.\n*CONNECTOR DAMPING, COMPONENT=1\n0.4\n",
        "",
    ),
    (
        "at its stop",
        "SLOT\nO,",
        "*CONNECTOR ELASTICITY, COMPONENT=1\n3.\n*CONNECTOR STOP, COMPONENT=1\n-9., 1.\n",
        "",
    ),
    (
        "rigid",
        "CARTESIAN\nO,",
        "*CONNECTOR ELASTICITY, RIGID\n1\n*CONNECTOR ELASTICITY, COMPONENT=2\n5.\n",
        "",
    ),
];

const STEP: f64 = 0.25;

fn model((name, types, behavior, steps): (&str, &str, &str, &str)) -> Model {
    let deck = format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0.5, -0.25\n*ORIENTATION, NAME=O\n1., 0.2, 0., 0., 1., 0.1\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\n{types}\n\
         *CONNECTOR BEHAVIOR, NAME=B\n{behavior}{steps}"
    );
    let scene = Scene::parse("deck.inp", &deck);
    let model = scene.and_then(|scene| Model::compile(&scene));
    model.unwrap_or_else(|error| panic!("{name}: {}\n{deck}", error.render(100, false)))
}

/// How far the nodes have gone at the first and at the second state: far enough to slip, or nearly not.
const SECOND: [f64; 3] = [0.45, 0.103, 0.1004];

fn motion(node: usize, state: usize, amount: f64) -> NodeMotion {
    let at = [[0.1, 0.02], [0.1, -0.01]][node][0];
    let amount = if state == 0 { 0.1 } else { amount };
    let sign = [1.0, -0.7][node];
    let along = |v: [f64; 3]| v.map(|x| sign * amount * x);
    NodeMotion {
        displacement: along([0.3, -0.5, 0.8]),
        rotation: Rotation::Vector(along([-0.6, 0.4, 0.7])),
        flow: at * amount,
        velocity: along([0.2, 0.9, -0.4]),
        angular_velocity: along([0.5, 0.1, -0.8]),
        flow_velocity: 0.3 * at,
        ..NodeMotion::default()
    }
}

fn states(element: &ConnectorElement, amount: f64) -> [SceneState; 2] {
    [0, 1].map(|i| {
        let mut forces = BTreeMap::new();
        let given = [3.0, -2.0, 4.0, 0.7, -0.4, 0.9];
        let total = [0, 1, 2, 3, 4, 5].map(|k| element.connector.has_force(k).then_some(given[k]));
        forces.insert(7.into(), ElementForces { total, ..ElementForces::default() });
        SceneState {
            time: Some(STEP * (i as f64 + 1.0)),
            nodes: BTreeMap::from([(1.into(), motion(0, i, amount)), (2.into(), motion(1, i, amount))]),
            forces,
            ..SceneState::default()
        }
    })
}

/// A connector at its second state, on 237 bits.
struct Truth<'a> {
    element: &'a ConnectorElement,
    connector: Connector<Wide>,
    result: &'a ConnectorResult,
    motions: [NodeMotion; 2],
    before: Components<f64>,
    velocities: Velocities,
    /// CRF of what reacts.
    reactions: [f64; 6],
}

/// By what forces change.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Node(usize),
    Rate(usize),
    Component(usize),
    Velocity(usize),
    Reaction(usize),
    Duration,
}

fn widened(state: &FrictionState<f64>) -> FrictionState<Wide> {
    FrictionState {
        force: state.force.map(Wide::from_f64),
        accumulated_slip: Wide::from_f64(state.accumulated_slip),
        stick_stiffness: state.stick_stiffness.map(Wide::from_f64),
    }
}

impl Truth<'_> {
    fn state(&self, by: By, h: Wide) -> State<Wide> {
        let at = |j: usize| if by == By::Node(j) { h } else { Wide::from_f64(0.0) };
        let node = |end: usize| {
            let motion = &self.motions[end];
            let Rotation::Vector(phi) = motion.rotation else { panic!("a rotation vector") };
            let turn = |phi: Vector<Wide>| so3::matrix(so3::exp_quaternion(phi));
            let first = 7 * end;
            let small = turn([at(first + 3), at(first + 4), at(first + 5)]);
            let initial: Matrix<Wide> = vector::exact_matrix(self.element.triads()[end]);
            let displacement: Vector<Wide> = vector::exact(motion.displacement);
            Node {
                displacement: [0, 1, 2].map(|i: usize| displacement[i] + at(first + i)),
                triad: product(&small, &product(&turn(vector::exact(phi)), &initial)),
                flow: Wide::from_f64(motion.flow) + at(first + 6),
            }
        };
        let mut velocity = [Wide::from_f64(0.0); DOFS];
        for (end, motion) in self.motions.iter().enumerate() {
            let rates = [motion.velocity, motion.angular_velocity].concat();
            for (i, rate) in rates.into_iter().chain([motion.flow_velocity]).enumerate() {
                velocity[7 * end + i] = Wide::from_f64(rate);
            }
        }
        if let By::Rate(j) = by {
            velocity[j] += h;
        }
        let pair = Pair { reference: vector::exact(self.element.reference), a: node(0), b: node(1) };
        State { pair, velocity, acceleration: [Wide::from_f64(0.0); DOFS] }
    }

    /// Component forces CEF + CVF + CSF + CRF, and nodal forces.
    fn forces(&self, by: By, h: Wide) -> ([Wide; 6], [Wide; DOFS]) {
        let (connector, element) = (&self.connector, self.element);
        let zero = Wide::from_f64(0.0);
        let state = self.state(by, h);
        let branch = connector.advance(&state, &Increment::none(), &connector.initial_branch());
        let wanted = Request::new(&[Output::CP, Output::CU, Output::CCU, Output::CV], [true; 6], 0);
        let found = connector.evaluate(
            &state,
            &Increment::none(),
            &connector.initial_branch(),
            &wanted,
            &mut Tally::default(),
        );
        let duration = Wide::from_f64(STEP) + if by == By::Duration { h } else { zero };
        let available = element.behavior.behavior.available();
        let moved = |k: usize| if by == By::Component(k) { h } else { zero };
        let all = [0, 1, 2, 3, 4, 5];
        let displacement = all.map(|k| found.displacement[k].unwrap_or(zero) + moved(k));
        let increment = all.map(|k| displacement[k] - Wide::from_f64(self.before[k].unwrap_or(0.0)));
        let of_velocity = |k: usize| match self.velocities {
            Velocities::Rates => found.velocity[k].unwrap_or(zero),
            // The velocity by itself, apart from the displacement.
            Velocities::Increments if matches!(by, By::Component(_)) => (increment[k] - moved(k)) / duration,
            Velocities::Increments => increment[k] / duration,
        };
        let faster = |k: usize| if by == By::Velocity(k) { h } else { zero };
        let motion = Motion {
            position: all.map(|k| found.position[k].unwrap_or(zero) + moved(k)),
            constitutive: all.map(|k| found.constitutive[k].unwrap_or(zero) + moved(k)),
            velocity: all.map(|k| if available[k] { of_velocity(k) + faster(k) } else { zero }),
        };
        let conditions = Conditions::default();
        let laws = element.behavior.behavior.forces(&motion, &conditions);
        let reaction =
            all.map(|k| Wide::from_f64(self.reactions[k]) + if by == By::Reaction(k) { h } else { zero });
        let pressing = all.map(|k| laws[k] + reaction[k]);
        let mut forces = pressing;
        let frictions: &[Friction] = &element.behavior.behavior.friction.frictions;
        for (friction, slip) in frictions.iter().zip(&self.result.behavior.as_ref().unwrap().slips) {
            let before = widened(slip.before.as_ref().unwrap());
            let input = Input {
                displacement: all.map(|k| if slip.components[k] { increment[k] } else { zero }),
                forces: pressing,
                duration: Some(duration),
                context: Context {
                    position: motion.position,
                    motion: motion.constitutive,
                    accumulated_slip: before.accumulated_slip,
                    conditions: &conditions,
                },
            };
            let outcome = friction.update(&before, &input, Branch::Decided);
            for k in (0..6).filter(|k| slip.components[*k]) {
                forces[k] += outcome.force[k];
            }
        }
        let rows = connector.force_rows(&state, &branch, [true; 6], Want::default(), &mut Tally::default());
        (forces, rows.nodal(&forces.map(Some)))
    }

    fn slope(&self, by: By) -> ([f64; 6], [f64; DOFS]) {
        let h = Wide::from_f64(1e-25);
        let (above, below) = (self.forces(by, h), self.forces(by, -h));
        let quotient = |above: Wide, below: Wide| ((above - below) / (h + h)).to_f64();
        (
            std::array::from_fn(|k| quotient(above.0[k], below.0[k])),
            std::array::from_fn(|j| quotient(above.1[j], below.1[j])),
        )
    }
}

/// Every scene, at rest or in motion, in stick and in slip.
fn each(mut judge: impl FnMut(&str, &Truth<'_>)) {
    let mut seen = BTreeMap::<String, usize>::new();
    for scene in SCENES {
        let model = model(scene);
        let element = &model.connectors[0];
        let outputs = ["TANGENT", "NF", "KG", "DNF", "KT", "CT", "KR", "CSF", "CRF", "CU"];
        let plan = Plan::compile(&model, &Selection::All, request(outputs, 0).unwrap()).unwrap();
        for (velocities, kind) in [(Velocities::Rates, "rates"), (Velocities::Increments, "increments")] {
            for amount in SECOND {
                let mut sequence = Sequence::new(&model, &plan);
                sequence.set_velocities(velocities);
                let states = states(element, amount);
                let before = sequence.step(&states[0]).connectors.remove(0);
                let result = sequence.step(&states[1]).connectors.remove(0);
                let outcome = result.behavior.as_ref().unwrap();
                let tangent = result.tangent.as_ref().unwrap();
                let place = format!("{}, {kind}, {amount}", scene.0);
                assert_eq!(tangent.unknown, [None; 6], "{place}");
                for slip in &outcome.slips {
                    let status = slip.outcome.as_ref().unwrap().status;
                    *seen.entry(format!("{status:?}")).or_default() += 1;
                }
                let laws = |k: usize| {
                    outcome.elastic.value[k].filter(|_| outcome.elastic.unknown[k].is_none()).unwrap_or(0.0)
                        + outcome.viscous.value[k].unwrap_or(0.0)
                        + outcome.friction.value[k].unwrap_or(0.0)
                };
                let is_rigid = element.behavior.behavior.elasticity.rigid();
                let reactions = [0, 1, 2, 3, 4, 5].map(|k| match tangent.reacting[k] {
                    true if is_rigid[k] => outcome.total.value[k].unwrap(),
                    true => outcome.total.value[k].unwrap() - laws(k),
                    // What is given where nothing of the model acts.
                    false
                        if [&outcome.elastic, &outcome.viscous, &outcome.friction]
                            .iter()
                            .all(|part| part.value[k].is_none() && part.unknown[k].is_none()) =>
                    {
                        outcome.total.value[k].unwrap_or(0.0)
                    }
                    false => 0.0,
                });
                let truth = Truth {
                    element,
                    connector: Connector::new(&element.definition()),
                    result: &result,
                    motions: [motion(0, 1, amount), motion(1, 1, amount)],
                    before: before.evaluation.displacement,
                    velocities,
                    reactions,
                };
                let nodal = result.forces.as_ref().unwrap().nodal.unwrap();
                let (_, exact) = truth.forces(By::Duration, Wide::from_f64(0.0));
                for j in (0..DOFS).filter(|j| element.connector.active()[*j]) {
                    let error = (nodal[j] - exact[j].to_f64()).abs();
                    assert!(
                        error < 1e-12 * (1.0 + nodal[j].abs()),
                        "{place}, force {j}: {} {:?}",
                        nodal[j],
                        exact[j]
                    );
                }
                judge(&place, &truth);
            }
        }
    }
    assert!(seen["Stick"] >= 8 && seen["Slip"] >= 8, "{seen:?}");
}

fn compare(place: &str, what: &str, got: f64, want: f64, scale: f64, allowed: f64) {
    let error = (got - want).abs() / scale;
    assert!(error <= allowed, "{place}, {what}: {got} {want}, {error:e} of {scale}");
}

/// The slopes of component forces by displacements, velocities, reactions and the time step.
#[test]
fn component_tangents_are_differences() {
    let mut unsymmetric = 0;
    each(|place, truth| {
        let tangent = truth.result.tangent.as_ref().unwrap();
        let all = tangent.displacement.iter().chain(&tangent.velocity).chain(&tangent.reaction).flatten();
        let scale = all.fold(1.0_f64, |most, slope| most.max(slope.abs()));
        for j in 0..6 {
            let by = [By::Component(j), By::Velocity(j), By::Reaction(j)].map(|by| truth.slope(by).0);
            for k in (0..6).filter(|k| truth.element.connector.has_force(*k)) {
                let what = |of: &str| format!("∂F{}/∂{of}{}", k + 1, j + 1);
                let available = truth.element.behavior.behavior.available();
                compare(place, &what("u"), tangent.displacement[k][j], by[0][k], scale, TANGENT);
                if available[j] {
                    compare(place, &what("v"), tangent.velocity[k][j], by[1][k], scale, TANGENT);
                }
                if tangent.reacting[j] {
                    compare(place, &what("λ"), tangent.reaction[k][j], by[2][k], scale, TANGENT);
                }
                unsymmetric += usize::from(k != j && tangent.reaction[k][j] != 0.0);
            }
        }
        let by_time = truth.slope(By::Duration).0;
        for (k, slope) in by_time.into_iter().enumerate() {
            compare(place, &format!("∂F{}/∂Δt", k + 1), tangent.time[k], slope, scale, TANGENT);
        }
    });
    assert!(unsymmetric > 20, "friction depends on reactions: {unsymmetric}");
}

/// ∂NF/∂q = KT − KG + DNF by nodal displacements, CT by nodal velocities, KR by reactions.
#[test]
fn nodal_tangents_are_differences() {
    each(|place, truth| {
        let forces = truth.result.forces.as_ref().unwrap();
        let parts = [&forces.tangent, &forces.geometric, &forces.derivative];
        let [Some(tangent), Some(geometric), Some(derivative)] = parts else {
            panic!("{place}: {:?}", forces.flags)
        };
        let scale = tangent.iter().flatten().fold(1.0_f64, |most, entry| most.max(entry.abs()));
        let active = *truth.element.connector.active();
        for j in (0..DOFS).filter(|j| active[*j]) {
            let by_place = truth.slope(By::Node(j)).1;
            let by_rate = truth.slope(By::Rate(j)).1;
            for i in (0..DOFS).filter(|i| active[*i]) {
                let got = tangent[i][j] - geometric[i][j] + derivative[i][j];
                compare(place, &format!("∂NF{i}/∂q{j}"), got, by_place[i], scale, NODAL_TANGENT);
                if let Some(damping) = &forces.damping {
                    compare(place, &format!("∂NF{i}/∂v{j}"), damping[i][j], by_rate[i], scale, NODAL_TANGENT);
                }
            }
        }
        assert_eq!(forces.damping.is_some(), truth.velocities == Velocities::Rates, "{place}");
        for k in 0..6 {
            let Some(column) = forces.by_reactions[k] else { continue };
            let by_reaction = truth.slope(By::Reaction(k)).1;
            for i in (0..DOFS).filter(|i| active[*i]) {
                compare(place, &format!("∂NF{i}/∂λ{k}"), column[i], by_reaction[i], scale, NODAL_TANGENT);
            }
        }
    });
}

/// Friction under a spring that is not known, and whose force is given, has a value; its slope would lack that of the spring, and is
/// not known.
#[test]
fn slopes_of_friction_need_those_of_what_presses() {
    let behavior = |dependencies: &str, rows: &str| {
        format!(
            "*CONNECTOR ELASTICITY, COMPONENT=2{dependencies}\n{rows}\n\
             *CONNECTOR FRICTION, COMPONENT=1, CONTACT FORCE=2, STICK STIFFNESS=40.\n*FRICTION\n0.4\n"
        )
    };
    let slopes = |behavior: &str| {
        let model = model(("pressed", "CARTESIAN, CARDAN\nO,", behavior, ""));
        let plan = Plan::compile(&model, &Selection::All, request(["CSF", "TANGENT"], 0).unwrap()).unwrap();
        let moved = NodeMotion { displacement: [0.5, 0.25, 0.0], ..NodeMotion::default() };
        let total = [0.0, 3.0, 0.0, 0.0, 0.0, 0.0].map(Some);
        let state = SceneState {
            nodes: [(2.into(), moved)].into(),
            forces: [(7.into(), ElementForces { total, ..ElementForces::default() })].into(),
            ..SceneState::default()
        };
        let result = Sequence::new(&model, &plan).step(&state).connectors.remove(0);
        let slip = result.behavior.unwrap().slips[0].outcome.clone();
        assert!(slip.unwrap().force[0] != 0.0);
        result.tangent.unwrap()
    };
    let known = slopes(&behavior("", "8."));
    assert!(known.unknown[0].is_none() && known.displacement[0][1] != 0.0, "{known:?}");
    let unknown = slopes(&behavior(", DEPENDENCIES=1", "8., , 1.\n9., , 2."));
    assert!(unknown.unknown[0].is_some() && unknown.displacement[0] == [0.0; 6], "{unknown:?}");
    // What does not press may be unknown; a rigid component has no slope that one could miss.
    let beside = |law: &str| slopes(&format!("*CONNECTOR ELASTICITY, {law}\n{}", behavior("", "8.")));
    let heated = beside("COMPONENT=3\n8., , 10.\n9., , 30.");
    assert_eq!((heated.unknown[0], heated.unknown[2]), (None, Some(Unknown::Temperature)));
    assert_eq!((heated.displacement[0], heated.displacement[2]), (known.displacement[0], [0.0; 6]));
    assert_eq!(beside("RIGID\n3").unknown, [None; 6]);
}
