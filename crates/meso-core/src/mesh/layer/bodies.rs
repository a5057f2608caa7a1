//! Bodies and their images in a periodic box, told apart while the layer is made.
//!
//! An aggregate and its images share an id in a mesh, and each of them shrinks to a place of its own. So the cells carry
//! the body's index in the meantime; of several with the cell's id it is the one that the cell lies deepest in.

use crate::aggregate::Aggregate;
use crate::geometry::Plane;
use crate::math::Vec3;
use crate::mesh::{Mesh, NO_AGGREGATE};
use rayon::prelude::*;

/// Bodies, those of one id beside each other.
pub(super) struct Bodies<'a> {
    all: &'a [Aggregate],
    /// Indices, by id.
    by_id: Vec<u32>,
    /// For every body how far it lies from the first of its id, in boxes along each axis.
    shifts: Vec<[i32; 3]>,
}

/// What a body and its images have in common, seen from one of them: its id, and the boxes between them.
pub(super) type Key = (u32, [i32; 3]);

impl<'a> Bodies<'a> {
    /// `size` is the box's, mm.
    pub(super) fn new(all: &'a [Aggregate], size: &Vec3) -> Self {
        let mut by_id: Vec<u32> = (0..all.len() as u32).collect();
        by_id.sort_by_key(|&index| all[index as usize].id);
        let mut shifts = vec![[0; 3]; all.len()];
        for same in by_id.chunk_by(|&a, &b| all[a as usize].id == all[b as usize].id) {
            let corner = |index: u32| all[index as usize].body.vertices()[0];
            for &index in same {
                let boxes = (corner(index) - corner(same[0])).component_div(size);
                shifts[index as usize] = [0, 1, 2].map(|axis| boxes[axis].round() as i32);
            }
        }
        Self { all, by_id, shifts }
    }

    pub(super) fn count(&self) -> u32 {
        self.all.len() as u32
    }

    /// One body of each id.
    pub(super) fn first_of_each(&self) -> impl Iterator<Item = u32> {
        self.by_id.chunk_by(|&a, &b| self.get(a).id == self.get(b).id).map(|same| same[0])
    }

    pub(super) fn get(&self, index: u32) -> &'a Aggregate {
        &self.all[index as usize]
    }

    /// The body as its image at the lower faces sees it, from an image that lies on the upper faces `along` (a bit per
    /// axis): the same for all images of one place. [`NO_AGGREGATE`] is the same everywhere.
    pub(super) fn key(&self, index: u32, along: u8) -> Key {
        if index == NO_AGGREGATE {
            return (NO_AGGREGATE, [0; 3]);
        }
        let shift = self.shifts[index as usize];
        (self.get(index).id, [0, 1, 2].map(|axis| shift[axis] - i32::from(along >> axis & 1)))
    }

    /// Gives the cells the indices of their bodies in place of the ids.
    pub(super) fn tell_apart(&self, mesh: &mut Mesh) {
        let planes: Vec<Vec<Plane>> = self.all.par_iter().map(|a| self.planes_of_several(a)).collect();
        let points = &mesh.points;
        mesh.cells.par_chunks_exact(4).zip(&mut mesh.aggregate).for_each(|(cell, id)| {
            if *id != NO_AGGREGATE {
                let centroid = || cell.iter().map(|&node| points[node as usize]).sum::<Vec3>() / 4.0;
                *id = match self.of_id(*id) {
                    [one] => *one,
                    several => deepest(several, &planes, &centroid()),
                };
            }
        });
    }

    /// Gives the cells the ids again.
    pub(super) fn name(&self, mesh: &mut Mesh) {
        let cells = mesh.aggregate.iter_mut().filter(|index| **index != NO_AGGREGATE);
        cells.for_each(|index| *index = self.get(*index).id);
    }

    fn of_id(&self, id: u32) -> &[u32] {
        let start = self.by_id.partition_point(|&index| self.get(index).id < id);
        let count = self.by_id[start..].partition_point(|&index| self.get(index).id == id);
        &self.by_id[start..start + count]
    }

    /// The face planes of a body that shares its id; none of others, that nobody asks for.
    fn planes_of_several(&self, aggregate: &Aggregate) -> Vec<Plane> {
        if self.of_id(aggregate.id).len() > 1 { aggregate.body.planes().collect() } else { Vec::new() }
    }
}

/// The one of `bodies` that `x` lies deepest in, or closest to.
fn deepest(bodies: &[u32], planes: &[Vec<Plane>], x: &Vec3) -> u32 {
    let height = |body: u32| {
        let heights = planes[body as usize].iter().map(|plane| plane.normal.dot(x) - plane.offset);
        (heights.fold(f64::NEG_INFINITY, f64::max), body)
    };
    let heights = bodies.iter().map(|&body| height(body));
    heights.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(NO_AGGREGATE, |(_, body)| body)
}
