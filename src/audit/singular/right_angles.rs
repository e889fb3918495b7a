//! Tests at states whose direction cosines are exactly 0 and ±1, where formulas meet their singular sets without rounding.

use crate::case::quantity::{Entries, Quantity};
use crate::case::{AtEnd, Case, Step};
use crate::engine::audit_case;
use crate::judge::bound::Bound;
use crate::judge::components::{Surroundings, judge};
use crate::judge::verdict::{Judgement, Verdict};
use crate::oracles::force::product_with_forces;
use crate::oracles::oracle::{Narrow, Oracle, WideAnswers};
use crate::oracles::truth::Truth;
use crate::sampling::{cube_orientations, definition, pair};
use crate::settings::Settings;
use pintle_kinematics::catalog::{COMPONENT, ConnectionType, TABLE};
use pintle_kinematics::connector::Flag;
use pintle_kinematics::draw::Draw;
use pintle_kinematics::measure::SingularClass;
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Matrix, product};
use rayon::prelude::*;

/// A connector whose b is turned by Q against a, at rest: from that orientation on, or after a regular one.
fn turned(connection: &ConnectionType, i: usize, q: &Matrix<f64>, is_start: bool) -> Case {
    let (d, cubes) = ([2.0, -1.0, 0.5], cube_orientations());
    let a0 = cubes[(7 * i + 3) % 24];
    let q0 = if is_start { *q } else { exp([0.2, -0.3, 0.1]) };
    let definition = definition(connection, pair(d, a0, &q0), 2.0);
    let mut after = pair(d, a0, q);
    after.a.triad = cubes[(5 * i + 1) % 24];
    after.b.triad = product(&after.a.triad, q);
    let step = Step::between(&definition.initial, after);
    let name = format!("{}, Q = {q:?}, from there on: {is_start}", connection.name);
    Case { name, definition, start: None, path: vec![step], length: 2.0 }
}

/// Every type at every orientation of a cube, with both histories.
fn all() -> impl Iterator<Item = Case> {
    let cubes = || cube_orientations().into_iter().enumerate();
    TABLE.iter().flat_map(move |connection| {
        cubes().flat_map(move |(i, q)| [true, false].map(|is_start| turned(connection, i, &q, is_start)))
    })
}

/// The singular set that each component is told to be on.
fn told(case: &Case) -> [Option<SingularClass>; 6] {
    let AtEnd { connector, step, before, after, .. } = case.at_end().unwrap();
    let margins = connector.margins(&step.state, &after, [true; 6]);
    let flags = connector.flags(&margins, &step.increment, &step.state, &before, &after);
    COMPONENT.map(|name| {
        flags.iter().find_map(|flag| match flag {
            Flag::Singular { component, class, .. } if *component == name => Some(*class),
            _ => None,
        })
    })
}

/// Rows by relative variations and the nodal maps are those by dual numbers in the degrees of freedom of the nodes, or their component is
/// told to be singular; and no number is judged wrong.
#[test]
fn rows_are_exact_or_told_to_be_singular() {
    let settings =
        Settings { oracles: [Oracle::WideDifferences, Oracle::NodalDual].into(), ..Settings::default() };
    let judged = |(n, mut case): (usize, Case)| {
        let numbers = product_with_forces(&case).unwrap();
        let of_nodes = Narrow::of(&case).unwrap().nodal_dual(&Bound::default()).numbers;
        let told = told(&case);
        for (k, j, x) in numbers.entries(Quantity::FirstDerivatives).iter() {
            let error = of_nodes.get(k, j).unwrap().error(x);
            assert!(
                error <= 1e-15 || told[k].is_some(),
                "{}: component {k}, entry {j}: {error:e}",
                case.name
            );
        }
        let is_singular = told.iter().any(Option::is_some);
        if is_singular {
            // At rest, and in motion.
            if n % 3 == 0 {
                let mut draw = Draw::new(&case.name);
                let state = &mut case.path.last_mut().unwrap().state;
                (state.velocity, state.acceleration) = (draw.rates(2.0), draw.rates(2.0));
            }
            for check in audit_case(&case, &settings, false, 1) {
                assert!(!check.verdict.is_mismatch(), "{}: {check:?}", case.name);
            }
        }
        [numbers.entries(Quantity::FirstDerivatives).len(), usize::from(is_singular)]
    };
    let cases: Vec<Case> = all().collect();
    let counts = cases.into_par_iter().enumerate().map(judged);
    let [compared, singular] = counts.reduce(|| [0; 2], |x, y| [x[0] + y[0], x[1] + y[1]]);
    assert!(compared > 10_000 && singular > 200, "{compared} {singular}");
}

/// The numbers of one component, changed, as differences on 237 bits judge them.
fn verdict(case: &Case, quantity: Quantity, k: usize, change: &dyn Fn(usize, f64) -> f64) -> Judgement {
    let numbers = product_with_forces(case).unwrap();
    let truth = Truth::of(case).unwrap();
    let answers = WideAnswers::of(&truth);
    let nearness = truth.nearness_of_components();
    let trusted = answers.trusted(&nearness.map(|near| near > 0.0));
    let state = &case.last().unwrap().state;
    let bound = Bound::of_components(&trusted, state, case.length, &nearness);
    let sides = truth.sides(&bound);
    let around = Surroundings::of(case, &truth, &bound, Some(&sides));
    let answer = answers.answer(Oracle::WideDifferences, quantity).unwrap();
    let mut got = Entries::default();
    got.0[k] = numbers.entries(quantity).map(|_, i, x| change(i, x)).0[k].take();
    judge(quantity, &got, &answer, &around)
}

/// Shafts that point at each other. The value of a component flexion is determined but for its sign, and on either sheet it is π −
/// 2|(w, z)| times its part of the axis. Across the set that is a kink, with two slopes; along the set a derivative, which is
/// judged as everywhere.
#[test]
fn component_flexions_over_half_a_turn_have_two_slopes() {
    let connection = ConnectionType::named("BUSHING", None).unwrap();
    let over = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
    let case = turned(&connection, 1, &over, true);
    assert_eq!(told(&case)[3..5], [Some(SingularClass::Reversal); 2]);
    let adding = |quantity: Quantity, j: usize, by: f64| {
        verdict(&case, quantity, 4, &|i, x| if i == j { x + by } else { x })
    };
    let row = product_with_forces(&case).unwrap().entries(Quantity::FirstDerivatives).0[4].clone().unwrap();
    // a carries cube orientation 6: the global axes across e3a are those of two columns of θ_a and θ_b.
    let e3 = case.last().unwrap().state.pair.a.triad.map(|row| row[2]);
    let (mut across, mut along) = (0, 0);
    for j in [3, 4, 5, 10, 11, 12] {
        let is_across = e3[j % 7 - 3] == 0.0;
        for quantity in [Quantity::FirstDerivatives, Quantity::NodalForces] {
            let right = adding(quantity, j, 0.0);
            let worst = right.worst.unwrap();
            assert_eq!(
                (right.verdict, worst.one_sided.map(|slopes| slopes.map(f64::abs))),
                (Verdict::Kink, Some([1.0; 2]))
            );
            // Beyond both slopes a number is wrong, across the set and along it; across, either slope may stand.
            assert_eq!(adding(quantity, j, 7.0).verdict, Verdict::Wrong);
            let slope = adding(quantity, j, 1.0).verdict;
            assert_eq!(slope, if is_across { Verdict::Kink } else { Verdict::Wrong }, "{quantity:?} {j}");
        }
        across += usize::from(is_across && row[j] == 0.0);
        along += usize::from(!is_across);
    }
    assert_eq!((across, along), (4, 2));
    // The sign of the value is a convention that the numbers follow; another value is wrong.
    assert_eq!(adding(Quantity::Value, 0, 1e-9).verdict, Verdict::Wrong);
}
