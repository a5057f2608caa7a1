//! Tables that are measured row by row, each by a run of its own.

use super::table::Table;

/// Prints a row of numbers and puts it into the CSV file `name`, in place of the one with the same first `keys` numbers.
/// Rows of other columns are of an older bench, and go.
pub(crate) fn enter(name: &str, header: &str, keys: usize, row: String) {
    println!("{header}\n{row}");
    let key = |row: &str| row.split(',').take(keys).map(number).collect::<Vec<_>>();
    let text = std::fs::read_to_string(super::table::folder().join(name)).unwrap_or_default();
    let old =
        if text.lines().next() == Some(header) { text.lines().skip(1).map(String::from).collect() } else { vec![] };
    let own = key(&row);
    let mut rows: Vec<String> = old.into_iter().filter(|old: &String| key(old) != own).chain([row]).collect();
    rows.sort_by(|a, b| key(a).partial_cmp(&key(b)).expect("numbers"));
    let mut table = Table::new(header);
    rows.iter().for_each(|row| table.row(&row.split(',').map(String::from).collect::<Vec<_>>()));
    table.save(name);
}

pub(crate) fn number(word: &str) -> f64 {
    word.parse().unwrap_or_else(|_| panic!("`{word}` is not a number"))
}
