//! Which measures one loop evaluates: compiled apart for each, so that a loop computes what its measures need and nothing else.

use crate::measure::{Measure, Shared};
use crate::scalar::Scalar;

/// M measures that are evaluated in one loop.
pub(super) trait Formula<const M: usize>: Sized {
    /// The measures.
    const MEASURES: [Measure; M];

    /// Their principal values.
    fn evaluate<S: Scalar>(shared: &mut Shared<'_, S>) -> [S; M];

    /// Does a task for this formula, as a function of its own: the compiler puts it into the unit of the module that the formula
    /// stands in, and works on units side by side. One function for all formulas takes it more than 25 minutes.
    #[inline(never)]
    fn apart(task: impl Task) {
        task.run::<Self, M>();
    }
}

/// Something to be done for a formula.
pub(super) trait Task {
    fn run<F: Formula<M>, const M: usize>(self);
}

/// One loop over tiles: the number of its formula, and the row of each of its measures; `usize::MAX` of those not wanted.
#[derive(Clone, Debug)]
pub(super) struct Pass {
    number: usize,
    pub(super) rows: [usize; 3],
}

macro_rules! formulas {
    ($($module:ident: $count:literal: $($measure:ident $(($($index:literal),+))? by $method:ident),+;)*) => {
        /// The measures of each formula. What stands first is preferred: longer formulas share more.
        const FORMULAS: &[&[Measure]] = &[$(&[$(formulas!(@measure $measure $($($index)+)?)),+]),*];

        $(mod $module {
            use super::{Formula, Measure, Scalar, Shared};

            pub(super) struct Evaluated;

            impl Formula<$count> for Evaluated {
                const MEASURES: [Measure; $count] = [$(formulas!(@measure $measure $($($index)+)?)),+];

                #[inline(always)]
                fn evaluate<S: Scalar>(shared: &mut Shared<'_, S>) -> [S; $count] {
                    [$(shared.$method($($($index),+)?)),+]
                }
            }
        })*

        impl Pass {
            /// Does a task for the formula of this pass.
            #[inline]
            pub(super) fn dispatch(&self, task: impl Task) {
                let mut number = 0;
                $(
                    if self.number == number {
                        return $module::Evaluated::apart(task);
                    }
                    number += 1;
                )*
                let _ = number;
            }
        }
    };
    (@measure $measure:ident) => { Measure::$measure };
    (@measure $measure:ident $($index:literal)+) => { Measure::$measure($($index),+) };
}

formulas! {
    rotation_vector: 3: RotationVector(1) by rotation, RotationVector(2) by rotation, RotationVector(3) by rotation;
    misalignment: 3: Misalignment(1) by misaligned, Misalignment(2) by misaligned, Misalignment(3) by misaligned;
    projected_position: 3: ProjectedPosition(1) by projected, ProjectedPosition(2) by projected, ProjectedPosition(3) by projected;
    component_flexion: 2: ComponentFlexion(1) by component_flexion, ComponentFlexion(2) by component_flexion;
    position: 3: Position(1) by coordinate, Position(2) by coordinate, Position(3) by coordinate;
    distance: 1: Distance by distance;
    radial_distance: 1: RadialDistance by radius;
    cardan: 3: Cardan(1) by cardan, Cardan(2) by cardan, Cardan(3) by cardan;
    cardan_and_cosines: 3: Cardan(1) by cardan, Cosine(1, 3) by cosine, Cosine(1, 2) by cosine;
    cosine_12: 1: Cosine(1, 2) by cosine;
    cosine_13: 1: Cosine(1, 3) by cosine;
    cardan_1: 1: Cardan(1) by cardan;
    cardan_2: 1: Cardan(2) by cardan;
    cardan_3: 1: Cardan(3) by cardan;
    euler_1: 1: Euler(1) by euler;
    euler_2: 1: Euler(2) by euler;
    euler_3: 1: Euler(3) by euler;
    flexion: 1: Flexion by flexion;
    torsion: 1: Torsion by torsion;
    sweep: 1: Sweep by sweep;
}

/// The passes that compute `measures`, or the row of one that none computes: first formulas that are wanted whole, then each that
/// computes one of those that are left.
pub(super) fn cover(measures: &[Measure]) -> Result<Vec<Pass>, usize> {
    let mut left: Vec<(usize, Measure)> =
        measures.iter().copied().map(Measure::as_function).enumerate().collect();
    let mut passes = Vec::new();
    for whole in [true, false] {
        for (number, formula) in FORMULAS.iter().enumerate() {
            let mut pass = Pass { number, rows: [usize::MAX; 3] };
            let mut found = 0;
            for (slot, measure) in pass.rows.iter_mut().zip(*formula) {
                if let Some((row, _)) = left.iter().find(|(_, one)| one == measure) {
                    *slot = *row;
                    found += 1;
                }
            }
            if found == 0 || whole && found < formula.len() {
                continue;
            }
            left.retain(|(row, _)| !pass.rows.contains(row));
            passes.push(pass);
        }
    }
    match left.first() {
        Some((row, _)) => Err(*row),
        None => Ok(passes),
    }
}

#[cfg(test)]
mod tests {
    use super::FORMULAS;

    /// A formula that stands before one of which it is a part would take its measures away from it.
    #[test]
    fn longer_formulas_are_preferred() {
        for (i, formula) in FORMULAS.iter().enumerate() {
            for before in FORMULAS.iter().take(i) {
                assert!(!before.iter().all(|one| formula.contains(one)), "{before:?} before {formula:?}");
            }
        }
    }
}
