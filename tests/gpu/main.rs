//! Tests on a device, beside the processor's.

mod ptx;
mod same_bytes;
