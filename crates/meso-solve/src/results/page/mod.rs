//! One self-contained page about a test: the curve beside the cracks to turn, with a slider over its moments; sections of damage,
//! figures, energies and gauges.

use super::section::RAMP;
use super::shots::{Body, Shot};
use super::snapshot::Moment;
use super::{Outcome, ResultFile};
use crate::march::{Ended, Row, Summary};
use meso_collision::math::Aabb;
use meso_concrete::thousands;
use meso_element::law;
use meso_mesh::Mesh;
use meso_mesh::materials::Scatter;
use meso_trial::{Gauge, OF_SUPPORTS, TestKind, word};
use meso_view::embedded::{TURNTABLE, base64};
use meso_view::plot::{Plot, Series, escape};
use meso_view::section::ACROSS;
use std::io::{self, BufWriter, Write};

const STYLE: &str = include_str!("style.css");
const VIEWER: &str = include_str!("viewer.js");
/// Width and height of the stress-strain curve, pixels.
const LARGE: [f64; 2] = [560.0, 400.0];
/// Width and height of a plot of energies, pixels.
const MEDIUM: [f64; 2] = [560.0, 320.0];
/// The largest displacement is drawn as this share of the specimen's longest side, at first.
const DRAWN: f64 = 0.12;

/// Writes the page.
///
/// # Errors
/// Fails with the errors of `out`.
pub(super) fn write(outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    head(outcome, &mut out)?;
    remarks(&outcome.response.result, &mut out)?;
    let body = outcome.last.map(|_| Body::of(outcome.mesh));
    let end = outcome.last.zip(body.as_ref()).map(|(last, body)| Shot::of(outcome.mesh, body, last)).transpose()?;
    let shots: Vec<(&str, &Shot)> = outcome.taken.shots().chain(end.as_ref().map(|end| ("end", end))).collect();
    writeln!(out, "<div class=\"split\">\n<section>")?;
    curve(outcome, &shots, &mut out)?;
    writeln!(out, "</section>")?;
    if let Some(body) = &body {
        writeln!(out, "<section>")?;
        view(outcome.mesh, &shots, &mut out)?;
        writeln!(out, "</section>")?;
        writeln!(out, "</div>")?;
        controls(outcome.mesh, &shots, &mut out)?;
        sections(outcome, &shots, &mut out)?;
        data(outcome, body, &shots, &mut out)?;
    } else {
        writeln!(out, "</div>")?;
    }
    figures(outcome, &mut out)?;
    energies(outcome, &mut out)?;
    gauges(outcome, &mut out)?;
    out.write_all(b"</main>\n</html>\n")?;
    out.flush()
}

fn head(outcome: &Outcome, out: &mut impl Write) -> io::Result<()> {
    let result = &outcome.response.result;
    let test = word(&result.test);
    let test = test[..1].to_ascii_uppercase() + &test[1..];
    let flags: String = result.flags.iter().map(|flag| format!(", {flag}")).collect();
    let headline = result.headline();
    let title = format!("{test} test: {}{flags}", headline.trim_start_matches("peak "));
    write!(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n")?;
    writeln!(out, "<meta name=\"viewport\" content=\"width=device-width\">\n<style>\n{STYLE}")?;
    let stops: Vec<String> = RAMP.iter().map(|[r, g, b]| format!("rgb({r},{g},{b})")).collect();
    writeln!(
        out,
        ".ramp{{background:linear-gradient(90deg,{})}}\n</style>\n<main>\n<h1>{title}</h1>",
        stops.join(",")
    )?;
    let source = outcome.source;
    let (version, seed, fraction) = (&source.version, source.seed, source.fraction);
    let (mesh, size) = (word(&source.mesh.method.name()), source.mesh.element_size_mm);
    let elements = thousands(result.elements);
    writeln!(
        out,
        "<p class=\"note\">mesocrete {version}; packing of seed {seed}, fraction {fraction:.4}; {elements} elements ({mesh}, \
         {size} mm)</p>"
    )
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

/// The axes of a test's plots.
struct PlotAxes {
    /// Label of the x axis, and its value in a row.
    x: &'static str,
    of: fn(&Row) -> f64,
    /// Label of the stress.
    y: &'static str,
}

impl PlotAxes {
    fn of(result: &Summary) -> Self {
        if result.is_free() {
            return Self { x: "time, ms", of: |row| 1e3 * row.time_s, y: "strain, µm/m" };
        }
        if has_no_strain(result) {
            return Self::in_time();
        }
        let (x, y) = match result.test {
            TestKind::Bending => ("strain 6 h w / l² of the roller's way", "stress 3 F l / (2 b h²), MPa"),
            TestKind::FourPoint => ("strain 27 h w / (5 l²) of the rollers' way", "stress F l / (b h²), MPa"),
            TestKind::Splitting => ("way over diameter", "stress 2 F / (π l d), MPa"),
            TestKind::Shear => ("way over height", "stress between the notches, MPa"),
            _ => ("mean axial strain", "stress, MPa"),
        };
        Self { x, of: |row| row.strain, y }
    }

    /// Of a test in real time.
    fn in_time() -> Self {
        Self { x: "time, µs", of: |row| 1e6 * row.time_s, y: "stress, MPa" }
    }

    /// A column over the x axis.
    fn points(&self, rows: &[Row], values: &[f64]) -> Vec<(f64, f64)> {
        rows.iter().map(self.of).zip(values.iter().copied()).collect()
    }
}

/// Whether a plate moves alone, so that its curve is over the time.
fn has_no_strain(result: &Summary) -> bool {
    matches!(result.test, TestKind::Spall | TestKind::Drop)
}

/// A moment in words.
fn words(result: &Summary, when: &str, moment: &Moment) -> String {
    if result.is_free() {
        return when.to_owned();
    }
    format!("{when}, strain {:.5}, {:.2} MPa", moment.strain, moment.stress_mpa)
}

/// Stress over strain, or the mean strains of an expansion over time.
fn curve(outcome: &Outcome, shots: &[(&str, &Shot)], out: &mut impl Write) -> io::Result<()> {
    let (rows, result) = (&outcome.response.curve, &outcome.response.result);
    let (axes, figures) = (PlotAxes::of(result), &result.figures);
    let columns = further(outcome)?;
    let (heading, title, curves) = if result.is_free() {
        let strains = columns.iter().filter(|(name, _)| result.strains_at_end.contains_key(name));
        let micro = |values: &[f64]| values.iter().map(|strain| 1e6 * strain).collect::<Vec<_>>();
        let lines = strains.map(|(name, values)| Series::line(name, axes.points(rows, &micro(values))));
        ("Strains", "Mean strains over time", lines.take(3).collect())
    } else {
        let start = std::iter::once((0.0, 0.0));
        let place = |strain, time_s| (axes.of)(&Row { strain, time_s, ..Row::default() });
        let top = rows.iter().find(|row| row.stress_mpa == figures.peak_mpa).copied().unwrap_or_default();
        let peak = vec![((axes.of)(&top), figures.peak_mpa)];
        let moments =
            shots.iter().map(|(_, Shot { moment, .. })| (place(moment.strain, moment.time_s), moment.stress_mpa));
        let moments = moments.collect();
        let curves = vec![
            Series::line("stress", start.chain(rows.iter().map(|row| ((axes.of)(row), row.stress_mpa))).collect()),
            Series::dots("peak", if figures.peak_mpa > 0.0 { peak } else { Vec::new() }),
            Series::moving("moment below", moments),
        ];
        let is_timed = has_no_strain(result);
        let heading = if is_timed { "Stress" } else { "Stress and strain" };
        (heading, if is_timed { "Stress over time" } else { "Stress over strain" }, curves)
    };
    writeln!(out, "<h2>{heading}</h2>\n<div class=\"large\">")?;
    Plot { title, x: axes.x, y: axes.y, log_x: false, size: LARGE, curves }.write(out)?;
    writeln!(out, "</div>")
}

/// The canvas of body and cracks.
fn view(mesh: &Mesh, shots: &[(&str, &Shot)], out: &mut impl Write) -> io::Result<()> {
    let size = Aabb::around(&mesh.points).size();
    let [x, y, z]: [f64; 3] = (size / size.max()).into();
    writeln!(
        out,
        "<h2>Cracks and deformation</h2>\n<canvas id=\"cracks\" tabindex=\"0\" role=\"img\" \
         aria-label=\"The deformed body and its cracks in 3D\" data-size=\"{x} {y} {z}\" data-longest=\"{}\"></canvas>",
        size.max()
    )?;
    for (number, (_, shot)) in shots.iter().enumerate() {
        let text = match &shot.cracks {
            Some(cracks) => {
                let [level, widest] = cracks.openings_mm;
                format!("Surfaces where the cracks are {level:.3} mm open; the widest cell is {widest:.3} mm open.")
            }
            None => "No crack is wider than 0.002 mm.".to_owned(),
        };
        writeln!(
            out,
            "<p class=\"note\" data-moment=\"{number}\">{text} The darker, the wider. Drag to turn; click, then wheel or + and - to zoom.</p>"
        )?;
    }
    Ok(())
}

/// The slider over the moments, the factor of the deformation, and the body's switch.
fn controls(mesh: &Mesh, shots: &[(&str, &Shot)], out: &mut impl Write) -> io::Result<()> {
    let last = shots.len().saturating_sub(1);
    let most = shots.iter().map(|(_, shot)| shot.most_mm).fold(0.0, f32::max);
    let drawn = DRAWN * Aabb::around(&mesh.points).size().max() / f64::from(most);
    let factor = rounded(drawn);
    writeln!(
        out,
        "<div class=\"controls\">\n<label for=\"moment\">Moment</label><input id=\"moment\" type=\"range\" min=\"0\" max=\"{last}\" \
         step=\"1\" value=\"{last}\"><output id=\"told\" for=\"moment\"></output>"
    )?;
    writeln!(
        out,
        "<label for=\"factor\">Deformation</label><input id=\"factor\" type=\"range\" min=\"0\" max=\"{}\" step=\"any\" \
         value=\"{factor}\"><output id=\"times\" for=\"factor\"></output>\n<label class=\"check\"><input id=\"shell\" type=\"checkbox\" \
         checked> body</label>\n</div>",
        4.0 * factor
    )
}

/// One digit.
fn rounded(factor: f64) -> f64 {
    let unit = libm::pow(10.0, libm::floor(libm::log10(factor.clamp(1.0, 1e6))));
    (factor / unit).round().max(1.0) * unit
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
    let test = if result.is_free() {
        ("test, law", format!("{}, {}", word(&result.test), word(&result.law)))
    } else {
        ("test, friction, law", format!("{}, {}, {}", word(&result.test), result.friction, word(&result.law)))
    };
    let strains = result.strains_at_end.iter().map(|(name, strain)| (name.as_str(), format!("{strain:.4e}")));
    let modulus = if result.has_modulus() { "modulus" } else { "stress over strain" };
    let modulus = format!("{modulus}, secant to 30 % of the peak");
    let of_strength = [
        (modulus.as_str(), format!("{:.0} MPa", figures.modulus_mpa)),
        ("peak", format!("{:.2} MPa", figures.peak_mpa)),
        ("first peak, beyond which it falls by 0.5 %", format!("{:.2} MPa", figures.first_peak_mpa)),
        ("strain at the peak", format!("{:.5}", figures.peak_strain)),
        ("stress at the end", format!("{:.2} MPa", figures.stress_at_end_mpa)),
        ("fell below 0.8 of the peak", softened.to_owned()),
        ("displacement from the peak to half of it", to_half),
        ("energy beyond the peak, per area", energy),
    ];
    let rate = result.rate_at_peak_per_s.map(|rate| {
        let [compressed, pulled] = law::strengths_over_rest(rate.abs());
        let grown = format!(", where mortar has {compressed:.3} and {pulled:.3} times its f_c and f_t at rest");
        let grown = if result.setup.rate_effect == Some(true) { grown } else { String::new() };
        ("rate of strain at the peak", format!("{rate:.3e} /s{grown}"))
    });
    // Waves run in a test in real time, so its secant is none.
    let of_strength = of_strength.into_iter().skip(usize::from(result.is_fast())).filter(|_| !result.is_free());
    let of_run = [
        ("steps, time step", format!("{}, {:.3e} s", thousands(result.steps as usize), result.time_step_s)),
        ("mass added", format!("{:.1} %", result.added_mass_percent)),
        ("kinetic over internal energy after the ramp, at most", percent(result.kinetic_over_internal_max)),
        ("the same until the stress had fallen to half its peak", percent(result.kinetic_over_internal_to_half_peak)),
        ("hourglass over internal energy, at most", percent(result.hourglass_over_internal)),
        ("error of the energy balance over the work, at most", format!("{:.4} %", 100.0 * result.energy_balance_error)),
        ("pairs of aggregates joined by the mesh", thousands(result.joined_pairs)),
        ("scatter", result.scatter.as_ref().map_or_else(|| "none".to_owned(), Scatter::words)),
    ];
    let lateral = [
        ("Poisson's ratio to 30 % of the peak", result.lateral.poisson_ratio.map(|x| format!("{x:.3}"))),
        ("lateral strain at the peak", result.lateral.lateral_strain_at_peak.map(|x| format!("{x:.5}"))),
        ("stress of least volume over the peak", result.lateral.least_volume_over_peak.map(|x| format!("{x:.3}"))),
    ];
    let lateral = lateral.into_iter().filter_map(|(name, value)| Some((name, value?)));
    let stone = result.broken_stone.map(|share| ("aggregates that broke, by volume", percent(share)));
    writeln!(out, "<h2>Figures</h2>\n<div class=\"split\">\n<div class=\"wide\"><table>")?;
    std::iter::once(test)
        .chain(result.setup.words())
        .chain([("strain smoothing", word(&result.smoothing))])
        .chain(strains)
        .chain(of_strength)
        .chain(rate)
        .chain(of_run)
        .chain(lateral)
        .chain(stone)
        .try_for_each(|(name, value)| writeln!(out, "<tr><td>{name}<td>{value}"))?;
    writeln!(
        out,
        "</table></div>\n<div class=\"wide\"><table><tr><th>phase<th>of specimen<th>exact<th>dissipated, mJ"
    )?;
    // A phase that neither the mesh nor the packing has is no news.
    for phase in result.phases.iter().filter(|phase| {
        phase.volume_fraction > 0.0
            || phase.dissipated_mj > 0.0
            || phase.exact_fraction.is_some_and(|exact| exact > 0.0)
    }) {
        let is_smeared = phase.volume_fraction > 0.0 && phase.exact_fraction == Some(0.0);
        let exact = phase.exact_fraction.filter(|_| !is_smeared);
        let exact = exact.map_or("-".to_owned(), |fraction| format!("{fraction:.5}"));
        writeln!(
            out,
            "<tr><td>{}<td>{:.5}<td>{exact}<td>{:.1}",
            escape(&phase.name),
            phase.volume_fraction,
            phase.dissipated_mj
        )?;
    }
    writeln!(out, "</table></div>\n</div>")
}

fn energies(outcome: &Outcome, out: &mut impl Write) -> io::Result<()> {
    let (rows, axes) = (&outcome.response.curve, PlotAxes::of(&outcome.response.result));
    let over_strain = |of: fn(&Row) -> f64| rows.iter().map(|row| ((axes.of)(row), of(row))).collect::<Vec<_>>();
    let plot = |title, y, curves| Plot { title, x: axes.x, y, log_x: false, size: MEDIUM, curves };
    // Where there is hardly any internal energy yet, its shares say nothing.
    let most = rows.iter().map(|row| row.internal).fold(0.0, f64::max);
    let loaded = || rows.iter().filter(|row| row.internal > 0.01 * most);
    let work = vec![
        Series::line("plates' work", over_strain(|row| row.external / 1000.0)),
        Series::line("dissipated", over_strain(|row| row.dissipated / 1000.0)),
        Series::line("plate friction", over_strain(|row| row.friction_work / 1000.0)),
    ];
    let shares = |of: fn(&Row) -> f64| loaded().map(|row| ((axes.of)(row), 100.0 * of(row) / row.internal)).collect();
    let small = vec![
        Series::line("kinetic", shares(|row| row.kinetic)),
        Series::line("hourglass", shares(|row| row.hourglass)),
    ];
    let plots = [plot("Work and its parts", "J", work), plot("Shares of the internal energy", "%", small)];
    group("Energies", "split large", &plots, out)
}

/// Plots that show something under a heading, if there are any.
fn group(heading: &str, class: &str, plots: &[Plot], out: &mut impl Write) -> io::Result<()> {
    let mut plots = plots.iter().filter(|plot| !plot.is_empty()).peekable();
    if plots.peek().is_none() {
        return Ok(());
    }
    writeln!(out, "<h2>{heading}</h2>\n<div class=\"{class}\">")?;
    plots.try_for_each(|plot| plot.write(out))?;
    writeln!(out, "</div>")
}

/// Names of the curve's columns after those of every test, with their values row by row.
fn further(outcome: &Outcome) -> io::Result<Vec<(String, Vec<f64>)>> {
    let mut text = Vec::new();
    ResultFile::Curve.write(outcome, &mut text)?;
    let text = String::from_utf8_lossy(&text);
    let mut lines = text.lines().map(|line| line.split(',').skip(Row::COLUMNS.len()));
    let names = lines.next().into_iter().flatten();
    let mut columns: Vec<(String, Vec<f64>)> = names.map(|name| (name.to_owned(), Vec::new())).collect();
    for line in lines {
        columns.iter_mut().zip(line).for_each(|((_, values), text)| values.push(text.parse().unwrap_or(f64::NAN)));
    }
    Ok(columns)
}

/// Gauges and forces of supports, one plot each, and the load over the crack mouth. Columns of zeros have none.
fn gauges(outcome: &Outcome, out: &mut impl Write) -> io::Result<()> {
    let (columns, result) = (further(outcome)?, &outcome.response.result);
    let axes = if result.is_fast() { PlotAxes::in_time() } else { PlotAxes::of(result) };
    let plot = |title, x, y, points| {
        let curves = vec![Series::line(title, points)];
        Plot { title, x, y, log_x: false, size: Plot::SMALL, curves }
    };
    let rows = &outcome.response.curve;
    let over_mouth = load_over_mouth(result, &columns);
    let over_mouth =
        over_mouth.map(|points| plot("load over crack mouth", "opening of the crack mouth, mm", "N", points));
    let single = columns.iter().map(|(name, values)| plot(name, axes.x, "", axes.points(rows, values)));
    let waves = columns.iter().filter(|(name, _)| OF_SUPPORTS[2..].iter().any(|end| name.ends_with(end)));
    let waves: Vec<Series> = waves.map(|(name, values)| Series::line(name, axes.points(rows, values))).collect();
    let title = "Waves in the bars, positive in compression";
    let waves = (!waves.is_empty()).then_some(Plot {
        title,
        x: axes.x,
        y: axes.y,
        log_x: false,
        size: Plot::SMALL,
        curves: waves,
    });
    let plots: Vec<Plot> = over_mouth.into_iter().chain(waves).chain(single).collect();
    group("Gauges and supports", "grid", &plots, out)
}

/// Force of the support that moves, over the opening of the crack mouth, if a gauge measures it.
fn load_over_mouth(result: &Summary, columns: &[(String, Vec<f64>)]) -> Option<Vec<(f64, f64)>> {
    let named = |wanted: &str| columns.iter().find(|(name, _)| name == wanted).map(|(_, values)| values);
    let mouth = result.setup.gauges.iter().find(|gauge| matches!(gauge, Gauge::CrackMouth { .. }))?;
    let moving = result.setup.supports.iter().find(|support| support.moves != 0.0)?;
    let (opening, force) = (named(mouth.name())?, named(&format!("{}_n", moving.name))?);
    Some(opening.iter().copied().zip(force.iter().copied()).collect())
}

/// Damage in the planes through the middle, at every moment; a script shows one of them.
fn sections(outcome: &Outcome, shots: &[(&str, &Shot)], out: &mut impl Write) -> io::Result<()> {
    let (aabb, result) = (Aabb::around(&outcome.mesh.points), &outcome.response.result);
    let middle = (aabb.min + aabb.max) / 2.0;
    let names = ["x", "y", "z"];
    for (number, (when, shot)) in shots.iter().enumerate() {
        let moment = words(result, when, &shot.moment);
        writeln!(out, "<section data-moment=\"{number}\">\n<h2>Damage: {moment}</h2>\n<div class=\"row\">")?;
        for (axis, (data, [width, height])) in shot.sections.iter().enumerate() {
            let (u, v) = ACROSS[axis];
            let caption =
                format!("{} = {} mm; {} to the right, {} upwards", names[axis], middle[axis], names[u], names[v]);
            let (width, height, ratio) = (width / 2, height / 2, *width as f64 / *height as f64);
            writeln!(
                out,
                "<figure style=\"--ratio:{ratio:.4}\"><img width=\"{width}\" height=\"{height}\" alt=\"Damage, {caption}\" \
                 src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>"
            )?;
        }
        writeln!(out, "</div>\n</section>")?;
    }
    writeln!(
        out,
        "<p class=\"note\">Damage 0 <span class=\"ramp\"></span> 1: the share of its stiffness that mortar or ITZ has \
         lost. Grey are aggregates that are not broken. {}</p>",
        result.test.description()
    )
}

/// Surfaces, displacements and moments, for the script, and the script itself.
fn data(outcome: &Outcome, body: &Body, shots: &[(&str, &Shot)], out: &mut impl Write) -> io::Result<()> {
    let mut put = |name: &str, text: &str| writeln!(out, "<script type=\"text/plain\" id=\"{name}\">{text}</script>");
    let corners: Vec<u8> = body.corners.as_flattened().iter().flat_map(|place| place.to_le_bytes()).collect();
    let triangles: Vec<u8> = body.triangles.as_flattened().iter().flat_map(|corner| corner.to_le_bytes()).collect();
    put("body-corners", &base64(&corners))?;
    put("body-triangles", &base64(&triangles))?;
    for (number, (_, shot)) in shots.iter().enumerate() {
        put(&format!("body-moved-{number}"), &shot.moved)?;
        if let Some(cracks) = &shot.cracks {
            put(&format!("corners-{number}"), &cracks.corners)?;
            put(&format!("openings-{number}"), &cracks.openings)?;
            put(&format!("moved-{number}"), &cracks.moved)?;
            put(&format!("triangles-{number}"), &cracks.triangles)?;
        }
    }
    let moments: Vec<_> = shots
        .iter()
        .map(|(when, shot)| {
            let told = words(&outcome.response.result, when, &shot.moment).replacen(", ", ": ", 1);
            let triangles = shot.cracks.as_ref().map_or(0, |cracks| cracks.count);
            serde_json::json!({ "told": told, "most_mm": shot.most_mm, "triangles": triangles })
        })
        .collect();
    writeln!(out, "<script type=\"text/plain\" id=\"moments\">{}</script>", serde_json::Value::from(moments))?;
    writeln!(out, "<script>\n{TURNTABLE}{VIEWER}</script>")
}
