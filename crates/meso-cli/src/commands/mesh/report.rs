//! Report on a mesh: its size, its phases against the exact ones, its worst elements; on stderr, and as JSON.

use crate::stderr::{self, flag};
use meso_ask::{DeckSettled, Giver, MeshFigures};
use meso_concrete::{exceeds, thousands};
use meso_core::Model;
use meso_core::mesh::figures::{PhaseScaling, QualityReport};
use meso_core::mesh::{Mesh, Notes, Phase, PhaseVolumes};
use serde::Serialize;
use std::io::{self, Write};

/// The figures of a mesh, to be printed.
#[derive(Serialize)]
pub(super) struct MeshReport(MeshFigures);

/// An ITZ beyond this multiple of its exact volume is worth a warning.
const FAR_TOO_MUCH: f64 = 1.2;
/// Error of the fibres' or the voids' volume without a warning, as a share; at half their diameter lattices were 2 % off.
const INCLUSIONS_OFF: f64 = 0.05;

/// The first few bad elements are named on stderr.
const NAMED: usize = 5;

impl MeshReport {
    pub(super) fn of(mesh: &Mesh, model: &Model, settled: &DeckSettled) -> Self {
        Self(MeshFigures::of(mesh, model, settled))
    }

    /// Writes all figures as JSON.
    pub(super) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *out, self)?;
        writeln!(out)
    }

    /// Prints the size of the mesh, its errors and what to do about them on stderr.
    pub(super) fn brief(&self) {
        let shares = self.shares().into_iter();
        let errors: Vec<String> = shares.map(|(name, share)| format!("{name} {:+.3} %", percent_off(share))).collect();
        stderr::line(format!("{}; volumes: {}", self.size(), errors.join(", ")));
        self.thick_shells();
        self.lost_inclusions();
        self.surface();
        gaps(&self.0.notes, self.0.cohesive_elements > 0, &self.larger_gap());
        self.0.warnings.iter().for_each(|doubt| stderr::line(format!("warning: {doubt}")));
    }

    fn size(&self) -> String {
        let cohesive = match self.0.cohesive_elements {
            0 => String::new(),
            elements => format!(" and {} cohesive ones", thousands(elements)),
        };
        let (elements, nodes) = (thousands(self.0.elements), thousands(self.0.nodes));
        let how = format!("{:?}, {} mm", self.0.options.method.name(), self.0.options.element_size_mm).to_lowercase();
        format!("meshed {elements} elements{cohesive}, {nodes} nodes ({how})")
    }

    /// Prints most of it on stderr.
    pub(super) fn print(&self) {
        stderr::line(self.size());
        self.volumes();
        self.thick_shells();
        self.lost_inclusions();
        self.surface();
        self.joined();
        gaps(&self.0.notes, self.0.cohesive_elements > 0, &self.larger_gap());
        notes(&self.0.notes);
        self.worst();
        self.scaled();
        self.doubts();
    }

    /// Option that leaves larger gaps between grains.
    fn larger_gap(&self) -> String {
        if self.0.is_scan {
            format!("import with a larger {}", flag("gap_mm"))
        } else {
            "a larger min_gap_mm".to_owned()
        }
    }

    /// Distance of the interfaces from the aggregates' exact surfaces.
    fn surface(&self) {
        let distance = &self.0.quality.interface_distance;
        let lattice = Giver::Flags.choice("method", "lattice");
        let hint = if self.0.voxels { format!(" (voxels; {lattice} follows the surfaces)") } else { String::new() };
        stderr::line(format!("surface error {:.2} mm rms, {:.2} mm max{hint}", distance.rms_mm, distance.max_mm));
    }

    /// The interface nodes that two aggregates share.
    fn joined(&self) {
        let distance = &self.0.quality.interface_distance;
        if distance.joined > 0 {
            let (joined, rms, max) = (thousands(distance.joined), distance.joined_rms_mm, distance.joined_max_mm);
            stderr::line(format!("{joined} interface nodes bridge a closed gap: {rms:.2} mm rms, {max:.2} mm max"));
        }
    }

    /// The phases that exist or should, each with its share of the specimen in the mesh and its exact one.
    fn shares(&self) -> Vec<(String, [f64; 2])> {
        let of_specimen = |volumes: &PhaseVolumes, phase| volumes.of(phase) / self.0.specimen_volume_mm3;
        let (meshed, exact) = (&self.0.quality.volumes_mm3, self.0.quality.exact_volumes_mm3.as_ref());
        let phases = &self.0.phases;
        let share = |phase: Phase| {
            // A smeared ITZ is mortar.
            let share = match phase {
                Phase::Mortar if self.0.smeared => of_specimen(meshed, phase) + of_specimen(meshed, Phase::Itz),
                Phase::Itz if self.0.smeared => 0.0,
                phase => of_specimen(meshed, phase),
            };
            (phases.name(phase).to_owned(), [share, exact.map_or(f64::NAN, |exact| of_specimen(exact, phase))])
        };
        let is_there = |(_, [share, wanted]): &(String, [f64; 2])| *share > 0.0 || *wanted > 0.0;
        let voids = self.0.voids_mm3.map(|volumes| volumes.map(|volume| volume / self.0.specimen_volume_mm3));
        let voids = voids.map(|shares| ("void".to_owned(), shares));
        phases.solid().map(share).filter(is_there).chain(voids).collect()
    }

    /// A row for each phase.
    fn volumes(&self) {
        stderr::line("        phase  of specimen       exact     error");
        for (name, shares) in self.shares() {
            let ([share, wanted], error) = (shares, percent_off(shares));
            stderr::line(format!("  {name:>11}  {share:>11.5}  {wanted:>10.5}  {error:>+7.3}%"));
        }
        if self.0.smeared {
            let (itz, mortar) = (self.0.quality.volumes_mm3.itz, self.0.quality.volumes_mm3.mortar);
            stderr::line(format!("the smeared ITZ is {:.1} % of the mortar", 100.0 * itz / (itz + mortar)));
        }
    }

    /// Warns where the shells are far from their own thickness, as voxels at least a layer thick make them.
    fn thick_shells(&self) {
        let Some(exact) = self.0.quality.exact_volumes_mm3 else { return };
        if self.0.voxels && exact.itz > 0.0 && self.0.quality.volumes_mm3.itz > FAR_TOO_MUCH * exact.itz {
            let [method, itz, thin] = ["method", "itz", "thin_itz"].map(flag);
            stderr::line(format!(
                "the ITZ is at least one voxel thick here, at the aggregates' expense: use {method} lattice, {itz} cohesive \
                 or none, or {thin}"
            ));
        }
    }

    /// Warns where the elements are too coarse for the fibres or the voids.
    fn lost_inclusions(&self) {
        let fibres = self.0.quality.exact_volumes_mm3.map(|exact| [self.0.quality.volumes_mm3.fibre, exact.fibre]);
        for (name, volumes) in [("fibres", fibres), ("voids", self.0.voids_mm3)] {
            if volumes.is_some_and(|[meshed, exact]| exceeds((meshed - exact).abs(), INCLUSIONS_OFF * exact)) {
                let [size, method] = ["element_size_mm", "method"].map(flag);
                stderr::line(format!(
                    "the elements are too coarse for the {name}: use an {size} of at most half their diameter, or \
                     for convex grains {method} conforming, which keeps them exactly"
                ));
            }
        }
    }

    /// Cost of explicit steps of the length asked for.
    fn scaled(&self) {
        let scaling = &self.0.mass_scaling;
        let phases: Vec<String> = scaling.phases.iter().map(times).collect();
        stderr::line(format!(
            "explicit steps of {:e} s need {:.2} times the mass, {:+.0} % by mass scaling ({})",
            scaling.time_step_s,
            scaling.factor,
            scaling.added_percent(),
            phases.join(", ")
        ));
    }

    /// Doubts about the deck, of which one is the softening of its mortar.
    fn doubts(&self) {
        self.0.warnings.iter().for_each(|doubt| stderr::line(format!("warning: {doubt}")));
    }

    fn worst(&self) {
        let quality = &self.0.quality;
        let (altitude, cell) = quality.shortest_altitude_mm;
        stderr::line(format!(
            "shortest altitude {altitude:.4} mm (element {}): a stable time step of {:.1e} s",
            cell + 1,
            quality.stable_time_step_s
        ));
        if let Some(step) = quality.cohesive_time_step_s {
            stderr::line(format!("the cohesive elements allow {step:.1e} s, by their stiffness"));
        }
        if self.0.voxels {
            return;
        }
        let ((angle, sharpest), (ratio, flattest)) = (quality.min_dihedral_deg, quality.min_radius_ratio);
        let (sharpest, flattest) = (sharpest + 1, flattest + 1);
        stderr::line(format!(
            "smallest dihedral angle {angle:.2} degrees (element {sharpest}), radius ratio {ratio:.4} (element {flattest})"
        ));
        let bad = &self.0.bad_elements;
        let named: Vec<String> = bad.iter().take(NAMED).map(usize::to_string).collect();
        let all = format!(", ...; {} of `mesocrete mesh` names all", flag("summary_json"));
        let more = if bad.len() > NAMED { &*all } else { "" };
        let which = if bad.is_empty() { String::new() } else { format!(" (elements {}{more})", named.join(", ")) };
        stderr::line(format!(
            "{} elements with an angle below {} degrees{which}",
            thousands(bad.len()),
            QualityReport::BAD_DEG
        ));
    }
}

/// Error of a phase's share of the specimen, in percent of its exact one.
fn percent_off([share, wanted]: [f64; 2]) -> f64 {
    // Rounding is no error.
    (1e5 * (share / wanted - 1.0)).round() / 1e3 + 0.0
}

/// A phase and the factor of its mass.
fn times(phase: &PhaseScaling) -> String {
    format!("{} x {:.2}", phase.phase.to_lowercase(), phase.factor)
}

/// Decisions of the builder: gaps split, layers thinned.
fn notes(notes: &Notes) {
    if notes.split_gap_edges > 0 {
        let edges = thousands(notes.split_gap_edges);
        stderr::line(format!(
            "{edges} edges from one aggregate to another got a node in the middle: --narrow-gaps keep leaves them"
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
            "the ITZ (or a shell) is thinner than asked in {} aggregates and at {} nodes; at {} of these it has no \
             thickness",
            thousands(notes.thinned_itz_aggregates),
            thousands(notes.thinned_itz_nodes),
            thousands(notes.pinched_itz_nodes)
        ));
    }
    if notes.shifted_itz_nodes > 0 {
        let nodes = thousands(notes.shifted_itz_nodes);
        stderr::line(format!(
            "{nodes} inner nodes of the ITZ (or of a shell) left its exact thickness to avoid sharp angles"
        ));
    }
}

/// Gaps that are narrower than the elements, and what keeps them.
fn gaps(notes: &Notes, has_cohesive: bool, larger: &str) {
    let (pairs, nodes, widest) = (notes.closed_gap_pairs, notes.closed_gaps, notes.widest_closed_gap_mm);
    if notes.parted_nodes > 0 {
        stderr::line(format!(
            "{} pairs of grains are closer than the elements can resolve (up to {widest:.2} mm). Mortar replaced {:.0} mm3 of {} \
             grains to keep them apart. Smaller elements or {larger} avoid this",
            thousands(notes.separated_pairs),
            notes.parted_mm3,
            thousands(notes.parted_aggregates)
        ));
    } else if nodes > 0 {
        let (pairs, nodes) = (thousands(pairs), thousands(nodes));
        let end = if has_cohesive {
            "cohesive elements separate them there".to_owned()
        } else {
            format!("smaller elements or {larger} keep mortar between them")
        };
        stderr::line(format!(
            "{pairs} pairs of grains are closer than the elements can resolve (up to {widest:.2} mm) and share {nodes} nodes; {end}"
        ));
    }
    if notes.closed_side_gaps > 0 {
        stderr::line(format!(
            "{} grains are closer to the specimen's sides than the elements can resolve (up to {:.2} mm) and touch them \
             at {} nodes; a larger wall_gap_mm keeps mortar there",
            thousands(notes.closed_side_gap_aggregates),
            notes.widest_closed_side_gap_mm,
            thousands(notes.closed_side_gaps)
        ));
    }
}
