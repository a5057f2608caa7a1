//! The two kernels, compiled for every instruction set: no other crate compiles an element's loop.

use crate::block::Pass;
use crate::block::probe::{Element, Point, Probe};
use crate::lanes::InstructionSet;

impl InstructionSet {
    /// Moves a block by one step; returns the energy that its elements spend, mJ.
    pub fn step(self, pass: Pass) -> f64 {
        self.run(pass)
    }

    /// States of a block's elements, in its order.
    pub fn probe(self, probe: Probe) -> Vec<(Element, Point)> {
        self.run(probe)
    }
}
