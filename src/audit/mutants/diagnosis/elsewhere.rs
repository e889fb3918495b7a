//! The same connector at other nodes than those that are meant: exchanged, held in their initial place, with triads transposed, an
//! increment late, without its history.

use crate::case::quantity::{Numbers, Quantity};
use crate::case::{Case, Step, values_before};
use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::matching::Hypothesis;
use crate::oracles::force::product_with_forces as product;
use pintle_kinematics::connector::State;
use pintle_kinematics::node::{DOFS, Node, PSI_A, Pair, XB};
use pintle_kinematics::so3::{self, exp};
use pintle_kinematics::vector::{self, Matrix, identity, product as times, skew, transpose};
use std::f64::consts::TAU;

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
    exp(phi)
}

fn product_of([x, y, z]: [Matrix<f64>; 3]) -> Matrix<f64> {
    times(&x, &times(&y, &z))
}

const PRINCIPAL: &str = "what is expected of principal angles";
const FLOWS_SWAPPED: &str = "what is expected with Ψa and Ψb exchanged";

/// What is right of a case elsewhere. What a one-form sums up goes on from what was right at the state before, for that is handed over.
fn numbers_of(case: &Case, quantity: Quantity) -> Option<Numbers<f64>> {
    let mut numbers = product(case)?;
    let connector = case.connector();
    let is_one_form = |k: &usize| connector.differentiated(*k).is_some_and(|measure| measure.is_one_form());
    let one_forms: Vec<usize> = (0..6).filter(is_one_form).collect();
    if quantity != Quantity::Value || one_forms.is_empty() || case.path.len() < 2 {
        return Some(numbers);
    }
    let mut before = case.clone();
    before.path.pop();
    let before = product(&before)?;
    for k in one_forms {
        let sum = before.entries(Quantity::Value).get(k, 0).unwrap_or(0.0);
        if let Some(x) = numbers.entries_mut(Quantity::Value).0[k].as_mut().and_then(|x| x.first_mut()) {
            *x -= sum;
        }
    }
    Some(numbers)
}

/// The numbers elsewhere, with the cause that puts them there, and what they are.
fn found_elsewhere(case: &Case, quantity: Quantity) -> Vec<(Cause, Option<String>, Numbers<f64>)> {
    let initial = case.definition.initial;
    let mut found = Vec::new();
    let mut add = |cause: Cause, relation: Option<String>, case: &Case| {
        found.extend(numbers_of(case, quantity).map(|numbers| (cause, relation, numbers)));
    };
    let turned = |from: &Node<f64>, triad| Node { triad, ..*from };
    let moved = |from: &Node<f64>, by: &Node<f64>| Node { displacement: by.displacement, ..*from };
    let still = |from: &Node<f64>, by: &Node<f64>| Node { flow: by.flow, ..*from };
    // Nodes made anew of what they are and of what they were at first.
    type Anew<'a> = &'a dyn Fn(&Node<f64>, &Node<f64>) -> Node<f64>;
    let both = |pair: &Pair<f64>, is_of: [bool; 2], anew: Anew<'_>| Pair {
        a: if is_of[0] { anew(&pair.a, &initial.a) } else { pair.a },
        b: if is_of[1] { anew(&pair.b, &initial.b) } else { pair.b },
        ..*pair
    };
    let back = |from: &Node<f64>, by: &Node<f64>| turned(from, by.triad);
    let left_out: [(&str, [bool; 2], Anew<'_>); 6] = [
        ("flows", [true, true], &still),
        ("rotation of a", [true, false], &back),
        ("rotation of b", [false, true], &back),
        ("displacement of a", [true, false], &moved),
        ("displacement of b", [false, true], &moved),
        ("displacements", [true, true], &moved),
    ];
    for (what, is_of, left) in left_out {
        let relation = format!("what is expected with the {what} left out");
        add(Cause::MotionIgnored, Some(relation), &mapped(case, |pair| both(pair, is_of, left), false));
    }
    // The rotations of nodes since the start, C, read as something else: of both nodes, or of one.
    type Read = fn(&Matrix<f64>) -> Matrix<f64>;
    fn of_quaternion(c: &Matrix<f64>, by: usize) -> Matrix<f64> {
        let mut quaternion = so3::quaternion(c);
        quaternion.rotate_left(by);
        so3::matrix(quaternion)
    }
    let readings: [(&'static str, Read); 9] = [
        ("taken as angles about x, y, z in this order", |c| {
            let phi = so3::log(c);
            product_of([2, 1, 0].map(|axis| about_axis(axis, phi[axis])))
        }),
        ("taken as angles about z, y, x in this order", |c| {
            let phi = so3::log(c);
            product_of([0, 1, 2].map(|axis| about_axis(axis, phi[axis])))
        }),
        ("to first order, 1 + φ^", |c| {
            let (one, hat): (Matrix<f64>, _) = (identity(), skew(so3::log(c)));
            [0, 1, 2].map(|i| vector::add(one[i], hat[i]))
        }),
        ("to second order, 1 + φ^ + φ^²/2", |c| {
            let (one, hat): (Matrix<f64>, _) = (identity(), skew(so3::log(c)));
            let square = times(&hat, &hat);
            [0, 1, 2].map(|i| vector::add(vector::add(one[i], hat[i]), square[i].map(|x| x / 2.0)))
        }),
        ("the other way round", transpose),
        ("by quaternions whose scalar w is read last, and stands first", |c| of_quaternion(c, 3)),
        ("by quaternions whose scalar w is read first, and stands last", |c| of_quaternion(c, 1)),
        ("by quaternions with v vᵀ for 2 v vᵀ", |c| {
            let [w, v @ ..] = so3::quaternion(c);
            let hat: Matrix<f64> = skew(v);
            let size = w.mul_add(w, -vector::dot(v, v));
            [0, 1, 2].map(|i| {
                [0, 1, 2].map(|j| {
                    let diagonal = if i == j { size } else { 0.0 };
                    diagonal + 2.0 * w * hat[i][j] + v[i] * v[j]
                })
            })
        }),
        ("by quaternions without a factor of two", |c| {
            let [w, v @ ..] = so3::quaternion(c);
            let (one, hat): (Matrix<f64>, _) = (identity(), skew(v));
            let square = times(&hat, &hat);
            [0, 1, 2].map(|i| vector::add(vector::add(one[i], hat[i].map(|x| w * x)), square[i]))
        }),
    ];
    const WHOSE: [(&str, [bool; 2]); 3] = [
        ("the rotations of nodes", [true, true]),
        ("the rotation of a", [true, false]),
        ("the rotation of b", [false, true]),
    ];
    for (whose, is_of) in WHOSE {
        let mut read = |cause: Cause, how: &str, anew: Anew<'_>| {
            let map = |pair: &Pair<f64>| both(pair, is_of, anew);
            add(cause, Some(format!("what is expected with {whose} {how}")), &mapped(case, map, false));
        };
        for (how, of) in &readings {
            read(Cause::OtherParameters, how, &|node, first| {
                let c = times(&node.triad, &transpose(&first.triad));
                turned(node, times(&of(&c), &first.triad))
            });
        }
        let what = "applied along the axes of the node, T₀ C for C T₀";
        read(Cause::OtherParameters, what, &|node, first| {
            let c = times(&node.triad, &transpose(&first.triad));
            turned(node, times(&first.triad, &c))
        });
        let Some((last, before)) = case.path.split_last() else { continue };
        let before = before.last().map_or(initial, |step| step.state.pair);
        let [first, old] = [&initial, &before].map(|pair| [pair.a, pair.b]);
        let since = |n: usize| times(&old[n].triad, &transpose(&first[n].triad));
        let increment = last.increment.rotation;
        type Continued<'a> = &'a dyn Fn(usize) -> Matrix<f64>;
        let continued: [(Cause, &str, Continued<'_>); 3] = [
            (Cause::OtherParameters, "found by adding rotation vectors", &|n| {
                times(&exp(vector::add(so3::log(&since(n)), increment[n])), &first[n].triad)
            }),
            (Cause::OtherParameters, "continued with the increment on the other side", &|n| {
                times(&since(n), &times(&exp(increment[n]), &first[n].triad))
            }),
            (Cause::StateBefore, "of the state before", &|n| old[n].triad),
        ];
        for (cause, how, triad) in continued {
            let mut other = case.clone();
            let mut pair = last.state.pair;
            for (n, node) in [&mut pair.a, &mut pair.b].into_iter().enumerate().filter(|(n, _)| is_of[*n]) {
                node.triad = triad(n);
            }
            let step = Step::between(&before, pair);
            if let Some(end) = other.path.last_mut() {
                (end.state.pair, end.increment) = (pair, step.increment);
            }
            add(cause, Some(format!("what is expected with {whose} {how}")), &other);
        }
    }
    let transposed = |node: &Node<f64>, _: &Node<f64>| turned(node, transpose(&node.triad));
    for is_of in [[true, true], [true, false], [false, true]] {
        let map = |pair: &Pair<f64>| both(pair, is_of, &transposed);
        add(Cause::TriadsTransposed, None, &mapped(case, map, true));
    }
    // The axes of both nodes by other names, right-handed.
    let renamed: [(&str, [(usize, f64); 3]); 5] = [
        ("e2, e3, e1 for e1, e2, e3", [(1, 1.0), (2, 1.0), (0, 1.0)]),
        ("e3, e1, e2 for e1, e2, e3", [(2, 1.0), (0, 1.0), (1, 1.0)]),
        ("e2 for e1, e1 for e2", [(1, 1.0), (0, 1.0), (2, -1.0)]),
        ("e3 for e1, e1 for e3", [(2, 1.0), (1, -1.0), (0, 1.0)]),
        ("e3 for e2, e2 for e3", [(0, -1.0), (2, 1.0), (1, 1.0)]),
    ];
    for (how, from) in renamed {
        let anew = |node: &Node<f64>, _: &Node<f64>| {
            let axes = from.map(|(i, sign)| vector::scale(vector::column(&node.triad, i), sign));
            turned(node, transpose(&axes))
        };
        let map = |pair: &Pair<f64>| both(pair, [true; 2], &anew);
        add(Cause::OtherAxis, Some(format!("what is expected with {how}")), &mapped(case, map, true));
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
        add(Cause::TurnForgotten, Some(PRINCIPAL.into()), &at_once);
        // With a held still, the increment of b is the relative rotation, and principal: angles do not see a rigid motion, rows do.
        if quantity == Quantity::Value {
            let back = times(&initial.a.triad, &transpose(&state.pair.a.triad));
            let apart = vector::apply(&back, state.pair.separation());
            let mut pair = state.pair;
            pair.a.triad = initial.a.triad;
            pair.b.triad = times(&back, &state.pair.b.triad);
            pair.a.displacement = [0.0; 3];
            pair.b.displacement = vector::sub(apart, pair.reference);
            at_once.path = vec![Step { state: State { pair, ..state }, ..Step::between(&initial, pair) }];
            add(Cause::TurnForgotten, Some(PRINCIPAL.into()), &at_once);
        }
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
        add(Cause::NodesSwapped, Some(FLOWS_SWAPPED.into()), &other);
        let what = "what is expected with a and b exchanged, and their flows";
        add(Cause::NodesSwapped, Some(what.into()), &exchanged(case));
    } else {
        add(Cause::NodesSwapped, None, &exchanged(case));
    }
    found
}

/// An angle on the sheet of the given number: a routine continues its own angle. Not one that is the expected angle on any sheet.
pub(super) fn beside(x: f64, given: f64, wanted: f64) -> f64 {
    let on_sheet = |of: f64| x + TAU * ((of - x) / TAU).round();
    if (on_sheet(wanted) - wanted).abs() < 1e-9 { x } else { on_sheet(given) }
}

/// What components are elsewhere.
pub(super) fn elsewhere(case: &Case, quantity: Quantity) -> Vec<Hypothesis> {
    let mut found = Vec::new();
    let connector = case.connector();
    let is_summed = |k: usize| {
        quantity == Quantity::Value
            && case.path.len() > 1
            && connector.differentiated(k).is_some_and(|measure| measure.is_one_form())
    };
    let before = if (0..6).any(is_summed) { values_before(case) } else { [None; 6] };
    for (cause, relation, numbers) in found_elsewhere(case, quantity) {
        for (k, row) in numbers.entries(quantity).0.iter().enumerate() {
            let Some(row) = row else { continue };
            let sum = if is_summed(k) { before[k].unwrap_or(0.0) } else { 0.0 };
            let row: Vec<f64> = row.iter().map(|x| x + sum).collect();
            let made = Hypothesis::of_row(cause, k, row.iter().copied().enumerate());
            found.push(made.related_if(relation.clone()));
            if cause == Cause::NodesSwapped && row.len() > 1 {
                if relation.as_deref() == Some(FLOWS_SWAPPED) {
                    continue;
                }
                // With columns in the right order.
                let at = |j: usize| (j + XB) % DOFS;
                let place =
                    |n: usize| if row.len() > DOFS { at(n / DOFS) * DOFS + at(n % DOFS) } else { at(n) };
                let ordered = (0..row.len()).map(|n| (n, row[place(n)]));
                found.push(Hypothesis::of_row(cause, k, ordered).related_if(relation.clone()));
            }
        }
    }
    found
}
