//! Random aggregates: the paper's polyhedra (Sec. 2.1, Fig. 1), and the other shapes users ask for.

use super::library::{Dents, Template};
use super::random::Stream;
use super::{AspectRatio, ShellLaw};
use meso_collision::geometry::ellipsoid::Ellipsoid;
use meso_collision::math::{Aabb, Vec3, longest_distance};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Shape of the aggregates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Shape {
    /// Which kind of body.
    pub kind: ShapeKind,
    /// Fewest and most vertices; of no meaning for a library, spheres and ellipsoids.
    pub vertices: [u32; 2],
    /// Law of b/a, the intermediate over the longest axis; of no meaning for a library and spheres.
    pub elongation: AspectRatio,
    /// Law of c/b, the shortest over the intermediate axis; of no meaning for a library and spheres.
    pub flatness: AspectRatio,
    /// The grains of a library.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub grains: Vec<Template>,
    /// Shells below the ITZ, from outside; a phase each.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shells: Vec<ShellLaw>,
}

/// Kinds of grains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ShapeKind {
    /// The paper's: the six ends of an ellipsoid's axes and random points on it.
    #[default]
    Polyhedron,
    /// Gravel: points spread evenly over an ellipsoid, so that the polyhedron is nearly as round as it.
    Rounded,
    /// Crushed rock: few, sharp corners, at random depths.
    Crushed,
    /// Exact balls.
    Sphere,
    /// Exact ellipsoids.
    Ellipsoid,
    /// A user's own grains, drawn at random and scaled.
    Library,
}

/// The default laws are illustrative: the paper takes its ratios from measurements it does not print. Means of 0.75
/// put the average grain near Zingg's limits of 2/3 on the equant side, as crushed rock mostly is.
impl Default for Shape {
    fn default() -> Self {
        let ratio = AspectRatio::Normal { mean: 0.75, sd: 0.1, min: 0.4, max: 1.0 };
        let kind = ShapeKind::default();
        Self {
            kind,
            vertices: kind.usual_vertices(),
            elongation: ratio,
            flatness: ratio,
            grains: Vec::new(),
            shells: Vec::new(),
        }
    }
}

impl ShapeKind {
    /// Fewest and most vertices where nothing is said.
    pub fn usual_vertices(self) -> [u32; 2] {
        match self {
            Self::Polyhedron | Self::Library | Self::Sphere | Self::Ellipsoid => [20, 30],
            Self::Rounded => [80, 80],
            Self::Crushed => [10, 16],
        }
    }

    /// Volume of the grain over its ellipsoid's, with the usual number of vertices: 0.55 to 0.65 for the paper's.
    pub fn mean_hull_over_ellipsoid(self) -> f64 {
        match self {
            Self::Polyhedron | Self::Library => 0.6,
            Self::Rounded => 0.9,
            Self::Crushed => 0.62,
            Self::Sphere | Self::Ellipsoid => 1.0,
        }
    }

    /// Fewest vertices that make such a grain: the ends of the three axes, or corners all around.
    pub fn fewest_vertices(self) -> u32 {
        match self {
            Self::Polyhedron | Self::Library | Self::Sphere | Self::Ellipsoid => 6,
            Self::Rounded | Self::Crushed => 8,
        }
    }
}

/// Fixed vertices on the axes (Sec. 2.1).
const AXIS_VERTICES: usize = 6;
/// Redraws of one vertex that comes too near to another; then the last draw is kept. At the default spacing of
/// 0.2 mm on a 5 mm grain about one draw in a hundred is refused.
const SPACING_DRAWS: usize = 100;
/// Directions drawn for each corner that is spread; the one farthest from the others is taken (Mitchell 1991). With 4
/// the corners of crushed rock stay irregular, with 12 gravel is round.
const CRUSHED_DRAWS: usize = 4;
const ROUNDED_DRAWS: usize = 12;
/// Corners of crushed rock lie at this share of the ellipsoid's radius, up to all of it.
const LEAST_DEPTH: f64 = 0.75;

/// Outline of a grain along its own axes, about a point inside of it.
#[derive(Clone, Debug)]
pub enum Outline<'a> {
    /// Vertices of a convex polyhedron, mm.
    Hull(Vec<Vec3>),
    /// A surface with dents, of length 1, and its number in the library.
    Dents(u32, &'a Dents),
    /// A ball or an ellipsoid, by its semi-axes, mm.
    Round(Vec3),
}

impl Shape {
    /// True where a grain of the library has dents.
    pub fn has_dents(&self) -> bool {
        self.grains.iter().any(|grain| grain.dents().is_some())
    }

    /// True where a shell lies around the stones that the grading asks for.
    pub fn has_coatings(&self) -> bool {
        self.shells.iter().any(|law| law.outward)
    }

    /// True where volumes below a depth are exact in all grains, which they are not with dents and in ellipsoids.
    pub fn has_exact_cores(&self) -> bool {
        self.kind != ShapeKind::Ellipsoid && !self.has_dents()
    }

    /// Draws the outline of a grain whose longest axis 2a is `length` mm.
    ///
    /// `class_limit / vertex count` (mm) is the least spacing of the paper's random vertices.
    pub fn outline(&self, length: f64, class_limit: f64, stream: &mut Stream) -> Outline<'_> {
        if self.kind == ShapeKind::Library {
            let number = stream.integer(0, self.grains.len() as u32 - 1);
            let grain = &self.grains[number as usize];
            let hull = || Outline::Hull(grain.scaled_to(length));
            return grain.dents().map_or_else(hull, |dents| Outline::Dents(number, dents));
        }
        match self.kind {
            ShapeKind::Sphere => Outline::Round(Vec3::repeat(length / 2.0)),
            ShapeKind::Ellipsoid => Outline::Round(self.ellipsoid(length, stream).semi_axes),
            _ => Outline::Hull(self.random_outline(length, class_limit, stream)),
        }
    }

    fn random_outline(&self, length: f64, class_limit: f64, stream: &mut Stream) -> Vec<Vec3> {
        let ellipsoid = self.ellipsoid(length, stream);
        let count = stream.integer(self.vertices[0], self.vertices[1]) as usize;
        match self.kind {
            ShapeKind::Rounded => rounded(&ellipsoid, count, stream),
            ShapeKind::Crushed => crushed(&ellipsoid, count, stream),
            _ => polyhedron(&ellipsoid, count, class_limit / count as f64, stream),
        }
    }

    fn ellipsoid(&self, length: f64, stream: &mut Stream) -> Ellipsoid {
        let a = length / 2.0;
        let b = a * self.elongation.draw(stream);
        let c = b * self.flatness.draw(stream);
        Ellipsoid { semi_axes: Vec3::new(a, b, c) }
    }
}

/// The six axis ends, then points of uniform longitude and polar angle that keep `spacing` mm between each other.
fn polyhedron(ellipsoid: &Ellipsoid, count: usize, spacing: f64, stream: &mut Stream) -> Vec<Vec3> {
    let mut vertices = axis_vertices(ellipsoid);
    while vertices.len() < count {
        let vertex = spaced_vertex(ellipsoid, &vertices, spacing, stream);
        vertices.push(vertex);
    }
    vertices
}

fn axis_vertices(ellipsoid: &Ellipsoid) -> Vec<Vec3> {
    let mut vertices = Vec::with_capacity(32);
    for axis in 0..AXIS_VERTICES / 2 {
        let end = Vec3::ith(axis, ellipsoid.semi_axes[axis]);
        vertices.extend([-end, end]);
    }
    vertices
}

fn spaced_vertex(ellipsoid: &Ellipsoid, others: &[Vec3], spacing: f64, stream: &mut Stream) -> Vec3 {
    let mut vertex = Vec3::zeros();
    for _ in 0..SPACING_DRAWS {
        vertex = ellipsoid.point(stream.uniform(0.0, TAU), stream.uniform(0.0, PI));
        if others.iter().all(|other| (vertex - other).norm_squared() >= spacing * spacing) {
            break;
        }
    }
    vertex
}

/// The axis ends, so that the longest axis is as long as asked for, and directions spread evenly.
fn rounded(ellipsoid: &Ellipsoid, count: usize, stream: &mut Stream) -> Vec<Vec3> {
    let mut directions: Vec<Vec3> = axis_vertices(&Ellipsoid { semi_axes: Vec3::repeat(1.0) });
    spread(&mut directions, count, ROUNDED_DRAWS, stream);
    directions.iter().map(|d| d.component_mul(&ellipsoid.semi_axes)).collect()
}

/// Spread directions at random depths, stretched to the ratios of the axes, then until the longest distance is 2a.
fn crushed(ellipsoid: &Ellipsoid, count: usize, stream: &mut Stream) -> Vec<Vec3> {
    let mut corners = Vec::with_capacity(count);
    spread(&mut corners, count, CRUSHED_DRAWS, stream);
    corners.iter_mut().for_each(|corner| *corner *= stream.uniform(LEAST_DEPTH, 1.0));
    let size = Aabb::around(&corners).size();
    let stretch = (ellipsoid.semi_axes * 2.0).component_div(&size);
    let middle = corners.iter().sum::<Vec3>() / count as f64;
    corners.iter_mut().for_each(|corner| *corner = (*corner - middle).component_mul(&stretch));
    let scale = 2.0 * ellipsoid.semi_axes.x / longest_distance(&corners);
    corners.iter().map(|corner| corner * scale).collect()
}

/// Adds unit directions up to `count`, each the one of `draws` that is farthest from all others.
fn spread(directions: &mut Vec<Vec3>, count: usize, draws: usize, stream: &mut Stream) {
    while directions.len() < count {
        let mut best = (f64::INFINITY, Vec3::zeros());
        for _ in 0..draws {
            let direction = stream.direction();
            let nearest = directions.iter().map(|other| other.dot(&direction)).fold(-1.0, f64::max);
            best = if nearest < best.0 { (nearest, direction) } else { best };
        }
        directions.push(best.1);
    }
}
