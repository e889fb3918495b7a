//! States in order: nodes once, connectors as planned, branches committed.

mod assemble;
mod belts;
mod branches;
mod element;
mod lanes;
pub(super) mod nodes;

use crate::behavior::Conditions;
use crate::behavior::state::Velocities;
use crate::evaluate::model::Model;
use crate::evaluate::mpc::{MpcResult, START};
use crate::evaluate::parallel;
use crate::evaluate::parallel::in_order;
use crate::evaluate::places::Places;
use crate::evaluate::plan::Plan;
use crate::evaluate::relation::RelationResult;
use branches::{Saved, followed};
use element::{Context, Memory};
pub(super) use element::{Needed, place};
use lanes::Lanes;
use nodes::{Moved, Orientation, STILL, UNTURNED, is_unturned};
use pintle_kinematics::connector::{Mask, Request, Tally, Turns};
use pintle_kinematics::mpc;
use pintle_scene::{Label, NodeMotion, Rotation, State as SceneState};
use std::convert::Infallible;
use std::sync::Arc;

pub use branches::Branches;
pub use element::ConnectorResult;

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
    /// Equations, rigid bodies, couplings and ties in the order of the plan.
    pub relations: Vec<RelationResult>,
}

/// What a walk hands on at one state: results in the room of the walk, which the next ones take again.
#[derive(Clone, Copy, Debug)]
pub enum Item<'a> {
    /// A connector.
    Connector(&'a ConnectorResult),
    /// A multi-point constraint.
    Mpc(&'a MpcResult),
    /// A relation.
    Relation(&'a RelationResult),
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
    /// The nodes of connectors, MPCs and relations, in the order of the plan.
    ends: Vec<[Place; 2]>,
    mpc_nodes: Vec<Vec<Place>>,
    relation_nodes: Vec<Vec<Place>>,
    connectors: Vec<Memory>,
    /// The components of each connector whose history is followed.
    followed: Vec<Mask>,
    /// Whether the behaviour of each has to be worked out.
    needed: Vec<Needed>,
    mpcs: Vec<[Turns<f64>; 2]>,
    tally: Tally,
    velocities: Velocities,
    conditions: Conditions,
    /// What the pattern of the Jacobian whose histories are followed shares with its copies.
    pattern: Option<Arc<()>>,
    /// Those whose rows it takes four at a time.
    lanes: Arc<Lanes>,
    /// Room for results.
    rooms: Rooms,
}

/// Room for results: a walk that is copied makes its own.
#[derive(Debug, Default)]
struct Rooms(Vec<Room>);

/// Room for the result of a connector, and for those of constraints where there are some.
#[derive(Debug)]
struct Room {
    connector: ConnectorResult,
    mpc: Option<Box<MpcResult>>,
    relation: Option<Box<RelationResult>>,
}

/// The parts of a walk, in their order.
#[derive(Clone, Copy, Debug)]
enum Phase {
    Connectors,
    Mpcs,
    Relations,
}

impl Default for Room {
    fn default() -> Self {
        Self { connector: ConnectorResult::room(), mpc: None, relation: None }
    }
}

impl Room {
    /// The result that was put here for that phase of a walk.
    fn item(&self, phase: Phase) -> Option<Item<'_>> {
        match phase {
            Phase::Connectors => Some(Item::Connector(&self.connector)),
            Phase::Mpcs => self.mpc.as_deref().map(Item::Mpc),
            Phase::Relations => self.relation.as_deref().map(Item::Relation),
        }
    }
}

impl Clone for Rooms {
    fn clone(&self) -> Self {
        Self::default()
    }
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
        let places = Places::new(&labels);
        let place = |label: Label| places.of(label).and_then(|at| u32::try_from(at).ok());
        let ends = |index: &usize| model.connectors[*index].nodes.map(|node| node.and_then(place));
        let of_mpc = |index: &usize| model.mpcs[*index].nodes.iter().map(|node| place(*node)).collect();
        let of_relation =
            |index: &usize| model.relations[*index].nodes.iter().map(|node| place(*node)).collect();
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
        let relation_nodes: Vec<Vec<Place>> = plan.relations.iter().map(of_relation).collect();
        // What follows from a behaviour is found once for all connectors in a row that share it.
        let (mut followed_of, mut needed) = (Vec::new(), Vec::new());
        let mut last = None;
        for index in &plan.connectors {
            let behavior = &model.connectors[*index].behavior;
            let (mask, need) = match last {
                Some((known, mask, need)) if Arc::ptr_eq(known, behavior) => (mask, need),
                _ => (followed(behavior, plan), Needed::of(behavior, &plan.request)),
            };
            last = Some((behavior, mask, need));
            followed_of.push(mask);
            needed.push(need);
        }
        let mut turning = vec![false; labels.len()];
        for (index, (ends, followed)) in plan.connectors.iter().zip(ends.iter().zip(&followed_of)) {
            if model.connectors[*index].connector.history_turns(*followed) {
                turns(&mut turning, ends);
            }
        }
        mpc_nodes.iter().for_each(|nodes| turns(&mut turning, nodes));
        for (index, nodes) in plan.relations.iter().zip(&relation_nodes) {
            if model.relations[*index].follows_turns() {
                turns(&mut turning, nodes);
            }
        }
        Self {
            states: branches.states,
            ends,
            mpc_nodes,
            relation_nodes,
            mpcs: plan.mpcs.iter().map(angles).collect(),
            nodes: labels.iter().map(turned).collect(),
            connectors: plan.connectors.iter().map(memory).collect(),
            followed: followed_of,
            turning,
            needed,
            moved: vec![STILL; labels.len()],
            labels,
            tally: Tally::default(),
            velocities: Velocities::default(),
            conditions: Conditions::default(),
            pattern: None,
            lanes: Arc::default(),
            rooms: Rooms::default(),
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
            (element.label, Saved::new(element, memory.branch, *followed, history))
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

    /// Evaluates the plan at the next state and commits it. What is large is better visited ([`Sequence::visit`]).
    pub fn step(&mut self, state: &SceneState) -> StepResult {
        let (index, time) = (self.states, state.time);
        let mut mpcs = Vec::with_capacity(self.plan.mpcs.len());
        let mut relations = Vec::with_capacity(self.plan.relations.len());
        let kept = std::mem::take(&mut self.rooms);
        self.rooms.0.resize_with(self.plan.connectors.len(), Room::default);
        let Ok(()) = self.walk_through(state, true, |item| -> Result<(), Infallible> {
            match item {
                Item::Connector(_) => {}
                Item::Mpc(result) => mpcs.push(result.clone()),
                Item::Relation(result) => relations.push(result.clone()),
            }
            Ok(())
        });
        let Rooms(rooms) = std::mem::replace(&mut self.rooms, kept);
        let count = self.plan.connectors.len();
        let connectors = rooms.into_iter().take(count).map(|room| room.connector).collect();
        StepResult { index, time, connectors, mpcs, relations }
    }

    /// Evaluates the plan at the next state and hands on one result at a time, connectors first, both in the order of the
    /// plan, so that a large model is never held as results. The state is committed when all have been taken.
    ///
    /// # Errors
    /// The first error of `take`; the walk must then be given up.
    pub fn visit<E>(
        &mut self,
        state: &SceneState,
        take: impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.walk_through(state, true, take)
    }

    /// The same, where each result is worked into something else by `digest`, on the thread that computed it, before it is taken.
    ///
    /// What it is worked into are `rooms`, made as they are needed and used again and again, also from state to state: `digest` overwrites
    /// what an earlier result has left there. What they have allocated is not allocated again.
    ///
    /// # Errors
    /// The first error of `take`; the walk must then be given up.
    pub fn visit_digested<T: Default + Send, E>(
        &mut self,
        state: &SceneState,
        rooms: &mut Vec<T>,
        digest: impl Fn(Item<'_>, &mut T) + Sync,
        mut take: impl FnMut(&mut T) -> Result<(), E>,
    ) -> Result<(), E> {
        self.walk(state, true, rooms, &Digest(digest), |digested, _| take(digested))
    }

    /// Commits the next state without any output: branches follow it, and results carry their flags only.
    ///
    /// # Errors
    /// The first error of `take`; the walk must then be given up.
    pub fn pass<E>(
        &mut self,
        state: &SceneState,
        take: impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.walk_through(state, false, take)
    }

    /// Hands on the results themselves.
    fn walk_through<E>(
        &mut self,
        state: &SceneState,
        is_wanted: bool,
        mut take: impl FnMut(Item<'_>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut rooms = std::mem::take(&mut self.rooms);
        let done = self.walk(state, is_wanted, &mut rooms.0, &Whole, |room, phase| {
            room.item(phase).map_or(Ok(()), &mut take)
        });
        self.rooms = rooms;
        done
    }

    /// Where the nodes of the plan are at the next state.
    fn follow_nodes(&mut self, state: &SceneState) {
        // Both are in order: the motions are found by going along, unless few nodes of many are planned.
        const FEW: usize = 16;
        let is_sparse = self.labels.len() < state.nodes.len() / FEW;
        let first = self.states == 0;
        let size = parallel::part(self.labels.len());
        let places = self.nodes.chunks_mut(size).zip(self.moved.chunks_mut(size));
        let parts = self.labels.chunks(size).zip(self.turning.chunks(size)).zip(places).collect();
        let rotations = parallel::parts(parts, |((labels, turning), (orientations, all_moved))| {
            let later = labels.first().map(|first| state.nodes.range(first..));
            let mut given = later.into_iter().flatten().peekable();
            let mut motion = |label: &Label| {
                if is_sparse {
                    return state.nodes.get(label);
                }
                while given.next_if(|(known, _)| *known < label).is_some() {}
                given.next_if(|(known, _)| *known == label).map(|(_, motion)| motion)
            };
            let (mut rotations, still) = (0, NodeMotion::default());
            let places = orientations.iter_mut().zip(all_moved);
            for ((label, is_followed), (orientation, moved)) in labels.iter().zip(turning).zip(places) {
                let given = motion(label);
                let motion = given.unwrap_or(&still);
                let is_turned = motion.rotation != Rotation::default() || !is_unturned(orientation);
                moved.follow(motion, orientation, given.is_some(), *is_followed, first);
                rotations += u64::from(is_turned);
            }
            rotations
        });
        self.tally.rotations += rotations.iter().sum::<u64>();
    }

    fn walk<T: Default + Send, E>(
        &mut self,
        state: &SceneState,
        is_wanted: bool,
        rooms: &mut Vec<T>,
        keep: &impl Keep<T>,
        mut take: impl FnMut(&mut T, Phase) -> Result<(), E>,
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
            mpc_nodes,
            relation_nodes,
            mpcs,
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
        let counts = [connectors.len(), mpcs.len(), relation_nodes.len()];
        let held = counts.into_iter().map(parallel::held).max().unwrap_or_default();
        rooms.resize_with(rooms.len().max(held), T::default);
        *tally += in_order(
            connectors,
            rooms,
            || keep.own(),
            |own, at, memory, room| {
                let nodes = ends[at].map(|end| end.map_or(&STILL, |end| &moved[end as usize]));
                let Needed { by_plan, always } = needed[at];
                let history = (followed[at], if is_wanted { by_plan } else { always });
                let (of, mut tally) = ((plan.connectors[at], nodes), Tally::default());
                keep.connector(own, room, &mut |result| {
                    context.connector(of, memory, request, history, result, &mut tally);
                });
                tally
            },
            |room| take(room, Phase::Connectors),
        )?;
        *tally += in_order(
            mpcs,
            rooms,
            || (),
            |(), at, angles, room| {
                let mut tally = Tally::default();
                let index = plan.mpcs[at];
                let (nodes, count) = at_mpc(&mpc_nodes[at], moved);
                let of_state = (request, &model.schedule, state);
                let result = model.mpcs[index].evaluate(index, &nodes[..count], angles, of_state, &mut tally);
                *angles = result.evaluation.angles;
                keep.mpc(result, room);
                tally
            },
            |room| take(room, Phase::Mpcs),
        )?;
        *tally += in_order(
            relation_nodes,
            rooms,
            || (),
            |(), at, nodes, room| {
                let mut tally = Tally::default();
                let index = plan.relations[at];
                let result =
                    model.relations[index].evaluate(index, at_relation(nodes, moved), request, &mut tally);
                keep.relation(result, room);
                tally
            },
            |room| take(room, Phase::Relations),
        )?;
        self.states += 1;
        Ok(())
    }
}

/// What is kept of results until they are taken, in rooms of which each is used again and again.
trait Keep<T>: Sync {
    /// What one thread uses for one result after the other.
    type Own;

    fn own(&self) -> Self::Own;

    /// Has a connector evaluated and keeps what came of it.
    fn connector(&self, own: &mut Self::Own, room: &mut T, evaluate: &mut dyn FnMut(&mut ConnectorResult));

    /// Keeps what came of an MPC.
    fn mpc(&self, result: MpcResult, room: &mut T);

    /// Keeps what came of a relation.
    fn relation(&self, result: RelationResult, room: &mut T);
}

/// The results themselves.
struct Whole;

impl Keep<Room> for Whole {
    type Own = ();

    fn own(&self) {}

    fn connector(&self, (): &mut (), room: &mut Room, evaluate: &mut dyn FnMut(&mut ConnectorResult)) {
        evaluate(&mut room.connector);
    }

    fn mpc(&self, result: MpcResult, room: &mut Room) {
        match &mut room.mpc {
            Some(place) => **place = result,
            none => *none = Some(Box::new(result)),
        }
    }

    fn relation(&self, result: RelationResult, room: &mut Room) {
        room.relation = Some(Box::new(result));
    }
}

/// What is made of them: a result stays with the thread that computes it.
struct Digest<D>(D);

impl<T, D: Fn(Item<'_>, &mut T) + Sync> Keep<T> for Digest<D> {
    type Own = ConnectorResult;

    fn own(&self) -> ConnectorResult {
        ConnectorResult::room()
    }

    fn connector(
        &self,
        own: &mut ConnectorResult,
        room: &mut T,
        evaluate: &mut dyn FnMut(&mut ConnectorResult),
    ) {
        evaluate(own);
        self.0(Item::Connector(own), room);
    }

    fn mpc(&self, result: MpcResult, room: &mut T) {
        self.0(Item::Mpc(&result), room);
    }

    fn relation(&self, result: RelationResult, room: &mut T) {
        self.0(Item::Relation(&result), room);
    }
}

/// The nodes of a constraint where they are, and how many it has.
fn at_mpc(places: &[Place], moved: &[Moved]) -> ([Moved; mpc::NODES], usize) {
    let mut nodes = [STILL; mpc::NODES];
    for (node, place) in nodes.iter_mut().zip(places) {
        *node = place.map_or(STILL, |place| moved[place as usize]);
    }
    (nodes, places.len().min(mpc::NODES))
}

/// The nodes of a relation where they are.
fn at_relation<'m>(places: &'m [Place], moved: &'m [Moved]) -> impl Iterator<Item = &'m Moved> {
    places.iter().map(|place| place.map_or(&STILL, |place| &moved[place as usize]))
}

/// Marks nodes whose turning matters.
fn turns(turning: &mut [bool], nodes: &[Place]) {
    for place in nodes.iter().flatten() {
        if let Some(turns) = turning.get_mut(*place as usize) {
            *turns = true;
        }
    }
}
