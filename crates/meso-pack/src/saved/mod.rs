//! The saved model, `.json`: everything a packing is, bit for bit.
//!
//! `{"mesocrete": version, "spec", "seed", "specimen", "report", "aggregates": [{"id", "class", "itz_thickness_mm",
//! "vertices": [[x, y, z], ...], "faces": [[i, j, k, ...], ...]}, ...]}`. One line per aggregate; coordinates in the
//! specimen's frame, mm, written as the shortest decimal that reads back to the same f64; faces are convex polygons,
//! counter-clockwise from outside. An aggregate with `"dents": true` need not be convex, and its faces are triangles. An aggregate of a phase of its own has
//! the name of it, `"phase"`, one with shells their thicknesses, `"shells_mm"`. Voids and fibres, where there are some, follow as `"inclusions": [{"id", "phase",
//! "vertices", "faces"}, ...]`, their ids counting on from the last aggregate's. `report` leaves out `seconds`, so
//! that the same spec and seed give the same bytes. The last entry, `crc32`, is the checksum of all bytes before it.
//!
//! `.json.gz` is the same text, compressed in members of 1 MB (RFC 1952), which `gunzip` and Python's `gzip` read as one.

mod gzip;
mod polygons;
mod read;
mod seal;

pub use read::read_while;
pub use read::{ReadError, read};

use crate::model::Model;
use meso_collision::geometry::{BodyForm, Face, Polyhedron};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::{Phase, PhaseNames, parallel};
use meso_place::{Report, Seconds};
use serde::Serialize;
use std::io::{self, BufWriter, Write};

/// The version whose form of the file this is.
pub(crate) const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Most lines are shorter: 30 vertices and 56 faces.
const LINE_BYTES: usize = 3072;
/// Aggregates whose lines each thread makes at once.
const AT_ONCE: usize = 32;

/// Writes `model` to `out`, some aggregates at a time.
///
/// # Errors
/// Fails with the errors of `out`, and refuses a model that could not be read back.
pub fn write(model: &Model, mut out: impl Write) -> io::Result<()> {
    write_to(model, &mut out)
}

/// Writes `model`; compiled once, here.
fn write_to(model: &Model, out: &mut dyn Write) -> io::Result<()> {
    model.accept().map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    let mut out = BufWriter::with_capacity(1 << 15, seal::Sealing::new(out));
    out.write_all(b"{")?;
    entry(&mut out, "mesocrete", VERSION)?;
    text(&mut out, "spec", &model.spec.to_json()?)?;
    entry(&mut out, "seed", &model.spec.seed)?;
    text(&mut out, "specimen", &model.spec.specimen_to_json()?)?;
    entry(&mut out, "report", &without_seconds(&model.report)?)?;
    let phases = model.spec.phases();
    list(&mut out, "aggregates", &model.aggregates, |aggregate, out| write_aggregate(aggregate, &phases, out))?;
    if !model.inclusions.is_empty() {
        out.write_all(b",\n")?;
        list(&mut out, "inclusions", &model.inclusions, write_inclusion)?;
    }
    out.flush()?;
    let end = out.get_ref().end();
    out.write_all(&end)?;
    out.flush()
}

/// Writes the model as JSON, compressed by gzip.
///
/// # Errors
/// Fails like [`write`].
pub fn write_compressed(model: &Model, mut out: impl Write) -> io::Result<()> {
    let mut out = gzip::Members::new(&mut out as &mut dyn Write);
    write_to(model, &mut out)?;
    out.finish()
}

/// One line per body; some of them are made at a time, on the threads of the pool that this is called in. Outside of
/// any it starts none: a process that was forked from one with a pool would wait for threads that it does not have.
fn list(
    out: &mut impl Write,
    key: &str,
    bodies: &[Aggregate],
    write: impl Fn(&Aggregate, &mut Vec<u8>) -> io::Result<()> + Sync,
) -> io::Result<()> {
    write!(out, "\"{key}\": [")?;
    let lines = |some: &[Aggregate]| -> io::Result<Vec<u8>> {
        let mut lines = Vec::with_capacity(LINE_BYTES * some.len());
        for body in some {
            lines.extend_from_slice(if std::ptr::eq(body, &bodies[0]) { b"\n" } else { b",\n" });
            write(body, &mut lines)?;
        }
        Ok(lines)
    };
    for several in bodies.chunks(AT_ONCE * threads()) {
        // Longer than the buffer: they go past it.
        in_chunks(several, AT_ONCE, lines)?.iter().try_for_each(|lines| out.write_all(lines))?;
    }
    out.write_all(b"\n]")
}

/// Threads of the pool that this is called in; 1 outside of any.
fn threads() -> usize {
    rayon::current_thread_index().map_or(1, |_| rayon::current_num_threads())
}

/// Maps every chunk by `make`, on all [`threads`].
fn in_chunks<T: Sync>(
    values: &[T],
    size: usize,
    make: impl Fn(&[T]) -> io::Result<Vec<u8>> + Sync,
) -> io::Result<Vec<Vec<u8>>> {
    let chunks: Vec<&[T]> = values.chunks(size).collect();
    if threads() > 1 {
        parallel::try_map(chunks.len(), |i| make(chunks[i]))
    } else {
        chunks.into_iter().map(make).collect()
    }
}

fn entry(out: &mut impl Write, key: &str, value: &(impl Serialize + ?Sized)) -> io::Result<()> {
    text(out, key, &serde_json::to_string(value)?)
}

/// An entry whose value is JSON text.
fn text(out: &mut impl Write, key: &str, json: &str) -> io::Result<()> {
    writeln!(out, "\"{key}\": {json},")
}

fn without_seconds(report: &Report) -> io::Result<serde_json::Value> {
    let mut value = serde_json::to_value(Report { seconds: Seconds::default(), ..report.clone() })?;
    if let Some(entries) = value.as_object_mut() {
        entries.remove("seconds");
    }
    Ok(value)
}

fn write_aggregate(aggregate: &Aggregate, phases: &PhaseNames, out: &mut Vec<u8>) -> io::Result<()> {
    write!(out, "{{\"id\":{},\"class\":{},\"itz_thickness_mm\":", aggregate.id, aggregate.class)?;
    serde_json::to_writer(&mut *out, &aggregate.itz_thickness_mm)?;
    if let Some(own) = aggregate.own {
        write!(out, ",\"phase\":\"{}\"", phases.name(Phase::Own(own)))?;
    }
    if !aggregate.shells.is_empty() {
        out.extend_from_slice(b",\"shells_mm\":");
        let thicknesses: Vec<f64> = aggregate.shells.iter().map(|shell| shell.thickness_mm).collect();
        serde_json::to_writer(&mut *out, &thicknesses)?;
    }
    match aggregate.body.form() {
        BodyForm::Hull => {}
        BodyForm::Surface => out.extend_from_slice(b",\"dents\":true"),
        BodyForm::Round(round) => {
            out.extend_from_slice(b",\"round\":true,\"vertices\":");
            write_vertices(&aggregate.body.vertices()[..round.ends().len()], out);
            out.extend_from_slice(OCTAHEDRON);
            return Ok(());
        }
    }
    write_body(&aggregate.body, out)
}

/// Faces over the ends of a ball or an ellipsoid, for readers that know neither.
const OCTAHEDRON: &[u8] = b",\"faces\":[[1,3,5],[3,0,5],[0,2,5],[2,1,5],[3,1,4],[0,3,4],[2,0,4],[1,2,4]]}";

fn write_inclusion(inclusion: &Aggregate, out: &mut Vec<u8>) -> io::Result<()> {
    write!(out, "{{\"id\":{},\"phase\":\"{}\"", inclusion.id, inclusion.kind.name())?;
    write_body(&inclusion.body, out)
}

fn write_body(body: &Polyhedron, out: &mut Vec<u8>) -> io::Result<()> {
    out.extend_from_slice(b",\"vertices\":");
    write_vertices(body.vertices(), out);
    out.extend_from_slice(b",\"faces\":[");
    for face in body.faces() {
        write_face(face, out);
    }
    out.pop();
    out.extend_from_slice(b"]}");
    Ok(())
}

fn write_vertices(vertices: &[Vec3], out: &mut Vec<u8>) {
    for (i, vertex) in vertices.iter().enumerate() {
        out.push(if i == 0 { b'[' } else { b',' });
        write_vertex(vertex, out);
    }
    out.push(b']');
}

/// Characters of the longest number.
const NUMBER: usize = 24;
/// Most numbers have as many characters, and no more than twice as many: two copies of a constant length are one of
/// any other.
const HALF: usize = 16;

/// The serializer's numbers, put together as the faces are.
fn write_vertex(vertex: &Vec3, out: &mut Vec<u8>) {
    let (mut digits, mut text, mut end) = (zmij::Buffer::new(), [b'['; 3 * (NUMBER + 1) + 1], 1);
    for x in vertex.iter() {
        let number = digits.format_finite(*x).as_bytes();
        let to = end + number.len();
        if let (Some(first), Some(last)) = (number.first_chunk::<HALF>(), number.last_chunk::<HALF>()) {
            text[end..end + HALF].copy_from_slice(first);
            text[to - HALF..to].copy_from_slice(last);
        } else {
            text[end..to].copy_from_slice(number);
        }
        text[to] = b',';
        end = to + 1;
    }
    text[end - 1] = b']';
    out.extend_from_slice(&text[..end]);
}

/// Corners of the faces that are put together by bytes.
const FEW: usize = 15;

/// A face and a comma. By hand: through the serializer these digits took as long as the coordinates.
fn write_face(face: Face, out: &mut Vec<u8>) {
    if face.len() <= FEW && face.iter().all(|corner| corner < BYTES.len() as u32) {
        let (mut text, mut end) = ([b'['; 4 * (FEW + 1)], 1);
        for corner in face.iter() {
            let (digits, len) = &BYTES[corner as usize];
            text[end..end + 4].copy_from_slice(digits);
            end += usize::from(*len);
        }
        text[end - 1..=end].copy_from_slice(b"],");
        out.extend_from_slice(&text[..=end]);
        return;
    }
    let mut digits = itoa::Buffer::new();
    for (k, corner) in face.iter().enumerate() {
        out.push(if k == 0 { b'[' } else { b',' });
        out.extend_from_slice(digits.format(corner).as_bytes());
    }
    out.extend_from_slice(b"],");
}

/// Small numbers with a comma, and how long that is.
const BYTES: [([u8; 4], u8); 256] = {
    let mut bytes = [([b','; 4], 0); 256];
    let mut number = 0;
    while number < 256 {
        let digits = if number < 10 {
            1
        } else if number < 100 {
            2
        } else {
            3
        };
        let (mut rest, mut at) = (number, digits);
        while at > 0 {
            at -= 1;
            bytes[number].0[at] = b'0' + (rest % 10) as u8;
            rest /= 10;
        }
        bytes[number].1 = digits as u8 + 1;
        number += 1;
    }
    bytes
};
