//! Rows in the few numbers that they are made of, for assembly.

use crate::connector::{Branch, Connector, Differentiation, Mask, State, Tally};
use crate::measure::Measure;
use crate::node::{DOFS, PSI_A, PSI_B, RelativeGradient, THETA_A, THETA_B, XA, XB};
use crate::scalar::{Duals, Real};
use crate::vector::Vector;

/// A row of nodal first derivatives as the parts it is made of. They are g and h, the derivatives by the relative translation and
/// rotation, the arm `g × D − h` with `D = x_b − x_a`, and the derivatives by the flows. All components are global.
///
/// The row is [−g, arm, ∂Ψ_a, g, h, ∂Ψ_b], in the order of [`crate::node::DOF`].
#[derive(Clone, Copy, Debug)]
pub struct CompactRow<R> {
    gradient: RelativeGradient<R>,
    arm: Vector<R>,
}

/// A group of degrees of freedom of one end that are the components of one vector, or material flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// x of node a: −g.
    TranslationA,
    /// θ of node a: g × D − h.
    RotationA,
    /// x of node b: g.
    TranslationB,
    /// θ of node b: h.
    RotationB,
}

impl<R: Real> CompactRow<R> {
    /// The derivatives by one group of three degrees of freedom, global components.
    #[inline]
    pub fn group(&self, group: Group) -> Vector<R> {
        match group {
            Group::TranslationA => self.gradient.translation.map(|g| -g),
            Group::RotationA => self.arm,
            Group::TranslationB => self.gradient.translation,
            Group::RotationB => self.gradient.rotation,
        }
    }

    /// The derivatives by Ψ_a and Ψ_b.
    pub const fn flow(&self) -> [R; 2] {
        self.gradient.flow
    }
}

impl CompactRow<f64> {
    /// Of the derivatives by θ_a, x_b and θ_b, without material flow.
    pub(crate) const fn new(turning_a: Vector<f64>, moving_b: Vector<f64>, turning_b: Vector<f64>) -> Self {
        let gradient = RelativeGradient { translation: moving_b, rotation: turning_b, flow: [0.0; 2] };
        Self { gradient, arm: turning_a }
    }

    /// Whether all its parts are finite.
    pub fn is_finite(&self) -> bool {
        let RelativeGradient { translation, rotation, flow } = &self.gradient;
        [&translation[..], rotation, &self.arm, flow].into_iter().flatten().all(|part| part.is_finite())
    }
}

impl<R: Duals> Connector<R> {
    pub(crate) fn compact_rows_any(
        &self,
        state: &State<R>,
        branch: &Branch<R>,
        wanted: Mask,
        tally: &mut Tally,
    ) -> [Option<CompactRow<R>>; 6] {
        let history = branch.history();
        let mut measures = [(0, Measure::Distance); 6];
        let mut count = 0;
        for k in (0..6).filter(|k| wanted[*k]) {
            let Some(row) = &self.kind.rows[k] else { continue };
            measures[count] = (k, row.differentiated);
            count += 1;
        }
        let measures = &measures[..count];
        let mut rows = [None; 6];
        let input = Differentiation { state, history: &history, active: &self.kind.active, second: false };
        self.relative_derivatives(&input, measures, tally, &mut |(k, _), gradient, _| {
            rows[k] = Some(CompactRow { arm: state.pair.arm(gradient), gradient: *gradient });
        });
        for (k, measure) in measures.iter().filter(|(_, measure)| measure.is_one_form()) {
            tally.gradients += 1;
            let form = measure.one_form(&state.pair.a.triad, &self.kind.section);
            let part = |at: usize| [form[at], form[at + 1], form[at + 2]];
            rows[*k] = Some(CompactRow {
                gradient: RelativeGradient {
                    translation: part(XB),
                    rotation: part(THETA_B),
                    flow: [form[PSI_A], form[PSI_B]],
                },
                arm: part(THETA_A),
            });
        }
        rows
    }

    /// Whether the row of component k (0-based) depends on what the history decides: the sheet of a rotation vector or of Euler angles,
    /// or the turns of torsion.
    pub fn row_has_history(&self, k: usize) -> bool {
        self.kind.rows[k].is_some_and(|row| {
            let measure = row.differentiated;
            measure.counts_torsion()
                || matches!(
                    measure,
                    Measure::RotationVector(_) | Measure::RotationVectorAtB(_) | Measure::Euler(_)
                )
        })
    }

    /// The degrees of freedom by which the row of component k (0-based) can be other than zero: those that the connector has and that
    /// the measure depends on. There are none (`None`) where there is no such component.
    pub fn row_pattern(&self, k: usize) -> Option<[bool; DOFS]> {
        let measure = self.kind.rows[k].as_ref()?.differentiated;
        let dependence = measure.dependence();
        let mut pattern = self.kind.active;
        let mut keep = |from: usize, to: usize, is_kept: bool| {
            for active in &mut pattern[from..to] {
                *active &= is_kept;
            }
        };
        keep(XA, THETA_A, dependence.translation);
        keep(THETA_A, PSI_A, measure.turns_with_a() && (dependence.translation || dependence.rotation));
        keep(PSI_A, XB, dependence.flow);
        keep(XB, THETA_B, dependence.translation);
        keep(THETA_B, PSI_B, dependence.rotation);
        keep(PSI_B, DOFS, dependence.flow);
        Some(pattern)
    }
}
