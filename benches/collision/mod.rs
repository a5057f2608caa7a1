//! What the collision benches share: bodies, pair sets, peers, a clock, where it ran, and a way to draw.

#![allow(dead_code, unreachable_pub, missing_docs, reason = "each bench uses its part")]

pub mod bodies;
pub mod ccd;
pub mod clock;
pub mod literal;
pub mod machine;
pub mod pairs;
pub mod plot;
pub mod table;

use table::Table;

/// A table each row of which says where and when it was measured.
pub struct Measured {
    table: Table,
    stamp: String,
}

impl Measured {
    pub fn new(header: &str) -> Self {
        Self { table: Table::new(&format!("{header},{}", machine::COLUMNS)), stamp: machine::stamp() }
    }

    pub fn row(&mut self, cells: &[String]) {
        self.table.row(&[cells, std::slice::from_ref(&self.stamp)].concat());
    }

    pub fn save(&self, name: &str) {
        self.table.save(name);
    }
}
