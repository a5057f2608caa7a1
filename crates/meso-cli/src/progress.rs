//! The progress line, the clock and the wish to stop, as the core sees them.

use crate::interrupt;
use meso_core::Progress;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Characters of a full bar: the line stays within 80.
const BAR: usize = 16;
/// Back to the start of the line, which is emptied.
pub(crate) const CLEAR: &str = "\r\x1b[2K";

/// Watches one run.
pub(crate) struct Watch {
    started: Instant,
    /// The tenth of a second in which the line was last drawn, where someone sees it.
    drawn: Option<AtomicU64>,
    polling: Option<interrupt::Polling>,
}

impl Watch {
    /// Starts the clock; a line is drawn where stderr is a terminal and `quiet` is false.
    pub(crate) fn start(quiet: bool) -> Self {
        let seen = !quiet && io::stderr().is_terminal();
        let drawn = seen.then(AtomicU64::default);
        Self { started: Instant::now(), drawn, polling: Some(interrupt::Polling::begin()) }
    }

    /// Seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Takes the line away. Nobody asks any more whether to stop, so that from now on Ctrl-C ends everything.
    pub(crate) fn finish(&mut self) {
        drop(self.polling.take());
        if self.drawn.is_some() {
            show(CLEAR);
        }
    }
}

impl Progress for Watch {
    fn update(&self, fraction: f64, target: f64) -> bool {
        let tenth = 1 + (10.0 * self.elapsed()) as u64;
        if self.drawn.as_ref().is_some_and(|drawn| drawn.swap(tenth, Ordering::Relaxed) != tenth) {
            show(&format!("{CLEAR}{}", line(fraction, target, self.elapsed())));
        }
        !interrupt::asked()
    }

    fn seconds(&self) -> f64 {
        self.elapsed()
    }
}

fn line(fraction: f64, target: f64, seconds: f64) -> String {
    let bar = bar(fraction / target);
    format!("packing {bar} {fraction:.4} of {target} ({seconds:.0} s, Ctrl-C keeps the best)")
}

/// A bar of which this share, 0 to 1, is full.
pub(crate) fn bar(share: f64) -> String {
    let full = "=".repeat((share.clamp(0.0, 1.0) * BAR as f64) as usize);
    format!("[{full:BAR$}]")
}

/// A closed terminal does not stop the run.
pub(crate) fn show(text: &str) {
    let mut stderr = io::stderr().lock();
    let _ = stderr.write_all(text.as_bytes()).and_then(|()| stderr.flush());
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn the_line_fits_a_terminal_of_80() {
        let text = line(0.43218, 0.5, 12.3);
        assert_eq!(text, "packing [=============   ] 0.4322 of 0.5 (12 s, Ctrl-C keeps the best)");
        assert!(line(0.7, 0.6789, 1e4).len() < 80);
    }
}
