//! Python bindings of mesocrete.
