//! Where a type is measured: states far from its singular points and near them, with the truth.

use crate::place::{Proximity, Unmeasured, draw, rows_of};
use pintle_audit::case::exact_branch;
use pintle_audit::judge::bound::scales;
use pintle_audit::oracles::truth::Truth;
use pintle_audit::{C, Case};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::{Branch, Connector, State};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::DOFS;
use pintle_kinematics::node::dof_size;
use pintle_kinematics::scalar::U;
use pintle_kinematics::scalar::Wide;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

pintle_kinematics::named! {
    /// What is computed of each component.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Order {
        /// What is enforced to be zero, or the position.
        Value = "value",
        /// Its derivatives by the nodal degrees of freedom.
        Jacobian = "Jacobian",
        /// Its second derivatives.
        Hessian = "Hessian",
    }
}

impl Order {
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
    pub place: Proximity,
    /// The components (0-based) that are measured: those with a function of the nodes.
    pub components: Vec<usize>,
    /// What each of them is.
    pub measures: Vec<Measure>,
    /// The components whose rows are not measured: one-forms, which are no functions of the nodes.
    pub left_out: Vec<usize>,
    /// The connectors and states.
    pub elements: Vec<Element>,
    /// How many elements a batch has: those of the subject, over and over.
    pub batch: usize,
    /// By order, then state by state and row by row, on 237 bits.
    truth: [Vec<Wide>; 3],
    /// How far rounding may take each of these numbers ([`Subject::beyond_rounding`]).
    tolerance: [Vec<f64>; 3],
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
        place: Proximity,
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
        let with_rows = (0..6).zip(rows_of(connector)).filter_map(|(k, measure)| Some((k, measure?)));
        let (one_forms, functions): (Vec<_>, Vec<_>) =
            with_rows.partition(|(_, measure)| measure.is_one_form());
        let (components, measures): (Vec<usize>, Vec<Measure>) = functions.into_iter().unzip();
        let left_out = one_forms.into_iter().map(|(k, _)| k).collect();
        let truths: Vec<Known> = cases
            .par_iter()
            .zip(&elements)
            .map(|(case, element)| truth(case, element, &components))
            .collect::<Option<_>>()
            .ok_or(Unmeasured::NoTruth)?;
        let mut size_of_values = Vec::new();
        let (mut truth, mut tolerance) = ([const { Vec::new() }; 3], [const { Vec::new() }; 3]);
        for Known { numbers, scales } in truths {
            size_of_values.extend(&scales[0]);
            truth.iter_mut().zip(numbers).for_each(|(all, numbers)| all.extend(numbers));
            tolerance.iter_mut().zip(scales).for_each(|(all, of)| all.extend(of.iter().map(|x| C * U * x)));
        }
        let connection = connection.clone();
        let batch = elements.len();
        Ok(Self {
            connection,
            place,
            components,
            measures,
            left_out,
            elements,
            batch,
            truth,
            tolerance,
            size_of_values,
        })
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

    /// The median and the largest error of numbers element by element, row by row, of the states over and over. That of a value is
    /// over [`Subject::size_of_values`], that of a derivative over the largest number of its row. The row of a second derivative
    /// has the first ones too. What is not a number is an infinite error.
    pub fn errors(&self, order: Order, found: &[f64]) -> [f64; 2] {
        let per_state = self.rows() * order.width();
        let scales = self.scales(order);
        let all = self.offsets(order, found);
        let mut each: Vec<f64> = all
            .chunks(per_state.max(1))
            .map(|of_state| {
                let of_state =
                    of_state.iter().map(|offset| offset.error / scales[offset.known / order.width()]);
                of_state.fold(0.0, worse)
            })
            .collect();
        each.sort_by(f64::total_cmp);
        [each.get(each.len() / 2), each.last()].map(|error| error.copied().unwrap_or(f64::INFINITY))
    }

    /// The entry that is farthest beyond what rounding explains: its error, and the one that is allowed there, both as
    /// [`Subject::errors`] tells them.
    ///
    /// What is allowed is what `pintle audit` allows there ([`pintle_audit::judge::bound`]): C u times what the rounding of the state does to the entry, by the derivatives one
    /// order higher. Beside a singular set rows are directions that a rounding of the state turns by u/δ. Of a row with a small first and a large
    /// second derivative, that is much of the row: its largest number would say nothing of that.
    pub fn beyond_rounding(&self, order: Order, found: &[f64]) -> [f64; 2] {
        let scales = self.scales(order);
        let relative = |Offset { error, known }: Offset| {
            let (scale, tolerance) = (scales[known / order.width()], self.tolerance[order as usize][known]);
            // A tolerance that is no number allows nothing.
            [error / scale, if tolerance.is_finite() { tolerance / scale } else { 0.0 }]
        };
        // An error of zero is within any tolerance, that of zero too.
        let excess = |of: &[f64; 2]| if of[0] == 0.0 { 0.0 } else { worse(0.0, of[0] / of[1]) };
        let all = self.offsets(order, found).into_iter().map(relative);
        all.max_by(|a, b| excess(a).total_cmp(&excess(b))).unwrap_or([f64::INFINITY, 0.0])
    }

    /// What errors are told over, row by row of all states: 1 of a row of zeros.
    fn scales(&self, order: Order) -> Vec<f64> {
        let width = order.width();
        let size = |numbers: &[Wide]| numbers.iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
        let scale = |row: usize| match order {
            Order::Value => self.size_of_values[row],
            _ => {
                let own = size(&self.truth[order as usize][row * width..(row + 1) * width]);
                own.max(size(&self.truth[1][row * DOFS..(row + 1) * DOFS]))
            }
        };
        let or_one = |scale: f64| if scale == 0.0 { 1.0 } else { scale };
        (0..self.states() * self.rows()).map(scale).map(or_one).collect()
    }

    /// The errors of numbers element by element, row by row, of the states over and over; of all states at least.
    fn offsets(&self, order: Order, found: &[f64]) -> Vec<Offset> {
        let truth = &self.truth[order as usize];
        let of = |i: usize| {
            let known = i % truth.len();
            let got = found.get(i).copied().unwrap_or(f64::NAN);
            let error = (Wide::from_f64(got) - truth[known]).abs().to_f64();
            Offset { error: if got.is_finite() { worse(0.0, error) } else { f64::INFINITY }, known }
        };
        (0..if truth.is_empty() { 0 } else { found.len().max(truth.len()) }).map(of).collect()
    }
}

/// How far a number is from the truth, and which of those known it is.
struct Offset {
    error: f64,
    known: usize,
}

/// The larger of two errors; one that is no number is infinite, where [`f64::max`] would pass over it.
pub fn worse(worst: f64, error: f64) -> f64 {
    if worst.is_nan() || error.is_nan() { f64::INFINITY } else { worst.max(error) }
}

impl Element {
    fn of(case: &Case) -> Option<Self> {
        let connector = case.connector();
        let step = case.last()?;
        let branch = connector.advance(&step.state, &step.increment, &case.branch_before(&connector));
        Some(Self { connector, state: step.state, branch })
    }
}

/// The truth of a case, order by order and row by row, and what the rounding of its state does to each number
/// ([`scales`]).
struct Known {
    numbers: [Vec<Wide>; 3],
    scales: [Vec<f64>; 3],
}

/// Values by the 237-bit scalar, derivatives by differences on it.
fn truth(case: &Case, element: &Element, components: &[usize]) -> Option<Known> {
    let truth = Truth::of(case)?;
    let wide = Connector::<Wide>::new(&case.definition);
    let values = wide.values(&element.state.pair.exact(), &exact_branch(&element.branch), [true; 6]);
    let (first, [second, _]) = (truth.first(), truth.second(false));
    let (nearness, size) = (truth.nearness_of_components(), dof_sizes(case));
    let mut known = Known { numbers: Default::default(), scales: Default::default() };
    for k in components.iter().copied() {
        let numbers = [vec![values[k]?], first.0[k].clone()?, second.0[k].clone()?];
        let [value, row, matrix] =
            numbers.each_ref().map(|of| of.iter().map(|x| x.to_f64()).collect::<Vec<_>>());
        let still = ([0.0; DOFS], [0.0; DOFS]);
        let [of_value, of_row, of_matrix, ..] =
            scales(value[0], &row, &matrix, (&size, &size), (&still.0, &still.1), nearness[k]);
        known.numbers.iter_mut().zip(numbers).for_each(|(all, of)| all.extend(of));
        known.scales.iter_mut().zip([of_value, of_row, of_matrix]).for_each(|(all, of)| all.extend(of));
    }
    Some(known)
}

/// s_j, 1 rad or the connector's length.
fn dof_sizes(case: &Case) -> [f64; DOFS] {
    std::array::from_fn(|j| dof_size(j, case.length))
}
