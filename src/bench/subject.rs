//! Where a type is measured: states far from its singular points and near them, with the truth.

use super::place::{Place, Unmeasured, draw, rows_of};
use crate::audit::Case;
use crate::audit::case::{dof_size, exact_branch, exact_pair};
use crate::audit::truth::Truth;
use crate::catalog::ConnectionType;
use crate::connector::{Branch, Connector, State};
use crate::measure::Measure;
use crate::node::DOFS;
use crate::scalar::Wide;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What is computed of each component.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Order {
    /// What is enforced to be zero, or the position.
    Value,
    /// Its derivatives by the nodal degrees of freedom.
    Jacobian,
    /// Its second derivatives.
    Hessian,
}

impl Order {
    /// All, in order.
    pub const ALL: [Self; 3] = [Self::Value, Self::Jacobian, Self::Hessian];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Value => "value",
            Self::Jacobian => "Jacobian",
            Self::Hessian => "Hessian",
        }
    }

    /// The numbers of one row: 1, 14, 196.
    pub const fn width(self) -> usize {
        match self {
            Self::Value => 1,
            Self::Jacobian => DOFS,
            Self::Hessian => DOFS * DOFS,
        }
    }
}

/// A connector at a state.
#[derive(Clone, Debug)]
pub struct Element {
    /// The connector.
    pub connector: Connector<f64>,
    /// The state.
    pub state: State<f64>,
    /// The branch of the state itself.
    pub branch: Branch<f64>,
}

/// A type at the states of one place, with the truth.
pub struct Subject {
    /// The type.
    pub connection: ConnectionType,
    /// Which states.
    pub place: Place,
    /// The components (0-based) that are measured: those with a function of the nodes.
    pub components: Vec<usize>,
    /// What each of them is.
    pub measures: Vec<Measure>,
    /// The connectors and states.
    pub elements: Vec<Element>,
    /// How many elements a batch has: those of the subject, over and over.
    pub batch: usize,
    /// By order, then state by state and row by row, on 237 bits.
    truth: [Vec<Wide>; 3],
    /// What a value is compared with, state by state and row by row ([`Subject::errors`]).
    size_of_values: Vec<f64>,
}

impl Subject {
    /// A type at `count` states, always the same ones, all with the same rows; those near a singular point are `distance` (rad, lengths of the
    /// connector) away.
    ///
    /// # Errors
    /// Why there is nothing to measure.
    pub fn new(
        connection: &ConnectionType,
        place: Place,
        count: usize,
        distance: f64,
    ) -> Result<Self, Unmeasured> {
        if connection.positions().all(Measure::is_one_form) {
            return Err(Unmeasured::NoFunction);
        }
        let cases = draw(connection, place, count, distance)?;
        let elements: Vec<Element> =
            cases.iter().map(Element::of).collect::<Option<_>>().ok_or(Unmeasured::NoState)?;
        let connector = &elements.first().ok_or(Unmeasured::NoState)?.connector;
        let (components, measures): (Vec<usize>, Vec<Measure>) = (0..6)
            .zip(rows_of(connector))
            .filter_map(|(k, measure)| Some((k, measure?)))
            .filter(|(_, measure)| !measure.is_one_form())
            .unzip();
        let truths: Vec<[Vec<Wide>; 3]> = cases
            .par_iter()
            .zip(&elements)
            .map(|(case, element)| truth(case, element, &components))
            .collect::<Option<_>>()
            .ok_or(Unmeasured::NoTruth)?;
        let mut size_of_values = Vec::new();
        let mut truth = [const { Vec::new() }; 3];
        for (case, of) in cases.iter().zip(truths) {
            let [values, rows, _] = &of;
            let of_row = |(value, row): (&Wide, &[Wide])| {
                let each = row.iter().enumerate().map(|(j, x)| x.to_f64().abs() * dof_size(j, case.length));
                value.to_f64().abs() + each.sum::<f64>()
            };
            size_of_values.extend(values.iter().zip(rows.chunks_exact(DOFS)).map(of_row));
            truth.iter_mut().zip(of).for_each(|(all, numbers)| all.extend(numbers));
        }
        let connection = connection.clone();
        let batch = elements.len();
        Ok(Self { connection, place, components, measures, elements, batch, truth, size_of_values })
    }

    /// The same, with batches of so many elements; no fewer than there are states.
    #[must_use]
    pub fn repeated(mut self, batch: usize) -> Self {
        self.batch = batch.max(self.states());
        self
    }

    /// The elements of a batch: those of the subject, over and over.
    pub fn in_batch(&self) -> impl Iterator<Item = &Element> {
        self.elements.iter().cycle().take(self.batch)
    }

    /// The number of states that differ.
    pub fn states(&self) -> usize {
        self.elements.len()
    }

    /// The number of rows of an element.
    pub fn rows(&self) -> usize {
        self.components.len()
    }

    /// The truth, rounded to doubles: element by element, row by row.
    pub fn truth(&self, order: Order) -> Vec<f64> {
        self.truth[order as usize].iter().map(|x| x.to_f64()).collect()
    }

    /// What the error of a value is compared with, state by state and row by row: |f| + Σ_k |∂f/∂q_k| s_k, s_k = 1 rad or the
    /// connector's own length. So much times the unit of rounding is what the rounding of the input does to it.
    pub fn size_of_values(&self) -> &[f64] {
        &self.size_of_values
    }

    /// The median and the largest error of numbers element by element, row by row, of the states over and over: of a value over [`Subject::size_of_values`], of a derivative over the largest
    /// number of its row, the first ones counting among those of a second. What is not a number is an infinite error.
    pub fn errors(&self, order: Order, found: &[f64]) -> [f64; 2] {
        let (width, rows, states) = (order.width(), self.rows(), self.states());
        let size = |numbers: &[Wide]| numbers.iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
        let scale = |row: usize| match order {
            Order::Value => self.size_of_values[row],
            _ => {
                let own = size(&self.truth[order as usize][row * width..(row + 1) * width]);
                own.max(size(&self.truth[1][row * DOFS..(row + 1) * DOFS]))
            }
        };
        let scales: Vec<f64> = (0..states * rows).map(scale).collect();
        let count = (found.len() / (rows * width).max(1)).max(states);
        let mut each: Vec<f64> = (0..count)
            .map(|i| {
                (0..rows).fold(0.0, |worst: f64, r| {
                    let (row, known) = (i * rows + r, i % states * rows + r);
                    let want = &self.truth[order as usize][known * width..(known + 1) * width];
                    let got = found.get(row * width..(row + 1) * width).unwrap_or_default();
                    if got.len() < width {
                        return f64::INFINITY;
                    }
                    got.iter().zip(want).fold(worst, |worst, (got, want)| {
                        let error = (Wide::from_f64(*got) - *want).abs().to_f64() / scales[known];
                        if error.is_nan() || !got.is_finite() { f64::INFINITY } else { worst.max(error) }
                    })
                })
            })
            .collect();
        each.sort_by(f64::total_cmp);
        [each.get(each.len() / 2), each.last()].map(|error| error.copied().unwrap_or(f64::INFINITY))
    }
}

impl Element {
    fn of(case: &Case) -> Option<Self> {
        let connector = case.connector();
        let step = case.last()?;
        let branch = connector.advance(&step.state, &step.increment, &case.branch_before(&connector));
        Some(Self { connector, state: step.state, branch })
    }
}

/// Values by the 237-bit scalar, derivatives by differences on it.
fn truth(case: &Case, element: &Element, components: &[usize]) -> Option<[Vec<Wide>; 3]> {
    let truth = Truth::of(case)?;
    let wide = Connector::<Wide>::new(&case.definition);
    let values = wide.values(&exact_pair(&element.state.pair), &exact_branch(&element.branch), [true; 6]);
    let values: Vec<Wide> = components.iter().map(|k| values[*k]).collect::<Option<_>>()?;
    let (first, [second, _]) = (truth.first(), truth.second(false));
    let all = |of: &[Option<Vec<Wide>>; 6]| -> Option<Vec<Wide>> {
        let rows: Vec<&Vec<Wide>> = components.iter().map(|k| of[*k].as_ref()).collect::<Option<_>>()?;
        Some(rows.into_iter().flatten().copied().collect())
    };
    Some([values, all(&first.0)?, all(&second.0)?])
}
