//! The nodal forces of a whole element whose components are springs, and their derivatives: what a user element gives.
//!
//! Its energy is E = ½ Σ_k D_k c_k², c_k being the residual of a constrained component and the displacement of any other. So
//! p_j = Σ_k D_k c_k ∂_j c_k, and the second derivatives of E along exp(δθ^) C are Σ_k D_k (∂_i c_k ∂_j c_k + c_k ∂_ij c_k). The
//! derivatives of p along spatial rotations have −½ M^ besides in the rotations of each node, M the moment on it: successive
//! rotations do not commute.

use super::WrongTable;
use super::given::{Element, Tangent};
use super::tables::diagnosed;
use crate::case::quantity::{Numbers, Quantity};
use crate::judge::bound::Bound;
use crate::judge::outcome::Check;
use crate::judge::table::{Entry, ResultTable};
use crate::mutants::diagnosis::{Cause, Hypothesis};
use pintle_kinematics::connector::Components;
use pintle_kinematics::node::{DOF, DOFS, THETA_A, THETA_B};
use pintle_kinematics::scalar::{Real, Wide};

/// The tables of what an element gave, from the right numbers of its components. A component without a stiffness bears nothing.
pub(super) fn tables(
    given: &Element,
    (springs, kind): (&[Option<f64>; 6], Tangent),
    right: &Numbers<Wide>,
    first: &Components<f64>,
    bound: &Bound,
) -> Vec<ResultTable> {
    let zero = Wide::from_f64(0.0);
    let mut force = [(zero, 0.0); DOFS];
    let mut slope = vec![(zero, 0.0); DOFS * DOFS];
    // Σ D ∂_i c ∂_j c alone.
    let mut material = vec![zero; DOFS * DOFS];
    // Springs that are slack where the position is zero: what these have besides.
    let mut of_first = [zero; DOFS];
    let mut slope_of_first = vec![zero; DOFS * DOFS];
    let initial = first;
    let (first, second) = (Quantity::FirstDerivatives, Quantity::SecondDerivatives);
    for (k, stiffness) in springs.iter().enumerate().filter_map(|(k, x)| Some((k, (*x)?))) {
        let Some(value) = right.entries(Quantity::Value).get(k, 0) else { continue };
        let d = Wide::from_f64(stiffness);
        let row = |j: usize| right.entries(first).get(k, j).unwrap_or(zero);
        let of_row = |j: usize| bound.scale(first, k, j);
        let (size, of_value) = (value.to_f64().abs(), bound.scale(Quantity::Value, k, 0));
        for (i, (entry, scale)) in force.iter_mut().enumerate() {
            *entry += d * value * row(i);
            of_first[i] += d * Wide::from_f64(initial[k].unwrap_or(0.0)) * row(i);
            *scale += stiffness.abs() * (size * of_row(i) + of_value * row(i).to_f64().abs());
        }
        for (n, (entry, scale)) in slope.iter_mut().enumerate() {
            let (i, j) = (n / DOFS, n % DOFS);
            let matrix = right.entries(second).get(k, n).unwrap_or(zero);
            *entry += d * (row(i) * row(j) + value * matrix);
            material[n] += d * row(i) * row(j);
            slope_of_first[n] += d * Wide::from_f64(initial[k].unwrap_or(0.0)) * matrix;
            let [x, y] = [row(i), row(j)].map(|x| x.to_f64().abs());
            let of_matrix = size * bound.scale(second, k, n) + of_value * matrix.to_f64().abs();
            *scale += stiffness.abs() * (of_row(i) * y + x * of_row(j) + of_matrix);
        }
    }
    if kind == Tangent::OfForces {
        for at in [THETA_A, THETA_B] {
            for axis in 0..3 {
                let (moment, of_moment) = force[at + axis];
                let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
                // M^ has −M_axis at (i, j).
                for (i, j, sign) in [(i, j, 1), (j, i, -1)] {
                    let (entry, scale) = &mut slope[(at + i) * DOFS + at + j];
                    *entry += moment * Wide::ratio(sign, 2);
                    *scale += of_moment / 2.0;
                }
            }
        }
    }
    let class = |j: usize| match j % (DOFS / 2) {
        0..=2 => 0,
        3..=5 => 1,
        _ => 2,
    };
    let mut tables = Vec::new();
    if let Some(got) = &given.forces {
        let mut table = ResultTable::new(Quantity::ElementForces);
        for (j, ((want, scale), got)) in force.iter().zip(got).enumerate() {
            let name = format!("p on {}", DOF[j]);
            table.rows.push(name.clone());
            table.entries.push(Entry::new(name, *got, *want, *scale, (0, class(j), 0)));
        }
        let other = |cause: Cause, relation: &str, of: &dyn Fn(usize) -> Wide| {
            let changes = (0..DOFS).map(|j| (j, 0, of(j).to_f64())).collect();
            Hypothesis::many(cause, changes).related(relation)
        };
        let half = Wide::ratio(1, 2);
        table.conventions = vec![
            other(Cause::Reversed, Cause::Reversed.relation(), &|j| -force[j].0),
            other(Cause::InitialKept, "Σ D x ∂c of positions x", &|j| force[j].0 + of_first[j]),
            other(Cause::InitialTwice, "Σ D c ∂c of displacements less the initial position", &|j| {
                force[j].0 - of_first[j]
            }),
            other(Cause::Factor, "half of what is expected, as E or c² halved once more", &|j| {
                half * force[j].0
            }),
        ];
        tables.push(table);
    }
    if let Some(got) = &given.stiffness {
        let mut table = ResultTable::new(Quantity::ElementStiffness);
        table.rows = DOF.map(|name| format!("∂p on {name}")).to_vec();
        table.columns = DOF.map(String::from).to_vec();
        let symmetric = |n: usize| {
            let (i, j) = (n / DOFS, n % DOFS);
            (slope[n].0 + slope[j * DOFS + i].0) * Wide::ratio(1, 2)
        };
        let geometric = |n: usize| slope[n].0 - material[n];
        let other = |cause: Cause, relation: &str, of: &dyn Fn(usize) -> Wide| {
            let changes = (0..DOFS * DOFS).map(|n| (n / DOFS, n % DOFS, of(n).to_f64())).collect();
            Hypothesis::many(cause, changes).related(relation)
        };
        let (missing, doubled) = (Cause::GeometricTermMissing, Cause::GeometricTermDoubled);
        let told = |how: &str| format!("what is expected {how} the geometric stiffness Σ D c ∂²c");
        let whole = format!("Σ D ∂c ∂c, {}", told("without"));
        let slack = "the stiffness of springs along positions, slack where these are zero";
        let half = Wide::ratio(1, 2);
        table.conventions = vec![
            other(missing, &whole, &|n| material[n]),
            other(Cause::LeverReversed, &told("with minus"), &|n| material[n] - geometric(n)),
            other(doubled, &told("with twice"), &|n| material[n] + geometric(n) + geometric(n)),
            other(missing, &told("with half of"), &|n| material[n] + half * geometric(n)),
            other(Cause::InitialKept, slack, &|n| slope[n].0 + slope_of_first[n]),
            other(Cause::Symmetrised, Cause::Symmetrised.relation(), &symmetric),
            other(Cause::Reversed, Cause::Reversed.relation(), &|n| -slope[n].0),
        ];
        for (n, ((want, scale), got)) in slope.iter().zip(got.as_flattened()).enumerate() {
            let (i, j) = (n / DOFS, n % DOFS);
            let name = format!("∂(p on {})/∂{}", DOF[i], DOF[j]);
            table.entries.push(Entry::new(name, *got, *want, *scale, (1, class(i), class(j))));
        }
        tables.push(table);
    }
    tables
}

/// Says of each check why the tables are wrong that were, one at a state: a cause holds over several.
pub(super) fn explain(checks: &mut [Check], wrong: &[WrongTable]) {
    for check in checks {
        let of = (check.against, check.quantity);
        let is_of = |(against, table): &&WrongTable| (*against, Some(table.quantity)) == of;
        diagnosed(check, wrong.iter().filter(is_of).map(|(_, table)| table));
    }
}
