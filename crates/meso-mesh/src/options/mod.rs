//! Options of a mesh that is to be built: [`MeshOptions`]. Users ask for them by name, in a [`MeshTable`].

mod memory;
mod table;

pub use table::{Auto, ElementSize, MeshTable, Purpose};

use super::error::MeshError;
use meso_collision::geometry::BodyForm;
use meso_concrete::aggregate::{Aggregate, Itz, Kind, Shape, ShapeKind};
use meso_concrete::specimen::Specimen;
use meso_concrete::{Room, short};
use serde::{Deserialize, Serialize};

/// Everything that decides a mesh of a given packing; it serializes as a [`MeshTable`].
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(into = "MeshTable")]
pub struct MeshOptions {
    /// How the specimen is divided.
    pub method: Method,
    /// Edge length asked of the elements, mm; rounded so that whole elements fill the specimen.
    pub element_size_mm: f64,
    /// How the interfacial transition zone enters the mesh.
    pub itz: ItzForm,
    /// Treatment of aggregates that would share nodes.
    pub joined: Joined,
    /// Which volume the aggregates of a fitted mesh have; `None` lets the bodies decide: [`for_bodies`](Self::for_bodies).
    pub volumes: Option<Volumes>,
    /// How many elements a narrow gap between aggregates has.
    pub narrow_gaps: NarrowGaps,
}

/// The meshing methods, siblings behind one interface, each with the options that it alone has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// A regular grid of hexahedra, each of the phase of its centre.
    Voxel {
        /// Let the solid ITZ have its own thickness, even where that is less than a voxel (and the layer has holes);
        /// otherwise it is at least one voxel thick.
        thin_itz: bool,
        /// Sub-samples per voxel and axis, 1 to 8: 1 takes the phase of the centre; with n each body gets as many voxels
        /// as its samples fill, of n^3 in each, the fullest first.
        subsamples: u32,
    },
    /// Body-centred cubic tetrahedra.
    Lattice {
        /// How the lattice follows the aggregates' surfaces.
        fit: Fit,
        /// Nodes of a tetrahedron.
        order: Order,
    },
    /// Tetrahedra between the exact facets, by gmsh.
    Conforming {
        /// Nodes of a tetrahedron.
        order: Order,
        /// Parts of a specimen, other than a sphere, that gmsh fills apart, 1 to 100; `None`: as its memory needs.
        slabs: Option<u32>,
    },
}

impl Method {
    /// Voxels of the phase of their centre, the solid ITZ at least one voxel thick.
    pub const VOXEL: Self = Self::Voxel { thin_itz: false, subsamples: 1 };
    /// A lattice fitted to the surfaces, C3D4.
    pub const FITTED: Self = Self::Lattice { fit: Fit::Fitted, order: Order::Linear };
    /// A plain lattice, C3D4.
    pub const PLAIN: Self = Self::Lattice { fit: Fit::Plain, order: Order::Linear };
    /// A conforming mesh, C3D4, in as many slabs as gmsh's memory needs.
    pub const CONFORMING: Self = Self::Conforming { order: Order::Linear, slabs: None };

    /// The method without its options.
    pub fn name(self) -> MethodName {
        match self {
            Self::Voxel { .. } => MethodName::Voxel,
            Self::Lattice { .. } => MethodName::Lattice,
            Self::Conforming { .. } => MethodName::Conforming,
        }
    }

    /// Nodes of a tetrahedron; voxels are linear.
    pub fn order(self) -> Order {
        match self {
            Self::Voxel { .. } => Order::Linear,
            Self::Lattice { order, .. } | Self::Conforming { order, .. } => order,
        }
    }

    /// Whether nodes lie on the surfaces of the aggregates, which then can have their exact volumes.
    pub(super) fn follows_surfaces(self) -> bool {
        !matches!(self, Self::Voxel { .. } | Self::Lattice { fit: Fit::Plain, .. })
    }

    /// Whether edges across narrow gaps can be split: voxels stay as they are.
    fn splits_gaps(self) -> bool {
        self.name() != MethodName::Voxel
    }
}

/// A [`Method`] by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum MethodName {
    /// [`Method::Voxel`].
    #[default]
    Voxel,
    /// [`Method::Lattice`].
    Lattice,
    /// [`Method::Conforming`].
    Conforming,
}

/// How a lattice follows the aggregates' surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Fit {
    /// Nodes move onto the surfaces, and tetrahedra that cross one are cut.
    Fitted,
    /// Every tetrahedron has the phase of its centroid.
    Plain,
}

/// The order of a tetrahedron's shape functions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Four nodes, C3D4.
    Linear,
    /// A node in the middle of every edge, too, C3D10.
    Quadratic,
}

/// The ITZ in the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ItzForm {
    /// A layer of solid elements.
    Solid,
    /// Zero-thickness cohesive elements between the aggregates and what they meet.
    Cohesive,
    /// Mortar cells with a face on an aggregate are the ITZ: as stiff as mortar, and weaker. Fibres have none.
    Smeared,
    /// Not at all: aggregates bonded to the mortar.
    None,
}

impl ItzForm {
    /// The form that elements resolve by default: a solid layer, or none if the elements are thicker than the shells.
    ///
    /// Voxels and plain lattices have only whole elements. Thinner shells would come out several times too thick, at the
    /// aggregates' expense.
    pub fn carried_by(method: MethodName, fit: Fit, element_size_mm: f64, itz: &Itz) -> Self {
        let whole_elements = method == MethodName::Voxel || (method == MethodName::Lattice && fit == Fit::Plain);
        if whole_elements && element_size_mm > itz.thickness_mm[0] { Self::None } else { Self::Solid }
    }
}

/// Treatment of aggregates that share nodes, since the elements cannot resolve the gap between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Joined {
    /// They stay joined: an elastic skeleton that no analysis breaks.
    #[default]
    Keep,
    /// Mortar separates them: of the cells at a shared node those of one aggregate stay. In meshes that follow the surfaces a
    /// cohesive ITZ separates the few that are left by itself.
    Mortar,
    /// Mortar separates them after tetrahedra are cut: less of the aggregates is lost, and elements get small.
    Cut,
}

/// Which volume aggregates have in a mesh of tetrahedra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Volumes {
    /// The volume within nodes on their surfaces: less than their own, since chords cut corners off.
    #[default]
    Fitted,
    /// Their own; the nodes lie some hundredths of a millimetre off their surfaces.
    Exact,
}

/// How many elements of mortar lie between two aggregates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum NarrowGaps {
    /// One at least. A layer of one tetrahedron cannot flow aside, so it is too strong.
    #[default]
    Keep,
    /// Two at least: every edge from one aggregate to another gets a node in the middle. Voxels stay as they are.
    Split,
}

impl Default for MeshOptions {
    fn default() -> Self {
        Self {
            method: Method::VOXEL,
            element_size_mm: 2.0,
            itz: ItzForm::Solid,
            joined: Joined::Keep,
            volumes: None,
            narrow_gaps: NarrowGaps::Keep,
        }
    }
}

/// Most elements along one axis: node numbers must fit 32 bits.
const MAX_COUNT: f64 = 1500.0;
/// Most second-order elements along one axis: a lattice has 16 nodes a cube, two of them corners.
const MAX_COUNT_QUADRATIC: f64 = 600.0;
/// Most sub-samples per voxel and axis.
const MAX_SUBSAMPLES: u32 = 8;
/// Most slabs of a conforming mesh.
const MAX_SLABS: u32 = 100;

impl MeshOptions {
    /// Checks every option against its range and the specimen.
    ///
    /// # Errors
    /// Names the option, its value and what is accepted.
    pub fn validate(&self, specimen: &Specimen) -> Result<(), MeshError> {
        let size = specimen.aabb().size();
        let most = if self.method.order() == Order::Quadratic { MAX_COUNT_QUADRATIC } else { MAX_COUNT };
        let (low, high) = (size.max() / most, size.min());
        if !(self.element_size_mm >= low && self.element_size_mm <= high) {
            let accepted = format!("it must lie within {} and {high} mm for this specimen", short(low));
            return Err(MeshError::option("element_size_mm", self.element_size_mm, accepted));
        }
        match self.method {
            Method::Voxel { subsamples, .. } => validate_count("subsamples", subsamples, MAX_SUBSAMPLES)?,
            Method::Lattice { .. } | Method::Conforming { slabs: None, .. } => {}
            Method::Conforming { slabs: Some(slabs), .. } => {
                validate_count("slabs", slabs, MAX_SLABS)?;
                if slabs > 1 && matches!(specimen, Specimen::Sphere { .. }) {
                    return Err(MeshError::option("slabs", slabs, "a sphere takes 1"));
                }
            }
        }
        self.validate_order()
    }

    /// The options with the choice that the bodies decide.
    ///
    /// Chords add to stones and cut off spheres, so that aggregates other than convex polyhedra have exact volumes by default.
    pub fn for_bodies(&self, bodies: &[Aggregate]) -> Self {
        let volumes = match self.volumes {
            Some(asked) => asked,
            None if self.method.follows_surfaces() && !bodies.iter().all(is_faceted) => Volumes::Exact,
            None => Volumes::Fitted,
        };
        Self { volumes: Some(volumes), ..self.clone() }
    }

    /// Refuses a method that cannot mesh grains of a `shape`.
    ///
    /// # Errors
    /// A conforming mesh takes convex polyhedra.
    pub fn accepts_shape(&self, shape: &Shape) -> Result<(), MeshError> {
        self.accepts(is_round(shape), shape.has_dents())
    }

    /// True where all grains of a `shape` are convex polyhedra.
    pub fn are_faceted(shape: &Shape) -> bool {
        !is_round(shape) && !shape.has_dents()
    }

    /// Refuses facets where bodies are round, and plane offsets where they have dents.
    pub(super) fn accepts(&self, has_round: bool, has_dents: bool) -> Result<(), MeshError> {
        let way = match (self.method, has_round, has_dents) {
            (Method::Conforming { .. }, true, _) => {
                "spheres and ellipsoids take lattice or voxel, which follow them exactly; kind = \"rounded\" packs polyhedra"
            }
            (Method::Conforming { .. }, false, true) => {
                "aggregates with dents take lattice or voxel; shape.hull = true packs their hulls"
            }
            _ => return Ok(()),
        };
        Err(MeshError::option("method", "conforming", way))
    }

    /// The gaps between aggregates that this mesh needs; `None` if it needs none.
    ///
    /// The facets of a conforming mesh must not touch. In a test, aggregates that share nodes form a skeleton that never
    /// breaks; half an element resolves most gaps.
    pub fn room(&self, purpose: Purpose) -> Option<Room> {
        match (self.method, purpose) {
            (Method::Conforming { .. }, _) => Some(Room::Everywhere(MeshError::ADVISED_GAP_MM)),
            (_, Purpose::Test | Purpose::FirstTest) => Some(Room::Between(self.element_size_mm / 2.0)),
            (_, Purpose::Mesh) => None,
        }
    }

    /// The thickness of an aggregate's shell as a layer of solid elements, mm; 0 for none.
    pub(super) fn shell_mm(&self, aggregate: &Aggregate) -> f64 {
        match self.itz {
            ItzForm::Solid => aggregate.itz_thickness_mm,
            ItzForm::Cohesive | ItzForm::Smeared | ItzForm::None => 0.0,
        }
    }

    fn validate_order(&self) -> Result<(), MeshError> {
        // There is no cohesive element over faces of six nodes.
        if self.method.order() == Order::Quadratic && self.itz == ItzForm::Cohesive {
            return Err(MeshError::option("order", 2, "with a cohesive itz it must be 1; itz solid or none take 2"));
        }
        Ok(())
    }
}

fn validate_count(key: &'static str, count: u32, most: u32) -> Result<(), MeshError> {
    if (1..=most).contains(&count) {
        return Ok(());
    }
    Err(MeshError::option(key, count, format!("it must be 1 to {most}")))
}

/// True for an aggregate that is a convex polyhedron, and for every void and fibre.
pub(crate) fn is_faceted(body: &Aggregate) -> bool {
    body.kind != Kind::Aggregate || body.body.form() == BodyForm::Hull
}

fn is_round(shape: &Shape) -> bool {
    matches!(shape.kind, ShapeKind::Sphere | ShapeKind::Ellipsoid)
}
