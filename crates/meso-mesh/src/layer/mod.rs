//! The solid ITZ: a layer of tetrahedra of its exact thickness, split off the inside of every body; and the shells below it,
//! one after the other ([`nested`](mod@nested)).
//!
//! Meshing a thin shell directly makes slivers by the hundred thousand. Instead all of a body's cells shrink towards its centroid,
//! surface nodes onto the offsets of their own faces ([`offset`]) or of the mesh's triangles ([`triangles`]), and between each
//! interface triangle and its offset stands a prism, cut into three tetrahedra ([`prisms`]). Where a cell would turn over, its
//! nodes are untangled; where that does not help they step back, at last to where they were; a rail (an edge between the two
//! ends) of no length takes just one of the three tetrahedra of each prism with it, so neighbours still match. In lattices small
//! angles are enlarged, by smoothing and by rails that collapse, and the layer's volume made right again
//! ([`improve`](mod@improve)).
//!
//! In lattices, cells that stand across a layer's way belong to the mortar first ([`unfold`](mod@unfold)).
//!
//! There is no layer below a cap, where a side of the box cuts a body; its nodes there stay in this side.
//!
//! In a periodic box whose opposite faces match they match afterwards, too, whatever made the tetrahedra: nodes on faces
//! stay in these, and images of each other move by the same displacement ([`periodic`]).

mod approach;
mod improve;
mod nested;
mod offset;
mod periodic;
mod prisms;
mod triangles;
mod unfold;

use crate::cells::{NO_BODY, Owners, Phase, copies, faces};
use crate::tet::TetMesh;
use approach::approach;
pub(super) use improve::improve;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;
pub(super) use nested::{FinishedLayer, exact_mm3, smooth};
use offset::RadialOffsets;
use periodic::{Bodies, PeriodicConstraint};
use prisms::{Layer, LayerCell, append, prism, step_back, untangle};
pub(super) use unfold::unfold;

/// The surfaces whose offsets are the inner side of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Onto {
    /// The faces of convex bodies, where the mesh has nodes along all of their edges.
    Faces,
    /// The triangles of a mesh of this size of elements, mm, which may cut across edges and dents.
    Triangles(f64),
}

/// Sorts vectors by their nodes; those of one node stay in their order.
fn by_node(vectors: &mut [(u32, Vec3)]) {
    vectors.sort_by_key(|(node, _)| *node);
}

/// Whether there is a layer between two depths.
fn has_some([begin, end]: [f64; 2]) -> bool {
    end > begin
}

/// Splits the layer `between(body)`, two depths in mm, off the inside of every one of `bodies`, which are sorted by id. What lies
/// above must be of no body.
///
/// The exact volume of all layers together is `exact_mm3`, where it is known, those of a body and its images once.
/// Every cell must have a positive volume; then every cell has one afterwards, too. Where the mesh repeats itself it must fill its
/// bounding box, with opposite faces that match.
pub(super) fn add(
    mesh: &mut TetMesh,
    phase: &mut Vec<Phase>,
    periodic: [bool; 3],
    bodies: &[Aggregate],
    between: impl Fn(&Aggregate) -> [f64; 2] + Sync,
    onto: Onto,
    exact_mm3: Option<f64>,
) -> Layer {
    let bodies = Bodies::new(bodies, &Aabb::around(&mesh.points).size());
    let between = |body: u32| between(bodies.get(body));
    let mut faces = faces(mesh.by_body());
    faces.retain(|face| has_some(between(mesh.owner[face.cell as usize])));
    let copies = copies(mesh.by_body(), &faces, None);
    copies.part(&mut mesh.points, 4, mesh.cells.as_flattened_mut(), &mesh.owner);
    // Nodes of the mortar, and of interfaces, have none.
    let owners = Owners::among(mesh.by_body(), |cell| mesh.owner[cell] != NO_BODY);
    let owner: Vec<u32> = (0..mesh.points.len() as u32).map(|node| owners.last(node)).collect();
    let mut constraint = PeriodicConstraint::new(mesh, periodic, &bodies, &owner, copies.first());
    constraint.align(&mut mesh.points);
    let thick = match onto {
        Onto::Faces => f64::INFINITY,
        Onto::Triangles(size) => triangles::THICK * size,
    };
    let offsets = RadialOffsets::new(&bodies, between, thick, &owner, &mut constraint, periodic);
    let layer: Vec<LayerCell> = parallel::flat_map(faces.len(), |face| prism(mesh, &faces[face], &copies, &constraint));
    let mut on_rays = offsets.targets(&mesh.points, &owner, &constraint);
    offset::use_fallback_directions(mesh, &faces, &copies, &offsets, &constraint, &mut on_rays);
    let mut targets = on_rays.clone();
    match onto {
        Onto::Faces => offset::project(mesh, &copies, &offsets, &constraint, &mut targets),
        Onto::Triangles(size) => {
            triangles::project(mesh, &faces, &copies, &offsets, &constraint, &mut targets);
            let reach = offsets.thickest_to_settle() / size;
            triangles::settle(mesh, &faces, &copies, &offsets, &constraint, reach, &mut targets);
            if let Some(exact) = exact_mm3.filter(|exact| *exact > 0.0) {
                triangles::scale(mesh, &layer, copies.first(), exact, &mut targets);
            }
            triangles::relax(mesh, &owner, copies.first(), &offsets, &constraint, reach, &mut targets);
        }
    }
    let stuck = untangle(mesh, &layer, &constraint, &on_rays, &mut targets);
    if offsets.back_onto_rays(&stuck, &mesh.points, &owner, &constraint, &mut targets) {
        untangle(mesh, &layer, &constraint, &on_rays, &mut targets);
    }
    let mut at = step_back(mesh, &targets, &layer, &constraint);
    approach(mesh, &layer, &constraint, &targets, &mut at);
    let pinched = parallel::map_short(at.len(), |node| at[node] == mesh.points[node]);
    mesh.points = at;
    let thinned_aggregates = offsets.thinner(&bodies, between);
    let rails = append(mesh, phase, &layer, &copies, &targets, &pinched);
    Layer { thinned_aggregates, pinched_nodes: copies.iter().len() - rails.len(), rails, caps: bodies.caps() }
}
