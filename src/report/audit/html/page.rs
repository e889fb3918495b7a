//! The page: what stands in which section.

use super::drawing::name_of;
use super::figure::{self, Bin, Curve, LogPlot, Map, Place, STYLE};
use super::{Supplement, drawing};
use crate::audit::assembly::Assembly;
use crate::audit::certificate::Certificate;
use crate::audit::coverage::Histogram;
use crate::audit::model::{ModelReport, Nearest};
use crate::audit::oracle::Shares;
use crate::audit::{Against, Approach, Cause, Check, Quantity, Report, Subject, U, Verdict};
use crate::bench::Environment;
use crate::grammar::count;
use crate::report::audit::model as of_assembly;
use crate::report::audit::summary::{
    self, OfKind, Outcome, Row, detectable, headline, is_sharp, symbols, telling,
};
use crate::scene::Severity;
use askama::Template;
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::io;

/// A verdict's class and words.
struct Said(String, &'static str);

impl Said {
    fn of(verdict: Verdict) -> Self {
        let verdict = verdict.headline();
        Self(name_of(verdict), verdict.name())
    }
}

/// What is to be said of one subject: what tells most, and the rest.
struct ProblemGroup {
    subject: String,
    is_mild: bool,
    shown: Vec<Problem>,
    rest: Vec<Problem>,
    /// How many they are.
    more: String,
}

struct Problem {
    is_mild: bool,
    said: String,
    /// Sentences with codes.
    diagnosis: Vec<(String, &'static str)>,
    /// The matrix, where it is one of first derivatives.
    heat: String,
    numbers: String,
    more: Vec<String>,
}

struct FindingRow {
    class: String,
    severity: String,
    code: &'static str,
    place: String,
    message: String,
    reason: String,
    remedy: String,
}

struct CoverageSection {
    scene: String,
    summary: String,
    maps: Vec<Map>,
}

/// The assembly as a whole, in one step.
struct AssemblySection {
    /// Which step; nothing where there is but one.
    step: String,
    /// Figure by figure, initially.
    figures: Vec<(&'static str, String)>,
    /// What is not as initially at the states given, and what was not looked at.
    more: Vec<String>,
}

struct ModelSection {
    scene: String,
    summary: String,
    assemblies: Vec<AssemblySection>,
    findings: Vec<FindingRow>,
}

struct Figure {
    svg: String,
    caption: String,
}

/// What a cell is sorted by, and what it shows.
struct Sorted(f64, String);

struct VerdictRow {
    text: String,
    name: String,
    verdicts: [Said; 3],
    states: u64,
    independent: u64,
    worst: Vec<Sorted>,
    seen: Sorted,
}

struct Card {
    name: String,
    caption: String,
    heat: String,
}

struct StepCard {
    name: String,
    svg: String,
}

struct ApproachCard {
    name: String,
    at: &'static str,
    class: String,
    class_name: String,
    svg: String,
    /// How near a scene came.
    came: String,
}

struct ScoreRow {
    name: &'static str,
    killed: Count,
    decisive: Count,
    survived: Count,
    equivalent: Count,
    below: Count,
    share: f64,
    percent: String,
}

/// A count, shown with thin spaces between thousands.
struct Count(u64);

impl std::fmt::Display for Count {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&grouped(self.0))
    }
}

/// Mutants with one kind of mistake.
struct KindRow {
    name: &'static str,
    code: &'static str,
    killed: Count,
    decisive: Count,
    survived: Count,
    equivalent: Count,
    below: Count,
    by_laws: Count,
    share: f64,
    percent: String,
}

struct OracleRow {
    name: &'static str,
    meaning: &'static str,
    kinematics: &'static str,
    elementary: &'static str,
    mechanism: &'static str,
    decides: &'static str,
}

#[derive(Template)]
#[template(path = "page.html")]
struct PageTemplate {
    css: &'static str,
    figure_css: &'static str,
    js: &'static str,
    headline: String,
    headline_capital: String,
    tone: &'static str,
    sign: &'static str,
    audited: String,
    facts: Vec<(&'static str, String)>,
    sections: Vec<(&'static str, &'static str)>,
    problems: Vec<ProblemGroup>,
    models: Vec<ModelSection>,
    coverage: Vec<CoverageSection>,
    drawings: Vec<Figure>,
    verdict_key: Vec<Said>,
    symbols: Vec<&'static str>,
    rows: Vec<VerdictRow>,
    undecided: Vec<String>,
    left_out: Vec<String>,
    cards: Vec<Card>,
    omitted: String,
    steps: Vec<StepCard>,
    approaches: Vec<ApproachCard>,
    confirmed: String,
    detectable: String,
    scores: Vec<ScoreRow>,
    kinds: Vec<KindRow>,
    survivors: Vec<String>,
    environment: Vec<(&'static str, String)>,
    oracles: Vec<OracleRow>,
}

/// The page.
pub(super) fn page(report: &Report, supplement: &Supplement<'_>) -> io::Result<String> {
    let outcome = headline(report);
    let (tone, sign) = match summary::outcome(report) {
        Outcome::Failed => ("bad", "✗"),
        Outcome::Undecided => ("open", "?"),
        Outcome::Warned => ("warned", "!"),
        Outcome::Clean => ("good", "✓"),
    };
    let drawings: Vec<Figure> = supplement
        .scenes
        .iter()
        .map(|scene| (scene.name, drawing(report, scene)))
        .filter(|(_, drawing)| !drawing.is_empty())
        .map(|(name, drawing)| Figure { svg: drawing.svg(name, Place::Page), caption: drawing.caption(name) })
        .collect();
    let unseen = supplement.scenes.iter().any(|scene| drawing(report, scene).has_unseen());
    let mut page = PageTemplate {
        css: include_str!("page.css"),
        figure_css: STYLE,
        js: include_str!("page.js"),
        headline_capital: capital(&outcome),
        headline: outcome,
        tone,
        sign,
        audited: audited(supplement),
        facts: facts(report),
        sections: Vec::new(),
        problems: problems(report),
        models: report.models.iter().map(model).collect(),
        coverage: report.models.iter().filter_map(coverage).collect(),
        drawings,
        verdict_key: verdict_key(report, unseen),
        symbols: symbols().into(),
        rows: report.subjects.iter().map(verdict_row).collect(),
        undecided: undecided(report),
        left_out: left_out(report),
        cards: cards(supplement),
        omitted: omitted(report, supplement),
        steps: step_cards(supplement),
        approaches: approaches(report, supplement)
            .map(|found| approach_card(found, report, supplement))
            .collect(),
        confirmed: confirmed(report, supplement),
        detectable: strip(report, Place::Page),
        scores: scores(report),
        kinds: kinds(report),
        survivors: survivors(report),
        environment: environment(report, supplement),
        oracles: oracles(report),
    };
    page.sections = sections(&page);
    page.render().map_err(io::Error::other)
}

/// What was audited: the catalogue, and scenes.
fn audited(supplement: &Supplement<'_>) -> String {
    let catalogue = supplement.catalogue.then_some("the catalogue");
    let all = catalogue.into_iter().chain(supplement.scenes.iter().map(|scene| scene.name));
    all.collect::<Vec<_>>().join(", ")
}

/// What the colours of a drawing mean: verdicts, where numbers were audited, and what was not.
fn verdict_key(report: &Report, unseen: bool) -> Vec<Said> {
    let verdicts = Verdict::ALL.into_iter().filter(|v| v.headline() == *v && !report.subjects.is_empty());
    let not = unseen.then(|| Said("unseen".to_string(), "not audited"));
    verdicts.map(Said::of).chain(not).collect()
}

/// The figures at the head: of the audit, or of the findings where no number was audited.
fn facts(report: &Report) -> Vec<(&'static str, String)> {
    if report.subjects.is_empty() && !report.models.is_empty() {
        let count =
            |severity| report.models.iter().map(|model| model.count(severity)).sum::<usize>().to_string();
        return vec![
            ("models", report.models.len().to_string()),
            ("errors", count(Severity::Error)),
            ("warnings", count(Severity::Warning)),
            ("notes", count(Severity::Note)),
            ("undecided", report.undecided_models().to_string()),
        ];
    }
    let test = summary::self_test(report);
    vec![
        ("connectors and types", grouped(report.subjects.len() as u64)),
        ("numbers compared", grouped(report.compared())),
        ("mismatches", report.mismatches().to_string()),
        ("undecided", report.undecided().to_string()),
        ("warnings", report.warnings().to_string()),
        ("mutants noticed", format!("{} of {}", grouped(test.noticed), grouped(test.decisive))),
    ]
}

fn sections(page: &PageTemplate) -> Vec<(&'static str, &'static str)> {
    let all = [
        ("problems", "What needs a look", !page.problems.is_empty()),
        ("model", "Model", !page.models.is_empty()),
        ("scene", "Scene", !page.drawings.is_empty()),
        ("verdicts", "Verdicts", !page.rows.is_empty()),
        ("coverage", "Coverage", !page.coverage.is_empty()),
        ("jacobians", "Jacobians", !page.cards.is_empty()),
        ("steps", "Steps", !page.steps.is_empty()),
        ("singular", "Singular points", !page.approaches.is_empty()),
        ("self-test", "Would it have noticed?", !page.rows.is_empty()),
        ("environment", "Environment", true),
    ];
    all.into_iter().filter(|section| section.2).map(|(id, name, _)| (id, name)).collect()
}

/// With a capital, where it begins with a word of the language: symbols stay what they are (μ, ur1, e1a, x_b).
fn capital(text: &str) -> String {
    let word = text.split(|c: char| c.is_whitespace() || ",.;:".contains(c)).next().unwrap_or_default();
    let is_word = word.len() > 1 && word.chars().all(|c| c.is_ascii_lowercase() || "-'’".contains(c));
    let is_word = is_word || (word == "a" && is_article(text));
    if !is_word {
        return text.to_string();
    }
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Whether a text that begins with `a` begins with the article, and not with the node: what follows that is a verb or a conjunction.
fn is_article(text: &str) -> bool {
    const AFTER_A_NODE: [&str; 7] = ["and", "or", "to", "at", "by", "from", "against"];
    let next = text.split_whitespace().nth(1).unwrap_or_default();
    let is_word = next.len() > 1 && next.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    is_word && !next.ends_with('s') && !AFTER_A_NODE.contains(&next)
}

/// With a capital and a full stop.
fn sentence(text: &str) -> String {
    let stop = if text.ends_with(['.', '!', '?', ':']) { "" } else { "." };
    capital(text) + stop
}

/// A count with thin spaces between thousands.
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{202f}');
        }
        text.push(digit);
    }
    text
}

/// The name of a subject, after that of its scene where it has one.
fn full_name(subject: &Subject) -> String {
    match summary::scene(subject) {
        Some(scene) => format!("{scene}: {}", subject.name),
        None => subject.name.clone(),
    }
}

fn problems(report: &Report) -> Vec<ProblemGroup> {
    let mut found = Vec::new();
    for subject in &report.subjects {
        let all: Vec<Problem> = telling(subject).map(|check| problem(subject, check)).collect();
        if !all.is_empty() {
            found.push(group(full_name(subject), all));
        }
    }
    for approach in report.atlas.iter().filter(|approach| !approach.is_confirmed()) {
        let problem = Problem {
            is_mild: false,
            said: format!("At {}: {}.", approach.at, approach.told()),
            diagnosis: Vec::new(),
            heat: String::new(),
            numbers: String::new(),
            more: Vec::new(),
        };
        found.push(group(format!("{} {}", approach.connection, approach.component), vec![problem]));
    }
    found
}

/// Each diagnosis is shown once, at the first check that it is of; without any, the first check. The rest is folded.
fn group(subject: String, mut all: Vec<Problem>) -> ProblemGroup {
    all.sort_by_key(|problem| problem.is_mild);
    let is_mild = all.iter().all(|problem| problem.is_mild);
    let (mut shown, mut rest): (Vec<Problem>, Vec<Problem>) = (Vec::new(), Vec::new());
    for mut problem in all {
        let is_new = !problem.diagnosis.is_empty()
            && shown.iter().all(|known: &Problem| known.diagnosis != problem.diagnosis);
        if is_new {
            shown.push(problem);
        } else {
            if !problem.diagnosis.is_empty() {
                problem.heat = String::new();
            }
            rest.push(problem);
        }
    }
    if shown.is_empty() && !rest.is_empty() {
        shown.push(rest.remove(0));
    }
    let more = count(rest.len(), "more check");
    ProblemGroup { subject, is_mild, shown, rest, more }
}

fn problem(subject: &Subject, check: &Check) -> Problem {
    let of = check.quantity.map_or_else(String::new, |quantity| format!("{} against ", quantity.name()));
    let mut numbers = String::new();
    if let Some(worst) = &check.worst {
        numbers = format!(
            "{}: {:e}, must be {:e}, tolerance {:.2e}: {:.3e} tolerances",
            worst.entry, worst.got, worst.want, worst.tolerance, worst.units
        );
        if let Some(state) = &check.worst_state {
            numbers += &format!(", at {state}");
        }
    }
    let mut more: Vec<String> = summary::sides(check).map(|text| sentence(&text)).collect();
    more.extend(summary::undecided(check));
    more.extend(
        check.score.survivors.iter().map(|(mistake, entry)| format!("Survived: {mistake} ({entry}).")),
    );
    Problem {
        is_mild: !check.verdict.is_mismatch() && check.score.survived == 0,
        said: capital(&format!("{of}{}: {}.", check.against.name(), check.verdict.headline().name())),
        diagnosis: check
            .diagnosis
            .iter()
            .flat_map(|diagnosis| diagnosis.lines())
            .map(|(sentence, code)| (capital(&sentence), code.as_str()))
            .collect(),
        heat: check.comparison.as_ref().filter(|_| is_sharp(check)).map_or_else(String::new, |comparison| {
            figure::heat(&full_name(subject), comparison, Place::Page)
        }),
        numbers,
        more,
    }
}

fn model(found: &ModelReport) -> ModelSection {
    let states = match found.states {
        0 => "at the initial state".to_string(),
        n => format!("at the initial state and {}", count(n, "state")),
    };
    ModelSection {
        scene: found.scene.clone(),
        summary: match found.findings.len() {
            0 => format!("Nothing was found {states}."),
            n => format!("{}, {states}.", count(n, "finding")),
        },
        assemblies: found
            .assembly
            .iter()
            .chain(&found.later_steps)
            .map(|of_step| assembly(of_step, !found.later_steps.is_empty()))
            .collect(),
        findings: found
            .findings
            .iter()
            .map(|finding| {
                let severity = format!("{:?}", finding.severity()).to_lowercase();
                let line = finding.line().map_or_else(String::new, |line| format!(":{line}"));
                FindingRow {
                    class: severity.clone(),
                    severity,
                    code: finding.code().as_str(),
                    place: format!("{}{line}", finding.file()),
                    message: sentence(finding.message()),
                    reason: if finding.reason().is_empty() {
                        String::new()
                    } else {
                        sentence(finding.reason())
                    },
                    remedy: finding.remedy().to_string(),
                }
            })
            .collect(),
    }
}

fn assembly(found: &Assembly, is_of_many: bool) -> AssemblySection {
    let mut figures = vec![
        ("degrees of freedom", grouped(found.degrees_of_freedom as u64)),
        ("held by boundary conditions", grouped(found.held as u64)),
        ("constraints", grouped(found.constraints as u64)),
        ("drives", grouped(found.drives as u64)),
        ("mobility by Grübler", found.gruebler.to_string()),
    ];
    let known =
        |number: Option<usize>| number.map_or_else(|| "not known".into(), |number| grouped(number as u64));
    if let Some(initial) = found.positions.first() {
        let certainty = if initial.decided { "" } else { ", undecided" };
        figures.extend([
            ("rank of the constraints", known(initial.rank) + certainty),
            ("redundant", known(initial.redundant)),
            ("mobility", known(initial.mobility)),
            ("not driven", known(initial.undriven)),
        ]);
    }
    if !found.unread.is_empty() {
        let kinds: Vec<&str> = found.unread.iter().map(|kind| kind.what.as_str()).collect();
        figures.push(("constraints not read", kinds.join(", ")));
    }
    let step = match (is_of_many, found.step) {
        (false, _) => String::new(),
        (true, 0) => "Before the first step".to_string(),
        (true, step) => format!("Step {step}"),
    };
    AssemblySection {
        step,
        figures,
        more: of_assembly::besides(found).iter().map(|line| sentence(line)).collect(),
    }
}

/// Which region of configuration space the states of a scene exercised; nothing where there were no samples.
fn coverage(found: &ModelReport) -> Option<CoverageSection> {
    let coverage = &found.coverage;
    if coverage.exercise.samples == 0 {
        return None;
    }
    let all = [
        &coverage.rotation_a,
        &coverage.rotation_b,
        &coverage.relative_rotation,
        &coverage.stretch,
        &coverage.margin,
    ];
    let of = |n: u64, all: u64| format!("{} of {}", grouped(n), grouped(all));
    Some(CoverageSection {
        scene: found.scene.clone(),
        summary: format!(
            "{}, every connector at each state: both nodes turned by more than 0.1 rad in {}, free components moved in {}, \
             away from the initial state in {}.{}",
            count(coverage.exercise.samples, "sample"),
            of(coverage.exercise.both_turned, coverage.exercise.could_turn_both),
            of(coverage.exercise.deformed, coverage.exercise.could_deform),
            of(coverage.exercise.away, coverage.exercise.samples),
            found
                .nearest
                .as_ref()
                .map_or_else(String::new, |nearest| format!(" The {}.", of_assembly::nearest(nearest)))
        ),
        maps: all.into_iter().filter(|histogram| histogram.samples() > 0).map(map).collect(),
    })
}

/// The lower edge of a bin, short enough to stand below it.
fn edge_name(edge: f64) -> String {
    /// Edges that are so near to 1 are told by what they are away from it.
    const NEAR: f64 = 1e-3;
    let plain = |x: f64| if x == 0.0 || (1e-3..1e3).contains(&x) { format!("{x}") } else { format!("{x:e}") };
    match edge {
        FRAC_PI_2 => "π/2".to_string(),
        PI => "π".to_string(),
        TAU => "2π".to_string(),
        x if x != 1.0 && (x - 1.0).abs() < NEAR => {
            let sign = if x < 1.0 { '−' } else { '+' };
            format!("1{sign}{:.0e}", (x - 1.0).abs())
        }
        x => plain(x),
    }
}

fn map(histogram: &Histogram) -> Map {
    let samples = histogram.samples();
    let bins = histogram.edges.iter().zip(&histogram.counts).map(|(edge, count)| {
        let share = *count as f64 / samples.max(1) as f64;
        let depth = match share {
            0.0 => 0,
            x if x < 0.01 => 1,
            x if x < 0.1 => 2,
            x if x < 0.5 => 3,
            _ => 4,
        };
        Bin { depth, from: edge_name(*edge), count: if *count == 0 { "–".into() } else { grouped(*count) } }
    });
    let unit = if histogram.unit.is_empty() { String::new() } else { format!(", {}", histogram.unit) };
    Map {
        name: format!("{}{unit}", histogram.quantity),
        bins: bins.collect(),
        largest: format!("{:.3}", histogram.largest),
    }
}

fn verdict_row(subject: &Subject) -> VerdictRow {
    let row = Row::of(subject);
    let name = full_name(subject);
    let words = row.verdicts.map(|verdict| verdict.headline().name()).join(" ");
    let worst = row.worst.map(|units| match units {
        Some(units) if units < 1000.0 => Sorted(units, format!("{units:.2}")),
        Some(units) => Sorted(units, format!("{units:.1e}")),
        None => Sorted(-1.0, "–".into()),
    });
    VerdictRow {
        text: format!("{name} {words}"),
        name,
        verdicts: row.verdicts.map(Said::of),
        states: row.states,
        independent: row.independent,
        worst: worst.into(),
        seen: detectable(subject).map_or_else(|| Sorted(2.0, "–".into()), |x| Sorted(x, format!("{x:.0e}"))),
    }
}

fn undecided(report: &Report) -> Vec<String> {
    let open = report.subjects.iter().filter(|subject| subject.declaration == Verdict::Undecided);
    let line = |subject: &Subject| {
        let page = subject
            .certificate
            .as_ref()
            .map_or_else(|| "never typed a second time".to_string(), Certificate::source);
        format!("{}: declaration undecided: {page}", full_name(subject))
    };
    let mut lines: Vec<String> = open.map(line).collect();
    lines.dedup();
    lines
}

fn cards(supplement: &Supplement<'_>) -> Vec<Card> {
    let card = |shown: &crate::audit::Illustration| Card {
        name: shown.subject.clone(),
        caption: format!("{}; worst {:.2} tolerances", shown.state, shown.comparison.worst()),
        heat: figure::heat(&shown.subject, &shown.comparison, Place::Page),
    };
    supplement.illustrations.iter().map(card).collect()
}

fn omitted(report: &Report, supplement: &Supplement<'_>) -> String {
    let (all, shown) = (report.subjects.len(), supplement.illustrations.len());
    if shown < all { format!("Shown are {shown} of {all}.") } else { String::new() }
}

fn step_cards(supplement: &Supplement<'_>) -> Vec<StepCard> {
    let has_curves = |shown: &&crate::audit::Illustration| !shown.steps.remainder.is_empty();
    let card = |shown: &crate::audit::Illustration| StepCard {
        name: shown.subject.clone(),
        svg: figure::steps(shown, Place::Page),
    };
    supplement.illustrations.iter().filter(has_curves).map(card).collect()
}

/// The histograms of coverage of the scenes, each as a file's text, by name.
pub(super) fn coverage_figures(report: &Report) -> Vec<(String, String)> {
    let of = |section: CoverageSection| {
        let title = format!("{}: where the samples of its states lie", section.scene);
        let figure = figure::coverage(&title, &section.maps);
        (section.scene, figure)
    };
    report.models.iter().filter_map(coverage).map(of).collect()
}

/// The curves of a singular set.
pub(super) fn approach(found: &Approach, place: Place) -> String {
    let curve = |name, colour, of: fn(&crate::audit::atlas::Rung) -> f64| Curve {
        name,
        is_main: false,
        colour,
        points: found.rungs.iter().map(|rung| [rung.distance, of(rung)]).collect(),
    };
    let plot = LogPlot {
        title: &format!("{} {}: {}", found.connection, found.component, found.at),
        heading: Vec::new(),
        x_name: "distance to the singular set",
        y_name: "roundings; size",
        curves: vec![
            curve("error, of the conditioned scale", 1, |rung| rung.first_error),
            curve("error, of the largest derivative", 2, |rung| rung.first_relative / U),
            curve("largest derivative", 3, |rung| rung.steepness),
        ],
        levels: vec![(crate::audit::C, "tolerance")],
        has_legend: false,
    };
    plot.svg(place)
}

/// The singular sets of the catalogue that was audited, or of the types of the scenes.
fn approaches<'a>(report: &'a Report, supplement: &'a Supplement<'_>) -> impl Iterator<Item = &'a Approach> {
    report.atlas.iter().chain(&supplement.approaches)
}

fn approach_card(found: &Approach, report: &Report, supplement: &Supplement<'_>) -> ApproachCard {
    let (class, class_name) = if found.is_confirmed() {
        let (name, _) = crate::report::words::singular_class(found.declared);
        ("pass", format!("{name}, confirmed"))
    } else {
        ("wrong", found.told())
    };
    ApproachCard {
        name: format!("{} {}", found.connection, found.component),
        at: found.at,
        class: class.into(),
        class_name,
        svg: approach(found, Place::Page),
        came: came(found, report, supplement),
    }
}

/// How near the states of a scene came to a singular set, where it is the nearest of the scene.
fn came(found: &Approach, report: &Report, supplement: &Supplement<'_>) -> String {
    let is_of = |(scene, nearest): &(&super::Audited<'_>, &Nearest)| {
        let element = scene.model.connectors.iter().find(|element| element.label == nearest.element);
        let is_type = element.is_some_and(|element| element.definition().connection.name == found.connection);
        is_type && nearest.component == found.component && nearest.at == found.at
    };
    let of_scene = |scene: &'_ super::Audited<'_>| {
        report.models.iter().find(|model| model.scene == scene.scene.name)?.nearest.as_ref()
    };
    let all = supplement.scenes.iter().filter_map(|scene| Some((scene, of_scene(scene)?)));
    let lines = all
        .filter(is_of)
        .map(|(scene, nearest)| format!("{}: {}", scene.name, of_assembly::nearest(nearest)));
    lines.collect::<Vec<_>>().join("; ")
}

fn confirmed(report: &Report, supplement: &Supplement<'_>) -> String {
    let all = approaches(report, supplement).count();
    let confirmed = approaches(report, supplement).filter(|approach| approach.is_confirmed()).count();
    let whose = if supplement.approaches.is_empty() {
        ""
    } else {
        " They are of the types that the scenes use, approached from states drawn about their initial one, not from those of the scenes."
    };
    format!("{confirmed} of {all} are confirmed.{whose}")
}

/// The smallest error that is noticed, by connector: a plot against the rank.
pub(super) fn strip(report: &Report, place: Place) -> String {
    let sharp = |subject: &Subject| {
        let is_it = |check: &&Check| check.quantity == Some(Quantity::FirstDerivatives) && is_sharp(check);
        let scores = || subject.checks.iter().filter(is_it).map(|check| &check.score);
        let most = |of: fn(&crate::audit::Score) -> Option<f64>| scores().filter_map(of).fold(0.0, f64::max);
        [most(|score| score.detectable_median), most(|score| score.detectable)]
    };
    let mut all: Vec<(String, [f64; 2])> = report
        .subjects
        .iter()
        .map(|subject| (full_name(subject), sharp(subject)))
        .filter(|x| x.1[0] > 0.0)
        .collect();
    if all.len() < 2 {
        return String::new();
    }
    all.sort_by(|x, y| x.1[0].total_cmp(&y.1[0]).then(x.1[1].total_cmp(&y.1[1])));
    figure::strip("The smallest relative error that is noticed on every significant entry", &all, place)
}

fn scores(report: &Report) -> Vec<ScoreRow> {
    let mut by_check: BTreeMap<(bool, Against), ScoreRow> = BTreeMap::new();
    for check in report.subjects.iter().flat_map(|subject| &subject.checks) {
        let key = (matches!(check.against, Against::Law(_)), check.against);
        let row = by_check.entry(key).or_insert_with(|| ScoreRow {
            name: check.against.name(),
            killed: Count(0),
            decisive: Count(0),
            survived: Count(0),
            equivalent: Count(0),
            below: Count(0),
            share: 0.0,
            percent: String::new(),
        });
        // What a law does not notice is no survivor.
        row.killed.0 += check.score.killed;
        row.decisive.0 += check.score.decisive();
        row.survived.0 += check.score.survived;
        row.equivalent.0 += check.score.equivalent;
        row.below.0 += check.score.below_resolution;
    }
    let mut rows: Vec<ScoreRow> = by_check.into_values().collect();
    for row in &mut rows {
        (row.share, row.percent) = share(row.killed.0, row.decisive.0);
    }
    rows.retain(|row| row.decisive.0 + row.equivalent.0 + row.below.0 > 0);
    rows
}

/// The part of mutants that was noticed, in percent: as a number, and in words.
fn share(killed: u64, decisive: u64) -> (f64, String) {
    if decisive == 0 {
        return (0.0, String::new());
    }
    let share = 100.0 * killed as f64 / decisive as f64;
    (share, format!("{share:.1} %"))
}

fn kinds(report: &Report) -> Vec<KindRow> {
    let row = |(cause, OfKind { by_oracles, by_laws }): (Cause, OfKind)| {
        let (share, percent) = share(by_oracles.killed, by_oracles.decisive());
        KindRow {
            name: cause.meaning(),
            code: cause.code().as_str(),
            killed: Count(by_oracles.killed),
            decisive: Count(by_oracles.decisive()),
            survived: Count(by_oracles.survived),
            equivalent: Count(by_oracles.equivalent),
            below: Count(by_oracles.below_resolution),
            by_laws: Count(by_laws),
            share,
            percent,
        }
    };
    summary::by_mistake(report).into_iter().map(row).collect()
}

/// Numbers without a witness, those that no state exercises, and laws that were not asked, with the connectors: once for each list.
fn left_out(report: &Report) -> Vec<String> {
    let of = |(text, subjects): (String, Vec<&str>)| format!("{}: {text}.", subjects.join(", "));
    summary::left_out(report).into_iter().map(of).collect()
}

fn survivors(report: &Report) -> Vec<String> {
    let mut lines = Vec::new();
    for subject in &report.subjects {
        for check in &subject.checks {
            for (mistake, entry) in &check.score.survivors {
                lines.push(format!(
                    "{}, {}: {mistake} survived ({entry})",
                    full_name(subject),
                    check.against.name()
                ));
            }
        }
    }
    lines
}

fn environment(report: &Report, supplement: &Supplement<'_>) -> Vec<(&'static str, String)> {
    let settings = &report.settings;
    let mut lines = vec![("pintle", report.version.to_string())];
    if !supplement.command.is_empty() {
        lines.push(("command", supplement.command.clone()));
    }
    let here = Environment::here();
    lines.extend(here.commit.map(|commit| ("commit", commit.into_owned())));
    lines.extend([
        ("date", here.date),
        ("compiler", format!("{} for {}", here.rustc, here.target)),
        ("numbers", env!("PINTLE_NUMBERS").to_string()),
        ("system", here.system),
        ("processor", here.processor),
        ("threads", rayon::current_num_threads().to_string()),
        ("tolerance", format!("C·u·(conditioned scale) with C = {}, u = 2⁻⁵³", report.constant)),
        (
            "states per type",
            format!(
                "{} on doubles, {} near singular sets, {} on 237 bits",
                settings.states, settings.near_singular_states, settings.wide_states
            ),
        ),
        ("seed", settings.seed.clone()),
        ("signs", crate::report::SIGNS.to_string()),
    ]);
    lines
}

fn oracles(report: &Report) -> Vec<OracleRow> {
    let word = |shared: bool| if shared { "shared" } else { "own" };
    report
        .settings
        .oracles
        .iter()
        .map(|oracle| {
            let Shares { kinematics, elementary, mechanism } = oracle.shares();
            OracleRow {
                name: oracle.name(),
                meaning: oracle.meaning(),
                kinematics: word(kinematics),
                elementary: word(elementary),
                mechanism: word(mechanism),
                decides: if oracle.is_independent() { "yes" } else { "" },
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{capital, edge_name, sentence};
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn edges_are_short() {
        let edges = [0.0, 1e-6, 0.001, 0.5, FRAC_PI_2, PI, 1.0 - 1e-6, 1.0 + 1e-6, 1.0, 2.0, 1e4];
        let said = ["0", "1e-6", "0.001", "0.5", "π/2", "π", "1−1e-6", "1+1e-6", "1", "2", "1e4"];
        assert_eq!(edges.map(edge_name), said);
    }

    #[test]
    fn symbols_keep_their_case() {
        for (text, shown) in [
            ("μ = 0", "μ = 0."),
            ("e1 is taken along a", "e1 is taken along a."),
            ("ur1 follows from the others", "ur1 follows from the others."),
            ("δl follows", "δl follows."),
            ("∂ur1/∂θa1 is zero", "∂ur1/∂θa1 is zero."),
            ("exp(μ α) overflows", "exp(μ α) overflows."),
            ("nothing presses", "Nothing presses."),
            ("a term is left out", "A term is left out."),
            ("a coincides with b", "a coincides with b."),
            ("a and b coincide", "a and b coincide."),
            ("second-order, then", "Second-order, then."),
        ] {
            assert_eq!(sentence(text), shown);
        }
        assert_eq!(capital(""), "");
    }
}
