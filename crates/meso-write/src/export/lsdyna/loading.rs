//! Templates of tests in a `.k`: compression between plates, tension of held faces, impact of a striker.

use super::{FIELD, Field, PLATES, card, element, node};
use crate::export::abaqus::{Analysis, DeckOptions};
use crate::export::lines::Lines;
use meso_collision::math::{Aabb, Vec3};
use meso_mesh::cells::Mesh;
use std::io::{self, Write};

/// Plates reach beyond the specimen by this share of its width, and are as thick.
const OVERHANG: f64 = 0.1;
/// A striker is as thick as this share of the specimen's width.
const STRIKER: f64 = 0.5;
/// Rows of histories.
const HISTORY: f64 = 500.0;
/// Points of the curve of the speed.
const POINTS: u32 = 50;
/// Scale of the stable time step.
const SCALE: f64 = 0.9;
/// Numbers of the node sets ZMIN and ZMAX.
const ENDS: [u64; 2] = [5, 6];

/// Control cards, loading and output of the analysis; nothing without one.
pub(super) fn write(cards: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions) -> io::Result<()> {
    let aabb = Aabb::around(&mesh.points);
    let travel = options.final_strain() * aabb.size().z;
    match options.analysis {
        Analysis::None | Analysis::Elastic | Analysis::Test => return Ok(()),
        Analysis::Compression => {
            blocks(cards, mesh, &aabb, OVERHANG)?;
            contacts(cards, options)?;
            moved(cards, "*BOUNDARY_PRESCRIBED_MOTION_RIGID", PLATES[1], -travel / options.loading.duration_s)?;
            speed(cards, options)?;
        }
        Analysis::Tension => {
            held(cards, ENDS[0], [1, 1, 1])?;
            held(cards, ENDS[1], [1, 1, 0])?;
            moved(cards, "*BOUNDARY_PRESCRIBED_MOTION_SET", ENDS[1], travel / options.loading.duration_s)?;
            speed(cards, options)?;
        }
        Analysis::Impact => {
            blocks(cards, mesh, &aabb, STRIKER)?;
            contacts(cards, options)?;
            cards.line("*INITIAL_VELOCITY_RIGID_BODY")?;
            let fall = -options.loading.impact_speed_mm_per_s;
            card(cards, &[PLATES[1].into(), 0.0.into(), 0.0.into(), fall.into()])?;
        }
    }
    control(cards, options)?;
    output(cards, options)
}

/// A rigid block under the specimen and one over it, of one hexahedron each.
fn blocks(cards: &mut Lines<impl Write>, mesh: &Mesh, aabb: &Aabb, upper: f64) -> io::Result<()> {
    let size = aabb.size();
    let margin = Vec3::new(size.x, size.y, 0.0) * OVERHANG;
    let (low, high, width) = (aabb.min - margin, aabb.max + margin, size.x.max(size.y));
    let corners = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
    let levels = [[aabb.min.z - OVERHANG * width, aabb.min.z], [aabb.max.z, aabb.max.z + upper * width]];
    let first = mesh.points.len() as u32;
    cards.line("*NODE")?;
    for (number, (z, (x, y))) in
        (u64::from(first) + 1..).zip(levels.iter().flatten().flat_map(|z| corners.map(|at| (*z, at))))
    {
        node(cards, number, [x, y, z])?;
    }
    cards.line("*ELEMENT_SOLID")?;
    let number = (mesh.cell_count() + mesh.cohesive().len()) as u64 + 1;
    for (i, part) in (0..).zip(PLATES) {
        let nodes: Vec<u32> = (first + 8 * i..first + 8 * i + 8).collect();
        element(cards, number + u64::from(i), part, &nodes)?;
    }
    Ok(())
}

/// The nodes of ZMIN and ZMAX against the plates: SURFA SURFB SURFATYP SURFBTYP, FS FD, scales, SOFT.
fn contacts(cards: &mut Lines<impl Write>, options: &DeckOptions) -> io::Result<()> {
    let friction = Field::Real(options.loading.friction);
    for ((number, nodes), plate) in (1_u64..).zip(ENDS).zip(PLATES) {
        cards.line("*CONTACT_AUTOMATIC_NODES_TO_SURFACE_ID")?;
        cards.integer(FIELD, number);
        cards.line(if number == 1 { "PLATE_BOTTOM" } else { "PLATE_TOP" })?;
        let spr = Field::Integer(1);
        card(
            cards,
            &[nodes.into(), plate.into(), Field::Integer(4), Field::Integer(3), Field::Blank, Field::Blank, spr, spr],
        )?;
        card(cards, &[friction, friction])?;
        card(cards, &[Field::Blank])?;
        // Optional card A: the soft constraint, since plates and mortar differ in stiffness.
        card(cards, &[Field::Integer(1)])?;
    }
    Ok(())
}

/// A speed along z by curve 1: DOF 3, VAD 0.
fn moved(cards: &mut Lines<impl Write>, keyword: &str, what: u64, mean: f64) -> io::Result<()> {
    cards.line(keyword)?;
    card(cards, &[what.into(), Field::Integer(3), Field::Integer(0), Field::Integer(1), mean.into()])
}

fn held(cards: &mut Lines<impl Write>, set: u64, directions: [i64; 3]) -> io::Result<()> {
    cards.line("*BOUNDARY_SPC_SET")?;
    let [x, y, z] = directions.map(Field::Integer);
    card(cards, &[set.into(), Field::Integer(0), x, y, z, Field::Integer(0), Field::Integer(0), Field::Integer(0)])
}

/// Curve 1: speed over its mean, the slope of the smooth step x^3 (10 - 15 x + 6 x^2).
fn speed(cards: &mut Lines<impl Write>, options: &DeckOptions) -> io::Result<()> {
    cards.line("*DEFINE_CURVE")?;
    cards.integer(FIELD, 1);
    cards.end()?;
    for i in 0..=POINTS {
        let x = f64::from(i) / f64::from(POINTS);
        cards.real(20, x * options.loading.duration_s);
        cards.real(20, 30.0 * x * x * (1.0 - x) * (1.0 - x));
        cards.end()?;
    }
    // Beyond its last point a curve keeps its value.
    Ok(())
}

/// End, time step and energies; an impact keeps the mass of its specimen.
fn control(cards: &mut Lines<impl Write>, options: &DeckOptions) -> io::Result<()> {
    let loading = &options.loading;
    cards.line("*CONTROL_TERMINATION")?;
    card(cards, &[loading.duration_s.into()])?;
    cards.line("*CONTROL_TIMESTEP")?;
    // A negative DT2MS adds mass to elements whose own step, times TSSFAC, is shorter than that.
    let scaled = if options.analysis == Analysis::Impact { 0.0 } else { -loading.time_increment_s / SCALE };
    card(cards, &[0.0.into(), SCALE.into(), Field::Integer(0), 0.0.into(), scaled.into()])?;
    cards.line("*CONTROL_ENERGY")?;
    card(cards, &[2, 2, 2, 2].map(Field::Integer))
}

/// Energies, forces of contacts or held nodes, and frames.
fn output(cards: &mut Lines<impl Write>, options: &DeckOptions) -> io::Result<()> {
    let forces: &[&str] = match options.analysis {
        Analysis::Tension => &["*DATABASE_SPCFORC", "*DATABASE_BNDOUT"],
        _ => &["*DATABASE_RCFORC", "*DATABASE_RBDOUT"],
    };
    for keyword in ["*DATABASE_GLSTAT", "*DATABASE_MATSUM"].iter().chain(forces) {
        cards.line(keyword)?;
        card(cards, &[(options.loading.duration_s / HISTORY).into()])?;
    }
    cards.line("*DATABASE_BINARY_D3PLOT")?;
    card(cards, &[(options.loading.duration_s / f64::from(options.loading.frames)).into()])
}
