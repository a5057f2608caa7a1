//! Diffusivity, conductivity and permeability of a mesh with cracks: of a moment of a test.
//!
//! A cell has a layer of its material and one layer for the crack across each principal axis n of its crack strain, whose principal
//! value f is the crack's share of the cell. With the value m of the phase and c of what fills the crack, a gradient along an axis
//! passes the cracks that it lies in beside the material, p = (1 - F) m + F c with the share F of these, and the crack across it after
//! it: 1 / ((1 - f) / p + f / c).
//!
//! Permeability has c = w^2 / 12 along a crack of the opening w, and no resistance across. A law's band has uneven openings in its
//! elements, and the cubic law would take their peaks. So w is that of the whole band: the crack strain along n, integrated from the cell's
//! centroid over a band's width on either side. A band of any width and number of elements then carries w^3 / 12.
//!
//! The sides of a test are free, so each axis has given potentials at its ends. There is one mesh. Its error follows from the
//! solution itself: the energy that a quadratic bubble on each edge, alone, would take away (Bank and Smith, SIAM J. Numer. Anal.
//! 30, 1993, 921).

use super::domain::{Domain, GIVEN};
use super::flux::{Conduction, Task, unit};
use crate::boundary::Boundary;
use crate::effective::{At, CRACK, Effective, EffectiveOptions, PhaseShare};
use crate::error::{self, EffectiveError};
use crate::estimate::Sizes;
use crate::field::PropertyField;
use crate::phases::{PhaseValues, Phases, Property};
use crate::resolution::Resolution;
use crate::solutions::Solutions;
use meso_collision::geometry::principal_axes;
use meso_collision::math::{Aabb, Mat3, Vec3};
use meso_concrete::watch::Watch;
use meso_concrete::{OutOfRange, Phase, PhaseNames, Ranges, parallel};
use meso_mesh::Mesh;
use meso_mesh::cells::CellKind;

/// A mesh with cracks.
#[derive(Clone, Copy, Debug)]
pub struct Cracked<'a> {
    /// The mesh; its sides are free.
    pub mesh: &'a Mesh,
    /// Strain of the cracks in every cell, xx yy zz xy yz zx.
    pub crack_strain: &'a [[f32; 6]],
    /// Opening of the widest crack in every cell, mm: over its crack strain it is the width of the band.
    pub opening_mm: &'a [f32],
    /// Share of the stiffness that is left in every cell.
    pub stiffness_left: &'a [f32],
    /// Volume of the cells over that of the specimen: less than 1 where voids have none.
    pub filled: f64,
    /// When.
    pub at: At,
}

/// What fills the cracks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CrackValues {
    /// Diffusivity, in the unit of the phases.
    pub diffusivity: Option<f64>,
    /// Conductivity, W/(m K).
    pub conductivity: Option<f64>,
    /// Factor of the cubic law for rough walls.
    pub roughness: Option<f64>,
}

/// Diffusivity of chloride in water over that in mortar, illustrative: 2e-9 and 1e-11 m2/s.
const WATER: f64 = 200.0;
/// Conductivity of water, W/(m K).
const WATER_W_PER_M_K: f64 = 0.6;
/// Largest ratio of a crack's value to the mortar's.
const CONTRAST: f64 = 1e6;
/// Most of a cell that its cracks fill.
const FULL: f64 = 0.999;
/// Largest area of an end, over the mean section, that is no flat end.
const FLAT: f64 = 0.5;
/// Distance of a side's faces from its plane, over the specimen's length.
const IN_PLANE: f64 = 1e-9;
/// Error over the energy that the bubbles take away: see docs/effective.md.
const SAFE: f64 = 2.0;
/// Most cells that a line through a crack crosses.
const MOST_CROSSED: usize = 100;
/// Bytes a tetrahedron, with its cracks.
const BYTES: f64 = 300.0;

impl CrackValues {
    /// Values in their ranges, those of water if omitted: of the cracks, and the factor of the cubic law.
    ///
    /// # Errors
    /// The first value out of its range.
    fn settle(&self, what: Property, mortar: f64) -> Result<[f64; 2], OutOfRange> {
        let (key, value) = match what {
            Property::Diffusivity => ("crack_diffusivity", self.diffusivity.unwrap_or(WATER * mortar)),
            Property::Conductivity => ("crack_conductivity", self.conductivity.unwrap_or(WATER_W_PER_M_K)),
            Property::Permeability => ("crack_conductivity", 0.0),
        };
        let (ranges, most) = (Ranges("effective"), CONTRAST * mortar);
        let accepted = format!("it must be 0 to {most}, 1000000 times the mortar's");
        ranges.require(key, value, (0.0..=most).contains(&value), accepted)?;
        let roughness = self.roughness.unwrap_or(1.0);
        let accepted = "it must be 0 to 1, the share of the flow between smooth walls; 0.1 to 0.5 is usual";
        ranges.require("crack_roughness", roughness, (0.0..=1.0).contains(&roughness), accepted)?;
        Ok([value, roughness])
    }
}

impl Cracked<'_> {
    /// Refuses a property that it cannot have; the memory that it takes at most, bytes.
    ///
    /// # Errors
    /// Values out of range, conditions at walls but fixed ones, and axes without flat ends.
    pub fn accept(
        &self,
        phases: &Phases,
        cracks: &CrackValues,
        options: &EffectiveOptions,
    ) -> Result<f64, EffectiveError> {
        let values = phases.values(options.what);
        values.validate(options.what, &self.mesh.phases)?;
        cracks.settle(options.what, values.mortar)?;
        error::accept_tolerance(options.tolerance)?;
        let is_fixed = options.boundary == Boundary::Fixed;
        Ranges("effective").require(
            "boundary",
            options.boundary.name(),
            is_fixed,
            "a cracked specimen has fixed ends",
        )?;
        Ok(BYTES * (self.mesh.cell_count() * self.mesh.kind.tetrahedra().len()) as f64)
    }

    /// Its tetrahedra, with the volume of the whole specimen.
    ///
    /// # Errors
    /// Axes along which it has no flat ends.
    pub(super) fn domain(&self, axes: [bool; 3]) -> Result<Domain, EffectiveError> {
        let mut domain = Domain::new(in_tetrahedra(self.mesh));
        domain.volume /= self.filled;
        has_ends(&domain, axes).map(|()| domain)
    }

    /// Volumes of the phases over the specimen's, with the share of every tetrahedron that its phase has. A test leaves voids out.
    pub(super) fn volumes(&self, domain: &Domain, share: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
        let parts = self.mesh.kind.tetrahedra().len();
        let volume = |own: Phase| {
            let is_own = |part: usize| self.mesh.phase[part / parts] == own;
            let [volume] =
                domain.sums(|part| [if is_own(part) { share(part) } else { 0.0 } * domain.cell(part).volume]);
            volume / domain.volume + if own == Phase::Void { 1.0 - self.filled } else { 0.0 }
        };
        self.mesh.phases.all().map(volume).collect()
    }
}

/// The effective property of a mesh with cracks, and the fields if asked for. The size of voxels in `options` does not matter.
///
/// # Errors
/// Those of [`Cracked::accept`], and equations that do not converge.
pub fn effective_in_cracks(
    of: &Cracked<'_>,
    phases: &Phases,
    cracks: &CrackValues,
    options: &EffectiveOptions,
    watch: &dyn Watch,
) -> Result<(Effective, Vec<PropertyField>), EffectiveError> {
    of.accept(phases, cracks, options)?;
    let (values, what) = (phases.values(options.what), options.what);
    let [crack, roughness] = cracks.settle(what, values.mortar)?;
    let domain = of.domain(options.axes)?;
    let parts = of.mesh.kind.tetrahedra().len();
    let layers = parallel::map_short(of.mesh.cell_count(), |cell| Layers::of(&of.crack_strain[cell]));
    let of_part = |part: usize| layers[part / parts].as_ref();
    let (names, phase) = (&of.mesh.phases, |part: usize| of.mesh.phase[part / parts]);
    // The value of each crack in a cell.
    let cracks = |part: usize, layers: &Layers| match what {
        Property::Permeability => [0, 1, 2].map(|axis| {
            let reach = f64::from(of.opening_mm[part / parts]) / layers.shares[2];
            let opening = opening(&domain, (part, &layers.normals.column(axis).into()), reach, |part| {
                symmetric(&of.crack_strain[part / parts])
            });
            roughness * opening * opening / 12.0
        }),
        Property::Diffusivity | Property::Conductivity => [crack; 3],
    };
    let cracks = parallel::map_short(domain.mesh.cell_count(), |part| {
        of_part(part).map_or([0.0; 3], |layers| cracks(part, layers))
    });
    let resists = what != Property::Permeability;
    let tensor =
        |part: usize| of_part(part).map(|layers| layers.tensor(values.of(phase(part), names), cracks[part], resists));
    let conduction = Conduction::of_cells(&domain, phase, (&values, names), tensor);
    let stages = options.axes.iter().filter(|axis| **axis).count();
    let task = Task { conduction, options, fields: options.fields, shows_excess: true, watch, stages };
    let solutions = Solutions { fine: task.columns()?, coarser: Vec::new(), sizes: Sizes::DOUBLED };
    let share = |part: usize| of_part(part).map_or(0.0, Layers::share);
    let volumes = of.volumes(&domain, |part| 1.0 - share(part));
    let [cracked, opened, conducted] = domain.sums(|part| {
        let volume = domain.cell(part).volume;
        let sum = |layers: &Layers| layers.shares.iter().zip(cracks[part]).map(|(share, value)| share * value).sum();
        let opened = of_part(part).map_or(0.0, |layers| layers.shares.iter().sum());
        [share(part) * volume, opened * volume, of_part(part).map_or(0.0, sum) * volume]
    });
    let phase_share = |(phase, volume_fraction)| {
        let value = if phase == Phase::Void { 0.0 } else { values.of(phase, names) };
        PhaseShare { name: names.name(phase).to_owned(), value, volume_fraction }
    };
    let mut shares: Vec<PhaseShare> = names.all().zip(volumes).map(phase_share).collect();
    if cracked > 0.0 {
        // The flux through openings that are wider than their cells counts, too.
        let value = if resists && opened == cracked { crack } else { conducted / cracked };
        shares.push(PhaseShare { name: CRACK.to_owned(), value, volume_fraction: cracked / domain.volume });
    }
    let resolution = Resolution::of_mesh(["fixed"; 3], domain.mesh.cell_count());
    let (mut found, fields) = Effective::new(what, solutions, shares, resolution);
    found.at = of.at;
    if of.filled < 1.0 && values.void > 0.0 {
        found.warnings.push("the mesh of a test has no voids; they count as 0".to_owned());
    }
    Ok((found, fields))
}

/// A mesh of tetrahedra; boxes have six each.
fn in_tetrahedra(mesh: &Mesh) -> Mesh {
    let parts = mesh.kind.tetrahedra();
    let cells = mesh.cells().flat_map(|nodes| parts.iter().flat_map(move |part| part.map(|corner| nodes[corner])));
    let repeated = |of: &[u32]| of.iter().flat_map(|owner| parts.iter().map(move |_| *owner)).collect();
    let phase = mesh.phase.iter().flat_map(|phase| parts.iter().map(move |_| *phase)).collect();
    let new = Mesh::of(CellKind::Tetrahedron, mesh.points.clone(), cells.collect(), phase, repeated(&mesh.owner));
    Mesh { id_of: mesh.id_of.clone(), phases: mesh.phases.clone(), ..new }
}

/// Refuses axes along which a mesh has no flat ends.
fn has_ends(domain: &Domain, axes: [bool; 3]) -> Result<(), EffectiveError> {
    let around = Aabb::around(&domain.mesh.points);
    let is_flat = |side: usize| {
        let (axis, plane) = (side / 2, if side.is_multiple_of(2) { around.min } else { around.max });
        let area = |(cell, face): &(u32, usize)| {
            let [a, b, c] = domain.face(*cell as usize, *face).map(|node| domain.mesh.points[node]);
            let off = [a, b, c].map(|point| (point - plane)[axis].abs()).into_iter().fold(0.0, f64::max);
            // A curved side has faces beside its plane.
            if off > IN_PLANE * around.size().max() { 0.0 } else { (b - a).cross(&(c - a)).norm() / 2.0 }
        };
        let area: f64 = domain.sides.faces()[side].iter().map(area).sum();
        area * around.size()[axis] > FLAT * domain.volume
    };
    let flat = [0, 1, 2].map(|axis| is_flat(2 * axis) && is_flat(2 * axis + 1));
    if (0..3).all(|axis| flat[axis] || !axes[axis]) {
        return Ok(());
    }
    let names = |of: [bool; 3]| (0..3).filter(|axis| of[*axis]).map(|axis| ["x", "y", "z"][axis]).collect::<String>();
    let accepted = match flat {
        [false, false, false] => "the specimen has no flat ends; take a cube, a box, a prism or a cylinder".to_owned(),
        flat => format!("the specimen has flat ends along {} alone", names(flat)),
    };
    Err(Ranges("effective").error("axes", names(axes), accepted).into())
}

/// A tensor by its components xx yy zz xy yz zx.
fn symmetric(of: &[f32; 6]) -> Mat3 {
    let [xx, yy, zz, xy, yz, zx] = of.map(f64::from);
    Mat3::new(xx, xy, zx, xy, yy, yz, zx, yz, zz)
}

/// The cracks of a cell.
#[derive(Clone, Copy, Debug)]
struct Layers {
    /// Their normals, as columns.
    normals: Mat3,
    /// Their openings over the width of the band.
    shares: [f64; 3],
}

impl Layers {
    fn of(crack_strain: &[f32; 6]) -> Option<Self> {
        if *crack_strain == [0.0; 6] {
            return None;
        }
        let strain = symmetric(crack_strain);
        let normals = principal_axes(&strain);
        let shares = [0, 1, 2].map(|axis| normals.column(axis).dot(&(strain * normals.column(axis))).max(0.0));
        Some(Self { normals, shares })
    }

    /// Their share of the cell; one that was torn apart is full of them.
    fn share(&self) -> f64 {
        self.shares.iter().sum::<f64>().min(FULL)
    }

    /// The tensor of a cell of a `value`, with those of its cracks, which may have no resistance across.
    fn tensor(&self, value: f64, cracks: [f64; 3], resists: bool) -> Mat3 {
        let along = |axis: usize| {
            let own = self.shares[axis].min(FULL);
            let others = || (0..3).filter(|other| *other != axis);
            let solid = 1.0 - others().map(|other| self.shares[other]).sum::<f64>().min(FULL);
            let mixed = solid * value + others().map(|other| self.shares[other] * cracks[other]).sum::<f64>();
            let across = if own > 0.0 && resists { own / cracks[axis] } else { 0.0 };
            if mixed > 0.0 { 1.0 / ((1.0 - own) / mixed + across) } else { 0.0 }
        };
        let diagonal = Mat3::from_diagonal(&Vec3::from_fn(|axis, _| along(axis)));
        self.normals * diagonal * self.normals.transpose()
    }
}

/// The opening along `normal` of the cracks around the centroid of a cell, as far as `reach` on either side.
fn opening(domain: &Domain, (cell, normal): (usize, &Vec3), reach: f64, strain: impl Fn(usize) -> Mat3) -> f64 {
    let one_way = |normal: Vec3| {
        let (mut cell, mut entered, mut left, mut opening) = (cell, None, reach, 0.0);
        let mut point = domain.nodes(cell).map(|node| domain.mesh.points[node]).into_iter().sum::<Vec3>() / 4.0;
        for _ in 0..MOST_CROSSED {
            let (nodes, gradients) = (domain.nodes(cell), domain.cell(cell).gradients);
            let from = domain.mesh.points[nodes[0]];
            // Where each shape function becomes 0.
            let exit = (0..4).filter(|corner| entered != Some(*corner)).filter_map(|corner| {
                let fall = -gradients[corner].dot(&normal);
                let value = f64::from(u8::from(corner == 0)) + gradients[corner].dot(&(point - from));
                (fall > 0.0).then(|| (corner, (value / fall).max(0.0)))
            });
            let Some((corner, distance)) = exit.min_by(|a, b| a.1.total_cmp(&b.1)) else { break };
            opening += normal.dot(&(strain(cell) * normal)) * distance.min(left);
            left -= distance;
            let Some(next) = domain.beyond(cell, corner).filter(|_| left > 0.0) else { break };
            point += normal * distance;
            entered = domain.nodes(next).iter().position(|node| !nodes.contains(node));
            cell = next;
        }
        opening
    };
    one_way(*normal) + one_way(-normal)
}

impl<'a> Conduction<'a> {
    /// Cells with the value of their phase, or with a tensor of their own.
    fn of_cells(
        domain: &'a Domain,
        phase: impl Fn(usize) -> Phase + Sync,
        (values, names): (&PhaseValues, &PhaseNames),
        tensor: impl Fn(usize) -> Option<Mat3> + Sync,
    ) -> Self {
        let count = domain.mesh.cell_count();
        let mut of = parallel::map_short(count, |cell| u32::from(phase(cell).number()));
        let mut tensors: Vec<Mat3> = names.all().map(|phase| Mat3::identity() * values.of(phase, names)).collect();
        for (cell, own) in parallel::map_short(count, tensor).into_iter().enumerate() {
            if let Some(own) = own {
                of[cell] = tensors.len() as u32;
                tensors.push(own);
            }
        }
        Self { domain, of, tensors }
    }

    /// Most by which the value along `axis` exceeds the exact one: see the head of this file.
    pub(super) fn excess(&self, of: &[u32], axis: usize, potential: &[f64]) -> f64 {
        let given = unit(axis);
        let energies = parallel::map_short(self.domain.mesh.points.len(), |node| {
            // The other end of each edge, the residual of its bubble, and the bubble's energy.
            let mut edges: Vec<(usize, f64, f64)> = Vec::with_capacity(16);
            for (cell, at) in self.domain.corners(node as u32).filter(|(cell, _)| self.conducts(*cell)) {
                let (nodes, tetrahedron) = (self.domain.nodes(cell), self.domain.cell(cell));
                let (tensor, g) = (self.tensor(cell), &tetrahedron.gradients);
                let flux = tensor * self.gradient(cell, &given, of, potential) * tetrahedron.volume;
                for (other, end) in nodes.into_iter().enumerate().filter(|(_, end)| *end > node) {
                    if of[node] == GIVEN && of[end] == GIVEN {
                        continue;
                    }
                    let (a, b) = (&g[at], &g[other]);
                    let residual = flux.dot(&(a + b));
                    let energy = a.dot(&(tensor * a)) + b.dot(&(tensor * b)) + a.dot(&(tensor * b));
                    let energy = 1.6 * tetrahedron.volume * energy;
                    match edges.iter_mut().find(|edge| edge.0 == end) {
                        Some(edge) => (edge.1, edge.2) = (edge.1 + residual, edge.2 + energy),
                        None => edges.push((end, residual, energy)),
                    }
                }
            }
            edges.iter().filter(|edge| edge.2 > 0.0).map(|edge| edge.1 * edge.1 / edge.2).sum::<f64>()
        });
        SAFE * energies.iter().sum::<f64>() / self.domain.volume
    }
}
