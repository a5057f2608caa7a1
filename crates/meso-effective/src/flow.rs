//! Fluxes through the links of voxels: at their centres, and their mean.

use crate::field::{FieldCells, PropertyField};
use crate::grid::{End, Grid};
use crate::links::Links;
use crate::phases::Property;
use meso_collision::simd::{Wide, widest};
use meso_concrete::parallel;

/// Fluxes through the links of a grid whose potential is that of a unit gradient along `axis`, and a periodic part.
pub(crate) struct Flow<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) links: &'a Links,
    pub(crate) axis: usize,
    pub(crate) potential: &'a [f64],
}

impl Flow<'_> {
    /// Length of the link below voxel `number` along an axis, 0 without a link; `counts` gives the link above the last.
    pub(crate) fn length(&self, axis: usize, number: usize) -> f64 {
        self.grid.link(axis, number).map_or(0.0, |link| link.to - link.from)
    }

    /// Flux through the link below voxel `at` along `axis`, and its energy; along z also above the last layer.
    fn through(&self, axis: usize, at: [usize; 3]) -> (f64, f64) {
        let [nx, ny, nz] = self.links.counts;
        let index = |[i, j, k]: [usize; 3]| (k * ny + j) * nx + i;
        let count = self.links.counts[axis];
        let u = |mut at: [usize; 3], place: Option<usize>| {
            place.map_or(0.0, |place| {
                at[axis] = place;
                self.potential[index(at)]
            })
        };
        let open = self.grid.ends[axis] == End::Fixed;
        let above = if at[axis] < count { Some(at[axis]) } else { (!open).then_some(0) };
        let below = if at[axis] > 0 { Some(at[axis] - 1) } else { (!open).then_some(count - 1) };
        let link = if axis < 2 && at[axis] == count { [at[0] % nx, at[1] % ny, at[2]] } else { at };
        debug_assert!(link[2] <= nz);
        let given = if axis == self.axis { self.length(axis, at[axis]) } else { 0.0 };
        let difference = given + u(at, above) - u(at, below);
        let flux = f64::from(self.links.across[axis][index(link)]) * difference;
        (flux, flux * difference)
    }

    /// Flux at the centre of a voxel, along the grid's axes.
    fn at_centre(&self, at: [usize; 3]) -> [f64; 3] {
        [0, 1, 2].map(|axis| {
            let mut above = at;
            above[axis] += 1;
            (self.through(axis, at).0 + self.through(axis, above).0) / (2.0 * self.grid.area(axis))
        })
    }

    /// Differences of potential along the links of a coupled voxel, and the coupled fluxes through them.
    pub(crate) fn coupled_fluxes(&self, number: usize) -> [[f64; 6]; 2] {
        self.links.coupled_fluxes(number, self.potential, self.given())
    }

    /// Given differences of potential along whole links of each axis.
    pub(crate) fn given(&self) -> [f64; 3] {
        [0, 1, 2].map(|axis| if axis == self.axis { self.grid.spacing[axis] } else { 0.0 })
    }

    /// Sums over the links of a layer: flux times length, along the grid's axes, and flux times difference of potential, the
    /// energy. The last layer has the links above it, too.
    pub(crate) fn sums(&self, k: usize) -> [f64; 4] {
        let [_, ny, nz] = self.links.counts;
        let mut sums = [0.0; 4];
        let last = k + 1 == nz && self.grid.ends[2] == End::Fixed;
        for j in 0..ny {
            let above = last.then_some((2, k + 1));
            for (axis, layer) in [(0, k), (1, k), (2, k)].into_iter().chain(above) {
                let length = self.length(axis, if axis == 2 { layer } else { 1 });
                let [flux, energy] = self.row_sums(axis, j, layer, if axis == self.axis { length } else { 0.0 });
                sums[axis] += flux * length;
                sums[3] += energy;
            }
        }
        for number in self.links.coupled_in(k) {
            let [differences, fluxes] = self.coupled_fluxes(number);
            for (side, flux) in fluxes.into_iter().enumerate() {
                sums[side / 2] += flux * self.grid.spacing[side / 2];
                sums[3] += flux * differences[side];
            }
        }
        sums
    }

    /// Sums of the fluxes through the links along `axis` below a row of voxels, and of their energies.
    fn row_sums(&self, axis: usize, j: usize, k: usize, given: f64) -> [f64; 2] {
        let [nx, ny, nz] = self.links.counts;
        let outside = vec![0.0; nx];
        let start = |j: usize, k: usize| (k * ny + j) * nx;
        let row = |j: usize, k: usize| &self.potential[start(j, k)..][..nx];
        let links = &self.links.across[axis][start(j, k)..][..nx];
        let before = |i: usize, n: usize| if i == 0 { n - 1 } else { i - 1 };
        let walled = self.grid.ends[2] == End::Fixed;
        let own = if k == nz { &outside[..] } else { row(j, k) };
        let sums = |own, below, links| widest(Fluxes { own, below, links, given });
        match axis {
            0 => {
                let [ends, inner] =
                    [sums(&own[..1], &own[nx - 1..], &links[..1]), sums(&own[1..], &own[..nx - 1], &links[1..])];
                [ends[0] + inner[0], ends[1] + inner[1]]
            }
            1 => sums(own, row(before(j, ny), k), links),
            _ if k == 0 && walled => sums(own, &outside, links),
            _ => sums(own, row(j, before(k, nz)), links),
        }
    }

    /// Mean flux along the grid's axes. Along the gradient it is the energy, whose error is the square of the potential's.
    pub(crate) fn mean(&self) -> [f64; 3] {
        let layers = parallel::map(self.links.counts[2], |k| self.sums(k));
        [0, 1, 2].map(|axis| {
            let which = if axis == self.axis { 3 } else { axis };
            layers.iter().map(|sums| sums[which]).sum::<f64>() / self.grid.volume()
        })
    }

    /// Energy of the given gradient alone.
    pub(crate) fn given_energy(&self) -> f64 {
        let [nx, ny, nz] = self.links.counts;
        let (len, along_z) = (nx * ny, self.axis == 2);
        let layers = nz + usize::from(along_z && self.grid.ends[2] == End::Fixed);
        let nothing = vec![0.0; len];
        let layer = |k: usize| {
            let links = &self.links.across[self.axis][k * len..][..len];
            let given = self.length(self.axis, if along_z { k } else { 1 });
            let [_, energy] = widest(Fluxes { own: &nothing, below: &nothing, links, given });
            energy
        };
        let coupled = (0..self.links.coupled()).map(|number| {
            let [differences, fluxes] = self.coupled_fluxes(number);
            differences.iter().zip(fluxes).map(|(difference, flux)| difference * flux).sum::<f64>()
        });
        parallel::map(layers, layer).iter().sum::<f64>() + coupled.sum::<f64>()
    }

    /// Flux into each voxel that the given gradient leaves over.
    pub(crate) fn sources(&self) -> Vec<f64> {
        let [nx, ny, nz] = self.links.counts;
        let links = &self.links.across[self.axis];
        let length = |k: usize| self.length(self.axis, if self.axis == 2 { k } else { 1 });
        let mut sources = vec![0.0; nx * ny * nz];
        parallel::chunks_mut(&mut sources, nx * ny, |k, layer| {
            let (from, to) = (length(k), length(k + 1));
            let source = |below: f32, above: f32| f64::from(above) * to - f64::from(below) * from;
            for (j, row) in layer.chunks_mut(nx).enumerate() {
                let links = |j: usize, k: usize| &links[(k * ny + j) * nx..][..nx];
                let below = links(j, k);
                let above = match self.axis {
                    0 => {
                        row[nx - 1] = source(below[nx - 1], below[0]);
                        &below[1..]
                    }
                    1 => links(if j + 1 == ny { 0 } else { j + 1 }, k),
                    _ => links(j, k + 1),
                };
                let ends = below.iter().zip(above);
                row.iter_mut().zip(ends).for_each(|(row, (below, above))| *row = source(*below, *above));
            }
        });
        for number in 0..self.links.coupled() {
            self.links.coupled_out(number, self.potential, self.given(), |voxel, flux| sources[voxel] -= flux);
        }
        sources
    }

    /// The field in the specimen's axes, of which `last` is the grid's third.
    pub(crate) fn field(&self, what: Property, last: usize) -> PropertyField {
        let turned = |axis: usize| (axis + 2 - last) % 3;
        let spacing_mm = [0, 1, 2].map(|axis| self.grid.spacing[turned(axis)]);
        let origin_mm = [0, 1, 2].map(|axis| self.grid.origin[turned(axis)]);
        let counts = [0, 1, 2].map(|axis| self.grid.counts[turned(axis)]);
        let [nx, ny, nz] = counts;
        let at = |number: usize| {
            let place = [number % nx, number / nx % ny, number / (nx * ny)];
            let mut at = [0; 3];
            (0..3).for_each(|axis| at[turned(axis)] = place[axis]);
            at
        };
        let [gx, gy, _] = self.grid.counts;
        let total = |number: usize| {
            let at = at(number);
            let given = (at[self.axis] as f64 + 0.5) * self.grid.spacing[self.axis];
            (given + self.potential[(at[2] * gy + at[1]) * gx + at[0]]) as f32
        };
        let flux = |number: usize| {
            let flux = self.at_centre(at(number));
            [0, 1, 2].map(|axis| flux[turned(axis)] as f32)
        };
        let axis = (0..3).find(|axis| turned(*axis) == self.axis).unwrap_or(last);
        let mut flux: Vec<[f32; 3]> = (0..nx * ny * nz).map(flux).collect();
        let place = |voxel: usize| {
            let at = [voxel % gx, voxel / gx % gy, voxel / (gx * gy)];
            (at[turned(2)] * ny + at[turned(1)]) * nx + at[turned(0)]
        };
        for number in 0..self.links.coupled() {
            let [_, coupled] = self.coupled_fluxes(number);
            for (side, voxel, beside) in self.links.coupled_ends(number) {
                let (axis, half) = ((side / 2 + last + 1) % 3, coupled[side] / (2.0 * self.grid.area(side / 2)));
                flux[place(voxel)][axis] += half as f32;
                flux[place(beside)][axis] += half as f32;
            }
        }
        let potential = (0..nx * ny * nz).map(total).collect();
        let cells = FieldCells::Voxels { counts, origin_mm, spacing_mm };
        PropertyField { what: what.name(), component: axis, cells, potential, values: flux.into_flattened() }
    }
}

/// A run of links with the potentials at their ends and the given difference.
pub(crate) struct Fluxes<'a> {
    pub(crate) own: &'a [f64],
    pub(crate) below: &'a [f64],
    pub(crate) links: &'a [f32],
    pub(crate) given: f64,
}

impl Wide for Fluxes<'_> {
    type Output = [f64; 2];
    #[inline(always)]
    fn run(self) -> [f64; 2] {
        let (mut flux, mut energy) = ([0.0; 8], [0.0; 8]);
        let mut add = |i: usize, link: f32, own: f64, below: f64| {
            let difference = self.given + own - below;
            let through = f64::from(link) * difference;
            flux[i] += through;
            energy[i] += through * difference;
        };
        let (links, links_rest) = self.links.as_chunks::<8>();
        let (own, own_rest) = self.own.as_chunks::<8>();
        let (below, below_rest) = self.below.as_chunks::<8>();
        for ((links, own), below) in links.iter().zip(own).zip(below) {
            (0..8).for_each(|i| add(i, links[i], own[i], below[i]));
        }
        (0..links_rest.len()).for_each(|i| add(i, links_rest[i], own_rest[i], below_rest[i]));
        [flux.iter().sum(), energy.iter().sum()]
    }
}
