//! A user's own grains: convex polyhedra and closed surfaces with dents, scaled to the size that is asked for.

use meso_collision::dents::SelfCrossing;
use meso_collision::geometry::{
    HullError, MassProperties, Polyhedron, SurfaceError, TriangleMesh, convex_hull, principal_axes,
};
use meso_collision::math::{Aabb, Mat3, Vec3, longest_distance};
use serde::de::value::{MapAccessDeserializer, SeqAccessDeserializer};
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::f64::consts::PI;
use std::fmt;

/// One grain of a library, of any size: the vertices of a convex polyhedron, or a closed surface of triangles, mm.
///
/// In a spec it is the list of its vertices, or `{ vertices, faces, reduced }`: with faces where it has dents, and with what a
/// reduction changed where there was one.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    /// What was changed where it is a scan in fewer triangles.
    pub reduced: Option<Reduction>,
    vertices: Vec<Vec3>,
    /// Triangles of a surface with dents; none where the grain is the hull of its vertices.
    triangles: Vec<[u32; 3]>,
    /// Corners scaled to size 1 and turned to the principal axes.
    unit: Vec<Vec3>,
    dents: Option<Dents>,
}

/// What changed when a scan was reduced to fewer triangles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Reduction {
    /// Triangles of the scan, or of its hull where that was taken.
    pub scanned_triangles: usize,
    /// Triangles that are left.
    pub triangles: usize,
    /// The surfaces lie within this distance of each other, over the length of the grain.
    pub distance: f64,
    /// Change of the volume, over that of the scan, or of its hull.
    pub volume_change: f64,
}

/// A grain with dents whose longest distance of two vertices is 1, along its principal axes about a point inside of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Dents {
    /// The closed surface.
    pub body: Polyhedron,
    /// Side of the smallest square hole that it passes.
    pub sieve_size: f64,
}

/// Why a surface is no grain.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TemplateError {
    /// Vertices that span no volume.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// A surface that encloses no volume.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// More triangles than every copy of a grain may have.
    #[error(
        "it has {triangles} triangles, and a grain may have up to {MOST_TRIANGLES}; raise shape.tolerance, or take its hull by shape.hull = true"
    )]
    TooMany {
        /// Number of triangles.
        triangles: usize,
    },
    /// A surface of more than one part.
    #[error("its surface has {parts} parts; a grain has one, without a hollow")]
    Parts {
        /// Number of connected parts.
        parts: usize,
    },
    /// A surface that crosses itself.
    #[error("its surface crosses itself near {at:?}; shape.hull = true takes its hull")]
    Crosses {
        /// A corner of one of the triangles that cross, mm.
        at: [f64; 3],
    },
}

/// Most triangles of a grain: thousands of copies of it are packed.
const MOST_TRIANGLES: usize = 20_000;
/// The centre of mass stays the centre where it is at least this share as deep as the deepest point found.
const DEEP: f64 = 0.5;

impl Template {
    /// The hull of `vertices` (mm).
    ///
    /// # Errors
    /// Where they have no solid hull.
    pub fn new(vertices: Vec<Vec3>) -> Result<Self, HullError> {
        let body = convex_hull(&vertices)?;
        let mass = body.mass_properties();
        let axes = principal_axes(&mass.inertia);
        let length = longest_distance(body.vertices());
        let along = |v: &Vec3| axes.transpose() * (v - mass.centroid) / length;
        let unit = body.vertices().iter().map(along).collect();
        Ok(Self { reduced: None, unit, vertices, triangles: Vec::new(), dents: None })
    }

    /// The grain inside a closed surface of any shape.
    ///
    /// # Errors
    /// See [`TemplateError`].
    pub fn of_surface(mesh: TriangleMesh) -> Result<Self, TemplateError> {
        if mesh.triangles.len() > MOST_TRIANGLES {
            return Err(TemplateError::TooMany { triangles: mesh.triangles.len() });
        }
        mesh.check_closed()?;
        let facets = mesh.facets();
        if let Some([first, _]) = (SelfCrossing { mesh: &mesh, facets: &facets }).find() {
            return Err(TemplateError::Crosses { at: first[0].into() });
        }
        let parts = mesh.components().len();
        if parts > 1 {
            return Err(TemplateError::Parts { parts });
        }
        let dents = Dents::new(&mesh)?;
        let TriangleMesh { vertices, triangles } = mesh;
        Ok(Self { reduced: None, unit: dents.body.vertices().to_vec(), vertices, triangles, dents: Some(dents) })
    }

    /// The surface of a grain with dents.
    pub fn dents(&self) -> Option<&Dents> {
        self.dents.as_ref()
    }

    /// Corners as given, mm.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Volume over the cube of the longest distance between two vertices.
    pub fn relative_volume(&self) -> f64 {
        match &self.dents {
            Some(dents) => dents.body.volume(),
            None => convex_hull(&self.unit).map_or(0.0, |body| body.volume()),
        }
    }

    /// Extent along the shortest principal axis, for a longest distance of 1.
    pub fn thickness(&self) -> f64 {
        Aabb::around(&self.unit).size().min()
    }

    /// Volume, surface and mean width over all directions, of the hull, for a longest distance of 1.
    pub fn measures(&self) -> (f64, f64, f64) {
        convex_hull(&self.unit).map_or((0.0, 0.0, 0.0), |body| (body.volume(), body.area(), mean_width(&self.unit)))
    }

    /// The vertices along its principal axes with `length` mm between the two that are farthest apart.
    pub(super) fn scaled_to(&self, length: f64) -> Vec<Vec3> {
        self.unit.iter().map(|vertex| vertex * length).collect()
    }
}

impl Dents {
    fn new(mesh: &TriangleMesh) -> Result<Self, HullError> {
        let length = longest_distance(mesh.hull()?.vertices());
        let given = Polyhedron::of_surface(mesh);
        let MassProperties { centroid, inertia, .. } = given.mass_properties();
        let skin = given.skin(0.0);
        let (deepest, depth) = skin.deepest();
        // A ring's centre of mass lies outside of it.
        let centre = if skin.depth(&centroid) >= DEEP * depth { centroid } else { deepest };
        let turn = right_handed(principal_axes(&inertia)).transpose();
        let body = given.mapped(|v| turn * (v - centre) / length);
        Ok(Self { sieve_size: body.sieve_size(), body })
    }
}

/// The axes with the last one turned round where they would mirror a surface and so turn it inside out.
fn right_handed(mut axes: Mat3) -> Mat3 {
    if axes.determinant() < 0.0 {
        axes.column_mut(2).neg_mut();
    }
    axes
}

/// Directions that the mean width is taken over: 1e-3 of a needle's, and less of all others, depend on them.
const DIRECTIONS: usize = 500;

/// The extent of `vertices`, averaged over directions spread evenly (a Fibonacci lattice).
fn mean_width(vertices: &[Vec3]) -> f64 {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let width = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / DIRECTIONS as f64;
        let ((sine, cosine), radius) = (libm::sincos(golden * i as f64), (1.0 - z * z).sqrt());
        let direction = Vec3::new(radius * cosine, radius * sine, z);
        let heights = vertices.iter().map(|vertex| vertex.dot(&direction));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        high - low
    };
    (0..DIRECTIONS).map(width).sum::<f64>() / DIRECTIONS as f64
}

impl Serialize for Template {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let rows = self.vertices.iter().map(|v| <[f64; 3]>::from(*v));
        if self.triangles.is_empty() && self.reduced.is_none() {
            return serializer.collect_seq(rows);
        }
        GrainTable { vertices: rows.collect(), faces: self.triangles.clone(), reduced: self.reduced }
            .serialize(serializer)
    }
}

/// A grain with dents, or a reduced one, as it stands in a spec.
#[derive(Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct GrainTable {
    /// Corners, mm.
    vertices: Vec<[f64; 3]>,
    /// Triangles of the surface, counter-clockwise seen from outside; none where the grain is the hull of its vertices.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    faces: Vec<[u32; 3]>,
    /// What was changed where it is a scan in fewer triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reduced: Option<Reduction>,
}

/// Reads both forms of a grain, each with its own errors.
struct EitherForm;

impl<'de> Visitor<'de> for EitherForm {
    type Value = Template;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list of vertices, or a table of vertices and faces")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, list: S) -> Result<Template, S::Error> {
        let rows = Vec::<[f64; 3]>::deserialize(SeqAccessDeserializer::new(list))?;
        Template::new(rows.into_iter().map(Vec3::from).collect()).map_err(S::Error::custom)
    }

    fn visit_map<M: MapAccess<'de>>(self, table: M) -> Result<Template, M::Error> {
        let GrainTable { vertices, faces, reduced } = GrainTable::deserialize(MapAccessDeserializer::new(table))?;
        if let Some(corner) = faces.iter().flatten().find(|&&corner| corner as usize >= vertices.len()) {
            return Err(M::Error::custom(format!("a face names vertex {corner} of {}", vertices.len())));
        }
        let vertices = vertices.into_iter().map(Vec3::from).collect();
        let template = match faces.is_empty() {
            true => Template::new(vertices).map_err(M::Error::custom),
            false => Template::of_surface(TriangleMesh { vertices, triangles: faces }).map_err(M::Error::custom),
        };
        Ok(Template { reduced, ..template? })
    }
}

impl<'de> Deserialize<'de> for Template {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(EitherForm)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Template {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Template".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let forms = [generator.subschema_for::<Vec<[f64; 3]>>(), generator.subschema_for::<GrainTable>()];
        schemars::json_schema!({ "anyOf": forms })
    }
}
