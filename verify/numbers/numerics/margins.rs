//! How far states are from the sets where measures are singular, by hand.

use pintle_kinematics::measure::{History, Measure, Section};
use pintle_kinematics::node::Relative;
use pintle_kinematics::{so3, vector};

/// The distance of a rotation vector to the nearest whole turn that is not zero, and of a belt segment to where it has no length:
/// that between the nodes, or that of the material, which flow takes up.
#[test]
fn margins_of_turns_and_of_belts() {
    let section = Section {
        initial_orientation: vector::identity(),
        initial_length: 3.0,
        fixed_direction: [0.0; 3],
        flow_scale: 0.0,
    };
    let axis = [0.6, 0.0, -0.8];
    let tau = std::f64::consts::TAU;
    for (angle, distance) in [
        (1.0, tau - 1.0),
        (4.0, tau - 4.0),
        (7.0, 7.0 - tau),
        (9.0, 9.0 - tau),
        (10.0, 2.0 * tau - 10.0),
        (20.0, 20.0 - 3.0 * tau),
    ] {
        let vector = axis.map(|e| e * angle);
        let relative =
            Relative { d: [0.0; 3], q: so3::matrix(so3::exp_quaternion(vector)), flow: [0.0; 2], spin: None };
        let history = History { rotation_vector: vector, euler_sign: 1.0, torsion_turns: 0.0 };
        let margin = Measure::RotationVector(1).margin(&relative, &section, &history).unwrap();
        assert!((margin.distance - distance).abs() < 1e-14, "{angle}: {}", margin.distance);
    }
    let history = History { rotation_vector: [0.0; 3], euler_sign: 1.0, torsion_turns: 0.0 };
    for (flow, distance, is_coincidence) in [
        ([0.0, 0.0], 3.0, false),
        ([1.0, 0.5], 3.5, false),
        ([1.0, -0.5], 4.5, false),
        ([4.0, 1.0], 5.0, true),
        ([0.0, 4.0], 0.0, false),
        // As long as the material: the length of the material decides.
        ([2.0, 0.0], 5.0, false),
    ] {
        let relative = Relative { d: [3.0, 0.0, 4.0], q: vector::identity(), flow, spin: None };
        let margin = Measure::Strain.margin(&relative, &section, &history).unwrap();
        assert_eq!(
            (margin.distance, margin.set.at.starts_with("coincident")),
            (distance, is_coincidence),
            "{flow:?}"
        );
    }
}
