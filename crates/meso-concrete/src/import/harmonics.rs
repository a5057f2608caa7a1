//! Stones as spherical harmonics, in the files of NIST's VCCTL: one coefficient a line, `n m Re Im`.
//!
//! Lines that are left out are coefficients of 0. A heading may stand before the first one, and exponents may begin with D.
//! The surface is r(theta, phi) = sum of a_nm Y_nm(theta, phi) about the stone's centre, where a_n,-m is (-1)^m times the
//! conjugate of a_nm, so that r is real: E. J. Garboczi, Cem. Concr. Res. 32 (2002) 1621. It becomes triangles between
//! directions that are spread evenly.

use meso_collision::geometry::{TriangleMesh, convex_hull};
use meso_collision::math::Vec3;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Why bytes are no coefficients of a stone.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HarmonicsError {
    /// Bytes that are no text.
    #[error("it is no text; a file of coefficients has one a line: n m Re Im")]
    NotText,
    /// A line that is no coefficient.
    #[error("line {line}: `{found}` is not a coefficient, n m Re Im, with m from -n to n")]
    Line {
        /// From 1.
        line: usize,
        /// The text found there.
        found: String,
    },
    /// The mean radius that is not there.
    #[error("it has no coefficient n = 0, m = 0, which is the mean radius")]
    Missing,
    /// Two lines that give one coefficient different values.
    #[error(
        "line {line}: n = {n}, m = {m} differs from an earlier line, or from a_n,-m = (-1)^m times the conjugate of a_nm; \
         write the complex coefficients of a real radius"
    )]
    Contradiction {
        /// From 1.
        line: usize,
        /// Degree.
        n: u32,
        /// Order.
        m: i32,
    },
    /// A radius that is not positive.
    #[error(
        "its radius is {radius} in the direction {direction:?}; it must be positive, which a lower degree may bring"
    )]
    Radius {
        /// The value there.
        radius: f64,
        /// Unit vector.
        direction: [f64; 3],
    },
}

/// Highest degree that is evaluated: published files end at 30.
pub const MOST_DEGREE: u32 = 40;
/// Lines about one coefficient may differ by this share of the mean radius, as rounded or fitted ones do.
const SAME: f64 = 1e-3;
/// Directions over which the volume within the harmonics is summed.
const FINE: usize = 20_000;

/// Coefficients of a stone's radius.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics {
    degree: u32,
    /// Real and imaginary parts of a_nm for m from 0 to n, n from 0.
    coefficients: Vec<[f64; 2]>,
    /// Of these, those that the file leaves out.
    left_out: usize,
}

impl Harmonics {
    /// Reads coefficients up to `degree`, or up to the highest in the file where that is lower.
    ///
    /// # Errors
    /// See [`HarmonicsError`].
    pub fn read(bytes: &[u8], degree: u32) -> Result<Self, HarmonicsError> {
        let text = std::str::from_utf8(bytes).map_err(|_| HarmonicsError::NotText)?;
        // Some programs begin a text with its byte order.
        let text = text.trim_start_matches('\u{feff}');
        let mut found: BTreeMap<(u32, u32), [f64; 2]> = BTreeMap::new();
        let mut lines = Vec::new();
        for (number, line) in rows(text) {
            let wrong = || HarmonicsError::Line { line: number + 1, found: line.trim().chars().take(40).collect() };
            let (n, m, value) = coefficient(line).ok_or_else(wrong)?;
            if n <= degree {
                lines.push((number + 1, n, m, value));
            }
        }
        // Orders from 0 first: they count as they are written, and those below 0 only where these are absent.
        lines.sort_by_key(|&(_, _, m, _)| m < 0);
        let mean = lines.iter().find(|(_, n, _, _)| *n == 0).map_or(0.0, |(_, _, _, [mean, _])| mean.abs());
        for (line, n, m, value) in lines {
            let [re, im] = mirrored(m, value);
            let known = *found.entry((n, m.unsigned_abs())).or_insert([re, im]);
            let own = if m == 0 { [re, -im] } else { [re, im] };
            if own.iter().zip(known).any(|(own, known)| (own - known).abs() > SAME * mean) {
                return Err(HarmonicsError::Contradiction { line, n, m });
            }
        }
        let degree = found.keys().map(|(n, _)| *n).max().unwrap_or(0);
        if !found.contains_key(&(0, 0)) {
            return Err(HarmonicsError::Missing);
        }
        let wanted = (0..=degree).flat_map(|n| (0..=n).map(move |m| (n, m)));
        let coefficients: Vec<[f64; 2]> = wanted.map(|nm| found.get(&nm).copied().unwrap_or_default()).collect();
        Ok(Self { degree, left_out: coefficients.len() - found.len(), coefficients })
    }

    /// Whether the first line of a text, behind a heading, is a coefficient.
    pub fn begin(bytes: &[u8]) -> bool {
        let text = std::str::from_utf8(bytes).unwrap_or_default();
        rows(text.trim_start_matches('\u{feff}')).next().is_some_and(|(_, row)| coefficient(row).is_some())
    }

    /// Number of coefficients that the file leaves out, of those of orders from 0.
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// Highest degree of the coefficients.
    pub fn degree(&self) -> u32 {
        self.degree
    }

    /// The radius in the direction of a unit vector.
    ///
    /// Legendre functions come from their recurrence in the degree, normalised so that none overflows.
    pub fn radius(&self, direction: &Vec3) -> f64 {
        let (cosine, sine) = (direction.z, libm::hypot(direction.x, direction.y));
        let angle = libm::atan2(direction.y, direction.x);
        let (mut sum, mut diagonal) = (0.0, (1.0 / (4.0 * PI)).sqrt());
        for m in 0..=self.degree {
            let order = f64::from(m);
            if m > 0 {
                diagonal *= -sine * ((2.0 * order + 1.0) / (2.0 * order)).sqrt();
            }
            let (turn_sine, turn_cosine) = libm::sincos(order * angle);
            let weight = if m == 0 { 1.0 } else { 2.0 };
            let (mut before, mut legendre) = (0.0, diagonal);
            for n in m..=self.degree {
                let [re, im] = self.coefficients[(n * (n + 1) / 2 + m) as usize];
                sum += weight * legendre * (re * turn_cosine - im * turn_sine);
                let next = f64::from(n + 1);
                let scale = ((4.0 * next * next - 1.0) / (next * next - order * order)).sqrt();
                let lag = (((next - 1.0).powi(2) - order * order) / (4.0 * (next - 1.0).powi(2) - 1.0)).max(0.0).sqrt();
                (before, legendre) = (legendre, scale * (cosine * legendre - lag * before));
            }
        }
        sum
    }

    /// The surface between as many directions as `triangles` take, which is even and at least 8.
    ///
    /// # Errors
    /// [`HarmonicsError::Radius`].
    pub fn surface(&self, triangles: usize) -> Result<TriangleMesh, HarmonicsError> {
        let directions = spread(triangles / 2 + 2);
        let sphere = convex_hull(&directions).expect("directions all around span a volume");
        let at = |direction: &Vec3| {
            let radius = self.radius(direction);
            let error = HarmonicsError::Radius { radius, direction: (*direction).into() };
            if radius > 0.0 { Ok(direction * radius) } else { Err(error) }
        };
        let vertices = sphere.vertices().iter().map(at).collect::<Result<_, _>>()?;
        Ok(TriangleMesh { vertices, triangles: sphere.triangles().collect() })
    }

    /// Volume within the harmonics, in the cube of the file's unit: a third of the mean cube of the radius, times 4 pi.
    pub fn volume(&self) -> f64 {
        let cubes = spread(FINE).into_iter().map(|direction| self.radius(&direction).powi(3));
        cubes.sum::<f64>() / FINE as f64 * 4.0 * PI / 3.0
    }
}

/// The coefficient of order |m| that one of order m stands for.
fn mirrored(m: i32, [re, im]: [f64; 2]) -> [f64; 2] {
    match (m < 0, m % 2 == 0) {
        (false, _) => [re, im],
        (true, true) => [re, -im],
        (true, false) => [-re, im],
    }
}

/// The lines of a text with their numbers, from 0, without empty ones, and without the words of a heading before all numbers.
fn rows(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let is_words = |line: &str| words(line).next().is_some_and(|word| number(word).is_none());
    let rows = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    rows.skip_while(move |(_, line)| is_words(line))
}

fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(|letter: char| letter.is_whitespace() || letter == ',').filter(|word| !word.is_empty())
}

/// A number, as Fortran writes it, too.
fn number(word: &str) -> Option<f64> {
    let digits = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
    digits(word).or_else(|| digits(&word.replace(['d', 'D'], "e")))
}

/// Degree, order and value of a line.
fn coefficient(line: &str) -> Option<(u32, i32, [f64; 2])> {
    let numbers: Vec<f64> = words(line).map(number).collect::<Option<_>>()?;
    let [n, m, re, im] = numbers[..] else { return None };
    let is_pair = n.fract() == 0.0 && m.fract() == 0.0 && (0.0..=1000.0).contains(&n) && m.abs() <= n;
    is_pair.then_some((n as u32, m as i32, [re, im]))
}

/// Unit vectors spread evenly (a Fibonacci lattice).
fn spread(count: usize) -> Vec<Vec3> {
    let golden = PI * (3.0 - 5.0_f64.sqrt());
    let one = |i: usize| {
        let z = 1.0 - (2.0 * i as f64 + 1.0) / count as f64;
        let ((sine, cosine), radius) = (libm::sincos(golden * i as f64), (1.0 - z * z).sqrt());
        Vec3::new(radius * cosine, radius * sine, z)
    };
    (0..count).map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn low_harmonics_are_the_closed_forms() {
        // Y_00, Y_10 and Y_11 without and with its phase; the convention of signs turns a stone by half a turn at most.
        let stone = Harmonics::read(b"0 0 7 0\n1 0 0.5 0\n1 1 0.25 -0.125\n1 -1 -0.25 -0.125\n", 30).unwrap();
        for direction in spread(50) {
            let [y0, y1] = [(1.0 / (4.0 * PI)).sqrt(), (3.0 / (4.0 * PI)).sqrt()];
            let x11 = -(3.0 / (8.0 * PI)).sqrt();
            let exact = 7.0 * y0 + 0.5 * y1 * direction.z + 2.0 * x11 * (0.25 * direction.x + 0.125 * direction.y);
            assert!((stone.radius(&direction) - exact).abs() < 1e-13);
        }
    }

    #[test]
    fn coefficients_of_other_conventions_are_refused() {
        let read = |text: &str| Harmonics::read(text.as_bytes(), 12);
        let [above, below] = ["1 0 0.5 0\n1 1 0.25 -0.125\n", "1 -1 -0.25 -0.125\n1 0 0.5 0\n"];
        let whole = read(&format!("0 0 7 0\n{above}")).unwrap();
        assert_eq!(read(&format!("\u{feff}0 0 7 0\n{below}")), Ok(whole.clone()));
        assert_eq!(read(&format!("0 0 7 0\n{above}{below}")), Ok(whole));
        for (text, line, n, m) in [
            ("1 -1 0.25 -0.125\n", 4, 1, -1),
            ("1 -1 -0.25 0.125\n", 4, 1, -1),
            ("1 1 0.5 -0.125\n", 4, 1, 1),
            ("0 0 8 0\n", 4, 0, 0),
        ] {
            let error = read(&format!("0 0 7 0\n{above}{text}")).unwrap_err();
            assert_eq!(error, HarmonicsError::Contradiction { line, n, m });
        }
        assert_eq!(read("0 0 7 1\n"), Err(HarmonicsError::Contradiction { line: 1, n: 0, m: 0 }));
        assert!(["", "1 0 1 0\n", "heading"].map(read) == [const { Err(HarmonicsError::Missing) }; 3]);
    }

    #[test]
    fn files_as_they_are_published_are_read() {
        let whole = "0 0 7 0\n1 0 0 0\n1 1 0 0\n2 0 0.5 0\n2 1 0 0\n2 2 0.25 -0.125\n";
        let stone = Harmonics::read(whole.as_bytes(), 12).unwrap();
        assert_eq!(stone.left_out(), 0);
        for (text, left_out) in [
            ("0 0 7 0\n2 0 0.5 0\n2 2 0.25 -0.125\n", 3),
            ("n m Re Im\n0 0 7 0\n1 0 0 0\n1 1 0 0\n2 0 .5 0\n2 1 0 0\n2 2 0.25 -0.125\n", 0),
            ("# a stone\n\n0 0 7 0\n2 0 0.5 0\n2 -2 0.25 0.125\n", 3),
            ("0 0 7.0D+00 0.0D0\n2 0 5d-1 0\n2 2 2.5D-01 -1.25d-1\n", 3),
            ("0.0 0.0 7 0\n2.0 0.0 0.5 0\n2.0 2.0 0.25 -0.125\n", 3),
            ("0, 0, 7, 0\n2, 0, 0.5, 0\n2,2,0.25,-0.125\n", 3),
        ] {
            let read = Harmonics::read(text.as_bytes(), 12).unwrap();
            assert_eq!((&read.coefficients, read.left_out()), (&stone.coefficients, left_out), "{text}");
            assert!(Harmonics::begin(text.as_bytes()), "{text}");
        }
        for other in
            ["0.0 0.0 0.0 0.0 0.0\n", "mean length 18.2\n", "", "0 1 2 3\n", "0.5 0 1 0\n", "0 0 nan 0\n", "\u{0}"]
        {
            assert!(!Harmonics::begin(other.as_bytes()), "{other}");
        }
    }

    #[test]
    fn harmonics_of_all_degrees_are_orthonormal() {
        let directions = spread(4000);
        let only = |n: u32, m: u32| {
            let rows =
                (0..=12_u32).flat_map(|i| (0..=i).map(move |j| format!("{i} {j} {} 0\n", u32::from((i, j) == (n, m)))));
            Harmonics::read(rows.collect::<String>().as_bytes(), 12).unwrap()
        };
        for (n, m) in [(3, 0), (7, 4), (12, 12), (12, 1)] {
            let stone = only(n, m);
            let square = directions.iter().map(|d| stone.radius(d).powi(2)).sum::<f64>() * 4.0 * PI / 4000.0;
            let exact = if m == 0 { 1.0 } else { 2.0 };
            assert!((square - exact).abs() < 0.02, "{n} {m}: {square}");
        }
    }
}
