//! P, F_C, F_N and Φ at given forces, with first and second derivatives.

use crate::case::failing::FrictionCase;
use crate::case::quantity::Quantity;
use crate::friction::{Judged, group_sizes, reach};
use crate::judge::slopes::{Argument, Output, Slopes};
use crate::judge::table::{Change, Entry, ResultTable};
use crate::mutants::mutant::Mistake;
use crate::oracles::differences::{FIRST_STEP, SECOND_STEP};
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use pintle_kinematics::catalog::FORCE;
use pintle_kinematics::scalar::{Real, Scalar, Wide};
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

    fn part_magnitudes(&self, values: &[f64; 4]) -> Vec<f64> {
        let mut found = magnitudes(values);
        // P, and Φ = P − limit.
        [0, 3].into_iter().for_each(|part| found[part] += self.shift());
        found
    }

    /// The forces after one has moved.
    fn moved<R: Real>(&self, k: usize, h: R) -> [R; 6] {
        let mut forces = self.point.map(R::from_f64);
        forces[k] = forces[k] + h;
        forces
    }

    /// How far the forces are from what kinks of norms and magnitudes they are not on, in their sizes: those lie where forces are zero.
    fn clear(&self, sizes: &[f64; 6]) -> f64 {
        let others = self.point.iter().zip(sizes).filter(|(force, _)| **force != 0.0);
        others.map(|(force, size)| force.abs() / size).fold(1.0, f64::min)
    }

    /// The step of second differences, in sizes.
    fn second_step(&self, sizes: &[f64; 6]) -> f64 {
        SECOND_STEP * self.clear(sizes).sqrt()
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

    /// The gradients of the parts by differences.
    fn gradients(&self, at: &[Wide; 6], sizes: &[f64; 6]) -> [[Wide; 6]; 4] {
        let mut found = [[Wide::zero(); 6]; 4];
        let step = self.second_step(sizes);
        for k in 0..6 {
            let h = Wide::from_f64(step * sizes[k]);
            let along = |h: Wide| {
                let mut forces = *at;
                forces[k] += h;
                self.values(&forces)
            };
            let (plus, minus) = (along(h), along(-h));
            for p in 0..4 {
                found[p][k] = (plus[p] - minus[p]) / (h + h);
            }
        }
        found
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
        let got = self.derivatives(criterion, &self.point);
        let mistaken: Vec<(Mistake, [Derivatives<f64>; 4])> = criterion
            .factor_mistakes()
            .into_iter()
            .map(|(mistake, criterion)| (Mistake::from(mistake), self.derivatives(&criterion, &self.point)))
            .collect();
        let named = |part: &str| format!("{part}{}", self.title);
        let magnitudes = self.part_magnitudes(&got.map(|part| part.value));
        let values = got.map(|part| part.value);
        let gradient_of = |all: &[Derivatives<f64>; 4]| -> Vec<Vec<f64>> {
            all.iter().map(|part| part.gradient.to_vec()).collect()
        };
        let gradients = Slopes {
            quantity: Quantity::FrictionGradient,
            outputs: Output::list((0..4).map(|p| (named(PARTS[p]), magnitudes[p], p))),
            inputs: self.inputs(&sizes),
            matrices: None,
            demanded: self.demanded(&got, &sizes),
            class: |_, j| (0, j / 3, 0),
            got: gradient_of(&got),
            step: FIRST_STEP * self.clear(&sizes),
            wide: Box::new(|k, h| self.values(&self.moved(k, h)).to_vec()),
            narrow: Box::new(|k, h| self.values(&self.moved(k, h)).to_vec()),
            slopes: Box::new(move |k, h| gradient_of(&self.derivatives(criterion, &self.moved(k, h)))),
            dual: Box::new(|| {
                let all = self.derivatives(criterion, &self.point.map(Wide::from_f64));
                all.iter().map(|part| part.gradient.to_vec()).collect()
            }),
            mistaken: mistaken.iter().map(|(mistake, wrong)| (*mistake, gradient_of(wrong))).collect(),
            held: None,
        };
        let scales = gradients.value_scales();
        let mut tables = gradients.tables(settings, wide);
        // Where a part has a kink along some force, it has no second derivatives.
        let are_smooth = gradients.are_smooth();
        let smooth: Vec<usize> = (0..4).filter(|p| are_smooth[*p]).collect();
        tables.extend(self.hessian_tables(settings, wide, &smooth, &got, &mistaken, &scales));
        if wide && settings.oracles.contains(&Oracle::WideDifferences) {
            let want = self.values(&self.point.map(Wide::from_f64));
            let entry = |p: usize| Entry::new(named(PARTS[p]), values[p], want[p], scales[p], (0, 0, 0));
            let mut table = ResultTable::new(Quantity::FrictionCriterion);
            table.rows = PARTS.map(named).to_vec();
            table.entries = (0..4).map(entry).collect();
            let of = |(mistake, wrong): &(Mistake, [Derivatives<f64>; 4])| Change {
                mistake: *mistake,
                changes: wrong.iter().map(|part| part.value).enumerate().collect(),
            };
            table.mistakes = mistaken.iter().map(of).collect();
            tables.push((Oracle::WideDifferences, table));
        }
        tables
    }

    fn hessian_tables(
        &self,
        settings: &Settings,
        wide: bool,
        smooth: &[usize],
        got: &[Derivatives<f64>; 4],
        mistaken: &[(Mistake, [Derivatives<f64>; 4])],
        scales: &[f64],
    ) -> Vec<Judged> {
        let criterion = &self.friction.criterion;
        let sizes = self.point_sizes();
        let hessian_of = |all: &[Derivatives<f64>; 4]| -> Vec<Vec<f64>> {
            smooth.iter().flat_map(|p| all[*p].hessian.map(|row| row.to_vec())).collect()
        };
        let all = smooth.iter().flat_map(|p| (0..6).map(|k| (*p, k))).enumerate();
        let output = |(n, (p, k)): (usize, (usize, usize))| {
            (format!("²{}{}/∂{}", PARTS[p], self.title, FORCE[k]), scales[p] / sizes[k], n)
        };
        let hessians = Slopes {
            quantity: Quantity::FrictionHessian,
            outputs: Output::list(all.map(output)),
            inputs: self.inputs(&sizes),
            matrices: Some(smooth.iter().map(|p| format!("∂²{}{}", PARTS[*p], self.title)).collect()),
            demanded: Vec::new(),
            class: |i, j| (0, i % 6 / 3, j / 3),
            got: hessian_of(got),
            step: self.second_step(&sizes),
            wide: Box::new(|k, h| {
                let all = self.gradients(&self.moved(k, h), &sizes);
                smooth.iter().flat_map(|p| all[*p]).collect()
            }),
            narrow: Box::new(|k, h| {
                let all = self.derivatives(criterion, &self.moved(k, h));
                smooth.iter().flat_map(|p| all[*p].gradient).collect()
            }),
            slopes: Box::new(move |k, h| hessian_of(&self.derivatives(criterion, &self.moved(k, h)))),
            dual: Box::new(|| {
                let all = self.derivatives(criterion, &self.point.map(Wide::from_f64));
                smooth.iter().flat_map(|p| all[*p].hessian.map(|row| row.to_vec())).collect()
            }),
            mistaken: mistaken.iter().map(|(mistake, wrong)| (*mistake, hessian_of(wrong))).collect(),
            held: None,
        };
        hessians.tables(settings, wide)
    }
}
