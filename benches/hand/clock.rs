//! How a call is timed that takes part in the rounds of `scripts/measure.py`.

use std::time::{Duration, Instant};

/// States per call. The first stay in the first cache with their rows.
pub(crate) const BATCHES: [usize; 4] = [32, 1000, 4096, 100_000];
/// The time of one measurement, of which the least call counts.
const BUDGET: Duration = Duration::from_millis(25);

/// The least time of one call within the budget, in ns.
pub(crate) fn time(count: usize, mut call: impl FnMut()) -> f64 {
    let calls = 2048 / count.min(2048);
    let (begin, mut least) = (Instant::now(), f64::INFINITY);
    let mut samples = 0;
    while samples < 3 || begin.elapsed() < BUDGET {
        let start = Instant::now();
        (0..calls).for_each(|_| call());
        least = least.min(start.elapsed().as_secs_f64() / calls as f64);
        samples += 1;
    }
    1e9 * least
}
