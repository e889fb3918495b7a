//! Are angles in degrees? They are in radians, in decks as in states.

use crate::model::finding::{About, Finding};
use pintle_scene::{
    Boundary, Code, ConnectorMotion, Degrees, InDegrees, MotionType, Scene, Span, State, is_in_degrees,
    told_in_degrees,
};

fn finding(scene: &Scene, place: Span, (what, angle): (String, f64), about: About) -> Finding {
    let (message, reason, remedy) = told_in_degrees(&what, angle);
    let about = About { value: Some(angle), ..about };
    Finding::new(scene, Code::ModelDegrees, place, message, reason, remedy).about(about)
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

/// The rotation of a node at a state that looks like degrees, where any does; whether most angles do, so that what else is wrong with them
/// follows from that.
pub(super) fn of_states(scene: &Scene, states: &[State]) -> Option<(Finding, bool)> {
    let mut seen = Degrees::default();
    for (index, state) in states.iter().enumerate() {
        seen.see(state.number.unwrap_or(index as u64), state);
    }
    let InDegrees { state, node, angle, what, is_common } = seen.found()?;
    let about = About { nodes: vec![node], state: Some(state), ..About::default() };
    let finding = finding(scene, Span::default(), (what, angle), about);
    let rest = if is_common { "; the states are not judged further unless this code is allowed" } else { "" };
    Some((finding.add(rest), is_common))
}
