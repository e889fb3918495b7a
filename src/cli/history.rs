//! The states of a run: held, or read from their file one at a time, as often as they are needed.

use super::Failure;
use pintle::scene::{Scene, State, StateFile, StateMark, StateStream};
use std::path::Path;

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
            survey.marks.push(StateMark::of(state));
            survey.moves |= moves(state);
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

/// Whether a state has rates.
fn moves(state: &State) -> bool {
    let still = [0.0; 3];
    state.nodes.values().any(|node| {
        [node.velocity, node.angular_velocity, node.acceleration, node.angular_acceleration]
            .iter()
            .any(|rate| *rate != still)
            || node.flow_velocity != 0.0
            || node.flow_acceleration != 0.0
    })
}
