//! Numbers and sieves as people write them: decimal commas, thousands, per cent, inches, ASTM numbers, pans.

/// The unit that a heading or an option gives to bare numbers of the sieve column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SieveUnit {
    /// Millimetres.
    Mm,
    /// Micrometres.
    Um,
    /// Inches.
    Inch,
    /// Numbers of ASTM E11.
    Number,
}

/// The decimal marks that the table proves: a mark is proved by a cell that no thousands explain.
#[derive(Clone, Copy, Debug)]
pub(super) struct Marks {
    pub(super) comma: bool,
    pub(super) point: bool,
    /// The largest number that its place allows; a larger one is not meant.
    pub(super) most: f64,
}

impl Marks {
    /// No mark is proved.
    pub(super) const NONE: Self = Self { comma: false, point: false, most: f64::INFINITY };
    /// Points stand before decimals.
    pub(super) const POINT: Self = Self { point: true, ..Self::NONE };
    /// Commas stand before decimals.
    pub(super) const COMMA: Self = Self { comma: true, ..Self::NONE };

    pub(super) fn up_to(self, most: f64) -> Self {
        Self { most, ..self }
    }
}

/// Openings of sieves end below this, mm: no bare 31.500 means 31500 mm.
const WIDEST_MM: f64 = 500.0;

/// A number of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) value: f64,
    /// A per cent sign stands behind it.
    pub(super) percent: bool,
}

/// A cell of the sieve column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Sieve {
    /// An opening, mm.
    Opening(f64),
    /// A bare number without any unit.
    Bare(f64),
    /// The pan; or all below an opening, mm.
    Pan(Option<f64>),
    /// Fines that were washed out before the sieving, beside the pan.
    Washed,
    /// The mass that washing leaves.
    Left,
    /// The sum of the column.
    Total,
    /// The mass before washing and sieving.
    Initial,
    /// A figure of the curve or of the test, e.g. a fineness modulus or a loss.
    Figure,
}

const PANS: [&str; 27] = [
    "p",
    "pan",
    "receiver",
    "bottom",
    "base",
    "schale",
    "boden",
    "siebboden",
    "auffang",
    "pfanne",
    "fond",
    "fondo",
    "ciego",
    "bandeja",
    "fundo",
    "prato",
    "bodem",
    "onderbak",
    "dno",
    "misa",
    "rest",
    "поддон",
    "дно",
    "resto",
    "底盘",
    "底",
    "筛底",
];
const TOTALS: [&str; 14] = [
    "total",
    "summe",
    "sum",
    "somme",
    "suma",
    "soma",
    "totale",
    "totaal",
    "gesamt",
    "summa",
    "σ",
    "∑",
    "итого",
    "合计",
];
/// Beginnings of words for what washing takes.
const WASHINGS: [&str; 9] =
    ["wash", "abschlämm", "ausgewasch", "lavage", "lavado", "lavagem", "lavaggio", "spül", "отмы"];
const INITIALS: [&str; 9] =
    ["initial", "m1", "einwaage", "anfangsmasse", "initiale", "inicial", "iniziale", "before", "original"];
/// Masses after a step of the test, which its rows have already.
const FINALS: [&str; 6] = ["final", "finale", "after", "nach", "après", "después"];
const LOSSES: [&str; 5] = ["loss", "lost", "verlust", "perte", "pérdida"];
const FIGURES: [&str; 12] = [
    "fineness",
    "fm",
    "f.m",
    "feinheit",
    "k-wert",
    "körnungsziffer",
    "module",
    "modulo",
    "módulo",
    "finheds",
    "модуль",
    "细度模数",
];

/// A part of the alphabet that stands for nothing: no value was measured.
pub(super) fn is_blank(text: &str) -> bool {
    matches!(text.trim().to_lowercase().as_str(), "" | "-" | "–" | "—" | "n/a" | "na" | "n.a." | "/" | "*")
}

/// Reads a number; a reason where it is none, or could be two.
pub(super) fn number(text: &str, marks: Marks) -> Result<Number, String> {
    let lower = text.trim().to_lowercase();
    if lower == "nil" {
        return Ok(Number { value: 0.0, percent: false });
    }
    let stripped = ["m.-%", "vol.-%", "m-%", "%", "percent", "kg", "g"].iter().find_map(|unit| {
        let rest = lower.strip_suffix(unit)?;
        Some((rest.trim_end(), unit.contains('%') || *unit == "percent"))
    });
    let (digits, percent) = stripped.unwrap_or((&lower, false));
    let marks = if percent { marks.up_to(100.0) } else { marks };
    Ok(Number { value: plain(digits, marks)?, percent })
}

/// Whether a cell has a number, whichever mark stands before its decimals.
pub(super) fn is_number(text: &str) -> bool {
    number(text, Marks::COMMA).is_ok()
}

/// Whether a cell has a mass in kg, where others may be in g.
pub(super) fn is_in_kg(text: &str) -> bool {
    text.trim().to_lowercase().ends_with("kg")
}

/// Which decimal mark a cell proves by itself.
pub(super) fn proof(text: &str) -> Marks {
    let digits =
        text.trim().trim_end_matches(|c: char| !c.is_ascii_digit()).trim_start_matches(|c: char| !c.is_ascii_digit());
    match WrittenDigits::of(digits) {
        Some(WrittenDigits { decimal: Some(','), .. }) => Marks::COMMA,
        Some(WrittenDigits { decimal: Some('.'), .. }) => Marks::POINT,
        _ => Marks::NONE,
    }
}

/// Digits with their marks, as far as one cell alone decides them.
struct WrittenDigits {
    /// Digits with a point before the decimals; groups of thousands are joined.
    text: String,
    /// The decimal mark.
    decimal: Option<char>,
    /// A single mark before three digits: decimals, or thousands.
    open: Option<char>,
}

impl WrittenDigits {
    fn of(text: &str) -> Option<Self> {
        let text = joined_groups(text, &[' ', '\u{a0}', '\u{202f}', '\u{2009}', '\'', '’'])?;
        if text.is_empty() || !text.chars().all(|c| c.is_ascii_digit() || matches!(c, ',' | '.')) {
            return None;
        }
        let marks: Vec<char> = text.chars().filter(|c| !c.is_ascii_digit()).collect();
        let Some(&last) = marks.last() else { return Some(Self { text, decimal: None, open: None }) };
        let other = if last == ',' { '.' } else { ',' };
        let times = marks.iter().filter(|mark| **mark == last).count();
        if times > 1 {
            // Thousands, without decimals.
            let text = joined_groups(&text, &[last])?;
            return (!text.contains(other)).then_some(Self { text, decimal: None, open: None });
        }
        let (whole, decimals) = text.split_once(last)?;
        let whole = joined_groups(whole, &[other])?;
        if decimals.is_empty() || whole.contains(['.', ',']) {
            return None;
        }
        let is_open =
            marks.len() == 1 && decimals.len() == 3 && (1..=3).contains(&whole.len()) && !whole.starts_with('0');
        let text = format!("{whole}.{decimals}");
        Some(Self { text, decimal: (!is_open).then_some(last), open: is_open.then_some(last) })
    }
}

/// Removes marks between groups of three digits; `None` if they stand elsewhere.
fn joined_groups(text: &str, marks: &[char]) -> Option<String> {
    let groups: Vec<&str> = text.split(marks).collect();
    let Some((first, rest)) = groups.split_first() else { return Some(String::new()) };
    if rest.is_empty() {
        return Some(text.to_owned());
    }
    let leading = |group: &str| group.chars().take_while(char::is_ascii_digit).count();
    let (last, between) = rest.split_last()?;
    let is_group = (1..=3).contains(&first.len())
        && leading(first) == first.len()
        && between.iter().all(|group| group.len() == 3 && leading(group) == 3)
        && leading(last) == 3;
    is_group.then(|| groups.concat())
}

fn plain(text: &str, marks: Marks) -> Result<f64, String> {
    let wrong = || format!("{text:?} is not a number");
    if let Some((mantissa, exponent)) = text.split_once('e') {
        let power: i32 = exponent.parse().map_err(|_| wrong())?;
        return if power.abs() < 10 {
            Ok(plain(mantissa, marks)? * libm::pow(10.0, f64::from(power)))
        } else {
            Err(wrong())
        };
    }
    let written = WrittenDigits::of(text).ok_or_else(wrong)?;
    let parse = |text: &str| text.parse::<f64>().map_err(|_| wrong());
    let Some(mark) = written.open else { return parse(&written.text) };
    let thousands = parse(&written.text.replace('.', ""))?;
    if thousands > marks.most {
        return parse(&written.text);
    }
    let (same, other) = if mark == ',' { (marks.comma, marks.point) } else { (marks.point, marks.comma) };
    match (same, other) {
        (true, false) => parse(&written.text),
        (false, true) => Ok(thousands),
        _ => Err(format!(
            "{text:?} is {} or {}: no other number of the table says which; write it without thousands, or with decimals",
            written.text, thousands
        )),
    }
}

/// Reads a cell of the sieve column; `None` where it is a word that names no sieve.
pub(super) fn sieve(text: &str, unit: Option<SieveUnit>, marks: Marks) -> Result<Option<Sieve>, String> {
    let text = usual(text);
    if text.is_empty() {
        return Ok(None);
    }
    if let Some((outside, inside)) = parenthesis(&text) {
        return both(sieve(&outside, unit, marks)?, sieve(&inside, None, marks).unwrap_or(None), &text);
    }
    if let Some(kind) = word(&text, unit, marks)? {
        return Ok(Some(kind));
    }
    let text = text.trim_start_matches(['>', '≥', '+', 'ø', '⌀', ' ']);
    if let Some(number) = astm_number(text) {
        let opening = number.and_then(of_number).ok_or_else(|| format!("{text:?} is no sieve number of ASTM E11"))?;
        return Ok(Some(Sieve::Opening(opening)));
    }
    let scaled = |suffixes: &[&str], scale: f64| {
        let rest = suffixes.iter().find_map(|suffix| text.strip_suffix(suffix))?;
        Some(plain(rest.trim(), marks.up_to(WIDEST_MM / scale)).map(|size| Some(Sieve::Opening(size * scale))))
    };
    if let Some(found) = scaled(&["mm", "mm.", "мм", "毫米"], 1.0) {
        return found;
    }
    // A division, so that 63 um is the 0.063 mm of the standards.
    let microns = ["um", "microns", "micron", "мкм", "u"].iter().find_map(|suffix| text.strip_suffix(suffix));
    if let Some(Ok(size)) = microns.map(|rest| plain(rest.trim(), marks)) {
        return Ok(Some(Sieve::Opening(size / 1000.0)));
    }
    let inches = ["inches", "inch", "in.", "in", "\"", "zoll", "pulg.", "pulg", "pouces", "pouce", "дюйм"];
    if let Some(rest) = inches.iter().find_map(|suffix| text.strip_suffix(suffix)) {
        return Ok(fraction(rest.trim(), marks).map(|size| Sieve::Opening(of_inches(size))));
    }
    bare(text, unit, marks)
}

fn bare(text: &str, unit: Option<SieveUnit>, marks: Marks) -> Result<Option<Sieve>, String> {
    if !begins_a_number(text) {
        return Ok(None);
    }
    if unit == Some(SieveUnit::Inch) {
        return Ok(fraction(text, marks).map(|size| Sieve::Opening(of_inches(size))));
    }
    if text.contains('/') {
        return Ok(None);
    }
    let marks = if unit == Some(SieveUnit::Um) { marks } else { marks.up_to(WIDEST_MM) };
    let size = match plain(text, marks) {
        Ok(size) => size,
        Err(reason) if reason.contains(" or ") => return Err(reason),
        Err(_) => return Ok(None),
    };
    Ok(match unit {
        _ if size == 0.0 => Some(Sieve::Pan(None)),
        Some(SieveUnit::Um) => Some(Sieve::Opening(size / 1000.0)),
        Some(SieveUnit::Number) => {
            let opening = of_number(size).ok_or_else(|| format!("{text:?} is no sieve number of ASTM E11"))?;
            Some(Sieve::Opening(opening))
        }
        Some(_) => Some(Sieve::Opening(size)),
        None => Some(Sieve::Bare(size)),
    })
}

/// Whether a text begins with a digit, a mark or a fraction.
pub(super) fn begins_a_number(text: &str) -> bool {
    let is_fraction = |c: char| FRACTIONS.iter().any(|(sign, _)| sign.starts_with(c));
    text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '.' | ',') || is_fraction(c))
}

const FRACTIONS: [(&str, &str); 7] =
    [("½", " 1/2"), ("¼", " 1/4"), ("¾", " 3/4"), ("⅛", " 1/8"), ("⅜", " 3/8"), ("⅝", " 5/8"), ("⅞", " 7/8")];

/// Lower case, one kind of quote, of micro sign and of space.
fn usual(text: &str) -> String {
    let text = text.trim().to_lowercase().replace(['″', '”', '“', '„'], "\"").replace("''", "\"");
    let text = text.replace(['µ', 'μ'], "u").replace(['\u{a0}', '\u{202f}'], " ").replace("u m", "um");
    let words = ["is ", "bs ", "en ", "iso ", "astm ", "us ", "sieve", "sieb", "tamis", "tamiz", "sito", "сито"];
    words.iter().fold(text, |text, word| {
        let rest = text.strip_prefix(word).unwrap_or(&text).trim();
        let rest = if word.ends_with(' ') { rest } else { rest.strip_suffix(word).map_or(rest, str::trim) };
        rest.to_owned()
    })
}

/// Text before and inside a parenthesis at the end.
fn parenthesis(text: &str) -> Option<(String, String)> {
    let (outside, inside) = text.strip_suffix([')', ']'])?.split_once(['(', '['])?;
    (!outside.trim().is_empty()).then(|| (outside.trim().to_owned(), inside.trim().to_owned()))
}

/// One sieve written twice: both must be the same, and millimetres are the more exact.
fn both(outside: Option<Sieve>, inside: Option<Sieve>, text: &str) -> Result<Option<Sieve>, String> {
    let size = |sieve| match sieve {
        Some(Sieve::Opening(size) | Sieve::Bare(size)) => Some(size),
        _ => None,
    };
    match (size(outside), size(inside)) {
        (Some(a), Some(b)) if (a / b - 1.0).abs() > 0.03 => {
            Err(format!("{text:?} names two sieves, of {a} and {b} mm"))
        }
        (Some(a), Some(_)) if text.contains("mm") => {
            let in_mm = if text.find("mm") < text.find(['(', '[']) { outside } else { inside };
            Ok(Some(Sieve::Opening(size(in_mm).unwrap_or(a))))
        }
        _ if outside.is_none() && matches!(inside, Some(Sieve::Pan(_))) => Ok(inside),
        _ => Ok(outside),
    }
}

/// Pans, sums, figures, and the masses of a test with washing (EN 933-1).
fn word(text: &str, unit: Option<SieveUnit>, marks: Marks) -> Result<Option<Sieve>, String> {
    let parts = text.split(|c: char| !c.is_alphanumeric());
    let is_washing = parts.clone().any(|part| WASHINGS.iter().any(|word| part.starts_with(word)));
    let is_one_of = |words: &[&str]| parts.clone().any(|part| words.contains(&part));
    if is_one_of(&INITIALS) {
        return Ok(Some(Sieve::Initial));
    }
    if is_one_of(&["m2"]) || (is_one_of(&FINALS) && is_washing) {
        return Ok(Some(Sieve::Left));
    }
    if is_one_of(&FINALS) || (is_one_of(&LOSSES) && !is_washing) {
        return Ok(Some(Sieve::Figure));
    }
    if is_washing {
        return Ok(Some(Sieve::Washed));
    }
    let below = ["<", "≤", "passing ", "finer than ", "-"].iter().find_map(|sign| text.strip_prefix(sign));
    if let Some(rest) = below.map(str::trim) {
        return Ok(match sieve(rest, unit, marks)? {
            Some(Sieve::Opening(size) | Sieve::Bare(size)) => Some(Sieve::Pan(Some(size))),
            Some(Sieve::Pan(size)) => Some(Sieve::Pan(size)),
            _ => None,
        });
    }
    let begins = |words: &[&str]| {
        words.iter().any(|word| {
            let rest = text.strip_prefix(word);
            rest.is_some_and(|rest| !rest.starts_with(|c: char| c.is_alphanumeric()))
        })
    };
    let has = |words: &[&str]| {
        text.split(|c: char| !c.is_alphanumeric() && c != 'σ' && c != '∑').any(|part| words.contains(&part))
    };
    let quantile =
        |text: &str| text.strip_prefix('d').is_some_and(|rest| rest.len() == 2 && rest.parse::<u8>().is_ok());
    Ok(if begins(&FIGURES) || quantile(text) || matches!(text, "cu" | "cc") {
        Some(Sieve::Figure)
    } else if has(&PANS) {
        Some(Sieve::Pan(None))
    } else if has(&TOTALS) {
        Some(Sieve::Total)
    } else {
        None
    })
}

/// The number behind `No.`, `Nr.`, `N°` or `#`; `Some(None)` where that is no number.
fn astm_number(text: &str) -> Option<Option<f64>> {
    let text = text.trim_start_matches("astm").trim_start();
    let rest =
        ["no.", "nº.", "nº", "n°", "nr.", "nr", "no", "№", "#"].iter().find_map(|sign| text.strip_prefix(sign))?;
    (!rest.trim().is_empty()).then(|| rest.trim().parse().ok())
}

/// Openings of ASTM E11 sieves by their numbers, mm.
const NUMBERS: [(f64, f64); 30] = [
    (3.5, 5.6),
    (4.0, 4.75),
    (5.0, 4.0),
    (6.0, 3.35),
    (7.0, 2.8),
    (8.0, 2.36),
    (10.0, 2.0),
    (12.0, 1.7),
    (14.0, 1.4),
    (16.0, 1.18),
    (18.0, 1.0),
    (20.0, 0.85),
    (25.0, 0.71),
    (30.0, 0.6),
    (35.0, 0.5),
    (40.0, 0.425),
    (45.0, 0.355),
    (50.0, 0.3),
    (60.0, 0.25),
    (70.0, 0.212),
    (80.0, 0.18),
    (100.0, 0.15),
    (120.0, 0.125),
    (140.0, 0.106),
    (170.0, 0.09),
    (200.0, 0.075),
    (230.0, 0.063),
    (270.0, 0.053),
    (325.0, 0.045),
    (400.0, 0.038),
];
/// Openings of ASTM E11 sieves by their inches, mm.
const INCHES: [(f64, f64); 20] = [
    (4.0, 100.0),
    (3.5, 90.0),
    (3.0, 75.0),
    (2.5, 63.0),
    (2.125, 53.0),
    (2.0, 50.0),
    (1.75, 45.0),
    (1.5, 37.5),
    (1.25, 31.5),
    (1.0, 25.0),
    (0.875, 22.4),
    (0.75, 19.0),
    (0.625, 16.0),
    (0.5, 12.5),
    (0.4375, 11.2),
    (0.375, 9.5),
    (0.3125, 8.0),
    (0.25, 6.3),
    (0.187, 4.75),
    (0.1875, 4.75),
];

fn of_number(number: f64) -> Option<f64> {
    NUMBERS.iter().find(|row| row.0 == number).map(|row| row.1)
}

fn of_inches(inches: f64) -> f64 {
    INCHES.iter().find(|row| row.0 == inches).map_or(25.4 * inches, |row| row.1)
}

/// Inches: `3/4`, `1 1/2`, `1-1/2`, `1½`, `0.75`.
fn fraction(text: &str, marks: Marks) -> Option<f64> {
    let text = FRACTIONS.iter().fold(text.to_owned(), |text, (sign, digits)| text.replace(sign, digits));
    let parts: Vec<&str> = text.split([' ', '-']).filter(|part| !part.is_empty()).collect();
    let part = |text: &str| match text.split_once('/') {
        Some((above, below)) => {
            let [above, below] = [above, below].map(|digits| digits.parse::<u8>().ok().filter(|digit| *digit > 0));
            Some(f64::from(above?) / f64::from(below?))
        }
        None => plain(text, marks).ok(),
    };
    match parts[..] {
        [one] => part(one),
        [whole, rest] if rest.contains('/') && !whole.contains('/') => Some(part(whole)? + part(rest)?),
        _ => None,
    }
}

/// Sieves of ISO 565, EN 933-2, ASTM E11, IS 460, GB/T 14684 and older sheets, mm.
const USUAL_MM: [f64; 82] = [
    0.038, 0.045, 0.053, 0.06, 0.063, 0.071, 0.075, 0.08, 0.09, 0.1, 0.106, 0.112, 0.125, 0.14, 0.15, 0.16, 0.18, 0.2,
    0.212, 0.25, 0.3, 0.315, 0.355, 0.4, 0.425, 0.5, 0.6, 0.63, 0.71, 0.8, 0.85, 1.0, 1.18, 1.25, 1.4, 1.6, 1.7, 2.0,
    2.36, 2.5, 2.8, 3.15, 3.35, 4.0, 4.75, 5.0, 5.6, 6.3, 6.7, 8.0, 9.5, 10.0, 11.2, 12.5, 13.2, 14.0, 16.0, 18.0,
    19.0, 20.0, 22.4, 25.0, 26.5, 28.0, 31.5, 32.0, 35.5, 37.5, 38.1, 40.0, 45.0, 50.0, 53.0, 56.0, 63.0, 71.0, 75.0,
    80.0, 90.0, 100.0, 125.0, 150.0,
];

/// Bare numbers are millimetres where all are usual sieves in mm, and not all are inches at once.
pub(super) fn are_millimetres(sizes: &[f64]) -> bool {
    let usual = |size: &f64| USUAL_MM.iter().any(|sieve| (size / sieve - 1.0).abs() < 1e-6);
    let inch = |size: &f64| INCHES.iter().any(|row| row.0 == *size);
    sizes.iter().all(usual) && !sizes.iter().all(inch)
}
