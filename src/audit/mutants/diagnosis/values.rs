//! What mistakes make of values: initial values, axes, turns, other functions of the same rotation.

use crate::case::quantity::{Entries, Quantity};
use crate::case::{Case, Step};
use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::MULTIPLES;
use crate::mutants::diagnosis::columns::along;
use crate::mutants::diagnosis::dictionary::PARAMETERS;
use crate::mutants::diagnosis::matching::{Gather, Hypothesis};
use crate::oracles::force::product_with_forces;
use pintle_kinematics::connector::Components;
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::node::{DOFS, Pair, XB};
use pintle_kinematics::scalar::elementary::norm;
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Matrix, apply, column, cross, dot, scale, sub, transpose, transposed_product,
};
use std::f64::consts::{PI, TAU};

/// What is given along the axes that b has at first.
pub(super) const INITIAL_AXES_OF_B: &str = "what is expected along the initial axes of b";

/// What mistakes make of values, where `want` are right and `got` were given.
pub(super) fn of_values(case: &Case, want: &Entries<f64>, got: &Entries<f64>) -> Vec<Hypothesis> {
    let Some(Step { state, .. }) = case.last() else { return Vec::new() };
    let (pair, initial) = (&state.pair, &case.definition.initial);
    let connector = case.connector();
    let (now, first) = (case.positions(), case.at_rest().positions());
    let mut earlier = case.clone();
    earlier.path.pop();
    let before = earlier.values();
    let mut found = of_rows(case, &before);
    for (k, _, f) in want.iter() {
        let Some(measure) = connector.differentiated(k) else { continue };
        let mut add = |cause: Cause, x: f64| found.push(Hypothesis::one(cause, (k, 0), x));
        let is_angle = measure.unit() == Unit::Angle;
        add(Cause::ComponentZero, 0.0);
        add(Cause::SignLost, f.abs());
        if let (Some(now), Some(first)) = (now[k], first[k]) {
            // Where the value is a position less its initial one.
            if (now - first - f).abs() <= 1e-9 * (1.0 + now.abs()) {
                add(Cause::InitialKept, now);
                add(Cause::InitialKept, now + first);
                add(Cause::InitialTwice, f - first);
                add(Cause::OtherOrder, -now - first);
                add(Cause::SignLost, now.abs() - first);
                add(Cause::SignLost, now.abs() - first.abs());
                if let Some(reference) = case.definition.references[k] {
                    let reference = if is_angle { reference.to_radians() } else { reference };
                    add(Cause::ReferenceSubtracted, now - reference);
                    add(Cause::ReferenceSubtracted, f - reference);
                }
                if is_angle {
                    of_function(k, now, first, &mut found);
                }
            }
        }
        let mut add = |cause: Cause, x: f64| found.push(Hypothesis::one(cause, (k, 0), x));
        if let Some(before) = before[k] {
            add(Cause::Increment, f - before);
        }
        if measure.is_one_form() {
            of_sums(case, (k, f, before[k].unwrap_or(0.0)), &mut found);
        }
        if is_angle {
            of_function(k, f, 0.0, &mut found);
            let mut add = |cause: Cause, x: f64| found.push(Hypothesis::one(cause, (k, 0), x));
            add(Cause::DegreesForRadians, f.to_radians());
            if let Some(got) = got.get(k, 0) {
                let turns = ((got - f) / TAU).round();
                if turns != 0.0 && turns.abs() < 1e3 {
                    let cause = if got.abs() < f.abs() { Cause::TurnForgotten } else { Cause::TurnAdded };
                    add(cause, f + TAU * turns);
                }
                let halves = ((got - f) / PI).round();
                if halves % 2.0 != 0.0 && halves.abs() < 1e3 {
                    add(Cause::WrongParity, f + PI * halves);
                }
                of_other_turns((k, f, got), &mut found);
                let mirrored = ((got + f) / PI).round();
                let mut add = |cause: Cause, x: f64| found.push(Hypothesis::one(cause, (k, 0), x));
                if mirrored % 2.0 != 0.0 && mirrored.abs() < 1e3 {
                    add(Cause::Folded, PI * mirrored - f);
                }
            }
        } else {
            for factor in [1e3, 1e-3] {
                found.row(Cause::LengthUnit, k, [(0, factor * f)], format!("{factor} × expected"));
            }
        }
        if let Some(i) = axis_of(measure) {
            for j in (0..3).filter(|j| *j != i) {
                let along = |pair: &Pair<f64>| dot(column(&pair.a.triad, j), pair.separation());
                let what = format!("the coordinate along e{}a, not e{}a", j + 1, i + 1);
                found.row(Cause::RowsSwapped, k, [(0, along(pair) - along(initial))], what);
            }
        }
    }
    found.extend(of_rotation(case, (want, got), (&now, &first)));
    found
}

/// An angle that is a multiple of the right one but for its turns, or whose turns are counted with few digits of π.
fn of_other_turns((k, f, got): (usize, f64, f64), found: &mut Vec<Hypothesis>) {
    for (factor, what) in [(0.5, "half of"), (2.0, "twice"), (-0.5, "minus half of"), (-2.0, "minus twice")] {
        let turns = ((got / factor - f) / TAU).round();
        if turns.abs() < 1e3 {
            let what = format!("{what} what is expected, turns counted apart");
            found.row(Cause::Factor, k, [(0, factor * (f + TAU * turns))], what);
        }
    }
    // So many half turns are tried, and so many digits of π, rounded or cut off.
    const HALVES: i32 = 24;
    const DIGITS: i32 = 10;
    if got == f || (got - f).abs() > 0.01 * f64::from(HALVES) {
        return;
    }
    for halves in (-HALVES..=HALVES).filter(|halves| *halves != 0) {
        let pi = PI + (got - f) / f64::from(halves);
        let written = (2..=DIGITS).map(|digits| 10.0_f64.powi(digits)).flat_map(|ten| {
            let digits = PI * ten;
            [digits.round() / ten, digits.trunc() / ten]
        });
        for written in written.filter(|written| (written - pi).abs() < 1e-14 * f64::from(HALVES)) {
            let what = format!("what is expected with {written} for π where turns are added");
            found.row(Cause::Rounded, k, [(0, f + f64::from(halves) * (written - PI))], what);
        }
    }
}

/// What is summed up over increments: the last of them along another axis, or with another multiple of one of its parts.
fn of_sums(case: &Case, (k, f, before): (usize, f64, f64), found: &mut Vec<Hypothesis>) {
    let Some((last, path)) = case.path.split_last() else { return };
    let mut add = |cause: Cause, x: f64, what: String| found.row(cause, k, [(0, x)], what);
    let from = path.last().map_or(case.definition.initial, |step| step.state.pair);
    let value_of = |pair: Pair<f64>| {
        let mut other = case.clone();
        if let Some(end) = other.path.last_mut() {
            (end.state.pair, end.increment) = (pair, Step::between(&from, pair).increment);
        }
        product_with_forces(&other)?.entries(Quantity::Value).get(k, 0)
    };
    let now = last.state.pair;
    let (mut still, mut held) = (now, now);
    (still.a.flow, still.b.flow) = (from.a.flow, from.b.flow);
    held.b.triad = from.b.triad;
    let [Some(still), Some(held)] = [still, held].map(value_of) else { return };
    let (flow, of_b) = (f - still, f - held);
    let rotations = f - before - flow;
    let of_a = rotations - of_b;
    for (part, what) in
        [(flow, "flow"), (rotations, "rotations"), (of_b, "rotation of b"), (of_a, "rotation of a")]
    {
        for (times, multiple) in MULTIPLES {
            let what = format!("what is expected {multiple} the increment of the {what}");
            add(Cause::TermLeftOut, f + times * part, what);
        }
    }
    let scale = case.definition.flow_scale;
    for (factor, what) in [
        (1.0 / scale, "without the scale β_s"),
        (1.0 / (scale * scale), "divided by β_s, which must multiply"),
    ] {
        let what = format!("what is expected, the increment of the flow {what}");
        add(Cause::NotNormalised, f + (factor - 1.0) * flow, what);
    }
    // The axis at the end of the increment, at its beginning, and their mean; and each axis of a.
    let spin = sub(last.increment.rotation[0], last.increment.rotation[1]);
    let ends = [&now.a.triad, &from.a.triad];
    for (j, name) in [(2, "e3a"), (0, "e1a"), (1, "e2a")] {
        let [end, begin] = ends.map(|triad| dot(column(triad, j), spin));
        for (x, where_) in [(end, "at the end"), (begin, "at the beginning"), ((end + begin) / 2.0, "mean")] {
            let axis = match where_ {
                "mean" => format!("the mean of {name} before and after"),
                _ => format!("{name} {where_} of it"),
            };
            let what = format!("the value before and the increment along {axis}");
            let cause = if j == 2 { Cause::AxisOfIncrement } else { Cause::OtherAxis };
            add(cause, before + flow + x, what);
        }
    }
}

/// The rows of a state.
fn rows(case: &Case) -> Entries<f64> {
    product_with_forces(case)
        .map(|numbers| numbers.entries(Quantity::FirstDerivatives).clone())
        .unwrap_or_default()
}

/// Values from rows: those of small motions about the initial state, and those of an increment.
fn of_rows(case: &Case, before: &Components<f64>) -> Vec<Hypothesis> {
    let Some((last, path)) = case.path.split_last() else { return Vec::new() };
    let initial = case.definition.initial;
    let motion = |from: &Pair<f64>| {
        let since = Step::between(from, last.state.pair).increment;
        let mut all = [0.0; DOFS];
        for (end, (now, then)) in
            [(&last.state.pair.a, &from.a), (&last.state.pair.b, &from.b)].into_iter().enumerate()
        {
            let moved = sub(now.displacement, then.displacement);
            all[XB * end..XB * end + 3].copy_from_slice(&moved);
            all[XB * end + 3..XB * end + 6].copy_from_slice(&since.rotation[end]);
            all[XB * end + 6] = now.flow - then.flow;
        }
        all
    };
    let at_rest = case.at_rest();
    let earlier =
        if path.is_empty() { at_rest.clone() } else { Case { path: path.to_vec(), ..case.clone() } };
    let from = path.last().map_or(initial, |step| step.state.pair);
    let mut found = Vec::new();
    let mut add = |cause: Cause, rows: &Entries<f64>, motion: &[f64; DOFS], before: &dyn Fn(usize) -> f64| {
        for (k, row) in rows.0.iter().enumerate() {
            let Some(row) = row else { continue };
            found.push(Hypothesis::one(cause, (k, 0), before(k) + along(row, motion)));
        }
    };
    let (total, increment) = (motion(&initial), motion(&from));
    add(Cause::Linearised, &rows(&at_rest), &total, &|_| 0.0);
    add(Cause::Linearised, &rows(case), &total, &|_| 0.0);
    let old = |k: usize| before[k].unwrap_or(0.0);
    add(Cause::Incremental, &rows(case), &increment, &old);
    add(Cause::Incremental, &rows(&earlier), &increment, &old);
    found
}

/// Which coordinate of b a measure is, if it is one.
pub(super) const fn axis_of(measure: Measure) -> Option<usize> {
    match measure {
        Measure::Position(i) | Measure::PositionAtB(i) | Measure::ProjectedPosition(i) => Some(i - 1),
        _ => None,
    }
}

/// Other functions of an angle, less the same of its initial value.
fn of_function(k: usize, now: f64, first: f64, found: &mut Vec<Hypothesis>) {
    let mut of = |cause: Cause, what: &str, f: &dyn Fn(f64) -> f64| {
        let made = Hypothesis::one(cause, (k, 0), f(now) - f(first));
        let what = (!what.is_empty()).then(|| format!("{what} of the angle, less that at first"));
        found.push(made.related_if(what));
    };
    of(Cause::OtherParameters, "the sine", &f64::sin);
    of(Cause::OtherParameters, "the tangent", &f64::tan);
    of(Cause::OtherParameters, "1 − the cosine", &|x| 1.0 - x.cos());
    of(Cause::OtherParameters, "twice the sine of half", &|x| 2.0 * (x / 2.0).sin());
    of(Cause::OtherParameters, "the sine of half", &|x| (x / 2.0).sin());
    of(Cause::OtherParameters, "twice the tangent of half", &|x| 2.0 * (x / 2.0).tan());
    of(Cause::OtherParameters, "the tangent of half", &|x| (x / 2.0).tan());
    of(Cause::Folded, "", &|x| x.sin().asin());
    of(Cause::Folded, "", &|x| x.tan().atan());
    of(Cause::SignLost, "", &|x| x.cos().acos());
}

/// Angles, or a rotation vector, by other parameters of the same relative rotation.
fn of_rotation(
    case: &Case,
    (want, got): (&Entries<f64>, &Entries<f64>),
    (now, first): (&Components<f64>, &Components<f64>),
) -> Vec<Hypothesis> {
    let Some(step) = case.last() else { return Vec::new() };
    let (pair, initial) = (&step.state.pair, &case.definition.initial);
    let connector = case.connector();
    let rotational = [3, 4, 5].map(|k| want.get(k, 0).and(connector.differentiated(k)));
    let mut found = Vec::new();
    // Three angles of the same rotation, the second one with the other sign.
    let of_own = rotational.iter().flatten().next();
    if let (Some(Measure::Euler(_) | Measure::Cardan(_)), [Some(x), Some(y), Some(z)]) =
        (of_own, [3, 4, 5].map(|k| want.get(k, 0)))
    {
        let given = [3, 4, 5].map(|k| got.get(k, 0).unwrap_or(f64::NAN));
        let middle = match (of_own, first[4]) {
            (Some(Measure::Euler(_)), Some(first)) => -y - 2.0 * first,
            (_, Some(first)) => PI - y - 2.0 * first,
            _ => f64::NAN,
        };
        for half in [PI, -PI] {
            let near = |right: f64, given: f64| right + half + TAU * ((given - right - half) / TAU).round();
            let three = [near(x, given[0]), middle, near(z, given[2])];
            let changes = three.into_iter().enumerate().map(|(i, x)| (3 + i, 0, x)).collect();
            let made = Hypothesis::many(Cause::OtherOrder, changes);
            found.push(made.related("the other three angles of the same rotation, half a turn off"));
        }
    }
    let mut add_as = |cause: Cause, what: &str, now: [f64; 3], first: [f64; 3]| {
        let said = |made: Hypothesis| made.related_if((!what.is_empty()).then_some(what));
        for i in (0..3).filter(|i| rotational[*i].is_some()) {
            found.push(said(Hypothesis::one(cause, (3 + i, 0), now[i] - first[i])));
            found.push(said(Hypothesis::one(cause, (3 + i, 0), now[i])));
        }
    };
    let q = |pair: &Pair<f64>| transposed_product(&pair.a.triad, &pair.b.triad);
    let (q, q0) = (q(pair), q(initial));
    let is_free =
        |measure: &Measure| matches!(measure, Measure::RotationVector(_) | Measure::RotationVectorAtB(_));
    let is_held = |measure: &Measure| matches!(measure, Measure::Misalignment(_));
    let is_vector = rotational.iter().flatten().all(|measure| is_free(measure) || is_held(measure));
    let principal = |q: &Matrix<f64>| match of_own {
        Some(Measure::Cardan(_)) => Some(so3::cardan(q)),
        Some(Measure::Euler(_)) => Some(so3::euler(q, 1.0)),
        _ => None,
    };
    if let (Some(now), Some(first)) = (principal(&q), principal(&q0)) {
        add_as(Cause::TurnForgotten, "the principal angles of the rotation", now, first);
    }
    let is_flexion = |of: &Measure| matches!(of, Measure::ComponentFlexion(_));
    if rotational.iter().flatten().any(is_flexion) {
        // The smallest rotation from e3a to e3b, along the directions of a or of b.
        let swing = |pair: &Pair<f64>| {
            let [a, b] = [&pair.a, &pair.b].map(|node| column(&node.triad, 2));
            let across = cross(a, b);
            let sine = norm(across);
            if sine > 0.0 { scale(across, sine.atan2(dot(a, b)) / sine) } else { across }
        };
        let (now, first) = (swing(pair), swing(initial));
        for (cause, node, old) in
            [(Cause::AxesOfA, &pair.a, &initial.a), (Cause::AxesOfB, &pair.b, &initial.b)]
        {
            let mut along = apply(&transpose(&node.triad), now);
            let mut along_first = apply(&transpose(&old.triad), first);
            // The torsion is another number.
            (along[2], along_first[2]) = (f64::NAN, f64::NAN);
            add_as(cause, "", along, along_first);
        }
    }
    if rotational.iter().flatten().any(|measure| *measure == Measure::Torsion) {
        let apart = |q: &Matrix<f64>| so3::euler_angle(q, 1.0, 1) - so3::euler_angle(q, 1.0, 3);
        let what = "the difference of the Euler angles α and γ, not their sum";
        add_as(Cause::OtherOrder, what, [apart(&q); 3], [apart(&q0); 3]);
    }
    if rotational.iter().flatten().any(is_held) {
        add_as(Cause::InitialKept, "", so3::log(&q), [0.0; 3]);
    }
    let flexions = [now, first];
    if rotational.iter().flatten().any(is_free) {
        add_as(Cause::TurnForgotten, "the principal rotation vector", so3::log(&q), so3::log(&q0));
    }
    let vector = |all: &Components<f64>| Some([all[3]?, all[4]?, all[5]?]);
    let held = || Some([0, 1, 2].map(|i| want.get(3 + i, 0)).map(|x| x.unwrap_or(0.0)));
    let is_misalignment = rotational.iter().flatten().any(is_held);
    let (now, first) = if is_misalignment { (held(), Some([0.0; 3])) } else { (vector(now), vector(first)) };
    // Of a flexion α q the first two numbers are such a vector.
    let bent = |all: &Components<f64>| Some([all[3]?, all[4]?, 0.0]);
    let is_bent = !is_vector && rotational.iter().flatten().any(is_flexion);
    let (now, first) = if is_bent { flexions.map(bent).into() } else { (now, first) };
    if let (Some(now), Some(first), true) = (now, first, is_vector || is_bent) {
        // The torsion beside a flexion is another number.
        let alone = |[x, y, z]: [f64; 3]| if is_bent { [x, y, f64::NAN] } else { [x, y, z] };
        for (what, length) in PARAMETERS {
            let to = |v: [f64; 3]| {
                let angle = norm(v);
                if angle > 0.0 { scale(v, length(angle)[0] / angle) } else { v }
            };
            add_as(Cause::OtherParameters, what, alone(to(now)), alone(to(first)));
        }
        if is_bent {
            return found;
        }
        add_as(Cause::GlobalAxes, "", apply(&pair.a.triad, now), apply(&initial.a.triad, first));
        add_as(Cause::AxesOfB, "", apply(&transpose(&q), now), apply(&transpose(&q0), first));
        let [now, first] = [apply(&pair.a.triad, now), apply(&initial.a.triad, first)];
        for (node, relation) in [(&initial.a, ""), (&initial.b, INITIAL_AXES_OF_B)] {
            let still = transpose(&node.triad);
            add_as(Cause::InitialAxes, relation, apply(&still, now), apply(&still, first));
        }
    }
    found
}
