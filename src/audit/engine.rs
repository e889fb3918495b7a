//! The audit: cases × quantities × oracles and laws, in parallel, gathered per connector.

use super::atlas::{self, Approach};
use super::bound::Bound;
use super::case::Case;
use super::certificate::{certificate, certifies_predefined};
use super::conditioned::Conditioned;
use super::diagnosis::Symptoms;
use super::force::product_with_forces as product;
use super::friction::{self, friction_cases};
use super::golden::{audit_golden, states_of};
use super::invariant::{self, Context, Invariant};
use super::mutant::{self, Mistake, Mutant, mutants};
use super::oracle::{Answer, Narrow, Oracle, WideAnswers, remainders};
use super::outcome::{Against, Check, Expected, Report, Subject};
use super::planted::Planted;
use super::quantity::{Numbers, Quantity};
use super::referee::Referee;
use super::sample::{Draw, Extent, cases, random_case};
use super::stage::invalid_stage;
use super::standing::cases_on;
use super::truth::{Locked, Truth};
use super::verdict::{
    Along, Exact, Finding, Judgement, Score, Surroundings, Verdict, Wanted, decided, judge, try_along,
    try_mutants,
};
use crate::behavior::Conditions;
use crate::catalog::{ConnectionType, TABLE};
use crate::measure::Unit;
use crate::node::DOFS;

use rayon::prelude::*;
use serde::Serialize;
use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet};

/// What an audit is to do.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Settings {
    /// States per type for the oracles on doubles.
    pub states: usize,
    /// States per type near its singular sets, besides.
    pub near_singular_states: usize,
    /// States per type for the oracles on 237 bits, chosen to cover the regions; without any the claim on derivatives is undecided.
    pub wide_states: usize,
    /// States on 237 bits of a scene in all: at least one of each connector, at most `wide_states`; none where that is 0.
    pub wide_states_of_a_scene: usize,
    /// States drawn about the initial one of a connector whose scene gives no states.
    pub drawn_states: usize,
    /// The oracles asked.
    pub oracles: BTreeSet<Oracle>,
    /// What the random states are drawn from.
    pub seed: String,
    /// The temperature and the field variables of scenes: forces that depend on others are undecided.
    pub conditions: Conditions,
    /// Whether the singular points of the catalogue are approached.
    pub atlas: bool,
    /// Whether what is undecided fails.
    pub strict: bool,
    /// A fault planted on purpose, which the audit must tell of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planted: Option<Planted>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            states: 800,
            near_singular_states: 200,
            wide_states: 30,
            wide_states_of_a_scene: 3000,
            drawn_states: 20,
            oracles: Oracle::ALL.into(),
            seed: "pintle".into(),
            conditions: Conditions::default(),
            atlas: true,
            strict: false,
            planted: None,
        }
    }
}

/// Audits every type of the catalogue. `progress` is told of each finished type.
pub fn audit_catalogue(settings: &Settings, progress: &(dyn Fn(&str) + Sync)) -> Report {
    let found: Vec<(Subject, Vec<Approach>)> = TABLE
        .par_iter()
        .map(|connection| {
            let subject = audit_type(connection, settings);
            let approaches = if settings.atlas { atlas::atlas(connection) } else { Vec::new() };
            progress(&connection.name);
            (subject, approaches)
        })
        .collect();
    let (subjects, mut atlas): (Vec<Subject>, Vec<Vec<Approach>>) = found.into_iter().unzip();
    if settings.atlas {
        atlas.push(super::mpc::atlas::approaches());
    }
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

/// `wanted` places among `count`: the first, the last, and others evenly between them; of one alone the last, for at the first nothing
/// has moved yet.
pub(super) fn spread(count: usize, wanted: usize) -> BTreeSet<usize> {
    spread_of(count, wanted, 0)
}

/// The same for one of many that share a history, by its number: where each has one place only, together they cover the history.
/// The first of them takes the last place, the second the first, others halve the gaps.
pub(super) fn spread_of(count: usize, wanted: usize, number: usize) -> BTreeSet<usize> {
    let Some(last) = count.checked_sub(1) else { return BTreeSet::new() };
    match wanted.min(count) {
        0 => BTreeSet::new(),
        1 => {
            let place = match number {
                0 => last,
                1 => 0,
                _ => halved(number - 1, last),
            };
            BTreeSet::from([place])
        }
        wanted => (0..wanted).map(|i| i * last / (wanted - 1)).collect(),
    }
}

/// The n-th (from 1) of the places that halve 0 … `last` again and again: 1/2, 1/4, 3/4, 1/8 … of it, van der Corput's sequence.
fn halved(n: usize, last: usize) -> usize {
    let reversed = n.reverse_bits() as u128;
    let place = (reversed * (last as u128)) >> usize::BITS;
    usize::try_from(place).unwrap_or(last)
}

fn audit_type(connection: &ConnectionType, settings: &Settings) -> Subject {
    let regions = cases(connection, Extent::Full);
    let near = if atlas::sites(connection).is_empty() { 0 } else { settings.near_singular_states };
    // Most of the wide states cover the regions, the others lie near singular sets.
    let near_wide = if near > 0 { settings.wide_states / 4 } else { 0 };
    let regular = settings.states.max(regions.len());
    let on_points = if near > 0 { cases_on(connection) } else { Vec::new() };
    let mut wide = spread(regions.len(), settings.wide_states - near_wide);
    wide.extend(spread(near, near_wide).into_iter().map(|i| regular + i));
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
    let found: Vec<Vec<Check>> = frictions.par_iter().map(|case| case.audit(settings)).collect();
    found.into_iter().for_each(|found| checks_of(&mut checks, found));
    checks_of(&mut checks, friction::audit_golden(connection, settings));
    for law in [Invariant::Start, Invariant::Turns, Invariant::FreeAxis] {
        let demands = invariant::of_type(connection, law);
        if !demands.is_empty() {
            checks.push(law_of_type(law, &demands, connection));
        }
    }
    let expected = regions.first().map_or_else(Expected::default, |case| Expected::of(&case.connector()));
    let (name, certificate) = (connection.name.to_string(), certificate(connection));
    let subject = Subject::new(name, certificate, count as u64, checks, &expected);
    let least = if certifies_predefined(connection) { Verdict::Pass } else { Verdict::Undecided };
    Subject { formula: subject.formula.max(least), ..subject }
}

/// A law whose demands carry the numbers that they judge.
fn law_of_type(law: Invariant, demands: &[invariant::Demand], connection: &ConnectionType) -> Check {
    let mut check = Check::new(None, Against::Law(law));
    let none = Numbers::default();
    check.compared = demands.len() as u64;
    if let Some((demand, units)) = invariant::worst(&none, demands) {
        check.verdict = demand.verdict(&none);
        check.worst = Some(finding(demand, units, demand.offset));
        check.worst_state = Some(format!("{} by itself", connection.name));
    }
    check.states.insert(check.verdict, 1);
    let passed = demands.iter().filter(|demand| demand.units(&none) <= 1.0);
    for demand in passed {
        for wrong in [
            demand.offset + std::f64::consts::PI,
            demand.offset - std::f64::consts::TAU,
            -demand.offset - 1e-6,
        ] {
            let mutated = invariant::Demand { offset: wrong, ..demand.clone() };
            let noticed = mutated.units(&none) > 1.0;
            check.score.count(Mistake::WrongParity, noticed, || f64::INFINITY, || demand.what.to_string());
        }
    }
    check
}

fn finding(demand: &invariant::Demand, units: f64, got: f64) -> Finding {
    Finding {
        entry: demand.what.to_string(),
        at: None,
        demanded: demand.what.demanded(),
        got,
        want: demand.want,
        tolerance: demand.allowed,
        units,
        one_sided: None,
        lack: None,
    }
}

/// The checks of many cases, whatever the number of threads.
fn gather(cases: impl IndexedParallelIterator<Item = Vec<Check>>) -> Vec<Check> {
    let all: Vec<Vec<Check>> = cases.collect();
    let mut found = Vec::new();
    for checks in all {
        checks_of(&mut found, checks);
    }
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

/// What the source gives on 237 bits where triads are rotations to the last of these, and what differences say there; computed where a
/// number is wrong by little.
pub(super) struct AtRotations<'a> {
    case: &'a Case,
    answers: OnceCell<Option<WideAnswers>>,
}

impl<'a> AtRotations<'a> {
    pub(super) const fn new(case: &'a Case) -> Self {
        Self { case, answers: OnceCell::new() }
    }

    pub(super) fn exact(&self, quantity: Quantity) -> Option<Exact<'_>> {
        let of_case = || Truth::of(self.case).as_ref().map(WideAnswers::of);
        let answers = self.answers.get_or_init(of_case).as_ref()?;
        let (product, truth) = (answers.dual.entries(quantity), answers.differences.entries(quantity));
        Some(Exact { product, truth })
    }
}

/// All checks of one case.
pub fn audit_case(case: &Case, settings: &Settings, wide: bool, index: usize) -> Vec<Check> {
    let (Some(mut numbers), Some(narrow)) = (product(case), Narrow::of(case)) else { return Vec::new() };
    if let Some(planted) = settings.planted {
        planted.spoil(&mut numbers);
    }
    judge_numbers(case, &numbers, &narrow, settings, wide, index)
}

/// Judges numbers, the product's or another's, at the end of a case.
fn judge_numbers(
    case: &Case,
    numbers: &Numbers<f64>,
    narrow: &Narrow,
    settings: &Settings,
    wide: bool,
    index: usize,
) -> Vec<Check> {
    let mut checks = Vec::new();
    let Some(step) = case.last() else { return checks };
    let asked = |oracle: Oracle| settings.oracles.contains(&oracle);
    // On a singular set differences on doubles have no step: only the wide ones tell its two sides.
    let truth = (wide || narrow.nearness() == 0.0).then(|| Truth::of(case)).flatten();
    let answers = truth.as_ref().map(WideAnswers::of);
    let nearness = truth.as_ref().map_or_else(|| narrow.nearness(), Truth::nearness);
    // Of a component on its singular set there are no differences to trust; any other is judged as everywhere.
    let of_components =
        truth.as_ref().map_or_else(|| narrow.nearness_of_components(), Truth::nearness_of_components);
    let locked = truth.as_ref().map_or_else(Locked::default, Truth::locked);
    let is_smooth = of_components.map(|near| near > 0.0);
    let trusted = answers.as_ref().map_or_else(|| numbers.clone(), |answers| answers.trusted(&is_smooth));
    let (velocity, acceleration) = (&step.state.velocity, &step.state.acceleration);
    let bound = Bound::of_components(&trusted, velocity, acceleration, case.length, &of_components);
    let scale = |quantity: Quantity| {
        let bound = &bound;
        move |k: usize, i: usize| bound.scale(quantity, k, i)
    };
    let connector = case.connector();
    let units: [Option<Unit>; 6] = std::array::from_fn(|k| connector.differentiated(k).map(|m| m.unit()));
    let conditioned = Conditioned::new(numbers, case, &units, &of_components);
    let branch = connector.advance(&step.state, &step.increment, &case.branch_before(&connector));
    let turns: [f64; 6] = std::array::from_fn(|k| branch.turns[k].turns);
    let make = |quantity: Quantity| {
        let scale = scale(quantity);
        let mut made = mutants(quantity, &mutant::Scene { numbers, case, units, turns, scale: &scale });
        made.retain(|mutant| mutant.changes.iter().all(|(k, ..)| is_smooth[*k]));
        made
    };
    let sides = truth.as_ref().filter(|_| nearness == 0.0).map(|truth| truth.sides(&bound));
    let rotations = AtRotations::new(case);
    let exact = |quantity: Quantity| rotations.exact(quantity);
    // 196 second derivatives take about as long as all that is done on doubles besides.
    let often = wide || index.is_multiple_of(SOMETIMES);
    let nested = (often && asked(Oracle::NestedDual)).then(|| narrow.nested_dual());
    let traced = asked(Oracle::Symbolic).then(|| narrow.symbolic());
    let counts_from_rounding = narrow.undetermined_origins().iter().any(Option::is_some);
    let referee = Referee::new(case, settings, truth.as_ref());
    let around = Surroundings {
        bound: &bound,
        exact: Some(&exact).filter(|_| answers.is_some()).map(|exact| exact as _),
        nearness: of_components,
        sides: sides.as_ref(),
        locked,
    };
    for quantity in Quantity::ALL {
        let mut made: Option<Vec<Mutant>> = None;
        for oracle in Oracle::ALL.into_iter().filter(|oracle| oracle.answers(quantity) && asked(*oracle)) {
            let answer = match oracle {
                Oracle::WideDifferences | Oracle::WideDual | Oracle::WideSymbolic => {
                    let (Some(answers), Some(truth)) = (&answers, &truth) else { continue };
                    let answer = answers.answer(oracle, quantity);
                    answer.map(|answer| match oracle {
                        Oracle::WideDifferences => {
                            Answer { error: truth.own_error(quantity, &bound), ..answer }
                        }
                        _ => answer,
                    })
                }
                Oracle::NodalDual => Some(narrow.nodal_dual(&bound)),
                Oracle::NestedDual | Oracle::Symbolic => {
                    let found = if oracle == Oracle::Symbolic { &traced } else { &nested };
                    let Some(numbers) = found.as_ref().map(|found| found.entries(quantity)) else { continue };
                    Some(match oracle {
                        Oracle::Symbolic => Answer::traced(quantity, numbers, &bound, &of_components),
                        _ => Answer::rounded(oracle, quantity, numbers, &bound),
                    })
                }
                _ => Some(narrow.differences(&bound)),
            };
            let Some(mut answer) = answer.filter(|answer| !answer.numbers.is_empty()) else { continue };
            if let Some(planted) = settings.planted.filter(|_| oracle.is_wide()) {
                planted.blind(&mut answer);
            }
            let got = numbers.entries(quantity);
            let mut judgement = judge(quantity, got, &answer, &around);
            if quantity == Quantity::Value && counts_from_rounding && judgement.verdict == Verdict::Pass {
                judgement.verdict = Verdict::IllConditioned;
            }
            // A check that speaks has proved that it can; mutants are made of right numbers.
            let is_wrong = judgement.verdict.is_mismatch();
            if let Some(why) = referee.excuse_of(oracle, &judgement, (quantity, got), &around) {
                let mut check = Check::new(Some(quantity), Against::Oracle(oracle));
                check.add_excused(why, judgement.worst, judgement.compared as u64, &case.name);
                checks.push(check);
                continue;
            }
            let proves = often && !is_wrong;
            let score = if proves {
                let made = made.get_or_insert_with(|| make(quantity));
                let size = |i: usize| quantity.entry_size(i, case.length);
                try_mutants(quantity, got, &answer, &bound, (&size, &conditioned), made)
            } else {
                Score::default()
            };
            let mut check = Check::new(Some(quantity), Against::Oracle(oracle));
            check.add(judgement, score, case);
            check.name_stage(|| invalid_stage(&step.state, numbers));
            if is_wrong {
                // Without 237 bits, what is right is what the oracle says.
                let told = answers.is_none().then(|| {
                    let mut told = trusted.clone();
                    told.set(quantity, got.map(|k, i, x| answer.numbers.get(k, i).map_or(x, Wanted::to_f64)));
                    told
                });
                let want = told.as_ref().unwrap_or(&trusted);
                check.explain(&Symptoms { quantity, got, want, case, bound: &bound }, &answer.numbers);
            }
            checks.push(check);
        }
    }
    let draw = &mut Draw::new(&case.name);
    let made = |quantity: Quantity| if often { make(quantity) } else { Vec::new() };
    if asked(Oracle::Taylor) {
        let of = |truth| taylor(case, numbers, truth, (&bound, &of_components), draw, &made);
        checks.extend(truth.as_ref().and_then(of));
    }
    if asked(Oracle::HyperDual) {
        let mut of_sum = hyper_dual(case, numbers, narrow, (&bound, &is_smooth), draw, &made);
        referee.hears(of_sum.as_mut_slice(), numbers, &around, &case.name);
        checks.extend(of_sum);
    }
    if often {
        checks.extend(laws(case, numbers, &bound, wide, &make));
    }
    checks
}

/// A random direction of the nodes: 1 rad, one length.
fn direction(draw: &mut Draw, length: f64, active: &[bool; DOFS]) -> [f64; DOFS] {
    let mut v = draw.rates(length);
    for (x, active) in v.iter_mut().zip(active) {
        if !active {
            *x = 0.0;
        }
    }
    v
}

/// Whether a sum, so many tolerances off, tells more than the worst known: one without a tolerance tells less than a wrong one, and
/// more than a right one.
fn is_worse((units, allowed): (f64, f64), worst: Option<&Finding>) -> bool {
    let order = |units: f64, allowed: f64| (decided(0.0, allowed, units), units);
    worst.is_none_or(|worst| order(units, allowed) > order(worst.units, worst.tolerance))
}

/// The verdict on the sum that is worst.
fn of_sum(worst: Option<&Finding>) -> Verdict {
    match worst {
        Some(worst) => decided(worst.want, worst.tolerance, worst.units),
        None => Verdict::Pass,
    }
}

fn taylor(
    case: &Case,
    numbers: &Numbers<f64>,
    truth: &Truth,
    (bound, nearness): (&Bound, &[f64; 6]),
    draw: &mut Draw,
    make: &dyn Fn(Quantity) -> Vec<Mutant>,
) -> Option<Check> {
    let quantity = Quantity::FirstDerivatives;
    let mut active = [false; DOFS];
    for j in truth.active() {
        active[j] = true;
    }
    let v = direction(draw, case.length, &active);
    let rows = numbers.entries(quantity);
    let mut worst: Option<Finding> = None;
    let mut compared = 0;
    let mut off = [None; 6];
    for remainder in remainders(truth, rows, bound, &v, nearness) {
        compared += 1;
        off[remainder.component] = Some((remainder.off, remainder.allowed));
        let (units, [largest, allowed]) = (remainder.units(), remainder.largest);
        if is_worse((units, allowed), worst.as_ref()) {
            worst = Some(Finding {
                entry: format!("∂{}·v, {}", crate::catalog::COMPONENT[remainder.component], remainder.told()),
                at: None,
                demanded: None,
                got: largest,
                want: 0.0,
                tolerance: allowed,
                units,
                one_sided: None,
                lack: None,
            });
        }
    }
    let verdict = of_sum(worst.as_ref());
    let mut check = Check::new(Some(quantity), Against::Oracle(Oracle::Taylor));
    let score = match verdict {
        Verdict::Pass => try_along(quantity, rows, &Along { weight: &|j| v[j], off }, &make(quantity)),
        _ => Score::default(),
    };
    check.add(Judgement { verdict, worst, compared }, score, case);
    (compared > 0).then_some(check)
}

fn hyper_dual(
    case: &Case,
    numbers: &Numbers<f64>,
    narrow: &Narrow,
    (bound, is_smooth): (&Bound, &[bool; 6]),
    draw: &mut Draw,
    make: &dyn Fn(Quantity) -> Vec<Mutant>,
) -> Option<Check> {
    let quantity = Quantity::SecondDerivatives;
    let v = direction(draw, case.length, narrow.active());
    let w = direction(draw, case.length, narrow.active());
    let mut worst: Option<Finding> = None;
    let mut compared = 0;
    let rows = numbers.entries(quantity);
    let weight = |i: usize| v[i / DOFS] * w[i % DOFS];
    let mut off = [None; 6];
    for (k, want) in narrow.hyper_dual(&v, &w).into_iter().enumerate().filter(|(k, _)| is_smooth[*k]) {
        let (Some(want), Some(matrix)) = (want, &rows.0[k]) else { continue };
        compared += 1;
        let mut got = 0.0;
        let mut allowed = 0.0;
        for (i, entry) in matrix.iter().enumerate() {
            let product = weight(i);
            got += entry * product;
            // Once for the product's entries, once for the oracle's.
            allowed += 2.0 * bound.tolerance(quantity, k, i) * product.abs();
        }
        off[k] = Some((want - got, allowed));
        let error = (got - want).abs();
        let units = if error == 0.0 { 0.0 } else { error / allowed };
        let units = if units.is_nan() { f64::INFINITY } else { units };
        if is_worse((units, allowed), worst.as_ref()) {
            worst = Some(Finding {
                entry: format!("vᵀ ∂²{} w", crate::catalog::COMPONENT[k]),
                at: None,
                demanded: None,
                got,
                want,
                tolerance: allowed,
                units,
                one_sided: None,
                lack: None,
            });
        }
    }
    let verdict = of_sum(worst.as_ref());
    let mut check = Check::new(Some(quantity), Against::Oracle(Oracle::HyperDual));
    let score = match verdict {
        Verdict::Pass => try_along(quantity, rows, &Along { weight: &weight, off }, &make(quantity)),
        _ => Score::default(),
    };
    check.add(Judgement { verdict, worst, compared }, score, case);
    (compared > 0).then_some(check)
}

/// Why a law is undecided.
const OVERFLOW: &str = "numbers overflow, so that the law has no finite tolerance, or no finite sum";

fn laws(
    case: &Case,
    numbers: &Numbers<f64>,
    bound: &Bound,
    wide: bool,
    make: &dyn Fn(Quantity) -> Vec<Mutant>,
) -> Vec<Check> {
    let mut checks = Vec::new();
    let Some(context) = Context::new(case, numbers, bound) else { return checks };
    let mut made: BTreeMap<Quantity, Vec<Mutant>> = BTreeMap::new();
    for law in Invariant::ALL {
        let all = context.demands(law);
        if all.is_empty() {
            continue;
        }
        let verdict = all.iter().map(|one| one.verdict(numbers)).max().unwrap_or(Verdict::Pass);
        let demands: Vec<_> = all.into_iter().filter(|one| one.is_decidable(numbers)).collect();
        let worst = invariant::worst(numbers, &demands);
        let worst = worst.map(|(demand, units)| {
            let got = demand.sum(|quantity, k, i| numbers.entries(quantity).get(k, i));
            finding(demand, units, got)
        });
        let judgement = Judgement { verdict, worst, compared: demands.len() };
        let mut score = Score::default();
        if wide {
            let spans: BTreeSet<Quantity> =
                demands.iter().flat_map(|demand| demand.terms.iter().map(|term| term.0)).collect();
            for quantity in spans {
                let made = made.entry(quantity).or_insert_with(|| {
                    let coarse = |mistake: Mistake| match mistake {
                        Mistake::Scaled(delta) => delta == 1e-6,
                        _ => true,
                    };
                    make(quantity).into_iter().filter(|mutant| coarse(mutant.mistake)).collect()
                });
                score.merge(invariant::try_mutants(quantity, numbers, &demands, made));
            }
        }
        let mut check = Check::new(None, Against::Law(law));
        check.add(judgement, score, case);
        if verdict == Verdict::Undecided {
            check.undecided.insert(OVERFLOW.to_string(), 1);
        }
        checks.push(check);
    }
    checks
}

#[cfg(test)]
mod tests {
    use super::{spread, spread_of};
    use std::collections::BTreeSet;

    #[test]
    fn wide_states_are_spread_over_the_history() {
        assert_eq!(spread(11, 3), BTreeSet::from([0, 5, 10]));
        assert_eq!(spread(10, 4), BTreeSet::from([0, 3, 6, 9]));
        assert_eq!(spread(2, 30), BTreeSet::from([0, 1]));
        assert_eq!(spread(9, 1), BTreeSet::from([8]));
        assert_eq!(spread(1, 1), BTreeSet::from([0]));
        assert_eq!((spread(0, 3), spread(7, 0)), (BTreeSet::new(), BTreeSet::new()));
        // Every count is met, with both ends.
        for count in 2..40 {
            for wanted in 2..=count {
                let found = spread(count, wanted);
                assert_eq!(found.len(), wanted, "{count} {wanted}");
                assert!(found.contains(&0) && found.contains(&(count - 1)));
            }
        }
        // One place each: the last, the first, and what halves the gaps.
        let places: Vec<usize> = (0..6).filter_map(|n| spread_of(1000, 1, n).into_iter().next()).collect();
        assert_eq!(places, [999, 0, 499, 249, 749, 124]);
        let all: BTreeSet<usize> = (0..4000).flat_map(|n| spread_of(1000, 1, n)).collect();
        assert_eq!(all.len(), 1000);
    }
}
