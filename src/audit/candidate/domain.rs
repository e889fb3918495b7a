//! Where states are drawn: what a user needs, or a routine covers.

use crate::case::{Case, Step};
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::node::Pair;
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, add, apply, dot, product, scale, sub, transpose};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::fmt;

/// The names of what has a range, along the axes of a: the place of b seen from a (length), and the rotation vector by which b has turned
/// against a since the initial state (rad).
const NAMES: [&str; 6] = ["x1", "x2", "x3", "r1", "r2", "r3"];

/// Ranges of relative places and angles; what has none is free.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "BTreeMap<String, [f64; 2]>", into = "BTreeMap<String, [f64; 2]>")]
pub struct Domain([Option<[f64; 2]>; 6]);

impl TryFrom<BTreeMap<String, [f64; 2]>> for Domain {
    type Error = String;

    fn try_from(given: BTreeMap<String, [f64; 2]>) -> Result<Self, String> {
        let mut found = Self::default();
        for (name, [low, high]) in given {
            let place = NAMES.iter().position(|known| *known == name);
            let place =
                place.ok_or_else(|| format!("the domain names {name:?}; there are {}", NAMES.join(", ")))?;
            if !(low.is_finite() && high.is_finite() && low <= high) {
                return Err(format!("the domain of {name} is {low} to {high}: no range of finite numbers"));
            }
            if place >= 3 && (low <= -PI || high >= PI) {
                return Err(format!("the domain of {name} is {low} to {high}: angles lie between −π and π"));
            }
            found.0[place] = Some([low, high]);
        }
        let least = norm(found.least_turned());
        if least >= PI {
            let why = "no rotation vector between −π and π is as long as that";
            return Err(format!("the domain of r1, r2, r3 begins at a turn of {least} rad: {why}"));
        }
        Ok(found)
    }
}

impl From<Domain> for BTreeMap<String, [f64; 2]> {
    fn from(domain: Domain) -> Self {
        let ranges = NAMES.iter().zip(domain.0);
        ranges.filter_map(|(name, range)| Some(((*name).to_string(), range?))).collect()
    }
}

impl std::str::FromStr for Domain {
    type Err = String;

    /// `x1=-0.5:0.5,r3=0:1`.
    fn from_str(text: &str) -> Result<Self, String> {
        let mut given = BTreeMap::new();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let read = || {
                let (name, range) = part.split_once('=')?;
                let (low, high) = range.split_once(':')?;
                Some((name.trim().to_string(), [low.trim().parse().ok()?, high.trim().parse().ok()?]))
            };
            let (name, range) =
                read().ok_or_else(|| format!("{part:?} is no range: write x1=-0.5:0.5 or r3=0:1"))?;
            if given.insert(name, range).is_some() {
                return Err(format!("{part:?} comes twice"));
            }
        }
        Self::try_from(given)
    }
}

/// As it is read: `x1=-0.5:0.5,r3=0:1`.
impl fmt::Display for Domain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ranges = NAMES.iter().zip(self.0);
        let ranges =
            ranges.filter_map(|(name, range)| range.map(|[low, high]| format!("{name}={low}:{high}")));
        f.write_str(&ranges.collect::<Vec<String>>().join(","))
    }
}

/// Up and down between the ends of a range, as often as x is beyond them: what is within stays as it is.
fn folded(x: f64, [low, high]: [f64; 2]) -> f64 {
    let width = high - low;
    if (low..=high).contains(&x) {
        x
    } else if width <= 0.0 {
        low
    } else {
        let along = (x - low).rem_euclid(2.0 * width);
        (low + if along > width { 2.0 * width - along } else { along }).clamp(low, high)
    }
}

impl Domain {
    /// Whether everything is free.
    pub fn is_everything(&self) -> bool {
        self.0.iter().all(Option::is_none)
    }

    /// How far its places reach from node a; `None` where none is limited.
    pub(super) fn reach(&self) -> Option<f64> {
        let ends = self.0[..3].iter().flatten().flatten();
        ends.map(|end| end.abs()).reduce(f64::max)
    }

    /// Whether a pair lies in it, but for rounding.
    pub fn holds(&self, definition: &Definition, pair: &Pair<f64>) -> bool {
        let (x, r) = relative(definition, pair);
        let size = 1e-12 * (1.0 + x.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
        let is_in = |(x, range): (&f64, &Option<[f64; 2]>)| {
            range.is_none_or(|[low, high]| (low - size..=high + size).contains(x))
        };
        x.iter().chain(&r).zip(&self.0).all(is_in)
    }

    /// The shortest rotation vector of its ranges.
    fn least_turned(&self) -> Vector<f64> {
        [3, 4, 5].map(|k| self.0[k].map_or(0.0, |[low, high]| 0.0_f64.clamp(low, high)))
    }

    /// Whether it limits places (`first` = 0) or turns (`first` = 3).
    fn limits(&self, first: usize) -> bool {
        self.0[first..first + 3].iter().any(Option::is_some)
    }

    /// A drawn case brought into the domain, a history step by step; `None` where its nodes cannot be brought there, or where it is to stay
    /// where it was drawn and that is outside.
    pub(super) fn brought(&self, case: Case, stays: bool) -> Option<Case> {
        let definition = &case.definition;
        // A turn goes on along the path. Where turns are limited a routine need not know whole ones.
        let mut turned = [0.0; 3];
        let turns: Vec<Vector<f64>> = case
            .path
            .iter()
            .map(|step| {
                turned = continued(relative(definition, &step.state.pair).1, turned);
                turned
            })
            .collect();
        let is_known = |turned: &Vector<f64>| !self.limits(3) || norm(*turned) < PI;
        let is_within = case.path.iter().all(|step| self.holds(definition, &step.state.pair));
        if is_within && turns.iter().all(is_known) {
            return Some(case);
        }
        if stays {
            return None;
        }
        let mut path: Vec<Step> = Vec::with_capacity(case.path.len());
        let mut reached = [0.0; 3];
        for (step, turned) in case.path.iter().zip(turns) {
            let State { pair, velocity, acceleration } = step.state;
            let within = self.turn_within(turned);
            let pair = self.nearest(definition, pair, (within != turned).then_some(within));
            if !self.holds(definition, &pair) || !is_in_plane(definition, &pair) {
                return None;
            }
            let before = path.last().map_or(definition.initial, |step| step.state.pair);
            let between = Step::between(&before, pair);
            // Neither node turns by as much as half a turn where this bounds both.
            let bound = norm(step.increment.rotation[0]).max(norm(step.increment.rotation[1]))
                + norm(sub(within, reached));
            if case.path.len() > 1 && bound >= PI {
                return None;
            }
            reached = within;
            path.push(Step { state: State { pair, velocity, acceleration }, ..between });
        }
        Some(Case { start: None, path, ..case })
    }

    /// A rotation vector with its components in the ranges, and shorter than half a turn.
    fn turn_within(&self, turned: Vector<f64>) -> Vector<f64> {
        /// Nearer to half a turn than that a range must ask for it.
        const LONG: f64 = 3.0;
        if !self.limits(3) {
            return turned;
        }
        let within = [0, 1, 2].map(|k| self.0[k + 3].map_or(turned[k], |range| folded(turned[k], range)));
        let least = self.least_turned();
        let longest = f64::midpoint(norm(least).max(LONG), PI);
        if norm(within) <= longest {
            return within;
        }
        // Towards the shortest one until it is short enough: what lies between two of a box is in it.
        let by = sub(within, least);
        let (along, size) = (dot(least, by), dot(by, by));
        let root = along.mul_add(along, size * (longest * longest - dot(least, least))).sqrt();
        add(least, scale(by, (root - along) / size))
    }

    /// The pair with its relative place in the ranges, turned so if at all: b is moved, or a where b does not move.
    fn nearest(
        &self,
        definition: &Definition,
        mut pair: Pair<f64>,
        turned: Option<Vector<f64>>,
    ) -> Pair<f64> {
        let turns = [0, 1].map(|end| definition.moves[end] && definition.rotates[end]);
        if let Some(turned) = turned {
            let between = product(&so3::exp(turned), &definition.initial.relative().q);
            if turns[1] {
                pair.b.triad = product(&pair.a.triad, &between);
            } else if turns[0] {
                pair.a.triad = product(&pair.b.triad, &transpose(&between));
            }
        }
        if !self.limits(0) {
            return pair;
        }
        // Seen from a as it is now.
        let place = pair.relative().d;
        let within = [0, 1, 2].map(|k| self.0[k].map_or(place[k], |range| folded(place[k], range)));
        let mut by = apply(&pair.a.triad, sub(within, place));
        if definition.planar {
            by[2] = 0.0;
        }
        if definition.moves[1] {
            pair.b.displacement = add(pair.b.displacement, by);
        } else if definition.moves[0] {
            pair.a.displacement = sub(pair.a.displacement, by);
        }
        pair
    }
}

/// The place of b seen from a and the rotation vector of b against a since the initial state, along the axes of a.
fn relative(definition: &Definition, pair: &Pair<f64>) -> (Vector<f64>, Vector<f64>) {
    let now = pair.relative();
    (now.d, so3::log(&product(&now.q, &transpose(&definition.initial.relative().q))))
}

/// The rotation vector of the same rotation that is nearest to the one before: whole turns more or less, along its axis.
fn continued(turned: Vector<f64>, before: Vector<f64>) -> Vector<f64> {
    let angle = norm(turned);
    if angle <= 0.0 {
        return turned;
    }
    let axis = scale(turned, 1.0 / angle);
    scale(axis, angle + TAU * ((dot(axis, before) - angle) / TAU).round())
}

/// Whether a two-dimensional connector is in its plane.
fn is_in_plane(definition: &Definition, pair: &Pair<f64>) -> bool {
    /// Rounding of a product of triads.
    const LEVEL: f64 = 1e-12;
    let initial = &definition.initial;
    // What turns about the third axis keeps what its directions have along it.
    let is_level = |(now, first): (&f64, &f64)| (now - first).abs() <= LEVEL;
    let mut ends = [(&pair.a, &initial.a), (&pair.b, &initial.b)].into_iter();
    !definition.planar || ends.all(|(now, first)| now.triad[2].iter().zip(&first.triad[2]).all(is_level))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{aligned, definition, pair, types};
    use crate::{Candidate, Settings};
    use pintle_kinematics::draw::Draw;

    /// Every state of every path lies within, in less than half a turn from the one before. No turn goes on beyond the ranges.
    ///
    /// It gives how many states, histories, and cases of those that are drawn everywhere there are.
    fn asked_within(definition: &Definition, domain: &Domain) -> [usize; 4] {
        let settings = Settings { states: 60, near_singular_states: 20, ..Settings::default() };
        let candidate = Candidate::new("within", definition).settings(settings).histories(10);
        let within = candidate.clone().within(domain.clone());
        let drawn = within.drawn();
        let (mut states, mut histories) = (0, 0);
        for case in &drawn {
            let name = &case.name;
            let (mut before, mut turned) = (definition.initial, [0.0; 3]);
            for step in &case.path {
                let pair = &step.state.pair;
                let (_, now) = relative(definition, pair);
                assert!(domain.holds(definition, pair), "{name}: {:?}", relative(definition, pair));
                assert!(is_in_plane(definition, pair), "{name}: {pair:?}");
                for (end, [now, first]) in
                    [[&pair.a, &definition.initial.a], [&pair.b, &definition.initial.b]]
                        .into_iter()
                        .enumerate()
                {
                    let moves = definition.moves[end];
                    assert!(moves || now.displacement == first.displacement, "{name}: {end} moves");
                    let turns = moves && definition.rotates[end];
                    let turned = so3::log(&product(&now.triad, &transpose(&first.triad)));
                    assert!(turns || norm(turned) < 1e-12, "{name}: {end} turns by {turned:?}");
                    let level = now.displacement[2] == first.displacement[2];
                    assert!(!definition.planar || level, "{name}: {end} leaves the plane");
                }
                turned = continued(now, turned);
                assert!(!domain.limits(3) || norm(turned) < PI, "{name}: {turned:?} is a turn");
                let again = Step::between(&before, *pair).increment.rotation;
                let same = again.into_iter().zip(step.increment.rotation);
                assert!(same.into_iter().all(|(x, y)| norm(sub(x, y)) < 1e-12), "{name}");
                before = *pair;
                states += 1;
            }
            histories += usize::from(case.path.len() > 1);
        }
        let everywhere = candidate.drawn();
        assert_eq!(within.left_out(), everywhere.len() - drawn.len());
        [states, histories, drawn.len(), everywhere.len()]
    }

    fn of_type(connection: &pintle_kinematics::catalog::ConnectionType) -> Definition {
        let draw = &mut Draw::new("a domain");
        let relative = aligned(connection, draw);
        definition(connection, pair([0.3, -0.4, 0.1], so3::exp([0.4, -0.3, 0.7]), &relative), 1.2)
    }

    /// Small ranges, large ones of all three turns, one that begins far from the initial state, and places alone.
    #[test]
    fn drawn_states_lie_within() {
        let mut found = [0; 4];
        for (domain, turns_on) in [
            ("x1=-0.3:0.4, x3=0.1:0.1, r2=-0.5:0.25, r3=-1:1", false),
            ("r1=-3.1:3.1, r2=-3.1:3.1, r3=-3.1:3.1", false),
            ("r1=1.5:3, r2=-3:3, r3=2:2.5", false),
            ("x2=-0.1:0.1", true),
        ] {
            let domain: Domain = domain.parse().unwrap();
            let mut of_domain = [0; 4];
            for connection in types() {
                let definition = of_type(&connection);
                let more = asked_within(&definition, &domain);
                of_domain = std::array::from_fn(|i| of_domain[i] + more[i]);
                let candidate = Candidate::new("whole turns", &definition).within(domain.clone());
                let case = candidate.history(40);
                let largest = |case: &Case| {
                    case.path.iter().fold([0.0; 3], |turned, step| {
                        continued(relative(&definition, &step.state.pair).1, turned)
                    })
                };
                let is_far = case.as_ref().is_some_and(|case| norm(largest(case)) > TAU);
                assert!(turns_on || !is_far, "{}", connection.name);
            }
            let [states, histories, inside, wide] = of_domain;
            println!("{domain}: {states} states, {histories} histories, {inside} of {wide} cases");
            // A history begins at the initial state, and comes into a domain far from it by no small increment.
            let is_near = norm(domain.least_turned()) <= 0.0;
            assert!((histories >= 100) == is_near && inside * 2 > wide, "{domain}: {of_domain:?}");
            found = std::array::from_fn(|i| found[i] + of_domain[i]);
        }
        assert!(found[0] > 20_000, "{found:?}");
    }

    /// What the domain keeps states from is told as its doing; what states lack anywhere is not.
    #[test]
    fn the_domain_is_the_reason() {
        let hinge = pintle_kinematics::catalog::ConnectionType::named("HINGE", None).unwrap();
        let definition = of_type(&hinge);
        let candidate = Candidate::new("within", &definition);
        let domain: Domain = "r1=-0.05:0.05,r2=0:0,r3=0:0".parse().unwrap();
        let lacks = |candidate: &Candidate<'_>| candidate.lacks(candidate.coverage());
        assert!(lacks(&candidate).is_none());
        let found = lacks(&candidate.within(domain)).unwrap();
        let told = format!("{:?}", found.findings);
        assert!(!found.findings.is_empty() && told.contains("the domain r1=-0.05:0.05"), "{told}");
    }

    /// Nothing moves, turns, or leaves the plane that cannot; what cannot be brought is left out, and counted.
    #[test]
    fn what_cannot_move_stays() {
        let free = Domain::default();
        let mut found = [0; 4];
        for name in ["CARTESIAN", "REVOLUTE", "HINGE", "ROTATION", "JOIN"] {
            let connection = pintle_kinematics::catalog::ConnectionType::named(name, None).unwrap();
            let level = Definition::new(
                connection.clone(),
                pair([0.3, -0.4, 0.0], so3::exp([0.0, 0.0, 0.7]), &so3::exp([0.0; 3])),
            );
            let oblique = of_type(&connection);
            for definition in [
                Definition { planar: true, ..level.clone() },
                Definition { planar: true, moves: [false, true], ..level },
                Definition { moves: [false, true], ..oblique.clone() },
                Definition { moves: [true, false], ..oblique.clone() },
                Definition { rotates: [false; 2], ..oblique.clone() },
                Definition { rotates: [true, false], ..oblique.clone() },
                Definition { rotates: [true, false], moves: [false, true], ..oblique },
            ] {
                for domain in [
                    "x1=-0.2:0.6, r3=-0.4:0.9",
                    "x3=0.2:0.3",
                    "r1=0.1:0.2",
                    "x1=-0.2:0.6, r1=-3:3, r2=-3:3, r3=-3:3",
                ] {
                    let domain: Domain = domain.parse().unwrap();
                    let more = asked_within(&definition, &domain);
                    found = std::array::from_fn(|i| found[i] + more[i]);
                    let is_out = definition.planar && domain.limits(0) != domain.limits(3);
                    let turns = (0..2).any(|end| definition.moves[end] && definition.rotates[end]);
                    let is_fixed = !turns && !domain.limits(0);
                    assert_eq!(more[2] == 0, is_out || is_fixed, "{name} {domain}: {more:?}");
                }
            }
        }
        assert!(free.is_everything() && found[0] > 9_000, "{found:?}");
        println!("{found:?}");
    }

    #[test]
    fn what_is_within_stays() {
        assert_eq!(folded(0.3, [0.0, 1.0]), 0.3);
        for (x, want) in [(1.25, 0.75), (-0.25, 0.25), (2.5, 0.5), (-1.75, 0.25)] {
            assert!((folded(x, [0.0, 1.0]) - want).abs() < 1e-15, "{x}");
        }
        for (text, why) in [
            ("y1=0:1", "names \"y1\""),
            ("x1=1:0", "no range"),
            ("x1=0", "no range"),
            ("r1=-4:0", "between −π and π"),
            ("x1=0:1,x1=0:2", "twice"),
            ("r1=3:3.1,r2=1:2", "as long as that"),
        ] {
            let told = text.parse::<Domain>().unwrap_err();
            assert!(told.contains(why), "{text}: {told}");
        }
        let text = "x1=-0.5:0.5,r3=0:1";
        assert_eq!(text.parse::<Domain>().unwrap().to_string(), text);
    }
}
