//! What an assembly can do, for mechanisms whose mobility and redundancies are known.
//!
//! Each mechanism is built of hinges (5 constraints) and rigid links (connection type BEAM, 6 constraints) between nodes of 6 degrees of
//! freedom, so that Grübler's mobility is 6 bodies − 5 hinges, whatever the geometry.

mod linkages;
mod singular;

use pintle_assembly::{Assembly, Holds, analyse, analyse_steps};
use pintle_audit::model::{Levels, audit_model};
use pintle_model::evaluate::Model;
use pintle_scene::{Code, NodeMotion, Rotation, Scene, State};
use std::collections::BTreeMap;
use std::fmt::Write;

type Point = [f64; 3];

/// A deck that is being written.
#[derive(Clone, Default)]
struct Deck {
    nodes: Vec<Point>,
    elements: String,
    sections: String,
    count: usize,
    fixed: Vec<usize>,
    more: String,
}

impl Deck {
    fn node(&mut self, at: Point) -> usize {
        self.nodes.push(at);
        self.nodes.len()
    }

    fn ground(&mut self, at: Point) -> usize {
        let node = self.node(at);
        self.fixed.push(node);
        node
    }

    /// A connector of this type whose first direction is `axis`; its number is 100 + its place.
    fn joint(&mut self, kind: &str, a: usize, b: usize, axis: Point) -> usize {
        self.count += 1;
        let number = 100 + self.count;
        // Any direction across.
        let least = (0..3).min_by(|i, j| axis[*i].abs().total_cmp(&axis[*j].abs())).unwrap();
        let mut across = [0.0; 3];
        across[least] = 1.0;
        let [x, y, z] = axis;
        let [p, q, r] = across;
        writeln!(self.elements, "*ELEMENT, TYPE=CONN3D2, ELSET=E{number}\n{number}, {a}, {b}").unwrap();
        writeln!(self.sections, "*ORIENTATION, NAME=O{number}\n{x:?}, {y:?}, {z:?}, {p:?}, {q:?}, {r:?}")
            .unwrap();
        writeln!(self.sections, "*CONNECTOR SECTION, ELSET=E{number}\n{kind}\nO{number},").unwrap();
        number
    }

    /// A connector of a type that needs no directions.
    fn plain(&mut self, kind: &str, a: usize, b: usize) {
        self.count += 1;
        let number = 100 + self.count;
        writeln!(self.elements, "*ELEMENT, TYPE=CONN3D2, ELSET=E{number}\n{number}, {a}, {b}").unwrap();
        writeln!(self.sections, "*CONNECTOR SECTION, ELSET=E{number}\n{kind}").unwrap();
    }

    /// A rigid link.
    fn link(&mut self, a: usize, b: usize) {
        self.plain("BEAM", a, b);
    }

    /// A hinge between two new nodes at one place.
    fn hinge(&mut self, at: Point, axis: Point) -> [usize; 2] {
        let ends = [self.node(at), self.node(at)];
        self.joint("HINGE", ends[0], ends[1], axis);
        ends
    }

    /// A closed loop of hinges, the link between the last and the first being the ground.
    fn closed(&mut self, hinges: &[(Point, Point)]) -> Vec<[usize; 2]> {
        let ends: Vec<[usize; 2]> = hinges.iter().map(|(at, axis)| self.hinge(*at, *axis)).collect();
        for pair in ends.windows(2) {
            self.link(pair[0][1], pair[1][0]);
        }
        self.fixed.push(ends[0][0]);
        self.fixed.push(ends[ends.len() - 1][1]);
        ends
    }

    fn text(&self) -> String {
        let mut text = String::from("*NODE\n");
        for (i, [x, y, z]) in self.nodes.iter().enumerate() {
            writeln!(text, "{}, {x:?}, {y:?}, {z:?}", i + 1).unwrap();
        }
        text += &self.elements;
        text += &self.sections;
        if !self.fixed.is_empty() {
            text += "*BOUNDARY\n";
            for node in &self.fixed {
                writeln!(text, "{node}, 1, 6").unwrap();
            }
        }
        text + &self.more
    }

    fn analyse(&self) -> Assembly {
        let text = self.text();
        let scene = Scene::parse("mechanism.inp", &text).unwrap_or_else(|error| panic!("{error}\n{text}"));
        let model = Model::compile(&scene).unwrap_or_else(|error| panic!("{error}\n{text}"));
        analyse(&scene, &model, &scene.states, 1).unwrap()
    }
}

/// Grübler's mobility, the true one, the number of redundant constraints, and where they hold.
#[track_caller]
fn is(assembly: &Assembly, gruebler: i64, mobility: usize, redundant: usize, holds: &[(Holds, usize)]) {
    let position = &assembly.positions[0];
    let counted = |wanted: Holds| assembly.redundant.iter().filter(|one| one.holds == wanted).count();
    let seen: Vec<(Holds, usize)> = [
        Holds::Throughout,
        Holds::Singular,
        Holds::Rigid,
        Holds::Here,
        Holds::Isolated,
        Holds::Large,
        Holds::Unjudged,
    ]
    .into_iter()
    .map(|holds| (holds, counted(holds)))
    .filter(|(_, count)| *count > 0)
    .collect();
    assert_eq!(
        (assembly.gruebler, position.mobility, position.redundant, seen.as_slice()),
        (gruebler, Some(mobility), Some(redundant), holds),
        "{:#?}",
        assembly.redundant
    );
    assert!(position.decided, "{position:#?}");
    assert_eq!(assembly.redundant.len(), redundant);
    if let Some([nonzero, zero]) = position.gap.singular_values {
        assert!(nonzero > 1e-4 && zero < 1e-13, "{:?}", position.gap);
    }
}

const Z: Point = [0.0, 0.0, 1.0];

/// A link system turned as a whole, so that no direction is along an axis.
fn turned([x, y, z]: Point) -> Point {
    let (c, s) = (0.8, 0.6);
    let [x, y] = [c * x - s * y, s * x + c * y];
    let [y, z] = [c * y - s * z, s * y + c * z];
    [x, y, z]
}

fn four_bar(at: impl Fn(Point) -> Point) -> Deck {
    let mut deck = Deck::default();
    let hinges: Vec<(Point, Point)> =
        [[0.0, 0.0, 0.0], [0.5, 1.0, 0.0], [2.5, 1.5, 0.0], [3.0, 0.0, 0.0]].map(|p| (at(p), at(Z))).to_vec();
    deck.closed(&hinges);
    deck
}

/// A planar four-bar linkage of spatial hinges: −2 by Grübler, 1 in truth, 3 redundant wherever it stands.
#[test]
fn a_planar_four_bar() {
    for assembly in [four_bar(|p| p).analyse(), four_bar(turned).analyse()] {
        is(&assembly, -2, 1, 3, &[(Holds::Throughout, 3)]);
        // Out of plane only, and named by connector and component.
        for one in &assembly.redundant {
            assert!(one.constraint.element.is_some(), "{one:?}");
            assert!(["u1", "u2", "u3", "ur1", "ur2", "ur3"].contains(&one.constraint.component.as_str()));
            assert!(one.from.len() >= 2, "{one:?}");
        }
        assert_eq!(assembly.modes.len(), 1);
        // The crank, the coupler and the rocker move: nodes 2 to 7.
        assert_eq!(assembly.modes[0].moving, Some(6));
    }
}

/// The crank driven: nothing is left; driven twice: one too many.
#[test]
fn drives_come_on_top() {
    let mut deck = four_bar(|p| p);
    deck.more = "*STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION\n101, 4, 1.\n*END STEP\n".into();
    let once = deck.analyse();
    is(&once, -2, 1, 3, &[(Holds::Throughout, 3)]);
    assert_eq!(
        (once.drives, once.positions[0].undriven, once.positions[0].overdriven),
        (1, Some(0), Some(0))
    );
    deck.more = "*STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION\n101, 4, 1.\n104, 4, 1.\n*END STEP\n".into();
    let twice = deck.analyse();
    assert_eq!(
        (twice.drives, twice.positions[0].undriven, twice.positions[0].overdriven),
        (2, Some(0), Some(1))
    );
    assert_eq!(twice.overdriven.len(), 1);
    // Held instead of driven it is a constraint, and nothing moves.
    deck.more = "*CONNECTOR MOTION\n101, 4\n".into();
    is(&deck.analyse(), -3, 0, 3, &[(Holds::Rigid, 3)]);
}

/// A matrix of Denavit and Hartenberg: turned by θ about z, moved by a along x, turned by α about x.
fn link([theta, length, alpha]: Point) -> [[f64; 4]; 4] {
    let [(s, c), (sa, ca)] = [theta, alpha].map(f64::sin_cos);
    [
        [c, -s * ca, s * sa, length * c],
        [s, c * ca, -c * sa, length * s],
        [0.0, sa, ca, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]
}

fn times(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Bennett's linkage: four hinges, neither parallel nor through one point, that move.
fn bennett() -> Vec<(Point, Point)> {
    let (a, alpha, beta) = (1.0, 0.6_f64, 1.1_f64);
    let b = a * beta.sin() / alpha.sin();
    let theta = 0.9_f64;
    let ratio = ((beta + alpha) / 2.0).sin() / ((beta - alpha) / 2.0).sin();
    let phi = 2.0 * (ratio / (theta / 2.0).tan()).atan();
    let tau = std::f64::consts::TAU;
    let links = [[theta, a, alpha], [phi, b, beta], [tau - theta, a, alpha], [tau - phi, b, beta]];
    let mut frame: [[f64; 4]; 4] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let mut hinges = Vec::new();
    for parameters in links {
        let column = |j: usize| [frame[0][j], frame[1][j], frame[2][j]];
        hinges.push((column(3), column(2)));
        frame = times(&frame, &link(parameters));
    }
    for i in 0..4 {
        for j in 0..4 {
            assert!((frame[i][j] - f64::from(u8::from(i == j))).abs() < 1e-14, "the loop is not closed");
        }
    }
    hinges
}

/// −2 by Grübler, 1 in truth.
#[test]
fn a_bennett_linkage() {
    let mut hinges = bennett();
    let mut deck = Deck::default();
    deck.closed(&hinges);
    is(&deck.analyse(), -2, 1, 3, &[(Holds::Throughout, 3)]);
    // With another length it is a structure: four hinges in general position.
    hinges[1].0[0] += 0.1;
    let mut deck = Deck::default();
    deck.closed(&hinges);
    is(&deck.analyse(), -2, 0, 2, &[(Holds::Rigid, 2)]);
}

/// Sarrus' linkage: two legs of three parallel hinges each guide a platform along a line: 0 by Grübler, 1 in truth.
#[test]
fn a_sarrus_linkage() {
    let [x, y] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut deck = Deck::default();
    deck.closed(&[
        ([1.0, 0.0, 0.0], y),
        ([1.7, 0.0, 0.5], y),
        ([1.0, 0.0, 1.0], y),
        ([0.0, 1.0, 1.0], x),
        ([0.0, 1.7, 0.5], x),
        ([0.0, 1.0, 0.0], x),
    ]);
    is(&deck.analyse(), 0, 1, 1, &[(Holds::Throughout, 1)]);
}

/// A parallelogram with a third crank: −6 by Grübler, and it moves. With a third crank of half the length, parallel to the others, it
/// moves to first order only; with one that points elsewhere not at all.
#[test]
fn a_parallelogram_with_an_extra_bar() {
    let build = |third: Point| {
        let mut deck = Deck::default();
        let (crank, mut tips) = ([0.6, 0.8, 0.0], Vec::new());
        for (x, crank) in [(0.0, crank), (1.0, third), (2.5, crank)] {
            let low = deck.hinge([x, 0.0, 0.0], Z);
            let high = deck.hinge([x + crank[0], crank[1], 0.0], Z);
            deck.fixed.push(low[0]);
            deck.link(low[1], high[0]);
            tips.push(high[1]);
        }
        deck.link(tips[0], tips[1]);
        deck.link(tips[0], tips[2]);
        deck
    };
    is(&build([0.6, 0.8, 0.0]).analyse(), -6, 1, 7, &[(Holds::Throughout, 7)]);
    is(&build([0.3, 0.4, 0.0]).analyse(), -6, 1, 7, &[(Holds::Rigid, 6), (Holds::Isolated, 1)]);
    is(&build([-0.6, 0.8, 0.0]).analyse(), -6, 0, 6, &[(Holds::Rigid, 6)]);
}

#[test]
fn a_pendulum() {
    let mut deck = Deck::default();
    let pin = deck.hinge([0.0; 3], Z);
    deck.fixed.push(pin[0]);
    let mass = deck.node([1.0, 0.0, 0.0]);
    deck.link(pin[1], mass);
    let assembly = deck.analyse();
    is(&assembly, 1, 1, 0, &[]);
    assert_eq!((assembly.degrees_of_freedom, assembly.held, assembly.constraints), (18, 6, 11));
    assert_eq!(assembly.modes[0].nodes.len(), 2);
    // Without ground it moves as a rigid body besides.
    deck.fixed.clear();
    is(&deck.analyse(), 7, 7, 0, &[]);
}

fn slider_crank(pin: Point, slider: f64) -> Deck {
    let mut deck = Deck::default();
    let [low, mid] = [deck.hinge([0.0; 3], Z), deck.hinge(pin, Z)];
    let high = deck.hinge([slider, 0.0, 0.0], Z);
    deck.link(low[1], mid[0]);
    deck.link(mid[1], high[0]);
    let rail = deck.ground([0.0; 3]);
    deck.joint("TRANSLATOR", rail, high[1], [1.0, 0.0, 0.0]);
    deck.fixed.push(low[0]);
    deck
}

#[test]
fn a_slider_crank() {
    is(&slider_crank([0.6, 0.8, 0.0], 2.4).analyse(), -2, 1, 3, &[(Holds::Throughout, 3)]);
}

/// Crank and rod of one length, upright, the slider at the centre: it can go on as a slider-crank, or turn about the centre. One of the four
/// redundancies holds here only.
#[test]
fn a_slider_crank_where_it_branches() {
    is(&slider_crank([0.0, 1.0, 0.0], 0.0).analyse(), -2, 2, 4, &[(Holds::Throughout, 3), (Holds::Here, 1)]);
    // Turned on by itself about the centre, the slider at rest, it is at no singular position.
    is(&slider_crank([0.6, 0.8, 0.0], 0.0).analyse(), -2, 1, 3, &[(Holds::Throughout, 3)]);
}

/// At the dead centre the slider cannot be driven: its motion is determined, to first order, and the crank is not.
#[test]
fn a_dead_centre() {
    let mut deck = slider_crank([0.8, 0.0, 0.0], 2.4);
    deck.more = "*STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION\n106, 1, 1.\n*END STEP\n".into();
    let assembly = deck.analyse();
    is(&assembly, -2, 1, 3, &[(Holds::Throughout, 3)]);
    assert_eq!((assembly.positions[0].undriven, assembly.positions[0].overdriven), (Some(1), Some(1)));
    deck = slider_crank([0.6, 0.8, 0.0], 2.4);
    deck.more = "*STEP\n*STATIC\n0.1, 1.\n*CONNECTOR MOTION\n106, 1, 1.\n*END STEP\n".into();
    let assembly = deck.analyse();
    assert_eq!((assembly.positions[0].undriven, assembly.positions[0].overdriven), (Some(0), Some(0)));
}

/// Two rods in line between fixed pins: they can move sideways to first order, and nowhere.
#[test]
fn rods_in_line() {
    let mut deck = Deck::default();
    deck.closed(&[([0.0; 3], Z), ([1.0, 0.0, 0.0], Z), ([2.0, 0.0, 0.0], Z)]);
    let assembly = deck.analyse();
    is(&assembly, -3, 1, 4, &[(Holds::Rigid, 3), (Holds::Isolated, 1)]);
    // What holds out of the plane has nothing to do with the position.
    let isolated = |one: &&pintle_assembly::Redundant| one.holds == Holds::Isolated;
    let named: Vec<_> =
        assembly.redundant.iter().filter(isolated).map(|one| &one.constraint.component).collect();
    assert!(["u1", "u2", "u3"].contains(&named[0].as_str()), "{named:?}");
}

/// Rods in line between fixed pins, more than sixty motions: the redundant one belongs to the position, however many they are.
#[test]
fn a_string_of_links_in_line() {
    let count = 45;
    let mut deck = Deck::default();
    let nodes: Vec<usize> = (0..=count).map(|k| deck.node([k as f64, 0.0, 0.0])).collect();
    nodes.windows(2).for_each(|pair| deck.plain("LINK", pair[0], pair[1]));
    deck.more = format!("*BOUNDARY\n{}, 1, 3\n{}, 1, 3\n", nodes[0], nodes[count]);
    is(&deck.analyse(), 2 * count as i64 - 3, 2 * count - 2, 1, &[(Holds::Isolated, 1)]);
}

/// A tower of four-bars, one on the coupler of the other.
#[test]
fn a_tower_of_four_bars() {
    let count = 80;
    let mut deck = Deck::default();
    let mut base: Option<[usize; 2]> = None;
    for level in 0..count {
        let at = |x: f64, y: f64| [x, 1.25 * f64::from(level) + y, 0.0];
        let pins = [at(0.0, 0.0), at(0.125, 1.25), at(2.125, 1.25), at(2.0, 0.0)];
        let ends = pins.map(|at| deck.hinge(at, Z));
        for k in 0..3 {
            deck.link(ends[k][1], ends[k + 1][0]);
        }
        match base {
            None => deck.fixed.extend([ends[0][0], ends[3][1]]),
            Some([left, right]) => {
                deck.link(left, ends[0][0]);
                deck.link(right, ends[3][1]);
            }
        }
        base = Some([ends[1][1], ends[2][0]]);
    }
    let count = count as usize;
    let mobility = count;
    let assembly = deck.analyse();
    assert_eq!(assembly.positions[0].mobility, Some(mobility));
    // A four-bar in the plane repeats three constraints.
    assert_eq!(assembly.positions[0].redundant, Some(3 * count));
    assert_eq!(assembly.redundant.len(), 3 * count);
    assert!(
        assembly.redundant.iter().all(|one| one.holds == Holds::Throughout),
        "{:?}",
        assembly.redundant[0].holds
    );
}

/// Three nodes welded in a triangle: one of the three links is too much, and nothing moves.
#[test]
fn a_welded_loop() {
    let mut deck = Deck::default();
    let [a, b] = [deck.ground([0.0; 3]), deck.node([1.0, 0.0, 0.0])];
    let c = deck.node([0.3, 0.7, 0.2]);
    for (a, b) in [(a, b), (b, c), (c, a)] {
        deck.link(a, b);
    }
    is(&deck.analyse(), -6, 0, 6, &[(Holds::Rigid, 6)]);
}

/// Two BEAMs between the same nodes.
#[test]
fn a_pair_of_beams() {
    let mut deck = Deck::default();
    let [a, b] = [deck.ground([0.0; 3]), deck.node([1.0, 0.5, 0.0])];
    deck.link(a, b);
    deck.link(a, b);
    let assembly = deck.analyse();
    is(&assembly, -6, 0, 6, &[(Holds::Rigid, 6)]);
    assert!(assembly.redundant.iter().all(|one| one.constraint.element.unwrap().to_string() == "102"));
    // Between nodes that are both held, everything is redundant.
    deck.fixed.push(b);
    let assembly = deck.analyse();
    is(&assembly, -12, 0, 12, &[(Holds::Rigid, 12)]);
}

/// Two shafts in bearings, bent by 0.3 rad and joined by a UJOINT: −2 by Grübler, and they turn.
#[test]
fn shafts_with_a_universal_joint() {
    let (s, c) = 0.3_f64.sin_cos();
    let mut deck = Deck::default();
    let first = deck.hinge([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
    let second = deck.hinge([c, s, 0.0], [c, s, 0.0]);
    let ends = [deck.node([0.0; 3]), deck.node([0.0; 3])];
    deck.link(first[1], ends[0]);
    deck.link(second[1], ends[1]);
    // The cross: its axes are across the shafts, and across each other.
    deck.joint("UJOINT", ends[0], ends[1], Z);
    deck.fixed.extend([first[0], second[0]]);
    let text = deck.text().replace("O105,", "O105, OB");
    let text = text.replace(
        "*CONNECTOR SECTION, ELSET=E105",
        &format!("*ORIENTATION, NAME=OB\n0., 0., 1., {:?}, {:?}, 0.\n*CONNECTOR SECTION, ELSET=E105", c, s),
    );
    let scene = Scene::parse("shafts.inp", &text).unwrap();
    let model = Model::compile(&scene).unwrap();
    let assembly = analyse(&scene, &model, &[], 1).unwrap();
    is(&assembly, -2, 1, 3, &[(Holds::Throughout, 3)]);
}

/// Digits that a deck does not have decide nothing: a four-bar whose hinges are off by 1e-9 rad.
#[test]
fn what_is_neither_zero_nor_not_is_undecided() {
    let mut deck = Deck::default();
    deck.closed(&[
        ([0.0, 0.0, 0.0], Z),
        ([0.5, 1.0, 0.0], [1e-9, 0.0, 1.0]),
        ([2.5, 1.5, 0.0], [0.0, 2e-9, 1.0]),
        ([3.0, 0.0, 0.0], Z),
    ]);
    let assembly = deck.analyse();
    assert!(!assembly.positions[0].decided, "{:?}", assembly.positions[0]);
    let scene = Scene::parse("off.inp", &deck.text()).unwrap();
    let report = audit_model(&scene, &[], &Levels::default());
    assert!(report.findings.iter().any(|finding| finding.code() == Code::AssemblyUndecided));
}

/// The unit of length does not matter, nor where the origin is.
#[test]
fn units_and_origin_do_not_matter() {
    for (unit, origin) in [(1e3, 0.0), (1e-3, 0.0), (1.0, 1e5), (1.0, 12_345.678), (1e3, 1e9)] {
        let mut deck = four_bar(turned);
        for node in &mut deck.nodes {
            *node = node.map(|x| x * unit + origin);
        }
        let assembly = deck.analyse();
        assert_eq!(
            (assembly.positions[0].mobility, assembly.positions[0].redundant),
            (Some(1), Some(3)),
            "{unit} {origin}"
        );
        // Coordinates far away are rounded, and that is known.
        assert!(assembly.positions[0].decided, "{unit} {origin}: {:?}", assembly.positions[0]);
    }
}

/// A folded four-bar whose pins lie on a line, or off it by so much, in this unit and this far from the origin.
fn folded(offset: f64, unit: f64, origin: f64) -> Deck {
    let mut deck = Deck::default();
    let pins = [[0.0, 0.0], [1.0, offset], [3.0, offset], [2.0, 0.0]];
    deck.closed(&pins.map(|[x, y]| ([origin + unit * x, origin + unit * y, origin], Z)));
    deck
}

/// Far from the origin what is off by a thousand times the rounding of coordinates is not zero for certain, and what is zero still is.
#[test]
fn what_is_off_by_more_than_rounding_is_not_zero() {
    for origin in [0.0, 1e6] {
        let flat = folded(0.0, 1.0, origin).analyse();
        assert_eq!((flat.positions[0].rank, flat.positions[0].decided), (Some(34), true), "{origin}");
        let near = folded(1e-7, 1.0, origin).analyse();
        assert!(!near.positions[0].decided, "{origin}: {:?}", near.positions[0]);
        assert!(!near.positions[0].doubtful.is_empty());
        let open = folded(1e-2, 1.0, origin).analyse();
        assert_eq!((open.positions[0].rank, open.positions[0].decided), (Some(35), true), "{origin}");
    }
}

/// Links of 1e-6 that lie 1e6 away have no digits: nothing that follows from their rank is a fact.
#[test]
fn an_uncertain_rank_states_nothing_as_a_fact() {
    let deck = folded(0.0, 1e-6, 1e6);
    let assembly = deck.analyse();
    let position = &assembly.positions[0];
    assert!(!position.decided);
    assert_eq!(Some(position.undriven_undecided), position.undriven);
    assert!(!assembly.redundant.is_empty() && !assembly.modes.is_empty());
    assert!(assembly.redundant.iter().all(|one| one.holds == Holds::Unjudged && !one.decided));
    assert!(assembly.modes.iter().all(|mode| !mode.decided));
    let scene = Scene::parse("far.inp", &deck.text()).unwrap();
    let report = audit_model(&scene, &[], &Levels::default());
    let of = |code: Code| report.findings.iter().filter(move |finding| finding.code() == code);
    for fact in [Code::AssemblyRedundant, Code::AssemblyRedundantHere, Code::AssemblyMechanism] {
        assert_eq!(of(fact).count(), 0, "{fact}");
    }
    let rank = position.rank.unwrap();
    let condition = format!("if the rank of the constraints is {rank}, which is not certain");
    let mut unjudged = of(Code::AssemblyRedundantUnjudged).peekable();
    assert!(unjudged.peek().is_some());
    assert!(unjudged.all(|finding| finding.message().contains(&condition)));
    let undecided = of(Code::AssemblyUndecided).next().unwrap().message();
    let ways = position.undriven.unwrap();
    assert!(undecided.contains(&format!("if it is {rank}, ")), "{undecided}");
    assert!(undecided.contains(&format!("can move in {ways} ways")), "{undecided}");
}

/// Motions of one node are told apart, by the degree of freedom that stands for each.
#[test]
fn motions_are_told_apart() {
    let mut deck = Deck::default();
    let [a, b] = [deck.ground([0.0; 3]), deck.node([1.0, 0.0, 0.0])];
    deck.joint("AXIAL", a, b, [1.0, 0.0, 0.0]);
    let carried = deck.node([2.0, 0.0, 0.0]);
    deck.joint("WELD", b, deck.nodes.len(), Z);
    let text = deck.text().replace("WELD", "BEAM");
    let scene = Scene::parse("free.inp", &text).unwrap();
    let report = audit_model(&scene, &[], &Levels::default());
    let finding = report.findings.iter().find(|one| one.code() == Code::AssemblyMechanism).unwrap();
    let message = finding.message();
    let words: Vec<&str> = message.split_once("by degree of freedom ").unwrap().1.split("; ").collect();
    assert_eq!(words.len(), 6, "{message}");
    for (i, word) in words.iter().enumerate() {
        assert!(
            word.contains(&format!("node {b}")) && word.contains(&format!("node {carried}")),
            "{message}"
        );
        assert!(!words[..i].contains(word), "{message}");
    }
}

/// A parallelogram of hinged bars (1-2 to 7-8) whose cranks stand at an angle, moved from where they stand upright.
fn parallelogram() -> (Deck, impl Fn(u64, f64) -> State) {
    let mut deck = Deck::default();
    let [low, tip] = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let ends = deck.closed(&[(low, Z), (tip, Z), ([2.0, 1.0, 0.0], Z), ([2.0, 0.0, 0.0], Z)]);
    let state = move |number: u64, angle: f64| {
        let turned = Rotation::Vector([0.0, 0.0, angle]);
        let shift = [-angle.sin(), angle.cos() - 1.0, 0.0];
        let mut nodes = BTreeMap::new();
        let mut put = |node: usize, displacement: Point, rotation: Rotation| {
            let motion = NodeMotion { displacement, rotation, ..NodeMotion::default() };
            nodes.insert(node.to_string().parse().unwrap(), motion);
        };
        let at_rest = Rotation::Vector([0.0; 3]);
        put(ends[0][1], [0.0; 3], turned);
        put(ends[1][0], shift, turned);
        put(ends[1][1], shift, at_rest);
        put(ends[2][0], shift, at_rest);
        put(ends[2][1], shift, turned);
        put(ends[3][0], [0.0; 3], turned);
        State { nodes, number: Some(number), ..State::default() }
    };
    (deck, state)
}

/// What moves, and what is redundant, is named at the states where it is not what it was.
#[test]
fn motions_at_a_flat_state_are_named() {
    let (deck, state) = parallelogram();
    let scene = Scene::parse("parallelogram.inp", &deck.text()).unwrap();
    let model = Model::compile(&scene).unwrap();
    let flat = std::f64::consts::FRAC_PI_2;
    let states: Vec<State> =
        [(0, 0.0), (1, -0.8), (4, -flat), (5, -1.8), (9, flat)].map(|(k, angle)| state(k, angle)).to_vec();
    let assembly = analyse(&scene, &model, &states, 1).unwrap();
    assert!(assembly.off.is_empty(), "{:?}", assembly.off);
    let differing: Vec<u64> =
        assembly.positions.iter().filter(|one| one.differs).filter_map(|one| one.state).collect();
    assert_eq!(differing, [4, 9]);
    for position in assembly.positions.iter().filter(|one| one.differs) {
        assert_eq!((position.rank, position.undriven, position.modes.len()), (Some(34), Some(2), 2));
        assert_ne!(position.modes[0].leading, position.modes[1].leading);
        // One crank can turn without the other.
        assert!(position.modes.iter().all(|mode| mode.decided && mode.moving.is_some_and(|n| n >= 2)));
        let counted = |holds: Holds| position.dependent.iter().filter(|one| one.holds == holds).count();
        assert_eq!((counted(Holds::Here), counted(Holds::Throughout)), (1, 3), "{:#?}", position.dependent);
        assert!(position.dependent.iter().all(|one| !one.from.is_empty()));
    }
    assert!(assembly.positions.iter().filter(|one| !one.differs).all(|one| one.modes.is_empty()));
    let report = audit_model(&scene, &states, &Levels::default());
    let message = |code: Code, with: &str| {
        report.findings.iter().any(|one| one.code() == code && one.message().contains(with))
    };
    assert!(message(
        Code::AssemblyMechanism,
        "at states 4, 9, the assembly can move in 2 ways that nothing drives, not 1 as initially"
    ));
    // Which of the constraints is named is a choice, and may not be the same at both.
    let here = |states: &str| message(Code::AssemblyRedundantHere, &format!("at {states}, "));
    assert!(here("states 4, 9") || (here("state 4") && here("state 9")));
    let mut text = Vec::new();
    let settings = pintle_audit::Settings::default();
    let mut page = pintle_audit::audit_scenes(&settings, &[], &|_| {});
    page.models.push(report.clone());
    pintle_report::audit::human(&mut text, &page, 200, false).unwrap();
    let text = String::from_utf8(text).unwrap();
    for line in ["at states 0, 1, 5: rank 35, mobility 1", "at states 4, 9: rank 34, mobility 2"] {
        assert!(text.contains(line), "{text}");
    }
}

/// OP=NEW without data lines removes all of its kind: the boundary conditions, the connector motions, or both.
#[test]
fn what_a_step_removes_no_longer_holds() {
    const MOTION: &str = "*CONNECTOR MOTION, OP=NEW\n";
    const BOUNDARY: &str = "*BOUNDARY, OP=NEW\n";
    for (removed, expected) in [
        (format!("{MOTION}{BOUNDARY}"), (0, Some(7))),
        (MOTION.to_owned(), (6, Some(1))),
        (BOUNDARY.to_owned(), (0, Some(6))),
    ] {
        let mut deck = Deck::default();
        let pin = deck.hinge([0.0; 3], Z);
        deck.more = format!(
            "*STEP\n*STATIC\n*BOUNDARY\n{}, 1, 6\n*CONNECTOR MOTION\n101, 4\n*END STEP\n*STEP\n*STATIC\n{removed}*END STEP\n",
            pin[0]
        );
        let scene = Scene::parse("removed.inp", &deck.text()).unwrap();
        let model = Model::compile(&scene).unwrap();
        let steps = analyse_steps(&scene, &model, &[]).unwrap();
        let found: Vec<_> =
            steps.iter().map(|one| (one.step, (one.held, one.positions[0].mobility))).collect();
        assert_eq!(found, [(1, (6, Some(0))), (2, expected)], "{removed}");
    }
}

/// What a later step holds is not what the first does: a hinge whose node is held in step 2, against its constraints and about its axis.
#[test]
fn later_steps_have_their_own_conditions() {
    let mut deck = Deck::default();
    let pin = deck.hinge([0.0; 3], Z);
    deck.fixed.push(pin[0]);
    deck.more = format!(
        "*STEP\n*STATIC\n0.1, 1.\n*END STEP\n*STEP\n*STATIC\n0.1, 1.\n*END STEP\n*STEP\n*STATIC\n0.1, 2.\n*BOUNDARY\n{0}, 6, 6\n{0}, 4, 4\n*END STEP\n",
        pin[1]
    );
    let scene = Scene::parse("steps.inp", &deck.text()).unwrap();
    let model = Model::compile(&scene).unwrap();
    let states: Vec<State> = [0.5, 1.0, 1.5, 2.5, 9.0]
        .into_iter()
        .enumerate()
        .map(|(k, time)| State { number: Some(k as u64), time: Some(time), ..State::default() })
        .collect();
    let steps = analyse_steps(&scene, &model, &states).unwrap();
    let looked_at = |assembly: &Assembly| -> Vec<Option<u64>> {
        assembly.positions.iter().map(|one| one.state).collect()
    };
    let found: Vec<_> = steps
        .iter()
        .map(|one| (one.step, one.held, one.positions[0].mobility, one.redundant.len(), looked_at(one)))
        .collect();
    let expected = [
        (1, 6, Some(1), 0, vec![None, Some(0), Some(1), Some(2)]),
        (3, 8, Some(0), 1, vec![None, Some(3), Some(4)]),
    ];
    assert_eq!(found, expected);
    let report = audit_model(&scene, &states, &Levels::default());
    assert_eq!((report.assembly.as_ref(), report.later_steps.as_slice()), (Some(&steps[0]), &steps[1..]));
    let told = |code: Code, begin: &str| {
        report.findings.iter().filter(|one| one.code() == code && one.message().starts_with(begin)).count()
    };
    assert_eq!(told(Code::AssemblyRedundant, "in step 3, element 101: "), 1);
    assert_eq!(
        (
            told(Code::AssemblyMechanism, "the assembly can move in 1 way"),
            told(Code::AssemblyMechanism, "in step")
        ),
        (1, 0)
    );
    // Without their times, states are of the first step.
    let timeless: Vec<State> = states.iter().map(|state| State { time: None, ..state.clone() }).collect();
    let steps = analyse_steps(&scene, &model, &timeless).unwrap();
    assert_eq!([steps[0].positions.len(), steps[1].positions.len()], [6, 1]);
}

/// A part whose elimination would take more than 1e9 operations is undecided, and the finding says why and what to do; what else there is, is found.
#[test]
fn what_would_take_too_long_is_undecided() {
    const NODES: usize = 1_500;
    let mut text = String::from("*NODE\n");
    for i in 1..=NODES {
        // Residues of a prime.
        let [x, y, z] = [i * 617, i * i * 389, i * i * i * 211].map(|number| (number % 1_511) as f64 / 64.0);
        writeln!(text, "{i}, {x:?}, {y:?}, {z:?}").unwrap();
    }
    let mut random = 1_u64;
    let mut joints = std::collections::BTreeSet::new();
    for i in 0..NODES {
        for _ in 0..6 {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let j = (random >> 33) as usize % NODES;
            if i != j {
                joints.insert([i.min(j) + 1, i.max(j) + 1]);
            }
        }
    }
    assert!(joints.len() > 4 * NODES, "{}", joints.len());
    text += "2001, -5., 0., 0.\n2002, -6., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=L\n";
    for (number, [a, b]) in (1..).zip(&joints) {
        writeln!(text, "{number}, {a}, {b}").unwrap();
    }
    text += "*ELEMENT, TYPE=CONN3D2, ELSET=B\n9001, 2001, 2002\n9002, 2001, 2002\n\
             *ORIENTATION, NAME=Z\n0., 0., 1., 1., 0., 0.\n*CONNECTOR SECTION, ELSET=L\nJOIN\nZ,\n*CONNECTOR SECTION, ELSET=B\nBEAM\n*BOUNDARY\n2001, 1, 6\n";
    let scene = Scene::parse("dense.inp", &text).unwrap();
    let report = audit_model(&scene, &[], &Levels::default());
    let assembly = report.assembly.as_ref().unwrap();
    assert_eq!((assembly.connected_components, assembly.skipped.len(), assembly.is_decided()), (2, 1, false));
    assert_eq!((assembly.skipped[0].connectors, assembly.positions[0].rank), (joints.len(), None));
    assert_eq!((assembly.redundant.len(), assembly.redundant[0].holds), (6, Holds::Rigid));
    let found = |code: Code| report.findings.iter().find(|finding| finding.code() == code).unwrap();
    let undecided = found(Code::AssemblyUndecided);
    let message = undecided.message();
    assert!(message.contains("more than 1e9 operations"), "{message}");
    assert!(
        undecided.reason().contains("joined so densely") && undecided.remedy().contains("smaller pieces")
    );
    assert!(found(Code::AssemblyRedundant).message().contains("element 9002"));
}
