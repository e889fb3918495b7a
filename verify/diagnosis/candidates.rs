//! A user's own routine, with each mistake of the catalogue planted in it: the report of `Candidate::check` says what it is.

use super::said;
use crate::audit::{at_rest, judged};
use pintle_audit::mutants::diagnosis::Cause;
use pintle_audit::mutants::mutant::{Mistake, Mutant, Scene, mutants};
use pintle_audit::sampling::about_initial;
use pintle_audit::{Candidate, Case, Given, Numbers, Quantity, Settings, Step, Verdict};
use pintle_kinematics::connector::{Connector, Definition, Increment, State};
use pintle_kinematics::draw::Draw;
use pintle_scene::Code;
use std::collections::{BTreeMap, BTreeSet};

/// What a candidate gives.
pub(crate) const GIVEN: [Quantity; 2] = [Quantity::Value, Quantity::FirstDerivatives];

/// What one state does not tell: how often an angle went round before.
const NOT_OF_A_STATE: Code = Code::DiagnosisTurnsForgotten;

/// Of values, the sign of an entry is the sign of its component, and nothing is nothing of it, which is named first.
const SAME_AS_ITS_ROW: [Code; 2] = [Code::DiagnosisSignOfEntry, Code::DiagnosisDropped];

/// The largest number that it changes anything by.
fn change(mutant: &Mutant, entries: &pintle_audit::Entries<f64>) -> f64 {
    let moved = mutant.changes.iter().map(|(k, i, x)| (x - entries.get(*k, *i).unwrap()).abs());
    moved.fold(0.0, f64::max)
}

/// The product's numbers at a state, with the mutant of a mistake in them that changes most.
pub(crate) fn mistaken(
    connector: &Connector<f64>,
    case: &Case,
    quantity: Quantity,
    code: Code,
) -> Option<Numbers<f64>> {
    let (numbers, bound, _) = judged(case);
    let units = std::array::from_fn(|k| connector.differentiated(k).map(|measure| measure.unit()));
    let scale = |k: usize, i: usize| bound.scale(quantity, k, i);
    let scene = Scene { numbers: &numbers, case, units, turns: [0.0; 6], scale: &scale };
    let entries = numbers.entries(quantity);
    let is_it = |mutant: &Mutant| {
        Cause::of(mutant.mistake).code() == code
            && !matches!(mutant.mistake, Mistake::Scaled(delta) if delta != 1e-2)
    };
    let made = mutants(quantity, &scene).into_iter().filter(is_it);
    let wrong = made.max_by(|x, y| change(x, entries).total_cmp(&change(y, entries)))?;
    if change(&wrong, entries) < 1e-6 {
        return None;
    }
    let changed = wrong.applied(entries);
    let mut numbers = numbers;
    numbers.set(quantity, changed);
    Some(numbers)
}

/// The mistakes that can be made in a quantity of a connector.
pub(crate) fn codes(definition: &Definition, quantity: Quantity) -> BTreeSet<Code> {
    let case = about_initial(definition, 1, 1.0, "drawn".into(), &mut Draw::new("codes")).unwrap();
    let connector = case.connector();
    let (numbers, bound, _) = judged(&case);
    let units = std::array::from_fn(|k| connector.differentiated(k).map(|measure| measure.unit()));
    let scale = |k: usize, i: usize| bound.scale(quantity, k, i);
    let scene = Scene { numbers: &numbers, case: &case, units, turns: [1.0; 6], scale: &scale };
    mutants(quantity, &scene).iter().map(|mutant| Cause::of(mutant.mistake).code()).collect()
}

#[test]
fn every_mistake_in_a_users_routine_is_diagnosed_as_itself() {
    let settings = Settings { states: 3, wide_states: 1, near_singular_states: 0, ..Settings::default() };
    let mut tally: BTreeMap<(Quantity, &str), (usize, usize)> = BTreeMap::new();
    for name in ["CARTESIAN", "CARDAN", "UJOINT"] {
        let definition = at_rest(name);
        let connector = Connector::<f64>::new(&definition);
        let case = |state: &State<f64>| Case {
            name: name.to_string(),
            definition: definition.clone(),
            start: None,
            path: vec![Step { state: *state, increment: Increment::none() }],
            length: 1.0,
        };
        for quantity in GIVEN {
            for code in codes(&definition, quantity) {
                let planted = std::cell::Cell::new(false);
                let report = Candidate::new("mine", &definition).settings(settings.clone()).check(|state| {
                    let case = case(state);
                    let made = mistaken(&connector, &case, quantity, code).inspect(|_| planted.set(true));
                    Given::from(made.unwrap_or_else(|| judged(&case).0))
                });
                if !planted.get() {
                    continue;
                }
                let checks = &report.subjects[0].checks;
                let told: Vec<_> = checks
                    .iter()
                    .filter(|check| check.quantity == Some(quantity) && check.verdict == Verdict::Wrong)
                    .filter_map(|check| check.diagnosis.as_ref())
                    .collect();
                let counted = tally.entry((quantity, code.as_str())).or_default();
                assert!(!told.is_empty(), "{name} {} {code}: nothing wrong", quantity.name());
                for diagnosis in told {
                    let what = format!("{name} {}, {code}:\n{}", quantity.name(), said(diagnosis));
                    let first = diagnosis.causes.first().unwrap_or_else(|| panic!("{what}"));
                    if first.code == code {
                        counted.0 += 1;
                    } else {
                        assert!(first.also.contains(&code), "{what}");
                        counted.1 += 1;
                    }
                }
            }
        }
    }
    for ((quantity, code), (first, besides)) in &tally {
        let is_known =
            *quantity == Quantity::Value && SAME_AS_ITS_ROW.iter().any(|same| same.as_str() == *code);
        assert_eq!(*first > 0, !is_known, "{} {code}: never first, {besides} times besides", quantity.name());
    }
    // Every mistake that can be made in what a routine gives was made.
    let made: BTreeSet<&str> = tally.keys().map(|(_, code)| *code).collect();
    assert!(!made.contains(NOT_OF_A_STATE.as_str()));
    assert!(made.len() >= 13, "{made:?}");
}
