//! Evidence: nothing hides behind a kink, nothing passes that nobody judged or no state exercises, and every check speaks.

use crate::audit::{at_rest, judged, spoiled};
use crate::commands::cli::{pintle, stdout};
use pintle_audit::judge::components::try_mutants;
use pintle_audit::judge::conditioned::Conditioned;
use pintle_audit::mutants::diagnosis::Cause;
use pintle_audit::mutants::mutant::{Mistake, Scene, mutants};
use pintle_audit::oracles::oracle::Answer;
use pintle_audit::sampling::{Extent, Region, cases, draw_case};
use pintle_audit::{
    Against, Case, Check, Entries, Invariant, Oracle, Planted, Quantity, Report, Settings, Step, Verdict,
    audit_case, audit_cases, audit_catalogue,
};
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::draw::Draw;
use std::fs;
use std::path::PathBuf;

/// A pair of nodes with one assembled connector, and one state with displacements alone.
fn scene(name: &str, connection: &str, u1: &str) -> [String; 2] {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let [deck, states] = ["inp", "csv"].map(|ending| folder.join(format!("evidence-{name}.{ending}")));
    let text = format!(
        "*NODE\n1, 0., 0., 0.\n2, 1., 0.5, 0.25\n*ORIENTATION, NAME=O\n1., 0., 0., 0., 1., 0.\n\
         *ELEMENT, TYPE=CONN3D2, ELSET=C\n7, 1, 2\n*CONNECTOR SECTION, ELSET=C\n{connection}\nO,\n"
    );
    fs::write(&deck, text).unwrap();
    fs::write(&states, format!("state,time,node,u1,u2,u3\n1,0.5,2,{u1},0.2,0.3\n")).unwrap();
    [deck, states].map(|path| path.to_str().unwrap().to_string())
}

/// The ordinary initial state of FLEXION-TORSION is a kink of its angles. What is wrong in the positions beside it is named.
#[test]
fn a_kink_hides_nothing_beside_it() {
    let [deck, states] = scene("kink", "CARTESIAN, FLEXION-TORSION", "0.1");
    let run = |more: &[&str], code: i32| {
        stdout(&pintle(&[&["audit", &deck, "--at", &states], more].concat()).assert().code(code))
    };
    let right = run(&[], 0);
    assert!(right.contains("singular point") && right.contains("do not settle"), "{right}");
    for plant in ["wrong-sign", "wrong-entry"] {
        let page = run(&["--plant", plant], 1);
        assert!(page.contains("∂u1/∂xb1") && page.contains("wrong"), "{plant}: {page}");
    }
    // The checks of what is smooth prove themselves there too.
    assert!(run(&["--plant", "lost-answer"], 5).contains("survived:"));
}

/// At such a state every quantity of the smooth components is judged, tried with mutants, and by all laws.
#[test]
fn beside_a_kink_everything_is_asked() {
    let connection = ConnectionType::named("CARTESIAN", Some("FLEXION-TORSION")).unwrap();
    let definition =
        pintle_kinematics::connector::Definition { connection: connection.into(), ..at_rest("CARTESIAN") };
    let mut moved = definition.initial;
    moved.b.displacement = [0.1, 0.2, -0.3];
    let mut step = Step::between(&definition.initial, moved);
    step.state.velocity = std::array::from_fn(|j| if j % 7 == 6 { 0.0 } else { 0.3 + 0.1 * j as f64 });
    step.state.acceleration = std::array::from_fn(|j| if j % 7 == 6 { 0.0 } else { 0.7 - 0.2 * j as f64 });
    let case = Case { name: "kinked".into(), definition, start: None, path: vec![step], length: 1.0 };
    let checks = audit_case(&case, &Settings::default(), true, 0);
    let found = |quantity: Option<Quantity>, against: Against| -> &Check {
        let of_it = |check: &&Check| (check.quantity, check.against) == (quantity, against);
        checks.iter().find(of_it).unwrap_or_else(|| panic!("{quantity:?} {against:?}"))
    };
    for quantity in Quantity::ALL {
        let check = found(Some(quantity), Against::Oracle(Oracle::WideDifferences));
        assert!(check.score.killed > 0 && !check.verdict.is_mismatch(), "{check:?}");
    }
    // Of the angles, torsion is smooth there.
    for oracle in [Oracle::Taylor, Oracle::HyperDual] {
        let check = checks.iter().find(|check| check.against == Against::Oracle(oracle)).unwrap();
        assert!(check.compared == 4 && check.verdict == Verdict::Pass, "{check:?}");
    }
    for law in [Invariant::RigidModes, Invariant::Frame, Invariant::Power, Invariant::Equilibrium] {
        assert!(found(None, Against::Law(law)).score.killed > 0, "{law:?}");
    }
    // What is wrong is named, in every quantity that a plant can spoil.
    let settings = Settings { planted: Some(Planted::WrongSign), ..Settings::default() };
    let wrong = audit_case(&case, &settings, true, 0);
    let named = wrong.iter().filter(|check| check.verdict == Verdict::Wrong);
    assert!(named.filter(|check| check.quantity == Some(Quantity::FirstDerivatives)).count() > 3);
}

/// An oracle that answers for first derivatives alone leaves the rest undecided, and the report says what no state exercises.
#[test]
fn nothing_passes_without_evidence() {
    let [deck, states] = scene("still", "CARTESIAN, CARDAN", "0.1");
    let audit = ["audit", deck.as_str(), "--at", states.as_str()];
    for oracle in ["taylor", "wide-symbolic"] {
        let page = stdout(&pintle(&[&audit[..], &["--oracles", oracle]].concat()).assert().code(0));
        let line = page.lines().find(|line| line.starts_with("CARTESIAN + CARDAN 7")).unwrap();
        assert!(line.contains("undecided"), "{oracle}: {line}");
    }
    // Without velocities, rates are zero whatever the formula.
    let page = stdout(&pintle(&audit).assert().code(0));
    assert!(page.contains("not exercised") && page.contains("rates,"), "{page}");
    pintle(&[&audit[..], &["--strict"]].concat()).assert().code(3);
    let document = stdout(&pintle(&[&audit[..], &["--format", "json"]].concat()).assert().code(0));
    let document: serde_json::Value = serde_json::from_str(&document).unwrap();
    assert_eq!(document["subjects"][0]["not_exercised"], serde_json::json!(["rate", "acceleration"]));
    let junit = stdout(&pintle(&[&audit[..], &["--format", "junit"]].concat()).assert().code(0));
    assert!(junit.contains("not exercised"), "{junit}");
    let markdown = stdout(&pintle(&[&audit[..], &["--format", "markdown"]].concat()).assert().code(0));
    assert!(markdown.contains("not exercised"), "{markdown}");
    let page = deck.replace(".inp", ".html");
    pintle(&[&audit[..], &["--html", &page]].concat()).assert().code(0);
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("not exercised") && page.contains("rates, accelerations"), "{page}");
}

/// A law that has nothing to ask of a connector at the ground is listed.
#[test]
fn laws_that_are_not_asked_are_listed() {
    let mut definition = at_rest("CARTESIAN");
    definition.moves = [false, true];
    let draw = &mut Draw::new("ground");
    let drawn = (0..4).filter_map(|i| {
        pintle_audit::sampling::about_initial(&definition, i, 1.2, format!("drawn {i}"), draw)
    });
    let report = audit_cases(&Settings::default(), &[("it".into(), drawn.collect())], &|_| ());
    assert_eq!((report.mismatches(), report.survivors()), (0, 0));
    assert_eq!(report.subjects[0].laws_not_asked, [Invariant::RigidModes]);
    let mut text = Vec::new();
    pintle_report::audit::human(&mut text, &report, 200, false).unwrap();
    let text = String::from_utf8(text).unwrap();
    assert!(text.contains("laws not asked") && text.contains("rigid modes in the kernel"), "{text}");
    let mut page = Vec::new();
    let supplement = pintle_report::audit::Supplement::default();
    pintle_report::audit::html(&mut page, &report, &supplement).unwrap();
    assert!(String::from_utf8(page).unwrap().contains("laws not asked"));
}

/// Displacements whose squares overflow are judged, or undecided: no tolerance, no verdict.
#[test]
fn without_a_tolerance_nothing_is_wrong() {
    for u1 in ["1e150", "1e160", "1e200"] {
        let [deck, states] = scene(&format!("far-{u1}"), "CARTESIAN, CARDAN", u1);
        let page = stdout(&pintle(&["audit", &deck, "--at", &states]).assert().code(0));
        assert!(!page.contains("wrong"), "{u1}: {page}");
        pintle(&["audit", &deck, "--at", &states, "--plant", "wrong-sign"]).assert().code(1);
    }
}

fn check(report: &Report, against: Against) -> &Check {
    report.subjects[0].checks.iter().find(|check| check.against == against).unwrap()
}

/// Each check is tried on mutants: sums along directions, a routine's own values, and every law; none of them is blind.
#[test]
fn every_check_is_tried_on_mutants() {
    let settings =
        Settings { states: 30, near_singular_states: 5, wide_states: 4, atlas: false, ..Settings::default() };
    let report = audit_catalogue(&settings, &|_| ());
    assert_eq!((report.mismatches(), report.survivors()), (0, 0));
    for subject in &report.subjects {
        let of_behavior = |check: &&Check| check.quantity.is_some_and(|q| Quantity::OF_BEHAVIOR.contains(&q));
        for check in subject.checks.iter().filter(|check| !of_behavior(check)) {
            assert!(check.score.decisive() > 0, "{}: {:?} {:?}", subject.name, check.quantity, check.against);
        }
        assert_eq!(
            (&subject.not_exercised[..], &subject.laws_not_asked[..]),
            (&[][..], &[][..]),
            "{}",
            subject.name
        );
    }
    // The secant for the tangent, which is one of laws that are not proportional, among them.
    let scores = report.subjects.iter().flat_map(|subject| &subject.checks).map(|check| &check.score);
    let secants = scores.filter_map(|score| score.by_mistake.get(&Cause::SecantForTangent));
    assert!(secants.map(|fared| fared.killed).sum::<u64>() > 0);
    let mine = spoiled("REVOLUTE", |_, _| {});
    assert!(check(&mine, Against::Own).score.decisive() > 0);
    // What is smallest is told of sums along directions too.
    for oracle in [Oracle::Taylor, Oracle::HyperDual, Oracle::WideDifferences] {
        let smallest = check(&report, Against::Oracle(oracle)).score.detectable;
        assert!(smallest.is_some_and(|delta| delta <= 1e-6), "{oracle:?}: {smallest:?}");
    }
}

/// A law that notices nothing fails the self-test.
#[test]
fn a_blind_law_survives() {
    let settings =
        Settings { states: 8, near_singular_states: 0, wide_states: 2, atlas: false, ..Settings::default() };
    let mut report = audit_catalogue(&settings, &|_| ());
    assert!(report.blind_laws().is_empty());
    for subject in &mut report.subjects {
        for check in subject.checks.iter_mut().filter(|check| check.against == Against::Law(Invariant::Power))
        {
            check.score.below_resolution += check.score.killed;
            check.score.killed = 0;
        }
    }
    assert_eq!(report.blind_laws(), [Invariant::Power]);
    assert_eq!(report.survivors(), 1);
}

/// What must be noticed does not follow from what is allowed: at well-conditioned states a tolerance that hides an error of 1e-9 of a
/// significant entry fails the self-test, though every mutant beyond twice that tolerance is noticed.
#[test]
fn a_tolerance_that_hides_errors_survives() {
    let mut demanded = 0;
    for connection in TABLE {
        for case in cases(connection, Extent::Brief) {
            let (numbers, bound, nearness) = judged(&case);
            let connector = case.connector();
            let units = std::array::from_fn(|k| connector.differentiated(k).map(|measure| measure.unit()));
            let conditioned = Conditioned::new(&numbers, &case, &units, &[nearness; 6]);
            for quantity in [Quantity::FirstDerivatives, Quantity::SecondDerivatives] {
                let got = numbers.entries(quantity);
                let is_demanded = |(k, i, x): (usize, usize, f64)| conditioned.demands(quantity, k, i, x);
                let here = got.iter().filter(|entry| is_demanded(*entry)).count();
                let scale = |k: usize, i: usize| bound.scale(quantity, k, i);
                let scene = Scene { numbers: &numbers, case: &case, units, turns: [0.0; 6], scale: &scale };
                let mut made = mutants(quantity, &scene);
                made.retain(|mutant| matches!(mutant.mistake, Mistake::Scaled(_)));
                let size = |i: usize| quantity.entry_size(i, case.length);
                let sharp = Answer::of(Oracle::WideDifferences, got);
                let score = try_mutants(quantity, got, &sharp, &bound, (&size, &conditioned), &made);
                assert_eq!(score.survived, 0, "{}: {:?}", case.name, score.survivors);
                // The same oracle, twenty million times as uncertain.
                let error = Entries(std::array::from_fn(|k| {
                    got.0[k]
                        .as_ref()
                        .map(|row| (0..row.len()).map(|i| 2e7 * bound.tolerance(quantity, k, i)).collect())
                }));
                let blunt = Answer { error, ..sharp };
                let score = try_mutants(quantity, got, &blunt, &bound, (&size, &conditioned), &made);
                assert_eq!(score.survived > 0, here > 0, "{}: {here}", case.name);
                demanded += here;
            }
        }
    }
    assert!(demanded > 1000, "{demanded}");
}

/// Most entries at aligned and at misaligned states are significant ones of well-conditioned components, in every quantity.
#[test]
fn well_conditioned_states_are_common() {
    for quantity in Quantity::ALL {
        let (mut demanded, mut types) = (0, 0);
        for connection in TABLE {
            let case = draw_case(connection, Region::Misaligned, &mut Draw::new("common")).unwrap();
            let (numbers, ..) = judged(&case);
            let narrow = pintle_audit::oracles::oracle::Narrow::of(&case).unwrap();
            let connector = case.connector();
            let units = std::array::from_fn(|k| connector.differentiated(k).map(|measure| measure.unit()));
            let conditioned = Conditioned::new(&numbers, &case, &units, &narrow.nearness_of_components());
            let here = numbers
                .entries(quantity)
                .iter()
                .filter(|(k, i, x)| conditioned.demands(quantity, *k, *i, *x));
            let here = here.count();
            (demanded, types) = (demanded + here, types + usize::from(here > 0));
        }
        assert!(demanded > 20 && 2 * types > TABLE.len(), "{quantity:?}: {demanded} of {types} types");
    }
}

/// The report says beside the states how many of them an independent oracle judged; none of them is no pass.
#[test]
fn states_that_an_independent_oracle_judged_are_counted() {
    let audited = |more: &[&str], code: i32| {
        let all =
            [&["audit", "gallery:hinge_pendulum", "--connector", "101", "--format", "json"], more].concat();
        let found: serde_json::Value =
            serde_json::from_str(&stdout(&pintle(&all).assert().code(code))).unwrap();
        found["subjects"][0].clone()
    };
    let states = audited(&["--wide-states", "3"], 0);
    assert_eq!((&states["judged_independently"], &states["derivative"]), (&3.into(), &"pass".into()));
    assert!(states["cases"].as_u64().unwrap() > 3);
    for more in [&["--wide-states", "0"][..], &["--oracles", "symbolic,differences,wide-dual,nodal-dual"]] {
        let none = audited(more, 0);
        assert_eq!(
            (&none["judged_independently"], &none["derivative"]),
            (&0.into(), &"undecided".into()),
            "{more:?}"
        );
        audited(&[more, &["--strict"]].concat(), 3);
    }
    for (format, wanted) in [
        ("human", "states  independent"),
        ("markdown", "| states | independent |"),
        ("junit", "name=\"states judged independently\" value=\"2\""),
    ] {
        let all = [
            "audit",
            "gallery:hinge_pendulum",
            "--connector",
            "101",
            "--wide-states",
            "2",
            "--format",
            format,
        ];
        let text = stdout(&pintle(&all).assert().code(0));
        assert!(text.contains(wanted), "{format}: {text}");
    }
}
