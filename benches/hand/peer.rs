//! What programs have in common that take part in the rounds of `scripts/measure.py`.

use pintle_kinematics::node::Pair;
use serde_json::Value;
use std::io::{BufRead, Write};

/// The state as all read it: X_b − X_a, U_a, U_b, A and B by rows.
pub(crate) fn numbers(pair: &Pair<f64>) -> [f64; 27] {
    let vectors = [pair.reference, pair.a.displacement, pair.b.displacement];
    let triads = [pair.a.triad, pair.b.triad];
    let mut all = vectors.iter().flatten().chain(triads.as_flattened().as_flattened());
    std::array::from_fn(|_| *all.next().unwrap())
}

/// Writes what is known first, then answers each line read with a round.
pub(crate) fn serve(greeting: &Value, mut round: impl FnMut() -> Value) {
    let mut out = std::io::stdout().lock();
    writeln!(out, "{greeting}").unwrap();
    out.flush().unwrap();
    for line in std::io::stdin().lock().lines() {
        line.unwrap();
        writeln!(out, "{}", round()).unwrap();
        out.flush().unwrap();
    }
}
