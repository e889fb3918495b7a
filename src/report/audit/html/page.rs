//! The page: what stands in which section.

use crate::audit::groups::named;
use crate::audit::html::cards::{
    APPROACH, ApproachCard, ApproachCurve, Card, StepCard, approach_card, approaches, cards, confirmed,
    omitted, step_cards, strip,
};
use crate::audit::html::drawing::{Colour, Drawing, name_of};
use crate::audit::html::figure::{Medium, STYLE};
use crate::audit::html::found::{CoverageSection, ModelSection, coverage, model};
use crate::audit::html::problems::{ProblemGroup, problems};
use crate::audit::html::prose::{capital, full_name, grouped};
use crate::audit::html::self_test::{KindRow, ScoreRow, kinds, left_out, scores, survivors};
use crate::audit::html::{Supplement, drawing};
use crate::audit::summary;
use crate::audit::summary::{
    AuditOutcome, PAGE_UNREAD, SubjectRow, headline, sentence, symbols, unconfirmed,
};
use askama::Template;
use pintle_audit::oracles::oracle::Shares;
use pintle_audit::{Report, Subject, Verdict};
use pintle_bench::Environment;
use pintle_scene::Severity;
use std::collections::BTreeMap;
use std::io;

/// A verdict's class and words.
pub(super) struct Said(pub(super) String, pub(super) &'static str);

impl Said {
    pub(super) fn of(verdict: Verdict) -> Self {
        let verdict = verdict.headline();
        Self(name_of(verdict), verdict.name())
    }
}

struct Figure {
    svg: String,
    caption: String,
}

/// What a cell is sorted by, and what it shows.
pub(super) struct Sorted(pub(super) f64, pub(super) String);

struct VerdictRow {
    text: String,
    name: String,
    verdicts: [Said; 3],
    states: u64,
    independent: u64,
    worst: Vec<Sorted>,
    seen: Sorted,
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
    sentence: String,
    tone: &'static str,
    sign: &'static str,
    audited: String,
    facts: Vec<(&'static str, String)>,
    sections: Vec<(&'static str, &'static str)>,
    problems: Vec<ProblemGroup>,
    models: Vec<ModelSection>,
    coverage: Vec<CoverageSection>,
    drawings: Vec<Figure>,
    colour_key: Vec<(String, String)>,
    symbols: Vec<&'static str>,
    rows: Vec<VerdictRow>,
    undecided: Vec<String>,
    left_out: Vec<String>,
    cards: Vec<Card>,
    omitted: String,
    steps: Vec<StepCard>,
    approaches: Vec<ApproachCard>,
    approach_key: [ApproachCurve; 4],
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
        AuditOutcome::Failed => ("bad", "✗"),
        AuditOutcome::Undecided => ("open", "?"),
        AuditOutcome::Warned => ("warned", "!"),
        AuditOutcome::Clean => ("good", "✓"),
    };
    let drawn = supplement.scenes.iter().map(|scene| (scene.name, drawing(report, scene)));
    let drawn: Vec<(&str, Drawing)> = drawn.filter(|(_, drawing)| !drawing.is_empty()).collect();
    let colour_key = colour_key(report, &drawn);
    let drawings = drawn
        .iter()
        .map(|(name, drawing)| Figure {
            svg: drawing.svg(name, Medium::Page),
            caption: drawing.caption(name),
        })
        .collect();
    let mut page = PageTemplate {
        css: include_str!("templates/page.css"),
        figure_css: STYLE,
        js: include_str!("templates/page.js"),
        headline_capital: capital(&outcome),
        sentence: sentence(report),
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
        colour_key,
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
        approach_key: APPROACH,
        confirmed: confirmed(report, supplement),
        detectable: strip(report, Medium::Page),
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

/// What the colours of drawings mean: every verdict, where numbers were audited, and what was found of that of which none were, as far as it is drawn.
fn colour_key(report: &Report, drawn: &[(&str, Drawing)]) -> Vec<(String, String)> {
    let is_shown = |colour: &Colour| match colour {
        Colour::Verdict(_) => !report.subjects.is_empty(),
        colour => drawn.iter().any(|(_, drawing)| drawing.has(*colour)),
    };
    Colour::all().filter(is_shown).map(|colour| (colour.class(), colour.name())).collect()
}

/// The figures at the head: of the audit, or of the findings where no number was audited.
fn facts(report: &Report) -> Vec<(&'static str, String)> {
    if report.subjects.is_empty() && !report.models.is_empty() {
        let count =
            |severity| grouped(report.models.iter().map(|model| model.count(severity)).sum::<usize>() as u64);
        return vec![
            ("models", grouped(report.models.len() as u64)),
            ("errors", count(Severity::Error)),
            ("warnings", count(Severity::Warning)),
            ("notes", count(Severity::Note)),
            ("undecided", grouped(report.undecided_models() as u64)),
        ];
    }
    let test = summary::self_test(report);
    vec![
        ("connectors and types", grouped(report.subjects.len() as u64)),
        ("numbers compared", grouped(report.compared())),
        ("mismatches", grouped(report.mismatches() as u64)),
        ("undecided", grouped(report.undecided() as u64)),
        ("warnings", grouped(report.warnings() as u64)),
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

fn verdict_row(subject: &Subject) -> VerdictRow {
    let row = SubjectRow::of(subject);
    let name = full_name(subject);
    let mut verdicts = row.verdicts.map(Said::of);
    if row.is_page_unread {
        verdicts[2] = Said("unread".to_string(), PAGE_UNREAD);
    }
    let words = verdicts.each_ref().map(|said| said.1).join(" ");
    let worst = row.worst.map(|units| match units {
        Some(units) if units < 1000.0 => Sorted(units, format!("{units:.2}")),
        Some(units) => Sorted(units, format!("{units:.1e}")),
        None => Sorted(-1.0, "–".into()),
    });
    VerdictRow {
        text: format!("{name} {words}"),
        name,
        verdicts,
        states: row.states,
        independent: row.independent,
        worst: worst.into(),
        seen: row.seen.map_or_else(|| Sorted(2.0, "–".into()), |x| Sorted(x, format!("{x:.0e}"))),
    }
}

/// Declarations that nobody confirms in full, and why: a line for each reason.
fn undecided(report: &Report) -> Vec<String> {
    let mut reasons: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for subject in report.subjects.iter().filter(|subject| subject.declaration == Verdict::Undecided) {
        reasons.entry(unconfirmed(subject)).or_default().push(full_name(subject));
    }
    reasons.into_iter().map(|(why, names)| format!("{}: {why}", named(&names))).collect()
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
        ("numbers", pintle_bench::NUMBERS.to_string()),
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
        ("signs", crate::SIGNS.to_string()),
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
