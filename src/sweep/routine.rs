//! Somebody's routine in place of pintle's own numbers.
//!
//! It is asked for values and rows at every state, 32 states of one connector at a time. Each thread has a routine of its own for each connector.
//!
//! Every state follows the initial one, and how angles go on is a matter of histories. So whole turns are no error, and other angles of the same
//! rotation are not judged. Nor is what is no number on a singular set that is not removable.

use crate::SweepError;
use crate::summary::Summary;
use crate::sweep::Sweep;
use pintle_audit::{Case, Given, Quantity, Question, values_before};
use pintle_kinematics::connector::Definition;
use std::sync::{Mutex, PoisonError};

/// Somebody's routine, opened for one connector.
pub trait Routine: Send {
    /// The numbers at these states; `None` outside its domain.
    ///
    /// # Errors
    /// In words, where it does not answer as it should.
    fn ask(&mut self, asked: &[Question<'_>]) -> Result<Vec<Option<Given>>, String>;

    /// What it offers.
    fn offers(&self) -> &[Quantity];

    /// Of which components.
    fn components(&self) -> [bool; 6];
}

/// Opens a routine for a connector.
type Opens<'a> = dyn Fn(&'a Definition) -> Result<Box<dyn Routine + 'a>, String> + Sync + 'a;

/// Routines that have been opened, each for the connector at a place of the plan.
pub struct Routines<'a> {
    sweep: &'a Sweep,
    opens: Box<Opens<'a>>,
    idle: Mutex<Vec<(usize, Box<dyn Routine + 'a>)>>,
}

impl std::fmt::Debug for Routines<'_> {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.debug_struct("Routines").field("sweep", self.sweep).finish_non_exhaustive()
    }
}

/// What numbers are due.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Due {
    pub(crate) values: bool,
    pub(crate) rows: bool,
    pub(crate) components: [bool; 6],
}

impl<'a> Routines<'a> {
    /// Of a sweep, opened as they are needed.
    pub fn new(
        sweep: &'a Sweep,
        opens: impl Fn(&'a Definition) -> Result<Box<dyn Routine + 'a>, String> + Sync + 'a,
    ) -> Self {
        Self { sweep, opens: Box::new(opens), idle: Mutex::default() }
    }

    /// As [`Sweep::run`], of the numbers of the routine.
    ///
    /// # Errors
    /// As there, and [`SweepError::Routine`].
    pub fn run(
        &self,
        first: u64,
        count: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Summary, SweepError> {
        self.sweep.run_of(first, count, progress, Some(self))
    }

    /// The numbers at the ends of cases, with their indices, of the connector at a place.
    pub(crate) fn ask(
        &self,
        place: usize,
        cases: &[(u64, Case)],
    ) -> Result<(Vec<Option<Given>>, Due), SweepError> {
        let known = {
            let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
            let at = idle.iter().position(|(of, _)| *of == place);
            at.map(|at| idle.swap_remove(at).1)
        };
        let mut routine = match (known, self.sweep.definition_at(place)) {
            (Some(routine), _) => routine,
            (None, Some(definition)) => (self.opens)(definition).map_err(SweepError::Routine)?,
            (None, None) => return Err(SweepError::Plan("it has no connector".into())),
        };
        let offers = routine.offers();
        let wants: Vec<Quantity> = [Quantity::Value, Quantity::FirstDerivatives]
            .into_iter()
            .filter(|quantity| offers.contains(quantity))
            .collect();
        if wants.is_empty() {
            return Err(SweepError::Routine(
                "the routine offers neither values nor rows: a sweep asks for nothing else".into(),
            ));
        }
        let before = cases.first().map_or([None; 6], |(_, case)| values_before(case));
        let wanted = wants.as_slice();
        let asked = cases.iter().filter_map(|(index, case)| {
            let number = usize::try_from(*index).ok()?;
            let (step, path) = case.path.split_last()?;
            Some(Question { number, step, path, values_before: before, wants: wanted, is_drawn: true })
        });
        let asked: Vec<Question<'_>> = asked.collect();
        let answers = routine.ask(&asked).map_err(SweepError::Routine)?;
        let due = Due {
            values: wants.contains(&Quantity::Value),
            rows: wants.contains(&Quantity::FirstDerivatives),
            components: routine.components(),
        };
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push((place, routine));
        Ok((answers, due))
    }
}
