//! Potentials and derived components against their formulas on 237 bits, whose derivatives are differences: every exponent, sign,
//! shift and function, and what holds where a contribution vanishes.

use super::{component, criterion};
use pintle_kinematics::scalar::{Real, Wide};
use pintle_model::behavior::friction::{
    Context, Contribution, Derived, DerivedPart, Flag, Form, Internal, Potential, Pressing, Tangential,
};
use pintle_scene::{Operator, PotentialFunction, PotentialOperator};

fn part(operator: Operator, components: &[usize], sign: f64) -> DerivedPart {
    DerivedPart { operator, sign, components: components.to_vec(), scale: None, independent: None }
}

fn of(part: DerivedPart) -> Form {
    Form::Derived(Derived { parts: vec![part] })
}

/// X of a contribution.
fn plain(form: &Form, f: &[Wide; 6]) -> Wide {
    match form {
        Form::Component(k) => f[*k],
        Form::Derived(derived) => {
            let value = |part: &DerivedPart| {
                let terms = part.components.iter().map(|k| f[*k]);
                let sum = match part.operator {
                    Operator::Sum => terms.sum::<Wide>(),
                    Operator::MacauleySum => terms.map(|x| x.max(Wide::from_f64(0.0))).sum(),
                    Operator::Norm => terms.map(|x| x * x).sum::<Wide>().square_root(),
                };
                sum * part.sign
            };
            derived.parts.iter().map(value).sum()
        }
    }
}

/// (Σ s H(X/R − a)^α)^(1/β), or max s H(X/R − a).
fn formula(operator: PotentialOperator, beta: f64, terms: &[Contribution], f: &[Wide; 6]) -> Wide {
    let value = |term: &Contribution| {
        let argument = plain(&term.of, f) / term.scale - term.shift;
        match term.function {
            PotentialFunction::Abs => argument.abs(),
            PotentialFunction::Macauley => argument.max(Wide::from_f64(0.0)),
            PotentialFunction::None => argument,
        }
    };
    match operator {
        PotentialOperator::Max => {
            terms.iter().map(|term| value(term) * term.sign).fold(Wide::from_f64(0.0), Wide::max)
        }
        PotentialOperator::Sum => {
            let raised = |term: &Contribution| {
                let value = value(term);
                let power =
                    if term.exponent == 1.0 { value } else { value.power(Wide::from_f64(term.exponent)) };
                power * term.sign
            };
            let sum = terms.iter().map(raised).sum::<Wide>();
            if beta == 1.0 { sum } else { sum.power(Wide::ratio(1, 1) / beta) }
        }
    }
}

/// Potentials with exponents on both sides of 1 and 2, with shifts, scales, signs and derived components.
fn all() -> Vec<(PotentialOperator, f64, Vec<Contribution>)> {
    use PotentialFunction::{Abs, Macauley, None as Plain};
    use PotentialOperator::{Max, Sum};
    let minus = |term: Contribution| Contribution { sign: -1.0, ..term };
    let shifted =
        |k, exponent, function| Contribution { shift: 0.2, scale: 0.8, ..component(k, exponent, function) };
    let derived = |form, exponent, function| Contribution { of: form, ..shifted(0, exponent, function) };
    let mut all = Vec::new();
    for beta in [0.8, 1.0, 1.5, 2.0, 2.5, 3.0] {
        for own in [beta, 1.0, 2.0, 3.0] {
            all.push((
                Sum,
                beta,
                vec![component(0, beta, Abs), shifted(1, own, Macauley), component(2, own, Abs)],
            ));
        }
        all.push((
            Sum,
            beta,
            vec![component(0, beta, Abs), minus(shifted(5, beta, Abs)), component(2, 2.0, Abs)],
        ));
        for operator in [Operator::Sum, Operator::Norm, Operator::MacauleySum] {
            let form = of(part(operator, &[2, 3, 4], 1.0));
            let bare = Contribution { of: form.clone(), ..component(0, beta, Abs) };
            all.push((Sum, beta, vec![component(0, beta, Abs), bare]));
            all.push((Sum, beta, vec![component(0, beta, Abs), derived(form, beta, Abs)]));
        }
    }
    all.push((
        Sum,
        1.0,
        vec![component(0, 1.0, Abs), component(1, 1.0, Plain), minus(component(5, 1.0, Plain))],
    ));
    all.push((Max, 2.0, vec![component(5, 2.0, Abs), component(0, 2.0, Abs), minus(shifted(1, 2.0, Abs))]));
    all.push((
        Max,
        1.0,
        vec![minus(component(0, 1.0, Abs)), shifted(1, 1.0, Plain), component(5, 1.0, Macauley)],
    ));
    all
}

/// Values, gradients and second derivatives of P. Measured 2e-16, 4e-16 and 5e-16: a few roundings.
#[test]
fn potentials_are_their_formulas() {
    let mut worst = [0.0_f64; 3];
    for (operator, beta, terms) in all() {
        let potential = Potential::new(operator, beta, terms.clone()).unwrap();
        let criterion =
            criterion(Tangential::Potential(potential), Pressing::Nothing, Internal::Constant(1.0));
        for f in [[3.0, 2.0, 1.75, 0.625, -0.5, 0.75], [-4.0, 0.875, -1.5, -0.25, 2.0, -0.5]] {
            let (point, flags) = criterion.derivatives(&f, 0.3, None, &Context::default());
            assert_eq!(flags, vec![], "{operator:?} {beta} {terms:?}");
            let at = |moved: &[(usize, f64)]| {
                let mut f = f.map(Wide::from_f64);
                moved.iter().for_each(|(k, h)| f[*k] += *h);
                formula(operator, beta, &terms, &f)
            };
            let value = at(&[]).to_f64();
            let mut see = |order: usize, found: f64, exact: f64, size: f64| {
                let error = (found - exact).abs() / size;
                worst[order] = worst[order].max(error);
                let allowed = [1e-15, 2e-15, 4e-15][order];
                assert!(
                    error <= allowed,
                    "{operator:?} {beta} order {order}: {found} {exact}\n{terms:?} {f:?}"
                );
            };
            see(0, point.tangential.value, value, value);
            for j in 0..6 {
                let (h, g) = (1e-25, 1e-18);
                let first = ((at(&[(j, h)]) - at(&[(j, -h)])) / (2.0 * h)).to_f64();
                see(1, point.tangential.gradient[j], first, 1.0 + first.abs());
                for k in 0..6 {
                    let second = at(&[(j, g), (k, g)]) - at(&[(j, g), (k, -g)]) - at(&[(j, -g), (k, g)])
                        + at(&[(j, -g), (k, -g)]);
                    let second = (second / (4.0 * g * g)).to_f64();
                    see(2, point.tangential.hessian[j][k], second, 1.0 + second.abs());
                }
            }
        }
    }
    println!("worst: {worst:?}");
}

/// A linear potential is the sum itself, rounded once; and powers of what is tiny beside the rest do no harm.
#[test]
fn linear_potentials_are_sums() {
    let at = |beta, own, f: [f64; 6]| {
        let term = |k| Contribution { scale: 1.0, ..component(k, own, PotentialFunction::Abs) };
        let potential = Potential::new(PotentialOperator::Sum, beta, vec![term(0), term(1)]).unwrap();
        let criterion =
            criterion(Tangential::Potential(potential), Pressing::Nothing, Internal::Constant(1.0));
        criterion.derivatives(&f, 0.3, None, &Context::default()).0.tangential
    };
    for (x, y) in [(0.3, 0.1), (0.7, 0.1), (5.0, 0.3), (1e-3, 0.9), (0.1, 0.2), (1.1, 2.3), (0.6, 0.7)] {
        assert_eq!(at(1.0, 1.0, [-x, y, 0.0, 0.0, 0.0, 0.0]).value, x + y, "{x} {y}");
    }
    // |f1|² + |f2|² with |f2|² below the normal numbers, whose reciprocal overflows.
    let point = at(1.0, 2.0, [1.0, 1e-160, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!((point.value, point.gradient[0]), (1.0, 2.0));
    assert!(point.hessian.as_flattened().iter().all(|h| h.is_finite()), "{point:?}");
}

/// A sum that is negative has no root: the potential is zero, which is told, of squares as of other powers.
#[test]
fn negative_sums_are_told() {
    for beta in [1.0, 2.0, 3.0] {
        let term = |k| Contribution { sign: -1.0, ..component(k, beta, PotentialFunction::Abs) };
        let potential = Potential::new(PotentialOperator::Sum, beta, vec![term(0), term(1)]).unwrap();
        let criterion =
            criterion(Tangential::Potential(potential), Pressing::Nothing, Internal::Constant(1.0));
        let (point, flags) =
            criterion.derivatives(&[3.0, 4.0, 0.0, 0.0, 0.0, 0.0], 0.3, None, &Context::default());
        assert_eq!((point.tangential.value, point.tangential.gradient), (0.0, [0.0; 6]), "{beta}");
        assert!(flags.contains(&Flag::NegativePotential), "{beta}: {flags:?}");
    }
}

/// √(f1² − f2²) on 237 bits, where f1 or f2 is negative: squares have no sign.
#[test]
fn squares_of_negative_forces_on_237_bits() {
    let term = |k, sign| Contribution { scale: 1.0, sign, ..component(k, 2.0, PotentialFunction::Abs) };
    let potential = Potential::new(PotentialOperator::Sum, 2.0, vec![term(0, 1.0), term(1, -1.0)]).unwrap();
    let criterion = criterion(Tangential::Potential(potential), Pressing::Nothing, Internal::Constant(1.0));
    for [x, y] in [[5.0, 4.0], [-5.0, 4.0], [5.0, -4.0], [-5.0, -4.0]] {
        let f = [x, y, 0.0, 0.0, 0.0, 0.0].map(Wide::from_f64);
        let (point, _) = criterion.derivatives(&f, Wide::ratio(1, 2), None, &Context::default());
        let p = point.tangential;
        let near = |a: Wide, b: Wide| assert!((a - b).abs() < 1e-68, "{x} {y}: {a} {b}");
        near(p.value, Wide::integer(3));
        near(p.gradient[0], Wide::from_f64(x) / 3.0);
        near(p.gradient[1], Wide::from_f64(-y) / 3.0);
        near(p.hessian[0][0], Wide::ratio(1, 3) - Wide::ratio(25, 27));
        near(p.hessian[1][1], Wide::ratio(-1, 3) - Wide::ratio(16, 27));
        near(p.hessian[0][1], Wide::from_f64(x * y) / 27.0);
    }
}

/// Where a contribution vanishes its derivatives do, and nothing is infinite, though powers of it would be.
#[test]
fn vanishing_contributions_have_no_slope() {
    for beta in [0.8, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0] {
        let terms = vec![
            component(0, beta, PotentialFunction::Abs),
            component(1, beta, PotentialFunction::Abs),
            component(5, 2.0, PotentialFunction::Abs),
        ];
        let potential = Potential::new(PotentialOperator::Sum, beta, terms).unwrap();
        let criterion =
            criterion(Tangential::Potential(potential), Pressing::Nothing, Internal::Constant(1.0));
        let f = [3.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let (point, _) = criterion.derivatives(&f, 0.3, None, &Context::default());
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 1e-15 * (1.0 + b.abs()), "{beta}: {a} {b}");
        close(point.tangential.value, 2.0);
        close(point.tangential.gradient[0], 1.0 / 1.5);
        close(point.tangential.gradient[1], 0.0);
        assert!(point.tangential.hessian.as_flattened().iter().all(|h| h.is_finite()), "{beta}");
        close(point.tangential.hessian[0][0], 0.0);
        // Only squares are curved there: ∂²P/∂f1² = 1/(R² P).
        close(point.tangential.hessian[1][1], if beta == 2.0 { 1.0 / (2.25 * 2.0) } else { 0.0 });
    }
}

/// Terms are named by their place, of squares too; a potential knows its components, each once.
#[test]
fn terms_are_named_by_place() {
    let terms = |exponent| {
        vec![
            component(0, exponent, PotentialFunction::Abs),
            component(1, exponent, PotentialFunction::Abs),
            component(2, exponent, PotentialFunction::Macauley),
        ]
    };
    for beta in [1.0, 2.0, 3.0] {
        let potential = Potential::new(PotentialOperator::Sum, beta, terms(beta)).unwrap();
        let criterion =
            criterion(Tangential::Potential(potential), Pressing::Nothing, Internal::Constant(1.0));
        let (_, flags) =
            criterion.derivatives(&[1.0, 2.0, 0.0, 0.0, 0.0, 0.0], 0.3, None, &Context::default());
        assert_eq!(flags, vec![Flag::MacauleyAtZero { term: 3 }], "{beta}");
    }
    let derived = Contribution {
        of: of(part(Operator::Sum, &[4, 2, 0], 1.0)),
        ..component(0, 1.0, PotentialFunction::Abs)
    };
    let potential =
        Potential::new(PotentialOperator::Sum, 1.0, vec![component(2, 1.0, PotentialFunction::Abs), derived]);
    assert_eq!(potential.unwrap().components(), [0, 2, 4]);
}

/// F_C of a derived component of several parts, by hand.
#[test]
fn contact_forces_of_derived_components() {
    let derived = Derived {
        parts: vec![
            part(Operator::Norm, &[1, 2], 1.0),
            part(Operator::Sum, &[3, 4], -1.0),
            part(Operator::MacauleySum, &[2, 5, 0], 1.0),
        ],
    };
    let criterion =
        criterion(Tangential::Norm(vec![(0, 1.0)]), Pressing::Derived(derived), Internal::Constant(0.5));
    let contact = |f: [f64; 6]| criterion.derivatives(&f, 0.5, None, &Context::default()).0.contact.value;
    // √(3² + 4²) − (−0.5 − 0.25) + ⟨4⟩ + ⟨2⟩ + ⟨1⟩
    assert_eq!(contact([1.0, 3.0, 4.0, -0.5, -0.25, 2.0]), 12.75);
    assert_eq!(contact([-1.0, 3.0, -4.0, -0.5, -0.25, 2.0]), 7.75);
}
