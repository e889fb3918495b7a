//! What `pintle eval` writes: one stream of blocks, written as they come, in one of three formats.

use super::block::Block;
use crate::connector::Tally;
use crate::evaluate::{Model, Plan};
use crate::scene::{Behavior, DampingKind, Law, Scene, Skipped, SkippedItem, Solver, Step, TableOptions};
use indexmap::IndexMap;
use std::io;
use std::ops::RangeInclusive;

/// A scene that is being evaluated.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// What was read.
    pub scene: &'a Scene,
    /// What it means.
    pub model: &'a Model,
    /// What is asked for.
    pub plan: &'a Plan,
    /// The number of states.
    pub states: usize,
    /// The numbers of those that are written.
    pub shown: &'a [RangeInclusive<u64>],
    /// The number of the first state: that of the file, or counted from 0, or from where a history is continued.
    pub first: u64,
    /// The number of the last state.
    pub last: u64,
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
    /// Of what, in the plural if there are several.
    pub what: &'static str,
    /// More about it, in words.
    pub details: Vec<String>,
}

/// What a scene has that `eval` does not evaluate.
pub fn unevaluated(scene: &Scene, model: &Model) -> Vec<Unevaluated> {
    let mut found = Vec::new();
    let mut add = |count: u64, [one, several]: [&'static str; 2], details: Vec<String>| {
        if count > 0 {
            found.push(Unevaluated { count, what: if count == 1 { one } else { several }, details });
        }
    };
    let behaviors: Vec<String> = scene
        .behaviors
        .iter()
        .filter_map(|(name, behavior)| {
            let parts: Vec<String> = [
                (
                    behavior.damping.iter().filter(|damping| damping.kind == DampingKind::Structural).count(),
                    "structural damping (a complex stiffness, in harmonic response only)",
                ),
                (behavior.plasticity.len(), "plasticity"),
                (behavior.damage.len(), "damage"),
            ]
            .into_iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, part)| if count > 1 { format!("{count} × {part}") } else { part.to_string() })
            .collect();
            (!parts.is_empty()).then(|| format!("{name}: {}", parts.join(", ")))
        })
        .collect();
    add(behaviors.len() as u64, ["connector behaviour", "connector behaviours"], behaviors);
    let is_regularized = |behavior: &Behavior| {
        let laws = behavior.elasticity.iter().map(|law| (&law.law, &law.table));
        let laws = laws.chain(behavior.damping.iter().map(|law| (&law.law, &law.table)));
        let is_on = |table: &TableOptions| table.regularize.or(behavior.table.regularize) != Some(false);
        laws.filter(|(law, _)| matches!(law, Law::Nonlinear { .. })).any(|(_, table)| is_on(table))
    };
    let regularized: Vec<String> = match scene.solver {
        Some(Solver::Explicit) => {
            let names = scene.behaviors.iter().filter(|(_, behavior)| is_regularized(behavior));
            names.map(|(name, _)| format!("{name}: the rows are used as they are given")).collect()
        }
        _ => Vec::new(),
    };
    add(regularized.len() as u64, ["regularisation of tables", "regularisations of tables"], regularized);
    let others: Vec<String> =
        model.other_mpcs.iter().map(|(name, count)| format!("{name}: {count}")).collect();
    add(model.other_mpcs.values().sum::<usize>() as u64, ["MPC", "MPCs"], others);
    let mut kinds: IndexMap<&str, usize> = IndexMap::new();
    for element in scene.point_elements.values() {
        *kinds.entry(element.kind.name()).or_default() += 1;
    }
    let kinds: Vec<String> = kinds.into_iter().map(|(name, count)| format!("{name}: {count}")).collect();
    let what = ["mass, spring or dashpot element", "mass, spring or dashpot elements"];
    add(scene.point_elements.len() as u64, what, kinds);
    let steps = &scene.steps;
    let in_steps = |count: fn(&Step) -> usize| steps.iter().map(count).sum::<usize>();
    for (count, what) in [
        (
            scene.boundaries.len() + in_steps(|step| step.boundaries.len()),
            ["boundary condition", "boundary conditions"],
        ),
        (
            in_steps(|step| step.concentrated_loads.len() + step.distributed_loads.len()),
            ["nodal or distributed load", "nodal or distributed loads"],
        ),
        (steps.len(), ["step", "steps"]),
    ] {
        add(count as u64, what, Vec::new());
    }
    let Skipped { keywords, element_types } = &scene.skipped;
    let details = keywords.iter().map(|(name, item)| {
        let lines = if item.data_lines == 1 { "line" } else { "lines" };
        format!(
            "*{name}: {}, {} data {lines}, first at line {}",
            item.count, item.data_lines, item.first_line
        )
    });
    let count = |items: &IndexMap<String, SkippedItem>| items.values().map(|item| item.count).sum::<u64>();
    add(count(keywords), ["skipped keyword", "skipped keywords"], details.collect());
    let details = element_types
        .iter()
        .map(|(name, item)| format!("{name}: {}, first at line {}", item.count, item.first_line));
    add(count(element_types), ["element of another type", "elements of other types"], details.collect());
    found
}
