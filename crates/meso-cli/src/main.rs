//! The `mesocrete` command.
fn main() {}
