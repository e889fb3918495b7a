//! The loops: tiles in, rows out.

use super::passes::{Formula, Pass, Task};
use super::{Batch, BatchError, Four, History, Section, Tile, same_length};
use crate::measure::Shared;
use crate::node::{Dependence, Pair};
use crate::scalar::Seeded;
use crate::scalar::lanes::{FirstOrder, Lanes, SecondOrder};
use crate::vector::{Vector, cross, sub};
use pulp::{Simd, WithSimd};

/// Values and rows of first derivatives of one measure of four elements, in the order x_a, θ_a, x_b, θ_b.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Row {
    /// The value, principal where it winds.
    pub value: Four,
    /// The derivatives.
    pub columns: [Four; 12],
}

/// What determines a row: its columns x_a are the opposite of x_b.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct CompactRow {
    /// The value, principal where it winds.
    pub value: Four,
    /// The columns θ_a.
    pub turning_a: [Four; 3],
    /// The columns x_b.
    pub moving_b: [Four; 3],
    /// The columns θ_b.
    pub turning_b: [Four; 3],
}

/// A row with second derivatives.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct HessianRow {
    /// The value and first derivatives.
    pub row: Row,
    /// The second derivatives, both indices in the order of the row.
    pub hessian: [[Four; 12]; 12],
}

/// Where the derivatives of a measure go.
trait Layout<const FUSED: bool>: Sized {
    /// Whether it has second derivatives.
    const ORDER: usize;

    fn put(
        &mut self,
        value: Lanes<FUSED>,
        gradient: &Gradient<FUSED>,
        separation: &Vector<Lanes<FUSED>>,
        second: &[[Lanes<FUSED>; 6]; 6],
    );
}

/// The first derivatives by the relative variations; `None` where there are none.
struct Gradient<const FUSED: bool> {
    translation: Option<Vector<Lanes<FUSED>>>,
    rotation: Option<Vector<Lanes<FUSED>>>,
}

impl<const FUSED: bool> Gradient<FUSED> {
    /// The columns θ_a: g × D − h.
    #[inline(always)]
    fn turning_a(&self, separation: &Vector<Lanes<FUSED>>) -> Vector<Lanes<FUSED>> {
        match (self.translation, self.rotation) {
            (Some(g), Some(h)) => sub(cross(g, *separation), h),
            (Some(g), None) => cross(g, *separation),
            (None, Some(h)) => [-h[0], -h[1], -h[2]],
            (None, None) => [Lanes::splat(0.0); 3],
        }
    }
}

impl<const FUSED: bool> Layout<FUSED> for Row {
    const ORDER: usize = 1;

    #[inline(always)]
    fn put(
        &mut self,
        value: Lanes<FUSED>,
        gradient: &Gradient<FUSED>,
        separation: &Vector<Lanes<FUSED>>,
        _: &[[Lanes<FUSED>; 6]; 6],
    ) {
        let zero = [Lanes::splat(0.0); 3];
        let arm = gradient.turning_a(separation);
        self.value = value.0;
        for i in 0..3 {
            let g = gradient.translation.unwrap_or(zero)[i];
            self.columns[i] = if gradient.translation.is_some() { (-g).0 } else { g.0 };
            self.columns[3 + i] = arm[i].0;
            self.columns[6 + i] = g.0;
            self.columns[9 + i] = gradient.rotation.unwrap_or(zero)[i].0;
        }
    }
}

impl<const FUSED: bool> Layout<FUSED> for CompactRow {
    const ORDER: usize = 1;

    #[inline(always)]
    fn put(
        &mut self,
        value: Lanes<FUSED>,
        gradient: &Gradient<FUSED>,
        separation: &Vector<Lanes<FUSED>>,
        _: &[[Lanes<FUSED>; 6]; 6],
    ) {
        let zero = [Lanes::splat(0.0); 3];
        let arm = gradient.turning_a(separation);
        self.value = value.0;
        for i in 0..3 {
            self.turning_a[i] = arm[i].0;
            self.moving_b[i] = gradient.translation.unwrap_or(zero)[i].0;
            self.turning_b[i] = gradient.rotation.unwrap_or(zero)[i].0;
        }
    }
}

/// What all loops of a batch work on.
struct Work<'a, L> {
    passes: &'a [Pass],
    rows: usize,
    tiles: &'a [Tile],
    sections: &'a [Section],
    histories: &'a [History],
    out: &'a mut [L],
}

impl<L: Layout<true> + Layout<false>> WithSimd for Work<'_, L> {
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
        L: Layout<FUSED>,
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

impl<const FUSED: bool, L: Layout<FUSED>> Task for Loop<'_, FUSED, L> {
    #[inline(always)]
    fn run<F: Formula<M>, const M: usize>(self) {
        let Loop { pass, rows, tiles, sections, histories, out } = self;
        let elements = tiles.iter().zip(sections).zip(histories).zip(out.chunks_exact_mut(rows));
        for (((tile, section), history), out) in elements {
            let pair = tile.pair::<FUSED>();
            let section = section.load::<FUSED>();
            let history = history.load::<FUSED>();
            let element = Element { pair: &pair, section: &section, history: &history, pass };
            // Constants, so that only one of these is compiled for each formula.
            if const { L::ORDER == 1 && needed::<M>(&F::MEASURES).of_position() } {
                element.differentiate::<F, FirstOrder<_, 3>, L, M, 3>(out, 0);
            }
            if const { L::ORDER == 1 && needed::<M>(&F::MEASURES).of_rotation() } {
                element.differentiate::<F, FirstOrder<_, 3>, L, M, 3>(out, 3);
            }
            if const { L::ORDER == 1 && needed::<M>(&F::MEASURES).of_both() } {
                element.differentiate::<F, FirstOrder<_, 6>, L, M, 6>(out, 0);
            }
            if const { L::ORDER == 2 && needed::<M>(&F::MEASURES).of_position() } {
                element.differentiate::<F, SecondOrder<_, 3>, L, M, 3>(out, 0);
            }
            if const { L::ORDER == 2 && needed::<M>(&F::MEASURES).of_rotation() } {
                element.differentiate::<F, SecondOrder<_, 3>, L, M, 3>(out, 3);
            }
            if const { L::ORDER == 2 && needed::<M>(&F::MEASURES).of_both() } {
                element.differentiate::<F, SecondOrder<_, 6>, L, M, 6>(out, 0);
            }
        }
    }
}

/// What any of the measures depends on.
const fn needed<const M: usize>(measures: &[crate::measure::Measure; M]) -> Dependence {
    let mut sum = measures[0].dependence();
    let mut i = 1;
    while i < M {
        sum = sum.or(measures[i].dependence());
        i += 1;
    }
    sum
}

/// Four elements and where the rows of a pass go.
struct Element<'a, const FUSED: bool> {
    pair: &'a Pair<Lanes<FUSED>>,
    section: &'a crate::measure::Section<Lanes<FUSED>>,
    history: &'a crate::measure::History<Lanes<FUSED>>,
    pass: &'a Pass,
}

impl<const FUSED: bool> Element<'_, FUSED> {
    /// The measures of a formula, differentiated by the N relative variations from number `first` on.
    #[inline(always)]
    fn differentiate<F, S, L, const M: usize, const N: usize>(&self, out: &mut [L], first: usize)
    where
        F: Formula<M>,
        S: Seeded<N, Real = Lanes<FUSED>>,
        L: Layout<FUSED>,
    {
        let needed = const { needed::<M>(&F::MEASURES) };
        let relative = self.pair.seeded::<S, N>(needed, first);
        let mut shared = Shared::new(&relative, &self.pair.a.triad, self.section, self.history);
        let values = F::evaluate(&mut shared);
        let separation = self.pair.separation();
        let zero = Lanes::splat(0.0);
        for m in 0..M {
            let Some(row) = out.get_mut(self.pass.rows[m]) else { continue };
            let mut all = [zero; 6];
            let mut second = [[zero; 6]; 6];
            let gradient = values[m].gradient();
            for i in 0..N {
                all[first + i] = gradient[i];
            }
            if L::ORDER > 1 {
                let hessian = values[m].hessian();
                for i in 0..N {
                    for j in 0..N {
                        second[first + i][first + j] = hessian[i][j];
                    }
                }
            }
            let gradient = Gradient {
                translation: needed.translation.then_some([all[0], all[1], all[2]]),
                rotation: needed.rotation.then_some([all[3], all[4], all[5]]),
            };
            row.put(values[m].real(), &gradient, &separation, &second);
        }
    }
}

impl Batch {
    /// Values and rows: those of the first tile, then those of the second …
    ///
    /// # Errors
    /// [`BatchError::Length`] unless there are as many sections and histories as tiles, and as many rows as [`Batch::rows`] for
    /// each tile.
    pub fn rows_of(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        out: &mut [Row],
    ) -> Result<(), BatchError> {
        self.run(tiles, sections, histories, out)
    }

    /// As [`Batch::rows_of`], as compact rows.
    ///
    /// # Errors
    /// As there.
    pub fn compact_rows_of(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        out: &mut [CompactRow],
    ) -> Result<(), BatchError> {
        self.run(tiles, sections, histories, out)
    }

    fn run<L: Layout<true> + Layout<false>>(
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
