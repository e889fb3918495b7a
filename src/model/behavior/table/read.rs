//! Tables from rows of a deck, and from what a saved scene holds: what is no table is refused.

use crate::behavior::table::{Block, Table, Variable};
use pintle_scene::{Code, Diagnostic, Extrapolation, Span, TableRow};

/// A table as a file has it, which may be of any shape.
#[derive(serde::Deserialize)]
pub(super) struct Written {
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
    pub(super) fn outputs(&self, levels: usize) -> Result<usize, String> {
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
    /// - [`Code::TableOrder`] at the row that does not follow the one before, or stands twice;
    /// - [`Code::MissingData`] at a row that leaves open what others give;
    /// - [`Code::NumberOutOfRange`] at a row so near to the one before, or so much higher, that the slope between them is no
    ///   double.
    pub fn new(
        rows: &[TableRow],
        outputs: usize,
        columns: &[&str],
        extrapolation: Extrapolation,
    ) -> Result<Self, Diagnostic> {
        let fields = rows.iter().map(|row| row.fields.len()).max().unwrap_or(0);
        let all = (0..columns.len())
            .map(Variable::Column)
            .chain(std::iter::once(Variable::Temperature))
            .chain((0..fields).map(Variable::Field));
        let given = |row: &TableRow, variable| match variable {
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
        let row = |(x, y): &(f64, f64)| TableRow { values: vec![Some(*y), Some(*x)], ..TableRow::default() };
        let rows: Vec<TableRow> = points.iter().map(row).collect();
        Self::new(&rows, 1, &["the abscissa"], extrapolation)
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
