use crate::*;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::scalar::{Real, Wide, elementary};
use pintle_kinematics::so3;

/// A function of two positive inputs that holds every atom.
fn every_atom() -> [Symbol; 12] {
    let (x, y) = (Symbol::input(0), Symbol::input(1));
    let half = Symbol::ratio(1, 2);
    let rotation = so3::matrix(so3::exp_quaternion([x, y * half, x * y]));
    [
        elementary::sqrt(x),
        elementary::inverse_sqrt(y * x),
        elementary::sin_cos(x * y).0,
        elementary::exp(x - y),
        elementary::exp_m1(x),
        elementary::atan2(y, x),
        elementary::norm([x, y, half]),
        elementary::direction([x, y, half])[1],
        elementary::power(x, Symbol::from_f64(2.5)),
        elementary::recip(x + y),
        so3::log(&rotation)[1],
        so3::continuous_log(&rotation, [x, y, half]).phi[2],
    ]
}

/// The n-th derivative by x, by central differences of the one before on 237 bits.
#[test]
fn every_atom_has_the_derivative_of_its_values() {
    let (mut graph, mut functions) = trace(every_atom).unwrap();
    let one = graph.integer(1);
    let mut by_x = Derivation::along([(0, one)]);
    let at = |x: Wide| [x, Wide::from_f64(0.75)];
    let (x, h) = (Wide::from_f64(0.625), Wide::from_f64(1e-22));
    for order in 1..=6 {
        let derivatives = functions.map(|id| by_x.of(&mut graph, id));
        for (i, (function, derivative)) in functions.iter().zip(derivatives).enumerate() {
            let value = |x: Wide| graph.evaluate(&[*function], &at(x))[0];
            let want = ((value(x + h) - value(x - h)) / (h + h)).to_f64();
            let got = graph.evaluate(&[derivative], &at(x))[0].to_f64();
            let narrow = graph.evaluate(&[derivative], &[0.625, 0.75])[0];
            assert!(
                (got - want).abs() <= 1e-14 * want.abs().max(1.0),
                "{i}, order {order}: {got:?}, {want:?}"
            );
            assert!(
                (narrow - want).abs() <= 1e-9 * want.abs().max(1.0),
                "{i}, order {order}: {narrow:?}, {want:?}"
            );
        }
        functions = derivatives;
    }
}

#[test]
fn traced_values_are_those_of_doubles() {
    let (graph, functions) = trace(every_atom).unwrap();
    let traced = graph.evaluate(&functions, &[0.625, 0.75]);
    let (x, y, half) = (0.625_f64, 0.75_f64, 0.5);
    let rotation = so3::matrix(so3::exp_quaternion([x, y * half, x * y]));
    let [_, along, _] = so3::log(&rotation);
    let direct = [x.sqrt(), 1.0 / (x * y).sqrt(), (x * y).sin(), (x - y).exp(), x.exp_m1(), y.atan2(x)];
    for (traced, direct) in traced.iter().zip(direct).chain([(&traced[10], along)]) {
        assert!((traced - direct).abs() <= 4.0 * pintle_kinematics::scalar::U, "{traced:?}, {direct:?}");
    }
}

#[test]
fn branches_are_joined_and_recorded() {
    let least = || {
        let (x, y) = (Symbol::input(0), Symbol::input(1));
        [if x.less(y) { x } else { y }]
    };
    let (graph, [id]) = trace(least).unwrap();
    assert_eq!(graph.evaluate(&[id], &[2.0, 3.0]), [2.0]);
    assert_eq!(graph.evaluate(&[id], &[4.0, 3.0]), [3.0]);
    assert!(matches!(graph.conditions(&[id])[..], [Condition::Branch(..)]));
}

#[test]
fn a_formula_without_end_is_an_error() {
    let endless = || {
        let mut x = Symbol::input(0);
        while x.less(Symbol::input(1)) && x.0.0 < 100_000 {
            x = x * Symbol::input(2);
        }
        [x]
    };
    assert_eq!(trace(endless).unwrap_err(), TraceError::Branches);
}

#[test]
fn half_a_turn_is_positive_and_simplification_keeps_it_so() {
    // −0 − e2a·e3b with e2a·e3b = +0: the Cardan angle at half a turn.
    let model = Model::of(&ConnectionType::named("CARDAN", None).unwrap(), Frame::Relative, 0).unwrap();
    let mut inputs = vec![0.0; model.inputs.len()];
    (inputs[3], inputs[7], inputs[11]) = (1.0, -1.0, -1.0);
    assert_eq!(model.graph.evaluate(&model.values, &inputs), [std::f64::consts::PI, 0.0, 0.0]);
}
