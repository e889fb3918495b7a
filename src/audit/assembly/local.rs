//! Where do the redundancies of a part hold that could not be moved as a whole?
//!
//! What a constraint follows from lies in its neighbourhood, as a rule: in the loops that go through its connector. So a neighbourhood is cut
//! out, with what holds it to the ground, and moved by itself; where it does not have all that the constraint follows from, a larger one. Cut out,
//! it can go wherever it can go in the whole, and further:
//! what depends on others wherever the neighbourhood goes does so in the whole, and what cannot move by itself cannot move there. What does not
//! depend on others elsewhere holds at this state only, unless the rest keeps the neighbourhood here ([`Holds::Loop`]).
//!
//! A neighbourhood that nothing holds is held by one node, for it is not to be moved as a rigid body. What is named in it depends on constraints before
//! it, and so it is named in the whole. Where loops meet, as in grids, a constraint that is named may close a way about
//! many of them; and of many neighbourhoods only some are looked at ([`WORK`]). What is then not told is [`Holds::Large`].

use super::Holds;
use super::budget::{Budget, EVALUATION, ROW};
use super::eliminate::Task;
use super::found::Found;
use super::moving::elsewhere;
use super::naming::named;
use super::system::{Origin, Part, Role, System, request};
use crate::evaluate::{Equation, Freedom, NUMBERS, Plan, Sequence, Source};
use crate::scene::{Label, State};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};

/// The degrees of freedom of neighbourhoods, which are tried one after the other.
pub(super) const SIZES: [usize; 4] = [600, 2_400, 9_600, 20_000];
/// The degrees of freedom of all neighbourhoods of a size together: with those of all sizes some tens of seconds of processor.
const WORK: usize = 30_000;
/// The states that a neighbourhood is moved to: at a random one the rank is the largest there is, but for those of no measure.
const SAMPLES: usize = 1;
/// What a neighbourhood may spend of what is left, however many are looked at.
const LEAST: u64 = 10_000_000;
/// Neighbourhoods that are looked at at once.
const BATCH: usize = 16;

/// What is where in a part.
struct Surroundings<'a> {
    system: &'a System<'a>,
    part: &'a Part,
    /// Its nodes that are not held, with the number of their degrees of freedom.
    nodes: HashMap<Label, usize>,
    /// Connectors and MPCs by those nodes.
    sources: HashMap<Label, Vec<Source>>,
    /// The redundant constraints.
    wanted: HashMap<Equation, u32>,
}

/// What was found in a neighbourhood.
struct Looked {
    /// Its degrees of freedom.
    size: usize,
    /// Redundant rows, and where they hold.
    rows: Vec<(u32, Holds)>,
}

/// Where the redundant rows of a part hold, in their order, from neighbourhoods of these sizes.
pub(super) fn judge(
    system: &System<'_>,
    part: &Part,
    found: &Found,
    sizes: &[usize],
    budget: &Budget,
) -> Vec<Holds> {
    let around = Surroundings::new(system, part, found);
    let mut open: BTreeMap<Source, Vec<u32>> = BTreeMap::new();
    for (equation, row) in &around.wanted {
        open.entry(equation.source).or_default().push(*row);
    }
    let mut holds: HashMap<u32, Holds> = HashMap::new();
    // What a neighbourhood leaves by itself a larger one may not: it is asked once.
    let mut leaves: HashMap<u32, usize> = HashMap::new();
    let mut ran_out = false;
    for size in sizes {
        let (mut later, mut work) = (BTreeMap::new(), 0);
        while !open.is_empty() && work < WORK && !budget.is_spent() {
            let stride = open.len().div_ceil(BATCH);
            let seeds: Vec<Source> = open.keys().step_by(stride).copied().collect();
            let look = |seed: &Source| {
                let own = budget.share([1, seeds.len()], LEAST);
                let looked = around.look(*seed, *size, &own);
                (looked, own)
            };
            let looked: Vec<(Looked, Budget)> = seeds.par_iter().map(look).collect();
            for (one, own) in looked {
                budget.count(&own);
                ran_out |= own.is_spent();
                work += one.size;
                for (row, is) in one.rows {
                    let first = *leaves.get(&row).unwrap_or(size);
                    if is == Holds::Loop && first == *size {
                        leaves.insert(row, first);
                    } else {
                        holds.entry(row).or_insert(is);
                    }
                }
            }
            open.retain(|_, rows| {
                rows.retain(|row| !holds.contains_key(row));
                !rows.is_empty()
            });
            // Of what its own neighbourhood does not tell a larger one is looked at.
            for seed in seeds {
                later.extend(open.remove_entry(&seed));
            }
        }
        open.extend(later);
    }
    let of = |row: &u32| {
        let left = match row {
            row if leaves.contains_key(row) => Holds::Loop,
            _ if ran_out || budget.is_spent() => Holds::Spent,
            _ => Holds::Large,
        };
        holds.get(row).copied().unwrap_or(left)
    };
    found.constraints.dependent.iter().map(of).collect()
}

impl<'a> Surroundings<'a> {
    fn new(system: &'a System<'a>, part: &'a Part, found: &Found) -> Self {
        let freedoms = system.jacobian.freedoms();
        let mut labels: Vec<(Label, usize)> = Vec::new();
        for column in &part.columns {
            let node = freedoms[*column as usize].node;
            match labels.last_mut() {
                Some((last, count)) if *last == node => *count += 1,
                _ => labels.push((node, 1)),
            }
        }
        let nodes: HashMap<Label, usize> = labels.into_iter().collect();
        let mut sources: HashMap<Label, Vec<Source>> = HashMap::new();
        let connectors = part.connectors.iter().map(|index| Source::Connector(*index));
        let all: BTreeSet<Source> =
            connectors.chain(part.mpcs.iter().map(|index| Source::Mpc(*index))).collect();
        for source in all {
            for node in nodes_of(system, source).filter(|node| nodes.contains_key(node)) {
                sources.entry(node).or_default().push(source);
            }
        }
        let wanted = found.constraints.dependent.iter().filter_map(|row| {
            match system.origins[found.rows[*row as usize] as usize] {
                Origin::Equation(equation) => Some((equation, *row)),
                Origin::Boundary(_) => None,
            }
        });
        Self { system, part, nodes, sources, wanted: wanted.collect() }
    }

    /// The nodes about a connector or MPC, by their distance, up to a number of degrees of freedom; and the connectors and MPCs of which no other node
    /// is free.
    fn neighbourhood(&self, seed: Source, size: usize) -> (BTreeSet<Label>, BTreeSet<Source>) {
        let is_free = |node: &Label| self.nodes.contains_key(node);
        // Where more meet, others lead to them.
        let at = |node: &Label| {
            self.sources.get(node).map(Vec::as_slice).filter(|all| all.len() <= size).unwrap_or_default()
        };
        let mut queue: VecDeque<Label> = nodes_of(self.system, seed).filter(is_free).collect();
        let mut inside: BTreeSet<Label> = queue.iter().copied().collect();
        let count = |node: &Label| self.nodes.get(node).copied().unwrap_or_default();
        let mut total: usize = inside.iter().map(count).sum();
        while let Some(node) = queue.pop_front().filter(|_| total < size) {
            for other in at(&node).iter().flat_map(|source| nodes_of(self.system, *source)).filter(is_free) {
                if inside.insert(other) {
                    total += count(&other);
                    queue.push_back(other);
                }
            }
        }
        let is_inside = |source: &Source| {
            nodes_of(self.system, *source).all(|node| !is_free(&node) || inside.contains(&node))
        };
        let mut sources: BTreeSet<Source> = inside.iter().flat_map(at).copied().filter(is_inside).collect();
        sources.insert(seed);
        (inside, sources)
    }

    /// Moves the neighbourhood of a connector or MPC.
    fn look(&self, seed: Source, size: usize, budget: &Budget) -> Looked {
        let (inside, sources) = self.neighbourhood(seed, size);
        let model = self.system.model;
        let mut looked = Looked { size: inside.len() * 6, rows: Vec::new() };
        // It is found, made a system of its own, and evaluated.
        if !budget.spend(sources.len() * (2 * EVALUATION + 12 * ROW)) {
            return looked;
        }
        let (mut connectors, mut mpcs) = (Vec::new(), Vec::new());
        for source in &sources {
            match source {
                Source::Connector(index) => connectors.push(*index),
                Source::Mpc(index) => mpcs.push(*index),
            }
        }
        let nodes: BTreeSet<Label> = sources
            .iter()
            .flat_map(|source| nodes_of(self.system, *source))
            .chain(inside.iter().copied())
            .collect();
        let elements: Vec<Label> = connectors.iter().map(|index| model.connectors[*index].label).collect();
        let given = self.system.prescribed;
        let mut prescribed = given.restricted(&nodes, &elements, &[]);
        let is_grounded = connectors.iter().any(|index| model.connectors[*index].nodes.contains(&None));
        if !is_grounded && prescribed.held.iter().next().is_none() {
            let last = inside.last();
            let held: Vec<Freedom> = last
                .iter()
                .flat_map(|node| NUMBERS.map(|number| Freedom { node: **node, number }))
                .filter(|freedom| freedom.number <= 6)
                .collect();
            prescribed = given.restricted(&nodes, &elements, &held);
        }
        let plan = Plan { connectors, mpcs, nodes, request: request() };
        let mut own = System::new(model, &plan, &prescribed);
        own.put_length(self.part.length);
        let sequence = Sequence::new(model, &plan);
        let (start, mut values) = (State::default(), Vec::new());
        if sequence.clone().assemble(&start, &own.jacobian, &mut values).is_err() {
            return looked;
        }
        for part in &own.parts {
            let (rows, matrix) = own.matrix(part, (&start, &values), |role| role != Role::Driven);
            let here = named(&matrix, part, Task { keep: true, budget: Some(budget), ..Task::default() });
            let known: Vec<(u32, u32)> = here
                .dependent
                .iter()
                .filter_map(|row| match own.origins[rows[*row as usize] as usize] {
                    Origin::Equation(equation) => Some((*row, *self.wanted.get(&equation)?)),
                    Origin::Boundary(_) => None,
                })
                .collect();
            if known.is_empty() || !here.is_decided() {
                continue;
            }
            let there = elsewhere(&own, part, &sequence, &start, &here, SAMPLES, budget);
            let there: HashMap<u32, Holds> = here.dependent.iter().copied().zip(there).collect();
            looked.rows.extend(known.iter().filter_map(|(row, of_whole)| match *there.get(row)? {
                Holds::Here => Some((*of_whole, Holds::Loop)),
                Holds::Unjudged | Holds::Spent => None,
                holds => Some((*of_whole, holds)),
            }));
        }
        looked
    }
}

/// The nodes of a connector or MPC.
fn nodes_of<'a>(system: &System<'a>, source: Source) -> impl Iterator<Item = Label> + use<'a> {
    let model = system.model;
    let (of_connector, of_mpc) = match source {
        Source::Connector(index) => (Some(&model.connectors[index].nodes), None),
        Source::Mpc(index) => (None, Some(&model.mpcs[index].nodes)),
    };
    let of_connector = of_connector.into_iter().flatten().flatten();
    of_connector.chain(of_mpc.into_iter().flatten()).copied()
}
