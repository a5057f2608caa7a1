//! Bytes that a run holds on a device, and that every step moves: counted by a host that keeps sizes only.

use crate::engine::Engine;
use crate::host::{Buffer, Host, Kernel};
use meso_solve::device::Upload;
use std::sync::{Arc, Mutex, PoisonError};

/// Bytes of a run on a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Held in its memory.
    pub held: usize,
    /// Read and written by one step in which no element is damaged: each kernel takes each of its buffers once.
    pub moved: usize,
    /// Read and written by one step in which every element is damaged.
    pub moved_with_damage: usize,
}

/// Counts the bytes of a run for groups of `threads`.
pub(crate) fn count(upload: &Upload, threads: usize) -> Result<Traffic, String> {
    let moved = Arc::new(Mutex::new(Traffic::default()));
    let host = BufferSizes { sizes: Vec::new(), moved: Arc::clone(&moved) };
    let held = Engine::on(Box::new(host), upload, threads)?.bytes;
    let moved = *moved.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(Traffic { held, ..moved })
}

/// A host without a device: sizes of the buffers, and bytes that the kernels move.
struct BufferSizes {
    sizes: Vec<usize>,
    moved: Arc<Mutex<Traffic>>,
}

/// Places of the elements' arguments: nodes of the blocks, memory, displacements, energies of the groups.
const PLACES: usize = 1;
const MEMORY: usize = 4;
const DISPLACEMENT: usize = 11;
const DISSIPATED: usize = 13;
/// Places of displacements and velocities among the nodes' arguments.
const MOTION: [usize; 2] = [7, 8];

impl BufferSizes {
    /// Bytes that a kernel moves beyond those of its buffers.
    fn beyond(name: &str, sizes: &[usize]) -> isize {
        let size = |argument: usize| sizes[argument] as isize;
        match name {
            // Energies are read and written. Every place of a block reads its node: 24 bytes for 4 of its number.
            "elements" => size(DISSIPATED) + 6 * size(PLACES) - size(DISPLACEMENT),
            "nodes" => MOTION.into_iter().map(size).sum(),
            _ => 0,
        }
    }
}

impl Host for BufferSizes {
    fn compile(&mut self, _: &str) -> Result<(), String> {
        Ok(())
    }

    fn buffer(&mut self, bytes: usize) -> Result<Buffer, String> {
        self.sizes.push(bytes);
        Ok(Buffer(self.sizes.len() as u64 - 1))
    }

    fn write(&mut self, _: Buffer, _: usize, _: &[u8]) -> Result<(), String> {
        Ok(())
    }

    fn read(&mut self, _: Buffer, _: usize, _: &mut [u8]) -> Result<(), String> {
        Ok(())
    }

    fn kernel(&mut self, name: &str, arguments: &[Buffer]) -> Result<Kernel, String> {
        let sizes: Vec<usize> = arguments.iter().map(|buffer| self.sizes[buffer.0 as usize]).collect();
        let all = sizes.iter().sum::<usize>().saturating_add_signed(Self::beyond(name, &sizes));
        if name != "begin" {
            let mut moved = self.moved.lock().unwrap_or_else(PoisonError::into_inner);
            moved.moved += all;
            moved.moved_with_damage += all + if name == "elements" { sizes[MEMORY] } else { 0 };
        }
        Ok(Kernel(0))
    }

    fn launch(&mut self, _: Kernel, _: usize, _: usize) -> Result<(), String> {
        Ok(())
    }
}
