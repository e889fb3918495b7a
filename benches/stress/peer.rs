//! The same quantities by nalgebra and num-dual as they come: what anyone would write first.

#![expect(clippy::disallowed_methods, reason = "what is drawn beside ours is what these give")]

use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use num_dual::{Dual64, DualNum};
use pintle_kinematics::node::DOFS;
use std::array;

/// nalgebra's order of the same four numbers.
pub(crate) fn rotation([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z))
}

/// A running sum of rotation vectors of the rotation of b relative to a.
pub(crate) struct Sum {
    before: UnitQuaternion<f64>,
    pub(crate) vector: Vector3<f64>,
}

impl Sum {
    pub(crate) fn from(quaternions: [[f64; 4]; 2], vector: [f64; 3]) -> Self {
        Self { before: Self::relative(quaternions), vector: vector.into() }
    }

    fn relative(quaternions: [[f64; 4]; 2]) -> UnitQuaternion<f64> {
        let [a, b] = quaternions.map(rotation);
        a.inverse() * b
    }

    pub(crate) fn add(&mut self, quaternions: [[f64; 4]; 2]) {
        let now = Self::relative(quaternions);
        self.vector += (now * self.before.inverse()).scaled_axis();
        self.before = now;
    }
}

pub(crate) type Dual = Dual64;
pub(crate) type Triad = Rotation3<Dual>;
pub(crate) type Position = Vector3<Dual>;

/// The triad of a node on duals, with a spin about a global axis. nalgebra's `Rotation3::new` takes a rotation vector of length zero for
/// no rotation, derivatives and all; the quaternion (1, ½ δθ) has them.
fn triad(quaternion: [f64; 4], axis: Option<usize>) -> Triad {
    let mut spin = [0.0; 3];
    if let Some(axis) = axis {
        spin[axis] = 0.5;
    }
    let [x, y, z] = spin.map(|half| Dual::new(0.0, half));
    let spin = UnitQuaternion::new_normalize(Quaternion::new(Dual::new(1.0, 0.0), x, y, z));
    let [w, x, y, z] = quaternion.map(Dual::from);
    let known = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
    (spin * known).to_rotation_matrix()
}

/// Values and rows of three functions of both triads and both positions: one evaluation on duals for each degree of freedom.
pub(crate) fn rows(
    quaternions: [[f64; 4]; 2],
    positions: [[f64; 3]; 2],
    of: impl Fn([Triad; 2], [Position; 2]) -> [Dual; 3],
) -> ([f64; 3], [[f64; DOFS]; 3]) {
    let mut rows = [[0.0; DOFS]; 3];
    let mut values = [0.0; 3];
    for j in 0..DOFS {
        let (node, at) = (j / 7, j % 7);
        let axis = |of: usize| (node == of && (3..6).contains(&at)).then(|| at - 3);
        let [a, b] = array::from_fn(|of| triad(quaternions[of], axis(of)));
        let position = |of: usize| {
            Vector3::from_fn(|i, _| Dual::new(positions[of][i], f64::from(u8::from(node == of && at == i))))
        };
        let found = of([a, b], [position(0), position(1)]);
        values = found.map(|x| x.re);
        for (row, x) in rows.iter_mut().zip(found) {
            row[j] = x.eps;
        }
    }
    (values, rows)
}

/// α, β, γ of CARDAN: those of `euler_angles`, which turns about the axes in the opposite order, of the transposed matrix.
pub(crate) fn cardan([a, b]: [Triad; 2], _: [Position; 2]) -> [Dual; 3] {
    let (alpha, beta, gamma) = (b.inverse() * a).euler_angles();
    [-alpha, -beta, -gamma]
}

/// α, β, γ of EULER, turns about 3, 1 and 3, of entries: `euler_angles_ordered` refuses first and third axes that are the same.
pub(crate) fn euler([a, b]: [Triad; 2], _: [Position; 2]) -> [Dual; 3] {
    let turned = a.inverse() * b;
    let entry = |i, j| turned[(i, j)];
    [entry(0, 2).atan2(-entry(1, 2)), entry(2, 2).acos(), entry(2, 0).atan2(entry(2, 1))]
}

/// u1 to u3 of CARTESIAN from current and initial positions.
pub(crate) fn cartesian(initial: [[f64; 3]; 2]) -> impl Fn([Triad; 2], [Position; 2]) -> [Dual; 3] {
    let [from, to] = initial.map(Vector3::from);
    let reference = (to - from).map(Dual::from);
    move |[a, _], [from, to]| (a.inverse() * (to - from) - reference).into()
}
