//! Unknowns in which P is curved finitely.
//!
//! A contribution |f_k/R|^α with 1 < α < 2 has a finite slope at f_k = 0 and an infinite curvature: the slip equations hold f_k there,
//! and near it f_k goes with a power of what is asked of it, on which Newton's method in f_k fails. With y = |f_k/F|^(α − 1) sign f_k,
//! F a size, the slope of P is proportional to y, and f_k = F |y|^(1/(α − 1)) sign y has no derivative by y where it is zero: the
//! equations are regular in y, and ∂f_k/∂y = 0 is the limit of the derivatives.

use super::derived::Potential;
use super::{Ordered, is_zero};

/// The unknowns of the slip equations in place of f_k/F.
pub(super) struct Stretch<R> {
    size: R,
    /// α − 1 where y is the unknown, and the factor of y in ∂P/∂f_k.
    bent: [Option<(R, R)>; 6],
}

impl<R: Ordered> Stretch<R> {
    /// `p` is P, `size` is F.
    pub(super) fn new(potential: &Potential, p: R, size: R) -> Self {
        let mut bent = [None; 6];
        if is_zero(p) {
            return Self { size, bent };
        }
        for (k, exponent, factor) in potential.bent(p, size) {
            bent[k] = Some((R::from_f64(exponent) - R::integer(1), factor));
        }
        Self { size, bent }
    }

    /// Whether any unknown is not f_k/F.
    pub(super) fn is_any(&self) -> bool {
        self.bent.iter().any(Option::is_some)
    }

    /// ∂(f_k/F)/∂y at f_k.
    pub(super) fn rise(&self, k: usize, force: R) -> R {
        match self.bent[k] {
            Some((power, _)) if !is_zero(force) => {
                (force / self.size).magnitude().power(R::integer(1) - power) / power
            }
            Some(_) => R::integer(0),
            None => R::integer(1),
        }
    }

    /// F ∂²P/∂f_k² ∂(f_k/F)/∂y from the second derivative at f_k.
    pub(super) fn curvature(&self, k: usize, force: R, second: R) -> R {
        match self.bent[k] {
            Some((_, factor)) if is_zero(force) => factor,
            _ => second * self.size * self.rise(k, force),
        }
    }

    /// f_k after y has decreased by a step.
    pub(super) fn stepped(&self, k: usize, force: R, step: R) -> R {
        let linear = force - step * self.rise(k, force) * self.size;
        let Some((power, _)) = self.bent[k] else { return linear };
        // Where the step is small, y and back would round more than a step in f_k does.
        if (linear - force).magnitude().less(force.magnitude() * R::ratio(1, 64)) {
            return linear;
        }
        let ratio = force / self.size;
        let y = if is_zero(ratio) { ratio } else { ratio.magnitude().power(power).with_sign_of(ratio) };
        let y = y - step;
        if is_zero(y) {
            return R::integer(0);
        }
        y.magnitude().power(R::integer(1) / power).with_sign_of(y) * self.size
    }
}
