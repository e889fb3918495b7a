//! What JAX says of predefined friction, by formulas and solutions of its own, at states of its own: `verify/golden/friction.json`,
//! written by `scripts/reference/reference_friction.py`.

use crate::case::failing::{Failing, FrictionCase};
use crate::case::quantity::Quantity;
use crate::friction::criterion::{PARTS, magnitudes};
use crate::friction::{Judged, checks};
use crate::judge::outcome::Check;
use crate::judge::table::{Entry, ResultTable};
use crate::oracles::golden::inflated;
use crate::oracles::oracle::Oracle;
use crate::settings::Settings;
use pintle_kinematics::catalog::{ConnectionType, FORCE};
use pintle_kinematics::scalar::{U, Wide};
use pintle_model::behavior::Conditions;
use pintle_model::behavior::friction::{Branch, Coefficient, Criterion, Friction, State, StickStiffness};
use serde::Deserialize;
use std::sync::LazyLock;

type Six = [f64; 6];

/// Roundings of the largest number of what is compared: JAX differentiates through square roots in doubles.
const ERROR: f64 = 256.0;

/// Δu, what presses, Δt.
const INPUTS: usize = 13;
/// Six forces, Δγ and F_N, by their places in the file and in a tangent.
const RESULTS: [(usize, usize); 8] = [(0, 0), (1, 1), (2, 2), (3, 3), (4, 4), (5, 5), (6, 6), (8, 7)];

#[derive(Deserialize)]
struct File {
    criteria: Vec<Forces>,
    updates: Vec<Update>,
}

#[derive(Deserialize)]
struct Forces {
    r#type: String,
    criterion: usize,
    parameters: Vec<f64>,
    coefficient: f64,
    forces: Six,
    position: Six,
    values: [f64; 4],
    gradients: [Six; 4],
    hessians: [[Six; 6]; 4],
}

#[derive(Deserialize)]
struct Update {
    r#type: String,
    criterion: usize,
    parameters: Vec<f64>,
    coefficients: [f64; 3],
    stick_stiffness: f64,
    start: Six,
    accumulated_slip: f64,
    displacement: Six,
    forces: Six,
    duration: f64,
    position: Six,
    values: [f64; 9],
    tangent: [[f64; INPUTS]; 9],
}

/// Nothing where the file cannot be read, which the test suite would notice.
static FILE: LazyLock<Option<File>> = LazyLock::new(|| {
    serde_json::from_str(&inflated(include_bytes!(concat!(env!("OUT_DIR"), "/friction")))).ok()
});

/// The checks of the predefined friction of a type, at every state of the file; none where JAX is not asked.
pub(crate) fn audit_golden(connection: &ConnectionType, settings: &Settings) -> Vec<Check> {
    let Some(file) = FILE.as_ref().filter(|_| settings.oracles.contains(&Oracle::Jax)) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    let mut add = |case: FrictionCase, tables: Vec<Judged>| {
        let mut of_case = checks(tables, settings, &case.name, true);
        of_case.iter_mut().for_each(|check| check.fails_at(|| Failing::Friction(Box::new(case.clone()))));
        found.extend(of_case);
    };
    for (n, told) in file.criteria.iter().filter(|told| told.r#type == connection.name).enumerate() {
        let Some(case) = told.case(connection, n) else { continue };
        let tables = told.tables(&case);
        add(case, tables);
    }
    for (n, told) in file.updates.iter().filter(|told| told.r#type == connection.name).enumerate() {
        let Some(case) = told.case(connection, n) else { continue };
        let tables = told.tables(&case, settings);
        add(case, tables);
    }
    found
}

fn criterion(connection: &ConnectionType, place: usize, parameters: &[f64]) -> Option<Criterion> {
    let numbers: Vec<Option<f64>> = parameters.iter().copied().map(Some).collect();
    let all = Criterion::predefined(&connection.friction?, &numbers, &[], false).ok()?;
    all.into_iter().nth(place)
}

/// Differences on doubles alone, for the numbers given and their conditioned scales.
fn narrow() -> Settings {
    Settings { oracles: [Oracle::Differences].into(), ..Settings::default() }
}

/// How far JAX may be off, by the largest of its numbers.
fn error(of: &[f64]) -> f64 {
    ERROR * U * of.iter().fold(1.0, |most: f64, x| most.max(x.abs()))
}

/// The same numbers, with what JAX says of them.
fn told(mut table: ResultTable, want: &[f64]) -> Option<Judged> {
    if table.entries.len() != want.len() {
        return None;
    }
    let width = table.width();
    for (entry, want) in table.entries.chunks_mut(width).zip(want.chunks(width)) {
        let error = error(want);
        for (entry, want) in entry.iter_mut().zip(want) {
            (entry.want, entry.error, entry.sides) = (Wide::from_f64(*want), error, None);
        }
    }
    Some((Oracle::Jax, table))
}

impl Forces {
    fn case(&self, connection: &ConnectionType, n: usize) -> Option<FrictionCase> {
        let friction = Friction {
            criterion: criterion(connection, self.criterion, &self.parameters)?,
            coefficient: Coefficient::Constant(self.coefficient),
            maximum: None,
            stick_stiffness: StickStiffness::Given(1.0),
            radius: 1.0,
        };
        Some(FrictionCase {
            name: format!("{} friction {}, forces {} of JAX", connection.name, self.criterion + 1, n + 1),
            title: String::new(),
            friction,
            coefficient: self.coefficient,
            point: self.forces,
            before: State::default(),
            displacement: [0.0; 6],
            forces: self.forces,
            position: self.position,
            motion: self.position,
            accumulated_slip: 0.0,
            duration: None,
            conditions: Conditions::default(),
            length: 1.0,
        })
    }

    fn tables(&self, case: &FrictionCase) -> Vec<Judged> {
        let mut found = Vec::new();
        for (_, table) in case.criterion_tables(&narrow(), false) {
            let want: Vec<f64> = match table.quantity {
                Quantity::FrictionGradient => self.gradients.as_flattened().to_vec(),
                _ => self.hessians.as_flattened().as_flattened().to_vec(),
            };
            found.extend(told(table, &want));
        }
        let got = case.part_values();
        let scales = magnitudes(&got);
        let entry = |p: usize| {
            let want = Wide::from_f64(self.values[p]);
            let entry = Entry::new(PARTS[p].to_string(), got[p], want, scales[p], (0, 0, 0));
            Entry { error: error(&self.values), ..entry }
        };
        let mut table = ResultTable::new(Quantity::FrictionCriterion);
        table.rows = PARTS.map(String::from).to_vec();
        table.entries = (0..4).map(entry).collect();
        found.push((Oracle::Jax, table));
        found
    }
}

impl Update {
    fn case(&self, connection: &ConnectionType, n: usize) -> Option<FrictionCase> {
        let [at_rest, kinetic, decay] = self.coefficients;
        let friction = Friction {
            criterion: criterion(connection, self.criterion, &self.parameters)?,
            coefficient: Coefficient::Exponential { at_rest, kinetic, decay },
            maximum: None,
            stick_stiffness: StickStiffness::Given(self.stick_stiffness),
            radius: 1.0,
        };
        Some(FrictionCase {
            name: format!("{} friction {}, increment {} of JAX", connection.name, self.criterion + 1, n + 1),
            title: String::new(),
            friction,
            coefficient: at_rest,
            point: self.forces,
            before: State {
                force: self.start,
                accumulated_slip: self.accumulated_slip,
                stick_stiffness: Some(self.stick_stiffness),
            },
            displacement: self.displacement,
            forces: self.forces,
            position: self.position,
            motion: self.position,
            accumulated_slip: self.accumulated_slip,
            duration: Some(self.duration),
            conditions: Conditions::default(),
            length: 1.0,
        })
    }

    fn tables(&self, case: &FrictionCase, settings: &Settings) -> Vec<Judged> {
        let of_product = Settings { planted: settings.planted, ..narrow() };
        let Some((_, mut tangent)) = case.increment_tables(&of_product, false).into_iter().next() else {
            return Vec::new();
        };
        // JAX says nothing of the limit.
        tangent.rows.truncate(RESULTS.len());
        tangent.entries.truncate(RESULTS.len() * INPUTS);
        let sizes = [&self.displacement[..], &self.forces, &[self.duration]].concat();
        let outcome = case.friction.tangent(&case.before, &case.input(0, 0.0), Branch::Decided).0;
        let got = [&outcome.force[..], &[outcome.slip_increment, outcome.normal]].concat();
        let entry = |(place, _): &(usize, usize), row: usize| {
            let slopes = tangent.entries.iter().skip(row * INPUTS).zip(&sizes);
            let formed: f64 = slopes.map(|(entry, size)| (entry.got * size).abs()).sum();
            let name = FORCE.get(row).copied().unwrap_or(if row == 6 { "Δγ" } else { "F_N" });
            let scale = got[row].abs() + formed;
            let want = Wide::from_f64(self.values[*place]);
            let entry = Entry::new(name.to_string(), got[row], want, scale, (row.min(6) / 3 + row / 7, 0, 0));
            Entry { error: error(&self.values), ..entry }
        };
        let mut table = ResultTable::new(Quantity::FrictionForce);
        table.entries = RESULTS.iter().enumerate().map(|(row, place)| entry(place, row)).collect();
        table.rows = table.entries.iter().map(|entry| entry.name.clone()).collect();
        let want: Vec<f64> = RESULTS.iter().flat_map(|(place, _)| self.tangent[*place]).collect();
        told(tangent, &want).into_iter().chain([(Oracle::Jax, table)]).collect()
    }
}
