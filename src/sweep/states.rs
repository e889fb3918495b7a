//! Which state has an index.
//!
//! | of 256 | both nodes moved, and |
//! |---|---|
//! | 204 | turned, each uniformly on the rotation group |
//! | 16 | 1e-1 to 1e-12 from a singular point of the type, as the audit places them; as above where it has none |
//! | 16 | turned uniformly, b against a by 2⁻⁴⁰ to 1 rad about any axis, or about the normal of the plane |
//! | 16 | turned uniformly, b by up to three whole turns besides |
//! | 4 | in one of the 24 orientations of a cube each: exact right angles |
//!
//! A node that cannot turn, or cannot do so about any axis, leaves nothing of a line: its states count as turned uniformly.
//! States of the second line are drawn as the audit draws them, whatever the generator. Of the others only sums, products, quotients and roots are
//! computed, which every machine rounds alike.

use crate::generator::{Generator, Stream};
use crate::plan::length_of;
use pintle_audit::sampling::cube_orientations;
use pintle_audit::{Case, Sites, Step};
use pintle_kinematics::connector::{Connector, Definition, Increment, State};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3::{Quaternion, compose, matrix};
use pintle_kinematics::vector::{Matrix, add, product, scale};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Where a state lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Place {
    /// Anywhere.
    Anywhere,
    /// Near a singular point.
    Near,
    /// b turned little against a.
    Little,
    /// b turned by whole turns besides.
    Turns,
    /// At right angles.
    RightAngles,
}

impl Place {
    /// Every place.
    pub const ALL: [Self; 5] = [Self::Anywhere, Self::Near, Self::Little, Self::Turns, Self::RightAngles];

    const fn of(one_of_256: u64) -> Self {
        match one_of_256 {
            0..16 => Self::Near,
            16..32 => Self::Little,
            32..48 => Self::Turns,
            48..52 => Self::RightAngles,
            _ => Self::Anywhere,
        }
    }
}

/// A connector whose states are drawn.
#[derive(Clone, Debug)]
pub struct Source {
    /// What defines it.
    pub definition: Definition,
    /// Its length at rest.
    pub length: f64,
    sites: Sites,
    has_one_form: bool,
    turns: [bool; 2],
    cubes: Vec<Matrix<f64>>,
}

/// A state that was drawn.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// The nodes.
    pub pair: Pair<f64>,
    /// What leads there from the initial state.
    pub increment: Increment<f64>,
    /// Where it lies.
    pub place: Place,
}

impl Drawn {
    /// The state, at rest.
    pub const fn state(&self) -> State<f64> {
        State { pair: self.pair, velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
    }
}

impl Source {
    /// Of a connector.
    pub fn new(definition: &Definition, connector: &Connector<f64>) -> Self {
        let measures = (0..6).filter_map(|k| connector.position_measure(k));
        Self {
            sites: Sites::of(definition),
            has_one_form: measures.into_iter().any(Measure::is_one_form),
            turns: [0, 1].map(|end| definition.moves[end] && definition.rotates[end]),
            cubes: cube_orientations(),
            length: length_of(definition),
            definition: definition.clone(),
        }
    }

    /// The state of that index.
    pub fn state(&self, generator: Generator, key: u64, index: u64) -> Drawn {
        self.next(&mut Stream::new(generator, key, index))
    }

    /// The state that these numbers make.
    pub(crate) fn next(&self, stream: &mut Stream) -> Drawn {
        match self.possible(Place::of(stream.below(256))) {
            Place::Near => self.near(stream).unwrap_or_else(|| self.drawn(Place::Anywhere, stream)),
            place => self.drawn(place, stream),
        }
    }

    /// The place, or anywhere where the nodes cannot be brought there.
    const fn possible(&self, place: Place) -> Place {
        let is_there = match place {
            Place::Anywhere => true,
            Place::Near => !self.sites.is_empty(),
            Place::Little | Place::Turns => self.turns[1],
            Place::RightAngles => self.turns[0] && self.turns[1] && !self.definition.planar,
        };
        if is_there { place } else { Place::Anywhere }
    }

    /// As the audit places it.
    fn near(&self, stream: &Stream) -> Option<Drawn> {
        let draw = &mut Draw::new(&stream.name());
        let (Step { state, increment }, _) = self.sites.near(&self.definition, self.length, draw)?;
        Some(Drawn { pair: state.pair, increment, place: Place::Near })
    }

    fn drawn(&self, place: Place, stream: &mut Stream) -> Drawn {
        let Self { turns, .. } = self;
        let initial = &self.definition.initial;
        let mut quaternion = [self.rotation(stream), self.rotation(stream)];
        let mut whole = 0.0;
        match place {
            Place::Little => {
                let little = self.little(stream);
                quaternion[1] = if turns[0] { compose(quaternion[0], little) } else { little };
            }
            Place::Turns => whole = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0][stream.below(6) as usize],
            _ => {}
        }
        let mut pair = *initial;
        let mut increment = Increment::none();
        for (end, node) in [&mut pair.a, &mut pair.b].into_iter().enumerate() {
            self.place_node(node, end, stream);
            if turns[end] {
                node.triad = product(&matrix(quaternion[end]), &node.triad);
            }
            increment.flow[end] = node.flow - [&initial.a, &initial.b][end].flow;
        }
        if place == Place::RightAngles {
            for node in [&mut pair.a, &mut pair.b] {
                let cube = self.cubes.get(stream.below(self.cubes.len() as u64) as usize);
                node.triad = cube.copied().unwrap_or(node.triad);
            }
        }
        if self.has_one_form {
            increment = Step::between(initial, pair).increment;
        }
        if whole != 0.0 {
            let [_, x, y, z] = quaternion[1];
            let size = norm([x, y, z]);
            if size > 0.0 {
                increment.whole_turns[1] = scale([x, y, z], whole * TAU / size);
                increment.rotation[1] = add(increment.rotation[1], increment.whole_turns[1]);
            }
        }
        Drawn { pair, increment, place }
    }

    /// Moves a node, where it can be.
    fn place_node(&self, node: &mut Node<f64>, end: usize, stream: &mut Stream) {
        let [x, y, z] = stream.cube(self.length * [0.5, 1.0][end]);
        let flow = if self.definition.connection.flow[end] { stream.signed() } else { 0.0 };
        if self.definition.moves[end] {
            node.displacement = [x, y, if self.definition.planar { 0.0 } else { z }];
            node.flow = 0.2 * self.length * flow;
        }
    }

    /// Uniform on the rotations that there are.
    fn rotation(&self, stream: &mut Stream) -> Quaternion<f64> {
        if self.definition.planar {
            let [x, y] = stream.circle();
            return [x, 0.0, 0.0, y];
        }
        stream.rotation()
    }

    /// By 2⁻⁴⁰ to 1 rad about any axis, or about the normal of the plane.
    ///
    /// The angle is 2 atan t with t = h/2 (1 + h²/12), which is h to within 1 %: from 2⁻ⁿ to 2¹⁻ⁿ for any n of 1 to 40.
    fn little(&self, stream: &mut Stream) -> Quaternion<f64> {
        let power = f64::from_bits((1023 - 1 - stream.below(40)) << 52);
        let h = power * (1.5 + 0.5 * stream.signed());
        let axis = if self.definition.planar {
            [0.0, 0.0, 1.0_f64.copysign(stream.signed())]
        } else {
            stream.direction()
        };
        let [x, y, z] = scale(axis, 0.5 * h * (1.0 + h * h / 12.0));
        let norm = norm([1.0, x, y, z]);
        [1.0 / norm, x / norm, y / norm, z / norm]
    }

    /// As a case of the audit, which judges its end.
    pub fn case(&self, name: &str, index: u64, drawn: &Drawn) -> Case {
        let step = Step { state: drawn.state(), increment: drawn.increment };
        Case {
            name: format!("{name}, state {index}"),
            definition: self.definition.clone(),
            start: None,
            length: self.length.max(norm(drawn.pair.separation())),
            path: vec![step],
        }
    }
}
