//! What a row of four elements holds, and how the derivatives of a measure become it.

use crate::batch::Four;
use crate::connector::Group;
use crate::measure::Measure;
use crate::node::{Dependence, arm};
use crate::scalar::lanes::{LANES, Lanes};
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

    /// The derivatives of a lane by one group of three degrees of freedom; of a lane above 3, those of lane 3.
    #[inline]
    pub fn group(&self, lane: usize, group: Group) -> Vector<f64> {
        let lane = lane.min(LANES - 1);
        let of = |x: &[Four; 3]| [x[0][lane], x[1][lane], x[2][lane]];
        match group {
            Group::TranslationA => {
                let [x, y, z] = of(&self.moving_b);
                [-x, -y, -z]
            }
            Group::RotationA => of(&self.turning_a),
            Group::TranslationB => of(&self.moving_b),
            Group::RotationB => of(&self.turning_b),
        }
    }

    /// Whether all derivatives of all lanes are finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        // A product with zero is zero, or NaN.
        let mut sum = [0.0; LANES];
        for columns in [&self.turning_a, &self.moving_b, &self.turning_b] {
            for column in columns {
                for lane in 0..LANES {
                    sum[lane] += 0.0 * column[lane];
                }
            }
        }
        sum == [0.0; LANES]
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
pub(super) const BLOCKS: [(usize, usize); 3] = [(0, 0), (0, 3), (3, 3)];

/// A vector unit multiplies and adds with one rounding.
pub(super) type Fused = Lanes<true>;

/// Where the derivatives of a measure go.
pub(super) trait Put: Copy + Default {
    /// The order of the derivatives.
    const ORDER: usize;

    /// Writes a row.
    fn put(&mut self, value: Fused, of: &Derivatives);
}

/// What the derivatives of a row are made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shape {
    /// Whether there are derivatives by δ.
    pub(super) translation: bool,
    /// Whether there are derivatives by ρ, first and second.
    pub(super) rotation: bool,
    /// Whether there are second derivatives by δ.
    pub(super) quadratic: bool,
    /// Whether there are second derivatives by δ and ρ.
    pub(super) mixed: bool,
    /// Whether a turn of a alone changes the value.
    pub(super) turns_with_a: bool,
}

impl Shape {
    /// That of nothing.
    pub(super) const NONE: Self =
        Self { translation: false, rotation: false, quadratic: false, mixed: false, turns_with_a: false };
    /// A position along an axis of a.
    pub(super) const LINEAR: Self = Self { translation: true, turns_with_a: true, ..Self::NONE };
    /// A distance.
    pub(super) const DISTANCE: Self = Self { translation: true, quadratic: true, ..Self::NONE };
    /// A distance from an axis of a.
    pub(super) const RADIAL: Self = Self { turns_with_a: true, ..Self::DISTANCE };
    /// An angle.
    pub(super) const ANGLE: Self = Self { rotation: true, turns_with_a: true, ..Self::NONE };
    /// Positions along axes of a, and angles.
    pub(super) const LINEAR_AND_ANGLE: Self = Self { rotation: true, ..Self::LINEAR };
    /// A position along axes of both.
    pub(super) const PROJECTED: Self = Self { quadratic: true, mixed: true, ..Self::LINEAR_AND_ANGLE };

    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) const fn of(measure: Measure) -> Self {
        let Dependence { translation, rotation, .. } = measure.dependence();
        let quadratic = translation && !measure.is_linear();
        let (mixed, turns_with_a) = (quadratic && rotation, measure.turns_with_a());
        Self { translation, rotation, quadratic, mixed, turns_with_a }
    }

    /// What either has.
    pub(super) const fn or(self, other: Self) -> Self {
        Self {
            translation: self.translation || other.translation,
            rotation: self.rotation || other.rotation,
            quadratic: self.quadratic || other.quadratic,
            mixed: self.mixed || other.mixed,
            turns_with_a: self.turns_with_a || other.turns_with_a,
        }
    }

    /// What any of those has that change as a turns, or of those that do not.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn all(shapes: &[Self], turning_with_a: bool) -> Self {
        let mut all = Self::NONE;
        for shape in shapes {
            if shape.turns_with_a == turning_with_a {
                all = all.or(*shape);
            }
        }
        all
    }

    /// Whether there are second derivatives by δ and δ, δ and ρ, ρ and ρ.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) const fn blocks(self) -> [bool; 3] {
        [self.quadratic, self.mixed, self.rotation]
    }
}

/// Runs a body with a shape that is a constant there: the code for it has nothing of what is not there.
macro_rules! with_constant {
    ($shape:expr, |$known:ident| $body:expr) => {
        with_constant!(@ $shape, $known, $body, LINEAR DISTANCE RADIAL ANGLE LINEAR_AND_ANGLE PROJECTED)
    };
    (@ $shape:expr, $known:ident, $body:expr, $($constant:ident)+) => {
        match $shape {
            $(Shape::$constant => {
                let $known = Shape::$constant;
                $body
            })+
            $known => $body,
        }
    };
}
pub(super) use with_constant;

/// The derivatives by the relative variations δ and ρ, and x_b − x_a. What its shape does not have is zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Derivatives {
    pub(super) shape: Shape,
    pub(super) separation: Vector<Fused>,
    pub(super) translation: Vector<Fused>,
    pub(super) rotation: Vector<Fused>,
    /// The second derivatives by δ and δ, δ and ρ, ρ and ρ.
    pub(super) second: [Block; 3],
}

impl Derivatives {
    /// The columns θ_a: g × D − h.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn turning_a(&self) -> Vector<Fused> {
        let Shape { translation, rotation, turns_with_a, .. } = self.shape;
        let (g, h) =
            ((self.translation, translation && turns_with_a), (self.rotation, rotation && turns_with_a));
        arm(g, h, self.separation)
    }
}

impl Put for Row {
    const ORDER: usize = 1;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(&mut self, value: Fused, of: &Derivatives) {
        let (g, arm) = (of.translation, of.turning_a());
        let minus_g = if of.shape.translation { [-g[0], -g[1], -g[2]] } else { g };
        value.store(&mut self.value);
        // In the order of memory: two stores to one line of the cache are done at once where one follows the other.
        for (place, part) in [minus_g, arm, g, of.rotation].into_iter().enumerate() {
            for i in 0..3 {
                part[i].store(&mut self.columns[3 * place + i]);
            }
        }
    }
}

impl Put for CompactRow {
    const ORDER: usize = 1;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(&mut self, value: Fused, of: &Derivatives) {
        let arm = of.turning_a();
        value.store(&mut self.value);
        for i in 0..3 {
            arm[i].store(&mut self.turning_a[i]);
            of.translation[i].store(&mut self.moving_b[i]);
            of.rotation[i].store(&mut self.turning_b[i]);
        }
    }
}

/// Value and derivatives by the relative variations of one measure of four elements, of which everything with second derivatives is made.
/// What a measure does not have is not written.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct RelativeRow {
    value: Four,
    translation: [Four; 3],
    rotation: [Four; 3],
    second: [[[Four; 3]; 3]; 3],
}

impl Put for RelativeRow {
    const ORDER: usize = 2;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn put(&mut self, value: Fused, of: &Derivatives) {
        value.store(&mut self.value);
        unrolled!(i < 3, {
            of.translation[i].store(&mut self.translation[i]);
            of.rotation[i].store(&mut self.rotation[i]);
        });
        let is_there = of.shape.blocks();
        unrolled!(block < 3, {
            if is_there[block] {
                unrolled!(i < 3, {
                    unrolled!(j < 3, {
                        of.second[block][i][j].store(&mut self.second[block][i][j]);
                    })
                });
            }
        });
    }
}

impl RelativeRow {
    /// What the loops left here.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn read(&self, shape: Shape, separation: Vector<Fused>) -> Derivatives {
        let mut found = Derivatives { shape, separation, ..Derivatives::NONE };
        unrolled!(i < 3, {
            found.translation[i] = Lanes(self.translation[i]);
            found.rotation[i] = Lanes(self.rotation[i]);
        });
        let is_there = shape.blocks();
        unrolled!(block < 3, {
            if is_there[block] {
                unrolled!(i < 3, {
                    unrolled!(j < 3, {
                        found.second[block][i][j] = Lanes(self.second[block][i][j]);
                    })
                });
            }
        });
        found
    }

    /// The row by the nodes.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn put_nodal(&self, shape: Shape, separation: Vector<Fused>, to: &mut HessianRow) {
        let derivatives = self.read(shape, separation);
        to.row.put(Lanes(self.value), &derivatives);
        derivatives.put_second(&mut to.hessian);
    }
}

/// Where the degrees of freedom of each node begin in a row.
const XA: usize = 0;
const THETA_A: usize = 3;
const XB: usize = 6;
const THETA_B: usize = 9;

/// The two axes after each.
const NEXT: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

pub(super) type Block = Matrix<Fused>;

const NOTHING: Block = [[Lanes([0.0; 4]); 3]; 3];

/// Writes a block and, apart from the diagonal, its transpose.
#[cfg_attr(not(debug_assertions), inline(always))]
fn write(to: &mut [[Four; 12]; 12], at: (usize, usize), block: &Block) {
    unrolled!(i < 3, {
        unrolled!(j < 3, {
            block[i][j].store(&mut to[at.0 + i][at.1 + j]);
            if at.0 != at.1 {
                block[i][j].store(&mut to[at.1 + j][at.0 + i]);
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

/// The second derivatives of g·δ, in which δ varies with the nodes.
///
/// - (x_b, θ_a): the transposed matrix of g ×
/// - (θ_a, θ_a): ½(g Dᵀ + D gᵀ) − (g·D) I
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
    pub(super) const NONE: Self = Self {
        shape: Shape::NONE,
        separation: NOTHING[0],
        translation: NOTHING[0],
        rotation: NOTHING[0],
        second: [NOTHING; 3],
    };

    /// Adds a multiple of others, which have no more than these.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn add(&mut self, multiplier: Fused, of: &Self) {
        for i in 0..3 {
            if of.shape.translation {
                self.translation[i] = multiplier.multiply_add(of.translation[i], self.translation[i]);
            }
            if of.shape.rotation {
                self.rotation[i] = multiplier.multiply_add(of.rotation[i], self.rotation[i]);
            }
        }
        let is_there = of.shape.blocks();
        unrolled!(block < 3, {
            if is_there[block] {
                unrolled!(i < 3, {
                    unrolled!(j < 3, {
                        self.second[block][i][j] =
                            multiplier.multiply_add(of.second[block][i][j], self.second[block][i][j]);
                    })
                });
            }
        });
    }

    /// The second derivatives as [`Pair::nodal_hessian`] has them, block by block: Lᵀ H L and the second variations of the map L.
    #[cfg_attr(not(debug_assertions), inline(always))]
    pub(super) fn put_second(&self, to: &mut [[Four; 12]; 12]) {
        let Self { shape, translation: g, rotation: h, separation, second: [dd, dr, rr] } = *self;
        let Shape { translation, rotation, quadratic, mixed, turns_with_a } = shape;
        // Blocks that vanish with what the row does not have are written as zeros, and not computed.
        write(to, (XA, XA), &dd);
        write(to, (XB, XB), &dd);
        write(to, (XA, XB), &if quadratic { negated(&dd) } else { NOTHING });
        write(to, (XB, THETA_B), &dr);
        write(to, (XA, THETA_B), &if mixed { negated(&dr) } else { NOTHING });
        write(to, (THETA_B, THETA_B), &rr);
        let (mut d_theta, mut r_theta, mut theta_theta) = (NOTHING, NOTHING, NOTHING);
        if turns_with_a {
            if quadratic {
                d_theta = levered(&dd, separation);
            }
            if mixed {
                d_theta = difference(&d_theta, &dr);
                r_theta = difference(&levered(&transpose(&dr), separation), &rr);
            } else if rotation {
                r_theta = negated(&rr);
            }
            if quadratic {
                // (D ×)ᵀ d_theta: the columns of d_theta crossed with D.
                theta_theta = transpose(&levered(&transpose(&d_theta), separation));
                if rotation {
                    theta_theta = difference(&theta_theta, &r_theta);
                }
            } else if rotation {
                theta_theta = rr;
            }
            if translation {
                let (spin, centripetal) = of_map(g, separation);
                unrolled!(i < 3, {
                    unrolled!(j < 3, {
                        theta_theta[i][j] = if quadratic || rotation {
                            theta_theta[i][j] + centripetal[i][j]
                        } else {
                            centripetal[i][j]
                        };
                        if i != j {
                            d_theta[i][j] = if quadratic { d_theta[i][j] + spin[i][j] } else { spin[i][j] };
                        }
                    })
                });
            }
            if rotation {
                let half = Lanes::splat(0.5);
                unrolled!(i < 3, {
                    let (j, k) = NEXT[i];
                    r_theta[i][j] = h[k].multiply_add(half, r_theta[i][j]);
                    r_theta[j][i] = h[k].multiply_add(-half, r_theta[j][i]);
                });
            }
        }
        write(to, (XB, THETA_A), &d_theta);
        write(to, (XA, THETA_A), &if turns_with_a && translation { negated(&d_theta) } else { NOTHING });
        write(to, (THETA_B, THETA_A), &r_theta);
        write(to, (THETA_A, THETA_A), &theta_theta);
    }
}
