//! Colours and layers of a STEP file: one of each for every material.

use super::lines::{Id, Lines, list, real};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Styles written so far.
#[derive(Default)]
pub(super) struct Styles {
    /// By the material's name: its style and its solids.
    materials: BTreeMap<String, (Id, Vec<Id>)>,
    painted: Vec<Id>,
}

impl Styles {
    /// Gives `solid` the colour of its material.
    pub(super) fn paint(
        &mut self,
        lines: &mut Lines<impl Write>,
        solid: Id,
        (name, colour): (&str, [u8; 3]),
    ) -> io::Result<()> {
        if !self.materials.contains_key(name) {
            self.materials.insert(name.to_owned(), (style(lines, name, colour)?, Vec::new()));
        }
        if let Some((style, solids)) = self.materials.get_mut(name) {
            self.painted.push(lines.entity(format_args!("STYLED_ITEM('',({style}),{solid})"))?);
            solids.push(solid);
        }
        Ok(())
    }

    /// Binds all colours to the geometry, and lists the layers.
    pub(super) fn end(self, lines: &mut Lines<impl Write>, geometry: Id) -> io::Result<()> {
        let painted = list(&self.painted);
        lines
            .entity(format_args!("MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{painted},{geometry})"))?;
        for (name, (_, solids)) in &self.materials {
            lines.entity(format_args!("PRESENTATION_LAYER_ASSIGNMENT('{name}','',{})", list(solids)))?;
        }
        Ok(())
    }
}

fn style(lines: &mut Lines<impl Write>, name: &str, colour: [u8; 3]) -> io::Result<Id> {
    let [r, g, b] = colour.map(|level| real(f64::from(level) / 255.0));
    let colour = lines.entity(format_args!("COLOUR_RGB('{name}',{r},{g},{b})"))?;
    let fill = lines.entity(format_args!("FILL_AREA_STYLE_COLOUR('',{colour})"))?;
    let fill = lines.entity(format_args!("FILL_AREA_STYLE('',({fill}))"))?;
    let fill = lines.entity(format_args!("SURFACE_STYLE_FILL_AREA({fill})"))?;
    let side = lines.entity(format_args!("SURFACE_SIDE_STYLE('',({fill}))"))?;
    let surface = lines.entity(format_args!("SURFACE_STYLE_USAGE(.BOTH.,{side})"))?;
    lines.entity(format_args!("PRESENTATION_STYLE_ASSIGNMENT(({surface}))"))
}
