//! Where states are drawn: what a user needs, or a routine covers.

use crate::case::{Case, Step};
use pintle_kinematics::connector::{Definition, State};
use pintle_kinematics::node::Pair;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{Vector, add, apply, product, sub, transpose};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
            if place >= 3 && (low <= -std::f64::consts::PI || high >= std::f64::consts::PI) {
                return Err(format!("the domain of {name} is {low} to {high}: angles lie between −π and π"));
            }
            found.0[place] = Some([low, high]);
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

    /// Whether a pair lies in it, but for rounding.
    pub fn holds(&self, definition: &Definition, pair: &Pair<f64>) -> bool {
        let (x, r) = relative(definition, pair);
        let size = 1e-12 * (1.0 + x.iter().fold(0.0, |most: f64, x| most.max(x.abs())));
        let is_in = |(x, range): (&f64, &Option<[f64; 2]>)| {
            range.is_none_or(|[low, high]| (low - size..=high + size).contains(x))
        };
        x.iter().chain(&r).zip(&self.0).all(is_in)
    }

    /// A drawn case brought into the domain; `None` where it is to stay where it was drawn and that is outside.
    pub(super) fn brought(&self, case: Case, stays: bool) -> Option<Case> {
        if self.is_everything() || case.path.iter().all(|step| self.holds(&case.definition, &step.state.pair))
        {
            return Some(case);
        }
        if stays {
            return None;
        }
        let definition = &case.definition;
        let State { pair, velocity, acceleration } = case.path.last()?.state;
        let pair = self.nearest(definition, pair);
        let mut step = Step::between(&definition.initial, pair);
        step.state = State { pair, velocity, acceleration };
        // By one step from the initial state: a way through what is outside is none.
        Some(Case { start: None, path: vec![step], ..case })
    }

    /// The pair with its relative place and rotation in the ranges: b is moved, or a where b is ground.
    fn nearest(&self, definition: &Definition, mut pair: Pair<f64>) -> Pair<f64> {
        let (x, r) = relative(definition, &pair);
        let within = |x: f64, k: usize| self.0[k].map_or(x, |range| folded(x, range));
        let initial = &definition.initial;
        let first = product(&transpose(&initial.a.triad), &initial.b.triad);
        let mut turned = r;
        for (k, x) in turned.iter_mut().enumerate() {
            *x = within(*x, k + 3);
        }
        let is_turned = turned != r;
        let [moves_a, moves_b] = definition.moves;
        let moves_b = moves_b || !moves_a;
        let between = product(&so3::turn(turned), &first);
        if is_turned && moves_b && definition.rotates[1] {
            pair.b.triad = product(&pair.a.triad, &between);
        } else if is_turned && definition.rotates[0] {
            pair.a.triad = product(&pair.b.triad, &transpose(&between));
        }
        let mut place: Vector<f64> = x;
        for (k, x) in place.iter_mut().enumerate() {
            *x = within(*x, k);
        }
        // Seen from a as it is now.
        let wanted = apply(&pair.a.triad, place);
        let now = add(pair.reference, sub(pair.b.displacement, pair.a.displacement));
        let by = sub(wanted, now);
        if moves_b {
            pair.b.displacement = add(pair.b.displacement, by);
        } else {
            pair.a.displacement = sub(pair.a.displacement, by);
        }
        pair
    }
}

/// The place of b seen from a and the rotation vector of b against a since the initial state, along the axes of a.
fn relative(definition: &Definition, pair: &Pair<f64>) -> (Vector<f64>, Vector<f64>) {
    let apart = add(pair.reference, sub(pair.b.displacement, pair.a.displacement));
    let seen = transpose(&pair.a.triad);
    let initial = &definition.initial;
    let first = product(&transpose(&initial.a.triad), &initial.b.triad);
    let turned = product(&product(&seen, &pair.b.triad), &transpose(&first));
    (apply(&seen, apart), so3::log(&turned))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{aligned, definition, pair, types};
    use crate::{Candidate, Settings};
    use pintle_kinematics::draw::Draw;

    #[test]
    fn drawn_states_lie_within() {
        let domain: Domain = "x1=-0.3:0.4, x3=0.1:0.1, r2=-0.5:0.25, r3=-1:1".parse().unwrap();
        let (mut states, mut inside, mut wide) = (0, 0, 0);
        for connection in types() {
            let draw = &mut Draw::new("a domain");
            let relative = aligned(&connection, draw);
            let definition =
                definition(&connection, pair([0.3, -0.4, 0.1], so3::turn([0.4, -0.3, 0.7]), &relative), 1.2);
            let settings = Settings { states: 60, near_singular_states: 20, ..Settings::default() };
            let candidate = Candidate::new("within", &definition).settings(settings).histories(10);
            let drawn = candidate.clone().within(domain.clone()).drawn();
            for case in &drawn {
                for step in &case.path {
                    assert!(
                        domain.holds(&definition, &step.state.pair),
                        "{}: {:?}",
                        connection.name,
                        super::relative(&definition, &step.state.pair)
                    );
                    states += 1;
                }
            }
            wide += candidate.drawn().len();
            inside += drawn.len();
        }
        println!("{states} states within, of {inside} of {wide} cases");
        assert!(states > 1_500 && inside * 2 > wide);
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
        ] {
            let told = text.parse::<Domain>().unwrap_err();
            assert!(told.contains(why), "{text}: {told}");
        }
    }
}
