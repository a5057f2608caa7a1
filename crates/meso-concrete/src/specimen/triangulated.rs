//! Any closed surface of triangles. A body is inside when one of its points is, and it meets no triangle.
//!
//! Both are exact, as [`Triangles`] answers them. To touch a triangle is to meet it.

use super::box_minus_convex::{clear_of, within_box};
use super::container::{Container, Obstacle, Surface};
use super::largest::{self, Largest};
use super::{ContainerError, Waiting};
use crate::parallel;
use meso_collision::dents::SelfCrossing;
use meso_collision::geometry::{HullError, Polyhedron, TriangleMesh, Triangles};
use meso_collision::math::{Aabb, Vec3};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// The region that a closed surface of triangles encloses, moved to the origin.
#[derive(Clone, Debug)]
pub(super) struct Triangulated {
    mesh: TriangleMesh,
    volume: f64,
    size: Vec3,
    facets: Triangles,
    /// Normal of every triangle, then those of the walls behind its reentrant edges and corners.
    outward: Vec<Vec<Vec3>>,
}

impl Triangulated {
    /// The container within `mesh`, whose surface must be closed.
    pub(super) fn new(mesh: TriangleMesh) -> Self {
        let corners: Vec<[Vec3; 3]> = mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect();
        let (size, outward) = (Aabb::around(&mesh.vertices).max, outward(&mesh, &corners));
        Self { volume: mesh.volume(), mesh, size, facets: Triangles::new(corners), outward }
    }

    /// The nearest point of the surface and its distance, mm.
    fn nearest(&self, point: &Vec3) -> (Vec3, f64) {
        self.facets.nearest(point).unwrap_or((*point, f64::INFINITY))
    }

    /// The convex hull of the surface.
    pub(super) fn hull(&self) -> Result<Polyhedron, HullError> {
        self.mesh.hull()
    }

    /// Two triangles that cross each other, or touch where they are not neighbours, if there are any.
    ///
    /// # Errors
    /// [`ContainerError::Late`].
    pub(super) fn crossing(&self, waiting: Waiting<'_>) -> Result<Option<[[Vec3; 3]; 2]>, ContainerError> {
        let triangles = self.mesh.triangles.len();
        let (looked_at, is_late) = (AtomicUsize::new(0), AtomicBool::new(false));
        let share = || looked_at.load(Ordering::Relaxed).min(triangles) as f64 / triangles as f64;
        let first = |a: usize| {
            if a.is_multiple_of(RUN) {
                looked_at.fetch_add(RUN, Ordering::Relaxed);
                is_late.fetch_or(waiting.is_over_at(BEFORE + WITHIN * share()), Ordering::Relaxed);
            }
            // Whatever is found ends the search.
            if is_late.load(Ordering::Relaxed) {
                return Some(Err(ContainerError::Late { triangles, share: share() }));
            }
            SelfCrossing { mesh: &self.mesh, facets: &self.facets }.of(a as u32).map(Ok)
        };
        parallel::find(triangles, first).transpose()
    }

    /// A corner of a component that is nested wrongly. An outer surface lies in no other's interior; the surface of a
    /// hollow lies in one.
    pub(super) fn nested(&self) -> Option<Vec3> {
        let component_of = self.mesh.component_of();
        let of = |triangle: u32| component_of[self.mesh.triangles[triangle as usize][0] as usize];
        let mut volumes = BTreeMap::new();
        for (t, [a, b, c]) in (0..).zip(self.facets.corners()) {
            *volumes.entry(of(t)).or_insert(0.0) += a.dot(&b.cross(c));
        }
        let wrong = |(component, volume): &(&u32, &f64)| {
            let corner = &self.mesh.vertices[**component as usize];
            let others = self.facets.windings(corner).filter(|&(t, ..)| of(t) != **component);
            others.map(|(_, turns, _)| turns).sum::<i32>() != i32::from(**volume < 0.0)
        };
        let found = volumes.iter().filter(|_| volumes.len() > 1).find(wrong);
        found.map(|(component, _)| self.mesh.vertices[*component as usize])
    }
}

impl Container for Triangulated {
    fn aabb(&self) -> Aabb {
        Aabb { min: Vec3::zeros(), max: self.size }
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    /// Width of the surface's box; narrower parts inside are found by trying.
    fn width(&self) -> f64 {
        self.size.min()
    }

    fn largest(&self) -> Largest {
        let ball_radius = largest::ball_radius(&self.aabb(), |point| self.depth(point));
        // A component without volume is the surface of a hollow.
        let components = self.mesh.components().into_iter().filter(|component| component.volume() > 0.0);
        let (length, volume) = components.fold((0.0, 0.0), |(length, volume): (f64, f64), component| {
            (length.max(longest(&component)), volume.max(component.volume()))
        });
        Largest { ball_radius, length, volume }
    }

    fn share_within(&self, rim: f64) -> Option<f64> {
        let middles = |axis: usize| (0..SAMPLES).map(move |k| (k as f64 + 0.5) / SAMPLES as f64 * self.size[axis]);
        let row = |x: f64| middles(1).flat_map(move |y| middles(2).map(move |z| Vec3::new(x, y, z)));
        let within = |gap: f64| {
            let count = |x: &f64| row(*x).filter(|point| self.is_clear(point, gap)).count();
            parallel::map_each(&middles(0).collect::<Vec<_>>(), count).iter().sum::<usize>()
        };
        let (inside, deep) = (within(0.0), within(rim));
        (inside > 0).then(|| deep as f64 / inside as f64)
    }

    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        within_box(&self.size, body, centre, gap).is_some_and(|(points, aabb)| {
            self.contains(&points[0])
                && self.facets.near(&aabb.grown(gap)).iter().all(|&t| clear_of(&points, self.facets.of(t), gap))
        })
    }

    fn contains(&self, point: &Vec3) -> bool {
        self.facets.contains(point)
    }

    fn depth(&self, point: &Vec3) -> f64 {
        self.facets.depth(point)
    }

    fn is_clear(&self, point: &Vec3, distance: f64) -> bool {
        let around = Aabb { min: *point, max: *point }.grown(distance);
        let clear = |t: u32| self.facets.nearest_of(t, point).1 >= distance;
        self.contains(point) && self.facets.meeting(around).all(clear)
    }

    /// A centre outside goes back through the nearest point of the surface; the triangles do the rest.
    fn confine(&self, _: &[Vec3], centre: &Vec3, gap: f64) -> Vec3 {
        if self.contains(centre) {
            return *centre;
        }
        let (nearest, distance) = self.nearest(centre);
        let inwards = (nearest - centre) / distance.max(f64::MIN_POSITIVE);
        nearest + inwards * (gap + BACK * self.size.max())
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn obstacles(&self, near: &Aabb) -> Vec<Obstacle<'_>> {
        let obstacle = |t: u32| Obstacle { points: self.facets.of(t), outward: &self.outward[t as usize] };
        self.facets.near(near).into_iter().map(obstacle).collect()
    }

    fn surface(&self) -> Surface {
        Surface { points: self.mesh.vertices.clone(), faces: self.mesh.triangles.iter().map(|t| t.to_vec()).collect() }
    }
}

/// No two points of the surface are farther apart, mm: within its box, and within a ball about the middle of that.
fn longest(component: &TriangleMesh) -> f64 {
    let aabb = Aabb::around(&component.vertices);
    let middle = (aabb.min + aabb.max) / 2.0;
    let radius = component.vertices.iter().map(|vertex| (vertex - middle).norm()).fold(0.0, f64::max);
    aabb.size().norm().min(2.0 * radius)
}

/// Share of the time to read a surface of a million triangles that passes before its triangles are compared.
const BEFORE: f64 = 0.4;
/// Share of that time in which the triangles are compared; the hull takes the rest.
const WITHIN: f64 = 0.4;
/// Triangles from one look at the clock to the next: some 10 ms of work.
const RUN: usize = 1 << 10;
/// Samples along each axis for [`Container::share_within`].
const SAMPLES: usize = 24;
/// How far inside a returned centre starts, as a share of the container's size.
const BACK: f64 = 2e-5;
/// A corner is beyond a plane when its height exceeds this share of its distance: nearly flat edges do not stand out.
const BEYOND: f64 = 1e-3;

/// For every triangle its normal, then the normals of those that share a corner with it and that it rises above: its
/// reentrant neighbours.
fn outward(mesh: &TriangleMesh, corners: &[[Vec3; 3]]) -> Vec<Vec<Vec3>> {
    let normals: Vec<Vec3> = corners.iter().map(|[a, b, c]| (b - a).cross(&(c - a)).normalize()).collect();
    let mut around = vec![Vec::new(); mesh.vertices.len()];
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        triangle.iter().for_each(|&corner| around[corner as usize].push(t));
    }
    let of_one = |t: usize| {
        let mut all = vec![normals[t]];
        for &corner in &mesh.triangles[t] {
            let origin = mesh.vertices[corner as usize];
            let rises = |&&other: &&usize| {
                corners[t].iter().any(|p| normals[other].dot(&(p - origin)) > BEYOND * (p - origin).norm())
            };
            all.extend(around[corner as usize].iter().filter(rises).map(|&other| normals[other]));
        }
        all
    };
    parallel::map(mesh.triangles.len(), of_one)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::watch::Silent;

    /// A box from the origin with a hollow, whose faces are reversed.
    fn hollow() -> Triangulated {
        let outer = Surface::cuboid(&Vec3::zeros(), &Vec3::repeat(10.0));
        let inner = Surface::cuboid(&Vec3::repeat(4.0), &Vec3::repeat(6.0));
        let corners = |surface: &Surface| -> Vec<[Vec3; 3]> {
            surface.triangles().map(|t| t.map(|i| surface.points[i as usize])).collect()
        };
        let turned = corners(&inner).into_iter().map(|[a, b, c]| [a, c, b]);
        Triangulated::new(TriangleMesh::welded(
            &corners(&outer).into_iter().chain(turned).flatten().collect::<Vec<_>>(),
        ))
    }

    #[test]
    fn points_in_edges_corners_and_hollows_are_classified() {
        let container = hollow();
        assert!((container.volume() - 992.0).abs() < 1e-9);
        // Points exactly above and below edges and diagonals of the triangulation are among them.
        for inside in
            [[5.0, 5.0, 3.0], [1.0, 1.0, 1.0], [5.0, 5.0, 9.0], [4.0, 6.0, 1.0], [0.0, 0.0, 0.0], [5.0, 5.0, 6.0]]
        {
            assert!(container.contains(&Vec3::from(inside)), "{inside:?}");
        }
        for outside in [[5.0, 5.0, 5.0], [4.5, 4.5, 5.0], [-1e-300, 5.0, 5.0], [11.0, 11.0, 1.0], [5.0, 5.0, 11.0]] {
            assert!(!container.contains(&Vec3::from(outside)), "{outside:?}");
        }
        assert!((container.depth(&Vec3::new(5.0, 5.0, 2.5)) - 1.5).abs() < 1e-12);
        assert!((container.depth(&Vec3::new(5.0, 5.0, 5.2)) + 0.8).abs() < 1e-12);
    }

    #[test]
    fn surfaces_that_cross_themselves_are_found() {
        let patient = Waiting { watch: &Silent, deadline: f64::INFINITY };
        assert_eq!(hollow().crossing(patient), Ok(None));
        let boxes = [(0.0, 6.0), (3.0, 9.0)].map(|(from, to)| {
            let surface = Surface::cuboid(&Vec3::repeat(from), &Vec3::repeat(to));
            surface.triangles().flat_map(|t| t.map(|i| surface.points[i as usize])).collect::<Vec<_>>()
        });
        let found = Triangulated::new(TriangleMesh::welded(&boxes.concat())).crossing(patient);
        assert!(found.is_ok_and(|pair| pair.is_some()));
    }
}
