//! A part of the connectors, through all states.

use crate::evaluate::arrays::quad::{Quads, Room};
use crate::evaluate::arrays::{Given, Numbers, Sorted};
use crate::evaluate::sequence::nodes::{Moved, Orientation, STILL, UNTURNED};
use crate::evaluate::sequence::place;
use pintle_kinematics::connector::{Branch, Connector, Evaluation, Output, Request, Tally};
use pintle_scene::{Label, NodeMotion};
use std::cell::LazyCell;
use std::ops::Range;

/// A node of a part.
struct OwnNode {
    label: Label,
    /// Whether a history depends on how it turns.
    turns: bool,
    orientation: Orientation,
}

/// A connector by itself.
struct Single {
    /// Its place in the part.
    at: usize,
    index: usize,
    ends: [Option<usize>; 2],
    branch: Branch<f64>,
}

/// Connectors that go through all states together.
pub(super) struct Part<'a> {
    nodes: Vec<OwnNode>,
    moved: Vec<Moved>,
    /// Those of each kind, in the order of kinds.
    quads: Vec<Quads<'a>>,
    singles: Vec<Single>,
    /// Whether no state has been evaluated yet.
    is_at_first: bool,
}

impl<'a> Part<'a> {
    /// The members of a plan, by their numbers in it.
    pub(super) fn new(sorted: &Sorted<'a>, members: Range<usize>) -> Self {
        let (plan, model) = (sorted.plan, sorted.model);
        let indices = plan.connectors.get(members.clone()).unwrap_or_default();
        let ends = |index: &usize| model.connectors[*index].nodes;
        let mut labels: Vec<Label> = indices.iter().flat_map(ends).flatten().collect();
        labels.sort_unstable();
        labels.dedup();
        let mut nodes: Vec<OwnNode> = labels
            .iter()
            .map(|label| OwnNode { label: *label, turns: false, orientation: UNTURNED })
            .collect();
        let followed = sorted.request().components();
        let mut kinds = vec![Vec::new(); sorted.kinds.len()];
        let mut singles = Vec::new();
        for (at, (place, index)) in members.zip(indices).enumerate() {
            let element = &model.connectors[*index];
            let ends = element.nodes.map(|node| labels.binary_search(&node?).ok());
            if element.connector.history_turns(followed) {
                ends.iter().flatten().for_each(|end| nodes[*end].turns = true);
            }
            match sorted.kind_of.get(place).copied().flatten() {
                Some(kind) => kinds[kind as usize].push((at, *index, ends)),
                None => singles.push(Single {
                    at,
                    index: *index,
                    ends,
                    branch: element.connector.initial_branch(),
                }),
            }
        }
        let all = kinds.iter().enumerate().filter(|(_, members)| !members.is_empty());
        let quads = all.map(|(kind, members)| Quads::new(sorted, kind, members)).collect();
        let moved = vec![STILL; nodes.len()];
        Self { nodes, moved, quads, singles, is_at_first: true }
    }

    /// Evaluates them at every state given.
    pub(super) fn run(&mut self, sorted: &Sorted<'a>, given: &Given<'_>, numbers: Vec<Numbers<'_>>) -> Tally {
        let columns: Vec<Option<usize>> = self.nodes.iter().map(|node| given.column(node.label)).collect();
        let mut tally = Tally::default();
        let mut room = Room::default();
        let mut evaluation = Evaluation::empty(Branch::none());
        for (s, mut numbers) in numbers.into_iter().enumerate() {
            let first = std::mem::take(&mut self.is_at_first);
            for ((node, column), moved) in self.nodes.iter_mut().zip(&columns).zip(&mut self.moved) {
                let mut motion = NodeMotion::default();
                let is_given = given.put_motion(s, (node.label, *column), &mut motion);
                moved.follow(&motion, &mut node.orientation, is_given, node.turns, first);
                tally.rotations += 1;
            }
            for quads in &mut self.quads {
                quads.run(sorted, &self.moved, &mut room, &mut numbers, &mut tally);
            }
            for single in &mut self.singles {
                single.run(sorted, &self.moved, &mut evaluation, &mut numbers, &mut tally);
            }
        }
        tally
    }
}

impl Single {
    fn run(
        &mut self,
        sorted: &Sorted<'_>,
        moved: &[Moved],
        evaluation: &mut Evaluation<f64>,
        numbers: &mut Numbers<'_>,
        tally: &mut Tally,
    ) {
        let element = &sorted.model.connectors[self.index];
        let (connector, request) = (&element.connector, sorted.request());
        let ends = self.ends.map(|end| end.map_or(&STILL, |end| &moved[end]));
        let (state, increment) = place(element, ends);
        self.branch = connector.follow(&state, &increment, &self.branch, request.components(), tally);
        connector.evaluate_into(evaluation, &state, self.branch, request, tally);
        write(evaluation, connector, request, self.at, numbers);
    }
}

/// Writes what a connector gives from its motion alone, by its place in the part.
pub(super) fn write(
    evaluation: &Evaluation<f64>,
    connector: &Connector<f64>,
    request: &Request,
    at: usize,
    numbers: &mut Numbers<'_>,
) {
    let stops = LazyCell::new(|| connector.stop_status(&evaluation.position));
    let value = |output, k: usize| {
        let value = match output {
            Output::CSLST => stops[k].map(|stop| f64::from(stop.flag())),
            Output::TURNS => evaluation.turns[k].map(|turns| turns.turns),
            of_motion => evaluation.value(of_motion, k),
        };
        value.filter(|_| request.wants(output, k))
    };
    numbers.put(at, value, evaluation);
}
