//! Agreement of a label volume's model with its bodies: it is made again from them, and every key compared. What the volume
//! alone can tell is held against the bodies as far as they bound it.

use super::Finding;
use super::report::{differences, plain, wrong};
use crate::drilled::MOST_OFF;
use crate::labelled::{LabelOptions, assembled};
use crate::model::Model;
use meso_collision::geometry::Polyhedron;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::exceeds;
use meso_place::{CoreReport, LabelReport, Report};
use serde_json::Value;
use std::f64::consts::PI;

/// A share of the voxels is a whole number of them to this.
const WHOLE: f64 = 1e-3;

/// Finds every figure that differs from those of a model of these bodies.
pub(super) fn check(model: &Model) -> Vec<Finding> {
    let reasons = model.report.labels.as_ref().map(|labels| reasons(model, labels));
    reasons.into_iter().flatten().map(wrong).collect()
}

fn reasons(model: &Model, labels: &LabelReport) -> Vec<String> {
    let mut reasons = alone(labels, model.aggregates.len());
    if let Err(error) = options(labels).validate() {
        reasons.push(error.to_string());
        return reasons;
    }
    let bodies: Vec<Polyhedron> = model.aggregates.iter().map(|aggregate| aggregate.body.clone()).collect();
    let itz = model.spec.itz.thickness_mm[0];
    match assembled(bodies, labels.voxels, labels.voxel_size_mm, itz, labels.clone()) {
        Ok(right) => against(model, right, &mut reasons),
        Err(error) => reasons.push(format!("its bodies make no model: {error}")),
    }
    reasons.extend(filled(model, labels));
    reasons
}

/// The options of an import with voxels of this size.
fn options(labels: &LabelReport) -> LabelOptions {
    LabelOptions { voxel_size_mm: Some(labels.voxel_size_mm), ..LabelOptions::default() }
}

/// Faults that the entry shows alone.
fn alone(labels: &LabelReport, aggregates: usize) -> Vec<String> {
    let LabelReport { fraction, dropped, dropped_fraction, filled, filled_fraction, farthest_mm, .. } = *labels;
    let voxels = labels.whole();
    let mut reasons = Vec::new();
    let mut say = |is_right: bool, reason: String| reasons.extend((!is_right).then_some(reason));
    let said = labels.labels.len();
    say(said == aggregates, format!("labels.labels has {said} labels for {aggregates} aggregates"));
    say(labels.labels.is_sorted(), "labels.labels do not ascend".to_owned());
    for (name, share) in
        [("fraction", fraction), ("dropped_fraction", dropped_fraction), ("filled_fraction", filled_fraction)]
    {
        let count = share * voxels;
        let is_share = (0.0..=1.0).contains(&share) && (count - count.round()).abs() <= WHOLE;
        say(is_share, format!("labels.{name} is {share}, which is no share of {voxels} voxels"));
    }
    say(
        fraction + dropped_fraction <= 1.0,
        format!("labels.dropped_fraction is {dropped_fraction} beside {fraction} of grains"),
    );
    say(filled_fraction <= fraction, format!("labels.filled_fraction is {filled_fraction}, of {fraction} of grains"));
    say(dropped > 0 || dropped_fraction == 0.0, format!("labels.dropped is 0 and dropped_fraction {dropped_fraction}"));
    say(
        (filled > 0) == (filled_fraction > 0.0),
        format!("labels.filled is {filled} and filled_fraction {filled_fraction}"),
    );
    for (name, count, share) in [("filled", filled, filled_fraction), ("dropped", dropped, dropped_fraction)] {
        let most = share * voxels;
        say(count as f64 <= most + WHOLE, format!("labels.{name} is {count} grains with {most:.0} voxels"));
    }
    let grains = aggregates.saturating_add(dropped);
    say(filled <= grains, format!("labels.filled is {filled} of {grains} grains"));
    let pairs = aggregates.saturating_mul(aggregates.saturating_sub(1)) / 2;
    let separated = labels.separated_pairs;
    say(
        separated <= pairs,
        format!("labels.separated_pairs is {separated}; {aggregates} aggregates have {pairs} pairs"),
    );
    let diagonal =
        (0..3).map(|axis| labels.voxels[axis] as f64 * labels.voxel_size_mm[axis]).map(|x| x * x).sum::<f64>();
    if let Some(core) = &labels.core {
        core_alone(labels, core, &mut say);
    }
    let is_distance = (0.0..=diagonal.sqrt()).contains(&farthest_mm);
    say(is_distance, format!("labels.farthest_mm is {farthest_mm}, which is no distance in the volume"));
    reasons
}

/// Faults of a core that its entry shows alone.
fn core_alone(labels: &LabelReport, core: &CoreReport, say: &mut dyn FnMut(bool, String)) {
    let ([nx, ny, nz], [hx, hy, _]) = (labels.voxels.map(|count| count as f64), labels.voxel_size_mm);
    let CoreReport { diameter_mm, voxels, off_fraction, pores_fraction, .. } = *core;
    // Voxels in a circle differ from its area by about the root of its length.
    let (area, own) = (PI / 4.0 * diameter_mm * diameter_mm, voxels as f64 / nz * hx * hy);
    let cut = 4.0 * (PI * diameter_mm / hx.min(hy)).sqrt() * hx * hy;
    let is_round = diameter_mm > 0.0 && diameter_mm <= (nx * hx).max(ny * hy) && (area - own).abs() <= cut;
    say(is_round, format!("labels.core is a cylinder of {diameter_mm} mm with {own:.3} mm2 of voxels in a layer"));
    say(!core.outside.is_empty(), "labels.core has no labels outside".to_owned());
    let is_grain = core.outside.iter().any(|label| labels.labels.contains(label));
    let is_twice = core.outside.iter().enumerate().any(|(place, label)| core.outside[..place].contains(label));
    say(!is_grain && !is_twice, format!("labels.core.outside is {:?}, of grains or twice", core.outside));
    let pores = pores_fraction * voxels as f64;
    for (name, share) in [("off_fraction", off_fraction), ("pores_fraction", pores_fraction)] {
        say((0.0..=1.0).contains(&share), format!("labels.core.{name} is {share}"));
    }
    say(
        !exceeds(off_fraction, MOST_OFF),
        format!("labels.core.off_fraction is {off_fraction}, and no core is so far off"),
    );
    say((pores - pores.round()).abs() <= WHOLE, format!("labels.core.pores_fraction is {pores} voxels"));
    let beside = labels.fraction - labels.filled_fraction + labels.dropped_fraction + pores_fraction;
    say(
        beside <= 1.0 + WHOLE / voxels as f64,
        format!("labels.core.pores_fraction is {pores_fraction} beside the grains"),
    );
}

/// Names what differs from the model that is `right`; how long it took is taken from the file.
fn against(model: &Model, right: Model, reasons: &mut Vec<String>) {
    let spec = |model: &Model| {
        let text = model.spec.to_json().ok();
        text.and_then(|text| serde_json::from_str::<Value>(&text).ok()).unwrap_or_default()
    };
    differences("spec", &spec(model), &spec(&right), reasons);
    let Report { version, seconds, .. } = model.report.clone();
    let report = Report { version, seconds, ..right.report.clone() };
    differences("", &plain(&model.report), &plain(&report), reasons);
    for (said, right) in model.aggregates.iter().zip(&right.aggregates) {
        let of = |aggregate: &Aggregate| (aggregate.class, aggregate.itz_thickness_mm);
        if of(said) != of(right) {
            let ((class, itz), (own_class, own_itz)) = (of(said), of(right));
            reasons.push(format!(
                "aggregate {} has the class {class} and an ITZ of {itz} mm; its body gives {own_class} and {own_itz} mm",
                said.id
            ));
        }
    }
}

/// Volume of the bodies over that of their voxels, at most: import keeps it to 0.25 %.
const GAIN: f64 = 1.05;

/// The volume of the grains' voxels differs from that of the bodies by what lies between their surfaces, which are nowhere
/// farther apart than the file says.
fn filled(model: &Model, labels: &LabelReport) -> Option<String> {
    let far = labels.farthest_mm;
    let between = |aggregate: &Aggregate| {
        let (volume, area) = (aggregate.body.volume(), aggregate.body.area());
        // A ball of this ratio grows by so much, or less.
        area * far * (1.0 + far * area / (3.0 * volume)).powi(2)
    };
    let own: f64 = model.aggregates.iter().map(|aggregate| aggregate.body.volume()).sum();
    let most: f64 = model.aggregates.iter().map(between).sum();
    let volume = labels.whole() * labels.voxel_size_mm.iter().product::<f64>();
    let said = labels.fraction * volume;
    // Bodies have their voxels' volume, hollows filled, and lose some where they touch; they never gain as much.
    let filled = labels.filled_fraction * volume;
    let is_near = (said - own).abs() <= most && own <= GAIN * said + filled;
    (!is_near).then(|| {
        format!("labels.fraction gives {said:.6} mm3 of grains, and the bodies have {own:.6}; their surfaces are within {far} mm")
    })
}
