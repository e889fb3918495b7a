//! Where verdicts differ by little: a formula that is right or nearly so, derivatives on singular sets.

use crate::audit::{judged, named};
use crate::laws::mpc;
use pintle_audit::judge::components::{Exact, Surroundings, judge};
use pintle_audit::oracles::oracle::{Narrow, WideAnswers, remainder_of, remainders};
use pintle_audit::oracles::truth::Truth;
use pintle_audit::sampling::{Extent, Region, cases, draw_case};
use pintle_audit::singular::atlas;
use pintle_audit::{
    Against, Bound, Case, Check, MpcCase, Numbers, Oracle, Planted, Quantity, Settings, Verdict, audit_case,
};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Definition, Turns};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::mpc::{Body, MpcType, State, Turning};
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::vector::identity;
use std::collections::BTreeMap;

const START: [Turns<f64>; 2] = [Turns { turns: 0.0, principal: 0.0 }; 2];

/// A number that has lost digits is an unstable formula only where the source, on 237 bits, gives the differences there to far below a
/// tolerance: a source that is off by half of one is wrong.
#[test]
fn a_formula_is_right_only_where_its_exact_value_is() {
    let quantity = Quantity::FirstDerivatives;
    let case = draw_case(named("CARDAN"), Region::Misaligned, &mut Draw::new("unstable")).unwrap();
    let (numbers, bound, nearness) = judged(&case);
    let answers = WideAnswers::of(&Truth::of(&case).unwrap());
    let tolerance = bound.tolerance(quantity, 3, 10);
    let mut got = numbers.entries(quantity).clone();
    got.0[3].as_mut().unwrap()[10] += 100.0 * tolerance;
    let truth = answers.differences.entries(quantity);
    let around = |sides| Surroundings { sides, ..Surroundings::new(&bound, [nearness; 6]) };
    let verdict = |off: f64| {
        let product = truth.map(|_, _, x| x + Wide::from_f64(off * tolerance));
        let exact = |_: Quantity| Some(Exact { product: &product, truth });
        let around = Surroundings { exact: Some(&exact), ..around(None) };
        let oracles = [Oracle::WideDifferences, Oracle::WideDual, Oracle::WideSymbolic];
        oracles
            .map(|oracle| judge(quantity, &got, &answers.answer(oracle, quantity).unwrap(), &around).verdict)
    };
    assert_eq!(verdict(1e-12), [Verdict::UnstableFormula; 3]);
    for off in [1e-7, 1e-3, 0.5, -0.5] {
        assert_eq!(verdict(off), [Verdict::Wrong; 3], "{off}");
    }
    // Without a witness nothing is proven.
    let answer = answers.answer(Oracle::WideDifferences, quantity).unwrap();
    assert_eq!(judge(quantity, &got, &answer, &around(None)).verdict, Verdict::Wrong);
}

/// Where triads are rotations, dual numbers and differences on 237 bits agree to a billionth of a tolerance, in every quantity of every type.
/// What is further apart is no rounding. Two exceptions:
/// - second derivatives where differences go ahead only: a millionth;
/// - near singular sets: what differences there are worth, 1e-20/δ.
#[test]
fn duals_and_differences_agree_far_below_the_tolerance() {
    let mut all_most = BTreeMap::<(Quantity, bool), (f64, String)>::new();
    let mut compared = 0;
    for connection in TABLE {
        let draw = &mut Draw::new(&connection.name);
        let mut all = cases(connection, Extent::Brief);
        all.extend((0..4).filter_map(|_| atlas::random_near(connection, draw)));
        for case in all {
            let (_, _, nearness) = judged(&case);
            if nearness == 0.0 {
                continue;
            }
            let answers = WideAnswers::of(&Truth::of(&case).unwrap());
            let bound = bound_of(&case, &answers, nearness);
            for quantity in Quantity::ALL {
                for (k, i, truth) in answers.differences.entries(quantity).iter() {
                    let dual = answers.dual.entries(quantity).get(k, i).unwrap();
                    let apart = (dual - truth).abs().to_f64();
                    if apart == 0.0 {
                        continue;
                    }
                    compared += 1;
                    let units = apart / bound.tolerance(quantity, k, i) / (1.0 + 1e-10 / nearness);
                    let is_second =
                        matches!(quantity, Quantity::SecondDerivatives | Quantity::GeometricStiffness);
                    let most = all_most.entry((quantity, is_second && nearness > 0.01)).or_default();
                    if units > most.0 {
                        *most = (units, format!("{} {}", case.name, quantity.entry_name(k, i)));
                    }
                }
            }
        }
    }
    println!("{compared} entries; {all_most:?}");
    assert!(compared > 10_000);
    for ((quantity, is_ahead), (most, place)) in all_most {
        // Of second differences that go ahead only, a step of 1e-21 is left, over C u = 4e-16.
        let allowed = if is_ahead { 1e-6 } else { 1e-9 };
        assert!(most < allowed, "{}: {most:e} at {place}", quantity.name());
    }
}

fn bound_of(case: &Case, answers: &WideAnswers, nearness: f64) -> Bound {
    let mut numbers = Numbers::default();
    for quantity in Quantity::ALL {
        numbers.set(quantity, answers.differences.entries(quantity).map(|_, _, x| x.to_f64()));
    }
    let state = &case.last().unwrap().state;
    Bound::new(&numbers, state, case.length, nearness)
}

/// On a singular set of one component another one is judged as ever: what is wrong there is no kink.
#[test]
fn an_error_beside_a_kink_is_wrong() {
    let connection = ConnectionType::named("JOIN", Some("FLEXION-TORSION")).unwrap();
    let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    let definition = Definition::new(connection, Pair { reference: [0.0; 3], a: node, b: node });
    let pair = definition.initial;
    let step = pintle_audit::Step::between(&pair, pair);
    let case = Case { name: "on a kink".into(), definition, start: None, path: vec![step], length: 1.0 };
    let of = |planted: Option<Planted>| {
        let settings = Settings { planted, ..Settings::default() };
        let checks = audit_case(&case, &settings, true, 0);
        let sharp = Against::Oracle(Oracle::WideDifferences);
        let check = checks
            .into_iter()
            .find(|check| check.quantity == Some(Quantity::FirstDerivatives) && check.against == sharp);
        check.unwrap()
    };
    // Flexion has a kink, and sweep is a true singularity.
    assert_eq!(of(None).verdict, Verdict::Singular);
    // The formula is right, the number is not.
    let wrong = of(Some(Planted::WrongEntry));
    assert_eq!(wrong.verdict, Verdict::UnstableFormula, "{wrong:?}");
    assert!(wrong.worst.unwrap().entry.starts_with("∂u1/∂"));
}

fn constraint(kind: MpcType, separation: [f64; 3], slave: [[f64; 3]; 3]) -> MpcCase {
    let positions = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    let body = |displacement, rotation| Body { displacement, rotation, flow: 0.0 };
    let [first, second, third, fourth] = positions;
    let displacement = [0, 1, 2].map(|i| second[i] - first[i] + separation[i]);
    let mut velocity = [0.0; pintle_kinematics::mpc::DOFS];
    velocity[..3].copy_from_slice(&[0.25, -0.5, 1.0]);
    MpcCase {
        name: format!("{} on a singular set", kind.name()),
        constraint: pintle_kinematics::mpc::Constraint::new(kind, first, second, [third, fourth]).with_flow(),
        state: State {
            slave: body(displacement, slave),
            master: body([0.0; 3], identity()),
            angles: [None; 2],
            velocity,
            acceleration: [0.0; pintle_kinematics::mpc::DOFS],
        },
        turning: Turning::none(),
        before: START,
        length: 2.0,
    }
}

/// Where the nodes of a LINK coincide both one-sided derivatives are told; numbers between them may stand there, others are wrong. Rates
/// have sides too.
#[test]
fn a_link_of_coincident_nodes_has_two_sides() {
    let case = constraint(MpcType::Link, [0.0; 3], identity());
    let checks = case.audit(&Settings::default(), true);
    let of = |quantity: Quantity| checks.iter().find(|check| check.quantity == Some(quantity)).unwrap();
    let first = of(Quantity::FirstDerivatives);
    assert_eq!(first.verdict, Verdict::Kink, "{first:?}");
    let [below, above] = first.worst.as_ref().unwrap().one_sided.unwrap();
    assert!((below + 1.0).abs() < 1e-15 && (above - 1.0).abs() < 1e-15, "{below} {above}");
    assert_eq!(of(Quantity::Value).verdict, Verdict::Pass);
    let rate = of(Quantity::Rate);
    assert_eq!(rate.verdict, Verdict::Kink, "{rate:?}");
    let speed = (0.0625_f64 + 0.25 + 1.0).sqrt();
    let [below, above] = rate.worst.as_ref().unwrap().one_sided.unwrap();
    assert!((below + speed).abs() < 1e-15 && (above - speed).abs() < 1e-15, "{below} {above}");
    let tables = case.tables();
    let table = tables.iter().find(|table| table.quantity == Quantity::FirstDerivatives).unwrap();
    for (got, verdict) in [
        (0.5, Verdict::Kink),
        (1.0, Verdict::Kink),
        (-1.0, Verdict::Kink),
        (1.0 + 1e-9, Verdict::Wrong),
        (-7.0, Verdict::Wrong),
        (f64::NAN, Verdict::Invalid),
    ] {
        let mut given = table.clone();
        given.entries[0].got = got;
        assert_eq!(given.check(false, "", None).verdict, verdict, "{got}");
    }
    // An entry that has a derivative is judged by it.
    let mut given = table.clone();
    let smooth = given.entries.iter_mut().find(|entry| entry.sides.is_none()).unwrap();
    smooth.got += 1e-9;
    assert_eq!(given.check(false, "", None).verdict, Verdict::Wrong);
}

/// At half a turn of violation the angles jump: the derivative of the side that the state is on is the one that counts.
#[test]
fn a_constraint_at_half_a_turn_is_judged_from_its_side() {
    let half_turn = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    for kind in [MpcType::Beam, MpcType::Tie] {
        let case = constraint(kind, [0.0; 3], half_turn);
        let of = |planted: Option<Planted>| {
            let settings = Settings { planted, ..Settings::default() };
            let checks = case.audit(&settings, true);
            checks.into_iter().find(|check| check.quantity == Some(Quantity::FirstDerivatives)).unwrap()
        };
        let right = of(None);
        assert_eq!(right.verdict, Verdict::Singular, "{right:?}");
        let worst = right.worst.unwrap();
        let [below, above] = worst.one_sided.unwrap();
        assert!(below.is_finite() != above.is_finite() && worst.lack.unwrap().contains(" only: "));
        let wrong = of(Some(Planted::WrongEntry));
        assert_eq!(wrong.verdict, Verdict::Wrong, "{wrong:?}");
    }
}

/// Every constraint of the laws' states, moved onto the singular sets of its equations, has no false alarm there.
#[test]
fn constraints_on_singular_sets_are_no_mismatch() {
    let half_turn = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let mut singular = 0;
    for drawn in mpc::cases() {
        let mut state = drawn.state;
        // Half a turn of one against the other, exactly.
        state.master.rotation = identity();
        state.slave.rotation = half_turn;
        let [slave, master, ..] = drawn.positions;
        state.master.displacement = [0, 1, 2].map(|i| -master[i]);
        state.slave.displacement = [0, 1, 2].map(|i| -slave[i]);
        let case = MpcCase {
            constraint: drawn.constraint(),
            name: drawn.name.clone(),
            state,
            turning: Turning::none(),
            before: START,
            length: drawn.length,
        };
        for check in case.audit(&Settings::default(), true) {
            assert!(!check.verdict.is_mismatch(), "{}: {check:?}", drawn.name);
            singular += usize::from(check.verdict == Verdict::Kink);
        }
    }
    assert!(singular > 10, "{singular}");
}

/// The check of first derivatives against differences on 237 bits, a right angle of torsion on from a singular set.
fn at_singular(name: &str, measure: Measure) -> Check {
    let mut case = atlas::near(named(name), measure, 0.5, 0.0, &mut Draw::new("at")).unwrap();
    let pair = &mut case.path.last_mut().unwrap().state.pair;
    // e3b = e3a exactly, about which b has turned by a right angle.
    let [e1, e2, e3] = [0, 1, 2].map(|j| pair.a.triad.map(|row| row[j]));
    pair.b.triad = [0, 1, 2].map(|i| [e2[i], -e1[i], e3[i]]);
    let checks = audit_case(&case, &Settings::default(), true, 0);
    let sharp = Against::Oracle(Oracle::WideDifferences);
    let is_it = |check: &Check| check.quantity == Some(Quantity::FirstDerivatives) && check.against == sharp;
    checks.into_iter().find(is_it).unwrap()
}

/// Where no side has a derivative the point is singular, with the reason, and no kink; a kink has both.
#[test]
fn a_true_singularity_is_no_kink() {
    let sweep = at_singular("FLEXION-TORSION", Measure::Flexion);
    let worst = sweep.worst.unwrap();
    assert_eq!(sweep.verdict, Verdict::Singular, "{worst:?}");
    assert!(worst.entry.starts_with("∂ur3/"), "{worst:?}");
    let lack = worst.lack.unwrap();
    assert!(lack.contains("do not settle") || lack.contains("only"), "{lack}");
    // Both sides are told of a kink alone, and of a jump the one that has a derivative.
    let both = worst.one_sided.is_some_and(|sides| sides.iter().all(|side| side.is_finite()));
    assert!(!both, "{worst:?}");
    // Of a length there are both.
    let draw = &mut Draw::new("coincident");
    let mut case = atlas::near(named("AXIAL"), Measure::Distance, 0.5, 0.0, draw).unwrap();
    let pair = &mut case.path.last_mut().unwrap().state.pair;
    pair.b.displacement = [0, 1, 2].map(|i| pair.a.displacement[i] - pair.reference[i]);
    for check in audit_case(&case, &Settings::default(), true, 0) {
        let Some(worst) = &check.worst else { continue };
        match check.verdict {
            Verdict::Kink => {
                assert!(worst.one_sided.is_some_and(|sides| sides.iter().all(|side| side.is_finite())));
                let both = [Quantity::FirstDerivatives, Quantity::NodalForces, Quantity::Rate];
                assert!(
                    check.quantity.is_some_and(|quantity| both.contains(&quantity)) && worst.lack.is_none()
                );
            }
            Verdict::Singular => assert!(worst.lack.is_some(), "{check:?}"),
            verdict => assert!(!verdict.is_mismatch(), "{check:?}"),
        }
    }
}

/// The order of Taylor's remainder is judged: what falls more slowly than h², or jumps on the way, is none of a derivative. What does
/// fall so is no false alarm, at any state that is drawn, however near to a singular set.
#[test]
fn the_order_of_a_remainder_is_judged() {
    const LADDER: [f64; 5] = [1e-4, 1e-8, 1e-12, 1e-16, 1e-20];
    let allowed = 4.0 * pintle_kinematics::scalar::U;
    let of = |over_h: &dyn Fn(f64) -> f64| remainder_of(0, &LADDER.map(|h| (h, over_h(h))), allowed, 1.0);
    // With a second derivative of 1 or less: right, linear, of higher order.
    for right in [of(&|h| 0.5 * h), of(&|_| 0.0), of(&|h| h * h), of(&|h| 0.5 * h - 5000.0 * h * h)] {
        assert!(right.units() <= 1.0, "{right:?}");
    }
    assert_eq!(
        (of(&|_| 0.0).order, of(&|h| 0.5 * h).order.map(|p| (p * 100.0).round())),
        (None, Some(200.0))
    );
    // Without a second derivative, near a singular set: the third is 1/δ² and may be; what jumps there, or is wrong, may not.
    const NEAR: f64 = 1e-6;
    let near = |over_h: &dyn Fn(f64) -> f64| {
        remainder_of(0, &LADDER.map(|h| (NEAR * h, over_h(NEAR * h))), allowed, NEAR)
    };
    assert!(near(&|h| (h / NEAR).powi(2)).units() <= 1.0);
    assert!(near(&|h| (h / NEAR).powi(2) + 1e-9).units() > 1.0 && near(&|h| (h / NEAR).sqrt()).units() > 1.0);
    // A root, a wrong row, a kink between two steps, what is no number.
    for (wrong, order) in [
        (of(&|h| h.sqrt()), Some(1.5)),
        (of(&|h| 0.5 * h + 1e-9), Some(1.0)),
        (of(&|h| if h > 1e-6 { 1.0 } else { 0.5 * h }), None),
    ] {
        assert!(wrong.units() > 1.0, "{wrong:?}");
        let found = wrong.order.unwrap();
        assert!(order.is_none_or(|order| (found - order).abs() < 0.05), "{wrong:?}");
    }
    assert!(of(&|_| f64::NAN).units() > 1.0);
    let mut clear = 0;
    let mut most = 0.0_f64;
    for connection in TABLE {
        let draw = &mut Draw::new(&connection.name);
        let near = (0..25).filter_map(|_| atlas::random_near(connection, draw)).collect::<Vec<_>>();
        for case in cases(connection, Extent::Brief).into_iter().chain(near) {
            let (numbers, bound, nearness) = judged(&case);
            let truth = Truth::of(&case).unwrap();
            let active = *Narrow::of(&case).unwrap().active();
            let v = std::array::from_fn(|j| if active[j] { draw.between(-1.0, 1.0) } else { 0.0 });
            let rows = numbers.entries(Quantity::FirstDerivatives);
            for found in remainders(&truth, rows, &bound, &v, &[nearness; 6]) {
                assert!(found.units() <= 1.0, "{}: {found:?}", case.name);
                most = most.max(found.units());
                clear += usize::from(found.order.is_some_and(|order| order > 1.9));
                assert!(found.order.is_none_or(|order| order > 1.9), "{}: {found:?}", case.name);
            }
        }
    }
    println!("{clear} orders, largest {most}");
    assert!(clear > 300, "{clear}");
}

/// Where the angles of a constraint jump, second derivatives of its positions are judged as ever, and those of its angles on the sheet that
/// their values are on.
#[test]
fn second_derivatives_beside_a_singular_row_are_judged() {
    let half_turn = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    let tables = constraint(MpcType::Beam, [0.0; 3], half_turn).tables();
    let table = tables.iter().find(|table| table.quantity == Quantity::SecondDerivatives).unwrap();
    assert!(!table.check(false, "", None).verdict.is_mismatch());
    let turned =
        pintle_kinematics::mpc::THETA_S * pintle_kinematics::mpc::DOFS + pintle_kinematics::mpc::THETA_S + 1;
    let rows = table.entries.chunks(table.width());
    let is_open: Vec<bool> = rows.map(|row| row[turned].sides.is_some()).collect();
    assert!(is_open.contains(&true) && is_open.contains(&false), "{is_open:?}");
    assert_eq!(table.check(false, "", None).verdict, Verdict::Singular);
    for row in 0..is_open.len() {
        let mut given = table.clone();
        given.entries[row * table.width() + turned].got += 1e-3;
        assert_eq!(given.check(false, "", None).verdict, Verdict::Wrong, "{}", table.rows[row]);
    }
}
