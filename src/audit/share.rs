//! Which connectors of a large scene are judged, and at which of its states: an even sample of both.
//!
//! A connector state that is judged on doubles costs a unit, one on 237 bits [`WIDE`] more. Where all together cost more than is
//! allowed, each connector is judged at fewer states, down to [`FEW`]; then fewer connectors are judged, but one of every type
//! and behaviour.

use crate::engine::{halved, spread_of};
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
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, schemars::JsonSchema)]
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
        let count = plan.connectors.len() + plan.mpcs.len();
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
        let beyond = |place: &usize| plan.mpcs.get(place.checked_sub(plan.connectors.len())?).copied();
        let mpcs = places.iter().filter_map(beyond).collect();
        Self { plan: Plan::of(model, connectors, mpcs, plan.request.clone()), ..fewer }
    }

    /// Connectors and constraints.
    pub(crate) fn count(&self) -> usize {
        self.plan.connectors.len() + self.plan.mpcs.len()
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
