//! States in order: nodes once, connectors as planned, branches committed.

use super::behavior::{SLOPES, flag, not_known, slopes_not_known, wants};
use super::forces::{ForceResult, given_forces};
use super::jacobian::{ForeignPattern, Jacobian};
use super::model::{ConnectorElement, ElementBehavior, Model};
use super::mpc::{MpcResult, START};
use super::parallel;
use super::plan::Plan;
use crate::behavior::state::{Event, History, Kinematics, Outcome, Velocities};
use crate::behavior::{Beyond, Conditions, Tangent, Unknown, Wrap};
use crate::catalog::COMPONENT;
use crate::connector::{
    Branch, CompactRow, Components, Evaluation, Flag, Increment, Mask, Output, Request, State, StopStatus,
    Tally, Turns,
};
use crate::measure::Margin;
use crate::mpc::Dofs;
use crate::node::{DOFS, Node, Pair};
use crate::scalar::elementary::norm;
use crate::scene::{Label, NodeMotion, Rotation, State as SceneState};
use crate::so3::{self, Quaternion};
use crate::vector::{Matrix, Vector, identity, product, sub};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;

/// A node at one state, its rotation worked out once for all connectors that share it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Moved {
    pub(super) displacement: Vector<f64>,
    pub(super) rotation: Matrix<f64>,
    pub(super) flow: f64,
    pub(super) rates: [f64; 7],
    pub(super) accelerations: [f64; 7],
    /// Since the previous state.
    pub(super) change: Vector<f64>,
    pub(super) whole_turns: Vector<f64>,
    flow_change: f64,
    /// Component 3 of the rotation as given: degree of freedom 6.
    pub(super) sixth: Option<f64>,
}

impl Moved {
    /// The ground.
    pub(super) const fn still() -> Self {
        STILL
    }
}

const STILL: Moved = Moved {
    displacement: [0.0; 3],
    rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    flow: 0.0,
    rates: [0.0; 7],
    accelerations: [0.0; 7],
    change: [0.0; 3],
    whole_turns: [0.0; 3],
    flow_change: 0.0,
    sixth: None,
};

/// How a node was rotated at the last state: enough to form the increment to the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Orientation {
    quaternion: Quaternion<f64>,
    /// The total rotation vector: as given, or that of a quaternion continued from the state before.
    vector: Vector<f64>,
    flow: f64,
}

const UNTURNED: Orientation = Orientation { quaternion: [1.0, 0.0, 0.0, 0.0], vector: [0.0; 3], flow: 0.0 };

/// Everything that a sequence remembers between states. Saved and read back, it continues bit for bit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Branches {
    /// The number of states committed.
    pub states: u64,
    connectors: BTreeMap<Label, Saved>,
    mpcs: BTreeMap<String, [Turns<f64>; 2]>,
    nodes: BTreeMap<Label, Orientation>,
}

/// Every component.
const fn all() -> Mask {
    [true; 6]
}

fn is_all(mask: &Mask) -> bool {
    *mask == all()
}

/// The components of a connector whose history a plan needs: those that it names, and those that behaviour follows from.
fn followed(element: &ConnectorElement, plan: &Plan) -> Mask {
    let request = &plan.request;
    let behavior = Some(&*element.behavior).filter(|behavior| behavior.is_needed(request, request));
    behavior.map_or(request.components(), |behavior| {
        behavior.request(request, behavior.slides(request)).components()
    })
}

/// The branch of a connector, with what it belongs to: turn counts of another type or geometry would be taken for its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Saved {
    connection: String,
    nodes: [Option<Label>; 2],
    reference: Vector<f64>,
    triads: [Matrix<f64>; 2],
    branch: Branch<f64>,
    /// The components whose history the branch holds.
    #[serde(default = "all", skip_serializing_if = "is_all")]
    followed: Mask,
    /// What the behaviour has decided, and the number that tells it from others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    behavior: Option<(u64, History)>,
}

impl Saved {
    fn new(element: &ConnectorElement, branch: Branch<f64>, behavior: Option<History>) -> Self {
        let identity = element.behavior.identity;
        Self {
            connection: element.connector.connection().name.to_string(),
            nodes: element.nodes,
            reference: element.reference,
            triads: element.triads().map(|triad| *triad),
            branch,
            followed: all(),
            behavior: behavior.map(|history| (identity, history)),
        }
    }

    /// What differs from the element, in words.
    fn difference(&self, element: &ConnectorElement) -> Option<String> {
        let now = Self::new(element, self.branch, Some(History::default()));
        let label = element.label;
        if self.connection != now.connection {
            let (saved, now) = (&self.connection, &now.connection);
            return Some(format!("the branch of connector {label} was saved for {saved}, and it is {now}"));
        }
        let identity = |saved: &Self| saved.behavior.as_ref().map(|(identity, _)| *identity);
        if identity(self).is_some_and(|identity_then| Some(identity_then) != identity(&now)) {
            return Some(format!("the history of connector {label} was saved for another behaviour"));
        }
        let place = (self.nodes, self.reference, self.triads) != (now.nodes, now.reference, now.triads);
        place.then(|| {
            format!(
                "the branch of connector {label} was saved for other nodes, initial positions or orientations"
            )
        })
    }
}

impl Branches {
    /// Whether these branches can be continued by a plan.
    ///
    /// # Errors
    /// In words, the first connector that one of the two knows and the other does not.
    pub fn check(&self, model: &Model, plan: &Plan) -> Result<(), String> {
        let planned: BTreeMap<Label, &ConnectorElement> = plan
            .connectors
            .iter()
            .map(|index| &model.connectors[*index])
            .map(|element| (element.label, element))
            .collect();
        if self.states > 0
            && let Some(label) = planned.keys().find(|label| !self.connectors.contains_key(label))
        {
            return Err(format!("connector {label} is to be evaluated, and its branch was not saved"));
        }
        for (label, saved) in &self.connectors {
            let Some(element) = planned.get(label) else {
                return Err(format!(
                    "a branch was saved for connector {label}, which is not to be evaluated"
                ));
            };
            if let Some(difference) = saved.difference(element) {
                return Err(difference);
            }
            let missing = |k: &usize| followed(element, plan)[*k] && !saved.followed[*k];
            if let Some(k) = (0..6).find(missing) {
                return Err(format!(
                    "the turns of {} of connector {label} were not followed when its branch was saved",
                    COMPONENT[k]
                ));
            }
            let behavior = &element.behavior;
            let needs = behavior.has_history() && behavior.is_asked(&plan.request);
            if needs && self.states > 0 && saved.behavior.is_none() {
                return Err(format!(
                    "what is asked for depends on the history of connector {label}, which was not followed: \
                     nothing that depends on it was asked for when the branches were saved"
                ));
            }
        }
        let mpcs: BTreeSet<String> = plan.mpcs.iter().map(|index| model.mpcs[*index].key(*index)).collect();
        if self.states > 0 && !mpcs.iter().eq(self.mpcs.keys()) {
            return Err("the MPCs to be evaluated are not those whose branches were saved".to_string());
        }
        if self.states > 0 && !plan.nodes.iter().eq(self.nodes.keys()) {
            return Err("the nodes of the scene are not those whose rotations were saved".to_string());
        }
        Ok(())
    }
}

/// One connector at one state.
#[derive(Clone, Debug)]
pub struct ConnectorResult {
    /// The index of the connector in the model.
    pub index: usize,
    /// Its nodes.
    pub state: State<f64>,
    /// What they did since the previous state; how they turned, only where a history depends on it that is followed.
    pub increment: Increment<f64>,
    /// The branch that the previous state left; [`Evaluation::branch`] is the one after.
    pub before: Branch<f64>,
    /// The numbers.
    pub evaluation: Evaluation<f64>,
    /// CSLST.
    pub stops: Components<StopStatus>,
    /// MARGIN, of every component of the request: what needs care is always looked at.
    pub margins: Components<Margin>,
    /// What needs care.
    pub flags: Vec<Flag>,
    /// Forces and what else follows from behaviour, motions and loads, where it was needed.
    pub behavior: Option<Box<Outcome>>,
    /// TANGENT.
    pub tangent: Option<Box<Tangent<f64>>>,
    /// What follows from component forces, where they are given and it is asked for.
    pub forces: Option<Box<ForceResult>>,
}

/// Everything planned, at one state.
#[derive(Clone, Debug)]
pub struct StepResult {
    /// The number of the state, from 0.
    pub index: u64,
    /// Its time, where given.
    pub time: Option<f64>,
    /// Connectors in the order of the plan.
    pub connectors: Vec<ConnectorResult>,
    /// Multi-point constraints in the order of the plan.
    pub mpcs: Vec<MpcResult>,
}

/// What a walk hands on at one state.
#[derive(Clone, Debug)]
pub enum Item {
    /// A connector.
    Connector(Box<ConnectorResult>),
    /// A multi-point constraint.
    Mpc(Box<MpcResult>),
}

/// What a walk remembers of one connector.
#[derive(Clone, Debug)]
struct Memory {
    branch: Branch<f64>,
    /// What the behaviour has decided.
    behavior: Option<Box<History>>,
}

/// Whether the behaviour of a connector has to be worked out, found once.
#[derive(Clone, Copy, Debug)]
struct Needed {
    /// At a state of which the plan's outputs are wanted.
    by_plan: bool,
    /// At any other, because later ones depend on it.
    always: bool,
}

impl Needed {
    fn of(element: &ConnectorElement, planned: &Request) -> Self {
        let behavior = &element.behavior;
        Self {
            by_plan: behavior.is_needed(planned, planned),
            always: behavior.is_needed(&Request::nothing(0), planned),
        }
    }
}

/// The place of a node among those of the plan; the ground has none.
type Place = Option<u32>;

/// A walk through states, holding one of them at a time.
///
/// Connectors are evaluated by the threads of rayon's current pool. Each is a function of its own nodes and history, and results are
/// handed on in the order of the plan: they do not depend on the number of threads, to the last bit.
#[derive(Clone, Debug)]
pub struct Sequence<'a> {
    model: &'a Model,
    plan: &'a Plan,
    /// The number of states committed.
    states: u64,
    /// Nodes in the order of the plan, and how each is turned.
    labels: Vec<Label>,
    nodes: Vec<Orientation>,
    /// Whether a history depends on how a node turns from state to state.
    turning: Vec<bool>,
    /// Where the nodes are at the state that is being evaluated.
    moved: Vec<Moved>,
    /// The nodes of connectors and MPCs, in the order of the plan.
    ends: Vec<[Place; 2]>,
    mpc_nodes: Vec<Vec<Place>>,
    connectors: Vec<Memory>,
    /// The components of each connector whose history is followed.
    followed: Vec<Mask>,
    /// Whether the behaviour of each has to be worked out.
    needed: Vec<Needed>,
    mpcs: Vec<[Turns<f64>; 2]>,
    tally: Tally,
    velocities: Velocities,
    conditions: Conditions,
}

impl<'a> Sequence<'a> {
    /// A walk that starts from the initial state of the model.
    pub fn new(model: &'a Model, plan: &'a Plan) -> Self {
        Self::resume(model, plan, Branches::default())
    }

    /// Where the velocities of damping come from: the rates of the states, unless they are said to be increments.
    pub const fn set_velocities(&mut self, velocities: Velocities) {
        self.velocities = velocities;
    }

    /// The temperature and field variables of the states that follow.
    pub fn set_conditions(&mut self, conditions: Conditions) {
        self.conditions = conditions;
    }

    /// A walk that continues where another stopped.
    pub fn resume(model: &'a Model, plan: &'a Plan, mut branches: Branches) -> Self {
        let labels: Vec<Label> = plan.nodes.iter().copied().collect();
        let place = |label: Label| labels.binary_search(&label).ok().and_then(|at| u32::try_from(at).ok());
        let ends = |index: &usize| model.connectors[*index].nodes.map(|node| node.and_then(place));
        let of_mpc = |index: &usize| model.mpcs[*index].nodes.iter().map(|node| place(*node)).collect();
        let memory = |index: &usize| {
            let element = &model.connectors[*index];
            match branches.connectors.remove(&element.label) {
                Some(Saved { branch, behavior, .. }) => {
                    Memory { branch, behavior: behavior.map(|(_, history)| Box::new(history)) }
                }
                None => Memory { branch: element.connector.initial_branch(), behavior: None },
            }
        };
        let angles = |index: &usize| {
            let known = branches.mpcs.get(&model.mpcs[*index].key(*index));
            known.copied().unwrap_or(START)
        };
        let turned = |label: &Label| branches.nodes.get(label).copied().unwrap_or(UNTURNED);
        let ends: Vec<[Place; 2]> = plan.connectors.iter().map(ends).collect();
        let mpc_nodes: Vec<Vec<Place>> = plan.mpcs.iter().map(of_mpc).collect();
        let followed: Vec<Mask> =
            plan.connectors.iter().map(|index| followed(&model.connectors[*index], plan)).collect();
        let mut turning = vec![false; labels.len()];
        for (index, (ends, followed)) in plan.connectors.iter().zip(ends.iter().zip(&followed)) {
            if model.connectors[*index].connector.history_turns(*followed) {
                turns(&mut turning, ends);
            }
        }
        mpc_nodes.iter().for_each(|nodes| turns(&mut turning, nodes));
        Self {
            states: branches.states,
            ends,
            mpc_nodes,
            mpcs: plan.mpcs.iter().map(angles).collect(),
            nodes: labels.iter().map(turned).collect(),
            connectors: plan.connectors.iter().map(memory).collect(),
            followed,
            turning,
            needed: plan
                .connectors
                .iter()
                .map(|index| Needed::of(&model.connectors[*index], &plan.request))
                .collect(),
            moved: vec![STILL; labels.len()],
            labels,
            tally: Tally::default(),
            velocities: Velocities::default(),
            conditions: Conditions::default(),
            model,
            plan,
        }
    }

    /// Follows the histories of all components, whether or not the plan names them, so that saved branches can be continued by any plan
    /// of the same connectors. To be said before the first state.
    pub fn follow_everything(&mut self) {
        self.followed.fill([true; 6]);
        self.turning.fill(true);
    }

    /// The number of states committed, those before [`Sequence::resume`] among them.
    pub const fn states(&self) -> u64 {
        self.states
    }

    /// What is remembered: save it to continue later.
    pub fn branches(&self) -> Branches {
        if self.states == 0 {
            return Branches::default();
        }
        let memories = self.connectors.iter().zip(&self.followed);
        let connectors = self.plan.connectors.iter().zip(memories).map(|(index, (memory, followed))| {
            let element = &self.model.connectors[*index];
            let history = memory.behavior.as_deref().cloned();
            (element.label, Saved { followed: *followed, ..Saved::new(element, memory.branch, history) })
        });
        let mpcs = self.plan.mpcs.iter().zip(&self.mpcs);
        Branches {
            states: self.states,
            connectors: connectors.collect(),
            mpcs: mpcs.map(|(index, angles)| (self.model.mpcs[*index].key(*index), *angles)).collect(),
            nodes: self.labels.iter().copied().zip(self.nodes.iter().copied()).collect(),
        }
    }

    /// What was computed so far.
    pub const fn tally(&self) -> Tally {
        self.tally
    }

    /// Evaluates the plan at the next state and commits it.
    pub fn step(&mut self, state: &SceneState) -> StepResult {
        let mut step = StepResult {
            index: self.states,
            time: state.time,
            connectors: Vec::with_capacity(self.plan.connectors.len()),
            mpcs: Vec::with_capacity(self.plan.mpcs.len()),
        };
        let Ok(()) = self.visit(state, |item| -> Result<(), Infallible> {
            match item {
                Item::Connector(result) => step.connectors.push(*result),
                Item::Mpc(result) => step.mpcs.push(*result),
            }
            Ok(())
        });
        step
    }

    /// Evaluates the plan at the next state and hands on one result at a time, connectors first, both in the order of the
    /// plan, so that a large model is never held as results. The state is committed when all have been taken.
    ///
    /// # Errors
    /// The first error of `take`; the walk must then be given up.
    pub fn visit<E>(&mut self, state: &SceneState, take: impl FnMut(Item) -> Result<(), E>) -> Result<(), E> {
        self.visit_digested(state, |item| item, take)
    }

    /// The same, where each result is worked into something else by `digest`, on the thread that computed it, before it is taken.
    ///
    /// # Errors
    /// The first error of `take`; the walk must then be given up.
    pub fn visit_digested<T: Send, E>(
        &mut self,
        state: &SceneState,
        digest: impl Fn(Item) -> T + Sync,
        take: impl FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        self.walk(state, true, digest, take)
    }

    /// Commits the next state without any output: branches follow it, and results carry their flags only.
    ///
    /// # Errors
    /// The first error of `take`; the walk must then be given up.
    pub fn pass<E>(&mut self, state: &SceneState, take: impl FnMut(Item) -> Result<(), E>) -> Result<(), E> {
        self.walk(state, false, |item| item, take)
    }

    /// Commits the next state and writes the entries of the sparse Jacobian there, and nothing else of it: `values` gets the length of
    /// [`Jacobian::entries`] and, in its order, the entries. Gives what needs care.
    ///
    /// # Errors
    /// A pattern that was made for another plan; one with rows whose history has not been followed. Then nothing is committed.
    pub fn assemble(
        &mut self,
        state: &SceneState,
        jacobian: &Jacobian,
        values: &mut Vec<f64>,
    ) -> Result<Vec<(String, Flag)>, ForeignPattern> {
        jacobian.check(self.plan)?;
        for (at, (index, followed)) in self.plan.connectors.iter().zip(&mut self.followed).enumerate() {
            let connector = &self.model.connectors[*index].connector;
            let (wanted, known) = (jacobian.wanted(at), *followed);
            for k in (0..6).filter(|k| wanted[*k] && !known[*k] && connector.row_has_history(*k)) {
                if self.states > 0 {
                    return Err(ForeignPattern::History);
                }
                followed[k] = true;
                turns(&mut self.turning, &self.ends[at]);
            }
        }
        let followed = &self.followed.clone();
        values.clear();
        values.resize(jacobian.entries(), 0.0);
        self.follow_nodes(state);
        let beyond = self.beyond(state);
        let Self { model, plan, moved, ends, connectors, needed, tally, velocities, conditions, .. } = self;
        let context = Context {
            model,
            planned: &plan.request,
            velocities: *velocities,
            conditions,
            scene_state: state,
            beyond: &beyond,
        };
        let mut care = Vec::new();
        let (of_connectors, of_mpcs) = values.split_at_mut(jacobian.connector_entries());
        let mut places = jacobian.split(of_connectors);
        let mut work: Vec<_> = connectors.iter_mut().zip(&mut places).collect();
        let Ok(()) = parallel::in_order(
            &mut work,
            |at, (memory, place)| {
                let mut tally = Tally::default();
                let nodes = ends[at].map(|end| end.map_or(&STILL, |end| &moved[end as usize]));
                let mut request = Request::nothing(0);
                request.add_rows(jacobian.wanted(at));
                let index = plan.connectors[at];
                let history = (followed[at], needed[at].always);
                let result = context.connector(index, nodes, memory, &request, history, &mut tally);
                let element = &model.connectors[index];
                let branch = &result.evaluation.branch;
                let rows =
                    element.connector.compact_rows(&result.state, branch, jacobian.wanted(at), &mut tally);
                jacobian.write(at, &rows, place);
                let mut flags = result.flags;
                let wanted = jacobian.wanted(at);
                let broken = |k: &usize| {
                    wanted[*k] && rows[*k].as_ref().is_none_or(|row: &CompactRow<f64>| !row.is_finite())
                };
                flags.extend(
                    (0..6)
                        .filter(broken)
                        .map(|k| Flag::NotFinite { component: COMPONENT[k], quantity: "derivative" }),
                );
                (flags, tally)
            },
            |at, (flags, work): (Vec<Flag>, Tally)| -> Result<(), Infallible> {
                *tally += work;
                let title = || model.connectors[plan.connectors[at]].title();
                care.extend(flags.into_iter().map(|flag| (title(), flag)));
                Ok(())
            },
        );
        drop(work);
        let mut rest = of_mpcs;
        let request = {
            let mut request = Request::nothing(1);
            request.add_rows([true; 6]);
            request
        };
        for (at, index) in self.plan.mpcs.iter().enumerate() {
            let element = &self.model.mpcs[*index];
            let nodes =
                self.mpc_nodes[at].iter().map(|node| node.map_or(STILL, |node| self.moved[node as usize]));
            let nodes: Vec<Moved> = nodes.collect();
            let of_state = (&request, &self.model.schedule, state);
            let result = element.evaluate(*index, &nodes, &self.mpcs[at], of_state, &mut self.tally);
            self.mpcs[at] = result.evaluation.angles;
            let place = rest.split_off_mut(..jacobian.mpc_entries(at)).unwrap_or_default();
            jacobian.write_mpc(at, &result.evaluation.jacobian, place);
            let rows = &result.evaluation.jacobian;
            let has = element.constraint.rows();
            let is_broken = |row: &Dofs<f64>| row.iter().any(|x| !x.is_finite());
            let broken = |row: &usize| has[*row] && rows[*row].as_ref().is_none_or(is_broken);
            let broken = (0..rows.len()).filter(broken).map(|row| Flag::NotFinite {
                component: element.constraint.kind().row_name(row),
                quantity: "derivative",
            });
            care.extend(result.flags.into_iter().chain(broken).map(|flag| (element.title(), flag)));
        }
        self.states += 1;
        Ok(care)
    }

    /// Where the nodes of the plan are at the next state.
    fn follow_nodes(&mut self, state: &SceneState) {
        let rotations = &mut self.tally.rotations;
        // Both are in order: the motions are found by going along, unless few nodes of many are planned.
        const FEW: usize = 16;
        let is_sparse = self.labels.len() < state.nodes.len() / FEW;
        let mut given = state.nodes.iter().peekable();
        let mut motion = |label: &Label| {
            if is_sparse {
                return state.nodes.get(label);
            }
            while given.next_if(|(known, _)| *known < label).is_some() {}
            given.next_if(|(known, _)| *known == label).map(|(_, motion)| motion)
        };
        let places = self.nodes.iter_mut().zip(&mut self.moved).zip(&self.turning);
        let mut nodes: Vec<_> =
            self.labels.iter().zip(places).map(|(label, place)| (motion(label), place)).collect();
        let Ok(()) = parallel::in_order(
            &mut nodes,
            |_, (given, ((orientation, moved), is_followed))| {
                let motion = given.copied().unwrap_or_default();
                let is_turned = motion.rotation != Rotation::default() || !is_unturned(orientation);
                let (node, after) = follow(&motion, orientation, given.is_some(), **is_followed);
                (**moved, **orientation) = (node, after);
                u64::from(is_turned)
            },
            |_, turned| -> Result<(), Infallible> {
                *rotations += turned;
                Ok(())
            },
        );
    }

    /// What the friction of belts needs of the segments beyond their rings, by the index of the segment that ends there: found before
    /// anything is committed, so that it does not depend on the order of the connectors.
    fn beyond(&mut self, scene_state: &SceneState) -> BTreeMap<usize, Beyond> {
        let mut found = BTreeMap::new();
        let Self { model, plan, labels, moved, connectors, tally, velocities, conditions, .. } = self;
        let (none, planned) = (BTreeMap::new(), &plan.request);
        let (velocities, beyond) = (*velocities, &none);
        let context = Context { model, planned, velocities, conditions, scene_state, beyond };
        let at = |node: Option<Label>| {
            let place = node.and_then(|label| labels.binary_search(&label).ok());
            place.and_then(|place| moved.get(place)).unwrap_or(&STILL)
        };
        let chosen = plan.connectors.iter().filter_map(|index| Some((*index, model.rings.get(index)?)));
        for (index, ring) in chosen {
            let Some(element) = model.connectors.get(index) else { continue };
            if !element.behavior.slides(planned) {
                continue;
            }
            let next = ring.next.and_then(|next| Some((next, model.connectors.get(next)?)));
            let Some((next, beyond)) = next else {
                found.insert(
                    index,
                    Beyond { tension: Err(Unknown::OpposedBelts), angle: 0.0, wrap: Wrap::Given },
                );
                continue;
            };
            let direction = |of: &ConnectorElement| place(of, of.nodes.map(at)).0.pair.separation();
            let measured = || Wrap::measured(direction(element), direction(beyond));
            let (angle, wrap) = ring.angle.map_or_else(measured, |angle| (angle, Wrap::Given));
            let memory = plan.connectors.binary_search(&next).ok().and_then(|place| connectors.get(place));
            // What came before is not known of a segment that is not planned.
            let is_known = self.states == 0 || memory.is_some_and(|memory| memory.behavior.is_some());
            let tension = if is_known || !beyond.behavior.remembers_tension() {
                context.tension(beyond, beyond.nodes.map(at), memory, tally)
            } else {
                Err(Unknown::Part)
            };
            found.insert(index, Beyond { tension, angle, wrap });
        }
        found
    }

    fn walk<T: Send, E>(
        &mut self,
        state: &SceneState,
        is_wanted: bool,
        digest: impl Fn(Item) -> T + Sync,
        mut take: impl FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        self.follow_nodes(state);
        let beyond = self.beyond(state);
        let nothing = Request::nothing(0);
        let request = if is_wanted { &self.plan.request } else { &nothing };
        let Self {
            model,
            plan,
            moved,
            ends,
            connectors,
            followed,
            needed,
            tally,
            velocities,
            conditions,
            ..
        } = self;
        let context = Context {
            model,
            planned: &plan.request,
            velocities: *velocities,
            conditions,
            scene_state: state,
            beyond: &beyond,
        };
        parallel::in_order(
            connectors,
            |at, memory| {
                let mut tally = Tally::default();
                let nodes = ends[at].map(|end| end.map_or(&STILL, |end| &moved[end as usize]));
                let Needed { by_plan, always } = needed[at];
                let is_needed = if is_wanted { by_plan } else { always };
                let history = (followed[at], is_needed);
                let result =
                    context.connector(plan.connectors[at], nodes, memory, request, history, &mut tally);
                (digest(Item::Connector(Box::new(result))), tally)
            },
            |_, (digested, work)| {
                *tally += work;
                take(digested)
            },
        )?;
        let Self { mpc_nodes, mpcs, .. } = self;
        parallel::in_order(
            mpcs,
            |at, angles| {
                let mut tally = Tally::default();
                let index = plan.mpcs[at];
                let nodes = mpc_nodes[at].iter().map(|node| node.map_or(STILL, |node| moved[node as usize]));
                let nodes: Vec<Moved> = nodes.collect();
                let of_state = (request, &model.schedule, state);
                let result = model.mpcs[index].evaluate(index, &nodes, angles, of_state, &mut tally);
                *angles = result.evaluation.angles;
                (digest(Item::Mpc(Box::new(result))), tally)
            },
            |_, (digested, work)| {
                *tally += work;
                take(digested)
            },
        )?;
        self.states += 1;
        Ok(())
    }
}

/// What all connectors share at one state.
#[derive(Clone, Copy)]
struct Context<'a> {
    model: &'a Model,
    /// What is planned for all states.
    planned: &'a Request,
    velocities: Velocities,
    conditions: &'a Conditions,
    scene_state: &'a SceneState,
    /// What the friction of belts needs, by connector.
    beyond: &'a BTreeMap<usize, Beyond>,
}

impl Context<'_> {
    /// The tension of a SLIPRING at the next state, which is not committed.
    fn tension(
        &self,
        element: &ConnectorElement,
        ends: [&Moved; 2],
        memory: Option<&Memory>,
        tally: &mut Tally,
    ) -> Result<f64, Unknown> {
        let (connector, behavior) = (&element.connector, &element.behavior);
        let given = given_forces(connector, self.scene_state, element.label);
        let given = given.map_err(|_| Unknown::ForcesRefused)?.unwrap_or_default();
        if behavior.is_empty() {
            return given[0].ok_or(Unknown::Part);
        }
        let (state, increment) = place(element, ends);
        let before = memory.map_or_else(|| connector.initial_branch(), |memory| memory.branch);
        let needed = behavior.request(&Request::nothing(0), false);
        tally.behaviors += 1;
        let evaluation = connector.evaluate(&state, &increment, &before, &needed, tally);
        let known = Kinematics::of(&evaluation, self.scene_state.time, self.velocities);
        let now = Kinematics { slides: false, ..known };
        let driven = (&behavior.drives, &self.model.schedule);
        let none = History::default();
        let history = memory.and_then(|memory| memory.behavior.as_deref()).unwrap_or(&none);
        let outcome = behavior.behavior.at(&now, &given, driven, self.conditions, history);
        outcome.total.value[0].ok_or(outcome.total.unknown[0].unwrap_or(Unknown::Part))
    }

    /// Evaluates a connector and commits its state to its memory.
    fn connector(
        &self,
        index: usize,
        ends: [&Moved; 2],
        memory: &mut Memory,
        request: &Request,
        (followed, needs_behavior): (Mask, bool),
        tally: &mut Tally,
    ) -> ConnectorResult {
        let Self { model, planned, velocities, conditions, scene_state, beyond } = *self;
        let element = &model.connectors[index];
        let (state, increment) = place(element, ends);
        let connector = &element.connector;
        let before = memory.branch;
        let behavior = needs_behavior.then_some(&*element.behavior);
        let slides = behavior.is_some_and(|behavior| behavior.slides(planned));
        let needed = behavior.map(|behavior| behavior.request(request, slides));
        tally.behaviors += u64::from(behavior.is_some());
        let next = connector.follow(&state, &increment, &before, followed, tally);
        let mut evaluation = connector.evaluate_on(&state, next, needed.as_ref().unwrap_or(request), tally);
        let mut stops = connector.stop_status(&evaluation.position);
        for (k, status) in stops.iter_mut().enumerate() {
            *status = status.filter(|_| request.wants(Output::CSLST, k));
        }
        let margins = connector.margins(&state, &evaluation.branch, request.components());
        tally.margins += margins.iter().flatten().count() as u64;
        let after = evaluation.branch;
        let mut flags = connector.flags_of(followed, &margins, &increment, &state, [&before, &after]);
        let given = given_forces(connector, scene_state, element.label);
        flags.extend(given.err().map(Flag::refused));
        let given = given.unwrap_or_default();
        let none = History::default();
        let history = memory.behavior.as_deref().unwrap_or(&none);
        let outcome = behavior.map(|behavior| {
            let known = Kinematics::of(&evaluation, scene_state.time, velocities);
            let now = Kinematics { slides, beyond: beyond.get(&index).copied(), ..known };
            let given = given.unwrap_or_default();
            let driven = (&behavior.drives, &model.schedule);
            behavior.behavior.at(&now, &given, driven, conditions, history)
        });
        let mut tangent = None;
        if let (Some(behavior), Some(outcome)) = (behavior, &outcome) {
            for k in (0..6).filter(|k| request.wants(Output::CSLST, *k)) {
                stops[k] = outcome.held[k];
            }
            for (k, residual) in outcome.residual.iter().enumerate() {
                let Some([position, rate, second]) = residual else { continue };
                let put = |place: &mut Option<f64>, output, value: Option<f64>| {
                    if request.wants(output, k) {
                        *place = value;
                    }
                };
                put(&mut evaluation.residual[k], Output::RES, *position);
                put(&mut evaluation.residual_rate[k], Output::RESV, *rate);
                put(&mut evaluation.residual_acceleration[k], Output::RESA, *second);
            }
            let wants_slopes = SLOPES.into_iter().any(|output| wants(request, output));
            // Where slopes jump matters to those who ask for slopes.
            let told = outcome.events.iter().filter(|event| wants_slopes || !matches!(event, Event::Kink(_)));
            flags.extend(told.map(|event| flag(*event)));
            flags.extend(not_known(outcome, request));
            if wants_slopes {
                let slopes = behavior.behavior.consistent_tangent(outcome, conditions, history);
                flags.extend(slopes_not_known(&slopes, request));
                tangent = Some(Box::new(slopes));
            }
        }
        // The total forces that are known: as given, or as the behaviour tells.
        let known_forces = outcome.as_ref().map(|outcome| {
            let given = given.unwrap_or_default();
            [0, 1, 2, 3, 4, 5].map(|k| outcome.total.value[k].or(given[k]))
        });
        let total = known_forces.filter(|forces| forces.iter().any(Option::is_some)).or(given);
        let slopes = tangent.as_deref();
        let forces = ForceResult::of(connector, (&state, &evaluation), total, slopes, request, tally);
        flags.extend(forces.iter().flat_map(|forces| &forces.flags));
        let history = outcome.as_ref().filter(|_| behavior.is_some_and(ElementBehavior::has_history));
        let history = history.map(|outcome| outcome.history.clone());
        *memory = Memory { branch: after, behavior: history.map(Box::new) };
        let behavior = outcome.map(Box::new);
        ConnectorResult {
            index,
            state,
            increment,
            before,
            evaluation,
            stops,
            margins,
            flags,
            behavior,
            tangent: tangent.filter(|_| wants(request, Output::TANGENT)),
            forces: forces.map(Box::new),
        }
    }
}

/// Marks nodes whose turning matters.
fn turns(turning: &mut [bool], nodes: &[Place]) {
    for place in nodes.iter().flatten() {
        if let Some(turns) = turning.get_mut(*place as usize) {
            *turns = true;
        }
    }
}

/// The state of a connector whose nodes are there, and its increment since the state before.
fn place(element: &ConnectorElement, ends: [&Moved; 2]) -> (State<f64>, Increment<f64>) {
    let node = |end: usize| Node {
        displacement: ends[end].displacement,
        triad: product(&ends[end].rotation, element.triads()[end]),
        flow: ends[end].flow,
    };
    let both = |of: fn(&Moved) -> &[f64; 7]| {
        let mut rates = [0.0; DOFS];
        rates[..7].copy_from_slice(of(ends[0]));
        rates[7..].copy_from_slice(of(ends[1]));
        rates
    };
    let state = State {
        pair: Pair { reference: element.reference, a: node(0), b: node(1) },
        velocity: both(|node| &node.rates),
        acceleration: both(|node| &node.accelerations),
    };
    let increment = Increment {
        rotation: ends.map(|end| end.change),
        whole_turns: ends.map(|end| end.whole_turns),
        flow: ends.map(|end| end.flow_change),
    };
    (state, increment)
}

/// Translational, rotational and flow rates of a node, in one.
const fn rates([x1, x2, x3]: Vector<f64>, [r1, r2, r3]: Vector<f64>, flow: f64) -> [f64; 7] {
    [x1, x2, x3, r1, r2, r3, flow]
}

/// Whether a node is turned by nothing, and no turns are to be remembered.
fn is_unturned(orientation: &Orientation) -> bool {
    orientation.quaternion == UNTURNED.quaternion && orientation.vector == UNTURNED.vector
}

/// A node at its next state: rotation matrix, and increments since the last one.
///
/// The increment is the rotation vector of C(new) C(old)ᵀ. It is principal, unless one of the two states gave a rotation
/// vector beyond half a turn: those keep their turns, and the increment then continues their difference. Vectors that are
/// wrapped at half a turn stay principal where π was rounded up: both within 0.001 rad of half a turn or less, and more than
/// 3π/2 apart. Of a node whose turning is not `followed` there is no increment.
fn follow(motion: &NodeMotion, before: &Orientation, given: bool, followed: bool) -> (Moved, Orientation) {
    if motion.rotation == Rotation::default() && is_unturned(before) {
        let node = Moved {
            displacement: motion.displacement,
            flow: motion.flow,
            rates: rates(motion.velocity, motion.angular_velocity, motion.flow_velocity),
            accelerations: rates(motion.acceleration, motion.angular_acceleration, motion.flow_acceleration),
            flow_change: motion.flow - before.flow,
            sixth: given.then_some(0.0),
            ..STILL
        };
        return (node, Orientation { flow: motion.flow, ..UNTURNED });
    }
    let quaternion = match motion.rotation {
        Rotation::Vector(phi) => so3::exp(phi),
        Rotation::Quaternion(q) => so3::normalize(q),
    };
    let still = [0.0; 3];
    let relative = so3::compose(quaternion, so3::conjugate(before.quaternion));
    let principal = if followed { so3::log_quaternion(relative) } else { still };
    let (vector, change) = match motion.rotation {
        Rotation::Vector(new) if !followed => (new, still),
        Rotation::Vector(new) if keep_turns(new, before.vector) => {
            (new, so3::continuous_log_quaternion(relative, sub(new, before.vector)).phi)
        }
        Rotation::Vector(new) => (new, principal),
        Rotation::Quaternion(_) => (so3::continuous_log_quaternion(quaternion, before.vector).phi, principal),
    };
    let rotation = match motion.rotation {
        Rotation::Vector([0.0, 0.0, 0.0]) => identity(),
        _ => so3::matrix(quaternion),
    };
    let node = Moved {
        displacement: motion.displacement,
        rotation,
        flow: motion.flow,
        rates: rates(motion.velocity, motion.angular_velocity, motion.flow_velocity),
        accelerations: rates(motion.acceleration, motion.angular_acceleration, motion.flow_acceleration),
        change,
        whole_turns: sub(change, principal),
        flow_change: motion.flow - before.flow,
        sixth: match motion.rotation {
            Rotation::Vector(phi) if given => Some(phi[2]),
            _ => None,
        },
    };
    (node, Orientation { quaternion, vector, flow: motion.flow })
}

/// Whether turns of two consecutive rotation vectors count: one is beyond half a turn, and not by the rounding of π only.
fn keep_turns(new: Vector<f64>, old: Vector<f64>) -> bool {
    use std::f64::consts::PI;
    const ROUNDED_UP: f64 = 1e-3;
    let longest = norm(new).max(norm(old));
    longest > PI && (longest > PI + ROUNDED_UP || norm(sub(new, old)) < 1.5 * PI)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluate::Selection;

    /// The rotation about the axis 1 that a node has made after states that give it as rotation vectors.
    fn turned(angles: &[f64]) -> f64 {
        let mut before = UNTURNED;
        let mut sum = 0.0;
        for angle in angles {
            let motion =
                NodeMotion { rotation: Rotation::Vector([*angle, 0.0, 0.0]), ..NodeMotion::default() };
            let (node, after) = follow(&motion, &before, true, true);
            sum += node.change[0];
            before = after;
        }
        sum
    }

    /// Turns survive a change from quaternions to rotation vectors.
    #[test]
    fn quaternions_and_vectors_mix() {
        let quaternion = |angle: f64| Rotation::Quaternion(so3::exp([angle, 0.0, 0.0]));
        let mut before = UNTURNED;
        let mut sum = 0.0;
        for rotation in
            [quaternion(0.3), Rotation::Vector([20.6, 0.0, 0.0]), quaternion(22.0), quaternion(24.0)]
        {
            let (node, after) =
                follow(&NodeMotion { rotation, ..NodeMotion::default() }, &before, true, true);
            sum += node.change[0];
            before = after;
        }
        assert!((sum - 24.0).abs() < 1e-13, "{sum}");
        assert!((before.vector[0] - 24.0).abs() < 1e-13, "{:?}", before.vector);
    }

    #[test]
    fn vectors_keep_their_turns_or_are_wrapped() {
        let tau = std::f64::consts::TAU;
        let is =
            |angles: &[f64], expected: f64| assert!((turned(angles) - expected).abs() < 1e-12, "{angles:?}");
        is(&[3.0, 3.2, 7.0, 3000.0, 2.0], 2.0);
        is(&[3.0, 4.0, -4.0], -4.0);
        is(&[3.0, -3.0, -0.5], tau - 0.5);
        // Half a turn, as a file has it that rounds π up.
        let half = std::f64::consts::PI + 7e-6;
        is(&[half], half);
        is(&[3.0, half, 3.3], 3.3);
        is(&[3.0, half, -3.0], tau - 3.0);
        is(&[-3.0, half, 3.0], 3.0 - tau);
    }

    /// Branches belong to a type, nodes and geometry, and to nothing else.
    #[test]
    fn foreign_branches_are_refused() {
        let deck = |types: &str, x: &str| {
            let text = format!(
                "*NODE\n1, 0., 0., 0.\n2, {x}, 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
                 *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\n{types}\nO,\n"
            );
            let scene = crate::scene::Scene::parse("deck.inp", &text).unwrap();
            let model = Model::compile(&scene).unwrap();
            let plan = Plan::compile(&model, &Selection::All, Request::everything(0)).unwrap();
            (model, plan)
        };
        let (model, plan) = deck("CARTESIAN, CARDAN", "1.");
        let mut walk = Sequence::new(&model, &plan);
        walk.step(&SceneState::default());
        let branches = walk.branches();
        assert_eq!(branches.check(&model, &plan), Ok(()));
        let refusal = |types, x| {
            let (model, plan) = deck(types, x);
            branches.check(&model, &plan).unwrap_err()
        };
        assert!(
            refusal("CARTESIAN, EULER", "1.")
                .contains("saved for CARTESIAN + CARDAN, and it is CARTESIAN + EULER")
        );
        assert!(refusal("CARTESIAN, CARDAN", "2.").contains("initial positions"));
    }
}
