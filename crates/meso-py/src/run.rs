//! Long work beside Python: the GIL is free, Ctrl-C is heard, and a panic is an exception.

use crate::boundary::{bug, wrong_value};
use meso_concrete::stop;
use meso_core::watch::{self, Measure, Stage};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

/// How often the calling thread checks for signals; well below the promised 0.2 s for Ctrl-C.
const POLL: Duration = Duration::from_millis(40);
/// How long a cancelled worker is waited for, ms; after that it ends by itself at its next look at the flag.
const GRACE: u64 = 80;
/// Wait for a worker that checks the flag often, ms: its threads have ended when the caller goes on.
const SOON_GRACE: u64 = 400;
/// Wait for a worker that writes files, ms. It removes them itself, and the caller may be about to end the process.
const FILES_GRACE: u64 = 3000;

thread_local! {
    /// Threads of the calls of this thread that name no number.
    static USUAL: Cell<Option<usize>> = const { Cell::new(None) };
}

/// Sets the threads of calls from this thread that name no number, `None` for all cores; returns what was set before.
#[pyfunction(name = "_usual_threads")]
pub(crate) fn usual_threads(threads: Option<usize>) -> Option<usize> {
    USUAL.replace(threads)
}

/// State that the worker and the waiting thread share.
pub(crate) struct Watch {
    go_on: Arc<AtomicBool>,
    /// Nobody waits for the result any more.
    abandoned: Arc<AtomicBool>,
    fraction: AtomicU64,
    target: AtomicU64,
    /// How long to wait for the end once it is asked for, ms.
    grace: AtomicU64,
    /// Whether the result so far is kept when the work is asked to stop.
    keeps: AtomicBool,
    /// When clock and time limit began to count.
    start: Instant,
    /// Plan of work in stages.
    staged: Option<Plan>,
}

/// The stages of work, and how far they are: of a copy, too, which goes on with other work.
#[derive(Clone)]
pub(crate) struct Plan {
    measure: Arc<Measure>,
    go_on: Arc<AtomicBool>,
    /// Clock and time limit count from here.
    began: Instant,
    /// Value of the whole in reports; `None` takes the fraction asked for, once that is known.
    whole: Option<f64>,
}

impl Plan {
    /// A plan of stages with their weights.
    pub(crate) fn new(stages: &[(Stage, f64)], whole: Option<f64>) -> Self {
        let (measure, go_on) = (Arc::new(Measure::new(stages)), Arc::new(AtomicBool::new(true)));
        Self { measure, go_on, began: Instant::now(), whole }
    }

    /// This plan, with a new value of the whole.
    pub(crate) fn of_whole(self, whole: f64) -> Self {
        Self { whole: Some(whole), ..self }
    }
}

impl Watch {
    /// The state of work that begins; a plan may have begun before.
    fn of(plan: Option<Plan>) -> Self {
        Self {
            go_on: plan.as_ref().map_or_else(|| Arc::new(AtomicBool::new(true)), |plan| Arc::clone(&plan.go_on)),
            start: plan.as_ref().map_or_else(Instant::now, |plan| plan.began),
            staged: plan,
            abandoned: Arc::new(AtomicBool::new(false)),
            fraction: AtomicU64::new(0),
            target: AtomicU64::new(0),
            grace: AtomicU64::new(GRACE),
            keeps: AtomicBool::new(false),
        }
    }

    /// Whether nobody asked to stop.
    pub(crate) fn goes_on(&self) -> bool {
        self.go_on.load(Relaxed)
    }

    /// Keeps how much is reached of the target, for whoever listens.
    pub(crate) fn reached(&self, done: f64, target: f64) {
        self.fraction.store(done.to_bits(), Relaxed);
        self.target.store(target.to_bits(), Relaxed);
    }

    /// From now on the worker looks whether to stop at every step.
    pub(crate) fn stops_soon(&self) {
        self.grace.store(SOON_GRACE, Relaxed);
    }

    /// From now on the work has something to keep: it is waited for, until the user asks once more.
    pub(crate) fn keeps_what_it_has(&self) {
        self.keeps.store(true, Relaxed);
    }

    /// From now on there are temporary files, and the worker often looks whether to stop.
    pub(crate) fn has_files(&self) {
        self.grace.store(FILES_GRACE, Relaxed);
    }
}

impl watch::Watch for Watch {
    fn target(&self, fraction: f64) {
        self.reached(0.0, fraction);
    }

    fn stops(&self) -> bool {
        !self.goes_on()
    }

    fn abandoned(&self) -> Option<Arc<AtomicBool>> {
        Some(Arc::clone(&self.abandoned))
    }

    fn stage(&self, stage: Stage, share: f64) {
        if let Some(plan) = &self.staged {
            plan.measure.tell(stage, share);
        }
    }

    fn seconds(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn began(&self) -> f64 {
        0.0
    }
}

/// Runs `work` on a thread of its own, with a rayon pool of its own, while this one waits for it and for signals.
///
/// The core checks the flag only between its own steps, which may be long. So on Ctrl-C the caller returns to Python
/// at once, and the worker, which shares nothing with Python, unwinds at its next check ([`stop`]). The pool lives only as long as
/// the work: a process forked in between inherits no dead threads.
pub(crate) fn beside_python<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> PyResult<T> {
    beside_python_on(py, None, progress, None, work)
}

/// Runs `work` in stages, half of which is worth nothing: a `progress` that returns False ends it with a `RuntimeError`.
/// See [`beside_python`].
pub(crate) fn in_stages<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    plan: Plan,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> PyResult<T> {
    let all = Terms { is_whole_or_nothing: true, threads: None };
    beside_python_keeping(py, all, progress, Some(plan), work).map_err(|broken| broken.error)
}

/// Runs `work` on a number of threads, or on all cores; see [`beside_python`].
pub(crate) fn beside_python_on<T: Send + 'static>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
    plan: Option<Plan>,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> PyResult<T> {
    beside_python_keeping(py, Terms::of(threads), progress, plan, work).map_err(|broken| broken.error)
}

/// How work runs.
#[derive(Clone, Copy)]
pub(crate) struct Terms {
    /// Threads; `None` takes the usual number.
    threads: Option<usize>,
    /// Whether work that is told to stop has nothing to give.
    is_whole_or_nothing: bool,
}

impl Terms {
    /// On a number of threads, with a result that may be kept.
    pub(crate) fn of(threads: Option<usize>) -> Self {
        Self { threads, is_whole_or_nothing: false }
    }
}

/// End of the wait for some work: the error, and the partial result.
pub(crate) struct Broken<T> {
    pub(crate) error: PyErr,
    pub(crate) kept: Option<T>,
}

impl<T, E: Into<PyErr>> From<E> for Broken<T> {
    fn from(error: E) -> Self {
        Self { error: error.into(), kept: None }
    }
}

/// Runs `work`, whose partial result on Ctrl-C comes with the error if it [keeps](Watch::keeps_what_it_has) it.
pub(crate) fn beside_python_keeping<T: Send + 'static>(
    py: Python<'_>,
    terms: Terms,
    progress: Option<&Bound<'_, PyAny>>,
    plan: Option<Plan>,
    work: impl FnOnce(&Watch) -> T + Send + 'static,
) -> Result<T, Broken<T>> {
    let watch = Arc::new(Watch::of(plan));
    let heard = Arc::clone(&watch);
    // For rayon 0 means all cores.
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(terms.threads.or(USUAL.get()).unwrap_or(0))
        .start_handler(move |_| stop::listen(&*heard))
        .build()
        .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let (sender, receiver) = mpsc::channel();
    let shared = Arc::clone(&watch);
    thread::Builder::new().name("mesocrete".into()).spawn(move || {
        let result = catch_unwind(AssertUnwindSafe(|| pool.install(|| work(&shared))));
        // Nobody waits any more after Ctrl-C.
        let _ = sender.send(result);
    })?;
    Waiting { py, receiver, watch: &watch, progress, terms }.for_the_end()
}

/// Result of the worker, or the payload of its panic.
type Worked<T> = thread::Result<T>;

/// The calling thread while it waits for the worker.
struct Waiting<'a, 'py, T> {
    py: Python<'py>,
    receiver: Receiver<Worked<T>>,
    watch: &'a Watch,
    progress: Option<&'a Bound<'py, PyAny>>,
    terms: Terms,
}

impl<T: Send> Waiting<'_, '_, T> {
    /// Waits for the end; a signal or an exception of the listener ends it early.
    fn for_the_end(mut self) -> Result<T, Broken<T>> {
        loop {
            match self.wait(POLL) {
                Ok(Ok(value)) => {
                    tell(self.progress, self.watch).and_then(|()| close(self.progress))?;
                    return Ok(value);
                }
                Ok(Err(payload)) => return Err(bug(&*payload).into()),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(PyRuntimeError::new_err("bug: the worker is gone").into());
                }
                Err(RecvTimeoutError::Timeout) => {
                    if let Err(error) = self.py.check_signals().and_then(|()| tell(self.progress, self.watch)) {
                        return Err(self.broken(error));
                    }
                    if self.terms.is_whole_or_nothing && !self.watch.goes_on() {
                        return Err(self.broken(PyRuntimeError::new_err("stopped: progress returned False")));
                    }
                }
            }
        }
    }

    fn wait(&mut self, limit: Duration) -> Result<Worked<T>, RecvTimeoutError> {
        let receiver = &mut self.receiver;
        self.py.detach(move || receiver.recv_timeout(limit))
    }

    /// Asks the worker to stop, and waits for the result that it keeps, or a moment for its end.
    fn broken(mut self, error: PyErr) -> Broken<T> {
        self.watch.go_on.store(false, Relaxed);
        let mut last = Err(RecvTimeoutError::Timeout);
        let runs_on = |last: &Result<_, _>| matches!(last, Err(RecvTimeoutError::Timeout));
        while self.watch.keeps.load(Relaxed) && runs_on(&last) && self.py.check_signals().is_ok() {
            last = self.wait(POLL);
        }
        self.watch.abandoned.store(true, Relaxed);
        if runs_on(&last) {
            last = self.wait(Duration::from_millis(self.watch.grace.load(Relaxed)));
        }
        Broken { error, kept: last.ok().and_then(Result::ok) }
    }
}

/// Tells the listener `done`, `total` and the stage; when it returns `False` the work stops with the best it has.
fn tell(progress: Option<&Bound<'_, PyAny>>, watch: &Watch) -> PyResult<()> {
    let Some(progress) = progress else { return Ok(()) };
    let [done, target] = [&watch.fraction, &watch.target].map(|bits| f64::from_bits(bits.load(Relaxed)));
    let (done, total, stage) = match &watch.staged {
        Some(Plan { measure, whole, .. }) => {
            let whole = whole.unwrap_or(target);
            (measure.share() * whole, whole, measure.stage())
        }
        None => (done, target, "solve"),
    };
    // The fraction asked for is not yet read.
    if watch.staged.is_some() && total == 0.0 {
        return Ok(());
    }
    let answer = progress.call1((done, total, stage))?;
    if !answer.is_none() && !answer.is_truthy()? {
        watch.go_on.store(false, Relaxed);
    }
    Ok(())
}

fn close(progress: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
    progress.map_or(Ok(()), |progress| progress.call_method0("close").map(drop))
}

/// Who hears how far the work is: nobody, a bar for True, or a callable.
///
/// # Errors
/// `TypeError` for anything else, before any work starts.
pub(crate) fn listener<'py>(
    py: Python<'py>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<Bound<'py, PyAny>>> {
    let Some(progress) = progress else { return Ok(None) };
    let listener = py.import("mesocrete._progress")?.call_method1("listener", (progress,))?;
    Ok((!listener.is_none()).then_some(listener))
}

/// A number of threads, checked before any work starts.
///
/// # Errors
/// `ValueError`.
pub(crate) fn checked_threads(threads: &Bound<'_, PyAny>) -> PyResult<usize> {
    let number: Option<usize> = threads.extract().ok().filter(|number| (1..=1024).contains(number));
    number.ok_or_else(|| wrong_value(format!("threads is {threads}; it must be an int from 1 to 1024")))
}
