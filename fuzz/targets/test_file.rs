#![no_main]

#[path = "../../tests/hostile/solver.rs"]
#[allow(dead_code)]
mod solver;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| solver::test_file(bytes));
