//! Tables in several variables: rows, slopes on both sides of them, integrals, and what is refused, worked out by hand.

use super::behavior;
use pintle_kinematics::scalar::Seeded;
use pintle_model::behavior::ground::Ground;
use pintle_model::behavior::table::{Table, Variable};
use pintle_model::behavior::{Conditions, Motion, Unknown};
use pintle_model::evaluate::Model;
use pintle_scene::{Extrapolation, TableRow};

/// Every row is met bit for bit, at the ends too, where the segment goes on or the value stays.
#[test]
fn rows_are_met_bit_for_bit() {
    let mut numbers = super::Numbers(11);
    for extrapolation in [Extrapolation::Linear, Extrapolation::Constant] {
        for _ in 0..20 {
            let mut x = -3.0;
            let points = [0; 5].map(|_| {
                x += 1.1 + numbers.next();
                (x, 7.0 * numbers.next())
            });
            let curve = Table::curve(&points, extrapolation).unwrap();
            for (x, y) in points {
                assert_eq!(curve.evaluate(0, |_| x), y);
                // So is the value that carries derivatives, whichever segment gives the slope.
                assert_eq!(curve.evaluate(0, |_| num_dual::DualSVec64::<1>::seed(x, 0)).re, y);
            }
        }
    }
}

/// One dependent value and two columns, and a temperature where it is given.
fn table(data: &[([f64; 3], Option<f64>)], extrapolation: Extrapolation) -> Table {
    let row = |(values, temperature): &([f64; 3], Option<f64>)| TableRow {
        values: values.map(Some).to_vec(),
        temperature: *temperature,
        ..TableRow::default()
    };
    Table::new(&data.iter().map(row).collect::<Vec<_>>(), 1, &["x", "y"], extrapolation).unwrap()
}

/// f = |x| (1 + y) + |y − 1|, which is affine in each variable between the rows.
fn folded() -> Table {
    let mut data = Vec::new();
    for y in [0.0, 1.0, 3.0] {
        for x in [-1.0_f64, 0.0, 2.0] {
            data.push(([x.abs() * (1.0 + y) + f64::abs(y - 1.0), x, y], Some(20.0)));
        }
    }
    table(&data, Extrapolation::Constant)
}

#[test]
fn kinks_have_the_slopes_at_the_other_variable() {
    let folded = folded();
    let kinks = |x: f64, y: f64| -> Vec<(usize, f64, [f64; 2])> {
        let at = |variable| if variable == Variable::Column(0) { x } else { y };
        let name = |variable| if variable == Variable::Column(0) { 0 } else { 1 };
        folded.kinks(0, at).iter().map(|k| (name(k.variable), k.at, [k.left, k.right])).collect()
    };
    assert_eq!(kinks(0.0, 0.25), [(0, 0.0, [-1.25, 1.25])]);
    assert_eq!(kinks(0.0, 0.75), [(0, 0.0, [-1.75, 1.75])]);
    assert_eq!(kinks(0.0, 2.5), [(0, 0.0, [-3.5, 3.5])]);
    assert_eq!(kinks(0.5, 1.0), [(1, 1.0, [-0.5, 1.5])]);
    assert_eq!(kinks(-0.75, 1.0), [(1, 1.0, [-0.25, 1.75])]);
    assert_eq!(kinks(0.0, 1.0), [(0, 0.0, [-2.0, 2.0]), (1, 1.0, [-1.0, 1.0])]);
    // Beyond the last row a table is constant.
    assert_eq!(kinks(2.0, 0.5), [(0, 2.0, [1.5, 0.0])]);
    assert_eq!(kinks(0.5, 0.5), []);
    // A row is met up to rounding, and how far off is told; a billionth of it is no rounding.
    let curve = Table::curve(&[(0.0, 0.0), (1000.0, 1.0), (1500.0, 9.0)], Extrapolation::Constant).unwrap();
    let x = 1000.0 + 2f64.powi(-43) * 100.0;
    assert_eq!(curve.kinks(0, |_| x)[0].distance, x - 1000.0);
    assert!(curve.kinks(0, |_| 1000.0 + 1e-8).is_empty());
}

/// The value beside a kink, with its derivatives, is that of the formula.
#[test]
fn values_have_the_slope_of_their_segment() {
    type Number = num_dual::DualSVec64<2>;
    let folded = folded();
    for (x, y) in [(0.5, 0.25), (-0.25, 0.75), (1.5, 1.5), (-0.75, 2.75)] {
        let seeded = [Number::seed(x, 0), Number::seed(y, 1)];
        let value = folded.evaluate(0, |variable| seeded[usize::from(variable != Variable::Column(0))]);
        let exact = f64::abs(x) * (1.0 + y) + f64::abs(y - 1.0);
        assert!((value.re - exact).abs() < 1e-15, "{x} {y}");
        let slopes = [f64::signum(x) * (1.0 + y), f64::abs(x) + f64::signum(y - 1.0)];
        assert!(value.gradient().iter().zip(slopes).all(|(a, b)| (a - b).abs() < 1e-14), "{x} {y}");
    }
}

#[test]
fn rows_stand_once_and_in_order() {
    let of = |values: [f64; 3], temperature| (values, Some(temperature));
    let table = table(
        &[
            of([1.0, 0.0, 5.0], 20.0),
            of([2.0, 3.0, 5.0], 20.0),
            of([1.0, -1.0, 5.0], 80.0),
            of([4.0, 3.0, 5.0], 80.0),
        ],
        Extrapolation::Constant,
    );
    assert_eq!(table.rows(Variable::Column(0)), [-1.0, 0.0, 3.0]);
    assert_eq!(table.rows(Variable::Temperature), [20.0, 80.0]);
    // What has one value only is no variable; and what is not there is none either.
    assert!(table.rows(Variable::Column(1)).is_empty());
    assert!(table.rows(Variable::Field(0)).is_empty());
    assert!(table.depends_on().eq([Variable::Column(0), Variable::Temperature]));
}

/// ∫₀ˣ between rows of two temperatures is that of the curve between them.
#[test]
fn integrals_are_those_of_the_curve_between_rows() {
    // At 0 degrees 2 |x|, at 10 degrees 4 for x < 1 and 4 x beyond.
    let data = [
        ([2.0, -1.0, 0.0], Some(0.0)),
        ([0.0, 0.0, 0.0], Some(0.0)),
        ([6.0, 3.0, 0.0], Some(0.0)),
        ([4.0, 0.0, 0.0], Some(10.0)),
        ([4.0, 1.0, 0.0], Some(10.0)),
        ([12.0, 3.0, 0.0], Some(10.0)),
    ];
    let table = table(&data, Extrapolation::Constant);
    let cold = |x: f64| if x < -1.0 { -1.0 + 2.0 * (x + 1.0) } else { x * x.abs() };
    let warm = |x: f64| if x < 1.0 { 4.0 * x } else { 2.0 + 2.0 * x * x };
    for x in [-2.5, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 3.0] {
        for share in [0.0, 0.25, 0.75, 1.0] {
            let found = table.integral(0, x, |_| 10.0 * share);
            let expected = (1.0 - share) * cold(x) + share * warm(x);
            assert!((found - expected).abs() < 1e-14, "{x} {share}: {found} {expected}");
        }
    }
    // Where the first column does not vary, the value is constant along it.
    let constant = self::table(&[([7.0, 1.0, 0.0], None), ([9.0, 1.0, 4.0], None)], Extrapolation::Constant);
    assert_eq!(constant.integral(0, 3.0, |_| 1.0), 22.5);
}

/// Slopes must be doubles, not the numbers that they are differences of; each fault says what to do.
#[test]
fn what_is_refused_is_helped() {
    let curve = |points: &[(f64, f64)]| Table::curve(points, Extrapolation::Linear);
    assert!(curve(&[(0.0, 1e308), (1.0, 1.5e308)]).is_ok());
    assert!(curve(&[(0.0, 1e300), (1e-9, 1e300)]).is_ok());
    let row = |x: f64, y: f64| TableRow { values: vec![Some(1.0), Some(x), Some(y)], ..TableRow::default() };
    let refused = |rows: &[TableRow]| Table::new(rows, 1, &["x", "y"], Extrapolation::Constant).unwrap_err();
    assert_eq!(refused(&[row(1.0, 0.0), row(0.0, 0.0)]).remedy(), "order the rows so that x increases");
    let blocks = refused(&[row(0.0, 1.0), row(1.0, 1.0), row(0.0, 0.0)]);
    assert!(blocks.remedy().starts_with("give all rows of one value of y together"), "{}", blocks.remedy());
}

/// Springs to ground: coefficients over temperature need it, tables of forces are asked for displacements.
#[test]
fn springs_to_ground_need_their_conditions() {
    let deck = "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=SPRING1, ELSET=S\n9, 1\n*ELEMENT, TYPE=SPRING1, ELSET=N\n10, 1\n\
                *SPRING, ELSET=S\n1\n4., , 10.\n8., , 30.\n*SPRING, ELSET=N, NONLINEAR\n1\n-2., -1.\n0., 0.\n6., 2.\n";
    let scene = pintle_scene::Scene::parse("deck.inp", deck).unwrap();
    let spring = |i: usize| {
        let mut ground = Ground::default();
        assert!(ground.is_empty());
        ground.add_spring(&scene.springs[i]).unwrap();
        assert!(!ground.is_empty() && !ground.has_dashpots());
        ground
    };
    let warm = Conditions { temperature: Some(20.0), ..Conditions::default() };
    assert_eq!(spring(0).spring(0.5, &warm), Ok(3.0));
    assert_eq!(spring(0).spring(0.5, &Conditions::default()), Err(Unknown::Temperature));
    assert_eq!(
        [-0.5, 0.5, 1.0].map(|x| spring(1).spring(x, &Conditions::default())),
        [Ok(-1.0), Ok(1.5), Ok(3.0)]
    );
}

/// A coefficient over frequency is that of frequency zero, wherever the spring is.
#[test]
fn coefficients_to_ground_are_not_asked_for_displacements() {
    let deck =
        "*NODE\n1, 0., 0., 0.\n*ELEMENT, TYPE=SPRING1, ELSET=S\n9, 1\n*SPRING, ELSET=S\n1\n4., 0.\n8., 2.\n";
    let scene = pintle_scene::Scene::parse("deck.inp", deck).unwrap();
    let mut ground = Ground::default();
    ground.add_spring(&scene.springs[0]).unwrap();
    for x in [-0.5, 0.5, 1.0, 3.0] {
        assert_eq!(ground.spring(x, &Conditions::default()), Ok(4.0 * x));
        assert_eq!(ground.energy(x, &Conditions::default()), Ok(2.0 * x * x));
    }
}

/// Of the upper triangle CYLINDRICAL takes D11, D14 and D44: what stands between others does nothing, whatever they do, and may be
/// left open by a library's caller.
#[test]
fn terms_of_absent_components_do_nothing() {
    let law = "*CONNECTOR ELASTICITY\n100., 9., 9., 9., 9., 9., 5., 9.\n9., 30., 9., 9., 9., 9., 9., 9.\n9., 9., 9., 9., 9.";
    let given = super::scene("CYLINDRICAL", law, "");
    let mut open = given.clone();
    let pintle_scene::Law::Coupled { rows, .. } = &mut open.behaviors[0].elasticity[0].law else {
        panic!("a coupled law")
    };
    for (n, value) in rows[0].values.iter_mut().enumerate() {
        *value = value.filter(|_| [0, 6, 9].contains(&n));
    }
    let motion = Motion {
        position: [0.0; 6],
        constitutive: [0.5, 0.75, -0.25, 0.25, 0.125, -0.5],
        velocity: [0.0; 6],
    };
    for scene in [given, open] {
        let model = Model::compile(&scene).unwrap();
        let elasticity = &model.connectors[0].behavior.behavior.elasticity;
        let forces = elasticity.forces(&motion, &Conditions::default());
        assert_eq!((forces.value[0], forces.value[3]), (Some(51.25), Some(10.0)));
    }
}

/// A law that depends on a field variable needs that one, by its number.
#[test]
fn field_variables_are_needed_by_number() {
    let law = "*CONNECTOR ELASTICITY, COMPONENT=1, DEPENDENCIES=2\n4., , , , 1.\n8., , , , 3.\n\
               *CONNECTOR DAMPING, COMPONENT=2, DEPENDENCIES=1\n4., , , 1.\n8., , , 3.";
    let behavior = behavior(law);
    let motion = Motion { position: [0.0; 6], constitutive: [0.5; 6], velocity: [0.5; 6] };
    let forces = |fields: &[f64]| {
        let conditions = Conditions { fields: fields.to_vec(), ..Conditions::default() };
        let of =
            [behavior.elasticity.forces(&motion, &conditions), behavior.damping.forces(&motion, &conditions)];
        [(of[0].value[0], of[0].unknown[0]), (of[1].value[1], of[1].unknown[1])]
    };
    assert_eq!(forces(&[]), [(None, Some(Unknown::Field(2))), (None, Some(Unknown::Field(1)))]);
    assert_eq!(forces(&[2.5]), [(None, Some(Unknown::Field(2))), (Some(3.5), None)]);
    assert_eq!(forces(&[2.5, 2.0]), [(Some(3.0), None), (Some(3.5), None)]);
    // Nor is energy known where a condition is not.
    let energy = |fields: &[f64]| {
        behavior.elasticity.energy(&motion, &Conditions { fields: fields.to_vec(), ..Conditions::default() })
    };
    assert_eq!((energy(&[2.5]), energy(&[0.0, 2.0])), (None, Some(0.75)));
}
