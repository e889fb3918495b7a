//! Friction: P, F_C, F_N and Φ with their derivatives by the forces, and what an increment does, with its consistent tangent.
//! Predefined friction of a type is judged at drawn forces, any of a scene's connector at its states, after its history.
//!
//! | module | question |
//! |---|---|
//! | `criterion` | are P, F_C, F_N, Φ, their gradients and Hessians right? |
//! | `increment` | do the forces satisfy the equations of stick and slip, and are their slopes right? |
//! | `solve` | how are equations solved on 237 bits, and what if they are not? |
//! | `belt` | the same for a belt around a ring |
//! | `total` | are the slopes of all forces of a connector right, with what presses its frictions? |
//! | `given` | what does somebody else's friction give, and what may explain it? |
//! | `golden` | what does JAX say, at states of its own? |
//! | `restored` | does it go on from what was saved? |
//! | `scene` | what of a connector's friction is judged at a state? |
//!
//! Central differences of values on 237 bits with h = s·1e-25 give first, with h = s·1e-18 second derivatives: no dual number enters
//! them. s is the largest force, or the largest moment. Beside them stand the dual numbers on 237 bits, and differences on doubles.

mod belt;
mod criterion;
mod given;
mod golden;
mod increment;
mod restored;
mod scene;
mod solve;
mod total;

use crate::case::failing::FrictionCase;
pub use given::{FrictionNumbers, FrictionSubject, Told};
pub(super) use golden::audit_golden;
pub(super) use restored::restored;
pub(super) use scene::{Slipping, audit_slipping, drawn, slipping};

use crate::case::failing::Failing;
use crate::case::quantity::Quantity;
use crate::judge::outcome::Check;
use crate::judge::table::ResultTable;
use crate::judge::verdict::Verdict;
use crate::mutants::mutant::Mistake;
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use pintle_kinematics::catalog::{ConnectionType, Contact};
use pintle_kinematics::draw::Draw;
use pintle_kinematics::scalar::Real;
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::{
    Coefficient, Context, Criterion, FactorMistake, Friction, State, StickStiffness,
};

/// Cases of every predefined criterion of a type, spatial, with parameters and forces drawn; none for a type without, and for a
/// belt around a ring, whose law is another.
pub fn friction_cases(connection: &ConnectionType, settings: &Settings, count: usize) -> Vec<FrictionCase> {
    let mut found = Vec::new();
    let Some(friction) =
        connection.friction.filter(|f| f.criteria.iter().all(|c| c.contact != Contact::Belt))
    else {
        return found;
    };
    let draw = &mut Draw::new(&format!("{} {} friction", settings.seed, connection.name));
    for i in 0..count {
        let numbers: Vec<Option<f64>> =
            friction.parameters.iter().map(|_| Some(draw.between(0.2, 2.0))).collect();
        let Ok(criteria) = Criterion::predefined(&friction, &numbers, &[], false) else { continue };
        // Away from zero, where norms have no derivative.
        let mut six = |size: f64| {
            [0; 6].map(|_| {
                let x = draw.between(-size, size);
                if x < 0.0 { x - 0.1 * size } else { x + 0.1 * size }
            })
        };
        let (forces, position) = (six(3.0), six(0.8));
        // Some increments stick, some slip.
        let displacement = six([0.002, 0.05, 0.2][i % 3]);
        for (n, criterion) in criteria.into_iter().enumerate() {
            let coefficient = draw.between(0.05, 0.6);
            let duration = draw.between(0.01, 0.2);
            let friction = Friction {
                criterion,
                coefficient: Coefficient::Constant(coefficient),
                maximum: None,
                stick_stiffness: StickStiffness::Given(draw.between(20.0, 60.0)),
                radius: 1.0,
            };
            found.push(FrictionCase {
                name: format!("{} friction {} state {i}", connection.name, n + 1),
                title: String::new(),
                friction,
                coefficient,
                point: forces,
                before: State::default(),
                displacement,
                forces,
                position,
                motion: position,
                accumulated_slip: 0.0,
                duration: Some(duration),
                conditions: Conditions::default(),
                length: 1.0,
            });
        }
    }
    found
}

/// What is judged of a friction: numbers in a table, by an oracle.
type Judged = (Oracle, ResultTable);

/// The checks that tables make at a state. What an oracle calls wrong that shares functions or derivatives with the product, and an
/// independent one passes, is undecided.
fn checks(tables: Vec<Judged>, settings: &Settings, name: &str, proves: bool) -> Vec<Check> {
    let says = |table: &ResultTable| !table.entries.is_empty() || table.undecided.is_some();
    let mut filled: Vec<Judged> = tables.into_iter().filter(|(_, table)| says(table)).collect();
    for (_, table) in &mut filled {
        settings.planted.into_iter().for_each(|planted| planted.spoil_table(table));
    }
    let passes = |of: &ResultTable| {
        let mut others = filled.iter().filter(|(oracle, other)| {
            oracle.is_independent() && (other.quantity, &other.rows) == (of.quantity, &of.rows)
        });
        others.any(|(_, other)| {
            let verdict = other.judge().verdict;
            !verdict.is_mismatch() && verdict != Verdict::Undecided
        })
    };
    let judged = filled.iter().map(|(oracle, table)| {
        let mut check = table.check_against(*oracle, proves, name, None);
        if check.verdict == Verdict::Wrong && !oracle.is_independent() && passes(table) {
            check = check.overruled(name);
        }
        check
    });
    judged.collect()
}

/// Differences on 237 bits alone.
fn by_differences() -> Settings {
    Settings { oracles: [Oracle::WideDifferences].into(), ..Settings::default() }
}

/// The unit of a result of an increment: forces, moments, and the others each by itself.
const fn kind(i: usize) -> usize {
    if i < 6 { i / 3 } else { i }
}

impl FrictionCase {
    /// The criterion and the state, in words.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The numbers at this state, and what they must be by differences on 237 bits: the criterion, its first and second derivatives, the
    /// tangent.
    pub fn tables(&self) -> Vec<ResultTable> {
        let tables = self.all_tables().into_iter();
        tables.filter(|table| table.quantity != Quantity::FrictionForce).collect()
    }

    /// The same with the forces that satisfy the equations of stick and slip.
    pub(super) fn all_tables(&self) -> Vec<ResultTable> {
        let settings = by_differences();
        let mut tables = self.criterion_tables(&settings, true);
        tables.extend(self.increment_tables(&settings, true));
        tables.into_iter().map(|(_, table)| table).collect()
    }

    /// All checks at this state, with mutants.
    pub fn audit(&self, settings: &Settings) -> Vec<Check> {
        self.judged(settings, true, true)
    }

    /// All checks at this state: those on 237 bits if `wide`, with mutants if it `proves`.
    pub(super) fn judged(&self, settings: &Settings, wide: bool, proves: bool) -> Vec<Check> {
        let mut tables = self.criterion_tables(settings, wide);
        tables.extend(self.increment_tables(settings, wide));
        let mut found = checks(tables, settings, &self.name, proves);
        found.iter_mut().for_each(|check| check.fails_at(|| Failing::Friction(Box::new(self.clone()))));
        found
    }

    fn context<R: Real>(&self) -> Context<'_, R> {
        let all = |x: [f64; 6]| x.map(R::from_f64);
        Context {
            position: all(self.position),
            motion: all(self.motion),
            accumulated_slip: R::from_f64(self.accumulated_slip),
            conditions: &self.conditions,
        }
    }
}

/// The sizes of forces and moments: the largest force, and the largest moment; where one of them is all zero, what the other makes of it
/// with the connector's length; 1 where nothing acts.
fn force_sizes(forces: &[f64; 6], length: f64) -> [f64; 6] {
    let largest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let (force, moment) = match (largest(&forces[..3]), largest(&forces[3..])) {
        (0.0, 0.0) => (1.0, length),
        (0.0, moment) => (moment / length, moment),
        (force, 0.0) => (force, force * length),
        both => both,
    };
    [force, force, force, moment, moment, moment]
}

/// The sizes of two groups of forces apart, those chosen and the others: tractions and what presses are of sizes of their own. A group
/// that is all zero has the sizes of both.
fn group_sizes(forces: &[f64; 6], chosen: [bool; 6], length: f64) -> [f64; 6] {
    let overall = force_sizes(forces, length);
    let of = |group: bool| {
        let own: [f64; 6] = std::array::from_fn(|k| if chosen[k] == group { forces[k] } else { 0.0 });
        if own == [0.0; 6] { overall } else { force_sizes(&own, length) }
    };
    let (inside, outside) = (of(true), of(false));
    std::array::from_fn(|k| if chosen[k] { inside[k] } else { outside[k] })
}

/// How far each number may go before something else than its slope is seen: to zero, and where it is zero, as far as the smallest of
/// the others that are measured by the same size: of one unit.
fn reach(of: &[f64], sizes: &[f64]) -> Vec<f64> {
    let least = |size: f64| {
        let alike = of.iter().zip(sizes).filter(|(x, other)| **x != 0.0 && **other == size);
        alike.fold(f64::INFINITY, |least, (x, _)| least.min(x.abs()))
    };
    let own = |(x, size): (&f64, &f64)| {
        let clear = if *x == 0.0 { least(*size) } else { x.abs() };
        if clear.is_finite() { clear.min(*size) } else { *size }
    };
    of.iter().zip(sizes).map(own).collect()
}

impl From<FactorMistake> for Mistake {
    fn from(mistake: FactorMistake) -> Self {
        match mistake {
            FactorMistake::NumberLeftOut => Self::NumberLeftOut,
            FactorMistake::Multiplied => Self::MultipliedInsteadOfDivided,
        }
    }
}
