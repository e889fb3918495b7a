/// √(v1² + … + vn²) without overflow or underflow.
fn norm(v: &[f64]) -> f64 {
    let square: f64 = v.iter().map(|x| x * x).sum();
    let largest = v.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if square.is_nan() || largest == 0.0 || (square > 1e-280 && square < 1e300) {
        return square.sqrt();
    }
    largest * v.iter().map(|x| (x / largest) * (x / largest)).sum::<f64>().sqrt()
}
