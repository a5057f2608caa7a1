//! The shells of bodies as layers below the solid ITZ, from outside.
//!
//! A finished layer counts as mortar while those below it are made: so a body is what is left within, and no node of the layer
//! moves any more. Making a layer appends cells, and takes back none but its own.

use super::improve::improve;
use super::prisms::Layer;
use crate::cells::{NO_BODY, Phase};
use crate::tet::TetMesh;
use meso_collision::geometry::OffsetError;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::parallel;

/// The layers that are finished, from outside: the first cell of each, and the owners of its cells.
#[derive(Default)]
pub(crate) struct FinishedLayer(Vec<(usize, Vec<u32>)>);

impl FinishedLayer {
    /// Counts the cells from `first` on, the next layer, as mortar.
    pub(crate) fn set_aside(&mut self, mesh: &mut TetMesh, phase: &mut [Phase], first: usize) {
        self.0.push((first, mesh.owner[first..].to_vec()));
        mesh.owner[first..].fill(NO_BODY);
        phase[first..].fill(Phase::Mortar);
    }

    /// Gives all layers back to `bodies`, in their own phases.
    pub(crate) fn give_back(self, mesh: &mut TetMesh, phase: &mut [Phase], bodies: &[Aggregate]) {
        for (number, (first, owners)) in self.0.into_iter().enumerate() {
            for (cell, owner) in (first..).zip(owners) {
                let shell = number.checked_sub(1).and_then(|shell| bodies[owner as usize].shells.get(shell));
                phase[cell] = shell.map_or(Phase::Itz, |shell| Phase::Own(shell.own));
                mesh.owner[cell] = owner;
            }
        }
    }
}

/// Moves nodes of all layers of a lattice with elements of about `size` mm where angles are still below 2 degrees: while one layer
/// was made, those above it could not move (1.4 million cells with shells of 1 mm: 109 such angles before, none afterwards).
pub(crate) fn smooth(mesh: &mut TetMesh, phase: &mut Vec<Phase>, periodic: [bool; 3], bodies: &[Aggregate], size: f64) {
    let caps = bodies.iter().map(|body| body.body.caps()).collect();
    let no_rails = Layer { thinned_aggregates: 0, pinched_nodes: 0, rails: Vec::new(), caps };
    improve(mesh, phase, periodic, &no_rails, None, size);
}

/// Volume of all layers of a number, mm3; `None` where one has no trustworthy volume.
pub(crate) fn exact_mm3(bodies: &[Aggregate], number: usize) -> Option<f64> {
    let volume = |body: usize| {
        let [begin, end] = bodies[body].layer_between(number).map(|depth| bodies[body].core_volume(depth));
        Ok::<_, OffsetError>(begin? - end?)
    };
    // Summed in the bodies' order: the same on any number of threads.
    parallel::try_map(bodies.len(), volume).ok().map(|volumes: Vec<f64>| volumes.iter().sum())
}
