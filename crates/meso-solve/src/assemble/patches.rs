//! Strain smoothing: strains belong to edges of the mesh instead of its tetrahedra.
//!
//! Edge-based smoothed finite elements (Liu, Nguyen-Thoi and Lam 2009, J. Sound Vib. 320, 1100; in three dimensions Cazes
//! and Meschke 2013, Int. J. Numer. Meth. Engng 94): the tetrahedra around an edge are its *patch*, each divides itself
//! between the patches that have it, and a patch's strain is the mean of theirs by volume. Linear tetrahedra that flow
//! between stiff grains are too strong, and patches much less so. There, every edge has a patch; here edges are left
//! out while each tetrahedron has two, which costs a third of the time and relieves more (docs/measured/engine-results.md).

use crate::assemble::tet::{Shape, corners};
use meso_collision::math::{Mat3, Vec3};
use meso_mesh::{Mesh, Phase};
use rayon::prelude::*;

/// Patches that a tetrahedron has, at least. The displacement for which patches are softest meets 1/25 of the
/// stiffness of irregular tetrahedra; with one it would be 1/246, with three 1/6, with a patch for every edge 1/4.
const LEAST: u8 = 2;
/// Width of a crack band of patches over that of their tetrahedra, in a lattice and in a conforming mesh: weak bands of
/// one, three and six elements then spend 0.90 to 1.09 of their energy, at 1.5, 2 and 3 mm.
const LATTICE_BAND: f64 = 1.52;
const CONFORMING_BAND: f64 = 1.45;
/// Nodes of a patch, at most.
pub(crate) const MOST_NODES: usize = 12;
/// Tetrahedra of a patch, at most, where all of those around the edge are in it: neighbours, which share nodes.
const MOST_CELLS: usize = 9;
/// Tetrahedra of each part, where there are more: they need not be neighbours.
const MOST_APART: usize = 5;
/// Nodes of the cells around an edge, at most, neighbours or not.
const ROOM: usize = 2 + 2 * MOST_CELLS;
/// Nodes whose edges go together.
const RUN: usize = 4096;
/// Bits for the place of a cell among those around a node.
const PLACE_BITS: u32 = 24;

/// The patches of a mesh. An edge at which phases of different stiffness meet has one patch per phase.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patches {
    lists: Lists,
    /// The phase whose law each patch has.
    pub(crate) phase: Vec<Phase>,
    /// Patches that have each cell.
    count: Vec<u8>,
}

/// Lists of cells.
#[derive(Clone, Debug, Default)]
struct Lists {
    /// Where each list begins in `cells`, and the end of the last.
    first: Vec<u32>,
    cells: Vec<u32>,
}

/// The shape of a patch.
#[derive(Clone, Debug, Default)]
pub(crate) struct Patch {
    count: usize,
    nodes: [u32; ROOM],
    gradients: [Vec3; ROOM],
    shares: [f64; ROOM],
    /// mm3.
    pub(crate) volume: f64,
    /// Mean volume of its whole cells, mm3.
    pub(crate) cell_mm3: f64,
}

/// A mesh, the phases of its cells in the test, and the engine's numbers of its nodes.
#[derive(Clone, Copy)]
pub(crate) struct Numbered<'a> {
    pub(crate) mesh: &'a Mesh,
    pub(crate) phases: &'a [Phase],
    /// The engine's number of every node.
    pub(crate) number: &'a [u32],
}

/// Width of a crack band of patches over that of their tetrahedra.
pub(crate) fn band(mesh: &Mesh) -> f64 {
    if mesh.notes.conforming { CONFORMING_BAND } else { LATTICE_BAND }
}

impl Patches {
    /// Makes the patches around edges from `nodes`, in their order, to nodes of higher numbers. Where they may be `mixed`, patches have
    /// cells of mortar and ITZ: those that the ITZ fills most have its law, as many as make up its volume.
    pub(crate) fn of(numbered: Numbered, nodes: &[u32], mixed: bool) -> Self {
        let Numbered { mesh, phases, .. } = numbered;
        let mut lists = Lists::of_edges(numbered, nodes, mixed);
        let count = lists.thin(mesh.cell_count());
        let phase = (0..lists.len()).map(|list| phases[lists.cells(list)[0] as usize]).collect();
        let mut patches = Self { lists, phase, count };
        if mixed {
            patches.divide(mesh, phases);
        }
        patches
    }

    /// Gives mixed patches their law.
    fn divide(&mut self, mesh: &Mesh, phases: &[Phase]) {
        let content = |patch: &u32| {
            let volume = |of: Phase| -> f64 {
                let own = self.cells(*patch).iter().filter(|&&cell| phases[cell as usize] == of);
                own.map(|&cell| self.part(cell) * Shape::of(&corners(mesh, cell)).volume).sum()
            };
            (*patch, volume(Phase::Mortar), volume(Phase::Itz))
        };
        let is_mixed = |patch: &u32| matches!(self.phase[*patch as usize], Phase::Mortar | Phase::Itz);
        let patches = (0..self.len() as u32).into_par_iter().filter(is_mixed);
        let contents: Vec<(u32, f64, f64)> = patches.map(|patch| content(&patch)).collect();
        let mut left: f64 = contents.iter().map(|(.., itz)| itz).sum();
        let filled = |(patch, mortar, itz): (u32, f64, f64)| (itz / (mortar + itz), patch, mortar + itz);
        let mut filled: Vec<(f64, u32, f64)> = contents.into_iter().map(filled).collect();
        // Stable: patches that are filled alike stay in their order.
        filled.par_sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, patch, whole) in filled {
            // The last one goes to the phase that it leaves nearer to its volume.
            self.phase[patch as usize] = if 2.0 * left > whole { Phase::Itz } else { Phase::Mortar };
            left -= whole;
        }
    }

    /// Number of patches.
    pub(crate) fn len(&self) -> usize {
        self.phase.len()
    }

    /// Cells of a patch.
    pub(crate) fn cells(&self, patch: u32) -> &[u32] {
        self.lists.cells(patch as usize)
    }

    /// Share of `cell` that each of its patches takes.
    pub(crate) fn part(&self, cell: u32) -> f64 {
        1.0 / f64::from(self.count[cell as usize])
    }

    /// Bytes that they hold.
    pub(crate) fn bytes(&self) -> usize {
        let lists = size_of_val(&*self.lists.first) + size_of_val(&*self.lists.cells);
        lists + size_of_val(&*self.phase) + size_of_val(&*self.count)
    }

    /// The shape of a patch.
    pub(crate) fn patch(&self, mesh: &Mesh, patch: u32) -> Patch {
        let (cells, mut found) = (self.cells(patch), Patch::default());
        cells
            .iter()
            .for_each(|&cell| found.add(mesh.cell(cell as usize), &Shape::of(&corners(mesh, cell)), self.part(cell)));
        found.gradients[..found.count].iter_mut().for_each(|gradient| *gradient /= found.volume);
        found.shares[..found.count].iter_mut().for_each(|share| *share /= found.volume);
        found.cell_mm3 /= cells.len() as f64;
        found
    }
}

impl Lists {
    /// The cells around every node.
    fn around_nodes(mesh: &Mesh) -> Self {
        let mut first = vec![0_u32; mesh.points.len() + 1];
        mesh.cells.iter().for_each(|&node| first[node as usize + 1] += 1);
        (1..first.len()).for_each(|node| first[node] += first[node - 1]);
        let mut next = first.clone();
        let mut cells = vec![0; mesh.cells.len()];
        for (cell, nodes) in (0..).zip(mesh.cells()) {
            for &node in nodes {
                let next = &mut next[node as usize];
                cells[*next as usize] = cell;
                *next += 1;
            }
        }
        Self { first, cells }
    }

    /// The cells around every edge.
    fn of_edges(numbered: Numbered, nodes: &[u32], mixed: bool) -> Self {
        let around = Self::around_nodes(numbered.mesh);
        let of_run = |run: &[u32]| {
            let (mut own, mut edges) = (Self::default(), Vec::new());
            run.iter().for_each(|&node| own.add_edges(numbered, node, around.cells(node as usize), mixed, &mut edges));
            own
        };
        Self::joined(nodes.par_chunks(RUN).map(of_run).collect())
    }

    /// Some lists after each other.
    fn joined(runs: Vec<Self>) -> Self {
        let room = |of: fn(&Self) -> usize| runs.iter().map(of).sum::<usize>() + 1;
        let mut all = Self {
            first: Vec::with_capacity(room(|run| run.first.len())),
            cells: Vec::with_capacity(room(|run| run.cells.len())),
        };
        for run in runs {
            let start = all.cells.len() as u32;
            all.first.extend(run.first.iter().map(|first| start + first));
            all.cells.extend(run.cells);
        }
        all.first.push(all.cells.len() as u32);
        all
    }

    /// Adds the cells around every edge from `node`, which the cells `around` have, ascending; the end is still missing.
    /// `edges` is memory for the node's edges: the other end, the class, and the place in `around`, as one number.
    fn add_edges(&mut self, numbered: Numbered, node: u32, around: &[u32], mixed: bool, edges: &mut Vec<u64>) {
        let Numbered { mesh, phases, number } = numbered;
        let own = number[node as usize];
        edges.clear();
        for (place, &cell) in (0..).zip(around) {
            let phase = phases[cell as usize];
            let class = if mixed && phase == Phase::Itz { Phase::Mortar } else { phase }.index() as u64;
            let others = mesh.cell(cell as usize).iter().map(|&other| number[other as usize]);
            let edge = |other: u32| u64::from(other) << 32 | class << PLACE_BITS | place;
            edges.extend(others.filter(|&other| other > own).map(edge));
        }
        edges.sort_unstable();
        for edge in edges.chunk_by(|a, b| a >> PLACE_BITS == b >> PLACE_BITS) {
            let cells = edge.iter().map(|edge| around[(edge & ((1 << PLACE_BITS) - 1)) as usize]);
            let is_whole = edge.len() <= MOST_APART || edge.len() <= MOST_CELLS && has_room(mesh, cells);
            let most = if is_whole { MOST_CELLS } else { MOST_APART };
            for part in edge.chunks(most) {
                self.first.push(self.cells.len() as u32);
                self.cells.extend(part.iter().map(|edge| around[(edge & ((1 << PLACE_BITS) - 1)) as usize]));
            }
        }
    }

    /// Leaves out lists while every cell is in [`LEAST`] others, the shortest first; how many have each of the `cells`.
    fn thin(&mut self, cells: usize) -> Vec<u8> {
        let mut count = vec![0; cells];
        self.cells.iter().for_each(|&cell| count[cell as usize] += 1);
        let mut by_length = vec![Vec::new(); MOST_CELLS + 1];
        (0..self.len()).for_each(|list| by_length[self.cells(list).len()].push(list as u32));
        let mut stays = vec![true; self.len()];
        for list in by_length.into_iter().flatten() {
            let own = self.cells(list as usize);
            if own.iter().all(|&cell| count[cell as usize] > LEAST) {
                own.iter().for_each(|&cell| count[cell as usize] -= 1);
                stays[list as usize] = false;
            }
        }
        self.retain(&stays);
        count
    }

    /// Keeps the lists that stay.
    fn retain(&mut self, stays: &[bool]) {
        let (mut lists, mut end) = (0, 0);
        for list in (0..stays.len()).filter(|&list| stays[list]) {
            let own = self.first[list] as usize..self.first[list + 1] as usize;
            self.first[lists] = end as u32;
            (lists, end) = (lists + 1, end + own.len());
            self.cells.copy_within(own.clone(), end - own.len());
        }
        self.first[lists] = end as u32;
        self.first.truncate(lists + 1);
        self.cells.truncate(end);
        self.first.shrink_to_fit();
        self.cells.shrink_to_fit();
    }

    fn len(&self) -> usize {
        self.first.len() - 1
    }

    fn cells(&self, list: usize) -> &[u32] {
        &self.cells[self.first[list] as usize..self.first[list + 1] as usize]
    }
}

/// Whether the nodes of [`MOST_CELLS`] cells at most fit into a patch: those in two fans around their edge have more.
fn has_room(mesh: &Mesh, cells: impl Iterator<Item = u32>) -> bool {
    let (mut nodes, mut count) = ([0; 4 * MOST_CELLS], 0);
    for &node in cells.flat_map(|cell| mesh.cell(cell as usize)) {
        if !nodes[..count].contains(&node) {
            (nodes[count], count) = (node, count + 1);
        }
    }
    count <= MOST_NODES
}

impl Patch {
    /// The mesh's numbers of its nodes.
    pub(crate) fn nodes(&self) -> &[u32] {
        &self.nodes[..self.count]
    }

    /// Mean gradient of each node's shape function, 1/mm; they add up to zero.
    pub(crate) fn gradients(&self) -> &[Vec3] {
        &self.gradients[..self.count]
    }

    /// Share of each node in the mass.
    pub(crate) fn shares(&self) -> &[f64] {
        &self.shares[..self.count]
    }

    /// Adds a `part` of a cell; gradients and shares are still times the volume, and the cells' mean is still a sum.
    fn add(&mut self, nodes: &[u32], shape: &Shape, part: f64) {
        let volume = part * shape.volume;
        self.volume += volume;
        self.cell_mm3 += shape.volume;
        for (&node, gradient) in nodes.iter().zip(shape.all_gradients()) {
            let place = self.nodes().iter().position(|&other| other == node).unwrap_or(self.count);
            self.nodes[place] = node;
            self.count = self.count.max(place + 1);
            self.gradients[place] += volume * gradient;
            self.shares[place] += volume / nodes.len() as f64;
        }
    }

    /// sum g_a g_a^T over the nodes' shares in the mass, 1/mm2.
    pub(crate) fn metric(&self) -> Mat3 {
        self.gradients().iter().zip(self.shares()).map(|(g, share)| g * g.transpose() / *share).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dice::dice;
    use meso_concrete::specimen::Specimen;
    use meso_mesh::{self as mesh, ItzForm, MeshOptions, Method, Tools};

    /// A cuboid of mortar in irregular tetrahedra, and phases of its cells: an ITZ in every fifth, an aggregate at one end.
    fn sample() -> (Mesh, Vec<Phase>) {
        let options =
            MeshOptions { method: Method::FITTED, element_size_mm: 2.0, itz: ItzForm::None, ..MeshOptions::default() };
        let mut mesh = mesh::build((&[], &Specimen::cuboid([8.0, 9.0, 10.0])), &options, &Tools::default()).unwrap();
        let mut state = 7_u64;
        mesh.points.iter_mut().for_each(|point| *point += Vec3::from_fn(|_, _| 0.25 * dice(&mut state)));
        let phase = |cell: u32| {
            let is_far = corners(&mesh, cell).iter().all(|corner| corner.z > 6.0);
            if is_far { Phase::Aggregate } else { [Phase::Mortar, Phase::Itz][usize::from(cell.is_multiple_of(5))] }
        };
        let phases = (0..mesh.cell_count() as u32).map(phase).collect();
        (mesh, phases)
    }

    fn patches(mesh: &Mesh, phases: &[Phase], mixed: bool) -> Patches {
        let nodes: Vec<u32> = (0..mesh.points.len() as u32).collect();
        Patches::of(Numbered { mesh, phases, number: &nodes }, &nodes, mixed)
    }

    fn volume(mesh: &Mesh, cell: u32) -> f64 {
        Shape::of(&corners(mesh, cell)).volume
    }

    #[test]
    fn patches_share_out_every_cell_and_keep_the_volume_of_every_phase() {
        let (mesh, phases) = sample();
        for mixed in [false, true] {
            let patches = patches(&mesh, &phases, mixed);
            let mut count = vec![0_u8; mesh.cell_count()];
            let mut apart = [0.0; 5];
            let mut largest = 0.0_f64;
            for number in 0..patches.len() as u32 {
                let (phase, patch) = (patches.phase[number as usize], patches.patch(&mesh, number));
                patches.cells(number).iter().for_each(|&cell| count[cell as usize] += 1);
                apart[phase.index()] += patch.volume;
                largest = largest.max(patch.volume);
                let sum: Vec3 = patch.gradients().iter().sum();
                assert!(sum.norm() < 1e-12 && (patch.shares().iter().sum::<f64>() - 1.0).abs() < 1e-12);
                assert!(patch.nodes().len() <= MOST_NODES);
                let soft = |phase: Phase| mixed && matches!(phase, Phase::Mortar | Phase::Itz);
                let fits = |&cell: &u32| phases[cell as usize] == phase || soft(phases[cell as usize]) && soft(phase);
                assert!(patches.cells(number).iter().all(fits), "{number}");
            }
            assert!(count == patches.count && count.iter().all(|&count| count >= LEAST));
            (0..).zip(&phases).for_each(|(cell, &phase)| apart[phase.index()] -= volume(&mesh, cell));
            assert!(apart.iter().all(|apart| apart.abs() < if mixed { largest } else { 1e-9 }), "{apart:?}");
        }
    }

    /// The case: nine cells in two fans around an edge have 13 nodes, and no element took their patch.
    #[test]
    fn cells_in_two_fans_around_an_edge_are_patches_of_twelve_nodes_at_most() {
        let ring = |i: u32| std::f64::consts::TAU * f64::from(i) / 11.0;
        let points = (0..11).map(|i| Vec3::new(ring(i).cos(), ring(i).sin(), 0.5));
        let points: Vec<Vec3> = points.chain([Vec3::zeros(), Vec3::new(0.0, 0.0, 1.0)]).collect();
        let (mut mesh, _) = sample();
        mesh.points = points;
        mesh.cells = (0..11).flat_map(|i| [11, 12, i, (i + 1) % 11]).collect();
        let stone = |i: u32| if i == 4 || i == 10 { Phase::Aggregate } else { Phase::Mortar };
        mesh.phase = (0..11).map(stone).collect();
        mesh.owner = vec![0; 11];
        let patches = patches(&mesh, &mesh.phase, true);
        let nodes: Vec<usize> = (0..patches.len() as u32).map(|n| patches.patch(&mesh, n).nodes().len()).collect();
        assert!(nodes.iter().all(|&count| count <= MOST_NODES), "{nodes:?}");
    }

    /// Nodes, gradients and volume of elements.
    type Elements = Vec<(Vec<u32>, Vec<Vec3>, f64)>;

    /// Forces of elastic elements, E = 1 and nu = 0.2, at the displacements `u`.
    fn forces(elements: &Elements, u: &[Vec3]) -> Vec<Vec3> {
        let mut forces = vec![Vec3::zeros(); u.len()];
        for (nodes, gradients, volume) in elements {
            let pairs = || nodes.iter().map(|&node| node as usize).zip(gradients);
            let h: Mat3 = pairs().map(|(node, g)| u[node] * g.transpose()).sum();
            let stress = Mat3::identity() * (h.trace() / 3.6) + (h + h.transpose()) / 2.4;
            pairs().for_each(|(node, g)| forces[node] += *volume * stress * g);
        }
        forces
    }

    fn dot(a: &[Vec3], b: &[Vec3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
    }

    /// Displacements at which the elements bear some `loads` in balance, by conjugate gradients.
    fn settled(elements: &Elements, loads: &[Vec3]) -> Vec<Vec3> {
        let mut u = vec![Vec3::zeros(); loads.len()];
        let (mut rest, mut way) = (loads.to_vec(), loads.to_vec());
        let aim = 1e-12 * dot(loads, loads);
        while dot(&rest, &rest) > aim {
            let (force, before) = (forces(elements, &way), dot(&rest, &rest));
            let step = before / dot(&way, &force);
            u.iter_mut().zip(&way).for_each(|(u, way)| *u += step * way);
            rest.iter_mut().zip(&force).for_each(|(rest, force)| *rest -= step * force);
            let more = dot(&rest, &rest) / before;
            way.iter_mut().zip(&rest).for_each(|(way, rest)| *way = *rest + more * *way);
        }
        u
    }

    #[test]
    fn no_displacement_meets_less_than_a_sixtieth_of_what_the_tetrahedra_would_oppose() {
        let (mesh, _) = sample();
        let phases = vec![Phase::Mortar; mesh.cell_count()];
        let patches = patches(&mesh, &phases, true);
        let smoothed: Elements = (0..patches.len() as u32)
            .map(|number| patches.patch(&mesh, number))
            .map(|patch| (patch.nodes().to_vec(), patch.gradients().to_vec(), patch.volume))
            .collect();
        let plain: Elements = (0..mesh.cell_count() as u32)
            .map(|cell| (cell, Shape::of(&corners(&mesh, cell))))
            .map(|(cell, shape)| (mesh.cell(cell as usize).to_vec(), shape.all_gradients().to_vec(), shape.volume))
            .collect();
        // Power iteration: the displacement for which the patches are softest beside the tetrahedra.
        let mut u: Vec<Vec3> =
            mesh.points.iter().map(|x| Vec3::new((3.0 * x.y).sin(), (5.0 * x.z).sin(), (4.0 * x.x).sin())).collect();
        let mut softer = 0.0;
        for _ in 0..60 {
            let loads = forces(&plain, &u);
            u = settled(&smoothed, &loads);
            softer = dot(&u, &forces(&plain, &u)) / dot(&u, &loads);
            let size = dot(&u, &u).sqrt();
            u.iter_mut().for_each(|u| *u /= size);
        }
        assert!((1.0..60.0).contains(&softer), "{softer}");
    }
}
