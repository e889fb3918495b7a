//! Which of the motions that are free to first order are so to second order?
//!
//! Let the motions m be those with J m = 0, and ω the combinations of constraints with ω J = 0, one for each redundant constraint. A path that
//! leaves the state along m satisfies the constraints to second order only where ω · (d²C/dt²)[m, m] = 0 for every ω: a quadratic form
//! in m for each redundancy. The leading term of every analytic path is such an m, be it of whatever order. So
//!
//! - where some combination of the forms is definite, no path leaves the state: it is an isolated one;
//! - where a combination is so but for motions that all the forms leave alone, paths can only leave along these;
//! - else paths leave along the zeros of the forms, if at all: those that are found are tried.
//!
//! Forms are found of the Jacobian, which is exact, by central differences along each motion.

use crate::facts::Role;
use crate::matrix::budget::{Budget, EVALUATION, PRODUCTS, ROW};
use crate::matrix::dense;
use crate::matrix::dense::size;
use crate::matrix::eliminate::Eliminated;
use crate::matrix::sparse::{Sparse, largest as largest_of};
use crate::system::{ConnectedComponent, System};
use nalgebra::{DMatrix, DVector, SymmetricEigen};
use pintle_kinematics::draw::Draw;
use pintle_model::evaluate::Sequence;
use pintle_scene::State;

/// Parts of more motions, or redundant constraints, are not looked at to second order.
const MOST: [usize; 2] = [400, 60];
/// The step of the differences (rad, or lengths of a connector): what is left out is of the size of its square.
const STEP: f64 = 1e-4;
/// A form is zero whose largest value on motions of length one is smaller: beyond what differences leave out by a factor of 100.
const ZERO: f64 = 1e-6;
/// One that is definite is no smaller, on motions of length one.
const DEFINITE: f64 = 1e-5;
/// Zeros of the forms that are tried.
const TRIED: usize = 6;

/// What second order says of a connected component.
pub(crate) struct Second {
    /// Motions that no form restrains.
    pub(crate) open: Vec<Vec<f64>>,
    /// Zeros of the forms among those that forms restrain; none where these are excluded.
    pub(crate) zeros: Vec<Vec<f64>>,
    /// Whether second order excludes all motions that forms restrain.
    pub(crate) excludes: bool,
    /// Of the dependent rows, those that restrain motions: as many as there are independent forms, the last ones.
    pub(crate) restraining: Vec<u32>,
}

/// The forms of a connected component, on the motions that are columns of a matrix.
struct Forms {
    motions: DMatrix<f64>,
    /// By dependent row.
    of: Vec<DMatrix<f64>>,
}

/// Looks at a connected component at the state to which the sequence comes next; `None` where it is too large, or costs more than may be spent.
pub(crate) fn second(
    system: &System<'_>,
    component: &ConnectedComponent,
    sequence: &Sequence<'_>,
    state: &State,
    here: &Eliminated,
    budget: &Budget,
) -> Option<Second> {
    let forms = forms(system, component, sequence, state, here, budget)?;
    let restraining = independent(&forms, &here.dependent);
    let columns = |vectors: &DMatrix<f64>| -> Vec<Vec<f64>> {
        (&forms.motions * vectors).column_iter().map(|column| column.iter().copied().collect()).collect()
    };
    let [open, rest] = divided(&forms)?;
    if restraining.is_empty() || rest.ncols() == 0 {
        let all = DMatrix::identity(forms.motions.ncols(), forms.motions.ncols());
        return Some(Second {
            open: columns(&all),
            zeros: Vec::new(),
            excludes: true,
            restraining: Vec::new(),
        });
    }
    let of_rest: Vec<DMatrix<f64>> =
        basis(&forms.of).iter().map(|form| rest.transpose() * form * &rest).collect();
    let excludes = is_definite(&of_rest, budget);
    let zeros = if excludes { Vec::new() } else { columns(&(&rest * zeros(&of_rest, rest.ncols(), budget))) };
    if budget.is_spent() {
        return None;
    }
    Some(Second { open: columns(&open), zeros, excludes, restraining })
}

fn forms(
    system: &System<'_>,
    component: &ConnectedComponent,
    sequence: &Sequence<'_>,
    state: &State,
    here: &Eliminated,
    budget: &Budget,
) -> Option<Forms> {
    if here.free.len() > MOST[0] || here.dependent.len() > MOST[1] || !(here.has_pivots() || here.rank == 0) {
        return None;
    }
    let jacobian = |state: &State| -> Option<Sparse> {
        let mut values = Vec::new();
        sequence.clone().assemble(state, &system.jacobian, &mut values).ok()?;
        Some(system.matrix(component, (state, &values), |role| role != Role::Driven).1)
    };
    let matrix = jacobian(state)?;
    if !dense::is_small(&matrix, dense::LARGEST) {
        return None;
    }
    let (width, count) = (matrix.width(), here.free.len());
    // Two states along each motion, the forms of what they differ in, and what the forms have in common.
    let evaluations = EVALUATION * system.evaluated_elements();
    let rows = ROW * component.rows.len();
    let of_forms = here.dependent.len() * count.pow(2) * (here.dependent.len() + 1) / PRODUCTS;
    let differences =
        2 * count * (evaluations + rows) + count * here.dependent.len() * matrix.values.len() / PRODUCTS;
    if !(budget.decompose(matrix.rows(), width) && budget.spend(differences + of_forms)) {
        return None;
    }
    let motion = |free: &u32| here.solve(width, |column| f64::from(u8::from(column == *free)), true);
    let motions = DMatrix::from_iterator(width, count, here.free.iter().flat_map(motion));
    let motions = motions.qr().q();
    let combinations = dense::combinations(&matrix, &here.dependent)?;
    if !dense::vanish(&matrix, &combinations) {
        return None;
    }
    let mut of = vec![DMatrix::zeros(count, count); here.dependent.len()];
    for (i, motion) in motions.column_iter().enumerate() {
        let moved = |by: f64| {
            let change: Vec<f64> = motion.iter().map(|x| x * by).collect();
            jacobian(&system.moved(component, state, &change))
        };
        let [after, before] = [moved(STEP)?, moved(-STEP)?];
        let mut rates = DMatrix::zeros(matrix.rows(), count);
        for row in 0..matrix.rows() {
            for at in matrix.range(row) {
                let rate = (after.values.get(at)? - before.values.get(at)?) / (2.0 * STEP);
                let column = matrix.columns[at] as usize;
                for k in 0..count {
                    rates[(row, k)] += rate * motions[(column, k)];
                }
            }
        }
        for (form, combination) in of.iter_mut().zip(combinations.column_iter()) {
            form.set_row(i, &(combination.transpose() * &rates));
        }
    }
    // What is not symmetric belongs to commutators of motions, which ω does not see.
    let of: Vec<DMatrix<f64>> = of.iter().map(|form| (form + form.transpose()) * 0.5).collect();
    of.iter().all(|form| form.iter().all(|x| x.is_finite())).then_some(Forms { motions, of })
}

fn as_vector(form: &DMatrix<f64>) -> DVector<f64> {
    DVector::from_column_slice(form.as_slice())
}

/// An orthonormal basis of forms, with the places of those that it was made of; the last ones are preferred.
fn orthonormal(forms: &[DMatrix<f64>]) -> Vec<(usize, DVector<f64>)> {
    let scale = forms.iter().map(|form| form.amax()).fold(1.0, f64::max);
    let mut basis: Vec<(usize, DVector<f64>)> = Vec::new();
    for (at, form) in forms.iter().enumerate().rev() {
        let mut rest = as_vector(form);
        for _ in 0..2 {
            for (_, other) in &basis {
                rest -= other * other.dot(&rest);
            }
        }
        if rest.amax() > ZERO * scale {
            let size = size(&rest);
            basis.push((at, rest / size));
        }
    }
    basis
}

fn basis(forms: &[DMatrix<f64>]) -> Vec<DMatrix<f64>> {
    let size = forms.first().map_or(0, DMatrix::nrows);
    let all = orthonormal(forms).into_iter();
    all.map(|(_, form)| DMatrix::from_column_slice(size, size, form.as_slice())).collect()
}

/// The dependent rows of independent forms, ascending.
fn independent(forms: &Forms, dependent: &[u32]) -> Vec<u32> {
    let mut rows: Vec<u32> =
        orthonormal(&forms.of).iter().filter_map(|(at, _)| dependent.get(*at).copied()).collect();
    rows.sort_unstable();
    rows
}

/// The motions that no form restrains, and those across them.
fn divided(forms: &Forms) -> Option<[DMatrix<f64>; 2]> {
    let count = forms.motions.ncols();
    let mut sum = DMatrix::<f64>::zeros(count, count);
    for form in &basis(&forms.of) {
        sum += form * form;
    }
    let eigen = SymmetricEigen::try_new(sum, f64::EPSILON, 10_000)?;
    let of = |is_open: bool| -> DMatrix<f64> {
        let chosen: Vec<DVector<f64>> = (0..count)
            .filter(|at| (eigen.eigenvalues[*at] < ZERO * ZERO * 1e2) == is_open)
            .map(|at| eigen.eigenvectors.column(at).into_owned())
            .collect();
        if chosen.is_empty() { DMatrix::zeros(count, 0) } else { DMatrix::from_columns(&chosen) }
    };
    Some([of(true), of(false)])
}

fn combined(forms: &[DMatrix<f64>], weights: &DVector<f64>) -> DMatrix<f64> {
    let size = forms.first().map_or(0, DMatrix::nrows);
    let mut sum = DMatrix::zeros(size, size);
    for (form, weight) in forms.iter().zip(weights.iter()) {
        sum += form * *weight;
    }
    sum
}

/// Whether a combination of forms is found that is definite: a combination that is negative along a motion takes more of the forms that
/// are positive there (the perceptron).
fn is_definite(forms: &[DMatrix<f64>], budget: &Budget) -> bool {
    /// So many eigenvalue problems of sixty motions; of more fewer, by what they cost.
    const TIMES: usize = 300;
    const MOTIONS: usize = 60;
    let values =
        |v: &DVector<f64>| DVector::from_iterator(forms.len(), forms.iter().map(|form| v.dot(&(form * v))));
    let mut weights = DVector::from_iterator(forms.len(), forms.iter().map(|form| form.trace()));
    let count = forms.first().map_or(0, DMatrix::nrows).max(MOTIONS);
    for _ in 0..(TIMES * MOTIONS.pow(3) / count.pow(3)).max(3) {
        let length = size(&weights);
        let size_of = forms.first().map_or(0, DMatrix::nrows);
        if !(budget.spend(forms.len() * size_of.pow(2) / PRODUCTS) && budget.decompose(size_of, size_of)) {
            return false;
        }
        if length > 0.0 {
            weights /= length;
        }
        let Some(eigen) = SymmetricEigen::try_new(combined(forms, &weights), f64::EPSILON, 10_000) else {
            return false;
        };
        let (at, least) = eigen.eigenvalues.argmin();
        if least > DEFINITE {
            return true;
        }
        let more = values(&eigen.eigenvectors.column(at).into_owned());
        if size(&more) < DEFINITE {
            // A motion along which all forms are zero.
            return false;
        }
        weights += more * 0.5;
    }
    false
}

/// Motions of length one along which all forms are zero, by Gauss and Newton from random ones.
fn zeros(forms: &[DMatrix<f64>], width: usize, budget: &Budget) -> DMatrix<f64> {
    const STARTS: usize = 40;
    const TIMES: usize = 60;
    let mut draw = Draw::new("zeros of forms");
    let mut found: Vec<DVector<f64>> = Vec::new();
    for _ in 0..STARTS {
        let mut v = DVector::from_fn(width, |_, _| draw.between(-1.0, 1.0));
        for _ in 0..TIMES {
            if !(budget.spend(2 * forms.len() * width.pow(2) / PRODUCTS)
                && budget.decompose(forms.len(), width))
            {
                break;
            }
            v /= size(&v).max(f64::MIN_POSITIVE);
            let values = DVector::from_iterator(forms.len(), forms.iter().map(|form| v.dot(&(form * &v))));
            if values.amax() < ZERO * ZERO {
                break;
            }
            // Along the sphere: along v itself the forms of degree two would only halve it.
            let slope = |(form, value): (&DMatrix<f64>, &f64)| ((form * &v - &v * *value) * 2.0).transpose();
            let slopes: Vec<_> = forms.iter().zip(values.iter()).map(slope).collect();
            let slopes = DMatrix::from_rows(&slopes);
            let right = DMatrix::from_column_slice(values.len(), 1, values.as_slice());
            let Some(step) = dense::solution(&slopes, &right, f64::EPSILON) else { break };
            v -= step.column(0);
        }
        v /= size(&v).max(f64::MIN_POSITIVE);
        let worst = forms.iter().map(|form| v.dot(&(form * &v)).abs()).fold(0.0, f64::max);
        let is_new = found.iter().all(|other| other.dot(&v).abs() < 0.999);
        if worst < ZERO && is_new && found.len() < TRIED {
            found.push(v);
        }
    }
    if found.is_empty() { DMatrix::zeros(width, 0) } else { DMatrix::from_columns(&found) }
}

/// A mixture of motions, whose largest amount is `step`; others for other samples.
pub(crate) fn mixed(motions: &[Vec<f64>], sample: usize, step: f64) -> Option<Vec<f64>> {
    let width = motions.first()?.len();
    let mut draw = Draw::new(&format!("motions {sample}"));
    let mut sum = vec![0.0; width];
    for motion in motions {
        let weight = draw.between(-1.0, 1.0);
        sum.iter_mut().zip(motion).for_each(|(sum, x)| *sum += weight * x);
    }
    let largest = largest_of(&sum);
    (largest > 0.0).then(|| sum.iter().map(|x| x * step / largest).collect())
}
