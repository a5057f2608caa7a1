//! Closed shells of a STEP file: plane polygons, cylinders and spheres.

use super::lines::{Id, Lines, list, real};
use meso_collision::math::Vec3;
use std::collections::BTreeMap;
use std::io::{self, Write};

/// The outer surface of a specimen; its bounding box begins at the origin.
pub(crate) enum Block {
    /// Plane polygons, counter-clockwise from outside.
    Polygons {
        /// mm.
        points: Vec<Vec3>,
        /// Indices of points.
        faces: Vec<Vec<u32>>,
    },
    /// Its axis is parallel to z.
    Cylinder {
        /// mm.
        radius: f64,
        /// mm.
        height: f64,
    },
    /// A ball.
    Sphere {
        /// mm.
        radius: f64,
    },
}

impl Block {
    pub(super) fn shell(&self, lines: &mut Lines<impl Write>) -> io::Result<Id> {
        match self {
            Self::Polygons { points, faces } => polygons(lines, points, faces.iter().cloned()),
            Self::Cylinder { radius, height } => cylinder(lines, *radius, *height),
            Self::Sphere { radius } => sphere(lines, *radius),
        }
    }
}

/// A shell of plane polygons; each edge has one polygon on either side.
pub(super) fn polygons(
    lines: &mut Lines<impl Write>,
    points: &[Vec3],
    faces: impl Iterator<Item = Vec<u32>>,
) -> io::Result<Id> {
    let placed = points.iter().map(|point| lines.point(point)).collect::<io::Result<Vec<Id>>>()?;
    let vertex = |&point: &Id| lines.entity(format_args!("VERTEX_POINT('',{point})"));
    let vertices = placed.iter().map(vertex).collect::<io::Result<Vec<Id>>>()?;
    let mut edges = Edges { points, placed: &placed, vertices: &vertices, known: BTreeMap::new() };
    let faces = faces.map(|corners| polygon(lines, &mut edges, &corners)).collect::<io::Result<Vec<Id>>>()?;
    closed(lines, &faces)
}

fn closed(lines: &mut Lines<impl Write>, faces: &[Id]) -> io::Result<Id> {
    lines.entity(format_args!("CLOSED_SHELL('',{})", list(faces)))
}

fn polygon(lines: &mut Lines<impl Write>, edges: &mut Edges, corners: &[u32]) -> io::Result<Id> {
    let mut around = Vec::new();
    for (k, &from) in corners.iter().enumerate() {
        let (edge, forward) = edges.between(lines, from, corners[(k + 1) % corners.len()])?;
        around.push(oriented(lines, edge, forward)?);
    }
    let at = |k: usize| edges.points[corners[k] as usize];
    let area: Vec3 = (2..corners.len()).map(|k| (at(k - 1) - at(0)).cross(&(at(k) - at(0)))).sum();
    let (point, normal) = (edges.placed[corners[0] as usize], lines.direction(&area.normalize())?);
    let along = lines.direction(&(at(1) - at(0)).normalize())?;
    let frame = lines.entity(format_args!("AXIS2_PLACEMENT_3D('',{point},{normal},{along})"))?;
    let plane = lines.entity(format_args!("PLANE('',{frame})"))?;
    face(lines, &around, plane)
}

fn oriented(lines: &mut Lines<impl Write>, edge: Id, forward: bool) -> io::Result<Id> {
    let sense = if forward { ".T." } else { ".F." };
    lines.entity(format_args!("ORIENTED_EDGE('',*,*,{edge},{sense})"))
}

/// A face of `surface` within a loop of oriented edges.
fn face(lines: &mut Lines<impl Write>, around: &[Id], surface: Id) -> io::Result<Id> {
    let edges = lines.entity(format_args!("EDGE_LOOP('',{})", list(around)))?;
    let bound = lines.entity(format_args!("FACE_OUTER_BOUND('',{edges},.T.)"))?;
    lines.entity(format_args!("ADVANCED_FACE('',({bound}),{surface},.T.)"))
}

/// Straight edges, each written where it is first met.
struct Edges<'a> {
    points: &'a [Vec3],
    placed: &'a [Id],
    vertices: &'a [Id],
    known: BTreeMap<[u32; 2], Id>,
}

impl Edges<'_> {
    /// The edge between two points, and whether it was first met in this direction.
    fn between(&mut self, lines: &mut Lines<impl Write>, from: u32, to: u32) -> io::Result<(Id, bool)> {
        if let Some(&edge) = self.known.get(&[to, from]) {
            return Ok((edge, false));
        }
        let (start, end) = (from as usize, to as usize);
        let along = lines.direction(&(self.points[end] - self.points[start]).normalize())?;
        let along = lines.entity(format_args!("VECTOR('',{along},1.)"))?;
        let line = lines.entity(format_args!("LINE('',{},{along})", self.placed[start]))?;
        let [start, end] = [self.vertices[start], self.vertices[end]];
        let edge = lines.entity(format_args!("EDGE_CURVE('',{start},{end},{line},.T.)"))?;
        self.known.insert([from, to], edge);
        Ok((edge, true))
    }
}

/// A placement whose first axis is x.
pub(super) fn placement(lines: &mut Lines<impl Write>, at: &Vec3, axis: &Vec3) -> io::Result<Id> {
    let (point, axis, along) = (lines.point(at)?, lines.direction(axis)?, lines.direction(&Vec3::x())?);
    lines.entity(format_args!("AXIS2_PLACEMENT_3D('',{point},{axis},{along})"))
}

/// Two discs, and the wall, which is cut along a seam from one circle to the other.
fn cylinder(lines: &mut Lines<impl Write>, radius: f64, height: f64) -> io::Result<Id> {
    let size = real(radius);
    let (mut circles, mut ends) = (Vec::new(), Vec::new());
    for z in [0.0, height] {
        let frame = placement(lines, &Vec3::new(radius, radius, z), &Vec3::z())?;
        let circle = lines.entity(format_args!("CIRCLE('',{frame},{size})"))?;
        let start = lines.point(&Vec3::new(2.0 * radius, radius, z))?;
        let vertex = lines.entity(format_args!("VERTEX_POINT('',{start})"))?;
        circles.push(lines.entity(format_args!("EDGE_CURVE('',{vertex},{vertex},{circle},.T.)"))?);
        ends.push((start, vertex));
    }
    let [(start, low), (_, high)] = [ends[0], ends[1]];
    let up = lines.direction(&Vec3::z())?;
    let up = lines.entity(format_args!("VECTOR('',{up},1.)"))?;
    let line = lines.entity(format_args!("LINE('',{start},{up})"))?;
    let seam = lines.entity(format_args!("EDGE_CURVE('',{low},{high},{line},.T.)"))?;
    let mut faces = Vec::new();
    for (circle, z, axis) in [(circles[0], 0.0, -Vec3::z()), (circles[1], height, Vec3::z())] {
        let frame = placement(lines, &Vec3::new(radius, radius, z), &axis)?;
        let plane = lines.entity(format_args!("PLANE('',{frame})"))?;
        let around = oriented(lines, circle, z > 0.0)?;
        faces.push(face(lines, &[around], plane)?);
    }
    let frame = placement(lines, &Vec3::new(radius, radius, 0.0), &Vec3::z())?;
    let wall = lines.entity(format_args!("CYLINDRICAL_SURFACE('',{frame},{size})"))?;
    let around = [(circles[0], true), (seam, true), (circles[1], false), (seam, false)];
    let around = around.into_iter().map(|(edge, forward)| oriented(lines, edge, forward));
    let around = around.collect::<io::Result<Vec<Id>>>()?;
    faces.push(face(lines, &around, wall)?);
    closed(lines, &faces)
}

/// One face, bounded by a pole.
fn sphere(lines: &mut Lines<impl Write>, radius: f64) -> io::Result<Id> {
    let frame = placement(lines, &Vec3::repeat(radius), &Vec3::z())?;
    let surface = lines.entity(format_args!("SPHERICAL_SURFACE('',{frame},{})", real(radius)))?;
    let pole = lines.point(&Vec3::new(radius, radius, 2.0 * radius))?;
    let pole = lines.entity(format_args!("VERTEX_POINT('',{pole})"))?;
    let around = lines.entity(format_args!("VERTEX_LOOP('',{pole})"))?;
    let bound = lines.entity(format_args!("FACE_BOUND('',{around},.T.)"))?;
    let face = lines.entity(format_args!("ADVANCED_FACE('',({bound}),{surface},.T.)"))?;
    closed(lines, &[face])
}
