//! Relations are judged as connectors are: right numbers pass everywhere, mutants of them are noticed, and so is what is planted.

use pintle_audit::{Against, MpcCase, Planted, RelationCase, Settings, Verdict};
use pintle_kinematics::connector::Turns;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::mpc::{Body, Constraint, Dofs, MpcType, State, Turning};
use pintle_kinematics::relation::{Point, Relation};
use pintle_kinematics::so3;
use pintle_kinematics::vector::Vector;

const FORMS: [&str; 17] = [
    "EQUATION",
    "EQUATION with angles",
    "RIGID BODY",
    "RIGID BODY pinned",
    "KINEMATIC 4",
    "KINEMATIC 5",
    "KINEMATIC 6",
    "KINEMATIC 45",
    "KINEMATIC 1346",
    "DISTRIBUTING",
    "DISTRIBUTING line",
    "DISTRIBUTING many",
    "EQUATION in the plane",
    "RIGID BODY in the plane",
    "KINEMATIC in the plane 16",
    "DISTRIBUTING in the plane",
    "DISTRIBUTING line in the plane",
];

/// Anywhere, small, far away, everything at rest, turned beyond half a turn.
const REGIONS: usize = 5;

fn case(form: &str, region: usize) -> RelationCase {
    let mut draw = Draw::new(&format!("{form} {region}"));
    let length = if region == 1 { 1e-6 } else { 1.0 };
    let is_planar = form.contains("in the plane");
    let mut three = |size: f64| -> Vector<f64> { [0; 3].map(|_| draw.between(-size, size)) };
    let flat = |[x, y, z]: Vector<f64>| if is_planar { [x, y, 0.0] } else { [x, y, z] };
    let about = |[x, y, z]: Vector<f64>| if is_planar { [0.0, 0.0, z] } else { [x, y, z] };
    let axes = so3::matrix(so3::exp_quaternion(about(three(2.0))));
    let places: Vec<Vector<f64>> = (0..200).map(|_| flat(three(length))).collect();
    let count = match form.trim_end_matches(" in the plane") {
        "DISTRIBUTING many" => 200,
        "DISTRIBUTING" => 6,
        "DISTRIBUTING line" | "EQUATION" | "EQUATION with angles" => 4,
        _ => 2,
    };
    let far = if region == 2 { flat(three(1e4)) } else { [0.0; 3] };
    let mut nodes = Vec::new();
    for place in 0..count {
        let phi = match region {
            3 => [0.0; 3],
            4 if place == 0 => about([3.0, 2.0, -2.5]),
            _ => about(three(1.2)),
        };
        let moved = if region == 3 { [0.0; 3] } else { flat(three(0.7 * length)) };
        let mut rates = || {
            let (x, turn, flow) = (flat(three(2.0 * length)), about(three(2.0)), three(length));
            [x[0], x[1], x[2], turn[0], turn[1], turn[2], flow[0]]
        };
        nodes.push(Point {
            displacement: [0, 1, 2].map(|i| far[i] + moved[i]),
            rotation: so3::matrix(so3::exp_quaternion(phi)),
            vector: phi,
            flow: 0.3 * length,
            velocity: rates(),
            acceleration: rates(),
        });
    }
    let fixed = |numbers: &str| [1, 2, 3, 4, 5, 6].map(|number: u8| numbers.contains(&number.to_string()));
    let carried = |numbers: &str| Relation::carried(places[0], places[1], axes, fixed(numbers));
    let mean = |places: &[Vector<f64>]| {
        let share = |(i, x): (usize, &Vector<f64>)| (1.0 + 0.1 * i as f64, *x);
        Relation::mean(places[0], &places[1..].iter().enumerate().map(share).collect::<Vec<_>>())
    };
    let relation = match form.trim_end_matches(" in the plane") {
        "EQUATION" if is_planar => {
            let terms = [(0, axes[0], 0, 1.5 / length), (1, axes[1], 1, -2.0 / length), (2, axes[2], 5, 0.7)];
            Relation::linear(&terms).with_angles(|_| false)
        }
        "EQUATION" => Relation::linear(&[
            (0, axes[0], 3, 1.5),
            (1, axes[1], 1, -2.0 / length),
            (2, axes[2], 5, 0.7),
            (3, axes[0], 6, 0.25 / length),
        ]),
        "EQUATION with angles" => {
            let terms = [(0, axes[0], 5, 1.5), (1, axes[1], 3, -2.0), (2, axes[2], 0, 0.5 / length)];
            Relation::linear(&terms).with_angles(|place| place == 1)
        }
        "RIGID BODY" => carried("123456"),
        "RIGID BODY pinned" => carried("123"),
        "DISTRIBUTING line" => {
            let line: Vec<Vector<f64>> = [0.3, -1.0, 0.5, 2.0].map(|t| places[1].map(|x| t * x)).to_vec();
            mean(&[&places[..1], &line[1..]].concat())
        }
        "DISTRIBUTING" | "DISTRIBUTING many" => mean(&places[..count]),
        kinematic => carried(kinematic.rsplit(' ').next().unwrap_or_default()),
    };
    let relation = if is_planar { relation.in_plane() } else { relation };
    let type_name = form.split(' ').next().unwrap_or_default().to_string();
    RelationCase { name: format!("{form} in region {region}"), type_name, relation, nodes, length }
}

/// Every number is right and every law holds, in every region; of the mutants that change enough none survives.
#[test]
fn relations_pass_and_their_mutants_do_not() {
    let (mut compared, mut noticed, mut laws) = (0, 0, 0);
    for form in FORMS {
        for region in 0..REGIONS {
            let case = case(form, region);
            for check in case.audit(&Settings::default(), true) {
                let state = format!("{}: {:?} {:?}", case.name, check.against, check.quantity);
                assert!(
                    matches!(check.verdict, Verdict::Pass | Verdict::IllConditioned),
                    "{state} {:?} {:?}",
                    check.verdict,
                    check.worst
                );
                assert_eq!(check.score.survived, 0, "{state} {:?}", check.score.survivors);
                compared += check.compared;
                noticed += check.score.killed;
                laws += usize::from(matches!(check.against, Against::Law(_)));
            }
        }
    }
    assert!(compared > 10_000 && noticed > 30_000, "{compared} {noticed}");
    // Three laws of what is carried and of means, one of equations.
    assert_eq!(laws, REGIONS * (14 * 3 + 3));
}

/// A row, a value, a rate and an acceleration with a wrong number are wrong, and say so.
#[test]
fn planted_mistakes_are_wrong() {
    let mut found = 0;
    for form in FORMS {
        for planted in [
            Planted::WrongEntry,
            Planted::WrongSign,
            Planted::WrongValue,
            Planted::WrongRate,
            Planted::WrongAcceleration,
        ] {
            let settings = Settings { planted: Some(planted), ..Settings::default() };
            let checks = case(form, 0).audit(&settings, false);
            assert!(checks.iter().any(|check| check.verdict == Verdict::Wrong), "{form} {planted:?}");
            found += 1;
        }
    }
    assert_eq!(found, 5 * FORMS.len());
}

/// Tolerances that are a billion times too wide fail the self-test, whatever passes within them.
#[test]
fn tolerances_that_are_too_wide_are_noticed() {
    let (mut tables, mut survivors) = (0, 0);
    for form in FORMS {
        let case = case(form, 0);
        for mut table in case.tables() {
            assert_eq!(table.check(true, &case.name, None).score.survived, 0, "{}", case.name);
            table.entries.iter_mut().for_each(|entry| entry.scale *= 1e9);
            tables += 1;
            survivors += usize::from(table.check(true, &case.name, None).score.survived > 0);
        }
    }
    println!("{survivors} of {tables}");
    assert!(tables >= 4 * FORMS.len() && 4 * survivors >= 3 * tables, "{survivors} of {tables}");
}

/// Constraints of a plane model pass as those of space do, laws and mutants included.
#[test]
fn constraints_in_the_plane_pass() {
    let (mut compared, mut laws) = (0, 0);
    for kind in [MpcType::Beam, MpcType::Pin, MpcType::Link, MpcType::Tie] {
        let turned = |angle: f64| so3::matrix(so3::exp_quaternion([0.0, 0.0, angle]));
        let body = |x: f64, y: f64, angle: f64| Body {
            displacement: [x, y, 0.0],
            rotation: turned(angle),
            flow: 0.0,
        };
        let rates = |n: f64| -> Dofs<f64> {
            std::array::from_fn(|j| match j % 7 {
                0 | 1 | 5 if j < 14 => 0.3 * n - 0.2 * j as f64 + 0.7,
                _ => 0.0,
            })
        };
        let case = MpcCase {
            name: format!("{} in the plane", kind.name()),
            constraint: Constraint::new(kind, [1.3, 0.4, 0.0], [0.2, -0.6, 0.0], [[0.0; 3]; 2]).in_plane(),
            state: State {
                slave: body(0.3, -0.2, 0.9),
                master: body(-0.1, 0.5, 0.4),
                angles: [None; 2],
                velocity: rates(1.0),
                acceleration: rates(-2.0),
            },
            turning: Turning::none(),
            before: [Turns { turns: 0.0, principal: 0.0 }; 2],
            length: 1.0,
        };
        for check in case.audit(&Settings::default(), true) {
            let state = format!("{}: {:?} {:?}", case.name, check.against, check.quantity);
            assert_eq!(check.verdict, Verdict::Pass, "{state} {:?}", check.worst);
            assert_eq!(check.score.survived, 0, "{state} {:?}", check.score.survivors);
            compared += check.compared;
            laws += usize::from(matches!(check.against, Against::Law(_)));
        }
    }
    assert!(compared > 500 && laws >= 12, "{compared} {laws}");
}
