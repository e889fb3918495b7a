//! What the rules are given: a connector at a state, as a function of one vector of parameters.

use crate::rules::Jacobian;
use pintle_audit::case::moved;
use pintle_audit::{Case, Entries};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Branch, Connector, Increment, Output, Request, State, Tally};
use pintle_kinematics::node::{DOFS, Node, Pair};

/// A connector at a state: its values as a function of the nodal degrees of freedom that it has.
pub(crate) struct Subject {
    pub(crate) connector: Connector<f64>,
    branch: Branch<f64>,
    state: State<f64>,
    /// The degrees of freedom, and the components that have a row.
    pub(crate) columns: Vec<usize>,
    components: Vec<usize>,
}

impl Subject {
    pub(crate) fn of(case: &Case, rows: &Entries<f64>) -> Option<Self> {
        let connector = case.connector();
        let end = case.last()?;
        let branch = connector.advance(&end.state, &end.increment, &case.branch_before(&connector));
        let columns = (0..DOFS).filter(|j| connector.active()[*j]).collect();
        let components = (0..6).filter(|k| rows.0[*k].is_some()).collect();
        Some(Self { connector, branch, state: end.state, columns, components })
    }

    /// Displacements and flow as they are, rotations from the present triads on.
    pub(crate) fn parameters(&self) -> Vec<f64> {
        let Pair { a, b, .. } = &self.state.pair;
        let of = |node: &Node<f64>| {
            let [x, y, z] = node.displacement;
            [x, y, z, 0.0, 0.0, 0.0, node.flow]
        };
        let all = [of(a), of(b)].concat();
        self.columns.iter().map(|j| all[*j]).collect()
    }

    pub(crate) fn values(&self, parameters: &[f64]) -> Vec<f64> {
        let mut at = [0.0; DOFS];
        for (j, x) in self.columns.iter().zip(parameters) {
            at[*j] = *x;
        }
        let mut state = self.state;
        for node in [&mut state.pair.a, &mut state.pair.b] {
            node.displacement = [0.0; 3];
            node.flow = 0.0;
        }
        state.pair = moved(&state.pair, &at);
        let asked = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let found =
            self.connector.evaluate(&state, &Increment::none(), &self.branch, &asked, &mut Tally::default());
        let value = |k: &usize| found.residual[*k].or(found.displacement[*k]).unwrap_or(f64::NAN);
        self.components.iter().map(value).collect()
    }

    pub(crate) fn jacobian(&self, entry: impl Fn(usize, usize) -> Option<f64>) -> Jacobian {
        let row = |k: &usize| self.columns.iter().map(|j| entry(*k, *j).unwrap_or(0.0)).collect();
        self.components.iter().map(row).collect()
    }
}

/// Types whose components are functions: a one-form, whose row is given, has no values to be differenced.
pub(crate) fn functions() -> impl Iterator<Item = &'static ConnectionType> {
    TABLE.iter().filter(|connection| {
        let mut positions = connection.slots.iter().filter_map(|slot| slot.position());
        !positions.any(|measure| measure.is_one_form())
    })
}
