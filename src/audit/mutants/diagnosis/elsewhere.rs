//! The same connector at other nodes than those that are meant: exchanged, held in their initial place, with triads transposed, an
//! increment late, without its history.

use crate::case::quantity::{Numbers, Quantity};
use crate::case::{Case, Step};
use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::matching::Hypothesis;
use crate::oracles::force::product_with_forces as product;
use pintle_kinematics::node::{DOFS, Node, Pair, XB};
use pintle_kinematics::vector::{identity, transpose};

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
    add(Cause::NodesSwapped, None, &exchanged(case));
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
                // With columns in the right order.
                let at = |j: usize| (j + XB) % DOFS;
                let place =
                    |n: usize| if row.len() > DOFS { at(n / DOFS) * DOFS + at(n % DOFS) } else { at(n) };
                let ordered = (0..row.len()).map(|n| (n, row[place(n)]));
                found.push(Hypothesis::of_row(cause, k, ordered));
            }
        }
    }
    found
}
