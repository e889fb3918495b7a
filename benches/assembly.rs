//! Time and memory of the analysis of whole assemblies, checked before they are measured: `cargo bench --bench assembly [CONNECTORS]`.
//!
//! A chain of pendulums, a closed loop, a tree, and a grid of four-bar loops, of 1e5 connectors each unless told otherwise. Each is
//! analysed at a quarter of the size too: memory that is linear is four times as much at the full one. Then grids of scissors, cubic lattices of BEAMs and of
//! LINKs, and such whose nodes are moved off them. `cargo bench --bench assembly decks FOLDER` writes the same models as decks instead, for `pintle audit
//! --model-only`.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a bench")]

#[path = "hand/commit.rs"]
mod commit;

use peak_alloc::PeakAlloc;
use pintle_assembly::{Assembly, Holds, OPERATIONS, analyse};
use pintle_model::evaluate::Model;
use pintle_scene::Scene;
use std::fmt::Write;
use std::time::Instant;

#[global_allocator]
static PEAK: PeakAlloc = PeakAlloc;

/// A deck of hinges about z and rigid links.
#[derive(Default)]
struct Deck {
    nodes: String,
    hinges: String,
    links: String,
    fixed: String,
    count: usize,
    elements: usize,
}

impl Deck {
    fn node(&mut self, [x, y]: [f64; 2]) -> usize {
        self.count += 1;
        writeln!(self.nodes, "{}, {x:?}, {y:?}, 0.", self.count).unwrap();
        self.count
    }

    fn hinge(&mut self, a: usize, b: usize) {
        self.elements += 1;
        writeln!(self.hinges, "{}, {a}, {b}", self.elements).unwrap();
    }

    fn link(&mut self, a: usize, b: usize) {
        self.elements += 1;
        writeln!(self.links, "{}, {a}, {b}", self.elements).unwrap();
    }

    fn ground(&mut self, node: usize) {
        writeln!(self.fixed, "{node}, 1, 6").unwrap();
    }

    fn text(self) -> String {
        let Self { nodes, hinges, links, fixed, .. } = self;
        format!(
            "*NODE\n{nodes}*ELEMENT, TYPE=CONN3D2, ELSET=H\n{hinges}*ELEMENT, TYPE=CONN3D2, ELSET=L\n{links}\
             *ORIENTATION, NAME=Z\n0., 0., 1., 1., 0., 0.\n*CONNECTOR SECTION, ELSET=H\nHINGE\nZ,\n\
             *CONNECTOR SECTION, ELSET=L\nBEAM\n*BOUNDARY\n{fixed}"
        )
    }
}

/// Links and hinges in turn; with `closed`, both ends are on the ground and the points lie on a circle.
fn chain(connectors: usize, closed: bool) -> (String, [usize; 2]) {
    let links = connectors / 2;
    let mut deck = Deck::default();
    let at = |i: usize| {
        let angle = 6.0 * i as f64 / links as f64;
        let radius = links as f64 / 6.0;
        if closed { [radius * angle.cos(), radius * angle.sin()] } else { [i as f64, 0.0] }
    };
    let mut end = deck.node(at(0));
    deck.ground(end);
    for i in 0..links {
        let (low, high) = (deck.node(at(i)), deck.node(at(i + 1)));
        deck.hinge(end, low);
        deck.link(low, high);
        end = high;
    }
    if closed {
        let last = deck.node(at(links));
        deck.hinge(end, last);
        deck.ground(last);
        return (deck.text(), [links - 2, 3]);
    }
    (deck.text(), [links, 0])
}

/// Every link carries two others.
fn tree(connectors: usize) -> (String, [usize; 2]) {
    let links = connectors / 2;
    let mut deck = Deck::default();
    let root = deck.node([0.0; 2]);
    deck.ground(root);
    let mut ends = vec![(root, [0.0, 0.0])];
    for i in 0..links {
        let (from, [x, y]) = ends[i / 2];
        let angle = 1.0 + i as f64 * 0.7;
        let to = [x + angle.cos(), y + angle.sin()];
        let (low, high) = (deck.node([x, y]), deck.node(to));
        deck.hinge(from, low);
        deck.link(low, high);
        ends.push((high, to));
    }
    (deck.text(), [links, 0])
}

/// Square meshes of hinged bars: at each crossing four bars meet, joined to each other by three hinges. Every row and column of meshes can be
/// sheared: 2 n − 3 ways in all.
fn grid(connectors: usize) -> (String, [usize; 2]) {
    let n = ((connectors as f64 / 5.0).sqrt() as usize).max(3);
    let mut deck = Deck::default();
    let at = |i: usize, j: usize| [i as f64 + 0.2 * j as f64, j as f64];
    let mut ends: Vec<Vec<usize>> = vec![Vec::new(); n * n];
    for i in 0..n {
        for j in 0..n {
            for (k, l) in [(i + 1, j), (i, j + 1)] {
                if k < n && l < n {
                    let (a, b) = (deck.node(at(i, j)), deck.node(at(k, l)));
                    deck.link(a, b);
                    ends[i * n + j].push(a);
                    ends[k * n + l].push(b);
                }
            }
        }
    }
    for ends in &ends {
        for pair in ends.windows(2) {
            deck.hinge(pair[0], pair[1]);
        }
    }
    deck.ground(ends[0][0]);
    let (mobility, links) = (2 * n - 3, 2 * n * (n - 1));
    let hinges = deck.elements - links;
    // One node is on the ground: 6 degrees of freedom for each other end of a link.
    let redundant = mobility + 6 * links + 5 * hinges - 6 * (2 * links - 1);
    (deck.text(), [mobility, redundant])
}

/// n by n pairs of bars that cross in the middle, hinged there and to the next at their ends: all move together, in one way.
fn scissors(n: usize) -> (String, [usize; 2]) {
    let mut deck = Deck::default();
    let mut ends: Vec<Vec<usize>> = vec![Vec::new(); (n + 1) * (n + 1)];
    let mut pins = Vec::new();
    for (i, j) in (0..n * n).map(|cell| (cell / n, cell % n)) {
        let middle = [i as f64 + 0.5, j as f64 + 0.5];
        let pin = [[(i, j), (i + 1, j + 1)], [(i + 1, j), (i, j + 1)]].map(|corners| {
            let crossing = deck.node(middle);
            for (k, l) in corners {
                let end = deck.node([k as f64, l as f64]);
                deck.link(end, crossing);
                ends[k * (n + 1) + l].push(end);
            }
            crossing
        });
        pins.push(pin);
    }
    let links = deck.elements;
    pins.extend(ends.iter().flat_map(|ends| ends.windows(2).map(|pair| [pair[0], pair[1]])));
    pins.iter().for_each(|[a, b]| deck.hinge(*a, *b));
    deck.ground(1);
    let (mobility, nodes) = (1, deck.count);
    let redundant = mobility + 6 * links + 5 * pins.len() - 6 * (nodes - 1);
    (deck.text(), [mobility, redundant])
}

/// A cubic lattice of n³ nodes with a BEAM between neighbours, the first node held: nothing moves.
fn beams(n: usize) -> (String, [usize; 2]) {
    let (text, [mobility, _]) = lattice(n, 0.0);
    let links = 3 * (n * n * n - 1) - mobility;
    let text = text.replace("\nLINK\n", "\nBEAM\n").replace("\n1, 1, 3\n", "\n1, 1, 6\n");
    (text, [0, 6 * (links + 1 - n * n * n)])
}

/// A cubic lattice of n³ nodes with a LINK between neighbours, the first node held; nodes moved at random by up to `moved`, so that rows that cross
/// each other fill. No link is redundant.
fn lattice(n: usize, moved: f64) -> (String, [usize; 2]) {
    let at = |i: usize, j: usize, k: usize| (i * n + j) * n + k + 1;
    let (mut nodes, mut links, mut count) = (String::new(), String::new(), 0);
    let mut random = 1_u64;
    let mut off = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        moved * ((random >> 11) as f64 / (1_u64 << 52) as f64 - 1.0)
    };
    for (i, j, k) in (0..n * n * n).map(|v| (v / n / n, v / n % n, v % n)) {
        let [x, y, z] = [i, j, k].map(|x| x as f64 + off());
        writeln!(nodes, "{}, {x:?}, {y:?}, {z:?}", at(i, j, k)).unwrap();
        for (p, q, r) in [(i + 1, j, k), (i, j + 1, k), (i, j, k + 1)] {
            if p.max(q).max(r) < n {
                count += 1;
                writeln!(links, "{count}, {}, {}", at(i, j, k), at(p, q, r)).unwrap();
            }
        }
    }
    let text = format!(
        "*NODE\n{nodes}*ELEMENT, TYPE=CONN3D2, ELSET=L\n{links}*CONNECTOR SECTION, ELSET=L\nLINK\n*BOUNDARY\n1, 1, 3\n"
    );
    (text, [3 * (n * n * n - 1) - count, 0])
}

/// Grids and scissors of so many connectors take more than 1e9 operations.
const DEAR: usize = 50_000;

/// What is known of a model: its mobility and the number of its redundant constraints; none where it is too dear, and undecided.
type Known = Option<[usize; 2]>;

fn measure(name: &str, text: &str, known: Known) {
    let scene = &Scene::parse("bench.inp", text).unwrap();
    let model = Model::compile(scene).unwrap();
    PEAK.reset_peak_usage();
    let before = PEAK.current_usage_as_mb();
    let start = Instant::now();
    let assembly: Assembly = analyse(scene, &model, &[], 1).unwrap();
    let time = start.elapsed().as_secs_f64();
    let memory = f64::from(PEAK.peak_usage_as_mb() - before);
    let position = &assembly.positions[0];
    print!(
        "{name:8} {:7} connectors {:8} constraints {time:8.2} s {memory:8.1} MB  ",
        model.connectors.len(),
        assembly.constraints
    );
    let Some(known) = known else {
        println!("undecided: beyond {:.0e} operations", OPERATIONS as f64);
        assert_eq!((assembly.skipped.len(), position.rank, position.decided), (1, None, false), "{name}");
        return;
    };
    let [mobility, redundant] = [position.mobility, position.redundant].map(Option::unwrap);
    println!(
        "mobility {mobility:6} redundant {redundant:6} (throughout {:6}) front {:5} gap {:.1e} {:.1e} decided {}",
        assembly.redundant.iter().filter(|one| one.holds == Holds::Throughout).count(),
        assembly.largest_front,
        position.gap.zero,
        position.gap.nonzero,
        position.decided
    );
    assert_eq!(assembly.gruebler, mobility as i64 - redundant as i64);
    assert_eq!([mobility, redundant], known, "{name}");
    assert!(position.decided, "{name}: {:?}", position.gap);
}

type Made = (String, [usize; 2]);

/// The models of so many connectors, with their mobility and the number of their redundant constraints.
fn models(count: usize) -> [(&'static str, Made); 4] {
    [
        ("chain", chain(count, false)),
        ("loop", chain(count, true)),
        ("tree", tree(count)),
        ("grid", grid(count)),
    ]
}

fn main() {
    if commit::is_told() {
        return;
    }
    let count = std::env::args().filter_map(|word| word.parse().ok()).next().unwrap_or(100_000);
    let lattices = || [("lattice", 0.0), ("moved", 0.1)];
    if let Some(folder) = std::env::args().skip_while(|word| word != "decks").nth(1) {
        let of_lattices = lattices().map(|(name, moved)| (name, lattice(33, moved)));
        let others = [("beams", beams(32)), ("scissors", scissors(111))];
        for (name, (text, _)) in models(count).into_iter().chain(of_lattices).chain(others) {
            std::fs::write(format!("{folder}/{name}.inp"), text).unwrap();
        }
        return;
    }
    for n in [count / 4, count] {
        for (name, (text, known)) in models(n) {
            measure(name, &text, (name != "grid" || n < DEAR).then_some(known));
        }
    }
    for n in [20, 32] {
        let (text, known) = beams(n);
        measure("beams", &text, Some(known));
    }
    for n in [55, 111] {
        let (text, known) = scissors(n);
        measure("scissors", &text, (8 * n * n < DEAR).then_some(known));
    }
    for (name, moved) in lattices() {
        for n in [20, 33] {
            let (text, known) = lattice(n, moved);
            // Those whose nodes are moved off the lattice fill.
            measure(name, &text, (moved == 0.0).then_some(known));
        }
    }
}
