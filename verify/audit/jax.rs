//! JAX as an oracle of the audit: formulas of another language, at states of its own.

use crate::commands::cli::{pintle, stdout};
use pintle_audit::{Against, Check, Oracle, Planted, Quantity, Report, Settings, Verdict, audit_catalogue};
use pintle_kinematics::catalog::TABLE;
use serde_json::Value;

fn settings() -> Settings {
    let oracles = [Oracle::Jax].into();
    Settings {
        oracles,
        states: 1,
        near_singular_states: 0,
        wide_states: 1,
        atlas: false,
        ..Settings::default()
    }
}

fn by_jax(report: &Report) -> impl Iterator<Item = (&str, &Check)> {
    report.subjects.iter().flat_map(|subject| {
        let of_it = subject.checks.iter().filter(|check| check.against == Against::Oracle(Oracle::Jax));
        of_it.map(|check| (subject.name.as_str(), check))
    })
}

/// Alone it decides on derivatives and formulas of every type, in every quantity, and every mutant that counts is noticed.
#[test]
fn jax_alone_decides() {
    let report = audit_catalogue(&settings(), &|_| ());
    assert_eq!((report.mismatches(), report.survivors()), (0, 0));
    for subject in &report.subjects {
        assert_eq!(subject.without_witness, [], "{}", subject.name);
        assert_eq!(subject.not_exercised, [], "{}", subject.name);
        assert_eq!([subject.derivative, subject.formula], [Verdict::Pass; 2], "{}", subject.name);
    }
    let states: u64 = by_jax(&report)
        .filter(|(_, check)| check.quantity == Some(Quantity::FirstDerivatives))
        .map(|(_, check)| check.states.values().sum::<u64>())
        .sum();
    // All that the tests compare with JAX.
    let golden: Value =
        serde_json::from_str(include_str!("../../src/audit/oracles/golden/jax.json")).unwrap();
    assert_eq!(states, golden["cases"].as_array().unwrap().len() as u64);
    // Predefined friction of every type that has a sum of terms.
    let golden: Value =
        serde_json::from_str(include_str!("../../src/audit/oracles/golden/friction.json")).unwrap();
    let count = |what: &str| golden[what].as_array().unwrap().len() as u64;
    for (quantity, wanted) in [
        (Quantity::FrictionCriterion, count("criteria")),
        (Quantity::FrictionGradient, count("criteria")),
        (Quantity::FrictionHessian, count("criteria")),
        (Quantity::FrictionForce, count("updates")),
        (Quantity::FrictionTangent, count("updates")),
    ] {
        let of_it: Vec<&Check> = by_jax(&report)
            .filter(|(_, check)| check.quantity == Some(quantity))
            .map(|(_, check)| check)
            .collect();
        let states: u64 = of_it.iter().map(|check| check.states.values().sum::<u64>()).sum();
        assert_eq!(states, wanted, "{quantity:?}");
        assert!(of_it.iter().all(|check| check.score.killed > 10), "{quantity:?}");
    }
    let shares = Oracle::Jax.shares();
    assert!(!shares.kinematics && !shares.elementary && !shares.mechanism && Oracle::Jax.is_independent());
    for quantity in Quantity::ALL {
        let of_it = by_jax(&report).filter(|(_, check)| check.quantity == Some(quantity));
        let killed: u64 = of_it.map(|(_, check)| check.score.killed).sum();
        assert!(killed > 100, "{quantity:?}: {killed}");
    }
}

/// A wrong derivative is noticed by it alone, in every type.
#[test]
fn jax_finds_what_is_planted() {
    for planted in [Planted::WrongEntry, Planted::WrongSign] {
        let report = audit_catalogue(&Settings { planted: Some(planted), ..settings() }, &|_| ());
        assert_eq!(report.mismatches(), TABLE.len(), "{planted:?}");
    }
}

/// It is picked, shown with what it shares, and says of scenes that it compares nothing there.
#[test]
fn jax_is_picked_by_name() {
    // Laws alone compare numbers there.
    let page = stdout(
        &pintle(&["audit", "gallery:hinge_pendulum", "--oracles", "jax", "--wide-states", "1"])
            .assert()
            .code(0),
    );
    assert!(page.contains("none of the oracles asked compares them"), "{page}");
    let help = stdout(&pintle(&["audit", "--help"]).assert().code(0));
    for oracle in Oracle::ALL {
        assert!(help.contains(oracle.name()), "{}", oracle.name());
    }
}
