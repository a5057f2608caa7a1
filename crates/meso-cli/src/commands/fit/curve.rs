//! Curves in CSV files: of tests in a laboratory, and of our own.

use crate::failure::Failure;
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
    let text = std::fs::read_to_string(path).map_err(|error| Failure::file(path, &error))?;
    parse(&text, height_mm).map_err(|message| Failure::Usage(format!("{}: {message}", path.display())))
}

fn parse(text: &str, height_mm: f64) -> Result<Vec<[f64; 2]>, String> {
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let mut lines = lines.map(|(number, line)| (number + 1, line.split([',', ';', '\t']).map(str::trim))).peekable();
    let mut columns = Columns { strain: 0, stress: 1, scale: 1.0 };
    let has_header = lines.peek().is_some_and(|(_, cells)| cells.clone().any(|cell| cell.parse::<f64>().is_err()));
    if has_header && let Some((_, cells)) = lines.next() {
        columns = named(&cells.collect::<Vec<_>>(), height_mm)?;
    }
    let row = |(number, cells): (usize, _)| {
        let cells: Vec<&str> = Iterator::collect(cells);
        let cell = |place: usize| cells.get(place).and_then(|cell| cell.parse::<f64>().ok());
        let pair = cell(columns.strain).zip(cell(columns.stress));
        pair.map(|(strain, stress)| [columns.scale * strain, stress])
            .ok_or_else(|| format!("line {number} has no number there"))
    };
    let mut curve: Vec<[f64; 2]> = lines.map(row).collect::<Result<_, _>>()?;
    if curve.iter().map(|point| point[1]).sum::<f64>() < 0.0 {
        curve.iter_mut().flatten().for_each(|value| *value = -*value);
    }
    Ok(curve)
}

fn named(header: &[&str], height_mm: f64) -> Result<Columns, String> {
    let place = |name: &str| header.iter().position(|cell| cell.trim_matches('"').eq_ignore_ascii_case(name));
    let stress = place("stress_mpa").ok_or("it has no column stress_mpa")?;
    match (place("strain"), place("displacement_mm")) {
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
    }

    #[test]
    fn a_curve_without_numbers_or_columns_is_named() {
        assert_eq!(parse("strain,stress_mpa\n0,0\n0.1\n", 1.0), Err("line 3 has no number there".to_owned()));
        assert_eq!(parse("strain,force\n0,0\n", 1.0), Err("it has no column stress_mpa".to_owned()));
        assert_eq!(
            parse("e,stress_mpa\n0,0\n", 1.0),
            Err("it has no column strain and none displacement_mm".to_owned())
        );
        assert_eq!(parse("", 1.0), Ok(Vec::new()));
    }
}
