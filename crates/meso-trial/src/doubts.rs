//! Doubts about a mesh that is to be tested, known before the first step.

use crate::sample::Sample;
use meso_concrete::exceeds;
use meso_mesh::{Mesh, Phase, PhaseOff, PhaseVolumes};

/// Difference of the volume of bodies in the mesh from their own, over that, which is worth a warning.
const VOLUME: f64 = 0.02;
/// Least share of the aggregates' cells, %, whose loss to mortar is worth a warning.
const FEW_PARTED: f64 = 0.05;

impl Sample<'_> {
    /// The phase that is farthest off its exact volume, where that is known.
    pub fn phase_off(&self) -> Option<PhaseOff> {
        PhaseOff::between(&PhaseVolumes::of_bodies(self.mesh), self.exact.as_ref()?, self.volume_mm3)
    }

    /// Pairs of aggregates that share nodes and form a skeleton.
    fn joined_pairs(&self) -> usize {
        self.mesh.joined_aggregates().1
    }

    /// Faults of the mesh that a strength must not be cited without, in a few words each: results carry them.
    pub fn flags(&self) -> Vec<String> {
        let coarse = self.phase_off().filter(|off| off.is_beyond(PhaseOff::ACCEPTED));
        let coarse = coarse.map(|off| {
            let (phase, percent) = (self.mesh.phases.name(off.phase), 100.0 * off.error());
            format!("mesh too coarse: {phase} {percent:+.0} %")
        });
        let joined = (self.joined_pairs() > 0).then(|| "aggregates joined".to_owned());
        coarse.into_iter().chain(joined).collect()
    }

    /// Warnings about the mesh, in sentences.
    pub fn doubts(&self) -> Vec<String> {
        let periodic = (self.mesh.periodic != [false; 3])
            .then(|| "the specimen is periodic, but its sides are free in this test".to_owned());
        let first = self.of_joined().into_iter().chain(self.of_touching());
        first.chain(self.of_volumes()).chain(periodic).collect()
    }

    fn of_joined(&self) -> Option<String> {
        let (mesh, notes) = (self.mesh, &self.mesh.notes);
        let (left, pairs) = (self.joined_pairs(), notes.separated_pairs);
        if left > 0 {
            return Some(format!(
                "{left} pairs of aggregates share nodes and form a skeleton that cannot break; mesh with joined = \"mortar\""
            ));
        }
        let kept = mesh.phase.iter().filter(|phase| phase.is_aggregate()).count();
        let share = 100.0 * notes.parted_cells as f64 / (kept + notes.parted_cells).max(1) as f64;
        (share >= FEW_PARTED).then(|| {
            let grains = notes.parted_aggregates;
            format!(
                "{pairs} pairs of aggregates share nodes: {share:.1} % of the aggregates' cells became mortar, of {grains} grains; \
                 {}, or refine the mesh",
                self.larger_gap()
            )
        })
    }

    /// Remedy for gaps that the elements close. Of 119 pairs in a scan of touching grains, gaps of half an element left 1.
    fn larger_gap(&self) -> String {
        let gap = 0.5 * self.element_size_mm;
        format!("pack with min_gap_mm = {gap}, or import a scan with gaps of {gap} mm")
    }

    fn of_touching(&self) -> Option<String> {
        let touching = self.mesh.touching_share();
        let share = 100.0 * touching;
        (touching > Mesh::FEW_TOUCH).then(|| {
            format!(
                "{share:.1} % of the cohesive faces lie between two aggregates: without mortar there these form a skeleton \
                 that hardly breaks; mesh with joined = \"mortar\", or {}",
                self.larger_gap()
            )
        })
    }

    /// Bodies that are another share of the specimen than they should be.
    fn of_volumes(&self) -> Vec<String> {
        let Some(exact) = self.exact else { return Vec::new() };
        let meshed = PhaseVolumes::of_mesh(self.mesh);
        let of = |phase| Some([meshed.of(phase), exact.of(phase)]);
        let voids = exact.voids(self.mesh, self.volume_mm3);
        let bodies = [
            ("aggregates", Some([meshed.aggregate, exact.aggregate]), "refine the mesh, or pack with a larger gap"),
            (
                "fibres",
                of(Phase::Fibre),
                "take elements of at most half their diameter, or for convex grains the method conforming",
            ),
            ("voids", voids, "refine the mesh"),
        ];
        let off = bodies.into_iter().filter_map(|(name, volumes, remedy)| Some((name, volumes?, remedy)));
        off.filter(|(_, [meshed, exact], _)| exceeds((meshed - exact).abs(), VOLUME * exact))
            .map(|(name, volumes, remedy)| {
                let [share, exact] = volumes.map(|volume| 100.0 * volume / self.volume_mm3);
                format!(
                    "the {name} are {share:.1} % of the specimen in this mesh and {exact:.1} % in the packing: {remedy}"
                )
            })
            .collect()
    }
}
