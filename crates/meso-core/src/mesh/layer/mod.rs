//! The solid ITZ: a layer of tetrahedra of its exact thickness, split off the inside of every aggregate.
//!
//! Meshing a thin shell directly makes slivers by the hundred thousand. Instead all of an aggregate's cells shrink towards
//! its centroid ([`shrink`]; [`turned`] where a face looks the wrong way), surface nodes onto the offsets of their own
//! faces ([`seat`]), and between each interface triangle and its image stands a prism, cut into three tetrahedra. Where a
//! cell would turn over, its nodes move aside ([`nudge`]); where that does not help they go less far, at last not at all
//! ([`settle`]); a rail of no length takes just one of the three tetrahedra of each prism with it, so neighbours still match.
//! In lattices sharp cells are made blunter ([`blunt`](mod@blunt)), and the layer's volume right again ([`balance`]).
//!
//! In a periodic box whose opposite faces match they match afterwards, too, whatever made the tetrahedra: nodes on faces
//! stay in these, and images of one place go the same ways ([`ties`]).

mod balance;
mod blunt;
mod bodies;
mod collapse;
mod faces;
mod flat;
mod nudge;
mod seat;
mod settle;
mod shrink;
mod sound;
mod steepest;
mod ties;
mod together;
mod turned;

use super::interface::{self, InterfaceFace};
use super::separate::{Copies, separate};
use super::{Mesh, NO_AGGREGATE, Phase};
use crate::aggregate::Aggregate;
use crate::math::Aabb;
pub(super) use blunt::blunt;
use bodies::Bodies;
use rayon::prelude::*;
use settle::{Ways, settle};
use shrink::Shrinks;
use ties::Ties;

/// What a layer had to do without.
pub(super) struct Thinned {
    /// Aggregates too small for their thickness.
    pub(super) aggregates: usize,
    /// Interface nodes that stopped short of their image.
    pub(super) nodes: usize,
    /// Of these, the ones that did not move: there the layer has no thickness.
    pub(super) pinched: usize,
    /// Inner and outer ends.
    pub(super) rails: Vec<[u32; 2]>,
    /// For every rail whether its outer end lies on no face of its aggregate: there is no exact place for the inner one.
    pub(super) loose: Vec<bool>,
    /// The layers' volume in truth, mm3, where it can be told.
    pub(super) exact_mm3: Option<f64>,
}

/// A tetrahedron of the layer; it holds both ends of one rail.
#[derive(Clone, Copy)]
struct LayerCell {
    nodes: [u32; 4],
    /// The copy that the aggregate's cells have for the rail's outer end.
    rail: [u32; 2],
    aggregate: u32,
    /// Area of the interface triangle, mm2.
    area: f64,
}

/// Splits a layer of `thickness(aggregate)` mm off the inside of every aggregate; images share their aggregate's id.
///
/// Every cell of `mesh` must have a positive volume; then every cell has one afterwards, too. Where `mesh` repeats itself
/// it must fill its bounding box, with opposite faces that match.
pub(super) fn add(mesh: &mut Mesh, aggregates: &[Aggregate], thickness: impl Fn(&Aggregate) -> f64 + Sync) -> Thinned {
    let bodies = Bodies::new(aggregates, &Aabb::around(&mesh.points).size());
    bodies.tell_apart(mesh);
    let thickness = |body: u32| thickness(bodies.get(body));
    let mut faces = interface::faces(mesh);
    faces.retain(|face| thickness(mesh.aggregate[face.cell as usize]) > 0.0);
    let copies = separate(mesh, &faces, false);
    let owner = owners(mesh);
    let mut ties = Ties::new(mesh, &bodies, &owner, copies.first());
    ties.align(&mut mesh.points);
    let shrinks = Shrinks::new(&bodies, thickness, &owner, &mut ties, mesh.periodic);
    let layer: Vec<LayerCell> = faces.par_iter().flat_map_iter(|face| prism(mesh, face, &copies, &ties)).collect();
    let mut images = shrinks.images(&mesh.points, &owner, &ties);
    turned::turn(mesh, &faces, &copies, &shrinks, &ties, &mut images);
    let mut seats = images.clone();
    let mut loose = seat::seat(mesh, &copies, &shrinks, &ties, &mut seats);
    loose.sort_unstable();
    nudge::nudge(mesh, &layer, &ties, &images, &mut seats);
    let ways = settle(mesh, &seats, &layer, &ties);
    let mut thinned = Thinned {
        aggregates: shrinks.thinner(&bodies, thickness),
        nodes: copies.iter().filter(|(.., copy)| ways.is_short(*copy)).count(),
        pinched: copies.iter().filter(|(.., copy)| ways.is_pinched(*copy)).count(),
        rails: Vec::new(),
        loose: Vec::new(),
        exact_mm3: balance::exact(&bodies, thickness),
    };
    mesh.points.par_iter_mut().zip(&seats).enumerate().for_each(|(node, (p, to))| *p = ways.place(node as u32, p, to));
    let kept = copies.iter().map(|(.., copy)| copy).filter(|copy| !ways.is_pinched(*copy));
    thinned.loose = kept.map(|copy| loose.binary_search(&ties.lead(copy)).is_ok()).collect();
    thinned.rails = append(mesh, &layer, &copies, &ways);
    bodies.name(mesh);
    thinned
}

/// Adds the layer's cells, and takes back the copies that did not move, with the cells on their rails.
fn append(mesh: &mut Mesh, layer: &[LayerCell], copies: &Copies, ways: &Ways) -> Vec<[u32; 2]> {
    let mut rails = Vec::new();
    for cell in layer.iter().filter(|cell| !ways.is_pinched(cell.rail[0])) {
        mesh.cells.extend(cell.nodes);
        mesh.phase.push(Phase::Itz);
        mesh.aggregate.push(cell.aggregate);
    }
    let mut number: Vec<u32> = (0..mesh.points.len() as u32).collect();
    let mut next = (mesh.points.len() - copies.iter().len()) as u32;
    for (_, node, copy) in copies.iter() {
        if ways.is_pinched(copy) {
            number[copy as usize] = node;
        } else {
            mesh.points[next as usize] = mesh.points[copy as usize];
            number[copy as usize] = next;
            rails.push([next, node]);
            next += 1;
        }
    }
    mesh.points.truncate(next as usize);
    mesh.cells.par_iter_mut().for_each(|node| *node = number[*node as usize]);
    rails
}

/// The aggregate whose cells a node has, [`NO_AGGREGATE`] for nodes of the mortar and of interfaces.
fn owners(mesh: &Mesh) -> Vec<u32> {
    let mut owner = vec![NO_AGGREGATE; mesh.points.len()];
    for (cell, &aggregate) in mesh.cells().zip(&mesh.aggregate).filter(|(_, aggregate)| **aggregate != NO_AGGREGATE) {
        cell.iter().for_each(|&node| owner[node as usize] = aggregate);
    }
    owner
}

/// The prism between an interface triangle and its image; diagonals start at the lowest place, so neighbours match, and
/// the opposite faces of a periodic box.
fn prism(mesh: &Mesh, face: &InterfaceFace, copies: &Copies, ties: &Ties) -> [LayerCell; 3] {
    let aggregate = mesh.aggregate[face.cell as usize];
    let [a, b, c, _] = face.nodes;
    let p = |node: u32| mesh.points[node as usize];
    let area = (p(b) - p(a)).cross(&(p(c) - p(a))).norm() / 2.0;
    let mut rails = [a, b, c].map(|node| [copies.of(aggregate, node), node]);
    let rank = |node: u32| (ties.place(node), node);
    let turns = [(a, b), (b, c), (a, c)].iter().filter(|(first, second)| rank(*first) > rank(*second)).count();
    rails.sort_unstable_by_key(|rail| rank(rail[1]));
    let [[a, d], [b, e], [c, f]] = rails;
    [([a, b, c, f], rails[2]), ([a, e, b, f], rails[1]), ([a, d, e, f], rails[0])].map(|(nodes, rail)| {
        let [i, j, k, l] = nodes;
        // Positive when the rails are in an even order, since the face is counter-clockwise from outside.
        let nodes = if turns % 2 == 0 { nodes } else { [j, i, k, l] };
        LayerCell { nodes, rail, aggregate, area }
    })
}
