//! Turns are counted, kept and never lost.

use super::U;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Branch, Connector, Definition, Increment, State};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::{Real, Wide};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::Vector;
use std::f64::consts::{PI, TAU};

/// The misses of the identity at whole turns.
const MISSES: [f64; 9] = [0.0, 1e-17, 1e-16, 1e-12, 1e-9, 1e-6, 1e-4, 1e-3, 1e-2];

/// s from 0 to 40 rad, with samples at the doubles nearest to 2πk.
fn path(step: f64) -> Vec<f64> {
    let mut samples: Vec<f64> = (0..=(40.0 / step) as usize).map(|i| i as f64 * step).collect();
    samples.extend((1..=6).map(|k| f64::from(k) * TAU));
    samples.sort_by(f64::total_cmp);
    samples
}

/// Half a turn is π n or −π n; which one does not hang on the signs of zeros in the matrix: the largest part of n is positive.
#[test]
fn the_sign_of_a_zero_chooses_no_axis() {
    for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [-0.6, 0.8, 0.0]] {
        let largest =
            axis.into_iter().fold(0.0, |most: f64, x: f64| if x.abs() > most.abs() { x } else { most });
        let expected = axis.map(|x| PI * x * largest.signum());
        for signs in 0..1 << 9 {
            let entry = |i: usize, j: usize| {
                let exact = 2.0 * axis[i] * axis[j] - f64::from(u8::from(i == j));
                let is_negative = signs >> (3 * i + j) & 1 == 1;
                if exact == 0.0 && is_negative { -0.0 } else { exact + 0.0 }
            };
            let r = [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)));
            let wide = so3::log(&r.map(|row| row.map(Wide::from_f64))).map(Wide::to_f64);
            for phi in [so3::log(&r), wide, so3::continuous_log(&r, [0.0; 3]).phi] {
                assert!((0..3).all(|i| (phi[i] - expected[i]).abs() < 4e-15), "{axis:?} {r:?}: {phi:?}");
            }
        }
    }
}

fn size(v: Vector<f64>) -> f64 {
    vector::dot(v, v).sqrt()
}

/// Paths about a fixed axis that miss the identity sideways: 9 misses × 3 steps, from matrices and from quaternions. The log
/// stays on its sheet, and is a log.
#[test]
fn turns_are_kept_where_a_path_passes_near_whole_turns() {
    let axis = [0.36, 0.48, 0.8];
    let sideways = [0.8, -0.6, 0.0];
    let (mut kept, mut off) = (0, [0.0f64; 2]);
    for from_matrix in [false, true] {
        for miss in MISSES {
            for step in [1.0, 0.1, 0.01] {
                let mut reference = [0.0; 3];
                let mut lost = None;
                for (i, s) in path(step).into_iter().enumerate() {
                    let q = so3::compose(
                        so3::exp_quaternion(vector::scale(sideways, miss)),
                        so3::exp_quaternion(vector::scale(axis, s)),
                    );
                    let log = if from_matrix {
                        so3::continuous_log(&so3::matrix(q), reference)
                    } else {
                        so3::continuous_log_quaternion(q, reference)
                    };
                    // Near a whole turn |φ| − 2πk is the angle left, of either sign; elsewhere |φ| is s, less than the miss off.
                    if (size(log.phi) - s).abs() > 2.0 * miss + 1e-13 {
                        lost.get_or_insert((s, log.phi));
                    }
                    // Beyond 32 rad the rounding of φ itself counts.
                    if i % 5 == 0 {
                        let back = so3::exp_quaternion::<Wide>(vector::exact(log.phi)).map(Wide::to_f64);
                        let sign = (0..4).map(|i| back[i] * q[i]).sum::<f64>().signum();
                        let error = (0..4).map(|i| (sign * back[i] - q[i]).abs()).fold(0.0, f64::max);
                        assert!(
                            error < 5e-15_f64.max(1.4 * U * s),
                            "miss {miss:e}, step {step}, s = {s}, from matrix: {from_matrix}: exp(log) off by {error:e}"
                        );
                        off[usize::from(from_matrix)] = off[usize::from(from_matrix)].max(error);
                    }
                    if log.is_reference() {
                        reference = log.phi;
                    }
                }
                assert_eq!(lost, None, "miss {miss:e}, step {step}, from matrix: {from_matrix}");
                kept += 1;
            }
        }
    }
    println!("turns kept on {kept} paths, exp(log) within {off:?}");
}

/// Going there and back ends where it began, to the last bit: nothing accumulates.
#[test]
fn there_and_back_leaves_no_trace() {
    let axis = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
    let samples = path(0.37);
    let mut reference = [0.0; 3];
    let mut visit = |s: f64| {
        let log = so3::continuous_log(&so3::matrix(so3::exp_quaternion(vector::scale(axis, s))), reference);
        if log.is_reference() {
            reference = log.phi;
        }
        log.phi
    };
    let out: Vec<_> = samples.iter().map(|s| visit(*s)).collect();
    let back: Vec<_> = samples.iter().rev().map(|s| visit(*s)).collect();
    for (out, back) in out.iter().zip(back.iter().rev()) {
        assert_eq!(out, back);
    }
}

/// From a saved reference at up to 1e9 turns, the rotation vector is that of the exact angle, rounded, for either direction
/// of further motion.
#[test]
fn a_billion_turns() {
    let axis = [0.0, 0.6, -0.8];
    let mut worst = 0.0f64;
    for turns in [1.0, 1e2, 1e4, 1e6, 1e8, 999_999_999.0, 1e9] {
        let mut reference = vector::scale(axis, f64::with_turns(0.5, turns));
        // 40 steps of 1.5 rad forwards, then backwards.
        for i in (0..=40).chain((0..40).rev()) {
            let moved = 0.5 + 1.5 * f64::from(i);
            let log =
                so3::continuous_log_quaternion(so3::exp_quaternion(vector::scale(axis, moved)), reference);
            let angle = Wide::with_turns(Wide::from_f64(moved), Wide::from_f64(turns));
            let error = (Wide::from_f64(vector::dot(log.phi, axis)) - angle).abs() / angle;
            worst = worst.max((error / U).to_f64());
            assert!(error < 6.0 * U, "{turns:e} turns, {moved} rad on: off by {error} of the angle");
            if log.is_reference() {
                reference = log.phi;
            }
        }
    }
    println!("continuous log at up to 1e9 turns: {worst:.2} u of the angle");
}

/// The angle of a REVOLUTE connector from a branch that was saved, and read back, at up to 1e9 turns: the count is exact, the
/// principal angle as good as on the first turn.
#[test]
fn a_saved_branch_of_a_billion_turns() {
    let at = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    let pair = |angle: f64| Pair {
        reference: [0.0; 3],
        a: at(vector::identity()),
        b: at(so3::matrix(so3::exp_quaternion([angle, 0.0, 0.0]))),
    };
    let revolute = ConnectionType::named("REVOLUTE", None).unwrap();
    let connector = Connector::<f64>::new(&Definition::new(revolute, pair(0.0)));
    for start in [0.0, 1.0, 1e6, -1e9, 1e9, 4e15] {
        let mut branch = connector.initial_branch();
        branch.turns[3].turns = start;
        let saved = serde_json::to_string(&branch).unwrap();
        let mut branch: Branch<f64> = serde_json::from_str(&saved).unwrap();
        // 3 rad a step: almost half a turn.
        for i in (0..=2000).chain((0..2000).rev()) {
            let angle = 3.0 * f64::from(i);
            let state = State { pair: pair(angle), velocity: [0.0; DOFS], acceleration: [0.0; DOFS] };
            branch = connector.advance(&state, &Increment::none(), &branch);
            let counted = ((angle - branch.turns[3].principal) / TAU).round();
            assert_eq!(branch.turns[3].turns, start + counted, "{angle} rad from {start} turns");
            let exact = Wide::with_turns(Wide::from_f64(angle), Wide::from_f64(-counted));
            let error = (exact - branch.turns[3].principal).abs();
            assert!(error < 4.0 * U * angle.max(1.0), "{angle} rad from {start} turns: off by {error}");
        }
        assert_eq!((branch.turns[3].turns, branch.turns[3].principal), (start, 0.0));
    }
}

/// principal + 2πn is the double nearest to the exact sum, or its neighbour in a near tie.
#[test]
fn whole_turns_add_no_error() {
    for n in [0.0, 1.0, -1.0, 2.0, 3.0, 100.0, -12_345.0, 1e6, 123_456_789.0, -1e9, 1e9] {
        for i in -31..=31 {
            let principal = f64::from(i) / 10.0;
            let exact = Wide::with_turns(Wide::from_f64(principal), Wide::from_f64(n));
            let computed = f64::with_turns(principal, n);
            let error = (Wide::from_f64(computed) - exact).abs() / exact.abs().max(Wide::from_f64(1e-300));
            assert!(error <= 1.001 * U, "{principal} + 2π·{n}: {computed} for {exact}");
        }
    }
}

/// Half a turn has the sign of its reference, and both signs are logs of it.
#[test]
fn half_a_turn_continues_either_way() {
    for axis in [[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.6, 0.0, 0.8], [-0.6, 0.8, 0.0]] {
        for s in [PI - 1e-3, PI - 1e-9, PI, PI + 1e-9, PI + 1e-3] {
            for sign in [1.0, -1.0] {
                let phi = vector::scale(axis, sign * s);
                let log = so3::continuous_log(
                    &so3::matrix(so3::exp_quaternion(phi)),
                    vector::scale(axis, sign * 3.0),
                );
                for i in 0..3 {
                    assert!((log.phi[i] - phi[i]).abs() < 16.0 * U * PI, "{phi:?}: {:?}", log.phi);
                }
            }
        }
    }
}
