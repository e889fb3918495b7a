//! One connector at one state: its nodes, its numbers, and what its behaviour makes of them.

use crate::behavior::state::{Event, History, Kinematics, Outcome, Velocities};
use crate::behavior::{Beyond, Conditions, Tangent, Unknown};
use crate::evaluate::behavior::{SLOPES, flag, not_known, slopes_not_known, wants};
use crate::evaluate::forces::{ForceResult, given_forces};
use crate::evaluate::model::{ConnectorElement, ElementBehavior, Model};
use crate::evaluate::sequence::nodes::{Moved, ambiguous_turns};
use pintle_kinematics::connector::{
    Branch, Components, Evaluation, Flag, Increment, Mask, Output, Request, State, StopStatus, Tally,
};
use pintle_kinematics::measure::Margin;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::vector::{identity, product};
use pintle_scene::State as SceneState;
use std::collections::BTreeMap;

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

impl ConnectorResult {
    /// Room for a result: what is evaluated is written in place, three kilobytes that nobody moves.
    pub(super) fn room() -> Self {
        let still = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
        let branch = Branch::none();
        Self {
            index: 0,
            state: State {
                pair: Pair { reference: [0.0; 3], a: still, b: still },
                velocity: [0.0; DOFS],
                acceleration: [0.0; DOFS],
            },
            increment: Increment::none(),
            before: branch,
            evaluation: Evaluation::empty(branch),
            stops: [None; 6],
            margins: [None; 6],
            flags: Vec::new(),
            behavior: None,
            tangent: None,
            forces: None,
        }
    }
}

/// What a walk remembers of one connector.
#[derive(Clone, Debug)]
pub(super) struct Memory {
    pub(super) branch: Branch<f64>,
    /// What the behaviour has decided.
    pub(super) behavior: Option<Box<History>>,
}

/// Whether the behaviour of a connector has to be worked out, found once.
#[derive(Clone, Copy, Debug)]
pub(in crate::evaluate) struct Needed {
    /// At a state of which the plan's outputs are wanted.
    pub(in crate::evaluate) by_plan: bool,
    /// At any other, because later ones depend on it.
    pub(in crate::evaluate) always: bool,
}

impl Needed {
    pub(in crate::evaluate) fn of(behavior: &ElementBehavior, planned: &Request) -> Self {
        Self {
            by_plan: behavior.is_needed(planned, planned),
            always: behavior.is_needed(&Request::nothing(0), planned),
        }
    }
}

/// What all connectors share at one state.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    pub(super) model: &'a Model,
    /// What is planned for all states.
    pub(super) planned: &'a Request,
    pub(super) velocities: Velocities,
    pub(super) conditions: &'a Conditions,
    pub(super) scene_state: &'a SceneState,
    /// What the friction of belts needs, by connector.
    pub(super) beyond: &'a BTreeMap<usize, Beyond>,
}

impl Context<'_> {
    /// The tension of a SLIPRING at the next state, which is not committed.
    pub(super) fn tension(
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

    /// Evaluates a connector and commits its state to its memory; the result is written to `result`, over what was there.
    pub(super) fn connector(
        &self,
        (index, ends): (usize, [&Moved; 2]),
        memory: &mut Memory,
        request: &Request,
        (followed, needs_behavior): (Mask, bool),
        result: &mut ConnectorResult,
        tally: &mut Tally,
    ) {
        let element = &self.model.connectors[index];
        let connector = &element.connector;
        result.index = index;
        (result.state, result.increment) = place(element, ends);
        result.before = memory.branch;
        let (state, increment) = (&result.state, &result.increment);
        let after = connector.follow(state, increment, &memory.branch, followed, tally);
        let behavior = needs_behavior.then_some(&*element.behavior);
        let slides = behavior.is_some_and(|behavior| behavior.slides(self.planned));
        let needed = behavior.map(|behavior| behavior.request(request, slides));
        let needed = needed.as_ref().unwrap_or(request);
        connector.evaluate_into(&mut result.evaluation, state, after, needed, tally);
        result.stops = [None; 6];
        if wants(request, Output::CSLST) {
            let stops = connector.stop_status(&result.evaluation.position);
            for (k, stop) in stops.into_iter().enumerate().filter(|(k, _)| request.wants(Output::CSLST, *k)) {
                result.stops[k] = stop;
            }
        }
        result.margins = connector.margins(state, &after, request.components());
        tally.margins += result.margins.iter().flatten().count() as u64;
        result.flags =
            connector.flags_of(followed, &result.margins, increment, state, [&memory.branch, &after]);
        if connector.history_turns(followed) {
            result.flags.extend(ambiguous_turns([("a", ends[0]), ("b", ends[1])]));
        }
        memory.branch = after;
        let given = given_forces(connector, self.scene_state, element.label);
        result.flags.extend(given.as_ref().err().copied().map(|code| Flag::refused(code.as_str())));
        let given = given.unwrap_or_default();
        (result.behavior, result.tangent) = (None, None);
        // The total forces that are known: as given, or as the behaviour tells.
        let mut total = given;
        if let Some(behavior) = behavior {
            tally.behaviors += 1;
            self.act(behavior, (given.unwrap_or_default(), slides), memory, request, result);
            if let Some(outcome) = &result.behavior {
                let known =
                    [0, 1, 2, 3, 4, 5].map(|k| outcome.total.value[k].or(given.and_then(|given| given[k])));
                total = Some(known).filter(|forces| forces.iter().any(Option::is_some)).or(given);
            }
        } else {
            memory.behavior = None;
        }
        let driven = element.behavior.drives.motions.each_ref().map(Option::is_some);
        result.flags.extend(connector.off_constraint(
            &result.state.pair,
            &result.evaluation.residual,
            driven,
            self.model.length,
        ));
        let (at, slopes) = ((&result.state, &result.evaluation), result.tangent.as_deref());
        let forces = ForceResult::of(connector, at, total, slopes, request, tally);
        result.flags.extend(forces.iter().flat_map(|forces| &forces.flags));
        result.forces = forces.map(Box::new);
        if !wants(request, Output::TANGENT) {
            result.tangent = None;
        }
    }

    /// What the behaviour of a connector makes of its motion, and of the forces given: its part of the result.
    fn act(
        &self,
        behavior: &ElementBehavior,
        (given, slides): (Components<f64>, bool),
        memory: &mut Memory,
        request: &Request,
        result: &mut ConnectorResult,
    ) {
        let Self { model, velocities, conditions, scene_state, beyond, .. } = *self;
        let evaluation = &mut result.evaluation;
        let none = History::default();
        let history = memory.behavior.as_deref().unwrap_or(&none);
        let known = Kinematics::of(evaluation, scene_state.time, velocities);
        let now = Kinematics { slides, beyond: beyond.get(&result.index).copied(), ..known };
        let driven = (&behavior.drives, &model.schedule);
        let outcome = behavior.behavior.at(&now, &given, driven, conditions, history);
        for k in (0..6).filter(|k| request.wants(Output::CSLST, *k)) {
            result.stops[k] = outcome.held[k];
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
        result.flags.extend(told.map(|event| flag(*event)));
        result.flags.extend(not_known(&outcome, request));
        if wants_slopes {
            let slopes = behavior.behavior.consistent_tangent(&outcome, conditions, history);
            result.flags.extend(slopes_not_known(&slopes, request));
            result.tangent = Some(Box::new(slopes));
        }
        memory.behavior = behavior.has_history().then(|| Box::new(outcome.history.clone()));
        result.behavior = Some(Box::new(outcome));
    }
}

/// The state of a connector whose nodes are there, and its increment since the state before.
pub(in crate::evaluate) fn place(
    element: &ConnectorElement,
    ends: [&Moved; 2],
) -> (State<f64>, Increment<f64>) {
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
