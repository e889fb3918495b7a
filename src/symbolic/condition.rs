//! Where an expression holds: branches that it takes, and domains of its functions.

use crate::graph::{Graph, Id, Node};

/// A condition that an expression met while it was traced.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Condition {
    /// x < y decides between two formulas.
    Branch(Id, Id),
    /// x ≠ 0: otherwise 1/x stands for 0, or x is a norm without a derivative.
    NotZero(Id),
    /// Not both are zero: an angle of the point (x, y), y first.
    NotBothZero(Id, Id),
    /// x ≥ 0: a root.
    NotNegative(Id),
    /// x > −1: the logarithm of a rotation.
    AboveMinusOne(Id),
}

impl Condition {
    /// What it is about.
    pub fn operands(self) -> Vec<Id> {
        match self {
            Self::Branch(x, y) | Self::NotBothZero(x, y) => vec![x, y],
            Self::NotZero(x) | Self::NotNegative(x) | Self::AboveMinusOne(x) => vec![x],
        }
    }
}

impl Graph {
    /// The branch conditions and domains of everything that `roots` are formed from, each once.
    ///
    /// ```
    /// use pintle_kinematics::catalog::ConnectionType;
    /// use pintle_symbolic::{Condition, Frame, Model};
    /// let axial = Model::of(&ConnectionType::named("AXIAL", None)?, Frame::Relative, 0)?;
    /// let conditions = axial.graph.conditions(&axial.values);
    /// // |d|, or while that is zero the coordinate along a direction fixed in space.
    /// assert!(conditions.iter().any(|condition| matches!(condition, Condition::Branch(..))));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn conditions(&self, roots: &[Id]) -> Vec<Condition> {
        let mut found = Vec::new();
        for id in self.reachable(roots) {
            let condition = match *self.node(id) {
                Node::Select { less, than, .. } => Condition::Branch(less, than),
                Node::Reciprocal(x) | Node::Divide(_, x) => Condition::NotZero(x),
                Node::Norm(_) | Node::Magnitude(_) => Condition::NotZero(id),
                Node::Arctangent(y, x) => Condition::NotBothZero(y, x),
                Node::SquareRoot(x) => Condition::NotNegative(x),
                Node::Logarithm(_, x) if !self.is_not_negative(x) => Condition::AboveMinusOne(x),
                _ => continue,
            };
            let is_constant =
                condition.operands().iter().all(|id| matches!(self.node(*id), Node::Constant(_) | Node::Pi));
            if !is_constant && !found.contains(&condition) {
                found.push(condition);
            }
        }
        found
    }
}
