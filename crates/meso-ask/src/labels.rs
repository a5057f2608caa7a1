//! Refusals of label volumes, with the option that answers each question, in its giver's spelling.

use crate::Giver;
use meso_core::labelled::{LabelOptions, LabelsError, Otherwise};

/// Why a label volume is refused, and the option that mends it.
pub fn labels_refusal(error: &LabelsError, options: &LabelOptions, giver: Giver<'_>) -> String {
    let list = |key: &str, labels: &[i64]| giver.labels(key, labels);
    match error {
        LabelsError::Option(wrong) => giver.refusal(wrong),
        LabelsError::Absent { key, .. } => {
            format!("{}{}", giver.option(key), error.to_string().trim_start_matches(key))
        }
        LabelsError::Negative { label } => format!("{error}, as in {}", list("mortar", &[*label])),
        LabelsError::NoGrains { dropped, .. } if *dropped > 0 && options.least_voxels > 1 => {
            format!("{error}; {} takes smaller ones", giver.option("least_voxels"))
        }
        LabelsError::Mortar { is_open, mortar, otherwise, .. } => {
            let other = match otherwise {
                Otherwise::Grains(share) => format!(", or {} if it is a grain", giver.number("largest_grain", *share)),
                Otherwise::Phase(labels) => {
                    format!(", or {} if these labels are one phase, as core and ITZ are", list("aggregate", labels))
                }
                Otherwise::Nothing => String::new(),
            };
            let touching =
                if *is_open { "; grains that touch are one part: separate them first, by a watershed" } else { "" };
            format!("{error} {} if so{other}{touching}", list("mortar", mortar))
        }
        _ => error.to_string(),
    }
}
