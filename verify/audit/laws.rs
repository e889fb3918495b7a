//! The laws of the audit: they are asked of every connector, also of one without rotations, in a plane or at the ground, and each
//! of them speaks.

use crate::audit::{judged, named};
use pintle_audit::sampling::{Extent, about_initial, cases};
use pintle_audit::{
    Against, Case, Invariant, Numbers, Quantity, Report, Settings, Verdict, audit_cases, laws as invariant,
};
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::connector::Definition;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::node::{Node, Pair};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::vector::identity;

/// A connector between nodes in a plane, which `alter` makes a special one.
fn special(name: &str, alter: impl Fn(&mut Definition)) -> Definition {
    let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    let pair = Pair { reference: [0.7, -0.4, 0.0], a: node, b: node };
    let mut definition = Definition::new(named(name).clone(), pair);
    alter(&mut definition);
    definition
}

fn without_rotations(definition: &mut Definition) {
    definition.rotates = [false; 2];
}

fn planar(definition: &mut Definition) {
    definition.planar = true;
}

fn audited(definition: &Definition) -> Report {
    let draw = &mut Draw::new("laws");
    let length = norm(definition.initial.reference);
    let drawn: Vec<Case> =
        (0..6).filter_map(|i| about_initial(definition, i, length, format!("drawn {i}"), draw)).collect();
    assert!(!drawn.is_empty());
    let settings = Settings { wide_states: 4, ..Settings::default() };
    audit_cases(&settings, &[("it".into(), drawn)], &|_| ())
}

/// How many mutants a law noticed; `None` where it was not asked.
fn noticed(report: &Report, law: Invariant) -> Option<u64> {
    let checks = &report.subjects[0].checks;
    checks.iter().find(|check| check.against == Against::Law(law)).map(|check| check.score.killed)
}

#[test]
fn no_law_is_silent_where_columns_are_missing() {
    const LAWS: [Invariant; 5] = [
        Invariant::RigidModes,
        Invariant::Frame,
        Invariant::Power,
        Invariant::Equilibrium,
        Invariant::Sparsity,
    ];
    type Alter = fn(&mut Definition);
    let all: [(&str, Alter); 8] = [
        ("CARTESIAN", without_rotations),
        ("SLIDE-PLANE", without_rotations),
        ("LINK", without_rotations),
        ("AXIAL", without_rotations),
        ("CARTESIAN", planar),
        ("JOIN", planar),
        ("LINK", planar),
        ("HINGE", planar),
    ];
    for (name, alter) in all {
        let report = audited(&special(name, alter));
        assert_eq!((report.mismatches(), report.survivors()), (0, 0), "{name}");
        for law in LAWS {
            assert!(noticed(&report, law).is_some_and(|n| n > 0), "{name}: {}", law.name());
        }
        if matches!(name, "LINK" | "AXIAL") {
            assert!(noticed(&report, Invariant::NodeSwap).is_some_and(|n| n > 0), "{name}");
        }
    }
}

/// The largest violation of a law, with its name, once `spoil` has changed the numbers at a state.
fn violation(case: &Case, law: Invariant, spoil: impl Fn(&mut Numbers<f64>)) -> (f64, String) {
    let (mut numbers, bound, _) = judged(case);
    spoil(&mut numbers);
    let context = invariant::Context::new(case, &numbers, &bound).unwrap();
    let demands = context.demands(law);
    let (demand, units) = invariant::worst(&numbers, &demands).unwrap();
    (units, demand.what.to_string())
}

/// A case of a type at which everything moves.
fn moving(name: &str) -> Case {
    cases(named(name), Extent::Brief).swap_remove(0)
}

/// A number that a part of the request, a half or a restored history lacks, or has besides, breaks the law.
#[test]
fn a_missing_number_breaks_the_laws_of_twins() {
    for law in [Invariant::Restricted, Invariant::Restored, Invariant::Halves] {
        let case = moving("BEAM");
        assert!(violation(&case, law, |_| ()).0 <= 1.0, "{law:?}");
        for quantity in Quantity::ALL {
            for k in [0, 4] {
                let (units, what) = violation(&case, law, |numbers| {
                    let mut entries = numbers.entries(quantity).clone();
                    entries.0[k] = None;
                    numbers.set(quantity, entries);
                });
                assert_eq!(units, f64::INFINITY, "{law:?} {quantity:?} {k}: {what}");
            }
        }
    }
}

/// Every number of a request for one component alone is compared with that of the whole: rates, second derivatives and forces too.
#[test]
fn a_restricted_request_is_compared_whole() {
    for quantity in Quantity::ALL {
        let (units, what) = violation(&moving("TRANSLATOR"), Invariant::Restricted, |numbers| {
            let mut entries = numbers.entries(quantity).clone();
            let entry = entries.0.iter_mut().flatten().flatten().find(|x| **x != 0.0).unwrap();
            *entry *= 1.0 + 1e-15;
            numbers.set(quantity, entries);
        });
        assert!(units > 1.0, "{quantity:?}: {what}");
    }
}

/// The power of nodal forces is that of the component forces: a wrong force breaks the law, whatever the force is conjugate to: a
/// position, the moments about the axes of REVOLUTE and ALIGN, the tension of SLIPRING.
#[test]
fn the_power_identity_knows_the_forces() {
    for (name, k) in [("CARTESIAN", 1), ("REVOLUTE", 4), ("ALIGN", 4), ("SLIPRING", 0), ("FLOW-CONVERTER", 2)]
    {
        let case = moving(name);
        let (units, what) = violation(&case, Invariant::Power, |_| ());
        assert!(units <= 1.0, "{name}: {what} {units}");
        let (numbers, ..) = judged(&case);
        let forces = numbers.entries(Quantity::NodalForces);
        let k = if forces.0[k].is_some() { k } else { forces.0.iter().position(Option::is_some).unwrap() };
        let row = forces.0[k].clone().unwrap();
        let v = case.last().unwrap().state.velocity;
        let j = (0..14).max_by(|i, j| (row[*i] * v[*i]).abs().total_cmp(&(row[*j] * v[*j]).abs())).unwrap();
        assert!(row[j] * v[j] != 0.0, "{name}");
        let (units, what) = violation(&case, Invariant::Power, |numbers| {
            let mut entries = numbers.entries(Quantity::NodalForces).clone();
            entries.0[k].as_mut().unwrap()[j] *= 1.0 + 1e-9;
            numbers.set(Quantity::NodalForces, entries);
        });
        assert!(units > 1.0 && what.starts_with("power of the nodal forces"), "{name}: {what} {units}");
    }
}

/// At the initial state of FLEXION-TORSION laws are asked of what is smooth there, and the numbers pass.
#[test]
fn laws_hold_beside_a_kink() {
    let connection = ConnectionType::named("CARTESIAN", Some("FLEXION-TORSION")).unwrap();
    let definition = special("CARTESIAN", |definition| definition.connection = connection.clone().into());
    let case = about_initial(&definition, 0, 0.8, "initial".into(), &mut Draw::new("kink")).unwrap();
    let (numbers, bound, nearness) = judged(&case);
    assert_eq!(nearness, 0.0);
    let context = invariant::Context::new(&case, &numbers, &bound).unwrap();
    for law in Invariant::ALL {
        let demands = context.demands(law);
        let worst = invariant::worst(&numbers, &demands);
        assert!(worst.is_none_or(|(_, units)| units <= 1.0), "{law:?}: {}", worst.unwrap().0.what);
    }
    assert!(!context.demands(Invariant::RigidModes).is_empty());
}

/// Where numbers overflow, so that a law has no finite tolerance or sum, nothing is decided: it is never wrong.
#[test]
fn laws_that_overflow_are_undecided() {
    let far = |name: &str, reference: [f64; 3]| {
        special(name, move |definition| definition.initial.reference = reference)
    };
    let mut open = 0;
    for definition in [
        far("BEAM", [1e300, 1e300, 0.0]),
        far("CARTESIAN", [1e307, 0.0, 1e307]),
        far("SLIDE-PLANE", [1e155, 1e160, 0.0]),
        far("LINK", [1e200, 1e190, 0.0]),
    ] {
        let report = audited(&definition);
        for check in report.subjects[0].checks.iter().filter(|check| matches!(check.against, Against::Law(_)))
        {
            assert!(!check.verdict.is_mismatch(), "{:?}: {:?}", check.against, check.worst);
            if check.verdict == Verdict::Undecided {
                open += 1;
                let why: Vec<&String> = check.undecided.keys().collect();
                assert!(matches!(why.as_slice(), [one] if one.contains("overflow")), "{why:?}");
            }
        }
    }
    assert!(open > 0, "nothing overflows");
    // Of lengths that are merely large every law is decided.
    let report = audited(&far("BEAM", [1e100, 1e100, 0.0]));
    let laws = report.subjects[0].checks.iter().filter(|check| matches!(check.against, Against::Law(_)));
    for check in laws {
        assert_eq!(check.verdict, Verdict::Pass, "{:?}: {:?}", check.against, check.worst);
    }
}

/// Beside a singular set a rounding of turned axes is another state: at a symmetric one rates and accelerations vanish that do not there.
#[test]
fn turned_axes_beside_a_singular_set_are_another_state() {
    for beside in [2.2120650096521383e-11, 1e-9, 1e-13] {
        let mut case = moving("BUSHING");
        let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
        let triad = [[0.0, 1.0, 0.0], [1.0, 0.0, -beside], [-beside, 0.0, -1.0]];
        let pair = Pair {
            reference: [0.0, 1.0, 0.0],
            a: node,
            b: Node { displacement: [1.0, -1.0, 0.0], triad, flow: 0.0 },
        };
        for axis in 0..3 {
            let step = case.path.last_mut().unwrap();
            step.state.pair = pair;
            step.state.velocity = [0.0; 14];
            step.state.velocity[3 + axis] = 1.0;
            step.state.acceleration = step.state.velocity;
            let (units, what) = violation(&case, Invariant::Frame, |_| ());
            assert!(units <= 1.0, "{beside} about axis {axis}: {units} {what}");
        }
    }
}
