//! What an audit found: checks, subjects, the report.

use crate::case::Case;
use crate::case::failing::{Failing, MpcCase, RelationCase};
use crate::case::quantity::Quantity;
use crate::judge::bound::C;
use crate::judge::comparison::Comparison;
use crate::judge::verdict::{Finding, Judgement, Score, Verdict};
use crate::laws::demanded::Invariant;
use crate::model::ModelReport;
use crate::mutants::diagnosis::{Cause, Diagnosis, Places, Sample, Seen, Symptoms, diagnose_all};
use crate::oracles::certificate::Certificate;
use crate::oracles::oracle::{Answer, Oracle};
use crate::settings::Settings;
use crate::share::Share;
use crate::singular::atlas::Approach;
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::Connector;
use pintle_kinematics::relation::{Form, Relation};
use pintle_scene::Severity;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// What numbers were compared with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// Of how many states a check was given numbers of a component, and at how many of these what they must be decided the verdict.
#[derive(Clone, Copy, Debug, Default)]
struct Components {
    given: [u64; 6],
    decided: [u64; 6],
}

/// One check over all cases of a connector.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Check {
    /// The numbers judged; a law may span several.
    pub quantity: Option<Quantity>,
    /// What they were compared with.
    pub against: Against,
    /// The severest verdict.
    pub verdict: Verdict,
    /// States by verdict.
    pub states: BTreeMap<Verdict, u64>,
    /// Why states are undecided, with how many of them.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub undecided: BTreeMap<String, u64>,
    /// Where it is invalid, the first stage that is not finite: `state`, `relative pair`, or the kind of numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stage: Option<&'static str>,
    /// Entries compared.
    pub compared: u64,
    /// The largest error in units of its tolerance, at any state.
    #[cfg_attr(feature = "schema", schemars(with = "Option<f64>"))]
    pub largest: f64,
    /// The entry that decided the verdict: nearest to, or farthest beyond, its tolerance.
    pub worst: Option<Finding>,
    /// The state at which it was found.
    pub worst_state: Option<String>,
    /// How mutants of the same numbers fared.
    pub score: Score,
    /// Why it is wrong: what holds at nearly all states at which it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Box<Diagnosis>>,
    /// The simplest state found at which a routine is wrong, in words, where that was asked for.
    #[serde(skip)]
    pub simplest: Option<String>,
    /// The file to which its counter-example was written: `pintle replay` runs it again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counter_example: Option<String>,
    /// The matrix of first derivatives at the worst state, where it is wrong.
    #[serde(skip)]
    pub comparison: Option<Box<Comparison>>,
    /// What fails worst, for a counter-example.
    #[serde(skip)]
    pub failing: Option<Box<Failing>>,
    /// At how many states another independent oracle passes all that this one calls wrong, and at how many of these that is by far more than
    /// its own error.
    #[serde(skip)]
    pub contradicted: [u64; 2],
    #[serde(skip)]
    components: Components,
    /// What is wrong, at some of the states at which it is.
    #[serde(skip)]
    samples: Vec<Sample>,
    /// What it has seen of all states.
    #[serde(skip)]
    seen: Seen,
}

/// Why numbers that were compared, or a law, are undecided.
pub const OVERFLOW: &str = "numbers overflow, so that there is no finite tolerance, or no finite sum: judge states at which they do \
     not, or choose other units";

impl Check {
    pub(crate) fn new(quantity: Option<Quantity>, against: Against) -> Self {
        Self {
            quantity,
            against,
            verdict: Verdict::Pass,
            states: BTreeMap::new(),
            undecided: BTreeMap::new(),
            stage: None,
            compared: 0,
            largest: 0.0,
            worst: None,
            worst_state: None,
            score: Score::default(),
            diagnosis: None,
            simplest: None,
            counter_example: None,
            comparison: None,
            failing: None,
            contradicted: [0; 2],
            components: Components::default(),
            samples: Vec::new(),
            seen: Seen::default(),
        }
    }

    /// Says of which components there were numbers at the one state of this check, and of which it was known what they must be.
    pub fn compares(&mut self, given: impl Fn(usize) -> bool, wanted: impl Fn(usize) -> bool) {
        let is_decided = !matches!(self.verdict, Verdict::Undecided | Verdict::Singular);
        for k in (0..6).filter(|k| given(*k)) {
            self.components.given[k] += 1;
            self.components.decided[k] += u64::from(is_decided && wanted(k));
        }
    }

    /// Whether it is by an independent oracle on 237 bits that answers entry by entry.
    fn is_witness(&self) -> bool {
        let of = |oracle: Oracle| {
            oracle.is_independent() && oracle.is_wide() && self.quantity.is_some_and(|of| oracle.answers(of))
        };
        matches!(self.against, Against::Oracle(oracle) if of(oracle))
    }

    /// Marks, among the checks of one state, the word of one independent oracle against another's: of as many numbers one passes all, and another
    /// calls one wrong.
    pub fn contradict(of_state: &mut [Self]) {
        /// More than an oracle's own error, in tolerances.
        const FAR: f64 = 1e3;
        let decides = |check: &&Self| !check.verdict.is_mismatch() && check.verdict != Verdict::Undecided;
        let right: Vec<_> = of_state
            .iter()
            .filter(|check| check.is_witness())
            .filter(decides)
            .map(|check| (check.quantity, check.compared))
            .collect();
        for check in of_state.iter_mut().filter(|check| check.is_witness() && check.verdict.is_mismatch()) {
            let is_far = check.worst.as_ref().is_some_and(|worst| worst.units > FAR);
            let is_denied = right.contains(&(check.quantity, check.compared));
            check.contradicted = [is_denied, is_denied && is_far].map(u64::from);
        }
    }

    /// Whether at each state at which something is wrong that is one oracle's word against another's, at one of them by far.
    fn is_contradicted(&self) -> bool {
        let wrong = self.states.iter().filter(|(verdict, _)| verdict.is_mismatch()).map(|(_, states)| states);
        let [denied, far] = self.contradicted;
        far > 0 && denied == wrong.sum::<u64>()
    }

    /// An entry that must be there and is not, or the other way round, in words, at the one state of this check.
    pub fn misplaced(&mut self, entry: String, got: f64, case: &Case) {
        let worst = Finding::new(entry, [got, f64::NAN], 0.0, f64::INFINITY);
        self.add(
            Judgement { verdict: Verdict::Wrong, worst: Some(worst), compared: 1 },
            Score::default(),
            case,
        );
        // It is the same state, whatever was said of it.
        self.states = BTreeMap::from([(self.verdict, 1)]);
        self.undecided.clear();
    }

    /// Keeps what was judged, where it failed.
    pub fn fails_at(&mut self, failing: impl FnOnce() -> Failing) {
        if self.verdict.is_mismatch() {
            self.failing = Some(Box::new(failing()));
        }
    }

    /// Adds a state of which nobody can say what a number must be, and why.
    pub fn add_undecided(&mut self, why: &str, state: &str) {
        let judgement = Judgement { verdict: Verdict::Undecided, worst: None, compared: 0 };
        self.add_at(judgement, Score::default(), state, None);
        *self.undecided.entry(why.to_string()).or_default() += 1;
    }

    /// Adds what was found at the end of a case.
    pub fn add(&mut self, judgement: Judgement, score: Score, case: &Case) {
        self.add_decided(judgement, score, &case.name, Some(case));
    }

    /// Adds what was found at a state, and why it is undecided where it is.
    pub fn add_decided(&mut self, judgement: Judgement, score: Score, state: &str, case: Option<&Case>) {
        if judgement.verdict == Verdict::Undecided {
            *self.undecided.entry(OVERFLOW.to_string()).or_default() += 1;
        }
        self.add_at(judgement, score, state, case);
    }

    /// Says from which stage on numbers are not finite, where they are not.
    pub fn name_stage(&mut self, stage: impl FnOnce() -> Option<&'static str>) {
        if self.verdict == Verdict::Invalid {
            self.stage = stage();
        }
    }

    /// Keeps numbers that are wrong, to say why when every state was seen, and to be shown.
    pub(super) fn explain(&mut self, symptoms: &Symptoms<'_>, answer: &Answer) {
        self.samples = vec![Sample::new(symptoms)];
        if self.verdict == Verdict::Invalid {
            return;
        }
        if symptoms.quantity == Quantity::FirstDerivatives {
            let allowed = |k: usize, j: usize| answer.allowed(symptoms.bound, symptoms.quantity, k, j);
            self.comparison = Some(Box::new(Comparison::new(symptoms.got, &answer.numbers, allowed)));
        }
    }

    /// Keeps how far a state is from special ones, whether something is wrong there, which values are right: component, value, tolerance; and which
    /// components are right as a whole, and not zero.
    pub(super) fn has_seen(
        &mut self,
        places: &Places,
        right: impl Iterator<Item = (usize, f64, f64)>,
        is_whole: impl Fn(usize) -> bool,
    ) {
        self.seen.add(places, self.verdict.is_mismatch());
        right.for_each(|(k, want, tolerance)| self.seen.add_right(k, want, tolerance));
        (0..6).filter(|k| is_whole(*k)).for_each(|k| self.seen.add_whole(k));
    }

    /// Settles the figures over all states, and says why numbers are wrong.
    pub fn finish(&mut self) {
        self.score.finish();
        let samples = std::mem::take(&mut self.samples);
        let symptoms: Vec<Symptoms<'_>> = samples.iter().map(Sample::symptoms).collect();
        // A formula that loses digits need not be mistaken.
        let is_told = |found: &Diagnosis| self.verdict != Verdict::UnstableFormula || found.is_whole();
        if let Some(found) = diagnose_all(&symptoms, &self.seen).filter(is_told) {
            let loses_digits =
                found.is_whole() && found.causes.iter().all(|one| one.cause == Cause::DigitsLost);
            self.diagnosis = Some(Box::new(found));
            if loses_digits && self.verdict == Verdict::Wrong {
                // The nearer to a special state the more, and nowhere by much: another thing than a mistake.
                let states = self.states.remove(&Verdict::Wrong).unwrap_or_default();
                *self.states.entry(Verdict::UnstableFormula).or_default() += states;
                self.verdict = Verdict::UnstableFormula;
            }
        }
    }

    /// Adds what was found at a state. Of numbers that are wrong the mutants do not count: the check has spoken already, and
    /// one that undoes the mistake is right.
    pub fn add_at(&mut self, judgement: Judgement, score: Score, state: &str, case: Option<&Case>) {
        if !judgement.verdict.is_mismatch() {
            self.score.merge(score);
        }
        *self.states.entry(judgement.verdict).or_default() += 1;
        self.compared += judgement.compared as u64;
        let severer = judgement.verdict > self.verdict;
        let units = |finding: &Option<Finding>| finding.as_ref().map_or(-1.0, |f| f.units);
        // At a singular point what nobody can judge has no error.
        if judgement.verdict != Verdict::Singular {
            self.largest = self.largest.max(units(&judgement.worst));
        }
        if severer || (judgement.verdict == self.verdict && units(&judgement.worst) > units(&self.worst)) {
            self.worst = judgement.worst;
            self.worst_state = Some(state.to_string());
            if judgement.verdict.is_mismatch() {
                self.failing = case.map(|case| Box::new(Failing::Connector(Box::new(case.clone()))));
            }
        }
        self.verdict = self.verdict.max(judgement.verdict);
    }

    /// The check of a state that stands on a singular point on purpose: that it is one is declared, and no finding.
    pub fn declared(self) -> Self {
        if !matches!(self.verdict, Verdict::Kink | Verdict::Singular) {
            return self;
        }
        let states = BTreeMap::from([(Verdict::Pass, self.states.values().sum())]);
        Self { verdict: Verdict::Pass, states, worst: None, worst_state: None, ..self }
    }

    /// Whether it is by an independent oracle.
    const fn is_independent(&self) -> bool {
        matches!(self.against, Against::Oracle(oracle) if oracle.is_independent())
    }

    /// At how many states it judged.
    pub fn judged(&self) -> u64 {
        self.states.values().sum()
    }

    /// At how many states an independent oracle decided, one way or the other.
    fn judged_independently(&self) -> u64 {
        let is_decided = |verdict: &Verdict| !matches!(verdict, Verdict::Undecided | Verdict::Singular);
        let decided = self.states.iter().filter(|(verdict, _)| is_decided(verdict));
        if self.is_independent() && self.compared > 0 { decided.map(|(_, states)| states).sum() } else { 0 }
    }

    pub(crate) fn merge(&mut self, other: Self) {
        for (verdict, count) in other.states {
            *self.states.entry(verdict).or_default() += count;
        }
        for (why, count) in other.undecided {
            *self.undecided.entry(why).or_default() += count;
        }
        self.stage = self.stage.or(other.stage);
        self.compared += other.compared;
        let units = |finding: &Option<Finding>| finding.as_ref().map_or(-1.0, |f| f.units);
        self.largest = self.largest.max(other.largest);
        let severer = other.verdict > self.verdict;
        if severer || (other.verdict == self.verdict && units(&other.worst) > units(&self.worst)) {
            self.worst = other.worst;
            self.worst_state = other.worst_state;
            self.failing = other.failing;
            self.comparison = other.comparison;
        }
        self.verdict = self.verdict.max(other.verdict);
        let Components { given, decided } = &mut self.components;
        for (states, more) in [
            (&mut self.contradicted[..], &other.contradicted[..]),
            (given, &other.components.given),
            (decided, &other.components.decided),
        ] {
            states.iter_mut().zip(more).for_each(|(states, more)| *states += more);
        }
        self.score.merge(other.score);
        Sample::merge(&mut self.samples, other.samples);
        self.seen.merge(other.seen);
        if let Some(diagnosis) = other.diagnosis
            && self.diagnosis.as_ref().is_none_or(|known| diagnosis.is_clearer_than(known))
        {
            self.diagnosis = Some(diagnosis);
        }
    }
}

/// What there is to judge, whoever is asked to judge it.
#[derive(Clone, Debug, Default)]
pub struct Expected {
    quantities: Vec<Quantity>,
    laws: Vec<Invariant>,
}

impl Expected {
    /// Numbers without laws.
    pub fn numbers(quantities: &[Quantity]) -> Self {
        Self { quantities: quantities.to_vec(), laws: Vec::new() }
    }

    /// Of a multi-point constraint.
    pub fn of_constraint() -> Self {
        Self { quantities: MpcCase::QUANTITIES.to_vec(), laws: MpcCase::LAWS.to_vec() }
    }

    /// Of a relation: an equation is not asked what holds of rigid motions.
    pub fn of_relation(relation: &Relation<f64>) -> Self {
        let is_equation = matches!(relation.form(), Form::Linear(_));
        let laws = RelationCase::LAWS.into_iter().filter(|law| !is_equation || *law == Invariant::Power);
        Self { quantities: RelationCase::QUANTITIES.to_vec(), laws: laws.collect() }
    }

    /// Adds numbers.
    pub fn add(&mut self, quantity: Quantity) {
        self.quantities.push(quantity);
    }

    /// Of a connector: its numbers, those of forces where it has any; and the laws of a state that say something of it.
    pub fn of(connector: &Connector<f64>) -> Self {
        let has_forces = (0..6).any(|k| connector.has_force(k));
        let is_of_forces =
            |quantity: Quantity| matches!(quantity, Quantity::NodalForces | Quantity::GeometricStiffness);
        let quantities = Quantity::ALL.into_iter().filter(|quantity| has_forces || !is_of_forces(*quantity));
        let laws = Invariant::ALL.into_iter().filter(|law| law.is_expected_of(connector));
        Self { quantities: quantities.collect(), laws: laws.collect() }
    }
}

/// Everything that was found about one connector or type.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Subject {
    /// The type, or the type with the element.
    pub name: String,
    /// The type alone.
    #[serde(skip)]
    pub type_name: String,
    /// The scene that it belongs to.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scene: Option<String>,
    /// States tried.
    pub cases: u64,
    /// States at which an independent oracle, on 237 bits or JAX, judged the numbers: of the kind of numbers that has the fewest.
    pub judged_independently: u64,
    /// Every check.
    pub checks: Vec<Check>,
    /// What was proven of its formulas and its declaration.
    pub certificate: Option<Certificate>,
    /// Numbers that no independent oracle judged, for which the claim on derivatives is undecided.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without_witness: Vec<Quantity>,
    /// Components whose numbers of a kind no independent oracle judged, though one judged others of that kind: the claim is undecided for them too.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub components_without_witness: BTreeMap<Quantity, Vec<&'static str>>,
    /// Numbers of which no state tells whether a mistake would have been noticed: nobody who was asked compares them, or all are zero
    /// whatever the formula, as rates are where nothing moves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub not_exercised: Vec<Quantity>,
    /// Laws that speak of such a connector, and were not asked: for want of a degree of freedom, or of a state where they hold.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub laws_not_asked: Vec<Invariant>,
    /// The verdict on its derivatives: the severest of the checks, undecided where a number that it has was not compared with that of
    /// an independent oracle.
    pub derivative: Verdict,
    /// The verdict on its formulas: that of JAX at its own states, where it was asked, else that of its certificate.
    pub formula: Verdict,
    /// The verdict on its declaration.
    pub declaration: Verdict,
}

impl Subject {
    /// The quantities on which independent oracles contradict each other at a state, by far more than their own errors.
    pub fn contradicted(&self) -> Vec<Quantity> {
        let is_contradicted = |quantity: &Quantity| {
            self.checks.iter().any(|check| check.quantity == Some(*quantity) && check.contradicted[1] > 0)
        };
        Quantity::ALL.into_iter().filter(is_contradicted).collect()
    }

    /// The numbers that no independent oracle judged, in words: kinds of them, and kinds of components.
    pub fn lacking_a_witness(&self) -> Vec<String> {
        let kinds = self.without_witness.iter().map(|quantity| quantity.name().to_string());
        let parts = self.components_without_witness.iter();
        kinds
            .chain(parts.map(|(of, components)| format!("{} of {}", of.name(), components.join(" and "))))
            .collect()
    }

    /// Whether something is wrong by more than the word of one independent oracle against another's.
    fn is_wrong(&self) -> bool {
        let is_agreed = self.contradicted().is_empty();
        let wrong = |check: &Check| check.verdict.is_mismatch() && !check.is_contradicted();
        self.verdict().is_mismatch() && (is_agreed || self.checks.iter().any(wrong))
    }

    pub(crate) fn new(
        name: String,
        certificate: Option<Certificate>,
        cases: u64,
        mut checks: Vec<Check>,
        expected: &Expected,
    ) -> Self {
        // All checks of a quantity know what the one with most states has seen.
        for quantity in Quantity::ALL {
            let of_it = |check: &&mut Check| check.quantity == Some(quantity);
            let most = checks
                .iter()
                .filter(|check| check.quantity == Some(quantity))
                .max_by_key(|check| check.seen.states());
            let Some(seen) = most.map(|check| check.seen.clone()) else { continue };
            checks.iter_mut().filter(of_it).for_each(|check| check.seen = seen.clone());
        }
        for check in &mut checks {
            check.finish();
        }
        let judged = checks.iter().filter_map(|check| check.quantity);
        let judged: BTreeSet<Quantity> = judged.chain(expected.quantities.iter().copied()).collect();
        // Of wrong numbers the mutants do not count: the check has spoken.
        let is_exercised = |quantity: &Quantity| {
            let mut of_it = checks.iter().filter(|check| check.quantity == Some(*quantity));
            of_it.any(|check| check.score.decisive() > 0 || check.verdict.is_mismatch())
        };
        let not_exercised = expected.quantities.iter().copied().filter(|quantity| !is_exercised(quantity));
        let not_exercised: Vec<Quantity> = not_exercised.collect();
        let is_asked = |law: &Invariant| {
            checks.iter().any(|check| check.against == Against::Law(*law) && check.compared > 0)
        };
        let laws_not_asked = expected.laws.iter().copied().filter(|law| !is_asked(law)).collect();
        let is_jax = |check: &Check| check.against == Against::Oracle(Oracle::Jax);
        // JAX has states of its own; the others share theirs.
        let witnessed = |quantity: Quantity, by_jax: bool| {
            let of_it = checks.iter().filter(|check| check.quantity == Some(quantity));
            of_it.filter(|check| is_jax(check) == by_jax).map(Check::judged_independently).max().unwrap_or(0)
        };
        let has_witness = |quantity: Quantity, by_jax: &[bool]| {
            by_jax.iter().any(|by_jax| witnessed(quantity, *by_jax) > 0)
        };
        let without_witness: Vec<Quantity> =
            judged.iter().copied().filter(|quantity| !has_witness(*quantity, &[false, true])).collect();
        let lacking = |quantity: &Quantity| {
            let of_it = || checks.iter().filter(|check| check.quantity == Some(*quantity));
            let is_given = |k: usize| of_it().any(|check| check.components.given[k] > 0);
            let is_judged =
                |k: usize| of_it().any(|check| check.is_independent() && check.components.decided[k] > 0);
            let components = (0..6).filter(|k| is_given(*k) && !is_judged(*k));
            components.map(|k| COMPONENT[k]).collect::<Vec<_>>()
        };
        let others = judged.iter().filter(|quantity| !without_witness.contains(quantity));
        let components_without_witness: BTreeMap<_, _> =
            others.map(|of| (*of, lacking(of))).filter(|(_, components)| !components.is_empty()).collect();
        let all = |quantity: &Quantity| {
            let is_whole = !components_without_witness.contains_key(quantity);
            if is_whole { witnessed(*quantity, false) + witnessed(*quantity, true) } else { 0 }
        };
        let judged_independently = judged.iter().map(all).min().unwrap_or(0);
        let is_witnessed =
            !judged.is_empty() && without_witness.is_empty() && components_without_witness.is_empty();
        let of = |wanted: &dyn Fn(&Check) -> bool| {
            let chosen = checks.iter().filter(|check| wanted(check));
            chosen.map(Check::claim).max()
        };
        let is_declared = |check: &Check| check.against == Against::Law(Invariant::Sparsity);
        // JAX has formulas of its own: what it says of numbers whose derivatives somebody else has judged is about formulas.
        let is_of_formula = |check: &Check| {
            is_jax(check) && check.quantity.is_some_and(|quantity| has_witness(quantity, &[false]))
        };
        let derivative = of(&|check| !is_declared(check) && !is_of_formula(check)).unwrap_or(Verdict::Pass);
        let declaration = of(&is_declared).unwrap_or(Verdict::Pass);
        let by_jax = of(&|check| is_jax(check) && check.compared > 0);
        let proven = |is: bool| if is { Verdict::Pass } else { Verdict::Undecided };
        let has = |is: fn(&Certificate) -> bool| certificate.as_ref().is_some_and(is);
        Self {
            type_name: name.clone(),
            name,
            scene: None,
            cases,
            judged_independently,
            without_witness,
            components_without_witness,
            not_exercised,
            laws_not_asked,
            derivative: if is_witnessed { derivative } else { derivative.max(Verdict::Undecided) },
            formula: by_jax.unwrap_or_else(|| proven(has(|c| c.jax_states > 0))),
            declaration: declaration.max(proven(has(Certificate::is_declaration_read))),
            checks,
            certificate,
        }
    }

    /// The name, with the scene that it is of.
    pub fn title(&self) -> String {
        match &self.scene {
            Some(scene) => format!("{} of {scene}", self.name),
            None => self.name.clone(),
        }
    }

    /// Whether the declaration is open for nothing but a part of the manual's page that could not be read: that is a note on the
    /// manual, and no verdict.
    pub fn is_page_unread(&self) -> bool {
        let unread = self.certificate.as_ref().is_some_and(|certificate| certificate.unread.is_some());
        unread && self.declaration == Verdict::Undecided
    }

    /// The severest of the three claims.
    pub fn verdict(&self) -> Verdict {
        let declaration = if self.is_page_unread() { Verdict::Pass } else { self.declaration };
        self.derivative.max(self.formula).max(declaration)
    }
}

/// An audit.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Report {
    /// The version of this program.
    pub version: &'static str,
    /// What was asked.
    pub settings: Settings,
    /// C of the bound.
    pub constant: f64,
    /// What was audited.
    pub subjects: Vec<Subject>,
    /// Of scenes of which only a sample was judged: how large a share it is.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sampled: Vec<Share>,
    /// Singular points.
    pub atlas: Vec<Approach>,
    /// What is found in the models of scenes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "schema", schemars(with = "Vec<serde_json::Value>"))]
    pub models: Vec<ModelReport>,
}

impl Report {
    /// The check at a place.
    pub fn check_mut(&mut self, [subject, check]: [usize; 2]) -> Option<&mut Check> {
        self.subjects.get_mut(subject)?.checks.get_mut(check)
    }

    /// A report of subjects and singular points.
    pub fn new(settings: &Settings, subjects: Vec<Subject>, atlas: Vec<Approach>) -> Self {
        Self {
            version: pintle_kinematics::VERSION,
            settings: settings.clone(),
            constant: C,
            subjects,
            sampled: Vec::new(),
            atlas,
            models: Vec::new(),
        }
    }

    /// The same with what another report found.
    #[must_use]
    pub fn joined(mut self, other: Self) -> Self {
        self.subjects.extend(other.subjects);
        self.sampled.extend(other.sampled);
        self.atlas.extend(other.atlas);
        self.models.extend(other.models);
        self
    }

    /// Subjects with a verified mismatch, and singular sets that are not what they are declared to be.
    pub fn mismatches(&self) -> usize {
        let wrong = self.subjects.iter().filter(|subject| subject.verdict().is_mismatch()).count();
        wrong + self.atlas.iter().filter(|approach| !approach.is_confirmed()).count()
    }

    /// Whether a mismatch is verified: by more than the word of one independent oracle against another's.
    pub fn is_verified_wrong(&self) -> bool {
        self.subjects.iter().any(Subject::is_wrong) || !self.atlas.iter().all(Approach::is_confirmed)
    }

    /// Quantities of subjects on which independent oracles contradict each other.
    pub fn contradictions(&self) -> usize {
        self.subjects.iter().map(|subject| subject.contradicted().len()).sum()
    }

    /// Models of which a finding is an error.
    pub fn failing_models(&self) -> usize {
        self.models.iter().filter(|model| model.fails()).count()
    }

    /// Models of whose assembly a rank is not certain, or was not found.
    pub fn undecided_models(&self) -> usize {
        let is_undecided = |model: &&ModelReport| {
            model.assembly.iter().chain(&model.later_steps).any(|assembly| !assembly.is_decided())
        };
        self.models.iter().filter(is_undecided).count()
    }

    /// Subjects of which something is undecided, and models of whose assembly a rank is.
    pub fn undecided(&self) -> usize {
        self.undecided_subjects() + self.undecided_models()
    }

    /// The number of findings in models that are warnings.
    pub fn warnings(&self) -> usize {
        self.models.iter().map(|model| model.count(Severity::Warning)).sum()
    }

    /// Subjects of which something is undecided.
    pub fn undecided_subjects(&self) -> usize {
        self.subjects.iter().filter(|subject| subject.verdict() == Verdict::Undecided).count()
    }

    /// Subjects with numbers that no independent oracle judged.
    pub fn unwitnessed(&self) -> usize {
        self.subjects.iter().filter(|subject| !subject.lacking_a_witness().is_empty()).count()
    }

    /// Subjects with a state on a singular set where nobody could judge something, which is not declared.
    pub fn unjudged(&self) -> usize {
        let is_unjudged = |check: &Check| check.states.contains_key(&Verdict::Singular);
        self.subjects.iter().filter(|subject| subject.checks.iter().any(is_unjudged)).count()
    }

    /// Whether something is undecided, not exercised, judged by nobody or beyond a sample: what fails where the audit is strict.
    pub fn is_open(&self) -> bool {
        self.undecided() + self.not_exercised() + self.unjudged() + self.sampled.len() > 0
    }

    /// Subjects with numbers of which no state tells whether a mistake would have been noticed.
    pub fn not_exercised(&self) -> usize {
        self.subjects.iter().filter(|subject| !subject.not_exercised.is_empty()).count()
    }

    /// Mutants that survived a check which passed the numbers themselves, and laws that noticed none of those that change what they
    /// speak of.
    pub fn survivors(&self) -> u64 {
        let checks = self.subjects.iter().flat_map(|subject| &subject.checks);
        let survived: u64 = checks.map(|check| check.score.survived).sum();
        survived + self.blind_laws().len() as u64
    }

    /// Laws that noticed no mutant over all subjects, though some change the numbers of which they speak.
    pub fn blind_laws(&self) -> Vec<Invariant> {
        let mut laws: BTreeMap<Invariant, [u64; 2]> = BTreeMap::new();
        for check in self.subjects.iter().flat_map(|subject| &subject.checks) {
            if let Against::Law(law) = check.against {
                let [noticed, changed] = laws.entry(law).or_default();
                *noticed += check.score.killed;
                *changed += check.score.decisive() + check.score.below_resolution;
            }
        }
        let is_blind = |[noticed, changed]: [u64; 2]| noticed == 0 && changed > 0;
        laws.into_iter().filter(|(_, found)| is_blind(*found)).map(|(law, _)| law).collect()
    }

    /// Whether anything is wrong of which a counter-example can be written, and none was.
    pub fn lacks_counter_examples(&self) -> bool {
        let mut checks = self.subjects.iter().flat_map(|subject| &subject.checks);
        checks.any(|check| {
            check.verdict.is_mismatch() && check.failing.is_some() && check.counter_example.is_none()
        })
    }

    /// Subjects with mismatches of which there is no counter-example: those of all forces of a connector together, which follow from
    /// more than a state; each with the kinds of numbers.
    pub fn without_counter_example(&self) -> Vec<(String, Vec<Quantity>)> {
        let of = |subject: &Subject| {
            let failed = subject.checks.iter().filter(|check| check.verdict.is_mismatch());
            let mut kinds: Vec<Quantity> =
                failed.filter(|check| check.failing.is_none()).filter_map(|check| check.quantity).collect();
            kinds.dedup();
            (!kinds.is_empty()).then(|| (subject.title(), kinds))
        };
        self.subjects.iter().filter_map(of).collect()
    }

    /// Whether what was audited has numbers in which the fault that was asked for is planted; true where none was.
    pub fn has_place_for_fault(&self) -> bool {
        let mut checks = self.subjects.iter().flat_map(|subject| &subject.checks);
        self.settings.planted.is_none_or(|planted| checks.any(|check| planted.is_in(check)))
    }

    /// Entries compared in all.
    pub fn compared(&self) -> u64 {
        self.subjects.iter().flat_map(|subject| &subject.checks).map(|check| check.compared).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(quantity: Quantity, oracle: Oracle, verdict: Verdict) -> Check {
        let mut check = Check::new(Some(quantity), Against::Oracle(oracle));
        check.add_at(Judgement { verdict, worst: None, compared: 1 }, Score::default(), "a state", None);
        check
    }

    /// A component that no independent oracle judges is undecided, however many judge the others.
    #[test]
    fn every_component_needs_a_witness() {
        let rates = Quantity::Rate;
        let judged = |oracle: Oracle, wanted: &'static [usize]| {
            let mut check = judged(rates, oracle, Verdict::Pass);
            check.compares(|k| k < 2, |k| wanted.contains(&k));
            check
        };
        let open = |checks: Vec<Check>| {
            let subject = Subject::new("it".to_string(), None, 1, checks, &Expected::numbers(&[rates]));
            (subject.derivative, subject.judged_independently, subject.components_without_witness)
        };
        let by_dual = || judged(Oracle::WideDual, &[0, 1]);
        let whole = open(vec![judged(Oracle::WideDifferences, &[0, 1]), by_dual()]);
        assert_eq!(whole, (Verdict::Pass, 1, BTreeMap::new()));
        let half = open(vec![judged(Oracle::WideDifferences, &[0]), by_dual()]);
        assert_eq!(half, (Verdict::Undecided, 0, BTreeMap::from([(rates, vec!["u2"])])));
        let mut both = judged(Oracle::WideDifferences, &[0]);
        both.merge(judged(Oracle::WideDifferences, &[1]));
        assert_eq!(open(vec![both]).0, Verdict::Pass);
    }

    /// What JAX says is about the formula where others say that the derivative is that of the function; alone it is about both.
    #[test]
    fn claims_are_told_apart() {
        let rows = Quantity::FirstDerivatives;
        let claims = |checks: Vec<Check>| {
            let expected = Expected::numbers(&[rows]);
            let subject = Subject::new("it".to_string(), None, 1, checks, &expected);
            (subject.derivative, subject.formula, subject.without_witness)
        };
        let wrong = || judged(rows, Oracle::Jax, Verdict::Wrong);
        let right = || judged(rows, Oracle::WideDifferences, Verdict::Pass);
        assert_eq!(claims(vec![right(), wrong()]), (Verdict::Pass, Verdict::Wrong, vec![]));
        assert_eq!(claims(vec![wrong()]), (Verdict::Wrong, Verdict::Wrong, vec![]));
        assert_eq!(claims(vec![right()]), (Verdict::Pass, Verdict::Undecided, vec![]));
        // What shares the mechanism or the functions is no other witness.
        let dual = judged(rows, Oracle::WideDual, Verdict::Pass);
        assert_eq!(claims(vec![dual.clone(), wrong()]), (Verdict::Wrong, Verdict::Wrong, vec![]));
        assert_eq!(claims(vec![dual]), (Verdict::Undecided, Verdict::Undecided, vec![rows]));
    }

    /// The matrix shown is that of the worst state, or none.
    #[test]
    fn a_matrix_is_of_the_worst_state() {
        let mut wrong = Check::new(Some(Quantity::FirstDerivatives), Against::Own);
        wrong.verdict = Verdict::Wrong;
        wrong.comparison = Some(Box::new(Comparison { columns: Vec::new(), rows: Vec::new() }));
        let mut invalid = Check::new(Some(Quantity::FirstDerivatives), Against::Own);
        invalid.verdict = Verdict::Invalid;
        let mut both = wrong.clone();
        both.merge(invalid.clone());
        assert!(both.verdict == Verdict::Invalid && both.comparison.is_none());
        invalid.merge(wrong);
        assert!(invalid.comparison.is_none());
    }
}
