//! Piecewise linear tables of one or several independent variables.
//!
//! The layout is the manual's: every row gives the dependent values, then the independent variables, then the temperature, then
//! field variables. The first variable runs fastest, at fixed values of all others; then the second, and so on. The values of
//! a variable may differ from block to block (a curve may have other abscissae at another temperature); inside a block they
//! increase. A table is therefore a tree: the last variable at its root, curves over the first one at its leaves.
//!
//! Between two rows the value is affine in each variable. Beyond the ends it is constant, or goes on along the last
//! segment (`EXTRAPOLATION=LINEAR`). The segment is chosen on the real part, and the value is then a polynomial of the scalar:
//! derivatives of every order are exact.
//!
//! At a row where two slopes meet there is no derivative. The one-sided slope of smaller magnitude stands for it, or zero where
//! the two have opposite signs (the subgradient of least norm), and [`Table::kinks`] names the place with both slopes.
//!
//! # Regularisation
//! Abaqus/Explicit replaces tables by ones of even intervals within `RTOL` (3 % by default) unless `REGULARIZE=OFF`. Here the
//! rows are used as they are given.

mod read;
#[cfg(test)]
mod tests;

use pintle_kinematics::scalar::{Real, Scalar};
use pintle_scene::Extrapolation;
use read::Written;
use std::cell::Cell;

/// An independent variable of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Variable {
    /// The column at this place (from 0) after the dependent values.
    Column(usize),
    /// The temperature.
    Temperature,
    /// A field variable, from 0.
    Field(usize),
}

/// A row where slopes meet, at or next to which a table was evaluated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kink<R> {
    /// The variable.
    pub variable: Variable,
    /// Where the slopes meet.
    pub at: f64,
    /// How far from it the table was evaluated: zero, or rounding.
    pub distance: R,
    /// The slope below.
    pub left: R,
    /// The slope above.
    pub right: R,
}

/// How near to a row, relative to the numbers it is found from, rounding decides the side.
const ROUNDING: f64 = 1e-13;

/// From which side a slope is taken at a row; zero takes none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Left,
    Right,
    Neither,
}

/// A dependent value for each output, or blocks by the values of one variable.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
enum Block {
    Values(Vec<f64>),
    Along { at: Vec<f64>, blocks: Vec<Block> },
}

/// A table.
///
/// ```
/// use pintle_model::behavior::table::Table;
/// use pintle_scene::Extrapolation;
/// use pintle_kinematics::scalar::Scalar;
/// let table = Table::curve(&[(-1.0, 0.0), (0.0, 0.0), (1.0, 1.0e5)], Extrapolation::Constant)?;
/// let slope = num_dual::Dual64::new(0.01, 1.0);
/// let force = table.evaluate(0, |_| slope);
/// assert_eq!((force.real(), force.eps), (1000.0, 1.0e5));
/// let kinks = table.kinks(0, |_| 0.0);
/// assert_eq!((kinks[0].left, kinks[0].right), (0.0, 1.0e5));
/// # Ok::<(), pintle_scene::Diagnostic>(())
/// ```
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Written")]
pub struct Table {
    /// The variables, fastest first, and whether more than one value of each is given.
    variables: Vec<(Variable, bool)>,
    root: Block,
    extrapolation: Extrapolation,
}

impl Table {
    /// The variables on which the values depend: those given with more than one value.
    pub fn depends_on(&self) -> impl Iterator<Item = Variable> + '_ {
        self.variables.iter().filter(|(_, varies)| *varies).map(|(variable, _)| *variable)
    }

    /// The values of a variable at which rows stand, in increasing order, each once: between two of them the table is affine
    /// in it.
    pub fn rows(&self, variable: Variable) -> Vec<f64> {
        let level = self.variables.iter().position(|(known, varies)| *varies && *known == variable);
        let mut found = level.map_or_else(Vec::new, |level| self.values_at(level));
        found.sort_by(f64::total_cmp);
        found.dedup();
        found
    }

    /// The values of the variable `level` in all blocks.
    fn values_at(&self, level: usize) -> Vec<f64> {
        fn collect(block: &Block, below: usize, found: &mut Vec<f64>) {
            let Block::Along { at, blocks } = block else { return };
            if below == 0 {
                found.extend(at);
            } else {
                blocks.iter().for_each(|block| collect(block, below - 1, found));
            }
        }
        let mut found = Vec::new();
        collect(&self.root, self.variables.len() - 1 - level, &mut found);
        found
    }

    /// How many dependent values there are.
    pub(crate) fn outputs(&self) -> usize {
        self.root.outputs(self.variables.len()).unwrap_or(0)
    }

    /// The dependent value `output` (from 0) at the given variables. `argument` is asked for those of [`Table::depends_on`] only.
    pub fn evaluate<S: Scalar>(&self, output: usize, argument: impl Fn(Variable) -> S) -> S {
        self.evaluated(output, &argument)
    }

    /// One for each type of numbers, not for each argument.
    #[inline(never)]
    fn evaluated<S: Scalar>(&self, output: usize, argument: &dyn Fn(Variable) -> S) -> S {
        let met = Cell::new(false);
        let value = self.at(output, argument, &|_| Side::Right, &met);
        if !met.get() || S::ORDER == 0 {
            return value;
        }
        let real = |variable| argument(variable).real();
        let sides: Vec<Side> = (0..self.variables.len())
            .map(|level| {
                let [left, right] = self.slopes(output, &real, level);
                least(left, right)
            })
            .collect();
        self.at(output, argument, &|level| sides[level], &met)
    }

    /// What the rounding of a slope is measured by: the sum of the magnitudes of the slopes of the rows between which it is interpolated, and
    /// of the values whose difference it is. It is larger than the slope where rows have opposite slopes. Of a row where two slopes meet, the
    /// larger.
    pub(crate) fn slope_scale(
        &self,
        output: usize,
        argument: impl Fn(Variable) -> f64,
        variable: Variable,
    ) -> f64 {
        let Some(level) = self.variables.iter().position(|(known, _)| *known == variable) else { return 0.0 };
        let of =
            |side| self.scale_of_slope((&self.root, self.variables.len()), output, &argument, level, side);
        of(Side::Left).max(of(Side::Right))
    }

    /// The same of the value.
    pub(crate) fn value_scale(&self, output: usize, argument: impl Fn(Variable) -> f64) -> f64 {
        self.scale_of_value(&self.root, self.variables.len(), output, &argument)
    }

    fn scale_of_value(
        &self,
        block: &Block,
        levels: usize,
        output: usize,
        argument: &dyn Fn(Variable) -> f64,
    ) -> f64 {
        let (at, blocks) = match block {
            Block::Values(values) => return values[output].abs(),
            Block::Along { at, blocks } => (at, blocks),
        };
        let below = |i: usize| self.scale_of_value(&blocks[i], levels - 1, output, argument);
        if at.len() == 1 {
            return below(0);
        }
        match self.place(at, argument(self.variables[levels - 1].0), Side::Right, &Cell::new(false)) {
            Place::Flat(i) => below(i),
            Place::Between(i) => below(i).max(below(i + 1)),
        }
    }

    fn scale_of_slope(
        &self,
        (block, levels): (&Block, usize),
        output: usize,
        argument: &dyn Fn(Variable) -> f64,
        level: usize,
        side: Side,
    ) -> f64 {
        let Block::Along { at, blocks } = block else { return 0.0 };
        let here = levels - 1;
        let below = |i: usize| self.scale_of_slope((&blocks[i], here), output, argument, level, side);
        if at.len() == 1 {
            return if here == level { 0.0 } else { below(0) };
        }
        let taken = if here == level { side } else { Side::Right };
        match self.place(at, argument(self.variables[here].0), taken, &Cell::new(false)) {
            Place::Flat(_) if here == level => 0.0,
            Place::Flat(i) => below(i),
            Place::Between(i) if here == level => {
                let value = |i: usize| {
                    self.descend(&blocks[i], here, output, argument, &|_| Side::Right, &Cell::new(false))
                };
                // Rows of the innermost variable are exact, and so is their difference, to its own rounding.
                let formed = |i: usize| {
                    if here == 0 { 0.0 } else { self.scale_of_value(&blocks[i], here, output, argument) }
                };
                ((value(i + 1) - value(i)).abs() + formed(i) + formed(i + 1)) / (at[i + 1] - at[i])
            }
            Place::Between(i) => below(i) + below(i + 1),
        }
    }

    /// The rows where slopes meet, of those at which, up to rounding, the variables lie.
    pub fn kinks<R: Real>(&self, output: usize, argument: impl Fn(Variable) -> R) -> Vec<Kink<R>> {
        let mut kinks = Vec::new();
        for (level, (variable, _)) in self.variables.iter().enumerate().filter(|(_, (_, varies))| *varies) {
            let x = argument(*variable);
            let mut near = None;
            nearest_row(&self.root, self.variables.len(), level, x, &mut near);
            let Some(at) = near else { continue };
            let there = |asked| if asked == *variable { R::from_f64(at) } else { argument(asked) };
            let [left, right] = self.slopes(output, &there, level);
            if less(left, right) || less(right, left) {
                kinks.push(Kink {
                    variable: *variable,
                    at,
                    distance: (x - R::from_f64(at)).magnitude(),
                    left,
                    right,
                });
            }
        }
        kinks
    }

    /// ∫₀ˣ of the dependent value `output` along the first variable, the others being at `rest`. It is the sum of trapezoids up
    /// to the last row before x, exact, and from there a polynomial of x. Its derivative at x is [`Table::evaluate`].
    pub fn integral<S: Scalar>(&self, output: usize, x: S, rest: impl Fn(Variable) -> S) -> S {
        let Some((first, true)) = self.variables.first().copied() else {
            return x * self.evaluate(output, rest);
        };
        let mut rows = self.values_at(0);
        let real = x.real();
        let zero = S::Real::ZERO;
        let forward = !less(real, zero);
        let passed = |row: &f64| {
            let at = S::Real::from_f64(*row);
            if forward { *row > 0.0 && less(at, real) } else { *row < 0.0 && less(real, at) }
        };
        rows.retain(passed);
        rows.sort_unstable_by(|a, b| a.abs().total_cmp(&b.abs()));
        rows.dedup();
        let value = |x: S| self.evaluate(output, |asked| if asked == first { x } else { rest(asked) });
        let mut from = S::zero();
        let mut sum = S::zero();
        for to in rows.into_iter().map(|row| S::from_real(S::Real::from_f64(row))).chain([x]) {
            sum = sum + ((to - from) * (value(from) + value(to))).scale(S::Real::ratio(1, 2));
            from = to;
        }
        sum
    }

    fn at<S: Scalar>(
        &self,
        output: usize,
        argument: &dyn Fn(Variable) -> S,
        side: &dyn Fn(usize) -> Side,
        met: &Cell<bool>,
    ) -> S {
        self.descend(&self.root, self.variables.len(), output, argument, side, met)
    }

    /// The value of a block that has the first `levels` variables.
    fn descend<S: Scalar>(
        &self,
        block: &Block,
        levels: usize,
        output: usize,
        argument: &dyn Fn(Variable) -> S,
        side: &dyn Fn(usize) -> Side,
        met: &Cell<bool>,
    ) -> S {
        let (at, blocks) = match block {
            Block::Values(values) => return S::from_real(S::Real::from_f64(values[output])),
            Block::Along { at, blocks } => (at, blocks),
        };
        let level = levels - 1;
        let below = |i: usize| self.descend(&blocks[i], level, output, argument, side, met);
        if at.len() == 1 {
            return below(0);
        }
        let x = argument(self.variables[level].0);
        let taken = side(level);
        match self.place(at, x.real(), taken, met) {
            Place::Flat(i) => below(i),
            Place::Between(i) => {
                let (low, high) = (below(i), below(i + 1));
                let [x0, x1] = [S::Real::from_f64(at[i]), S::Real::from_f64(at[i + 1])];
                let inverse = S::Real::integer(1) / (x1 - x0);
                let to_low = x.real() - x0;
                let is_low = less(to_low.magnitude(), (x1 - x.real()).magnitude());
                let (base, t) =
                    if is_low { (low, to_low / (x1 - x0)) } else { (high, (x.real() - x1) / (x1 - x0)) };
                let slope = if taken == Side::Neither { S::Real::ZERO } else { inverse };
                let zero = S::Real::ZERO;
                base + (high - low) * x.lift(&[t, slope, zero, zero, zero])
            }
        }
    }

    /// The derivative with respect to the variable `level`, of a block that has the first `levels` variables.
    fn slope<R: Real>(
        &self,
        (block, levels): (&Block, usize),
        output: usize,
        argument: &dyn Fn(Variable) -> R,
        level: usize,
        side: Side,
    ) -> R {
        let Block::Along { at, blocks } = block else { return R::ZERO };
        let here = levels - 1;
        if at.len() == 1 {
            let only = (&blocks[0], here);
            return if here == level { R::ZERO } else { self.slope(only, output, argument, level, side) };
        }
        let met = Cell::new(false);
        let x = argument(self.variables[here].0);
        let place = self.place(at, x, if here == level { side } else { Side::Right }, &met);
        if here == level {
            let Place::Between(i) = place else { return R::ZERO };
            let value = |i: usize| {
                self.descend(&blocks[i], here, output, argument, &|_| Side::Right, &Cell::new(false))
            };
            return (value(i + 1) - value(i)) / (R::from_f64(at[i + 1]) - R::from_f64(at[i]));
        }
        let below = |i: usize| self.slope((&blocks[i], here), output, argument, level, side);
        match place {
            Place::Flat(i) => below(i),
            Place::Between(i) => {
                let [x0, x1] = [R::from_f64(at[i]), R::from_f64(at[i + 1])];
                below(i) + (below(i + 1) - below(i)) * ((x - x0) / (x1 - x0))
            }
        }
    }

    /// The slopes on both sides of where the variable `level` is.
    fn slopes<R: Real>(&self, output: usize, argument: &dyn Fn(Variable) -> R, level: usize) -> [R; 2] {
        let from = |side| self.slope((&self.root, self.variables.len()), output, argument, level, side);
        [from(Side::Left), from(Side::Right)]
    }

    /// The segment of two or more rows in which x lies, or the row whose value holds where there is no slope; `met` tells that x
    /// is at a row.
    fn place<R: Real>(&self, at: &[f64], x: R, side: Side, met: &Cell<bool>) -> Place {
        let last = at.len() - 1;
        let i = at.partition_point(|row| !less(x, R::from_f64(*row)));
        // Rows before i are at or below x.
        let Some(before) = i.checked_sub(1) else { return self.beyond(0, 0) };
        let is_at = !less(R::from_f64(at[before]), x);
        if is_at {
            met.set(true);
        }
        match (is_at, side) {
            (true, Side::Left) if before == 0 => self.beyond(0, 0),
            (true, Side::Left) => Place::Between(before - 1),
            _ if before == last => self.beyond(last, last - 1),
            _ => Place::Between(before),
        }
    }

    const fn beyond(&self, end: usize, segment: usize) -> Place {
        match self.extrapolation {
            Extrapolation::Constant => Place::Flat(end),
            Extrapolation::Linear => Place::Between(segment),
        }
    }
}

/// Where in a block a variable lies.
enum Place {
    /// The value of this row, without a slope.
    Flat(usize),
    /// Along the segment from this row to the next.
    Between(usize),
}

fn less<R: Real>(a: R, b: R) -> bool {
    R::holds(a.less(b))
}

/// The side of the slope of least magnitude; neither where the signs differ.
fn least<R: Real>(left: R, right: R) -> Side {
    let zero = R::ZERO;
    let (below, above) = (less(left, zero), less(right, zero));
    if below != above && (below || less(zero, left)) && (above || less(zero, right)) {
        Side::Neither
    } else if less(left.magnitude(), right.magnitude()) {
        Side::Left
    } else {
        Side::Right
    }
}

/// The row of the variable `level` at which x lies, up to rounding, in any block.
fn nearest_row<R: Real>(block: &Block, levels: usize, level: usize, x: R, found: &mut Option<f64>) {
    let Block::Along { at, blocks } = block else { return };
    if levels - 1 > level {
        blocks.iter().for_each(|block| nearest_row(block, levels - 1, level, x, found));
        return;
    }
    let i = at.partition_point(|row| !less(x, R::from_f64(*row)));
    for row in [i.checked_sub(1), Some(i)].into_iter().flatten().filter_map(|i| at.get(i)) {
        let distance = (x - R::from_f64(*row)).magnitude();
        let scale = x.magnitude() + R::from_f64(row.abs());
        if !less(scale * R::from_f64(ROUNDING), distance) {
            *found = Some(*row);
        }
    }
}
