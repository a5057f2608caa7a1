//! Report on a mesh: its size, its phases against the exact ones, its worst elements; on stderr, and as JSON.

use crate::stderr;
use meso_core::Model;
use meso_core::materials::Materials;
use meso_core::mesh::quality::{BAD_DEG, QualityReport};
use meso_core::mesh::{CellKind, Mesh, MeshOptions, Notes, Phase, PhaseVolumes};
use serde::Serialize;
use std::io::{self, Write};

/// The figures of a mesh.
#[derive(Serialize)]
pub(super) struct MeshReport {
    version: &'static str,
    elements: usize,
    cohesive_elements: usize,
    nodes: usize,
    specimen_volume_mm3: f64,
    /// The numbers that the bad cells have in a deck.
    bad_elements: Vec<usize>,
    quality: QualityReport,
    notes: Notes,
    options: MeshOptions,
    #[serde(skip)]
    voxels: bool,
}

/// An ITZ beyond this multiple of its exact volume is worth a warning.
const FAR_TOO_MUCH: f64 = 1.2;
/// Error of the fibres' volume without a warning, as a share; at half their diameter lattices were 2 % off.
const FIBRES_OFF: f64 = 0.05;

/// The first few bad elements are named on stderr.
const NAMED: usize = 5;

impl MeshReport {
    pub(super) fn of(mesh: &Mesh, model: &Model, options: MeshOptions, materials: &Materials) -> Self {
        let specimen = &model.spec.specimen;
        let quality = QualityReport::of(mesh, &model.bodies(), specimen, materials);
        Self {
            version: env!("CARGO_PKG_VERSION"),
            elements: mesh.cell_count(),
            cohesive_elements: mesh.cohesive().len(),
            nodes: mesh.points.len(),
            specimen_volume_mm3: specimen.volume(),
            bad_elements: quality.bad_cells.iter().map(|cell| cell + 1).collect(),
            quality,
            notes: mesh.notes,
            options,
            voxels: mesh.kind == CellKind::Hexahedron,
        }
    }

    /// Writes all figures as JSON.
    pub(super) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        writeln!(out)
    }

    /// Prints most of it on stderr.
    pub(super) fn print(&self) {
        let cohesive = match self.cohesive_elements {
            0 => String::new(),
            elements => format!(" and {} cohesive ones", stderr::thousands(elements)),
        };
        let (elements, nodes) = (stderr::thousands(self.elements), stderr::thousands(self.nodes));
        let how = format!("{:?}, {} mm", self.options.method.name(), self.options.element_size_mm).to_lowercase();
        stderr::line(format!("meshed {elements} elements{cohesive}, {nodes} nodes ({how})"));
        self.volumes();
        self.thick_shells();
        self.lost_fibres();
        let distance = &self.quality.interface_distance;
        stderr::line(format!(
            "of {} interface nodes, {} lie off the aggregates' surfaces: {:.4} mm rms over all, {:.4} mm at most",
            stderr::thousands(distance.nodes),
            stderr::thousands(distance.off),
            distance.rms_mm,
            distance.max_mm
        ));
        if distance.joined > 0 {
            stderr::line(format!(
                "of these, {} bridge a closed gap: {:.4} mm rms, {:.4} mm at most",
                stderr::thousands(distance.joined),
                distance.joined_rms_mm,
                distance.joined_max_mm
            ));
        }
        notes(&self.notes);
        self.worst();
    }

    /// A row for each phase that exists or should.
    fn volumes(&self) {
        let of_specimen = |volumes: &PhaseVolumes, phase| volumes.of(phase) / self.specimen_volume_mm3;
        stderr::line("        phase  of specimen       exact     error");
        for phase in Phase::ALL {
            let (meshed, exact) = (&self.quality.volumes_mm3, self.quality.exact_volumes_mm3.as_ref());
            let share = of_specimen(meshed, phase);
            let wanted = exact.map_or(f64::NAN, |exact| of_specimen(exact, phase));
            if share > 0.0 || wanted > 0.0 {
                // Rounding is no error.
                let error = (1e5 * (share / wanted - 1.0)).round() / 1e3 + 0.0;
                stderr::line(format!(
                    "  {:>11}  {share:>11.5}  {wanted:>10.5}  {error:>+7.3}%",
                    phase.name().to_lowercase()
                ));
            }
        }
    }

    /// Warns where the shells are far from their own thickness, as voxels at least a layer thick make them.
    fn thick_shells(&self) {
        let Some(exact) = self.quality.exact_volumes_mm3 else { return };
        if self.voxels && exact.itz > 0.0 && self.quality.volumes_mm3.itz > FAR_TOO_MUCH * exact.itz {
            stderr::line(
                "the ITZ is at least one voxel thick here, at the aggregates' expense: use --method lattice, --itz cohesive \
                 or none, or --thin-itz",
            );
        }
    }

    /// Warns where the elements are too coarse for the fibres.
    fn lost_fibres(&self) {
        let Some(exact) = self.quality.exact_volumes_mm3 else { return };
        if (self.quality.volumes_mm3.fibre - exact.fibre).abs() > FIBRES_OFF * exact.fibre {
            stderr::line(
                "the elements are too coarse for the fibres: use an --element-size-mm of at most half their diameter, or \
                 --method conforming, which keeps them exactly",
            );
        }
    }

    fn worst(&self) {
        let quality = &self.quality;
        let (altitude, cell) = quality.shortest_altitude_mm;
        stderr::line(format!(
            "shortest altitude {altitude:.4} mm (element {}): a stable time step of {:.1e} s",
            cell + 1,
            quality.stable_time_step_s
        ));
        if let Some(step) = quality.cohesive_time_step_s {
            stderr::line(format!("the cohesive elements allow {step:.1e} s, by their stiffness"));
        }
        if self.voxels {
            return;
        }
        let ((angle, sharpest), (ratio, flattest)) = (quality.min_dihedral_deg, quality.min_radius_ratio);
        let (sharpest, flattest) = (sharpest + 1, flattest + 1);
        stderr::line(format!(
            "smallest dihedral angle {angle:.2} degrees (element {sharpest}), radius ratio {ratio:.4} (element {flattest})"
        ));
        let bad = &self.bad_elements;
        let named: Vec<String> = bad.iter().take(NAMED).map(usize::to_string).collect();
        let more = if bad.len() > NAMED { ", ...; --summary-json of `mesocrete mesh` names all" } else { "" };
        let which = if bad.is_empty() { String::new() } else { format!(" (elements {}{more})", named.join(", ")) };
        stderr::line(format!("{} elements with an angle below {BAD_DEG} degrees{which}", stderr::thousands(bad.len())));
    }
}

/// Decisions of the builder: gaps closed, layers thinned.
fn notes(notes: &Notes) {
    if notes.closed_gaps > 0 {
        stderr::line(format!(
            "gaps that the elements cannot show: {} nodes join {} pairs of aggregates (widest {:.2} mm); to keep mortar there, use \
             a smaller --element-size-mm or a larger min_gap_mm",
            stderr::thousands(notes.closed_gaps),
            stderr::thousands(notes.closed_gap_pairs),
            notes.widest_closed_gap_mm
        ));
    }
    if notes.closed_side_gaps > 0 {
        stderr::line(format!(
            "gaps that the elements cannot show: {} nodes join {} aggregates to the specimen's sides (widest {:.4} mm); to keep \
             mortar there, use a larger wall_gap_mm",
            stderr::thousands(notes.closed_side_gaps),
            stderr::thousands(notes.closed_side_gap_aggregates),
            notes.widest_closed_side_gap_mm
        ));
    }
    if notes.off_surface_nodes > 0 {
        let nodes = stderr::thousands(notes.off_surface_nodes);
        stderr::line(format!(
            "{nodes} nodes could not be projected onto their surface with angles of 8 degrees, mostly in gaps to the specimen's \
             sides or on periodic faces"
        ));
    }
    if notes.thinned_itz_aggregates + notes.thinned_itz_nodes > 0 {
        stderr::line(format!(
            "the ITZ is thinner than asked in {} aggregates and at {} nodes; at {} of these it has no thickness",
            stderr::thousands(notes.thinned_itz_aggregates),
            stderr::thousands(notes.thinned_itz_nodes),
            stderr::thousands(notes.pinched_itz_nodes)
        ));
    }
    if notes.shifted_itz_nodes > 0 {
        let nodes = stderr::thousands(notes.shifted_itz_nodes);
        stderr::line(format!("{nodes} inner nodes of the ITZ left its exact thickness to avoid sharp angles"));
    }
}
