//! Somebody's own routine: one-forms, which are the derivative of no value; components that are too many; and what nobody has decided.

use crate::audit::at_rest;
use pintle_audit::{Candidate, Oracle, Report, Settings, Verdict};
use pintle_kinematics::connector::{Connector, Definition, Increment, NodalRow, Request, State, Tally};
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::so3;
use pintle_report::audit::AssertOk;
use std::panic::{AssertUnwindSafe, catch_unwind};

type Given = ([Option<f64>; 6], [Option<NodalRow<f64>>; 6]);

fn brief(states: usize, wide_states: usize) -> Settings {
    Settings { states, wide_states, near_singular_states: 0, atlas: false, ..Settings::default() }
}

/// The product as somebody's routine, changed.
fn checked(definition: &Definition, settings: Settings, change: impl Fn(&mut Given)) -> Report {
    let connector = Connector::<f64>::new(definition);
    Candidate::new("mine", definition).settings(settings).check(|state| {
        let branch = connector.advance(state, &Increment::none(), &connector.initial_branch());
        let asked = Request::everything(1);
        let found = connector.evaluate(state, &Increment::none(), &branch, &asked, &mut Tally::default());
        let values = std::array::from_fn(|k| found.residual[k].or(found.displacement[k]));
        let mut given = (values, found.jacobian);
        change(&mut given);
        given
    })
}

/// What `assert_ok` says where it fails.
fn complaint(report: &Report) -> String {
    let failed = catch_unwind(AssertUnwindSafe(|| report.assert_ok())).expect_err("must fail");
    failed.downcast_ref::<String>().cloned().unwrap_or_default()
}

/// The entry of the first check that is wrong.
fn wrong_entry(report: &Report) -> String {
    let wrong = report.subjects[0].checks.iter().find(|check| check.verdict == Verdict::Wrong);
    wrong.and_then(|check| check.worst.as_ref()).map_or_else(String::new, |worst| worst.entry.clone())
}

/// The row of a one-form is no derivative of what a state has: right rows pass, with a value or without, and a wrong one is found.
#[test]
fn rows_of_one_forms_are_judged_by_themselves() {
    for name in ["FLOW-CONVERTER", "RETRACTOR"] {
        let definition = Definition { flow_scale: 0.4, ..at_rest(name) };
        let connector = Connector::<f64>::new(&definition);
        let form = (0..6).find(|k| connector.differentiated(*k).is_some_and(|m| m.is_one_form())).unwrap();
        let right = checked(&definition, brief(40, 10), |(values, _)| values[form] = None);
        right.assert_ok();
        assert_eq!(right.subjects[0].judged_independently, 10, "{name}");
        for states in [1, 40] {
            let wrong = checked(&definition, brief(40, states), |(values, rows)| {
                values[form] = None;
                rows[form].as_mut().unwrap()[13] *= 1.0 + 1e-9;
            });
            assert_eq!(wrong_entry(&wrong), "∂ur3/∂Ψb", "{name}");
        }
        let missing = checked(&definition, brief(40, 10), |(values, rows)| {
            (values[form], rows[form]) = (None, None);
        });
        assert!(wrong_entry(&missing).contains("is missing"), "{name}: {}", wrong_entry(&missing));
    }
    // Of what is no one-form a value must be there.
    let lacking = checked(&at_rest("CARTESIAN"), brief(20, 5), |(values, _)| values[1] = None);
    assert!(wrong_entry(&lacking).contains("u2 is missing"), "{}", wrong_entry(&lacking));
}

/// A component that the connector has not is told, whether its value or its row is given.
#[test]
fn components_that_the_connector_has_not_are_wrong() {
    let axial = at_rest("AXIAL");
    let value = checked(&axial, brief(20, 5), |(values, _)| values[4] = Some(0.0));
    assert!(
        wrong_entry(&value).contains("ur2 is given, and AXIAL has no such component"),
        "{}",
        wrong_entry(&value)
    );
    let row = checked(&axial, brief(20, 5), |(_, rows)| rows[2] = Some([0.0; 14]));
    assert!(wrong_entry(&row).contains("is given, and AXIAL has no such component"), "{}", wrong_entry(&row));
    assert_eq!((value.mismatches(), row.mismatches()), (1, 1));
}

/// What nobody independent has judged is no pass, and the message says what to ask for.
#[test]
fn what_is_undecided_is_not_ok() {
    let axial = at_rest("AXIAL");
    let shared = Settings { oracles: [Oracle::NodalDual].into(), ..brief(20, 5) };
    let narrow = complaint(&checked(&axial, shared, |_| ()));
    for wanted in ["undecided: the derivative of mine", "wide-differences", "undecided: the formula of mine"]
    {
        assert!(narrow.contains(wanted), "{wanted}: {narrow}");
    }
    // Values are judged on 237 bits at every state, derivatives at none of them.
    let report = checked(&axial, brief(20, 0), |_| ());
    assert_eq!(report.subjects[0].judged_independently, 0);
    let unasked = complaint(&report);
    assert!(
        unasked.contains(
            "undecided: the derivative of mine: no independent oracle judged its first derivatives"
        ),
        "{unasked}"
    );
    assert!(!unasked.contains("undecided: the formula"), "{unasked}");
    // Lengths of 1e308 have no finite tolerance.
    let mut long = axial;
    long.initial.reference = long.initial.reference.map(|x| x * 1e308);
    let overflown = complaint(&checked(&long, brief(20, 5), |_| ()));
    assert!(overflown.contains("overflow"), "{overflown}");
}

/// The first wrong check, and by how much.
fn worst(report: &Report) -> Option<String> {
    let wrong = report.subjects[0].checks.iter().find(|check| check.verdict.is_mismatch())?;
    let worst = wrong.worst.as_ref()?;
    Some(format!(
        "{:?} {:?} at {:?}: {} {} for {}, {}",
        wrong.quantity, wrong.against, wrong.worst_state, worst.entry, worst.got, worst.want, worst.units
    ))
}

/// A routine that works on the rotations nearest to its triads is right, beside a lock too.
#[test]
fn nearest_rotations_are_no_mismatch() {
    let nearest = |node: Node<f64>| Node { triad: so3::matrix(so3::quaternion(&node.triad)), ..node };
    for name in ["CARDAN", "EULER", "REVOLUTE", "UNIVERSAL", "FLEXION-TORSION", "ROTATION"] {
        let definition = at_rest(name);
        let connector = Connector::<f64>::new(&definition);
        let settings = Settings { near_singular_states: 200, ..brief(200, 200) };
        let report = Candidate::new("mine", &definition).settings(settings).check(|state| {
            let Pair { a, b, reference } = state.pair;
            let state = &State { pair: Pair { a: nearest(a), b: nearest(b), reference }, ..*state };
            let branch = connector.advance(state, &Increment::none(), &connector.initial_branch());
            let asked = Request::everything(1);
            let found = connector.evaluate(state, &Increment::none(), &branch, &asked, &mut Tally::default());
            (std::array::from_fn(|k| found.residual[k].or(found.displacement[k])), found.jacobian)
        });
        let compared: usize = report.subjects[0].checks.iter().map(|check| check.compared as usize).sum();
        assert!(compared > 5_000, "{name}: {compared}");
        assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{name}: {:?}", worst(&report));
    }
}
