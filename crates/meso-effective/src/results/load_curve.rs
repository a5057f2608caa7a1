//! Properties over the load: one row for each frame of a test, as a table and as plots.

use super::{Found, figure};
use crate::effective::At;
use meso_view::plot::{Plot, Series};
use std::io::{self, Write};

/// Name of the table.
pub const CURVE: &str = "effective.csv";

/// A quantity with its values and errors along x, y, z.
struct LoadQuantity {
    name: &'static str,
    unit: &'static str,
    values: [Option<f64>; 3],
    errors: [Option<f64>; 3],
}

/// All quantities of a frame.
struct Row {
    at: At,
    quantities: Vec<LoadQuantity>,
}

/// Name of the moduli.
const MODULUS: &str = "modulus_mpa";
const AXES: [&str; 3] = ["x", "y", "z"];

fn at(found: &Found) -> At {
    match found {
        Found::Flux(of) => of.at,
        Found::Unloading(of) => of.at,
        Found::Stiffness(_) => At::default(),
    }
}

fn quantity(found: &Found) -> Option<LoadQuantity> {
    match found {
        Found::Flux(of) => {
            let diagonal = |tensor: &[[Option<f64>; 3]; 3]| [0, 1, 2].map(|axis| tensor[axis][axis]);
            let (name, values, errors) = (of.what.name(), diagonal(&of.tensor), diagonal(&of.error));
            Some(LoadQuantity { name, unit: of.what.unit(), values, errors })
        }
        Found::Unloading(of) => {
            let (values, errors) = (of.youngs_modulus_mpa, of.error);
            Some(LoadQuantity { name: MODULUS, unit: ", MPa", values, errors })
        }
        Found::Stiffness(_) => None,
    }
}

/// One row for each frame.
fn rows(found: &[(Found, f64)]) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for (of, _) in found {
        let (at, quantities) = (at(of), quantity(of));
        match rows.last_mut().filter(|row| row.at == at) {
            Some(row) => row.quantities.extend(quantities),
            None => rows.push(Row { at, quantities: quantities.into_iter().collect() }),
        }
    }
    rows
}

/// Writes a line for each frame: its number, strain and stress, then every quantity along each axis with its error.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_curve(found: &[(Found, f64)], out: &mut dyn Write) -> io::Result<()> {
    let rows = rows(found);
    let Some(first) = rows.first() else { return Ok(()) };
    write!(out, "frame,strain,stress_mpa")?;
    for (of, axis) in asked(first) {
        write!(out, ",{0}_{1},{0}_{1}_error", of.name, AXES[axis])?;
    }
    writeln!(out)?;
    for row in &rows {
        let At { frame, strain, stress_mpa } = row.at;
        write!(out, "{},{:?},{:?}", frame.unwrap_or(0), strain.unwrap_or(0.0), stress_mpa.unwrap_or(0.0) + 0.0)?;
        for (of, axis) in asked(row) {
            write!(out, ",{:?},{:?}", of.values[axis].unwrap_or(f64::NAN), of.errors[axis].unwrap_or(f64::NAN))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The quantities of a row, with the axes that were asked for.
fn asked(row: &Row) -> impl Iterator<Item = (&LoadQuantity, usize)> {
    row.quantities.iter().flat_map(|of| (0..3).filter(|axis| of.values[*axis].is_some()).map(move |axis| (of, axis)))
}

const STYLE: &str =
    "<style>svg{font:11px system-ui,sans-serif;margin:.5rem}.f{fill:none;stroke:#888}.g{stroke:#ddd}</style>";

/// Writes stress and every quantity over the strain, and the table.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write_plots(found: &[(Found, f64)], mut out: &mut dyn Write) -> io::Result<()> {
    let rows = rows(found);
    let Some(first) = rows.first() else { return Ok(()) };
    writeln!(out, "{STYLE}")?;
    let over = |of: &dyn Fn(&Row) -> Option<f64>| -> Vec<(f64, f64)> {
        rows.iter().filter_map(|row| Some((1000.0 * row.at.strain?, of(row)?))).collect()
    };
    let x = "strain, per mille";
    let plot = |title: &str, y: &str, curves, out: &mut &mut dyn Write| {
        Plot { title, x, y, log_x: false, curves, size: Plot::SMALL }.write(out)
    };
    plot("Stress", "MPa", vec![Series::line("stress", over(&|row| row.at.stress_mpa))], &mut out)?;
    for (number, of) in first.quantities.iter().enumerate() {
        // A crack's permeability grows by powers of ten.
        let is_log = of.name == "permeability";
        let shown = |value: f64, sound: f64| if is_log { libm::log10(value / sound) } else { value };
        let at = |row: &Row, axis: usize| {
            let value = shown(row.quantities.get(number)?.values[axis]?, of.values[axis]?);
            value.is_finite().then_some(value)
        };
        let curve = |axis: usize| over(&|row| at(row, axis));
        let curves = (0..3).filter(|axis| of.values[*axis].is_some());
        let curves = curves.map(|axis| Series::line(AXES[axis], curve(axis))).collect();
        let name = of.name.trim_end_matches("_mpa");
        let title =
            if is_log { format!("log10 of {name} over that of the first frame") } else { format!("{name}{}", of.unit) };
        plot(&title, "", curves, &mut out)?;
    }
    write!(out, "<table><tr><th>frame</th><th>strain</th><th>stress, MPa</th>")?;
    asked(first)
        .try_for_each(|(of, axis)| write!(out, "<th>{} {}</th>", of.name.trim_end_matches("_mpa"), AXES[axis]))?;
    writeln!(out, "</tr>")?;
    for row in &rows {
        let At { frame, strain, stress_mpa } = row.at;
        let (frame, strain, stress) = (frame.unwrap_or(0), strain.unwrap_or(0.0), stress_mpa.unwrap_or(0.0));
        write!(out, "<tr><td>{frame}</td><td>{strain:.5}</td><td>{stress:.2}</td>")?;
        for (of, axis) in asked(row) {
            let value = of.values[axis].unwrap_or(0.0);
            let text = if of.name == MODULUS { format!("{value:.0}") } else { figure(value) };
            write!(out, "<td>{text}</td>")?;
        }
        writeln!(out, "</tr>")?;
    }
    writeln!(out, "</table>")
}
