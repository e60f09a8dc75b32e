//! The line that shows the progress of a program.

use std::io::{IsTerminal as _, Stderr, Write};
use std::time::{Duration, Instant};

use crate::readable::duration;

/// Width of the bar in characters.
const BAR: usize = 20;

/// Shows progress on a terminal (one line, rewritten) or elsewhere (a line now and then). The text never reaches a file of
/// the program.
#[derive(Debug)]
pub struct Progress<W: Write = Stderr> {
    /// Nowhere if the program is to be quiet.
    out: Option<W>,
    terminal: bool,
    begun: Instant,
    shown: Instant,
    shown_any: bool,
}

impl Progress {
    /// On standard error, if that is a terminal and the program is not to be quiet.
    #[must_use]
    pub fn new(quiet: bool) -> Self {
        let out = std::io::stderr();
        let terminal = out.is_terminal();
        Self::begin((terminal && !quiet).then_some(out), terminal)
    }

    /// On standard error, even if it is not a terminal: for work of hours, so that a log shows whether it continues.
    #[must_use]
    pub fn in_logs_too(quiet: bool) -> Self {
        let out = std::io::stderr();
        let terminal = out.is_terminal();
        Self::begin((!quiet).then_some(out), terminal)
    }
}

impl<W: Write> Progress<W> {
    /// To `out`, which is a terminal or not.
    pub fn to(out: W, terminal: bool) -> Self {
        Self::begin(Some(out), terminal)
    }

    fn begin(out: Option<W>, terminal: bool) -> Self {
        let now = Instant::now();
        Self {
            out,
            terminal,
            begun: now,
            shown: now,
            shown_any: false,
        }
    }

    /// Shows that a stage of unknown length begins: at once on a terminal, where long work without a sign of life looks like a
    /// hang; nowhere else.
    pub fn stage(&mut self, what: &str) {
        if self.terminal {
            self.print(what);
        }
    }

    /// Shows the completed share (0 to 1) of the work with a text from `text`, given the seconds since the beginning. Does
    /// nothing if something was shown shortly before (0.2 s on a terminal, 10 s elsewhere).
    pub fn share(&mut self, share: f64, text: impl FnOnce(f64) -> String) {
        if self.is_due() {
            let seconds = self.begun.elapsed().as_secs_f64();
            self.print(&line(share, seconds, &text(seconds), self.terminal));
        }
    }

    /// Like [`share`](Self::share), for work with a better estimate of the remaining time (s) than the completed share gives.
    pub fn share_left(&mut self, share: f64, left: f64, text: impl FnOnce() -> String) {
        if self.is_due() {
            self.print(&line_left(share, left, &text(), self.terminal));
        }
    }

    /// Shows that `done` of `total` are complete; if the total is not known, only `done`.
    pub fn count(&mut self, what: &str, done: usize, total: Option<usize>) {
        match total {
            Some(total) => self.share(done as f64 / total.max(1) as f64, |_| {
                format!("{what} {done} of {total}")
            }),
            None if self.is_due() => self.print(&format!("{what} {done}")),
            None => {}
        }
    }

    /// Shows what is being done, given the seconds since the beginning. Does nothing if something was shown shortly before.
    pub fn busy(&mut self, text: impl FnOnce(f64) -> String) {
        if self.is_due() {
            let text = text(self.begun.elapsed().as_secs_f64());
            self.print(&text);
        }
    }

    /// Removes the line from a terminal.
    pub fn clear(&mut self) {
        if let Some(out) = self
            .out
            .as_mut()
            .filter(|_| self.terminal && self.shown_any)
        {
            let _ = write!(out, "\r\x1b[2K").and_then(|()| out.flush());
            self.shown_any = false;
        }
    }

    fn is_due(&self) -> bool {
        let pause = if self.terminal {
            Duration::from_millis(200)
        } else {
            Duration::from_secs(10)
        };
        self.out.is_some() && self.shown.elapsed() >= pause
    }

    fn print(&mut self, line: &str) {
        let Some(out) = &mut self.out else {
            return;
        };
        self.shown = Instant::now();
        self.shown_any = true;
        // A closed terminal does not end the work; only the progress line is lost.
        let _ = if self.terminal {
            write!(out, "\r\x1b[2K{line}").and_then(|()| out.flush())
        } else {
            writeln!(out, "{line}")
        };
    }
}

/// A program that fails gives the reason in a line of its own.
impl<W: Write> Drop for Progress<W> {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Progress line of work that goes on as it has since its beginning, of which nothing was done.
fn line(share: f64, seconds: f64, text: &str, with_bar: bool) -> String {
    let done = share.clamp(0.0, 1.0);
    line_left(
        share,
        seconds * (1.0 - done) / done.max(1e-9),
        text,
        with_bar,
    )
}

fn line_left(share: f64, left: f64, text: &str, with_bar: bool) -> String {
    let share = share.clamp(0.0, 1.0);
    let mut line = String::new();
    if with_bar {
        let full = (share * BAR as f64) as usize;
        line = format!("[{}{}] ", "=".repeat(full), " ".repeat(BAR - full));
    }
    line += &format!("{:5.1} %  {text}  {} left", 100.0 * share, duration(left));
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Text that a progress line wrote.
    fn shown(terminal: bool, act: impl FnOnce(&mut Progress<&mut Vec<u8>>)) -> String {
        let mut out = Vec::new();
        let mut progress = Progress::to(&mut out, terminal);
        // As if the last sign had been given long ago.
        progress.shown -= Duration::from_secs(60);
        act(&mut progress);
        drop(progress);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn a_line_states_share_and_time_left() {
        // A quarter in 20 s: three quarters take 60 s.
        assert_eq!(
            line(0.25, 20.0, "t = 1 s", true),
            "[=====               ]  25.0 %  t = 1 s  1 min 0 s left"
        );
        assert_eq!(
            line(0.0, 3.0, "frame 0", false),
            "  0.0 %  frame 0  > 100 d left"
        );
        // A share that is no number, or beyond its range, is no reason to panic.
        line(f64::NAN, 1.0, "", true);
        assert!(line(1.5, 1.0, "", true).starts_with("[====================] 100.0 %"));
    }

    #[test]
    fn a_terminal_is_rewritten_and_left_clean() {
        let text = shown(true, |progress| {
            progress.stage("reading");
            progress.count("frame", 1, Some(2)); // too soon
        });
        assert_eq!(text, "\r\x1b[2Kreading\r\x1b[2K");
    }

    #[test]
    fn elsewhere_lines_come_now_and_then_and_stay() {
        let text = shown(false, |progress| {
            progress.stage("reading"); // for eyes that wait
            progress.count("pebbles", 7, None);
            progress.count("pebbles", 8, None); // too soon
            progress.busy(|_| unreachable!("too soon"));
        });
        assert_eq!(text, "pebbles 7\n");
        let text = shown(false, |progress| progress.busy(|_| "planning".to_owned()));
        assert_eq!(text, "planning\n");
    }

    #[test]
    fn a_quiet_program_says_nothing() {
        let mut progress = Progress::new(true);
        progress.shown -= Duration::from_secs(60);
        progress.stage("reading");
        progress.share(0.5, |_| unreachable!("this text is never shown"));
        assert!(!progress.shown_any);
    }
}
