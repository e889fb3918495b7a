//! Which connectors of a large scene are judged, and at which of its states: an even sample of both.
//!
//! A connector state that is judged on doubles costs a unit, one on 237 bits [`WIDE`] more. Where all together cost more than is
//! allowed, each connector is judged at fewer states, down to [`FEW`]; then fewer connectors are judged, but one of every type
//! and behaviour.

use crate::settings::Settings;
use pintle_model::evaluate::{Model, Plan};
use serde::Serialize;
use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

/// What a connector state costs on 237 bits, beside one on doubles.
const WIDE: u64 = 9;

/// States of a connector that cost as much as one on 237 bits: before there are fewer, fewer connectors are judged.
const FEW: u64 = WIDE;

/// How much of a scene was judged.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Share {
    /// The scene.
    pub scene: String,
    /// Connectors and constraints that were judged at any state.
    pub connectors: u64,
    /// Connectors and constraints that there are.
    pub of_connectors: u64,
    /// Connector states that were judged.
    pub states: u64,
    /// Connector states that there are.
    pub of_states: u64,
    /// The connectors that were judged, by their indices in the model.
    #[serde(skip)]
    pub judged: Vec<usize>,
}

impl Share {
    /// Whether everything was judged.
    pub const fn is_whole(&self) -> bool {
        self.states == self.of_states
    }

    /// The part of the connector states that was judged.
    pub fn part(&self) -> f64 {
        if self.of_states == 0 { 1.0 } else { self.states as f64 / self.of_states as f64 }
    }
}

/// `wanted` places among `count`: the first, the last, and others evenly between them; of one alone the last, for at the first nothing
/// has moved yet.
pub(crate) fn spread(count: usize, wanted: usize) -> BTreeSet<usize> {
    spread_of(count, wanted, 0)
}

/// The same for one of many that share a history, by its number: where each has one place only, together they cover the history.
/// The first of them takes the last place, the second the first, others halve the gaps.
fn spread_of(count: usize, wanted: usize, number: usize) -> BTreeSet<usize> {
    let Some(last) = count.checked_sub(1) else { return BTreeSet::new() };
    match wanted.min(count) {
        0 => BTreeSet::new(),
        1 => {
            let place = match number {
                0 => last,
                1 => 0,
                _ => halved(number - 1, last),
            };
            BTreeSet::from([place])
        }
        wanted => (0..wanted).map(|i| i * last / (wanted - 1)).collect(),
    }
}

/// The n-th (from 1) of the places that halve 0 … `last` again and again: 1/2, 1/4, 3/4, 1/8 … of it, van der Corput's sequence.
fn halved(n: usize, last: usize) -> usize {
    let reversed = n.reverse_bits() as u128;
    let place = (reversed * (last as u128)) >> usize::BITS;
    usize::try_from(place).unwrap_or(last)
}

/// A sample of the connectors and constraints of a plan, and of the states of each.
#[derive(Clone, Debug)]
pub(crate) struct Chosen {
    /// What is judged.
    pub plan: Plan,
    /// States of each.
    pub states: usize,
    /// States that there are.
    pub of_states: usize,
    /// States of each on 237 bits.
    pub wide: usize,
}

impl Chosen {
    /// What costs at most so many units; at least one connector at one state.
    pub(crate) fn new(
        settings: &Settings,
        (model, plan): (&Model, &Plan),
        states: usize,
        units: u64,
    ) -> Self {
        let count = plan.connectors.len() + plan.mpcs.len() + plan.relations.len();
        let all = if states == 0 { settings.drawn_states.max(1) } else { states };
        let wide = settings.wide_states.min((settings.wide_states_of_a_scene / count.max(1)).max(1));
        let whole = Self { plan: plan.clone(), states: all, of_states: all, wide };
        let units = units.max(1);
        if whole.cost() <= units {
            return whole;
        }
        let each = units / (count.max(1) as u64);
        let wides = WIDE * wide as u64;
        let most = if each > wides + wide as u64 { each - wides } else { each / (1 + WIDE) };
        let states = usize::try_from(most.max(FEW)).unwrap_or(all).min(all);
        let fewer = Self { states, ..whole };
        if fewer.cost() <= units {
            return fewer;
        }
        let of_one = fewer.cost() / (count.max(1) as u64);
        let wanted = usize::try_from(units / of_one.max(1)).unwrap_or(count).clamp(1, count);
        let mut places: BTreeSet<usize> = (0..wanted).map(|i| i * count / wanted).collect();
        let mut kinds = HashSet::new();
        for (place, index) in plan.connectors.iter().enumerate() {
            let Some(element) = model.connectors.get(*index) else { continue };
            let connection = Arc::as_ptr(&element.definition().connection).addr();
            if kinds.len() < wanted && kinds.insert((connection, Arc::as_ptr(&element.behavior).addr())) {
                places.insert(place);
            }
        }
        let at = |place: &usize| plan.connectors.get(*place).copied();
        let connectors = places.iter().filter_map(at).collect();
        let of = |list: &[usize], before: usize| -> Vec<usize> {
            places.iter().filter_map(|place| list.get(place.checked_sub(before)?).copied()).collect()
        };
        let before = plan.connectors.len();
        let constraints = [of(&plan.mpcs, before), of(&plan.relations, before + plan.mpcs.len())];
        Self { plan: Plan::of(model, connectors, constraints, plan.request.clone()), ..fewer }
    }

    /// Connectors and constraints.
    pub(crate) fn count(&self) -> usize {
        self.plan.connectors.len() + self.plan.mpcs.len() + self.plan.relations.len()
    }

    /// What it costs, in units.
    pub(crate) fn cost(&self) -> u64 {
        (self.count() as u64) * (self.states as u64 + WIDE * self.wide.min(self.states) as u64)
    }

    /// Which of its states this is for the connector at a place of the plan, where it is one of them. Connectors beside each other have
    /// others, which together cover the history.
    pub(crate) fn rank(&self, place: usize, index: usize) -> Option<usize> {
        let (wanted, all) = (self.states, self.of_states);
        let phase = if wanted < all { halved(place + 1, all) } else { 0 };
        let rank = (index * wanted).saturating_sub(phase).div_ceil(all.max(1));
        (rank < wanted && (rank * all + phase) / wanted == index).then_some(rank)
    }

    /// Whether the state of that rank goes to the oracles on 237 bits.
    pub(crate) fn is_wide(&self, place: usize, rank: usize) -> bool {
        spread_of(self.states, self.wide, place).contains(&rank)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pintle_kinematics::connector::Request;
    use pintle_model::evaluate::ConnectorElement;
    use pintle_scene::Scene;

    /// A row of JOINs, with one BEAM among them.
    fn row(count: usize) -> Model {
        let mut deck = "*NODE\n".to_string();
        (0..2 * count).for_each(|i| deck += &format!("{}, {i}., 0., 0.\n", i + 1));
        for (set, wanted) in [("J", false), ("B", true)] {
            deck += &format!("*ELEMENT, TYPE=CONN3D2, ELSET={set}\n");
            let of_set = (0..count).filter(|i| (*i == 5) == wanted);
            of_set.for_each(|i| deck += &format!("{}, {}, {}\n", i + 1, 2 * i + 1, 2 * i + 2));
        }
        deck += "*CONNECTOR SECTION, ELSET=J\nJOIN\n*CONNECTOR SECTION, ELSET=B\nBEAM\n";
        Model::compile(&Scene::parse("row.inp", &deck).unwrap()).unwrap()
    }

    /// A sample costs no more than it may, is even, and has every type; what is small is whole.
    #[test]
    fn samples_are_even() {
        let model = row(500);
        let plan = Plan::everything(&model, Request::nothing(0));
        let settings = Settings::default();
        let of = |states: usize, units: u64| Chosen::new(&settings, (&model, &plan), states, units);
        let is_beam = |element: &ConnectorElement| element.connector.connection().name == "BEAM";
        let beam = model.connectors.iter().position(is_beam).unwrap();
        let whole = of(2, 1_000_000);
        assert_eq!((whole.count(), whole.states), (500, 2));
        let mut tried = 0;
        for (states, units) in
            [(2, 5000), (2, 300), (40, 5000), (40, 30_000), (4000, 100_000), (1, 1), (0, 2000)]
        {
            let chosen = of(states, units);
            // Besides what is chosen evenly there is one of each of two types.
            let one = chosen.cost() / chosen.count() as u64;
            assert!(chosen.cost() <= units.max(one) + 2 * one, "{states} {units}: {}", chosen.cost());
            assert!(chosen.count() < 500 || chosen.states < states, "{states} {units}");
            assert!(chosen.plan.connectors.contains(&beam) || chosen.count() == 1, "{states} {units}");
            let gaps = chosen.plan.connectors.windows(2).map(|pair| pair[1] - pair[0]);
            assert!(
                gaps.max().unwrap_or(0) <= 500 / chosen.count().saturating_sub(2).max(1) + 2,
                "{states} {units}"
            );
            tried += 1;
        }
        assert_eq!(tried, 7);
    }

    /// Each connector has as many states as were chosen, in order; neighbours have others, which together cover the history.
    #[test]
    fn states_are_spread() {
        let model = row(8);
        let plan = Plan::everything(&model, Request::nothing(0));
        for (states, of_states) in [(1, 7), (3, 10), (7, 7), (9, 1000), (999, 1000)] {
            let chosen = Chosen { plan: plan.clone(), states, of_states, wide: 1 };
            let mut seen = BTreeSet::new();
            for place in 0..400 {
                let ranks: Vec<(usize, usize)> =
                    (0..of_states).filter_map(|index| Some((chosen.rank(place, index)?, index))).collect();
                assert!(ranks.iter().map(|(rank, _)| *rank).eq(0..states), "{states} of {of_states}");
                assert_eq!((0..states).filter(|rank| chosen.is_wide(place, *rank)).count(), 1);
                seen.extend(ranks.into_iter().map(|(_, index)| index));
            }
            assert!(seen.len() >= of_states.min(states * 400) / 2, "{states} of {of_states}: {}", seen.len());
        }
    }

    #[test]
    fn wide_states_are_spread_over_the_history() {
        assert_eq!(spread(11, 3), BTreeSet::from([0, 5, 10]));
        assert_eq!(spread(10, 4), BTreeSet::from([0, 3, 6, 9]));
        assert_eq!(spread(2, 30), BTreeSet::from([0, 1]));
        assert_eq!(spread(9, 1), BTreeSet::from([8]));
        assert_eq!(spread(1, 1), BTreeSet::from([0]));
        assert_eq!((spread(0, 3), spread(7, 0)), (BTreeSet::new(), BTreeSet::new()));
        // Every count is met, with both ends.
        for count in 2..40 {
            for wanted in 2..=count {
                let found = spread(count, wanted);
                assert_eq!(found.len(), wanted, "{count} {wanted}");
                assert!(found.contains(&0) && found.contains(&(count - 1)));
            }
        }
        // One place each: the last, the first, and what halves the gaps.
        let places: Vec<usize> = (0..6).filter_map(|n| spread_of(1000, 1, n).into_iter().next()).collect();
        assert_eq!(places, [999, 0, 499, 249, 749, 124]);
        let all: BTreeSet<usize> = (0..4000).flat_map(|n| spread_of(1000, 1, n)).collect();
        assert_eq!(all.len(), 1000);
    }
}
