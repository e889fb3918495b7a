//! Somebody's routine that gives all seven quantities, along histories: right as it is, wrong where one of them is spoilt.

use crate::audit::at_rest;
use pintle_audit::case::{exact_state, moved};
use pintle_audit::{Candidate, Case, Given, Quantity, Question, Report, Settings, Tangent, Verdict, product};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
use pintle_kinematics::node::DOFS;
use pintle_kinematics::scalar::Wide;
use std::collections::BTreeSet;
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
    checked_of(definition, &Quantity::ALL, change)
}

fn checked_of(
    definition: &Definition,
    offers: &[Quantity],
    change: impl Fn(&Question<'_>, &mut pintle_audit::Numbers<f64>),
) -> Report {
    let candidate =
        Candidate::new("mine", definition).settings(brief()).histories(10).offers(offers, [true; 6]);
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
/// One that offers a single quantity, and is right, is not undecided.
#[test]
fn each_quantity_alone_is_decided() {
    let mut decided = 0;
    for name in ["CARTESIAN", "CARDAN", "ROTATION", "SLIDE-PLANE", "REVOLUTE", "FLOW-CONVERTER"] {
        let definition = Definition { flow_scale: 0.4, ..at_rest(name) };
        let connector = Connector::<f64>::new(&definition);
        for quantity in Quantity::ALL {
            let is_force = matches!(quantity, Quantity::NodalForces | Quantity::GeometricStiffness);
            if is_force && !(0..6).any(|k| connector.has_force(k)) {
                continue;
            }
            let report = checked_of(&definition, &[quantity], |_, _| ());
            let found = (report.mismatches(), report.undecided_subjects());
            // The value of a one-form alone is none of the state.
            let is_open = name == "FLOW-CONVERTER" && quantity == Quantity::Value;
            assert!(found == (0, 0) || is_open, "{name}, {}: {found:?}", quantity.name());
            decided += usize::from(found == (0, 0));
        }
    }
    assert!(decided > 35, "{decided}");
}

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

/// Nodal forces of an element of springs at a pair that was moved, on 237 bits: from the values and rows there.
fn forces(
    definition: &Definition,
    asked: &Question<'_>,
    by: &[Wide; DOFS],
    springs: &[Option<f64>; 6],
) -> [Wide; DOFS] {
    let connector = Connector::<Wide>::new(definition);
    let request = Request::new(&[Output::CU, Output::RES], [true; 6], 1);
    let state = exact_state::<Wide>(asked.state());
    let state = State { pair: moved(&state.pair, by), ..state };
    let branch = connector.advance(&state, &Increment::none(), &connector.initial_branch());
    let found = connector.evaluate(&state, &Increment::none(), &branch, &request, &mut Tally::default());
    let mut force = [Wide::from_f64(0.0); DOFS];
    for k in 0..6 {
        let (Some(d), Some(row)) = (springs[k], &found.jacobian[k]) else { continue };
        let value = found.residual[k].or(found.displacement[k]).unwrap();
        for (entry, x) in force.iter_mut().zip(row) {
            *entry += Wide::from_f64(d) * value * *x;
        }
    }
    force
}

/// An element of springs: the stiffness is what differences of its forces on 237 bits say; its symmetric part is the energy's; an error of
/// 1e-7 is found in each.
#[test]
fn an_element_of_springs_is_judged() {
    let mut compared = 0;
    for (name, springs) in [
        ("AXIAL", [Some(3.0), None, None, None, None, None]),
        ("CARTESIAN", OF_CARTESIAN),
        ("BUSHING", OF_BUSHING),
        ("REVOLUTE", [None, None, None, Some(5.0), Some(100.0), Some(100.0)]),
    ] {
        let definition = at_rest(name);
        for (tangent, spoil) in [
            (Tangent::OfForces, [0.0, 0.0]),
            (Tangent::OfEnergy, [0.0, 0.0]),
            (Tangent::OfForces, [1e-7, 0.0]),
            (Tangent::OfForces, [0.0, 1e-7]),
        ] {
            let candidate = Candidate::new("mine", &definition)
                .settings(Settings { states: 8, wide_states: 4, near_singular_states: 0, ..brief() })
                .springs(springs, tangent)
                .offers(&[Quantity::ElementForces, Quantity::ElementStiffness], [true; 6]);
            let answers = |asked: &[Question<'_>]| {
                let one = |asked: &Question<'_>| {
                    let still = [Wide::from_f64(0.0); DOFS];
                    let p =
                        forces(&definition, asked, &still, &springs).map(|x| x.to_f64() * (1.0 + spoil[0]));
                    let mut k = Box::new([[0.0; DOFS]; DOFS]);
                    let h = Wide::from_f64(1e-25);
                    for j in 0..DOFS {
                        let [plus, minus] = [h, -h].map(|h| {
                            let mut by = still;
                            by[j] = h;
                            forces(&definition, asked, &by, &springs)
                        });
                        for i in 0..DOFS {
                            k[i][j] = ((plus[i] - minus[i]) / (h + h)).to_f64();
                        }
                    }
                    if tangent == Tangent::OfEnergy {
                        let whole = k.clone();
                        for (i, line) in k.iter_mut().enumerate() {
                            for (j, x) in line.iter_mut().enumerate() {
                                *x = (whole[i][j] + whole[j][i]) / 2.0;
                            }
                        }
                    }
                    k[8][9] *= 1.0 + spoil[1];
                    Some(Given::default().element_forces(p).element_stiffness(k))
                };
                Ok::<_, Infallible>(asked.iter().map(one).collect())
            };
            let Ok(report) = candidate.try_check(answers);
            let checks = &report.subjects[0].checks;
            let wrong: Vec<_> = checks.iter().filter(|check| check.verdict.is_mismatch()).collect();
            let of: BTreeSet<_> = wrong.iter().filter_map(|check| check.quantity).collect();
            match spoil {
                [0.0, 0.0] => assert!(wrong.is_empty(), "{name} {tangent:?}: {wrong:#?}"),
                [_, 0.0] => assert_eq!(of, [Quantity::ElementForces].into(), "{name}"),
                // Only where ∂p_b2/∂x_b3 is not zero.
                _ => assert!(
                    of.iter().all(|of| *of == Quantity::ElementStiffness)
                        && (name == "REVOLUTE" || !of.is_empty()),
                    "{name}: {of:?}"
                ),
            }
            compared += checks.iter().map(|check| check.compared).sum::<u64>();
        }
    }
    assert!(compared >= 16 * 8 * 210, "{compared}");
}

/// A type, the stiffness of its springs, and what is wrong with that of the element.
pub(crate) type Springs = (&'static str, [Option<f64>; 6], &'static str);

const OF_CARTESIAN: [Option<f64>; 6] = [Some(3.0), Some(-2.0), Some(40.0), None, None, None];
const OF_BUSHING: [Option<f64>; 6] = [Some(3.0), Some(2.0), None, Some(5.0), Some(0.5), Some(1e-3)];

/// The stiffness of one spring along its length is symmetric as it is.
pub(crate) const SPRINGS: [Springs; 5] = [
    ("AXIAL", [Some(3.0), None, None, None, None, None], "geometric-term-missing"),
    ("CARTESIAN", OF_CARTESIAN, "geometric-term-missing"),
    ("CARTESIAN", OF_CARTESIAN, "symmetrised"),
    ("BUSHING", OF_BUSHING, "geometric-term-missing"),
    ("BUSHING", OF_BUSHING, "symmetrised"),
];

/// The right forces of an element of springs, and a stiffness that is made of the first derivatives alone, or is symmetric.
pub(crate) fn wrong_element(
    definition: &Definition,
    asked: &Question<'_>,
    springs: &[Option<f64>; 6],
    code: &str,
) -> ([f64; DOFS], Box<[[f64; DOFS]; DOFS]>) {
    let p = forces(definition, asked, &[Wide::from_f64(0.0); DOFS], springs).map(|x| x.to_f64());
    let numbers = answered(definition, asked);
    let rows = numbers.entries(Quantity::FirstDerivatives);
    let mut k = Box::new([[0.0; DOFS]; DOFS]);
    for (n, d) in springs.iter().enumerate().filter_map(|(n, d)| Some((n, (*d)?))) {
        for i in 0..DOFS {
            for j in 0..DOFS {
                let [x, y] = [i, j].map(|j| rows.get(n, j).unwrap_or(0.0));
                k[i][j] += d * x * y;
                if code == "symmetrised" {
                    let second = numbers.entries(Quantity::SecondDerivatives);
                    let value = numbers.entries(Quantity::Value).get(n, 0).unwrap_or(0.0);
                    k[i][j] += d * value * second.get(n, i * DOFS + j).unwrap_or(0.0);
                }
            }
        }
    }
    (p, k)
}

/// Both mistakes of a stiffness are named.
#[test]
fn causes_of_a_wrong_stiffness_are_named() {
    for (name, springs, code) in SPRINGS {
        let definition = at_rest(name);
        let candidate = Candidate::new("mine", &definition)
            .settings(Settings { states: 8, wide_states: 4, near_singular_states: 0, ..brief() })
            .springs(springs, Tangent::OfForces)
            .offers(&[Quantity::ElementForces, Quantity::ElementStiffness], [true; 6]);
        let answers = |asked: &[Question<'_>]| {
            let one = |asked: &Question<'_>| {
                let (p, k) = wrong_element(&definition, asked, &springs, code);
                Some(Given::default().element_forces(p).element_stiffness(k))
            };
            Ok::<_, Infallible>(asked.iter().map(one).collect())
        };
        let Ok(report) = candidate.try_check(answers);
        let checks = report.subjects[0].checks.iter();
        let told: Vec<String> =
            checks.filter_map(|check| check.diagnosis.as_ref()).map(|found| super::said(found)).collect();
        let is_named = told.iter().any(|told| told.contains(&format!("diagnosis::{code}]")));
        assert!(is_named, "{name} {code}: {told:#?}");
    }
}
