//! `pintle audit`.

mod budget;
mod page;

use super::eval::{Source, nothing, read, selected, source};
use super::tell::{complain, show_diagnostic};
use super::{ConditionOptions, Failure, Files, Sign, one_of, page_width};
pub(crate) use budget::Bar;
use budget::{say_budget, seconds};
use clap::{Args, ValueEnum};
use pintle_audit::model::{Level, Levels, audit_model};
use pintle_audit::{
    Budget, Found, Oracle, Planted, Quantity, Report, Settings, Target, audit_catalogue, audit_scenes,
    drawn_coverage,
};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::Request;
use pintle_model::evaluate::{Model, Plan};
use pintle_report::audit as report;
use pintle_scene::{Diagnostic, ForceFile, GALLERY, Scene, Severity, State};
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

const HELP: &str = "\
Without a scene, every type of the catalogue is tried at states drawn from its
regions, and every connector of the gallery at the states of its scene. With
scenes, every connector and MPC at the states that the scene gives (--at FILE
gives others); of a deck without states, at the initial state and states drawn
about it.

A type, connector or MPC passes where every number agrees with an independent
oracle within a tolerance that follows from the conditioning of the state, and
where mutants of the same numbers were noticed. Other verdicts: ill-conditioned
point, kink, singular point, undecided (no independent oracle), unstable
formula, wrong, invalid. docs/explanation/audit.md says how it judges, and what
it does not: forces under given motion, stops, locks and failure among them.

A large scene is judged by an even sample of its connectors and states, with one
connector of every type and behaviour, and the report says what share that is.
--budget 60s judges as large a share as fits into that time, or all: the models
come first. How long it takes is said before it begins.

Of each scene the model is looked at besides: rules, orientations, singular
points along the states, stops, frictions, duplicates; mobility, redundant
constraints and free motions of the whole assembly; which region of
configuration space the states exercised. Each finding has a code, which
pintle explain CODE explains, and is a note, a warning or an error; --deny,
--warn, --note and --allow say which: of a code, a group of codes, all notes or
warnings. The code outweighs its group, and that all. A level of what none
applies to, such as the cause of a wrong number, is refused. A rule that leaves nothing to evaluate (pintle explain CODE says which) stays an
error: no number of such a scene is audited, the report has all it breaks, and
the exit code is 6.

Examples:
  pintle audit
  pintle audit model.inp --deny warnings --allow assembly::redundant
  pintle audit model.inp --model-only
  pintle audit model.inp --at run.csv --counter-examples found
  pintle audit large.inp --at run.csv --budget 10m
  pintle audit model.inp --html audit.html --plots figures
  pintle audit --states 10000 --format junit";

/// How an audit is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum AuditFormat {
    /// Text for reading
    #[default]
    Human,
    /// One JSON document, schema pintle-audit/1
    Json,
    /// JUnit XML, for continuous integration
    Junit,
    /// Markdown, for a comment on a change
    Markdown,
    /// One self-contained page of HTML
    Html,
}

#[derive(Debug, Args)]
#[command(after_long_help = HELP)]
pub(crate) struct Audit {
    /// Decks (.inp), TOML or JSON scenes (.toml, .json) or gallery:NAME; without any, the catalogue and the gallery
    #[arg(id = "scene", value_name = "SCENE")]
    scenes: Vec<String>,
    /// States of the nodes of the scene (.csv, .json, or a printed .dat); without it, those of the scene, or states drawn about the initial one
    #[arg(long, value_name = "FILE")]
    at: Option<PathBuf>,
    /// Component forces of connectors at the states (.csv or .json), as for `pintle eval`: what presses on frictions
    #[arg(long, value_name = "FILE", requires = "scene")]
    forces: Option<PathBuf>,
    /// What a positive force of a constrained component means in the file of forces
    #[arg(long, value_enum, default_value_t, requires = "forces")]
    force_sign: Sign,
    #[command(flatten)]
    conditions: ConditionOptions,
    /// Only these connectors of the scenes, by element number or element set; MPCs are then left out
    #[arg(long, value_name = "NUMBER|SET", value_delimiter = ',', requires = "scene")]
    connector: Vec<String>,
    /// States per type for the oracles on doubles
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().states)]
    states: usize,
    /// States per type near its singular sets, besides
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().near_singular_states)]
    near_singular_states: usize,
    /// States per type, or per connector of a scene, for the oracles on 237 bits [default: 30; of a scene at most 3000 in all,
    /// and at least one of each connector]
    #[arg(long, value_name = "COUNT")]
    wide_states: Option<usize>,
    /// States per connector of a scene that gives none, drawn about its initial state
    #[arg(long, value_name = "COUNT", default_value_t = Settings::default().drawn_states)]
    drawn_states: usize,
    /// How long the audit may take, as 60s, 5m or 2h. It judges an even sample of connectors and states, and says what share.
    /// [default: all, or of a large scene a sample that does not depend on the machine]
    #[arg(long, value_name = "TIME", value_parser = seconds, requires = "scene")]
    budget: Option<f64>,
    /// What random states are drawn from
    #[arg(long, value_name = "WORD", default_value_t = Settings::default().seed)]
    seed: String,
    /// Only these oracles, separated by commas: wide-differences, wide-symbolic,
    /// wide-dual, taylor, nodal-dual, hyper-dual, nested-dual, symbolic, differences,
    /// jax (of the catalogue, at the states at which JAX computed the numbers)
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = oracle)]
    oracles: Vec<Oracle>,
    /// Write a counter-example for every mismatch into this folder, for `pintle replay`
    #[arg(long, value_name = "FOLDER")]
    counter_examples: Option<PathBuf>,
    /// Write the report as a self-contained page of HTML too
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) html: Option<PathBuf>,
    /// Write the figures of the page into this folder, as SVG files
    #[arg(long, value_name = "FOLDER")]
    pub(super) plots: Option<PathBuf>,
    /// Plant a fault, to see the audit fail
    #[arg(long, value_parser = one_of(Planted::ALL, Planted::name), hide = true)]
    plant: Option<Planted>,
    /// Findings of this code, of this group (model, assembly, coverage, rule …), all notes or all warnings, are errors: exit 1; after @,
    /// those of a file or line
    #[arg(long, value_name = "CODE[@FILE[:LINE]]", value_delimiter = ',')]
    deny: Vec<String>,
    /// … are warnings
    #[arg(long, value_name = "CODE[@FILE[:LINE]]", value_delimiter = ',')]
    warn: Vec<String>,
    /// … are notes
    #[arg(long, value_name = "CODE[@FILE[:LINE]]", value_delimiter = ',')]
    note: Vec<String>,
    /// … are not shown
    #[arg(long, value_name = "CODE[@FILE[:LINE]]", value_delimiter = ',')]
    allow: Vec<String>,
    /// Look at the models of the scenes only: findings, rank and mobility of the assembly, coverage; audit no numbers
    #[arg(long, requires = "scene", conflicts_with_all = ["oracles", "counter_examples", "connector", "temperature", "fields"])]
    model_only: bool,
    /// Exit with 3 where something is undecided
    #[arg(long)]
    strict: bool,
    /// How to write it
    #[arg(long, value_enum, default_value_t)]
    pub(super) format: AuditFormat,
    /// Show every check
    #[arg(short, long)]
    verbose: bool,
}

fn oracle(name: &str) -> Result<Oracle, String> {
    let names = || Oracle::ALL.map(Oracle::name).join(", ");
    let found = Oracle::ALL.into_iter().find(|oracle| oracle.name().eq_ignore_ascii_case(name));
    found.ok_or_else(|| format!("there is no oracle {name:?}; there are {}", names()))
}

/// Audits and writes the report.
pub(crate) fn run(arguments: &Audit, files: Files) -> Result<(), Failure> {
    files.check(&arguments.html)?;
    files.check_folder(arguments.plots.as_deref(), "svg")?;
    files.check_folder(arguments.counter_examples.as_deref(), "json")?;
    if arguments.at.is_some() && arguments.scenes.len() != 1 {
        return Err(Failure::Usage("--at gives the states of one scene: name one".into()));
    }
    if arguments.forces.is_some() && arguments.scenes.len() != 1 {
        return Err(Failure::Usage("--forces gives the forces of one scene: name one".into()));
    }
    let begun = Instant::now();
    let settings = settings(arguments);
    let levels = levels(arguments)?;
    let is_catalogue = arguments.scenes.is_empty();
    let sources = match arguments.scenes.as_slice() {
        [] => GALLERY.iter().map(Source::Gallery).collect(),
        names => names.iter().map(|name| source(name)).collect::<Result<Vec<_>, Failure>>()?,
    };
    let loaded = sources
        .iter()
        .map(|source| with_forces(*source, arguments, &levels))
        .collect::<Result<Vec<Loaded>, Failure>>()?;
    let selection = selected(&arguments.connector);
    let mut plans = Vec::new();
    for (source, Loaded { scene, model, .. }) in
        sources.iter().zip(&loaded).filter(|(_, loaded)| loaded.errors.is_empty())
    {
        let plan = Plan::compile(model, &selection, Request::nothing(0))
            .map_err(|error| Failure::Usage(error.to_string()))?;
        if plan.is_empty() {
            // Without a report they are told here.
            loaded.iter().flat_map(|loaded| &loaded.errors).for_each(show_diagnostic);
            source.warn(scene, &model.warnings, |warning| levels.of_diagnostic(warning));
            return Err(nothing(scene));
        }
        plans.push(plan);
    }
    let sound: Vec<&Loaded> = loaded.iter().filter(|loaded| loaded.errors.is_empty()).collect();
    let targets: Vec<Target<'_>> = sound
        .iter()
        .zip(&plans)
        .map(|(Loaded { name, model, states, .. }, plan)| Target { name, model, plan, states })
        .collect();
    let bar = Bar::new();
    let of_model = |loaded: &Loaded| {
        bar.say(&format!("looking at the model of {}", loaded.name));
        audit_model(&loaded.scene, &loaded.states, &levels)
    };
    let models = loaded.iter().map(of_model).collect();
    let models_took = begun.elapsed();
    let of_catalogue = is_catalogue.then(|| {
        bar.expect(TABLE.len());
        audit_catalogue(&settings, &|name| bar.advance(1, name))
    });
    let of_scenes =
        audit_scenes(&settings, if arguments.model_only { &[] } else { &targets }, &|at| bar.hear(at));
    bar.finish();
    if let Some(budget) = arguments.budget {
        say_budget(budget, models_took, begun.elapsed());
    }
    let mut report = match of_catalogue {
        Some(of_catalogue) => of_catalogue.joined(of_scenes),
        None => of_scenes,
    };
    report.models = models;
    if !arguments.model_only {
        let of_sound = report.models.iter_mut().zip(&loaded).filter(|(_, loaded)| loaded.errors.is_empty());
        for ((found, _), target) in of_sound.zip(&targets).filter(|(_, target)| target.states.is_empty()) {
            let share = report.sampled.iter().find(|share| share.scene == target.name);
            let judged = share.map_or(target.plan.connectors.as_slice(), |share| &share.judged);
            (found.coverage, found.drawn) = (drawn_coverage(&settings, target, judged), true);
        }
    }
    if let Some(folder) = &arguments.counter_examples {
        save(folder, &mut report, files)?;
    }
    let is_page = matches!(arguments.format, AuditFormat::Html);
    if is_page || arguments.html.is_some() || arguments.plots.is_some() {
        let scenes =
            loaded.iter().map(|Loaded { name, scene, model, .. }| report::Audited { name, scene, model });
        let scenes = scenes.collect();
        let supplement = page::supplement(&report, is_catalogue, &targets, scenes, arguments.model_only);
        page::write(arguments, &report, &supplement, files)?;
    }
    if !is_page {
        write(arguments.format, arguments.verbose, &report)?;
    }
    say_what_stays(&levels, &report);
    let refused = loaded.iter().filter(|loaded| !loaded.errors.is_empty()).map(|loaded| loaded.name.as_str());
    let refused: Vec<&str> = refused.collect();
    match verdict(&report) {
        Ok(()) | Err(Failure::Findings | Failure::Undecided | Failure::Nothing(_)) if !refused.is_empty() => {
            let message = format!(
                "{}: refused by rules, and not evaluated; the findings name them",
                refused.join(", ")
            );
            Err(Failure::Input(message))
        }
        other => other,
    }
}

/// Where a level was set in vain: what refuses a model stays an error.
fn say_what_stays(levels: &Levels, report: &Report) {
    let findings = report.models.iter().flat_map(|model| &model.findings);
    let codes: BTreeSet<&str> = findings
        .filter(|finding| finding.severity() == Severity::Error && levels.is_lowered(finding))
        .map(|finding| finding.code().as_str())
        .collect();
    for code in codes {
        let why = "what breaks it cannot be evaluated";
        complain("note", &format!("{code} stays an error: {why} (pintle explain {code})"));
    }
}

/// A scene that is to be audited.
struct Loaded {
    name: String,
    scene: Scene,
    states: Vec<State>,
    /// Resolved as far as it goes.
    model: Model,
    /// The rules that refuse the model: then no number of it is audited.
    errors: Vec<Diagnostic>,
}

/// A scene with its states and their forces, which are checked. Every rule that it breaks is told.
fn with_forces(source: Source<'_>, arguments: &Audit, levels: &Levels) -> Result<Loaded, Failure> {
    let (scene, mut states) = read(source, arguments.at.as_deref())?;
    let (model, mut errors) = Model::examine(&scene);
    // Those that are taken for less are told by the findings.
    errors.retain(|error| !levels.lets_pass(error));
    // The report has them, and warnings.
    let (name, file) = match source {
        Source::File(path) => (path.to_string(), Path::new(path)),
        Source::Gallery(example) => (format!("gallery:{}", example.name), Path::new(example.name)),
    };
    let file = arguments.forces.as_deref().or(arguments.at.as_deref()).unwrap_or(file);
    let show = |error: Diagnostic| match File::open(file) {
        Ok(text) => error.with_source(BufReader::new(text)),
        Err(_) => error,
    };
    if let Some(forces) = &arguments.forces {
        let forces = ForceFile::read(forces, &scene, arguments.force_sign.into())?;
        forces.attach(&mut states, 0).map_err(show)?;
    }
    if errors.is_empty() {
        model.check_forces(&states, 0, &file.display().to_string()).map_err(show)?;
    }
    Ok(Loaded { name, scene, states, model, errors })
}

/// How bad the findings of each code are taken to be.
fn levels(arguments: &Audit) -> Result<Levels, Failure> {
    let Audit { allow, note, warn, deny, .. } = arguments;
    let mut levels = Levels::default();
    for (names, level) in
        [(allow, Level::Allow), (note, Level::Note), (warn, Level::Warn), (deny, Level::Deny)]
    {
        for name in names {
            levels.set(name, level).map_err(Failure::Usage)?;
        }
    }
    Ok(levels)
}

fn settings(arguments: &Audit) -> Settings {
    let mut settings = Settings {
        states: arguments.states,
        near_singular_states: arguments.near_singular_states,
        drawn_states: arguments.drawn_states,
        seed: arguments.seed.clone(),
        planted: arguments.plant,
        conditions: (&arguments.conditions).into(),
        strict: arguments.strict,
        ..Settings::default()
    };
    if let Some(wide_states) = arguments.wide_states {
        (settings.wide_states, settings.wide_states_of_a_scene) = (wide_states, usize::MAX);
    }
    if !arguments.oracles.is_empty() {
        settings.oracles = arguments.oracles.iter().copied().collect();
    }
    settings.budget = arguments.budget.map(Budget::from_now);
    settings
}

/// Writes the counter-examples of a report, shrunk to the simplest values that still fail.
fn save(folder: &Path, report: &mut Report, files: Files) -> Result<(), Failure> {
    files.folder(folder)?;
    for Found { at, name, example } in report.counter_examples() {
        let text = serde_json::to_string_pretty(&example).map_err(io::Error::from)?;
        let file = folder.join(name);
        files.text(&file, text + "\n")?;
        if let Some(check) = report.check_mut(at) {
            check.counter_example = Some(file.display().to_string());
        }
    }
    for (subject, kinds) in report.without_counter_example() {
        let kinds: Vec<&str> = kinds.into_iter().map(Quantity::name).collect();
        anstream::eprintln!(
            "note: no counter-example of {subject}: {}; these follow from more than a state: audit the scene again instead",
            kinds.join(", ")
        );
    }
    Ok(())
}

/// Writes a report.
pub(super) fn write(format: AuditFormat, verbose: bool, found: &Report) -> Result<(), Failure> {
    match format {
        AuditFormat::Human => {
            let mut out = BufWriter::new(anstream::stdout().lock());
            report::human(&mut out, found, page_width(&io::stdout()), verbose)?;
            Ok(out.flush()?)
        }
        AuditFormat::Json => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::json(&mut out, found)?;
            Ok(out.flush()?)
        }
        AuditFormat::Junit => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::junit(&mut out, found)?;
            Ok(out.flush()?)
        }
        AuditFormat::Html => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::html(&mut out, found, &report::Supplement::default())?;
            Ok(out.flush()?)
        }
        AuditFormat::Markdown => {
            let mut out = BufWriter::new(io::stdout().lock());
            report::markdown(&mut out, found)?;
            Ok(out.flush()?)
        }
    }
}

/// The exit code of a report. What is wrong comes before what would not have been noticed.
pub(super) fn verdict(report: &Report) -> Result<(), Failure> {
    if report.is_verified_wrong() {
        return Err(Failure::Mismatch);
    }
    if report.survivors() > 0 || report.contradictions() > 0 {
        return Err(Failure::SelfTest);
    }
    if let Some(planted) = report.settings.planted {
        let place = planted.place();
        if planted.is_of_a_witness() && report.settings.asks_for_everything() && report.unwitnessed() > 0 {
            return Err(Failure::Undecided);
        }
        if report.has_place_for_fault() {
            return Err(Failure::Unnoticed(place));
        }
        let message = format!("--plant plants its fault in {place}, and nothing that was audited has one");
        return Err(Failure::Usage(message));
    }
    if report.failing_models() > 0 {
        return Err(Failure::Findings);
    }
    let is_of_models_alone = report.subjects.is_empty() && !report.models.is_empty();
    if report.compared() == 0 && !is_of_models_alone {
        return Err(Failure::Nothing("no number was compared".into()));
    }
    if report.settings.strict && report.is_open() {
        return Err(Failure::Undecided);
    }
    Ok(())
}
