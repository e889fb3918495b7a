//! Reports of an audit: each shows what was found, and no text of the input becomes markup.

use crate::audit::spoiled;
use pintle_assembly::{Assembly, NotAssembled};
use pintle_audit::model::{Level, Levels, ModelReport, audit_model};
use pintle_audit::{
    Illustration, Planted, Quantity, Report, Settings, Target, Verdict, audit_catalogue, audit_scenes,
    illustrate_catalogue, illustrate_scene,
};
use pintle_kinematics::connector::Request;
use pintle_model::evaluate::{Model, Plan, Selection};
use pintle_report::audit as report;
use pintle_report::audit::{Audited, Supplement};
use pintle_scene::{GALLERY, Scene};
use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

/// A name that is markup in every form that a report has.
const HOSTILE: &str = "a|b <script>alert(1)</script> & *x* `y`";

/// A report with a wrong entry, on a connector with a hostile name.
pub(crate) fn wrong() -> Report {
    let mut report = spoiled("REVOLUTE", |_, rows| rows[3].as_mut().unwrap()[10] = 0.0);
    report.subjects[0].name = HOSTILE.to_string();
    report
}

/// A brief audit of the catalogue.
pub(crate) fn brief() -> Report {
    static FOUND: OnceLock<Report> = OnceLock::new();
    let settings = Settings { states: 10, near_singular_states: 4, wide_states: 1, ..Settings::default() };
    FOUND.get_or_init(|| audit_catalogue(&settings, &|_| {})).clone()
}

/// A report in one of its forms.
pub(crate) fn text(
    write: impl Fn(&mut dyn Write, &Report) -> std::io::Result<()>,
    report: &Report,
) -> String {
    let mut text = Vec::new();
    write(&mut text, report).unwrap();
    String::from_utf8(text).unwrap()
}

#[test]
fn markdown_names_what_is_wrong() {
    let page = text(report::markdown, &wrong());
    assert!(page.starts_with("## ❌ pintle audit: 1 mismatch\n"), "{page}");
    assert!(page.contains("∂ur1/∂θb1: 0, must be 1, "), "{page}");
    assert!(!page.contains("<script>") && page.contains("a\\|b &lt;script&gt;"), "{page}");
    // Every row of a table has as many cells as its heading.
    // The quantities of behaviour share a column.
    let wide = 9 + Quantity::ALL.len();
    let cells = |line: &str| line.replace("\\|", "").matches('|').count();
    let rows: Vec<usize> = page.lines().filter(|line| line.starts_with('|')).map(cells).collect();
    assert!(rows.iter().filter(|n| **n == wide).count() >= 3, "{rows:?}");
    assert!(rows.iter().all(|n| [8, wide].contains(n)), "{rows:?}");
}

#[test]
fn markdown_of_a_clean_audit() {
    let report = brief();
    let page = text(report::markdown, &report);
    // A page of the manual that could not be read is a note, and leaves nothing undecided.
    assert!(page.starts_with("## ✅ pintle audit: no mismatch\n"), "{page}");
    let unread = report.subjects.iter().filter(|one| one.is_page_unread()).count();
    let open = report.subjects.iter().filter(|one| one.declaration == Verdict::Undecided).count();
    assert_eq!((report.undecided(), unread), (0, open));
    assert!(unread > 2 && page.matches("| page unread |").count() == unread, "{page}");
    for subject in &report.subjects {
        assert!(page.contains(&format!("| {} | pass |", subject.name)), "{page}");
    }
    assert!(page.contains("<details>") && page.contains("</details>"));
}

/// A model of that deck in the folder of findings, with findings of a code denied.
fn model_of(name: &str, denied: Option<&str>) -> ModelReport {
    let deck = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("verify/findings").join(name);
    let scene = Scene::read(&deck).unwrap();
    let mut levels = Levels::default();
    if let Some(code) = denied {
        levels.set(code, Level::Deny).unwrap();
    }
    let mut model = audit_model(&scene, &[], &levels);
    model.scene = name.to_string();
    model
}

/// What is wrong, then models with errors, then what is undecided; models without findings are models.
#[test]
fn markdown_tells_errors_before_what_is_mild() {
    let mut report = wrong();
    report.subjects[0].checks.retain(|check| check.verdict.is_mismatch());
    report.subjects[0].checks.truncate(1);
    let check = &mut report.subjects[0].checks[0];
    // Rounding is that of the machine.
    let worst = check.worst.as_mut().unwrap();
    (worst.want, worst.tolerance, worst.units) = (0.5, 1e-15, 5e14);
    let mut mild = report.subjects[0].clone();
    mild.name = "undecided".to_string();
    let check = &mut mild.checks[0];
    (check.verdict, check.worst, check.diagnosis) = (Verdict::Undecided, None, None);
    check.undecided.insert("newton-not-converged: no solution".to_string(), 3);
    for claim in [&mut mild.derivative, &mut mild.formula] {
        *claim = Verdict::Undecided;
    }
    report.subjects.insert(0, mild);
    let clean = ModelReport { findings: Vec::new(), ..model_of("stop-violated.inp", None) };
    let clean = ModelReport { scene: "clean".to_string(), ..clean };
    report.models = vec![
        clean,
        model_of("stop-violated.inp", None),
        model_of("stop-violated.inp", Some("model::stop-violated")),
    ];
    let page = text(report::markdown, &report).replace(pintle::VERSION, "VERSION");
    let folder = env!("CARGO_MANIFEST_DIR");
    insta::assert_snapshot!(
        "markdown",
        page.replace(folder, "FOLDER").replace(&folder.replace('_', "\\_"), "FOLDER")
    );
    // Without room: a model without findings is no finding.
    let many = (0..900).map(|n| {
        let mut subject = report.subjects[1].clone();
        subject.name = format!("{} {n}", subject.name);
        subject.type_name.clone_from(&subject.name);
        subject
    });
    report.subjects.extend(many.collect::<Vec<_>>());
    report.models.truncate(1);
    let page = text(report::markdown, &report);
    assert!(page.contains("*1 model left out here") && !page.contains("finding left out"), "{page}");
}

/// Never longer than a comment may be; what is wrong comes first, and what is left out is counted.
#[test]
fn markdown_fits_into_a_comment() {
    let limit = report::MARKDOWN_LIMIT;
    let mut found = brief();
    let whole = text(report::markdown, &found);
    assert!(whole.chars().count() < limit && !whole.contains("left out"), "{}", whole.chars().count());
    let spoiled = wrong();
    for n in 0..900 {
        let mut subject = found.subjects[n % 31].clone();
        subject.name = format!("{} {n}", subject.name);
        subject.type_name.clone_from(&subject.name);
        found.subjects.push(subject);
    }
    found.subjects.extend(spoiled.subjects.clone());
    let page = text(report::markdown, &found);
    assert!(
        page.chars().count() <= limit && page.chars().count() > limit - 2_000,
        "{}",
        page.chars().count()
    );
    assert!(page.contains("∂ur1/∂θb1: 0, must be 1, "), "what is wrong");
    let first = page.find("\n| a\\|b").unwrap();
    assert!(first < page.find("\n| ALIGN |").unwrap_or(usize::MAX), "the wrong one is first");
    assert!(page.contains("subjects left out here") && page.ends_with('\n') && page.contains("</details>"));
    // As many wrong ones as no comment can hold.
    for n in 0..900 {
        let mut subject = spoiled.subjects[0].clone();
        subject.name = format!("{} {n}", subject.name);
        subject.type_name.clone_from(&subject.name);
        found.subjects.push(subject);
    }
    let page = text(report::markdown, &found);
    assert!(page.chars().count() <= limit, "{}", page.chars().count());
    assert!(page.contains("items left out here") && page.contains("subjects left out here"));
    assert!(page.contains("pintle ") && page.contains("oracles: wide-differences"));
}

/// Findings in models: one that is an error fails, others are told.
#[test]
fn junit_has_the_findings() {
    let deck = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("verify/findings/stop-violated.inp");
    let scene = Scene::read(&deck).unwrap();
    let of = |level: Option<Level>| {
        let mut levels = Levels::default();
        if let Some(level) = level {
            levels.set("model::stop-violated", level).unwrap();
        }
        let mut report = brief();
        report.models = vec![audit_model(&scene, &[], &levels)];
        text(report::junit, &report)
    };
    let warned = of(None);
    let case = "<testcase name=\"model::stop-violated at ";
    let has = |page: &str, what: &[&str]| {
        what.iter().for_each(|what| assert!(page.contains(what), "{what}: {page}"))
    };
    assert!(!warned.contains("<failure"), "{warned}");
    let told = "<system-out>warning[model::stop-violated]";
    has(&warned, &[case, "line=\"17\"", "classname=\"model::stop-violated\"", told, "help: move the stop"]);
    let denied = of(Some(Level::Deny));
    has(&denied, &[case, "<failure message=\"", "type=\"model::stop-violated\"", "failures=\"1\""]);
    assert!(!denied.contains(told), "{denied}");
    let allowed = of(Some(Level::Allow));
    assert!(
        !allowed.contains("model::stop-violated") && allowed.contains("stop-violated.inp\""),
        "{allowed}"
    );
}

/// Every test of JUnit says what it is of, those of laws, claims, singular points, ranks and findings too; none has a time, which would differ from run
/// to run.
#[test]
fn every_test_of_junit_has_a_class() {
    let deck = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("verify/findings/stop-violated.inp");
    let mut report = brief();
    report.models = vec![audit_model(&Scene::read(&deck).unwrap(), &[], &Levels::default())];
    let page = text(report::junit, &report);
    let tests: Vec<&str> = page.lines().filter(|line| line.contains("<testcase ")).collect();
    let of = |what: &str, class: &str| {
        let class = format!("classname=\"{class}");
        tests.iter().any(|line| line.contains(what) && line.contains(&class))
    };
    assert!(of("power identity", "REVOLUTE") && of("claim: formula", "REVOLUTE"), "{page}");
    assert!(of("AXIAL u1 at coincident nodes", "AXIAL") && of("δl at coincident nodes", "LINK"), "{page}");
    assert!(of("rank of the assembly", "model "), "{page}");
    for line in tests {
        assert!(line.contains(" classname=\"") && !line.contains(" time=\""), "{line}");
    }
}

/// An assembly of which no rank was found, or that was not judged from a state on, is as undecided as one whose rank is not certain.
#[test]
fn what_was_not_analysed_is_undecided() {
    let scene = GALLERY[0].scene().unwrap();
    let mut report = brief();
    report.models = vec![audit_model(&scene, &[], &Levels::default())];
    assert_eq!(report.undecided_models(), 0);
    let spoiled = |spoil: fn(&mut Assembly)| {
        let mut report = report.clone();
        spoil(report.models[0].assembly.as_mut().unwrap());
        report.undecided_models()
    };
    assert_eq!(spoiled(|assembly| assembly.positions.clear()), 1);
    assert_eq!(spoiled(|assembly| assembly.positions[0].decided = false), 1);
    let stopped = |assembly: &mut Assembly| {
        assembly.not_assembled = Some(NotAssembled { state: Some(3), why: "it was not".into() });
    };
    assert_eq!(spoiled(stopped), 1);
}

/// What is undecided and what is warned of, of models alone: the same in every form of the report.
#[test]
fn no_form_hides_what_is_undecided_or_warned_of() {
    let of = |name: &str, strict: bool| {
        let settings = Settings { strict, ..Settings::default() };
        let mut report = audit_scenes(&settings, &[], &|_| {});
        report.models = vec![model_of(name, None)];
        report
    };
    let json =
        |report: &Report| -> serde_json::Value { serde_json::from_str(&text(report::json, report)).unwrap() };
    let html =
        |report: &Report| text(|out, report| report::html(out, report, &Supplement::default()), report);
    let human = |report: &Report| text(|out, report| report::human(out, report, 100, false), report);
    let forms = |report: &Report, [mark, tone, headline]: [&str; 3]| {
        let page = text(report::markdown, report);
        assert!(page.starts_with(&format!("## {mark} pintle audit: {headline}\n")), "{page}");
        assert!(html(report).contains(&format!("<p class=\"outcome {tone}\">")), "{tone}");
        assert!(human(report).contains(headline), "{}", human(report));
    };
    let open = of("undecided.inp", false);
    let warnings = open.warnings();
    let headline = format!("models alone: no number audited; 1 model undecided; {warnings} warning");
    forms(&open, ["❔", "open", &headline]);
    assert_eq!(
        (json(&open)["undecided"].clone(), json(&open)["warnings"].clone()),
        (1.into(), warnings.into())
    );
    let row = format!("| 0 | 0 | 0 | 1 | {warnings} | 0 of 0 | 0 |");
    assert!(text(report::markdown, &open).contains(&row));
    let suite = text(report::junit, &open);
    assert!(suite.contains("rank of the assembly in step 1") && suite.contains("<skipped "), "{suite}");
    assert!(suite.contains("<skipped message=\"The rank is undecided"), "{suite}");
    // Asked to be strict, it fails.
    let strict = of("undecided.inp", true);
    forms(&strict, ["❌", "bad", &headline]);
    let suite = text(report::junit, &strict);
    assert!(suite.contains("failures=\"1\"") && !suite.contains("<skipped"), "{suite}");
    // A warning is no success without a word, and no failure.
    for strict in [false, true] {
        let warned = of("stop-violated.inp", strict);
        forms(&warned, ["⚠️", "warned", "models alone: no number audited; 1 warning"]);
        assert_eq!(json(&warned)["warnings"], 1);
        assert!(text(report::junit, &warned).contains("failures=\"0\""));
    }
    let noted = of("mechanism.inp", true);
    forms(&noted, ["✅", "good", "models alone: no number audited"]);
}

/// The page of a report on the catalogue and one scene of the gallery, with one verdict spoiled so that something is to be said.
fn page() -> (String, Report, Vec<(String, String)>, ModelReport) {
    let example = GALLERY.iter().find(|example| example.name == "slider_crank").unwrap();
    let scene = example.scene().unwrap();
    let model = Model::compile(&scene).unwrap();
    let states = example.states(&scene).unwrap().states;
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let target = Target { name: "gallery:slider_crank", model: &model, plan: &plan, states: &states };
    let settings = Settings { wide_states: 1, ..Settings::default() };
    let of_scene = audit_scenes(&settings, &[target], &|_| {});
    let mut illustrations = illustrate_catalogue(&of_scene);
    illustrations.extend(illustrate_scene(&target, &of_scene, 3));
    illustrations[0].subject = HOSTILE.to_string();
    illustrations[0].state = HOSTILE.to_string();
    let mut report = brief().joined(of_scene).joined(wrong());
    let crank = report.subjects.iter_mut().find(|subject| subject.name == "BEAM 104").unwrap();
    crank.derivative = Verdict::Wrong;
    let looked_at = audit_model(&scene, &states, &Levels::default());
    report.models.push(looked_at.clone());
    let supplement = Supplement {
        scenes: vec![Audited { name: target.name, scene: &scene, model: &model }],
        illustrations,
        command: format!("pintle audit {HOSTILE}"),
        ..Supplement::default()
    };
    let page = text(|out, report| report::html(out, report, &supplement), &report);
    let figures = report::figures(&report, &supplement);
    (page, report, figures, looked_at)
}

#[test]
fn the_page_is_self_contained_and_escapes_its_input() {
    let (page, report, figures, models) = page();
    // Nothing is loaded from anywhere: the only addresses are names of the SVG namespace.
    let addresses = page.matches("://").count();
    assert_eq!(addresses, page.matches("http://www.w3.org/2000/svg").count());
    for loading in ["src=", "@import", "url(", "<link rel=\"stylesheet\""] {
        assert!(!page.contains(loading), "{loading}");
    }
    assert!(!page.contains("<script>alert"));
    assert_eq!(page.matches("<script>").count(), 1);
    for section in [
        "problems",
        "model",
        "coverage",
        "scene",
        "verdicts",
        "jacobians",
        "steps",
        "singular",
        "self-test",
        "environment",
    ] {
        assert!(page.contains(&format!("<section id=\"{section}\">")), "{section}");
        assert!(page.contains(&format!("href=\"#{section}\"")), "{section}");
    }
    for subject in report.subjects.iter().filter(|subject| subject.name != HOSTILE) {
        assert!(page.contains(&subject.name), "{}", subject.name);
    }
    for finding in &models.findings {
        assert!(page.contains(&format!("<code>{}</code>", finding.code().as_str())), "{}", finding.message());
    }
    assert!(page.contains("<table class=\"map\">") && page.contains("rank of the constraints"));
    // The wrong entry, in words.
    assert!(page.contains("∂ur1/∂θb1: 0, must be 1, "), "the finding");
    // The spoiled connector is drawn as such, the others as what they are.
    assert!(page.contains("<g class=\"link v-wrong\"><title>BEAM 104: wrong</title>"));
    assert!(page.contains("<title>JOIN 103: pass</title>"));
    // One for each Jacobian shown, and that of what is wrong, once.
    let heat = pintle_kinematics::catalog::TABLE.len() + 3;
    assert_eq!(page.matches("class=\"heat\"").count(), heat + 1);
    // The same figures as files, each one a document of its own.
    let names: std::collections::BTreeSet<&String> = figures.iter().map(|(name, _)| name).collect();
    assert_eq!(names.len(), figures.len());
    // … with the smallest errors that are noticed, coverage, and the drawing.
    assert_eq!(figures.len(), 2 * heat + report.atlas.len() + 3);
    for (begins, key) in [
        ("jacobian-", ">✗ beyond</text>"),
        ("steps-", ">Taylor remainder / h, 237 bits</text>"),
        ("singular-", ">largest derivative</text>"),
        ("smallest-error-noticed", ">at the worst</text>"),
        ("coverage-slider-crank", "class=\"bin-m4\""),
        ("scene-gallery-slider-crank", "class=\"swatch\""),
    ] {
        let mut of = figures.iter().filter(|(name, _)| name.starts_with(begins)).peekable();
        assert!(of.peek().is_some(), "{begins}");
        of.for_each(|(name, svg)| {
            assert!(svg.contains(key) && svg.contains("<text class=\"label\""), "{name}")
        });
    }
    for (name, svg) in &figures {
        assert!(
            name.ends_with(".svg") && svg.starts_with("<svg xmlns=") && svg.contains("<style>"),
            "{name}"
        );
        assert!(!svg.contains("var(--ink)") && !svg.contains("<script"), "{name}");
    }
}

/// A wrong matrix has its wrong entries marked in the heat map.
#[test]
fn a_wrong_matrix_shows() {
    let mut shown: Vec<Illustration> = illustrate_catalogue(&wrong());
    let (_, row) = shown[5].comparison.rows.first_mut().unwrap();
    (row[0].got, row[0].units) = (7.0, 1e12);
    let supplement = Supplement { illustrations: shown, ..Supplement::default() };
    let page = text(|out, report| report::html(out, report, &supplement), &wrong());
    // One in the gallery, one where the wrong matrix is explained.
    assert_eq!(page.matches("<rect class=\"bad\"").count(), 2);
    assert!(page.contains("= 7e0, must be"));
}

/// Chromium, if it is installed.
fn chromium() -> Option<PathBuf> {
    let folders = std::env::var_os("PATH").map(|path| std::env::split_paths(&path).collect::<Vec<_>>());
    let named = |name: &'static str| folders.iter().flatten().map(move |folder| folder.join(name));
    ["chromium", "chromium-browser", "google-chrome"].into_iter().flat_map(named).find(|path| path.is_file())
}

/// What a page is after its scripts have run in a window of that width, and what the console says.
fn browsed(chromium: &PathBuf, name: &str, page: &str, width: u32) -> (String, String) {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let path = folder.join(name);
    fs::write(&path, page).unwrap();
    let profile = folder.join(format!("{name}.profile"));
    let output = Command::new(chromium)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"])
        .arg(format!("--window-size={width},1000"))
        .args(["--enable-logging=stderr", "--log-level=0", "--virtual-time-budget=2000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("file://{}", path.display()))
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8_lossy(&output.stderr);
    let console: Vec<&str> = said.lines().filter(|line| line.contains("CONSOLE")).collect();
    (String::from_utf8(output.stdout).unwrap(), console.join("\n"))
}

/// Asks the page, in the browser, what can be seen of it, and uses its tools.
const PROBE: &str = r##"<script>
const seen = (what, width, height) => [...document.querySelectorAll(what)].filter(e => {
  const box = e.getBoundingClientRect(); return box.width > width && box.height > height; }).length;
const body = document.body.dataset;
body.plots = seen("svg.plot", 200, 100); body.heats = seen("svg.heat", 200, 20); body.scenes = seen("svg.scene", 600, 150);
body.mutants = seen("#mutants tbody tr", 300, 10); body.maps = seen("table.map", 300, 30); body.bins = seen("table.map td", 20, 15);
body.findings = seen("#model table tbody tr", 300, 15); body.facts = seen("#model .facts div", 40, 20);
body.tall = [...document.querySelectorAll("#model tbody tr")].filter(e => e.getBoundingClientRect().height > 300).length;
body.environment = seen("#environment tbody tr", 300, 10); body.problems = seen(".problem", 300, 40);
body.triads = seen(".scene line.triad", -1, 8); body.dots = seen(".scene .node circle", 3, 3);
body.names = seen(".scene text.label", 20, 5);
const boxes = [...document.querySelectorAll(".scene text.label, .scene text.minor")].map(e => e.getBoundingClientRect());
const apart = (a, b) => a.right <= b.left || b.right <= a.left || a.bottom <= b.top + 3 || b.bottom <= a.top + 3;
body.collisions = boxes.filter((a, i) => boxes.slice(0, i).some(b => !apart(a, b))).length;
const cut = e => { const box = e.getBoundingClientRect(), svg = e.closest("svg").getBoundingClientRect();
  return box.left < svg.left - 1 || box.right > svg.right + 1 || box.top < svg.top - 1 || box.bottom > svg.bottom + 1; };
body.cut = [...document.querySelectorAll("svg text")].filter(cut).length;
body.empty = [...document.querySelectorAll("section, figure, .card")].filter(e => e.getBoundingClientRect().height < 30).length;
const text = [...document.querySelectorAll(".plot .axis, .plot .level-name")];
const within = (a, b) => a.closest("svg") === b.closest("svg");
const clear = (a, b) => apart(a.getBoundingClientRect(), b.getBoundingClientRect());
body.levels = text.filter(a => a.classList.contains("level-name") && text.some(b => a !== b && within(a, b) && !clear(a, b))).length;
body.rows = seen("#verdict-table tbody tr", 300, 10); body.links = seen(".link.v-wrong", 20, 20);
const shown = [...document.querySelectorAll("header *, #problems *, #model *, #scene figcaption, #environment .wide:first-of-type *")];
body.beyond = shown.filter(e => !e.closest("svg") && e.getBoundingClientRect().right > innerWidth + 1).length;
body.overflow = document.documentElement.scrollWidth > innerWidth;
const heads = document.querySelectorAll("#verdict-table th");
const first = () => document.querySelector("#verdict-table tbody tr td").textContent;
heads[0].click(); body.up = first(); heads[0].click(); body.down = first();
const input = document.querySelector("[data-count=verdict-count]");
input.value = "cardan pass"; input.dispatchEvent(new Event("input")); body.filtered = seen("#verdict-table tbody tr", 300, 10);
const ink = () => getComputedStyle(document.querySelector("h2")).color;
const before = ink(); document.getElementById("theme").click(); body.themed = before !== ink();
</script></body>"##;

/// The page of a scene alone has the singular points of the types that it uses, how near it came to one, and every step that differs.
#[test]
fn a_page_of_a_scene_has_its_steps_and_approaches() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n4, 1, 2\n\
                *CONNECTOR SECTION, ELSET=C\nCARTESIAN, CARDAN\nO,\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
                *BOUNDARY\n1, 1, 6\n*STEP\n*STATIC\n*END STEP\n*STEP\n*STATIC\n*BOUNDARY\n2, 1, 3\n*END STEP\n";
    let states = r#"{"schema": "pintle-states/1", "states": [{"time": 0, "nodes": {"2": {"rotation": [0, 1.5, 0]}}}]}"#;
    let folder = crate::commands::cli::file("scene_page.inp", deck);
    let states = crate::commands::cli::file("scene_page.json", states);
    let page = format!("{folder}.html");
    let arguments = [
        "audit",
        &folder,
        "--at",
        &states,
        "--wide-states",
        "1",
        "--html",
        &page,
        "--plots",
        &format!("{folder}.plots"),
    ];
    crate::commands::cli::pintle(&arguments).assert().code(0);
    let page = fs::read_to_string(page).unwrap();
    let section =
        page.split("<section id=\"singular\">").nth(1).and_then(|rest| rest.split("</section>").next());
    let section = section.expect("singular points");
    assert!(
        section.contains("<svg") && section.contains("CARDAN ur1") || section.contains("CARDAN ur2"),
        "{section}"
    );
    assert!(section.contains("types that the scenes use"), "{section}");
    let came = section.matches("of element 4 is").count();
    assert_eq!(came, 1, "{section}");
    for step in ["<h4>Step 1</h4>", "<h4>Step 2</h4>"] {
        assert_eq!(page.matches(step).count(), 1, "{step}");
    }
    // Six degrees of freedom are held in step 1, nine in step 2.
    let held: Vec<&str> =
        page.split("<dt>held by boundary conditions</dt><dd>").skip(1).map(|rest| &rest[..1]).collect();
    assert_eq!(held, ["6", "9"]);
    let plots: Vec<String> = fs::read_dir(format!("{folder}.plots"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert!(plots.iter().any(|name| name.starts_with("singular-")), "{plots:?}");
}

/// What a rule refuses is named and drawn as far as its nodes are known; of models alone nothing is shown that was not looked at.
#[test]
fn a_page_shows_what_was_not_audited_as_that() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
                *CONNECTOR SECTION, ELSET=C\nHINGE\n";
    let refused = crate::commands::cli::file("refused_page.inp", deck);
    let page = format!("{refused}.html");
    crate::commands::cli::pintle(&["audit", &refused, "--html", &page]).assert().code(6);
    let text = fs::read_to_string(&page).unwrap();
    assert!(text.contains(&format!("pintle audit <span class=\"soft\">of {refused}</span>")), "{text}");
    assert!(
        text.contains("<title>element 7: error found, not audited</title>")
            && text.contains("error\">error found, not audited"),
        "{text}"
    );
    let arguments = [
        "audit",
        "gallery:revolute_mpc",
        "--model-only",
        "--html",
        &page,
        "--plots",
        &format!("{refused}.plots"),
    ];
    crate::commands::cli::pintle(&arguments).assert().code(0);
    let text = fs::read_to_string(&page).unwrap();
    for absent in ["id=\"jacobians\"", "id=\"steps\"", "id=\"verdicts\"", "id=\"self-test\""] {
        assert!(!text.contains(absent), "{absent}");
    }
    // The node of the angle, and the axis that leads there.
    let drawn = [
        "<title>MPC REVOLUTE 10-20-30: axis of node 30</title><line class=\"hinge\"",
        "<title>node 30</title>",
    ];
    let all = [
        drawn[0],
        drawn[1],
        "10-20-30: nothing found, not audited</title>",
        "unseen\">nothing found, not audited",
    ];
    all.iter().for_each(|part| assert!(text.contains(part), "{part}"));
}

/// The histograms of coverage that have samples.
fn models_maps(model: &ModelReport) -> usize {
    let of = &model.coverage;
    let all = [&of.rotation_a, &of.rotation_b, &of.relative_rotation, &of.stretch, &of.margin];
    all.iter().filter(|histogram| histogram.samples() > 0).count()
}

/// In a browser: nothing on the console, tables and pictures are there, tools work; and without scripts the rows are there too.
#[test]
fn a_browser_shows_the_page() {
    let Some(chromium) = chromium() else {
        assert!(
            std::env::var_os("CI").is_none_or(|set| set.is_empty()),
            "no chromium in PATH, and CI is set: a browser must look at the page (Debian: apt install chromium)"
        );
        // Not `println!`, which a test that passes keeps to itself.
        let message = "SKIPPED: no chromium in PATH, so no browser has looked at the page (Debian: apt install chromium)";
        writeln!(std::io::stderr(), "{message}").unwrap();
        return;
    };
    let (page, report, _, models) = page();
    let page = page.replace("</body>", PROBE);
    let (dom, console) = browsed(&chromium, "audit.html", &page, 1280);
    assert_eq!(console, "");
    let head: String = dom.chars().skip_while(|c| *c != '<').collect();
    let body = head.split("<body").nth(1).and_then(|rest| rest.split('>').next()).unwrap();
    let has = |name: &str, value: &str| {
        assert!(body.contains(&format!("data-{name}=\"{value}\"")), "{name} {value}: {body}");
    };
    let heats = pintle_kinematics::catalog::TABLE.len() + 3;
    // Steps for each Jacobian, one plot for each singular set, and that of the smallest errors noticed.
    has("plots", &(heats + report.atlas.len() + 1).to_string());
    has("heats", &(heats + 1).to_string());
    has("scenes", "1");
    has("links", "1");
    has("rows", &report.subjects.len().to_string());
    has("overflow", "false");
    has("collisions", "0");
    has("levels", "0");
    has("beyond", "0");
    has("cut", "0");
    has("empty", "0");
    has("findings", &models.findings.len().to_string());
    has("facts", "9");
    let number = |name: &str| -> usize {
        let value = body.split(&format!("data-{name}=\"")).nth(1).and_then(|rest| rest.split('"').next());
        value.unwrap().parse().unwrap()
    };
    assert_eq!(number("maps"), models_maps(&models));
    assert!(number("bins") > 5 * number("maps"), "{body}");
    for (name, least) in
        [("mutants", 15), ("environment", 15), ("problems", 1), ("triads", 9), ("dots", 3), ("names", 6)]
    {
        assert!(number(name) >= least, "{name}: {body}");
    }
    has("up", "ACCELEROMETER");
    has("down", "WELD");
    has("filtered", "1");
    has("themed", "true");
    assert!(!dom.contains("<html lang=\"en\" class=\"no-script\""));
    // On a telephone nothing is wider than the window, and findings are not columns of single words.
    let (dom, console) = browsed(&chromium, "narrow.html", &page, 400);
    assert_eq!(console, "");
    for narrow in ["data-overflow=\"false\"", "data-tall=\"0\""] {
        assert!(dom.contains(narrow), "{narrow}");
    }
    // … with the longest of paths too: nothing is cut, nothing must be moved sideways to be read.
    let path =
        format!("/home/somebody/projects/{}/final_version", "suspension_with_many_bushings_".repeat(3));
    let long =
        page.replace("slider_crank.inp", &format!("{path}.inp")).replace("gallery:slider_crank", &path);
    assert!(long.matches(&path).count() > 20);
    let (dom, _) = browsed(&chromium, "long.html", &long, 420);
    for narrow in ["data-overflow=\"false\"", "data-beyond=\"0\""] {
        assert!(
            dom.contains(narrow),
            "{narrow}: {}",
            dom.split("<body").nth(1).unwrap_or_default().split('>').next().unwrap_or_default()
        );
    }
    // The console would have spoken.
    let (_, console) = browsed(&chromium, "broken.html", &page.replace("\"use strict\"", "missing()"), 1280);
    assert!(console.contains("missing is not defined"), "{console}");
}

/// Constraints have their matrices on the page as connectors have, and with a fault planted both show what was judged.
#[test]
fn constraints_and_planted_faults_show() {
    let example = GALLERY.iter().find(|example| example.name == "revolute_mpc").unwrap();
    let scene = example.scene().unwrap();
    let model = Model::compile(&scene).unwrap();
    let states = example.states(&scene).unwrap().states;
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    for states in [&states[..], &[]] {
        let target = Target { name: "scene", model: &model, plan: &plan, states };
        let shown = |planted: Option<Planted>| {
            let mut report = brief().clone();
            report.settings.planted = planted;
            illustrate_scene(&target, &report, 48)
        };
        let (right, wrong) = (shown(None), shown(Some(Planted::WrongEntry)));
        assert_eq!(right.len(), model.connectors.len() + model.mpcs.len());
        for (right, wrong) in right.iter().zip(&wrong) {
            assert!(right.comparison.worst() <= 1.0, "{}", right.subject);
            assert!(wrong.comparison.worst() > 1e3, "{}", right.subject);
            assert_eq!(right.comparison.columns.len(), right.comparison.rows[0].1.len(), "{}", right.subject);
        }
        let of_constraints = right.iter().filter(|shown| shown.subject.starts_with("scene: MPC "));
        assert_eq!(of_constraints.count(), model.mpcs.len());
        let supplement = Supplement { illustrations: wrong, ..Supplement::default() };
        let page = text(|out, report| report::html(out, report, &supplement), &brief());
        assert!(
            page.contains("must be") && page.contains(">θS1</text>") && page.contains("<rect class=\"bad\"")
        );
    }
}
