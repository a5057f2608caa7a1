//! Progress, the clock and the wish to stop, as the core sees them: a bar on a terminal, now and then a line elsewhere.

use crate::interrupt;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use meso_core::watch::{self, Measure, Stage};
use std::io::{self, IsTerminal, Write};
use std::sync::{Mutex, Once};
use std::time::{Duration, Instant};

/// Back to the start of the line, which is emptied.
pub(crate) const CLEAR: &str = "\r\x1b[2K";
/// Characters of a full bar beside other figures.
const BAR: usize = 16;
/// Steps of a full bar on a terminal.
const STEPS: u64 = 1000;
/// From this width on there is space for the clock and for the effect of Ctrl-C.
const WIDE: u16 = 72;
/// Jams in the first seconds are not printed: most end by themselves.
const JAM_S: f64 = 5.0;
/// A run without a terminal reports no more often.
const LINE: Duration = Duration::from_secs(10);

/// The stages of a packing that is meshed and written, with their weights in the default run.
pub(crate) const PACK: [(Stage, f64); 7] = [
    // Only the specimen of a surface has this stage.
    (Stage::Read, 8.0),
    (Stage::Take, 2.0),
    (Stage::Place, 4.0),
    (Stage::Prove, 1.0),
    (Stage::Mesh, 3.0),
    (Stage::Write, 2.0),
    // A page's: it is written last.
    (Stage::Measure, 2.0),
];

/// The stages of work on a saved model, with the weight of `stage` beside that of reading a large surface.
pub(crate) fn of_model(stage: Stage, weight: f64) -> [(Stage, f64); 2] {
    [(Stage::Read, 1.0), (stage, weight)]
}

/// Watches one run, and counts its time limit from its own beginning on.
pub(crate) struct Watch {
    started: Instant,
    measure: Measure,
    shown: Shown,
    /// Whether a jam was printed.
    jammed: Once,
    polling: Option<interrupt::Polling>,
}

/// Form in which the user sees it.
enum Shown {
    Nothing,
    /// Drawn from the first stage on.
    Bar(ProgressBar, Once),
    /// When the last line was written.
    Lines(Mutex<Instant>),
}

impl Watch {
    /// Starts the clock of a packing, of which Ctrl-C keeps the best. A bar is drawn where stderr is a terminal and
    /// `quiet` is false.
    pub(crate) fn start(quiet: bool, plan: &[(Stage, f64)]) -> Self {
        let mut watch = Self::of_files(quiet, plan);
        watch.keeps_the_best();
        watch
    }

    /// From now on Ctrl-C keeps the best packing.
    pub(crate) fn keeps_the_best(&mut self) {
        self.polling = Some(interrupt::Polling::begin());
        self.leaves("Ctrl-C keeps what is placed");
    }

    /// Starts the clock of work that Ctrl-C ends without a file.
    pub(crate) fn of_files(quiet: bool, plan: &[(Stage, f64)]) -> Self {
        let shown = match (quiet, io::stderr().is_terminal()) {
            (true, _) => Shown::Nothing,
            (_, true) => Shown::Bar(bar_on_terminal(), Once::new()),
            (_, false) => Shown::Lines(Mutex::new(Instant::now())),
        };
        let watch =
            Self { started: Instant::now(), measure: Measure::new(plan), shown, jammed: Once::new(), polling: None };
        watch.leaves("Ctrl-C leaves no file");
        watch
    }

    /// Seconds since the start.
    pub(crate) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Nobody asks any more whether to stop, so that from now on Ctrl-C ends everything.
    pub(crate) fn placed(&mut self) {
        drop(self.polling.take());
        self.leaves("Ctrl-C leaves no file");
    }

    /// All files but the page are there.
    pub(crate) fn has_but_the_page(&self) {
        self.leaves("Ctrl-C leaves out the page");
    }

    /// Takes the bar away.
    pub(crate) fn finish(&mut self) {
        drop(self.polling.take());
        if let Shown::Bar(bar, _) = &self.shown {
            bar.finish_and_clear();
        }
    }

    /// Writes lines where the bar stands, which comes back below them.
    pub(crate) fn aside<T>(&self, write: impl FnOnce() -> T) -> T {
        if let Shown::Bar(bar, _) = &self.shown { bar.suspend(write) } else { write() }
    }

    fn leaves(&self, what: &'static str) {
        if let Shown::Bar(bar, _) = &self.shown {
            bar.set_message(what);
        }
    }
}

/// An error takes the bar away, too.
impl Drop for Watch {
    fn drop(&mut self) {
        self.finish();
    }
}

impl watch::Watch for Watch {
    /// Once the best packing is kept, Ctrl-C ends everything at once.
    fn stops(&self) -> bool {
        self.polling.as_ref().is_some_and(watch::Watch::stops)
    }

    fn stage(&self, stage: Stage, share: f64) {
        self.measure.tell(stage, share);
        if stage == Stage::Jam && self.elapsed() >= JAM_S {
            self.jammed.call_once(|| self.say_jammed());
        }
        match &self.shown {
            Shown::Nothing => {}
            Shown::Bar(bar, drawn) => {
                drawn.call_once(|| draw(bar));
                bar.set_prefix(self.measure.stage());
                bar.set_position((self.measure.share() * STEPS as f64) as u64);
            }
            Shown::Lines(last) => self.line(last),
        }
    }

    fn seconds(&self) -> f64 {
        self.elapsed()
    }

    fn began(&self) -> f64 {
        0.0
    }
}

impl Watch {
    fn say_jammed(&self) {
        if !matches!(self.shown, Shown::Nothing) {
            let seconds = self.elapsed();
            let [gap, fraction, limit] = ["min_gap_mm", "fraction", "time_limit_s"].map(crate::stderr::flag);
            self.aside(|| {
                crate::stderr::line(format!(
                    "jammed after {seconds:.0} s: the overlaps do not shrink any more; a smaller {gap} or {fraction} packs \
                     sooner, and {limit} S ends with the best found"
                ));
            });
        }
    }

    /// Writes a line where the last one is old.
    fn line(&self, last: &Mutex<Instant>) {
        if let Ok(mut last) = last.try_lock()
            && last.elapsed() >= LINE
        {
            *last = Instant::now();
            let (stage, percent) = (self.measure.stage(), 100.0 * self.measure.share());
            crate::stderr::line(format!("{stage}: {percent:.0} % of all after {:.0} s", self.elapsed()));
        }
    }
}

/// A bar as wide as the terminal, on one line of it; not yet drawn.
fn bar_on_terminal() -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(STEPS), ProgressDrawTarget::hidden());
    let is_wide = console::Term::stderr().size().1 >= WIDE;
    let template = if is_wide {
        "{prefix:<8}{wide_bar} {percent:>3} % {elapsed:>4}  {msg}"
    } else {
        "{prefix:<8}{wide_bar} {percent:>3} %"
    };
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.progress_chars("=> "));
    bar
}

fn draw(bar: &ProgressBar) {
    bar.set_draw_target(ProgressDrawTarget::stderr_with_hz(10));
    bar.enable_steady_tick(Duration::from_millis(200));
}

/// A bar of which this share, 0 to 1, is full.
pub(crate) fn bar(share: f64) -> String {
    let full = "=".repeat((share.clamp(0.0, 1.0) * BAR as f64) as usize);
    format!("[{full:BAR$}]")
}

/// The part of a line that fits the terminal.
pub(crate) fn fitting(line: &str) -> String {
    let columns = usize::from(console::Term::stderr().size().1).max(2);
    line.chars().take(columns - 1).collect()
}

/// A closed terminal does not stop the run.
pub(crate) fn show(text: &str) {
    let mut stderr = io::stderr().lock();
    let _ = stderr.write_all(text.as_bytes()).and_then(|()| stderr.flush());
}
