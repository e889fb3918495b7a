//! Do states turn nodes by angles in degrees? They are in radians.
//!
//! What looks like degrees is a multiple of 15 without a fraction, from 30 on: of angles in radians, which are measured or computed,
//! hardly one in a million is such a number.

use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{count, number};
use crate::label::Label;
use crate::model::{Rotation, State};
use crate::span::Span;
use std::collections::HashMap;

/// Whether an angle looks like one in degrees.
#[must_use]
pub fn is_in_degrees(angle: f64) -> bool {
    angle.abs() >= 30.0 && angle % 15.0 == 0.0
}

/// What an angle that looks like degrees is said to be, the reason, and the remedy.
#[must_use]
pub fn told_in_degrees(what: &str, angle: f64) -> (String, &'static str, String) {
    let radians = angle.to_radians();
    (
        format!("{what}, which looks like degrees: in radians that is {}", number(radians, 6)),
        "angles are in radians, in decks as in states",
        format!("write {} where {}° is meant", number(radians, 9), number(angle, 9)),
    )
}

/// Time, total rotation vector, angular velocity.
type Turned = (f64, [f64; 3], [f64; 3]);

/// Angles of states that look like degrees. Those that the given rates prove to be in radians do not.
#[derive(Debug, Clone, Default)]
pub struct Degrees {
    /// The largest: the number of its state, its node, the angle.
    worst: Option<(u64, Label, f64)>,
    turned: usize,
    angles: usize,
    before: HashMap<Label, Turned>,
}

/// What of states looks like degrees.
#[derive(Debug, Clone, PartialEq)]
pub struct InDegrees {
    /// The number of the state with the largest such angle.
    pub state: u64,
    /// Its node.
    pub node: Label,
    /// The angle.
    pub angle: f64,
    /// `state 2 turns node 7 by 90 (and 3 more such angles)`.
    pub what: String,
    /// Whether most angles of the states look so, and what else is wrong with them follows from that.
    pub is_common: bool,
}

impl Degrees {
    /// Looks at the next state, of that number.
    pub fn see(&mut self, number: u64, state: &State) {
        for (node, motion) in &state.nodes {
            let Rotation::Vector(vector) = motion.rotation else { continue };
            let now = state.time.map(|time| (time, vector, motion.angular_velocity));
            let proven = now.as_ref().is_some_and(|now| is_proven(self.before.get(node), now));
            if let Some(now) = now {
                self.before.insert(*node, now);
            }
            if proven {
                continue;
            }
            self.angles += vector.into_iter().filter(|angle| *angle != 0.0).count();
            for angle in vector.into_iter().filter(|angle| is_in_degrees(*angle)) {
                self.turned += 1;
                if self.worst.is_none_or(|(.., most)| angle.abs() > most.abs()) {
                    self.worst = Some((number, *node, angle));
                }
            }
        }
    }

    /// What was found, where anything was.
    #[must_use]
    pub fn found(&self) -> Option<InDegrees> {
        let (state, node, angle) = self.worst?;
        let others = self.turned - 1;
        let others =
            if others > 0 { format!(" (and {})", count(others, "more such angle")) } else { String::new() };
        let what = format!("state {state} turns node {node} by {angle}{others}");
        Some(InDegrees { state, node, angle, what, is_common: 2 * self.turned >= self.angles })
    }

    /// The same as a warning.
    #[must_use]
    pub fn warning(&self) -> Option<Diagnostic> {
        let found = self.found()?;
        let (message, reason, remedy) = told_in_degrees(&found.what, found.angle);
        Some(Diagnostic::finding(Code::ModelDegrees, Span::default(), message, reason).help(remedy))
    }
}

/// Whether the rates that states give show an increment to be in radians: they lead from one state to the next, to a fifth of the way.
fn is_proven(before: Option<&Turned>, now: &Turned) -> bool {
    let (Some((t0, turned, rate)), (t1, turned_now, rate_now)) = (before, now) else { return false };
    let (mut apart, mut largest) = (0.0_f64, 0.0_f64);
    for k in 0..3 {
        let moved = turned_now[k] - turned[k];
        let expected = (t1 - t0) * (rate[k] + rate_now[k]) / 2.0;
        apart = apart.max((moved - expected).abs());
        largest = largest.max(moved.abs());
    }
    largest > 0.0 && apart <= 0.2 * largest
}

#[cfg(test)]
mod tests {
    use super::is_in_degrees;

    #[test]
    fn round_numbers_of_degrees_are_told_from_radians() {
        assert!([30.0, -90.0, 360.0, 45.0, 720.0].into_iter().all(is_in_degrees));
        assert!(![0.0, 15.0, 29.999, 90.1, 31.415_926_535, 100.0].into_iter().any(is_in_degrees));
    }
}
