//! The supports of a test in a deck: by `*DYNAMIC, EXPLICIT` with rigid plates, or by `*STATIC` where all is elastic.
//!
//! A support is a reference node with the nodes that it meets. A plate is a rigid facet in contact with them; a glued one has
//! them as nodes of its rigid body. Loads grow in a first step; the path, or motions in real time, follow in a second one.

use super::geometry::{ExtraNodes, node_set};
use super::lines::real;
use super::{DeckOptions, limits::DECK, output};
use crate::export::lines::Lines;
use meso_collision::math::Aabb;
use meso_concrete::OutOfRange;
use meso_mesh::cells::Mesh;
use meso_trial::{Hold, Loads, Motion, RigidSupport};
use std::io::{self, Write};

/// Plates reach beyond the nodes that they meet by this share of the specimen's width, so that its sides can bulge.
const OVERHANG: f64 = 0.1;
/// Intervals of a leg's speed in the table of an amplitude: their mean is 1.5e-5 off the leg's way.
const INTERVALS: u32 = 16;
/// Longest name of a support in a deck; longer ones are cut.
const LONGEST_NAME: usize = 20;

/// Finds out whether Abaqus can follow the loads.
pub(super) fn check(loads: &Loads) -> Result<(), OutOfRange> {
    let linked: Vec<&RigidSupport> = loads.supports.iter().filter(|support| support.force_ratio.is_some()).collect();
    let is_pair = linked.is_empty() || linked.iter().any(|support| support.is_upper);
    let why = "of two plates in a ratio of stresses a deck holds the lower one; give an upper one, too";
    DECK.require("analysis", &loads.test, is_pair, why)?;
    let why = "*STATIC has no servo for a ratio of stresses; take a law that breaks, such as cdp";
    DECK.require("analysis", &loads.test, linked.is_empty() || !loads.is_elastic, why)
}

/// Names of the supports in a deck, each another one.
pub(crate) fn names(loads: &Loads) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for (number, support) in (1..).zip(&loads.supports) {
        let name = format!("{:.LONGEST_NAME$}", support.name.to_uppercase());
        names.push(if names.contains(&name) { format!("{name}_{number}") } else { name });
    }
    names
}

/// Number of the reference node of the support at `place`.
pub(crate) fn reference(mesh: &Mesh, place: usize) -> u64 {
    (mesh.points.len() + place) as u64 + 1
}

/// Node sets of the supports, surfaces of the pressures, and the temperature that strains start from.
pub(super) fn model(lines: &mut Lines<impl Write>, loads: &Loads) -> io::Result<()> {
    for (name, support) in names(loads).iter().zip(&loads.supports) {
        node_set(lines, &format!("N_{name}"), support.nodes.iter().map(|&node| u64::from(node) + 1))?;
    }
    for (number, pressure) in (1..).zip(&loads.pressures) {
        lines.line(format!("*SURFACE, TYPE=ELEMENT, NAME=S_PRESSURE_{number}"))?;
        pressure.faces.iter().try_for_each(|&(cell, face)| lines.face(u64::from(cell) + 1, face))?;
    }
    if loads.strains.is_some() {
        lines.line("*INITIAL CONDITIONS, TYPE=TEMPERATURE")?;
        lines.line("ALLNODES, 0.0")?;
    }
    Ok(())
}

/// Pressures and strains of the step in which they grow.
pub(super) fn grow(lines: &mut Lines<impl Write>, loads: &Loads, amplitude: &str) -> io::Result<()> {
    for (number, pressure) in (1..).zip(&loads.pressures) {
        lines.line(format!("*DSLOAD{amplitude}"))?;
        lines.line(format!("S_PRESSURE_{number}, P, {}", real(pressure.mpa)))?;
    }
    if loads.strains.is_some() {
        // Coefficients of expansion are the strains.
        lines.line(format!("*TEMPERATURE{amplitude}"))?;
        lines.line("ALLNODES, 1.0")?;
    }
    Ok(())
}

/// Degree of freedom along the axis of a support.
pub(super) fn along(support: &RigidSupport) -> usize {
    support.axis + 1
}

/// Explicit dynamics of a test.
pub(super) fn write(
    lines: &mut Lines<impl Write>,
    mesh: &Mesh,
    options: &DeckOptions,
    loads: &Loads,
) -> io::Result<()> {
    model(lines, loads)?;
    let names = names(loads);
    let mut next = Numbers::behind(mesh, loads);
    for (place, (name, support)) in names.iter().zip(&loads.supports).enumerate() {
        body(lines, (reference(mesh, place), name, support), &mut next)?;
    }
    for (place, (name, support)) in names.iter().zip(&loads.supports).enumerate() {
        let Some(motion) = &support.motion else { continue };
        moving(lines, (reference(mesh, place), name, support), motion, &mut next)?;
    }
    let link = link(lines, mesh, loads)?;
    let has_lead = loads.lead_s > 0.0;
    amplitudes(lines, loads)?;
    let deck = Steps { mesh, options, loads, names: &names, link };
    if has_lead {
        deck.lead(lines)?;
    }
    match () {
        () if loads.is_fast() => deck.drive(lines),
        () if loads.path_mm.is_empty() => Ok(()),
        () => deck.path(lines),
    }
}

/// The next free numbers of a plate's corners and elements.
struct Numbers {
    node: u64,
    element: u64,
}

impl Numbers {
    fn behind(mesh: &Mesh, loads: &Loads) -> Self {
        let element = (mesh.cell_count() + mesh.cohesive().len()) as u64 + 1;
        Self { node: reference(mesh, loads.supports.len()), element }
    }
}

/// Whether a support has a facet of its own.
fn has_facet(support: &RigidSupport) -> bool {
    matches!(support.hold, Hold::Plate(_))
}

/// Reference nodes of the supports, the corners of their facets, and the node that leads plates in a ratio of forces.
pub(super) fn references(mesh: &Mesh, loads: &Loads) -> Vec<ExtraNodes> {
    let whole = Aabb::around(&mesh.points);
    let middle = |patch: &Aabb| (0.5 * (patch.min + patch.max)).into();
    let patches: Vec<Aabb> = loads.supports.iter().map(|support| patch(mesh, support, &whole)).collect();
    let places =
        names(loads).into_iter().zip(&patches).map(|(name, patch)| (middle(patch), Some(format!("REF_{name}"))));
    let facets = loads.supports.iter().zip(&patches).filter(|(support, _)| has_facet(support));
    let corners = facets.flat_map(|(support, patch)| corners(support, patch, &whole)).map(|corner| (corner, None));
    let lead = is_linked(loads).then(|| (middle(&whole), Some("REF_PATH".to_owned())));
    // The dashpot of a bar reaches from its end to a node that stays.
    let grounds = names(loads).into_iter().zip(&loads.supports).zip(&patches).filter_map(|((name, support), patch)| {
        let mut place: [f64; 3] = middle(patch);
        place[support.axis] -= inward(support) * whole.size()[support.axis];
        matches!(support.motion, Some(Motion::Bar { .. })).then(|| (place, Some(format!("GROUND_{name}"))))
    });
    let all = places.chain(corners).chain(lead).chain(grounds);
    (reference(mesh, 0)..).zip(all).map(|(number, (position, set))| ExtraNodes { number, position, set }).collect()
}

/// The nodes under a support, in the plane of its side.
fn patch(mesh: &Mesh, support: &RigidSupport, whole: &Aabb) -> Aabb {
    let mut patch = Aabb::around(support.nodes.iter().map(|&node| &mesh.points[node as usize]));
    let plane = if support.is_upper { whole.max } else { whole.min }[support.axis];
    (patch.min[support.axis], patch.max[support.axis]) = (plane, plane);
    patch
}

/// Corners of a facet beyond `patch` on all sides, its positive side towards the specimen.
fn corners(support: &RigidSupport, patch: &Aabb, whole: &Aabb) -> [[f64; 3]; 4] {
    let axis = support.axis;
    let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
    let margin = OVERHANG * whole.size();
    let (low, high) = (patch.min - margin, patch.max + margin);
    let mut corners = [(low[b], low[c]), (high[b], low[c]), (high[b], high[c]), (low[b], high[c])];
    if support.is_upper {
        corners.reverse();
    }
    corners.map(|(at_b, at_c)| {
        let mut corner = [patch.min[axis]; 3];
        (corner[b], corner[c]) = (at_b, at_c);
        corner
    })
}

/// The rigid body that the reference node `number` of a support moves.
fn body(
    lines: &mut Lines<impl Write>,
    (number, name, support): (u64, &str, &RigidSupport),
    next: &mut Numbers,
) -> io::Result<()> {
    let Hold::Plate(friction) = support.hold else {
        return lines.line(format!("*RIGID BODY, REF NODE={number}, PIN NSET=N_{name}"));
    };
    lines.line(format!("*SURFACE, TYPE=NODE, NAME=S_N_{name}"))?;
    lines.line(format!("N_{name}"))?;
    facet(lines, name, next)?;
    lines.line(format!("*RIGID BODY, REF NODE={number}, ELSET=PLATE_{name}"))?;
    // No thickness: half of any would be overclosure.
    lines.line("0.,")?;
    lines.line(format!("*SURFACE, TYPE=ELEMENT, NAME=S_PLATE_{name}"))?;
    lines.line(format!("PLATE_{name}, SPOS"))?;
    lines.line(format!("*SURFACE INTERACTION, NAME=I_{name}"))?;
    lines.line("*FRICTION")?;
    lines.line(format!("{},", real(friction)))
}

/// Direction towards the specimen along the axis of a support.
pub(crate) fn inward(support: &RigidSupport) -> f64 {
    if support.is_upper { -1.0 } else { 1.0 }
}

/// Mass, dashpot, speed over time and first speed of a support in real time.
fn moving(
    lines: &mut Lines<impl Write>,
    (number, name, support): (u64, &str, &RigidSupport),
    motion: &Motion,
    next: &mut Numbers,
) -> io::Result<()> {
    let mut mass = |lines: &mut Lines<_>, mass_t: f64| {
        lines.line(format!("*ELEMENT, TYPE=MASS, ELSET=MASS_{name}"))?;
        lines.line(format!("{}, {number}", next.element))?;
        next.element += 1;
        lines.line(format!("*MASS, ELSET=MASS_{name}"))?;
        lines.line(format!("{},", real(mass_t)))
    };
    match motion {
        Motion::Mass { mass_t, speed_mm_per_s } => {
            mass(lines, *mass_t)?;
            lines.line("*INITIAL CONDITIONS, TYPE=VELOCITY")?;
            lines.line(format!("REF_{name}, {}, {}", along(support), real(inward(support) * speed_mm_per_s)))
        }
        Motion::Speed(rows) => table(lines, name, rows),
        Motion::Bar { impedance, mass_t, wave } => {
            mass(lines, *mass_t)?;
            lines.line(format!("*ELEMENT, TYPE=DASHPOTA, ELSET=BAR_{name}"))?;
            lines.line(format!("{}, {}, {number}", next.element, next.node))?;
            (next.element, next.node) = (next.element + 1, next.node + 1);
            lines.line(format!("*DASHPOT, ELSET=BAR_{name}"))?;
            // The first line of a dashpot along its own axis is empty.
            lines.line(",")?;
            lines.line(format!("{},", real(*impedance)))?;
            if wave.is_empty() { Ok(()) } else { table(lines, name, wave) }
        }
    }
}

/// A speed over the time of a step.
fn table(lines: &mut Lines<impl Write>, name: &str, rows: &[[f64; 2]]) -> io::Result<()> {
    lines.line(format!("*AMPLITUDE, NAME=DRIVE_{name}"))?;
    points(lines, rows)
}

/// Rows of an amplitude, four points a line.
fn points(lines: &mut Lines<impl Write>, rows: &[[f64; 2]]) -> io::Result<()> {
    rows.chunks(4).try_for_each(|row| {
        let row: Vec<String> = row.iter().flatten().map(|value| format!("{value:.9e}")).collect();
        lines.line(row.join(", "))
    })
}

/// The two halves of a rigid facet. Triangles, since meshio has no word for R3D4.
fn facet(lines: &mut Lines<impl Write>, name: &str, next: &mut Numbers) -> io::Result<()> {
    lines.line(format!("*ELEMENT, TYPE=R3D3, ELSET=PLATE_{name}"))?;
    for (number, half) in (next.element..).zip([[0, 1, 2], [0, 2, 3]]) {
        lines.element(number, &half.map(|corner: u32| next.node as u32 - 1 + corner))?;
    }
    (next.node, next.element) = (next.node + 4, next.element + 2);
    Ok(())
}

/// Whether plates have forces in a ratio.
fn is_linked(loads: &Loads) -> bool {
    loads.supports.iter().any(|support| support.force_ratio.is_some())
}

/// Links plates whose forces have a ratio: the sum of their ways, each times its force over the test's, is the way of a
/// further node. By the principle of virtual work the forces have that ratio, before the peak and beyond. Returns the node.
fn link(lines: &mut Lines<impl Write>, mesh: &Mesh, loads: &Loads) -> io::Result<Option<u64>> {
    if !is_linked(loads) {
        return Ok(None);
    }
    let linked: Vec<(u64, usize, f64)> = (0..)
        .zip(&loads.supports)
        .filter(|(_, support)| support.is_upper)
        .filter_map(|(place, support)| {
            let share = support.force_ratio.or((support.moves != 0.0).then_some(1.0))?;
            Some((reference(mesh, place), along(support), share))
        })
        .collect();
    let facets = loads.supports.iter().filter(|support| has_facet(support)).count();
    let lead = reference(mesh, loads.supports.len() + 4 * facets);
    lines.line("*EQUATION")?;
    lines.line(format!("{}", linked.len() + 1))?;
    for (node, dof, share) in linked {
        lines.line(format!("{node}, {dof}, {}", real(share)))?;
    }
    lines.line(format!("{lead}, 1, 1.0"))?;
    Ok(Some(lead))
}

/// Times of the path's turns, s, and their places over its farthest one, from the start on.
fn turns(loads: &Loads) -> Vec<[f64; 2]> {
    let ways = loads.path_mm.iter().scan(0.0, |from, &to| Some((to - std::mem::replace(from, to)).abs()));
    let whole: f64 = ways.clone().sum();
    let most = farthest(loads);
    let mut time = 0.0;
    let turn = |(way, place): (f64, &f64)| {
        time += loads.duration_s * way / whole;
        [time, place / most]
    };
    std::iter::once([0.0, 0.0]).chain(ways.zip(&loads.path_mm).map(turn)).collect()
}

/// The farthest place of the path, mm.
fn farthest(loads: &Loads) -> f64 {
    loads.path_mm.iter().fold(0.0, |most, place| place.abs().max(most))
}

/// Amplitudes: LEAD of the loads, over the whole time, and PATH of ways, or of speeds where a plate has gone some way before.
fn amplitudes(lines: &mut Lines<impl Write>, loads: &Loads) -> io::Result<()> {
    if loads.lead_s > 0.0 {
        lines.line("*AMPLITUDE, NAME=LEAD, DEFINITION=SMOOTH STEP, TIME=TOTAL TIME")?;
        lines.line(format!("0.0, 0.0, {}, 1.0", real(loads.lead_s)))?;
    }
    if loads.path_mm.is_empty() {
        return Ok(());
    }
    let turns = turns(loads);
    let rows: Vec<[f64; 2]> = if loads.lead_s > 0.0 {
        lines.line("*AMPLITUDE, NAME=PATH")?;
        turns.windows(2).flat_map(|leg| speeds(leg[0], leg[1])).chain([[loads.duration_s, 0.0]]).collect()
    } else {
        lines.line("*AMPLITUDE, NAME=PATH, DEFINITION=SMOOTH STEP")?;
        turns
    };
    points(lines, &rows)
}

/// Speeds of a leg, by the derivative of a smooth step: 30 s^2 (1 - s)^2.
fn speeds([start, from]: [f64; 2], [end, to]: [f64; 2]) -> impl Iterator<Item = [f64; 2]> {
    let (time, mean) = (end - start, (to - from) / (end - start));
    (0..INTERVALS).map(move |interval| {
        let s = f64::from(interval) / f64::from(INTERVALS);
        [start + s * time, mean * 30.0 * (s * (1.0 - s)).powi(2)]
    })
}

/// The steps of an explicit deck.
struct Steps<'a> {
    mesh: &'a Mesh,
    options: &'a DeckOptions,
    loads: &'a Loads,
    names: &'a [String],
    /// The node that leads plates in a ratio of forces.
    link: Option<u64>,
}

impl Steps<'_> {
    /// Loads grow; plates stay, but for those with a force.
    fn lead(&self, lines: &mut Lines<impl Write>) -> io::Result<()> {
        self.begin(lines, self.loads.lead_s, true)?;
        self.hold(lines)?;
        grow(lines, self.loads, ", AMPLITUDE=LEAD")?;
        for (name, support) in self.pressed() {
            lines.line("*CLOAD, AMPLITUDE=LEAD")?;
            lines.line(format!("REF_{name}, {}, {}", along(support), real(-support.force_n)))?;
        }
        self.end(lines, self.loads.lead_s)
    }

    /// Supports follow the path.
    fn path(&self, lines: &mut Lines<impl Write>) -> io::Result<()> {
        let has_lead = self.loads.lead_s > 0.0;
        self.begin(lines, self.loads.duration_s, !has_lead)?;
        if !has_lead {
            self.hold(lines)?;
        }
        if self.pressed().next().is_some() {
            // The path holds these plates now.
            lines.line("*CLOAD, OP=NEW")?;
        }
        let kind = if has_lead { "VELOCITY" } else { "DISPLACEMENT" };
        lines.line(format!("*BOUNDARY, TYPE={kind}, AMPLITUDE=PATH"))?;
        let most = farthest(self.loads);
        if let Some(node) = self.link {
            lines.line(format!("{node}, 1, 1, {most:.9e}"))?;
        } else {
            for (name, support) in self.named().filter(|(_, support)| support.moves != 0.0) {
                let dof = along(support);
                lines.line(format!("REF_{name}, {dof}, {dof}, {:.9e}", support.moves * most))?;
            }
        }
        self.end(lines, self.loads.duration_s)
    }

    /// Supports move in real time.
    fn drive(&self, lines: &mut Lines<impl Write>) -> io::Result<()> {
        let has_lead = self.loads.lead_s > 0.0;
        self.begin(lines, self.loads.duration_s, !has_lead)?;
        if !has_lead {
            self.hold(lines)?;
        }
        for (name, support) in self.named() {
            let (dof, inward) = (along(support), inward(support));
            match &support.motion {
                Some(Motion::Speed(_)) => {
                    lines.line(format!("*BOUNDARY, TYPE=VELOCITY, AMPLITUDE=DRIVE_{name}"))?;
                    lines.line(format!("REF_{name}, {dof}, {dof}, {}", real(inward)))?;
                }
                Some(Motion::Bar { impedance, wave, .. }) if !wave.is_empty() => {
                    lines.line(format!("*CLOAD, AMPLITUDE=DRIVE_{name}"))?;
                    lines.line(format!("REF_{name}, {dof}, {}", real(2.0 * inward * impedance)))?;
                }
                Some(Motion::Bar { .. } | Motion::Mass { .. }) | None => {}
            }
        }
        self.end(lines, self.loads.duration_s)
    }

    fn named(&self) -> impl Iterator<Item = (&String, &RigidSupport)> {
        self.names.iter().zip(&self.loads.supports)
    }

    fn pressed(&self) -> impl Iterator<Item = (&String, &RigidSupport)> {
        self.named().filter(|(_, support)| support.is_pressed())
    }

    fn begin(&self, lines: &mut Lines<impl Write>, time_s: f64, is_first: bool) -> io::Result<()> {
        lines.line("*STEP, NLGEOM=YES")?;
        lines.line("*DYNAMIC, EXPLICIT")?;
        lines.line(format!(", {}", real(time_s)))?;
        if !is_first {
            return Ok(());
        }
        if !self.loads.is_fast() {
            lines.line(format!("*FIXED MASS SCALING, DT={}, TYPE=BELOW MIN", real(self.loads.time_increment_s)))?;
        }
        for (name, _) in self.named().filter(|(_, support)| has_facet(support)) {
            lines.line(format!("*CONTACT PAIR, INTERACTION=I_{name}, MECHANICAL CONSTRAINT=KINEMATIC"))?;
            lines.line(format!("S_N_{name}, S_PLATE_{name}"))?;
        }
        Ok(())
    }

    /// Holds all degrees of freedom of the supports but those that a force, the link or the path of this step moves.
    fn hold(&self, lines: &mut Lines<impl Write>) -> io::Result<()> {
        if self.loads.supports.is_empty() {
            return Ok(());
        }
        lines.line("*BOUNDARY")?;
        for (name, support) in self.named() {
            let is_linked = self.link.is_some() && support.is_upper;
            let goes = support.moves != 0.0 || matches!(support.motion, Some(Motion::Speed(_)));
            let answers = matches!(support.motion, Some(Motion::Bar { .. } | Motion::Mass { .. }));
            let goes = answers || goes && self.loads.lead_s == 0.0;
            let free = (is_linked || support.is_pressed() || goes).then_some(along(support));
            for dof in (1..=6).filter(|dof| Some(*dof) != free) {
                lines.line(format!("REF_{name}, {dof}, {dof}"))?;
            }
            if matches!(support.motion, Some(Motion::Bar { .. })) {
                lines.line(format!("GROUND_{name}, 1, 3"))?;
            }
        }
        Ok(())
    }

    fn end(&self, lines: &mut Lines<impl Write>, time_s: f64) -> io::Result<()> {
        output::restart(lines)?;
        output::fields(lines, self.mesh, self.options)?;
        let plates = self.named().map(|(name, support)| (format!("REF_{name}"), along(support)));
        output::history(lines, plates, time_s / output::HISTORY)?;
        lines.line("*END STEP")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speeds_of_a_leg_sum_up_to_its_way() {
        let mut points: Vec<[f64; 2]> = speeds([1.0, 0.2], [3.0, 1.0]).collect();
        points.push([3.0, 0.0]);
        let way: f64 = points.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum();
        assert!((way / 0.8 - 1.0).abs() < 2e-5, "{way}");
    }
}
