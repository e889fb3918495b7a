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

use crate::scalar::{Real, Scalar};
use crate::scene::{Code, Diagnostic, Extrapolation, Row, Span};
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
/// use pintle::behavior::table::Table;
/// use pintle::scene::Extrapolation;
/// use pintle::scalar::Scalar;
/// let table = Table::curve(&[(-1.0, 0.0), (0.0, 0.0), (1.0, 1.0e5)], Extrapolation::Constant)?;
/// let slope = num_dual::Dual64::new(0.01, 1.0);
/// let force = table.evaluate(0, |_| slope);
/// assert_eq!((force.real(), force.eps), (1000.0, 1.0e5));
/// let kinks = table.kinks(0, |_| 0.0);
/// assert_eq!((kinks[0].left, kinks[0].right), (0.0, 1.0e5));
/// # Ok::<(), pintle::scene::Diagnostic>(())
/// ```
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "Written")]
pub struct Table {
    /// The variables, fastest first, and whether more than one value of each is given.
    variables: Vec<(Variable, bool)>,
    root: Block,
    extrapolation: Extrapolation,
}

/// A table as a file has it, which may be of any shape.
#[derive(serde::Deserialize)]
struct Written {
    variables: Vec<(Variable, bool)>,
    root: Block,
    extrapolation: Extrapolation,
}

impl TryFrom<Written> for Table {
    type Error = String;

    fn try_from(Written { variables, root, extrapolation }: Written) -> Result<Self, String> {
        root.outputs(variables.len())?;
        let mut table = Self { variables, root, extrapolation };
        for level in 0..table.variables.len() {
            let varies = table.values_at(level).windows(2).any(|pair| pair[0] != pair[1]);
            table.variables[level].1 = varies;
        }
        Ok(table)
    }
}

impl Block {
    /// How many dependent values each row of a block with the first `levels` variables has.
    fn outputs(&self, levels: usize) -> Result<usize, String> {
        match (self, levels.checked_sub(1)) {
            (Self::Values(values), None) => match values.len() {
                0 => Err("a row of a table has no dependent value".into()),
                _ if !values.iter().all(|x| x.is_finite()) => Err("a value of a table is not finite".into()),
                outputs => Ok(outputs),
            },
            (Self::Along { at, blocks }, Some(below)) => {
                let (rows, values) = (blocks.len(), at.len());
                if rows == 0 || rows != values {
                    return Err(format!("a table has {values} values of a variable for {rows} rows"));
                }
                if !at.iter().all(|x| x.is_finite()) || !at.windows(2).all(|pair| pair[0] < pair[1]) {
                    return Err("the values of a variable of a table do not increase".into());
                }
                let all: Vec<usize> =
                    blocks.iter().map(|block| block.outputs(below)).collect::<Result<_, _>>()?;
                if all.windows(2).any(|pair| pair[0] != pair[1]) {
                    return Err("rows of a table have different numbers of dependent values".into());
                }
                all.first().copied().ok_or_else(|| "a table has no row".into())
            }
            (Self::Values(_), Some(_)) => Err("a table has more variables than its rows".into()),
            (Self::Along { .. }, None) => Err("a table has fewer variables than its rows".into()),
        }
    }
}

/// One row on the way into a table.
struct Record<'a> {
    outputs: &'a [f64],
    at: &'a [f64],
    span: Span,
}

impl Table {
    /// A table from rows: `outputs` dependent values, then one column for each of `columns` (their names, for messages), then
    /// temperature and field variables. A column that no row gives is no variable.
    ///
    /// # Errors
    /// [`Code::TableOrder`] at the row that does not follow the one before, or stands twice; [`Code::MissingData`] at a row that
    /// leaves open what others give; [`Code::NumberOutOfRange`] at a row so near to the one before, or so much higher, that the
    /// slope between them is no double.
    pub fn new(
        rows: &[Row],
        outputs: usize,
        columns: &[&str],
        extrapolation: Extrapolation,
    ) -> Result<Self, Diagnostic> {
        let fields = rows.iter().map(|row| row.fields.len()).max().unwrap_or(0);
        let all = (0..columns.len())
            .map(Variable::Column)
            .chain(std::iter::once(Variable::Temperature))
            .chain((0..fields).map(Variable::Field));
        let given = |row: &Row, variable| match variable {
            Variable::Column(column) => row.values.get(outputs + column).copied().flatten(),
            Variable::Temperature => row.temperature,
            Variable::Field(field) => row.fields.get(field).copied().flatten(),
        };
        let variables: Vec<Variable> =
            all.filter(|variable| rows.iter().any(|row| given(row, *variable).is_some())).collect();
        let names: Vec<String> = variables.iter().map(|variable| name(*variable, columns)).collect();
        let mut numbers = Vec::with_capacity(rows.len());
        for row in rows {
            let mut dependent = Vec::with_capacity(outputs);
            for output in 0..outputs {
                let value = row.values.get(output).copied().flatten();
                dependent.push(value.ok_or_else(|| missing(row.span, "a dependent value"))?);
            }
            let mut at = Vec::with_capacity(variables.len());
            for (variable, name) in variables.iter().zip(&names) {
                at.push(given(row, *variable).ok_or_else(|| missing(row.span, name))?);
            }
            numbers.push((dependent, at, row.span));
        }
        let records: Vec<Record<'_>> =
            numbers.iter().map(|(outputs, at, span)| Record { outputs, at, span: *span }).collect();
        if records.is_empty() {
            return Err(missing(Span::default(), "a row"));
        }
        let root = build(&records, &names)?;
        let varies = |level: usize| records.windows(2).any(|pair| pair[0].at[level] != pair[1].at[level]);
        let variables = variables.into_iter().enumerate().map(|(level, v)| (v, varies(level))).collect();
        Ok(Self { variables, root, extrapolation })
    }

    /// A curve through (x, y), with x in increasing order.
    ///
    /// # Errors
    /// As [`Table::new`].
    pub fn curve(points: &[(f64, f64)], extrapolation: Extrapolation) -> Result<Self, Diagnostic> {
        let row = |(x, y): &(f64, f64)| Row { values: vec![Some(*y), Some(*x)], ..Row::default() };
        let rows: Vec<Row> = points.iter().map(row).collect();
        Self::new(&rows, 1, &["the abscissa"], extrapolation)
    }

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
        let met = Cell::new(false);
        let value = self.at(output, &argument, &|_| Side::Right, &met);
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
        self.at(output, &argument, &|level| sides[level], &met)
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
        argument: &impl Fn(Variable) -> f64,
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
        argument: &impl Fn(Variable) -> f64,
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

    /// ∫₀ˣ of the dependent value `output` along the first variable, the others being at `rest`: the sum of trapezoids up to the
    /// last row before x, exact, and from there a polynomial of x. Its derivative at x is [`Table::evaluate`].
    pub fn integral<S: Scalar>(&self, output: usize, x: S, rest: impl Fn(Variable) -> S) -> S {
        let Some((first, true)) = self.variables.first().copied() else {
            return x * self.evaluate(output, rest);
        };
        let mut rows = Vec::new();
        abscissae(&self.root, self.variables.len(), &mut rows);
        let real = x.real();
        let zero = S::Real::integer(0);
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
        argument: &impl Fn(Variable) -> S,
        side: &impl Fn(usize) -> Side,
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
        argument: &impl Fn(Variable) -> S,
        side: &impl Fn(usize) -> Side,
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
                let slope = if taken == Side::Neither { S::Real::integer(0) } else { inverse };
                let zero = S::Real::integer(0);
                base + (high - low) * x.lift(&[t, slope, zero, zero, zero])
            }
        }
    }

    /// The derivative with respect to the variable `level`, of a block that has the first `levels` variables.
    fn slope<R: Real>(
        &self,
        (block, levels): (&Block, usize),
        output: usize,
        argument: &impl Fn(Variable) -> R,
        level: usize,
        side: Side,
    ) -> R {
        let Block::Along { at, blocks } = block else { return R::integer(0) };
        let here = levels - 1;
        if at.len() == 1 {
            let only = (&blocks[0], here);
            return if here == level {
                R::integer(0)
            } else {
                self.slope(only, output, argument, level, side)
            };
        }
        let met = Cell::new(false);
        let x = argument(self.variables[here].0);
        let place = self.place(at, x, if here == level { side } else { Side::Right }, &met);
        if here == level {
            let Place::Between(i) = place else { return R::integer(0) };
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
    fn slopes<R: Real>(&self, output: usize, argument: &impl Fn(Variable) -> R, level: usize) -> [R; 2] {
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

/// The values of the first variable in all blocks.
fn abscissae(block: &Block, levels: usize, found: &mut Vec<f64>) {
    let Block::Along { at, blocks } = block else { return };
    if levels == 1 {
        found.extend(at);
    } else {
        blocks.iter().for_each(|block| abscissae(block, levels - 1, found));
    }
}

fn less<R: Real>(a: R, b: R) -> bool {
    R::holds(a.less(b))
}

/// The side of the slope of least magnitude; neither where the signs differ.
fn least<R: Real>(left: R, right: R) -> Side {
    let zero = R::integer(0);
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

fn build(records: &[Record<'_>], names: &[String]) -> Result<Block, Diagnostic> {
    let Some((name, inner)) = names.split_last() else {
        return match records {
            [only] => Ok(Block::Values(only.outputs.to_vec())),
            [_, second, ..] => Err(order(second.span, "this row stands twice".to_string())
                .help("keep one of the two rows with equal independent variables")),
            [] => Err(missing(Span::default(), "a row")),
        };
    };
    let level = inner.len();
    let (mut at, mut blocks): (Vec<f64>, Vec<Block>) = (Vec::new(), Vec::new());
    let mut rest = records;
    while let Some(first) = rest.first() {
        let value = first.at[level];
        if let Some(before) = at.last().filter(|before| **before >= value) {
            let message = format!("{name} goes from {before} to {value}");
            let remedy = if level == 0 {
                format!("order the rows so that {name} increases")
            } else {
                format!(
                    "give all rows of one value of {name} together, and let {name} increase from block to block"
                )
            };
            return Err(order(first.span, message).help(remedy));
        }
        let count = rest.iter().take_while(|record| record.at[level] == value).count();
        let (together, others) = rest.split_at(count);
        let block = build(together, inner)?;
        if let (Some(before), Some(low)) = (at.last(), blocks.last()) {
            check_slope(value - before, low, &block, first.span, name)?;
        }
        at.push(value);
        blocks.push(block);
        rest = others;
    }
    Ok(Block::Along { at, blocks })
}

/// Slopes, and what they are formed from, are doubles.
fn check_slope(width: f64, low: &Block, high: &Block, span: Span, name: &str) -> Result<(), Diagnostic> {
    let out_of_range = |message: String| {
        Diagnostic::error(Code::NumberOutOfRange, span, message, "from here on")
            .help("use rows that lie farther apart, or other units")
    };
    if !width.is_finite() || !width.recip().is_finite() {
        let message =
            format!("{name} moves by {width:e} from the row before: too little, or too much, for a double");
        return Err(out_of_range(message));
    }
    if let (Block::Values(low), Block::Values(high)) = (low, high) {
        for (low, high) in low.iter().zip(high) {
            let (rise, slope) = (high - low, (high - low) / width);
            if !rise.is_finite() || !slope.is_finite() {
                return Err(out_of_range(format!(
                    "the slope from the row before, {rise:e}/{width:e}, is no double"
                )));
            }
        }
    }
    Ok(())
}

fn order(span: Span, message: String) -> Diagnostic {
    Diagnostic::error(Code::TableOrder, span, message, "does not follow the row before")
}

fn missing(span: Span, what: &str) -> Diagnostic {
    Diagnostic::error(Code::MissingData, span, format!("{what} is missing"), "in this row")
        .help(format!("give {what} in every row, or in none"))
}

fn name(variable: Variable, columns: &[&str]) -> String {
    match variable {
        Variable::Column(column) => columns.get(column).map_or_else(String::new, ToString::to_string),
        Variable::Temperature => "the temperature".to_string(),
        Variable::Field(field) => format!("field variable {}", field + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_dual::{Dual2SVec64, DualSVec64};

    fn rows(rows: &[(&[f64], Option<f64>)]) -> Vec<Row> {
        let row = |(values, temperature): &(&[f64], Option<f64>)| Row {
            values: values.iter().copied().map(Some).collect(),
            temperature: *temperature,
            ..Row::default()
        };
        rows.iter().map(row).collect()
    }

    fn table(data: &[(&[f64], Option<f64>)], columns: usize, extrapolation: Extrapolation) -> Table {
        Table::new(&rows(data), 1, &["x", "y", "z"][..columns], extrapolation).unwrap()
    }

    /// Where a product of two linear functions is a table, the table is that product, with its derivatives.
    #[test]
    fn a_grid_is_affine_in_each_variable() {
        let product = |x: f64, y: f64| (1.0 + 2.0 * x) * (3.0 - y);
        let mut data = Vec::new();
        for y in [-1.0, 0.5, 2.0] {
            for x in [0.0, 1.0, 4.0] {
                data.push(vec![product(x, y), x, y]);
            }
        }
        let data: Vec<(&[f64], Option<f64>)> = data.iter().map(|row| (row.as_slice(), None)).collect();
        let table = table(&data, 2, Extrapolation::Linear);
        for (x, y) in
            [(0.25, 0.25), (3.0, 1.0), (-2.0, 5.0), (1.0, 0.5), (4.0, 2.0), (0.0, -1.0), (9.0, -4.0)]
        {
            let seeded =
                [Dual2SVec64::<2>::from_re(x).derivative(0), Dual2SVec64::<2>::from_re(y).derivative(1)];
            let value = table.evaluate(0, |variable| match variable {
                Variable::Column(j) => seeded[j],
                _ => unreachable!(),
            });
            let (gradient, second) = (value.v1.0.unwrap(), value.v2.0.unwrap());
            let near = |a: f64, b: f64| assert!((a - b).abs() <= 1e-13 * (1.0 + b.abs()), "{x} {y}: {a} {b}");
            near(value.re, product(x, y));
            near(gradient[0], 2.0 * (3.0 - y));
            near(gradient[1], -(1.0 + 2.0 * x));
            near(second[(0, 0)], 0.0);
            near(second[(0, 1)], -2.0);
        }
    }

    /// The values given are the values got, bit for bit, and a curve may have other abscissae at another temperature.
    #[test]
    fn rows_are_met_exactly() {
        let data: [(&[f64], Option<f64>); 5] = [
            (&[0.1, -0.3], Some(20.0)),
            (&[0.7, 0.2], Some(20.0)),
            (&[0.3, -1.1], Some(100.0)),
            (&[0.5, 0.1], Some(100.0)),
            (&[0.9, 1.7], Some(100.0)),
        ];
        let table = table(&data, 1, Extrapolation::Constant);
        assert!(table.depends_on().eq([Variable::Column(0), Variable::Temperature]));
        for (values, temperature) in data {
            let value = table.evaluate(0, |variable| match variable {
                Variable::Temperature => temperature.unwrap(),
                _ => values[1],
            });
            assert_eq!(value, values[0]);
        }
        let between =
            table.evaluate(0, |variable| if variable == Variable::Temperature { 60.0 } else { 0.1 });
        // At 20 degrees 0.1 + 0.6·0.4/0.5, at 100 degrees 0.5.
        assert!((between - 0.5 * (0.58 + 0.5)).abs() < 1e-15, "{between}");
    }

    #[test]
    fn slopes_at_a_row_are_those_of_least_norm() {
        let of = |y: [f64; 3], x: f64, extrapolation| {
            let points = [(-1.0, y[0]), (0.0, y[1]), (2.0, y[2])];
            let table = Table::curve(&points, extrapolation).unwrap();
            let value = table.evaluate(0, |_| DualSVec64::<1>::from_re(x).derivative(0));
            let kinks = table.kinks(0, |_| x);
            (value.eps.0.map_or(0.0, |eps| eps[0]), kinks.first().map(|kink| (kink.left, kink.right)))
        };
        use Extrapolation::{Constant, Linear};
        assert_eq!(of([0.0, 0.0, 6.0], 0.0, Constant), (0.0, Some((0.0, 3.0))));
        assert_eq!(of([-5.0, 0.0, 6.0], 0.0, Constant), (3.0, Some((5.0, 3.0))));
        assert_eq!(of([-2.0, 0.0, 6.0], 0.0, Constant), (2.0, Some((2.0, 3.0))));
        assert_eq!(of([5.0, 0.0, 6.0], 0.0, Constant), (0.0, Some((-5.0, 3.0))));
        assert_eq!(of([-3.0, 0.0, 6.0], 0.0, Constant), (3.0, None));
        assert_eq!(of([-3.0, 0.0, 6.0], 2.0, Constant), (0.0, Some((3.0, 0.0))));
        assert_eq!(of([-3.0, 0.0, 6.0], -1.0, Constant), (0.0, Some((0.0, 3.0))));
        assert_eq!(of([-3.0, 0.0, 6.0], 2.0, Linear), (3.0, None));
        assert_eq!(of([-3.0, 0.0, 8.0], 7.0, Linear), (4.0, None));
        assert_eq!(of([-3.0, 0.0, 8.0], 7.0, Constant), (0.0, None));
        // A hair beside the row the slope is that of the segment, and the row is still told.
        assert_eq!(of([0.0, 0.0, 6.0], 1e-300, Constant), (3.0, None));
        assert_eq!(of([0.0, 4.0, 4.0], 2.0 + 1e-15, Constant), (0.0, None));
        assert_eq!(of([0.0, 0.0, 6.0], 2.0 - 1e-15, Constant), (3.0, Some((3.0, 0.0))));
    }

    #[test]
    fn the_range_of_doubles_is_used() {
        let points = [(-1e300, -2e-300), (1e-300, 3e300), (1e300, 4e300)];
        let table = Table::curve(&points, Extrapolation::Constant).unwrap();
        for (x, y) in points {
            assert_eq!(table.evaluate(0, |_| x), y);
        }
        let value = table.evaluate(0, |_| DualSVec64::<1>::from_re(5e299).derivative(0));
        assert!((value.re - 3.5e300).abs() < 1e285 && (value.eps.0.unwrap()[0] - 1.0).abs() < 1e-15);
        let steep = Table::curve(&[(0.0, 0.0), (1e-300, 1e300)], Extrapolation::Constant);
        assert_eq!(steep.unwrap_err().code(), Code::NumberOutOfRange);
        let near = Table::curve(&[(0.0, 0.0), (5e-324, 0.0)], Extrapolation::Constant);
        assert_eq!(near.unwrap_err().code(), Code::NumberOutOfRange);
    }

    #[test]
    fn rows_out_of_order_are_told() {
        let fails = |data: &[(&[f64], Option<f64>)]| {
            let error = Table::new(&rows(data), 1, &["x", "y"], Extrapolation::Constant).unwrap_err();
            (error.code(), error.message().to_string())
        };
        let twice = fails(&[(&[1.0, 0.0, 0.0], None), (&[2.0, 0.0, 0.0], None)]);
        assert_eq!(twice, (Code::TableOrder, "this row stands twice".to_string()));
        let back = fails(&[(&[1.0, 1.0, 0.0], None), (&[2.0, 0.0, 0.0], None)]);
        assert_eq!(back, (Code::TableOrder, "x goes from 1 to 0".to_string()));
        let blocks = fails(&[(&[1.0, 0.0, 0.0], None), (&[1.0, 0.0, 1.0], None), (&[2.0, 1.0, 0.0], None)]);
        assert_eq!(blocks, (Code::TableOrder, "y goes from 1 to 0".to_string()));
        let partly = fails(&[(&[1.0, 0.0, 0.0], Some(20.0)), (&[2.0, 1.0, 0.0], None)]);
        assert_eq!(partly, (Code::MissingData, "the temperature is missing".to_string()));
    }

    /// A table of two variables with opposite slopes in neighbouring rows.
    fn crossing(extrapolation: Extrapolation) -> Table {
        let data: [&[f64]; 6] = [
            &[1.0, 1.0, 1.0],
            &[-3.0, 3.0, 1.0],
            &[1.0, 4.0, 1.0],
            &[5.0, 1.0, 3.0],
            &[7.0, 3.0, 3.0],
            &[7.5, 4.0, 3.0],
        ];
        table(&data.map(|row| (row, None)), 2, extrapolation)
    }

    /// Σ |slopes of the rows| along the first variable; |Δ| and both rows' sizes over the step along the second.
    #[test]
    fn slopes_are_measured_by_what_they_are_formed_from() {
        let table = crossing(Extrapolation::Constant);
        let scales = |x: f64, y: f64| {
            let argument = |variable| if variable == Variable::Column(0) { x } else { y };
            let slope = |variable| table.slope_scale(0, argument, variable);
            [
                slope(Variable::Column(0)),
                slope(Variable::Column(1)),
                slope(Variable::Temperature),
                table.value_scale(0, argument),
            ]
        };
        assert_eq!(scales(2.0, 1.5), [3.0, 8.5, 0.0, 7.0]);
        // Where two slopes meet, the larger.
        assert_eq!(scales(3.0, 1.5), [4.5, 10.25, 0.0, 7.5]);
        // From the left, where there is nothing on the right.
        assert_eq!(scales(4.0, 1.5), [4.5, 7.5, 0.0, 7.5]);
        // Beyond the rows it is constant.
        assert_eq!(scales(9.0, 1.5), [0.0, 7.5, 0.0, 7.5]);
        assert_eq!(scales(2.0, 5.0), [1.0, 0.0, 0.0, 7.0]);
        assert_eq!(scales(2.0, -1.0), [2.0, 0.0, 0.0, 3.0]);
        let single =
            self::table(&[(&[1.0, 1.0, 2.0], None), (&[4.0, 3.0, 2.0], None)], 2, Extrapolation::Constant);
        let argument = |_| 2.0;
        let slope = |column| single.slope_scale(0, argument, Variable::Column(column));
        assert_eq!([slope(0), slope(1), single.value_scale(0, argument)], [1.5, 0.0, 4.0]);
    }

    /// Tables go to files and come back; what makes none is refused.
    #[test]
    fn tables_are_read_back_or_refused() {
        let table = crossing(Extrapolation::Linear);
        let written = serde_json::to_value(&table).unwrap();
        let read = |value: &serde_json::Value| {
            serde_json::from_value::<Table>(value.clone()).map_err(|error| error.to_string())
        };
        assert_eq!(read(&written).unwrap(), table);
        assert_eq!(table.outputs(), 1);
        // Whether a variable varies is found anew.
        let mut flags = written.clone();
        flags["variables"][0][1] = false.into();
        assert_eq!(read(&flags).unwrap(), table);
        let single = self::table(&[(&[1.0, 2.0], None)], 1, Extrapolation::Constant);
        let mut flags = serde_json::to_value(&single).unwrap();
        flags["variables"][0][1] = true.into();
        assert_eq!(read(&flags).unwrap(), single);
        let spoiled = |path: &str, value: serde_json::Value| {
            let mut spoiled = written.clone();
            *spoiled.pointer_mut(path).unwrap() = value;
            read(&spoiled).unwrap_err()
        };
        let inner = "/root/Along/blocks/1/Along";
        let json = |text: &str| serde_json::from_str::<serde_json::Value>(text).unwrap();
        for (path, value, why) in [
            ("/root/Along/at", "[1.0, 1.0]", "do not increase"),
            ("/root/Along/at", "[3.0, 1.0]", "do not increase"),
            ("/root/Along/at", "[1.0]", "a table has 1 values of a variable for 2 rows"),
            ("/root/Along/blocks", "[]", "a table has 2 values of a variable for 0 rows"),
            (
                "/root",
                r#"{"Along": {"at": [], "blocks": []}}"#,
                "a table has 0 values of a variable for 0 rows",
            ),
            (&format!("{inner}/blocks/0"), r#"{"Values": []}"#, "no dependent value"),
            (
                &format!("{inner}/blocks/2"),
                r#"{"Values": [1.0, 2.0]}"#,
                "different numbers of dependent values",
            ),
            (&format!("{inner}/blocks/2"), r#"{"Along": {"at": [1.0], "blocks": [{"Values": [1.0]}]}}"#, ""),
            ("/root", r#"{"Values": [1.0]}"#, ""),
        ] {
            let error = spoiled(path, json(value));
            assert!(error.contains(why), "{path} {value}: {error}");
        }
        assert_eq!(Block::Values(vec![1.0, 2.0, 3.0]).outputs(0), Ok(3));
        for x in [f64::NAN, f64::INFINITY] {
            assert!(Block::Values(vec![1.0, x]).outputs(0).is_err());
            let one = || Block::Values(vec![1.0]);
            assert!(Block::Along { at: vec![x], blocks: vec![one()] }.outputs(1).is_err());
            assert!(Block::Along { at: vec![1.0, x], blocks: vec![one(), one()] }.outputs(1).is_err());
        }
    }
}
