//! Tables of numbers in text: a header, if there is one, then a row on each line.

/// A table of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// Names of the columns; none where the first line holds numbers alone.
    pub names: Vec<String>,
    /// Line and cells of each row, none for a cell that is no number.
    pub rows: Vec<(usize, Vec<Option<f64>>)>,
}

impl Columns {
    /// Reads a table.
    ///
    /// Cells end at semicolons, tabs or commas, whichever the first line has; between the former two a decimal comma is
    /// read, too. Empty lines, lines that begin with # and Excel's mark of UTF-8 are left out.
    ///
    /// # Errors
    /// A row with more or fewer cells than the first one.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim_start_matches('\u{feff}').replace("\r\n", "\n");
        let is_row = |(line, _): &(&str, usize)| !line.trim().is_empty() && !line.starts_with('#');
        let mut lines = text.split(['\n', '\r']).zip(1..).filter(is_row).peekable();
        let Some(&(first, number)) = lines.peek() else { return Ok(Self::default()) };
        let separator = [';', '\t', ','].into_iter().find(|separator| first.contains(*separator)).unwrap_or(',');
        let count = first.split(separator).count();
        let header = numbers(first, separator).contains(&None).then(|| lines.next()).flatten();
        let name = |cell: &str| cell.trim().trim_matches('"').to_owned();
        let names = header.map(|(line, _)| line.split(separator).map(name).collect()).unwrap_or_default();
        let row = |(line, place): (&str, usize)| match numbers(line, separator) {
            cells if cells.len() == count => Ok((place, cells)),
            cells => Err(format!("line {place} has {} cells and line {number} has {count}", cells.len())),
        };
        Ok(Self { names, rows: lines.map(row).collect::<Result<_, _>>()? })
    }

    /// Place of the column with this name, whatever its case.
    ///
    /// # Errors
    /// Two columns have the name.
    pub fn place(&self, name: &str) -> Result<Option<usize>, String> {
        let mut places = (0..self.names.len()).filter(|&place| self.names[place].eq_ignore_ascii_case(name));
        match (places.next(), places.next()) {
            (_, Some(_)) => Err(format!("it has the column {name} twice; keep one of the two")),
            (place, None) => Ok(place),
        }
    }
}

/// The cells of a line as numbers. Where commas separate no cells, they stand before decimals.
fn numbers(line: &str, separator: char) -> Vec<Option<f64>> {
    let number = |cell: &str| match separator {
        ',' => cell.parse().ok(),
        _ => cell.replace(',', ".").parse().ok(),
    };
    line.split(separator).map(|cell| number(cell.trim().trim_matches('"'))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_of_numbers_is_read_whatever_its_separator_and_line_ends() {
        for text in ["a,b\n0.5,2\n", "# a remark\r\n\"a\";b\r\n\r\n0,5;\"2\"\r\n", "a\tb\r0,5\t2\r"] {
            let table = Columns::parse(text).unwrap();
            assert_eq!(table.names, ["a", "b"]);
            assert_eq!(table.rows.iter().map(|(_, cells)| cells.clone()).collect::<Vec<_>>(), [[Some(0.5), Some(2.0)]]);
            assert_eq!([table.place("B"), table.place("c")], [Ok(Some(1)), Ok(None)]);
        }
        assert_eq!(
            Columns::parse("1,2\n3,x\n").unwrap().rows,
            [(1, vec![Some(1.0), Some(2.0)]), (2, vec![Some(3.0), None])]
        );
        assert_eq!(Columns::parse("\n# nothing\n"), Ok(Columns::default()));
    }

    #[test]
    fn a_table_with_short_rows_or_two_columns_of_one_name_is_refused() {
        let short = "line 3 has 1 cells and line 1 has 2";
        assert_eq!(Columns::parse("a,b\r\n0,0\r\n0.1\r\n"), Err(short.to_owned()));
        // Decimal commas between commas.
        assert!(Columns::parse("0,0\n0,001,30\n").unwrap_err().contains("line 2 has 3 cells"));
        let twice = Columns::parse("a,A\n1,2\n").unwrap().place("a");
        assert_eq!(twice, Err("it has the column a twice; keep one of the two".to_owned()));
    }
}
