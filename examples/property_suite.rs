//! A property suite for an element routine of one's own, on pintle's states: four properties of a hand-written AXIAL.
//!
//! `cargo run --example property_suite --features proptest`

use pintle::audit::strategies;
use pintle::audit::{AssertOk, Candidate};
use pintle::catalog::ConnectionType;
use pintle::connector::{Definition, State};
use pintle::node::{Node, Pair};
use pintle::vector::identity;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

/// u1 = |d| − |d₀| and its row.
fn routine(state: &State<f64>, initial: f64) -> (f64, [f64; 14]) {
    let d = state.pair.separation();
    let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut row = [0.0; 14];
    for i in 0..3 {
        row[i] = -d[i] / length;
        row[7 + i] = d[i] / length;
    }
    (length - initial, row)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let node = Node { displacement: [0.0; 3], triad: identity(), flow: 0.0 };
    let pair = Pair { reference: [2.0, 0.0, 0.0], a: node, b: node };
    let axial = Definition::new(ConnectionType::named("AXIAL", None)?, pair);
    let mut runner = TestRunner::default();

    // A rigid translation of both nodes changes nothing.
    runner.run(&strategies::state(&axial), |case| {
        let end = case.last().ok_or_else(|| TestCaseError::fail("no state"))?;
        let (_, row) = routine(&end.state, 2.0);
        for i in 0..3 {
            prop_assert!((row[i] + row[7 + i]).abs() < 1e-15);
        }
        Ok(())
    })?;
    println!("rigid translations: passed");

    // The rate, the row times the rates of the nodes, is what the value changes by when the nodes go on with these rates for a short time.
    runner.run(&strategies::history(&axial, 2), |case| {
        let end = case.last().ok_or_else(|| TestCaseError::fail("no state"))?;
        let (_, row) = routine(&end.state, 2.0);
        let rate: f64 = row.iter().zip(&end.state.velocity).map(|(r, v)| r * v).sum();
        let speed = end.state.velocity.iter().fold(1.0, |most: f64, v| most.max(v.abs()));
        let distance = end.state.pair.separation().iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let step = 1e-5 * distance / speed;
        let [before, after] = [-step, step].map(|time| {
            let mut state = end.state;
            for i in 0..3 {
                state.pair.a.displacement[i] += time * state.velocity[i];
                state.pair.b.displacement[i] += time * state.velocity[7 + i];
            }
            routine(&state, 2.0).0
        });
        let difference = (after - before) / (2.0 * step);
        prop_assert!((rate - difference).abs() <= 1e-7 * speed, "{rate}, by a difference {difference}");
        Ok(())
    })?;
    println!("rates: passed");

    // Down to 1e-12 from coincident nodes the row is a direction: of length one.
    runner.run(&strategies::near_singular(&axial.connection), |case| {
        let case = case.ok_or_else(|| TestCaseError::fail("AXIAL has a singular set"))?;
        let end = case.last().ok_or_else(|| TestCaseError::fail("no state"))?;
        let (_, row) = routine(&end.state, 2.0);
        for node in row.chunks(7) {
            let length = node.iter().map(|x| x * x).sum::<f64>().sqrt();
            prop_assert!((length - 1.0).abs() < 1e-15, "{length}");
        }
        Ok(())
    })?;
    println!("directions near coincident nodes: passed");

    // Everything else, by the audit.
    let report = Candidate::new("my AXIAL", &axial).check(|state| {
        let (value, row) = routine(state, 2.0);
        ([Some(value), None, None, None, None, None], [Some(row), None, None, None, None, None])
    });
    report.assert_ok();
    println!("audit: {} numbers compared, none wrong", report.compared());
    Ok(())
}
