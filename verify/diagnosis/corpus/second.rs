//! Second derivatives.

use super::{DDF, DF, Right, Wrong, each, part, row};
use pintle_audit::Numbers;
use pintle_kinematics::vector::{apply, apply_transposed, cross};

const fn is_in(j: usize, at: usize) -> bool {
    j >= at && j < at + 3
}

const fn turns(j: usize) -> bool {
    is_in(j, 3) || is_in(j, 10)
}

/// Each entry by its place: component, row, column.
fn entries(numbers: &mut Numbers<f64>, change: impl Fn(usize, usize, usize, f64) -> f64) {
    each(numbers, DDF, |k, n, x| change(k, n / 14, n % 14, x));
}

/// Both sides of each matrix: `change` changes a row of it.
fn on_both(numbers: &mut Numbers<f64>, change: impl Fn(&mut [f64])) {
    for matrix in numbers.entries_mut(DDF).0.iter_mut().flatten() {
        for _ in 0..2 {
            matrix.chunks_mut(14).for_each(&change);
            let rows = matrix.clone();
            (0..196).for_each(|n| matrix[n] = rows[n % 14 * 14 + n / 14]);
        }
    }
}

/// ½ (e_i × e_j)·g of the rotations of a node.
fn bracket(right: &Right<'_>, k: usize, i: usize, j: usize) -> f64 {
    let Some(at) = [3, 10].into_iter().find(|at| is_in(i, *at) && is_in(j, *at)) else { return 0.0 };
    let axis = |n: usize| [0, 1, 2].map(|m| if at + m == n { 1.0 } else { 0.0 });
    let v = cross(axis(i), axis(j));
    (0..3).map(|m| v[m] * right.of(DF, k, at + m)).sum::<f64>() / 2.0
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("CARDAN", "derivatives of the rows, not symmetrised"),
        &[DF, DDF],
        |right, numbers| entries(numbers, |k, i, j, x| x + bracket(right, k, i, j)),
        (&["diagnosis::not-symmetrised"], "∂²ur1"),
    ),
    Wrong::new(
        ("UNIVERSAL", "the bracket in the other order"),
        &[DF, DDF],
        |right, numbers| entries(numbers, |k, i, j, x| x - bracket(right, k, i, j)),
        (&["diagnosis::not-symmetrised"], "∂²ur1"),
    ),
    Wrong::new(
        ("CARTESIAN", "the axes of a are held"),
        &[DF, DDF],
        |_, numbers| entries(numbers, |_, i, j, x| if is_in(i, 3) || is_in(j, 3) { 0.0 } else { x }),
        (
            &["diagnosis::frame-held", "diagnosis::component-zero", "diagnosis::geometric-term-missing"],
            "∂²u1",
        ),
    ),
    Wrong::new(
        ("JOIN", "no second derivatives at all: the row is taken for constant"),
        &[DDF],
        |_, numbers| entries(numbers, |_, _, _, _| 0.0),
        (
            &["diagnosis::component-zero", "diagnosis::geometric-term-missing", "diagnosis::frame-held"],
            "∂²u1",
        ),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "the upper triangle alone"),
        &[DDF],
        |_, numbers| entries(numbers, |_, i, j, x| if j < i { 0.0 } else { x }),
        (&["diagnosis::one-triangle"], "∂²u1"),
    ),
    Wrong::new(
        ("AXIAL", "blocks between the nodes with the sign of the others"),
        &[DDF],
        |_, numbers| entries(numbers, |_, i, j, x| if (i < 7) == (j < 7) { x } else { -x }),
        (&["diagnosis::sign-of-block", "diagnosis::sign-of-a"], "∂²u1"),
    ),
    Wrong::new(
        ("LINK", "minus the second derivatives"),
        &[DDF],
        |_, numbers| entries(numbers, |_, _, _, x| -x),
        (&["diagnosis::sign"], "∂²u1"),
    ),
    Wrong::new(
        ("SLOT", "half of the second derivatives: the ½ of Taylor kept"),
        &[DDF],
        |_, numbers| entries(numbers, |_, _, _, x| x / 2.0),
        (&["diagnosis::factor"], "∂²u1"),
    ),
    Wrong::new(
        ("EULER", "blocks of rotations halved"),
        &[DDF],
        |_, numbers| entries(numbers, |_, i, j, x| if turns(i) && turns(j) { x / 2.0 } else { x }),
        (&["diagnosis::rotation-halved", "diagnosis::factor"], "∂²ur1"),
    ),
    Wrong::new(
        ("REVOLUTE", "rotations along the axes of the nodes"),
        &[DDF],
        |right, numbers| {
            let [a, b] = [right.pair().a.triad, right.pair().b.triad];
            on_both(numbers, |row| {
                super::put(row, 3, apply_transposed(&a, part(row, 3)));
                super::put(row, 10, apply_transposed(&b, part(row, 10)));
            });
        },
        (&["diagnosis::rotation-as-local"], "∂²ur1"),
    ),
    Wrong::new(
        ("ALIGN", "rotations of a turned forth"),
        &[DDF],
        |right, numbers| {
            let a = right.pair().a.triad;
            on_both(numbers, |row| super::put(row, 3, apply(&a, part(row, 3))));
        },
        (&["diagnosis::rotation-turned-twice"], "∂²ur1"),
    ),
    Wrong::new(
        ("FLEXION-TORSION", "the matrices of ur1 and ur2 exchanged"),
        &[DDF],
        |_, numbers| numbers.entries_mut(DDF).0.swap(3, 4),
        (&["diagnosis::components-swapped"], "∂²ur1"),
    ),
    Wrong::new(
        ("BUSHING", "the nodes exchanged"),
        &[DDF],
        |_, numbers| {
            on_both(numbers, |row| row.rotate_left(7));
        },
        (&["diagnosis::nodes-swapped"], "∂²u1"),
    ),
    Wrong::new(
        ("TRANSLATOR", "no coupling between displacements and rotations"),
        &[DDF],
        |_, numbers| entries(numbers, |_, i, j, x| if turns(i) == turns(j) { x } else { 0.0 }),
        (&["diagnosis::block-missing"], "∂²u1"),
    ),
    Wrong::new(
        ("ROTATION", "per degree"),
        &[DDF],
        |_, numbers| {
            on_both(numbers, |row| {
                for j in (3..6).chain(10..13) {
                    row[j] = row[j].to_radians();
                }
            });
        },
        (&["diagnosis::degrees"], "∂²ur1"),
    ),
    Wrong::new(
        ("PLANAR", "the lever of d − d₀ in the matrix: rotations of a by themselves left out"),
        &[DDF],
        |_, numbers| entries(numbers, |_, i, j, x| if is_in(i, 3) && is_in(j, 3) { 0.0 } else { x }),
        (&["diagnosis::frame-held", "diagnosis::block-missing"], "∂²u1"),
    ),
    Wrong::new(
        ("CONSTANT VELOCITY", "the blocks between the nodes left out"),
        &[DDF],
        |_, numbers| {
            row(numbers, DDF, 4, |matrix| {
                (0..196).filter(|n| (n / 14 < 7) != (n % 14 < 7)).for_each(|n| matrix[n] = 0.0);
            })
        },
        (&["diagnosis::block-missing"], "∂²ur2"),
    ),
    Wrong::new(
        ("FLOW-CONVERTER", "transposed: ∂row_i/∂q_j where ∂row_j/∂q_i belongs"),
        &[DDF],
        |right, numbers| entries(numbers, |k, i, j, _| right.of(DDF, k, 14 * j + i)),
        (&["diagnosis::block-transposed"], "∂²ur3"),
    ),
];
