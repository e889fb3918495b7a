/// The n-th Taylor coefficient at s ≥ 0 of cos(√s/2) (b = 1) or 2 sin(√s/2)/√s (b = 3).
fn root_coefficient(n: i32, b: i32, s: f64) -> f64 {
    if s < 16.0 {
        let mut value = 1.0;
        for m in (0..=40).rev() {
            value = 1.0 - value * s / (8.0 * f64::from(m + 1) * f64::from(b + 2 * (m + n)));
        }
        for m in 0..n {
            value /= -8.0 * f64::from(m + 1) * f64::from(b + 2 * m);
        }
        return value;
    }
    let (mut w, mut k) = ((0.5 * s.sqrt()).cos(), (0.5 * s.sqrt()).sin() / s.sqrt());
    for m in 0..n {
        // w′ = −k/4 and s k′ = w/4 − k/2, and their derivatives.
        let next = -k / f64::from(4 * (m + 1));
        k = (0.25 * w - (f64::from(m) + 0.5) * k) / (f64::from(m + 1) * s);
        w = next;
    }
    if b == 1 { w } else { 2.0 * k }
}
