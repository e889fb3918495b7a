//! What a row of four elements holds, and how the derivatives of a measure become it.

use crate::batch::Four;
use crate::measure::Measure;
use crate::node::Dependence;
use crate::scalar::lanes::Lanes;
use crate::scalar::{Scalar, unrolled};
use crate::vector::{Matrix, Vector, cross, dot, sub, transpose};

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

impl CompactRow {
    /// The row of a lane by itself.
    pub fn lane(&self, lane: usize) -> crate::connector::CompactRow<f64> {
        let of = |x: &[Four; 3]| x.each_ref().map(|x| x.get(lane).copied().unwrap_or(f64::NAN));
        crate::connector::CompactRow::new(of(&self.turning_a), of(&self.moving_b), of(&self.turning_b))
    }
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

/// Where the second derivatives by δ and δ, δ and ρ, ρ and ρ stand among those by all six.
const BLOCKS: [(usize, usize); 3] = [(0, 0), (0, 3), (3, 3)];

/// A vector unit multiplies and adds with one rounding.
pub(super) type Fused = Lanes<true>;

/// Where the derivatives of a measure go.
pub(super) trait Put: Copy + Default {
    /// The order of the derivatives.
    const ORDER: usize;

    /// Writes a row.
    fn put(&mut self, value: Fused, of: &Derivatives);
}

/// How a measure depends on the nodes, as far as rows are made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    needed: Dependence,
    turns_with_a: bool,
    is_linear: bool,
}

impl Shape {
    /// That of nothing.
    pub(super) const NONE: Self = Self {
        needed: Dependence { translation: false, rotation: false, flow: false },
        turns_with_a: false,
        is_linear: true,
    };

    pub(super) fn of(measure: Measure) -> Self {
        let (needed, turns_with_a) = (measure.dependence(), measure.turns_with_a());
        Self { needed, turns_with_a, is_linear: measure.is_linear() }
    }

    /// Whether there are second derivatives by δ and δ, δ and ρ, ρ and ρ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    const fn blocks(self) -> [bool; 3] {
        let Dependence { translation, rotation, .. } = self.needed;
        [
            translation && !self.is_linear,
            translation && rotation && !self.is_linear,
            rotation && !self.is_linear,
        ]
    }
}

/// The derivatives by the relative variations δ and ρ, and x_b − x_a.
#[derive(Clone, Copy, Debug)]
pub(super) struct Derivatives {
    pub(super) needed: Dependence,
    /// Whether a turn of a alone changes the value.
    pub(super) turns_with_a: bool,
    /// Whether the value is linear in δ, so that its second derivatives are those of the map alone.
    pub(super) is_linear: bool,
    pub(super) separation: Vector<Fused>,
    pub(super) translation: Vector<Fused>,
    pub(super) rotation: Vector<Fused>,
    pub(super) second: [[Fused; 6]; 6],
}

impl Derivatives {
    /// The columns θ_a: g × D − h.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turning_a(&self) -> Vector<Fused> {
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

impl Put for Row {
    const ORDER: usize = 1;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(&mut self, value: Fused, of: &Derivatives) {
        let (g, arm) = (of.translation, of.turning_a());
        let minus_g = if of.needed.translation { [-g[0], -g[1], -g[2]] } else { g };
        self.value = value.0;
        // In the order of memory: two stores to one line of the cache are done at once where one follows the other.
        for (place, part) in [minus_g, arm, g, of.rotation].into_iter().enumerate() {
            for i in 0..3 {
                self.columns[3 * place + i] = part[i].0;
            }
        }
    }
}

impl Put for CompactRow {
    const ORDER: usize = 1;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(&mut self, value: Fused, of: &Derivatives) {
        let arm = of.turning_a();
        self.value = value.0;
        for i in 0..3 {
            self.turning_a[i] = arm[i].0;
            self.moving_b[i] = of.translation[i].0;
            self.turning_b[i] = of.rotation[i].0;
        }
    }
}

/// The loops leave the derivatives by the relative variations here: g and h among the columns, and blocks of second derivatives in the
/// first lines. [`HessianRow::read`] takes them, and [`HessianRow::put_nodal`] overwrites them. What a measure does not depend on is not written.
impl Put for HessianRow {
    const ORDER: usize = 2;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(&mut self, value: Fused, of: &Derivatives) {
        self.row.value = value.0;
        for i in 0..3 {
            self.row.columns[i] = of.translation[i].0;
            self.row.columns[3 + i] = of.rotation[i].0;
        }
        let is_there = of.is_there();
        unrolled!(block < 3, {
            if is_there[block] {
                let (at, by) = BLOCKS[block];
                unrolled!(i < 3, {
                    unrolled!(j < 3, {
                        self.hessian[block][3 * i + j] = of.second[at + i][by + j].0;
                    })
                });
            }
        });
    }
}

impl HessianRow {
    /// The value and the derivatives by the relative variations that the loops left here.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn read(&self, shape: Shape, separation: Vector<Fused>) -> (Fused, Derivatives) {
        let mut second = [[Lanes::splat(0.0); 6]; 6];
        let is_there = shape.blocks();
        unrolled!(block < 3, {
            if is_there[block] {
                let (at, by) = BLOCKS[block];
                for i in 0..3 {
                    for j in 0..3 {
                        second[at + i][by + j] = Lanes(self.hessian[block][3 * i + j]);
                    }
                }
            }
        });
        let Shape { needed, turns_with_a, is_linear } = shape;
        let [g1, g2, g3, h1, h2, h3, ..] = self.row.columns;
        let (translation, rotation) = ([g1, g2, g3].map(Lanes), [h1, h2, h3].map(Lanes));
        let derivatives =
            Derivatives { needed, turns_with_a, is_linear, separation, translation, rotation, second };
        (Lanes(self.row.value), derivatives)
    }

    /// The row itself.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn put_nodal(&mut self, value: Fused, of: &Derivatives) {
        self.row.put(value, of);
        of.put_second(&mut self.hessian);
    }
}

/// Where the degrees of freedom of each node begin in a row.
const XA: usize = 0;
const THETA_A: usize = 3;
const XB: usize = 6;
const THETA_B: usize = 9;

/// The two axes after each.
const NEXT: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

type Block = Matrix<Fused>;

/// Writes a block and, apart from the diagonal, its transpose.
#[cfg_attr(not(debug_assertions), inline(always))]
fn write(to: &mut [[Four; 12]; 12], at: (usize, usize), block: &Block) {
    unrolled!(i < 3, {
        unrolled!(j < 3, {
            to[at.0 + i][at.1 + j] = block[i][j].0;
            if at.0 != at.1 {
                to[at.1 + j][at.0 + i] = block[i][j].0;
            }
        })
    });
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn negated(block: &Block) -> Block {
    let mut result = *block;
    for i in 0..3 {
        for j in 0..3 {
            result[i][j] = -block[i][j];
        }
    }
    result
}

/// The rows a_i × D of a block a: a times the matrix of D ×.
#[cfg_attr(not(debug_assertions), inline(always))]
fn levered(block: &Block, separation: Vector<Fused>) -> Block {
    [cross(block[0], separation), cross(block[1], separation), cross(block[2], separation)]
}

#[cfg_attr(not(debug_assertions), inline(always))]
fn difference(a: &Block, b: &Block) -> Block {
    [sub(a[0], b[0]), sub(a[1], b[1]), sub(a[2], b[2])]
}

/// The second derivatives of g·δ, in which δ varies with the nodes: the transposed matrix of g × (x_b, θ_a), and
/// ½(g Dᵀ + D gᵀ) − (g·D) I (θ_a, θ_a).
#[cfg_attr(not(debug_assertions), inline(always))]
fn of_map(g: Vector<Fused>, separation: Vector<Fused>) -> (Block, Block) {
    let (zero, half) = (Lanes::splat(0.0), Lanes::splat(0.5));
    let spin = [[zero, g[2], -g[1]], [-g[2], zero, g[0]], [g[1], -g[0], zero]];
    let halves = [g[0] * half, g[1] * half, g[2] * half];
    let along = dot(g, separation);
    let mut centripetal = [[zero; 3]; 3];
    unrolled!(i < 3, {
        centripetal[i][i] = g[i] * separation[i] - along;
        unrolled!(j < i; 3, {
            centripetal[i][j] = halves[i].multiply_add(separation[j], halves[j] * separation[i]);
            centripetal[j][i] = centripetal[i][j];
        })
    });
    (spin, centripetal)
}

impl Derivatives {
    /// Those of nothing.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn none(turns_with_a: bool, separation: Vector<Fused>) -> Self {
        let zero = Lanes::splat(0.0);
        let needed = Dependence { translation: false, rotation: false, flow: false };
        let (first, second) = ([zero; 3], [[zero; 6]; 6]);
        Self {
            needed,
            turns_with_a,
            is_linear: true,
            separation,
            translation: first,
            rotation: first,
            second,
        }
    }

    /// Adds a multiple of others, as far as they are there.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn add(&mut self, multiplier: Fused, of: &Self) {
        self.needed = self.needed.or(of.needed);
        self.is_linear &= of.is_linear;
        for i in 0..3 {
            self.translation[i] = multiplier.multiply_add(of.translation[i], self.translation[i]);
            self.rotation[i] = multiplier.multiply_add(of.rotation[i], self.rotation[i]);
        }
        for ((at, by), is_there) in BLOCKS.into_iter().zip(of.is_there()) {
            if is_there {
                for i in at..at + 3 {
                    for j in by..by + 3 {
                        self.second[i][j] = multiplier.multiply_add(of.second[i][j], self.second[i][j]);
                    }
                }
            }
        }
    }

    /// Whether there are second derivatives by δ and δ, δ and ρ, ρ and ρ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) const fn is_there(&self) -> [bool; 3] {
        self.shape().blocks()
    }

    const fn shape(&self) -> Shape {
        Shape { needed: self.needed, turns_with_a: self.turns_with_a, is_linear: self.is_linear }
    }

    /// The second derivatives as [`Pair::nodal_hessian`] has them, block by block: Lᵀ H L and the second variations of the map L.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn put_second(&self, to: &mut [[Four; 12]; 12]) {
        let of = self;
        let zero = [[Lanes::splat(0.0); 3]; 3];
        let (g, h, separation) = (of.translation, of.rotation, of.separation);
        if of.is_linear {
            let (spin, centripetal) = of_map(g, separation);
            let minus = [
                [zero[0][0], -spin[0][1], -spin[0][2]],
                [-spin[1][0], zero[0][0], -spin[1][2]],
                [-spin[2][0], -spin[2][1], zero[0][0]],
            ];
            write(to, (XA, XA), &zero);
            write(to, (XB, XB), &zero);
            write(to, (XA, XB), &zero);
            write(to, (XA, THETA_B), &zero);
            write(to, (XB, THETA_B), &zero);
            write(to, (THETA_A, THETA_B), &zero);
            write(to, (THETA_B, THETA_B), &zero);
            write(to, (XA, THETA_A), &minus);
            write(to, (XB, THETA_A), &spin);
            write(to, (THETA_A, THETA_A), &centripetal);
            return;
        }
        let (mut dd, mut dr, mut rr) = (zero, zero, zero);
        unrolled!(i < 3, {
            unrolled!(j < 3, {
                dd[i][j] = of.second[i][j];
                dr[i][j] = of.second[i][3 + j];
                rr[i][j] = of.second[3 + i][3 + j];
            })
        });
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
            write(to, (XA, THETA_A), &zero);
            write(to, (XB, THETA_A), &zero);
            write(to, (THETA_B, THETA_A), &zero);
            write(to, (THETA_A, THETA_A), &zero);
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
            let (spin, centripetal) = of_map(g, separation);
            unrolled!(i < 3, {
                unrolled!(j < 3, {
                    theta_theta[i][j] = theta_theta[i][j] + centripetal[i][j];
                    if i != j {
                        d_theta[i][j] = d_theta[i][j] + spin[i][j];
                    }
                })
            });
        } else {
            theta_theta = rr;
        }
        if rotation {
            let half = Lanes::splat(0.5);
            for i in 0..3 {
                let (j, k) = NEXT[i];
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
