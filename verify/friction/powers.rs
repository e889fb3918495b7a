//! Potentials whose exponents are below 2, at and near the zero of a contribution: infinite curvature, whose tangent has a limit.

use super::{component, criterion, friction, widened};
use pintle_kinematics::scalar::Wide;
use pintle_model::behavior::friction::{
    Branch, Coefficient, Context, Contribution, Criterion, Derived, DerivedPart, Flag, Form, Friction,
    FrictionOutcome, Input, Internal, Potential, Pressing, State, Status, StickStiffness, Tangential,
};
use pintle_scene::{Operator, PotentialFunction, PotentialOperator};

/// K.
const STIFFNESS: f64 = 1000.0;

fn potential(beta: f64, terms: Vec<Contribution>) -> Criterion {
    let potential = Potential::new(PotentialOperator::Sum, beta, terms).unwrap();
    criterion(Tangential::Potential(potential), Pressing::Component(4), Internal::Constant(0.0))
}

fn term(k: usize, exponent: f64) -> Contribution {
    Contribution { scale: 1.0, ..component(k, exponent, PotentialFunction::Abs) }
}

/// P = (|f1|^α + |f2|^α)^(1/β), pressed so that L = 1.
fn plane(alpha: f64, beta: f64) -> Friction {
    let criterion = potential(beta, vec![term(0, alpha), term(1, alpha)]);
    friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(STIFFNESS))
}

fn input(u1: f64, u2: f64) -> Input<'static, f64> {
    Input {
        displacement: [u1, u2, 0.0, 0.0, 0.0, 0.0],
        forces: [0.0, 0.0, 0.0, 0.0, 2.0, 0.0],
        duration: Some(0.1),
        context: Context::default(),
    }
}

/// What is left of f + K Δγ ∂P/∂f = f_tr beside the largest of its terms, of each component, with the gradient typed by hand.
fn left(outcome: &FrictionOutcome<f64>, alpha: f64, beta: f64, moved: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|k| {
        let (f, p) = (outcome.force[k], 1.0_f64);
        let slope = alpha / beta * p.powf(1.0 - beta) * f.abs().powf(alpha - 1.0) * f.signum();
        let [flow, trial] = [STIFFNESS * outcome.slip_increment * slope, STIFFNESS * moved[k]];
        if trial == 0.0 { f } else { (f + flow - trial) / trial }
    })
}

/// P is convex: β ≤ α. However small a traction, the equations hold beside itself; at zero it stays there, ∂f1/∂u1 = 0, and the slip takes all of u1.
#[test]
fn small_tractions_satisfy_the_flow() {
    for (alpha, beta) in [(1.5, 1.5), (1.2, 1.2), (1.8, 1.8), (1.05, 1.05), (1.8, 1.5), (1.5, 1.25)] {
        for u1 in [0.0, 1e-30, 1e-17, 1e-9, -1e-5, 1e-3, 0.1, 0.5] {
            let name = format!("{alpha} {beta} {u1}");
            let (outcome, tangent) =
                plane(alpha, beta).tangent(&State::default(), &input(u1, 0.5), Branch::Decided);
            assert_eq!((outcome.status, outcome.limit), (Status::Slip, 1.0), "{name}");
            assert!(outcome.criterion.abs() < 1e-14, "{name}: {}", outcome.criterion);
            let near_one = alpha < 1.1;
            for left in left(&outcome, alpha, beta, [u1, 0.5]) {
                // |f|^0.05 of the smallest doubles is 1e-16.
                assert!(left.abs() < 1e-13 || (near_one && u1.abs() < 1e-16), "{name}: {left}");
            }
            let is_flagged = |flag: &Flag| {
                matches!(flag, Flag::ReturnedAlongTraction | Flag::InfiniteCurvature { .. } | Flag::Unstable)
            };
            assert!(
                !outcome.flags.iter().any(is_flagged) || (near_one && u1.abs() < 1e-16),
                "{name}: {outcome:?}"
            );
            let slope = tangent.force[0].displacement[0];
            if u1 == 0.0 {
                assert_eq!((outcome.force[0], slope), (0.0, 0.0), "{name}");
            } else if !near_one || u1.abs() > 1e-4 {
                // By differences on 237 bits.
                let wide = |h: f64| {
                    let at = input(u1, 0.5);
                    let mut moved = at.displacement.map(Wide::from_f64);
                    moved[0] += Wide::from_f64(h) * Wide::from_f64(u1);
                    let moved = Input {
                        displacement: moved,
                        forces: at.forces.map(Wide::from_f64),
                        duration: at.duration.map(Wide::from_f64),
                        context: Context::default(),
                    };
                    let state = widened(&State::default());
                    plane(alpha, beta).update(&state, &moved, Branch::Decided).force[0]
                };
                let exact =
                    ((wide(1e-20) - wide(-1e-20)) / (Wide::from_f64(2e-20) * Wide::from_f64(u1))).to_f64();
                assert!((slope - exact).abs() <= 1e-12 * exact.abs(), "{name}: {slope} {exact}");
            }
        }
    }
}

/// Second derivatives are infinite there, and flagged; the tangent of an increment is not where its limit is known, and is flagged
/// where it is not.
#[test]
fn infinite_curvature_is_flagged() {
    let at = |criterion: &Criterion, f1: f64| {
        let forces = [f1, 2.0, 0.0, 0.0, 2.0, 0.0];
        criterion.derivatives(&forces, 0.5, None, &Context::default()).1
    };
    let is_curved = |flags: &[Flag]| flags.contains(&Flag::InfiniteCurvature { term: 1 });
    for (alpha, beta, expected) in
        [(1.5, 1.5, true), (1.5, 2.0, true), (0.5, 2.0, true), (2.0, 1.5, false), (3.0, 3.0, false)]
    {
        let criterion = plane(alpha, beta).criterion;
        assert_eq!(is_curved(&at(&criterion, 0.0)), expected, "{alpha} {beta}");
        assert!(!is_curved(&at(&criterion, 1e-9)), "{alpha} {beta}");
    }
    // |f1 + f3|^1.5 + |f2|^1.5: no unknown of the equations is f1 + f3.
    let part = DerivedPart {
        operator: Operator::Sum,
        sign: 1.0,
        components: vec![0, 2],
        scale: None,
        independent: None,
    };
    let sum = Contribution { of: Form::Derived(Derived { parts: vec![part] }), ..term(0, 1.5) };
    let criterion = potential(1.5, vec![sum, term(1, 1.5)]);
    let friction = friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(STIFFNESS));
    let outcome = friction.update(&State::default(), &input(0.0, 0.5), Branch::Decided);
    assert!(is_curved(&outcome.flags), "{:?}", outcome.flags);
    assert_eq!(Flag::InfiniteCurvature { term: 1 }.name(), "infinite-curvature");
}

/// Squares are curved at zero whatever exponents stand beside them: ∂²P/∂f1² = (2/β) P^(1 − β), of P = (f1² + |f2|^α)^(1/β).
#[test]
fn squares_are_curved_at_zero_in_any_sum() {
    for (beta, other) in [(1.5, 2.0), (1.5, 1.5), (2.0, 4.0), (3.0, 2.0), (3.0, 3.0), (1.0, 2.0), (2.5, 1.0)]
    {
        let criterion = potential(beta, vec![term(0, 2.0), term(1, other)]);
        let forces = [0.0, 2.0, 0.0, 0.0, 2.0, 0.0];
        let (point, _) = criterion.derivatives(&forces, 0.5, None, &Context::default());
        let p = 2.0_f64.powf(other / beta);
        let expected = 2.0 / beta * p.powf(1.0 - beta);
        let found = point.tangential.hessian[0][0];
        assert!((found - expected).abs() < 4e-15 * expected, "{beta} {other}: {found} {expected}");
    }
}

/// While μ falls with the slip rate, Newton's method from stick is led over the zero of the traction; from what lies along the traction it
/// is not. Of one direction the slope is that of the limit, L'/(1 + L'/K).
#[test]
fn a_return_of_many_decades_is_against_the_gradient() {
    let criterion = potential(3.0, vec![term(0, 3.0), term(1, 3.0)]);
    let coefficient = Coefficient::Exponential { at_rest: 0.5, kinetic: 0.2, decay: 0.003 };
    let friction = friction(&criterion, &coefficient, StickStiffness::Given(1e7));
    let far = Input { duration: Some(0.2), forces: [0.0, 0.0, 0.0, 0.0, 2e6, 0.0], ..input(0.0, 1250.0) };
    let (outcome, tangent) = friction.tangent(&State::default(), &far, Branch::Decided);
    assert!(!outcome.flags.contains(&Flag::ReturnedAlongTraction), "{:?}", outcome.flags);
    let decay = 0.003 / 0.2;
    let slope = -0.3 * 2e6 * decay * (-decay * outcome.slip_increment).exp();
    let expected = slope / (1.0 + slope / 1e7);
    let found = tangent.force[1].displacement[1];
    assert!((found / expected - 1.0).abs() < 1e-13, "{found} {expected}");
}

/// A limit that falls faster than the spring unloads has no stable slip, of a potential as of a norm; no slip is negative.
#[test]
fn a_limit_that_falls_faster_is_told_of_potentials() {
    for (decay, is_unstable) in [(1.0, false), (1000.0, true)] {
        let coefficient = Coefficient::Exponential { at_rest: 0.5, kinetic: 0.2, decay };
        for exponent in [1.5, 2.0, 3.0] {
            let criterion = potential(exponent, vec![term(0, exponent), term(1, exponent)]);
            let friction = friction(&criterion, &coefficient, StickStiffness::Given(STIFFNESS));
            // At the threshold: f_tr = L.
            let outcome = friction.update(&State::default(), &input(0.0, 1e-3), Branch::Slip);
            assert!(outcome.slip_increment >= 0.0, "{decay} {exponent}: {outcome:?}");
            if outcome.slip_increment < 1e-12 {
                assert_eq!(
                    outcome.flags.contains(&Flag::Unstable),
                    is_unstable,
                    "{decay} {exponent}: {outcome:?}"
                );
            }
        }
    }
}
