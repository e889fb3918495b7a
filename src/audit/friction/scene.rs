//! The frictions of a scene's connector at a state: as its history left them, under the forces that the state gives.
//!
//! Where what presses is not given, it is drawn, and the increment starts from rest: derivatives are functions of forces, whatever these
//! are. The name of the state says so.

use crate::case::Case;
use crate::case::failing::{BeltCase, FrictionCase};
use crate::case::quantity::Quantity;
use crate::friction::checks;
use crate::friction::increment::output;
use crate::friction::total::Total;
use crate::judge::outcome::{Against, Check};
use crate::judge::table::{Entry, ResultTable};
use crate::judge::verdict::Score;
use crate::laws::Invariant;
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::{Output, Request};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::scalar::Wide;
use pintle_model::behavior::drive::Schedule;
use pintle_model::behavior::friction::{FLOW, State, StickStiffness};
use pintle_model::behavior::state::{Event, History, Kinematics, Outcome, Velocities};
use pintle_model::behavior::{Beyond, Conditions, Tangent, Unknown, Wrap};
use pintle_model::evaluate::{ConnectorResult, ElementBehavior};

/// What a connector's friction does at a state.
pub(crate) struct Slipping {
    /// The state, in words.
    name: String,
    outcome: Box<Outcome>,
    tangent: Option<Box<Tangent<f64>>>,
    conditions: Conditions,
    /// What the state before left, where states are followed.
    previous: Option<Box<History>>,
    /// The connector's own length.
    length: f64,
}

/// Whether a friction is not known because forces are not given, now or before.
const fn lacks_forces(why: Unknown) -> bool {
    matches!(why, Unknown::ContactForce | Unknown::FrictionHistory | Unknown::Part)
}

/// What a walk found at a state; nothing of a connector without friction, and of one of which a force that presses is not given.
pub(crate) fn slipping(
    placed: &ConnectorResult,
    behavior: &ElementBehavior,
    case: &Case,
    (previous, conditions): (History, &Conditions),
) -> Option<Slipping> {
    let outcome = placed.behavior.as_ref().filter(|_| behavior.behavior.slips_at_all())?;
    let is_lost = outcome.slips.iter().any(|slip| slip.outcome.as_ref().is_err_and(|why| lacks_forces(*why)));
    (!is_lost).then(|| Slipping {
        name: case.name.clone(),
        outcome: outcome.clone(),
        tangent: placed.tangent.clone(),
        conditions: conditions.clone(),
        previous: Some(Box::new(previous)),
        length: case.length,
    })
}

impl Slipping {
    /// The friction of that number, with what it does, as a case; none of a belt.
    fn case(&self, i: usize, element: &ElementBehavior) -> Option<FrictionCase> {
        let Self { name, outcome, conditions, length, .. } = self;
        let frictions = &element.behavior.friction.frictions;
        let (slip, friction) = (outcome.slips.get(i)?, frictions.get(i)?);
        let (before, done) = (slip.before.as_ref()?, slip.outcome.as_ref().ok()?);
        let mut point = slip.forces;
        (0..6).filter(|k| slip.components[*k]).for_each(|k| point[k] = done.force[k]);
        let several = frictions.len() > 1;
        Some(FrictionCase {
            name: name.clone(),
            title: if several { format!("({})", friction.criterion.output) } else { String::new() },
            friction: friction.clone(),
            coefficient: done.coefficient,
            point,
            before: *before,
            displacement: slip.displacement,
            forces: slip.forces,
            position: outcome.motion.position,
            motion: outcome.motion.constitutive,
            accumulated_slip: done.accumulated_slip,
            duration: outcome.duration,
            conditions: conditions.clone(),
            length: *length,
        })
    }

    /// What a friction remembers and how far it goes, against what the state before left.
    fn carried(&self, proves: bool) -> Option<Check> {
        let previous = self.previous.as_ref()?;
        let mut entries = Vec::new();
        let mut add = |name: String, got: f64, want: Wide, scale: f64| {
            entries.push(Entry::new(name, got, want, scale, (0, 0, 0)));
        };
        for (i, slip) in self.outcome.slips.iter().enumerate() {
            let left = match &previous.friction {
                None => Some(State::default()),
                Some(states) => states.get(i).copied().flatten(),
            };
            let (Some(before), Some(left)) = (&slip.before, left) else { continue };
            let number =
                if self.outcome.slips.len() > 1 { format!(" of friction {}", i + 1) } else { String::new() };
            for k in (0..6).filter(|k| slip.components[*k] && !previous.failed[*k]) {
                let (got, want) = (before.force[k], left.force[k]);
                add(format!("{} carried{number}", output(k)), got, Wide::from_f64(want), want.abs());
                let now = self.outcome.history.displacement[k].unwrap_or(0.0);
                let then = previous.displacement[k].unwrap_or(0.0);
                let by = Wide::from_f64(now) - Wide::from_f64(then);
                let name = format!("Δ{}{number}", COMPONENT[k]);
                add(name, slip.displacement[k], by, now.abs() + then.abs());
            }
            let (got, want) = (before.accumulated_slip, left.accumulated_slip);
            add(format!("CASU carried{number}"), got, Wide::from_f64(want), want.abs());
            if let Some(want) = left.stick_stiffness {
                let got = before.stick_stiffness.unwrap_or(0.0);
                add(format!("stick stiffness carried{number}"), got, Wide::from_f64(want), want.abs());
            }
        }
        let mut table = ResultTable::new(Quantity::FrictionForce);
        table.rows = entries.iter().map(|entry| entry.name.clone()).collect();
        table.entries = entries;
        let score = if proves { table.try_mistakes(&table.all_mistakes()) } else { Score::default() };
        let mut check = Check::new(None, Against::Law(Invariant::Carried));
        check.add_at(table.judge(), score, &self.name, None::<&Case>);
        (!table.entries.is_empty()).then_some(check)
    }
}

/// The friction of a connector at the end of a case under forces that are drawn, after an increment from rest; nothing of a connector
/// without friction.
pub(crate) fn drawn(
    case: &Case,
    element: &ElementBehavior,
    schedule: &Schedule,
    (settings, index): (&Settings, usize),
) -> Option<Slipping> {
    let behavior = &element.behavior;
    if !behavior.slips_at_all() {
        return None;
    }
    let outputs = [Output::CP, Output::CU, Output::CCU, Output::CV, Output::CA];
    let (evaluation, _) = case.evaluation(&Request::new(&outputs, [true; 6], 0))?;
    let draw = &mut Draw::new(&format!("{} {} friction", settings.seed, case.name));
    // The increment is a part of the way: some stick, some slip.
    let part = [1.0, 1e-3, 1e-5][index % 3];
    let unit = |k: usize| if k < 3 { case.length } else { 1.0 };
    let mut before = evaluation.displacement;
    for (k, place) in before.iter_mut().enumerate() {
        if let Some(now) = place {
            let way = if *now == 0.0 { draw.between(-0.1, 0.1) * unit(k) } else { *now };
            *now -= part * way;
        }
    }
    let history = History { displacement: before, ..History::default() };
    // Forces of the size that the stick stiffness makes of the increment, so that both happen.
    let frictions = behavior.friction.frictions.iter().map(|friction| friction.stick_stiffness);
    let stiffness = frictions.chain(behavior.friction.belt.as_ref().map(|belt| belt.stick_stiffness));
    let stiffest = stiffness.fold(0.0_f64, |most, stiffness| match stiffness {
        StickStiffness::Given(stiffness) => most.max(stiffness),
        StickStiffness::ElasticSlip(_) => most,
    });
    let size = match stiffest * part * case.length {
        0.0 => 3.0,
        size => size * [0.3, 3.0, 30.0][index / 3 % 3],
    };
    let mut force = |k: usize| {
        let x = draw.between(0.1, 1.0) * size * unit(k);
        if draw.unit() < 0.5 { -x } else { x }
    };
    let total = [0, 1, 2, 3, 4, 5].map(|k| Some(force(k)));
    let beyond = behavior.friction.belt.as_ref().map(|_| Beyond {
        tension: Ok(draw.between(0.1, 1.0) * size),
        angle: draw.between(0.3, 3.0),
        wrap: Wrap::Given,
    });
    let time = Some(draw.between(0.01, 1.0));
    let now = Kinematics { beyond, ..Kinematics::of(&evaluation, time, Velocities::Rates) };
    let conditions = &settings.conditions;
    let outcome = behavior.at(&now, &total, (&element.drives, schedule), conditions, &history);
    let tangent = behavior.consistent_tangent(&outcome, conditions, &history);
    Some(Slipping {
        name: format!("{}, drawn forces", case.name),
        outcome: Box::new(outcome),
        tangent: Some(Box::new(tangent)),
        conditions: conditions.clone(),
        previous: None,
        length: case.length,
    })
}

/// All checks of a connector's frictions at a state: those on 237 bits if `wide`, with mutants if it `proves`. Undecided where a friction
/// is not known.
pub(crate) fn audit_slipping(
    slipping: &Slipping,
    element: &ElementBehavior,
    settings: &Settings,
    (wide, proves): (bool, bool),
) -> Vec<Check> {
    let Slipping { name, outcome, tangent, conditions, length, .. } = slipping;
    let behavior = &element.behavior;
    let mut found = Vec::new();
    found.extend(slipping.carried(proves));
    for (i, slip) in outcome.slips.iter().enumerate() {
        let before = match (&slip.before, &slip.outcome) {
            (Some(before), Ok(_)) => before,
            (_, outcome) => {
                found.extend(undecided(settings, name, outcome.as_ref().err().copied()));
                continue;
            }
        };
        if let Some(case) = slipping.case(i, element) {
            found.extend(case.judged(settings, wide, proves));
        } else if let (Some(belt), Some(Beyond { tension: Ok(tension), angle, .. })) =
            (&behavior.friction.belt, slip.beyond)
        {
            let case = BeltCase {
                name: name.clone(),
                belt: belt.clone(),
                before: *before,
                flow: slip.displacement[FLOW],
                tension: [slip.forces[0], tension],
                angle,
                duration: outcome.duration,
                conditions: conditions.clone(),
                length: *length,
            };
            found.extend(case.judged(settings, wide, proves));
        }
    }
    // At the state of a failure forces vanish that pressed before it.
    let fails = outcome.events.iter().any(|event| matches!(event, Event::Failed { .. }));
    if let Some(tangent) = tangent.as_ref().filter(|_| !fails) {
        let total = Total { behavior, outcome, tangent, conditions, length: *length };
        found.extend(checks(total.tables(settings, wide), settings, name, proves));
    }
    found
}

/// A friction that nobody can judge, because it is not known.
fn undecided(settings: &Settings, name: &str, why: Option<Unknown>) -> Option<Check> {
    let oracle = settings.oracles.contains(&Oracle::WideDifferences).then_some(Oracle::WideDifferences)?;
    let mut check = Check::new(Some(Quantity::FrictionForce), Against::Oracle(oracle));
    check.add_undecided(&format!("the friction is not known: {}", why?.in_words()), name);
    Some(check)
}
