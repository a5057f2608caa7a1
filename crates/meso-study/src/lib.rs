//! Studies: every combination of some options, one folder each, and one table of all of them.
//!
//! [`Plan`] is the only source of combinations, hashes and folder names; the command and the Python package run its cases.
//! [`Record`] is what a case leaves behind, written last: a case without one was killed and is done again. [`Table`] and
//! [`ensemble`] put the records together.
#![forbid(unsafe_code)]

mod case;
mod ensemble;
mod folder;
mod plan;
mod record;
mod results;
mod student;
mod table;

pub use case::{Case, digest};
pub use ensemble::{REPLICATE, ensemble};
pub use folder::{TABLES, save_tables};
pub use plan::{Axis, MOST_CASES, Plan, PlanError};
pub use record::{Failed, MODEL, RECORD, Record, State, Status};
pub use results::{of_packing, of_summary};
pub use student::quantile_975;
pub use table::{Column, Table, Values, tabulate};
