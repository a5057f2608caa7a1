//! A user's own grains: convex polyhedra, scaled to the size that is asked for.

use crate::geometry::{HullError, convex_hull, principal_axes};
use crate::math::{Vec3, longest_distance};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// One grain of a library, of any size: the vertices of a convex polyhedron, mm.
///
/// In a spec it is the list of its vertices.
#[derive(Clone, Debug, PartialEq)]
pub struct Template {
    vertices: Vec<Vec3>,
    /// The same of size 1, along its principal axes.
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

    /// As given, mm.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// Volume over the cube of the longest distance between two vertices.
    pub fn relative_volume(&self) -> f64 {
        convex_hull(&self.unit).map_or(0.0, |body| body.volume())
    }

    /// The vertices along its principal axes with `length` mm between the two that are farthest apart.
    pub(super) fn scaled_to(&self, length: f64) -> Vec<Vec3> {
        self.unit.iter().map(|vertex| vertex * length).collect()
    }
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
