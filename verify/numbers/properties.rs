//! Six properties of connectors, drawn at random and made small where they fail. They need no reference value, and this file alone.
//!
//! | property | of |
//! |---|---|
//! | e1a·e2b = e1a·e3b = 0 along every admissible motion | REVOLUTE |
//! | the angle unwraps through nπ | REVOLUTE |
//! | the rotation vector continues past 2π | ROTATION |
//! | a motion common to both nodes changes nothing | every type |
//! | an assembled type is its halves | every pair of halves |
//! | f·u̇ = F·q̇: component forces and nodal forces have the same power | every type |

use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{
    Branch, Connector, Definition, Evaluation, Increment, Request, State, Tally,
};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::so3::exp;
use pintle_kinematics::vector::{Matrix, Vector, add, apply, column, cross, dot, product, scale};
use proptest::array::{uniform3, uniform14};
use proptest::prelude::*;
use proptest::test_runner::{TestRng, TestRunner};
use std::cell::Cell;
use std::f64::consts::PI;

/// The unit of rounding.
const U: f64 = f64::EPSILON / 2.0;

/// How many motions each property is tried on.
const CASES: u32 = 200;

/// Asks a property of motions, shrinks what fails, and demands that at least `least` numbers were compared.
fn ask<S: Strategy>(
    motions: S,
    least: usize,
    property: impl Fn(S::Value, &Cell<usize>) -> Result<(), TestCaseError>,
) {
    let compared = Cell::new(0);
    let config = ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(CASES) };
    let random = TestRng::deterministic_rng(config.rng_algorithm);
    let outcome =
        TestRunner::new_with_rng(config, random).run(&motions, |motion| property(motion, &compared));
    if let Err(failure) = outcome {
        panic!("{failure}");
    }
    assert!(compared.get() >= least, "only {} numbers were compared, of {least} at least", compared.get());
}

/// Demands that two numbers agree to so many roundings of `size`, and counts the comparison.
fn agree(
    got: f64,
    want: f64,
    roundings: f64,
    size: f64,
    compared: &Cell<usize>,
    what: &str,
) -> Result<(), TestCaseError> {
    compared.set(compared.get() + 1);
    let error = (got - want).abs();
    prop_assert!(error <= roundings * U * size, "{}: {:e} for {:e}, error {:e}", what, got, want, error);
    Ok(())
}

fn vector(size: f64) -> impl Strategy<Value = Vector<f64>> {
    uniform3(-size..=size)
}

/// A connector that moves: where it is, and what its history left.
struct Moving {
    connector: Connector<f64>,
    pair: Pair<f64>,
    branch: Branch<f64>,
}

impl Moving {
    fn new(connection: ConnectionType, separation: Vector<f64>, [a, b]: [Matrix<f64>; 2]) -> Self {
        let node = |triad| Node { displacement: [0.0; 3], triad, flow: 0.0 };
        let pair = Pair { reference: separation, a: node(a), b: node(b) };
        let connector = Connector::new(&Definition::new(connection, pair));
        let branch = connector.initial_branch();
        Self { connector, pair, branch }
    }

    /// Turns both nodes by rotation vectors, global components, and displaces them.
    fn step(&mut self, rotation: [Vector<f64>; 2], displacement: [Vector<f64>; 2]) -> Evaluation<f64> {
        let turned = |node: Node<f64>, by: Vector<f64>, moved: Vector<f64>| Node {
            displacement: add(node.displacement, moved),
            triad: product(&exp(by), &node.triad),
            ..node
        };
        self.pair.a = turned(self.pair.a, rotation[0], displacement[0]);
        self.pair.b = turned(self.pair.b, rotation[1], displacement[1]);
        self.evaluate(&Increment { rotation, ..Increment::none() }, [0.0; DOFS])
    }

    fn evaluate(&mut self, increment: &Increment<f64>, velocity: [f64; DOFS]) -> Evaluation<f64> {
        let state = State { pair: self.pair, velocity, acceleration: [0.0; DOFS] };
        let request = Request::everything(1);
        let result =
            self.connector.evaluate(&state, increment, &self.branch, &request, &mut Tally::default());
        self.branch = result.branch;
        result
    }
}

fn named(name: &str) -> ConnectionType {
    ConnectionType::named(name, None).unwrap()
}

/// Both nodes turn by any common rotation, and b besides about e1a: e1a·e2b and e1a·e3b, the residuals ur3 and ur2, stay zero.
/// Any other turn of b leaves them.
#[test]
fn revolute_keeps_its_axis_along_every_admissible_motion() {
    let steps = prop::collection::vec((vector(1.5), -2.5..2.5_f64), 1..8);
    ask((vector(1.8), steps, 0.01..0.5_f64), 1_500, |(initial, steps, apart), compared| {
        let triad = exp(initial);
        let mut revolute = Moving::new(named("REVOLUTE"), [0.0; 3], [triad; 2]);
        for (common, angle) in steps {
            // First b about the axis as it stands, then both together.
            revolute.step([[0.0; 3], scale(column(&revolute.pair.a.triad, 0), angle)], [[0.0; 3]; 2]);
            let result = revolute.step([common; 2], [[0.0; 3]; 2]);
            for k in [4, 5] {
                agree(result.residual[k].unwrap(), 0.0, 40.0, 1.0, compared, "a direction cosine")?;
            }
        }
        let across = scale(column(&revolute.pair.a.triad, 1), apart);
        let result = revolute.step([[0.0; 3], across], [[0.0; 3]; 2]);
        let left = result.residual[4].unwrap().hypot(result.residual[5].unwrap());
        agree(left, apart.sin(), 40.0, 1.0, compared, "the sine of a turn across the axis")
    });
}

/// However often the angle passes ±π, its displacement is the sum of what b was turned.
#[test]
fn the_angle_of_revolute_unwraps_through_n_pi() {
    let steps = prop::collection::vec((-3.0..3.0_f64, vector(1.0)), 1..40);
    let (passed, most) = (Cell::new(0), Cell::new(0.0_f64));
    ask((vector(1.8), steps), 2_000, |(initial, steps), compared| {
        let mut revolute = Moving::new(named("REVOLUTE"), [0.0; 3], [exp(initial); 2]);
        let mut total = 0.0_f64;
        for (angle, common) in steps {
            revolute.step([common; 2], [[0.0; 3]; 2]);
            let result =
                revolute.step([[0.0; 3], scale(column(&revolute.pair.a.triad, 0), angle)], [[0.0; 3]; 2]);
            let turns = |angle: f64| ((angle + PI) / (2.0 * PI)).floor();
            passed.set(passed.get() + usize::from(turns(total) != turns(total + angle)));
            total += angle;
            most.set(most.get().max(turns(total).abs()));
            agree(result.displacement[3].unwrap(), total, 200.0, 10.0, compared, "ur1")?;
        }
        Ok(())
    });
    let (passed, most) = (passed.get(), most.get());
    assert!(passed > 800 && most > 2.0, "±π was passed {passed} times, {most} turns at most");
}

/// b turns about an axis fixed in a, any number of times: the rotation vector is the whole angle along that axis.
#[test]
fn the_rotation_vector_continues_past_two_pi() {
    let axis = vector(1.0).prop_filter("a direction", |v| dot(*v, *v) > 0.01);
    // Half a step beside whole turns, where the vector keeps its sheet and its digits.
    ask((vector(1.8), axis, 5..60_usize, 0.2..0.6_f64), 2_000, |(initial, axis, count, step), compared| {
        let unit = scale(axis, 1.0 / dot(axis, axis).sqrt());
        let triad = exp(initial);
        let mut rotation = Moving::new(named("ROTATION"), [0.0; 3], [triad; 2]);
        for n in 1..=count {
            let about = apply(&triad, unit);
            let result = rotation.step([[0.0; 3], scale(about, step)], [[0.0; 3]; 2]);
            let total = n as f64 * step;
            // Across the axis an error of R grows like |φ|/2 over the sine of half the angle.
            let growth = 1.0 + total / (total / 2.0).sin().abs().max(0.02);
            for k in 0..3 {
                let got = result.displacement[3 + k].unwrap();
                agree(got, total * unit[k], 100.0, n as f64 * growth, compared, "a rotation vector")?;
            }
        }
        Ok(())
    });
}

/// Two triads whose relative orientation each type accepts initially, and the vector between the nodes.
fn anywhere() -> impl Strategy<Value = (Vector<f64>, Vector<f64>)> {
    (vector(1.8), vector(2.0).prop_filter("nodes apart", |v| dot(*v, *v) > 0.1))
}

/// Both nodes move as one body: no component that is a function of the state notices.
#[test]
fn a_common_motion_changes_nothing() {
    let small = vector(0.25).prop_filter("clear of locks at rest", |v| dot(*v, *v) > 0.01);
    let motions = (anywhere(), small, vector(0.25), vector(1.7), vector(3.0));
    ask(motions, 10_000, |((initial, apart), spin, moved, common, shift), compared| {
        for connection in TABLE {
            let triad = exp(initial);
            let mut one = Moving::new(connection.clone(), apart, [triad; 2]);
            let before = one.step([[0.0; 3], spin], [[0.0; 3], moved]);
            // About the origin of a: x_b − x_a turns with both.
            let separation = one.pair.separation();
            let turned = apply(&exp(common), separation);
            let arm = [0, 1, 2].map(|i| turned[i] - separation[i]);
            let after = one.step([common; 2], [shift, add(shift, arm)]);
            for k in 0..6 {
                let (Some(before), Some(after)) = (before.position[k], after.position[k]) else { continue };
                let size = 10.0 * (1.0 + dot(shift, shift).sqrt());
                // The sweep and the Euler angles of a small flexion are 1 over it less exact.
                let slack = 4.0 / dot(spin, spin);
                agree(after, before, 60.0 * slack, size, compared, &connection.name)?;
            }
        }
        Ok(())
    });
}

/// The components of an assembled type are those of its halves: HINGE = JOIN + REVOLUTE, TRANSLATOR = SLOT + ALIGN …
#[test]
fn the_whole_is_its_parts() {
    const ASSEMBLED: [(&str, &str, &str); 7] = [
        ("BEAM", "JOIN", "ALIGN"),
        ("BUSHING", "PROJECTION CARTESIAN", "PROJECTION FLEXION-TORSION"),
        ("CYLINDRICAL", "SLOT", "REVOLUTE"),
        ("HINGE", "JOIN", "REVOLUTE"),
        ("PLANAR", "SLIDE-PLANE", "REVOLUTE"),
        ("TRANSLATOR", "SLOT", "ALIGN"),
        ("UJOINT", "JOIN", "UNIVERSAL"),
    ];
    ask((anywhere(), vector(0.3), vector(0.3)), 5_000, |((initial, apart), spin, moved), compared| {
        for (whole, first, second) in ASSEMBLED {
            let step = |name: &str| {
                let mut one = Moving::new(named(name), apart, [exp(initial); 2]);
                one.step([[0.0; 3], spin], [[0.0; 3], moved])
            };
            let [whole_result, first_result, second_result] = [whole, first, second].map(step);
            for k in 0..6 {
                let part = if k < 3 { &first_result } else { &second_result };
                prop_assert_eq!(whole_result.position[k].is_some(), part.position[k].is_some());
                for (whole_number, part) in [
                    (whole_result.position[k], part.position[k]),
                    (whole_result.residual[k], part.residual[k]),
                ] {
                    if let (Some(got), Some(want)) = (whole_number, part) {
                        agree(got, want, 0.0, 1.0, compared, whole)?;
                    }
                }
                if let (Some(got), Some(want)) = (&whole_result.jacobian[k], &part.jacobian[k]) {
                    for (got, want) in got.iter().zip(want) {
                        agree(*got, *want, 0.0, 1.0, compared, whole)?;
                    }
                }
            }
        }
        Ok(())
    });
}

/// Component forces f on rates u̇ and the nodal forces F = Σ f ∂u/∂q on rates q̇ have one power, for any rates.
#[test]
fn component_and_nodal_forces_have_the_same_power() {
    let small = vector(0.3).prop_filter("clear of locks at rest", |v| dot(*v, *v) > 0.01);
    let motions =
        (anywhere(), small, vector(0.25), uniform14(-1.0..1.0_f64), prop::array::uniform6(-1.0..1.0_f64));
    ask(motions, 5_000, |((initial, apart), spin, moved, rates, forces), compared| {
        for connection in TABLE {
            let mut one = Moving::new(connection.clone(), apart, [exp(initial); 2]);
            one.step([[0.0; 3], spin], [[0.0; 3], moved]);
            let result = one.evaluate(&Increment::none(), rates);
            let (mut power, mut nodal, mut size) = (0.0, [0.0; DOFS], 0.0);
            for k in 0..6 {
                // Rates of accelerometers are the nodal ones resolved in b, and no derivatives of their positions.
                let is_function = !connection.name.contains("ACCELEROMETER");
                let rate = result.residual_rate[k].or(result.velocity[k]);
                let (Some(row), Some(rate), true) = (&result.jacobian[k], rate, is_function) else {
                    continue;
                };
                power += forces[k] * rate;
                for j in 0..DOFS {
                    nodal[j] += forces[k] * row[j];
                    size += (forces[k] * row[j] * rates[j]).abs();
                }
            }
            let product: f64 = nodal.iter().zip(rates).map(|(force, rate)| force * rate).sum();
            agree(product, power, 100.0, size.max(1e-300), compared, &connection.name)?;
        }
        Ok(())
    });
}

/// The unit vectors of a triad turn by cross products: the helper that turns nodes is a rotation, and not only near one.
#[test]
fn nodes_are_turned_by_rotations() {
    ask(vector(3.0 * PI), 2_000, |by, compared| {
        let triad = exp(by);
        for i in 0..3 {
            let [first, second, third] = [i, (i + 1) % 3, (i + 2) % 3].map(|j| column(&triad, j));
            let crossed = cross(first, second);
            for j in 0..3 {
                agree(crossed[j], third[j], 20.0, 1.0, compared, "a triad")?;
            }
            agree(dot(first, first), 1.0, 20.0, 1.0, compared, "a length")?;
        }
        Ok(())
    });
}
