//! Are angles in degrees? They are in radians, in decks as in states.
//!
//! What looks like degrees is a multiple of 15 without a fraction, from 30 on: of angles in radians, which are measured or computed,
//! hardly one in a million is such a number.

use crate::model::finding::{About, Finding};
use pintle_kinematics::vector::Vector;
use pintle_scene::grammar::{count, number};
use pintle_scene::{Boundary, Code, ConnectorMotion, Label, MotionType, Rotation, Scene, Span, State};
use std::collections::HashMap;

/// Whether an angle looks like one in degrees.
fn is_in_degrees(angle: f64) -> bool {
    angle.abs() >= 30.0 && angle % 15.0 == 0.0
}

const REASON: &str = "angles are in radians, in decks as in states";

fn finding(scene: &Scene, place: Span, (what, angle): (String, f64), about: About) -> Finding {
    let message =
        format!("{what}, which looks like degrees: in radians that is {}", number(angle.to_radians(), 6));
    let remedy = format!("write {} where {}° is meant", number(angle.to_radians(), 9), number(angle, 9));
    let about = About { value: Some(angle), ..about };
    Finding::new(scene, Code::ModelDegrees, place, message, REASON, remedy).about(about)
}

/// Angles of a deck that look like degrees: limits, motions, what is prescribed at nodes.
pub(super) fn of_scene(scene: &Scene) -> Vec<Finding> {
    let mut found = Vec::new();
    let component =
        |k: u8| About { components: vec![format!("ur{}", k.saturating_sub(3))], ..About::default() };
    for (name, behavior) in &scene.behaviors {
        for stop in behavior.stops.iter().filter(|stop| (4..=6).contains(&stop.component)) {
            let Some(limit) = [stop.lower, stop.upper].into_iter().flatten().find(|x| is_in_degrees(*x))
            else {
                continue;
            };
            let what = format!("a stop of ur{} in behavior {name} is at {limit}", stop.component - 3);
            found.push(finding(scene, stop.span, (what, limit), component(stop.component)));
        }
    }
    let of_steps = scene.steps.iter().flat_map(|step| &step.connector_motions);
    let motions = scene.connector_motions.iter().chain(of_steps);
    let is_angle = |motion: &&ConnectorMotion| {
        (4..=6).contains(&motion.component)
            && motion.kind == MotionType::Displacement
            && motion.applied.amplitude.is_none()
    };
    for motion in motions.filter(is_angle) {
        if let Some(angle) = motion.magnitude.filter(|x| is_in_degrees(*x)) {
            let what = format!("a connector motion turns ur{} by {angle}", motion.component - 3);
            found.push(finding(scene, motion.target.span, (what, angle), component(motion.component)));
        }
    }
    let of_steps = scene.steps.iter().flat_map(|step| &step.boundaries);
    let is_angle = |boundary: &&Boundary| {
        boundary.degrees_of_freedom.iter().any(|dof| (4..=6).contains(dof))
            && boundary.kind == MotionType::Displacement
            && boundary.applied.amplitude.is_none()
            && is_in_degrees(boundary.magnitude)
    };
    for boundary in scene.boundaries.iter().chain(of_steps).filter(is_angle) {
        let angle = boundary.magnitude;
        let what = format!("a boundary condition turns nodes by {angle}");
        found.push(finding(scene, boundary.target.span, (what, angle), About::default()));
    }
    found
}

/// What looks like degrees at states.
pub(super) struct InDegrees {
    pub(super) finding: Finding,
    /// Whether most angles of the states do, so that what else is wrong with them follows from that.
    pub(super) is_common: bool,
}

/// Whether the rates that states give show an increment to be in radians: they lead from one state to the next, to a fifth of the way.
fn is_proven(
    before: Option<&(f64, Vector<f64>, Vector<f64>)>,
    now: &(f64, Vector<f64>, Vector<f64>),
) -> bool {
    let (Some((t0, turned, rate)), (t1, turned_now, rate_now)) = (before, now) else { return false };
    let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
    for k in 0..3 {
        let moved = turned_now[k] - turned[k];
        let expected = (t1 - t0) * (rate[k] + rate_now[k]) / 2.0;
        apart = apart.max((moved - expected).abs());
        largest = largest.max(moved.abs());
    }
    largest > 0.0 && apart <= 0.2 * largest
}

/// The rotation of a node at a state that looks like degrees, where any does: the largest. What rates prove to be in radians does not.
pub(super) fn of_states(scene: &Scene, states: &[State]) -> Option<InDegrees> {
    let mut worst: Option<(u64, Label, f64)> = None;
    let (mut turned, mut angles) = (0_usize, 0_usize);
    let mut before: HashMap<Label, (f64, Vector<f64>, Vector<f64>)> = HashMap::new();
    for (index, state) in states.iter().enumerate() {
        for (node, motion) in &state.nodes {
            let Rotation::Vector(vector) = motion.rotation else { continue };
            let now = state.time.map(|time| (time, vector, motion.angular_velocity));
            let proven = now.as_ref().is_some_and(|now| is_proven(before.get(node), now));
            if let Some(now) = now {
                before.insert(*node, now);
            }
            if proven {
                continue;
            }
            angles += vector.into_iter().filter(|angle| *angle != 0.0).count();
            for angle in vector.into_iter().filter(|angle| is_in_degrees(*angle)) {
                turned += 1;
                if worst.is_none_or(|(.., most)| angle.abs() > most.abs()) {
                    worst = Some((state.number.unwrap_or(index as u64), *node, angle));
                }
            }
        }
    }
    let (state, node, angle) = worst?;
    let others =
        if turned > 1 { format!(" (and {})", count(turned - 1, "more such angle")) } else { String::new() };
    let what = format!("state {state} turns node {node} by {angle}{others}");
    let about = About { nodes: vec![node], state: Some(state), ..About::default() };
    let finding = finding(scene, Span::default(), (what, angle), about);
    let is_common = 2 * turned >= angles;
    let rest = if is_common { "; the states are not judged further unless this code is allowed" } else { "" };
    Some(InDegrees { finding: finding.add(rest), is_common })
}

#[cfg(test)]
mod tests {
    use super::is_in_degrees;

    #[test]
    fn round_numbers_of_degrees_are_told_from_radians() {
        assert!([30.0, -90.0, 360.0, 45.0, 720.0].into_iter().all(is_in_degrees));
        assert!(![0.0, 15.0, 29.999, 90.1, 31.415_926_535, 100.0].into_iter().any(is_in_degrees));
    }
}
