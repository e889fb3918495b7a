//! Derivatives to the fourth order, the highest that a scalar carries, of functions whose derivatives are known in closed form.

use super::function::Function;
use num_dual::{Dual2, Dual2_64, Dual3, HyperHyperDual};
use pintle_kinematics::scalar::{Scalar, Wide, elementary};
use pintle_kinematics::{so3, vector};

type Jet = Dual2<Dual2_64>;

/// x₀ + ε, with four derivatives by ε.
fn variable(x: f64) -> Jet {
    Dual2::new(Dual2::new(x, 1.0, 0.0), Dual2::new(1.0, 0.0, 0.0), Dual2::new(0.0, 0.0, 0.0))
}

/// f, f′, f″, f‴, f⁗.
fn derivatives(f: Jet) -> [f64; 5] {
    [f.re.re, f.v1.re, f.v2.re, f.v2.v1, f.v2.v2]
}

#[track_caller]
fn agree(name: &str, x: f64, found: [f64; 5], expected: [f64; 5]) {
    agree_to(name, x, found, expected, [32.0; 5]);
}

/// To so many roundings of each number, or of 1 where that is larger.
#[track_caller]
fn agree_to(name: &str, x: f64, found: [f64; 5], expected: [f64; 5], roundings: [f64; 5]) {
    for order in 0..5 {
        let (found, expected) = (found[order], expected[order]);
        let error = (found - expected).abs() / expected.abs().max(1.0);
        assert!(
            error < roundings[order] * super::U,
            "{name} at {x:e}, order {order}: {found:e} for {expected:e}"
        );
    }
}

const POINTS: [f64; 6] = [0.3, 0.75, 1.0, 1.7, 2.6, 5.5];

#[test]
fn functions_of_one_number() {
    for x in POINTS {
        let v = variable(x);
        let (sine, cosine) = elementary::sin_cos(v);
        let (s, c) = (x.sin(), x.cos());
        agree("sin", x, derivatives(sine), [s, c, -s, -c, s]);
        agree("cos", x, derivatives(cosine), [c, -s, -c, s, c]);
        let e = x.exp();
        agree("exp", x, derivatives(elementary::exp(v)), [e; 5]);
        agree("exp_m1", x, derivatives(elementary::exp_m1(v)), [x.exp_m1(), e, e, e, e]);
        let r = 1.0 / x;
        let inverse = [r, -r * r, 2.0 * r.powi(3), -6.0 * r.powi(4), 24.0 * r.powi(5)];
        agree("1/x", x, derivatives(elementary::recip(v)), inverse);
        let powers = |p: f64| {
            let mut factor = 1.0;
            [0, 1, 2, 3, 4].map(|k| {
                let left = p - f64::from(k);
                let value = factor * x.powf(left);
                factor *= left;
                value
            })
        };
        agree("√x", x, derivatives(elementary::sqrt(v)), powers(0.5));
        agree("1/√x", x, derivatives(elementary::inverse_sqrt(v)), powers(-0.5));
        for p in [0.5, 1.0, 2.0, 3.3, 5.0] {
            agree("xᵖ", x, derivatives(elementary::power(v, p)), powers(p));
        }
    }
}

#[test]
fn the_angle_of_a_point_on_the_circle_is_its_parameter() {
    for x in [-3.0, -1.1, 0.0, 0.3, 0.75, 1.7, 2.6] {
        let (s, c) = elementary::sin_cos(variable(x));
        agree("atan2(sin, cos)", x, derivatives(elementary::atan2(s, c)), [x, 1.0, 0.0, 0.0, 0.0]);
    }
}

/// |v₀ + ε w| with n = |v₀|, a the part of w along v₀ and p that across: √((n + aε)² + (pε)²).
#[test]
fn norms_and_directions() {
    for (v, w) in [([3.0, 0.0, 4.0], [1.0, 2.0, -0.5]), ([-0.2, 0.7, 0.1], [0.3, 0.1, -0.9])] {
        let jets = [0, 1, 2].map(|i| {
            Dual2::new(Dual2::new(v[i], w[i], 0.0), Dual2::new(w[i], 0.0, 0.0), Dual2::new(0.0, 0.0, 0.0))
        });
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let n: f64 = dot(v, v).sqrt();
        let a = dot(v, w) / n;
        let p = dot(w, w) - a * a; // p²
        let expected = [n, a, p / n, -3.0 * a * p / (n * n), (12.0 * a * a * p - 3.0 * p * p) / (n * n * n)];
        let (norm, direction) = elementary::norm_and_direction(jets);
        agree("norm", n, derivatives(norm), expected);
        agree("norm alone", n, derivatives(elementary::norm(jets)), expected);
        for i in 0..3 {
            let back = derivatives(direction[i] * norm);
            agree("norm × direction", n, back, [v[i], w[i], 0.0, 0.0, 0.0]);
        }
    }
}

/// φ = (x + ε) e at any number of turns: the log that continues at x e, of exp of it.
#[test]
fn the_continuous_log_of_a_turn_about_one_axis_is_its_angle() {
    let e = [0.48, -0.6, 0.64];
    for turns in [0.0, 1.0, -1.0, 4.0, -3.0] {
        for angle in [0.3, 1.9, 2.4, 2.9, -2.4, -1.0] {
            let x = turns * std::f64::consts::TAU + angle;
            let phi = e.map(|e| variable(x) * e);
            // The quaternion is rounded, and each order divides its roundings by the distance to the whole turn.
            let lateral: f64 = (0.5 * angle).sin().abs();
            let roundings = [0, 1, 2, 3, 4].map(|order| 4.0 * (1.0 + x.abs()) / lateral.powi(order));
            let found = so3::continuous_log_quaternion(so3::exp_quaternion(phi), e.map(|e| x * e)).phi;
            for i in 0..3 {
                let name = format!("log, {turns} turns, component {}", i + 1);
                agree_to(&name, x, derivatives(found[i]), [x * e[i], e[i], 0.0, 0.0, 0.0], roundings);
            }
        }
    }
}

/// The six-sided positions with half a turn of torsion, β = π, where the sign of the quaternion changes: about the third
/// directions β advances as b turns about e3b or e3a, and the component flexions stay α (−sin χ, cos χ), χ = (φ − ψ)/2.
#[test]
fn torsion_passes_half_a_turn() {
    use std::f64::consts::{FRAC_PI_2, PI};
    let quarter = |k: i32| [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)][k.rem_euclid(4) as usize];
    let about_3 = |k: i32| {
        let (c, s) = quarter(k);
        [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
    };
    let about_2 = |k: i32| {
        let (c, s) = quarter(k);
        [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]]
    };
    let mut tried = 0;
    for (alpha, phi, psi) in [-2, -1, 0, 1, 2, 3, 4]
        .into_iter()
        .flat_map(|phi| [2 - phi, -2 - phi].map(|psi| (phi, psi)))
        .flat_map(|(phi, psi)| [0, 1].map(|alpha| (alpha, phi, psi)))
    {
        let r = vector::product(&vector::product(&about_3(phi), &about_2(alpha)), &about_3(psi));
        let turning = variable(0.0);
        let [c, s] = [elementary::sin_cos(turning).1, elementary::sin_cos(turning).0];
        let [zero, one] = [variable(0.0) * 0.0, variable(0.0) * 0.0 + 1.0];
        let about = [[c, -s, zero], [s, c, zero], [zero, zero, one]];
        let r = r.map(|row| row.map(|x| one * x));
        for turned in [vector::product(&about, &r), vector::product(&r, &about)] {
            let found = derivatives(so3::torsion(&turned));
            agree(
                "torsion",
                0.0,
                [found[0].abs(), found[1], found[2], found[3], found[4]],
                [PI, 1.0, 0.0, 0.0, 0.0],
            );
            tried += 1;
        }
        // χ and its rate as b turns about e3b: ψ advances, χ falls by half of it.
        let turned = vector::product(&r, &about);
        let [x, y] = so3::component_flexions(&turned, None, 0.0).map(derivatives);
        let alpha = f64::from(alpha) * FRAC_PI_2;
        // β = π: of the angles that differ by whole turns of ψ, those with φ + ψ = π.
        let chi = f64::from(phi) * FRAC_PI_2 - FRAC_PI_2;
        let (s, c) = chi.sin_cos();
        for (name, found, value, rate) in [("α1", x, -s, c / 2.0), ("α2", y, c, s / 2.0)] {
            assert!(
                (found[0] - alpha * value).abs() < 8.0 * super::U,
                "{name} at φ {phi}, ψ {psi}: {found:?}"
            );
            assert!(
                (found[1] - alpha * rate).abs() < 8.0 * super::U,
                "{name} at φ {phi}, ψ {psi}: {found:?}"
            );
        }
    }
    assert_eq!(tried, 56);
}

/// A number without derivatives has no nilpotent part.
#[test]
fn reals_have_no_nilpotent_part() {
    assert_eq!(2.5_f64.nilpotent(), 0.0);
    assert_eq!(Wide::from_real(pintle_kinematics::scalar::Real::integer(7)).nilpotent().to_f64(), 0.0);
    assert_eq!(variable(2.5).nilpotent().re.re, 0.0);
}

/// exp(ε n^) q₀, all four derivatives from the spin ε n: (cos ε/2, n sin ε/2) q₀; and its log where n is the axis of q₀.
#[test]
fn spins_of_every_order() {
    let [w, v] = [0.6, 0.8].map(f64::from);
    let q0 = [w, v * 0.48, -v * 0.6, v * 0.64];
    let n = [0.36, 0.48, -0.8];
    // (0, n) q₀
    let axis = [q0[1], q0[2], q0[3]];
    let cross = vector::cross(n, axis);
    let first = [
        -(n[0] * axis[0] + n[1] * axis[1] + n[2] * axis[2]),
        w * n[0] + cross[0],
        w * n[1] + cross[1],
        w * n[2] + cross[2],
    ];
    let r = so3::matrix(q0).map(|row| row.map(Jet::from_real));
    let spin = n.map(|component| (variable(0.0)).scale(component));
    for (i, found) in so3::quaternion_along(&r, Some(spin)).into_iter().enumerate() {
        let (c, s) = (q0[i], first[i]);
        agree("exp(σ^) q₀", 0.0, derivatives(found), [c, s / 2.0, -c / 4.0, -s / 8.0, c / 16.0]);
    }
    let along = axis.map(|component| variable(0.0).scale(component / v));
    let angle = 2.0 * v.atan2(w);
    for (i, found) in so3::log_along(&r, Some(along)).into_iter().enumerate() {
        let component = axis[i] / v;
        agree("log exp(ε n^)", 0.0, derivatives(found), [component * angle, component, 0.0, 0.0, 0.0]);
    }
}

/// A double for a number that may be too large for one.
fn alike(found: f64, exact: Wide, scale: Wide) -> bool {
    let nearest = exact.to_f64();
    let is_close = (Wide::from_f64(found) - exact).abs() <= scale * Wide::from_f64(64.0 * super::U);
    is_close || found == nearest || (nearest.abs() > 1e307 && found == f64::INFINITY.copysign(nearest))
}

/// Close to zero a derivative is what it is, or infinite where no double is as large: to the third order of a norm, the second of
/// directions and angles.
#[test]
fn vectors_that_vanish_have_derivatives() {
    let mut compared = [0, 0];
    let zero = Wide::from_f64(0.0);
    for decade in [-77, -100, -104, -110, -150, -154, -156, -160, -200, -250, -300] {
        let scale = 10f64.powi(decade);
        for direction in
            [[1.0, 0.0, 0.0], [0.0, -2.0, 0.0], [1.0, 1.0, 0.0], [0.3, -0.7, 0.2], [1.0, 1.0, -1.0]]
        {
            let v = direction.map(|x| x * scale);
            for w in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 2.0, -0.5]] {
                let [wide_v, wide_w] = [v, w].map(|v| v.map(Wide::from_f64));
                let dot = |a: [Wide; 3], b: [Wide; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
                let n = elementary::norm(wide_v);
                let a = dot(wide_v, wide_w) / n;
                let q = [0, 1, 2].map(|i| wide_w[i] * n - wide_v[i] * a);
                let p = dot(q, q) / (n * n);
                let expected = [n, a, p / n, -(a * p / (n * n)) * 3.0];
                // Of what is formed by subtraction, beside what it is formed from.
                let size = dot(wide_w, wide_w);
                let scales = [n, size, size / n, size * a.abs() / (n * n)];
                let third = elementary::norm([0, 1, 2].map(|i| Dual3::new(v[i], w[i], 0.0, 0.0)));
                let jet = derivatives(elementary::norm([0, 1, 2].map(|i| {
                    Dual2::new(
                        Dual2::new(v[i], w[i], 0.0),
                        Dual2::new(w[i], 0.0, 0.0),
                        Dual2::new(0.0, 0.0, 0.0),
                    )
                })));
                let mixed = elementary::norm(
                    [0, 1, 2].map(|i| HyperHyperDual::new(v[i], w[i], w[i], w[i], 0.0, 0.0, 0.0, 0.0)),
                );
                let found = [
                    [third.re, third.v1, third.v2, third.v3],
                    [jet[0], jet[1], jet[2], jet[3]],
                    [mixed.re, mixed.eps2, mixed.eps1eps3, mixed.eps1eps2eps3],
                ];
                for (kind, found) in found.into_iter().enumerate() {
                    for order in 0..4 {
                        // Twice beyond the range of a double, intermediate products may be.
                        if order == 3 && (n * n).to_f64() < 1e-307 {
                            continue;
                        }
                        let scale = scales[order] + Wide::from_f64(f64::MIN_POSITIVE);
                        assert!(
                            alike(found[order], expected[order], scale),
                            "norm of {v:?} along {w:?}, type {kind}, order {order}: {:e} for {:e}",
                            found[order],
                            expected[order].to_f64()
                        );
                        compared[0] += 1;
                    }
                }
            }
            for function in [Function::Atan2, Function::Direction3] {
                let input = if function == Function::Atan2 { &v[..2] } else { &v[..] };
                if input.iter().all(|x| *x == 0.0) {
                    continue;
                }
                let wide: Vec<Wide> = input.iter().map(|x| Wide::from_f64(*x)).collect();
                for (found, exact) in function.numbers(input).iter().zip(function.numbers(&wide)) {
                    let largest =
                        exact.iter().fold(zero, |most, x| if x.abs() > most { x.abs() } else { most });
                    for (found, exact) in found.iter().zip(&exact) {
                        assert!(
                            alike(*found, *exact, largest),
                            "{function:?} of {v:?}: {found:e} for {:e}",
                            exact.to_f64()
                        );
                        compared[1] += 1;
                    }
                }
            }
        }
    }
    assert!(compared[0] > 2_000 && compared[1] > 1_500, "{compared:?}");
}
