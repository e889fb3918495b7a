/// 1/x, and 0 where that is infinite: the derivative of least norm at a point that has none.
fn reciprocal(x: f64) -> f64 {
    let inverse = 1.0 / x;
    if inverse.is_infinite() { 0.0 } else { inverse }
}
