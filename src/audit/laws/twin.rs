//! Laws of twins: another connector, another history or a part of the request must give the same numbers.

use crate::case::quantity::{Numbers, OneOrMany, Quantity, request_of};
use crate::case::{AtEnd, Case, Step};
use crate::laws::{Claim, Context, Demand, What};
use crate::oracles::force::{add_forces_of, product_at, product_with_forces};
use crate::oracles::oracle::nearness;
use pintle_kinematics::catalog::{ConnectionType, Loading};
use pintle_kinematics::connector::{
    Branch, Connector, Definition, Increment, NodalRow, Output, Request, State, Tally, Turns,
};
use pintle_kinematics::measure::{Exchanged, Measure};
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::vector::{scale, transposed_product};
use serde_json::Value;
use std::f64::consts::{PI, TAU};

/// The distance from a singular set within which rounding decides on which side of a lock a state is.
const ROUNDING: f64 = 1e-14;

/// From what increment on an angle's turns are not certain.
const LARGE: f64 = 0.9 * PI;

/// What a component of a connector with exchanged nodes is in components of the connector, each with its factor; nothing where the measure
/// has no such rule ([`Measure::exchanged`]), or the connector lacks a component of it.
pub(super) fn exchanged(connector: &Connector<f64>, initial: &Pair<f64>, k: usize) -> Vec<(usize, f64)> {
    let place = |measure: Measure| (0..6).find(|k| connector.differentiated(*k) == Some(measure));
    let sum: Option<Vec<(usize, f64)>> = match connector.differentiated(k).map(Measure::exchanged) {
        Some(Exchanged::Sum(parts)) => {
            parts.into_iter().flatten().map(|(measure, factor)| Some((place(measure)?, factor))).collect()
        }
        Some(Exchanged::Frozen(i)) => {
            let q = transposed_product(&initial.a.triad, &initial.b.triad);
            (0..3).map(|j| Some((place(Measure::Misalignment(j + 1))?, -q[j][i - 1]))).collect()
        }
        Some(Exchanged::None(_)) | None => None,
    };
    sum.unwrap_or_default()
}

/// The place of an entry of a quantity where the nodes are exchanged.
pub(crate) const fn exchanged_entry(quantity: Quantity, i: usize) -> usize {
    const fn column(j: usize) -> usize {
        (j + DOFS / 2) % DOFS
    }
    match quantity.entries() {
        1 => i,
        DOFS => column(i),
        _ => column(i / DOFS) * DOFS + column(i % DOFS),
    }
}

impl Context<'_> {
    /// A connector at a state, after a history, without an increment.
    pub(super) fn beside(&self, definition: Definition, state: State<f64>, branch: Branch<f64>) -> Case {
        let path = vec![Step { state, increment: Increment::none() }];
        Case { name: String::new(), definition, start: Some(branch), path, length: self.case.length }
    }

    /// The same seen from b: with the history of the case where that is known from its beginning.
    pub(crate) fn swapped(&self) -> Case {
        let swap = |pair: &Pair<f64>| Pair { reference: scale(pair.reference, -1.0), a: pair.b, b: pair.a };
        let rows = |x: &NodalRow<f64>| -> NodalRow<f64> { std::array::from_fn(|j| x[(j + DOFS / 2) % DOFS]) };
        let mut definition = self.case.definition.clone();
        definition.initial = swap(&definition.initial);
        definition.moves.reverse();
        definition.rotates.reverse();
        let state = |state: &State<f64>| State {
            pair: swap(&state.pair),
            velocity: rows(&state.velocity),
            acceleration: rows(&state.acceleration),
        };
        if self.case.start.is_none() {
            let step = |step: &Step| {
                let mut increment = step.increment;
                increment.rotation.reverse();
                increment.whole_turns.reverse();
                increment.flow.reverse();
                Step { state: state(&step.state), increment }
            };
            let path = self.case.path.iter().map(step).collect();
            return Case { definition, path, ..self.case.clone() };
        }
        // The sheets that mirror those of the history.
        let after = &self.after;
        let torsion = Turns { turns: -after.torsion.turns, principal: -after.torsion.principal };
        let rotation_vector = scale(after.rotation_vector, -1.0);
        let branch = Branch { rotation_vector, torsion, turns: self.mirrored_angles(), ..*after };
        self.beside(definition, state(&self.state), branch)
    }

    /// The angles that wind, as the exchanged connector measures them: of Q = Rz(α) Rx(β) Rz(γ) follows Qᵀ = Rz(π − γ) Rx(β) Rz(−π − α), on
    /// the same sheet of the Euler angles. Others have one sheet.
    fn mirrored_angles(&self) -> [Turns<f64>; 6] {
        let all = self.after.turns;
        let angle = |i: usize| {
            let place = (0..6).find(|k| self.connector.position_measure(*k) == Some(Measure::Euler(i)));
            place.map_or(0.0, |k| angle(&all[k]))
        };
        let of = |angle: f64| {
            let turns = (angle / TAU).round();
            Turns { turns, principal: angle - TAU * turns }
        };
        std::array::from_fn(|k| match self.connector.position_measure(k) {
            Some(Measure::Euler(1)) => of(PI - angle(3)),
            Some(Measure::Euler(3)) => of(-PI - angle(1)),
            _ => all[k],
        })
    }

    pub(super) fn node_swap(&self) -> Vec<Demand> {
        let sums: Vec<(usize, Vec<(usize, f64)>)> = self
            .components()
            .filter(|(_, measure)| !self.is_fixed_in_space(*measure))
            .map(|(k, _)| (k, exchanged(&self.connector, &self.case.definition.initial, k)))
            .filter(|(_, sum)| !sum.is_empty() && sum.iter().all(|(m, _)| self.is_smooth[*m]))
            .collect();
        let mut found = Vec::new();
        if sums.is_empty() {
            return found;
        }
        let swapped = self.swapped();
        let Some(swapped) = swapped.at_end() else { return found };
        let twin = product_at(&swapped);
        let sheets = self.mirrored(&swapped);
        for (k, sum) in sums {
            for quantity in Quantity::ALL.into_iter().filter(|quantity| self.compares(*quantity, k)) {
                if sum.iter().any(|(m, _)| !sheets(quantity, *m)) || !self.is_exchanged(quantity, &sum) {
                    continue;
                }
                for i in 0..quantity.entries() {
                    // Second derivatives are symmetric.
                    let is_upper = quantity.entries() == DOFS * DOFS && i % DOFS > i / DOFS;
                    let want = twin.entries(quantity).get(k, exchanged_entry(quantity, i));
                    let (Some(want), false) = (want, is_upper) else { continue };
                    let terms: Vec<_> = sum.iter().map(|(m, factor)| (quantity, *m, i, *factor)).collect();
                    let mut demand = self.sum(terms, want, What::of(Claim::ExchangedNodes, quantity, k, i));
                    // Vectors are resolved in a's directions before and in b's after.
                    let vectors: f64 = sum
                        .iter()
                        .map(|(m, factor)| factor.abs() * Self::around(self.bound, quantity, *m, i))
                        .sum();
                    demand.allowed = 4.0 * demand.allowed.max(vectors);
                    found.push(demand);
                }
            }
        }
        found
    }

    /// Whether the exchanged connector chose the mirrored one of two sheets, of a quantity of a component: of exact half turns either is right.
    fn mirrored(&self, swapped: &AtEnd<'_>) -> impl Fn(Quantity, usize) -> bool {
        let AtEnd { connector: twin, step, after, .. } = swapped;
        // Within rounding of a singular set one of the two may be on it.
        let margins = twin.margins(&step.state, after, [true; 6]);
        // And where an initial state is on one, each chose its sheet.
        let initial = self.connector.initial_branch();
        let start = State { pair: self.case.definition.initial, ..self.state };
        let initially = self.connector.margins(&start, &initial, [true; 6]);
        let is_apart: [bool; 6] = std::array::from_fn(|k| {
            let all = [
                nearness(margins[k], self.case.length),
                nearness(initially[k], self.case.length),
                self.nearness[k],
            ];
            all.into_iter().all(|near| near > ROUNDING)
        });
        let is_vector =
            (0..3).all(|i| (after.rotation_vector[i] + self.after.rotation_vector[i]).abs() < 1.0);
        let is_euler = after.euler_sign == self.after.euler_sign;
        let is_torsion = (angle(&after.torsion) + angle(&self.after.torsion)).abs() < 1.0;
        let measures: [Option<Measure>; 6] = std::array::from_fn(|k| self.measure(k));
        let is_counted: [bool; 6] = std::array::from_fn(|k| {
            let by = angle(&self.after.turns[k]) - angle(&self.before.turns[k]);
            by.abs() < LARGE && initial.turns[k].principal.abs() < LARGE
        });
        move |quantity, k| match measures[k] {
            _ if !is_apart[k] => false,
            Some(Measure::RotationVector(_) | Measure::RotationVectorAtB(_)) => is_vector,
            Some(Measure::Euler(_)) if !is_euler => false,
            Some(measure) if measure.counts_torsion() => is_torsion,
            Some(measure) if measure.winds() && quantity == Quantity::Value => is_counted[k],
            _ => true,
        }
    }

    /// Whether the rule of exchanged nodes holds of a quantity: of values where the history is known from its beginning, of rates where
    /// these are of the values, of forces that are conjugate to what is measured.
    fn is_exchanged(&self, quantity: Quantity, sum: &[(usize, f64)]) -> bool {
        let all = |holds: &dyn Fn(usize, Measure) -> bool| {
            sum.iter().all(|(m, _)| self.measure(*m).is_some_and(|measure| holds(*m, measure)))
        };
        match quantity {
            Quantity::Value => self.case.start.is_none(),
            Quantity::Rate | Quantity::Acceleration => all(&|_, measure| !measure.has_nodal_rates()),
            Quantity::NodalForces | Quantity::GeometricStiffness => all(&|m, measure| {
                self.connector.connection().loading(m) == Some(Loading::Conjugate)
                    && self.connector.position_measure(m) == Some(measure)
            }),
            _ => true,
        }
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
    pub(crate) fn half(&self, k: usize) -> Option<Case> {
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
            let half = self.half(range.start).and_then(|case| product_with_forces(&case));
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

    /// The numbers of the history, each by its path in what is saved; whether a value changes where it is forgotten, and stands where a history begins,
    /// and whether the law of restored histories notices that.
    pub(crate) fn forgotten(&self) -> Vec<(String, [bool; 2])> {
        let saved_as = |branch: &Branch<f64>| serde_json::to_value(branch).unwrap_or_default();
        let (saved, initial) = (saved_as(&self.before), saved_as(&self.connector.initial_branch()));
        let values = Request::new(&[Output::CU, Output::RES], [true; 6], 0);
        let forget = |path: String| {
            let other = initial.pointer(&path).filter(|other| saved.pointer(&path) != Some(other))?;
            let mut lost = saved.clone();
            lost.pointer_mut(&path)?.clone_from(other);
            let branch = serde_json::from_value::<Branch<f64>>(lost).ok()?;
            let mut tally = Tally::default();
            let again = self.connector.evaluate(&self.state, &self.increment, &branch, &values, &mut tally);
            let again = Numbers::of(&again);
            let value = |numbers: &Numbers<f64>, k: usize| {
                numbers.entries(Quantity::Value).get(k, 0).filter(|x| x.is_finite())
            };
            let changes = (0..6).any(|k| value(&again, k) != value(self.numbers, k));
            let demands = self.same(&again, &[Quantity::Value], 0..6, Claim::RestoredHistory);
            let notices = demands.iter().any(|demand| demand.units(self.numbers) > 1.0);
            Some((path, [changes, notices]))
        };
        let mut paths = Vec::new();
        fields(&saved, String::new(), &mut paths);
        paths.into_iter().filter_map(forget).collect()
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

/// The paths (JSON Pointers) to the fields of a document; numbers of one field stand together.
fn fields(document: &Value, path: String, found: &mut Vec<String>) {
    match document {
        Value::Object(parts) => {
            parts.iter().for_each(|(name, part)| fields(part, format!("{path}/{name}"), found));
        }
        Value::Array(parts) if parts.iter().all(Value::is_object) => {
            parts.iter().enumerate().for_each(|(i, part)| fields(part, format!("{path}/{i}"), found));
        }
        _ => found.push(path),
    }
}

/// A whole angle (rad).
fn angle(of: &Turns<f64>) -> f64 {
    of.principal + TAU * of.turns
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::bound::Bound;
    use crate::laws::{Invariant, worst};
    use crate::sampling::{Extent, cases};
    use pintle_kinematics::catalog::TABLE;

    /// Whatever a history remembers, there are states at which the law of restored histories notices that it was forgotten.
    #[test]
    fn what_a_history_forgets_is_noticed() {
        let mut noticed = std::collections::BTreeMap::<String, bool>::new();
        for connection in TABLE {
            for case in cases(connection, Extent::Full) {
                let numbers = crate::product(&case).unwrap();
                let state = case.last().unwrap().state;
                let bound = Bound::new(&numbers, &state, case.length, 1.0);
                let context = Context::new(&case, &numbers, &bound).unwrap();
                let demands = context.restored();
                assert!(worst(&numbers, &demands).is_none_or(|(_, units)| units == 0.0));
                for (path, [changes, is_noticed]) in context.forgotten() {
                    assert_eq!(changes, is_noticed, "{path}");
                    *noticed.entry(path).or_default() |= is_noticed;
                }
            }
        }
        // The sheet of Euler angles follows from the angles before, of which none moves far.
        let lost = noticed.iter().filter(|(_, is_noticed)| !**is_noticed);
        assert_eq!(lost.map(|(path, _)| path.as_str()).collect::<Vec<_>>(), ["/euler_sign"]);
        let connector = Connector::<f64>::new(&cases(&TABLE[0], Extent::Brief)[0].definition);
        let all = serde_json::to_value(connector.initial_branch()).unwrap();
        for field in all.as_object().unwrap().keys() {
            assert!(
                noticed.keys().any(|path| path[1..].starts_with(field)),
                "no history has another {field}"
            );
        }
    }

    /// Every type has a rule of exchanged nodes, or a measure that says why not, and the numbers meet it. Each kind of number with an error of
    /// 1e-6 in its largest entry, or with the wrong sign, does not.
    #[test]
    fn exchanged_nodes_follow_their_rules() {
        let (mut types, mut spoiled) = (0, 0);
        for connection in TABLE {
            let case = cases(connection, Extent::Brief).swap_remove(0);
            let numbers = crate::product(&case).unwrap();
            let state = case.last().unwrap().state;
            let bound = Bound::new(&numbers, &state, case.length, 1.0);
            let context = Context::new(&case, &numbers, &bound).unwrap();
            let demands = context.node_swap();
            if demands.is_empty() {
                let has_reason = |k: usize| match context.measure(k)?.exchanged() {
                    Exchanged::None(why) => Some(!why.is_empty()),
                    Exchanged::Sum(_) | Exchanged::Frozen(_) => Some(true),
                };
                assert!((0..6).all(|k| has_reason(k) != Some(false)), "{}", connection.name);
                continue;
            }
            types += 1;
            assert!(Invariant::NodeSwap.is_expected_of(&case.connector()));
            let (demand, units) = worst(&numbers, &demands).unwrap();
            assert!(units <= 1.0, "{}: {} {units}", connection.name, demand.what);
            for quantity in Quantity::ALL {
                for factor in [1.0 + 1e-6, -1.0] {
                    let told = |(k, i): &(usize, usize)| {
                        let of = |demand: &Demand| {
                            demand.terms.iter().any(|t| (t.0, t.1, t.2) == (quantity, *k, *i))
                        };
                        demands.iter().any(of)
                    };
                    let mut entries = numbers.entries(quantity).clone();
                    let all = entries.iter().map(|(k, i, x)| ((k, i), x)).filter(|(place, _)| told(place));
                    let Some(((k, i), x)) = all.max_by(|x, y| x.1.abs().total_cmp(&y.1.abs())) else {
                        continue;
                    };
                    if x == 0.0 {
                        continue;
                    }
                    entries.0[k].as_mut().unwrap()[i] *= factor;
                    let mut wrong = numbers.clone();
                    wrong.set(quantity, entries);
                    let (demand, units) = worst(&wrong, &demands).unwrap();
                    assert!(units > 1.0, "{} {quantity:?}: {}", connection.name, demand.what);
                    spoiled += 1;
                }
            }
        }
        assert!(types >= 14 && spoiled > 140, "{types} {spoiled}");
    }
}
