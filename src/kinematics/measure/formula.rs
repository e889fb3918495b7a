//! Which measures are evaluated together: compiled apart for each such formula, so that it computes what its measures need and
//! nothing else.

use crate::measure::{Measure, Shared};
use crate::node::Dependence;
use crate::scalar::Scalar;

/// M measures that are evaluated together.
pub(crate) trait Formula<const M: usize> {
    /// The measures.
    const MEASURES: [Measure; M];

    /// What any of them depends on.
    const NEEDED: Dependence;

    /// Their principal values.
    fn evaluate<S: Scalar>(shared: &mut Shared<'_, S>) -> [S; M];
}

/// Something to be done for a formula.
pub(crate) trait Task {
    fn run<F: Formula<M>, const M: usize>(self);
}

/// The number of a formula, and the row of each of its measures; `usize::MAX` of those not wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pass {
    number: usize,
    pub(crate) rows: [usize; 3],
}

/// What no measure depends on.
const NOTHING: Dependence = Dependence { translation: false, rotation: false, flow: false };

macro_rules! formulas {
    ($($module:ident: $count:literal: $($measure:ident $(($($index:literal),+))? by $method:ident),+;)*) => {
        /// The measures of each formula. What stands first is preferred: longer formulas share more.
        const FORMULAS: &[&[Measure]] = &[$(&[$(formulas!(@measure $measure $($($index)+)?)),+]),*];

        // Each in a module, which is what the compiler makes units of, and works on side by side.
        $(mod $module {
            use super::{Dependence, Formula, Measure, NOTHING, Scalar, Shared};

            pub(super) struct Evaluated;

            impl Formula<$count> for Evaluated {
                const MEASURES: [Measure; $count] = [$(formulas!(@measure $measure $($($index)+)?)),+];
                const NEEDED: Dependence =
                    NOTHING$(.or(formulas!(@measure $measure $($($index)+)?).dependence()))+;

                #[inline(always)]
                fn evaluate<S: Scalar>(shared: &mut Shared<'_, S>) -> [S; $count] {
                    [$(shared.$method($($($index),+)?)),+]
                }
            }
        })*

        impl Pass {
            /// Does a task for the formula of this pass.
            #[inline(always)]
            pub(crate) fn dispatch(&self, task: impl Task) {
                let mut number = 0;
                $(
                    if self.number == number {
                        return task.run::<$module::Evaluated, $count>();
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

/// The passes that compute `measures`, and the rows that none computes: first formulas that are wanted whole, then each that computes
/// one of those that are left.
pub(crate) fn cover(measures: &[Measure]) -> (Vec<Pass>, Vec<usize>) {
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
    (passes, left.into_iter().map(|(row, _)| row).collect())
}

/// The pass that computes one measure and no other, for the row given.
pub(crate) fn alone(measure: Measure, row: usize) -> Option<Pass> {
    let number = FORMULAS.iter().position(|formula| *formula == [measure.as_function()])?;
    Some(Pass { number, rows: [row, usize::MAX, usize::MAX] })
}

#[cfg(test)]
mod tests {
    use super::Measure::{self, Cardan, Cosine, Position, PositionAtB, RotationVector};
    use super::{FORMULAS, Pass, alone, cover};

    const NONE: usize = usize::MAX;

    fn told(pass: Pass) -> (&'static [Measure], [usize; 3]) {
        (FORMULAS[pass.number], pass.rows)
    }

    /// What is wanted whole goes first, wherever its rows stand; then formulas of which a part is wanted.
    #[test]
    fn measures_are_covered_by_few_formulas() {
        let of = |measures: &[Measure]| {
            let (passes, left) = cover(measures);
            assert!(left.is_empty(), "{measures:?}: {left:?}");
            passes.into_iter().map(told).collect::<Vec<_>>()
        };
        let cross: &[Measure] = &[Cardan(1), Cosine(1, 3), Cosine(1, 2)];
        assert_eq!(of(&[Cosine(1, 3), Cardan(1), Cosine(1, 2)]), [(cross, [1, 0, 2])]);
        assert_eq!(of(&[Cardan(2)]), [(&[Cardan(2)] as &[_], [0, NONE, NONE])]);
        let all: &[Measure] = &[Position(1), Position(2), Position(3)];
        assert_eq!(of(&[PositionAtB(3), Position(1), Position(2)]), [(all, [1, 2, 0])]);
        let mixed = of(&[Cardan(3), RotationVector(2)]);
        assert_eq!(
            mixed.iter().map(|(_, rows)| rows.iter().filter(|row| **row != NONE).count()).sum::<usize>(),
            2
        );
        for formula in FORMULAS {
            let [part, ..] = formula else { panic!("an empty formula") };
            let passes = of(&[*part]);
            assert!(passes.len() == 1 && passes[0].0.contains(part), "{part:?}: {passes:?}");
        }
    }

    #[test]
    fn one_measure_has_a_formula_of_its_own() {
        let pass = alone(Cardan(2), 5).map(told);
        assert_eq!(pass, Some((&[Cardan(2)] as &[_], [5, NONE, NONE])));
        for formula in FORMULAS {
            for one in *formula {
                let pass = alone(*one, 0);
                assert!(pass.is_none_or(|pass| FORMULAS[pass.number] == [*one]), "{one:?}");
            }
        }
    }

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
