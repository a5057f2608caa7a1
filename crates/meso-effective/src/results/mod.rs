//! Files of a result: figures, a page, and the names that both fronts use.

mod load_curve;

pub use load_curve::{CURVE, write_curve};

use crate::bounds::PropertyBounds;
use crate::effective::Effective;
use crate::elastic::{ElasticShare, Stiffness};
use crate::field::{COMPONENTS, FieldCells, PropertyField, von_mises};
use crate::phases::Property;
use crate::resolution::Resolution;
use crate::tetrahedra::Unloading;
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::Mesh;
use meso_view::embedded::base64;
use png::{BitDepth, ColorType, Encoder};
use serde::Serialize;
use std::io::{self, Write};

/// Name of the figures' file.
pub const FIGURES: &str = "effective.json";
/// Name of the page.
pub const PAGE: &str = "effective.html";

/// Ending of the fields' files: image data of voxels, or grids of tetrahedra.
pub fn field_ending(in_tetrahedra: bool) -> &'static str {
    if in_tetrahedra { "vtu" } else { "vti" }
}

/// Names of the files of a property's fields, by the component of the gradient or the strain: `diffusivity_x.vti`,
/// `stiffness_xx.vti`. `None` is stiffness.
pub fn field_files(what: Option<Property>, ending: &str) -> Vec<String> {
    let (name, components) = what.map_or(("stiffness", &COMPONENTS[..]), |what| (what.name(), &["x", "y", "z"]));
    components.iter().map(|component| format!("{name}_{component}.{ending}")).collect()
}

/// Names of all files that results may have, but for the figures and the page.
pub fn further_files() -> Vec<String> {
    let properties = || Property::ALL.into_iter().map(Some).chain([None]);
    let of_ending = |in_tetrahedra| properties().flat_map(move |what| field_files(what, field_ending(in_tetrahedra)));
    [false, true].into_iter().flat_map(of_ending).chain([CURVE.to_owned()]).collect()
}

impl PropertyField {
    /// Name of its file.
    pub fn file(&self) -> String {
        let component = if self.is_stress() { COMPONENTS[self.component] } else { ["x", "y", "z"][self.component] };
        let in_tetrahedra = matches!(self.cells, FieldCells::Tetrahedra(_));
        format!("{}_{component}.{}", self.what, field_ending(in_tetrahedra))
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
    /// Young's moduli of a cracked specimen.
    Unloading(Box<Unloading>),
}

impl Found {
    /// What a reader should know.
    pub fn warnings(&self) -> &[String] {
        match self {
            Self::Flux(of) => &of.warnings,
            Self::Stiffness(of) => &of.warnings,
            Self::Unloading(of) => &of.warnings,
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

/// Writes a page of the properties over the load, one row for each frame of a test.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_curve_page(found: &[(Found, f64)], out: &mut dyn Write) -> io::Result<()> {
    begin(out)?;
    load_curve::write_plots(found, out)?;
    writeln!(out, "</html>")
}

fn begin(out: &mut dyn Write) -> io::Result<()> {
    write!(
        out,
        "<!doctype html>\n<html lang=\"en\"><meta charset=\"utf-8\"><title>Effective properties</title>\n{STYLE}"
    )?;
    writeln!(out, "<h1>Effective properties</h1>")
}

/// Writes a page: for each property the tensor with its error, bounds, phases, and a section of each field.
///
/// # Errors
/// Fails with the errors of `out`.
pub fn write_page(found: &[(Found, f64)], fields: &[PropertyField], out: &mut dyn Write) -> io::Result<()> {
    begin(out)?;
    for (of, _) in found {
        match of {
            Found::Flux(of) => write_flux(of, fields, out)?,
            Found::Stiffness(of) => write_stiffness(of, fields, out)?,
            Found::Unloading(of) => write_unloading(of, out)?,
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
    write_resolution(&of.resolution, out)?;
    let mut own = fields.iter().filter(|field| field.what == of.what.name());
    own.try_for_each(|field| write_flux_section(&Raster::of(field), of, out))
}

fn write_resolution(of: &Resolution, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "<p>")?;
    if let Some([x, y, z]) = of.voxels {
        write!(out, "{x} x {y} x {z} voxels")?;
    }
    if let Some(count) = of.elements {
        write!(out, "{count} tetrahedra")?;
    }
    if let Some(size) = of.element_size_mm {
        write!(out, " of {size} mm")?;
    }
    let [x, y, z] = of.boundary;
    writeln!(out, "; ends of x, y, z: {x}, {y}, {z}.</p>")
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
        writeln!(out, "<p>{name}: {} ± {}</p>", figure(value), figure(error))?;
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
    write_resolution(&of.resolution, out)?;
    fields.iter().filter(|field| field.is_stress()).try_for_each(|field| write_stress_section(&Raster::of(field), out))
}

fn write_unloading(of: &Unloading, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<h2>Young's modulus of unloading, MPa</h2>\n<table><tr><th>along</th><th>modulus</th></tr>")?;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        if let (Some(modulus), Some(error)) = (of.youngs_modulus_mpa[axis], of.error[axis]) {
            writeln!(out, "<tr><td>{name}</td><td>{modulus:.0} ± {error:.0}</td></tr>")?;
        }
    }
    writeln!(out, "</table>")?;
    write_resolution(&of.resolution, out)
}

const STYLE: &str = "<style>body{font:15px/1.5 system-ui,sans-serif;max-width:52rem;margin:2rem auto;padding:0 1rem}\
table{border-collapse:collapse;margin:1rem 0}td,th{padding:.2rem .8rem;text-align:right;border-bottom:1px solid #ccc}\
td:first-child,th:first-child{text-align:left}figure{display:inline-block;margin:.5rem}img{width:15rem;image-rendering:pixelated}\
.warning{color:#a00}</style>\n";

/// A value for readers: five decimals, or five digits where these would say nothing.
pub fn figure(value: f64) -> String {
    if value == 0.0 || (1e-3..1e7).contains(&value.abs()) { format!("{value:.5}") } else { format!("{value:.4e}") }
}

fn write_tensor(of: &Effective, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "<table><tr><th>mean flux</th><th>gradient along x</th><th>y</th><th>z</th></tr>")?;
    for (row, name) in ["x", "y", "z"].into_iter().enumerate() {
        write!(out, "<tr><td>{name}</td>")?;
        for column in 0..3 {
            match (of.tensor[row][column], of.error[row][column]) {
                (Some(value), Some(error)) => write!(out, "<td>{} ± {}</td>", figure(value), figure(error))?,
                _ => write!(out, "<td></td>")?,
            }
        }
        writeln!(out, "</tr>")?;
    }
    writeln!(out, "</table>")
}

fn write_bounds(rows: &[(&str, &PropertyBounds)], out: &mut dyn Write) -> io::Result<()> {
    let head = "<th>Reuss</th><th>Hashin-Shtrikman, lower</th><th>upper</th><th>Voigt</th>";
    writeln!(out, "<table><tr><th>bounds</th>{head}</tr>")?;
    for (name, b) in rows {
        let (low, high) = (b.hashin_shtrikman_lower, b.hashin_shtrikman_upper);
        let values = [b.reuss, low, high, b.voigt].map(|value| format!("<td>{}</td>", figure(value))).concat();
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

/// Amounts on the middle section of a field: the horizontal axis is x or y, the vertical one z.
struct Raster {
    component: usize,
    size: [usize; 2],
    /// By rows from the lowest.
    amounts: Vec<f32>,
    /// Mean over the whole field.
    mean: f64,
}

/// Pixels along the longer side of a section through tetrahedra.
const PIXELS: f64 = 240.0;

fn vector_norm(v: &[f32]) -> f32 {
    v.iter().map(|x| x * x).sum::<f32>().sqrt()
}

impl Raster {
    fn of(field: &PropertyField) -> Self {
        // The section holds the gradient or the strain.
        let across = usize::from(field.component == 1 || (field.is_stress() && field.component == 3));
        let (components, amount): (_, fn(&[f32]) -> f32) =
            if field.is_stress() { (6, von_mises) } else { (3, vector_norm) };
        let values = field.values.chunks(components).map(amount);
        let (component, mean) = (field.component, 0.0);
        match &field.cells {
            FieldCells::Voxels { counts, .. } => {
                let values: Vec<f32> = values.collect();
                let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64;
                let size = [counts[across], counts[2]];
                let pixel = |number: usize| {
                    let mut at = [0; 3];
                    (at[across], at[2], at[1 - across]) = (number % size[0], number / size[0], counts[1 - across] / 2);
                    values[(at[2] * counts[1] + at[1]) * counts[0] + at[0]]
                };
                Self { component, size, amounts: (0..size[0] * size[1]).map(pixel).collect(), mean }
            }
            FieldCells::Tetrahedra(mesh) => {
                let mut raster = Self { component, size: [0; 2], amounts: Vec::new(), mean };
                raster.fill(mesh, across, values);
                raster
            }
        }
    }

    /// Fills the pixels by the cells that cross the plane in the middle.
    fn fill(&mut self, mesh: &Mesh, across: usize, values: impl Iterator<Item = f32>) {
        let aabb = Aabb::around(&mesh.points);
        let (length, plane) = (aabb.size(), (aabb.min + aabb.max)[1 - across] / 2.0);
        let edge = length[across].max(length[2]) / PIXELS;
        let axes = [across, 2];
        let size = axes.map(|axis| ((length[axis] / edge + 0.5) as usize).max(1));
        (self.size, self.amounts) = (size, vec![0.0; size[0] * size[1]]);
        let mut volumes = 0.0;
        for (cell, amount) in mesh.cells().zip(values) {
            let corners = [0, 1, 2, 3].map(|corner| mesh.points[cell[corner] as usize]);
            let around = Aabb::around(&corners);
            let whole = determinant(&corners);
            self.mean += whole * f64::from(amount);
            volumes += whole;
            if around.min[1 - across] > plane || around.max[1 - across] < plane {
                continue;
            }
            let range = |i: usize| {
                let at = |x: f64| ((x - aabb.min[axes[i]]) / edge - 0.5).max(0.0);
                at(around.min[axes[i]]) as usize..size[i].min(at(around.max[axes[i]]) as usize + 2)
            };
            for (row, column) in range(1).flat_map(|row| range(0).map(move |column| (row, column))) {
                let mut point = Vec3::repeat(plane);
                point[across] = aabb.min[across] + (column as f64 + 0.5) * edge;
                point[2] = aabb.min[2] + (row as f64 + 0.5) * edge;
                let beside = |corner: usize| {
                    let mut others = corners;
                    others[corner] = point;
                    determinant(&others) >= 0.0
                };
                if (0..4).all(beside) {
                    self.amounts[row * size[0] + column] = amount;
                }
            }
        }
        self.mean /= volumes;
    }

    /// A picture of the amounts over the one that is white.
    fn write(&self, white: f32, (name, caption): (&str, &str), out: &mut dyn Write) -> io::Result<()> {
        let [width, height] = self.size;
        let rows = self.amounts.chunks(width).rev().flatten();
        let pixels: Vec<u8> = rows.map(|amount| (255.0 * (amount / white).min(1.0)) as u8).collect();
        let picture = base64(&png(width, height, &pixels)?);
        writeln!(
            out,
            "<figure><img alt=\"{name}\" src=\"data:image/png;base64,{picture}\"><figcaption>{caption}</figcaption></figure>"
        )
    }
}

/// Six times the volume of a tetrahedron.
fn determinant([a, b, c, d]: &[Vec3; 4]) -> f64 {
    (b - a).cross(&(c - a)).dot(&(d - a))
}

/// The middle section that holds the gradient: amount of the flux over the mean flux.
fn write_flux_section(raster: &Raster, of: &Effective, out: &mut dyn Write) -> io::Result<()> {
    let along = raster.component;
    let mean = of.tensor[along][along].unwrap_or(1.0).abs().max(f64::MIN_POSITIVE) as f32;
    let name = ["x", "y", "z"][along];
    let caption = format!(
        "Amount of the flux for a gradient along {name}, on the middle section; white is {BRIGHTEST} times the mean."
    );
    raster.write(mean * BRIGHTEST, ("flux", &caption), out)
}

/// The middle section that holds the strain: von Mises' stress over twice its mean.
fn write_stress_section(raster: &Raster, out: &mut dyn Write) -> io::Result<()> {
    let (mean, name) = (raster.mean, COMPONENTS[raster.component]);
    let caption = format!(
        "Von Mises' stress for a strain {name}, on the middle section; white is twice the mean, {mean:.0} MPa."
    );
    raster.write((2.0 * mean.max(f64::MIN_POSITIVE)) as f32, ("stress", &caption), out)
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
            Self::Permeability => "permeability",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Diffusivity => "Diffusivity",
            Self::Conductivity => "Conductivity",
            Self::Permeability => "Permeability",
        }
    }

    pub(crate) fn unit(self) -> &'static str {
        match self {
            Self::Diffusivity => ", in the unit of the phases",
            Self::Conductivity => ", W/(m K)",
            Self::Permeability => ", mm2",
        }
    }
}
