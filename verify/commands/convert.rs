//! `pintle convert` and `pintle schema`: what is written is evaluated to the same numbers, and what is lost is said.

use pintle_scene::GALLERY;
use serde_json::Value;
use std::fs;
use std::path::PathBuf;

fn pintle(arguments: &[&str]) -> std::process::Output {
    crate::commands::cli::pintle(arguments).output().unwrap()
}

fn run(arguments: &[&str]) -> String {
    let output = pintle(arguments);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

fn path(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("convert_{name}"));
    path.to_str().unwrap().to_owned()
}

fn file(name: &str, text: &str) -> String {
    let path = path(name);
    fs::write(&path, text).unwrap();
    path
}

/// The rows without the column of the scene's name.
fn numbers(csv: &str) -> Vec<&str> {
    csv.lines().map(|row| row.split_once(',').unwrap().1).collect()
}

/// Decks lose the states, which `--save-states` keeps; with them they too give the same numbers.
#[test]
fn converted_scenes_evaluate_to_the_same_numbers() {
    for example in GALLERY {
        let gallery = format!("gallery:{}", example.name);
        let evaluate = ["--format", "csv", "--order", "2"];
        let original = run(&[["eval", &gallery].as_slice(), &evaluate].concat());
        let states = path(&format!("{}.states.json", example.name));
        for form in ["toml", "json", "inp"] {
            let name = path(&format!("{}.{form}", example.name));
            run(&["convert", &gallery, "-o", &name, "--save-states", &states]);
            let mut arguments = [["eval", &name].as_slice(), &evaluate].concat();
            if form == "inp" {
                arguments.extend(["--states", &states]);
            }
            assert_eq!(numbers(&run(&arguments)), numbers(&original), "{name}");
        }
        let toml = path(&format!("{}.toml", example.name));
        let others = run(&["eval", &toml, "--states", &states, "--format", "csv", "--order", "2"]);
        assert_eq!(numbers(&others), numbers(&original));
    }
}

/// What is saved as JSON is not given another ending, by which it would be read; what `--strict` forbids leaves no file.
#[test]
fn states_are_saved_where_they_can_be_read() {
    let [deck, csv, kept] = ["saved.inp", "saved.csv", "kept.json"].map(path);
    let refused = |arguments: &[&str], code: i32, why: &str| {
        let output = pintle(arguments);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{error}");
        assert!(error.contains(why), "{error}");
    };
    let from = "gallery:slider_crank";
    refused(&["convert", from, "-o", &deck, "--save-states", &csv], 2, "end its name in .json");
    refused(&["convert", from, "-o", &deck, "--save-states", &kept, "--strict"], 1, "nothing was written");
    for file in [deck, csv, kept] {
        assert!(!std::path::Path::new(&file).exists(), "{file}");
    }
}

const LOSSY: &str = "\
*HEADING
 a deck with more than a scene holds
** a comment
*NODE
1, 0., 0., 0.
2, 1., 0., 0.
*MATERIAL, NAME=STEEL
*ELASTIC
2.1E11, 0.3
*ELEMENT, TYPE=C3D4
1, 1, 2, 1, 2
*ELEMENT, TYPE=CONN3D2, ELSET=E
101, 1, 2
*CONNECTOR SECTION, ELSET=E
BEAM
*STEP, UNSYMM=YES
*STATIC, DIRECT
0.1, 1.
*END STEP
";

#[test]
fn what_is_lost_is_said() {
    let deck = file("lossy.inp", LOSSY);
    let output = pintle(&["convert", &deck, "--to", "toml"]);
    assert!(output.status.success());
    let said = String::from_utf8(output.stderr).unwrap();
    for what in [
        "dropped: *MATERIAL: 1 keyword, first on line 7",
        "dropped: *ELASTIC: 1 keyword with 1 data line, first on line 8",
        "dropped: elements of type C3D4: 1 element",
        "dropped: *STEP, UNSYMM: 1 occurrence, first on line 16",
        "dropped: *STATIC, DIRECT: 1 occurrence, first on line 17",
        "dropped: 1 comment line\n",
    ] {
        assert!(said.contains(what), "{what}:\n{said}");
    }
    assert_eq!(said.lines().count(), 6, "{said}");
    let result = path("lossy.toml");
    if fs::exists(&result).unwrap() {
        fs::remove_file(&result).unwrap();
    }
    let strict = pintle(&["convert", &deck, "-o", &result, "--strict"]);
    assert_eq!(strict.status.code(), Some(1));
    assert!(!fs::exists(&result).unwrap());
    run(&["convert", &deck, "-o", &result]);
    let again = pintle(&["convert", &result, "--to", "json", "--strict"]);
    assert!(again.status.success() && again.stderr.is_empty());
}

/// A rule that is broken is told as `eval` tells it, with all errors of the scene; by itself it does not keep a deck from being converted.
#[test]
fn broken_rules_are_told() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\nHINJE,\n";
    let told = |text: &str, code: i32| {
        let deck = file("broken.inp", text);
        let [converted, evaluated] = [&["convert", &deck, "--to", "toml"][..], &["eval", &deck]].map(pintle);
        assert_eq!(converted.status.code(), Some(code));
        assert_eq!(evaluated.status.code(), Some(6));
        assert_eq!(converted.stdout.is_empty(), code != 0);
        [converted, evaluated].map(|output| String::from_utf8(output.stderr).unwrap())
    };
    let [converted, evaluated] = told(text, 0);
    assert_eq!(converted.replace('⚠', "×"), evaluated);
    assert!(converted.contains("did you mean HINGE?"), "{converted}");
    let [converted, evaluated] = told(&format!("{text}*BOUNDARY\n9, 1\n"), 6);
    assert_eq!(converted, evaluated);
    for what in ["there is no node 9", "did you mean HINGE?"] {
        assert!(converted.contains(what), "{converted}");
    }
}

#[test]
fn states_go_into_a_scene() {
    let deck = file(
        "plain.inp",
        "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\nCARTESIAN\n",
    );
    let states = file("plain.csv", "state,time,node,u1\n4,0.5,2,0.125\n");
    let json: Value =
        serde_json::from_str(&run(&["convert", &deck, "--states", &states, "--to", "json"])).unwrap();
    assert_eq!(
        json["states"],
        serde_json::json!([
            {"number": 4, "time": 0.5, "nodes": {"2": {"displacement": [0.125, 0.0, 0.0]}}}
        ])
    );
}

#[test]
fn usage() {
    let unsaid = pintle(&["convert", "gallery:seat_belt"]);
    assert_eq!(unsaid.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&unsaid.stderr).contains("--to"));
    let ending = pintle(&["convert", "gallery:seat_belt", "-o", "scene.txt"]);
    assert_eq!(ending.status.code(), Some(2));
    assert_eq!(pintle(&["convert", "no/such.toml", "--to", "inp"]).status.code(), Some(6));
    assert_eq!(
        pintle(&["convert", "gallery:seat_belt", "-o", "/no/such/directory/a.toml"]).status.code(),
        Some(7)
    );
}

#[test]
fn the_schema_is_printed() {
    let printed: Value = serde_json::from_str(&run(&["schema"])).unwrap();
    assert_eq!(printed, serde_json::from_str::<Value>(pintle_scene::SCHEMA_TEXT).unwrap());
}

/// The example of the help is a scene.
#[test]
fn the_example_of_the_help_is_read() {
    let help = run(&["schema", "--help"]);
    let example = help.split("An example in TOML:\n").nth(1).unwrap().split("\n\nEditors").next().unwrap();
    let example: String = example.lines().map(|line| line.trim_start().to_owned() + "\n").collect();
    let scene = file("help.toml", &example);
    let values = run(&["eval", &scene, "--format", "csv", "--outputs", "CPR1"]);
    assert!(values.contains(",0.3"), "{values}");
}

#[test]
fn toml_is_written_for_readers() {
    insta::assert_snapshot!(
        run(&["convert", "gallery:seat_belt", "--to", "toml"]).split("[[states]]").next().unwrap()
    );
}
