//! The layouts that users have: arrays of states in C order, dense rows out.

use pintle_bench::{Cause, Method, Order, Prepared, Subject, Tiles};
use pintle_kinematics::batch::{Array, Columns, Nodes, Orientation, States, vector_unit};
use std::hint::black_box;

/// `Batch::rows_of_states` by triads, in as many states as a batch has, into rows of 14 columns that the tables compare.
pub(crate) struct ByArrays;

struct Given {
    tiles: Tiles,
    count: usize,
    reference: Vec<f64>,
    displacement: [Vec<f64>; 2],
    triad: [Vec<f64>; 2],
    values: Vec<f64>,
    rows: Vec<f64>,
}

impl Method for ByArrays {
    fn name(&self) -> &'static str {
        "pintle, arrays"
    }

    fn order(&self) -> Order {
        Order::Jacobian
    }

    fn vector_unit(&self) -> Option<&'static str> {
        vector_unit()
    }

    fn cause(&self) -> Cause {
        Cause::Rounding
    }

    fn prepare<'s>(&self, subject: &'s Subject) -> Result<Box<dyn Prepared + 's>, &'static str> {
        let tiles = Tiles::new(subject)?;
        let pairs: Vec<_> =
            tiles.tiles.iter().flat_map(|tile| [0, 1, 2, 3].map(|lane| tile.lane(lane))).collect();
        let nodes = |end: usize| pairs.iter().map(move |pair| [&pair.a, &pair.b][end]);
        let (count, each) = (pairs.len(), tiles.batch.rows());
        Ok(Box::new(Given {
            count,
            reference: pairs.iter().flat_map(|pair| pair.reference).collect(),
            displacement: [0, 1].map(|end| nodes(end).flat_map(|node| node.displacement).collect()),
            triad: [0, 1].map(|end| nodes(end).flat_map(|node| node.triad.concat()).collect()),
            values: vec![0.0; count * each],
            rows: vec![0.0; count * tiles.batch.width(Columns::Fourteen)],
            tiles,
        }))
    }
}

impl Prepared for Given {
    fn run(&mut self) {
        let node = |end: usize| Nodes {
            displacement: Array::new(&self.displacement[end], 3),
            orientation: Orientation::Triad(Array::new(&self.triad[end], 9)),
        };
        let states = States {
            count: self.count,
            reference: Array::new(&self.reference, 3),
            nodes: [node(0), node(1)],
            sections: &self.tiles.sections,
            histories: &self.tiles.histories,
        };
        let rows = black_box(&mut self.rows);
        self.tiles.batch.rows_of_states(&states, Columns::Fourteen, &mut self.values, rows).unwrap();
    }

    fn states(&self) -> usize {
        self.count
    }

    fn numbers(&mut self) -> Vec<f64> {
        self.run();
        self.rows.clone()
    }
}
