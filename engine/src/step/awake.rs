//! Threads that stay awake between the phases of steps.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// How often the calling thread looks whether the others keep watch, before it begins without them: 10 to 40 microseconds, as long as a pause of
/// the processor takes, which is about what waking one takes on a machine that has nothing else to do.
const LOOKS: u32 = 1_000;

/// Runs `work` on this thread of a pool and keeps the others from falling asleep meanwhile: waking them in every step would take
/// as long as a tenth of it. They still take whatever `work` shares out.
pub(super) fn awake<T>(work: impl FnOnce() -> T) -> T {
    watched_over(work).0
}

/// The state on which the watching threads decide. It is shared with the stepping thread, which does not wait for the end of the
/// watch: a thread without a core would delay it by a time slice.
#[derive(Debug, Default)]
struct SpinGate {
    /// There is work to share.
    begun: AtomicBool,
    over: AtomicBool,
    /// Threads that came in time.
    watching: AtomicUsize,
}

impl SpinGate {
    /// Takes what there is to do, until it is over.
    fn keep(&self) {
        // A thread that arrives from within a part of the work has received that part after this was set.
        if self.begun.load(Ordering::Acquire) {
            return;
        }
        self.watching.fetch_add(1, Ordering::Relaxed);
        let mut idle = 0u32;
        while !self.over.load(Ordering::Relaxed) {
            if rayon::yield_now() == Some(rayon::Yield::Executed) {
                idle = 0;
            } else if idle < 1000 {
                idle += 1;
                std::hint::spin_loop();
            } else {
                std::thread::yield_now();
            }
        }
    }
}

/// Result of the work, and how many threads kept watch from the beginning.
///
/// Only those may. Once there is work to share, a thread that waits for a part of it may come to its watch from within that part; it would keep watch
/// until all is over, and the part would never end.
fn watched_over<T>(work: impl FnOnce() -> T) -> (T, usize) {
    /// Ends the vigil, whatever way `work` ends.
    struct End<'a>(&'a SpinGate);
    impl Drop for End<'_> {
        fn drop(&mut self) {
            self.0.over.store(true, Ordering::Relaxed);
        }
    }
    let this = rayon::current_thread_index();
    let others = rayon::current_num_threads() - usize::from(this.is_some());
    let vigil = Arc::new(SpinGate::default());
    let theirs = Arc::clone(&vigil);
    rayon::spawn_broadcast(move |thread| {
        if Some(thread.index()) != this {
            theirs.keep();
        }
    });
    let _end = End(&vigil);
    for _ in 0..LOOKS {
        if vigil.watching.load(Ordering::Relaxed) == others {
            break;
        }
        std::hint::spin_loop();
    }
    vigil.begun.store(true, Ordering::Release);
    let done = work();
    (done, vigil.watching.load(Ordering::Relaxed))
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    /// One of two threads is busy until the other has begun: it does not stay for the watch, and does its part of the work.
    #[test]
    fn a_thread_that_comes_late_does_not_keep_watch() {
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
