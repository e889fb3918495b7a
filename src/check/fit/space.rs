//! The conventions among which the fit looks: everything but the order of rows, their signs and units, which follow from the numbers.

use crate::convention::{Angle, Axes, COLUMNS, Frame, Variation};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::measure::Unit;
use pintle_kinematics::mpc::{DOFS, MpcType, PHI};

/// Where the degrees of freedom are that have no others beside them: flows, and the angles of hinges.
pub(super) const PLACES: [usize; 4] = [6, 13, PHI, PHI + 1];

/// Whether a degree of freedom is a rotation.
pub(super) const fn is_rotation(place: usize) -> bool {
    place >= PHI || matches!(place % 7, 3..=5)
}

/// What the rows and columns of a connector or constraint are called.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Names {
    pub(super) rows: [&'static str; 7],
    pub(super) columns: [&'static str; DOFS],
    /// The nodes, and their rotations.
    pub(super) nodes: [&'static str; 2],
    pub(super) rotations: [&'static str; 2],
    /// How many lines there are of values and rows in pintle's order.
    pub(super) height: usize,
    /// How many hinges.
    pub(super) hinges: usize,
}

impl Names {
    pub(super) fn of_connector() -> Self {
        let mut columns = [""; DOFS];
        columns[..PHI].copy_from_slice(&COLUMNS);
        let mut rows = [""; 7];
        rows[..6].copy_from_slice(&COMPONENT);
        let rotations = ["rotations of a", "rotations of b"];
        Self { rows, columns, nodes: ["a", "b"], rotations, height: 6, hinges: 0 }
    }

    pub(super) fn of_constraint(kind: MpcType) -> Self {
        let rotations = ["rotations of S", "rotations of M"];
        Self {
            rows: std::array::from_fn(|k| kind.row_name(k)),
            columns: columns_of(kind),
            nodes: ["S", "M"],
            rotations,
            height: 7,
            hinges: kind.entry().angles.len(),
        }
    }
}

/// The columns of a row of a constraint: those of S and M, then degree of freedom 6 of the nodes of hinges.
pub(crate) fn columns_of(kind: MpcType) -> [&'static str; DOFS] {
    const NODAL: [&str; PHI] = [
        "S.u1", "S.u2", "S.u3", "S.ur1", "S.ur2", "S.ur3", "S.flow", "M.u1", "M.u2", "M.u3", "M.ur1",
        "M.ur2", "M.ur3", "M.flow",
    ];
    let mut columns = [""; DOFS];
    columns[..PHI].copy_from_slice(&NODAL);
    let hinges: &[&str] = match kind.entry().angles.len() {
        0 => &[],
        1 => &["J.ur3"],
        _ => &["J1.ur3", "J2.ur3"],
    };
    columns[PHI..PHI + hinges.len()].copy_from_slice(hinges);
    columns
}

/// How a routine misreads the orientation that it got.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Reading {
    /// As it is meant.
    Right,
    /// The axes of triads as the columns of a matrix.
    Transposed,
    /// The scalar of quaternions last.
    ScalarLast,
    /// Rotations backwards.
    Inverse,
}

impl Reading {
    pub(super) const ALL: [Self; 4] = [Self::Right, Self::Transposed, Self::ScalarLast, Self::Inverse];
}

/// Units of length over another: the same, mm, cm, m and inches.
pub(super) const LENGTHS: [f64; 9] = [1.0, 1e-3, 1e3, 1e-2, 1e2, 0.0254, 1.0 / 0.0254, 25.4, 1.0 / 25.4];

/// The units of rows and columns: lengths and angles of each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    pub(super) row_length: f64,
    pub(super) row_angle: Angle,
    pub(super) column_length: f64,
    pub(super) column_angle: Angle,
}

impl Units {
    /// All of them.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        LENGTHS.into_iter().flat_map(|row_length| {
            LENGTHS.into_iter().flat_map(move |column_length| {
                Angle::ALL.into_iter().flat_map(move |row_angle| {
                    let of = move |column_angle| Self { row_length, row_angle, column_length, column_angle };
                    Angle::ALL.into_iter().map(of)
                })
            })
        })
    }

    /// What a value of pintle is multiplied with.
    pub(super) fn of_value(&self, unit: Unit) -> f64 {
        match unit {
            Unit::Length => 1.0 / self.row_length,
            Unit::Angle => 1.0 / self.row_angle.size(),
            Unit::None => 1.0,
        }
    }

    /// What an entry of a row is multiplied with, by a displacement (or flow) or a rotation.
    pub(super) fn of_entry(&self, row: Unit, is_rotation: bool) -> f64 {
        let column = if is_rotation { self.column_angle.size() } else { self.column_length };
        self.of_value(row) * column
    }

    /// How many of them are not pintle's.
    pub(super) fn cost(&self) -> f64 {
        let length = |x: f64| f64::from(u8::from(x != 1.0));
        let angle = |x: Angle| f64::from(u8::from(x != Angle::Radian));
        // One unit of length for all is simpler than two; lengths of both that differ are odd.
        let lengths = if self.row_length == self.column_length {
            length(self.row_length)
        } else {
            1.0 + length(self.row_length) + length(self.column_length)
        };
        let angles = angle(self.row_angle) + angle(self.column_angle);
        lengths + if self.row_angle == self.column_angle { angles / 2.0 } else { angles }
    }
}

/// An order of columns, by pintle's places of the degrees of freedom, and how unusual it is.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Order {
    pub(super) places: Vec<usize>,
    pub(super) cost: f64,
}

/// The permutations of three axes, the plain one first.
const AXES: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];

impl Order {
    /// Every declared order of so many columns. Nodes apart, kinds apart or degrees of freedom apart; displacements or rotations first; b
    /// before a; axes in any order. Flow with its node, last, or left out; one node alone. Angles of hinges last, first, or left out.
    pub(super) fn all(count: usize, hinges: usize) -> Vec<Self> {
        let mut found = Self::of_nodes(count);
        let last: Vec<usize> = (PHI..PHI + hinges).collect();
        for order in Self::of_nodes(count.saturating_sub(hinges)).into_iter().filter(|_| hinges > 0) {
            let places = [order.places.clone(), last.clone()].concat();
            found.push(Self { places, cost: order.cost });
            let places = [last.clone(), order.places].concat();
            found.push(Self { places, cost: order.cost + 1.0 });
        }
        found
    }

    /// Those of the two nodes.
    fn of_nodes(count: usize) -> Vec<Self> {
        let mut found: Vec<Self> = Vec::new();
        let mut add = |places: Vec<usize>, cost: f64| {
            if places.len() == count && !found.iter().any(|known| known.places == places) {
                found.push(Self { places, cost });
            }
        };
        let of = |node: usize, kind: usize, axis: usize| 7 * node + 3 * kind + axis;
        for (n, axes) in AXES.into_iter().enumerate() {
            let of_axes = if n == 0 { 0.0 } else { 2.0 };
            for (m, kinds) in [[0, 1], [1, 0]].into_iter().enumerate() {
                let of_kinds = m as f64;
                for (l, nodes) in [vec![0, 1], vec![1, 0], vec![1], vec![0]].into_iter().enumerate() {
                    let cost = of_axes + of_kinds + [0.0, 1.0, 2.0, 3.0][l];
                    let flows: Vec<usize> = nodes.iter().map(|node| 7 * node + 6).collect();
                    let dofs = |node: usize| {
                        kinds
                            .into_iter()
                            .flat_map(move |kind| axes.into_iter().map(move |x| of(node, kind, x)))
                    };
                    let apart: Vec<usize> = nodes.iter().flat_map(|node| dofs(*node)).collect();
                    let with_flow = nodes.iter().flat_map(|node| dofs(*node).chain([7 * node + 6]));
                    add(with_flow.collect(), cost);
                    let by_kind: Vec<usize> = kinds
                        .into_iter()
                        .flat_map(|kind| nodes.iter().flat_map(move |node| axes.map(|x| of(*node, kind, x))))
                        .collect();
                    let by_dof: Vec<usize> = kinds
                        .into_iter()
                        .flat_map(|kind| {
                            let nodes = &nodes;
                            axes.into_iter()
                                .flat_map(move |x| nodes.iter().map(move |node| of(*node, kind, x)))
                        })
                        .collect();
                    for (order, more) in [(apart, 0.0), (by_kind, 1.0), (by_dof, 2.0)] {
                        add(order.iter().chain(&flows).copied().collect(), cost + more + 0.5);
                        add(order, cost + more);
                    }
                }
            }
        }
        found
    }

    /// The names of the columns.
    pub(super) fn names(&self, names: &Names) -> Vec<String> {
        self.places.iter().map(|place| names.columns[place % DOFS].to_string()).collect()
    }
}

/// How unusual a variation is.
pub(super) const fn cost_of_variation(variation: Variation) -> f64 {
    match variation {
        Variation::Spatial => 0.0,
        Variation::Body | Variation::TotalVector => 1.0,
        _ => 2.0,
    }
}

/// How unusual axes of displacements are.
pub(super) const fn cost_of_frame(frame: Frame) -> f64 {
    match frame {
        Frame::Global => 0.0,
        Frame::A | Frame::Own => 1.0,
        Frame::B => 2.0,
    }
}

/// How unusual axes of vectors are.
pub(super) const fn cost_of_axes(axes: Axes) -> f64 {
    match axes {
        Axes::A => 0.0,
        Axes::Global => 1.0,
        Axes::B => 2.0,
    }
}
