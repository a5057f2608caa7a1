//! One self-contained HTML page about a packing: pictures, a block to turn, grading plot, statistics; nothing to load.
//!
//! Pictures are exact: the polygons in which the plane meets the polyhedra and their cores.

mod mesh_section;
mod scene;
mod slice;
mod tables;

use crate::export::appearance::{CLASSES, phase_colour};
use meso_concrete::aggregate::{Aggregate, SizeDefinition};
use meso_concrete::parallel;
use meso_concrete::{Phase, thousands};
use meso_mesh::cells::Mesh;
use meso_pack::model::Model;
use meso_pack::statistics::Statistics;
use meso_view::plot::{self, Plot, Series};
use std::io::{self, BufWriter, Write};

/// Writes the page to `out`, with a section through `mesh` where there is one.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write(model: &Model, statistics: &Statistics, mesh: Option<&Mesh>, mut out: impl Write) -> io::Result<()> {
    write_to(model, statistics, mesh, &mut out)
}

/// Writes the page; compiled once, here.
fn write_to(model: &Model, statistics: &Statistics, mesh: Option<&Mesh>, out: &mut dyn Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    head(model, &mut out)?;
    tables::outcome(model, &mut out)?;
    scene::write(model, &mut out)?;
    pictures(model, mesh, &mut out)?;
    plots(model, statistics, &mut out)?;
    tables::shapes(statistics, &mut out)?;
    tables::spec(model, &mut out)?;
    out.write_all(b"</main>\n</html>\n")?;
    out.flush()
}

/// Writes one section across `axis` at `at` mm as a picture of its own (`.svg`), to scale in mm and upright.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn section(model: &Model, axis: usize, at: f64, out: &mut impl Write) -> io::Result<()> {
    slice::picture(model, axis, at, out)
}

const STYLE: &str = "\
:root{color-scheme:light dark;--paper:#fff;--ink:#1d1d1f;--soft:#5f6368;--line:#c9ccd1;--faint:#e8eaed;--panel:#f6f7f8;--label:#3c4043}
@media (prefers-color-scheme:dark){:root{--paper:#17181a;--ink:#e6e6e8;--soft:#a0a4aa;--line:#4a4d52;--faint:#303338;\
--panel:#212327;--label:#c4c8cd}}
body{margin:0;font:15px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper)}
main{max-width:72rem;margin:0 auto;padding:2rem clamp(.8rem,4vw,1.5rem)}
h1{font-size:1.6rem;margin:0}h2{font-size:1.15rem;margin:2.2rem 0 .6rem}
p{max-width:46rem;overflow-wrap:anywhere}.note{color:var(--soft)}
table{border-collapse:collapse;margin:.5rem 0;display:block;max-width:100%;overflow-x:auto}
th,td{padding:.2rem .9rem .2rem 0;text-align:right;white-space:nowrap}
th{font-weight:600;border-bottom:1px solid var(--line)}th:first-child,td:first-child{text-align:left}
.row{display:flex;flex-wrap:wrap;gap:1.5rem}figure{margin:0;max-width:100%}figcaption{color:var(--soft);font-size:.85rem}
svg{display:block;max-width:100%;height:auto}svg text{font:11px system-ui,sans-serif;fill:var(--label)}
canvas{display:block;width:100%;height:min(70vh,36rem,100vw);touch-action:none;cursor:grab}
input[type=range]{width:min(11rem,40vw);vertical-align:middle}
.key{white-space:nowrap;margin-right:.8rem}.key i{display:inline-block;width:.8em;height:.8em;margin-right:.35em;border-radius:.15em}
.a{stroke:none}.f{fill:none;stroke:#9aa0a6}.g{stroke:var(--faint)}
section{max-width:100%}.e{stroke:#6b6f76;stroke-linejoin:round}
pre{background:var(--panel);padding:1rem;overflow:auto;font-size:.8rem}
@media(max-width:34rem){table{font-size:.8rem}th,td{padding-right:.5rem}td:first-child{white-space:normal}.brief{display:none}}
";

fn head(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let report = &model.report;
    let title = format!("Packing of {} aggregates, fraction {:.4}", thousands(report.aggregates), report.fraction);
    write!(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n")?;
    let (matrix, classes) = (slice::matrix_style(), slice::class_style(|class| CLASSES[class]));
    write!(
        out,
        "<meta name=\"viewport\" content=\"width=device-width\">\n<style>\n{STYLE}{matrix}{classes}\n</style>\n<main>\n<h1>{title}</h1>\n"
    )?;
    let version = plot::escape(&report.version);
    writeln!(out, "<p class=\"note\">mesocrete {version}, seed {}, {}</p>", report.seed, plot::escape(&report.grading))
}

/// Three sections through the middle, the block as one sees it with its corner cut away, and the mesh.
fn pictures(model: &Model, mesh: Option<&Mesh>, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<h2>Sections through the middle</h2>")?;
    let phases = &model.spec.phases();
    if !model.inclusions.is_empty() || phases.own().len() > 0 {
        writeln!(out, "<style>{}</style>", slice::inclusion_style(phases))?;
    }
    if !model.inclusions.is_empty() {
        writeln!(out, "<p class=\"note\">Voids are white, fibres dark blue.</p>")?;
    }
    if phases.own().len() > 0 {
        let key = |phase: Phase| {
            let [r, g, b] = phase_colour(phase.number());
            let name = phases.name(phase);
            format!("<span class=key><i style=\"background:#{r:02x}{g:02x}{b:02x}\"></i>{name}</span>")
        };
        writeln!(out, "<p class=\"note\">Phases: {}</p>", phases.own().map(key).collect::<String>())?;
    }
    writeln!(out, "<div class=\"row\">")?;
    let aabb = model.spec.specimen.aabb();
    let middle = (aabb.min + aabb.max) / 2.0;
    for axis in 0..3 {
        slice::figure(model, axis, middle[axis], out)?;
    }
    writeln!(
        out,
        "</div>\n<p class=\"note\">Coloured by size class, from the finest; dark rims are the ITZ, light is mortar.</p>"
    )?;
    writeln!(out, "<div class=\"row\">\n<section><h2>The block, cut open along three planes</h2>")?;
    slice::block(model, out)?;
    writeln!(out, "</section>")?;
    if let Some(mesh) = mesh {
        writeln!(out, "<section><h2>The mesh at half height</h2>")?;
        mesh_section::figure(model, mesh, out)?;
        writeln!(out, "</section>")?;
    }
    writeln!(out, "</div>")
}

fn plots(model: &Model, statistics: &Statistics, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<h2>Grading, walls, correlation</h2>\n<div class=\"row\">")?;
    grading(model).write(out)?;
    let walls = walls(statistics);
    if !walls.is_empty() {
        walls.write(out)?;
    }
    correlation(statistics).write(out)?;
    writeln!(out, "</div>")
}

/// The curve asked for, and the volumes reached at the class limits.
fn grading(model: &Model) -> Plot<'static> {
    let grading = &model.spec.grading;
    let (low, high) = (grading.d_min_mm, grading.d_max_mm);
    let asked = (0..=100).map(|i| low * libm::pow(high / low, f64::from(i) / 100.0)).map(|d| (d, grading.passing(d)));
    let mut sum = grading.passing(low);
    let mut reached = vec![(low, sum)];
    for class in &model.report.classes {
        sum += class.fraction / model.report.target_fraction;
        reached.push((class.d_max_mm, sum));
    }
    let mut curves = vec![Series::line("asked", asked.collect()), Series::dots("reached", reached)];
    let (title, x) = match grading.size {
        SizeDefinition::Sieve => ("Passing against sieve size", "sieve size, mm (logarithmic)"),
        SizeDefinition::LongestAxis => {
            curves.push(Series::line("by sieve size", sieve_curve(model)));
            ("Passing against longest axis", "longest axis, mm (logarithmic)")
        }
    };
    Plot { title, x, y: "share of the asked volume", log_x: true, size: Plot::SMALL, curves }
}

/// Points of a curve over sizes.
const CURVE_POINTS: usize = 60;

/// The volume that passes square openings of a size, over the volume asked for.
fn sieve_curve(model: &Model) -> Vec<(f64, f64)> {
    let sieved = |aggregate: &Aggregate| {
        let body = aggregate.graded();
        (body.sieve_size(), body.volume())
    };
    let mut grains: Vec<(f64, f64)> = parallel::map_each(&model.aggregates, sieved);
    grains.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let asked = model.report.target_fraction * model.report.specimen.volume_mm3;
    let step = grains.len().div_ceil(CURVE_POINTS).max(1);
    let mut passing = 0.0;
    let mut curve = Vec::new();
    for some in grains.chunks(step) {
        passing += some.iter().map(|grain| grain.1).sum::<f64>() / asked;
        curve.push((some[some.len() - 1].0, passing));
    }
    curve
}

/// Layers with fewer samples scatter by more than 2 %, and are left out.
const FEWEST_POINTS: u64 = 600;

/// The fraction by depth; empty where periods leave no wall.
fn walls(statistics: &Statistics) -> Plot<'static> {
    let wall = &statistics.wall_effect;
    let layers = wall.depth_mm.iter().zip(&wall.fraction).zip(&wall.points);
    let sampled =
        layers.filter(|&(_, &points)| points >= FEWEST_POINTS).map(|((&depth, &fraction), _)| (depth, fraction));
    let layers: Vec<(f64, f64)> = sampled.collect();
    let mean = layers.last().map_or_else(Vec::new, |layer| [0.0, layer.0].map(|d| (d, statistics.fraction)).to_vec());
    Plot {
        title: "Wall effect",
        x: "depth below the surface, mm",
        y: "fraction",
        log_x: false,
        size: Plot::SMALL,
        curves: vec![Series::line("by depth", layers), Series::line("mean", mean)],
    }
}

fn correlation(statistics: &Statistics) -> Plot<'static> {
    let correlation = &statistics.correlation;
    let over_lag = |values: &[f64]| correlation.lag_mm.iter().copied().zip(values.iter().copied()).collect();
    Plot {
        title: "Two-point correlation and lineal path",
        x: "distance, mm",
        y: "probability",
        log_x: false,
        size: Plot::SMALL,
        curves: vec![
            Series::line("S2", over_lag(&correlation.two_point)),
            Series::line("lineal path", over_lag(&correlation.lineal_path)),
        ],
    }
}
