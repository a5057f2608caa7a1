//! One self-contained HTML page about a packing: pictures, grading plot, statistics; no script, nothing to load.
//!
//! Pictures are exact: the polygons in which the plane meets the polyhedra and their cores.

#[doc(hidden)]
pub mod plot;
mod slice;
mod tables;

use crate::model::Model;
use crate::statistics::Statistics;
use plot::{Curve, Plot};
use std::io::{self, BufWriter, Write};

/// Writes the page to `out`.
///
/// # Errors
/// Those of `out`.
pub fn write(model: &Model, statistics: &Statistics, out: impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    head(model, &mut out)?;
    tables::outcome(model, &mut out)?;
    pictures(model, &mut out)?;
    plots(model, statistics, &mut out)?;
    tables::shapes(statistics, &mut out)?;
    tables::spec(model, &mut out)?;
    out.write_all(b"</main>\n</html>\n")?;
    out.flush()
}

const STYLE: &str = "\
body{margin:0;font:15px/1.5 system-ui,sans-serif;color:#1d1d1f;background:#fff}
main{max-width:72rem;margin:0 auto;padding:2rem 1.5rem}
h1{font-size:1.6rem;margin:0}h2{font-size:1.15rem;margin:2.2rem 0 .6rem}
p{max-width:46rem}.note{color:#5f6368}
table{border-collapse:collapse;margin:.5rem 0}th,td{padding:.2rem .9rem .2rem 0;text-align:right}
th{font-weight:600;border-bottom:1px solid #c9ccd1}th:first-child,td:first-child{text-align:left}
.row{display:flex;flex-wrap:wrap;gap:1.5rem}figure{margin:0}figcaption{color:#5f6368;font-size:.85rem}
svg{display:block}svg text{font:11px system-ui,sans-serif;fill:#3c4043}
.m{fill:#e4e1da}.i{fill:#8a8275}.a{stroke:none}.f{fill:none;stroke:#9aa0a6}.g{stroke:#e8eaed}
.c0{fill:#7fa8c9}.c1{fill:#c9a66b}.c2{fill:#a3b18a}.c3{fill:#c48b9f}.c4{fill:#8fb8b0}.c5{fill:#b39ddb}
pre{background:#f6f7f8;padding:1rem;overflow:auto;font-size:.8rem}
";

fn head(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let report = &model.report;
    let title = format!("Packing of {} aggregates, fraction {:.4}", report.aggregates, report.fraction);
    write!(out, "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n")?;
    write!(
        out,
        "<meta name=\"viewport\" content=\"width=device-width\">\n<style>\n{STYLE}</style>\n<main>\n<h1>{title}</h1>\n"
    )?;
    let version = plot::escape(&report.version);
    writeln!(out, "<p class=\"note\">mesocrete {version}, seed {}, {}</p>", report.seed, plot::escape(&report.grading))
}

/// Three sections through the middle, and the block as one sees it with its corner cut away.
fn pictures(model: &Model, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<h2>Sections through the middle</h2>")?;
    if !model.inclusions.is_empty() {
        writeln!(out, "<style>.vo{{fill:#fff}}.fi{{fill:#2f3b4c}}</style>")?;
        writeln!(out, "<p class=\"note\">Voids are white, fibres dark blue.</p>")?;
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
    writeln!(out, "<h2>The block, cut open along three planes</h2>")?;
    slice::block(model, out)
}

fn plots(model: &Model, statistics: &Statistics, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "<h2>Grading, walls, correlation</h2>\n<div class=\"row\">")?;
    grading(model).write(out)?;
    walls(statistics).write(out)?;
    correlation(statistics).write(out)?;
    writeln!(out, "</div>")
}

/// The curve asked for, and the volumes reached at the class limits.
fn grading(model: &Model) -> Plot {
    let grading = &model.spec.grading;
    let (low, high) = (grading.d_min_mm, grading.d_max_mm);
    let asked = (0..=100).map(|i| low * libm::pow(high / low, f64::from(i) / 100.0)).map(|d| (d, grading.passing(d)));
    let mut sum = grading.passing(low);
    let mut reached = vec![(low, sum)];
    for class in &model.report.classes {
        sum += class.fraction / model.report.target_fraction;
        reached.push((class.d_max_mm, sum));
    }
    Plot {
        title: "Passing against sieve size",
        x: "size, mm (logarithmic)",
        y: "share of the asked volume",
        log_x: true,
        size: plot::SMALL,
        curves: vec![Curve::line("asked", asked.collect()), Curve::dots("reached", reached)],
    }
}

/// Layers with fewer samples scatter by more than 2 %, and are left out.
const FEWEST_POINTS: u64 = 600;

fn walls(statistics: &Statistics) -> Plot {
    let wall = &statistics.wall_effect;
    let layers = wall.depth_mm.iter().zip(&wall.fraction).zip(&wall.points);
    let sampled =
        layers.filter(|&(_, &points)| points >= FEWEST_POINTS).map(|((&depth, &fraction), _)| (depth, fraction));
    let layers: Vec<(f64, f64)> = sampled.collect();
    let deepest = layers.last().map_or(1.0, |layer| layer.0);
    let mean = vec![(0.0, statistics.fraction), (deepest, statistics.fraction)];
    Plot {
        title: "Wall effect",
        x: "depth below the surface, mm",
        y: "fraction",
        log_x: false,
        size: plot::SMALL,
        curves: vec![Curve::line("by depth", layers), Curve::line("mean", mean)],
    }
}

fn correlation(statistics: &Statistics) -> Plot {
    let correlation = &statistics.correlation;
    let over_lag = |values: &[f64]| correlation.lag_mm.iter().copied().zip(values.iter().copied()).collect();
    Plot {
        title: "Two-point correlation and lineal path",
        x: "distance, mm",
        y: "probability",
        log_x: false,
        size: plot::SMALL,
        curves: vec![
            Curve::line("S2", over_lag(&correlation.two_point)),
            Curve::line("lineal path", over_lag(&correlation.lineal_path)),
        ],
    }
}
