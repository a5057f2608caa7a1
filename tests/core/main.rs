//! Tests of meso-core through its public interface, one module per subject.

mod exact;
mod hull;
mod mesh;
mod spec;
