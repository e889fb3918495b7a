//! How nodes move, as files tell it: states of a scene, and states between those.

use crate::column::{Map, Motion, Rotations};
use crate::printed::Printed;
use crate::read::{Frame, Results};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, identity, product};
use pintle_scene::{Label, NodeMotion, Rotation, Scene, State};
use std::collections::BTreeMap;

/// The states of a run, as scenes have them.
pub(crate) struct Motions {
    pub(crate) labels: BTreeMap<String, Label>,
    map: Map,
    /// Total rotations, where the file has increments.
    turned: BTreeMap<Label, Matrix<f64>>,
}

/// The name that files have for a node or an element.
pub(crate) fn in_files(label: &Label) -> String {
    label.to_string().to_ascii_uppercase()
}

/// The nodes of a scene by the names that files have.
pub(crate) fn labels(scene: &Scene) -> BTreeMap<String, Label> {
    scene.nodes.keys().map(|label| (in_files(label), *label)).collect()
}

impl Motions {
    pub(crate) fn new(scene: &Scene, map: &Map) -> Self {
        Self { labels: labels(scene), map: map.clone(), turned: BTreeMap::new() }
    }

    /// The state of a frame.
    pub(crate) fn state(&mut self, frame: &Frame) -> Result<State, String> {
        let mut state = State { number: frame.number, time: frame.time, ..State::default() };
        for (node, motions) in &frame.nodes {
            // A file holds more nodes than a scene needs.
            let Some(label) = self.labels.get(node) else { continue };
            let mut motion = of_node(motions)?;
            if self.map.rotations == Rotations::Incremental {
                let before = self.turned.get(label).copied().unwrap_or_else(identity);
                let now = product(&motion.rotation.matrix(), &before);
                self.turned.insert(*label, now);
                motion.rotation = Rotation::Quaternion(so3::quaternion(&now));
            }
            state.nodes.insert(*label, motion);
        }
        Ok(state)
    }
}

/// The motion of a node from what a file says of it.
fn of_node(motions: &[(Motion, Printed)]) -> Result<NodeMotion, String> {
    let mut found = NodeMotion::default();
    let (mut vector, mut quaternion) = ([0.0; 3], None);
    for (motion, number) in motions {
        let x = number.x;
        match motion {
            Motion::Displacement(i) => found.displacement[*i] = x,
            Motion::Rotation(i) => vector[*i] = x,
            Motion::Quaternion(i) => quaternion.get_or_insert([0.0; 4])[*i] = x,
            Motion::Velocity(i) => found.velocity[*i] = x,
            Motion::AngularVelocity(i) => found.angular_velocity[*i] = x,
            Motion::Acceleration(i) => found.acceleration[*i] = x,
            Motion::AngularAcceleration(i) => found.angular_acceleration[*i] = x,
            Motion::Flow => found.flow = x,
            Motion::FlowVelocity => found.flow_velocity = x,
            Motion::FlowAcceleration => found.flow_acceleration = x,
        }
    }
    found.rotation = match quaternion {
        None => Rotation::Vector(vector),
        Some(q) => {
            let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (norm - 1.0).abs() > 1e-3 {
                return Err(format!("a quaternion of norm {norm}: is it q0, q1, q2, q3, the scalar first?"));
            }
            // Printed digits leave the norm a little off.
            Rotation::Quaternion(q.map(|x| x / norm))
        }
    };
    Ok(found)
}

/// The states that files tell, for whoever reads states.
///
/// # Errors
/// What cannot be read, with file and line.
pub fn states(scene: &Scene, results: &Results) -> Result<Vec<State>, String> {
    let mut motions = Motions::new(scene, &results.map);
    let mut found = Vec::new();
    results.each(|frame| {
        if frame.moves {
            let mut state = motions.state(frame)?;
            state.number = state.number.or(Some(found.len() as u64));
            found.push(state);
        }
        Ok(())
    })?;
    Ok(found)
}

/// Moves a node a little.
pub(crate) fn shift(node: &mut NodeMotion, motion: Motion, by: f64) {
    match (motion, &mut node.rotation) {
        (Motion::Displacement(i), _) => node.displacement[i] += by,
        (Motion::Rotation(i), Rotation::Vector(vector)) => vector[i] += by,
        (Motion::Rotation(i), Rotation::Quaternion(quaternion)) => {
            let mut turn = [0.0; 3];
            turn[i] = by;
            let turned = product(&so3::exp(turn), &so3::matrix(*quaternion));
            *quaternion = so3::quaternion(&turned);
        }
        (Motion::Quaternion(i), Rotation::Quaternion(quaternion)) => {
            quaternion[i] += by;
            let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            *quaternion = quaternion.map(|x| x / norm);
        }
        (Motion::Quaternion(_), Rotation::Vector(_)) => {}
        (Motion::Velocity(i), _) => node.velocity[i] += by,
        (Motion::AngularVelocity(i), _) => node.angular_velocity[i] += by,
        (Motion::Acceleration(i), _) => node.acceleration[i] += by,
        (Motion::AngularAcceleration(i), _) => node.angular_acceleration[i] += by,
        (Motion::Flow, _) => node.flow += by,
        (Motion::FlowVelocity, _) => node.flow_velocity += by,
        (Motion::FlowAcceleration, _) => node.flow_acceleration += by,
    }
}

/// So many states wait for the next that has a motion.
const WAITING: usize = 100_000;

/// Fills in the motions of states that have none, from those before and after.
#[derive(Debug, Default)]
pub(crate) struct Between {
    /// The last three states that have one.
    known: Vec<Frame>,
    /// States since then that have none.
    waiting: Vec<Frame>,
}

impl Between {
    /// Takes the next state; gives those that are complete.
    pub(crate) fn push(&mut self, frame: Frame) -> Vec<Frame> {
        if !frame.moves {
            self.waiting.push(frame);
            // After so many the motion has ended.
            return if self.waiting.len() < WAITING { Vec::new() } else { std::mem::take(&mut self.waiting) };
        }
        let mut done = std::mem::take(&mut self.waiting);
        for waiting in &mut done {
            between(&self.known, &frame, waiting);
        }
        self.known.push(Frame { elements: BTreeMap::new(), forces: BTreeMap::new(), ..frame.clone() });
        if self.known.len() > 3 {
            self.known.remove(0);
        }
        done.push(frame);
        done
    }

    /// What is left: it has no state after it.
    pub(crate) fn rest(self) -> Vec<Frame> {
        self.waiting
    }
}

/// Gives a state the motion on the straight line from the last of some states to the next one. Half a unit of its digits grows by
/// twice what a parabola through three of them differs from that.
fn between(known: &[Frame], next: &Frame, frame: &mut Frame) {
    let Some(last) = known.last() else { return };
    let (Some(t), Some(from), Some(to)) = (frame.time, last.time, next.time) else { return };
    let s = (t - from) / (to - from);
    if !(0.0..=1.0).contains(&s) {
        return;
    }
    let of = |frame: &Frame, node: &str, motion: Motion| {
        let all = frame.nodes.get(node)?;
        all.iter().find(|(known, _)| *known == motion).map(|(_, x)| *x)
    };
    for (node, motions) in &next.nodes {
        let at = motions.iter().filter_map(|(motion, second)| {
            let first = of(last, node, *motion)?;
            // Second differences there and one state earlier: one of them may be nothing, where the motion bends the other way.
            let mut points: Vec<(f64, f64)> =
                known.iter().filter_map(|frame| Some((frame.time?, of(frame, node, *motion)?.x))).collect();
            points.push((to, second.x));
            let bends = points.windows(3).map(|of| {
                let slope = |n: usize| (of[n + 1].1 - of[n].1) / (of[n + 1].0 - of[n].0);
                ((slope(1) - slope(0)) / (of[2].0 - of[0].0)).abs() * (t - from) * (to - t)
            });
            let bend = bends.reduce(f64::max).unwrap_or((second.x - first.x).abs() * s * (1.0 - s));
            let half = first.half.max(second.half) + 2.0 * bend;
            Some((*motion, Printed { x: first.x + s * (second.x - first.x), half }))
        });
        let at: Vec<_> = at.collect();
        if !at.is_empty() {
            frame.nodes.insert(node.clone(), at);
            (frame.moves, frame.is_between) = (true, true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_state_between_two_is_within_what_is_said_of_it() {
        let frame = |time: f64| {
            let x = Printed { x: (1.3 * time).sin(), half: 0.0 };
            let nodes = BTreeMap::from([("2".to_string(), vec![(Motion::Displacement(0), x)])]);
            Frame { time: Some(time), nodes, moves: true, ..Frame::default() }
        };
        let (mut between, mut found) = (Between::default(), Vec::new());
        for n in 0..40 {
            let time = 0.1 * f64::from(n);
            found.extend(between.push(if n % 4 == 0 {
                frame(time)
            } else {
                Frame { time: Some(time), ..Frame::default() }
            }));
        }
        assert_eq!((found.len(), between.rest().len()), (37, 3));
        for frame in found.iter().filter(|frame| frame.is_between) {
            let x = frame.nodes["2"][0].1;
            assert!((x.x - (1.3 * frame.time.unwrap()).sin()).abs() <= x.half, "{frame:?}");
        }
        assert_eq!(found.iter().filter(|frame| frame.is_between).count(), 27);
    }
}
