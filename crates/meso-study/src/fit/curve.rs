//! Curves in CSV files: of tests in a laboratory, and of our own.

use meso_core::import::{Columns, sieve_table};

/// Strain and stress, MPa, in the bytes of a file about a specimen of this height. Curves of compression with negative signs are
/// turned round.
///
/// # Errors
/// A table without such columns.
pub fn curve(bytes: &[u8], height_mm: f64) -> Result<Vec<[f64; 2]>, String> {
    parse(&sieve_table::decode(bytes)?, height_mm)
}

fn parse(text: &str, height_mm: f64) -> Result<Vec<[f64; 2]>, String> {
    let table = Columns::parse(text)?;
    let (strain, stress, scale) = if table.names.is_empty() { (0, 1, 1.0) } else { named(&table, height_mm)? };
    let row = |(line, cells): &(usize, Vec<Option<f64>>)| {
        let cell = |column: usize| cells.get(column).copied().flatten();
        let pair = cell(strain).zip(cell(stress)).ok_or_else(|| format!("line {line} has no number there"));
        pair.map(|(strain, stress)| [scale * strain, stress])
    };
    let mut curve: Vec<[f64; 2]> = table.rows.iter().map(row).collect::<Result<_, _>>()?;
    if curve.iter().map(|point| point[1]).sum::<f64>() < 0.0 {
        curve.iter_mut().flatten().for_each(|value| *value = -*value);
    }
    Ok(curve)
}

/// Columns of strain and stress, and strain per unit of the first.
fn named(table: &Columns, height_mm: f64) -> Result<(usize, usize, f64), String> {
    let lacks = |columns: &str| format!("it has no column {columns}; it has {}", table.names.join(", "));
    let stress = table.place("stress_mpa")?.ok_or_else(|| lacks("stress_mpa"))?;
    match (table.place("strain")?, table.place("displacement_mm")?) {
        (Some(strain), _) => Ok((strain, stress, 1.0)),
        (None, Some(way)) => Ok((way, stress, 1.0 / height_mm)),
        (None, None) => Err(lacks("strain and none displacement_mm")),
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
        assert_eq!(
            parse("strain,force\n0,0\n", 1.0),
            Err("it has no column stress_mpa; it has strain, force".to_owned())
        );
        assert_eq!(
            parse("e,stress_mpa\n0,0\n", 1.0),
            Err("it has no column strain and none displacement_mm; it has e, stress_mpa".to_owned())
        );
        assert_eq!(parse("", 1.0), Ok(Vec::new()));
    }
}
