//! Laws of twins: another connector, another history or a part of the request must give the same numbers.

use super::{Claim, Context, Demand, What};
use crate::audit::case::{Case, Step};
use crate::audit::force::add_forces_of;
use crate::audit::quantity::{Numbers, OneOrMany, Quantity, request_of};
use crate::catalog::ConnectionType;
use crate::connector::{Branch, Connector, Definition, Increment, NodalRow, Output, Request, State, Tally};
use crate::measure::Measure;
use crate::node::{DOFS, Pair};
use crate::vector::scale;

/// The sign that exchanged nodes give a measure: a length is the same, a rotation vector the opposite. Of others there is no such law.
pub(super) const fn exchanged(measure: Measure) -> Option<f64> {
    match measure {
        Measure::Distance => Some(1.0),
        Measure::RotationVector(_) => Some(-1.0),
        _ => None,
    }
}

impl Context<'_> {
    /// A connector at a state, after a history, without an increment.
    pub(super) fn beside(&self, definition: Definition, state: State<f64>, branch: Branch<f64>) -> Case {
        let path = vec![Step { state, increment: Increment::none() }];
        Case { name: String::new(), definition, start: Some(branch), path, length: self.case.length }
    }

    /// The numbers at the end of a case, asked for everything.
    pub(super) fn numbers_of(&self, case: &Case) -> Numbers<f64> {
        let connector = Connector::new(&case.definition);
        let before = case.branch_before(&connector);
        let Step { state, increment } = case.last().copied().unwrap_or(self.step());
        asked(&connector, &state, &increment, &before, [true; 6])
    }

    /// The state judged.
    const fn step(&self) -> Step {
        Step { state: self.state, increment: self.increment }
    }

    /// The sign that exchanged nodes give the measure of a component.
    pub(in crate::audit) fn exchanged(&self, k: usize) -> Option<f64> {
        self.measure(k).and_then(exchanged)
    }

    /// The same seen from b.
    pub(in crate::audit) fn swapped(&self) -> Case {
        let swap = |pair: &Pair<f64>| Pair { reference: scale(pair.reference, -1.0), a: pair.b, b: pair.a };
        let rows = |x: &NodalRow<f64>| -> NodalRow<f64> { std::array::from_fn(|j| x[(j + DOFS / 2) % DOFS]) };
        let mut definition = self.case.definition.clone();
        definition.initial = swap(&definition.initial);
        definition.moves.reverse();
        definition.rotates.reverse();
        let state = State {
            pair: swap(&self.state.pair),
            velocity: rows(&self.state.velocity),
            acceleration: rows(&self.state.acceleration),
        };
        let mut branch = self.after;
        branch.rotation_vector = scale(branch.rotation_vector, -1.0);
        self.beside(definition, state, branch)
    }

    pub(super) fn node_swap(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        if !self.components().any(|(_, measure)| exchanged(measure).is_some()) {
            return found;
        }
        let twin = self.numbers_of(&self.swapped());
        for (k, measure) in self.components() {
            let Some(sign) = exchanged(measure) else { continue };
            let Some(row) = &twin.entries(Quantity::FirstDerivatives).0[k] else { continue };
            for j in 0..DOFS {
                let terms = OneOrMany::One([(Quantity::FirstDerivatives, k, j, 1.0)]);
                let what = What::of(Claim::ExchangedNodes, Quantity::FirstDerivatives, k, j);
                let mut demand = self.sum(terms, sign * row[(j + DOFS / 2) % DOFS], what);
                // The rotation vector's components are taken along a's directions before and b's after.
                let block = j - j % 7 % 3;
                let vector: f64 = (0..3)
                    .filter(|i| block + i < DOFS)
                    .map(|i| self.tolerance(Quantity::FirstDerivatives, k, block + i))
                    .sum();
                demand.allowed = 2.0 * demand.allowed.max(vector);
                found.push(demand);
            }
        }
        found
    }

    /// `twin` has the same numbers of `quantities` for `components`, bit for bit: none more and none fewer.
    fn same(
        &self,
        twin: &Numbers<f64>,
        quantities: &[Quantity],
        components: std::ops::Range<usize>,
        claim: Claim,
    ) -> Vec<Demand> {
        let mut found = Vec::new();
        for quantity in quantities.iter().copied() {
            for k in components.clone() {
                let of = |numbers: &Numbers<f64>| numbers.entries(quantity).0[k].as_ref().map_or(0, Vec::len);
                for i in 0..of(self.numbers).max(of(twin)) {
                    let pair = [self.numbers, twin].map(|numbers| numbers.entries(quantity).get(k, i));
                    // What is no number on either side is judged as such by others.
                    if pair.iter().all(|x| x.is_some_and(|x| !x.is_finite())) {
                        continue;
                    }
                    found.push(Demand {
                        terms: OneOrMany::One([(quantity, k, i, 1.0)]),
                        offset: 0.0,
                        // A number that the twin lacks is one that nothing equals.
                        want: pair[1].unwrap_or(f64::NAN),
                        allowed: 0.0,
                        what: What::of(claim, quantity, k, i),
                    });
                }
            }
        }
        found
    }

    /// The half of an assembled type that has a component, with the same history.
    pub(in crate::audit) fn half(&self, k: usize) -> Option<Case> {
        let [Some(translational), Some(rotational)] = self.case.definition.connection.halves else {
            return None;
        };
        let half = if k < 3 { translational } else { rotational };
        let mut definition = self.case.definition.clone();
        definition.connection = ConnectionType::basic(half).into();
        Some(Case { definition, ..self.case.clone() })
    }

    pub(super) fn halves(&self) -> Vec<Demand> {
        let of = |range: std::ops::Range<usize>| {
            let half = self.half(range.start).map(|case| self.numbers_of(&case));
            half.map_or_else(Vec::new, |twin| self.same(&twin, &Quantity::ALL, range, Claim::Half))
        };
        [0..3, 3..6].into_iter().flat_map(of).collect()
    }

    pub(super) fn restored(&self) -> Vec<Demand> {
        let saved = serde_json::to_string(&self.before).ok();
        let restored: Option<Branch<f64>> = saved.and_then(|text| serde_json::from_str(&text).ok());
        let branch = restored.unwrap_or_else(|| self.connector.initial_branch());
        let again = asked(&self.connector, &self.state, &self.increment, &branch, [true; 6]);
        self.same(&again, &Quantity::ALL, 0..6, Claim::RestoredHistory)
    }

    /// One component asked for alone, with everything; and all components without second derivatives, rates and forces.
    pub(super) fn restricted(&self) -> Vec<Demand> {
        let mut found = Vec::new();
        for k in (0..6).filter(|k| self.measure(*k).is_some()) {
            let mut only = [false; 6];
            only[k] = true;
            let part = asked(&self.connector, &self.state, &self.increment, &self.before, only);
            found.extend(self.same(&part, &Quantity::ALL, k..k + 1, Claim::Alone));
        }
        let rows = Request::new(&[Output::CU, Output::RES], [true; 6], 1);
        let mut tally = Tally::default();
        let part = self.connector.evaluate(&self.state, &self.increment, &self.before, &rows, &mut tally);
        let both = [Quantity::Value, Quantity::FirstDerivatives];
        found.extend(self.same(&Numbers::of(&part), &both, 0..6, Claim::WithoutRates));
        found
    }
}

/// The numbers of some components of a connector at a state, with forces.
fn asked(
    connector: &Connector<f64>,
    state: &State<f64>,
    increment: &Increment<f64>,
    branch: &Branch<f64>,
    components: [bool; 6],
) -> Numbers<f64> {
    let request = request_of(components);
    let evaluation = connector.evaluate(state, increment, branch, &request, &mut Tally::default());
    let mut numbers = Numbers::of(&evaluation);
    add_forces_of(&mut numbers, connector, state, &evaluation.branch, components);
    numbers
}
