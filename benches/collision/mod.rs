//! What the collision benches share: bodies, pair sets, peers, a clock, where it ran, and a way to draw.

#![allow(dead_code, unreachable_pub, missing_docs, reason = "each bench uses its part")]

pub mod bodies;
pub mod ccd;
pub mod clock;
pub mod contestants;
pub mod literal;
pub mod machine;
pub mod pairs;
pub mod plot;
pub mod table;

use meso_collision::simd::isa;
use table::Table;

/// A table whose rows name the instruction set, too.
pub struct Measured(Table);

impl Measured {
    pub fn new(header: &str) -> Self {
        Self(Table::new(&format!("{header},isa")))
    }

    pub fn row(&mut self, cells: &[String]) {
        self.0.row(&[cells, &[isa().name().to_owned()]].concat());
    }

    pub fn save(&self, name: &str) {
        self.0.save(name);
    }
}
