//! Bodies of the tests, and short ways to their tensors.

use meso_core::Silent;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::geometry::{Polyhedron, clipped, convex_hull};
use meso_core::math::{Aabb, Vec3};
use meso_core::specimen::{Periodic, Specimen};
use meso_effective::{Effective, EffectiveOptions, GivenValues, Phases, Property, effective};

pub(crate) fn cube(side_mm: f64, periodic: bool) -> Specimen {
    Specimen::Cube { side_mm, periodic: Periodic([periodic; 3]) }
}

pub(crate) fn aggregate(body: Polyhedron, itz_thickness_mm: f64) -> Aggregate {
    Aggregate { id: 0, kind: Kind::Aggregate, own: None, class: 0, itz_thickness_mm, shells: Vec::new(), body }
}

/// Phases whose diffusivities are those of mortar, aggregate and ITZ.
pub(crate) fn phases(mortar: f64, aggregate: f64, itz: f64) -> Phases {
    let [mortar, aggregate, itz] = [mortar, aggregate, itz].map(Some);
    Phases { diffusivity: GivenValues { mortar, aggregate, itz, ..GivenValues::default() }, ..Phases::default() }
}

pub(crate) fn solve(bodies: &[Aggregate], specimen: &Specimen, phases: &Phases, h: f64) -> Effective {
    effective((bodies, specimen), phases, &EffectiveOptions::new(Property::Diffusivity, h), &Silent).unwrap().0
}

pub(crate) fn entry(found: &Effective, row: usize, column: usize) -> f64 {
    found.tensor[row][column].unwrap()
}

/// A slab of `thickness` normal to `normal`, in layers a `period` apart, within a box.
pub(crate) fn slabs(normal: Vec3, period: f64, thickness: f64, side: f64) -> Vec<Aggregate> {
    let n = normal.normalize();
    let t = n.cross(&if n.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() }).normalize();
    let b = n.cross(&t);
    let domain = Aabb { min: Vec3::zeros(), max: Vec3::repeat(side) };
    let reach = 3.0 * side;
    let slab = |layer: i32| {
        let middle = n * (f64::from(layer) * period + 0.31 * thickness);
        let corner = |s: usize| {
            let sign = |bit: usize| if s >> bit & 1 == 0 { -1.0 } else { 1.0 };
            middle + n * (sign(0) * thickness / 2.0) + (t * sign(1) + b * sign(2)) * reach
        };
        let whole = convex_hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap();
        clipped(&whole, &domain)
    };
    let layers = (2.0 * side / period) as i32 + 2;
    (-layers..=layers).filter_map(slab).map(|body| aggregate(body, 0.0)).collect()
}

/// A polyhedron of the volume of a sphere: an icosahedron, its triangles divided `times` times.
pub(crate) fn sphere(centre: Vec3, radius: f64, times: usize) -> Polyhedron {
    let g = (1.0 + 5.0_f64.sqrt()) / 2.0;
    let mut points = Vec::new();
    for (a, b) in [(1.0, g), (-1.0, g), (1.0, -g), (-1.0, -g)] {
        points.extend([Vec3::new(0.0, a, b), Vec3::new(a, b, 0.0), Vec3::new(b, 0.0, a)]);
    }
    for _ in 0..times {
        let points_now = points.clone();
        let body = convex_hull(&points_now).unwrap();
        for [a, b, c] in body.triangles() {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                if p < q {
                    points.push((body.vertices()[p as usize] + body.vertices()[q as usize]).normalize());
                }
            }
        }
        points.iter_mut().for_each(|point| *point = point.normalize());
    }
    points.iter_mut().for_each(|point| *point = point.normalize());
    let unit = convex_hull(&points).unwrap();
    let scale = radius * libm::cbrt(4.0 / 3.0 * std::f64::consts::PI / unit.volume());
    let place: Vec<Vec3> = points.iter().map(|point| centre + point * scale).collect();
    convex_hull(&place).unwrap()
}
