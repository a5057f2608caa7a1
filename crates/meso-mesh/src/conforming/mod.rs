//! The conforming mesh: facets exact, tetrahedra by gmsh, which runs as a program of its own.
//!
//! 1. Gaps too narrow for a mesh are refused (`slabs`).
//! 2. Large specimens are divided into slabs; bodies are cut at the planes and at the faces of a box that repeats itself
//!    (`clipped`).
//! 3. All facets are cut into triangles (`triangulation`) and put together to the input of gmsh (`sections`,
//!    `plc`, `msh`): discrete surfaces, without CAD and without booleans.
//! 4. gmsh fills every slab. Where bodies are close it puts nodes of its own on the facets, which stay plane.
//! 5. The slabs' meshes become one and flat cells on periodic faces are opened (`stitch`), and small angles are enlarged
//!    (`improve`).
//!
//! The core runs nothing: [`Surfaces::write`] and [`Surfaces::script`] are gmsh's input, and whoever calls runs it with
//! [`Surfaces::GMSH_OPTIONS`] and hands its output back ([`VolumeMesher`]).

mod clipped;
mod improve;
mod msh;
mod plc;
mod sections;
mod slabs;
mod stitch;

use super::acceptance::all_positive;
use super::error::MeshError;
use crate::cells::NO_BODY;
use crate::tet::{TetMesh, oriented};
use crate::triangulation::{self, Triangles};
use clipped::{BodyIndex, Cuts};
use meso_collision::math::Aabb;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::parallel;
use meso_concrete::specimen::{Container, Period, Specimen};
use plc::{Filled, Shells};
use rayon::prelude::*;
use slabs::Slabs;
use std::collections::BTreeSet;
use std::io::{self, Write};

/// Sizes that gmsh is asked for in turn, as shares of the one wanted, where it puts a node on one of two opposite faces
/// alone, leaves a cell without volume or breaks off: with other nodes on the surfaces it does none of these, mostly.
const TRIES: [f64; 3] = [1.0, 0.97, 0.94];

/// Fills closed surfaces with tetrahedra: gmsh, or a stand-in of tests.
pub trait VolumeMesher: Sync {
    /// Tests whether it is there and runs.
    ///
    /// # Errors
    /// [`MeshError::MissingGmsh`], and faults of files.
    fn available(&self) -> Result<(), MeshError> {
        Ok(())
    }

    /// gmsh's output, MSH 4.1 in binary, for the input that [`Surfaces::write`] gives. The parts of a large specimen are asked
    /// for at the same time.
    ///
    /// # Errors
    /// [`MeshError::Gmsh`] where another element size may help; it is asked again then, and after no other error.
    fn fill(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError>;
}

impl<F: Fn(&Surfaces) -> Result<Vec<u8>, MeshError> + Sync> VolumeMesher for F {
    fn fill(&self, surfaces: &Surfaces) -> Result<Vec<u8>, MeshError> {
        self(surfaces)
    }
}

/// The mesh of `aggregates` and mortar by `gmsh`; `images` as of [`GmshInput::new`].
///
/// # Errors
/// Fails like [`GmshInput::new`], those of `gmsh`, and where no size gives opposite faces that match and cells with a volume.
pub(super) fn mesh(
    aggregates: &[Aggregate],
    images: &[Aggregate],
    specimen: &Specimen,
    element_size_mm: f64,
    slabs: Option<u32>,
    gmsh: &dyn VolumeMesher,
) -> Result<TetMesh, MeshError> {
    let meshed = |share: f64| {
        let mut division = GmshInput::new(aggregates, images, specimen, share * element_size_mm, slabs)?;
        division.runs[0].again = share != TRIES[0];
        let mesh = division.mesh(gmsh)?;
        all_positive(mesh.by_body()).map(|()| mesh)
    };
    // The error reported is that of the size asked for.
    let mut first = None;
    for share in TRIES {
        match meshed(share) {
            Err(error) if error.is_worth_another_try() => first = first.or(Some(error)),
            done => return done,
        }
    }
    Err(first.unwrap_or(MeshError::NeedsGmsh))
}

/// The input of all runs of gmsh.
struct GmshInput {
    /// By slab.
    runs: Vec<Surfaces>,
    slabs: Slabs,
    /// How the specimen repeats itself, and its box.
    period: Period,
    domain: Aabb,
}

impl GmshInput {
    /// Cuts all facets into triangles of the element size. `images` are the aggregates and, where the specimen repeats
    /// itself, their images in it, whole.
    ///
    /// # Errors
    /// Aggregates so close to each other or to the specimen's surface that no good mesh can be between them.
    fn new(
        aggregates: &[Aggregate],
        images: &[Aggregate],
        specimen: &Specimen,
        size: f64,
        slabs: Option<u32>,
    ) -> Result<Self, MeshError> {
        let container = specimen.container();
        let (period, domain) = (specimen.period(), container.aabb());
        let bodies = BodyIndex::new(aggregates, images, &period);
        slabs::refuse_near_touching(images, &*container, triangulation::chord(specimen))?;
        slabs::refuse_grazed(aggregates, &period)?;
        let walls = triangulation::polygons(specimen, &*container, size);
        let corners = walls.as_ref().map_or(&[][..], |walls| &walls.points);
        let slabs = match specimen {
            Specimen::Sphere { .. } => Slabs::one(),
            _ => Slabs::new(images, corners, &domain, size, slabs),
        };
        let cuts = Cuts { placed: aggregates, bodies: &bodies, period: &period, domain: &domain, slabs: &slabs, size };
        let shells = match walls {
            _ if period.is_none() && slabs.positions.is_empty() => vec![walled(cuts, specimen, &*container)?],
            Some(walls) => sections::of_walls(cuts, walls)?,
            None => sections::of_box(cuts)?,
        };
        let runs = shells.into_iter().map(|shells| Surfaces { shells, size, again: false }).collect();
        Ok(Self { runs, slabs, period, domain })
    }

    /// The mesh of `aggregates` and mortar, slab by slab by `gmsh`, as many at once as there are threads.
    ///
    /// # Errors
    /// Fails with the errors of `gmsh`; names a fault of its output; a node on a periodic face that has none opposite to it.
    fn mesh(self, gmsh: &dyn VolumeMesher) -> Result<TetMesh, MeshError> {
        let filled = self.runs.par_iter().with_max_len(1).map(|surfaces| surfaces.filled(&gmsh.fill(surfaces)?));
        let mut mesh = stitch::joined(filled.collect::<Result<_, MeshError>>()?, &self.slabs)?;
        stitch::open_slivers(&mut mesh, &self.period, &self.domain);
        sections::all_matched(&mesh.points, &self.period, &self.domain)?;
        parallel::each_short_mut(&mut mesh.cells, |_, cell| *cell = oriented(*cell, &mesh.points));
        improve::enlarge_angles(&mut mesh);
        Ok(mesh)
    }
}

/// The surfaces that a conforming mesh keeps, for one run of gmsh.
pub struct Surfaces {
    shells: Shells,
    /// Edge length asked of the elements, mm.
    size: f64,
    /// Whether these are the first ones of another size than the one that was asked for.
    again: bool,
}

impl Surfaces {
    /// Arguments for gmsh besides its script and `-o` with its output: Delaunay's volume mesher, optimised, and binary MSH 4.1.
    ///
    /// Not HXT, which is faster on several cores: where bodies are close it needs nodes on the given surfaces, and breaks off
    /// (4.8 and 4.15: "corrupted size").
    pub const GMSH_OPTIONS: [&str; 7] = ["-3", "-algo", "del3d", "-format", "msh41", "-bin", "-save_all"];

    /// The size of the elements, mm, where gmsh is asked again from here on, since its mesh for another size is of no use.
    pub fn again_mm(&self) -> Option<f64> {
        self.again.then_some(self.size)
    }

    /// gmsh's script, which reads the surfaces from `file`.
    pub fn script(&self, file: &str) -> String {
        msh::script(file, &self.shells, self.size)
    }

    /// Writes the surfaces for gmsh.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        msh::write(&self.shells, out)
    }

    /// gmsh's output, with the index of its body for every cell.
    ///
    /// # Errors
    /// Names the fault of `output`.
    fn filled(&self, output: &[u8]) -> Result<TetMesh, MeshError> {
        let read = msh::read(output).map_err(MeshError::Gmsh)?;
        let (filled, wanted) = (read.tags.iter().collect::<BTreeSet<_>>().len(), self.shells.volumes.len());
        if filled < wanted {
            let empty = wanted - filled;
            return Err(MeshError::Gmsh(format!("gmsh left {empty} of {wanted} volumes without elements")));
        }
        let owner = read.tags.iter().map(|&tag| self.shells.volumes[tag as usize - 1].owner).collect();
        Ok(TetMesh { points: read.points, cells: read.cells, owner })
    }
}

/// Aggregates within a specimen's surface that none of them meets.
///
/// # Errors
/// Fails like [`triangulation::facets`].
fn walled(cuts: Cuts, specimen: &Specimen, container: &dyn Container) -> Result<Shells, MeshError> {
    let Cuts { placed, bodies, size, .. } = cuts;
    let surfaces: Vec<Triangles> = parallel::try_map(placed.len(), |i| triangulation::of_body(&placed[i].body, size))?;
    let mut shells = Shells::default();
    let mut holes = Vec::new();
    for (aggregate, surface) in placed.iter().zip(&surfaces) {
        let shell = shells.closed(surface);
        holes.push(shell);
        if aggregate.kind != Kind::Void {
            let centre = Some(aggregate.body.centroid());
            let owner = bodies.of(aggregate.id, [0; 3]);
            shells.volumes.push(Filled { loops: vec![shell], centre, owner });
        }
    }
    // The specimen's surface first, then those that bound holes.
    let outer = shells.closed(&triangulation::walls(specimen, container, size)?);
    shells.volumes.push(Filled { loops: [vec![outer], holes].concat(), centre: None, owner: NO_BODY });
    Ok(shells)
}
