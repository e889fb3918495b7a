//! What the history of four connectors decides, by the source and the rule of one.

use crate::batch::tile::{Four, four, matrix, vector};
use crate::connector::{Branch, Connector, Increment, State, Tally, Turns};
use crate::measure::Section;
use crate::node::{Node, Pair};
use crate::scalar::lanes::{LANES, Lanes};
use crate::vector::Vector;

/// Lanes of any processor.
type Plain = Lanes<false>;

fn plain(x: [Four; 3]) -> Vector<Plain> {
    x.map(Lanes)
}

/// Four of what R is one of.
fn increments(of: &[Increment<f64>; LANES]) -> Increment<Plain> {
    Increment {
        rotation: [0, 1].map(|end| plain(vector(of, |one| one.rotation[end]))),
        whole_turns: [0, 1].map(|end| plain(vector(of, |one| one.whole_turns[end]))),
        flow: [0, 1].map(|end| Lanes(four(of, |one| one.flow[end]))),
    }
}

fn states(of: &[State<f64>; LANES]) -> State<Plain> {
    let node = |get: fn(&State<f64>) -> &Node<f64>| Node {
        displacement: plain(vector(of, |one| get(one).displacement)),
        triad: matrix(of, |one| get(one).triad).map(plain),
        flow: Lanes(four(of, |one| get(one).flow)),
    };
    let rates = |get: fn(&State<f64>) -> &[f64]| {
        std::array::from_fn(|j| Lanes(four(of, |one| get(one).get(j).copied().unwrap_or(0.0))))
    };
    State {
        pair: Pair {
            reference: plain(vector(of, |one| one.pair.reference)),
            a: node(|one| &one.pair.a),
            b: node(|one| &one.pair.b),
        },
        velocity: rates(|one| &one.velocity),
        acceleration: rates(|one| &one.acceleration),
    }
}

fn section(of: &[&Connector<f64>; LANES]) -> Section<Plain> {
    Section {
        initial_orientation: matrix(of, |one| one.section().initial_orientation).map(plain),
        initial_length: Lanes(four(of, |one| one.section().initial_length)),
        fixed_direction: plain(vector(of, |one| one.section().fixed_direction)),
        flow_scale: Lanes(four(of, |one| one.section().flow_scale)),
    }
}

fn branches(of: &[Branch<f64>; LANES]) -> Branch<Plain> {
    let turns = |get: &dyn Fn(&Branch<f64>) -> Turns<f64>| Turns {
        turns: Lanes(four(of, |one| get(one).turns)),
        principal: Lanes(four(of, |one| get(one).principal)),
    };
    Branch {
        turns: [0, 1, 2, 3, 4, 5].map(|k| turns(&|one| one.turns[k])),
        rotation_vector: plain(vector(of, |one| one.rotation_vector)),
        euler_sign: Lanes(four(of, |one| one.euler_sign)),
        torsion: turns(&|one| one.torsion),
        accumulated: Lanes(four(of, |one| one.accumulated)),
        accumulated_rest: Lanes(four(of, |one| one.accumulated_rest)),
    }
}

/// The branch of lane i.
fn branch(of: &Branch<Plain>, i: usize) -> Branch<f64> {
    let lane = |x: Plain| x.0.get(i).copied().unwrap_or(f64::NAN);
    let turns = |t: Turns<Plain>| Turns { turns: lane(t.turns), principal: lane(t.principal) };
    Branch {
        turns: of.turns.map(turns),
        rotation_vector: of.rotation_vector.map(lane),
        euler_sign: lane(of.euler_sign),
        torsion: turns(of.torsion),
        accumulated: lane(of.accumulated),
        accumulated_rest: lane(of.accumulated_rest),
    }
}

/// [`Connector::advance`] of four connectors of one connection type at once: the branches after their states.
///
/// Principal angles come from lanes, turns from them by the same rule; only the connectors' measures and section data are looked at.
#[inline]
pub fn advance(
    connectors: &[&Connector<f64>; LANES],
    states_of: &[State<f64>; LANES],
    increments_of: &[Increment<f64>; LANES],
    branches_of: &[Branch<f64>; LANES],
) -> [Branch<f64>; LANES] {
    let section = section(connectors);
    let after = Connector::gathered(connectors, &section).follow(
        &states(states_of),
        &increments(increments_of),
        &branches(branches_of),
        [true; 6],
        &mut Tally::default(),
    );
    [branch(&after, 0), branch(&after, 1), branch(&after, 2), branch(&after, 3)]
}
