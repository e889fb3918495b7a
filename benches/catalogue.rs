//! Time per evaluation of every connection type: value, value and Jacobian, value, Jacobian and Hessian.
//!
//! Before anything is timed, the numbers are compared with those of the 237-bit scalar. Read the figures as ratios within
//! one run: `cargo bench -- TRANSLATOR` times one type.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use pintle_audit::case::exact_state;
use pintle_kinematics::catalog::{ConnectionType, TABLE};
use pintle_kinematics::connector::{Connector, Definition, Increment, Output, Request, State, Tally};
use pintle_kinematics::node::{DOFS, Node, Pair};
use pintle_kinematics::scalar::Wide;
use pintle_kinematics::so3;
use std::hint::black_box;

/// States per sample, all different, so that branches are not learnt by heart.
const STATES: usize = 32;

/// The largest error, relative to the largest entry of the row, that lets a type be timed.
const BOUND: f64 = 1e-13;

fn pair(seed: f64) -> Pair<f64> {
    let node = |a: f64, b: f64, c: f64, flow: f64| Node {
        displacement: [0.1 * a, 0.2 * b, 0.3 * c],
        triad: so3::matrix(so3::exp_quaternion([a, b, c])),
        flow,
    };
    Pair {
        reference: [1.0, 0.3, -0.7],
        a: node(0.3 + seed, -0.5, 0.2, 0.1),
        b: node(-0.2, 0.6 + seed, 0.9 - seed, 0.02),
    }
}

fn definition(connection: &ConnectionType) -> Definition {
    Definition { flow_scale: 50.0, ..Definition::new(connection.clone(), pair(0.0)) }
}

fn state(seed: f64) -> State<f64> {
    State { pair: pair(seed), velocity: [0.0; DOFS], acceleration: [0.0; DOFS] }
}

fn request(order: u8) -> Request {
    Request::new(&[Output::CU, Output::RES], [true; 6], order)
}

/// Panics unless rows and second derivatives equal the truth.
fn assert_correct(connection: &ConnectionType) {
    let definition = definition(connection);
    let (double, wide) = (Connector::<f64>::new(&definition), Connector::<Wide>::new(&definition));
    let mut tally = Tally::default();
    for i in 0..STATES {
        let at = state(i as f64 * 0.01);
        let all = request(2);
        let found = double.evaluate(&at, &Increment::none(), &double.initial_branch(), &all, &mut tally);
        let truth =
            wide.evaluate(&exact_state(&at), &Increment::none(), &wide.initial_branch(), &all, &mut tally);
        for k in 0..6 {
            let rows = |of: Option<[f64; DOFS]>| of.unwrap_or([0.0; DOFS]);
            let row = rows(found.jacobian[k]);
            let exact_row = rows(truth.jacobian[k].map(|row| row.map(Wide::to_f64)));
            assert_close(connection, &row, &exact_row);
            if let (Some(hessian), Some(exact)) = (&found.hessian[k], &truth.hessian[k]) {
                let exact = exact.map(|row| row.map(Wide::to_f64));
                assert_close(connection, hessian.as_flattened(), exact.as_flattened());
            }
        }
    }
}

fn assert_close(connection: &ConnectionType, found: &[f64], exact: &[f64]) {
    let scale = exact.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
    for (x, y) in found.iter().zip(exact) {
        assert!((x - y).abs() <= BOUND * scale, "{}: {x:e} where the truth is {y:e}", connection.name);
    }
}

fn catalogue(criterion: &mut Criterion) {
    for connection in TABLE {
        assert_correct(connection);
        let connector = Connector::<f64>::new(&definition(connection));
        let states: Vec<State<f64>> = (0..STATES).map(|i| state(i as f64 * 0.01)).collect();
        let branch = connector.initial_branch();
        let mut group = criterion.benchmark_group(connection.name.as_ref());
        group.throughput(criterion::Throughput::Elements(STATES as u64));
        for (order, name) in ["value", "Jacobian", "Hessian"].into_iter().enumerate() {
            let request = request(order as u8);
            group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
                let mut tally = Tally::default();
                bencher.iter(|| {
                    for state in &states {
                        let increment = Increment::none();
                        black_box(connector.evaluate(
                            black_box(state),
                            &increment,
                            &branch,
                            &request,
                            &mut tally,
                        ));
                    }
                });
            });
        }
        group.finish();
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().sample_size(20).warm_up_time(std::time::Duration::from_millis(200))
        .measurement_time(std::time::Duration::from_millis(500));
    targets = catalogue
}
criterion_main!(benches);
