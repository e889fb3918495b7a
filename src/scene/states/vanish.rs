//! Which nodes does a state leave out that the one before moved?

use crate::diagnostic::{Code, Diagnostic};
use crate::label::Label;
use crate::model::{NodeMotion, State};
use crate::span::Span;

/// What is remembered from state to state: the nodes that the last one moved.
#[derive(Debug, Clone, Default)]
pub struct Vanishing {
    moved: Vec<Label>,
    /// The first state that leaves out nodes: its number, and the nodes.
    found: Option<(u64, Vec<Label>)>,
    states: usize,
}

impl Vanishing {
    /// Looks at the next state, of that number.
    pub fn see(&mut self, number: u64, state: &State) {
        let mut given = state.nodes.keys().peekable();
        self.moved.retain(|node| {
            while given.next_if(|known| *known < node).is_some() {}
            given.next_if_eq(&node).is_none()
        });
        if !self.moved.is_empty() {
            self.states += 1;
            let moved = std::mem::take(&mut self.moved);
            self.found.get_or_insert((number, moved));
        }
        let moves = |motion: &NodeMotion| {
            let at_rest = NodeMotion { rotation: motion.rotation, ..NodeMotion::default() };
            *motion != at_rest || motion.rotation.turns()
        };
        self.moved.clear();
        self.moved.extend(state.nodes.iter().filter(|(_, motion)| moves(motion)).map(|(node, _)| *node));
    }

    /// The nodes of the first such state.
    pub fn nodes(&self) -> &[Label] {
        self.found.as_ref().map_or(&[], |(_, nodes)| nodes)
    }

    /// The first such state, as a warning; `None` where there is none.
    #[must_use]
    pub fn warning(&self) -> Option<Diagnostic> {
        let (number, nodes) = self.found.as_ref()?;
        let (node, others) = (nodes.first()?, nodes.len() - 1);
        let more = if others > 0 { format!(" and {others} more") } else { String::new() };
        let besides =
            if self.states > 1 { format!("; so do {} later states", self.states - 1) } else { String::new() };
        let message = format!(
            "state {number} leaves out node {node}{more}, which the state before moves: it jumps to its initial place{besides}"
        );
        let reason = "what a state leaves out is at rest in its initial place";
        let remedy = "give the node in every state, zeros where it returns to its initial place";
        Some(Diagnostic::finding(Code::ModelNodeVanishes, Span::default(), message, reason).help(remedy))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_that_was_moved_is_missed() {
        let state = |nodes: &[(u64, f64)]| State {
            nodes: nodes
                .iter()
                .map(|(node, x)| {
                    ((*node).into(), NodeMotion { displacement: [*x, 0.0, 0.0], ..NodeMotion::default() })
                })
                .collect(),
            ..State::default()
        };
        let told = |states: &[State]| {
            let mut vanishing = Vanishing::default();
            (0..).zip(states).for_each(|(number, state)| vanishing.see(number, state));
            vanishing.warning().map(|warning| warning.message().to_string())
        };
        let (both, first, rest) =
            (state(&[(1, 0.5), (2, 1.0)]), state(&[(1, 0.5)]), state(&[(1, 0.5), (2, 0.0)]));
        let said = told(&[both.clone(), both.clone(), first.clone()]).unwrap();
        assert!(said.starts_with("state 2 leaves out node 2,"), "{said}");
        // What returns, and what was never moved, is not missed.
        assert_eq!(told(&[both.clone(), rest.clone(), first.clone()]), None);
        assert_eq!(
            told(&[rest, first.clone(), both, first]).map(|said| said.contains("state 3")),
            Some(true)
        );
    }
}
