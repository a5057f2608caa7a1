//! Mends surfaces as other programs write them: corners that should be equal, facets written twice or turned over, triangles
//! without area.
//!
//! A surface whose edges all lie between two triangles is left alone, so that its packing keeps its bytes. Nothing is
//! closed that has a real hole: only ends of open edges are joined, and only within [`SHARE`] of the size.

use super::Imported;
use meso_collision::geometry::{SurfaceError, TriangleMesh};
use meso_collision::math::{Aabb, Vec3};
use std::collections::{BTreeMap, HashMap};

/// Corners nearer than this share of the surface's diagonal are joined where they are ends of open edges.
const SHARE: f64 = 1e-6;
/// Corners in single precision differ by as much, as a share of their largest coordinate: 4 units in the last place.
const SINGLE: f64 = 4.0 / (1 << 23) as f64;

/// Joins corners and drops doubled facets where edges are open or have too many triangles.
pub(super) fn mended(mesh: TriangleMesh) -> Imported {
    let edges = mesh.check_edges();
    if edges.is_ok() {
        return Imported { mesh, edges, notes: Vec::new() };
    }
    let mut tried = mesh.clone();
    let joined = join_corners(&mut tried);
    let dropped = drop_twins(&mut tried);
    let turned = turn_to_neighbours(&mut tried);
    let outcome = tried.check_edges();
    let is_worse =
        matches!((&edges, &outcome), (Err(SurfaceError::Open { .. }), Err(SurfaceError::NotManifold { .. })));
    if tried.triangles.is_empty() || is_worse {
        return Imported { mesh, edges, notes: Vec::new() };
    }
    let corners = (joined > 0).then(|| {
        format!(
            "{joined} corner(s) were joined with others within {:.1e} mm, {SHARE:e} of its size",
            tolerance(&mesh.vertices)
        )
    });
    let twins = (dropped > 0).then(|| format!("{dropped} triangle(s) that stood there twice were dropped"));
    let turned = (turned > 0)
        .then(|| format!("{turned} triangle(s) that faced the other way than their neighbours were turned"));
    Imported { mesh: tried, edges: outcome, notes: corners.into_iter().chain(twins).chain(turned).collect() }
}

/// Distance within which corners are one, mm.
fn tolerance(vertices: &[Vec3]) -> f64 {
    let aabb = Aabb::around(vertices);
    let farthest = aabb.min.abs().sup(&aabb.max.abs()).max();
    (SHARE * aabb.size().norm()).max(SINGLE * farthest)
}

/// Joins every end of an open edge with an earlier one within the tolerance; their number.
fn join_corners(mesh: &mut TriangleMesh) -> usize {
    let tolerance = tolerance(&mesh.vertices);
    let open = open_ends(mesh);
    let cell = |p: &Vec3| <[i64; 3]>::from((p / tolerance).map(|x| x.floor() as i64));
    // Corners that stay lie farther apart than the tolerance, so that a cell has few.
    let mut stay: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut target: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for &corner in &open {
        let position = &mesh.vertices[corner as usize];
        let here = cell(position);
        let near = (0..27).flat_map(|k| {
            let [x, y, z] = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            stay.get(&[here[0] + x, here[1] + y, here[2] + z]).into_iter().flatten()
        });
        let reaches = |&&other: &&u32| (mesh.vertices[other as usize] - position).norm() <= tolerance;
        match near.copied().filter(|other| reaches(&other)).min() {
            Some(other) => target[corner as usize] = other,
            None => stay.entry(here).or_default().push(corner),
        }
    }
    let joined = (0..).zip(&target).filter(|&(own, other): &(u32, &u32)| own != *other).count();
    rename(mesh, &target);
    joined
}

/// Ends of the edges without a triangle on the other side, ascending.
fn open_ends(mesh: &TriangleMesh) -> Vec<u32> {
    let mut edges: Vec<(u32, u32)> = mesh.triangles.iter().flat_map(edges_of).collect();
    edges.sort_unstable();
    let open = edges.iter().filter(|&&(from, to)| edges.binary_search(&(to, from)).is_err());
    let mut ends: Vec<u32> = open.flat_map(|&(from, to)| [from, to]).collect();
    ends.sort_unstable();
    ends.dedup();
    ends
}

fn edges_of(&[a, b, c]: &[u32; 3]) -> [(u32, u32); 3] {
    [(a, b), (b, c), (c, a)]
}

/// Puts `target[v]` for every vertex v. Triangles that lose a corner, and vertices without triangles, are left out.
fn rename(mesh: &mut TriangleMesh, target: &[u32]) {
    let renamed = mesh.triangles.iter().map(|t| t.map(|v| target[v as usize]));
    let solid: Vec<[u32; 3]> = renamed.filter(|[a, b, c]| a != b && b != c && c != a).collect();
    *mesh = compact(&mesh.vertices, &solid);
}

/// The mesh of these triangles alone, its vertices in their old order.
fn compact(vertices: &[Vec3], triangles: &[[u32; 3]]) -> TriangleMesh {
    let mut number = vec![u32::MAX; vertices.len()];
    triangles.iter().flatten().for_each(|&vertex| number[vertex as usize] = 0);
    let mut kept = Vec::new();
    for (number, vertex) in number.iter_mut().zip(vertices).filter(|(number, _)| **number == 0) {
        *number = kept.len() as u32;
        kept.push(*vertex);
    }
    TriangleMesh { vertices: kept, triangles: triangles.iter().map(|t| t.map(|v| number[v as usize])).collect() }
}

/// Keeps one of equal triangles, and none of two that differ in orientation only; the number of those dropped.
fn drop_twins(mesh: &mut TriangleMesh) -> usize {
    let oriented = |&[a, b, c]: &[u32; 3]| {
        let least = a.min(b).min(c);
        let [_, p, q] = if least == a {
            [a, b, c]
        } else if least == b {
            [b, c, a]
        } else {
            [c, a, b]
        };
        if p < q { ([least, p, q], 1) } else { ([least, q, p], -1) }
    };
    let mut sums: BTreeMap<[u32; 3], i32> = BTreeMap::new();
    for triangle in &mesh.triangles {
        let (key, sign) = oriented(triangle);
        *sums.entry(key).or_default() += sign;
    }
    let mut kept = Vec::with_capacity(mesh.triangles.len());
    for triangle in &mesh.triangles {
        let (key, sign) = oriented(triangle);
        let sum = sums.get_mut(&key).expect("each was counted");
        if *sum * sign > 0 {
            *sum = 0;
            kept.push(*triangle);
        }
    }
    let dropped = mesh.triangles.len() - kept.len();
    *mesh = compact(&mesh.vertices, &kept);
    dropped
}

/// Turns triangles so that both of every edge pass it in opposite directions; how many. None are turned where an edge has
/// other than two triangles, or the surface has one side alone, as a Moebius band has.
fn turn_to_neighbours(mesh: &mut TriangleMesh) -> usize {
    let Some(beside) = neighbours(mesh) else { return 0 };
    let mut is_turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    for first in 0..beside.len() {
        if is_turned[first].is_some() {
            continue;
        }
        is_turned[first] = Some(false);
        let (mut part, mut known) = (vec![(first, false)], 0);
        while let Some(&(t, turned)) = part.get(known) {
            known += 1;
            for &(next, is_against) in &beside[t] {
                let wanted = turned ^ is_against;
                match is_turned[next] {
                    Some(found) if found != wanted => return 0,
                    Some(_) => {}
                    None => {
                        is_turned[next] = Some(wanted);
                        part.push((next, wanted));
                    }
                }
            }
        }
        // The side of the most triangles counts.
        if 2 * part.iter().filter(|(_, turned)| *turned).count() > part.len() {
            part.iter().for_each(|&(t, turned)| is_turned[t] = Some(!turned));
        }
    }
    let wrong = mesh.triangles.iter_mut().zip(is_turned).filter(|(_, turned)| *turned == Some(true));
    wrong.map(|(triangle, _)| triangle.swap(1, 2)).count()
}

/// For every triangle those beyond its edges, and whether they pass the edge in the same direction; `None` where an edge has
/// other than two triangles.
fn neighbours(mesh: &TriangleMesh) -> Option<Vec<Vec<(usize, bool)>>> {
    let mut sides: Vec<(u32, u32, usize, bool)> = Vec::with_capacity(3 * mesh.triangles.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        sides.extend(edges_of(triangle).map(|(from, to)| (from.min(to), from.max(to), t, from < to)));
    }
    sides.sort_unstable();
    let mut beside = vec![Vec::with_capacity(3); mesh.triangles.len()];
    for side in sides.chunk_by(|p, q| (p.0, p.1) == (q.0, q.1)) {
        let [p, q] = side else { return None };
        beside[p.2].push((q.2, p.3 == q.3));
        beside[q.2].push((p.2, p.3 == q.3));
    }
    Some(beside)
}

/// The mesh without triangles that are flat within the tolerance, and how many there were; `None` where there are none,
/// or they cannot be removed.
///
/// Two corners of a needle are joined. The long edge of any other is flipped: its middle corner then splits the triangle
/// beyond that edge.
pub fn without_flat_triangles(mesh: &TriangleMesh) -> Option<(TriangleMesh, usize)> {
    let tolerance = tolerance(&mesh.vertices);
    let is_flat = |mesh: &TriangleMesh, t: &[u32; 3]| height(mesh, t) <= tolerance;
    let flat = mesh.triangles.iter().filter(|t| is_flat(mesh, t)).count();
    if flat == 0 {
        return None;
    }
    let mut mended = joined_needles(mesh, tolerance).unwrap_or_else(|| mesh.clone());
    drop_twins(&mut mended);
    while flip_flat(&mut mended, |mesh, t| is_flat(mesh, t)) > 0 {}
    drop_twins(&mut mended);
    (mended.check_edges().is_ok() && !mended.triangles.iter().any(|t| is_flat(&mended, t))).then_some((mended, flat))
}

/// Distance of the corner opposite to the longest edge from that edge, mm.
fn height(mesh: &TriangleMesh, triangle: &[u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|v| mesh.vertices[v as usize]);
    let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
    (b - a).cross(&(c - a)).norm() / longest
}

/// The mesh with the ends of edges that are shorter than the tolerance joined, if its edges are then sound.
fn joined_needles(mesh: &TriangleMesh, tolerance: f64) -> Option<TriangleMesh> {
    let mut target: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for (from, to) in mesh.triangles.iter().flat_map(edges_of) {
        if (mesh.vertices[from as usize] - mesh.vertices[to as usize]).norm() <= tolerance {
            let (low, high) = (target[from.min(to) as usize], from.max(to));
            target[high as usize] = low;
        }
    }
    let mut joined = mesh.clone();
    rename(&mut joined, &target);
    drop_twins(&mut joined);
    joined.check_edges().is_ok().then_some(joined)
}

/// Flips the long edge of each flat triangle whose neighbour there is not flat; the number of flips. One pass over the
/// triangles; each flip leaves one flat triangle less.
fn flip_flat(mesh: &mut TriangleMesh, is_flat: impl Fn(&TriangleMesh, &[u32; 3]) -> bool) -> usize {
    let mut of_edge: HashMap<(u32, u32), usize> = HashMap::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        of_edge.extend(edges_of(triangle).map(|edge| (edge, t)));
    }
    let mut flips = 0;
    for t in 0..mesh.triangles.len() {
        let triangle = mesh.triangles[t];
        if !is_flat(mesh, &triangle) {
            continue;
        }
        let [a, b, middle] = longest_first(mesh, triangle);
        let Some(&beyond) = of_edge.get(&(b, a)) else { continue };
        let other = mesh.triangles[beyond];
        let Some(&tip) = other.iter().find(|&&v| v != a && v != b) else { continue };
        let makes_third = of_edge.contains_key(&(middle, tip)) || of_edge.contains_key(&(tip, middle));
        let halves @ [first, second] = [[b, middle, tip], [middle, a, tip]];
        if tip == middle || makes_third || is_flat(mesh, &other) || halves.iter().any(|half| is_flat(mesh, half)) {
            continue;
        }
        (mesh.triangles[t], mesh.triangles[beyond]) = (first, second);
        of_edge.remove(&(a, b));
        of_edge.remove(&(b, a));
        of_edge.extend(edges_of(&first).map(|edge| (edge, t)));
        of_edge.extend(edges_of(&second).map(|edge| (edge, beyond)));
        flips += 1;
    }
    flips
}

/// The triangle turned so that its longest edge comes first.
fn longest_first(mesh: &TriangleMesh, [a, b, c]: [u32; 3]) -> [u32; 3] {
    let length = |p: u32, q: u32| (mesh.vertices[p as usize] - mesh.vertices[q as usize]).norm();
    let (ab, bc, ca) = (length(a, b), length(b, c), length(c, a));
    if ab >= bc && ab >= ca {
        [a, b, c]
    } else if bc >= ca {
        [b, c, a]
    } else {
        [c, a, b]
    }
}
