//! Outputs of `mesocrete pack`: their destinations, and the writing.

use super::flags::Args;
use crate::commands::mesh;
use crate::failure::Failure;
use crate::formats::{Content, Named};
use crate::outputs::{self, Target, Unit};
use crate::progress::Watch;
use meso_ask::{DeckAsk, Giver};
use meso_core::export::abaqus::DeckOptions;
use meso_core::formats::{Format, MeshFormat, SurfaceOptions};
use meso_core::mesh::Mesh;
use meso_core::packing::{Report, Seconds};
use meso_core::specimen::Specimen;
use meso_core::statistics::{Statistics, StatisticsOptions};
use meso_core::watch::Stage;
use meso_core::{Model, Watch as _, page};
use std::path::{Path, PathBuf};

impl Args {
    /// The files to write, or the usual ones.
    fn outputs(&self) -> Vec<Named<Content>> {
        let usual = ["model.json", "model.vtu", "model.inp", "model.html"].map(PathBuf::from);
        if self.output.is_empty() { usual.into_iter().flat_map(Named::of).collect() } else { self.output.clone() }
    }

    /// Formats of the meshes to write.
    pub(super) fn mesh_formats(&self) -> Vec<MeshFormat> {
        let mesh = |output: Named<Content>| if let Content::Mesh(format) = output.format { Some(format) } else { None };
        self.outputs().into_iter().filter_map(mesh).collect()
    }

    /// Destinations of all outputs; refuses those that cannot be written before anything is packed.
    pub(super) fn plan(&self, ask: &DeckAsk) -> Result<Plan, Failure> {
        let force = self.writing.force;
        let target = |Named { path, format: content }: Named<Content>| {
            let target = match content {
                Content::Packing(_) | Content::Page => Target::new(&path, force),
                Content::Mesh(format) => mesh::target(&Named { path, format }, force, ask),
            };
            Ok((target?, content))
        };
        let outputs = self.outputs().into_iter().map(target).collect::<Result<Vec<_>, Failure>>()?;
        let summary = self.summary_json.as_ref().map(|path| Target::new(path, force)).transpose()?;
        let all: Vec<&Target> = outputs.iter().map(|(target, _)| target).chain(&summary).collect();
        outputs::distinct(&all, &self.spec.as_deref().into_iter().chain(self.meshing.inputs()).collect::<Vec<_>>())?;
        let surfaces = SurfaceOptions { compress: self.compress, images: self.images, ..SurfaceOptions::default() };
        let packing = |content: &Content| if let Content::Packing(format) = content { Some(*format) } else { None };
        let formats: Vec<Format> = outputs.iter().filter_map(|(_, content)| packing(content)).collect();
        let accepted = surfaces.accept(&formats, &self.mesh_formats());
        accepted.map_err(|error| Failure::Usage(ask.given.refusal(&error)))?;
        Ok(Plan { outputs, summary, force, surfaces })
    }
}

/// Destinations of all outputs.
pub(super) struct Plan {
    outputs: Vec<(Target, Content)>,
    summary: Option<Target>,
    force: bool,
    surfaces: SurfaceOptions,
}

impl Plan {
    /// The files that were written, those of meshes where there is one.
    pub(super) fn files(&self, has_mesh: bool) -> impl Iterator<Item = &Path> {
        let is_there = move |content: &Content| has_mesh || !matches!(content, Content::Mesh(_));
        let there = self.outputs.iter().filter(move |(_, content)| is_there(content)).map(|(target, _)| target);
        there.chain(&self.summary).filter_map(Target::file)
    }

    /// The next step: the page, where one is written, else the command that writes it.
    pub(super) fn next(&self) -> Option<String> {
        let of = |wanted: Content| self.outputs.iter().find(|(_, content)| *content == wanted);
        let file = |wanted| of(wanted).and_then(|(target, _)| target.file()).map(|path| path.display().to_string());
        let page = || file(Content::Page).map(|page| format!("next: open {page} in a browser"));
        let model = || {
            let model = file(Content::Packing(Format::Json))?;
            let page = Path::new(&model).with_extension("html");
            Some(format!("next: mesocrete report {model} -o {}", page.display()))
        };
        page().or_else(model)
    }

    pub(super) fn meshes(&self) -> impl Iterator<Item = (&Target, MeshFormat)> {
        self.outputs.iter().filter_map(|(target, content)| match content {
            Content::Mesh(format) => Some((target, *format)),
            Content::Packing(_) | Content::Page => None,
        })
    }

    /// Refuses surfaces that the specimen cannot have.
    pub(super) fn suits(&self, specimen: &Specimen) -> Result<(), Failure> {
        self.surfaces.suits(specimen).map_err(|error| Failure::Usage(Giver::Flags.refusal(&error)))
    }

    pub(super) fn has_mesh(&self) -> bool {
        self.outputs.iter().any(|(_, content)| matches!(content, Content::Mesh(_)))
    }

    /// Writes all files: pages after the others, as their statistics may take long, and the summary last, because it states
    /// how long the others took.
    pub(super) fn write(
        &self,
        model: &Model,
        mesh: Option<(&Mesh, &DeckOptions)>,
        watch: &Watch,
    ) -> Result<(), Failure> {
        let start = watch.elapsed();
        let (pages, others): (Vec<_>, Vec<_>) = self.outputs.iter().partition(|(_, content)| *content == Content::Page);
        let mut unit = Unit::default();
        for (number, (target, content)) in others.into_iter().enumerate() {
            watch.stage(Stage::Write, number as f64 / self.outputs.len() as f64);
            match (content, mesh) {
                (Content::Packing(format), _) => {
                    unit.fill(target, self.force, |out| format.write(model, self.surfaces, out))?;
                }
                (Content::Mesh(format), Some((mesh, deck))) => {
                    mesh::fill(&mut unit, target, self.force, *format, mesh, deck, self.surfaces.compress)?;
                }
                (Content::Mesh(_), None) | (Content::Page, _) => {}
            }
        }
        if !pages.is_empty() {
            std::mem::take(&mut unit).commit()?;
            watch.has_but_the_page();
        }
        for (target, _) in pages {
            self.fill_page(&mut unit, target, model, mesh.map(|(mesh, _)| mesh), watch)?;
        }
        if let Some(target) = &self.summary {
            let total = watch.elapsed();
            let seconds = Seconds { write: total - start, total, ..model.report.seconds };
            let summary = Report { seconds, ..model.report.clone() };
            unit.fill(target, self.force, |out| {
                serde_json::to_writer_pretty(&mut *out, &summary)?;
                writeln!(out)
            })?;
        }
        unit.commit()
    }
}

impl Plan {
    /// A page of fewer samples than `report` takes: a newcomer waits for it.
    fn fill_page(
        &self,
        unit: &mut Unit,
        target: &Target,
        model: &Model,
        mesh: Option<&Mesh>,
        watch: &Watch,
    ) -> Result<(), Failure> {
        let figures = Statistics::watched(model, &StatisticsOptions::quick(), watch)
            .map_err(|error| Failure::Run(error.to_string()))?;
        unit.fill(target, self.force, |out| page::write(model, &figures, mesh, out))
    }
}
