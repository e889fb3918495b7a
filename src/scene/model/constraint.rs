//! The constraints of a scene beside connectors and `*MPC`: equations, rigid bodies, couplings, ties.

use crate::choice::choices;
use crate::label::Label;
use crate::model::Target;
use crate::span::{Span, Spanned};
use serde::Serialize;

/// A term of an equation: A times a degree of freedom of a node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EquationTerm {
    /// The node.
    pub node: Label,
    /// The degree of freedom, 1 to 6 or 10, along the axes of the node's `*TRANSFORM`.
    pub degree_of_freedom: u8,
    /// A.
    pub factor: f64,
}

/// `*EQUATION`: the terms add up to zero.
#[derive(Debug, Clone, Serialize)]
pub struct Equation {
    /// The terms.
    pub terms: Vec<EquationTerm>,
    /// The data line that begins it.
    #[serde(skip)]
    pub span: Span,
}

/// `*SURFACE, TYPE=NODE`: nodes with their areas.
#[derive(Debug, Clone, Serialize)]
pub struct Surface {
    /// Nodes and node sets, with the area, or weight, of each node.
    pub members: Vec<(Spanned<Target>, Option<f64>)>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// `*RIGID BODY`.
#[derive(Debug, Clone, Serialize)]
pub struct RigidBody {
    /// The reference node.
    pub reference: Label,
    /// Elements whose nodes belong to it: with their rotations, where they have some.
    pub element_set: Option<Spanned<String>>,
    /// Nodes of those of the elements that are of types which are not read, as far as anything else is about them.
    #[serde(skip)]
    pub others: Vec<Label>,
    /// Nodes that belong to it without their rotations.
    pub pin_set: Option<Spanned<String>>,
    /// Nodes that belong to it with their rotations.
    pub tie_set: Option<Spanned<String>>,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

choices! {
    /// How the weights of a distributing coupling fall off with the distance r from the reference node; r₀ is that of the farthest node.
    pub enum Weighting {
        /// They do not.
        Uniform = "UNIFORM",
        /// 1 − r/r₀.
        Linear = "LINEAR",
        /// 1 − (r/r₀)².
        Quadratic = "QUADRATIC",
        /// 1 − 3 (r/r₀)² + 2 (r/r₀)³.
        Cubic = "CUBIC",
    }
}

/// What a coupling does to its nodes.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CouplingKind {
    /// `*KINEMATIC`: the reference node carries them in these degrees of freedom, 1 to 6.
    Kinematic(Vec<u8>),
    /// `*DISTRIBUTING`: the reference node moves with their mean.
    Distributing(Weighting),
}

/// `*COUPLING`.
#[derive(Debug, Clone, Serialize)]
pub struct Coupling {
    /// Its name.
    pub name: Spanned<String>,
    /// The reference node.
    pub reference: Label,
    /// The surface whose nodes it couples.
    pub surface: Spanned<String>,
    /// The axes of its degrees of freedom; the global ones when there is none.
    pub orientation: Option<Spanned<String>>,
    /// Nodes that are farther from the reference node are left out.
    pub influence_radius: Option<f64>,
    /// What it does.
    pub kind: CouplingKind,
    /// The keyword.
    #[serde(skip)]
    pub span: Span,
}

/// `*TIE` between nodes.
#[derive(Debug, Clone, Serialize)]
pub struct Tie {
    /// Its name.
    pub name: Spanned<String>,
    /// The surface whose nodes are dependent.
    pub slave: Spanned<String>,
    /// The surface to whose nodes they are tied.
    pub master: Spanned<String>,
    /// Nodes that are farther apart are not tied.
    pub position_tolerance: Option<f64>,
    /// Whether rotations stay free.
    pub no_rotation: bool,
    /// The data line.
    #[serde(skip)]
    pub span: Span,
}

impl Weighting {
    /// The factor of the weight at r/r₀.
    #[must_use]
    pub fn at(self, ratio: f64) -> f64 {
        match self {
            Self::Uniform => 1.0,
            Self::Linear => 1.0 - ratio,
            Self::Quadratic => 1.0 - ratio * ratio,
            Self::Cubic => 1.0 - ratio * ratio * (3.0 - 2.0 * ratio),
        }
    }
}
