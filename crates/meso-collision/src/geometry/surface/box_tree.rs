//! A tree of boxes: which of many bodies are near a box, which is nearest to a point.
//!
//! Halved at the middle centre along the longest axis, down to a few items a leaf, and laid out in the order it is
//! walked: a subtree that does not meet is skipped by one number. It grows with the number of items alone, where the
//! cells of a grid may hold many in one corner and none in the next.

use crate::math::{Aabb, Vec3};

/// Items of a leaf: to look at four boxes takes no longer than to walk two more nodes.
const LEAF: usize = 4;
/// Bound on the rounding error of a box's distance, as a share: far above that of three squares and a root.
const ROUNDING: f64 = 1e-12;

/// The tree of the boxes it was made from, which it does not keep.
#[derive(Clone, Debug)]
pub struct BoxTree {
    /// The root first; the lower half of an inner node follows it.
    nodes: Vec<Node>,
    /// Numbers of the boxes, those of a leaf together.
    items: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Node {
    aabb: Aabb,
    /// The node to go on with when nothing of this one is asked for.
    next: u32,
    /// The items of a leaf; none of an inner node.
    items: std::ops::Range<u32>,
}

impl BoxTree {
    /// The tree of `boxes`, which are numbered in their order.
    pub fn new(boxes: &[Aabb]) -> Self {
        let mut items: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = Vec::with_capacity(boxes.len());
        if !items.is_empty() {
            grow(&mut nodes, boxes, &mut items, 0);
        }
        Self { nodes, items }
    }

    /// The tree of boxes whose order is that of the items of another tree: it is only measured, not sorted.
    pub fn in_order(boxes: &[Aabb]) -> Self {
        let mut nodes = Vec::with_capacity(boxes.len());
        if !boxes.is_empty() {
            measure(&mut nodes, boxes, 0..boxes.len() as u32);
        }
        Self { nodes, items: (0..boxes.len() as u32).collect() }
    }

    /// The items in the order of the leaves.
    pub fn order(&self) -> &[u32] {
        &self.items
    }

    /// The smallest box around all items.
    pub fn aabb(&self) -> Aabb {
        self.nodes.first().map_or_else(Aabb::empty, |root| root.aabb)
    }

    /// True where `visit` is true for all pairs of items, one of each tree, whose boxes come within `margin` of each
    /// other. More pairs may be visited.
    pub fn all_pairs(&self, other: &Self, margin: f64, mut visit: impl FnMut(u32, u32) -> bool) -> bool {
        let mut open = vec![(0, 0)];
        while let Some((a, b)) = open.pop() {
            let (Some(own), Some(others)) = (self.nodes.get(a), other.nodes.get(b)) else { continue };
            if !own.aabb.grown(margin).intersects(&others.aabb) {
                continue;
            }
            let halves = |tree: &Self, at: usize| [at + 1, tree.nodes[at + 1].next as usize];
            match (own.items.is_empty(), others.items.is_empty()) {
                (false, false) => {
                    let pairs = self.leaf(own).iter().flat_map(|&p| other.leaf(others).iter().map(move |&q| (p, q)));
                    if !pairs.into_iter().all(|(p, q)| visit(p, q)) {
                        return false;
                    }
                }
                (true, false) => open.extend(halves(self, a).map(|half| (half, b))),
                (false, true) => open.extend(halves(other, b).map(|half| (a, half))),
                // The larger box is halved.
                _ if own.aabb.size().max() > others.aabb.size().max() => {
                    open.extend(halves(self, a).map(|half| (half, b)));
                }
                _ => open.extend(halves(other, b).map(|half| (a, half))),
            }
        }
        true
    }

    /// The items of a leaf.
    fn leaf(&self, node: &Node) -> &[u32] {
        &self.items[node.items.start as usize..node.items.end as usize]
    }

    /// The items in the leaves whose boxes meet `aabb`: all whose own boxes do, each once, and a few more.
    pub fn near(&self, aabb: Aabb) -> impl Iterator<Item = u32> {
        let mut at = 0;
        let leaves = std::iter::from_fn(move || {
            while let Some(node) = self.nodes.get(at) {
                let meets = node.aabb.intersects(&aabb);
                at = if meets { at + 1 } else { node.next as usize };
                if meets && !node.items.is_empty() {
                    return Some(&self.items[node.items.start as usize..node.items.end as usize]);
                }
            }
            None
        });
        leaves.flatten().copied()
    }

    /// The item at the least `distance`, and that distance; of equally near ones the first. An item's distance is at least
    /// that of `point` to its box. `None` where all are infinitely far.
    pub fn nearest(&self, point: &Vec3, distance: impl Fn(u32) -> f64) -> Option<(u32, f64)> {
        let mut best = (f64::INFINITY, u32::MAX);
        let mut open = vec![(0.0, 0)];
        while let Some((least, at)) = open.pop() {
            let Some(node) = self.nodes.get(at).filter(|_| least * (1.0 - ROUNDING) <= best.0) else { continue };
            for &item in &self.items[node.items.start as usize..node.items.end as usize] {
                let found = (distance(item), item);
                best = if found < best { found } else { best };
            }
            if node.items.is_empty() {
                let lower = at + 1;
                let mut halves =
                    [lower, self.nodes[lower].next as usize].map(|half| (self.nodes[half].aabb.distance(point), half));
                // The nearer one is looked at first: it stands last.
                if halves[0].0 < halves[1].0 {
                    halves.swap(0, 1);
                }
                open.extend(halves);
            }
        }
        (best.1 != u32::MAX).then_some((best.1, best.0))
    }
}

/// Adds the node of `items`, which begin at number `first` of all, and those below it.
fn grow(nodes: &mut Vec<Node>, boxes: &[Aabb], items: &mut [u32], first: u32) {
    let aabb = items.iter().fold(Aabb::empty(), |all, &item| all.with(&boxes[item as usize]));
    let (number, count) = (nodes.len(), items.len());
    let leaf = if count <= LEAF { first..first + count as u32 } else { 0..0 };
    nodes.push(Node { aabb, next: 0, items: leaf });
    if count > LEAF {
        let axis = aabb.size().imax();
        let middle = |item: u32| boxes[item as usize].min[axis] + boxes[item as usize].max[axis];
        // By number where middles are equal: the tree is the same on every machine.
        items.select_nth_unstable_by(count / 2, |&p, &q| middle(p).total_cmp(&middle(q)).then(p.cmp(&q)));
        let (lower, upper) = items.split_at_mut(count / 2);
        grow(nodes, boxes, lower, first);
        grow(nodes, boxes, upper, first + lower.len() as u32);
    }
    nodes[number].next = nodes.len() as u32;
}

/// Adds the node of the boxes of these numbers, halved in the middle as [`grow`] does, and those below it.
fn measure(nodes: &mut Vec<Node>, boxes: &[Aabb], range: std::ops::Range<u32>) {
    let (number, count) = (nodes.len(), range.end - range.start);
    let is_leaf = count as usize <= LEAF;
    let items = if is_leaf { range.clone() } else { 0..0 };
    nodes.push(Node { aabb: Aabb::empty(), next: 0, items });
    let aabb = if is_leaf {
        boxes[range.start as usize..range.end as usize].iter().fold(Aabb::empty(), |all, one| all.with(one))
    } else {
        let middle = range.start + count / 2;
        measure(nodes, boxes, range.start..middle);
        let upper = nodes.len();
        measure(nodes, boxes, middle..range.end);
        nodes[number + 1].aabb.with(&nodes[upper].aabb)
    };
    nodes[number].aabb = aabb;
    nodes[number].next = nodes.len() as u32;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Stream;

    fn boxes(stream: &mut Stream, count: usize) -> Vec<Aabb> {
        let all = Aabb { min: Vec3::zeros(), max: Vec3::repeat(40.0) };
        let mut corner = || stream.point(&all.min, &all.max);
        let one = |_| {
            let min = corner();
            Aabb { min, max: min + corner() * 0.1 }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn a_tree_finds_what_a_look_at_every_box_finds() {
        let mut stream = Stream::new(3);
        let mut met = 0;
        for count in [0, 1, 4, 5, 9, 300] {
            let boxes = boxes(&mut stream, count);
            let tree = BoxTree::new(&boxes);
            for point in self::boxes(&mut stream, 100).iter().map(|near| near.max) {
                let near = Aabb { min: point, max: point }.grown(3.0);
                let meets = |&item: &u32| boxes[item as usize].intersects(&near);
                let mut found: Vec<u32> = tree.near(near).filter(meets).collect();
                found.sort_unstable();
                assert_eq!(found, (0..count as u32).filter(meets).collect::<Vec<_>>());
                met += found.len();
                let distance = |item: u32| boxes[item as usize].distance(&point);
                let least = (0..count as u32).map(|item| (distance(item), item)).min_by(|p, q| p.0.total_cmp(&q.0));
                assert_eq!(tree.nearest(&point, distance), least.map(|(distance, item)| (item, distance)));
            }
        }
        assert!(met > 100, "{met}");
    }
}
