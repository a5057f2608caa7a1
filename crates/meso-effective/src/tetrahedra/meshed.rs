//! Meshes of a packing, as the values of its ITZ need them.
//!
//! | values | mesh |
//! |---|---|
//! | ITZ like mortar | the cores of the aggregates |
//! | ITZ like the aggregates | the aggregates |
//! | impermeable aggregates, ITZ below a fiftieth of their radius | the aggregates, and a conductive film on their faces |
//! | others | the aggregates with a layer of elements as their ITZ |

use super::domain::Domain;
use crate::error::EffectiveError;
use crate::estimate::Sizes;
use crate::grid::Space;
use crate::resolution::Resolution;
use crate::solutions::{Column, Solutions};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::specimen::Specimen;
use meso_concrete::watch::Watch;
use meso_concrete::{Parts, Ranges};
use meso_concrete::{Phase, PhaseNames};
use meso_mesh::cells::faces;
use meso_mesh::{ItzForm, Mesh, MeshOptions, Method, PhaseOff, Tools, Volumes, build};
use std::borrow::Cow;

/// Most cubes of the element size along an axis: node numbers fit 32 bits.
const MOST: f64 = 1000.0;
/// Fewest cubes along an axis: the second resolution has half as many.
const FEWEST: f64 = 4.0;

/// Number of cubes of the element size in a specimen.
///
/// # Errors
/// A size out of its range.
pub(super) fn cubes(specimen: &Specimen, element_size_mm: f64) -> Result<f64, EffectiveError> {
    let (ranges, lengths) = (Ranges("effective"), specimen.aabb().size());
    ranges.positive("element_size_mm", element_size_mm)?;
    let (low, high) = (lengths.max() / MOST, lengths.min() / FEWEST);
    let is_met = (low..=high).contains(&element_size_mm);
    ranges.require("element_size_mm", element_size_mm, is_met, format!("it must be {low} to {high} mm"))?;
    Ok(specimen.volume() / element_size_mm.powi(3))
}

/// Films have at most this share of a body's volume: three times the thickness over the radius.
const THIN: f64 = 0.06;

/// The ITZ in a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Itz {
    /// It counts as mortar.
    Mortar,
    /// It counts as aggregate.
    Aggregate,
    /// A film on impermeable aggregates where it is thin, else a layer of elements.
    Film,
    /// A layer of elements.
    Layer,
}

impl Itz {
    /// By the values of mortar, of the aggregates' phases and of the ITZ.
    pub(super) fn of<T: PartialEq>(mortar: &T, aggregates: &[T], itz: &T, is_impermeable: bool) -> Self {
        match itz {
            itz if itz == mortar => Self::Mortar,
            itz if aggregates.iter().all(|aggregate| itz == aggregate) => Self::Aggregate,
            _ if is_impermeable => Self::Film,
            _ => Self::Layer,
        }
    }
}

/// Bodies as they are meshed.
pub(super) struct Bodies<'a> {
    specimen: &'a Specimen,
    names: &'a PhaseNames,
    bodies: Vec<Aggregate>,
    /// Phase of every body within its ITZ.
    phases: Vec<Phase>,
    /// Volumes of their ITZ, mm3.
    films: Vec<f64>,
    itz: Itz,
}

impl<'a> Bodies<'a> {
    /// `fills_voids` says that voids have a value, so that they are meshed.
    pub(super) fn new(
        bodies: &[Aggregate],
        (specimen, names): (&'a Specimen, &'a PhaseNames),
        itz: Itz,
        fills_voids: bool,
    ) -> Self {
        let mut all = Self { specimen, names, bodies: Vec::new(), phases: Vec::new(), films: Vec::new(), itz };
        for body in bodies {
            all.add(body, fills_voids);
        }
        let has_film = all.films.iter().zip(&all.bodies).all(|(film, body)| *film <= THIN * body.body.volume());
        all.itz = match itz {
            Itz::Layer | Itz::Film if all.films.iter().all(|film| *film == 0.0) => Itz::Aggregate,
            Itz::Film if !has_film => Itz::Layer,
            itz => itz,
        };
        all
    }

    fn add(&mut self, body: &Aggregate, fills_voids: bool) {
        let (mut body, phase, mut film) = (body.clone(), body.phase(), 0.0);
        body.own = None;
        if body.kind == Kind::Aggregate && body.itz_thickness_mm > 0.0 {
            match body.inner_surface() {
                Err(_) => body.itz_thickness_mm = 0.0,
                Ok(None) if self.itz == Itz::Mortar => return,
                Ok(None) => film = body.body.volume(),
                Ok(Some(core)) => {
                    film = body.body.volume() - core.volume();
                    if self.itz == Itz::Mortar {
                        (body.body, body.itz_thickness_mm) = (core, 0.0);
                    }
                }
            }
        }
        if body.kind == Kind::Void && fills_voids {
            body.kind = Kind::Aggregate;
        }
        body.id = self.bodies.len() as u32;
        self.bodies.push(body);
        self.phases.push(phase);
        self.films.push(film);
    }

    /// The solutions on elements of a size, and on those of twice and four times the size, with the fine mesh as a division whose walls
    /// have the conditions `at_walls`; `solve` learns which one it is. Elements of four times the size are left out if they are too
    /// large for the specimen or its bodies.
    ///
    /// # Errors
    /// The errors of `solve`, bodies and options that cannot be meshed, and elements too large for a phase.
    pub(super) fn on_sizes<const N: usize>(
        &self,
        (element_size_mm, at_walls): (f64, &'static str),
        watch: &dyn Watch,
        solve: impl Fn(&Domain, bool) -> Result<Vec<Column<N>>, EffectiveError>,
    ) -> Result<(Solutions<N>, Resolution), EffectiveError> {
        let mut coarser = vec![solve(&self.mesh(2.0 * element_size_mm, false, watch)?, false)?];
        if 8.0 * element_size_mm <= self.specimen.aabb().size().min() {
            let coarsest = self.mesh(4.0 * element_size_mm, false, watch);
            coarser.extend(coarsest.and_then(|domain| solve(&domain, false)));
        }
        let domain = self.mesh(element_size_mm, true, watch)?;
        let (count, boundary) = (domain.mesh.cell_count(), Space::of(self.specimen).boundary(at_walls));
        let solutions = Solutions { fine: solve(&domain, true)?, coarser, sizes: Sizes::DOUBLED };
        Ok((solutions, Resolution::of_tetrahedra(boundary, count, element_size_mm)))
    }

    /// The mesh of elements of a size; in a fine one every phase has nearly its exact volume.
    fn mesh(&self, element_size_mm: f64, is_fine: bool, watch: &dyn Watch) -> Result<Domain, EffectiveError> {
        let is_layer = self.itz == Itz::Layer;
        let options = MeshOptions {
            method: Method::FITTED,
            element_size_mm,
            itz: if is_layer { ItzForm::Solid } else { ItzForm::None },
            volumes: (!is_layer).then_some(Volumes::Exact),
            ..MeshOptions::default()
        };
        let parts = Parts { bodies: Cow::Borrowed(&self.bodies), specimen: self.specimen, phases: self.names.clone() };
        let mesh = build(parts.clone(), &options, &Tools { watch, ..Tools::default() })?;
        let found = if is_fine { PhaseOff::accept(&mesh, parts, &options, f64::INFINITY)? } else { None };
        if let Some(PhaseOff { phase, meshed, exact }) = found.filter(|found| found.is_beyond(PhaseOff::ACCEPTED)) {
            return Err(EffectiveError::Coarse { phase: self.names.name(phase).to_owned(), meshed, exact });
        }
        Ok(Domain::new(mesh))
    }

    /// Phase of a cell of their mesh. A shell has the cells whose centre lies in it.
    pub(super) fn phase(&self, mesh: &Mesh, cell: usize) -> Phase {
        match mesh.phase[cell] {
            // Cores have the phase of their owner: those of a phase of its own are shells.
            own @ (Phase::Mortar | Phase::Itz | Phase::Own(_)) => own,
            _ => self.phases[mesh.owner[cell] as usize],
        }
    }

    /// Films on the faces of bodies: the cell outside, the volume of the film there, mm3, and the normal.
    pub(super) fn films(&self, mesh: &Mesh) -> Vec<(usize, f64, Vec3)> {
        if self.itz != Itz::Film {
            return Vec::new();
        }
        let faces: Vec<(u32, u32, Vec3)> = faces(mesh.by_owner())
            .into_iter()
            .map(|face| {
                let [a, b, c] = [0, 1, 2].map(|corner| mesh.points[face.nodes[corner] as usize]);
                (face.behind, mesh.owner[face.cell as usize], (b - a).cross(&(c - a)) / 2.0)
            })
            .collect();
        let mut areas = vec![0.0; self.bodies.len()];
        faces.iter().for_each(|(_, owner, area)| areas[*owner as usize] += area.norm());
        let film = |(cell, owner, area): &(u32, u32, Vec3)| {
            let thickness = self.films[*owner as usize] / areas[*owner as usize];
            (*cell as usize, thickness * area.norm(), area.normalize())
        };
        faces.iter().map(film).filter(|(_, volume, _)| *volume > 0.0).collect()
    }
}
