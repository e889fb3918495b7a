//! One connector: positions, displacements, rates, residuals, rows, second derivatives, and what its history decides.
//!
//! A [`Connector`] is a connection type with its section data and initial state. It is evaluated at a [`State`] with the
//! [`Branch`] that the previous states left (turn counts, the sheet of the rotation vector, accumulated one-forms), computes
//! what a [`Request`] names and nothing else, and gives back the branch to commit. A branch is committed by keeping it:
//! [`Connector::advance`] never changes the one it starts from.

mod flags;
mod request;

pub(crate) use flags::{CERTAIN_INCREMENT, ILL_CONDITIONED};
pub use flags::{Flag, Stop, StopStatus};
pub use request::{Mask, Output, Request, Tally};

use crate::catalog::{Condition, ConnectionType, Slot};
use crate::measure::{History, Measure, Section, Shared, Unit};
use crate::node::{
    self, DOF_NUMBER, DOFS, Dependence, End, NodalRates, Pair, Relative, RelativeGradient, RelativeRates,
};
use crate::scalar::{Differentiable, Real, Scalar, Seeded};
use crate::so3;
use crate::vector::{self, Vector, add, column, dot, scale, sub};
use serde::{Deserialize, Serialize};

/// A value for each of u1, u2, u3, ur1, ur2, ur3; `None` where the component is absent or was not asked for.
pub type Components<T> = [Option<T>; 6];

/// A row of nodal derivatives, in the order of [`node::DOF`].
pub type NodalRow<R> = [R; DOFS];

/// An angle as whole turns and a principal part: principal + 2π turns. Exact at any number of turns.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Turns<R> {
    /// The number of whole turns, an integer.
    pub turns: R,
    /// The principal angle in (−π, π] (rad).
    pub principal: R,
}

/// What the states up to now decide about the next: committed once per state.
///
/// A `Branch<f64>` survives serialization bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Branch<R> {
    /// Turn counts of the components that wind; zero for the others.
    pub turns: [Turns<R>; 6],
    /// The last well-conditioned rotation vector of b's directions relative to a's, components along e_i^a (rad).
    pub rotation_vector: [R; 3],
    /// The sign of sin β on the sheet of the Euler angles: ±1.
    pub euler_sign: R,
    /// The torsion between the third directions, with its turns, where the directions midway between a and b depend on it.
    pub torsion: Turns<R>,
    /// What a one-form has accumulated (rad).
    pub accumulated: R,
    /// What the roundings of that sum left out, so that thousands of turns lose nothing: the value is the sum of the two.
    pub accumulated_rest: R,
}

/// What a state does to the nodes since the previous one: increments along which one-forms accumulate and turns are counted.
#[derive(Clone, Copy, Debug)]
pub struct Increment<R> {
    /// Δθ of a and b, rotation vectors with C(new) = exp(Δθ^) C(old), whole turns included; global components (rad).
    pub rotation: [Vector<R>; 2],
    /// The whole turns in them: Δθ minus its principal part (rad).
    pub whole_turns: [Vector<R>; 2],
    /// ΔΨ of a and b (length).
    pub flow: [R; 2],
}

impl<R: Real> Increment<R> {
    /// No change.
    pub fn none() -> Self {
        let zero = [R::integer(0); 3];
        Self { rotation: [zero; 2], whole_turns: [zero; 2], flow: [R::integer(0); 2] }
    }
}

/// The nodes at one instant, with their rates.
#[derive(Clone, Copy, Debug)]
pub struct State<R: Real> {
    /// Displacements, triads, flows.
    pub pair: Pair<R>,
    /// v, ω, Ψ̇ of both nodes.
    pub velocity: NodalRates<R>,
    /// a, α, Ψ̈ of both nodes.
    pub acceleration: NodalRates<R>,
}

/// Everything that defines a connector.
#[derive(Clone, Debug)]
pub struct Definition {
    /// The connection type.
    pub connection: ConnectionType,
    /// The initial state.
    pub initial: Pair<f64>,
    /// β_s of FLOW-CONVERTER (rad/length).
    pub flow_scale: f64,
    /// The space-fixed direction of an AXIAL whose nodes coincide (Standard); zero where none is given.
    pub fixed_direction: Vector<f64>,
    /// Reference lengths (length) and angles (degrees); the initial position where none is given.
    pub references: Components<f64>,
    /// Stops.
    pub stops: Components<Stop>,
    /// Whether the element is two-dimensional: components u1, u2, ur3 and degrees of freedom 1, 2, 6 and 10 remain.
    pub planar: bool,
    /// Whether a and b have degrees of freedom (a ground node has none).
    pub moves: [bool; 2],
}

impl Definition {
    /// A three-dimensional connector between two nodes that move, with β_s = 1 and neither references nor stops.
    pub const fn new(connection: ConnectionType, initial: Pair<f64>) -> Self {
        Self {
            connection,
            initial,
            flow_scale: 1.0,
            fixed_direction: [0.0; 3],
            references: [None; 6],
            stops: [None; 6],
            planar: false,
            moves: [true; 2],
        }
    }
}

/// A component of one connector, resolved.
#[derive(Clone, Copy, Debug)]
struct Row<R> {
    slot: Slot,
    position: Measure,
    /// The initial position (principal).
    initial: R,
    /// What is differentiated: the residual of a constrained component, else the position.
    differentiated: Measure,
    /// The initial value of what is differentiated, or 0 where the printed function vanishes.
    offset: R,
}

/// A connector on numbers of type R: `f64` for the product, [`crate::scalar::Wide`] for the truth.
#[derive(Clone, Debug)]
pub struct Connector<R: Differentiable> {
    connection: ConnectionType,
    rows: Components<Row<R>>,
    section: Section<R>,
    references: Components<R>,
    stops: Components<Stop>,
    active: [bool; DOFS],
    is_planar: bool,
    initial: Branch<R>,
}

/// How far an initially zero constraint may be from zero and still count as satisfied: direction cosines of exactly aligned
/// axes carry a few roundings.
const ALIGNED: f64 = 1e-12;

/// How far the choice between two equally near sheets leans to where the nodes turned: enough to outweigh rounding at an
/// increment of exactly half a turn, too little to matter elsewhere.
const LEAN: (i32, i32) = (1, 1_000_000);

/// What an evaluation gives; each part is present where it was asked for and exists.
#[derive(Clone, Debug)]
pub struct Evaluation<R> {
    /// CP.
    pub position: Components<R>,
    /// CU.
    pub displacement: Components<R>,
    /// CCU.
    pub constitutive: Components<R>,
    /// CV.
    pub velocity: Components<R>,
    /// CA.
    pub acceleration: Components<R>,
    /// RES.
    pub residual: Components<R>,
    /// RESV.
    pub residual_rate: Components<R>,
    /// RESB.
    pub residual_bias: Components<R>,
    /// RESA.
    pub residual_acceleration: Components<R>,
    /// Rows of first derivatives: of the residual of a constrained component, of the displacement of any other.
    pub jacobian: Components<NodalRow<R>>,
    /// Second derivatives ∂²/∂q_j∂q_k of the same functions; of a one-form, ∂row_j/∂q_k, which is not symmetric.
    pub hessian: Components<Box<[NodalRow<R>; DOFS]>>,
    /// TURNS of components that wind.
    pub turns: Components<Turns<R>>,
    /// The branch to commit.
    pub branch: Branch<R>,
}

impl<R: Differentiable> Connector<R> {
    /// A connector from its definition. Angles of the initial state are principal.
    pub fn new(definition: &Definition) -> Self {
        let exact_node = |node: &node::Node<f64>| node::Node {
            displacement: vector::exact(node.displacement),
            triad: vector::exact_matrix(&node.triad),
            flow: R::from_f64(node.flow),
        };
        let initial = Pair {
            reference: vector::exact(definition.initial.reference),
            a: exact_node(&definition.initial.a),
            b: exact_node(&definition.initial.b),
        };
        let relative = initial.relative();
        let section = Section {
            initial_orientation: relative.q,
            initial_length: R::direction_and_norm(initial.reference).1,
            fixed_direction: vector::exact(definition.fixed_direction),
            flow_scale: R::from_f64(definition.flow_scale),
        };
        let zero = R::integer(0);
        let one = R::integer(1);
        let mut history = History { rotation_vector: [zero; 3], euler_sign: one, torsion_turns: zero };
        history.rotation_vector = so3::log(&relative.q);
        let mut shared = Shared::new(&relative, &initial.a.triad, &section, &history);
        let planar = |k: usize| !definition.planar || matches!(k, 0 | 1 | 5);
        let mut rows = [None; 6];
        let mut references = [None; 6];
        let mut turns = [Turns { turns: zero, principal: zero }; 6];
        for k in (0..6).filter(|k| planar(*k)) {
            let slot = definition.connection.slots[k];
            let Some(position) = slot.position() else { continue };
            let start = position.unlocked(&relative.q, position.evaluate(&mut shared), zero);
            let (differentiated, offset) = match slot {
                Slot::Constrained(_, Condition::Zero(printed)) => (printed, zero),
                Slot::Constrained(_, Condition::ZeroOrHeld(printed)) => {
                    let printed_start = printed.evaluate(&mut shared);
                    let tiny = R::from_f64(ALIGNED);
                    R::choose(printed_start.magnitude().less(tiny), || (printed, zero), || (position, start))
                }
                _ => (position, start),
            };
            if position.winds() {
                turns[k].principal = start;
            }
            rows[k] = Some(Row { slot, position, initial: start, differentiated, offset });
            references[k] = definition.references[k].map(|reference| match position.unit() {
                Unit::Angle => R::from_f64(reference) * R::pi() / R::integer(180),
                _ => R::from_f64(reference),
            });
        }
        let mut active = [false; DOFS];
        for (j, active) in active.iter_mut().enumerate() {
            let end = usize::from(j >= DOFS / 2);
            let number = DOF_NUMBER[j];
            *active = definition.moves[end]
                && (number != 10 || definition.connection.flow[end])
                && (!definition.planar || matches!(number, 1 | 2 | 6 | 10));
        }
        let branch = Branch {
            turns,
            rotation_vector: history.rotation_vector,
            euler_sign: one,
            torsion: Turns { turns: zero, principal: so3::torsion(&relative.q) },
            accumulated: zero,
            accumulated_rest: zero,
        };
        Self {
            connection: definition.connection.clone(),
            rows,
            section,
            references,
            stops: definition.stops,
            active,
            is_planar: definition.planar,
            initial: branch,
        }
    }

    /// The connection type.
    pub const fn connection(&self) -> &ConnectionType {
        &self.connection
    }

    /// The branch before any motion.
    pub const fn initial_branch(&self) -> Branch<R> {
        self.initial
    }

    /// The nodal degrees of freedom that this connector has.
    pub const fn active(&self) -> &[bool; DOFS] {
        &self.active
    }

    /// What is differentiated in row k (0-based): the residual of a constrained component, else the position.
    pub fn differentiated(&self, k: usize) -> Option<Measure> {
        self.rows[k].map(|row| row.differentiated)
    }

    /// Whether the residual of component k (0-based) is the printed function, rather than the position held.
    pub fn is_printed_constraint(&self, k: usize) -> bool {
        self.rows[k].is_some_and(|row| row.slot.is_constrained() && row.differentiated != row.position)
    }

    /// The branch after `state`, which follows by `increment` the state that left `branch`.
    ///
    /// Turns are counted to the nearest, from where the whole turns of the nodes' own increments would have taken the angle. An
    /// increment of exactly half a turn goes the way the nodes turned, or to the principal angle where that is not said.
    pub fn advance(&self, state: &State<R>, increment: &Increment<R>, branch: &Branch<R>) -> Branch<R> {
        let mut next = *branch;
        let needs = |wanted: fn(Measure) -> bool| self.rows.iter().flatten().any(|row| wanted(row.position));
        let pair = &state.pair;
        let whole = sub(increment.whole_turns[1], increment.whole_turns[0]);
        let told = sub(sub(increment.rotation[1], increment.rotation[0]), whole);
        let rotates = needs(|m| m.dependence().rotation);
        if !rotates {
            return next;
        }
        let relative = self.relative(pair, Dependence { rotation: true, ..Dependence::default() });
        if needs(|m| matches!(m, Measure::RotationVector(_) | Measure::RotationVectorAtB(_))) {
            let carried = add(branch.rotation_vector, vector::apply_transposed(&pair.a.triad, whole));
            let lean = scale(vector::apply_transposed(&pair.a.triad, told), R::ratio(LEAN.0, LEAN.1));
            let log = so3::continuous_log(&relative.q, add(carried, lean));
            next.rotation_vector = R::choose(log.is_reference(), || log.phi, || carried);
        }
        if needs(|m| matches!(m, Measure::Euler(_))) {
            let (same, distance) = self.wind(&relative, pair, [whole, told], branch, branch.euler_sign);
            let (other, other_distance) =
                self.wind(&relative, pair, [whole, told], branch, -branch.euler_sign);
            let chosen = R::choose(
                other_distance.less(distance),
                || (other, -branch.euler_sign),
                || (same, branch.euler_sign),
            );
            (next.turns, next.euler_sign) = chosen;
        } else if needs(Measure::winds) {
            next.turns = self.wind(&relative, pair, [whole, told], branch, branch.euler_sign).0;
        }
        if needs(Measure::counts_torsion) {
            let principal = so3::torsion(&relative.q);
            let along =
                |v: Vector<R>| Measure::Torsion.winding_axis(pair).map_or(R::integer(0), |axis| dot(axis, v));
            next.torsion = nearest_turn(principal, &branch.torsion, along(whole), along(told)).0;
        }
        if needs(Measure::is_one_form) {
            // The sum and its rounding error, exactly (Knuth's two-sum).
            let change = self.accumulation(pair, increment);
            let sum = branch.accumulated + change;
            let added = sum - branch.accumulated;
            let lost = (branch.accumulated - (sum - added)) + (change - added);
            next.accumulated = sum;
            next.accumulated_rest = branch.accumulated_rest + lost;
        }
        next
    }

    /// The turn counts nearest to the previous ones, and how far the angles moved in all.
    fn wind(
        &self,
        relative: &Relative<R>,
        pair: &Pair<R>,
        [whole, told]: [Vector<R>; 2],
        branch: &Branch<R>,
        euler_sign: R,
    ) -> ([Turns<R>; 6], R) {
        let history = History { euler_sign, ..branch.history() };
        let mut shared = Shared::new(relative, &pair.a.triad, &self.section, &history);
        let mut turns = branch.turns;
        let mut moved = R::integer(0);
        for (k, row) in self.rows.iter().enumerate() {
            let Some(row) = row.filter(|row| row.position.winds()) else { continue };
            let evaluated = row.position.evaluate(&mut shared);
            let principal = row.position.unlocked(&relative.q, evaluated, branch.turns[3].principal);
            let previous = branch.turns[k];
            let along =
                |v: Vector<R>| row.position.winding_axis(pair).map_or(R::integer(0), |axis| dot(axis, v));
            let (counted, change) = nearest_turn(principal, &previous, along(whole), along(told));
            turns[k] = counted;
            moved = moved + change.magnitude();
        }
        (turns, moved)
    }

    /// The one-form over the increment, at the midpoint direction: e3a(mid)·(Δθ_a − Δθ_b) − β_s ΔΨ_b.
    fn accumulation(&self, pair: &Pair<R>, increment: &Increment<R>) -> R {
        let [of_a, of_b] = increment.rotation;
        let back = so3::matrix(so3::exp(scale(of_a, R::ratio(-1, 2))));
        let middle = vector::product(&back, &pair.a.triad);
        let form = Measure::FlowConversion.one_form(&middle, &self.section);
        let mut change = [R::integer(0); DOFS];
        change[node::THETA_A..node::PSI_A].copy_from_slice(&of_a);
        change[node::THETA_B..node::PSI_B].copy_from_slice(&of_b);
        change[node::PSI_A] = increment.flow[0];
        change[node::PSI_B] = increment.flow[1];
        let mut sum = R::integer(0);
        for (row, change) in form.iter().zip(&change) {
            sum = sum + *row * *change;
        }
        sum
    }

    /// The relative pair, as far as it is needed.
    fn relative(&self, pair: &Pair<R>, needed: Dependence) -> Relative<R> {
        let zero = [R::integer(0); 3];
        pair.varied(needed, zero, zero, [R::integer(0); 2])
    }

    /// Evaluates what `request` names at `state`, which follows by `increment` the state that left `branch`; `tally` counts the
    /// work.
    pub fn evaluate(
        &self,
        state: &State<R>,
        increment: &Increment<R>,
        branch: &Branch<R>,
        request: &Request,
        tally: &mut Tally,
    ) -> Evaluation<R> {
        let next = self.advance(state, increment, branch);
        // Values and derivatives are taken on the sheets just chosen, so that rounding cannot set them apart at a half turn.
        let history = next.history();
        let mut evaluation = Evaluation::empty(next);
        let rows: Vec<(usize, Row<R>)> = (0..6)
            .filter(|k| request.components()[*k])
            .filter_map(|k| self.rows[k].map(|row| (k, row)))
            .collect();
        self.positions(state, &history, &rows, request, tally, &mut evaluation);
        self.rates(state, &history, &rows, request, tally, &mut evaluation);
        if request.order > 0 {
            self.rows_of_derivatives(state, &history, &rows, request, tally, &mut evaluation);
        }
        evaluation
    }

    fn positions(
        &self,
        state: &State<R>,
        history: &History<R>,
        rows: &[(usize, Row<R>)],
        request: &Request,
        tally: &mut Tally,
        evaluation: &mut Evaluation<R>,
    ) {
        let wants_position =
            |k: usize| request.wants_any(&[Output::CP, Output::CU, Output::CCU, Output::CSLST], k);
        let wants_residual =
            |k: usize, row: &Row<R>| request.wants(Output::RES, k) && row.slot.is_constrained();
        let value =
            |k: usize, row: &Row<R>| (wants_position(k) && !row.position.winds()).then_some(row.position);
        let residual = |k: usize, row: &Row<R>| {
            (wants_residual(k, row) && !row.differentiated.winds()).then_some(row.differentiated)
        };
        let needed = rows
            .iter()
            .flat_map(|(k, row)| [value(*k, row), residual(*k, row)])
            .flatten()
            .fold(Dependence::default(), |sum, measure| sum.or(measure.dependence()));
        let relative = self.relative(&state.pair, needed);
        let mut shared = Shared::new(&relative, &state.pair.a.triad, &self.section, history);
        let mut evaluate = |measure: Measure, tally: &mut Tally| {
            if measure.is_one_form() {
                return evaluation.branch.accumulated + evaluation.branch.accumulated_rest;
            }
            tally.values += 1;
            measure.evaluate(&mut shared)
        };
        let zero = R::integer(0);
        for (k, row) in rows.iter().copied() {
            let turns = evaluation.branch.turns[k];
            if request.wants(Output::TURNS, k) && row.position.winds() {
                evaluation.turns[k] = Some(turns);
            }
            // An angle that winds is differenced as principal parts, so that its turns cost no digits.
            let known = value(k, &row).map(|measure| evaluate(measure, tally));
            let from = |origin: R| match known {
                Some(value) => value - origin,
                None => R::with_turns(turns.principal - origin, turns.turns),
            };
            if request.wants_any(&[Output::CP, Output::CSLST], k) {
                evaluation.position[k] = Some(from(zero));
            }
            if request.wants(Output::CU, k) {
                evaluation.displacement[k] = Some(from(row.initial));
            }
            if request.wants(Output::CCU, k) && row.slot.is_available() {
                evaluation.constitutive[k] = Some(from(self.references[k].unwrap_or(row.initial)));
            }
            if wants_residual(k, &row) {
                evaluation.residual[k] = Some(match residual(k, &row) {
                    Some(measure) if Some(measure) == value(k, &row) => from(row.offset),
                    Some(measure) => evaluate(measure, tally) - row.offset,
                    None => R::with_turns(turns.principal - row.offset, turns.turns),
                });
            }
        }
    }

    fn rates(
        &self,
        state: &State<R>,
        history: &History<R>,
        rows: &[(usize, Row<R>)],
        request: &Request,
        tally: &mut Tally,
        evaluation: &mut Evaluation<R>,
    ) {
        let of_position = |k: usize| request.wants_any(&[Output::CV, Output::CA], k);
        let of_residual = |k: usize, row: &Row<R>| {
            request.wants_any(&[Output::RESV, Output::RESA], k) && row.slot.is_constrained()
        };
        let bias = |k: usize, row: &Row<R>| request.wants(Output::RESB, k) && row.slot.is_constrained();
        let mut measures = Vec::new();
        let mut bias_measures = Vec::new();
        for (k, row) in rows {
            if of_position(*k) {
                measures.push(row.position);
            }
            if of_residual(*k, row) && !measures.contains(&row.differentiated) {
                measures.push(row.differentiated);
            }
            if bias(*k, row) {
                bias_measures.push(row.differentiated);
            }
        }
        if !measures.is_empty() {
            let mut along = Along::new(self, state, &state.acceleration, history, measures);
            for (k, row) in rows.iter().copied() {
                if of_position(k) {
                    let [velocity, acceleration] = along.rates(row.position, tally);
                    evaluation.velocity[k] = request.wants(Output::CV, k).then_some(velocity);
                    evaluation.acceleration[k] = request.wants(Output::CA, k).then_some(acceleration);
                }
                if of_residual(k, &row) {
                    let [velocity, acceleration] = along.rates(row.differentiated, tally);
                    evaluation.residual_rate[k] = request.wants(Output::RESV, k).then_some(velocity);
                    evaluation.residual_acceleration[k] =
                        request.wants(Output::RESA, k).then_some(acceleration);
                }
            }
        }
        if !bias_measures.is_empty() {
            let still = [R::integer(0); DOFS];
            let mut along = Along::new(self, state, &still, history, bias_measures);
            for (k, row) in rows.iter().filter(|(k, row)| bias(*k, row)) {
                evaluation.residual_bias[*k] = Some(along.rates(row.differentiated, tally)[1]);
            }
        }
    }

    fn rows_of_derivatives(
        &self,
        state: &State<R>,
        history: &History<R>,
        rows: &[(usize, Row<R>)],
        request: &Request,
        tally: &mut Tally,
        evaluation: &mut Evaluation<R>,
    ) {
        let of = |seeds: Seeds| {
            let chosen = rows.iter().filter(move |(_, row)| Seeds::of(row.differentiated) == seeds);
            chosen.map(|(k, row)| (*k, row.differentiated)).collect::<Vec<_>>()
        };
        let second = request.order > 1;
        let mut take = |k: usize, gradient: RelativeGradient<R>, relative: [[R; 8]; 8]| {
            // A measure that no direction of a enters does not feel a turn.
            let mut active = self.active;
            if !self.differentiated(k).is_some_and(Measure::turns_with_a) {
                active[node::THETA_A..node::PSI_A].fill(false);
            }
            let mut row = state.pair.nodal_row(&gradient);
            for (entry, active) in row.iter_mut().zip(&active) {
                if !active {
                    *entry = R::integer(0);
                }
            }
            evaluation.jacobian[k] = Some(row);
            if second {
                let hessian = state.pair.nodal_hessian(&gradient, &relative, &active);
                evaluation.hessian[k] = Some(Box::new(hessian));
            }
        };
        let input = (self, state, history);
        if second {
            Seeds::Translation.pass::<R, R::Hessian<3>, 3>(input, &of(Seeds::Translation), &mut take);
            Seeds::Rotation.pass::<R, R::Hessian<3>, 3>(input, &of(Seeds::Rotation), &mut take);
            Seeds::Motion.pass::<R, R::Hessian<6>, 6>(input, &of(Seeds::Motion), &mut take);
            Seeds::All.pass::<R, R::Hessian<8>, 8>(input, &of(Seeds::All), &mut take);
        } else {
            Seeds::Translation.pass::<R, R::Gradient<3>, 3>(input, &of(Seeds::Translation), &mut take);
            Seeds::Rotation.pass::<R, R::Gradient<3>, 3>(input, &of(Seeds::Rotation), &mut take);
            Seeds::Motion.pass::<R, R::Gradient<6>, 6>(input, &of(Seeds::Motion), &mut take);
            Seeds::All.pass::<R, R::Gradient<8>, 8>(input, &of(Seeds::All), &mut take);
        }
        let count = rows.iter().filter(|(_, row)| !row.differentiated.is_one_form()).count() as u64;
        if second {
            tally.hessians += count;
        } else {
            tally.gradients += count;
        }
        for (k, row) in rows.iter().filter(|(_, row)| row.differentiated.is_one_form()) {
            self.one_form_rows(state, *k, row.differentiated, second, tally, evaluation);
        }
    }

    /// The row of a one-form and, for second derivatives, how the row changes as its carrier turns.
    fn one_form_rows(
        &self,
        state: &State<R>,
        k: usize,
        measure: Measure,
        second: bool,
        tally: &mut Tally,
        evaluation: &mut Evaluation<R>,
    ) {
        let zero = R::integer(0);
        let row = measure.one_form(&state.pair.a.triad, &self.section);
        let masked = |j: usize, value: R| if self.active[j] { value } else { zero };
        let mut active_row = row;
        for (j, entry) in active_row.iter_mut().enumerate() {
            *entry = masked(j, *entry);
        }
        evaluation.jacobian[k] = Some(active_row);
        tally.gradients += 1;
        if !second {
            return;
        }
        tally.hessians += 1;
        let seed = |i: usize| R::Gradient::<3>::seed(zero, i);
        let turning = turned_triad(&state.pair.a.triad, [seed(0), seed(1), seed(2)]);
        let form = measure.one_form(&turning, &self.section);
        let mut hessian = Box::new([[zero; DOFS]; DOFS]);
        for (j, entry) in form.iter().enumerate() {
            for (i, derivative) in entry.gradient().into_iter().enumerate() {
                let carrier = node::THETA_A + i;
                if self.active[carrier] {
                    hessian[j][carrier] = masked(j, derivative);
                }
            }
        }
        evaluation.hessian[k] = Some(hessian);
    }
}

impl<R: Copy> Branch<R> {
    /// What measures need to know of it.
    const fn history(&self) -> History<R> {
        History {
            rotation_vector: self.rotation_vector,
            euler_sign: self.euler_sign,
            torsion_turns: self.torsion.turns,
        }
    }
}

/// An angle with the number of turns that brings it nearest to where the previous one is after the `whole` turns of the nodes,
/// and how far it moved besides (rad). Where two numbers of turns are equally near, `told`, how far the nodes turned besides,
/// decides.
fn nearest_turn<R: Real>(principal: R, previous: &Turns<R>, whole: R, told: R) -> (Turns<R>, R) {
    let turn = R::pi() + R::pi();
    let lean = R::ratio(LEAN.0, LEAN.1);
    let change = principal - previous.principal - whole;
    let counted = ((change - (told + change * lean) * lean) / turn).nearest_integer();
    (Turns { turns: previous.turns - counted, principal }, change - counted * turn)
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

/// Which relative variations carry derivatives: those that a measure depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Seeds {
    Translation,
    Rotation,
    Motion,
    All,
    None,
}

impl Seeds {
    fn of(measure: Measure) -> Self {
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

    /// Evaluates measures on numbers with derivatives along these variations and hands on their relative derivatives.
    fn pass<R: Differentiable, S: Seeded<N, Real = R>, const N: usize>(
        self,
        (connector, state, history): (&Connector<R>, &State<R>, &History<R>),
        measures: &[(usize, Measure)],
        take: &mut impl FnMut(usize, RelativeGradient<R>, [[R; 8]; 8]),
    ) {
        if measures.is_empty() {
            return;
        }
        let (first, needed) = match self {
            Self::Translation => (0, Dependence { translation: true, ..Dependence::default() }),
            Self::Rotation => (3, Dependence { rotation: true, ..Dependence::default() }),
            Self::Motion => (0, Dependence { translation: true, rotation: true, flow: false }),
            Self::All | Self::None => (0, Dependence { translation: true, rotation: true, flow: true }),
        };
        let zero = R::integer(0);
        let seed = |i: usize| {
            if i >= first && i < first + N { S::seed(zero, i - first) } else { S::zero() }
        };
        let relative = state.pair.varied(
            needed,
            [seed(0), seed(1), seed(2)],
            [seed(3), seed(4), seed(5)],
            [seed(6), seed(7)],
        );
        let mut shared = Shared::new(&relative, &state.pair.a.triad, &connector.section, history);
        for (k, measure) in measures {
            let value = measure.evaluate(&mut shared);
            let mut gradient = [zero; 8];
            gradient[first..first + N].copy_from_slice(&value.gradient());
            let mut hessian = [[zero; 8]; 8];
            for (i, line) in value.hessian().into_iter().enumerate() {
                hessian[first + i][first..first + N].copy_from_slice(&line);
            }
            let [g1, g2, g3, h1, h2, h3, psi_a, psi_b] = gradient;
            let gradient =
                RelativeGradient { translation: [g1, g2, g3], rotation: [h1, h2, h3], flow: [psi_a, psi_b] };
            take(*k, gradient, hessian);
        }
    }
}

/// A state that moves: measures evaluated on numbers with two time derivatives.
struct Along<'a, R: Differentiable> {
    connector: &'a Connector<R>,
    state: &'a State<R>,
    acceleration: &'a NodalRates<R>,
    history: &'a History<R>,
    relative: Relative<R::Time>,
    /// The rotation vector and misalignment are shared between components by evaluating all of them once.
    cache: Vec<(Measure, [R; 2])>,
    measures: Vec<Measure>,
}

impl<'a, R: Differentiable> Along<'a, R> {
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
    fn rates(&mut self, measure: Measure, tally: &mut Tally) -> [R; 2] {
        if self.cache.is_empty() {
            let state = self.state;
            let section = &self.connector.section;
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
        found.map_or([R::integer(0); 2], |(_, rates)| *rates)
    }
}

/// The relative pair along time.
fn moving<R: Differentiable>(
    pair: &Pair<R>,
    rates: &RelativeRates<R>,
    needed: Dependence,
) -> Relative<R::Time> {
    let zero = R::integer(0);
    let vector = |of: [[R; 3]; 2]| [0, 1, 2].map(|i| R::moving(zero, of[0][i], of[1][i]));
    let flow = [0, 1].map(|i| R::moving(zero, rates.flow[0][i], rates.flow[1][i]));
    pair.varied(needed, vector(rates.translation), vector(rates.rotation), flow)
}

/// The rate of a one-form, row·q̇, and its time derivative, row·q̈ + (row)˙·q̇.
fn one_form_rates<R: Differentiable>(
    measure: Measure,
    state: &State<R>,
    acceleration: &NodalRates<R>,
    section: &Section<R>,
) -> [R; 2] {
    let zero = R::integer(0);
    let spin = node::spin(&state.velocity, End::A);
    let turning = turned_triad(&state.pair.a.triad, spin.map(|rate| R::moving(zero, rate, zero)));
    let mut rates = [zero; 2];
    for (j, entry) in measure.one_form(&turning, section).into_iter().enumerate() {
        let (change, _) = R::rates(entry);
        rates[0] = rates[0] + entry.real() * state.velocity[j];
        rates[1] = rates[1] + entry.real() * acceleration[j] + change * state.velocity[j];
    }
    rates
}

impl<R> Evaluation<R> {
    fn empty(branch: Branch<R>) -> Self {
        Self {
            position: [const { None }; 6],
            displacement: [const { None }; 6],
            constitutive: [const { None }; 6],
            velocity: [const { None }; 6],
            acceleration: [const { None }; 6],
            residual: [const { None }; 6],
            residual_rate: [const { None }; 6],
            residual_bias: [const { None }; 6],
            residual_acceleration: [const { None }; 6],
            jacobian: [const { None }; 6],
            hessian: [const { None }; 6],
            turns: [const { None }; 6],
            branch,
        }
    }
}

#[cfg(test)]
mod tests;
