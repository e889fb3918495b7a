//! What holds without any reference: laws that relate the numbers of one connector to each other, or to its own numbers at a
//! state that is the same thing seen from elsewhere.
//!
//! Every law here is a list of [`Demand`]s, each linear in the numbers judged: Σ c·x = want. So the same list judges the
//! numbers and every mutant of them.

pub(crate) mod checks;
pub mod demanded;
mod power;
mod rigid;
mod turns;
mod twin;
mod type_laws;

pub use demanded::{Claim, Demanded, Invariant, What};
pub(super) use power::along_rows;
pub(super) use rigid::{about_third, along_plane, axis, turned_terms, turning};
pub(super) use twin::exchanged_entry;
pub use type_laws::of_type;

use crate::case::quantity::{Numbers, OneOrMany, Quantity};
use crate::case::{AtEnd, Case};
use crate::judge::bound::Bound;
use crate::judge::conditioned::NOTICED;
use crate::judge::judged::{SIGNIFICANT, Trials, moved_by};
use crate::judge::verdict::{Finding, Judgement, Score, Verdict};
use crate::mutants::mutant::{Mistake, Mutant};
use crate::oracles::oracle::nearness;
use pintle_kinematics::connector::{Branch, Connector, Increment, State};
use pintle_kinematics::measure::Measure;
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::U;
use pintle_kinematics::vector;
use std::collections::{BTreeMap, BTreeSet};

/// 2⁻¹⁰⁷⁴, the least distance of two doubles.
const LEAST: f64 = f64::from_bits(1);

impl Invariant {
    /// Whether it speaks of the states of such a connector: of exchanged nodes where a length or a rotation vector is measured, of
    /// halves where a type is assembled of two. The laws of types and of friction are asked elsewhere.
    pub(super) fn is_expected_of(self, connector: &Connector<f64>) -> bool {
        let mut measures = (0..6).filter_map(|k| connector.differentiated(k));
        match self {
            Self::RigidModes | Self::Frame | Self::Sparsity | Self::Restored | Self::Restricted => {
                measures.next().is_some()
            }
            Self::Power => measures.any(|measure| !measure.has_nodal_rates()),
            Self::Symmetry => measures.any(|measure| !measure.is_one_form()),
            Self::Equilibrium => (0..6).any(|k| connector.has_force(k)),
            Self::NodeSwap => {
                // Which components there are does not depend on the initial state.
                let node = Node { displacement: [0.0; 3], triad: vector::identity(), flow: 0.0 };
                let any = Pair { reference: [0.0; 3], a: node, b: node };
                (0..6).any(|k| !twin::exchanged(connector, &any, k).is_empty())
            }
            Self::Halves => connector.connection().halves.iter().all(Option::is_some),
            Self::Start | Self::Turns | Self::FreeAxis | Self::Carried => false,
        }
    }
}

/// Numbers that laws relate: of a connector by component, of a constraint by equation.
pub trait Related {
    /// The numbers of a kind in a row (0-based); none where there is no such row.
    fn row(&self, quantity: Quantity, row: usize) -> &[f64];

    /// One of them.
    fn number(&self, quantity: Quantity, row: usize, place: usize) -> Option<f64> {
        self.row(quantity, row).get(place).copied()
    }
}

impl Related for Numbers<f64> {
    fn row(&self, quantity: Quantity, row: usize) -> &[f64] {
        self.entries(quantity).0.get(row).and_then(Option::as_deref).unwrap_or_default()
    }
}

/// A number by its kind, component or equation (0-based) and place, and what it is multiplied by.
pub type Term = (Quantity, usize, usize, f64);

/// Σ c·x = want, for numbers x of one evaluation.
#[derive(Clone, Debug)]
pub struct Demand {
    /// The terms c·x.
    pub terms: OneOrMany<Term>,
    /// A number that is judged besides and is not among those of the evaluation.
    pub offset: f64,
    /// What the sum must be.
    pub want: f64,
    /// How far it may be from that.
    pub allowed: f64,
    /// What is demanded.
    pub what: What,
}

impl Demand {
    /// A sum of entries that must be `want`, allowed what its terms are allowed and a rounding each; below the range of doubles, too, where
    /// a number is one of two that are [`LEAST`] apart.
    pub(super) fn of_sum(
        terms: OneOrMany<Term>,
        want: f64,
        what: What,
        numbers: &impl Related,
        tolerance: impl Fn(Quantity, usize, usize) -> f64,
    ) -> Self {
        let allowed = terms
            .iter()
            .map(|(q, k, i, c)| {
                let x = numbers.number(*q, *k, *i).unwrap_or(0.0);
                c.abs() * (tolerance(*q, *k, *i) + 4.0 * U * x.abs() + LEAST)
            })
            .sum();
        Self { terms, offset: 0.0, want, allowed, what }
    }

    /// The same of what is told in a sentence; where there is no tolerance, as without a truth, anything is allowed.
    pub(super) fn said(
        terms: Vec<Term>,
        want: f64,
        what: String,
        (numbers, tolerance): (&impl Related, &impl Related),
    ) -> Self {
        let allowed = |q: Quantity, k: usize, i: usize| tolerance.number(q, k, i).unwrap_or(f64::INFINITY);
        Self::of_sum(terms.into(), want, What::Said(what), numbers, allowed)
    }

    /// The sum that one of some demands is of, by the words in which it is told.
    pub(super) fn sum_of(all: Vec<Self>, what: &str, numbers: &impl Related) -> Option<f64> {
        let demand = all.into_iter().find(|demand| demand.what.to_string() == what)?;
        Some(demand.sum(|quantity, row, place| numbers.number(quantity, row, place)))
    }

    /// The sum, with numbers by quantity, component and entry.
    pub fn sum(&self, number: impl Fn(Quantity, usize, usize) -> Option<f64>) -> f64 {
        self.terms.iter().fold(self.offset, |sum, (quantity, k, i, c)| {
            sum + c * number(*quantity, *k, *i).unwrap_or(f64::NAN)
        })
    }

    /// Whether numbers can be told to meet it or not: not where they overflow, so that the sum, or what is allowed, is not finite. A number
    /// that is not there meets nothing, and what must be equal bit for bit needs no tolerance.
    pub(super) fn is_decidable(&self, numbers: &impl Related) -> bool {
        let number = |quantity: Quantity, k: usize, i: usize| numbers.number(quantity, k, i);
        let is_there = self.terms.iter().all(|(quantity, k, i, _)| number(*quantity, *k, *i).is_some());
        self.allowed.is_finite()
            && (self.want.is_finite() || self.allowed == 0.0)
            && (!is_there || self.sum(number).is_finite())
    }

    /// How far a sum is from what it must be, in units of what is allowed.
    fn units_of(&self, sum: f64) -> f64 {
        let error = (sum - self.want).abs();
        if error == 0.0 {
            return 0.0;
        }
        let units = error / self.allowed;
        if units.is_nan() { f64::INFINITY } else { units }
    }

    /// What is told of it: the sum that there is, so far from it in units of what is allowed.
    pub(super) fn finding(&self, units: f64, got: f64) -> Finding {
        let demanded = self.what.demanded();
        Finding { demanded, ..Finding::new(self.what.to_string(), [got, self.want], self.allowed, units) }
    }

    /// The verdict on numbers.
    pub(super) fn verdict(&self, numbers: &impl Related) -> Verdict {
        if !self.is_decidable(numbers) {
            Verdict::Undecided
        } else if self.units(numbers) <= 1.0 {
            Verdict::Pass
        } else {
            Verdict::Wrong
        }
    }

    /// How far numbers are from it, in units of what is allowed.
    pub fn units(&self, numbers: &impl Related) -> f64 {
        self.units_of(self.sum(|quantity, k, i| numbers.number(quantity, k, i)))
    }
}

/// A state with what laws need to know of it.
pub struct Context<'a> {
    case: &'a Case,
    connector: Connector<f64>,
    before: Branch<f64>,
    after: Branch<f64>,
    numbers: &'a Numbers<f64>,
    bound: &'a Bound,
    state: State<f64>,
    increment: Increment<f64>,
    /// min(1, distance of each component to its singular sets).
    nearness: [f64; 6],
    /// The components that are not on a singular set: those of which derivatives exist.
    is_smooth: [bool; 6],
    /// Whether second derivatives, of which there are many, are left to other states.
    is_brief: bool,
}

impl<'a> Context<'a> {
    /// The end of a case; `None` for an empty path.
    pub fn new(case: &'a Case, numbers: &'a Numbers<f64>, bound: &'a Bound) -> Option<Self> {
        Some(Self::at(case.at_end()?, numbers, bound))
    }

    /// The same where the end is at hand.
    pub fn at(end: AtEnd<'a>, numbers: &'a Numbers<f64>, bound: &'a Bound) -> Self {
        let AtEnd { case, connector, step, before, after } = end;
        let margins = connector.margins(&step.state, &after, [true; 6]);
        let nearness = margins.map(|margin| nearness(margin, case.length));
        let is_smooth = nearness.map(|near| near > 0.0);
        Self {
            case,
            nearness,
            is_smooth,
            connector,
            before,
            after,
            numbers,
            bound,
            state: step.state,
            increment: step.increment,
            is_brief: false,
        }
    }

    /// The same without the laws of matrices, for one of many states.
    #[must_use]
    pub const fn brief(mut self) -> Self {
        self.is_brief = true;
        self
    }

    /// Whether laws of a kind of number are asked here.
    const fn asks(&self, quantity: Quantity) -> bool {
        !self.is_brief || quantity.entries() <= DOFS
    }

    /// Whether numbers of a component are compared with those of another state. Matrices, and accelerations, which second
    /// derivatives are in, are so only away from singular sets. The states are rounded apart, and no tolerance knows the third
    /// derivatives by which they differ there.
    fn compares(&self, quantity: Quantity, k: usize) -> bool {
        /// In radians or lengths.
        const AWAY: f64 = 1e-3;
        let is_of_second = quantity.entries() > DOFS || matches!(quantity, Quantity::Acceleration);
        self.asks(quantity) && (!is_of_second || self.nearness[k] > AWAY)
    }

    fn measure(&self, k: usize) -> Option<Measure> {
        self.connector.differentiated(k)
    }

    fn components(&self) -> impl Iterator<Item = (usize, Measure)> + '_ {
        (0..6).filter(|k| self.is_smooth[*k]).filter_map(|k| Some((k, self.measure(k)?)))
    }

    fn tolerance(&self, quantity: Quantity, k: usize, i: usize) -> f64 {
        // Without a truth there is no tolerance: not none at all.
        self.bound.known(quantity, k, i).unwrap_or(f64::INFINITY)
    }

    /// What a bound allows of the vector, or of the block of vectors, to which an entry belongs: all its components together.
    fn around(bound: &Bound, quantity: Quantity, k: usize, i: usize) -> f64 {
        let tolerance = |i: usize| bound.known(quantity, k, i).unwrap_or(f64::INFINITY);
        let block = |j: usize| if j % 7 == 6 { j..j + 1 } else { j - j % 7 % 3..j - j % 7 % 3 + 3 };
        let all = |places: &mut dyn Iterator<Item = usize>| -> f64 { places.map(tolerance).sum() };
        match quantity.entries() {
            1 => tolerance(i),
            DOFS => all(&mut block(i)),
            _ => all(&mut block(i / DOFS).flat_map(|j| block(i % DOFS).map(move |l| j * DOFS + l))),
        }
    }

    /// A sum of entries that must be `want`.
    fn sum(
        &self,
        terms: impl Into<OneOrMany<(Quantity, usize, usize, f64)>>,
        want: f64,
        what: What,
    ) -> Demand {
        Demand::of_sum(terms.into(), want, what, self.numbers, |q, k, i| self.tolerance(q, k, i))
    }

    /// What a law demands of the numbers; nothing where it has nothing to say of this connector.
    pub fn demands(&self, invariant: Invariant) -> Vec<Demand> {
        match invariant {
            Invariant::RigidModes => self.rigid_modes(),
            Invariant::Frame => self.frame(),
            Invariant::Equilibrium => self.equilibrium(),
            Invariant::Power => self.power(),
            Invariant::Symmetry => self.symmetry(),
            Invariant::Sparsity => self.sparsity(),
            Invariant::NodeSwap => self.node_swap(),
            Invariant::Halves => self.halves(),
            Invariant::Restored => self.restored(),
            Invariant::Restricted => self.restricted(),
            Invariant::Start | Invariant::Turns | Invariant::FreeAxis | Invariant::Carried => Vec::new(),
        }
    }

    /// Whether a measure changes with a nodal degree of freedom, as its declaration says.
    fn depends(&self, measure: Measure, j: usize) -> bool {
        let on = measure.dependence();
        match j % 7 {
            0..=2 => on.translation,
            3..=5 => on.rotation || (j < 7 && on.translation && measure.turns_with_a()),
            _ => on.flow && self.connector.connection().flow[j / 7],
        }
    }

    fn symmetry(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        for (k, _) in self.components().filter(|(_, measure)| !measure.is_one_form()) {
            for j in 0..DOFS {
                for l in 0..j {
                    let second = Quantity::SecondDerivatives;
                    let terms = vec![(second, k, j * DOFS + l, 1.0), (second, k, l * DOFS + j, -1.0)];
                    let what = What::of(Claim::Symmetry, second, k, j * DOFS + l);
                    found.push(self.sum(terms, 0.0, what));
                }
            }
        }
        found
    }

    fn sparsity(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        let mut zero = |quantity: Quantity, k: usize, i: usize| {
            if self.numbers.entries(quantity).get(k, i).is_some() {
                found.push(Demand {
                    terms: OneOrMany::One([(quantity, k, i, 1.0)]),
                    offset: 0.0,
                    want: 0.0,
                    allowed: 0.0,
                    what: What::of(Claim::DeclaredZero, quantity, k, i),
                });
            }
        };
        let (active, reach) = (self.connector.active(), self.connector.reach());
        for (k, measure) in self.components() {
            for (j, is_active) in active.iter().enumerate() {
                if !self.depends(measure, j) || !is_active {
                    zero(Quantity::FirstDerivatives, k, j);
                }
                for l in (0..=j).filter(|_| self.asks(Quantity::SecondDerivatives)) {
                    let both = |holds: &dyn Fn(usize) -> bool| holds(j) && holds(l);
                    let is_straight = measure.is_straight() && both(&|j| !matches!(j % 7, 3..=5));
                    if is_straight || !both(&|j| self.depends(measure, j)) {
                        for i in [j * DOFS + l, l * DOFS + j].into_iter().take(1 + usize::from(l < j)) {
                            zero(Quantity::SecondDerivatives, k, i);
                        }
                    }
                }
                if !reach[j] {
                    zero(Quantity::NodalForces, k, j);
                }
                for l in (0..DOFS).filter(|_| self.asks(Quantity::GeometricStiffness)) {
                    if !reach[j] || !reach[l] {
                        zero(Quantity::GeometricStiffness, k, j * DOFS + l);
                    }
                }
            }
        }
        found
    }
}

/// Judges a list of demands: the one that decides the verdict, and how far from it numbers are, in units of what is allowed.
pub fn worst<'a>(numbers: &impl Related, demands: &'a [Demand]) -> Option<(&'a Demand, f64)> {
    let judged = demands.iter().map(|demand| (demand, demand.units(numbers)));
    let severity = |demand: &Demand| demand.verdict(numbers);
    judged.max_by(|x, y| severity(x.0).cmp(&severity(y.0)).then(x.1.total_cmp(&y.1)))
}

/// Whether a number, by its kind, row and place, is well-conditioned.
pub type IsConditioned<'a> = dyn Fn(Quantity, usize, usize, f64) -> bool + 'a;

/// Of the mutants that touch a number of which a law speaks, one in so many is tried: of matrices, of rows, of single numbers. The steps are
/// prime, so that every rung of the ladder is among those tried.
const fn tried(quantity: Quantity) -> usize {
    match quantity.entries() {
        1 => 1,
        DOFS => 7,
        _ => 37,
    }
}

/// A law asked of the numbers at one state, by the demands on it that can be decided.
pub(super) struct Asked {
    /// What it demands.
    pub(super) demands: Vec<Demand>,
    /// The verdict, and the demand that decides it.
    pub(super) judgement: Judgement,
}

impl Asked {
    /// Judges numbers by all demands of a law.
    pub(super) fn of(numbers: &impl Related, all: Vec<Demand>) -> Self {
        let verdict = all.iter().map(|one| one.verdict(numbers)).max().unwrap_or(Verdict::Pass);
        let demands: Vec<_> = all.into_iter().filter(|one| one.is_decidable(numbers)).collect();
        let worst = worst(numbers, &demands).map(|(demand, units)| {
            let got = demand.sum(|quantity, k, i| numbers.number(quantity, k, i));
            demand.finding(units, got)
        });
        let compared = demands.len();
        Self { demands, judgement: Judgement { verdict, worst, compared } }
    }

    /// The kinds of numbers of which it speaks.
    pub(super) fn spans(&self) -> BTreeSet<Quantity> {
        self.demands.iter().flat_map(|demand| demand.terms.iter().map(|term| term.0)).collect()
    }
}

/// Which mutants of a quantity a law notices, of those that touch a number of which it speaks. One that changes every sum by less
/// than twice what is allowed is below its resolution. The exception is a relative error of a thousand times [`NOTICED`] in a
/// number that carries a sum of which every other that does is well-conditioned too. That must be noticed, whatever is allowed.
/// `size` is the unit of the degrees of freedom of an entry, and `is_conditioned` tells which numbers are well-conditioned.
pub fn try_mutants(
    quantity: Quantity,
    numbers: &impl Related,
    demands: &[Demand],
    mutants: &[Mutant],
    (size, is_conditioned): (&dyn Fn(Quantity, usize) -> f64, &IsConditioned<'_>),
) -> Score {
    let right = |q: Quantity, k: usize, i: usize| numbers.number(q, k, i);
    let speaks = |demand: &&Demand| demand.terms.iter().any(|(q, ..)| *q == quantity);
    let demands: Vec<&Demand> = demands.iter().filter(speaks).collect();
    let spoken_of = || demands.iter().flat_map(|demand| demand.terms.iter()).filter(|(q, ..)| *q == quantity);
    let width = spoken_of().map(|(_, _, i, _)| i + 1).max().unwrap_or(0);
    let height = spoken_of().map(|(_, k, ..)| k + 1).max().unwrap_or(0);
    // What is not spoken of has a place beyond the last.
    let place = |k: usize, i: usize| if i < width { k * width + i } else { height * width };
    // The demands in which each entry occurs, with its coefficient.
    let mut touched: Vec<Vec<(usize, f64)>> = vec![Vec::new(); height * width];
    for (n, demand) in demands.iter().enumerate() {
        for (_, k, i, c) in demand.terms.iter().filter(|(q, ..)| *q == quantity) {
            if let Some(of_entry) = touched.get_mut(place(*k, *i)) {
                of_entry.push((n, *c));
            }
        }
    }
    let in_demands =
        |k: usize, i: usize| touched.get(place(k, i)).map_or(&[][..], |of_entry| of_entry.as_slice());
    let sums: Vec<f64> = demands.iter().map(|demand| demand.sum(right)).collect();
    // What the largest entry of a row would make of each sum, in the place of any of its terms.
    let mut rows: BTreeMap<(Quantity, usize), f64> = BTreeMap::new();
    let mut largest: Vec<f64> = Vec::with_capacity(demands.len());
    for demand in &demands {
        let mut most = 0.0_f64;
        for (q, k, i, c) in demand.terms.iter() {
            let row = *rows.entry((*q, *k)).or_insert_with(|| {
                let sized = numbers.row(*q, *k).iter().enumerate().map(|(i, x)| x.abs() * size(*q, i));
                sized.fold(0.0_f64, f64::max)
            });
            most = most.max(c.abs() * row / size(*q, *i));
        }
        largest.push(most);
    }
    let largest = largest.as_slice();
    // Whether the terms that carry a sum are all of well-conditioned components.
    let is_plain = |n: usize| {
        let (Some(demand), Some(largest)) = (demands.get(n), largest.get(n)) else { return false };
        demand.terms.iter().all(|(q, k, i, c)| {
            let x = right(*q, *k, *i).unwrap_or(0.0);
            (c * x).abs() < SIGNIFICANT * largest || is_conditioned(*q, *k, *i, x)
        })
    };
    let is_touched = |mutant: &&Mutant| mutant.changes.iter().any(|(k, i, _)| !in_demands(*k, *i).is_empty());
    let mut moved = vec![0.0; demands.len()];
    let mut asked: Vec<usize> = Vec::new();
    let mut trials = Trials::default();
    for mutant in mutants.iter().filter(is_touched).step_by(tried(quantity)) {
        asked.clear();
        for (k, i, x) in mutant.changes.iter() {
            let by = x - right(quantity, *k, *i).unwrap_or(f64::NAN);
            for (n, c) in in_demands(*k, *i) {
                if let Some(moved) = moved.get_mut(*n) {
                    *moved += c * by;
                    asked.push(*n);
                }
            }
        }
        asked.sort_unstable();
        asked.dedup();
        let of = |n: &usize| Some((*demands.get(*n)?, *sums.get(*n)?, *moved.get(*n)?));
        let noticed =
            asked.iter().filter_map(of).any(|(demand, sum, moved)| demand.units_of(sum + moved) > 1.0);
        // The sums that a single number carries.
        let carried = || {
            let (k, i, _) = mutant.changes.first().copied().unwrap_or_default();
            let x = right(quantity, k, i).unwrap_or(0.0);
            in_demands(k, i).iter().filter(move |(n, c)| {
                let largest = largest.get(*n).copied().unwrap_or(0.0);
                largest > 0.0 && (c * x).abs() >= SIGNIFICANT * largest
            })
        };
        let (mut must, mut significant) = (false, false);
        if let Mistake::Scaled(delta) = mutant.mistake {
            let is_carried = carried().next().is_some();
            significant = is_carried;
            if !noticed && is_carried {
                // Of a term below the normal doubles a relative error is less than its last digit.
                let x = mutant.changes.first().and_then(|(k, i, _)| right(quantity, *k, *i)).unwrap_or(0.0);
                let must_be = |(n, c): &(usize, f64)| (c * x).abs() >= f64::MIN_POSITIVE && is_plain(*n);
                must = delta >= NOTICED / SIGNIFICANT && carried().any(must_be);
            }
        }
        let change = || {
            let of_sum = |(demand, _, moved): (&Demand, f64, f64)| moved_by(moved.abs(), demand.allowed);
            let most = asked.iter().filter_map(of).map(of_sum).fold(0.0, f64::max);
            if must { f64::INFINITY } else { most }
        };
        let what = || {
            asked
                .first()
                .and_then(|n| demands.get(*n))
                .map_or_else(String::new, |demand| demand.what.to_string())
        };
        trials.add(mutant.mistake, noticed, (|| significant, || false), change, what);
        for n in &asked {
            if let Some(moved) = moved.get_mut(*n) {
                *moved = 0.0;
            }
        }
    }
    trials.score()
}
