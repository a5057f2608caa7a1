//! The command line: one file per subcommand, each with its arguments and its action.

pub(crate) mod check;
pub(crate) mod completions;
pub(crate) mod convert;
pub(crate) mod dataset;
pub(crate) mod devices;
pub(crate) mod effective;
mod examples;
mod file_or;
pub(crate) mod fit;
pub(crate) mod image;
pub(crate) mod import;
pub(crate) mod init;
pub(crate) mod mesh;
mod meshing;
pub(crate) mod pack;
pub(crate) mod recipes;
pub(crate) mod report;
pub(crate) mod schema;
mod shared;
pub(crate) mod solve;
pub(crate) mod study;

use crate::failure::Failure;
use clap::{Parser, Subcommand};
pub(crate) use meso_ask::flags::{names, values};

/// Mesoscale concrete: aggregates packed without overlap, proved apart, meshed for finite elements.
#[derive(Parser, Debug)]
#[command(name = "mesocrete", version, after_help = AFTER_HELP, max_term_width = 100)]
#[command(arg_required_else_help = true, subcommand_required = true)]
pub(crate) struct Cli {
    #[command(subcommand)]
    pub(crate) command: Command,
}

const AFTER_HELP: &str = "\
Lengths are in mm; fractions are aggregate volume over specimen volume, 0 to 1.
stdout carries data only, messages go to stderr.

Exit codes: 0 done; 1 failure; 2 wrong usage or spec; 3 short of the target with --strict; 130 after Ctrl-C.

First steps:
  mesocrete pack --fraction 0.4        pack a 150 mm cube; writes model.json, .vtu, .inp, .html
  mesocrete init en-cube-150           write SPEC.toml to start from, then: mesocrete pack SPEC.toml";

#[derive(Subcommand, Debug)]
pub(crate) enum Command {
    /// Pack a specimen with aggregates and write it
    #[command(after_help = examples::PACK)]
    Pack(pack::Args),
    /// Mesh a saved model for finite elements
    #[command(after_help = examples::MESH)]
    Mesh(mesh::Args),
    /// Test a specimen until it breaks: from a model, a spec or nothing to the stress-strain curve
    #[command(after_help = examples::SOLVE)]
    Solve(Box<solve::Args>),
    /// List the devices that `solve --device` can take
    #[command(after_help = examples::DEVICES)]
    Devices(devices::Args),
    /// Pack, mesh and test every combination of some options; a killed study resumes where it stopped
    #[command(after_help = examples::STUDY)]
    Study(study::Args),
    /// Make many labelled volumes with the metadata of each, for learning; a killed one resumes where it stopped
    #[command(after_help = examples::DATASET)]
    Dataset(dataset::Args),
    /// Find the mortar with which a specimen's curve meets a measured one; a killed fit resumes where it stopped
    #[command(after_help = examples::FIT)]
    Fit(fit::Args),
    /// Prove that a saved model keeps its promises: no overlaps, all inside, all closed
    #[command(after_help = examples::CHECK)]
    Check(check::Args),
    /// Write one page about a saved model: pictures, grading plot, statistics; or the statistics alone
    #[command(after_help = examples::REPORT)]
    Report(report::Args),
    /// Write a saved model in another format
    #[command(after_help = examples::CONVERT)]
    Convert(convert::Args),
    /// Turn a label volume, one integer a grain or a phase, into a saved model
    #[command(after_help = examples::IMPORT)]
    Import(import::Args),
    /// Write voxel images and sections of a saved model: .npy, .tif, .vti, .png, .svg
    #[command(after_help = examples::IMAGE)]
    Image(image::Args),
    /// Compute the diffusivity, conductivity or stiffness of a saved model, each with its error
    #[command(after_help = examples::EFFECTIVE)]
    Effective(effective::Args),
    /// Write a commented SPEC.toml to start from
    #[command(after_help = examples::INIT)]
    Init(init::Args),
    /// List the specimens that `init` knows
    #[command(after_help = examples::RECIPES)]
    Recipes,
    /// Write the options of a SPEC.toml as a JSON Schema, so that editors complete and check it
    #[command(after_help = examples::SCHEMA)]
    Schema(schema::Args),
    /// Write a shell's completions
    #[command(after_help = examples::COMPLETIONS)]
    Completions(completions::Args),
    /// Write the manual pages
    #[command(after_help = examples::MAN)]
    Man(completions::ManArgs),
}

impl Command {
    /// Refuses flags that no file can make right.
    pub(crate) fn unread(&self) -> Result<(), Failure> {
        match self {
            Self::Pack(args) => args.unread().map(drop),
            Self::Mesh(args) => args.unread().map(drop),
            Self::Solve(args) => args.unread().map(drop),
            Self::Convert(args) => args.settle(),
            Self::Image(args) => args.options().map(drop),
            Self::Import(args) => args.options().map(drop),
            _ => Ok(()),
        }
    }
}
