//! Report on a mesh: its size, its phases against the exact ones, its worst elements; on stderr, and as JSON.

use crate::stderr;
use meso_concrete::thousands;
use meso_core::Model;
use meso_core::export::abaqus::DeckOptions;
use meso_core::mesh::figures::{MassScaling, PhaseScaling, QualityReport};
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
    mass_scaling: MassScaling,
    /// The inelastic strain at which mortar is at half its compressive strength in the deck.
    #[serde(skip_serializing_if = "Option::is_none")]
    half_strength_strain: Option<f64>,
    warnings: Vec<String>,
    notes: Notes,
    options: MeshOptions,
    #[serde(skip)]
    voxels: bool,
    #[serde(skip)]
    smeared: bool,
    /// Volume of the voids in the mesh and their own.
    #[serde(skip)]
    voids_mm3: Option<[f64; 2]>,
}

/// An ITZ beyond this multiple of its exact volume is worth a warning.
const FAR_TOO_MUCH: f64 = 1.2;
/// Error of the fibres' or the voids' volume without a warning, as a share; at half their diameter lattices were 2 % off.
const INCLUSIONS_OFF: f64 = 0.05;

/// The first few bad elements are named on stderr.
const NAMED: usize = 5;

impl MeshReport {
    pub(super) fn of(mesh: &Mesh, model: &Model, options: MeshOptions, deck: &DeckOptions) -> Self {
        let specimen = &model.spec.specimen;
        let quality = QualityReport::of(mesh, &model.bodies(), specimen, &deck.materials);
        Self {
            version: env!("CARGO_PKG_VERSION"),
            elements: mesh.cell_count(),
            cohesive_elements: mesh.cohesive().len(),
            nodes: mesh.points.len(),
            specimen_volume_mm3: specimen.volume(),
            bad_elements: quality.bad_cells.iter().map(|cell| cell + 1).collect(),
            mass_scaling: MassScaling::of(mesh, &deck.materials, deck.loading.time_increment_s),
            half_strength_strain: deck.half_strength_strain(mesh),
            warnings: deck.doubts(mesh, quality.exact_volumes_mm3.as_ref()),
            notes: mesh.notes,
            options,
            voxels: mesh.kind == CellKind::Hexahedron,
            smeared: mesh.has_smeared_itz(),
            voids_mm3: quality.exact_volumes_mm3.and_then(|exact| exact.voids(mesh, specimen.volume())),
            quality,
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
            elements => format!(" and {} cohesive ones", thousands(elements)),
        };
        let (elements, nodes) = (thousands(self.elements), thousands(self.nodes));
        let how = format!("{:?}, {} mm", self.options.method.name(), self.options.element_size_mm).to_lowercase();
        stderr::line(format!("meshed {elements} elements{cohesive}, {nodes} nodes ({how})"));
        self.volumes();
        self.thick_shells();
        self.lost_inclusions();
        let distance = &self.quality.interface_distance;
        stderr::line(format!(
            "of {} interface nodes, {} lie off the aggregates' surfaces: {:.4} mm rms over all, {:.4} mm at most",
            thousands(distance.nodes),
            thousands(distance.off),
            distance.rms_mm,
            distance.max_mm
        ));
        if distance.joined > 0 {
            stderr::line(format!(
                "of these, {} bridge a closed gap: {:.4} mm rms, {:.4} mm at most",
                thousands(distance.joined),
                distance.joined_rms_mm,
                distance.joined_max_mm
            ));
        }
        notes(&self.notes, self.cohesive_elements > 0);
        self.worst();
        self.scaled();
        self.curve();
    }

    /// A row for each phase that exists or should.
    fn volumes(&self) {
        let of_specimen = |volumes: &PhaseVolumes, phase| volumes.of(phase) / self.specimen_volume_mm3;
        stderr::line("        phase  of specimen       exact     error");
        for phase in Phase::ALL {
            let (meshed, exact) = (&self.quality.volumes_mm3, self.quality.exact_volumes_mm3.as_ref());
            // A smeared ITZ is mortar.
            let share = match phase {
                Phase::Mortar if self.smeared => of_specimen(meshed, phase) + of_specimen(meshed, Phase::Itz),
                Phase::Itz if self.smeared => 0.0,
                _ => of_specimen(meshed, phase),
            };
            let wanted = exact.map_or(f64::NAN, |exact| of_specimen(exact, phase));
            if share > 0.0 || wanted > 0.0 {
                volume_row(&phase.name().to_lowercase(), [share, wanted]);
            }
        }
        if let Some(volumes) = self.voids_mm3 {
            volume_row("void", volumes.map(|volume| volume / self.specimen_volume_mm3));
        }
        if self.smeared {
            let (itz, mortar) = (self.quality.volumes_mm3.itz, self.quality.volumes_mm3.mortar);
            stderr::line(format!("the smeared ITZ is {:.1} % of the mortar", 100.0 * itz / (itz + mortar)));
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

    /// Warns where the elements are too coarse for the fibres or the voids.
    fn lost_inclusions(&self) {
        let fibres = self.quality.exact_volumes_mm3.map(|exact| [self.quality.volumes_mm3.fibre, exact.fibre]);
        for (name, volumes) in [("fibres", fibres), ("voids", self.voids_mm3)] {
            if volumes.is_some_and(|[meshed, exact]| (meshed - exact).abs() > INCLUSIONS_OFF * exact) {
                stderr::line(format!(
                    "the elements are too coarse for the {name}: use an --element-size-mm of at most half their diameter, or \
                     --method conforming, which keeps them exactly"
                ));
            }
        }
    }

    /// Cost of explicit steps of the length asked for.
    fn scaled(&self) {
        let scaling = &self.mass_scaling;
        let phases: Vec<String> = scaling.phases.iter().map(times).collect();
        stderr::line(format!(
            "explicit steps of {:e} s take {:.2} times the mass, {:+.0} % by mass scaling ({})",
            scaling.time_step_s,
            scaling.factor,
            scaling.added_percent(),
            phases.join(", ")
        ));
    }

    /// Softening of the deck's mortar, and doubts about the deck.
    fn curve(&self) {
        if let Some(strain) = self.half_strength_strain {
            stderr::line(format!("mortar is at half its strength at an inelastic strain of {strain:.4}"));
        }
        self.warnings.iter().for_each(|doubt| stderr::line(format!("warning: {doubt}")));
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
        stderr::line(format!(
            "{} elements with an angle below {} degrees{which}",
            thousands(bad.len()),
            QualityReport::BAD_DEG
        ));
    }
}

/// A phase's share of the specimen in the mesh, and its exact one.
fn volume_row(name: &str, [share, wanted]: [f64; 2]) {
    // Rounding is no error.
    let error = (1e5 * (share / wanted - 1.0)).round() / 1e3 + 0.0;
    stderr::line(format!("  {name:>11}  {share:>11.5}  {wanted:>10.5}  {error:>+7.3}%"));
}

/// A phase and the factor of its mass.
fn times(phase: &PhaseScaling) -> String {
    format!("{} x {:.2}", phase.phase.to_lowercase(), phase.factor)
}

/// Decisions of the builder: gaps closed, layers thinned.
fn notes(notes: &Notes, parted_by_itz: bool) {
    gaps_between_aggregates(notes, parted_by_itz);
    if notes.split_gap_edges > 0 {
        let edges = thousands(notes.split_gap_edges);
        stderr::line(format!(
            "{edges} edges from one aggregate to another got a node in the middle: --narrow-gaps keep leaves them"
        ));
    }
    if notes.closed_side_gaps > 0 {
        stderr::line(format!(
            "gaps that the elements cannot show: {} nodes join {} aggregates to the specimen's sides (widest {:.4} mm); to keep \
             mortar there, use a larger wall_gap_mm",
            thousands(notes.closed_side_gaps),
            thousands(notes.closed_side_gap_aggregates),
            notes.widest_closed_side_gap_mm
        ));
    }
    if notes.off_surface_nodes > 0 {
        let nodes = thousands(notes.off_surface_nodes);
        stderr::line(format!(
            "{nodes} nodes could not be projected onto their surface with angles of 8 degrees, mostly in gaps to the specimen's \
             sides or on periodic faces"
        ));
    }
    if notes.thinned_itz_aggregates + notes.thinned_itz_nodes > 0 {
        stderr::line(format!(
            "the ITZ is thinner than asked in {} aggregates and at {} nodes; at {} of these it has no thickness",
            thousands(notes.thinned_itz_aggregates),
            thousands(notes.thinned_itz_nodes),
            thousands(notes.pinched_itz_nodes)
        ));
    }
    if notes.shifted_itz_nodes > 0 {
        let nodes = thousands(notes.shifted_itz_nodes);
        stderr::line(format!("{nodes} inner nodes of the ITZ left its exact thickness to avoid sharp angles"));
    }
}

fn gaps_between_aggregates(notes: &Notes, parted_by_itz: bool) {
    if notes.parted_nodes > 0 {
        stderr::line(format!(
            "{} pairs of aggregates would have been joined at {} nodes, since the elements cannot show the gaps between them: \
             mortar parts them now, {:.0} mm3 of it in place of aggregates; a larger min_gap_mm or a smaller --element-size-mm \
             keeps these",
            thousands(notes.parted_pairs),
            thousands(notes.parted_nodes),
            notes.parted_mm3
        ));
    } else if notes.closed_gaps > 0 && parted_by_itz {
        stderr::line(format!(
            "at {} nodes {} pairs of aggregates meet, since the elements cannot show the gaps between them (widest {:.2} mm): \
             cohesive elements part them",
            thousands(notes.closed_gaps),
            thousands(notes.closed_gap_pairs),
            notes.widest_closed_gap_mm
        ));
    } else if notes.closed_gaps > 0 {
        stderr::line(format!(
            "gaps that the elements cannot show: {} nodes join {} pairs of aggregates (widest {:.2} mm); to keep mortar there, use \
             a smaller --element-size-mm or a larger min_gap_mm",
            thousands(notes.closed_gaps),
            thousands(notes.closed_gap_pairs),
            notes.widest_closed_gap_mm
        ));
    }
}
