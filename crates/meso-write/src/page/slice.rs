//! Section of the aggregates: exact polygons as SVG.

use crate::export::appearance::{CLASSES, fill, phase_colour};
use meso_collision::geometry::{BodyForm, Polyhedron};
use meso_collision::math::Vec3;
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::images::Images;
use meso_concrete::specimen::Surface;
use meso_mesh::cells::Phase;
use meso_pack::model::Model;
use meso_view::section::{ACROSS, sort_around};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{self, Write};

const NAMES: [&str; 3] = ["x", "y", "z"];
/// Width of the widest picture, pixels.
pub(super) const WIDTH: f64 = 340.0;

/// One section across `axis` at `at` mm, to scale.
pub(super) fn figure(model: &Model, axis: usize, at: f64, out: &mut impl Write) -> io::Result<()> {
    let size = model.spec.specimen.aabb().size();
    let (u, v) = ACROSS[axis];
    let scale = WIDTH / size.max();
    let (width, height) = (size[u], size[v]);
    writeln!(
        out,
        "<figure><svg width=\"{:.0}\" height=\"{:.0}\" viewBox=\"0 0 {width} {height}\">",
        width * scale,
        height * scale
    )?;
    // SVG's second axis points down.
    writeln!(out, "<g transform=\"matrix(1 0 0 -1 0 {height})\">")?;
    section(model, axis, at, out)?;
    let caption = format!("{} = {at} mm; {} to the right, {} upwards", NAMES[axis], NAMES[u], NAMES[v]);
    writeln!(out, "</g></svg><figcaption>{caption}</figcaption></figure>")
}

/// The colours of mortar and ITZ.
pub(super) fn matrix_style() -> String {
    fill("m", phase_colour(Phase::Mortar.number())) + &fill("i", phase_colour(Phase::Itz.number()))
}

/// Styles of the size classes; their colours repeat.
pub(super) fn class_style(colour: impl Fn(usize) -> [u8; 3]) -> String {
    (0..CLASSES.len()).map(|class| fill(&format!("c{class}"), colour(class))).collect()
}

/// Styles of voids, of fibres, and of the specimen's own phases.
pub(super) fn inclusion_style(phases: &PhaseNames) -> String {
    let of = |class: &str, phase: Phase| fill(class, phase_colour(phase.number()));
    let own = phases.own().map(|phase| of(&own_class(phase), phase));
    [of("vo", Phase::Void), of("fi", Phase::Fibre)].into_iter().chain(own).collect()
}

/// Name of the style of a phase of the specimen's own.
pub(super) fn own_class(phase: Phase) -> String {
    format!("p{}", phase.number())
}

/// One section across `axis` at `at` mm, as a file of its own.
pub(super) fn picture(model: &Model, axis: usize, at: f64, out: &mut impl Write) -> io::Result<()> {
    let size = model.spec.specimen.aabb().size();
    let (u, v) = ACROSS[axis];
    let (width, height) = (size[u], size[v]);
    write!(out, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}mm\" height=\"{height}mm\" ")?;
    writeln!(out, "viewBox=\"0 0 {width} {height}\">\n<title>{} = {at} mm</title>", NAMES[axis])?;
    // One colour for all aggregates, as in images of voxels.
    let style = matrix_style() + &inclusion_style(&model.spec.phases());
    let style = style + &class_style(|_| phase_colour(Phase::Aggregate.number()));
    writeln!(out, "<style>{style}</style>\n<g transform=\"matrix(1 0 0 -1 0 {height})\">")?;
    section(model, axis, at, out)?;
    out.write_all(b"</g>\n</svg>\n")
}

/// The three sections half a largest aggregate below the faces at the upper ends of the axes, seen from their corner.
pub(super) fn block(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let aabb = model.spec.specimen.aabb();
    let depth = (model.spec.grading.d_max_mm / 2.0).min(aabb.size().min() / 4.0);
    let cut = aabb.max - Vec3::repeat(depth);
    // Isometric: x to the lower right, y to the lower left, z upwards (SVG's second axis points down).
    let (cos, sin) = (0.75f64.sqrt(), 0.5);
    let shown = [(cos, sin), (-cos, sin), (0.0, -1.0)];
    let (left, width) = (cut.y * cos, (cut.x + cut.y) * cos);
    let height = (cut.x + cut.y) * sin + cut.z;
    let scale = 1.4 * WIDTH / width.max(height);
    writeln!(
        out,
        "<svg width=\"{:.0}\" height=\"{:.0}\" viewBox=\"{:.4} {:.4} {width:.4} {height:.4}\">",
        width * scale,
        height * scale,
        -left,
        -cut.z
    )?;
    for axis in 0..3 {
        let (u, v) = ACROSS[axis];
        let [(a, b), (c, d), (x, y)] = [shown[u], shown[v], (shown[axis].0 * cut[axis], shown[axis].1 * cut[axis])];
        writeln!(out, "<clipPath id=\"k{axis}\"><rect width=\"{}\" height=\"{}\"/></clipPath>", cut[u], cut[v])?;
        writeln!(
            out,
            "<g transform=\"matrix({a:.6} {b:.6} {c:.6} {d:.6} {x:.6} {y:.6})\" clip-path=\"url(#k{axis})\">"
        )?;
        section(model, axis, cut[axis], out)?;
        writeln!(out, "</g>")?;
    }
    writeln!(out, "</svg>")
}

/// Mortar, aggregates with their rims, and cores on top, voids and fibres, in mm.
fn section(model: &Model, axis: usize, at: f64, out: &mut impl Write) -> io::Result<()> {
    let mortar = outlines(&model.spec.specimen.container().surface(), axis, at);
    mortar.iter().try_for_each(|outline| path("m", outline, out))?;
    let shown = Images::Whole.of(&model.bodies(), &model.spec.specimen);
    shown.iter().try_for_each(|aggregate| match aggregate.shells.is_empty() {
        true => cut(aggregate, axis, at, out),
        false => faceted(aggregate).nested().iter().try_for_each(|layer| cut(layer, axis, at, out)),
    })
}

/// An ellipsoid with shells is drawn by its facets.
fn faceted(aggregate: &Aggregate) -> Cow<'_, Aggregate> {
    match aggregate.body.form() {
        BodyForm::Round(round) if round.radius().is_none() => {
            Cow::Owned(Aggregate { body: aggregate.body.faceted().into_owned(), ..aggregate.clone() })
        }
        _ => Cow::Borrowed(aggregate),
    }
}

fn cut(aggregate: &Aggregate, axis: usize, at: f64, out: &mut impl Write) -> io::Result<()> {
    if aggregate.body.form() == BodyForm::Surface {
        return cut_with_dents(aggregate, axis, at, out);
    }
    let outline = polygon(&aggregate.body, axis, at);
    if outline.len() < 3 {
        return Ok(());
    }
    match aggregate.kind {
        Kind::Aggregate => path("i", &outline, out)?,
        Kind::Void => return path("vo", &outline, out),
        Kind::Fibre => return path("fi", &outline, out),
    }
    // A body whose core has no trustworthy answer is drawn as all rim.
    let core = aggregate.core().ok().flatten().map(|core| polygon(&core, axis, at)).unwrap_or_default();
    if core.len() < 3 { Ok(()) } else { path(&core_class(aggregate), &core, out) }
}

/// An aggregate with dents has no inner surface, and is drawn without a rim.
fn cut_with_dents(aggregate: &Aggregate, axis: usize, at: f64, out: &mut impl Write) -> io::Result<()> {
    let body = &aggregate.body;
    let faces = body.triangles().map(|triangle| triangle.to_vec()).collect();
    let outlines = outlines(&Surface { points: body.vertices().to_vec(), faces }, axis, at);
    // Outlines of openings run the other way round: in one path they stay open.
    if outlines.is_empty() { Ok(()) } else { paths(&core_class(aggregate), &outlines, out) }
}

fn core_class(aggregate: &Aggregate) -> String {
    match aggregate.phase() {
        phase @ Phase::Own(_) => own_class(phase),
        _ => format!("c{}", usize::from(aggregate.class) % CLASSES.len()),
    }
}

fn path(class: &str, corners: &[[f64; 2]], out: &mut impl Write) -> io::Result<()> {
    paths(class, &[corners], out)
}

/// Several closed lines as one path.
fn paths(class: &str, lines: &[impl AsRef<[[f64; 2]]>], out: &mut impl Write) -> io::Result<()> {
    write!(out, "<path class=\"{class}\" d=\"")?;
    for line in lines {
        write!(out, "M")?;
        for [x, y] in line.as_ref() {
            write!(out, "{x:.2} {y:.2} ")?;
        }
        write!(out, "z")?;
    }
    writeln!(out, "\"/>")
}

/// The corners of the section of `body`, in order around it, mm.
fn polygon(body: &Polyhedron, axis: usize, at: f64) -> Vec<[f64; 2]> {
    let mut corners = Vec::new();
    for face in body.faces() {
        let vertex = |k: usize| body.vertices()[face.vertex(k) as usize];
        corners.extend(rising_edges(face.len(), vertex, axis, at));
    }
    sort_around(&mut corners);
    corners
}

/// Where the edges of a face rise through the plane. The faces of a solid pass every edge in both directions, so that all of
/// them together name each point of a section once.
pub(super) fn rising_edges(
    count: usize,
    vertex: impl Fn(usize) -> Vec3,
    axis: usize,
    at: f64,
) -> impl Iterator<Item = [f64; 2]> {
    let (u, v) = ACROSS[axis];
    (0..count).filter_map(move |k| {
        let (from, to) = (vertex(k), vertex((k + 1) % count));
        (from[axis] < at && to[axis] >= at).then(|| {
            let point = from + (to - from) * ((at - from[axis]) / (to[axis] - from[axis]));
            [point[u], point[v]]
        })
    })
}

/// The closed lines in which a plane meets the specimen's surface, mm.
///
/// Every face that the plane crosses leads from the edge on which its boundary rises through the plane to the edge on
/// which it falls back, and there on to its neighbour.
fn outlines(surface: &Surface, axis: usize, at: f64) -> Vec<Vec<[f64; 2]>> {
    let (u, v) = ACROSS[axis];
    let height = |i: u32| surface.points[i as usize][axis] - at;
    let mut next = BTreeMap::new();
    for face in &surface.faces {
        let edges = || (0..face.len()).map(|k| (face[k], face[(k + 1) % face.len()]));
        let rises = edges().find(|&(a, b)| height(a) < 0.0 && height(b) >= 0.0);
        let falls = edges().find(|&(a, b)| height(a) >= 0.0 && height(b) < 0.0);
        if let (Some(rise), Some((a, b))) = (rises, falls) {
            next.insert(rise, (b, a));
        }
    }
    let mut outlines = Vec::new();
    while let Some((mut edge, mut following)) = next.pop_first() {
        let mut outline = Vec::new();
        loop {
            let [from, to] = [edge.0, edge.1].map(|i| surface.points[i as usize]);
            let point = from + (to - from) * ((at - from[axis]) / (to[axis] - from[axis]));
            outline.push([point[u], point[v]]);
            let Some(after) = next.remove(&following) else { break };
            (edge, following) = (following, after);
        }
        outlines.push(outline);
    }
    outlines
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::convex_hull;
    use meso_concrete::specimen::Specimen;

    #[test]
    fn a_cylinder_is_outlined_by_a_rectangle_and_by_a_circle() {
        let surface = Specimen::Cylinder { diameter_mm: 10.0, height_mm: 20.0 }.container().surface();
        let across = outlines(&surface, 2, 5.0);
        assert_eq!((across.len(), across[0].len()), (1, 128));
        assert!(across[0].iter().all(|[x, y]| ((x - 5.0).hypot(y - 5.0) - 5.0).abs() < 1e-12));
        let along = outlines(&surface, 0, 5.0);
        assert_eq!(along.len(), 1);
        let spread = |k: usize| along[0].iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max);
        assert!((spread(0) - 10.0).abs() < 1e-12 && (spread(1) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn an_octahedron_is_cut_in_a_square() {
        let ends: Vec<Vec3> = (0..3).flat_map(|i| [Vec3::ith(i, 2.0), Vec3::ith(i, -2.0)]).collect();
        let body = convex_hull(&ends).unwrap();
        let corners = polygon(&body, 2, 1.0);
        assert_eq!(corners.len(), 4);
        let doubled_area: f64 =
            (0..4).map(|i| corners[i][0] * corners[(i + 1) % 4][1] - corners[i][1] * corners[(i + 1) % 4][0]).sum();
        assert!((doubled_area - 4.0).abs() < 1e-12, "{corners:?}");
        assert!(polygon(&body, 2, 2.5).is_empty());
    }
}
