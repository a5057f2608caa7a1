//! Words of headings, in the languages of the sheets: which column has sieves, and what the others mean.

use super::cells::SieveUnit;
use super::{Meaning, ValueUnit};

const PASSING: [&str; 37] = [
    "passing",
    "pass",
    "finer",
    "undersize",
    "durchgang",
    "durchgänge",
    "passant",
    "tamisat",
    "passe",
    "pasa",
    "pasante",
    "pasan",
    "passante",
    "passato",
    "passado",
    "passa",
    "doorval",
    "przechod",
    "przesiew",
    "propad",
    "podsit",
    "átesett",
    "áthull",
    "läpäisy",
    "passerande",
    "passerar",
    "gjennomgang",
    "gennemfald",
    "проход",
    "прошл",
    "прошед",
    "trecer",
    "geçen",
    "通过",
    "通過",
    "διερχ",
    "prolaz",
];
const RETAINED: [&str; 25] = [
    "retain",
    "rückstand",
    "rückst",
    "rueckstand",
    "refus",
    "reten",
    "retido",
    "trattenut",
    "zeefrest",
    "siebrest",
    "pozostał",
    "odsiew",
    "zbyt",
    "nadsit",
    "fennmarad",
    "остат",
    "kalan",
    "筛余",
    "篩餘",
    "oversize",
    "coarser",
    "stannar",
    "seulalle",
    "tilbakehold",
    "rest",
];
const CUMULATIVE: [&str; 12] =
    ["cum", "kum", "acum", "accum", "summe", "skum", "полн", "累计", "累計", "ackum", "σ", "∑"];
const INDIVIDUAL: [&str; 10] =
    ["individual", "partial", "parzial", "partiel", "parcial", "einzel", "част", "分计", "each sieve", "per sieve"];
const SIEVES: [&str; 37] = [
    "sieve",
    "sieb",
    "masche",
    "lochweite",
    "korngr",
    "korn",
    "tamis",
    "maille",
    "ouverture",
    "tamiz",
    "malla",
    "abertura",
    "luz",
    "setacci",
    "vaglio",
    "apertura",
    "peneira",
    "zeef",
    "sito",
    "síto",
    "oczk",
    "szita",
    "sikt",
    "seula",
    "elek",
    "сит",
    "отверст",
    "筛孔",
    "篩",
    "筛",
    "opening",
    "aperture",
    "mesh",
    "size",
    "diamet",
    "diam",
    "durchmesser",
];
const LIMITS: [&str; 11] =
    ["limit", "lower", "upper", "specification", "grenz", "untere", "obere", "envelope", "fuseau", "wymag", "требован"];
const LIMIT_WORDS: [&str; 8] = ["min", "max", "minimum", "maximum", "spec", "soll", "huso", "target"];
const TARES: [&str; 4] = ["empty", "tare", "leer", "+"];

/// What the words of a heading say; nothing where they say nothing.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Said {
    pub(super) is_sieve: bool,
    pub(super) sieve_unit: Option<SieveUnit>,
    /// Meanings that the words leave; all, where they name none.
    pub(super) meanings: Vec<Meaning>,
    /// Whether the words name a meaning.
    pub(super) has_meaning: bool,
    pub(super) unit: Option<ValueUnit>,
    /// Limits of a specification, masses of empty sieves: no analysis.
    pub(super) is_foreign: bool,
}

/// Reads a heading.
pub(super) fn read(heading: &str) -> Said {
    let text = heading.to_lowercase().replace(['µ', 'μ'], "u");
    let has = |words: &[&str]| words.iter().any(|word| begins_word(&text, word));
    let (passing, retained) = (has(&PASSING), !has(&PASSING) && has(&RETAINED));
    let (cumulative, individual) = (has(&CUMULATIVE), has(&INDIVIDUAL));
    let meanings = match (passing, retained, cumulative, individual) {
        (true, ..) => vec![Meaning::Passing],
        (_, true, true, false) => vec![Meaning::Cumulative],
        (_, true, false, true) | (_, false, false, true) => vec![Meaning::Retained],
        (_, true, ..) => vec![Meaning::Cumulative, Meaning::Retained],
        (_, false, true, _) => vec![Meaning::Passing, Meaning::Cumulative],
        _ => vec![Meaning::Passing, Meaning::Cumulative, Meaning::Retained],
    };
    let unit = unit(&text);
    let has_meaning = passing || retained;
    let sieve_unit = sieve_unit(&text);
    let named = has(&SIEVES) || matches!(sieve_unit, Some(SieveUnit::Mm | SieveUnit::Um | SieveUnit::Inch));
    let is_tare =
        unit == Some(ValueUnit::Mass) && has(&SIEVES) && (!has_meaning || TARES.iter().any(|word| text.contains(word)));
    Said {
        is_sieve: named && !has_meaning && unit.is_none(),
        sieve_unit,
        meanings,
        has_meaning,
        unit,
        is_foreign: has(&LIMITS) || LIMIT_WORDS.iter().any(|word| has_word(&text, word)) || is_tare,
    }
}

/// Whether a word of the text begins so; words of Chinese, and the second parts of German ones, begin anywhere.
fn begins_word(text: &str, word: &str) -> bool {
    let anywhere = !word.is_ascii() || word.len() > 5;
    text.match_indices(word).any(|(at, _)| anywhere || !text[..at].chars().next_back().is_some_and(char::is_alphabetic))
}

/// Whether the text has a word that is exactly this.
fn has_word(text: &str, word: &str) -> bool {
    text.split(|c: char| !c.is_alphanumeric()).any(|part| part == word)
}

fn unit(text: &str) -> Option<ValueUnit> {
    let percent = ["%", "percent", "per cent", "prozent", "pourcent", "porcent", "pct", "百分", "процент"];
    let shares = ["fraction", "share", "(-)", "[-]", "0-1", "0..1", "0–1", "decimal", "bruchteil"];
    if percent.iter().any(|word| text.contains(word)) {
        Some(ValueUnit::Percent)
    } else if has_word(text, "g") || has_word(text, "kg") || has_word(text, "гр") || has_word(text, "grams") {
        Some(ValueUnit::Mass)
    } else if shares.iter().any(|word| text.contains(word)) {
        Some(ValueUnit::Share)
    } else {
        let masses = ["mass", "weight", "masse", "poids", "peso", "gewicht", "масса", "质量", "waga"];
        masses.iter().any(|word| text.contains(word)).then_some(ValueUnit::Mass)
    }
}

fn sieve_unit(text: &str) -> Option<SieveUnit> {
    let words = |words: &[&str]| words.iter().any(|word| has_word(text, word));
    let units = [
        (words(&["mm", "millimetre", "millimeter", "millimetres", "мм", "毫米"]), SieveUnit::Mm),
        (words(&["um", "micron", "microns", "micrometre", "micrometer", "мкм"]), SieveUnit::Um),
        (
            words(&["in", "inch", "inches", "zoll", "pouce", "pouces", "pulgadas", "pulg"]) || text.contains("(\")"),
            SieveUnit::Inch,
        ),
        (
            words(&["no", "nr", "number"]) || text.contains('#') || text.contains('№') || text.contains("n°"),
            SieveUnit::Number,
        ),
    ];
    let mut said = units.iter().filter(|unit| unit.0).map(|unit| unit.1);
    let first = said.next();
    // Two units say nothing of a bare number.
    if said.next().is_some() { None } else { first }
}

/// A unit of a heading in which no sieve is read.
pub(super) fn foreign_unit(heading: &str) -> Option<&'static str> {
    let text = heading.to_lowercase();
    ["cm", "см", "dm", "m", "ft", "nm", "phi", "φ", "ϕ", "mm²", "mm2"].into_iter().find(|unit| has_word(&text, unit))
}

/// Whether a row gives the share of every column in a blend.
pub(super) fn is_share_row(label: &str) -> bool {
    let label = label.to_lowercase();
    [
        "share",
        "proportion",
        "anteil",
        "mix",
        "blend",
        "dosage",
        "proporci",
        "quota",
        "udział",
        "andel",
        "доля",
        "aandeel",
    ]
    .iter()
    .any(|word| begins_word(&label, word))
}
