//! Lines of a deck: data of at most 16 entries a line.

use crate::export::lines::Lines;
use std::io::{self, Write};

/// Entries on a data line that lists set members.
const ENTRIES: usize = 16;

/// A number as a deck can hold it: Abaqus reads at most 20 characters of one, so 13 digits where all of them are longer.
pub(crate) fn real(x: f64) -> String {
    let shortest = format!("{x:?}");
    if shortest.len() <= 20 { shortest } else { format!("{x:.12e}") }
}

impl<W: Write> Lines<W> {
    /// A node: number and coordinates in mm.
    pub(super) fn node(&mut self, number: u64, position: [f64; 3]) -> io::Result<()> {
        self.number(number);
        for x in position {
            self.buffer.extend_from_slice(b", ");
            self.decimal(x);
        }
        self.end()
    }

    /// An element: number and node numbers, counted from the indices.
    pub(super) fn element(&mut self, number: u64, nodes: &[u32]) -> io::Result<()> {
        self.number(number);
        for &node in nodes {
            self.buffer.extend_from_slice(b", ");
            self.number(u64::from(node) + 1);
        }
        self.end()
    }

    /// One member of an element surface: element number and face, S1 to S6.
    pub(super) fn face(&mut self, number: u64, face: usize) -> io::Result<()> {
        self.number(number);
        self.buffer.extend_from_slice(b", S");
        self.number(face as u64 + 1);
        self.end()
    }

    /// Set members, 16 a line.
    pub(super) fn members(&mut self, numbers: impl Iterator<Item = u64>) -> io::Result<()> {
        let mut entries = 0;
        for number in numbers {
            if entries == ENTRIES {
                self.end()?;
                entries = 0;
            }
            if entries > 0 {
                self.buffer.extend_from_slice(b", ");
            }
            self.number(number);
            entries += 1;
        }
        if entries > 0 { self.end() } else { Ok(()) }
    }

    fn number(&mut self, value: u64) {
        self.buffer.extend_from_slice(itoa::Buffer::new().format(value).as_bytes());
    }

    /// A coordinate to 1e-10 mm; Abaqus reads at most 20 characters a number, less than the 24 of a shortest
    /// round-trip f64. Where ten decimals would not do (tiny or huge models), 13 significant digits.
    fn decimal(&mut self, x: f64) {
        let magnitude = x.abs();
        if magnitude != 0.0 && !(1e-2..1e7).contains(&magnitude) {
            let _ = write!(self.buffer, "{x:.12e}");
            return;
        }
        let scaled = (magnitude * 1e10).round() as u64;
        if x < 0.0 && scaled > 0 {
            self.buffer.push(b'-');
        }
        self.number(scaled / 10_000_000_000);
        self.buffer.push(b'.');
        self.decimals(scaled % 10_000_000_000);
    }

    /// Ten decimals without the trailing zeros.
    fn decimals(&mut self, mut fraction: u64) {
        if fraction == 0 {
            return self.buffer.push(b'0');
        }
        let mut digits = [b'0'; 10];
        for digit in digits.iter_mut().rev() {
            *digit = b'0' + (fraction % 10) as u8;
            fraction /= 10;
        }
        let used = digits.iter().rposition(|d| *d != b'0').map_or(1, |last| last + 1);
        self.buffer.extend_from_slice(&digits[..used]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(x: f64) -> String {
        let mut lines = Lines::new(Vec::new());
        lines.decimal(x);
        String::from_utf8(lines.buffer).unwrap()
    }

    #[test]
    fn coordinates_are_short_and_within_half_a_unit_of_the_last_place() {
        for x in [0.0, 150.0, -0.5, 1.0 / 3.0, 149.999_999_999_99, 0.012_345_678_912_345, 9_999_999.123_456_79] {
            let text = coordinate(x);
            assert!(text.len() <= 20, "{text}");
            assert!((text.parse::<f64>().unwrap() - x).abs() <= 6e-11, "{text}");
        }
    }

    #[test]
    fn tiny_and_huge_coordinates_keep_thirteen_digits() {
        for x in [-1.234_567_890_123_4e-100, 9.876_543_210_123_4e99, 1e-3, 3e7] {
            let text = coordinate(x);
            assert!(text.len() <= 20, "{text}");
            assert!((text.parse::<f64>().unwrap() / x - 1.0).abs() <= 1e-12, "{text}");
        }
    }

    #[test]
    fn numbers_have_at_most_twenty_characters() {
        assert_eq!(
            [0.1, 26_000.0, 2.2e-9, 0.03 * 2.2e-9].map(real),
            ["0.1", "26000.0", "2.2e-9", "6.600000000000e-11"]
        );
        for x in [f64::MIN_POSITIVE, -f64::MAX, 1.0 / 3.0, -1e-300 / 7.0] {
            assert!(real(x).len() <= 20 && (real(x).parse::<f64>().unwrap() / x - 1.0).abs() < 1e-12, "{}", real(x));
        }
    }

    #[test]
    fn set_members_stand_sixteen_to_a_line() {
        let mut lines = Lines::new(Vec::new());
        lines.members(1..=17).unwrap();
        let text = String::from_utf8(lines.buffer).unwrap();
        assert_eq!(text, "1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16\n17\n");
    }
}
