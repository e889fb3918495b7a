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
//! | `steps` | in which steps are they others, and which states belong to those? |
//! | `still` | which nodes stand still, or cannot turn, whatever the assembly does? |
//! | `contract` | what moves as one body? |
//! | `order` | in which order are bodies eliminated? |
//! | `eliminate` | what are rank, dependent rows and free columns? |
//! | `naming` | … and which rows may be named? |
//! | `budget` | what may be spent on what follows the rank? |
//! | `echelon` | which rows depend on those before them? |
//! | `krylov` | what are they where elimination would fill the matrix? |
//! | `noise` | what of that is rounding? |
//! | `digits` | what of that do the digits of the scene leave open? |
//! | `dense` | singular values of small parts |
//! | `found` | what has each part, and the whole, at one state? |
//! | `redundant` | which constraints are redundant, and where? |
//! | `modes` | which motions are left? |
//! | `given` | what holds at the states given? |
//! | `moving` | does a redundancy hold elsewhere? |
//! | `second` | … which of the free motions does second order exclude? |
//! | `once` | … of a large part? |
//! | `local` | … where the part could not be moved as a whole? |
//! | `unread` | which constraints of the deck were not read? |
//! | `findings` | what is said of it? |

mod budget;
mod contract;
mod dense;
pub(super) mod digits;
mod echelon;
mod eliminate;
pub(super) mod findings;
mod found;
mod given;
mod krylov;
mod local;
mod modes;
mod moving;
mod naming;
mod noise;
mod once;
mod order;
mod redundant;
mod second;
mod sparse;
pub(super) mod steps;
pub(super) mod still;
mod system;
#[cfg(test)]
mod tests;
mod unread;

pub use system::Role;
pub use unread::{Place, Unread};

use crate::audit::bound::U;
use crate::evaluate::{Fixed, Freedom, Jacobian, Model, Plan, Sequence};
use crate::scene::{Diagnostic, Label, Scene, State};
use budget::Budget;
use found::{look, overdriven, position};
use serde::{Serialize, Serializer};
use std::fmt::{self, Display};
use system::{Prescribed, System, request};

/// Where a redundancy holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Holds {
    /// At every state that was looked at: judged to hold wherever the part can move.
    Throughout,
    /// The same, each of them a singular position: motions that are free to first order because of it are excluded to second order.
    Singular,
    /// The part cannot move at all: there is no other state.
    Rigid,
    /// At this state, and not at another admissible one: proven, to rounding.
    Here,
    /// At this state, and not at another one given, to the digits of these states.
    Differs,
    /// At a singular position: motions that are free to first order because of it are excluded to second order.
    Isolated,
    /// At this state, and not at others that its neighbourhood, cut out of a part that could not be moved as a whole, can go to: at this one only, unless
    /// the rest of the assembly keeps it here.
    Loop,
    /// It was not judged: the part could not be moved as a whole, and of the neighbourhoods that were looked at none has all it follows from.
    Large,
    /// It was not judged, or not to the end, for what may be spent on it was ([`Spent`]).
    Spent,
    /// It could not be judged.
    Unjudged,
}

impl Holds {
    /// Whether it holds wherever the part can be.
    pub const fn is_throughout(self) -> bool {
        matches!(self, Self::Throughout | Self::Singular | Self::Rigid)
    }

    /// In words, with what it rests on.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Throughout => {
                "it holds throughout (judged: the same at other states that the assembly was moved to)"
            }
            Self::Singular => {
                "it holds throughout (judged: the same at other states that the assembly was moved to), at a singular position wherever that is: \
                 second order excludes motions that are free to first order because of it"
            }
            Self::Rigid => "it holds throughout (what belongs to it cannot move)",
            Self::Here => {
                "it holds at this state and not at every other (proven to rounding: at another admissible state it does not)"
            }
            Self::Differs => {
                "it holds at this state and not at another one given, to the digits of these (they satisfy the constraints to no more)"
            }
            Self::Isolated => {
                "it holds at this singular position (second order excludes the motions that are free to first order because of it)"
            }
            Self::Loop => {
                "it holds at this state, and not at others that the connectors about it can go to (proven to rounding; the whole could not \
                 be moved): at this one only, unless the rest of the assembly keeps them here"
            }
            Self::Large => {
                "whether it holds at other states was not judged: the part could not be moved as a whole, and what it follows from was not found among the \
                 connectors about it, of up to 20 000 degrees of freedom, or not looked for, for there are too many like it: audit its loop as a scene of \
                 its own"
            }
            Self::Spent => {
                "whether it holds at other states was not judged: the operations that may be spent on that, of those of the assembly the share of its part, were spent"
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
    /// Its place among the constraints of the model that are evaluated.
    #[serde(skip)]
    pub index: Option<usize>,
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
    /// Whether the rank of its part is certain. Where it is not, the constraint is redundant if what was taken for zero is zero.
    pub decided: bool,
    /// Whether boundary conditions hold all that it would: then it follows from them alone.
    pub held: bool,
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
    /// Whether the rank of its part is certain. Where it is not, this is a motion if what was taken for zero is zero.
    pub decided: bool,
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

/// The assembly at one state. Numbers are `None` where a part was not looked at ([`Skipped`]).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Position {
    /// The number of the state; none for the initial one.
    pub state: Option<u64>,
    /// The rank of the constraints.
    pub rank: Option<usize>,
    /// The independent motions that constraints leave.
    pub mobility: Option<usize>,
    /// Those that nothing drives either.
    pub undriven: Option<usize>,
    /// Those of them that belong to parts whose rank is not certain: as many if what was taken for zero is zero.
    pub undriven_undecided: usize,
    /// The number of redundant constraints.
    pub redundant: Option<usize>,
    /// The number of drives that act on what is determined already.
    pub overdriven: Option<usize>,
    /// Whether all ranks are known and certain.
    pub decided: bool,
    /// Whether all numbers were finite; where not, no rank is certain.
    pub finite: bool,
    /// How certain they are.
    pub gap: Gap,
    /// The constraints whose independence, or dependence, is not certain; at most a hundred.
    pub doubtful: Vec<Constraint>,
    /// The constraints that have no derivative at this state, or one without digits: they may hold, and do not show in the Jacobian. Not called redundant; at
    /// most a hundred.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub without_derivative: Vec<Constraint>,
    /// Whether, of a given state, the rank or the number of motions of a part is another than initially: what is redundant and what moves
    /// is named then, up to a thousand in all.
    pub differs: bool,
    /// Redundant constraints at a given state that differs; at the initial one, [`Assembly::redundant`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub dependent: Vec<Redundant>,
    /// Motions that nothing drives, at a given state that differs; at the initial one, [`Assembly::modes`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub modes: Vec<Mode>,
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
    /// The largest front, in columns: what the elimination cost.
    pub largest_front: usize,
    /// Parts that were not looked at, for their elimination would have taken more than 1.3 GB, or longer than some 40 s.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub skipped: Vec<Skipped>,
    /// The initial state, then those given that were looked at.
    pub positions: Vec<Position>,
    /// Redundant constraints at the initial state.
    pub redundant: Vec<Redundant>,
    /// Those of them that are counted, and not named.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unnamed: Option<Unnamed>,
    /// Drives that act, initially, on what is determined already.
    pub overdriven: Vec<Constraint>,
    /// Motions that nothing drives, at the initial state: at most a thousand.
    pub modes: Vec<Mode>,
    /// Given states that were not looked at, because they do not satisfy the constraints.
    pub off: Vec<u64>,
    /// Given states that were not looked at, because they move what boundary conditions hold.
    pub off_boundary: Vec<u64>,
    /// Constraints that are redundant at a given state and not at the state where the rank is largest, which may be the initial one, with the number
    /// of the state, and whether that is proven ([`Holds::Here`]) or so to the digits of the states ([`Holds::Differs`]).
    pub redundant_at: Vec<(u64, Constraint, Holds)>,
    /// What was spent to judge where redundancies hold, where that was not enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spent: Option<Spent>,
    /// Constraints of the deck that are not read: where there are any, what is certain is so of what was read.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unread: Vec<Unread>,
    /// The state from which on nothing was looked at, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_assembled: Option<NotAssembled>,
}

/// A part that was not looked at.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Skipped {
    /// The number of its connectors.
    pub connectors: usize,
    /// The number of its multi-point constraints.
    pub mpcs: usize,
    /// Its degrees of freedom that nothing holds.
    pub degrees_of_freedom: usize,
    /// The number of its constraints and drives.
    pub constraints: usize,
    /// Its first node.
    pub node: Label,
    /// The columns of the front at which it was given up.
    pub front: usize,
}

/// What was spent to judge where redundancies hold: operations, each some 10 ns of processor, and not time, so that the same is judged everywhere.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Spent {
    /// The operations.
    pub operations: u64,
    /// How many may be.
    pub most: u64,
}

/// Redundant constraints that are counted, and not named.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Unnamed {
    /// Their number.
    pub count: usize,
    /// Why not.
    pub why: WhyUnnamed,
    /// What was spent on the names of the parts for which that was not enough.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spent: Option<Spent>,
}

/// Why redundant constraints are not named.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum WhyUnnamed {
    /// The rank came of products with the matrix, and to eliminate it for the names is predicted to cost too much.
    Dear,
    /// As many rows that depend on those before them were not found as the rank says.
    Numbers,
    /// They were not sought to the end, for the operations that may be spent on that, of those of the assembly the share of its part, were spent.
    Spent,
}

impl WhyUnnamed {
    /// In words.
    pub const fn meaning(self) -> &'static str {
        match self {
            Self::Dear => {
                "the rank came of products with the matrix, and elimination, which names them, would take too long"
            }
            Self::Spent => {
                "the operations that may be spent on their names, of those of the assembly the share of their part, were spent"
            }
            Self::Numbers => "rows were not found, as many as the rank says, without which it is the same",
        }
    }
}

/// A state at which the Jacobian of the constraints could not be assembled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct NotAssembled {
    /// The number of the state; none for the initial one.
    pub state: Option<u64>,
    /// Why not.
    pub why: String,
}

/// What is listed.
const LISTED: usize = 1000;

/// Looks at an assembly at its initial state and at those given, in a step (counted from 1; 0 is before the first).
///
/// # Errors
/// The points of a `*TRANSFORM` that define no directions.
pub fn analyse(scene: &Scene, model: &Model, states: &[State], step: usize) -> Result<Assembly, Diagnostic> {
    let found = in_step(model, states, step, &Prescribed::of(scene, step)?, &|_| true);
    Ok(Assembly { unread: unread::unread(scene), ..found })
}

/// Looks at an assembly in its first step, and in all whose boundary conditions or connector motions are not those of the step before: at
/// its initial state, and at those given that belong to the step by their time, or to those after it that prescribe the same. States
/// whose time is not known, and all where the period of a step is not, count as of the first.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_steps(scene: &Scene, model: &Model, states: &[State]) -> Result<Vec<Assembly>, Diagnostic> {
    let steps = steps::differing(scene)?;
    let ends = steps::ends(scene);
    let next = steps.iter().skip(1).map(|(step, _)| *step).chain([usize::MAX]);
    let unread = unread::unread(scene);
    let found = steps.iter().zip(next).map(|((step, prescribed), next)| {
        let is_of = |state: &State| (*step..next).contains(&steps::of_state(ends.as_deref(), state));
        Assembly { unread: unread.clone(), ..in_step(model, states, *step, prescribed, &is_of) }
    });
    Ok(found.collect())
}

/// Looks at those states that are of a step, following all.
fn in_step(
    model: &Model,
    states: &[State],
    step: usize,
    prescribed: &Prescribed,
    is_of: &dyn Fn(&State) -> bool,
) -> Assembly {
    let plan = Plan::everything(model, request());
    let system = System::new(model, &plan, prescribed);
    let mut assembly = Assembly::none(step);
    of_system(&system, states, is_of, &mut assembly);
    assembly
}

fn of_system(system: &System<'_>, states: &[State], is_of: &dyn Fn(&State) -> bool, assembly: &mut Assembly) {
    let drives = system.roles.iter().filter(|role| **role == Role::Driven).count();
    let columns = system.jacobian.columns();
    let constraints = system.origins.len() - drives;
    let all = Jacobian::new(system.model, system.plan, &Fixed::none(), |_, _| false).columns();
    assembly.degrees_of_freedom = all;
    assembly.held = all - columns;
    assembly.constraints = constraints;
    assembly.drives = drives;
    assembly.gruebler = columns as i64 - constraints as i64;
    assembly.parts = system.parts.len();
    let mut sequence = Sequence::new(system.model, system.plan);
    let mut values = Vec::new();
    if let Err(error) = sequence.assemble(&State::default(), &system.jacobian, &mut values) {
        assembly.not_assembled = Some(NotAssembled { state: None, why: error.to_string() });
        return;
    }
    let without_derivative =
        system.without_derivative(&Sequence::new(system.model, system.plan), &State::default());
    let found = look(system, (&State::default(), &values), (&[], &without_derivative), true);
    let skipped =
        system.parts.iter().zip(&found).filter_map(|(part, found)| Some((part, found.as_ref().err()?)));
    assembly.skipped = skipped.filter_map(|(part, front)| system.skipped(part, *front)).collect();
    assembly.largest_front =
        found.iter().flatten().map(|found| found.constraints.front).max().unwrap_or_default();
    let is_held = |row: &u32| system.roles[*row as usize] != Role::Driven;
    let fixed: Vec<u32> = system.fixed_rows.iter().copied().filter(is_held).collect();
    assembly.positions.push(position(system, None, &found, fixed.len()));
    let budget = Budget::of(columns);
    assembly.redundant = redundant::redundant(system, &found, &fixed, &budget);
    if assembly.redundant.iter().any(|one| one.holds == Holds::Spent) {
        assembly.spent = Some(Spent { operations: budget.spent(), most: budget.most() });
    }
    assembly.unnamed = redundant::unnamed(&found);
    assembly.overdriven = overdriven(system, &found);
    assembly.modes = modes::modes(system, &found);
    given::along(system, (states, is_of), &found, fixed.len(), assembly);
}

impl Assembly {
    /// Whether the assembly was looked at as a whole and at all states given, and all ranks are certain.
    pub fn is_decided(&self) -> bool {
        self.not_assembled.is_none()
            && self.off.is_empty()
            && self.off_boundary.is_empty()
            && !self.positions.is_empty()
            && self.positions.iter().all(|position| position.decided)
    }

    const fn none(step: usize) -> Self {
        Self {
            step,
            degrees_of_freedom: 0,
            held: 0,
            constraints: 0,
            drives: 0,
            gruebler: 0,
            parts: 0,
            largest_front: 0,
            skipped: Vec::new(),
            positions: Vec::new(),
            redundant: Vec::new(),
            unnamed: None,
            overdriven: Vec::new(),
            modes: Vec::new(),
            off: Vec::new(),
            off_boundary: Vec::new(),
            redundant_at: Vec::new(),
            spent: None,
            unread: Vec::new(),
            not_assembled: None,
        }
    }
}

/// The largest magnitude; what is no number stays one.
fn largest<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> f64 {
    let larger = |most: f64, x: &f64| if most.is_nan() || x.is_nan() { f64::NAN } else { most.max(x.abs()) };
    numbers.into_iter().fold(0.0, larger)
}

/// The relative change of the matrix that rounding explains: what is smaller counts as zero.
pub const ROUNDING: f64 = eliminate::ROUNDINGS * U;
