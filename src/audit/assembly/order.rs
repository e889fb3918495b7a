//! In which order are nodes eliminated, and which belong together?

use std::collections::{BTreeSet, HashSet};
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
/// # Errors
/// The number of neighbours of a vertex at its turn, where that is more than `most`: elimination would fill the matrix.
pub(super) fn minimum_degree(count: usize, cliques: &[Vec<u32>], most: usize) -> Result<Vec<u32>, usize> {
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
    let mut order = Vec::with_capacity(count);
    while let Some((_, v)) = queue.pop_first() {
        order.push(v);
        let joined: Vec<u32> = std::mem::take(&mut neighbours[v as usize]).into_iter().collect();
        if joined.len() > most {
            return Err(joined.len());
        }
        for w in &joined {
            let set = &mut neighbours[*w as usize];
            queue.remove(&(set.len() as u32, *w));
            set.remove(&v);
            set.extend(joined.iter().filter(|other| *other != w));
            queue.insert((set.len() as u32, *w));
        }
    }
    Ok(order)
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
    use super::minimum_degree;

    #[test]
    fn leaves_come_before_their_hub() {
        let star: Vec<Vec<u32>> = (1..6).map(|leaf| vec![0, leaf]).collect();
        let order = minimum_degree(6, &star, 1).unwrap_or_default();
        assert_eq!(order.len(), 6);
        let hub = order.iter().position(|v| *v == 0).unwrap_or_default();
        assert!(hub >= 4, "{order:?}");
    }

    /// In a complete graph the first vertex has all others for neighbours.
    #[test]
    fn what_would_be_filled_is_refused() {
        let complete = [(0..9).collect::<Vec<u32>>()];
        assert_eq!(minimum_degree(9, &complete, 7), Err(8));
        assert_eq!(minimum_degree(9, &complete, 8).map(|order| order.len()), Ok(9));
    }
}
