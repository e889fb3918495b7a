//! In which order are nodes eliminated, and which belong together?

use std::collections::{BTreeSet, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

/// A hash of small numbers.
#[derive(Default)]
pub(crate) struct Mix(u64);

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

/// The vertices of a graph, each after those of least degree at its turn (Markowitz; Tinney and Walker, scheme 2). What is
/// eliminated leaves its neighbours joined to each other. `cliques` are sets of vertices that are joined to each other, `widths`
/// their columns.
///
/// `None` where the elimination would take more than so many operations, or where the order itself would take too long to find. The
/// operations are Σ c f², with c the columns of a vertex and f those of its front (it, and what is joined to it at its turn).
pub(crate) fn minimum_degree(widths: &[usize], cliques: &[Vec<u32>], most: usize) -> Option<Vec<u32>> {
    /// Pairs that may be joined while the order is sought, a second or two.
    const PAIRS: usize = 150_000_000;
    let count = widths.len();
    let mut neighbours: Vec<Neighbours> = vec![Neighbours::default(); count];
    let (private, before) = private(widths, cliques);
    let is_private = |v: u32| private.get(v as usize).is_some_and(|is| *is);
    for clique in cliques {
        let others: Vec<u32> = clique.iter().copied().filter(|v| !is_private(*v)).collect();
        for v in &others {
            for w in others.iter().filter(|w| *w != v) {
                neighbours[*v as usize].insert(*w);
            }
        }
    }
    let mut queue: BTreeSet<(u32, u32)> = neighbours
        .iter()
        .enumerate()
        .map(|(v, joined)| (joined.len() as u32, v as u32))
        .filter(|(_, v)| !is_private(*v))
        .collect();
    let (mut order, mut operations, mut pairs) = (Vec::with_capacity(count), most, PAIRS);
    order.extend((0..count as u32).filter(|v| is_private(*v)));
    operations = operations.checked_sub(before)?;
    while let Some((_, v)) = queue.pop_first() {
        order.push(v);
        let joined: Vec<u32> = std::mem::take(&mut neighbours[v as usize]).into_iter().collect();
        let own = widths[v as usize];
        let front = own + joined.iter().map(|w| widths[*w as usize]).sum::<usize>();
        operations = operations.checked_sub(own * front.pow(2))?;
        pairs = pairs.checked_sub(joined.len().pow(2))?;
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

/// The vertices of large cliques that no other row joins, and the operations that they take when they come first.
///
/// A clique of many vertices is that of a mean or an equation, and has no more rows than [`ROWS`]. Each pivot takes one of them, so that
/// they are used up by the first few vertices: what they leave joined are the vertices that others join too.
fn private(widths: &[usize], cliques: &[Vec<u32>]) -> (Vec<bool>, usize) {
    /// So many vertices make a clique large.
    const LARGE: usize = 64;
    /// The rows of one.
    const ROWS: usize = 6;
    let large: HashSet<&Vec<u32>> = cliques.iter().filter(|clique| clique.len() > LARGE).collect();
    if large.is_empty() {
        return (Vec::new(), 0);
    }
    let mut joins = vec![0_usize; widths.len()];
    let small = cliques.iter().filter(|clique| clique.len() <= LARGE);
    for v in small.chain(large.iter().copied()).flatten() {
        joins[*v as usize] += 1;
    }
    let mut private = vec![false; widths.len()];
    let mut operations = 0;
    for clique in large {
        let front: usize = clique.iter().map(|v| widths[*v as usize]).sum();
        operations += ROWS * ROWS * front;
        for v in clique.iter().filter(|v| joins[**v as usize] == 1) {
            private[*v as usize] = true;
        }
    }
    (private, operations)
}

/// Sets of things that are joined, directly or through others.
pub(crate) struct Union {
    parent: Vec<u32>,
}

impl Union {
    pub(crate) fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// What stands for the set of v.
    pub(crate) fn find(&mut self, v: u32) -> u32 {
        let mut root = v;
        while self.parent[root as usize] != root {
            let up = self.parent[root as usize];
            self.parent[root as usize] = self.parent[up as usize];
            root = self.parent[root as usize];
        }
        root
    }

    /// Joins the sets of v and w.
    pub(crate) fn join(&mut self, v: u32, w: u32) {
        let (v, w) = (self.find(v), self.find(w));
        let (low, high) = (v.min(w), v.max(w));
        self.parent[high as usize] = low;
    }
}

#[cfg(test)]
mod tests {
    use super::minimum_degree;

    #[test]
    fn leaves_come_before_their_hub() {
        let star: Vec<Vec<u32>> = (1..6).map(|leaf| vec![0, leaf]).collect();
        let order = minimum_degree(&[1; 6], &star, usize::MAX).unwrap_or_default();
        assert_eq!(order.len(), 6);
        let hub = order.iter().position(|v| *v == 0).unwrap_or_default();
        assert!(hub >= 4, "{order:?}");
    }

    /// What many rows of few vertices would fill, few rows of many do not: all of them but those that others join come first.
    #[test]
    fn a_mean_of_many_costs_little() {
        let mut cliques = vec![(0..1000).collect::<Vec<u32>>(); 2];
        cliques.push(vec![0, 7]);
        let order = minimum_degree(&[3; 1000], &cliques, 36 * 3000 + 1000).unwrap_or_default();
        assert_eq!(order.len(), 1000);
        let mut last = order[998..].to_vec();
        last.sort_unstable();
        assert_eq!(last, [0, 7]);
    }

    /// A path has fronts of two vertices but for the last, a complete graph of all that are left; an operation less than that is too few.
    #[test]
    fn what_would_take_long_is_refused() {
        let path: Vec<Vec<u32>> = (0..4).map(|v| vec![v, v + 1]).collect();
        let complete = vec![(0..4).collect::<Vec<u32>>()];
        for (count, width, cliques, operations) in
            [(5, 1, &path, 4 * 4 + 1), (5, 3, &path, 27 * (4 * 4 + 1)), (4, 1, &complete, 16 + 9 + 4 + 1)]
        {
            let order = |most: usize| minimum_degree(&vec![width; count], cliques, most);
            assert_eq!(order(operations).map(|order| order.len()), Some(count), "{operations}");
            assert_eq!(order(operations - 1), None, "{operations}");
        }
    }
}
