//! The loops: tiles in, rows out.

use super::passes::{Formula, Pass, Task};
use super::{Batch, BatchError, Four, History, Section, Tile, same_length};
use crate::measure::Shared;
use crate::node::{Dependence, Pair};
use crate::scalar::Scalar;
use crate::scalar::Seeded;
use crate::scalar::lanes::{FirstOrder, Lanes, SecondOrder};
use crate::vector::{Matrix, Vector, cross, dot, sub, transpose};
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
trait Layout<const FUSED: bool>: Copy + Default {
    /// The order of the derivatives.
    const ORDER: usize;

    fn put(&mut self, value: Lanes<FUSED>, of: &Derivatives<FUSED>);
}

/// The derivatives by the relative variations δ and ρ, and x_b − x_a.
struct Derivatives<const FUSED: bool> {
    needed: Dependence,
    /// Whether a turn of a alone changes the value.
    turns_with_a: bool,
    separation: Vector<Lanes<FUSED>>,
    translation: Vector<Lanes<FUSED>>,
    rotation: Vector<Lanes<FUSED>>,
    second: [[Lanes<FUSED>; 6]; 6],
}

impl<const FUSED: bool> Derivatives<FUSED> {
    /// The columns θ_a: g × D − h.
    #[inline(always)]
    fn turning_a(&self) -> Vector<Lanes<FUSED>> {
        let (g, h) = (self.translation, self.rotation);
        if !self.turns_with_a {
            return [Lanes::splat(0.0); 3];
        }
        if !self.needed.translation {
            return [-h[0], -h[1], -h[2]];
        }
        let arm = cross(g, self.separation);
        if self.needed.rotation { sub(arm, h) } else { arm }
    }
}

impl<const FUSED: bool> Layout<FUSED> for Row {
    const ORDER: usize = 1;

    #[inline(always)]
    fn put(&mut self, value: Lanes<FUSED>, of: &Derivatives<FUSED>) {
        let arm = of.turning_a();
        self.value = value.0;
        for i in 0..3 {
            let g = of.translation[i];
            self.columns[i] = if of.needed.translation { (-g).0 } else { g.0 };
            self.columns[3 + i] = arm[i].0;
            self.columns[6 + i] = g.0;
            self.columns[9 + i] = of.rotation[i].0;
        }
    }
}

impl<const FUSED: bool> Layout<FUSED> for CompactRow {
    const ORDER: usize = 1;

    #[inline(always)]
    fn put(&mut self, value: Lanes<FUSED>, of: &Derivatives<FUSED>) {
        let arm = of.turning_a();
        self.value = value.0;
        for i in 0..3 {
            self.turning_a[i] = arm[i].0;
            self.moving_b[i] = of.translation[i].0;
            self.turning_b[i] = of.rotation[i].0;
        }
    }
}

/// Where the degrees of freedom of each node begin in a row.
const XA: usize = 0;
const THETA_A: usize = 3;
const XB: usize = 6;
const THETA_B: usize = 9;

type Block<const FUSED: bool> = Matrix<Lanes<FUSED>>;

/// Writes a block and, apart from the diagonal, its transpose.
#[inline(always)]
fn write<const FUSED: bool>(to: &mut [[Four; 12]; 12], at: (usize, usize), block: &Block<FUSED>) {
    for i in 0..3 {
        for j in 0..3 {
            to[at.0 + i][at.1 + j] = block[i][j].0;
            if at.0 != at.1 {
                to[at.1 + j][at.0 + i] = block[i][j].0;
            }
        }
    }
}

#[inline(always)]
fn negated<const FUSED: bool>(block: &Block<FUSED>) -> Block<FUSED> {
    let mut result = *block;
    for i in 0..3 {
        for j in 0..3 {
            result[i][j] = -block[i][j];
        }
    }
    result
}

/// The rows a_i × D of a block a: a times the matrix of D ×.
#[inline(always)]
fn levered<const FUSED: bool>(block: &Block<FUSED>, separation: Vector<Lanes<FUSED>>) -> Block<FUSED> {
    [cross(block[0], separation), cross(block[1], separation), cross(block[2], separation)]
}

#[inline(always)]
fn difference<const FUSED: bool>(a: &Block<FUSED>, b: &Block<FUSED>) -> Block<FUSED> {
    [sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2])]
}

impl<const FUSED: bool> Layout<FUSED> for HessianRow {
    const ORDER: usize = 2;

    /// As [`Pair::nodal_hessian`], block by block: Lᵀ H L and the second variations of the map L.
    #[inline(always)]
    fn put(&mut self, value: Lanes<FUSED>, of: &Derivatives<FUSED>) {
        self.row.put(value, of);
        let to = &mut self.hessian;
        let zero = [[Lanes::splat(0.0); 3]; 3];
        let (g, h, separation) = (of.translation, of.rotation, of.separation);
        let half = Lanes::splat(0.5);
        let (mut dd, mut dr, mut rr) = (zero, zero, zero);
        for i in 0..3 {
            for j in 0..3 {
                dd[i][j] = of.second[i][j];
                dr[i][j] = of.second[i][3 + j];
                rr[i][j] = of.second[3 + i][3 + j];
            }
        }
        let Dependence { translation, rotation, .. } = of.needed;
        // Blocks that vanish with what the measure does not depend on are written as zeros, and not computed.
        let minus = if translation { negated(&dd) } else { zero };
        write(to, (XA, XA), &dd);
        write(to, (XB, XB), &dd);
        write(to, (XA, XB), &minus);
        write(to, (XB, THETA_B), &dr);
        write(to, (XA, THETA_B), &if translation && rotation { negated(&dr) } else { zero });
        write(to, (THETA_B, THETA_B), &rr);
        if !of.turns_with_a {
            for at in [XA, XB, THETA_B, THETA_A] {
                write(to, (at, THETA_A), &zero);
            }
            return;
        }
        let mut d_theta = zero;
        let mut theta_theta;
        if translation {
            d_theta = levered(&dd, separation);
            if rotation {
                d_theta = difference(&d_theta, &dr);
            }
        }
        let mut r_theta = if rotation { negated(&rr) } else { zero };
        if translation && rotation {
            r_theta = difference(&levered(&transpose(&dr), separation), &rr);
        }
        if translation {
            // (D ×)ᵀ d_theta: the columns of d_theta crossed with D.
            theta_theta = transpose(&levered(&transpose(&d_theta), separation));
            if rotation {
                theta_theta = difference(&theta_theta, &r_theta);
            }
            let along = dot(g, separation);
            for i in 0..3 {
                for j in 0..3 {
                    let mut centripetal = g[i].multiply_add(separation[j], g[j] * separation[i]) * half;
                    if i == j {
                        centripetal = centripetal - along;
                    }
                    theta_theta[i][j] = theta_theta[i][j] + centripetal;
                }
            }
            // The transposed matrix of g ×.
            for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                d_theta[i][j] = d_theta[i][j] + g[k];
                d_theta[j][i] = d_theta[j][i] - g[k];
            }
        } else {
            theta_theta = rr;
        }
        if rotation {
            for (i, j, k) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
                r_theta[i][j] = h[k].multiply_add(half, r_theta[i][j]);
                r_theta[j][i] = h[k].multiply_add(-half, r_theta[j][i]);
            }
        }
        write(to, (XB, THETA_A), &d_theta);
        write(to, (XA, THETA_A), &if translation { negated(&d_theta) } else { zero });
        write(to, (THETA_B, THETA_A), &r_theta);
        write(to, (THETA_A, THETA_A), &theta_theta);
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
        // Mostly the rows stand side by side where they are to go.
        let in_place = pass.rows[0] < rows
            && pass.rows[M - 1] < rows
            && (1..M).all(|m| pass.rows[m] == pass.rows[0].wrapping_add(m));
        let mut apart = [L::default(); M];
        for (((tile, section), history), out) in elements {
            let pair = tile.pair::<FUSED>();
            let section = section.load::<FUSED>();
            let history = history.load::<FUSED>();
            let element = Element { pair: &pair, section: &section, history: &history };
            let target = if in_place {
                let Some(target) = out.get_mut(pass.rows[0]..).and_then(|rows| rows.first_chunk_mut::<M>())
                else {
                    continue;
                };
                target
            } else {
                &mut apart
            };
            // Constants, so that only one of these is compiled for each formula.
            if const { L::ORDER == 1 && needed::<M>(&F::MEASURES).of_position() } {
                element.differentiate::<F, FirstOrder<_, 3>, L, M, 3>(target, 0);
            }
            if const { L::ORDER == 1 && needed::<M>(&F::MEASURES).of_rotation() } {
                element.differentiate::<F, FirstOrder<_, 3>, L, M, 3>(target, 3);
            }
            if const { L::ORDER == 1 && needed::<M>(&F::MEASURES).of_both() } {
                element.differentiate::<F, FirstOrder<_, 6>, L, M, 6>(target, 0);
            }
            if const { L::ORDER == 2 && needed::<M>(&F::MEASURES).of_position() } {
                element.differentiate::<F, SecondOrder<_, 3>, L, M, 3>(target, 0);
            }
            if const { L::ORDER == 2 && needed::<M>(&F::MEASURES).of_rotation() } {
                element.differentiate::<F, SecondOrder<_, 3>, L, M, 3>(target, 3);
            }
            if const { L::ORDER == 2 && needed::<M>(&F::MEASURES).of_both() } {
                element.differentiate::<F, SecondOrder<_, 6>, L, M, 6>(target, 0);
            }
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

/// Four elements.
struct Element<'a, const FUSED: bool> {
    pair: &'a Pair<Lanes<FUSED>>,
    section: &'a crate::measure::Section<Lanes<FUSED>>,
    history: &'a crate::measure::History<Lanes<FUSED>>,
}

impl<const FUSED: bool> Element<'_, FUSED> {
    /// The measures of a formula, differentiated by the N relative variations from number `first` on.
    #[inline(always)]
    fn differentiate<F, S, L, const M: usize, const N: usize>(&self, out: &mut [L; M], first: usize)
    where
        F: Formula<M>,
        S: Seeded<N, Real = Lanes<FUSED>>,
        L: Layout<FUSED>,
    {
        let needed = const { needed::<M>(&F::MEASURES) };
        let relative = self.pair.seeded::<S, N>(needed, first);
        let mut shared = Shared::new(&relative, &self.pair.a.triad, self.section, self.history);
        let values = F::evaluate(&mut shared);
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

// Inline, so that the loops are compiled by the crate that calls them, and only those: they take the compiler minutes.
impl Batch {
    /// Values and rows: those of the first tile, then those of the second …
    ///
    /// # Errors
    /// [`BatchError::Length`] unless there are as many sections and histories as tiles, and as many rows as [`Batch::rows`] for
    /// each tile.
    #[inline]
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
    #[inline]
    pub fn compact_rows_of(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        out: &mut [CompactRow],
    ) -> Result<(), BatchError> {
        self.run(tiles, sections, histories, out)
    }

    /// As [`Batch::rows_of`], with second derivatives.
    ///
    /// # Errors
    /// As there.
    #[inline]
    pub fn hessians_of(
        &self,
        tiles: &[Tile],
        sections: &[Section],
        histories: &[History],
        out: &mut [HessianRow],
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
