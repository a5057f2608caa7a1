//! The work of `mesocrete image`: voxel images and sections of a saved model.

use super::flags::Args;
use super::settings::plan;
use crate::failure::Failure;
use crate::outputs::{self, Target, Unit};
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_core::SpecError;
use meso_core::formats::ImageFormat;
use meso_core::voxel_image::VoxelImage;
use meso_core::watch::Stage;

pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    args.threads.run(|| on_these_threads(args))?
}

fn on_these_threads(args: &Args) -> Result<u8, Failure> {
    let options = args.options()?;
    let plan = args.output.iter().map(|path| plan(path, args, &options)).collect::<Result<Vec<_>, _>>()?;
    outputs::distinct(&plan.iter().map(|(target, _)| target).collect::<Vec<_>>(), &[&args.model])?;
    let mut watch = Watch::of_files(args.writing.quiet, &of_model(Stage::Image, 2.0));
    let model = inputs::model(&args.model, &watch)?;
    let image = VoxelImage::new(&model, &options).map_err(|error| wrong(&error))?;
    plan.iter().try_for_each(|(target, format)| accept_size(target, *format, &image))?;
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

/// Refuses an image that its disk has no space for, before it is made.
fn accept_size(target: &Target, format: ImageFormat, image: &VoxelImage) -> Result<(), Failure> {
    let holds_values = matches!(format, ImageFormat::Npy | ImageFormat::Tif | ImageFormat::Vti);
    match target {
        Target::File { shown, path } if holds_values => room::accept_on_disk(shown, path, image.bytes()),
        _ => Ok(()),
    }
}

/// Turns an error of the image into wrong usage, by the name of its flag.
fn wrong(error: &SpecError) -> Failure {
    Failure::Usage(format!("--{} {}", error.key.replace('_', "-"), error.message))
}
