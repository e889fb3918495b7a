//! The command line, by its output and exit codes.

use assert_cmd::Command;
use assert_cmd::assert::Assert;
use pintle_kinematics::catalog::{COMPONENT, TABLE};
use pintle_kinematics::connector::{Output, Request};
use pintle_kinematics::mpc;
use pintle_model::evaluate::{Model, Plan, Selection, Sequence};
use pintle_scene::{Code, Example, GALLERY, StateFile};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// The command with some arguments, and nothing in its environment that changes output.
pub(crate) fn pintle(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pintle"));
    for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE", "COLUMNS", "RUST_BACKTRACE"] {
        command.env_remove(name);
    }
    command.args(arguments);
    // What an earlier run of the tests has left is written over.
    if arguments.iter().any(|word| WRITES.contains(word)) {
        command.arg("--force");
    }
    command
}

/// Options that write files.
const WRITES: [&str; 8] = [
    "-o",
    "--html",
    "--plots",
    "--folder",
    "--jacobian",
    "--save-branches",
    "--save-states",
    "--counter-examples",
];

pub(crate) fn stdout(assert: &Assert) -> String {
    String::from_utf8(assert.get_output().stdout.clone()).unwrap()
}

pub(crate) fn stderr(assert: &Assert) -> String {
    String::from_utf8(assert.get_output().stderr.clone()).unwrap()
}

/// What a successful run prints; it must say nothing else.
fn output(arguments: &[&str]) -> String {
    stdout(&pintle(arguments).assert().success().stderr(""))
}

/// The gallery's pendulum turns on where its stop would hold it.
const BEYOND_STOP: &str = "HINGE 101: ur1 lies 0.5502 beyond its stop";

/// What a successful run prints that has something to note besides.
fn noted(arguments: &[&str], part: &str) -> String {
    let assert = pintle(arguments).assert().success();
    assert!(stderr(&assert).contains(part), "{}", stderr(&assert));
    stdout(&assert)
}

fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&output(arguments)).unwrap()
}

/// The same, where a note on stderr about values that need care is right.
fn json_with_care(arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(&pintle(arguments).assert().success())).unwrap()
}

/// A folder of a test.
pub(crate) fn folder(name: impl AsRef<Path>) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// A file for one test.
pub(crate) fn file(name: &str, text: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_string()
}

fn example(name: &str) -> &'static Example {
    GALLERY.iter().find(|example| example.name == name).unwrap()
}

/// Numbers below 1e-12, which are rounding and depend on the machine, as `~`; blanks in a row as one.
fn without_rounding(text: &str) -> String {
    fn word(word: &str) -> &str {
        let is_rounding = word.parse::<f64>().is_ok_and(|number| number != 0.0 && number.abs() < 1e-12);
        if is_rounding { "~" } else { word }
    }
    let line = |line: &str| line.split_whitespace().map(word).collect::<Vec<_>>().join(" ");
    text.lines().map(line).collect::<Vec<_>>().join("\n")
}

/// The components of a connector at a state of a JSON document.
fn at(document: &Value, scene: usize, state: u64, element: u64) -> Value {
    let states = document["scenes"][scene]["states"].as_array().unwrap();
    let state = states.iter().find(|found| found["index"] == state).unwrap();
    let connectors = state["connectors"].as_array().unwrap();
    connectors.iter().find(|found| found["element"] == element).unwrap()["components"].clone()
}

#[test]
fn list() {
    insta::assert_snapshot!("list", output(&["list"]));
    let document = json(&["list", "--format", "json"]);
    let names: Vec<&str> =
        document["types"].as_array().unwrap().iter().map(|entry| entry["name"].as_str().unwrap()).collect();
    assert_eq!(names, TABLE.iter().map(|entry| entry.name.as_ref()).collect::<Vec<_>>());
}

#[test]
fn explain() {
    for name in ["revolute", "Translator", "RETRACTOR", "rotation-accelerometer"] {
        insta::assert_snapshot!(name.to_lowercase(), output(&["explain", name]));
    }
    assert!(output(&["explain", "cardan", "Cartesian"]).starts_with("CARTESIAN + CARDAN\n"));
    assert!(output(&["explain", "JOIN", "REVOLUTE"]).starts_with("HINGE\n"));
    for (asked, said) in [
        (vec!["undecidd"], "did you mean undecided?"),
        (vec!["beem"], "did you mean BEAM?"),
        (vec!["no", "such", "word"], "nothing called \"no such word\"; it explains"),
        (vec!["JOIN", "REVOLUT"], "did you mean REVOLUTE?"),
    ] {
        let refused = pintle(&[&["explain"], asked.as_slice()].concat()).assert().code(2);
        let told = String::from_utf8_lossy(&refused.get_output().stderr).into_owned();
        assert!(told.contains(said), "{asked:?}: {told}");
    }
}

#[test]
fn the_mpcs_are_explained() {
    insta::assert_snapshot!("mpcs", output(&["explain", "MPC"]));
    for kind in mpc::MpcType::ALL {
        let page = output(&["explain", "MPC", kind.name()]);
        insta::assert_snapshot!(format!("mpc-{}", kind.name().to_lowercase()), page);
        assert_eq!(output(&["explain", &format!("mpc {}", kind.name().to_lowercase())]), page);
        let document = json(&["explain", "MPC", kind.name(), "--format", "json"]);
        for field in document["summary"].as_array().unwrap() {
            assert!(page.contains(field["name"].as_str().unwrap()), "{field}");
        }
        assert!(page.lines().all(|line| line.chars().count() <= 110), "{page}");
    }
    // What no connection type is called needs no MPC before it.
    assert!(output(&["explain", "tie"]).starts_with("MPC TIE\n"));
    assert!(output(&["explain", "link"]).starts_with("LINK\n"));
    let document = json(&["explain", "MPC", "--format", "json"]);
    assert_eq!(document["types"].as_array().unwrap().len(), mpc::TABLE.len());
    let document = json(&["explain", "MPC", "revolute", "--format", "json"]);
    assert_eq!(
        (&document["schema"], &document["name"]),
        (&"pintle-explain/1".into(), &"MPC REVOLUTE".into())
    );
    let names: Vec<&Value> =
        document["components"].as_array().unwrap().iter().map(|of| &of["names"]).collect();
    assert_eq!(
        format!("{names:?}"),
        r#"[Array [String("φJ")], Array [String("ρ1"), String("ρ2"), String("ρ3")]]"#
    );
}

#[test]
fn the_help_describes_states() {
    let help = output(&["eval", "--help"]);
    let from = |start: &str| &help[help.find(start).unwrap()..];
    let (table, document) =
        (from("  state,time,node").split("\n\n").next().unwrap(), from("  {\"schema\": \"pintle-states/1\""));
    let document = document.split("\n\n").next().unwrap();
    let scene = example("hinge_pendulum").scene().unwrap();
    let table: String = table.lines().map(|line| format!("{}\n", line.trim())).collect();
    let from_table = StateFile::parse_csv("help.csv", &table, &scene).unwrap();
    assert_eq!(from_table, StateFile::parse_json("help.json", document, &scene).unwrap());
    assert_eq!(from_table.states.len(), 2);
    let columns = "state time node u1 u2 u3 ur1 ur2 ur3 q0 q1 q2 q3 v1 v2 v3 vr1 vr2 vr3 a1 a2 a3 ar1 ar2 ar3 \
                   flow flow_v flow_a";
    let words: Vec<&str> = help.split_whitespace().collect();
    for column in columns.split_whitespace() {
        assert!(words.contains(&column), "{column}");
    }
    assert!(
        StateFile::parse_csv("all.csv", &format!("{}\n", columns.replace(' ', ",")), &scene)
            .is_err_and(|error| error.code() == Code::StatesEmpty)
    );
}

#[test]
fn every_type_is_explained_in_both_formats() {
    for entry in TABLE {
        let document = json(&["explain", &entry.name, "--format", "json"]);
        assert_eq!(document["name"], entry.name.as_ref());
        assert_eq!(document["signs"], pintle_report::SIGNS);
        let shown: Vec<&str> = document["components"]
            .as_array()
            .unwrap()
            .iter()
            .map(|component| component["name"].as_str().unwrap())
            .collect();
        let expected: Vec<&str> =
            (0..6).filter(|k| entry.slots[*k].position().is_some()).map(|k| COMPONENT[k]).collect();
        assert_eq!(shown, expected, "{}", entry.name);
        let page = output(&["explain", &entry.name]);
        for field in document["summary"].as_array().unwrap() {
            assert!(page.contains(field["name"].as_str().unwrap()), "{}: {field}", entry.name);
        }
        assert!(page.lines().all(|line| line.chars().count() <= 110), "{}", entry.name);
    }
}

#[test]
fn codes_are_explained() {
    for code in Code::ALL {
        let page = output(&["explain", code.as_str()]);
        assert!(page.starts_with(code.as_str()), "{page}");
    }
}

#[test]
fn gallery_overview() {
    insta::assert_snapshot!("gallery", without_rounding(&noted(&["eval", "--show", "middle"], BEYOND_STOP)));
    let page = stdout(&pintle(&["eval"]).assert().success());
    for example in GALLERY {
        assert!(page.contains(&format!("{}.inp\n", example.name)), "{page}");
    }
    assert!(page.contains("25 states (shown: 12, 24; --show all shows every one)"), "{page}");
}

#[test]
fn one_scene_with_jacobian() {
    let arguments = ["eval", "gallery:hinge_pendulum", "--show", "3", "--order", "1", "--connector", "pin"];
    let page = noted(&arguments, BEYOND_STOP);
    insta::assert_snapshot!("pin", page);
    let page = output(&["eval", "gallery:slider_crank", "--show", "6", "--order", "1"]);
    insta::assert_snapshot!("slider_crank", without_rounding(&page));
}

#[test]
fn second_derivatives_by_name() {
    let page =
        output(&["eval", "gallery:seat_belt", "--show", "last", "--order", "2", "--connector", "102,BELT"]);
    insta::assert_snapshot!("seat_belt", without_rounding(&page));
}

#[test]
fn details_on_request() {
    let page =
        output(&["eval", "gallery:slider_crank", "--show", "first", "--outputs", "TURNS,MARGIN", "-v"]);
    insta::assert_snapshot!("verbose", page);
}

/// Crank 0.2, rod 0.6: x = 0.2 cos θ + √(0.36 − 0.04 sin² θ) − 0.8.
#[test]
fn slider_crank_in_closed_form() {
    let document = json(&["eval", "gallery:slider_crank", "--outputs", "CU1", "--format", "json"]);
    for (state, degrees) in [(6, 90.0_f64), (12, 180.0), (18, 270.0)] {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let expected = 0.2 * cosine + (0.36 - 0.04 * sine * sine).sqrt() - 0.8;
        let found = at(&document, 0, state, 106)["u1"]["CU"].as_f64().unwrap();
        assert!((found - expected).abs() < 1e-15, "{degrees}: {found} {expected}");
    }
    let at_90 = at(&document, 0, 6, 106)["u1"]["CU"].as_f64().unwrap();
    let at_180 = at(&document, 0, 12, 106)["u1"]["CU"].as_f64().unwrap();
    assert!((at_90 + 0.23431).abs() < 5e-6 && (at_180 + 0.4).abs() < 1e-15, "{at_90} {at_180}");
}

#[test]
fn pendulum_at_the_bottom() {
    let deck = file("pendulum.inp", example("hinge_pendulum").deck);
    let states = file("bottom.csv", "node,u1,u2,ur3\n2,,,-1.5707963267948966\n3,-1,-1,-1.5707963267948966\n");
    let document =
        json(&["eval", &deck, "--states", &states, "--outputs", "CUR1,CSLST4", "--format", "json"]);
    let components = at(&document, 0, 0, 101);
    let found = components["ur1"]["CU"].as_f64().unwrap();
    assert!((found + std::f64::consts::FRAC_PI_2).abs() < 4.5e-16, "{found}");
    assert_eq!(components["ur1"]["CSLST"], 0);
    assert!(components.get("u1").is_none(), "{components}");
}

/// Psi at node 10 and the turn of the drum, 50 times that (keyword deck 5.3, frictionless).
#[test]
fn belt_is_drawn_from_the_drum() {
    let document = json(&[
        "eval",
        "gallery:seat_belt",
        "--show",
        "last",
        "--outputs",
        "CUR1,CU3,RES6",
        "--format",
        "json",
    ]);
    let flow = at(&document, 0, 10, 103)["u3"]["CU"].as_f64().unwrap();
    let drum = at(&document, 0, 10, 101)["ur1"]["CU"].as_f64().unwrap();
    assert!((flow - 0.07937).abs() < 5e-6, "{flow}");
    assert!((drum - 3.9685).abs() < 5e-5 && (drum - 50.0 * flow).abs() < 1e-14, "{drum}");
    let residual = at(&document, 0, 10, 102)["ur3"]["RES"].as_f64().unwrap();
    assert!(residual.abs() < 1e-14, "{residual}");
}

/// Every number of the document is the library's, bit by bit.
#[test]
fn json_is_exact() {
    for example in GALLERY {
        let scene = format!("gallery:{}", example.name);
        let document =
            json_with_care(&["eval", &scene, "--outputs", "ALL", "--order", "2", "--format", "json"]);
        assert_eq!(document["schema"], "pintle-eval/1");
        let scene = example.scene().unwrap();
        let states = example.states(&scene).unwrap().states;
        let model = Model::compile(&scene).unwrap();
        let plan = Plan::compile(&model, &Selection::All, Request::everything(2)).unwrap();
        let mut sequence = Sequence::new(&model, &plan);
        let found = document["scenes"][0]["states"].as_array().unwrap();
        assert_eq!(found.len(), states.len());
        let mut compared = 0;
        for (found, state) in found.iter().zip(&states) {
            let step = sequence.step(state);
            assert_eq!(found["index"], step.index);
            for (found, result) in found["connectors"].as_array().unwrap().iter().zip(&step.connectors) {
                let active = model.connectors[result.index].connector.active();
                let mut same = |found: &Value, expected: f64, what: &str| {
                    let found = found.as_f64().unwrap_or(f64::NAN);
                    assert_eq!(
                        found.to_bits(),
                        expected.to_bits(),
                        "{} {what}: {found} {expected}",
                        example.name
                    );
                    compared += 1;
                };
                for k in 0..6 {
                    let of = &found["components"][COMPONENT[k]];
                    let evaluation = &result.evaluation;
                    for (output, value) in [
                        (Output::CP, evaluation.position[k]),
                        (Output::CU, evaluation.displacement[k]),
                        (Output::CCU, evaluation.constitutive[k]),
                        (Output::CV, evaluation.velocity[k]),
                        (Output::CA, evaluation.acceleration[k]),
                        (Output::RES, evaluation.residual[k]),
                        (Output::RESV, evaluation.residual_rate[k]),
                        (Output::RESB, evaluation.residual_bias[k]),
                        (Output::RESA, evaluation.residual_acceleration[k]),
                    ] {
                        match value {
                            Some(value) => same(&of[output.name()], value, output.name()),
                            None => assert!(of.get(output.name()).is_none(), "{of}"),
                        }
                    }
                    if let Some(margin) = result.margins[k] {
                        same(&of["MARGIN"]["distance"], margin.distance, "MARGIN");
                    }
                    if let Some(turns) = evaluation.turns[k] {
                        same(&of["TURNS"]["turns"], turns.turns, "TURNS");
                        same(&of["TURNS"]["principal"], turns.principal, "TURNS");
                    }
                    let kept: Vec<usize> = (0..active.len()).filter(|j| active[*j]).collect();
                    let row = evaluation.jacobian[k].as_ref();
                    assert_eq!(row.is_some(), found["jacobian"]["rows"].get(COMPONENT[k]).is_some());
                    if let (Some(row), Some(hessian)) = (row, evaluation.hessian[k].as_ref()) {
                        for (i, j) in kept.iter().enumerate() {
                            same(&found["jacobian"]["rows"][COMPONENT[k]][i], row[*j], "gradient");
                            for (l, m) in kept.iter().enumerate() {
                                same(&found["hessian"][COMPONENT[k]][i][l], hessian[*j][*m], "Hessian");
                            }
                        }
                    }
                }
            }
            for (found, result) in found["mpcs"].as_array().unwrap().iter().zip(&step.mpcs) {
                let element = &model.mpcs[result.index];
                let kind = element.constraint.kind();
                assert_eq!(found["type"], kind.name());
                for (row, residual) in result.evaluation.residual.iter().enumerate() {
                    let of = &found["components"][kind.row_name(row)];
                    match residual {
                        Some(residual) => {
                            assert_eq!(of["RES"].as_f64().map(f64::to_bits), Some(residual.to_bits()))
                        }
                        None => assert!(of.is_null(), "{of}"),
                    }
                }
                for (name, angle) in kind.entry().angles.iter().zip(result.evaluation.angles) {
                    assert_eq!(found["components"][name]["TURNS"]["turns"], angle.turns);
                    assert!(found["hinges"][name]["axis"].is_array());
                }
            }
            assert_eq!(found["mpcs"].as_array().unwrap().len(), step.mpcs.len());
        }
        assert!(compared > 1000, "{compared}");
    }
}

/// The same numbers as JSON, one line each; derivatives that are zero left out.
#[test]
fn csv_is_exact() {
    let arguments = ["eval", "gallery:seat_belt", "--order", "2", "--format"];
    let document = json(&[&arguments[..], &["json"]].concat());
    let table = output(&[&arguments[..], &["csv"]].concat());
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let heading: Vec<String> = reader.headers().unwrap().iter().map(String::from).collect();
    let column = |name: &str| heading.iter().position(|known| known == name).unwrap();
    let (mut values, mut derivatives) = (0_usize, 0_usize);
    for line in reader.records() {
        let line = line.unwrap();
        let states = document["scenes"][0]["states"].as_array().unwrap();
        let state = &states[line[column("state")].parse::<usize>().unwrap()];
        let label: u64 = line[column("label")].parse().unwrap();
        let connector =
            state["connectors"].as_array().unwrap().iter().find(|found| found["element"] == label).unwrap();
        let component = &line[column("component")];
        if line[column("derivative")].is_empty() {
            for output in ["CP", "CU", "CV", "CA", "RES"] {
                let found = line[column(output)].parse::<f64>().ok().map(f64::to_bits);
                let expected = connector["components"][component][output].as_f64().map(f64::to_bits);
                assert_eq!(found, expected, "{line:?}");
                values += usize::from(found.is_some());
            }
            continue;
        }
        let dofs = connector["jacobian"]["dofs"].as_array().unwrap();
        let index = |dof: &str, node: &str| {
            let node: u64 = line[column(node)].parse().unwrap();
            dofs.iter().position(|known| known["name"] == line[column(dof)] && known["node"] == node).unwrap()
        };
        let first = index("dof_1", "node_1");
        let expected = if line[column("dof_2")].is_empty() {
            &connector["jacobian"]["rows"][component][first]
        } else {
            &connector["hessian"][component][first][index("dof_2", "node_2")]
        };
        let found: f64 = line[column("derivative")].parse().unwrap();
        assert_eq!(found.to_bits(), expected.as_f64().unwrap().to_bits(), "{line:?}");
        assert!(found != 0.0);
        derivatives += 1;
    }
    let states = document["scenes"][0]["states"].as_array().unwrap().len();
    assert!(values > 40 * states && derivatives > 100 * states, "{values} {derivatives}");
}

/// Only what is named: components per output, connectors, states.
#[test]
fn requests_are_masks() {
    let arguments = ["eval", "gallery:slider_crank", "--format", "json", "--outputs"];
    let document =
        json(&[&arguments[..], &["CU1,CPR3", "--connector", "SLIDE,101", "--show", "2,5-6"]].concat());
    let states = document["scenes"][0]["states"].as_array().unwrap();
    let indices: Vec<u64> = states.iter().map(|state| state["index"].as_u64().unwrap()).collect();
    assert_eq!(indices, [2, 5, 6]);
    for state in states {
        let elements: Vec<&Value> =
            state["connectors"].as_array().unwrap().iter().map(|connector| &connector["element"]).collect();
        assert_eq!(elements, [101, 106]);
    }
    let components = at(&document, 0, 5, 106);
    let shown: Vec<(&String, Vec<&String>)> = components
        .as_object()
        .unwrap()
        .iter()
        .map(|(name, of)| (name, of.as_object().unwrap().keys().filter(|key| key.starts_with('C')).collect()))
        .collect();
    assert_eq!(format!("{shown:?}"), r#"[("u1", ["CU"]), ("ur3", ["CP"])]"#);
    let work = &document["scenes"][0]["work"];
    // One position of 101 and u1 of 106 at three states: its friction is not followed, for nothing that depends on it is asked
    // for; ur3 winds and costs nothing more.
    assert_eq!(
        (&work["values"], &work["gradients"], &work["rates"]),
        (&6.into(), &0.into(), &0.into()),
        "{work}"
    );
}

/// A history cut in two and continued is the history, bit by bit.
#[test]
fn saved_branches_continue_exactly() {
    for example in GALLERY {
        let name = example.name;
        let deck = file(&format!("{name}.inp"), example.deck);
        let scene = example.scene().unwrap();
        let states = example.states(&scene).unwrap().states;
        let (first, second) = states.split_at(states.len() / 2 + 1);
        let part = |label: &str, states: &[pintle_scene::State]| {
            let text = StateFile { states: states.to_vec() }.to_json().unwrap();
            file(&format!("{name}.{label}.json"), &text)
        };
        // Quaternions hold no turns.
        let mut turnless = second.to_vec();
        for motion in turnless.iter_mut().flat_map(|state| state.nodes.values_mut()) {
            if let pintle_scene::Rotation::Vector(phi) = motion.rotation {
                motion.rotation =
                    pintle_scene::Rotation::Quaternion(pintle_kinematics::so3::exp_quaternion(phi));
            }
        }
        let turnless = part("turnless", &turnless);
        let (whole, first, second) = (part("whole", &states), part("first", first), part("second", second));
        let saved = file(&format!("{name}.branches"), "");
        let all = ["--outputs", "ALL", "--order", "1", "--format", "json"];
        let run = |more: &[&str]| json_with_care(&[&["eval", deck.as_str()], &all[..], more].concat());
        let uncut = run(&["--states", &whole]);
        let before = run(&["--states", &first, "--save-branches", &saved]);
        let after = run(&["--states", &second, "--resume", &saved]);
        let states = |document: &Value| document["scenes"][0]["states"].as_array().unwrap().clone();
        let joined = [states(&before), states(&after)].concat();
        assert_eq!(joined.len(), states(&uncut).len());
        for (joined, uncut) in joined.iter().zip(&states(&uncut)) {
            // Text, so that 0.0 and −0.0 differ.
            assert_eq!(joined.to_string(), uncut.to_string(), "{name}");
        }
        if name == "hinge_pendulum" {
            let angle = |more: &[&str]| {
                let document = run(&[&["--states", turnless.as_str()], more].concat());
                states(&document)[0]["connectors"][0]["components"]["ur1"]["CP"].as_f64().unwrap()
            };
            let turns = (angle(&["--resume", &saved]) - angle(&[])) / std::f64::consts::TAU;
            assert!(
                turns.round() != 0.0 && (turns - turns.round()).abs() < 1e-12,
                "turns must matter: {turns}"
            );
        }
    }
}

/// Friction of the slider under given constraint forces, for readers and programs, and where they are not given.
#[test]
fn friction_along_a_history() {
    let mut text = String::from("element,state,f1,f2,f3,m1,m2,m3\n");
    for state in 0..3 {
        text += &format!("106,{state},0,{state},4,0.5,0.3,0.4\n");
    }
    let forces = file("friction.csv", &text);
    let eval = |show: &str, format: &str| {
        let of = ["eval", "gallery:slider_crank", "--forces", &forces, "--connector", "106"];
        let what = ["--outputs", "CSF,CNF,CASU,CIVC", "--show", show, "--format", format];
        pintle(&[&of[..], &what[..]].concat()).assert().code(if show == "3" { 4 } else { 0 })
    };
    insta::assert_snapshot!("friction", without_rounding(&stdout(&eval("2", "human"))));
    let document: Value = serde_json::from_str(&stdout(&eval("2", "json"))).unwrap();
    let u1 = at(&document, 0, 2, 106)["u1"].clone();
    let number = |output: &str| u1[output].as_f64().unwrap_or_else(|| panic!("{output}: {u1}"));
    // 10 + 0.5/0.05 + √(2² + 4²) + 2·0.5/0.1
    let normal = 30.0 + 20.0_f64.sqrt();
    assert!((number("CNF") - normal).abs() < 1e-13, "{u1}");
    assert!((number("CSF").abs() - 0.1 * normal).abs() < 1e-13, "{u1}");
    assert!(number("CASU") > 0.0 && number("CIVC") > 0.0, "{u1}");
    let table = stdout(&eval("2", "csv"));
    for output in ["CSF", "CNF", "CASU", "CIVC"] {
        assert!(table.lines().next().unwrap().split(',').any(|name| name == output), "{table}");
        let shortest = serde_json::to_string(&u1[output]).unwrap();
        assert!(table.contains(&shortest), "{output} {shortest}: {table}");
    }
    let lacking = eval("3", "json");
    let document: Value = serde_json::from_str(&stdout(&lacking)).unwrap();
    let said = document.to_string();
    assert!(said.contains("not-known") && said.contains("what presses is the force"), "{said}");
}

/// Tables over temperature and field variables have what the command line gives; without it the force is said to be unknown.
#[test]
fn conditions_are_given() {
    let deck = file(
        "conditions.inp",
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n\
         *CONNECTOR SECTION, ELSET=E, BEHAVIOR=B\nCARTESIAN\n*CONNECTOR BEHAVIOR, NAME=B\n\
         *CONNECTOR ELASTICITY, COMPONENT=1, DEPENDENCIES=1\n5., , 20., 1.\n6., , 30., 1.\n15., , 20., 2.\n16., , 30., 2.\n",
    );
    let states = file("conditions.csv", "state,node,u1\n1,2,2.0\n");
    let ask = |given: &[&str]| {
        let arguments =
            [&["eval", &deck, "--states", &states, "--outputs", "CU1,CEF1", "--format", "csv"], given]
                .concat();
        stdout(&pintle(&arguments).assert().success())
    };
    let force = |text: &str| text.lines().nth(1).unwrap().rsplit(',').next().unwrap().to_string();
    assert_eq!(force(&ask(&["--temperature", "25", "--fields", "1.5"])), "21.0");
    assert_eq!(force(&ask(&["--temperature", "-5", "--fields", "1"])), "10.0");
    for lacking in [&[][..], &["--temperature", "25"], &["--fields", "1"]] {
        assert_eq!(force(&ask(lacking)), "", "{lacking:?}");
    }
    pintle(&["eval", &deck, "--temperature", "warm"]).assert().failure().code(2);
    pintle(&["eval", &deck, "--fields", "1,inf"]).assert().failure().code(2);
}

/// The forces of one connector, by CSV, JSON, and in a scene itself in TOML and JSON, give one document; the page and the table of it.
#[test]
fn forces_from_files_and_scenes() {
    let deck = "*HEADING\n a guide pressed and pushed\n*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nTRANSLATOR\nO,\n\
        *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1\n20.\n\
        *CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=1000.\n0.5, 2., 0.\n*FRICTION\n0.25\n";
    let scene = file("guide.inp", deck);
    let states = file("guide.states.csv", "state,time,node,u1\n0,0.5,2,0.25\n");
    let csv = file("guide.csv", "element,state,f1,f2,f3,m1,m2,m3\n7,0,7.,3.,4.,0.5,0.,6.\n");
    let json = file(
        "guide.json",
        "{\"schema\": \"pintle-forces/1\", \"states\": [{\"state\": 0, \"forces\": {\"7\": \
         {\"CTF1\": 7, \"CRF2\": 3, \"f3\": 4, \"CTM1\": 0.5, \"m2\": 0, \"CRM3\": 6}}}]}",
    );
    let outputs = "CSF,CNF,SLIP,CTF,NF,TANGENT,KT,KR";
    let run = |scene: &str, more: &[&str], format: &str| {
        let rest = ["--outputs", outputs, "--order", "0", "--show", "0", "--format", format];
        stdout(&pintle(&[&["eval", scene][..], more, &rest].concat()).assert().success())
    };
    let of_csv = ["--states", states.as_str(), "--forces", csv.as_str()];
    insta::assert_snapshot!(
        "forces",
        without_rounding(&run(&scene, &of_csv, "human").replace(&scene, "guide.inp"))
    );
    insta::assert_snapshot!("forces-csv", run(&scene, &of_csv, "csv").replace(&scene, "guide.inp"));
    let document = run(&scene, &of_csv, "json");
    let parsed: Value = serde_json::from_str(&document).unwrap();
    let block = &parsed["scenes"][0]["states"][0]["connectors"][0];
    insta::assert_snapshot!("forces-json", serde_json::to_string_pretty(block).unwrap());
    // F_N = 0.5/0.5 + 5 + 2·6/2 = 12; the spring takes 5 of the 7, friction 3, and the sum is told to be another one.
    assert_eq!(
        (&block["components"]["u1"]["CNF"], &block["components"]["u1"]["SLIP"]),
        (&12.0.into(), &"slip".into())
    );
    let of_json = ["--states", states.as_str(), "--forces", json.as_str()];
    assert_eq!(run(&scene, &of_json, "json"), document);
    // The same with states and forces in the scene.
    let written = |to: &str| stdout(&pintle(&["convert", &scene, "--to", to]).assert().success());
    let toml = format!(
        "{}\n[[states]]\nnumber = 0\ntime = 0.5\n\
         [states.nodes.2]\ndisplacement = [0.25, 0.0, 0.0]\n[states.forces.7]\nf1 = 7.0\nf2 = 3.0\nf3 = 4.0\nm1 = 0.5\nm2 = 0.0\nm3 = 6.0\n",
        written("toml")
    );
    let mut whole: Value = serde_json::from_str(&written("json")).unwrap();
    whole["states"] = serde_json::json!([
        {"number": 0, "time": 0.5, "nodes": {"2": {"displacement": [0.25, 0.0, 0.0]}},
         "forces": {"7": {"f1": 7.0, "f2": 3.0, "f3": 4.0, "m1": 0.5, "m2": 0.0, "m3": 6.0}}}
    ]);
    for (name, text) in [("guide.toml", toml), ("guide.scene.json", whole.to_string())] {
        let of_scene = file(name, &text);
        let found: Value = serde_json::from_str(&run(&of_scene, &[], "json")).unwrap();
        assert_eq!(&found["scenes"][0]["states"][0]["connectors"][0], block, "{name}");
    }
}

#[test]
fn usage_errors() {
    let several = folder("several-decks").to_str().unwrap().to_string();
    let none = folder("no-deck").to_str().unwrap().to_string();
    for name in ["a.inp", "b.inp"] {
        fs::write(Path::new(&several).join(name), "*NODE\n1, 0., 0., 0.\n").unwrap();
    }
    for (arguments, code, part) in [
        (&["explain", "revolut"][..], 2, "did you mean REVOLUTE?"),
        (&["explain", "nonsense"], 2, "pintle list"),
        (&["explain", "hinge", "join"], 2, "do not pair"),
        (&["eval", "gallery:slider"], 2, "slider_crank"),
        (&["eval", "gallery:slider_crank", "--outputs", "CU4"], 2, "CUR1 to CUR3"),
        (&["eval", "gallery:slider_crank", "--outputs", "CUE"], 2, "not evaluated yet"),
        (&["eval", "gallery:slider_crank", "--outputs", "CTF4"], 2, "CTM1 to CTM3 moments"),
        (
            &["eval", "gallery:slider_crank", "--connector", "102", "--outputs", "CTF"],
            4,
            "nothing was evaluated",
        ),
        (&["eval", "gallery:slider_crank", "--outputs", "MARGN"], 2, "did you mean MARGIN?"),
        (&["eval", "gallery:slider_crank", "--connector", "999"], 2, "999"),
        (&["eval", "gallery:slider_crank", "--show", "25"], 2, "there is no state 25: they are 0 to 24"),
        (&["eval", "gallery:slider_crank", "--show", "x"], 2, "is no state"),
        (&["eval", "gallery:slider_crank", "--order", "3"], 2, "3"),
        (&["eval", "--states", "states.csv"], 2, "<SCENE>"),
        (
            &["explain", "model::near-singlar"],
            2,
            "there is no code \"model::near-singlar\"; did you mean model::near-singular?",
        ),
        (&["explain", "model::x"], 2, "there is no code"),
        (&["audit", "--deny", "foo"], 2, "groups are deck, rule, model"),
        (
            &["audit", "--deny", "diagnosis::secant"],
            2,
            "names the cause of a wrong number, and a wrong number fails the audit whatever its cause; leave it out",
        ),
        (
            &["audit", "--allow", "states::order"],
            2,
            "correct the file in which it is (pintle explain states::order)",
        ),
        (&["eval", "--frobnicate"], 2, "--frobnicate"),
        (&["frobnicate"], 2, "frobnicate"),
        (&[], 2, "Usage"),
        (&["eval", "gallery:slider_crank", "--outputs", "NONE"], 4, "nothing was evaluated"),
        (
            &["eval", "gallery:slider_crank", "--connector", "101", "--outputs", "CSLST"],
            4,
            "nothing was evaluated",
        ),
        (&["explain", "MPC", "SLIDER"], 2, "PIN, REVOLUTE, TIE"),
        (&["explain", "MPC REVOLUTE", "TIE"], 2, "one type"),
        (&["eval", "-"], 2, "not read from standard input"),
        (&["eval", "no/such/deck.inp"], 6, "× no/such/deck.inp: cannot be opened: "),
        (&["eval", &several], 6, "name one of its decks: "),
        (&["eval", &none], 6, "name a deck (.inp); there is none in it"),
        (&["eval", "gallery:slider_crank", "--states", "no/such.csv"], 6, "× no/such.csv: cannot be read: "),
        (&["eval", "gallery:slider_crank", "--resume", "no/such.json"], 6, "no/such.json"),
    ] {
        let message = stderr(&pintle(arguments).assert().code(code));
        assert!(message.contains(part), "{arguments:?}: {message}");
    }
    for arguments in [&["--help"][..], &["--version"], &["eval", "--help"], &["help", "explain"]] {
        pintle(arguments).assert().success().stderr("");
    }
}

/// The commit that a release was built of, where its sources are in a repository.
#[test]
fn the_version_names_the_commit() {
    let short = stdout(&pintle(&["-V"]).assert().success());
    assert_eq!(short, format!("pintle {}\n", pintle::VERSION));
    let long = stdout(&pintle(&["--version"]).assert().success());
    assert!(long.starts_with(&format!("pintle {}\ncommit: ", pintle::VERSION)), "{long}");
    let commit =
        pintle_bench::COMMIT.unwrap_or("not known: a build for development, or outside its repository");
    assert!(long.contains(&format!("\ncommit: {commit}\n")), "{long}");
    // A build for development would be made anew after each commit.
    assert!(!cfg!(debug_assertions) || pintle_bench::COMMIT.is_none());
}

#[test]
fn bad_input_is_shown_where_it_is() {
    let deck = example("hinge_pendulum").deck;
    let run = |name: &str, text: &str, more: &[&str]| {
        let path = file(name, text);
        stderr(&pintle(&[&["eval", path.as_str()], more].concat()).assert().code(6).stdout(""))
    };
    let message = run("misspelt.inp", &deck.replace("HINGE\n", "HINGGE\n"), &[]);
    assert!(
        message.contains("rule::unknown-connection-type") && message.contains("write HINGE"),
        "{message}"
    );
    assert!(message.contains("misspelt.inp:") && message.contains("HINGGE"), "{message}");
    let message = run("bare.inp", &deck.replace("HINGE\nHAXIS,\n", "HINGE\n"), &[]);
    assert!(message.contains("rule::orientation-required") && message.contains("element 101"), "{message}");
    assert!(message.contains("*CONNECTOR SECTION"), "the source line is shown: {message}");
    let message = run("number.inp", &deck.replace("1, 0., 0., 0.\n", "1, 0., x, 0.\n"), &[]);
    assert!(message.contains("deck::malformed-number"), "{message}");
    let states = file("unknown.csv", "node,u1\n77,1\n");
    let message = run("states.inp", deck, &["--states", &states]);
    assert!(message.contains("states::unknown-node") && message.contains("77"), "{message}");
    let branches = file("none.json", "{}");
    let message = run("resume.inp", deck, &["--resume", &branches]);
    assert!(message.contains("--save-branches"), "{message}");
    let saved = file("pendulum.branches", "");
    pintle(&["eval", "gallery:hinge_pendulum", "--connector", "101", "--save-branches", &saved])
        .assert()
        .success();
    let message = run("other.inp", deck, &["--resume", &saved]);
    assert!(message.contains("connector 102") && message.contains("cannot be continued"), "{message}");
}

#[test]
fn warnings_do_not_stop() {
    let deck = example("hinge_pendulum").deck.replace("BEAM\n", "BEAM\n,\n1.,\n");
    let path = file("surplus.inp", &deck);
    let assert = pintle(&["eval", &path]).assert();
    let code = assert.get_output().status.code();
    let message = stderr(&assert);
    assert!(message.contains("rule::section-data-unused"), "{code:?} {message}");
}

#[test]
fn a_scene_without_connectors() {
    let path = file("nodes.inp", "*NODE\n1, 0., 0., 0.\n");
    let message = stderr(&pintle(&["eval", &path]).assert().code(4).stdout(""));
    assert!(message.contains("no connector element"), "{message}");
}

/// A CARDAN at its lock, and a belt without material.
const AT_THE_EDGE: &str = "\
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
*ORIENTATION, NAME=X
1., 0., 0., 0., 1., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=ANGLES
101, 1, 2
*ELEMENT, TYPE=CONN3D2, ELSET=BELT
102, 1, 2
*CONNECTOR SECTION, ELSET=ANGLES
CARDAN
X,
*CONNECTOR SECTION, ELSET=BELT
SLIPRING
";

#[test]
fn what_needs_care_is_said() {
    let deck = file("edge.inp", AT_THE_EDGE);
    let states = file(
        "edge.csv",
        "state,node,u1,ur1,ur2,flow\n0,2,,,1.5707963267948966,\n1,1,,,,-1\n2,2,,3.1,,\n3,1,-1e308,3.1,,\n3,2,1e308,3.1,,\n4,2,-1,,,\n5,2,,,1.57079632,\n",
    );
    let arguments = ["eval", &deck, "--states", &states, "--order", "1", "--format"];
    let assert = pintle(&[&arguments[..], &["json"]].concat()).assert().success();
    let message = stderr(&assert);
    assert!(message.contains("note: ") && message.contains("state 0, CARDAN 101"), "{message}");
    let document: Value = serde_json::from_str(&stdout(&assert)).unwrap();
    let flags = |state: usize, connector: usize| {
        let state = &document["scenes"][0]["states"][state];
        let flags = state["connectors"][connector]["flags"].as_array().unwrap().clone();
        flags.iter().map(|flag| format!("{} {}", flag["flag"], flag["component"])).collect::<Vec<_>>()
    };
    assert!(!flags(0, 0).is_empty(), "the lock");
    assert_eq!(flags(1, 1), [r#""singular" "u1""#]);
    assert!(flags(3, 1).contains(&r#""not-finite" "u1""#.to_string()), "{:?}", flags(3, 1));
    let belt = at(&document, 0, 3, 102);
    assert!(belt["u1"]["CP"].is_null() && belt["u2"]["CP"].is_number(), "{belt}");
    assert_eq!(flags(2, 0), [r#""large-increment" "ur1""#]);
    // Angles do not depend on where the nodes are, however far.
    assert_eq!(flags(3, 0), [r#""large-increment" "ur1""#]);
    assert_eq!(flags(4, 1), [r#""singular" "u1""#]);
    let page = stdout(&pintle(&[&arguments[..], &["human"]].concat()).assert().success());
    let words = page.split_whitespace().collect::<Vec<_>>().join(" ");
    for part in [
        "! ur1, ur3 are singular, at β = ±π/2 (lock): neither value nor derivatives are determined there",
        "from β = ±π/2 (lock): value and derivatives lose digits",
        "! ur1, ur3 are ill-conditioned, ",
        "! u1 is singular, at no material left, l0 + Ψa − Ψb ≤ 0",
        "! u1 is singular, at coincident nodes, d = 0",
        "! ur1 moved by 3.100000 rad since the previous state, more than 0.9 π: its turns are not certain",
        "! CP of u1 is not finite",
        "! derivative of u1 is not finite",
    ] {
        assert!(words.contains(part), "{part:?} in {page}");
    }
    let message =
        stderr(&pintle(&["eval", &deck, "--states", &states, "--show", "1", "--outputs", "CUR1"]).assert());
    assert!(message.contains("state 2, CARDAN 101: ur1 moved by 3.1"), "a state not shown: {message}");
    let table = stdout(&pintle(&[&arguments[..], &["csv"]].concat()).assert().success());
    assert!(table.contains("not-finite") && table.contains("large-increment"), "{table}");
}

#[test]
fn colours_only_for_terminals() {
    for arguments in [&["list"][..], &["explain", "HINGE"], &["eval", "gallery:seat_belt"]] {
        assert!(!output(arguments).contains('\x1b'));
        let forced = stdout(&pintle(arguments).env("CLICOLOR_FORCE", "1").assert().success());
        assert!(forced.contains("\x1b[1m"));
        let refused = stdout(&pintle(arguments).env("NO_COLOR", "1").assert().success());
        assert!(!refused.contains('\x1b'));
    }
    let refused = pintle(&["eval", "no/such.inp"]).env("NO_COLOR", "1").assert().code(6);
    assert!(!stderr(&refused).contains('\x1b'));
}

/// `pintle … | head`: no message, no failure.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_error() {
    for format in ["human", "json", "csv"] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_pintle"))
            .args(["eval", "--order", "2", "--show", "all", "--format", format])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let result = child.wait_with_output().unwrap();
        assert_eq!(String::from_utf8_lossy(&result.stderr), "", "{format}");
        assert_eq!(result.status.code(), Some(0), "{format}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error() {
    let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let result = std::process::Command::new(env!("CARGO_BIN_EXE_pintle"))
        .args(["eval", "gallery:seat_belt", "--format", "json"])
        .stdout(full)
        .output()
        .unwrap();
    assert_eq!(result.status.code(), Some(7));
    assert!(String::from_utf8_lossy(&result.stderr).contains("cannot write the results"));
}

#[test]
fn a_defect_says_so() {
    if cfg!(debug_assertions) {
        let message = stderr(&pintle(&["panic"]).assert().code(70).stdout(""));
        assert!(message.contains("internal error") && message.contains("a defect of pintle"), "{message}");
    }
}

/// The picture in the README is what the program prints.
#[test]
fn the_readme_shows_real_output() {
    let page = output(&["eval", "gallery:slider_crank", "--show", "6", "--connector", "SLIDE"]);
    assert!(include_str!("../../README.md").contains(page.trim_end()), "the README differs from:\n{page}");
}

/// Completions and manual pages come from the definition: unit tests beside it compare every command and option.
#[test]
fn completions_and_manual_pages() {
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let text = output(&["completions", shell]);
        for command in
            ["audit", "bench", "completions", "convert", "eval", "explain", "list", "man", "replay", "schema"]
        {
            assert!(text.contains(command), "{shell} {command}");
        }
    }
    let script = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("pintle.bash");
    fs::write(&script, output(&["completions", "bash"])).unwrap();
    Command::new("bash").arg("-n").arg(&script).assert().success().stderr("");
    assert!(output(&["man"]).contains("pintle\\-eval(1)"));
    assert!(output(&["man", "eval"]).contains("pintle eval"));
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("man");
    assert_eq!(output(&["man", "--folder", folder.to_str().unwrap()]), "");
    assert_eq!(fs::read_to_string(folder.join("pintle-audit.1")).unwrap(), output(&["man", "audit"]));
    let unknown = pintle(&["man", "evil"]).assert().code(2);
    assert!(stderr(&unknown).contains("there is no command evil"), "{}", stderr(&unknown));
}
