//! Random linkages whose mobility follows from how they are built, against singular values of their Jacobian, at every state.

use super::{Deck, Point, Z};
use nalgebra::DMatrix;
use pintle_assembly::{Assembly, analyse};
use pintle_kinematics::so3;
use pintle_model::evaluate::{Fixed, Jacobian, Model, Plan, Sequence};
use pintle_scene::{NodeMotion, Rotation, Scene, State};
use std::collections::BTreeMap;

/// Random numbers (splitmix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// A point whose coordinates are eighths: exact near the origin and far from it.
    fn eighths(&mut self) -> Point {
        std::array::from_fn(|_| self.below(64) as f64 / 8.0 - 4.0)
    }
}

/// What is expected of the constraints.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Known {
    mobility: usize,
    redundant: usize,
}

fn compile(text: &str) -> (Scene, Model) {
    let scene = Scene::parse("linkage.inp", text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let model = Model::compile(&scene).unwrap_or_else(|error| panic!("{error}\n{text}"));
    (scene, model)
}

/// Rank and number of rows at the initial state and at those given, from singular values of the whole Jacobian, rotations taken times a
/// length.
fn dense(scene: &Scene, model: &Model, states: &[State], length: f64) -> Vec<(usize, usize, usize)> {
    let held = Fixed::held_in_step(scene, 1).unwrap();
    let plan = Plan::everything(model, pintle_kinematics::connector::Request::nothing(0));
    let jacobian = Jacobian::new(model, &plan, &held, |element, k| element.connector.is_constrained(k));
    let initial = State::default();
    let mut sequence = Sequence::new(model, &plan);
    let mut found = Vec::new();
    for (at, state) in std::iter::once(&initial).chain(states).enumerate() {
        if at == 1 {
            sequence = Sequence::new(model, &plan);
        }
        let mut values = Vec::new();
        sequence.assemble(state, &jacobian, &mut values).unwrap();
        let mut full = DMatrix::<f64>::zeros(jacobian.rows(), jacobian.columns());
        for row in 0..jacobian.rows() {
            let range = jacobian.range(row).unwrap();
            for (column, value) in jacobian.row(row).iter().zip(&values[range]) {
                let is_angle = (4..=6).contains(&jacobian.freedoms()[*column as usize].number);
                full[(row, *column as usize)] = if is_angle { value / length } else { *value };
            }
            let largest = full.row(row).amax();
            full.row_mut(row).scale_mut(if largest > 0.0 { 1.0 / largest } else { 1.0 });
        }
        let values = full.singular_values();
        let rank = values.iter().filter(|value| **value > 1e-7 * values.max()).count();
        found.push((rank, jacobian.rows(), jacobian.columns()));
    }
    found
}

/// The analysis says what is known, and what singular values say, at every state, and it is certain of it.
#[track_caller]
fn agrees(text: &str, states: &[State], known: Known, length: f64) -> Assembly {
    let (scene, model) = compile(text);
    let assembly = analyse(&scene, &model, states, 1).unwrap();
    assert!(assembly.off.is_empty(), "{:?}", assembly.off);
    let dense = dense(&scene, &model, states, length);
    assert_eq!(assembly.positions.len(), dense.len());
    for (position, (rank, rows, columns)) in assembly.positions.iter().zip(dense) {
        assert_eq!(
            (rows - rank, columns - rank),
            (known.redundant, known.mobility),
            "singular values\n{text}"
        );
        assert_eq!(
            (position.rank, position.redundant, position.mobility),
            (Some(rank), Some(known.redundant), Some(known.mobility)),
            "{position:?}\n{text}"
        );
        assert!(position.decided, "{position:?}\n{text}");
    }
    assert_eq!(assembly.redundant.len(), known.redundant);
    assert_eq!(assembly.modes.len(), known.mobility);
    assembly
}

fn scaled(deck: &Deck, unit: f64, origin: f64) -> String {
    let mut moved = deck.clone();
    for node in &mut moved.nodes {
        *node = node.map(|x| x * unit + origin);
    }
    moved.text()
}

/// Random trees of rigid bodies on the ground: every joint adds its freedom, every rod between two points of one body is redundant.
#[test]
fn trees_with_redundant_rods() {
    let mut dice = Dice(6);
    for _ in 0..8 {
        let mut deck = Deck::default();
        let root = deck.ground(dice.eighths());
        let mut bodies = vec![vec![root]];
        let mut known = Known { mobility: 0, redundant: 0 };
        for _ in 0..2 + dice.below(3) {
            let from = dice.below(bodies.len());
            let joint = bodies[from][dice.below(bodies[from].len())];
            let own = deck.node(deck.nodes[joint - 1]);
            let axis = [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.8, -0.6, 0.0], [0.0, 0.0, 1.0]][dice.below(4)];
            let (kind, freedom) = [
                ("HINGE", 1),
                ("JOIN", 3),
                ("CYLINDRICAL", 2),
                ("WELD", 0),
                ("TRANSLATOR", 1),
                ("PLANAR", 3),
            ][dice.below(6)];
            deck.joint(kind, joint, own, axis);
            known.mobility += freedom;
            let mut body = vec![own];
            for _ in 0..1 + dice.below(3) {
                let next = deck.node(dice.eighths());
                deck.link(body[dice.below(body.len())], next);
                body.push(next);
            }
            bodies.push(body);
        }
        for body in bodies.iter().filter(|body| body.len() > 1) {
            for _ in 0..dice.below(2) {
                let [first, last] = [body[0], body[body.len() - 1]];
                if deck.nodes[first - 1] != deck.nodes[last - 1] {
                    deck.link(first, last);
                    known.redundant += 6;
                }
            }
        }
        // Metres, millimetres, kilometres, and far from the origin.
        for (unit, origin) in [(1.0, 0.0), (1024.0, 0.0), (1.0 / 1024.0, 0.0), (1.0, 1e9)] {
            agrees(&scaled(&deck, unit, origin), &[], known, 4.0 * unit);
        }
    }
}

/// The rotation matrix of a rotation about an axis that has no direction in common with the global ones.
fn frame(dice: &mut Dice) -> [[f64; 3]; 3] {
    so3::matrix(so3::exp_quaternion(std::array::from_fn(|_| dice.between(-2.0, 2.0))))
}

fn apply(matrix: &[[f64; 3]; 3], x: Point) -> Point {
    std::array::from_fn(|i| (0..3).map(|j| matrix[i][j] * x[j]).sum())
}

/// A rotation by an angle about the third axis of a frame.
fn about(matrix: &[[f64; 3]; 3], angle: f64) -> Rotation {
    Rotation::Vector(apply(matrix, [0.0, 0.0, angle]))
}

/// Random planar four-bars, anywhere in space, moved by their cranks: 1 motion, 3 redundancies, at every state.
#[test]
fn four_bars_along_their_motion() {
    let mut dice = Dice(4);
    for _ in 0..10 {
        let turned = frame(&mut dice);
        // By Grashof the crank turns all the way round, and there is no change point.
        let [ground, crank, coupler] =
            [dice.between(3.0, 4.0), dice.between(0.7, 1.2), dice.between(3.0, 4.0)];
        let rocker = dice.between(ground + crank - coupler, coupler + ground - crank).clamp(2.5, 4.5);
        let place = |angle: f64| -> [Point; 4] {
            let (s, c) = angle.sin_cos();
            let (low, pin, foot) = ([0.0, 0.0, 0.0], [crank * c, crank * s, 0.0], [ground, 0.0, 0.0]);
            let [x, y] = [foot[0] - pin[0], foot[1] - pin[1]];
            let far = x.hypot(y);
            let along = (coupler * coupler - rocker * rocker + far * far) / (2.0 * far);
            let up = (coupler * coupler - along * along).sqrt();
            [low, pin, [pin[0] + (along * x - up * y) / far, pin[1] + (along * y + up * x) / far, 0.0], foot]
        };
        let start = place(0.4);
        let mut deck = Deck::default();
        let hinges = start.map(|p| (apply(&turned, p), apply(&turned, Z)));
        let ends = deck.closed(&hinges);
        let direction = |p: Point, q: Point| (q[1] - p[1]).atan2(q[0] - p[0]);
        let states: Vec<State> = (1..7)
            .map(|k| {
                let now = place(0.4 + f64::from(k));
                let mut nodes = BTreeMap::new();
                // Each link from its first hinge to its second, the crank turning on and on.
                for i in 0..3 {
                    let by = direction(now[i], now[i + 1]) - direction(start[i], start[i + 1]);
                    let angle = if i == 0 { f64::from(k) } else { by };
                    for (node, j) in [(ends[i][1], i), (ends[i + 1][0], i + 1)] {
                        let shift: Point = std::array::from_fn(|k| now[j][k] - start[j][k]);
                        let label = node.to_string().parse().unwrap();
                        let motion = NodeMotion {
                            displacement: apply(&turned, shift),
                            rotation: about(&turned, angle),
                            ..NodeMotion::default()
                        };
                        nodes.insert(label, motion);
                    }
                }
                State { nodes, ..State::default() }
            })
            .collect();
        agrees(&deck.text(), &states, Known { mobility: 1, redundant: 3 }, 3.0);
    }
}

/// Chains of hinges about axes all over the place, folded at random: as many motions as hinges.
#[test]
fn chains_folded_at_random() {
    let mut dice = Dice(9);
    for count in [1, 3, 6] {
        let mut deck = Deck::default();
        let mut end = deck.ground([0.0; 3]);
        let mut links = Vec::new();
        for _ in 0..count {
            let at = deck.nodes[end - 1];
            let axis = apply(&frame(&mut dice), Z);
            let low = deck.node(at);
            deck.joint("HINGE", end, low, axis);
            let by: Point = std::array::from_fn(|_| dice.between(-1.0, 1.0));
            let high = deck.node(std::array::from_fn(|k| at[k] + by[k]));
            deck.link(low, high);
            links.push((low, high, axis, by));
            end = high;
        }
        let states: Vec<State> = (0..5)
            .map(|_| {
                let mut nodes = BTreeMap::new();
                let (mut turned, mut shift) = (so3::exp_quaternion([0.0; 3]), [0.0; 3]);
                for (low, high, axis, by) in &links {
                    let angle = dice.between(-3.0, 3.0);
                    turned = so3::compose(turned, so3::exp_quaternion(axis.map(|x| x * angle)));
                    let rotation = Rotation::Quaternion(turned);
                    let of = |displacement| NodeMotion { displacement, rotation, ..NodeMotion::default() };
                    nodes.insert(low.to_string().parse().unwrap(), of(shift));
                    let moved = apply(&so3::matrix(turned), *by);
                    shift = std::array::from_fn(|k| shift[k] + moved[k] - by[k]);
                    nodes.insert(high.to_string().parse().unwrap(), of(shift));
                }
                State { nodes, ..State::default() }
            })
            .collect();
        agrees(&deck.text(), &states, Known { mobility: count, redundant: 0 }, 1.0);
    }
}

/// A drum that turns by 20 rad and takes up belt: its constraint counts turns, so that the states must be followed one after the other.
#[test]
fn turns_along_the_states_are_counted() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n10, 0., 0., 0.\n*ORIENTATION, NAME=DRUM\n1., 0., 0., 0., 1., 0.\n\
                *ORIENTATION, NAME=HZ\n0., 0., 1., 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=SPOOL\n101, 2, 1\n\
                *ELEMENT, TYPE=CONN3D2, ELSET=RETR\n102, 1, 10\n*CONNECTOR SECTION, ELSET=SPOOL\nHINGE\nHZ,\n\
                *CONNECTOR SECTION, ELSET=RETR\nRETRACTOR\nDRUM,\n50.\n*BOUNDARY\n2, 1, 6\n";
    let (scene, model) = compile(text);
    let state = |turned: f64, flow: f64| {
        let drum = NodeMotion {
            rotation: Rotation::Quaternion(so3::exp_quaternion([0.0, 0.0, turned])),
            ..NodeMotion::default()
        };
        let belt = NodeMotion { flow, ..NodeMotion::default() };
        let nodes = [("1", drum), ("10", belt)].map(|(node, motion)| (node.parse().unwrap(), motion));
        State { nodes: nodes.into(), ..State::default() }
    };
    let states: Vec<State> =
        (0..=8).map(|k| 2.5 * f64::from(k)).map(|turned| state(turned, turned / 50.0)).collect();
    let assembly = analyse(&scene, &model, &states, 1).unwrap();
    assert_eq!((assembly.positions.len(), assembly.off.as_slice()), (states.len() + 1, [].as_slice()));
    // The same belt, with one turn of the drum less, does not satisfy the constraint.
    let states: Vec<State> =
        [0.0, 2.5, 5.0].map(|turned| state(turned, (turned - std::f64::consts::TAU) / 50.0)).to_vec();
    assert_eq!(analyse(&scene, &model, &states, 1).unwrap().off, [0, 1, 2]);
}

/// Two cranks of one length and a coupler, all three in line at the one state that is given: a change point, and the initial state is none.
#[test]
fn a_change_point_is_told_from_the_initial_state() {
    let text = "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 0., 0.5\n4, 1., 0.5\n*ELEMENT, TYPE=CONN2D2, ELSET=BAR\n101, 1, 3\n102, 3, 4\n103, 2, 4\n\
                *CONNECTOR SECTION, ELSET=BAR\nLINK\n*BOUNDARY\n1, 1, 2\n2, 1, 2\n";
    let (scene, model) = compile(text);
    let moved = NodeMotion { displacement: [0.5, -0.5, 0.0], ..NodeMotion::default() };
    let nodes = ["3", "4"].map(|node| (node.parse().unwrap(), moved));
    let state = State { nodes: nodes.into(), number: Some(3), ..State::default() };
    let assembly = analyse(&scene, &model, &[state], 1).unwrap();
    let ranks: Vec<usize> = assembly.positions.iter().filter_map(|position| position.rank).collect();
    assert_eq!(ranks, [3, 2]);
    assert_eq!(assembly.redundant_at.len(), 1, "{:?}", assembly.redundant_at);
    assert_eq!(assembly.redundant_at[0].0, 3);
    // At a distance that states of ten digits do not tell from it, it is undecided.
    for (distance, is_decided) in [(1e-8_f64, false), (1e-4, true)] {
        let angle = std::f64::consts::FRAC_PI_2 - distance;
        let moved = NodeMotion {
            displacement: [0.5 * angle.sin(), 0.5 * angle.cos() - 0.5, 0.0],
            ..NodeMotion::default()
        };
        let nodes = ["3", "4"].map(|node| (node.parse().unwrap(), moved));
        let state = State { nodes: nodes.into(), ..State::default() };
        let assembly = analyse(&scene, &model, &[state], 1).unwrap();
        let decided: Vec<bool> = assembly.positions.iter().map(|position| position.decided).collect();
        assert_eq!(decided, [true, is_decided], "{:?}", assembly.positions);
        assert_eq!(assembly.positions[1].rank, Some(3));
    }
}
