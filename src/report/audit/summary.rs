//! What every form of the report says of a subject, counted once.

use pintle_audit::oracles::certificate::Certificate;
use pintle_audit::{Against, Cause, Check, Fared, Finding, Quantity, Report, Share, Subject, Verdict};
use pintle_scene::Severity;
use pintle_scene::grammar::{agree, count, number};
use std::collections::BTreeMap;

/// What the columns of the table of verdicts say.
pub(super) const LEGEND: &str = "independent: of the states, those at which every kind of number was judged on 237 bits or by JAX; f … F: worst error in units of its tolerance, F: of springs, dampers and friction with their slopes; δ seen: the smallest relative error of an entry \
     that is noticed, median";

/// The line of a subject in the table of verdicts.
pub(super) struct SubjectRow {
    pub(super) name: String,
    type_name: String,
    /// On derivative, formula, declaration.
    pub(super) verdicts: [Verdict; 3],
    pub(super) states: u64,
    /// How many of them an independent oracle judged.
    pub(super) independent: u64,
    /// The worst error of the sharp oracles in units of the tolerance, by quantity.
    pub(super) worst: [Option<f64>; COLUMNS],
    /// The smallest relative error of a first derivative that is noticed, at the median state.
    pub(super) seen: Option<f64>,
    /// Whether a part of the manual's page could not be read, and the declaration is open for that alone.
    pub(super) is_page_unread: bool,
}

/// What stands for a declaration of which a part of the manual's page could not be read.
pub(super) const PAGE_UNREAD: &str = "page unread";

/// Why nobody confirms a declaration in full.
pub(super) fn unconfirmed(subject: &Subject) -> String {
    let source = subject.certificate.as_ref().map(Certificate::source);
    match source {
        Some(source) if subject.is_page_unread() => {
            format!("a note on the manual, no verdict on the scene: {source}")
        }
        Some(source) => format!("declaration undecided: {source}"),
        None => "declaration undecided: never typed a second time".to_string(),
    }
}

/// A number beside what it must be: in the shortest digits that tell it from its neighbours.
pub(super) fn against_tolerance(worst: &Finding) -> String {
    let exact = |x: f64| {
        // A zero has no sign.
        let x = x + 0.0;
        let digits =
            if x == 0.0 || (1e-4..1e6).contains(&x.abs()) { format!("{x}") } else { format!("{x:e}") };
        if x.is_nan() { "nothing".to_string() } else { digits }
    };
    let Finding { entry, got, want, tolerance, units, .. } = worst;
    // What is given or missing against the declaration says so itself.
    if got.is_nan() && want.is_nan() {
        return entry.clone();
    }
    format!(
        "{entry}: {}, must be {}, tolerance {}: {} tolerances",
        exact(*got),
        exact(*want),
        number(*tolerance, 3),
        number(*units, 4)
    )
}

/// The quantities of components, and all of behaviour in one.
const COLUMNS: usize = Quantity::ALL.len() + 1;

/// The headings of the columns of [`SubjectRow::worst`].
pub(super) fn symbols() -> [&'static str; COLUMNS] {
    let mut symbols = ["F"; COLUMNS];
    symbols.iter_mut().zip(Quantity::ALL).for_each(|(symbol, quantity)| *symbol = quantity.symbol());
    symbols
}

impl SubjectRow {
    pub(super) fn of(subject: &Subject) -> Self {
        Self {
            name: subject.name.clone(),
            type_name: subject.type_name.clone(),
            verdicts: [subject.derivative, subject.formula, subject.declaration],
            states: subject.cases,
            independent: subject.judged_independently,
            worst: std::array::from_fn(|i| match Quantity::ALL.get(i) {
                Some(quantity) => worst(subject, &[*quantity]),
                None => worst(subject, &Quantity::OF_BEHAVIOR),
            }),
            seen: detectable(subject),
            is_page_unread: subject.is_page_unread(),
        }
    }

    /// One row for those of a type that came out alike: states together, errors the largest.
    pub(super) fn by_type(rows: Vec<Self>) -> Vec<Self> {
        let mut found: Vec<(usize, Self)> = Vec::new();
        for row in rows {
            let is_same = |known: &Self| (&known.type_name, known.verdicts) == (&row.type_name, row.verdicts);
            let Some((count, known)) = found.iter_mut().find(|(_, known)| is_same(known)) else {
                found.push((1, row));
                continue;
            };
            *count += 1;
            (known.states, known.independent) =
                (known.states + row.states, known.independent + row.independent);
            let larger = |x: Option<f64>, y: Option<f64>| x.into_iter().chain(y).reduce(f64::max);
            for (most, units) in known.worst.iter_mut().zip(row.worst) {
                *most = larger(*most, units);
            }
            known.seen = larger(known.seen, row.seen);
        }
        let several = |(count, row): (usize, Self)| match count {
            1 => row,
            _ => Self { name: format!("{} × {count}", row.type_name), ..row },
        };
        found.into_iter().map(several).collect()
    }
}

/// The worst error of the sharp oracles in units of the tolerance; `None` where none answered.
pub(super) fn worst(subject: &Subject, quantities: &[Quantity]) -> Option<f64> {
    let is_it = |check: &&Check| check.quantity.is_some_and(|quantity| quantities.contains(&quantity));
    let of_it = subject.checks.iter().filter(is_it).filter(|check| is_sharp(check));
    of_it
        .map(|check| check.largest)
        .fold(None, |most: Option<f64>, x| Some(most.map_or(x, |most| most.max(x))))
}

/// Whether an independent oracle's word decides in this check.
pub(super) const fn is_sharp(check: &Check) -> bool {
    matches!(check.against, Against::Oracle(oracle) if oracle.is_independent())
}

/// The smallest relative error of a first derivative that the sharp oracles notice on every significant entry, at the median state.
pub(super) fn detectable(subject: &Subject) -> Option<f64> {
    let sharp = subject
        .checks
        .iter()
        .filter(|check| check.quantity == Some(Quantity::FirstDerivatives) && is_sharp(check));
    sharp.filter_map(|check| check.score.detectable_median).reduce(f64::max)
}

/// The checks that say something is wrong, lost or survived.
pub(super) fn telling(subject: &Subject) -> impl Iterator<Item = &Check> {
    subject.checks.iter().filter(|check| check.verdict > Verdict::IllConditioned || check.score.survived > 0)
}

/// What was left out of the audit of which subjects: numbers without a witness, or that no state exercises, laws that were not asked.
pub(super) fn left_out(report: &Report) -> BTreeMap<String, Vec<&str>> {
    let mut found: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for subject in &report.subjects {
        for text in left_out_of(subject) {
            found.entry(text).or_default().push(&subject.name);
        }
    }
    found
}

/// The same of one subject.
fn left_out_of(subject: &Subject) -> impl Iterator<Item = String> {
    let told =
        without_witness(subject).into_iter().chain(not_exercised(subject)).chain(laws_not_asked(subject));
    told.chain(ill_conditioned(subject))
}

/// That a subject passes at states where that does not say much.
fn ill_conditioned(subject: &Subject) -> Option<String> {
    let is_so = |check: &Check| check.states.contains_key(&Verdict::IllConditioned);
    subject.checks.iter().any(is_so).then(|| {
        "ill-conditioned at some states, where an error of more than 1e-6 of a row may pass: -v and JSON tell of which \
         numbers, and how small an error was seen"
            .to_string()
    })
}

fn with_list<'a>(why: &str, list: impl Iterator<Item = &'a str>) -> Option<String> {
    let list: Vec<&str> = list.collect();
    (!list.is_empty()).then(|| format!("{why}: {}", list.join(", ")))
}

/// The numbers of a subject that no independent oracle judged.
pub(super) fn without_witness(subject: &Subject) -> Option<String> {
    let names = subject.lacking_a_witness();
    let why = "undecided, for no independent oracle of those asked judged them";
    with_list(why, names.iter().map(String::as_str))
}

/// The numbers of a subject that no state exercises, or nobody who was asked compares.
pub(super) fn not_exercised(subject: &Subject) -> Option<String> {
    let is_compared = |quantity: &Quantity| {
        subject.checks.iter().any(|check| check.quantity == Some(*quantity) && check.compared > 0)
    };
    let of = |compared: bool| {
        let those = subject.not_exercised.iter().filter(move |quantity| is_compared(quantity) == compared);
        those.map(|quantity| quantity.name())
    };
    let nobody = with_list("not exercised, for none of the oracles asked compares them", of(false));
    let why = "not exercised, for no mistake counts at these states, as of what is zero whatever the formula";
    let zero = with_list(why, of(true));
    let both: Vec<String> = nobody.into_iter().chain(zero).collect();
    (!both.is_empty()).then(|| both.join("; "))
}

/// The laws that a subject was not asked.
pub(super) fn laws_not_asked(subject: &Subject) -> Option<String> {
    let names = subject.laws_not_asked.iter().map(|law| law.name());
    with_list("laws not asked, for want of degrees of freedom or of states where they hold", names)
}

/// What there is in place of a derivative where there is none: those from both sides, and why one of them is missing.
pub(super) fn sides(check: &Check) -> impl Iterator<Item = String> {
    let side = |x: f64| if x.is_nan() { "none".to_string() } else { number(x, 11) };
    let worst = check.worst.as_ref();
    let both = worst.and_then(|worst| worst.one_sided);
    let both = both.map(|[below, above]| format!("from below {}, from above {}", side(below), side(above)));
    both.into_iter().chain(worst.and_then(|worst| worst.lack).map(String::from))
}

/// Why states of a check are undecided, a sentence for each reason; and from which stage on one is invalid.
pub(super) fn undecided(check: &Check) -> impl Iterator<Item = String> {
    let stage = check.stage.map(|stage| format!("not finite from this on: {stage}"));
    let reasons = check.undecided.iter().map(|(why, states)| {
        let states = count(usize::try_from(*states).unwrap_or(usize::MAX), "state");
        format!("undecided at {states}: {why}")
    });
    reasons.chain(stage)
}

/// How the mutants fared under the oracles.
pub(super) struct SelfTest {
    pub(super) noticed: u64,
    pub(super) decisive: u64,
    pub(super) equivalent: u64,
    pub(super) below_resolution: u64,
}

/// How the mutants fared under the oracles.
pub(super) fn self_test(report: &Report) -> SelfTest {
    let mut found = SelfTest { noticed: 0, decisive: 0, equivalent: 0, below_resolution: 0 };
    let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
    for check in checks.filter(|check| matches!(check.against, Against::Oracle(_))) {
        found.noticed += check.score.killed;
        found.decisive += check.score.decisive();
        found.equivalent += check.score.equivalent;
        found.below_resolution += check.score.below_resolution;
    }
    found
}

/// How the mutants of one kind fared under oracles, and how many of them laws noticed.
#[derive(Clone, Copy, Default)]
pub(super) struct OfKind {
    pub(super) by_oracles: Fared,
    pub(super) by_laws: u64,
}

/// How the mutants fared, by kind.
pub(super) fn by_mistake(report: &Report) -> BTreeMap<Cause, OfKind> {
    let mut found: BTreeMap<Cause, OfKind> = BTreeMap::new();
    for check in report.subjects.iter().flat_map(|subject| &subject.checks) {
        for (cause, fared) in &check.score.by_mistake {
            let of_kind = found.entry(*cause).or_default();
            match check.against {
                Against::Law(_) => of_kind.by_laws += fared.killed,
                Against::Oracle(_) | Against::Own => of_kind.by_oracles.add(*fared),
            }
        }
    }
    found
}

/// How an audit came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AuditOutcome {
    /// Nothing is wrong, undecided or warned of.
    Clean,
    /// A finding is a warning, and nothing is worse.
    Warned,
    /// A verdict is undecided, or the rank of an assembly, and nothing is wrong.
    Undecided,
    /// A number is wrong, a mutant survived, a finding is an error; with --strict, something is undecided.
    Failed,
}

/// How an audit came out: every form of the report shows the same.
pub(super) fn outcome(report: &Report) -> AuditOutcome {
    let is_open = report.undecided() > 0;
    let fails_as_open = report.settings.strict && report.is_open();
    let is_unproven = report.survivors() > 0 || report.contradictions() > 0;
    if report.mismatches() > 0 || is_unproven || report.failing_models() > 0 || fails_as_open {
        AuditOutcome::Failed
    } else if is_open {
        AuditOutcome::Undecided
    } else if report.warnings() > 0 {
        AuditOutcome::Warned
    } else {
        AuditOutcome::Clean
    }
}

/// A number in words up to twelve.
fn in_words(n: usize, noun: &str) -> String {
    const WORDS: [&str; 13] = [
        "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven",
        "twelve",
    ];
    let counted = count(n, noun);
    match (WORDS.get(n), counted.split_once(' ')) {
        (Some(word), Some((_, noun))) => format!("{word} {noun}"),
        _ => counted,
    }
}

/// The outcome in one sentence, for those who do not know the words of this report.
pub(super) fn sentence(report: &Report) -> String {
    let findings = |severity| report.models.iter().map(|model| model.count(severity)).sum::<usize>();
    let of = |severity, noun: &str| match findings(severity) {
        0 => None,
        n => Some(in_words(n, noun)),
    };
    let wrong = report.mismatches();
    let unproven = report.survivors() > 0 || report.contradictions() > 0;
    let what = match report.models.len() {
        0 => None,
        1 => Some(("The model", "is", "has")),
        _ => Some(("The models", "are", "have")),
    };
    let mut words = match (what, of(Severity::Error, "error")) {
        _ if wrong > 0 => {
            let who = agree(wrong, ["one subject", "several subjects"]);
            format!("Numbers of {who} are wrong: do not rely on them")
        }
        _ if unproven => "The audit itself failed: nothing is to be concluded from it".to_string(),
        (Some((model, _, has)), Some(errors)) => {
            format!("{model} {has} {errors}, to be mended before anything is computed")
        }
        (Some((model, is, _)), None) => {
            let remarks = [of(Severity::Warning, "warning"), of(Severity::Note, "remark")];
            let remarks: Vec<String> = remarks.into_iter().flatten().collect();
            match remarks.as_slice() {
                [] => format!("{model} {is} sound; nothing was found"),
                remarks if findings(Severity::Warning) == 0 => {
                    format!("{model} {is} sound; {}", remarks.join(", "))
                }
                remarks => format!("{model} can be computed; {}", remarks.join(", ")),
            }
        }
        (None, _) => "Every number that was compared is right".to_string(),
    };
    if wrong == 0 && report.undecided() > 0 {
        words += "; something could not be decided";
    }
    if !report.sampled.is_empty() {
        words += "; numbers were judged by a sample";
    }
    words + "."
}

/// The outcome in a few words.
pub(super) fn headline(report: &Report) -> String {
    let mut words = vec![of_numbers(report)];
    words.extend(report.sampled.iter().map(|share| {
        let Share { scene, states, of_states, .. } = share;
        format!("{} of {scene} judged ({states} of {of_states} connector states)", percent(share.part()))
    }));
    let open: Vec<String> = [(report.undecided_subjects(), "subject"), (report.undecided_models(), "model")]
        .into_iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, noun)| count(n, noun))
        .collect();
    if !open.is_empty() {
        words.push(format!("{} undecided", open.join(" and ")));
    }
    if report.settings.strict && report.not_exercised() > 0 {
        words.push(format!("{} not exercised in all", count(report.not_exercised(), "subject")));
    }
    if report.settings.strict && report.unjudged() > 0 {
        words.push(format!("{} at singular points that nobody judged", count(report.unjudged(), "subject")));
    }
    if report.failing_models() > 0 {
        words.push(format!("{} with errors", count(report.failing_models(), "model")));
    }
    if report.warnings() > 0 {
        words.push(count(report.warnings(), "warning"));
    }
    words.join("; ")
}

/// A part in percent, with two digits; less than all is never said to be all.
fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    let digits = if percent < 1.0 { 2 } else { usize::from(percent < 10.0) };
    let shown = format!("{percent:.digits$}");
    if part < 1.0 && shown == "100" { "over 99 %".to_string() } else { format!("{shown} %") }
}

/// Of scenes of which only a sample was judged: what was, a sentence each.
pub(super) fn samples(report: &Report) -> impl Iterator<Item = String> {
    report.sampled.iter().map(|share| {
        let Share { scene, connectors, of_connectors, states, of_states, .. } = share;
        format!(
            "only a sample of {scene} was judged: {connectors} of {of_connectors} connectors and MPCs, {states} of {of_states} connector \
             states ({}); nothing is said of the others, and --budget 2h judges more",
            percent(share.part())
        )
    })
}

/// The outcome of the comparisons.
fn of_numbers(report: &Report) -> String {
    let (mismatches, survivors) = (report.mismatches(), report.survivors());
    let mut words = Vec::new();
    if mismatches > 0 {
        words.push(count(mismatches, "mismatch"));
    }
    if survivors > 0 {
        words.push(format!("self-test failed: {} survived", count(survivors, "mutant")));
    }
    let mut contradicted = Vec::new();
    for subject in &report.subjects {
        contradicted
            .extend(subject.contradicted().iter().map(|of| format!("{} of {}", of.name(), subject.name)));
    }
    if let Some(first) = contradicted.first() {
        let others = contradicted.len() - 1;
        let more = if others > 0 { format!(" and {others} more") } else { String::new() };
        words.push(format!("self-test failed: oracles contradict each other on {first}{more}"));
    }
    match words.is_empty() {
        false => words.join("; "),
        true if report.subjects.is_empty() => "models alone: no number audited".into(),
        true if !report.sampled.is_empty() => "no mismatch in the sample".into(),
        true => "no mismatch".into(),
    }
}

/// The scene that a subject belongs to.
pub(super) fn scene(subject: &Subject) -> Option<&str> {
    subject.scene.as_deref()
}
