//! What holds for every connection type, whatever it is: properties over the whole table and every free pair.
//!
//! Errors are in units u = 2⁻⁵³ of a *conditioned scale*: what one rounding of each input already forces. s_j is the size of degree of
//! freedom j: 1 rad, or the connector's length.
//!
//! | of | conditioned scale |
//! |---|---|
//! | a value | F = |f| + Σ_j |∂f/∂q_j| s_j |
//! | a first derivative | F/s_j + Σ_k |∂²f/∂q_j∂q_k| s_k |
//! | a second derivative | (F + Σ_jk |∂²f/∂q_j∂q_k| s_j s_k)/(s_j s_k) |

mod derivatives; // derivatives are those of the functions, on 237-bit numbers
mod forces; // nodal forces are transposed rows times component forces
mod forms; // the same motion in every form of input
mod hinges; // what acts on the angles of hinges
mod histories; // turns are counted and saved branches continue
mod motion; // rigid motions, frames, units, rates, the initial state, exchanged nodes
pub(crate) mod mpc; // the laws of multi-point constraints
mod mpc_forces; // what they transmit, and what they leave to be solved for
mod requests; // a part is part of the whole, and nothing else is computed

use crate::tolerance::{LAWS, Law};
use pintle_kinematics::connector::{Components, Evaluation, NodalRow};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::{Real, Wide};
use std::fmt::Display;

/// u, the unit of rounding of `f64`.
pub(crate) const U: f64 = 1.0 / 9_007_199_254_740_992.0;

/// The comparisons of one law: the worst error, and everything beyond the tolerance.
pub(crate) struct Check {
    law: &'static Law,
    worst: (f64, String),
    failures: Vec<String>,
    count: usize,
}

impl Check {
    pub(crate) fn of(name: &str) -> Self {
        let law = LAWS.iter().find(|law| law.name == name).expect("the law is in the table of tolerances");
        Self { law, worst: (0.0, String::new()), failures: Vec::new(), count: 0 }
    }

    /// |got − want| ≤ tolerance · u · scale, `want` in 237 bits.
    pub(crate) fn compare(&mut self, place: impl Fn() -> String, got: f64, want: Wide, scale: f64) {
        self.count += 1;
        let error = (Wide::from_f64(got) - want).abs().to_f64();
        let units = if error == 0.0 { 0.0 } else { error / (U * scale) };
        let units = if units.is_nan() { f64::INFINITY } else { units };
        if units > self.worst.0 {
            self.worst = (units, place());
        }
        if units > self.law.units || !got.is_finite() {
            let want = want.to_f64();
            self.failures.push(format!("{}: {got:e}, not {want:e}: {units:.3e} u of {scale:e}", place()));
        }
    }

    /// As [`Check::compare`], against another double.
    pub(crate) fn against(&mut self, place: impl Fn() -> String, got: f64, want: f64, scale: f64) {
        self.compare(place, got, Wide::from_f64(want), scale);
    }

    /// Fails with all that was beyond the tolerance, or where nothing was compared.
    pub(crate) fn finish(self) {
        let Self { law, worst, failures, count } = self;
        println!(
            "{}: {count} compared, worst {:.3} u (allowed {}) at {}",
            law.name, worst.0, law.units, worst.1
        );
        assert!(count > 0, "{}: nothing was compared", law.name);
        let shown = failures.iter().take(30).cloned().collect::<Vec<_>>().join("\n");
        assert!(failures.is_empty(), "{}: {} of {count} fail\n{shown}", law.name, failures.len());
    }
}

/// Equality of every bit.
pub(crate) fn assert_bits(place: impl Display, got: f64, want: f64) {
    assert!(got.to_bits() == want.to_bits(), "{place}: {got:e} is not {want:e} bit for bit");
}

/// What is differentiated: the residual of a constrained component, the displacement of any other.
pub(crate) fn functions<R: Copy>(evaluation: &Evaluation<R>) -> Components<R> {
    [0, 1, 2, 3, 4, 5].map(|k| evaluation.residual[k].or(evaluation.displacement[k]))
}

/// The conditioned scales of one row.
pub(crate) struct Scales {
    /// F.
    pub(crate) value: f64,
    /// F/s_j + Σ_k |H_jk| s_k.
    pub(crate) first: NodalRow<f64>,
    /// F₂.
    second: f64,
    sizes: NodalRow<f64>,
}

impl Scales {
    pub(crate) fn new(value: f64, row: &NodalRow<f64>, hessian: &[NodalRow<f64>; DOFS], length: f64) -> Self {
        let sizes: NodalRow<f64> = std::array::from_fn(|j| crate::states::dof_size(j, length));
        let mut f = value.abs();
        let mut bent = [0.0; DOFS];
        for j in 0..DOFS {
            f += row[j].abs() * sizes[j];
            for k in 0..DOFS {
                bent[j] += hessian[j][k].abs() * sizes[k];
            }
        }
        let second = f + (0..DOFS).map(|j| bent[j] * sizes[j]).sum::<f64>();
        let first = std::array::from_fn(|j| f / sizes[j] + bent[j]);
        Self { value: f, first, second, sizes }
    }

    /// F₂/(s_j s_k).
    pub(crate) fn second(&self, j: usize, k: usize) -> f64 {
        self.second / (self.sizes[j] * self.sizes[k])
    }
}

/// Σ_k row_k x_k.
pub(crate) fn times<R: Real>(row: &NodalRow<R>, x: &NodalRow<R>) -> R {
    row.iter().zip(x).fold(R::ZERO, |sum, (r, x)| sum + *r * *x)
}
