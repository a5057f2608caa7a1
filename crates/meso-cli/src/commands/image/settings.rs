//! The image and the outputs that the flags of `mesocrete image` ask for.

use super::flags::Args;
use crate::failure::Failure;
use crate::outputs::Target;
use meso_core::formats::ImageFormat;
use meso_core::voxel_image::{ImageOptions, Quantity, Region};
use std::path::Path;

impl Args {
    /// Refuses flags that are wrong with any file.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let options = self.options()?;
        self.output.iter().try_for_each(|path| format(path, &options).map(drop))
    }

    pub(super) fn options(&self) -> Result<ImageOptions, Failure> {
        if self.of.is_some() && self.what != Quantity::Share {
            return Err(Failure::Usage("--of is only for --what share; add that, or leave --of out".to_owned()));
        }
        let region = match (self.section, self.r#box) {
            (Some((axis, at)), _) => Region::Section { axis, at },
            (_, Some([a, b, c, d, e, f])) => Region::Box { min: [a, b, c], max: [d, e, f] },
            _ => Region::Whole,
        };
        let of = self.of.unwrap_or_default();
        Ok(ImageOptions { voxel_size_mm: self.voxel_size_mm, quantity: self.what, of, region })
    }
}

pub(super) fn plan(path: &Path, args: &Args, options: &ImageOptions) -> Result<(Target, ImageFormat), Failure> {
    let format = format(path, options)?;
    Ok((Target::new(path, args.writing.force)?, format))
}

/// The format that an output's name asks for, where it can hold the image.
fn format(path: &Path, options: &ImageOptions) -> Result<ImageFormat, Failure> {
    let format = if path == Path::new("-") { Some(ImageFormat::Npy) } else { ImageFormat::from_path(path) };
    let format = format.ok_or_else(|| {
        let known = ImageFormat::ALL.map(|format| format!(".{}", format.extension())).join(", ");
        Failure::Usage(format!("{}: unknown image format; the extension must be one of {known}", path.display()))
    })?;
    if matches!(format, ImageFormat::Png | ImageFormat::Svg) && !matches!(options.region, Region::Section { .. }) {
        let message = "it holds one section; add --section z=75, or use .npy, .tif or .vti";
        return Err(Failure::Usage(format!("{}: {message}", path.display())));
    }
    format.check(options).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    Ok(format)
}
