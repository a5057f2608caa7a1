//! What the collision benches share: bodies, pair sets, peers, a clock, and a way to draw.

#![allow(dead_code, unreachable_pub, missing_docs, reason = "each bench uses its part")]

pub mod bodies;
pub mod ccd;
pub mod clock;
pub mod literal;
pub mod pairs;
pub mod plot;
pub mod table;
