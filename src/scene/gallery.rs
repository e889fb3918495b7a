//! Scenes of our own with known answers.

use crate::diagnostic::Result;
use crate::model::Scene;
use crate::states::StateFile;

/// A deck and a file of states, both embedded in the binary.
///
/// The states are solutions in closed form; `scripts/gallery_states.py` states them and writes the files.
#[derive(Debug, Clone, Copy)]
pub struct Example {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it shows, in one sentence.
    pub summary: &'static str,
    /// The deck.
    pub deck: &'static str,
    /// The states, as CSV.
    pub states: &'static str,
}

impl Example {
    /// The scene that the deck describes.
    ///
    /// # Errors
    /// None, unless the deck is broken, which a test excludes.
    pub fn scene(&self) -> Result<Scene> {
        Scene::parse(&format!("{}.inp", self.name), self.deck)
    }

    /// The states of its nodes.
    ///
    /// # Errors
    /// None, unless the file is broken, which a test excludes.
    pub fn states(&self, scene: &Scene) -> Result<StateFile> {
        StateFile::parse_csv(&format!("{}.states.csv", self.name), self.states, scene)
    }
}

macro_rules! example {
    ($name:literal, $summary:literal) => {
        Example {
            name: $name,
            summary: $summary,
            deck: include_str!(concat!("../../decks/", $name, ".inp")),
            states: include_str!(concat!("../../decks/", $name, ".states.csv")),
        }
    };
}

/// The built-in scenes.
pub static GALLERY: &[Example] = &[
    example!("hinge_pendulum", "a bar on a HINGE with stops, through three full turns"),
    example!("slider_crank", "a crank turned once by its HINGE, with UJOINT and a TRANSLATOR with friction"),
    example!("seat_belt", "a belt from a RETRACTOR over a ring, two SLIPRINGs, pulled without friction"),
    example!(
        "revolute_mpc",
        "a revolute joint as *MPC on a moving master, beside a ROTATION connector, through three turns"
    ),
    example!(
        "parallel_cranks",
        "an assembly of instances, moved and turned: two cranks and the coupler between them"
    ),
];
