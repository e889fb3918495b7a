//! `pintle audit` and `pintle replay` through the command line: every exit code, every format, counter-examples.

use crate::commands::cli::{pintle, stderr, stdout};
use pintle_scene::Code;
use serde_json::{Value, json};
use std::fs;
use std::path::PathBuf;

/// An audit that is done in a moment.
fn brief<'a>(more: &[&'a str]) -> Vec<&'a str> {
    [&["audit", "gallery:hinge_pendulum", "--wide-states", "1", "--connector", "102"], more].concat()
}

/// A folder of that name that does not exist yet.
pub(crate) fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    _ = fs::remove_dir_all(&path);
    path
}

#[test]
fn exit_codes_are_those_of_the_manual() {
    // 0: all that was selected passed. The pendulum turns thrice, past its stops: a warning.
    let page = stdout(&pintle(&brief(&[])).assert().code(0));
    assert!(page.contains("BEAM 102") && page.trim_end().ends_with("no mismatch; 1 warning"), "{page}");
    // 1: a number is wrong.
    let wrong = pintle(&brief(&["--plant", "wrong-entry"])).assert().code(1);
    assert!(stderr(&wrong).contains("verified to be wrong"), "{}", stderr(&wrong));
    // A mutant that undoes what is wrong is right: that it passes says nothing of the check, which has spoken.
    let reversed = pintle(&brief(&["--plant", "wrong-sign"])).assert().code(1);
    let page = stdout(&reversed);
    assert!(page.contains("\n1 mismatch; 1 warning") && !page.contains("survived:"), "{page}");
    // 2: usage.
    pintle(&["audit", "--oracles", "oracle-of-delphi"]).assert().code(2);
    pintle(&["audit", "gallery:no_such_scene"]).assert().code(2);
    pintle(&["audit", "--at", "states.csv"]).assert().code(2);
    // A HINGE's page could not be read in full: a note on the manual, which is no fault of the scene.
    let text = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=A\n0., 0., 1., 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n\
        101, 1, 2\n*CONNECTOR SECTION, ELSET=C\nHINGE\nA,\n";
    let deck = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("strict-hinge.inp");
    fs::write(&deck, text).unwrap();
    let hinge = ["audit", deck.to_str().unwrap(), "--wide-states", "3", "--strict"];
    let page = stdout(&pintle(&hinge).assert().code(0));
    assert!(page.contains("page unread") && page.contains("a note on the manual"), "{page}");
    assert!(page.trim_end().ends_with("no mismatch"), "{page}");
    // 3: undecided, where that is asked to be an error.
    // An oracle that shares the mechanism or the elementary functions is no witness.
    for oracle in ["nodal-dual", "nested-dual", "differences", "wide-dual"] {
        let found = pintle(&brief(&["--oracles", oracle, "--strict"])).assert().code(3);
        assert!(stdout(&found).contains("undecided"), "{oracle}: {}", stdout(&found));
    }
    // 4: nothing to check.
    let deck = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("nodes-only.inp");
    fs::write(&deck, "*NODE\n1, 0., 0., 0.\n").unwrap();
    pintle(&["audit", deck.to_str().unwrap()]).assert().code(4);
    // 5: what nobody compares cannot be noticed, and the self-test says so.
    let blind = pintle(&brief(&["--plant", "lost-answer"])).assert().code(5);
    assert!(stderr(&blind).contains("self-test failed"), "{}", stderr(&blind));
    assert!(stdout(&blind).contains("survived:"), "{}", stdout(&blind));
    // 5 too: one of two witnesses lies, and neither is believed.
    let liar = pintle(&brief(&["--plant", "wrong-answer"])).assert().code(5);
    assert!(
        stdout(&liar).contains("oracles contradict each other on first derivatives"),
        "{}",
        stdout(&liar)
    );
    // 1: a component is lost; 3: nobody judges one.
    let lost = pintle(&brief(&["--plant", "lost-component"])).assert().code(1);
    assert!(stdout(&lost).contains("is missing"), "{}", stdout(&lost));
    let page = stdout(&pintle(&brief(&["--plant", "lost-witness"])).assert().code(3));
    let told = "no independent oracle of those asked judged them: values of ";
    assert!(page.contains("undecided") && page.contains(told), "{page}");
    // 6: bad input.
    let missing = pintle(&["audit", "no/such.inp"]).assert().code(6);
    assert!(stderr(&missing).contains("no/such.inp"), "{}", stderr(&missing));
    let broken = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("broken.json");
    fs::write(&broken, "{}").unwrap();
    let refused = pintle(&["replay", broken.to_str().unwrap()]).assert().code(6);
    assert!(stderr(&refused).contains("no counter-example"), "{}", stderr(&refused));
}

/// What fails is written as values, small ones; it fails again where the fault is, and passes where it is not.
#[test]
fn counter_examples_are_written_and_replayed() {
    let folder = folder("counter-examples");
    let path = folder.to_str().unwrap();
    let found = pintle(&brief(&["--plant", "wrong-entry", "--counter-examples", path])).assert().code(1);
    let page = stdout(&found);
    assert!(page.contains("∂u1/∂x") && page.contains("wrong"), "{page}");
    // The diagram of the matrix marks the entry.
    assert!(page.contains("✗"), "{page}");
    let files: Vec<PathBuf> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert!(!files.is_empty());
    for file in &files {
        let file = file.to_str().unwrap();
        let text = fs::read_to_string(file).unwrap();
        let document: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(document["schema"], "pintle-counterexample/2");
        assert_eq!(document["version"], pintle::VERSION);
        let fails = pintle(&["replay", file, "--plant", "wrong-entry"]).assert().code(1);
        let page = stdout(&fails);
        assert!(page.contains("  given ") && page.contains("0x") && page.contains("must be"), "{page}");
        let passes = pintle(&["replay", file]).assert().code(0);
        assert!(stdout(&passes).trim_end().ends_with("no mismatch"), "{}", stdout(&passes));
    }
    for format in ["json", "junit"] {
        pintle(&["replay", files[0].to_str().unwrap(), "--format", format]).assert().code(0);
    }
}

/// A replay asks the oracles that found it, and no others.
#[test]
fn a_replay_asks_who_was_asked() {
    let folder = folder("counter-examples-by-one-oracle");
    let path = folder.to_str().unwrap();
    let one = ["--oracles", "wide-differences", "--plant", "wrong-entry", "--counter-examples", path];
    pintle(&brief(&one)).assert().code(1);
    let file = fs::read_dir(&folder).unwrap().next().unwrap().unwrap().path();
    let replay = ["replay", file.to_str().unwrap(), "--format", "json"];
    let again: Value = serde_json::from_str(&stdout(&pintle(&replay).assert().code(0))).unwrap();
    assert_eq!(again["settings"]["oracles"], serde_json::json!(["wide-differences"]));
}

/// Values that make no state are refused with their place: of them nothing can be said to be wrong.
#[test]
fn counter_examples_of_no_state_are_refused() {
    let folder = folder("counter-examples-of-no-state");
    let path = folder.to_str().unwrap();
    pintle(&brief(&["--plant", "wrong-entry", "--counter-examples", path])).assert().code(1);
    let file = fs::read_dir(&folder).unwrap().next().unwrap().unwrap().path();
    let whole: Value = serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let stretched = serde_json::json!([
        ["0x1p+1", "0x0p+0", "0x0p+0"],
        ["0x0p+0", "0x1p+0", "0x0p+0"],
        ["0x0p+0", "0x0p+0", "0x1p+0"]
    ]);
    let mirrored = serde_json::json!([
        ["0x1p+0", "0x0p+0", "0x0p+0"],
        ["0x0p+0", "0x1p+0", "0x0p+0"],
        ["0x0p+0", "0x0p+0", "-0x1p+0"]
    ]);
    let changes = [
        ("/values/length", "0x0p+0".into(), "length is 0"),
        ("/values/length", "nan".into(), "length has the value NaN"),
        ("/values/length", "inf".into(), "length has the value inf"),
        ("/values/length", "-0x1p+0".into(), "length is -1"),
        (
            "/values/definition/connection",
            serde_json::json!(["AXIAL", "CARDAN", "CARDAN"]),
            "3 connection types, not 1 or 2",
        ),
        ("/values/definition/connection", serde_json::json!(["AXLE"]), "AXLE"),
        ("/values/definition/flow_scale", "nan".into(), "definition.flow_scale has the value NaN"),
        ("/values/definition/references/0", "inf".into(), "definition.references[0] has the value inf"),
        (
            "/values/definition/stops/0",
            serde_json::json!({"lower": "0x1p+1", "upper": "0x1p+0"}),
            "definition.stops[0] is 2 to 1",
        ),
        (
            "/values/definition/initial/b/triad",
            stretched.clone(),
            "definition.initial.b.triad is no right-handed rotation",
        ),
        (
            "/values/path/0/state/pair/a/triad",
            mirrored,
            "path[0].state.pair.a.triad is no right-handed rotation",
        ),
        (
            "/values/path/0/state/pair/a/triad",
            stretched,
            "path[0].state.pair.a.triad is no right-handed rotation",
        ),
        ("/values/path/0/state/pair/a/flow", "inf".into(), "path[0].state.pair.a.flow has the value inf"),
        ("/values/path", serde_json::json!([]), "path has no state"),
        ("/values/path/0/state/velocity", serde_json::json!([]), "they make no connector: invalid length 0"),
        ("/schema", "pintle-counterexample/1".into(), "schema \"pintle-counterexample/1\", not"),
        ("/values/path/0/state/velocity/3", "nan".into(), "path[0].state.velocity[3] has the value NaN"),
    ];
    for (place, value, told) in changes {
        let mut changed = whole.clone();
        *changed.pointer_mut(place).unwrap() = value;
        fs::write(&file, changed.to_string()).unwrap();
        let refused = pintle(&["replay", file.to_str().unwrap()]).assert().code(6);
        assert!(stderr(&refused).contains(told), "{place}: {}", stderr(&refused));
    }
}

/// Connectors of two scenes that have one name have files of their own, each with its own state, and none is overwritten.
#[test]
fn counter_examples_of_two_scenes_have_their_own_files() {
    let deck = |name: &str, x: f64| {
        let text = format!(
            "*NODE\n1, 0., 0., 0.\n2, {x:?}, 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
             *CONNECTOR SECTION, ELSET=C\nAXIAL\n"
        );
        crate::commands::cli::file(name, &text)
    };
    let decks = [deck("twin-a.inp", 1.0), deck("twin-b.inp", 3.0)];
    let folder = folder("counter-examples-of-twins");
    let brief = ["--wide-states", "1", "--drawn-states", "2", "--plant", "wrong-entry", "--counter-examples"];
    let arguments = [&["audit", &decks[0], &decks[1]], &brief[..], &[folder.to_str().unwrap()]].concat();
    let report = stdout(&pintle(&[&arguments[..], &["--format", "json"]].concat()).assert().code(1));
    let report: Value = serde_json::from_str(&report).unwrap();
    let wrong = |subject: &Value| {
        let checks = subject["checks"].as_array().unwrap().iter();
        checks
            .filter(|check| {
                ["wrong", "unstable-formula", "invalid"].contains(&check["verdict"].as_str().unwrap())
            })
            .count()
    };
    let failed: Vec<usize> = report["subjects"].as_array().unwrap().iter().map(wrong).collect();
    assert!(failed.len() == 2 && failed.iter().all(|n| *n > 0), "{failed:?}");
    let mut names: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names.len(), failed.iter().sum::<usize>(), "{names:?}");
    assert!(names.iter().all(|name| name.starts_with("axial-7-") && name.ends_with(".json")), "{names:?}");
}

/// A fault that can be planted nowhere is an error, and not a pass; where there is a place for it, it is seen.
#[test]
fn a_fault_that_is_planted_nowhere_is_an_error() {
    let nowhere = pintle(&brief(&["--plant", "wrong-friction"])).assert().code(2);
    let said = stderr(&nowhere);
    assert!(said.contains("a slope of a friction force, and nothing that was audited has one"), "{said}");
    let somewhere = ["audit", "gallery:slider_crank", "--wide-states", "1", "--plant", "wrong-friction"];
    pintle(&somewhere).assert().code(1);
    let symmetric = ["--oracles", "nodal-dual", "--plant", "lost-answer"];
    let nowhere = pintle(&brief(&symmetric)).assert().code(2);
    assert!(stderr(&nowhere).contains("an answer of an oracle on 237 bits"), "{}", stderr(&nowhere));
}

/// A fault can be planted in every kind of number; what is called wrong is that kind, or a law that speaks of it.
#[test]
fn faults_are_planted_in_every_kind_of_number() {
    let slide =
        ["audit", "gallery:slider_crank", "--connector", "106", "--wide-states", "4", "--format", "json"];
    for (plant, quantity) in [
        ("wrong-value", "value"),
        ("wrong-rate", "rate"),
        ("wrong-acceleration", "acceleration"),
        ("wrong-force", "nodal-forces"),
    ] {
        let found = pintle(&[&slide[..], &["--plant", plant]].concat()).assert().code(1);
        let report: Value = serde_json::from_str(&stdout(&found)).unwrap();
        let checks = report["subjects"][0]["checks"].as_array().unwrap();
        let is_wrong =
            |check: &&Value| ["wrong", "unstable-formula"].contains(&check["verdict"].as_str().unwrap());
        let kinds: Vec<&Value> = checks.iter().filter(is_wrong).map(|check| &check["quantity"]).collect();
        assert!(kinds.contains(&&json!(quantity)), "{plant}: {kinds:?}");
        assert!(kinds.iter().all(|kind| kind.is_null() || **kind == json!(quantity)), "{plant}: {kinds:?}");
    }
}

/// Constraints and behaviours are wrong too where a fault is planted, which is told why; all forces of a connector together follow from
/// more than a state, and that is said.
#[test]
fn what_has_no_counter_example_is_said() {
    let folder = folder("no-counter-examples");
    let path = folder.to_str().unwrap();
    let brief = ["--wide-states", "1", "--oracles", "wide-differences", "--plant", "wrong-entry"];
    let scenes = ["audit", "gallery:hinge_pendulum", "--counter-examples", path];
    let found = pintle(&[&scenes[..], &brief].concat()).assert().code(1);
    assert!(!stderr(&found).contains("no counter-example"), "{}", stderr(&found));
    assert!(
        folder.join("hinge-101-0.json").exists(),
        "{:?}",
        fs::read_dir(&folder).unwrap().collect::<Vec<_>>()
    );
    let page = stdout(&pintle(&[&["audit", "gallery:revolute_mpc"][..], &brief].concat()).assert().code(1));
    assert!(
        page.contains("∂δ3/∂xM3 equals (1 + 1e-6) × expected: entry scaled [diagnosis::scaled]"),
        "{page}"
    );
}

/// The copy in the repository, which the program prints.
#[cfg(feature = "schema")]
#[test]
fn the_schema_is_that_of_the_types() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/schema/pintle-audit-1.json");
    let types = format!("{:#}\n", pintle_report::audit::schema());
    if std::env::var_os("PINTLE_UPDATE").is_some() {
        fs::write(path, &types).unwrap();
    }
    let copy = fs::read_to_string(path).unwrap();
    assert!(copy == types, "{path} is not what the types give; run the test with PINTLE_UPDATE=1");
}

/// The JSON report obeys its schema, whatever it has to say.
#[test]
fn the_json_report_obeys_its_schema() {
    let schema: Value = serde_json::from_str(pintle_report::audit::SCHEMA_TEXT).unwrap();
    let printed: Value =
        serde_json::from_str(&stdout(&pintle(&["schema", "audit"]).assert().success())).unwrap();
    assert_eq!(printed, schema);
    let validator = jsonschema::validator_for(&schema).unwrap();
    let check = |document: &Value| {
        let errors: Vec<String> =
            validator.iter_errors(document).map(|e| format!("{}: {e}", e.instance_path())).collect();
        assert!(errors.is_empty(), "{errors:#?}");
    };
    for (arguments, code) in [
        (brief(&["--format", "json"]), 0),
        (brief(&["--format", "json", "--plant", "wrong-entry"]), 1),
        (brief(&["--format", "json", "--plant", "lost-answer"]), 5),
    ] {
        let report = stdout(&pintle(&arguments).assert().code(code));
        let document: Value = serde_json::from_str(&report).unwrap();
        check(&document);
        assert_eq!(document["schema"], "pintle-audit/1");
        let oracle = &document["oracles"][0];
        assert!(oracle["shares"]["kinematics"].is_boolean(), "{oracle}");
    }
    let mut text = Vec::new();
    pintle_report::audit::json(&mut text, &crate::commands::reports::brief()).unwrap();
    let mut document: Value = serde_json::from_slice(&text).unwrap();
    check(&document);
    assert!(!document["atlas"].as_array().unwrap().is_empty());
    // And it is a schema that can refuse.
    document["subjects"][0]["derivative"] = "fine".into();
    assert!(!validator.is_valid(&document));
}

/// JUnit: a suite for each connector, a failure where a number is wrong, an error where a mutant survives.
#[test]
fn junit_tells_failures_from_errors() {
    let of = |more: &[&str], code: i32| {
        stdout(&pintle(&brief(&[&["--format", "junit"], more].concat())).assert().code(code))
    };
    let fine = of(&[], 0);
    assert!(fine.contains("BEAM 102 of gallery:hinge_pendulum") && !fine.contains("<failure"), "{fine}");
    let wrong = of(&["--plant", "wrong-entry"], 1);
    assert!(wrong.contains("<failure") && wrong.contains("∂u1/∂x"), "{wrong}");
    let blind = of(&["--plant", "lost-answer"], 5);
    assert!(blind.contains("<error") && blind.contains("mutants survived"), "{blind}");
}

/// Progress goes to a terminal only, results to stdout: nothing is on stderr of a run that passes.
#[test]
fn results_and_progress_do_not_mix() {
    pintle(&brief(&[])).assert().code(0).stderr("");
}

/// A spring that depends on a field that is not given has no slope to judge: undecided, and not a pass of zeros. Given, it has one.
#[test]
fn slopes_of_what_is_not_given_are_undecided() {
    let verdict = |dependencies: &str, rows: &str, given: &[&str]| {
        let deck = folder(&format!("slopes{}", dependencies.len()));
        fs::create_dir_all(&deck).unwrap();
        let deck = deck.join("spring.inp");
        let text = format!(
            "*NODE\n1, 0., 0., 0.\n2, 2., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
             *CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nAXIAL,\n*CONNECTOR BEHAVIOR, NAME=B\n\
             *CONNECTOR ELASTICITY, COMPONENT=1{dependencies}\n{rows}\n"
        );
        fs::write(&deck, text).unwrap();
        let brief = ["--drawn-states", "2", "--wide-states", "1", "--format", "json"];
        let arguments = [&["audit", deck.to_str().unwrap()], &brief[..], given].concat();
        let found = pintle(&arguments).assert().code(0);
        let report: Value = serde_json::from_str(&stdout(&found)).unwrap();
        let checks = report["subjects"][0]["checks"].as_array().unwrap();
        let check = checks.iter().find(|check| check["quantity"] == "behavior-tangent").unwrap();
        let conditions = &report["settings"]["conditions"];
        (check["verdict"].as_str().unwrap().to_string(), conditions.clone())
    };
    let nothing = json!({ "temperature": null, "fields": [] });
    assert_eq!(verdict("", "100.", &[]), ("pass".into(), nothing.clone()));
    let rows = "100., , 20., 1.\n200., , 40., 2.";
    assert_eq!(verdict(", DEPENDENCIES=1", rows, &[]), ("undecided".into(), nothing));
    let (told, conditions) = verdict(", DEPENDENCIES=1", rows, &["--temperature", "30"]);
    assert_eq!((told.as_str(), &conditions["temperature"]), ("undecided", &json!(30.0)));
    let (told, conditions) = verdict(", DEPENDENCIES=1", rows, &["--temperature=30", "--fields=1.5"]);
    assert_eq!((told.as_str(), conditions), ("pass", json!({ "temperature": 30.0, "fields": [1.5] })));
    // Of no scene, and of a model alone, they say nothing.
    pintle(&["audit", "--fields", "1"]).assert().code(2);
    pintle(&["audit", "gallery:slider_crank", "--model-only", "--temperature", "20"]).assert().code(2);
}

/// A state on a singular set is a kink, not a mismatch, wherever it stands in a long history: differences on doubles have no step there.
#[test]
fn a_singular_state_in_a_long_history_is_a_kink() {
    let deck = crate::commands::cli::file(
        "axial-through-zero.inp",
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nAXIAL\n",
    );
    let mut lines = "state,node,u1,u2\n".to_string();
    for i in 0..40 {
        let [along, across] = if i == 3 { [-1.0, 0.0] } else { [0.1 + 0.01 * f64::from(i), 0.2] };
        lines += &format!("{i},2,{along:?},{across:?}\n");
    }
    let states = crate::commands::cli::file("axial-through-zero.csv", &lines);
    let found =
        pintle(&["audit", &deck, "--at", &states, "--wide-states", "5", "--format", "json"]).assert().code(0);
    let report: Value = serde_json::from_str(&stdout(&found)).unwrap();
    let checks = report["subjects"][0]["checks"].as_array().unwrap();
    let first = checks.iter().find(|check| {
        check["quantity"] == "first-derivatives" && check["against"]["oracle"] == "wide-differences"
    });
    assert_eq!(first.unwrap()["verdict"], "kink", "{first:?}");
    // JUnit tells all three claims.
    let page = stdout(
        &pintle(&["audit", &deck, "--at", &states, "--oracles", "nodal-dual", "--format", "junit"]).assert(),
    );
    for claim in ["derivative", "formula", "declaration"] {
        assert!(page.contains(&format!("claim: {claim}")), "{page}");
    }
}

/// Nodes at the end of the doubles overflow the constraint Jacobian: it is said, and the audit ends.
#[test]
fn an_assembly_that_overflows_ends() {
    let deck = crate::commands::cli::file(
        "overflow.inp",
        "*NODE\n1, 0., 0., 0.\n2, 1e200, 0., 0.\n3, -1.7e308, 0., 0.\n4, 1.7e308, 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n11, 1, 2\n12, 2, 3\n13, 3, 4\n14, 4, 1\n*CONNECTOR SECTION, ELSET=C\nBEAM\n",
    );
    let page = stdout(&pintle(&["audit", &deck, "--wide-states", "1", "--drawn-states", "1"]).assert());
    assert!(page.contains("assembly::"), "{page}");
}

/// A scene that rules refuse has its report all the same, with everything that it breaks, in every format; the numbers of other scenes
/// are audited. What is allowed or lowered in vain is told.
#[test]
fn a_refused_scene_has_a_report() {
    let folder = folder("refused");
    fs::create_dir_all(&folder).unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_string()
    };
    let refused = write(
        "refused.inp",
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 1., 0., 0.\n4, 2., 0., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=D\n2, 2, 3\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n4, 2, 3\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=F\n3, 3, 4\n*CONNECTOR SECTION, ELSET=D\nHINGE\n\
         *CONNECTOR SECTION, ELSET=E\nLINK\n*CONNECTOR SECTION, ELSET=F, BEHAVIOR=B\nAXIAL\n\
         *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=1\n2., 3.\n*BOUNDARY\n1, 1, 6\n",
    );
    let sound = write(
        "sound.inp",
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
         *CONNECTOR SECTION, ELSET=C\nBEAM\n*BOUNDARY\n1, 1, 6\n",
    );
    let page = folder.join("page.html");
    let page = page.to_str().unwrap();
    let more = ["--wide-states", "1", "--drawn-states", "1", "--html", page, "--allow", "rule", "--format"];
    let told = |format: &str| {
        let arguments = [&["audit", &sound, &refused][..], &more, &[format]].concat();
        let found = pintle(&arguments).assert().code(6);
        let said = stderr(&found);
        assert!(said.contains("refused.inp: refused by rules"), "{said}");
        assert!(said.contains("rule::orientation-required stays an error"), "{said}");
        stdout(&found)
    };
    for (format, words) in [
        (
            "human",
            [
                "BEAM 7",
                "error[rule::orientation-required]",
                "error[rule::coincident-nodes]",
                "element 3: u1 is 1",
            ],
        ),
        ("junit", ["BEAM 7", "rule::orientation-required", "rule::coincident-nodes", "model::stop-violated"]),
        ("markdown", ["BEAM 7", "rule::orientation-required", "rule::coincident-nodes", "stop-violated"]),
    ] {
        let text = told(format);
        for word in words {
            assert!(text.contains(word), "{format} lacks {word}:\n{text}");
        }
    }
    let document: Value = serde_json::from_str(&told("json")).unwrap();
    let codes = |scene: usize| -> Vec<String> {
        let findings = document["models"][scene]["findings"].as_array().unwrap();
        findings.iter().map(|finding| finding["code"].as_str().unwrap().to_string()).collect()
    };
    assert!(document["compared"].as_u64().unwrap() > 0);
    assert!(document["models"][1]["assembly"].is_null() && !document["models"][0]["assembly"].is_null());
    for code in ["rule::orientation-required", "rule::coincident-nodes", "model::stop-violated"] {
        assert!(codes(1).iter().any(|found| found == code), "{code}: {:?}", codes(1));
    }
    assert!(fs::read_to_string(page).unwrap().contains("rule::orientation-required"));
}

/// A rule after which every number is defined can be taken for less than an error, and the scene is then audited in full; others cannot. A level
/// can be set for a file and a line of it.
#[test]
fn severities_are_set_by_code_file_and_line() {
    let folder = folder("severities");
    fs::create_dir_all(&folder).unwrap();
    let deck = folder.join("two.inp");
    // ROTATION-ACCELEROMETER is of Explicit analyses alone; stops of both AXIALs are violated, in lines of their own.
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 2., 0., 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=D\n1, 1, 2\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n2, 2, 3\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=F\n3, 1, 3\n\
                *CONNECTOR SECTION, ELSET=D, BEHAVIOR=B\nAXIAL\n*CONNECTOR SECTION, ELSET=E, BEHAVIOR=C\nAXIAL\n\
                *CONNECTOR SECTION, ELSET=F\nROTATION-ACCELEROMETER\n*CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=1\n2., 3.\n\
                *CONNECTOR BEHAVIOR, NAME=C\n*CONNECTOR STOP, COMPONENT=1\n2., 3.\n\
                *BOUNDARY\n1, 1, 6\n*STEP\n*STATIC\n*END STEP\n";
    fs::write(&deck, text).unwrap();
    let deck = deck.to_str().unwrap();
    let audit = |more: &[&str], code: i32| {
        let brief = ["audit", deck, "--wide-states", "1", "--drawn-states", "1", "--format", "json"];
        let found = pintle(&[&brief[..], more].concat()).assert().code(code);
        let document: Value = serde_json::from_str(&stdout(&found)).unwrap();
        (document, stderr(&found))
    };
    let found = |document: &Value, code: &str| -> Vec<(String, u64)> {
        let findings = document["models"][0]["findings"].as_array().unwrap();
        let of = findings.iter().filter(|finding| finding["code"] == code);
        of.map(|one| (one["severity"].as_str().unwrap().to_string(), one["line"].as_u64().unwrap())).collect()
    };
    const RULE: &str = "rule::not-in-procedure";
    const STOP: &str = "model::stop-violated";
    let (refused, said) = audit(&[], 6);
    assert_eq!(refused["compared"], 0);
    assert_eq!(found(&refused, RULE)[0].0, "error");
    assert!(said.contains("refused by rules"), "{said}");
    let stops = found(&refused, STOP);
    assert_eq!(stops.len(), 2);
    // Taken for a warning, the rule is told, and all three connectors are audited.
    let (lowered, said) = audit(&["--warn", RULE], 0);
    assert_eq!(found(&lowered, RULE)[0].0, "warning");
    assert_eq!(lowered["subjects"].as_array().unwrap().len(), 3);
    assert!(lowered["compared"].as_u64().unwrap() > 0 && !lowered["models"][0]["assembly"].is_null());
    assert!(!said.contains(RULE) && !said.contains("refused"), "{said}");
    let (allowed, _) = audit(&["--allow", "rule"], 0);
    assert!(found(&allowed, RULE).is_empty());
    // A level is of a whole run: no file and no line is taken.
    let (denied, _) = audit(&["--allow", RULE, "--deny", STOP], 1);
    assert_eq!(found(&denied, STOP).iter().filter(|(severity, _)| severity == "error").count(), 2);
    for wrong in [format!("{STOP}@two.inp"), format!("{STOP}@two.inp:{}", stops[1].1)] {
        pintle(&["audit", deck, "--deny", &wrong]).assert().code(2);
    }
    // The same of every rule that leaves all numbers, of decks that break it.
    let lowered: Vec<Code> = Code::ALL.iter().copied().filter(|code| code.leaves_numbers()).collect();
    for (code, name) in lowered.iter().zip([
        "section-orientation-unused",
        "section-explicit-only",
        "section-data-too-long",
        "mpc-twice-on-one-node",
        "procedure-orientation-z-rectangular-in-explicit",
        "procedure-frequency-in-explicit",
        "procedure-unsymmetric-in-explicit",
    ]) {
        let deck = format!("{}/verify/faults/deck/{name}.inp", env!("CARGO_MANIFEST_DIR"));
        let levels = ["audit", &deck, "--wide-states", "1", "--drawn-states", "1", "--note", code.as_str()];
        let page = stdout(&pintle(&levels).assert().code(0));
        assert!(page.contains("no mismatch") && page.contains(&format!("note[{code}]")), "{name}: {page}");
    }
    // What can be done is explained.
    let explained = |code: &str| {
        let page = stdout(&pintle(&["explain", code]).assert().code(0));
        page.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert!(explained(RULE).contains("pintle audit goes on"), "{}", explained(RULE));
    assert!(explained("rule::orientation-required").contains("cannot be evaluated"));
    assert!(explained(STOP).contains("of this code or its group"));
}

/// The models alone: findings and the assembly, no numbers.
#[test]
fn models_alone_can_be_audited() {
    let scene = ["audit", "gallery:slider_crank", "--model-only"];
    let page = stdout(&pintle(&scene).assert().code(0));
    assert!(page.contains("degrees of freedom") && page.contains("models alone"), "{page}");
    assert!(!page.contains("subjects audited") && !page.contains("mutants"), "{page}");
    let page = stdout(&pintle(&[&scene[..], &["--format", "html"]].concat()).assert().code(0));
    for (section, is_there) in
        [("model", true), ("scene", true), ("singular", true), ("verdicts", false), ("self-test", false)]
    {
        assert_eq!(page.contains(&format!("<section id=\"{section}\">")), is_there, "{section}");
    }
    assert!(page.contains("<dt>warnings</dt>") && !page.contains("<dt>mutants noticed</dt>"));
    pintle(&[&scene[..], &["--strict"]].concat()).assert().code(0);
    pintle(&["audit", "--model-only"]).assert().code(2);
}

/// How near to a singular set a connector comes is told however far that is; and of several elements of a section, each one's own value.
#[test]
fn distances_and_values_are_told_of_each() {
    let folder = folder("each");
    fs::create_dir_all(&folder).unwrap();
    let deck = folder.join("each.inp");
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 3., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n1, 1, 2\n2, 1, 3\n\
                *ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nCARTESIAN, CARDAN\nO\n\
                *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR STOP, COMPONENT=1\n5., 9.\n*BOUNDARY\n1, 1, 6\n";
    fs::write(&deck, text).unwrap();
    let states = folder.join("each.csv");
    fs::write(&states, "state,node,u1,u2,u3,ur1,ur2,ur3\n1,2,0,0,0,0,0.5,0\n2,2,0,0,0,0,1.5,0\n").unwrap();
    let arguments = ["audit", deck.to_str().unwrap(), "--at", states.to_str().unwrap(), "--model-only"];
    let page = stdout(&pintle(&arguments).assert().code(0));
    assert!(
        page.contains(
            "nearest singular point: ur1 of element 1 is 0.0708 rad from β = ±π/2 (lock), at state 2"
        ),
        "{page}"
    );
    pintle(&[&arguments[..], &["--deny", "warnings"]].concat()).assert().code(1);
    let document = stdout(&pintle(&[&arguments[..], &["--format", "json"]].concat()).assert().code(0));
    let document: Value = serde_json::from_str(&document).unwrap();
    let model = &document["models"][0];
    assert_eq!(model["nearest"]["component"], "ur1");
    assert_eq!(model["nearest"]["state"], 2);
    let findings = model["findings"].as_array().unwrap();
    let stop = findings.iter().find(|finding| finding["code"] == "model::stop-violated").unwrap();
    assert_eq!(stop["about"]["elements"], serde_json::json!([1, 2]));
    let values: Vec<f64> = stop["about"]["values"]
        .as_array()
        .unwrap()
        .iter()
        .map(|value| value.as_f64().unwrap().abs())
        .collect();
    assert_eq!(values, [4.0, 2.0]);
}

/// Orientations that define no directions are findings, all of them, in every form; the other scenes of the call are audited, and the exit code
/// is 6 in the end.
#[test]
fn degenerate_orientations_are_findings() {
    let deck = crate::commands::cli::file(
        "degenerate.inp",
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=LINE\n1., 0., 0., 2., 0., 0.\n*ORIENTATION, NAME=UNUSED\n\
         0., 0., 0., 0., 1., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n1, 1, 2\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=D\n2, 1, 2\n3, 1, 2\n*CONNECTOR SECTION, ELSET=C\nBEAM\nLINE,\n*CONNECTOR SECTION, ELSET=D\n\
         HINGE\nO,\n",
    );
    let folder = folder("degenerate-orientations");
    fs::create_dir_all(&folder).unwrap();
    let page = folder.join("page.html");
    let arguments = [
        "audit",
        &deck,
        "gallery:hinge_pendulum",
        "--model-only",
        "--format",
        "json",
        "--html",
        page.to_str().unwrap(),
    ];
    let found = pintle(&arguments).assert().code(6);
    let document: Value = serde_json::from_str(&stdout(&found)).unwrap();
    let models = document["models"].as_array().unwrap();
    assert_eq!(models.len(), 2);
    let findings = models[0]["findings"].as_array().unwrap();
    let of = |code: &str| -> Vec<u64> {
        let found = findings.iter().filter(|finding| finding["code"] == code);
        found.map(|finding| finding["line"].as_u64().unwrap_or_default()).collect()
    };
    // One that no connector uses refuses nothing.
    assert_eq!(of("deck::degenerate-orientation"), [4], "{findings:#?}");
    // What can be found without the element that is refused is found.
    assert!(!of("rule::repeated-constraint").is_empty(), "{findings:#?}");
    for finding in findings.iter().filter(|finding| finding["code"] == "deck::degenerate-orientation") {
        assert!(
            finding["severity"] == "error" && finding["remedy"].as_str().unwrap().contains("move"),
            "{finding}"
        );
        assert!(finding["file"].as_str().unwrap().ends_with("degenerate.inp"), "{finding}");
    }
    assert!(stderr(&found).contains("degenerate.inp: refused by rules"), "{}", stderr(&found));
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("orientation LINE") || page.contains("Orientation LINE"));
    assert!(!page.contains("rientation UNUSED"));
    // Who evaluates it, or converts it, is told the first.
    for arguments in [["eval", &deck].to_vec(), ["convert", &deck, "--to", "toml"].to_vec()] {
        let refused = pintle(&arguments).assert().code(6);
        let said = stderr(&refused);
        assert!(said.contains("deck::degenerate-orientation") && said.contains("LINE"), "{said}");
    }
}
