//! What somebody else's routine gives of a constraint at a state.

use crate::case::failing::MpcCase;
use crate::case::quantity::Quantity;
use crate::judge::table::ResultTable;
use pintle_kinematics::mpc::{Dofs, Evaluation, ROWS, Rows};

/// What a routine gives of a multi-point constraint at a state: numbers of each equation, `None` where there is no such equation, or
/// the routine gives none.
///
/// Columns are the sixteen degrees of freedom x, θ and Ψ of S, the same of M, φ1 and φ2; rotations vary spatially, δC = δθ^ C.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ConstraintNumbers {
    values: Rows<f64>,
    rows: Rows<Dofs<f64>>,
    second: Rows<Matrix>,
    rates: Rows<f64>,
    accelerations: Rows<f64>,
}

type Matrix = Box<[Dofs<f64>; pintle_kinematics::mpc::DOFS]>;

impl ConstraintNumbers {
    /// The residuals δ1 … δ3 or δl (length), ρ1 … ρ3 (rad), δΨ (length).
    #[must_use]
    pub fn values(self, values: Rows<f64>) -> Self {
        Self { values, ..self }
    }

    /// ∂g_k/∂q_j.
    #[must_use]
    pub fn rows(self, rows: Rows<Dofs<f64>>) -> Self {
        Self { rows, ..self }
    }

    /// ∂²g_k/∂q_i∂q_j, symmetric: along exp(δθ^) C.
    #[must_use]
    pub fn second_derivatives(self, second: Rows<Matrix>) -> Self {
        Self { second, ..self }
    }

    /// ġ_k at the velocities of the state.
    #[must_use]
    pub fn rates(self, rates: Rows<f64>) -> Self {
        Self { rates, ..self }
    }

    /// g̈_k at the velocities and accelerations of the state.
    #[must_use]
    pub fn accelerations(self, accelerations: Rows<f64>) -> Self {
        Self { accelerations, ..self }
    }

    /// Of which equations there are numbers of a quantity.
    pub(crate) fn has(&self, quantity: Quantity) -> [bool; ROWS] {
        match quantity {
            Quantity::Value => self.values.map(|x| x.is_some()),
            Quantity::FirstDerivatives => self.rows.map(|x| x.is_some()),
            Quantity::SecondDerivatives => self.second.each_ref().map(Option::is_some),
            Quantity::Rate => self.rates.map(|x| x.is_some()),
            Quantity::Acceleration => self.accelerations.map(|x| x.is_some()),
            _ => [false; ROWS],
        }
    }

    /// The same as an evaluation: what is not given is what is there.
    fn into(self, mut there: Evaluation<f64>) -> Evaluation<f64> {
        there.jacobian = self.rows;
        there.hessian = self.second;
        there.residual_rate = self.rates;
        there.residual_acceleration = self.accelerations;
        for (there, given) in there.residual.iter_mut().zip(self.values) {
            *there = given.or(*there);
        }
        there
    }
}

impl From<Evaluation<f64>> for ConstraintNumbers {
    fn from(found: Evaluation<f64>) -> Self {
        Self {
            values: found.residual,
            rows: found.jacobian,
            second: found.hessian,
            rates: found.residual_rate,
            accelerations: found.residual_acceleration,
        }
    }
}

impl MpcCase {
    /// What the product gives at this state.
    pub fn product(&self) -> ConstraintNumbers {
        self.said().into()
    }

    /// What a routine gives of these equations beside what it must give, as tables; with mistakes that may explain it where
    /// `explains`.
    pub(crate) fn tables_given(
        &self,
        given: ConstraintNumbers,
        equations: &[usize],
        explains: bool,
    ) -> Vec<ResultTable> {
        let got = given.into(self.said());
        let mut tables = self.tables_of(&got, &self.truth(&got), equations);
        if explains {
            self.add_mistakes(&mut tables, equations);
        }
        tables
    }
}
