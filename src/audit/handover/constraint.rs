//! A counter-example of a multi-point constraint as a test in Rust, as a script for JAX, as a deck.

use super::deck::{Deck, Difference, three_of};
use super::jax::{FORMULAS, VERDICT, text};
use super::{ExportError, list, matrix, number, vector};
use crate::audit::invariant::Invariant;
use crate::audit::mpc::MpcCase;
use crate::audit::quantity::Quantity;
use crate::audit::recorded::Recorded;
use crate::audit::scene::{Target, last_constraints};
use crate::connector::{Request, Tally};
use crate::evaluate::{Model, Plan, Selection};
use crate::mpc::{Body, DOFS, Evaluation, Kind, PHI, ROWS, State, Translation};
use crate::scene::{Label, NodeMotion, Rotation, Scene, State as SceneState, StateFile};
use crate::so3;
use crate::vector::{Matrix, Vector, dot};

/// The formulas of constraints, a second time.
const CONSTRAINTS: &str = include_str!("../../../scripts/reference_mpc_formulas.py");

/// What the script does with the state, after formulas and values.
const JUDGES: &str = include_str!("judge_mpc.py");

/// The square of a length is one to within this: far above rounding, far below what matters.
const UNIT: f64 = 1e-9;

/// One number of a constraint: its kind, equation and place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::audit) struct Place {
    quantity: Quantity,
    row: usize,
    i: usize,
}

impl Place {
    /// Every number of a constraint with these equations.
    fn all(quantity: Quantity, rows: [bool; ROWS]) -> impl Iterator<Item = Self> {
        let count = match quantity {
            Quantity::FirstDerivatives => DOFS,
            Quantity::SecondDerivatives => DOFS * DOFS,
            _ => 1,
        };
        let rows = (0..ROWS).filter(move |row| rows[*row]);
        rows.flat_map(move |row| (0..count).map(move |i| Self { quantity, row, i }))
    }

    /// Its name: `∂ρ1/∂θS2`.
    fn name(self, kind: Kind) -> String {
        let (row, column) = (kind.row_name(self.row), |j: usize| kind.column_name(j));
        match self.quantity {
            Quantity::FirstDerivatives => format!("∂{row}/∂{}", column(self.i)),
            Quantity::SecondDerivatives => {
                format!("∂²{row}/∂{}∂{}", column(self.i / DOFS), column(self.i % DOFS))
            }
            Quantity::Rate => format!("d{row}/dt"),
            Quantity::Acceleration => format!("d²{row}/dt²"),
            _ => row.to_string(),
        }
    }

    /// The number in an evaluation.
    fn of(self, found: &Evaluation<f64>) -> Option<f64> {
        let Self { quantity, row, i } = self;
        match quantity {
            Quantity::Value => found.residual.get(row).copied()?,
            Quantity::FirstDerivatives => found.jacobian.get(row)?.as_ref()?.get(i).copied(),
            Quantity::SecondDerivatives => found.hessian.get(row)?.as_ref()?.as_flattened().get(i).copied(),
            Quantity::Rate => found.residual_rate.get(row).copied()?,
            Quantity::Acceleration => found.residual_acceleration.get(row).copied()?,
            _ => None,
        }
    }

    /// The expression of it in Rust.
    fn taken(self) -> String {
        let Self { quantity, row, i } = self;
        match quantity {
            Quantity::FirstDerivatives => format!("found.jacobian[{row}].unwrap()[{i}]"),
            Quantity::SecondDerivatives => {
                format!("found.hessian[{row}].as_ref().unwrap()[{}][{}]", i / DOFS, i % DOFS)
            }
            Quantity::Rate => format!("found.residual_rate[{row}].unwrap()"),
            Quantity::Acceleration => format!("found.residual_acceleration[{row}].unwrap()"),
            _ => format!("found.residual[{row}].unwrap()"),
        }
    }
}

/// The numbers at the state, judged.
fn evaluated(case: &MpcCase) -> Evaluation<f64> {
    let request = Request::everything(2);
    case.constraint.evaluate(&case.state, &case.before, &case.turning, &request, &mut Tally::default())
}

/// The number of that name.
pub(super) fn place(recorded: &Recorded, case: &MpcCase) -> Option<Place> {
    let mut all = Place::all(recorded.quantity?, case.constraint.rows());
    all.find(|place| place.name(case.constraint.kind()) == recorded.entry)
}

/// The law that is broken, where it was compared with one.
pub(super) fn law(recorded: &Recorded) -> Option<Invariant> {
    Invariant::ALL.into_iter().find(|law| recorded.quantity.is_none() && law.name() == recorded.against)
}

/// The number in question, as the constraint gives it; of a law the sum that it speaks of.
pub(super) fn got(recorded: &Recorded, case: &MpcCase) -> Option<f64> {
    match law(recorded) {
        Some(law) => case.sum_of_law(law, &recorded.entry),
        None => place(recorded, case)?.of(&evaluated(case)),
    }
}

fn body(body: &Body<f64>) -> String {
    let (displacement, rotation) = (vector(&body.displacement), matrix(&body.rotation));
    format!("Body {{ displacement: {displacement}, rotation: {rotation}, flow: {} }}", number(body.flow))
}

/// The statements that lead to `got`, the number at a place.
pub(super) fn rust(case: &MpcCase, place: Place) -> String {
    let kind = case.constraint.kind();
    let name = kind.name().to_lowercase();
    let (first, rest) = name.split_at(1);
    let axes = case.constraint.axes();
    let flow = if case.constraint.has_flow() { ".with_flow()" } else { "" };
    let State { slave, master, angles, velocity, acceleration } = &case.state;
    let angle = |angle: Option<f64>| angle.map_or("None".into(), |x| format!("Some({})", number(x)));
    format!(
        "    let constraint = Constraint::<f64>::with_axes(\n        Kind::{}{rest},\n        {},\n        [{}, {}],\n    ){flow};\n    \
         let state = State {{\n        slave: {},\n        master: {},\n        angles: [{}, {}],\n        velocity: {},\n        \
         acceleration: {},\n    }};\n    let start = [Turns {{ turns: 0.0, principal: 0.0 }}; 2];\n    \
         let asked = Request::everything(2);\n    \
         let found = constraint.evaluate(&state, &start, &Turning::none(), &asked, &mut Tally::default());\n    \
         let got: f64 = {};\n",
        first.to_uppercase(),
        vector(&case.constraint.arm()),
        vector(&axes[0]),
        vector(&axes[1]),
        body(slave),
        body(master),
        angle(angles[0]),
        angle(angles[1]),
        list(velocity),
        list(acceleration),
        place.taken()
    )
}

/// What a test of a constraint uses of the crate.
pub(super) const IMPORTS: &str = "use pintle::connector::{Request, Tally, Turns};\nuse pintle::mpc::{Body, Constraint, Kind, State, Turning};\n";

/// A script for Python with JAX and NumPy.
pub(super) fn jax(recorded: &Recorded, case: &MpcCase, place: Place) -> String {
    let Place { quantity, row, i } = place;
    let above = case.constraint.rows().iter().take(row).filter(|row| **row).count();
    // The 17th variable is time.
    let place = match quantity {
        Quantity::FirstDerivatives => format!("({above}, {i})"),
        Quantity::SecondDerivatives => format!("({above}, {}, {})", i / DOFS, i % DOFS),
        Quantity::Rate => format!("({above}, {DOFS})"),
        Quantity::Acceleration => format!("({above}, {DOFS}, {DOFS})"),
        _ => format!("({above},)"),
    };
    let State { slave, master, angles, velocity, acceleration } = &case.state;
    let axes = case.constraint.axes();
    let angle = |angle: Option<f64>| angle.map_or("None".into(), number);
    let mut script = String::from(FORMULAS);
    // One file has no other to import from.
    let formulas = CONSTRAINTS.lines().filter(|line| !line.starts_with("from reference_formulas import"));
    script.push_str("\n\n");
    script.extend(formulas.flat_map(|line| [line, "\n"]));
    script.push_str(&format!(
        "\n\n# The state of the counter-example\n\nABOUT = {}\nKIND, PLACE = {}, {place}\n\
         GIVEN = float({:?})\nWANTED = float({:?})\nTOLERANCE = float({:?})\n",
        text(&super::about(&recorded.heading(), recorded)),
        text(case.constraint.kind().name()),
        number(recorded.got.0),
        number(recorded.want.0),
        number(recorded.tolerance.0)
    ));
    script.push_str(&format!(
        "PLACES = [{}, [0.0, 0.0, 0.0], {}, {}]\n\
         STATE = {{\"u_S\": {}, \"psi_S\": {}, \"u_M\": {}, \"psi_M\": {}}}\n\
         ROTATIONS = {{\"S\": {}, \"M\": {}}}\nANGLES = [{}, {}]\nRATES = {}\nACCELERATIONS = {}\n\n\n",
        vector(&case.constraint.arm()),
        vector(&axes[0]),
        vector(&axes[1]),
        vector(&slave.displacement),
        number(slave.flow),
        vector(&master.displacement),
        number(master.flow),
        matrix(&slave.rotation),
        matrix(&master.rotation),
        angle(angles[0]),
        angle(angles[1]),
        list(velocity),
        list(acceleration)
    ));
    script.push_str(JUDGES);
    script.push_str(VERDICT);
    script
}

/// The model: M at the origin, S and the nodes of hinges where its arm and axes lead.
fn model(case: &MpcCase) -> String {
    let constraint = &case.constraint;
    let kind = constraint.kind();
    let items = |all: &[f64]| list(all).trim_matches(['[', ']']).to_string();
    let mut text = format!("*NODE\n1, {}\n2, 0., 0., 0.\n", items(&constraint.arm()));
    let hinges = constraint.initial_axes();
    for (n, axis) in hinges.iter().flatten().enumerate() {
        text.push_str(&format!("{}, {}\n", n + 3, items(axis)));
    }
    let nodes: Vec<String> = (1..=kind.entry().nodes.len()).map(|node| node.to_string()).collect();
    text.push_str(&format!("*MPC\n{}, {}\n", kind.name(), nodes.join(", ")));
    if constraint.has_flow() {
        text.push_str(
            "** Connectors that give both nodes a material flow\n*ELEMENT, TYPE=CONN3D2, ELSET=FLOW\n1, 2, 1\n2, 1, 2\n\
             *ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*CONNECTOR SECTION, ELSET=FLOW\nFLOW-CONVERTER\nO,\n",
        );
    }
    text
}

/// The state judged, by the nodes of that model.
fn state(case: &MpcCase) -> SceneState {
    let State { slave, master, angles, velocity, acceleration } = &case.state;
    let kind = case.constraint.kind();
    let turns = kind.entry().hinges.is_some() || kind.entry().translation == Translation::Carried;
    let has_flow = case.constraint.has_flow();
    let rotation = |of: &Matrix<f64>| {
        if *of == crate::vector::identity::<f64>() {
            Rotation::default()
        } else {
            Rotation::Quaternion(so3::normalize(so3::quaternion(of)))
        }
    };
    let mut found = SceneState::default();
    for (n, body) in [slave, master].into_iter().enumerate() {
        let at = n * PHI / 2;
        let rates = |all: &[f64; DOFS], from: usize| three_of(all, at + from);
        let flow = |x: f64| if has_flow { x } else { 0.0 };
        let angular = |all: &[f64; DOFS]| if turns { rates(all, 3) } else { [0.0; 3] };
        let motion = NodeMotion {
            displacement: body.displacement,
            rotation: if turns { rotation(&body.rotation) } else { Rotation::default() },
            velocity: rates(velocity, 0),
            angular_velocity: angular(velocity),
            acceleration: rates(acceleration, 0),
            angular_acceleration: angular(acceleration),
            flow: flow(body.flow),
            flow_velocity: flow(velocity[at + 6]),
            flow_acceleration: flow(acceleration[at + 6]),
        };
        found.nodes.insert(Label::from(n as u64 + 1), motion);
    }
    for (n, angle) in angles.iter().take(kind.entry().angles.len()).enumerate() {
        let motion = NodeMotion {
            // A quaternion leaves the angle to the rotations.
            rotation: angle.map_or(Rotation::Quaternion([1.0, 0.0, 0.0, 0.0]), |angle| {
                Rotation::Vector([0.0, 0.0, angle])
            }),
            angular_velocity: [0.0, 0.0, velocity[PHI + n]],
            angular_acceleration: [0.0, 0.0, acceleration[PHI + n]],
            ..NodeMotion::default()
        };
        found.nodes.insert(Label::from(n as u64 + 3), motion);
    }
    found
}

/// A deck with the constraint, and its state.
pub(super) fn deck(recorded: &Recorded, case: &MpcCase) -> Result<Deck, ExportError> {
    let is_unit = |axis: &Vector<f64>| (dot(*axis, *axis) - 1.0).abs() < UNIT;
    if !case.constraint.initial_axes().iter().flatten().all(is_unit) {
        return Err(ExportError::Lost(
            "an axis of its hinges is not of unit length, and a deck gives only the direction".into(),
        ));
    }
    let model = model(case);
    let lost =
        |error: &dyn std::fmt::Display| ExportError::Lost(format!("its state cannot be written: {error}"));
    let states = StateFile { states: vec![state(case)] }.to_json().map_err(|error| lost(&error))?;
    let scene = Scene::parse("the deck", &model)?;
    let read = StateFile::parse_json("its state", &states, &scene)?;
    let compiled = Model::compile(&scene)?;
    let plan =
        Plan::compile(&compiled, &Selection::All, Request::nothing(0)).map_err(|error| lost(&error))?;
    let target = Target { name: "the deck", model: &compiled, plan: &plan, states: &read.states };
    let again = last_constraints(&target).pop();
    let again = again.ok_or_else(|| ExportError::Lost("the deck has no constraint".to_string()))?;
    if again.constraint.rows() != case.constraint.rows() {
        return Err(ExportError::Lost(
            "its nodes have degrees of freedom that they would not have in a deck".into(),
        ));
    }
    let (was, is) = (evaluated(case), evaluated(&again));
    let differences = MpcCase::QUANTITIES.map(|quantity| {
        let gaps =
            Place::all(quantity, case.constraint.rows()).map(|place| match (place.of(&was), place.of(&is)) {
                (Some(x), Some(y)) if x.to_bits() == y.to_bits() || x == y => 0.0,
                (Some(x), Some(y)) if (x - y).is_finite() => (x - y).abs(),
                _ => f64::INFINITY,
            });
        Difference { quantity, largest: gaps.fold(0.0, f64::max) }
    });
    Ok(Deck::new(
        &super::about(&recorded.heading(), recorded),
        recorded.numbers(),
        &model,
        states,
        differences.into(),
    ))
}
