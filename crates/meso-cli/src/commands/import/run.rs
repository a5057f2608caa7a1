//! The work of `mesocrete import`: a label volume becomes a saved model.

use super::flags::Args;
use crate::failure::Failure;
use crate::formats::Named;
use crate::outputs::{self, Unit};
use crate::progress::Watch;
use crate::stderr::flag;
use crate::{inputs, room, stderr};
use meso_ask::{Giver, labels_refusal};
use meso_concrete::{exceeds, thousands};
use meso_core::Model;
use meso_core::formats::SurfaceOptions;
use meso_core::import::grains::{Roles, SmoothOptions};
use meso_core::labelled::{LabelOptions, of_labels};
use meso_core::packing::LabelReport;
use meso_core::watch::Stage;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let (options, plan) = (args.options()?, Named::targets(&args.output, args.writing.force)?);
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.volume])?;
    let mut watch = Watch::of_files(args.writing.quiet, &[(Stage::Take, 1.0)]);
    let volume = inputs::volume(&args.volume, args.array.as_deref())?;
    room::accept_image("the grains of the volume", LabelOptions::bytes(volume.counts))?;
    // A refusal of the grains is about the array and the size that were taken.
    inputs::warn_of_choices(&volume, options.voxel_size_mm.is_some());
    let model = of_labels(&volume, &options, &watch);
    watch.finish();
    let model = model.map_err(|error| {
        Failure::Run(format!("{}: {}", args.volume.display(), labels_refusal(&error, &options, Giver::Flags)))
    })?;
    drop(volume);
    let mut unit = Unit::default();
    for (target, format) in &plan {
        unit.fill(target, args.writing.force, |out| format.write(&model, SurfaceOptions::default(), out))?;
    }
    unit.commit()?;
    let Some(labels) = &model.report.labels else { return Ok(0) };
    if !args.writing.quiet {
        print(&model, labels);
        outputs::wrote(plan.iter().map(|(target, _)| target));
    }
    Ok(if is_short(labels, args.gap_mm) && args.strict { SHORT } else { 0 })
}

impl Args {
    /// The grains that are asked for. Refuses flags that are wrong with any file.
    pub(crate) fn options(&self) -> Result<LabelOptions, Failure> {
        let option = |key| Giver::Flags.option(key);
        let voxel_size_mm = match self.voxel_size_mm[..] {
            [] => None,
            [h] => Some([h; 3]),
            [x, y, z] => Some([x, y, z]),
            _ => {
                let message = format!("{} takes one length, or three along x, y, z", option("voxel_size_mm"));
                return Err(Failure::Usage(message));
            }
        };
        let options = LabelOptions {
            voxel_size_mm,
            roles: Roles { mortar: self.mortar.clone(), aggregate: self.aggregate.clone() },
            outside: self.outside.clone(),
            least_voxels: self.least_voxels as usize,
            largest_grain: self.largest_grain,
            gap_mm: self.gap_mm,
            itz_thickness_mm: self.itz_thickness_mm,
            surfaces: SmoothOptions { step: self.step, smoothing: self.smoothing, tolerance: self.tolerance },
        };
        options.validate().map_err(|error| Failure::Usage(Giver::Flags.refusal(&error)))?;
        Ok(options)
    }
}

/// Exit code of a result that `--strict` refuses.
const SHORT: u8 = 3;
/// Share of the labels' volume whose loss is worth a warning.
const LOSS: f64 = 0.02;

/// Warns where the aggregates have much less volume than the labels.
fn is_short(labels: &LabelReport, gap_mm: f64) -> bool {
    let had = labels.fraction + labels.dropped_fraction;
    let share = labels.lost_fraction / had;
    let is_short = exceeds(share, LOSS);
    if is_short {
        let [share, dropped] = [share, labels.dropped_fraction / had].map(|share| 100.0 * share);
        let gap = if gap_mm > 0.0 { format!("a smaller {}, ", flag("gap_mm")) } else { String::new() };
        let [least, smoothing, tolerance] = ["least_voxels", "smoothing", "tolerance"].map(flag);
        stderr::line(format!(
            "warning: the aggregates have {share:.1} % less volume than the labels: {dropped:.1} % in small or thin \
             grains, the rest by smoothing and at contacts; take {gap}smaller voxels, {least}, {smoothing} or {tolerance}"
        ));
    }
    is_short
}

fn print(model: &Model, labels: &LabelReport) {
    let report = &model.report;
    let triangles: usize = model.aggregates.iter().map(|aggregate| aggregate.body.triangles().count()).sum();
    stderr::line(format!(
        "{} grains of {} triangles: fraction {:.5}, {:.5} in the labels; surfaces are up to {:.3} mm from the voxels' faces",
        thousands(report.aggregates),
        thousands(triangles),
        report.fraction,
        labels.fraction,
        labels.farthest_mm
    ));
    if let Some(core) = &labels.core {
        let (diameter, off) = (core.diameter_mm, percent(core.off_fraction));
        stderr::line(format!(
            "the core is a cylinder of {diameter:.3} mm; {off} of its voxels are beyond it, or missing within"
        ));
        if core.pores_fraction > 0.0 {
            let pores = percent(core.pores_fraction);
            stderr::line(format!("{pores} of the cylinder is outside by its label, as pores are; it is mortar"));
        }
    }
    if labels.separated_pairs > 0 {
        stderr::line(format!(
            "{} pairs of grains that touch in the labels are apart",
            thousands(labels.separated_pairs)
        ));
    }
    if labels.dropped > 0 {
        let (dropped, share) = (thousands(labels.dropped), percent(labels.dropped_fraction));
        stderr::line(format!("{dropped} grains are too small, {share} of the voxels; they are mortar"));
    }
    if labels.filled > 0 {
        let (filled, share) = (thousands(labels.filled), percent(labels.filled_fraction));
        stderr::line(format!("hollows in {filled} grain(s), {share} of the voxels, were filled"));
    }
    // The labels are in order. One label alone is the phase of all grains.
    let names = labels.labels.chunk_by(|a, b| a == b);
    let (several, of_several) =
        names.clone().filter(|parts| parts.len() > 1).fold((0, 0), |sum, parts| (sum.0 + 1, sum.1 + parts.len()));
    if several > 0 && names.count() > 1 {
        let (several, parts) = (thousands(several), thousands(of_several));
        stderr::line(format!("{several} label(s) have separate parts; each of these {parts} parts is a grain"));
    }
}

/// A share in per cent; one that three decimals would show as nothing is less than the least of these.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 0.001 { "less than 0.001 %".to_owned() } else { format!("{percent:.3} %") }
}
