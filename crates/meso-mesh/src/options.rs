//! Options of a mesh: [`MeshOptions`], and the flat table of names that users write ([`MeshTable`]).

use super::error::MeshError;
use meso_concrete::aggregate::{Aggregate, Itz};
use meso_concrete::specimen::Specimen;
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
    /// Which volume the aggregates of a fitted mesh have.
    pub volumes: Volumes,
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
}

/// A [`Method`] by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum MethodName {
    /// [`Method::Voxel`].
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
    /// The form that elements can show without more being asked for: a solid layer, or none where the elements are too
    /// coarse for it.
    ///
    /// Voxels and plain lattices have whole elements alone. Shells thinner than one would come out several times too
    /// thick, at the aggregates' expense.
    pub fn carried_by(method: MethodName, fit: Fit, element_size_mm: f64, itz: &Itz) -> Self {
        let whole_elements = method == MethodName::Voxel || (method == MethodName::Lattice && fit == Fit::Plain);
        if whole_elements && element_size_mm > itz.thickness_mm[0] { Self::None } else { Self::Solid }
    }
}

/// Treatment of aggregates that share nodes, since the elements cannot show the gap between them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Joined {
    /// They stay joined: an elastic skeleton that no analysis breaks.
    #[default]
    Keep,
    /// Mortar parts them: of the cells at a shared node those of one aggregate stay. In meshes that follow the surfaces a
    /// cohesive ITZ parts the few that are left by itself.
    Mortar,
    /// The same with tetrahedra that are cut first: less of the aggregates is lost, and elements get small.
    Cut,
}

/// Which volume aggregates have in a mesh of tetrahedra.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Volumes {
    /// That of the mesh with its nodes on their surfaces: less than their own, since chords cut corners off.
    #[default]
    Fitted,
    /// Their own; the nodes lie some hundredths of a millimetre off their surfaces. Not with a solid ITZ.
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
            volumes: Volumes::Fitted,
            narrow_gaps: NarrowGaps::Keep,
        }
    }
}

/// Most elements along one axis: node numbers must fit 32 bits.
const MAX_COUNT: f64 = 1500.0;
/// The same for second-order elements: a lattice has 16 nodes a cube, two of them corners.
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
            let accepted = format!("it must lie within {low} and {high} mm for this specimen");
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

/// [`MeshOptions`] as a flat table, as Python's keywords and `--summary-json` have them. What only another method has must
/// keep its default.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct MeshTable {
    /// As [`MeshOptions::method`].
    pub method: MethodName,
    /// As [`MeshOptions::element_size_mm`].
    pub element_size_mm: f64,
    /// As [`MeshOptions::itz`]; absent: what the elements can show, see [`ItzForm::carried_by`].
    pub itz: Option<ItzForm>,
    /// As [`MeshOptions::joined`].
    pub joined: Joined,
    /// As [`MeshOptions::volumes`].
    pub volumes: Volumes,
    /// As [`MeshOptions::narrow_gaps`].
    pub narrow_gaps: NarrowGaps,
    /// Voxels alone.
    pub thin_itz: bool,
    /// Voxels alone.
    pub subsamples: u32,
    /// Lattices alone.
    pub fit: Fit,
    /// 1 or 2; voxels take 1.
    pub order: u32,
    /// Conforming meshes alone.
    pub slabs: Option<u32>,
}

#[expect(clippy::derivable_impls, reason = "the defaults are those of the options, not of the types")]
impl Default for MeshTable {
    fn default() -> Self {
        Self { itz: None, ..MeshOptions::default().into() }
    }
}

impl From<MeshOptions> for MeshTable {
    fn from(options: MeshOptions) -> Self {
        let MeshOptions { method, element_size_mm, itz, joined, volumes, narrow_gaps } = options;
        let order = if method.order() == Order::Quadratic { 2 } else { 1 };
        let (mut thin_itz, mut subsamples, mut fit, mut slabs) = (false, 1, Fit::Fitted, None);
        match method {
            Method::Voxel { thin_itz: thin, subsamples: samples } => (thin_itz, subsamples) = (thin, samples),
            Method::Lattice { fit: own, .. } => fit = own,
            Method::Conforming { slabs: own, .. } => slabs = own,
        }
        let (method, itz) = (method.name(), Some(itz));
        Self { method, element_size_mm, itz, joined, volumes, narrow_gaps, thin_itz, subsamples, fit, order, slabs }
    }
}

impl TryFrom<MeshTable> for MeshOptions {
    type Error = MeshError;

    /// # Errors
    /// Names an option that belongs to another method, and an order that no element has.
    fn try_from(table: MeshTable) -> Result<Self, MeshError> {
        table.refuse_foreign()?;
        let order = table.order()?;
        let MeshTable { element_size_mm, itz, joined, volumes, narrow_gaps, thin_itz, subsamples, fit, slabs, .. } =
            table;
        let method = match table.method {
            MethodName::Voxel => Method::Voxel { thin_itz, subsamples },
            MethodName::Lattice => Method::Lattice { fit, order },
            MethodName::Conforming => Method::Conforming { order, slabs },
        };
        Ok(Self { method, element_size_mm, itz: itz.unwrap_or(ItzForm::Solid), joined, volumes, narrow_gaps })
    }
}

impl MeshTable {
    /// The defaults of a test, in a deck with an analysis and in the solver alike: interfaces without steps, no skeleton of
    /// joined aggregates, phases of their own volumes, gaps in which mortar can flow, and an ITZ that costs no small steps.
    pub fn of_a_test() -> Self {
        Self {
            method: MethodName::Lattice,
            itz: Some(ItzForm::Smeared),
            joined: Joined::Mortar,
            volumes: Volumes::Exact,
            narrow_gaps: NarrowGaps::Split,
            ..Self::default()
        }
    }

    /// The options that this table gives to a method which does not have them: name, value and that method.
    pub fn foreign(&self) -> impl Iterator<Item = (&'static str, String, MethodName)> {
        let slabs = self.slabs.map_or_else(String::new, |slabs| slabs.to_string());
        let fit = format!("{:?}", self.fit).to_lowercase();
        let all = [
            ("fit", self.fit != Fit::Fitted, fit, MethodName::Lattice),
            ("thin_itz", self.thin_itz, self.thin_itz.to_string(), MethodName::Voxel),
            ("subsamples", self.subsamples != 1, self.subsamples.to_string(), MethodName::Voxel),
            ("slabs", self.slabs.is_some(), slabs, MethodName::Conforming),
        ];
        let method = self.method;
        let foreign = all.into_iter().filter(move |(_, given, _, of)| *given && *of != method);
        foreign.map(|(key, _, value, of)| (key, value, of))
    }

    /// Checks the ranges of the options that only one method has, whether or not it is this one.
    ///
    /// # Errors
    /// Names the option, its value and what is accepted.
    pub fn validate_ranges(&self) -> Result<(), MeshError> {
        validate_count("subsamples", self.subsamples, MAX_SUBSAMPLES)?;
        self.slabs.map_or(Ok(()), |slabs| validate_count("slabs", slabs, MAX_SLABS))
    }

    /// The same table with the form of the ITZ that its elements can show, where it names none.
    #[must_use]
    pub fn with_itz_for(self, itz: &Itz) -> Self {
        let carried = match self.thin_itz {
            true => ItzForm::Solid,
            false => ItzForm::carried_by(self.method, self.fit, self.element_size_mm, itz),
        };
        Self { itz: Some(self.itz.unwrap_or(carried)), ..self }
    }

    /// The same table without the options of other methods.
    #[must_use]
    pub fn without_foreign(mut self) -> Self {
        let usual = Self::default();
        if self.method != MethodName::Voxel {
            (self.thin_itz, self.subsamples) = (usual.thin_itz, usual.subsamples);
        }
        if self.method != MethodName::Lattice {
            self.fit = usual.fit;
        }
        if self.method != MethodName::Conforming {
            self.slabs = usual.slabs;
        }
        self
    }

    fn refuse_foreign(&self) -> Result<(), MeshError> {
        let Some((key, value, of)) = self.foreign().next() else { return Ok(()) };
        let accepted = format!("only the method {} takes it", format!("{of:?}").to_lowercase());
        Err(MeshError::option(key, value, accepted))
    }

    fn order(&self) -> Result<Order, MeshError> {
        match (self.order, self.method) {
            (1, _) => Ok(Order::Linear),
            (2, MethodName::Voxel) => {
                Err(MeshError::option("order", 2, "voxels take 1; the methods lattice and conforming take 2"))
            }
            (2, _) => Ok(Order::Quadratic),
            _ => Err(MeshError::option("order", self.order, "it must be 1 or 2")),
        }
    }
}
