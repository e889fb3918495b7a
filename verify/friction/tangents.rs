//! The consistent tangent of an increment against differences on 237 bits, in stick, slip and freedom.

use super::{Numbers, U, coefficients, component, criterion, friction, predefined, scales, users, widened};
use crate::states::Draw;
use crate::tolerance::friction as gate;
use pintle_kinematics::scalar::Wide;
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::{
    Belt, BeltInput, Branch, Coefficient, Context, Contribution, Criterion, Derived, DerivedPart, FLOW, Flag,
    Form, Friction, FrictionOutcome, Input, Internal, Potential, Pressing, State, Status, StickStiffness,
    Tangential, wrap_angle,
};
use pintle_scene::{Basis, Operator, PotentialFunction, PotentialOperator};
use std::collections::BTreeMap;

/// The quantities that a tangent is given of.
fn results(friction: &Friction, state: &State<Wide>, input: &Input<'_, Wide>) -> [Wide; 9] {
    let outcome = friction.update(state, input, Branch::Decided);
    let [f1, f2, f3, m1, m2, m3] = outcome.force;
    [f1, f2, f3, m1, m2, m3, outcome.slip_increment, outcome.normal, outcome.limit]
}

/// Displacement of component j moves its position and motion too.
fn moved(numbers: &Numbers, input: usize, h: f64) -> Input<'static, Wide> {
    let mut moved = numbers.input::<Wide>();
    match input {
        0..6 => {
            moved.displacement[input] += h;
            moved.context.position[input] += h;
            moved.context.motion[input] += h;
        }
        6..12 => moved.forces[input - 6] += h,
        _ => moved.duration = moved.duration.map(|duration| duration + h),
    }
    moved
}

/// The tangent of an increment against differences, and its forces against those on 237 bits; what the increment does.
fn agree(
    name: &str,
    friction: &Friction,
    state: &State<f64>,
    numbers: &Numbers,
    worst: &mut (f64, String),
) -> FrictionOutcome<f64> {
    let (outcome, tangent) = friction.tangent(state, &numbers.input(), Branch::Decided);
    let wide = widened(state);
    assert!(outcome.force.iter().all(|x| x.is_finite()), "{name}: {outcome:?}");
    let [f1, f2, f3, m1, m2, m3] = tangent.force;
    let partials = [f1, f2, f3, m1, m2, m3, tangent.slip_increment, tangent.normal, tangent.limit];
    let truth = results(friction, &wide, &numbers.input());
    // Forces and slips in their own units; the largest of each is the scale of all.
    let force_size = outcome.limit.abs().max(outcome.tangential.abs()).max(0.1);
    for j in 0..13 {
        let h = 1e-25;
        let [above, below] = [h, -h].map(|h| results(friction, &wide, &moved(numbers, j, h)));
        for (i, partial) in partials.iter().enumerate() {
            let exact = ((above[i] - below[i]) / (2.0 * h)).to_f64();
            let given = match j {
                0..6 => partial.displacement[j],
                6..12 => partial.forces[j - 6],
                _ => partial.duration,
            };
            let row = partials[i]
                .displacement
                .iter()
                .chain(&partials[i].forces)
                .fold(partials[i].duration.abs() * 0.1, |most: f64, x| most.max(x.abs()));
            let scale = row + force_size + if j == 12 { 10.0 * exact.abs() } else { 0.0 };
            let error = (given - exact).abs() / (U * scale);
            if error > worst.0 {
                *worst = (error, format!("{name}: ∂{i}/∂{j} {:?}", outcome.flags));
            }
            assert!(
                error <= gate("tangents"),
                "{name}: ∂{i}/∂{j} = {given} not {exact} ({error} u)\n{outcome:?}"
            );
        }
    }
    for (i, value) in outcome.force.iter().enumerate() {
        let error = (value - truth[i].to_f64()).abs() / (U * (force_size + value.abs()));
        assert!(error <= gate("forces"), "{name}: force {i} {value} {} ({error} u)", truth[i]);
    }
    outcome
}

#[test]
fn tangents_are_those_of_differences() {
    let mut draw = Draw::new("friction tangents");
    let mut criteria: Vec<(String, Criterion)> =
        predefined(&mut draw, false).into_iter().map(|(name, i, _, c)| (format!("{name} {i}"), c)).collect();
    criteria.extend(users().into_iter().map(|(name, c)| (name.to_string(), c)));
    let mut met: BTreeMap<String, usize> = BTreeMap::new();
    let mut worst = (0.0_f64, String::new());
    for (name, criterion) in &criteria {
        for (law, coefficient) in coefficients() {
            for stiffness in [StickStiffness::Given(40.0), StickStiffness::ElasticSlip(0.02)] {
                let mut friction = friction(criterion, &coefficient, stiffness);
                if law == "constant" && name.starts_with("HINGE") {
                    friction.maximum = Some(0.4);
                }
                let mut state: State<f64> = State::default();
                for step in 0..3 {
                    let numbers = Numbers::drawn(&mut draw, [0.1, 0.01, 0.03][step]);
                    let of = format!("{name}, {law}, {stiffness:?}, step {step}");
                    let outcome = agree(&of, &friction, &state, &numbers, &mut worst);
                    let status = format!("{:?}", outcome.status);
                    let kind = if name.contains(char::is_lowercase) { "user" } else { "predefined" };
                    *met.entry(format!("{kind} {status}")).or_default() += 1;
                    if outcome.flags.contains(&Flag::ReturnedAlongTraction) {
                        *met.entry("along traction".into()).or_default() += 1;
                    }
                    state = outcome.state();
                }
            }
        }
    }
    println!("worst {worst:?}; {met:?}");
    for kind in ["predefined Stick", "predefined Slip", "user Stick", "user Slip", "along traction"] {
        assert!(met.contains_key(kind), "no {kind}: {met:?}");
    }
}

/// √(f1²/R² + X²/R²) with X the norm of moments that constitutive motions scale.
fn scaled_by_motion() -> Criterion {
    let part = DerivedPart {
        operator: Operator::Norm,
        sign: 1.0,
        components: vec![3, 4],
        scale: Some(scales()),
        independent: Some((Basis::ConstitutiveMotion, vec![0, 1])),
    };
    let own = component(0, 2.0, PotentialFunction::Abs);
    let moving = Contribution { of: Form::Derived(Derived { parts: vec![part] }), ..own.clone() };
    let potential = Potential::new(PotentialOperator::Sum, 2.0, vec![own, moving]).unwrap();
    criterion(Tangential::Potential(potential), Pressing::Component(5), Internal::Constant(0.2))
}

/// The same in a hurry: potentials whose scale factors move, exponents of every kind and edges, while μ changes with the slip rate.
#[test]
fn tangents_of_potentials_while_coefficients_fall() {
    let mut draw = Draw::new("friction tangents of potentials");
    let coefficient = Coefficient::Exponential { at_rest: 0.45, kinetic: 0.15, decay: 2.0 };
    let mut worst = (0.0_f64, String::new());
    let (mut slips, mut along) = (0, 0);
    let named = ["norm scaled by position", "mixed exponents", "cubic", "linear", "scaled by position"];
    let mut criteria: Vec<_> = users().into_iter().filter(|(name, _)| named.contains(name)).collect();
    criteria.push(("norm scaled by motion", scaled_by_motion()));
    for (name, criterion) in criteria {
        let friction = friction(&criterion, &coefficient, StickStiffness::Given(40.0));
        let mut numbers = Numbers { duration: Some(0.4), ..Numbers::drawn(&mut draw, 0.5) };
        if name == "linear" {
            // Towards an edge, where there is no normal.
            numbers.displacement = [0.01, 5.0, 0.0, 0.0, 0.0, 0.0];
        }
        let outcome = agree(name, &friction, &State::default(), &numbers, &mut worst);
        slips += usize::from(outcome.status == Status::Slip);
        along += usize::from(outcome.flags.contains(&Flag::ReturnedAlongTraction));
    }
    println!("worst {worst:?}");
    assert_eq!(slips, 6);
    assert!(along > 0);
}

/// F_C = α √(m1² + 4 m2²) with α = 1 + 0.3 u1 − 0.2 u2, by positions or by constitutive motions: sliding along u1 changes what presses.
#[test]
fn scale_factors_that_move_have_their_slopes() {
    for basis in [Basis::Position, Basis::ConstitutiveMotion] {
        let part = DerivedPart {
            operator: Operator::Norm,
            sign: 1.0,
            components: vec![3, 4],
            scale: Some(scales()),
            independent: Some((basis, vec![0, 1])),
        };
        let pressing = Pressing::Derived(Derived { parts: vec![part] });
        let criterion = criterion(Tangential::Norm(vec![(0, 1.0)]), pressing, Internal::Constant(0.1));
        let friction = friction(&criterion, &Coefficient::Constant(0.5), StickStiffness::Given(1e3));
        let place = [0.7, 0.4, 0.0, 0.0, 0.0, 0.0];
        let elsewhere = [-0.3, 0.9, 0.0, 0.0, 0.0, 0.0];
        let (position, motion) =
            if basis == Basis::Position { (place, elsewhere) } else { (elsewhere, place) };
        let input = Input {
            displacement: [0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
            forces: [0.0, 0.0, 0.0, 3.0, 2.0, 0.0],
            duration: None,
            context: Context { position, motion, ..Context::default() },
        };
        let (outcome, tangent) = friction.tangent(&State::default(), &input, Branch::Decided);
        assert_eq!(outcome.status, Status::Slip);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 4e-15, "{basis:?}: {a} {b}");
        near(outcome.force[0], 0.5 * (5.0 * 1.13 + 0.1));
        near(tangent.force[0].displacement[0], 0.5 * 5.0 * 0.3);
        near(tangent.force[0].displacement[1], 0.5 * 5.0 * -0.2);
        near(tangent.force[0].forces[3], 0.5 * 1.13 * 0.6);
        near(tangent.force[0].forces[4], 0.5 * 1.13 * 1.6);
    }
}

/// The part −μ ∂F_N/∂λ couples friction to the constraint forces one way only.
#[test]
fn slip_is_unsymmetric() {
    let translator =
        pintle_kinematics::catalog::ConnectionType::named("TRANSLATOR", None).unwrap().friction.unwrap();
    let criterion =
        Criterion::predefined(&translator, &[Some(0.5), Some(0.25)], &[], false).unwrap().remove(0);
    let friction = friction(&criterion, &Coefficient::Constant(0.25), StickStiffness::Given(1e3));
    let input = Input {
        displacement: [-0.5, 0.0, 0.0, 0.0, 0.0, 0.0],
        forces: [0.0, 3.0, -4.0, 2.0, 0.0, 1.0],
        duration: None,
        context: Context::default(),
    };
    let (outcome, tangent) = friction.tangent(&State::default(), &input, Branch::Decided);
    assert_eq!(outcome.status, Status::Slip);
    // F_C = 2/0.5 + 5 + 8·1 = 17 resists motion towards −u1.
    assert_eq!(outcome.force[0], -0.25 * 17.0);
    assert_eq!(tangent.force[0].forces, [0.0, -0.25 * 0.6, 0.25 * 0.8, -0.25 * 2.0, 0.0, -0.25 * 8.0]);
    assert_eq!(tangent.force[0].displacement, [0.0; 6]);
    assert_eq!(tangent.force[1].displacement, [0.0; 6]);
}

#[test]
fn tangents_of_belts_are_those_of_differences() {
    let mut draw = Draw::new("belt tangents");
    let conditions = Conditions::default();
    let mut met = BTreeMap::<String, usize>::new();
    for (law, coefficient) in coefficients() {
        for stick_stiffness in [StickStiffness::Given(50.0), StickStiffness::ElasticSlip(0.01)] {
            let belt = Belt { coefficient: coefficient.clone(), maximum: None, stick_stiffness };
            let mut state = State::default();
            for step in 0..40 {
                let numbers = [
                    draw.between(-0.03, 0.03),
                    draw.between(0.5, 4.0),
                    draw.between(0.5, 4.0),
                    draw.between(0.1, 3.0),
                    draw.between(0.01, 0.1),
                ];
                let input = |x: [Wide; 5]| BeltInput {
                    flow: x[0],
                    tension: [x[1], x[2]],
                    angle: x[3],
                    duration: Some(x[4]),
                    conditions: &conditions,
                };
                let given = BeltInput {
                    flow: numbers[0],
                    tension: [numbers[1], numbers[2]],
                    angle: numbers[3],
                    duration: Some(numbers[4]),
                    conditions: &conditions,
                };
                let (outcome, tangent) = belt.tangent(&state, &given, Branch::Decided);
                *met.entry(format!("{:?}", outcome.status)).or_default() += 1;
                let wide = widened(&state);
                let at = |j: usize, h: f64| {
                    let mut x = numbers.map(Wide::from_f64);
                    x[j] += h;
                    belt.update(&wide, &input(x), Branch::Decided).force[FLOW]
                };
                let partials =
                    [tangent.flow, tangent.tension[0], tangent.tension[1], tangent.angle, tangent.duration];
                let size = partials.iter().fold(1.0, |most: f64, x| most.max(x.abs()));
                for (j, partial) in partials.into_iter().enumerate() {
                    let exact = ((at(j, 1e-25) - at(j, -1e-25)) / 2e-25).to_f64();
                    let error = (partial - exact).abs() / (U * size);
                    assert!(error <= gate("tangents"), "{law} {step} {j}: {partial} {exact} ({error} u)");
                }
                state = outcome.state();
            }
        }
    }
    assert!(met["Stick"] > 20 && met["Slip"] > 20, "{met:?}");
}

/// The angle of wrap and its gradient: moving the ends of both segments.
#[test]
fn the_angle_of_wrap_has_exact_derivatives() {
    use num_dual::DualSVec;
    let points = [[0.1, -0.2, 0.3], [0.4, 1.1, 0.2], [1.3, 0.9, -0.5]];
    let seeded =
        [0, 1, 2].map(|p| [0, 1, 2].map(|i| DualSVec::<f64, 9>::from_re(points[p][i]).derivative(3 * p + i)));
    let (angle, flags) = wrap_angle(seeded[0], seeded[1], seeded[2]);
    assert!(flags.is_empty());
    let gradient = angle.eps.0.unwrap();
    for j in 0..9 {
        let at = |h: f64| {
            let mut moved = points.map(|point| point.map(Wide::from_f64));
            moved[j / 3][j % 3] += h;
            wrap_angle(moved[0], moved[1], moved[2]).0
        };
        let exact = ((at(1e-25) - at(-1e-25)) / 2e-25).to_f64();
        assert!((gradient[j] - exact).abs() < 1e-15, "{j}: {} {exact}", gradient[j]);
    }
    let pi = std::f64::consts::PI;
    let straight = wrap_angle([0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]);
    assert_eq!(straight, (0.0, vec![Flag::WrapAngle { angle: 0.0 }]));
    let folded = wrap_angle([0.0; 3], [1.0, 0.0, 0.0], [0.5, 0.0, 0.0]);
    assert_eq!(folded, (pi, vec![Flag::WrapAngle { angle: pi }]));
}

/// With the default stiffness, which is the limit over an elastic slip, the slip of the first increment does not change with what presses,
/// however small it is: exactly, for every criterion that is homogeneous.
#[test]
fn slips_of_the_default_stiffness_know_nothing_of_what_presses() {
    use PotentialFunction::Abs;
    let sum =
        |beta, terms| Tangential::Potential(Potential::new(PotentialOperator::Sum, beta, terms).unwrap());
    let most =
        Potential::new(PotentialOperator::Max, 1.0, vec![component(0, 1.0, Abs), component(3, 1.0, Abs)]);
    let criteria = [
        Tangential::Norm(vec![(0, 1.0), (3, 0.3)]),
        sum(2.0, vec![component(0, 2.0, Abs), component(3, 2.0, Abs)]),
        sum(3.0, vec![component(0, 3.0, Abs), component(3, 3.0, Abs)]),
        sum(1.5, vec![component(0, 1.5, Abs), component(3, 1.5, Abs)]),
        Tangential::Potential(most.unwrap()),
    ];
    let decay = Coefficient::Exponential { at_rest: 0.5, kinetic: 0.2, decay: 3.0 };
    for (tangential, coefficient) in
        criteria.iter().flat_map(|of| [(of, Coefficient::Constant(0.3)), (of, decay.clone())])
    {
        let pressing = Pressing::Component(4);
        let criterion = criterion(tangential.clone(), pressing, Internal::Constant(1.0));
        let friction = friction(&criterion, &coefficient, StickStiffness::ElasticSlip(1e-4));
        let input = Input {
            displacement: [2.0, 0.0, 0.0, 3.0, 0.0, 0.0],
            forces: [0.0, 0.0, 0.0, 0.0, -1.0 + 3e-12, 0.0],
            duration: Some(1.0),
            context: Context::default(),
        };
        let (outcome, tangent) = friction.tangent(&State::default(), &input, Branch::Decided);
        assert_eq!(outcome.status, Status::Slip, "{tangential:?}");
        assert_eq!(tangent.slip_increment.forces, [0.0; 6], "{tangential:?}, {coefficient:?}");
        // f = L n, with n the direction of the slip, so that ∂f/∂F_N is f/F_N.
        for k in [0, 3] {
            let ratio = outcome.force[k] / outcome.normal;
            let error = (tangent.force[k].forces[4] - ratio).abs();
            assert!(error <= 8.0 * U * ratio.abs(), "{tangential:?}, {coefficient:?}: {error} of {ratio}");
        }
    }
}
