//! Flaps: cells of a body whose corners all lie on its surface, and one of whose free faces looks into the body.
//!
//! The fit leaves some at edges, and many where it closed a gap. A layer cannot go below such a face: its prism would stand
//! upside down. Nodes that step back from there take the layer's thickness from all that is around; so the mortar gets the cell.

use super::has_some;
use super::periodic::{Faces, Flat};
use crate::cells::{NO_BODY, Owners, Phase, by_nodes};
use crate::tet::{TetMesh, volume};
use meso_collision::posed::WithTree;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{parallel, stop};

/// A flap may hide another: 132, 31 and 4 in a dense cube of 128 polyhedra.
const ROUNDS: usize = 3;
/// How far from a face's middle its body's surface is asked, as a share of the face's size.
const NEAR: f64 = 0.05;

/// Gives the mortar the flaps of the `bodies` that get a layer, whose indices the cells carry. A body whose flaps would be more
/// than the share `most` of it in a round keeps them.
pub(crate) fn unfold(mesh: &mut TetMesh, phase: &mut [Phase], periodic: [bool; 3], bodies: &[Aggregate], most: f64) {
    let caps: Vec<u8> = bodies.iter().map(|body| body.body.caps()).collect();
    let sides = Faces::of(mesh, periodic, &caps);
    for _ in 0..ROUNDS {
        let flaps = flaps(mesh, &sides, bodies, most);
        for &cell in &flaps {
            mesh.owner[cell as usize] = NO_BODY;
            phase[cell as usize] = Phase::Mortar;
        }
        if flaps.is_empty() {
            break;
        }
    }
}

/// A face of a cell that may be a flap: the body, the cell, the face's number, and whether mortar is behind it, else the body.
type Side = (u32, u32, u8, bool);

/// The cells with two or more faces to the mortar, one of which looks into the body, and more so than those that would then be
/// its surface; none at faces across which the mesh repeats itself, whose opposite ones must have the same, nor at caps.
fn flaps(mesh: &TetMesh, at: &Faces, bodies: &[Aggregate], most: f64) -> Vec<u32> {
    let owners = Owners::of(mesh.by_body());
    let lies_on = |node: u32| owners.are_several(node) && at.flat(node) == Flat::SPACE;
    let has_layer = |body: &Aggregate| (0..=body.shells.len()).any(|layer| has_some(body.layer_between(layer)));
    let is_split = |owner: u32| owner != NO_BODY && has_layer(&bodies[owner as usize]);
    let may_be = |cell: usize| is_split(mesh.owner[cell]) && mesh.cells[cell].iter().all(|&node| lies_on(node));
    let mut asked = vec![false; mesh.points.len()];
    for cell in parallel::filter(mesh.cells.len(), may_be) {
        mesh.cell(cell).iter().for_each(|&node| asked[node as usize] = true);
    }
    let mut around = by_nodes(mesh.by_body(), |node| asked[node as usize]);
    around.sort_unstable();
    let pairs = around.chunk_by(|a, b| a.0 == b.0).filter(|pair| pair.len() == 2);
    let sides = pairs.flat_map(|pair| [(pair[0].1, pair[0].2, pair[1].1), (pair[1].1, pair[1].2, pair[0].1)]);
    let side = |(cell, face, behind): (u32, u8, u32)| {
        let [owner, behind] = [cell, behind].map(|cell| mesh.owner[cell as usize]);
        let counts = may_be(cell as usize) && (behind == NO_BODY || behind == owner);
        counts.then_some((owner, cell, face, behind == NO_BODY))
    };
    let mut sides: Vec<Side> = sides.filter_map(side).collect();
    sides.sort_unstable();
    let of_bodies: Vec<&[Side]> = sides.chunk_by(|a, b| a.0 == b.0).collect();
    let body = |sides: &[Side]| &bodies[sides[0].0 as usize];
    parallel::flat_map(of_bodies.len(), |at| folded(mesh, body(of_bodies[at]), of_bodies[at], most))
}

/// The flaps among the cells of a `body` with these `sides`, unless they are more than the share `most` of it.
fn folded(mesh: &TetMesh, body: &Aggregate, sides: &[Side], most: f64) -> Vec<u32> {
    stop::point();
    let may_be = |sides: &&[Side]| sides.iter().filter(|side| side.3).count() > 1;
    let of_cells: Vec<&[Side]> = sides.chunk_by(|a, b| a.1 == b.1).filter(may_be).collect();
    let body = WithTree::new(&body.body);
    // The cosine between a side's normal and the surface's: 1 where it looks out.
    let looks_out = |side: &Side| {
        let mut corners = mesh.by_body().face(side.1, side.2 as usize).map(|node| mesh.position(node));
        let [a, b, c] = [(); 3].map(|()| corners.next().unwrap_or_default());
        let normal = (b - a).cross(&(c - a));
        let step = normal * (NEAR / normal.norm().sqrt());
        let middle = (a + b + c) / 3.0;
        (body.height(&(middle + step)) - body.height(&(middle - step))) / (2.0 * step.norm())
    };
    let is_flap = |sides: &&&[Side]| {
        let least = |free: bool, way: f64| {
            let of = sides.iter().filter(|side| side.3 == free);
            of.map(|side| way * looks_out(side)).fold(f64::INFINITY, f64::min)
        };
        let now = least(true, 1.0);
        now < 0.0 && least(false, -1.0) > now
    };
    let flaps: Vec<u32> = of_cells.iter().filter(is_flap).map(|sides| sides[0].1).collect();
    let lost: f64 = flaps.iter().map(|&cell| volume(mesh.corners(mesh.cell(cell)))).sum();
    if lost <= most * body.body.volume() { flaps } else { Vec::new() }
}
