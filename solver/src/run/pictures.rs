//! The pictures of the end, which take long for many grains and are no part of the results: a request to stop does not wait for
//! them.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use mercury_common::whole_file::write_whole;
use mercury_pictures::energy_page;

use crate::output::{OutputError, Written, draw_final};
use crate::plan::Plan;

/// The interval between two checks for a request to stop.
const LOOK: Duration = Duration::from_millis(20);

/// Draws the final state and the energies; returns false if a stop was requested meanwhile. An earlier request, which ended the
/// run itself, does not count.
pub(super) fn draw_pictures(
    folder: PathBuf,
    plan: Arc<Plan>,
    written: Arc<Written>,
    stop: &AtomicBool,
) -> Result<bool, OutputError> {
    unless_stopped(stop, move |gate| {
        let put = |path: &Path, bytes: &[u8]| gate.pass(|| Ok(write_whole(path, bytes)?));
        if let Some(last) = &written.last {
            draw_final(&folder, &plan, last, &put)?;
        }
        let stem = folder.join(format!("{}.energy", plan.outputs().prefix()));
        gate.pass(|| {
            energy_page(plan.outputs().title(), &written.energies).write(&stem)?;
            Ok(())
        })
    })
}

/// Lets files through until the work is given up.
#[derive(Debug, Default)]
struct Gate {
    is_shut: Mutex<bool>,
}

impl Gate {
    /// Writes whole files; false, and nothing is written, if the work was given up.
    fn pass(&self, write: impl FnOnce() -> Result<(), OutputError>) -> Result<bool, OutputError> {
        let is_shut = self.is_shut.lock().unwrap_or_else(PoisonError::into_inner);
        match *is_shut {
            true => Ok(false),
            false => write().map(|()| true),
        }
    }

    /// From now on nothing is written; waits for a write in progress.
    fn shut(&self) {
        *self.is_shut.lock().unwrap_or_else(PoisonError::into_inner) = true;
    }
}

/// Does work in a thread of its own. On a request to stop the thread is abandoned with its gate shut, and false is returned.
fn unless_stopped(
    stop: &AtomicBool,
    work: impl FnOnce(&Gate) -> Result<bool, OutputError> + Send + 'static,
) -> Result<bool, OutputError> {
    let gate = Arc::new(Gate::default());
    if stop.load(Ordering::Relaxed) {
        return work(&gate);
    }
    let (done, doing) = channel();
    let inside = Arc::clone(&gate);
    let thread = std::thread::spawn(move || {
        // The receiver is gone if the work was abandoned.
        let _ = done.send(work(&inside));
    });
    loop {
        match doing.recv_timeout(LOOK) {
            Ok(outcome) => return outcome,
            Err(RecvTimeoutError::Timeout) if stop.load(Ordering::Relaxed) => {
                gate.shut();
                return Ok(false);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => match thread.join() {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(()) => return Ok(false),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_leaves_the_work_alone_and_nothing_is_written_any_more() {
        let place = tempfile::tempdir().unwrap();
        let [early, late] = ["early", "late"].map(|name| place.path().join(name));
        let stop = Arc::new(AtomicBool::new(false));
        let (go_on, wait) = channel::<()>();
        let (tell, reported) = channel();
        let (asks, paths) = (Arc::clone(&stop), [early.clone(), late.clone()]);
        let is_done = unless_stopped(&stop, move |gate| {
            let put = |path: &Path| gate.pass(|| Ok(write_whole(path, b"x")?));
            assert!(put(&paths[0])?);
            // Ctrl-C, and then work without end.
            asks.store(true, Ordering::Relaxed);
            let _ = wait.recv();
            let is_put = put(&paths[1]);
            let _ = tell.send(matches!(is_put, Ok(false)));
            is_put
        });
        assert!(!is_done.unwrap());
        assert!(early.exists());
        go_on.send(()).unwrap();
        assert!(reported.recv().unwrap(), "it was let through");
        assert!(!late.exists());
    }

    #[test]
    fn work_comes_to_its_end_where_no_stop_was_requested() {
        for asked in [false, true] {
            let place = tempfile::tempdir().unwrap();
            let file = place.path().join("a");
            let path = file.clone();
            let is_done = unless_stopped(&AtomicBool::new(asked), move |gate| {
                gate.pass(|| Ok(write_whole(&path, b"x")?))
            });
            assert!(is_done.unwrap());
            assert!(file.exists());
        }
    }

    #[test]
    fn what_goes_wrong_is_reported() {
        let path = Path::new("/there/is/no/such/folder/a").to_owned();
        let outcome = unless_stopped(&AtomicBool::new(false), move |gate| {
            gate.pass(|| Ok(write_whole(&path, b"x")?))
        });
        assert!(outcome.is_err());
    }
}
