//! A scene of one connector, read from a deck, walked through as a solver would, beside the truth and beside running sums.

use crate::peer::Sum;
use crate::{Result, U};
use pintle_bench::worse;
use pintle_kinematics::connector::{
    Branch, Connector, Evaluation, Flag, Increment, Output, Request, State, Tally,
};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::{Real, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::so3::Quaternion;
use pintle_kinematics::vector;
use pintle_kinematics::vector::Vector;
use pintle_model::evaluate::{Branches, ConnectorResult, Item, Model, Plan, Sequence};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State as SceneState, StateFile};
use std::convert::Infallible;

/// The one connector of a scene.
pub(crate) struct Stressed {
    scene: Scene,
    pub(crate) model: Model,
    pub(crate) plan: Plan,
}

/// The rotations of the two nodes, scalar first.
pub(crate) type Rotations = [Quaternion<f64>; 2];

impl Stressed {
    /// Between nodes at these positions, oriented along the global axes. CU, and its derivatives up to an order.
    pub(crate) fn new(name: &str, positions: [Vector<f64>; 2], order: u8) -> Result<Self> {
        let [a, b] = positions.map(|[x, y, z]| format!("{x:?}, {y:?}, {z:?}"));
        let deck = format!(
            "*HEADING\na connector under stress\n*NODE\n1, {a}\n2, {b}\n\
             *ORIENTATION, NAME=FRAME\n1., 0., 0., 0., 1., 0.\n\
             *ELEMENT, TYPE=CONN3D2, ELSET=ONE\n1, 1, 2\n\
             *CONNECTOR SECTION, ELSET=ONE\n{name}\nFRAME,\n"
        );
        let scene = Scene::parse("stress.inp", &deck)?;
        let model = Model::compile(&scene)?;
        let plan = Plan::everything(&model, Request::new(&[Output::CU], [true; 6], order));
        Ok(Self { scene, model, plan })
    }

    /// The first state of a file of states.
    pub(crate) fn read(&self, csv: &str) -> Result<SceneState> {
        let file = StateFile::parse_csv("stress.csv", csv, &self.scene)?;
        Ok(file.states.into_iter().next().ok_or("a file of states has one")?)
    }

    /// What the walk makes of its next state.
    pub(crate) fn step(&self, sequence: &mut Sequence, state: &SceneState) -> Result<ConnectorResult> {
        Ok(sequence.step(state).connectors.pop().ok_or("the scene has a connector")?)
    }

    /// The same on 237 bits, from the same numbers, turns not counted.
    pub(crate) fn truth(&self, rotations: &Rotations, branch: &Branch<Wide>, order: u8) -> Evaluation<Wide> {
        let definition = self.model.connectors[0].definition();
        let node = |node: &Node<f64>, rotation: Quaternion<f64>| Node {
            displacement: vector::exact(node.displacement),
            triad: vector::product(
                &so3::matrix(so3::normalize(rotation.map(Wide::from_f64))),
                &vector::exact_matrix(&node.triad),
            ),
            flow: Wide::from_f64(node.flow),
        };
        let Pair { reference, a, b } = definition.initial;
        let pair = Pair {
            reference: vector::exact(reference),
            a: node(&a, rotations[0]),
            b: node(&b, rotations[1]),
        };
        let still = [Wide::ZERO; DOFS];
        let state = State { pair, velocity: still, acceleration: still };
        let request = Request::new(&[Output::CU], [true; 6], order);
        Connector::<Wide>::new(&definition).evaluate(
            &state,
            &Increment::none(),
            branch,
            &request,
            &mut Tally::default(),
        )
    }

    pub(crate) fn initial_branch(&self) -> Branch<Wide> {
        Connector::<Wide>::new(&self.model.connectors[0].definition()).initial_branch()
    }
}

/// A state with these rotations and no displacement.
pub(crate) fn turned(rotations: &Rotations) -> SceneState {
    let motion =
        |q: Quaternion<f64>| NodeMotion { rotation: Rotation::Quaternion(q), ..NodeMotion::default() };
    let [a, b] = rotations.map(motion);
    SceneState { nodes: [(Label::from(1), a), (Label::from(2), b)].into(), ..SceneState::default() }
}

/// The types that wind, with the components that do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Winding {
    /// ur1, by the number of its turns.
    Hinge,
    /// The rotation vector, ur1 to ur3.
    Rotation,
}

/// A motion: b turns against a about one axis, and both with a about any.
pub(crate) struct Motion {
    /// What it is, in words, from which its axes are drawn.
    pub(crate) seed: String,
    pub(crate) winding: Winding,
    /// Components along the axes of a.
    pub(crate) axis: Vector<f64>,
    /// What b turns against a from one state to the next (rad).
    pub(crate) step: f64,
    /// What a turns at most (rad).
    pub(crate) carried: f64,
    pub(crate) steps: u64,
    /// The whole turns before, in the saved branches that the walk continues.
    pub(crate) turns: f64,
}

/// How far reported numbers are from the truth at a state.
pub(crate) struct Sample {
    pub(crate) step: u64,
    /// The angle, roughly (rad).
    pub(crate) angle: f64,
    pub(crate) ours: f64,
    /// Of a running sum of the rotation vectors of increments.
    pub(crate) summed: f64,
    /// What is expected of ours: the rounding of the reported number, those of relative rotations, and what the direction of a rotation
    /// vector makes of these.
    pub(crate) bound: f64,
    /// Whether an increment up to here was told as too large to count turns with certainty.
    pub(crate) told: bool,
}

/// Half the distance from a double to the next.
pub(crate) fn half_spacing(x: f64) -> f64 {
    0.5 * (x.abs().next_up() - x.abs())
}

/// The angle at the first state (rad).
const START: f64 = 1.0;

impl Motion {
    /// Walks, and looks at the states that `is_looked_at` tells by their number.
    pub(crate) fn walk(&self, is_looked_at: impl Fn(u64) -> bool) -> Result<Vec<Sample>> {
        let name = match self.winding {
            Winding::Hinge => "HINGE",
            Winding::Rotation => "ROTATION",
        };
        let stressed = Stressed::new(name, [[0.0; 3]; 2], 0)?;
        let draw = &mut Draw::new(&self.seed);
        let turn = |angle: f64| so3::exp_quaternion(vector::scale(self.axis, angle));
        let mut rotations = [[1.0, 0.0, 0.0, 0.0], turn(START)];
        let mut sequence = Sequence::new(&stressed.model, &stressed.plan);
        let Ok(()) = sequence.pass(&turned(&rotations), |_| Ok::<(), Infallible>(()));
        let before = (Wide::pi() + Wide::pi()) * Wide::from_f64(self.turns);
        let total = (before + Wide::from_f64(START)).to_f64();
        if self.turns > 0.0 {
            let saved = self.with_turns(&sequence.branches(), total)?;
            saved.check(&stressed.model, &stressed.plan)?;
            sequence = Sequence::resume(&stressed.model, &stressed.plan, saved);
        }
        let mut sum = Sum::from(rotations, vector::scale(self.axis, total));
        let (mut samples, mut told) = (Vec::new(), false);
        for step in 1..=self.steps {
            // As a solver composes them: each node by its own increment.
            let [a, b] = rotations;
            let of_a = so3::exp_quaternion(vector::scale(draw.direction(), draw.between(0.0, self.carried)));
            let relative = so3::compose(a, so3::compose(turn(self.step), so3::conjugate(a)));
            let of_b = so3::compose(of_a, relative);
            rotations = [(of_a, a), (of_b, b)].map(|(by, old)| so3::normalize(so3::compose(by, old)));
            sum.add(rotations);
            let mut look = |flags: &[Flag]| {
                told |= flags.iter().any(|flag| matches!(flag, Flag::LargeIncrement { .. }));
            };
            if !is_looked_at(step) {
                let Ok(()) = sequence.pass(&turned(&rotations), |item| {
                    if let Item::Connector(result) = item {
                        look(&result.flags);
                    }
                    Ok::<(), Infallible>(())
                });
                continue;
            }
            let result = stressed.step(&mut sequence, &turned(&rotations))?;
            look(&result.flags);
            let angle =
                before + Wide::from_f64(START) + Wide::from_f64(self.step) * Wide::from_f64(step as f64);
            let (truth, bound) = self.truth(&stressed, &rotations, angle)?;
            let got = &result.evaluation.displacement;
            let (mut ours, mut summed) = (0.0_f64, 0.0_f64);
            for (i, want) in truth.iter().enumerate() {
                let error = |got: f64| (Wide::from_f64(got) - *want).abs().to_f64();
                ours = worse(ours, error(got[3 + i].ok_or("the component is reported")?));
                summed = worse(summed, error(sum.vector[i]));
            }
            samples.push(Sample { step, angle: angle.to_f64(), ours, summed, bound, told });
        }
        Ok(samples)
    }

    /// The file of branches as a run would have saved it after so many turns.
    fn with_turns(&self, saved: &Branches, total: f64) -> Result<Branches> {
        let mut file: serde_json::Value = serde_json::from_str(&serde_json::to_string(saved)?)?;
        let branch = file.pointer_mut("/connectors/1/branch").ok_or("connector 1 has a branch")?;
        match self.winding {
            Winding::Hinge => branch["turns"][3]["turns"] = self.turns.into(),
            Winding::Rotation => {
                branch["rotation_vector"] = serde_json::to_value(vector::scale(self.axis, total))?;
            }
        }
        Ok(serde_json::from_str(&file.to_string())?)
    }

    /// The components that wind, from the rotations that the nodes have and the turns that they have made; and the bound of ours.
    fn truth(&self, stressed: &Stressed, rotations: &Rotations, angle: Wide) -> Result<(Vec<Wide>, f64)> {
        let turn = Wide::pi() + Wide::pi();
        let principal = stressed.truth(rotations, &stressed.initial_branch(), 0).displacement;
        let rounding = half_spacing(angle.to_f64());
        match self.winding {
            Winding::Hinge => {
                let principal = principal[3].ok_or("a HINGE has ur1")?;
                let turns = ((angle - principal) / turn).nearest_integer();
                Ok((vec![principal + turns * turn], rounding + 8.0 * U))
            }
            Winding::Rotation => {
                let [x, y, z] = [3, 4, 5].map(|k| principal[k]);
                let vector = [x, y, z].map(|x| x.unwrap_or(Wide::ZERO));
                let length = pintle_kinematics::scalar::elementary::norm(vector);
                let along = vector::dot(vector, self.axis.map(Wide::from_f64));
                let angle = if along.to_f64() < 0.0 { -angle } else { angle };
                let turns = ((angle - length) / turn).nearest_integer();
                let factor = (length + turns * turn) / length;
                // A relative rotation with an error of a few u has a direction with that error over sin(φ/2).
                let sine = (0.5 * length.to_f64()).sin();
                let bound = rounding + 8.0 * U * (1.0 + angle.to_f64().abs() / sine);
                Ok((vector.map(|x| x * factor).to_vec(), bound))
            }
        }
    }
}
