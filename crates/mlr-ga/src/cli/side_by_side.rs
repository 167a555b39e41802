//! Long independent jobs, several at a time.

use std::{
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
    thread,
};

/// Does the work for each item and returns the results in the items' order: as many at a time as
/// the current pool has threads, each on one thread. After the first error, nothing new is begun.
///
/// A parallel iterator over the items would not do: a thread that waits for the inner one of its
/// job would take up another job meanwhile.
///
/// # Errors
/// The first error of the work.
pub(super) fn side_by_side<T: Sync, R: Send>(
    items: &[T],
    work: impl Fn(&T) -> anyhow::Result<R> + Sync,
) -> anyhow::Result<Vec<R>> {
    let next = AtomicUsize::new(0);
    let stopped = AtomicBool::new(false);
    let results: Mutex<Vec<(usize, anyhow::Result<R>)>> = Mutex::new(Vec::new());
    let workers = rayon::current_num_threads().min(items.len());
    let pools = (0..workers)
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
        .collect::<Result<Vec<_>, _>>()?;
    thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                while !stopped.load(Ordering::Relaxed) {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { break };
                    let result = pool.install(|| work(item));
                    stopped.fetch_or(result.is_err(), Ordering::Relaxed);
                    let mut results = results.lock().unwrap_or_else(PoisonError::into_inner);
                    results.push((index, result));
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use std::{sync::Barrier, time::Duration};

    use anyhow::bail;

    use super::*;

    fn on_threads<R: Send>(threads: usize, run: impl FnOnce() -> R + Send) -> R {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(run)
    }

    #[test]
    fn results_are_in_order_whatever_the_number_of_threads() {
        let items: Vec<u64> = (0..20).collect();
        let run = |threads| {
            on_threads(threads, || {
                side_by_side(&items, |item| {
                    // The last ones are done first.
                    thread::sleep(Duration::from_millis(20 - item));
                    Ok(item * item)
                })
            })
        };
        let expected: Vec<u64> = items.iter().map(|item| item * item).collect();
        for threads in [1, 2, 5] {
            assert_eq!(run(threads).unwrap(), expected);
        }
        assert!(side_by_side(&[], |_: &u64| Ok(())).unwrap().is_empty());
    }

    #[test]
    fn as_many_at_a_time_as_there_are_threads_each_on_one() {
        // Without two at a time, the first would wait for the second forever.
        let both = Barrier::new(2);
        let inner = on_threads(2, || {
            side_by_side(&[0, 1], |_| {
                both.wait();
                Ok(rayon::current_num_threads())
            })
        });
        assert_eq!(inner.unwrap(), [1, 1]);
    }

    #[test]
    fn nothing_is_begun_after_an_error() {
        let begun = AtomicUsize::new(0);
        let items: Vec<usize> = (0..100).collect();
        let result = on_threads(1, || {
            side_by_side(&items, |item| {
                begun.fetch_add(1, Ordering::Relaxed);
                if *item == 3 {
                    bail!("no space left");
                }
                Ok(())
            })
        });
        assert_eq!(result.unwrap_err().to_string(), "no space left");
        assert_eq!(begun.into_inner(), 4);
    }
}
