//! Work shared by threads, its results taken in order.
//!
//! A thread that finds nothing to do goes to sleep, and to wake it takes as long as ten or twenty connectors. So there is no point at which threads wait for each
//! other: while one takes results, the others work on, and what a thread writes besides a result is its own.

use crate::connector::Tally;
use rayon::Yield;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

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

/// How many of `count` items are worked on before the first of them is taken: one by one where there is one thread, or little to do.
pub(super) fn held(count: usize) -> usize {
    if is_shared(count) { HELD.min(count) } else { 1 }
}

/// How many of `count` items make a part for [`parts`].
pub(super) fn part(count: usize) -> usize {
    if is_shared(count) { PART } else { count.max(1) }
}

/// Works on each part on the threads of rayon's current pool, and gives what came of it, in the order of the parts.
pub(super) fn parts<P: Send, T: Send>(parts: Vec<P>, work: impl Fn(P) -> T + Sync) -> Vec<T> {
    match parts.len() {
        0 | 1 => parts.into_iter().map(work).collect(),
        _ => parts.into_par_iter().with_max_len(1).map(&work).collect(),
    }
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
    let mut sum = Tally::default();
    if rooms.len() < 2 || !is_shared(items.len()) {
        let mut own = make();
        let at_once = rooms.len().max(1);
        for (chunk, items) in items.chunks_mut(at_once).enumerate() {
            for (at, (item, room)) in (chunk * at_once..).zip(items.iter_mut().zip(&mut *rooms)) {
                sum += work(&mut own, at, item, room);
                take(room)?;
            }
        }
        return Ok(sum);
    }
    let size = (rooms.len() / (2 * rayon::current_num_threads())).clamp(1, PART);
    // A room for each item of a part.
    let used = if rooms.len() < items.len() { rooms.len() / size * size } else { rooms.len() };
    let (make, work) = (&make, &work);
    rayon::in_place_scope_fifo(|scope| {
        let mut parts = items.chunks_mut(size).enumerate();
        let mut begin = |rooms| {
            let (number, items) = parts.next()?;
            let count = items.len();
            let (done, result) = sync_channel(1);
            scope.spawn_fifo(move |_| {
                let (rooms, mut own, mut tally): (&mut [R], _, _) = (rooms, make(), Tally::default());
                for (at, (item, room)) in (number * size..).zip(items.iter_mut().zip(&mut *rooms)) {
                    tally += work(&mut own, at, item, room);
                }
                // After an error nobody takes it.
                _ = done.send((rooms, tally));
            });
            Some((count, result))
        };
        let mut under_way: VecDeque<_> = rooms[..used].chunks_mut(size).map_while(&mut begin).collect();
        while let Some((count, result)) = under_way.pop_front() {
            // What is not there has panicked, which the scope hands on.
            let Some((rooms, tally)) = wait_for(&result) else { break };
            sum += tally;
            rooms.iter_mut().take(count).try_for_each(&mut take)?;
            under_way.extend(begin(rooms));
        }
        Ok(sum)
    })
}

/// What comes there, after the work that this thread can do until then; nothing where nothing can come.
fn wait_for<T>(result: &Receiver<T>) -> Option<T> {
    loop {
        match result.try_recv() {
            Ok(found) => return Some(found),
            Err(TryRecvError::Disconnected) => return None,
            Err(TryRecvError::Empty) if rayon::yield_now() == Some(Yield::Executed) => {}
            Err(TryRecvError::Empty) => return result.recv().ok(),
        }
    }
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
