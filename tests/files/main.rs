//! Tests of meso-files through its public interface.

mod lock;
