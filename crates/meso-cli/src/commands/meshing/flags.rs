//! Flags of a mesh and of its deck, as users type them.

use super::gmsh::Announced;
use crate::commands::file_or::FileOr;
use crate::commands::names;
use crate::failure::Failure;
use crate::inputs;
use crate::stderr::flag;
use clap::builder::TypedValueParser;
use meso_ask::{DeckAsk, Given, MeshAsk, files};
use meso_core::export::abaqus::{Analysis, DeckOptions, Plain};
use meso_core::materials::Materials;
use meso_core::mesh::{MeshTable, MethodName};
use meso_gmsh::Gmsh;
use meso_solve::TestKind;
use std::path::{Path, PathBuf};

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Mesh and materials")]
pub(crate) struct MeshFlags {
    #[command(flatten)]
    given: Given<MeshTable>,
    /// Accept a phase more than 10 % off its exact volume, which is an error otherwise; results carry a flag then
    #[arg(long, hide_short_help = true)]
    accept_phase_error: bool,
    /// A TOML file with a [materials] table; absent values keep their illustrative defaults
    #[arg(long, value_name = "FILE")]
    materials: Option<PathBuf>,
    /// The program gmsh, for --method conforming [default: gmsh]
    #[arg(long, value_name = "PROGRAM", hide_short_help = true)]
    gmsh: Option<PathBuf>,
}

impl MeshFlags {
    /// The mesh that is asked for, with the materials of the file.
    pub(crate) fn ask(&self) -> Result<MeshAsk, Failure> {
        if self.gmsh.is_some() && self.given.options.method != Some(MethodName::Conforming) {
            let [gmsh, method] = ["gmsh", "method"].map(flag);
            return Err(Failure::Usage(format!(
                "{gmsh} has no effect; only {method} conforming takes it: leave it out"
            )));
        }
        let read = |path: &Path| files::materials(path, &inputs::text);
        let materials = self.materials.as_deref().map_or_else(|| Ok(Materials::default()), read)?;
        Ok(MeshAsk { materials: Some(materials), ..self.unread() })
    }

    /// The mesh that is asked for, as far as no file is read.
    pub(crate) fn unread(&self) -> MeshAsk {
        MeshAsk {
            given: self.given.clone(),
            accept_phase_error: self.accept_phase_error,
            materials: self.materials.is_none().then(Materials::default),
            ..MeshAsk::default()
        }
    }

    /// The program gmsh, which is silent if the command is `quiet`.
    pub(crate) fn gmsh(&self, quiet: bool) -> Announced {
        Announced { gmsh: Gmsh::program(self.gmsh.as_deref().unwrap_or(Path::new("gmsh"))), quiet }
    }

    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.materials.iter().map(PathBuf::as_path)
    }
}

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
#[command(next_help_heading = "Decks")]
struct DeckFlags {
    #[arg(long, value_name = "NAME|TEST.toml", default_value = "none", value_parser = analysis_parser())]
    #[arg(help = format!(
        "Analysis of the deck; any but none meshes, and packs, for a test: {}, or a test: {}, or a TEST.toml",
        names::list::<Plain>(),
        names::list::<TestKind>()
    ))]
    analysis: AnalysisText,
    #[command(flatten)]
    given: Given<DeckOptions>,
}

/// An analysis as users type it.
#[derive(Clone, Debug, PartialEq)]
enum AnalysisText {
    Named(Analysis),
    File(PathBuf),
}

/// Parser of an analysis.
fn analysis_parser() -> impl TypedValueParser<Value = AnalysisText> {
    let read = |name: &str| {
        let plain = names::read(name).map(|plain: Plain| plain.into());
        plain.or_else(|_| names::read(name).map(|kind: TestKind| kind.into())).map(AnalysisText::Named)
    };
    let name = names::parser_of([names::all::<Plain>(), names::all::<TestKind>()].concat(), read);
    FileOr { file: AnalysisText::File, name }
}

// A doc comment here would become the command's own description.
#[derive(clap::Args, Debug)]
pub(crate) struct Meshing {
    #[command(flatten)]
    pub(crate) mesh: MeshFlags,
    #[command(flatten)]
    deck: DeckFlags,
}

impl Meshing {
    /// The mesh and the deck that are asked for, with the content of the files.
    pub(crate) fn ask(&self) -> Result<DeckAsk, Failure> {
        let analysis = match &self.deck.analysis {
            AnalysisText::Named(analysis) => analysis.clone(),
            AnalysisText::File(path) => files::test(path, &inputs::text)?.into(),
        };
        Ok(DeckAsk { mesh: self.mesh.ask()?, analysis: Some(analysis), ..self.unread() })
    }

    /// The mesh and the deck that are asked for, as far as no file is read.
    pub(crate) fn unread(&self) -> DeckAsk {
        let analysis = match &self.deck.analysis {
            AnalysisText::Named(analysis) => Some(analysis.clone()),
            AnalysisText::File(_) => None,
        };
        DeckAsk { mesh: self.mesh.unread(), given: self.deck.given.clone(), analysis }
    }

    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let test = if let AnalysisText::File(path) = &self.deck.analysis { Some(path.as_path()) } else { None };
        self.mesh.inputs().chain(test)
    }
}
