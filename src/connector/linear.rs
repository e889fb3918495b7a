//! Values and rows of one connector, and nothing else: what an element routine asks for at every iteration.

use super::derivatives::Seeds;
use super::{Branch, Components, Connector, Mask, NodalRow};
use crate::measure::{Measure, Shared};
use crate::node::{DOFS, Dependence, Pair};
use crate::scalar::{Differentiable, Real};

/// A value with its derivatives by the nodal degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Linear<R> {
    /// The component (0-based): u1, u2, u3, ur1, ur2, ur3.
    pub component: usize,
    /// The value of [`Connector::differentiated`], principal where it winds; of a one-form what it has accumulated.
    pub value: R,
    /// The derivatives, in the order of [`crate::node::DOF`].
    pub row: NodalRow<R>,
}

impl<R: Real> Default for Linear<R> {
    fn default() -> Self {
        Self { component: 0, value: R::integer(0), row: [R::integer(0); DOFS] }
    }
}

impl<R: Differentiable> Connector<R> {
    /// Values and rows of the components in `wanted` that there are, in their order, at the nodes `pair` on the sheets of `branch`, which
    /// must be that of the state ([`Connector::advance`]): of the residual of a constrained component, of the position of any
    /// other. They go to the front of `out`, whose rest stays as it is; gives their number.
    ///
    /// A third to a tenth of the time of [`Connector::evaluate`], for there is no history, no request and no output that may be
    /// absent; the numbers are the same. Offsets, turns and references are the caller's.
    ///
    /// ```
    /// use pintle::catalog::ConnectionType;
    /// use pintle::connector::{Connector, Definition, Linear};
    /// use pintle::node::{Node, Pair};
    /// use pintle::{so3, vector};
    ///
    /// let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
    /// let turned = |angle| Pair {
    ///     reference: [0.0; 3],
    ///     a: node(vector::identity()),
    ///     b: node(so3::matrix(so3::exp([angle, 0.0, 0.0]))),
    /// };
    /// let definition = Definition::new(ConnectionType::named("REVOLUTE", None)?, turned(0.0));
    /// let connector = Connector::<f64>::new(&definition);
    /// let mut rows = [Linear::default(); 6];
    /// let count = connector.linearize(&turned(0.3), &connector.initial_branch(), [true; 6], &mut rows);
    /// assert_eq!(count, 3);
    /// assert_eq!((rows[0].component, rows[0].value), (3, 0.3)); // ur1
    /// assert_eq!(rows[0].row[10..13], [1.0, 0.0, 0.0]); // ∂ur1/∂θb1, ∂ur1/∂θb2, ∂ur1/∂θb3
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn linearize(
        &self,
        pair: &Pair<R>,
        branch: &Branch<R>,
        wanted: Mask,
        out: &mut [Linear<R>; 6],
    ) -> usize {
        let history = branch.history();
        let mut measures = [Measure::Distance; 6];
        let (mut count, mut present) = (0, 0);
        for k in 0..6 {
            let (Some(row), true) = (&self.kind.rows[k], wanted[k]) else { continue };
            present |= row.seeds.bit();
            measures[count] = row.differentiated;
            out[count].component = k;
            count += 1;
        }
        let (measures, out) = (&measures[..count], &mut out[..count]);
        let from = (self, pair, &history);
        if present & Seeds::Translation.bit() != 0 {
            Seeds::Translation.linearize::<R, 3>(from, Measure::evaluate_position, measures, out);
        }
        if present & Seeds::Rotation.bit() != 0 {
            Seeds::Rotation.linearize::<R, 3>(from, Measure::evaluate, measures, out);
        }
        if present & Seeds::Motion.bit() != 0 {
            Seeds::Motion.linearize::<R, 6>(from, Measure::evaluate, measures, out);
        }
        if present & Seeds::All.bit() != 0 {
            Seeds::All.linearize::<R, 8>(from, Measure::evaluate, measures, out);
        }
        if present & Seeds::None.bit() != 0 {
            for (measure, out) in measures.iter().zip(out).filter(|(measure, _)| measure.is_one_form()) {
                out.value = branch.accumulated + branch.accumulated_rest;
                out.row = measure.one_form(&pair.a.triad, &self.kind.section);
                self.mask(*measure, &mut out.row);
            }
        }
        count
    }

    /// The values of [`Connector::linearize`] alone, by component.
    pub fn values(&self, pair: &Pair<R>, branch: &Branch<R>, wanted: Mask) -> Components<R> {
        let history = branch.history();
        let mut needed = Dependence::default();
        for (row, _) in self.kind.rows.iter().zip(wanted).filter(|(_, wanted)| *wanted) {
            if let Some(row) = row {
                needed = needed.or(row.differentiated.dependence());
            }
        }
        let relative = self.relative(pair, needed);
        let mut shared = Shared::new(&relative, &pair.a.triad, &self.kind.section, &history);
        let mut values = [None; 6];
        for (k, row) in self.kind.rows.iter().enumerate() {
            let (Some(row), true) = (row, wanted[k]) else { continue };
            values[k] = Some(match row.seeds {
                Seeds::None => branch.accumulated + branch.accumulated_rest,
                _ => row.differentiated.evaluate(&mut shared),
            });
        }
        values
    }
}
