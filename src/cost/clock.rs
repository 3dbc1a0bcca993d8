//! Time spent, by two clocks.

use cpu_time::ThreadTime;
use std::time::{Duration, Instant};

/// Seconds that some work took.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seconds {
    /// CPU time of the one thread that did it: what others do on the machine is not in it.
    pub cpu: f64,
    /// Time on the wall.
    pub wall: f64,
}

/// Shorter work is done again until so much time has passed, because clocks have a grain and caches warm up.
const LONG_ENOUGH: Duration = Duration::from_millis(2);

/// Most repetitions.
const REPETITIONS: u32 = 16;

/// The result of `work`, and what it takes once, which is the least of several runs when they are short: whatever disturbs a
/// run makes it longer.
///
/// The work has to stay on the thread of the caller, see [`super::workers`], and to give the same result every time.
pub(super) fn timed<T>(mut work: impl FnMut() -> T) -> (T, Seconds) {
    let begin = Instant::now();
    let mut once = || {
        let (cpu, wall) = (ThreadTime::now(), Instant::now());
        let result = work();
        let spent = Seconds {
            cpu: cpu.elapsed().as_secs_f64(),
            wall: wall.elapsed().as_secs_f64(),
        };
        (result, spent)
    };
    let (result, mut least) = once();
    for _ in 1..REPETITIONS {
        if begin.elapsed() >= LONG_ENOUGH {
            break;
        }
        let (_, spent) = once();
        least.cpu = least.cpu.min(spent.cpu);
        least.wall = least.wall.min(spent.wall);
    }
    (result, least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_takes_time_on_the_wall_and_none_of_the_processor() {
        let ((), spent) = timed(|| std::thread::sleep(Duration::from_millis(30)));
        assert!(spent.wall >= 0.03, "{spent:?}");
        // going to sleep and waking up take microseconds; a busy wait would take all of it
        assert!(spent.cpu < 0.01, "{spent:?}");
    }

    #[test]
    fn short_work_is_repeated() {
        let mut count = 0;
        let (last, _) = timed(|| {
            count += 1;
            count
        });
        assert_eq!(last, 1, "the result of the first run");
        assert_eq!(count, REPETITIONS);
    }
}
