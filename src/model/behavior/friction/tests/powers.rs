//! Sums of powers against their formulas typed by hand, and the unknowns in which those below 2 are curved finitely.

use crate::behavior::friction::derived::{Contribution, Derived, DerivedPart, Form, Potential};
use crate::behavior::friction::flags::{Flag, Flags};
use crate::behavior::friction::stretch::Stretch;
use crate::behavior::friction::{Context, Ordered};
use pintle_kinematics::scalar::Duals;
use pintle_kinematics::scalar::{Scalar, Seeded};
use pintle_scene::{Operator, PotentialFunction, PotentialOperator};

type First = <f64 as Duals>::Gradient<6>;
type Second = <f64 as Duals>::Hessian<6>;

/// |f_k/R|^α.
pub(super) fn term(k: usize, scale: f64, exponent: f64) -> Contribution {
    let of = Form::Component(k);
    Contribution { of, scale, exponent, function: PotentialFunction::Abs, shift: 0.0, sign: 1.0 }
}

/// |f_i op f_j|^α.
fn joined(operator: Operator, components: &[usize], exponent: f64) -> Contribution {
    let components = components.to_vec();
    let part = DerivedPart { operator, sign: 1.0, components, scale: None, independent: None };
    Contribution { of: Form::Derived(Derived { parts: vec![part] }), ..term(0, 1.0, exponent) }
}

pub(super) fn sum(beta: f64, terms: &[Contribution]) -> Potential {
    Potential::new(PotentialOperator::Sum, beta, terms.to_vec()).unwrap()
}

fn evaluated<S>(potential: &Potential, t: [S; 6], unit: f64) -> (S, Vec<Flag>)
where
    S: Scalar<Real = f64>,
    f64: Ordered,
{
    let mut flags = Flags::default();
    let p = potential.evaluate(&t, S::from_real(unit), &Context::default(), &mut flags);
    (p, flags.into_vec())
}

fn first(t: [f64; 6]) -> [First; 6] {
    [0, 1, 2, 3, 4, 5].map(|k| First::seed(t[k], k))
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 2e-14 * b.abs()
}

/// p(t) = P(K t)/K with P = (|f1/R|^α + |f2|^δ + f3²)^(1/β) at f3 = 0, where only the square is curved: ∂²P/∂f3² = (2/β) P^(1 − β).
#[test]
fn sums_of_powers_are_their_formulas() {
    let (unit, scale, t) = (8.0, 1.25, [0.75, -0.5, 0.0, 0.0, 0.0, 0.0]);
    for (beta, alpha, delta) in
        [(1.0, 1.5, 3.0), (3.0, 3.0, 1.5), (0.75, 1.5, 2.5), (1.5, 1.25, 1.75), (2.0, 3.0, 1.5)]
    {
        let name = format!("{beta} {alpha} {delta}");
        let potential = sum(beta, &[term(0, scale, alpha), term(1, 1.0, delta), term(2, 1.0, 2.0)]);
        let ([x, y], one) = ([unit * t[0] / scale, unit * t[1]], 1.0);
        let inside = x.powf(alpha) + (-y).powf(delta);
        let p = inside.powf(one / beta);
        // Of the sum: its first and second derivatives by f1 and f2.
        let slope = [alpha * x.powf(alpha - 1.0) / scale, -delta * (-y).powf(delta - 1.0)];
        let bend = [
            alpha * (alpha - 1.0) * x.powf(alpha - 2.0) / (scale * scale),
            delta * (delta - 1.0) * (-y).powf(delta - 2.0),
        ];
        let outer =
            [inside.powf(one / beta - 1.0) / beta, (one / beta - 1.0) / beta * inside.powf(one / beta - 2.0)];
        let seeded = [0, 1, 2, 3, 4, 5].map(|k| Second::seed(t[k], k));
        let (found, flags) = evaluated(&potential, seeded, unit);
        assert_eq!(flags, [Flag::ContributionAtZero { term: 3 }], "{name}");
        let (gradient, hessian) = (found.gradient(), found.hessian());
        assert!(near(found.real(), p / unit), "{name}: {} {}", found.real(), p / unit);
        for i in 0..2 {
            assert!(near(gradient[i], outer[0] * slope[i]), "{name} {i}: {gradient:?}");
            for j in 0..2 {
                let own = if i == j { outer[0] * bend[i] } else { 0.0 };
                let expected = unit * (own + outer[1] * slope[i] * slope[j]);
                let size = unit * (outer[0] * bend[i]).abs() + expected.abs();
                assert!((hessian[i][j] - expected).abs() < 2e-14 * size, "{name} {i} {j}: {hessian:?}");
            }
        }
        let square = unit * 2.0 / beta * p.powf(1.0 - beta);
        assert!(near(hessian[2][2], square), "{name}: {} {square}", hessian[2][2]);
        assert_eq!((gradient[2], hessian[0][2], hessian[1][2]), (0.0, 0.0, 0.0), "{name}");
    }
}

/// The slope of a power above 1 is zero at zero, and is no reason for a flag: infinite is the curvature, of those who ask for it.
#[test]
fn first_derivatives_know_no_curvature() {
    for beta in [0.75, 1.0, 1.5, 3.0] {
        let potential = sum(beta, &[term(0, 1.0, 1.5), term(1, 1.0, 3.0)]);
        let at = [0.0, 2.0, 0.0, 0.0, 0.0, 0.0];
        let (p, flags) = evaluated(&potential, first(at), 1.0);
        let slope = 3.0 / beta * 2.0_f64.powf(3.0 / beta - 1.0);
        assert!(near(p.gradient()[1], slope) && p.gradient()[0] == 0.0, "{beta}: {p:?}");
        assert!(!flags.contains(&Flag::InfiniteCurvature { term: 1 }), "{beta}: {flags:?}");
        let seeded = [0, 1, 2, 3, 4, 5].map(|k| Second::seed(at[k], k));
        assert!(
            evaluated(&potential, seeded, 1.0).1.contains(&Flag::InfiniteCurvature { term: 1 }),
            "{beta}"
        );
    }
}

/// Whichever comes first, and whatever its sign; two that are equal are told.
#[test]
fn the_largest_contribution_counts() {
    let maximum = |terms: [Contribution; 3]| {
        let potential = Potential::new(PotentialOperator::Max, 1.0, terms.to_vec()).unwrap();
        let (p, flags) = evaluated(&potential, first([3.0, -5.0, 4.0, 0.0, 0.0, 0.0]), 1.0);
        (p.real(), p.gradient()[..3].to_vec(), flags)
    };
    let [a, b, c] = [0, 1, 2].map(|k| term(k, 1.0, 1.0));
    let minus = Contribution { sign: -1.0, ..b.clone() };
    for order in [[&a, &b, &c], [&b, &c, &a], [&c, &a, &b]] {
        assert_eq!(maximum(order.map(Clone::clone)), (5.0, vec![0.0, -1.0, 0.0], vec![]));
    }
    for order in [[&a, &minus, &c], [&minus, &c, &a], [&c, &a, &minus]] {
        assert_eq!(maximum(order.map(Clone::clone)), (4.0, vec![0.0, 0.0, 1.0], vec![]));
    }
    let half = term(0, 0.6, 1.0);
    let tied = vec![Flag::TiedMaximum { terms: [2, 3] }];
    assert_eq!(maximum([a, half, b]), (5.0, vec![1.0 / 0.6, 0.0, 0.0], tied));
}

/// |f1 + f2| is squared as it is, √(f1² + f2²) of its parts.
#[test]
fn sums_are_no_norms() {
    let at = [3.0, 4.0, 0.0, 0.0, 0.0, 0.0];
    for (operator, value) in [(Operator::Sum, 7.0), (Operator::Norm, 5.0), (Operator::MacauleySum, 7.0)] {
        assert_eq!(evaluated(&sum(2.0, &[joined(operator, &[0, 1], 2.0)]), at, 1.0).0, value);
    }
}

/// The factor of y = |t/F|^(α − 1) sign t in ∂P/∂f is what makes it the slope.
#[test]
fn bent_factors_make_the_slope() {
    let t = [0.3, -0.02, 0.0, 0.0, 0.0, 0.7];
    for (beta, alphas) in [(1.5, [1.5, 1.5]), (2.5, [1.5, 1.75]), (0.75, [1.25, 1.5]), (1.0, [1.75, 1.25])] {
        for (unit, size) in [(8.0, 0.37), (0.3, 5.0)] {
            let potential =
                sum(beta, &[term(0, 0.5, alphas[0]), term(1, -3.0, alphas[1]), term(5, 1.3, 2.0)]);
            let (p, _) = evaluated(&potential, first(t), unit);
            let bent = potential.bent(p.real(), size, unit);
            assert_eq!(
                bent.iter().map(|(k, alpha, _)| (*k, *alpha)).collect::<Vec<_>>(),
                [(0, alphas[0]), (1, alphas[1])]
            );
            for (k, alpha, factor) in bent {
                let slope = factor * (t[k] / size).abs().powf(alpha - 1.0) * t[k].signum();
                assert!(near(slope, p.gradient()[k]), "{beta} {k}: {slope} {:?}", p.gradient());
            }
        }
    }
}

/// Only |f_k/R|^α with 1 < α < 2 that has its component to itself has such an unknown; elsewhere infinite curvature is met, by place.
#[test]
fn curvature_is_infinite_in_lone_powers_or_told() {
    let plain = term(0, 1.0, 1.5);
    let others = [
        Contribution { exponent: 1.0, ..plain.clone() },
        Contribution { exponent: 0.5, ..plain.clone() },
        Contribution { exponent: 2.0, ..plain.clone() },
        Contribution { exponent: 3.0, ..plain.clone() },
        Contribution { function: PotentialFunction::Macauley, ..plain.clone() },
        Contribution { shift: 0.25, ..plain.clone() },
        Contribution { sign: -1.0, ..plain.clone() },
    ];
    let bent = |potential: &Potential| {
        potential.bent(1.0, 1.0, 1.0).into_iter().map(|(k, ..)| k).collect::<Vec<_>>()
    };
    let met = |potential: &Potential, t: [f64; 6]| potential.infinitely_curved(&t, 1.0, &Context::default());
    let rest = [0.0, 2.0, 0.0, 0.0, 0.0, 0.0];
    for (i, other) in others.into_iter().enumerate() {
        let potential = sum(1.5, &[term(1, 1.0, 1.5), other]);
        assert_eq!(bent(&potential), [1], "{i}");
        // ⟨f1⟩^1.5 and −|f1|^1.5 are at zero with the force, |f1 − 0.25|^1.5 where the force is the shift.
        assert_eq!(met(&potential, rest), if [4, 6].contains(&i) { vec![2] } else { vec![] }, "{i}");
        assert_eq!(
            met(&potential, [0.25, 2.0, 0.0, 0.0, 0.0, 0.0]),
            if i == 5 { vec![2] } else { vec![] },
            "{i}"
        );
    }
    for (terms, expected, curved) in [
        (vec![plain.clone(), term(1, 1.0, 1.5)], vec![0, 1], vec![]),
        (vec![plain.clone(), term(1, 1.0, 2.0), term(0, 3.0, 1.25)], vec![], vec![1, 3]),
        (vec![plain.clone(), joined(Operator::Sum, &[2, 0], 2.0), term(1, 1.0, 1.5)], vec![1], vec![1]),
        (vec![plain.clone(), joined(Operator::Sum, &[2, 4], 1.5), term(1, 1.0, 1.5)], vec![0, 1], vec![2]),
        (vec![term(1, 1.0, 1.5), joined(Operator::Norm, &[0, 2], 1.5)], vec![1], vec![2]),
    ] {
        let potential = sum(1.5, &terms);
        assert_eq!((bent(&potential), met(&potential, rest)), (expected, curved), "{terms:?}");
    }
    let largest = Potential::new(PotentialOperator::Max, 1.5, vec![plain, term(1, 1.0, 1.5)]).unwrap();
    assert_eq!((bent(&largest), met(&largest, rest)), (vec![], vec![]));
}

/// A stretch of size F for |f1|^α beside f2², with p of t.
fn stretch(alpha: f64, size: f64, t: [f64; 6]) -> (Stretch<f64>, First, f64) {
    let potential = sum(2.0, &[term(0, 0.5, alpha), term(1, 1.0, 2.0)]);
    let p = evaluated(&potential, first(t), 3.0).0;
    let factor = potential.bent(p.real(), size, 3.0)[0].2;
    (Stretch::new(&potential, p.real(), size, 3.0), p, factor)
}

/// Unknowns y = |t/F|^(α − 1) sign t where a power is bent, t/F elsewhere.
#[test]
fn steps_are_taken_in_the_unknowns() {
    let rest = [0.2, 1.0, 0.0, 0.0, 0.0, 0.0];
    for alpha in [1.125, 1.5, 1.75] {
        for size in [0.125, 3.0, 400.0] {
            let (stretch, ..) = stretch(alpha, size, rest);
            let y = |t: f64| (t / size).abs().powf(alpha - 1.0).copysign(t);
            for t in [0.0, 1e-9, 0.03, -0.7, 40.0, -1e4] {
                for step in [0.9, -0.4, 3.0, -0.06 * y(t), 1.75 * y(t)] {
                    let name = format!("{alpha} {size} {t} {step}");
                    let moved = stretch.stepped(0, t, step);
                    // Small steps are taken along the slope, whose second order is left out.
                    let size_of = y(t).abs() + step.abs();
                    let allowed =
                        if (moved - t).abs() < t.abs() / 60.0 { 2e-3 } else { 4e-15 / (alpha - 1.0) };
                    assert!((y(moved) - (y(t) - step)).abs() <= allowed * size_of, "{name}: {moved}");
                    assert_eq!(stretch.stepped(1, t, step), t - step * size, "{name}");
                }
                // What a number of this precision does not feel changes nothing; to first order the step goes by the slope.
                assert_eq!(stretch.stepped(0, t, 1e-18 * y(t)), t);
                let step = 1e-4 * y(t);
                let slope = t.abs().powf(2.0 - alpha) * size.powf(alpha - 1.0) / (alpha - 1.0) / size;
                assert!(near(stretch.rise(0, t), slope), "{alpha} {size} {t}: {}", stretch.rise(0, t));
                let found = stretch.stepped(0, t, step) - t;
                assert!((found + step * slope * size).abs() <= 1e-11 * (step * slope * size).abs());
                assert_eq!(stretch.rise(1, t), 1.0);
            }
            // To zero exactly, and over it.
            assert_eq!(stretch.stepped(0, size, 1.0), 0.0);
            assert_eq!(stretch.stepped(0, -size, -2.0), size);
        }
    }
}

/// F K ∂²P/∂f² ∂(t/F)/∂y is finite at zero, where it is the limit of what it is beside zero.
#[test]
fn curvature_is_continuous_at_zero() {
    for alpha in [1.25, 1.5, 1.75] {
        for size in [0.125, 3.0] {
            let at = |t1: f64| {
                let t = [t1, 1.0, 0.0, 0.0, 0.0, 0.0];
                let (stretch, p, factor) = stretch(alpha, size, t);
                let seeded = [0, 1, 2, 3, 4, 5].map(|k| Second::seed(t[k], k));
                let potential = sum(2.0, &[term(0, 0.5, alpha), term(1, 1.0, 2.0)]);
                let hessian = evaluated(&potential, seeded, 3.0).0.hessian();
                let others = hessian[1][1] * size;
                assert!(near(stretch.curvature(1, 1.0, hessian[1][1]), others));
                (stretch.curvature(0, t1, hessian[0][0]), factor, p.gradient()[0])
            };
            let (limit, factor, _) = at(0.0);
            assert_eq!(limit, factor);
            let (beside, ..) = at(1e-20);
            assert!((beside / limit - 1.0).abs() < 1e-9, "{alpha} {size}: {beside} {limit}");
            // Away from zero it is ∂(∂P/∂f)/∂y, by differences.
            let y = |t: f64| (t / size).powf(alpha - 1.0);
            let [above, below] = [0.3 + 1e-5, 0.3 - 1e-5].map(|t| (at(t).2, y(t)));
            let expected = (above.0 - below.0) / (above.1 - below.1);
            let (found, ..) = at(0.3);
            assert!((found / expected - 1.0).abs() < 1e-6, "{alpha} {size}: {found} {expected}");
        }
    }
}

/// Where nothing is bent, or P has no size, the unknowns are t/F.
#[test]
fn only_bent_powers_are_stretched() {
    let is_any = |alpha: f64, p: f64| {
        let potential = sum(2.0, &[term(0, 0.5, alpha), term(1, 1.0, 2.0)]);
        let stretch = Stretch::new(&potential, p, 1.0, 3.0);
        assert_eq!(stretch.rise(0, 16.0) == 1.0, !stretch.is_any());
        stretch.is_any()
    };
    assert_eq!(
        [is_any(1.5, 1.0), is_any(2.0, 1.0), is_any(3.0, 1.0), is_any(1.5, 0.0)],
        [true, false, false, false]
    );
}
