//! Rows that are a sum of two directions, or a product of two: with a term left out, or with another sign or factor.

use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::matching::Hypothesis;
use crate::mutants::mutant::{part, put};
use pintle_kinematics::node::{THETA_A, THETA_B, XB};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::{Matrix, Vector, add, column, cross, dot, scale, sub};

/// A direction is a sum, or a product, to this part of its length.
const MET: f64 = 1e-9;

/// Terms that are smaller than this part of the sum are none.
const NOTHING: f64 = 1e-6;

/// The directions of both nodes, with their names.
fn directions(triads: [&Matrix<f64>; 2]) -> Vec<(String, Vector<f64>)> {
    let of = |(triad, node): (&Matrix<f64>, char)| {
        [0, 1, 2].map(|i| (format!("e{}{node}", i + 1), column(triad, i)))
    };
    triads.into_iter().zip(['a', 'b']).flat_map(of).collect()
}

/// What is left of a row where a term of its gradient is missing, or has another sign or factor.
pub(super) fn parts(
    k: usize,
    row: &[f64],
    (triads, separation): ([&Matrix<f64>; 2], Vector<f64>),
) -> Vec<Hypothesis> {
    let at = if k < 3 { XB } else { THETA_B };
    let gradient = part(row, at);
    let size = norm(gradient);
    let opposite = part(row, at - XB);
    if size == 0.0 || norm(add(gradient, opposite)) > MET * size {
        return Vec::new();
    }
    let made = |of: Vector<f64>| {
        let lever = if k < 3 { put(THETA_A, cross(of, separation)) } else { Vec::new() };
        put(at, of).into_iter().chain(put(at - XB, of.map(|x| -x))).chain(lever)
    };
    let directions = directions(triads);
    let mut found = Vec::new();
    for (n, (one, p)) in directions.iter().enumerate() {
        for (other, q) in &directions[n + 1..] {
            let apart = 1.0 - dot(*p, *q).powi(2);
            if apart < NOTHING {
                continue;
            }
            let [along_p, along_q] = [dot(gradient, *p), dot(gradient, *q)];
            let x = (along_p - dot(*p, *q) * along_q) / apart;
            let y = along_q - dot(*p, *q) * x;
            let is_sum = norm(sub(gradient, add(scale(*p, x), scale(*q, y)))) <= MET * size;
            if is_sum && x.abs().min(y.abs()) > NOTHING * size {
                for (cause, x, y, what) in [
                    (Cause::TermLeftOut, 0.0, y, format!("without its term along {one}")),
                    (Cause::TermLeftOut, x, 0.0, format!("without its term along {other}")),
                    (Cause::TermLeftOut, -x, y, format!("with minus its term along {one}")),
                    (Cause::TermLeftOut, x, -y, format!("with minus its term along {other}")),
                    (
                        Cause::ParametersSwapped,
                        y,
                        x,
                        format!("with the factors of {one} and {other} exchanged"),
                    ),
                    (Cause::ParametersSwapped, x, x, format!("with the factor of {one} at {other}, too")),
                    (Cause::ParametersSwapped, y, y, format!("with the factor of {other} at {one}, too")),
                ] {
                    let changed = made(add(scale(*p, x), scale(*q, y)));
                    let made = Hypothesis::of_row(cause, k, changed);
                    found.push(made.related(format!("what is expected {what}")));
                }
            }
            let product = cross(*p, *q);
            let is_product = k >= 3
                && [1.0, -1.0]
                    .into_iter()
                    .any(|sign| norm(sub(gradient, scale(product, sign))) <= MET * size);
            for (i, sign) in [0, 1, 2].into_iter().flat_map(|i| [(i, 1.0), (i, -1.0)]).filter(|_| is_product)
            {
                let (j, l) = ((i + 1) % 3, (i + 2) % 3);
                let mut typed = gradient;
                typed[i] = sign * (p[j] * q[l] + p[l] * q[j]);
                let made = Hypothesis::of_row(Cause::BlockReversed, k, made(typed));
                let what = format!("what is expected with a plus for the minus in {one} × {other}");
                found.push(made.related(what));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{parts, put};
    use pintle_kinematics::node::{DOFS, THETA_A, THETA_B, XB};
    use pintle_kinematics::so3::exp;
    use pintle_kinematics::vector::{add, column, cross, scale};

    /// A plus in one product of e1a × e2b, and a sum of two directions with a term left out, are among what is tried.
    #[test]
    fn products_and_sums_of_directions_are_tried() {
        let (a, b) = (exp([0.3, -0.8, 0.5]), exp([-1.1, 0.2, 0.7]));
        let [p, q] = [column(&a, 0), column(&b, 1)];
        let row = |k: usize, gradient: [f64; 3]| {
            let mut row = [0.0; DOFS];
            let at = if k < 3 { XB } else { THETA_B };
            for (j, x) in put(at, gradient).into_iter().chain(put(at - XB, gradient.map(|x| -x))) {
                row[j] = x;
            }
            row
        };
        let said = |k: usize, gradient: [f64; 3], typed: [f64; 3]| {
            let found = parts(k, &row(k, gradient), ([&a, &b], [0.4, 0.1, -0.3]));
            let at = if k < 3 { XB } else { THETA_B };
            let is_it = |changes: &[(usize, usize, f64)]| {
                (0..3).all(|i| changes.iter().any(|(_, j, x)| *j == at + i && (x - typed[i]).abs() < 1e-12))
            };
            found
                .iter()
                .filter(|made| is_it(&made.changes))
                .filter_map(|made| made.relation.clone())
                .collect::<Vec<_>>()
        };
        let product = cross(p, q);
        let typed = [product[0], p[2] * q[0] + p[0] * q[2], product[2]];
        assert_eq!(said(4, product, typed), ["what is expected with a plus for the minus in e1a × e2b"]);
        let sum = add(scale(p, 1.7), scale(q, -0.6));
        assert_eq!(said(4, sum, scale(p, 1.7)), ["what is expected without its term along e2b"]);
        assert_eq!(
            said(0, sum, add(scale(p, 1.7), scale(q, 1.7))),
            ["what is expected with the factor of e1a at e2b, too"]
        );
        assert_eq!(row(0, sum)[THETA_A], 0.0);
        assert!(parts(4, &[0.0; DOFS], ([&a, &b], [0.0; 3])).is_empty());
    }
}
