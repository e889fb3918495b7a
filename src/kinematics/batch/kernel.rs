//! The loops: tiles in, rows out. They are compiled here, once for each formula and layout; callers do not compile them again.

use crate::batch::layout::{BLOCKS, CompactRow, Derivatives, Fused, Put, RelativeRow, Row, Shape};
use crate::batch::{Batch, BatchError, History, Section, Tile, same_length, single};
use crate::measure::formula::{Formula, Pass, Task};
use crate::measure::{Measure, Shared};
use crate::node::Pair;
use crate::scalar::lanes::{FirstOrder, Lanes, SecondOrder};
use crate::scalar::{Seeded, unrolled};
use pulp::{Arch, Simd, WithSimd};
use std::hint::black_box;
use std::marker::PhantomData;
use std::ops::Range;

/// One pass over all tiles, from row `first` of each on, the rows of each `rows` after those of the one before.
///
/// It is handed on by reference: of few tiles, copies of it would be a tenth of the time.
#[derive(Debug)]
pub(super) struct Loop<'a, L> {
    arch: Arch,
    rows: usize,
    first: usize,
    tiles: &'a [Tile],
    sections: &'a [Section],
    histories: &'a [History],
    out: &'a mut [L],
}

/// A pass whose rows go where it says.
#[derive(Debug)]
pub(super) struct Placed<'l, 'a, L> {
    pass: &'l Pass,
    all: &'l mut Loop<'a, L>,
}

/// Tiles, each with a section and a history, or one for all.
#[derive(Clone, Copy, Debug)]
pub struct Slices<'a> {
    pub(super) tiles: &'a [Tile],
    pub(super) sections: &'a [Section],
    pub(super) histories: &'a [History],
}

impl<'a> Slices<'a> {
    /// Some of them.
    pub(super) fn part(self, these: Range<usize>) -> Option<Self> {
        fn of<'a, T>(all: &'a [T], these: &Range<usize>) -> Option<&'a [T]> {
            if all.len() == 1 { Some(all) } else { all.get(these.clone()) }
        }
        let (sections, histories) = (of(self.sections, &these)?, of(self.histories, &these)?);
        Some(Self { tiles: self.tiles.get(these)?, sections, histories })
    }
}

/// What a batch writes for each row: [`Row`], [`CompactRow`], [`HessianRow`](crate::batch::HessianRow).
/// Nothing outside of this crate can implement it.
pub trait Layout: Copy + Default {
    /// Writes the rows of tiles: there is room for those of each.
    #[doc(hidden)]
    fn fill(batch: &Batch, of: Slices<'_>, out: &mut [Self]);
}

impl Layout for Row {
    fn fill(batch: &Batch, of: Slices<'_>, out: &mut [Self]) {
        loops(batch, of, out);
    }
}

impl Layout for CompactRow {
    fn fill(batch: &Batch, of: Slices<'_>, out: &mut [Self]) {
        loops(batch, of, out);
    }
}

/// What the loops write.
pub(super) trait Looped: Put {
    /// Runs the loop of a pass.
    fn run(placed: Placed<'_, '_, Self>);
}

/// Functions that are not generic, so that they and the loops belong to this crate.
macro_rules! compiled_here {
    ($($layout:ty),+) => {
        $(impl Looped for $layout {
            #[inline(never)]
            fn run(placed: Placed<'_, '_, Self>) {
                placed.pass.dispatch(placed);
            }
        })+
    };
}

compiled_here!(Row, CompactRow, RelativeRow);

/// Runs the passes of a batch: one after the other over all tiles, or over some of them at a time.
pub(super) fn loops<L: Looped>(batch: &Batch, of: Slices<'_>, out: &mut [L]) {
    let (arch, rows, count) = (batch.arch, batch.rows(), of.tiles.len());
    let at_once = if batch.passes.len() > 1 { TILES_AT_ONCE } else { count };
    let mut done = 0;
    while done < count {
        let these = done..count.min(done + at_once);
        done = these.end;
        let out = out.get_mut(these.start * rows..these.end * rows);
        let (Some(Slices { tiles, sections, histories }), Some(out)) = (of.part(these), out) else { break };
        let all = &mut Loop { arch, rows, first: 0, tiles, sections, histories, out };
        for pass in &batch.passes {
            L::run(Placed { pass, all });
        }
    }
}

impl<L: Put> Task for Placed<'_, '_, L> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run<F: Formula<M>, const M: usize>(self) {
        let Self { pass, all } = self;
        // Mostly the rows stand side by side where they are to go.
        let first = pass.rows[0];
        let in_place = (0..M).all(|m| pass.rows[m] < all.rows && pass.rows[m] == first.wrapping_add(m));
        if !in_place {
            return scattered::<F, L, M>(pass, all);
        }
        all.first = first;
        F::apart(all);
    }
}

/// Rows that stand apart, or of which some are not wanted: computed for one tile after another, and copied.
fn scattered<F: Formula<M>, L: Put, const M: usize>(pass: &Pass, all: &mut Loop<'_, L>) {
    let Loop { arch, rows, tiles, sections, histories, ref mut out, .. } = *all;
    let mut computed = [L::default(); M];
    let all = Slices { tiles, sections, histories };
    for (i, out) in out.chunks_exact_mut(rows).enumerate() {
        let Some(Slices { tiles, sections, histories }) = all.part(i..i + 1) else { return };
        F::apart(&mut Loop { arch, rows: M, first: 0, tiles, sections, histories, out: &mut computed });
        for (row, place) in computed.iter().zip(pass.rows) {
            if let Some(out) = out.get_mut(place) {
                *out = *row;
            }
        }
    }
}

/// A formula with a function of its own for its loop: in one function, all loops take the compiler more than 25 minutes.
trait Apart<const M: usize>: Formula<M> + Sized {
    /// Runs the loop, on the vector unit there is. As a default method it belongs to the module of the formula.
    #[inline(never)]
    fn apart<L: Put>(all: &mut Loop<'_, L>) {
        all.arch.dispatch(LoopOf::<Self, L, M> { all, formula: PhantomData });
    }
}

impl<F: Formula<M>, const M: usize> Apart<M> for F {}

/// The loop of one formula.
struct LoopOf<'l, 'a, F, L, const M: usize> {
    all: &'l mut Loop<'a, L>,
    formula: PhantomData<F>,
}

impl<F: Formula<M>, L: Put, const M: usize> WithSimd for LoopOf<'_, '_, F, L, M> {
    type Output = ();

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_simd<V: Simd>(self, _: V) {
        // Without a vector unit four at a time gain nothing: one after the other, by functions that are there anyway.
        if V::F64_LANES > 1 { self.run() } else { self.one_by_one() }
    }
}

impl<F: Formula<M>, L: Put, const M: usize> LoopOf<'_, '_, F, L, M> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn run(self) {
        let Loop { rows, first, tiles, sections, histories, ref mut out, .. } = *self.all;
        let Some(mut rest) = out.get_mut(first..) else { return };
        let (of_section, of_history) = (usize::from(sections.len() > 1), usize::from(histories.len() > 1));
        for i in 0..tiles.len() {
            let constants = (sections.get(i * of_section), histories.get(i * of_history));
            let (Some(target), (Some(section), Some(history))) = (rest.first_chunk_mut::<M>(), constants)
            else {
                return;
            };
            differentiate::<F, L, M>(&tiles[i], section, history, target);
            // After the last tile there may be less left, and it does not matter.
            let Some((_, following)) = rest.split_at_mut_checked(rows) else { return };
            rest = following;
        }
    }

    #[inline(never)]
    fn one_by_one(self) {
        let Loop { rows, first, tiles, sections, histories, ref mut out, .. } = *self.all;
        let all = Slices { tiles, sections, histories };
        for (i, (tile, rows)) in tiles.iter().zip(out.chunks_exact_mut(rows)).enumerate() {
            let Some(Slices { sections: [section], histories: [history], .. }) = all.part(i..i + 1) else {
                return;
            };
            for (row, measure) in rows.iter_mut().skip(first).zip(F::MEASURES) {
                *row = single::row(measure, tile, section, history);
            }
        }
    }
}

/// The rows of four elements.
///
/// Its arguments are references of its own: the compiler knows them to be apart, and reads numbers of a tile between the stores of the rows.
#[cfg_attr(not(debug_assertions), inline(always))]
fn differentiate<F: Formula<M>, L: Put, const M: usize>(
    tile: &Tile,
    section: &Section,
    history: &History,
    out: &mut [L; M],
) {
    // Mostly rotation vectors are principal: whether they are need be known in the end only, so that nothing waits for it.
    let is_final = Element::load(tile, section, history).rows::<F, L, M, true>(out);
    if const { continues_log(&F::MEASURES) } {
        if is_final {
            return;
        }
        // Of other numbers, as far as the compiler knows: else it would keep those above for this, lane by lane.
        let element = Element::load(black_box(tile), black_box(section), black_box(history));
        element.rows::<F, L, M, false>(out);
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
struct Element {
    pair: Pair<Fused>,
    section: crate::measure::Section<Fused>,
    history: crate::measure::History<Fused>,
}

impl Element {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn load(tile: &Tile, section: &Section, history: &History) -> Self {
        Self { pair: tile.pair(), section: section.load(), history: history.load() }
    }

    /// The rows of a formula; with principal rotation vectors if `PRINCIPAL`, and whether those continue the history.
    ///
    /// A constant, so that from the first no function holds both: the compiler would keep all numbers of it in memory.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn rows<F, L, const M: usize, const PRINCIPAL: bool>(&self, out: &mut [L; M]) -> bool
    where
        F: Formula<M>,
        L: Put,
    {
        // Constants, so that only one of these is compiled for each formula.
        if const { L::ORDER == 1 && F::NEEDED.of_position() } {
            self.differentiate::<F, FirstOrder<_, 3>, L, M, 3, PRINCIPAL>(out, 0)
        } else if const { L::ORDER == 1 && F::NEEDED.of_rotation() } {
            self.differentiate::<F, FirstOrder<_, 3>, L, M, 3, PRINCIPAL>(out, 3)
        } else if const { L::ORDER == 1 } {
            self.differentiate::<F, FirstOrder<_, 6>, L, M, 6, PRINCIPAL>(out, 0)
        } else if const { F::NEEDED.of_position() } {
            self.differentiate::<F, SecondOrder<_, 3>, L, M, 3, PRINCIPAL>(out, 0)
        } else if const { F::NEEDED.of_rotation() } {
            self.differentiate::<F, SecondOrder<_, 3>, L, M, 3, PRINCIPAL>(out, 3)
        } else {
            self.differentiate::<F, SecondOrder<_, 6>, L, M, 6, PRINCIPAL>(out, 0)
        }
    }

    /// The same by the N relative variations from number `first` on.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn differentiate<F, S, L, const M: usize, const N: usize, const PRINCIPAL: bool>(
        &self,
        out: &mut [L; M],
        first: usize,
    ) -> bool
    where
        F: Formula<M>,
        S: Seeded<N, Real = Fused>,
        L: Put,
    {
        let needed = F::NEEDED;
        let relative = self.pair.seeded::<S, N>(needed, first);
        let shared = Shared::new(&relative, &self.pair.a.triad, &self.section, &self.history);
        let mut shared = if const { PRINCIPAL } { shared.principal() } else { shared };
        self.put::<F, S, L, M, N>(F::evaluate(&mut shared), out, first);
        shared.is_continued()
    }

    /// The rows of measures differentiated by the N relative variations from number `first` on.
    ///
    /// Row by row, not in a loop: the compiler leaves loops of so many instructions as they are, and what they index in memory.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put<F, S, L, const M: usize, const N: usize>(&self, values: [S; M], out: &mut [L; M], first: usize)
    where
        F: Formula<M>,
        S: Seeded<N, Real = Fused>,
        L: Put,
    {
        const { assert!(M <= 3, "a formula of more than three measures") }
        self.put_one::<F, S, L, M, N, 0>(&values, out, first);
        if const { M > 1 } {
            self.put_one::<F, S, L, M, N, 1>(&values, out, first);
        }
        if const { M > 2 } {
            self.put_one::<F, S, L, M, N, 2>(&values, out, first);
        }
    }

    /// The row of measure number AT.
    #[expect(
        clippy::manual_memcpy,
        reason = "a copied slice is a call, where a vector unit has these in registers"
    )]
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put_one<F, S, L, const M: usize, const N: usize, const AT: usize>(
        &self,
        values: &[S; M],
        out: &mut [L; M],
        first: usize,
    ) where
        F: Formula<M>,
        S: Seeded<N, Real = Fused>,
        L: Put,
    {
        let (Some(value), Some(row), Some(measure)) = (values.get(AT), out.get_mut(AT), F::MEASURES.get(AT))
        else {
            return;
        };
        let zero = Lanes::splat(0.0);
        let mut all = [zero; 6];
        let mut second = [[[zero; 3]; 3]; 3];
        let gradient = value.gradient();
        unrolled!(i < N, {
            all[first + i] = gradient[i];
        });
        if const { L::ORDER > 1 } {
            let hessian = value.hessian();
            unrolled!(block < 3, {
                let (at, by) = BLOCKS[block];
                if first <= at && by < first + N {
                    unrolled!(i < 3, {
                        unrolled!(j < 3, {
                            second[block][i][j] = hessian[at - first + i][by - first + j];
                        })
                    });
                }
            });
        }
        let derivatives = Derivatives {
            shape: Shape::of(*measure),
            separation: self.pair.separation(),
            translation: [all[0], all[1], all[2]],
            rotation: [all[3], all[4], all[5]],
            second,
        };
        row.put(value.real(), &derivatives);
    }
}

/// How many tiles a pass goes through before the next pass takes them: they and their rows stay in the second cache.
const TILES_AT_ONCE: usize = 32;

impl Batch {
    /// Values and rows, in the layout asked for: those of the first tile, then those of the second …
    ///
    /// # Errors
    /// [`BatchError::Length`] unless there are as many sections and histories as tiles, or one for all, and as many rows as
    /// [`Batch::rows`] for each tile.
    pub fn rows_of<L: Layout>(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        out: &mut [L],
    ) -> Result<(), BatchError> {
        let slices = self.slices(tiles, sections, histories)?;
        same_length("rows", out.len(), tiles.len() * self.rows())?;
        if self.rows() > 0 {
            L::fill(self, slices, out);
        }
        Ok(())
    }

    /// Tiles, with as many sections and histories, or one for all.
    pub(super) fn slices<'a>(
        &self,
        tiles: &'a [Tile],
        sections: &'a [Section],
        histories: &'a [History],
    ) -> Result<Slices<'a>, BatchError> {
        for (what, found) in [("sections", sections.len()), ("histories", histories.len())] {
            if found != 1 {
                same_length(what, found, tiles.len())?;
            }
        }
        Ok(Slices { tiles, sections, histories })
    }
}
