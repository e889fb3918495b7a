//! P, F_C, F_N and Φ at given forces, with first and second derivatives.

use crate::case::failing::FrictionCase;
use crate::case::quantity::Quantity;
use crate::friction::{Judged, group_sizes, reach};
use crate::judge::slopes::{Argument, Output, Slopes};
use crate::judge::table::{Entry, ResultTable};
use crate::mutants::mutant::{Mistake, Mutant};
use crate::oracles::differences::{FIRST_STEP, SECOND_STEP};
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use pintle_kinematics::catalog::FORCE;
use pintle_kinematics::scalar::{Real, Wide};
use pintle_model::behavior::friction::{Criterion, Derivatives, Frictional, Point, Tangential};

/// What is judged of a criterion, by name.
pub(super) const PARTS: [&str; 4] = ["P", "F_C", "F_N", "Φ"];

/// Of which parts each is formed: Φ is a difference, and what counts is what it is formed from.
pub(super) const FORMED: [&[usize]; 4] = [&[0], &[1], &[1, 2], &[0, 2]];

/// The parts in their order.
pub(super) fn parts<T>(point: Point<T>) -> [T; 4] {
    let Point { tangential, contact, normal, criterion } = point;
    [tangential, contact, normal, criterion]
}

/// The sum of the magnitudes of what each part is formed from.
pub(super) fn magnitudes(values: &[f64; 4]) -> Vec<f64> {
    FORMED.iter().map(|of| of.iter().map(|part| values[*part].abs()).sum()).collect()
}

impl FrictionCase {
    pub(super) fn derivatives<R: Frictional>(
        &self,
        criterion: &Criterion,
        forces: &[R; 6],
    ) -> [Derivatives<R>; 4] {
        let coefficient = R::from_f64(self.coefficient);
        parts(criterion.derivatives(forces, coefficient, self.friction.maximum, &self.context()).0)
    }

    fn values<R: Frictional>(&self, forces: &[R; 6]) -> [R; 4] {
        let coefficient = R::from_f64(self.coefficient);
        let at = self.friction.criterion.at(forces, coefficient, self.friction.maximum, &self.context());
        parts(at.0)
    }

    /// P, F_C, F_N and Φ.
    pub(super) fn part_values(&self) -> [f64; 4] {
        self.values(&self.point)
    }

    /// The shift of a potential: P is formed from numbers as large as that.
    pub(super) fn shift(&self) -> f64 {
        match &self.friction.criterion.tangential {
            Tangential::Potential(potential) => potential.shift(),
            Tangential::Norm(_) => 0.0,
        }
    }

    /// A traction is added to the shift of a potential, and rounded as that is.
    fn beside_shift(&self) -> Vec<f64> {
        let mut found = vec![0.0; 6];
        for (k, radius) in self.friction.radii() {
            found[k] = self.shift() * radius;
        }
        found
    }

    /// The sizes of tractions, and of what presses.
    fn point_sizes(&self) -> [f64; 6] {
        let sliding = self.friction.criterion.tangential.components();
        group_sizes(&self.point, [0, 1, 2, 3, 4, 5].map(|k| sliding.contains(&k)), self.length)
    }

    /// The forces after some have moved.
    fn moved<R: Real>(&self, moved: &[(usize, R)]) -> [R; 6] {
        let mut forces = self.point.map(R::from_f64);
        moved.iter().for_each(|(k, h)| forces[*k] = forces[*k] + *h);
        forces
    }

    /// How far the forces are from what kinks of norms and magnitudes they are not on, in their sizes: those lie where forces are zero.
    fn clear(&self, sizes: &[f64; 6]) -> f64 {
        let others = self.point.iter().zip(sizes).filter(|(force, _)| **force != 0.0);
        others.map(|(force, size)| force.abs() / size).fold(1.0, f64::min)
    }

    /// Which entries of the gradients must show a relative error of a billionth, by the forces and the product's numbers alone. No
    /// force may be small beside others and not zero. An entry counts that is at least a thousandth of value over force, and that
    /// bends by no more than thirty of that. Where what is formed vanishes, as F_C beside F_C^int, its value says nothing of its
    /// rounding. The entries are then a ten-thousandth at least of what all forces make of it, of whatever size they are.
    fn demanded(&self, got: &[Derivatives<f64>; 4], sizes: &[f64; 6]) -> Vec<Vec<bool>> {
        const PLAIN: f64 = 0.05;
        let is_plain = self.clear(sizes) >= PLAIN && self.shift() == 0.0;
        let values = magnitudes(&got.map(|part| part.value));
        let of = |p: usize, j: usize| {
            let usual = values[p] / sizes[j];
            let bent: f64 =
                got[p].hessian[j].iter().zip(self.point).map(|(bent, force)| (bent * force).abs()).sum();
            let all: f64 = got[p].gradient.iter().zip(sizes).map(|(slope, size)| (slope * size).abs()).sum();
            let formed = (values[p] + all) / sizes[j];
            let slope = got[p].gradient[j].abs();
            is_plain && slope >= 1e-3 * usual && slope >= 1e-4 * formed && bent <= 30.0 * usual
        };
        (0..4).map(|p| (0..6).map(|j| of(p, j)).collect()).collect()
    }

    /// The forces at the point, which are given, and rounded so.
    fn inputs(&self, sizes: &[f64; 6]) -> Vec<Argument> {
        let (reach, beside) = (reach(&self.point, sizes), self.beside_shift());
        let mut inputs = Argument::list(&FORCE, sizes, &reach, |_| 0.0);
        for (j, input) in inputs.iter_mut().enumerate() {
            input.rounded = self.point[j].abs() + beside[j];
        }
        inputs
    }

    pub(super) fn criterion_tables(&self, settings: &Settings, wide: bool) -> Vec<Judged> {
        let criterion = &self.friction.criterion;
        let sizes = self.point_sizes();
        let mistaken = criterion.factor_mistakes().into_iter();
        let mistaken = mistaken
            .map(|(mistake, criterion)| (Mistake::from(mistake), self.derivatives(&criterion, &self.point)));
        let parts = Parts {
            of: self,
            title: &self.title,
            inputs: self.inputs(&sizes),
            of_a_unit: 3,
            shift: self.shift(),
            clear: self.clear(&sizes),
            demanded: self.demanded(&self.derivatives(criterion, &self.point), &sizes),
            mistaken: mistaken.collect(),
        };
        parts.tables(settings, wide)
    }
}

impl Pressed for FrictionCase {
    fn parts<R: Frictional>(&self, moved: &[(usize, R)]) -> [R; 4] {
        self.values(&self.moved(moved))
    }

    fn differentiated<R: Frictional>(&self, moved: &[(usize, R)]) -> [Derivatives<R>; 4] {
        self.derivatives(&self.friction.criterion, &self.moved(moved))
    }
}

/// What has P, F_C, F_N and Φ: functions of forces, or of tensions and an angle.
pub(super) trait Pressed {
    /// The parts where some of these have moved.
    fn parts<R: Frictional>(&self, moved: &[(usize, R)]) -> [R; 4];

    /// The same with their derivatives.
    fn differentiated<R: Frictional>(&self, moved: &[(usize, R)]) -> [Derivatives<R>; 4];
}

/// The gradients of the parts by so many numbers.
fn gradients<R: Copy>(of: &[Derivatives<R>; 4], n: usize) -> Vec<Vec<R>> {
    of.iter().map(|part| part.gradient[..n].to_vec()).collect()
}

/// The rows of the Hessians of some parts.
fn hessians<R: Copy>(of: &[Derivatives<R>; 4], smooth: &[usize], n: usize) -> Vec<Vec<R>> {
    smooth.iter().flat_map(|p| of[*p].hessian[..n].iter().map(|row| row[..n].to_vec())).collect()
}

/// P, F_C, F_N and Φ with what is known of them.
pub(super) struct Parts<'a, P> {
    pub(super) of: &'a P,
    /// What follows their names.
    pub(super) title: &'a str,
    pub(super) inputs: Vec<Argument>,
    /// So many inputs, from the first on, have one unit.
    pub(super) of_a_unit: usize,
    /// P, and Φ = P − limit, are formed beside it.
    pub(super) shift: f64,
    /// How far kinks are that they are not on, in sizes.
    pub(super) clear: f64,
    /// Which entries of the gradients must show a relative error of a billionth.
    pub(super) demanded: Vec<Vec<bool>>,
    /// The same with a mistake in them.
    pub(super) mistaken: Vec<(Mistake, [Derivatives<f64>; 4])>,
}

impl<P: Pressed> Parts<'_, P> {
    /// The tables of values, gradients and Hessians.
    pub(super) fn tables(self, settings: &Settings, wide: bool) -> Vec<Judged> {
        let Self { of, inputs, of_a_unit: unit, mistaken, .. } = self;
        let n = inputs.len();
        let got = of.differentiated(&[]);
        let values = got.map(|part| part.value);
        let mut magnitudes = magnitudes(&values);
        [0, 3].into_iter().for_each(|part| magnitudes[part] += self.shift);
        let named = |part: &str| format!("{part}{}", self.title);
        let slopes = Slopes {
            quantity: Quantity::FrictionGradient,
            outputs: Output::list((0..4).map(|p| (named(PARTS[p]), magnitudes[p], p))),
            inputs: inputs.clone(),
            matrices: None,
            demanded: self.demanded,
            class: &|_, j| (0, j / unit, 0),
            got: gradients(&got, n),
            step: FIRST_STEP * self.clear,
            wide: Box::new(|k, h| of.parts(&[(k, h)]).to_vec()),
            narrow: Box::new(|k, h| of.parts(&[(k, h)]).to_vec()),
            slopes: Box::new(|k, h| gradients(&of.differentiated(&[(k, h)]), n)),
            dual: Box::new(|| gradients(&of.differentiated::<Wide>(&[]), n)),
            mistaken: mistaken.iter().map(|(mistake, wrong)| (*mistake, gradients(wrong, n))).collect(),
            held: None,
        };
        let scales = slopes.value_scales();
        let mut tables = slopes.tables(settings, wide);
        // Where a part has a kink along some number, it has no second derivatives.
        let are_smooth = slopes.are_smooth();
        let smooth: Vec<usize> = (0..4).filter(|p| are_smooth[*p]).collect();
        let output = |(i, (p, input)): (usize, (usize, &Argument))| {
            (format!("²{}/∂{}", named(PARTS[p]), input.name), scales[p] / input.size, i)
        };
        let all = smooth.iter().flat_map(|p| inputs.iter().map(|input| (*p, input))).enumerate();
        let step = SECOND_STEP * self.clear.sqrt();
        // The gradients by differences.
        let differenced = |l: usize, h: Wide| -> Vec<Wide> {
            let along = |(k, input): (usize, &Argument)| {
                let g = Wide::from_f64(step * input.size);
                let [plus, minus] = [g, -g].map(|g| of.parts(&[(l, h), (k, g)]));
                [0, 1, 2, 3].map(|p| (plus[p] - minus[p]) / (g + g))
            };
            let slopes: Vec<[Wide; 4]> = inputs.iter().enumerate().map(along).collect();
            smooth.iter().flat_map(|p| slopes.iter().map(|of| of[*p])).collect()
        };
        let slopes = Slopes {
            quantity: Quantity::FrictionHessian,
            outputs: Output::list(all.map(output)),
            inputs: inputs.clone(),
            matrices: Some(smooth.iter().map(|p| named(&format!("∂²{}", PARTS[*p]))).collect()),
            demanded: Vec::new(),
            class: &|i, j| (0, i % n / unit, j / unit),
            got: hessians(&got, &smooth, n),
            step,
            wide: Box::new(differenced),
            narrow: Box::new(|l, h| {
                let found = gradients(&of.differentiated(&[(l, h)]), n);
                smooth.iter().flat_map(|p| found[*p].iter().copied()).collect()
            }),
            slopes: Box::new(|l, h| hessians(&of.differentiated(&[(l, h)]), &smooth, n)),
            dual: Box::new(|| hessians(&of.differentiated::<Wide>(&[]), &smooth, n)),
            mistaken: mistaken
                .iter()
                .map(|(mistake, wrong)| (*mistake, hessians(wrong, &smooth, n)))
                .collect(),
            held: None,
        };
        tables.extend(slopes.tables(settings, wide));
        if wide && settings.oracles.contains(&Oracle::WideDifferences) {
            let want = of.parts::<Wide>(&[]);
            let entry = |p: usize| Entry::new(named(PARTS[p]), values[p], want[p], scales[p], (0, 0, 0));
            let mut table = ResultTable::new(Quantity::FrictionCriterion);
            table.rows = PARTS.map(named).to_vec();
            table.entries = (0..4).map(entry).collect();
            let of = |(mistake, wrong): &(Mistake, [Derivatives<f64>; 4])| {
                Mutant::many(*mistake, wrong.iter().enumerate().map(|(p, part)| (p, 0, part.value)))
            };
            table.mistakes = mistaken.iter().map(of).collect();
            tables.push((Oracle::WideDifferences, table));
        }
        tables
    }
}
