//! Units and axes: what is judged in metres is judged the same in millimetres, in any other unit and in turned axes, number by number
//! and deck by deck, whether it is right or wrong.

use crate::audit::judged;
use pintle_audit::model::{Finding, Levels, audit_model};
use pintle_audit::oracles::oracle::WideAnswers;
use pintle_audit::oracles::truth::Truth;
use pintle_audit::sampling::{Extent, cases};
use pintle_audit::singular::atlas;
use pintle_audit::{
    Bound, Case, Check, Numbers, Oracle, Planted, Quantity, Report, Settings, Target, Verdict, audit_case,
    audit_scenes,
};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{NodalRow, Request};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, Vector, apply, apply_transposed, product};
use pintle_model::evaluate::{Model, Plan, Selection};
use pintle_scene::{GALLERY, Scene, StateFile};
use std::collections::BTreeMap;

/// Millimetres for metres; a power of two, by which nothing is rounded; micrometres for metres, and megametres.
const FACTORS: [f64; 4] = [1000.0, 1.0 / 1024.0, 1e6, 1e-6];

/// Regular states, and two at a ten-thousandth beside a singular set.
fn tried() -> Vec<Case> {
    let mut found = Vec::new();
    for connection in TABLE {
        found.extend(cases(connection, Extent::Brief));
        let draw = &mut Draw::new(&connection.name);
        let sites = atlas::sites(connection);
        let ends = [sites.first(), sites.last()].into_iter().flatten();
        found.extend(ends.filter_map(|(_, site)| atlas::beside(connection, site, 1e-4, 0.4, draw)));
    }
    found
}

const fn is_length(j: usize) -> bool {
    !matches!(j % 7, 3..=5)
}

/// The same with lengths in another unit.
pub(crate) fn scaled(case: &Case, factor: f64) -> Case {
    let mut other = case.clone();
    let pair = |pair: &mut Pair<f64>| {
        pair.reference = pair.reference.map(|x| x * factor);
        for node in [&mut pair.a, &mut pair.b] {
            node.displacement = node.displacement.map(|x| x * factor);
            node.flow *= factor;
        }
    };
    pair(&mut other.definition.initial);
    other.definition.flow_scale /= factor;
    other.length *= factor;
    for step in &mut other.path {
        pair(&mut step.state.pair);
        step.increment.flow = step.increment.flow.map(|x| x * factor);
        for rates in [&mut step.state.velocity, &mut step.state.acceleration] {
            for (_, rate) in rates.iter_mut().enumerate().filter(|(j, _)| is_length(*j)) {
                *rate *= factor;
            }
        }
    }
    other
}

/// The same in turned axes, from the initial state on.
fn turned(case: &Case, rotation: &Matrix<f64>) -> Case {
    let mut other = case.clone();
    let turn = |v: &mut Vector<f64>| *v = apply(rotation, *v);
    let pair = |pair: &mut Pair<f64>| {
        turn(&mut pair.reference);
        for node in [&mut pair.a, &mut pair.b] {
            turn(&mut node.displacement);
            node.triad = product(rotation, &node.triad);
        }
    };
    pair(&mut other.definition.initial);
    turn(&mut other.definition.fixed_direction);
    for step in &mut other.path {
        pair(&mut step.state.pair);
        let vectors = step.increment.rotation.iter_mut().chain(&mut step.increment.whole_turns);
        vectors.for_each(turn);
        for rates in [&mut step.state.velocity, &mut step.state.acceleration] {
            *rates = row_in(rates, |v| apply(rotation, v));
        }
    }
    other
}

/// A nodal row, its vectors changed one by one.
fn row_in(row: &NodalRow<f64>, change: impl Fn(Vector<f64>) -> Vector<f64>) -> NodalRow<f64> {
    let mut found = *row;
    for at in [0, 3, 7, 10] {
        found[at..at + 3].copy_from_slice(&change([row[at], row[at + 1], row[at + 2]]));
    }
    found
}

/// The numbers at a state, their tolerances, and the truth.
fn seen(case: &Case) -> (Numbers<f64>, Bound, WideAnswers) {
    let (numbers, bound, _) = judged(case);
    (numbers, bound, WideAnswers::of(&Truth::of(case).unwrap()))
}

/// The dimension of an entry as a power of length; of forces, those of a unit of their component, nothing is said.
fn dimension(case: &Case, quantity: Quantity, k: usize, i: usize) -> Option<i32> {
    let of_dof = |j: usize| i32::from(is_length(j));
    let own = i32::from(case.connector().differentiated(k)?.unit() == Unit::Length);
    match quantity {
        Quantity::Value | Quantity::Rate | Quantity::Acceleration => Some(own),
        Quantity::FirstDerivatives => Some(own - of_dof(i)),
        Quantity::SecondDerivatives => Some(own - of_dof(i / DOFS) - of_dof(i % DOFS)),
        _ => None,
    }
}

/// Entry by entry, in every unit: a number and its tolerance have the same dimension; the number is right; and an error of four
/// tolerances, put into it in metres and carried over, is wrong.
#[test]
fn units_do_not_change_the_verdict_on_an_entry() {
    let (mut compared, mut dimensioned) = (0, 0);
    for case in tried() {
        let (numbers, bound, answers) = seen(&case);
        for factor in FACTORS {
            let (others, fine, truth) = seen(&scaled(&case, factor));
            for quantity in Quantity::ALL {
                let sharp = Oracle::WideDifferences;
                let [want, carried] = [&answers, &truth].map(|of| of.answer(sharp, quantity));
                let (Some(want), Some(carried)) = (want, carried) else { continue };
                for (k, i, x) in numbers.entries(quantity).iter() {
                    let told = || format!("{} × {factor:e}: {}", case.name, quantity.entry_name(k, i));
                    let y = others.entries(quantity).get(k, i).unwrap_or_else(|| panic!("{}", told()));
                    let [t, s] = [bound.tolerance(quantity, k, i), fine.tolerance(quantity, k, i)];
                    if t == 0.0 || s == 0.0 {
                        assert_eq!((t, s, x, y), (0.0, 0.0, 0.0, 0.0), "{}", told());
                        continue;
                    }
                    let unit = s / t;
                    let power = (unit.ln() / factor.ln()).round() as i32;
                    assert!((unit / factor.powi(power) - 1.0).abs() < 1e-6, "{}: {t} {s}", told());
                    if let Some(dimension) = dimension(&case, quantity, k, i) {
                        assert_eq!(power, dimension, "{}", told());
                        dimensioned += 1;
                    }
                    if factor.log2().fract() == 0.0 {
                        assert_eq!(y, x * factor.powi(power), "{}", told());
                    }
                    let error = |x: f64, of: &pintle_audit::oracles::oracle::Answer| {
                        (x - of.numbers.get(k, i).unwrap().to_f64()).abs()
                    };
                    let right = [error(x, &want) <= t, error(y, &carried) <= s];
                    let spoiled = [error(x + 4.0 * t, &want) <= t, error(y + 4.0 * t * unit, &carried) <= s];
                    assert_eq!((right, spoiled), ([true; 2], [false; 2]), "{}", told());
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 100_000 && dimensioned > 50_000, "{compared} {dimensioned}");
}

/// In turned axes numbers are the same and rows are turned, within the tolerances of both.
#[test]
fn axes_do_not_change_the_verdict_on_an_entry() {
    let rotation = so3::matrix(so3::exp_quaternion([0.7, -1.9, 0.4]));
    let mut compared = 0;
    for case in tried() {
        let [(numbers, bound, _), (others, fine, _)] = [judged(&case), judged(&turned(&case, &rotation))];
        for quantity in Quantity::ALL {
            for k in 0..6 {
                let (Some(x), Some(y)) = (&numbers.entries(quantity).0[k], &others.entries(quantity).0[k])
                else {
                    assert_eq!(
                        numbers.entries(quantity).0[k],
                        others.entries(quantity).0[k],
                        "{}",
                        case.name
                    );
                    continue;
                };
                let back = |row: &[f64]| {
                    let row: NodalRow<f64> = row.try_into().unwrap();
                    row_in(&row, |v| apply_transposed(&rotation, v)).to_vec()
                };
                // The columns of a matrix turned back, then its rows.
                let y = match quantity {
                    Quantity::FirstDerivatives | Quantity::NodalForces => back(y),
                    Quantity::SecondDerivatives | Quantity::GeometricStiffness => {
                        let half: Vec<Vec<f64>> = y.chunks(DOFS).map(back).collect();
                        let columns = |j: usize| back(&half.iter().map(|row| row[j]).collect::<Vec<f64>>());
                        let turned: Vec<Vec<f64>> = (0..DOFS).map(columns).collect();
                        (0..DOFS * DOFS).map(|n| turned[n % DOFS][n / DOFS]).collect()
                    }
                    _ => y.clone(),
                };
                for (i, (x, y)) in x.iter().zip(&y).enumerate() {
                    // A component of a vector is as uncertain as the vector.
                    let most = |bound: &Bound| {
                        (0..quantity.entries()).map(|i| bound.tolerance(quantity, k, i)).fold(0.0, f64::max)
                    };
                    let allowed = 3.0 * (most(&bound) + most(&fine));
                    let name = quantity.entry_name(k, i);
                    assert!((x - y).abs() <= allowed, "{}: {name}: {x} {y} {allowed}", case.name);
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// Every check of a state by its verdict. Laws of a planted error see it or not by the axes: of it the oracles are asked.
fn verdicts(case: &Case, planted: Option<Planted>) -> BTreeMap<String, (Verdict, u64)> {
    let settings = Settings { planted, ..Settings::default() };
    let checks = audit_case(case, &settings, true, 0);
    let asked = checks.iter().filter(|check| planted.is_none() || check.quantity.is_some());
    asked.map(|check| (told(check), (claimed(check.quantity, check.verdict), check.compared))).collect()
}

/// Right, or what is wrong. Of a number that is nothing but rounding, as a rate that cancels, the rounding decides whether it is *passed* or
/// told to be *ill-conditioned*, and units that are no power of two round otherwise.
const fn claimed(quantity: Option<Quantity>, verdict: Verdict) -> Verdict {
    let may_cancel = matches!(quantity, None | Some(Quantity::Rate | Quantity::Acceleration));
    if may_cancel && matches!(verdict, Verdict::IllConditioned) { Verdict::Pass } else { verdict }
}

fn told(check: &Check) -> String {
    format!("{:?} {:?}", check.quantity, check.against)
}

/// Every oracle and law has the same verdict on as many numbers in millimetres and in turned axes, of right numbers and of wrong ones.
#[test]
fn every_check_has_the_same_verdict_in_any_frame() {
    let rotation = so3::matrix(so3::exp_quaternion([0.7, -1.9, 0.4]));
    let mut wrong = 0;
    for (case, error) in tried().iter().zip([Planted::WrongEntry, Planted::WrongSign].into_iter().cycle()) {
        for planted in [None, Some(error)] {
            let here = verdicts(case, planted);
            assert!(!here.is_empty());
            wrong += here.values().filter(|(verdict, _)| verdict.is_mismatch()).count();
            assert_eq!(here, verdicts(&scaled(case, 1000.0), planted), "{} {planted:?}", case.name);
            if planted.is_none() {
                assert_eq!(here, verdicts(&scaled(case, 1e-6), planted), "{}", case.name);
                assert_eq!(here, verdicts(&turned(case, &rotation), planted), "{}", case.name);
            }
        }
    }
    assert!(wrong > 150, "{wrong}");
}

/// The lines of decks of the gallery that hold lengths, with the power of length in each number; forces keep their unit.
const LINES: [(&str, &str, &[i32]); 8] = [
    ("slider_crank", "-0.5, 0.1", &[1, 1]),
    ("slider_crank", "0.05, 0.1, 10.", &[1, 1, 0]),
    ("seat_belt", "50.", &[-1]),
    ("seat_belt", "0.06, 1.5707963", &[-1, 0]),
    ("seat_belt", "5.", &[1]),
    ("seat_belt", "30, 1, 1, 0.1", &[0, 0, 0, 1]),
    ("springs", "40., 0.1", &[0, 1]),
    ("revolute_mpc", "2.5", &[1]),
];

/// A deck with lengths multiplied by a factor: those of nodes, and of the lines listed.
fn deck_in(name: &str, deck: &str, factor: f64) -> String {
    let in_unit = |line: &str, powers: &[i32]| {
        let numbers = line.split(',').zip(powers.iter().chain(std::iter::repeat(&0)));
        let of = |(text, power): (&str, &i32)| match power {
            0 => text.trim().to_string(),
            _ => format!("{:e}", text.trim().parse::<f64>().unwrap() * factor.powi(*power)),
        };
        numbers.map(of).collect::<Vec<_>>().join(", ")
    };
    let (mut is_node, mut used) = (false, 0);
    let mut found = String::new();
    for line in deck.lines() {
        if line.starts_with('*') {
            is_node = is_node && line.starts_with("**") || line == "*NODE";
        }
        let listed = LINES.iter().find(|(of, text, _)| *of == name && *text == line.trim());
        used += usize::from(listed.is_some());
        let line = match listed {
            Some((.., powers)) => in_unit(line, powers),
            None if is_node && !line.starts_with('*') => in_unit(line, &[0, 1, 1, 1]),
            None => line.to_string(),
        };
        found.push_str(&line);
        found.push('\n');
    }
    assert_eq!(used, LINES.iter().filter(|(of, ..)| *of == name).count(), "{name}");
    found
}

/// A file of states with lengths multiplied by a factor.
fn states_in(csv: &str, factor: f64) -> String {
    let mut columns: Vec<bool> = Vec::new();
    let mut found = String::new();
    for line in csv.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let line = if line.starts_with('#') {
            line.to_string()
        } else if columns.is_empty() {
            let of = |name: &&str| {
                name.starts_with("flow") || matches!(name.as_bytes(), [b'u' | b'v' | b'a', b'1'..=b'3'])
            };
            columns = fields.iter().map(of).collect();
            line.to_string()
        } else {
            let of = |(text, is_length): (&&str, &bool)| match text.parse::<f64>() {
                Ok(x) if *is_length => format!("{:e}", x * factor),
                _ => (*text).to_string(),
            };
            fields.iter().zip(&columns).map(of).collect::<Vec<_>>().join(",")
        };
        found.push_str(&line);
        found.push('\n');
    }
    found
}

/// Springs, a damper, a multi-point constraint that keeps a length, and nothing said of states.
const SPRINGS: &str = "*NODE
1, 0.1, 0., 0.
2, 0.8, 0.3, -0.2
3, 1.5, 0.2, 0.4
*ELEMENT, TYPE=CONN3D2, ELSET=E
1, 1, 2
*MPC
LINK, 3, 2
*CONNECTOR SECTION, ELSET=E, BEHAVIOR=B
CARTESIAN, CARDAN
*CONNECTOR BEHAVIOR, NAME=B
*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR
0., 0.
40., 0.1
*BOUNDARY
1, 1, 6
";

/// What an audit says of a deck in a unit of length: every check with its verdicts, states and numbers, and every finding with its line.
fn said(
    name: &str,
    deck: &str,
    states: Option<&str>,
    factor: f64,
    planted: Option<Planted>,
) -> (Vec<String>, u64) {
    let scene = Scene::parse(name, &deck_in(name, deck, factor)).unwrap();
    let file = states.map(|csv| StateFile::parse_csv("states", &states_in(csv, factor), &scene).unwrap());
    let mut states = file.map_or_else(Vec::new, |file| file.states);
    states.truncate(9);
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    let settings = Settings { wide_states: 2, drawn_states: 6, planted, ..Settings::default() };
    let target = Target { name, model: &model, plan: &plan, states: &states };
    let report: Report = audit_scenes(&settings, &[target], &|_| {});
    let mut found = Vec::new();
    for subject in &report.subjects {
        let claims = (subject.cases, claimed(None, subject.derivative), subject.formula, subject.declaration);
        found.push(format!("{} {claims:?} {:?}", subject.name, subject.not_exercised));
        let asked = subject.checks.iter().filter(|check| planted.is_none() || check.quantity.is_some());
        for check in asked {
            let mut states: BTreeMap<Verdict, u64> = BTreeMap::new();
            for (verdict, count) in &check.states {
                *states.entry(claimed(check.quantity, *verdict)).or_default() += count;
            }
            let counts = (states, check.compared, &check.undecided, claimed(check.quantity, check.verdict));
            found.push(format!("{} {} {counts:?}", subject.name, told(check)));
        }
    }
    for finding in audit_model(&scene, &states, &Levels::default()).findings {
        found.push(format!("{:?} {:?} {:?}", finding.code(), finding.severity(), finding.line()));
    }
    (found, report.mismatches() as u64)
}

/// What the states exercised does not depend on the unit of length, of nodes that coincide initially either: the same findings, word for word.
#[test]
fn coverage_is_the_same_in_every_unit() {
    let mut findings = 0;
    for name in ["slider_crank", "seat_belt", "hinge_pendulum"] {
        let example = GALLERY.iter().find(|example| example.name == name).unwrap();
        let mut told = |factor: f64| {
            let scene = Scene::parse(name, &deck_in(name, example.deck, factor)).unwrap();
            let states = states_in(example.states, factor);
            let states = StateFile::parse_csv("states", &states, &scene).unwrap().states;
            let report = audit_model(&scene, &states, &Levels::default());
            let of = |finding: &Finding| finding.code().as_str().starts_with("coverage");
            let told = report.findings.iter().filter(|finding| of(finding)).map(|found| found.message());
            let exercise = report.coverage.exercise;
            findings += told.clone().count();
            (told.map(String::from).collect::<Vec<_>>(), exercise.away, exercise.deformed)
        };
        let metres = told(1.0);
        assert!(metres.1 > 0 && metres.2 > 0, "{name}");
        for factor in [1e-6, 1e-3, 1e3, 1e6] {
            assert_eq!(told(factor), metres, "{name} {factor}");
        }
    }
    assert!(findings > 0);
}

/// A deck in millimetres is judged as in metres: connectors, multi-point constraints, springs and friction, and the model as a whole.
#[test]
fn a_deck_in_millimetres_is_judged_as_in_metres() {
    let mut wrong = 0;
    for planted in [None, Some(Planted::WrongEntry), Some(Planted::WrongFriction)] {
        let of = |name: &str| GALLERY.iter().find(|example| example.name == name).unwrap();
        let examples = ["slider_crank", "seat_belt", "hinge_pendulum", "revolute_mpc"].map(of);
        let given = examples.map(|example| (example.name, example.deck, Some(example.states)));
        let drawn = [("slider_crank", of("slider_crank").deck, None), ("springs", SPRINGS, None)];
        for (name, deck, states) in given.into_iter().chain(drawn) {
            let (metres, mismatches) = said(name, deck, states, 1.0, planted);
            wrong += mismatches;
            match planted {
                None => assert_eq!(mismatches, 0, "{name} {metres:#?}"),
                Some(Planted::WrongEntry) => assert!(mismatches > 0, "{name} {metres:#?}"),
                _ => {}
            }
            let (others, _) = said(name, deck, states, 1000.0, planted);
            assert_eq!(metres, others, "{name} {planted:?}");
        }
    }
    assert!(wrong > 10, "{wrong}");
}
