//! What expressions are formed from: named groups of inputs, with shapes and units.

use crate::graph::Graph;
use crate::symbol::Symbol;
use pintle_kinematics::vector::{Matrix, Vector};

pintle_kinematics::named! {
    /// The unit of an input.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum InputUnit {
        /// A length.
        Length = "length",
        /// Radians.
        Angle = "rad",
        /// A pure number.
        None = "-",
        /// Radians per length.
        AnglePerLength = "rad/length",
        /// A force for f1 … f3, a moment for m1 … m3.
        ForceOrMoment = "force, moment",
        /// A force.
        Force = "force",
        /// As the parameter of the friction says.
        OfParameter = "as the data line of the friction",
    }
}

/// The shape of an input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One number.
    Scalar,
    /// A list of n numbers.
    List(usize),
    /// 3 × 3, by rows.
    Matrix,
}

impl Shape {
    /// How many numbers.
    pub const fn len(self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::List(n) => n,
            Self::Matrix => 9,
        }
    }

    /// Whether there is no number.
    pub const fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// In words.
    pub fn name(self) -> String {
        match self {
            Self::Scalar => "number".into(),
            Self::List(n) => format!("[{n}]"),
            Self::Matrix => "[3][3]".into(),
        }
    }
}

/// A named group of inputs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// The name in programs.
    pub name: String,
    /// The sources' symbol.
    pub symbol: String,
    /// The shape.
    pub shape: Shape,
    /// The unit.
    pub unit: InputUnit,
    /// What it is.
    pub meaning: String,
    /// The number of its first entry in the graph.
    pub first: u32,
}

/// Groups of inputs, numbered one after the other.
#[derive(Clone, Debug, Default)]
pub struct Inputs(Vec<Input>);

impl Inputs {
    /// Adds a group and gives its place.
    pub fn add(&mut self, [name, symbol, meaning]: [&str; 3], shape: Shape, unit: InputUnit) -> usize {
        let first = self.0.last().map_or(0, |last| last.first + last.shape.len() as u32);
        let [name, symbol, meaning] = [name, symbol, meaning].map(String::from);
        self.0.push(Input { name, symbol, shape, unit, meaning, first });
        self.0.len() - 1
    }

    /// Every group.
    pub fn iter(&self) -> impl Iterator<Item = &Input> {
        self.0.iter()
    }

    /// The numbers of the inputs in all.
    pub fn len(&self) -> usize {
        self.0.last().map_or(0, |last| last.first as usize + last.shape.len())
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The group of an input's number, and the place of the input in it.
    pub fn find(&self, number: u32) -> Option<(&Input, usize)> {
        let group = self.0.iter().rfind(|group| group.first <= number)?;
        let place = (number - group.first) as usize;
        (place < group.shape.len()).then_some((group, place))
    }

    /// The groups of which `graph` needs an input for `roots`.
    pub fn used<'a>(&'a self, graph: &Graph, roots: &[crate::Id]) -> Vec<&'a Input> {
        let mut is_used = vec![false; self.len()];
        for id in graph.reachable(roots) {
            if let crate::Node::Input(number) = graph.node(id)
                && let Some(used) = is_used.get_mut(*number as usize)
            {
                *used = true;
            }
        }
        let any = |input: &&Input| {
            let first = input.first as usize;
            is_used.iter().skip(first).take(input.shape.len()).any(|used| *used)
        };
        self.0.iter().filter(any).collect()
    }

    fn first(&self, group: usize) -> u32 {
        self.0.get(group).map_or(u32::MAX / 2, |input| input.first)
    }

    /// A number, within a trace.
    pub(super) fn scalar(&self, group: usize) -> Symbol {
        Symbol::input(self.first(group))
    }

    /// An entry of a list, within a trace.
    pub(super) fn entry(&self, group: usize, i: usize) -> Symbol {
        Symbol::input(self.first(group) + i as u32)
    }

    /// A vector, within a trace.
    pub(super) fn vector(&self, group: usize) -> Vector<Symbol> {
        [0, 1, 2].map(|i| self.entry(group, i))
    }

    /// A matrix, within a trace.
    pub(super) fn matrix(&self, group: usize) -> Matrix<Symbol> {
        [0, 3, 6].map(|row| [0, 1, 2].map(|i| self.entry(group, row + i)))
    }

    /// The numbers of a group's entries.
    pub(super) fn numbers(&self, group: usize) -> Vec<u32> {
        let count = self.0.get(group).map_or(0, |input| input.shape.len() as u32);
        (0..count).map(|i| self.first(group) + i).collect()
    }
}
