//! Throughput of the audit: cases per second of each oracle, of the laws and of the mutants, on one thread.
//!
//! `cargo bench --bench audit -- TRANSLATOR` times one type. The command's own time is that of `pintle audit`.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use pintle::audit::sample::{Draw, Region, draw_case};
use pintle::audit::{Case, Oracle, Settings, audit_case};
use pintle::catalog::{ConnectionType, TABLE};
use std::hint::black_box;

/// A type with few components, one with many, one of rotations only, one with a one-form.
const TYPES: [&str; 4] = ["AXIAL", "TRANSLATOR", "ROTATION", "RETRACTOR"];

fn cases(connection: &ConnectionType) -> Vec<Case> {
    let draw = &mut Draw::new("bench");
    (0..8).filter_map(|_| draw_case(connection, Region::Aligned, draw)).collect()
}

fn throughput(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("audit");
    group.sample_size(10);
    for connection in TABLE.iter().filter(|entry| TYPES.contains(&entry.name.as_ref())) {
        let cases = cases(connection);
        group.throughput(Throughput::Elements(cases.len() as u64));
        for oracle in Oracle::ALL {
            let settings = Settings { oracles: [oracle].into(), ..Settings::default() };
            // The index decides whether laws and mutants are tried: not with 1.
            let run = |wide: bool, index: usize| {
                cases.iter().map(|case| audit_case(case, &settings, wide, index).len()).sum::<usize>()
            };
            assert!(run(oracle.is_wide(), 1) > 0 || oracle.is_wide(), "{}", oracle.name());
            let id = BenchmarkId::new(oracle.name(), &connection.name);
            group.bench_function(id, |bencher| bencher.iter(|| black_box(run(oracle.is_wide(), 1))));
        }
        let settings = Settings::default();
        for (name, wide, index) in
            [("doubles", false, 1), ("doubles with laws and mutants", false, 0), ("all", true, 0)]
        {
            let run =
                || cases.iter().map(|case| audit_case(case, &settings, wide, index).len()).sum::<usize>();
            group.bench_function(BenchmarkId::new(name, &connection.name), |bencher| {
                bencher.iter(|| black_box(run()));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, throughput);
criterion_main!(benches);
