//! A polyhedron: vertices and outward faces, with its exact integrals. It is convex unless it was made of a surface with
//! dents, or a round body with facets.

use crate::geometry::Triangles;
use crate::geometry::exact::predicates::orient3d;
use crate::geometry::faces::{Face, FaceList, Faces, Role};
use crate::geometry::measure::facet_kernels::{Facets, Moment};
use crate::geometry::measure::integrals;
use crate::geometry::measure::tetrahedron::six_volumes;
use crate::geometry::plane::{Facet, Plane};
use crate::geometry::round::{FACETS, Round};
use crate::math::{Aabb, Mat3, Rotation, Vec3};
use crate::simd::widest;
use std::borrow::Cow;

/// As many vertices as a byte can number.
const BYTE_INDICES: usize = 256;

/// A closed polyhedron.
///
/// Vertices in mm; faces are convex polygons, counter-clockwise seen from outside. The type keeps its input as it is:
/// [`convex_hull`](crate::geometry::convex_hull) makes one that is convex by construction. [`Polyhedron::form`] says
/// what it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyhedron {
    vertices: Box<[Vec3]>,
    faces: FaceList,
    volume: f64,
}

/// A body by what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BodyForm {
    /// A convex polyhedron: the planes of its faces bound it.
    Hull,
    /// A ball or an ellipsoid: its faces are facets within.
    Round(Round),
    /// A closed surface of triangles that need not be convex: the planes of its faces bound nothing.
    Surface,
}

impl BodyForm {
    /// The smallest axis-aligned box around a body of this form with these vertices.
    pub fn aabb(&self, vertices: &[Vec3]) -> Aabb {
        if let Self::Round(round) = self { round.aabb() } else { Aabb::around(vertices) }
    }
}

/// Volume integrals of a body of unit density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// mm3.
    pub volume: f64,
    /// Centre of volume, mm.
    pub centroid: Vec3,
    /// Inertia tensor about the centroid, mm5.
    pub inertia: Mat3,
}

impl Polyhedron {
    /// Keeps `vertices` and `faces` as they are; they must form a closed convex surface.
    pub fn from_parts<F: AsRef<[u32]>>(vertices: Vec<Vec3>, faces: impl IntoIterator<Item = F>) -> Self {
        let (mut corners, mut ends) = (Vec::new(), Vec::new());
        for face in faces {
            corners.extend_from_slice(face.as_ref());
            ends.push(corners.len() as u32);
        }
        Self::from_lists(vertices.into_boxed_slice(), &corners, &ends)
    }

    /// The body as one that need not be convex, whose faces must be triangles.
    #[must_use]
    pub fn with_dents(mut self) -> Self {
        self.set_caps(0);
        self
    }

    /// Makes it a body with dents whose triangles in some sides of its box are caps.
    pub(crate) fn set_caps(&mut self, caps: u8) {
        self.faces.role = Role::Surface { caps };
    }

    /// The sides of its box where a cut ends a body with dents: a bit for each, the lower and the upper one along x, y and z.
    pub fn caps(&self) -> u8 {
        if let Role::Surface { caps } = self.faces.role { caps } else { 0 }
    }

    /// The body by what it is.
    pub fn form(&self) -> BodyForm {
        match self.faces.role {
            Role::Hull => BodyForm::Hull,
            Role::Surface { .. } => BodyForm::Surface,
            Role::Facets => BodyForm::Round(Round::of_ends(&self.vertices)),
        }
    }

    /// False for a body with dents, even where it has none.
    pub(crate) fn is_convex(&self) -> bool {
        !matches!(self.faces.role, Role::Surface { .. })
    }

    /// A ball or an ellipsoid. Its vertices lie on it, its faces within; volume, inertia, box, points inside, distances
    /// and sieve size are those of the round body itself.
    pub fn of_round(round: &Round) -> Self {
        Self::of_ends(&round.ends())
    }

    /// The round body whose ends these are.
    pub fn of_ends(ends: &[Vec3]) -> Self {
        let round = Round::of_ends(ends);
        let mut faces = FaceList::of_triangles(FACETS.triangles.as_flattened().into());
        faces.role = Role::Facets;
        Self { vertices: round.vertices(ends), faces, volume: round.volume() }
    }

    /// The ball or ellipsoid that it is, beyond its faces.
    pub(crate) fn round(&self) -> Option<Round> {
        if let BodyForm::Round(round) = self.form() { Some(round) } else { None }
    }

    /// The body bounded by its faces: a round one becomes a convex polyhedron of its volume, others stay.
    pub fn faceted(&self) -> Cow<'_, Self> {
        let Some(round) = self.round() else { return Cow::Borrowed(self) };
        let within = self.facets_grown(&round, 1.0);
        Cow::Owned(self.facets_grown(&round, libm::cbrt(self.volume / within.volume)))
    }

    /// Planes that leave the body inside and follow it closely: those of its faces, or around a round body.
    pub fn bounding_planes(&self) -> Vec<Plane> {
        match self.round() {
            Some(round) => self.facets_grown(&round, FACETS.outwards).planes().collect(),
            None => self.planes().collect(),
        }
    }

    /// True where the points deeper than a thickness are a body of the same kind, which they are not for dents and
    /// ellipsoids.
    pub fn has_inner_body(&self) -> bool {
        match self.form() {
            BodyForm::Hull => true,
            BodyForm::Surface => false,
            BodyForm::Round(round) => round.radius().is_some(),
        }
    }

    /// The facets of a round body as a convex polyhedron, grown about its centre.
    pub(crate) fn facets_grown(&self, round: &Round, growth: f64) -> Self {
        let mut faces = self.faces.clone();
        faces.role = Role::Hull;
        let centre = round.centre();
        Self::with_faces(self.vertices.iter().map(|vertex| centre + (vertex - centre) * growth).collect(), faces)
    }

    /// Its triangles, to be asked which points they hold and whether they are apart from others.
    pub fn surface(&self) -> Triangles {
        Triangles::in_order(self.triangles().map(|t| t.map(|i| self.vertices[i as usize])).collect())
    }

    /// Makes a polyhedron as [`Polyhedron::from_parts`] does, from the corners of all faces and where each face ends.
    pub(crate) fn from_lists(vertices: Box<[Vec3]>, corners: &[u32], ends: &[u32]) -> Self {
        // The lists are read faster than the narrow indices they are stored as: a tenth of a grain's hull.
        let starts = std::iter::once(&0).chain(ends);
        let triangles = starts.zip(ends).flat_map(|(&start, &end)| {
            let face = &corners[start as usize..end as usize];
            face.windows(2).skip(1).map(|edge| [face[0], edge[0], edge[1]])
        });
        let volume = if vertices.len() <= BYTE_INDICES {
            let mut few = Vec::with_capacity(corners.len() - 2 * ends.len());
            triangles.for_each(|triangle| few.push(triangle.map(|i| i as u8)));
            integrals::volume_of_few(&vertices, &few)
        } else if ends.len() * 3 == corners.len() {
            integrals::volume(&vertices, corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]))
        } else {
            integrals::volume(&vertices, triangles)
        };
        Self { vertices, faces: FaceList::new(corners, ends), volume }
    }

    /// From the corners of triangles, in the canonical order.
    pub(crate) fn of_triangles(vertices: Box<[Vec3]>, corners: &[u8]) -> Self {
        Self::with_faces(vertices, FaceList::of_triangles(corners.into()))
    }

    /// Over faces that other vertices had.
    pub(crate) fn with_faces(vertices: Box<[Vec3]>, faces: FaceList) -> Self {
        if faces.role == Role::Facets {
            return Self::of_ends(&vertices);
        }
        let volume = match faces.faces().byte_triangles() {
            Some(triangles) => integrals::volume_of_few(&vertices, triangles),
            None => integrals::volume(&vertices, faces.faces().iter().flat_map(Face::triangles)),
        };
        Self { vertices, faces, volume }
    }

    /// Over faces that other vertices had, around the same volume.
    pub(crate) fn of_volume(vertices: Box<[Vec3]>, faces: FaceList, volume: f64) -> Self {
        if faces.role == Role::Facets {
            return Self::of_ends(&vertices);
        }
        Self { vertices, faces, volume }
    }

    /// Its vertices, mm.
    pub fn into_vertices(self) -> Vec<Vec3> {
        self.vertices.into_vec()
    }

    /// Its faces, wherever they are stored.
    pub(crate) fn face_lists(&self) -> Faces<'_> {
        self.faces.faces()
    }

    /// Maps the vertices by `map` and keeps the faces, with a volume known better than from the rounded vertices.
    pub(crate) fn mapped_to_volume(mut self, map: impl Fn(&Vec3) -> Vec3, volume: f64) -> Self {
        self.vertices.iter_mut().for_each(|vertex| *vertex = map(vertex));
        Self { volume, ..self }
    }

    /// Vertex positions, mm.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Faces as vertex indices, counter-clockwise from outside.
    pub fn faces(&self) -> impl ExactSizeIterator<Item = Face<'_>> {
        self.face_lists().iter()
    }

    /// Faces cut into triangles, fan-wise from their first vertex.
    pub fn triangles(&self) -> impl Iterator<Item = [u32; 3]> {
        self.faces().flat_map(Face::triangles)
    }

    /// The planes of the faces, in face order.
    pub fn planes(&self) -> impl Iterator<Item = Plane> {
        self.facets().into_iter().map(|facet| facet.plane)
    }

    /// The faces with their planes, in face order.
    pub fn facets(&self) -> Vec<Facet> {
        match self.face_lists().byte_triangles() {
            // Nearly all bodies: in a fifth of the time.
            Some(triangles) => widest(Facets { vertices: &self.vertices, triangles }),
            None => self.faces().map(|face| self.facet(face)).collect(),
        }
    }

    fn facet(&self, face: Face) -> Facet {
        let corners = face.iter().map(|i| self.vertices[i as usize]);
        let vector_area = vector_area(corners.clone());
        let area = vector_area.norm();
        let normal = vector_area / area;
        // The plane that leaves every vertex of the face inside: rounding must not cut the body.
        let offset = corners.clone().map(|corner| normal.dot(&corner)).fold(f64::NEG_INFINITY, f64::max);
        Facet { plane: Plane { normal, offset }, area, corners: corners.len() }
    }

    /// Surface area, mm2.
    pub fn area(&self) -> f64 {
        if let Some(round) = self.round() {
            return round.area();
        }
        self.facets().iter().map(|facet| facet.area).sum()
    }

    /// Volume, mm3, to 1e-14.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Sphericity after Wadell (J. Geol. 40, 1932): the area of the ball of equal volume over the body's own, at most 1.
    pub fn sphericity(&self) -> f64 {
        libm::cbrt(std::f64::consts::PI) * libm::cbrt(6.0 * self.volume()).powi(2) / self.area()
    }

    /// Centre of volume, mm.
    pub fn centroid(&self) -> Vec3 {
        if let Some(round) = self.round() {
            return *round.centre();
        }
        let (volume, moment) = match self.face_lists().byte_triangles() {
            // Nearly all bodies: eight tetrahedra at a time.
            Some(triangles) => widest(Moment { apex: self.vertices[0], vertices: &self.vertices, triangles }),
            None => {
                let (mut volume, mut moment) = (0.0, Vec3::zeros());
                self.each_tetrahedron(|v, [a, b, c]| {
                    volume += v;
                    moment += (a + b + c) * (v / 4.0);
                });
                (volume, moment)
            }
        };
        self.vertices[0] + moment / volume
    }

    /// Volume, centroid and inertia by summing the tetrahedra between the first vertex and every surface triangle.
    ///
    /// The covariance of a tetrahedron (0, a, b, c) of volume V is V/20 (s s^T + a a^T + b b^T + c c^T), s = a + b + c.
    pub fn mass_properties(&self) -> MassProperties {
        if let Some(round) = self.round() {
            return MassProperties { volume: self.volume, centroid: *round.centre(), inertia: round.inertia() };
        }
        let (mut volume, mut moment, mut covariance) = (0.0, Vec3::zeros(), Mat3::zeros());
        self.each_tetrahedron(|v, [a, b, c]| {
            let s = a + b + c;
            volume += v;
            moment += s * (v / 4.0);
            covariance += (s * s.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose()) * (v / 20.0);
        });
        let mean = moment / volume;
        let central = covariance - mean * mean.transpose() * volume;
        let inertia = Mat3::identity() * central.trace() - central;
        MassProperties { volume: self.volume, centroid: self.vertices[0] + mean, inertia }
    }

    /// The tetrahedra between the first vertex and every surface triangle: volumes, and corners from that vertex.
    fn each_tetrahedron(&self, mut visit: impl FnMut(f64, [Vec3; 3])) {
        let apex = self.vertices[0];
        let mut look = |corners: [Vec3; 3]| {
            visit(six_volumes(&apex, &corners) / 6.0, corners.map(|p| p - apex));
        };
        match self.face_lists().byte_triangles() {
            // Nearly all bodies: without an iterator of iterators, which takes as long as the sums.
            Some(triangles) => triangles.iter().for_each(|t| look(t.map(|i| self.vertices[usize::from(i)]))),
            None => self.triangles().for_each(|t| look(t.map(|i| self.vertices[i as usize]))),
        }
    }

    /// True when the closed body has `point`; exact where the faces are plane to the last bit.
    pub fn contains(&self, point: &Vec3) -> bool {
        if !self.is_convex() {
            // A tree of all triangles takes fifty times as long as the few above the point.
            let is_above = |corners: &[Vec3; 3]| {
                let Aabb { min, max } = Aabb::around(corners);
                let around = |axis: usize| min[axis] <= point[axis] && point[axis] <= max[axis];
                around(0) && around(1) && max.z >= point.z
            };
            let few: Vec<[Vec3; 3]> =
                self.triangles().map(|t| t.map(|i| self.vertices[i as usize])).filter(is_above).collect();
            return !few.is_empty() && Triangles::new(few).contains(point);
        }
        if let Some(round) = self.round() {
            return round.contains(point);
        }
        self.faces().all(|face| {
            let [a, b, c] = [0, 1, 2].map(|k| &self.vertices[face.vertex(k) as usize]);
            orient3d(a, b, c, point) <= 0.0
        })
    }

    /// The smallest axis-aligned box around the body.
    pub fn aabb(&self) -> Aabb {
        self.form().aabb(&self.vertices)
    }

    /// The body moved by `displacement`; every coordinate is rounded once.
    pub fn translated(&self, displacement: &Vec3) -> Self {
        let moved = self.vertices.iter().map(|v| v + displacement).collect();
        Self::with_faces(moved, self.faces.clone())
    }

    /// The body turned about the origin.
    pub fn rotated(&self, rotation: &Rotation) -> Self {
        let matrix = rotation.to_rotation_matrix();
        self.mapped(|v| matrix * v)
    }

    /// Maps the vertices by `map`, which must keep the orientation, and keeps the faces. Caps become a surface like any other.
    pub fn mapped(&self, map: impl Fn(&Vec3) -> Vec3) -> Self {
        let mut faces = self.faces.clone();
        faces.role = if self.is_convex() { faces.role } else { Role::Surface { caps: 0 } };
        Self::with_faces(self.vertices.iter().map(map).collect(), faces)
    }
}

/// The vector area of a face with these corners: outward, as long as the face is large.
#[inline(always)]
fn vector_area(mut corners: impl Iterator<Item = Vec3>) -> Vec3 {
    let (mut sum, first) = (Vec3::zeros(), corners.next().unwrap_or_default());
    let mut edge = corners.next().unwrap_or_default() - first;
    for corner in corners {
        let next = corner - first;
        sum += edge.cross(&next) * 0.5;
        edge = next;
    }
    sum
}
