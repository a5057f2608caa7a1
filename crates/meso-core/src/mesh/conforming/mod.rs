//! The conforming mesh: facets exact, tetrahedra by gmsh, which runs as a program of its own.
//!
//! The facets are cut into triangles here ([`facets`], [`walls`], curved ones [`round`]) and go to gmsh as discrete surfaces, without CAD and
//! without booleans. Where grains are close gmsh puts nodes of its own on the facets, which stay plane. The core runs
//! nothing: [`Surfaces::write`] and [`Surfaces::script`] are gmsh's input, and whoever calls runs it with
//! [`GMSH_OPTIONS`] and hands its output back.

mod facets;
mod gaps;
mod msh;
mod round;
mod walls;

pub use gaps::ROOM_MM;

use super::lattice::Tetrahedra;
use super::{Mesh, MeshError, MeshOptions, NO_AGGREGATE, Notes};
use crate::aggregate::{Aggregate, Kind};
use crate::math::Vec3;
use crate::packing::Specimen;
use facets::Triangles;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::io::{self, Write};

/// Arguments for gmsh besides its script and `-o` with its output: Delaunay's volume mesher, optimised, and binary MSH 4.1.
///
/// Not HXT, which is faster on several cores: where grains are close it needs nodes on the given surfaces, and breaks off
/// (4.8 and 4.15: "corrupted size").
pub const GMSH_OPTIONS: [&str; 7] = ["-3", "-algo", "del3d", "-format", "msh41", "-bin", "-save_all"];

/// The surfaces that a conforming mesh keeps.
pub struct Surfaces<'a> {
    aggregates: &'a [Aggregate],
    /// One per aggregate, then the specimen's.
    surfaces: Vec<Triangles>,
    /// Edge length asked of the elements, mm.
    size: f64,
}

impl<'a> Surfaces<'a> {
    /// Cuts all facets into triangles of the element size.
    ///
    /// # Errors
    /// Aggregates so close to each other or to the specimen's surface that no good mesh can be between them.
    pub fn new(aggregates: &'a [Aggregate], specimen: &Specimen, options: &MeshOptions) -> Result<Self, MeshError> {
        let (room, size) = (specimen.room(), options.element_size_mm);
        gaps::refuse_near_touching(aggregates, &*room, walls::chord(specimen))?;
        let mut surfaces: Vec<Triangles> = aggregates.par_iter().map(|a| facets::facets(&a.body, size)).collect();
        surfaces.push(walls::walls(specimen, &*room, size));
        Ok(Self { aggregates, surfaces, size })
    }

    /// gmsh's script, which reads the surfaces from `file`.
    pub fn script(&self, file: &str) -> String {
        let centre = |body: &Aggregate| (body.kind != Kind::Void).then(|| body.body.centroid());
        msh::script(file, &self.aggregates.iter().map(centre).collect::<Vec<Option<Vec3>>>(), self.size)
    }

    /// Writes the surfaces for gmsh.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        msh::write(&self.surfaces, out)
    }

    /// The mesh from gmsh's output, aggregates and mortar.
    ///
    /// # Errors
    /// Says what is wrong with `output`.
    pub(super) fn mesh(&self, output: &[u8]) -> Result<Mesh, MeshError> {
        let volumes = msh::read(output).map_err(MeshError::Gmsh)?;
        let mortar = self.aggregates.len() as u32 + 1;
        let grain = |&tag: &u32| if tag == mortar { NO_AGGREGATE } else { tag - 1 };
        let filled = volumes.volume.iter().collect::<BTreeSet<_>>().len();
        let wanted = self.surfaces.len() - self.aggregates.iter().filter(|body| body.kind == Kind::Void).count();
        if filled < wanted {
            let empty = wanted - filled;
            return Err(MeshError::Gmsh(format!("gmsh left {empty} of {wanted} volumes without elements")));
        }
        let cells = volumes.cells.par_iter().map(|cell| super::lattice::oriented(*cell, &volumes.points)).collect();
        let grain = volumes.volume.iter().map(grain).collect();
        let tetrahedra = Tetrahedra { points: volumes.points, cells, grain };
        Ok(super::of_tetrahedra(tetrahedra, self.aggregates, Notes::default()))
    }
}
