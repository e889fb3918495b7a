//! What `pintle eval` writes: one stream of blocks, written as they come, in one of three formats.

use super::block::Block;
use crate::connector::Tally;
use crate::evaluate::{Model, Plan};
use crate::scene::Scene;
use std::io;

/// A scene that is being evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// What was read.
    pub scene: &'a Scene,
    /// What it means.
    pub model: &'a Model,
    /// What is asked for.
    pub plan: &'a Plan,
    /// The number of states, of which those written may be fewer.
    pub states: usize,
    /// The number of the first state: not 0 where a history is continued.
    pub first: u64,
}

/// A format of evaluations. Calls nest: begin, then scenes with states with blocks, then end.
pub trait Format {
    /// Before anything.
    ///
    /// # Errors
    /// Those of the stream, here and below.
    fn begin(&mut self) -> io::Result<()>;
    /// A scene begins.
    fn scene(&mut self, subject: &Subject<'_>) -> io::Result<()>;
    /// A state begins.
    fn state(&mut self, index: u64, time: Option<f64>) -> io::Result<()>;
    /// A connector or MPC at this state; connectors come first.
    fn block(&mut self, block: &Block<'_>) -> io::Result<()>;
    /// The state ends.
    fn end_state(&mut self) -> io::Result<()>;
    /// The scene ends; `work` counts what was computed for it.
    fn end_scene(&mut self, work: Tally) -> io::Result<()>;
    /// After everything.
    fn end(&mut self) -> io::Result<()>;
}

/// Something that was read and is not evaluated.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Unevaluated {
    /// How many.
    pub count: u64,
    /// Of what.
    pub what: String,
    /// More about it, in words.
    pub details: Vec<String>,
}

/// What a scene has that `eval` does not evaluate.
pub fn unevaluated(scene: &Scene, model: &Model) -> Vec<Unevaluated> {
    let mut found = Vec::new();
    let mut add = |count: usize, what: &str, details: Vec<String>| {
        if count > 0 {
            found.push(Unevaluated { count: count as u64, what: what.to_string(), details });
        }
    };
    let behaviors: Vec<String> = scene
        .behaviors
        .iter()
        .filter_map(|(name, behavior)| {
            let parts: Vec<String> = [
                (behavior.elasticity.len(), "elasticity"),
                (behavior.damping.len(), "damping"),
                (behavior.friction.len(), "friction"),
                (behavior.plasticity.len(), "plasticity"),
                (behavior.damage.len(), "damage"),
                (behavior.locks.len(), "lock"),
                (behavior.failures.len(), "failure"),
            ]
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, part)| if count > 1 { format!("{count} × {part}") } else { part.to_string() })
            .collect();
            (!parts.is_empty()).then(|| format!("{name}: {}", parts.join(", ")))
        })
        .collect();
    add(behaviors.len(), "connector behaviour", behaviors);
    let others: Vec<String> =
        model.other_mpcs.iter().map(|(name, count)| format!("{name}: {count}")).collect();
    add(model.other_mpcs.values().sum(), "MPC", others);
    let mut kinds: indexmap::IndexMap<&str, usize> = indexmap::IndexMap::new();
    for element in scene.point_elements.values() {
        *kinds.entry(element.kind.name()).or_default() += 1;
    }
    let kinds: Vec<String> = kinds.into_iter().map(|(name, count)| format!("{name}: {count}")).collect();
    add(scene.point_elements.len(), "mass, spring or dashpot element", kinds);
    let steps = &scene.steps;
    let in_steps = |count: fn(&crate::scene::Step) -> usize| steps.iter().map(count).sum::<usize>();
    add(scene.boundaries.len() + in_steps(|step| step.boundaries.len()), "boundary condition", Vec::new());
    add(
        scene.connector_motions.len() + in_steps(|step| step.connector_motions.len()),
        "connector motion",
        Vec::new(),
    );
    add(in_steps(|step| step.connector_loads.len()), "connector load", Vec::new());
    add(in_steps(|step| step.concentrated_loads.len() + step.distributed_loads.len()), "load", Vec::new());
    add(steps.len(), "step", Vec::new());
    let skipped = &scene.skipped;
    let details = skipped.keywords.iter().map(|(name, item)| {
        let plural = if item.data_lines == 1 { "line" } else { "lines" };
        format!(
            "*{name}: {}, {} data {plural}, first at line {}",
            item.count, item.data_lines, item.first_line
        )
    });
    add(
        usize::try_from(skipped.keywords.values().map(|item| item.count).sum::<u64>()).unwrap_or(usize::MAX),
        "skipped keyword",
        details.collect(),
    );
    let details = skipped
        .element_types
        .iter()
        .map(|(name, item)| format!("{name}: {}, first at line {}", item.count, item.first_line));
    add(
        usize::try_from(skipped.element_types.values().map(|item| item.count).sum::<u64>())
            .unwrap_or(usize::MAX),
        "element of another type",
        details.collect(),
    );
    found
}
