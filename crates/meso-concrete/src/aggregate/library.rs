//! A user's own grains: convex polyhedra, scaled to the size that is asked for.

use meso_collision::geometry::{HullError, convex_hull, principal_axes};
use meso_collision::math::{Vec3, longest_distance};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::f64::consts::PI;

/// One grain of a library, of any size: the vertices of a convex polyhedron, mm.
///
/// In a spec it is the list of its vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    vertices: Vec<Vec3>,
    /// Corners scaled to size 1 and turned to the principal axes.
    unit: Vec<Vec3>,
}

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
        Ok(Self { unit: body.vertices().iter().map(along).collect(), vertices })
    }

    /// Corners as given, mm.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Volume over the cube of the longest distance between two vertices.
    pub fn relative_volume(&self) -> f64 {
        convex_hull(&self.unit).map_or(0.0, |body| body.volume())
    }

    /// Volume, surface and mean width over all directions, for a longest distance of 1.
    pub fn measures(&self) -> (f64, f64, f64) {
        convex_hull(&self.unit).map_or((0.0, 0.0, 0.0), |body| (body.volume(), body.area(), mean_width(&self.unit)))
    }

    /// The vertices along its principal axes with `length` mm between the two that are farthest apart.
    pub(super) fn scaled_to(&self, length: f64) -> Vec<Vec3> {
        self.unit.iter().map(|vertex| vertex * length).collect()
    }
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
        serializer.collect_seq(self.vertices.iter().map(|v| <[f64; 3]>::from(*v)))
    }
}

impl<'de> Deserialize<'de> for Template {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows = Vec::<[f64; 3]>::deserialize(deserializer)?;
        Self::new(rows.into_iter().map(Vec3::from).collect()).map_err(serde::de::Error::custom)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Template {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Template".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        generator.subschema_for::<Vec<[f64; 3]>>()
    }
}
