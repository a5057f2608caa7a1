//! Any closed surface of triangles. A body is inside when one of its points is, and it meets no triangle.
//!
//! Both are exact: the certified collision test against every triangle near, each a body of three points, and the count
//! of the triangles above a point by exact signs. To touch a triangle is to meet it.

use super::room::{Obstacle, Room, Surface};
use super::solid::{clear_of, within_box};
use crate::geometry::{TriangleMesh, nearest_on_triangle, orient3d};
use crate::gjk;
use crate::math::{Aabb, Vec3};
use robust::{Coord, orient2d};

/// What a closed surface of triangles encloses, moved to the origin.
#[derive(Clone, Debug)]
pub(super) struct Closed {
    mesh: TriangleMesh,
    volume: f64,
    size: Vec3,
    /// Corners of every triangle.
    corners: Vec<[Vec3; 3]>,
    /// Normal of every triangle, and those of the walls behind an edge or corner of it that stands out into the room.
    outward: Vec<Vec<Vec3>>,
    boxes: Vec<Aabb>,
    /// Edge of a cell of the grid, mm, and number of cells along each axis.
    cell: f64,
    counts: [usize; 3],
    /// The triangles whose boxes reach into each cell.
    cells: Vec<Vec<u32>>,
    /// The same for each column of cells along z, every triangle once: what a point is counted against.
    columns: Vec<Vec<u32>>,
}

/// Most cells along an axis.
const MOST_CELLS: f64 = 48.0;

impl Closed {
    /// The room within `mesh`, whose surface must be closed.
    pub(super) fn new(mesh: TriangleMesh) -> Self {
        let corners: Vec<[Vec3; 3]> = mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect();
        let boxes: Vec<Aabb> = corners.iter().map(Aabb::around).collect();
        let size = Aabb::around(&mesh.vertices).max;
        let cell = (size.max() / MOST_CELLS).max(f64::MIN_POSITIVE);
        let counts = [0, 1, 2].map(|i| (size[i] / cell).ceil().max(1.0) as usize);
        let cells = vec![Vec::new(); counts.iter().product()];
        let columns = vec![Vec::new(); counts[0] * counts[1]];
        let outward = outward(&mesh, &corners);
        let mut room =
            Self { volume: mesh.volume(), mesh, size, corners, outward, boxes, cell, counts, cells, columns };
        for triangle in 0..room.boxes.len() {
            let Aabb { min, max } = room.boxes[triangle];
            // The lowest cells are numbered as the columns are.
            for column in room.cells_of(&Aabb { min: min.xy().push(0.0), max: max.xy().push(0.0) }) {
                room.columns[column].push(triangle as u32);
            }
            for cell in room.cells_of(&room.boxes[triangle]) {
                room.cells[cell].push(triangle as u32);
            }
        }
        room
    }

    /// The number of the cell at a coordinate.
    fn along(&self, x: f64, axis: usize) -> usize {
        ((x / self.cell).max(0.0) as usize).min(self.counts[axis] - 1)
    }

    /// Cells that a box reaches into; what sticks out counts to the outermost.
    fn cells_of(&self, aabb: &Aabb) -> Vec<usize> {
        let [x, y, z] = [0, 1, 2].map(|i| self.along(aabb.min[i], i)..=self.along(aabb.max[i], i));
        let rows = z.flat_map(|k| y.clone().map(move |j| (k * self.counts[1] + j) * self.counts[0]));
        rows.flat_map(|row| x.clone().map(move |i| row + i)).collect()
    }

    /// The triangles whose boxes meet `aabb`, each once.
    fn near(&self, aabb: &Aabb) -> Vec<u32> {
        let all = self.cells_of(aabb).into_iter().flat_map(|cell| &self.cells[cell]);
        let mut near: Vec<u32> = all.filter(|&&t| self.boxes[t as usize].intersects(aabb)).copied().collect();
        near.sort_unstable();
        near.dedup();
        near
    }

    /// The triangles whose boxes reach above `point`, or hold it.
    fn above(&self, point: &Vec3) -> impl Iterator<Item = u32> {
        let upwards = Aabb { min: *point, max: Vec3::new(point.x, point.y, f64::INFINITY) };
        let column = &self.columns[self.along(point.y, 1) * self.counts[0] + self.along(point.x, 0)];
        column.iter().copied().filter(move |&t| self.boxes[t as usize].intersects(&upwards))
    }

    /// The nearest point of the surface and its distance, mm.
    fn nearest(&self, point: &Vec3) -> (Vec3, f64) {
        // Most who ask are near the surface.
        let mut reach = self.cell / 4.0;
        loop {
            let (place, distance) = self.nearest_within(point, reach);
            // What was not looked at is farther off than the box reaches.
            if distance <= reach {
                return (place, distance);
            }
            reach = if distance.is_finite() { distance } else { 2.0 * reach };
        }
    }

    /// The same of the triangles whose boxes come within `reach`, of equally near ones the first; infinite without any.
    fn nearest_within(&self, point: &Vec3, reach: f64) -> (Vec3, f64) {
        let around = Aabb { min: *point, max: *point }.grown(reach);
        let mut best = (f64::INFINITY, u32::MAX, *point);
        // A triangle of several cells is looked at in each: that is less work than a list of them without repetitions.
        for &t in self.cells_of(&around).into_iter().flat_map(|cell| &self.cells[cell]) {
            if self.boxes[t as usize].intersects(&around) {
                let place = nearest_on_triangle(&self.corners[t as usize], point);
                let distance = (place - point).norm();
                if (distance, t) < (best.0, best.1) {
                    best = (distance, t, place);
                }
            }
        }
        (best.2, best.0)
    }

    /// Two triangles that cross each other, or touch where they are not neighbours, if there are any.
    pub(super) fn crossing(&self) -> Option<[[Vec3; 3]; 2]> {
        let meets = |&(a, b): &(u32, u32)| self.cross(a, b);
        let first = |a: u32| {
            let near = self.near(&self.boxes[a as usize]).into_iter().filter(move |&b| b > a);
            near.map(move |b| (a, b)).find(meets)
        };
        let found = (0..self.boxes.len() as u32).find_map(first)?;
        Some([found.0, found.1].map(|t| self.corners[t as usize]))
    }

    /// Neighbours share their common corners or edge; what else they share is a crossing.
    fn cross(&self, a: u32, b: u32) -> bool {
        let [p, q] = [a, b].map(|t| self.mesh.triangles[t as usize]);
        let at = |i: &u32| self.mesh.vertices[*i as usize];
        let shared = p.iter().filter(|i| q.contains(i)).count();
        // The corner or edge opposite to what is shared, against the whole other triangle.
        let opposite = |own: &[u32; 3], other: &[u32; 3]| -> Vec<Vec3> {
            own.iter().filter(|i| !other.contains(i)).map(at).collect()
        };
        let meets =
            |points: &[Vec3], triangle: u32| gjk::intersects(points, &self.corners[triangle as usize]).unwrap_or(true);
        match shared {
            0 => meets(&self.corners[a as usize], b),
            1 | 2 => meets(&opposite(&p, &q), b) || meets(&opposite(&q, &p), a),
            _ => true,
        }
    }
}

impl Room for Closed {
    fn aabb(&self) -> Aabb {
        Aabb { min: Vec3::zeros(), max: self.size }
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    /// That of its box: what is narrower inside is found by trying.
    fn width(&self) -> f64 {
        self.size.min()
    }

    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        within_box(&self.size, body, centre, gap).is_some_and(|(points, aabb)| {
            self.contains(&points[0])
                && self.near(&aabb.grown(gap)).iter().all(|&t| clear_of(&points, &self.corners[t as usize], gap))
        })
    }

    /// True when the surface winds once around the point, or the point lies on it: every triangle above or below counts by
    /// its orientation, edges to one of their two sides.
    fn contains(&self, point: &Vec3) -> bool {
        let mut windings = 0;
        for t in self.above(point) {
            let [a, b, c] = &self.corners[t as usize];
            let turns = turns_around(&[*a, *b, *c], point);
            let side = orient3d(a, b, c, point);
            if side == 0.0 && gjk::intersects(std::slice::from_ref(point), &self.corners[t as usize]).unwrap_or(true) {
                return true;
            }
            // An upward triangle with the point below it has the point on its inner side.
            if (turns > 0 && side < 0.0) || (turns < 0 && side > 0.0) {
                windings += turns;
            }
        }
        windings > 0
    }

    fn depth(&self, point: &Vec3) -> f64 {
        let distance = self.nearest(point).1;
        if self.contains(point) { distance } else { -distance }
    }

    /// A centre that is outside goes back through the nearest point of the surface; the rest is for the triangles.
    fn confine(&self, _: &[Vec3], centre: &Vec3, gap: f64) -> Vec3 {
        if self.contains(centre) {
            return *centre;
        }
        let (place, distance) = self.nearest(centre);
        let inwards = (place - centre) / distance.max(f64::MIN_POSITIVE);
        place + inwards * (gap + 1e-3 * self.cell)
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn obstacles(&self, near: &Aabb) -> Vec<Obstacle<'_>> {
        let obstacle = |t: u32| Obstacle { points: &self.corners[t as usize], outward: &self.outward[t as usize] };
        self.near(near).into_iter().map(obstacle).collect()
    }

    fn surface(&self) -> Surface {
        Surface { points: self.mesh.vertices.clone(), faces: self.mesh.triangles.iter().map(|t| t.to_vec()).collect() }
    }
}

/// A corner is beyond a plane when it is so by this share of its distance: what is nearly flat does not stand out.
const BEYOND: f64 = 1e-3;

/// For every triangle its normal, then the normals of those that share a corner with it and that it rises above: there
/// the surface stands out into the room.
fn outward(mesh: &TriangleMesh, corners: &[[Vec3; 3]]) -> Vec<Vec<Vec3>> {
    let normals: Vec<Vec3> = corners.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).normalize()).collect();
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        triangle.iter().for_each(|&corner| around[corner as usize].push(t));
    }
    let of_one = |(t, triangle): (usize, &[u32; 3])| {
        let mut all = vec![normals[t]];
        for &corner in triangle {
            let origin = mesh.vertices[corner as usize];
            let rises = |&&other: &&usize| {
                corners[t].iter().any(|p| normals[other].dot(&(p - origin)) > BEYOND * (p - origin).norm())
            };
            all.extend(around[corner as usize].iter().filter(rises).map(|&other| normals[other]));
        }
        all
    };
    mesh.triangles.iter().enumerate().map(of_one).collect()
}

/// How often a triangle seen from above turns around a point, 1, 0 or -1: its edges that cross the line to the right of the
/// point, those upwards less those downwards. A point on an edge of two triangles counts to one of them.
fn turns_around(triangle: &[Vec3; 3], point: &Vec3) -> i32 {
    let coord = |v: &Vec3| Coord { x: v.x, y: v.y };
    let crossing = |k: usize| {
        let (from, to) = (&triangle[k], &triangle[(k + 1) % 3]);
        let left = || orient2d(coord(from), coord(to), coord(point));
        if from.y <= point.y && to.y > point.y {
            i32::from(left() > 0.0)
        } else if from.y > point.y && to.y <= point.y {
            -i32::from(left() < 0.0)
        } else {
            0
        }
    };
    (0..3).map(crossing).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A box from the origin with a hollow inside, its faces turned the other way.
    fn hollow() -> Closed {
        let outer = Surface::cuboid(&Vec3::zeros(), &Vec3::repeat(10.0));
        let inner = Surface::cuboid(&Vec3::repeat(4.0), &Vec3::repeat(6.0));
        let corners = |surface: &Surface| -> Vec<[Vec3; 3]> {
            surface.triangles().map(|t| t.map(|i| surface.points[i as usize])).collect()
        };
        let turned = corners(&inner).into_iter().map(|[a, b, c]| [a, c, b]);
        Closed::new(TriangleMesh::welded(&corners(&outer).into_iter().chain(turned).flatten().collect::<Vec<_>>()))
    }

    #[test]
    fn points_in_edges_corners_and_hollows_are_told_apart() {
        let room = hollow();
        assert!((room.volume() - 992.0).abs() < 1e-9);
        // Right above and below edges and diagonals of the triangulation, too.
        for inside in
            [[5.0, 5.0, 3.0], [1.0, 1.0, 1.0], [5.0, 5.0, 9.0], [4.0, 6.0, 1.0], [0.0, 0.0, 0.0], [5.0, 5.0, 6.0]]
        {
            assert!(room.contains(&Vec3::from(inside)), "{inside:?}");
        }
        for outside in [[5.0, 5.0, 5.0], [4.5, 4.5, 5.0], [-1e-300, 5.0, 5.0], [11.0, 11.0, 1.0], [5.0, 5.0, 11.0]] {
            assert!(!room.contains(&Vec3::from(outside)), "{outside:?}");
        }
        assert!((room.depth(&Vec3::new(5.0, 5.0, 2.5)) - 1.5).abs() < 1e-12);
        assert!((room.depth(&Vec3::new(5.0, 5.0, 5.2)) + 0.8).abs() < 1e-12);
    }

    #[test]
    fn surfaces_that_cross_themselves_are_found() {
        assert_eq!(hollow().crossing(), None);
        let boxes = [(0.0, 6.0), (3.0, 9.0)].map(|(from, to)| {
            let surface = Surface::cuboid(&Vec3::repeat(from), &Vec3::repeat(to));
            surface.triangles().flat_map(|t| t.map(|i| surface.points[i as usize])).collect::<Vec<_>>()
        });
        assert!(Closed::new(TriangleMesh::welded(&boxes.concat())).crossing().is_some());
    }
}
