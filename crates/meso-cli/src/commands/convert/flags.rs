//! Flags of `mesocrete convert`.

use crate::commands::names;
use crate::commands::shared::{Threads, Writing};
use crate::formats::Named;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use meso_core::formats::Format;
use meso_core::images::Images;
use std::path::{Path, PathBuf};

#[derive(clap::Args, Debug)]
pub(crate) struct Args {
    /// A saved model (.json or .json.gz); `-` is standard input
    pub(super) model: PathBuf,
    #[arg(short, long, value_name = "FILE", required = true, value_parser = Named::<Format>::parser())]
    #[arg(help = format!("File to write, its format by the extension: {}; `-` is standard output. May be repeated", known(".")))]
    pub(super) output: Vec<Named<Format>>,
    /// Format on standard output [default: json]
    #[arg(long, value_name = "FORMAT", value_parser = format_names())]
    pub(super) format: Option<Format>,
    /// Compress the data of a .vtu or .vtp (zlib)
    #[arg(long)]
    pub(super) compress: bool,
    /// Aggregates that cross a face of a periodic specimen, where surfaces are written
    #[arg(long, default_value = "none", value_parser = names::parser::<Images>())]
    #[arg(hide_short_help = true)]
    pub(super) images: Images,
    /// Add the mortar to a .step: a solid with a cavity per aggregate
    #[arg(long, hide_short_help = true)]
    pub(super) mortar: bool,
    /// Write an .stl as text, each aggregate a solid with its name
    #[arg(long, hide_short_help = true)]
    pub(super) named_solids: bool,
    #[command(flatten)]
    pub(super) threads: Threads,
    #[command(flatten)]
    pub(super) writing: Writing,
}

fn format_names() -> impl TypedValueParser<Value = Format> {
    let names = PossibleValuesParser::new(Format::ALL.map(Format::extension));
    names.try_map(|name| Format::from_path(&Path::new("x").with_extension(name)).ok_or("unknown format"))
}

/// The extensions of all formats, each after `dot`.
pub(super) fn known(dot: &str) -> String {
    Format::ALL.map(|format| format!("{dot}{}", format.extension())).join(", ")
}
