//! Proptest strategies for suites of your own (feature `proptest`): states, near-singular states and histories of a connector,
//! made of plain numbers, so that proptest shrinks a failure to a small motion.
//!
//! ```
//! use pintle_audit::sampling::strategies;
//! use pintle_kinematics::catalog::ConnectionType;
//! use pintle_kinematics::connector::Definition;
//! use pintle_kinematics::node::{Node, Pair};
//! use pintle_kinematics::vector::identity;
//! use proptest::prelude::*;
//!
//! let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
//! let hinge = Definition::new(ConnectionType::named("HINGE", None)?, Pair { reference: [0.0; 3], a: node, b: node });
//! proptest!(|(case in strategies::state(&hinge))| {
//!     let end = case.last().expect("a path has an end");
//!     prop_assert!(end.state.pair.separation().iter().all(|x| x.is_finite()));
//! });
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::case::Case;
use crate::sampling::Motion;
use crate::singular::atlas;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::Definition;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::Vector;
use proptest::array::{uniform3, uniform14};
use proptest::prelude::*;
use std::f64::consts::PI;

/// A vector with components in ±size.
fn vector(size: f64) -> impl Strategy<Value = Vector<f64>> {
    uniform3(-size..=size)
}

/// Both nodes turned by up to `most` rad about any axis, b besides against a, and moved by up to half the length.
pub fn motion(length: f64, most: f64, steps: usize) -> impl Strategy<Value = Motion> + use<> {
    let reach = most / 3.0_f64.sqrt();
    let flow = -0.2 * length..=0.2 * length;
    let parts =
        (vector(reach), vector(reach), vector(0.5 * length), vector(0.5 * length), flow.clone(), flow);
    parts.prop_map(move |(common, spin, a, b, flow_a, flow_b)| Motion {
        common,
        spin,
        displacement: [a, b],
        flow: [flow_a, flow_b],
        steps,
    })
}

fn length_of(definition: &Definition) -> f64 {
    let length = norm(definition.initial.reference);
    if length > 0.0 { length } else { 1.0 }
}

fn case<M: Strategy<Value = Motion>>(
    definition: &Definition,
    motion: M,
    what: &'static str,
) -> impl Strategy<Value = Case> + use<M> {
    let length = length_of(definition);
    let definition = definition.clone();
    let rates = uniform14(-1.0..=1.0_f64);
    (motion, rates.clone(), rates).prop_map(move |(motion, velocity, acceleration)| {
        let mut path = motion.path(&definition.initial);
        if let Some(end) = path.last_mut() {
            let sized = |rates: [f64; DOFS]| {
                std::array::from_fn(|j| rates[j] * pintle_kinematics::node::dof_size(j, length))
            };
            end.state.velocity = sized(velocity);
            end.state.acceleration = sized(acceleration);
        }
        let name = format!("{} {what}", definition.connection.name);
        Case { name, definition: definition.clone(), start: None, path, length }
    })
}

/// One state of a connector, reached in one increment of less than half a turn, with rates.
pub fn state(definition: &Definition) -> impl Strategy<Value = Case> + use<> {
    case(definition, motion(length_of(definition), 1.5, 1), "state")
}

/// A history of `steps` states in which the nodes turn by up to `turns` whole turns, so slowly that they can be counted.
pub fn history(definition: &Definition, turns: u32) -> impl Strategy<Value = Case> + use<> {
    let angle = 2.0 * PI * f64::from(turns.max(1));
    let steps = (2.0 * angle / 0.35).ceil() as usize;
    case(definition, motion(length_of(definition), angle, steps), "history")
}

/// A state 1e-1 to 1e-12 from a singular set of the type, on either side and from any direction; nothing else for a type that
/// has none.
pub fn near_singular(connection: &ConnectionType) -> impl Strategy<Value = Option<Case>> + use<> {
    let measures: Vec<Measure> = connection.singular_measures().collect();
    let connection = connection.clone();
    let which = 0..measures.len().max(1);
    (which, 1.0..12.0_f64, -PI..PI, any::<bool>(), any::<u16>()).prop_map(
        move |(which, exponent, azimuth, beyond, seed)| {
            let measure = *measures.get(which)?;
            let sign = if beyond && measure != Measure::Strain { -1.0 } else { 1.0 };
            let draw = &mut Draw::new(&format!("{seed}"));
            atlas::near(&connection, measure, sign * 10.0_f64.powf(-exponent), azimuth, draw)
        },
    )
}
