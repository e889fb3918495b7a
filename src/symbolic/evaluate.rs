//! The value of expressions on any number without derivatives: doubles, 237 bits.

use crate::graph::{Graph, Id, Node, Number};
use pintle_kinematics::scalar::{MAX_ORDER, Real};

impl Graph {
    /// The values of `roots` at `inputs`, on numbers whose comparisons are plain; an input that is not given is zero.
    ///
    /// Elementary functions are those of `R`: on [`pintle_kinematics::scalar::Wide`] they share nothing with those on doubles. Doubles and ratios
    /// enter exactly.
    pub fn evaluate<R: Real<Mask = bool>>(&self, roots: &[Id], inputs: &[R]) -> Vec<R> {
        self.evaluate_along(&self.reachable(roots), roots, inputs)
    }

    /// The same, with the nodes that `roots` need ([`Graph::reachable`]) known.
    pub fn evaluate_along<R: Real<Mask = bool>>(&self, needed: &[Id], roots: &[Id], inputs: &[R]) -> Vec<R> {
        let zero = R::ZERO;
        let mut values = vec![zero; self.len()];
        for id in needed {
            let of = |x: Id| values.get(x.place()).copied().unwrap_or(zero);
            let value = self.value(*id, inputs, &of);
            if let Some(place) = values.get_mut(id.place()) {
                *place = value;
            }
        }
        roots.iter().map(|root| values.get(root.place()).copied().unwrap_or(zero)).collect()
    }

    fn value<R: Real<Mask = bool>>(&self, id: Id, inputs: &[R], of: &impl Fn(Id) -> R) -> R {
        match self.node(id) {
            Node::Constant(number) => constant(*number),
            Node::Pi => R::pi(),
            Node::Input(number) => inputs.get(*number as usize).copied().unwrap_or(R::ZERO),
            Node::Add(x, y) => of(*x) + of(*y),
            Node::Multiply(x, y) => of(*x) * of(*y),
            Node::Divide(x, y) => of(*x) / of(*y),
            Node::Negate(x) => -of(*x),
            Node::Unsigned(x) => R::ZERO + of(*x),
            Node::Reciprocal(x) => of(*x).reciprocal_or_zero(),
            Node::SquareRoot(x) => of(*x).square_root(),
            Node::Magnitude(x) => of(*x).magnitude(),
            Node::Sign(x) => {
                let (x, zero, one) = (of(*x), R::ZERO, R::integer(1));
                if zero.less(x) {
                    one
                } else if x.less(zero) {
                    -one
                } else {
                    zero
                }
            }
            Node::Sine(x) => of(*x).sine_cosine().0,
            Node::Cosine(x) => of(*x).sine_cosine().1,
            Node::Exponential(x) => of(*x).exponential(),
            Node::ExponentialMinusOne(x) => of(*x).exponential_minus_one(),
            Node::Power(x, p) => of(*x).power(of(*p)),
            Node::Arctangent(y, x) => of(*y).arctangent(of(*x)),
            Node::NearestInteger(x) => of(*x).nearest_integer(),
            Node::Norm(v) => norm(v, of),
            Node::Quaternion(r, part) => {
                let row = |i: usize| [of(r[i]), of(r[i + 1]), of(r[i + 2])];
                let q = R::quaternion_of(&[row(0), row(3), row(6)]);
                let value = q[usize::from(*part) % 4];
                if q[0].less(R::ZERO) { -value } else { value }
            }
            Node::CosineOfRoot(n, s) => exp_coefficient(*n as usize, of(*s)).0,
            Node::SineOfRoot(n, s) => exp_coefficient(*n as usize, of(*s)).1,
            Node::Logarithm(n, c) => log_coefficient(*n as usize, of(*c)),
            Node::Select { less, than, yes, no } => of(if of(*less).less(of(*than)) { *yes } else { *no }),
        }
    }
}

fn constant<R: Real>(number: Number) -> R {
    const LIMB: i64 = 1 << 30;
    let integer = |n: i64| {
        let limb = R::integer(LIMB as i32);
        (R::integer((n / LIMB / LIMB) as i32) * limb + R::integer((n / LIMB % LIMB) as i32)) * limb
            + R::integer((n % LIMB) as i32)
    };
    match number {
        Number::Ratio(p, 1) => integer(p),
        Number::Ratio(p, q) => integer(p) / integer(q),
        Number::Double(bits) => R::from_f64(f64::from_bits(bits)),
    }
}

/// |v|, by the norms of arrays: of any length with zeros behind.
fn norm<R: Real>(v: &[Id], of: &impl Fn(Id) -> R) -> R {
    fn of_array<R: Real, const N: usize>(v: &[Id], of: &impl Fn(Id) -> R) -> R {
        let mut all = [R::ZERO; N];
        for (place, id) in all.iter_mut().zip(v) {
            *place = of(*id);
        }
        R::direction_and_norm(all).1
    }
    match v.len() {
        0..=2 => of_array::<R, 2>(v, of),
        3 => of_array::<R, 3>(v, of),
        _ => of_array::<R, 24>(v, of),
    }
}

/// The n-th Taylor coefficients of cos(√s / 2) and sin(√s / 2)/√s.
fn exp_coefficient<R: Real<Mask = bool>>(n: usize, s: R) -> (R, R) {
    let order = n.min(MAX_ORDER);
    let (w, k) = R::exp_series(s, order);
    let (mut w, mut k) = (w[order], k[order]);
    // w′ = −k/4 and s k′ = w/4 − k/2, and their derivatives: for high orders away from s = 0, else the power series.
    if n > MAX_ORDER && s.less(R::integer(64)) {
        return (root_series(n, 1, s), root_series(n, 3, s) * R::ratio(1, 2));
    }
    for m in order..n {
        let m = m as i32;
        let next_w = k / R::integer(-4 * (m + 1));
        k = (w * R::ratio(1, 4) - k * R::ratio(2 * m + 1, 2)) / (R::integer(m + 1) * s);
        w = next_w;
    }
    (w, k)
}

/// The n-th Taylor coefficient at s of Σ (−s/16)ᵐ / (m! (b/2)_m), b = 1 or 3: cos(√s/2), or 2 sin(√s/2)/√s.
fn root_series<R: Real>(n: usize, b: i32, s: R) -> R {
    const TERMS: i32 = 200;
    let n = n as i32;
    let mut term = R::integer(1);
    for m in 0..n {
        // The coefficient of sⁿ: (−1/16)ⁿ / (n! (b/2)_n).
        term = term / R::integer(-8 * (m + 1) * (b + 2 * m));
    }
    let mut sum = R::ZERO;
    for m in 0..TERMS {
        sum = sum + term;
        term = term * s / R::integer(-8 * (m + 1) * (b + 2 * (m + n)));
    }
    sum
}

/// The n-th Taylor coefficient of K(c) = 2 acos(c)/√(1 − c²).
fn log_coefficient<R: Real<Mask = bool>>(n: usize, c: R) -> R {
    if n <= MAX_ORDER {
        return R::log_series(c, n)[n];
    }
    if R::ZERO.less(c) {
        // 2 (−½)ⁿ n!/(3/2)_n ₂F₁(n + 1, n + 1; n + 3/2; (1 − c)/2), whose terms have one sign.
        let y = (R::integer(1) - c) * R::ratio(1, 2);
        let n = n as i32;
        let mut term = R::integer(2);
        for m in 0..n {
            term = term * R::integer(-(m + 1)) / R::integer(3 + 2 * m);
        }
        let mut sum = R::ZERO;
        for m in 0..300 + 4 * n {
            sum = sum + term;
            term = term * y * R::integer(2 * (n + 1 + m)) * R::integer(n + 1 + m)
                / (R::integer(2 * n + 3 + 2 * m) * R::integer(m + 1));
        }
        return sum;
    }
    // (1 − c²) K′ = c K − 2 and its derivatives.
    let series = R::log_series(c, 1);
    let rest = (R::integer(1) - c) * (R::integer(1) + c);
    let (mut before, mut last) = (series[0], series[1]);
    for m in 1..n as i32 {
        let next = (R::integer(2 * m + 1) * c * last + R::integer(m) * before) / (R::integer(m + 1) * rest);
        (before, last) = (last, next);
    }
    last
}
