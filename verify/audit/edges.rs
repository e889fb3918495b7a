//! The edges of the audit: states within rounding of a singular set, routines near one, files made by hand.

use crate::audit::friction::{DECK, path};
use crate::audit::{at_rest, named};
use pintle_audit::case::{Step, carried};
use pintle_audit::sampling as sample;
use pintle_audit::sampling::Extent;
use pintle_audit::singular::atlas;
use pintle_audit::{
    Candidate, Check, CounterExample, Failing, Oracle, Planted, Report, Settings, Target, audit_case,
    audit_scenes,
};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{Connector, Increment, Request, Tally};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::so3;
use pintle_kinematics::vector::identity;
use pintle_model::evaluate::{Model, Plan, Selection};
use pintle_report::audit::AssertOk;
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State};
use serde_json::{Value, json};
use std::f64::consts::FRAC_PI_2;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Beside a lock, from where every angle has its derivative to where rounding decides them and the first one is kept: nothing is wrong
/// on either side, from any direction, whatever the nodes have turned besides.
#[test]
fn states_beside_a_lock_are_no_mismatch() {
    const DISTANCES: [f64; 18] = [
        1e-13, 3e-14, 1e-14, 6e-15, 4e-15, 3e-15, 2.4e-15, 2.1e-15, 2e-15, 1.9e-15, 1.6e-15, 1.2e-15, 8e-16,
        5e-16, 3e-16, 1e-16, 1e-17, 0.0,
    ];
    let (mut found, mut compared) = (Vec::new(), 0);
    for (name, measure) in [("CARDAN", Measure::Cardan(1)), ("EULER", Measure::Euler(1))] {
        for (n, distance) in DISTANCES.into_iter().enumerate() {
            for (sign, azimuth) in [(1.0, 0.0), (-1.0, 0.4), (1.0, 2.9), (-1.0, -1.3)] {
                let draw = &mut Draw::new(&format!("{name} {n} {azimuth}"));
                let mut case = atlas::near(named(name), measure, sign * distance, azimuth, draw).unwrap();
                let turn = pintle_kinematics::vector::scale(draw.direction(), draw.between(0.0, 3.0));
                let together = so3::matrix(so3::exp_quaternion(turn));
                for step in case.path.iter_mut().filter(|_| azimuth != 0.0) {
                    step.state.pair = carried(&step.state.pair, &together, [0.0; 3]);
                }
                for check in audit_case(&case, &Settings::default(), true, 0) {
                    compared += check.compared;
                    if check.verdict.is_mismatch() || check.score.survived > 0 {
                        let worst = check.worst.as_ref().map(|worst| (worst.entry.clone(), worst.units));
                        found.push(format!(
                            "{name} {:e}: {:?} against {}: {:?} {worst:?} {:?}",
                            sign * distance,
                            check.quantity,
                            check.against.name(),
                            check.verdict,
                            check.score.survivors
                        ));
                    }
                }
            }
        }
    }
    assert!(found.is_empty(), "{}\n{}", found.len(), found.join("\n"));
    assert!(compared > 10_000, "{compared}");
}

/// At exact half turns of b against a, where half of a torsion changes its sign though no singular set says so, and whole turns beyond, nothing
/// of any type is wrong, second derivatives among them.
#[test]
fn half_turns_are_no_mismatch() {
    let (mut found, mut compared) = (Vec::new(), 0);
    for (connection, axis) in TABLE.iter().flat_map(|connection| [0, 1, 2].map(|axis| (connection, axis))) {
        let about = |angle: f64| {
            so3::matrix(so3::exp_quaternion([0, 1, 2].map(|i| if i == axis { angle } else { 0.0 })))
        };
        let mut half = [[0.0; 3]; 3];
        (0..3).for_each(|i| half[i][i] = if i == axis { 1.0 } else { -1.0 });
        let mut case = sample::cases(connection, Extent::Brief).swap_remove(0);
        let Some(last) = case.path.last().cloned() else { continue };
        let Pair { a, mut b, reference } = last.state.pair;
        (b.displacement, b.triad) = ([0.3, -0.2, 0.7], half);
        let pair = Pair { reference, a: Node { displacement: [0.0; 3], triad: identity(), ..a }, b };
        let quarter = Pair { b: Node { triad: about(FRAC_PI_2), ..b }, ..pair };
        case.path = vec![Step::between(&case.definition.initial, quarter), Step::between(&quarter, pair)];
        for step in &mut case.path {
            (step.state.velocity, step.state.acceleration) = (last.state.velocity, last.state.acceleration);
        }
        for check in audit_case(&case, &Settings::default(), true, 0) {
            compared += check.compared;
            if check.verdict.is_mismatch() || check.score.survived > 0 {
                let worst = check.worst.as_ref().map(|worst| (worst.entry.clone(), worst.units));
                found.push(format!("{} {axis}: {} {worst:?}", connection.name, check.against.name()));
            }
        }
    }
    assert!(found.is_empty(), "{}\n{}", found.len(), found.join("\n"));
    assert!(compared > 10_000, "{compared}");
}

/// Scenes at exact half turns and beside singular sets, whose right numbers were once called wrong:
/// - an angle that 237 bits put on the other side of half a turn;
/// - a rotation vector that jumps where it is and on both sides;
/// - rows that are extrema beside a lock;
/// - an exchanged connector on the other sheet of its Euler angles.
#[test]
fn scenes_once_called_wrong_are_right() {
    const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
    let frames = [
        "0., 0.6, 0.8, 1., 0., 0.",
        "0., 1., 0., 0., 0., 1.",
        "1., 0., 0., 0., 1., 0.",
        "1., 0., 0., 0., 0., 1.",
    ];
    let beside = [1e-10, HALF, 0.0, HALF];
    let half = [0.0, 0.0, 0.0, 1.0];
    let none = [1.0, 0.0, 0.0, 0.0];
    for (name, orientations, turned, spins) in [
        ("BUSHING", &[0][..], [none, [0.0, HALF, HALF, 0.0]], [[0.0; 3]; 2]),
        ("PROJECTION CARTESIAN", &[0], [none, [0.0, HALF, HALF, 0.0]], [[0.3, 0.1, -0.2], [0.0; 3]]),
        ("BEAM", &[1], [none, half], [[-1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]),
        ("WELD", &[1], [none, half], [[-1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]),
        ("FLEXION-TORSION", &[1, 2], [none, beside], [[0.0; 3]; 2]),
        ("UNIVERSAL", &[2], [beside, [HALF, 0.0, 0.0, HALF]], [[0.0; 3]; 2]),
        ("EULER", &[2, 3], [none, none], [[0.0; 3]; 2]),
    ] {
        let named: Vec<String> = orientations.iter().map(|i| format!("O{i}")).collect();
        let frames: String =
            frames.iter().enumerate().map(|(i, axes)| format!("*ORIENTATION, NAME=O{i}\n{axes}\n")).collect();
        let second = if matches!(name, "WELD" | "UNIVERSAL") { "0." } else { "1." };
        let deck = format!(
            "*NODE\n1, 0., 0., 0.\n2, {second}, 0., 0.\n{frames}*ELEMENT, TYPE=ROTARYI\n201, 1\n202, 2\n*ELEMENT, TYPE=CONN3D2, \
             ELSET=E\n101, 1, 2\n*CONNECTOR SECTION, ELSET=E\n{name}\n{},\n",
            named.join(", ")
        );
        let motion = |quaternion, angular_velocity| NodeMotion {
            rotation: Rotation::Quaternion(quaternion),
            angular_velocity,
            ..NodeMotion::default()
        };
        let nodes = [1_u64, 2].into_iter().zip(turned.into_iter().zip(spins));
        let nodes = nodes.map(|(label, (turned, spin))| (Label::from(label), motion(turned, spin)));
        let state = State { number: Some(1), nodes: nodes.collect(), ..State::default() };
        let report = audited(&deck, &[state], &Settings::default());
        for check in report.subjects.iter().flat_map(|subject| &subject.checks) {
            assert!(!check.verdict.is_mismatch(), "{name}: {check:?}");
        }
        assert_eq!(report.survivors(), 0, "{name}");
        assert!(report.compared() > 100, "{name}: {}", report.compared());
    }
}

/// A routine that gives what the product gives, rows spoiled where `spoils` says so, at states about the initial one and near its
/// singular sets.
fn near_singular(name: &str, near: usize, spoils: impl Fn(f64) -> bool) -> Report {
    let mut definition = at_rest(name);
    // No kink, and no lock, at the start.
    definition.initial.b.triad = so3::matrix(so3::exp_quaternion([0.2, 0.7, -0.3]));
    let connector = Connector::<f64>::new(&definition);
    let settings = Settings {
        states: 12,
        near_singular_states: near,
        wide_states: 8,
        atlas: false,
        ..Settings::default()
    };
    Candidate::new("candidate", &definition).settings(settings).check(|state| {
        let branch = connector.advance(state, &Increment::none(), &connector.initial_branch());
        let asked = Request::everything(1);
        let found = connector.evaluate(state, &Increment::none(), &branch, &asked, &mut Tally::default());
        let values = std::array::from_fn(|k| found.residual[k].or(found.displacement[k]));
        let mut rows = found.jacobian;
        let margins = connector.margins(state, &branch, [true; 6]);
        let nearest =
            margins.iter().flatten().fold(f64::INFINITY, |least, margin| least.min(margin.distance));
        if let Some(row) = rows.iter_mut().flatten().next_back().filter(|_| spoils(nearest)) {
            row[DOFS / 2 + 4] += 1e-3 * (1.0 + row[DOFS / 2 + 4].abs());
        }
        (values, rows)
    })
}

/// A routine that is wrong near a singular set alone is found where states are drawn there.
#[test]
fn candidates_are_tried_near_singular_sets() {
    for name in ["CARDAN", "EULER", "FLEXION-TORSION", "UJOINT", "TRANSLATOR", "AXIAL", "RADIAL-THRUST"] {
        let right = near_singular(name, 24, |_| false);
        right.assert_ok();
        assert_eq!(right.subjects[0].cases, 36, "{name}");
    }
    for name in ["CARDAN", "EULER", "FLEXION-TORSION"] {
        assert_eq!(near_singular(name, 0, |near| near < 9e-3).mismatches(), 0, "{name}");
        assert_eq!(near_singular(name, 24, |near| near < 9e-3).mismatches(), 1, "{name}");
    }
}

fn audited(deck: &str, states: &[State], settings: &Settings) -> Report {
    let scene = Scene::parse("deck.inp", deck).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    let model = Model::compile(&scene).unwrap_or_else(|error| panic!("{}", error.render(100, false)));
    let plan = Plan::compile(&model, &Selection::All, Request::nothing(0)).unwrap();
    audit_scenes(settings, &[Target { name: "scene", model: &model, plan: &plan, states }], &|_| {})
}

/// Rates and accelerations of any size beside each other are judged, and what differences in time do not tell is not asked of them.
#[test]
fn tiny_rates_are_no_mismatch() {
    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\nHINGE\nO,\n";
    let sizes = [0.0, 1e-300, 1e-160, 1e-53, 1e-30, 1e-12, 1.0, 1e12, 1e100];
    let mut compared = 0;
    for (rate, acceleration) in sizes.into_iter().flat_map(|rate| sizes.map(|second| (rate, second))) {
        let motion = NodeMotion {
            rotation: Rotation::Vector([0.3, 0.0, 0.0]),
            angular_velocity: [0.2 * rate, 0.0, rate],
            angular_acceleration: [0.0, 0.3 * acceleration, acceleration],
            ..NodeMotion::default()
        };
        let state = State { nodes: [(Label::from(2), motion)].into(), ..State::default() };
        let report = audited(deck, &[state], &Settings { atlas: false, ..Settings::default() });
        let found = (report.mismatches(), report.survivors());
        assert_eq!(found, (0, 0), "vr = {rate:e}, ar = {acceleration:e}");
        compared += report.subjects[0].checks.iter().map(|check| check.compared).sum::<u64>();
    }
    assert!(compared > 81 * 1_000, "{compared}");
}

/// A counter-example of every friction of a scene, and of its springs.
fn recorded() -> Vec<Value> {
    let tabled = DECK.replace("*FRICTION\n0.3\n", "*FRICTION\n0.3, 0.\n0.2, 1.\n0.1, 20.\n").replace(
        "*CONNECTOR ELASTICITY, COMPONENT=3\n50.,\n",
        "*CONNECTOR ELASTICITY, COMPONENT=3, NONLINEAR, INDEPENDENT COMPONENTS=POSITION\n1, 3\n\
         -30., -9., -9.\n10., 9., -9.\n70., -9., 9.\n210., 9., 9.\n",
    );
    let mut found: Vec<Value> = Vec::new();
    for planted in [Planted::WrongFriction, Planted::WrongEntry] {
        let settings = Settings {
            planted: Some(planted),
            oracles: [Oracle::WideDifferences].into(),
            wide_states: 2,
            ..Settings::default()
        };
        let report = audited(&tabled, &path()[..6], &settings);
        let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
        let of_other = |check: &&Check| matches!(check.failing.as_deref(), Some(failing) if !matches!(failing, Failing::Connector(_)));
        let examples = checks.filter(of_other).filter_map(|check| CounterExample::of(check, "a test"));
        found.extend(examples.map(|example| serde_json::to_value(example).unwrap()));
    }
    found
}

/// Every place of a value, as a pointer.
fn places(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.to_string());
    match value {
        Value::Array(all) => {
            all.iter().enumerate().for_each(|(i, value)| places(value, &format!("{at}/{i}"), found));
        }
        Value::Object(all) => {
            all.iter().for_each(|(name, value)| places(value, &format!("{at}/{name}"), found))
        }
        _ => {}
    }
}

/// What somebody might have made of a value.
fn spoiled_values(value: &Value) -> Vec<Value> {
    let mut made = vec![json!(null), json!([]), json!("0x0p+0"), json!(5), json!({}), json!([value])];
    match value {
        Value::Array(all) if !all.is_empty() => {
            let mut longer = all.clone();
            longer.extend(all.last().cloned());
            let mut turned = all.clone();
            turned.reverse();
            made.extend([json!(all[1..]), json!(longer), json!(turned)]);
            made.push(Value::Array(std::iter::repeat_n(all[0].clone(), 40).collect()));
        }
        Value::Object(all) => {
            made.extend(all.values().cloned());
        }
        Value::String(_) => {
            made.extend(["-0x1p+1023", "0x1p-1074", "0x1p+0", "nothing"].map(|x| json!(x)));
        }
        _ => {}
    }
    made
}

/// Whatever is made of a file, it is refused with a reason, or judged: nothing panics.
#[test]
fn files_made_by_hand_do_not_panic() {
    let (mut tried, mut refused, mut found) = (0, 0, Vec::new());
    for document in recorded() {
        let mut all = Vec::new();
        places(&document["values"], "/values", &mut all);
        let mut draw = Draw::new("by hand");
        for place in all {
            for value in spoiled_values(document.pointer(&place).unwrap()) {
                // Numbers are many, and one is as good as another.
                if document.pointer(&place).unwrap().is_string() && draw.below(12) > 0 {
                    continue;
                }
                let mut changed = document.clone();
                *changed.pointer_mut(&place).unwrap() = value.clone();
                let text = changed.to_string();
                let outcome = catch_unwind(AssertUnwindSafe(|| {
                    let Ok(example) = CounterExample::read(&text) else { return false };
                    match example.failing() {
                        Err(error) => {
                            assert!(error.to_string().len() > 10, "{error}");
                            false
                        }
                        Ok(failing) => {
                            let settings =
                                Settings { oracles: [Oracle::Differences].into(), ..Settings::default() };
                            _ = failing.audit(&settings);
                            true
                        }
                    }
                }));
                tried += 1;
                match outcome {
                    Ok(is_judged) => refused += usize::from(!is_judged),
                    Err(_) => found.push(format!("{} {place} = {value}", document["kind"])),
                }
            }
        }
    }
    println!("{tried} tried, {refused} refused");
    assert!(refused > 500 && tried - refused > 100, "{tried} tried, {refused} refused");
    assert!(found.is_empty(), "{} panics\n{}", found.len(), found.join("\n"));
}
