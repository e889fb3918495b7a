//! Where verdicts differ by little: a formula that is right or nearly so, derivatives on singular sets.

use crate::audit::{judged, named};
use crate::laws::mpc;
use pintle::audit::oracle::WideAnswers;
use pintle::audit::sample::{Draw, Extent, Region, cases, draw_case};
use pintle::audit::truth::Truth;
use pintle::audit::verdict::{Exact, Surroundings, judge};
use pintle::audit::{
    Against, Bound, Case, MpcCase, Numbers, Oracle, Planted, Quantity, Settings, Verdict, atlas, audit_case,
};
use pintle::catalog::{ConnectionType, TABLE};
use pintle::connector::{Definition, Turns};
use pintle::mpc::{Body, Kind, State, Turning};
use pintle::node::{Node, Pair};
use pintle::scalar::Wide;
use pintle::vector::identity;
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
    let verdict = |off: f64| {
        let product = truth.map(|_, _, x| x + Wide::from_f64(off * tolerance));
        let exact = |_: Quantity| Some(Exact { product: &product, truth });
        let around =
            Surroundings { bound: &bound, exact: Some(&exact), nearness: [nearness; 6], sides: None };
        let oracles = [Oracle::WideDifferences, Oracle::WideDual, Oracle::WideSymbolic];
        oracles
            .map(|oracle| judge(quantity, &got, &answers.answer(oracle, quantity).unwrap(), &around).verdict)
    };
    assert_eq!(verdict(1e-12), [Verdict::UnstableFormula; 3]);
    for off in [1e-7, 1e-3, 0.5, -0.5] {
        assert_eq!(verdict(off), [Verdict::Wrong; 3], "{off}");
    }
    // Without a witness nothing is proven.
    let around = Surroundings { bound: &bound, exact: None, nearness: [nearness; 6], sides: None };
    let answer = answers.answer(Oracle::WideDifferences, quantity).unwrap();
    assert_eq!(judge(quantity, &got, &answer, &around).verdict, Verdict::Wrong);
}

/// Dual numbers and differences on 237 bits agree to a billionth of a tolerance and less, in every quantity of every type, and near
/// singular sets to what differences there are worth (1e-20/δ), where triads are rotations: what is further apart is no rounding.
#[test]
fn duals_and_differences_agree_far_below_the_tolerance() {
    let mut all_most = BTreeMap::<Quantity, (f64, String)>::new();
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
            let answers = WideAnswers::of(&Truth::of_rotations(&case).unwrap());
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
                    let most = all_most.entry(quantity).or_default();
                    if units > most.0 {
                        *most = (units, format!("{} {}", case.name, quantity.entry_name(k, i)));
                    }
                }
            }
        }
    }
    println!("{compared} entries; {all_most:?}");
    assert!(compared > 10_000);
    for (quantity, (most, place)) in all_most {
        assert!(most < 1e-9, "{}: {most:e} at {place}", quantity.name());
    }
}

fn bound_of(case: &Case, answers: &WideAnswers, nearness: f64) -> Bound {
    let mut numbers = Numbers::default();
    for quantity in Quantity::ALL {
        numbers.set(quantity, answers.differences.entries(quantity).map(|_, _, x| x.to_f64()));
    }
    let state = &case.last().unwrap().state;
    Bound::new(&numbers, &state.velocity, &state.acceleration, case.length, nearness)
}

/// On a singular set of one component another one is judged as ever: what is wrong there is no kink.
#[test]
fn an_error_beside_a_kink_is_wrong() {
    let connection = ConnectionType::named("JOIN", Some("FLEXION-TORSION")).unwrap();
    let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    let definition = Definition::new(connection, Pair { reference: [0.0; 3], a: node, b: node });
    let pair = definition.initial;
    let step = pintle::audit::Step::between(&pair, pair);
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
    assert_eq!(of(None).verdict, Verdict::Kink);
    // The formula is right, the number is not.
    let wrong = of(Some(Planted::WrongEntry));
    assert_eq!(wrong.verdict, Verdict::UnstableFormula, "{wrong:?}");
    assert!(wrong.worst.unwrap().entry.starts_with("∂u1/∂"));
}

fn constraint(kind: Kind, separation: [f64; 3], slave: [[f64; 3]; 3]) -> MpcCase {
    let positions = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]];
    let body = |displacement, rotation| Body { displacement, rotation, flow: 0.0 };
    let [first, second, third, fourth] = positions;
    let displacement = [0, 1, 2].map(|i| second[i] - first[i] + separation[i]);
    let mut velocity = [0.0; pintle::mpc::DOFS];
    velocity[..3].copy_from_slice(&[0.25, -0.5, 1.0]);
    MpcCase {
        name: format!("{} on a singular set", kind.name()),
        constraint: pintle::mpc::Constraint::new(kind, first, second, [third, fourth]).with_flow(),
        state: State {
            slave: body(displacement, slave),
            master: body([0.0; 3], identity()),
            angles: [None; 2],
            velocity,
            acceleration: [0.0; pintle::mpc::DOFS],
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
    let case = constraint(Kind::Link, [0.0; 3], identity());
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
    let sheets = case.sheets();
    let sheet = sheets.iter().find(|sheet| sheet.quantity == Quantity::FirstDerivatives).unwrap();
    for (got, verdict) in [
        (0.5, Verdict::Kink),
        (1.0, Verdict::Kink),
        (-1.0, Verdict::Kink),
        (1.0 + 1e-9, Verdict::Wrong),
        (-7.0, Verdict::Wrong),
        (f64::NAN, Verdict::Invalid),
    ] {
        let mut given = sheet.clone();
        given.entries[0].got = got;
        assert_eq!(given.check(0.0, false, "", None).verdict, verdict, "{got}");
    }
    // An entry that has a derivative is judged by it.
    let mut given = sheet.clone();
    let smooth = given.entries.iter_mut().find(|entry| entry.sides.is_none()).unwrap();
    smooth.got += 1e-9;
    assert_eq!(given.check(0.0, false, "", None).verdict, Verdict::Wrong);
}

/// At half a turn of violation the angles jump: the derivative of the side that the state is on is the one that counts.
#[test]
fn a_constraint_at_half_a_turn_is_judged_from_its_side() {
    let half_turn = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    for kind in [Kind::Beam, Kind::Tie] {
        let case = constraint(kind, [0.0; 3], half_turn);
        let of = |planted: Option<Planted>| {
            let settings = Settings { planted, ..Settings::default() };
            let checks = case.audit(&settings, true);
            checks.into_iter().find(|check| check.quantity == Some(Quantity::FirstDerivatives)).unwrap()
        };
        let right = of(None);
        assert_eq!(right.verdict, Verdict::Kink, "{right:?}");
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
