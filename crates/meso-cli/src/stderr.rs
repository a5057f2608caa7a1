//! Messages on stderr. It may be closed: a message that nobody reads is no failure.

use meso_concrete::printable;
use std::cell::RefCell;
use std::fmt::Display;
use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};

thread_local! {
    static SUBJECT: RefCell<Option<Subject>> = const { RefCell::new(None) };
}

/// A part of the work, e.g. a case of a study, whose messages name it and are kept.
#[derive(Clone, Debug)]
pub(crate) struct Subject {
    name: Arc<str>,
    said: Arc<Mutex<Said>>,
}

/// Warnings and errors of a subject, without their first word.
#[derive(Clone, Debug, Default)]
pub(crate) struct Said {
    pub(crate) warnings: Vec<String>,
    pub(crate) errors: Vec<String>,
}

/// Writes a line to stderr, with the control characters of names, keys and paths escaped. Within [`of`] it names the subject.
pub(crate) fn line(message: impl Display) {
    let message = message.to_string();
    let text = SUBJECT.with_borrow(|subject| subject.as_ref().map(|subject| subject.keep(&message)));
    let _ = writeln!(std::io::stderr(), "{}", printable(&text.unwrap_or(message)));
}

/// Runs `work`; its warnings and errors name `name` and are returned.
pub(crate) fn of<T>(name: &str, work: impl FnOnce() -> T) -> (T, Said) {
    let subject = Subject { name: name.into(), said: Arc::default() };
    let before = SUBJECT.replace(Some(subject.clone()));
    let result = work();
    SUBJECT.set(before);
    let said = subject.said.lock().unwrap_or_else(PoisonError::into_inner).clone();
    (result, said)
}

/// The subject of this thread's messages, for the threads that work for it.
pub(crate) fn subject() -> Option<Subject> {
    SUBJECT.with_borrow(Clone::clone)
}

/// Makes `subject` that of this thread's messages.
pub(crate) fn speak_of(subject: Option<Subject>) {
    SUBJECT.set(subject);
}

impl Subject {
    /// Keeps a warning or an error; the line with the subject's name in it.
    fn keep(&self, message: &str) -> String {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        for (word, kept) in [("warning", 0), ("error", 1)] {
            if let Some(text) = message.strip_prefix(word).and_then(|rest| rest.strip_prefix(": ")) {
                if kept == 0 { &mut said.warnings } else { &mut said.errors }.push(text.to_owned());
                return format!("{word}: {}: {text}", self.name);
            }
        }
        format!("{}: {message}", self.name)
    }
}
