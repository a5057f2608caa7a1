//! The packing to turn: quantised bodies and the specimen's edges for the page's viewer.

use crate::export::appearance::CLASSES;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::images::Images;
use meso_concrete::specimen::Surface;
use meso_concrete::thousands;
use meso_pack::model::Model;
use meso_view::embedded::{TURNTABLE, base64};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Bodies that are shown, the largest first: their data stay within 12 MB.
const MOST: usize = 30_000;
/// Cosine of the angle from which on two polygons of the specimen's surface meet in an edge that is drawn.
const SHARP: f64 = 0.94;

/// Writes the canvas, its controls, the data and the script.
pub(super) fn write(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let surface = model.spec.specimen.container().surface();
    let bodies = Images::Cut.of(&model.bodies(), &model.spec.specimen);
    let shown = &bodies[..bodies.len().min(MOST)];
    let mut all = Aabb::around(&surface.points);
    shown.iter().for_each(|body| all = all.with(&body.body.aabb()));
    let [x, y, z] = all.size().into();
    writeln!(out, "<h2>The packing in 3D</h2>")?;
    writeln!(
        out,
        "<canvas id=\"view\" tabindex=\"0\" data-size=\"{x} {y} {z}\" role=\"img\" aria-label=\"the packing in 3D\"></canvas>"
    )?;
    controls(out)?;
    legend(model, out)?;
    if shown.len() < bodies.len() {
        writeln!(out, "<p class=\"note\">The {} largest bodies alone are shown.</p>", thousands(MOST))?;
    }
    for (name, bytes) in [("bodies", bodies_of(shown, &all)), ("edges", edges_of(&surface, &all))] {
        writeln!(out, "<script type=\"text/plain\" id=\"{name}\">{}</script>", base64(&bytes))?;
    }
    writeln!(out, "<script>\n{TURNTABLE}{}</script>", include_str!("viewer.js"))
}

/// A slider for the cut along each axis, and the button that saves the picture.
fn controls(out: &mut impl Write) -> io::Result<()> {
    write!(out, "<p class=\"note\">")?;
    for axis in ["x", "y", "z"] {
        write!(
            out,
            "<label>cut {axis} <input id=\"cut-{axis}\" type=\"range\" min=\"0\" max=\"1\" step=\"0.005\" value=\"1\"></label> "
        )?;
    }
    writeln!(out, "<button id=\"save\">save the picture</button></p>")?;
    writeln!(
        out,
        "<p class=\"note\">Drag to turn; click, then zoom with the wheel. Two fingers, the arrow keys, + and - do the same.</p>"
    )
}

/// The colour of each size class, and of voids and fibres.
fn legend(model: &Model, out: &mut impl Write) -> io::Result<()> {
    let classes = model.report.classes.iter().map(|class| format!("{} to {} mm", class.d_min_mm, class.d_max_mm));
    let mut names: BTreeMap<u16, String> = (0..).zip(classes).collect();
    names.extend(model.inclusions.iter().map(|body| (body.class, body.kind.plural().to_owned())));
    write!(out, "<p class=\"note\">")?;
    for (class, name) in names {
        let [r, g, b] = CLASSES[usize::from(class) % CLASSES.len()];
        write!(out, "<span class=\"key\"><i style=\"background:#{r:02x}{g:02x}{b:02x}\"></i>{name}</span> ")?;
    }
    writeln!(out, "</p>")
}

/// A position in the box as three numbers of 16 bits, the lowest byte first.
fn quantised(position: &Vec3, all: &Aabb) -> [u8; 6] {
    let mut bytes = [0; 6];
    for axis in 0..3 {
        let share = (position[axis] - all.min[axis]) / all.size()[axis];
        let [low, high] = ((65535.0 * share).round() as u16).to_le_bytes();
        (bytes[2 * axis], bytes[2 * axis + 1]) = (low, high);
    }
    bytes
}

/// For each body its colour, the numbers of corners and triangles, the corners, and the triangles, all of 16 bits.
fn bodies_of(bodies: &[Aggregate], all: &Aabb) -> Vec<u8> {
    let mut bytes = Vec::new();
    for Aggregate { class, body, .. } in bodies {
        let triangles: Vec<u16> = body.triangles().flatten().map(|corner| corner as u16).collect();
        let head = [class % CLASSES.len() as u16, body.vertices().len() as u16, (triangles.len() / 3) as u16];
        bytes.extend(head.into_iter().flat_map(u16::to_le_bytes));
        bytes.extend(body.vertices().iter().flat_map(|vertex| quantised(vertex, all)));
        bytes.extend(triangles.into_iter().flat_map(u16::to_le_bytes));
    }
    bytes
}

/// The ends of the specimen's edges: where two polygons of its surface meet at an angle.
fn edges_of(surface: &Surface, all: &Aabb) -> Vec<u8> {
    let corner = |i: u32| surface.points[i as usize];
    let mut normals: BTreeMap<(u32, u32), Vec3> = BTreeMap::new();
    let mut bytes = Vec::new();
    for face in &surface.faces {
        let [a, b, c] = [0, 1, 2].map(|k| corner(face[k]));
        let normal = (b - a).cross(&(c - a)).normalize();
        for (k, &from) in face.iter().enumerate() {
            let to = face[(k + 1) % face.len()];
            let ends = (from.min(to), from.max(to));
            match normals.remove(&ends) {
                None => drop(normals.insert(ends, normal)),
                Some(other) if other.dot(&normal) < SHARP => {
                    bytes.extend([ends.0, ends.1].into_iter().flat_map(|end| quantised(&corner(end), all)));
                }
                Some(_) => {}
            }
        }
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_concrete::specimen::Specimen;

    #[test]
    fn a_box_has_twelve_edges_and_a_cylinder_two_circles() {
        let edges = |specimen: Specimen| {
            let surface = specimen.container().surface();
            edges_of(&surface, &Aabb::around(&surface.points)).len() / 12
        };
        assert_eq!(edges(Specimen::cube(10.0)), 12);
        assert_eq!(edges(Specimen::Cylinder { diameter_mm: 10.0, height_mm: 20.0 }), 256);
    }
}
