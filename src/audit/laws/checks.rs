//! Laws asked of numbers at a state: the checks that they make, and how mutants of the numbers fare.

use crate::case::Case;
use crate::case::quantity::Quantity;
use crate::judge::outcome::{Against, Check};
use crate::judge::table::ResultTable;
use crate::judge::verdict::Score;
use crate::laws::{Asked, Demand, Invariant, Related, try_mutants};
use crate::mutants::mutant::Mutant;
use std::collections::HashSet;

/// Asks laws that demand something; `score` says how mutants fared.
pub(crate) fn checks(
    laws: &[Invariant],
    numbers: &impl Related,
    (state, case): (&str, Option<&Case>),
    demands: impl Fn(Invariant) -> Vec<Demand>,
    score: impl Fn(Invariant, &Asked) -> Score,
) -> Vec<Check> {
    let asked = |law: &Invariant| {
        let all = demands(*law);
        if all.is_empty() {
            return None;
        }
        let asked = Asked::of(numbers, all);
        let score = score(*law, &asked);
        let mut check = Check::new(None, Against::Law(*law));
        check.add_decided(asked.judgement, score, state, case);
        Some(check)
    };
    laws.iter().filter_map(asked).collect()
}

/// Numbers by kind and row: of a constraint, whose rows are equations, or of a relation.
#[derive(Default)]
pub(crate) struct ByRow([Vec<Vec<f64>>; Quantity::ALL.len()]);

impl ByRow {
    /// Numbers of these kinds, of each row.
    pub(crate) fn of<const N: usize>(
        kinds: [Quantity; N],
        rows: impl IntoIterator<Item = (usize, [Vec<f64>; N])>,
    ) -> Self {
        let mut found = Self::default();
        for (row, numbers) in rows {
            for (quantity, numbers) in kinds.into_iter().zip(numbers) {
                let of_kind = &mut found.0[quantity as usize];
                of_kind.resize_with(of_kind.len().max(row + 1), Vec::new);
                of_kind[row] = numbers;
            }
        }
        found
    }

    /// One number; none is not a number.
    pub(crate) fn at(&self, quantity: Quantity, row: usize, place: usize) -> f64 {
        self.number(quantity, row, place).unwrap_or(f64::NAN)
    }

    /// Changes a number, where it is.
    pub(crate) fn put(&mut self, quantity: Quantity, row: usize, place: usize, x: f64) {
        let rows = self.0.get_mut(quantity as usize).and_then(|rows| rows.get_mut(row));
        rows.and_then(|row| row.get_mut(place)).into_iter().for_each(|number| *number = x);
    }
}

impl Related for ByRow {
    fn row(&self, quantity: Quantity, row: usize) -> &[f64] {
        self.0.get(quantity as usize).and_then(|rows| rows.get(row)).map_or(&[], Vec::as_slice)
    }
}

/// Asks laws of numbers that stand in tables, too, with mutants of these where it `proves`.
///
/// - `place` says which number, by row and place, an entry of a table is: none where no mutant is made of it.
/// - `size` is the unit of the degrees of freedom of a number.
pub(crate) fn checks_of_tables(
    laws: &[Invariant],
    (numbers, tables): (&ByRow, &[ResultTable]),
    (state, proves): (&str, bool),
    demands: impl Fn(Invariant) -> Vec<Demand>,
    place: impl Fn(Quantity, usize, usize) -> Option<(usize, usize)>,
    size: impl Fn(Quantity, usize) -> f64,
) -> Vec<Check> {
    let (mut made, mut demanded) = (Vec::new(), HashSet::new());
    for table in tables.iter().filter(|_| proves) {
        let (quantity, width) = (table.quantity, table.width());
        let mutant = |mut made: Mutant| {
            for (row, i, _) in made.changes.iter_mut() {
                (*row, *i) = place(quantity, *row, *i)?;
            }
            Some(made)
        };
        made.push((quantity, table.all_mistakes().into_iter().filter_map(mutant).collect::<Vec<_>>()));
        let all = table.entries.iter().enumerate().filter(|(_, entry)| entry.is_demanded);
        let at = |(i, _): (usize, &_)| place(quantity, i / width, i % width);
        demanded.extend(all.filter_map(at).map(|(row, place)| (quantity, row, place)));
    }
    let is_demanded = |quantity, row, place, _: f64| demanded.contains(&(quantity, row, place));
    let score = |_: Invariant, asked: &Asked| {
        let mut score = Score::default();
        for (quantity, made) in &made {
            score.merge(try_mutants(*quantity, numbers, &asked.demands, made, (&size, &is_demanded)));
        }
        score
    };
    checks(laws, numbers, (state, None), demands, score)
}
