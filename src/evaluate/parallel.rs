//! Work shared by threads, its results taken in order.

use rayon::prelude::*;

/// Below this many items the threads cost more than they bring.
const FEW: usize = 64;

/// How many results are held at a time: rendered second derivatives are a hundred kilobytes for each connector.
const HELD: usize = 512;

/// Works on each item, on the threads of rayon's current pool, and takes the results one after another in the order of the items: what is
/// taken does not depend on the number of threads.
///
/// # Errors
/// The first error of `take`; what follows is then not taken.
pub(super) fn in_order<M: Send, T: Send, E>(
    items: &mut [M],
    work: impl Fn(usize, &mut M) -> T + Sync,
    mut take: impl FnMut(usize, T) -> Result<(), E>,
) -> Result<(), E> {
    if items.len() < FEW || rayon::current_num_threads() == 1 {
        return items.iter_mut().enumerate().try_for_each(|(at, item)| take(at, work(at, item)));
    }
    for (chunk, items) in items.chunks_mut(HELD).enumerate() {
        let first = chunk * HELD;
        let results: Vec<T> =
            items.par_iter_mut().enumerate().map(|(at, item)| work(first + at, item)).collect();
        for (at, result) in results.into_iter().enumerate() {
            take(first + at, result)?;
        }
    }
    Ok(())
}
