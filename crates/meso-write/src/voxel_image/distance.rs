//! Distance of the centres of voxels from the nearest surface of a body.
//!
//! A layer is divided into square tiles. All voxels of a tile ask the same few bodies: heights above a body's planes and
//! distances from it change by no more than the way from the tile's centre.

use meso_collision::geometry::{BodySurface, BoxTree, Plane};
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use meso_concrete::stop;
use meso_mesh::location::{Label, PointGrid, Scan};
use std::ops::Range;

/// Voxels along the side of a tile. Larger ones ask more bodies for each voxel, smaller ones the tree more often.
const TILE: usize = 8;
/// From so many radii of a tile on, the tree is asked for a nearer body than those of the last tile.
const FAR: f64 = 4.0;

/// The bodies by their surfaces, and a tree of their boxes.
pub(super) struct Surfaces {
    bodies: Vec<BodySurface>,
    boxes: Vec<Aabb>,
    tree: BoxTree,
}

impl Surfaces {
    pub(super) fn new(aggregates: &[Aggregate]) -> Self {
        let boxes: Vec<Aabb> = aggregates.iter().map(|aggregate| aggregate.body.aabb()).collect();
        Self {
            bodies: parallel::map_each(aggregates, |aggregate| BodySurface::new(&aggregate.body)),
            tree: BoxTree::new(&boxes),
            boxes,
        }
    }

    /// Distances of the voxels of layer `k`, mm, negative inside a body. The bodies of `scan` are these, in their order.
    pub(super) fn measure(&self, scan: &Scan, k: usize, layer: &mut [f32]) {
        let mut labels = vec![Label::MORTAR; layer.len()];
        scan.label_layer(k, &mut labels);
        let mut nearby = NearBodies::of(self);
        for tile in Tile::all(scan.grid(), k) {
            stop::point();
            if tile.voxels().any(|voxel| labels[voxel].body().is_none()) {
                nearby.move_to(&tile);
            }
            for voxel in tile.voxels() {
                let point = scan.grid().point(voxel, k);
                layer[voxel] = match labels[voxel].body() {
                    Some(body) => scan.bodies()[body as usize].height(&point).min(0.0) as f32,
                    None => nearby.distance(&point) as f32,
                };
            }
        }
    }

    /// From a point to the body with the nearest box, which is seldom far from the nearest body; infinite without bodies.
    fn near(&self, point: &Vec3) -> f64 {
        self.tree
            .nearest(point, |item| self.boxes[item as usize].distance(point))
            .map_or(f64::INFINITY, |(item, _)| self.bodies[item as usize].distance(point))
    }
}

/// A square of voxels of one layer.
struct Tile {
    columns: Range<usize>,
    rows: Range<usize>,
    row_len: usize,
    centre: Vec3,
    /// From the centre to the farthest voxel's, mm.
    radius: f64,
}

impl Tile {
    fn all(grid: &PointGrid, k: usize) -> impl Iterator<Item = Self> {
        let [columns, rows, _] = grid.counts;
        let tiles = move |count: usize| (0..count).step_by(TILE).map(move |from| from..count.min(from + TILE));
        tiles(rows).flat_map(move |rows| tiles(columns).map(move |columns| Self::new(grid, k, columns, rows.clone())))
    }

    fn new(grid: &PointGrid, k: usize, columns: Range<usize>, rows: Range<usize>) -> Self {
        let row_len = grid.counts[0];
        let corner = |i: usize, j: usize| grid.point(j * row_len + i, k);
        let (first, last) = (corner(columns.start, rows.start), corner(columns.end - 1, rows.end - 1));
        Self { columns, rows, row_len, centre: (first + last) / 2.0, radius: (last - first).norm() / 2.0 }
    }

    /// Their numbers in the layer.
    fn voxels(&self) -> impl Iterator<Item = usize> {
        let Self { columns, row_len, .. } = self;
        self.rows.clone().flat_map(move |j| columns.clone().map(move |i| j * row_len + i))
    }
}

/// The bodies that may be the nearest ones to the voxels of a tile.
struct NearBodies<'a> {
    surfaces: &'a Surfaces,
    centre: Vec3,
    /// The lowest below the centre first.
    bodies: Vec<NearBody>,
    /// The nearest one to the last point, which is often that to the next one.
    last: Option<u32>,
}

struct NearBody {
    body: u32,
    /// The body's plane that is farthest below the centre.
    plane: Plane,
    /// Height of the centre above the plane, mm; at most its distance from the body.
    height: f64,
}

impl<'a> NearBodies<'a> {
    fn of(surfaces: &'a Surfaces) -> Self {
        Self { surfaces, centre: Vec3::zeros(), bodies: Vec::new(), last: None }
    }

    /// If the nearest body is at `d` from the centre, no voxel is farther from it than `d + radius`, and only bodies
    /// within `d + 2 radius` of the centre can be nearer to one.
    fn move_to(&mut self, tile: &Tile) {
        self.centre = tile.centre;
        // A body near the last tile shows how far the nearest one is at the most, unless that tile is far away.
        let known = self.distance(&tile.centre);
        let most = if known < FAR * tile.radius { known } else { self.surfaces.near(&tile.centre) };
        self.find_within(most + 2.0 * tile.radius);
        let least = self.distance(&tile.centre);
        self.bodies.retain(|candidate| candidate.height <= least + 2.0 * tile.radius);
    }

    fn find_within(&mut self, reach: f64) {
        let Self { surfaces: Surfaces { bodies, boxes, tree }, centre, .. } = self;
        let near = tree.near(Aabb { min: *centre, max: *centre }.grown(reach));
        let near = near.filter(|&body| boxes[body as usize].distance(centre) <= reach);
        self.bodies.clear();
        self.bodies.extend(near.map(|body| {
            let plane = *bodies[body as usize].plane_under(centre);
            NearBody { body, plane, height: plane.height(centre) }
        }));
        self.bodies.retain(|candidate| candidate.height <= reach);
        self.bodies.sort_unstable_by(|p, q| p.height.total_cmp(&q.height).then(p.body.cmp(&q.body)));
    }

    /// From a point outside all bodies to the nearest of these.
    fn distance(&mut self, point: &Vec3) -> f64 {
        let body = |body: u32| &self.surfaces.bodies[body as usize];
        let way = (point - self.centre).norm();
        let mut least = self.last.map_or(f64::INFINITY, |last| body(last).distance(point));
        for candidate in &self.bodies {
            if candidate.height - way > least {
                break;
            }
            // The plane under the centre rejects most bodies that are too far, without their other planes.
            if Some(candidate.body) == self.last || candidate.plane.height(point) > least {
                continue;
            }
            let found = body(candidate.body).distance_below(point, least).filter(|found| *found < least);
            if let Some(distance) = found {
                least = distance;
                self.last = Some(candidate.body);
            }
        }
        least
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::convex_hull;
    use meso_concrete::aggregate::Kind;
    use meso_concrete::aggregate::random::{Draw, Stream};

    /// Sixty hulls of ten points, each in a cube of 5 mm of its own.
    fn bodies() -> Vec<Aggregate> {
        let mut stream = Stream::new(5, Draw::Sample, 0, 0);
        let body = |id: u32| {
            let corner = Vec3::new(f64::from(id % 4), f64::from(id / 4 % 5), f64::from(id / 20)) * 5.0;
            let size = stream.uniform(1.5, 4.5);
            let points: Vec<Vec3> = (0..10).map(|_| stream.point(&corner, &(corner + Vec3::repeat(size)))).collect();
            let body = convex_hull(&points).unwrap();
            Aggregate {
                id,
                kind: Kind::Aggregate,
                own: None,
                class: 0,
                itz_thickness_mm: 0.0,
                shells: Vec::new(),
                body,
            }
        };
        (0..60).map(body).collect()
    }

    /// Every voxel asks every body, once in tiles of one voxel's width and once in whole ones.
    #[test]
    fn distances_are_those_that_every_body_gives() {
        let bodies = bodies();
        for (h, counts) in [(2.1, [9, 11, 2]), (0.4, [19, 17, 3]), (3.0, [1, 8, 7]), (6.0, [4, 4, 1])] {
            let grid = PointGrid { origin: Vec3::new(0.3, 0.2, 9.1), spacing: Vec3::repeat(h), counts };
            let scan = Scan::new(grid, meso_mesh::location::Facets::all(&bodies, |_| 0.0));
            let (surfaces, mut outside) = (Surfaces::new(&bodies), 0);
            for k in 0..counts[2] {
                let mut layer = vec![0.0; grid.layer_len()];
                surfaces.measure(&scan, k, &mut layer);
                for (number, &value) in layer.iter().enumerate().filter(|(_, value)| **value > 0.0) {
                    let point = grid.point(number, k);
                    let least = surfaces.bodies.iter().map(|body| body.distance(&point)).fold(f64::INFINITY, f64::min);
                    assert_eq!(value, least as f32, "{point}");
                    outside += 1;
                }
            }
            assert!(outside > 10, "{outside} at {h} mm");
        }
    }
}
