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
