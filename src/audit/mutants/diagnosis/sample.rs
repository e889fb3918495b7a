//! Wrong numbers that are kept until every state was seen.

use crate::case::Case;
use crate::case::quantity::{Entries, Numbers, Quantity};
use crate::judge::bound::Bound;
use crate::mutants::diagnosis::component::Symptoms;
use pintle_kinematics::draw::Draw;

/// Of how many states wrong numbers are kept.
const KEPT: usize = 16;

/// Wrong numbers of a state, and what they must be.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Its place among others, by its state: which ones are kept depends on neither their order nor their names.
    order: f64,
    quantity: Quantity,
    got: Entries<f64>,
    rows: Entries<f64>,
    want: Numbers<f64>,
    case: Case,
    bound: Bound,
}

impl Sample {
    /// A copy of what is wrong at a state.
    pub fn new(symptoms: &Symptoms<'_>) -> Self {
        let Symptoms { quantity, got, rows, want, case, bound } = *symptoms;
        let order = Draw::new(&format!("{:?}", case.last().map(|step| step.state.pair))).unit();
        Self {
            order,
            quantity,
            got: got.clone(),
            rows: rows.clone(),
            want: want.clone(),
            case: case.clone(),
            bound: bound.clone(),
        }
    }

    /// What is wrong.
    pub const fn symptoms(&self) -> Symptoms<'_> {
        let Self { quantity, got, rows, want, case, bound, .. } = self;
        Symptoms { quantity: *quantity, got, rows, want, case, bound }
    }

    /// Adds others, and keeps so many that memory is bounded.
    pub fn merge(samples: &mut Vec<Self>, others: Vec<Self>) {
        samples.extend(others);
        samples.sort_by(|x, y| x.order.total_cmp(&y.order).then_with(|| x.case.name.cmp(&y.case.name)));
        samples.truncate(KEPT);
    }
}
