use crate::audit::{Against, Check, Oracle, Settings, Verdict, audit_catalogue};
use crate::catalog::TABLE;

#[test]
fn traced_derivatives_judge_the_product() {
    let settings = Settings {
        oracles: [Oracle::WideDifferences, Oracle::WideSymbolic, Oracle::Symbolic].into(),
        states: 20,
        near_singular_states: 8,
        wide_states: 3,
        atlas: false,
        ..Settings::default()
    };
    let report = audit_catalogue(&settings, &|_| {});
    let asked = |check: &&Check| matches!(check.against, Against::Oracle(_));
    let answered = |oracle: Oracle| {
        let checks = report.subjects.iter().flat_map(|subject| &subject.checks).filter(asked);
        checks.filter(|check| check.against == Against::Oracle(oracle) && check.compared > 0).count()
    };
    for oracle in [Oracle::WideSymbolic, Oracle::Symbolic] {
        assert_eq!(answered(oracle), 2 * TABLE.len());
    }
    for check in report.subjects.iter().flat_map(|subject| &subject.checks).filter(asked) {
        let twin = (check.verdict, check.worst.clone().map(|worst| worst.entry));
        assert!(check.verdict < Verdict::UnstableFormula, "{twin:?}");
    }
    assert_eq!(report.mismatches(), 0);
}
