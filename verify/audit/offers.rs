//! Somebody's routine that gives all seven quantities, along histories: right as it is, wrong where one of them is spoilt.

use crate::audit::at_rest;
use pintle_audit::{Candidate, Case, Given, Quantity, Question, Report, Settings, Verdict, product};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{Connector, Definition};
use std::convert::Infallible;

fn brief() -> Settings {
    Settings { states: 30, wide_states: 8, near_singular_states: 10, atlas: false, ..Settings::default() }
}

/// The product's numbers where a question ends.
fn answered(definition: &Definition, asked: &Question<'_>) -> pintle_audit::Numbers<f64> {
    let path = asked.path.iter().chain([asked.step]).copied().collect();
    let name = "asked".to_string();
    product(&Case { name, definition: definition.clone(), start: None, path, length: 1.0 }).unwrap()
}

fn checked(
    definition: &Definition,
    change: impl Fn(&Question<'_>, &mut pintle_audit::Numbers<f64>),
) -> Report {
    let candidate =
        Candidate::new("mine", definition).settings(brief()).histories(10).offers(&Quantity::ALL, [true; 6]);
    let answers = |asked: &[Question<'_>]| {
        let one = |asked: &Question<'_>| {
            let mut numbers = answered(definition, asked);
            change(asked, &mut numbers);
            Some(Given::from(numbers).only(asked.wants, [true; 6]))
        };
        Ok::<_, Infallible>(asked.iter().map(one).collect())
    };
    let Ok(report) = candidate.try_check(answers);
    report
}

/// Every type by its own numbers: no mismatch, every quantity judged.
#[test]
fn every_quantity_of_every_type_is_judged() {
    let mut compared = 0;
    for connection in TABLE.iter() {
        let definition = Definition { flow_scale: 0.4, ..at_rest(&connection.name) };
        let connector = Connector::<f64>::new(&definition);
        let report = checked(&definition, |_, _| ());
        let subject = &report.subjects[0];
        let wrong: Vec<_> = subject.checks.iter().filter(|check| check.verdict.is_mismatch()).collect();
        assert!(wrong.is_empty(), "{}: {wrong:#?}", connection.name);
        for quantity in Quantity::ALL {
            let of: u64 = subject
                .checks
                .iter()
                .filter(|check| check.quantity == Some(quantity))
                .map(|check| check.compared)
                .sum();
            let has = connector.has_force(0)
                || (1..6).any(|k| connector.has_force(k))
                || !matches!(quantity, Quantity::NodalForces | Quantity::GeometricStiffness);
            assert!(of > 0 || !has, "{} {}: nothing compared", connection.name, quantity.name());
            compared += of;
        }
    }
    println!("{compared} numbers compared");
    assert!(compared > 100_000, "{compared}");
}

/// A relative error of 1e-6 in one quantity is found in it and nowhere else.
#[test]
fn an_error_is_found_in_its_quantity() {
    for name in ["REVOLUTE", "CARTESIAN", "CARDAN", "ROTATION", "UJOINT"] {
        let definition = at_rest(name);
        for quantity in Quantity::ALL {
            let report = checked(&definition, |asked, numbers| {
                if asked.is_drawn {
                    for row in numbers.entries_mut(quantity).0.iter_mut().flatten() {
                        row.iter_mut().for_each(|x| *x *= 1.0 + 1e-6);
                    }
                }
            });
            let wrong: Vec<Option<Quantity>> = report.subjects[0]
                .checks
                .iter()
                .filter(|check| check.verdict == Verdict::Wrong)
                .map(|check| check.quantity)
                .collect();
            assert!(
                !wrong.is_empty() && wrong.iter().all(|of| *of == Some(quantity)),
                "{name} {}: {wrong:?}",
                quantity.name()
            );
        }
    }
}

/// Principal angles are wrong where they were to go on, and right where that is declared.
#[test]
fn principal_angles_are_declared() {
    let definition = at_rest("REVOLUTE");
    let answers = |asked: &[Question<'_>]| {
        let one = |asked: &Question<'_>| {
            let mut numbers = answered(&definition, asked);
            let angle = &mut numbers.entries_mut(Quantity::Value).0[3].as_mut().unwrap()[0];
            *angle -= std::f64::consts::TAU * (*angle / std::f64::consts::TAU).round();
            Some(Given::from(numbers).only(asked.wants, [true; 6]))
        };
        Ok::<_, Infallible>(asked.iter().map(one).collect())
    };
    let candidate = Candidate::new("mine", &definition).settings(brief()).histories(10);
    let Ok(report) = candidate.clone().try_check(answers);
    assert!(report.mismatches() > 0);
    let Ok(report) = candidate.histories(10).principal_angles(true).try_check(answers);
    assert_eq!(report.mismatches(), 0);
}
