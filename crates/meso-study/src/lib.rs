//! Studies: every combination of some options, one folder each, and one table of all of them.
//!
//! [`Plan`] is the only source of combinations, hashes and folder names. [`StudyRun`] does its cases, each in a locked folder, for
//! the command and the Python package alike. A case leaves its [`Record`], written last: a case without one was killed and is
//! done again. [`Table`] and [`ensemble`] put the records together. [`Names`] keeps the files of a case apart.
#![forbid(unsafe_code)]

mod case;
mod design;
mod ensemble;
mod file;
pub mod fit;
mod journal;
mod named_files;
mod names;
mod plan;
mod record;
mod repetitions;
mod results;
mod run;
pub mod steps;
mod student;
mod table;

pub use case::{Case, digest};
pub use design::{Design, Sampling};
pub use ensemble::{REPLICATE, ensemble};
pub use file::StudyFile;
use file::place;
pub use journal::{RECORDS, Seen, StudyLayout};
pub use named_files::{NamedFiles, read_text};
pub use names::{NameError, Names};
pub use plan::{Axis, MOST_CASES, Plan, PlanError, Planning};
pub use record::{CURVE, CaseOutcome, CaseState, Failed, Keep, MODELS, RECORD, Record, Status};
pub use results::{of_effective, of_packing, of_summary};
pub use run::{Again, Begun, CaseTurn, Heard, RunError, Share, StudyRun, TABLES, Tally, records, save_tables};
pub use steps::{Attached, Devices, Doing, Steps};
pub use student::quantile_975;
pub use table::{Column, Table, Values, tabulate};
