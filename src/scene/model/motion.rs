//! What a state gives: motions of nodes, and forces of connectors and constraints.

use crate::label::Label;
use crate::span::Span;
use pintle_kinematics::so3;
use pintle_kinematics::vector::Matrix;
use serde::Serialize;
use std::collections::BTreeMap;

/// The total rotation of a node from its initial orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rotation {
    /// Rotation vector, radians: R = exp(θ^). Its length may exceed π and counts turns.
    Vector([f64; 3]),
    /// Quaternion q0, q1, q2, q3 (scalar first), of norm 1 within 1e-6. Turns are not in it.
    Quaternion([f64; 4]),
}

impl Rotation {
    /// R, by which the axes of a node have turned.
    #[must_use]
    pub fn matrix(&self) -> Matrix<f64> {
        match *self {
            Self::Vector(vector) => so3::exp(vector),
            Self::Quaternion(quaternion) => so3::matrix(so3::normalize(quaternion)),
        }
    }

    /// Whether it is one at all.
    #[must_use]
    pub fn turns(&self) -> bool {
        match self {
            Self::Vector(vector) => *vector != [0.0; 3],
            Self::Quaternion([_, x, y, z]) => [*x, *y, *z] != [0.0; 3],
        }
    }
}

impl Default for Rotation {
    fn default() -> Self {
        Self::Vector([0.0; 3])
    }
}

/// What a node does. Everything is 0 unless given; components are global.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct NodeMotion {
    /// From the initial position.
    pub displacement: [f64; 3],
    /// From the initial orientation.
    pub rotation: Rotation,
    /// Time derivative of the displacement.
    pub velocity: [f64; 3],
    /// Spatial angular velocity ω, with Ṙ = ω^ R.
    pub angular_velocity: [f64; 3],
    /// Time derivative of the velocity.
    pub acceleration: [f64; 3],
    /// Spatial angular acceleration ω̇.
    pub angular_acceleration: [f64; 3],
    /// Material flow Ψ (degree of freedom 10), a length.
    pub flow: f64,
    /// Time derivative of the flow.
    pub flow_velocity: f64,
    /// Second time derivative of the flow.
    pub flow_acceleration: f64,
}

/// The motions of all nodes that move, at one time.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct State {
    /// Its number, if the file numbers its states: the column `state`, or `number` in JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<u64>,
    /// The time, if it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// Motions by node number. A node that is not in it is at rest in its initial place.
    pub nodes: BTreeMap<Label, NodeMotion>,
    /// Component forces by element number, where they are given.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub forces: BTreeMap<Label, ElementForces>,
    /// The forces and moments that multi-point constraints put on their first nodes, by their nodes (`10-20-30`), where they are
    /// given: residual-side, global components.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub mpc_forces: BTreeMap<String, ElementForces>,
}

/// What a positive force means.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ForceSign {
    /// Every force resists growth of its component when it is positive: the total adds up as CEF + CVF + CSF + CRF − CCF.
    #[default]
    Internal,
    /// The forces of constrained components are those applied at node b to enforce the constraint: minus the internal ones.
    ConstraintsOnB,
}

/// The forces of one connector at one state, as given.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ElementForces {
    /// f1 … m3, CTF and CTM.
    pub total: [Option<f64>; 6],
    /// CRF and CRM.
    pub reaction: [Option<f64>; 6],
    /// What a positive force of a constraint means.
    pub sign: ForceSign,
    /// Where they stand in their file.
    pub span: Span,
}

/// The forces of one state.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct StateForces {
    /// Those of connectors, by element number.
    pub elements: BTreeMap<Label, ElementForces>,
    /// Those of multi-point constraints, by their nodes (`10-20-30`).
    pub mpcs: BTreeMap<String, ElementForces>,
}

impl State {
    /// Whether it has rates of a node: velocities or accelerations other than zero.
    pub fn has_rates(&self) -> bool {
        let still = [0.0; 3];
        self.nodes.values().any(|node| {
            [node.velocity, node.angular_velocity, node.acceleration, node.angular_acceleration]
                .iter()
                .any(|rate| *rate != still)
                || node.flow_velocity != 0.0
                || node.flow_acceleration != 0.0
        })
    }
}
