//! The functions under test, each on plain inputs, with first and second derivatives.

use pintle_kinematics::Differentiable;
use pintle_kinematics::scalar::{Real, Scalar, Seeded, elementary};
use pintle_kinematics::so3;
use pintle_kinematics::vector;
use pintle_kinematics::vector::{Matrix, Vector};

/// A function under test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Sqrt,
    InverseSqrt,
    Recip,
    SinCos,
    Atan2,
    Norm2,
    Norm3,
    Direction3,
    ExpQuaternion,
    ExpMatrix,
    LogQuaternion,
    LogMatrix,
    ContinuousLog,
    ContinuousLogMatrix,
    Cardan,
    Euler,
}

use Function::*;

pub(super) const ALL: [Function; 16] = [
    Sqrt,
    InverseSqrt,
    Recip,
    SinCos,
    Atan2,
    Norm2,
    Norm3,
    Direction3,
    ExpQuaternion,
    ExpMatrix,
    LogQuaternion,
    LogMatrix,
    ContinuousLog,
    ContinuousLogMatrix,
    Cardan,
    Euler,
];

impl Function {
    /// How many directions it is differentiated in.
    pub(super) fn directions(self) -> usize {
        match self {
            Sqrt | InverseSqrt | Recip | SinCos => 1,
            Atan2 | Norm2 => 2,
            _ => 3,
        }
    }

    /// The measures to apply: the name of the gate, and how many outputs are measured in one maximum norm.
    pub(super) fn measures(self) -> &'static [(&'static str, usize)] {
        match self {
            SinCos => &[("sin_cos", 1)],
            Cardan => &[("cardan", 3), ("cardan, each angle", 1)],
            Euler => &[("euler", 3), ("euler, each angle", 1)],
            Sqrt => &[("sqrt", 1)],
            InverseSqrt => &[("inverse_sqrt", 1)],
            Recip => &[("recip", 1)],
            Atan2 => &[("atan2", 1)],
            Norm2 => &[("norm2", 1)],
            Norm3 => &[("norm3", 1)],
            Direction3 => &[("direction3", 3)],
            ExpQuaternion => &[("exp_quaternion", 4)],
            ExpMatrix => &[("exp_matrix", 9)],
            LogQuaternion => &[("log_quaternion", 3)],
            LogMatrix => &[("log_matrix", 3)],
            ContinuousLog => &[("continuous_log", 3)],
            ContinuousLogMatrix => &[("continuous_log_matrix", 3)],
        }
    }

    /// Its name in the golden file.
    pub(super) fn name(self) -> &'static str {
        self.measures()[0].0
    }

    /// How many inputs are rounded numbers; those that follow select a branch.
    pub(super) fn rounded_inputs(self) -> usize {
        match self {
            Sqrt | InverseSqrt | Recip | SinCos => 1,
            Atan2 | Norm2 => 2,
            Norm3 | Direction3 | ExpQuaternion | ExpMatrix => 3,
            LogQuaternion | ContinuousLog => 4,
            LogMatrix | ContinuousLogMatrix | Cardan | Euler => 9,
        }
    }

    /// Whether it is the function of the exact rotation nearest to its inputs, and of derivatives along it whose seeds of second
    /// order are rounded.
    pub(super) fn is_log(self) -> bool {
        matches!(self, LogQuaternion | LogMatrix | ContinuousLog | ContinuousLogMatrix)
    }

    /// Per output its value, first derivatives and the upper triangle of the second, at the inputs `x`.
    ///
    /// The inputs of a rotation are its quaternion (w, x, y, z) or its matrix by rows; the reference of a continuous log and
    /// the sign of `Euler` follow.
    pub(super) fn numbers<R: Differentiable>(self, x: &[R]) -> Vec<Vec<R>> {
        match self {
            Sqrt => jets::<R, 1>([elementary::sqrt(seeded([x[0]])[0])]),
            InverseSqrt => jets::<R, 1>([elementary::inverse_sqrt(seeded([x[0]])[0])]),
            Recip => jets::<R, 1>([elementary::recip(seeded([x[0]])[0])]),
            SinCos => jets::<R, 1>(<[_; 2]>::from(elementary::sin_cos(seeded([x[0]])[0]))),
            Atan2 => {
                let [a, b] = seeded([x[0], x[1]]);
                jets::<R, 2>([elementary::atan2(a, b)])
            }
            Norm2 => jets::<R, 2>([elementary::norm(seeded([x[0], x[1]]))]),
            Norm3 => jets::<R, 3>([elementary::norm(seeded(three(x)))]),
            Direction3 => jets::<R, 3>(elementary::direction(seeded(three(x)))),
            ExpQuaternion => jets::<R, 3>(so3::exp_quaternion(seeded(three(x)))),
            ExpMatrix => jets::<R, 3>(so3::matrix(so3::exp_quaternion(seeded(three(x)))).concat()),
            LogQuaternion => jets::<R, 3>(so3::log_quaternion(turned::<R, R::Hessian<3>>(four(x)))),
            LogMatrix => jets::<R, 3>(so3::log(&turned_matrix::<R, R::Hessian<3>>(&nine(x)))),
            ContinuousLog => {
                let q = turned::<R, R::Hessian<3>>(four(x));
                jets::<R, 3>(so3::continuous_log_quaternion(q, three(&x[4..])).phi)
            }
            ContinuousLogMatrix => {
                let r = turned_matrix::<R, R::Hessian<3>>(&nine(x));
                jets::<R, 3>(so3::continuous_log(&r, three(&x[9..])).phi)
            }
            Cardan => jets::<R, 3>(so3::cardan(&turned_matrix::<R, R::Hessian<3>>(&nine(x)))),
            Euler => jets::<R, 3>(so3::euler(&turned_matrix::<R, R::Hessian<3>>(&nine(x)), x[9])),
        }
    }
}

fn jets<R: Differentiable, const N: usize>(outputs: impl IntoIterator<Item = R::Hessian<N>>) -> Vec<Vec<R>> {
    let numbers = |f: R::Hessian<N>| {
        let mut numbers = vec![f.real()];
        numbers.extend(f.gradient());
        let hessian = f.hessian();
        for (i, row) in hessian.iter().enumerate() {
            for (j, entry) in row.iter().enumerate() {
                if j >= i {
                    numbers.push(*entry);
                }
            }
        }
        numbers
    };
    outputs.into_iter().map(numbers).collect()
}

fn seeded<S: Seeded<N>, const N: usize>(x: [S::Real; N]) -> [S; N] {
    std::array::from_fn(|i| S::seed(x[i], i))
}

fn three<R: Real>(x: &[R]) -> Vector<R> {
    [x[0], x[1], x[2]]
}

fn four<R: Real>(x: &[R]) -> so3::Quaternion<R> {
    [x[0], x[1], x[2], x[3]]
}

fn nine<R: Real>(x: &[R]) -> Matrix<R> {
    [three(x), three(&x[3..]), three(&x[6..])]
}

/// (1 − |e|²/8, e/2) q at e = 0: exp(e) to second order, exact in floating point.
fn turned<R: Real, S: Scalar<Real = R> + Seeded<3>>(q: so3::Quaternion<R>) -> so3::Quaternion<S> {
    let e: Vector<S> = seeded([R::ZERO; 3]);
    let half = vector::scale(e, R::ratio(1, 2));
    let w = S::one() - vector::dot(e, e).scale(R::ratio(1, 8));
    so3::compose([w, half[0], half[1], half[2]], q.map(S::from_real))
}

/// (I + E + E²/2) R, E = e^, at e = 0: exp(e^) to second order, exact in floating point.
pub(super) fn turned_matrix<R: Real, S: Scalar<Real = R> + Seeded<3>>(r: &Matrix<R>) -> Matrix<S> {
    let [x, y, z]: Vector<S> = seeded([R::ZERO; 3]);
    let o = S::zero();
    let e: Matrix<S> = [[o, -z, y], [z, o, -x], [-y, x, o]];
    let first = vector::product(&e, &r.map(vector::constant));
    let second = vector::product(&e, &first);
    let mut turned = [[o; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            turned[i][j] = S::from_real(r[i][j]) + first[i][j] + second[i][j].scale(R::ratio(1, 2));
        }
    }
    turned
}
