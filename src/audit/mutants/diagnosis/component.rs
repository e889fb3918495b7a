//! Numbers of a connector's components.

use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::case::{Case, initial_places};
use crate::judge::bound::Bound;
use crate::mutants::diagnosis::cells::Cell;
use crate::mutants::diagnosis::columns::{BLOCKS, along, operations, twice};
use crate::mutants::diagnosis::dictionary::of_dictionary;
use crate::mutants::diagnosis::elsewhere::{beside, elsewhere};
use crate::mutants::diagnosis::matching::{AtState, Class, Gather, Hypothesis, Matching, Words, ranges};
use crate::mutants::diagnosis::parts::parts;
use crate::mutants::diagnosis::patterns::{
    differences, digits_lost, led_by_place, rounded, single_precision, single_precision_on_the_way,
    without_numbers,
};
use crate::mutants::diagnosis::seen::Seen;
use crate::mutants::diagnosis::smoothed::of_smoothed;
use crate::mutants::diagnosis::values::{INITIAL_AXES_OF_B, axis_of, of_values};
use crate::mutants::diagnosis::{Cause, Diagnosis, MULTIPLES};
use crate::mutants::mutant::{OfRow, ROTATIONS, Scene, mutants, part, put, second_variation};
use pintle_kinematics::catalog::COMPONENT;
use pintle_kinematics::connector::Connector;
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::node::{DOF, DOFS, PSI_A, Pair, THETA_A, THETA_B, XA, XB};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Matrix, Vector, add, apply, column, cross, product, scale, skew, sub, transpose, transposed_product,
};
use std::collections::BTreeSet;

/// Wrong numbers, and what they must be.
pub struct Symptoms<'a> {
    /// What they are.
    pub quantity: Quantity,
    /// The numbers given.
    pub got: &'a Entries<f64>,
    /// The rows given with them.
    pub rows: &'a Entries<f64>,
    /// Everything as it must be.
    pub want: &'a Numbers<f64>,
    /// The case at whose end they are.
    pub case: &'a Case,
    /// The tolerances.
    pub bound: &'a Bound,
}

/// Why numbers are wrong; `None` where none is.
pub fn diagnose(symptoms: &Symptoms<'_>) -> Option<Diagnosis> {
    diagnose_all(std::slice::from_ref(symptoms), &Seen::default())
}

/// Why numbers of one quantity are wrong at several states: a cause is told that holds at nearly all of them; `None` where nothing is.
/// What all states had, right ones too, has been seen.
pub fn diagnose_all(symptoms: &[Symptoms<'_>], seen: &Seen) -> Option<Diagnosis> {
    let words = ComponentWords { quantity: symptoms.first()?.quantity };
    let found = diagnosed(symptoms, seen)?;
    Some(led_by_place(symptoms, seen, &words, found))
}

fn diagnosed(symptoms: &[Symptoms<'_>], seen: &Seen) -> Option<Diagnosis> {
    let quantity = symptoms.first()?.quantity;
    let is_number = |symptoms: &&Symptoms<'_>| symptoms.got.iter().all(|(.., x)| x.is_finite());
    let words = ComponentWords { quantity };
    let (whole, lacking): (Vec<&Symptoms<'_>>, Vec<&Symptoms<'_>>) = symptoms.iter().partition(is_number);
    if whole.is_empty() {
        return without_numbers(&lacking, &words);
    }
    if let Some(few) = single_precision(&whole, &words) {
        return Some(few);
    }
    let states = whole.iter().map(|symptoms| symptoms.at_state()).collect();
    let mut regions: BTreeSet<Vec<Cell>> = BTreeSet::new();
    for (k, row) in symptoms.iter().flat_map(|one| one.wanted().0.iter().enumerate()) {
        let Some(row) = row else { continue };
        regions.insert((0..row.len()).map(|i| (k, i)).collect());
        let of_block = |block: &std::ops::Range<usize>| block.clone().map(|i| (k, i)).collect();
        if row.len() == DOFS {
            regions.extend(BLOCKS.iter().map(of_block));
        }
    }
    let has_offsets = quantity == Quantity::Value;
    let has_bounds = !is_derivative(quantity);
    let regions = regions.into_iter().collect();
    let matching = Matching { states, regions, has_offsets, has_bounds, seen: Some(seen), words: &words };
    let found = matching.diagnosis()?;
    if found.is_whole() {
        return Some(found);
    }
    let fewer = single_precision_on_the_way(&whole, &words)
        .or_else(|| digits_lost(&whole, &words))
        .or_else(|| rounded(&whole, &words))
        .or_else(|| differences(&whole, &words));
    Some(fewer.unwrap_or(found))
}

/// Whether entries are derivatives, of which many are the same constant at every state.
pub(super) const fn is_derivative(quantity: Quantity) -> bool {
    !matches!(
        quantity,
        Quantity::Value
            | Quantity::Rate
            | Quantity::Acceleration
            | Quantity::FrictionCriterion
            | Quantity::FrictionForce
    )
}

/// The class of an entry.
fn class(quantity: Quantity, k: usize, i: usize) -> Class {
    let kind = |j: usize| match j % (DOFS / 2) {
        0..=2 => 0,
        3..=5 => 1,
        _ => 2,
    };
    match quantity {
        Quantity::FirstDerivatives | Quantity::NodalForces => (k / 3, kind(i), 0),
        Quantity::SecondDerivatives | Quantity::GeometricStiffness => {
            let [x, y] = [kind(i / DOFS), kind(i % DOFS)];
            (k / 3, x.min(y), x.max(y))
        }
        _ => (k / 3, 0, 0),
    }
}

impl Symptoms<'_> {
    fn wanted(&self) -> &Entries<f64> {
        self.want.entries(self.quantity)
    }

    fn at_state(&self) -> AtState {
        let Self { quantity, got, bound, .. } = *self;
        let given = self.wanted().iter().map(|(k, i, want)| {
            ((k, i), (got.get(k, i), want, bound.tolerance(quantity, k, i), class(quantity, k, i)))
        });
        let mut hypotheses = self.hypotheses();
        let others = of_dictionary(self.case, quantity, self.wanted(), got);
        hypotheses.extend(others.hypotheses);
        AtState::new(given, hypotheses, others.tried)
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let connector = self.case.connector();
        let units: [Option<Unit>; 6] = std::array::from_fn(|k| connector.differentiated(k).map(|m| m.unit()));
        let turns = self.case.at_end().map(|end| end.after.turns.map(|turns| turns.turns));
        let scale = |k: usize, i: usize| self.bound.scale(self.quantity, k, i);
        let scene = Scene {
            numbers: self.want,
            case: self.case,
            units,
            turns: turns.unwrap_or_default(),
            scale: &scale,
        };
        let made = mutants(self.quantity, &scene).into_iter();
        let made = made.map(|mutant| Hypothesis::new(Cause::of(mutant.mistake), mutant.changes));
        let mut found: Vec<Hypothesis> = made.filter(|made| !made.cause.is_of_an_entry()).collect();
        for (k, entries) in self.wanted().0.iter().enumerate() {
            let Some(entries) = entries else { continue };
            let all = |of: fn(f64) -> f64| entries.iter().map(move |x| of(*x)).enumerate();
            found.push(Hypothesis::of_row(Cause::Reversed, k, all(|x| -x)));
            found.push(Hypothesis::of_row(Cause::ComponentZero, k, all(|_| 0.0)));
            // The self-test exchanges neighbours of one class, without a sign.
            for (l, others) in self.wanted().0.iter().enumerate().skip(k + 1) {
                let Some(others) = others else { continue };
                for signs in [[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]] {
                    if signs == [1.0; 2] && k / 3 == l / 3 {
                        continue;
                    }
                    let there = others.iter().enumerate().map(|(i, x)| (k, i, signs[0] * x));
                    let back = entries.iter().enumerate().map(|(i, x)| (l, i, signs[1] * x));
                    let made = Hypothesis::many(Cause::RowsSwapped, there.chain(back).collect());
                    let what = "what is expected of each other, with another sign";
                    found.push(made.related_if((signs != [1.0; 2]).then_some(what)));
                }
            }
        }
        // One copied into the place of another.
        for (k, from) in self.wanted().0.iter().enumerate() {
            let others = self.wanted().0.iter().enumerate().filter(|(l, to)| *l != k && to.is_some());
            for (l, _) in others.filter(|(l, _)| l / 3 == k / 3) {
                let Some(from) = from else { continue };
                let what = format!("what is expected of {}", COMPONENT[k]);
                found.row(Cause::RowsSwapped, l, from.iter().copied().enumerate(), what);
            }
        }
        // Three components one place on, either way.
        for first in [0, 3] {
            let rows = [0, 1, 2].map(|i| self.wanted().0[first + i].as_ref());
            let [Some(x), Some(y), Some(z)] = rows else { continue };
            for from in [[y, z, x], [z, x, y]] {
                let placed = from.into_iter().enumerate();
                let changes =
                    placed.flat_map(|(i, row)| row.iter().enumerate().map(move |(j, x)| (first + i, j, *x)));
                found.push(Hypothesis::many(Cause::RowsSwapped, changes.collect()));
            }
        }
        found.extend(elsewhere(self.case, self.quantity));
        found.extend(of_smoothed(self.case, self.quantity, self.wanted(), self.got));
        match self.quantity {
            Quantity::Value => {
                found.extend(of_values(self.case, self.wanted(), self.got));
                self.put_beside(&mut found, &connector);
            }
            Quantity::FirstDerivatives | Quantity::NodalForces => found.extend(self.of_rows()),
            Quantity::SecondDerivatives | Quantity::GeometricStiffness => found.extend(self.of_matrices()),
            Quantity::Rate | Quantity::Acceleration => found.extend(self.of_rates()),
            _ => {}
        }
        found
    }

    /// Puts angles on the sheets of the numbers given.
    fn put_beside(&self, found: &mut [Hypothesis], connector: &Connector<f64>) {
        let winds: [bool; 6] =
            std::array::from_fn(|k| connector.differentiated(k).is_some_and(Measure::winds));
        for made in found.iter_mut().filter(|made| made.cause != Cause::TurnForgotten) {
            for (k, i, x) in made.changes.iter_mut() {
                if let (true, Some(given), Some(wanted)) =
                    (winds[*k], self.got.get(*k, *i), self.wanted().get(*k, *i))
                {
                    *x = beside(*x, given, wanted);
                }
            }
        }
    }

    /// Changes of rows that are no mistakes of the self-test.
    fn of_rows(&self) -> Vec<Hypothesis> {
        let Some(pair) = self.case.last().map(|step| &step.state.pair) else { return Vec::new() };
        let connector = self.case.connector();
        let operations = operations(self.case);
        let initial = &self.case.definition.initial;
        let [first, second] = initial_places(initial.reference, self.case.definition.planar);
        let places: [(Vector<f64>, &str); 4] = [
            (add(second, pair.b.displacement), "x_b"),
            (add(first, pair.a.displacement), "x_a"),
            (pair.b.displacement, "u_b"),
            (sub(pair.b.displacement, pair.a.displacement), "u_b − u_a"),
        ];
        let others = match self.quantity {
            Quantity::NodalForces => Quantity::FirstDerivatives,
            _ => Quantity::NodalForces,
        };
        let mut found = Vec::new();
        for (k, row) in self.wanted().0.iter().enumerate() {
            let Some(row) = row else { continue };
            let triads = [&pair.a.triad, &pair.b.triad];
            let separations = [pair.separation(), self.case.definition.initial.separation()];
            let made = conventions(row, triads).into_iter().chain(levers(row, separations));
            found.extend(made.map(|(cause, changes)| Hypothesis::of_row(cause, k, changes)));
            let lever = cross(part(row, XB), separations[0]);
            let with = |d| put(THETA_A, sub(add(part(row, THETA_A), cross(part(row, XB), d)), lever));
            for (place, what) in &places {
                let what = format!("what is expected with {what} for the lever d = x_b − x_a");
                found.row(Cause::OtherLength, k, with(*place), what);
            }
            found.extend(mistyped_levers(k, row, separations[0]));
            found.extend(shared_levers(k, row, separations[0]));
            let what = "what is expected with the lever of the initial state";
            found.row(Cause::Linearised, k, with(separations[1]), what);
            if let Some(before) = self.case.path.iter().rev().nth(1) {
                let what = "what is expected with the lever of the state before";
                found.row(Cause::StateBefore, k, with(before.state.pair.separation()), what);
            }
            found.extend(operations.iter().filter_map(|operation| operation.of_row(k, row)));
            if let Some(other) = &self.want.entries(others).0[k] {
                let other = other.iter().copied().enumerate();
                found.push(Hypothesis::of_row(Cause::ConjugateForPrinted, k, other));
            }
            let measure = connector.differentiated(k);
            found.extend(parts(k, row, (triads, separations[0])));
            if k >= 3 {
                for (axis, what) in axes(triads) {
                    // An axis that is the gradient is none for it.
                    if norm(cross(axis, part(row, THETA_B))) < 1e-9 {
                        continue;
                    }
                    for sign in [1.0, -1.0] {
                        let made = Hypothesis::of_row(Cause::AxisForGradient, k, opposite(axis, sign));
                        found.push(made.related_if(what.clone()));
                    }
                }
                // The direction of a torsion, of length 1.
                let sum = add(column(triads[0], 2), column(triads[1], 2));
                for (along, what) in [
                    (scale(sum, 1.0 / norm(sum)), "the direction of e3a + e3b with the length 1"),
                    (scale(sum, 0.5), "½ (e3a + e3b), not divided by ½ (1 + e3a·e3b)"),
                ] {
                    for sign in [1.0, -1.0] {
                        found.row(Cause::NotNormalised, k, opposite(along, sign), what);
                    }
                }
            }
            if measure.is_some_and(|measure| measure.is_one_form()) {
                let scale = self.case.definition.flow_scale;
                for (what, x) in [
                    ("what is expected without the scale β_s", row[DOFS - 1] / scale),
                    ("what is expected with β_s twice", row[DOFS - 1] * scale),
                ] {
                    found.row(Cause::NotNormalised, k, [(DOFS - 1, x)], what);
                }
                let e = column(triads[1], 2);
                found.push(Hypothesis::of_row(Cause::AxesOfB, k, opposite(e, -1.0)));
            }
            found.extend(flow_columns(k, row));
            found.extend(shifted_columns(k, row));
            let others = self.wanted().0.iter().enumerate().filter(|(l, _)| *l != k && l / 3 == k / 3);
            for (l, other) in others {
                let Some(other) = other else { continue };
                for block in [XA..THETA_A, THETA_A..PSI_A, XB..THETA_B, THETA_B..DOFS - 1] {
                    let what = format!("what is expected there of {}", COMPONENT[l]);
                    found.row(Cause::RowsSwapped, k, block.map(|j| (j, other[j])), what);
                }
            }
            if measure == Some(Measure::Strain) {
                let stretch = 1.0 + self.case.positions()[k].unwrap_or(0.0);
                let material = norm(pair.separation()) / stretch;
                let flows = [PSI_A, DOFS - 1];
                let moves: Vec<usize> = (XA..THETA_A).chain(XB..THETA_B).collect();
                for (columns, factor, what) in [
                    (&flows[..], 1.0 / stretch, "without the stretch l/l_ref in the columns of the flows"),
                    (&flows, material, "with 1/l_ref for 1/l_ref² in the columns of the flows"),
                    (&flows, material * material, "without 1/l_ref² in the columns of the flows"),
                    (&flows, -1.0, "with the other sign of the columns of the flows"),
                    (&flows, 0.0, "without the columns of the flows"),
                    (&moves, material, "with the direction of d not divided by l_ref"),
                    (
                        &moves,
                        material / norm(pair.separation()),
                        "with the direction of d divided by l for l_ref",
                    ),
                ] {
                    let made = columns.iter().map(|j| (*j, factor * row[*j]));
                    found.row(Cause::NotNormalised, k, made, format!("what is expected {what}"));
                }
            }
            found.extend(measure.into_iter().flat_map(|measure| other_jacobians(self.case, k, measure)));
            if let Some(i) = measure.and_then(axis_of) {
                let initial = &self.case.definition.initial.a.triad;
                found.extend(along_axes(k, i, (triads, initial), pair.separation()));
                for j in (0..3).filter(|j| *j != i) {
                    let e = column(triads[0], j);
                    let ends = put(XA, e.map(|x| -x)).into_iter().chain(put(XB, e));
                    let all = ends.chain(put(THETA_A, cross(e, pair.separation())));
                    let what = format!("the row of the coordinate along e{}a, not e{}a", j + 1, i + 1);
                    found.row(Cause::RowsSwapped, k, all, what);
                }
            }
        }
        found
    }

    /// Changes of second derivatives that are no mistakes of the self-test.
    fn of_matrices(&self) -> Vec<Hypothesis> {
        let operations = operations(self.case);
        let first = match self.quantity {
            Quantity::GeometricStiffness => Quantity::NodalForces,
            _ => Quantity::FirstDerivatives,
        };
        let pair = self.case.last().map(|step| step.state.pair);
        let connector = self.case.connector();
        let mut found = Vec::new();
        for (k, matrix) in self.wanted().0.iter().enumerate() {
            let Some(matrix) = matrix else { continue };
            let changed = |cause: Cause, of: &dyn Fn(usize, usize, f64) -> f64| {
                let all = matrix.iter().enumerate().map(|(n, x)| (n, of(n / DOFS, n % DOFS, *x), *x));
                Hypothesis::of_row(cause, k, all.filter(|(_, x, old)| x != old).map(|(n, x, _)| (n, x)))
            };
            found.extend(operations.iter().filter_map(|operation| operation.of_matrix(k, matrix)));
            let of = |j: usize, at: usize| (at..at + 3).contains(&j);
            let is_a = |j: usize| of(j, THETA_A);
            let turns = |j: usize| of(j, THETA_A) || of(j, THETA_B);
            let moves = |j: usize| of(j, XA) || of(j, XB);
            type Place<'a> = &'a dyn Fn(usize, usize) -> bool;
            let held: [Place<'_>; 4] =
                [&|i, j| is_a(i) || is_a(j), &|i, _| is_a(i), &|_, j| is_a(j), &|i, j| is_a(i) && is_a(j)];
            for is_held in held {
                found.push(changed(Cause::FrameHeld, &|i, j, x| if is_held(i, j) { 0.0 } else { x }));
            }
            let blocks: [Place<'_>; 8] = [
                &|i, j| turns(i) && turns(j),
                &|i, j| moves(i) && moves(j),
                &|i, j| turns(i) != turns(j) && moves(i) != moves(j),
                &|i, j| (i < XB) != (j < XB),
                &|i, j| i < XB && j < XB,
                &|i, j| i >= XB && j >= XB,
                &|i, j| of(i, THETA_A) && of(j, THETA_B) || of(j, THETA_A) && of(i, THETA_B),
                &|i, j| of(i, THETA_B) && of(j, THETA_B),
            ];
            for is_in in blocks {
                found.push(changed(Cause::BlockMissing, &|i, j, x| if is_in(i, j) { 0.0 } else { x }));
                found.push(changed(Cause::BlockReversed, &|i, j, x| if is_in(i, j) { -x } else { x }));
            }
            if let (Some(pair), Some(Measure::Distance)) = (&pair, connector.differentiated(k)) {
                let of_one = 1.0 / norm(pair.separation());
                let whole = changed(Cause::GeometricTermMissing, &|i, j, x| {
                    let same = moves(i) && moves(j) && i % XB == j % XB;
                    let sign = if (i < XB) == (j < XB) { 1.0 } else { -1.0 };
                    if same {
                        sign * of_one
                    } else if moves(i) && moves(j) {
                        0.0
                    } else {
                        x
                    }
                });
                found.push(
                    whole.related("1/l for (1 − q qᵀ)/l, q the direction: the part along q is not taken off"),
                );
            }
            // H = Σ t tᵀ/r over the directions across, and what directions that turn add.
            if let (Some(pair), Some(measure)) = (&pair, connector.differentiated(k))
                && matches!(measure, Measure::Distance | Measure::RadialDistance)
            {
                let d = pair.separation();
                let axis = column(&pair.a.triad, 2);
                let radial = match measure {
                    Measure::RadialDistance => sub(d, scale(axis, along(&axis, &d))),
                    _ => d,
                };
                let r = norm(radial);
                let first = if measure == Measure::RadialDistance { axis } else { column(&pair.a.triad, 0) };
                let across = cross(radial, first);
                let one = scale(across, 1.0 / norm(across));
                let two = cross(scale(radial, 1.0 / r), one);
                let ways = if measure == Measure::RadialDistance { vec![one] } else { vec![one, two] };
                let columns = ways.into_iter().map(|e| {
                    let mut of = [0.0; DOFS];
                    of[XA..THETA_A].copy_from_slice(&e.map(|x| -x));
                    of[XB..THETA_B].copy_from_slice(&e);
                    if measure == Measure::RadialDistance {
                        of[THETA_A..PSI_A].copy_from_slice(&cross(e, d));
                    }
                    of
                });
                let columns: Vec<[f64; DOFS]> = columns.collect();
                let product = |i: usize, j: usize| columns.iter().map(|of| of[i] * of[j]).sum::<f64>() / r;
                for (times, what) in MULTIPLES {
                    let made = changed(Cause::GeometricTermMissing, &|i, j, x| x + times * product(i, j));
                    found.push(made.related(format!(
                        "what is expected {what} the part t tᵀ/r, t the directions across the length r"
                    )));
                }
            }
            let mirrored = |i: usize, j: usize| matrix[j * DOFS + i];
            found.push(changed(Cause::Symmetrised, &|i, j, x| (x + mirrored(i, j)) / 2.0));
            found.push(changed(Cause::Symmetrised, &|i, j, x| if j < i { mirrored(i, j) } else { x }));
            found.push(changed(Cause::Symmetrised, &|i, j, x| if j > i { mirrored(i, j) } else { x }));
            let triangles: [Place<'_>; 2] = [&|i, j| i < j, &|i, j| i > j];
            for is_empty in triangles {
                for rest in [1.0, 2.0] {
                    found.push(changed(Cause::OneTriangle, &|i, j, x| {
                        if is_empty(i, j) {
                            0.0
                        } else if i == j {
                            x
                        } else {
                            rest * x
                        }
                    }));
                }
            }
            let (Some(pair), Some(row)) = (&pair, self.want.entries(first).0[k].as_deref()) else { continue };
            let mut terms = vec![0.0; DOFS * DOFS];
            second_variation(row, pair).into_iter().for_each(|(i, j, term)| terms[i * DOFS + j] += term);
            for (cause, times) in [
                (Cause::GeometricTermDoubled, 1.0),
                (Cause::LeverReversed, -2.0),
                (Cause::GeometricTermMissing, -1.0),
            ] {
                found.push(changed(cause, &|i, j, x| x + times * terms[i * DOFS + j]));
            }
            // The other order: the bracket with the other sign, of both nodes or of one.
            for (times, ats) in
                [(1.0, &ROTATIONS[..]), (-1.0, &ROTATIONS), (1.0, &[THETA_A]), (-1.0, &[THETA_A])]
            {
                for part_of in [0.5, 1.0] {
                    found.push(changed(Cause::BracketKept, &|i, j, x| {
                        let Some(at) = ats.iter().find(|at| of(i, **at) && of(j, **at)) else { return x };
                        let axis = |n: usize| [0, 1, 2].map(|m| f64::from(u8::from(at + m == n)));
                        x + times * part_of * along(&cross(axis(i), axis(j)), &part(row, *at))
                    }));
                }
            }
        }
        found
    }

    /// Changes of rates, or accelerations, that are no mistakes of the self-test.
    fn of_rates(&self) -> Vec<Hypothesis> {
        let Some(state) = self.case.last().map(|step| &step.state) else { return Vec::new() };
        let operations = operations(self.case);
        let (velocity, acceleration) = (&state.velocity, &state.acceleration);
        let faster = (self.quantity == Quantity::Acceleration).then_some(&acceleration[..]);
        let connector = self.case.connector();
        let triads = [&state.pair.a.triad, &state.pair.b.triad];
        let separations = [state.pair.separation(), self.case.definition.initial.separation()];
        let [position, initial_position] = [self.case.positions(), self.case.at_rest().positions()];
        let is_length = |k: usize| {
            matches!(connector.differentiated(k), Some(Measure::Distance | Measure::RadialDistance))
        };
        let (mut found, mut parts) = (Vec::new(), Vec::new());
        for (k, _, want) in self.wanted().iter() {
            let of = |quantity: Quantity| self.want.entries(quantity).0[k].as_deref();
            let Some(row) = of(Quantity::FirstDerivatives) else { continue };
            let matrix = of(Quantity::SecondDerivatives);
            let zeros = [0.0; DOFS * DOFS];
            let matrix = matrix.unwrap_or(&zeros);
            let made = operations.iter().filter_map(|one| one.of_rate(k, (row, matrix), (velocity, faster)));
            found.extend(made);
            let mut is = |cause: Cause, x: f64| found.push(Hypothesis::one(cause, (k, 0), x));
            let size = row.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let is_wrong = |given: &&[f64]| row.iter().zip(*given).any(|(x, y)| (x - y).abs() > 1e-9 * size);
            if let Some(given) = self.rows.0[k].as_deref().filter(is_wrong) {
                let more = faster.map_or(0.0, |faster| want - along(row, faster));
                is(Cause::OfItsRow, along(given, faster.unwrap_or(velocity)) + more);
            }
            is(Cause::SignLost, want.abs());
            is(
                Cause::RateForAcceleration,
                along(row, if faster.is_some() { velocity } else { acceleration }),
            );
            for (cause, changes) in levers(row, separations) {
                let mut changed = row.to_vec();
                changes.into_iter().for_each(|(j, x)| changed[j] = x);
                if changed == row {
                    continue;
                }
                let more = faster.map_or(0.0, |_| twice(matrix, velocity));
                is(cause, along(&changed, faster.unwrap_or(velocity)) + more);
            }
            if let Some(faster) = faster {
                let of_length = position[k].filter(|_| is_length(k));
                let lengths = of_length.map(|x| (x, initial_position[k].unwrap_or(x)));
                parts.extend(other_accelerations(
                    (k, want),
                    (row, matrix),
                    (velocity, faster),
                    (separations[0], lengths),
                ));
            } else {
                is(Cause::DerivativeForResolved, along(row, velocity));
            }
            if faster.is_none() && connector.differentiated(k) == Some(Measure::Distance) {
                let speed = norm(sub(part(velocity, XB), part(velocity, XA)));
                let what = "|v_b − v_a|, the speed for its component along d";
                parts.row(Cause::OtherLength, k, [(0, speed)], what);
            }
            if let Some((i, at)) = connector.differentiated(k).and_then(resolved_at) {
                let v = faster.unwrap_or(velocity);
                let along_b = column(triads[1], i);
                let apart = sub(part(v, at + XB), part(v, at));
                let mut told = |cause: Cause, x: f64, what: &str| parts.row(cause, k, [(0, x)], what);
                if faster.is_some() {
                    let slower = sub(part(velocity, at + XB), part(velocity, at));
                    let turned = cross(part(velocity, THETA_B), along_b);
                    told(
                        Cause::DerivativeForResolved,
                        along(&along_b, &apart) + along(&turned, &slower),
                        "the time derivative of the resolved rate, whose axes turn with b",
                    );
                }
                let carried = cross(part(v, THETA_A), separations[0]);
                if at == XA && faster.is_none() {
                    told(
                        Cause::DerivativeForResolved,
                        along(&along_b, &sub(apart, carried)),
                        "the velocity of b as a sees it, ω_a × d taken off, along the axes of b",
                    );
                }
                told(
                    Cause::AxesOfA,
                    along(&along_b, &part(v, at + XB)) - along(&column(triads[0], i), &part(v, at)),
                    "those of each node along its own axes, and their difference",
                );
                if let Some(faster) = faster {
                    is(Cause::DerivativeForResolved, along(row, faster) + twice(matrix, velocity));
                }
                let initial = &self.case.definition.initial;
                let (of_a, of_b) = (part(v, at), part(v, at + XB));
                let global = [0, 1, 2].map(|n| f64::from(u8::from(n == i)));
                let [a, b] = triads.map(|triad| column(triad, i));
                let still = [&initial.a, &initial.b].map(|node| column(&node.triad, i));
                let relative = sub(of_b, of_a);
                for (cause, e) in
                    [(Cause::AxesOfA, a), (Cause::GlobalAxes, global), (Cause::InitialAxes, still[0])]
                {
                    is(cause, along(&e, &relative));
                }
                is(Cause::RatesOfAIgnored, along(&b, &of_b));
                let of_b = [(0, along(&still[1], &relative))];
                found.row(Cause::InitialAxes, k, of_b, INITIAL_AXES_OF_B);
            }
            let is_angle = connector.differentiated(k).is_some_and(|measure| measure.unit() == Unit::Angle);
            let relative = |v: &[f64; DOFS]| [0, 1, 2].map(|i| v[THETA_B + i] - v[THETA_A + i]);
            let relative = relative(if faster.is_some() { acceleration } else { velocity });
            for (axis, _) in axes(triads).into_iter().filter(|_| is_angle) {
                found.push(Hypothesis::one(Cause::AxisForGradient, (k, 0), along(&axis, &relative)));
            }
        }
        found.extend(parts);
        found.extend(self.of_mistaken_rows(velocity, faster));
        found
    }

    /// Rates, or the linear part of accelerations, that known mistakes of rows make.
    fn of_mistaken_rows(&self, velocity: &[f64; DOFS], faster: Option<&[f64]>) -> Vec<Hypothesis> {
        let quantity = Quantity::FirstDerivatives;
        let Self { got, rows, want, case, bound, .. } = *self;
        let of_rows = Symptoms { quantity, got, rows, want, case, bound }.of_rows();
        let made = of_rows.into_iter().filter_map(|Hypothesis { cause, changes, relation, .. }| {
            let mut of = None;
            let mut by = 0.0;
            for (k, j, x) in changes.iter() {
                let right = want.entries(quantity).get(*k, *j)?;
                by += (x - right) * faster.unwrap_or(velocity).get(*j)?;
                if of.is_some_and(|known| known != *k) {
                    return None;
                }
                of = Some(*k);
            }
            let k = of?;
            let x = self.wanted().get(k, 0)? + by;
            Some(Hypothesis { relation, is_searched: true, ..Hypothesis::one(cause, (k, 0), x) })
        });
        made.collect()
    }
}

/// Accelerations q̈ = row·a + vᵀ H v of component k with another multiple of a part: `d` is the separation, `lengths` are that of a distance, now
/// and at first.
fn other_accelerations(
    (k, want): (usize, f64),
    (row, matrix): (&[f64], &[f64]),
    (velocity, acceleration): (&[f64; DOFS], &[f64]),
    (d, lengths): (Vector<f64>, Option<(f64, f64)>),
) -> Vec<Hypothesis> {
    let linear = along(row, acceleration);
    let quadratic = want - linear;
    let of_motion = |moves: &dyn Fn(usize) -> bool| {
        twice(matrix, &std::array::from_fn::<f64, DOFS, _>(|j| if moves(j) { velocity[j] } else { 0.0 }))
    };
    let turning = of_motion(&|j| (THETA_A..PSI_A).contains(&(j % XB)));
    let moving = of_motion(&|j| j % XB < THETA_A);
    let (of_a, of_b) = (of_motion(&|j| j < XB), of_motion(&|j| j >= XB));
    let mut parts = vec![
        ("the part quadratic in the spins".to_owned(), turning),
        ("the part quadratic in the velocities".to_owned(), moving),
        ("the product of spins and velocities".to_owned(), quadratic - turning - moving),
        ("the product of the rates of a and of b".to_owned(), quadratic - of_a - of_b),
    ];
    parts.extend(quadratic_parts(matrix, velocity, d));
    let one = |cause: Cause, x: f64| Hypothesis::one(cause, (k, 0), x);
    let mut found = vec![
        one(Cause::LinearPartMissing, quadratic),
        one(Cause::Coriolis, linear + turning).related("the linear part, and that quadratic in the spins"),
        one(Cause::Coriolis, linear + moving)
            .related("the linear part, and that quadratic in the velocities"),
        // Of the rates of b alone, in the quadratic part alone, or in the linear one too.
        one(Cause::RatesOfAIgnored, linear + of_b),
        one(Cause::RatesOfAIgnored, along(&row[XB..], &acceleration[XB..]) + of_b),
    ];
    found.extend([1.0, -0.5, -2.0].map(|times| one(Cause::QuadraticPartDoubled, want + times * quadratic)));
    if let Some((x, first)) = lengths {
        let own = along(row, velocity).powi(2) / x;
        let across = quadratic + own;
        parts.push(("−ẋ²/x, x the length".to_owned(), -own));
        parts.push(("|v|²/x, v the rates across it".to_owned(), across));
        let with = |cause: Cause, part: f64, what: &str| {
            one(cause, linear + part).related(format!("what is expected with {what}"))
        };
        found.extend([
            with(
                Cause::InitialKept,
                quadratic * x / first,
                "the initial length in the part quadratic in the rates",
            ),
            with(
                Cause::NotNormalised,
                quadratic * x,
                "the part quadratic in the rates not divided by the length",
            ),
            with(
                Cause::NotNormalised,
                across * x - own,
                "|v|² not divided by the length, v the rates across it",
            ),
        ]);
    }
    for (words, part) in parts.iter().filter(|(_, part)| *part != 0.0) {
        found.extend(MULTIPLES.map(|(times, what)| {
            one(Cause::Coriolis, want + times * part).related(format!("what is expected {what} {words}"))
        }));
    }
    found
}

/// vᵀ H v by parts: the nodes move as a body that turns with a, b moves and turns against it, material flows. Each pair of these is a part.
fn quadratic_parts(matrix: &[f64], velocity: &[f64; DOFS], d: Vector<f64>) -> Vec<(String, f64)> {
    let zero = [0.0; DOFS];
    let spin = part(velocity, THETA_A);
    let carried = cross(spin, d);
    let mut motions = [zero; 4];
    let [moves, turns, body, flows] = &mut motions;
    let relative = sub(sub(part(velocity, XB), part(velocity, XA)), carried);
    moves[XB..THETA_B].copy_from_slice(&relative);
    turns[THETA_B..DOFS - 1].copy_from_slice(&sub(part(velocity, THETA_B), spin));
    body[THETA_A..PSI_A].copy_from_slice(&spin);
    body[XB..THETA_B].copy_from_slice(&carried);
    body[THETA_B..DOFS - 1].copy_from_slice(&spin);
    (flows[PSI_A], flows[DOFS - 1]) = (velocity[PSI_A], velocity[DOFS - 1]);
    const NAME: [&str; 4] =
        ["the velocity of b as a sees it", "the spin of b against a", "the spin of a", "the flows"];
    let mut found = Vec::new();
    for i in 0..4 {
        for j in i..4 {
            let (x, y) = (&motions[i], &motions[j]);
            let both: [f64; DOFS] = std::array::from_fn(|n| x[n] + y[n]);
            let (words, part) = if i == j {
                (format!("the part quadratic in {}", NAME[i]), twice(matrix, x))
            } else {
                let product = twice(matrix, &both) - twice(matrix, x) - twice(matrix, y);
                (format!("the product of {} and {}", NAME[i], NAME[j]), product)
            };
            found.push((words, part));
        }
    }
    found
}

/// Which axis of b nodal rates are resolved along, and where these stand.
const fn resolved_at(measure: Measure) -> Option<(usize, usize)> {
    match measure {
        Measure::PositionAtB(i) => Some((i - 1, XA)),
        Measure::RotationVectorAtB(i) => Some((i - 1, THETA_A)),
        _ => None,
    }
}

/// The directions of the nodes, those midway between them, and their sums.
fn axes([a, b]: [&Matrix<f64>; 2]) -> Vec<(Vector<f64>, Option<String>)> {
    let of = |i: usize| {
        let (a, b) = (column(a, i), column(b, i));
        let sum = add(a, b);
        // That of the third axes is a torsion's direction, which was not divided.
        let midway = if i < 2 { scale(sum, 1.0 / norm(sum)) } else { a };
        [a, b, midway, sum].map(|axis| (axis, None))
    };
    let across = |n: usize| {
        let what = format!("the cross product of e{}a and e{}b", n / 3 + 1, n % 3 + 1);
        (cross(column(b, n % 3), column(a, n / 3)), Some(what))
    };
    (0..3).flat_map(of).chain((0..9).map(across)).collect()
}

/// Rows of a component of the rotation vector by other Jacobians than the inverse left one, along the axes of a.
fn other_jacobians(case: &Case, k: usize, measure: Measure) -> Vec<Hypothesis> {
    let Some(step) = case.last() else { return Vec::new() };
    let relative = |pair: &Pair<f64>| transposed_product(&pair.a.triad, &pair.b.triad);
    let (q, q0) = (relative(&step.state.pair), relative(&case.definition.initial));
    let (i, r) = match measure {
        Measure::RotationVector(i) | Measure::RotationVectorAtB(i) => (i - 1, q),
        Measure::Misalignment(i) | Measure::Cardan(i) => (i - 1, product(&q, &transpose(&q0))),
        _ => return Vec::new(),
    };
    // With its turns, where it is what the components are.
    let whole = case.positions();
    let phi = match (measure, [whole[3], whole[4], whole[5]]) {
        (Measure::RotationVector(_) | Measure::RotationVectorAtB(_), [Some(x), Some(y), Some(z)]) => {
            [x, y, z]
        }
        _ => so3::log(&r),
    };
    let (left, inverse) = (so3::left_jacobian(phi), so3::inverse_left_jacobian(phi));
    let of = |m: Matrix<f64>| {
        let g = apply(&step.state.pair.a.triad, m[i]);
        Hypothesis::of_row(Cause::OtherJacobian, k, opposite(g, 1.0))
    };
    // J⁻¹ = 1 − φ^/2 + (1 − (θ/2) cot(θ/2))/θ² φ^²: with another coefficient.
    let theta = norm(phi);
    let hat = skew(phi);
    let square = product(&hat, &hat);
    let by = |coefficient: f64| {
        let entry = |i: usize, j: usize| {
            let one = f64::from(u8::from(i == j));
            coefficient.mul_add(square[i][j], one - hat[i][j] / 2.0)
        };
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| entry(i, j)))
    };
    let others = [
        ("cot θ for cot(θ/2)", (1.0 - theta / 2.0 / theta.tan()) / (theta * theta)),
        ("θ cot(θ/2) for (θ/2) cot(θ/2)", (1.0 - theta / (theta / 2.0).tan()) / (theta * theta)),
        ("1/12 for the coefficient of φ^²", 1.0 / 12.0),
        ("no φ^²", 0.0),
    ];
    let made = [
        of(left),
        of(transpose(&left)),
        of(transpose(&inverse)),
        of(inverse),
        of(pintle_kinematics::vector::identity())
            .related("the axis itself: the Jacobian of the rotation vector is left out"),
    ];
    let of_others = others.into_iter().map(|(what, coefficient)| {
        of(by(coefficient)).related(format!("the row of the inverse Jacobian with {what}"))
    });
    made.into_iter().chain(of_others).collect()
}

/// Rows whose directions are held, and whose lever g × d stands at a, at b or at both.
fn shared_levers(k: usize, row: &[f64], d: Vector<f64>) -> Vec<Hypothesis> {
    // What no displacement changes has no lever.
    if part(row, XB).iter().all(|x| *x == 0.0) {
        return Vec::new();
    }
    let lever = cross(part(row, XB), d);
    let mut found = Vec::new();
    for (at_a, at_b, what) in [
        (0.5, 0.5, "what is expected with half of the lever d at each node"),
        (0.5, -0.5, "what is expected with half of the lever d at each node, of the other sign at b"),
        (-0.5, -0.5, "what is expected with half of the lever d at each node, of the other sign"),
        (1.0, 0.0, "the force with the moment f × d on a"),
        (0.0, 1.0, "the force with the moment f × d on b"),
        (0.0, -1.0, "the force with the moment d × f on b"),
    ] {
        let both = put(THETA_A, scale(lever, at_a)).into_iter().chain(put(THETA_B, scale(lever, at_b)));
        found.row(Cause::LeverAtB, k, both, what);
    }
    found
}

/// Rows whose lever g × d has a product mistyped: of the other sign, or left out.
fn mistyped_levers(k: usize, row: &[f64], d: Vector<f64>) -> Vec<Hypothesis> {
    let (g, of_a) = (part(row, XB), part(row, THETA_A));
    let mut found = Vec::new();
    for i in 0..3 {
        let (j, l) = ((i + 1) % 3, (i + 2) % 3);
        for (product, sign) in [(g[j] * d[l], -1.0), (g[l] * d[j], 1.0)] {
            for (times, cause, what) in [
                (2.0, Cause::LeverReversed, "with a product of the lever d × δθ of the other sign"),
                (1.0, Cause::GeometricTermMissing, "without a product of the lever d × δθ"),
            ] {
                let entry = (THETA_A + i, of_a[i] + sign * times * product);
                found.row(cause, k, [entry], format!("what is expected {what}"));
            }
        }
    }
    // An index of g_j d_l − g_l d_j that is another one, in each component.
    for place in 0..4 {
        for by in [1, 2] {
            let typed = (0..3).map(|i| {
                let (j, l) = ((i + 1) % 3, (i + 2) % 3);
                let mut at = [j, l, l, j];
                at[place] = (at[place] + by) % 3;
                let [a, b, c, d_] = at;
                let lever = g[j] * d[l] - g[l] * d[j];
                (THETA_A + i, of_a[i] - lever + g[a] * d[b] - g[c] * d[d_])
            });
            let what = "what is expected with an index mistyped in the cross product g × d of the lever";
            found.row(Cause::GeometricTermMissing, k, typed, what);
        }
    }
    found
}

/// Rows with a flow in the column of another degree of freedom, or in both: beside what stands there, or in its place.
fn flow_columns(k: usize, row: &[f64]) -> Vec<Hypothesis> {
    let mut found = Vec::new();
    for flow in [PSI_A, DOFS - 1].into_iter().filter(|flow| row[*flow] != 0.0) {
        let x = row[flow];
        let mut add = |relation: String, changes: Vec<(usize, f64)>| {
            found.row(Cause::FlowColumn, k, changes, relation);
        };
        for to in (0..DOFS).filter(|to| *to != flow) {
            let (of, by) = (DOF[flow], DOF[to]);
            if row[to] == 0.0 {
                let what = format!("what is expected with the number of {of} in the column {by}");
                add(what, vec![(flow, 0.0), (to, x)]);
            } else if row[to] != -x {
                let what = format!("what is expected with the numbers of {of} and {by} exchanged");
                add(what, vec![(flow, row[to]), (to, x)]);
                let what = format!("what is expected with the number of {of} added to the column {by}");
                add(what, vec![(flow, 0.0), (to, row[to] + x)]);
            }
        }
        let other = DOFS - 1 + PSI_A - flow;
        for sign in [1.0, -1.0].into_iter().filter(|_| row[other] == 0.0) {
            let what = format!("what is expected, and a number in the column {} too", DOF[other]);
            add(what, vec![(other, sign * x)]);
        }
    }
    found
}

/// Rows whose columns from one on, to the end of a node or of both, stand one place further on, or back.
fn shifted_columns(k: usize, row: &[f64]) -> Vec<Hypothesis> {
    let mut found = Vec::new();
    for from in [THETA_A, PSI_A, XB, THETA_B] {
        for to in [PSI_A + 1, DOFS].into_iter().filter(|to| *to > from + 1) {
            let columns = &row[from..to];
            if columns.iter().all(|x| *x == 0.0) {
                continue;
            }
            for (by, side) in [(1, "further on"), (columns.len() - 1, "further back")] {
                let mut moved = columns.to_vec();
                moved.rotate_right(by);
                // What falls out at one end leaves a zero at the other.
                moved[if by == 1 { 0 } else { columns.len() - 1 }] = 0.0;
                let made = moved.into_iter().enumerate().map(|(j, x)| (from + j, x));
                let (one, last) = (DOF[from], DOF[to - 1]);
                let what = format!("what is expected with the columns {one} to {last} one place {side}");
                found.row(Cause::ColumnsSwapped, k, made, what);
            }
        }
    }
    found
}

/// The row of a coordinate along other axes: of b, global ones, initial ones of a.
fn along_axes(
    k: usize,
    i: usize,
    ([a, b], initial): ([&Matrix<f64>; 2], &Matrix<f64>),
    d: Vector<f64>,
) -> Vec<Hypothesis> {
    let global = [0, 1, 2].map(|n| f64::from(u8::from(n == i)));
    let ends = |e: Vector<f64>| put(XA, e.map(|x| -x)).into_iter().chain(put(XB, e));
    let of = |cause: Cause, e: Vector<f64>, at: Option<usize>| {
        let mut row = [0.0; DOFS];
        ends(e).chain(at.into_iter().flat_map(|at| put(at, cross(e, d)))).for_each(|(j, x)| row[j] = x);
        Hypothesis::of_row(cause, k, row.into_iter().enumerate())
    };
    let of_displacements = |cause: Cause, e: Vector<f64>| Hypothesis::of_row(cause, k, ends(e));
    vec![
        of_displacements(Cause::AxesOfA, column(a, i)),
        of_displacements(Cause::AxesOfB, column(b, i)),
        of_displacements(Cause::GlobalAxes, global),
        of_displacements(Cause::InitialAxes, column(initial, i)),
        of(Cause::AxesOfA, column(a, i), Some(THETA_A)),
        of(Cause::AxesOfB, column(b, i), Some(THETA_B)),
        of(Cause::AxesOfB, column(b, i), Some(THETA_A)),
        of(Cause::AxesOfB, column(b, i), None),
        of(Cause::GlobalAxes, global, None),
        of(Cause::GlobalAxes, global, Some(THETA_A)),
        of(Cause::InitialAxes, column(initial, i), None),
        of(Cause::InitialAxes, column(initial, i), Some(THETA_A)),
    ]
}

/// A vector in the rotations of b, and its opposite in those of a, times a sign.
fn opposite(v: Vector<f64>, sign: f64) -> impl Iterator<Item = (usize, f64)> {
    put(THETA_B, v.map(|x| sign * x)).into_iter().chain(put(THETA_A, v.map(|x| -sign * x)))
}

/// The lever of a row counted otherwise; the separation now and initially.
fn levers(row: &[f64], [d, initial]: [Vector<f64>; 2]) -> Vec<(Cause, OfRow)> {
    let lever = cross(part(row, XB), d);
    let of_initial = cross(part(row, XB), initial);
    let [of_a, of_b] = ROTATIONS.map(|at| part(row, at));
    let plus = |v: Vector<f64>, times: f64| [0, 1, 2].map(|i| v[i] + times * lever[i]);
    let moved = |times: f64| [put(THETA_A, plus(of_a, -1.0)), put(THETA_B, plus(of_b, times))].concat();
    vec![
        (Cause::LeverAtB, moved(1.0)),
        (Cause::LeverReversed, put(THETA_A, plus(of_a, -2.0))),
        (Cause::GeometricTermMissing, put(THETA_A, plus(of_a, -1.0))),
        (Cause::GeometricTermDoubled, put(THETA_A, plus(of_a, 1.0))),
        (Cause::InitialTurned, put(THETA_A, sub(of_a, of_initial))),
        (Cause::LeverAtB, moved(-1.0)),
        (Cause::LeverAtB, put(THETA_B, [0, 1, 2].map(|i| of_b[i] + lever[i]))),
        (Cause::LeverAtB, put(THETA_B, [0, 1, 2].map(|i| of_b[i] - lever[i]))),
    ]
}

/// Rotations of a row of nodal derivatives by other conventions: turned twice by the triads of the nodes, and doubled.
pub fn conventions(row: &[f64], triads: [&Matrix<f64>; 2]) -> Vec<(Cause, OfRow)> {
    let of = |(at, triad): (usize, &Matrix<f64>)| {
        let block = part(row, at);
        let turned = (Cause::RotationTurnedTwice, put(at, apply(triad, block)));
        [turned, (Cause::RotationDoubled, put(at, block.map(|x| 2.0 * x)))]
    };
    ROTATIONS.into_iter().zip(triads).flat_map(of).collect()
}

pub(super) struct ComponentWords {
    quantity: Quantity,
}

impl Words for ComponentWords {
    fn entry(&self, (k, i): Cell) -> String {
        self.quantity.entry_name(k, i)
    }

    fn region(&self, places: &BTreeSet<Cell>) -> String {
        let rows: BTreeSet<usize> = places.iter().map(|(k, _)| *k).collect();
        let rows: Vec<&str> = rows.into_iter().filter_map(|k| COMPONENT.get(k).copied()).collect();
        let each = |prefix: &str, suffix: &str| {
            let named: Vec<String> = rows.iter().map(|row| format!("{prefix}{row}{suffix}")).collect();
            named.join(", ")
        };
        match self.quantity {
            Quantity::Rate => each("d", "/dt"),
            Quantity::Acceleration => each("d²", "/dt²"),
            Quantity::SecondDerivatives => each("∂²", ""),
            Quantity::NodalForces => each("the nodal forces of ", &columns(places, " on ", " and ")),
            Quantity::GeometricStiffness => each("the geometric stiffness of ", ""),
            Quantity::FirstDerivatives => each("∂", &columns(places, "/∂", " and ∂")),
            _ => rows.join(", "),
        }
    }

    fn triads(&self) -> [&'static str; 2] {
        ["A", "B"]
    }

    fn rotations(&self, places: &BTreeSet<Cell>) -> [bool; 2] {
        ROTATIONS.map(|at| places.iter().any(|(_, j)| (at..at + 3).contains(j)))
    }
}

/// The columns of entries in words, after a prefix; nothing where they are all columns.
fn columns(places: &BTreeSet<Cell>, prefix: &str, and: &str) -> String {
    let columns: BTreeSet<usize> = places.iter().map(|(_, j)| *j).collect();
    let name = |j: usize| DOF.get(j).copied().unwrap_or_default().to_string();
    // A connector need not have both flows.
    if columns.len() >= DOFS - 2 {
        String::new()
    } else {
        format!("{prefix}{}", ranges(&columns, &name).join(and))
    }
}
