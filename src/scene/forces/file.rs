//! Files of component forces: held as a whole, or read state by state.

use crate::diagnostic::{Code, Diagnostic, Result};
use crate::forces::{Group, Take, document, table};
use crate::model::Scene;
use crate::model::State;
use crate::model::{ForceSign, StateForces};
use crate::states;
use crate::states::{Source, StateMark};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// How close the time of forces must be to that of a state, as a part of the largest time: exports have six or seven digits.
const SAME_TIME: f64 = 1e-6;

/// A file of component forces.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ForceFile {
    name: String,
    groups: Vec<Group>,
}

impl ForceFile {
    /// Reads component forces of `scene` from a `.csv` or `.json` file.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn read(path: impl AsRef<Path>, scene: &Scene, sign: ForceSign) -> Result<Self> {
        let (name, text, is_json) = states::text_of(path.as_ref(), "forces")?;
        if is_json {
            Self::parse_json(&name, &text, scene, sign)
        } else {
            Self::parse_csv(&name, &text, scene, sign)
        }
    }

    /// Reads forces from CSV. `name` stands for the file in messages.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn parse_csv(name: &str, text: &str, scene: &Scene, sign: ForceSign) -> Result<Self> {
        let text = states::without_mark(text);
        Self::collect(name, |take| table::groups(Source::Text(text), scene, sign, take))
            .map_err(|error| states::located(error, name, text))
    }

    /// Reads forces from JSON. `name` stands for the file in messages.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a remedy.
    pub fn parse_json(name: &str, text: &str, scene: &Scene, sign: ForceSign) -> Result<Self> {
        let text = states::without_mark(text);
        Self::collect(name, |take| document::groups(Source::Text(text), scene, sign, take))
            .map_err(|error| states::located(error, name, text))
    }

    fn collect(name: &str, read: impl FnOnce(&mut Take<'_>) -> Result<()>) -> Result<Self> {
        let mut groups = Vec::new();
        read(&mut |group| {
            groups.push(group);
            ControlFlow::Continue(())
        })?;
        Ok(Self { name: name.to_string(), groups })
    }

    /// Gives the forces to the states they belong to; states without numbers of their own count from `first`.
    ///
    /// # Errors
    /// Forces of a state that there is not, of a time that no state or several have, or of a state that has forces already.
    pub fn attach(&self, states: &mut [State], first: u64) -> Result<()> {
        let marks: Vec<StateMark> = states.iter().map(StateMark::of).collect();
        for (index, forces) in self.assign(&StateIndex::new(&marks, first))? {
            if let Some(state) = states.get_mut(index) {
                state.forces.clone_from(&forces.elements);
                state.mpc_forces.clone_from(&forces.mpcs);
            }
        }
        Ok(())
    }

    /// The forces by the places of the states they belong to, of states that are known by their marks only.
    ///
    /// # Errors
    /// Those of [`ForceFile::attach`].
    pub fn assign(&self, states: &StateIndex<'_>) -> Result<BTreeMap<usize, &StateForces>> {
        let mut reading = Reading::of(states);
        let (mut assigned, mut errors) = (BTreeMap::new(), Vec::new());
        for group in &self.groups {
            match reading.place(group) {
                Ok(Some(place)) => {
                    assigned.insert(place, &group.forces);
                }
                Ok(None) => {}
                Err(error) => errors.push(error.in_file(&self.name)),
            }
        }
        Diagnostic::joined(errors).map_or(Ok(assigned), Err)
    }

    /// The name of the file.
    pub fn name(&self) -> &str {
        &self.name
    }
}

/// A file of component forces that is read as often as it is asked for, one state at a time: of the forces it holds those of one state,
/// however many there are. What it is told of the states, by which it finds them, is the caller's: a [`StateIndex`] of all.
#[derive(Clone, Debug)]
pub struct ForceStream {
    path: PathBuf,
    is_json: bool,
    sign: ForceSign,
}

impl ForceStream {
    /// A `.csv` or `.json` file. Nothing is read yet.
    ///
    /// # Errors
    /// A name with another ending.
    pub fn open(path: impl AsRef<Path>, sign: ForceSign) -> Result<Self> {
        let path = path.as_ref();
        Ok(Self { path: path.to_path_buf(), is_json: states::is_json(path, "forces")?, sign })
    }

    /// Whether the file can be read more than once: not so a pipe.
    pub fn is_repeatable(&self) -> bool {
        self.path.metadata().is_ok_and(|metadata| metadata.is_file())
    }

    /// Reads the file from its beginning and hands on its forces, one state after another in the order of the file, each with the place of
    /// the state that it belongs to. What comes before a place where something is wrong has been handed on. While it reads, it keeps a bit
    /// for each state: whether that has got forces.
    ///
    /// # Errors
    /// All that is wrong with the file, each with its place and a remedy; those of [`ForceFile::attach`]; the first error of `take`,
    /// after which nothing more is read.
    pub fn for_each<E: From<Diagnostic>>(
        &self,
        scene: &Scene,
        states: &StateIndex<'_>,
        mut take: impl FnMut(usize, StateForces) -> Result<(), E>,
    ) -> Result<(), E> {
        let located = |error| E::from(states::located_in(&self.path, error));
        let mut reading = Reading::of(states);
        let (mut failure, mut misplaced) = (None, None::<Diagnostic>);
        let mut each = |group: Group| match reading.place(&group) {
            Ok(Some(place)) => match take(place, group.forces) {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    failure = Some(error);
                    ControlFlow::Break(())
                }
            },
            Ok(None) => ControlFlow::Continue(()),
            Err(error) => {
                misplaced = Diagnostic::joined(misplaced.take().into_iter().chain([error]));
                ControlFlow::Continue(())
            }
        };
        let source = Source::File(&self.path);
        let read = match self.is_json {
            true => document::groups(source, scene, self.sign, &mut each),
            false => table::groups(source, scene, self.sign, &mut each),
        };
        match failure {
            Some(error) => Err(error),
            None => Diagnostic::joined(misplaced.into_iter().chain(read.err()))
                .map_or(Ok(()), |error| Err(located(error))),
        }
    }
}

fn fail(code: Code, group: &Group, message: String, remedy: &str) -> Diagnostic {
    Diagnostic::error(code, group.span, message, "here").help(remedy)
}

/// States by number and by time, found once for however many readings of forces: 16 bytes for each, and 16 more for one with a time.
#[derive(Clone, Debug)]
pub struct StateIndex<'a> {
    states: &'a [StateMark],
    first: u64,
    /// In order of the numbers, of equal ones in order of the states.
    numbers: Vec<(u64, usize)>,
    /// In order of time.
    times: Vec<(f64, usize)>,
}

impl<'a> StateIndex<'a> {
    /// The index of states that are known by their marks; those without numbers of their own count from `first`.
    pub fn new(states: &'a [StateMark], first: u64) -> Self {
        let numbered = (first..).zip(states).enumerate();
        let mut numbers: Vec<(u64, usize)> =
            numbered.map(|(index, (counted, state))| (state.number.unwrap_or(counted), index)).collect();
        numbers.sort_unstable();
        let timed = states.iter().enumerate();
        let mut times: Vec<(f64, usize)> =
            timed.filter_map(|(index, state)| Some((state.time?, index))).collect();
        times.sort_by(|(one, _), (other, _)| one.total_cmp(other));
        Self { states, first, numbers, times }
    }

    /// The state with a number, of several the last.
    fn numbered(&self, number: u64) -> Option<usize> {
        let after = self.numbers.partition_point(|(known, _)| *known <= number);
        let (known, index) = self.numbers.get(after.checked_sub(1)?)?;
        (*known == number).then_some(*index)
    }
}

/// One reading of forces: which states have got theirs.
struct Reading<'a> {
    states: &'a StateIndex<'a>,
    /// A bit for each state.
    given: Vec<u64>,
}

impl<'a> Reading<'a> {
    fn of(states: &'a StateIndex<'a>) -> Self {
        Self { states, given: vec![0; states.states.len().div_ceil(64)] }
    }

    /// The place of the state that forces belong to; `None` where they give nothing.
    fn place(&mut self, group: &Group) -> Result<Option<usize>> {
        let StateIndex { states, first, .. } = self.states;
        let index = self.states.index(group)?;
        let (Some(state), Some(bits)) = (states.get(index), self.given.get_mut(index / 64)) else {
            return Ok(None);
        };
        let bit = 1 << (index % 64);
        if state.has_forces || *bits & bit != 0 {
            let number = state.number.unwrap_or(first + index as u64);
            let message = format!("state {number} is given forces twice");
            let remedy = "keep one of them: in the file of states or in that of forces, once";
            return Err(fail(Code::ForcesRepeatedElement, group, message, remedy));
        }
        if group.forces.elements.is_empty() && group.forces.mpcs.is_empty() {
            return Ok(None);
        }
        *bits |= bit;
        Ok(Some(index))
    }
}

impl StateIndex<'_> {
    /// The place of the state that forces are said to belong to.
    fn index(&self, group: &Group) -> Result<usize> {
        let Self { states, .. } = self;
        let fail =
            |message: String, remedy: &str| Err(fail(Code::ForcesUnknownState, group, message, remedy));
        let remedy = "give the numbers of the states, as `pintle eval` prints them, in `state`";
        match (group.state, group.time) {
            (Some(number), _) => {
                let Some(index) = self.numbered(number) else {
                    let [lowest, highest] = self.range();
                    let message = format!("forces of state {number}: the states are {lowest} to {highest}");
                    return fail(message, remedy);
                };
                match (group.time, states.get(index).and_then(|state| state.time)) {
                    (Some(given), Some(time)) if (given - time).abs() > self.tolerance(given) => fail(
                        format!("forces of state {number} at time {given}, which is at {time}"),
                        "leave out `time` or `state`, or correct one of them",
                    ),
                    _ => Ok(index),
                }
            }
            (None, Some(given)) => match self.at(given) {
                [(_, index)] => Ok(*index),
                [] => fail(format!("no state has the time {given} of these forces"), remedy),
                several => {
                    fail(format!("{} states have the time {given} of these forces", several.len()), remedy)
                }
            },
            (None, None) if states.len() == 1 => Ok(0),
            (None, None) => {
                fail(format!("forces without a state, and there are {} states", states.len()), remedy)
            }
        }
    }

    fn range(&self) -> [u64; 2] {
        [self.numbers.first(), self.numbers.last()].map(|found| found.map_or(0, |(number, _)| *number))
    }

    fn tolerance(&self, given: f64) -> f64 {
        let ends = [self.times.first(), self.times.last()].into_iter().flatten();
        SAME_TIME * ends.fold(given.abs(), |most, (time, _)| most.max(time.abs()))
    }

    fn at(&self, given: f64) -> &[(f64, usize)] {
        let tolerance = self.tolerance(given);
        let from = self.times.partition_point(|(time, _)| *time < given - tolerance);
        let to = self.times.partition_point(|(time, _)| *time <= given + tolerance);
        self.times.get(from..to).unwrap_or_default()
    }
}
