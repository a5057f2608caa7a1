//! Tests of meso-core through its public interface, one module per subject.

mod mesh;
mod spec;
