//! A scene: every connector and every multi-point constraint at its states.

use crate::behavior::audit_behavior;
use crate::case::failing::{MpcCase, RelationCase, SlopesCase};
use crate::case::quantity::Quantity;
use crate::case::{Case, Step};
use crate::engine::{SOMETIMES, audit_case, checks_of, laws_of_type};
use crate::friction::{Slipping, audit_slipping, drawn, restored, slipping};
use crate::judge::outcome::{Check, Expected, Report, Subject};
use crate::judge::verdict::Verdict;
use crate::oracles::certificate::{
    certificate, certificate_named, certificate_of_mpc, certifies_frictions, certifies_springs,
};
use crate::relation::differentiated;
use crate::sampling::about_initial;
use crate::sampling::coverage::{Coverage, Sample};
use crate::settings::{Budget, Settings};
use crate::share::{Chosen, Share};
use pintle_kinematics::connector::{Output, Request};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{add, sub};
use pintle_model::behavior::state::History;
use pintle_model::evaluate::{
    ConnectorElement, ConnectorResult, ElementBehavior, Item, Model, MpcResult, Plan, RelationResult,
    Sequence,
};
use pintle_scene::State;
use rayon::prelude::*;
use std::collections::HashMap;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Instant;

/// A scene to be audited.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// Its name in the report.
    pub name: &'a str,
    /// The scene, resolved.
    pub model: &'a Model,
    /// What is planned: which connectors and constraints.
    pub plan: &'a Plan,
    /// Its states, in order; without any, states are drawn about the initial one.
    pub states: &'a [State],
}

/// How many connectors are judged at a time: so many cases are held at once.
const AT_ONCE: usize = 256;

/// The share of all scenes that is judged where no budget is given, in units of [`Chosen::cost`]: a minute or so.
const UNITS: u64 = 60_000;

/// What costs more than that (units) is tried first, to say how long it will take.
const TRIED: u64 = 4_000;

/// What is tried (units).
const TRIAL: u64 = 300;

/// A budget is spent in so many parts, each an even sample by itself: one that ends early leaves one.
const PARTS: usize = 4;

/// The part of a budget that is planned: trials are short, and other programs run.
const PLANNED: f64 = 0.8;

/// How far the numbers of scenes are judged.
#[derive(Clone, Copy, Debug)]
pub enum Progress<'a> {
    /// So much of a scene is about to be judged; how long that will take (s), where it was tried.
    Begins(&'a Share, Option<f64>),
    /// So many more connector states were judged.
    Judged(usize),
}

/// Who is told of it.
type Listener<'a> = dyn Fn(Progress<'_>) + Sync + 'a;

/// What is gathered of one connector or constraint.
#[derive(Default)]
struct Gathered {
    cases: u64,
    checks: Vec<Check>,
}

/// A case of one connector or constraint.
enum Work {
    Connector(Box<Case>, Arc<ElementBehavior>, Option<Box<Slipping>>),
    Mpc(Box<MpcCase>),
    Relation(Box<RelationCase>),
}

/// One piece of work: whose it is, its number among the states, and whether it goes to the oracles on 237 bits.
struct Piece {
    place: usize,
    index: usize,
    is_wide: bool,
    work: Work,
}

/// Audits connectors and constraints of scenes at their states: all of them, or where they are many an even sample, of which
/// [`Report::sampled`] says the share.
pub fn audit_scenes(settings: &Settings, targets: &[Target<'_>], progress: &Listener<'_>) -> Report {
    let mut report = Report::new(settings, Vec::new(), Vec::new());
    for (at, target) in targets.iter().enumerate() {
        let (subjects, share) = audit_scene(settings, target, targets.len() - at, progress);
        report.subjects.extend(subjects);
        report.sampled.extend((!share.is_whole()).then_some(share));
    }
    report
}

/// What was chosen of a scene, and its share where all of that is judged.
fn choose(settings: &Settings, target: &Target<'_>, units: u64) -> (Chosen, Share) {
    let Target { model, plan, states, name } = *target;
    let chosen = Chosen::new(settings, (model, plan), states.len(), units);
    // Constraints of a scene without states are judged at their initial one.
    let of = |plan: &Plan, states: usize| {
        let of_mpcs = if target.states.is_empty() { 1 } else { states };
        let constraints = plan.mpcs.len() + plan.relations.len();
        (plan.connectors.len() * states + constraints * of_mpcs) as u64
    };
    let share = Share {
        scene: name.to_string(),
        connectors: chosen.count() as u64,
        of_connectors: (plan.connectors.len() + plan.mpcs.len() + plan.relations.len()) as u64,
        states: of(&chosen.plan, chosen.states),
        of_states: of(plan, chosen.of_states),
        judged: chosen.plan.connectors.clone(),
    };
    (chosen, share)
}

/// Audits one of so many scenes that are left.
fn audit_scene(
    settings: &Settings,
    target: &Target<'_>,
    left: usize,
    progress: &Listener<'_>,
) -> (Vec<Subject>, Share) {
    let (mut chosen, mut share) = choose(settings, target, UNITS);
    let end = settings.budget.map(|budget| Budget::from_now(budget.left() / left.max(1) as f64));
    let mut seconds = None;
    if end.is_some() || chosen.cost() > TRIED {
        let (trial, _) = choose(settings, target, TRIAL);
        let begin = Instant::now();
        Run::new(settings, target, &trial, &|_| {}).judge((0, 1), None);
        let each = begin.elapsed().as_secs_f64() / trial.cost().max(1) as f64;
        if let Some(end) = end {
            // A cast from a float takes the nearest number that there is.
            (chosen, share) = choose(settings, target, (PLANNED * end.left() / each) as u64);
        }
        seconds = Some(each * chosen.cost() as f64);
    }
    progress(Progress::Begins(&share, seconds));
    let mut run = Run::new(settings, target, &chosen, progress);
    match end {
        None => run.judge((0, 1), None),
        Some(end) => {
            let ends_early = (0..PARTS).any(|part| {
                run.judge((part, PARTS), Some(end));
                end.left() == 0.0
            });
            if ends_early {
                run.keep_judged(&mut share);
            }
        }
    }
    (run.subjects(), share)
}

/// The judging of what was chosen of a scene.
struct Run<'a> {
    settings: &'a Settings,
    target: Target<'a>,
    chosen: Chosen,
    progress: &'a Listener<'a>,
    gathered: Vec<Gathered>,
}

/// The budget is spent.
struct Spent;

impl<'a> Run<'a> {
    fn new(settings: &'a Settings, target: &Target<'a>, chosen: &Chosen, progress: &'a Listener<'a>) -> Self {
        let mut gathered = Vec::new();
        gathered.resize_with(chosen.count(), Gathered::default);
        Self { settings, target: *target, chosen: chosen.clone(), progress, gathered }
    }

    /// Judges one of so many parts of the sample, until the budget is spent.
    fn judge(&mut self, part: (usize, usize), end: Option<Budget>) {
        // What is left when the budget is spent is left out.
        _ = if self.target.states.is_empty() { self.drawn(part, end) } else { self.given(part, end) };
    }

    /// Judges what waits, if that is enough, or the last.
    fn judge_waiting(
        &mut self,
        waiting: &mut Vec<Piece>,
        end: Option<Budget>,
        is_last: bool,
    ) -> Result<(), Spent> {
        if waiting.len() < AT_ONCE && !is_last {
            return Ok(());
        }
        let count = waiting.len();
        judge(self.settings, std::mem::take(waiting), &mut self.gathered);
        (self.progress)(Progress::Judged(count));
        if end.is_some_and(|end| end.left() == 0.0) { Err(Spent) } else { Ok(()) }
    }

    /// The rank of a state among those that are judged of the connector or constraint at that place, where it is in the part.
    fn rank(&self, place: usize, index: usize, (part, parts): (usize, usize)) -> Option<usize> {
        self.chosen.rank(place, index).filter(|rank| (place + rank) % parts == part)
    }

    /// The states of the scene, in order.
    fn given(&mut self, part: (usize, usize), end: Option<Budget>) -> Result<(), Spent> {
        let (settings, Target { model, states, .. }) = (self.settings, self.target);
        // Walking needs every planned thing in the order of the plan.
        let follows = self.followed();
        let mut walk = walk(model, &follows);
        walk.set_conditions(settings.conditions.clone());
        // What the frictions of each connector remember.
        let mut left: Vec<History> = vec![History::default(); follows.connectors.len()];
        let mut waiting = Vec::new();
        for (index, state) in states.iter().enumerate() {
            let mut place = 0;
            let number = state.number.unwrap_or(index as u64);
            walk.visit(state, |placed| {
                let rank = self.rank(place, index, part);
                let work = match placed {
                    Item::Connector(placed) => {
                        let behavior = &model.connectors[placed.index].behavior;
                        let slides = placed.behavior.as_ref().filter(|_| behavior.behavior.slips_at_all());
                        let now = slides.map(|outcome| outcome.history.clone()).unwrap_or_default();
                        let before = left.get_mut(place).map(|left| std::mem::replace(left, now));
                        rank.map(|rank| {
                            let case = case(model, placed, number);
                            let left_and_given = (before.unwrap_or_default(), &settings.conditions);
                            let slips = slipping(placed, behavior, &case, left_and_given);
                            let slips =
                                slips.or_else(|| drawn(&case, behavior, &model.schedule, (settings, rank)));
                            Work::Connector(Box::new(case), Arc::clone(behavior), slips.map(Box::new))
                        })
                    }
                    Item::Mpc(placed) => rank.map(|_| Work::Mpc(Box::new(mpc_case(model, placed, number)))),
                    Item::Relation(placed) => {
                        rank.map(|_| Work::Relation(Box::new(relation_case(model, placed, number))))
                    }
                };
                if let (Some(index), Some(work)) = (rank, work) {
                    waiting.push(Piece { place, index, is_wide: self.chosen.is_wide(place, index), work });
                }
                place += 1;
                self.judge_waiting(&mut waiting, end, false)
            })?;
        }
        self.judge_waiting(&mut waiting, end, true)
    }

    /// States about the initial one, where a scene gives none: connectors at drawn ones, constraints at the initial one.
    fn drawn(&mut self, part: (usize, usize), end: Option<Budget>) -> Result<(), Spent> {
        let (settings, Target { model, .. }) = (self.settings, self.target);
        let plan = self.chosen.plan.clone();
        let mut waiting = Vec::new();
        for (place, at) in plan.connectors.iter().enumerate() {
            let Some(element) = model.connectors.get(*at) else { continue };
            for (index, case) in drawn_cases(settings, &self.target, element) {
                let (Some(rank), Some(case)) = (self.rank(place, index, part), case) else { continue };
                let is_wide = self.chosen.is_wide(place, rank);
                let behavior = Arc::clone(&element.behavior);
                let slips = drawn(&case, &behavior, &model.schedule, (settings, rank));
                let work = Work::Connector(Box::new(case), behavior, slips.map(Box::new));
                waiting.push(Piece { place, index: rank, is_wide, work });
            }
            self.judge_waiting(&mut waiting, end, false)?;
        }
        let alone = Plan { connectors: Vec::new(), request: Request::nothing(0), ..plan.clone() };
        let mut walk = Sequence::new(model, &alone);
        let mut place = plan.connectors.len();
        walk.visit(&State::default(), |placed| {
            let work = match placed {
                Item::Connector(_) => None,
                Item::Mpc(placed) => Some(Work::Mpc(Box::new(mpc_case(model, placed, 0)))),
                Item::Relation(placed) => Some(Work::Relation(Box::new(relation_case(model, placed, 0)))),
            };
            if let Some(work) = work.filter(|_| place % part.1 == part.0) {
                waiting.push(Piece { place, index: 0, is_wide: true, work });
            }
            place += 1;
            self.judge_waiting(&mut waiting, end, false)
        })?;
        self.judge_waiting(&mut waiting, end, true)
    }

    /// The plan, with what is asked of a walk: nothing, and where there is friction its forces and slopes, so that its history is
    /// followed.
    fn followed(&self) -> Plan {
        let slides = |at: &usize| {
            let element = self.target.model.connectors.get(*at);
            element.is_some_and(|element| element.behavior.behavior.slips_at_all())
        };
        let request = if self.chosen.plan.connectors.iter().any(slides) {
            Request::new(&[Output::CSF, Output::TANGENT], [true; 6], 0)
        } else {
            Request::nothing(0)
        };
        Plan { request, ..self.chosen.plan.clone() }
    }

    /// Keeps what was judged before the budget was spent.
    fn keep_judged(&mut self, share: &mut Share) {
        let is_judged: Vec<bool> = self.gathered.iter().map(|one| one.cases > 0).collect();
        self.gathered.retain(|one| one.cases > 0);
        let Plan { connectors, mpcs, relations, .. } = &mut self.chosen.plan;
        let mut is_judged = is_judged.into_iter();
        connectors.retain(|_| is_judged.next().unwrap_or(false));
        mpcs.retain(|_| is_judged.next().unwrap_or(false));
        relations.retain(|_| is_judged.next().unwrap_or(false));
        share.connectors = self.gathered.len() as u64;
        share.states = self.gathered.iter().map(|one| one.cases).sum();
        share.judged.clone_from(&self.chosen.plan.connectors);
    }

    fn subjects(mut self) -> Vec<Subject> {
        let follows = self.followed();
        let target = Target { plan: &self.chosen.plan, ..self.target };
        if follows.request.outputs().any(|output| output == Output::CSF) {
            for (place, check) in restored(&target, &follows, self.settings) {
                if let Some(one) = self.gathered.get_mut(place) {
                    checks_of(&mut one.checks, vec![check]);
                }
            }
        }
        subjects(&target, self.gathered)
    }
}

/// Audits pieces in parallel and gathers them in their order.
fn judge(settings: &Settings, pieces: Vec<Piece>, gathered: &mut [Gathered]) {
    let found: Vec<(usize, Vec<Check>)> = pieces
        .into_par_iter()
        .map(|Piece { place, index, is_wide, work }| match work {
            Work::Connector(case, element, slips) => {
                let mut checks = audit_case(&case, settings, is_wide, index);
                let proves = is_wide || index.is_multiple_of(SOMETIMES);
                checks.extend(
                    slips
                        .into_iter()
                        .flat_map(|slips| audit_slipping(&slips, &element, settings, (is_wide, proves))),
                );
                checks.extend(audit_behavior(&case, &element.behavior, settings, proves));
                (place, checks)
            }
            Work::Mpc(case) if is_wide => (place, case.audit(settings, true)),
            Work::Mpc(case) => (place, case.audit(settings, index.is_multiple_of(SOMETIMES))),
            Work::Relation(case) => (place, case.audit(settings, is_wide || index.is_multiple_of(SOMETIMES))),
        })
        .collect();
    for (place, checks) in found {
        if let Some(one) = gathered.get_mut(place) {
            one.cases += 1;
            checks_of(&mut one.checks, checks);
        }
    }
}

/// A connector at the states that are drawn about its initial one, the initial one first, by their numbers.
fn drawn_cases<'a>(
    settings: &Settings,
    target: &Target<'_>,
    element: &'a ConnectorElement,
) -> impl Iterator<Item = (usize, Option<Case>)> + 'a {
    let title = element.title();
    let length = own_length(target.model, norm(element.reference), 0.0);
    let mut draw = Draw::new(&format!("{} {} {title}", settings.seed, target.name));
    (0..settings.drawn_states.max(1)).map(move |index| {
        let name = match index {
            0 => format!("{title}, initial state"),
            _ => format!("{title}, drawn state {index}"),
        };
        (index, about_initial(&element.definition(), index, length, name, &mut draw))
    })
}

/// Which region of configuration space the states exercise at which [`audit_scenes`] judges connectors, by their indices in the model, of a
/// scene that gives none.
#[must_use]
pub fn drawn_coverage(settings: &Settings, target: &Target<'_>, connectors: &[usize]) -> Coverage {
    let samples = |at: &usize| -> Vec<Sample> {
        let Some(element) = target.model.connectors.get(*at) else { return Vec::new() };
        let definition = element.definition();
        let sample = |case: Case| {
            let state = &case.last()?.state;
            Some(Sample::of(&element.connector, &definition, state, target.model.length))
        };
        drawn_cases(settings, target, element).filter_map(|(_, case)| sample(case?)).collect()
    };
    let samples: Vec<Vec<Sample>> = connectors.par_iter().map(samples).collect();
    let mut coverage = Coverage::default();
    samples.iter().flatten().for_each(|sample| coverage.take(sample));
    coverage
}

/// s: the larger of the present and the initial length; that of the model where the nodes coincide.
fn own_length(model: &Model, initial: f64, present: f64) -> f64 {
    /// What is shorter than this part of the model is a coincidence with rounding.
    const COINCIDENT: f64 = 1e-9;
    let own = initial.max(present);
    if own > COINCIDENT * model.length { own } else { model.length }
}

/// A walk that follows every history, though nothing is asked for: what is judged starts from where it leads.
fn walk<'a>(model: &'a Model, plan: &'a Plan) -> Sequence<'a> {
    let mut walk = Sequence::new(model, plan);
    walk.follow_everything();
    walk
}

fn case(model: &Model, placed: &ConnectorResult, number: u64) -> Case {
    let element = &model.connectors[placed.index];
    let state = placed.state;
    Case {
        name: format!("{} at state {number}", element.title()),
        definition: element.definition(),
        start: Some(placed.before),
        path: vec![Step { state, increment: placed.increment }],
        length: own_length(model, norm(element.reference), norm(state.pair.separation())),
    }
}

/// A connector of a model at states of somebody's own: each case ends there, and comes from the state before. States that are
/// `independent` follow the initial one each.
#[must_use]
pub fn connector_at(model: &Model, connector: usize, states: &[State], independent: bool) -> Vec<Case> {
    let plan = Plan::of(model, vec![connector], Default::default(), Request::nothing(0));
    let (mut cases, mut before): (Vec<Case>, Option<Case>) = (Vec::new(), None);
    walk_along(model, &plan, (states, independent), |placed, number, _| {
        let Item::Connector(placed) = placed else { return };
        let mut case = case(model, placed, number);
        let before = before.replace(case.clone()).filter(|_| !independent);
        if let Some(before) = before {
            case.start = before.start;
            case.path.splice(..0, before.path);
        }
        cases.push(case);
    });
    cases
}

/// A multi-point constraint of a model at such states.
#[must_use]
pub fn constraint_at(model: &Model, mpc: usize, states: &[State], independent: bool) -> Vec<MpcCase> {
    let plan = Plan::of(model, Vec::new(), [vec![mpc], Vec::new()], Request::nothing(0));
    let mut cases = Vec::new();
    walk_along(model, &plan, (states, independent), |placed, number, _| {
        if let Item::Mpc(placed) = placed {
            cases.push(mpc_case(model, placed, number));
        }
    });
    cases
}

/// Takes what a plan gives at each state, with the state's number, and whether it is the last.
fn walk_along(
    model: &Model,
    plan: &Plan,
    (states, independent): (&[State], bool),
    mut take: impl FnMut(Item<'_>, u64, bool),
) {
    let start = walk(model, plan);
    let mut now = start.clone();
    for (index, state) in states.iter().enumerate() {
        if independent {
            now.clone_from(&start);
        }
        let number = state.number.unwrap_or(index as u64);
        let Ok(()) = now.visit(state, |placed| {
            take(placed, number, index + 1 == states.len());
            Ok::<_, Infallible>(())
        });
    }
}

fn mpc_case(model: &Model, placed: &MpcResult, number: u64) -> MpcCase {
    let element = &model.mpcs[placed.index];
    let arm = element.constraint.arm();
    let moved = sub(placed.state.slave.displacement, placed.state.master.displacement);
    let present = norm(add(arm, moved));
    MpcCase {
        name: format!("{} at state {number}", element.title()),
        constraint: element.constraint,
        state: placed.state,
        turning: placed.turning,
        before: placed.before,
        length: own_length(model, norm(arm), present),
    }
}

fn relation_case(model: &Model, placed: &RelationResult, number: u64) -> RelationCase {
    let element = &model.relations[placed.index];
    RelationCase {
        name: format!("{} at state {number}", element.title()),
        type_name: element.type_name.to_string(),
        relation: element.relation.clone(),
        nodes: placed.nodes.clone(),
        length: own_length(model, element.length(), 0.0),
    }
}

fn subjects(target: &Target<'_>, mut gathered: Vec<Gathered>) -> Vec<Subject> {
    let Target { model, plan, .. } = *target;
    let mut laws: HashMap<&str, Vec<Check>> = HashMap::new();
    for (at, one) in plan.connectors.iter().zip(&mut gathered) {
        let Some(element) = model.connectors.get(*at) else { continue };
        let connection = element.connector.connection();
        let of_type = laws.entry(&connection.name).or_insert_with(|| laws_of_type(connection));
        one.checks.extend(of_type.iter().cloned());
    }
    let connectors = plan.connectors.iter().filter_map(|at| {
        let element = model.connectors.get(*at)?;
        let connection = element.connector.connection();
        let slips = certifies_frictions(connection, &element.behavior.behavior.friction);
        let mut expected = Expected::of(&element.connector);
        if SlopesCase::acts(&element.behavior.behavior) {
            expected.add(Quantity::BehaviorTangent);
        }
        let names = (element.title(), connection.name.to_string());
        Some((names, certificate(connection), slips, expected))
    });
    let mpcs = plan.mpcs.iter().filter_map(|at| {
        let element = model.mpcs.get(*at)?;
        let kind = element.constraint.kind();
        let (names, of_kind) = ((element.title(), format!("MPC {}", kind.name())), certificate_of_mpc(kind));
        Some((names, of_kind, true, Expected::of_constraint()))
    });
    let relations = plan.relations.iter().filter_map(|at| {
        let element = model.relations.get(*at)?;
        let of_kind = certificate_named(element.type_name);
        let (nodes, compared) = (element.nodes.len(), differentiated(element.nodes.len()));
        let title = match element.title() {
            title if compared == nodes => title,
            title => format!("{title} (columns of {compared} of its {nodes} nodes)"),
        };
        Some((
            (title, element.type_name.to_string()),
            of_kind,
            true,
            Expected::of_relation(&element.relation),
        ))
    });
    let named = connectors.chain(mpcs).chain(relations).zip(gathered);
    named
        .map(|(((title, type_name), certificate, slips, expected), mut one)| {
            one.checks.sort_by_key(|check| (check.quantity.is_none(), check.quantity, check.against));
            let springs = one.checks.iter().any(|check| check.quantity == Some(Quantity::BehaviorTangent));
            let certified = slips && (!springs || certifies_springs());
            let subject = Subject::new(title, certificate, one.cases, one.checks, &expected);
            let least = if certified { Verdict::Pass } else { Verdict::Undecided };
            let formula = subject.formula.max(least);
            Subject { scene: Some(target.name.to_string()), type_name, formula, ..subject }
        })
        .collect()
}

/// The cases of some connectors, by their indices in increasing order, at the last state; at a drawn one where there is none.
pub(super) fn last_cases(target: &Target<'_>, connectors: &[usize]) -> Vec<(String, Case)> {
    let Target { model, states, .. } = *target;
    if states.is_empty() {
        let drawn = connectors.iter().filter_map(|at| {
            let element = model.connectors.get(*at)?;
            let title = element.title();
            let length = own_length(model, norm(element.reference), 0.0);
            let draw = &mut Draw::new(&format!("{} {title}", target.name));
            let name = format!("{title}, a drawn state");
            let case = about_initial(&element.definition(), 1, length, name, draw)?;
            Some((title, case))
        });
        return drawn.collect();
    }
    let plan = Plan {
        connectors: connectors.to_vec(),
        mpcs: Vec::new(),
        relations: Vec::new(),
        request: Request::nothing(0),
        ..target.plan.clone()
    };
    let mut found = Vec::new();
    walk_along(model, &plan, (states, false), |placed, number, is_last| {
        if let (Item::Connector(placed), true) = (placed, is_last) {
            found.push((model.connectors[placed.index].title(), case(model, placed, number)));
        }
    });
    found
}

/// The constraints at the last state; at the initial one, where no states are given.
pub(super) fn last_constraints(target: &Target<'_>) -> Vec<(String, MpcCase)> {
    let Target { model, states, plan, .. } = *target;
    let mut found = Vec::new();
    let initial = [State::default()];
    let states = if states.is_empty() { &initial[..] } else { states };
    walk_along(model, plan, (states, false), |placed, number, is_last| {
        if let (Item::Mpc(placed), true) = (placed, is_last) {
            found.push((model.mpcs[placed.index].title(), mpc_case(model, placed, number)));
        }
    });
    found
}
