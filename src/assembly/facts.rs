//! What is found of an assembly, as it is told: facts, and no words on how bad they are.

use pintle_model::evaluate::Freedom;
use pintle_scene::{Label, Span};
use serde::{Serialize, Serializer};
use std::fmt::{self, Display};

/// Why an equation holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// A connection type or a multi-point constraint enforces it.
    Enforced,
    /// A connector motion of zero holds an available component.
    Held,
    /// A connector motion, or a boundary condition that is not zero, drives it.
    Driven,
}

/// Where a redundancy holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Holds {
    /// At every state that was looked at: judged to hold wherever the connected component can move.
    Throughout,
    /// The same, each of them a singular position: motions that are free to first order because of it are excluded to second order.
    Singular,
    /// The connected component cannot move at all: there is no other state.
    Rigid,
    /// At this state, and not at another admissible one: proven, to rounding.
    Here,
    /// At this state, and not at another one given, to the digits of these states.
    Differs,
    /// At a singular position: motions that are free to first order because of it are excluded to second order.
    Isolated,
    /// It was not judged: the connected component is too large to be moved.
    Large,
    /// It was not judged, or not to the end, for what may be spent on it was ([`Spent`]).
    Spent,
    /// It could not be judged.
    Unjudged,
}

impl Holds {
    /// Whether it holds wherever the connected component can be.
    pub const fn is_throughout(self) -> bool {
        matches!(self, Self::Throughout | Self::Singular | Self::Rigid)
    }
}

/// An equation, by what it belongs to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Constraint {
    /// The connector element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<Label>,
    /// The multi-point constraint or relation, by kind and nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mpc: Option<String>,
    /// Its place among the constraints of the model that are evaluated; relations come after multi-point constraints.
    #[serde(skip)]
    pub index: Option<usize>,
    /// Where a relation was read, and its nodes.
    #[serde(skip)]
    pub joined: Option<(Span, Vec<Label>)>,
    /// The node of a boundary condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<Label>,
    /// The component, equation or degree of freedom.
    pub component: String,
    /// Why it holds.
    pub role: Role,
}

impl Display for Constraint {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let component = &self.component;
        match (&self.element, &self.mpc, &self.node) {
            (Some(element), ..) => write!(formatter, "{component} of element {element}"),
            (_, Some(mpc), _) => write!(formatter, "{component} of {mpc}"),
            (_, _, Some(node)) => write!(formatter, "degree of freedom {component} of node {node}"),
            _ => formatter.write_str(component),
        }
    }
}

/// A constraint that follows from others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Redundant {
    /// The constraint.
    pub constraint: Constraint,
    /// Where it does.
    pub holds: Holds,
    /// Whether the rank of its connected component is certain. Where it is not, the constraint is redundant if what was taken for zero is zero.
    pub decided: bool,
    /// Whether boundary conditions hold all that it would: then it follows from them alone.
    pub held: bool,
    /// The others that it follows from, where the connected component is small enough to say it; empty where all its nodes are held.
    pub from: Vec<Constraint>,
}

/// A motion that is left.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// The degree of freedom that stands for it.
    pub leading: Freedom,
    /// The nodes that move, those that move most first, and at most twenty; only that of `leading` where the connected component is too large.
    pub nodes: Vec<Label>,
    /// The number of nodes that move; `None` where the connected component is too large to say it.
    pub moving: Option<usize>,
    /// Whether the rank of its connected component is certain. Where it is not, this is a motion if what was taken for zero is zero.
    pub decided: bool,
}

/// What lies between zero and not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// The largest relative change of the matrix that makes a number zero which counts as zero.
    #[serde(serialize_with = "finite")]
    pub zero: f64,
    /// The smallest one of those that do not; infinite where there is none.
    #[serde(serialize_with = "finite")]
    pub nonzero: f64,
    /// For a connected component small enough, and of all connected components the worst: the smallest singular value that is not zero, and the largest that is, over the
    /// largest.
    pub singular_values: Option<[f64; 2]>,
}

fn is_zero(number: &usize) -> bool {
    *number == 0
}

fn finite<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    number.is_finite().then_some(number).serialize(serializer)
}

/// The assembly at one state. Numbers are `None` where a connected component was not looked at ([`Skipped`]).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Position {
    /// The number of the state; none for the initial one.
    pub state: Option<u64>,
    /// The rank of the constraints.
    pub rank: Option<usize>,
    /// The independent motions that constraints leave.
    pub mobility: Option<usize>,
    /// Those that nothing drives either.
    pub undriven: Option<usize>,
    /// Those of them that belong to connected components whose rank is not certain: as many if what was taken for zero is zero.
    pub undriven_undecided: usize,
    /// The number of redundant constraints.
    pub redundant: Option<usize>,
    /// The number of drives that act on what is determined already.
    pub overdriven: Option<usize>,
    /// Whether all ranks are known and certain.
    pub decided: bool,
    /// Whether all numbers were finite; where not, no rank is certain.
    pub finite: bool,
    /// How certain they are.
    pub gap: Gap,
    /// The constraints whose independence, or dependence, is not certain; at most a hundred.
    pub doubtful: Vec<Constraint>,
    /// The constraints that have no derivative at this state, or one without digits: they may hold, and do not show in the Jacobian. Not called redundant; at
    /// most a hundred.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without_derivative: Vec<Constraint>,
    /// Whether, of a given state, the rank or the number of motions of a connected component is another than initially. What is redundant and
    /// what moves is named then, up to a thousand in all.
    pub differs: bool,
    /// Redundant constraints at a given state that differs; at the initial one, [`Assembly::redundant`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dependent: Vec<Redundant>,
    /// Motions that nothing drives, at a given state that differs; at the initial one, [`Assembly::modes`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<Mode>,
}

/// The whole assembly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assembly {
    /// The step whose boundary conditions and connector motions hold, counted from 1; 0 is before the first.
    pub step: usize,
    /// The degrees of freedom of all nodes of connectors and MPCs.
    pub degrees_of_freedom: usize,
    /// Those of them that boundary conditions hold.
    pub held: usize,
    /// The number of constraints, without boundary conditions.
    pub constraints: usize,
    /// The number of driven components and degrees of freedom.
    pub drives: usize,
    /// Degrees of freedom that nothing holds, less constraints.
    pub gruebler: i64,
    /// The number of connected components that have no degree of freedom in common.
    #[serde(rename = "parts")]
    pub connected_components: usize,
    /// The largest front, in columns: what the elimination cost.
    pub largest_front: usize,
    /// Connected components that were not looked at, for their elimination would take more than [`OPERATIONS`], or 1.3 GB.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub skipped: Vec<Skipped>,
    /// The initial state, then those given that were looked at.
    pub positions: Vec<Position>,
    /// Redundant constraints at the initial state.
    pub redundant: Vec<Redundant>,
    /// How many of them are counted, and not named: rows without which the rank is the same were not found.
    #[serde(skip_serializing_if = "is_zero")]
    pub unnamed: usize,
    /// Drives that act, initially, on what is determined already.
    pub overdriven: Vec<Constraint>,
    /// The other drives of the same connected components, in which one of either is too many.
    #[serde(skip)]
    pub driven_besides: Vec<Constraint>,
    /// Motions that nothing drives, at the initial state: at most a thousand.
    pub modes: Vec<Mode>,
    /// Given states that were not looked at, because they do not satisfy the constraints.
    pub off: Vec<u64>,
    /// Given states that were not looked at, because they move what boundary conditions hold.
    pub off_boundary: Vec<u64>,
    /// Constraints that are redundant at a given state and not at the state of the largest rank, which may be the initial one. Each
    /// has the number of the state, and whether that is proven ([`Holds::Here`]) or so to the digits of the states
    /// ([`Holds::Differs`]).
    pub redundant_at: Vec<(u64, Constraint, Holds)>,
    /// What was spent to judge where redundancies hold, where that was not enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spent: Option<Spent>,
    /// Constraints of the deck that are not read: where there are any, what is certain is so of what was read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unread: Vec<Unread>,
    /// The state from which on nothing was looked at, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_assembled: Option<NotAssembled>,
}

/// The operations that are spent on the elimination of a connected component: each takes some 8 ns. What takes more is undecided.
pub const OPERATIONS: usize = 1_000_000_000;

/// A connected component that was not looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// The number of its connectors.
    pub connectors: usize,
    /// The number of its multi-point constraints.
    pub mpcs: usize,
    /// Of equations, rigid bodies, couplings and ties.
    pub relations: usize,
    /// Its degrees of freedom that nothing holds.
    pub degrees_of_freedom: usize,
    /// The number of its constraints and drives.
    pub constraints: usize,
    /// Its first node.
    pub node: Label,
}

/// What was spent to judge where redundancies hold: operations, each some 10 ns of processor, and not time, so that the same is judged everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Spent {
    /// The operations.
    pub operations: u64,
    /// How many may be.
    pub most: u64,
}

/// A state at which the Jacobian of the constraints could not be assembled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotAssembled {
    /// The number of the state; none for the initial one.
    pub state: Option<u64>,
    /// Why not.
    pub why: String,
}

/// Constraints of one kind that are not read, and not in the rank. Where there are any, the nodes of connectors may move in fewer ways than is
/// said, and more constraints may be redundant.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Unread {
    /// The keyword, with its asterisk, or the kind of multi-point constraint: `*EQUATION`, `MPC SLIDER`.
    pub what: String,
    /// How many there are.
    pub count: usize,
    /// Where they are; at most a thousand.
    pub places: Vec<Line>,
}

/// A line of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Line {
    /// The file.
    pub file: String,
    /// The line.
    pub line: u32,
}

impl Assembly {
    /// Whether the assembly was looked at as a whole and at all states given, and all ranks are certain.
    pub fn is_decided(&self) -> bool {
        self.not_assembled.is_none()
            && self.off.is_empty()
            && self.off_boundary.is_empty()
            && !self.positions.is_empty()
            && self.positions.iter().all(|position| position.decided)
    }

    /// Nothing that was looked at yet, in a step.
    pub(crate) const fn none(step: usize) -> Self {
        Self {
            step,
            degrees_of_freedom: 0,
            held: 0,
            constraints: 0,
            drives: 0,
            gruebler: 0,
            connected_components: 0,
            largest_front: 0,
            skipped: Vec::new(),
            positions: Vec::new(),
            redundant: Vec::new(),
            unnamed: 0,
            overdriven: Vec::new(),
            driven_besides: Vec::new(),
            modes: Vec::new(),
            off: Vec::new(),
            off_boundary: Vec::new(),
            redundant_at: Vec::new(),
            spent: None,
            unread: Vec::new(),
            not_assembled: None,
        }
    }
}

/// What is listed.
pub(crate) const LISTED: usize = 1000;
