//! Results of a test: a curve, figures, frames and a page, each written to an `impl Write`.
//!
//! Both fronts, the command and Python, write the same [`ResultFile`]s of one [`Outcome`]; files are theirs.

mod layers;
mod page;
mod png;
mod section;
mod shots;
mod snapshot;

pub use meso_view::vtk::Still;
pub use meso_view::vtk::mesh::Unread;
pub use shots::{Shooting, Shot, ShotFile};
pub use snapshot::{Moment, Snapshot};

use crate::march::{Extra, Response, Row};
use meso_mesh::{Mesh, MeshOptions, PhaseVolumes};
use meso_pack::Model;
use meso_trial::Sample;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};

/// The mesh of `model` that `options` gave, ready to be tested, with the exact volumes of its phases.
pub fn sample_of<'a>(mesh: &'a Mesh, model: &Model, options: &MeshOptions) -> Sample<'a> {
    let exact = PhaseVolumes::exact_for(mesh, &model.bodies(), &model.spec.specimen);
    Sample { exact, ..Sample::of(mesh, &model.spec.specimen, options) }
}

/// A test that came to its end, with its mesh, source and times.
#[derive(Clone, Copy, Debug)]
pub struct Outcome<'a> {
    /// The mesh that was tested.
    pub mesh: &'a Mesh,
    /// The response.
    pub response: &'a Response,
    /// Where the mesh came from.
    pub source: &'a Source,
    /// The frames that have a file.
    pub frames: &'a [Moment],
    /// Moments before the end that the page shows.
    pub taken: &'a ShotFile,
    /// The end; a run that diverged has none.
    pub last: Option<&'a Snapshot>,
    /// How long it took.
    pub seconds: TestSeconds,
}

/// Where a tested mesh came from.
#[derive(Clone, Debug, Serialize)]
pub struct Source {
    /// Version of mesocrete.
    pub version: String,
    /// Seed of the packing.
    pub seed: u64,
    /// Volume of the aggregates over the specimen's.
    pub fraction: f64,
    /// Options of the mesh.
    pub mesh: MeshOptions,
}

impl Source {
    /// Source of a mesh of `model`.
    pub fn of(model: &Model, mesh: &MeshOptions) -> Self {
        let (seed, fraction) = (model.report.seed, model.report.fraction);
        Self { version: env!("CARGO_PKG_VERSION").to_owned(), seed, fraction, mesh: mesh.for_bodies(&model.aggregates) }
    }
}

/// How long the parts took, s.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TestSeconds {
    /// Packing; 0 where a saved model was read.
    pub pack: f64,
    /// Meshing.
    pub mesh: f64,
    /// From the mesh to the end of the curve, frames included.
    pub solve: f64,
    /// All of it until the results are written.
    pub total: f64,
}

/// A file of results; frames have their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultFile {
    /// The curve.
    Curve,
    /// The figures.
    Figures,
    /// The list of frames.
    Collection,
    /// The page.
    Page,
}

impl ResultFile {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Curve, Self::Figures, Self::Collection, Self::Page];

    /// Its name in the folder of results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Curve => "curve.csv",
            Self::Figures => "result.json",
            Self::Collection => "frames.pvd",
            Self::Page => "result.html",
        }
    }

    /// Writes it.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write(self, outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Curve => write_curve(&outcome.response.curve, &outcome.response.extra, out),
            Self::Figures => write_figures(outcome, out),
            Self::Collection => write_collection(outcome.frames, out),
            Self::Page => page::write(outcome, out),
        }
    }
}

/// Writes a header of [`Row::COLUMNS`] and the names of further columns, and a line for every row, in digits that read back
/// to the same numbers; no zero has a sign.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_curve(rows: &[Row], extra: &Extra, out: &mut dyn Write) -> io::Result<()> {
    let mut out = io::BufWriter::new(out);
    let names = Row::COLUMNS.into_iter().chain(extra.names.iter().map(String::as_str));
    writeln!(out, "{}", names.collect::<Vec<_>>().join(","))?;
    for (number, row) in rows.iter().enumerate() {
        let values = row.values().into_iter().chain(extra.row(number).iter().copied());
        writeln!(out, "{}", values.map(|value| format!("{:?}", value + 0.0)).collect::<Vec<_>>().join(","))?;
    }
    out.flush()
}

/// Content of `result.json`.
#[derive(Serialize)]
struct Figures<'a> {
    #[serde(flatten)]
    response: &'a Response,
    frames: Vec<FrameFigures<'a>>,
    #[serde(flatten)]
    source: &'a Source,
    seconds: TestSeconds,
}

#[derive(Serialize)]
struct FrameFigures<'a> {
    file: String,
    #[serde(flatten)]
    moment: &'a Moment,
}

/// The figures of an outcome as a tree, the content of `result.json`.
///
/// # Errors
/// None that is known.
pub fn figures(outcome: &Outcome) -> serde_json::Result<serde_json::Value> {
    let Outcome { response, source, seconds, .. } = *outcome;
    let frames = outcome.frames.iter().map(|moment| FrameFigures { file: moment.file(), moment }).collect();
    serde_json::to_value(Figures { response, frames, source, seconds })
}

fn write_figures(outcome: &Outcome, out: &mut dyn Write) -> io::Result<()> {
    serde_json::to_writer_pretty(&mut *out, &figures(outcome)?)?;
    writeln!(out)
}

/// The frames as ParaView and PyVista read them; their time is the strain, or the time of a test whose strain does not only grow.
fn write_collection(frames: &[Moment], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>")?;
    let grows = frames.windows(2).all(|pair| pair[0].strain < pair[1].strain);
    for moment in frames {
        let time = if grows { moment.strain } else { moment.time_s };
        writeln!(out, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{}\"/>", moment.file())?;
    }
    writeln!(out, "</Collection>\n</VTKFile>")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_reads_back_to_the_same_numbers() {
        let row = Row { strain: 1.0 / 3.0, stress_mpa: 1e-300, time_s: 0.1 + 0.2, ..Row::default() };
        let mut text = Vec::new();
        let extra = Extra { names: vec!["top_n".to_owned()], values: vec![0.25] };
        write_curve(&[row], &extra, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next().unwrap(), Row::COLUMNS.join(",") + ",top_n");
        let read: Vec<f64> = lines.next().unwrap().split(',').map(|value| value.parse().unwrap()).collect();
        assert_eq!((read, lines.next()), ([&row.values()[..], &[0.25]].concat(), None));
    }

    #[test]
    fn a_collection_names_its_frames_by_strain() {
        let moment = |number: u32| Moment { number, strain: 0.001 * f64::from(number), ..Moment::default() };
        let mut text = Vec::new();
        write_collection(&[moment(1), moment(2)], &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains("timestep=\"0.002\" part=\"0\" file=\"frame_0002.vtu\""), "{text}");
        let still = |number: u32| Moment { number, time_s: 1e-6 * f64::from(number), ..Moment::default() };
        let mut text = Vec::new();
        write_collection(&[still(1), still(2)], &mut text).unwrap();
        assert!(String::from_utf8(text).unwrap().contains("timestep=\"0.000002\" part=\"0\" file=\"frame_0002.vtu\""));
    }
}
