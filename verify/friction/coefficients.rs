//! Coefficients of friction, and the slip at which a limit that changes with it is met first.

use super::criterion;
use pintle_model::behavior::friction::{
    Branch, Coefficient, CoefficientError, Context, Flag, Friction, Input, Internal, Pressing, State,
    StickStiffness, Tangential,
};
use pintle_model::behavior::table::Table;
use pintle_scene::{Basis, Extrapolation, TableRow};

/// A decay through test data meets them; data through which there is none are refused.
#[test]
fn decays_meet_test_data() {
    let at = |coefficient: &Coefficient, rate: f64| match coefficient {
        Coefficient::Exponential { at_rest, kinetic, decay } => {
            kinetic + (at_rest - kinetic) * (-decay * rate).exp()
        }
        _ => panic!("a decay"),
    };
    for (second, rate, limit) in [(0.21, 2.0, 0.2), (0.15, 0.5, 0.0), (0.3, 1.0, 0.1)] {
        let decay = Coefficient::test_data(0.3, (second, rate), Some(limit)).unwrap();
        assert!(
            (at(&decay, rate) - second).abs() < 1e-15 && (at(&decay, 1e9) - limit).abs() < 1e-9
                || second == 0.3
        );
        assert_eq!(at(&decay, 0.0), 0.3);
    }
    // Without the limit, 95 % of the fall are done at the second point.
    let decay = Coefficient::test_data(0.3, (0.205, 2.0), None).unwrap();
    assert!((at(&decay, 2.0) - 0.205).abs() < 1e-15 && (at(&decay, 1e9) - 0.2).abs() < 1e-15);
    let refused = |first, second, limit| Coefficient::test_data(first, second, limit).unwrap_err();
    for (first, second, limit) in [
        (-0.1, 0.2, 0.1),
        (0.3, -0.2, 0.1),
        (0.3, 0.2, -0.1),
        (f64::NAN, 0.2, 0.1),
        (0.3, f64::INFINITY, 0.1),
    ] {
        let error = refused(first, (second, 1.0), Some(limit));
        assert!(matches!(error, CoefficientError::Negative(_)), "{first} {second} {limit}: {error}");
    }
    // Beyond the first, at the limit, below the limit; no rate, and one backwards.
    for (second, rate, limit) in
        [(0.4, 1.0, 0.1), (0.1, 1.0, 0.1), (0.05, 1.0, 0.1), (0.2, 0.0, 0.1), (0.2, -1.0, 0.1)]
    {
        let error = refused(0.3, (second, rate), Some(limit));
        assert!(matches!(error, CoefficientError::TestData { .. }), "{second} {rate}: {error}");
    }
    // No friction at all once the decay is over is a limit like any other; so is none at rest, where there is nothing to fall.
    assert!(Coefficient::test_data(0.3, (0.0, 1.0), Some(0.0)).is_err());
}

fn rows(data: &[[f64; 3]]) -> Coefficient {
    let row = |values: &[f64; 3]| TableRow { values: values.map(Some).to_vec(), ..TableRow::default() };
    let rows: Vec<TableRow> = data.iter().map(row).collect();
    Coefficient::Table(Table::new(&rows, 1, &["rate", "force"], Extrapolation::Constant).unwrap())
}

#[test]
fn coefficients_say_whether_the_rate_counts() {
    let decay = |at_rest, kinetic, decay| Coefficient::Exponential { at_rest, kinetic, decay };
    for (coefficient, expected) in [
        (Coefficient::Constant(0.3), false),
        (decay(0.3, 0.2, 1.0), true),
        (decay(0.3, 0.3, 1.0), false),
        (decay(0.3, 0.2, 0.0), false),
        (rows(&[[0.3, 0.0, 0.0], [0.2, 1.0, 0.0]]), true),
        (rows(&[[0.3, 0.0, 0.0], [0.2, 0.0, 1.0]]), false),
    ] {
        assert_eq!(coefficient.depends_on_rate(), expected, "{coefficient:?}");
    }
}

/// A friction of component 1 pressed by component 2, or by an internal force over accumulated slip, with K_s = 0.1.
fn friction(coefficient: Coefficient, internal: Option<Table>) -> Friction {
    let (pressing, internal) = match internal {
        Some(table) => {
            (Pressing::Nothing, Internal::Table { table, basis: Basis::Position, components: vec![] })
        }
        None => (Pressing::Component(1), Internal::Constant(0.0)),
    };
    Friction {
        criterion: criterion(Tangential::Norm(vec![(0, 1.0)]), pressing, internal),
        coefficient,
        maximum: None,
        stick_stiffness: StickStiffness::Given(0.1),
        radius: 1.0,
    }
}

/// The traction 1 after a motion of 10 falls by 0.1 for each unit of slip, and meets the limit where it is reached first: on the
/// flank of a bump that two smooth stretches hide. 1 − 0.1 x = 0.2 + 80 (x − 1).
#[test]
fn the_first_slip_that_meets_the_limit_is_taken() {
    let first = 80.8 / 80.1;
    let bump = |by: f64| [(0.0, 0.2), (by, 0.2), (by + 0.01, 1.0), (by + 0.02, 0.2), (by + 9.0, 0.2)];
    let by_rate: Vec<[f64; 3]> = bump(1.0).iter().map(|(x, y)| [*y, x / 2.0, 0.0]).collect();
    let input = Input {
        displacement: [10.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        forces: [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        duration: Some(2.0),
        context: Context::default(),
    };
    for sign in [1.0, -1.0] {
        let mut input = input.clone();
        input.displacement[0] *= sign;
        let outcome = friction(rows(&by_rate), None).update(&State::default(), &input, Branch::Decided);
        assert!((outcome.slip_increment - first).abs() < 1e-12, "by rate: {}", outcome.slip_increment);
        assert!(
            (outcome.force[0] - sign * (1.0 - 0.1 * first)).abs() < 1e-12
                && outcome.slip_rate * 2.0 == outcome.slip_increment
        );
        // The same bump over the accumulated slip, of which 3 is behind; with and without a rate.
        let internal = Table::curve(&bump(4.0), Extrapolation::Constant).unwrap();
        let before = State { accumulated_slip: 3.0, ..State::default() };
        let accumulated = friction(Coefficient::Constant(1.0), Some(internal));
        let outcome = accumulated.update(&before, &input, Branch::Decided);
        assert!((outcome.slip_increment - first).abs() < 1e-12, "by slip: {}", outcome.slip_increment);
        assert!((outcome.accumulated_slip - 3.0 - first).abs() < 1e-12);
        input.duration = None;
        assert_eq!(
            accumulated.update(&before, &input, Branch::Decided).slip_increment,
            outcome.slip_increment
        );
    }
}

/// τ_max caps the limit: below it nothing is said, at it the kink is, above it the limit stays.
#[test]
fn limits_are_capped() {
    for (force, limit, is_kink) in [(3.0, 1.5, false), (4.0, 2.0, true), (5.0, 2.0, false)] {
        let mut capped = friction(Coefficient::Constant(0.5), None);
        capped.maximum = Some(2.0);
        let input = Input {
            displacement: [100.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            forces: [0.0, force, 0.0, 0.0, 0.0, 0.0],
            duration: None,
            context: Context::default(),
        };
        let outcome = capped.update(&State::default(), &input, Branch::Decided);
        assert_eq!(outcome.limit, limit, "{force}");
        assert_eq!(outcome.flags.contains(&Flag::LimitAtMaximum), is_kink, "{force}");
    }
}
