//! The forces and moments that the manual prints, typed from its pages: nodal forces of every half, aligned and misaligned.

use super::{Pose, angle, entry, row, torsion_of};
use crate::laws::Check;
use crate::states::{Case, Ends, Extent, cases, dof_size};
use pintle_kinematics::connector::{NodalRow, Tally};
use pintle_kinematics::force::{ForceRows, Want};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, add, apply, column, cross, dot, scale, sub};

const FORCES: [f64; 6] = [1.5, -2.25, 0.75, -1.25, 3.5, 0.625];

/// The rows of a case, with its forces on every component that has one, and their nodal forces.
fn loaded(case: &Case) -> (ForceRows<f64>, [Option<f64>; 6], NodalRow<f64>) {
    let connector = case.connector();
    let end = case.end();
    let branch = connector.advance(&end.state, &end.increment, &case.branch_before(&connector));
    let want = Want { stiffness: true, multipliers: true, motions: [false; 6] };
    let rows = connector.force_rows(&end.state, &branch, [true; 6], want, &mut Tally::default());
    let forces = [0, 1, 2, 3, 4, 5].map(|k| connector.has_force(k).then_some(FORCES[k]));
    let nodal = rows.nodal(&forces);
    (rows, forces, nodal)
}

/// Compares nodal forces with those of a formula, over the size of all rows and their changes.
fn judge(name: &str, formula: impl Fn(&Case, &Pose) -> NodalRow<f64>) {
    let mut check = Check::of("forces by hand");
    for case in cases(entry(name), Extent::Full) {
        let (rows, forces, nodal) = loaded(&case);
        let size = |j: usize| dof_size(j, case.length);
        let mut all = 0.0;
        for k in 0..6 {
            let (Some(force), Some(row)) = (forces[k], rows.row(k)) else { continue };
            let change = row.change.as_ref().expect("changes were wanted");
            for i in 0..DOFS {
                all += (force * row.row[i]).abs() * size(i);
                all += (0..DOFS).map(|j| (force * change[i][j]).abs() * size(i) * size(j)).sum::<f64>();
            }
        }
        let expected = formula(&case, &Pose::of(&case));
        for j in 0..DOFS {
            let place = || format!("{}, {j}", case.name);
            check.against(place, nodal[j], expected[j], all / size(j));
        }
    }
    check.finish();
}

impl Pose {
    /// A force on b in the frame that a carries: −F on a with the moment F × d, F on b.
    fn force(&self, force: Vector<f64>) -> NodalRow<f64> {
        row(scale(force, -1.0), cross(force, self.d), force, [0.0; 3])
    }

    /// f1 e1a + f2 e2a + f3 e3a.
    fn frame(&self) -> NodalRow<f64> {
        self.force(along(self.a, [FORCES[0], FORCES[1], FORCES[2]]))
    }

    /// Along the axes e1a, cos α e2a + sin α e3a, e3b: the moment with M·axis_i = m_i.
    fn successive(&self, m: [f64; 3]) -> Vector<f64> {
        let [first, second, third] = self.cardan().map(|row| [row[10], row[11], row[12]]);
        along([first, second, third], m)
    }
}

fn along(v: [Vector<f64>; 3], c: [f64; 3]) -> Vector<f64> {
    add(add(scale(v[0], c[0]), scale(v[1], c[1])), scale(v[2], c[2]))
}

fn sum(one: NodalRow<f64>, other: NodalRow<f64>) -> NodalRow<f64> {
    std::array::from_fn(|j| one[j] + other[j])
}

const M: [f64; 3] = [FORCES[3], FORCES[4], FORCES[5]];

/// CARTESIAN, JOIN, SLOT, SLIDE-PLANE: f = f1 e1a + f2 e2a + f3 e3a, and f × d on a.
#[test]
fn forces_along_the_frame_of_a() {
    for name in ["CARTESIAN", "JOIN", "SLOT", "SLIDE-PLANE"] {
        judge(name, |_, pose| pose.frame());
    }
}

/// AXIAL, LINK: f1 q. SLIPRING besides: ∓f1 on the flows, f2 on that of b.
#[test]
fn forces_along_the_line_of_nodes() {
    for name in ["AXIAL", "LINK", "SLIPRING"] {
        judge(name, |case, pose| {
            let length = dot(pose.d, pose.d).sqrt();
            let q = if length > 0.0 { scale(pose.d, 1.0 / length) } else { [0.0; 3] };
            let pull = scale(q, FORCES[0]);
            let mut nodal = row(scale(pull, -1.0), [0.0; 3], pull, [0.0; 3]);
            if case.definition.connection.name == "SLIPRING" {
                (nodal[6], nodal[13]) = (-FORCES[0], FORCES[0] + FORCES[1]);
            }
            nodal
        });
    }
}

/// RADIAL-THRUST: f1 e_r + f3 e3a, and f × d on a.
#[test]
fn radial_and_thrust() {
    judge("RADIAL-THRUST", |_, pose| {
        let (x, y) = (dot(pose.a[0], pose.d), dot(pose.a[1], pose.d));
        let outward = scale(add(scale(pose.a[0], x), scale(pose.a[1], y)), 1.0 / (x * x + y * y).sqrt());
        pose.force(add(scale(outward, FORCES[0]), scale(pose.a[2], FORCES[2])))
    });
}

/// REVOLUTE, HINGE …: m1 (e1a − sin β e3b)/cos²β + m2 e2a + m3 e3a, misaligned or not: m2, m3 are perpendicular to e1a for every frozen
/// angle, and do no work on α.
#[test]
fn moments_of_revolute() {
    for (name, has_force) in [("REVOLUTE", false), ("HINGE", true), ("CYLINDRICAL", true), ("PLANAR", true)] {
        judge(name, |_, pose| {
            let kinetic = pose.successive([M[0], 0.0, 0.0]);
            let moment = add(kinetic, add(scale(pose.a[1], M[1]), scale(pose.a[2], M[2])));
            if has_force { sum(pose.frame(), angle(moment)) } else { angle(moment) }
        });
    }
}

/// CARDAN, UNIVERSAL, UJOINT: the dual vectors of the successive axes; UNIVERSAL's m2 is along cos α e2a + sin α e3a either way.
#[test]
fn moments_about_successive_axes() {
    judge("CARDAN", |_, pose| angle(pose.successive(M)));
    judge("UNIVERSAL", |_, pose| angle(pose.successive(M)));
    judge("UJOINT", |_, pose| sum(pose.frame(), angle(pose.successive(M))));
}

/// ALIGN, TRANSLATOR, BEAM, WELD: m1 e1a + m2 e2a + m3 e3a; for frozen angles M·axis_i = m_i about the axes frozen.
#[test]
fn moments_of_align() {
    for (name, has_force) in [("ALIGN", false), ("TRANSLATOR", true), ("BEAM", true), ("WELD", true)] {
        judge(name, |_, pose| {
            let [alpha, ..] = so3::cardan(&pose.q0);
            let second = add(scale(pose.a[1], alpha.cos()), scale(pose.a[2], alpha.sin()));
            let third = apply(&pose.triad_a, column(&pose.q0, 2));
            let axes = [pose.a[0], second, third];
            // By Cramer's rule.
            let volume = dot(axes[0], cross(axes[1], axes[2]));
            let duals = [cross(axes[1], axes[2]), cross(axes[2], axes[0]), cross(axes[0], axes[1])];
            let moment = scale(along(duals, M), 1.0 / volume);
            if has_force { sum(pose.frame(), angle(moment)) } else { angle(moment) }
        });
    }
}

/// CONSTANT VELOCITY: m2 (e3a + e3b)/(1 + e3a·e3b).
#[test]
fn moment_of_constant_velocity() {
    judge("CONSTANT VELOCITY", |_, pose| {
        let both = add(pose.a[2], pose.b[2]);
        angle(scale(both, M[1] * 2.0 / dot(both, both)))
    });
}

/// FLEXION-TORSION: m1 q + m2 (e3a + e3b)/(1 + c) + m3 (e3a − c e3b)/sin²α.
#[test]
fn moments_of_flexion_torsion() {
    judge("FLEXION-TORSION", |_, pose| {
        let (shaft_a, shaft_b) = (pose.a[2], pose.b[2]);
        let (across, both) = (cross(shaft_a, shaft_b), add(shaft_a, shaft_b));
        let square = dot(across, across);
        angle(along(
            [
                scale(across, 1.0 / square.sqrt()),
                scale(both, 2.0 / dot(both, both)),
                scale(sub(shaft_a, scale(shaft_b, dot(shaft_a, shaft_b))), 1.0 / square),
            ],
            M,
        ))
    });
}

/// PROJECTION CARTESIAN, BUSHING: f = Σ f_i e_i midway, whose moment N = f × d … loads both nodes through T; the flexions and torsion.
#[test]
fn forces_midway() {
    for (name, turns) in [("PROJECTION CARTESIAN", false), ("BUSHING", true)] {
        judge(name, |case, pose| {
            let middle = pose.middle(torsion_of(case));
            let mut nodal = [0.0; DOFS];
            for i in 0..3 {
                let of = middle.coordinate(i + 1, pose.d);
                nodal = sum(nodal, of.map(|entry| FORCES[i] * entry));
            }
            if turns {
                let [first, second] = middle.flexions();
                for (m, of) in M.into_iter().zip([first, second, pose.torsion()]) {
                    nodal = sum(nodal, of.map(|entry| m * entry));
                }
            }
            nodal
        });
    }
}

/// ROTATION: M = A H⁻ᵀ m, and the printed m_i = M·e_i^a beside it, another one unless m is along φ (decision D-6).
#[test]
fn moments_of_rotation() {
    judge("ROTATION", |case, pose| {
        let phi = case.evaluate(&pintle_kinematics::connector::Request::everything(0)).0.position;
        let rows = pose.rotation_vector([3, 4, 5].map(|c| phi[c].expect("an angle")));
        rows.into_iter().zip(M).fold([0.0; DOFS], |total, (of, m)| sum(total, of.map(|entry| m * entry)))
    });
    let mut differ = 0;
    for case in cases(entry("ROTATION"), Extent::Full) {
        let (rows, forces, nodal) = loaded(&case);
        let moment = [nodal[10], nodal[11], nodal[12]];
        let (pose, printed) = (Pose::of(&case), rows.printed(&forces));
        for i in 0..3 {
            let want = dot(moment, pose.a[i]);
            let got = printed[3 + i].expect("a printed moment");
            assert!((got - want).abs() < 1e-13 * (1.0 + dot(moment, moment)), "{}: {got} {want}", case.name);
            differ += usize::from((want - M[i]).abs() > 1e-3);
        }
    }
    assert!(differ > 20, "the printed moments are the conjugate ones");
}

/// FLOW-CONVERTER, RETRACTOR: m3 e3a on a, −m3 e3a on b, −β_s m3 on the flow of b.
#[test]
fn moments_of_a_drum() {
    for (name, has_force) in [("FLOW-CONVERTER", false), ("RETRACTOR", true)] {
        judge(name, |_, pose| {
            let mut drum = angle(scale(pose.a[2], -M[2]));
            drum[13] = -pose.flow_scale * M[2];
            if has_force { sum(pose.frame(), drum) } else { drum }
        });
    }
}

/// ACCELEROMETER and ROTATION-ACCELEROMETER have no forces.
#[test]
fn accelerometers_have_no_forces() {
    for name in ["ACCELEROMETER", "ROTATION-ACCELEROMETER"] {
        let case = &cases(entry(name), Extent::Brief)[0];
        let (_, forces, nodal) = loaded(case);
        assert_eq!((forces, nodal), ([None; 6], [0.0; DOFS]));
    }
}
