//! Rows of first and second derivatives, and rates: the same measures on numbers with derivatives.

use crate::connector::{
    Branch, Components, Connector, Evaluation, Linear, NodalMatrix, NodalRow, Output, Pass, Row, State, Tally,
};
use crate::measure::{History, Measure, Section, Shared};
use crate::node;
use crate::node::{DOFS, Dependence, NodalRates, Pair, Relative, RelativeGradient, RelativeRates};
use crate::scalar::{Duals, Scalar, Seeded};
use crate::vector;
use crate::vector::{Vector, column};
use num_dual::{Dual, DualSVec, HyperDual};

impl<R: Duals> Connector<R> {
    pub(super) fn rates(&self, pass: &Pass<'_, R>, tally: &mut Tally, evaluation: &mut Evaluation<R>) {
        let Pass { state, history, request, .. } = *pass;
        let of_position = |k: usize| request.wants_any([Output::CV, Output::CA], k);
        let of_residual = |k: usize, row: &Row| {
            request.wants_any([Output::RESV, Output::RESA], k) && row.slot.is_constrained()
        };
        let bias = |k: usize, row: &Row| request.wants(Output::RESB, k) && row.slot.is_constrained();
        let mut measures = Vec::new();
        let mut bias_measures = Vec::new();
        for (k, row) in pass.rows() {
            if of_position(k) {
                measures.push(row.position);
            }
            if of_residual(k, row) && !measures.contains(&row.differentiated) {
                measures.push(row.differentiated);
            }
            if bias(k, row) {
                bias_measures.push(row.differentiated);
            }
        }
        if !measures.is_empty() {
            let mut along = Along::new(self, state, &state.acceleration, history, measures);
            for (k, row) in pass.rows() {
                if of_position(k) {
                    let [velocity, acceleration] = along.rates(row.position, tally);
                    evaluation.velocity[k] = request.wants(Output::CV, k).then_some(velocity);
                    evaluation.acceleration[k] = request.wants(Output::CA, k).then_some(acceleration);
                }
                if of_residual(k, row) {
                    let [velocity, acceleration] = along.rates(row.differentiated, tally);
                    evaluation.residual_rate[k] = request.wants(Output::RESV, k).then_some(velocity);
                    evaluation.residual_acceleration[k] =
                        request.wants(Output::RESA, k).then_some(acceleration);
                }
            }
        }
        if !bias_measures.is_empty() {
            let still = [R::ZERO; DOFS];
            let mut along = Along::new(self, state, &still, history, bias_measures);
            for (k, row) in pass.rows().filter(|(k, row)| bias(*k, row)) {
                evaluation.residual_bias[k] = Some(along.rates(row.differentiated, tally)[1]);
            }
        }
    }

    pub(super) fn rows_of_derivatives(
        &self,
        pass: &Pass<'_, R>,
        tally: &mut Tally,
        evaluation: &mut Evaluation<R>,
    ) {
        let Pass { state, history, chosen, request, .. } = *pass;
        if const { R::HAS_COMPILED_FORMULAS } && request.order == 1 {
            let mut rows = [Linear::default(); 6];
            let count = self.linearize_any(&state.pair, &evaluation.branch, chosen, &mut rows);
            tally.gradients += count as u64;
            for Linear { component, row, .. } in rows.iter().take(count) {
                evaluation.jacobian[*component] = Some(*row);
            }
            return;
        }
        let measures: Vec<(usize, Measure)> = pass.rows().map(|(k, row)| (k, row.differentiated)).collect();
        let input = Differentiation { state, history, active: &self.kind.active, second: request.order > 1 };
        self.differentiate(&input, &measures, tally, &mut |k, row, hessian| {
            evaluation.jacobian[k] = Some(row);
            evaluation.hessian[k] = hessian;
        });
    }

    /// The nodal derivatives of measures, handed on by number.
    pub(crate) fn differentiate(
        &self,
        input: &Differentiation<'_, R>,
        measures: &[(usize, Measure)],
        tally: &mut Tally,
        take: &mut dyn FnMut(usize, NodalRow<R>, Option<NodalMatrix<R>>),
    ) {
        let Differentiation { state, active, .. } = *input;
        let mut nodal = |(k, measure): (usize, Measure),
                         gradient: &RelativeGradient<R>,
                         relative: Option<&[[R; 8]; 8]>| {
            // A measure that no direction of a enters does not feel a turn.
            let mut active = *active;
            if !measure.turns_with_a() {
                active[node::THETA_A..node::PSI_A].fill(false);
            }
            let mut row = state.pair.nodal_row(gradient);
            for (entry, active) in row.iter_mut().zip(&active) {
                if !active {
                    *entry = R::ZERO;
                }
            }
            let hessian = |relative| Box::new(state.pair.nodal_hessian(gradient, relative, &active));
            take(k, row, relative.map(hessian));
        };
        self.relative_derivatives(input, measures, tally, &mut nodal);
        for (k, measure) in measures.iter().filter(|(_, measure)| measure.is_one_form()) {
            let (row, hessian) = self.one_form_row(input, *measure, tally);
            take(*k, row, hessian);
        }
    }

    /// The derivatives by the relative variations of measures, but for one-forms, handed on with their numbers.
    pub(super) fn relative_derivatives(
        &self,
        input: &Differentiation<'_, R>,
        measures: &[(usize, Measure)],
        tally: &mut Tally,
        take: &mut Take<'_, R>,
    ) {
        let Differentiation { state, history, second, .. } = *input;
        let from = (self, state, history);
        if second {
            Seeds::Translation.pass::<R, R::Hessian<3>, 3>(from, measures, take);
            Seeds::Rotation.pass::<R, R::Hessian<3>, 3>(from, measures, take);
            Seeds::Motion.pass::<R, R::Hessian<6>, 6>(from, measures, take);
            Seeds::All.pass::<R, R::Hessian<8>, 8>(from, measures, take);
        } else {
            Seeds::Translation.pass::<R, R::Gradient<3>, 3>(from, measures, take);
            Seeds::Rotation.pass::<R, R::Gradient<3>, 3>(from, measures, take);
            Seeds::Motion.pass::<R, R::Gradient<6>, 6>(from, measures, take);
            Seeds::All.pass::<R, R::Gradient<8>, 8>(from, measures, take);
        }
        let functions = measures.iter().filter(|(_, measure)| !measure.is_one_form()).count() as u64;
        if second {
            tally.hessians += functions;
        } else {
            tally.gradients += functions;
        }
    }

    /// Makes zero what a row of a measure has for degrees of freedom that are not active, or do not matter to it.
    #[inline(always)]
    pub(super) fn mask(&self, measure: Measure, row: &mut NodalRow<R>) {
        // A measure that no direction of a enters does not feel a turn.
        if !measure.turns_with_a() {
            row[node::THETA_A..node::PSI_A].fill(R::ZERO);
        }
        if self.kind.is_free && !measure.dependence().flow {
            return;
        }
        for (entry, active) in row.iter_mut().zip(&self.kind.active) {
            if !active {
                *entry = R::ZERO;
            }
        }
    }

    /// The row of a one-form and, for second derivatives, how the row changes as its carrier turns.
    fn one_form_row(
        &self,
        input: &Differentiation<'_, R>,
        measure: Measure,
        tally: &mut Tally,
    ) -> (NodalRow<R>, Option<NodalMatrix<R>>) {
        let Differentiation { state, active, second, .. } = *input;
        let zero = R::ZERO;
        let masked = |j: usize, value: R| if active[j] { value } else { zero };
        let mut row = measure.one_form(&state.pair.a.triad, &self.kind.section);
        for (j, entry) in row.iter_mut().enumerate() {
            *entry = masked(j, *entry);
        }
        tally.gradients += 1;
        if !second {
            return (row, None);
        }
        tally.hessians += 1;
        let seed = |i: usize| R::Gradient::<3>::seed(zero, i);
        let turning = turned_triad(&state.pair.a.triad, [seed(0), seed(1), seed(2)]);
        let form = measure.one_form(&turning, &self.kind.section);
        let mut hessian = Box::new([[zero; DOFS]; DOFS]);
        for (j, entry) in form.iter().enumerate() {
            for (i, derivative) in entry.gradient().into_iter().enumerate() {
                let carrier = node::THETA_A + i;
                if active[carrier] {
                    hessian[j][carrier] = masked(j, derivative);
                }
            }
        }
        (row, Some(hessian))
    }
}

/// Where measures are differentiated, and by which degrees of freedom.
#[derive(Clone, Copy)]
pub(crate) struct Differentiation<'a, R: Duals> {
    pub(crate) state: &'a State<R>,
    pub(crate) history: &'a History<R>,
    pub(crate) active: &'a [bool; DOFS],
    pub(crate) second: bool,
}

/// The triad after a first-order rotation θ: e + θ × e, exact for first derivatives.
fn turned_triad<S: Scalar>(triad: &vector::Matrix<S::Real>, theta: Vector<S>) -> vector::Matrix<S> {
    let mut turned = [[S::zero(); 3]; 3];
    for j in 0..3 {
        let direction = column(triad, j);
        let change = vector::cross_real(theta, direction);
        for i in 0..3 {
            turned[i][j] = S::from_real(direction[i]) + change[i];
        }
    }
    turned
}

/// What takes the relative derivatives of a measure, with its number: the first, and the second where they are wanted.
type Take<'a, R> = dyn FnMut((usize, Measure), &RelativeGradient<R>, Option<&[[R; 8]; 8]>) + 'a;

/// Which relative variations carry derivatives: those that a measure depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seeds {
    Translation,
    Rotation,
    Motion,
    All,
    None,
}

impl Seeds {
    #[inline(always)]
    pub(super) fn of(measure: Measure) -> Self {
        if measure.is_one_form() {
            return Self::None;
        }
        match measure.dependence() {
            Dependence { translation: true, rotation: false, flow: false } => Self::Translation,
            Dependence { translation: false, rotation: true, flow: false } => Self::Rotation,
            Dependence { translation: true, rotation: true, flow: false } => Self::Motion,
            _ => Self::All,
        }
    }

    /// The first of the variations, in the order δ, ρ, Ψ_a, Ψ_b, and what they vary.
    #[inline(always)]
    const fn span(self) -> (usize, Dependence) {
        let (first, translation, rotation, flow) = match self {
            Self::Translation => (0, true, false, false),
            Self::Rotation => (3, false, true, false),
            Self::Motion => (0, true, true, false),
            Self::All | Self::None => (0, true, true, true),
        };
        (first, Dependence { translation, rotation, flow })
    }

    /// Evaluates those measures that depend on just these variations, on numbers with derivatives along them, and hands on their
    /// relative derivatives.
    fn pass<R: Duals, S: Seeded<N, Real = R>, const N: usize>(
        self,
        (connector, state, history): (&Connector<R>, &State<R>, &History<R>),
        measures: &[(usize, Measure)],
        take: &mut Take<'_, R>,
    ) {
        let mut own = measures.iter().filter(|(_, measure)| Self::of(*measure) == self).peekable();
        if own.peek().is_none() {
            return;
        }
        let (first, needed) = self.span();
        let zero = R::ZERO;
        let relative = state.pair.seeded::<S, N>(needed, first);
        let mut shared = Shared::new(&relative, &state.pair.a.triad, &connector.kind.section, history);
        for (k, measure) in own {
            let value = measure.evaluate(&mut shared);
            let mut gradient = [zero; 8];
            gradient[first..first + N].copy_from_slice(&value.gradient());
            let [g1, g2, g3, h1, h2, h3, psi_a, psi_b] = gradient;
            let gradient =
                RelativeGradient { translation: [g1, g2, g3], rotation: [h1, h2, h3], flow: [psi_a, psi_b] };
            if const { S::ORDER < 2 } {
                take((*k, *measure), &gradient, None);
                continue;
            }
            let mut hessian = [[zero; 8]; 8];
            for (i, line) in value.hessian().into_iter().enumerate() {
                hessian[first + i][first..first + N].copy_from_slice(&line);
            }
            take((*k, *measure), &gradient, Some(&hessian));
        }
    }
}

/// A state that moves: measures evaluated on numbers with two time derivatives.
struct Along<'a, R: Duals> {
    connector: &'a Connector<R>,
    state: &'a State<R>,
    acceleration: &'a NodalRates<R>,
    history: &'a History<R>,
    relative: Relative<R::Time>,
    /// The rotation vector and misalignment are shared between components by evaluating all of them once.
    cache: Vec<(Measure, [R; 2])>,
    measures: Vec<Measure>,
}

impl<'a, R: Duals> Along<'a, R> {
    fn new(
        connector: &'a Connector<R>,
        state: &'a State<R>,
        acceleration: &'a NodalRates<R>,
        history: &'a History<R>,
        measures: Vec<Measure>,
    ) -> Self {
        let needed = measures
            .iter()
            .filter(|m| !m.is_one_form() && !m.has_nodal_rates())
            .fold(Dependence::default(), |sum, m| sum.or(m.dependence()));
        let mut rates = state.pair.relative_rates(&state.velocity, acceleration);
        if !measures.iter().any(|m| m.dependence().translation && m.turns_with_a()) {
            let linear = |rates: &NodalRates<R>| [0, 1, 2].map(|i| rates[node::XB + i] - rates[node::XA + i]);
            rates.translation = [linear(&state.velocity), linear(acceleration)];
        }
        let relative = moving(&state.pair, &rates, needed);
        Along { connector, state, acceleration, history, relative, cache: Vec::new(), measures }
    }

    /// (velocity, acceleration) of a measure.
    pub(super) fn rates(&mut self, measure: Measure, tally: &mut Tally) -> [R; 2] {
        if self.cache.is_empty() {
            let state = self.state;
            let section = &self.connector.kind.section;
            let mut shared = Shared::new(&self.relative, &state.pair.a.triad, section, self.history);
            for measure in &self.measures {
                tally.rates += 1;
                let nodal = measure.nodal_rates(&state.pair, &state.velocity, self.acceleration);
                let rates = nodal.unwrap_or_else(|| {
                    if measure.is_one_form() {
                        one_form_rates(*measure, state, self.acceleration, section)
                    } else {
                        let (first, second) = R::rates(measure.evaluate(&mut shared));
                        [first, second]
                    }
                });
                self.cache.push((*measure, rates));
            }
        }
        let found = self.cache.iter().find(|(known, _)| *known == measure);
        found.map_or([R::ZERO; 2], |(_, rates)| *rates)
    }
}

/// The relative pair along time.
fn moving<R: Duals>(pair: &Pair<R>, rates: &RelativeRates<R>, needed: Dependence) -> Relative<R::Time> {
    let zero = R::ZERO;
    let vector = |of: [[R; 3]; 2]| [0, 1, 2].map(|i| R::moving(zero, of[0][i], of[1][i]));
    let flow = [0, 1].map(|i| R::moving(zero, rates.flow[0][i], rates.flow[1][i]));
    pair.varied(needed, vector(rates.translation), vector(rates.rotation), flow)
}

/// The rate of a one-form, row·q̇, and its time derivative, row·q̈ + (row)˙·q̇.
fn one_form_rates<R: Duals>(
    measure: Measure,
    state: &State<R>,
    acceleration: &NodalRates<R>,
    section: &Section<R>,
) -> [R; 2] {
    let zero = R::ZERO;
    let spin = node::spin_of_a(&state.velocity);
    let turning = turned_triad(&state.pair.a.triad, spin.map(|rate| R::moving(zero, rate, zero)));
    let mut rates = [zero; 2];
    for (j, entry) in measure.one_form(&turning, section).into_iter().enumerate() {
        let (change, _) = R::rates(entry);
        rates[0] = rates[0] + entry.real() * state.velocity[j];
        rates[1] = rates[1] + entry.real() * acceleration[j] + change * state.velocity[j];
    }
    rates
}

impl Connector<f64> {
    /// First derivatives by dual numbers in the fourteen nodal degrees of freedom: [`Pair::moved`] instead of the relative pair
    /// and the nodal maps. About 25 times slower than rows; a witness for them.
    pub fn nodal_rows(&self, state: &State<f64>, branch: &Branch<f64>) -> Components<NodalRow<f64>> {
        type Nodal = DualSVec<f64, DOFS>;
        let seeds: [Nodal; DOFS] = std::array::from_fn(|j| Seeded::<DOFS>::seed(0.0, j));
        let values = self.on_moved_nodes(state, branch, &seeds);
        std::array::from_fn(|k| {
            let row = self.kind.rows[k]?;
            if row.differentiated.is_one_form() {
                return Some(
                    self.active_only(row.differentiated.one_form(&state.pair.a.triad, &self.kind.section)),
                );
            }
            Some(self.active_only(values[k]?.gradient()))
        })
    }

    /// Σ_jk v_j w_k ∂²f/∂q_j∂q_k by hyper-dual numbers in the nodal degrees of freedom; `None` for a one-form.
    pub fn nodal_second(
        &self,
        state: &State<f64>,
        branch: &Branch<f64>,
        v: &NodalRow<f64>,
        w: &NodalRow<f64>,
    ) -> Components<f64> {
        let (v, w) = (self.active_only(*v), self.active_only(*w));
        let seeds: [HyperDual<f64>; DOFS] = std::array::from_fn(|j| HyperDual::new(0.0, v[j], w[j], 0.0));
        let values = self.on_moved_nodes(state, branch, &seeds);
        std::array::from_fn(|k| {
            values[k]
                .filter(|_| !self.kind.rows[k].is_some_and(|r| r.differentiated.is_one_form()))
                .map(|x| x.eps1eps2)
        })
    }

    /// First and second derivatives by nesting first-order dual numbers in the fourteen nodal degrees of freedom: no dual number of
    /// second order, no nodal map. Of a one-form its row, and how it changes.
    pub fn nested(
        &self,
        state: &State<f64>,
        branch: &Branch<f64>,
    ) -> Components<(NodalRow<f64>, NodalMatrix<f64>)> {
        type Inner = DualSVec<f64, DOFS>;
        let mut found = self.kind.rows.map(|row| row.map(|_| ([0.0; DOFS], Box::new([[0.0; DOFS]; DOFS]))));
        for j in (0..DOFS).filter(|j| self.kind.active[*j]) {
            let seeds: [Dual<Inner>; DOFS] = std::array::from_fn(|i| {
                let outer = if i == j { Inner::one() } else { Inner::zero() };
                Dual::new(<Inner as Seeded<DOFS>>::seed(0.0, i), outer)
            });
            let values = self.on_moved_nodes(state, branch, &seeds);
            for (k, found) in found.iter_mut().enumerate() {
                let (Some((first, second)), Some(row), Some(value)) = (found, self.kind.rows[k], values[k])
                else {
                    continue;
                };
                if row.differentiated.is_one_form() {
                    let triad = state.pair.moved(&seeds).a.triad;
                    let form = row.differentiated.one_form(&triad, &self.kind.section);
                    *first = self.active_only(form.map(Scalar::real));
                    let change = self.active_only(form.map(|entry| entry.eps.real()));
                    for (line, entry) in second.iter_mut().zip(change) {
                        line[j] = entry;
                    }
                } else {
                    *first = self.active_only(value.re.gradient());
                    second[j] = self.active_only(value.eps.gradient());
                }
            }
        }
        found
    }

    fn on_moved_nodes<S: Scalar<Real = f64>>(
        &self,
        state: &State<f64>,
        branch: &Branch<f64>,
        dofs: &[S; DOFS],
    ) -> Components<S> {
        self.on_nodes(&state.pair.moved(dofs), &state.pair.a.triad, branch)
    }

    /// What is differentiated, as a function of the nodes, on any number; `triad_a` is the real part of the triad of a.
    pub(crate) fn on_nodes<S: Scalar<Real = f64>>(
        &self,
        pair: &Pair<S>,
        triad_a: &vector::Matrix<f64>,
        branch: &Branch<f64>,
    ) -> Components<S> {
        let relative = pair.relative();
        let history = branch.history();
        let mut shared = Shared::new(&relative, triad_a, &self.kind.section, &history);
        std::array::from_fn(|k| self.kind.rows[k].map(|row| row.differentiated.evaluate(&mut shared)))
    }

    fn active_only(&self, mut row: NodalRow<f64>) -> NodalRow<f64> {
        for (entry, active) in row.iter_mut().zip(&self.kind.active) {
            if !active {
                *entry = 0.0;
            }
        }
        row
    }
}
