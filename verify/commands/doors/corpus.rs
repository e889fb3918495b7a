//! Every wrong routine of the corpus through every door: the report is that of the check in process, word for word.
//!
//! In process each question is taken on a tape with its answer. Behind a door a player finds what it is asked there, bit for bit, and
//! gives those very numbers.

use super::{lacks_programs, library};
use crate::commands::cli::pintle;
use crate::diagnosis::{candidates, constraints, corpus, frictions, offers};
use pintle::check::Subject;
use pintle_audit::{
    Candidate, ConstraintCandidate, FrictionCandidate, FrictionCase, Given, MpcCase, Numbers, Quantity,
    Question, Report, Settings, Tangent, initial_places,
};
use pintle_check::OFFERS;
use pintle_kinematics::connector::{Connector, Definition};
use pintle_kinematics::mpc::{Evaluation, PHI};
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::so3::{log, quaternion};
use pintle_kinematics::vector::{Matrix, Vector, add, product, transpose};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::convert::Infallible;
use std::fs;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The player as a Python function, and as a process that answers JSON lines.
const PYTHON: &str = include_str!("play.py");

/// The player as a routine in C.
const C: &str = include_str!("play.c");

/// What is not there, as `pintle_element.h` has it: a NaN that no computation makes.
const NONE: f64 = f64::from_bits(0x7ff8_7069_6e74_6c65);

/// What may be offered, in the order of its bits.
fn names() -> impl Iterator<Item = (&'static str, Quantity)> {
    OFFERS.into_iter().chain([
        ("criterion", Quantity::FrictionCriterion),
        ("gradients", Quantity::FrictionGradient),
        ("friction_forces", Quantity::FrictionForce),
        ("friction_tangent", Quantity::FrictionTangent),
    ])
}

fn bits(quantities: &[Quantity]) -> u32 {
    let of = names().enumerate().filter(|(_, (_, quantity))| quantities.contains(quantity));
    of.map(|(place, _)| 1 << place).sum()
}

/// Answers by what was asked: the bits of what was wanted, and the state in the order of `pintle_element.h`.
#[derive(Default)]
struct Tape(HashMap<Vec<u64>, Vec<f64>>);

impl Tape {
    /// Takes the lines of each quantity that is wanted, in the order of their bits, each with the width of one that is missing.
    fn take(
        &mut self,
        wants: &[Quantity],
        state: &[f64],
        of: impl Fn(Quantity) -> (usize, Vec<Option<Vec<f64>>>),
    ) {
        let question = [f64::from(bits(wants))].iter().chain(state).map(|x| x.to_bits()).collect();
        let mut answer = Vec::new();
        for (_, quantity) in names().filter(|(_, quantity)| wants.contains(quantity)) {
            let (width, lines) = of(quantity);
            answer.extend(lines.into_iter().flat_map(|line| line.unwrap_or_else(|| vec![NONE; width])));
        }
        let of_same = self.0.entry(question).or_insert_with(|| answer.clone());
        let is_same = of_same.iter().map(|x| x.to_bits()).eq(answer.iter().map(|x| x.to_bits()));
        assert!(is_same, "one question has two answers");
    }

    /// Each question with its answer, their length before them.
    fn bytes(&self) -> Vec<u8> {
        let record = |(question, answer): (&Vec<u64>, &Vec<f64>)| {
            let length = (question.len() + answer.len()) as f64;
            let all = [length.to_bits()].into_iter().chain(question.iter().copied());
            all.chain(answer.iter().map(|x| x.to_bits())).flat_map(u64::to_le_bytes).collect::<Vec<u8>>()
        };
        self.0.iter().flat_map(record).collect()
    }
}

/// A routine that was judged in process.
struct Taped {
    /// What it is to be, as `pintle_element.h` names it in capitals.
    kind: &'static str,
    /// The same as the command names it, with options.
    of: String,
    more: Option<String>,
    title: String,
    offers: Vec<Quantity>,
    tape: Tape,
    report: Report,
}

/// How many states: what is not seen at these is not seen through any door.
const HISTORIES: usize = 1;

fn settings() -> Settings {
    Settings { states: 6, near_singular_states: 1, wide_states: 1, atlas: false, ..Settings::default() }
}

/// The numbers of `pintle_node`.
fn node(
    [x, u]: [Vector<f64>; 2],
    triad: &Matrix<f64>,
    rotation: &Matrix<f64>,
    (flow, increment, rates): (f64, Vector<f64>, &[f64]),
) -> Vec<f64> {
    let triad = transpose(triad);
    let rotations = [triad.as_flattened(), &quaternion(rotation), &log(rotation), &[flow], &increment];
    [&add(x, u)[..], &u, &rotations.concat(), rates].concat()
}

const STILL: [f64; 14] = [0.0; 14];

fn pair(pair: &Pair<f64>, initial: &Pair<f64>, turned: [Vector<f64>; 2], rates: [&[f64]; 2]) -> Vec<f64> {
    let of = |end: usize, now: &Node<f64>, first: &Node<f64>, x: Vector<f64>| {
        let rotation = product(&now.triad, &transpose(&first.triad));
        node([x, now.displacement], &now.triad, &rotation, (now.flow, turned[end], rates[end]))
    };
    let [of_a, of_b] = initial_places(initial.reference, false);
    [of(0, &pair.a, &initial.a, of_a), of(1, &pair.b, &initial.b, of_b)].concat()
}

/// The numbers of `pintle_state`.
fn of_question(asked: &Question<'_>, initial: &Pair<f64>) -> Vec<f64> {
    let now = asked.state();
    let has_rates = asked.wants.iter().any(|of| matches!(of, Quantity::Rate | Quantity::Acceleration));
    let rates = [0, 7].map(|at| match has_rates {
        true => [&now.velocity[at..at + 7], &now.acceleration[at..at + 7]].concat(),
        false => STILL.to_vec(),
    });
    let before = asked.before().map_or(*initial, |before| before.pair);
    let values = asked.values_before.map(|x| x.unwrap_or(0.0) + 0.0);
    let now = pair(&now.pair, initial, asked.step.increment.rotation, [&rates[0], &rates[1]]);
    [now, pair(&before, initial, [[0.0; 3]; 2], [&STILL; 2]), values.to_vec()].concat()
}

/// The numbers of `pintle_mpc_state`.
fn of_constraint(case: &MpcCase, wants: &[Quantity]) -> Vec<f64> {
    let state = &case.state;
    let has_rates = wants.iter().any(|of| matches!(of, Quantity::Rate | Quantity::Acceleration));
    let [velocity, acceleration] =
        [state.velocity, state.acceleration].map(|rates| if has_rates { rates } else { [0.0; PHI + 2] });
    let hinges = case.constraint.kind().entry().angles.len();
    let [master, slave] = initial_places(case.constraint.arm(), false);
    let ends = [(&state.slave, slave, 0), (&state.master, master, 7)];
    let mut all: Vec<f64> = ends
        .into_iter()
        .flat_map(|(body, x, at)| {
            let rates = [&velocity[at..at + 7], &acceleration[at..at + 7]].concat();
            node([x, body.displacement], &body.rotation, &body.rotation, (body.flow, [0.0; 3], &rates))
        })
        .collect();
    let angles = state.angles.map(|angle| angle.unwrap_or(0.0));
    for of in [&angles[..], &velocity[PHI..], &acceleration[PHI..]] {
        all.extend((0..2).map(|n| if n < hinges { of[n] } else { 0.0 }));
    }
    all
}

/// The numbers of `pintle_friction_state`.
fn of_friction(case: &FrictionCase) -> Vec<f64> {
    let told = case.told();
    let before = [&told.forces_before[..], &[told.slip_before]].concat();
    [&told.forces[..], &told.displacement, &told.pressing, &before, &told.position, &told.motion].concat()
}

fn definition(connection: &str) -> Definition {
    match pintle::check::subject(connection, None) {
        Ok(Subject::Connector(definition, _)) => *definition,
        other => panic!("{connection}: {other:?}"),
    }
}

fn connector(
    connection: &str,
    title: String,
    offers: &[Quantity],
    spoil: impl Fn(&corpus::Right<'_>, &mut Numbers<f64>),
) -> Taped {
    let definition = definition(connection);
    let mut tape = Tape::default();
    let candidate = Candidate::new("played", &definition).settings(settings()).histories(HISTORIES);
    let report = corpus::heard(&candidate.offers(offers, [true; 6]), &definition, spoil, |asked, numbers| {
        let of = |quantity: Quantity| {
            let lines = numbers.entries(quantity).0.to_vec();
            let width = match quantity {
                Quantity::SecondDerivatives | Quantity::GeometricStiffness => 196,
                Quantity::FirstDerivatives | Quantity::NodalForces => 14,
                _ => 1,
            };
            (width, lines)
        };
        tape.take(asked.wants, &of_question(asked, &definition.initial), of);
    });
    Taped {
        kind: "ELEMENT",
        of: connection.to_string(),
        more: None,
        title,
        offers: offers.to_vec(),
        tape,
        report,
    }
}

fn element((connection, springs, code): offers::Springs) -> Taped {
    let definition = definition(connection);
    let mut tape = Tape::default();
    let gives = [Quantity::ElementForces, Quantity::ElementStiffness];
    let candidate = Candidate::new("played", &definition)
        .settings(settings())
        .histories(HISTORIES)
        .springs(springs, Tangent::OfForces)
        .offers(&gives, [true; 6]);
    let answers = |asked: &[Question<'_>]| {
        let one = |asked: &Question<'_>| {
            let (forces, stiffness) = offers::wrong_element(&definition, asked, &springs, code);
            tape.take(asked.wants, &of_question(asked, &definition.initial), |quantity| match quantity {
                Quantity::ElementForces => (14, vec![Some(forces.to_vec())]),
                _ => (196, vec![Some(stiffness.as_flattened().to_vec())]),
            });
            Some(Given::default().element_forces(forces).element_stiffness(stiffness))
        };
        Ok::<_, Infallible>(asked.iter().map(one).collect())
    };
    let Ok(report) = candidate.try_check(answers);
    let springs = springs.map(|d| d.map_or_else(|| "-".to_string(), |d| d.to_string()));
    let more = Some(format!("--springs={}", springs.join(",")));
    Taped {
        kind: "ELEMENT",
        of: connection.to_string(),
        more,
        title: code.to_string(),
        offers: gives.to_vec(),
        tape,
        report,
    }
}

fn constraint((kind, title, offers, spoil, ..): &constraints::Wrong) -> Taped {
    let of = format!("MPC {}", kind.name());
    let Ok(Subject::Constraint(constraint, _)) = pintle::check::subject(&of, None) else { panic!("{of}") };
    let tape = RefCell::new(Tape::default());
    let candidate = ConstraintCandidate::new("played", &constraint).settings(settings()).offers(offers);
    let report = candidate.check(|case| {
        let mut found: Evaluation<f64> = constraints::right(case);
        spoil(case, &mut found);
        let scalars = |of: &[Option<f64>]| (1, of.iter().map(|x| x.map(|x| vec![x])).collect());
        tape.borrow_mut().take(offers, &of_constraint(case, offers), |quantity| match quantity {
            Quantity::Value => scalars(&found.residual),
            Quantity::Rate => scalars(&found.residual_rate),
            Quantity::Acceleration => scalars(&found.residual_acceleration),
            Quantity::FirstDerivatives => {
                (16, found.jacobian.iter().map(|row| row.map(|row| row.to_vec())).collect())
            }
            _ => {
                let flat = |matrix: &Option<Box<[[f64; 16]; 16]>>| {
                    matrix.as_ref().map(|matrix| matrix.as_flattened().to_vec())
                };
                (256, found.hessian.iter().map(flat).collect())
            }
        });
        found.into()
    });
    Taped {
        kind: "MPC",
        of,
        more: None,
        title: (*title).to_string(),
        offers: offers.to_vec(),
        tape: tape.into_inner(),
        report,
    }
}

fn friction((connection, title, offers, spoil, ..): &frictions::Wrong) -> Taped {
    let of = format!("FRICTION {connection}");
    let Ok(Subject::Friction(subject)) = pintle::check::subject(&of, None) else { panic!("{of}") };
    let tape = RefCell::new(Tape::default());
    let candidate = FrictionCandidate::new("played", &subject).settings(settings()).offers(offers);
    let report = candidate.check(|case| {
        let mut given = case.product();
        spoil(case, &mut given);
        let scalars = |of: &[Option<f64>]| (1, of.iter().map(|x| x.map(|x| vec![x])).collect());
        tape.borrow_mut().take(offers, &of_friction(case), |quantity| match quantity {
            Quantity::FrictionCriterion => scalars(&given.criterion),
            Quantity::FrictionForce => scalars(&given.forces),
            Quantity::FrictionGradient => {
                (6, given.gradients.iter().map(|row| row.map(|row| row.to_vec())).collect())
            }
            _ => (12, given.tangent.iter().map(|row| row.map(|row| row.to_vec())).collect()),
        });
        given
    });
    Taped {
        kind: "FRICTION",
        of,
        more: None,
        title: (*title).to_string(),
        offers: offers.to_vec(),
        tape: tape.into_inner(),
        report,
    }
}

/// All routines of the corpus, each to be judged in process when its turn comes.
fn all() -> Vec<Box<dyn Fn() -> Taped + Sync>> {
    let mut all: Vec<Box<dyn Fn() -> Taped + Sync>> = Vec::new();
    for wrong in corpus::all() {
        all.push(Box::new(|| connector(wrong.connection, wrong.name.to_string(), wrong.offers, wrong.spoil)));
    }
    all.extend(offers::SPRINGS.map(|springs| Box::new(move || element(springs)) as _));
    all.extend(constraints::ALL.iter().map(|wrong| Box::new(|| constraint(wrong)) as _));
    all.extend(frictions::ALL.iter().map(|wrong| Box::new(|| friction(wrong)) as _));
    for connection in ["CARTESIAN", "CARDAN", "UJOINT"] {
        let of = definition(connection);
        for quantity in candidates::GIVEN {
            for code in candidates::codes(&of, quantity) {
                let right = Connector::<f64>::new(&of);
                all.push(Box::new(move || {
                    let title = format!("{} {code}", quantity.name());
                    connector(connection, title, &candidates::GIVEN, |asked, numbers| {
                        if let Some(wrong) = candidates::mistaken(&right, asked.case, quantity, code) {
                            *numbers = wrong;
                        }
                    })
                }));
            }
        }
    }
    all
}

/// What the command is to exit with.
fn code(report: &Report) -> i32 {
    if report.is_verified_wrong() {
        1
    } else if report.is_open() {
        3
    } else {
        0
    }
}

/// How many of the doors a routine goes through. A function in Python waits for NumPy: one of so many is asked for as such.
fn doors_of(place: usize) -> usize {
    if place.is_multiple_of(24) { 3 } else { 2 }
}

/// What doors say otherwise of a routine than the process does.
fn differences(taped: &Taped, place: usize, folder: &Path, tape: &Path) -> Vec<String> {
    let mut found = Vec::new();
    let kind = taped.kind;
    fs::write(tape, taped.tape.bytes()).unwrap();
    let mut report = taped.report.clone();
    // What is asked again asks pintle, not the routine.
    report.subjects.iter_mut().flat_map(|subject| &mut subject.checks).for_each(|check| check.failing = None);
    let mut want = Vec::new();
    pintle_report::audit::json(&mut want, &report).unwrap();
    let want = String::from_utf8(want).unwrap();
    let Settings { states, near_singular_states, wide_states, .. } = settings();
    let numbers = [
        ("states", states),
        ("near-singular-states", near_singular_states),
        ("wide-states", wide_states),
        ("histories", HISTORIES),
    ];
    let numbers = numbers.map(|(option, count)| format!("--{option}={count}"));
    let offers: Vec<&str> =
        names().filter(|(_, of)| taped.offers.contains(of)).map(|(name, _)| name).collect();
    let library = format!("./{kind}.so");
    let doors = [
        (["--with", "exec python3 -S play.py"], "played"),
        (["--library", &library], &format!("pintle_{}", kind.to_lowercase())),
        (["--python", "play:play"], "play:play"),
    ];
    for (door, name) in doors.into_iter().take(doors_of(place)) {
        let arguments = ["check", &taped.of, door[0], door[1], "--timeout=60", "--format=json"];
        let output = pintle(&arguments)
            .args(numbers.iter().chain(&taped.more))
            .current_dir(folder)
            .envs([("KIND", kind), ("OFFERS", &offers.join(" ")), ("BITS", &bits(&taped.offers).to_string())])
            .env("TAPE", tape)
            .output()
            .unwrap();
        let errors = String::from_utf8_lossy(&output.stderr);
        let got = String::from_utf8_lossy(&output.stdout).replace(name, "played");
        let (exit, due) = (output.status.code(), Some(code(&report)));
        if exit != due || got != want {
            let first = got.lines().zip(want.lines()).find(|(got, want)| got != want);
            let what = format!("exit code {exit:?} for {due:?}, {first:?} {errors}");
            found.push(format!("{} {} by {}: {what}", taped.of, taped.title, door[0]));
        }
    }
    found
}

#[test]
fn every_door_tells_of_the_corpus_what_the_process_does() {
    if lacks_programs() {
        return;
    }
    let folder = super::folder("played", &[("play.py", PYTHON), ("play.c", C)]);
    ["ELEMENT", "MPC", "FRICTION"].into_iter().for_each(|name| library(&folder, "play.c", name));
    let all = all();
    let next = AtomicUsize::new(0);
    let found = Mutex::new((BTreeMap::<(&str, i32), [usize; 2]>::new(), Vec::new()));
    std::thread::scope(|scope| {
        for worker in 0..2 {
            let (folder, all, next, found) = (&folder, &all, &next, &found);
            scope.spawn(move || {
                let tape = folder.join(format!("tape-{worker}"));
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    let Some(one) = all.get(place) else { return };
                    let taped = one();
                    let differences = differences(&taped, place, folder, &tape);
                    let checks = taped.report.subjects.iter().flat_map(|subject| &subject.checks);
                    let causes = checks.filter_map(|check| check.diagnosis.as_ref());
                    let causes: usize = causes.map(|diagnosis| diagnosis.causes.len()).sum();
                    let mut found = found.lock().unwrap();
                    let [routines, told] = found.0.entry((taped.kind, code(&taped.report))).or_default();
                    (*routines, *told) = (*routines + 1, *told + causes);
                    found.1.extend(differences);
                }
            });
        }
    });
    let (tally, differences) = found.into_inner().unwrap();
    let through: usize = (0..all.len()).map(doors_of).sum();
    println!("{} routines through {through} doors; routines and causes by exit code: {tally:?}", all.len());
    assert!(differences.is_empty(), "{} differences:\n{}", differences.len(), differences.join("\n"));
    let of_wrong = tally.iter().filter(|((_, code), _)| *code == 1).map(|(_, count)| *count);
    let [wrong, causes] = of_wrong.fold([0; 2], |[n, m], [routines, causes]| [n + routines, m + causes]);
    // At so few states some are not seen to be wrong.
    assert!(wrong >= 300 && causes >= wrong, "{tally:?}");
}
