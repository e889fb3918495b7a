//! In which order are nodes eliminated, and which belong together?

use std::cmp::Ordering;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

/// A hash of small numbers.
#[derive(Default)]
pub(super) struct Mix(u64);

impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u32(&mut self, number: u32) {
        self.write_u64(u64::from(number));
    }

    fn write_u64(&mut self, number: u64) {
        let mixed = (self.0 ^ number).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 = mixed ^ (mixed >> 29);
    }
}

type Neighbours = HashSet<u32, BuildHasherDefault<Mix>>;

/// The vertices of a graph, each after those of least degree at its turn (Markowitz; Tinney and Walker, scheme 2): what is eliminated
/// leaves its neighbours joined to each other. `cliques` are sets of vertices that are joined to each other.
///
/// `None` where what is left joined has more than so many pairs in all: to find the order takes as long.
pub(super) fn minimum_degree(count: usize, cliques: &[Vec<u32>], most: usize) -> Option<Vec<u32>> {
    let mut neighbours: Vec<Neighbours> = vec![Neighbours::default(); count];
    for clique in cliques {
        for v in clique {
            for w in clique.iter().filter(|w| *w != v) {
                neighbours[*v as usize].insert(*w);
            }
        }
    }
    let mut queue: BTreeSet<(u32, u32)> =
        neighbours.iter().enumerate().map(|(v, joined)| (joined.len() as u32, v as u32)).collect();
    let (mut order, mut left) = (Vec::with_capacity(count), most);
    while let Some((_, v)) = queue.pop_first() {
        order.push(v);
        let joined: Vec<u32> = std::mem::take(&mut neighbours[v as usize]).into_iter().collect();
        left = left.checked_sub(joined.len().pow(2))?;
        for w in &joined {
            let set = &mut neighbours[*w as usize];
            queue.remove(&(set.len() as u32, *w));
            set.remove(&v);
            set.extend(joined.iter().filter(|other| *other != w));
            queue.insert((set.len() as u32, *w));
        }
    }
    Some(order)
}

/// What an elimination will cost: Σ c f², where c is the number of columns of a vertex and f that of its front, which is it and what those
/// before it leave joined to it (symbolic factorization along the elimination tree; Liu, 1990).
pub(super) fn predicted(order: &[u32], cliques: &[Vec<u32>], columns: &[usize]) -> f64 {
    let mut turn = vec![0; order.len()];
    for (at, v) in (0..).zip(order) {
        turn[*v as usize] = at;
    }
    // Sets of turns that are joined, each at the first of them.
    let mut waiting: Vec<Vec<Vec<u32>>> = vec![Vec::new(); order.len()];
    for clique in cliques {
        let set: Vec<u32> = clique.iter().map(|v| turn[*v as usize]).collect();
        if let Some(first) = set.iter().min() {
            waiting[*first as usize].push(set);
        }
    }
    let (mut sum, mut seen) = (0.0, vec![usize::MAX; order.len()]);
    for (at, v) in order.iter().enumerate() {
        let (mut later, mut front) = (Vec::new(), columns[*v as usize]);
        seen[at] = at;
        for other in std::mem::take(&mut waiting[at]).into_iter().flatten() {
            if seen[other as usize] != at {
                seen[other as usize] = at;
                front += columns[order[other as usize] as usize];
                later.push(other);
            }
        }
        sum += columns[*v as usize] as f64 * (front as f64).powi(2);
        if let Some(next) = later.iter().min() {
            waiting[*next as usize].push(later);
        }
    }
    sum
}

/// The vertices of a graph so that sets which others separate come before those (nested dissection; George, 1973, by levels of distance from
/// a far vertex as in his automatic one). Small sets are ordered by least degree.
pub(super) fn dissection(count: usize, cliques: &[Vec<u32>]) -> Vec<u32> {
    /// Sets of no more vertices are not divided.
    const LEAF: usize = 60;
    let mut joined: Vec<Vec<u32>> = vec![Vec::new(); count];
    for clique in cliques {
        for v in clique {
            joined[*v as usize].extend(clique.iter().filter(|w| *w != v));
        }
    }
    joined.iter_mut().for_each(|of| {
        of.sort_unstable();
        of.dedup();
    });
    // The set that each vertex is in; what was put last into the order is in none.
    let mut set_of: Vec<u32> = vec![1; count];
    let (mut sets, mut next) = (vec![(0..count as u32).collect::<Vec<u32>>()], 2);
    let mut reversed = Vec::with_capacity(count);
    while let Some(set) = sets.pop() {
        let Some(first) = set.first() else { continue };
        let own = set_of[*first as usize];
        let levels = if set.len() > LEAF { far_levels(&joined, &set_of, *first) } else { Vec::new() };
        let reached: usize = levels.iter().map(Vec::len).sum();
        if reached > 0 && reached < set.len() {
            // Parts that are not joined.
            for v in levels.iter().flatten() {
                set_of[*v as usize] = next;
            }
            next += 1;
            sets.push(set.into_iter().filter(|v| set_of[*v as usize] == own).collect());
            sets.push(levels.into_iter().flatten().collect());
            continue;
        }
        let Some(middle) = separator(&levels) else {
            let place: HashMap<u32, u32, BuildHasherDefault<Mix>> =
                set.iter().enumerate().map(|(at, v)| (*v, at as u32)).collect();
            let edges: Vec<Vec<u32>> = set
                .iter()
                .flat_map(|v| joined[*v as usize].iter().filter(move |w| *w > v).map(move |w| (v, w)))
                .filter_map(|(v, w)| Some(vec![*place.get(v)?, *place.get(w)?]))
                .collect();
            let order = minimum_degree(set.len(), &edges, usize::MAX).unwrap_or_default();
            reversed.extend(order.iter().rev().map(|at| set[*at as usize]));
            set.iter().for_each(|v| set_of[*v as usize] = 0);
            continue;
        };
        let [low, high] = [next, next + 1];
        next += 2;
        for (level, vertices) in levels.iter().enumerate() {
            let to = match level.cmp(&middle) {
                Ordering::Less => low,
                Ordering::Equal => 0,
                Ordering::Greater => high,
            };
            vertices.iter().for_each(|v| set_of[*v as usize] = to);
        }
        // What of the level has nothing beyond it does not separate.
        for v in &levels[middle] {
            if joined[*v as usize].iter().any(|w| set_of[*w as usize] == high) {
                reversed.push(*v);
            } else {
                set_of[*v as usize] = low;
            }
        }
        sets.push(set.iter().copied().filter(|v| set_of[*v as usize] == low).collect());
        sets.push(set.iter().copied().filter(|v| set_of[*v as usize] == high).collect());
    }
    reversed.reverse();
    reversed
}

/// The vertices of the set of one by their distance from a vertex that is far from others.
fn far_levels(joined: &[Vec<u32>], set_of: &[u32], from: u32) -> Vec<Vec<u32>> {
    let mut levels = levels_from(joined, set_of, from);
    for _ in 0..4 {
        let Some(last) =
            levels.last().and_then(|last| last.iter().min_by_key(|v| joined[**v as usize].len()))
        else {
            break;
        };
        let next = levels_from(joined, set_of, *last);
        if next.len() <= levels.len() {
            break;
        }
        levels = next;
    }
    levels
}

fn levels_from(joined: &[Vec<u32>], set_of: &[u32], from: u32) -> Vec<Vec<u32>> {
    let own = set_of[from as usize];
    let mut seen: HashSet<u32, BuildHasherDefault<Mix>> = HashSet::default();
    seen.insert(from);
    let mut levels = vec![vec![from]];
    loop {
        let mut next = Vec::new();
        for v in levels.last().into_iter().flatten() {
            for w in &joined[*v as usize] {
                if set_of[*w as usize] == own && seen.insert(*w) {
                    next.push(*w);
                }
            }
        }
        if next.is_empty() {
            return levels;
        }
        levels.push(next);
    }
}

/// The smallest level of those in the middle; none where there is nothing on both sides.
fn separator(levels: &[Vec<u32>]) -> Option<usize> {
    let all: usize = levels.iter().map(Vec::len).sum();
    let mut before = 0;
    let mut best: Option<(usize, usize)> = None;
    for (level, vertices) in levels.iter().enumerate() {
        let after = all - before - vertices.len();
        if before.min(after) * 10 >= all * 3
            || (best.is_none() && before.min(after) > 0 && before * 2 + vertices.len() >= all)
        {
            let is_smaller = best.is_none_or(|(_, least)| vertices.len() < least);
            if is_smaller {
                best = Some((level, vertices.len()));
            }
        }
        before += vertices.len();
    }
    best.map(|(level, _)| level)
}

/// The pairs of nodes that may be joined while an order by least degree is sought, a second or two: of what is joined in three dimensions dissection
/// leaves smaller fronts.
const PAIRS: usize = 150_000_000;
/// What costs more by least degree may cost less by dissection, which is tried.
const DIVIDED: f64 = 1e8;

/// In which orders groups of columns are eliminated.
#[derive(Clone, Debug, Default)]
pub(super) struct Orders {
    /// That of least cost.
    pub(super) best: Vec<u32>,
    /// That by least degree, where it is known: in it rows that are put in one by one stay sparser than by dissection.
    pub(super) by_degree: Vec<u32>,
    /// What the elimination is predicted to cost ([`predicted`]).
    pub(super) cost: f64,
}

impl Orders {
    /// The orders of groups of so many columns, of which these sets are joined.
    pub(super) fn of(cliques: &[Vec<u32>], widths: &[usize]) -> Self {
        let cost = |order: &[u32]| predicted(order, cliques, widths);
        let by_degree = minimum_degree(widths.len(), cliques, PAIRS);
        let cost_by_degree = by_degree.as_ref().map_or(f64::INFINITY, |order| cost(order));
        let (mut best, mut least) = (None, cost_by_degree);
        if cost_by_degree > DIVIDED {
            let by_dissection = dissection(widths.len(), cliques);
            least = cost(&by_dissection);
            best = Some(by_dissection).filter(|_| least < cost_by_degree);
        }
        let by_degree = by_degree.or_else(|| best.clone()).unwrap_or_default();
        let best = best.unwrap_or_else(|| by_degree.clone());
        Self { best, by_degree, cost: least.min(cost_by_degree) }
    }
}

/// Sets of things that are joined, directly or through others.
pub(super) struct Union {
    parent: Vec<u32>,
}

impl Union {
    pub(super) fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// What stands for the set of v.
    pub(super) fn find(&mut self, v: u32) -> u32 {
        let mut root = v;
        while self.parent[root as usize] != root {
            let up = self.parent[root as usize];
            self.parent[root as usize] = self.parent[up as usize];
            root = self.parent[root as usize];
        }
        root
    }

    /// Joins the sets of v and w.
    pub(super) fn join(&mut self, v: u32, w: u32) {
        let (v, w) = (self.find(v), self.find(w));
        let (low, high) = (v.min(w), v.max(w));
        self.parent[high as usize] = low;
    }
}

#[cfg(test)]
mod tests {
    use super::{dissection, minimum_degree, predicted};
    use std::collections::BTreeSet;

    #[test]
    fn leaves_come_before_their_hub() {
        let star: Vec<Vec<u32>> = (1..6).map(|leaf| vec![0, leaf]).collect();
        let order = minimum_degree(6, &star, 5).unwrap_or_default();
        assert_eq!(order.len(), 6);
        let hub = order.iter().position(|v| *v == 0).unwrap_or_default();
        assert!(hub >= 4, "{order:?}");
    }

    /// A cube of n³ vertices comes apart along its planes: what is joined when one is eliminated is at most about two of them.
    #[test]
    fn a_cube_comes_apart() {
        let n = 9_u32;
        let at = |i: u32, j: u32, k: u32| (i * n + j) * n + k;
        let mut edges = Vec::new();
        for (i, j, k) in (0..n * n * n).map(|v| (v / n / n, v / n % n, v % n)) {
            for (p, q, r) in [(i + 1, j, k), (i, j + 1, k), (i, j, k + 1)] {
                if p.max(q).max(r) < n {
                    edges.push(vec![at(i, j, k), at(p, q, r)]);
                }
            }
        }
        let count = (n * n * n) as usize;
        let order = dissection(count, &edges);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..n * n * n).collect::<Vec<_>>());
        let mut joined = vec![BTreeSet::new(); count];
        for edge in &edges {
            joined[edge[0] as usize].insert(edge[1]);
            joined[edge[1] as usize].insert(edge[0]);
        }
        let mut most = 0;
        for v in order {
            let of = std::mem::take(&mut joined[v as usize]);
            most = most.max(of.len());
            for w in &of {
                joined[*w as usize].remove(&v);
                joined[*w as usize].extend(of.iter().filter(|other| *other != w));
            }
        }
        assert!(most <= 2 * (n * n) as usize, "{most}");
    }

    /// In a complete graph the first vertex has all others for neighbours, and so on.
    #[test]
    fn what_would_take_long_is_refused() {
        let complete = [(0..9).collect::<Vec<u32>>()];
        let squares = (0..9).map(|n| n * n).sum();
        assert_eq!(minimum_degree(9, &complete, squares - 1), None);
        assert_eq!(minimum_degree(9, &complete, squares).map(|order| order.len()), Some(9));
    }

    /// A path from one end has fronts of two vertices; from its middle of three, and then of two; a complete graph has all that are left.
    #[test]
    fn costs_are_those_of_fronts() {
        let path: Vec<Vec<u32>> = (0..4).map(|v| vec![v, v + 1]).collect();
        assert_eq!(predicted(&[0, 1, 2, 3, 4], &path, &[1; 5]), 4.0 * 4.0 + 1.0);
        assert_eq!(predicted(&[2, 0, 1, 3, 4], &path, &[1; 5]), 9.0 + 3.0 * 4.0 + 1.0);
        assert_eq!(predicted(&[0, 1, 2, 3, 4], &path, &[3; 5]), 27.0 * 17.0);
        let complete = [(0..4).collect::<Vec<u32>>()];
        assert_eq!(predicted(&[3, 1, 0, 2], &complete, &[1; 4]), 16.0 + 9.0 + 4.0 + 1.0);
    }
}
