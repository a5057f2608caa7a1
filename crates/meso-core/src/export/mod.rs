//! Writers, one file per format; each takes `impl io::Write` and knows nothing of packing.
