//! `pintle compare` and `pintle check --fit-convention`: results of other programs, with faults drawn into them.

use crate::commands::cli::{pintle, stderr, stdout};
use pintle_kinematics::draw::Draw;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// The output of each component, by state: what `eval` says.
type Table = Vec<BTreeMap<String, f64>>;

/// A history of a type: its deck, its states as a table of motions, and its outputs.
fn history(type_name: &str, count: usize) -> (PathBuf, PathBuf, Table) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("compare").join(type_name.replace(' ', "_"));
    fs::create_dir_all(&folder).unwrap();
    let [deck, states] = ["deck.inp", "states.csv"].map(|name| folder.join(name));
    let [of, at] = [&deck, &states].map(|path| path.to_str().unwrap());
    let count = count.to_string();
    pintle(&["--force", "states", type_name, "--history", "--count", &count, "--deck", of, "-o", at])
        .assert()
        .success();
    let done =
        pintle(&["eval", of, "--states", at, "--outputs", "CU,CP", "--format", "csv"]).assert().success();
    let mut table = Table::new();
    for line in stdout(&done).lines().skip(1) {
        let cells: Vec<&str> = line.split(',').collect();
        let state: usize = cells[1].parse().unwrap();
        table.resize_with(table.len().max(state + 1), BTreeMap::new);
        let (name, number) = cells[7].split_at(cells[7].len() - 1);
        for (output, cell) in [("CP", cells[11]), ("CU", cells[12])] {
            if let Ok(x) = cell.parse::<f64>() {
                let rotation = if name == "ur" { "R" } else { "" };
                table[state].insert(format!("{output}{rotation}{number}"), x);
            }
        }
    }
    (deck, states, table)
}

/// The outputs of a run as another program would write them, with so many digits.
fn write(path: &Path, table: &Table, digits: usize) {
    let names: Vec<&String> = table[0].keys().collect();
    let mut text =
        format!("state,element,{}\n", names.iter().map(|name| name.as_str()).collect::<Vec<_>>().join(","));
    for (state, of) in table.iter().enumerate() {
        let _ = write!(text, "{state},1");
        for name in &names {
            let _ = write!(text, ",{:.*e}", digits - 1, of[*name]);
        }
        text.push('\n');
    }
    fs::write(path, text).unwrap();
}

fn compared(deck: &Path, states: &Path, table: &Table, digits: usize) -> (bool, serde_json::Value) {
    let outputs = deck.with_file_name("outputs.csv");
    write(&outputs, table, digits);
    let [deck, states, outputs] = [deck, states, &outputs].map(|path| path.to_str().unwrap());
    let done = pintle(&["compare", deck, "--against", states, outputs, "--format", "json"]).assert();
    let code = done.get_output().status.code();
    assert!(matches!(code, Some(0 | 1)), "{}", stderr(&done));
    let found: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    (code == Some(0), found[0]["comparison"].clone())
}

/// What a fault makes of a series, and the words of its cause.
type Fault = (&'static str, fn(&mut [f64], &mut Draw), &'static str);

const FAULTS: [Fault; 7] = [
    ("sign", |all, _| all.iter_mut().for_each(|x| *x = -*x), "the sign is the opposite"),
    ("degrees", |all, _| all.iter_mut().for_each(|x| *x *= 180.0 / PI), "it is in degrees"),
    ("millimetres", |all, _| all.iter_mut().for_each(|x| *x *= 1e3), "as mm are of m"),
    (
        "offset",
        |all, draw| {
            let by = draw.between(0.3, 0.9);
            all.iter_mut().for_each(|x| *x += by);
        },
        "a constant",
    ),
    ("late", |all, _| all.rotate_right(1), "it is right up to"),
    (
        "factor",
        |all, draw| {
            let by = draw.between(3.0, 9.0);
            all.iter_mut().for_each(|x| *x *= by);
        },
        "times what it must be",
    ),
    (
        "from some time on",
        |all, draw| {
            let from = 1 + draw.below(all.len() - 2);
            all[from..].iter_mut().for_each(|x| *x *= 1.7);
        },
        "it is right up to",
    ),
];

/// Faults drawn into any output of any of these types are found, where they are, with their cause; what is right agrees at any number of
/// digits, and nothing that is right is called wrong.
#[test]
fn drawn_faults_of_results_are_found_and_named() {
    let (mut agreed, mut found) = (0, 0);
    for type_name in ["CARTESIAN", "CARDAN", "ROTATION", "BUSHING", "CYLINDRICAL", "SLOT"] {
        let (deck, states, table) = history(type_name, 24);
        for digits in [4, 7, 17] {
            let (agrees, comparison) = compared(&deck, &states, &table, digits);
            assert!(agrees, "{type_name}, {digits} digits: {comparison:#}");
            let count: u64 = comparison["series"]
                .as_array()
                .unwrap()
                .iter()
                .map(|one| one["compared"].as_u64().unwrap())
                .sum();
            assert_eq!(count, (table.len() * table[0].len()) as u64, "{type_name}");
            agreed += count;
        }
        let mut draw = Draw::new(&format!("faults of {type_name}"));
        let names: Vec<String> = table[0].keys().cloned().collect();
        for (fault, change, words) in FAULTS {
            let name = &names[draw.below(names.len())];
            let mut series: Vec<f64> = table.iter().map(|of| of[name]).collect();
            // A constant tells no offset from a factor.
            if series.iter().all(|x| (x - series[0]).abs() < 1e-9) {
                continue;
            }
            change(&mut series, &mut draw);
            let mut spoilt = table.clone();
            spoilt.iter_mut().zip(&series).for_each(|(of, x)| *of.get_mut(name).unwrap() = *x);
            let (agrees, comparison) = compared(&deck, &states, &spoilt, 12);
            assert!(!agrees, "{type_name} {name}, {fault}");
            for one in comparison["series"].as_array().unwrap() {
                let is_it = one["name"] == name.as_str();
                assert_eq!(one["wrong"].as_u64() > Some(0), is_it, "{type_name} {name}, {fault}: {one:#}");
                if is_it {
                    let cause = one["cause"].as_str().unwrap_or("none");
                    // CP and CU differ by a constant: what is added may be just that.
                    let is_named = cause.contains(words) || fault == "late" && cause.contains("late");
                    assert!(is_named, "{type_name} {name}, {fault}: {cause}");
                    found += 1;
                }
            }
        }
    }
    println!("{agreed} right numbers agree, {found} faults named");
    assert!(agreed > 2_000 && found >= 30, "{agreed} {found}");
}

/// What Abaqus prints is read, with the digits that it has: a slider that moves by 0.25 and says 0.2500; one that says 0.2600 differs.
#[test]
fn printed_tables_are_read_with_their_digits() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("printed");
    fs::create_dir_all(&folder).unwrap();
    let [deck, printed] = ["slider.inp", "slider.dat"].map(|name| folder.join(name));
    fs::write(
        &deck,
        "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n\
         7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nTRANSLATOR\nO,\n",
    )
    .unwrap();
    let told = |second: &str| {
        format!(
            " STEP TIME COMPLETED      0.500     ,  TOTAL TIME COMPLETED       0.500\n\n   N O D E   O U T P U T\n\n\
             \x20      NODE FOOT-   U1             U2             U3\n            NOTE\n\n\
             \x20         2       0.2500         0.000          0.000\n\n MAXIMUM           0.2500  0.000  0.000\n\n\
             \x20   ELEMENT  FOOT-       CU1         CU2\n              NOTE\n\n          7           {second}      0.000\n"
        )
    };
    for (second, code) in [("0.2500", 0), ("0.25004", 0), ("0.2600", 1)] {
        fs::write(&printed, told(second)).unwrap();
        let [deck, printed] = [&deck, &printed].map(|path| path.to_str().unwrap());
        let done = pintle(&["compare", deck, "--against", printed]).assert();
        assert_eq!(
            done.get_output().status.code(),
            Some(code),
            "{second}: {}{}",
            stdout(&done),
            stderr(&done)
        );
        let states = pintle(&["states", deck, "--from", printed]).assert().success();
        assert!(stdout(&states).contains("0,0.5,2,0.25,"), "{}", stdout(&states));
    }
}

/// Files that say too little are refused with what to print, and a wrong cell by its file and line.
#[test]
fn what_a_file_lacks_is_said() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("lacks");
    fs::create_dir_all(&folder).unwrap();
    let file = folder.join("run.csv");
    for (text, words) in [
        ("time,node,U1\n0,2,0.1\n", "no file has an output of connectors"),
        ("time,element,CU1\n0,106,0.1\n", "no file has a motion of nodes"),
        ("time,thing\n0,1\n", "no heading is a motion"),
        ("time,node,U1\n0,2,zero\n", "run.csv:2: U1 is \"zero\", not a number"),
        ("time,node,U1\n0,2\n", "2 cells, and 3 headings"),
    ] {
        fs::write(&file, text).unwrap();
        let done = pintle(&["compare", "gallery:slider_crank", "--against", file.to_str().unwrap()])
            .assert()
            .code(6);
        assert!(stderr(&done).contains(words), "{words}: {}", stderr(&done));
    }
}
