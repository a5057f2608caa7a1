//! Named tests as supports, and the scales of their curves.

use crate::error::{TEST, TrialError};
use crate::sample::Geometry;
use crate::trial::conflict;
use crate::trial::load::{Along, Gauge, Rule, Side, Strip, SupportSpec, Turn, TurnOf};
use crate::trial::setup::word;
use crate::trial::{Control, Test, TestKind};
use meso_concrete::OutOfRange;
use meso_concrete::specimen::Specimen;
use std::f64::consts::PI;

/// The supports of a test, and the scales from path and force to strain and stress.
#[derive(Clone, Debug, PartialEq)]
pub struct Rig {
    /// In the order of their columns.
    pub supports: Vec<SupportSpec>,
    /// The axis that the supports move along: 0, 1 or 2.
    pub axis: usize,
    /// Path over this is the strain, mm.
    pub length_mm: f64,
    /// Force over this is the stress, mm2.
    pub section_mm2: f64,
    /// Area that breaks, mm2: energies are given over it.
    pub breaking_mm2: f64,
}

impl Rig {
    /// Refuses supports that give two places to a node; `members` has a row of a node and the number of its support for each
    /// node that a support meets.
    ///
    /// # Errors
    /// Two supports that contradict each other, both by name.
    pub fn agree(&self, members: Vec<(u32, u32)>) -> Result<(), OutOfRange> {
        conflict::agree(&self.supports, members)
    }
}

/// Width of a splitting strip over the diameter: EN 12390-6 has strips of 10 mm on cylinders of 100 and 150 mm.
const STRIP: f64 = 0.1;
/// Enough for plates to keep up with strains of 1e-3.
const SEATING_MPA: f64 = 0.2;
/// Coulomb's coefficient of plates.
const PLATES: f64 = 0.1;
/// Coulomb's coefficient of strips: EN 12390-6 has hardboard, which does not slide. Strips that slide are driven into the
/// specimen like a wedge. A cylinder of 24 mm split at 0.88 of its strength in tension with 0.1, and at 1.02 with 0.5 and 1.
const STICKING: f64 = 0.5;
/// Linear strain of the aggregates in an expansion test that names none.
pub(super) const SWELLING: f64 = 1e-4;
/// Width of a roller over the beam's depth.
const ROLLER: f64 = 0.05;
/// Span over depth of a beam that one roller presses, at most (EN 14651: 500 mm over 150 mm).
const SPAN: f64 = 10.0 / 3.0;
/// The same of a beam that two rollers press (ASTM C78 and EN 12390-5: three depths).
const THIRD_POINT_SPAN: f64 = 3.0;

impl Test {
    /// The rig of the test on a specimen of this `geometry`.
    pub fn rig(&self, geometry: &Geometry) -> Result<Rig, TrialError> {
        let [.., z] = geometry.size_mm;
        let of = |supports: Vec<SupportSpec>, axis, length_mm, section_mm2| Rig {
            supports,
            axis,
            length_mm,
            section_mm2,
            breaking_mm2: section_mm2,
        };
        let along_z = |supports: Vec<SupportSpec>| of(supports, 2, z, geometry.section_mm2);
        if !self.supports.is_empty() {
            let axis = self.moving_axis()?;
            let length_mm = geometry.size_mm[axis];
            let section_mm2 = geometry.section_mm2 * z / length_mm;
            return Ok(of(self.supports.clone(), axis, length_mm, section_mm2));
        }
        Ok(match self.kind {
            TestKind::Compression | TestKind::Cyclic => along_z(self.plates(self.seating_mpa()).to_vec()),
            TestKind::Tension => along_z(self.pair(Rule::Glued, 0.5, 0.0).to_vec()),
            TestKind::Triaxial => along_z(self.confined()),
            TestKind::Biaxial => along_z(self.pressed_twice()),
            TestKind::Splitting => self.split(geometry)?,
            TestKind::Bending | TestKind::FourPoint => self.bent(geometry)?,
            TestKind::Expansion => along_z(Vec::new()),
            TestKind::Shear => self.sheared(geometry),
            TestKind::Hopkinson
            | TestKind::HopkinsonSplitting
            | TestKind::Spall
            | TestKind::Drop
            | TestKind::Impact => self.fast_rig(geometry)?,
        })
    }

    /// Finds out whether a specimen can have the test, before it is packed.
    ///
    /// # Errors
    /// A specimen without the notch, the room or the sides that the test needs, with a remedy.
    pub fn suits(&self, specimen: &Specimen) -> Result<(), TrialError> {
        let geometry = Geometry::of(specimen);
        if self.kind.splits() && self.supports.is_empty() && geometry.notch_mm > 0.0 {
            let why = "the specimen has a notch where it splits; take a cylinder, cube or box";
            return Err(TEST.error("kind", word(&self.kind), why).into());
        }
        let is_round = matches!(specimen, Specimen::Cylinder { .. } | Specimen::Sphere { .. });
        let is_flat = matches!(self.kind, TestKind::Biaxial | TestKind::Shear) || self.kind.is_beam();
        if is_flat && is_round && self.supports.is_empty() {
            let name = word(&self.kind);
            let why = "the specimen has no plane sides for its plates; take a cube, box or prism";
            return Err(TEST.error("kind", name, why).into());
        }
        self.suits_drop(&geometry, is_round)?;
        let rig = self.rig(&geometry)?;
        self.suits_notch(&geometry)?;
        self.gauges().iter().try_for_each(|gauge| gauge.suits(&geometry.size_mm))?;
        rig.supports.iter().try_for_each(|support| support.suits(&geometry.size_mm))?;
        conflict::suits(&rig.supports, specimen)?;
        let has_own_shape = matches!(specimen, Specimen::Mesh { .. });
        let is_notched = has_own_shape || geometry.notch_mm > 0.0 && geometry.upper_notch_mm > 0.0;
        if self.kind == TestKind::Shear && self.supports.is_empty() && !is_notched {
            let why = "the specimen has no two notches, whose tips the sheared plane joins; take a notched-prism with an \
                       upper_notch_depth_mm, as in mesocrete init double-notched-100, or supports of your own";
            return Err(TEST.error("kind", "shear", why).into());
        }
        Ok(())
    }

    /// Finds out whether a gauge measures the openings of turns, and whether the specimen has the notch that it spans.
    fn suits_notch(&self, geometry: &Geometry) -> Result<(), TrialError> {
        let gauges = self.gauges();
        let over = |gauge: &Gauge| if let Gauge::CrackMouth { over_mm, .. } = gauge { Some(*over_mm) } else { None };
        let mouths: Vec<Option<f64>> = gauges.iter().filter_map(over).collect();
        if mouths.is_empty() && self.turns().iter().any(|turn| turn.of == TurnOf::Opening) {
            let why = "no gauge measures an opening; add one of kind crack-mouth, or take turns at strains";
            return Err(TEST.error("turns.of", "opening", why).into());
        }
        if geometry.notch_mm > 0.0 || self.kind.is_beam() || mouths.iter().all(Option::is_some) {
            return Ok(());
        }
        let key = if self.control() == Control::CrackMouth { "control" } else { "gauges.kind" };
        let why =
            "the specimen has no notch, whose mouth opens; take a notched-prism, a gauge with over_mm, or bending";
        Err(TEST.error(key, "crack-mouth", why).into())
    }

    /// The axis of the sides whose supports follow the path.
    fn moving_axis(&self) -> Result<usize, TrialError> {
        let is_free = !self.has_path() && !self.is_fast();
        if is_free {
            return Ok(2);
        }
        let moving = self.supports.iter().find(|support| support.moves != 0.0 || support.drive.is_some());
        let bit = moving.and_then(|support| support.on.bit());
        let why = "no support moves; give one of them moves = 0.5 or -0.5";
        bit.map(|bit| bit / 2).ok_or_else(|| TEST.error("supports", self.supports.len(), why).into())
    }

    /// The lower and the upper support across z; `moves` is the upper one's.
    fn pair(&self, rule: Rule, moves: f64, pressure_mpa: f64) -> [SupportSpec; 2] {
        let friction = if rule == Rule::Plate { self.friction() } else { 0.0 };
        [("bottom", Side::ZMin, -moves), ("top", Side::ZMax, moves)].map(|(name, on, moves)| SupportSpec {
            rule,
            friction,
            moves,
            pressure_mpa,
            ..SupportSpec::new(name, on)
        })
    }

    fn plates(&self, pressure_mpa: f64) -> [SupportSpec; 2] {
        self.pair(Rule::Plate, -0.5, pressure_mpa)
    }

    /// Stress with which plates follow phases that swell or shrink, so that the specimen is free until the path begins, MPa.
    fn seating_mpa(&self) -> f64 {
        if self.expansion.is_some() { SEATING_MPA } else { 0.0 }
    }

    /// All sides under pressure, then plates. Under lateral tension the plates begin without a force, since they cannot pull.
    fn confined(&self) -> Vec<SupportSpec> {
        let pressure_mpa = self.pressure_mpa();
        let mantle = SupportSpec { rule: Rule::Pressure, pressure_mpa, ..SupportSpec::new("mantle", Side::Mantle) };
        self.plates(pressure_mpa.max(0.0)).into_iter().chain([mantle]).collect()
    }

    /// Plates across z, and plates across x whose stress follows.
    fn pressed_twice(&self) -> Vec<SupportSpec> {
        let (friction, stress_ratio) = (self.friction(), Some(self.stress_ratio()));
        let side = |name, on| SupportSpec { friction, stress_ratio, ..SupportSpec::new(name, on) };
        self.plates(self.seating_mpa())
            .into_iter()
            .chain([side("left", Side::XMin), side("right", Side::XMax)])
            .collect()
    }

    /// Strips along y on the sides across x: 2 F / (pi l d) is the stress.
    pub(super) fn split(&self, geometry: &Geometry) -> Result<Rig, TrialError> {
        let [x, y, z] = geometry.size_mm;
        let width_mm = self.strip_mm.unwrap_or(STRIP * x);
        let accepted = format!("a strip must leave half of the side free; take {} mm at most", 0.5 * y);
        TEST.require("strip_mm", width_mm, width_mm <= 0.5 * y, accepted)?;
        // A cylinder lies on its mantle, and its axis is z. A cube has a strip along z, too.
        let strip = Some(Strip::new(Along::Y, 0.0, width_mm));
        let friction = self.friction();
        let pressed = |name, on, moves| SupportSpec { strip, friction, moves, ..SupportSpec::new(name, on) };
        Ok(Rig {
            supports: vec![pressed("left", Side::XMin, 0.5), pressed("right", Side::XMax, -0.5)],
            axis: 0,
            length_mm: x,
            section_mm2: 0.5 * PI * x * z,
            breaking_mm2: x * z,
        })
    }

    /// Plates glued to the upper side left of the notches and to the lower side right of them, as on the double-notched specimens
    /// of Reinhardt and Xu (2000): force over the plane between the notches is the stress, and way over the height the strain.
    fn sheared(&self, geometry: &Geometry) -> Rig {
        let ([x, y, z], notch) = (geometry.size_mm, geometry.notch_at_mm);
        let half = |name, on, end: f64, moves| SupportSpec {
            strip: Some(Strip::new(Along::X, 0.5 * (notch + end), (end - notch).abs())),
            rule: Rule::Glued,
            moves,
            ..SupportSpec::new(name, on)
        };
        let supports = vec![half("bottom", Side::ZMin, 0.5 * x, 0.5), half("top", Side::ZMax, -0.5 * x, -0.5)];
        let section_mm2 = y * (z - geometry.notch_mm - geometry.upper_notch_mm);
        Rig { supports, axis: 2, length_mm: z, section_mm2, breaking_mm2: section_mm2 }
    }

    /// A beam on two rollers, pressed by a third one, or by two at its third points. With a from a roller below to the next
    /// one above, and h as the depth above the notch, 3 F a / (b h^2) is the stress and 3 h w / (a (3 l - 4 a)) the strain:
    /// 3 F l / (2 b h^2) and 6 h w / l^2 by one roller, F l / (b h^2) and 27 h w / (5 l^2) by two.
    pub(super) fn bent(&self, geometry: &Geometry) -> Result<Rig, TrialError> {
        let [x, y, z] = geometry.size_mm;
        let span = self.span_mm(geometry);
        let why = format!("a beam must be longer than 10/9 of its depth, {z} mm; take a longer prism");
        TEST.require("kind", word(&self.kind), 0.9 * x > z, why)?;
        let accepted = format!(
            "the rollers must stand on the beam, {x} mm long, and its depth of {z} mm apart; take {:.3}",
            0.9 * x
        );
        TEST.require("span_mm", span, span < x && span >= z, accepted)?;
        let is_four = self.kind == TestKind::FourPoint;
        let arm = if is_four { span / 3.0 } else { 0.5 * span };
        let width_mm = self.strip_mm.unwrap_or(ROLLER * z);
        let accepted =
            format!("rollers must be narrower than the {arm} mm from one to the next; take {:.3} mm", ROLLER * z);
        TEST.require("strip_mm", width_mm, width_mm < arm, accepted)?;
        let roller = |name, on, at_mm, moves| SupportSpec {
            strip: Some(Strip::new(Along::X, at_mm, width_mm)),
            moves,
            ..SupportSpec::new(name, on)
        };
        let height = z - geometry.notch_mm;
        let above = [("load_left", -0.5 * arm), ("load_right", 0.5 * arm)];
        let above = if is_four { &above[..] } else { &[("load", 0.0)] };
        let below = [("left", -0.5 * span), ("right", 0.5 * span)];
        let at_rest = below.iter().map(|&(name, at_mm)| roller(name, Side::ZMin, at_mm, 0.0));
        let moving = above.iter().map(|&(name, at_mm)| roller(name, Side::ZMax, at_mm, -1.0));
        Ok(Rig {
            supports: at_rest.chain(moving).collect(),
            axis: 2,
            length_mm: arm * (3.0 * span - 4.0 * arm) / (3.0 * height),
            section_mm2: y * height * height / (3.0 * arm),
            breaking_mm2: y * height,
        })
    }

    /// Distance of a beam's rollers, mm.
    pub fn span_mm(&self, geometry: &Geometry) -> f64 {
        let [x, _, z] = geometry.size_mm;
        let depths = if self.kind == TestKind::FourPoint { THIRD_POINT_SPAN } else { SPAN };
        let own = || self.plate_span_mm(geometry).unwrap_or((depths * z).min(0.9 * x));
        self.span_mm.unwrap_or_else(own)
    }

    /// Width of the strips of a splitting test, mm; none for other tests and supports of a file.
    pub fn splitting_strip_mm(&self, geometry: &Geometry) -> Option<f64> {
        let is_split = self.kind.splits() && self.supports.is_empty();
        is_split.then(|| self.strip_mm.unwrap_or(STRIP * geometry.size_mm[0]))
    }

    /// Coulomb's coefficient between plates and specimen.
    pub fn friction(&self) -> f64 {
        self.friction.unwrap_or(if self.kind.splits() { STICKING } else { PLATES })
    }

    /// Lateral pressure, MPa.
    pub fn pressure_mpa(&self) -> f64 {
        self.pressure_mpa.unwrap_or(5.0)
    }

    /// Lateral over axial stress.
    pub fn stress_ratio(&self) -> f64 {
        self.stress_ratio.unwrap_or(1.0)
    }
}

impl SupportSpec {
    /// A smooth plate at rest.
    pub fn new(name: &str, on: Side) -> Self {
        Self {
            name: name.to_owned(),
            on,
            strip: None,
            rule: Rule::Plate,
            friction: 0.0,
            moves: 0.0,
            pressure_mpa: 0.0,
            stress_ratio: None,
            drive: None,
        }
    }
}

/// Gauges of a named test.
pub(super) fn gauges(kind: TestKind) -> Vec<Gauge> {
    match kind {
        TestKind::Triaxial | TestKind::Biaxial | TestKind::Cyclic => {
            vec![Gauge::LateralStrain { name: "lateral_strain".to_owned() }]
        }
        TestKind::Expansion => [("strain_x", Along::X), ("strain_y", Along::Y), ("strain_z", Along::Z)]
            .map(|(name, axis)| Gauge::Sides { name: name.to_owned(), axis })
            .to_vec(),
        TestKind::Bending | TestKind::FourPoint => vec![Gauge::mouth()],
        TestKind::Spall => vec![Gauge::Side { name: "face".to_owned(), on: Side::ZMax }],
        TestKind::Compression | TestKind::Tension | TestKind::Splitting | TestKind::Shear => Vec::new(),
        TestKind::Hopkinson | TestKind::HopkinsonSplitting | TestKind::Drop | TestKind::Impact => Vec::new(),
    }
}

/// Parts of the last strain at which a cyclic test turns.
const CYCLES: [f64; 4] = [0.2, 0.35, 0.5, 0.7];

/// Turns of a cyclic test that ends at `strain`; it turns back at 1 MPa.
pub(super) fn cycles(strain: f64) -> Vec<Turn> {
    // The plates stay on: a plate that returns strikes the specimen.
    let back = Turn { at: 1.0, of: TurnOf::Stress };
    let there = |share: f64| Turn { at: share * strain, of: TurnOf::Strain };
    CYCLES.into_iter().flat_map(|share| [there(share), back]).chain([there(1.0)]).collect()
}
