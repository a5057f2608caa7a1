//! The conforming mesh: facets exact, tetrahedra by gmsh, which runs as a program of its own.
//!
//! The facets are cut into triangles here ([`facets`], [`walls`], curved ones [`round`]) and go to gmsh as discrete surfaces, without CAD and
//! without booleans; in boxes that repeat themselves, images of grains are cut at the faces ([`periodic`]). Where grains are close gmsh puts nodes of its own on the facets, which stay plane. The core runs
//! nothing: [`Surfaces::write`] and [`Surfaces::script`] are gmsh's input, and whoever calls runs it with
//! [`GMSH_OPTIONS`] and hands its output back.

mod faces;
mod facets;
mod flat;
mod gaps;
mod msh;
mod parts;
mod periodic;
mod pieces;
mod round;
mod shells;
mod walls;

pub use gaps::ROOM_MM;

use super::lattice::Tetrahedra;
use super::volumes::all_positive;
use super::{Mesh, MeshError, MeshOptions, NO_AGGREGATE, Notes};
use crate::aggregate::{Aggregate, Kind};
use crate::math::Aabb;
use crate::packing::{Period, Room, Specimen};
use facets::Triangles;
use rayon::prelude::*;
use shells::{Filled, Shells};
use std::collections::BTreeSet;
use std::io::{self, Write};

/// Arguments for gmsh besides its script and `-o` with its output: Delaunay's volume mesher, optimised, and binary MSH 4.1.
///
/// Not HXT, which is faster on several cores: where grains are close it needs nodes on the given surfaces, and breaks off
/// (4.8 and 4.15: "corrupted size").
pub const GMSH_OPTIONS: [&str; 7] = ["-3", "-algo", "del3d", "-format", "msh41", "-bin", "-save_all"];

/// Sizes that gmsh is asked for in turn, as shares of the one wanted, where it puts a node on one of two opposite faces
/// alone, leaves a cell without volume or breaks off: with other nodes on the surfaces it does none of these, mostly.
const TRIES: [f64; 3] = [1.0, 0.97, 0.94];

/// The mesh of `aggregates` and mortar by `gmsh`; `images` as of [`Surfaces::new`].
///
/// # Errors
/// As [`Surfaces::new`], those of `gmsh`, and where no size gives opposite faces that match and cells with a volume.
pub(super) fn mesh(
    aggregates: &[Aggregate],
    images: &[Aggregate],
    specimen: &Specimen,
    options: &MeshOptions,
    gmsh: super::Gmsh,
) -> Result<Mesh, MeshError> {
    let meshed = |share: f64| {
        let options = MeshOptions { element_size_mm: share * options.element_size_mm, ..options.clone() };
        let surfaces = Surfaces::new(aggregates, images, specimen, &options)?;
        let mesh = surfaces.mesh(&gmsh(&surfaces)?)?;
        all_positive(&mesh).map(|()| mesh)
    };
    let [first, others @ ..] = TRIES;
    others.into_iter().fold(meshed(first), |last, share| match last {
        // What went wrong with the size that was asked for is what is told.
        Err(MeshError::Unmatched { .. } | MeshError::Flat { .. } | MeshError::Gmsh(_)) => meshed(share).or(last),
        done => done,
    })
}

/// The surfaces that a conforming mesh keeps.
pub struct Surfaces<'a> {
    aggregates: &'a [Aggregate],
    shells: Shells,
    /// Edge length asked of the elements, mm.
    size: f64,
    /// How the specimen repeats itself, and its box.
    period: Period,
    domain: Aabb,
}

impl<'a> Surfaces<'a> {
    /// Cuts all facets into triangles of the element size. `images` are the aggregates and, where the specimen repeats
    /// itself, their images in it, whole.
    ///
    /// # Errors
    /// Aggregates so close to each other or to the specimen's surface that no good mesh can be between them.
    pub fn new(
        aggregates: &'a [Aggregate],
        images: &[Aggregate],
        specimen: &Specimen,
        options: &MeshOptions,
    ) -> Result<Self, MeshError> {
        let (room, size) = (specimen.room(), options.element_size_mm);
        let (period, domain) = (specimen.period(), room.aabb());
        gaps::refuse_near_touching(images, &*room, walls::chord(specimen))?;
        let shells = if period.is_none() {
            walled(aggregates, specimen, &*room, size)
        } else {
            gaps::refuse_grazed(aggregates, &period)?;
            periodic::shells(aggregates, &period, &domain, size)?
        };
        Ok(Self { aggregates, shells, size, period, domain })
    }

    /// gmsh's script, which reads the surfaces from `file`.
    pub fn script(&self, file: &str) -> String {
        msh::script(file, &self.shells, self.size)
    }

    /// Writes the surfaces for gmsh.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        msh::write(&self.shells, out)
    }

    /// The mesh from gmsh's output, aggregates and mortar.
    ///
    /// # Errors
    /// Says what is wrong with `output`; a node on a periodic face that has none opposite to it.
    pub(super) fn mesh(&self, output: &[u8]) -> Result<Mesh, MeshError> {
        let mut read = msh::read(output).map_err(MeshError::Gmsh)?;
        flat::open(&mut read, &self.period, &self.domain);
        let (filled, wanted) = (read.volume.iter().collect::<BTreeSet<_>>().len(), self.shells.volumes.len());
        if filled < wanted {
            let empty = wanted - filled;
            return Err(MeshError::Gmsh(format!("gmsh left {empty} of {wanted} volumes without elements")));
        }
        periodic::all_matched(&read.points, &self.period, &self.domain)?;
        let grain = |tag: &u32| self.shells.volumes[*tag as usize - 1].grain.unwrap_or(NO_AGGREGATE);
        let cells = read.cells.par_iter().map(|cell| super::lattice::oriented(*cell, &read.points)).collect();
        let grain = read.volume.iter().map(grain).collect();
        let tetrahedra = Tetrahedra { points: read.points, cells, grain };
        Ok(super::of_tetrahedra(tetrahedra, self.aggregates, Notes::default()))
    }
}

/// Aggregates within a specimen's surface that none of them meets.
fn walled(aggregates: &[Aggregate], specimen: &Specimen, room: &dyn Room, size: f64) -> Shells {
    let bodies: Vec<Triangles> = aggregates.par_iter().map(|a| facets::facets(&a.body, size)).collect();
    let mut shells = Shells::default();
    let mut holes = Vec::new();
    for (grain, (aggregate, surface)) in (0..).zip(aggregates.iter().zip(&bodies)) {
        let shell = shells.closed(surface);
        holes.push(shell);
        if aggregate.kind != Kind::Void {
            let centre = Some(aggregate.body.centroid());
            shells.volumes.push(Filled { loops: vec![shell], centre, grain: Some(grain) });
        }
    }
    // The specimen's surface first, then those that bound holes.
    let outer = shells.closed(&walls::walls(specimen, room, size));
    shells.volumes.push(Filled { loops: [vec![outer], holes].concat(), centre: None, grain: None });
    shells
}
