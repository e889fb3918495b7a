//! Where a type is measured: states far from its singular points and near them, with the truth.

use crate::audit::atlas::near;
use crate::audit::case::{exact_branch, exact_pair, turn};
use crate::audit::sample::{Draw, Region, definition, draw_case, pair};
use crate::audit::truth::Truth;
use crate::audit::{Case, Step};
use crate::catalog::ConnectionType;
use crate::connector::{Branch, Connector, State};
use crate::measure::Measure;
use crate::node::DOFS;
use crate::scalar::Wide;
use crate::vector::{self, scale};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Which states.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// At least 0.15 rad or lengths of the connector from every singular point.
    Far,
    /// Near a singular point of the type or, where a rotation vector is measured, near half a turn: where formulas lose digits.
    Near,
}

impl Place {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Far, Self::Near];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Far => "far",
            Self::Near => "near",
        }
    }
}

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
    /// By order, then element by element and row by row, on 237 bits.
    truth: [Vec<Wide>; 3],
}

/// How far the row of a value may be from the truth, relative to the largest number of the row, to be timed; near a singular point over
/// the distance from it.
const BOUND: [f64; 3] = [1e-14, 1e-14, 1e-13];

impl Subject {
    /// A type at `count` states, always the same; those near a singular point are `distance` (rad, lengths of the connector) away.
    ///
    /// `None` where there is nothing to measure: a type without singular points has no states near one, and one-forms have no
    /// function to difference.
    pub fn new(connection: &ConnectionType, place: Place, count: usize, distance: f64) -> Option<Self> {
        let mut draw = Draw::new(&format!("bench {} {}", connection.name, place.name()));
        let cases: Vec<Case> = (0..count)
            .map(|i| match place {
                Place::Far => draw_case(connection, Region::Aligned, &mut draw),
                Place::Near => case_near(connection, i, distance, &mut draw),
            })
            .collect::<Option<_>>()?;
        let elements: Vec<Element> = cases.iter().map(Element::of).collect::<Option<_>>()?;
        let connector = &elements.first()?.connector;
        let (components, measures): (Vec<usize>, Vec<Measure>) = (0..6)
            .filter_map(|k| Some((k, connector.differentiated(k)?)))
            .filter(|(_, measure)| !measure.is_one_form())
            .unzip();
        if components.is_empty() {
            return None;
        }
        let truths: Vec<[Vec<Wide>; 3]> = cases
            .par_iter()
            .zip(&elements)
            .map(|(case, element)| truth(case, element, &components))
            .collect::<Option<_>>()?;
        let mut truth = [const { Vec::new() }; 3];
        for of in truths {
            truth.iter_mut().zip(of).for_each(|(all, numbers)| all.extend(numbers));
        }
        Some(Self { connection: connection.clone(), place, components, measures, elements, truth })
    }

    /// The number of rows of an element.
    pub fn rows(&self) -> usize {
        self.components.len()
    }

    /// The truth, rounded to doubles: element by element, row by row.
    pub fn truth(&self, order: Order) -> Vec<f64> {
        self.truth[order as usize].iter().map(|x| x.to_f64()).collect()
    }

    /// The median and the largest error over the states: of an entry, over the largest number of its row; of a second derivative, the first
    /// ones count among those. What is not a number is an infinite error.
    pub fn errors(&self, order: Order, found: &[f64]) -> [f64; 2] {
        let (width, rows) = (order.width(), self.rows());
        let size = |numbers: &[Wide]| numbers.iter().fold(0.0, |most: f64, x| most.max(x.to_f64().abs()));
        let mut each: Vec<f64> = (0..self.elements.len())
            .map(|i| {
                (i * rows..(i + 1) * rows).fold(0.0, |worst: f64, row| {
                    let want = &self.truth[order as usize][row * width..(row + 1) * width];
                    let scale = size(want).max(size(&self.truth[1][row * DOFS..(row + 1) * DOFS]));
                    let got = found.get(row * width..(row + 1) * width).unwrap_or_default();
                    if got.len() < width {
                        return f64::INFINITY;
                    }
                    got.iter().zip(want).fold(worst, |worst, (got, want)| {
                        let error = (Wide::from_f64(*got) - *want).abs().to_f64() / scale;
                        if error.is_nan() || !got.is_finite() { f64::INFINITY } else { worst.max(error) }
                    })
                })
            })
            .collect();
        each.sort_by(f64::total_cmp);
        [each.get(each.len() / 2), each.last()].map(|error| error.copied().unwrap_or(f64::INFINITY))
    }

    /// The error beyond which pintle's own numbers are wrong, and are not timed.
    pub fn bound(&self, order: Order, distance: f64) -> f64 {
        let condition = match self.place {
            Place::Far => 1.0,
            Place::Near => distance.recip().max(1.0),
        };
        BOUND[order as usize] * condition
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

/// State `i` near a singular point of one of the measures, or near half a turn.
fn case_near(connection: &ConnectionType, i: usize, distance: f64, draw: &mut Draw) -> Option<Case> {
    let measures: Vec<Measure> = connection.singular_measures().collect();
    let measure = *measures.get(i % measures.len().max(1))?;
    if matches!(measure, Measure::RotationVector(_) | Measure::RotationVectorAtB(_)) {
        let a0 = draw.triad();
        let definition = definition(connection, pair([0.5, -0.25, 1.0], a0, &vector::identity()), 1.0);
        let spin = turn(scale(draw.direction(), PI - distance));
        let after = pair([0.5, -0.25, 1.0], a0, &spin);
        let step = Step::between(&definition.initial, after);
        let name = format!("{} {distance:e} from half a turn", connection.name);
        return Some(Case { name, definition, start: None, path: vec![step], length: 1.0 });
    }
    near(connection, measure, distance, draw.between(-PI, PI), draw)
}
