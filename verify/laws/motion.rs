//! Rigid motions, frames, units, rates, the initial state, exchanged nodes.

use super::derivatives::Truth;
use super::{Check, Scales, U, assert_bits, functions, times};
use crate::states::{Case, Draw, Ends, Extent, carried, cases, dof_size, exp, extent, moved, pair, types};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{
    Components, Connector, Evaluation, Flag, Increment, NodalRow, Output, Request, State, Tally,
};
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::scalar::{Scalar, Wide};
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector, add, apply, column, cross, dot, product, scale, sub};

fn everywhere(mut judge: impl FnMut(&Case)) {
    for connection in types() {
        for case in cases(&connection, extent(&connection)) {
            judge(&case);
        }
    }
}

fn part(x: &NodalRow<f64>, at: usize) -> Vector<f64> {
    [x[at], x[at + 1], x[at + 2]]
}

fn set(x: &mut NodalRow<f64>, at: usize, v: Vector<f64>) {
    x[at..at + 3].copy_from_slice(&v);
}

/// The scales of every component at the end of a case.
fn scales(case: &Case, evaluation: &Evaluation<f64>) -> Components<Scales> {
    let functions = functions(evaluation);
    [0, 1, 2, 3, 4, 5].map(|c| {
        let hessian = evaluation.hessian[c].as_ref()?;
        Some(Scales::new(functions[c]?, &evaluation.jacobian[c]?, hessian, case.length))
    })
}

/// Evaluates a state as a continuation of the end of a case that brings no increment.
fn after(case: &Case, state: &State<f64>, request: &Request) -> Evaluation<f64> {
    let connector = case.connector();
    let end = case.end();
    let branch = connector.advance(&end.state, &end.increment, &case.branch_before(&connector));
    connector.evaluate(state, &Increment::none(), &branch, request, &mut Tally::default())
}

/// The rigid modes as nodal variations: three translations, three rotations about node a.
fn rigid_modes(pair: &Pair<f64>) -> [NodalRow<f64>; 6] {
    let arm = pair.separation();
    std::array::from_fn(|i| {
        let mut mode = [0.0; DOFS];
        let mut axis = [0.0; 3];
        axis[i % 3] = 1.0;
        if i < 3 {
            set(&mut mode, 0, axis);
            set(&mut mode, 7, axis);
        } else {
            set(&mut mode, 3, axis);
            set(&mut mode, 10, axis);
            set(&mut mode, 7, cross(axis, arm));
        }
        mode
    })
}

/// J m = 0 for the six rigid modes, and along every steady rigid rotation also J q̈ + q̇ᵀ H q̇ = 0.
#[test]
fn rigid_modes_are_in_the_kernel() {
    let mut first = Check::of("rigid modes");
    let mut second = Check::of("rigid rotations, second order");
    everywhere(|case| {
        let (got, _) = case.evaluate(&Request::everything(2));
        let pair = &case.end().state.pair;
        let arm = pair.separation();
        let modes = rigid_modes(pair);
        let scales = scales(case, &got);
        for c in 0..6 {
            let Some(scale) = &scales[c] else { continue };
            let (row, hessian) = (got.jacobian[c].unwrap(), got.hessian[c].as_ref().unwrap());
            for (i, mode) in modes.iter().enumerate() {
                let size = if i < 3 { case.length } else { 1.0 };
                let place = || format!("{}, component {}, mode {i}", case.name, c + 1);
                first.against(place, times(&row, mode) * size, 0.0, scale.value);
            }
            for i in 0..3 {
                for j in 0..3 {
                    // x_b − x_a = exp(ω^ t) D with ω = e_i, then e_i + e_j.
                    let spin = add(part(&modes[3 + i], 3), part(&modes[3 + j], 3));
                    let mode: NodalRow<f64> = std::array::from_fn(|k| modes[3 + i][k] + modes[3 + j][k]);
                    let mut acceleration = [0.0; DOFS];
                    set(&mut acceleration, 7, cross(spin, cross(spin, arm)));
                    let bent = hessian.map(|line| times(&line, &mode));
                    let sum = times(&row, &acceleration) + times(&bent, &mode);
                    let place = || format!("{}, component {}, spin {i}{j}", case.name, c + 1);
                    second.against(place, sum, 0.0, scale.second(3, 3));
                }
            }
        }
    });
    first.finish();
    second.finish();
}

/// A finite rigid motion with any velocity and acceleration changes no output.
///
/// The exceptions are documented: rates of ROTATION-ACCELEROMETER and ACCELEROMETER are nodal ones resolved in b. A common spin
/// Ω adds (Ω × (ω_b − ω_a))·e_i^b to the accelerations of the first; to the second it adds Ω × d, and to the accelerations
/// 2 Ω × (v_b − v_a) + Ω × (Ω × d) + Ω̇ × d.
#[test]
fn rigid_motion_changes_nothing() {
    let mut value = Check::of("rigid motion, values");
    let mut rate = Check::of("rigid motion, rates");
    everywhere(|case| {
        let draw = &mut Draw::new(&format!("rigid {}", case.name));
        let rotation = exp(draw.rotation(0.2, 3.0));
        let original = case.end().state;
        let before = after(case, &original, &Request::everything(2));
        let mut state = original;
        state.pair = carried(&original.pair, &rotation, draw.vector(case.length));
        let spin = draw.vector(1.0);
        let spin_rate = draw.vector(1.0);
        let arm = state.pair.separation();
        let [shift, push] = [draw.vector(case.length), draw.vector(case.length)];
        for (at, lever) in [(0, [0.0; 3]), (7, arm)] {
            let v = apply(&rotation, part(&original.velocity, at));
            let a = apply(&rotation, part(&original.acceleration, at));
            set(&mut state.velocity, at, add(add(v, cross(spin, lever)), shift));
            let coriolis = scale(cross(spin, v), 2.0);
            let carried = add(cross(spin, cross(spin, lever)), cross(spin_rate, lever));
            set(&mut state.acceleration, at, add(add(add(a, coriolis), carried), push));
            let omega = apply(&rotation, part(&original.velocity, at + 3));
            let alpha = apply(&rotation, part(&original.acceleration, at + 3));
            set(&mut state.velocity, at + 3, add(omega, spin));
            set(&mut state.acceleration, at + 3, add(add(alpha, spin_rate), cross(spin, omega)));
        }
        let moved = after(case, &state, &Request::everything(0));
        let connector = case.connector();
        let scales = scales(case, &before);
        for c in 0..6 {
            let Some(scale) = &scales[c] else { continue };
            for (name, was, is) in [
                ("CU", &before.displacement, &moved.displacement),
                ("CP", &before.position, &moved.position),
                ("RES", &before.residual, &moved.residual),
            ] {
                let (Some(was), Some(is)) = (was[c], is[c]) else { continue };
                let place = || format!("{}, component {}, {name}", case.name, c + 1);
                value.against(place, is, was, scale.value + was.abs());
            }
            let nodal = connector.differentiated(c).is_some_and(Measure::has_nodal_rates);
            let size = rate_scale(case, &state, &before, c) + rate_scale(case, &original, &before, c);
            for (name, was, is) in [
                ("CV", &before.velocity, &moved.velocity),
                ("CA", &before.acceleration, &moved.acceleration),
                ("RESV", &before.residual_rate, &moved.residual_rate),
                ("RESA", &before.residual_acceleration, &moved.residual_acceleration),
            ] {
                let (Some(mut was), Some(is)) = (was[c], is[c]) else { continue };
                if nodal {
                    let axis = column(&state.pair.b.triad, c % 3);
                    let between = |b: usize, a: usize| {
                        apply(&rotation, sub(part(&original.velocity, b), part(&original.velocity, a)))
                    };
                    let added = match (c < 3, name) {
                        (true, "CV") => cross(spin, arm),
                        (true, _) => {
                            let carried = add(cross(spin, cross(spin, arm)), cross(spin_rate, arm));
                            add(cross(vector::scale(spin, 2.0), between(7, 0)), carried)
                        }
                        (false, "CV") => [0.0; 3],
                        (false, _) => cross(spin, between(10, 3)),
                    };
                    was += dot(added, axis);
                }
                let place = || format!("{}, component {}, {name}", case.name, c + 1);
                rate.against(place, is, was, size);
            }
        }
    });
    value.finish();
    rate.finish();
}

/// How large the terms of rates and accelerations of component c are.
///
/// A constrained component reports the rates of its position (a Cardan angle) beside those of its constraint; the position's
/// derivatives, which no output shows, are bounded by the distance δ to the lock: |∂β| ≤ 1, |∂α| ≤ 1/δ, |∂²α| ≤ 4/δ².
fn rate_scale(case: &Case, state: &State<f64>, evaluation: &Evaluation<f64>, c: usize) -> f64 {
    let (row, hessian) = (evaluation.jacobian[c].unwrap(), evaluation.hessian[c].as_ref().unwrap());
    let size = |j: usize| dof_size(j, case.length);
    let (v, a) = (state.velocity.map(f64::abs), state.acceleration.map(f64::abs));
    let mut sum = 0.0;
    let (mut spin, mut spin_rate) = (0.0, 0.0);
    let (mut moving, mut pushed) = (0.0, 0.0);
    for j in 0..DOFS {
        sum += row[j].abs() * (v[j] + a[j]);
        for k in 0..DOFS {
            sum += hessian[j][k].abs() * (v[j] * (v[k] + size(k)) + a[j] * size(k));
        }
        if matches!(j % 7, 3..=5) {
            spin += v[j];
            spin_rate += a[j];
        } else if j % 7 < 3 {
            moving += v[j];
            pushed += a[j];
        }
    }
    let connector = case.connector();
    if connector.is_printed_constraint(c) {
        let relative = state.pair.relative();
        let lock = relative.q[1][2].hypot(relative.q[2][2]);
        sum += (spin + spin_rate) / lock + spin * spin * 4.0 / (lock * lock);
    }
    if connector.differentiated(c).is_some_and(Measure::has_nodal_rates) {
        sum += if c < 3 { moving + pushed } else { spin + spin_rate };
    }
    sum * (1.0 + spin)
}

/// What is measured does not depend on the axes in which everything is written: values stay, rows and second derivatives turn
/// with the axes.
#[test]
fn every_frame_gives_the_same() {
    let mut value = Check::of("frames, values");
    let mut first = Check::of("frames, rows");
    let mut second = Check::of("frames, second derivatives");
    everywhere(|case| {
        let draw = &mut Draw::new(&format!("frame {}", case.name));
        let rotation = exp(draw.rotation(0.2, 3.0));
        let turned_pair = |pair: &Pair<f64>| {
            let mut turned = *pair;
            turned.reference = apply(&rotation, pair.reference);
            for (new, old) in [(&mut turned.a, &pair.a), (&mut turned.b, &pair.b)] {
                new.displacement = apply(&rotation, old.displacement);
                new.triad = product(&rotation, &old.triad);
            }
            turned
        };
        // Far from the origin the turned displacements are rounded before their difference is formed.
        let far = if case.name.contains("away") { 2f64.powi(31) } else { 1.0 };
        let mut turned = case.clone();
        turned.definition.initial = turned_pair(&case.definition.initial);
        turned.definition.fixed_direction = apply(&rotation, case.definition.fixed_direction);
        for step in &mut turned.path {
            step.state.pair = turned_pair(&step.state.pair);
            step.increment.rotation = step.increment.rotation.map(|v| apply(&rotation, v));
        }
        let (was, _) = case.evaluate(&Request::everything(2));
        let (is, _) = turned.evaluate(&Request::everything(2));
        let sheets = |e: &Evaluation<f64>| functions(e).map(|f| f.unwrap_or(0.0));
        // At an exact half turn a rounding decides between two sheets that are equally far, initially or now.
        let [old, new] = [&was, &is].map(|e| e.position.map(|p| p.unwrap_or(0.0)));
        let half_turn = (0..6).any(|c| (old[c] - new[c]).abs() > 1.0);
        if half_turn && case.name.contains("cube") {
            return;
        }
        let scales = scales(case, &was);
        for c in 0..6 {
            let Some(scale) = &scales[c] else { continue };
            let place = |what: &str| {
                let what = what.to_string();
                move || format!("{}, component {}, {what}", case.name, c + 1)
            };
            value.against(place("f"), sheets(&is)[c], sheets(&was)[c], far * scale.value);
            let (row, hessian) = (was.jacobian[c].unwrap(), was.hessian[c].as_ref().unwrap());
            let (new_row, new_hessian) = (is.jacobian[c].unwrap(), is.hessian[c].as_ref().unwrap());
            let blocks = |v: &NodalRow<f64>| {
                let mut turned = *v;
                for at in [0, 3, 7, 10] {
                    set(&mut turned, at, apply(&rotation, part(v, at)));
                }
                turned
            };
            let row = blocks(&row);
            let transpose = |h: &[NodalRow<f64>; DOFS]| -> [NodalRow<f64>; DOFS] {
                std::array::from_fn(|j| std::array::from_fn(|k| h[k][j]))
            };
            let hessian = transpose(&transpose(&hessian.map(|line| blocks(&line))).map(|line| blocks(&line)));
            for j in 0..DOFS {
                let node = 7 * (j / 7) + if j % 7 < 3 { 0 } else { 3 };
                let around = if j % 7 == 6 { j..j + 1 } else { node..node + 3 };
                let largest = around.map(|i| scale.first[i]).fold(0.0, f64::max);
                first.against(place("row"), new_row[j], row[j], far * largest);
                for k in 0..DOFS {
                    second.against(
                        place("second"),
                        new_hessian[j][k],
                        hessian[j][k],
                        far * scale.second(j, k),
                    );
                }
            }
        }
    });
    value.finish();
    first.finish();
    second.finish();
}

/// The factor by which a quantity grows when lengths are multiplied by `length`.
fn unit_factor(measure: Measure, length: f64) -> f64 {
    if measure.unit() == Unit::Length { length } else { 1.0 }
}

/// In units 1024 times smaller, lengths are 1024 times larger and angles the same, bit for bit, with all derivatives.
#[test]
fn units_do_not_matter() {
    const LENGTH: f64 = 1024.0;
    let request = Request::everything(2);
    everywhere(|case| {
        let enlarged = |pair: &Pair<f64>| {
            let mut enlarged = *pair;
            enlarged.reference = scale(pair.reference, LENGTH);
            for node in [&mut enlarged.a, &mut enlarged.b] {
                node.displacement = scale(node.displacement, LENGTH);
                node.flow *= LENGTH;
            }
            enlarged
        };
        let by_unit = |x: &NodalRow<f64>| std::array::from_fn(|j| x[j] * dof_size(j, LENGTH));
        let mut small = case.clone();
        small.length *= LENGTH;
        small.definition.initial = enlarged(&case.definition.initial);
        small.definition.flow_scale /= LENGTH;
        for step in &mut small.path {
            step.state.pair = enlarged(&step.state.pair);
            step.state.velocity = by_unit(&step.state.velocity);
            step.state.acceleration = by_unit(&step.state.acceleration);
            step.increment.flow = step.increment.flow.map(|flow| flow * LENGTH);
        }
        let connector = case.connector();
        let ((was, _), (is, _)) = (case.evaluate(&request), small.evaluate(&request));
        for c in 0..6 {
            let Some(measure) = connector.differentiated(c) else { continue };
            let factor = unit_factor(measure, LENGTH);
            let outputs = [
                ("CP", &was.position, &is.position),
                ("CU", &was.displacement, &is.displacement),
                ("CV", &was.velocity, &is.velocity),
                ("CA", &was.acceleration, &is.acceleration),
                ("RES", &was.residual, &is.residual),
                ("RESV", &was.residual_rate, &is.residual_rate),
                ("RESB", &was.residual_bias, &is.residual_bias),
                ("RESA", &was.residual_acceleration, &is.residual_acceleration),
            ];
            for (name, was, is) in outputs {
                if let (Some(was), Some(is)) = (was[c], is[c]) {
                    assert_bits(format!("{}, component {}, {name}", case.name, c + 1), is, was * factor);
                }
            }
            for j in 0..DOFS {
                let place = format!("{}, component {}, ∂{j}", case.name, c + 1);
                let by = factor / dof_size(j, LENGTH);
                assert_bits(&place, is.jacobian[c].unwrap()[j], was.jacobian[c].unwrap()[j] * by);
                for k in 0..DOFS {
                    let [was, is] = [&was, &is].map(|e| e.hessian[c].as_ref().unwrap()[j][k]);
                    assert_bits(&place, is, was * by / dof_size(k, LENGTH));
                }
            }
        }
    });
}

/// f·u̇ = F·q̇: the rates of what is differentiated are J q̇, its accelerations J q̈ + q̇ᵀ H q̇, so that nodal forces from the
/// transposed Jacobian do the work of the component forces.
///
/// The exceptions are documented: rates of ROTATION-ACCELEROMETER and ACCELEROMETER are nodal ones resolved in b.
#[test]
fn rates_follow_from_rows() {
    let mut check = Check::of("rates from rows");
    everywhere(|case| {
        let (got, _) = case.evaluate(&Request::everything(2));
        let connector = case.connector();
        let State { pair, velocity, acceleration } = case.end().state;
        let masked = |x: &NodalRow<f64>| -> NodalRow<f64> {
            std::array::from_fn(|j| if connector.active()[j] { x[j] } else { 0.0 })
        };
        let (v, a) = (masked(&velocity), masked(&acceleration));
        for c in 0..6 {
            let Some(row) = got.jacobian[c] else { continue };
            let hessian = got.hessian[c].as_ref().unwrap();
            let size = rate_scale(case, &case.end().state, &got, c);
            let place = |what: &'static str| move || format!("{}, component {}, {what}", case.name, c + 1);
            let bent = hessian.map(|line| times(&line, &v));
            let (rate, bias) = (times(&row, &v), times(&bent, &v));
            let pushed = times(&row, &a);
            if connector.differentiated(c).is_some_and(Measure::has_nodal_rates) {
                let axis = column(&pair.b.triad, c % 3);
                let [of_b, of_a] = if c < 3 { [7, 0] } else { [10, 3] };
                let resolved = |x: &NodalRow<f64>| dot(sub(part(x, of_b), part(x, of_a)), axis);
                check.against(place("CV"), got.velocity[c].unwrap(), resolved(&v), size);
                check.against(place("CA"), got.acceleration[c].unwrap(), resolved(&a), size);
            } else if let Some(residual_rate) = got.residual_rate[c] {
                check.against(place("RESV"), residual_rate, rate, size);
                check.against(place("RESB"), got.residual_bias[c].unwrap(), bias, size);
                check.against(place("RESA"), got.residual_acceleration[c].unwrap(), pushed + bias, size);
            } else {
                check.against(place("CV"), got.velocity[c].unwrap(), rate, size);
                check.against(place("CA"), got.acceleration[c].unwrap(), pushed + bias, size);
            }
        }
    });
    check.finish();
}

/// Rates and accelerations are the time derivatives of positions and residuals along x + v t + ½ a t², exp((ω t + ½ α t²)^) C,
/// by central differences on 237-bit numbers.
#[test]
fn rates_are_differences_in_time() {
    let mut check = Check::of("rates in time");
    let request = Request::new(&[Output::CP, Output::RES], [true; 6], 0);
    everywhere(|case| {
        let (got, _) = case.evaluate(&Request::everything(2));
        let truth = Truth::of(case);
        let connector = case.connector();
        let h = Wide::from_f64(1e-18);
        let at = |t: Wide| {
            let by: NodalRow<Wide> = std::array::from_fn(|j| {
                truth.state.velocity[j] * t + truth.state.acceleration[j] * t * t / Wide::from_f64(2.0)
            });
            (truth.evaluate(&by, &request), truth.accumulated(&by))
        };
        let [minus, still, plus] = [-h, Wide::zero(), h].map(at);
        let differences = |[x, y, z]: [Wide; 3]| [(z - x) / (h + h), (z - y - y + x) / (h * h)];
        let times = [&minus, &still, &plus];
        for c in 0..6 {
            let Some(measure) = connector.differentiated(c) else { continue };
            if measure.has_nodal_rates() {
                continue; // tested by `rates_follow_from_rows`
            }
            let size = rate_scale(case, &case.end().state, &got, c);
            let place = |what: &'static str| move || format!("{}, component {}, {what}", case.name, c + 1);
            if measure.is_one_form() {
                let [rate, acceleration] = differences(times.map(|x| x.1));
                check.compare(place("CV"), got.velocity[c].unwrap(), rate, size);
                check.compare(place("CA"), got.acceleration[c].unwrap(), acceleration, size);
                continue;
            }
            let [rate, acceleration] = differences(times.map(|x| x.0.position[c].unwrap()));
            check.compare(place("CV"), got.velocity[c].unwrap(), rate, size);
            check.compare(place("CA"), got.acceleration[c].unwrap(), acceleration, size);
            if got.residual[c].is_some() {
                let [rate, acceleration] = differences(times.map(|x| x.0.residual[c].unwrap()));
                check.compare(place("RESV"), got.residual_rate[c].unwrap(), rate, size);
                check.compare(place("RESA"), got.residual_acceleration[c].unwrap(), acceleration, size);
            }
        }
    });
    check.finish();
}

/// At the initial state every displacement is exactly zero; so is every residual but that of a printed constraint, which is as
/// far from zero as the given directions are (a few u).
#[test]
fn motion_starts_at_zero() {
    let mut check = Check::of("initial residuals");
    everywhere(|case| {
        let connector = case.connector();
        let state = State { pair: case.definition.initial, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
        let branch = connector.initial_branch();
        let request = Request::everything(1);
        let got = connector.evaluate(&state, &Increment::none(), &branch, &request, &mut Tally::default());
        for c in 0..6 {
            let place = format!("{}, component {}", case.name, c + 1);
            for value in [got.displacement[c], got.constitutive[c]].into_iter().flatten() {
                assert!(value == 0.0, "{place}: displacement {value:e} at the initial state");
            }
            for rate in [got.velocity[c], got.acceleration[c], got.residual_bias[c]].into_iter().flatten() {
                assert!(rate == 0.0, "{place}: rate {rate:e} at rest");
            }
            if let Some(residual) = got.residual[c] {
                if connector.is_printed_constraint(c) {
                    check.against(|| place.clone(), residual, 0.0, 1.0);
                } else {
                    assert!(residual == 0.0, "{place}: residual {residual:e} at the initial state");
                }
            }
            if let Some(turns) = got.turns[c] {
                assert!(turns.turns == 0.0, "{place}: {} turns at the initial state", turns.turns);
            }
        }
    });
    check.finish();
}

/// The case with nodes a and b exchanged.
fn exchanged(case: &Case) -> Case {
    let swap = |pair: &Pair<f64>| Pair { reference: scale(pair.reference, -1.0), a: pair.b, b: pair.a };
    let rows = |x: &NodalRow<f64>| -> NodalRow<f64> { std::array::from_fn(|j| x[(j + 7) % DOFS]) };
    let mut other = case.clone();
    other.definition.initial = swap(&case.definition.initial);
    for step in &mut other.path {
        step.state.pair = swap(&step.state.pair);
        step.state.velocity = rows(&step.state.velocity);
        step.state.acceleration = rows(&step.state.acceleration);
        step.increment.rotation.swap(0, 1);
        step.increment.whole_turns.swap(0, 1);
        step.increment.flow.swap(0, 1);
    }
    other
}

fn entry(name: &str) -> &'static ConnectionType {
    TABLE.iter().find(|entry| entry.name == name).expect(name)
}

/// What exchanging the nodes does, for the types where it does something simple:
///
/// - AXIAL, LINK: nothing; the row exchanges its halves.
/// - ROTATION: φ becomes −φ, for e_i^b·φ = e_i^a·φ. On its principal sheet, and on every other.
/// - EULER: (α, β, γ) becomes (π − γ, β, −π − α) up to whole turns, so that rates become (−γ̇, β̇, −α̇).
/// - SLIPRING: with Ψ_a, Ψ_b also replaced by −Ψ_b, −Ψ_a, nothing: what enters at one end leaves at the other.
///
/// It does nothing simple to CARDAN (1-2-3 becomes 3-2-1), nor to types that measure in the frame carried by a.
#[test]
fn exchanging_the_nodes() {
    let mut value = Check::of("exchanged nodes, values");
    let mut row = Check::of("exchanged nodes, rows");
    let request = Request::everything(2);
    // The new component, the old one that it was, and their signs.
    const SAME: &[(usize, usize, f64)] = &[(0, 0, 1.0)];
    const OPPOSITE: &[(usize, usize, f64)] = &[(3, 3, -1.0), (4, 4, -1.0), (5, 5, -1.0)];
    const REVERSED: &[(usize, usize, f64)] = &[(3, 5, -1.0), (4, 4, 1.0), (5, 3, -1.0)];
    let simple = [("AXIAL", SAME), ("LINK", SAME), ("ROTATION", OPPOSITE), ("EULER", REVERSED)];
    for (name, map) in simple {
        for case in cases(entry(name), Extent::Full) {
            if case.name.contains("cube") {
                continue; // a half turn in one increment may be counted either way
            }
            let ((was, _), (is, _)) = (case.evaluate(&request), exchanged(&case).evaluate(&request));
            let scales = scales(&case, &was);
            for (new, old, sign) in map {
                let scale = scales[*old].as_ref().expect("a component");
                let place = || format!("{}, component {}", case.name, new + 1);
                value.against(
                    place,
                    functions(&is)[*new].unwrap(),
                    sign * functions(&was)[*old].unwrap(),
                    scale.value + 2.0,
                );
                for j in 0..DOFS {
                    let want = sign * was.jacobian[*old].unwrap()[(j + 7) % DOFS];
                    row.against(place, is.jacobian[*new].unwrap()[j], want, scale.first[(j + 7) % DOFS]);
                }
            }
        }
    }
    for case in cases(entry("SLIPRING"), Extent::Full) {
        let mut other = exchanged(&case);
        for step in &mut other.path {
            let pair = &mut step.state.pair;
            (pair.a.flow, pair.b.flow) = (-pair.a.flow, -pair.b.flow);
            step.increment.flow = step.increment.flow.map(|flow| -flow);
        }
        let ((was, _), (is, _)) = (case.evaluate(&request), other.evaluate(&request));
        let scales = scales(&case, &was);
        let scale = scales[0].as_ref().expect("a strain");
        let place = || format!("{}, strain", case.name);
        value.against(place, is.displacement[0].unwrap(), was.displacement[0].unwrap(), scale.value);
        for j in 0..DOFS {
            let sign = if j % 7 == 6 { -1.0 } else { 1.0 };
            let want = sign * was.jacobian[0].unwrap()[(j + 7) % DOFS];
            row.against(place, is.jacobian[0].unwrap()[j], want, scale.first[(j + 7) % DOFS]);
        }
        assert_eq!(is.displacement[1].unwrap(), -was.displacement[2].unwrap(), "{}", case.name);
    }
    value.finish();
    row.finish();
}

/// Second derivatives of a function are symmetric; those of the one-form e3a·(δθ_a − δθ_b) − β_s δΨ_b are
/// ∂e3a/∂θ_a = [·]× e3a in the columns of θ_a, and zero elsewhere.
#[test]
fn second_derivatives_are_symmetric_but_for_the_one_form() {
    let mut check = Check::of("symmetry");
    let mut asymmetric = 0;
    everywhere(|case| {
        let connector = case.connector();
        let (got, _) = case.evaluate(&Request::everything(2));
        let scales = scales(case, &got);
        for c in 0..6 {
            let Some(scale) = &scales[c] else { continue };
            let hessian = got.hessian[c].as_ref().unwrap();
            let one_form = connector.differentiated(c).is_some_and(Measure::is_one_form);
            let e3 = column(&case.end().state.pair.a.triad, 2);
            for j in 0..DOFS {
                for k in 0..DOFS {
                    let place = || format!("{}, component {}, ∂{j}∂{k}", case.name, c + 1);
                    if !one_form {
                        check.against(place, hessian[j][k], hessian[k][j], scale.second(j, k));
                        continue;
                    }
                    let mut want = 0.0;
                    if (3..6).contains(&k) && matches!(j % 7, 3..=5) {
                        let mut axis = [0.0; 3];
                        axis[k - 3] = 1.0;
                        want = cross(axis, e3)[j % 7 - 3] * if j < 7 { 1.0 } else { -1.0 };
                    }
                    assert!(hessian[j][k] == want, "{}: {} is not {want}", place(), hessian[j][k]);
                    asymmetric += usize::from(hessian[j][k] != hessian[k][j]);
                }
            }
        }
    });
    assert!(asymmetric > 0, "the one-form has a potential");
    check.finish();
}

/// A coincident AXIAL acts along a direction fixed in space: its row is that direction, its second derivatives are zero, its
/// acceleration is that of the nodes along it, however a turns.
#[test]
fn coincident_axial_is_fixed_in_space() {
    let draw = &mut Draw::new("coincident AXIAL");
    for _ in 0..8 {
        let direction = draw.direction();
        let a0 = draw.triad();
        let q0 = exp(draw.rotation(0.0, 3.0));
        let mut definition = crate::states::definition(entry("AXIAL"), pair([0.0; 3], a0, &q0), 1.0);
        definition.fixed_direction = direction;
        let connector = Connector::<f64>::new(&definition);
        let mut by = [0.0; DOFS];
        set(&mut by, 3, draw.rotation(0.1, 1.0));
        set(&mut by, 10, draw.rotation(0.1, 1.0));
        let state = State {
            pair: moved(&definition.initial, &by),
            velocity: draw.rates(1.0),
            acceleration: draw.rates(1.0),
        };
        let got = connector.evaluate(
            &state,
            &Increment::none(),
            &connector.initial_branch(),
            &Request::everything(2),
            &mut Tally::default(),
        );
        assert_eq!(got.position[0], Some(0.0));
        let row = got.jacobian[0].unwrap();
        let expected = |j: usize| match j {
            0..=2 => -direction[j],
            7..=9 => direction[j - 7],
            _ => 0.0,
        };
        for j in 0..DOFS {
            assert!((row[j] - expected(j)).abs() <= 4.0 * U, "∂{j}: {} is not {}", row[j], expected(j));
            for k in 0..DOFS {
                let entry = got.hessian[0].as_ref().unwrap()[j][k];
                assert!(entry == 0.0, "∂{j}∂{k} = {entry}, of a direction fixed in space");
            }
        }
        let along = |x: &NodalRow<f64>| dot(sub(part(x, 7), part(x, 0)), direction);
        for (name, got, want) in [
            ("CV", got.velocity[0].unwrap(), along(&state.velocity)),
            ("CA", got.acceleration[0].unwrap(), along(&state.acceleration)),
        ] {
            assert!((got - want).abs() <= 16.0 * U, "{name}: {got} is not {want}");
        }
    }
}

/// The constraint rows of a type have full rank where its constraints nearly hold: no constraint is said twice.
///
/// (Far from there they need not: a printed cosine at ±1 is stationary, a rotation vector at π is flat across itself.)
#[test]
fn constraint_rows_are_independent() {
    let mut count = 0;
    everywhere(|case| {
        let (got, _) = case.evaluate(&Request::everything(1));
        let connector = case.connector();
        let printed = |c: &usize| connector.is_printed_constraint(*c);
        if (0..6).filter(printed).any(|c| got.residual[c].unwrap().abs() > 0.9) {
            return;
        }
        count += 1;
        let mut rows: Vec<NodalRow<f64>> = Vec::new();
        for c in 0..6 {
            if got.residual[c].is_none() {
                continue;
            }
            // Gram and Schmidt, in units in which lengths are of order 1.
            let row = got.jacobian[c].unwrap();
            let mut rest: NodalRow<f64> = std::array::from_fn(|j| row[j] * dof_size(j, case.length));
            let size = times(&rest, &rest).sqrt();
            for other in &rows {
                let along = times(&rest, other);
                for (x, y) in rest.iter_mut().zip(other) {
                    *x -= along * y;
                }
            }
            let left = times(&rest, &rest).sqrt();
            assert!(
                left > 0.02 * size,
                "{}: row {} depends on the others ({left} of {size})",
                case.name,
                c + 1
            );
            rows.push(rest.map(|x| x / left));
        }
    });
    assert!(count > 200, "only {count} states are near their constraints");
}

/// Two half turns that are the same pose are told apart by the increment that leads there, and without one the principal
/// angle is taken.
#[test]
fn half_turns_in_one_increment() {
    let pi = std::f64::consts::PI;
    for (name, component, axis, tilt) in [
        ("REVOLUTE", 3, [1.0, 0.0, 0.0], 0.0),
        ("CARDAN", 3, [1.0, 0.0, 0.0], 0.0),
        ("UNIVERSAL", 3, [1.0, 0.0, 0.0], 0.0),
        ("ROTATION", 3, [1.0, 0.0, 0.0], 0.0),
        ("EULER", 3, [0.0, 0.0, 1.0], 1.0),
        ("CONSTANT VELOCITY", 4, [0.0, 0.0, 1.0], 1.0),
        ("FLEXION-TORSION", 4, [0.0, 0.0, 1.0], 1.0),
        ("FLEXION-TORSION", 5, [0.0, 0.0, 1.0], 1.0),
        ("PROJECTION FLEXION-TORSION", 5, [0.0, 0.0, 1.0], 0.0),
        ("PROJECTION FLEXION-TORSION", 5, [0.0, 0.0, 1.0], 1.0),
    ] {
        let connection = entry(name);
        let q0 = crate::states::about_1(tilt);
        let a0: Matrix<f64> = vector::identity();
        let definition = crate::states::definition(connection, pair([1.0, 0.0, 0.0], a0, &q0), 1.0);
        let connector = Connector::<f64>::new(&definition);
        for (told, expected) in [(pi, pi), (-pi, -pi), (0.0, pi)] {
            let mut after = definition.initial;
            after.b.triad = product(
                &[0, 1, 2].map(|i| {
                    let mut row = [0.0; 3];
                    row[i] = if axis[i] == 1.0 { 1.0 } else { -1.0 };
                    row
                }),
                &after.b.triad,
            );
            let mut increment = Increment::none();
            increment.rotation[1] = scale(axis, told);
            let state = State { pair: after, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
            let request = Request::everything(0);
            let got = connector.evaluate(
                &state,
                &increment,
                &connector.initial_branch(),
                &request,
                &mut Tally::default(),
            );
            let moved = got.displacement[component].unwrap();
            let place = format!("{name}, component {}, told {told}", component + 1);
            // The sweep starts where −e2a·e3b is positive and ends where it is negative: at 0 and at π.
            assert!((moved - expected).abs() < 1e-14, "{place}: {moved}, not {expected}");
        }
    }
}

/// At collinear shafts and at r = 0 the components that do not exist there are told, with the class of the singularity, and no
/// others; beside them nothing is.
#[test]
fn singular_points_of_shafts_are_told() {
    use pintle_kinematics::measure::SingularClass::{Kink, Reversal, TrueSingularity};
    const ALONG: [f64; 3] = [0.0, 0.0, 1.5];
    const ACROSS: [f64; 3] = [0.7, -0.2, 1.5];
    let straight: Matrix<f64> = vector::identity();
    let over = [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    let bent = crate::states::about_1(0.8);
    let kinked = [("u1", Kink)].to_vec();
    let coupling = [("ur1", Kink), ("ur3", TrueSingularity)].to_vec();
    let over_bent = [("ur1", Reversal), ("ur2", Reversal), ("ur3", TrueSingularity)].to_vec();
    let all = |names: &[&'static str]| names.iter().map(|name| (*name, TrueSingularity)).collect::<Vec<_>>();
    for (name, q, reference, expected) in [
        ("RADIAL-THRUST", bent, ALONG, kinked),
        ("RADIAL-THRUST", bent, ACROSS, vec![]),
        ("FLEXION-TORSION", straight, ACROSS, coupling),
        (
            "FLEXION-TORSION",
            over,
            ACROSS,
            [("ur1", Kink), ("ur2", TrueSingularity), ("ur3", TrueSingularity)].to_vec(),
        ),
        ("FLEXION-TORSION", bent, ACROSS, vec![]),
        ("CONSTANT VELOCITY", straight, ACROSS, vec![]),
        ("CONSTANT VELOCITY", over, ACROSS, all(&["ur2"])),
        ("PROJECTION FLEXION-TORSION", straight, ACROSS, vec![]),
        ("PROJECTION FLEXION-TORSION", over, ACROSS, over_bent),
        ("PROJECTION CARTESIAN", straight, ACROSS, vec![]),
        ("PROJECTION CARTESIAN", over, ACROSS, all(&["u1", "u2", "u3"])),
    ] {
        let definition = crate::states::definition(entry(name), pair(reference, straight, &q), 1.0);
        let connector = Connector::<f64>::new(&definition);
        let state = State { pair: definition.initial, velocity: [0.3; DOFS], acceleration: [0.1; DOFS] };
        let (before, increment) = (connector.initial_branch(), Increment::none());
        let got =
            connector.evaluate(&state, &increment, &before, &Request::everything(2), &mut Tally::default());
        let margins = connector.margins(&state, &got.branch, [true; 6]);
        let flags = connector.flags(&margins, &increment, &state, &before, &got.branch);
        let told: Vec<_> = flags
            .iter()
            .map(|flag| match flag {
                Flag::Singular { component, class, .. } => (*component, *class),
                other => panic!("{name}: {other:?}"),
            })
            .collect();
        assert_eq!(told, expected, "{name}, e3a·e3b = {}", q[2][2]);
        for c in 0..6 {
            let numbers = [got.position[c], got.velocity[c], got.acceleration[c]].into_iter().flatten();
            let rows = got.jacobian[c].into_iter().flatten();
            let second = got.hessian[c].iter().flat_map(|h| h.as_flattened().to_vec());
            for number in numbers.chain(rows).chain(second) {
                assert!(number.is_finite(), "{name}, component {}: {number} is not finite", c + 1);
            }
        }
    }
}
