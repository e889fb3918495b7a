//! A scene: every connector and every multi-point constraint at its states.

use crate::behavior::audit_behavior;
use crate::case::failing::SlopesCase;
use crate::case::failing::{MpcCase, RelationCase};
use crate::case::quantity::Quantity;
use crate::case::{Case, Step};
use crate::engine::{SOMETIMES, audit_case, checks_of, laws_of_type, spread_of};
use crate::friction::{Slipping, audit_slipping, drawn, restored, slipping};
use crate::judge::outcome::{Check, Expected, Report, Subject};
use crate::judge::verdict::Verdict;
use crate::oracles::certificate::{
    certificate, certificate_named, certificate_of_mpc, certifies_frictions, certifies_springs,
};
use crate::sampling::about_initial;
use crate::sampling::coverage::{Coverage, Sample};
use crate::settings::Settings;
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
const AT_ONCE: usize = 2048;

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

/// Audits every connector and constraint of scenes at their states. `progress` is told of each finished state.
pub fn audit_scenes(settings: &Settings, targets: &[Target<'_>], progress: &(dyn Fn(&str) + Sync)) -> Report {
    let subjects = targets.iter().flat_map(|target| audit_scene(settings, target, progress)).collect();
    Report::new(settings, subjects, Vec::new())
}

fn audit_scene(settings: &Settings, target: &Target<'_>, progress: &(dyn Fn(&str) + Sync)) -> Vec<Subject> {
    let Target { model, plan, states, .. } = *target;
    let count = plan.connectors.len() + plan.mpcs.len() + plan.relations.len();
    let mut gathered: Vec<Gathered> = Vec::new();
    gathered.resize_with(count, Gathered::default);
    let share = settings.wide_states_of_a_scene / count.max(1);
    let wide_states = settings.wide_states.min(share.max(1));
    let mut waiting = Vec::new();
    if states.is_empty() {
        draw_states(settings, target, wide_states, &mut gathered);
        progress(target.name);
    }
    // Walking needs every planned thing in the order of the plan.
    let follows = Plan { request: followed(target), ..plan.clone() };
    let mut walk = walk(model, &follows);
    walk.set_conditions(settings.conditions.clone());
    let is_wide = |place: usize, index: usize| spread_of(states.len(), wide_states, place).contains(&index);
    // What the frictions of each connector remember.
    let mut left: Vec<History> = vec![History::default(); plan.connectors.len()];
    for (index, state) in states.iter().enumerate() {
        let mut place = 0;
        let number = state.number.unwrap_or(index as u64);
        let Ok(()) = walk.visit(state, |placed| -> Result<(), Infallible> {
            let work = match placed {
                Item::Connector(placed) => {
                    let behavior = Arc::clone(&model.connectors[placed.index].behavior);
                    let case = case(model, placed, number);
                    let slides = placed.behavior.as_ref().filter(|_| behavior.behavior.slips_at_all());
                    let now = slides.map(|outcome| outcome.history.clone()).unwrap_or_default();
                    let before = left.get_mut(place).map(|left| std::mem::replace(left, now));
                    let left_and_given = (before.unwrap_or_default(), &settings.conditions);
                    let slips = slipping(placed, &behavior, &case, left_and_given);
                    let slips = slips.or_else(|| drawn(&case, &behavior, &model.schedule, (settings, index)));
                    Work::Connector(Box::new(case), behavior, slips.map(Box::new))
                }
                Item::Mpc(placed) => Work::Mpc(Box::new(mpc_case(model, placed, number))),
                Item::Relation(placed) => Work::Relation(Box::new(relation_case(model, placed, number))),
            };
            waiting.push(Piece { place, index, is_wide: is_wide(place, index), work });
            place += 1;
            if waiting.len() >= AT_ONCE {
                judge(settings, std::mem::take(&mut waiting), &mut gathered);
            }
            Ok(())
        });
        progress(target.name);
    }
    judge(settings, waiting, &mut gathered);
    if follows.request.outputs().any(|output| output == Output::CSF) {
        for (place, check) in restored(target, &follows, settings) {
            if let Some(one) = gathered.get_mut(place) {
                checks_of(&mut one.checks, vec![check]);
            }
        }
    }
    subjects(target, gathered)
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

/// Which region of configuration space the states exercise at which [`audit_scenes`] judges the connectors of a scene that gives none.
#[must_use]
pub fn drawn_coverage(settings: &Settings, target: &Target<'_>) -> Coverage {
    let samples = |at: &usize| -> Vec<Sample> {
        let Some(element) = target.model.connectors.get(*at) else { return Vec::new() };
        let definition = element.definition();
        let sample = |case: Case| {
            let state = &case.last()?.state;
            Some(Sample::of(&element.connector, &definition, state, target.model.length))
        };
        drawn_cases(settings, target, element).filter_map(|(_, case)| sample(case?)).collect()
    };
    let samples: Vec<Vec<Sample>> = target.plan.connectors.par_iter().map(samples).collect();
    let mut coverage = Coverage::default();
    samples.iter().flatten().for_each(|sample| coverage.take(sample));
    coverage
}

/// States about the initial one, where a scene gives none: connectors at drawn ones, constraints at the initial one.
fn draw_states(settings: &Settings, target: &Target<'_>, wide_states: usize, gathered: &mut [Gathered]) {
    let Target { model, plan, .. } = *target;
    let mut pieces = Vec::new();
    for (place, at) in plan.connectors.iter().enumerate() {
        let Some(element) = model.connectors.get(*at) else { continue };
        let wide = spread_of(settings.drawn_states, wide_states, place);
        for (index, case) in drawn_cases(settings, target, element) {
            let is_wide = wide.contains(&index);
            let work = case.map(|case| {
                let behavior = Arc::clone(&element.behavior);
                let slips = drawn(&case, &behavior, &model.schedule, (settings, index));
                Work::Connector(Box::new(case), behavior, slips.map(Box::new))
            });
            pieces.extend(work.map(|work| Piece { place, index, is_wide, work }));
        }
        if pieces.len() >= AT_ONCE {
            judge(settings, std::mem::take(&mut pieces), gathered);
        }
    }
    let alone = Plan { connectors: Vec::new(), request: Request::nothing(0), ..plan.clone() };
    let mut walk = Sequence::new(model, &alone);
    let mut place = plan.connectors.len();
    let Ok(()) = walk.visit(&State::default(), |placed| -> Result<(), Infallible> {
        let work = match placed {
            Item::Connector(_) => None,
            Item::Mpc(placed) => Some(Work::Mpc(Box::new(mpc_case(model, placed, 0)))),
            Item::Relation(placed) => Some(Work::Relation(Box::new(relation_case(model, placed, 0)))),
        };
        if let Some(work) = work {
            pieces.push(Piece { place, index: 0, is_wide: true, work });
            place += 1;
            if pieces.len() >= AT_ONCE {
                judge(settings, std::mem::take(&mut pieces), gathered);
            }
        }
        Ok(())
    });
    judge(settings, pieces, gathered);
}

/// What is asked of a walk: nothing, and where there is friction its forces and slopes, so that its history is followed.
fn followed(target: &Target<'_>) -> Request {
    let slides = |at: &usize| {
        target.model.connectors.get(*at).is_some_and(|element| element.behavior.behavior.slips_at_all())
    };
    if !target.plan.connectors.iter().any(slides) {
        return Request::nothing(0);
    }
    Request::new(&[Output::CSF, Output::TANGENT], [true; 6], 0)
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
        Some((element.title(), certificate(connection), slips, expected))
    });
    let mpcs = plan.mpcs.iter().filter_map(|at| {
        let element = model.mpcs.get(*at)?;
        let of_kind = certificate_of_mpc(element.constraint.kind());
        Some((element.title(), of_kind, true, Expected::of_constraint()))
    });
    let relations = plan.relations.iter().filter_map(|at| {
        let element = model.relations.get(*at)?;
        let of_kind = certificate_named(element.type_name);
        Some((element.title(), of_kind, true, Expected::of_relation(&element.relation)))
    });
    let named = connectors.chain(mpcs).chain(relations).zip(gathered);
    named
        .map(|((title, certificate, slips, expected), mut one)| {
            one.checks.sort_by_key(|check| (check.quantity.is_none(), check.quantity, check.against));
            let springs = one.checks.iter().any(|check| check.quantity == Some(Quantity::BehaviorTangent));
            let certified = slips && (!springs || certifies_springs());
            let subject = Subject::new(title, certificate, one.cases, one.checks, &expected);
            let least = if certified { Verdict::Pass } else { Verdict::Undecided };
            let formula = subject.formula.max(least);
            Subject { scene: Some(target.name.to_string()), formula, ..subject }
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
    let mut walk = walk(model, &plan);
    let mut found = Vec::new();
    for (index, state) in states.iter().enumerate() {
        found.clear();
        let number = state.number.unwrap_or(index as u64);
        let Ok(()) = walk.visit(state, |placed| -> Result<(), Infallible> {
            if let Item::Connector(placed) = placed {
                found.push((model.connectors[placed.index].title(), case(model, placed, number)));
            }
            Ok(())
        });
    }
    found
}

/// The constraints at the last state; at the initial one, where no states are given.
pub(super) fn last_constraints(target: &Target<'_>) -> Vec<MpcCase> {
    let Target { model, states, plan, .. } = *target;
    let mut walk = walk(model, plan);
    let mut found = Vec::new();
    let initial = [State::default()];
    let states = if states.is_empty() { &initial[..] } else { states };
    for (index, state) in states.iter().enumerate() {
        found.clear();
        let number = state.number.unwrap_or(index as u64);
        let Ok(()) = walk.visit(state, |placed| -> Result<(), Infallible> {
            if let Item::Mpc(placed) = placed {
                found.push(mpc_case(model, placed, number));
            }
            Ok(())
        });
    }
    found
}
