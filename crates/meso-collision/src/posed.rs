//! Pairs of bodies of any form, and bodies that are asked often.

use crate::geometry::{BodyForm, Plane, Polyhedron, Triangles};
use crate::gjk::{self, GjkError};
use crate::math::{Aabb, Vec3};
use crate::round_bodies::Other;
use std::borrow::{Borrow, Cow};
use std::sync::OnceLock;

/// A body at a place, which is made only as far as an answer needs it.
pub trait Posed: Sized {
    /// The body by what it is; a round one at its place.
    fn form(&self) -> BodyForm;
    /// Its vertices, mm.
    fn vertices(&self) -> Cow<'_, [Vec3]>;
    /// Its triangles.
    fn surface(&self) -> Cow<'_, Triangles>;

    /// The smallest axis-aligned box around the body.
    fn aabb(&self) -> Aabb {
        self.form().aabb(&self.vertices())
    }

    /// Distance of two bodies, mm; 0 where they share a point.
    ///
    /// # Errors
    /// Coordinates that are not finite.
    fn distance(&self, other: &impl Posed) -> Result<f64, GjkError> {
        match (self.form(), other.form()) {
            (BodyForm::Round(round), form) => Ok(asked(other, form, |other| round.distance(other))),
            (form, BodyForm::Round(round)) => Ok(asked(self, form, |other| round.distance(other))),
            (BodyForm::Hull, BodyForm::Hull) => gjk::distance(&self.vertices(), &other.vertices()),
            (BodyForm::Surface, _) | (_, BodyForm::Surface) => Ok(self.surface().distance(&other.surface())),
        }
    }

    /// True where two bodies are proved more than `gap` mm apart.
    ///
    /// # Errors
    /// Coordinates that are not finite.
    fn is_farther(&self, other: &impl Posed, gap: f64) -> Result<bool, GjkError> {
        self.is_apart(other, gap, || gjk::distance_exceeds(&self.vertices(), &other.vertices(), gap))
    }

    /// True where two bodies are proved more than `gap` mm apart; `hulls` says so of the hulls of their vertices.
    ///
    /// # Errors
    /// Those of `hulls`.
    fn is_apart<E>(&self, other: &impl Posed, gap: f64, hulls: impl FnOnce() -> Result<bool, E>) -> Result<bool, E> {
        match (self.form(), other.form()) {
            (BodyForm::Round(round), form) => Ok(asked(other, form, |other| round.is_apart(other, gap))),
            (form, BodyForm::Round(round)) => Ok(asked(self, form, |other| round.is_apart(other, gap))),
            (BodyForm::Hull, BodyForm::Hull) => hulls(),
            (BodyForm::Surface, _) | (_, BodyForm::Surface) => {
                Ok(hulls()? || self.surface().is_apart(&other.surface(), gap))
            }
        }
    }
}

/// An answer about a body of this form beside a round one.
fn asked<T>(body: &impl Posed, form: BodyForm, ask: impl Fn(&Other) -> T) -> T {
    match form {
        BodyForm::Hull => ask(&Other::Hull(&body.vertices())),
        BodyForm::Round(round) => ask(&Other::Round(round)),
        BodyForm::Surface => ask(&Other::Surface(&body.surface())),
    }
}

/// A body that is asked often: the tree of its triangles, which takes as long as an answer, is made at the first need.
pub struct WithTree<B> {
    /// The body.
    pub body: B,
    form: BodyForm,
    surface: OnceLock<Triangles>,
}

impl<B: Borrow<Polyhedron>> WithTree<B> {
    /// A body without its tree yet.
    pub fn new(body: B) -> Self {
        Self { form: body.borrow().form(), body, surface: OnceLock::new() }
    }

    fn tree(&self) -> &Triangles {
        self.surface.get_or_init(|| self.body.borrow().surface())
    }

    /// How far `x` is from the body, mm, negative inside: beyond the farthest face plane, which is less than the distance
    /// where an edge or corner is nearest; the distance itself where the body is round or has dents.
    pub fn height(&self, x: &Vec3) -> f64 {
        match &self.form {
            BodyForm::Hull => Plane::height_over(self.body.borrow().planes(), x),
            BodyForm::Round(round) => round.height(x),
            BodyForm::Surface => -self.tree().depth(x),
        }
    }
}

impl<B: Borrow<Polyhedron>> Posed for WithTree<B> {
    fn form(&self) -> BodyForm {
        self.form
    }

    fn vertices(&self) -> Cow<'_, [Vec3]> {
        Cow::Borrowed(self.body.borrow().vertices())
    }

    fn surface(&self) -> Cow<'_, Triangles> {
        Cow::Borrowed(self.tree())
    }
}
