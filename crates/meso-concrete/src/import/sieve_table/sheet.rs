//! The table within a file: its headings, the column of its sieves, and the numbers beside them.

use super::cells::{self, Marks, Number, Sieve, SieveUnit};
use super::text::{self, Row};
use super::words::{self, Said};
use super::{Choices, ValueUnit};

/// A column of numbers beside the sieves.
pub(super) struct Values {
    /// Position in the file, from 1.
    pub(super) position: usize,
    pub(super) heading: String,
    pub(super) said: Said,
    /// Number of every sieve, from the coarsest; none in a blank cell, a reason for one that is no number.
    pub(super) numbers: Vec<Result<Option<Number>, String>>,
    pub(super) pan: Option<f64>,
    /// Fines that were washed out, with their line.
    pub(super) washed: Option<(usize, f64)>,
    /// The initial mass, or the sum, with its line.
    pub(super) total: Option<(usize, f64)>,
    /// Share in a blend, where a row of the table gives it.
    pub(super) share: Option<f64>,
    /// Why a mass of the test, the pan or the sum is no number.
    pub(super) fault: Option<String>,
}

impl Values {
    /// The column for its user.
    pub(super) fn name(&self) -> String {
        if self.heading.is_empty() {
            format!("column {}", self.position)
        } else {
            format!("column {} {:?}", self.position, self.heading)
        }
    }
}

/// Sieves from the coarsest, and the columns beside them.
pub(super) struct Sheet {
    pub(super) sieves: Vec<(usize, f64)>,
    pub(super) sieve_name: String,
    pub(super) columns: Vec<Values>,
}

impl Sheet {
    /// Finds the table in a text whose fields stand between `separator`.
    pub(super) fn of(text: &str, separator: char, choices: &Choices) -> Result<Self, String> {
        let rows = upright(text::rows(text, separator));
        let marks = if separator == ',' { Marks::POINT } else { marks(&rows) };
        let width = rows.iter().map(|row| row.cells.len()).max().unwrap_or(0);
        let grid = Grid { rows: &rows, marks, separator, chosen: choices.sieve_unit };
        let bodies: Vec<Body> = (0..width.min(64)).filter_map(|column| grid.body(column)).collect();
        let named = bodies.iter().filter(|body| body.said.is_sieve);
        let best = named.min_by_key(|body| (!body.is_metric(), body.column)).or_else(|| sole(&bodies));
        let Some(best) = best else { return Err(grid.no_sieves(&bodies)) };
        grid.leaves_no_row_above(best)?;
        let sheet = grid.sheet(best)?;
        let mut others = bodies.iter().filter(|body| body.said.is_sieve && body.column != best.column);
        others.try_for_each(|body| grid.agrees(best, body))?;
        Ok(sheet)
    }
}

/// The first column that can be sieves where no heading says so: bare numbers are proved later.
fn sole(bodies: &[Body]) -> Option<&Body> {
    bodies
        .iter()
        .find(|body| !body.said.has_meaning && body.said.unit.is_none() && !body.said.is_foreign && !body.is_index)
}

/// Decimal marks that cells prove by themselves.
fn marks(rows: &[Row]) -> Marks {
    let cells = rows.iter().filter(|row| row.cells.len() > 1).flat_map(|row| &row.cells);
    cells.map(|cell| cells::proof(cell)).fold(Marks::NONE, |all, one| Marks {
        comma: all.comma || one.comma,
        point: all.point || one.point,
        ..all
    })
}

/// Turns a table whose sieves stand in a row.
fn upright(rows: Vec<Row>) -> Vec<Row> {
    let is_number = |cell: &String| cells::number(cell, Marks::POINT).is_ok() || cells::proof(cell).comma;
    let wide = |row: &&Row| {
        row.cells.len() > 3 && row.cells.iter().skip(2).filter(|cell| is_number(cell)).count() + 2 >= row.cells.len()
    };
    let lying: Vec<&Row> = rows.iter().filter(wide).collect();
    let labelled = |row: &&Row| {
        row.cells
            .first()
            .is_some_and(|cell| !is_number(cell) && matches!(cells::sieve(cell, None, Marks::NONE), Ok(None)))
    };
    let words = lying.first().and_then(|row| row.cells.first()).map(|cell| words::read(cell));
    if lying.len() < 2 || !lying.iter().all(labelled) || !words.is_some_and(|said| said.is_sieve) {
        return rows;
    }
    let width = lying.iter().map(|row| row.cells.len()).max().unwrap_or(0);
    let cell = |row: &Row, i: usize| row.cells.get(i).cloned().unwrap_or_default();
    (0..width).map(|i| Row { line: lying[0].line, cells: lying.iter().map(|row| cell(row, i)).collect() }).collect()
}

/// One column as the column of sieves: where its rows are, and what stands above them.
struct Body {
    column: usize,
    /// First row below the nearest heading; 0 without a heading.
    after: usize,
    first: usize,
    said: Said,
    /// The numbers 1, 2, 3: rows are counted.
    is_index: bool,
}

impl Body {
    fn is_metric(&self) -> bool {
        matches!(self.said.sieve_unit, Some(SieveUnit::Mm | SieveUnit::Um))
    }
}

struct Grid<'a> {
    rows: &'a [Row],
    marks: Marks,
    separator: char,
    chosen: Option<SieveUnit>,
}

impl Grid<'_> {
    fn sieve(&self, row: &Row, column: usize, unit: Option<SieveUnit>) -> Result<Option<Sieve>, String> {
        let cell = row.cells.get(column).map_or("", String::as_str);
        cells::sieve(cell, self.chosen.or(unit), self.marks)
    }

    /// Whether a row has a sieve in `column` and a number in another.
    fn has_data(&self, row: &Row, column: usize) -> bool {
        // A bare fraction is of inches, if the heading says so.
        let is_sieve = [None, Some(SieveUnit::Inch)].iter().any(|unit| {
            let found = self.sieve(row, column, *unit);
            found.map_or(true, |found| matches!(found, Some(Sieve::Opening(_) | Sieve::Bare(_) | Sieve::Pan(_))))
        });
        let is_number = |(at, cell): (usize, &String)| at != column && cells::is_number(cell);
        is_sieve && row.cells.iter().enumerate().any(is_number)
    }

    /// Whether a row heads a table with its sieves in `column`.
    fn is_heading(&self, at: usize, column: usize) -> bool {
        let cell = self.rows[at].cells.get(column).map_or("", String::as_str);
        // A sieve with a slip of the keys is no heading.
        let is_word = !cells::begins_a_number(cell) && !matches!(cells::sieve(cell, None, self.marks), Ok(Some(_)));
        let data = self.rows[at + 1..].iter().filter(|row| self.has_data(row, column));
        is_word && words::read(cell).is_sieve && data.count() > 1
    }

    fn body(&self, column: usize) -> Option<Body> {
        let data = |row: &Row| self.has_data(row, column);
        let after = (0..self.rows.len()).rev().find(|&at| self.is_heading(at, column)).map_or(0, |at| at + 1);
        let first = (after..self.rows.len()).find(|&at| data(&self.rows[at]))?;
        // Sieves without a number above the first row of data belong to the table.
        let is_sieve = |at: &usize| {
            matches!(self.sieve(&self.rows[*at], column, None), Ok(Some(Sieve::Opening(_) | Sieve::Bare(_))))
        };
        let first = (after..first).rev().take_while(is_sieve).last().unwrap_or(first);
        if self.rows[first..].iter().filter(|row| data(row)).count() < 2 {
            return None;
        }
        let said = words::read(&self.heading(first, column));
        let counts = self.rows[first..].iter().filter(|row| data(row)).zip(1_u32..);
        let is_index = counts.clone().all(|(row, count)| row.cells[column] == count.to_string());
        Some(Body { column, after, first, said, is_index })
    }

    /// Rows above the first one belong to no other table, and name no sieve that cannot be read.
    fn leaves_no_row_above(&self, body: &Body) -> Result<(), String> {
        let heading = (0..body.after).find(|&at| self.is_heading(at, body.column)).unwrap_or(body.after);
        let is_left = |row: &&Row| self.has_data(row, body.column);
        if let Some(row) = self.rows[heading..body.after].iter().find(is_left) {
            let line = self.rows[body.after - 1].line;
            return Err(format!(
                "line {line}: a second heading, below the sieves from line {} on; keep one table",
                row.line
            ));
        }
        let is_meant = |row: &&Row| {
            let cell = row.cells.get(body.column).map_or("", String::as_str);
            !self.is_share_row(row) && (body.after > 0 || cells::begins_a_number(cell))
        };
        let mut above = self.rows[body.after..body.first].iter().filter(is_meant);
        above.try_for_each(|row| {
            self.is_remark(row, body.column).map_err(|reason| format!("line {}: {reason}", row.line))
        })
    }

    fn no_sieves(&self, bodies: &[Body]) -> String {
        let has_number = |row: &&Row| row.cells.iter().skip(1).any(|cell| cells::is_number(cell));
        let what = match self.rows.iter().find(has_number) {
            _ if !bodies.is_empty() => "no column is that of the sieves".to_owned(),
            Some(row) => format!("line {}: {:?} names no sieve", row.line, row.cells[0]),
            None => "it has no column of sieves with a number beside each".to_owned(),
        };
        format!(
            "{what}; write a line for each sieve, its opening and the per cent that passes, as in Sieve (mm);Passing (%)"
        )
    }

    /// Cells above the first row of data: the nearest rows of words, at most three.
    fn heading(&self, first: usize, column: usize) -> String {
        let mut parts: Vec<&str> =
            self.heads(first).iter().filter_map(|row| row.cells.get(column)).map(String::as_str).collect();
        parts.retain(|part| !part.is_empty());
        parts.join(" ")
    }

    fn heads(&self, first: usize) -> Vec<&Row> {
        let above = self.rows[..first].iter().rev();
        let above = above.filter(|row| !self.is_share_row(row) && !self.is_of_the_test(row, 0));
        let filled = |row: &&Row| row.cells.iter().filter(|cell| !cell.is_empty()).count();
        let above = above.skip_while(|row| row.cells.is_empty());
        let is_head = |(at, row): &(usize, &Row)| {
            let numbers = row.cells.iter().filter(|cell| cells::is_number(cell)).count();
            let has_words = row.cells.iter().any(|cell| words::read(cell).is_sieve);
            filled(row) > 1 && (numbers == 0 || (*at == 0 && has_words))
        };
        let mut heads: Vec<&Row> = above.enumerate().take_while(is_head).map(|(_, row)| row).take(3).collect();
        heads.reverse();
        heads
    }

    fn is_share_row(&self, row: &Row) -> bool {
        let numbers = row.cells.iter().skip(1).filter(|cell| cells::is_number(cell)).count();
        numbers > 1 && row.cells.first().is_some_and(|cell| words::is_share_row(cell))
    }

    /// Whether a row has a mass or a figure of the test, as that before washing.
    fn is_of_the_test(&self, row: &Row, column: usize) -> bool {
        let cell = row.cells.get(column).map_or("", String::as_str);
        matches!(
            cells::sieve(cell, None, self.marks),
            Ok(Some(Sieve::Initial | Sieve::Left | Sieve::Washed | Sieve::Figure))
        )
    }

    fn sheet(&self, body: &Body) -> Result<Sheet, String> {
        let sieve_heading = self.heading(body.first, body.column);
        let width = self.rows[body.first..].iter().map(|row| row.cells.len()).max().unwrap_or(0);
        self.fits_its_headings(body)?;
        if let Some(unit) =
            words::foreign_unit(&sieve_heading).filter(|_| self.chosen.or(body.said.sieve_unit).is_none())
        {
            let line = self.rows[body.first].line;
            return Err(format!(
                "line {line}: the sieves are in {unit:?} by the heading {sieve_heading:?}; write them in mm"
            ));
        }
        let mut found: Vec<(f64, bool, &Row)> = Vec::new();
        let (mut pans, mut washed, mut initial, mut left, mut total) = (Vec::new(), None, None, None, None);
        // Masses of the test may stand between the heading and the first sieve, or above the heading as in EN 933-1.
        let begin = if body.after > 0 { body.after } else { body.first };
        let is_headed = |row: &Row| row.line < self.rows[begin].line;
        let numbers = |row: &Row| {
            let cells = row.cells.iter().enumerate();
            cells
                .filter(|(at, cell)| *at != body.column && cells::is_number(cell))
                .map(|(at, _)| at)
                .collect::<Vec<_>>()
        };
        let headed =
            self.rows[..begin].iter().filter(|row| self.is_of_the_test(row, body.column) && !numbers(row).is_empty());
        for row in headed.chain(&self.rows[begin..]).filter(|row| !row.cells.is_empty()) {
            let at = |reason: String| format!("line {}: {reason}", row.line);
            match self.sieve(row, body.column, body.said.sieve_unit).map_err(at)? {
                Some(Sieve::Opening(size)) => found.push((size, false, row)),
                Some(Sieve::Bare(size)) => found.push((size, true, row)),
                Some(Sieve::Pan(size)) => pans.push((size, row)),
                Some(Sieve::Washed) if washed.is_some() => {
                    return Err(at("a second row of what was washed out".to_owned()));
                }
                Some(Sieve::Washed) => washed = Some(row),
                Some(Sieve::Initial) => initial = Some(row),
                Some(Sieve::Left) => left = Some(row),
                Some(Sieve::Total) => total = Some(row),
                Some(Sieve::Figure) => {}
                None if self.is_share_row(row) => {}
                None => self.is_remark(row, body.column).map_err(at)?,
            }
        }
        proved_millimetres(&found, &sieve_heading)?;
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        if let Some(pair) = found.windows(2).find(|pair| pair[0].0 == pair[1].0) {
            let [first, second] = [pair[0].2.line.min(pair[1].2.line), pair[0].2.line.max(pair[1].2.line)];
            return Err(format!("line {second}: the sieve of {} mm stands in line {first} already", pair[0].0));
        }
        let pan = self.pan(&pans, &found)?;
        let shares = self.rows.iter().find(|row| self.is_share_row(row));
        let is_percent: Vec<bool> =
            (0..width).map(|at| words::read(&self.heading(body.first, at)).unit == Some(ValueUnit::Percent)).collect();
        let number = |row: &Row, at: usize| {
            let marks = if is_percent[at] { self.marks.up_to(100.0) } else { self.marks };
            let cell = row.cells.get(at).map_or("", String::as_str);
            if cells::is_blank(cell) { Ok(None) } else { cells::number(cell, marks).map(Some) }
        };
        let total = initial.or(total);
        let weighed = found.iter().map(|row| row.2).chain(pan).chain(washed).chain(left).chain(total);
        (0..width).try_for_each(|at| one_unit_of_mass(weighed.clone(), at))?;
        let one = |row: Option<&Row>, at: usize| {
            let Some(row) = row else { return Ok(None) };
            // The only number of a line above the heading is of all columns.
            let at = numbers(row).first().copied().filter(|_| is_headed(row) && numbers(row).len() == 1).unwrap_or(at);
            match number(row, at) {
                Ok(number) => Ok(number.map(|number| number.value)),
                Err(reason) if row.cells[at].contains(|c: char| c.is_ascii_digit()) => {
                    Err(format!("line {}: {reason}", row.line))
                }
                Err(_) => Ok(None),
            }
        };
        let known = |row: Option<&Row>, at: usize| one(row, at).ok().flatten();
        let washed_out = |at: usize| {
            let by_masses = || Some((left?.line, known(initial, at)? - known(left, at)?)).filter(|fines| fines.1 > 0.0);
            washed.and_then(|row| Some((row.line, known(washed, at)?))).or_else(by_masses)
        };
        let columns = (0..width).filter(|&at| at != body.column).map(|at| {
            let heading = self.heading(body.first, at);
            Values {
                position: at + 1,
                said: words::read(&heading),
                heading,
                numbers: found.iter().map(|row| number(row.2, at)).collect(),
                pan: known(pan, at),
                washed: washed_out(at),
                total: total.and_then(|row| Some((row.line, known(total, at)?))),
                share: known(shares, at),
                fault: [pan, washed, left, total].into_iter().find_map(|row| one(row, at).err()),
            }
        });
        let has_numbers = |values: &Values| {
            found.iter().filter_map(|row| row.2.cells.get(values.position - 1)).any(|cell| cells::is_number(cell))
        };
        let columns = columns.filter(|values| has_numbers(values) && !is_index(values));
        Ok(Sheet {
            sieves: found.iter().map(|row| (row.2.line, row.0)).collect(),
            sieve_name: format!("column {} {sieve_heading:?}", body.column + 1),
            columns: columns.collect(),
        })
    }

    /// Between commas a decimal comma makes one field more.
    fn fits_its_headings(&self, body: &Body) -> Result<(), String> {
        if self.separator != ',' {
            return Ok(());
        }
        let heads = self.heads(body.first);
        let headed = heads.iter().map(|row| row.cells.len()).max().unwrap_or(2);
        match self.rows[body.first..].iter().find(|row| row.cells.len() > headed) {
            Some(row) => Err(format!(
                "line {}: it has {} fields where {headed} are expected; where a comma stands before decimals, separate the fields by ;",
                row.line,
                row.cells.len()
            )),
            None => Ok(()),
        }
    }

    /// The row below the finest sieve.
    fn pan<'a>(&self, pans: &[(Option<f64>, &'a Row)], found: &[(f64, bool, &Row)]) -> Result<Option<&'a Row>, String> {
        let Some(&(below, row)) = pans.first() else { return Ok(None) };
        if let Some(&(_, second)) = pans.get(1) {
            return Err(format!("line {}: a second row for the pan, after line {}; keep one", second.line, row.line));
        }
        let finest = found.last().map_or(0.0, |row| row.0);
        match below {
            Some(size) if (size / finest - 1.0).abs() > 0.03 => {
                Err(format!("line {}: it counts all below {size} mm, but the finest sieve has {finest} mm", row.line))
            }
            _ => Ok(Some(row)),
        }
    }

    /// A row of words below the first sieve: remarks have no numbers.
    fn is_remark(&self, row: &Row, column: usize) -> Result<(), String> {
        let first = row.cells.get(column).map_or("", String::as_str);
        let has_number = |(at, cell): (usize, &String)| at != column && cells::is_number(cell);
        if self.is_of_the_test(row, column) || !row.cells.iter().enumerate().any(has_number) {
            return Ok(());
        }
        Err(format!("{first:?} names no sieve; write its opening in mm, in inches as 3/4 in, as No. 4, or Pan"))
    }

    /// Two columns name the same sieves.
    fn agrees(&self, best: &Body, other: &Body) -> Result<(), String> {
        let size = |row: &Row, body: &Body| match self.sieve(row, body.column, body.said.sieve_unit) {
            Ok(Some(Sieve::Opening(size))) => Some(size),
            _ => None,
        };
        let differs = |row: &&Row| match (size(row, best), size(row, other)) {
            (Some(a), Some(b)) => (a / b - 1.0).abs() > 0.03,
            _ => false,
        };
        match self.rows[best.first..].iter().find(differs) {
            Some(row) => Err(format!(
                "line {}: its columns {} and {} name two sieves",
                row.line,
                best.column + 1,
                other.column + 1
            )),
            None => Ok(()),
        }
    }
}

/// The rows are counted in this column.
fn is_index(values: &Values) -> bool {
    let at = |i: usize, number: &Result<Option<Number>, String>| matches!(number, Ok(Some(number)) if number.value == i as f64);
    let count = values.numbers.len();
    let upwards = values.numbers.iter().enumerate().all(|(i, number)| at(i + 1, number));
    let downwards = values.numbers.iter().enumerate().all(|(i, number)| at(count - i, number));
    values.said.unit.is_none() && !values.said.has_meaning && count > 2 && (upwards || downwards)
}

/// Masses of a column are all in kg by their cells, or none is.
fn one_unit_of_mass<'a>(rows: impl Iterator<Item = &'a Row>, column: usize) -> Result<(), String> {
    let cell = |row: &'a Row| Some((row.line, row.cells.get(column)?));
    let is_mass =
        |(_, cell): &(usize, &String)| cells::number(cell, Marks::COMMA).is_ok_and(|number| number.value > 0.0);
    let (kg, others): (Vec<_>, Vec<_>) =
        rows.filter_map(cell).filter(is_mass).partition(|(_, cell)| cells::is_in_kg(cell));
    match (kg.first(), others.first()) {
        (Some((line, cell)), Some((other, _))) => {
            Err(format!("line {line}: {cell:?} is in kg, and line {other} is not; write all masses in one unit"))
        }
        _ => Ok(()),
    }
}

fn proved_millimetres(found: &[(f64, bool, &Row)], heading: &str) -> Result<(), String> {
    let bare: Vec<f64> = found.iter().filter(|row| row.1).map(|row| row.0).collect();
    if bare.is_empty() || cells::are_millimetres(&bare) {
        return Ok(());
    }
    let line = found.iter().find(|row| row.1).map_or(0, |row| row.2.line);
    Err(format!(
        "line {line}: no unit of the sieves in the heading {heading:?}; write Sieve (mm), or sieve_unit = \"mm\" beside file"
    ))
}
