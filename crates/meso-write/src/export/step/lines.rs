//! Numbered entities of a STEP file, one a line (ISO 10303-21).

use meso_collision::math::Vec3;
use std::fmt;
use std::io::{self, Write};

/// The number of an entity, which others refer to it by.
#[derive(Clone, Copy)]
pub(super) struct Id(u64);

impl fmt::Display for Id {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "#{}", self.0)
    }
}

/// Entities as they are written.
pub(super) struct Lines<W> {
    out: W,
    last: u64,
}

impl<W: Write> Lines<W> {
    pub(super) fn new(out: W) -> Self {
        Self { out, last: 0 }
    }

    /// Text that is no entity.
    pub(super) fn text(&mut self, text: &str) -> io::Result<()> {
        self.out.write_all(text.as_bytes())
    }

    pub(super) fn entity(&mut self, of: fmt::Arguments) -> io::Result<Id> {
        self.last += 1;
        writeln!(self.out, "#{}={of};", self.last)?;
        Ok(Id(self.last))
    }

    pub(super) fn point(&mut self, at: &Vec3) -> io::Result<Id> {
        self.entity(format_args!("CARTESIAN_POINT('',{})", Triple(at)))
    }

    pub(super) fn direction(&mut self, along: &Vec3) -> io::Result<Id> {
        self.entity(format_args!("DIRECTION('',{})", Triple(along)))
    }

    pub(super) fn flush(mut self) -> io::Result<()> {
        self.out.flush()
    }
}

struct Triple<'a>(&'a Vec3);

impl fmt::Display for Triple<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "({},{},{})", real(self.0.x), real(self.0.y), real(self.0.z))
    }
}

/// A number with the point that the format wants of reals: the shortest that reads back the same.
pub(super) fn real(x: f64) -> String {
    let text = format!("{x:?}").replace('e', "E");
    match text.split_once('E') {
        Some((digits, exponent)) if !digits.contains('.') => format!("{digits}.E{exponent}"),
        _ => text,
    }
}

pub(super) fn list(ids: &[Id]) -> String {
    format!("({})", ids.iter().map(Id::to_string).collect::<Vec<_>>().join(","))
}

#[cfg(test)]
mod tests {
    use super::real;

    #[test]
    fn reals_have_a_point() {
        let written = [0.0, -1.0, 0.1, 1e-7, 1.5e-9, 1e20].map(real);
        assert_eq!(written, ["0.0", "-1.0", "0.1", "1.E-7", "1.5E-9", "1.E20"]);
    }
}
