//! Four states, as arrays of four.

use crate::connector::{Branch, Connector};
use crate::measure;
use crate::node::{Node, Pair};
use crate::scalar::lanes::{LANES, Lanes};
use crate::vector::{Matrix, Vector, product};
use pulp::{Arch, Simd, WithSimd};

/// A number of each of four elements.
pub type Four = [f64; LANES];

/// The nodes of four elements.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Tile {
    /// X_b − X_a (length).
    pub reference: [Four; 3],
    /// U of a and of b (length).
    pub displacement: [[Four; 3]; 2],
    /// The local directions of a and of b as columns.
    pub triad: [[[Four; 3]; 3]; 2],
}

/// Where four pairs of nodes are, as what happened to them since the initial state.
#[derive(Clone, Copy, Debug)]
pub struct Poses<'a> {
    /// U of a and of b (length).
    pub displacement: [[&'a Vector<f64>; LANES]; 2],
    /// How they are turned.
    pub rotation: [[&'a Matrix<f64>; LANES]; 2],
}

/// The initial triads of four pairs of nodes, a local direction a column.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Triads([[[Four; 3]; 3]; 2]);

/// The data of four connectors that measures refer to; see [`measure::Section`].
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Section {
    /// Q₀.
    pub initial_orientation: [[Four; 3]; 3],
    /// The direction that stands in for d/|d| while the nodes of an AXIAL coincide.
    pub fixed_direction: [Four; 3],
}

/// What the past of four connectors decides; see [`measure::History`].
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct History {
    /// The last well-conditioned rotation vector (rad).
    pub rotation_vector: [Four; 3],
    /// The sign of sin β on the sheet of the Euler angles.
    pub euler_sign: Four,
    /// The whole turns of torsion.
    pub torsion_turns: Four,
}

/// `of` each of four, lane by lane.
pub(super) fn four<T>(from: &[T; LANES], of: impl Fn(&T) -> f64) -> Four {
    let [a, b, c, d] = from;
    [of(a), of(b), of(c), of(d)]
}

pub(super) fn vector<T>(from: &[T; LANES], of: impl Fn(&T) -> Vector<f64>) -> [Four; 3] {
    [0, 1, 2].map(|i| four(from, |one| of(one)[i]))
}

pub(super) fn matrix<T>(from: &[T; LANES], of: impl Fn(&T) -> Matrix<f64>) -> [[Four; 3]; 3] {
    [0, 1, 2].map(|i| vector(from, |one| of(one)[i]))
}

impl Tile {
    /// Four pairs of nodes.
    pub fn new(pairs: &[Pair<f64>; LANES]) -> Self {
        Self {
            reference: vector(pairs, |pair| pair.reference),
            displacement: [
                vector(pairs, |pair| pair.a.displacement),
                vector(pairs, |pair| pair.b.displacement),
            ],
            triad: [matrix(pairs, |pair| pair.a.triad), matrix(pairs, |pair| pair.b.triad)],
        }
    }

    /// X_b − X_a of four.
    pub fn references(of: &[Vector<f64>; LANES]) -> [Four; 3] {
        vector(of, |one| *one)
    }

    /// Four pairs of nodes where they were at first, each with X_b − X_a.
    pub const fn initial(reference: [Four; 3], triads: &Triads) -> Self {
        Self { reference, displacement: [[[0.0; LANES]; 3]; 2], triad: triads.0 }
    }

    /// Moves nodes from their initial triads: T = R T₀. Nothing else is changed.
    pub fn place(&mut self, initial: &Triads, poses: &Poses<'_>) {
        Arch::new().dispatch(Place { poses, initial, tile: self });
    }

    /// x_b − x_a of a lane.
    pub fn apart(&self, lane: usize) -> Vector<f64> {
        let [a, b] = &self.displacement;
        let of = |x: &Four| x.get(lane).copied().unwrap_or(f64::NAN);
        [0, 1, 2].map(|i| of(&self.reference[i]) + (of(&b[i]) - of(&a[i])))
    }

    /// The nodes of a lane.
    pub fn lane(&self, lane: usize) -> Pair<f64> {
        let number = |of: &Four| of.get(lane).copied().unwrap_or(f64::NAN);
        let vector = |of: &[Four; 3]| -> Vector<f64> { of.each_ref().map(number) };
        let node = |end: usize| Node {
            displacement: vector(&self.displacement[end]),
            triad: self.triad[end].each_ref().map(vector),
            flow: 0.0,
        };
        Pair { reference: vector(&self.reference), a: node(0), b: node(1) }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn pair<const FUSED: bool>(&self) -> Pair<Lanes<FUSED>> {
        let node = |end: usize| Node {
            displacement: lanes(&self.displacement[end]),
            triad: lanes_matrix(&self.triad[end]),
            flow: Lanes::splat(0.0),
        };
        Pair { reference: lanes(&self.reference), a: node(0), b: node(1) }
    }
}

impl Triads {
    /// Those of four connectors.
    pub fn new(of: &[[&Matrix<f64>; 2]; LANES]) -> Self {
        Self([0, 1].map(|end| matrix(of, |one| *one[end])))
    }
}

/// The nodes of four, on the vector unit that there is.
struct Place<'l> {
    poses: &'l Poses<'l>,
    initial: &'l Triads,
    tile: &'l mut Tile,
}

impl WithSimd for Place<'_> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_simd<V: Simd>(self, _: V) {
        let Self { poses, initial, tile } = self;
        for end in 0..2 {
            let (displacement, rotation) = (&poses.displacement[end], &poses.rotation[end]);
            let mut turn = [[Lanes::<false>::splat(0.0); 3]; 3];
            for i in 0..3 {
                for lane in 0..LANES {
                    tile.displacement[end][i][lane] = displacement[lane][i];
                    for j in 0..3 {
                        turn[i][j].0[lane] = rotation[lane][i][j];
                    }
                }
            }
            let triad = product(&turn, &lanes_matrix(&initial.0[end]));
            for i in 0..3 {
                for j in 0..3 {
                    triad[i][j].store(&mut tile.triad[end][i][j]);
                }
            }
        }
    }
}

impl Section {
    /// Those of four connectors.
    pub fn new(connectors: &[&Connector<f64>; LANES]) -> Self {
        Self {
            initial_orientation: matrix(connectors, |one| one.section().initial_orientation),
            fixed_direction: vector(connectors, |one| one.section().fixed_direction),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn load<const FUSED: bool>(&self) -> measure::Section<Lanes<FUSED>> {
        measure::Section {
            initial_orientation: lanes_matrix(&self.initial_orientation),
            initial_length: Lanes::splat(0.0),
            fixed_direction: lanes(&self.fixed_direction),
            flow_scale: Lanes::splat(0.0),
        }
    }
}

impl History {
    /// Those that four branches tell: the branch at the state itself ([`Connector::advance`]).
    pub fn new(branches: &[Branch<f64>; LANES]) -> Self {
        Self {
            rotation_vector: vector(branches, |one| one.rotation_vector),
            euler_sign: four(branches, |one| one.euler_sign),
            torsion_turns: four(branches, |one| one.torsion.turns),
        }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn load<const FUSED: bool>(&self) -> measure::History<Lanes<FUSED>> {
        measure::History {
            rotation_vector: lanes(&self.rotation_vector),
            euler_sign: Lanes(self.euler_sign),
            torsion_turns: Lanes(self.torsion_turns),
        }
    }
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn lanes<const FUSED: bool>(of: &[Four; 3]) -> Vector<Lanes<FUSED>> {
    [Lanes(of[0]), Lanes(of[1]), Lanes(of[2])]
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn lanes_matrix<const FUSED: bool>(of: &[[Four; 3]; 3]) -> Matrix<Lanes<FUSED>> {
    [lanes(&of[0]), lanes(&of[1]), lanes(&of[2])]
}
