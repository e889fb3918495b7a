//! Rows of first derivatives.

use super::{DF, F, Right, Wrong, each, one, part, put, row};
use pintle_audit::Numbers;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{add, apply, apply_transposed, cross, product, scale, sub, transpose};

/// Changes every row.
fn rows(numbers: &mut Numbers<f64>, change: impl Fn(&mut [f64])) {
    numbers.entries_mut(DF).0.iter_mut().flatten().for_each(|row| change(row));
}

pub(super) const ALL: &[Wrong] = &[
    Wrong::new(
        ("CARTESIAN", "the axes of a are taken for fixed: no columns θ"),
        &[F, DF],
        |_, numbers| rows(numbers, |row| put(row, 3, [0.0; 3])),
        (&["diagnosis::geometric-term-missing"], "∂u1"),
    ),
    Wrong::new(
        ("SLOT", "the lever d × e for e × d"),
        &[F, DF],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| put(row, 3, cross(right.d(), right.a(k))));
            }
        },
        (&["diagnosis::geometric-term-reversed", "diagnosis::sign-of-block"], "∂u1"),
    ),
    Wrong::new(
        ("PLANAR", "the lever counted twice"),
        &[F, DF],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| put(row, 3, scale(cross(right.a(k), right.d()), 2.0)));
            }
        },
        (&["diagnosis::geometric-term-doubled", "diagnosis::rotation-doubled"], "∂u2"),
    ),
    Wrong::new(
        ("JOIN", "the lever on b"),
        &[F, DF],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    put(row, 3, [0.0; 3]);
                    put(row, 10, cross(right.a(k), right.d()));
                });
            }
        },
        (&["diagnosis::lever-at-b", "diagnosis::columns-swapped"], "∂u1"),
    ),
    Wrong::new(
        ("REVOLUTE", "rotations of both nodes along their own axes"),
        &[F, DF],
        |right, numbers| {
            rows(numbers, |row| {
                put(row, 3, apply_transposed(&right.pair().a.triad, part(row, 3)));
                put(row, 10, apply_transposed(&right.pair().b.triad, part(row, 10)));
            });
        },
        (&["diagnosis::rotation-as-local"], "∂ur1"),
    ),
    Wrong::new(
        ("UNIVERSAL", "rotations of b along the axes of a"),
        &[F, DF],
        |right, numbers| {
            rows(numbers, |row| {
                put(row, 3, apply_transposed(&right.pair().a.triad, part(row, 3)));
                put(row, 10, apply_transposed(&right.pair().a.triad, part(row, 10)));
            });
        },
        (&["diagnosis::rotation-as-local"], "∂ur3"),
    ),
    Wrong::new(
        ("EULER", "A g for g"),
        &[F, DF],
        |right, numbers| rows(numbers, |row| put(row, 3, apply(&right.pair().a.triad, part(row, 3)))),
        (&["diagnosis::rotation-turned-twice"], "∂ur2"),
    ),
    Wrong::new(
        ("CARTESIAN", "displacements in the frame of a"),
        &[F, DF],
        |_, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    let e = [0, 1, 2].map(|i| f64::from(u8::from(i == k)));
                    put(row, 0, scale(e, -1.0));
                    put(row, 7, e);
                });
            }
        },
        (&["diagnosis::displacement-as-local", "diagnosis::global-axes"], "∂u1"),
    ),
    Wrong::new(
        ("ALIGN", "variations of the total rotation vector of b"),
        &[F, DF],
        |right, numbers| {
            let (now, initial) = (right.pair(), right.initial());
            let phi = so3::log(&product(&now.b.triad, &transpose(&initial.b.triad)));
            let jacobian = transpose(&so3::left_jacobian(phi));
            rows(numbers, |row| put(row, 10, apply(&jacobian, part(row, 10))));
        },
        (&["diagnosis::total-vector"], "∂ur1/∂θb1..3"),
    ),
    Wrong::new(
        ("ROTATION", "e_i of a for the gradient"),
        &[F, DF],
        |right, numbers| {
            for i in 0..3 {
                row(numbers, DF, 3 + i, |row| {
                    put(row, 3, scale(right.a(i), -1.0));
                    put(row, 10, right.a(i));
                });
            }
        },
        (&["diagnosis::axis-for-gradient"], "∂ur1"),
    ),
    Wrong::new(
        ("CARDAN", "the axes about which the angles turn for their gradients"),
        &[F, DF],
        |right, numbers| {
            for (k, axis) in [(3, right.a(0)), (5, right.b(2))] {
                row(numbers, DF, k, |row| {
                    put(row, 3, scale(axis, -1.0));
                    put(row, 10, axis);
                });
            }
        },
        (&["diagnosis::axis-for-gradient"], "∂ur1"),
    ),
    Wrong::new(
        ("HINGE", "derivatives of the angle per degree"),
        &[F, DF],
        |_, numbers| row(numbers, DF, 3, |row| row.iter_mut().for_each(|x| *x = x.to_radians())),
        (&["diagnosis::degrees"], "∂ur1"),
    ),
    Wrong::new(
        ("CYLINDRICAL", "the derivative of the angle in degrees"),
        &[F, DF],
        |_, numbers| row(numbers, DF, 3, |row| row.iter_mut().for_each(|x| *x = x.to_degrees())),
        (&["diagnosis::degrees"], "∂ur1"),
    ),
    Wrong::new(
        ("LINK", "the sign of b's columns at both nodes"),
        &[F, DF],
        |_, numbers| {
            row(numbers, DF, 0, |row| {
                let of_b = part(row, 7);
                put(row, 0, of_b);
            });
        },
        (&["diagnosis::sign-of-a", "diagnosis::sign-of-block"], "∂u1"),
    ),
    Wrong::new(
        ("AXIAL", "only node b has columns"),
        &[F, DF],
        |_, numbers| row(numbers, DF, 0, |row| row[..7].fill(0.0)),
        (&["diagnosis::node-left-out", "diagnosis::block-missing"], "∂u1"),
    ),
    Wrong::new(
        ("RADIAL-THRUST", "nodes exchanged in the columns"),
        &[F, DF],
        |_, numbers| rows(numbers, |row| row.rotate_left(7)),
        (&["diagnosis::nodes-swapped"], "∂u1"),
    ),
    Wrong::new(
        ("CVJOINT", "rotations before displacements"),
        &[F, DF],
        |_, numbers| {
            rows(numbers, |row| {
                for at in [0, 7] {
                    let (x, theta) = (part(row, at), part(row, at + 3));
                    put(row, at, theta);
                    put(row, at + 3, x);
                }
            });
        },
        (&["diagnosis::columns-swapped"], "∂u1"),
    ),
    Wrong::new(
        ("TRANSLATOR", "columns θ1 and θ3 exchanged"),
        &[F, DF],
        |_, numbers| {
            rows(numbers, |row| {
                row.swap(3, 5);
                row.swap(10, 12);
            });
        },
        (&["diagnosis::columns-swapped"], "∂u1"),
    ),
    Wrong::new(
        ("FLEXION-TORSION", "the rows of ur1 and ur2 exchanged"),
        &[F, DF],
        |_, numbers| numbers.entries_mut(DF).0.swap(3, 4),
        (&["diagnosis::components-swapped"], "∂ur1"),
    ),
    Wrong::new(
        ("SLIDE-PLANE", "a 3 × 3 block transposed"),
        &[F, DF],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| put(row, 7, [0, 1, 2].map(|i| right.a(i)[k])));
            }
        },
        (&["diagnosis::block-transposed"], "∂u1"),
    ),
    Wrong::new(
        ("PROJECTION CARTESIAN", "midway directions that do not turn"),
        &[F, DF],
        |_, numbers| {
            rows(numbers, |row| {
                put(row, 3, [0.0; 3]);
                put(row, 10, [0.0; 3]);
            });
        },
        (&["diagnosis::block-missing"], "∂u1"),
    ),
    Wrong::new(
        ("PROJECTION FLEXION-TORSION", "twice the rotations: the quaternion's half angle undone twice"),
        &[F, DF],
        |_, numbers| {
            rows(numbers, |row| {
                put(row, 3, scale(part(row, 3), 2.0));
                put(row, 10, scale(part(row, 10), 2.0));
            });
        },
        (&["diagnosis::rotation-doubled", "diagnosis::factor"], "∂ur1"),
    ),
    Wrong::new(
        ("BUSHING", "half the rotations"),
        &[F, DF],
        |_, numbers| {
            rows(numbers, |row| {
                put(row, 3, scale(part(row, 3), 0.5));
                put(row, 10, scale(part(row, 10), 0.5));
            });
        },
        (&["diagnosis::rotation-halved"], "∂u1"),
    ),
    Wrong::new(
        ("FLOW-CONVERTER", "b minus a"),
        &[DF],
        |_, numbers| row(numbers, DF, 5, |row| row.iter_mut().for_each(|x| *x = -*x)),
        (&["diagnosis::sign", "diagnosis::nodes-swapped"], "∂ur3"),
    ),
    Wrong::new(
        ("RETRACTOR", "the radius for its reciprocal in the column of flow"),
        &[DF],
        |right, numbers| {
            let scale = right.definition.flow_scale;
            one(numbers, DF, (5, 13), |_| -1.0 / scale);
        },
        (&["diagnosis::factor", "diagnosis::scaled"], "∂ur3"),
    ),
    Wrong::new(
        ("SLIPRING", "flow at b with the sign of that at a"),
        &[DF],
        |_, numbers| one(numbers, DF, (0, 13), |x| -x),
        (&["diagnosis::sign-of-block", "diagnosis::sign-of-entry"], "∂u1"),
    ),
    Wrong::new(
        ("BEAM", "columns of displacements per millimetre"),
        &[DF],
        |_, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    put(row, 0, scale(part(row, 0), 1e-3));
                    put(row, 7, scale(part(row, 7), 1e-3));
                });
            }
        },
        (&["diagnosis::unit-of-length"], "∂u1"),
    ),
    Wrong::new(
        ("UJOINT", "the row of ur3 is never filled"),
        &[F, DF],
        |_, numbers| row(numbers, DF, 5, |row| row.fill(0.0)),
        (&["diagnosis::component-zero"], "∂ur3"),
    ),
    Wrong::new(
        ("ACCELEROMETER", "rows of coordinates along b"),
        &[F, DF],
        |right, numbers| {
            for k in 0..3 {
                row(numbers, DF, k, |row| {
                    put(row, 0, scale(right.b(k), -1.0));
                    put(row, 3, [0.0; 3]);
                    put(row, 7, right.b(k));
                    put(row, 10, cross(right.b(k), right.d()));
                });
            }
        },
        (&["diagnosis::axes-of-b"], "∂u1"),
    ),
    Wrong::new(
        ("WELD", "rotation columns of both nodes exchanged"),
        &[F, DF],
        |_, numbers| {
            rows(numbers, |row| {
                let (a, b) = (part(row, 3), part(row, 10));
                put(row, 3, b);
                put(row, 10, a);
            });
        },
        (&["diagnosis::columns-swapped"], "∂u1"),
    ),
    Wrong::new(
        ("CONSTANT VELOCITY", "a row of the principal direction (e3a + e3b), not divided by 1 + e3a·e3b"),
        &[DF],
        |right, numbers| {
            let axis = add(right.a(2), right.b(2));
            row(numbers, DF, 4, |row| {
                put(row, 3, scale(axis, -1.0));
                put(row, 10, axis);
            });
        },
        (&["diagnosis::axis-for-gradient"], "∂ur2"),
    ),
    Wrong::new(
        ("ROTATION-ACCELEROMETER", "columns of a not with the opposite sign"),
        &[DF],
        |_, numbers| rows(numbers, |row| put(row, 3, scale(part(row, 3), -1.0))),
        (&["diagnosis::sign-of-a", "diagnosis::sign-of-block"], "∂ur1"),
    ),
    Wrong::new(
        ("HINGE", "the row of an increment before"),
        &[DF],
        |right: &Right<'_>, numbers| {
            let Some(step) = right.path.last() else { return };
            let before = (right.at)(&step.state);
            each(numbers, DF, |k, i, _| before.entries(DF).get(k, i).unwrap());
        },
        (&["diagnosis::state-before"], "∂ur1"),
    ),
    Wrong::new(
        ("CARTESIAN", "the lever of d − d₀"),
        &[DF],
        |right, numbers| {
            let moved = sub(right.d(), right.initial().separation());
            for k in 0..3 {
                row(numbers, DF, k, |row| put(row, 3, cross(right.a(k), moved)));
            }
        },
        (&["diagnosis::initial-separation-turned"], "∂u1"),
    ),
];
