//! The progress bar, the clock and the wish to stop, as the core sees them.

use crate::interrupt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use meso_core::Progress;
use std::time::{Duration, Instant};

/// Ticks of a full bar.
const TICKS: u64 = 1000;

/// Watches one run.
pub(crate) struct Watch {
    started: Instant,
    bar: ProgressBar,
    _polling: interrupt::Polling,
}

impl Watch {
    /// Starts the clock, and draws a bar where stderr is a terminal and `quiet` is false.
    pub(crate) fn start(quiet: bool) -> Self {
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(TICKS), target);
        if let Ok(style) = ProgressStyle::with_template("packing {bar:36} {msg} ({elapsed}, Ctrl-C keeps the best)") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.enable_steady_tick(Duration::from_millis(100));
        Self { started: Instant::now(), bar, _polling: interrupt::Polling::begin() }
    }

    /// Seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Watch {
    fn update(&self, fraction: f64, target: f64) -> bool {
        if !self.bar.is_hidden() {
            self.bar.set_position((fraction / target * TICKS as f64) as u64);
            self.bar.set_message(format!("{fraction:.4} of {target}"));
        }
        !interrupt::asked()
    }

    fn seconds(&self) -> f64 {
        self.elapsed()
    }
}
