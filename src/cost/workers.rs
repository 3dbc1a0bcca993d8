//! Jobs on several threads, each job on one of them alone, so that its CPU time can be told.

use rayon::ThreadPoolBuildError;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

/// Runs `work` on every job and returns the results in the order of the jobs.
///
/// Integrators spread over the threads of the pool that they are called in. Here each worker is a pool of one thread: nothing
/// spreads, and no idle thread looks for work on somebody's account. Jobs are begun in their order.
///
/// # Errors
/// When the system has no threads left.
pub(super) fn run<J: Sync, T: Send>(
    threads: usize,
    jobs: &[J],
    work: impl Fn(&J) -> T + Sync,
) -> Result<Vec<T>, ThreadPoolBuildError> {
    let pools = (0..threads.clamp(1, jobs.len().max(1)))
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
        .collect::<Result<Vec<_>, _>>()?;
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<T>>> = Mutex::new(jobs.iter().map(|_| None).collect());
    let take = || loop {
        let index = next.fetch_add(1, Ordering::Relaxed);
        let Some(job) = jobs.get(index) else { break };
        let result = work(job);
        results.lock().unwrap_or_else(|poisoned| poisoned.into_inner())[index] = Some(result);
    };
    thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| pool.install(take));
        }
    });
    let results = results.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    // a job without a result has panicked, and its panic has come out of the scope
    Ok(results.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;

    #[test]
    fn results_come_in_the_order_of_the_jobs_on_any_number_of_threads() {
        let jobs: Vec<u64> = (0..100).collect();
        let squares: Vec<u64> = jobs.iter().map(|n| n * n).collect();
        for threads in [1, 3, 1000] {
            assert_eq!(run(threads, &jobs, |n| n * n).unwrap(), squares);
        }
        assert!(run(4, &[] as &[u64], |n| *n).unwrap().is_empty());
    }

    #[test]
    fn parallel_work_stays_on_the_thread_of_its_job() {
        let results = run(2, &[1, 2, 3], |_| {
            let own = thread::current().id();
            (0..64).into_par_iter().all(|_| thread::current().id() == own)
        });
        assert_eq!(results.unwrap(), [true; 3]);
    }
}
