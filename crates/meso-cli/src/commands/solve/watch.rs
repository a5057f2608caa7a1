//! The observer of a test: the line with strain, stress and the time left, frames and checkpoints.

use super::folder::Folder;
use crate::failure::Failure;
use crate::progress::{CLEAR, bar, fitting, show};
use crate::{stderr, threads};
use meso_core::mesh::Mesh;
use meso_solve::results::{Shooting, Snapshot};
use meso_solve::{Frame, Observer, Row, Run};
use std::cell::{Cell, RefCell};
use std::io::{self, IsTerminal};
use std::thread::{Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

/// Lines of a test where nobody sees a bar.
const LINES: u64 = 10;
/// How often the bar is drawn.
const REDRAW: Duration = Duration::from_millis(100);

/// The progress of a test, as the user sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shown {
    Nothing,
    Lines,
    Bar,
}

/// The folder of the results, here or with the thread that writes a frame.
enum Shelf<'scope> {
    Here(Box<Folder>),
    Lent(ScopedJoinHandle<'scope, (Box<Folder>, Result<(), Failure>)>),
}

/// Watches one test.
pub(super) struct Watching<'scope, 'a> {
    mesh: &'a Mesh,
    /// Where frames are written while the test goes on, one at a time: no more than one is held in memory.
    scope: &'scope Scope<'scope, 'a>,
    /// None only while it changes hands.
    shelf: RefCell<Option<Shelf<'scope>>>,
    shooting: Shooting,
    shown: Shown,
    started: Instant,
    /// Share of the test that a run before this one did.
    first: Cell<Option<f64>>,
    /// Tenths of the test that have a line, and when the bar was drawn.
    told: Cell<u64>,
    drawn: Cell<Option<Instant>>,
    every: Option<Duration>,
    kept: Cell<Instant>,
    /// Whether the last checkpoint could not be written.
    unkept: Cell<bool>,
}

impl<'scope, 'a> Watching<'scope, 'a> {
    /// Starts the clock; `every` so many seconds the state is kept.
    pub(super) fn new(
        mesh: &'a Mesh,
        folder: Folder,
        scope: &'scope Scope<'scope, 'a>,
        every: Option<f64>,
        quiet: bool,
    ) -> Self {
        let seen = io::stderr().is_terminal();
        let now = Instant::now();
        Self {
            mesh,
            shooting: Shooting::after(folder.taken()),
            scope,
            shelf: RefCell::new(Some(Shelf::Here(Box::new(folder)))),
            shown: if quiet {
                Shown::Nothing
            } else if seen {
                Shown::Bar
            } else {
                Shown::Lines
            },
            started: now,
            first: Cell::new(None),
            told: Cell::new(0),
            drawn: Cell::new(None),
            every: every.map(Duration::from_secs_f64),
            kept: Cell::new(now),
            unkept: Cell::new(false),
        }
    }

    /// The folder with the frames.
    pub(super) fn folder(self) -> Folder {
        let mut folder = self.fetch();
        self.clear();
        folder.keep_shots(self.shooting.taken());
        *folder
    }

    /// The folder, once the last frame is written.
    fn fetch(&self) -> Box<Folder> {
        match self.shelf.take().expect("whoever takes the folder gives it back") {
            Shelf::Here(folder) => folder,
            Shelf::Lent(writer) => {
                let (folder, written) = writer.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
                if let Err(failure) = written {
                    self.warn(&failure, "the test goes on without this frame");
                }
                folder
            }
        }
    }

    /// Takes the bar away.
    fn clear(&self) {
        if self.shown == Shown::Bar {
            show(CLEAR);
        }
    }

    /// Says that something could not be written: no reason to lose a test of hours.
    fn warn(&self, failure: &Failure, what_then: &str) {
        self.clear();
        stderr::line(format!("warning: {}; {what_then}", failure.message()));
    }

    fn show(&self, row: &Row, done: f64) {
        let left = self.left(done);
        match self.shown {
            Shown::Nothing => {}
            Shown::Lines => {
                let tenth = (LINES as f64 * done) as u64;
                if self.told.replace(tenth) < tenth {
                    stderr::line(format!("{:>3} %: {}", 100 * tenth / LINES, figures(row, left)));
                }
            }
            Shown::Bar => {
                if self.drawn.get().is_none_or(|drawn| drawn.elapsed() >= REDRAW) {
                    self.drawn.set(Some(Instant::now()));
                    show(&format!("{CLEAR}{}", fitting(&line(row, done, left))));
                }
            }
        }
    }

    /// Seconds to the end, at the pace since the first row; none at the first row.
    fn left(&self, done: f64) -> Option<f64> {
        let Some(first) = self.first.get() else {
            self.first.set(Some(done));
            return None;
        };
        (done > first).then(|| self.started.elapsed().as_secs_f64() * (1.0 - done) / (done - first))
    }
}

impl Observer for Watching<'_, '_> {
    fn row(&self, row: &Row, done: f64) {
        self.show(row, done);
    }

    fn keeps(&self) -> bool {
        self.every.is_some_and(|every| self.kept.get().elapsed() >= every)
    }

    fn wants(&self, row: &Row) -> bool {
        self.shooting.wants(row)
    }

    fn moment(&self, frame: &Frame) {
        self.shooting.take(frame);
    }

    fn frame(&self, frame: &Frame) {
        let (mut folder, mesh) = (self.fetch(), self.mesh);
        let snapshot = Snapshot::of(frame);
        let writer = self.scope.spawn(move || {
            let written = threads::alone(|| folder.add(mesh, &snapshot));
            (folder, written)
        });
        self.shelf.replace(Some(Shelf::Lent(writer)));
    }

    fn keep(&self, run: &Run) {
        let mut folder = self.fetch();
        folder.keep_shots(self.shooting.taken());
        let failure = folder.keep(run).err();
        self.shelf.replace(Some(Shelf::Here(folder)));
        // Said once, not every few minutes.
        let was_unkept = self.unkept.replace(failure.is_some());
        if let Some(failure) = failure.filter(|_| !was_unkept) {
            self.warn(&failure, "the test goes on; an earlier checkpoint is kept");
        }
        self.kept.set(Instant::now());
    }
}

fn line(row: &Row, done: f64, left: Option<f64>) -> String {
    format!("solving {} {}", bar(done), figures(row, left))
}

fn figures(row: &Row, left: Option<f64>) -> String {
    let (strain, stress) = (row.strain, row.stress_mpa);
    let left = left.map_or_else(String::new, |left| format!(", {} left", time(left)));
    format!("strain {strain:.5}, {stress:.2} MPa{left}")
}

/// Seconds as one reads them: 42 s, 3:05 min, 1:20 h.
fn time(seconds: f64) -> String {
    let whole = seconds.round().max(0.0) as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{}:{:02} min", whole / 60, whole % 60),
        _ => format!("{}:{:02} h", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_fits_a_terminal() {
        let row = Row { strain: 0.00213, stress_mpa: 31.42, ..Row::default() };
        let text = line(&row, 0.5, Some(185.2));
        assert_eq!(text, "solving [========        ] strain 0.00213, 31.42 MPa, 3:05 min left");
        assert!(text.len() < 80);
    }

    #[test]
    fn the_first_row_of_a_resumed_test_has_no_time_left() {
        // A test that was resumed at a fifth said that 3827 hours were left.
        let row = Row { strain: 0.00007, stress_mpa: 1.75, ..Row::default() };
        assert_eq!(figures(&row, None), "strain 0.00007, 1.75 MPa");
    }

    #[test]
    fn times_are_told_as_one_reads_them() {
        assert_eq!([0.2, 59.4, 60.0, 3599.4, 4805.0].map(time), ["0 s", "59 s", "1:00 min", "59:59 min", "1:20 h"]);
    }
}
