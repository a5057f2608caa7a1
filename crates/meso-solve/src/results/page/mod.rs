//! One self-contained page about a test: the curve, its figures, energies, damage in three sections, and the cracks to turn.

use super::cracks::Cracks;
use super::section::{ACROSS, RAMP, picture};
use super::{Outcome, Snapshot};
use crate::march::Row;
use crate::march::{Ended, Summary};
use crate::test::TestKind;
use meso_collision::math::Aabb;
use meso_concrete::thousands;
use meso_mesh::Mesh;
use meso_view::embedded::{TURNTABLE, base64};
use meso_view::plot::{Plot, Series, escape};
use std::io::{self, BufWriter, Write};

const STYLE: &str = include_str!("style.css");
const VIEWER: &str = include_str!("viewer.js");
/// Width and height of the stress-strain curve, pixels.
const LARGE: [f64; 2] = [560.0, 340.0];

/// Writes the page.
///
/// # Errors
/// Fails with the errors of `out`.
pub(super) fn write(outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    head(outcome, &mut out)?;
    remarks(&outcome.response.result, &mut out)?;
    curve(outcome, &mut out)?;
    figures(outcome, &mut out)?;
    energies(&outcome.response.curve, &mut out)?;
    if let Some(last) = outcome.last {
        sections(outcome.mesh, last, &mut out)?;
        cracks(outcome.mesh, last, &mut out)?;
    }
    out.write_all(b"</main>\n</html>\n")?;
    out.flush()
}

fn head(outcome: &Outcome, out: &mut impl Write) -> io::Result<()> {
    let result = &outcome.response.result;
    let test = if result.test == TestKind::Compression { "Compression" } else { "Tension" };
    let flags: String = result.flags.iter().map(|flag| format!(", {flag}")).collect();
    let (peak, strain) = (result.figures.peak_mpa, result.figures.peak_strain);
    let title = format!("{test} test: {peak:.2} MPa at a strain of {strain:.5}{flags}");
    write!(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n")?;
    writeln!(out, "<meta name=\"viewport\" content=\"width=device-width\">\n<style>\n{STYLE}")?;
    let stops: Vec<String> = RAMP.iter().map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
    writeln!(
        out,
        ".ramp{{background:linear-gradient(90deg,{})}}\n</style>\n<main>\n<h1>{title}</h1>",
        stops.join(",")
    )?;
    let source = outcome.source;
    let (version, seed, fraction) = (source.version, source.seed, source.fraction);
    let (mesh, size) = (word(&source.mesh.method.name()), source.mesh.element_size_mm);
    let elements = thousands(result.elements);
    writeln!(
        out,
        "<p class=\"note\">mesocrete {version}; packing of seed {seed}, fraction {fraction:.4}; {elements} elements ({mesh}, \
         {size} mm)</p>"
    )
}

/// The word that a spec or a flag has for a value.
fn word(value: &impl serde::Serialize) -> String {
    serde_json::to_value(value).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// How the test ended, unless it was completed, and its errors and warnings.
fn remarks(result: &Summary, out: &mut impl Write) -> io::Result<()> {
    let stopped = (result.ended == Ended::Stopped).then(|| {
        format!(
            "The test was stopped after {} steps ({} are the whole test at full speed); the curve is valid until there.",
            thousands(result.steps as usize),
            thousands(result.steps_planned as usize)
        )
    });
    let errors = stopped.iter().chain(&result.errors).map(|text| ("error", text));
    for (class, text) in errors.chain(result.warnings.iter().map(|text| ("warning", text))) {
        writeln!(out, "<p class=\"{class}\">{}</p>", escape(text))?;
    }
    Ok(())
}

fn curve(outcome: &Outcome, out: &mut impl Write) -> io::Result<()> {
    let (rows, figures) = (&outcome.response.curve, &outcome.response.result.figures);
    let start = std::iter::once((0.0, 0.0));
    let peak = vec![(figures.peak_strain, figures.peak_mpa)];
    writeln!(out, "<h2>Stress and strain</h2>")?;
    let plot = Plot {
        title: "Stress over strain",
        x: "mean axial strain",
        y: "stress, MPa",
        log_x: false,
        size: LARGE,
        curves: vec![
            Series::line("stress", start.chain(rows.iter().map(|row| (row.strain, row.stress_mpa))).collect()),
            Series::dots("peak", if figures.peak_mpa > 0.0 { peak } else { Vec::new() }),
        ],
    };
    plot.write(out)
}

fn figures(outcome: &Outcome, out: &mut impl Write) -> io::Result<()> {
    let result = &outcome.response.result;
    let figures = &result.figures;
    let percent = |share: f64| format!("{:.2} %", 100.0 * share);
    let softened = if figures.softened { "yes" } else { "no" };
    let beyond = &result.beyond_peak;
    let to_half = beyond.displacement_to_half_mm.map_or("not reached".to_owned(), |mm| format!("{mm:.4} mm"));
    let left = 100.0 * beyond.energy_beyond_peak_until;
    let energy = format!("{:.3} N/mm, until {left:.0} % are left", beyond.energy_beyond_peak_n_per_mm);
    let rows = [
        ("test, friction, law", format!("{}, {}, {}", word(&result.test), result.friction, word(&result.law))),
        ("strain smoothing", word(&result.smoothing)),
        ("modulus, secant to 30 % of the peak", format!("{:.0} MPa", figures.modulus_mpa)),
        ("peak", format!("{:.2} MPa", figures.peak_mpa)),
        ("strain at the peak", format!("{:.5}", figures.peak_strain)),
        ("stress at the end", format!("{:.2} MPa", figures.stress_at_end_mpa)),
        ("fell below 0.8 of the peak", softened.to_owned()),
        ("displacement from the peak to half of it", to_half),
        ("energy beyond the peak, per area", energy),
        ("steps, time step", format!("{}, {:.3e} s", thousands(result.steps as usize), result.time_step_s)),
        ("mass added", format!("{:.1} %", result.added_mass_percent)),
        ("kinetic over internal energy after the ramp, at most", percent(result.kinetic_over_internal_max)),
        ("the same until the stress had fallen to half its peak", percent(result.kinetic_over_internal_to_half_peak)),
        ("hourglass over internal energy, at most", percent(result.hourglass_over_internal)),
        ("error of the energy balance over the work, at most", format!("{:.4} %", 100.0 * result.energy_balance_error)),
        ("pairs of aggregates joined by the mesh", thousands(result.joined_pairs)),
    ];
    let stone = result.broken_stone.map(|share| ("aggregates that broke, by volume", percent(share)));
    writeln!(out, "<h2>Figures</h2>\n<div class=\"wide\"><table>")?;
    rows.iter().chain(&stone).try_for_each(|(name, value)| writeln!(out, "<tr><td>{name}<td>{value}"))?;
    writeln!(
        out,
        "</table></div>\n<div class=\"wide\"><table><tr><th>phase<th>of specimen<th>exact<th>dissipated, mJ"
    )?;
    for phase in &result.phases {
        let exact = phase.exact_fraction.map_or("-".to_owned(), |fraction| format!("{fraction:.5}"));
        writeln!(
            out,
            "<tr><td>{}<td>{:.5}<td>{exact}<td>{:.1}",
            escape(&phase.name),
            phase.volume_fraction,
            phase.dissipated_mj
        )?;
    }
    writeln!(out, "</table></div>")
}

fn energies(rows: &[Row], out: &mut impl Write) -> io::Result<()> {
    let over_strain = |of: fn(&Row) -> f64| rows.iter().map(|row| (row.strain, of(row))).collect::<Vec<_>>();
    let plot = |title, y, curves| Plot { title, x: "mean axial strain", y, log_x: false, size: Plot::SMALL, curves };
    // Where there is hardly any internal energy yet, its shares say nothing.
    let most = rows.iter().map(|row| row.internal).fold(0.0, f64::max);
    let loaded = || rows.iter().filter(|row| row.internal > 0.01 * most);
    writeln!(out, "<h2>Energies</h2>\n<div class=\"row\">")?;
    let work = vec![
        Series::line("plates' work", over_strain(|row| row.external / 1000.0)),
        Series::line("dissipated", over_strain(|row| row.dissipated / 1000.0)),
        Series::line("plate friction", over_strain(|row| row.friction_work / 1000.0)),
    ];
    plot("Work and its parts", "J", work).write(out)?;
    let shares = |of: fn(&Row) -> f64| loaded().map(|row| (row.strain, 100.0 * of(row) / row.internal)).collect();
    let small = vec![
        Series::line("kinetic", shares(|row| row.kinetic)),
        Series::line("hourglass", shares(|row| row.hourglass)),
    ];
    plot("Shares of the internal energy", "%", small).write(out)?;
    writeln!(out, "</div>")
}

/// Damage in the planes through the middle.
fn sections(mesh: &Mesh, last: &Snapshot, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<h2>Damage at a strain of {:.5}, {:.2} MPa</h2>", last.moment.strain, last.moment.stress_mpa)?;
    writeln!(out, "<div class=\"row\">")?;
    let aabb = Aabb::around(&mesh.points);
    let middle = (aabb.min + aabb.max) / 2.0;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let section = picture(mesh, last, axis, middle[axis]);
        let (u, v) = ACROSS[axis];
        let names = ["x", "y", "z"];
        let caption = format!("{name} = {} mm; {} to the right, {} upwards", middle[axis], names[u], names[v]);
        let data = base64(&section.png()?);
        let (width, height) = (section.width / 2, section.height / 2);
        writeln!(
            out,
            "<figure><img width=\"{width}\" height=\"{height}\" alt=\"Damage, {caption}\" \
             src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>"
        )?;
    }
    writeln!(
        out,
        "</div>\n<p class=\"note\">Damage 0 <span class=\"ramp\"></span> 1: the share of its stiffness that mortar or ITZ has \
         lost. Grey are aggregates, which stay elastic. The test presses or pulls along z.</p>"
    )
}

/// The cells with the widest cracks, to be turned.
fn cracks(mesh: &Mesh, last: &Snapshot, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<h2>Cracks</h2>")?;
    let Some(cracks) = Cracks::of(mesh, last) else {
        return writeln!(out, "<p class=\"note\">No crack is wider than 0.01 mm.</p>");
    };
    let [least, widest] = cracks.openings_mm;
    writeln!(
        out,
        "<p class=\"note\">The {} elements whose cracks are {least:.3} mm wide or wider; the darkest is the widest, {widest:.3} mm. Drag to turn, use the wheel or two fingers to zoom, or the arrow keys, + and -.</p>",
        cracks.cells
    )?;
    let size = Aabb::around(&mesh.points).size();
    let [x, y, z]: [f64; 3] = (size / size.max()).into();
    let text = "The cracks in 3D";
    writeln!(
        out,
        "<canvas id=\"cracks\" tabindex=\"0\" role=\"img\" aria-label=\"{text}\" data-size=\"{x} {y} {z}\"></canvas>"
    )?;
    let corners: Vec<u8> = cracks.corners.as_flattened().iter().flat_map(|place| place.to_le_bytes()).collect();
    let triangles: Vec<u8> = cracks.triangles.as_flattened().iter().flat_map(|corner| corner.to_le_bytes()).collect();
    for (name, bytes) in [("corners", &corners), ("openings", &cracks.openings), ("triangles", &triangles)] {
        writeln!(out, "<script type=\"text/plain\" id=\"{name}\">{}</script>", base64(bytes))?;
    }
    writeln!(out, "<script>\n{TURNTABLE}{VIEWER}</script>")
}
