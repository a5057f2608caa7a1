//! Fields that outlive their moment, for the frames' files and the page's pictures.

use super::layers;
use crate::march::{Ended, Frame, Mean, Run};
use meso_mesh::Mesh;
use meso_view::vtk::Still;
use meso_view::vtk::mesh::{self as vtu_mesh, Field, Unread};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{self, Write};

/// When a frame was taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// From 1 to the test's number of frames.
    pub number: u32,
    /// Mean axial strain, positive in the test's sense.
    pub strain: f64,
    /// Stress of the latest row of the curve, MPa.
    pub stress_mpa: f64,
    /// s.
    pub time_s: f64,
    /// Checksum of its displacements, stresses and cracks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seal: Option<u32>,
}

impl Moment {
    /// Beginning and end of a frame's file name; the number stands between them.
    pub const FILES: [&str; 2] = ["frame_", ".vtu"];

    /// When `frame` is.
    pub fn of(frame: &Frame) -> Self {
        let (number, strain) = (frame.number(), frame.strain());
        Self { number, strain, stress_mpa: frame.stress_mpa(), time_s: frame.time_s(), seal: None }
    }

    /// Name of the frame's file.
    pub fn file(&self) -> String {
        let [prefix, suffix] = Self::FILES;
        format!("{prefix}{:04}{suffix}", self.number)
    }

    /// The frame's number, where `name` is that of its file.
    pub fn number_of(name: &str) -> Option<u32> {
        let [prefix, suffix] = Self::FILES;
        name.strip_prefix(prefix)?.strip_suffix(suffix)?.parse().ok()
    }
}

/// All fields of a moment.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// When.
    pub moment: Moment,
    /// Displacements of the mesh's nodes, mm.
    pub displacement: Vec<[f32; 3]>,
    /// xx yy zz xy yz zx in every cell, MPa; tension is positive.
    pub stress: Vec<[f32; 6]>,
    /// 1 less the share of the stiffness that is left, in every cell.
    pub damage: Vec<f32>,
    /// Damage in tension, 0 to 1.
    pub tension: Vec<f32>,
    /// Damage in compression, 0 to 1.
    pub compression: Vec<f32>,
    /// Opening of the crack in every cell, mm.
    pub opening_mm: Vec<f32>,
    /// Factor of the strengths in every cell; empty where they do not scatter.
    pub strength: Vec<f32>,
    /// Share of the stiffness with which every cell unloads, 0 to 1.
    pub stiffness_left: Vec<f32>,
    /// Strain of its cracks in every cell, xx yy zz xy yz zx: openings over distances, along the cracks' normals.
    pub crack_strain: Vec<[f32; 6]>,
}

/// Numbers that are hashed at once.
const CHUNK: usize = 1 << 14;

impl Snapshot {
    /// Fields of `frame`.
    pub fn of(frame: &Frame) -> Self {
        let cells = frame.mesh().cell_count();
        let (mut stress, mut damage) = (vec![[0.0_f32; 6]; cells], vec![0.0_f32; cells]);
        let (mut tension, mut compression, mut opening_mm) = (damage.clone(), damage.clone(), damage.clone());
        let mut strength = if frame.is_scattered() { damage.clone() } else { Vec::new() };
        let mut stiffness_left = damage.clone();
        let mut crack_strain = stress.clone();
        frame.visit(
            |point| (*point, layers::crack_strain(point)),
            |cell, (point, strain), share| {
                stiffness_left[cell].take(&point.stiffness_left, share);
                crack_strain[cell].take(strain, share);
                stress[cell].take(&point.stress, share);
                damage[cell].take(&point.damage, share);
                tension[cell].take(&point.tension, share);
                compression[cell].take(&point.compression, share);
                opening_mm[cell].take(&point.opening_mm, share);
                if let Some(strength) = strength.get_mut(cell) {
                    strength.take(&point.strength, share);
                }
            },
        );
        let (moment, displacement) = (Moment::of(frame), frame.displacement());
        let mut own = Self {
            moment,
            displacement,
            stress,
            damage,
            tension,
            compression,
            opening_mm,
            strength,
            stiffness_left,
            crack_strain,
        };
        own.moment.seal = Some(own.seal());
        own
    }

    /// Whether its fields are those of its moment; without a seal nothing shows it.
    pub fn is_of_its_moment(&self) -> bool {
        self.moment.seal == Some(self.seal())
    }

    /// The first four bytes of a SHA-256.
    fn seal(&self) -> u32 {
        let (displacement, cracks) = (self.displacement.as_flattened(), self.crack_strain.as_flattened());
        let mut hash = Sha256::new();
        for field in [displacement, self.stress.as_flattened(), cracks, &self.opening_mm, &self.stiffness_left] {
            let bytes = |some: &[f32]| some.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
            field.chunks(CHUNK).for_each(|some| hash.update(bytes(some)));
        }
        let [a, b, c, d, ..]: [u8; 32] = hash.finalize().into();
        u32::from_be_bytes([a, b, c, d])
    }

    /// Reads what [`Snapshot::write`] wrote, with its mesh, which lacks cohesive elements and notes.
    ///
    /// # Errors
    /// A file that [`Snapshot::write`] did not write, or that was changed.
    pub fn read(moment: Moment, bytes: &[u8]) -> Result<(Mesh, Self), Unread> {
        let (mesh, stored) = vtu_mesh::read(bytes)?;
        let cells = |name| stored.floats(name, [1, mesh.cell_count()]);
        let six = |name| Ok(stored.floats(name, [6, mesh.cell_count()])?.as_chunks().0.to_vec());
        let snapshot = Self {
            moment,
            displacement: stored.floats("displacement_mm", [3, mesh.points.len()])?.as_chunks().0.to_vec(),
            stress: six("stress_mpa")?,
            damage: cells("damage")?,
            tension: cells("damage_tension")?,
            compression: cells("damage_compression")?,
            opening_mm: cells("crack_opening_mm")?,
            strength: if stored.has("strength_factor") { cells("strength_factor")? } else { Vec::new() },
            stiffness_left: cells("stiffness_left")?,
            crack_strain: six("crack_strain")?,
        };
        Ok((mesh, snapshot))
    }

    /// Fields at the end of `run`, with the number 0; a run that diverged holds no numbers then.
    pub fn last(run: &Run, ended: &Ended) -> Option<Self> {
        (!matches!(ended, Ended::Diverged(_) | Ended::Failed(_))).then(|| Self::of(&Frame::new(run, 0)))
    }

    /// Writes it as a `.vtu` of `mesh`, which it belongs to. All snapshots of a mesh have one `still`, empty at first.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write(&self, mesh: &Mesh, still: &mut Still, out: &mut dyn Write) -> io::Result<()> {
        let scalar = |name, values| Field { name, components: 1, values };
        let moved = Field { name: "displacement_mm", components: 3, values: self.displacement.as_flattened() };
        let mut cells = vec![
            scalar("damage", &self.damage),
            scalar("damage_tension", &self.tension),
            scalar("damage_compression", &self.compression),
            scalar("crack_opening_mm", &self.opening_mm),
            Field { name: "stress_mpa", components: 6, values: self.stress.as_flattened() },
        ];
        cells.extend([
            scalar("stiffness_left", &self.stiffness_left),
            Field { name: "crack_strain", components: 6, values: self.crack_strain.as_flattened() },
        ]);
        cells.extend((!self.strength.is_empty()).then(|| scalar("strength_factor", &self.strength)));
        vtu_mesh::write_fields(mesh, &[moved], &cells, still, out)
    }
}
