//! A counter-example as a deck, with its states.

use crate::case::Case;
use crate::case::quantity::{Quantity, request};
use crate::product;
use crate::replay::counterexample::CounterExample;
use crate::replay::handover::{ExportError, about, list};
use crate::scene::{Target, last_cases};
use pintle_kinematics::catalog::{Class, Orientation};
use pintle_kinematics::connector::{Branch, Definition, Evaluation};
use pintle_kinematics::node::{DOFS, Node};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, add, column, product as times, scale, transpose};
use pintle_model::evaluate::{Model, Plan, Selection};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State, StateFile};

/// Below it, an increment of rotation leads back to the initial orientation: far above rounding, far below any turn.
const SAME: f64 = 1e-9;

/// What a deck and its states say, and by how much its numbers miss those of the counter-example.
#[derive(Clone, Debug)]
pub struct Deck {
    /// The deck.
    pub text: String,
    /// Its states, in the form of `--states`.
    pub states: String,
    /// Of each kind of number.
    pub differences: Vec<Difference>,
}

/// The largest difference between numbers of one kind, of the deck and of the counter-example, in the unit of the number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// The kind of number.
    pub quantity: Quantity,
    /// 0 where all have the same bits.
    pub largest: f64,
}

/// The rotation of one node, state by state.
struct Turning {
    initial: Matrix<f64>,
    /// The total rotation vector of the state before.
    total: Vector<f64>,
    counts_turns: bool,
}

impl Turning {
    /// The total rotation that gives the triad, `by` after the state before.
    fn to(&mut self, triad: &Matrix<f64>, by: Vector<f64>) -> Rotation {
        let total = times(triad, &transpose(&self.initial));
        if !self.counts_turns && *triad == self.initial {
            return Rotation::default();
        }
        if !self.counts_turns {
            return Rotation::Quaternion(so3::normalize(so3::quaternion(&total)));
        }
        self.total = so3::continuous_log(&total, add(self.total, by)).phi;
        Rotation::Vector(self.total)
    }
}

/// exp(−Δθ^) C: the triad before an increment.
fn before(triad: &Matrix<f64>, by: Vector<f64>) -> Matrix<f64> {
    times(&so3::matrix(so3::exp_quaternion(scale(by, -1.0))), triad)
}

fn is_near(a: &Matrix<f64>, b: &Matrix<f64>) -> bool {
    a.as_flattened().iter().zip(b.as_flattened()).all(|(a, b)| (a - b).abs() <= SAME)
}

/// Three numbers of a list, from a place on.
fn three_of(all: &[f64], at: usize) -> Vector<f64> {
    std::array::from_fn(|i| all.get(at + i).copied().unwrap_or_default())
}

fn motion(node: &Node<f64>, rotation: Rotation, velocity: &[f64], acceleration: &[f64]) -> NodeMotion {
    let three = three_of;
    let flow = |all: &[f64]| all.get(6).copied().unwrap_or_default();
    NodeMotion {
        displacement: node.displacement,
        rotation,
        velocity: three(velocity, 0),
        angular_velocity: three(velocity, 3),
        acceleration: three(acceleration, 0),
        angular_acceleration: three(acceleration, 3),
        flow: node.flow,
        flow_velocity: flow(velocity),
        flow_acceleration: flow(acceleration),
    }
}

/// The states that lead to the one judged. Where a branch is all that is known of those before, the one just before is
/// the only one of them.
fn states(case: &Case) -> StateFile {
    let initial = &case.definition.initial;
    let whole = |end: usize| {
        let mut steps = case.path.iter();
        steps.any(|step| step.increment.whole_turns[end] != [0.0; 3])
    };
    let turning = |end: usize, triad: Matrix<f64>| Turning {
        initial: triad,
        total: [0.0; 3],
        counts_turns: whole(end),
    };
    let mut turnings = [turning(0, initial.a.triad), turning(1, initial.b.triad)];
    let mut found = StateFile::default();
    let mut put = |nodes: [(&Node<f64>, Vector<f64>); 2],
                   velocity: &[f64; DOFS],
                   acceleration: &[f64; DOFS]| {
        let mut state = State::default();
        for (end, (node, by)) in nodes.into_iter().enumerate() {
            if case.definition.moves[end] {
                let rotation = turnings[end].to(&node.triad, by);
                let rates = |all: &[f64; DOFS]| all.iter().skip(end * DOFS / 2).copied().collect::<Vec<_>>();
                let moved = motion(node, rotation, &rates(velocity), &rates(acceleration));
                state.nodes.insert(Label::from(end as u64 + 1), moved);
            }
        }
        found.states.push(state);
    };
    if let (Some(_), Some(first)) = (&case.start, case.path.first()) {
        let mut pair = first.state.pair;
        let [by_a, by_b] = first.increment.rotation;
        for (node, by, flow) in
            [(&mut pair.a, by_a, first.increment.flow[0]), (&mut pair.b, by_b, first.increment.flow[1])]
        {
            node.triad = before(&node.triad, by);
            node.flow -= flow;
        }
        let is_initial =
            |now: &Node<f64>, was: &Node<f64>| is_near(&now.triad, &was.triad) && now.flow == was.flow;
        if !(is_initial(&pair.a, &initial.a) && is_initial(&pair.b, &initial.b)) {
            put([(&pair.a, [0.0; 3]), (&pair.b, [0.0; 3])], &[0.0; DOFS], &[0.0; DOFS]);
        }
    }
    for step in &case.path {
        let [by_a, by_b] = step.increment.rotation;
        let pair = &step.state.pair;
        put([(&pair.a, by_a), (&pair.b, by_b)], &step.state.velocity, &step.state.acceleration);
    }
    found
}

/// The model: two nodes, of which the first stands at the origin, and the connector.
fn model(definition: &Definition) -> String {
    let types = match definition.connection.halves {
        [Some(t), Some(r)] => format!("{}, {}", t.name, r.name),
        _ => definition.connection.name.to_string(),
    };
    let items = |all: &[f64]| {
        let text = list(all);
        text.trim_matches(['[', ']']).to_string()
    };
    let has = |end: usize| definition.connection.orientation[end].orientation != Orientation::Ignored;
    let triads = [&definition.initial.a.triad, &definition.initial.b.triad];
    let mut text = format!("*NODE\n1, 0., 0., 0.\n2, {}\n", items(&definition.initial.reference));
    for (end, name) in ["OA", "OB"].into_iter().enumerate().filter(|(end, _)| has(*end)) {
        let (e1, e2) = (column(triads[end], 0), column(triads[end], 1));
        text.push_str(&format!("*ORIENTATION, NAME={name}\n{}, {}\n", items(&e1), items(&e2)));
    }
    let element = if definition.planar { "CONN2D2" } else { "CONN3D2" };
    let node = |end: usize| if definition.moves[end] { (end + 1).to_string() } else { String::new() };
    text.push_str(&format!("*ELEMENT, TYPE={element}, ELSET=CONNECTOR\n1, {}, {}\n", node(0), node(1)));
    let stops = definition.stops.iter().enumerate().filter_map(|(k, stop)| Some((k, stop.as_ref()?)));
    let bound = |x: Option<f64>| x.map_or_else(String::new, |x| format!("{x:?}"));
    let stops: Vec<String> = stops
        .map(|(k, stop)| {
            format!("*CONNECTOR STOP, COMPONENT={}\n{}, {}\n", k + 1, bound(stop.lower), bound(stop.upper))
        })
        .collect();
    let references: Vec<String> = definition.references.iter().map(|x| bound(*x)).collect();
    let refers = definition.references.iter().any(Option::is_some);
    let behaves = refers || !stops.is_empty();
    let behavior = if behaves { ", BEHAVIOR=REFERENCES" } else { "" };
    let orientation = |end: usize| ["OA", "OB"].into_iter().nth(end).filter(|_| has(end)).unwrap_or_default();
    let [a, b] = [orientation(0), orientation(1)];
    text.push_str(&format!("*CONNECTOR SECTION, ELSET=CONNECTOR{behavior}\n{types}\n{a}, {b}\n"));
    let connection = &definition.connection;
    let winds_flow = connection.flow[1] && connection.class != Class::Complex;
    if winds_flow && definition.flow_scale != 1.0 {
        text.push_str(&format!("{:?}\n", definition.flow_scale));
    }
    if behaves {
        text.push_str("*CONNECTOR BEHAVIOR, NAME=REFERENCES\n");
    }
    if refers {
        text.push_str(&format!("*CONNECTOR CONSTITUTIVE REFERENCE\n{}\n", references.join(", ")));
    }
    text.extend(stops);
    let turning: Vec<usize> =
        (0..2).filter(|end| definition.moves[*end] && definition.rotates[*end]).collect();
    if !turning.is_empty() {
        text.push_str(
            "** Nodes that turn, whatever the connector needs\n*ELEMENT, TYPE=ROTARYI, ELSET=TURNING\n",
        );
        text.extend(turning.iter().map(|end| format!("{}, {}\n", end + 11, end + 1)));
        text.push_str("*ROTARY INERTIA, ELSET=TURNING\n1., 1., 1.\n");
    }
    text
}

/// What the histories decide that differs.
fn otherwise(a: &Case, b: &Case) -> Option<&'static str> {
    let (one, other) = (a.evaluation(&request())?.0, b.evaluation(&request())?.0);
    let turns = |branch: &Branch<f64>| {
        [branch.turns.map(|turns| turns.turns).to_vec(), vec![branch.torsion.turns]].concat()
    };
    let sum = |branch: &Branch<f64>| branch.accumulated + branch.accumulated_rest;
    // Rotation vectors of the same rotation on two sheets are a whole turn apart, one of them at least half a turn long.
    let angles = |evaluation: &Evaluation<f64>| evaluation.displacement.map(Option::unwrap_or_default);
    let mut angles = angles(&one).into_iter().zip(angles(&other)).skip(3);
    let (left, right) = (&one.branch, &other.branch);
    if turns(left) != turns(right) {
        Some("another number of whole turns")
    } else if left.euler_sign != right.euler_sign {
        Some("the other side of the Euler angles")
    } else if (sum(left) - sum(right)).abs() > SAME * (1.0 + sum(left).abs()) {
        Some("another sum of the turns of the drum")
    } else if angles.any(|(x, y)| (x - y).abs() > 1.0) {
        Some("another sheet of an angle")
    } else {
        None
    }
}

fn differences(a: &Case, b: &Case) -> Vec<Difference> {
    let (Some(a), Some(b)) = (product(a), product(b)) else { return Vec::new() };
    let mut found = Vec::new();
    for quantity in Quantity::ALL {
        let (mut largest, mut any) = (0.0_f64, false);
        for (k, i, x) in a.entries(quantity).iter() {
            any = true;
            let y = b.entries(quantity).get(k, i).unwrap_or(f64::NAN);
            let gap = if x.to_bits() == y.to_bits() || x == y { 0.0 } else { (x - y).abs() };
            largest = if gap.is_nan() { f64::INFINITY } else { largest.max(gap) };
        }
        if any {
            found.push(Difference { quantity, largest });
        }
    }
    found
}

impl CounterExample {
    /// A deck of two nodes and the connector, and states that lead to the one in question. Decks and states give orientations by
    /// points and rotations, not by triads: where these do not give the same triads to the last bit, a comment of the deck says by how
    /// much its numbers differ.
    ///
    /// # Errors
    /// What cannot be replayed, what decks cannot say, and a history that cannot be told from the states known.
    pub(crate) fn deck_of_connector(&self, case: &Case) -> Result<Deck, ExportError> {
        let initial = &case.definition.initial;
        if [&initial.a, &initial.b].iter().any(|node| node.displacement != [0.0; 3] || node.flow != 0.0) {
            return Err(ExportError::Lost(
                "its initial state is displaced; that of a deck is not".to_string(),
            ));
        }
        let model = model(&case.definition);
        let states = states(case);
        let lost = |error: &dyn std::fmt::Display| {
            ExportError::Lost(format!("its states cannot be written: {error}"))
        };
        let states = states.to_json().map_err(|error| lost(&error))?;
        let again = read(&model, &states)?;
        let (was, is) = (&case.definition, &again.definition);
        if (was.planar, was.moves, was.rotates) != (is.planar, is.moves, is.rotates) {
            let message = "its nodes have degrees of freedom that they would not have in a deck";
            return Err(ExportError::Lost(message.to_string()));
        }
        if let Some(what) = otherwise(case, &again) {
            let message =
                format!("the states known lead to {what}; the history before them cannot be told in a deck");
            return Err(ExportError::Lost(message));
        }
        let differences = differences(case, &again);
        let numbers = format!("given {}, must be {}, tolerance {}", self.got, self.want, self.tolerance);
        Ok(Deck::new(&about(&case.definition.connection.name, self), numbers, &model, states, differences))
    }
}

impl Deck {
    /// A deck with a heading: what it is about, the numbers in question, how to evaluate it.
    pub(super) fn new(
        about: &str,
        numbers: String,
        model: &str,
        states: String,
        differences: Vec<Difference>,
    ) -> Self {
        let mut text = format!(
            "** {about}\n** {numbers}\n** Evaluate it at the last of its states: pintle eval THIS --states THOSE\n"
        );
        if differences.iter().all(|difference| difference.largest == 0.0) {
            text.push_str("** Its numbers are those of the counter-example, bit for bit.\n");
        } else {
            text.push_str(
                "** Points and rotations do not give the triads of the counter-example to the last bit: numbers differ by at most\n",
            );
            for Difference { quantity, largest } in &differences {
                text.push_str(&format!("**   {}: {largest:e}\n", quantity.name()));
            }
        }
        text.push_str(model);
        Self { text, states: states + "\n", differences }
    }
}

/// The connector of a deck at the last of its states.
fn read(deck: &str, states: &str) -> Result<Case, ExportError> {
    let scene = Scene::parse("the deck", deck)?;
    let states = StateFile::parse_json("its states", states, &scene)?;
    let model = Model::compile(&scene)?;
    let plan = Plan::compile(&model, &Selection::All, request())
        .map_err(|error| ExportError::Lost(error.to_string()))?;
    let target = Target { name: "the deck", model: &model, plan: &plan, states: &states.states };
    let found = last_cases(&target, &[0]).pop();
    found.map(|(_, case)| case).ok_or_else(|| ExportError::Lost("the deck has no connector".to_string()))
}

#[cfg(test)]
mod tests {
    use super::Turning;
    use pintle_kinematics::vector::identity;
    use pintle_scene::Rotation;

    #[test]
    fn no_rotation_is_written_as_none() {
        let mut turning = Turning { initial: identity(), total: [0.0; 3], counts_turns: false };
        assert_eq!(turning.to(&identity(), [0.0; 3]), Rotation::default());
    }
}
