//! Files of a result: figures, a page, and the names that both fronts use.

use crate::effective::Effective;
use crate::field::FluxField;
use crate::phases::Property;
use meso_view::embedded::base64;
use png::{BitDepth, ColorType, Encoder};
use serde::Serialize;
use std::io::{self, Write};

/// Name of the figures' file.
pub const FIGURES: &str = "effective.json";
/// Name of the page.
pub const PAGE: &str = "effective.html";

impl FluxField {
    /// Name of the field's file, for a property: `diffusivity_x.vti`.
    pub fn file(&self, what: Property) -> String {
        format!("{}_{}.vti", what.name(), ["x", "y", "z"][self.axis])
    }
}

/// Writes the figures of all properties: one object, or a list of several.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_figures(found: &[(Effective, f64)], out: &mut dyn Write) -> io::Result<()> {
    match found {
        [(of, seconds)] => serde_json::to_writer_pretty(&mut *out, &Timed { of, seconds: *seconds })?,
        several => {
            let all: Vec<Timed> = several.iter().map(|(of, seconds)| Timed { of, seconds: *seconds }).collect();
            serde_json::to_writer_pretty(&mut *out, &all)?;
        }
    }
    writeln!(out)
}

/// A result in `effective.json`.
#[derive(Serialize)]
struct Timed<'a> {
    #[serde(flatten)]
    of: &'a Effective,
    seconds: f64,
}

/// Writes a page: for each property the tensor with its error, bounds, phases, and a section of each field.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_page(found: &[(Effective, f64)], fields: &[(Property, FluxField)], out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Effective properties</title>\n{STYLE}"
    )?;
    writeln!(out, "<h1>Effective properties</h1>")?;
    for (of, _) in found {
        writeln!(out, "<h2>{}{}</h2>", of.what.title(), of.what.unit())?;
        write_tensor(of, out)?;
        write_bounds(of, out)?;
        write_phases(of, out)?;
        let [x, y, z] = of.voxels;
        let [ends_x, ends_y, ends_z] = of.boundary;
        writeln!(out, "<p>{x} x {y} x {z} voxels; ends of x, y, z: {ends_x}, {ends_y}, {ends_z}.</p>")?;
        of.warnings.iter().try_for_each(|warning| writeln!(out, "<p class=\"warning\">Warning: {warning}.</p>"))?;
        for (_, field) in fields.iter().filter(|(what, _)| *what == of.what) {
            write_section(field, of, out)?;
        }
    }
    writeln!(out, "</html>")
}

const STYLE: &str = "<style>body{font:15px/1.5 system-ui,sans-serif;max-width:52rem;margin:2rem auto;padding:0 1rem}\
table{border-collapse:collapse;margin:1rem 0}td,th{padding:.2rem .8rem;text-align:right;border-bottom:1px solid #ccc}\
td:first-child,th:first-child{text-align:left}figure{display:inline-block;margin:.5rem}img{width:15rem;image-rendering:pixelated}\
.warning{color:#a00}</style>\n";

fn write_tensor(of: &Effective, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<table><tr><th>mean flux</th><th>gradient along x</th><th>y</th><th>z</th></tr>")?;
    for (row, name) in ["x", "y", "z"].into_iter().enumerate() {
        write!(out, "<tr><td>{name}</td>")?;
        for column in 0..3 {
            match (of.tensor[row][column], of.error[row][column]) {
                (Some(value), Some(error)) => write!(out, "<td>{value:.5} ± {error:.5}</td>")?,
                _ => write!(out, "<td></td>")?,
            }
        }
        writeln!(out, "</tr>")?;
    }
    writeln!(out, "</table>")
}

fn write_bounds(of: &Effective, out: &mut dyn Write) -> io::Result<()> {
    let b = &of.bounds;
    writeln!(out, "<table><tr><th>Reuss</th><th>Hashin-Shtrikman</th><th>Hashin-Shtrikman</th><th>Voigt</th></tr>")?;
    let (low, high) = (b.hashin_shtrikman_lower, b.hashin_shtrikman_upper);
    writeln!(out, "<tr><td>{:.5}</td><td>{low:.5}</td><td>{high:.5}</td><td>{:.5}</td></tr></table>", b.reuss, b.voigt)
}

fn write_phases(of: &Effective, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<table><tr><th>phase</th><th>value</th><th>volume fraction</th></tr>")?;
    for phase in of.phases.iter().filter(|phase| phase.volume_fraction > 0.0) {
        writeln!(out, "<tr><td>{}</td><td>{}</td><td>{:.5}</td></tr>", phase.name, phase.value, phase.volume_fraction)?;
    }
    writeln!(out, "</table>")
}

/// Flux, over the mean one, with the last of the colours.
const BRIGHTEST: f32 = 3.0;

/// The middle section that holds the gradient: amount of the flux over the mean flux.
fn write_section(field: &FluxField, of: &Effective, out: &mut dyn Write) -> io::Result<()> {
    let along = field.axis;
    let (across, up) = if along == 2 { (0, 2) } else { (along, 2) };
    let normal = 3 - across - up;
    let mean = of.tensor[along][along].unwrap_or(1.0).abs().max(f64::MIN_POSITIVE) as f32;
    let [nx, ny, _] = field.counts;
    let (width, height) = (field.counts[across], field.counts[up]);
    let pixel = |number: usize| {
        let mut at = [0; 3];
        (at[across], at[up], at[normal]) = (number % width, height - 1 - number / width, field.counts[normal] / 2);
        let [x, y, z] = field.flux[(at[2] * ny + at[1]) * nx + at[0]];
        let amount = (x * x + y * y + z * z).sqrt() / (mean * BRIGHTEST);
        (255.0 * amount.min(1.0)) as u8
    };
    let pixels: Vec<u8> = (0..width * height).map(pixel).collect();
    let picture = base64(&png(width, height, &pixels)?);
    let name = ["x", "y", "z"][along];
    writeln!(
        out,
        "<figure><img alt=\"flux\" src=\"data:image/png;base64,{picture}\"><figcaption>Amount of the flux for a gradient along {name}, \
         on the middle section; white is {BRIGHTEST} times the mean.</figcaption></figure>"
    )
}

fn png(width: usize, height: usize, pixels: &[u8]) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width as u32, height as u32);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_color(ColorType::Grayscale);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(pixels));
    written.map_err(io::Error::other)?;
    Ok(bytes)
}

impl Property {
    /// Name, as users type it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Diffusivity => "diffusivity",
            Self::Conductivity => "conductivity",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Diffusivity => "Diffusivity",
            Self::Conductivity => "Conductivity",
        }
    }

    fn unit(self) -> &'static str {
        match self {
            Self::Diffusivity => ", in the unit of the phases",
            Self::Conductivity => ", W/(m K)",
        }
    }
}
