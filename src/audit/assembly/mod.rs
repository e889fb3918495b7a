//! The whole assembly: how many degrees of freedom has it, how can it move, which of its constraints are redundant?
//!
//! The equations that connectors and multi-point constraints enforce, components that connector motions hold, and degrees of freedom
//! that boundary conditions hold, make one matrix J over the nodal degrees of freedom: with q̇ any motion of the nodes, J q̇ = 0 are
//! those that the assembly allows. Lengths are divided by the mean length of the connectors of a part, so that J has no
//! dimension.
//!
//! | number | is |
//! |---|---|
//! | degrees of freedom | columns of J: those of the nodes that nothing holds |
//! | constraints | rows of J |
//! | Grübler's mobility | degrees of freedom less constraints |
//! | mobility | degrees of freedom less rank: the independent motions that are left |
//! | redundant | constraints less rank: constraints that follow from the others |
//!
//! Motions that connector motions and boundary conditions *drive* (prescribed, and not zero) come on top: what they leave of the
//! mobility is what nothing drives.
//!
//! *Proven and judged.* Ranks are those of the matrix to rounding, with the gap between what counts as zero and what does not
//! ([`Gap`]); without gap they are undecided. That a redundancy holds at one state only is proven, to rounding, by another
//! admissible state without it; that it holds throughout is judged from several random ones that the assembly was moved to, and from
//! the states given ([`Holds`]). Stops, locks, failures and friction are not looked at.
//!
//! | module | question |
//! |---|---|
//! | `system` | what are the equations, and which belong together? |
//! | `order` | in which order are nodes eliminated? |
//! | `eliminate` | what are rank, dependent rows and free columns? |
//! | `noise` | what of that is rounding? |
//! | `dense` | singular values of small parts |
//! | `given` | what holds at the states given? |
//! | `moving` | does a redundancy hold elsewhere? |
//! | `findings` | what is said of it? |

mod dense;
mod eliminate;
pub(super) mod findings;
mod given;
mod moving;
mod noise;
mod order;
mod sparse;
mod system;
#[cfg(test)]
mod tests;

pub use system::Role;

use crate::audit::bound::U;
use crate::catalog::COMPONENT;
use crate::evaluate::{Fixed, Freedom, Jacobian, Model, Plan, Sequence, Source};
use crate::scene::{Diagnostic, Label, Scene, State};
use eliminate::{Outcome, Sparse, Task, eliminate};
use moving::elsewhere;
use rayon::prelude::*;
use serde::{Serialize, Serializer};
use std::collections::BTreeSet;
use std::fmt::{self, Display};
use system::{Origin, Part, Prescribed, System, request};

/// Where a redundancy holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Holds {
    /// At every state that was looked at: judged to hold wherever the part can move.
    Throughout,
    /// The part cannot move at all: there is no other state.
    Rigid,
    /// At this state, and not at another admissible one: proven, to rounding.
    Here,
    /// The part can move to first order, and no admissible state near by was found: judged a singular position.
    Isolated,
    /// It could not be judged.
    Unjudged,
}

impl Holds {
    /// In words, with what it rests on.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Throughout => {
                "it holds throughout (judged: the same at other states that the assembly was moved to)"
            }
            Self::Rigid => "it holds throughout (what belongs to it cannot move)",
            Self::Here => {
                "it holds at this state only (proven to rounding: at another admissible state it does not)"
            }
            Self::Isolated => {
                "it holds at this state (judged a singular position: motions that are free to first order lead nowhere)"
            }
            Self::Unjudged => "whether it holds at other states was not judged",
        }
    }
}

/// An equation, by what it belongs to.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Constraint {
    /// The connector element.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub element: Option<Label>,
    /// The multi-point constraint, by kind and nodes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mpc: Option<String>,
    /// The node of a boundary condition.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub node: Option<Label>,
    /// The component, equation or degree of freedom.
    pub component: String,
    /// Why it holds.
    pub role: Role,
}

impl Display for Constraint {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let component = &self.component;
        match (&self.element, &self.mpc, &self.node) {
            (Some(element), ..) => write!(formatter, "{component} of element {element}"),
            (_, Some(mpc), _) => write!(formatter, "{component} of {mpc}"),
            (_, _, Some(node)) => write!(formatter, "degree of freedom {component} of node {node}"),
            _ => formatter.write_str(component),
        }
    }
}

/// A constraint that follows from others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Redundant {
    /// The constraint.
    pub constraint: Constraint,
    /// Where it does.
    pub holds: Holds,
    /// The others that it follows from, where the part is small enough to say it; empty where all its nodes are held.
    pub from: Vec<Constraint>,
}

/// A motion that is left.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// The degree of freedom that stands for it.
    pub leading: Freedom,
    /// The nodes that move, those that move most first, and at most twenty; only that of `leading` where the part is too large.
    pub nodes: Vec<Label>,
    /// The number of nodes that move; `None` where the part is too large to say it.
    pub moving: Option<usize>,
}

/// What lies between zero and not.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// The largest relative change of the matrix that makes a number zero which counts as zero.
    #[serde(serialize_with = "finite")]
    pub zero: f64,
    /// The smallest one of those that do not; infinite where there is none.
    #[serde(serialize_with = "finite")]
    pub nonzero: f64,
    /// For a part small enough, and of all parts the worst: the smallest singular value that is not zero, and the largest that is, over the
    /// largest.
    pub singular_values: Option<[f64; 2]>,
}

fn finite<S: Serializer>(number: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    number.is_finite().then_some(number).serialize(serializer)
}

/// The assembly at one state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Position {
    /// The number of the state; none for the initial one.
    pub state: Option<u64>,
    /// The rank of the constraints.
    pub rank: usize,
    /// The independent motions that constraints leave.
    pub mobility: usize,
    /// Those that nothing drives either.
    pub undriven: usize,
    /// The number of redundant constraints.
    pub redundant: usize,
    /// The number of drives that act on what is determined already.
    pub overdriven: usize,
    /// Whether all ranks are certain.
    pub decided: bool,
    /// Whether all numbers were finite; where not, no rank is certain.
    pub finite: bool,
    /// How certain they are.
    pub gap: Gap,
    /// The constraints whose independence is not certain; at most a hundred.
    pub doubtful: Vec<Constraint>,
}

/// The whole assembly.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Assembly {
    /// The step whose boundary conditions and connector motions hold, counted from 1; 0 is before the first.
    pub step: usize,
    /// The degrees of freedom of all nodes of connectors and MPCs.
    pub degrees_of_freedom: usize,
    /// Those of them that boundary conditions hold.
    pub held: usize,
    /// The number of constraints, without boundary conditions.
    pub constraints: usize,
    /// The number of driven components and degrees of freedom.
    pub drives: usize,
    /// Degrees of freedom that nothing holds, less constraints.
    pub gruebler: i64,
    /// The number of parts that have no degree of freedom in common.
    pub parts: usize,
    /// The largest front, in columns: what the elimination cost, or, where there are no positions, would have cost.
    pub largest_front: usize,
    /// The initial state, then those given that were looked at. None where the elimination would have taken too much memory.
    pub positions: Vec<Position>,
    /// Redundant constraints at the initial state.
    pub redundant: Vec<Redundant>,
    /// Drives that act, initially, on what is determined already.
    pub overdriven: Vec<Constraint>,
    /// Motions that nothing drives, at the initial state: at most a thousand.
    pub modes: Vec<Mode>,
    /// Given states that were not looked at, because they do not satisfy the constraints.
    pub off: Vec<u64>,
    /// Constraints that are redundant at a given state and not at the state where the rank is largest, which may be the initial one, with the number
    /// of the state.
    pub redundant_at: Vec<(u64, Constraint)>,
    /// The state from which on nothing was looked at, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_assembled: Option<NotAssembled>,
}

/// A state at which the Jacobian of the constraints could not be assembled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotAssembled {
    /// The number of the state; none for the initial one.
    pub state: Option<u64>,
    /// Why not.
    pub why: String,
}

/// The modes that are named by all nodes that move, of one part.
const MODES: usize = 20;
/// Parts with no more degrees of freedom are moved, to judge where redundancies hold.
const MOVED: usize = 20_000;
/// What is listed.
const LISTED: usize = 1000;
/// Parts of which this many constraints are redundant say what from.
const EXPLAINED: usize = 24;
/// A singular value below this part of the largest that is not zero by rounding is decided by digits that decks do not have.
const DIGITS: f64 = 1e-7;

/// The size (the smaller of rows and columns) up to which singular values of a part are looked at at every state given, not only initially.
const EVERYWHERE: usize = 60;

/// What one part has at one state.
struct Found {
    constraints: Outcome,
    /// Rows of the matrix of constraints.
    rows: Vec<u32>,
    /// With drives: rank beyond that of the constraints, and what is free.
    driven: Option<(Outcome, Vec<u32>)>,
    singular_values: Option<[f64; 2]>,
    matrix: Option<Sparse>,
}

impl Found {
    fn undriven(&self) -> &Outcome {
        self.driven.as_ref().map_or(&self.constraints, |(driven, _)| driven)
    }

    fn overdriven(&self) -> usize {
        let Some((driven, rows)) = &self.driven else { return 0 };
        (rows.len() - self.rows.len()).saturating_sub(driven.rank - self.constraints.rank.min(driven.rank))
    }

    fn is_decided(&self) -> bool {
        let digits = self.singular_values.is_none_or(|[nonzero, _]| nonzero > DIGITS);
        self.constraints.is_decided() && self.undriven().is_decided() && digits
    }
}

/// Looks at an assembly at its initial state and at those given, in a step (counted from 1; 0 is before the first).
///
/// # Errors
/// The points of a `*TRANSFORM` that define no directions.
pub fn analyse(scene: &Scene, model: &Model, states: &[State], step: usize) -> Result<Assembly, Diagnostic> {
    let prescribed = Prescribed::of(scene, step)?;
    let plan = Plan::everything(model, request());
    let system = System::new(model, &plan, &prescribed);
    let start = State::default();
    let mut values = Vec::new();
    if let Err(error) = Sequence::new(model, &plan).assemble(&start, &system.jacobian, &mut values) {
        let not_assembled = Some(NotAssembled { state: None, why: error.to_string() });
        return Ok(Assembly { not_assembled, ..Assembly::none(step) });
    }
    if let Some(largest_front) = system.too_large {
        return Ok(Assembly { largest_front, parts: system.parts.len(), ..Assembly::none(step) });
    }
    let found = look(&system, &values, &[], true);
    let drives = system.roles.iter().filter(|role| **role == Role::Driven).count();
    let all = Jacobian::new(model, &plan, &Fixed::none(), |_, _| false).columns();
    let columns = system.jacobian.columns();
    let constraints = system.origins.len() - drives;
    let mut assembly = Assembly {
        step,
        degrees_of_freedom: all,
        held: all - columns,
        constraints,
        drives,
        gruebler: columns as i64 - constraints as i64,
        parts: system.parts.len(),
        largest_front: found.iter().map(|found| found.constraints.front).max().unwrap_or_default(),
        ..Assembly::none(step)
    };
    let fixed: Vec<u32> =
        system.fixed_rows.iter().copied().filter(|row| system.roles[*row as usize] != Role::Driven).collect();
    assembly.positions.push(position(&system, None, &found, fixed.len()));
    assembly.redundant = redundant(&system, &found, &fixed, &prescribed);
    assembly.overdriven = overdriven(&system, &found);
    assembly.modes = modes(&system, &found);
    given::along(&system, states, &found, fixed.len(), &mut assembly);
    Ok(assembly)
}

impl Assembly {
    fn none(step: usize) -> Self {
        Self {
            step,
            degrees_of_freedom: 0,
            held: 0,
            constraints: 0,
            drives: 0,
            gruebler: 0,
            parts: 0,
            largest_front: 0,
            positions: Vec::new(),
            redundant: Vec::new(),
            overdriven: Vec::new(),
            modes: Vec::new(),
            off: Vec::new(),
            redundant_at: Vec::new(),
            not_assembled: None,
        }
    }
}

/// Looks at every part at one state, whose equations are satisfied but for `residuals` (by row of the system).
fn look(system: &System<'_>, values: &[f64], residuals: &[f64], keep: bool) -> Vec<Found> {
    let of_part = |part: &Part| {
        let worst = part.rows.iter().filter_map(|row| residuals.get(*row as usize));
        let worst = largest(worst);
        let has_drives = part.rows.iter().any(|row| system.roles[*row as usize] == Role::Driven);
        let (rows, matrix) = system.matrix(part, values, |role| role != Role::Driven);
        let task = Task { uncertainty: 30.0 * worst, keep, right: None };
        let constraints = eliminate(&matrix, &part.order, task);
        let driven = has_drives.then(|| {
            let (rows, matrix) = system.matrix(part, values, |_| true);
            (eliminate(&matrix, &part.order, task), rows)
        });
        let is_small = dense::is_small(&matrix, if keep { dense::LARGEST } else { EVERYWHERE });
        let singular_values = is_small.then(|| dense::singular_values(&matrix)).and_then(|values| {
            let largest = values.first().copied().filter(|largest| *largest > 0.0)?;
            let nonzero = values.get(constraints.rank.checked_sub(1)?)?;
            let zero = values.get(constraints.rank).copied().unwrap_or_default();
            Some([nonzero / largest, zero / largest])
        });
        let is_wanted = keep && is_small && !constraints.dependent.is_empty();
        Found { constraints, rows, driven, singular_values, matrix: is_wanted.then_some(matrix) }
    };
    system.parts.par_iter().map(of_part).collect()
}

fn position(system: &System<'_>, state: Option<u64>, found: &[Found], fixed: usize) -> Position {
    let sum = |of: fn(&Found) -> usize| found.iter().map(of).sum::<usize>();
    let outcomes = || found.iter().flat_map(|found| [&found.constraints, found.undriven()]);
    let zero = outcomes().map(|outcome| outcome.gap[0]).fold(0.0, f64::max);
    let nonzero = outcomes().map(|outcome| outcome.gap[1]).fold(f64::INFINITY, f64::min);
    let values = found.iter().filter_map(|found| found.singular_values);
    let singular_values = values.reduce(|x, y| [x[0].min(y[0]), x[1].max(y[1])]);
    let doubtful = found.iter().filter(|found| !found.is_decided()).flat_map(|found| {
        let certain = &found.constraints.doubtful;
        let named = if certain.is_empty() { found.constraints.weakest.as_slice() } else { certain };
        named.iter().map(|row| constraint(system, found.rows[*row as usize]))
    });
    Position {
        state,
        rank: sum(|found| found.constraints.rank),
        mobility: sum(|found| found.constraints.free.len()),
        undriven: sum(|found| found.undriven().free.len()),
        redundant: sum(|found| found.constraints.dependent.len()) + fixed,
        overdriven: sum(Found::overdriven),
        decided: found.iter().all(Found::is_decided),
        finite: outcomes().all(|outcome| !outcome.overflows),
        gap: Gap { zero, nonzero, singular_values },
        doubtful: doubtful.take(100).collect(),
    }
}

fn constraint(system: &System<'_>, row: u32) -> Constraint {
    let role = system.roles[row as usize];
    let none = Constraint { element: None, mpc: None, node: None, component: String::new(), role };
    match system.origins[row as usize] {
        Origin::Boundary(freedom) => {
            Constraint { node: Some(freedom.node), component: freedom.number.to_string(), ..none }
        }
        Origin::Equation(equation) => match equation.source {
            Source::Connector(index) => Constraint {
                element: Some(system.model.connectors[index].label),
                component: COMPONENT[equation.component].to_string(),
                ..none
            },
            Source::Mpc(index) => {
                let mpc = &system.model.mpcs[index];
                let component = mpc.constraint.kind().row_name(equation.component).to_string();
                Constraint { mpc: Some(mpc.title()), component, ..none }
            }
        },
    }
}

/// Names the redundant constraints and judges where they are.
fn redundant(system: &System<'_>, found: &[Found], fixed: &[u32], prescribed: &Prescribed) -> Vec<Redundant> {
    let held = fixed.iter().map(|row| Redundant {
        constraint: constraint(system, *row),
        holds: Holds::Rigid,
        from: Vec::new(),
    });
    let of_parts: Vec<Vec<Redundant>> = system
        .parts
        .par_iter()
        .zip(found)
        .map(|(part, found)| {
            if found.constraints.dependent.is_empty() {
                return Vec::new();
            }
            let (elsewhere, rows) = judge(system, part, found, prescribed);
            let dependent = &found.constraints.dependent;
            let here = only_here(dependent, &elsewhere);
            dependent
                .iter()
                .map(|row| Redundant {
                    constraint: constraint(system, found.rows[*row as usize]),
                    holds: match rows {
                        Holds::Here if !here.contains(row) => Holds::Throughout,
                        holds => holds,
                    },
                    from: match &found.matrix {
                        Some(matrix) if dependent.len() <= EXPLAINED => {
                            let made = dense::made_of(matrix, dependent, *row);
                            made.iter().map(|row| constraint(system, found.rows[*row as usize])).collect()
                        }
                        _ => Vec::new(),
                    },
                })
                .collect()
        })
        .collect();
    held.chain(of_parts.into_iter().flatten()).collect()
}

/// Of dependent rows, as many as are not elsewhere: those that are not named there, the last ones if there are more.
fn only_here(dependent: &[u32], elsewhere: &[u32]) -> Vec<u32> {
    let count = dependent.len().saturating_sub(elsewhere.len());
    let is_gone = |row: &&u32| elsewhere.binary_search(row).is_err();
    dependent.iter().rev().filter(is_gone).take(count).copied().collect()
}

/// Where the redundancies of a part hold, and the rows that are dependent elsewhere too.
fn judge(system: &System<'_>, part: &Part, found: &Found, prescribed: &Prescribed) -> (Vec<u32>, Holds) {
    if found.constraints.free.is_empty() {
        return (found.constraints.dependent.clone(), Holds::Rigid);
    }
    if part.columns.len() > MOVED || found.constraints.fill > eliminate::KEPT {
        return (Vec::new(), Holds::Unjudged);
    }
    // The part by itself: its connectors, constraints and nodes.
    let mut nodes = BTreeSet::new();
    for index in &part.connectors {
        nodes.extend(system.model.connectors[*index].nodes.iter().flatten());
    }
    for index in &part.mpcs {
        nodes.extend(&system.model.mpcs[*index].nodes);
    }
    let connectors = part.connectors.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let mpcs = part.mpcs.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let plan = Plan { connectors, mpcs, nodes, request: request() };
    let own = System::new(system.model, &plan, prescribed);
    let [part] = own.parts.as_slice() else { return (Vec::new(), Holds::Unjudged) };
    let sequence = Sequence::new(system.model, &plan);
    let mut values = Vec::new();
    let start = State::default();
    if sequence.clone().assemble(&start, &own.jacobian, &mut values).is_err() {
        return (Vec::new(), Holds::Unjudged);
    }
    let (_, matrix) = own.matrix(part, &values, |role| role != Role::Driven);
    let here = eliminate(&matrix, &part.order, Task { keep: true, ..Task::default() });
    let elsewhere = elsewhere(&own, part, &sequence, &start, &here);
    (elsewhere.dependent, elsewhere.holds)
}

/// Drives that act on what is determined already.
fn overdriven(system: &System<'_>, found: &[Found]) -> Vec<Constraint> {
    let mut named = Vec::new();
    for found in found {
        let Some((driven, rows)) = found.driven.as_ref().filter(|_| found.overdriven() > 0) else { continue };
        let is_drive = |row: &u32| system.roles[*row as usize] == Role::Driven;
        let dependent = driven.dependent.iter().map(|row| rows[*row as usize]).filter(is_drive);
        let mut of_part: Vec<u32> = dependent.collect();
        if of_part.is_empty() {
            of_part = rows.iter().copied().filter(is_drive).collect();
        }
        named.extend(of_part.into_iter().map(|row| constraint(system, row)));
    }
    named.extend(
        system
            .fixed_rows
            .iter()
            .filter(|row| system.roles[**row as usize] == Role::Driven)
            .map(|row| constraint(system, *row)),
    );
    named
}

/// The motions that are left, and what moves.
fn modes(system: &System<'_>, found: &[Found]) -> Vec<Mode> {
    let freedoms = system.jacobian.freedoms();
    let mut modes = Vec::new();
    for (part, found) in system.parts.iter().zip(found) {
        let outcome = found.undriven();
        for (at, column) in outcome.free.iter().enumerate() {
            if modes.len() >= LISTED {
                return modes;
            }
            let leading = freedoms[part.columns[*column as usize] as usize];
            let is_known = outcome.has_pivots() || outcome.rank == 0;
            if at >= MODES || !is_known {
                modes.push(Mode { leading, nodes: vec![leading.node], moving: None });
                continue;
            }
            let motion =
                outcome.solve(part.columns.len(), |other| f64::from(u8::from(other == *column)), true);
            let mut nodes: Vec<(Label, f64)> = Vec::new();
            for (column, amount) in part.columns.iter().zip(&motion) {
                let node = freedoms[*column as usize].node;
                match nodes.last_mut() {
                    Some((last, most)) if *last == node => *most = most.max(amount.abs()),
                    _ => nodes.push((node, amount.abs())),
                }
            }
            let largest = nodes.iter().map(|(_, amount)| *amount).fold(0.0, f64::max);
            // What rounding leaves of a node that does not move.
            nodes.retain(|(_, amount)| *amount > 1e-9 * largest);
            nodes.sort_by(|x, y| y.1.total_cmp(&x.1).then(x.0.cmp(&y.0)));
            let moving = Some(nodes.len());
            modes.push(Mode {
                leading,
                nodes: nodes.iter().take(20).map(|(node, _)| *node).collect(),
                moving,
            });
        }
    }
    modes
}

/// The largest magnitude; what is no number stays one.
fn largest<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    let larger = |most: f64, x: &f64| if most.is_nan() || x.is_nan() { f64::NAN } else { most.max(x.abs()) };
    numbers.into_iter().fold(0.0, larger)
}

/// The relative change of the matrix that rounding explains: what is smaller counts as zero.
pub const ROUNDING: f64 = eliminate::ROUNDINGS * U;
