//! Flags of a mesh and of its deck, as users type them.

use crate::commands::names;
use crate::commands::test_file::{self, FileOr};
use crate::failure::Failure;
use clap::builder::TypedValueParser;
use meso_ask::{Given, Giver};
use meso_core::export::abaqus::{Analysis, DeckOptions, Plain};
use meso_core::mesh::{MeshTable, Purpose};
use meso_core::{Spec, Watch};
use meso_solve::{Test, TestKind, footing};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Mesh and materials")]
pub(crate) struct MeshFlags {
    #[command(flatten)]
    pub(super) given: Given<MeshTable>,
    /// The size that `auto` means for the packing at hand, mm.
    #[arg(skip)]
    tried: OnceLock<f64>,
    /// Accept a phase more than 10 % off its exact volume, which is an error otherwise; results carry a flag then
    #[arg(long, hide_short_help = true)]
    pub(super) accept_phase_error: bool,
    /// A TOML file with a [materials] table; absent values keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    pub(super) materials: Option<PathBuf>,
    /// The program gmsh, for --method conforming
    #[arg(long, value_name = "PROGRAM", default_value = "gmsh")]
    #[arg(hide_short_help = true)]
    pub(super) gmsh: PathBuf,
}

impl MeshFlags {
    /// The options that are given.
    pub(super) fn table(&self) -> MeshTable {
        self.given.options.clone().with_tried(self.tried.get().copied())
    }

    /// Sets who gave the options.
    pub(crate) fn given_by(&mut self, giver: Giver<'static>) {
        self.given.given_by(giver);
    }

    /// Finds the size that `auto` means for `spec`. `leaves_room` says that it is still to be packed, with the gaps that the
    /// mesh needs.
    pub(crate) fn try_sizes(
        &self,
        purpose: Purpose,
        spec: &Spec,
        leaves_room: bool,
        watch: &dyn Watch,
    ) -> Result<(), Failure> {
        if self.given.options.is_auto() && self.tried.get().is_none() {
            let found = footing::element_size(&self.table(), purpose, spec, leaves_room, watch);
            let size = found.map_err(|error| self.wrong(&error))?;
            self.tried.get_or_init(|| size);
        }
        Ok(())
    }

    /// Whether a file has the materials.
    pub(crate) fn has_materials(&self) -> bool {
        self.materials.is_some()
    }

    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.materials.iter().map(PathBuf::as_path)
    }
}

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Decks")]
pub(crate) struct DeckFlags {
    #[arg(long, value_name = "NAME|TEST.toml", default_value = "none", value_parser = analysis_parser())]
    #[arg(help = format!(
        "Analysis of the deck; any but none meshes, and packs, for a test: {}, or a test: {}, or a TEST.toml",
        names::list::<Plain>(),
        names::list::<TestKind>()
    ))]
    pub(super) analysis: AnalysisText,
    #[command(flatten)]
    pub(super) given: Given<DeckOptions>,
}

/// An analysis as users type it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum AnalysisText {
    Named(Analysis),
    /// A file, and its test once it was read.
    File(PathBuf, Box<OnceLock<Test>>),
}

/// Parser of an analysis.
fn analysis_parser() -> impl TypedValueParser<Value = AnalysisText> {
    let read = |name: &str| {
        let plain = names::read(name).map(|plain: Plain| plain.into());
        plain.or_else(|_| names::read(name).map(|kind: TestKind| kind.into())).map(AnalysisText::Named)
    };
    let name = names::parser_of([names::all::<Plain>(), names::all::<TestKind>()].concat(), read);
    FileOr { file: |path| AnalysisText::File(path, Box::default()), name }
}

impl DeckFlags {
    /// The analysis of the deck; a file is read once.
    fn analysis(&self) -> Result<Analysis, Failure> {
        Ok(match &self.analysis {
            AnalysisText::Named(analysis) => analysis.clone(),
            AnalysisText::File(path, read) => match read.get() {
                Some(test) => test.clone().into(),
                None => test_file::of_deck(path).map(|test| read.get_or_init(|| test).clone())?.into(),
            },
        })
    }

    /// Contents of the deck as far as flags say them.
    pub(super) fn options(&self) -> Result<DeckOptions, Failure> {
        Ok(DeckOptions { analysis: self.analysis()?, ..self.given.options.clone() })
    }

    /// The file of a test.
    pub(super) fn file(&self) -> Option<&Path> {
        if let AnalysisText::File(path, _) = &self.analysis { Some(path) } else { None }
    }

    /// Whether the deck computes something, by its own step or by one that is added to it.
    pub(super) fn analyses(&self) -> bool {
        (self.analysis != AnalysisText::Named(Analysis::None) || self.given.options.with_damage)
            && !self.given.options.geometry_only
    }

    /// The first option that only a deck has. An analysis also decides mesh and packing, a time increment the figures.
    pub(super) fn only_for_decks(&self) -> Option<String> {
        let key = self.given.asked().find(|key| *key != "time_increment_s");
        key.map(|key| self.given.giver().option(key))
    }
}
