//! Arrays of numpy (`.npy`, format 1.0): a short header, then the values as they come.

use super::{Frame, ValueKind, Voxels};
use std::io::{self, Write};

/// The header's length is a multiple of this, so that values are aligned when a file is mapped into memory.
const ALIGNED: usize = 64;

/// Writes an image to `out`, slab by slab.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(frame: &Frame, mut slabs: impl Iterator<Item = Voxels>, mut out: impl Write) -> io::Result<()> {
    let kind = match frame.kind {
        ValueKind::Label => "|u1",
        ValueKind::Id => "<i4",
        ValueKind::Real => "<f4",
    };
    let shape: Vec<String> = frame.shape().iter().map(usize::to_string).collect();
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}", shape.join(", "));
    // Ten bytes stand before the header, a line break at its end.
    let length = (10 + header.len() + 1).next_multiple_of(ALIGNED) - 10;
    header += &" ".repeat(length - header.len() - 1);
    out.write_all(b"\x93NUMPY\x01\x00")?;
    out.write_all(&(length as u16).to_le_bytes())?;
    writeln!(out, "{header}")?;
    slabs.try_for_each(|slab| out.write_all(&slab.bytes()))
}
