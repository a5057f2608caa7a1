#![no_main]

#[path = "../../tests/hostile/command_line.rs"]
mod command_line;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| command_line::command_line(bytes));
