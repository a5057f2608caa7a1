//! The two kernels, compiled for every instruction set: no other crate compiles an element's loop.

use crate::block::probe::{Element, Point, Probe};
use crate::block::{Block, Common, Pass};
use crate::lanes::InstructionSet;

impl InstructionSet {
    /// Moves a block by one step; returns the energy that its elements spend, mJ.
    pub fn step(self, pass: Pass) -> f64 {
        self.run(pass)
    }

    /// States of the elements of `block`, in its order, at these displacements of all nodes, mm.
    pub fn probe(self, block: &Block, common: &Common, displacement: &[[f64; 3]]) -> Vec<(Element, Point)> {
        self.run(Probe { block, common, displacement })
    }
}
