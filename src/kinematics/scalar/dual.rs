//! num-dual's dual numbers as [`Scalar`]s: one line per type, for any innermost number and any nesting.

use crate::scalar::lanes::{FirstOrder, Lanes, SecondOrder};
use crate::scalar::{Real, Scalar, Wide};
use nalgebra::{Const, SMatrix};
use num_dual::{Derivative, Dual, Dual2, Dual2SVec, Dual3, DualNumCopy, DualSVec, HyperDual, HyperHyperDual};

/// Derivative parts of a dual number: plain numbers of the inner type, or num-dual's optional matrices of them.
trait Part<T: Scalar> {
    fn scale_part(self, factor: T::Real) -> Self;
}

impl<T: Scalar> Part<T> for T {
    #[inline(always)]
    fn scale_part(self, factor: T::Real) -> Self {
        self.scale(factor)
    }
}

impl<T: Scalar + DualNumCopy, const R: usize, const C: usize> Part<T> for Derivative<T, Const<R>, Const<C>> {
    #[inline(always)]
    fn scale_part(mut self, factor: <T as Scalar>::Real) -> Self {
        if let Some(parts) = &mut self.0 {
            for part in parts.as_mut_slice() {
                *part = Scalar::scale(*part, factor);
            }
        }
        self
    }
}

macro_rules! dual_scalar {
    ($dual:ident, order $order:literal, [$($part:ident),*] $(, $n:ident)? $(; |$x:ident, $y:ident| [$($product:expr),*])?) => {
        impl<T: Scalar + DualNumCopy $(, const $n: usize)?> Scalar for $dual<T $(, $n)?> {
            type Real = <T as Scalar>::Real;
            const ORDER: usize = $order + T::ORDER;

            #[inline(always)]
            fn from_real(value: Self::Real) -> Self {
                Self::from_re(T::from_real(value))
            }

            #[inline(always)]
            fn real(self) -> Self::Real {
                Scalar::real(self.re)
            }

            #[inline(always)]
            fn nilpotent(self) -> Self {
                Self::new(self.re.nilpotent(), $(self.$part),*)
            }

            #[inline(always)]
            fn with_real(self, value: Self::Real) -> Self {
                Self::new(self.re.with_real(value), $(self.$part),*)
            }

            #[inline(always)]
            fn scale(self, factor: Self::Real) -> Self {
                Self::new(Scalar::scale(self.re, factor), $(Part::<T>::scale_part(self.$part, factor)),*)
            }
            $(

            #[inline(always)]
            fn nilpotent_times(self, other: Self) -> Self {
                let ($x, $y) = (self, other);
                Self::new($x.re.nilpotent_times($y.re), $($product),*)
            }
            )?
        }
    };
}

/// The part of a product over which derivatives are shared out: x₀ y′ + x′ y₀, where x₀ is nilpotent.
fn leibniz<T: Scalar, const N: usize>(x: T, y: T, shared: [(T, T); N]) -> T {
    shared.into_iter().fold(x.nilpotent_times(y), |sum, (x, y)| sum + x * y)
}

/// A number three times.
fn thrice<T: Scalar>(x: T) -> T {
    x.scale(T::Real::integer(3))
}

dual_scalar!(Dual, order 1, [eps]; |x, y| [leibniz(x.re, y.eps, [(x.eps, y.re)])]);
dual_scalar!(Dual2, order 2, [v1, v2]; |x, y| [
    leibniz(x.re, y.v1, [(x.v1, y.re)]),
    leibniz(x.re, y.v2, [(x.v1, y.v1), (x.v1, y.v1), (x.v2, y.re)])
]);
dual_scalar!(Dual3, order 3, [v1, v2, v3]; |x, y| [
    leibniz(x.re, y.v1, [(x.v1, y.re)]),
    leibniz(x.re, y.v2, [(x.v1, y.v1), (x.v1, y.v1), (x.v2, y.re)]),
    leibniz(x.re, y.v3, [(thrice(x.v1), y.v2), (thrice(x.v2), y.v1), (x.v3, y.re)])
]);
dual_scalar!(HyperDual, order 2, [eps1, eps2, eps1eps2]; |x, y| [
    leibniz(x.re, y.eps1, [(x.eps1, y.re)]),
    leibniz(x.re, y.eps2, [(x.eps2, y.re)]),
    leibniz(x.re, y.eps1eps2, [(x.eps1, y.eps2), (x.eps2, y.eps1), (x.eps1eps2, y.re)])
]);
dual_scalar!(HyperHyperDual, order 3, [eps1, eps2, eps3, eps1eps2, eps1eps3, eps2eps3, eps1eps2eps3]; |x, y| [
    leibniz(x.re, y.eps1, [(x.eps1, y.re)]),
    leibniz(x.re, y.eps2, [(x.eps2, y.re)]),
    leibniz(x.re, y.eps3, [(x.eps3, y.re)]),
    leibniz(x.re, y.eps1eps2, [(x.eps1, y.eps2), (x.eps2, y.eps1), (x.eps1eps2, y.re)]),
    leibniz(x.re, y.eps1eps3, [(x.eps1, y.eps3), (x.eps3, y.eps1), (x.eps1eps3, y.re)]),
    leibniz(x.re, y.eps2eps3, [(x.eps2, y.eps3), (x.eps3, y.eps2), (x.eps2eps3, y.re)]),
    leibniz(x.re, y.eps1eps2eps3, [
        (x.eps1, y.eps2eps3), (x.eps2, y.eps1eps3), (x.eps3, y.eps1eps2),
        (x.eps1eps2, y.eps3), (x.eps1eps3, y.eps2), (x.eps2eps3, y.eps1), (x.eps1eps2eps3, y.re)
    ])
]);
dual_scalar!(DualSVec, order 1, [eps], N);
dual_scalar!(Dual2SVec, order 2, [v1, v2], N);

/// A dual number in N directions at once, built from and taken apart into plain arrays.
///
/// | type | N | carries |
/// |---|---|---|
/// | `DualSVec`, `Dual2SVec` | any | first, and second derivatives |
/// | `Dual`, `Dual2`, `Dual3` | 1 | first; second; a third as well, which begins at zero |
/// | `HyperDual` | 2 | first, and the mixed second one |
pub trait Seeded<const N: usize>: Scalar {
    /// value + ε_index.
    fn seed(value: Self::Real, index: usize) -> Self;

    /// A value with its first derivatives and, where the type carries them, its second ones, on and below the diagonal.
    fn assemble(value: Self::Real, first: [Self::Real; N], second: [[Self::Real; N]; N]) -> Self;

    /// The first derivatives.
    fn gradient(self) -> [Self::Real; N];

    /// The second derivatives; zero where the type carries only the first.
    fn hessian(self) -> [[Self::Real; N]; N];
}

impl<R: Real + DualNumCopy, const N: usize> Seeded<N> for DualSVec<R, N> {
    #[inline(always)]
    fn seed(value: R, index: usize) -> Self {
        Self::from_re(value).derivative(index)
    }

    #[inline(always)]
    fn assemble(value: R, first: [R; N], _: [[R; N]; N]) -> Self {
        Self::new(value, Derivative::some(SMatrix::from(first)))
    }

    #[inline(always)]
    fn gradient(self) -> [R; N] {
        row(self.eps.0)
    }

    fn hessian(self) -> [[R; N]; N] {
        [[R::ZERO; N]; N]
    }
}

impl<R: Real + DualNumCopy, const N: usize> Seeded<N> for Dual2SVec<R, N> {
    #[inline(always)]
    fn seed(value: R, index: usize) -> Self {
        Self::from_re(value).derivative(index)
    }

    #[inline(always)]
    fn assemble(value: R, first: [R; N], second: [[R; N]; N]) -> Self {
        let symmetric = SMatrix::from_fn(|i, j| second[i.max(j)][i.min(j)]);
        Self::new(value, Derivative::some(SMatrix::from_fn(|_, j| first[j])), Derivative::some(symmetric))
    }

    #[inline(always)]
    fn gradient(self) -> [R; N] {
        row(self.v1.0)
    }

    #[inline(always)]
    fn hessian(self) -> [[R; N]; N] {
        let mut entries = [[R::ZERO; N]; N];
        if let Some(matrix) = self.v2.0 {
            for (i, line) in entries.iter_mut().enumerate() {
                for (j, entry) in line.iter_mut().enumerate() {
                    *entry = matrix[(i, j)];
                }
            }
        }
        entries
    }
}

macro_rules! seeded_along_one {
    ($dual:ident, $first:ident $(, $second:ident)?) => {
        impl<R: Real + DualNumCopy> Seeded<1> for $dual<R> {
            #[inline(always)]
            fn seed(value: R, index: usize) -> Self {
                let mut seeded = Self::from_re(value);
                seeded.$first = if index == 0 { R::integer(1) } else { R::ZERO };
                seeded
            }

            #[inline(always)]
            fn assemble(value: R, first: [R; 1], _second: [[R; 1]; 1]) -> Self {
                let mut assembled = Self::from_re(value);
                assembled.$first = first[0];
                $(assembled.$second = _second[0][0];)?
                assembled
            }

            #[inline(always)]
            fn gradient(self) -> [R; 1] {
                [self.$first]
            }

            fn hessian(self) -> [[R; 1]; 1] {
                let second = [R::ZERO $(, self.$second)?];
                [[second[second.len() - 1]]]
            }
        }
    };
}
seeded_along_one!(Dual, eps);
seeded_along_one!(Dual2, v1, v2);
seeded_along_one!(Dual3, v1, v2);

/// Of two directions: the mixed second derivative alone is there, and those twice along one are zero.
impl<R: Real + DualNumCopy> Seeded<2> for HyperDual<R> {
    #[inline(always)]
    fn seed(value: R, index: usize) -> Self {
        let along = |direction: usize| if index == direction { R::integer(1) } else { R::ZERO };
        Self::new(value, along(0), along(1), R::ZERO)
    }

    #[inline(always)]
    fn assemble(value: R, first: [R; 2], second: [[R; 2]; 2]) -> Self {
        Self::new(value, first[0], first[1], second[1][0])
    }

    #[inline(always)]
    fn gradient(self) -> [R; 2] {
        [self.eps1, self.eps2]
    }

    fn hessian(self) -> [[R; 2]; 2] {
        [[R::ZERO, self.eps1eps2], [self.eps1eps2, R::ZERO]]
    }
}

/// The entries of num-dual's optional gradient, which is a column in one type and a row in the other.
#[inline(always)]
fn row<R: Real, const N: usize, const I: usize, const J: usize>(parts: Option<SMatrix<R, I, J>>) -> [R; N] {
    let mut entries = [R::ZERO; N];
    if let Some(matrix) = parts {
        for (entry, part) in entries.iter_mut().zip(matrix.as_slice()) {
            *entry = *part;
        }
    }
    entries
}

/// A [`Real`] together with the dual numbers that the product differentiates with.
///
/// The catalogue is evaluated through these associated types only, so that another real number (vector lanes, a traced
/// symbol) may bring dual numbers of its own.
pub trait Duals: Real {
    /// First derivatives in N directions.
    type Gradient<const N: usize>: Scalar<Real = Self> + Seeded<N>;
    /// First and second derivatives in N directions.
    type Hessian<const N: usize>: Scalar<Real = Self> + Seeded<N>;
    /// First and second derivatives in time.
    type Time: Scalar<Real = Self>;

    /// Whether a connector takes its rows from formulas that are compiled for each set of measures, as the product does: many functions,
    /// of which the witnesses on other numbers keep apart.
    const HAS_COMPILED_FORMULAS: bool = false;

    /// value + velocity t + acceleration t²/2.
    fn moving(value: Self, velocity: Self, acceleration: Self) -> Self::Time;
    /// The first and second time derivative.
    fn rates(moving: Self::Time) -> (Self, Self);
}

macro_rules! differentiable {
    ($($real:ty: $compiled:literal;)*) => { $(
        impl Duals for $real {
            const HAS_COMPILED_FORMULAS: bool = $compiled;
            type Gradient<const N: usize> = FirstOrder<Self, N>;
            type Hessian<const N: usize> = SecondOrder<Self, N>;
            type Time = Dual2<Self>;

            #[inline(always)]
            fn moving(value: Self, velocity: Self, acceleration: Self) -> Self::Time {
                Dual2::new(value, velocity, acceleration)
            }

            #[inline(always)]
            fn rates(moving: Self::Time) -> (Self, Self) {
                (moving.v1, moving.v2)
            }
        }
    )* };
}

// Plain arrays take half of num-dual's time on doubles: those hold their derivatives as an option and multiply what is zero.
differentiable! {
    Wide: false;
    f64: true;
}

/// Dual numbers of plain arrays, in place of num-dual's: those ask of the number underneath an order and a conversion to `f64`,
/// which four lanes do not have.
impl<const FUSED: bool> Duals for Lanes<FUSED> {
    type Gradient<const N: usize> = FirstOrder<Self, N>;
    type Hessian<const N: usize> = SecondOrder<Self, N>;
    type Time = SecondOrder<Self, 1>;

    #[inline(always)]
    fn moving(value: Self, velocity: Self, acceleration: Self) -> Self::Time {
        SecondOrder { value, first: [velocity], second: [[acceleration]] }
    }

    #[inline(always)]
    fn rates(moving: Self::Time) -> (Self, Self) {
        (moving.first[0], moving.second[0][0])
    }
}

#[cfg(test)]
mod tests {
    use super::Seeded;
    use crate::so3;
    use num_dual::{Dual, Dual2, Dual2SVec, Dual3, HyperDual};

    /// φ1 of a rotation, which has no derivative that is zero.
    fn angle<S: Seeded<N, Real = f64>, const N: usize>() -> ([f64; N], [[f64; N]; N]) {
        let at = [0.4, -0.7];
        let [x, y] = [0, 1].map(|i| if i < N { S::seed(at[i], i) } else { S::from_real(at[i]) });
        let first = so3::log(&so3::exp([x * y, x, y * y]))[0];
        let second = so3::log(&so3::exp([x, x * y, y + x]))[2];
        let product = first * second;
        (product.gradient(), product.hessian())
    }

    #[test]
    fn one_direction_and_two_are_those_of_many() {
        let (gradient, hessian) = angle::<Dual2SVec<f64, 2>, 2>();
        let is_near = |x: f64, y: f64| (x - y).abs() < 1e-14;
        let ones = [angle::<Dual2<f64>, 1>(), angle::<Dual3<f64>, 1>()];
        assert!(ones.iter().all(|(g, h)| is_near(g[0], gradient[0]) && is_near(h[0][0], hessian[0][0])));
        let (g, h) = angle::<Dual<f64>, 1>();
        assert!(is_near(g[0], gradient[0]) && h == [[0.0]]);
        let (g, h) = angle::<HyperDual<f64>, 2>();
        assert!(is_near(g[0], gradient[0]) && is_near(g[1], gradient[1]));
        assert!(is_near(h[0][1], hessian[0][1]) && h[1][0] == h[0][1] && h[0][0] == 0.0);
        assert!(gradient.iter().chain(hessian.as_flattened()).all(|x| x.abs() > 0.05));
        let whole: HyperDual<f64> = Seeded::<2>::assemble(2.0, [3.0, 4.0], [[0.0, 5.0], [5.0, 0.0]]);
        assert_eq!(
            (whole.re, whole.gradient(), whole.hessian()),
            (2.0, [3.0, 4.0], [[0.0, 5.0], [5.0, 0.0]])
        );
        let whole: Dual3<f64> = Seeded::<1>::assemble(2.0, [3.0], [[4.0]]);
        assert_eq!((whole.re, whole.gradient(), whole.hessian()), (2.0, [3.0], [[4.0]]));
    }
}
