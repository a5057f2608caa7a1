//! Turns of a path and courses of strains from tables in CSV.

use crate::error::TEST;
use crate::trial::drive::{Speed, unfit_row};
use crate::trial::expansion::{Course, unfit_strain, unfit_time};
use crate::trial::{Drive, Test, Turn, TurnOf};
use meso_concrete::OutOfRange;
use meso_concrete::import::Columns;

/// Columns that give the turns, and their quantities.
const COLUMNS: [(&str, TurnOf); 3] =
    [("strain", TurnOf::Strain), ("stress_mpa", TurnOf::Stress), ("opening_mm", TurnOf::Opening)];

impl Test {
    /// Takes in the tables that [`history`](Self::history) and [`expansion`](Self::expansion) name; `read` gives a file's
    /// text, or why it cannot be read.
    ///
    /// # Errors
    /// A file that cannot be read, one without its columns, a row without a number or with one out of range, and turns
    /// beside their table.
    pub fn take_tables(&mut self, read: impl Fn(&str) -> Result<String, String>) -> Result<(), OutOfRange> {
        for (key, course) in self.expansion.iter_mut().flat_map(|expansion| expansion.courses_mut()) {
            let Course::Table(name) = course else { continue };
            let rows = read(name).and_then(|text| rows(&text));
            *course = Course::Through(rows.map_err(|why| TEST.error(key, &*name, why))?);
        }
        for support in &mut self.supports {
            let key = format!("supports.{}.drive.speed_m_per_s", support.name);
            let Some(speed) = support.drive.as_mut().and_then(Drive::speed_mut) else { continue };
            let Speed::Table(name) = speed else { continue };
            let rows = read(name).and_then(|text| speeds(&text));
            *speed = Speed::Over(rows.map_err(|why| TEST.error(key, &*name, why))?);
        }
        let Some(name) = self.history.take() else { return Ok(()) };
        if !self.turns.is_empty() {
            return Err(TEST.error("history", name, "the test has turns, too; leave one of them out"));
        }
        let turns = read(&name).and_then(|text| turns(&text));
        self.turns = turns.map_err(|why| TEST.error("history", name, why))?;
        Ok(())
    }

    /// Names of the tables that [`take_tables`](Self::take_tables) reads.
    pub fn tables(&self) -> Vec<String> {
        let courses = self.expansion.iter().flat_map(|expansion| expansion.courses());
        let name = |course: &Course| if let Course::Table(name) = course { Some(name.clone()) } else { None };
        let speeds = self.supports.iter().filter_map(|support| support.drive.as_ref()?.speed());
        let table = |speed: &Speed| if let Speed::Table(name) = speed { Some(name.clone()) } else { None };
        let history = self.history.clone().into_iter();
        history.chain(courses.filter_map(name)).chain(speeds.filter_map(table)).collect()
    }
}

/// Rows of a course: a header, then a time and a strain for each row. A first row of zeros repeats the start.
fn rows(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for (line, [time, strain]) in pairs(text, ["time", "strain"])? {
        if rows.is_empty() && [time, strain] == [0.0; 2] {
            continue;
        }
        let before = rows.last().map_or(0.0, |row| row[0]);
        let of_time = unfit_time(before, time).map(|why| ("time", time, why.to_owned()));
        if let Some((name, value, why)) = of_time.or_else(|| Some(("strain", strain, unfit_strain(strain)?))) {
            return Err(format!("its line {line} has {value} in the column {name}; {why}"));
        }
        rows.push([time, strain]);
    }
    if rows.is_empty() { Err("it has no row; give one for each time and its strain".to_owned()) } else { Ok(rows) }
}

/// Rows of a speed over time: a header, then a time and a speed for each row.
fn speeds(text: &str) -> Result<Vec<[f64; 2]>, String> {
    let names = ["time_s", "speed_m_per_s"];
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for (line, row) in pairs(text, names)? {
        if let Some((place, why)) = unfit_row(rows.last().map_or(0.0, |row| row[0]), row) {
            return Err(format!("its line {line} has {} in the column {}; {why}", row[place], names[place]));
        }
        rows.push(row);
    }
    if rows.is_empty() { Err("it has no row; give one for each time and its speed".to_owned()) } else { Ok(rows) }
}

/// The numbers of two columns of a table, each row with the number of its line.
fn pairs(text: &str, names: [&str; 2]) -> Result<Vec<(usize, [f64; 2])>, String> {
    let table = Columns::parse(text)?;
    let place = |name: &str| table.place(name)?.ok_or_else(|| format!("it has no column {name} in its first line"));
    let places = [place(names[0])?, place(names[1])?];
    let row = |(line, cells): &(usize, Vec<Option<f64>>)| {
        let number = |column: usize| {
            let name = names[column];
            cells[places[column]].ok_or_else(|| format!("its line {line} has no number in the column {name}"))
        };
        Ok((*line, [number(0)?, number(1)?]))
    };
    table.rows.iter().map(row).collect()
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
    let &(place, name, of) =
        found.first().ok_or("it has no column strain, stress_mpa or opening_mm in its first line")?;
    let turn = |(line, cells): &(usize, Vec<Option<f64>>)| {
        let at = cells[place].filter(|at| at.is_finite());
        at.map(|at| Turn { at, of }).ok_or_else(|| format!("its line {line} has no number in the column {name}"))
    };
    let turns: Vec<Turn> = table.rows.iter().map(turn).collect::<Result<_, _>>()?;
    if turns.is_empty() { Err("it has no row; give one for each turn".to_owned()) } else { Ok(turns) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trial::Expansion;

    fn taken(text: &str) -> Result<Vec<Turn>, String> {
        let mut test = Test { history: Some("turns.csv".to_owned()), ..Test::default() };
        let read = |name: &str| if name == "turns.csv" { Ok(text.to_owned()) } else { Err(name.to_owned()) };
        test.take_tables(read).map_err(|error| error.to_string())?;
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
        assert_eq!(Test { history: Some("a.csv".to_owned()), ..Test::default() }.tables(), ["a.csv"]);
        let mut both = Test {
            history: Some("a.csv".to_owned()),
            turns: vec![Turn { at: 1.0, of: TurnOf::Strain }],
            ..Test::default()
        };
        assert!(both.clone().take_tables(|_| Ok(String::new())).is_err());
        both.turns.clear();
        assert!(both.validate().unwrap_err().to_string().contains("only a TEST.toml and Python"));
    }

    fn course(text: &str) -> Result<Course, String> {
        let expansion = Expansion { aggregate: Course::Table("drying.csv".to_owned()), ..Expansion::default() };
        let mut test = Test { expansion: Some(expansion), ..Test::default() };
        assert_eq!(test.tables(), ["drying.csv"]);
        let read = |name: &str| if name == "drying.csv" { Ok(text.to_owned()) } else { Err(name.to_owned()) };
        test.take_tables(read).map_err(|error| error.to_string())?;
        Ok(test.expansion.unwrap().aggregate)
    }

    #[test]
    fn a_course_has_the_rows_of_its_table() {
        let rows = Ok(Course::Through(vec![[28.0, -2e-4], [90.0, -4e-4]]));
        assert_eq!(course("time,strain\n28,-2e-4\n90,-4e-4\n"), rows);
        assert_eq!(course("# gauge 3\nStrain;Gauge;Time\n0;7;0\n-0,0002;7;28\n-0,0004;7;90\n"), rows);
    }

    #[test]
    fn a_table_that_is_no_course_is_refused_with_its_line_and_column() {
        for (text, why) in [
            ("28,-2e-4\n90,-4e-4\n", "it has no column time in its first line"),
            ("time,eps\n28,-2e-4\n", "it has no column strain in its first line"),
            ("time,time,strain\n1,2,3\n", "the column time twice"),
            ("time,strain\n0,0\n", "it has no row"),
            ("time,strain\n28,-2e-4\n90,dry\n", "its line 3 has no number in the column strain"),
            ("time,strain\nsoon,1e-4\n", "its line 2 has no number in the column time"),
            ("time,strain\n28,1e-4\n7,2e-4\n", "its line 3 has 7 in the column time; times must be finite"),
            ("time,strain\ninf,1e-4\n", "its line 2 has inf in the column time"),
            ("time,strain\n0,1e-4\n", "its line 2 has 0 in the column time"),
            ("time,strain\n\n28,-300\n", "its line 3 has -300 in the column strain; it must be -0.005 to 0.02"),
            ("time,strain\n28,nan\n", "its line 2 has NaN in the column strain"),
            ("time,strain\n28\n", "line 2 has 1 cells and line 1 has 2"),
        ] {
            let error = course(text).unwrap_err();
            assert!(error.contains("test.expansion.aggregate is drying.csv; ") && error.contains(why), "{error}");
        }
    }
}
