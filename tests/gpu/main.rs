//! Tests on a device, beside the processor's.

#![allow(clippy::print_stderr, reason = "a test that skips says so")]

mod ptx;
mod same_bytes;
