//! `mesocrete dataset`: many labelled volumes. The Python package makes them: it has the arrays and their files.

use super::shared::{Writing, share};
use super::values;
use crate::failure::Failure;
use crate::{Python, inputs, outputs};
use meso_core::spec::options_from_toml;
use meso_study::Share;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Quantities of a volume.
const QUANTITIES: [&str; 5] = ["phase", "grain", "share", "distance", "scan"];

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// Spec of every volume (SPEC.toml)
    spec: PathBuf,
    /// Number of volumes
    #[arg(short, value_name = "N", value_parser = values::count, allow_negative_numbers = true)]
    n: u32,
    /// Sink: NAME.zarr, NAME.h5 (through h5py), or a folder of .npz files
    #[arg(short, long, value_name = "SINK", default_value = "dataset")]
    output: PathBuf,
    /// Options of the spec that are drawn (TOML): each a range { low, high } or a list, as in [draw.over] of a study; absent:
    /// the seed alone differs
    #[arg(long, value_name = "FILE")]
    over: Option<PathBuf>,
    /// Voxels along the longest side, or the numbers along z, y, x
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "128", value_parser = values::count)]
    shape: Vec<u32>,
    /// Quantities of a volume
    #[arg(long, value_name = "WHAT", value_delimiter = ',', default_value = "phase", value_parser = QUANTITIES)]
    what: Vec<String>,
    /// Seed of all draws
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = values::seed, allow_negative_numbers = true)]
    seed: u64,
    /// Keep the packings, too
    #[arg(long)]
    model: bool,
    /// Volumes at the same time; as many as cores when absent. It changes the time, never the result
    #[arg(short, long, value_name = "N", value_parser = values::threads, allow_negative_numbers = true)]
    jobs: Option<u16>,
    /// Make part K of N, every N-th volume from the K-th on, beside processes that make the others; not in an .h5
    #[arg(long, value_name = "K/N", value_parser = share, conflicts_with = "force")]
    shard: Option<Share>,
    #[command(flatten)]
    writing: Writing,
}

pub(crate) fn run(args: &Args, python: Option<&Python<'_>>) -> Result<u8, Failure> {
    let Some(python) = python else {
        let message = "a data set is made by the Python package, which writes its arrays; pip install mesocrete, and run its \
                       mesocrete";
        return Err(Failure::Usage(message.to_owned()));
    };
    outputs::refuse_stdout(&args.output, "a data set has many volumes; name a sink")?;
    let over = args.over.as_deref().map(|path| inputs::toml(path, options_from_toml::<Value>)).transpose()?;
    let shape = if let [longest] = args.shape[..] { json!(longest) } else { json!(args.shape) };
    let request = json!({
        "n": args.n, "sampler": over, "spec": args.spec, "sink": args.output, "shape": shape, "what": args.what,
        "seed": args.seed, "model": args.model, "jobs": args.jobs, "overwrite": args.writing.force,
        "progress": !args.writing.quiet, "shard": args.shard.map(|Share { shard, of }| [shard, of]),
    });
    python("dataset", &request.to_string()).map_err(Failure::Run)
}
