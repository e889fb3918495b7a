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
    let folder = crate::commands::cli::folder(Path::new("compare").join(type_name.replace(' ', "_")));
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

/// Faults drawn into any output of any of these types are found, where they are, with their cause. What is right agrees at any number of
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
    let folder = crate::commands::cli::folder("printed");
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
    let folder = crate::commands::cli::folder("lacks");
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

/// Somebody's files beside a deck, in a folder of a test; the exit code and what is written.
fn run_in(name: &str, files: &[(&str, &str)], arguments: &[&str]) -> (Option<i32>, String) {
    let folder = crate::commands::cli::folder(Path::new("compare").join(name));
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
    let done = pintle(&["compare", "deck.inp"]).current_dir(&folder).args(arguments).assert();
    let text = format!("{}{}", stdout(&done), stderr(&done));
    (done.get_output().status.code(), text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// A bushing of springs from a held node 1 to a moved node 2, with axes across the global ones.
const SPRINGS: &str = "*NODE\n1, 0.2, -0.1, 0.3\n2, 1.1, 0.4, 0.8\n3, 1.5, -0.3, 0.2\n\
    *ORIENTATION, NAME=O\n0.6, 0.8, 0., -0.8, 0.6, 0.\n\
    *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n8, 3, 2\n\
    *CONNECTOR SECTION, ELSET=C, BEHAVIOR=K\nCARTESIAN, ROTATION\nO, O\n*CONNECTOR BEHAVIOR, NAME=K\n\
    *CONNECTOR ELASTICITY, COMPONENT=1\n200.\n*CONNECTOR ELASTICITY, COMPONENT=2\n330.\n\
    *CONNECTOR ELASTICITY, COMPONENT=3\n150.\n*CONNECTOR ELASTICITY, COMPONENT=4\n12.\n\
    *CONNECTOR ELASTICITY, COMPONENT=5\n17.\n*CONNECTOR ELASTICITY, COMPONENT=6\n9.\n\
    *BOUNDARY\n1, 1, 6\n2, 1, 6\n3, 1, 6\n";

/// Node, displacement and rotation vector of each node at one state.
type Moved = Vec<(u32, [f64; 3], [f64; 3])>;

/// The motion of such a run: nodes 1 and 2 move and turn, 3 stays.
fn motion(states: usize) -> Vec<Moved> {
    (0..states)
        .map(|n| {
            let t = n as f64 / 10.0;
            vec![
                (1, [0.1 * t, -0.2 * t * t, 0.05 * t], [0.3 * t, 0.2 * t, -0.4 * t]),
                (2, [0.4 * t, 0.1 * (3.0 * t).sin(), -0.3 * t], [-0.5 * t, 0.7 * t, 0.2 * t]),
                (3, [0.0; 3], [0.0; 3]),
            ]
        })
        .collect()
}

fn table_of(motion: &[Moved]) -> String {
    let mut text = "time,node,U1,U2,U3,UR1,UR2,UR3\n".to_string();
    for (n, nodes) in motion.iter().enumerate() {
        for (node, u, r) in nodes {
            let _ = write!(text, "{:?},{node}", n as f64 / 10.0);
            for x in u.iter().chain(r) {
                let _ = write!(text, ",{x:.16e}");
            }
            text.push('\n');
        }
    }
    text
}

/// Nodal forces on node 2 and 1 by the balance of each spring alone. The force is that of three springs along the axes of its first node.
/// The torque of three along its rotation vector has the moment J⁻ᵀ of it.
fn balance(motion: &Moved) -> BTreeMap<u32, [[f64; 3]; 2]> {
    use pintle_kinematics::so3;
    use pintle_kinematics::vector::{add, apply, apply_transposed, cross, product, sub, transpose};
    let place = |node: u32| match node {
        1 => [0.2, -0.1, 0.3],
        2 => [1.1, 0.4, 0.8],
        _ => [1.5, -0.3, 0.2],
    };
    let initial = transpose(&[[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]);
    let of = |node: u32| motion.iter().find(|(label, ..)| *label == node).unwrap();
    let mut found: BTreeMap<u32, [[f64; 3]; 2]> = BTreeMap::new();
    for [a, b] in [[1, 2], [3, 2]] {
        let [turned_a, turned_b] = [a, b].map(|node| product(&so3::turn(of(node).2), &initial));
        let apart = sub(add(place(b), of(b).1), add(place(a), of(a).1));
        let along =
            sub(apply_transposed(&turned_a, apart), apply_transposed(&initial, sub(place(b), place(a))));
        let force = apply(&turned_a, [200.0 * along[0], 330.0 * along[1], 150.0 * along[2]]);
        let vector = so3::log(&product(&transpose(&turned_a), &turned_b));
        let torque = [12.0 * vector[0], 17.0 * vector[1], 9.0 * vector[2]];
        let moment = apply(&turned_a, apply_transposed(&so3::inverse_left_jacobian(vector), torque));
        let at_b = found.entry(b).or_insert([[0.0; 3]; 2]);
        *at_b = [add(at_b[0], force), add(at_b[1], moment)];
        let at_a = found.entry(a).or_insert([[0.0; 3]; 2]);
        *at_a = [sub(at_a[0], force), sub(at_a[1], add(moment, cross(apart, force)))];
    }
    found
}

/// Reactions agree with the balance of the springs, typed again here; drawn faults of them are found and named.
#[test]
fn reactions_and_their_faults_are_told() {
    use pintle_kinematics::vector::{add, cross};
    let motion = motion(14);
    let nodes = table_of(&motion);
    let written = |change: &dyn Fn(usize, u32, [[f64; 3]; 2]) -> [[f64; 3]; 2], digits: usize| {
        let mut text = "time,node,RF1,RF2,RF3,RM1,RM2,RM3\n".to_string();
        for (n, moved) in motion.iter().enumerate() {
            for (node, at) in balance(moved) {
                let _ = write!(text, "{:?},{node}", n as f64 / 10.0);
                for x in change(n, node, at).as_flattened() {
                    let _ = write!(text, ",{x:.*e}", digits - 1);
                }
                text.push('\n');
            }
        }
        text
    };
    let files = ["--against", "nodes.csv", "forces.csv"];
    for digits in [4, 7, 15] {
        let forces = written(&|_, _, at| at, digits);
        let all = [("deck.inp", SPRINGS), ("nodes.csv", nodes.as_str()), ("forces.csv", forces.as_str())];
        let (code, text) = run_in("reactions", &all, &files);
        assert_eq!(code, Some(0), "{digits} digits: {text}");
        assert!(text.contains("All 252 numbers agree"), "{text}");
    }
    let place = |n: usize, node: u32, moved: bool| {
        let initial = if node == 1 { [0.2, -0.1, 0.3] } else { [1.5, -0.3, 0.2] };
        let of = motion[n].iter().find(|(label, ..)| *label == node).unwrap();
        if moved { add(initial, of.1) } else { of.1 }
    };
    let to_b = |n: usize, node: u32| {
        let at = |label: u32, initial: [f64; 3]| {
            add(initial, motion[n].iter().find(|(of, ..)| *of == label).unwrap().1)
        };
        let a = if node == 1 { at(1, [0.2, -0.1, 0.3]) } else { at(3, [1.5, -0.3, 0.2]) };
        pintle_kinematics::vector::sub(a, at(2, [1.1, 0.4, 0.8]))
    };
    type Change<'a> = &'a dyn Fn(usize, u32, [[f64; 3]; 2]) -> [[f64; 3]; 2];
    let faults: [(&str, Change<'_>, &str); 6] = [
        (
            "sign",
            &|_, node, at| if node == 1 { at.map(|of| of.map(|x| -x)) } else { at },
            "the sign is the opposite",
        ),
        (
            "other node",
            &|n, node, at| if node == 1 { [at[0], add(at[1], cross(to_b(n, 1), at[0]))] } else { at },
            "a moment about the other node of 7: M + r × F",
        ),
        (
            "middle",
            &|n, node, at| {
                let half = to_b(n, node).map(|x| 0.5 * x);
                if node == 3 { [at[0], add(at[1], cross(half, at[0]))] } else { at }
            },
            "a moment about the middle of 8: M + r × F",
        ),
        (
            "origin",
            &|n, node, at| if node == 1 { [at[0], add(at[1], cross(place(n, 1, true), at[0]))] } else { at },
            "a moment about the origin: M + r × F",
        ),
        (
            "initial place",
            &|n, node, at| if node == 1 { [at[0], add(at[1], cross(place(n, 1, false), at[0]))] } else { at },
            "a moment about the initial place of the node: M + r × F",
        ),
        (
            "axes",
            &|n, node, at| {
                let turned = pintle_kinematics::so3::turn(motion[n][0].2);
                let initial = pintle_kinematics::vector::transpose(&[
                    [0.6, 0.8, 0.0],
                    [-0.8, 0.6, 0.0],
                    [0.0, 0.0, 1.0],
                ]);
                let triad = pintle_kinematics::vector::product(&turned, &initial);
                let along = |v: [f64; 3]| pintle_kinematics::vector::apply_transposed(&triad, v);
                if node == 1 { at.map(along) } else { at }
            },
            "it is along the axes of node a of 7",
        ),
    ];
    let mut named = 0;
    for (fault, change, words) in faults {
        let forces = written(change, 9);
        let all = [("deck.inp", SPRINGS), ("nodes.csv", nodes.as_str()), ("forces.csv", forces.as_str())];
        let (code, text) = run_in("reactions", &all, &files);
        assert!(code == Some(1) && text.contains(words), "{fault}: {text}");
        named += 1;
    }
    assert_eq!(named, 6);
}

/// A matrix as files of each format hold it.
fn matrix_files(folder: &Path, matrix: &[Vec<f64>], digits: usize) -> Vec<String> {
    let (rows, columns) = (matrix.len(), matrix[0].len());
    let mut text =
        format!("%%MatrixMarket matrix coordinate real general\n{rows} {columns} {}\n", rows * columns);
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({rows}, {columns}), }}\n");
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for (i, line) in matrix.iter().enumerate() {
        for (j, x) in line.iter().enumerate() {
            let _ = writeln!(text, "{} {} {x:.*e}", i + 1, j + 1, digits - 1);
            bytes.extend(x.to_le_bytes());
        }
    }
    fs::write(folder.join("matrix.mtx"), text).unwrap();
    fs::write(folder.join("matrix.npy"), bytes).unwrap();
    vec!["matrix.mtx".into(), "matrix.npy".into()]
}

/// The matrix of a file of `pintle eval --jacobian`.
fn read_matrix(path: &Path) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('%'));
    let size: Vec<usize> = lines.next().unwrap().split(' ').map(|x| x.parse().unwrap()).collect();
    let mut matrix = vec![vec![0.0; size[1]]; size[0]];
    for line in lines {
        let words: Vec<&str> = line.split(' ').collect();
        let at = |n: usize| words[n].parse::<usize>().unwrap() - 1;
        matrix[at(0)][at(1)] = words[2].parse().unwrap();
    }
    matrix
}

const PIN: &str = "\
*NODE
1, 0., 0., 0.
2, 0., 0., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=PIN
7, 1, 2
*CONNECTOR SECTION, ELSET=PIN
CARTESIAN
";

/// What begins late in a long file is explained by what else the connector gives there, whatever is wrong from early on.
#[test]
fn a_late_fault_of_a_long_file_is_explained() {
    const BEGINS: i32 = 6_000;
    for early in [false, true] {
        let mut table = "Time,Node,U1,U2,Element,CU1,CU2,CU3\n".to_string();
        for i in 0..9_000 {
            let one = (f64::from(i) / 50.0).sin();
            let other = one + 0.01 * f64::from((i - BEGINS).max(0));
            let third = if early && i >= 10 { 0.25 } else { 0.0 };
            let time = f64::from(i) / 8.0;
            let _ = writeln!(table, "{time},2,{one:.6},{other:.6},7,{other:.6},{one:.6},{third:.6}");
        }
        let files = [("deck.inp", PIN), ("long.csv", table.as_str())];
        let (code, told) = run_in("late", &files, &["--against", "long.csv"]);
        assert_eq!(code, Some(1), "{told}");
        for words in [
            if early { "14988 of 27000 numbers differ" } else { "5998 of 27000 numbers differ" },
            "from 750.125 on",
            "it is CP2: components are exchanged",
            "it is CP1: components are exchanged",
        ] {
            assert!(told.contains(words), "{words}: {told}");
        }
    }
}

/// Numbers that went through single precision are named as such, unless one is wrong besides.
#[test]
fn single_precision_is_told_unless_something_refutes_it() {
    for wrong in [None, Some(700)] {
        let mut table = "Time,Node,U1,Element,CU1\n".to_string();
        for i in 0..1_000 {
            let u = (f64::from(i) / 50.0).sin();
            let got = f64::from(u as f32) + if wrong == Some(i) { 1e-5 } else { 0.0 };
            let _ = writeln!(table, "{},2,{u:.12},7,{got:.12}", f64::from(i) / 8.0);
        }
        let files = [("deck.inp", PIN), ("single.csv", table.as_str())];
        let (code, told) = run_in("single", &files, &["--against", "single.csv"]);
        assert_eq!(code, Some(1), "{told}");
        assert_eq!(told.contains("single = true in the map"), wrong.is_none(), "{told}");
    }
}

/// Jacobians of drawn types agree in every format, and drawn departures from pintle's conventions are named; a single wrong entry is
/// named under the right one.
#[test]
fn jacobians_of_files_are_compared_entry_by_entry() {
    use pintle_kinematics::so3;
    let (mut agreed, mut named, mut entries) = (0, 0, 0);
    for type_name in ["HINGE", "TRANSLATOR", "UJOINT", "CVJOINT", "BEAM", "CYLINDRICAL"] {
        let (deck, states, _) = history_of(type_name, 6);
        let folder = deck.parent().unwrap().to_path_buf();
        let jacobian = folder.join("right.mtx");
        let [deck, at, out] = [&deck, &states, &jacobian].map(|path| path.to_str().unwrap());
        pintle(&[
            "--force",
            "eval",
            deck,
            "--states",
            at,
            "--show",
            "last",
            "--outputs",
            "RES",
            "--jacobian",
            out,
        ])
        .assert()
        .success();
        let right = read_matrix(&jacobian);
        // How the nodes are turned at the last state.
        let text = fs::read_to_string(&states).unwrap();
        let last: Vec<Vec<f64>> = text
            .lines()
            .skip(1)
            .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect::<Vec<f64>>())
            .collect();
        let turned: Vec<_> =
            last[last.len() - 2..].iter().map(|row| so3::matrix([row[5], row[6], row[7], row[8]])).collect();
        let run = |file: &str| {
            let done = pintle(&["compare", deck, "--against", at, file]).current_dir(&folder).assert();
            let text: String = stdout(&done).split_whitespace().collect::<Vec<_>>().join(" ");
            (done.get_output().status.code(), text + &stderr(&done))
        };
        for digits in [5, 9, 17] {
            for file in matrix_files(&folder, &right, digits) {
                let (code, text) = run(&file);
                assert_eq!(code, Some(0), "{type_name} {file}, {digits} digits: {text}");
                agreed += right.len() * right[0].len();
            }
        }
        let width = right[0].len();
        assert_eq!(width, 12, "{type_name}");
        let transposed = |m: &[Vec<f64>]| -> Vec<Vec<f64>> {
            (0..m[0].len()).map(|j| m.iter().map(|line| line[j]).collect()).collect()
        };
        let each = |m: &[Vec<f64>], of: &dyn Fn(usize, f64) -> f64| -> Vec<Vec<f64>> {
            m.iter().map(|line| line.iter().enumerate().map(|(j, x)| of(j, *x)).collect()).collect()
        };
        let body: Vec<Vec<f64>> = right
            .iter()
            .map(|line| {
                let mut line = line.clone();
                for (end, rotation) in turned.iter().enumerate() {
                    let at = 6 * end + 3;
                    let block = [line[at], line[at + 1], line[at + 2]];
                    let along = pintle_kinematics::vector::apply_transposed(rotation, block);
                    line[at..at + 3].copy_from_slice(&along);
                }
                line
            })
            .collect();
        let kinds: Vec<usize> = vec![0, 1, 2, 6, 7, 8, 3, 4, 5, 9, 10, 11];
        let by_kind: Vec<Vec<f64>> =
            right.iter().map(|line| kinds.iter().map(|j| line[*j]).collect()).collect();
        let departures = [
            (transposed(&right), "transposed"),
            (each(&right, &|_, x| -x), "every sign is the opposite"),
            (each(&right, &|j, x| if j % 6 >= 3 { x * PI / 180.0 } else { x }), "rotations in degrees"),
            (body.clone(), "(body)"),
            (by_kind, "displacements of all nodes first"),
            (transposed(&each(&body, &|_, x| -x)), "(body)"),
        ];
        for (matrix, words) in &departures {
            matrix_files(&folder, matrix, 12);
            for file in ["matrix.mtx", "matrix.npy"] {
                let (code, text) = run(file);
                assert!(code == Some(1) && text.contains(words), "{type_name} {words}: {text}");
                assert!(!text.contains("wrong even so"), "{type_name} {words}: {text}");
                named += 1;
            }
        }
        let mut draw = Draw::new(&format!("entries of {type_name}"));
        for (matrix, words) in [(right.clone(), ""), (body.clone(), "(body)")] {
            let mut spoilt = matrix;
            let places: Vec<(usize, usize)> = (0..spoilt.len())
                .flat_map(|i| (0..width).map(move |j| (i, j)))
                .filter(|(i, j)| spoilt[*i][*j].abs() > 1e-6)
                .collect();
            let (i, j) = places[draw.below(places.len())];
            spoilt[i][j] *= 1.0 + 10.0_f64.powf(-draw.between(0.0, 6.0));
            matrix_files(&folder, &spoilt, 17);
            let (code, text) = run("matrix.npy");
            let place = format!("(line {}, column {})", i + 1, j + 1);
            assert!(
                code == Some(1) && text.contains(&place) && text.contains(words),
                "{type_name} {place}: {text}"
            );
            entries += 1;
        }
    }
    println!("{agreed} entries agree, {named} departures and {entries} wrong entries named");
    assert!(agreed >= 6 * 6 * 24 && named == 72 && entries == 12);
}

/// The deck and states of a history of a type.
fn history_of(type_name: &str, count: usize) -> (PathBuf, PathBuf, ()) {
    let folder = crate::commands::cli::folder(Path::new("compare").join(format!("matrix {type_name}")));
    let [deck, states] = ["deck.inp", "states.csv"].map(|name| folder.join(name));
    let [of, at] = [&deck, &states].map(|path| path.to_str().unwrap());
    let count = count.to_string();
    pintle(&["--force", "states", type_name, "--history", "--count", &count, "--deck", of, "-o", at])
        .assert()
        .success();
    (deck, states, ())
}

/// The stiffness of springs agrees with differences of the balance that is typed above, and a wrong factor of it is told.
#[test]
fn a_stiffness_is_compared() {
    let motion = motion(8);
    let nodes = table_of(&motion);
    let last = motion.last().unwrap();
    // By the displacements of node 2 alone: rotations of a moment are another matter.
    let deck = SPRINGS.replace("2, 1, 6\n", "2, 4, 6\n");
    let step = 1e-6;
    let column = |j: usize| -> Vec<f64> {
        let at = |by: f64| {
            let mut moved = last.clone();
            moved[1].1[j] += by;
            balance(&moved)[&2][0]
        };
        (0..3).map(|i| (at(step)[i] - at(-step)[i]) / (2.0 * step)).collect()
    };
    let columns: Vec<Vec<f64>> = (0..3).map(column).collect();
    let matrix = |factor: f64| -> String {
        let mut text = "%%MatrixMarket matrix array real general\n3 3\n".to_string();
        for line in &columns {
            for x in line {
                let _ = writeln!(text, "{:.6e}", factor * x);
            }
        }
        text
    };
    for (factor, code, words) in [
        (1.0, 0, "All 9 numbers agree"),
        (-1.0, 1, "every sign is the opposite"),
        (1e-3, 1, "mm of a scene in m"),
        (1.2, 1, "∂force at 2.u"),
    ] {
        let stiffness = matrix(factor);
        let files = [
            ("deck.inp", deck.as_str()),
            ("nodes.csv", nodes.as_str()),
            ("k.mtx", stiffness.as_str()),
            ("map.toml", "matrix = \"stiffness\"\n"),
        ];
        let (found, text) =
            run_in("stiffness", &files, &["--against", "nodes.csv", "k.mtx", "--map", "map.toml"]);
        assert!(found == Some(code) && text.contains(words), "{factor}: {text}");
    }
}

/// Vectors along other axes, and a force that has the right size in another direction.
#[test]
fn vectors_along_other_axes_are_told() {
    use pintle_kinematics::so3;
    use pintle_kinematics::vector::{apply, apply_transposed, product, transpose};
    let motion = motion(14);
    let nodes = table_of(&motion);
    let initial = transpose(&[[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]);
    let force = |n: usize| {
        let at = balance(
            &motion[n]
                .iter()
                .filter(|(node, ..)| *node != 3)
                .copied()
                .chain([(3, [0.0; 3], [0.0; 3])])
                .collect(),
        );
        let a = product(&so3::turn(motion[n][0].2), &initial);
        // On node 1 there is one spring alone.
        apply_transposed(&a, at[&1][0].map(|x| -x))
    };
    type Change<'a> = &'a dyn Fn(usize, [f64; 3]) -> [f64; 3];
    let a = |n: usize| product(&so3::turn(motion[n][0].2), &initial);
    let b = |n: usize| product(&so3::turn(motion[n][1].2), &initial);
    let faults: [(Change<'_>, &str); 6] = [
        (&|_, f| f, "All 42 numbers agree"),
        (&|n, f| apply(&a(n), f), "it is along global axes"),
        (&|n, f| apply_transposed(&b(n), apply(&a(n), f)), "it is along the axes of node b"),
        (
            &|n, f| apply_transposed(&initial, apply(&a(n), f)).map(|x| -x),
            "initial axes of node a, with the opposite sign",
        ),
        (&|_, f| [f[1], f[0], f[2]], "it is CTF2: components are exchanged"),
        (
            &|_, f| {
                let (s, c) = 0.3_f64.sin_cos();
                [c * f[0] - s * f[1], s * f[0] + c * f[1], f[2]]
            },
            "a vector of the right size in another direction",
        ),
    ];
    for (change, words) in faults {
        let mut text = "time,element,CTF1,CTF2,CTF3\n".to_string();
        for n in 0..motion.len() {
            let [x, y, z] = change(n, force(n));
            let _ = writeln!(text, "{:?},7,{x:.8e},{y:.8e},{z:.8e}", n as f64 / 10.0);
        }
        let files = [("deck.inp", SPRINGS), ("nodes.csv", nodes.as_str()), ("forces.csv", text.as_str())];
        let (code, text) = run_in("axes", &files, &["--against", "nodes.csv", "forces.csv"]);
        assert!(
            code == Some(i32::from(!words.starts_with("All"))) && text.contains(words),
            "{words}: {text}"
        );
    }
}

/// Outputs between two states of the motion are compared on request alone, and that is said.
#[test]
fn states_between_are_interpolated_on_request() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=O\n0., 0., 1., 1., 0., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nHINGE\nO,\n*BOUNDARY\n1, 1, 6\n";
    let angle = |t: f64| 1.9 * (0.8 * t).sin();
    let (mut nodes, mut right, mut wrong) =
        ("time,node,UR3\n".to_string(), "time,element,CUR1\n".to_string(), "time,element,CUR1\n".to_string());
    for n in 0..41 {
        let t = f64::from(n) / 10.0;
        if n % 4 == 0 {
            let _ = writeln!(nodes, "{t:?},2,{:.15}", angle(t));
        }
        let _ = writeln!(right, "{t:?},7,{:.8}", angle(t));
        let _ = writeln!(wrong, "{t:?},7,{:.8}", 1.5 * angle(t));
    }
    let files = [
        ("deck.inp", deck),
        ("nodes.csv", nodes.as_str()),
        ("right.csv", right.as_str()),
        ("wrong.csv", wrong.as_str()),
    ];
    let (code, text) = run_in("between", &files, &["--against", "nodes.csv", "right.csv"]);
    assert!(
        code == Some(0) && text.contains("All 11 numbers agree") && text.contains("--interpolate"),
        "{text}"
    );
    let (code, text) = run_in("between", &files, &["--against", "nodes.csv", "right.csv", "--interpolate"]);
    assert!(code == Some(0) && text.contains("All 41 numbers agree"), "{text}");
    assert!(text.contains("interpolated: 30 of 41 states have no motion of their own"), "{text}");
    let (code, text) = run_in("between", &files, &["--against", "nodes.csv", "wrong.csv", "--interpolate"]);
    assert!(code == Some(1) && text.contains("file ") && text.contains("difference "), "{text}");
}

/// Tables as Abaqus lays them out: with what is zero left out, integration points, several tables of a time, summaries; and as CalculiX
/// does, with numbers that touch.
#[test]
fn printed_tables_keep_their_habits() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
        *CONNECTOR SECTION, ELSET=C, BEHAVIOR=K\nCARTESIAN\n*CONNECTOR BEHAVIOR, NAME=K\n\
        *CONNECTOR ELASTICITY, COMPONENT=1\n2000.\n*CONNECTOR ELASTICITY, COMPONENT=2\n3000.\n*BOUNDARY\n1, 1, 6\n2, 1, 2\n";
    let abaqus = |force: &str| {
        format!(
            " STEP TIME COMPLETED       0.00    ,  TOTAL TIME COMPLETED         0.00\n\n N O D E   O U T P U T\n\n\
             \x20  THE FOLLOWING TABLE IS PRINTED FOR ALL NODES\n\n       NODE FOOT-   U1          U2          U3\n            NOTE\n\n\
             \x20  ALL VALUES IN THIS TABLE ARE ZERO\n\n\
             \x20  ELEMENT  FOOT-   CTF1        CTF2\n              NOTE\n\n          7       0.000       0.000\n\n\
             \x20STEP TIME COMPLETED       1.00    ,  TOTAL TIME COMPLETED         1.00\n\n\
             \x20      NODE FOOT-   U1          U2          U3\n            NOTE\n\n          2      2.0000E-03  1.0000E-03   0.000\n\n\
             \x20MAXIMUM         2.0000E-03  1.0000E-03   0.000\n AT NODE                 2           2           0\n\n\
             \x20      NODE FOOT-   RF1         RF2         RF3         RM1         RM2         RM3\n            NOTE\n\n\
             \x20         1      -4.000      -3.000       0.000       0.000       0.000      -3.002\n\
             \x20         2       4.000       3.000       0.000       0.000       0.000     {force}\n\n\
             \x20TOTAL            0.000       0.000       0.000       0.000       0.000       0.000\n\n\
             \x20   ELEMENT  PT FOOT-       CTF1        CTF2\n                 NOTE\n\n          7   1            4.000       3.000\n"
        )
    };
    for (force, code) in [("  0.000", 0), ("  1.0000E-04", 1)] {
        let dat = abaqus(force);
        let files = [("deck.inp", deck), ("run.dat", dat.as_str())];
        let (found, text) = run_in("abaqus", &files, &["--against", "run.dat"]);
        assert_eq!(found, Some(code), "{text}");
        let counted = text.contains("CTF1 agrees 0 of 2") && text.contains("RF1 agrees 0 of 1");
        assert!(counted && text.contains("RM1"), "{text}");
    }
    let calculix = "                        S T E P       1\n\n INCREMENT     1\n\n\
        \x20displacements (vx,vy,vz) for set ALL and time  0.1000000E+01\n\n\
        \x20        1  0.000000E+00  0.000000E+00  0.000000E+00\n         2  2.000000E-03-1.000000E-03 0.000000E+00\n\n\
        \x20forces (fx,fy,fz) for set FIX and time  0.1000000E+01\n\n\
        \x20        1 -4.000000E+00 3.000000E+00-0.000000E+00\n         2  4.000000E+00-3.000000E+00 0.000000E+00\n\n\
        \x20total force (fx,fy,fz) for set FIX and time  0.1000000E+01\n\n        0.000000E+00  0.000000E+00  0.000000E+00\n";
    let files = [("deck.inp", deck), ("run.dat", calculix)];
    let (code, text) = run_in("calculix", &files, &["--against", "run.dat"]);
    assert!(
        code == Some(0) && text.contains("RF2 agrees 0 of 1") && text.contains("All 6 numbers agree"),
        "{text}"
    );
}

/// Records of JSON are read one at a time, arrays of NumPy by their fields; both say the same as a table.
#[test]
fn every_format_says_the_same() {
    let folder = crate::commands::cli::folder(Path::new("compare").join("formats"));
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=O\n0., 0., 1., 1., 0., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nHINGE\nO,\n";
    let (mut csv, mut json, mut lines, mut numbers) =
        ("time,UR3,CUR1\n".to_string(), "[".to_string(), String::new(), Vec::new());
    for n in 0..9 {
        let t = f64::from(n) / 8.0;
        let (got, want) = (if n == 5 { t + 0.25 } else { t }, t);
        let _ = writeln!(csv, "{t:?},{want:?},{got:?}");
        let record = format!(
            "{{\"time\": {t:?}, \"note\": \"a }} ] \\\" brace\", \"UR3\": {want:?}, \"CUR1\": {got:?}}}"
        );
        json.push_str(&format!("{}{record}", if n > 0 { ",\n" } else { "" }));
        lines.push_str(&format!("{record}\n"));
        numbers.extend([t, want, got]);
    }
    json.push(']');
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    let header = "{'descr': [('time', '<f8'), ('UR3', '<f8'), ('CUR1', '<f8')], 'fortran_order': False, 'shape': (9,), }\n";
    npy.extend((header.len() as u16).to_le_bytes());
    npy.extend(header.as_bytes());
    numbers.iter().for_each(|x| npy.extend(x.to_le_bytes()));
    fs::write(folder.join("run.npy"), npy).unwrap();
    let files = [
        ("deck.inp", deck),
        ("map.toml", "node = \"2\"\nelement = \"7\"\n"),
        ("run.csv", csv.as_str()),
        ("run.json", json.as_str()),
        ("run.jsonl", lines.as_str()),
    ];
    for file in ["run.csv", "run.json", "run.jsonl", "run.npy"] {
        let (code, text) = run_in("formats", &files, &["--against", file, "--map", "map.toml"]);
        assert!(code == Some(1) && text.contains("1 of 9 numbers differ"), "{file}: {text}");
    }
    let broken = json.trim_end_matches(']');
    let (code, text) =
        run_in("formats", &[("run.json", broken)], &["--against", "run.json", "--map", "map.toml"]);
    assert!(code == Some(6) && text.contains("run.json, record 10: the list ends in the middle"), "{text}");
    let right = csv.replace("0.625,0.625,0.875", "0.625,0.625,0.625");
    let files = [("right.csv", right.as_str())];
    let both = ["--against", "right.csv", "--or", "run.csv", "--map", "map.toml"];
    let (code, text) = run_in("formats", &files, &both);
    assert!(code == Some(1) && text.starts_with("right.csv: right. run.csv: wrong."), "{text}");
    let report = |format: &str| {
        let done =
            pintle(&["compare", "deck.inp", "--against", "run.csv", "--map", "map.toml", "--format", format])
                .current_dir(&folder)
                .assert()
                .code(1);
        stdout(&done)
    };
    let junit = report("junit");
    assert!(
        junit.contains("<testsuite name=\"run.csv\" tests=\"1\"") && junit.contains("failures=\"1\""),
        "{junit}"
    );
    let markdown = report("markdown");
    assert!(markdown.contains("| HINGE 7 | CUR1 | 1 of 9 |"), "{markdown}");
    let html = report("html");
    assert!(html.contains("class=\"got\"") && html.contains("class=\"apart\""), "{html}");
}

/// What a file cannot tell is said with the lines of a deck that print it.
#[test]
fn gaps_are_said_with_the_output_request() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n\
        *CONNECTOR SECTION, ELSET=C\nCARTESIAN\n*BOUNDARY\n1, 1, 6\n2, 1, 6\n*ELEMENT, TYPE=ROTARYI, ELSET=R\n8, 1\n\
        *ROTARY INERTIA, ELSET=R\n1., 1., 1.\n";
    let run =
        "time,node,element,U1,CU1,CV1\n0,1,,0,,\n0,2,,0,,\n0,,7,,0,0\n1,1,,0,,\n1,2,,0.5,,\n1,,7,,0.5,0.5\n";
    let files = [("deck.inp", deck), ("run.csv", run), ("forces.csv", "time,node,RF1\n1,2,0.\n")];
    let (code, text) = run_in("gaps", &files, &["--against", "run.csv", "forces.csv"]);
    assert_eq!(code, Some(0), "{text}");
    for words in [
        "no rotation of nodes 1: they are taken not to turn, so it distinguishes neither frames of components nor variations of rotations; add to the step *NODE PRINT U, UR",
        "the rates of nodes, of which CV, CA and viscous forces are made; add to the step *NODE PRINT U, UR, V, VR, A, AR",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let deck = deck.replace("CARTESIAN", "JOIN");
    let files = [("deck.inp", deck.as_str()), ("run.csv", "time,node,U1,UR3\n1,2,0,0.\n1,1,0,0\n")];
    let (code, text) = run_in("gaps", &files, &["--against", "run.csv", "forces.csv"]);
    let words = "reactions do not follow from a motion; add to the step *EL PRINT CTF";
    assert!(code == Some(4) && text.contains(words), "{text}");
}

/// A hinge with a spring and a damper, about the third axis.
const DOOR: &str = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=O\n0., 0., 1., 1., 0., 0.\n\
    *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nHINGE\nO,\n\
    *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=4\n12.\n*CONNECTOR DAMPING, COMPONENT=4\n2.\n\
    *BOUNDARY\n1, 1, 6\n2, 1, 6\n";

/// Numbers without zeros at the end have the digits of the longest, not those they show; where digits leave much open, it is said.
#[test]
fn short_numbers_are_not_taken_for_rough_ones() {
    let turn =
        "Time,Node,UR1,UR2,UR3\n0,2,0.0,0.0,0\n0.25,2,0.0,0.0,0.5\n0.5,2,0.0,0.0,1.0\n0.75,2,0.0,0.0,1.5\n";
    let said = "Time,Element,CUR1,CEM1\n0,7,0.0,0.0\n0.25,7,0.5,6.12\n0.5,7,1.0,12.24\n0.75,7,1.54,18.0\n";
    let json =
        r#"[{"time": 0.25, "node": 2, "UR3": 0.5}, {"time": 0.25, "element": 7, "CUR1": 0.5, "CEM1": 6.1}]"#;
    let files = [("deck.inp", DOOR), ("turn.csv", turn), ("said.csv", said), ("said.json", json)];
    let (code, text) = run_in("short", &files, &["--against", "turn.csv", "said.csv"]);
    assert!(code == Some(1) && text.contains("3 of 8 numbers differ, in 2 of 2 outputs"), "{text}");
    let (code, text) = run_in("short", &files, &["--against", "said.json"]);
    assert!(code == Some(1) && text.contains("1 of 2 numbers differ"), "{text}");
    let rough = "Time,Element,CUR1\n0.25,7,0.5\n0.5,7,1.0\n0.75,7,1.5\n";
    let files = [("deck.inp", DOOR), ("turn.csv", turn), ("rough.csv", rough)];
    let (code, text) = run_in("short", &files, &["--against", "turn.csv", "rough.csv"]);
    assert!(code == Some(0) && text.contains("errors below 3.3 % of CUR1 of 7"), "{text}");
}

/// What is not read, and what cannot be joined, is no silent agreement.
#[test]
fn files_that_do_not_fit_are_said_to() {
    let turn = "Time,Node,UR3\n0.1,2,0.1250\n0.2,2,0.2500\n0.3,2,0.5000\n0.4,2,0.7500\n";
    let run = |said: &str, more: &[&str]| {
        let map = "[columns]\n\"Frame\" = \"Time\"\n";
        let files = [("deck.inp", DOOR), ("turn.csv", turn), ("said.csv", said), ("map.toml", map)];
        run_in("unfit", &files, &[&["--against", "turn.csv", "said.csv"], more].concat())
    };
    let said = "Time;Element;CUR1;Winkel\n0.1;7;0.1250;0.1\n0.2;7;0.2500;0.2\n0.3;7;0.5000;0.3\n";
    let (code, text) = run(said, &[]);
    let words = "All 3 numbers agree, within the digits of the file. The column Winkel was not read.";
    assert!(code == Some(0) && text.contains(words), "{text}");
    let (code, text) = run(&said.replace("Time;", "Frame;"), &[]);
    let words = "said.csv:2: Frame is 0.1, not the whole number of a state; where it is a time, a map says so: [columns] \"Frame\" = \"Time\"";
    assert!(code == Some(6) && text.contains(words), "{text}");
    assert_eq!(run(&said.replace("Time;", "Frame;"), &["--map", "map.toml"]).0, Some(0));
    let (code, text) = run("Increment,Element,CUR1\n0,7,0.1250\n1,7,0.2500\n", &[]);
    let words = "turn.csv has times, and said.csv has none: their lines cannot be joined";
    assert!(code == Some(6) && text.contains(words), "{text}");
    let (code, text) = run(&said.replace("0.2500", "0.3500"), &[]);
    assert!(
        code == Some(1) && text.contains("CUR1 of 7 differs at 0.2 alone: got 0.35, want 0.25"),
        "{text}"
    );
}

/// Where files have no velocities, a viscous force is that of some time between two states, and the first has none.
#[test]
fn viscous_forces_without_velocities_are_not_called_wrong() {
    let mut turn = "Time,Node,UR3\n".to_string();
    let [mut said, mut reversed] = ["Time,Element,CVM1,CTM1\n"; 2].map(str::to_string);
    for n in 0..20 {
        let t = 0.05 * f64::from(n);
        let (u, v) = (1.2 * (3.0 * t).sin(), 3.6 * (3.0 * t).cos());
        let _ = writeln!(turn, "{t:.2},2,{u:.6}");
        let _ = writeln!(said, "{t:.2},7,{:.6},{:.6}", 2.0 * v, 12.0 * u + 2.0 * v);
        let _ = writeln!(reversed, "{t:.2},7,{:.6},{:.6}", -2.0 * v, 12.0 * u - 2.0 * v);
    }
    let run = |said: &str| {
        let files = [("deck.inp", DOOR), ("turn.csv", &turn), ("said.csv", said)];
        run_in("viscous", &files, &["--against", "turn.csv", "said.csv"])
    };
    let (code, text) = run(&said);
    assert!(
        code == Some(0) && text.contains("CTM1, CVM1 of 7 (2 numbers): the files have no such rates"),
        "{text}"
    );
    assert!(
        text.contains("CV, CA and viscous forces are made; add to the step *NODE PRINT U, UR, V, VR"),
        "{text}"
    );
    let (code, text) = run(&reversed);
    assert!(code == Some(1) && text.contains("CVM1 of 7 differs at 18 of 19 states"), "{text}");
}

/// Angles of another type, or in another sequence, are named.
#[test]
fn angles_of_another_kind_are_named() {
    use pintle_kinematics::so3;
    use pintle_kinematics::vector::product;
    let deck = |kind: &str| {
        format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
             *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\n{kind}\nO,\n*BOUNDARY\n1, 1, 6\n"
        )
    };
    let mut turn = "Time,Node,UR1,UR2,UR3\n".to_string();
    let (mut states, mut nodes) = (Vec::new(), Vec::new());
    for n in 1..8 {
        let t = 0.1 * f64::from(n);
        let of = [0.9 * t, -0.7 * t, 0.8 * t * t];
        let _ = writeln!(turn, "{t:.1},2,{:.9},{:.9},{:.9}", of[0], of[1], of[2]);
        states.push(t);
        nodes.push(of);
    }
    let run = |said: &str, turn: &str| {
        let deck = deck("CARDAN");
        let files = [("deck.inp", deck.as_str()), ("turn.csv", turn), ("said.csv", said)];
        run_in("angles", &files, &["--against", "turn.csv", "said.csv"])
    };
    let table = |of: &dyn Fn(&[f64; 3]) -> [f64; 3]| {
        let mut said = "Time,Element,CUR1,CUR2,CUR3\n".to_string();
        for (t, turn) in states.iter().zip(&nodes) {
            let [x, y, z] = of(turn);
            let _ = writeln!(said, "{t:.1},7,{x:.9},{y:.9},{z:.9}");
        }
        said
    };
    let (code, text) = run(&table(&|turn| *turn), &turn);
    assert!(code == Some(1) && text.contains("it is what a ROTATION has"), "{text}");
    // Turned about 1, then about 2, then about 3: the angles are those that were given.
    let turned = |angles: &[f64; 3]| {
        let [x, y, z] = [0, 1, 2].map(|i| {
            let mut about = [0.0; 3];
            about[i] = angles[i];
            so3::turn(about)
        });
        so3::log(&product(&z, &product(&y, &x)))
    };
    turn = "Time,Node,UR1,UR2,UR3\n".to_string();
    for (t, angles) in states.iter().zip(&nodes) {
        let [x, y, z] = turned(angles);
        let _ = writeln!(turn, "{t:.1},2,{x:.9},{y:.9},{z:.9}");
    }
    let (code, text) = run(&table(&|angles| *angles), &turn);
    assert!(code == Some(1) && text.contains("it is angles in the sequence 3-2-1"), "{text}");
}
