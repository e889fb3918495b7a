//! The friction coefficient μ.

use crate::behavior::Conditions;
use crate::behavior::friction::flags::Flags;
use crate::behavior::friction::{Context, Ordered};
use crate::behavior::table::{Table, Variable};
use pintle_kinematics::scalar::elementary::exp;
use pintle_kinematics::scalar::{Real, Scalar};

/// μ as `*FRICTION` gives it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub enum Coefficient {
    /// A number.
    Constant(f64),
    /// A table: column 0 is the slip rate, column 1 the contact force F_N; then temperature and field variables.
    Table(Table),
    /// μ_k + (μ_s − μ_k) exp(−d_c · slip rate).
    Exponential {
        /// μ_s.
        at_rest: f64,
        /// μ_k.
        kinetic: f64,
        /// d_c.
        decay: f64,
    },
}

/// Why test data give no decay.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CoefficientError {
    /// The ratio (μ_2 − μ_∞)/(μ_1 − μ_∞) is not between 0 and 1, or the rate is not positive.
    #[error(
        "no decay goes from {first} at rest through {second} at the slip rate {rate} to {limit}: the coefficients must fall \
         (or rise) in this order, at a positive rate"
    )]
    TestData {
        /// μ_1.
        first: f64,
        /// μ_2.
        second: f64,
        /// The slip rate of μ_2.
        rate: f64,
        /// μ_∞.
        limit: f64,
    },
    /// A coefficient is negative or not a number.
    #[error("the friction coefficient cannot be {0}")]
    Negative(f64),
}

impl Coefficient {
    /// The decay through test data: μ_1 at rest, μ_2 at a slip rate, μ_∞ at large ones. Without μ_∞ the second point is where
    /// 95 % of the fall are done, (μ_2 − μ_∞)/(μ_1 − μ_∞) = 0.05 (our reading; the data lines are documented).
    ///
    /// # Errors
    /// [`CoefficientError`]: points through which no exponential decay goes.
    ///
    /// ```
    /// use pintle_model::behavior::friction::Coefficient;
    /// let Coefficient::Exponential { kinetic, decay, .. } = Coefficient::test_data(0.3, (0.21, 2.0), Some(0.2))? else { return Ok(()) };
    /// assert_eq!(kinetic, 0.2);
    /// assert!((decay - 10.0_f64.ln() / 2.0).abs() < 1e-14); // 0.21 = 0.2 + 0.1 exp(−2 d_c)
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn test_data(
        first: f64,
        (second, rate): (f64, f64),
        limit: Option<f64>,
    ) -> Result<Self, CoefficientError> {
        const DONE: f64 = 0.05;
        let (kinetic, ratio) = match limit {
            Some(limit) => (limit, (second - limit) / (first - limit)),
            None => ((second - DONE * first) / (1.0 - DONE), DONE),
        };
        for value in [first, second, kinetic] {
            if value < 0.0 || !value.is_finite() {
                return Err(CoefficientError::Negative(value));
            }
        }
        let decay = -ratio.ln() / rate;
        // A ratio that is negative or zero has no finite logarithm, and through zero nothing can be divided.
        if !(ratio <= 1.0 && rate.is_sign_positive() && decay.is_finite()) {
            return Err(CoefficientError::TestData { first, second, rate, limit: kinetic });
        }
        Ok(Self::Exponential { at_rest: first, kinetic, decay })
    }

    /// μ at a slip rate and a contact force.
    pub fn at<S>(&self, rate: S, normal: S, conditions: &Conditions) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let context = Context { conditions, ..Context::default() };
        self.evaluate(rate, normal, &context, &mut Flags::default())
    }

    /// The slip rates (length or rad, by time) above zero at which μ is not smooth: rows of its table, in increasing order.
    pub fn rows(&self) -> Vec<f64> {
        let Self::Table(table) = self else { return Vec::new() };
        table.rows(Variable::Column(0)).into_iter().filter(|rate| *rate > 0.0).collect()
    }

    /// μ at a slip rate and a contact force.
    pub(super) fn evaluate<S>(&self, rate: S, normal: S, context: &Context<'_, S>, flags: &mut Flags) -> S
    where
        S: Scalar,
        S::Real: Ordered,
    {
        let number = |x: f64| S::from_real(S::Real::from_f64(x));
        match self {
            Self::Constant(value) => number(*value),
            Self::Table(table) => {
                let argument = |variable| match variable {
                    Variable::Column(0) => rate,
                    Variable::Column(_) => normal,
                    other => context.conditions.of(other),
                };
                flags.rows("friction coefficient", table, context.conditions, 0, |variable| {
                    argument(variable).real()
                });
                table.evaluate(0, argument)
            }
            Self::Exponential { at_rest, kinetic, decay } => {
                let fall = S::Real::from_f64(*at_rest) - S::Real::from_f64(*kinetic);
                number(*kinetic) + exp(rate.scale(-S::Real::from_f64(*decay))).scale(fall)
            }
        }
    }

    /// Whether μ changes with the slip rate.
    pub fn depends_on_rate(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Table(table) => table.depends_on().any(|variable| variable == Variable::Column(0)),
            Self::Exponential { at_rest, kinetic, decay } => at_rest != kinetic && *decay != 0.0,
        }
    }

    /// The slip rates at which the slope of μ changes, in increasing order.
    pub(super) fn rates(&self) -> Vec<f64> {
        match self {
            Self::Table(table) => table.rows(Variable::Column(0)),
            Self::Constant(_) | Self::Exponential { .. } => Vec::new(),
        }
    }
}
