//! Four states at a time, as [`pintle_kinematics::batch`] takes them.

use crate::method::Prepared;
use crate::subject::{Element, Order, Subject};
use pintle_kinematics::batch::{Batch, COLUMNS, HessianRow, History, LANES, Row, Section, Tile};
use pintle_kinematics::node::DOFS;

/// The elements of a subject in tiles of four.
#[derive(Clone, Debug)]
pub struct Tiles {
    /// What is computed of them.
    pub batch: Batch,
    /// The nodes.
    pub tiles: Vec<Tile>,
    /// The connectors' data.
    pub sections: Vec<Section>,
    /// The histories.
    pub histories: Vec<History>,
}

impl Tiles {
    /// As many elements as [`Subject::batch`] says, or up to three more.
    ///
    /// # Errors
    /// Why there is no batch of them.
    pub fn new(subject: &Subject) -> Result<Self, &'static str> {
        let first = subject.elements.first().ok_or("there is no state")?;
        let wanted = std::array::from_fn(|k| subject.components.contains(&k));
        let batch = Batch::new(&first.connector, wanted)
            .map_err(|_| "a batch has no columns for material flow, on which a row depends")?;
        let all: Vec<&Element> = subject.elements.iter().cycle().take(count(subject)).collect();
        let (fours, _) = all.as_chunks::<LANES>();
        Ok(Self {
            tiles: fours.iter().map(|four| Tile::new(&four.map(|one| one.state.pair))).collect(),
            sections: fours.iter().map(|four| Section::new(&four.map(|one| &one.connector))).collect(),
            histories: fours.iter().map(|four| History::new(&four.map(|one| one.branch))).collect(),
            batch,
        })
    }
}

/// The elements that fill the tiles.
fn count(subject: &Subject) -> usize {
    subject.batch.next_multiple_of(LANES)
}

/// Room for the rows of tiles.
#[derive(Clone, Debug)]
pub enum Rows {
    /// With first derivatives.
    First(Vec<Row>),
    /// With second derivatives.
    Second(Vec<HessianRow>),
}

impl Rows {
    /// Room for the rows of a subject.
    ///
    /// # Errors
    /// There are no rows without derivatives.
    pub fn new(order: Order, subject: &Subject) -> Result<Self, &'static str> {
        let count = count(subject) / LANES * subject.rows();
        match order {
            Order::Value => Err("a batch computes values with their rows, not alone"),
            Order::Jacobian => Ok(Self::First(vec![Row::default(); count])),
            Order::Hessian => Ok(Self::Second(vec![HessianRow::default(); count])),
        }
    }

    /// The derivatives of the last order, state by state, row by row, of tiles with so many rows each, in the order of [`pintle_kinematics::node::DOF`].
    pub fn numbers(&self, rows: usize) -> Vec<f64> {
        match self {
            Self::First(found) => by_state(found, rows, |row, lane, all| {
                all.extend(spread(&row.columns.map(|four| four[lane])));
            }),
            Self::Second(found) => by_state(found, rows, |row, lane, all| {
                let lines = row.hessian.map(|line| spread(&line.map(|four| four[lane])));
                let mut matrix = [[0.0; DOFS]; DOFS];
                COLUMNS.iter().zip(lines).for_each(|(i, line)| matrix[*i] = line);
                all.extend(matrix.as_flattened());
            }),
        }
    }
}

/// The numbers of each row of each lane of tiles with so many rows.
fn by_state<R>(found: &[R], rows: usize, put: impl Fn(&R, usize, &mut Vec<f64>)) -> Vec<f64> {
    let mut all = Vec::new();
    for tile in found.chunks(rows.max(1)) {
        for lane in 0..LANES {
            tile.iter().for_each(|row| put(row, lane, &mut all));
        }
    }
    all
}

/// A row of twelve columns among all degrees of freedom.
fn spread(columns: &[f64; 12]) -> [f64; DOFS] {
    let mut row = [0.0; DOFS];
    COLUMNS.iter().zip(columns).for_each(|(j, x)| row[*j] = *x);
    row
}

/// Tiles and room for their rows, made before the clock starts; what is timed is [`Batch::rows_of`].
pub(super) struct Batched {
    tiles: Tiles,
    rows: Rows,
}

impl Batched {
    pub(super) fn new(order: Order, subject: &Subject) -> Result<Self, &'static str> {
        Ok(Self { rows: Rows::new(order, subject)?, tiles: Tiles::new(subject)? })
    }
}

impl Prepared for Batched {
    fn run(&mut self) {
        let Self { tiles: Tiles { batch, tiles, sections, histories }, rows } = self;
        let done = match rows {
            Rows::First(rows) => batch.rows_of(tiles, sections, histories, rows),
            Rows::Second(rows) => batch.rows_of(tiles, sections, histories, rows),
        };
        debug_assert_eq!(done, Ok(()), "the slices have been made for each other");
    }

    fn states(&self) -> usize {
        LANES * self.tiles.tiles.len()
    }

    fn numbers(&mut self) -> Vec<f64> {
        self.run();
        self.rows.numbers(self.tiles.batch.rows())
    }
}
