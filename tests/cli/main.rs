//! Tests of the `mesocrete` command, run as a user runs it.
