//! Convex hull of points, with exact predicates.
//!
//! The hull grows point by point ([`surface`]) on triangles; then coplanar triangles become polygons and points
//! inside faces and edges are dropped ([`polygons`]). No tolerance is involved: every sign is exact, so the vertices
//! are exactly the extreme points and the faces exactly the facets.

mod cloud;
mod loops;
mod polygons;
mod same_facets;
mod surface;
mod wrap;

use crate::geometry::exact::predicates::in_range;
use crate::geometry::faces::Role;
use crate::geometry::{CompactPolyhedron, Polyhedron};
use crate::math::Vec3;
pub(crate) use loops::{Loops, pairs};
use polygons::Polygons;
use std::borrow::Cow;
use std::cell::RefCell;
use surface::Surface;
use wrap::Wrap;

/// Up to this many points each thread keeps the memory of its last hull.
const KEPT_POINTS: usize = 256;

/// Why points have no solid hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HullError {
    /// There are no points.
    #[error("no points were given; a hull needs at least four that do not lie in one plane")]
    Empty,
    /// A coordinate is NaN or infinite.
    #[error("point {index} is not finite")]
    NotFinite {
        /// Row of the point.
        index: usize,
    },
    /// A coordinate is outside {0} and 1e-60 to 1e60.
    #[error("point {index} has a coordinate beyond the accepted magnitudes 1e-60 to 1e60 (or 0)")]
    OutOfRange {
        /// Row of the point.
        index: usize,
    },
    /// The points span less than three dimensions.
    #[error("the points span {dimension} dimension(s), a solid hull needs 3; they lie {}", ["in one point", "on one line", "in one plane"][*dimension as usize])]
    LowerDimensional {
        /// 0: one point, 1: a line, 2: a plane.
        dimension: u8,
    },
}

/// The convex hull of `points` (mm): exact extreme set, outward faces, coplanar triangles merged into polygons.
///
/// Vertices keep the order of `points`. Every face begins with its smallest vertex index, and the faces stand in
/// ascending order of their first two indices: the result depends on the points alone.
///
/// # Errors
/// See [`HullError`].
pub fn convex_hull(points: &[Vec3]) -> Result<Polyhedron, HullError> {
    with_builder(points.len(), |builder| builder.build(points))
}

impl Polyhedron {
    /// The convex hull of its vertices; a body without dents itself.
    ///
    /// # Errors
    /// Where they span no volume.
    pub fn hull(&self) -> Result<Cow<'_, Self>, HullError> {
        if self.is_convex() { Ok(Cow::Borrowed(self)) } else { convex_hull(self.vertices()).map(Cow::Owned) }
    }
}

/// Runs with the memory of the thread's last hull, where this one is of few points.
fn with_builder<R>(points: usize, run: impl FnOnce(&mut HullBuilder) -> R) -> R {
    thread_local! {
        static BUILDER: RefCell<HullBuilder> = RefCell::default();
    }
    // Fresh memory would cost a fifth of a grain's hull; that of a large hull is better given back.
    if points <= KEPT_POINTS { BUILDER.with_borrow_mut(run) } else { run(&mut HullBuilder::default()) }
}

/// [`convex_hull`] with memory that is kept from one hull to the next: for whoever makes thousands of them.
#[derive(Clone, Debug, Default)]
pub struct HullBuilder {
    wrap: Wrap,
    surface: Surface,
    polygons: Polygons,
    /// Position of every point among the hull's vertices.
    rank: Vec<u32>,
}

impl HullBuilder {
    /// Errors are those of [`convex_hull`].
    ///
    /// # Errors
    /// See [`HullError`].
    pub fn build(&mut self, points: &[Vec3]) -> Result<Polyhedron, HullError> {
        check(points)?;
        // A few points in general position, as nearly all grains have them: in half the time.
        let triangles = self.wrap.triangles(points);
        // This many corners mean that every point is one.
        if let Some(corners) = triangles.filter(|corners| corners.len() == 3 * (2 * points.len() - 4)) {
            return Ok(Polyhedron::of_triangles(points.into(), corners));
        }
        self.surface.build(points)?;
        self.polygons.collect(&self.surface, points);
        Ok(self.polyhedron(points))
    }

    /// The collected polygons over the points that are their corners, in the canonical order.
    fn polyhedron(&mut self, points: &[Vec3]) -> Polyhedron {
        self.polygons.sort(points.len());
        self.rank.clear();
        self.rank.resize(points.len(), 0);
        for &corner in &self.polygons.corners {
            self.rank[corner as usize] = 1;
        }
        if self.rank.iter().all(|rank| *rank == 1) {
            return Polyhedron::from_lists(points.into(), &self.polygons.corners, &self.polygons.ends);
        }
        let vertices: Box<[Vec3]> = points.iter().zip(&self.rank).filter(|(_, r)| **r == 1).map(|(p, _)| *p).collect();
        let mut count = 0;
        for rank in &mut self.rank {
            count += std::mem::replace(rank, count);
        }
        for corner in &mut self.polygons.corners {
            *corner = self.rank[*corner as usize];
        }
        Polyhedron::from_lists(vertices, &self.polygons.corners, &self.polygons.ends)
    }

    /// The body whose vertices, moved as one body and rounded, are `points`. A convex polyhedron becomes their
    /// [`convex_hull`], since rounding may fold a nearly flat edge: where they keep its faces, which is found by looking,
    /// in a tenth of the time. Others keep their triangles.
    ///
    /// # Errors
    /// See [`HullError`].
    pub fn moved(like: &CompactPolyhedron, points: &[Vec3]) -> Result<Polyhedron, HullError> {
        let faces = like.faces();
        if like.role() != Role::Hull {
            return Ok(Polyhedron::with_faces(points.into(), faces));
        }
        check(points)?;
        let same = points.len() == like.vertex_count() && same_facets::are_facets(points, faces.faces());
        if same { Ok(Polyhedron::with_faces(points.into(), faces)) } else { convex_hull(points) }
    }
}

/// The facets of the hull of `points` as loops of points, and the loops of facets around the points, for whoever wants
/// the combinatorics alone. Coordinates must be within the range of [`convex_hull`].
pub(crate) fn facets_and_dual(points: &[Vec3]) -> Result<[Loops; 2], HullError> {
    check(points)?;
    with_builder(points.len(), |HullBuilder { surface, polygons, .. }| {
        surface.build(points)?;
        polygons.collect(surface, points);
        let facets = Loops { corners: polygons.corners.clone(), ends: polygons.ends.clone() };
        let around = facets.around(points.len());
        Ok([facets, around])
    })
}

fn check(points: &[Vec3]) -> Result<(), HullError> {
    if points.is_empty() {
        return Err(HullError::Empty);
    }
    for (index, point) in points.iter().enumerate() {
        if !point.iter().all(|x| in_range(*x)) {
            let finite = point.iter().all(|x| x.is_finite());
            return Err(if finite { HullError::OutOfRange { index } } else { HullError::NotFinite { index } });
        }
    }
    Ok(())
}
