//! A solution as arrays: frames first, then nodes or connectors, then components.

use crate::cli::output::npz::Array;
use pintle_solve::{ConnectorFrame, Frame, NodeFrame, Number, Solution};

pub(super) fn arrays<R: Number>(solution: &Solution<R>) -> Vec<Array> {
    let Solution { frames, events, nodes, connectors, .. } = solution;
    let doubles = |all: Vec<R>| -> Vec<f64> { all.into_iter().map(Number::to_f64).collect() };
    let each = |of: &dyn Fn(&Frame<R>) -> Vec<R>| doubles(frames.iter().flat_map(of).collect());
    let of_nodes = |name, of: &dyn Fn(&NodeFrame<R>) -> Vec<R>| {
        let numbers = each(&|frame| frame.nodes.iter().flat_map(of).collect());
        Array::numbers(name, vec![frames.len(), nodes.len(), 3], numbers)
    };
    let flow = |name, k: usize| {
        let numbers = each(&|frame| frame.nodes.iter().map(|node| node.flow[k]).collect());
        Array::numbers(name, vec![frames.len(), nodes.len()], numbers)
    };
    let of_connectors = |name, of: &dyn Fn(&ConnectorFrame<R>) -> [R; 6]| {
        let numbers = each(&|frame| frame.connectors.iter().flat_map(of).collect());
        Array::numbers(name, vec![frames.len(), connectors.len(), 6], numbers)
    };
    let sticks = |frame: &Frame<R>| -> Vec<f64> {
        let stuck = |of: &ConnectorFrame<R>| !of.sticks.is_empty() && of.sticks.iter().all(|sticks| *sticks);
        frame.connectors.iter().map(|of| f64::from(stuck(of))).collect()
    };
    let count = frames.len();
    // What is open is no number.
    let known = |is_open: bool, force: R| if is_open { f64::NAN } else { force.to_f64() };
    let energies = frames.iter().flat_map(|frame| {
        let of = &frame.energies;
        let [kinetic, dissipated, external] = [of.kinetic, of.dissipated, of.external].map(Number::to_f64);
        [kinetic, known(solution.stored_is_open, of.stored), dissipated, external]
    });
    let energies: Vec<f64> = energies.collect();
    let forces = |of: &dyn Fn(&ConnectorFrame<R>) -> [f64; 6]| -> Vec<f64> {
        frames.iter().flat_map(|frame| &frame.connectors).flat_map(of).collect()
    };
    let total = forces(&|of| std::array::from_fn(|k| known(of.open[k], of.total[k])));
    let friction = forces(&|of| std::array::from_fn(|k| known(of.open_friction[k], of.friction[k])));
    vec![
        Array::numbers("time", vec![count], each(&|frame| vec![frame.time])),
        Array::words("node", nodes.iter().map(ToString::to_string).collect()),
        of_nodes("U", &|node| node.displacement.to_vec()),
        of_nodes("UR", &|node| node.rotation.to_vec()),
        of_nodes("V", &|node| node.velocity[..3].to_vec()),
        of_nodes("VR", &|node| node.velocity[3..].to_vec()),
        of_nodes("A", &|node| node.acceleration[..3].to_vec()),
        of_nodes("AR", &|node| node.acceleration[3..].to_vec()),
        flow("flow", 0),
        flow("flow_velocity", 1),
        flow("flow_acceleration", 2),
        Array::words("element", connectors.iter().map(|(label, _)| label.to_string()).collect()),
        of_connectors("CU", &|of| of.displacement),
        of_connectors("CV", &|of| of.velocity),
        Array::numbers("CTF", vec![count, connectors.len(), 6], total),
        Array::numbers("CSF", vec![count, connectors.len(), 6], friction),
        Array::numbers("sticks", vec![count, connectors.len()], frames.iter().flat_map(sticks).collect()),
        Array::numbers("energies", vec![count, 4], energies),
        Array::numbers(
            "event_time",
            vec![events.len()],
            doubles(events.iter().map(|event| event.time).collect()),
        ),
        Array::words("event", events.iter().map(|event| event.what.name().to_string()).collect()),
        Array::words(
            "event_element",
            events
                .iter()
                .filter_map(|event| connectors.get(event.connector))
                .map(|(label, _)| label.to_string())
                .collect(),
        ),
    ]
}
