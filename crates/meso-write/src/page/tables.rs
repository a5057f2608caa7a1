//! The page's tables.

use meso_concrete::specimen::Specimen;
use meso_concrete::thousands;
use meso_mesh::figures::PhaseVolumes;
use meso_pack::model::Model;
use meso_pack::packing::{ClassReport, StopReason};
use meso_pack::spec::Spec;
use meso_pack::statistics::{Distribution, Orientation, PhaseFigures, Sampled, Statistics};
use meso_view::plot::escape;
use std::io::{self, Write};

/// Target and result by class.
pub(super) fn outcome(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let report = &model.report;
    let is_reached = report.stop_reason == StopReason::TargetReached;
    let detail = report.shortfall().filter(|_| is_reached).unwrap_or_else(|| report.stop_detail.clone());
    writeln!(out, "<p>Target {}: {}.</p>", report.target_fraction, escape(&detail))?;
    let row = "<tr><th>class, mm<th>asked<th>reached<th>deviation<th>aggregates";
    writeln!(out, "<table>{row}")?;
    report.classes.iter().try_for_each(|own| class("", own, out))?;
    for phase in &report.phases {
        let (name, deviation) = (phase.phase.plural(), 100.0 * (phase.fraction / phase.target_fraction - 1.0));
        let (asked, reached, bodies) = (phase.target_fraction, phase.fraction, thousands(phase.bodies));
        writeln!(out, "<tr><td>{name}<td>{asked:.5}<td>{reached:.5}<td>{deviation:+.2} %<td>{bodies}")?;
        phase.classes.iter().try_for_each(|own| class(&format!("{name} of "), own, out))?;
    }
    for own in &report.own_phases {
        let (name, deviation) = (&own.phase, 100.0 * (own.fraction / own.target_fraction - 1.0));
        let (asked, reached, bodies) = (own.target_fraction, own.fraction, thousands(own.aggregates));
        writeln!(out, "<tr><td>of these {name}<td>{asked:.5}<td>{reached:.5}<td>{deviation:+.2} %<td>{bodies}")?;
    }
    for shell in &report.shells {
        let (name, reached, bodies) = (&shell.phase, shell.fraction, thousands(shell.aggregates));
        writeln!(out, "<tr><td>shells of {name}<td><td>{reached:.5}<td><td>{bodies}")?;
    }
    if let Some(reached) = report.coated_fraction {
        writeln!(out, "<tr><td>stones with coatings and ITZ<td><td>{reached:.5}<td><td>{}", report.aggregates)?;
    }
    writeln!(out, "</table>")?;
    writeln!(
        out,
        "<p class=\"note\">Fractions are exact volumes of the polyhedra, ITZ included, over the specimen ({}, {} mm\u{b3}). \
         Placed by {}; {} aggregates were left out.</p>",
        escape(&report.specimen.kind),
        thousands(report.specimen.volume_mm3.round() as usize),
        escape(&report.strategy),
        thousands(report.discarded)
    )?;
    for remark in report.remarks().into_iter().chain(report.cost_of_reductions()) {
        writeln!(out, "<p>{remark}.</p>")?;
    }
    phases(model, out)
}

/// The row of a class, `of` a kind of bodies.
fn class(of: &str, class: &ClassReport, out: &mut impl Write) -> io::Result<()> {
    let deviation = if class.target_fraction > 0.0 { class.fraction / class.target_fraction - 1.0 } else { 0.0 };
    writeln!(
        out,
        "<tr><td>{of}{} to {}<td>{:.5}<td>{:.5}<td>{:+.2} %<td>{}",
        class.d_min_mm,
        class.d_max_mm,
        class.target_fraction,
        class.fraction,
        100.0 * deviation,
        thousands(class.aggregates)
    )
}

/// The exact volumes of the phases over the specimen's; nothing where a core has no trustworthy volume.
fn phases(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let specimen = &model.spec.specimen;
    let exact = PhaseVolumes::exact(&model.bodies(), specimen, |aggregate| aggregate.itz_thickness_mm);
    let Ok(PhaseVolumes { aggregate, itz, mortar, .. }) = exact else { return Ok(()) };
    let [aggregate, itz, mortar] = [aggregate, itz, mortar].map(|volume| volume / specimen.volume());
    writeln!(
        out,
        "<p>Shares of the specimen: aggregates inside their ITZ {aggregate:.4}, ITZ {itz:.4}, mortar {mortar:.4}.</p>"
    )
}

/// Shapes, gaps, orientation.
pub(super) fn shapes(statistics: &Statistics, out: &mut impl Write) -> io::Result<()> {
    let shapes = &statistics.shapes;
    writeln!(
        out,
        "<h2>Shapes and gaps</h2>\n<table><tr><th><th>mean<th class=brief>sd<th>min<th class=brief>10 %<th>median<th class=brief>90 %<th>max"
    )?;
    let rows: [(&str, &Option<Distribution>); 8] = [
        ("length, mm", &shapes.length_mm),
        ("sieve size, mm", &shapes.sieve_size_mm),
        ("elongation, intermediate over longest axis", &shapes.elongation),
        ("flatness, shortest over intermediate axis", &shapes.flatness),
        ("sphericity after Wadell", &shapes.wadell_sphericity),
        ("sphericity after Krumbein", &shapes.krumbein_sphericity),
        ("convexity, volume over that of the hull", &shapes.convexity),
        ("distance to the nearest neighbour, mm", &statistics.nearest_distance_mm),
    ];
    for (name, distribution) in rows {
        let Some(d) = distribution else { continue };
        write!(out, "<tr><td>{name}")?;
        let Distribution { mean, sd, min, p10, median, p90, max } = d;
        // A phone shows four of them.
        writeln!(
            out,
            "<td>{mean:.4}<td class=brief>{sd:.4}<td>{min:.4}<td class=brief>{p10:.4}<td>{median:.4}<td class=brief>{p90:.4}\
             <td>{max:.4}"
        )?;
    }
    let (zingg, [low, middle, high]) = (&shapes.zingg, statistics.orientation.eigenvalues);
    writeln!(
        out,
        "</table>\n<p>Zingg: {} equant, {} disc, {} rod, {} blade. Eigenvalues of the orientation tensor of the longest \
         axes: {low:.4}, {middle:.4}, {high:.4} (all 1/3 without a preferred direction). Specific surface {:.4} \
         mm\u{207b}\u{b9}, mean chord {:.3} mm.</p>",
        thousands(zingg.equant),
        thousands(zingg.disc),
        thousands(zingg.rod),
        thousands(zingg.blade),
        statistics.specific_surface_per_mm,
        statistics.correlation.mean_chord_mm
    )?;
    statistics.sampled.iter().try_for_each(|sampled| sample(sampled, statistics, out))?;
    statistics.phases.iter().try_for_each(|phase| further(phase, out))
}

/// How much was measured, in a sentence.
fn sample(sampled: &Sampled, statistics: &Statistics, out: &mut impl Write) -> io::Result<()> {
    let Sampled { aggregates, shapes, nearest, lines_asked } = sampled;
    let [aggregates, shapes, nearest] = [aggregates, shapes, nearest].map(|count| thousands(*count));
    let lines = [statistics.correlation.lines, *lines_asked].map(|count| thousands(count as usize));
    writeln!(
        out,
        "<p>The aggregates have many triangles, so a sample was measured: shapes of {shapes} and nearest neighbours of {nearest} of \
         {aggregates} aggregates, spread evenly over all sizes, and {} of {} lines. \
         <code>packing.statistics(whole=True)</code> in Python measures all.</p>",
        lines[0], lines[1]
    )
}

/// Voids or fibres in a sentence.
fn further(figures: &PhaseFigures, out: &mut impl Write) -> io::Result<()> {
    let PhaseFigures { phase, bodies, volume_mm3, specific_surface_per_mm: surface, orientation, .. } = figures;
    let (mut name, bodies) = (phase.plural().to_owned(), thousands(*bodies));
    name[..1].make_ascii_uppercase();
    write!(out, "<p>{name}: {bodies}, {volume_mm3:.1} mm\u{b3}, specific surface {surface:.4} mm\u{207b}\u{b9}")?;
    if let Some(Orientation { eigenvalues: [low, middle, high], .. }) = orientation {
        write!(out, "; eigenvalues of their orientation tensor: {low:.4}, {middle:.4}, {high:.4}")?;
    }
    writeln!(out, ".</p>")
}

/// Corners and triangles of a surface, and grains of a library, that the page's spec shows: a scan has 100,000.
const LISTED: usize = 20;

/// The spec, its longest lists cut.
pub(super) fn spec(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let brief = brief(&model.spec);
    write!(out, "<details><summary>The spec</summary>")?;
    if brief != model.spec {
        let what = "Of corners, triangles and grains the first";
        write!(out, "<p>{what} {LISTED} are listed; the saved model has them all.</p>")?;
    }
    writeln!(out, "<pre>{}</pre></details>", escape(&serde_json::to_string_pretty(&brief)?))
}

/// The spec with the beginning of every list that may be long.
fn brief(spec: &Spec) -> Spec {
    let mut brief = spec.clone();
    match &mut brief.specimen {
        Specimen::Polyhedron { vertices_mm } => vertices_mm.truncate(LISTED),
        Specimen::Mesh { vertices_mm, triangles, .. } => {
            vertices_mm.truncate(LISTED);
            triangles.truncate(LISTED);
        }
        _ => {}
    }
    brief.shape.grains.truncate(LISTED);
    brief
}
