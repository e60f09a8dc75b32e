//! The line that tells how far a run is.

use std::io::Write;
use std::time::{Duration, Instant};

use crate::run::Progress;

/// Width of the bar in characters.
const BAR: usize = 20;

/// Writes progress to a terminal (one line, rewritten) or elsewhere (a line now and then). What it shows never reaches a file.
#[derive(Debug)]
pub struct ProgressLine<W> {
    out: W,
    terminal: bool,
    begun: Instant,
    shown: Instant,
    shown_any: bool,
}

impl<W: Write> ProgressLine<W> {
    /// To `out`, which is a terminal or not.
    pub fn new(out: W, terminal: bool) -> Self {
        let now = Instant::now();
        Self {
            out,
            terminal,
            begun: now,
            shown: now,
            shown_any: false,
        }
    }

    /// Shows where the run is, unless it was shown a moment ago (0.2 s on a terminal, 10 s elsewhere).
    pub fn show(&mut self, progress: &Progress<'_>) {
        let pause = if self.terminal {
            Duration::from_millis(200)
        } else {
            Duration::from_secs(10)
        };
        if self.shown.elapsed() < pause {
            return;
        }
        self.shown = Instant::now();
        self.shown_any = true;
        let line = line(progress, self.begun.elapsed().as_secs_f64(), self.terminal);
        // Whoever closed the terminal does not want to see progress; the run goes on.
        let _ = if self.terminal {
            write!(self.out, "\r\x1b[2K{line}").and_then(|()| self.out.flush())
        } else {
            writeln!(self.out, "{line}")
        };
    }

    /// Removes the line from a terminal.
    pub fn clear(&mut self) {
        if self.terminal && self.shown_any {
            let _ = write!(self.out, "\r\x1b[2K").and_then(|()| self.out.flush());
        }
    }
}

/// The line after `seconds` of run time.
fn line(progress: &Progress<'_>, seconds: f64, with_bar: bool) -> String {
    let share = progress.share();
    let mut line = String::new();
    if with_bar {
        let full = (share * BAR as f64) as usize;
        line = format!("[{}{}] ", "=".repeat(full), " ".repeat(BAR - full));
    }
    let rate = progress.particle_steps as f64 / seconds.max(1e-9);
    let left = seconds * (1.0 - share) / share.max(1e-9);
    line += &format!(
        "{:5.1} %  t = {:.4e} s  {} particles  {rate:.2e} particle-steps/s  Ekin {:.2e} J  {} left",
        100.0 * share,
        progress.engine.time(),
        progress.engine.particles.len(),
        progress.kinetic_energy(),
        duration(left),
    );
    line
}

/// A duration as people say it: 7.25 s, 3 min 20 s, 2 h 5 min.
#[must_use]
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds >= 8.64e6 {
        return "> 100 d".to_owned();
    }
    if seconds < 9.995 {
        return format!("{seconds:.2} s");
    }
    let whole = seconds.round() as u64;
    match (whole / 3600, whole / 60 % 60, whole % 60) {
        (0, 0, s) => format!("{s} s"),
        (0, min, s) => format!("{min} min {s} s"),
        (h, min, _) => format!("{h} h {min} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations() {
        for (seconds, text) in [
            (0.4, "0.40 s"),
            (9.999, "10 s"),
            (59.6, "1 min 0 s"),
            (3599.4, "59 min 59 s"),
            (7500.0, "2 h 5 min"),
            (f64::INFINITY, "> 100 d"),
        ] {
            assert_eq!(duration(seconds), text);
        }
    }
}
