//! The tables in a study's folder.

use crate::ensemble::{REPLICATE, ensemble};
use crate::record::{Record, save};
use crate::table::{Table, tabulate};
use meso_files::whole::{Keeper, Unit};
use std::io;
use std::path::Path;

/// Names of the tables: all cases, then the ensembles.
pub const TABLES: [&str; 2] = ["table.csv", "ensemble.csv"];

/// Writes the tables of `records` into `out`, each whole or not at all; returns the table of all cases. `keeper` removes
/// temporary files after a signal.
///
/// # Errors
/// Errors of the file system.
pub fn save_tables<K: Keeper + Copy>(out: &Path, keys: &[String], records: &[Record], keeper: K) -> io::Result<Table> {
    let table = tabulate(keys, records);
    let groups = ensemble(&table, keys, REPLICATE);
    save(out, TABLES[0], Unit::new(keeper), |file| table.write_csv(file))?;
    save(out, TABLES[1], Unit::new(keeper), |file| groups.write_csv(file))?;
    Ok(table)
}
