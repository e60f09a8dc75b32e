//! Threads that stay awake between the phases of steps.

use std::sync::atomic::{AtomicBool, Ordering};

/// Runs `work` on this thread of a pool and keeps the others from falling asleep meanwhile: waking them in every step would take
/// as long as a tenth of it. They still take whatever `work` shares out.
pub(super) fn awake<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    /// Ends the vigil, whatever way `work` ends.
    struct End<'a>(&'a AtomicBool);
    impl Drop for End<'_> {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    let over = AtomicBool::new(false);
    let this = rayon::current_thread_index();
    rayon::in_place_scope(|scope| {
        scope.spawn_broadcast(|_, thread| {
            let mut idle = 0u32;
            while Some(thread.index()) != this && !over.load(Ordering::Relaxed) {
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
        work()
    })
}
