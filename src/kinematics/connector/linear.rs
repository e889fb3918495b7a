//! Values and rows of one connector, and nothing else: what an element routine asks for at every iteration.
//!
//! Which measures there are is found once, when the connector is made. Each row belongs to a formula that is compiled for its
//! measures alone ([`crate::measure::formula`]). A call runs these one after another.

use crate::connector::{Branch, Components, Connector, Kind, Mask, NodalRow, Row};
use crate::measure::formula::{Formula, Pass, Task, alone, cover};
use crate::measure::{Measure, Shared};
use crate::node::{self, DOFS, Dependence, Pair, RelativeGradient};
use crate::scalar::{Duals, Real, Scalar, Seeded};

/// A value with its derivatives by the nodal degrees of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
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
        Self { component: 0, value: R::ZERO, row: [R::ZERO; DOFS] }
    }
}

impl<R: Duals> Connector<R> {
    pub(crate) fn linearize_any(
        &self,
        pair: &Pair<R>,
        branch: &Branch<R>,
        wanted: Mask,
        out: &mut [Linear<R>; 6],
    ) -> usize {
        let kind = &*self.kind;
        let Program { passes, components, count, left, .. } = &kind.program;
        if wanted == [true; 6] {
            for pass in passes {
                pass.dispatch(Rows { kind, pair, branch, slots: &pass.rows, components, out });
            }
            for (row, measure) in left {
                let out = &mut out[*row];
                out.component = components[*row];
                self.linearize_with_flow(pair, branch, *measure, out);
            }
            return *count;
        }
        self.linearize_some(pair, branch, wanted, out)
    }

    /// [`Connector::linearize`] of some of the components. Apart, so that all of them need no room for what this does.
    #[inline(never)]
    fn linearize_some(
        &self,
        pair: &Pair<R>,
        branch: &Branch<R>,
        wanted: Mask,
        out: &mut [Linear<R>; 6],
    ) -> usize {
        let kind = &*self.kind;
        let Program { passes, alone, components: all, count, left } = &kind.program;
        let (mut slots, components) = ([usize::MAX; 6], &mut [usize::MAX; 6]);
        let mut found = 0;
        for (row, component) in all.iter().enumerate().take(*count) {
            if wanted[*component] {
                slots[row] = found;
                components[found] = *component;
                found += 1;
            }
        }
        let slot = |row: usize| slots.get(row).copied().unwrap_or(usize::MAX);
        for pass in passes {
            let slots = pass.rows.map(slot);
            let is_whole = (0..3).all(|m| (slots[m] == usize::MAX) == (pass.rows[m] == usize::MAX));
            let mut together = slots;
            if !is_whole {
                // What is computed by itself as well costs nothing for the others.
                for m in 0..3 {
                    let Some(pass) = alone.get(pass.rows[m]).copied().flatten() else { continue };
                    together[m] = usize::MAX;
                    if slots[m] != usize::MAX {
                        let slots = &[slots[m], usize::MAX, usize::MAX];
                        pass.dispatch(Rows { kind, pair, branch, slots, components, out });
                    }
                }
            }
            if together != [usize::MAX; 3] {
                pass.dispatch(Rows { kind, pair, branch, slots: &together, components, out });
            }
        }
        for (row, measure) in left {
            let slot = slot(*row);
            if let Some(out) = out.get_mut(slot) {
                out.component = components[slot];
                self.linearize_with_flow(pair, branch, *measure, out);
            }
        }
        found
    }

    /// A row with columns of material flow.
    #[inline(never)]
    fn linearize_with_flow(&self, pair: &Pair<R>, branch: &Branch<R>, measure: Measure, out: &mut Linear<R>) {
        let section = &self.kind.section;
        if measure.is_one_form() {
            out.value = branch.accumulated + branch.accumulated_rest;
            out.row = measure.one_form(&pair.a.triad, section);
        } else {
            let history = branch.history();
            let relative = pair.seeded::<R::Gradient<8>, 8>(measure.dependence(), 0);
            let value = measure.evaluate(&mut Shared::new(&relative, &pair.a.triad, section, &history));
            let [g1, g2, g3, h1, h2, h3, psi_a, psi_b] = value.gradient();
            let gradient =
                RelativeGradient { translation: [g1, g2, g3], rotation: [h1, h2, h3], flow: [psi_a, psi_b] };
            out.value = value.real();
            out.row = pair.nodal_row(&gradient);
        }
        self.mask(measure, &mut out.row);
    }

    pub(crate) fn values_any(&self, pair: &Pair<R>, branch: &Branch<R>, wanted: Mask) -> Components<R> {
        if wanted == [true; 6] {
            return self.all_values(pair, branch);
        }
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
            values[k] = Some(if row.differentiated.is_one_form() {
                branch.accumulated + branch.accumulated_rest
            } else {
                row.differentiated.evaluate(&mut shared)
            });
        }
        values
    }

    /// The values of all components that there are.
    fn all_values(&self, pair: &Pair<R>, branch: &Branch<R>) -> Components<R> {
        let Kind { program, section, .. } = &*self.kind;
        let Program { passes, components, left, .. } = program;
        let mut values = [None; 6];
        let mut put = |row: usize, value: R| {
            if let Some(out) = components.get(row).and_then(|component| values.get_mut(*component)) {
                *out = Some(value);
            }
        };
        for pass in passes {
            pass.dispatch(Values { kind: &self.kind, pair, branch, rows: &pass.rows, put: &mut put });
        }
        for (row, measure) in left {
            if measure.is_one_form() {
                put(*row, branch.accumulated + branch.accumulated_rest);
            } else {
                let (relative, history) = (self.relative(pair, measure.dependence()), branch.history());
                put(*row, measure.evaluate(&mut Shared::new(&relative, &pair.a.triad, section, &history)));
            }
        }
        values
    }
}

/// How [`Connector::linearize`] goes about the rows of a connector.
#[derive(Clone, Debug)]
pub(super) struct Program {
    /// The formulas that compute the rows, in which those of all components are numbered.
    passes: Vec<Pass>,
    /// Of each row a formula that computes no other, where there is one.
    alone: [Option<Pass>; 6],
    /// The component of each row, and their number.
    components: [usize; 6],
    count: usize,
    /// The rows with columns of material flow.
    left: Vec<(usize, Measure)>,
}

impl Program {
    pub(super) fn new(rows: &Components<Row>) -> Self {
        let mut components = [usize::MAX; 6];
        let mut singles = [None; 6];
        let mut measures = Vec::new();
        for (k, row) in rows.iter().enumerate() {
            let Some(row) = row else { continue };
            let at = measures.len();
            components[at] = k;
            singles[at] = alone(row.differentiated, at);
            measures.push(row.differentiated);
        }
        let (passes, left) = cover(&measures);
        let left = left.into_iter().map(|row| (row, measures[row])).collect();
        Self { passes, alone: singles, components, count: measures.len(), left }
    }
}

/// The values of one formula, handed on with their rows.
struct Values<'a, R: Duals, P> {
    kind: &'a Kind<R>,
    pair: &'a Pair<R>,
    branch: &'a Branch<R>,
    rows: &'a [usize; 3],
    put: &'a mut P,
}

impl<R: Duals, P: FnMut(usize, R)> Task for Values<'_, R, P> {
    #[inline(always)]
    fn run<F: Formula<M>, const M: usize>(self) {
        let Self { kind, pair, branch, rows, put } = self;
        let values = evaluate::<F, R, M>(kind, pair, branch);
        rows.iter().zip(values).for_each(|(row, value)| put(*row, value));
    }
}

/// The values of a formula.
#[inline(never)]
fn evaluate<F: Formula<M>, R: Duals, const M: usize>(
    kind: &Kind<R>,
    pair: &Pair<R>,
    branch: &Branch<R>,
) -> [R; M] {
    let zero = [R::ZERO; 3];
    let relative = pair.varied(F::NEEDED, zero, zero, [R::ZERO; 2]);
    F::evaluate(&mut Shared::new(&relative, &pair.a.triad, &kind.section, &branch.history()))
}

/// The rows of one formula, to be written where the slots say.
struct Rows<'a, R: Duals> {
    kind: &'a Kind<R>,
    pair: &'a Pair<R>,
    branch: &'a Branch<R>,
    slots: &'a [usize; 3],
    /// The component of each slot.
    components: &'a [usize; 6],
    out: &'a mut [Linear<R>; 6],
}

impl<R: Duals> Task for Rows<'_, R> {
    #[inline(always)]
    fn run<F: Formula<M>, const M: usize>(self) {
        let Self { kind, pair, branch, slots, components, out } = self;
        // Constants, so that only one of these is compiled for each formula.
        if const { F::NEEDED.of_position() || F::NEEDED.of_rotation() } {
            differentiate::<F, R, M, 3>(kind, pair, branch, slots, components, out);
        } else {
            differentiate::<F, R, M, 6>(kind, pair, branch, slots, components, out);
        }
    }
}

/// The values and rows of a formula, by the N relative variations from number `first` on.
#[inline(never)]
fn differentiate<F: Formula<M>, R: Duals, const M: usize, const N: usize>(
    kind: &Kind<R>,
    pair: &Pair<R>,
    branch: &Branch<R>,
    slots: &[usize; 3],
    components: &[usize; 6],
    out: &mut [Linear<R>; 6],
) {
    // Iterators and `map` of arrays are calls across units of the crate, each as dear as a row.
    let first = if F::NEEDED.of_rotation() { 3 } else { 0 };
    let history = branch.history();
    let relative = pair.seeded::<R::Gradient<N>, N>(F::NEEDED, first);
    let mut shared = Shared::new(&relative, &pair.a.triad, &kind.section, &history);
    let values = F::evaluate(&mut shared);
    let separation = pair.separation();
    let zero = R::ZERO;
    let none = [zero; 3];
    for m in 0..M {
        let (Some(out), Some(component)) = (out.get_mut(slots[m]), components.get(slots[m])) else {
            continue;
        };
        out.component = *component;
        let gradient = values[m].gradient();
        let (mut g, mut h) = (none, none);
        for i in 0..3 {
            if first == 0 {
                g[i] = gradient[i];
            }
            if first + N == 6 {
                h[i] = gradient[i + 3 - first];
            }
        }
        // −g, g × D − h, ∂Ψ_a, g, h, ∂Ψ_b ([`Pair::nodal_row`]). A measure that no direction of a enters does not feel a turn.
        let (has_g, has_h) = (!F::NEEDED.of_rotation(), !F::NEEDED.of_position());
        let minus_g = if has_g { [-g[0], -g[1], -g[2]] } else { none };
        let turns = F::MEASURES[m].turns_with_a();
        let arm = node::arm((g, has_g && turns), (h, has_h && turns), separation);
        let ([a1, a2, a3], [r1, r2, r3], [g1, g2, g3], [h1, h2, h3]) = (minus_g, arm, g, h);
        out.value = values[m].real();
        out.row = [a1, a2, a3, r1, r2, r3, zero, g1, g2, g3, h1, h2, h3, zero];
        if !kind.is_free {
            for j in 0..DOFS {
                if !kind.active[j] {
                    out.row[j] = zero;
                }
            }
        }
    }
}
