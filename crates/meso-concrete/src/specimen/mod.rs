//! Specimens that a spec may name, and the container of each.
//!
//! [`Specimen`] is the spec's view, a few lengths or coordinates. [`Specimen::container`] turns it into a
//! [`Container`]: one file per kind behind one small interface.

mod box_minus_convex;
mod container;
mod convex;
mod cuboid;
mod cylinder;
mod dogbone;
mod largest;
mod notched;
mod period;
mod profile;
mod sphere;
mod triangulated;

pub use container::Obstacle;
pub use container::{Container, Surface};
pub use largest::Largest;
pub use period::{Period, Periodic};

use super::watch::{Silent, Stage, Waiting};
use convex::Convex;
use cuboid::Cuboid;
use cylinder::Cylinder;
use dogbone::Dogbone;
use meso_collision::geometry::{HullError, SurfaceError, TriangleMesh};
use meso_collision::math::{Aabb, Vec3};
use serde::{Deserialize, Serialize};
use sphere::Sphere;
use std::fmt;
use std::sync::{Arc, OnceLock};
use triangulated::Triangulated;

/// A specimen; its frame has the origin at the lowest corner of its bounding box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Specimen {
    /// A cube from the origin.
    Cube {
        /// Side, mm.
        side_mm: f64,
        /// The axes along which it repeats itself; it has no walls across them.
        #[serde(default, skip_serializing_if = "Periodic::is_none")]
        periodic: Periodic,
    },
    /// A box from the origin.
    Box {
        /// Edge lengths along x, y, z, mm.
        size_mm: [f64; 3],
        /// The axes along which it repeats itself; it has no walls across them.
        #[serde(default, skip_serializing_if = "Periodic::is_none")]
        periodic: Periodic,
    },
    /// A box as beams are named: the length along x, the width along y, the depth upwards.
    Prism {
        /// Along x, mm.
        length_mm: f64,
        /// Along y, mm.
        width_mm: f64,
        /// Along z, mm.
        depth_mm: f64,
    },
    /// An upright cylinder: its axis is parallel to z.
    Cylinder {
        /// Diameter, mm.
        diameter_mm: f64,
        /// Along z, mm.
        height_mm: f64,
    },
    /// A sphere.
    Sphere {
        /// Diameter, mm.
        diameter_mm: f64,
    },
    /// A prism with a notch sawn into its lower side, across its width, and perhaps one into its upper side.
    NotchedPrism {
        /// Along x, mm.
        length_mm: f64,
        /// Along y, mm.
        width_mm: f64,
        /// Along z, the notch's included, mm.
        depth_mm: f64,
        /// Depth of the notch, from z = 0 upwards, mm.
        notch_depth_mm: f64,
        /// Width of the notch, along x, mm.
        notch_width_mm: f64,
        /// Depth of a second notch above it, from the upper side downwards, mm; 0 for none.
        #[serde(default, skip_serializing_if = "is_zero")]
        upper_notch_depth_mm: f64,
        /// Place of both notches along x, mm from the middle of the length.
        #[serde(default, skip_serializing_if = "is_zero")]
        notch_at_mm: f64,
    },
    /// A plate that narrows in round arcs to a neck in the middle of its length.
    Dogbone {
        /// Along x, mm.
        length_mm: f64,
        /// Along y, at the ends, mm.
        width_mm: f64,
        /// Along z, mm.
        thickness_mm: f64,
        /// Narrowest width, mm.
        neck_width_mm: f64,
        /// Length of the part that is as narrow as the neck, mm; 0 where the arcs meet in the middle.
        #[serde(default)]
        neck_length_mm: f64,
        /// Radius of the arcs, mm; they are polygons within 0.005 mm.
        radius_mm: f64,
    },
    /// The convex hull of points, moved to the origin.
    Polyhedron {
        /// Four points or more, mm.
        vertices_mm: Vec<[f64; 3]>,
    },
    /// The region that a closed surface of triangles encloses, moved to the origin; in a spec, `file` may name
    /// a surface file (STL, PLY, OBJ, OFF) instead.
    Mesh {
        /// Corners, mm.
        vertices_mm: Vec<[f64; 3]>,
        /// Indices of corners, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
        /// The container built from them.
        #[serde(skip)]
        built: Built,
    },
}

/// A container that takes seconds to build for a large surface: built once, and shared by copies of the specimen.
#[derive(Clone, Default)]
pub struct Built {
    container: Arc<OnceLock<Arc<dyn Container>>>,
    volume: Arc<OnceLock<f64>>,
    /// [`fingerprint`] of the surface that was found sound.
    checked: Arc<OnceLock<u64>>,
}

impl fmt::Debug for Built {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.container.get().is_some() { "Built" } else { "NotBuilt" })
    }
}

/// It follows from the corners and triangles, which are compared.
impl PartialEq for Built {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Why lengths or points enclose no volume.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ContainerError {
    /// Points without a hull.
    #[error(transparent)]
    Hull(#[from] HullError),
    /// Triangles that are not closed.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// A triangle with a corner that is not there.
    #[error("triangle {triangle} names corner {corner}; there are {corners}, counted from 0")]
    Corner {
        /// Which triangle, from 0.
        triangle: usize,
        /// The corner that it names.
        corner: u32,
        /// How many there are.
        corners: usize,
    },
    /// Triangles that cross each other.
    #[error("its surface crosses itself near ({}, {}, {})", at[0], at[1], at[2])]
    Crossing {
        /// A corner of one of the two triangles, mm, in the frame of the spec.
        at: [f64; 3],
    },
    /// The time limit came first.
    #[error(
        "{:.0} % of its {triangles} triangles were; allow more time, or simplify the surface", 100.0 * share
    )]
    Late {
        /// How many triangles it has.
        triangles: usize,
        /// Share of them that is proved, 0 to 1.
        share: f64,
    },
    /// A component of the surface that is nested the wrong way.
    #[error(
        "a component of its surface, at ({}, {}, {}), is nested the wrong way: it bounds a volume inside another's, or a \
         hollow outside all others; reverse its triangles, or remove it",
        at[0], at[1], at[2]
    )]
    Nested {
        /// A corner of the component, mm, in the frame of the spec.
        at: [f64; 3],
    },
}

impl Default for Specimen {
    fn default() -> Self {
        Self::cube(150.0)
    }
}

impl Specimen {
    /// A cube with walls on all sides; `side_mm` in mm.
    pub fn cube(side_mm: f64) -> Self {
        Self::Cube { side_mm, periodic: Periodic::NONE }
    }

    /// A box with walls on all sides; edge lengths in mm.
    pub fn cuboid(size_mm: [f64; 3]) -> Self {
        Self::Box { size_mm, periodic: Periodic::NONE }
    }

    /// The name the spec gives it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Cube { .. } => "cube",
            Self::Box { .. } => "box",
            Self::Prism { .. } => "prism",
            Self::Cylinder { .. } => "cylinder",
            Self::Sphere { .. } => "sphere",
            Self::NotchedPrism { .. } => "notched-prism",
            Self::Dogbone { .. } => "dogbone",
            Self::Polyhedron { .. } => "polyhedron",
            Self::Mesh { .. } => "mesh",
        }
    }

    /// The axes along which it repeats itself.
    pub fn periodic(&self) -> Periodic {
        match *self {
            Self::Cube { periodic, .. } | Self::Box { periodic, .. } => periodic,
            _ => Periodic::NONE,
        }
    }

    /// The lengths after which it repeats itself.
    pub fn period(&self) -> Period {
        let size = match *self {
            Self::Cube { side_mm, .. } => [side_mm; 3],
            Self::Box { size_mm, .. } => size_mm,
            _ => [0.0; 3],
        };
        Period::new(&Vec3::from(size), self.periodic())
    }

    /// The container of this specimen.
    ///
    /// # Errors
    /// Points or triangles that enclose no volume. Crossing triangles are not detected: see [`Specimen::check`].
    pub fn build(&self) -> Result<Box<dyn Container>, ContainerError> {
        Ok(match self {
            Self::Cube { side_mm, periodic } => Box::new(Cuboid::new([*side_mm; 3], *periodic)),
            Self::Box { size_mm, periodic } => Box::new(Cuboid::new(*size_mm, *periodic)),
            &Self::Prism { length_mm, width_mm, depth_mm } => {
                Box::new(Cuboid::new([length_mm, width_mm, depth_mm], Periodic::NONE))
            }
            &Self::Cylinder { diameter_mm, height_mm } => Box::new(Cylinder::new(diameter_mm, height_mm)),
            &Self::Sphere { diameter_mm } => Box::new(Sphere::new(diameter_mm)),
            &Self::NotchedPrism {
                length_mm,
                width_mm,
                depth_mm,
                notch_depth_mm,
                notch_width_mm,
                upper_notch_depth_mm,
                notch_at_mm,
            } => {
                let depths = [notch_depth_mm, upper_notch_depth_mm];
                let middle = 0.5 * length_mm + notch_at_mm;
                Box::new(notched::container([length_mm, width_mm, depth_mm], depths, notch_width_mm, middle)?)
            }
            Self::Dogbone { .. } => Box::new(self.dogbone().container()?),
            Self::Polyhedron { vertices_mm } => Box::new(Convex::hull(vertices_mm)?),
            Self::Mesh { vertices_mm, triangles, .. } => convex_or(Triangulated::new(surface(vertices_mm, triangles)?)),
        })
    }

    /// Builds the container like [`Specimen::build`], and refuses triangles that cross each other and components nested
    /// in others.
    ///
    /// # Errors
    /// See [`ContainerError`].
    pub fn check(&self) -> Result<Arc<dyn Container>, ContainerError> {
        self.check_while(Waiting { watch: &Silent, deadline: f64::INFINITY })
    }

    /// Checks like [`Specimen::check`], reports to a watch, and ends at its deadline.
    pub fn check_while(&self, waiting: Waiting<'_>) -> Result<Arc<dyn Container>, ContainerError> {
        let Self::Mesh { vertices_mm, triangles, built } = self else { return Ok(self.build()?.into()) };
        let fingerprint = fingerprint(vertices_mm, triangles);
        if let (Some(checked), Some(container)) = (built.checked.get(), built.container.get())
            && *checked == fingerprint
        {
            return Ok(Arc::clone(container));
        }
        if waiting.is_over_at(READ) {
            return Err(ContainerError::Late { triangles: triangles.len(), share: 0.0 });
        }
        let closed = Triangulated::new(surface(vertices_mm, triangles)?);
        if let Some([triangle, _]) = closed.crossing(waiting)? {
            return Err(ContainerError::Crossing { at: as_given(vertices_mm, &triangle[0]) });
        }
        if let Some(corner) = closed.nested() {
            return Err(ContainerError::Nested { at: as_given(vertices_mm, &corner) });
        }
        built.checked.get_or_init(|| fingerprint);
        let container = built.container.get_or_init(|| convex_or(closed).into());
        waiting.watch.stage(Stage::Read, 1.0);
        Ok(Arc::clone(container))
    }

    /// Position of the specimen's origin in the frame of its vertices, mm, where that is not the origin: the lowest corner.
    pub fn origin(&self) -> Option<[f64; 3]> {
        let (Self::Polyhedron { vertices_mm } | Self::Mesh { vertices_mm, .. }) = self else { return None };
        let low = vertices_mm.iter().copied().reduce(|low, p| [0, 1, 2].map(|axis| low[axis].min(p[axis])))?;
        low.iter().any(|x| *x != 0.0).then_some(low)
    }

    /// How long each arc of a dog-bone is along its length, mm; `None` for other kinds and for arcs that cannot be.
    pub fn arc_run(&self) -> Option<f64> {
        matches!(self, Self::Dogbone { .. }).then(|| self.dogbone().run()).filter(|run| run.is_finite())
    }

    fn dogbone(&self) -> Dogbone {
        let &Self::Dogbone { length_mm, width_mm, thickness_mm, neck_width_mm, neck_length_mm, radius_mm } = self
        else {
            unreachable!("asked of dog-bones alone")
        };
        Dogbone {
            length: length_mm,
            width: width_mm,
            thickness: thickness_mm,
            neck: neck_width_mm,
            neck_length: neck_length_mm,
            radius: radius_mm,
        }
    }

    /// The container of a specimen that its spec's `validate` accepts.
    ///
    /// # Panics
    /// Where [`Specimen::build`] fails.
    pub fn container(&self) -> Arc<dyn Container> {
        let build = || self.build().expect("an accepted specimen encloses a volume").into();
        match self {
            Self::Mesh { built, .. } => Arc::clone(built.container.get_or_init(build)),
            _ => build(),
        }
    }

    /// Bounding box of the specimen, mm.
    pub fn aabb(&self) -> Aabb {
        match self {
            // The container of a large surface takes long to build, where it is not yet there.
            Self::Mesh { vertices_mm, .. } => Aabb::around(&at_origin(vertices_mm)),
            _ => self.container().aabb(),
        }
    }

    /// Volume of the specimen, mm3.
    pub fn volume(&self) -> f64 {
        match self {
            Self::Mesh { vertices_mm, triangles, built } => {
                *built.volume.get_or_init(|| unchecked(vertices_mm, triangles).volume())
            }
            _ => self.container().volume(),
        }
    }
}

/// Hash of a surface. A surface that a spec checks several times is proved once. The turn carries the sign of a
/// coordinate, its highest bit, on to others.
fn fingerprint(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> u64 {
    let corners = vertices.iter().flatten().map(|x| x.to_bits());
    let words = corners.chain(triangles.iter().flatten().map(|&index| u64::from(index)));
    words.fold(0, |hash: u64, word| (hash.rotate_left(23) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

/// Share of the stage that is over when the proof of a surface begins; see [`Triangulated::crossing`].
const READ: f64 = 0.25;

/// A closed surface that lacks no more than this share of its hull's volume is its hull.
const CONVEX: f64 = 1e-12;

/// The container within a closed surface. A convex one is packed as a polyhedron, which is denser and faster.
fn convex_or(closed: Triangulated) -> Box<dyn Container> {
    match closed.hull() {
        Ok(hull) if closed.volume() >= (1.0 - CONVEX) * hull.volume() => Box::new(Convex::new(hull)),
        _ => Box::new(closed),
    }
}

fn surface(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> Result<TriangleMesh, ContainerError> {
    let corners = vertices.len();
    for (triangle, indices) in triangles.iter().enumerate() {
        if let Some(&corner) = indices.iter().find(|&&corner| corner as usize >= corners) {
            return Err(ContainerError::Corner { triangle, corner, corners });
        }
    }
    let mesh = unchecked(vertices, triangles);
    if let Err(error) = mesh.check_closed() {
        // Open edges are located where the user knows them.
        let given = vertices.iter().map(|p| Vec3::from(*p)).collect();
        TriangleMesh { vertices: given, triangles: mesh.triangles }.check_edges()?;
        return Err(error.into());
    }
    Ok(mesh)
}

fn unchecked(vertices: &[[f64; 3]], triangles: &[[u32; 3]]) -> TriangleMesh {
    TriangleMesh { vertices: at_origin(vertices), triangles: triangles.to_vec() }
}

/// The position in the spec of a corner that was moved to the specimen's frame.
fn as_given(vertices: &[[f64; 3]], corner: &Vec3) -> [f64; 3] {
    let place = at_origin(vertices).iter().position(|vertex| vertex == corner);
    place.map_or((*corner).into(), |place| vertices[place])
}

/// Whether a length is left out of a file.
fn is_zero(length_mm: &f64) -> bool {
    *length_mm == 0.0
}

/// The points moved so that the lowest corner of their bounding box is the origin.
fn at_origin(points: &[[f64; 3]]) -> Vec<Vec3> {
    let points: Vec<Vec3> = points.iter().map(|p| Vec3::from(*p)).collect();
    let origin = Aabb::around(&points).min;
    points.iter().map(|p| p - origin).collect()
}
