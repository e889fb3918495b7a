//! Counter-examples in other forms, each one run: Rust tests are compiled against the crate, scripts go to Python, decks to `pintle
//! eval`.

use crate::audit::{named, spoiled};
use crate::audit_counterexample::{of_constraint, others};
use crate::audit_friction::{DECK, path};
use crate::cli::pintle;
use crate::laws::mpc;
use crate::tolerance::{FRICTION_FORCES, HANDOVER};
use pintle::audit::counterexample::BrokenLaw;
use pintle::audit::oracle::Narrow;
use pintle::audit::sample::{Draw, Region, draw_case, extent};
use pintle::audit::{
    Against, Bound, Case, Check, CounterExample, Example, Failing, FrictionCase, Hex, Invariant, Kind,
    MpcCase, Oracle, Planted, Quantity, Recorded, Settings, Target, audit_case, audit_catalogue,
    audit_scenes, friction_cases, invariant, product,
};
use pintle::catalog::{COMPONENT, TABLE};
use pintle::evaluate::{Model, Plan, Selection, request};
use pintle::node::{DOF, DOFS};
use pintle::scene::Scene;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("handover");
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// The library that these tests were built with: the newest of that name beside the program.
fn library() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_BIN_EXE_pintle")).parent().unwrap().join("deps");
    let is_library = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.starts_with("libpintle-") && path.extension().is_some_and(|ending| ending == "rlib")
    };
    let all = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).filter(is_library);
    all.max_by_key(|path| path.metadata().and_then(|data| data.modified()).unwrap()).unwrap()
}

/// Compiles tests against the library, each in a module of its own, and runs them; the names of those that fail, and what was said.
fn run_tests(name: &str, texts: &[(String, String)]) -> (Vec<String>, String) {
    let (source, program) = (folder().join(format!("{name}.rs")), folder().join(name));
    let modules: String = texts.iter().map(|(name, text)| format!("mod {name} {{\n{text}}}\n")).collect();
    fs::write(&source, modules).unwrap();
    let library = library();
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let compiled = Command::new(rustc)
        .args(["--edition", "2024", "--test", "-D", "warnings", "-o"])
        .arg(&program)
        .arg(&source)
        .arg("--extern")
        .arg(format!("pintle={}", library.display()))
        .arg("-L")
        .arg(format!("dependency={}", library.parent().unwrap().display()))
        .output()
        .unwrap();
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let found = Command::new(&program).output().unwrap();
    let said = String::from_utf8_lossy(&found.stdout).into_owned();
    assert!(said.contains(&format!("running {} test", texts.len())), "{said}");
    let failed =
        texts.iter().filter(|(name, _)| said.contains(&format!("test {name}::counter_example ... FAILED")));
    let failed: Vec<String> = failed.map(|(name, _)| name.clone()).collect();
    assert_eq!(found.status.success(), failed.is_empty(), "{said}");
    (failed, said)
}

/// A counter-example of one entry of a case, which wants what the product gives, with no tolerance at all.
fn exact(case: &Case, quantity: Quantity, k: usize, i: usize) -> CounterExample {
    let x = product(case).unwrap().entries(quantity).get(k, i).unwrap();
    CounterExample {
        quantity: Some(quantity),
        entry: quantity.entry_name(k, i),
        got: Hex(x),
        want: Hex(x),
        ..CounterExample::record(case, Against::Oracle(Oracle::WideDifferences))
    }
}

/// A case of each of some types, wound up where the type counts turns.
fn wound(name: &str) -> Case {
    let connection = named(name);
    let winds = Region::of(connection, extent(connection)).contains(&Region::ManyTurns(7.0));
    let region = if winds { Region::ManyTurns(7.0) } else { Region::Misaligned };
    draw_case(connection, region, &mut Draw::new(name)).unwrap()
}

/// The exported test evaluates the same state bit for bit, through a history of turns: with no tolerance it passes, and one digit
/// away it fails.
#[test]
fn a_rust_test_gives_the_same_bits() {
    let (mut right, mut wrong) = (Vec::new(), Vec::new());
    for (name, k, i, quantity) in [
        ("CARDAN", 3, 11, Quantity::FirstDerivatives),
        ("RETRACTOR", 5, 13, Quantity::FirstDerivatives),
        ("FLEXION-TORSION", 4, 0, Quantity::Value),
        ("BEAM", 4, 3 * DOFS + 11, Quantity::SecondDerivatives),
        ("EULER", 3, 0, Quantity::Rate),
        ("BUSHING", 1, 0, Quantity::Acceleration),
        ("UJOINT", 4, 10, Quantity::NodalForces),
        ("CYLINDRICAL", 3, 4 * DOFS + 11, Quantity::GeometricStiffness),
    ] {
        let example = exact(&wound(name), quantity, k, i);
        assert!(example.want.0 != 0.0, "{name}");
        let module = format!("case_{}", right.len());
        right.push((module.clone(), example.rust().unwrap()));
        let other = CounterExample { want: Hex(example.want.0.next_up()), ..example };
        wrong.push((module, other.rust().unwrap()));
    }
    let (failed, said) = run_tests("right", &right);
    assert!(failed.is_empty(), "{said}");
    let (failed, said) = run_tests("wrong", &wrong);
    assert_eq!(failed.len(), wrong.len(), "{said}");
    assert_eq!(said.matches("must be").count(), wrong.len(), "{said}");
}

/// Of a law and a state, the demand of the largest number, as a counter-example.
fn of_law(case: &Case, law: Invariant) -> Option<CounterExample> {
    let numbers = product(case)?;
    let last = case.last()?.state;
    let nearness = Narrow::of(case)?.nearness();
    let bound = Bound::new(&numbers, &last.velocity, &last.acceleration, case.length, nearness);
    let demands = invariant::Context::new(case, &numbers, &bound)?.demands(law);
    let size = |demand: &&invariant::Demand| {
        let terms =
            demand.terms.iter().map(|(q, k, i, c)| (c * numbers.entries(*q).get(*k, *i).unwrap()).abs());
        terms.fold(0.0, f64::max)
    };
    let demand = demands.iter().max_by(|x, y| size(x).total_cmp(&size(y)))?;
    Some(CounterExample {
        entry: demand.what.to_string(),
        law: Some(BrokenLaw { name: law, demanded: demand.what.demanded() }),
        got: Hex(demand.sum(|q, k, i| numbers.entries(q).get(k, i))),
        want: Hex(demand.want),
        tolerance: Hex(demand.allowed),
        ..CounterExample::record(case, Against::Law(law))
    })
}

/// A law that is of one state is a test of it: what is added up, and what that must be, at the same state or its twin. The tests pass, and each
/// fails where a number of it is another.
#[test]
fn a_law_is_a_rust_test() {
    let (mut right, mut wrong) = (Vec::new(), Vec::new());
    for (law, name) in [
        (Invariant::RigidModes, "CARDAN"),
        (Invariant::Frame, "SLIDE-PLANE"),
        (Invariant::Frame, "BUSHING"),
        (Invariant::Equilibrium, "CYLINDRICAL"),
        (Invariant::Power, "BUSHING"),
        (Invariant::Power, "UJOINT"),
        (Invariant::Symmetry, "EULER"),
        (Invariant::Sparsity, "CARTESIAN"),
        (Invariant::NodeSwap, "ROTATION"),
        (Invariant::Halves, "RETRACTOR"),
        (Invariant::Restricted, "TRANSLATOR"),
        (Invariant::Restricted, "HINGE"),
    ] {
        let example = of_law(&wound(name), law).unwrap_or_else(|| panic!("{} {name}", law.name()));
        let module = format!("case_{}", right.len());
        let text = example.rust().unwrap_or_else(|error| panic!("{} {name}: {error}", law.name()));
        // What is declared zero stays it times anything.
        if law != Invariant::Sparsity {
            let other = text.replacen("    [\n        ", "    [\n        1.5 * ", 1);
            assert_ne!(other, text, "{} {name}", law.name());
            wrong.push((module.clone(), other));
        }
        right.push((module, text));
    }
    let (failed, said) = run_tests("laws", &right);
    assert!(failed.is_empty(), "{said}");
    let (failed, said) = run_tests("broken_laws", &wrong);
    assert_eq!(failed.len(), wrong.len(), "{said}");
    // A law that is not of one state says why it is none, and so does JAX, whose numbers are its own.
    for (law, why) in [
        (Invariant::Start, "law of a type"),
        (Invariant::Turns, "law of a type"),
        (Invariant::FreeAxis, "law of a type"),
        (Invariant::Carried, "friction"),
    ] {
        let example = CounterExample::record(&wound("BEAM"), Against::Law(law));
        let said = example.rust().unwrap_err().to_string();
        assert!(said.contains(law.name()) && said.contains(why), "{said}");
    }
    let law = CounterExample::record(&wound("BEAM"), Against::Law(Invariant::Power));
    assert!(law.rust().unwrap().contains("report.mismatches()"));
    let law = Example::Connector(Box::new(law));
    assert!(law.jax().unwrap_err().to_string().contains("exported as a Rust test"));
}

/// The Python of the witnesses, where it has JAX.
fn python() -> Option<PathBuf> {
    let made = Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/bin/python");
    let python = std::env::var_os("PINTLE_PYTHON")
        .map_or_else(|| if made.exists() { made } else { "python3".into() }, PathBuf::from);
    let has = Command::new(&python).args(["-I", "-c", "import jax"]).output();
    if has.is_ok_and(|output| output.status.success()) {
        return Some(python);
    }
    eprintln!(
        "SKIPPED: {} has no jax, so scripts for it are not tested; scripts/test.sh sets one up",
        python.display()
    );
    None
}

fn run_script(python: &Path, name: &str, text: &str) -> (bool, String) {
    let path = folder().join(format!("{name}.py"));
    fs::write(&path, text).unwrap();
    let output = Command::new(python).arg("-I").arg(&path).output().unwrap();
    let said =
        [output.stdout, output.stderr].map(|said| String::from_utf8_lossy(&said).into_owned()).concat();
    (output.status.success(), said)
}

/// The script confirms what is right, within the bound of the state and after turns, and does not confirm what is wrong.
#[test]
fn a_script_confirms_what_is_right() {
    let Some(python) = python() else { return };
    for (n, (name, k, i, quantity)) in [
        ("CARDAN", 3, 0, Quantity::Value),
        ("EULER", 5, 11, Quantity::FirstDerivatives),
        ("ROTATION", 4, 3 * DOFS + 11, Quantity::SecondDerivatives),
        ("BUSHING", 1, 0, Quantity::Acceleration),
        ("RETRACTOR", 5, 0, Quantity::Value),
        ("FLEXION-TORSION", 4, 0, Quantity::Value),
        ("UNIVERSAL", 4, 0, Quantity::Rate),
        ("CARTESIAN", 1, 3, Quantity::NodalForces),
        ("CARDAN", 3, 3 * DOFS + 11, Quantity::GeometricStiffness),
    ]
    .into_iter()
    .enumerate()
    {
        let case = wound(name);
        let mut example = exact(&case, quantity, k, i);
        let nearness = Narrow::of(&case).unwrap().nearness();
        let last = case.last().unwrap().state;
        let bound =
            Bound::new(&product(&case).unwrap(), &last.velocity, &last.acceleration, case.length, nearness);
        example.tolerance = Hex(bound.tolerance(quantity, k, i));
        let (passes, said) = run_script(&python, &format!("right_{n}"), &example.jax().unwrap());
        assert!(passes && said.contains("JAX confirms"), "{name}: {said}");
        if n < 2 {
            let far = example.want.0 + 100.0 * example.tolerance.0;
            let wrong = CounterExample { want: Hex(far), ..example };
            let (passes, said) = run_script(&python, &format!("wrong_{n}"), &wrong.jax().unwrap());
            assert!(!passes && said.contains("JAX does not confirm"), "{name}: {said}");
        }
    }
}

/// The numbers that `pintle eval` gives at the last state, as the product's are held.
fn evaluated(deck: &Path, states: &Path) -> Vec<(Quantity, usize, usize, f64)> {
    let [deck, states] = [deck, states].map(|path| path.to_str().unwrap());
    let outputs = "CU,CV,CA,RES,RESV,RESA";
    let arguments =
        ["eval", deck, "--states", states, "--outputs", outputs, "--order", "2", "--format", "json"];
    let output = pintle(&arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let document: Value = serde_json::from_slice(&output.stdout).unwrap();
    let last = document["scenes"][0]["states"].as_array().unwrap().last().unwrap();
    let connector = &last["connectors"][0];
    let mut found = Vec::new();
    for (k, component) in COMPONENT.iter().enumerate() {
        let numbers = &connector["components"][component];
        for (quantity, residual, other) in [
            (Quantity::Value, "RES", "CU"),
            (Quantity::Rate, "RESV", "CV"),
            (Quantity::Acceleration, "RESA", "CA"),
        ] {
            let number = numbers[residual].as_f64().or(numbers[other].as_f64());
            found.extend(number.map(|x| (quantity, k, 0, x)));
        }
        let dofs = connector["jacobian"]["dofs"].as_array().unwrap();
        let place = |dof: &Value| DOF.iter().position(|name| dof["name"] == *name).unwrap();
        let columns: Vec<usize> = dofs.iter().map(place).collect();
        let row =
            |row: &Value| row.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect::<Vec<f64>>();
        if let Some(of) = connector["jacobian"]["rows"].get(component) {
            let entries = columns.iter().zip(row(of));
            found.extend(entries.map(|(j, x)| (Quantity::FirstDerivatives, k, *j, x)));
        }
        if let Some(of) = connector["hessian"].get(component) {
            for (i, of) in columns.iter().zip(of.as_array().unwrap()) {
                let entries = columns.iter().zip(row(of));
                found.extend(entries.map(|(j, x)| (Quantity::SecondDerivatives, k, i * DOFS + j, x)));
            }
        }
    }
    found
}

/// A deck and its states give the numbers of the counter-example: the same bits where no node is turned, and otherwise within what
/// the deck says itself.
#[test]
fn a_deck_gives_the_same_numbers() {
    let (mut same, mut near, mut count) = (0, 0, 0);
    let mut refused = Vec::new();
    for connection in TABLE {
        for region in Region::of(connection, extent(connection)) {
            let chosen = matches!(
                region,
                Region::Aligned
                    | Region::Misaligned
                    | Region::ManyTurns(_)
                    | Region::Cube(0 | 9)
                    | Region::Coincident
            );
            let Some(case) = draw_case(connection, region, &mut Draw::new("deck")).filter(|_| chosen) else {
                continue;
            };
            let what = format!("{} {}", connection.name, region.name());
            let example = CounterExample::record(&case, Against::Own);
            let deck = match example.deck() {
                Ok(deck) => deck,
                Err(error) => {
                    let refusal = format!("{what}: {error}");
                    refused.push(refusal);
                    continue;
                }
            };
            let [path, states] = ["inp", "states.json"].map(|ending| folder().join(format!("deck.{ending}")));
            fs::write(&path, &deck.text).unwrap();
            fs::write(&states, &deck.states).unwrap();
            let numbers = product(&case).unwrap();
            count += 1;
            let bits = deck.text.contains("bit for bit");
            let triads_are_exact = deck.differences.iter().all(|difference| difference.largest == 0.0);
            assert_eq!(bits, triads_are_exact, "{what}");
            if bits {
                same += 1
            } else {
                near += 1
            }
            let all = evaluated(&path, &states);
            for quantity in [Quantity::Value, Quantity::FirstDerivatives, Quantity::SecondDerivatives] {
                assert!(all.iter().any(|(of, ..)| *of == quantity), "{what}");
            }
            for (quantity, k, i, x) in all {
                let want = numbers.entries(quantity).get(k, i).unwrap();
                let line = format!("**   {}: ", quantity.name());
                let said = deck.text.lines().find_map(|text| text.strip_prefix(&line));
                let most: f64 = said.map_or(0.0, |said| said.parse().unwrap());
                assert!(
                    (x - want).abs() <= most,
                    "{what}: {} {x:e}, not {want:e} within {most:e}",
                    COMPONENT[k]
                );
                if bits {
                    assert!(
                        x.to_bits() == want.to_bits() || x == 0.0,
                        "{what}: {} {x:e}, {want:e}",
                        COMPONENT[k]
                    );
                }
                // What is said is rounding, not another state.
                let size = HANDOVER * (1.0 + want.abs().max(case.length));
                let is_regular = matches!(region, Region::Aligned | Region::Misaligned);
                assert!(!is_regular || most <= size, "{what}: {most:e}");
            }
        }
    }
    println!("{count} decks: {same} to the bit, {near} near");
    assert!(same >= 20 && near >= 20, "{same} {near}");
    assert!(refused.is_empty(), "{refused:#?}");
}

/// One case of each kind of constraint, its counter-example, and the numbers that are judged.
fn constraints() -> Vec<(MpcCase, Recorded)> {
    let mut kinds = std::collections::BTreeSet::new();
    // Violated, so that nothing is zero by chance.
    let drawn = mpc::cases().into_iter().filter(|drawn| drawn.name.ends_with('5'));
    let found: Vec<(MpcCase, Recorded)> =
        drawn.filter(|drawn| kinds.insert(drawn.kind)).map(|drawn| of_constraint(&drawn)).collect();
    assert_eq!(found.len(), pintle::mpc::Kind::ALL.len());
    found
}

/// The largest number of each kind, exactly as the constraint gives it; with the tolerance that it has.
fn largest(case: &MpcCase, recorded: &Recorded) -> Vec<(Recorded, f64)> {
    let mut found = Vec::new();
    for sheet in case.sheets() {
        let largest = sheet.entries.iter().max_by(|x, y| x.got.abs().total_cmp(&y.got.abs())).unwrap();
        let of = Recorded {
            quantity: Some(sheet.quantity),
            entry: largest.name.clone(),
            want: Hex(largest.got),
            tolerance: Hex(0.0),
            ..recorded.clone()
        };
        assert_eq!(of.number().unwrap().to_bits(), largest.got.to_bits(), "{} {}", of.subject, of.entry);
        found.push((of, largest.tolerance()));
    }
    found
}

/// Tests of constraints, frictions, belts and tables give the same bits: with no tolerance they pass, and one digit away they fail.
#[test]
fn what_is_no_connector_is_a_rust_test() {
    let constraints = constraints();
    let all =
        constraints.iter().flat_map(|(case, recorded)| largest(case, recorded)).map(|(recorded, _)| recorded);
    let other = |recorded: Recorded| {
        let want = Hex(recorded.number().unwrap());
        Recorded { want, tolerance: Hex(0.0), ..recorded }
    };
    let all: Vec<Recorded> = all.chain(others().into_iter().map(other)).collect();
    let (mut right, mut wrong) = (Vec::new(), Vec::new());
    for recorded in all.into_iter().filter(|recorded| recorded.want.0 != 0.0) {
        let module = format!("case_{}", right.len());
        right.push((module.clone(), recorded.rust().unwrap()));
        let off = Recorded { want: Hex(recorded.want.0.next_up()), ..recorded };
        wrong.push((module, off.rust().unwrap()));
    }
    // Linear equations have no second derivatives.
    assert!(right.len() >= 28, "{}", right.len());
    let (failed, said) = run_tests("no_connectors", &right);
    assert!(failed.is_empty(), "{said}");
    let (failed, said) = run_tests("wrong_no_connectors", &wrong);
    assert_eq!(failed.len(), wrong.len(), "{said}");
}

/// A script of a constraint confirms what is right, and does not confirm what is wrong.
#[test]
fn a_constraint_is_a_script() {
    let Some(python) = python() else { return };
    for (n, (case, recorded)) in constraints().iter().enumerate() {
        let all = largest(case, recorded);
        // Each kind of number, and two of each kind of constraint.
        for (of, tolerance) in [n % all.len(), (n + 2) % all.len()].map(|at| all[at].clone()) {
            let right = Recorded { tolerance: Hex(tolerance), ..of.clone() };
            let (passes, said) = run_script(&python, &format!("constraint_{n}"), &right.jax().unwrap());
            assert!(passes && said.contains("JAX confirms"), "{}: {said}", case.name);
            let off = Recorded { want: Hex(of.want.0 + 100.0 * tolerance), ..right };
            if n % 3 == 0 {
                let (passes, said) =
                    run_script(&python, &format!("wrong_constraint_{n}"), &off.jax().unwrap());
                assert!(!passes && said.contains("JAX does not confirm"), "{}: {said}", case.name);
            }
        }
    }
}

/// A deck of a constraint and its state give the numbers of the counter-example, within what it says.
#[test]
fn a_deck_of_a_constraint_gives_the_same_numbers() {
    for (case, recorded) in constraints() {
        let deck = recorded.deck().unwrap();
        let [path, states] =
            ["inp", "states.json"].map(|ending| folder().join(format!("constraint.{ending}")));
        fs::write(&path, &deck.text).unwrap();
        fs::write(&states, &deck.states).unwrap();
        let [path, states] = [&path, &states].map(|path| path.to_str().unwrap());
        let arguments = [
            "eval",
            path,
            "--states",
            states,
            "--outputs",
            "RES,RESV,RESA",
            "--order",
            "2",
            "--format",
            "json",
        ];
        let output = pintle(&arguments).output().unwrap();
        assert!(output.status.success(), "{}{}", deck.text, String::from_utf8_lossy(&output.stderr));
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        let found = &document["scenes"][0]["states"][0]["mpcs"][0];
        let dofs: Vec<&str> = found["jacobian"]["dofs"]
            .as_array()
            .unwrap()
            .iter()
            .map(|dof| dof["name"].as_str().unwrap())
            .collect();
        let mut count = 0;
        for sheet in case.sheets() {
            let line = format!("**   {}: ", sheet.quantity.name());
            let said = deck.text.lines().find_map(|text| text.strip_prefix(&line));
            let most: f64 = said.map_or(0.0, |said| said.parse().unwrap());
            for (row, entries) in sheet.rows.iter().zip(sheet.entries.chunks(sheet.width())) {
                let name = row.trim_start_matches(['∂', '²', 'd']).split('/').next().unwrap();
                // The name of δ begins with none of these.
                for entry in entries {
                    let by = entry.name.split("/∂").nth(1);
                    let x = match sheet.quantity {
                        Quantity::Value => found["components"][name]["RES"].as_f64(),
                        Quantity::Rate => found["components"][name]["RESV"].as_f64(),
                        Quantity::Acceleration => found["components"][name]["RESA"].as_f64(),
                        Quantity::FirstDerivatives => dofs
                            .iter()
                            .position(|dof| Some(*dof) == by)
                            .and_then(|j| found["jacobian"]["rows"][name][j].as_f64()),
                        _ => None,
                    };
                    let Some(x) = x else { continue };
                    count += 1;
                    assert!(
                        (x - entry.got).abs() <= most,
                        "{} {}: {x:e}, not {:e}",
                        case.name,
                        entry.name,
                        entry.got
                    );
                }
            }
            // What is said is rounding, not another state.
            let size =
                sheet.entries.iter().fold(case.length.max(1.0), |most, entry| most.max(entry.got.abs()));
            assert!(most <= 10.0 * HANDOVER * size, "{} {}: {most:e}", case.name, sheet.quantity.name());
        }
        assert!(
            count >= 3 + case.constraint.rows().iter().filter(|row| **row).count() * 2,
            "{}: {count}",
            case.name
        );
    }
}

/// Of springs and of a friction under given forces, the scene is handed over, with the states up to the one in question: it gives the same numbers
/// there as the scene itself.
#[test]
fn a_deck_of_a_friction_is_its_scene() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n3, 1., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
        *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*ELEMENT, TYPE=CONN3D2, ELSET=D\n8, 2, 3\n\
        *CONNECTOR SECTION, ELSET=C, BEHAVIOR=B\nSLOT\nO,\n*CONNECTOR SECTION, ELSET=D\nAXIAL\n\
        *CONNECTOR BEHAVIOR, NAME=B\n*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR\n-9., -3.\n0., 0.\n1., 0.01\n8., 3.\n\
        *CONNECTOR FRICTION, PREDEFINED, STICK STIFFNESS=400.\n0.\n*FRICTION\n0.3\n";
    let states = r#"{"schema": "pintle-states/1", "states": [
        {"time": 0, "nodes": {}, "forces": {"7": {"f1": 0, "f2": 3, "f3": 4}}},
        {"time": 1, "nodes": {"2": {"displacement": [0.02, 0, 0]}}, "forces": {"7": {"f1": 1, "f2": 3, "f3": 4}}},
        {"time": 2, "nodes": {"2": {"displacement": [0.05, 0, 0]}}, "forces": {"7": {"f1": 1, "f2": 3, "f3": 2}}}]}"#;
    let (scene, states) = (crate::cli::file("scene_of.inp", deck), crate::cli::file("scene_of.json", states));
    let numbers = |deck: &str, states: &str, state: &str| {
        let outputs = "CU,CEF,CSF,CNF,TANGENT";
        let arguments = [
            "eval",
            deck,
            "--states",
            states,
            "--show",
            state,
            "--outputs",
            outputs,
            "--connector",
            "7",
            "--format",
            "json",
        ];
        let output = pintle(&arguments).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let document: Value = serde_json::from_slice(&output.stdout).unwrap();
        let all = document["scenes"][0]["states"].as_array().unwrap();
        all.iter().find(|found| found["index"].as_u64() == state.parse().ok()).unwrap()["connectors"].clone()
    };
    let mut kinds = std::collections::BTreeSet::new();
    for plant in ["wrong-friction", "wrong-entry"] {
        let found = folder().join(plant);
        fs::remove_dir_all(&found).ok();
        let arguments = [
            "audit",
            &scene,
            "--at",
            &states,
            "--plant",
            plant,
            "--wide-states",
            "4",
            "--counter-examples",
            found.to_str().unwrap(),
        ];
        assert_eq!(pintle(&arguments).output().unwrap().status.code(), Some(1));
        for file in fs::read_dir(&found).unwrap().map(|entry| entry.unwrap().path()) {
            let Example::Other(recorded) = Example::read(&fs::read_to_string(&file).unwrap()).unwrap() else {
                continue;
            };
            let Some(found_in) = &recorded.found_in else { panic!("{}", file.display()) };
            let deck = folder().join("found_in.inp");
            let arguments =
                ["replay", file.to_str().unwrap(), "--export", "inp", "-o", deck.to_str().unwrap()];
            assert!(pintle(&arguments).output().unwrap().status.success());
            let state = found_in.state.to_string();
            let exported = numbers(
                deck.to_str().unwrap(),
                folder().join("found_in.states.json").to_str().unwrap(),
                &state,
            );
            assert_eq!(exported, numbers(&scene, &states, &state), "{}", file.display());
            assert!(exported[0]["tangent"]["rows"]["f1"].is_object(), "{exported}");
            kinds.insert(recorded.kind.name());
            assert!(fs::read_to_string(&deck).unwrap().contains(&format!("--show {state} ")));
        }
    }
    assert_eq!(kinds.into_iter().collect::<Vec<_>>(), ["friction", "slope of a behaviour"]);
}

/// Counter-examples of connectors by every oracle that calls a number wrong, and every law: of faults planted in first derivatives, in second
/// ones and in nodal forces, at states of several types.
fn of_connectors() -> Vec<Example> {
    let mut found: Vec<Example> = Vec::new();
    let mut against = std::collections::BTreeSet::new();
    let mut add = |check: &Check, name: &str| {
        if check.verdict.is_mismatch() && against.insert((check.quantity, check.against)) {
            found.push(Example::of(check, name).unwrap_or_else(|| panic!("{check:?}")));
        }
    };
    for planted in [Planted::WrongEntry, Planted::WrongSecond] {
        let settings = Settings { planted: Some(planted), ..Settings::default() };
        for name in ["UJOINT", "RETRACTOR", "ROTATION", "CYLINDRICAL"] {
            let checks = audit_case(&wound(name), &settings, true, 0);
            checks.iter().for_each(|check| add(check, name));
        }
        let jax =
            Settings { oracles: [Oracle::Jax].into(), states: 1, wide_states: 0, atlas: false, ..settings };
        let report = audit_catalogue(&jax, &|_| {});
        report.subjects.iter().for_each(|of| of.checks.iter().for_each(|check| add(check, &of.name)));
    }
    found
}

/// A counter-example of a friction, and the largest number of each kind beside it, which it wants as the oracle on 237 bits has it.
fn largest_of_friction(case: &FrictionCase, recorded: &Recorded) -> Vec<Recorded> {
    let mut found = Vec::new();
    for sheet in case.sheets() {
        let largest = sheet.entries.iter().max_by(|x, y| x.got.abs().total_cmp(&y.got.abs())).unwrap();
        found.push(Recorded {
            quantity: Some(sheet.quantity),
            entry: largest.name.clone(),
            want: Hex(largest.want.to_f64()),
            tolerance: Hex(largest.tolerance()),
            ..recorded.clone()
        });
    }
    // Of several frictions of a connector each is named.
    let title = recorded.values["title"].as_str().unwrap();
    for entry in ["Δγ", "CNF", "CASU"] {
        let entry = format!("{entry}{title}");
        let of = Recorded { quantity: Some(Quantity::FrictionForce), entry, ..recorded.clone() };
        let want = of.number().unwrap();
        let tolerance = Hex(FRICTION_FORCES * want.abs().max(1e-3));
        found.push(Recorded { want: Hex(want), tolerance, ..of });
    }
    found
}

/// Frictions of all types at drawn forces, each with a counter-example.
fn drawn_frictions() -> Vec<(FrictionCase, Recorded)> {
    let settings = Settings {
        planted: Some(Planted::WrongFriction),
        oracles: [Oracle::WideDifferences].into(),
        ..Settings::default()
    };
    let cases = TABLE.iter().flat_map(|connection| friction_cases(connection, &settings, 3));
    let of = |case: FrictionCase| {
        let checks = case.audit(&settings);
        let wrong = checks.iter().find(|check| check.verdict.is_mismatch()).unwrap();
        match Example::of(wrong, "a test") {
            Some(Example::Other(recorded)) => (case, *recorded),
            other => panic!("{other:?}"),
        }
    };
    cases.map(of).collect()
}

/// Scripts in parallel, each with what it must say.
fn run_scripts(python: &Path, scripts: &[(String, String, &str)]) {
    const AT_ONCE: usize = 4;
    let wrong = std::sync::Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for first in 0..AT_ONCE {
            let wrong = &wrong;
            scope.spawn(move || {
                for (name, text, must) in scripts.iter().skip(first).step_by(AT_ONCE) {
                    let (passes, said) = run_script(python, name, text);
                    if passes != must.starts_with("JAX confirms") || !said.contains(must) {
                        wrong.lock().unwrap().push(format!("{name}: {said}"));
                    }
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Scripts of frictions of every type confirm what is right, of each kind of number, in stick and in slip; and not what is wrong.
#[test]
fn a_friction_is_a_script() {
    let Some(python) = python() else { return };
    let mut scripts = Vec::new();
    let mut kinds = std::collections::BTreeSet::new();
    for (n, (case, recorded)) in drawn_frictions().iter().enumerate() {
        let all = largest_of_friction(case, recorded);
        let of = &all[n % all.len()];
        kinds.insert(of.quantity);
        scripts.push((format!("friction_{n}"), of.jax().unwrap(), "JAX confirms"));
        if n % 9 == 0 {
            let off = of.want.0 + 100.0 * of.tolerance.0;
            let wrong = Recorded { want: Hex(off), ..of.clone() };
            scripts.push((format!("wrong_friction_{n}"), wrong.jax().unwrap(), "JAX does not confirm"));
        }
    }
    assert!(kinds.len() == 5 && scripts.len() > 27, "{kinds:?} {}", scripts.len());
    run_scripts(&python, &scripts);
}

/// Numbers of a belt, as the product has them.
fn numbers_of_belt(of: &Recorded) -> Vec<Recorded> {
    let all = [
        (Quantity::FrictionCriterion, "Φ"),
        (Quantity::FrictionGradient, "∂Φ/∂α"),
        (Quantity::FrictionHessian, "∂²Φ/∂α∂α"),
        (Quantity::FrictionForce, "CSF2"),
        (Quantity::FrictionForce, "Δγ"),
        (Quantity::FrictionTangent, "∂CSF2/∂Δu2"),
    ];
    let one = |(quantity, entry): (Quantity, &str)| {
        let of = Recorded { quantity: Some(quantity), entry: entry.into(), ..of.clone() };
        let want = of.number().unwrap();
        Recorded { want: Hex(want), tolerance: Hex(FRICTION_FORCES * want.abs().max(1e-3)), ..of }
    };
    all.into_iter().map(one).collect()
}

/// What is found in scenes: frictions of users with derived components, tables and potentials, belts, at states given and under forces drawn,
/// of every kind of number.
#[test]
fn a_friction_of_a_scene_is_a_script() {
    let Some(python) = python() else { return };
    let scene = Scene::parse("deck.inp", DECK).unwrap();
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, request([], 0).unwrap()).unwrap();
    let (given, mut unforced) = (path(), path());
    unforced.iter_mut().for_each(|state| state.forces.clear());
    let mut all = Vec::new();
    for planted in [Planted::WrongFriction, Planted::WrongEntry] {
        for states in [&given, &unforced] {
            let settings = Settings {
                planted: Some(planted),
                oracles: [Oracle::WideDifferences].into(),
                wide_states: 4,
                ..Settings::default()
            };
            let target = Target { name: "deck", model: &model, plan: &plan, states };
            let report = audit_scenes(&settings, &[target], &|_| {});
            for subject in &report.subjects {
                let wrong = subject.checks.iter().filter(|check| check.verdict.is_mismatch());
                all.extend(wrong.filter_map(|check| Example::of(check, &subject.name)));
            }
        }
    }
    all.extend(others().into_iter().map(|recorded| Example::Other(Box::new(recorded))));
    let mut chosen = Vec::new();
    for (n, example) in all.iter().enumerate() {
        let Example::Other(of) = example else { continue };
        match example.failing().unwrap() {
            Failing::Friction(case) => {
                chosen.push((**of).clone());
                let mut others = largest_of_friction(&case, of);
                chosen.push(others.swap_remove(n % others.len()));
            }
            Failing::Belt(_) => {
                chosen.push((**of).clone());
                chosen.extend(numbers_of_belt(of));
            }
            _ => {}
        }
    }
    let mut scripts = Vec::new();
    let mut quantities = std::collections::BTreeSet::new();
    for of in &chosen {
        quantities.insert(of.quantity);
        let name = format!("scene_friction_{}", scripts.len());
        scripts.push((name, of.jax().unwrap_or_else(|error| panic!("{error}")), "JAX confirms"));
    }
    assert!(quantities.len() == 5 && scripts.len() > 24, "{quantities:?} {}", scripts.len());
    run_scripts(&python, &scripts);
}

/// A deck of a predefined friction and its states lead to the increment, and to the tractions at which the criterion is judged: the same
/// bits where nothing turns, else within what the deck says; `eval` gives its forces, `audit` finds nothing wrong. What none leads to is said.
#[test]
fn a_deck_of_a_predefined_friction_gives_the_same_numbers() {
    let (mut same, mut near, mut beyond) = (0, 0, 0);
    for (n, (case, recorded)) in drawn_frictions().iter().enumerate() {
        for (i, of) in largest_of_friction(case, recorded).into_iter().enumerate() {
            let deck = match of.deck() {
                Ok(deck) => deck,
                Err(error) => {
                    let said = error.to_string();
                    assert!(said.contains("beyond the limit") && of.entry.contains('Φ'), "{said} {of:?}");
                    beyond += 1;
                    continue;
                }
            };
            let is_exact = deck.differences.iter().all(|difference| difference.largest == 0.0);
            same += usize::from(is_exact);
            near += usize::from(!is_exact);
            let turns = of.values["friction"]["criterion"]["tangential"].to_string().contains("[3,")
                || case.name().starts_with("UJOINT");
            assert!(is_exact || turns, "{} {}: {:?}", case.name(), of.entry, deck.differences);
            // Forces as `eval` writes them, and nothing wrong for `audit`.
            if i % 7 != n % 7 {
                continue;
            }
            let [path, states] =
                ["inp", "states.json"].map(|ending| folder().join(format!("friction.{ending}")));
            fs::write(&path, &deck.text).unwrap();
            fs::write(&states, &deck.states).unwrap();
            let [path, states] = [&path, &states].map(|path| path.to_str().unwrap());
            let audited = pintle(&["audit", path, "--at", states, "--wide-states", "1"]).output().unwrap();
            let said = String::from_utf8_lossy(&audited.stdout).into_owned();
            assert!(audited.status.success(), "{}{said}", deck.text);
            if of.quantity != Some(Quantity::FrictionForce) {
                continue;
            }
            let arguments =
                ["eval", path, "--states", states, "--outputs", "CSF,CNF,CASU,TANGENT", "--format", "json"];
            let output = pintle(&arguments).output().unwrap();
            assert!(output.status.success(), "{}{}", deck.text, String::from_utf8_lossy(&output.stderr));
            let document: Value = serde_json::from_slice(&output.stdout).unwrap();
            let last = document["scenes"][0]["states"].as_array().unwrap().last().unwrap();
            let text = last["connectors"][0].to_string();
            let most = deck.differences[0].largest;
            let has = |x: f64| numbers_in(&last["connectors"][0]).iter().any(|y| (x - y).abs() <= most);
            assert!(of.entry == "Δγ" || has(of.want.0), "{} {:e}: {text}", of.entry, of.want.0);
        }
    }
    println!("{same} to the bit, {near} near, {beyond} beyond the limit");
    assert!(same > 60 && near > 20 && beyond > 3, "{same} {near} {beyond}");
    // History is no state.
    let (_, recorded) = drawn_frictions().swap_remove(0);
    let mut document = serde_json::to_value(&recorded).unwrap();
    document["values"]["before"]["accumulated_slip"] = serde_json::json!("0x1p+0");
    let slid = Example::Other(Box::new(serde_json::from_value(document).unwrap()));
    let said = slid.deck().unwrap_err().to_string();
    assert!(said.contains("no history but its states") && said.contains("--export jax"), "{said}");
}

/// Every number in a document.
fn numbers_in(value: &Value) -> Vec<f64> {
    match value {
        Value::Number(x) => x.as_f64().into_iter().collect(),
        Value::Array(all) => all.iter().flat_map(numbers_in).collect(),
        Value::Object(all) => all.values().flat_map(numbers_in).collect(),
        _ => Vec::new(),
    }
}

/// Every kind of counter-example in every form: each has a Rust test, which passes for the product is right; what a refusal of another form
/// advises works; scripts confirm what must be.
#[test]
fn every_counter_example_has_a_form() {
    let python = python();
    let mut all = of_connectors();
    let named = |all: &[Example], against: &str| {
        all.iter().any(|example| matches!(example, Example::Connector(of) if of.against == against))
    };
    for oracle in Oracle::ALL {
        assert!(named(&all, oracle.name()), "{}", oracle.name());
    }
    assert!(
        all.iter().filter(|example| matches!(example, Example::Connector(of) if of.law.is_some())).count()
            > 4
    );
    // What is missing, what must not be there, what a history loses and what is of a law without a demand.
    let case = wound("BEAM");
    let state = CounterExample::record(&case, Against::Law(Invariant::Restored));
    let lost = CounterExample {
        quantity: Some(Quantity::FirstDerivatives),
        want: Hex(f64::NAN),
        law: None,
        ..state.clone()
    };
    let lost =
        CounterExample {
            against: "wide-differences".into(), entry: "∂u1/∂xb1 is missing".into(), ..lost
        };
    all.extend([state, lost].map(|example| Example::Connector(Box::new(example))));
    all.extend(others().into_iter().map(|recorded| Example::Other(Box::new(recorded))));
    all.extend(constraints().into_iter().map(|(_, recorded)| Example::Other(Box::new(recorded))));
    // Of frictions by JAX, whose names of forces are its own.
    let report = friction_of_jax();
    all.extend(report);
    let mut tests = Vec::new();
    let (mut scripts, mut refusals) = (0, 0);
    for (n, example) in all.iter().enumerate() {
        // As it is read from a file.
        let text = serde_json::to_string(example).unwrap();
        let again = Example::read(&text).unwrap();
        tests.push((format!("case_{n}"), again.rust().unwrap_or_else(|error| panic!("{error}: {text}"))));
        let [jax, deck] = [again.jax().err(), again.deck().map(|_| ()).err()];
        for refused in [&jax, &deck].into_iter().flatten() {
            refusals += 1;
            let said = refused.to_string();
            assert!(said.contains("--export rust"), "{said}");
            assert_eq!(said.contains("--export jax"), jax.is_none(), "{said}");
            assert_eq!(said.contains("--export inp"), deck.is_none(), "{said}");
        }
        // Of other numbers scripts are run elsewhere.
        let is_run = match &again {
            Example::Connector(of) => !of.sum.is_empty(),
            Example::Other(of) => matches!(of.kind, Kind::Friction | Kind::Belt),
        };
        if let (Some(python), Ok(script), true) = (&python, again.jax(), is_run) {
            scripts += 1;
            let (passes, said) = run_script(python, &format!("every_{n}"), &script);
            assert!(passes && said.contains("JAX confirms"), "{text}: {said}");
        }
    }
    assert!(refusals > 5, "{refusals}");
    assert!(python.is_none() || scripts >= 3, "{scripts}");
    let (failed, said) = run_tests("every", &tests);
    assert!(failed.is_empty(), "{failed:?} {said}");
}

/// What JAX calls wrong of predefined friction, of each kind of number.
fn friction_of_jax() -> Vec<Example> {
    let planted = |planted: Planted| Settings {
        planted: Some(planted),
        oracles: [Oracle::Jax].into(),
        states: 1,
        wide_states: 0,
        atlas: false,
        ..Settings::default()
    };
    let mut found: Vec<Example> = Vec::new();
    for planted in [Planted::WrongEntry, Planted::WrongFriction].map(planted) {
        for subject in audit_catalogue(&planted, &|_| {}).subjects {
            let wrong = subject.checks.iter().filter(|check| check.verdict.is_mismatch());
            let of = wrong.filter_map(|check| Example::of(check, &subject.name));
            found.extend(of.filter(|example| matches!(example, Example::Other(_))).take(1));
        }
    }
    // The forces of the same states, which nothing is planted in, by their names.
    let forces = |example: &Example| match example {
        Example::Other(of) => ["f1", "Δγ", "F_N", "m3"].map(|entry| {
            let of =
                Recorded { quantity: Some(Quantity::FrictionForce), entry: entry.into(), ..(**of).clone() };
            let want = Hex(of.number().unwrap());
            Example::Other(Box::new(Recorded { want, ..of }))
        }),
        Example::Connector(_) => unreachable!("it is of a friction"),
    };
    assert!(!found.is_empty());
    let more: Vec<Example> = found.iter().take(1).flat_map(forces).collect();
    found.truncate(4);
    found.extend(more);
    found
}

/// A row that is wrong by little is found along a direction by the Rust test that is written of Taylor's remainder, and by the script.
#[test]
fn a_wrong_row_has_too_large_a_remainder() {
    let settings = Settings {
        oracles: [Oracle::Taylor].into(),
        planted: Some(Planted::WrongEntry),
        ..Settings::default()
    };
    let case = wound("UJOINT");
    let checks = audit_case(&case, &settings, true, 0);
    let wrong = checks.iter().find(|check| check.against == Against::Oracle(Oracle::Taylor)).unwrap();
    let example = CounterExample::of(wrong, "a test").unwrap();
    // The product is right.
    let units = example.remainder().unwrap();
    assert!(units <= 1.0 && example.got.0 > 1e3 * example.tolerance.0, "{units} {}", example.got);
    // A test with another bound fails, so that what it compares is that number.
    let text = example.rust().unwrap();
    let never = text.replacen("got <= 1.0", "got < 0.0", 1);
    assert_ne!(text, never);
    let (failed, said) = run_tests("taylor", &[("right".into(), text), ("never".into(), never)]);
    assert_eq!(failed, ["never"], "{said}");
    let without = CounterExample { sum: Vec::new(), ..example };
    assert!(without.rust().unwrap_err().to_string().contains("along a direction"));
}

/// What is audited in a deck is shrunk to what a deck can hold, and to values of which each is known: what is written replays without
/// the fault, in every form that it has.
#[test]
fn what_is_shrunk_can_be_handed_over() {
    let mut count = 0;
    for (scene, plant, oracles) in [
        ("gallery:slider_crank", "wrong-friction", "wide-differences"),
        ("gallery:slider_crank", "wrong-entry", "taylor"),
        ("gallery:seat_belt", "wrong-entry", "wide-differences"),
    ] {
        let found = folder().join(format!("shrunk-{plant}-{oracles}"));
        fs::remove_dir_all(&found).ok();
        let path = found.to_str().unwrap();
        let arguments = [
            "audit",
            scene,
            "--plant",
            plant,
            "--oracles",
            oracles,
            "--wide-states",
            "2",
            "--counter-examples",
            path,
        ];
        assert_eq!(pintle(&arguments).output().unwrap().status.code(), Some(1), "{scene} {plant}");
        for file in fs::read_dir(&found).unwrap().map(|entry| entry.unwrap().path()) {
            count += 1;
            let text = fs::read_to_string(&file).unwrap();
            let example = Example::read(&text).unwrap();
            assert!(example.rust().is_ok(), "{text}");
            let name = file.to_str().unwrap();
            let is_connector = matches!(example, Example::Connector(_));
            if let (true, Err(error)) = (is_connector, example.deck()) {
                panic!("{error} {text}");
            }
            // All others, and some of these.
            if is_connector && count % 8 != 1 {
                continue;
            }
            let output = pintle(&["replay", name]).output().unwrap();
            let said = String::from_utf8_lossy(&output.stdout).into_owned();
            assert!(output.status.success() && !said.contains("NaN"), "{name}: {said}");
        }
    }
    assert!(count >= 6, "{count}");
}

/// What has no such form says which it has.
#[test]
fn what_has_no_script_or_deck_says_what_there_is() {
    for recorded in others() {
        let example = Example::Other(Box::new(recorded.clone()));
        // A friction of a type has both, a belt a script.
        let refused = [example.jax().err(), example.deck().err()];
        let count = refused.iter().flatten().count();
        let wanted = [(Kind::Friction, 0), (Kind::Belt, 1), (Kind::Slopes, 2)];
        assert!(wanted.contains(&(recorded.kind, count)), "{} {count}", recorded.kind.name());
        for refused in refused.into_iter().flatten() {
            let said = refused.to_string();
            assert!(said.contains(recorded.kind.name()) && said.contains("--export rust"), "{said}");
        }
        let unknown = Recorded { entry: "CSF9".into(), ..recorded };
        assert!(unknown.rust().unwrap_err().to_string().contains("CSF9 is no number of its"));
    }
    let (_, recorded) = constraints().swap_remove(3);
    let text = serde_json::to_string(&recorded).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    document["values"]["constraint"]["axes"][0] = serde_json::json!(["0x0p+0", "0x0p+0", "0x1p+1"]);
    let stretched: Recorded = serde_json::from_value(document).unwrap();
    assert!(stretched.deck().unwrap_err().to_string().contains("not of unit length"));
}

/// A pair, by the command line, in every form: the counter-example of a wrong candidate.
#[test]
fn the_command_line_exports() {
    let report = spoiled("REVOLUTE", |_, rows| rows[3].as_mut().unwrap()[10] = 0.0);
    let check = report.subjects[0].checks.iter().find(|check| check.verdict.is_mismatch()).unwrap();
    let example = CounterExample::of(check, "a \"candidate\"\n*/ '''\u{7}").unwrap();
    assert_eq!(example.entry, format!("∂ur1/∂{}", DOF[10]));
    let file = folder().join("counter-example.json");
    fs::write(&file, serde_json::to_string(&example).unwrap()).unwrap();
    let replay = |form: &str, more: &[&str]| {
        let arguments = [&["replay", file.to_str().unwrap(), "--export", form], more].concat();
        let output = pintle(&arguments).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let (code, text, said) = replay("rust", &[]);
    assert_eq!((code, text.as_str()), (Some(0), example.rust().unwrap().as_str()), "{said}");
    // The product is right, only the candidate was wrong.
    let (failed, said) = run_tests("candidate", &[("candidate".to_string(), text)]);
    assert!(failed.is_empty(), "{said}");
    let (code, text, said) = replay("jax", &[]);
    assert_eq!((code, text.as_str()), (Some(0), example.jax().unwrap().as_str()), "{said}");
    if let Some(python) = python() {
        let (passes, said) = run_script(&python, "candidate", &text);
        assert!(passes && said.contains("JAX confirms"), "{said}");
    }
    let deck = folder().join("candidate.inp");
    let (code, text, said) = replay("inp", &["-o", deck.to_str().unwrap()]);
    assert_eq!((code, text.as_str()), (Some(0), ""), "{said}");
    assert!(!evaluated(&deck, &folder().join("candidate.states.json")).is_empty());
    let (code, _, said) = replay("inp", &[]);
    assert!(code == Some(2) && said.contains("-o FILE.inp"), "{said}");
    let (code, _, said) = replay("rust", &["-o", "no/such/folder/test.rs"]);
    assert!(code == Some(6) && said.contains("no/such/folder/test.rs cannot be written"), "{said}");
    let (code, _, said) = replay("fortran", &[]);
    assert!(code == Some(2) && said.contains("possible values"), "{said}");
}

/// What a form has no place for is refused in one sentence.
#[test]
fn what_cannot_be_exported_is_said() {
    let case = wound("BEAM");
    let law = CounterExample::record(&case, Against::Own);
    assert!(law.rust().unwrap_err().to_string().contains("names no entry"));
    assert!(law.jax().unwrap_err().to_string().contains("names no entry"));
    let moment = exact(&wound("UJOINT"), Quantity::NodalForces, 4, 10);
    assert!(
        moment
            .jax()
            .unwrap_err()
            .to_string()
            .contains("this force is not conjugate to what is differentiated")
    );
    // A friction's number belongs to no connector alone.
    let friction =
        CounterExample {
            quantity: Some(Quantity::FrictionGradient), entry: "∂Φ/∂f1".into(), ..law.clone()
        };
    for refused in [friction.rust().err(), friction.jax().err()] {
        assert!(refused.unwrap().to_string().contains("∂Φ/∂f1: that is no value or derivative"));
    }
    // Turns that no state tells of.
    let mut turned = CounterExample::record(&wound("CARDAN"), Against::Own);
    let case = turned.case().unwrap();
    let mut branch = case.branch_before(&case.connector());
    branch.turns.iter_mut().skip(3).for_each(|turns| turns.turns += 5.0);
    let short = Case { start: Some(branch), path: case.path.last().copied().into_iter().collect(), ..case };
    turned = CounterExample::record(&short, Against::Own);
    let said = turned.deck().unwrap_err().to_string();
    assert!(said.contains("another number of whole turns"), "{said}");
    let mut displaced = CounterExample::record(&wound("BEAM"), Against::Own);
    displaced.connector.initial.flow[0] = Hex(1.0);
    assert!(displaced.deck().unwrap_err().to_string().contains("initial state is displaced"));
    let other = CounterExample { schema: "pintle-eval/1".to_string(), ..displaced };
    for refused in [other.rust().err(), other.jax().err(), other.deck().err()] {
        assert!(refused.unwrap().to_string().contains("pintle-counterexample/1"));
    }
}
