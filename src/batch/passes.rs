//! Which measures one loop evaluates: compiled apart for each, so that a loop computes what its measures need and nothing else.

use crate::measure::{Measure, Shared};
use crate::scalar::Scalar;

/// M measures that are evaluated in one loop.
pub(super) trait Formula<const M: usize> {
    /// The measures.
    const MEASURES: [Measure; M];

    /// Their principal values.
    fn evaluate<S: Scalar>(shared: &mut Shared<'_, S>) -> [S; M];
}

/// Something to be done for a formula.
pub(super) trait Task {
    fn run<F: Formula<M>, const M: usize>(self);
}

/// One loop over tiles: the number of its formula, and the row of each of its measures.
#[derive(Clone, Debug)]
pub(super) struct Pass {
    number: usize,
    pub(super) rows: [usize; 3],
}

macro_rules! formulas {
    ($($count:literal: $($measure:ident($($index:literal),*) by $method:ident),+;)*) => {
        /// The measures of each formula; those with more measures come first.
        const FORMULAS: &[&[Measure]] = &[$(&[$(formulas!(@measure $measure $($index)*)),+]),*];

        impl Pass {
            /// Does a task for the formula of this pass.
            #[inline(always)]
            pub(super) fn dispatch(&self, task: impl Task) {
                let mut number = 0;
                $({
                    struct Evaluated;

                    impl Formula<$count> for Evaluated {
                        const MEASURES: [Measure; $count] = [$(formulas!(@measure $measure $($index)*)),+];

                        #[inline(always)]
                        fn evaluate<S: Scalar>(shared: &mut Shared<'_, S>) -> [S; $count] {
                            [$(shared.$method($($index),*)),+]
                        }
                    }

                    if self.number == number {
                        return task.run::<Evaluated, $count>();
                    }
                    number += 1;
                })*
                let _ = number;
            }
        }
    };
    (@measure $measure:ident) => { Measure::$measure };
    (@measure $measure:ident $($index:literal)+) => { Measure::$measure($($index),+) };
}

formulas! {
    3: RotationVector(1) by rotation, RotationVector(2) by rotation, RotationVector(3) by rotation;
    3: Misalignment(1) by misaligned, Misalignment(2) by misaligned, Misalignment(3) by misaligned;
    3: Position(1) by coordinate, Position(2) by coordinate, Position(3) by coordinate;
}

/// The passes that compute `measures`: of each formula that computes some of them, those with the most first.
pub(super) fn cover(measures: &[Measure]) -> Vec<Pass> {
    let mut left: Vec<(usize, Measure)> =
        measures.iter().copied().map(Measure::as_function).enumerate().collect();
    let mut passes = Vec::new();
    for (number, formula) in FORMULAS.iter().enumerate() {
        let row_of = |measure: &Measure| left.iter().find(|(_, one)| one == measure).map(|(row, _)| *row);
        let rows: Vec<usize> = formula.iter().filter_map(row_of).collect();
        if rows.len() < formula.len() {
            continue;
        }
        left.retain(|(row, _)| !rows.contains(row));
        let mut pass = Pass { number, rows: [0; 3] };
        for (slot, row) in pass.rows.iter_mut().zip(rows) {
            *slot = row;
        }
        passes.push(pass);
    }
    passes
}
