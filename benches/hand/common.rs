//! What the programs of time against error have in common.

use super::peer::numbers;
use pintle_bench::{Element, Report, Settings, Subject};
use pintle_kinematics::batch::COLUMNS;
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::DOFS;
use serde_json::{Value, json};

/// States that differ, and how many elements a batch has.
const STATES: usize = 64;
const BATCH: usize = 1024;

pub(crate) fn settings() -> Settings {
    Settings { states: STATES, batch: BATCH, ..Settings::default() }
}

/// The states as the others read them.
pub(crate) fn flat(subject: &Subject) -> Vec<[f64; 27]> {
    subject.elements.iter().map(|element| numbers(&element.state.pair)).collect()
}

/// A report before anything is timed.
pub(crate) fn untimed(report: &Report) -> Value {
    let mut greeting = serde_json::to_value(report).unwrap();
    for point in greeting["points"].as_array_mut().unwrap() {
        point["nanoseconds"] = json!(0.0);
    }
    greeting
}

/// Whether the rows of a subject are those that are written in this folder, where misalignment is measured from Q₀ = I.
pub(crate) fn is_written(subject: &Subject) -> Result<(), &'static str> {
    use Measure::{Cardan, Cosine, Misalignment, Position, RotationVector};
    let three = |of: fn(usize) -> Measure| [1, 2, 3].map(of);
    let rows: Vec<Measure> = match subject.connection.name.as_ref() {
        "SLIDE-PLANE" => three(Position).to_vec(),
        "REVOLUTE" => vec![Cardan(1), Cosine(1, 3), Cosine(1, 2)],
        "TRANSLATOR" => [three(Position), three(Misalignment)].concat(),
        "ROTATION" => three(RotationVector).to_vec(),
        "CARDAN" => three(Cardan).to_vec(),
        _ => return Err("its rows are not written"),
    };
    // Two triads that are one have a product that is I but for rounding.
    let is_misaligned = |element: &Element| {
        let q0 = element.connector.section().initial_orientation;
        let off = |i: usize, j: usize| (q0[i][j] - f64::from(u8::from(i == j))).abs();
        (0..3).any(|i| (0..3).any(|j| off(i, j) > 4.0 * f64::EPSILON))
    };
    if subject.measures != rows {
        Err("its rows here are not those that are written")
    } else if rows.contains(&Misalignment(1)) && subject.elements.iter().any(is_misaligned) {
        Err("it is misaligned initially")
    } else {
        Ok(())
    }
}

/// A row of twelve columns among all degrees of freedom.
pub(crate) fn spread(columns: &[f64; 12]) -> [f64; DOFS] {
    let mut row = [0.0; DOFS];
    COLUMNS.iter().zip(columns).for_each(|(j, x)| row[*j] = *x);
    row
}
