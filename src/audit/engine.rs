//! The audit: cases × quantities × oracles and laws, in parallel, gathered per connector.

use super::atlas::{self, Approach, truth_to_f64};
use super::bound::{Bound, C};
use super::case::Case;
use super::certificate::{Certificate, certificate};
use super::counterexample::CounterExample;
use super::invariant::{self, Context, Invariant};
use super::mutant::{self, Mistake, Mutant, mutants};
use super::oracle::{Narrow, Oracle, WideAnswers, remainders};
use super::quantity::{Numbers, Quantity, product};
use super::sample::{Draw, Extent, cases, random_case};
use super::shrink::shrink;
use super::truth::Truth;
use super::verdict::{Finding, Judgement, Score, Surroundings, Verdict, judge, try_mutants};
use crate::catalog::{ConnectionType, Slot, TABLE};
use crate::measure::Unit;
use crate::node::DOFS;
use rayon::prelude::*;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What an audit is to do.
#[derive(Clone, Debug, Serialize)]
pub struct Settings {
    /// States per type for the oracles on doubles.
    pub states: usize,
    /// States per type near its singular sets, besides.
    pub near_singular_states: usize,
    /// States per type for the oracles on 237 bits, chosen to cover the regions.
    pub wide_states: usize,
    /// The oracles asked.
    pub oracles: BTreeSet<Oracle>,
    /// What the random states are drawn from.
    pub seed: String,
    /// Whether the singular points of the catalogue are approached.
    pub atlas: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            states: 800,
            near_singular_states: 200,
            wide_states: 30,
            oracles: Oracle::ALL.into(),
            seed: "pintle".into(),
            atlas: true,
        }
    }
}

/// What numbers were compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Against {
    /// An oracle's.
    Oracle(Oracle),
    /// Differences of the candidate's own values.
    Own,
    /// Each other, by a law.
    Law(Invariant),
}

impl Against {
    /// In words.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Oracle(oracle) => oracle.name(),
            Self::Own => "differences of its own values",
            Self::Law(law) => law.name(),
        }
    }
}

/// One check over all cases of a connector.
#[derive(Clone, Debug, Serialize)]
pub struct Check {
    /// The numbers judged; a law may span several.
    pub quantity: Option<Quantity>,
    /// What they were compared with.
    pub against: Against,
    /// The severest verdict.
    pub verdict: Verdict,
    /// States by verdict.
    pub states: BTreeMap<Verdict, u64>,
    /// Entries compared.
    pub compared: u64,
    /// The largest error in units of its tolerance, at any state.
    pub largest: f64,
    /// The entry that decided the verdict: nearest to, or farthest beyond, its tolerance.
    pub worst: Option<Finding>,
    /// The state at which it was found.
    pub worst_state: Option<String>,
    /// How mutants of the same numbers fared.
    pub score: Score,
    /// The case of the worst mismatch, for a counter-example.
    #[serde(skip)]
    pub failing: Option<Box<Case>>,
}

impl Check {
    pub(super) fn new(quantity: Option<Quantity>, against: Against) -> Self {
        Self {
            quantity,
            against,
            verdict: Verdict::Pass,
            states: BTreeMap::new(),
            compared: 0,
            largest: 0.0,
            worst: None,
            worst_state: None,
            score: Score::default(),
            failing: None,
        }
    }

    /// An entry that must be there and is not.
    pub(super) fn missing(&mut self, entry: String, case: &Case) {
        let worst = Finding {
            entry: format!("{entry} is missing"),
            at: (0, 0),
            got: f64::NAN,
            want: f64::NAN,
            tolerance: 0.0,
            units: f64::INFINITY,
            one_sided: None,
        };
        self.add(
            Judgement { verdict: Verdict::Wrong, worst: Some(worst), compared: 1 },
            Score::default(),
            case,
        );
    }

    pub(super) fn add(&mut self, judgement: Judgement, score: Score, case: &Case) {
        *self.states.entry(judgement.verdict).or_default() += 1;
        self.compared += judgement.compared as u64;
        let severer = judgement.verdict > self.verdict;
        let units = |finding: &Option<Finding>| finding.as_ref().map_or(-1.0, |f| f.units);
        self.largest = self.largest.max(units(&judgement.worst));
        if severer || (judgement.verdict == self.verdict && units(&judgement.worst) > units(&self.worst)) {
            self.worst = judgement.worst;
            self.worst_state = Some(case.name.clone());
            if judgement.verdict.is_mismatch() {
                self.failing = Some(Box::new(case.clone()));
            }
        }
        self.verdict = self.verdict.max(judgement.verdict);
        self.score.merge(score);
    }

    fn merge(&mut self, other: Self) {
        for (verdict, count) in other.states {
            *self.states.entry(verdict).or_default() += count;
        }
        self.compared += other.compared;
        let units = |finding: &Option<Finding>| finding.as_ref().map_or(-1.0, |f| f.units);
        self.largest = self.largest.max(other.largest);
        let severer = other.verdict > self.verdict;
        if severer || (other.verdict == self.verdict && units(&other.worst) > units(&self.worst)) {
            self.worst = other.worst;
            self.worst_state = other.worst_state;
            self.failing = other.failing.or(self.failing.take());
        }
        self.verdict = self.verdict.max(other.verdict);
        self.score.merge(other.score);
    }
}

/// Everything that was found about one connector or type.
#[derive(Clone, Debug, Serialize)]
pub struct Subject {
    /// The type, or the type with the element.
    pub name: String,
    /// States tried.
    pub cases: u64,
    /// Every check.
    pub checks: Vec<Check>,
    /// What was proven of its formulas and its declaration.
    pub certificate: Option<Certificate>,
    /// The verdict on its derivatives: the severest of the checks, undecided without an independent oracle.
    pub derivative: Verdict,
    /// The verdict on its formulas.
    pub formula: Verdict,
    /// The verdict on its declaration.
    pub declaration: Verdict,
}

impl Subject {
    pub(super) fn new(name: String, connection: &ConnectionType, cases: u64, mut checks: Vec<Check>) -> Self {
        for check in &mut checks {
            check.score.finish();
        }
        let certificate = certificate(connection);
        let judged: BTreeSet<Quantity> = checks.iter().filter_map(|check| check.quantity).collect();
        let witnessed = !judged.is_empty()
            && judged.iter().all(|quantity| {
                checks.iter().any(|check| {
                    check.quantity == Some(*quantity)
                        && check.compared > 0
                        && matches!(check.against, Against::Oracle(oracle) if oracle.is_independent())
                })
            });
        let of = |wanted: fn(Against) -> bool| {
            let chosen = checks.iter().filter(|check| wanted(check.against));
            chosen.map(|check| check.verdict).max().unwrap_or(Verdict::Pass)
        };
        let is_declared = |against| matches!(against, Against::Law(Invariant::Sparsity));
        let derivative = of(|against| !matches!(against, Against::Law(Invariant::Sparsity)));
        let declaration = of(is_declared);
        let proven = |is: bool| if is { Verdict::Pass } else { Verdict::Undecided };
        let has = |is: fn(&Certificate) -> bool| certificate.as_ref().is_some_and(is);
        Self {
            name,
            cases,
            derivative: if witnessed { derivative } else { derivative.max(Verdict::Undecided) },
            formula: proven(has(|c| c.jax_states > 0)),
            declaration: declaration.max(proven(has(Certificate::is_declaration_read))),
            checks,
            certificate,
        }
    }

    /// The severest of the three claims.
    pub fn verdict(&self) -> Verdict {
        self.derivative.max(self.formula).max(self.declaration)
    }
}

/// An audit.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The version of this program.
    pub version: &'static str,
    /// What was asked.
    pub settings: Settings,
    /// C of the bound.
    pub constant: f64,
    /// What was audited.
    pub subjects: Vec<Subject>,
    /// Singular points.
    pub atlas: Vec<Approach>,
}

impl Report {
    /// Subjects with a verified mismatch, and singular sets that are not what they are declared to be.
    pub fn mismatches(&self) -> usize {
        let wrong = self.subjects.iter().filter(|subject| subject.verdict().is_mismatch()).count();
        wrong + self.atlas.iter().filter(|approach| !approach.is_confirmed()).count()
    }

    /// Subjects of which something is undecided.
    pub fn undecided(&self) -> usize {
        self.subjects.iter().filter(|subject| subject.verdict() == Verdict::Undecided).count()
    }

    /// Mutants that survived a check by an oracle, and laws that noticed none of theirs.
    pub fn survivors(&self) -> u64 {
        let checks = self.subjects.iter().flat_map(|subject| &subject.checks);
        checks.map(|check| check.score.survived).sum()
    }

    /// A counter-example for every failed check of an oracle, by file name, shrunk to the simplest values that still fail.
    pub fn counter_examples(&self) -> Vec<(String, CounterExample)> {
        let mut found = Vec::new();
        for subject in &self.subjects {
            let failed = subject.checks.iter().filter(|check| check.verdict.is_mismatch());
            for (i, check) in failed.enumerate() {
                let Some(case) = &check.failing else { continue };
                let same = |case: &Case| {
                    let checks = audit_case(case, &self.settings, true, 0);
                    checks.into_iter().find(|other| {
                        (other.quantity, other.against) == (check.quantity, check.against)
                            && other.verdict == check.verdict
                    })
                };
                let small = shrink(case, &|case| same(case).is_some());
                let example = CounterExample::of(same(&small).as_ref().unwrap_or(check), &subject.name);
                let words: String = subject
                    .name
                    .chars()
                    .map(|c| if c.is_alphanumeric() { c.to_ascii_lowercase() } else { '-' })
                    .collect();
                found.extend(example.map(|example| (format!("{words}-{i}.json"), example)));
            }
        }
        found
    }

    /// Entries compared in all.
    pub fn compared(&self) -> u64 {
        self.subjects.iter().flat_map(|subject| &subject.checks).map(|check| check.compared).sum()
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
    let (subjects, atlas): (Vec<Subject>, Vec<Vec<Approach>>) = found.into_iter().unzip();
    report(settings, subjects, atlas.concat())
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
            Some(Subject::new(name.clone(), connection, cases.len() as u64, checks))
        })
        .collect();
    report(settings, subjects, Vec::new())
}

fn report(settings: &Settings, subjects: Vec<Subject>, atlas: Vec<Approach>) -> Report {
    Report { version: crate::VERSION, settings: settings.clone(), constant: C, subjects, atlas }
}

/// `wanted` places among `count`, evenly spread.
fn spread(count: usize, wanted: usize) -> BTreeSet<usize> {
    let wanted = wanted.min(count).max(usize::from(count > 0));
    (0..wanted).map(|i| i * count / wanted).collect()
}

fn audit_type(connection: &ConnectionType, settings: &Settings) -> Subject {
    let regions = cases(connection, Extent::Full);
    let has_singular_set = |slot: &Slot| slot.position().is_some_and(|m| m.singular_set().is_some());
    let near = if connection.slots.iter().any(has_singular_set) { settings.near_singular_states } else { 0 };
    // Most of the wide states cover the regions, the others lie near singular sets.
    let near_wide = if near > 0 { settings.wide_states / 4 } else { 0 };
    let regular = settings.states.max(regions.len());
    let mut wide = spread(regions.len(), settings.wide_states - near_wide);
    wide.extend(spread(near, near_wide).into_iter().map(|i| regular + i));
    let count = regular + near;
    let mut checks = gather((0..count).into_par_iter().map(|i| {
        let draw = &mut Draw::new(&format!("{} {} {i}", settings.seed, connection.name));
        let drawn = match regions.get(i) {
            Some(case) => Some(case.clone()),
            None if i < regular => random_case(connection, draw),
            None => atlas::random_near(connection, draw),
        };
        drawn.map_or_else(Vec::new, |case| audit_case(&case, settings, wide.contains(&i), i))
    }));
    for law in [Invariant::Start, Invariant::Turns] {
        let demands = invariant::of_type(connection, law);
        if !demands.is_empty() {
            checks.push(law_of_type(law, &demands, connection));
        }
    }
    Subject::new(connection.name.to_string(), connection, count as u64, checks)
}

/// A law whose demands carry the numbers that they judge.
fn law_of_type(law: Invariant, demands: &[invariant::Demand], connection: &ConnectionType) -> Check {
    let mut check = Check::new(None, Against::Law(law));
    let none = Numbers::default();
    check.compared = demands.len() as u64;
    if let Some((demand, units)) = invariant::worst(&none, demands) {
        check.verdict = if units > 1.0 { Verdict::Wrong } else { Verdict::Pass };
        check.worst = Some(finding(demand, units, demand.offset));
        check.worst_state = Some(format!("{} by itself", connection.name));
    }
    check.states.insert(check.verdict, 1);
    for demand in demands {
        for wrong in [
            demand.offset + std::f64::consts::PI,
            demand.offset - std::f64::consts::TAU,
            -demand.offset - 1e-6,
        ] {
            let mutated = invariant::Demand { offset: wrong, ..demand.clone() };
            if mutated.units(&none, &[]) > 1.0 {
                check.score.killed += 1;
            } else {
                check.score.survived += 1;
                check.score.survivors.insert(Mistake::WrongParity.name(), demand.what.clone());
            }
        }
    }
    check
}

fn finding(demand: &invariant::Demand, units: f64, got: f64) -> Finding {
    Finding {
        entry: demand.what.clone(),
        at: (0, 0),
        got,
        want: demand.want,
        tolerance: demand.allowed,
        units,
        one_sided: None,
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
const SOMETIMES: usize = 20;

/// All checks of one case.
pub fn audit_case(case: &Case, settings: &Settings, wide: bool, index: usize) -> Vec<Check> {
    let (Some(numbers), Some(narrow)) = (product(case), Narrow::of(case)) else { return Vec::new() };
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
    let truth = if wide { Truth::of(case) } else { None };
    let answers = truth.as_ref().map(WideAnswers::of);
    let nearness = truth.as_ref().map_or_else(|| narrow.nearness(), Truth::nearness);
    let trusted = match &answers {
        Some(answers) if nearness > 0.0 => truth_to_f64(&answers.differences),
        Some(answers) => truth_to_f64(&answers.dual),
        None => numbers.clone(),
    };
    let bound = Bound::new(&trusted, &step.state.velocity, &step.state.acceleration, case.length, nearness);
    let scale = |quantity: Quantity| {
        let bound = &bound;
        move |k: usize, i: usize| bound.scale(quantity, k, i)
    };
    let connector = case.connector();
    let units: [Option<Unit>; 6] = std::array::from_fn(|k| connector.differentiated(k).map(|m| m.unit()));
    let branch = connector.advance(&step.state, &step.increment, &case.branch_before(&connector));
    let turns: [f64; 6] = std::array::from_fn(|k| branch.turns[k].turns);
    let make = |quantity: Quantity| {
        let scale = scale(quantity);
        mutants(quantity, &mutant::Scene { numbers, case, units, turns, scale: &scale })
    };
    let sides = match &truth {
        Some(truth) if nearness == 0.0 => Some([truth.one_sided(-1), truth.one_sided(1)]),
        _ => None,
    };
    for quantity in Quantity::ALL {
        let mut made: Option<Vec<Mutant>> = None;
        let exact = answers.as_ref().map(|answers| answers.dual.entries(quantity));
        let around = Surroundings {
            bound: &bound,
            exact,
            nearness,
            one_sided: sides.as_ref().map(|[below, above]| [below, above]),
        };
        for oracle in Oracle::ALL.into_iter().filter(|oracle| oracle.answers(quantity) && asked(*oracle)) {
            let answer = match oracle {
                Oracle::WideDifferences | Oracle::WideDual | Oracle::WideSymbolic => {
                    let Some(answers) = &answers else { continue };
                    answers.answer(oracle, quantity)
                }
                Oracle::NodalDual => Some(narrow.nodal_dual(&bound)),
                Oracle::Symbolic => Some(narrow.symbolic(quantity, &bound)),
                _ => Some(narrow.differences(&bound)),
            };
            let Some(answer) = answer.filter(|answer| !answer.numbers.is_empty()) else { continue };
            let got = numbers.entries(quantity);
            let judgement = judge(quantity, got, &answer, &around);
            let proves = nearness > 0.0 && (wide || index.is_multiple_of(SOMETIMES));
            let score = if proves {
                let made = made.get_or_insert_with(|| make(quantity));
                try_mutants(quantity, got, &answer, &bound, &|i| quantity.entry_size(i, case.length), made)
            } else {
                Score::default()
            };
            let mut check = Check::new(Some(quantity), Against::Oracle(oracle));
            check.add(judgement, score, case);
            checks.push(check);
        }
    }
    let draw = &mut Draw::new(&case.name);
    if asked(Oracle::Taylor) && nearness > 0.0 {
        checks.extend(truth.as_ref().and_then(|truth| taylor(case, numbers, truth, &bound, draw)));
    }
    if asked(Oracle::HyperDual) && nearness > 0.0 {
        checks.extend(hyper_dual(case, numbers, narrow, &bound, draw));
    }
    if nearness > 0.0 && (wide || index.is_multiple_of(SOMETIMES)) {
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

fn taylor(
    case: &Case,
    numbers: &Numbers<f64>,
    truth: &Truth,
    bound: &Bound,
    draw: &mut Draw,
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
    for remainder in remainders(truth, rows, bound, &v) {
        compared += 1;
        let units = if remainder.error == 0.0 { 0.0 } else { remainder.error / remainder.allowed };
        if worst.as_ref().is_none_or(|w| units > w.units || units.is_nan()) {
            let order = remainder.order.map_or("linear to rounding".into(), |p| format!("order {p:.2}"));
            worst = Some(Finding {
                entry: format!("∂{}·v, {order}", crate::catalog::COMPONENT[remainder.component]),
                at: (remainder.component, 0),
                got: remainder.error,
                want: 0.0,
                tolerance: remainder.allowed,
                units: if units.is_nan() { f64::INFINITY } else { units },
                one_sided: None,
            });
        }
    }
    let wrong = worst.as_ref().is_some_and(|w| w.units > 1.0);
    let verdict = if wrong { Verdict::Wrong } else { Verdict::Pass };
    let mut check = Check::new(Some(quantity), Against::Oracle(Oracle::Taylor));
    check.add(Judgement { verdict, worst, compared }, Score::default(), case);
    (compared > 0).then_some(check)
}

fn hyper_dual(
    case: &Case,
    numbers: &Numbers<f64>,
    narrow: &Narrow,
    bound: &Bound,
    draw: &mut Draw,
) -> Option<Check> {
    let quantity = Quantity::SecondDerivatives;
    let v = direction(draw, case.length, narrow.active());
    let w = direction(draw, case.length, narrow.active());
    let mut worst: Option<Finding> = None;
    let mut compared = 0;
    for (k, want) in narrow.hyper_dual(&v, &w).into_iter().enumerate() {
        let (Some(want), Some(matrix)) = (want, &numbers.entries(quantity).0[k]) else { continue };
        compared += 1;
        let mut got = 0.0;
        let mut allowed = 0.0;
        for (i, entry) in matrix.iter().enumerate() {
            let product = v[i / DOFS] * w[i % DOFS];
            got += entry * product;
            // Once for the product's entries, once for the oracle's.
            allowed += 2.0 * bound.tolerance(quantity, k, i) * product.abs();
        }
        let error = (got - want).abs();
        let units = if error == 0.0 { 0.0 } else { error / allowed };
        let units = if units.is_nan() { f64::INFINITY } else { units };
        if worst.as_ref().is_none_or(|found| units > found.units) {
            worst = Some(Finding {
                entry: format!("vᵀ ∂²{} w", crate::catalog::COMPONENT[k]),
                at: (k, 0),
                got,
                want,
                tolerance: allowed,
                units,
                one_sided: None,
            });
        }
    }
    let wrong = worst.as_ref().is_some_and(|found| found.units > 1.0);
    let verdict = if wrong { Verdict::Wrong } else { Verdict::Pass };
    let mut check = Check::new(Some(quantity), Against::Oracle(Oracle::HyperDual));
    check.add(Judgement { verdict, worst, compared }, Score::default(), case);
    (compared > 0).then_some(check)
}

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
        let demands = context.demands(law);
        let Some((demand, units)) = invariant::worst(numbers, &demands) else { continue };
        let verdict = if units > 1.0 { Verdict::Wrong } else { Verdict::Pass };
        let got = demand.terms.iter().fold(demand.offset, |sum, (q, k, i, c)| {
            sum + c * numbers.entries(*q).get(*k, *i).unwrap_or(f64::NAN)
        });
        let judgement =
            Judgement { verdict, worst: Some(finding(demand, units, got)), compared: demands.len() };
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
                    make(quantity).into_iter().filter(|mutant| coarse(mutant.mistake)).step_by(7).collect()
                });
                score.merge(invariant::try_mutants(quantity, numbers, &demands, made));
            }
        }
        let mut check = Check::new(None, Against::Law(law));
        check.add(judgement, score, case);
        checks.push(check);
    }
    checks
}
