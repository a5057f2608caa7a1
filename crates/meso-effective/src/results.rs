//! Files of a result: figures, a page, and the names that both fronts use.

use crate::bounds::PropertyBounds;
use crate::effective::Effective;
use crate::elastic::{COMPONENTS, ElasticShare, Stiffness, StressField};
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

/// Name of the file of a property's field for a gradient along `axis`: `diffusivity_x.vti`.
pub fn field_file(what: Property, axis: usize) -> String {
    format!("{}_{}.vti", what.name(), ["x", "y", "z"][axis])
}

/// Name of the file of the stresses for the strain `component`, 0 to 5: `stiffness_xx.vti`.
pub fn stress_file(component: usize) -> String {
    format!("stiffness_{}.vti", COMPONENTS[component])
}

/// A field of a computed property.
pub enum PropertyField {
    /// Potential and flux of diffusivity or conductivity.
    Flux(Property, FluxField),
    /// Stresses.
    Stress(StressField),
}

impl PropertyField {
    /// Name of its file.
    pub fn file(&self) -> String {
        match self {
            Self::Flux(what, field) => field_file(*what, field.axis),
            Self::Stress(field) => stress_file(field.strain),
        }
    }

    /// Writes VTK image data.
    ///
    /// # Errors
    /// Fails with the errors of `out`.
    pub fn write_vti(&self, out: impl Write) -> io::Result<()> {
        match self {
            Self::Flux(_, field) => field.write_vti(out),
            Self::Stress(field) => field.write_vti(out),
        }
    }
}

/// A computed property.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Found {
    /// Diffusivity or conductivity.
    Flux(Box<Effective>),
    /// Stiffness.
    Stiffness(Box<Stiffness>),
}

impl Found {
    /// What a reader should know.
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::Flux(of) => &of.warnings,
            Self::Stiffness(of) => &of.warnings,
        }
    }
}

/// Writes the figures of all properties: one object, or a list of several.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_figures(found: &[(Found, f64)], out: &mut dyn Write) -> io::Result<()> {
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
    of: &'a Found,
    seconds: f64,
}

/// Writes a page: for each property the tensor with its error, bounds, phases, and a section of each field.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_page(found: &[(Found, f64)], fields: &[PropertyField], out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Effective properties</title>\n{STYLE}"
    )?;
    writeln!(out, "<h1>Effective properties</h1>")?;
    for (of, _) in found {
        match of {
            Found::Flux(of) => write_flux(of, fields, out)?,
            Found::Stiffness(of) => write_stiffness(of, fields, out)?,
        }
        of.warnings().iter().try_for_each(|warning| writeln!(out, "<p class=\"warning\">Warning: {warning}.</p>"))?;
    }
    writeln!(out, "</html>")
}

fn write_flux(of: &Effective, fields: &[PropertyField], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<h2>{}{}</h2>", of.what.title(), of.what.unit())?;
    write_tensor(of, out)?;
    write_bounds(&[("", &of.bounds)], out)?;
    write_phases(of, out)?;
    write_voxels(of.voxels, of.boundary, out)?;
    fields.iter().try_for_each(|field| match field {
        PropertyField::Flux(what, field) if *what == of.what => write_flux_section(field, of, out),
        _ => Ok(()),
    })
}

fn write_voxels([x, y, z]: [usize; 3], [ends_x, ends_y, ends_z]: [&str; 3], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<p>{x} x {y} x {z} voxels; ends of x, y, z: {ends_x}, {ends_y}, {ends_z}.</p>")
}

fn write_stiffness(of: &Stiffness, fields: &[PropertyField], out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<h2>Stiffness, MPa</h2>")?;
    let (is, error) = (&of.isotropic, &of.isotropic_error);
    for (name, value, error) in [
        ("Young's modulus", is.youngs_modulus_mpa, error.youngs_modulus_mpa),
        ("Poisson's ratio", is.poisson_ratio, error.poisson_ratio),
        ("bulk modulus", is.bulk_modulus_mpa, error.bulk_modulus_mpa),
        ("shear modulus", is.shear_modulus_mpa, error.shear_modulus_mpa),
    ] {
        writeln!(out, "<p>{name}: {value:.5} ± {error:.5}</p>")?;
    }
    let bounds = &of.bounds;
    write_bounds(&[("bulk modulus", &bounds.bulk_modulus_mpa), ("shear modulus", &bounds.shear_modulus_mpa)], out)?;
    let names = COMPONENTS;
    writeln!(out, "<table><tr><th>mean stress</th>")?;
    names.iter().try_for_each(|name| write!(out, "<th>strain {name}</th>"))?;
    writeln!(out, "</tr>")?;
    for (name, (row, error)) in names.iter().zip(of.tensor.iter().zip(&of.error)) {
        write!(out, "<tr><td>{name}</td>")?;
        row.iter().zip(error).try_for_each(|(value, error)| write!(out, "<td>{value:.1} ± {error:.1}</td>"))?;
        writeln!(out, "</tr>")?;
    }
    writeln!(
        out,
        "</table><table><tr><th>phase</th><th>Young's modulus</th><th>Poisson's ratio</th><th>eigenstrain</th><th>volume fraction</th></tr>"
    )?;
    for phase in of.phases.iter().filter(|phase| phase.volume_fraction > 0.0) {
        let ElasticShare { name, youngs_modulus_mpa: e, poisson_ratio: nu, eigenstrain, volume_fraction } = phase;
        writeln!(
            out,
            "<tr><td>{name}</td><td>{e}</td><td>{nu}</td><td>{eigenstrain}</td><td>{volume_fraction:.5}</td></tr>"
        )?;
    }
    writeln!(out, "</table>")?;
    if of.phases.iter().any(|phase| phase.eigenstrain != 0.0) {
        let [x, y, z, ..] = of.expansion;
        writeln!(out, "<p>Strain of the free specimen along x, y, z: {x:.4e}, {y:.4e}, {z:.4e}</p>")?;
    }
    write_voxels(of.voxels, of.boundary, out)?;
    fields.iter().try_for_each(|field| match field {
        PropertyField::Stress(field) => write_stress_section(field, out),
        PropertyField::Flux(..) => Ok(()),
    })
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

fn write_bounds(rows: &[(&str, &PropertyBounds)], out: &mut dyn Write) -> io::Result<()> {
    let head = "<th>Reuss</th><th>Hashin-Shtrikman</th><th>Hashin-Shtrikman</th><th>Voigt</th>";
    writeln!(out, "<table><tr><th>bounds</th>{head}</tr>")?;
    for (name, b) in rows {
        let (low, high) = (b.hashin_shtrikman_lower, b.hashin_shtrikman_upper);
        let values = [b.reuss, low, high, b.voigt].map(|value| format!("<td>{value:.5}</td>")).concat();
        writeln!(out, "<tr><td>{name}</td>{values}</tr>")?;
    }
    writeln!(out, "</table>")
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
fn write_flux_section(field: &FluxField, of: &Effective, out: &mut dyn Write) -> io::Result<()> {
    let along = field.axis;
    let mean = of.tensor[along][along].unwrap_or(1.0).abs().max(f64::MIN_POSITIVE) as f32;
    let amount = |voxel: usize| {
        let [x, y, z] = field.flux[voxel];
        (x * x + y * y + z * z).sqrt() / (mean * BRIGHTEST)
    };
    let name = ["x", "y", "z"][along];
    let caption = format!(
        "Amount of the flux for a gradient along {name}, on the middle section; white is {BRIGHTEST} times the mean."
    );
    write_section(field.counts, if along == 2 { 0 } else { along }, amount, ("flux", &caption), out)
}

/// The middle section that holds the strain: von Mises' stress over twice its mean.
fn write_stress_section(field: &StressField, out: &mut dyn Write) -> io::Result<()> {
    let count = field.stress.len();
    let mean = (0..count).map(|voxel| f64::from(field.von_mises(voxel))).sum::<f64>() / count as f64;
    let amount = |voxel: usize| field.von_mises(voxel) / (2.0 * mean.max(f64::MIN_POSITIVE)) as f32;
    let name = COMPONENTS[field.strain];
    let caption = format!(
        "Von Mises' stress for a strain {name}, on the middle section; white is twice the mean, {mean:.0} MPa."
    );
    write_section(
        field.counts,
        if field.strain == 1 || field.strain == 3 { 1 } else { 0 },
        amount,
        ("stress", &caption),
        out,
    )
}

/// The middle section of the axis `across` and z: an amount from 0, black, to 1, white.
fn write_section(
    counts: [usize; 3],
    across: usize,
    amount: impl Fn(usize) -> f32,
    (name, caption): (&str, &str),
    out: &mut dyn Write,
) -> io::Result<()> {
    let (normal, [nx, ny, _]) = (1 - across, counts);
    let (width, height) = (counts[across], counts[2]);
    let pixel = |number: usize| {
        let mut at = [0; 3];
        (at[across], at[2], at[normal]) = (number % width, height - 1 - number / width, counts[normal] / 2);
        (255.0 * amount((at[2] * ny + at[1]) * nx + at[0]).min(1.0)) as u8
    };
    let pixels: Vec<u8> = (0..width * height).map(pixel).collect();
    let picture = base64(&png(width, height, &pixels)?);
    writeln!(
        out,
        "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{picture}\"><figcaption>{caption}</figcaption></figure>"
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
