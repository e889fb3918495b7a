//! The whole assembly: how many degrees of freedom has it, how can it move, which of its constraints are redundant?
//!
//! One matrix J over the nodal degrees of freedom has a row for each:
//! - equation that a connector or a multi-point constraint enforces;
//! - component that a connector motion holds;
//! - degree of freedom that a boundary condition holds.
//!
//! The assembly allows the motions q̇ of the nodes with J q̇ = 0. Lengths are divided by the mean length of the connectors of a
//! connected component, so that J has no dimension.
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
//! admissible state without it. That it holds throughout is judged from several random ones that the assembly was moved to, and from
//! the states given ([`Holds`]). Stops, locks, failures and friction are not looked at.
//!
//! | module | question |
//! |---|---|
//! | `facts` | what is told of an assembly? |
//! | `steps` | when do steps end, and which states belong to them? |
//! | `prescribed` | what is prescribed in a step, and in which steps is that something else? |
//! | `system` | what are the equations, and which belong together? |
//! | `matrix` | what are rank, dependent rows and free columns, and how certain are they? |
//! | `found` | what has each connected component, and the whole, at one state? |
//! | `redundant` | which constraints are redundant, and where? |
//! | `moving` | does a redundancy hold elsewhere? |
//! | `second` | … which of the free motions does second order exclude? |
//! | `modes` | which motions are left? |
//! | `given` | what holds at the states given? |
//! | `unread` | which constraints of the deck were not read? |

pub mod facts;
mod found;
mod given;
pub mod matrix;
pub mod modes;
mod moving;
pub mod prescribed;
pub mod redundant;
mod second;
pub mod steps;
pub mod system;
#[cfg(test)]
mod tests;
mod unread;

pub use facts::{
    Assembly, Constraint, Gap, Holds, Line, Mode, NotAssembled, OPERATIONS, Position, Redundant, Role,
    Skipped, Spent, Unread,
};

use found::{look, overdriven, position};
use matrix::budget::Budget;
use matrix::eliminate;
use pintle_kinematics::scalar::U;
use pintle_model::evaluate::{Fixed, Jacobian, Model, Plan, Sequence};
use pintle_scene::{Diagnostic, Scene, State};
use prescribed::{Prescribed, differing};
use system::{System, request};

/// Looks at an assembly at its initial state and at those given, in a step (counted from 1; 0 is before the first).
///
/// # Errors
/// The points of a `*TRANSFORM` that define no directions.
pub fn analyse(scene: &Scene, model: &Model, states: &[State], step: usize) -> Result<Assembly, Diagnostic> {
    let found = in_step(model, states, step, &Prescribed::of(scene, step)?, &|_| true);
    Ok(Assembly { unread: unread::unread(scene), ..found })
}

/// Looks at an assembly in its first step, and in all whose boundary conditions or connector motions are not those of the step
/// before. In each it looks at the initial state, and at those given that belong to the step by their time, or to those after it
/// that prescribe the same. States whose time is not known, and all where the period of a step is not, count as of the first.
///
/// # Errors
/// As [`analyse`].
pub fn analyse_steps(scene: &Scene, model: &Model, states: &[State]) -> Result<Vec<Assembly>, Diagnostic> {
    let steps = differing(scene)?;
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
    assembly.connected_components = system.components.len();
    let mut sequence = Sequence::new(system.model, system.plan);
    let mut values = Vec::new();
    if let Err(error) = sequence.assemble(&State::default(), &system.jacobian, &mut values) {
        assembly.not_assembled = Some(NotAssembled { state: None, why: error.to_string() });
        return;
    }
    let without_derivative =
        system.without_derivative(&Sequence::new(system.model, system.plan), &State::default());
    let found = look(system, (&State::default(), &values), (&[], &without_derivative), true);
    let skipped = system.components.iter().zip(&found).filter(|(_, found)| found.is_none());
    assembly.skipped = skipped.filter_map(|(component, _)| system.skipped(component)).collect();
    assembly.largest_front =
        found.iter().flatten().map(|found| found.constraints.front).max().unwrap_or_default();
    let is_held = |row: &u32| system.roles[*row as usize] != Role::Driven;
    let fixed: Vec<u32> = system.fixed_rows.iter().copied().filter(is_held).collect();
    assembly.positions.push(position(system, None, &found, fixed.len()));
    let budget = Budget::of(columns);
    assembly.redundant = redundant::redundant(system, &found, &fixed, &budget);
    if assembly.redundant.iter().any(|one| one.holds == Holds::Spent) {
        assembly.spent = Some(budget.told());
    }
    assembly.unnamed = redundant::unnamed(&found);
    (assembly.overdriven, assembly.driven_besides) = overdriven(system, &found);
    assembly.modes = modes::modes(system, &found);
    given::along(system, (states, is_of), &found, fixed.len(), assembly);
}

/// The relative change of the matrix that rounding explains: what is smaller counts as zero.
pub const ROUNDING: f64 = eliminate::ROUNDINGS * U;
