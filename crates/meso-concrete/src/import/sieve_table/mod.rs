//! Sieve tables as laboratories write them: any heading, per cent, shares or masses, passing or retained.
//!
//! Text becomes rows of cells (`text`), cells become sieves and numbers (`cells`), headings say what their words
//! say (`words`). Whatever is left open is decided by proofs (`readings`): more passes a wider sieve, the coarsest sieve
//! passes all, what is retained sums to all. A table that several readings fit with different curves is refused.

mod cells;
mod readings;
mod sheet;
mod text;
mod words;

pub use cells::SieveUnit;
pub use text::decode;

use readings::ReadAnalysis;
use sheet::Sheet;

/// A column of numbers, by its meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Meaning {
    /// All that passes the sieve.
    Passing,
    /// All that the sieve and the wider ones retain.
    Cumulative,
    /// The part that the sieve itself retains.
    Retained,
}

impl Meaning {
    /// Options' names of the meanings.
    pub const NAMES: [(&'static str, Self); 3] =
        [("passing", Self::Passing), ("cumulative-retained", Self::Cumulative), ("retained", Self::Retained)];

    fn words(self) -> &'static str {
        match self {
            Self::Passing => "passing",
            Self::Cumulative => "cumulative retained",
            Self::Retained => "retained on each sieve",
        }
    }
}

/// What a number of a column counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueUnit {
    /// Hundredths.
    Percent,
    /// Shares from 0 to 1.
    Share,
    /// Masses, whose sum is all.
    Mass,
}

impl ValueUnit {
    /// Options' names of the units.
    pub const NAMES: [(&'static str, Self); 3] =
        [("percent", Self::Percent), ("share", Self::Share), ("mass", Self::Mass)];

    fn words(self) -> &'static str {
        match self {
            Self::Percent => "per cent",
            Self::Share => "shares",
            Self::Mass => "masses",
        }
    }
}

impl SieveUnit {
    /// Options' names of the units of sieves.
    pub const NAMES: [(&'static str, Self); 4] =
        [("mm", Self::Mm), ("um", Self::Um), ("in", Self::Inch), ("astm-number", Self::Number)];
}

/// A column, as an option names it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TableColumn {
    /// Position from 1, the sieves included.
    Position(usize),
    /// Heading, or a part of it that no other heading has; else digits are a position.
    Heading(String),
}

/// Choices that the table's own words and numbers do not need to make.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Choices {
    /// Columns and their shares, in any scale; one column alone where it is chosen.
    pub columns: Vec<(TableColumn, f64)>,
    /// Meaning of the columns.
    pub means: Option<Meaning>,
    /// What their numbers count.
    pub unit: Option<ValueUnit>,
    /// Unit of bare numbers in the column of sieves.
    pub sieve_unit: Option<SieveUnit>,
}

/// A grading as a table has it.
#[derive(Clone, Debug, PartialEq)]
pub struct SieveTable {
    /// Openings, mm, ascending.
    pub sieves_mm: Vec<f64>,
    /// Share that passes each, 0 to 1.
    pub passing: Vec<f64>,
    /// How the table was read, for its user.
    pub understood: String,
}

/// Most bytes of a table; the longest that laboratories write have some kB.
const LONGEST: usize = 4 << 20;

/// Reads the text of a table.
///
/// # Errors
/// Names the line and the reason, and the choices that help; never guesses.
pub fn read(bytes: &[u8], choices: &Choices) -> Result<SieveTable, String> {
    if bytes.len() > LONGEST {
        return Err(format!("it is longer than {} MB, too long for a sieve table", LONGEST >> 20));
    }
    let text = text::decode(bytes)?;
    let separators = text::separators(&text);
    let tried: Vec<_> = separators.iter().map(|&separator| read_with(&text, separator, choices)).collect();
    let good: Vec<&SieveTable> = tried.iter().flatten().collect();
    if good.windows(2).any(|pair| !same(pair[0], pair[1])) {
        return Err(
            "its fields can be separated in two ways with different numbers; separate them by ; alone".to_owned()
        );
    }
    if let Some(&table) = good.first() {
        return Ok(table.clone());
    }
    let none = "it has no two columns; write a line for each sieve, its opening and the per cent that passes, as in Sieve \
                (mm);Passing (%)";
    Err(tried.into_iter().find_map(Result::err).unwrap_or_else(|| none.to_owned()))
}

fn same(a: &SieveTable, b: &SieveTable) -> bool {
    a.sieves_mm == b.sieves_mm && a.passing == b.passing
}

fn read_with(text: &str, separator: char, choices: &Choices) -> Result<SieveTable, String> {
    let sheet = Sheet::of(text, separator, choices)?;
    ReadAnalysis { sheet: &sheet, choices }.read()
}
