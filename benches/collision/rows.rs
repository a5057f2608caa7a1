//! Tables that are measured row by row, each by a run of its own.

use super::table::Table;

/// Prints a row of numbers and puts it into the CSV file `name`, in place of the one with the same first `keys` numbers.
/// Rows of other columns are of an older bench, and go.
pub(crate) fn enter(name: &str, header: &str, keys: usize, row: String) {
    println!("{header}\n{row}");
    let key = |row: &str| row.split(',').take(keys).map(number).collect::<Vec<_>>();
    let text = std::fs::read_to_string(super::table::folder().join(name)).unwrap_or_default();
    let mut table = Table::new(header);
    let is_same = text.lines().next() == Some(&Table::header(header));
    let old: Vec<&str> = if is_same { text.lines().skip(1).collect() } else { Vec::new() };
    let row = table.stamped(&row);
    let own = key(&row);
    let mut rows: Vec<&str> = old.into_iter().filter(|old| key(old) != own).chain([row.as_str()]).collect();
    rows.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("numbers"));
    rows.iter().for_each(|row| table.keep(row));
    table.save(name);
}

pub(crate) fn number(word: &str) -> f64 {
    word.parse().unwrap_or_else(|_| panic!("`{word}` is not a number"))
}
