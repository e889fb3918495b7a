//! What `pintle eval` writes: one stream of blocks, written as they come, in one of three formats.

mod arrays;
mod block;
pub mod csv;
mod flags;
pub mod human;
pub mod json;
pub mod matrix_market;
mod number;

pub use arrays::{ArrayEvaluation, into_arrays};
pub use block::{
    Block, BlockKind, Column, ComponentRow, Derivative, HingeFacts, MpcFacts, Nodal, NodalForce, Value,
    value_of,
};
pub use flags::{flag_in_words, flags_in_words};

use indexmap::IndexMap;
use pintle_kinematics::connector::Tally;
use pintle_model::behavior::drive::takes_time;
use pintle_model::evaluate::{Model, Plan, SUBOPTIONS};
use pintle_scene::grammar;
use pintle_scene::{
    Behavior, Boundary, DampingKind, LabelSet, Law, Scene, Skipped, SkippedItem, Solver, Step, TableOptions,
    Target,
};
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
    /// What writes the blocks of this state into texts, on any thread.
    fn renderer(&self) -> Renderer;
    /// A connector or MPC at this state, as the renderer wrote it; connectors come first.
    fn rendered(&mut self, kind: BlockKind, text: &[u8]) -> io::Result<()>;
    /// A connector or MPC at this state; connectors come first.
    fn block(&mut self, block: &Block<'_>) -> io::Result<()> {
        let mut text = Vec::new();
        self.renderer()(block, &mut text)?;
        self.rendered(block.kind, &text)
    }
    /// The state ends.
    fn end_state(&mut self) -> io::Result<()>;
    /// The scene ends; `work` counts what was computed for it.
    fn end_scene(&mut self, work: Tally) -> io::Result<()>;
    /// After everything.
    fn end(&mut self) -> io::Result<()>;
}

/// Writes a block at the end of a text.
pub type Renderer = Box<dyn Fn(&Block<'_>, &mut Vec<u8>) -> io::Result<()> + Send + Sync>;

/// Something that was read and is not evaluated.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Unevaluated {
    /// How many.
    pub count: u64,
    /// Of what, in the plural if there are several.
    pub what: &'static str,
    /// Names, where they are few.
    #[serde(skip)]
    pub names: Vec<String>,
    /// More about it, in words.
    pub details: Vec<String>,
}

/// As many names as are told without being asked for.
const FEW: usize = 4;

/// `3 × `, or nothing for one.
fn times(count: u64) -> String {
    if count == 1 { String::new() } else { format!("{count} × ") }
}

/// What a scene has that `eval` does not evaluate.
pub fn unevaluated(scene: &Scene, model: &Model) -> Vec<Unevaluated> {
    let mut found = Vec::new();
    let mut add = |count: u64, [one, several]: [&'static str; 2], details: Vec<String>| {
        if count > 0 {
            let what = grammar::agree(count, [one, several]);
            found.push(Unevaluated { count, what, names: Vec::new(), details });
        }
    };
    let behaviors: Vec<String> = scene
        .behaviors
        .iter()
        .filter_map(|(name, behavior)| {
            let kept = behavior.suboptions().filter(|(keyword, _)| !SUBOPTIONS.contains(keyword));
            let mut parts: Vec<String> =
                kept.map(|(keyword, count)| format!("{}*{keyword}", times(count as u64))).collect();
            let structural =
                behavior.damping.iter().filter(|damping| damping.kind == DampingKind::Structural).count();
            if structural > 0 {
                let what = "structural damping (a complex stiffness, in harmonic response only)";
                parts.push(format!("{}{what}", times(structural as u64)));
            }
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
    let others = scene.point_elements.iter().filter(|(label, _)| !model.grounded.contains(*label));
    for (_, element) in others {
        *kinds.entry(element.kind.name()).or_default() += 1;
    }
    let count: usize = kinds.values().sum();
    let kinds: Vec<String> = kinds.into_iter().map(|(name, count)| format!("{name}: {count}")).collect();
    let what = ["mass, spring or dashpot element", "mass, spring or dashpot elements"];
    add(count as u64, what, kinds);
    let steps = &scene.steps;
    let in_steps = |count: &dyn Fn(&Step) -> usize| steps.iter().map(count).sum::<usize>();
    // What acts on the angles of hinges alone is evaluated.
    let hinges: LabelSet = model
        .mpcs
        .iter()
        .flat_map(|mpc| mpc.nodes.iter().skip(2).take(mpc.constraint.kind().entry().angles.len()).copied())
        .collect();
    let is_left = |target: &Target, dofs: &[u8]| {
        let nodes = match target {
            Target::Label(label) => std::slice::from_ref(label),
            Target::Set(name) => scene.node_sets.get(name.as_str()).map_or(&[][..], |set| &set.labels),
        };
        !(dofs == [6] && nodes.iter().all(|node| hinges.contains(node)))
    };
    let held = |boundaries: &[Boundary]| {
        boundaries.iter().filter(|given| is_left(&given.target.value, &given.degrees_of_freedom)).count()
    };
    let loads = |step: &Step| {
        let nodal = step.concentrated_loads.iter();
        let left = nodal.filter(|load| is_left(&load.target.value, &[load.degree_of_freedom])).count();
        left + step.distributed_loads.len()
    };
    for (count, what) in [
        (
            held(&scene.boundaries) + in_steps(&|step| held(&step.boundaries)),
            ["boundary condition", "boundary conditions"],
        ),
        (in_steps(&loads), ["nodal or distributed load", "nodal or distributed loads"]),
    ] {
        add(count as u64, what, Vec::new());
    }
    // Motions and loads of connectors follow the steps in time; what follows none of them is left.
    let driven = |step: &Step| step.connector_motions.len() + step.connector_loads.len();
    let (mut in_time, mut left) = (0, 0);
    for step in steps {
        let follows = takes_time(step) && in_time < model.schedule.len();
        in_time += usize::from(takes_time(step));
        left += if follows { 0 } else { driven(step) };
    }
    let what = [
        "connector motion or load of a step without a place in time",
        "connector motions and loads of steps without a place in time",
    ];
    add(left as u64, what, Vec::new());
    let evaluated = in_steps(&driven) - left;
    let mut details = vec!["states are given, and none is solved for".to_string()];
    if evaluated > 0 {
        details.push(format!("evaluated, by the time of states: connector motions and loads, {evaluated}"));
    }
    add(steps.len() as u64, ["solution of a step", "solutions of steps"], details);
    add(in_steps(&|step| step.outputs.len()) as u64, ["output request", "output requests"], Vec::new());
    let Skipped { keywords, element_types, parameters, comments: _, constraints: _, nodes: _ } =
        &scene.skipped;
    let kinds = [
        (keywords, "*", ["skipped keyword", "skipped keywords"]),
        (element_types, "", ["element of another type", "elements of other types"]),
        (parameters, "", ["skipped parameter or line", "skipped parameters and lines"]),
    ];
    for (items, mark, [one, several]) in kinds {
        let count = items.values().map(|item| item.count).sum::<u64>();
        if count == 0 {
            continue;
        }
        let details = items.iter().map(|(name, item)| {
            let SkippedItem { count, data_lines, first_line, .. } = item;
            let lines = grammar::count(*data_lines, "data line");
            format!("{mark}{name}: {count}, {lines}, first at line {first_line}")
        });
        let names = items.iter().map(|(name, item)| format!("{}{mark}{name}", times(item.count)));
        let names = if items.len() <= FEW { names.collect() } else { Vec::new() };
        let what = grammar::agree(count, [one, several]);
        found.push(Unevaluated { count, what, names, details: details.collect() });
    }
    found
}
