//! Unknowns in which P is curved finitely.
//!
//! A contribution `|f_k/R|^α` with 1 < α < 2 has a finite slope at f_k = 0 and an infinite curvature. The slip equations hold f_k
//! there, and near it `t_k = f_k/K` goes with a power of what is asked of it, on which Newton's method in t_k fails. Let `y =
//! |t_k/F|^(α − 1) sign t_k`, F a size. The slope of P is proportional to y, and `t_k = F |y|^(1/(α − 1)) sign y` has no derivative
//! by y where it is zero. The equations are regular in y, and `∂t_k/∂y = 0` is the limit of the derivatives.

use crate::behavior::friction::derived::Potential;
use crate::behavior::friction::{Ordered, is_zero};

/// The unknowns of the slip equations in place of t_k/F.
pub(super) struct Stretch<R> {
    size: R,
    /// α − 1 where y is the unknown, and the factor of y in ∂P/∂f_k.
    bent: [Option<(R, R)>; 6],
}

impl<R: Ordered> Stretch<R> {
    /// `p` is P/K, `size` is F, `unit` is K.
    pub(super) fn new(potential: &Potential, p: R, size: R, unit: R) -> Self {
        let mut bent = [None; 6];
        if is_zero(p) {
            return Self { size, bent };
        }
        for (k, exponent, factor) in potential.bent(p, size, unit) {
            bent[k] = Some((R::from_f64(exponent) - R::integer(1), factor));
        }
        Self { size, bent }
    }

    /// Whether any unknown is not t_k/F.
    pub(super) fn is_any(&self) -> bool {
        self.bent.iter().any(Option::is_some)
    }

    /// ∂(t_k/F)/∂y at t_k.
    pub(super) fn rise(&self, k: usize, t: R) -> R {
        match self.bent[k] {
            Some((power, _)) if !is_zero(t) => {
                (t / self.size).magnitude().power(R::integer(1) - power) / power
            }
            Some(_) => R::ZERO,
            None => R::integer(1),
        }
    }

    /// F ∂²P/∂f_k² K ∂(t_k/F)/∂y from the second derivative K ∂²P/∂f_k² at t_k.
    pub(super) fn curvature(&self, k: usize, t: R, second: R) -> R {
        match self.bent[k] {
            Some((_, factor)) if is_zero(t) => factor,
            _ => second * self.size * self.rise(k, t),
        }
    }

    /// t_k after y has decreased by a step.
    pub(super) fn stepped(&self, k: usize, t: R, step: R) -> R {
        let linear = t - step * self.rise(k, t) * self.size;
        let Some((power, _)) = self.bent[k] else { return linear };
        // Where the step is small, y and back would round more than a step in t_k does.
        if (linear - t).magnitude().less(t.magnitude() * R::ratio(1, 64)) {
            return linear;
        }
        let ratio = t / self.size;
        let y = if is_zero(ratio) { ratio } else { ratio.magnitude().power(power).with_sign_of(ratio) };
        let y = y - step;
        if is_zero(y) {
            return R::ZERO;
        }
        y.magnitude().power(R::integer(1) / power).with_sign_of(y) * self.size
    }
}
