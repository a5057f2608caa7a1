//! Small angles of gmsh's mesh are enlarged, and no surface moves: by swaps, contraction, smoothing, and insertion.
//!
//! Every step leaves the smallest angle there larger than it was, no altitude shorter and every volume positive. Nodes on a
//! facet move within it, those on its edges along these, and both sides of a facet's triangles change alike ([`VertexClass`]): so
//! every body stays as it is. The outside of the mesh stays, too, for it may have to match the opposite side.

use crate::cells::NO_BODY;
use crate::tet::{
    Constraint, Improver, NEW, ON_MM, Star, TetMesh, Topology, are_coplanar, ascending, best_position, contraction,
    cos2_of, directions, edges, improve, insertion, smoothed, swapped,
};
use meso_collision::math::Vec3;
use meso_concrete::parallel;
use meso_concrete::stop;

/// Cells with a smaller angle are improved, degrees (somewhat more than the limit of bad ones), and for how many rounds; the worst
/// once more at the end.
const PASSES: [(f64, usize); 2] = [(10.0, 4), (3.0, 8)];
/// Steps tried: of a node in lengths of its shortest edge, of a new one in lengths of the edge that it divides.
const STEPS: [f64; 3] = [0.3, 0.1, 0.03];
/// A new node is worth it where the square of the smallest angle grows by this factor,
const WORTH: f64 = 2.0;
/// or by this one where that angle is below so many degrees.
const WORTH_WHERE_SMALL: (f64, f64) = (1.2, 2.0);
/// Share of the target that the first steps reach, or not at all.
const NEAR: f64 = 0.5;

/// Improves the poor cells of `mesh`.
pub(super) fn enlarge_angles(mesh: &mut TetMesh) {
    let limit = cos2_of(PASSES[0].0);
    let poor = parallel::filter(mesh.cells.len(), |cell| mesh.cos2(cell as u32) > limit);
    let mut topology = Topology::new(mesh, poor.into_iter());
    for (degrees, rounds) in PASSES {
        let limit = cos2_of(degrees);
        let poor = topology.worse(limit);
        improve(&mut PoorCellPass { topology: &mut topology, limit }, poor, rounds);
    }
    mesh.drop_removed();
    mesh.drop_lone_nodes();
}

/// A pass over the cells that are worse than a limit.
struct PoorCellPass<'a, 'm> {
    topology: &'a mut Topology<'m>,
    limit: f64,
}

impl Improver for PoorCellPass<'_, '_> {
    fn is_poor(&self, cell: u32) -> bool {
        self.topology.is_worse(cell, self.limit)
    }

    fn round(&mut self, poor: &[u32]) -> Vec<u32> {
        let mut touched = Vec::new();
        for &cell in poor {
            // One before may have removed or bettered it.
            if self.is_poor(cell) {
                let nodes = self.topology.cell(cell);
                if better(self.topology, cell) {
                    touched.extend(nodes);
                }
            }
        }
        ascending(touched).into_iter().flat_map(|node| self.topology.star(node)).copied().collect()
    }
}

/// Applies the first operator that betters the cells around a cell; whether there was one.
fn better(topology: &mut Topology, cell: u32) -> bool {
    if swapped(topology, cell) {
        return true;
    }
    let nodes = topology.cell(cell);
    let classes = nodes.map(|node| (node, VertexClass::of(topology, node)));
    if classes.iter().any(|(node, class)| contract(topology, *node, &nodes, class)) {
        return true;
    }
    let moved = classes.iter().filter(|(node, class)| smooth(topology, *node, class)).count();
    moved > 0 || edges(nodes).into_iter().any(|[a, b]| insert(topology, a, b))
}

/// Contracts `node` onto one of `others` where that leaves no angle as small as the smallest around it and no altitude shorter;
/// whether it did.
fn contract(topology: &mut Topology, node: u32, others: &[u32], class: &VertexClass) -> bool {
    let may = |into: &u32| *into != node && class.may_contract(*into);
    if !others.iter().any(may) {
        return false;
    }
    // The nodes inside a body stay there: without any its solid ITZ would have nothing to go in to.
    let star = topology.star(node);
    if matches!(class, VertexClass::Free) && topology.owner(star[0]) != NO_BODY {
        return false;
    }
    let worst = topology.worst(star);
    others.iter().filter(|into| may(into)).any(|&into| {
        contraction(topology, node, into, worst).is_some_and(|proposed| topology.replace_thicker(&proposed))
    })
}

/// Moves a node to the best position around it that its class allows; whether there was a better one, with no altitude shorter.
fn smooth(topology: &mut Topology, node: u32, class: &VertexClass) -> bool {
    stop::point();
    let Some(position) = smoothed_position(topology, node, class) else { return false };
    let altitude =
        |topology: &Topology| topology.shortest_altitude(topology.star(node).iter().map(|&cell| topology.cell(cell)));
    let (from, before) = (topology.point(node), altitude(topology));
    topology.move_to(node, position);
    let is_thinner = altitude(topology) < before;
    if is_thinner {
        topology.move_to(node, from);
    }
    !is_thinner
}

fn smoothed_position(topology: &Topology, node: u32, class: &VertexClass) -> Option<Vec3> {
    if topology.star(node).is_empty() || matches!(class, VertexClass::Fixed) {
        return None;
    }
    let mut star = Star::of(topology.mesh, node, topology.star(node));
    let from = topology.point(node);
    let neighbours = topology.star(node).iter().flat_map(|&cell| topology.cell(cell)).filter(|other| *other != node);
    let shortest = neighbours.map(|other| (topology.point(other) - from).norm()).fold(f64::INFINITY, f64::min);
    let before = star.worst_first();
    smoothed(class, &from, STEPS.map(|step| step * shortest), before, |x, limit| star.worst(x, limit))
}

/// Divides the edge from a to b by a new node at the best position around it where that makes the smallest angle there much
/// larger and no altitude shorter; whether it did.
fn insert(topology: &mut Topology, a: u32, b: u32) -> bool {
    let proposed = insertion(topology, a, b);
    let Some(class) = VertexClass::on_edge(topology, &proposed.old, a, b) else { return false };
    let [p, q] = [a, b].map(|end| topology.point(end));
    let position = |node: u32| if node == NEW { (p + q) / 2.0 } else { topology.point(node) };
    let mut star = Star::of_cells(NEW, proposed.new.iter().copied(), position);
    let worst = topology.worst(&proposed.old);
    let worth = if worst > cos2_of(WORTH_WHERE_SMALL.1) { WORTH_WHERE_SMALL.0 } else { WORTH };
    let limit = 1.0 - worth * (1.0 - worst);
    let found = best_for_new(&mut star, (q - p).norm(), &class, limit);
    found.is_some_and(|position| topology.insert_thicker(position, proposed))
}

/// The best position found for the node of `star`, where it leaves all cells better than `limit`; the first steps must come near
/// that.
fn best_for_new(star: &mut Star, length: f64, class: &VertexClass, limit: f64) -> Option<Vec3> {
    let mut best = (star.worst_first(), star.centre);
    for step in STEPS {
        let positions = class.reachable(&best.1, step * length);
        best = best_position(best.0, positions, |x, limit| star.worst(x, limit)).unwrap_or(best);
        if 1.0 - best.0 < NEAR * (1.0 - limit) {
            return None;
        }
    }
    (best.0 < limit).then_some(best.1)
}

/// Where a node may go.
enum VertexClass {
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
        let around = ascending(sides.as_flattened().iter().copied());
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

    /// Whether the node may be contracted onto its neighbour `into`.
    fn may_contract(&self, into: u32) -> bool {
        match self {
            Self::Free => true,
            Self::Facet(_, around) => around.contains(&into),
            Self::Edge(_, ends) => ends.contains(&into),
            Self::Fixed => false,
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
}

/// The other two nodes of every triangle that a node has between two materials; `None` where it is on the outside of the mesh
/// or its cells are not known.
fn sides(topology: &Topology, node: u32) -> Option<Vec<[u32; 2]>> {
    let star = topology.star(node);
    let mut faces = Vec::with_capacity(3 * star.len());
    for &cell in star {
        let (nodes, owner) = (topology.cell(cell), topology.owner(cell));
        let beside = edges(nodes).into_iter().filter(|edge| !edge.contains(&node));
        faces.extend(beside.map(|[a, b]| ([a.min(b), a.max(b)], owner)));
    }
    if star.is_empty() { None } else { between_materials(faces) }
}

/// The triangles between two materials, out of those of some cells, each with its cell's material; `None` where one has a cell on one
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tet::{Replacement, edge_removal, face_swap, oriented};

    /// The eight octants between points on the axes and `centre`, node 6, with the owners of those where x, y and z are
    /// positive or not.
    fn octants(centre: Vec3, owner: impl Fn([bool; 3]) -> u32) -> TetMesh {
        let ends = (0..3).flat_map(|i| [Vec3::ith(i, 1.0), Vec3::ith(i, -1.0)]);
        let points: Vec<Vec3> = ends.chain([centre]).collect();
        let of = |octant: u32| [octant >> 2 & 1, 2 + (octant >> 1 & 1), 4 + (octant & 1), 6];
        let cells = (0..8).map(|octant| oriented(of(octant), &points)).collect();
        let owner = (0..8).map(|octant| owner([octant & 4 == 0, octant & 2 == 0, octant & 1 == 0])).collect();
        TetMesh { points, cells, owner }
    }

    /// Two apexes over and under a triangle of this radius, `height` from it.
    fn spindle(radius: f64, height: f64) -> Vec<Vec3> {
        let corner = |angle: f64| Vec3::new(radius * libm::cos(angle), radius * libm::sin(angle), 0.0);
        let third = 2.0 * std::f64::consts::FRAC_PI_3;
        let apexes = [-height, height].map(|z| Vec3::new(0.0, 0.0, z));
        [corner(0.0), corner(third), corner(2.0 * third)].into_iter().chain(apexes).collect()
    }

    fn mesh(points: Vec<Vec3>, cells: &[[u32; 4]], owner: Vec<u32>) -> TetMesh {
        let cells = cells.iter().map(|cell| oriented(*cell, &points)).collect();
        TetMesh { points, cells, owner }
    }

    fn volume(mesh: &TetMesh) -> f64 {
        mesh.numbers().map(|cell| mesh.volume(cell)).sum()
    }

    fn volume_of(mesh: &TetMesh, owner: u32) -> f64 {
        mesh.numbers().filter(|&cell| mesh.owner[cell as usize] == owner).map(|cell| mesh.volume(cell)).sum()
    }

    /// Whether a proposal is there and thick enough.
    fn apply(topology: &mut Topology, proposed: Option<Replacement>) -> bool {
        proposed.is_some_and(|proposed| topology.replace_thicker(&proposed))
    }

    const AROUND_AN_EDGE: [[u32; 4]; 3] = [[3, 4, 0, 1], [3, 4, 1, 2], [3, 4, 2, 0]];

    #[test]
    fn a_long_edge_is_taken_out_of_the_cells_around_it_within_one_grain_alone() {
        for (owner, done) in [(vec![5; 3], true), (vec![5, 5, 6], false)] {
            let mut mesh = mesh(spindle(0.2, 1.0), &AROUND_AN_EDGE, owner);
            let before = volume(&mesh);
            let mut topology = Topology::new(&mut mesh, 0..3);
            let worst = topology.worst(&[0, 1, 2]);
            let removal = edge_removal(&topology, 3, 4);
            assert_eq!(apply(&mut topology, removal), done);
            assert!(!done || topology.worst(&[0, 1]) < worst);
            mesh.drop_removed();
            assert_eq!((mesh.cells.len(), mesh.owner.len()), if done { (2, 2) } else { (3, 3) });
            assert!((volume(&mesh) - before).abs() < 1e-15);
        }
    }

    #[test]
    fn an_edge_is_put_through_the_face_of_two_flat_cells() {
        let mut mesh = mesh(spindle(1.0, 0.15), &[[0, 1, 2, 3], [0, 1, 2, 4]], vec![5; 2]);
        let before = volume(&mesh);
        let mut topology = Topology::new(&mut mesh, 0..2);
        let swap = face_swap(&topology, 0, 3);
        assert!(apply(&mut topology, swap));
        mesh.drop_removed();
        assert_eq!(mesh.owner, [5; 3]);
        assert!((volume(&mesh) - before).abs() < 1e-15 && mesh.cells.iter().all(|cell| cell.contains(&3)));
    }

    #[test]
    fn an_edge_in_a_facet_gives_way_to_the_other_diagonal_on_both_sides() {
        for (height, done) in [(0.0, true), (0.01, false)] {
            let quad = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.12, height], [0.0, -0.12, 0.0]];
            let points = quad.into_iter().chain([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]).map(Vec3::from).collect();
            let cells = [[0, 1, 2, 4], [0, 1, 4, 3], [0, 1, 3, 5], [0, 1, 5, 2]];
            let mut mesh = mesh(points, &cells, vec![5, 5, 6, 6]);
            let before = volume(&mesh);
            let mut topology = Topology::new(&mut mesh, 0..4);
            let removal = edge_removal(&topology, 0, 1);
            assert_eq!(apply(&mut topology, removal), done);
            mesh.drop_removed();
            assert_eq!(mesh.cells.iter().all(|cell| cell.contains(&2) && cell.contains(&3)), done);
            let above = |(cell, owner): (&[u32; 4], &u32)| cell.contains(&4) == (*owner == 5);
            assert!(mesh.cells.len() == 4 && mesh.cells.iter().zip(&mesh.owner).all(above));
            assert!((volume(&mesh) - before).abs() < 1e-15);
        }
    }

    #[test]
    fn a_node_goes_where_angles_are_larger_as_far_as_its_materials_let_it() {
        let none: fn([bool; 3]) -> u32 = |_| 5;
        let halves: fn([bool; 3]) -> u32 = |[_, _, z]| u32::from(z);
        let quarter: fn([bool; 3]) -> u32 = |[x, y, _]| u32::from(x && y);
        for (from, owner, free) in [
            ([0.3, 0.3, 0.38], none, [true, true, true]),
            ([0.45, 0.5, 0.0], halves, [true, true, false]),
            ([0.0, 0.0, 0.9], quarter, [false, false, true]),
            ([0.3, 0.3, 0.38], quarter, [false, false, false]),
        ] {
            let from = Vec3::from(from);
            let mut mesh = octants(from, owner);
            let (whole, corners) = (volume(&mesh), mesh.points[..6].to_vec());
            let mut topology = Topology::new(&mut mesh, 0..8);
            let class = VertexClass::of(&topology, 6);
            assert_eq!(smooth(&mut topology, 6, &class), free != [false; 3]);
            assert!(mesh.points[..6] == corners[..] && (volume(&mesh) - whole).abs() < 1e-12);
            let moved = (0..3).map(|axis| mesh.points[6][axis] != from[axis]);
            assert!(moved.zip(free).all(|(moved, free)| free || !moved), "{:?}", mesh.points[6]);
        }
    }

    /// A flat cell under a blunt edge of a surface, 0-1, and the cells below it down to node 4.
    fn under_a_blunt_edge() -> TetMesh {
        let points = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, -1.0, -0.02], [0.0, 1.0, -0.02], [0.0, 0.0, -2.0]];
        mesh(points.map(Vec3::from).to_vec(), &[[0, 1, 2, 3], [2, 3, 1, 4], [2, 3, 4, 0]], vec![5; 3])
    }

    #[test]
    fn the_edge_that_makes_a_cell_flat_gets_a_node_far_from_it() {
        let mut mesh = under_a_blunt_edge();
        let before = volume_of(&mesh, 5);
        let mut topology = Topology::new(&mut mesh, 0..3);
        let worst = topology.worst(&[0, 1, 2]);
        assert!(!insert(&mut topology, 0, 1), "an edge on the outside stays");
        assert!(insert(&mut topology, 2, 3));
        assert!(1.0 - topology.worst(&[0, 1, 2, 3, 4, 5]) > 10.0 * (1.0 - worst));
        mesh.drop_removed();
        mesh.drop_lone_nodes();
        assert_eq!((mesh.cells.len(), mesh.points.len()), (6, 6));
        assert!(mesh.points[5].z < -0.2 && (volume_of(&mesh, 5) - before).abs() < 1e-15);
    }

    /// A node on the edge between two facets of body 5, 0.01 from that edge's end, all within body 6.
    #[test]
    fn a_node_close_to_the_end_of_an_edge_becomes_one_with_it_and_the_facets_stay() {
        let ring = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]].map(|[x, y]| [x, y, 0.3]);
        // The edge is 4-5-6, from the bottom to the top, and body 5 between the first two of the ring.
        let line = [[0.0, 0.0, -1.0], [0.0, 0.0, 0.99], [0.0, 0.0, 1.0]];
        let cells: Vec<[u32; 4]> = (0..4).flat_map(|i| [[i, (i + 1) % 4, 4, 5], [i, (i + 1) % 4, 5, 6]]).collect();
        let mut mesh = mesh(
            [&ring[..], &line].concat().into_iter().map(Vec3::from).collect(),
            &cells,
            vec![5, 5, 6, 6, 6, 6, 6, 6],
        );
        let before = [5, 6].map(|owner| volume_of(&mesh, owner));
        let mut topology = Topology::new(&mut mesh, 0..8);
        let class = VertexClass::of(&topology, 5);
        assert!(!contract(&mut topology, 5, &[0, 1, 2, 3], &class), "not off its edge");
        assert!(contract(&mut topology, 5, &[0, 4, 5, 6], &class));
        mesh.drop_removed();
        mesh.drop_lone_nodes();
        assert_eq!((mesh.cells.len(), mesh.points.len()), (4, 6));
        assert!([5, 6].iter().zip(before).all(|(owner, before)| (volume_of(&mesh, *owner) - before).abs() < 1e-15));
    }

    #[test]
    fn a_new_node_between_two_materials_stays_in_their_facet_or_on_their_edge() {
        let class = |height: f64| {
            let square = [[-1.0, 0.0, height], [1.0, 0.0, height], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]];
            let apexes = [[0.0, 0.0, -2.0], [0.0, 0.0, 2.0]];
            let cells = [[2, 3, 1, 4], [2, 3, 4, 0], [2, 3, 0, 5], [2, 3, 5, 1]];
            let mut mesh =
                mesh([&square[..], &apexes].concat().into_iter().map(Vec3::from).collect(), &cells, vec![5, 5, 6, 6]);
            let topology = Topology::new(&mut mesh, 0..4);
            VertexClass::on_edge(&topology, &[0, 1, 2, 3], 2, 3)
        };
        assert!(matches!(class(0.0), Some(VertexClass::Facet(normal, _)) if normal.z.abs() == 1.0));
        assert!(matches!(class(0.3), Some(VertexClass::Edge(along, [2, 3])) if along.y.abs() == 1.0));
    }

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
