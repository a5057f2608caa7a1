//! Boxes minus convex cutouts: notched prisms and dog-bones. All faces are plane, so all answers are exact.
//!
//! A body is inside when it is inside the box and, by the certified collision test, shares no point with a cutout; to
//! touch a cutout is to meet it. Cutouts reach beyond the box, so that their other sides do not matter.

use super::container::{Container, Obstacle, Surface};
use meso_collision::geometry::{HullError, Plane, Triangles, convex_hull};
use meso_collision::gjk;
use meso_collision::math::{Aabb, Vec3};

/// A box from the origin with cutouts taken out.
#[derive(Clone, Debug)]
pub(super) struct BoxMinusConvex {
    size: Vec3,
    volume: f64,
    width: f64,
    surface: Surface,
    cutouts: Vec<Cutout>,
}

#[derive(Clone, Debug)]
struct Cutout {
    vertices: Vec<Vec3>,
    planes: Vec<Plane>,
    aabb: Aabb,
    /// Its faces in triangles.
    facets: Triangles,
}

impl BoxMinusConvex {
    /// The region that the closed `surface` bounds: its bounding box minus the hulls of `cutouts`; `width` as in
    /// [`Container::width`], mm.
    pub(super) fn new(surface: Surface, width: f64, cutouts: &[Vec<Vec3>]) -> Result<Self, HullError> {
        let cutouts = cutouts.iter().map(|points| Cutout::new(points)).collect::<Result<_, _>>()?;
        Ok(Self { size: Aabb::around(&surface.points).max, volume: surface.volume(), width, surface, cutouts })
    }

    fn box_depth(&self, point: &Vec3) -> f64 {
        point.min().min((self.size - point).min())
    }
}

impl Cutout {
    fn new(points: &[Vec3]) -> Result<Self, HullError> {
        let hull = convex_hull(points)?;
        let vertices = hull.vertices().to_vec();
        let facets = Triangles::new(hull.triangles().map(|t| t.map(|i| vertices[i as usize])).collect());
        Ok(Self { vertices, planes: hull.planes().collect(), aabb: hull.aabb(), facets })
    }

    /// Distance to `point`, or a number that is at least `enough`; negative inside.
    fn distance(&self, point: &Vec3, enough: f64) -> f64 {
        let height = Plane::height_over(&self.planes, point);
        if height < 0.0 || height >= enough {
            return height;
        }
        // Many points are asked about: the certified distance of two bodies takes ten times as long.
        self.facets.nearest(point).map_or(0.0, |(_, distance)| distance)
    }
}

impl Container for BoxMinusConvex {
    fn aabb(&self) -> Aabb {
        Aabb { min: Vec3::zeros(), max: self.size }
    }

    fn volume(&self) -> f64 {
        self.volume
    }

    fn width(&self) -> f64 {
        self.width
    }

    fn holds(&self, body: &[Vec3], centre: &Vec3, gap: f64) -> bool {
        within_box(&self.size, body, centre, gap).is_some_and(|(points, aabb)| {
            let near = aabb.grown(gap);
            let mut met = self.cutouts.iter().filter(|cutout| cutout.aabb.intersects(&near));
            met.all(|cutout| clear_of(&points, &cutout.vertices, gap))
        })
    }

    fn depth(&self, point: &Vec3) -> f64 {
        let depth = self.box_depth(point);
        self.cutouts.iter().fold(depth, |depth, cutout| depth.min(cutout.distance(point, depth)))
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn obstacles(&self, near: &Aabb) -> Vec<Obstacle<'_>> {
        let met = self.cutouts.iter().filter(|cutout| cutout.aabb.intersects(near));
        met.map(|cutout| Obstacle { points: &cutout.vertices, outward: &[] }).collect()
    }

    fn surface(&self) -> Surface {
        self.surface.clone()
    }
}

/// The points of `body` at `centre` and their box, where this lies at least `gap` mm inside the one of `size` from the
/// origin.
pub(super) fn within_box(size: &Vec3, body: &[Vec3], centre: &Vec3, gap: f64) -> Option<(Vec<Vec3>, Aabb)> {
    let points: Vec<Vec3> = body.iter().map(|v| v + centre).collect();
    let aabb = Aabb::around(&points);
    (0..3).all(|i| aabb.min[i] >= gap && aabb.max[i] <= size[i] - gap).then_some((points, aabb))
}

/// True when two bodies share no point and are at least `gap` mm apart; false where the query fails.
pub(super) fn clear_of(a: &[Vec3], b: &[Vec3], gap: f64) -> bool {
    if gap > 0.0 {
        return gjk::distance(a, b).is_ok_and(|distance| distance >= gap);
    }
    gjk::intersects(a, b).is_ok_and(|meet| !meet)
}
