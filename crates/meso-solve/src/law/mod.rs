//! Material laws: strain in, stress out, for one number or for a register of numbers at a time.
