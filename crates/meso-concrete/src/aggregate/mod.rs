//! Aggregates before they have a pose: grading, shape, ITZ, and the *take* that makes a batch of them.

mod aspect_ratio;
pub(crate) mod grading;
pub mod grain;
mod inclusions;
mod itz;
mod kinds;
mod library;
pub mod random;
mod shape;
mod shells;
pub mod take;

pub use aspect_ratio::AspectRatio;
pub use grading::{Curve, Form, Grading, SizeClass, SizeDefinition, SizeLaw, Standard};
pub use grain::Grain;
pub use grain::{Kind, Shell};
pub use inclusions::Inclusions;
pub use inclusions::{Cone, Fibres, Voids};
pub use itz::Itz;
pub use kinds::{OwnPhase, SHARE_ROUNDING};
pub use library::{Dents, Reduction, Template, TemplateError};
pub use shape::{Outline, Shape, ShapeKind};
pub use shells::{ShellLaw, Thickness, TooThick, add_shells};

use meso_collision::geometry::{BodyForm, OffsetError, Polyhedron};
use std::borrow::Cow;

/// One aggregate, or one void or fibre, at its position in the specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct Aggregate {
    /// Position in the model's list, from 0; voids and fibres count on from the last aggregate.
    pub id: u32,
    /// Kind of the body.
    pub kind: Kind,
    /// Position of its phase among the specimen's own; `None` for the phase of its kind.
    pub own: Option<u8>,
    /// Index of its size class, from the finest; those of voids and of fibres follow the grading's.
    pub class: u16,
    /// Thickness of its ITZ shell, measured inwards, mm; 0 where the model has none.
    pub itz_thickness_mm: f64,
    /// Its further shells below the ITZ, from outside.
    pub shells: Vec<Shell>,
    /// The outer surface, in the specimen's frame, mm.
    pub body: Polyhedron,
}

impl Aggregate {
    /// The body whose size and volume the grading asks for: the stone within outward shells, or else all of it.
    pub fn graded(&self) -> Cow<'_, Polyhedron> {
        let stone = |depth| self.body.inward_offset(depth).ok().flatten();
        let depth = Some(grain::coating_mm(self.itz_thickness_mm, &self.shells)).filter(|depth| *depth > 0.0);
        depth.and_then(stone).map_or(Cow::Borrowed(&self.body), Cow::Owned)
    }

    /// The body inside the ITZ shell, or `None` where the shell takes it all.
    ///
    /// # Errors
    /// Where the offset of an ill-shaped body has no trustworthy answer.
    pub fn core(&self) -> Result<Option<Polyhedron>, OffsetError> {
        self.body.inward_offset(self.itz_thickness_mm)
    }

    /// The body inside the ITZ shell as a polyhedron, also where the outer one has dents: see [`Polyhedron::inset`].
    ///
    /// # Errors
    /// Fails like [`core`](Self::core), and where a body with dents is too thin for its shell.
    pub fn inner_surface(&self) -> Result<Option<Polyhedron>, OffsetError> {
        self.surface_below(self.itz_thickness_mm)
    }

    /// The body of the points deeper than `depth` mm as a polyhedron, as [`inner_surface`](Self::inner_surface) makes it of the ITZ.
    ///
    /// # Errors
    /// Fails like [`inner_surface`](Self::inner_surface).
    pub fn surface_below(&self, depth: f64) -> Result<Option<Polyhedron>, OffsetError> {
        if self.body.form() != BodyForm::Surface || depth <= 0.0 {
            return self.body.inward_offset(depth);
        }
        self.body.inset(depth).map(Some).ok_or(OffsetError::NotConvex)
    }

    /// The volume inside a shell of `thickness` mm, mm3; sampled where the body has dents or is an ellipsoid.
    ///
    /// # Errors
    /// Fails like [`core`](Self::core).
    pub fn core_volume(&self, thickness: f64) -> Result<f64, OffsetError> {
        if thickness > 0.0 && !self.body.has_inner_body() {
            return Ok(self.body.eroded_volume(thickness));
        }
        Ok(self.body.inward_offset(thickness)?.map_or(0.0, |core| core.volume()))
    }
}
