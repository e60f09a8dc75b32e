//! Ctrl-C and the end of the session.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

#[cfg(unix)]
use signal_hook::consts::SIGUSR1;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;
use signal_hook::iterator::Signals;

use super::{Exit, Failure};

/// Paths that are removed, the last first, when the program is ended at once.
static TEMPORARY: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn temporary() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARY.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A file, or an empty folder, that is removed when the program is ended at once; until this is dropped.
#[derive(Debug)]
pub struct Temporary(PathBuf);

impl Temporary {
    /// From now on.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        temporary().push(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let mut all = temporary();
        if let Some(place) = all.iter().rposition(|path| *path == self.0) {
            all.remove(place);
        }
    }
}

/// Ends the program with this code, whatever its threads do, without what is [`Temporary`].
pub fn end_at_once(code: i32) -> ! {
    // Held to the end, so that a path cannot be withdrawn from the list while it is being removed.
    let all = temporary();
    for path in all.iter().rev() {
        // A folder that is not empty stays.
        let _ = fs::remove_file(path).or_else(|_| fs::remove_dir(path));
    }
    signal_hook::low_level::exit(code)
}

/// A flag that Ctrl-C, the end of the session and SIGUSR2 set; the second time they end the program at once, with code 130 and without what is
/// [`Temporary`].
///
/// # Errors
/// If the system does not let signals be caught.
pub fn stop_on_request() -> Result<Arc<AtomicBool>, Failure> {
    let failed = |error: std::io::Error| Failure::run(format!("signals cannot be caught: {error}"));
    let stop = Arc::new(AtomicBool::new(false));
    let noted = Arc::clone(&stop);
    // Launchers of several processes forward SIGUSR2 to all of them, and end them soon after the other two.
    #[cfg(unix)]
    flag::register(signal_hook::consts::SIGUSR2, Arc::clone(&stop)).map_err(failed)?;
    let mut signals = Signals::new([SIGINT, SIGTERM]).map_err(failed)?;
    // A thread may do what a signal's handler may not, as removing files.
    let listener = std::thread::Builder::new().name("signals".to_owned());
    listener
        .spawn(move || {
            for _ in signals.forever() {
                if noted.swap(true, Ordering::Relaxed) {
                    end_at_once(Exit::AtOnce as i32);
                }
            }
        })
        .map_err(failed)?;
    Ok(stop)
}

/// A flag that the signal SIGUSR1 sets, where there is such a signal.
///
/// # Errors
/// If the system does not let signals be caught.
pub fn note_on_request() -> Result<Arc<AtomicBool>, Failure> {
    let noted = Arc::new(AtomicBool::new(false));
    #[cfg(unix)]
    flag::register(SIGUSR1, Arc::clone(&noted))
        .map_err(|error| Failure::run(format!("signals cannot be caught: {error}")))?;
    Ok(noted)
}
