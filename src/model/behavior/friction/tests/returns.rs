//! Slip against the gradient of a potential and along the traction: its equations, its tangents, answers in closed form.

use crate::behavior::Conditions;
use crate::behavior::friction::tests::powers::{sum, term};
use crate::behavior::friction::{
    Belt, BeltInput, Branch, Coefficient, Context, Contribution, Criterion, Derived, DerivedPart, Flag, Form,
    Friction, FrictionOutcome, Input, Internal, Potential, Pressing, State, Status, StickStiffness,
    Tangential,
};
use crate::behavior::table::Table;
use pintle_scene::{Basis, Extrapolation, Operator, PotentialOperator};

/// The place of f5 among the inputs of a tangent.
const PRESSING: usize = 10;

/// Pressed by f5, μ = 1/2.
fn friction(potential: Potential, stiffness: f64) -> Friction {
    Friction {
        criterion: Criterion {
            tangential: Tangential::Potential(potential),
            pressing: Pressing::Component(4),
            internal: Internal::Constant(0.0),
            output: "CSFC",
        },
        coefficient: Coefficient::Constant(0.5),
        maximum: None,
        stick_stiffness: StickStiffness::Given(stiffness),
        radius: 1.0,
    }
}

fn input(displacement: [f64; 6], normal: f64) -> Input<'static, f64> {
    Input {
        displacement,
        forces: [0.0, 0.0, 0.0, 0.0, normal, 0.0],
        duration: Some(0.1),
        context: Context::default(),
    }
}

fn slid(friction: &Friction, input: &Input<'_, f64>) -> FrictionOutcome<f64> {
    let outcome = friction.update(&State::default(), input, Branch::Decided);
    assert_eq!(outcome.status, Status::Slip);
    outcome
}

/// Tangents of the forces and of the slip are differences of them, from rest: by displacements, which move positions and motions too,
/// by what presses (f5), and by the duration. Components 5 and 6 neither slide nor move anything.
fn assert_tangent(name: &str, friction: &Friction, at: &Input<'static, f64>) -> FrictionOutcome<f64> {
    let (outcome, tangent) = friction.tangent(&State::default(), at, Branch::Decided);
    assert_eq!(outcome.status, Status::Slip, "{name}");
    let results = |outcome: &FrictionOutcome<f64>| {
        let mut all = outcome.force.to_vec();
        all.push(outcome.slip_increment);
        all
    };
    for j in [0, 1, 2, 3, PRESSING, 12] {
        let moved = |h: f64| {
            let mut moved = at.clone();
            match j {
                0..6 => {
                    moved.displacement[j] += h;
                    moved.context.position[j] += h;
                    moved.context.motion[j] += h;
                }
                6..12 => moved.forces[j - 6] += h,
                _ => moved.duration = moved.duration.map(|duration| duration + h),
            }
            results(&slid(friction, &moved))
        };
        let size = match j {
            0..6 => at.displacement[j].abs().max(1e-2),
            6..12 => 1.0,
            _ => 0.1,
        };
        let h = 1e-5 * size;
        let (above, below) = (moved(h), moved(-h));
        let partials = tangent.force.iter().chain([&tangent.slip_increment]);
        for (i, partial) in partials.enumerate() {
            let expected = (above[i] - below[i]) / (2.0 * h);
            let found = match j {
                0..6 => partial.displacement[j],
                6..12 => partial.forces[j - 6],
                _ => partial.duration,
            };
            let scale = expected.abs() + 1e-2 * (above[i].abs() + below[i].abs()) / size;
            assert!((found - expected).abs() <= 1e-6 * scale, "{name}: ∂{i}/∂{j}: {found} {expected}");
        }
    }
    outcome
}

/// P = (|f1|^α + |f2|^α)^(1/β), L = 1, f_tr = K u: f + K Δγ ∂P/∂f = f_tr beside its largest term, of every component however small
/// the others leave it, in any unit of length; Φ = 0.
#[test]
fn what_is_tiny_satisfies_its_own_equation() {
    for (alpha, beta) in [(1.5, 1.5), (1.2, 1.2), (1.8, 1.5), (1.5, 2.5), (1.75, 1.0)] {
        let potential = || sum(beta, &[term(0, 1.0, alpha), term(1, 1.0, alpha)]);
        for unit in [1.0, 1e-8, 1e6] {
            for u1 in [0.0, 1e-30, 1e-17, 1e-9, -1e-5, 1e-3, 0.1, 0.5] {
                let name = format!("{alpha} {beta} {u1} {unit}");
                let moved = [u1 * unit, 0.5 * unit];
                let stiffness = 1000.0 / unit;
                let at = input([moved[0], moved[1], 0.0, 0.0, 0.0, 0.0], 2.0);
                let outcome = slid(&friction(potential(), stiffness), &at);
                assert!(outcome.criterion.abs() < 1e-14, "{name}: {}", outcome.criterion);
                for k in 0..2 {
                    let f = outcome.force[k];
                    let slope = alpha / beta * f.abs().powf(alpha - 1.0) * f.signum();
                    let (flow, trial) = (stiffness * outcome.slip_increment * slope, stiffness * moved[k]);
                    let left = if trial == 0.0 { f } else { (f + flow - trial) / trial };
                    assert!(left.abs() < 1e-13, "{name} {k}: {left}");
                }
                // Of degree below 1, P falls slower than the slip asks: the traction has jumped.
                let expected =
                    [(u1 == 0.0, Flag::ContributionAtZero { term: 1 }), (alpha < beta, Flag::Unstable)];
                let expected: Vec<Flag> =
                    expected.into_iter().filter(|(holds, _)| *holds).map(|(_, flag)| flag).collect();
                assert_eq!(outcome.flags, expected, "{name}");
            }
        }
    }
}

/// Tangents where the unknowns are stretched, of forces and of a moment on a radius, at and beside the zero of a contribution.
#[test]
fn tangents_of_bent_potentials() {
    let decay = Coefficient::Exponential { at_rest: 0.5, kinetic: 0.2, decay: 0.03 };
    for (beta, alphas) in [(1.5, [1.5, 1.5, 1.5]), (1.25, [1.25, 1.75, 3.0]), (1.0, [1.5, 2.0, 1.75])] {
        let terms = [term(0, 1.0, alphas[0]), term(1, -0.5, alphas[1]), term(3, 0.25, alphas[2])];
        let friction =
            Friction { radius: 0.5, coefficient: decay.clone(), ..friction(sum(beta, &terms), 10.0) };
        for u in [[0.5, 0.25, 0.75], [-0.25, 0.5, -1.0]] {
            let name = format!("{beta} {u:?}");
            let outcome = assert_tangent(&name, &friction, &input([u[0], u[1], 0.0, u[2], 0.0, 0.0], 2.0));
            assert_eq!(outcome.flags, [], "{name}");
            // The slip is Δγ ∂P/∂f, and what it loses is work: Σ f slip = Δγ f·∂P/∂f.
            let lost: f64 = (0..6).map(|k| outcome.force[k] * outcome.slip[k]).sum();
            assert!((outcome.dissipation - lost).abs() < 1e-14 * lost);
        }
    }
}

/// A stiffness that follows the limit, and scale factors that follow the position or the motion, move what is not homogeneous.
#[test]
fn tangents_of_moving_potentials() {
    let of = |basis: Option<Basis>, component: usize| {
        let scale = basis.map(|_| Table::curve(&[(-1.0, 0.5), (1.0, 2.0)], Extrapolation::Linear).unwrap());
        let part = DerivedPart {
            operator: Operator::Sum,
            sign: 1.0,
            components: vec![1],
            scale,
            independent: basis.map(|basis| (basis, vec![component])),
        };
        Contribution { of: Form::Derived(Derived { parts: vec![part] }), ..term(1, 1.0, 3.0) }
    };
    for basis in [None, Some(Basis::Position), Some(Basis::ConstitutiveMotion)] {
        for component in [0, 2] {
            for stick_stiffness in [StickStiffness::ElasticSlip(0.05), StickStiffness::Given(20.0)] {
                let potential = sum(2.0, &[term(0, 0.75, 2.0), of(basis, component), term(3, 0.5, 1.5)]);
                let friction = Friction { stick_stiffness, radius: 0.5, ..friction(potential, 1.0) };
                let name = format!("{basis:?} {component} {stick_stiffness:?}");
                let mut at = input([0.3, 0.2, 0.0, 0.4, 0.0, 0.0], 3.0);
                at.context.position = [0.25, 0.0, -0.125, 0.0, 0.0, 0.0];
                at.context.motion = [-0.5, 0.0, 0.375, 0.0, 0.0, 0.0];
                assert_tangent(&name, &friction, &at);
            }
        }
    }
}

/// P = max(|f1|, |m1|/r) at its corner is met along the traction: f = s f_tr with s P(f_tr) = L(Δγ) and
/// K Δγ = (1 − s) Σ (f_tr,k/R_k)²/P(f_tr).
#[test]
fn corners_are_met_along_the_traction() {
    let potential =
        || Potential::new(PotentialOperator::Max, 1.0, vec![term(0, 1.0, 1.0), term(3, 0.25, 1.0)]).unwrap();
    let (stiffness, radius) = (10.0, 0.5);
    for coefficient in
        [Coefficient::Constant(0.5), Coefficient::Exponential { at_rest: 0.5, kinetic: 0.25, decay: 0.2 }]
    {
        let friction = Friction { radius, coefficient, ..friction(potential(), stiffness) };
        let at = input([0.5, 0.0, 0.0, 0.45, 0.0, 0.0], 2.0);
        let name = format!("{:?}", friction.coefficient);
        let outcome = assert_tangent(&name, &friction, &at);
        assert_eq!(outcome.flags, [Flag::ReturnedAlongTraction], "{name}");
        let trial = [5.0, stiffness * radius * radius * 0.45];
        let p = trial[0].max(trial[1] / 0.25);
        let share = outcome.force[0] / trial[0];
        assert!((outcome.force[3] / trial[1] - share).abs() < 1e-15, "{name}");
        assert!((share * p - outcome.limit).abs() < 4e-15 * p, "{name}");
        let whole = (trial[0] * trial[0] + (trial[1] / radius).powi(2)) / p;
        let expected = (1.0 - share) * whole / stiffness;
        assert!((outcome.slip_increment - expected).abs() < 1e-14 * expected, "{name}: {outcome:?}");
    }
}

/// Far tractions of very unequal exponents, where one force nearly vanishes: Newton's method finds the return against the gradient, from
/// one of its starts, and every force satisfies its own equation.
#[test]
fn far_tractions_return_against_the_gradient() {
    /// α of f1, f2 and m1; β; K; u; R of f2 and m1; L at rest.
    type Case = ([f64; 3], f64, f64, [f64; 3], [f64; 2], f64);
    const CASES: [Case; 5] = [
        ([3.0, 1.05, 4.0], 1.0, 455.0, [0.13, 0.2117, 6.165], [2.468, 2.225], 0.2109),
        ([10.0, 6.0, 1.05], 1.0, 5.85e4, [1.233e-6, 0.04906, 0.0607], [9.055, 1.266], 0.07585),
        ([1.05, 4.0, 1.8], 1.05, 1.304e4, [0.9099, 3.515e-4, 1.112], [1.158, 8.771], 0.1164),
        ([1.05, 4.0, 1.8], 1.05, 9.276e4, [0.01817, 0.1904, 0.6142], [1.712, 2.463], 47.315),
        ([1.2, 3.0, 1.8], 1.0, 1.095e5, [1.018, 0.07016, 0.235], [0.2309, 1.374], 20.955),
    ];
    for (alphas, beta, stiffness, u, radii, limit) in CASES {
        let (places, scales) = ([0, 1, 3], [1.0, radii[0], radii[1]]);
        let terms = [0, 1, 2].map(|i| term(places[i], scales[i], alphas[i]));
        let friction = Friction { radius: 0.5, ..friction(sum(beta, &terms), stiffness) };
        let outcome = slid(&friction, &input([u[0], u[1], 0.0, u[2], 0.0, 0.0], 2.0 * limit));
        assert_eq!(outcome.flags, [], "{alphas:?}");
        assert!(outcome.criterion.abs() < 1e-14 * limit, "{alphas:?}: {outcome:?}");
        for i in 0..3 {
            let stiffness = stiffness * if places[i] == 3 { 0.25 } else { 1.0 };
            let f = outcome.force[places[i]];
            let slope = (f / scales[i]).powf(alphas[i] - 1.0) / scales[i];
            let flow = outcome.slip_increment * alphas[i] / beta * limit.powf(1.0 - beta) * slope;
            let left = f / stiffness + flow - u[i];
            assert!(left.abs() < 1e-12 * u[i], "{alphas:?} {i}: {left} of {}", u[i]);
        }
    }
}

/// Of one force every potential is |f|: f = L, and the slip is what the springs do not hold.
#[test]
fn one_force_is_the_limit() {
    for exponent in [1.25, 1.5, 2.0, 3.0, 8.0] {
        for turned in [1.0, -1.0] {
            let friction = friction(sum(exponent, &[term(1, 1.0, exponent)]), 100.0);
            let outcome = slid(&friction, &input([0.0, turned * 0.5, 0.0, 0.0, 0.0, 0.0], 2.0));
            let near = |a: f64, b: f64| assert!((a - b).abs() < 4e-16, "{exponent}: {outcome:?}");
            near(outcome.force[1], turned);
            near(outcome.slip_increment, 0.49);
            assert_eq!(outcome.flags, [], "{exponent}");
        }
    }
}

/// F = L(T, α, Δγ) of a belt whose coefficient falls with the slip rate: its tangent is a difference, by tension and angle too.
#[test]
fn belts_slip_as_their_tensions_tell() {
    static NOTHING: Conditions = Conditions { temperature: None, fields: Vec::new() };
    let belt = Belt {
        coefficient: Coefficient::Exponential { at_rest: 0.5, kinetic: 0.25, decay: 0.5 },
        maximum: None,
        stick_stiffness: StickStiffness::Given(10.0),
    };
    let at = |moved: [f64; 4]| BeltInput {
        flow: 0.5 + moved[0],
        tension: [2.0 + moved[1], 3.0],
        angle: 1.5 + moved[2],
        duration: Some(0.25 + moved[3]),
        conditions: &NOTHING,
    };
    let force = |moved: [f64; 4]| belt.update(&State::default(), &at(moved), Branch::Decided).force[1];
    let (outcome, tangent) = belt.tangent(&State::default(), &at([0.0; 4]), Branch::Decided);
    assert_eq!((outcome.status, outcome.flags), (Status::Slip, vec![]));
    let found = [tangent.flow, tangent.tension[0], tangent.angle, tangent.duration];
    for (j, found) in found.into_iter().enumerate() {
        let [above, below] = [1e-5, -1e-5].map(|h| {
            let mut moved = [0.0; 4];
            moved[j] = h;
            force(moved)
        });
        let expected = (above - below) / 2e-5;
        assert!((found - expected).abs() < 1e-8 * (1.0 + expected.abs()), "{j}: {found} {expected}");
    }
}
