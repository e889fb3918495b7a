//! Counter-examples in other forms, each one run: Rust tests are compiled against the crate, scripts go to Python, decks to `pintle
//! eval`.

use crate::audit::counterexample::{of_constraint, others};
use crate::audit::{named, spoiled};
use crate::commands::cli::pintle;
use crate::laws::mpc;
use crate::tolerance::HANDOVER;
use pintle_audit::oracles::oracle::Narrow;
use pintle_audit::replay::counterexample::BrokenLaw;
use pintle_audit::sampling::{Region, draw_case, extent};
use pintle_audit::{
    About, Against, Bound, Case, Check, CounterExample, Hex, Invariant, MpcCase, Oracle, Planted, Quantity,
    Settings, audit_case, audit_catalogue, laws as invariant, product,
};
use pintle_kinematics::catalog::{COMPONENT, TABLE};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{DOF, DOFS};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> PathBuf {
    crate::commands::cli::folder("handover")
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
    let bound = Bound::new(&numbers, &last, case.length, nearness);
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
    assert!(std::env::var_os("CI").is_none(), "CI has no jax");
    eprintln!(
        "SKIPPED: {} has no jax, so scripts for it are not tested; scripts/test.sh sets one up",
        python.display()
    );
    None
}

fn run_script(python: &Path, name: &str, text: &str) -> (bool, String) {
    let path = folder().join(format!("{name}.py"));
    fs::write(&path, text).unwrap();
    // Each is run once: what XLA optimises takes longer than it saves.
    let once = ("XLA_FLAGS", "--xla_backend_optimization_level=0");
    let output = Command::new(python).arg("-I").arg(&path).env(once.0, once.1).output().unwrap();
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
        let bound = Bound::new(&product(&case).unwrap(), &last, case.length, nearness);
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
fn constraints() -> Vec<(MpcCase, CounterExample)> {
    let mut kinds = std::collections::BTreeSet::new();
    // Violated, so that nothing is zero by chance.
    let drawn = mpc::cases().into_iter().filter(|drawn| drawn.name.ends_with('5'));
    let found: Vec<(MpcCase, CounterExample)> =
        drawn.filter(|drawn| kinds.insert(drawn.kind)).map(|drawn| of_constraint(&drawn)).collect();
    assert_eq!(found.len(), pintle_kinematics::mpc::MpcType::ALL.len());
    found
}

/// The largest number of each kind, exactly as the constraint gives it.
fn largest(case: &MpcCase, recorded: &CounterExample) -> Vec<CounterExample> {
    let mut found = Vec::new();
    for table in case.tables() {
        let largest = table.entries.iter().max_by(|x, y| x.got.abs().total_cmp(&y.got.abs())).unwrap();
        let of = CounterExample {
            quantity: Some(table.quantity),
            entry: largest.name.clone(),
            want: Hex(largest.got),
            tolerance: Hex(0.0),
            ..recorded.clone()
        };
        assert_eq!(of.number().unwrap().to_bits(), largest.got.to_bits(), "{} {}", of.subject, of.entry);
        found.push(of);
    }
    found
}

/// Tests of constraints, frictions, belts and tables give the same bits: with no tolerance they pass, and one digit away they fail.
#[test]
fn what_is_no_connector_is_a_rust_test() {
    let constraints = constraints();
    let all = constraints.iter().flat_map(|(case, recorded)| largest(case, recorded));
    let other = |recorded: CounterExample| {
        let want = Hex(recorded.number().unwrap());
        CounterExample { want, tolerance: Hex(0.0), ..recorded }
    };
    let all: Vec<CounterExample> = all.chain(others().into_iter().map(other)).collect();
    let (mut right, mut wrong) = (Vec::new(), Vec::new());
    for recorded in all.into_iter().filter(|recorded| recorded.want.0 != 0.0) {
        let module = format!("case_{}", right.len());
        right.push((module.clone(), recorded.rust().unwrap()));
        let off = CounterExample { want: Hex(recorded.want.0.next_up()), ..recorded };
        wrong.push((module, off.rust().unwrap()));
    }
    // Linear equations have no second derivatives.
    assert!(right.len() >= 28, "{}", right.len());
    let (failed, said) = run_tests("no_connectors", &right);
    assert!(failed.is_empty(), "{said}");
    let (failed, said) = run_tests("wrong_no_connectors", &wrong);
    assert_eq!(failed.len(), wrong.len(), "{said}");
}

/// Counter-examples of connectors by every oracle that calls a number wrong, and every law: of faults planted in first derivatives, in second
/// ones and in nodal forces, at states of several types.
fn of_connectors() -> Vec<CounterExample> {
    let mut found: Vec<CounterExample> = Vec::new();
    let mut against = std::collections::BTreeSet::new();
    let mut add = |check: &Check, name: &str| {
        if check.verdict.is_mismatch() && against.insert((check.quantity, check.against)) {
            found.push(CounterExample::of(check, name).unwrap_or_else(|| panic!("{check:?}")));
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

/// Every kind of counter-example in every form: each has a Rust test, which passes for the product is right; what a refusal of another form
/// advises works; scripts confirm what must be.
#[test]
fn every_counter_example_has_a_form() {
    let python = python();
    let mut all = of_connectors();
    let named = |all: &[CounterExample], against: &str| {
        all.iter().any(|example| example.kind == About::Connector && example.against == against)
    };
    for oracle in Oracle::ALL {
        assert!(named(&all, oracle.name()), "{}", oracle.name());
    }
    assert!(all.iter().filter(|example| example.law.is_some()).count() > 4);
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
    all.extend([state, lost]);
    all.extend(others());
    all.extend(constraints().into_iter().map(|(_, recorded)| recorded));
    // Of frictions by JAX, whose names of forces are its own.
    let report = friction_of_jax();
    all.extend(report);
    let mut tests = Vec::new();
    let (mut scripts, mut refusals) = (0, 0);
    for (n, example) in all.iter().enumerate() {
        // As it is read from a file.
        let text = serde_json::to_string(example).unwrap();
        let again = CounterExample::read(&text).unwrap();
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
        let is_run = again.kind == About::Connector && !again.sum.is_empty();
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
fn friction_of_jax() -> Vec<CounterExample> {
    let planted = |planted: Planted| Settings {
        planted: Some(planted),
        oracles: [Oracle::Jax].into(),
        states: 1,
        wide_states: 0,
        atlas: false,
        ..Settings::default()
    };
    let mut found: Vec<CounterExample> = Vec::new();
    for planted in [Planted::WrongEntry, Planted::WrongFriction].map(planted) {
        for subject in audit_catalogue(&planted, &|_| {}).subjects {
            let wrong = subject.checks.iter().filter(|check| check.verdict.is_mismatch());
            let of = wrong.filter_map(|check| CounterExample::of(check, &subject.name));
            found.extend(of.filter(|example| example.kind != About::Connector).take(1));
        }
    }
    // The forces of the same states, which nothing is planted in, by their names.
    let forces = |example: &CounterExample| {
        ["f1", "Δγ", "F_N", "m3"].map(|entry| {
            let quantity = Some(Quantity::FrictionForce);
            let of = CounterExample { quantity, entry: entry.into(), ..example.clone() };
            CounterExample { want: Hex(of.number().unwrap()), ..of }
        })
    };
    assert!(!found.is_empty());
    let more: Vec<CounterExample> = found.iter().take(1).flat_map(forces).collect();
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

/// What is audited in a deck is shrunk to what a deck can hold, and to values of which each is known. What is written replays without the fault,
/// in every form that it has.
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
            let example = CounterExample::read(&text).unwrap();
            assert!(example.rust().is_ok(), "{text}");
            let name = file.to_str().unwrap();
            let is_connector = example.kind == About::Connector;
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

/// Scripts and decks are of connectors: of anything else they are refused with the one form that there is.
#[test]
fn what_is_no_connector_has_a_rust_test_alone() {
    let constraints = constraints().into_iter().map(|(_, recorded)| recorded);
    let all: Vec<CounterExample> = others().into_iter().chain(constraints).collect();
    for recorded in &all {
        for refused in [recorded.jax().err(), recorded.deck().err()] {
            let said = refused.unwrap().to_string();
            let wanted =
                format!("scripts and decks are of connectors, and this is of a {}", recorded.kind.name());
            assert!(said.starts_with(&wanted) && said.contains("--export rust"), "{said}");
            assert!(!said.contains("--export jax") && !said.contains("--export inp"), "{said}");
        }
        let unknown = CounterExample { entry: "CSF9".into(), ..recorded.clone() };
        assert!(unknown.rust().unwrap_err().to_string().contains("CSF9 is no number of its"));
    }
    assert!(all.len() > 3 + 5, "{}", all.len());
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
    assert!(code == Some(7) && said.contains("cannot write no/such/folder/test.rs"), "{said}");
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
    displaced.values["definition"]["initial"]["a"]["flow"] = Hex(1.0).to_string().into();
    assert!(displaced.deck().unwrap_err().to_string().contains("initial state is displaced"));
    let other = CounterExample { schema: "pintle-eval/1".to_string(), ..displaced };
    for refused in [other.rust().err(), other.jax().err(), other.deck().err()] {
        assert!(refused.unwrap().to_string().contains("pintle-counterexample/2"));
    }
}
