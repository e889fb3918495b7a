//! What a friction says of itself to the rest of the crate.

use crate::behavior::Wrap;
use crate::behavior::friction::criterion::FactorMistake;
use crate::behavior::friction::criterion::FactorMistake::{Multiplied, NumberLeftOut};
use crate::behavior::friction::{
    Context, Contribution, Criterion, Derived, DerivedPart, Form, Potential, Tangential, is_divisor,
    wrap_angle,
};
use crate::behavior::table::Table;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::vector::sub;
use pintle_scene::{Basis, Extrapolation, Operator, PotentialFunction, PotentialOperator};

mod powers; // sums of powers, and the unknowns in which they are curved finitely
mod returns; // the slip equations, their tangents and their answers

#[test]
fn divisors_are_positive_and_have_a_reciprocal() {
    for x in [1.0, -0.0 + 1e300, f64::MIN_POSITIVE] {
        assert!(is_divisor(x), "{x}");
    }
    for x in [0.0, -0.0, -1.0, 5e-324, f64::INFINITY, f64::NAN] {
        assert!(!is_divisor(x), "{x}");
    }
}

fn mistakes(name: &str, numbers: &[f64], forces: [f64; 6]) -> Vec<(FactorMistake, f64, f64)> {
    let friction = ConnectionType::named(name, None).unwrap().friction.unwrap();
    let numbers: Vec<Option<f64>> = numbers.iter().copied().map(Some).collect();
    let criterion = Criterion::predefined(&friction, &numbers, &[], false).unwrap().remove(0);
    let found = criterion.factor_mistakes();
    let at = |wrong: &Criterion| wrong.at(&forces, 0.5, None, &Context::default()).0;
    found.iter().map(|(mistake, wrong)| (*mistake, at(wrong).contact, at(wrong).tangential)).collect()
}

/// TRANSLATOR: |m1|/R_r + √(f2² + f3²) + 2 √(m2² + m3²)/L with R_r = 0.5, L = 0.25; CYLINDRICAL: √(f1² + (m1/R)²) with R = 0.25.
#[test]
fn mistakes_are_made_in_every_factor() {
    let forces = [3.0, 3.0, 4.0, 2.0, 0.0, 1.0];
    let right = 2.0 / 0.5 + 5.0 + 2.0 / 0.25;
    let wrong = |term: f64, instead: f64| right - term + instead;
    assert_eq!(
        mistakes("TRANSLATOR", &[0.5, 0.25], forces),
        [
            (Multiplied, wrong(4.0, 2.0 * 0.5), 3.0),
            (NumberLeftOut, wrong(8.0, 1.0 / 0.25), 3.0),
            (Multiplied, wrong(8.0, 2.0 * 0.25), 3.0),
        ]
    );
    // Nothing is wrong with a radius of 1, multiplied or divided by.
    assert!(mistakes("CYLINDRICAL", &[1.0], forces).is_empty());
    let [(mistake, contact, tangential)] = mistakes("CYLINDRICAL", &[0.25], forces)[..] else {
        panic!("one factor, one mistake")
    };
    assert_eq!((mistake, contact), (Multiplied, 5.0));
    assert!((tangential - 3.0_f64.hypot(2.0 * 0.25)).abs() < 1e-15);
}

/// A potential is formed from its shifts too, and moves where a scale factor depends on the position.
#[test]
fn shifts_and_moving_factors_are_known() {
    let contribution = |of, shift| Contribution {
        of,
        scale: 1.0,
        exponent: 2.0,
        function: PotentialFunction::Abs,
        shift,
        sign: 1.0,
    };
    let potential = |contributions| Potential::new(PotentialOperator::Sum, 2.0, contributions).unwrap();
    let plain = vec![contribution(Form::Component(0), 0.5), contribution(Form::Component(1), -0.25)];
    let still = potential(plain.clone());
    assert_eq!((still.shift(), still.moves()), (0.75, false));
    let centred = |k| Contribution { scale: -2.0, ..contribution(Form::Component(k), 0.0) };
    assert_eq!(potential(vec![centred(0), centred(1)]).norm(), Some(vec![(0, 2.0), (1, 2.0)]));
    assert_eq!([still.norm(), potential(vec![centred(0), centred(0)]).norm()], [None, None]);
    let part = |independent| {
        let scale = Some(Table::curve(&[(0.0, 1.0), (1.0, 2.0)], Extrapolation::Linear).unwrap());
        let part =
            DerivedPart { operator: Operator::Sum, sign: 1.0, components: vec![2], scale, independent };
        contribution(Form::Derived(Derived { parts: vec![part] }), 0.0)
    };
    let with = |part| potential(plain.iter().cloned().chain([part]).collect());
    assert!(!with(part(None)).moves());
    assert!(with(part(Some((Basis::Position, vec![0])))).moves());
    assert!(matches!(Tangential::Potential(still).components()[..], [0, 1]));
}

/// How an angle of wrap changes as the nodes of both segments move: differences on 237 bits, by node and direction.
#[test]
fn angles_of_wrap_change_with_every_node() {
    let points = [[0.1, -0.2, 0.3], [0.4, 1.1, 0.2], [1.3, 0.9, -0.5]];
    let (angle, wrap) = Wrap::measured(sub(points[1], points[0]), sub(points[2], points[1]));
    let at = |node: usize, direction: usize, h: f64| {
        let mut moved = points.map(|point| point.map(Wide::from_f64));
        moved[node][direction] += h;
        wrap_angle(moved[0], moved[1], moved[2]).0
    };
    assert!((angle - at(0, 0, 0.0).to_f64()).abs() < 1e-15);
    let Wrap::Measured(gradient) = wrap else { panic!("{wrap:?}") };
    for node in 0..3 {
        for direction in 0..3 {
            let exact = ((at(node, direction, 1e-25) - at(node, direction, -1e-25)) / 2e-25).to_f64();
            assert!((gradient[node][direction] - exact).abs() < 2e-15, "{node} {direction}: {exact}");
        }
    }
    assert_eq!(Wrap::measured([1.0, 0.0, 0.0], [2.0, 0.0, 0.0]), (0.0, Wrap::Kink));
}

/// Terms of derived components go to files and come back, up to as many components as there is room for; factors must be as many.
#[test]
fn terms_are_read_back_or_refused() {
    let table = |outputs: usize| {
        let values = (0..outputs).map(|n| Some(n as f64)).collect();
        let row = pintle_scene::TableRow { values, ..Default::default() };
        Table::new(&[row], outputs, &[], Extrapolation::Constant).unwrap()
    };
    let read = |count: usize, factors: Option<usize>| {
        let part = DerivedPart {
            operator: Operator::Sum,
            sign: -1.0,
            components: (0..count).map(|k| k % 6).collect(),
            scale: factors.map(table),
            independent: None,
        };
        let read = serde_json::from_value::<DerivedPart>(serde_json::to_value(&part).unwrap());
        assert!(read.as_ref().map_or(true, |found| *found == part));
        read.map_err(|error| error.to_string()).err()
    };
    let most = crate::behavior::friction::MOST_CONTRIBUTIONS;
    assert_eq!([read(1, None), read(most, None), read(most - 1, None)], [const { None }; 3]);
    assert!(read(most + 1, None).unwrap().contains("takes at most"));
    assert!(read(most + 2, None).is_some());
    assert_eq!([read(3, Some(3)), read(3, Some(4)), read(1, Some(1))], [const { None }; 3]);
    assert!(read(3, Some(2)).unwrap().contains("of 3 components has 2 scale factors"));
    assert!(read(4, Some(1)).is_some());
}
