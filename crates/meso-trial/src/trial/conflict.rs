//! Supports that contradict each other: a node has one place, so no two supports may give it two.
//!
//! A plate holds its nodes along the axis of its side, and a glued one holds them along all axes. A pressure holds no node,
//! but a plate over the whole side leaves it nothing to press on. What the sides show is refused before a specimen is
//! packed ([`validate`], [`suits`]), and the rest by the nodes of the mesh ([`agree`]).

use crate::error::TEST;
use crate::trial::load::{Rule, Side, Strip, SupportSpec};
use crate::trial::setup::word;
use meso_concrete::OutOfRange;
use meso_concrete::specimen::Specimen;

/// Part of two widths by which strips overlap where they only touch, by rounding.
const TOUCHES: f64 = 1e-9;

/// Way of a support along one axis.
#[derive(Clone, Copy)]
struct Way {
    /// Its way for each mm of the path.
    moves: f64,
    /// Whether a servo moves it.
    is_led: bool,
}

impl Way {
    fn is_of(self, other: Self) -> bool {
        !self.is_led && !other.is_led && self.moves == other.moves
    }
}

impl SupportSpec {
    /// Axis of its side; the mantle has none.
    fn axis(&self) -> Option<usize> {
        self.on.bit().map(|bit| bit / 2)
    }

    /// Its way along `axis` on the nodes that it meets, if it holds them along that axis.
    fn way(&self, axis: usize) -> Option<Way> {
        let is_led = self.pressure_mpa != 0.0 || self.stress_ratio.is_some() || self.drive.is_some();
        match self.rule {
            Rule::Pressure => None,
            Rule::Plate | Rule::Glued if self.axis() == Some(axis) => Some(Way { moves: self.moves, is_led }),
            Rule::Plate => None,
            Rule::Glued => Some(Way { moves: 0.0, is_led: false }),
        }
    }

    /// The axis along which it and `other` give two places to a node that both meet.
    fn contradicts(&self, other: &Self) -> Option<usize> {
        let differ = |axis: &usize| self.way(*axis).zip(other.way(*axis)).is_some_and(|(own, other)| !own.is_of(other));
        let acts_alike = self.rule == other.rule && self.friction == other.friction;
        let same_side = self.axis().filter(|_| self.on == other.on && !acts_alike);
        (0..3).find(differ).or(same_side.filter(|_| self.is_rigid() && other.is_rigid()))
    }

    fn is_rigid(&self) -> bool {
        self.rule != Rule::Pressure
    }

    /// Whether both lie on one side, and one of them on some of the other's part of it.
    fn overlaps(&self, other: &Self) -> bool {
        let meets = |axis, one: &Strip, other: &Strip| {
            let [[from, to], [low, high]] = [one, other].map(|strip| strip.ends_mm(axis, 0.0));
            let touches = TOUCHES * (to - from).min(high - low);
            to - low > touches && high - from > touches
        };
        let covers = |one: &Strip, other: &Strip| (0..3).all(|axis| meets(axis, one, other));
        let strips = self.strip.as_ref().zip(other.strip.as_ref());
        self.on == other.on && strips.is_none_or(|(one, other)| covers(one, other))
    }

    /// Whether a plate over a whole side takes the side from a pressure.
    fn covers(&self, pressure: &Self) -> bool {
        let is_on_mantle = pressure.on == Side::Mantle && self.axis().is_some_and(|axis| axis < 2);
        self.strip.is_none() && (self.on == pressure.on || is_on_mantle)
    }

    /// The part of the edge with a side across `other` that it lies on, mm from the middle along the third axis; `None` if
    /// its strip does not reach the edge of a box.
    fn on_edge(&self, size_mm: &[f64; 3], other: usize, is_upper: bool) -> Option<[f64; 2]> {
        let along = 3 - self.axis()? - other;
        let whole = 0.5 * size_mm[along];
        let Some(strip) = self.strip else { return Some([-whole, whole]) };
        let [[from, to], [low, high]] = [along, other].map(|axis| strip.ends_mm(axis, 0.0));
        let half = 0.5 * size_mm[other] * (1.0 - TOUCHES);
        let reaches = if is_upper { high >= half } else { low <= -half };
        let lies_across = strip.axis as usize != 3 - along - other;
        (reaches && lies_across).then_some([from.max(-whole), to.min(whole)])
    }

    /// Whether it and `other` share a part of an edge of a box.
    fn shares_edge(&self, other: &Self, size_mm: &[f64; 3]) -> bool {
        let (Some(own_bit), Some(other_bit)) = (self.on.bit(), other.on.bit()) else { return false };
        if own_bit / 2 == other_bit / 2 {
            return false;
        }
        let own = self.on_edge(size_mm, other_bit / 2, other_bit % 2 == 1);
        let others = other.on_edge(size_mm, own_bit / 2, own_bit % 2 == 1);
        own.zip(others).is_some_and(|(own, other)| own[0] < other[1] && other[0] < own[1])
    }

    /// Its rule, side and way in words.
    fn is_what(&self) -> String {
        let rule = match self.rule {
            Rule::Plate => "a plate on",
            Rule::Glued => "glued to",
            Rule::Pressure => "a pressure on",
        };
        let led = match (self.rule, self.stress_ratio) {
            (Rule::Pressure, _) => return format!("{rule} {}", word(&self.on)),
            (_, Some(ratio)) => format!("stress_ratio = {ratio}"),
            _ if self.drive.is_some() => "a drive".to_owned(),
            _ if self.pressure_mpa != 0.0 => format!("pressure_mpa = {}", self.pressure_mpa),
            _ => format!("moves = {}", self.moves),
        };
        let rubs = if self.rule == Rule::Plate { format!(", friction = {}", self.friction) } else { String::new() };
        format!("{rule} {} with {led}{rubs}", word(&self.on))
    }

    /// The error of two supports that hold the same nodes along `axis`.
    fn error(&self, other: &Self, axis: usize) -> OutOfRange {
        let axis = ["x", "y", "z"][axis];
        let why = format!(
            "{} is {} and holds the same nodes along {axis}, but a node has one place: leave one of them out, or give them \
             strips that share no node",
            other.name,
            other.is_what()
        );
        TEST.error(format!("supports.{}", self.name), self.is_what(), why)
    }
}

/// Every two of some supports, in their order.
fn pairs(supports: &[SupportSpec]) -> impl Iterator<Item = (&SupportSpec, &SupportSpec)> {
    supports.iter().enumerate().flat_map(|(place, one)| supports[place + 1..].iter().map(move |other| (one, other)))
}

/// Refuses supports that contradict each other on any specimen.
pub(super) fn validate(supports: &[SupportSpec]) -> Result<(), OutOfRange> {
    for (one, other) in pairs(supports) {
        let (rigid, pressure) = if one.is_rigid() { (one, other) } else { (other, one) };
        match (one.is_rigid(), other.is_rigid()) {
            (true, true) if one.overlaps(other) => return Err(other.error(one, one.axis().unwrap_or_default())),
            (true, false) | (false, true) if rigid.covers(pressure) => {
                let why = format!(
                    "{} is {} and covers that side, so that nothing is left to press on: leave one of them out; a servo \
                     presses a plate with {} MPa where pressure_mpa = {} stands in the plate",
                    rigid.name,
                    rigid.is_what(),
                    pressure.pressure_mpa,
                    pressure.pressure_mpa
                );
                return Err(TEST.error(format!("supports.{}", pressure.name), pressure.is_what(), why));
            }
            _ => {}
        }
    }
    as_one(supports)
}

/// Refuses supports that carry the specimen along: all that hold it along the path's axis move alike.
fn as_one(supports: &[SupportSpec]) -> Result<(), OutOfRange> {
    let Some(first) = supports.iter().find(|support| support.moves != 0.0) else { return Ok(()) };
    let Some(axis) = first.axis() else { return Ok(()) };
    let holding = || supports.iter().filter_map(|support| Some((support, support.way(axis)?)));
    let ends = holding().fold([false; 2], |[low, high], (support, _)| {
        let is_upper = support.on.bit().is_some_and(|bit| bit == 2 * axis + 1);
        let is_lower = support.on.bit() == Some(2 * axis);
        [low || is_lower, high || is_upper]
    });
    let is_carried = ends == [true; 2] && holding().all(|(_, way)| !way.is_led && way.moves == first.moves);
    let why = "all supports along its axis move alike and carry the specimen along unstrained; let one of them rest \
               (moves = 0), or move the other way";
    TEST.require(format!("supports.{}.moves", first.name), first.moves, !is_carried, why)
}

/// Refuses supports that contradict each other at an edge of a specimen of six sides.
pub(super) fn suits(supports: &[SupportSpec], specimen: &Specimen) -> Result<(), OutOfRange> {
    let is_box = matches!(
        specimen,
        Specimen::Cube { .. } | Specimen::Box { .. } | Specimen::Prism { .. } | Specimen::NotchedPrism { .. }
    );
    let size_mm: [f64; 3] = specimen.aabb().size().into();
    for (one, other) in pairs(supports).filter(|(one, other)| is_box && one.shares_edge(other, &size_mm)) {
        if let Some(axis) = one.contradicts(other) {
            return Err(other.error(one, axis));
        }
    }
    Ok(())
}

/// Refuses supports that give two places to a node; `members` has a row of a node and the number of its support for each
/// node that a support meets.
pub(super) fn agree(supports: &[SupportSpec], mut members: Vec<(u32, u32)>) -> Result<(), OutOfRange> {
    members.sort_unstable();
    let of = |row: &(u32, u32)| &supports[row.1 as usize];
    for same in members.chunk_by(|one, other| one.0 == other.0) {
        for (place, one) in same.iter().enumerate() {
            for other in &same[place + 1..] {
                if let Some(axis) = of(one).contradicts(of(other)) {
                    return Err(of(other).error(of(one), axis));
                }
            }
        }
    }
    Ok(())
}
