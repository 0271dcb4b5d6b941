//! Parallel work.

use std::sync::Mutex;

/// Processes items in parallel, one per processor at a time, and returns the results in the order of the items.
pub fn in_parallel<T: Send, R: Send>(
    items: impl Iterator<Item = T> + Send,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let waiting = Mutex::new(items.enumerate());
    let next = || waiting.lock().ok().and_then(|mut items| items.next());
    let all = || std::iter::from_fn(next).map(|(i, item)| (i, work(item))).collect::<Vec<(usize, R)>>();
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(all)).collect();
        let mut done = all();
        for other in others {
            done.extend(other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
        }
        done.sort_by_key(|(i, _)| *i);
        done.into_iter().map(|(_, result)| result).collect()
    })
}
