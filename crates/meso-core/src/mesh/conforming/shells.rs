//! What gmsh is given: triangles on shared nodes, the shells they make, and the volumes between those.

use super::facets::Triangles;
use crate::math::Vec3;

/// Surfaces and the volumes between them; all indices count from 0.
#[derive(Default)]
pub(super) struct Shells {
    pub(super) points: Vec<Vec3>,
    /// Triangles by surface; surfaces share the nodes of their rims.
    pub(super) surfaces: Vec<Vec<[u32; 3]>>,
    /// Closed shells by their surfaces.
    pub(super) loops: Vec<Vec<u32>>,
    pub(super) volumes: Vec<Filled>,
}

/// A volume that gmsh fills.
pub(super) struct Filled {
    /// The outer shell first, then those of holes.
    pub(super) loops: Vec<u32>,
    /// Where gmsh is to put a node.
    pub(super) centre: Option<Vec3>,
    /// Index of the aggregate; `None` in the mortar.
    pub(super) grain: Option<u32>,
}

impl Shells {
    /// Adds a closed surface with nodes of its own; its shell.
    pub(super) fn closed(&mut self, surface: &Triangles) -> u32 {
        let first = self.points.len() as u32;
        self.points.extend(&surface.points);
        let triangles = surface.triangles.iter().map(|triangle| triangle.map(|node| first + node)).collect();
        let surface = self.surface(triangles);
        self.shell(vec![surface])
    }

    /// Adds a surface; its index.
    pub(super) fn surface(&mut self, triangles: Vec<[u32; 3]>) -> u32 {
        self.surfaces.push(triangles);
        self.surfaces.len() as u32 - 1
    }

    /// Adds a shell of `surfaces`; its index.
    pub(super) fn shell(&mut self, surfaces: Vec<u32>) -> u32 {
        self.loops.push(surfaces);
        self.loops.len() as u32 - 1
    }

    /// The nodes that each surface is the first to have, ascending.
    pub(super) fn own_nodes(&self) -> Vec<Vec<u32>> {
        let mut owner = vec![None; self.points.len()];
        for (surface, triangles) in self.surfaces.iter().enumerate() {
            triangles.as_flattened().iter().for_each(|&node| {
                owner[node as usize].get_or_insert(surface);
            });
        }
        let mut own = vec![Vec::new(); self.surfaces.len()];
        // What is cut off a void has no surface at the box's faces, and its nodes there have none.
        (0..)
            .zip(owner)
            .filter_map(|(node, owner)| Some((node, owner?)))
            .for_each(|(node, owner)| own[owner].push(node));
        own
    }
}
