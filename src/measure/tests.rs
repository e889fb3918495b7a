//! What batches ask of a first attempt.

use super::{History, Section, Shared};
use crate::node::Relative;
use crate::{so3, vector};
use std::f64::consts::{FRAC_PI_2, PI};

/// The rotation vector of a first attempt is the principal one, and continues the history where the reference is within half a turn
/// of zero and not on the other side; half a turn from a reference at zero does. Where it has not been asked for, nothing is lost.
#[test]
fn a_first_attempt_knows_whether_it_holds() {
    let continued = |angle: f64, reference: f64, asks: bool| {
        let axis = [0.0, 0.6, 0.8];
        let q = so3::matrix(so3::exp(vector::scale(axis, angle)));
        let relative = Relative { d: [0.0; 3], q, flow: [0.0; 2], spin: None };
        let history =
            History { rotation_vector: vector::scale(axis, reference), euler_sign: 1.0, torsion_turns: 0.0 };
        let section = Section {
            initial_orientation: vector::identity(),
            initial_length: 1.0,
            fixed_direction: [0.0; 3],
            flow_scale: 1.0,
        };
        let triad = vector::identity();
        let mut shared = Shared::new(&relative, &triad, &section, &history).principal();
        if asks {
            let phi = shared.rotation_vector();
            assert!((vector::dot(phi, axis) - angle).abs() < 1e-14, "{angle} {phi:?}");
        }
        shared.is_continued()
    };
    for (angle, reference, holds) in [
        (0.5, 0.0, true),
        (0.5, 3.0, true),
        (0.5, -3.0, false),
        (0.5, 3.2, false),
        (2.0, 2.5, true),
        (3.0, -1.0, false),
        (FRAC_PI_2, -0.4, true),
    ] {
        assert_eq!(continued(angle, reference, true), holds, "{angle} {reference}");
        assert!(continued(angle, reference, false));
    }
    // Half a turn exactly, where w = 0.
    let half = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    let (phi, nearness) = so3::principal_log_along(&half, None, [0.0; 3]);
    assert_eq!(phi, [0.0, 0.0, PI]);
    assert!(nearness > 0.0);
}
