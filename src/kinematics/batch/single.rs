//! Rows without a vector unit: one element after the other, on doubles.

use crate::batch::layout::{BLOCKS, Derivatives, Fused, Put, Shape};
use crate::batch::tile::Four;
use crate::batch::{History, Section, Tile};
use crate::measure::{self, Measure, Shared};
use crate::scalar::Seeded;
use crate::scalar::lanes::{FirstOrder, LANES, SecondOrder};
use crate::vector::{Matrix, Vector};

/// A value with its derivatives by δ and ρ.
struct Relative {
    value: f64,
    first: [f64; 6],
    second: [[f64; 6]; 6],
}

/// The row of a measure of four elements.
#[inline(never)]
pub(super) fn row<L: Put>(measure: Measure, tile: &Tile, section: &Section, history: &History) -> L {
    let derivatives =
        if const { L::ORDER > 1 } { of::<SecondOrder<f64, 6>> } else { of::<FirstOrder<f64, 6>> };
    let all = [0, 1, 2, 3].map(|lane| derivatives(measure, tile, section, history, lane));
    let four =
        |of: &dyn Fn(&Relative) -> f64| -> Fused { crate::scalar::lanes::Lanes(all.each_ref().map(of)) };
    let first = |at: usize| [0, 1, 2].map(|i| four(&|one| one.first[at + i]));
    let mut row = L::default();
    row.put(
        four(&|one| one.value),
        &Derivatives {
            shape: Shape::of(measure),
            separation: tile.pair().separation(),
            translation: first(0),
            rotation: first(3),
            second: BLOCKS.map(|(at, by)| {
                [0, 1, 2].map(|i| [0, 1, 2].map(|j| four(&|one| one.second[at + i][by + j])))
            }),
        },
    );
    row
}

/// The derivatives of one element.
fn of<S: Seeded<6, Real = f64>>(
    measure: Measure,
    tile: &Tile,
    section: &Section,
    history: &History,
    lane: usize,
) -> Relative {
    const { assert!(LANES == 4, "lanes are counted by hand") }
    let number = |of: &Four| of[lane];
    let vector = |of: &[Four; 3]| -> Vector<f64> { of.each_ref().map(number) };
    let matrix = |of: &[[Four; 3]; 3]| -> Matrix<f64> { of.each_ref().map(vector) };
    let pair = tile.lane(lane);
    let section = measure::Section {
        initial_orientation: matrix(&section.initial_orientation),
        initial_length: 0.0,
        fixed_direction: vector(&section.fixed_direction),
        flow_scale: 0.0,
    };
    let history = measure::History {
        rotation_vector: vector(&history.rotation_vector),
        euler_sign: number(&history.euler_sign),
        torsion_turns: number(&history.torsion_turns),
    };
    let relative = pair.seeded::<S, 6>(measure.dependence(), 0);
    let value = measure.evaluate(&mut Shared::new(&relative, &pair.a.triad, &section, &history));
    Relative { value: value.real(), first: value.gradient(), second: value.hessian() }
}
