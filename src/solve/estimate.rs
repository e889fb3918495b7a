//! The error of a solution on doubles, where motion makes rounding grow.
//!
//! Where neighbouring motions part, all that rounding has done to a run points the same way in the end: it is one number, of either sign. Two of
//! them may be next to each other by chance, and far from the truth: one time in thirty they are ten times nearer. Of four runs that round
//! otherwise that is one time in hundreds.

use crate::number::Number;
use crate::time::integrate::Method;
use crate::time::run::{Options, Solvable, solve};
use crate::time::solution::{Difference, Solution};
use pintle_scene::Scene;
use std::thread;

/// Where nothing grows, two methods on doubles agree to this or better.
const GROWN: f64 = 1e-14;

/// How many times the largest difference the error may be. Where nothing grows all numbers of a solution are as many chances to see it; where
/// rounding grows there are four runs.
const SURE: f64 = 3.0;

/// The same where rounding grows and no other run but its witness has the events of the solution, or one alone.
const LESS_SURE: [f64; 2] = [10.0, 5.0];

/// The error of a solution, whose difference from its witness is known. On 237 bits it is that difference.
pub fn estimate<R: Solvable>(
    scene: &Scene,
    options: &Options,
    (solution, witness): (&Solution<R>, Difference),
) -> Difference {
    if !witness.same_events || R::ROUNDING < f64::ROUNDING {
        return witness;
    }
    // When events are is found to no more digits, and costs no further runs.
    let of_states = Difference { event: 0.0, ..witness };
    if of_states.largest() <= GROWN {
        return largest(&[witness], SURE);
    }
    let trial = |trial, method| {
        let length = Some(solution.length);
        let options = Options { trial, method, length, reached: None, ..options.clone() };
        solve::<R>(scene, &options).ok().map(|other| solution.difference(&other))
    };
    let others = thread::scope(|scope| {
        let second = scope.spawn(|| trial(2, Method::Collocation));
        let first = trial(1, Method::Extrapolation);
        [first, second.join().ok().flatten()]
    });
    let others = others.into_iter().flatten().filter(|other| other.same_events);
    let all: Vec<Difference> = std::iter::once(witness).chain(others).collect();
    largest(&all, LESS_SURE.get(all.len() - 1).copied().unwrap_or(SURE))
}

/// So many times the largest of each kind.
fn largest(all: &[Difference], factor: f64) -> Difference {
    let most = |of: fn(&Difference) -> f64| factor * all.iter().map(of).fold(0.0, f64::max);
    Difference {
        displacement: most(|of| of.displacement),
        rotation: most(|of| of.rotation),
        velocity: most(|of| of.velocity),
        force: most(|of| of.force),
        energy: most(|of| of.energy),
        event: most(|of| of.event),
        same_events: true,
        others_from: None,
        compared: all.iter().map(|of| of.compared).min().unwrap_or(0),
        runs: all.len() + 1,
    }
}
