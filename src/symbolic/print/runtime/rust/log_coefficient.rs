/// The n-th Taylor coefficient of K(c) = 2 acos(c)/√(1 − c²) at c in (−1, 1]: the rotation vector of the unit quaternion (w, v) is
/// K(w) v. For c > 0 the series 2 (−½)ⁿ n!/(3/2)_n ₂F₁(n + 1, n + 1; n + 3/2; (1 − c)/2).
fn log_coefficient(n: i32, c: f64) -> f64 {
    let rest = (1.0 - c) * (1.0 + c);
    if c > 0.0 {
        let y = 0.5 * (1.0 - c);
        let mut value = 1.0;
        for m in (0..=80 + 2 * n).rev() {
            let squares = 2.0 * f64::from(n + 1 + m) * f64::from(n + 1 + m);
            value = 1.0 + value * y * squares / (f64::from(2 * n + 3 + 2 * m) * f64::from(m + 1));
        }
        value *= 2.0;
        for m in 0..n {
            value *= -f64::from(m + 1) / f64::from(3 + 2 * m);
        }
        return value;
    }
    let (mut before, mut value) = (0.0, 2.0 * c.acos() / rest.sqrt());
    for m in 0..n {
        // (1 − c²) K′ = c K − 2 and its derivatives.
        let last = if m == 0 { -2.0 } else { f64::from(m) * before };
        let next = (f64::from(2 * m + 1) * c * value + last) / (f64::from(m + 1) * rest);
        (before, value) = (value, next);
    }
    value
}
