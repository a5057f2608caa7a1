//! Curves in CSV files: of tests in a laboratory, and of our own.

use crate::failure::Failure;
use crate::inputs;
use meso_core::import::sieve_table;
use std::path::Path;

/// The columns of strain and stress in a file.
struct Columns {
    strain: usize,
    stress: usize,
    /// Strain per unit of the first.
    scale: f64,
}

/// Reads strain and stress, MPa, of a specimen of this height. Curves of compression with negative signs are turned round.
pub(super) fn read(path: &Path, height_mm: f64) -> Result<Vec<[f64; 2]>, Failure> {
    let wrong = |message: String| Failure::Usage(format!("{}: {message}", path.display()));
    let text = sieve_table::decode(&inputs::table(path)?).map_err(wrong)?;
    parse(&text, height_mm).map_err(wrong)
}

fn parse(text: &str, height_mm: f64) -> Result<Vec<[f64; 2]>, String> {
    let text = text.replace("\r\n", "\n");
    let lines =
        || text.split(['\n', '\r']).zip(1..).filter(|(line, _)| !(line.trim().is_empty() || line.starts_with('#')));
    let Some((first, number)) = lines().next() else { return Ok(Vec::new()) };
    let separator = [';', '\t', ','].into_iter().find(|separator| first.contains(*separator)).unwrap_or(',');
    let columns = match numbers(first, separator).contains(&None) {
        true => named(&first.split(separator).map(str::trim).collect::<Vec<_>>(), height_mm)?,
        false => Columns { strain: 0, stress: 1, scale: 1.0 },
    };
    let count = first.split(separator).count();
    let row = |(line, place): (&str, usize)| {
        let cells = numbers(line, separator);
        let cell = |column: usize| cells.get(column).copied().flatten();
        if cells.len() != count {
            return Err(format!("line {place} has {} cells and line {number} has {count}", cells.len()));
        }
        let pair = cell(columns.strain).zip(cell(columns.stress));
        pair.map(|(strain, stress)| [columns.scale * strain, stress])
            .ok_or_else(|| format!("line {place} has no number there"))
    };
    let has_header = usize::from(numbers(first, separator).contains(&None));
    let mut curve: Vec<[f64; 2]> = lines().skip(has_header).map(row).collect::<Result<_, _>>()?;
    if curve.iter().map(|point| point[1]).sum::<f64>() < 0.0 {
        curve.iter_mut().flatten().for_each(|value| *value = -*value);
    }
    Ok(curve)
}

/// The cells of a line as numbers. Where commas separate no cells, they stand before decimals.
fn numbers(line: &str, separator: char) -> Vec<Option<f64>> {
    let number = |cell: &str| match separator {
        ',' => cell.trim().parse().ok(),
        _ => cell.trim().replace(',', ".").parse().ok(),
    };
    line.split(separator).map(number).collect()
}

fn named(header: &[&str], height_mm: f64) -> Result<Columns, String> {
    let places = |name: &str| {
        let is_it = |cell: &&str| cell.trim_matches('"').eq_ignore_ascii_case(name);
        let places: Vec<usize> = (0..header.len()).filter(|&place| is_it(&header[place])).collect();
        if places.len() > 1 { Err(format!("it has the column {name} twice; keep one of the two")) } else { Ok(places) }
    };
    let place = |name: &str| places(name).map(|places| places.first().copied());
    let stress = place("stress_mpa")?.ok_or("it has no column stress_mpa")?;
    match (place("strain")?, place("displacement_mm")?) {
        (Some(strain), _) => Ok(Columns { strain, stress, scale: 1.0 }),
        (None, Some(strain)) => Ok(Columns { strain, stress, scale: 1.0 / height_mm }),
        (None, None) => Err("it has no column strain and none displacement_mm".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_by_the_names_of_their_columns_or_their_order() {
        let expected = Ok(vec![[0.0, 0.0], [0.001, 30.0]]);
        assert_eq!(parse("0,0\n0.001,30\n", 100.0), expected);
        assert_eq!(parse("# a remark\ntime_s,stress_mpa,strain\n1,0,0\n2,30,0.001\n\n", 100.0), expected);
        assert_eq!(parse("displacement_mm;stress_mpa\n0;0\n0.1;30\n", 100.0), expected);
        assert_eq!(parse("0,0\n-0.001,-30\n", 100.0).map(|curve| curve[1]), Ok([0.001, 30.0]));
        // As a laboratory's table calculation writes them.
        assert_eq!(parse("0;0\r\n0,001;30\r\n", 100.0), expected);
        assert_eq!(parse("strain\tstress_mpa\r0\t0\r0,001\t30,0\r", 100.0), expected);
    }

    #[test]
    fn a_curve_without_numbers_or_columns_is_named() {
        assert_eq!(parse("strain,stress_mpa\n0,0\n0.1,x\n", 1.0), Err("line 3 has no number there".to_owned()));
        let short = "line 3 has 1 cells and line 1 has 2";
        assert_eq!(parse("strain,stress_mpa\r\n0,0\r\n0.1\r\n", 1.0), Err(short.to_owned()));
        assert_eq!(parse("strain,stress_mpa\n0,0\n0.1\n", 1.0), Err(short.to_owned()));
        // Decimal commas between commas.
        assert!(parse("0,0\n0,001,30\n", 1.0).unwrap_err().contains("line 2 has 3 cells"));
        let twice = "it has the column strain twice; keep one of the two";
        assert_eq!(parse("strain,stress_mpa,Strain\n0,0,1\n", 1.0), Err(twice.to_owned()));
        assert_eq!(parse("strain,force\n0,0\n", 1.0), Err("it has no column stress_mpa".to_owned()));
        assert_eq!(
            parse("e,stress_mpa\n0,0\n", 1.0),
            Err("it has no column strain and none displacement_mm".to_owned())
        );
        assert_eq!(parse("", 1.0), Ok(Vec::new()));
    }
}
