//! Work shared by threads, its results taken in order.

use rayon::prelude::*;

/// Below this many items the threads cost more than they bring.
const FEW: usize = 64;

/// How many results are held at a time: rendered second derivatives are a hundred kilobytes for each connector.
const HELD: usize = 512;

/// How many of `count` items are worked on before the first of them is taken: one by one where there is one thread, or little to do.
pub(super) fn held(count: usize) -> usize {
    if count < FEW || rayon::current_num_threads() == 1 { 1 } else { HELD.min(count) }
}

/// Works on each item, on the threads of rayon's current pool, and takes the results one after another in the order of the items: what is
/// taken does not depend on the number of threads. As many items are worked on at a time as there are `rooms`, each of which is used
/// again and again.
///
/// # Errors
/// The first error of `take`; what follows is then not taken.
pub(super) fn in_order<M: Send, R: Send, T: Send, E>(
    items: &mut [M],
    rooms: &mut [R],
    work: impl Fn(usize, &mut M, &mut R) -> T + Sync,
    mut take: impl FnMut(usize, T, &mut R) -> Result<(), E>,
) -> Result<(), E> {
    if let [room] = rooms {
        return items.iter_mut().enumerate().try_for_each(|(at, item)| {
            let result = work(at, item, room);
            take(at, result, room)
        });
    }
    let at_once = rooms.len().max(1);
    for (chunk, items) in items.chunks_mut(at_once).enumerate() {
        let first = chunk * at_once;
        if held(items.len()) == 1 {
            for (at, (item, room)) in items.iter_mut().zip(rooms.iter_mut()).enumerate() {
                let result = work(first + at, item, room);
                take(first + at, result, room)?;
            }
            continue;
        }
        let pairs = items.par_iter_mut().zip(rooms.par_iter_mut()).enumerate();
        let results: Vec<T> = pairs.map(|(at, (item, room))| work(first + at, item, room)).collect();
        for (at, (result, room)) in results.into_iter().zip(rooms.iter_mut()).enumerate() {
            take(first + at, result, room)?;
        }
    }
    Ok(())
}
