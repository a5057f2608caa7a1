//! Grading curves of the standards, in percent by volume passing.
//!
//! - DIN 1045-2, lines A, B, C for 8, 16 and 32 mm. All nine reproduce the D-sums and k-values that betontechnische-daten.de
//!   gives in its Sec. 2.7.2 (A8 537 and 3.63, B16 534 and 3.66, C32 570 and 3.30, ...); a test holds them.
//! - EN 12620, coarse d/D of category Gc 85/20 (Table 2; betontechnische-daten.de, Sec. 2.2.3): 0 to 5 % pass d/2, 0 to 20 %
//!   pass d, 85 to 99 % pass D, 98 to 100 % pass 1.4 D, all pass 2 D.
//! - ASTM C33, Table "Grading requirements for coarse aggregates", and the same sizes in AASHTO M 43, from which Table 703-1
//!   of the Colorado Department of Transportation's specifications repeats those given here. All but size 56, which C33 has
//!   wider than M 43 (40 to 85 % pass 19 mm and 10 to 40 % 12.5 mm, not 40 to 75 and 15 to 35 %), were held against a second copy of M 43.
//! - GB/T 14685-2011 and -2022, Table 1, pebble and crushed stone, continuous gradings (those of JGJ 52-2006, Table
//!   3.2.1-2, too), which give shares retained; turned into shares passing here. Held against two public programs, one with
//!   the table of JGJ 52, one with that of GB/T 14685-2022: the latter differs for 5-40 mm, the former does not.

use serde::{Deserialize, Serialize};

/// A curve of a standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Standard {
    /// DIN 1045-2, A8.
    #[serde(rename = "din-1045-2-a8")]
    DinA8,
    /// DIN 1045-2, B8.
    #[serde(rename = "din-1045-2-b8")]
    DinB8,
    /// DIN 1045-2, C8.
    #[serde(rename = "din-1045-2-c8")]
    DinC8,
    /// DIN 1045-2, A16.
    #[serde(rename = "din-1045-2-a16")]
    DinA16,
    /// DIN 1045-2, B16.
    #[serde(rename = "din-1045-2-b16")]
    DinB16,
    /// DIN 1045-2, C16.
    #[serde(rename = "din-1045-2-c16")]
    DinC16,
    /// DIN 1045-2, A32.
    #[serde(rename = "din-1045-2-a32")]
    DinA32,
    /// DIN 1045-2, B32.
    #[serde(rename = "din-1045-2-b32")]
    DinB32,
    /// DIN 1045-2, C32.
    #[serde(rename = "din-1045-2-c32")]
    DinC32,
    /// EN 12620, 4/8.
    #[serde(rename = "en-12620-4-8")]
    En4To8,
    /// EN 12620, 8/16.
    #[serde(rename = "en-12620-8-16")]
    En8To16,
    /// EN 12620, 16/32.
    #[serde(rename = "en-12620-16-32")]
    En16To32,
    /// ASTM C33, size 1 (90 to 37.5 mm).
    #[serde(rename = "astm-c33-1")]
    Astm1,
    /// ASTM C33, size 2 (63 to 37.5 mm).
    #[serde(rename = "astm-c33-2")]
    Astm2,
    /// ASTM C33, size 3 (50 to 25 mm).
    #[serde(rename = "astm-c33-3")]
    Astm3,
    /// ASTM C33, size 357 (50 to 4.75 mm).
    #[serde(rename = "astm-c33-357")]
    Astm357,
    /// ASTM C33, size 4 (37.5 to 19 mm).
    #[serde(rename = "astm-c33-4")]
    Astm4,
    /// ASTM C33, size 467 (37.5 to 4.75 mm).
    #[serde(rename = "astm-c33-467")]
    Astm467,
    /// ASTM C33, size 5 (25 to 12.5 mm).
    #[serde(rename = "astm-c33-5")]
    Astm5,
    /// ASTM C33, size 56 (25 to 9.5 mm).
    #[serde(rename = "astm-c33-56")]
    Astm56,
    /// ASTM C33, size 57 (25 to 4.75 mm).
    #[serde(rename = "astm-c33-57")]
    Astm57,
    /// ASTM C33, size 6 (19 to 9.5 mm).
    #[serde(rename = "astm-c33-6")]
    Astm6,
    /// ASTM C33, size 67 (19 to 4.75 mm).
    #[serde(rename = "astm-c33-67")]
    Astm67,
    /// ASTM C33, size 7 (12.5 to 4.75 mm).
    #[serde(rename = "astm-c33-7")]
    Astm7,
    /// ASTM C33, size 8 (9.5 to 2.36 mm).
    #[serde(rename = "astm-c33-8")]
    Astm8,
    /// ASTM C33, size 89 (9.5 to 1.18 mm).
    #[serde(rename = "astm-c33-89")]
    Astm89,
    /// ASTM C33, size 9 (4.75 to 1.18 mm).
    #[serde(rename = "astm-c33-9")]
    Astm9,
    /// GB/T 14685, continuous 5-16 mm.
    #[serde(rename = "gbt-14685-5-16")]
    Gb5To16,
    /// GB/T 14685, continuous 5-20 mm.
    #[serde(rename = "gbt-14685-5-20")]
    Gb5To20,
    /// GB/T 14685, continuous 5-25 mm.
    #[serde(rename = "gbt-14685-5-25")]
    Gb5To25,
    /// GB/T 14685, continuous 5-31.5 mm.
    #[serde(rename = "gbt-14685-5-31.5")]
    Gb5To31,
    /// GB/T 14685, continuous 5-40 mm.
    #[serde(rename = "gbt-14685-5-40")]
    Gb5To40,
}

/// A sieve, mm, with the least and the most that passes it, percent.
type Row = (f64, f64, f64);

/// The sieves of DIN 1045-2, mm.
const DIN: [f64; 8] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 31.5];

impl Standard {
    /// All gradings of standards.
    pub const ALL: [Self; 32] = [
        Self::DinA8,
        Self::DinB8,
        Self::DinC8,
        Self::DinA16,
        Self::DinB16,
        Self::DinC16,
        Self::DinA32,
        Self::DinB32,
        Self::DinC32,
        Self::En4To8,
        Self::En8To16,
        Self::En16To32,
        Self::Astm1,
        Self::Astm2,
        Self::Astm3,
        Self::Astm357,
        Self::Astm4,
        Self::Astm467,
        Self::Astm5,
        Self::Astm56,
        Self::Astm57,
        Self::Astm6,
        Self::Astm67,
        Self::Astm7,
        Self::Astm8,
        Self::Astm89,
        Self::Astm9,
        Self::Gb5To16,
        Self::Gb5To20,
        Self::Gb5To25,
        Self::Gb5To31,
        Self::Gb5To40,
    ];

    /// Name of the grading as engineers write it.
    pub fn title(self) -> &'static str {
        match self {
            Self::DinA8 => "DIN 1045-2 A8",
            Self::DinB8 => "DIN 1045-2 B8",
            Self::DinC8 => "DIN 1045-2 C8",
            Self::DinA16 => "DIN 1045-2 A16",
            Self::DinB16 => "DIN 1045-2 B16",
            Self::DinC16 => "DIN 1045-2 C16",
            Self::DinA32 => "DIN 1045-2 A32",
            Self::DinB32 => "DIN 1045-2 B32",
            Self::DinC32 => "DIN 1045-2 C32",
            Self::En4To8 => "EN 12620 4/8, middle of Gc 85/20",
            Self::En8To16 => "EN 12620 8/16, middle of Gc 85/20",
            Self::En16To32 => "EN 12620 16/32, middle of Gc 85/20",
            Self::Astm1 => "ASTM C33 size 1, middle of the band",
            Self::Astm2 => "ASTM C33 size 2, middle of the band",
            Self::Astm3 => "ASTM C33 size 3, middle of the band",
            Self::Astm357 => "ASTM C33 size 357, middle of the band",
            Self::Astm4 => "ASTM C33 size 4, middle of the band",
            Self::Astm467 => "ASTM C33 size 467, middle of the band",
            Self::Astm5 => "ASTM C33 size 5, middle of the band",
            Self::Astm56 => "ASTM C33 size 56, middle of the band",
            Self::Astm57 => "ASTM C33 size 57, middle of the band",
            Self::Astm6 => "ASTM C33 size 6, middle of the band",
            Self::Astm67 => "ASTM C33 size 67, middle of the band",
            Self::Astm7 => "ASTM C33 size 7, middle of the band",
            Self::Astm8 => "ASTM C33 size 8, middle of the band",
            Self::Astm89 => "ASTM C33 size 89, middle of the band",
            Self::Astm9 => "ASTM C33 size 9, middle of the band",
            Self::Gb5To16 => "GB/T 14685 continuous 5-16 mm, middle of the band",
            Self::Gb5To20 => "GB/T 14685 continuous 5-20 mm, middle of the band",
            Self::Gb5To25 => "GB/T 14685 continuous 5-25 mm, middle of the band",
            Self::Gb5To31 => "GB/T 14685 continuous 5-31.5 mm, middle of the band",
            Self::Gb5To40 => "GB/T 14685 continuous 5-40 mm, middle of the band",
        }
    }

    /// Sieves (mm, ascending) and the share that passes, 0 to 1; of a band the middle.
    pub fn points(self) -> impl Iterator<Item = (f64, f64)> {
        self.rows().into_iter().map(|(sieve, least, most)| (sieve, (least + most) / 200.0))
    }

    /// The table as the standard has it.
    pub fn rows(self) -> Vec<Row> {
        match self {
            Self::DinA8 => din(&[5, 14, 21, 36, 61, 100]),
            Self::DinB8 => din(&[11, 26, 42, 57, 74, 100]),
            Self::DinC8 => din(&[21, 39, 57, 71, 85, 100]),
            Self::DinA16 => din(&[3, 8, 12, 21, 36, 60, 100]),
            Self::DinB16 => din(&[8, 20, 32, 42, 56, 76, 100]),
            Self::DinC16 => din(&[18, 34, 49, 62, 74, 88, 100]),
            Self::DinA32 => din(&[2, 5, 8, 14, 23, 38, 62, 100]),
            Self::DinB32 => din(&[8, 18, 28, 37, 47, 62, 80, 100]),
            Self::DinC32 => din(&[15, 29, 42, 53, 65, 77, 89, 100]),
            Self::En4To8 => en([2.0, 4.0, 8.0, 11.2, 16.0]),
            Self::En8To16 => en([4.0, 8.0, 16.0, 22.4, 31.5]),
            Self::En16To32 => en([8.0, 16.0, 31.5, 45.0, 63.0]),
            Self::Astm1 => vec![
                (19.0, 0.0, 5.0),
                (37.5, 0.0, 15.0),
                (63.0, 25.0, 60.0),
                (90.0, 90.0, 100.0),
                (100.0, 100.0, 100.0),
            ],
            Self::Astm2 => {
                vec![(19.0, 0.0, 5.0), (37.5, 0.0, 15.0), (50.0, 35.0, 70.0), (63.0, 90.0, 100.0), (75.0, 100.0, 100.0)]
            }
            Self::Astm3 => {
                vec![(12.5, 0.0, 5.0), (25.0, 0.0, 15.0), (37.5, 35.0, 70.0), (50.0, 90.0, 100.0), (63.0, 100.0, 100.0)]
            }
            Self::Astm357 => vec![
                (4.75, 0.0, 5.0),
                (12.5, 10.0, 30.0),
                (25.0, 35.0, 70.0),
                (50.0, 95.0, 100.0),
                (63.0, 100.0, 100.0),
            ],
            Self::Astm4 => {
                vec![(9.5, 0.0, 5.0), (19.0, 0.0, 15.0), (25.0, 20.0, 55.0), (37.5, 90.0, 100.0), (50.0, 100.0, 100.0)]
            }
            Self::Astm467 => {
                vec![(4.75, 0.0, 5.0), (9.5, 10.0, 30.0), (19.0, 35.0, 70.0), (37.5, 95.0, 100.0), (50.0, 100.0, 100.0)]
            }
            Self::Astm5 => {
                vec![(9.5, 0.0, 5.0), (12.5, 0.0, 10.0), (19.0, 20.0, 55.0), (25.0, 90.0, 100.0), (37.5, 100.0, 100.0)]
            }
            Self::Astm56 => vec![
                (4.75, 0.0, 5.0),
                (9.5, 0.0, 15.0),
                (12.5, 10.0, 40.0),
                (19.0, 40.0, 85.0),
                (25.0, 90.0, 100.0),
                (37.5, 100.0, 100.0),
            ],
            Self::Astm57 => {
                vec![(2.36, 0.0, 5.0), (4.75, 0.0, 10.0), (12.5, 25.0, 60.0), (25.0, 95.0, 100.0), (37.5, 100.0, 100.0)]
            }
            Self::Astm6 => {
                vec![(4.75, 0.0, 5.0), (9.5, 0.0, 15.0), (12.5, 20.0, 55.0), (19.0, 90.0, 100.0), (25.0, 100.0, 100.0)]
            }
            Self::Astm67 => {
                vec![(2.36, 0.0, 5.0), (4.75, 0.0, 10.0), (9.5, 20.0, 55.0), (19.0, 90.0, 100.0), (25.0, 100.0, 100.0)]
            }
            Self::Astm7 => {
                vec![(2.36, 0.0, 5.0), (4.75, 0.0, 15.0), (9.5, 40.0, 70.0), (12.5, 90.0, 100.0), (19.0, 100.0, 100.0)]
            }
            Self::Astm8 => {
                vec![(1.18, 0.0, 5.0), (2.36, 0.0, 10.0), (4.75, 10.0, 30.0), (9.5, 85.0, 100.0), (12.5, 100.0, 100.0)]
            }
            Self::Astm89 => vec![
                (0.3, 0.0, 5.0),
                (1.18, 0.0, 10.0),
                (2.36, 5.0, 30.0),
                (4.75, 20.0, 55.0),
                (9.5, 90.0, 100.0),
                (12.5, 100.0, 100.0),
            ],
            Self::Astm9 => {
                vec![(0.3, 0.0, 5.0), (1.18, 0.0, 10.0), (2.36, 10.0, 40.0), (4.75, 85.0, 100.0), (9.5, 100.0, 100.0)]
            }
            Self::Gb5To16 => retained(&[
                (2.36, 95.0, 100.0),
                (4.75, 85.0, 100.0),
                (9.5, 30.0, 60.0),
                (16.0, 0.0, 10.0),
                (19.0, 0.0, 0.0),
            ]),
            Self::Gb5To20 => retained(&[
                (2.36, 95.0, 100.0),
                (4.75, 90.0, 100.0),
                (9.5, 40.0, 80.0),
                (19.0, 0.0, 10.0),
                (26.5, 0.0, 0.0),
            ]),
            Self::Gb5To25 => retained(&[
                (2.36, 95.0, 100.0),
                (4.75, 90.0, 100.0),
                (16.0, 30.0, 70.0),
                (26.5, 0.0, 5.0),
                (31.5, 0.0, 0.0),
            ]),
            Self::Gb5To31 => retained(&[
                (2.36, 95.0, 100.0),
                (4.75, 90.0, 100.0),
                (9.5, 70.0, 90.0),
                (19.0, 15.0, 45.0),
                (31.5, 0.0, 5.0),
                (37.5, 0.0, 0.0),
            ]),
            Self::Gb5To40 => retained(&[
                (4.75, 95.0, 100.0),
                (9.5, 70.0, 90.0),
                (19.0, 30.0, 65.0),
                (37.5, 0.0, 5.0),
                (53.0, 0.0, 0.0),
            ]),
        }
    }
}

fn din(passing: &[u8]) -> Vec<Row> {
    DIN.iter().zip(passing).map(|(&sieve, &share)| (sieve, f64::from(share), f64::from(share))).collect()
}

/// Sieves of half the small size to twice the large one; 1.4 D and 2 D are the next of the sieves.
fn en([half, small, large, wider, widest]: [f64; 5]) -> Vec<Row> {
    vec![(half, 0.0, 5.0), (small, 0.0, 20.0), (large, 85.0, 99.0), (wider, 98.0, 100.0), (widest, 100.0, 100.0)]
}

/// From the least and the most that each sieve retains, itself and the wider ones together.
fn retained(rows: &[Row]) -> Vec<Row> {
    rows.iter().map(|&(sieve, least, most)| (sieve, 100.0 - most, 100.0 - least)).collect()
}
