//! What is judged: one connector, where its history left it, and the states that lead to the one in question.

pub mod failing;
pub mod hex;
pub mod quantity;
pub mod stage;

use pintle_kinematics::Differentiable;
use pintle_kinematics::connector::{
    Branch, Components, Connector, Definition, Evaluation, Increment, Output, Request, State, Tally, Turns,
};
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::Real;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3::{self, exp};
use pintle_kinematics::vector::{self, Matrix, Vector, add, apply, product, sub, transpose};
use serde::{Deserialize, Serialize};

/// One state of a path, and the increment that leads to it.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// The state.
    pub state: State<f64>,
    /// What happened to the nodes since the state before.
    pub increment: Increment<f64>,
}

/// Where two nodes start that are `apart`: the first not at the origin, where nobody sees that it was left out. Its place has few digits, so
/// that places are rounded little; a planar connector stays in its plane.
pub fn initial_places(apart: Vector<f64>, planar: bool) -> [Vector<f64>; 2] {
    let length = norm(apart);
    let size = if length > 0.0 && length.is_finite() { length.log2().floor().exp2() } else { 1.0 };
    let first = [0.5 * size, -0.75 * size, if planar { 0.0 } else { 0.25 * size }];
    [first, add(first, apart)]
}

impl Step {
    /// From one pair to the next at rest, by less than half a turn of each node.
    pub fn between(before: &Pair<f64>, after: Pair<f64>) -> Self {
        let turned =
            |old: &Node<f64>, new: &Node<f64>| so3::log(&product(&new.triad, &transpose(&old.triad)));
        let increment = Increment {
            rotation: [turned(&before.a, &after.a), turned(&before.b, &after.b)],
            whole_turns: [[0.0; 3]; 2],
            flow: [after.a.flow - before.a.flow, after.b.flow - before.b.flow],
        };
        Self { state: State { pair: after, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }, increment }
    }
}

/// A connector and a path of it; what is judged is the end of the path.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Case {
    /// The type and the region of configuration space, in words.
    pub name: String,
    /// The connector.
    pub definition: Definition,
    /// What the states before the path left; `None` is the initial branch.
    pub start: Option<Branch<f64>>,
    /// At least one state.
    pub path: Vec<Step>,
    /// s, the connector's own length: max(|d|, |d₀|, a reference length).
    pub length: f64,
}

/// A case at its end: its connector, built once, and its history, replayed once.
#[derive(Clone)]
pub struct AtEnd<'a> {
    /// The case.
    pub case: &'a Case,
    /// The connector, on doubles.
    pub connector: Connector<f64>,
    /// The state judged, and the increment that leads to it.
    pub step: &'a Step,
    /// The branch that the states before the end leave.
    pub before: Branch<f64>,
    /// The branch at the end.
    pub after: Branch<f64>,
}

impl AtEnd<'_> {
    /// The evaluation of `request`, and how much was computed for it.
    pub fn evaluation(&self, request: &Request) -> (Evaluation<f64>, Tally) {
        let Step { state, increment } = self.step;
        let mut tally = Tally::default();
        (self.connector.evaluate(state, increment, &self.before, request, &mut tally), tally)
    }

    /// Where displacements count from what rounding decided, that.
    pub fn undetermined_origins(&self) -> [Option<f64>; 6] {
        let sets = self.connector.undetermined_origins();
        [0, 1, 2, 3, 4, 5].map(|k| sets[k].and_then(|_| self.connector.counts_from(k)))
    }
}

impl Case {
    /// The end, ready to be asked; `None` for an empty path.
    pub fn at_end(&self) -> Option<AtEnd<'_>> {
        let (step, connector) = (self.last()?, self.connector());
        let before = self.branch_before(&connector);
        let after = connector.advance(&step.state, &step.increment, &before);
        Some(AtEnd { case: self, connector, step, before, after })
    }

    /// The connector, on doubles.
    pub fn connector(&self) -> Connector<f64> {
        Connector::new(&self.definition)
    }

    /// The state judged, and the increment that leads to it; `None` for an empty path.
    pub fn last(&self) -> Option<&Step> {
        self.path.last()
    }

    /// Whether the fourth power of a length at the end, of which second derivatives are formed on the way, is no normal double, or its
    /// reciprocal is none.
    pub(super) fn is_out_of_range(&self) -> bool {
        let Some(step) = self.last() else { return false };
        let apart = [step.state.pair.separation(), step.state.pair.reference];
        let lengths = apart.into_iter().map(norm).chain([self.length]);
        let mut lengths = lengths.filter(|length| *length != 0.0);
        lengths.any(|length| !length.powi(4).is_normal() || !length.powi(-4).is_normal())
    }

    /// The branch that the states before the end leave.
    pub fn branch_before(&self, connector: &Connector<f64>) -> Branch<f64> {
        let mut branch = self.start.unwrap_or_else(|| connector.initial_branch());
        let Some((_, before)) = self.path.split_last() else { return branch };
        for step in before {
            branch = connector.advance(&step.state, &step.increment, &branch);
        }
        branch
    }

    /// The evaluation of `request` at the end, and how much was computed for it; `None` for an empty path.
    pub fn evaluation(&self, request: &Request) -> Option<(Evaluation<f64>, Tally)> {
        Some(self.at_end()?.evaluation(request))
    }

    /// CP of the components at the end: lengths, and angles with their turns (rad).
    pub fn positions(&self) -> Components<f64> {
        let asked = Request::new(&[Output::CP], [true; 6], 0);
        self.evaluation(&asked).map_or([None; 6], |(found, _)| found.position)
    }

    /// What is right at the end: residuals of constrained components, displacements of others.
    pub fn values(&self) -> Components<f64> {
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let of =
            |found: Evaluation<f64>| [0, 1, 2, 3, 4, 5].map(|k| found.residual[k].or(found.displacement[k]));
        self.evaluation(&asked).map_or([None; 6], |(found, _)| of(found))
    }

    /// The same connector where nothing has moved.
    #[must_use]
    pub fn at_rest(&self) -> Self {
        let initial = self.definition.initial;
        Self { start: None, path: vec![Step::between(&initial, initial)], ..self.clone() }
    }

    /// Whether the initial state is clear of the singular sets by `start`, and the end by `end`, in radians and in lengths of
    /// the connector.
    pub fn is_clear(&self, start: f64, end: f64) -> bool {
        let connector = self.connector();
        let mut branch = self.start.unwrap_or_else(|| connector.initial_branch());
        let rest = State { pair: self.definition.initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let clear = |state: &State<f64>, branch: &Branch<f64>, least: f64| {
            connector.margins(state, branch, [true; 6]).iter().flatten().all(|margin| {
                let unit = if margin.set.unit == Unit::Length { self.length } else { 1.0 };
                margin.distance >= least * unit
            })
        };
        if !clear(&rest, &branch, start) {
            return false;
        }
        let Some((last, before)) = self.path.split_last() else { return false };
        for step in before {
            branch = connector.advance(&step.state, &step.increment, &branch);
            if !clear(&step.state, &branch, 0.0) {
                return false;
            }
        }
        branch = connector.advance(&last.state, &last.increment, &branch);
        clear(&last.state, &branch, end)
    }
}

/// The same state on another real number, exactly.
pub fn exact_state<R: Real>(state: &State<f64>) -> State<R> {
    State {
        pair: state.pair.exact(),
        velocity: state.velocity.map(R::from_f64),
        acceleration: state.acceleration.map(R::from_f64),
    }
}

/// The same branch on another real number, exactly.
pub fn exact_branch<R: Real>(branch: &Branch<f64>) -> Branch<R> {
    let exact = |t: Turns<f64>| Turns { turns: R::from_f64(t.turns), principal: R::from_f64(t.principal) };
    Branch {
        turns: branch.turns.map(exact),
        torsion: exact(branch.torsion),
        rotation_vector: vector::exact(branch.rotation_vector),
        euler_sign: R::from_f64(branch.euler_sign),
        accumulated: R::from_f64(branch.accumulated),
        accumulated_rest: R::from_f64(branch.accumulated_rest),
    }
}

/// Whether a rotation vector is none at all: nothing that is moved on purpose turns as little as that.
pub(super) fn is_still<R: Differentiable>(rotation: &Vector<R>) -> bool {
    let least = R::from_f64(f64::MIN_POSITIVE);
    rotation.iter().all(|x| R::holds(x.magnitude().less(least)))
}

/// The pair with its degrees of freedom moved by finite amounts: U + δx, exp(δθ^) C, Ψ + δΨ. Written apart from
/// [`Pair::moved`], and used on numbers without derivatives.
pub fn moved<R: Differentiable>(pair: &Pair<R>, by: &[R; DOFS]) -> Pair<R> {
    let node = |node: &Node<R>, at: usize| {
        let rotation = [by[at + 3], by[at + 4], by[at + 5]];
        Node {
            displacement: add(node.displacement, [by[at], by[at + 1], by[at + 2]]),
            triad: if is_still(&rotation) { node.triad } else { product(&exp(rotation), &node.triad) },
            flow: node.flow + by[at + 6],
        }
    };
    Pair { reference: pair.reference, a: node(&pair.a, 0), b: node(&pair.b, DOFS / 2) }
}

/// The pair after the rigid motion of space that turns it by R and gives node a the displacement `translation`.
pub fn carried(pair: &Pair<f64>, rotation: &Matrix<f64>, translation: Vector<f64>) -> Pair<f64> {
    // U_b' − U_a' must give R D = R (X_b − X_a + U_b − U_a) with the same X_b − X_a.
    let carried = apply(rotation, pair.separation());
    let mut moved = *pair;
    moved.a.displacement = translation;
    moved.b.displacement = add(translation, sub(carried, pair.reference));
    moved.a.triad = product(rotation, &pair.a.triad);
    moved.b.triad = product(rotation, &pair.b.triad);
    moved
}

/// What is right at the state before the end of a case.
pub fn values_before(case: &Case) -> Components<f64> {
    let mut before = case.clone();
    before.path.pop();
    if before.path.is_empty() {
        let pair = case.definition.initial;
        before.path.push(Step::between(&pair, pair));
    }
    before.values()
}
