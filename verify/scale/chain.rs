//! Chains of connectors of every type, as decks of any length, and motions of their nodes.

use pintle_kinematics::catalog::{Availability, ConnectionType, Orientation, TABLE};
use pintle_scene::{Label, NodeMotion, Rotation, State};
use std::fmt::Write;

/// The types of a chain, in turn: every type, and a free pair.
pub(crate) fn types() -> Vec<(String, &'static [Orientation])> {
    const BOTH: [&[Orientation]; 3] = [&[], &[Orientation::Required], &[Orientation::Required; 2]];
    let wanted = |connection: &ConnectionType| {
        let permitted = connection.orientation.iter().filter(|rule| rule.orientation != Orientation::Ignored);
        BOTH[permitted.count()]
    };
    let usable = |connection: &&ConnectionType| {
        matches!(connection.availability, Availability::Always | Availability::StandardOnly)
    };
    let mut types: Vec<_> =
        TABLE.iter().filter(usable).map(|entry| (entry.name.to_string(), wanted(entry))).collect();
    types.push(("CARTESIAN, CARDAN".to_string(), BOTH[2]));
    types
}

/// The deck of a chain: node i at x = i, connector i from node i to i + 1, every fifth the other way round, every eleventh from the
/// ground, which is where the node is: a length cannot begin there. `rest` follows.
pub(crate) fn deck(connectors: usize, types: &[(String, &[Orientation])], rest: &str) -> String {
    let mut text = String::from("*NODE, NSET=ALL\n");
    for node in 1..=connectors + 1 {
        let bend = (node % 7) as f64 * 0.125;
        writeln!(text, "{node}, {node}., {bend}, {}", bend - 0.25).unwrap();
    }
    // Every node can turn.
    text.push_str("*ELEMENT, TYPE=ROTARYI, ELSET=TURNING\n");
    (1..=connectors + 1).for_each(|node| writeln!(text, "{}, {node}", 10_000_000 + node).unwrap());
    text.push_str("*ORIENTATION, NAME=A\n0.6, 0.8, 0., -0.8, 0.6, 0.\n*ORIENTATION, NAME=B\n0.6, 0.8, 0., -0.75, 0.6, 0.1\n");
    for (place, (name, orientations)) in types.iter().enumerate() {
        let members: Vec<usize> = (1..=connectors).filter(|number| number % types.len() == place).collect();
        if members.is_empty() {
            continue;
        }
        writeln!(text, "*ELEMENT, TYPE=CONN3D2, ELSET=E{place}").unwrap();
        for number in members {
            let grounded = number % 11 == 3 && !matches!(name.as_str(), "LINK" | "AXIAL" | "SLIPRING");
            match (grounded, number % 5) {
                (true, _) => writeln!(text, "{number}, , {}", number + 1).unwrap(),
                (_, 2) => writeln!(text, "{number}, {}, {number}", number + 1).unwrap(),
                _ => writeln!(text, "{number}, {number}, {}", number + 1).unwrap(),
            }
        }
        writeln!(text, "*CONNECTOR SECTION, ELSET=E{place}\n{name}").unwrap();
        match orientations.len() {
            0 => {}
            1 => text.push_str("A,\n"),
            _ => text.push_str("A, B\n"),
        }
    }
    text.push_str(rest);
    text
}

/// State `number` of a motion of nodes 1 to `nodes`: each swings by itself, and two of three turn on and on.
pub(crate) fn state(number: u64, nodes: usize) -> State {
    let time = number as f64 * 0.125;
    let moved = (1..=nodes).map(|node| {
        let phase = node as f64;
        let swing = |rate: f64| (rate * time + phase).sin();
        let motion = NodeMotion {
            displacement: [0.05 * swing(1.0), 0.04 * swing(1.3), 0.03 * swing(0.7)],
            rotation: Rotation::Vector([
                0.2 * swing(0.9),
                0.3 * swing(1.1),
                0.5 * time * (node % 3) as f64 + 0.1 * swing(0.8),
            ]),
            velocity: [0.05, 0.04 * swing(0.3), -0.02],
            angular_velocity: [0.1 * swing(0.2), 0.2, 0.5],
            acceleration: [0.01, 0.0, 0.02 * swing(0.6)],
            angular_acceleration: [0.0, 0.3 * swing(0.1), 0.05],
            flow: 0.01 * swing(0.4),
            flow_velocity: 0.01,
            flow_acceleration: 0.0,
        };
        (Label::from(node as u64), motion)
    });
    State { number: Some(number), time: Some(time), nodes: moved.collect(), ..State::default() }
}
