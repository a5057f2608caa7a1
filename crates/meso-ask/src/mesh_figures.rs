//! Figures of a mesh: its size, its phases against the exact ones, its worst elements, and doubts about its deck.

use crate::{DeckSettled, Giver};
use meso_concrete::PhaseNames;
use meso_core::Model;
use meso_core::mesh::figures::{MassScaling, QualityReport};
use meso_core::mesh::{CellKind, Mesh, MeshOptions, Notes, PhaseOff};
use serde::Serialize;

/// The figures of a mesh.
#[derive(Serialize)]
pub struct MeshFigures {
    /// Version of mesocrete.
    pub version: &'static str,
    /// Number of elements, without cohesive ones.
    pub elements: usize,
    /// Number of cohesive elements.
    pub cohesive_elements: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Volume of the specimen, mm3.
    pub specimen_volume_mm3: f64,
    /// The numbers that the bad cells have in a deck.
    pub bad_elements: Vec<usize>,
    /// Shapes of the elements, and volumes of the phases.
    pub quality: QualityReport,
    /// Mass that explicit steps need.
    pub mass_scaling: MassScaling,
    /// The inelastic strain at which mortar is at half its compressive strength in the deck.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub half_strength_strain: Option<f64>,
    /// Doubts about the deck.
    pub warnings: Vec<String>,
    /// Decisions of the mesher.
    pub notes: Notes,
    /// The options of the mesh.
    pub options: MeshOptions,
    /// Volumes of the packing's own phases, which count among the aggregates above.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub own_phases: Vec<OwnVolumes>,
    /// The phases of the mesh.
    #[serde(skip)]
    pub phases: PhaseNames,
    /// Whether the elements are voxels.
    #[serde(skip)]
    pub voxels: bool,
    /// Whether the grains are those of a label volume.
    #[serde(skip)]
    pub is_scan: bool,
    /// Whether the ITZ is a share of elements of mortar.
    #[serde(skip)]
    pub smeared: bool,
    /// Volume of the voids in the mesh and their own.
    #[serde(skip)]
    pub voids_mm3: Option<[f64; 2]>,
}

/// Volumes of a phase of the packing's own.
#[derive(Serialize)]
pub struct OwnVolumes {
    /// Its name.
    pub name: String,
    /// Volume of its elements, mm3.
    pub volume_mm3: f64,
    /// Volume of its bodies within their ITZ, as far as the mesh has one, mm3.
    pub exact_volume_mm3: Option<f64>,
}

impl OwnVolumes {
    fn all(phases: &PhaseNames, quality: &QualityReport) -> Vec<Self> {
        let of = |phase| Self {
            name: phases.name(phase).to_owned(),
            volume_mm3: quality.volumes_mm3.of(phase),
            exact_volume_mm3: quality.exact_volumes_mm3.map(|exact| exact.of(phase)),
        };
        phases.own().map(of).collect()
    }
}

impl MeshFigures {
    /// Counts the figures of the mesh of `model`.
    pub fn of(mesh: &Mesh, model: &Model, settled: &DeckSettled) -> Self {
        let DeckSettled { footing, deck, .. } = settled;
        let specimen = &model.spec.specimen;
        let quality = QualityReport::of(mesh, &model.bodies(), specimen, &deck.materials);
        Self {
            version: env!("CARGO_PKG_VERSION"),
            elements: mesh.cell_count(),
            cohesive_elements: mesh.cohesive().len(),
            nodes: mesh.points.len(),
            specimen_volume_mm3: specimen.volume(),
            bad_elements: quality.bad_cells.iter().map(|cell| cell + 1).collect(),
            mass_scaling: MassScaling::of(mesh, &deck.materials, deck.mass_scaling_step_s()),
            half_strength_strain: deck.half_strength_strain(mesh),
            warnings: deck.doubts(mesh, quality.exact_volumes_mm3.as_ref()),
            notes: mesh.notes,
            options: footing.options.for_bodies(&model.aggregates),
            own_phases: OwnVolumes::all(&mesh.phases, &quality),
            phases: mesh.phases.clone(),
            voxels: mesh.kind == CellKind::Hexahedron,
            is_scan: model.report.labels.is_some(),
            smeared: mesh.has_smeared_itz(),
            voids_mm3: quality.exact_volumes_mm3.and_then(|exact| exact.voids(mesh, specimen.volume())),
            quality,
        }
    }
}

/// Beyond this share of its exact volume a phase is off in a strict run.
const STRICT_PHASE_ERROR: f64 = 0.01;

/// The doubt about a phase that a strict run does not accept.
pub fn strict_doubt(off: Option<PhaseOff>, mesh: &Mesh, giver: Giver<'_>) -> Option<String> {
    off.filter(|off| off.is_beyond(STRICT_PHASE_ERROR)).map(|off| {
        let (phase, error) = (mesh.phases.set_name(off.phase), 100.0 * off.error());
        let strict = giver.option("strict");
        format!("{phase} has {error:+.1} % of its exact volume, where {strict} allows 1 %")
    })
}
