//! Turns of a path from a table in CSV.

use crate::error::TEST;
use crate::test::{Test, Turn, TurnOf};
use meso_concrete::OutOfRange;
use meso_concrete::import::Columns;

/// Columns that give the turns, and their quantities.
const COLUMNS: [(&str, TurnOf); 3] =
    [("strain", TurnOf::Strain), ("stress_mpa", TurnOf::Stress), ("opening_mm", TurnOf::Opening)];

impl Test {
    /// Takes in the table that [`history`](Self::history) names; `read` gives a file's text, or why it cannot be read.
    ///
    /// # Errors
    /// A file that cannot be read, one without a known column, a row without a number, and turns beside the table.
    pub fn take_history(&mut self, read: impl FnOnce(&str) -> Result<String, String>) -> Result<(), OutOfRange> {
        let Some(name) = self.history.take() else { return Ok(()) };
        if !self.turns.is_empty() {
            return Err(TEST.error("history", name, "the test has turns, too; leave one of them out"));
        }
        let turns = read(&name).and_then(|text| turns(&text));
        self.turns = turns.map_err(|why| TEST.error("history", name, why))?;
        Ok(())
    }
}

/// Turns of a table: a header, then a row for each turn.
fn turns(text: &str) -> Result<Vec<Turn>, String> {
    let table = Columns::parse(text)?;
    let mut found: Vec<(usize, &str, TurnOf)> = Vec::new();
    for (name, of) in COLUMNS {
        found.extend(table.place(name)?.map(|place| (place, name, of)));
    }
    if let [(_, one, _), (_, other, _), ..] = found[..] {
        return Err(format!("it has the columns {one} and {other}; a turn is at one of them, so leave the other out"));
    }
    let &(place, _, of) = found.first().ok_or("it has no column strain, stress_mpa or opening_mm in its first line")?;
    let turn = |(line, cells): &(usize, Vec<Option<f64>>)| {
        let at = cells[place].filter(|at| at.is_finite());
        at.map(|at| Turn { at, of }).ok_or_else(|| format!("its line {line} has no number in that column"))
    };
    let turns: Vec<Turn> = table.rows.iter().map(turn).collect::<Result<_, _>>()?;
    if turns.is_empty() { Err("it has no row; give one for each turn".to_owned()) } else { Ok(turns) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn taken(text: &str) -> Result<Vec<Turn>, String> {
        let mut test = Test { history: Some("turns.csv".to_owned()), ..Test::default() };
        let read = |name: &str| if name == "turns.csv" { Ok(text.to_owned()) } else { Err(name.to_owned()) };
        test.take_history(read).map_err(|error| error.to_string())?;
        assert_eq!(test.history, None);
        Ok(test.turns)
    }

    #[test]
    fn a_history_is_a_turn_for_each_row_of_a_table() {
        let turns = |of, all: &[f64]| Ok(all.iter().map(|&at| Turn { at, of }).collect());
        assert_eq!(taken("strain\n0.002\n0\n0.005\n"), turns(TurnOf::Strain, &[0.002, 0.0, 0.005]));
        assert_eq!(
            taken("# cycles\r\n\"t\"; \"Stress_MPa\"\r\n1; 10\r\n\r\n2; 1\r\n"),
            turns(TurnOf::Stress, &[10.0, 1.0])
        );
        assert_eq!(taken("opening_mm\n0.1"), turns(TurnOf::Opening, &[0.1]));
        // As a table calculation writes them.
        assert_eq!(taken("t;strain\r1;0,002\r2;0\r"), turns(TurnOf::Strain, &[0.002, 0.0]));
    }

    #[test]
    fn a_history_without_turns_is_refused_with_its_line() {
        for (text, why) in [
            ("", "it has no column strain, stress_mpa or opening_mm"),
            ("0.002\n0.004\n", "it has no column strain, stress_mpa or opening_mm"),
            ("strain\n", "it has no row"),
            ("strain\n0.1\nfar\n", "its line 3 has no number"),
            ("strain\ninf\n", "its line 2 has no number"),
            ("strain,strain\n0.1,0.2\n", "the column strain twice"),
            ("strain,stress_mpa\n0.1,20\n", "it has the columns strain and stress_mpa"),
            ("t,strain\n1\n", "line 2 has 1 cells and line 1 has 2"),
        ] {
            let error = taken(text).unwrap_err();
            assert!(error.contains("test.history is") && error.contains(why), "{error}");
        }
        let mut both = Test {
            history: Some("a.csv".to_owned()),
            turns: vec![Turn { at: 1.0, of: TurnOf::Strain }],
            ..Test::default()
        };
        assert!(both.clone().take_history(|_| Ok(String::new())).is_err());
        both.turns.clear();
        assert!(both.validate().unwrap_err().to_string().contains("only a TEST.toml has it"));
    }
}
