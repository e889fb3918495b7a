//! Nodal forces and geometric stiffness.

use super::{DF, FORCE, Right, STIFF, Wrong, each, part, put, row};
use pintle_audit::Numbers;
use pintle_kinematics::vector::{apply_transposed, cross, scale};

fn rows(numbers: &mut Numbers<f64>, change: impl Fn(&mut [f64])) {
    numbers.entries_mut(FORCE).0.iter_mut().flatten().for_each(|row| change(row));
}

const fn is_of_a(j: usize) -> bool {
    j >= 3 && j < 6
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("CARTESIAN", "action for reaction"),
        &[FORCE],
        |_, numbers| each(numbers, FORCE, |_, _, x| -x),
        (&["diagnosis::sign"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("SLOT", "no moment at a: the lever is forgotten"),
        &[FORCE],
        |_, numbers| rows(numbers, |row| put(row, 3, [0.0; 3])),
        (&["diagnosis::geometric-term-missing"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("JOIN", "the moment of the lever at b"),
        &[FORCE],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, FORCE, k, |row| {
                    put(row, 3, [0.0; 3]);
                    put(row, 10, cross(right.d(), right.a(k)));
                });
            }
        },
        (&["diagnosis::lever-at-b"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("AXIAL", "force on b only"),
        &[FORCE],
        |_, numbers| rows(numbers, |row| row[..7].fill(0.0)),
        (&["diagnosis::node-left-out", "diagnosis::block-missing"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("LINK", "force on a only"),
        &[FORCE],
        |_, numbers| rows(numbers, |row| row[7..].fill(0.0)),
        (&["diagnosis::node-left-out", "diagnosis::block-missing"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("PLANAR", "forces along the axes of a"),
        &[FORCE],
        |right, numbers| {
            let a = right.pair().a.triad;
            rows(numbers, |row| {
                for at in [0, 7] {
                    put(row, at, apply_transposed(&a, part(row, at)));
                }
            });
        },
        (&["diagnosis::displacement-as-local"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("CARDAN", "moments along the axes of the nodes"),
        &[FORCE],
        |right, numbers| {
            let [a, b] = [right.pair().a.triad, right.pair().b.triad];
            rows(numbers, |row| {
                put(row, 3, apply_transposed(&a, part(row, 3)));
                put(row, 10, apply_transposed(&b, part(row, 10)));
            });
        },
        (&["diagnosis::rotation-as-local"], "nodal forces of ur1"),
    ),
    Wrong::new(
        ("REVOLUTE", "the conjugate moments of ur2 and ur3, where those along e2a and e3a are printed"),
        &[FORCE],
        |right, numbers| each(numbers, FORCE, |k, i, _| right.of(DF, k, i)),
        (&["diagnosis::conjugate-for-printed"], "nodal forces of ur2"),
    ),
    Wrong::new(
        ("ALIGN", "the conjugate moments"),
        &[FORCE],
        |right, numbers| each(numbers, FORCE, |k, i, _| right.of(DF, k, i)),
        (&["diagnosis::conjugate-for-printed"], "nodal forces of ur1"),
    ),
    Wrong::new(
        ("UNIVERSAL", "M = m e1a for the conjugate moment"),
        &[FORCE],
        |right, numbers| {
            row(numbers, FORCE, 3, |row| {
                put(row, 3, scale(right.a(0), -1.0));
                put(row, 10, right.a(0));
            })
        },
        (&["diagnosis::axis-for-gradient"], "nodal forces of ur1"),
    ),
    Wrong::new(
        ("TRANSLATOR", "the same force on both nodes"),
        &[FORCE],
        |_, numbers| {
            for k in 0..3 {
                row(numbers, FORCE, k, |row| put(row, 0, part(row, 7)));
            }
        },
        (&["diagnosis::sign-of-block", "diagnosis::sign-of-a"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("HINGE", "forces and moments in kN"),
        &[FORCE],
        |_, numbers| each(numbers, FORCE, |_, _, x| 1e-3 * x),
        (&["diagnosis::unit-of-length", "diagnosis::factor"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("SLIPRING", "the belt's tension without its flow forces"),
        &[FORCE],
        |_, numbers| row(numbers, FORCE, 0, |row| (row[6], row[13]) = (0.0, 0.0)),
        (&["diagnosis::block-missing"], "nodal forces of u1"),
    ),
    Wrong::new(
        ("RETRACTOR", "the belt's moment with the opposite sign"),
        &[FORCE],
        |_, numbers| row(numbers, FORCE, 5, |row| row.iter_mut().for_each(|x| *x = -*x)),
        (&["diagnosis::sign", "diagnosis::nodes-swapped"], "nodal forces of ur3"),
    ),
    Wrong::new(
        ("CARTESIAN", "the material part only"),
        &[FORCE, STIFF],
        |_, numbers| each(numbers, STIFF, |_, _, _| 0.0),
        (
            &["diagnosis::component-zero", "diagnosis::geometric-term-missing", "diagnosis::frame-held"],
            "stiffness of u1",
        ),
    ),
    Wrong::new(
        ("CYLINDRICAL", "forces do not turn with a: no derivatives by its rotations"),
        &[STIFF],
        |_, numbers| each(numbers, STIFF, |_, n, x| if is_of_a(n % 14) { 0.0 } else { x }),
        (&["diagnosis::frame-held"], "stiffness of u1"),
    ),
    Wrong::new(
        ("BEAM", "moments at a do not change"),
        &[STIFF],
        |_, numbers| each(numbers, STIFF, |_, n, x| if is_of_a(n / 14) { 0.0 } else { x }),
        (&["diagnosis::frame-held"], "stiffness of u1"),
    ),
    Wrong::new(
        ("WELD", "stiffness with the opposite sign"),
        &[STIFF],
        |_, numbers| each(numbers, STIFF, |_, _, x| -x),
        (&["diagnosis::sign"], "stiffness of u1"),
    ),
    Wrong::new(
        ("REVOLUTE", "stiffness transposed"),
        &[STIFF],
        |right: &Right<'_>, numbers| each(numbers, STIFF, |k, n, _| right.of(STIFF, k, n % 14 * 14 + n / 14)),
        (&["diagnosis::block-transposed"], "stiffness of ur2"),
    ),
    Wrong::new(
        ("CVJOINT", "twice the stiffness: both halves of a symmetric sum added"),
        &[STIFF],
        |_, numbers| each(numbers, STIFF, |_, _, x| 2.0 * x),
        (&["diagnosis::factor"], "stiffness of u1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "forces in the axes of b"),
        &[FORCE],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, FORCE, k, |row| {
                    put(row, 0, scale(right.b(k), -1.0));
                    put(row, 7, right.b(k));
                });
            }
        },
        (&["diagnosis::axes-of-b"], "nodal forces of u1"),
    ),
];
