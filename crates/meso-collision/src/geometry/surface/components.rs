//! Parts of a surface: triangles that edges connect.
//!
//! Bodies may touch: in a corner, which connects nothing, or in an edge where four triangles or more meet. Around such an edge
//! the inside and the outside take turns, and the two triangles on either side of the same wedge of the inside belong together.

use crate::geometry::TriangleMesh;
use crate::math::Vec3;
use std::collections::BTreeMap;

/// A triangle at an edge: the lower and the upper end, its number, and whether it runs from the lower to the upper one.
type Side = (u32, u32, u32, bool);

impl TriangleMesh {
    /// The parts that edges connect, each with its own vertices: bodies that touch in a corner, an edge or a face are two.
    ///
    /// Where more than two triangles meet in an edge, those on either side of the same part of the inside are connected.
    pub fn components(&self) -> Vec<Self> {
        let split = self.split();
        let component_of = split.component_of();
        let mut numbers = BTreeMap::new();
        let mut components: Vec<Self> = Vec::new();
        let mut own = vec![0; split.vertices.len()];
        for (vertex, root) in component_of.iter().enumerate() {
            let number = *numbers.entry(*root).or_insert(components.len());
            if number == components.len() {
                components.push(Self { vertices: Vec::new(), triangles: Vec::new() });
            }
            own[vertex] = components[number].vertices.len() as u32;
            components[number].vertices.push(split.vertices[vertex]);
        }
        for triangle in &split.triangles {
            let number = numbers[&component_of[triangle[0] as usize]];
            components[number].triangles.push(triangle.map(|vertex| own[vertex as usize]));
        }
        components
    }

    /// For every vertex the lowest that triangles connect it with.
    pub fn component_of(&self) -> Vec<u32> {
        let sides = self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c)]);
        lowest_of(self.vertices.len(), sides)
    }

    /// The surface in which each part has its own vertices, where several touch.
    fn split(&self) -> Self {
        let part_of = lowest_of(self.triangles.len(), self.neighbours());
        let mut split = self.clone();
        let mut owner = vec![u32::MAX; self.vertices.len()];
        let mut copies = BTreeMap::new();
        for (triangle, part) in split.triangles.iter_mut().zip(part_of) {
            for vertex in triangle {
                let owner = &mut owner[*vertex as usize];
                *owner = if *owner == u32::MAX { part } else { *owner };
                if *owner != part {
                    *vertex = *copies.entry((*vertex, part)).or_insert_with(|| {
                        split.vertices.push(self.vertices[*vertex as usize]);
                        split.vertices.len() as u32 - 1
                    });
                }
            }
        }
        split
    }

    /// Pairs of triangles that an edge connects.
    fn neighbours(&self) -> Vec<(u32, u32)> {
        let side = |t: u32, p: u32, q: u32| (p.min(q), p.max(q), t, p < q);
        let sides_of = |(t, &[a, b, c]): (u32, &[u32; 3])| [side(t, a, b), side(t, b, c), side(t, c, a)];
        let all = || (0..).zip(&self.triangles).flat_map(sides_of);
        // By their lower ends first, which are counted: few sides are left to sort at each.
        let mut ends = vec![0; self.vertices.len() + 1];
        all().for_each(|side| ends[side.0 as usize + 1] += 1);
        (1..ends.len()).for_each(|low| ends[low] += ends[low - 1]);
        let mut sides: Vec<Side> = vec![Side::default(); 3 * self.triangles.len()];
        for side in all() {
            sides[ends[side.0 as usize]] = side;
            ends[side.0 as usize] += 1;
        }
        sides.chunk_by_mut(|p, q| p.0 == q.0).for_each(<[Side]>::sort_unstable);
        let is_inside_out = self.volume() < 0.0;
        let mut pairs = Vec::with_capacity(sides.len() / 2);
        for around in sides.chunk_by(|p, q| (p.0, p.1) == (q.0, q.1)) {
            let wedges = if around.len() > 2 { self.wedges(around, is_inside_out) } else { None };
            match wedges {
                Some(wedges) => pairs.extend(wedges),
                None => pairs.extend(around.windows(2).map(|pair| (pair[0].2, pair[1].2))),
            }
        }
        pairs
    }

    /// The triangles around an edge by pairs, each about a wedge of the inside; `None` where the sides do not take turns.
    fn wedges(&self, around: &[Side], is_inside_out: bool) -> Option<Vec<(u32, u32)>> {
        let (low, high) = (self.vertices[around[0].0 as usize], self.vertices[around[0].1 as usize]);
        let along = (high - low).try_normalize(0.0)?;
        let across = along.cross(&Vec3::ith(along.iamin(), 1.0)).normalize();
        let other = along.cross(&across);
        let angle = |t: u32| {
            let [a, b, c] = self.triangles[t as usize].map(|vertex| self.vertices[vertex as usize]);
            let apex = a + b + c - low - high - low;
            libm::atan2(apex.dot(&other), apex.dot(&across))
        };
        // A triangle that runs along the edge has the inside before it; where two lie on each other, it comes first.
        let mut turns: Vec<_> = around.iter().map(|&(.., t, runs)| (angle(t), runs == is_inside_out, t)).collect();
        turns.sort_unstable_by(|p, q| p.0.total_cmp(&q.0).then(p.1.cmp(&q.1)));
        let begins = turns.iter().position(|turn| turn.1)?;
        turns.rotate_left(begins);
        let wedges = turns.chunks(2).map(|wedge| match wedge {
            [(_, true, first), (_, false, second)] => Some((*first, *second)),
            _ => None,
        });
        wedges.collect()
    }
}

/// For every number below `count` the lowest that `pairs` connect it with.
fn lowest_of(count: usize, pairs: impl IntoIterator<Item = (u32, u32)>) -> Vec<u32> {
    let mut lower: Vec<u32> = (0..count as u32).collect();
    let root = |lower: &mut Vec<u32>, mut number: u32| {
        while lower[number as usize] != number {
            // Path halving, so that the next walk is shorter.
            lower[number as usize] = lower[lower[number as usize] as usize];
            number = lower[number as usize];
        }
        number
    };
    for (p, q) in pairs {
        let (p, q) = (root(&mut lower, p), root(&mut lower, q));
        lower[p.max(q) as usize] = p.min(q);
    }
    (0..count as u32).map(|number| root(&mut lower, number)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::convex_hull;

    /// Blocks of these lowest and highest corners, with the vertices that they share.
    fn blocks(boxes: &[[[f64; 3]; 2]]) -> TriangleMesh {
        let corners = boxes.iter().flat_map(|[low, high]| {
            let points: Vec<Vec3> = (0..8)
                .map(|k| Vec3::from_fn(|axis, _| if k >> axis & 1 == 1 { high[axis] } else { low[axis] }))
                .collect();
            let block = convex_hull(&points).unwrap();
            block.triangles().flat_map(|t| t.map(|i| block.vertices()[i as usize])).collect::<Vec<_>>()
        });
        TriangleMesh::welded(&corners.collect::<Vec<_>>())
    }

    #[test]
    fn blocks_that_touch_in_a_corner_an_edge_or_a_face_are_two_closed_parts() {
        let first = [[0.0; 3], [2.0, 3.0, 4.0]];
        for (case, other) in [
            ("corner", [[2.0, 3.0, 4.0], [5.0; 3]]),
            ("edge", [[2.0, 3.0, 0.0], [5.0, 5.0, 4.0]]),
            ("face", [[2.0, 0.0, 0.0], [5.0, 3.0, 4.0]]),
            ("nothing", [[3.0, 4.0, 5.0], [5.0, 6.0, 7.0]]),
        ] {
            let mut mesh = blocks(&[first, other]);
            for sign in [1.0, -1.0] {
                let parts = mesh.components();
                assert_eq!(parts.len(), 2, "{case} {sign}");
                for (part, [low, high]) in parts.iter().zip([first, other]) {
                    let volume = (0..3).map(|axis| high[axis] - low[axis]).product::<f64>();
                    assert_eq!(part.check_edges(), Ok(()), "{case} {sign}");
                    assert!((part.volume() * sign - volume).abs() < 1e-12 && part.vertices.len() == 8, "{case} {sign}");
                }
                mesh.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
            }
        }
    }

    /// The surface of the cubes of a grid with these places.
    fn cubes(places: &[[i32; 3]]) -> TriangleMesh {
        let mut corners = Vec::new();
        for place in places {
            for (axis, side) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, -1), (axis, 1)]) {
                let mut next = *place;
                next[axis] += side;
                if places.contains(&next) {
                    continue;
                }
                let corner = |u: i32, v: i32| {
                    let mut at = place.map(f64::from);
                    at[axis] += f64::from((side + 1) / 2);
                    at[(axis + 1) % 3] += f64::from(u);
                    at[(axis + 2) % 3] += f64::from(v);
                    Vec3::from(at)
                };
                let [a, b, c, d] = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                corners.extend(if side > 0 { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] });
            }
        }
        TriangleMesh::welded(&corners)
    }

    #[test]
    fn cubes_that_share_an_edge_alone_are_parts_and_a_ring_that_touches_itself_is_one() {
        // Two of the three share a face, which is no surface.
        let three = cubes(&[[0, 0, 0], [-1, 0, 0], [-1, -1, 0]]);
        assert_eq!(three.components().len(), 1);
        let two = cubes(&[[0, 0, 0], [-1, -1, 0]]);
        assert!(two.check_edges().is_err());
        assert!(two.components().len() == 2 && two.components().iter().all(|part| part.check_closed().is_ok()));
        let ring = cubes(&[[0, 0, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1]]);
        let parts = ring.components();
        assert!(parts.len() == 1 && parts[0].check_edges().is_err());
        assert_eq!(parts[0].triangles.len(), ring.triangles.len());
        // Every second octant about a corner.
        let octants = cubes(&[[0, 0, 0], [-1, -1, 0], [-1, 0, -1], [0, -1, -1]]);
        assert!(octants.components().len() == 4 && octants.components().iter().all(|part| part.check_closed().is_ok()));
    }
}
