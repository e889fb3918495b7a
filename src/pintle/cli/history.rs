//! The states and forces of a run: held, or read from their files one state at a time, as often as they are needed.

use super::compare::is_of_another;
use super::{Failure, compare};
use pintle_scene::{
    Degrees, Diagnostic, ElementForces, ForceFile, ForceSign, ForceStream, Label, Scene, State, StateFile,
    StateForces, StateIndex, StateMark, StateStream, Vanishing,
};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::mpsc::{Receiver, sync_channel};
use std::thread;

/// States in order.
pub(crate) enum History {
    /// All of them.
    Held(Vec<State>),
    /// A file, of which one state is held at a time.
    File(StateStream),
}

impl History {
    /// The states of a file. What cannot be read twice, such as a pipe, is held.
    pub(crate) fn open(path: &Path, scene: &Scene) -> Result<Self, Failure> {
        if is_of_another(path) {
            return Ok(Self::Held(compare::states(path, scene)?));
        }
        let stream = StateStream::open(path)?;
        // What is not there is said by its reader.
        if stream.is_repeatable() || !path.exists() {
            return Ok(Self::File(stream));
        }
        Ok(Self::Held(StateFile::read(path, scene)?.states))
    }

    /// Hands on the states, one after another.
    pub(crate) fn each(
        &self,
        scene: &Scene,
        mut take: impl FnMut(&State) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        match self {
            Self::Held(states) => states.iter().try_for_each(take),
            Self::File(stream) => stream.for_each(scene, |state| take(&state)),
        }
    }

    /// Reads them all, and says what has to be known of them before the first is evaluated.
    pub(crate) fn survey(&self, scene: &Scene) -> Result<Survey, Failure> {
        let mut survey = Survey::default();
        self.each(scene, |state| {
            let number = state.number.unwrap_or(survey.marks.len() as u64);
            survey.vanishing.see(number, state);
            survey.degrees.see(number, state);
            survey.marks.push(StateMark::of(state));
            survey.moves |= state.has_rates();
            Ok(())
        })?;
        Ok(survey)
    }
}

/// What is known of states once all have been read: a few bytes for each.
#[derive(Default)]
pub(crate) struct Survey {
    /// What each is called.
    pub(crate) marks: Vec<StateMark>,
    /// Whether any has rates.
    pub(crate) moves: bool,
    /// Which nodes are left out that were moved.
    pub(crate) vanishing: Vanishing,
    /// Which angles look like degrees.
    pub(crate) degrees: Degrees,
}

impl Survey {
    /// Whether any has forces of its own.
    pub(crate) fn has_forces(&self) -> bool {
        self.marks.iter().any(|mark| mark.has_forces)
    }

    /// The numbers of the states; those that have none are counted from `first`.
    pub(crate) fn numbers(&self, first: u64) -> Vec<u64> {
        (first..).zip(&self.marks).map(|(counted, mark)| mark.number.unwrap_or(counted)).collect()
    }
}

/// The forces of one state: of connectors, and of multi-point constraints.
pub(crate) type Given<'a> = (&'a BTreeMap<Label, ElementForces>, &'a BTreeMap<String, ElementForces>);

/// Component forces of their own file.
pub(crate) enum Forces {
    /// All of them.
    Held(ForceFile),
    /// A file, of which the forces of a few states are held at a time.
    File(ForceStream),
}

impl Forces {
    /// The forces of a file. What cannot be read twice, such as a pipe, is held.
    pub(crate) fn open(path: &Path, scene: &Scene, sign: ForceSign) -> Result<Self, Failure> {
        let stream = ForceStream::open(path, sign)?;
        if stream.is_repeatable() || !path.exists() {
            return Ok(Self::File(stream));
        }
        Ok(Self::Held(ForceFile::read(path, scene, sign)?))
    }

    /// Reads them all, checks each, and finds the states that they belong to.
    pub(crate) fn assign(
        &self,
        scene: &Scene,
        states: &StateIndex<'_>,
        check: impl Fn(usize, Given<'_>) -> Result<(), Diagnostic>,
    ) -> Result<Assigned, Failure> {
        let wrong = RefCell::new(None::<Diagnostic>);
        let see = |place: usize, forces: &StateForces| {
            let error = check(place, (&forces.elements, &forces.mpcs)).err();
            wrong.replace_with(|known| Diagnostic::joined(known.take().into_iter().chain(error)));
        };
        let stream = match self {
            Self::Held(file) => {
                let assigned = file.assign(states)?;
                assigned.iter().for_each(|(place, forces)| see(*place, forces));
                wrong.into_inner().map_or(Ok(()), Err)?;
                let held = assigned.into_iter().map(|(place, forces)| (place, forces.clone()));
                return Ok(Assigned::Held(held.collect()));
            }
            Self::File(stream) => stream,
        };
        let (mut last, mut ascends) = (None, true);
        stream.for_each(scene, states, |place, forces| -> Result<(), Failure> {
            ascends &= last < Some(place);
            last = Some(place);
            see(place, &forces);
            Ok(())
        })?;
        wrong.into_inner().map_or(Ok(()), Err)?;
        if ascends {
            return Ok(Assigned::InOrder);
        }
        let mut held = BTreeMap::new();
        stream.for_each(scene, states, |place, forces| -> Result<(), Failure> {
            held.insert(place, forces);
            Ok(())
        })?;
        Ok(Assigned::Held(held))
    }
}

/// Where the forces of a file belong.
pub(crate) enum Assigned {
    /// They stand in the order of the states.
    InOrder,
    /// They do not, or are held anyway: by the places of the states.
    Held(BTreeMap<usize, StateForces>),
}

impl Default for Assigned {
    fn default() -> Self {
        Self::Held(BTreeMap::new())
    }
}

/// The forces of states that are asked for in order.
pub(crate) enum Feed<'a> {
    Held(&'a BTreeMap<usize, StateForces>),
    /// Those that a reader hands over, and the next of them.
    Read(Receiver<Result<(usize, StateForces), Failure>>, Option<(usize, StateForces)>),
}

impl Feed<'_> {
    /// Those of the state at a place, if it has any.
    pub(crate) fn at(&mut self, place: usize) -> Result<Option<StateForces>, Failure> {
        match self {
            Self::Held(forces) => Ok(forces.get(&place).cloned()),
            Self::Read(reader, next) => {
                if next.is_none() {
                    *next = reader.recv().ok().transpose()?;
                }
                Ok(next.take_if(|(at, _)| *at == place).map(|(_, forces)| forces))
            }
        }
    }
}

impl Assigned {
    /// Hands the forces to `walk`, which goes through the states: from memory, or as a thread reads them, no more than two states ahead.
    pub(crate) fn with<T>(
        &self,
        forces: Option<(&Forces, &StateIndex<'_>)>,
        scene: &Scene,
        walk: impl FnOnce(Feed<'_>) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let (stream, states) = match (self, forces) {
            (Self::Held(held), _) => return walk(Feed::Held(held)),
            (Self::InOrder, Some((Forces::File(stream), states))) => (stream, states),
            (Self::InOrder, _) => return walk(Feed::Held(&BTreeMap::new())),
        };
        thread::scope(|scope| {
            let (sender, receiver) = sync_channel(0);
            let read = move || {
                let gone = || Failure::Input("nobody reads the forces any more".to_string());
                let each = |place, forces| sender.send(Ok((place, forces))).map_err(|_| gone());
                if let Err(failure) = stream.for_each(scene, states, each) {
                    // Whoever has gone does not want to know.
                    _ = sender.send(Err(failure));
                }
            };
            thread::Builder::new()
                .spawn_scoped(scope, read)
                .map_err(|error| Failure::Input(format!("cannot start a thread: {error}")))?;
            walk(Feed::Read(receiver, None))
        })
    }
}
