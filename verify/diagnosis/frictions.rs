//! Wrong frictions as engineers write them, each with its cause: all are found, and the cause is said in words.

use super::said;
use pintle_audit::{
    FrictionCandidate, FrictionCase, FrictionNumbers, FrictionSubject, Quantity, Report, Settings,
};
use pintle_kinematics::catalog::{ConnectionType, TABLE};

const PHI: Quantity = Quantity::FrictionCriterion;
const DPHI: Quantity = Quantity::FrictionGradient;
const FORCE: Quantity = Quantity::FrictionForce;
const TANGENT: Quantity = Quantity::FrictionTangent;

fn subject(name: &str) -> FrictionSubject {
    FrictionSubject::predefined(&ConnectionType::named(name, None).unwrap(), 0).unwrap()
}

/// What a routine computes with: μ = 0.3, K_s = 40; TRANSLATOR has R_r, L and F_C^int.
const MU: f64 = 0.3;
const STICK: f64 = 40.0;
const TRANSLATOR: [f64; 3] = [0.35, 1.7, 0.8];

/// P, F_C, F_N and Φ of a TRANSLATOR, by parameters and a norm of one's own.
fn translator(f: &[f64; 6], [r, l, internal]: [f64; 3], norm: fn(f64, f64) -> f64, mu: f64) -> [f64; 4] {
    let contact = f[3].abs() / r + norm(f[1], f[2]) + 2.0 * norm(f[4], f[5]) / l;
    let normal = (contact + internal).abs();
    [f[0].abs(), contact, normal, f[0].abs() - mu * normal]
}

/// The gradients of the same.
fn slopes(f: &[f64; 6], [r, l, _]: [f64; 3], is_sum: bool, mu: f64) -> [[f64; 6]; 4] {
    let of = |x: f64, y: f64| match x.hypot(y) {
        0.0 => 0.0,
        _ if is_sum => x.signum(),
        size => x / size,
    };
    let contact = [
        0.0,
        of(f[1], f[2]),
        of(f[2], f[1]),
        f[3].signum() / r,
        2.0 * of(f[4], f[5]) / l,
        2.0 * of(f[5], f[4]) / l,
    ];
    let tangential = [if f[0] == 0.0 { 0.0 } else { f[0].signum() }, 0.0, 0.0, 0.0, 0.0, 0.0];
    let excess = std::array::from_fn(|j| tangential[j] - mu * contact[j]);
    [tangential, contact, contact, excess]
}

/// P, F_C, F_N and Φ of a TRANSLATOR that is pressed by F_C.
fn press(case: &FrictionCase, given: &mut FrictionNumbers, contact: f64) {
    let [_, _, internal] = TRANSLATOR;
    let (traction, normal) = (case.told().forces[0].abs(), (contact + internal).abs());
    given.criterion = [traction, contact, normal, traction - MU * normal].map(Some);
}

const fn sum(x: f64, y: f64) -> f64 {
    x.abs() + y.abs()
}

/// Whether the increment slips, which its limit tells.
fn slips(given: &FrictionNumbers) -> bool {
    given.forces[6].unwrap() > 0.0
}

pub(crate) type Wrong = (
    &'static str,
    &'static str,
    &'static [Quantity],
    fn(&FrictionCase, &mut FrictionNumbers),
    &'static str,
    &'static str,
);

pub(crate) const ALL: &[Wrong] = &[
    (
        "TRANSLATOR",
        "R_r and L exchanged",
        &[PHI, DPHI],
        |case, given| {
            let [r, l, internal] = TRANSLATOR;
            let f = case.told().forces;
            given.criterion = translator(&f, [l, r, internal], f64::hypot, MU).map(Some);
            given.gradients = slopes(&f, [l, r, internal], false, MU).map(Some);
        },
        "parameters-swapped",
        "R_r and L exchanged",
    ),
    (
        "TRANSLATOR",
        "one norm of all that presses",
        &[PHI],
        |case, given| {
            let ([r, l, _], f) = (TRANSLATOR, case.told().forces);
            press(case, given, (f[3] / r).hypot(f[1].hypot(f[2])).hypot(2.0 / l * f[4].hypot(f[5])));
        },
        "sum-for-norm",
        "one norm of all terms",
    ),
    (
        "TRANSLATOR",
        "m1 for |m1| in F_C",
        &[PHI],
        |case, given| {
            let ([r, l, _], f) = (TRANSLATOR, case.told().forces);
            press(case, given, f[3] / r + f[1].hypot(f[2]) + 2.0 / l * f[4].hypot(f[5]));
        },
        "sign-lost",
        "m1 for its magnitude",
    ),
    (
        "TRANSLATOR",
        "L for R_r in the torsion alone",
        &[PHI],
        |case, given| {
            let ([_, l, _], f) = (TRANSLATOR, case.told().forces);
            press(case, given, f[3].abs() / l + f[1].hypot(f[2]) + 2.0 / l * f[4].hypot(f[5]));
        },
        "parameters-swapped",
        "L for R_r in the term of |m1|",
    ),
    (
        "SLIDE-PLANE",
        "a force that is not cut at the limit",
        &[FORCE],
        |case, given| {
            let told = case.told();
            for k in [1, 2] {
                given.forces[k] = Some(told.forces_before[k] + STICK * told.displacement[k]);
            }
        },
        "stick-for-slip",
        "not cut at the limit",
    ),
    (
        "TRANSLATOR",
        "P without the magnitude",
        &[PHI],
        |case, given| given.criterion[0] = Some(case.told().forces[0]),
        "sign",
        "right at other states, so that a magnitude is left out",
    ),
    (
        "TRANSLATOR",
        "a norm taken as a sum",
        &[PHI],
        |case, given| {
            given.criterion = translator(&case.told().forces, TRANSLATOR, sum, MU).map(Some);
        },
        "sum-for-norm",
        "F_C",
    ),
    (
        "TRANSLATOR",
        "a norm taken as a sum, in the gradients",
        &[DPHI],
        |case, given| {
            given.gradients = slopes(&case.told().forces, TRANSLATOR, true, MU).map(Some);
        },
        "sum-for-norm",
        "∂F_C",
    ),
    (
        "TRANSLATOR",
        "μ twice",
        &[PHI],
        |case, given| {
            given.criterion = translator(&case.told().forces, TRANSLATOR, f64::hypot, MU * MU).map(Some);
        },
        "other-coefficient",
        "Φ",
    ),
    (
        "TRANSLATOR",
        "no μ",
        &[DPHI],
        |case, given| {
            given.gradients = slopes(&case.told().forces, TRANSLATOR, false, 1.0).map(Some);
        },
        "other-coefficient",
        "∂Φ",
    ),
    (
        "TRANSLATOR",
        "the slopes by m2 and m3 exchanged",
        &[DPHI],
        |_, given| {
            given.gradients[2].iter_mut().for_each(|row| row.swap(4, 5));
        },
        "columns-swapped",
        "m2",
    ),
    (
        "SLIDE-PLANE",
        "a regularised norm",
        &[PHI],
        |_, given| {
            let p = given.criterion[0].unwrap();
            given.criterion[0] = Some((p * p + 1e-8).sqrt());
        },
        "regularised",
        "P",
    ),
    (
        "SLIDE-PLANE",
        "a term in the square of F_C",
        &[PHI],
        |_, given| given.criterion[1] = given.criterion[1].map(|f| f + 1e-5 * f * f),
        "quadratic",
        "F_C",
    ),
    (
        "TRANSLATOR",
        "1/L for 2/L",
        &[PHI],
        |case, given| {
            let [r, l, internal] = TRANSLATOR;
            given.criterion =
                translator(&case.told().forces, [r, 2.0 * l, internal], f64::hypot, MU).map(Some);
        },
        "number-left-out",
        "F_C",
    ),
    (
        "TRANSLATOR",
        "R_r multiplied",
        &[PHI],
        |case, given| {
            let [r, l, internal] = TRANSLATOR;
            given.criterion =
                translator(&case.told().forces, [1.0 / r, l, internal], f64::hypot, MU).map(Some);
        },
        "multiplied",
        "F_C",
    ),
    (
        "TRANSLATOR",
        "0/0 where nothing slides",
        &[DPHI],
        |case, given| {
            let f = case.told().forces;
            let mut wrong = slopes(&f, TRANSLATOR, false, MU);
            wrong[0][0] = f[0] / f[0].abs();
            wrong[3][0] = wrong[0][0];
            given.gradients = wrong.map(Some);
        },
        "not-a-number",
        "∂P",
    ),
    (
        "SLIDE-PLANE",
        "a norm taken as a sum in P",
        &[PHI],
        |case, given| {
            let f = case.told().forces;
            let p = sum(f[1], f[2]);
            let by = p - given.criterion[0].unwrap();
            given.criterion[0] = Some(p);
            given.criterion[3] = given.criterion[3].map(|x| x + by);
        },
        "sum-for-norm",
        "P",
    ),
    (
        "SLIDE-PLANE",
        "no return",
        &[FORCE],
        |case, given| {
            let told = case.told();
            for k in [1, 2] {
                given.forces[k] = Some(told.forces_before[k] + STICK * told.displacement[k]);
            }
            for i in 6..10 {
                given.forces[i] = None;
            }
        },
        "stick-for-slip",
        "CSF",
    ),
    (
        "SLIDE-PLANE",
        "elastic for consistent tangent",
        &[TANGENT],
        |_, given| {
            if slips(given) {
                for k in [1, 2] {
                    let mut row = [0.0; 12];
                    row[k] = STICK;
                    given.tangent[k] = Some(row);
                }
            }
        },
        "stick-for-slip",
        "∂f",
    ),
    (
        "SLIDE-PLANE",
        "continuum for consistent tangent",
        &[TANGENT],
        |_, given| {
            if slips(given) {
                let f = [given.forces[1].unwrap(), given.forces[2].unwrap()];
                let size = f[0].hypot(f[1]);
                for (i, k) in [1, 2].into_iter().enumerate() {
                    let row = given.tangent[k].as_mut().unwrap();
                    for (j, l) in [1, 2].into_iter().enumerate() {
                        let own = if i == j { 1.0 } else { 0.0 };
                        row[l] = STICK * (own - f[i] * f[j] / (size * size));
                    }
                }
            }
        },
        "continuum-tangent",
        "∂f",
    ),
    (
        "SLIDE-PLANE",
        "the unsymmetric part left out",
        &[TANGENT],
        |_, given| {
            given.tangent.iter_mut().flatten().for_each(|row| row[6..].fill(0.0));
        },
        "contact-force-held",
        "∂f",
    ),
    (
        "SLIDE-PLANE",
        "μ twice",
        &[FORCE],
        |case, given| {
            let normal = given.forces[7].unwrap();
            let told = case.told();
            let trial = [1, 2].map(|k| told.forces_before[k] + STICK * told.displacement[k]);
            let size = trial[0].hypot(trial[1]);
            let limit = MU * MU * normal;
            let part = if size > limit { limit / size } else { 1.0 };
            for (k, trial) in [1, 2].into_iter().zip(trial) {
                given.forces[k] = Some(part * trial);
            }
            let slip = (size - limit).max(0.0) / STICK;
            given.forces[6] = Some(slip);
            given.forces[8] = Some(limit);
            given.forces[9] = Some(told.slip_before + slip);
        },
        "other-coefficient",
        "CSF",
    ),
    (
        "SLIDE-PLANE",
        "the friction acts along the motion",
        &[FORCE],
        |_, given| {
            for k in [1, 2] {
                given.forces[k] = given.forces[k].map(|x| -x);
            }
        },
        "sign",
        "CSF",
    ),
    (
        "CYLINDRICAL",
        "R multiplied in P",
        &[PHI],
        |case, given| {
            let f = case.told().forces;
            let p = f[0].hypot(f[3] * 0.35);
            let by = p - given.criterion[0].unwrap();
            given.criterion[0] = Some(p);
            given.criterion[3] = given.criterion[3].map(|x| x + by);
        },
        "multiplied",
        "P",
    ),
    (
        "TRANSLATOR",
        "one of two norms missing",
        &[PHI],
        |case, given| {
            let mut f = case.told().forces;
            (f[4], f[5]) = (0.0, 0.0);
            given.criterion = translator(&f, TRANSLATOR, f64::hypot, MU).map(Some);
        },
        "term-left-out",
        "F_C",
    ),
    (
        "TRANSLATOR",
        "one of two norms missing, in the gradients",
        &[DPHI],
        |case, given| {
            let mut f = case.told().forces;
            (f[1], f[2]) = (0.0, 0.0);
            given.gradients = slopes(&f, TRANSLATOR, false, MU).map(Some);
        },
        "term-left-out",
        "∂F_C",
    ),
    (
        "SLIDE-PLANE",
        "one force of the norm in P",
        &[PHI],
        |case, given| {
            let p = case.told().forces[1].abs();
            let by = p - given.criterion[0].unwrap();
            given.criterion[0] = Some(p);
            given.criterion[3] = given.criterion[3].map(|x| x + by);
        },
        "term-left-out",
        "f3 in P",
    ),
    (
        "SLIDE-PLANE",
        "f/|f| where there is no traction",
        &[DPHI],
        |case, given| {
            let f = case.told().forces;
            for k in [1, 2] {
                given.gradients[0].as_mut().unwrap()[k] = f[k] / f[1].hypot(f[2]);
            }
        },
        "not-a-number",
        "∂P",
    ),
    (
        "TRANSLATOR",
        "f/|f| where nothing presses across",
        &[DPHI],
        |case, given| {
            let f = case.told().forces;
            for k in [1, 2] {
                given.gradients[1].as_mut().unwrap()[k] = f[k] / f[1].hypot(f[2]);
            }
        },
        "not-a-number",
        "∂F_C",
    ),
    (
        "SLIDE-PLANE",
        "the direction of a slip that is none",
        &[FORCE],
        |case, given| {
            let told = case.told();
            let trial = [1, 2].map(|k| told.forces_before[k] + STICK * told.displacement[k]);
            let size = trial[0].hypot(trial[1]);
            for (k, trial) in [1, 2].into_iter().zip(trial) {
                given.forces[k] = Some(size.min(given.forces[8].unwrap()) * trial / size);
            }
        },
        "not-a-number",
        "CSF",
    ),
    (
        "SLIDE-PLANE",
        "a traction clamped at 50",
        &[PHI],
        |_, given| given.criterion[0] = given.criterion[0].map(|x| x.min(50.0)),
        "limited",
        "P",
    ),
    (
        "SLIDE-PLANE",
        "the tangent times 1 + 1e-7",
        &[TANGENT],
        |_, given| given.tangent.iter_mut().flatten().flatten().for_each(|x| *x *= 1.0 + 1e-7),
        "factor",
        "(1 + 1e-7)",
    ),
];

fn settings(states: usize) -> Settings {
    Settings { states, near_singular_states: 0, wide_states: 4, atlas: false, ..Settings::default() }
}

fn checked(name: &str, offers: &[Quantity], spoil: fn(&FrictionCase, &mut FrictionNumbers)) -> Report {
    let subject = subject(name);
    let candidate = FrictionCandidate::new("mine", &subject).settings(settings(24)).offers(offers);
    candidate.check(|case| {
        let mut given = case.product();
        spoil(case, &mut given);
        given
    })
}

/// The corpus: every routine is found, and the first cause that is told is the one.
#[test]
fn causes_of_wrong_frictions_are_named() {
    let (mut table, mut named) = (String::new(), 0);
    for (of, name, offers, spoil, cause, place) in ALL {
        let report = checked(of, offers, *spoil);
        assert!(report.mismatches() > 0, "{of} {name}: not found");
        let checks = report.subjects.iter().flat_map(|subject| &subject.checks);
        let told: Vec<String> =
            checks.filter_map(|check| check.diagnosis.as_ref()).map(|found| said(found)).collect();
        let is_it = |line: &&str| line.contains(&format!("diagnosis::{cause}")) && line.contains(place);
        if told.iter().any(|told| told.lines().next().as_ref().is_some_and(is_it)) {
            named += 1;
        } else {
            table += &format!("{of} {name}, {cause} of {place}:\n{}\n", told.join("\n"));
        }
    }
    println!("{named} of {} named\n{table}", ALL.len());
    assert!(ALL.len() >= 16 && named == ALL.len(), "{named} of {} named\n{table}", ALL.len());
}

/// The product's own numbers are right of every predefined friction; formulas of one's own are, too; each quantity is compared, and an error
/// of 1e-8 is found in it alone.
#[test]
fn right_frictions_are_not_called_wrong() {
    let (mut compared, mut types) = (0, 0);
    for connection in TABLE {
        let Some(subject) = FrictionSubject::predefined(connection, 0) else { continue };
        types += 1;
        let candidate = FrictionCandidate::new("mine", &subject).settings(settings(12));
        let report = candidate.check(FrictionCase::product);
        let found = &report.subjects[0];
        let wrong: Vec<_> = found.checks.iter().filter(|check| check.verdict.is_mismatch()).collect();
        assert!(wrong.is_empty(), "{}: {wrong:#?}", connection.name);
        for quantity in FrictionCandidate::QUANTITIES {
            let of = found.checks.iter().filter(|check| check.quantity == Some(quantity));
            let count: u64 = of.map(|check| check.compared).sum();
            assert!(count >= 12, "{} {}: {count}", connection.name, quantity.name());
            compared += count;
            let report = candidate.check(|case| {
                let mut given = case.product();
                let by = |x: &mut f64| *x *= 1.0 + 1e-8;
                match quantity {
                    PHI => given.criterion.iter_mut().flatten().for_each(by),
                    DPHI => given.gradients.iter_mut().flatten().flatten().for_each(by),
                    FORCE => given.forces.iter_mut().flatten().for_each(by),
                    _ => given.tangent.iter_mut().flatten().flatten().for_each(by),
                }
                given
            });
            let wrong = report.subjects[0].checks.iter().filter(|check| check.verdict.is_mismatch());
            let wrong: Vec<_> = wrong.map(|check| check.quantity).collect();
            assert_eq!(wrong, [Some(quantity)], "{} {}", connection.name, quantity.name());
        }
    }
    println!("{types} types, {compared} numbers compared");
    assert!(types >= 7 && compared > 4_000, "{types} types, {compared} numbers");
    let report = checked("TRANSLATOR", &[PHI, DPHI], |case, given| {
        let f = case.told().forces;
        given.criterion = translator(&f, TRANSLATOR, f64::hypot, MU).map(Some);
        given.gradients = slopes(&f, TRANSLATOR, false, MU).map(Some);
    });
    assert_eq!(report.mismatches(), 0, "{:#?}", report.subjects[0].checks);
}

/// What is missing is said; what may be left out is not missed.
#[test]
fn missing_numbers_of_frictions_are_named() {
    let worst = |report: &Report| report.subjects[0].checks[0].worst.as_ref().unwrap().entry.clone();
    let report = checked("SLIDE-PLANE", &[FORCE], |_, given| given.forces[2] = None);
    assert_eq!(worst(&report), "CSF3 is missing");
    let report = checked("SLIDE-PLANE", &[FORCE], |_, given| given.forces[6..].fill(None));
    assert_eq!(report.mismatches(), 0);
}
