//! Dual numbers in N directions as plain arrays.

use crate::scalar::{Real, Scalar, Seeded};
use std::ops::{Add, Mul, Neg, Sub};

/// A value with its first derivatives in N directions.
#[derive(Clone, Copy, Debug)]
pub struct FirstOrder<R, const N: usize> {
    /// The value.
    pub value: R,
    /// The first derivatives.
    pub first: [R; N],
}

/// A value with its first and second derivatives in N directions.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrder<R, const N: usize> {
    /// The value.
    pub value: R,
    /// The first derivatives.
    pub first: [R; N],
    /// The second derivatives, on and below the diagonal; what is above is not used.
    pub second: [[R; N]; N],
}

/// What is inlined where that pays, for lanes and first derivatives of doubles, and called elsewhere.
macro_rules! inlined_if {
    ($inlined:expr, ($($x:ident: $type:ty = $argument:expr),+) -> $result:ty $body:block) => {{
        #[cfg_attr(not(debug_assertions), inline(always))]
        fn inlined<R: Real, const N: usize>($($x: $type),+) -> $result $body
        #[inline(never)]
        fn called<R: Real, const N: usize>($($x: $type),+) -> $result $body
        if const { $inlined } { inlined::<R, N>($($argument),+) } else { called::<R, N>($($argument),+) }
    }};
}

/// A loop that ends where it is tested, as the compiler would turn it: of ranges it is a third of the time that the kernels take to compile.
macro_rules! counted {
    ($i:ident <= $last:expr, $body:block) => {{
        let mut $i = 0;
        loop {
            $body
            if $i >= $last {
                break;
            }
            $i += 1;
        }
    }};
}

/// A body for each pair j ≤ i < N: written out for up to three directions; of six, the code would be too long.
macro_rules! each_pair {
    ($i:ident, $j:ident, $body:block) => {
        if N <= 3 {
            unrolled!($i < N, { unrolled!($j < $i + 1; N, $body) });
        } else {
            counted!($i <= N - 1, { counted!($j <= $i, $body) });
        }
    };
}

macro_rules! first_order {
    (|$($x:ident),+| $f:expr) => {{
        let value = {
            $(let $x = $x.value;)+
            $f
        };
        let mut first = const { [R::ZERO; N] };
        counted!(i <= N - 1, {
            $(let $x = $x.first[i];)+
            first[i] = $f;
        });
        FirstOrder { value, first }
    }};
}

macro_rules! second_order {
    (|$($x:ident),+| $f:expr) => {{
        let value = {
            $(let $x = $x.value;)+
            $f
        };
        let mut first = const { [R::ZERO; N] };
        let mut second = const { [[R::ZERO; N]; N] };
        counted!(i <= N - 1, {
            $(let $x = $x.first[i];)+
            first[i] = $f;
        });
        each_pair!(i, j, {
            $(let $x = $x.second[i][j];)+
            second[i][j] = $f;
        });
        SecondOrder { value, first, second }
    }};
}

macro_rules! linear {
    ($dual:ident, $each:ident) => {
        impl<R: Real, const N: usize> Add for $dual<R, N> {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn add(self, other: Self) -> Self {
                inlined_if!(<$dual<R, N> as Scalar>::IS_INLINED, (x: $dual<R, N> = self, y: $dual<R, N> = other) -> $dual<R, N> {
                    $each!(|x, y| x + y)
                })
            }
        }

        impl<R: Real, const N: usize> Sub for $dual<R, N> {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn sub(self, other: Self) -> Self {
                inlined_if!(<$dual<R, N> as Scalar>::IS_INLINED, (x: $dual<R, N> = self, y: $dual<R, N> = other) -> $dual<R, N> {
                    $each!(|x, y| x - y)
                })
            }
        }

        impl<R: Real, const N: usize> Neg for $dual<R, N> {
            type Output = Self;

            #[cfg_attr(not(debug_assertions), inline(always))]
            fn neg(self) -> Self {
                let x = self;
                $each!(|x| -x)
            }
        }
    };
}

linear!(FirstOrder, first_order);
linear!(SecondOrder, second_order);

impl<R: Real, const N: usize> Mul for FirstOrder<R, N> {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, other: Self) -> Self {
        inlined_if!(R::IS_INLINED, (a: FirstOrder<R, N> = self, b: FirstOrder<R, N> = other) -> FirstOrder<R, N> {
            let (x, y) = (a.value, b.value);
            let mut first = a.first;
            counted!(i <= N - 1, {
                first[i] = x.multiply_add(b.first[i], a.first[i] * y);
            });
            FirstOrder { value: x * y, first }
        })
    }
}

impl<R: Real, const N: usize> Mul for SecondOrder<R, N> {
    type Output = Self;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn mul(self, other: Self) -> Self {
        inlined_if!(R::HAS_LANES, (a: SecondOrder<R, N> = self, b: SecondOrder<R, N> = other) -> SecondOrder<R, N> {
            let (x, y) = (a.value, b.value);
            let (dx, dy) = (a.first, b.first);
            let (mut first, mut second) = (dx, a.second);
            counted!(i <= N - 1, {
                first[i] = x.multiply_add(dy[i], dx[i] * y);
            });
            each_pair!(i, j, {
                let of_first = dx[i].multiply_add(dy[j], dx[j] * dy[i]);
                second[i][j] = x.multiply_add(b.second[i][j], a.second[i][j].multiply_add(y, of_first));
            });
            SecondOrder { value: x * y, first, second }
        })
    }
}

impl<R: Real, const N: usize> Scalar for FirstOrder<R, N> {
    type Real = R;
    const ORDER: usize = 1;
    const IS_INLINED: bool = R::IS_INLINED;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_real(value: R) -> Self {
        Self { value, first: const { [R::ZERO; N] } }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn real(self) -> R {
        self.value
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nilpotent(self) -> Self {
        Self { value: R::ZERO, first: self.first }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_real(self, value: R) -> Self {
        Self { value, ..self }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nilpotent_product(self, _: Self) -> Self {
        Self::zero()
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn scale(self, factor: R) -> Self {
        let x = self;
        first_order!(|x| x * factor)
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        first_order!(|yes, no| R::select(mask, yes, no))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn multiply_add(self, y: Self, z: Self) -> Self {
        let mut first = z.first;
        counted!(i <= N - 1, {
            first[i] = self.value.multiply_add(y.first[i], self.first[i].multiply_add(y.value, z.first[i]));
        });
        Self { value: self.value.multiply_add(y.value, z.value), first }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn scale_add(self, factor: R, z: Self) -> Self {
        let x = self;
        first_order!(|x, z| x.multiply_add(factor, z))
    }

    /// f(x₀) + f′(x₀) e.
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lift(self, c: &crate::scalar::Series<R>) -> Self {
        let mut first = self.first;
        counted!(i <= N - 1, {
            first[i] = self.first[i] * c[1];
        });
        Self { value: c[0], first }
    }
}

impl<R: Real, const N: usize> Scalar for SecondOrder<R, N> {
    type Real = R;
    const ORDER: usize = 2;
    const IS_INLINED: bool = R::HAS_LANES;

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn from_real(value: R) -> Self {
        Self { value, first: const { [R::ZERO; N] }, second: const { [[R::ZERO; N]; N] } }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn real(self) -> R {
        self.value
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nilpotent(self) -> Self {
        Self { value: R::ZERO, ..self }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn with_real(self, value: R) -> Self {
        Self { value, ..self }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn nilpotent_product(self, other: Self) -> Self {
        inlined_if!(R::HAS_LANES, (a: SecondOrder<R, N> = self, b: SecondOrder<R, N> = other) -> SecondOrder<R, N> {
            let (dx, dy) = (a.first, b.first);
            let mut product = SecondOrder::zero();
            each_pair!(i, j, {
                product.second[i][j] = dx[i].multiply_add(dy[j], dx[j] * dy[i]);
            });
            product
        })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn scale(self, factor: R) -> Self {
        inlined_if!(R::HAS_LANES, (x: SecondOrder<R, N> = self, factor: R = factor) -> SecondOrder<R, N> {
            second_order!(|x| x * factor)
        })
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn select(mask: R::Mask, yes: Self, no: Self) -> Self {
        second_order!(|yes, no| R::select(mask, yes, no))
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn multiply_add(self, y: Self, z: Self) -> Self {
        self * y + z
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn scale_add(self, factor: R, z: Self) -> Self {
        inlined_if!(R::HAS_LANES, (x: SecondOrder<R, N> = self, factor: R = factor, z: SecondOrder<R, N> = z) -> SecondOrder<R, N> {
            second_order!(|x, z| x.multiply_add(factor, z))
        })
    }

    /// f(x₀) + f′(x₀) e + ½ f″(x₀) e².
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn lift(self, c: &crate::scalar::Series<R>) -> Self {
        let twice = c[2] + c[2];
        let mut lifted = self;
        lifted.value = c[0];
        counted!(i <= N - 1, {
            lifted.first[i] = self.first[i] * c[1];
        });
        each_pair!(i, j, {
            let curved = (twice * self.first[i]) * self.first[j];
            lifted.second[i][j] = c[1].multiply_add(self.second[i][j], curved);
        });
        lifted
    }
}

/// ε_index as first derivatives.
#[cfg_attr(not(debug_assertions), inline(always))]
fn unit<R: Real, const N: usize>(index: usize) -> [R; N] {
    let mut first = const { [R::ZERO; N] };
    if let Some(entry) = first.get_mut(index) {
        *entry = R::integer(1);
    }
    first
}

impl<R: Real, const N: usize> Seeded<N> for FirstOrder<R, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn seed(value: R, index: usize) -> Self {
        Self { value, first: unit(index) }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn assemble(value: R, first: [R; N], _: [[R; N]; N]) -> Self {
        Self { value, first }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gradient(self) -> [R; N] {
        self.first
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn hessian(self) -> [[R; N]; N] {
        const { [[R::ZERO; N]; N] }
    }
}

impl<R: Real, const N: usize> Seeded<N> for SecondOrder<R, N> {
    #[cfg_attr(not(debug_assertions), inline(always))]
    fn seed(value: R, index: usize) -> Self {
        Self { first: unit(index), ..Self::from_real(value) }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn assemble(value: R, first: [R; N], second: [[R; N]; N]) -> Self {
        Self { value, first, second }
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn gradient(self) -> [R; N] {
        self.first
    }

    #[cfg_attr(not(debug_assertions), inline(always))]
    fn hessian(self) -> [[R; N]; N] {
        let mut hessian = self.second;
        each_pair!(i, j, {
            hessian[j][i] = hessian[i][j];
        });
        hessian
    }
}
