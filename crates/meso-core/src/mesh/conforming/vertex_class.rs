//! What a node of a conforming mesh lies on, and so where it may go and which neighbours it may be contracted onto: surfaces between
//! materials stay as they are, point for point, and so do those around the mesh.

use crate::math::Vec3;
use crate::mesh::tet::{Constraint, ON_MM, Topology, are_coplanar, directions};

/// Where a node may go.
pub(super) enum VertexClass {
    /// Inside one material.
    Free,
    /// In one facet, with this normal; the nodes are its neighbours there.
    Facet(Vec3, Vec<u32>),
    /// On an edge between two facets, in this direction; the nodes are its neighbours there.
    Edge(Vec3, [u32; 2]),
    /// Nowhere.
    Fixed,
}

impl VertexClass {
    pub(super) fn of(topology: &Topology, node: u32) -> Self {
        let Some(sides) = sides(topology, node) else { return Self::Fixed };
        let at = topology.point(node);
        let cross = |[x, y]: &[u32; 2]| (topology.point(*x) - at).cross(&(topology.point(*y) - at));
        let Some(largest) = largest(sides.iter().map(cross)) else { return Self::Free };
        let normal = largest / largest.norm();
        let is_off = |other: &u32| normal.dot(&(topology.point(*other) - at)).abs() > ON_MM;
        let beyond: Vec<[u32; 2]> = sides.iter().copied().filter(|side| side.iter().any(is_off)).collect();
        let around = neighbours(&sides);
        let Some(second) = self::largest(beyond.iter().map(cross)) else { return Self::Facet(normal, around) };
        let second = second / second.norm();
        let is_off_second = |other: &u32| second.dot(&(topology.point(*other) - at)).abs() > ON_MM;
        if beyond.as_flattened().iter().any(is_off_second) {
            return Self::Fixed;
        }
        let both: Vec<u32> = around.into_iter().filter(|other| !is_off(other) && !is_off_second(other)).collect();
        let [p, q] = both[..] else { return Self::Fixed };
        let along = topology.point(q) - topology.point(p);
        let along = along / along.norm();
        let from = at - topology.point(p);
        if (from - along * along.dot(&from)).norm() > ON_MM { Self::Fixed } else { Self::Edge(along, [p, q]) }
    }

    /// Unit vectors in which the node may go.
    pub(super) fn directions(&self) -> Vec<Vec3> {
        match self {
            Self::Free => directions().collect(),
            Self::Facet(normal, _) => {
                let u = normal.cross(&Vec3::ith(normal.iamin(), 1.0)).normalize();
                let (v, half) = (normal.cross(&u), std::f64::consts::FRAC_1_SQRT_2);
                [u, v, (u + v) * half, (u - v) * half]
                    .into_iter()
                    .flat_map(|direction| [direction, -direction])
                    .collect()
            }
            Self::Edge(along, _) => vec![*along, -along],
            Self::Fixed => Vec::new(),
        }
    }

    /// Where a node on the edge from a to b with the cells `around` may go; `None` on the outside of the mesh, or where these are
    /// not known.
    pub(super) fn on_edge(topology: &Topology, around: &[u32], a: u32, b: u32) -> Option<Self> {
        let mut faces = Vec::with_capacity(2 * around.len());
        for &cell in around {
            let others = topology.cell(cell).into_iter().filter(|node| ![a, b].contains(node));
            faces.extend(others.map(|other| (other, topology.owner(cell))));
        }
        let sides = between_materials(faces)?;
        let [p, q] = [a, b].map(|end| topology.point(end));
        match sides[..] {
            [] => (!around.is_empty()).then_some(Self::Free),
            [x, y] if are_coplanar([p, q, topology.point(x), topology.point(y)]) => {
                let normal = (q - p).cross(&(topology.point(x) - p));
                Some(Self::Facet(normal / normal.norm(), vec![a, b, x, y]))
            }
            [_, _] => Some(Self::Edge((q - p) / (q - p).norm(), [a, b])),
            _ => None,
        }
    }
}

impl Constraint for VertexClass {
    /// Steps are in mm.
    fn reachable(&self, x: &Vec3, step: f64) -> Vec<Vec3> {
        self.directions().into_iter().map(|direction| x + direction * step).collect()
    }

    fn may_contract(&self, into: u32) -> bool {
        match self {
            Self::Free => true,
            Self::Facet(_, around) => around.contains(&into),
            Self::Edge(_, ends) => ends.contains(&into),
            Self::Fixed => false,
        }
    }
}

/// The other two nodes of every triangle that a node has between two materials; `None` where it is on the outside of the mesh
/// or its cells are not known.
fn sides(topology: &Topology, node: u32) -> Option<Vec<[u32; 2]>> {
    let star = topology.star(node);
    let mut faces = Vec::with_capacity(3 * star.len());
    for &cell in star {
        let (nodes, grain) = (topology.cell(cell), topology.owner(cell));
        let edges = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].map(|[i, j]: [usize; 2]| [nodes[i], nodes[j]]);
        let beside = edges.into_iter().filter(|edge| !edge.contains(&node));
        faces.extend(beside.map(|[a, b]| ([a.min(b), a.max(b)], grain)));
    }
    if star.is_empty() { None } else { between_materials(faces) }
}

/// Of the triangles of some cells, each with its cell's material, those between two materials; `None` where one has a cell on one
/// side alone.
fn between_materials<T: Copy + Ord>(mut triangles: Vec<(T, u32)>) -> Option<Vec<T>> {
    triangles.sort_unstable();
    let mut between = Vec::new();
    for both in triangles.chunk_by(|a, b| a.0 == b.0) {
        let [(triangle, here), (_, there)] = *both else { return None };
        if here != there {
            between.push(triangle);
        }
    }
    Some(between)
}

fn largest(normals: impl Iterator<Item = Vec3>) -> Option<Vec3> {
    normals.max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))
}

fn neighbours(sides: &[[u32; 2]]) -> Vec<u32> {
    let mut nodes = sides.as_flattened().to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// The eight octants between points on the axes and `centre`, node 6, with the owners of those where x, y and z are
/// positive or not.
#[cfg(test)]
pub(super) fn octants(centre: Vec3, owner: impl Fn([bool; 3]) -> u32) -> crate::mesh::tet::TetMesh {
    let ends = (0..3).flat_map(|i| [Vec3::ith(i, 1.0), Vec3::ith(i, -1.0)]);
    let points: Vec<Vec3> = ends.chain([centre]).collect();
    let of = |octant: u32| [octant >> 2 & 1, 2 + (octant >> 1 & 1), 4 + (octant & 1), 6];
    let cells = (0..8).map(|octant| crate::mesh::tet::oriented(of(octant), &points)).collect();
    let owner = (0..8).map(|octant| owner([octant & 4 == 0, octant & 2 == 0, octant & 1 == 0])).collect();
    crate::mesh::tet::TetMesh { points, cells, owner }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn class(centre: Vec3, owner: impl Fn([bool; 3]) -> u32) -> VertexClass {
        let mut mesh = octants(centre, owner);
        VertexClass::of(&Topology::new(&mut mesh, 0..8), 6)
    }

    #[test]
    fn a_node_is_free_inside_a_material_and_goes_within_a_facet_or_along_an_edge_alone() {
        let centre = Vec3::new(0.2, 0.1, 0.0);
        assert!(matches!(class(centre, |_| 5), VertexClass::Free));
        let facet = class(centre, |[_, _, z]| u32::from(z));
        assert!(
            matches!(&facet, VertexClass::Facet(normal, around) if normal.z.abs() == 1.0 && *around == [0, 1, 2, 3])
        );
        assert!(
            facet.directions().len() == 8
                && facet
                    .directions()
                    .iter()
                    .all(|direction| direction.z == 0.0 && (direction.norm() - 1.0).abs() < 1e-15)
        );
        let off = class(Vec3::new(0.2, 0.1, 1e-6), |[_, _, z]| u32::from(z));
        assert!(matches!(off, VertexClass::Fixed), "of four planes that are all but one");
        let edge = class(Vec3::new(0.0, 0.0, 0.3), |[x, y, _]| u32::from(x && y));
        assert!(matches!(&edge, VertexClass::Edge(along, [4, 5]) if along.z.abs() == 1.0));
        assert!(edge.may_contract(4) && !edge.may_contract(0));
        assert!(matches!(class(Vec3::zeros(), |[x, y, z]| u32::from(x && y && z)), VertexClass::Fixed), "a corner");
    }

    #[test]
    fn nodes_on_the_outside_of_a_mesh_are_fixed() {
        let mut mesh = octants(Vec3::zeros(), |_| 5);
        let topology = Topology::new(&mut mesh, 0..8);
        assert!((0..6).all(|node| matches!(VertexClass::of(&topology, node), VertexClass::Fixed)));
    }
}
