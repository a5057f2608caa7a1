//! Tests of meso-collision through its public interface, against independent references.

mod answers;
mod batches;
mod bodies;
mod dented;
mod dice;
mod erosion;
mod exact;
mod families;
mod hull;
mod invariance;
mod isa;
mod offset;
mod oracle;
mod packed;
mod properties;
#[path = "../property.rs"]
mod property;
mod reference;
mod shadow;
mod sieve;
mod slow;
mod solids;
mod witnesses;
