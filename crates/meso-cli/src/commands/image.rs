//! `mesocrete image`: voxel images and sections of a saved model.

use super::shared::{Threads, Writing};
use super::{names, values};
use crate::failure::Failure;
use crate::outputs::{self, Target, Unit};
use crate::progress::{Watch, of_model};
use crate::{inputs, room, stderr};
use meso_core::SpecError;
use meso_core::formats::ImageFormat;
use meso_core::voxel_image::{ImageOptions, Quantity, Region, ShareOf, VoxelImage};
use meso_core::watch::Stage;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    model: PathBuf,
    /// File to write, its format by the extension: .npy, .tif, .vti; of a section .png and .svg, too; `-` writes the
    /// .npy to standard output. May be repeated
    #[arg(short, long, value_name = "FILE", required = true)]
    output: Vec<PathBuf>,
    /// Edge of a voxel, mm; along periodic axes it must divide the specimen's length
    #[arg(long, value_name = "H", default_value_t = ImageOptions::default().voxel_size_mm, value_parser = values::number)]
    #[arg(allow_negative_numbers = true, aliases = ["voxel-size", "size", "h"])]
    voxel_size_mm: f64,
    #[arg(long, default_value = "phase", value_parser = names::parse::<Quantity>)]
    #[arg(help = format!("Quantity at the voxels: {}", names::list::<Quantity>()))]
    what: Quantity,
    #[arg(long, value_parser = names::parse::<ShareOf>)]
    #[arg(help = format!("Bodies whose share of a voxel is written, with --what share: {} [default: aggregate, ITZ included]", names::list::<ShareOf>()))]
    of: Option<ShareOf>,
    /// Write only the voxels on a plane normal to an axis, in mm: z=75
    #[arg(long, value_name = "AXIS=MM", value_parser = plane, conflicts_with = "box")]
    section: Option<(usize, f64)>,
    /// Write only a box, given by its lower and upper corner in mm: 0,0,0,50,50,50. Voxels start at the lower corner
    #[arg(long, value_name = "X,Y,Z,X,Y,Z", value_parser = corners, allow_hyphen_values = true)]
    r#box: Option<[f64; 6]>,
    #[command(flatten)]
    threads: Threads,
    #[command(flatten)]
    writing: Writing,
}

/// An axis and a position on it.
fn plane(text: &str) -> Result<(usize, f64), String> {
    let expected = || "it must be an axis and a length in mm, as in z=75".to_owned();
    let (axis, at) = text.split_once('=').ok_or_else(expected)?;
    let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim()).ok_or_else(expected)?;
    at.trim().parse().ok().filter(|at: &f64| at.is_finite()).map(|at| (axis, at)).ok_or_else(expected)
}

/// Six coordinates.
fn corners(text: &str) -> Result<[f64; 6], String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers
        .and_then(|numbers| numbers.try_into().ok())
        .ok_or_else(|| "it must be six lengths in mm, separated by commas".to_owned())
}

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
        let files = plan.iter().filter_map(|(target, _)| target.file());
        files.for_each(|path| stderr::line(format!("wrote {}", path.display())));
    }
    Ok(0)
}

impl Args {
    /// Refuses flags that no file can make right.
    pub(super) fn validate(&self) -> Result<(), Failure> {
        let options = self.options()?;
        self.output.iter().try_for_each(|path| format(path, &options).map(drop))
    }

    fn options(&self) -> Result<ImageOptions, Failure> {
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

fn plan(path: &Path, args: &Args, options: &ImageOptions) -> Result<(Target, ImageFormat), Failure> {
    let format = format(path, options)?;
    Ok((Target::new(path, args.writing.force)?, format))
}

/// Refuses an image that its disk has no space for, before it is made.
fn accept_size(target: &Target, format: ImageFormat, image: &VoxelImage) -> Result<(), Failure> {
    let holds_values = matches!(format, ImageFormat::Npy | ImageFormat::Tif | ImageFormat::Vti);
    match target {
        Target::File { shown, path } if holds_values => room::accept_on_disk(shown, path, image.bytes()),
        _ => Ok(()),
    }
}

/// The format that an output's name asks for, where it can hold the image.
fn format(path: &Path, options: &ImageOptions) -> Result<ImageFormat, Failure> {
    let format = if path == Path::new("-") { Some(ImageFormat::Npy) } else { ImageFormat::from_path(path) };
    let format = format.ok_or_else(|| {
        let known = ImageFormat::ALL.map(|format| format!(".{}", format.extension())).join(", ");
        Failure::Usage(format!("{}: unknown image format; the extension must be one of {known}", path.display()))
    })?;
    if matches!(format, ImageFormat::Png | ImageFormat::Svg) && !matches!(options.region, Region::Section { .. }) {
        let message = "it shows one section; add one, as --section z=75, or take .npy, .tif or .vti";
        return Err(Failure::Usage(format!("{}: {message}", path.display())));
    }
    format.check(options).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    Ok(format)
}

/// The core speaks of `voxel_size_mm`, the user typed `--voxel-size-mm`.
fn wrong(error: &SpecError) -> Failure {
    Failure::Usage(format!("--{} {}", error.key.replace('_', "-"), error.message))
}
