//! What else of the nodes a number may be, each with its formula in words:
//!
//! - coordinates along other axes, and other lengths;
//! - angles of other sequences, rotation vectors and cosines of other relative rotations;
//! - functions of them.
//!
//! All are formed on dual numbers, so that rows, rates and accelerations of a mistake are known as its values are.

use crate::case::quantity::{Entries, Quantity};
use crate::case::{Case, Step, initial_places};
use crate::mutants::cause::Cause;
use crate::mutants::diagnosis::elsewhere::beside;
use crate::mutants::diagnosis::matching::Hypothesis;
use num_dual::{Dual2, DualSVec64};
use pintle_kinematics::measure::{Measure, Unit};
use pintle_kinematics::node::{DOFS, Pair};
use pintle_kinematics::scalar::elementary::{abs, atan2, direction, norm, recip};
use pintle_kinematics::scalar::{MAX_ORDER, Scalar, Seeded};
use pintle_kinematics::so3;
use pintle_kinematics::vector::{
    Matrix, Vector, add, apply_transposed, column, constant, product, scale, sub, transpose,
    transposed_product,
};

/// A number is looked at more closely where all of its entries are met to this part of the largest.
const MET: f64 = 1e-8;

/// A number of the nodes.
struct Item<S> {
    cause: Cause,
    unit: Unit,
    formula: Formula,
    x: S,
}

/// A formula, in words where they are wanted. Of three numbers it has the place of this one.
#[derive(Clone, Copy)]
enum Formula {
    /// As it is said.
    Said(&'static str),
    /// The coordinate of a vector along an axis of a frame.
    Coordinate(&'static str, usize, &'static str),
    /// |d₁| + |d₂| + |d₃| along the axes of a frame.
    Sum(&'static str),
    /// The distance from an axis of a frame.
    FromAxis(usize, &'static str),
    /// The magnitude of a vector.
    Magnitude(&'static str),
    /// An angle of a sequence of axes, of a rotation.
    Angle([usize; 3], usize, &'static str),
    /// A component of the rotation vector of a rotation.
    Component(usize, &'static str),
    /// The whole angle of a rotation.
    Whole(&'static str),
    /// The torsion of a rotation.
    Torsion(&'static str),
    /// A component of parameters, of a rotation.
    Parameter(&'static str, usize, &'static str),
    /// Entry n of a rotation, by rows.
    Entry(usize, &'static str),
    /// atan2 of two entries of Q, the second with a sign.
    OfEntries(usize, &'static str, usize),
    /// A component of φ_b − φ_a along axes.
    Apart(usize, &'static str),
}

impl Formula {
    /// In words; what component k equals where it has the place of this one.
    fn said(self, k: usize) -> String {
        let is = |place: usize| place == k % 3;
        let entry = |n: usize| format!("{}{}", n / 3 + 1, n % 3 + 1);
        match self {
            Self::Said(words) => words.into(),
            Self::Coordinate(name, i, of) if is(i) => {
                format!("the coordinate of {name} along the axis of {of}")
            }
            Self::Coordinate(name, i, of) => format!("the coordinate of {name} along e{} of {of}", i + 1),
            Self::Sum(of) => format!("|d₁| + |d₂| + |d₃| along the axes of {of}"),
            Self::FromAxis(i, of) => format!("the distance from the axis e{} of {of}", i + 1),
            Self::Magnitude(name) => format!("|{name}|"),
            Self::Angle(axes, n, of) => {
                let named = axes.map(|axis| format!("e{}", axis + 1)).join(" ");
                let place = ["first ", "second ", "third "][n];
                format!("the {}angle of the sequence {named} of {of}", if is(n) { "" } else { place })
            }
            Self::Component(i, of) if is(i) => format!("the rotation vector of {of}"),
            Self::Component(i, of) => format!("component {} of the rotation vector of {of}", i + 1),
            Self::Whole(of) => format!("the whole angle of {of}"),
            Self::Torsion(of) => format!("the torsion of {of}"),
            Self::Parameter(name, i, of) if is(i) => format!("{name}, of {of}"),
            Self::Parameter(name, i, of) => format!("component {} of {name}, of {of}", i + 1),
            Self::Entry(n, of) => format!("entry {} of {of}", entry(n)),
            Self::OfEntries(m, sign, n) => {
                format!("the angle atan2(Q{}, {sign}Q{}) of two entries of Q = AᵀB", entry(m), entry(n))
            }
            Self::Apart(i, of) => {
                let component = if is(i) { String::new() } else { format!("component {} of ", i + 1) };
                format!("{component}the difference φ_b − φ_a of the rotation vectors of the nodes{of}")
            }
        }
    }
}

/// A function f(x) with what its initial value x₀ has to do with it: Taylor coefficients f, f′, f″/2.
struct Function {
    of: Unit,
    /// `x` stands for its argument, `x₀` for that at the initial state.
    formula: &'static str,
    taylor: fn(f64, f64) -> [f64; 3],
}

/// A function of a part of an angle, less the same at first.
macro_rules! of_part {
    ($x:ident, $first:ident, $part:expr, $f:expr, $slope:expr, $half:expr) => {{
        let f: fn(f64) -> f64 = $f;
        let slope: fn(f64) -> f64 = $slope;
        let half: fn(f64) -> f64 = $half;
        [f($part * $x) - f($part * $first), $part * slope($part * $x), $part * $part * half($part * $x)]
    }};
}

const TAN_SLOPE: fn(f64) -> f64 = |x| x.tan().mul_add(x.tan(), 1.0);
const TAN_HALF: fn(f64) -> f64 = |x| x.tan() * TAN_SLOPE(x);

/// The functions that strains, squares, quaternions and cosines are.
const FUNCTIONS: [Function; 18] = {
    const fn of(of: Unit, formula: &'static str, taylor: fn(f64, f64) -> [f64; 3]) -> Function {
        Function { of, formula, taylor }
    }
    use Unit::{Angle, Length};
    [
        of(Length, "x² − x₀²", |x, o| [x * x - o * o, 2.0 * x, 1.0]),
        of(Length, "(x² − x₀²)/2", |x, o| [(x * x - o * o) / 2.0, x, 0.5]),
        of(Length, "(x² − x₀²)/(2 x₀)", |x, o| [(x * x - o * o) / (2.0 * o), x / o, 0.5 / o]),
        of(Length, "(x² − x₀²)/(2 x₀²)", |x, o| {
            [(x * x - o * o) / (2.0 * o * o), x / (o * o), 0.5 / (o * o)]
        }),
        of(Length, "ln(x/x₀)", |x, o| [(x / o).ln(), 1.0 / x, -0.5 / (x * x)]),
        of(Length, "x₀ ln(x/x₀)", |x, o| [o * (x / o).ln(), o / x, -0.5 * o / (x * x)]),
        of(Length, "ln((1 + x)/(1 + x₀))", |x, o| {
            [x.ln_1p() - o.ln_1p(), 1.0 / (1.0 + x), -0.5 / ((1.0 + x) * (1.0 + x))]
        }),
        of(Length, "(x − x₀)/x₀", |x, o| [(x - o) / o, 1.0 / o, 0.0]),
        of(Length, "(x − x₀)/x", |x, o| [(x - o) / x, o / (x * x), -o / (x * x * x)]),
        of(Angle, "sin x − sin x₀", |x, o| of_part!(x, o, 1.0, f64::sin, f64::cos, |x| -x.sin() / 2.0)),
        of(Angle, "cos x₀ − cos x", |x, o| {
            of_part!(x, o, 1.0, |x| -x.cos(), f64::sin, |x| x.cos() / 2.0)
        }),
        of(Angle, "tan x − tan x₀", |x, o| of_part!(x, o, 1.0, f64::tan, TAN_SLOPE, TAN_HALF)),
        of(Angle, "sin(x/2) − sin(x₀/2)", |x, o| {
            of_part!(x, o, 0.5, f64::sin, f64::cos, |x| -x.sin() / 2.0)
        }),
        of(Angle, "2 sin(x/2) − 2 sin(x₀/2)", |x, o| {
            of_part!(x, o, 0.5, |x| 2.0 * x.sin(), |x| 2.0 * x.cos(), |x| -x.sin())
        }),
        of(Angle, "tan(x/2) − tan(x₀/2)", |x, o| of_part!(x, o, 0.5, f64::tan, TAN_SLOPE, TAN_HALF)),
        of(Angle, "2 tan(x/2) − 2 tan(x₀/2)", |x, o| {
            of_part!(x, o, 0.5, |x| 2.0 * x.tan(), |x| 2.0 * TAN_SLOPE(x), |x| 2.0 * TAN_HALF(x))
        }),
        of(Angle, "4 tan(x/4) − 4 tan(x₀/4)", |x, o| {
            of_part!(x, o, 0.25, |x| 4.0 * x.tan(), |x| 4.0 * TAN_SLOPE(x), |x| 4.0 * TAN_HALF(x))
        }),
        of(Angle, "x − x₀ in turns", |x, o| {
            [(x - o) / std::f64::consts::TAU, 1.0 / std::f64::consts::TAU, 0.0]
        }),
    ]
};

/// What is the length of parameters where the rotation vector has the length θ, with Taylor coefficients f, f′, f″/2.
type Length = fn(f64) -> [f64; 3];

/// The parameters of a rotation by θ about n that are not its rotation vector.
pub(crate) const PARAMETERS: [(&str, Length); 7] = [
    ("sin θ n, the axial vector", |x| [x.sin(), x.cos(), -x.sin() / 2.0]),
    ("2 sin θ n, twice the axial vector", |x| [2.0 * x.sin(), 2.0 * x.cos(), -x.sin()]),
    ("2 sin(θ/2) n, twice the quaternion's vector", |x| {
        [2.0 * (x / 2.0).sin(), (x / 2.0).cos(), -(x / 2.0).sin() / 4.0]
    }),
    ("sin(θ/2) n, the quaternion's vector", |x| {
        [(x / 2.0).sin(), (x / 2.0).cos() / 2.0, -(x / 2.0).sin() / 8.0]
    }),
    ("2 tan(θ/2) n, twice the Rodrigues vector", |x| {
        [2.0 * (x / 2.0).tan(), TAN_SLOPE(x / 2.0), TAN_HALF(x / 2.0) / 2.0]
    }),
    ("tan(θ/2) n, the Rodrigues vector", |x| {
        [(x / 2.0).tan(), TAN_SLOPE(x / 2.0) / 2.0, TAN_HALF(x / 2.0) / 4.0]
    }),
    ("4 tan(θ/4) n, the Wiener-Milenković vector", |x| {
        [4.0 * (x / 4.0).tan(), TAN_SLOPE(x / 4.0), TAN_HALF(x / 4.0) / 4.0]
    }),
];

/// Lengths: coordinates of d = x_b − x_a, and distances, by the axes of any frame.
fn lengths<S: Scalar<Real = f64>>(
    pair: &Pair<S>,
    initial: &Pair<f64>,
    before: &Pair<f64>,
    [first, second]: [Vector<f64>; 2],
    mut add_item: impl FnMut(Cause, Formula, S),
) {
    let lifted = |m: &Matrix<f64>| m.map(constant);
    let (d, d0) = (pair.separation(), constant(initial.separation()));
    let midway: Matrix<S> = {
        let sums = [0, 1, 2].map(|i| direction(add(column(&pair.a.triad, i), column(&pair.b.triad, i))));
        transpose(&sums)
    };
    let half: Matrix<S> = {
        let sums = [0, 1, 2].map(|i| scale(add(column(&pair.a.triad, i), column(&pair.b.triad, i)), 0.5));
        transpose(&sums)
    };
    let identity: Matrix<S> = pintle_kinematics::vector::identity();
    let frames: [(&str, Cause, Matrix<S>); 10] = [
        ("a", Cause::AxesOfA, pair.a.triad),
        ("b", Cause::AxesOfB, pair.b.triad),
        ("a at first", Cause::InitialAxes, lifted(&initial.a.triad)),
        ("b at first", Cause::InitialAxes, lifted(&initial.b.triad)),
        ("a and b midway", Cause::AxesMidway, midway),
        ("½ (a + b), shorter than 1", Cause::NotNormalised, half),
        ("a at the state before", Cause::StateBefore, lifted(&before.a.triad)),
        ("b at the state before", Cause::StateBefore, lifted(&before.b.triad)),
        ("the global frame", Cause::GlobalAxes, identity),
        ("a, rows for columns", Cause::TriadsTransposed, transpose(&pair.a.triad)),
    ];
    let vectors = [
        ("d", None, d),
        ("(d − d₀)", Some(Cause::InitialTurned), sub(d, d0)),
        ("x_b", Some(Cause::OtherLength), add(pair.b.displacement, constant(second))),
        ("x_a", Some(Cause::OtherLength), add(pair.a.displacement, constant(first))),
        ("u_b", Some(Cause::MotionIgnored), pair.b.displacement),
        ("u_a", Some(Cause::MotionIgnored), pair.a.displacement),
    ];
    for (of, cause, frame) in frames {
        for (name, of_vector, vector) in vectors {
            let along = apply_transposed(&frame, vector);
            for i in 0..3 {
                add_item(of_vector.unwrap_or(cause), Formula::Coordinate(name, i, of), along[i]);
            }
            if of_vector.is_none() {
                let magnitudes = along.map(abs);
                let sum = magnitudes[0] + magnitudes[1] + magnitudes[2];
                add_item(Cause::OtherLength, Formula::Sum(of), sum);
                for i in 0..3 {
                    let [j, k] = [(i + 1) % 3, (i + 2) % 3];
                    let across = norm([along[j], along[k]]);
                    add_item(Cause::OtherLength, Formula::FromAxis(i, of), across);
                }
            }
        }
    }
    add_item(Cause::OtherLength, Formula::Said("the whole length |d|"), norm(d));
    add_item(Cause::OtherLength, Formula::Said("|d − d₀|"), norm(sub(d, d0)));
    for (name, vector) in [vectors[2], vectors[3]].map(|(name, _, vector)| (name, vector)) {
        add_item(Cause::OtherLength, Formula::Magnitude(name), norm(vector));
    }
    let flows = pair.b.flow - pair.a.flow;
    add_item(Cause::OtherParameters, Formula::Said("Ψ_b − Ψ_a"), flows);
}

/// What the strain l/l_ref − 1 of a belt ([`Measure::Strain`]) may be else: l = |d|, l_ref = l₀ + Ψ_a − Ψ_b, l₀ the material length at first.
fn strains<S: Scalar<Real = f64>>(pair: &Pair<S>, l0: f64, mut add_item: impl FnMut(Cause, Formula, S)) {
    let l = norm(pair.separation());
    let (a, b, l0) = (pair.a.flow, pair.b.flow, S::from_real(l0));
    let reference = l0 + a - b;
    let one = S::one();
    let over = |x: S, y: S| x * recip(y);
    let mut add = |cause: Cause, words: &'static str, x: S| add_item(cause, Formula::Said(words), x);
    add(Cause::OtherLength, "l/l_ref", over(l, reference));
    add(Cause::OtherLength, "the elongation l − l_ref, not divided by l_ref", l - reference);
    add(Cause::OtherLength, "(l − l_ref)/l, divided by the length now", one - over(reference, l));
    let green = over(l, reference) * over(l, reference) - one;
    add(Cause::OtherLength, "(l² − l_ref²)/(2 l_ref²), Green's strain", green * S::from_real(0.5));
    add(Cause::OtherLength, "ln(l/l_ref), the logarithmic strain", {
        let x = over(l, reference);
        lift(x, [x.real().ln(), 1.0 / x.real(), -0.5 / (x.real() * x.real())])
    });
    add(
        Cause::InitialKept,
        "(l − l_ref)/l₀, divided by the material length at first",
        over(l - reference, l0),
    );
    add(Cause::MotionIgnored, "l/l₀ − 1, without the flows", over(l, l0));
    for (words, other) in [
        ("l/(l₀ − Ψ_a + Ψ_b) − 1, the flows of the other sign", l0 - a + b),
        ("l/(l₀ + Ψ_a) − 1, without the flow of b", l0 + a),
        ("l/(l₀ − Ψ_b) − 1, without the flow of a", l0 - b),
        ("l/(l₀ + Ψ_a + Ψ_b) − 1, the flow of b of the other sign", l0 + a + b),
        ("l/(l₀ − Ψ_a − Ψ_b) − 1, the flow of a of the other sign", l0 - a - b),
    ] {
        add(Cause::FlowColumn, words, over(l, other));
    }
}

/// The angles of every sequence of three axes, in the order of the rotations: three different axes, then the first one twice.
fn sequences<S: Scalar>(r: &Matrix<S>) -> Vec<([usize; 3], [S; 3])> {
    let mut found = Vec::new();
    for i in 0..3 {
        for (j, is_cyclic) in [((i + 1) % 3, true), ((i + 2) % 3, false)] {
            let k = 3 - i - j;
            let signed = |x: S| if is_cyclic { x } else { -x };
            let three = [
                atan2(-signed(r[j][k]), r[k][k]),
                atan2(signed(r[i][k]), norm([r[i][i], r[i][j]])),
                atan2(-signed(r[i][j]), r[i][i]),
            ];
            let two = [
                atan2(r[j][i], -signed(r[k][i])),
                atan2(norm([r[i][j], r[i][k]]), r[i][i]),
                atan2(r[i][j], signed(r[i][k])),
            ];
            found.extend([([i, j, k], three), ([i, j, i], two)]);
        }
    }
    found
}

/// Angles of any relative rotation.
fn angles<S: Scalar<Real = f64>>(
    pair: &Pair<S>,
    initial: &Pair<f64>,
    mut add_item: impl FnMut(Cause, Formula, S),
) {
    let lifted = |m: &Matrix<f64>| m.map(constant);
    let (a, b) = (&pair.a.triad, &pair.b.triad);
    let (a0, b0): (Matrix<S>, Matrix<S>) = (lifted(&initial.a.triad), lifted(&initial.b.triad));
    let (q, q0) = (transposed_product(a, b), transposed_product(&a0, &b0));
    let since = |now: &Matrix<S>, first: &Matrix<S>| product(now, &transpose(first));
    let (of_a, of_b) = (since(a, &a0), since(b, &b0));
    let rotations: [(&str, Cause, Matrix<S>); 11] = [
        ("Q = AᵀB", Cause::OtherParameters, q),
        ("Qᵀ = BᵀA", Cause::NodesSwapped, transpose(&q)),
        ("Q Q₀ᵀ", Cause::OtherParameters, since(&q, &q0)),
        ("Q₀ᵀ Q", Cause::OtherParameters, transposed_product(&q0, &q)),
        ("B Aᵀ", Cause::GlobalAxes, since(b, a)),
        ("A Bᵀ", Cause::GlobalAxes, since(a, b)),
        ("B B₀ᵀ A₀ Aᵀ", Cause::GlobalAxes, since(&of_b, &of_a)),
        ("A A₀ᵀ, the rotation of a", Cause::MotionIgnored, of_a),
        ("B B₀ᵀ, the rotation of b", Cause::MotionIgnored, of_b),
        ("A₀ᵀ B", Cause::MotionIgnored, transposed_product(&a0, b)),
        ("Aᵀ B₀", Cause::MotionIgnored, transposed_product(a, &b0)),
    ];
    for (of, cause, r) in rotations {
        for (axes, three) in sequences(&r) {
            let is_relative = matches!(cause, Cause::OtherParameters | Cause::NodesSwapped);
            let of_sequence = if is_relative { Cause::OtherOrder } else { cause };
            for (n, x) in three.into_iter().enumerate() {
                add_item(of_sequence, Formula::Angle(axes, n, of), x);
            }
        }
        let vector = so3::log(&r);
        for (i, x) in vector.into_iter().enumerate() {
            add_item(cause, Formula::Component(i, of), x);
        }
        let length = norm(vector);
        add_item(cause, Formula::Whole(of), length);
        add_item(cause, Formula::Torsion(of), so3::torsion(&r));
        let along = direction(vector);
        for (name, function) in PARAMETERS {
            let made = lift(length, function(length.real()));
            for (i, x) in along.into_iter().enumerate() {
                add_item(Cause::OtherParameters, Formula::Parameter(name, i, of), x * made);
            }
        }
        for (n, x) in r.as_flattened().iter().enumerate() {
            add_item(Cause::OtherParameters, Formula::Entry(n, of), *x);
        }
    }
    // An index or a sign mistyped.
    let entries = q.as_flattened();
    for (m, y) in entries.iter().enumerate() {
        for (n, x) in entries.iter().enumerate().filter(|(n, _)| *n != m) {
            for (sign, x) in [("", *x), ("−", -*x)] {
                add_item(Cause::OtherOrder, Formula::OfEntries(m, sign, n), atan2(*y, x));
            }
        }
    }
    let apart = sub(so3::log(&of_b), so3::log(&of_a));
    for (of, along) in [
        ("", apart),
        (" along the axes of a", apply_transposed(a, apart)),
        (" along the axes of a at first", apply_transposed(&a0, apart)),
    ] {
        for (i, x) in along.into_iter().enumerate() {
            add_item(Cause::OtherParameters, Formula::Apart(i, of), x);
        }
    }
}

/// A function whose Taylor coefficients at x are these, of a number with two orders of derivatives at most.
fn lift<S: Scalar<Real = f64>>(x: S, taylor: [f64; 3]) -> S {
    const { assert!(S::ORDER <= 2, "three coefficients are given") }
    let mut all = [0.0; MAX_ORDER + 1];
    all[..3].copy_from_slice(&taylor);
    x.lift(&all)
}

/// All of them at a pair of nodes, whose initial places are given.
fn items<S: Scalar<Real = f64>>(
    pair: &Pair<S>,
    initial: &Pair<f64>,
    before: &Pair<f64>,
    (places, units): ([Vector<f64>; 2], &[Unit]),
    belt: Option<f64>,
) -> Vec<Item<S>> {
    let mut found = Vec::new();
    if let Some(l0) = belt {
        strains(pair, l0, |cause, formula, x| {
            found.push(Item { cause, unit: Unit::Length, formula, x });
        });
    }
    if units.contains(&Unit::Length) {
        lengths(pair, initial, before, places, |cause, formula, x| {
            found.push(Item { cause, unit: Unit::Length, formula, x });
        });
    }
    if units.contains(&Unit::Angle) {
        angles(pair, initial, |cause, formula, x| {
            found.push(Item { cause, unit: Unit::Angle, formula, x });
        });
    }
    found
}

/// What numbers may be else, and how many were tried for each.
#[derive(Default)]
pub(super) struct Found {
    pub(super) hypotheses: Vec<Hypothesis>,
    pub(super) tried: usize,
}

/// What else the numbers given may be.
pub(super) fn of_dictionary(
    case: &Case,
    quantity: Quantity,
    want: &Entries<f64>,
    got: &Entries<f64>,
) -> Found {
    let Some(Step { state, .. }) = case.last() else { return Found::default() };
    match quantity {
        Quantity::Value => found(case, "", (&[0.0; DOFS], |x: f64| [x]), want, got),
        Quantity::FirstDerivatives | Quantity::NodalForces => {
            let seeds = std::array::from_fn(|j| <DualSVec64<DOFS> as Seeded<DOFS>>::seed(0.0, j));
            let read = |x: DualSVec64<DOFS>| x.gradient();
            found(case, "the row of ", (&seeds, read), want, got)
        }
        Quantity::Rate | Quantity::Acceleration => {
            let seeds: [Dual2<f64>; DOFS] =
                std::array::from_fn(|j| Dual2::new(0.0, state.velocity[j], state.acceleration[j]));
            let is_rate = quantity == Quantity::Rate;
            let read = move |x: Dual2<f64>| [if is_rate { x.v1 } else { x.v2 }];
            let of = if is_rate { "the rate of " } else { "the acceleration of " };
            found(case, of, (&seeds, read), want, got)
        }
        _ => Found::default(),
    }
}

/// Whether numbers agree, to a part of the largest.
fn is_met(made: &[f64], by: &[f64]) -> bool {
    let (mut largest, mut error) = (0.0_f64, 0.0_f64);
    for (x, y) in made.iter().zip(by) {
        let off = (x - y).abs();
        if off.is_nan() {
            return false;
        }
        largest = largest.max(x.abs()).max(y.abs());
        error = error.max(off);
    }
    error <= MET * largest
}

fn found<S: Scalar<Real = f64>, const N: usize>(
    case: &Case,
    of: &str,
    (seeds, read): (&[S; DOFS], impl Fn(S) -> [f64; N]),
    want: &Entries<f64>,
    got: &Entries<f64>,
) -> Found {
    let Some((last, path)) = case.path.split_last() else { return Found::default() };
    let initial = &case.definition.initial;
    let before = path.last().map_or(initial, |step| &step.state.pair);
    let connector = case.connector();
    // A pure number is a cosine, or the strain of a belt.
    let is_strain = |measure: Option<Measure>| measure == Some(Measure::Strain);
    let unit = |measure: Measure| match measure.unit() {
        Unit::Length => Unit::Length,
        _ if is_strain(Some(measure)) => Unit::Length,
        _ => Unit::Angle,
    };
    let units: [Option<Unit>; 6] = std::array::from_fn(|k| connector.differentiated(k).map(unit));
    let distances: [bool; 6] = std::array::from_fn(|k| {
        matches!(connector.differentiated(k), Some(Measure::Distance | Measure::RadialDistance))
    });
    let present: Vec<Unit> = units.into_iter().flatten().collect();
    let [own_now, own_first] = [case.positions(), case.at_rest().positions()];
    let places = initial_places(initial.reference, case.definition.planar);
    // The material length at first: l/(1 + ε) less the flows.
    let belt = (0..6).find(|k| is_strain(connector.differentiated(*k))).and_then(|k| own_first[k]);
    let belt = belt
        .map(|strain| norm(initial.separation()) / (1.0 + strain) - initial.a.flow + initial.b.flow)
        .filter(|length| length.is_finite() && *length != 0.0);
    let all = items(&last.state.pair.moved(seeds), initial, before, (places, &present), belt);
    let at_first = items(initial, initial, initial, (places, &present), belt);
    let mut found = Found::default();
    for (k, wanted) in want.0.iter().enumerate() {
        let (Some(wanted), Some(given), Some(unit)) = (wanted, &got.0[k], units[k]) else { continue };
        let winds = connector.differentiated(k).is_some_and(Measure::winds);
        let mut tried = 0;
        let other = if unit == Unit::Angle { Cause::OtherParameters } else { Cause::OtherLength };
        if is_met(wanted, given) {
            continue;
        }
        let mut add = |cause: Cause, formula: &dyn Fn() -> String, x: S| {
            // Minus the angles of Qᵀ are those of Q.
            let signs = if cause == Cause::NodesSwapped { 1 } else { 2 };
            for (sign, x) in [("", x), ("−", -x)].into_iter().take(signs) {
                tried += 1;
                let mut made = read(x);
                if let ([x], [given], [wanted], true) =
                    (&mut made[..], &given[..], &wanted[..], S::ORDER == 0 && winds)
                {
                    *x = beside(*x, *given, *wanted);
                }
                if !is_met(&made, given) {
                    continue;
                }
                let minus = if sign.is_empty() { "" } else { "minus " };
                let said = format!("{minus}{of}{}", formula());
                let made = Hypothesis::of_row(cause, k, made.into_iter().enumerate());
                found.hypotheses.push(Hypothesis { is_searched: true, ..made.related(said) });
            }
        };
        if let (0, Some(now), Some(first)) = (S::ORDER, own_now[k], own_first[k]) {
            let is_angle = connector.differentiated(k).is_some_and(|m| m.unit() == Unit::Angle);
            for function in FUNCTIONS.iter().filter(|function| (function.of == Unit::Angle) == is_angle) {
                let [made, ..] = (function.taylor)(now, first);
                let cause = if is_angle { Cause::OtherParameters } else { Cause::OtherLength };
                add(cause, &|| format!("{}, x the position", function.formula), S::from_real(made));
            }
        }
        for (item, first) in all.iter().zip(&at_first).filter(|(item, _)| item.unit == unit) {
            let Item { cause, formula, x, .. } = item;
            let formula = || formula.said(k);
            // A distance has no axis that could be mistaken.
            let cause = if distances[k] { Cause::OtherLength } else { *cause };
            let since = *x - S::from_real(first.x);
            let is_own = is_met(&read(since), wanted);
            let is_value = S::ORDER == 0;
            if !is_met(&read(*x), wanted) {
                let cause = if is_value && is_own { Cause::InitialKept } else { cause };
                add(cause, &formula, *x);
            }
            // Derivatives know of no initial value.
            if is_value && !is_own {
                add(cause, &|| format!("the change of {}", formula()), since);
            }
            if let Some(own) =
                own_first[k].filter(|own| is_value && *own != 0.0 && (own - first.x).abs() > MET)
            {
                let less = *x - S::from_real(own);
                if !is_met(&read(less), wanted) {
                    add(cause, &|| format!("{}, less the initial value of the component", formula()), less);
                }
                // Minus that is minus the number, less the initial value.
                let sum = *x + S::from_real(own);
                add(
                    cause,
                    &|| format!("the sum of {} and the initial value of the component", formula()),
                    sum,
                );
            }
            for function in FUNCTIONS.iter().filter(|function| function.of == unit) {
                let made = lift(*x, (function.taylor)(x.real(), first.x));
                add(other, &|| format!("{}, x {}", function.formula, formula()), made);
            }
        }
        found.tried = found.tried.max(tried);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::{Dual2, FUNCTIONS, Seeded, initial_places, is_met, items};
    use crate::case::quantity::Quantity;
    use crate::oracles::force::product_with_forces;
    use crate::sampling::{Region, draw_case};
    use num_dual::DualSVec64;
    use pintle_kinematics::catalog::ConnectionType;
    use pintle_kinematics::draw::Draw;
    use pintle_kinematics::measure::Unit;
    use pintle_kinematics::node::DOFS;

    /// Coordinates, lengths and angles of the types that they define are among the numbers. They have the values, rows, rates and accelerations
    /// of the catalogue's formulas, which share none of this.
    #[test]
    fn numbers_of_the_catalogue_are_in_it() {
        let mut compared = 0;
        for (name, of) in [
            ("CARTESIAN", 0..3),
            ("AXIAL", 0..1),
            ("RADIAL-THRUST", 0..1),
            ("CARDAN", 3..6),
            ("EULER", 3..6),
            ("ROTATION", 3..6),
            ("FLEXION-TORSION", 3..4),
        ] {
            for n in 0..6 {
                let mut draw = Draw::new(&format!("dictionary {name} {n}"));
                let connection = ConnectionType::named(name, None).unwrap();
                let case = draw_case(&connection, Region::Wide, &mut draw).unwrap();
                let (state, initial) = (&case.last().unwrap().state, &case.definition.initial);
                let right = product_with_forces(&case).unwrap();
                let unit = [if of.start < 3 { Unit::Length } else { Unit::Angle }];
                let rows = std::array::from_fn(|j| <DualSVec64<DOFS> as Seeded<DOFS>>::seed(0.0, j));
                let places = initial_places(initial.reference, false);
                let rows = items(&state.pair.moved(&rows), initial, initial, (places, &unit), None);
                let rates: [Dual2<f64>; DOFS] =
                    std::array::from_fn(|j| Dual2::new(0.0, state.velocity[j], state.acceleration[j]));
                let rates = items(&state.pair.moved(&rates), initial, initial, (places, &unit), None);
                for k in of.clone() {
                    let want = |quantity: Quantity| right.entries(quantity).0[k].clone().unwrap();
                    let row = want(Quantity::FirstDerivatives);
                    let moves = [want(Quantity::Rate), want(Quantity::Acceleration)].concat();
                    let has_row = |n: &usize| is_met(&rows[*n].x.gradient(), &row);
                    let found = (0..rows.len()).filter(has_row).find(|n| {
                        let x = rates[*n].x;
                        is_met(&[x.v1], &moves[..1]) && is_met(&[x.v2], &moves[1..])
                    });
                    assert!(found.is_some(), "{name}, component {k}, state {n}");
                    compared += 1;
                }
            }
        }
        assert_eq!(compared, 6 * (3 + 1 + 1 + 3 + 3 + 3 + 1));
    }

    /// The derivatives of each function are those of its values; zero where nothing has moved.
    #[test]
    fn functions_have_their_derivatives() {
        let h = 1e-4;
        for function in &FUNCTIONS {
            for (x, first) in [(0.7, 0.4), (1.3, 0.9)] {
                let at = |x: f64| (function.taylor)(x, first);
                let [[f, slope, half], [up, ..], [down, ..]] = [at(x), at(x + h), at(x - h)];
                let differences = [(up - down) / (2.0 * h), (up - 2.0 * f + down) / (2.0 * h * h)];
                for (told, found) in [slope, half].into_iter().zip(differences) {
                    assert!(
                        (told - found).abs() < 1e-6 * (1.0 + told.abs()),
                        "{}: {told} {found}",
                        function.formula
                    );
                }
                assert!((function.taylor)(x, x)[0].abs() < 1e-15, "{}", function.formula);
            }
        }
    }
}
