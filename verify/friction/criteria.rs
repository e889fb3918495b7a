//! P and F_C of each type, typed from the manual; derivatives against differences on 237 bits; scaling; zeros.

use super::{U, predefined, users};
use crate::states::Draw;
use crate::tolerance::friction;
use pintle_kinematics::catalog::ConnectionType;
use pintle_kinematics::scalar::{Scalar, Wide};
use pintle_model::behavior::friction::{Belt, Coefficient, Context, Criterion, Flag, Point, StickStiffness};

/// P and F_C of a type's criterion, as its page prints them; `p` are the numbers of the data line.
fn manual(
    name: &str,
    criterion: usize,
    p: &[f64],
    f: [f64; 6],
    position: [f64; 6],
    planar: bool,
) -> (f64, f64) {
    let [f1, f2, f3, m1, m2, m3] = f;
    // Two dimensions: f3 = m1 = m2 = 0.
    let [f3, m1, m2] = if planar { [0.0; 3] } else { [f3, m1, m2] };
    let over = |x: f64, length: f64| if length == 0.0 { 0.0 } else { x / length };
    let puck = |r: f64| f1.abs() + over(m2.hypot(m3), r);
    let cross = |t: [f64; 3]| {
        let along = f1 * t[0] + f2 * t[1] + f3 * t[2];
        let across = [f1 - along * t[0], f2 - along * t[1], f3 - along * t[2]];
        let across = across[0].hypot(across[1]).hypot(across[2]);
        p[2] * along.abs() + p[0] * (across + 2.0 * m2.abs() / p[1])
    };
    let [alpha, beta] = [position[3], position[4]];
    match (name, criterion) {
        ("SLIDE-PLANE", 0) => (f2.hypot(f3), f1.abs()),
        ("SLOT", 0) => (f1.abs(), f2.hypot(f3)),
        ("TRANSLATOR", 0) => (f1.abs(), over(m1.abs(), p[0]) + f2.hypot(f3) + over(2.0 * m2.hypot(m3), p[1])),
        ("CYLINDRICAL", 0) => (f1.hypot(m1 / p[0]), f2.hypot(f3) + over(2.0 * m2.hypot(m3), p[1])),
        ("HINGE", 0) => (m1.abs(), f1.abs() * p[1] + p[0] * (f2.hypot(f3) + over(2.0 * m2.hypot(m3), p[2]))),
        ("PLANAR", 0) => (f2.hypot(f3), puck(p[0])),
        ("PLANAR", 1) => (m1.abs(), p[0] * puck(p[0])),
        ("UJOINT", 0) => (m1.abs(), cross([1.0, 0.0, 0.0])),
        ("UJOINT", 1) => (m3.abs(), cross([beta.sin(), -alpha.sin() * beta.cos(), alpha.cos() * beta.cos()])),
        other => panic!("{other:?} has predefined friction and no transcribed formula"),
    }
}

fn internal(name: &str, criterion: usize, p: &[f64]) -> f64 {
    match (name, criterion) {
        ("SLOT" | "SLIDE-PLANE", _) => p[0],
        ("TRANSLATOR" | "CYLINDRICAL", _) => p[2],
        ("HINGE", _) => p[3],
        ("PLANAR", i) => p[1 + i],
        ("UJOINT", i) => p[4 + i],
        other => panic!("{other:?}"),
    }
}

fn positions(draw: &mut Draw) -> [f64; 6] {
    [0; 6].map(|_| draw.between(-1.2, 1.2))
}

fn forces(draw: &mut Draw) -> [f64; 6] {
    [0; 6].map(|_| draw.between(-3.0, 3.0))
}

fn context(position: [f64; 6]) -> Context<'static, f64> {
    Context { position, motion: position, ..Context::default() }
}

#[test]
fn formulas_are_the_manuals() {
    let mut draw = Draw::new("friction formulas");
    let mut compared = 0;
    for planar in [false, true] {
        for (name, i, numbers, criterion) in predefined(&mut draw, planar) {
            if planar && !["SLOT", "TRANSLATOR"].contains(&name.as_str()) {
                continue;
            }
            let p: Vec<f64> = numbers.iter().map(|x| x.unwrap_or(0.0)).collect();
            for _ in 0..20 {
                let (f, position) = (forces(&mut draw), positions(&mut draw));
                let (tangential, contact) = manual(&name, i, &p, f, position, planar);
                let normal = (contact + internal(&name, i, &p)).abs();
                let (point, flags) = criterion.at(&f, 0.3, None, &context(position));
                let close = |what: &str, a: f64, b: f64| {
                    let bound = friction("formulas") * U * b.abs();
                    assert!((a - b).abs() <= bound, "{name} {i} {what}: {a} {b} {f:?} {p:?}");
                };
                close("P", point.tangential, tangential);
                close("F_C", point.contact, contact);
                close("F_N", point.normal, normal);
                let phi = tangential - 0.3 * normal;
                let bound = friction("formulas") * U * (tangential + 0.3 * normal);
                assert!((point.criterion - phi).abs() <= bound, "{name} {i} Φ");
                let without_contact = contact == 0.0;
                assert!(flags.is_empty() || without_contact, "{name} {i} {flags:?}");
                compared += usize::from(tangential != 0.0);
            }
        }
    }
    assert!(compared > 800, "{compared}");
}

/// Parameters that no force depends on drop out; those that make no sense are refused.
#[test]
fn parameters_are_checked() {
    let hinge = ConnectionType::named("HINGE", None).unwrap().friction.unwrap();
    for (numbers, part) in [
        (vec![], "takes 1 to 4 numbers, not 0"),
        (vec![Some(1.0); 5], "takes 1 to 4 numbers, not 5"),
        (vec![Some(0.0)], "R_p = 0.0: a length must be positive"),
        (vec![Some(1.0), Some(-2.0)], "R_a = -2.0: a length must be positive, or zero"),
        (vec![Some(1.0), None, Some(1e-310)], "L_s = 1e-310: "),
        (vec![Some(f64::INFINITY)], "R_p = inf"),
    ] {
        let message = Criterion::predefined(&hinge, &numbers, &[], false).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    let internal = Criterion::predefined(&hinge, &[Some(1.0), None, None, Some(-3.0)], &[], false).unwrap();
    let (point, _) = internal[0].at(&[0.0, 2.0, 0.0, 0.0, 0.0, 0.0], 0.1, None, &Context::default());
    assert_eq!(point.normal, 1.0);
}

/// The arm of PLANAR's spin moment is 1, or as set.
#[test]
fn the_arm_of_a_puck_can_be_set() {
    let planar = ConnectionType::named("PLANAR", None).unwrap().friction.unwrap();
    let moment = |constants: &[f64]| {
        let criteria = Criterion::predefined(&planar, &[Some(0.5)], constants, false).unwrap();
        criteria[1].at(&[3.0, 0.0, 0.0, 0.0, 0.0, 0.0], 0.1, None, &Context::default()).0.contact
    };
    assert_eq!((moment(&[]), moment(&[2.0 / 3.0])), (1.5, 1.0));
}

type Getter<S> = fn(&Point<S>) -> S;

/// First and second derivatives against differences on 237 bits.
#[test]
fn derivatives_are_those_of_differences() {
    let mut draw = Draw::new("friction derivatives");
    let mut all: Vec<(String, Criterion)> =
        predefined(&mut draw, false).into_iter().map(|(name, i, _, c)| (format!("{name} {i}"), c)).collect();
    all.extend(users().into_iter().map(|(name, c)| (name.to_string(), c)));
    let mut worst = [0.0_f64; 2];
    for (name, criterion) in &all {
        for _ in 0..6 {
            let (f, position) = (forces(&mut draw), positions(&mut draw));
            let (duals, _) = criterion.derivatives(&f, 0.3, None, &context(position));
            let wide_position = position.map(Wide::from_f64);
            let wide = Context { position: wide_position, motion: wide_position, ..Context::default() };
            let at = |moved: &[(usize, f64)], get: Getter<Wide>| {
                let mut f = f.map(Wide::from_f64);
                for (k, h) in moved {
                    f[*k] += *h;
                }
                get(&criterion.at(&f, Wide::from_f64(0.3), None, &wide).0)
            };
            let quantities: [(&str, Getter<Wide>, _); 4] = [
                ("P", |p| p.tangential, duals.tangential),
                ("F_C", |p| p.contact, duals.contact),
                ("F_N", |p| p.normal, duals.normal),
                ("Φ", |p| p.criterion, duals.criterion),
            ];
            for (what, get, dual) in quantities {
                let size = 1.0 + dual.value.abs();
                for j in 0..6 {
                    let h = 1e-25;
                    let first = ((at(&[(j, h)], get) - at(&[(j, -h)], get)) / (2.0 * h)).to_f64();
                    let scale = size + dual.gradient.iter().fold(0.0, |s: f64, g| s.max(g.abs()));
                    worst[0] = worst[0].max((dual.gradient[j] - first).abs() / (U * scale));
                    assert!(
                        (dual.gradient[j] - first).abs() <= friction("gradients") * U * scale,
                        "{name} ∂{what}/∂{j}: {} {first} at {f:?}",
                        dual.gradient[j]
                    );
                    for k in 0..6 {
                        let h = 1e-18;
                        let second = (at(&[(j, h), (k, h)], get)
                            - at(&[(j, h), (k, -h)], get)
                            - at(&[(j, -h), (k, h)], get)
                            + at(&[(j, -h), (k, -h)], get))
                            / (4.0 * h * h);
                        let second = second.to_f64();
                        let scale =
                            scale + dual.hessian.as_flattened().iter().fold(0.0, |s: f64, g| s.max(g.abs()));
                        worst[1] = worst[1].max((dual.hessian[j][k] - second).abs() / (U * scale));
                        assert!(
                            (dual.hessian[j][k] - second).abs() <= friction("hessians") * U * scale,
                            "{name} ∂²{what}/∂{j}∂{k}: {} {second} at {f:?}",
                            dual.hessian[j][k]
                        );
                    }
                }
            }
        }
    }
    println!("worst in u: gradients {}, hessians {}", worst[0], worst[1]);
}

/// P and F_C are homogeneous of degree one: scaling forces by a power of two scales them exactly, from 1e-300 to 1e300, keeps
/// gradients and divides second derivatives.
#[test]
fn forces_of_any_size_are_alike() {
    let mut draw = Draw::new("friction range");
    let mut compared = 0;
    let mut all: Vec<(String, Criterion)> =
        predefined(&mut draw, false).into_iter().map(|(name, i, _, c)| (format!("{name} {i}"), c)).collect();
    all.extend(
        users()
            .into_iter()
            .filter(|(name, _)| !["shifted", "mixed exponents"].contains(name))
            .map(|(n, c)| (n.to_string(), c)),
    );
    for (name, criterion) in &all {
        let (f, position) = (forces(&mut draw), positions(&mut draw));
        let evaluate = |f: [f64; 6]| criterion.derivatives(&f, 0.3, None, &context(position)).0;
        let base = evaluate(f);
        for power in [-990, -500, 500, 990] {
            let factor = 2.0_f64.powi(power);
            let scaled = evaluate(f.map(|x| x * factor));
            for (what, a, b) in
                [("P", base.tangential, scaled.tangential), ("F_C", base.contact, scaled.contact)]
            {
                let close = |what: &str, a: f64, b: f64| {
                    assert!(
                        (a - b).abs() <= friction("range") * U * (1.0 + a.abs()),
                        "{name} {what} 2^{power}: {a} {b}"
                    );
                };
                close(what, a.value, b.value / factor);
                compared += usize::from(a.value != 0.0);
                for j in 0..6 {
                    close(what, a.gradient[j], b.gradient[j]);
                    for k in 0..6 {
                        close(what, a.hessian[j][k], b.hessian[j][k] * factor);
                    }
                }
            }
        }
    }
    assert!(compared > 300, "{compared}");
}

/// At zeros the value is exact, derivatives are zero, and the place is named.
#[test]
fn zeros_are_named() {
    let of = |name: &str, numbers: &[Option<f64>], f: [f64; 6]| {
        let friction = ConnectionType::named(name, None).unwrap().friction.unwrap();
        let criterion = Criterion::predefined(&friction, numbers, &[], false).unwrap().remove(0);
        criterion.derivatives(&f, 0.5, None, &Context::default())
    };
    let (point, flags) = of("SLIDE-PLANE", &[], [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!((point.tangential.value, point.tangential.gradient), (0.0, [0.0; 6]));
    assert_eq!(point.tangential.hessian, [[0.0; 6]; 6]);
    assert_eq!((point.contact.gradient[0], flags), (1.0, vec![Flag::NoTraction]));
    let (point, flags) = of("SLIDE-PLANE", &[], [0.0, 3.0, 4.0, 0.0, 0.0, 0.0]);
    assert_eq!((point.contact.gradient, point.normal.gradient), ([0.0; 6], [0.0; 6]));
    assert_eq!(point.tangential.gradient, [0.0, 0.6, 0.8, 0.0, 0.0, 0.0]);
    assert_eq!(flags, vec![Flag::LoadAtZero { load: "|f1|".into() }, Flag::NoContactForce]);
    // F_C + F_C^int = 0: the derivative of |x| changes its sign.
    let (point, flags) = of("SLIDE-PLANE", &[Some(-2.0)], [-2.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!((point.contact.value, point.normal.value, point.normal.gradient), (2.0, 0.0, [0.0; 6]));
    assert_eq!(flags, vec![Flag::NoContactForce]);
    let (point, flags) = of("TRANSLATOR", &[Some(0.1), Some(0.2)], [1.0, 3.0, 4.0, 0.0, 0.0, 0.0]);
    assert_eq!(point.contact.gradient, [0.0, 0.6, 0.8, 0.0, 0.0, 0.0]);
    let loads = ["|m1|", "√(m2² + m3²)"].map(|load| Flag::LoadAtZero { load: load.into() });
    assert_eq!(flags, loads);
    // Nothing non-finite anywhere near.
    for size in [1e-300, 1e-308, 1e300] {
        let (point, _) = of("TRANSLATOR", &[Some(1.0), Some(1.0)], [size; 6]);
        assert!(point.criterion.value.is_finite() && point.criterion.gradient.iter().all(|g| g.is_finite()));
    }
}

/// Squares are smooth where they vanish: the curvature of √(x² + y²) at x = 0 is not lost, and no kink is named.
#[test]
fn a_quadratic_potential_is_smooth_at_the_zero_of_a_contribution() {
    let (_, ellipsoid) = users().into_iter().find(|(name, _)| *name == "ellipsoid").unwrap();
    let (point, flags) =
        ellipsoid.derivatives(&[0.0, 2.0, 0.0, 0.0, 1.0, 0.0], 0.5, None, &Context::default());
    // P = √((f1/1.5)² + (f2/0.7)² + …): ∂²P/∂f1² = 1/(1.5² P).
    let expected = 0.7 / (1.5 * 1.5 * 2.0);
    assert!(
        (point.tangential.hessian[0][0] - expected).abs() < 4.0 * U,
        "{}",
        point.tangential.hessian[0][0]
    );
    assert_eq!(flags, vec![]);
}

#[test]
fn kinks_of_potentials_are_named() {
    let at = |name: &str, f: [f64; 6]| {
        let (_, criterion) = users().into_iter().find(|(known, _)| *known == name).unwrap();
        criterion.derivatives(&f, 0.5, None, &Context::default())
    };
    let (_, flags) = at("maximum", [1.5, 0.3, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(flags, vec![Flag::TiedMaximum { terms: [1, 2] }]);
    let (_, flags) = at("linear", [0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(flags, vec![Flag::ContributionAtZero { term: 1 }]);
    let (point, flags) = at("linear", [0.0, -1.0, 0.0, 0.0, 1.0, 0.0]);
    assert_eq!(point.tangential.value, 0.0);
    assert!(flags.contains(&Flag::NegativePotential));
    let (_, flags) = at("mixed exponents", [1.0, 0.0, 1.0, 0.0, 1.0, 0.0]);
    assert_eq!(flags, vec![Flag::MacauleyAtZero { term: 2 }]);
    let (_, flags) = at("derived sum", [1.0, 1.0, 0.0, 1.0, 1.0, 1.0]);
    assert_eq!(flags, vec![Flag::MacauleyAtZero { term: 3 }]);
}

/// max(T1, T2) ≤ min(T1, T2) exp(μ α).
#[test]
fn a_belt_slips_at_the_ratio_of_tensions() {
    let belt = Belt {
        coefficient: Coefficient::Constant(0.2),
        maximum: None,
        stick_stiffness: StickStiffness::Given(1.0),
    };
    let ratio = (0.2_f64 * 1.5).exp();
    let (point, flags) = belt.at([100.0, 100.0 * ratio], 1.5, 0.2);
    assert!(point.criterion.abs() < 1e-13 * 100.0 && flags.is_empty(), "{point:?}");
    let (reversed, _) = belt.at([100.0 * ratio, 100.0], 1.5, 0.2);
    assert_eq!(point.tangential, reversed.tangential);
    let (duals, _) = belt.derivatives([100.0, 120.0], 1.5, 0.2);
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-13 * (1.0 + b.abs()), "{a} {b}");
    near(duals.criterion.gradient[0], -1.0 - (ratio - 1.0));
    near(duals.criterion.gradient[1], 1.0);
    near(duals.criterion.gradient[2], -100.0 * 0.2 * ratio);
    near(duals.criterion.hessian[0][2], -0.2 * ratio);
    near(duals.criterion.hessian[2][2], -100.0 * 0.04 * ratio);
    assert_eq!(belt.at([50.0, 50.0], 1.5, 0.2).1, vec![Flag::NoTraction]);
    assert_eq!(belt.at([-1.0, 50.0], 1.5, 0.2).1, vec![Flag::Slack]);
    // A belt that hardly wraps: exp(μ α) − 1 keeps its digits.
    let (point, _) = belt.at([1.0, 1.0], 1e-12, 0.2);
    near(point.criterion / -2e-13, 1.0);
    assert_eq!(point.criterion.real(), point.criterion);
}

/// Written and read back, a criterion is the same; a load that no friction of the catalogue has is refused.
#[test]
fn criteria_are_read_back() {
    let mut draw = Draw::new("written criteria");
    let mut refused = 0;
    for (name, place, _, criterion) in predefined(&mut draw, false) {
        let text = serde_json::to_string(&criterion).unwrap();
        let back: Criterion = serde_json::from_str(&text).unwrap();
        assert_eq!(Criterion { output: criterion.output, ..back }, criterion, "{name} {place}");
        if text.contains("norm of components") {
            let other = text.replace("norm of components", "none of components");
            assert!(serde_json::from_str::<Criterion>(&other).is_err(), "{name} {place}");
            refused += 1;
        }
    }
    assert!(refused > 0);
}
