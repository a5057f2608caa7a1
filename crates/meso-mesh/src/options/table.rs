//! Options of a mesh as users ask for them: flat, by name, most of them absent.

use super::{
    Fit, ItzForm, Joined, MAX_SLABS, MAX_SUBSAMPLES, MeshOptions, Method, MethodName, NarrowGaps, Order, Volumes,
    validate_count,
};
use crate::error::MeshError;
use meso_concrete::aggregate::Itz;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

/// Options of a mesh, as `mesh`, `Packing.mesh` and a study take them. Leave out the options of other methods.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct MeshTable {
    /// Method of meshing [default: voxel; for a test lattice]
    pub method: Option<MethodName>,
    /// Edge length of the elements, mm, or auto: the largest of some sizes that keeps every phase within 5 % on a small cube
    /// of the packing. It is rounded so that whole elements fill the specimen [default: 2; for a test without a model 4]
    pub element_size_mm: Option<ElementSize>,
    /// Interfacial transition zone in the mesh [default: solid, or none where the elements are thicker than it; for a test
    /// smeared]
    pub itz: Option<ItzForm>,
    /// Treatment of aggregates that would share nodes [default: keep; for a test mortar]
    pub joined: Option<Joined>,
    /// Volume of the aggregates in a mesh that follows them [default: exact for grains other than convex polyhedra, and for a
    /// test without a solid ITZ; else fitted]
    pub volumes: Option<Volumes>,
    /// Gaps one tetrahedron wide between aggregates [default: keep; for a test of a model split]
    pub narrow_gaps: Option<NarrowGaps>,
    /// Let the ITZ of voxels be thinner than one voxel, with holes in it
    pub thin_itz: Option<bool>,
    /// Sub-samples per voxel and axis, 1 to 8 [default: 1]; with more than 1 each body gets as many voxels as its samples fill
    pub subsamples: Option<u32>,
    /// Fit of a lattice to the aggregates' surfaces [default: fitted]
    pub fit: Option<Fit>,
    /// Order of the elements [default: 1]; 2 puts a node in the middle of every edge of a tetrahedron (C3D10)
    pub order: Option<u32>,
    /// Number of slabs that gmsh fills one by one; absent: as many as its memory needs
    pub slabs: Option<u32>,
}

/// Edge length of the elements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(inline))]
#[serde(untagged, expecting = "a number or auto")]
pub enum ElementSize {
    /// Length, mm.
    Mm(f64),
    /// The largest of some sizes that keeps the phases of the packing at hand.
    Tried(Auto),
}

/// The word `auto`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema), schemars(inline))]
#[serde(rename_all = "kebab-case")]
pub enum Auto {
    /// Sizes are tried.
    Auto,
}

/// Use of a mesh: it decides the options that are not asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Purpose {
    /// A mesh without an analysis: voxels, with a solid ITZ if they resolve it.
    #[default]
    Mesh,
    /// A test, by a deck with an analysis or by the solver. The lattice has smooth interfaces, no skeleton of joined
    /// aggregates, exact phase volumes, and narrow gaps in which mortar can flow.
    Test,
    /// The first test of a user who names no specimen: larger elements, so that it takes minutes.
    FirstTest,
}

impl Purpose {
    /// Usual options; an absent ITZ follows from the elements.
    fn usual(self) -> MeshTable {
        let usual = MeshTable::from(MeshOptions::default());
        let test = || MeshTable {
            method: Some(MethodName::Lattice),
            itz: Some(ItzForm::Smeared),
            joined: Some(Joined::Mortar),
            volumes: Some(Volumes::Exact),
            narrow_gaps: Some(NarrowGaps::Split),
            ..usual.clone()
        };
        match self {
            Self::Mesh => MeshTable { itz: None, ..usual },
            Self::Test => test(),
            Self::FirstTest => {
                MeshTable { element_size_mm: Some(ElementSize::Mm(4.0)), narrow_gaps: Some(NarrowGaps::Keep), ..test() }
            }
        }
    }
}

impl MeshTable {
    /// The options of a mesh for `purpose`, of aggregates with the shells `itz`.
    ///
    /// # Errors
    /// Names an option that is out of its range, or that has no effect on this mesh.
    pub fn resolve(&self, purpose: Purpose, itz: &Itz) -> Result<MeshOptions, MeshError> {
        let usual = MeshOptions::default();
        let asked = self.clone().or(purpose.usual());
        let method = asked.method.unwrap_or(usual.method.name());
        let element_size_mm = match asked.element_size_mm {
            Some(ElementSize::Mm(size)) => size,
            Some(ElementSize::Tried(_)) => {
                return Err(MeshError::option("element_size_mm", "auto", "give a number here"));
            }
            None => usual.element_size_mm,
        };
        let (fit, order) = (self.fit.unwrap_or(Fit::Fitted), order(self.order.unwrap_or(1), method)?);
        let (thin_itz, subsamples) = (self.thin_itz.unwrap_or(false), self.subsamples.unwrap_or(1));
        validate_count("subsamples", subsamples, MAX_SUBSAMPLES)?;
        self.slabs.map_or(Ok(()), |slabs| validate_count("slabs", slabs, MAX_SLABS))?;
        let resolved =
            |thin| if thin { ItzForm::Solid } else { ItzForm::carried_by(method, fit, element_size_mm, itz) };
        let itz = asked.itz.unwrap_or_else(|| resolved(thin_itz));
        let method = match method {
            MethodName::Voxel => Method::Voxel { thin_itz, subsamples },
            MethodName::Lattice => Method::Lattice { fit, order },
            MethodName::Conforming => Method::Conforming { order, slabs: self.slabs },
        };
        self.refuse_idle(method, itz)?;
        Ok(MeshOptions {
            method,
            element_size_mm,
            itz,
            joined: asked.joined.unwrap_or_default(),
            // A layer keeps its outer side on the surfaces of convex polyhedra, whatever the use, unless it is asked for.
            volumes: match itz {
                _ if !method.follows_surfaces() => Some(Volumes::Fitted),
                ItzForm::Solid => self.volumes,
                ItzForm::Cohesive | ItzForm::Smeared | ItzForm::None => asked.volumes,
            },
            narrow_gaps: asked.narrow_gaps.filter(|_| method.splits_gaps()).unwrap_or_default(),
        })
    }

    /// Whether the size of the elements is to be tried.
    pub fn is_auto(&self) -> bool {
        matches!(self.element_size_mm, Some(ElementSize::Tried(_)))
    }

    /// The table with the size that `auto` means, or without one; a size in mm stays.
    #[must_use]
    pub fn with_tried(self, size_mm: Option<f64>) -> Self {
        let element_size_mm = if self.is_auto() { size_mm.map(ElementSize::Mm) } else { self.element_size_mm };
        Self { element_size_mm, ..self }
    }

    /// The options of this table, and of `usual` if they are absent here; those of one method stay absent.
    fn or(self, usual: Self) -> Self {
        Self {
            method: self.method.or(usual.method),
            element_size_mm: self.element_size_mm.or(usual.element_size_mm),
            itz: self.itz.or(usual.itz),
            joined: self.joined.or(usual.joined),
            volumes: self.volumes.or(usual.volumes),
            narrow_gaps: self.narrow_gaps.or(usual.narrow_gaps),
            ..self
        }
    }

    /// Refuses options without effect. A value that asks for nothing, as in a table that was written, is accepted.
    fn refuse_idle(&self, method: Method, itz: ItzForm) -> Result<(), MeshError> {
        let is_voxel = method.name() == MethodName::Voxel;
        let idle = [
            (
                method.name() == MethodName::Lattice,
                asked("fit", self.fit, Fit::Fitted),
                "only the method lattice takes it",
            ),
            (is_voxel, asked("thin_itz", self.thin_itz, false), "only the method voxel takes it"),
            (itz == ItzForm::Solid, asked("thin_itz", self.thin_itz, false), "only the itz solid takes it"),
            (is_voxel, asked("subsamples", self.subsamples, 1), "only the method voxel takes it"),
            (
                method.name() == MethodName::Conforming,
                self.slabs.map(|slabs| ("slabs", slabs.to_string())),
                "only the method conforming takes it",
            ),
            (
                method.follows_surfaces(),
                asked("volumes", self.volumes, Volumes::Fitted),
                "only the method conforming and a fitted lattice take it",
            ),
            (
                method.splits_gaps(),
                asked("narrow_gaps", self.narrow_gaps, NarrowGaps::Keep),
                "only the methods lattice and conforming take it",
            ),
        ];
        let idle = idle.into_iter().filter(|(has_effect, ..)| !has_effect);
        match idle.filter_map(|(_, asked, accepted)| Some((asked?, accepted))).next() {
            Some(((key, value), accepted)) => Err(MeshError::option(key, value, accepted)),
            None => Ok(()),
        }
    }
}

/// An option that is asked for something, by name, with the value as users write it.
fn asked<T: PartialEq + Debug>(key: &'static str, given: Option<T>, nothing: T) -> Option<(&'static str, String)> {
    given.filter(|value| *value != nothing).map(|value| (key, written(&value)))
}

fn written(value: &impl Debug) -> String {
    format!("{value:?}").to_lowercase()
}

fn order(order: u32, method: MethodName) -> Result<Order, MeshError> {
    match (order, method) {
        (1, _) => Ok(Order::Linear),
        (2, MethodName::Voxel) => {
            Err(MeshError::option("order", 2, "voxels take 1; the methods lattice and conforming take 2"))
        }
        (2, _) => Ok(Order::Quadratic),
        _ => Err(MeshError::option("order", order, "it must be 1 or 2")),
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
        Self {
            method: Some(method.name()),
            element_size_mm: Some(ElementSize::Mm(element_size_mm)),
            itz: Some(itz),
            joined: Some(joined),
            volumes,
            narrow_gaps: Some(narrow_gaps),
            thin_itz: Some(thin_itz),
            subsamples: Some(subsamples),
            fit: Some(fit),
            order: Some(order),
            slabs,
        }
    }
}

impl MeshOptions {
    /// The options by name, in the order of a command line. Options of one method are absent if they ask for nothing.
    pub fn named(&self) -> Vec<(&'static str, String)> {
        let table = MeshTable::from(self.clone());
        let shared = [
            ("method", written(&self.method.name())),
            ("element_size_mm", self.element_size_mm.to_string()),
            ("itz", written(&self.itz)),
            ("joined", written(&self.joined)),
        ];
        let volumes = self.volumes.map(|volumes| ("volumes", written(&volumes)));
        let narrow_gaps = [("narrow_gaps", written(&self.narrow_gaps))];
        let own = [
            asked("fit", table.fit, Fit::Fitted),
            asked("order", table.order, 1),
            asked("thin_itz", table.thin_itz, false),
            asked("subsamples", table.subsamples, 1),
            table.slabs.map(|slabs| ("slabs", slabs.to_string())),
        ];
        shared.into_iter().chain(volumes).chain(narrow_gaps).chain(own.into_iter().flatten()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(table: &MeshTable, purpose: Purpose) -> Result<MeshOptions, String> {
        table.resolve(purpose, &Itz::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn a_table_that_was_written_gives_its_options_again() {
        for method in [Method::VOXEL, Method::FITTED, Method::PLAIN, Method::CONFORMING] {
            for purpose in [Purpose::Mesh, Purpose::Test, Purpose::FirstTest] {
                let (method, fit) = (Some(method.name()), (method == Method::PLAIN).then_some(Fit::Plain));
                let options = resolved(&MeshTable { method, fit, ..MeshTable::default() }, purpose).unwrap();
                assert_eq!(resolved(&options.clone().into(), Purpose::Mesh), Ok(options.clone()));
                assert_eq!(resolved(&options.clone().into(), Purpose::Test), Ok(options));
            }
        }
    }

    #[test]
    fn an_option_without_effect_is_refused_and_its_usual_value_is_not() {
        let table = |method| MeshTable { method: Some(method), ..MeshTable::default() };
        let (voxel, lattice) = (table(MethodName::Voxel), table(MethodName::Lattice));
        let exact = Some(Volumes::Exact);
        for (asked, said) in [
            (MeshTable { fit: Some(Fit::Plain), ..voxel.clone() }, "mesh.fit is plain; only the method lattice"),
            (
                MeshTable { narrow_gaps: Some(NarrowGaps::Split), ..voxel.clone() },
                "mesh.narrow_gaps is split; only the",
            ),
            (MeshTable { volumes: exact, ..voxel.clone() }, "mesh.volumes is exact; only the method conforming and"),
            (MeshTable { volumes: exact, fit: Some(Fit::Plain), ..lattice.clone() }, "mesh.volumes is exact; only"),
            (MeshTable { thin_itz: Some(true), ..lattice.clone() }, "mesh.thin_itz is true; only the method voxel"),
            (
                MeshTable { thin_itz: Some(true), itz: Some(ItzForm::None), ..voxel.clone() },
                "mesh.thin_itz is true; only the itz solid takes it",
            ),
            (MeshTable { subsamples: Some(2), ..lattice.clone() }, "mesh.subsamples is 2; only the method voxel"),
            (MeshTable { slabs: Some(1), ..lattice.clone() }, "mesh.slabs is 1; only the method conforming takes it"),
        ] {
            let error = resolved(&asked, Purpose::Mesh).unwrap_err();
            assert!(error.starts_with(said), "{error}");
        }
        let usual = MeshTable { thin_itz: Some(false), subsamples: Some(1), volumes: Some(Volumes::Fitted), ..lattice };
        assert!(resolved(&usual, Purpose::Test).is_ok());
        let options = resolved(&voxel, Purpose::Test).unwrap();
        assert_eq!((options.volumes, options.narrow_gaps), (Some(Volumes::Fitted), NarrowGaps::Keep));
    }
}
