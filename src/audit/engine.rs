//! The audit: cases × quantities × oracles and laws, in parallel, gathered per connector.

use crate::case::quantity::{Numbers, Quantity};
use crate::case::stage::invalid_stage;
use crate::case::{AtEnd, Case};
use crate::friction::{self, friction_cases};
use crate::judge::components::{Exact, Surroundings};
use crate::judge::examined::{Examined, Trusted};
use crate::judge::judged::{Trials, moved_by};
use crate::judge::outcome::{Against, Check, Expected, Report, Subject};
use crate::judge::verdict::{Score, Verdict};
use crate::laws as invariant;
use crate::laws::{Context, Invariant};
use crate::mutants::mutant::{self, Mistake};
use crate::oracles::certificate::{certificate, certifies_predefined};
use crate::oracles::force::product_at;
use crate::oracles::golden::{audit_golden, states_of};
use crate::oracles::oracle::{Answer, Narrow, Oracle, WideAnswers};
use crate::oracles::referee::Referee;
use crate::oracles::sums::{hyper_dual, taylor};
use crate::oracles::truth::Truth;
use crate::sampling::{random_case, regions_drawn};
use crate::settings::Settings;
use crate::share::spread;
use crate::singular::atlas::{self, Approach};
use crate::singular::standing::cases_on;
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::draw::Draw;
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Audits every type of the catalogue. `progress` is told of each finished type.
pub fn audit_catalogue(settings: &Settings, progress: &(dyn Fn(&str) + Sync)) -> Report {
    let of_type = |connection: &ConnectionType| {
        let approaches = || if settings.atlas { atlas::atlas(connection) } else { Vec::new() };
        let found = rayon::join(|| audit_type(connection, settings), approaches);
        progress(&connection.name);
        found
    };
    let of_constraints = || if settings.atlas { crate::mpc::atlas::approaches() } else { Vec::new() };
    let (found, of_constraints): (Vec<(Subject, Vec<Approach>)>, Vec<Approach>) =
        rayon::join(|| TABLE.par_iter().map(of_type).collect(), of_constraints);
    let (subjects, mut atlas): (Vec<Subject>, Vec<Vec<Approach>>) = found.into_iter().unzip();
    atlas.push(of_constraints);
    Report::new(settings, subjects, atlas.concat())
}

/// Audits connectors of a scene, each with the cases that its states make.
pub fn audit_cases(
    settings: &Settings,
    connectors: &[(String, Vec<Case>)],
    progress: &(dyn Fn(&str) + Sync),
) -> Report {
    let subjects = connectors
        .par_iter()
        .filter_map(|(name, cases)| {
            let connection = &cases.first()?.definition.connection;
            let wide = spread(cases.len(), settings.wide_states);
            let checks = gather(
                cases
                    .par_iter()
                    .enumerate()
                    .map(|(i, case)| audit_case(case, settings, wide.contains(&i), i)),
            );
            progress(name);
            let expected = Expected::of(&cases.first()?.connector());
            Some(Subject::new(name.clone(), certificate(connection), cases.len() as u64, checks, &expected))
        })
        .collect();
    Report::new(settings, subjects, Vec::new())
}

/// Which states of a type are judged on 237 bits, besides the `standing` ones, which always are. First come the regular states, the
/// first of them one from a region, then those near its singular sets. Three quarters of those wanted that are left are regular,
/// but of two thirds of those wanted at least. They are more where there are as many regions that are not all alike. Those of right
/// angles are alike, and come after them. Every other state near the sets may stand on one, from the first on: those between do
/// not.
fn wide_states(
    (distinct, regions): (usize, usize),
    (regular, near, standing): (usize, usize, usize),
    wanted: usize,
) -> BTreeSet<usize> {
    let wanted = wanted.saturating_sub(standing).max((2 * wanted).div_ceil(3));
    let of_near = if near > 0 { (wanted / 4).min(wanted.saturating_sub(distinct)) } else { 0 };
    let of_regular = wanted - of_near;
    let others = spread(regular.saturating_sub(regions), of_regular.saturating_sub(regions));
    let mut wide = spread(distinct, of_regular);
    let alike = spread(regions - distinct, of_regular.saturating_sub(distinct));
    wide.extend(alike.into_iter().map(|i| distinct + i));
    wide.extend(others.into_iter().map(|i| regions + i));
    let between = near / 2;
    if of_near <= between {
        wide.extend(spread(between, of_near).into_iter().map(|i| regular + 2 * i + 1));
    } else {
        wide.extend(spread(near, of_near).into_iter().map(|i| regular + i));
    }
    wide
}

fn audit_type(connection: &ConnectionType, settings: &Settings) -> Subject {
    let draw = &mut Draw::new(&format!("{} {}", settings.seed, connection.name));
    let (distinct, regions) = regions_drawn(connection, draw);
    let near = if atlas::sites(connection).is_empty() { 0 } else { settings.near_singular_states };
    let regular = settings.states.max(regions.len());
    let on_points = if near > 0 { cases_on(connection) } else { Vec::new() };
    // On a removable point nothing is singular, and doubles alone judge what is not wide.
    let is_singular = |case: &&Case| Narrow::of(case).is_some_and(|narrow| narrow.nearness() == 0.0);
    let standing = on_points.iter().take(near.div_ceil(2)).filter(is_singular).count();
    let wide = wide_states((distinct, regions.len()), (regular, near, standing), settings.wide_states);
    let golden = if settings.oracles.contains(&Oracle::Jax) { states_of(connection) } else { 0 };
    let count = regular + near + golden;
    let mut checks = gather((0..count).into_par_iter().map(|i| {
        if let Some(place) = i.checked_sub(regular + near) {
            return audit_golden(connection, place, settings);
        }
        let name = format!("{} {} {i}", settings.seed, connection.name);
        let drawn_by = |draw: &mut Draw| {
            if i < regular { random_case(connection, draw) } else { atlas::random_near(connection, draw) }
        };
        // Half of the states near singular sets, and a quarter of the others, have the structure that models have.
        let share = if i < regular { 0.25 } else { 0.5 };
        let is_structured = Draw::new(&format!("{name} structure")).unit() < share;
        let structured = || {
            let mut draw = Draw::new(&name);
            draw.structured();
            drawn_by(&mut draw)
        };
        // Every other state near singular sets stands on one, while there are such.
        let among_near = i.checked_sub(regular).filter(|n| n.is_multiple_of(2));
        if let Some(case) = among_near.and_then(|n| on_points.get(n / 2)) {
            let checks = audit_case(case, settings, wide.contains(&i), i);
            return checks.into_iter().map(Check::declared).collect();
        }
        let drawn = regions.get(i).cloned().or_else(|| is_structured.then(structured).flatten());
        let drawn = drawn.or_else(|| drawn_by(&mut Draw::new(&name)));
        drawn.map_or_else(Vec::new, |case| audit_case(&case, settings, wide.contains(&i), i))
    }));
    let frictions = friction_cases(connection, settings, settings.wide_states);
    let found: Vec<Vec<Check>> = frictions
        .par_iter()
        .map(|case| {
            let mut checks = case.audit(settings);
            checks.push(case.restored(true));
            checks
        })
        .collect();
    found.into_iter().for_each(|found| checks_of(&mut checks, found));
    checks_of(&mut checks, friction::audit_golden(connection, settings));
    checks.extend(laws_of_type(connection));
    let expected = regions.first().map_or_else(Expected::default, |case| Expected::of(&case.connector()));
    let (name, certificate) = (connection.name.to_string(), certificate(connection));
    let subject = Subject::new(name, certificate, count as u64, checks, &expected);
    let least = if certifies_predefined(connection) { Verdict::Pass } else { Verdict::Undecided };
    Subject { formula: subject.formula.max(least), ..subject }
}

/// The laws of a type by itself, at states of their own.
pub(super) fn laws_of_type(connection: &ConnectionType) -> Vec<Check> {
    let of = |law: Invariant| {
        let demands = invariant::of_type(connection, law);
        (!demands.is_empty()).then(|| law_of_type(law, &demands, connection))
    };
    [Invariant::Start, Invariant::Turns, Invariant::FreeAxis].into_iter().filter_map(of).collect()
}

/// A law whose demands carry the numbers that they judge.
fn law_of_type(law: Invariant, demands: &[invariant::Demand], connection: &ConnectionType) -> Check {
    let mut check = Check::new(None, Against::Law(law));
    let none = Numbers::default();
    check.compared = demands.len() as u64;
    if let Some((demand, units)) = invariant::worst(&none, demands) {
        check.verdict = demand.verdict(&none);
        check.worst = Some(demand.finding(units, demand.offset));
        check.worst_state = Some(format!("{} by itself", connection.name));
    }
    check.states.insert(check.verdict, 1);
    let passed = demands.iter().filter(|demand| demand.units(&none) <= 1.0);
    let mut trials = Trials::default();
    for demand in passed {
        // Of an angle in radians, of a length in lengths, and of what is larger than one of them a part of it.
        for delta in mutant::LADDER {
            let off = invariant::Demand {
                offset: demand.offset + delta * demand.offset.abs().max(1.0),
                ..demand.clone()
            };
            trials.see(delta, off.units(&none) > 1.0, true);
        }
        for wrong in [
            demand.offset + std::f64::consts::PI,
            demand.offset - std::f64::consts::TAU,
            -demand.offset - 1e-6,
        ] {
            let mutated = invariant::Demand { offset: wrong, ..demand.clone() };
            let noticed = mutated.units(&none) > 1.0;
            // What is allowed where only continuity is asked is more than a rounding.
            let change = || moved_by((wrong - demand.offset).abs(), demand.allowed);
            let what = || demand.what.to_string();
            trials.add(Mistake::WrongParity, noticed, (|| true, || false), change, what);
        }
    }
    check.score = trials.score();
    check
}

/// The checks of many cases, in their order, whatever the number of threads; wrong numbers of a few are kept at a time.
fn gather(cases: impl IndexedParallelIterator<Item = Vec<Check>>) -> Vec<Check> {
    let merged = |mut found: Vec<Check>, checks: Vec<Check>| {
        checks_of(&mut found, checks);
        found
    };
    let mut found = cases.fold(Vec::new, merged).reduce(Vec::new, merged);
    found.sort_by_key(|check| (check.quantity.is_none(), check.quantity, check.against));
    found
}

/// Adds the checks of one case to those of others.
pub(super) fn checks_of(found: &mut Vec<Check>, checks: Vec<Check>) {
    for check in checks {
        let same =
            found.iter_mut().find(|known| (known.quantity, known.against) == (check.quantity, check.against));
        match same {
            Some(known) => known.merge(check),
            None => found.push(check),
        }
    }
}

/// How often, among the states on doubles only, mutants and laws are tried.
pub(super) const SOMETIMES: usize = 20;

/// All checks of one case.
pub fn audit_case(case: &Case, settings: &Settings, wide: bool, index: usize) -> Vec<Check> {
    let Some(end) = case.at_end() else { return Vec::new() };
    let mut numbers = product_at(&end);
    if let Some(planted) = settings.planted {
        planted.spoil(&mut numbers);
    }
    judge_numbers(&end, &numbers, settings, wide, index)
}

/// Judges the product's numbers at the end of a case.
fn judge_numbers(
    end: &AtEnd<'_>,
    numbers: &Numbers<f64>,
    settings: &Settings,
    wide: bool,
    index: usize,
) -> Vec<Check> {
    let mut checks = Vec::new();
    let (case, narrow) = (end.case, Narrow::at(end));
    let asked = |oracle: Oracle| settings.oracles.contains(&oracle);
    // On a singular set differences on doubles have no step: only the wide ones tell its two sides. What is not finite is invalid, or
    // beyond the range of doubles: only the wide numbers tell which.
    let asks = wide || narrow.nearness() == 0.0 || invalid_stage(&end.step.state, numbers).is_some();
    let truth = asks.then(|| Truth::at(end));
    let answers = truth.as_ref().map(WideAnswers::of);
    // Of a component on its singular set there are no differences to trust; any other is judged as everywhere.
    let of_components =
        truth.as_ref().map_or_else(|| narrow.nearness_of_components(), Truth::nearness_of_components);
    let trusted = answers.as_ref().map_or(Trusted::Own, |answers| {
        Trusted::Wide(answers.trusted(&of_components.map(|near| near > 0.0)))
    });
    let examined = Examined::new(end, numbers, trusted, &of_components);
    let (examined, sides) = examined.on_sets(truth.as_ref());
    let bound = &examined.bound;
    let exact = |quantity: Quantity| answers.as_ref().map(|answers| Exact::of(answers, quantity));
    // 196 second derivatives take about as long as all that is done on doubles besides.
    let often = wide || index.is_multiple_of(SOMETIMES);
    let nested = (often && asked(Oracle::NestedDual)).then(|| narrow.nested_dual());
    let traced = asked(Oracle::Symbolic).then(|| narrow.symbolic());
    let referee = Referee::new(end, settings, truth.as_ref());
    let around = match &truth {
        Some(truth) => {
            Surroundings { exact: Some(&exact), ..Surroundings::of(case, truth, bound, sides.as_ref()) }
        }
        None => Surroundings::new(bound, of_components),
    };
    for quantity in Quantity::ALL {
        for oracle in Oracle::ALL.into_iter().filter(|oracle| oracle.answers(quantity) && asked(*oracle)) {
            let answer = match oracle {
                Oracle::WideDifferences | Oracle::WideDual | Oracle::WideSymbolic => {
                    let (Some(answers), Some(truth)) = (&answers, &truth) else { continue };
                    let answer = answers.answer(oracle, quantity);
                    answer.map(|answer| match oracle {
                        Oracle::WideDifferences => answer.with_error_of(truth, quantity, bound),
                        _ => answer,
                    })
                }
                Oracle::NodalDual => Some(narrow.nodal_dual(bound)),
                Oracle::NestedDual | Oracle::Symbolic => {
                    let found = if oracle == Oracle::Symbolic { &traced } else { &nested };
                    let Some(numbers) = found.as_ref().map(|found| found.entries(quantity)) else { continue };
                    Some(match oracle {
                        Oracle::Symbolic => Answer::traced(quantity, numbers, bound, &of_components),
                        _ => Answer::rounded(oracle, quantity, numbers, bound),
                    })
                }
                _ => Some(narrow.differences(bound)),
            };
            let Some(mut answer) = answer.filter(|answer| !answer.numbers.is_empty()) else { continue };
            if let Some(planted) = settings.planted.filter(|_| oracle.is_wide()) {
                planted.blind(&mut answer);
            }
            let by = (Some(&referee), often);
            checks.push(if oracle.is_wide() {
                examined.check_wide(quantity, &answer, &around, by)
            } else {
                examined.check(quantity, &answer, &around, by)
            });
        }
    }
    let draw = &mut Draw::new(&case.name);
    let made = |quantity: Quantity| if often { examined.mutants(quantity) } else { &[] };
    if asked(Oracle::Taylor) {
        let made = made(Quantity::FirstDerivatives);
        let mut of_sum =
            truth.as_ref().and_then(|truth| taylor(&examined, truth, &of_components, draw, made));
        referee.hears(of_sum.as_mut_slice(), numbers, &around, &case.name);
        checks.extend(of_sum);
    }
    if asked(Oracle::HyperDual) {
        let mut of_sum = hyper_dual(&examined, &narrow, draw, made(Quantity::SecondDerivatives));
        referee.hears(of_sum.as_mut_slice(), numbers, &around, &case.name);
        checks.extend(of_sum);
    }
    if often {
        checks.extend(laws(end, &examined, wide));
    }
    Check::contradict(&mut checks);
    checks
}

/// What relates the numbers to each other; with mutants of them where `wide`.
fn laws(end: &AtEnd<'_>, examined: &Examined<'_>, wide: bool) -> Vec<Check> {
    let Examined { case, numbers, bound, .. } = examined;
    let context = Context::at(end.clone(), numbers, bound);
    let context = if wide { context } else { context.brief() };
    let score = |law: Invariant, asked: &invariant::Asked| {
        let mut score = Score::default();
        if wide {
            for quantity in asked.spans() {
                score.merge(examined.score_of_law(quantity, &asked.demands));
            }
        }
        if wide && law == Invariant::Restored {
            for (path, [changes, noticed]) in context.forgotten() {
                let change = || if changes { f64::INFINITY } else { 0.0 };
                score.count(Mistake::TurnForgotten, noticed, change, || path);
            }
        }
        score
    };
    let at = (case.name.as_str(), Some(*case));
    invariant::checks::checks(&Invariant::ALL, *numbers, at, |law| context.demands(law), score)
}

#[cfg(test)]
mod tests {
    use super::wide_states;

    #[test]
    fn as_many_states_are_wide_as_are_asked_for() {
        let of = |wanted: usize, standing: usize| {
            let found = wide_states((18, 42), (10_000, 10_000, standing), wanted);
            [0..42, 42..10_000, 10_000..20_000]
                .map(|range: std::ops::Range<usize>| found.range(range).count())
        };
        assert_eq!(of(30, 0), [23, 0, 7]);
        assert_eq!(of(1000, 0), [42, 708, 250]);
        assert_eq!(of(40_000, 0), [42, 9_958, 10_000]);
        assert_eq!(of(30, 6), [18, 0, 6]);
        assert_eq!(of(30, 20), [18, 0, 2]);
        assert_eq!(of(1, 20), [1, 0, 0]);
        assert_eq!(of(0, 20), [0, 0, 0]);
        // Every region that is not like others is among them.
        assert!((0..18).all(|i| wide_states((18, 42), (1000, 200, 20), 30).contains(&i)));
        // None of those near singular sets is where another one stands.
        assert!(wide_states((18, 42), (1000, 200, 20), 30).range(1000..).all(|i| i % 2 == 1));
        assert_eq!(wide_states((18, 42), (42, 0, 0), 1000).len(), 42);
    }
}
