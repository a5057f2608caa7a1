//! Reading a saved model, which may come from anywhere: everything a later step relies on is looked at here.
//!
//! Convexity, overlaps and the specimen's walls are not: [`check`](crate::check) proves those.

use super::polygons::Polygons;
use super::{VERSION, gzip, seal};
use crate::accept::{self, Fault};
use crate::model::{Model, target};
use meso_collision::geometry::{Polyhedron, Round};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::{Aggregate, Kind, Shell, ShellLaw};
use meso_concrete::stop;
use meso_concrete::watch::{Silent, Stage, Watch};
use meso_concrete::{PhaseNames, mark_caps};
use meso_place::Report;
use meso_spec::distinct;
use meso_spec::{MAX_LENGTH_MM, NoFiles, Spec, SpecError, options_from_value};
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::borrow::Cow;
use std::collections::BTreeSet;

/// Why a file is no saved model.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// Not JSON, or not with the keys a model has.
    #[error("this is not a saved model of mesocrete: {0}")]
    NotAModel(String),
    /// Changed since it was written.
    #[error(
        "its checksum does not fit: the file was damaged or edited; take another copy, or remove its last entry, crc32, to \
         read it all the same"
    )]
    Damaged,
    /// Written by a version that may mean something else.
    #[error("it was written by mesocrete {found}, and this is {VERSION}, which cannot read it: update mesocrete")]
    Version {
        /// The file's text.
        found: String,
    },
    /// Its spec cannot be.
    #[error("its spec is wrong: {0}")]
    Spec(#[from] SpecError),
    /// Values that no model has.
    #[error(transparent)]
    Fault(#[from] Fault),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct SavedFile {
    mesocrete: String,
    #[serde(deserialize_with = "distinct::value")]
    spec: serde_json::Value,
    seed: u64,
    #[serde(deserialize_with = "distinct::value")]
    specimen: serde_json::Value,
    report: Option<Report>,
    aggregates: Vec<FileAggregate>,
    #[serde(default)]
    inclusions: Vec<FileInclusion>,
    /// Proved before the rest is parsed.
    #[serde(default, rename = "crc32")]
    _seal: Option<IgnoredAny>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileAggregate {
    id: u32,
    class: u16,
    itz_thickness_mm: f64,
    #[serde(default)]
    phase: Option<String>,
    #[serde(default)]
    shells_mm: Vec<f64>,
    #[serde(default)]
    dents: bool,
    #[serde(default)]
    round: bool,
    vertices: Vec<[f64; 3]>,
    faces: Polygons,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileInclusion {
    id: u32,
    phase: Kind,
    vertices: Vec<[f64; 3]>,
    faces: Polygons,
}

/// Reads the bytes of a saved model, compressed or not.
///
/// A file without a `report` gets the figures that follow from its aggregates.
///
/// # Errors
/// See [`ReadError`].
pub fn read(bytes: &[u8]) -> Result<Model, ReadError> {
    read_while(bytes, &Silent)
}

/// Bytes of a model that takes a good part of a second to read.
const LONG: usize = 16 << 20;
/// Shares of the stage [`Stage::Read`] that are over when the bytes are there, and when they are parsed and the proof of a
/// surface begins.
const LOADED: f64 = 0.05;
const PARSED: f64 = 0.3;

/// Reads a model like [`read`], and reports to `watch`: a long file and the proof of a surface of a million triangles
/// take seconds. A time limit of the model's spec was its packing's, and does not count here.
///
/// # Errors
/// See [`ReadError`].
pub fn read_while(bytes: &[u8], watch: &dyn Watch) -> Result<Model, ReadError> {
    let reading = Reading { watch, is_long: bytes.len() >= LONG };
    reading.tell(LOADED);
    let text = if bytes.starts_with(&gzip::MAGIC) {
        Cow::Owned(gzip::expand(bytes).map_err(ReadError::NotAModel)?)
    } else {
        Cow::Borrowed(bytes)
    };
    if let Some(other) = other_kind(&text) {
        return Err(ReadError::NotAModel(other.to_owned()));
    }
    let is_whole = seal::is_whole(&text);
    let file = serde_json::from_slice::<SavedFile>(&text);
    drop(text);
    reading.tell(PARSED);
    // A later version may seal its files in another way.
    file.as_ref().map_or(Ok(()), |file| accept_version(&file.mesocrete))?;
    if !is_whole {
        return Err(ReadError::Damaged);
    }
    let file = file.map_err(|error| ReadError::NotAModel(error.to_string()))?;
    let is_found = file.report.as_ref().is_some_and(|report| report.labels.is_some());
    let spec = if is_found {
        Spec::from_described(&file.spec, &reading)?
    } else {
        Spec::from_value_while(&file.spec, &mut NoFiles, &reading, None)?
    };
    accept_repeats(&file, &spec)?;
    let (classes, phases) = (spec.grading.classes().len(), spec.phases());
    let aggregates = file.aggregates.into_iter().enumerate();
    let mut aggregates =
        aggregates.map(|(i, a)| aggregate(i, a, classes, &spec, &phases)).collect::<Result<Vec<_>, _>>()?;
    mark_caps(&mut aggregates, &spec.specimen);
    let inclusions = (aggregates.len()..).zip(file.inclusions);
    let inclusions = inclusions.map(|(i, body)| inclusion(i, body, &spec)).collect::<Result<Vec<_>, _>>()?;
    let report = match file.report {
        Some(report) => {
            accept::report(&report, &spec, aggregates.len())?;
            report
        }
        None => Report::of_bodies(&target(&spec), &aggregates, &inclusions),
    };
    Ok(Model { spec, aggregates, inclusions, report })
}

/// Hears how far reading is, and has no clock.
struct Reading<'a> {
    watch: &'a dyn Watch,
    is_long: bool,
}

impl Reading<'_> {
    /// This share of the stage is over; a short file is read before anybody looks.
    fn tell(&self, share: f64) {
        if self.is_long {
            self.watch.stage(Stage::Read, share);
        }
    }
}

impl Watch for Reading<'_> {
    fn stage(&self, stage: Stage, share: f64) {
        self.watch.stage(stage, PARSED + (1.0 - PARSED) * share);
    }
}

/// Guesses the kind of a file that does not begin like a model, and names the way out.
fn other_kind(text: &[u8]) -> Option<&'static str> {
    let mut lines = text.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.find(|line| !line.is_empty() && line[0] != b'#').unwrap_or_default();
    match first {
        [b'{', ..] => None,
        [] => Some("it is empty"),
        [b'*', ..] => Some("it is a deck, which holds a mesh; name the .json that it was made from"),
        [b'<', ..] => Some("it is XML or a page; name the .json that it was made from"),
        [b'[', second, ..] if second.is_ascii_alphabetic() || *second == b'[' => Some(A_SPEC),
        line if line[0].is_ascii_alphabetic() && line.contains(&b'=') => Some(A_SPEC),
        _ => Some("it does not begin with {; name the .json or .json.gz of a saved packing"),
    }
}

/// Said of TOML.
const A_SPEC: &str = "it is TOML, as a spec is; pack it first, and save the packing as .json";

/// Accepts this major version with this minor version or an older one.
fn accept_version(found: &str) -> Result<(), ReadError> {
    let numbers = |version: &str| {
        let parts = version.split('.').map(|part| part.parse::<u32>().ok()).collect::<Option<Vec<_>>>()?;
        <[u32; 3]>::try_from(parts).ok()
    };
    match (numbers(found), numbers(VERSION)) {
        _ if found == VERSION => Ok(()),
        (Some([major, minor, _]), Some(own)) if major == own[0] && minor <= own[1] => Ok(()),
        _ => Err(ReadError::Version { found: found.chars().take(40).collect() }),
    }
}

/// `seed` and `specimen` stand twice in the file.
fn accept_repeats(file: &SavedFile, spec: &Spec) -> Result<(), Fault> {
    if file.seed != spec.seed {
        let message = format!("seed is {} but spec.seed is {}; they must agree", file.seed, spec.seed);
        return Err(Fault::Contradiction(message));
    }
    let specimen = options_from_value(&file.specimen).ok();
    if specimen.as_ref() != Some(&spec.specimen) {
        return Err(Fault::Contradiction("specimen and spec.specimen differ; they must agree".to_owned()));
    }
    Ok(())
}

fn aggregate(
    index: usize,
    file: FileAggregate,
    classes: usize,
    spec: &Spec,
    phases: &PhaseNames,
) -> Result<Aggregate, Fault> {
    let wrong = |reason: String| Fault::Aggregate { index, reason };
    accept::values(index, file.id, (file.class, classes), file.itz_thickness_mm).map_err(wrong)?;
    let FileAggregate { id, class, itz_thickness_mm, phase, shells_mm, dents, round, vertices, faces } = file;
    let own = phase.map(|name| phases.find(&name).ok_or(name)).transpose();
    let own = own.map_err(|name| wrong(format!("its phase is {name:?}; the spec has none of this name in phases")))?;
    let laws = spec.shells_of(own);
    if shells_mm.len() != laws.len() || shells_mm.iter().any(|thickness| !(0.0..=MAX_LENGTH_MM).contains(thickness)) {
        return Err(wrong(format!(
            "its shells_mm are {shells_mm:?}; the spec gives it {} shells of 0 mm or more",
            laws.len()
        )));
    }
    let shell =
        |((own, law), thickness_mm): (&(u8, &ShellLaw), f64)| Shell { own: *own, thickness_mm, outward: law.outward };
    let shells = laws.iter().zip(shells_mm).map(shell).collect();
    if let Some(face) = faces.iter().position(|face| dents && face.len() != 3) {
        return Err(wrong(format!("face {face} is no triangle, which all faces of an aggregate with dents are")));
    }
    let body = body(vertices, faces).map_err(wrong)?;
    let body = match (dents, round) {
        (true, true) => return Err(wrong("it has dents and is round; it can be one of them".to_owned())),
        (true, false) => body.with_dents(),
        (false, true) => rounded(&body).map_err(wrong)?,
        (false, false) => body,
    };
    Ok(Aggregate { id, kind: Kind::Aggregate, own, class, itz_thickness_mm, shells, body })
}

/// The ball or ellipsoid over an octahedron of its ends.
fn rounded(octahedron: &Polyhedron) -> Result<Polyhedron, String> {
    let ends = octahedron.vertices();
    let is_sound = ends.len() == 6 && Round::of_ends(ends).is_sound(ends, TILT * octahedron.aabb().size().max());
    let fault = || "it is round, and its vertices are not the six ends of an ellipsoid's axes".to_owned();
    if is_sound { Ok(Polyhedron::of_ends(ends)) } else { Err(fault()) }
}

/// Share of its size by which the axes of a ball or an ellipsoid may miss the right angle in a file.
const TILT: f64 = 1e-3;

/// A void or fibre, of the phases that the spec asks for.
fn inclusion(index: usize, file: FileInclusion, spec: &Spec) -> Result<Aggregate, Fault> {
    let wrong = |reason: String| Fault::Inclusion { index, reason };
    if file.id as usize != index {
        return Err(wrong(format!("its id is {}; ids count on from the last aggregate's", file.id)));
    }
    let mut asked = Kind::FURTHER.into_iter().zip(spec.inclusions().fractions());
    let Some(index) = asked.position(|(kind, fraction)| kind == file.phase && fraction > 0.0) else {
        return Err(wrong(format!("its phase is {}; the spec asks for none", file.phase.name())));
    };
    let class = (spec.grading.classes().len() + index) as u16;
    let body = body(file.vertices, file.faces).map_err(wrong)?;
    Ok(Aggregate { id: file.id, kind: file.phase, own: None, class, itz_thickness_mm: 0.0, shells: Vec::new(), body })
}

fn body(vertices: Vec<[f64; 3]>, faces: Polygons) -> Result<Polyhedron, String> {
    stop::point();
    let vertices: Vec<Vec3> = vertices.into_iter().map(Vec3::from).collect();
    accept::in_reach(&vertices)?;
    closed_surface(vertices.len(), &faces)?;
    Ok(Polyhedron::from_parts(vertices, faces.iter()))
}

/// Every face has three corners or more, all of them there, every edge is passed once in each direction, and no vertex is
/// left over.
fn closed_surface(vertices: usize, faces: &Polygons) -> Result<(), String> {
    if vertices < 4 || faces.len() < 4 {
        return Err(format!("{vertices} vertices and {} faces; a solid has at least 4 of each", faces.len()));
    }
    let (mut edges, mut is_named) = (BTreeSet::new(), vec![false; vertices]);
    for (f, face) in faces.iter().enumerate() {
        if face.len() < 3 {
            return Err(format!("face {f} has {} corners; it takes at least 3", face.len()));
        }
        if let Some(corner) = face.iter().find(|&&corner| corner as usize >= vertices) {
            return Err(format!("face {f} names vertex {corner}; there are {vertices}, counted from 0"));
        }
        for (i, &from) in face.iter().enumerate() {
            let to = face[(i + 1) % face.len()];
            is_named[from as usize] = true;
            if from == to || !edges.insert((from, to)) {
                return Err(format!("face {f} passes the edge {from}-{to} a second time in the same direction"));
            }
        }
    }
    if let Some(vertex) = is_named.iter().position(|is_named| !is_named) {
        return Err(format!("vertex {vertex} is the corner of no face; leave it out"));
    }
    match edges.iter().find(|&&(from, to)| !edges.contains(&(to, from))) {
        Some((from, to)) => {
            Err(format!("the edge {from}-{to} has a face on one side only; the surface must be closed"))
        }
        None => Ok(()),
    }
}
