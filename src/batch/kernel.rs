//! The loops: tiles in, rows out.

use super::layout::{Derivatives, Layout, Put};
use super::{Batch, BatchError, History, Section, Tile, same_length};
use crate::measure::formula::{Formula, Pass, Task};
use crate::measure::{Measure, Shared};
use crate::node::Pair;
use crate::scalar::Seeded;
use crate::scalar::lanes::{FirstOrder, Lanes, SecondOrder};
use pulp::{Simd, WithSimd};
use std::hint::black_box;

/// What all loops of a batch work on.
struct Work<'a, L> {
    passes: &'a [Pass],
    rows: usize,
    tiles: &'a [Tile],
    sections: &'a [Section],
    histories: &'a [History],
    out: &'a mut [L],
}

impl<L: Layout> WithSimd for Work<'_, L> {
    type Output = ();

    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) {
        // A vector unit multiplies and adds with one rounding; without one that would be a call of a library.
        if V::F64_LANES > 1 { self.loops::<true>() } else { self.loops::<false>() }
    }
}

impl<L> Work<'_, L> {
    #[inline(always)]
    fn loops<const FUSED: bool>(self)
    where
        L: Put<FUSED>,
    {
        let Work { passes, rows, tiles, sections, histories, out } = self;
        for pass in passes {
            pass.dispatch(Loop::<FUSED, L> { pass, rows, tiles, sections, histories, out });
        }
    }
}

/// One pass over all tiles.
struct Loop<'a, const FUSED: bool, L> {
    pass: &'a Pass,
    rows: usize,
    tiles: &'a [Tile],
    sections: &'a [Section],
    histories: &'a [History],
    out: &'a mut [L],
}

impl<const FUSED: bool, L: Put<FUSED>> Task for Loop<'_, FUSED, L> {
    #[inline(always)]
    fn run<F: Formula<M>, const M: usize>(self) {
        let Loop { pass, rows, tiles, sections, histories, out } = self;
        // Mostly the rows stand side by side where they are to go.
        let in_place = pass.rows[0] < rows
            && pass.rows[M - 1] < rows
            && (1..M).all(|m| pass.rows[m] == pass.rows[0].wrapping_add(m));
        let mut apart = [L::default(); M];
        let out = out.get_mut(if in_place { pass.rows[0] } else { 0 }..).unwrap_or_default().chunks_mut(rows);
        for (((tile, section), history), out) in tiles.iter().zip(sections).zip(histories).zip(out) {
            let target = if in_place {
                let Some(target) = out.first_chunk_mut::<M>() else { return };
                target
            } else {
                &mut apart
            };
            differentiate::<F, L, M, FUSED>(tile, section, history, target);
            if !in_place {
                for (row, computed) in pass.rows.iter().zip(&apart) {
                    if let Some(row) = out.get_mut(*row) {
                        *row = *computed;
                    }
                }
            }
        }
    }
}

/// The rows of four elements.
///
/// Its arguments are references of its own so that the compiler knows them to be apart, and reads a tile when it needs a number of
/// it, between the stores of the rows.
#[inline(always)]
fn differentiate<F: Formula<M>, L: Put<FUSED>, const M: usize, const FUSED: bool>(
    tile: &Tile,
    section: &Section,
    history: &History,
    out: &mut [L; M],
) {
    // Mostly rotation vectors are principal: whether they are need be known in the end only, so that nothing waits for it.
    let is_final = Element::<FUSED>::load(tile, section, history).rows::<F, L, M>(out, true);
    if const { continues_log(&F::MEASURES) } {
        if is_final {
            return;
        }
        // Of other numbers, as far as the compiler knows: else it would keep those above for this, lane by lane.
        let element = Element::<FUSED>::load(black_box(tile), black_box(section), black_box(history));
        element.rows::<F, L, M>(out, false);
    }
}

/// Whether a measure is a component of the rotation vector that continues the history.
const fn continues_log<const M: usize>(measures: &[Measure; M]) -> bool {
    let mut i = 0;
    while i < M {
        if matches!(measures[i], Measure::RotationVector(_)) {
            return true;
        }
        i += 1;
    }
    false
}

/// Four elements.
struct Element<const FUSED: bool> {
    pair: Pair<Lanes<FUSED>>,
    section: crate::measure::Section<Lanes<FUSED>>,
    history: crate::measure::History<Lanes<FUSED>>,
}

impl<const FUSED: bool> Element<FUSED> {
    #[inline(always)]
    fn load(tile: &Tile, section: &Section, history: &History) -> Self {
        Self { pair: tile.pair(), section: section.load(), history: history.load() }
    }

    /// The rows of a formula; with `principal` rotation vectors, and whether those continue the history.
    #[inline(always)]
    fn rows<F: Formula<M>, L: Put<FUSED>, const M: usize>(&self, out: &mut [L; M], principal: bool) -> bool {
        // Constants, so that only one of these is compiled for each formula.
        if const { L::ORDER == 1 && F::NEEDED.of_position() } {
            self.differentiate::<F, FirstOrder<_, 3>, L, M, 3>(out, 0, principal)
        } else if const { L::ORDER == 1 && F::NEEDED.of_rotation() } {
            self.differentiate::<F, FirstOrder<_, 3>, L, M, 3>(out, 3, principal)
        } else if const { L::ORDER == 1 } {
            self.differentiate::<F, FirstOrder<_, 6>, L, M, 6>(out, 0, principal)
        } else if const { F::NEEDED.of_position() } {
            self.differentiate::<F, SecondOrder<_, 3>, L, M, 3>(out, 0, principal)
        } else if const { F::NEEDED.of_rotation() } {
            self.differentiate::<F, SecondOrder<_, 3>, L, M, 3>(out, 3, principal)
        } else {
            self.differentiate::<F, SecondOrder<_, 6>, L, M, 6>(out, 0, principal)
        }
    }

    /// The same by the N relative variations from number `first` on.
    #[inline(always)]
    fn differentiate<F, S, L, const M: usize, const N: usize>(
        &self,
        out: &mut [L; M],
        first: usize,
        principal: bool,
    ) -> bool
    where
        F: Formula<M>,
        S: Seeded<N, Real = Lanes<FUSED>>,
        L: Put<FUSED>,
    {
        let needed = F::NEEDED;
        let relative = self.pair.seeded::<S, N>(needed, first);
        let shared = Shared::new(&relative, &self.pair.a.triad, &self.section, &self.history);
        let mut shared = if principal { shared.principal() } else { shared };
        self.put::<F, S, L, M, N>(F::evaluate(&mut shared), out, first);
        shared.is_continued()
    }

    /// The rows of measures differentiated by the N relative variations from number `first` on.
    #[inline(always)]
    fn put<F, S, L, const M: usize, const N: usize>(&self, values: [S; M], out: &mut [L; M], first: usize)
    where
        F: Formula<M>,
        S: Seeded<N, Real = Lanes<FUSED>>,
        L: Put<FUSED>,
    {
        let needed = F::NEEDED;
        let zero = Lanes::splat(0.0);
        for m in 0..M {
            let row = &mut out[m];
            let mut all = [zero; 6];
            let mut second = [[zero; 6]; 6];
            let gradient = values[m].gradient();
            all[first..first + N].copy_from_slice(&gradient);
            if L::ORDER > 1 {
                let hessian = values[m].hessian();
                for i in 0..N {
                    for j in 0..N {
                        second[first + i][first + j] = hessian[i][j];
                    }
                }
            }
            let derivatives = Derivatives {
                needed,
                turns_with_a: F::MEASURES[m].turns_with_a(),
                separation: self.pair.separation(),
                translation: [all[0], all[1], all[2]],
                rotation: [all[3], all[4], all[5]],
                second,
            };
            row.put(values[m].real(), &derivatives);
        }
    }
}

impl Batch {
    /// Values and rows, in the layout asked for: those of the first tile, then those of the second …
    ///
    /// The loops are compiled by the crate that calls this, and only those of its layouts: they take the compiler minutes.
    ///
    /// # Errors
    /// [`BatchError::Length`] unless there are as many sections and histories as tiles, and as many rows as [`Batch::rows`] for
    /// each tile.
    pub fn rows_of<L: Layout>(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        out: &mut [L],
    ) -> Result<(), BatchError> {
        same_length("sections", sections.len(), tiles.len())?;
        same_length("histories", histories.len(), tiles.len())?;
        same_length("rows", out.len(), tiles.len() * self.rows())?;
        if self.rows() == 0 {
            return Ok(());
        }
        let work = Work { passes: &self.passes, rows: self.rows(), tiles, sections, histories, out };
        self.arch.dispatch(work);
        Ok(())
    }
}
