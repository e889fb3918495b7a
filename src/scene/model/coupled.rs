//! Which nodes the constraints of a scene couple, and with which weights.

use crate::label::Label;
use crate::label::labelled::{LabelMap, LabelSet};
use crate::model::Target;
use crate::model::constraint::{Coupling, CouplingKind, RigidBody, Tie};
use crate::model::scene::Scene;
use crate::span::{Span, Spanned};
use indexmap::IndexMap;
use std::collections::HashMap;
fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    pintle_kinematics::scalar::elementary::norm([0, 1, 2].map(|i| a[i] - b[i]))
}

impl Scene {
    fn coordinates(&self, node: Label) -> [f64; 3] {
        self.nodes.get(&node).map_or([0.0; 3], |node| node.coordinates)
    }

    /// The nodes of a surface, each once and in their order, with their weights: 1 unless given.
    #[must_use]
    pub fn surface_nodes(&self, surface: &str) -> Vec<(Label, f64)> {
        let mut known = LabelSet::default();
        let mut found = Vec::new();
        for (target, weight) in self.surfaces.get(surface).into_iter().flat_map(|surface| &surface.members) {
            let labels = match &target.value {
                Target::Label(label) => std::slice::from_ref(label),
                Target::Set(name) => self.node_sets.get(name).map_or(&[][..], |set| set.labels.as_slice()),
            };
            let new = labels.iter().filter(|label| known.insert(**label));
            found.extend(new.map(|label| (*label, weight.unwrap_or(1.0))));
        }
        found
    }

    /// The constraints that are not read, by kind (`*TIE`, `MPC SLIDER`), with the place of each.
    #[must_use]
    pub fn unread_constraints(&self) -> IndexMap<String, Vec<Span>> {
        let mut found: IndexMap<String, Vec<Span>> = IndexMap::new();
        for skipped in &self.skipped.constraints {
            found.entry(format!("*{}", skipped.keyword)).or_default().push(skipped.span);
        }
        for mpc in self.mpcs.iter().filter(|mpc| mpc.kind.evaluated().is_none()) {
            found.entry(format!("MPC {}", mpc.kind.name())).or_default().push(mpc.span);
        }
        found
    }

    /// The nodes of a coupling, within its radius and without its reference node, with the weights that a distributing one gives them.
    #[must_use]
    pub fn coupling_nodes(&self, coupling: &Coupling) -> Vec<(Label, f64)> {
        let from = self.coordinates(coupling.reference);
        let radius = |label: Label| distance(self.coordinates(label), from);
        let mut nodes = self.surface_nodes(&coupling.surface.value);
        nodes.retain(|(label, _)| {
            *label != coupling.reference
                && coupling.influence_radius.is_none_or(|most| radius(*label) <= most)
        });
        if let CouplingKind::Distributing(weighting) = coupling.kind {
            let farthest = nodes.iter().map(|(label, _)| radius(*label)).fold(0.0, f64::max);
            for (label, weight) in nodes.iter_mut().filter(|_| farthest > 0.0) {
                *weight *= weighting.at(radius(*label) / farthest);
            }
        }
        nodes
    }

    /// The nodes of a rigid body, each once, without the reference node; with whether it is tied by its rotations, where that is said.
    #[must_use]
    pub fn body_nodes(&self, body: &RigidBody) -> Vec<(Label, Option<bool>)> {
        let of_elements = || {
            let set = body.element_set.as_ref().and_then(|name| self.element_sets.get(&name.value));
            let nodes = set.into_iter().flat_map(|set| &set.labels).flat_map(|label| {
                let connector = self.connectors.get(label).map(|element| [element.a, element.b]);
                let point = self.point_elements.get(label);
                let point = point.map(|element| [Some(element.node), element.second]);
                connector.or(point).unwrap_or_default()
            });
            nodes.flatten().map(|node| (node, None))
        };
        let of_set = |name: &Option<Spanned<String>>, tied: bool| {
            let set = name.as_ref().and_then(|name| self.node_sets.get(&name.value));
            let labels = set.into_iter().flat_map(|set| set.labels.iter().copied()).collect::<Vec<_>>();
            labels.into_iter().map(move |node| (node, Some(tied)))
        };
        // What a set says comes before what follows from elements.
        let others = body.others.iter().map(|node| (*node, None));
        let of_sets = of_set(&body.tie_set, true).chain(of_set(&body.pin_set, false));
        let all = of_sets.chain(of_elements()).chain(others);
        let mut known = LabelSet::default();
        all.filter(|(node, _)| *node != body.reference && known.insert(*node)).collect()
    }

    /// The pairs of nodes that a tie ties, the dependent one first: each node of the one surface with the nearest of the other, unless that is
    /// farther than the tolerance. Where none is given it is 5 % of the mean distance between neighbours on the other surface, estimated
    /// from its extent \[R\].
    #[must_use]
    pub fn tied_nodes(&self, tie: &Tie) -> Vec<[Label; 2]> {
        let place = |(label, _): (Label, f64)| (label, self.coordinates(label));
        let slaves: Vec<_> = self.surface_nodes(&tie.slave.value).into_iter().map(place).collect();
        let masters: Vec<_> = self.surface_nodes(&tie.master.value).into_iter().map(place).collect();
        let within = tie_reach(tie, &masters);
        let cell = |x: [f64; 3]| x.map(|x| (x / within).floor());
        let bits = |cell: [f64; 3]| cell.map(|x| (x + 0.0).to_bits());
        let mut cells: HashMap<[u64; 3], Vec<(Label, [f64; 3])>> = HashMap::new();
        for (label, x) in &masters {
            cells.entry(bits(cell(*x))).or_default().push((*label, *x));
        }
        let mut taken: LabelMap<Label> = LabelMap::default();
        let mut found = Vec::new();
        for (slave, x) in slaves {
            let home = cell(x);
            let around = (0..27).map(|n| {
                let step = [n % 3, n / 3 % 3, n / 9].map(|step| f64::from(step) - 1.0);
                bits([0, 1, 2].map(|i| home[i] + step[i]))
            });
            let near = around.filter_map(|key| cells.get(&key)).flatten();
            let nearest = near
                .filter(|(label, _)| *label != slave)
                .map(|(label, at)| (*label, distance(*at, x)))
                .filter(|(_, apart)| *apart <= within)
                .min_by(|one, other| one.1.total_cmp(&other.1).then(one.0.cmp(&other.0)));
            let Some((master, _)) = nearest else { continue };
            // A surface tied to itself: neither of two nodes depends on the other twice.
            if taken.get(&master) != Some(&slave) {
                taken.insert(slave, master);
                found.push([slave, master]);
            }
        }
        found
    }

    /// How far from a node of the other surface of a tie a node is tied to it.
    pub(crate) fn tie_reach(&self, tie: &Tie) -> f64 {
        let masters = self.surface_nodes(&tie.master.value).into_iter();
        let masters: Vec<_> = masters.map(|(label, _)| (label, self.coordinates(label))).collect();
        tie_reach(tie, &masters)
    }

    /// The nodes of the dependent surface that are too far from the other to be tied, and how far is too far.
    pub(crate) fn untied_nodes(&self, tie: &Tie) -> (Vec<Label>, f64) {
        let place = |(label, _): (Label, f64)| (label, self.coordinates(label));
        let masters: Vec<_> = self.surface_nodes(&tie.master.value).into_iter().map(place).collect();
        let tied = self.tied_nodes(tie).into_iter().flatten();
        let known: LabelSet = tied.chain(masters.iter().map(|(label, _)| *label)).collect();
        let slaves = self.surface_nodes(&tie.slave.value).into_iter().map(|(label, _)| label);
        (slaves.filter(|label| !known.contains(label)).collect(), tie_reach(tie, &masters))
    }
}

/// How far from a node of the other surface a node is tied to it.
fn tie_reach(tie: &Tie, masters: &[(Label, [f64; 3])]) -> f64 {
    const SHARE: f64 = 0.05;
    // Nodes that are no farther apart than rounding makes them coincide.
    const ROUNDED: f64 = 1e-12;
    let corner = |of: fn(f64, f64) -> f64, from: f64| {
        masters.iter().fold([from; 3], |corner, (_, x)| [0, 1, 2].map(|i| of(corner[i], x[i])))
    };
    let extent = distance(corner(f64::min, f64::INFINITY), corner(f64::max, f64::NEG_INFINITY));
    let spacing = extent / (masters.len() as f64).sqrt();
    let within = tie.position_tolerance.unwrap_or(SHARE * spacing);
    let largest = masters.iter().flat_map(|(_, x)| x).fold(0.0_f64, |most, x| most.max(x.abs()));
    within.max(ROUNDED * largest).max(f64::MIN_POSITIVE)
}
