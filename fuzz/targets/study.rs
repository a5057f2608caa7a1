#![no_main]

#[path = "../../tests/hostile/study.rs"]
mod study;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| study::study(bytes));
