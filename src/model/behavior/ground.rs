//! `*SPRING` and `*DASHPOT` from one degree of freedom to ground (SPRING1, DASHPOT1).
//!
//! A spring gives k q or a table over the displacement q, a dashpot c q̇ or a table over the velocity, both internal: positive resists
//! growth of q. Beyond its ends a table is constant. On the angle of a hinge (degree of freedom 6 of its node) they are its
//! stiffness and damping, in moments over radians.

use crate::behavior::table::{Table, Variable};
use crate::behavior::{Conditions, Unknown};
use pintle_kinematics::scalar::Scalar;
use pintle_scene::{Diagnostic, Discrete, Extrapolation, Span, TableRow};

/// What gives a force over one variable.
#[derive(Clone, Debug, PartialEq)]
struct Law {
    nonlinear: bool,
    table: Table,
}

impl Law {
    fn new(given: &Discrete, [coefficient, force]: [&str; 2]) -> Result<Self, Diagnostic> {
        let rows: Vec<TableRow> = given.rows.iter().map(|row| row_of(row, given.element_set.span)).collect();
        let name = if given.nonlinear { force } else { coefficient };
        let table = Table::new(&rows, 1, &[name], Extrapolation::Constant)?;
        Ok(Self { nonlinear: given.nonlinear, table })
    }

    fn unknown(&self, conditions: &Conditions) -> Option<Unknown> {
        self.table.depends_on().find_map(|variable| conditions.lacks(variable))
    }

    /// What a variable of the table is, for a displacement or velocity; frequencies are zero.
    fn argument<S: Scalar>(&self, variable: Variable, x: S, conditions: &Conditions) -> S {
        match variable {
            Variable::Column(_) if self.nonlinear => x,
            other => conditions.of(other),
        }
    }

    fn force<S: Scalar>(&self, x: S, conditions: &Conditions) -> S {
        let found = self.table.evaluate(0, |variable| self.argument(variable, x, conditions));
        if self.nonlinear { found } else { found * x }
    }

    fn energy<S: Scalar>(&self, x: S, conditions: &Conditions) -> S {
        let argument = |variable| self.argument(variable, x, conditions);
        if self.nonlinear {
            return self.table.integral(0, x, argument);
        }
        (x * x * self.table.evaluate(0, argument)).scale(pintle_kinematics::scalar::Real::ratio(1, 2))
    }
}

/// A data line: coefficient and frequency, or force and variable; then temperature and field variables.
fn row_of(values: &[Option<f64>], span: Span) -> TableRow {
    let (own, rest) = values.split_at(values.len().min(2));
    let (temperature, fields) = match rest {
        [temperature, fields @ ..] => (*temperature, fields.to_vec()),
        [] => (None, Vec::new()),
    };
    TableRow { values: own.to_vec(), temperature, fields, span }
}

/// The springs and dashpots of one degree of freedom, side by side.
///
/// ```
/// use pintle_model::behavior::Conditions;
/// use pintle_model::behavior::ground::Ground;
/// use pintle_kinematics::scalar::Scalar;
/// use pintle_scene::Scene;
///
/// let deck = "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=SPRING1, ELSET=S\n9, 1\n\
///             *SPRING, ELSET=S, NONLINEAR\n6\n-1., -1.\n0., 0.\n4., 2.\n";
/// let scene = Scene::parse("deck.inp", deck).unwrap();
/// let mut ground = Ground::default();
/// ground.add_spring(&scene.springs[0]).unwrap();
/// let moment = ground.spring(num_dual::Dual64::new(0.5, 1.0), &Conditions::default()).unwrap();
/// assert_eq!((moment.real(), moment.eps), (1.0, 2.0)); // the moment, and its stiffness
/// assert_eq!(ground.energy(0.5, &Conditions::default()), Ok(0.25));
/// assert_eq!(ground.spring(3.0, &Conditions::default()), Ok(4.0)); // constant beyond the table
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ground {
    springs: Vec<Law>,
    dashpots: Vec<Law>,
}

impl Ground {
    /// Adds the spring of a deck.
    ///
    /// # Errors
    /// A table out of order or incomplete ([`Table::new`]).
    pub fn add_spring(&mut self, given: &Discrete) -> Result<(), Diagnostic> {
        self.springs.push(Law::new(given, ["the frequency", "the displacement"])?);
        Ok(())
    }

    /// Adds the dashpot of a deck.
    ///
    /// # Errors
    /// As [`Ground::add_spring`].
    pub fn add_dashpot(&mut self, given: &Discrete) -> Result<(), Diagnostic> {
        self.dashpots.push(Law::new(given, ["the frequency", "the velocity"])?);
        Ok(())
    }

    /// Whether there is none.
    pub const fn is_empty(&self) -> bool {
        self.springs.is_empty() && self.dashpots.is_empty()
    }

    /// The displacements at which the slope of the spring force jumps, then the velocities of the dashpot force.
    pub fn rows(&self) -> [Vec<f64>; 2] {
        [&self.springs, &self.dashpots].map(|laws| {
            let nonlinear = laws.iter().filter(|law| law.nonlinear);
            let mut rows: Vec<f64> = nonlinear.flat_map(|law| law.table.rows(Variable::Column(0))).collect();
            rows.sort_by(f64::total_cmp);
            rows.dedup();
            rows
        })
    }

    /// Whether there are dashpots.
    pub const fn has_dashpots(&self) -> bool {
        !self.dashpots.is_empty()
    }

    fn sum<S: Scalar>(laws: &[Law], conditions: &Conditions, of: impl Fn(&Law) -> S) -> Result<S, Unknown> {
        match laws.iter().find_map(|law| law.unknown(conditions)) {
            Some(unknown) => Err(unknown),
            None => Ok(laws.iter().fold(S::zero(), |sum, law| sum + of(law))),
        }
    }

    /// The force of the springs at a displacement, or the moment at an angle; with the derivatives that it carries, the stiffness.
    ///
    /// # Errors
    /// It depends on a temperature or field variable that is not given.
    pub fn spring<S: Scalar>(&self, displacement: S, conditions: &Conditions) -> Result<S, Unknown> {
        Self::sum(&self.springs, conditions, |law| law.force(displacement, conditions))
    }

    /// The energy that the springs hold at a displacement: ∫ force, from zero.
    ///
    /// # Errors
    /// As [`Ground::spring`].
    pub fn energy<S: Scalar>(&self, displacement: S, conditions: &Conditions) -> Result<S, Unknown> {
        Self::sum(&self.springs, conditions, |law| law.energy(displacement, conditions))
    }

    /// The force of the dashpots at a velocity; with the derivatives that it carries, the damping.
    ///
    /// # Errors
    /// As [`Ground::spring`].
    pub fn dashpot<S: Scalar>(&self, velocity: S, conditions: &Conditions) -> Result<S, Unknown> {
        Self::sum(&self.dashpots, conditions, |law| law.force(velocity, conditions))
    }
}
