//! What multi-point constraints transmit: forces are in balance, their power is that of the multipliers, tangents are differences.

use super::Check;
use super::mpc::{Case, Truth, cases};
use crate::states::Draw;
use pintle_kinematics::connector::{Output, Request};
use pintle_kinematics::mpc::{
    DOFS, Dofs, FLOW, MpcType, PSI_M, PSI_S, RHO, Rows, THETA_M, THETA_S, XM, XS, force,
};
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::vector::{Vector, add, cross, dot, sub};

fn part(of: &Dofs<f64>, at: usize) -> Vector<f64> {
    [of[at], of[at + 1], of[at + 2]]
}

/// Forces of size 1, moments of size 1 × length, on the degrees of freedom of S.
fn on_slave(case: &Case, draw: &mut Draw) -> Dofs<f64> {
    let mut forces = [0.0; DOFS];
    forces[XS..THETA_S].copy_from_slice(&draw.vector(1.0));
    forces[THETA_S..PSI_S].copy_from_slice(&draw.vector(case.length));
    forces[PSI_S] = draw.between(-1.0, 1.0);
    forces
}

/// For given forces and moments on S: M_M = −M_S, M_J = −M_S·a = M_M·a, F_M = −F_S. A BEAM is in balance about any point, a LINK along
/// itself. What is put on S is what was given.
#[test]
fn forces_are_in_balance() {
    let mut check = Check::of("mpc, forces");
    for case in cases().into_iter().filter(|case| case.holds) {
        let mut draw = Draw::new(&format!("{} forces", case.name));
        let constraint = case.constraint::<f64>();
        let got = case.evaluate(&Request::everything(1));
        let given = on_slave(&case, &mut draw);
        let nodal = got.nodal(&constraint.multipliers(&case.state, &got, &given));
        let place = |what: &str| format!("{}, {what}", case.name);
        let mut same = |what: &str, got: Vector<f64>, want: Vector<f64>, size: f64| {
            for (got, want) in got.into_iter().zip(want) {
                check.against(|| place(what), got, want, size);
            }
        };
        let none = [0.0; 3];
        let (force, moment) = (part(&nodal, XS), part(&nodal, THETA_S));
        let apart = sub(add(constraint.arm(), case.state.slave.displacement), case.state.master.displacement);
        match case.kind {
            MpcType::Link => {
                let scale = 4.0 * case.length / dot(apart, apart).sqrt();
                same("along the link", cross(force, apart), none, case.length * scale.max(4.0));
                let dependent = constraint.dependent(&case.state);
                let j = (0..3).find(|j| dependent[*j]).unwrap();
                same("as given", [nodal[j], 0.0, 0.0], [given[j], 0.0, 0.0], 1.0);
            }
            MpcType::Pin | MpcType::Beam | MpcType::Tie => same("force on S", force, part(&given, XS), 1.0),
            MpcType::Revolute | MpcType::Universal => same("force on S", force, none, 1.0),
        }
        if case.kind.entry().hinges.is_some() {
            same("moment on S", moment, part(&given, THETA_S), case.length);
        }
        same("forces", add(force, part(&nodal, XM)), none, 1.0);
        let moments = add(moment, part(&nodal, THETA_M));
        match case.kind {
            MpcType::Beam => {
                same("moments about M", add(moments, cross(apart, force)), none, 10.0 * case.length)
            }
            _ => same("moments", moments, none, case.length),
        }
        same("flow", [nodal[PSI_S] + nodal[PSI_M], 0.0, 0.0], none, 1.0);
        for (i, axis) in got.axes.into_iter().enumerate() {
            let Some(axis) = axis else { continue };
            let in_hinge = force::hinge_moments(&nodal)[i];
            same("MJ = −MS·a", [in_hinge, 0.0, 0.0], [-dot(moment, axis), 0.0, 0.0], case.length);
            same(
                "MJ = MM·a",
                [in_hinge, 0.0, 0.0],
                [dot(part(&nodal, THETA_M), axis), 0.0, 0.0],
                case.length,
            );
        }
    }
    check.finish();
}

/// Multipliers of size 1.
fn multipliers(case: &Case, draw: &mut Draw) -> Rows<f64> {
    let rows = case.constraint::<f64>().rows();
    std::array::from_fn(|row| {
        let size = if (RHO..FLOW).contains(&row) { case.length } else { 1.0 };
        rows[row].then(|| draw.between(-size, size))
    })
}

/// F·q̇ = λ·ġ.
#[test]
fn power_is_that_of_the_multipliers() {
    let mut check = Check::of("mpc, power");
    for case in cases() {
        let mut draw = Draw::new(&format!("{} power", case.name));
        let got = case.evaluate(&Request::everything(2));
        let multipliers = multipliers(&case, &mut draw);
        let nodal = got.nodal(&multipliers);
        let sizes = case.sizes();
        let terms: Vec<f64> =
            nodal.iter().zip(case.state.velocity).map(|(force, rate)| force * rate).collect();
        let size: f64 = (0..DOFS).map(|j| (nodal[j] * sizes[j]).abs()).sum::<f64>();
        let with_rates: f64 =
            multipliers.iter().zip(got.residual_rate).map(|(l, g)| l.unwrap_or(0.0) * g.unwrap_or(0.0)).sum();
        check.against(|| case.name.clone(), terms.iter().sum(), with_rates, 4.0 * size);
    }
    check.finish();
}

/// How nodal forces change is the difference of nodal forces, on 237-bit numbers.
#[test]
fn stiffness_is_a_difference() {
    let mut check = Check::of("mpc, stiffness");
    for case in cases() {
        let mut draw = Draw::new(&format!("{} stiffness", case.name));
        let multipliers = multipliers(&case, &mut draw);
        let got = case.evaluate(&Request::everything(2));
        let derivative = got.derivative(&multipliers);
        let truth = Truth::of(&case);
        let exact = multipliers.map(|row| row.map(Wide::from_f64));
        let rows = Request::new(&[Output::RES], [true; 6], 1);
        let sizes = case.sizes();
        // One scale for all: the largest part, by the size of its degrees of freedom.
        let mut size = 0.0_f64;
        for (multiplier, hessian) in multipliers.iter().zip(&got.hessian) {
            let (Some(multiplier), Some(hessian)) = (multiplier, hessian) else { continue };
            for i in 0..DOFS {
                for j in 0..DOFS {
                    size += (multiplier * hessian[i][j] * sizes[i] * sizes[j]).abs();
                }
            }
        }
        let nodal = got.nodal(&multipliers);
        size += (0..DOFS).map(|j| (nodal[j] * sizes[j]).abs()).sum::<f64>();
        for j in 0..DOFS {
            let change = truth.difference(j, |by| truth.at(by, &rows).nodal(&exact).map(Some));
            for i in 0..DOFS {
                let scale = size / (sizes[i] * sizes[j]);
                check.compare(
                    || format!("{} {i} {j}", case.name),
                    derivative[i][j],
                    change[i].unwrap(),
                    scale,
                );
            }
        }
    }
    check.finish();
}

/// Springs and dashpots to ground on the angle of a hinge: moments, their stiffness, damping and energy as differences on 237-bit
/// numbers, over a history that goes through turns.
#[test]
fn springs_on_hinges() {
    use pintle_model::behavior::Conditions;
    use pintle_model::evaluate::{Model, Plan, Selection, Sequence};
    use pintle_report::unevaluated;
    use pintle_scene::{NodeMotion, Rotation, Scene, State as SceneState};

    let deck = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n3, 0., 0., 1.\n4, 1., 0., 0.\n*MPC\nUNIVERSAL, 1, 2, 3, 4\n\
                *ELEMENT, TYPE=SPRING1, ELSET=K\n11, 3\n*SPRING, ELSET=K\n6\n2.5\n\
                *ELEMENT, TYPE=SPRING1, ELSET=T\n12, 4\n\
                *SPRING, ELSET=T, NONLINEAR\n6\n-3., -1.\n0., 0.\n1., 0.5\n4., 1.\n\
                *ELEMENT, TYPE=DASHPOT1, ELSET=C\n13, 3\n*DASHPOT, ELSET=C, NONLINEAR\n6\n-2., -1.\n0., 0.\n6., 1.\n\
                *ELEMENT, TYPE=SPRING1, ELSET=OTHER\n14, 3\n*SPRING, ELSET=OTHER\n5\n9.\n";
    let scene = Scene::parse("springs.inp", deck).unwrap();
    let model = Model::compile(&scene).unwrap();
    let plan = Plan::compile(&model, &Selection::All, Request::everything(0)).unwrap();
    let mut sequence = Sequence::new(&model, &plan);
    let left: Vec<_> =
        unevaluated(&scene, &model).into_iter().map(|note| (note.count, note.details)).collect();
    assert_eq!(left, [(1, vec!["SPRING1: 1".to_string()])]);
    let mut check = Check::of("mpc, springs");
    let conditions = Conditions::default();
    for n in 0..40 {
        let (first, second, rate) =
            (0.4 * f64::from(n), 0.03 * f64::from(n) - 0.613, 0.1 * f64::from(n) - 2.05);
        let motion = |angle: f64, rate: f64| NodeMotion {
            rotation: Rotation::Vector([0.0, 0.0, angle]),
            angular_velocity: [0.0, 0.0, rate],
            ..NodeMotion::default()
        };
        let mut state = SceneState::default();
        let [of_first, of_second] =
            [[0.0, 0.0, first], [second, 0.0, 0.0]].map(pintle_kinematics::so3::exp_quaternion);
        let rotation = Rotation::Quaternion(pintle_kinematics::so3::compose(of_first, of_second));
        let names: Vec<_> = scene.nodes.keys().copied().collect();
        state.nodes.insert(names[0], NodeMotion { rotation, ..NodeMotion::default() });
        // The first angle is given, the second is what the rotations imply.
        state.nodes.insert(names[2], motion(first, rate));
        let step = sequence.step(&state);
        let [on_first, on_second] = step.mpcs[0].moments.map(|moments| moments.unwrap().unwrap());
        for (i, (got, angle)) in [(on_first, first), (on_second, second)].into_iter().enumerate() {
            let ground = &model.mpcs[0].ground[i];
            let h = Wide::from_f64(1e-20);
            let at = Wide::from_f64(angle);
            let energy = |x: Wide| ground.energy(x, &conditions).unwrap();
            let spring = |x: Wide| ground.spring(x, &conditions).unwrap();
            let place = |what: &str| format!("state {n}, angle {}, {what}", i + 1);
            let size = 4.0 * (1.0 + angle.abs());
            check.compare(|| place("moment"), got.spring, (energy(at + h) - energy(at - h)) / (h + h), size);
            check.compare(
                || place("stiffness"),
                got.stiffness,
                (spring(at + h) - spring(at - h)) / (h + h),
                6.0,
            );
            check.compare(|| place("energy"), got.energy, energy(at), size * (1.0 + angle.abs()));
        }
        check.against(|| format!("state {n}, k φ"), on_first.spring, 2.5 * first, 2.5 * (1.0 + first));
        let c = if rate < 0.0 { 2.0 } else { 6.0 };
        let damped = if rate < -1.0 {
            (-2.0, 0.0)
        } else if rate > 1.0 {
            (6.0, 0.0)
        } else {
            (c * rate, c)
        };
        check.against(|| format!("state {n}, dashpot"), on_first.dashpot.unwrap(), damped.0, 6.0);
        check.against(|| format!("state {n}, damping"), on_first.damping.unwrap(), damped.1, 6.0);
    }
    check.finish();
}
