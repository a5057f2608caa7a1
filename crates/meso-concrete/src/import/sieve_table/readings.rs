//! Readings of a column of numbers, and the proofs that leave one.

use super::sheet::{Sheet, Values};
use super::{Choices, Meaning, SieveTable, TableColumn, ValueUnit};

/// Largest difference of two columns of one sheet that rounding explains: integers of ten sieves, added.
const ROUNDED: f64 = 0.02;
/// Largest loss of a sieving: EN 933-1 repeats a test beyond 1 %, so exactly 1 % is accepted.
const LOSS: f64 = 0.01 + 1e-9;

/// A curve that a column has under one meaning and unit.
#[derive(Clone, Debug)]
struct Reading {
    meaning: Meaning,
    unit: ValueUnit,
    /// Share that passes each sieve, from the coarsest.
    passing: Vec<f64>,
    note: String,
}

/// Why a reading is none.
struct Fault {
    reason: String,
    /// The numbers contradict it; else something is missing that would prove it.
    is_contradiction: bool,
}

fn contradiction<T>(reason: String) -> Result<T, Fault> {
    Err(Fault { reason, is_contradiction: true })
}

fn unproved<T>(reason: impl Into<String>) -> Result<T, Fault> {
    Err(Fault { reason: reason.into(), is_contradiction: false })
}

/// A sheet and its user's choices.
pub(super) struct ReadAnalysis<'a> {
    pub(super) sheet: &'a Sheet,
    pub(super) choices: &'a Choices,
}

/// A column and its share of the blend.
type Share<'a> = (&'a Values, f64);

impl ReadAnalysis<'_> {
    /// The one curve of the sheet.
    pub(super) fn read(&self) -> Result<SieveTable, String> {
        if self.sheet.sieves.len() < 2 {
            return Err("it has a single sieve; a curve has two or more".to_owned());
        }
        let (columns, how) = self.columns()?;
        let mut curves = Vec::new();
        for (values, share) in &columns {
            let reading = self.sole(values)?;
            curves.push((*values, *share, reading));
        }
        if curves.len() == 1 && self.choices.columns.is_empty() {
            self.cross_check(curves[0].0, &curves[0].2)?;
        }
        Ok(self.table(&curves, &how))
    }

    fn table(&self, curves: &[(&Values, f64, Reading)], how: &str) -> SieveTable {
        let whole: f64 = curves.iter().map(|curve| curve.1).sum();
        let sum = |i: usize| curves.iter().map(|(_, share, reading)| share / whole * reading.passing[i]).sum::<f64>();
        let mut passing: Vec<f64> = (0..self.sheet.sieves.len()).rev().map(sum).collect();
        // Sums of shares round.
        let mut most = 0.0_f64;
        passing.iter_mut().for_each(|share| {
            most = share.clamp(most, 1.0);
            *share = most;
        });
        let sieves_mm: Vec<f64> = self.sheet.sieves.iter().rev().map(|sieve| sieve.1).collect();
        let parts = curves.iter().map(|(values, share, reading)| {
            let part =
                if curves.len() > 1 { format!("{} % of ", rounded(100.0 * share / whole)) } else { String::new() };
            let Reading { meaning, unit, note, .. } = reading;
            format!("{part}{} is {}, in {}{note}", values.name(), meaning.words(), unit.words())
        });
        let parts: Vec<String> = parts.collect();
        let [finest, coarsest] = [sieves_mm[0], sieves_mm[sieves_mm.len() - 1]].map(rounded);
        let understood = format!(
            "{} sieves of {finest} to {coarsest} mm in {}; {}{how}",
            sieves_mm.len(),
            self.sheet.sieve_name,
            parts.join(", ")
        );
        SieveTable { sieves_mm, passing, understood }
    }

    /// Columns to read with their shares, and how the shares are known.
    fn columns(&self) -> Result<(Vec<Share<'_>>, String), String> {
        if !self.choices.columns.is_empty() {
            let named = self.choices.columns.iter().map(|(column, share)| Ok((self.column(column)?, *share)));
            return Ok((named.collect::<Result<_, String>>()?, String::new()));
        }
        let best = self.candidates();
        if let [one] = best[..] {
            return Ok((vec![(one, 1.0)], String::new()));
        }
        let shared: Vec<(&Values, f64)> = best.iter().filter_map(|values| Some((*values, values.share?))).collect();
        let whole: f64 = shared.iter().map(|column| column.1).sum();
        if shared.len() > 1 && [1.0, 100.0].iter().any(|all| (whole / all - 1.0).abs() < 1e-6) {
            return Ok((shared, "; the table gives the shares".to_owned()));
        }
        if best.is_empty() {
            return Err(format!("no column has numbers to the sieves of {}", self.sheet.sieve_name));
        }
        let names: Vec<String> = best.iter().map(|values| values.name()).collect();
        Err(format!(
            "{} can be the grading; name one beside file, column = {}, or blend them by their shares, blend = {{ {} }}",
            names.join(" and "),
            quoted(best[0]),
            best.iter()
                .map(|values| format!("{} = {}", quoted(values), rounded(1.0 / best.len() as f64)))
                .collect::<Vec<_>>()
                .join(", ")
        ))
    }

    /// The columns of the most direct meaning.
    fn candidates(&self) -> Vec<&Values> {
        let all: Vec<&Values> =
            self.sheet.columns.iter().filter(|values| !values.said.is_foreign && !values.said.is_sieve).collect();
        let level = |values: &&Values| match (values.said.has_meaning, &values.said.meanings[..], values.said.unit) {
            (true, [Meaning::Passing], _) => 0,
            (true, [Meaning::Cumulative], Some(ValueUnit::Mass)) => 2,
            (true, [Meaning::Cumulative], _) => 1,
            (true, _, Some(ValueUnit::Mass)) => 4,
            (true, ..) => 3,
            (false, _, Some(_)) => 5,
            _ => 6,
        };
        let best = all.iter().map(level).min();
        all.into_iter().filter(|values| Some(level(values)) == best).collect()
    }

    fn column(&self, column: &TableColumn) -> Result<&Values, String> {
        let all = &self.sheet.columns;
        let list = || all.iter().map(Values::name).collect::<Vec<_>>().join(", ");
        let found: Vec<&Values> = match column {
            TableColumn::Position(position) => all.iter().filter(|values| values.position == *position).collect(),
            TableColumn::Heading(name) => {
                let name = name.trim().to_lowercase();
                let exact: Vec<&Values> = all.iter().filter(|values| values.heading.to_lowercase() == name).collect();
                let position: Option<usize> = name.parse().ok();
                let part = |values: &&Values| match position {
                    Some(position) => values.position == position,
                    None => values.heading.to_lowercase().contains(&name),
                };
                if exact.is_empty() && !name.is_empty() { all.iter().filter(part).collect() } else { exact }
            }
        };
        let asked = match column {
            TableColumn::Position(position) => position.to_string(),
            TableColumn::Heading(name) => format!("{name:?}"),
        };
        match found[..] {
            [one] => Ok(one),
            [] => Err(format!("it has no column {asked} of numbers; it has {}", list())),
            _ => Err(format!("{} columns are called {asked}; give the position of one: {}", found.len(), list())),
        }
    }

    /// The one curve of a column.
    fn sole(&self, values: &Values) -> Result<Reading, String> {
        let (good, faults) = self.readings(values);
        let Some(first) = good.first() else {
            let reasons: Vec<String> =
                faults.into_iter().map(|(words, fault)| format!("{words}: {}", fault.reason)).collect();
            return Err(format!("{} fits no reading; as {}", values.name(), reasons.join("; as ")));
        };
        if let Some(other) = good.iter().find(|other| difference(&first.passing, &other.passing) > 1e-9) {
            let says = |reading: &Reading| {
                let (_, size) = self.sheet.sieves[self.sheet.sieves.len() - 1];
                let share = rounded(100.0 * reading.passing[reading.passing.len() - 1]);
                format!("{} in {}, so that {share} % passes {size} mm", reading.meaning.words(), reading.unit.words())
            };
            return Err(format!(
                "{} is {}, or {}; say it in the heading, or beside file: means = \"passing\", \"retained\" or \"cumulative-retained\", \
                 unit = \"percent\", \"share\" or \"mass\"",
                values.name(),
                says(first),
                says(other)
            ));
        }
        Ok(first.clone())
    }

    /// Every reading that the words allow and the numbers prove, and the faults of the others.
    fn readings(&self, values: &Values) -> (Vec<Reading>, Vec<(String, Fault)>) {
        let (mut good, mut faults) = (Vec::new(), Vec::new());
        let meanings = self.choices.means.map_or_else(|| values.said.meanings.clone(), |meaning| vec![meaning]);
        let units = self
            .choices
            .unit
            .or(values.said.unit)
            .map_or_else(|| vec![ValueUnit::Percent, ValueUnit::Share, ValueUnit::Mass], |unit| vec![unit]);
        let is_named = values.said.has_meaning || self.choices.means.is_some();
        for &meaning in &meanings {
            for &unit in &units {
                let proof = ColumnProof {
                    sieves: &self.sheet.sieves,
                    values,
                    meaning,
                    unit,
                    is_named,
                    has_unit: units.len() == 1,
                };
                match proof.reading() {
                    Ok(reading) => good.push(reading),
                    Err(fault) => faults.push((format!("{} in {}", meaning.words(), unit.words()), fault)),
                }
            }
        }
        // Masses explain what per cent explains already.
        if good.iter().any(|reading| reading.unit != ValueUnit::Mass) && units.len() > 1 {
            good.retain(|reading| reading.unit != ValueUnit::Mass);
        }
        if let Some(contradicted) = faults.iter().position(|(_, fault)| fault.is_contradiction) {
            faults.swap(0, contradicted);
        }
        faults.truncate(3);
        (good, faults)
    }

    /// The other columns with a meaning say nothing else.
    fn cross_check(&self, chosen: &Values, reading: &Reading) -> Result<(), String> {
        let others = self.sheet.columns.iter().filter(|values| values.said.has_meaning && !values.said.is_foreign);
        for values in others.filter(|values| values.position != chosen.position) {
            let (good, faults) = self.readings(values);
            if good.is_empty() {
                match faults.into_iter().find(|(_, fault)| fault.is_contradiction) {
                    Some((words, fault)) => {
                        return Err(format!(
                            "{} as {words}: {}; mend it, or name the column to read: column = {}",
                            values.name(),
                            fault.reason,
                            quoted(chosen)
                        ));
                    }
                    None => continue,
                }
            }
            if good.iter().all(|other| difference(&other.passing, &reading.passing) > ROUNDED) {
                return Err(self.disagreement(chosen, reading, values, &good[0]));
            }
        }
        Ok(())
    }

    fn disagreement(&self, a: &Values, first: &Reading, b: &Values, second: &Reading) -> String {
        let differs = |i: &usize| (first.passing[*i] - second.passing[*i]).abs() > ROUNDED;
        let i = (0..first.passing.len()).find(differs).unwrap_or(0);
        let (line, size) = self.sheet.sieves[i];
        let [one, other] = [first, second].map(|reading| rounded(100.0 * reading.passing[i]));
        format!(
            "line {line}: {} and {} disagree at {size} mm, where {one} and {other} % pass; mend one, or name the column to read: column = {}",
            a.name(),
            b.name(),
            quoted(a)
        )
    }
}

fn quoted(values: &Values) -> String {
    if values.heading.is_empty() { values.position.to_string() } else { format!("{:?}", values.heading) }
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

/// One column under one meaning and unit.
struct ColumnProof<'a> {
    /// Line and opening of every sieve, from the coarsest.
    sieves: &'a [(usize, f64)],
    values: &'a Values,
    meaning: Meaning,
    unit: ValueUnit,
    /// Whether words give the meaning: then the ends of the curve need not prove it.
    is_named: bool,
    /// Whether words give the unit.
    has_unit: bool,
}

impl ColumnProof<'_> {
    fn reading(&self) -> Result<Reading, Fault> {
        let numbers = self.numbers()?;
        self.unit_fits(&numbers)?;
        let (passing, note) = match self.meaning {
            Meaning::Passing => self.passing(&numbers)?,
            Meaning::Cumulative => self.cumulative(&numbers)?,
            Meaning::Retained => self.retained(&numbers)?,
        };
        Ok(Reading { meaning: self.meaning, unit: self.unit, passing, note })
    }

    fn whole(&self) -> f64 {
        if self.unit == ValueUnit::Percent { 100.0 } else { 1.0 }
    }

    fn at(&self, i: usize) -> String {
        format!("line {}", self.sieves[i].0)
    }

    /// Fines that were washed out, in the unit of the column.
    fn washed(&self) -> Option<(usize, f64)> {
        self.values.washed.filter(|row| self.is_in_the_unit(row))
    }

    /// The initial mass or the sum, in the unit of the column.
    fn total(&self) -> Option<f64> {
        self.values.total.filter(|row| self.is_in_the_unit(row)).map(|(_, total)| total)
    }

    /// Above the sieves stand the masses of the test, whatever the column holds.
    fn is_in_the_unit(&self, (line, _): &(usize, f64)) -> bool {
        self.unit == ValueUnit::Mass || self.sieves.iter().any(|(sieve, _)| sieve < line)
    }

    /// A number for every sieve; blank ones beyond the ends of a curve are its ends.
    fn numbers(&self) -> Result<Vec<f64>, Fault> {
        let numbers = &self.values.numbers;
        if let Some((i, Err(reason))) = numbers.iter().enumerate().find(|(_, number)| number.is_err()) {
            return contradiction(format!("{}: {reason}", self.at(i)));
        }
        if let Some(reason) = &self.values.fault {
            return contradiction(reason.clone());
        }
        let mut filled = Vec::with_capacity(numbers.len());
        let known = |i: usize| numbers[i].as_ref().ok().and_then(Option::as_ref).map(|number| number.value);
        let (first, last) =
            ((0..numbers.len()).find(|&i| known(i).is_some()), (0..numbers.len()).rev().find(|&i| known(i).is_some()));
        let (Some(first), Some(last)) = (first, last) else { return unproved("it is empty") };
        let [coarse, fine] = if self.meaning == Meaning::Passing { [self.whole(), 0.0] } else { [0.0, self.whole()] };
        for (i, number) in numbers.iter().enumerate() {
            let value = match number.as_ref().ok().and_then(Option::as_ref) {
                Some(number) => number.value,
                None if self.meaning == Meaning::Retained || self.unit == ValueUnit::Mass => {
                    None.ok_or_else(|| self.blank(i))?
                }
                None if i < first && known(first) == Some(coarse) => coarse,
                None if i > last && known(last) == Some(fine) => fine,
                None => None.ok_or_else(|| self.blank(i))?,
            };
            filled.push(value);
        }
        Ok(filled)
    }

    fn blank(&self, i: usize) -> Fault {
        let reason =
            format!("{}: no number for the sieve of {} mm; fill it, or delete the line", self.at(i), self.sieves[i].1);
        Fault { reason, is_contradiction: true }
    }

    /// The unit is said, or no other explains the numbers.
    fn unit_fits(&self, numbers: &[f64]) -> Result<(), Fault> {
        let most = numbers.iter().copied().chain(self.values.pan).fold(0.0, f64::max);
        let has_signs = self.values.numbers.iter().any(|number| matches!(number, Ok(Some(number)) if number.percent));
        let bound = |limit: f64| {
            let beyond = numbers.iter().position(|value| *value > limit * (1.0 + 1e-9));
            beyond.map_or(Ok(()), |i| {
                contradiction(format!("{}: {} is more than {limit}, which is all", self.at(i), numbers[i]))
            })
        };
        match self.unit {
            ValueUnit::Percent => {
                bound(100.0)?;
                if most <= 1.0 && most > 0.0 && !has_signs {
                    let reason = "no number is above 1: these are shares; write the heading Passing (share), or per cent from 0 to 100";
                    return contradiction(reason.to_owned());
                }
                Ok(())
            }
            ValueUnit::Share if has_signs => contradiction("numbers have a per cent sign".to_owned()),
            ValueUnit::Share => {
                bound(1.0)?;
                if self.has_unit || most == 1.0 || self.sums_to(numbers, 1.0) {
                    Ok(())
                } else {
                    unproved("no number is 1, which is all")
                }
            }
            ValueUnit::Mass if has_signs => contradiction("numbers have a per cent sign".to_owned()),
            ValueUnit::Mass if self.has_unit => Ok(()),
            ValueUnit::Mass => unproved("no word of the heading says that these are masses"),
        }
    }

    fn sums_to(&self, numbers: &[f64], whole: f64) -> bool {
        let washed = self.washed().map(|(_, fines)| fines);
        let sum: f64 = numbers.iter().copied().chain(self.values.pan).chain(washed).sum();
        (sum / whole - 1.0).abs() <= LOSS
    }

    /// Finds a step against the order from the coarsest sieve: `sign` is -1 for numbers that fall.
    fn ordered(&self, numbers: &[f64], sign: f64, reason: &str) -> Result<(), Fault> {
        match (1..numbers.len()).find(|&i| sign * (numbers[i] - numbers[i - 1]) < -1e-9) {
            Some(i) => contradiction(format!(
                "{}: {} at {} mm after {} at {} mm, but {reason}",
                self.at(i),
                numbers[i],
                self.sieves[i].1,
                numbers[i - 1],
                self.sieves[i - 1].1
            )),
            None => Ok(()),
        }
    }

    fn passing(&self, numbers: &[f64]) -> Result<(Vec<f64>, String), Fault> {
        if self.unit == ValueUnit::Mass {
            return unproved("masses that pass need the whole mass; give them in per cent");
        }
        self.ordered(numbers, -1.0, "more passes a wider sieve")?;
        let whole = self.whole();
        self.has_no_washing("what passes a sieve counts them already")?;
        if self.values.pan.is_some_and(|pan| pan != 0.0) {
            return contradiction("nothing passes the pan".to_owned());
        }
        if !self.is_named && numbers[0] != whole {
            return unproved(format!("the coarsest sieve passes {}, not {whole}", numbers[0]));
        }
        Ok((numbers.iter().map(|number| number / whole).collect(), String::new()))
    }

    fn cumulative(&self, numbers: &[f64]) -> Result<(Vec<f64>, String), Fault> {
        self.ordered(numbers, 1.0, "a finer sieve adds to what the wider ones retain")?;
        self.has_no_washing("only what each sieve retains can be added to them; read that column")?;
        let whole = if self.unit == ValueUnit::Mass { self.all_mass()? } else { self.whole() };
        if let Some(i) = numbers.iter().position(|number| *number > whole * (1.0 + 1e-9)) {
            return contradiction(format!("{}: {} is more than {whole}, which is all", self.at(i), numbers[i]));
        }
        match self.values.pan {
            Some(pan) if (pan / whole - 1.0).abs() > LOSS => {
                return contradiction(format!("the pan has {pan}, not {whole}"));
            }
            None if !self.is_named && numbers[0] != 0.0 => {
                return unproved("neither a pan proves it nor a sieve that retains nothing");
            }
            None if !self.is_named && numbers.last() != Some(&whole) => return unproved("no pan proves it"),
            _ => {}
        }
        Ok((numbers.iter().map(|number| (whole - number) / whole).collect(), String::new()))
    }

    /// The mass of all: the pan's, where masses are added up, or the sum's.
    fn all_mass(&self) -> Result<f64, Fault> {
        match self.values.pan.or(self.total()) {
            Some(mass) if mass > 0.0 => Ok(mass),
            _ => unproved("the whole mass is not known; give a row Pan or Total"),
        }
    }

    /// Refuses fines that were washed out, beside numbers that cannot be added to them.
    fn has_no_washing(&self, why: &str) -> Result<(), Fault> {
        match self.washed() {
            Some((line, fines)) if fines != 0.0 => {
                contradiction(format!("line {line}: {fines} of fines were washed out, but {why}"))
            }
            _ => Ok(()),
        }
    }

    fn retained(&self, numbers: &[f64]) -> Result<(Vec<f64>, String), Fault> {
        let (pan, washed, total) = (self.values.pan, self.washed(), self.total());
        // EN 933-1: the fines are those of the pan and those of the washing.
        let fines = washed.map(|(_, fines)| fines);
        let pan = fines.map_or(pan, |fines| Some(pan.unwrap_or(0.0) + fines));
        let sum: f64 = numbers.iter().copied().chain(pan).sum();
        if let Some(total) = total.filter(|total| (sum / total - 1.0).abs() > LOSS) {
            return contradiction(format!("all rows sum to {}, but the row of the sum has {total}", rounded(sum)));
        }
        let (fines, whole, note) = match (pan, self.unit) {
            // EN 933-1 divides by the initial mass: what was lost in the sieving counts as fines.
            (Some(pan), ValueUnit::Mass) => {
                let lost = total.map_or(0.0, |total| (total - sum).max(0.0));
                let share = rounded(100.0 * lost / (sum + lost));
                let note = if share > 0.0 {
                    format!(" ({share} % lost in the sieving counts as fines)")
                } else {
                    String::new()
                };
                (pan + lost, sum + lost, note)
            }
            (None, ValueUnit::Mass) => match total {
                Some(total) => ((total - sum).max(0.0), total.max(sum), String::new()),
                None => return unproved("the whole mass is not known; give a row Pan or Total"),
            },
            (Some(pan), _) if self.sums_to(numbers, self.whole()) => (pan, sum, String::new()),
            (None, _) if self.sums_to(numbers, self.whole()) => (0.0, sum, String::new()),
            (Some(_), _) => return contradiction(format!("all rows sum to {}, not {}", rounded(sum), self.whole())),
            (None, _) if sum > self.whole() => {
                return contradiction(format!("all rows sum to {}, more than {}", rounded(sum), self.whole()));
            }
            (None, _) if !self.is_named => {
                return unproved(format!("all rows sum to {}, not {}", rounded(sum), self.whole()));
            }
            (None, _) => {
                let rest = self.whole() - sum;
                let share = rounded(100.0 * rest / self.whole());
                (rest, self.whole(), format!(" (no row for the pan: the remaining {share} % passes the finest sieve)"))
            }
        };
        if whole <= 0.0 {
            return contradiction("all rows are 0".to_owned());
        }
        let mut finer = fines;
        let mut passing: Vec<f64> = Vec::with_capacity(numbers.len());
        for retained in numbers.iter().rev() {
            passing.push(finer);
            finer += retained;
        }
        // The last sum is all: a sieve that retains nothing passes exactly 1.
        passing.iter_mut().for_each(|share| *share /= finer);
        passing.reverse();
        Ok((passing, note))
    }
}
