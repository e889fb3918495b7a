//! Elements of types that are not read: their numbers, and their nodes, for sets, surfaces and rigid bodies that name them.

pub(super) mod shape;

use crate::label::labelled::LabelSet;
use crate::label::{Instance, Label};
use crate::orientation::{cross, minus};
use pintle_kinematics::scalar::elementary::norm;
use std::collections::HashMap;
use std::sync::Arc;

/// Numbers `first`, `first + step` … `last`.
pub(crate) type Range = (Label, u64, u64);

/// Numbers in ranges, for those of which nothing else is kept.
#[derive(Debug, Clone, Default)]
struct LabelRanges {
    ranges: Vec<(u64, u64)>,
}

impl LabelRanges {
    fn push(&mut self, label: u64) {
        match self.ranges.last_mut() {
            Some((_, last)) if last.checked_add(1) == Some(label) => *last = label,
            _ => self.ranges.push((label, label)),
        }
    }

    /// Orders the ranges, so that [`contains`](Self::contains) can search them.
    fn sort(&mut self) {
        self.ranges.sort_unstable();
        let mut merged: Vec<(u64, u64)> = Vec::new();
        for &(first, last) in &self.ranges {
            match merged.last_mut() {
                Some((_, end)) if first <= *end => *end = last.max(*end),
                _ => merged.push((first, last)),
            }
        }
        self.ranges = merged;
    }

    /// How many of `first`, `first + step` … `last` there are.
    fn count(&self, first: u64, last: u64, step: u64) -> u64 {
        let after = self.ranges.partition_point(|&(_, end)| end < first);
        let overlapping = self.ranges.iter().skip(after).take_while(|&&(begin, _)| begin <= last);
        let up_to = |number: u64| number.checked_sub(first).map_or(0, |distance| distance / step + 1);
        overlapping.map(|&(begin, end)| up_to(end.min(last)) - up_to(begin.saturating_sub(1))).sum()
    }

    /// Those of `first`, `first + step` … `last`. It takes as long as there are such.
    fn within(&self, first: u64, last: u64, step: u64) -> impl Iterator<Item = u64> {
        let after = self.ranges.partition_point(|&(_, end)| end < first);
        let overlapping = self.ranges.iter().skip(after).take_while(move |&&(begin, _)| begin <= last);
        overlapping.flat_map(move |&(begin, end)| {
            let from = begin.saturating_sub(first).div_ceil(step).saturating_mul(step).saturating_add(first);
            (from..=end.min(last)).step_by(usize::try_from(step).unwrap_or(usize::MAX))
        })
    }

    /// How many numbers there are, once they are sorted.
    fn total(&self) -> u64 {
        self.ranges.iter().map(|(first, last)| last - first + 1).sum()
    }

    /// Whether a number is one of them, before they are sorted.
    fn contains_unsorted(&self, number: u64) -> bool {
        self.ranges.iter().any(|(first, last)| (*first..=*last).contains(&number))
    }

    fn contains(&self, label: u64) -> bool {
        let after = self.ranges.partition_point(|&(first, _)| first <= label);
        after.checked_sub(1).and_then(|place| self.ranges.get(place)).is_some_and(|&(_, last)| label <= last)
    }
}

/// The nodes of elements.
#[derive(Debug, Clone, Default)]
struct Connectivity {
    types: Vec<String>,
    /// By number: the type, and where the nodes are.
    elements: HashMap<u64, (usize, usize, usize)>,
    nodes: Vec<u64>,
}

/// The elements of a part, a model or an instance.
#[derive(Debug, Clone, Default)]
struct Others {
    numbers: LabelRanges,
    connectivity: Arc<Connectivity>,
}

/// Elements of types that are not read, by instance.
#[derive(Debug, Clone, Default)]
pub(super) struct OtherElements(HashMap<Option<Instance>, Others>);

/// An element of a type that is not read.
pub(super) struct Element<'a> {
    type_name: &'a str,
    nodes: &'a [u64],
    pub(super) label: Label,
}

impl OtherElements {
    /// An element of this level, without nodes yet.
    pub(super) fn push(&mut self, number: u64, type_name: &str) {
        let Others { numbers, connectivity } = self.0.entry(None).or_default();
        numbers.push(number);
        let known = Arc::make_mut(connectivity);
        if known.types.last().is_none_or(|last| last != type_name) {
            known.types.push(type_name.to_owned());
        }
        let from = known.nodes.len();
        known.elements.insert(number, (known.types.len() - 1, from, from));
    }

    /// Gives the last element nodes. Those of an element that has an item which is no node of this level are not known.
    pub(super) fn extend(&mut self, number: u64, nodes: impl Iterator<Item = Option<Label>>) {
        let Connectivity { elements, nodes: known, .. } =
            Arc::make_mut(&mut self.0.entry(None).or_default().connectivity);
        let mut is_known = true;
        for node in nodes {
            match node.filter(|node| node.instance().is_none()) {
                Some(node) => known.push(node.number()),
                None => is_known = false,
            }
        }
        match elements.get_mut(&number) {
            Some((.., end)) if is_known => *end = known.len(),
            _ => drop(elements.remove(&number)),
        }
    }

    /// The element `master` of this level once more, as `number`, with node numbers that are larger by `by`.
    pub(super) fn copy(&mut self, master: u64, number: u64, by: u64) {
        let Others { numbers, connectivity } = self.0.entry(None).or_default();
        numbers.push(number);
        let known = Arc::make_mut(connectivity);
        let Some((of_type, first, last)) = known.elements.get(&master).copied() else { return };
        let from = known.nodes.len();
        known.nodes.extend_from_within(first..last);
        known.nodes.iter_mut().skip(from).for_each(|node| *node = node.saturating_add(by));
        known.elements.insert(number, (of_type, from, known.nodes.len()));
    }

    /// Takes those of a part as those of its instance.
    pub(super) fn place(&mut self, mut of_part: Self, instance: Instance) {
        if let Some(others) = of_part.0.remove(&None) {
            self.0.insert(Some(instance), others);
        }
    }

    /// Whether there is such a number at this level, before they are sorted.
    pub(super) fn contains_unsorted(&self, number: u64) -> bool {
        self.0.get(&None).is_some_and(|others| others.numbers.contains_unsorted(number))
    }

    pub(super) fn sort(&mut self) {
        self.0.values_mut().for_each(|others| others.numbers.sort());
    }

    pub(super) fn contains(&self, label: Label) -> bool {
        self.0.get(&label.instance()).is_some_and(|others| others.numbers.contains(label.number()))
    }

    /// How many of a range there are.
    pub(super) fn count(&self, (first, last, step): Range) -> u64 {
        let others = self.0.get(&first.instance());
        others.map_or(0, |others| others.numbers.count(first.number(), last, step))
    }

    /// One of them; none where its nodes are not known.
    pub(super) fn element(&self, label: Label) -> Option<Element<'_>> {
        let known = &self.0.get(&label.instance())?.connectivity;
        let (of_type, first, last) = *known.elements.get(&label.number())?;
        let (type_name, nodes) = (known.types.get(of_type)?, known.nodes.get(first..last)?);
        Some(Element { type_name, nodes, label })
    }

    /// Those of a range, each once; none for one whose nodes are not known.
    pub(super) fn within(&self, (first, last, step): Range) -> impl Iterator<Item = Option<Element<'_>>> {
        let instance = first.instance();
        let ranges = self.0.get(&instance).map(|others| others.numbers.within(first.number(), last, step));
        ranges.into_iter().flatten().map(move |number| self.element(Label::of(instance, number)))
    }

    /// The nodes of networks of fluids (type D of CalculiX) that no other element has: their degrees of freedom are no motions.
    pub(super) fn network(&self) -> LabelSet {
        let (mut found, mut others) = (LabelSet::default(), LabelSet::default());
        for (instance, group) in &self.0 {
            let known = &group.connectivity;
            for (of_type, first, last) in known.elements.values() {
                let is_of_network = known.types.get(*of_type).is_some_and(|name| name == "D");
                let nodes = known.nodes.get(*first..*last).unwrap_or_default();
                let nodes = nodes.iter().map(|number| Label::of(*instance, *number));
                if is_of_network { found.extend(nodes) } else { others.extend(nodes) }
            }
        }
        found.retain(|node| !others.contains(node));
        found
    }

    /// The nodes of all, and whether those of each are known.
    pub(super) fn nodes(&self) -> (impl Iterator<Item = Label>, bool) {
        let whole = |others: &Others| others.connectivity.elements.len() as u64 >= others.numbers.total();
        let all = self.0.iter().flat_map(|(instance, others)| {
            others.connectivity.nodes.iter().map(|number| Label::of(*instance, *number))
        });
        (all, self.0.values().all(whole))
    }
}

/// How much of the area of a face falls to each of its corners (length²): A_i = ∫ N_i dA, the tributary areas of nodes. None for a face of second
/// order, whose integrals at the corners are not positive.
///
/// By three nodes A_i = |(b − a) × (c − a)|/6. By four it is Gauss quadrature of 2 × 2 points, exact for a plane face.
pub(super) fn shares(corners: &[[f64; 3]]) -> Option<Vec<f64>> {
    let area = |one: [f64; 3], other: [f64; 3]| norm(cross(one, other));
    match *corners {
        [a, b, c] => Some(vec![area(minus(b, a), minus(c, a)) / 6.0; 3]),
        [a, b, c, d] => {
            let mut shares = vec![0.0; 4];
            let at = 1.0 / 3.0_f64.sqrt();
            for [r, s] in [[-at, -at], [at, -at], [at, at], [-at, at]] {
                let along = |from: f64, one: [f64; 3], two: [f64; 3]| {
                    [0, 1, 2].map(|i| ((1.0 - from) * one[i] + (1.0 + from) * two[i]) / 4.0)
                };
                let here = area(along(s, minus(b, a), minus(c, d)), along(r, minus(d, a), minus(c, b)));
                for (share, [x, y]) in
                    shares.iter_mut().zip([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
                {
                    *share += here * (1.0 + x * r) * (1.0 + y * s) / 4.0;
                }
            }
            Some(shares)
        }
        _ => None,
    }
}

/// Edges of a solid that have a node in their middle, by the numbers of their ends, in the order of these nodes.
const TETRAHEDRON: &[[usize; 2]] = &[[1, 2], [2, 3], [3, 1], [1, 4], [2, 4], [3, 4]];
const WEDGE: &[[usize; 2]] = &[[1, 2], [2, 3], [3, 1], [4, 5], [5, 6], [6, 4], [1, 4], [2, 5], [3, 6]];
const BRICK: &[[usize; 2]] =
    &[[1, 2], [2, 3], [3, 4], [4, 1], [5, 6], [6, 7], [7, 8], [8, 5], [1, 5], [2, 6], [3, 7], [4, 8]];

impl Element<'_> {
    /// Its nodes.
    pub(super) fn nodes(&self) -> impl Iterator<Item = Label> {
        self.nodes.iter().map(|number| Label::of(self.label.instance(), *number))
    }

    /// The nodes of a face by its identifier: S1 … of solids and of elements in a plane, SPOS and SNEG, E1 … of shells. Numbers
    /// are those of the Abaqus element library. None for an element or a face that is not one of these.
    pub(super) fn face(&self, face: &str) -> Option<Vec<Label>> {
        let (corners, edges): (&[usize], &[[usize; 2]]) = match (self.shape()?, self.nodes.len(), face) {
            (Shape::Solid, 4 | 10, _) => {
                let faces = [[1, 2, 3], [1, 4, 2], [2, 4, 3], [3, 4, 1]];
                return Some(self.labels(faces.get(side(face, 'S')?)?, TETRAHEDRON, 4));
            }
            (Shape::Solid, 6 | 15, _) => {
                let faces: [&[usize]; 5] =
                    [&[1, 2, 3], &[4, 6, 5], &[1, 4, 5, 2], &[2, 5, 6, 3], &[3, 6, 4, 1]];
                return Some(self.labels(faces.get(side(face, 'S')?)?, WEDGE, 6));
            }
            (Shape::Solid, 8 | 20, _) => {
                let faces =
                    [[1, 2, 3, 4], [5, 8, 7, 6], [1, 5, 6, 2], [2, 6, 7, 3], [3, 7, 8, 4], [4, 8, 5, 1]];
                return Some(self.labels(faces.get(side(face, 'S')?)?, BRICK, 8));
            }
            (Shape::Shell, 3..=9, "SPOS" | "SNEG") => return Some(self.nodes().collect()),
            (Shape::Shell | Shape::Plane, 3 | 6, _) => (&[1, 2, 3], &[[1, 2], [2, 3], [3, 1]]),
            (Shape::Shell | Shape::Plane, 4 | 8, _) => (&[1, 2, 3, 4], &[[1, 2], [2, 3], [3, 4], [4, 1]]),
            _ => return None,
        };
        let letter = if self.shape()? == Shape::Plane { 'S' } else { 'E' };
        let edge = edges.get(side(face, letter)?)?;
        Some(self.labels(edge, edges, corners.len()))
    }

    /// The type of an element that distributes forces in space.
    pub(super) const DISTRIBUTES: &'static str = "DCOUP3D";

    /// Whether it distributes forces.
    pub(super) fn distributes(&self) -> bool {
        self.type_name == Self::DISTRIBUTES
    }

    /// Whether it is a solid, whose nodes have no rotations.
    pub(super) fn is_solid(&self) -> bool {
        self.shape() == Some(Shape::Solid)
    }

    /// Whether a face is an edge: that of an element in a plane, or E1 … of a shell.
    pub(super) fn is_edge(&self, face: &str) -> bool {
        self.shape().is_some_and(|shape| shape != Shape::Solid) && !["SPOS", "SNEG"].contains(&face)
    }

    /// The nodes with these numbers, and those in the middle of edges between them, in their order around.
    fn labels(&self, corners: &[usize], edges: &[[usize; 2]], count: usize) -> Vec<Label> {
        let last = if corners.len() > 2 { corners.len() } else { 1 };
        let sides = (0..last).map(|i| [corners[i], corners[(i + 1) % corners.len()]]);
        let is_side = |[a, b]: [usize; 2], ends: &[usize; 2]| *ends == [a, b] || *ends == [b, a];
        let inner = sides.filter_map(|side| edges.iter().position(|ends| is_side(side, ends)));
        let places = corners.iter().map(|corner| corner - 1).chain(inner.map(|place| count + place));
        places.filter_map(|place| Some(Label::of(self.label.instance(), *self.nodes.get(place)?))).collect()
    }

    fn shape(&self) -> Option<Shape> {
        let begins = |names: &[&str]| names.iter().any(|name| self.type_name.starts_with(name));
        match () {
            () if begins(&["C3D", "SC6", "SC8"]) => Some(Shape::Solid),
            () if begins(&["CPE", "CPS", "CAX"]) => Some(Shape::Plane),
            () if begins(&["S3", "S4", "S6", "S8", "S9", "STRI", "M3D", "R3D"]) => Some(Shape::Shell),
            () => None,
        }
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Shape {
    Solid,
    Plane,
    Shell,
}

/// The number of a side, from 0: that of S3 is 2.
fn side(face: &str, letter: char) -> Option<usize> {
    face.strip_prefix(letter)?.parse::<usize>().ok()?.checked_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces of a solid hold each edge twice, and of a second-order one each node in the middle of an edge.
    #[test]
    fn faces_close_their_solids() {
        let mut compared = 0;
        for (type_name, count, faces, edges) in [
            ("C3D4", 4, 4, TETRAHEDRON),
            ("C3D10M", 10, 4, TETRAHEDRON),
            ("C3D6", 6, 5, WEDGE),
            ("C3D15", 15, 5, WEDGE),
            ("C3D8R", 8, 6, BRICK),
            ("C3D20", 20, 6, BRICK),
        ] {
            let nodes: Vec<Label> = (1..=count).map(Label::from).collect();
            let mut others = OtherElements::default();
            others.push(7, type_name);
            others.extend(7, nodes.into_iter().map(Some));
            let element = others.element(Label::from(7)).unwrap();
            let of = |face: usize| element.face(&format!("S{face}")).unwrap();
            assert!(element.face(&format!("S{}", faces + 1)).is_none() && element.face("SPOS").is_none());
            let mut known = [0; 21];
            for face in 1..=faces {
                let labels: Vec<usize> = of(face).iter().map(|label| label.number() as usize).collect();
                labels.iter().for_each(|label| known[*label] += 1);
            }
            for [one, other] in edges {
                let both = |face: &usize| {
                    [one, other].iter().all(|end| of(*face).contains(&Label::from(**end as u64)))
                };
                assert_eq!((1..=faces).filter(both).count(), 2, "{type_name} {one} {other}");
                compared += 1;
            }
            let corners = edges.iter().flatten().max().unwrap();
            assert!(
                known[corners + 1..=count as usize].iter().all(|times| *times == 2),
                "{type_name} {known:?}"
            );
        }
        assert_eq!(compared, 54);
    }

    #[test]
    fn ranges_find_their_members() {
        let mut ranges = LabelRanges::default();
        for label in [10, 11, 12, 3, 4, 11, 12, 13, 20] {
            ranges.push(label);
        }
        ranges.sort();
        for (first, last, step) in [(1, 25, 1), (1, 25, 3), (3, 3, 1), (4, 12, 4), (5, 9, 1), (11, 30, 9)] {
            let met = (first..=last).step_by(step as usize).filter(|&label| ranges.contains(label)).count();
            assert_eq!(ranges.count(first, last, step), met as u64, "{first} to {last} by {step}");
            assert_eq!(ranges.within(first, last, step).count(), met, "{first} to {last} by {step}");
            assert!(ranges.within(first, last, step).all(|label| ranges.contains(label)));
        }
        let inside: Vec<u64> = (0..25).filter(|&label| ranges.contains(label)).collect();
        assert_eq!(inside, [3, 4, 10, 11, 12, 13, 20]);
    }
}
