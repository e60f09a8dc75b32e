//! Ctrl-C and the end of the session.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

#[cfg(unix)]
use signal_hook::consts::SIGUSR1;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::Failure;

/// A flag that Ctrl-C and the end of the session set; the second time they end the program at once, with code 130.
///
/// # Errors
/// If the system does not let signals be caught.
pub fn stop_on_request() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the shutdown looks at the flag before this signal sets it.
        flag::register_conditional_shutdown(signal, 130, Arc::clone(&stop))
            .and_then(|_| flag::register(signal, Arc::clone(&stop)))
            .map_err(|error| Failure::run(format!("signals cannot be caught: {error}")))?;
    }
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
