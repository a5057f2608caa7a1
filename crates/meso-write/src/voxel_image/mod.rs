//! Voxel images of a packing: which phase or grain holds each voxel, how much of it, and how far the next surface is.
//!
//! Arrays are [z, y, x] in C order. Voxel (k, j, i) has its centre at (i + 0.5, j + 0.5, k + 0.5) h from the lower corner
//! of the specimen's bounding box, or of the box asked for. A voxel lies in a body if its centre lies in the closed
//! polyhedron. Rows along x meet a convex body in one interval, which its face planes cut out; see
//! [`location`](meso_mesh::location). Images are made slab by slab, so that memory does not grow with their size.

mod distance;
mod options;
mod outside;
mod share;

pub use options::{ImageOptions, Quantity, Region, ShareOf};

pub use crate::export::raster::Voxels;
use crate::export::raster::{Frame, ValueKind};
use meso_concrete::aggregate::Aggregate;

use distance::Surfaces;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::images::near as images_near;
use meso_concrete::parallel;
use meso_concrete::specimen::Container;
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_mesh::cells::Phase;
use meso_mesh::location::{Facets, PointGrid, Scan};
use meso_pack::model::Model;
use meso_pack::spec::SpecError;
use share::Shares;
use std::ops::Range;
use std::sync::Arc;

/// The label of voxels outside the specimen.
const OUTSIDE: u8 = 255;
/// The id of voxels in no grain.
const NO_GRAIN: i32 = -1;
/// The id of voxels outside the specimen.
const OUTSIDE_ID: i32 = -2;

/// Voxels that are made at a time: 32 MB of shares, and enough layers of any image for many threads.
const AT_ONCE: usize = 8 << 20;

/// An image that is ready to be made.
pub struct VoxelImage {
    grid: PointGrid,
    corner: Vec3,
    section: Option<usize>,
    quantity: Quantity,
    maker: Maker,
    container: Arc<dyn Container>,
}

/// Data of the bodies that a quantity needs.
enum Maker {
    /// Shell and core of every body.
    Phase(Scan<'static>, Vec<[u8; 2]>),
    /// The id of every body.
    Grain(Scan<'static>, Vec<i32>),
    Share(Shares),
    Distance(Scan<'static>, Surfaces),
}

impl VoxelImage {
    /// Prepares the image that `options` ask for; nothing of it is made yet.
    ///
    /// # Errors
    /// Names the option, its value and the accepted range.
    pub fn new(model: &Model, options: &ImageOptions) -> Result<Self, SpecError> {
        let specimen = &model.spec.specimen;
        let (corner, grid) = options.grid(specimen)?;
        let margin = match options.quantity {
            // No point is further than half a period from the nearest image of anything.
            Quantity::Distance => specimen.aabb().size().max() / 2.0,
            _ => 0.0,
        };
        let mut bodies = images_near(&model.bodies(), specimen, margin);
        if options.quantity != Quantity::Distance {
            let voxel = Vec3::repeat(options.voxel_size_mm);
            let last = Vec3::from_fn(|axis, _| grid.coordinate(axis, grid.counts[axis]));
            let shown = Aabb { min: grid.origin - voxel, max: last + voxel };
            bodies.retain(|body| body.body.aabb().intersects(&shown));
        }
        let maker = Maker::new(grid, options, &bodies);
        let section = if let Region::Section { axis, .. } = options.region { Some(axis) } else { None };
        Ok(Self { grid, corner, section, quantity: options.quantity, maker, container: specimen.container() })
    }

    /// Voxels along x, y and z; one across a section.
    pub fn counts(&self) -> [usize; 3] {
        self.grid.counts
    }

    /// Lower corner of the first voxel, mm.
    pub fn corner_mm(&self) -> [f64; 3] {
        self.corner.into()
    }

    /// Lengths of the array's axes, the slowest first: three of a volume, two of a section.
    pub fn shape(&self) -> Vec<usize> {
        self.frame().shape()
    }

    /// Bytes of its values in a file.
    pub fn bytes(&self) -> u64 {
        let value = if self.quantity == Quantity::Phase { 1 } else { 4 };
        self.shape().iter().fold(value, |bytes, &count| bytes * count as u64)
    }

    /// The grid and the type of the values.
    pub(crate) fn frame(&self) -> Frame {
        Frame {
            counts: self.grid.counts,
            corner_mm: self.corner.into(),
            voxel_size_mm: self.grid.spacing.x,
            section: self.section,
            name: self.quantity.name(),
            kind: match self.quantity {
                Quantity::Phase => ValueKind::Label,
                Quantity::Grain => ValueKind::Id,
                Quantity::Share | Quantity::Distance => ValueKind::Real,
            },
        }
    }

    /// The whole image, some layers at a time, from z = 0 upwards.
    pub fn slabs(&self) -> impl Iterator<Item = Voxels> {
        self.slabs_watched(&Silent)
    }

    /// Yields the slabs of [`VoxelImage::slabs`], and reports to `watch` as [`Stage::Image`].
    pub fn slabs_watched<'a>(&'a self, watch: &'a dyn Watch) -> impl Iterator<Item = Voxels> + 'a {
        let layers = self.grid.counts[2];
        let step = (AT_ONCE / self.grid.layer_len()).clamp(1, layers.max(1));
        (0..layers).step_by(step).map(move |from| {
            let made = self.layers(from..layers.min(from + step));
            watch.stage(Stage::Image, (from + step).min(layers) as f64 / layers as f64);
            made
        })
    }

    /// The values of some layers, x fastest.
    pub fn layers(&self, layers: Range<usize>) -> Voxels {
        match &self.maker {
            Maker::Phase(scan, labels) => {
                Voxels::Label(self.painted(layers, scan, labels, Phase::Mortar.number(), OUTSIDE))
            }
            Maker::Grain(scan, ids) => {
                let ids: Vec<[i32; 2]> = ids.iter().map(|&id| [id; 2]).collect();
                Voxels::Id(self.painted(layers, scan, &ids, NO_GRAIN, OUTSIDE_ID))
            }
            Maker::Share(shares) => Voxels::Real(self.made(layers, 0.0, |k, layer| shares.add(k, layer), None)),
            Maker::Distance(scan, surfaces) => {
                Voxels::Real(self.made(layers, f32::NAN, |k, layer| surfaces.measure(scan, k, layer), Some(f32::NAN)))
            }
        }
    }

    /// Layers in which shells and cores of bodies have their values.
    fn painted<T: Copy + Send + Sync>(
        &self,
        layers: Range<usize>,
        scan: &Scan,
        values: &[[T; 2]],
        mortar: T,
        outside: T,
    ) -> Vec<T> {
        self.made(layers, mortar, |k, layer| scan.paint_layer(k, layer, |body| values[body as usize]), Some(outside))
    }

    /// Layers that `make` fills, on all threads; voxels outside the specimen get a value of their own, if there is one.
    /// Shares have no such value: a voxel with its centre outside may hold a part of a body.
    fn made<T: Copy + Send + Sync>(
        &self,
        layers: Range<usize>,
        blank: T,
        make: impl Fn(usize, &mut [T]) + Sync,
        outside: Option<T>,
    ) -> Vec<T> {
        let first = layers.start;
        let mut values = vec![blank; layers.len() * self.grid.layer_len()];
        parallel::chunks_mut(&mut values, self.grid.layer_len(), |k, layer| {
            make(first + k, layer);
            if let Some(value) = outside {
                outside::mark(&*self.container, &self.grid, first + k, layer, value);
            }
        });
        values
    }
}

impl Maker {
    fn new(grid: PointGrid, options: &ImageOptions, bodies: &[Aggregate]) -> Self {
        let scan = || Scan::new(grid, Facets::all(bodies, |body| body.itz_thickness_mm));
        match options.quantity {
            Quantity::Phase => {
                let layers = parallel::flat_map(bodies.len(), |number| Facets::layers(&bodies[number]));
                let (facets, phases): (Vec<Facets>, Vec<Phase>) = layers.into_iter().unzip();
                let labels = phases.iter().map(|phase| [Phase::Itz, *phase].map(Phase::number)).collect();
                Self::Phase(Scan::new(grid, facets), labels)
            }
            Quantity::Grain => Self::Grain(scan(), bodies.iter().map(|body| body.id as i32).collect()),
            Quantity::Share => Self::Share(Shares::new(grid, options.of, bodies)),
            Quantity::Distance => Self::Distance(scan(), Surfaces::new(bodies)),
        }
    }
}
