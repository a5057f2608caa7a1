//! The work of `mesocrete image`: voxel images and sections of a saved model.

use super::flags::Args;
use crate::failure::Failure;
use crate::formats::Named;
use crate::outputs::{self, Target, Unit};
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_ask::Giver;
use meso_core::SpecError;
use meso_core::formats::ImageFormat;
use meso_core::voxel_image::{ImageOptions, Quantity, Region, VoxelImage};
use meso_core::watch::Stage;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let options = args.options()?;
    let plan = Named::targets(&args.output, args.writing.force)?;
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.model])?;
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Image, 2.0));
    let model = inputs::model(&args.model, &watch)?;
    let image = VoxelImage::new(&model, &options).map_err(|error| wrong(&error))?;
    plan.iter().try_for_each(|(target, format)| leave_space(target, *format, &image))?;
    let mut unit = Unit::default();
    for (target, format) in &plan {
        match format {
            ImageFormat::Tif => {
                unit.fill_file(target, args.writing.force, |out| {
                    format.write_file(&image, &model, options.region, &watch, out)
                })?;
            }
            _ => {
                unit.fill(target, args.writing.force, |out| format.write(&image, &model, options.region, &watch, out))?;
            }
        }
    }
    unit.commit()?;
    watch.finish();
    if !args.writing.quiet {
        let shape: Vec<String> = image.shape().iter().map(usize::to_string).collect();
        let (what, shape) = (options.quantity.name(), shape.join(" x "));
        stderr::line(format!("{what} of {shape} voxels of {} mm", options.voxel_size_mm));
        outputs::wrote(plan.iter().map(|(target, _)| target));
    }
    Ok(0)
}

impl Args {
    /// The image that is asked for. Refuses flags that are wrong with any file.
    pub(crate) fn options(&self) -> Result<ImageOptions, Failure> {
        if self.of.is_some() && self.what != Quantity::Share {
            let [of, what] = ["of", "what"].map(|key| Giver::Flags.option(key));
            return Err(Failure::Usage(format!("{of} is only for {what} share; add that, or leave {of} out")));
        }
        let region = match (self.section, self.r#box) {
            (Some((axis, at)), _) => Region::Section { axis, at },
            (_, Some([a, b, c, d, e, f])) => Region::Box { min: [a, b, c], max: [d, e, f] },
            _ => Region::Whole,
        };
        let of = self.of.unwrap_or_default();
        let options = ImageOptions { voxel_size_mm: self.voxel_size_mm, quantity: self.what, of, region };
        let is_section = matches!(region, Region::Section { .. });
        for Named { path, format } in &self.output {
            if matches!(format, ImageFormat::Png | ImageFormat::Svg) && !is_section {
                let section = Giver::Flags.option("section");
                let message = format!("it holds one section; add {section} z=75, or use .npy, .tif or .vti");
                return Err(Failure::Usage(format!("{}: {message}", path.display())));
            }
            format.check(&options).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
        }
        Ok(options)
    }
}

/// Refuses an image that its disk has no space for, before it is made.
fn leave_space(target: &Target, format: ImageFormat, image: &VoxelImage) -> Result<(), Failure> {
    let holds_values = matches!(format, ImageFormat::Npy | ImageFormat::Tif | ImageFormat::Vti);
    match target {
        Target::File { shown, path } if holds_values => room::accept_on_disk(shown, path, image.bytes()),
        _ => Ok(()),
    }
}

/// Turns an error of the image into wrong usage, by the name of its flag.
fn wrong(error: &SpecError) -> Failure {
    Failure::Usage(format!("{} {}", Giver::Flags.option(&error.key), error.message))
}
