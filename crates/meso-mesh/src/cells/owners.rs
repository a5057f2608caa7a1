//! Whose cells meet at every node.

use super::mesh::{Cells, Mesh, NO_BODY};
use meso_concrete::stop;
use rayon::prelude::*;

impl Mesh {
    /// Whose cells meet at every node, of the cells alone whose numbers `counts` picks.
    pub fn owners(&self, counts: impl Fn(usize) -> bool) -> Owners {
        Owners::among(self.by_owner(), counts)
    }
}

/// Whose cells meet at every node.
pub struct Owners {
    /// One of them, [`NO_BODY`] where no cell counts.
    one: Vec<u32>,
    /// Another, where there is another; else the same.
    other: Vec<u32>,
    /// All further ones with their nodes, in order.
    further: Vec<(u32, u32)>,
}

impl Owners {
    /// The owners of all nodes, but for those in the middle of edges.
    pub(crate) fn of(mesh: Cells) -> Self {
        Self::among(mesh, |_| true)
    }

    /// The owners of all nodes among the cells whose numbers `counts` picks.
    pub(crate) fn among(mesh: Cells, counts: impl Fn(usize) -> bool) -> Self {
        let corners = mesh.kind.corners();
        let owned = || {
            let cells = mesh.iter().zip(mesh.owner).enumerate().filter(|(cell, _)| counts(*cell));
            cells.flat_map(|(_, (cell, &owner))| {
                stop::point();
                cell[..corners].iter().map(move |&node| (node, owner))
            })
        };
        let mut one = vec![NO_BODY; mesh.points.len()];
        owned().for_each(|(node, owner)| one[node as usize] = owner);
        let (mut other, mut further) = (one.clone(), Vec::new());
        owned().filter(|&(node, owner)| one[node as usize] != owner).for_each(|(node, owner)| {
            let seen = &mut other[node as usize];
            if *seen == one[node as usize] {
                *seen = owner;
            } else if *seen != owner {
                further.push((node, owner));
            }
        });
        further.sort_unstable();
        further.dedup();
        Self { one, other, further }
    }

    /// True where the cells are not all of one owner.
    pub fn are_several(&self, node: u32) -> bool {
        self.one[node as usize] != self.other[node as usize]
    }

    /// Whether some body owns cells around every one of `nodes`.
    pub(crate) fn have_one_in_common(&self, nodes: impl Iterator<Item = u32> + Clone) -> bool {
        let mut rest = nodes.clone();
        rest.next().is_some_and(|first| self.around(first).any(|body| rest.clone().all(|node| self.has(node, body))))
    }

    /// The bodies that own cells around a node.
    fn around(&self, node: u32) -> impl Iterator<Item = u32> {
        let [one, other] = [self.one[node as usize], self.other[node as usize]];
        let start =
            if one == other { self.further.len() } else { self.further.partition_point(|entry| entry.0 < node) };
        let further = self.further[start..].iter().take_while(move |entry| entry.0 == node).map(|entry| entry.1);
        [one, other].into_iter().filter(|body| *body != NO_BODY).chain(further)
    }

    fn has(&self, node: u32, body: u32) -> bool {
        self.one[node as usize] == body || self.around(node).any(|other| other == body)
    }

    /// The owner of the last cell around a node that counts.
    pub fn last(&self, node: u32) -> u32 {
        self.one[node as usize]
    }

    /// The body of a node that has cells of it and of the mortar, and no others.
    pub(crate) fn beside_mortar(&self, node: u32) -> Option<u32> {
        let has_further = || self.further.binary_search_by_key(&node, |(node, _)| *node).is_ok();
        match [self.one[node as usize], self.other[node as usize]] {
            [one, other] if one == other || has_further() => None,
            [NO_BODY, body] | [body, NO_BODY] => Some(body),
            _ => None,
        }
    }

    /// The body of a node that has one alone; none for nodes that came after.
    pub(crate) fn only(&self, node: u32) -> Option<u32> {
        let one = *self.one.get(node as usize).filter(|one| **one != NO_BODY)?;
        (!self.are_several(node)).then_some(one)
    }

    /// Pairs of bodies that share a node, each once, in order.
    pub fn pairs(&self) -> Vec<(u32, u32)> {
        pairs(&self.bodies(|node| self.are_several(node)))
    }

    /// Nodes with the bodies that own them, each pair once, in order; only the nodes that `asked` picks.
    pub(crate) fn bodies(&self, asked: impl Fn(u32) -> bool) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        for (node, (&one, &other)) in (0..).zip(self.one.iter().zip(&self.other)).filter(|(node, _)| asked(*node)) {
            pairs.push((node, one.min(other)));
            if one != other {
                pairs.push((node, one.max(other)));
            }
        }
        pairs.extend(self.further.iter().filter(|(node, _)| asked(*node)));
        pairs.retain(|(_, owner)| *owner != NO_BODY);
        // Two runs in order: the stable sort merges them.
        pairs.sort();
        pairs
    }
}

/// The pairs of bodies at the same node of `members`, nodes with their bodies in order; each once, in order.
pub(crate) fn pairs(members: &[(u32, u32)]) -> Vec<(u32, u32)> {
    fn each(meet: &[(u32, u32)]) -> impl Iterator<Item = (u32, u32)> {
        meet.iter().enumerate().flat_map(|(i, higher)| meet[..i].iter().map(move |lower| (lower.1, higher.1)))
    }
    let mut pairs: Vec<(u32, u32)> = members.chunk_by(|a, b| a.0 == b.0).flat_map(each).collect();
    pairs.par_sort_unstable();
    pairs.dedup();
    pairs
}
