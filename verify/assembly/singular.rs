//! Singular positions, whose second order is known: what is proven of them, and what is not.

use super::{Deck, Point, Z, bennett, is};
use pintle_assembly::{Assembly, Holds, Position, analyse};
use pintle_kinematics::so3;
use pintle_model::evaluate::Model;
use pintle_scene::{NodeMotion, Rotation, Scene, State};

/// A motion of space: nothing of what an assembly can do depends on it.
type Move = fn(Point) -> Point;

const STAYS: Move = |x| x;
/// Turned about no axis of the coordinates, and moved.
const MOVED: Move = |x| {
    let [x, y, z] = turned(x);
    [x + 10.0, y - 20.0, z + 30.0]
};

fn turned(x: Point) -> Point {
    let r = so3::matrix(so3::exp_quaternion([0.7, -1.1, 0.4]));
    std::array::from_fn(|i| r[i][0] * x[0] + r[i][1] * x[1] + r[i][2] * x[2])
}

/// LINKs between nodes that have no rotations.
fn links(nodes: &[Point], links: &[[usize; 2]], fixed: &[usize], by: Move) -> Deck {
    let mut deck = Deck::default();
    for at in nodes {
        deck.node(by(*at));
    }
    for [a, b] in links {
        deck.plain("LINK", *a, *b);
    }
    if !fixed.is_empty() {
        deck.more = "*BOUNDARY\n".into();
        fixed.iter().for_each(|node| deck.more += &format!("{node}, 1, 3\n"));
    }
    deck
}

/// Hinges about `axis` where cranks of this length, in line, are pinned to the ground, and to a coupler.
fn cranks(at: &[f64], by: Move, axis: Point) -> Deck {
    let mut deck = Deck::default();
    let mut last = None;
    for x in at {
        let low = deck.hinge(by([*x, 0.0, 0.0]), axis);
        let high = deck.hinge(by([x + 1.5, 0.0, 0.0]), axis);
        deck.fixed.push(low[0]);
        deck.link(low[1], high[0]);
        if let Some(last) = last {
            deck.link(last, high[1]);
        }
        last = Some(high[1]);
    }
    deck
}

/// Three LINKs of lengths 1, 2 and 3 in one line: by the triangle inequality they are so at every admissible state, and one of them is redundant.
#[test]
fn a_triangle_without_height() {
    for by in [STAYS, MOVED] {
        let deck = links(&[[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]], &[[1, 2], [2, 3], [1, 3]], &[], by);
        is(&deck.analyse(), 6, 7, 1, &[(Holds::Singular, 1)]);
    }
}

/// A platform on four equal and parallel LINKs, whose hooks are on no circle, swings with all of them parallel: one is redundant wherever it swings.
#[test]
fn a_swing_on_four_links() {
    let hooks = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.5]];
    for by in [STAYS, MOVED] {
        let mut deck = Deck::default();
        for [x, y] in hooks {
            deck.node(by([x, y, 1.0]));
        }
        for [x, y] in hooks {
            deck.node(by([x, y, 0.0]));
        }
        for leg in 1..5 {
            deck.plain("LINK", leg, leg + 4);
            deck.fixed.push(leg);
        }
        for bar in 5..8 {
            deck.plain("BEAM", bar, bar + 1);
        }
        is(&deck.analyse(), 2, 3, 1, &[(Holds::Singular, 1)]);
    }
}

/// Two LINKs in line between fixed nodes, and one that hangs where they meet, and swings: that node can be nowhere else.
#[test]
fn a_column_with_a_pendulum() {
    for by in [STAYS, MOVED] {
        let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 0.0, -2.0]];
        is(
            &links(&nodes, &[[1, 2], [2, 3], [2, 4]], &[1, 3], by).analyse(),
            3,
            4,
            1,
            &[(Holds::Singular, 1)],
        );
        // Without it.
        is(&links(&nodes[..3], &[[1, 2], [2, 3]], &[1, 3], by).analyse(), 1, 2, 1, &[(Holds::Isolated, 1)]);
    }
}

/// A flat arch of three hinges, and a pendulum on its crown: rigid to second order, but for the pendulum.
#[test]
fn a_flat_arch_with_a_pendulum() {
    for (by, axis) in [(STAYS, Z), (MOVED, turned(Z))] {
        let mut deck = Deck::default();
        let ends = deck.closed(&[[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]].map(|at| (by(at), axis)));
        let own = deck.node(by([1.0, 0.0, 0.0]));
        deck.joint("HINGE", ends[1][0], own, axis);
        let mass = deck.node(by([1.0, -1.0, 0.0]));
        deck.link(own, mass);
        is(&deck.analyse(), -2, 2, 4, &[(Holds::Throughout, 3), (Holds::Singular, 1)]);
    }
}

/// Equal parallel cranks with a coupler, at dead centre: of three the coupler goes on in one way only, which is none of random ones.
#[test]
fn parallel_cranks_at_dead_centre() {
    for (by, axis) in [(STAYS, Z), (MOVED, turned(Z))] {
        let two = cranks(&[0.0, 1.0], by, axis).analyse();
        is(&two, -2, 2, 4, &[(Holds::Throughout, 3), (Holds::Here, 1)]);
        let three = cranks(&[0.0, 1.0, 2.25], by, axis).analyse();
        is(&three, -6, 2, 8, &[(Holds::Throughout, 7), (Holds::Here, 1)]);
    }
}

/// Constraints that follow from the others are named so that the others have the same rank.
#[test]
fn without_what_is_redundant_the_rank_is_the_same() {
    let deck = cranks(&[0.0, 1.0, 2.25], MOVED, turned(Z));
    let redundant = deck.analyse().redundant;
    // Each with what it follows from: rigid links first, and else the last ones of the deck.
    assert!(!redundant.is_empty() && redundant.iter().all(|one| !one.from.is_empty()), "{redundant:#?}");
    let last = |one: &pintle_assembly::Constraint| {
        let number = one.element.unwrap().to_string();
        (!deck.sections.contains(&format!("ELSET=E{number}\nBEAM\n")), number.parse::<usize>().unwrap())
    };
    assert!(redundant.iter().all(|one| one.from.iter().all(|other| last(other) <= last(&one.constraint))));
    assert!(redundant.iter().all(|one| last(&one.constraint).0), "{redundant:#?}");
}

fn at(text: &str, states: &[State]) -> Assembly {
    let scene = Scene::parse("singular.inp", text).unwrap();
    let model = Model::compile(&scene).unwrap();
    analyse(&scene, &model, states, 1).unwrap()
}

fn state(moved: &[(&str, Point)]) -> State {
    let one = |(node, displacement): &(&str, Point)| {
        (node.parse().unwrap(), NodeMotion { displacement: *displacement, ..NodeMotion::default() })
    };
    State { nodes: moved.iter().map(one).collect(), ..State::default() }
}

/// States at which constraints hold to some digits only prove nothing of a position that is singular to second order: node 2 aside by 5e-3 makes a
/// LINK too long by 1e-5.
#[test]
fn states_that_are_not_admissible_prove_nothing() {
    let deck = links(&[[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]], &[[1, 2], [2, 3]], &[1, 3], STAYS);
    let states = [0.0, 1e-3, 5e-3].map(|y| state(&[("2", [0.0, y, 0.0])]));
    let assembly = at(&deck.text(), &states);
    assert!(assembly.off.is_empty());
    assert!(assembly.redundant_at.is_empty(), "{:?}", assembly.redundant_at);
    assert!(!assembly.redundant.is_empty(), "nothing is redundant");
    assert!(assembly.redundant.iter().all(|one| one.holds == Holds::Isolated));
}

/// What a state is off that is given with a few digits is no matter far from where the assembly is singular, but what is concluded is no proof.
#[test]
fn states_of_few_digits_are_told_as_such() {
    let text = "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 0., 0.5\n4, 1., 0.5\n*ELEMENT, TYPE=CONN2D2, ELSET=BAR\n101, 1, 3\n102, 3, 4\n103, 2, 4\n\
                *CONNECTOR SECTION, ELSET=BAR\nLINK\n*BOUNDARY\n1, 1, 2\n2, 1, 2\n";
    let aside = |angle: f64, error: f64| {
        let by = [0.5 * angle.sin() + error, 0.5 * angle.cos() - 0.5, 0.0];
        state(&[("3", by), ("4", by)])
    };
    let folded = text.replace("3, 0., 0.5", "3, 0.5, 0.").replace("4, 1., 0.5", "4, 1.5, 0.");
    let up = |error: f64| state(&[("3", [-0.5, 0.5 + error, 0.0]), ("4", [-0.5, 0.5 + error, 0.0])]);
    for (error, holds) in [(0.0, Holds::Here), (1e-8, Holds::Differs)] {
        let assembly = at(&folded, &[state(&[]), up(error)]);
        assert_eq!(assembly.redundant[0].holds, Holds::Here);
        let told: Vec<(u64, Holds)> =
            assembly.redundant_at.iter().map(|(at, _, holds)| (*at, *holds)).collect();
        assert_eq!(told, [(0, holds)], "{error}");
    }
    assert!(at(text, &[aside(0.3, 1e-8)]).redundant_at.is_empty());
}

/// A state that moves what boundary conditions hold is not looked at, which decides nothing.
#[test]
fn a_state_that_moves_what_is_held_is_told() {
    let deck = links(&[[0.0; 3], [1.0, 0.0, 0.0]], &[[1, 2]], &[1], STAYS);
    let assembly = at(&deck.text(), &[state(&[("2", [0.0, 1.0, 0.0]), ("1", [0.0, 1.0, 0.0])]), state(&[])]);
    assert_eq!((assembly.off.as_slice(), assembly.off_boundary.as_slice()), ([].as_slice(), [0].as_slice()));
    assert_eq!((assembly.positions.len(), assembly.is_decided()), (2, false));
    let off = at(&deck.text(), &[state(&[("2", [0.5, 0.0, 0.0])])]);
    assert_eq!((off.off.as_slice(), off.is_decided()), ([0].as_slice(), false));
    assert!(at(&deck.text(), &[state(&[])]).is_decided());
    // A held rotation, and one that is free.
    let hinge = "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=Z\n0., 0., 1., 1., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=H\n1, 1, 2\n\
                 *CONNECTOR SECTION, ELSET=H\nHINGE\nZ,\n*BOUNDARY\n1, 1, 6\n";
    let turn = |nodes: &[&str]| {
        let motion = NodeMotion { rotation: Rotation::Vector([0.0, 0.0, 0.5]), ..NodeMotion::default() };
        State {
            nodes: nodes.iter().map(|node| (node.parse().unwrap(), motion)).collect(),
            ..State::default()
        }
    };
    assert_eq!(at(hinge, &[turn(&["2"]), turn(&["1", "2"])]).off_boundary, [1]);
}

/// The row of a component at its singular point is reported as zero. That is no redundant constraint, and leaves no motion.
#[test]
fn a_row_without_derivative_is_not_redundant() {
    for kind in ["HINGE", "REVOLUTE", "UNIVERSAL"] {
        let text = format!(
            "*NODE\n1, 0., 0., 0.\n2, 0., 0., 0.\n*ORIENTATION, NAME=A\n1., 0., 0., 0., 1., 0.\n*ORIENTATION, NAME=B\n0., 0., -1., 0., 1., 0.\n\
             *ELEMENT, TYPE=CONN3D2, ELSET=H\n1, 1, 2\n*CONNECTOR SECTION, ELSET=H\n{kind}\nA, B\n*BOUNDARY\n1, 1, 6\n"
        );
        let assembly = at(&text, &[State::default()]);
        assert!(assembly.redundant.is_empty() && !assembly.is_decided(), "{kind}: {:?}", assembly.redundant);
        for position in &assembly.positions {
            assert!(!position.decided && position.redundant == Some(0), "{kind}");
            assert!(!position.without_derivative.is_empty(), "{kind}");
        }
        assert!(!assembly.modes.is_empty() && assembly.modes.iter().all(|mode| !mode.decided), "{kind}");
    }
}

/// A spatial four-bar of Bennett moves, and written with n decimals it does not: its digits decide, and they are counted.
#[test]
fn digits_that_are_not_given_decide_nothing() {
    let pins = bennett();
    let exact = |decimals: Option<usize>| {
        let write = |x: f64| decimals.map_or(x, |decimals| format!("{x:.decimals$}").parse().unwrap());
        let mut deck = Deck::default();
        deck.closed(&pins.iter().map(|(at, axis)| (at.map(write), axis.map(write))).collect::<Vec<_>>());
        deck.analyse()
    };
    let all = exact(None);
    assert_eq!((all.positions[0].mobility, all.positions[0].decided), (Some(1), true));
    let held: Vec<Holds> = all.redundant.iter().map(|one| one.holds).collect();
    assert_eq!(held, [Holds::Throughout; 3]);
    // What twelve decimals leave out is no more than rounding is taken for.
    for decimals in 3..13 {
        let some = exact(Some(decimals));
        let Position { mobility, decided, .. } = some.positions[0];
        assert!(!decided || (decimals >= 12 && mobility == Some(1)), "{decimals}: {:?}", some.positions[0]);
    }
}

/// Two LINKs in line between held nodes: the node between them can be nowhere else. A state that puts it aside by δ satisfies them but for δ²/2,
/// and has a rank that this alone makes: it is not decided.
#[test]
fn a_rank_of_the_residual_is_not_decided() {
    let text = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 3., 0., 0.\n*ELEMENT, TYPE=CONN3D2, ELSET=ROD\n101, 1, 2\n102, 2, 3\n\
                *CONNECTOR SECTION, ELSET=ROD\nLINK\n*BOUNDARY\n1, 1, 3\n3, 1, 3\n";
    let scene = Scene::parse("aside.inp", text).unwrap();
    let model = Model::compile(&scene).unwrap();
    for aside in [1e-6, 1e-4, 1e-3, 5e-3] {
        let moved = NodeMotion { displacement: [0.0, aside, 0.0], ..NodeMotion::default() };
        let state = State { nodes: [("2".parse().unwrap(), moved)].into(), ..State::default() };
        let assembly = analyse(&scene, &model, &[state], 1).unwrap();
        let found: Vec<_> = assembly.positions.iter().map(|one| (one.rank, one.decided)).collect();
        assert_eq!(found[0], (Some(1), true), "{:?}", assembly.positions);
        assert!(found[1].0 == Some(1) || !found[1].1, "{aside}: {:?}", assembly.positions[1]);
    }
}
