//! Is this model sound? What an analyst should know of a scene before it is run: rules that it breaks, directions that are not what
//! they look like, singular points that its states come near, parameters without effect, duplicates.
//!
//! Each [`Finding`] has a stable code, which `pintle explain CODE` explains, a severity, which [`Levels`] set per code, a place in the
//! file, what it is about, and a remedy.
//!
//! | module | question |
//! |---|---|
//! | `finding`, `levels` | what is a finding, and how bad is it taken to be? |
//! | `geometry` | are the directions and lengths what they look like? |
//! | `along` | what happens along the given states? |
//! | `behavior` | does what is attached to components act? |
//! | `certainty` | how certain is a position? |
//! | `held` | do the states move what boundary conditions hold? |
//! | `pressing` | which contact forces are always zero? |
//! | `assembly` | what can the whole assembly do, and what is redundant in it? |
//! | `coverage` | which connectors and types did the states exercise? |
//! | `still` | which nodes stand still, or cannot turn? |
//! | `duplicates` | is something there twice? |
//! | `units` | are angles in degrees? |

mod along;
mod assembly;
mod behavior;
mod certainty;
mod coverage;
mod duplicates;
mod finding;
mod gather;
mod geometry;
mod held;
mod levels;
mod pressing;
mod still;
mod units;

pub use along::Nearest;
pub use finding::{About, Finding};
pub use levels::{Level, Levels};

use crate::sampling::coverage::{Coverage, Exercise, Sample};
use pintle_assembly::{Assembly, analyse_steps};
use pintle_model::evaluate::Model;
use pintle_scene::{Diagnostic, Scene, Severity, State, Vanishing};
use serde::Serialize;
use still::Still;

/// What is found in one scene.
#[derive(Clone, Debug, Serialize)]
pub struct ModelReport {
    /// The scene.
    pub scene: String,
    /// The number of states that were looked at besides the initial one.
    pub states: usize,
    /// What the assembly as a whole can do, in the first step; `None` where a rule refuses the model.
    pub assembly: Option<Assembly>,
    /// The same in later steps whose boundary conditions or connector motions are not those of the step before.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub later_steps: Vec<Assembly>,
    /// Which region of configuration space the states exercised.
    pub coverage: Coverage,
    /// Whether the states of the coverage were drawn, for the scene gives none ([`crate::drawn_coverage`]).
    pub drawn: bool,
    /// How near to a singular set any connector comes, initially and at the states; `None` where no component has one.
    pub nearest: Option<Nearest>,
    /// Findings: rules first, then geometry, behaviour, duplicates, states, the assembly, coverage.
    pub findings: Vec<Finding>,
}

impl ModelReport {
    /// The number of findings as bad as that.
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity() == severity).count()
    }

    /// Whether the model fails: a finding is an error.
    pub fn fails(&self) -> bool {
        self.count(Severity::Error) > 0
    }
}

/// Looks at a scene, at its initial state and at those given.
pub fn audit_model(scene: &Scene, states: &[State], levels: &Levels) -> ModelReport {
    let (model, errors) = Model::examine(scene);
    let is_refused = errors.iter().any(|error| !levels.lets_pass(error));
    let mut findings = broken(scene, &model, errors);
    findings.extend(geometry::findings(scene, &model, levels));
    findings.extend(behavior::findings(scene, &model, levels));
    findings.extend(duplicates::findings(scene, &model, levels));
    findings.extend(units::of_scene(scene));
    let in_degrees = units::of_states(scene, states);
    // What states in degrees do besides follows from that.
    let is_told = in_degrees
        .as_ref()
        .is_some_and(|(finding, is_common)| *is_common && levels.of_finding(finding).is_some());
    let (given, states) = (states.len(), if is_told { &[] } else { states });
    findings.extend(in_degrees.map(|(finding, _)| finding));
    findings.extend(vanishing(scene, states));
    let mut coverage = Coverage::default();
    let mut exercises = vec![Exercise::default(); model.connectors.len()];
    // What defines no directions is told with the assembly; without states nothing is asked for.
    let still =
        if states.is_empty() { Still::default() } else { Still::of(scene, &model).unwrap_or_default() };
    let (along, nearest) = along::findings(scene, &model, states, levels, &mut |result| {
        if let (Some(element), Some(exercise)) =
            (model.connectors.get(result.index), exercises.get_mut(result.index))
        {
            let sample = Sample::of(&element.connector, &element.definition(), &result.state, model.length)
                .held(still.cannot_turn(element), still.cannot_move(element));
            coverage.take(&sample);
            exercise.add(&sample);
        }
    });
    findings.extend(along);
    findings.extend(held::findings(scene, states, model.length));
    let mut steps = Vec::new();
    if !is_refused {
        match geometry::axes_apart(scene, &model) {
            Ok(found) => findings.extend(found),
            Err(error) => findings.push(error.into()),
        }
        match analyse_steps(scene, &model, states) {
            Ok(found) => {
                findings.extend(assembly::findings_in_steps(scene, &found, levels));
                steps = found;
            }
            Err(error) => findings.push(error.into()),
        }
    }
    findings.extend(coverage::findings(scene, &model, &exercises));
    let findings = levels.apply(findings);
    let mut steps = steps.into_iter();
    let assembly = steps.next();
    let later_steps = steps.collect();
    ModelReport {
        scene: scene.name.clone(),
        states: given,
        assembly,
        later_steps,
        coverage,
        drawn: false,
        nearest,
        findings,
    }
}

/// Every error and warning of reading and resolving the scene.
fn broken(scene: &Scene, model: &Model, errors: Vec<Diagnostic>) -> Vec<Finding> {
    let told = errors.into_iter().chain(scene.warnings.iter().cloned()).chain(model.warnings.iter().cloned());
    told.map(|diagnostic| {
        let mut elements = diagnostic.elements().to_vec();
        elements.dedup();
        let (diagnostic, unsaid) = diagnostic.without_unsaid();
        let mut others = diagnostic.others();
        if unsaid > 0 {
            others += &format!(" (and {unsaid} more of this code)");
        }
        Finding::from(diagnostic).add(&others).about(About { elements, ..About::default() })
    })
    .collect()
}

/// Nodes that a state leaves out and the state before moves.
fn vanishing(scene: &Scene, states: &[State]) -> Option<Finding> {
    let mut vanishing = Vanishing::default();
    for (index, state) in states.iter().enumerate() {
        vanishing.see(state.number.unwrap_or(index as u64), state);
    }
    let nodes = vanishing.nodes().iter().copied().take(100).collect();
    let finding = Finding::from(vanishing.warning()?.in_file(&scene.name));
    Some(finding.about(About { nodes, ..About::default() }))
}
