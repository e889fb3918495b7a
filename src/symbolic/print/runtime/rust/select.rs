/// `yes` where the condition holds, else `no`.
fn select(holds: bool, yes: f64, no: f64) -> f64 {
    if holds { yes } else { no }
}
