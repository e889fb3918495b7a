//! Whether exported programs give the numbers of `pintle eval`, in every language, for every type, to rounding.

use crate::tolerance::EXPORT;
use pintle_audit::case::quantity::{Numbers, Quantity};
use pintle_audit::sampling::{Region, draw_case, random_case};
use pintle_audit::singular::atlas;
use pintle_audit::{Against, Check, Oracle, Settings, Verdict, audit_catalogue};
use pintle_audit::{Bound, Case};
use pintle_kinematics::catalog::{ConnectionType, Contact, Friction, TABLE};
use pintle_kinematics::connector::{Increment, Request, State, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::History;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::vector;
use pintle_model::behavior::friction::{
    Belt, Coefficient, Context, Criterion, Derivatives, Point, StickStiffness,
};
use pintle_report::export::{Export, Routine, Target, identifier};
use pintle_symbolic::{Frame, Function, Shape, nodal_inputs, relative_inputs};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

/// What an entry must be, and its tolerance; none where `eval` does not say.
type Want = Option<(f64, f64)>;

/// A routine at some states: its inputs, and what each result must be, where `eval` says so, with its tolerance.
struct Job {
    module: String,
    prefix: String,
    routine: String,
    /// Name, shape, first input and count of each parameter.
    takes: Vec<(Shape, usize)>,
    shapes: Vec<Vec<usize>>,
    states: Vec<Vec<f64>>,
    wants: Vec<Vec<Want>>,
}

/// Regular and near-singular states of a type.
fn states(connection: &ConnectionType, near: usize) -> Vec<Case> {
    let draw = &mut Draw::new(&format!("export {}", connection.name));
    let mut found: Vec<Case> = Vec::new();
    for region in [Region::Aligned, Region::Misaligned] {
        found.extend(draw_case(connection, region, draw));
    }
    found.extend(random_case(connection, draw));
    found.extend((0..near).filter_map(|_| atlas::random_near(connection, draw)));
    found
}

/// The state seen from a: d and Q as those of nodes of which a is at rest.
fn from_a(pair: &Pair<f64>) -> Pair<f64> {
    let relative = pair.relative();
    let node = |displacement, triad, flow| Node { displacement, triad, flow };
    Pair {
        reference: [0.0; 3],
        a: node([0.0; 3], vector::identity(), relative.flow[0]),
        b: node(relative.d, relative.q, relative.flow[1]),
    }
}

/// The columns of nodal derivatives that are the relative ones while a is at rest.
const RELATIVE: [usize; 8] = [7, 8, 9, 10, 11, 12, 6, 13];

/// Inputs, and values, rows and second derivatives as `eval` has them.
fn sample(connection: &ConnectionType, frame: Frame, case: &Case) -> (Vec<f64>, [Vec<Want>; 3]) {
    let connector = case.connector();
    let end = case.last().unwrap();
    let branch = connector.advance(&end.state, &end.increment, &case.branch_before(&connector));
    let pair = if frame == Frame::Relative { from_a(&end.state.pair) } else { end.state.pair };
    let state = State { pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
    let evaluation = connector.evaluate(
        &state,
        &Increment::none(),
        &branch,
        &Request::everything(2),
        &mut Tally::default(),
    );
    let history = History {
        rotation_vector: evaluation.branch.rotation_vector,
        euler_sign: evaluation.branch.euler_sign,
        torsion_turns: evaluation.branch.torsion.turns,
    };
    let inputs = match frame {
        Frame::Nodal => nodal_inputs(&pair, connector.section(), &history),
        Frame::Relative => relative_inputs(&pair.relative(), connector.section(), &history),
    };
    let numbers = Numbers::of(&evaluation);
    let nearness = pintle_audit::oracles::oracle::Narrow::of(case).unwrap().nearness();
    let bound = Bound::new(&numbers, &state, case.length, nearness);
    let columns: Vec<usize> = if frame == Frame::Relative { RELATIVE.into() } else { (0..DOFS).collect() };
    let (mut values, mut rows, mut second) = (Vec::new(), Vec::new(), Vec::new());
    for function in Function::of(connection) {
        let (k, measure) = (function.component, function.measure);
        let is_row = connector.differentiated(k) == Some(measure);
        if !measure.is_one_form() {
            let value = if function.is_constraint {
                evaluation.residual[k].filter(|_| is_row)
            } else if measure.winds() {
                evaluation.turns[k].map(|turns| turns.principal)
            } else {
                evaluation.position[k]
            };
            // The tolerance of an entry is that of what is differentiated.
            let tolerance = bound.tolerance(Quantity::Value, k, 0);
            values.push(
                value
                    .filter(|_| is_row)
                    .map(|value| (value, tolerance.max(4.0 * pintle_kinematics::scalar::U * value.abs()))),
            );
        }
        for j in &columns {
            let entry = evaluation.jacobian[k].filter(|_| is_row);
            rows.push(entry.map(|row| (row[*j], bound.tolerance(Quantity::FirstDerivatives, k, *j))));
            for l in &columns {
                let entry = evaluation.hessian[k].as_ref().filter(|_| is_row);
                let place = j * DOFS + l;
                second.push(
                    entry.map(|matrix| {
                        (matrix[*j][*l], bound.tolerance(Quantity::SecondDerivatives, k, place))
                    }),
                );
            }
        }
    }
    (inputs, [values, rows, second])
}

fn takes(routine: &Routine<'_>) -> Vec<(Shape, usize)> {
    routine.takes.iter().map(|input| (input.shape, input.first as usize)).collect()
}

fn shapes(routine: &Routine<'_>) -> Vec<Vec<usize>> {
    routine.gives.iter().map(|output| output.shape.clone()).collect()
}

/// What friction is at some forces, with the parameters 0.5, 0.75, 1 … and a positive internal contact force; `bare`, those that may
/// be left out are zero.
fn friction(
    friction: &Friction,
    which: usize,
    bare: bool,
    draw: &mut Draw,
) -> (Vec<f64>, Point<Derivatives<f64>>, usize) {
    let mu = 0.3;
    if friction.criteria[which].contact == Contact::Belt {
        let belt = Belt {
            coefficient: Coefficient::Constant(mu),
            maximum: None,
            stick_stiffness: StickStiffness::Given(1.0),
        };
        let (tension, angle) = ([draw.between(1.0, 9.0), draw.between(1.0, 9.0)], draw.between(0.1, 3.0));
        return (vec![tension[0], tension[1], angle, mu], belt.derivatives(tension, angle, mu).0, 3);
    }
    let number =
        |i: usize| if bare && !friction.parameters[i].required { 0.0 } else { 0.5 + 0.25 * i as f64 };
    let parameters: Vec<f64> = (0..friction.parameters.len()).map(number).collect();
    let given: Vec<Option<f64>> = parameters.iter().copied().map(Some).collect();
    let criteria = Criterion::predefined(friction, &given, &[], false).unwrap();
    let forces: [f64; 6] = std::array::from_fn(|_| draw.between(-5.0, 5.0));
    let angles = [draw.between(-1.0, 1.0), draw.between(-1.0, 1.0)];
    let mut context = Context::default();
    (context.position[3], context.position[4]) = (angles[0], angles[1]);
    let (point, _) = criteria[which].derivatives(&forces, mu, None, &context);
    let constants = friction.constants.iter().map(|constant| constant.value);
    let inputs = forces.into_iter().chain(angles).chain([mu]).chain(parameters).chain(constants);
    (inputs.collect(), point, 6)
}

/// Every routine of every type, at `near` near-singular states besides the regular ones.
fn jobs(frame: Frame, near: usize, most: usize) -> Vec<(Export, Vec<Job>)> {
    let of_type = |connection: &ConnectionType| {
        let export = Export::of(connection, frame).unwrap();
        let mut cases = states(connection, near);
        cases.truncate(most);
        let mut samples: Vec<_> = cases.iter().map(|case| sample(connection, frame, case)).collect();
        let mut jobs = Vec::new();
        for routine in export.routines() {
            let part = ["values", "jacobian", "hessian"].iter().position(|name| *name == routine.name);
            let draw = &mut Draw::new(&routine.name);
            let (states, wants) = match part {
                Some(part) => samples
                    .iter_mut()
                    .map(|(inputs, wants)| (inputs.clone(), std::mem::take(&mut wants[part])))
                    .unzip(),
                None => (0..most)
                    .map(|state| {
                        let data = connection.friction.unwrap();
                        let which =
                            routine.name.strip_prefix("friction_").unwrap().parse::<usize>().unwrap() - 1;
                        let (inputs, point, count) = friction(&data, which, state % 3 == 1, draw);
                        let scale = point.tangential.value + point.normal.value + 10.0;
                        let with = |x: f64| Some((x, 8.0 * pintle_kinematics::scalar::U * scale));
                        let values = [&point.tangential, &point.contact, &point.normal, &point.criterion];
                        let mut wants: Vec<_> = values.iter().map(|of| with(of.value)).collect();
                        wants.extend(point.criterion.gradient[..count].iter().map(|x| with(*x)));
                        for row in &point.criterion.hessian[..count] {
                            wants.extend(row[..count].iter().map(|x| with(*x)));
                        }
                        (inputs, wants)
                    })
                    .unzip(),
            };
            jobs.push(Job {
                module: identifier(&connection.name),
                prefix: format!("pintle_{}_", identifier(&connection.name)),
                routine: routine.name.clone(),
                takes: takes(&routine),
                shapes: shapes(&routine),
                states,
                wants,
            });
        }
        (export, jobs)
    };
    TABLE.iter().map(of_type).collect()
}

/// Compares results, state by state, and gives the largest error in units of the tolerance.
fn compare<'a>(jobs: impl Iterator<Item = &'a Job>, results: &mut impl Iterator<Item = f64>) -> f64 {
    let mut largest = 0.0_f64;
    let mut compared = 0;
    for job in jobs {
        for (state, wants) in job.wants.iter().enumerate() {
            for (place, want) in wants.iter().enumerate() {
                let got = results.next().expect("a result for each entry");
                let Some((want, tolerance)) = want else { continue };
                compared += 1;
                let units = if got == *want { 0.0 } else { (got - want).abs() / tolerance };
                assert!(
                    units <= EXPORT,
                    "{} {}, state {state}, entry {place}: {got:?} is not {want:?}, {units:.1} units",
                    job.module,
                    job.routine
                );
                largest = largest.max(units);
            }
        }
    }
    assert!(results.next().is_none(), "a result too many");
    assert!(compared > 10_000, "{compared} entries");
    largest
}

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("export-{name}"));
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs a command; `None`, with a word about it, where the program is not installed.
fn run(command: &mut Command, purpose: &str) -> Option<String> {
    let output = match command.output() {
        Ok(output) => output,
        Err(error) => {
            assert!(env::var_os("CI").is_none(), "CI has no {:?}", command.get_program());
            eprintln!(
                "SKIPPED: {:?} cannot be run ({error}), so {purpose} is not tested",
                command.get_program()
            );
            return None;
        }
    };
    assert!(output.status.success(), "{purpose}: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8(output.stdout).unwrap())
}

fn numbers(of: &[f64]) -> String {
    of.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ")
}

fn run_c(frame: Frame) -> Option<f64> {
    let folder = folder(&format!("c-{}", frame.name()));
    let all = jobs(frame, 3, 6);
    let (mut main, mut calls) = (String::from("#include <stdio.h>\n"), String::new());
    let mut sources = Vec::new();
    for (export, jobs) in &all {
        let mut source = export.write(Target::C);
        let module = &jobs[0].module;
        let _ = write!(
            source,
            "\n#include <stdio.h>\nvoid run_{module}(void);\nvoid run_{module}(void)\n{{\n    int s, i;\n"
        );
        for job in jobs {
            let inputs = job.states[0].len();
            let rows: Vec<String> =
                job.states.iter().map(|state| format!("{{{}}}", numbers(state))).collect();
            let _ = writeln!(
                source,
                "    {{ static const double in[{}][{inputs}] = {{{}}};",
                rows.len(),
                rows.join(", ")
            );
            let mut arguments: Vec<String> = job
                .takes
                .iter()
                .map(|(shape, first)| {
                    if *shape == Shape::Scalar {
                        format!("in[s][{first}]")
                    } else {
                        format!("&in[s][{first}]")
                    }
                })
                .collect();
            let mut print = String::new();
            for (o, shape) in job.shapes.iter().enumerate() {
                let extents: String = shape.iter().map(|n| format!("[{n}]")).collect();
                let count: usize = shape.iter().product();
                let _ = writeln!(source, "    static double o{o}{extents};");
                arguments.push(format!("o{o}"));
                let _ = write!(
                    print,
                    "for (i = 0; i < {count}; ++i) printf(\"%.17g\\n\", ((double *)o{o})[i]); "
                );
            }
            let call = format!("{}{}({});", job.prefix, job.routine, arguments.join(", "));
            let _ = writeln!(
                source,
                "    for (s = 0; s < {}; ++s) {{ (void)in; {call} {print}}} }}",
                job.states.len()
            );
        }
        source.push_str("}\n");
        let path = folder.join(format!("{module}.c"));
        fs::write(&path, source).unwrap();
        sources.push(path);
        let _ = writeln!(main, "void run_{module}(void);");
        let _ = writeln!(calls, "    run_{module}();");
    }
    let _ = write!(main, "int main(void)\n{{\n{calls}    return 0;\n}}\n");
    let path = folder.join("main.c");
    fs::write(&path, main).unwrap();
    let program = folder.join("program");
    let strict = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror"];
    let mut cc = Command::new(env::var("CC").unwrap_or_else(|_| "cc".into()));
    run(cc.args(strict).args(&sources).arg(&path).arg("-lm").arg("-o").arg(&program), "C")?;
    let output = run(&mut Command::new(&program), "C")?;
    let mut results = output.lines().map(|line| line.parse::<f64>().unwrap());
    Some(compare(all.iter().flat_map(|(_, jobs)| jobs), &mut results))
}

fn run_rust(frame: Frame) -> Option<f64> {
    let folder = folder(&format!("rust-{}", frame.name()));
    let all = jobs(frame, 3, 6);
    let mut main = String::new();
    let mut calls = String::new();
    for (export, jobs) in &all {
        let module = &jobs[0].module;
        let mut source = export.write(Target::Rust);
        source.push_str("\npub fn run() {\n");
        for job in jobs {
            let rows: Vec<String> = job.states.iter().map(|state| format!("[{}]", numbers(state))).collect();
            let _ = writeln!(
                source,
                "    for x in [{}] {{\n        let _: [f64; {}] = x;",
                rows.join(", "),
                job.states[0].len()
            );
            let at = |first: usize, count: usize| {
                (first..first + count).map(|i| format!("x[{i}]")).collect::<Vec<_>>().join(", ")
            };
            let arguments: Vec<String> = job
                .takes
                .iter()
                .map(|(shape, first)| match shape {
                    Shape::Scalar => format!("x[{first}]"),
                    Shape::List(n) => format!("&[{}]", at(*first, *n)),
                    Shape::Matrix => {
                        format!("&[[{}], [{}], [{}]]", at(*first, 3), at(first + 3, 3), at(first + 6, 3))
                    }
                })
                .collect();
            let results: Vec<String> = (0..job.shapes.len()).map(|o| format!("o{o}")).collect();
            let pattern =
                if results.len() == 1 { results.concat() } else { format!("({})", results.join(", ")) };
            let _ = writeln!(source, "        let {pattern} = {}({});", job.routine, arguments.join(", "));
            for (o, shape) in job.shapes.iter().enumerate() {
                let flat = ".flatten()".repeat(shape.len() - 1);
                let _ = writeln!(
                    source,
                    "        for y in o{o}.iter(){flat} {{\n            println!(\"{{y:?}}\");\n        }}"
                );
            }
            source.push_str("    }\n");
        }
        source.push_str("}\n");
        fs::write(folder.join(format!("{module}.rs")), source).unwrap();
        let _ = writeln!(main, "mod {module};");
        let _ = writeln!(calls, "    {module}::run();");
    }
    let _ = write!(main, "\nfn main() {{\n{calls}}}\n");
    let path = folder.join("main.rs");
    fs::write(&path, main).unwrap();
    let program = folder.join("program");
    let mut rustc = Command::new(env::var("RUSTC").unwrap_or_else(|_| "rustc".into()));
    run(rustc.args(["--edition", "2021", "-D", "warnings"]).arg(&path).arg("-o").arg(&program), "Rust")?;
    let output = run(&mut Command::new(&program), "Rust")?;
    let mut results = output.lines().map(|line| line.parse::<f64>().unwrap());
    Some(compare(all.iter().flat_map(|(_, jobs)| jobs), &mut results))
}

/// The Python of the witnesses: `PINTLE_PYTHON`, the environment that `scripts/test.sh` makes, or whatever there is.
pub(crate) fn python() -> PathBuf {
    let made = Path::new(env!("CARGO_MANIFEST_DIR")).join(".venv/bin/python");
    env::var_os("PINTLE_PYTHON")
        .map_or_else(|| if made.exists() { made } else { "python3".into() }, PathBuf::from)
}

fn run_python(target: Target, name: &str, frame: Frame, most: usize) -> Option<f64> {
    let has = Command::new(python()).args(["-c", &format!("import {name}")]).output();
    if !has.is_ok_and(|output| output.status.success()) {
        assert!(env::var_os("CI").is_none(), "CI has no {name}");
        eprintln!(
            "SKIPPED: {} has no {name}, so programs for it are not tested; scripts/test.sh sets one up",
            python().display()
        );
        return None;
    }
    let folder = folder(&format!("{name}-{}", frame.name()));
    let all = jobs(frame, 1, most);
    let mut cases = Vec::new();
    for (export, jobs) in &all {
        fs::write(folder.join(format!("{}_{name}.py", jobs[0].module)), export.write(target)).unwrap();
        for job in jobs {
            let state = |inputs: &Vec<f64>| {
                let of = |(shape, first): &(Shape, usize)| {
                    serde_json::json!([&inputs[*first..first + shape.len()], shape.name()])
                };
                job.takes.iter().map(of).collect::<Vec<_>>()
            };
            cases.push(serde_json::json!({
                "module": format!("{}_{name}", job.module),
                "function": job.routine,
                "states": job.states.iter().map(state).collect::<Vec<_>>(),
            }));
        }
    }
    fs::write(folder.join("cases.json"), serde_json::to_string(&cases).unwrap()).unwrap();
    let script = folder.join("run.py");
    fs::write(&script, include_str!("export/run.py")).unwrap();
    let output = run(Command::new(python()).arg(&script).arg(name).arg(&folder), name)?;
    let results: Vec<Vec<Vec<f64>>> = serde_json::from_str(&output).unwrap();
    let mut results = results.into_iter().flatten().flatten();
    Some(compare(all.iter().flat_map(|(_, jobs)| jobs), &mut results))
}

fn report(what: &str, largest: Option<f64>) {
    if let Some(largest) = largest {
        println!("{what}: {largest:.3} of the bound at most");
    }
}

#[test]
fn c_programs_give_the_same_numbers() {
    report("C, relative", run_c(Frame::Relative));
    report("C, nodal", run_c(Frame::Nodal));
}

#[test]
fn rust_programs_give_the_same_numbers() {
    report("Rust, relative", run_rust(Frame::Relative));
    report("Rust, nodal", run_rust(Frame::Nodal));
}

#[test]
fn sympy_programs_give_the_same_numbers() {
    report("SymPy, relative", run_python(Target::Sympy, "sympy", Frame::Relative, 4));
    report("SymPy, nodal", run_python(Target::Sympy, "sympy", Frame::Nodal, 2));
}

#[test]
fn jax_programs_give_the_same_numbers() {
    report("JAX, relative", run_python(Target::Jax, "jax", Frame::Relative, 4));
    report("JAX, nodal", run_python(Target::Jax, "jax", Frame::Nodal, 1));
}

#[test]
fn latex_is_balanced() {
    for connection in TABLE {
        let text = Export::of(connection, Frame::Relative).unwrap().write(Target::Latex);
        let mut depth = 0_i32;
        for c in text.lines().filter(|line| !line.starts_with('%')).flat_map(str::chars) {
            depth += i32::from(c == '{') - i32::from(c == '}');
            assert!(depth >= 0, "{}", connection.name);
        }
        assert_eq!(depth, 0, "{}", connection.name);
        let count = |what: &str| text.matches(what).count();
        assert_eq!(count("\\begin{"), count("\\end{"), "{}", connection.name);
        assert!(
            text.lines().filter(|line| !line.starts_with('%')).all(|line| line.is_ascii()),
            "{}",
            connection.name
        );
    }
}

#[test]
fn the_picture_is_that_of_the_program() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/explanation/revolute.dot");
    let revolute = Export::of(&ConnectionType::named("REVOLUTE", None).unwrap(), Frame::Relative).unwrap();
    assert_eq!(
        fs::read_to_string(path).unwrap(),
        revolute.graphviz(),
        "draw docs/explanation/revolute.svg again"
    );
}

#[test]
fn bad_input_is_named() {
    let pintle = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_pintle")).args(arguments).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    for (arguments, code, said) in [
        (&["export", "REVOLUT", "--as", "c"][..], 2, "did you mean REVOLUTE?"),
        (&["export", "HINGE", "JOIN", "--as", "c"], 2, "HINGE and JOIN do not pair"),
        (&["export", "HINGE", "--as", "fortran"], 2, "possible values"),
        (&["export", "HINGE"], 2, "--as"),
        (
            &["export", "HINGE", "--as", "c", "-o", "no/such/folder/hinge.c"],
            7,
            "cannot write no/such/folder/hinge.c",
        ),
        (&["explain", "MPC", "--format", "latex"], 2, "only connection types have formulas in LaTeX"),
        (
            &["explain", "deck::unknown-node", "--format", "latex"],
            2,
            "only connection types have formulas in LaTeX",
        ),
    ] {
        let (found, stderr) = pintle(arguments);
        assert_eq!(found, Some(code), "{arguments:?}: {stderr}");
        assert!(stderr.contains(said), "{arguments:?}: {stderr}");
    }
}

#[test]
fn a_pair_is_exported_like_its_halves() {
    let pair = ConnectionType::named("CARTESIAN", Some("CARDAN")).unwrap();
    let text = Export::of(&pair, Frame::Relative).unwrap().write(Target::C);
    assert!(
        text.contains(
            "void pintle_cartesian_cardan_values(const double d[3], const double Q[9], double values[6])"
        ),
        "{text}"
    );
}

#[test]
fn traced_derivatives_judge_the_product() {
    let settings = Settings {
        oracles: [Oracle::WideDifferences, Oracle::WideSymbolic, Oracle::Symbolic].into(),
        states: 20,
        near_singular_states: 8,
        wide_states: 3,
        atlas: false,
        ..Settings::default()
    };
    let report = audit_catalogue(&settings, &|_| {});
    let asked = |check: &&Check| matches!(check.against, Against::Oracle(_));
    let answered = |oracle: Oracle| {
        let checks = report.subjects.iter().flat_map(|subject| &subject.checks).filter(asked);
        checks.filter(|check| check.against == Against::Oracle(oracle) && check.compared > 0).count()
    };
    for oracle in [Oracle::WideSymbolic, Oracle::Symbolic] {
        assert_eq!(answered(oracle), 2 * TABLE.len());
    }
    for check in report.subjects.iter().flat_map(|subject| &subject.checks).filter(asked) {
        let twin = (check.verdict, check.worst.clone().map(|worst| worst.entry));
        assert!(check.verdict < Verdict::UnstableFormula, "{twin:?}");
    }
    assert_eq!(report.mismatches(), 0);
}
