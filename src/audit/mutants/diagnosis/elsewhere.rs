//! The same connector at other nodes than those that are meant: exchanged, held in their initial place, with triads transposed, an
//! increment late, without its history.

use crate::case::quantity::{Numbers, Quantity};
use crate::case::{Case, Step};
use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::matching::Hypothesis;
use crate::oracles::force::product_with_forces as product;
use pintle_kinematics::node::{DOFS, Node, PSI_A, Pair, XB};
use pintle_kinematics::so3::{self, turn};
use pintle_kinematics::vector::{self, Matrix, Vector, identity, product as times, skew, transpose};

/// A case whose pairs are others, with the increments between them.
fn mapped(case: &Case, of: impl Fn(&Pair<f64>) -> Pair<f64>, is_initial_too: bool) -> Case {
    let mut other = case.clone();
    if is_initial_too {
        other.definition.initial = of(&case.definition.initial);
    }
    let mut before = other.definition.initial;
    for step in &mut other.path {
        let pair = of(&step.state.pair);
        let increment = Step::between(&before, pair).increment;
        (step.state.pair, step.increment) = (pair, increment);
        before = pair;
    }
    other
}

fn exchanged(case: &Case) -> Case {
    let swap = |pair: &Pair<f64>| Pair { reference: pair.reference.map(|x| -x), a: pair.b, b: pair.a };
    let mut other = mapped(case, swap, true);
    for step in &mut other.path {
        step.state.velocity.rotate_left(XB);
        step.state.acceleration.rotate_left(XB);
    }
    other
}

/// A turn about a global axis.
fn about_axis(axis: usize, angle: f64) -> Matrix<f64> {
    let mut phi = [0.0; 3];
    phi[axis] = angle;
    turn(phi)
}

fn product_of([x, y, z]: [Matrix<f64>; 3]) -> Matrix<f64> {
    times(&x, &times(&y, &z))
}

/// The numbers elsewhere, with the cause that puts them there, and what they are.
fn found_elsewhere(case: &Case) -> Vec<(Cause, Option<&'static str>, Numbers<f64>)> {
    let initial = case.definition.initial;
    let mut found = Vec::new();
    let mut add = |cause: Cause, relation: Option<&'static str>, case: &Case| {
        found.extend(product(case).map(|numbers| (cause, relation, numbers)));
    };
    let turned = |from: &Node<f64>, triad| Node { triad, ..*from };
    let moved = |from: &Node<f64>, by: &Node<f64>| Node { displacement: by.displacement, ..*from };
    type Map<'a> = &'a dyn Fn(&Pair<f64>) -> Pair<f64>;
    let still = |from: &Node<f64>, by: &Node<f64>| Node { flow: by.flow, ..*from };
    let left_out: [(&'static str, Map<'_>); 6] = [
        ("what is expected with the flows left out", &|pair| Pair {
            a: still(&pair.a, &initial.a),
            b: still(&pair.b, &initial.b),
            ..*pair
        }),
        ("what is expected with the rotation of a left out", &|pair| Pair {
            a: turned(&pair.a, initial.a.triad),
            ..*pair
        }),
        ("what is expected with the rotation of b left out", &|pair| Pair {
            b: turned(&pair.b, initial.b.triad),
            ..*pair
        }),
        ("what is expected with the displacement of a left out", &|pair| Pair {
            a: moved(&pair.a, &initial.a),
            ..*pair
        }),
        ("what is expected with the displacement of b left out", &|pair| Pair {
            b: moved(&pair.b, &initial.b),
            ..*pair
        }),
        ("what is expected with the displacements left out", &|pair| Pair {
            a: moved(&pair.a, &initial.a),
            b: moved(&pair.b, &initial.b),
            ..*pair
        }),
    ];
    for (relation, map) in left_out {
        add(Cause::MotionIgnored, Some(relation), &mapped(case, map, false));
    }
    // Total rotations of nodes read as something else.
    type Read = fn(Vector<f64>) -> Matrix<f64>;
    let readings: [(&'static str, Read); 4] = [
        ("what is expected with rotations of nodes taken as angles about x, y, z in this order", |phi| {
            product_of([2, 1, 0].map(|axis| about_axis(axis, phi[axis])))
        }),
        ("what is expected with rotations of nodes taken as angles about z, y, x in this order", |phi| {
            product_of([0, 1, 2].map(|axis| about_axis(axis, phi[axis])))
        }),
        ("what is expected with 1 + φ^ for the rotations of nodes", |phi| {
            let (one, hat): (Matrix<f64>, _) = (identity(), skew(phi));
            [0, 1, 2].map(|i| vector::add(one[i], hat[i]))
        }),
        ("what is expected with the rotations of nodes the other way round", |phi| turn(phi.map(|x| -x))),
    ];
    for (relation, read) in readings {
        let anew = |node: &Node<f64>, first: &Node<f64>| {
            let phi = so3::log(&times(&node.triad, &transpose(&first.triad)));
            turned(node, times(&read(phi), &first.triad))
        };
        let map =
            |pair: &Pair<f64>| Pair { a: anew(&pair.a, &initial.a), b: anew(&pair.b, &initial.b), ..*pair };
        add(Cause::OtherParameters, Some(relation), &mapped(case, map, false));
    }
    let transposed = |node: &Node<f64>| turned(node, transpose(&node.triad));
    let of_triads: [Map<'_>; 3] = [
        &|pair| Pair { a: transposed(&pair.a), b: transposed(&pair.b), ..*pair },
        &|pair| Pair { a: transposed(&pair.a), ..*pair },
        &|pair| Pair { b: transposed(&pair.b), ..*pair },
    ];
    for map in of_triads {
        add(Cause::TriadsTransposed, None, &mapped(case, map, true));
    }
    let global = |pair: &Pair<f64>| Pair { a: turned(&pair.a, identity()), ..*pair };
    add(Cause::GlobalAxes, None, &mapped(case, global, true));
    add(Cause::Linearised, None, &mapped(case, |_| initial, false));
    let mut before = case.clone();
    before.path.pop();
    if before.path.is_empty() {
        before.path.push(Step::between(&initial, initial));
    }
    add(Cause::StateBefore, None, &before);
    if let Some(last) = case.last().filter(|_| case.path.len() > 1) {
        let mut at_once = case.clone();
        let state = last.state;
        at_once.path = vec![Step { state, ..Step::between(&initial, state.pair) }];
        add(Cause::TurnForgotten, Some("what is expected of principal angles"), &at_once);
    }
    let flows = |pair: &Pair<f64>| Pair {
        a: Node { flow: pair.b.flow, ..pair.a },
        b: Node { flow: pair.a.flow, ..pair.b },
        ..*pair
    };
    if case.path.iter().any(|step| step.state.pair.a.flow != step.state.pair.b.flow) {
        let mut other = mapped(case, flows, true);
        for step in &mut other.path {
            step.state.velocity.swap(PSI_A, DOFS - 1);
            step.state.acceleration.swap(PSI_A, DOFS - 1);
        }
        add(Cause::NodesSwapped, Some("what is expected with Ψa and Ψb exchanged"), &other);
        add(
            Cause::NodesSwapped,
            Some("what is expected with a and b exchanged, and their flows"),
            &exchanged(case),
        );
    } else {
        add(Cause::NodesSwapped, None, &exchanged(case));
    }
    found
}

/// What components are elsewhere.
pub(super) fn elsewhere(case: &Case, quantity: Quantity) -> Vec<Hypothesis> {
    let mut found = Vec::new();
    for (cause, relation, numbers) in found_elsewhere(case) {
        for (k, row) in numbers.entries(quantity).0.iter().enumerate() {
            let Some(row) = row else { continue };
            let made = Hypothesis::of_row(cause, k, row.iter().copied().enumerate());
            found.push(match relation {
                Some(relation) => made.related(relation),
                None => made,
            });
            if cause == Cause::NodesSwapped && row.len() > 1 {
                if relation == Some("what is expected with Ψa and Ψb exchanged") {
                    continue;
                }
                // With columns in the right order.
                let at = |j: usize| (j + XB) % DOFS;
                let place =
                    |n: usize| if row.len() > DOFS { at(n / DOFS) * DOFS + at(n % DOFS) } else { at(n) };
                let ordered = (0..row.len()).map(|n| (n, row[place(n)]));
                let ordered = Hypothesis::of_row(cause, k, ordered);
                found.push(match relation {
                    Some(relation) => ordered.related(relation),
                    None => ordered,
                });
            }
        }
    }
    found
}
