//! Threads that stay awake between the phases of steps.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// How often the calling thread looks whether the others keep watch, before it begins without them: 10 to 40 microseconds, as long as a pause of
/// the processor takes, which is about what waking one takes on a machine that has nothing else to do.
const LOOKS: u32 = 1_000;

/// Runs `work` on this thread of a pool and keeps the others from falling asleep meanwhile: waking them in every step would take
/// as long as a tenth of it. They still take whatever `work` shares out.
pub(super) fn awake<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    watched_over(work).0
}

/// The same, and how many threads kept watch from the beginning.
///
/// Only those may. Once there is work to share, a thread that waits for a part of it may come to its watch from within that part; it would keep watch
/// until all is over, and the part would never end.
fn watched_over<T: Send>(work: impl FnOnce() -> T + Send) -> (T, usize) {
    /// Ends the vigil, whatever way `work` ends.
    struct End<'a>(&'a AtomicBool);
    impl Drop for End<'_> {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    let (begun, over) = (AtomicBool::new(false), AtomicBool::new(false));
    let watching = AtomicUsize::new(0);
    let this = rayon::current_thread_index();
    let others = rayon::current_num_threads() - usize::from(this.is_some());
    let done = rayon::in_place_scope(|scope| {
        scope.spawn_broadcast(|_, thread| {
            // Who has come here from within a part of the work has got that part after this was set.
            if Some(thread.index()) == this || begun.load(Ordering::Acquire) {
                return;
            }
            watching.fetch_add(1, Ordering::Relaxed);
            let mut idle = 0u32;
            while !over.load(Ordering::Relaxed) {
                if rayon::yield_now() == Some(rayon::Yield::Executed) {
                    idle = 0;
                } else if idle < 1000 {
                    idle += 1;
                    std::hint::spin_loop();
                } else {
                    std::thread::yield_now();
                }
            }
        });
        let _end = End(&over);
        for _ in 0..LOOKS {
            if watching.load(Ordering::Relaxed) == others {
                break;
            }
            std::hint::spin_loop();
        }
        begun.store(true, Ordering::Release);
        work()
    });
    (done, watching.into_inner())
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    /// One of two threads is busy until the other has begun: it does not stay for the watch, and does its part of the work.
    #[test]
    fn who_comes_late_does_not_keep_watch() {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(2)
            .build()
            .unwrap();
        let (begin, begun) = channel();
        let (take, taken) = channel();
        pool.spawn(move || {
            take.send(()).unwrap();
            begun.recv().unwrap();
        });
        taken.recv().unwrap();
        let (sum, watching) = pool.install(|| {
            watched_over(|| {
                begin.send(()).unwrap();
                let parts = pool.broadcast(|thread| thread.index() + 1);
                parts.iter().sum::<usize>()
            })
        });
        assert_eq!((sum, watching), (3, 0));
    }

    /// Threads that have nothing to do keep watch, on a machine that lets them; all that is shared out is done in any case.
    #[test]
    fn what_is_shared_out_is_done() {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(3)
            .build()
            .unwrap();
        for round in 0..200 {
            let (sum, watching) = pool.install(|| {
                watched_over(|| {
                    let (a, b) = rayon::join(|| rayon::join(|| round, || 1), || 2);
                    a.0 + a.1 + b
                })
            });
            assert_eq!(sum, round + 3);
            assert!(watching <= 2);
        }
    }
}
