//! Section of a mesh: the cells that a plane cuts, as SVG.

use super::slice::{self, WIDTH};
use crate::export::appearance::CLASSES;
use meso_concrete::thousands;
use meso_mesh::cells::{CellKind, Mesh, Phase};
use meso_pack::model::Model;
use meso_view::section::sort_around;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Most cells of a picture: of a finer mesh the middle is shown. They take 1 MB.
const MOST: usize = 20_000;
/// The axis that the plane lies across.
const AXIS: usize = 2;

/// The cells at half the specimen's height, coloured as in the sections, with a caption.
pub(super) fn figure(model: &Model, mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    let aabb = model.spec.specimen.aabb();
    let middle = (aabb.min + aabb.max) / 2.0;
    let all = cut_cells(mesh, middle[AXIS]);
    let share = (MOST as f64 / all.len().max(1) as f64).sqrt().min(1.0);
    let (width, height) = (aabb.size().x * share, aabb.size().y * share);
    let is_shown = |corners: &[[f64; 2]]| {
        corners.iter().all(|[x, y]| 2.0 * (x - middle.x).abs() <= width && 2.0 * (y - middle.y).abs() <= height)
    };
    let classes: BTreeMap<u32, u16> = model.aggregates.iter().map(|body| (body.id, body.class)).collect();
    let mut by_class: BTreeMap<String, Vec<&Vec<[f64; 2]>>> = BTreeMap::new();
    for (cell, corners) in all.iter().filter(|(_, corners)| share == 1.0 || is_shown(corners)) {
        by_class.entry(class(&classes, mesh, *cell)).or_default().push(corners);
    }
    let scale = 1.2 * WIDTH / width.max(height);
    let (left, top) = (middle.x - width / 2.0, -middle.y - height / 2.0);
    writeln!(
        out,
        "<figure><svg width=\"{:.0}\" height=\"{:.0}\" viewBox=\"{left:.4} {top:.4} {width:.4} {height:.4}\">\n\
         <g class=\"e\" transform=\"scale(1 -1)\" stroke-width=\"{:.4}\">",
        width * scale,
        height * scale,
        0.3 / scale
    )?;
    by_class.iter().try_for_each(|(class, cells)| path(class, cells, out))?;
    let part = if share < 1.0 { ", the middle part" } else { "" };
    let kind = match mesh.kind {
        CellKind::Hexahedron => "hexahedra",
        CellKind::Tetrahedron | CellKind::QuadraticTetrahedron => "tetrahedra",
    };
    let (cells, at) = (thousands(mesh.phase.len()), middle[AXIS]);
    writeln!(out, "</g></svg><figcaption>{cells} {kind}, cut at z = {at} mm{part}</figcaption></figure>")
}

/// The cells that the plane across z at `at` mm cuts, and their sections' corners, mm.
fn cut_cells(mesh: &Mesh, at: f64) -> Vec<(usize, Vec<[f64; 2]>)> {
    let mut corners = Vec::new();
    let cut = |(cell, nodes): (usize, &[u32])| {
        let point = |corner: usize| mesh.points[nodes[corner] as usize];
        let below = (0..mesh.kind.corners()).filter(|&corner| point(corner)[AXIS] < at).count();
        if below == 0 || below == mesh.kind.corners() {
            return None;
        }
        corners.clear();
        for face in mesh.kind.faces() {
            corners.extend(slice::rising_edges(face.len(), |k| point(face[k]), AXIS, at));
        }
        sort_around(&mut corners);
        Some((cell, corners.clone()))
    };
    mesh.cells().enumerate().filter_map(cut).collect()
}

/// A body has the colour of its class, as in the sections; `classes` are the bodies' by their ids.
fn class(classes: &BTreeMap<u32, u16>, mesh: &Mesh, cell: usize) -> String {
    match mesh.phase[cell] {
        Phase::Mortar => "m".to_owned(),
        Phase::Itz => "i".to_owned(),
        Phase::Fibre => "fi".to_owned(),
        phase @ Phase::Own(_) => slice::own_class(phase),
        Phase::Aggregate | Phase::Void => {
            let class = classes.get(&mesh.id(mesh.owner[cell])).copied().unwrap_or_default();
            format!("c{}", usize::from(class) % CLASSES.len())
        }
    }
}

/// Polygons of one colour.
fn path(class: &str, cells: &[&Vec<[f64; 2]>], out: &mut impl Write) -> io::Result<()> {
    write!(out, "<path class=\"{class}\" d=\"")?;
    for corners in cells {
        for (k, [x, y]) in corners.iter().enumerate() {
            write!(out, "{}{x:.2} {y:.2}", if k == 0 { "M" } else { " " })?;
        }
        write!(out, "z")?;
    }
    writeln!(out, "\"/>")
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::math::Vec3;

    #[test]
    fn a_plane_cuts_a_cube_in_a_square_and_a_tetrahedron_in_a_triangle() {
        let corner = |i: usize| {
            Vec3::new(f64::from(u8::from(matches!(i % 4, 1 | 2))), f64::from(u8::from(i % 4 > 1)), (i / 4) as f64)
        };
        let cube = Mesh::of(
            CellKind::Hexahedron,
            (0..8).map(corner).collect(),
            (0..8).collect(),
            vec![Phase::Mortar],
            vec![0],
        );
        assert_eq!(cut_cells(&cube, 0.5)[0].1.len(), 4);
        // On its upper face it is cut, on its lower one the cell below would be.
        assert_eq!([cut_cells(&cube, 1.0).len(), cut_cells(&cube, 0.0).len(), cut_cells(&cube, 1.5).len()], [1, 0, 0]);
        let points = vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
        let tetrahedron = Mesh::of(CellKind::Tetrahedron, points, vec![0, 1, 2, 3], vec![Phase::Itz], vec![0]);
        let cut = cut_cells(&tetrahedron, 0.5);
        assert_eq!(cut[0].1.len(), 3);
        assert!(cut[0].1.iter().all(|[x, y]| x + y <= 0.5));
    }
}
