//! Work shared out over the processors.

use std::sync::Mutex;

/// Works on all items, as many at the same time as there are processors; results come in the order in which they are
/// done.
pub fn side_by_side<T: Send, R: Send>(
    items: impl Iterator<Item = T> + Send,
    work: impl Fn(T) -> R + Sync,
) -> Vec<R> {
    let waiting = Mutex::new(items);
    let next = || waiting.lock().ok().and_then(|mut items| items.next());
    let all = || std::iter::from_fn(next).map(&work).collect::<Vec<R>>();
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    std::thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(all)).collect();
        let own = all();
        let joined = others
            .into_iter()
            .flat_map(|other| other.join().unwrap_or_else(|p| std::panic::resume_unwind(p)));
        own.into_iter().chain(joined).collect()
    })
}
