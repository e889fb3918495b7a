//! The same motion in every form of input: quaternions, and rotation vectors on any sheet, give the same numbers.

use super::{Check, functions};
use crate::scale::chain;
use pintle_kinematics::connector::{Flag, Output, Request};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::so3::Quaternion;
use pintle_kinematics::vector::{Vector, scale};
use pintle_model::evaluate::{Model, Plan, Selection, Sequence, StepResult};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State};
use std::f64::consts::{PI, TAU};

const STATES: usize = 120;

/// How a rotation is written.
#[derive(Clone, Copy, Debug)]
enum Form {
    Quaternion,
    Continued,
    BelowHalfATurn,
    BelowATurn,
    /// Vectors in one state, quaternions in the next.
    Mixed,
}

const FORMS: [Form; 4] = [Form::Continued, Form::BelowHalfATurn, Form::BelowATurn, Form::Mixed];

/// A node that turns about no fixed axis.
#[derive(Clone, Copy)]
struct Turning {
    quaternion: Quaternion<f64>,
    continued: Vector<f64>,
}

impl Turning {
    /// Turns on by an increment, in pieces.
    fn on(&mut self, increment: Vector<f64>) {
        const PIECES: usize = 64;
        let piece = so3::exp_quaternion(scale(increment, 1.0 / PIECES as f64));
        for _ in 0..PIECES {
            self.quaternion = so3::normalize(so3::compose(piece, self.quaternion));
            self.continued = so3::continuous_log_quaternion(self.quaternion, self.continued).phi;
        }
    }

    fn written(&self, form: Form, number: usize) -> Rotation {
        let short = so3::log_quaternion(self.quaternion);
        match form {
            Form::Quaternion => Rotation::Quaternion(self.quaternion),
            Form::Mixed if number.is_multiple_of(2) => Rotation::Quaternion(self.quaternion),
            Form::Continued | Form::Mixed => Rotation::Vector(self.continued),
            Form::BelowHalfATurn => Rotation::Vector(short),
            // Either of the two, in turn.
            Form::BelowATurn if number.is_multiple_of(3) => Rotation::Vector(short),
            Form::BelowATurn => Rotation::Vector(scale(short, 1.0 - TAU / norm(short))),
        }
    }
}

/// Where node `node` is at state `number`, and by how much it has turned since the last: between 0.2 and 1.4 rad, about an axis that
/// wanders.
fn motion(number: usize, node: usize) -> (Vector<f64>, Vector<f64>) {
    let (time, phase) = (0.37 * number as f64, 1.7 * node as f64);
    let wave = |rate: f64| (rate * time + phase).sin();
    let axis = [wave(0.31) + 0.2, wave(0.53), wave(0.7) - 0.4];
    let turn = scale(axis, (0.8 + 0.6 * wave(1.9)) / norm(axis));
    ([0.05 * wave(1.0), 0.04 * wave(1.3), 0.03 * wave(0.7)], turn)
}

/// The results of every type in a chain, state by state, in one form; and how many increments continued vectors do not show.
fn run(form: Form) -> (Vec<StepResult>, Model, usize) {
    let types = chain::types();
    let nodes = types.len() + 1;
    let joint = "*NODE, NSET=ALL\n9001, 3., 2., 1.\n*MPC\nREVOLUTE, 1, 2, 9001\n";
    let deck = chain::deck(types.len(), &types, joint);
    let scene = Scene::parse("chain.inp", &deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    let request = Request::new(&[Output::CP, Output::CU, Output::RES], [true; 6], 1);
    let plan = Plan::compile(&model, &Selection::All, request).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    let mut turning = vec![Turning { quaternion: [1.0, 0.0, 0.0, 0.0], continued: [0.0; 3] }; nodes];
    let mut hidden = 0;
    let results = (0..STATES).map(|number| {
        let mut state = State { time: Some(number as f64), ..State::default() };
        for (at, node) in turning.iter_mut().enumerate() {
            let (displacement, increment) = motion(number, at);
            let before = node.continued;
            node.on(increment);
            let jump = norm([0, 1, 2].map(|i| node.continued[i] - before[i]));
            hidden += usize::from(jump > PI);
            let rotation = node.written(form, number);
            let moved = NodeMotion { displacement, rotation, ..NodeMotion::default() };
            state.nodes.insert(Label::from(at as u64 + 1), moved);
        }
        walk.step(&state)
    });
    (results.collect(), model, hidden)
}

/// Every type and the MPC REVOLUTE. The scale knows that a longer vector has a larger rounding, and that what is accumulated keeps it.
#[test]
fn every_form_of_input_gives_the_same_numbers() {
    let mut check = Check::of("forms of input");
    let (want, model, hidden) = run(Form::Quaternion);
    assert!(hidden > 100, "continued vectors swing to the other side {hidden} times");
    for form in FORMS {
        let (got, ..) = run(form);
        for (number, (got, want)) in got.iter().zip(&want).enumerate() {
            for (got, want) in got.connectors.iter().zip(&want.connectors) {
                let place = |c: usize| {
                    format!("{form:?}, {number}, {}, {}", model.connectors[want.index].title(), c + 1)
                };
                let [values, wanted] = [got, want].map(|one| functions(&one.evaluation));
                for c in 0..6 {
                    let (Some(x), Some(y)) = (values[c], wanted[c]) else { continue };
                    let rows = want.evaluation.jacobian[c].unwrap();
                    let slope: f64 = rows.iter().map(|entry| entry.abs()).sum();
                    check.against(|| place(c), x, y, (y.abs() + slope) * (1.0 + number as f64));
                }
                let large =
                    |flags: &[Flag]| flags.iter().filter(|flag| flag.name() == "large-increment").count();
                assert_eq!(large(&got.flags), large(&want.flags), "{}", place(0));
            }
            for (got, want) in got.mpcs.iter().zip(&want.mpcs) {
                for (x, y) in got.evaluation.angles.iter().zip(&want.evaluation.angles) {
                    let place = || format!("{form:?}, {number}, MPC");
                    let angle = |turns: &pintle_kinematics::connector::Turns<f64>| {
                        TAU.mul_add(turns.turns, turns.principal)
                    };
                    check.against(place, angle(x), angle(y), (1.0 + angle(y).abs()) * (1.0 + number as f64));
                }
            }
        }
    }
    check.finish();
}

/// A rotation vector beside a whole turn keeps its sheet, and is ill-conditioned there; beside none it is not.
#[test]
fn beside_whole_turns_rotation_vectors_are_ill_conditioned() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nROTATION\nO,\n";
    let model = Model::compile(&Scene::parse("rotation.inp", deck).unwrap()).unwrap();
    let plan = Plan::compile(&model, &Selection::All, Request::new(&[Output::CP], [true; 6], 1)).unwrap();
    let mut walk = Sequence::new(&model, &plan);
    for (angle, flagged) in
        [(0.05, 0), (2.9, 0), (5.6, 0), (6.25, 3), (TAU + 0.07, 3), (6.5, 0), (9.2, 0), (12.5, 3)]
    {
        let rotation = Rotation::Vector([0.0, 0.6 * angle, 0.8 * angle]);
        let moved = NodeMotion { rotation, ..NodeMotion::default() };
        let state = State { nodes: [(Label::from(2), moved)].into(), ..State::default() };
        let flags = walk.step(&state).connectors.remove(0).flags;
        let found = flags.iter().filter(|flag| flag.name() == "ill-conditioned").count();
        assert_eq!(found, flagged, "{angle}: {flags:?}");
    }
}
