//! The options that the flags of `mesocrete import` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::outputs::Target;
use meso_concrete::OutOfRange;
use meso_core::formats::Format;
use meso_core::import::grains::{Roles, SmoothOptions};
use meso_core::labelled::LabelOptions;
use std::path::Path;

impl Args {
    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        self.output.iter().try_for_each(|path| format(path).map(drop))?;
        self.options().map(drop)
    }

    pub(super) fn options(&self) -> Result<LabelOptions, Failure> {
        let voxel_size_mm = match self.voxel_size_mm[..] {
            [] => None,
            [h] => Some([h; 3]),
            [x, y, z] => Some([x, y, z]),
            _ => return Err(Failure::Usage("--voxel-size-mm takes one length, or three along x, y, z".to_owned())),
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
        let wrong = |error: OutOfRange| format!("--{} {}", error.key.replace('_', "-"), error.fault());
        options.validate().map_err(|error| Failure::Usage(wrong(error)))?;
        Ok(options)
    }

    pub(super) fn plan(&self) -> Result<Vec<(Target, Format)>, Failure> {
        self.output.iter().map(|path| Ok((Target::new(path, self.writing.force)?, format(path)?))).collect()
    }
}

fn format(path: &Path) -> Result<Format, Failure> {
    let format = if path == Path::new("-") { Some(Format::Json) } else { Format::from_path(path) };
    let known = || Format::ALL.map(|format| format!(".{}", format.extension())).join(", ");
    format.ok_or_else(|| {
        Failure::Usage(format!("{}: unknown format; the extension must be one of {}", path.display(), known()))
    })
}
