//! Loading of a `.k`: the supports and loads of a test, or a striker.
//!
//! A plate is a rigid block in contact with the nodes under it; a glued one holds them as a set. Loads grow by curve 2, and
//! the path follows by curve 1, a speed over its mean. In real time the end of a bar is a block with a damper to a fixed point.

use super::{FIELD, Field, LOWER, UPPER, block_parts, card, element, list, node, set};
use crate::export::abaqus::{Analysis, DECK, DeckOptions};
use crate::export::lines::Lines;
use meso_collision::math::{Aabb, Vec3};
use meso_concrete::{OutOfRange, short};
use meso_mesh::cells::{Mesh, Sides};
use meso_trial::{Hold, LawName, Loads, Motion, RigidSupport, Rule, Test, TestKind};
use std::io::{self, Write};

/// Plates reach beyond the nodes that they meet by this share of the specimen's width, and are as thick.
const OVERHANG: f64 = 0.1;
/// A striker is as thick as this share of the specimen's width.
const STRIKER: f64 = 0.5;
/// Rows of histories.
const HISTORY: f64 = 500.0;
/// Points of a leg in the curve of the speed.
const POINTS: u32 = 50;
/// History variables of an element in a d3plot: those of `*MAT_CDPM` have its damage among the first.
const HISTORIES: i64 = 20;
/// Scale of the stable time step.
const SCALE: f64 = 0.9;
/// Numbers of the first node set and segment set behind those of the sides.
const FIRST_SET: u64 = 11;
/// Curves of the path's speed and of the loads' growth.
const PATH: u64 = 1;
const GROWTH: u64 = 2;
/// Curve of the first support in real time.
const DRIVE: u64 = 3;

/// A rigid block.
pub(super) struct Block {
    pub(super) name: String,
    /// Its lowest and highest corner.
    low: Vec3,
    high: Vec3,
    /// Code of the translations that are held: CON1 of `*MAT_RIGID`.
    pub(super) held: i64,
    /// Its density, tonne/mm3, where its mass counts.
    pub(super) density: Option<f64>,
}

/// Finds out whether a `.k` can have the test.
///
/// # Errors
/// The user's word for it, and a remedy.
pub(super) fn check(test: &Test, word: &str) -> Result<(), OutOfRange> {
    let has_ratio = test.supports.iter().any(|support| support.stress_ratio.is_some());
    let lacks = test.expansion().is_some() || test.kind == TestKind::Biaxial && test.supports.is_empty() || has_ratio;
    let accepted = format!("{word} has no .k yet: write an .inp, or test it with `mesocrete solve`");
    DECK.require("analysis", word, !lacks, accepted)?;
    let elastic = if test.is_fast() {
        "decks of the law elastic are static: take a law that breaks, or test it with `mesocrete solve`"
    } else {
        "a .k has no statics: write an .inp for the law elastic, or take a law that breaks"
    };
    DECK.require("analysis", word, test.law != LawName::Elastic, elastic)?;
    let pulls = |support: &meso_trial::SupportSpec| support.rule == Rule::Glued && support.pressure_mpa != 0.0;
    let glued = "a .k presses with plates alone: write an .inp for a glued plate with a pressure";
    DECK.require("analysis", word, !test.supports.iter().any(pulls), glued)?;
    let drives = |support: &meso_trial::SupportSpec| support.rule == Rule::Glued && support.drive.is_some();
    let driven = "a .k has drives of plates alone: write an .inp for a glued one";
    DECK.require("analysis", word, !test.supports.iter().any(drives), driven)
}

/// The rigid blocks of the deck.
pub(super) fn blocks(mesh: &Mesh, options: &DeckOptions) -> Vec<Block> {
    let whole = Aabb::around(&mesh.points);
    if options.geometry_only {
        return Vec::new();
    }
    match (&options.analysis, &options.loads) {
        (Analysis::Striker, _) => {
            let width = whole.size().x.max(whole.size().y);
            let margin = Vec3::new(whole.size().x, whole.size().y, 0.0) * OVERHANG;
            let (low, high) = (whole.min - margin, whole.max + margin);
            let block = |name: &str, from: f64, to: f64, held| Block {
                name: name.to_owned(),
                low: Vec3::new(low.x, low.y, from),
                high: Vec3::new(high.x, high.y, to),
                held,
                density: None,
            };
            let [lower, upper] = [whole.min.z - OVERHANG * width, whole.max.z + STRIKER * width];
            vec![block("PLATE_BOTTOM", lower, whole.min.z, 7), block("STRIKER", whole.max.z, upper, 4)]
        }
        (_, Some(loads)) => plates(loads).map(|(name, support)| plate(mesh, &whole, name, support)).collect(),
        _ => Vec::new(),
    }
}

/// The plates of a test, with their names.
fn plates(loads: &Loads) -> impl Iterator<Item = (String, &RigidSupport)> {
    let names = crate::export::abaqus::support_names(loads);
    names.into_iter().zip(&loads.supports).filter(|(_, support)| is_plate(support))
}

fn is_plate(support: &RigidSupport) -> bool {
    matches!(support.hold, Hold::Plate(_))
}

/// The block of a plate, behind the side of the specimen.
fn plate(mesh: &Mesh, whole: &Aabb, name: String, support: &RigidSupport) -> Block {
    let axis = support.axis;
    let patch = Aabb::around(support.nodes.iter().map(|&node| &mesh.points[node as usize]));
    let size = whole.size();
    let (mut low, mut high) = (patch.min - OVERHANG * size, patch.max + OVERHANG * size);
    let thick = OVERHANG * size.max();
    let (from, to) = match support.is_upper {
        true => (whole.max[axis], whole.max[axis] + thick),
        false => (whole.min[axis] - thick, whole.min[axis]),
    };
    (low[axis], high[axis]) = (from, to);
    let moves = support.moves != 0.0 || support.is_pressed() || support.motion.is_some();
    let density = match support.motion {
        Some(Motion::Bar { mass_t, .. } | Motion::Mass { mass_t, .. }) => Some(mass_t / (high - low).product()),
        Some(Motion::Speed(_)) | None => None,
    };
    // The codes of two translations: y and z, z and x, x and y.
    let held = if moves { [5, 6, 4][axis] } else { 7 };
    Block { name: format!("PLATE_{name}"), low, high, held, density }
}

/// Corners of the blocks, which the deck's one block of nodes has.
pub(super) fn corners(cards: &mut Lines<impl Write>, mesh: &Mesh, blocks: &[Block]) -> io::Result<()> {
    let corners = blocks.iter().flat_map(|block| {
        let (low, high) = (block.low, block.high);
        let ring = [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)];
        [low.z, high.z].into_iter().flat_map(move |z| ring.map(|(x, y)| [x, y, z]))
    });
    (mesh.points.len() as u64 + 1..).zip(corners).try_for_each(|(number, corner)| node(cards, number, corner))
}

/// One hexahedron for each block.
pub(super) fn hexahedra(cards: &mut Lines<impl Write>, mesh: &Mesh, blocks: &[Block]) -> io::Result<()> {
    let first = mesh.points.len() as u32;
    let number = (mesh.cell_count() + mesh.cohesive().len()) as u64 + 1;
    for (i, part) in (0..).zip(block_parts(blocks)) {
        let nodes: Vec<u32> = (first + 8 * i..first + 8 * i + 8).collect();
        element(cards, number + u64::from(i), part, &nodes)?;
    }
    Ok(())
}

/// Control cards, loading and output of the analysis; nothing without one.
pub(super) fn write(
    cards: &mut Lines<impl Write>,
    mesh: &Mesh,
    options: &DeckOptions,
    blocks: &[Block],
) -> io::Result<()> {
    match (&options.analysis, &options.loads) {
        (Analysis::Striker, _) => {
            let [friction, duration, speed] = options.impact();
            for (name, nodes, plate) in [("PLATE_BOTTOM", LOWER, 1), ("STRIKER", UPPER, 2)] {
                contact(cards, plate, name, nodes, friction)?;
            }
            cards.line("*INITIAL_VELOCITY_RIGID_BODY")?;
            let striker = block_parts(blocks).nth(1).unwrap_or_default();
            card(cards, &[striker.into(), 0.0.into(), 0.0.into(), (-speed).into()])?;
            // It keeps the mass of its specimen.
            control(cards, duration, 0.0)?;
            output(cards, options, duration, &["*DATABASE_RCFORC", "*DATABASE_RBDOUT"])
        }
        (_, Some(loads)) => test(cards, mesh, options, loads),
        _ => Ok(()),
    }
}

/// Supports, loads and path of a test.
fn test(cards: &mut Lines<impl Write>, mesh: &Mesh, options: &DeckOptions, loads: &Loads) -> io::Result<()> {
    let names = crate::export::abaqus::support_names(loads);
    let parts: Vec<(String, &RigidSupport)> = plates(loads).collect();
    let part_of = |name: &str| parts.iter().position(|(other, _)| other == name).map(|at| super::PLATE + at as u64);
    for (number, (name, support)) in (FIRST_SET..).zip(names.iter().zip(&loads.supports)) {
        set(cards, "*SET_NODE_LIST_TITLE", &format!("N_{name}"), number)?;
        list(cards, support.nodes.iter().map(|&node| u64::from(node) + 1))?;
        let part = part_of(name);
        match support.hold {
            Hold::Plate(friction) => {
                contact(
                    cards,
                    part.unwrap_or_default() - super::PLATE + 1,
                    &format!("PLATE_{name}"),
                    number,
                    friction,
                )?;
            }
            Hold::Glued => held(cards, number, support)?,
        }
        moved(cards, loads, support, part, number)?;
        if let (Some(part), Some(motion)) = (part, &support.motion) {
            driven(cards, mesh, (loads, support, part), motion)?;
        }
    }
    pressures(cards, mesh, loads)?;
    speed(cards, loads)?;
    if loads.lead_s > 0.0 {
        growth(cards, loads)?;
    }
    let is_fast = loads.is_fast();
    let end = loads.lead_s + if loads.path_mm.is_empty() && !is_fast { 0.0 } else { loads.duration_s };
    // In real time no mass is added.
    control(cards, end, if is_fast { 0.0 } else { -loads.time_increment_s / SCALE })?;
    let has_glued = loads.supports.iter().any(|support| !is_plate(support));
    let glued: &[&str] = if has_glued { &["*DATABASE_SPCFORC", "*DATABASE_BNDOUT"] } else { &[] };
    let rubbing: &[&str] = if parts.is_empty() { &[] } else { &["*DATABASE_RCFORC", "*DATABASE_RBDOUT"] };
    output(cards, options, end, &[rubbing, glued].concat())
}

/// Nodes of set `nodes` against plate `number` of the blocks: SURFA SURFB SURFATYP SURFBTYP, FS FD, scales, SOFT.
fn contact(cards: &mut Lines<impl Write>, number: u64, name: &str, nodes: u64, friction: f64) -> io::Result<()> {
    cards.line("*CONTACT_AUTOMATIC_NODES_TO_SURFACE_ID")?;
    cards.integer(FIELD, number);
    cards.line(name)?;
    let (spr, friction) = (Field::Integer(1), Field::Real(friction));
    let part = super::PLATE + number - 1;
    card(
        cards,
        &[nodes.into(), part.into(), Field::Integer(4), Field::Integer(3), Field::Blank, Field::Blank, spr, spr],
    )?;
    card(cards, &[friction, friction])?;
    card(cards, &[Field::Blank])?;
    // Optional card A: the soft constraint, since plates and mortar differ in stiffness.
    card(cards, &[Field::Integer(1)])
}

/// A support's way by curve 1, after the loads have grown: TYPEID DOF VAD LCID SF VID DEATH BIRTH, VAD 0.
fn moved(
    cards: &mut Lines<impl Write>,
    loads: &Loads,
    support: &RigidSupport,
    part: Option<u64>,
    nodes: u64,
) -> io::Result<()> {
    let dof = Field::Integer(support.axis as i64 + 1);
    if support.is_pressed() {
        cards.line("*LOAD_RIGID_BODY")?;
        card(cards, &[part.unwrap_or(nodes).into(), dof, GROWTH.into(), Field::Real(-support.force_n)])?;
    }
    if support.moves == 0.0 || loads.path_mm.is_empty() {
        return Ok(());
    }
    let mean = support.moves * whole_mm(loads) / loads.duration_s;
    let (keyword, what) = match part {
        Some(part) => ("*BOUNDARY_PRESCRIBED_MOTION_RIGID", part),
        None => ("*BOUNDARY_PRESCRIBED_MOTION_SET", nodes),
    };
    cards.line(keyword)?;
    let birth = (loads.lead_s > 0.0).then_some([Field::Blank, Field::Real(1e28), Field::Real(loads.lead_s)]);
    let fields = [what.into(), dof, Field::Integer(0), PATH.into(), mean.into()];
    card(cards, &fields.into_iter().chain(birth.into_iter().flatten()).collect::<Vec<_>>())
}

/// A plate in real time: its speed over time, its first speed, or the damper and the force of a bar, all towards the specimen.
fn driven(
    cards: &mut Lines<impl Write>,
    mesh: &Mesh,
    (loads, support, part): (&Loads, &RigidSupport, u64),
    motion: &Motion,
) -> io::Result<()> {
    let inward = crate::export::abaqus::inward(support);
    let (dof, number) = (Field::Integer(support.axis as i64 + 1), part - super::PLATE);
    let id = DRIVE + number;
    match motion {
        Motion::Speed(rows) => {
            over_time(cards, id, loads.lead_s, rows)?;
            cards.line("*BOUNDARY_PRESCRIBED_MOTION_RIGID")?;
            card(cards, &[part.into(), dof, Field::Integer(0), id.into(), inward.into()])
        }
        Motion::Mass { speed_mm_per_s, .. } => {
            cards.line("*INITIAL_VELOCITY_RIGID_BODY")?;
            let speeds = [0, 1, 2].map(|axis| if axis == support.axis { inward * speed_mm_per_s } else { 0.0 });
            card(cards, &[Field::from(part)].into_iter().chain(speeds.map(Field::Real)).collect::<Vec<_>>())
        }
        Motion::Bar { impedance, wave, .. } => {
            if !wave.is_empty() {
                over_time(cards, id, loads.lead_s, wave)?;
                cards.line("*LOAD_RIGID_BODY")?;
                card(cards, &[part.into(), dof, id.into(), (2.0 * inward * impedance).into()])?;
            }
            damper(cards, mesh, (loads, support.axis, number), *impedance)
        }
    }
}

/// A speed over time, which begins once the loads have grown and keeps its last value.
fn over_time(cards: &mut Lines<impl Write>, number: u64, lead_s: f64, rows: &[[f64; 2]]) -> io::Result<()> {
    curve(cards, number)?;
    if lead_s > 0.0 {
        point(cards, 0.0, 0.0)?;
    }
    rows.iter().try_for_each(|[time, speed]| point(cards, lead_s + time, *speed))?;
    point(cards, 1e28, rows[rows.len() - 1][1])
}

/// A damper between the first corner of a plate and a fixed point: its part has a number behind those of all plates.
fn damper(
    cards: &mut Lines<impl Write>,
    mesh: &Mesh,
    (loads, axis, plate): (&Loads, usize, u64),
    impedance: f64,
) -> io::Result<()> {
    let plates = plates(loads).count() as u64;
    let part = super::PLATE + plates + plate;
    cards.line("*PART")?;
    cards.line(format!("DAMPER_{}", plate + 1))?;
    card(cards, &[part.into(), part.into(), part.into()])?;
    cards.line("*SECTION_DISCRETE")?;
    card(cards, &[part.into()])?;
    card(cards, &[Field::Blank])?;
    cards.line("*MAT_DAMPER_VISCOUS")?;
    card(cards, &[part.into(), impedance.into()])?;
    cards.line("*DEFINE_SD_ORIENTATION")?;
    let along = [0, 1, 2].map(|other| Field::Real(f64::from(u8::from(other == axis))));
    card(cards, &[&[Field::from(part), Field::Integer(0)], &along[..]].concat())?;
    cards.line("*ELEMENT_DISCRETE")?;
    let element = (mesh.cell_count() + mesh.cohesive().len()) as u64 + plates + plate + 1;
    // EID PID N1 N2 VID, in eight columns each; N2 is the ground.
    for number in [element, part, mesh.points.len() as u64 + 8 * plate + 1, 0, part] {
        cards.integer(8, number);
    }
    cards.end()
}

/// The output that has the force of the support at a place among all, and the number of its contact or node set there.
pub(crate) fn force_of(loads: &Loads, place: usize) -> (&'static str, u64) {
    let support = &loads.supports[place];
    let plates_before = loads.supports[..place].iter().filter(|other| is_plate(other)).count() as u64;
    match support.hold {
        Hold::Plate(_) => ("rcforc", plates_before + 1),
        Hold::Glued if support.moves != 0.0 => ("bndout/velocity/nodes", FIRST_SET + place as u64),
        Hold::Glued => ("spcforc", FIRST_SET + place as u64),
    }
}

/// Holds glued nodes in the directions that do not follow the path.
fn held(cards: &mut Lines<impl Write>, nodes: u64, support: &RigidSupport) -> io::Result<()> {
    cards.line("*BOUNDARY_SPC_SET")?;
    let free = (support.moves != 0.0).then_some(support.axis);
    let [x, y, z] = [0, 1, 2].map(|axis| Field::Integer(i64::from(Some(axis) != free)));
    let none = Field::Integer(0);
    card(cards, &[nodes.into(), none, x, y, z, none, none, none])
}

/// Pressures on the faces of a segment set, by curve 2: SSID LCID SF AT.
fn pressures(cards: &mut Lines<impl Write>, mesh: &Mesh, loads: &Loads) -> io::Result<()> {
    for (number, pressure) in (FIRST_SET..).zip(&loads.pressures) {
        set(cards, "*SET_SEGMENT_TITLE", &format!("{:.20}", pressure.name.to_uppercase()), number)?;
        pressure.faces.iter().try_for_each(|&(cell, face)| super::segment(cards, mesh, cell, face))?;
        cards.line("*LOAD_SEGMENT_SET")?;
        card(cards, &[number.into(), GROWTH.into(), Field::Real(pressure.mpa), 0.0.into()])?;
    }
    Ok(())
}

/// Way of the path with all its turns, mm.
fn whole_mm(loads: &Loads) -> f64 {
    let ways = loads.path_mm.iter().scan(0.0, |from, &to| Some((to - std::mem::replace(from, to)).abs()));
    ways.sum()
}

/// Curve 1: speed over the mean of the path, for each leg the slope of the smooth step x^3 (10 - 15 x + 6 x^2).
fn speed(cards: &mut Lines<impl Write>, loads: &Loads) -> io::Result<()> {
    if loads.path_mm.is_empty() {
        return Ok(());
    }
    let whole = whole_mm(loads);
    curve(cards, PATH)?;
    let (mut from, mut time) = (0.0, loads.lead_s);
    for (leg, &to) in loads.path_mm.iter().enumerate() {
        let (way, lasts) = (to - from, loads.duration_s * (to - from).abs() / whole);
        // The end of a leg is the beginning of the next one: its speed is 0.
        for i in u32::from(leg > 0)..=POINTS {
            let x = f64::from(i) / f64::from(POINTS);
            let slope = 30.0 * x * x * (1.0 - x) * (1.0 - x);
            point(cards, time + x * lasts, way.signum() * slope)?;
        }
        (from, time) = (to, time + lasts);
    }
    Ok(())
}

/// Curve 2: the share of the loads that acts, a smooth step.
fn growth(cards: &mut Lines<impl Write>, loads: &Loads) -> io::Result<()> {
    curve(cards, GROWTH)?;
    for i in 0..=POINTS {
        let x = f64::from(i) / f64::from(POINTS);
        point(cards, x * loads.lead_s, x * x * x * (10.0 - 15.0 * x + 6.0 * x * x))?;
    }
    // Beyond its last point a curve keeps its value.
    point(cards, 1e28, 1.0)
}

fn curve(cards: &mut Lines<impl Write>, number: u64) -> io::Result<()> {
    cards.line("*DEFINE_CURVE")?;
    cards.integer(FIELD, number);
    cards.end()
}

fn point(cards: &mut Lines<impl Write>, x: f64, y: f64) -> io::Result<()> {
    cards.real(20, short(x));
    cards.real(20, short(y));
    cards.end()
}

/// End, time step and energies.
fn control(cards: &mut Lines<impl Write>, end_s: f64, scaled_s: f64) -> io::Result<()> {
    cards.line("*CONTROL_TERMINATION")?;
    card(cards, &[end_s.into()])?;
    cards.line("*CONTROL_TIMESTEP")?;
    // A negative DT2MS adds mass to elements whose own step, times TSSFAC, is shorter than that.
    card(cards, &[0.0.into(), SCALE.into(), Field::Integer(0), 0.0.into(), scaled_s.into()])?;
    cards.line("*CONTROL_ENERGY")?;
    card(cards, &[2, 2, 2, 2].map(Field::Integer))
}

/// Energies, forces of contacts or held nodes, and frames.
fn output(cards: &mut Lines<impl Write>, options: &DeckOptions, end_s: f64, forces: &[&str]) -> io::Result<()> {
    for keyword in ["*DATABASE_GLSTAT", "*DATABASE_MATSUM"].iter().chain(forces) {
        cards.line(keyword)?;
        // The history goes to text and to the binout, which the script of the curve reads.
        card(cards, &[(end_s / HISTORY).into(), Field::Integer(3)])?;
    }
    cards.line("*DATABASE_BINARY_D3PLOT")?;
    card(cards, &[(end_s / f64::from(options.field_frames())).into()])?;
    if !options.has_curves() {
        return Ok(());
    }
    // Damage is among the history variables of a law, which a d3plot has on request alone.
    cards.line("*DATABASE_EXTENT_BINARY")?;
    card(cards, &[Field::Integer(HISTORIES)])
}

/// Finds out whether the specimen has the faces that a striker and its plate press on: a spike has none.
pub(super) fn check_faces(mesh: &Mesh) -> Result<(), OutOfRange> {
    let sides = Sides::of(mesh);
    let has_both = !sides.faces()[4].is_empty() && !sides.faces()[5].is_empty();
    let why = "no face of the specimen points up or down within 45 degrees; take a specimen with plane ends, or none";
    DECK.require("analysis", "striker", has_both, why)
}
