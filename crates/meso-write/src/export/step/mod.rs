//! Bodies as STEP (`.step`, ISO 10303-214): one solid with plane faces per body, to be edited in CAD programs and Abaqus/CAE.
//!
//! The file is an assembly with a part per body. Part and solid have the body's name, the solid the colour of its
//! material, and each material is a layer. The mortar, where it is asked for, is a solid with a cavity per body, which is
//! the body's own shell, reversed.

mod brep;
mod lines;
mod style;

use super::appearance::{MORTAR, colour, material, name};
pub(crate) use brep::Block;
use lines::{Id, Lines, list, real};
use meso_collision::math::Vec3;
use meso_concrete::PhaseNames;
use meso_concrete::aggregate::Aggregate;
use std::io::{self, BufWriter, Write};
use style::Styles;

/// Lengths below which a reader may merge points, mm.
const ACCURACY_MM: f64 = 1e-7;

/// Writes every body as a solid to `out`, and the mortar between them where `mortar` bounds it; mm.
///
/// # Errors
/// Fails with the errors of `out`.
pub(crate) fn write(
    bodies: &[Aggregate],
    phases: &PhaseNames,
    mortar: Option<&Block>,
    out: impl Write,
) -> io::Result<()> {
    let mut lines = Lines::new(BufWriter::new(out));
    lines.text(HEADER)?;
    let mut part = StepAssembly::begin(&mut lines)?;
    let mut shells = Vec::new();
    for body in bodies {
        let faces = body.body.faces().map(|face| face.to_vec());
        let shell = brep::polygons(&mut lines, body.body.vertices(), faces)?;
        let name = name(body, phases);
        let solid = lines.entity(format_args!("MANIFOLD_SOLID_BREP('{name}',{shell})"))?;
        part.add(&mut lines, &name, (&material(body, phases), colour(body)), solid)?;
        shells.push(shell);
    }
    if let Some(block) = mortar {
        let solid = with_cavities(&mut lines, block, &shells)?;
        part.add(&mut lines, MORTAR.0, MORTAR, solid)?;
    }
    part.end(&mut lines)?;
    lines.text("ENDSEC;\nEND-ISO-10303-21;\n")?;
    lines.flush()
}

/// The core reads no clock: the time stamp says nothing.
const HEADER: &str = "ISO-10303-21;
HEADER;
FILE_DESCRIPTION(('Aggregates of mesoscale concrete, mm'),'2;1');
FILE_NAME('','1970-01-01T00:00:00',(''),(''),'mesocrete','mesocrete','');
FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));
ENDSEC;
DATA;
";

fn with_cavities(lines: &mut Lines<impl Write>, block: &Block, shells: &[Id]) -> io::Result<Id> {
    let outer = block.shell(lines)?;
    let reversed = |&shell: &Id| lines.entity(format_args!("ORIENTED_CLOSED_SHELL('',*,{shell},.F.)"));
    let cavities = shells.iter().map(reversed).collect::<io::Result<Vec<Id>>>()?;
    if cavities.is_empty() {
        return lines.entity(format_args!("MANIFOLD_SOLID_BREP('{}',{outer})", MORTAR.0));
    }
    lines.entity(format_args!("BREP_WITH_VOIDS('{}',{outer},{})", MORTAR.0, list(&cavities)))
}

/// The product that all parts belong to, and the entities that they share.
struct StepAssembly {
    /// Contexts of every product, and of every product definition.
    contexts: [Id; 2],
    /// Units and accuracy.
    geometry: Id,
    /// The frame of every part, which is the assembly's.
    frame: Id,
    definition: Id,
    shape: Id,
    products: Vec<Id>,
    styles: Styles,
}

impl StepAssembly {
    fn begin(lines: &mut Lines<impl Write>) -> io::Result<Self> {
        let application = lines.entity(format_args!("APPLICATION_CONTEXT('automotive design')"))?;
        lines.entity(format_args!(
            "APPLICATION_PROTOCOL_DEFINITION('international standard','automotive_design',2010,{application})"
        ))?;
        let contexts = [
            lines.entity(format_args!("PRODUCT_CONTEXT('',{application},'mechanical')"))?,
            lines.entity(format_args!("PRODUCT_DEFINITION_CONTEXT('part definition',{application},'design')"))?,
        ];
        let geometry = units(lines)?;
        let frame = brep::placement(lines, &Vec3::zeros(), &Vec3::z())?;
        let (product, definition, defined) = define(lines, "specimen", contexts)?;
        let shape = lines.entity(format_args!("SHAPE_REPRESENTATION('',({frame}),{geometry})"))?;
        lines.entity(format_args!("SHAPE_DEFINITION_REPRESENTATION({defined},{shape})"))?;
        let styles = Styles::default();
        Ok(Self { contexts, geometry, frame, definition, shape, products: vec![product], styles })
    }

    /// Makes `solid` a part of this name, placed where it is.
    fn add(
        &mut self,
        lines: &mut Lines<impl Write>,
        name: &str,
        material: (&str, [u8; 3]),
        solid: Id,
    ) -> io::Result<()> {
        self.styles.paint(lines, solid, material)?;
        let Self { contexts, geometry, frame, definition: whole, shape: assembly, .. } = *self;
        let (product, definition, defined) = define(lines, name, contexts)?;
        let shape =
            lines.entity(format_args!("ADVANCED_BREP_SHAPE_REPRESENTATION('',({frame},{solid}),{geometry})"))?;
        lines.entity(format_args!("SHAPE_DEFINITION_REPRESENTATION({defined},{shape})"))?;
        let used = lines
            .entity(format_args!("NEXT_ASSEMBLY_USAGE_OCCURRENCE('{name}','{name}','',{whole},{definition},$)"))?;
        let used = lines.entity(format_args!("PRODUCT_DEFINITION_SHAPE('','',{used})"))?;
        let stays = lines.entity(format_args!("ITEM_DEFINED_TRANSFORMATION('','',{frame},{frame})"))?;
        let placed = lines.entity(format_args!(
            "(REPRESENTATION_RELATIONSHIP('','',{shape},{assembly})\
             REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION({stays})SHAPE_REPRESENTATION_RELATIONSHIP())"
        ))?;
        lines.entity(format_args!("CONTEXT_DEPENDENT_SHAPE_REPRESENTATION({placed},{used})"))?;
        self.products.push(product);
        Ok(())
    }

    fn end(self, lines: &mut Lines<impl Write>) -> io::Result<()> {
        lines.entity(format_args!("PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,{})", list(&self.products)))?;
        self.styles.end(lines, self.geometry)
    }
}

/// A product, its definition and the definition of its shape.
fn define(lines: &mut Lines<impl Write>, name: &str, [product, definition]: [Id; 2]) -> io::Result<(Id, Id, Id)> {
    let product = lines.entity(format_args!("PRODUCT('{name}','{name}','',({product}))"))?;
    let formation = lines.entity(format_args!("PRODUCT_DEFINITION_FORMATION('','',{product})"))?;
    let definition = lines.entity(format_args!("PRODUCT_DEFINITION('design','',{formation},{definition})"))?;
    let shape = lines.entity(format_args!("PRODUCT_DEFINITION_SHAPE('','',{definition})"))?;
    Ok((product, definition, shape))
}

fn units(lines: &mut Lines<impl Write>) -> io::Result<Id> {
    let length = lines.entity(format_args!("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))"))?;
    let angle = lines.entity(format_args!("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))"))?;
    let solid_angle = lines.entity(format_args!("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())"))?;
    let accuracy = real(ACCURACY_MM);
    let accuracy = lines.entity(format_args!(
        "UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({accuracy}),{length},'distance_accuracy_value','')"
    ))?;
    lines.entity(format_args!(
        "(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT(({accuracy}))\
         GLOBAL_UNIT_ASSIGNED_CONTEXT(({length},{angle},{solid_angle}))REPRESENTATION_CONTEXT('',''))"
    ))
}
