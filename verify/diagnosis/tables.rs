//! Constraints, frictions and slopes of behaviour: every mistake of their catalogues is named as what it is.

use super::said;
use crate::laws::mpc;
use pintle_audit::behavior::slopes;
use pintle_audit::judge::table::ResultTable;
use pintle_audit::mutants::diagnosis::{Cause, diagnose_table};
use pintle_audit::mutants::mutant::Mistake;
use pintle_audit::sampling::about_initial;
use pintle_audit::{MpcCase, Quantity, Settings, friction_cases};
use pintle_kinematics::catalog::TABLE;
use pintle_kinematics::connector::Turns;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::mpc::Turning;
use pintle_model::behavior::Conditions;
use pintle_model::evaluate::Model;
use pintle_scene::{Code, Scene};
use std::collections::{BTreeMap, BTreeSet};

const START: [Turns<f64>; 2] = [Turns { turns: 0.0, principal: 0.0 }; 2];

fn of_constraints() -> Vec<(String, ResultTable)> {
    let audited = mpc::cases().into_iter().filter(|case| !case.holds).map(|case| MpcCase {
        constraint: case.constraint(),
        name: case.name,
        state: case.state,
        turning: Turning::none(),
        before: START,
        length: case.length,
    });
    audited.flat_map(|case| case.tables().into_iter().map(move |table| (case.name.clone(), table))).collect()
}

fn of_frictions() -> Vec<(String, ResultTable)> {
    let settings = Settings::default();
    let cases = TABLE.iter().flat_map(|connection| friction_cases(connection, &settings, 3));
    let tables = cases.flat_map(|case| {
        let name = case.name().to_string();
        case.tables().into_iter().map(move |table| (name.clone(), table))
    });
    tables.collect()
}

/// Springs and dashpots: of tables, not proportional; coupled; linear.
const BEHAVIOR: &str = "\
*NODE
1, 0., 0., 0.
2, 2., 0.3, -0.4
*ORIENTATION, NAME=O
1., 0., 0., 0., 1., 0.
*ELEMENT, TYPE=CONN3D2, ELSET=C
7, 1, 2
*CONNECTOR SECTION, ELSET=C, BEHAVIOR=B
CARTESIAN, CARDAN
O, O
*CONNECTOR BEHAVIOR, NAME=B
*CONNECTOR ELASTICITY, COMPONENT=1, NONLINEAR
-900., -3.
-100., -0.01
0., 0.
150., 0.01
800., 3.
*CONNECTOR ELASTICITY, COMPONENT=3, NONLINEAR, INDEPENDENT COMPONENTS=POSITION
1, 3
-30., -9., -9.
10., 9., -9.
70., -9., 9.
210., 9., 9.
*CONNECTOR ELASTICITY, COMPONENT=4
50.,
*CONNECTOR ELASTICITY, COMPONENT=5, NONLINEAR
-90., -3.
-10., -0.01
0., 0.
15., 0.01
80., 3.
*CONNECTOR DAMPING, COMPONENT=2, NONLINEAR
-90., -30.
-10., -0.01
0., 0.
15., 0.01
80., 30.
*CONNECTOR DAMPING, COMPONENT=5
3.5,
";

fn of_behaviors() -> Vec<(String, ResultTable)> {
    let scene =
        Scene::parse("behaviour.inp", BEHAVIOR).unwrap_or_else(|e| panic!("{}", e.render(110, false)));
    let model = Model::compile(&scene).unwrap();
    let element = &model.connectors[0];
    let draw = &mut Draw::new("slopes");
    let cases =
        (1..6).filter_map(|i| about_initial(&element.definition(), i, 2.0, format!("state {i}"), draw));
    cases
        .filter_map(|case| {
            Some((
                case.name.clone(),
                slopes(&case, &element.behavior.behavior, &Conditions::default())?.table,
            ))
        })
        .collect()
}

/// Why the sign of an entry is never named first there.
const OF_ONE_NUMBER: &str = "the sign of its row, which is one number";

/// What is tried of a quantity: how often a mistake was named first, and how often besides another.
type Tally = BTreeMap<(Quantity, &'static str), (usize, usize)>;

/// The name of a mistake, without its size.
fn kind(mistake: Mistake) -> &'static str {
    Cause::of(mistake).code().as_str()
}

fn diagnosed(tables: &[(String, ResultTable)]) -> Tally {
    let mut tally = Tally::new();
    for (name, table) in tables {
        for (n, change) in table.all_mistakes().into_iter().enumerate() {
            let skipped = match change.mistake {
                Mistake::Scaled(delta) if delta != 1e-1 && delta != 1e-6 => true,
                // Of the entries of many matrices, some.
                Mistake::Scaled(_) | Mistake::Dropped | Mistake::Sign | Mistake::Spurious => {
                    table.entries.len() > 60 && n % 37 != 0
                }
                _ => false,
            };
            if skipped {
                continue;
            }
            let mut wrong = table.clone();
            let mut most = 0.0_f64;
            for (row, i, x) in change.changes.iter() {
                let entry = &mut wrong.entries[row * table.width() + i];
                most = most.max((x - entry.got).abs() / entry.tolerance());
                entry.got = *x;
            }
            // What changes less than that cannot be told from chance.
            if most < 1e6 {
                continue;
            }
            let found = diagnose_table(&wrong);
            let mistake = change.mistake.name();
            let found = found.unwrap_or_else(|| panic!("{name}: {mistake}: nothing wrong"));
            let what = format!("{name} {}, {mistake}:\n{}", table.quantity.name(), said(&found));
            assert_eq!((found.causes.len(), found.unexplained), (1, 0), "{what}");
            let first = &found.causes[0];
            let code = Cause::of(change.mistake).code();
            let counted = tally.entry((table.quantity, kind(change.mistake))).or_default();
            if first.code == code {
                counted.0 += 1;
            } else {
                let also: BTreeSet<Code> = first.also.iter().copied().collect();
                assert!(also.contains(&code), "{what}");
                counted.1 += 1;
            }
        }
    }
    tally
}

/// Every mistake in a quantity is named by its own sentence, but for those that make the same numbers as another everywhere.
fn demand(tables: &[(String, ResultTable)], quantities: &[Quantity], same: &[(Quantity, Code, &str)]) {
    let tally = diagnosed(tables);
    let tried: BTreeSet<Quantity> = tally.keys().map(|(quantity, _)| *quantity).collect();
    assert_eq!(tried, quantities.iter().copied().collect());
    for ((quantity, code), (first, besides)) in &tally {
        let known = same.iter().find(|(of, same, _)| of == quantity && same.as_str() == *code);
        match known {
            None => assert!(*first > 0, "{} {code}: never first, {besides} times besides", quantity.name()),
            Some((.., why)) => assert_eq!(*first, 0, "{} {code}: not always {why}", quantity.name()),
        }
    }
    // Every mistake that a table knows was tried.
    for (_, table) in tables {
        for change in &table.mistakes {
            let key = (table.quantity, kind(change.mistake));
            assert!(tally.contains_key(&key), "{} {} was never decisive", key.0.name(), key.1);
        }
    }
}

#[test]
fn every_mistake_in_a_constraint_is_diagnosed_as_itself() {
    use Quantity::{Acceleration, FirstDerivatives, Rate, SecondDerivatives, Value};
    let same =
        [Value, Rate, Acceleration].map(|quantity| (quantity, Code::DiagnosisSignOfEntry, OF_ONE_NUMBER));
    demand(&of_constraints(), &[Value, FirstDerivatives, SecondDerivatives, Rate, Acceleration], &same);
}

#[test]
fn every_mistake_in_a_friction_is_diagnosed_as_itself() {
    use Quantity::{FrictionCriterion, FrictionGradient, FrictionHessian, FrictionTangent};
    let same = [(FrictionCriterion, Code::DiagnosisSignOfEntry, OF_ONE_NUMBER)];
    demand(&of_frictions(), &[FrictionCriterion, FrictionGradient, FrictionHessian, FrictionTangent], &same);
}

#[test]
fn every_mistake_in_slopes_is_diagnosed_as_itself() {
    demand(&of_behaviors(), &[Quantity::BehaviorTangent], &[]);
}

/// The numbers with all mistakes of one cause at once, as a routine makes them; nothing where they change nothing.
fn throughout(table: &ResultTable, cause: Cause) -> Option<ResultTable> {
    let mut wrong = table.clone();
    let mut most = 0.0_f64;
    for change in table.mistakes.iter().filter(|change| Cause::of(change.mistake) == cause) {
        for (row, i, x) in change.changes.iter() {
            let entry = &mut wrong.entries[row * table.width() + i];
            most = most.max((x - entry.got).abs() / entry.tolerance());
            entry.got = *x;
        }
    }
    (most > 1e6).then_some(wrong)
}

/// A routine that gives secants throughout, F/u of springs and dampers, or what a whole increment changes of a friction, is told so in one sentence.
#[test]
fn a_secant_stiffness_is_told_in_words() {
    for tables in [of_behaviors(), of_frictions()] {
        let mut told = 0;
        for (name, table) in tables {
            let Some(wrong) = throughout(&table, Cause::SecantForTangent) else { continue };
            let check = wrong.check(false, &name, None);
            let diagnosis = check.diagnosis.unwrap_or_else(|| panic!("{name}: nothing wrong"));
            let words = said(&diagnosis);
            assert_eq!((diagnosis.causes.len(), diagnosis.unexplained), (1, 0), "{name}: {words}");
            let cause = &diagnosis.causes[0];
            let is_first =
                cause.code == Code::DiagnosisSecant && words.contains("the secant instead of the tangent");
            assert!(is_first || cause.also.contains(&Code::DiagnosisSecant), "{name}: {words}");
            told += usize::from(is_first);
        }
        assert!(told >= 3, "{told}");
    }
}
