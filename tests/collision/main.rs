//! The collision tests against independent references.

mod answers;
mod batches;
mod bodies;
mod families;
mod invariance;
mod oracle;
mod packed;
mod properties;
#[path = "../property.rs"]
mod property;
mod reference;
mod slow;
mod witnesses;
