//! Grains that the sides of a box cut, as a scan has them: their caps lie in the side, and no mortar is between the two.
//!
//! Nodes near such a side would be pulled onto the cap and onto the side at once. So the fit sees the grain continued
//! straight beyond the side, and the lattice ends at the side as it does where an image of a periodic box crosses it.

use meso_collision::geometry::{Polyhedron, TriangleMesh};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
use std::collections::{BTreeMap, BTreeSet};

/// The bodies, those with caps continued by `reach` mm; `None` where none has caps.
pub(super) fn continued(bodies: &[Aggregate], reach: f64) -> Option<Vec<Aggregate>> {
    let long = parallel::map_each(bodies, |aggregate| long(&aggregate.body, reach));
    let mut all = long.iter().any(Option::is_some).then(|| bodies.to_vec())?;
    all.iter_mut().zip(long).filter_map(|(all, long)| Some((all, long?))).for_each(|(all, long)| all.body = long);
    Some(all)
}

/// A body with caps, continued.
fn long(body: &Polyhedron, reach: f64) -> Option<Polyhedron> {
    let (aabb, caps) = (body.aabb(), body.caps());
    if caps == 0 {
        return None;
    }
    let mut mesh = TriangleMesh { vertices: body.vertices().to_vec(), triangles: body.triangles().collect() };
    // One after the other: walls that stand in a side go on with the caps there.
    let sides = (0..3).flat_map(|axis| [(axis, aabb.min[axis], -reach), (axis, aabb.max[axis], reach)]);
    let kept = sides.enumerate().filter(|(bit, _)| caps >> bit & 1 == 1);
    kept.for_each(|(_, (axis, side, way))| extrude(&mut mesh, axis, side, way));
    Some(Polyhedron::of_surface(&mesh))
}

/// Moves the triangles in the plane `side` across `axis` along it by `way`, and joins their rim with its old place.
fn extrude(mesh: &mut TriangleMesh, axis: usize, side: f64, way: f64) {
    let TriangleMesh { vertices, triangles } = mesh;
    let is_cap = |triangle: &[u32; 3]| triangle.iter().all(|&v| vertices[v as usize][axis] == side);
    let (caps, others): (Vec<[u32; 3]>, Vec<[u32; 3]>) = triangles.iter().partition(|triangle| is_cap(triangle));
    // The corner across from every edge.
    let corner: BTreeMap<(u32, u32), u32> =
        caps.iter().flat_map(|&[a, b, c]| [((a, b), c), ((b, c), a), ((c, a), b)]).collect();
    let rim: Vec<(u32, u32)> = corner.keys().copied().filter(|&(a, b)| !corner.contains_key(&(b, a))).collect();
    let ends: BTreeSet<u32> = rim.iter().map(|(a, _)| *a).collect();
    let within: BTreeSet<u32> = caps.iter().flatten().copied().filter(|vertex| !ends.contains(vertex)).collect();
    within.iter().for_each(|&v| vertices[v as usize][axis] += way);
    // The copy of a vertex by the edge that leaves it. A rim may pass a vertex twice: every fan of triangles has its own.
    let mut copies = BTreeMap::new();
    for &(vertex, first) in &rim {
        let copy = vertices.len() as u32;
        let mut position = vertices[vertex as usize];
        position[axis] += way;
        vertices.push(position);
        let mut next = Some(first);
        while let Some(end) = next {
            copies.insert((vertex, end), copy);
            next = corner.get(&(vertex, end)).copied();
        }
    }
    let moved = |from: u32, to: u32| copies.get(&(from, to)).copied().unwrap_or(from);
    *triangles = others;
    triangles.extend(caps.iter().map(|&[a, b, c]| [moved(a, b), moved(b, c), moved(c, a)]));
    triangles.extend(rim.iter().flat_map(|&(a, b)| [[a, b, moved(b, a)], [a, moved(b, a), moved(a, b)]]));
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::geometry::convex_hull;
    use meso_collision::math::Vec3;
    use meso_concrete::aggregate::Kind;
    use meso_concrete::mark_caps;
    use meso_concrete::specimen::Specimen;

    fn grain(mesh: &TriangleMesh) -> Aggregate {
        let body = Polyhedron::of_surface(mesh);
        let mut grains = [Aggregate {
            id: 0,
            kind: Kind::Aggregate,
            own: None,
            class: 0,
            itz_thickness_mm: 0.0,
            shells: Vec::new(),
            body,
        }];
        mark_caps(&mut grains, &Specimen::cube(9.0));
        let [grain] = grains;
        grain
    }

    /// The volume of a grain in a box of 9 mm once it is continued by 1.5 mm.
    fn long_volume(mesh: &TriangleMesh) -> f64 {
        let long = continued(&[grain(mesh)], 1.5).unwrap().remove(0).body;
        let surface = TriangleMesh { vertices: long.vertices().to_vec(), triangles: long.triangles().collect() };
        assert_eq!(surface.check_closed(), Ok(()));
        long.volume()
    }

    /// A cube of 4 mm with a corner at `x`.
    fn cube(x: Vec3) -> TriangleMesh {
        let corner = |k: u32| x + Vec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2)) * 4.0;
        let hull = convex_hull(&(0..8).map(corner).collect::<Vec<_>>()).unwrap();
        TriangleMesh { vertices: hull.vertices().to_vec(), triangles: hull.triangles().collect() }
    }

    #[test]
    fn a_corner_of_a_box_is_continued_along_every_axis() {
        for (x, expected) in [
            (Vec3::zeros(), 5.5_f64.powi(3)),
            (Vec3::repeat(5.0), 5.5_f64.powi(3)),
            (Vec3::new(0.0, 2.0, 5.0), 5.5 * 5.5 * 4.0),
        ] {
            assert!((long_volume(&cube(x)) - expected).abs() < 1e-9);
        }
        assert!(continued(&[grain(&cube(Vec3::repeat(1.0)))], 1.5).is_none());
    }

    #[test]
    fn a_rim_that_passes_a_vertex_twice_is_continued_as_two() {
        // Two tetrahedra on the side with one corner in common.
        let [x, y, z] = [Vec3::x() * 2.0, Vec3::y() * 2.0, Vec3::z() * 2.0];
        let middle = x * 2.0 + y * 2.0;
        let vertices = vec![middle, middle - x, middle - y, middle - x + z, middle + x, middle + y, middle + x + z];
        let half = |a, b, c| [[0, b, a], [0, a, c], [a, b, c], [b, 0, c]];
        let mesh = TriangleMesh { vertices, triangles: [half(1, 2, 3), half(4, 5, 6)].concat() };
        assert!((long_volume(&mesh) - mesh.volume() - 2.0 * 2.0 * 1.5).abs() < 1e-9);
    }
}
