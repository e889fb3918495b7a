//! What is right at the states of a fit, in every form that a convention may give it.

use super::space::Reading;
use crate::convention::{Axes, Frame, Positions, Turned, Variation, is_vector};
use pintle_audit::{Case, MpcCase, Quantity, Right, Step};
use pintle_kinematics::connector::{Connector, Definition, State};
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::mpc::{Body, DOFS, MpcType, PHI};
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::scalar::U;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Matrix, product, transpose};

/// Roundings that a routine may spend on a convention: products by units and sums of three.
const ROUNDINGS: f64 = 8.0 * U;

/// A number, and how far a right answer may be from it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Number {
    pub(super) x: f64,
    pub(super) off: f64,
}

impl Number {
    /// Whether `got` is this number times a factor.
    pub(super) fn is(&self, got: f64, factor: f64) -> bool {
        let want = factor * self.x;
        (got - want).abs() <= factor.abs() * self.off + ROUNDINGS * want.abs()
    }

    /// Whether it is too small to tell a factor by.
    pub(super) fn tells_nothing(&self) -> bool {
        self.x.abs() <= 1e4 * self.off
    }
}

/// Three numbers of a row: by the displacements or the rotations of a node.
pub(super) type Block = [Number; 3];

/// The blocks of a row, in every form.
#[derive(Clone, Debug)]
pub(super) struct Row {
    /// Of a and b, by the displacements along the axes of each frame.
    pub(super) displacements: [[Block; Frame::ALL.len()]; 2],
    /// By each variation of rotations.
    pub(super) rotations: [[Block; Variation::ALL.len()]; 2],
    /// By the flows, and by the angles of hinges.
    pub(super) single: [Number; 4],
}

impl Row {
    /// From the entries by the degrees of freedom of both nodes, and those by the angles of hinges.
    fn of(entry: &dyn Fn(usize) -> Number, hinges: [Number; 2], turned: &[Turned; 2]) -> Self {
        let block = |at: usize| [0, 1, 2].map(|i| entry(at + i));
        let displacements =
            |end: usize| Frame::ALL.map(|frame| times(&frame.axes(end, turned), block(7 * end)));
        let rotations =
            |end: usize| Variation::ALL.map(|of| times(&of.jacobian(&turned[end]), block(7 * end + 3)));
        Self {
            displacements: [0, 1].map(displacements),
            rotations: [0, 1].map(rotations),
            single: [entry(6), entry(13), hinges[0], hinges[1]],
        }
    }

    /// By a degree of freedom that has no others beside it.
    pub(super) fn by(&self, place: usize) -> Number {
        match place {
            6 => self.single[0],
            13 => self.single[1],
            hinge => self.single[hinge - PHI + 2],
        }
    }
}

/// A line that a routine may give: a component, or a cosine as an angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Line {
    pub(super) k: usize,
    pub(super) is_as_angle: bool,
    pub(super) unit: Unit,
}

/// What is right of a line at one state.
#[derive(Clone, Debug)]
pub(super) struct Right1 {
    pub(super) row: Row,
    /// The value as each of [`Positions::ALL`].
    pub(super) values: [Option<Number>; Positions::ALL.len()],
    pub(super) rate: Option<Number>,
}

/// Which columns a connector can have entries in, at any state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said {
    pub(super) displacements: bool,
    /// Of a and of b.
    pub(super) rotations: [bool; 2],
    pub(super) flows: bool,
    pub(super) hinges: bool,
    /// Whether it matters how orientations are read.
    pub(super) turns: bool,
}

/// What is right at all states, of every line, where the orientations are read and vectors resolved in one way.
#[derive(Clone, Debug)]
pub(super) struct Expected {
    pub(super) lines: Vec<Line>,
    pub(super) said: Said,
    /// By state, then by line.
    pub(super) at: Vec<Vec<Right1>>,
}

/// m^T applied to a block.
fn times(m: &Matrix<f64>, of: Block) -> Block {
    [0, 1, 2].map(|j| {
        let terms = [0, 1, 2].map(|i| m[i][j] * of[i].x);
        let size: f64 = (0..3).map(|i| (m[i][j] * of[i].x).abs()).sum();
        let off: f64 = (0..3).map(|i| m[i][j].abs() * of[i].off).sum();
        Number { x: terms[0] + terms[1] + terms[2], off: off + ROUNDINGS * size }
    })
}

/// The pair and connector as a routine sees them that reads orientations in its own way.
fn read(definition: &Definition, pair: &Pair<f64>, reading: Reading) -> (Definition, Pair<f64>) {
    let (mut of, mut now) = (definition.clone(), *pair);
    let initial = [definition.initial.a, definition.initial.b];
    let turned = |node: &Node<f64>, first: &Node<f64>| product(&node.triad, &transpose(&first.triad));
    for (end, (node, first)) in [&mut now.a, &mut now.b].into_iter().zip(initial).enumerate() {
        let rotation = turned(node, &first);
        match reading {
            Reading::Right => {}
            Reading::Transposed => {
                node.triad = transpose(&node.triad);
                let first = if end == 0 { &mut of.initial.a } else { &mut of.initial.b };
                first.triad = transpose(&first.triad);
            }
            Reading::Inverse => node.triad = product(&transpose(&rotation), &first.triad),
            Reading::ScalarLast => {
                let mut quaternion = so3::quaternion(&rotation);
                quaternion.rotate_right(1);
                node.triad = product(&so3::matrix(quaternion), &first.triad);
            }
        }
    }
    (of, now)
}

impl Expected {
    /// `None` where a reading leaves no state of the connector.
    pub(super) fn of(
        definition: &Definition,
        states: &[State<f64>],
        reading: Reading,
        axes: Axes,
        length: f64,
    ) -> Option<Self> {
        // Where triads are read transposed, the initial ones are too, and another measure may be constrained.
        let (as_read, _) = read(definition, &definition.initial, reading);
        let connector = Connector::<f64>::new(&as_read);
        let blocks: Vec<usize> = [0, 3].into_iter().filter(|first| is_vector(&connector, *first)).collect();
        if axes != Axes::A && blocks.is_empty() {
            return None;
        }
        let measures: [Option<Measure>; 6] = std::array::from_fn(|k| connector.differentiated(k));
        let mut lines = Vec::new();
        for (k, measure) in measures.iter().enumerate().filter_map(|(k, of)| Some((k, (*of)?))) {
            lines.push(Line { k, is_as_angle: false, unit: measure.unit() });
            if matches!(measure, Measure::Cosine(..)) {
                lines.push(Line { k, is_as_angle: true, unit: Unit::Angle });
            }
        }
        let active = connector.active();
        let any = |of: std::ops::Range<usize>| active[of].contains(&true);
        let depends = |on: fn(Measure) -> bool| measures.iter().flatten().any(|measure| on(*measure));
        let turns_b = |measure: Measure| measure.dependence().rotation;
        let turns_a = |measure: Measure| measure.turns_with_a();
        let said = Said {
            displacements: depends(|measure| measure.dependence().translation) && (any(0..3) || any(7..10)),
            rotations: [depends(turns_a) && any(3..6), depends(turns_b) && any(10..13)],
            flows: depends(|measure| measure.dependence().flow) && (active[6] || active[13]),
            hinges: false,
            turns: depends(turns_a) || depends(turns_b),
        };
        let at = states.iter().map(|state| {
            let (definition, pair) = read(definition, &state.pair, reading);
            Self::at(&definition, &State { pair, ..*state }, &lines, (axes, &blocks), length)
        });
        let at = at.collect::<Option<Vec<_>>>()?;
        Some(Self { lines, said, at })
    }

    fn at(
        definition: &Definition,
        state: &State<f64>,
        lines: &[Line],
        (axes, blocks): (Axes, &[usize]),
        length: f64,
    ) -> Option<Vec<Right1>> {
        let mut step = Step::between(&definition.initial, state.pair);
        (step.state.velocity, step.state.acceleration) = (state.velocity, state.acceleration);
        let name = definition.connection.name.to_string();
        let case = Case { name, definition: definition.clone(), start: None, path: vec![step], length };
        let right = Right::of(&case)?;
        let connector = case.connector();
        let turned = Turned::of(definition, state);
        let along = axes.out_of_a(&turned);
        let number = |of: Quantity, k: usize, i: usize| {
            let x = right.numbers.entries(of).get(k, i)?;
            Some(Number { x, off: right.bound.tolerance(of, k, i) })
        };
        // A component of a vector along other axes.
        let resolved = |of: Quantity, k: usize, i: usize| match blocks
            .iter()
            .find(|first| axes != Axes::A && (**first..**first + 3).contains(&k))
        {
            None => number(of, k, i),
            Some(first) => {
                let parts = [0, 1, 2].map(|m| number(of, first + m, i).unwrap_or_default());
                Some(times(&transpose(&along), parts)[k - first])
            }
        };
        let offsets = Positions::ALL.map(|positions| positions.offsets(definition, &connector));
        let found = lines.iter().map(|line| {
            let k = line.k;
            let value = resolved(Quantity::Value, k, 0);
            // d asin(c) = dc/√(1 − c²).
            let cosine = value.filter(|_| line.is_as_angle).map(|value| value.x.clamp(-1.0, 1.0));
            let slope = cosine.map_or(1.0, |c| 1.0 / (1.0 - c * c).sqrt());
            let scaled = |number: Number| Number { x: number.x * slope, off: number.off * slope };
            let entry = |j: usize| scaled(resolved(Quantity::FirstDerivatives, k, j).unwrap_or_default());
            let row = Row::of(&entry, [Number::default(); 2], &turned);
            let values = [0, 1, 2].map(|n| {
                let value = value?;
                let x = cosine.map_or(value.x, f64::asin);
                match n {
                    0 => Some(Number { x, off: scaled(value).off }),
                    _ => {
                        let more = offsets[n][k].filter(|_| cosine.is_none()).unwrap_or(0.0);
                        if axes != Axes::A {
                            return None;
                        }
                        Some(Number { x: x + more, off: value.off + ROUNDINGS * more.abs() })
                    }
                }
            });
            let rate = resolved(Quantity::Rate, k, 0).map(scaled);
            Right1 { row, values, rate }
        });
        Some(found.collect())
    }
}

/// The case as a routine sees it that reads orientations in its own way.
fn read_case(case: &MpcCase, reading: Reading) -> MpcCase {
    let mut case = case.clone();
    let read = |body: &mut Body<f64>| match reading {
        Reading::Right => {}
        Reading::Inverse | Reading::Transposed => body.rotation = transpose(&body.rotation),
        Reading::ScalarLast => {
            let mut quaternion = so3::quaternion(&body.rotation);
            quaternion.rotate_right(1);
            body.rotation = so3::matrix(quaternion);
        }
    };
    read(&mut case.state.slave);
    read(&mut case.state.master);
    case
}

impl Expected {
    /// Of a multi-point constraint, S in the place of a and M in that of b.
    pub(super) fn of_constraint(cases: &[MpcCase], reading: Reading, axes: Axes) -> Option<Self> {
        // Initial triads are the global axes: transposed triads are rotations backwards.
        if axes != Axes::A || reading == Reading::Transposed {
            return None;
        }
        let constraint = &cases.first()?.constraint;
        let rows = constraint.rows();
        let rows: Vec<usize> = (0..rows.len()).filter(|k| rows[*k]).collect();
        let lines =
            rows.iter().map(|k| Line { k: *k, is_as_angle: false, unit: MpcType::row_unit(*k) }).collect();
        let has = constraint.columns();
        let any = |of: std::ops::Range<usize>| has[of].contains(&true);
        let said = Said {
            displacements: any(0..3),
            rotations: [any(3..6), any(10..13)],
            flows: has[6] || has[13],
            hinges: any(PHI..DOFS),
            turns: any(3..6) || any(10..13),
        };
        let at = cases.iter().map(|case| Self::at_case(&read_case(case, reading), rows.len())).collect();
        Some(Self { lines, said, at })
    }

    fn at_case(case: &MpcCase, rows: usize) -> Vec<Right1> {
        let turned = Turned::of_bodies(&case.state);
        let tables = case.judged();
        let number = |quantity: Quantity, n: usize, j: usize| {
            let table = tables.iter().find(|table| table.quantity == quantity)?;
            let entry = table.entries.get(n * table.width() + j)?;
            Some(Number { x: entry.want.to_f64(), off: entry.tolerance() })
        };
        let found = (0..rows).map(|n| {
            let entry = |j: usize| number(Quantity::FirstDerivatives, n, j).unwrap_or_default();
            let row = Row::of(&entry, [entry(PHI), entry(PHI + 1)], &turned);
            let values = [number(Quantity::Value, n, 0), None, None];
            Right1 { row, values, rate: number(Quantity::Rate, n, 0) }
        });
        found.collect()
    }
}
