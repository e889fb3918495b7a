//! Work shared by threads, its results taken in order.
//!
//! A thread that finds nothing to do goes to sleep, and to wake it takes as long as ten or twenty connectors. The fewer times
//! threads wait for each other, the better. What a thread allocates it frees itself. Small blocks that are freed elsewhere wander
//! from thread to thread, and then threads that render text wait for each other's allocators. Tasks on the heap, one for each part
//! of a pipeline, made text by four threads slower than by one.

use pintle_kinematics::connector::Tally;
use rayon::prelude::*;

/// Below this many items the threads cost more than they bring.
const FEW: usize = 64;

/// How many results are held at a time: rendered second derivatives are a hundred kilobytes for each connector.
const HELD: usize = 512;

/// How many items a thread works on before it looks for more, where there are enough of them.
const PART: usize = 64;

/// Whether so many items are shared by threads.
fn is_shared(count: usize) -> bool {
    count >= FEW && rayon::current_num_threads() > 1
}

/// How many of `count` items are worked on before the first of them is taken: one after the other where there is one thread, or little to do.
pub(super) fn held(count: usize) -> usize {
    if is_shared(count) { HELD.min(count) } else { 1 }
}

/// How many of `count` items make a part for [`parts`].
pub(super) fn part(count: usize) -> usize {
    if is_shared(count) { PART } else { count.max(1) }
}

/// Works on each part on the threads of rayon's current pool, and gives what came of it, in the order of the parts.
pub(super) fn parts<P: Send, T: Send>(parts: Vec<P>, work: impl Fn(P) -> T + Sync) -> Vec<T> {
    // By itself a pool of one thread would only be waited for.
    if parts.len() < 2 || rayon::current_num_threads() == 1 {
        return parts.into_iter().map(work).collect();
    }
    parts.into_par_iter().with_max_len(1).map(&work).collect()
}

/// Works on each item, on the threads of rayon's current pool, and takes the results one after another in the order of the items: what is
/// taken does not depend on the number of threads. Results are left in `rooms`, each of which is used again and again, or once where there are as many
/// as items. What a thread needs besides, it makes by `make`, and uses for one item after the other. Gives the sum of what was computed.
///
/// # Errors
/// The first error of `take`; what follows is then not taken.
pub(super) fn in_order<M: Send, S, R: Send, E>(
    items: &mut [M],
    rooms: &mut [R],
    make: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize, &mut M, &mut R) -> Tally + Sync,
    mut take: impl FnMut(&mut R) -> Result<(), E>,
) -> Result<Tally, E> {
    let (mut sum, mut own) = (Tally::default(), make());
    let at_once = rooms.len().max(1);
    for (group, items) in items.chunks_mut(at_once).enumerate() {
        let first = group * at_once;
        if at_once > 1 && is_shared(items.len()) {
            let pairs = items.par_iter_mut().zip(&mut *rooms).enumerate();
            let each = |own: &mut S, (at, (item, room)): (usize, (&mut M, &mut R))| {
                work(own, first + at, item, room)
            };
            let add = |mut sum: Tally, more| {
                sum += more;
                sum
            };
            sum += pairs.map_init(&make, each).reduce(Tally::default, add);
            rooms.iter_mut().take(items.len()).try_for_each(&mut take)?;
            continue;
        }
        for (at, (item, room)) in (first..).zip(items.iter_mut().zip(&mut *rooms)) {
            sum += work(&mut own, at, item, room);
            take(room)?;
        }
    }
    Ok(sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    /// Rooms that are enough for all items, for one, for some parts, and not for whole parts.
    const ROOMS: [usize; 6] = [1, 3, 50, 512, 999, 1000];

    fn with_threads<T: Send>(count: usize, work: impl FnOnce() -> T + Send) -> T {
        rayon::ThreadPoolBuilder::new().num_threads(count).build().unwrap().install(work)
    }

    /// Every item is worked on once and taken in its order, by any number of threads.
    #[test]
    fn results_are_taken_in_order() {
        for threads in [1, 2, 5, 7] {
            for (count, rooms) in
                [10, 64, 1000].into_iter().flat_map(|count| ROOMS.map(|rooms| (count, rooms)))
            {
                let (mut items, mut taken) = (vec![0; count], Vec::new());
                let mut rooms = vec![usize::MAX; rooms];
                let work = |own: &mut usize, at: usize, item: &mut usize, room: &mut usize| {
                    (*item, *room, *own) = (*item + 1, at, *own + 1);
                    Tally { values: at as u64, ..Tally::default() }
                };
                let sum = with_threads(threads, || {
                    in_order(
                        &mut items,
                        &mut rooms,
                        || 0,
                        work,
                        |room| -> Result<(), ()> {
                            taken.push(*room);
                            Ok(())
                        },
                    )
                });
                assert!(
                    taken.iter().copied().eq(0..count),
                    "{threads} threads, {} rooms: {taken:?}",
                    rooms.len()
                );
                assert!(items.iter().all(|item| *item == 1));
                assert_eq!(sum.unwrap().values, (0..count as u64).sum::<u64>());
                if rooms.len() >= count {
                    assert!(rooms[..count].iter().copied().eq(0..count));
                }
            }
            let sums = with_threads(threads, || parts((0..100).collect(), |i: u32| i * i));
            assert!(sums.into_iter().eq((0..100).map(|i| i * i)));
        }
    }

    /// An error ends it, and so does a panic, which nobody waits for.
    #[test]
    fn errors_and_panics_end_it() {
        for threads in [1, 2, 5] {
            let (mut items, mut rooms, mut taken) = (vec![(); 3000], vec![0; 512], 0);
            let run = |last: usize, items: &mut [()], rooms: &mut [usize], taken: &mut usize| {
                let work = |(): &mut (), at: usize, (): &mut (), room: &mut usize| {
                    assert!(at != last, "no more");
                    *room = at;
                    Tally::default()
                };
                let take = |room: &mut usize| {
                    *taken = *room;
                    if *room == 700 { Err(*room) } else { Ok(()) }
                };
                with_threads(threads, || in_order(items, rooms, || (), work, take))
            };
            assert_eq!(run(usize::MAX, &mut items, &mut rooms, &mut taken).err(), Some(700));
            assert_eq!(taken, 700);
            let panicking =
                catch_unwind(AssertUnwindSafe(|| run(600, &mut items, &mut rooms, &mut taken).is_ok()));
            assert!(panicking.is_err() && taken < 600, "{threads} threads: {taken}");
        }
    }
}
