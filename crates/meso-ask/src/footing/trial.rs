//! Trials on a small cube of the packing: which size of elements keeps the phases?
//!
//! A cube of two and a half of the largest aggregates takes a second to pack and mesh. Its phase errors are between half and twice
//! those of a large specimen, so a size is advised where they are half of what is accepted.

use super::{Footing, leave_room};
use meso_core::Watch;
use meso_core::mesh::{ElementSize, MeshError, MeshOptions, MeshTable, MethodName, PhaseOff, Purpose, Tools, build};
use meso_core::packing::StopReason;
use meso_core::specimen::{Periodic, Specimen};
use meso_core::{Model, Spec, pack};

/// Edge of the cube over the largest body.
const EDGE: f64 = 2.5;
/// Phase error that a size is advised for, as a share: half the accepted one.
const KEPT: f64 = PhaseOff::ACCEPTED / 2.0;
/// Sizes are tried from this share of the smallest aggregate down.
const COARSEST: f64 = 0.8;
/// No mesh of a trial has more cubes of one element: 60,000 take some 8 s.
const MOST_CUBES: f64 = 60_000.0;
/// Sizes that users write, in every power of ten.
const DIGITS: [f64; 9] = [8.0, 6.0, 5.0, 4.0, 3.0, 2.5, 2.0, 1.5, 1.25];

/// A packing of which a small cube is meshed.
pub(super) struct Trial<'a> {
    pub(super) footing: &'a Footing,
    pub(super) spec: &'a Spec,
    /// Whether the packing is still to be made, with the gaps that its mesh needs.
    pub(super) leaves_room: bool,
    pub(super) watch: &'a dyn Watch,
}

/// What a trial found.
#[derive(Clone, Copy)]
pub(super) struct Tried {
    pub(super) size_mm: f64,
    pub(super) gap_mm: f64,
    pub(super) off: PhaseOff,
}

/// The largest size of elements, mm, that keeps every phase of `spec` within 5 % on a small cube. `leaves_room` says that the
/// packing is still to be made, with the gaps that its mesh needs.
///
/// # Errors
/// Options out of their range, and a spec of which no size that was tried keeps the phases.
pub fn element_size(
    table: &MeshTable,
    purpose: Purpose,
    spec: &Spec,
    leaves_room: bool,
    watch: &dyn Watch,
) -> Result<f64, MeshError> {
    let table = MeshTable { element_size_mm: Some(ElementSize::Mm(spec.grading.d_min_mm)), ..table.clone() };
    let options = table.resolve(purpose, &spec.itz)?;
    let footing = Footing { purpose, options, accepts_phase_error: false };
    let trial = Trial { footing: &footing, spec, leaves_room, watch };
    trial.found().map(|tried| tried.size_mm).ok_or_else(|| trial.nothing_found())
}

/// The options of a mesh of `spec`, with the size that `auto` means; `leaves_room` as in [`element_size`].
///
/// # Errors
/// See [`element_size`].
pub fn options(
    table: &MeshTable,
    purpose: Purpose,
    spec: &Spec,
    leaves_room: bool,
    watch: &dyn Watch,
) -> Result<MeshOptions, MeshError> {
    let tried = table.is_auto().then(|| element_size(table, purpose, spec, leaves_room, watch)).transpose()?;
    let options = table.clone().with_tried(tried).resolve(purpose, &spec.itz)?;
    options.validate(&spec.specimen)?;
    Ok(options)
}

impl Trial<'_> {
    /// Edge of the cube, mm.
    pub(super) fn cube_mm(&self) -> f64 {
        EDGE * self.spec.largest_body_mm()
    }

    /// The spec of the small cube; a specimen that is no larger stays.
    fn small(&self) -> Spec {
        let side_mm = self.cube_mm();
        let is_small = self.spec.specimen.volume() <= side_mm.powi(3);
        let cube = Specimen::Cube { side_mm, periodic: Periodic::default() };
        Spec { specimen: if is_small { self.spec.specimen.clone() } else { cube }, ..self.spec.clone() }
    }

    /// Packs and meshes the cube; `None` where that fails or the cube falls short of its fraction.
    pub(super) fn of(&self, options: &MeshOptions) -> Option<Tried> {
        let mut spec = self.small();
        if self.leaves_room {
            leave_room(&mut spec, options, self.footing.purpose).ok()?;
        }
        let watch = Unseen(self.watch);
        let model = pack(&spec, &watch).ok().filter(|model| model.report.stop_reason == StopReason::TargetReached)?;
        self.off(&model, options, &watch).map(|off| Tried {
            size_mm: options.element_size_mm,
            gap_mm: spec.placement.min_gap_mm,
            off,
        })
    }

    fn off(&self, model: &Model, options: &MeshOptions, watch: &dyn Watch) -> Option<PhaseOff> {
        let mesh = build(model, options, &Tools { watch, ..Tools::default() }).ok()?;
        PhaseOff::accept(&mesh, model, options, f64::INFINITY).ok()?
    }

    /// The sizes below the one that is asked for, the largest first.
    fn sizes(&self) -> impl Iterator<Item = MeshOptions> {
        let options = &self.footing.options;
        let most = options.element_size_mm.min(COARSEST * self.spec.grading.d_min_mm * (1.0 + 1e-9));
        let (cube, is_asked) = (self.small().specimen, options.element_size_mm);
        // From 10 m down to micrometres.
        let all = (-3..4).rev().flat_map(|power| DIGITS.map(|digit| nice(digit, power)));
        all.filter(move |size| *size <= most && *size < is_asked)
            .map(|element_size_mm| MeshOptions { element_size_mm, ..options.clone() })
            .take_while(move |options| options.cubes(&cube) <= MOST_CUBES)
    }

    /// The largest size that keeps the phases. gmsh is not tried.
    pub(super) fn found(&self) -> Option<Tried> {
        if self.footing.options.method.name() == MethodName::Conforming {
            return None;
        }
        let tried = |options: MeshOptions| if self.watch.stops() { None } else { self.of(&options) };
        self.sizes().filter_map(tried).find(|tried| tried.off.error().abs() <= KEPT)
    }

    /// Adds to the refusal of a phase a size that was tried, with the gaps of the packing or with those that a test needs.
    pub(super) fn advised(&self, error: MeshError) -> MeshError {
        let with_room = Trial { leaves_room: true, ..*self };
        let is_open = !self.leaves_room && self.spec.placement.min_gap_mm == 0.0;
        let found = self.found().or_else(|| if is_open { with_room.found() } else { None });
        match (error, found) {
            (MeshError::PhaseError { phase, meshed, exact, tried_mm, ways }, Some(tried)) => {
                let ways = ways.with_tried(tried.size_mm, &self.finding(&tried));
                MeshError::PhaseError { phase, meshed, exact, tried_mm, ways }
            }
            (error, _) => error,
        }
    }

    fn finding(&self, tried: &Tried) -> String {
        let percent = 100.0 * tried.off.error().abs();
        let gaps = match (tried.gap_mm, self.spec.placement.min_gap_mm) {
            (0.0, _) => String::new(),
            (gap, 0.0) => format!(", packed with min_gap_mm = {gap}"),
            (gap, _) => format!(" with gaps of {gap} mm"),
        };
        let specimen = match self.spec.specimen.volume() > self.cube_mm().powi(3) {
            true => format!("a cube of {} mm", self.cube_mm()),
            false => "this specimen".to_owned(),
        };
        format!("tried on {specimen}{gaps}: every phase within {percent:.1} %")
    }

    fn nothing_found(&self) -> MeshError {
        let accepted = match self.spec.placement.min_gap_mm {
            0.0 if !self.leaves_room => {
                "no size that was tried keeps every phase within 5 %; pack with gaps, or give a number"
            }
            _ => "no size that was tried keeps every phase within 5 %; give a number",
        };
        MeshError::option("element_size_mm", "auto", accepted)
    }
}

/// A size of one or two digits, mm, without rounding errors in its last place.
fn nice(digit: f64, power: i32) -> f64 {
    if power < 0 { digit / 10f64.powi(-power) } else { digit * 10f64.powi(power) }
}

/// The watch of a trial: it stops with the run, and shows nothing.
struct Unseen<'a>(&'a dyn Watch);

impl Watch for Unseen<'_> {
    fn stops(&self) -> bool {
        self.0.stops()
    }

    fn abandoned(&self) -> Option<std::sync::Arc<std::sync::atomic::AtomicBool>> {
        self.0.abandoned()
    }

    fn seconds(&self) -> f64 {
        self.0.seconds()
    }
}
