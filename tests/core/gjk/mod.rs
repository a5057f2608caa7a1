//! The collision tests against independent references.

mod answers;
mod bodies;
mod families;
mod reference;
