//! Lines of fixed columns, as LS-DYNA and ANSYS read them.

use super::lines::Lines;
use meso_mesh::cells::{Mesh, Phase};
use std::io::Write;

/// Number of the first part of a specimen's own phases; supports and plates have lower ones.
const OWN: u64 = 101;

/// Number of a phase's part, section and material.
pub(super) fn part(phase: Phase) -> u64 {
    if let Phase::Own(own) = phase {
        return OWN + u64::from(own);
    }
    Phase::SOLID.into_iter().zip(1..).find(|(solid, _)| *solid == phase).map_or(0, |(_, part)| part)
}

/// Places of an element's nodes on a card; a wedge of 6 repeats the third node of either face.
pub(super) fn places(nodes: usize) -> &'static [usize] {
    if nodes == 6 { &[0, 1, 2, 2, 3, 4, 5, 5] } else { &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9][..nodes] }
}

/// Phases that a mesh has, cohesive elements as ITZ.
pub(super) fn present(mesh: &Mesh) -> impl Iterator<Item = Phase> {
    let has = |phase: &Phase| mesh.phase.contains(phase) || *phase == Phase::Itz && !mesh.cohesive.is_empty();
    mesh.phases.solid().filter(has)
}

impl<W: Write> Lines<W> {
    /// An integer at the right of so many columns; a longer one gets what it needs.
    pub(super) fn integer(&mut self, width: usize, value: u64) {
        self.text(width, itoa::Buffer::new().format(value));
    }

    /// A number of at most so many columns, in full where it fits, with at least one space before it.
    pub(super) fn real(&mut self, width: usize, value: f64) {
        self.text(width, &real(value, width - 1));
    }

    /// Text at the right of so many columns.
    pub(super) fn text(&mut self, width: usize, text: &str) {
        self.buffer.resize(self.buffer.len() + width.saturating_sub(text.len()), b' ');
        self.buffer.extend_from_slice(text.as_bytes());
    }

    /// A coordinate in 16 columns, with as many decimals as fit: to 1e-12 mm below 1000 mm.
    pub(super) fn coordinate(&mut self, x: f64) {
        let magnitude = x.abs();
        if (x < 0.0 && magnitude >= 100.0) || magnitude >= 1000.0 {
            return self.text(16, &real(x, 16));
        }
        let scaled = (magnitude * 1e12).round() as u64;
        let (whole, decimals) = (scaled / 1_000_000_000_000, scaled % 1_000_000_000_000);
        let mut digits = [b' '; 16];
        let mut rest = decimals;
        for digit in digits[4..].iter_mut().rev() {
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
        }
        digits[3] = b'.';
        let (mut at, mut rest) = (2, whole);
        digits[at] = b'0' + (rest % 10) as u8;
        rest /= 10;
        while rest > 0 {
            at -= 1;
            digits[at] = b'0' + (rest % 10) as u8;
            rest /= 10;
        }
        if x < 0.0 && scaled > 0 {
            digits[at - 1] = b'-';
        }
        self.buffer.extend_from_slice(&digits);
    }
}

/// A number in at most `width` characters: the shortest form that is exact, else the most exact one that fits.
pub(super) fn real(value: f64, width: usize) -> String {
    let shortest = format!("{value:?}");
    if shortest.len() <= width {
        return shortest;
    }
    let plain = (0..width).rev().map(|decimals| format!("{value:.decimals$}"));
    let scientific = (0..width).rev().map(|decimals| format!("{value:.decimals$e}"));
    let first = |mut forms: Box<dyn Iterator<Item = String> + '_>| forms.find(|form| form.len() <= width);
    let off = |form: &String| form.parse::<f64>().map_or(f64::INFINITY, |read| (read - value).abs());
    let forms = [first(Box::new(plain)), first(Box::new(scientific))];
    let best = forms.into_iter().flatten().filter(|form| form.contains(['.', 'e']));
    best.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(shortest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_fill_sixteen_columns_and_are_exact_to_1e_12() {
        for x in [
            0.0,
            150.0,
            -0.5,
            1.0 / 3.0,
            149.999_999_999_999_9,
            -99.123_456_789_012_3,
            999.9,
            -1e-14,
            12_345.678_901_234,
        ] {
            let mut columns = Lines::new(Vec::new());
            columns.coordinate(x);
            let text = String::from_utf8(columns.buffer).unwrap();
            assert_eq!(text.len(), 16, "{text}");
            assert!(
                (text.trim().parse::<f64>().unwrap() - x).abs() <= 5.1e-13 * (x.abs() / 500.0).max(1.0),
                "{text} {x}"
            );
        }
    }

    #[test]
    fn numbers_keep_what_their_columns_hold() {
        assert_eq!([70_000.0, 2.7e-9, 0.2].map(|x| real(x, 9)), ["70000.0", "2.7e-9", "0.2"]);
        for x in [1.0 / 3.0, 123_456.789, 2.0 / 3.0 * 1e-7, -1e5 / 7.0, 1e12 / 3.0] {
            let text = real(x, 9);
            assert!(text.len() <= 9 && (text.parse::<f64>().unwrap() / x - 1.0).abs() < 2e-4, "{text}");
        }
    }
}
