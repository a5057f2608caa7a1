//! Tests on a device, beside the processor's.

mod same_bytes;
