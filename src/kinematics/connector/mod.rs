//! One connector: positions, displacements, rates, residuals, rows, second derivatives, and what its history decides.
//!
//! A [`Connector`] is a connection type with its section data and initial state. It is evaluated at a [`State`] with the [`Branch`] that
//! the previous states left: turn counts, the sheet of the rotation vector, accumulated one-forms. It computes what a [`Request`] names
//! and nothing else, and gives back the branch to commit. A branch is committed by keeping it: [`Connector::advance`] never changes the
//! one it starts from.

mod branch;
mod compact;
mod derivatives;
mod flags;
mod linear;
mod request;

pub use branch::{Branch, Increment, Turns};
pub(crate) use branch::{Follower, nearest_turn};
pub use compact::{CompactRow, Group};
pub(crate) use derivatives::Differentiation;
use flags::Singular;
pub use flags::{CERTAIN_INCREMENT, CERTAIN_TOLD, CERTAIN_TURNS, ILL_CONDITIONED};
pub use flags::{Flag, Holding, Stop, StopStatus, Turned};
pub use linear::Linear;
use linear::Program;
pub use request::{Mask, Output, Request, Tally};

use crate::catalog::{Condition, ConnectionType, PLANE, Slot};
use crate::measure::{History, LOCK, Measure, Section, Shared, SingularClass, Unit};
use crate::node::{DOF_NUMBER, DOFS, Dependence, NodalRates, Pair, Relative};
use crate::scalar::{Duals, Real};
use crate::so3;
use crate::vector;
use crate::vector::Vector;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A value for each of u1, u2, u3, ur1, ur2, ur3; `None` where the component is absent or was not asked for.
pub type Components<T> = [Option<T>; 6];

/// A row of nodal derivatives, in the order of [`crate::node::DOF`].
pub type NodalRow<R> = [R; DOFS];

/// Derivatives by two nodal degrees of freedom, both in the order of [`crate::node::DOF`].
pub type NodalMatrix<R> = Box<[NodalRow<R>; DOFS]>;

/// The nodes at one instant, with their rates.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(
    deny_unknown_fields,
    bound(
        serialize = "R: Serialize, R::Real: Serialize",
        deserialize = "R: Deserialize<'de>, R::Real: Deserialize<'de>"
    )
)]
pub struct State<R: Real> {
    /// Displacements, triads, flows.
    pub pair: Pair<R>,
    /// v, ω, Ψ̇ of both nodes.
    pub velocity: NodalRates<R>,
    /// a, α, Ψ̈ of both nodes.
    pub acceleration: NodalRates<R>,
}

/// Everything that defines a connector.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Definition {
    /// The connection type, shared by all connectors of a section.
    #[serde(with = "by_name")]
    pub connection: Arc<ConnectionType>,
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
    /// Whether a and b have rotational degrees of freedom. The directions of an end without them are fixed, its triad in every state
    /// the initial one, and rows have no columns θ there.
    pub rotates: [bool; 2],
}

/// A connection type as the names of what it is made of: itself, or a basic translational and a basic rotational type.
mod by_name {
    use crate::catalog::ConnectionType;
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::sync::Arc;

    pub(super) fn serialize<S: Serializer>(of: &Arc<ConnectionType>, to: S) -> Result<S::Ok, S::Error> {
        match of.halves {
            [Some(t), Some(r)] => [t.name, r.name].serialize(to),
            _ => [&of.name].serialize(to),
        }
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Arc<ConnectionType>, D::Error> {
        let names: Vec<String> = Deserialize::deserialize(from)?;
        let found = match names.as_slice() {
            [one] => ConnectionType::named(one, None),
            [translational, rotational] => ConnectionType::named(translational, Some(rotational)),
            others => return Err(Error::custom(format!("{} connection types, not 1 or 2", others.len()))),
        };
        found.map(Arc::new).map_err(Error::custom)
    }
}

impl Definition {
    /// A three-dimensional connector between two nodes that move, with β_s = 1 and neither references nor stops.
    pub fn new(connection: impl Into<Arc<ConnectionType>>, initial: Pair<f64>) -> Self {
        Self {
            connection: connection.into(),
            initial,
            flow_scale: 1.0,
            fixed_direction: [0.0; 3],
            references: [None; 6],
            stops: [None; 6],
            planar: false,
            moves: [true; 2],
            rotates: [true; 2],
        }
    }
}

/// A component of a connector, resolved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Row {
    slot: Slot,
    position: Measure,
    /// What is differentiated: the residual of a constrained component, else the position.
    differentiated: Measure,
    /// Whether that is the printed function, which vanishes initially, rather than the position with its initial value.
    vanishes: bool,
}

/// One evaluation: the state, what its history decides, the components wanted and what is wanted of them.
#[derive(Clone, Copy)]
struct Pass<'a, R: Duals> {
    state: &'a State<R>,
    history: &'a History<R>,
    rows: &'a Components<Row>,
    chosen: Mask,
    request: &'a Request,
}

impl<'a, R: Duals> Pass<'a, R> {
    /// The components chosen that there are.
    fn rows(&self) -> impl Iterator<Item = (usize, &'a Row)> + use<'a, R> {
        let (rows, chosen) = (self.rows, self.chosen);
        rows.iter().enumerate().filter_map(move |(k, row)| Some((k, row.as_ref().filter(|_| chosen[k])?)))
    }
}

/// What connectors have in common that differ in their initial lengths only. A model has many of these.
#[derive(Clone, Debug)]
struct Kind<R> {
    connection: Arc<ConnectionType>,
    rows: Components<Row>,
    program: Program,
    section: Section<R>,
    references: Components<R>,
    stops: Components<Stop>,
    active: [bool; DOFS],
    /// Whether all degrees of freedom are active, but for those of material flow.
    is_free: bool,
    reach: [bool; DOFS],
    is_planar: bool,
    /// The singular sets next to which the initial positions lay, so that rounding decided them.
    undetermined_origins: [Option<&'static str>; 6],
    /// Which distances to singular sets there are.
    singular: Singular,
    /// Before any motion.
    branch: Branch<R>,
}

/// A connector on numbers of type R: `f64` for the product, [`crate::scalar::Wide`] for the truth.
#[derive(Clone, Debug)]
pub struct Connector<R: Duals> {
    kind: Arc<Kind<R>>,
    /// The initial position of each component (principal); zero where there is none.
    initial: [R; 6],
}

/// The degrees of freedom that a connector loads: flow where it is active, 1, 2, 6 and 10 in two dimensions, no rotation of a node that
/// has none. The ground has all of them: it takes every reaction.
fn reach(definition: &Definition) -> [bool; DOFS] {
    let mut reach = [false; DOFS];
    for (j, reach) in reach.iter_mut().enumerate() {
        let (end, number) = (usize::from(j >= DOFS / 2), DOF_NUMBER[j]);
        *reach = (number != 10 || definition.connection.flow[end])
            && (!matches!(number, 4..=6) || definition.rotates[end] || !definition.moves[end])
            && (!definition.planar || matches!(number, 1 | 2 | 6 | 10));
    }
    reach
}

/// Where rounding decided the initial positions: within it of a set where an angle is not determined, or changes its sign. On such a set
/// exactly, and at a lock, a convention says what stands there.
fn undetermined_origins(definition: &Definition, rows: &[Option<Row>; 6]) -> [Option<&'static str>; 6] {
    let measures = [0, 1, 2, 3, 4, 5].map(|k| rows[k].as_ref().map(|row| row.position));
    let may_be = |measure: &Measure| {
        measure.singular_set().is_some_and(|set| {
            set.unit == Unit::Angle
                && match set.class {
                    SingularClass::TrueSingularity | SingularClass::BranchCut | SingularClass::Reversal => {
                        true
                    }
                    SingularClass::Kink | SingularClass::Removable => false,
                }
        })
    };
    if !measures.iter().flatten().any(may_be) {
        return [None; 6];
    }
    let relative = definition.initial.relative();
    let section = Section {
        initial_orientation: relative.q,
        initial_length: 0.0,
        fixed_direction: definition.fixed_direction,
        flow_scale: definition.flow_scale,
    };
    let rotation_vector = so3::log(&relative.q);
    let history = History { rotation_vector, euler_sign: 1.0, torsion_turns: 0.0 };
    measures.map(|measure| {
        let margin = measure.filter(may_be)?.margin(&relative, &section, &history)?;
        (margin.distance > 0.0 && margin.distance < LOCK).then_some(margin.set.at)
    })
}

/// How far an initially zero constraint may be from zero and still count as satisfied: direction cosines of exactly aligned
/// axes carry a few roundings.
const ALIGNED: f64 = 1e-12;

/// What an evaluation gives; each part is present where it was asked for and exists.
#[derive(Clone, Debug)]
#[non_exhaustive]
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
    pub hessian: Components<NodalMatrix<R>>,
    /// TURNS of components that wind.
    pub turns: Components<Turns<R>>,
    /// The branch to commit.
    pub branch: Branch<R>,
}

impl<R: Duals> Connector<R> {
    pub(crate) fn make(definition: &Definition) -> Self {
        let initial: Pair<R> = definition.initial.exact();
        let relative = initial.relative();
        let zero = R::ZERO;
        let section = Section {
            initial_orientation: relative.q,
            initial_length: match definition.connection.is_belt() {
                true => R::direction_and_norm(initial.reference).1,
                false => zero,
            },
            fixed_direction: vector::exact(definition.fixed_direction),
            flow_scale: R::from_f64(definition.flow_scale),
        };
        let one = R::integer(1);
        let mut history = History { rotation_vector: [zero; 3], euler_sign: one, torsion_turns: zero };
        history.rotation_vector = so3::log(&relative.q);
        let mut shared = Shared::new(&relative, &initial.a.triad, &section, &history);
        let planar = |k: usize| !definition.planar || PLANE[k];
        let mut rows = [None; 6];
        let mut starts = [zero; 6];
        let mut references = [None; 6];
        let mut turns = [Turns { turns: zero, principal: zero }; 6];
        for k in (0..6).filter(|k| planar(*k)) {
            let slot = definition.connection.slots[k];
            let Some(position) = slot.position() else { continue };
            let start = position.unlocked(&relative.q, position.evaluate(&mut shared), zero);
            let (differentiated, vanishes) = match slot {
                Slot::Constrained(_, Condition::Zero(printed)) => (printed, true),
                Slot::Constrained(_, Condition::ZeroOrHeld(printed)) => {
                    let printed_start = printed.evaluate(&mut shared);
                    let tiny = R::from_f64(ALIGNED);
                    if R::holds(printed_start.magnitude().less(tiny)) {
                        (printed, true)
                    } else {
                        (position, false)
                    }
                }
                _ => (position, false),
            };
            if position.winds() {
                turns[k].principal = start;
            }
            rows[k] = Some(Row { slot, position, differentiated, vanishes });
            starts[k] = start;
            references[k] = definition.references[k].map(|reference| match position.unit() {
                Unit::Angle => R::from_f64(reference) * R::pi() / R::integer(180),
                _ => R::from_f64(reference),
            });
        }
        let reach = reach(definition);
        let mut active = reach;
        for (j, active) in active.iter_mut().enumerate() {
            *active &= definition.moves[usize::from(j >= DOFS / 2)];
        }
        let branch = Branch {
            turns,
            rotation_vector: history.rotation_vector,
            euler_sign: one,
            torsion: Turns { turns: zero, principal: so3::torsion(&relative.q) },
            accumulated: zero,
            accumulated_rest: zero,
        };
        let kind = Kind {
            connection: Arc::clone(&definition.connection),
            program: Program::new(&rows),
            rows,
            section,
            references,
            stops: definition.stops,
            active,
            is_free: (0..DOFS).all(|j| active[j] || DOF_NUMBER[j] == 10),
            singular: Singular::new(&rows),
            reach,
            is_planar: definition.planar,
            undetermined_origins: undetermined_origins(definition, &rows),
            branch,
        };
        Self { kind: Arc::new(kind), initial: starts }
    }

    /// The connection type.
    pub fn connection(&self) -> &ConnectionType {
        &self.kind.connection
    }

    /// The branch before any motion.
    pub fn initial_branch(&self) -> Branch<R> {
        self.kind.branch
    }

    /// The nodal degrees of freedom that this connector has.
    pub fn active(&self) -> &[bool; DOFS] {
        &self.kind.active
    }

    /// What is differentiated in row k (0-based): the residual of a constrained component, else the position.
    pub fn differentiated(&self, k: usize) -> Option<Measure> {
        self.kind.rows[k].map(|row| row.differentiated)
    }

    /// The measure of the position of component k (0-based).
    pub fn position_measure(&self, k: usize) -> Option<Measure> {
        self.kind.rows[k].map(|row| row.position)
    }

    /// Whether component k (0-based) is constrained.
    pub fn is_constrained(&self, k: usize) -> bool {
        self.kind.rows[k].is_some_and(|row| row.slot.is_constrained())
    }

    /// What measures refer to.
    pub fn section(&self) -> &Section<R> {
        &self.kind.section
    }

    /// Q₀.
    pub(crate) fn initial_orientation(&self) -> &vector::Matrix<R> {
        &self.kind.section.initial_orientation
    }

    /// The degrees of freedom that the connector loads, of moving nodes and of the ground.
    pub fn reach(&self) -> &[bool; DOFS] {
        &self.kind.reach
    }

    /// Whether the residual of component k (0-based) is the printed function, rather than the position held.
    pub fn is_printed_constraint(&self, k: usize) -> bool {
        self.kind.rows[k].is_some_and(|row| row.slot.is_constrained() && row.differentiated != row.position)
    }

    /// The relative pair, as far as it is needed.
    fn relative(&self, pair: &Pair<R>, needed: Dependence) -> Relative<R> {
        let zero = [R::ZERO; 3];
        pair.varied(needed, zero, zero, [R::ZERO; 2])
    }

    /// Adds what a request names to an evaluation that has nothing but its branch.
    pub(crate) fn add_any(
        &self,
        evaluation: &mut Evaluation<R>,
        state: &State<R>,
        request: &Request,
        tally: &mut Tally,
    ) {
        let chosen = request.components();
        if chosen == [false; 6] {
            return;
        }
        // Values and derivatives are taken on the sheets just chosen, so that rounding cannot set them apart at a half turn.
        let history = evaluation.branch.history();
        let pass = Pass { state, history: &history, rows: &self.kind.rows, chosen, request };
        self.positions(&pass, tally, evaluation);
        self.rates(&pass, tally, evaluation);
        if request.order > 0 {
            self.rows_of_derivatives(&Pass { chosen: request.rows(), ..pass }, tally, evaluation);
        }
    }

    /// What the constitutive displacement of component k (0-based) counts from; `None` where there is no component.
    pub fn reference(&self, k: usize) -> Option<R> {
        let is_there = self.kind.rows.get(k)?.is_some();
        is_there.then(|| self.kind.references[k].unwrap_or(self.initial[k]))
    }

    /// What a residual counts from.
    fn offset(&self, k: usize, row: &Row) -> R {
        if row.vanishes { R::ZERO } else { self.initial[k] }
    }

    fn positions(&self, pass: &Pass<'_, R>, tally: &mut Tally, evaluation: &mut Evaluation<R>) {
        let Pass { state, history, request, .. } = *pass;
        let wants_position =
            |k: usize| request.wants_any([Output::CP, Output::CU, Output::CCU, Output::CSLST], k);
        let wants_residual = |k: usize, row: &Row| request.wants(Output::RES, k) && row.slot.is_constrained();
        let value =
            |k: usize, row: &Row| (wants_position(k) && !row.position.winds()).then_some(row.position);
        let residual = |k: usize, row: &Row| {
            (wants_residual(k, row) && !row.differentiated.winds()).then_some(row.differentiated)
        };
        let mut needed = Dependence::default();
        for (k, row) in pass.rows() {
            for measure in [value(k, row), residual(k, row)].into_iter().flatten() {
                needed = needed.or(measure.dependence());
            }
        }
        let relative = self.relative(&state.pair, needed);
        let mut shared = Shared::new(&relative, &state.pair.a.triad, &self.kind.section, history);
        let mut evaluate = |measure: Measure, tally: &mut Tally| {
            if measure.is_one_form() {
                return evaluation.branch.accumulated + evaluation.branch.accumulated_rest;
            }
            tally.values += 1;
            measure.evaluate(&mut shared)
        };
        let zero = R::ZERO;
        for (k, row) in pass.rows() {
            let turns = evaluation.branch.turns[k];
            if request.wants(Output::TURNS, k) && row.position.winds() {
                evaluation.turns[k] = Some(turns);
            }
            // An angle that winds is differenced as principal parts, so that its turns cost no digits.
            let known = value(k, row).map(|measure| evaluate(measure, tally));
            let from = |origin: R| match known {
                Some(value) => value - origin,
                None => R::with_turns(turns.principal - origin, turns.turns),
            };
            if request.wants_any([Output::CP, Output::CSLST], k) {
                evaluation.position[k] = Some(from(zero));
            }
            if request.wants(Output::CU, k) {
                evaluation.displacement[k] = Some(from(self.initial[k]));
            }
            if request.wants(Output::CCU, k) && row.slot.is_available() {
                evaluation.constitutive[k] = self.reference(k).map(from);
            }
            if wants_residual(k, row) {
                let offset = self.offset(k, row);
                evaluation.residual[k] = Some(match residual(k, row) {
                    Some(measure) if Some(measure) == value(k, row) => from(offset),
                    Some(measure) => evaluate(measure, tally) - offset,
                    None => R::with_turns(turns.principal - offset, turns.turns),
                });
            }
        }
    }
}

impl Connector<f64> {
    /// Whether its rows are those of another one: the same measures, constrained alike. Such connectors share a [`Fours`](crate::batch::Fours).
    pub fn has_measures_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.kind, &other.kind) || self.kind.rows == other.kind.rows
    }

    pub(crate) fn rows(&self) -> &Components<Row> {
        &self.kind.rows
    }

    /// Keeps what it has in common with a connector whose definition differs from its own in X_b − X_a only once for both.
    pub fn share(&mut self, alike: &Self) {
        let length = |of: &Self| of.kind.section.initial_length.to_bits();
        if self.kind.rows == alike.kind.rows && length(self) == length(alike) {
            self.kind = Arc::clone(&alike.kind);
        }
    }
}

impl<R: Copy> Evaluation<R> {
    /// The value of an output of component k (0-based); `None` of those that it does not hold as numbers ([`Output::is_of_motion`]).
    pub fn value(&self, output: Output, k: usize) -> Option<R> {
        let values = match output {
            Output::CP => &self.position,
            Output::CU => &self.displacement,
            Output::CCU => &self.constitutive,
            Output::CV => &self.velocity,
            Output::CA => &self.acceleration,
            Output::RES => &self.residual,
            Output::RESV => &self.residual_rate,
            Output::RESB => &self.residual_bias,
            Output::RESA => &self.residual_acceleration,
            _ => return None,
        };
        values.get(k).copied().flatten()
    }
}

impl<R> Evaluation<R> {
    /// No number yet, on a branch.
    pub const fn empty(branch: Branch<R>) -> Self {
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

    /// Takes everything from it but its branch, in place: it is three kilobytes long.
    pub(crate) fn clear(&mut self) {
        let Self {
            position,
            displacement,
            constitutive,
            velocity,
            acceleration,
            residual,
            residual_rate,
            residual_bias,
            residual_acceleration,
            jacobian,
            hessian,
            turns,
            branch: _,
        } = self;
        for values in [
            position,
            displacement,
            constitutive,
            velocity,
            acceleration,
            residual,
            residual_rate,
            residual_bias,
            residual_acceleration,
        ] {
            *values = [const { None }; 6];
        }
        jacobian.iter_mut().for_each(|row| *row = None);
        hessian.iter_mut().for_each(|matrix| *matrix = None);
        turns.iter_mut().for_each(|turns| *turns = None);
    }
}

#[cfg(test)]
mod tests;
