//! The faces of a body as the file lists them, in two lists: one per face would be sixty for every grain.

use meso_concrete::stop;
use serde::de::{Deserialize, DeserializeSeed, Deserializer, SeqAccess, Visitor};
use std::fmt;

/// Polygons over vertices 0, 1, 2, ...
#[derive(Default)]
pub(super) struct Polygons {
    corners: Vec<u32>,
    /// One past the last corner of each polygon.
    ends: Vec<usize>,
}

impl Polygons {
    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// The corners of each.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(&start, &end)| &self.corners[start..end])
    }
}

impl<'de> Deserialize<'de> for Polygons {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_seq(All)
    }
}

struct All;

impl<'de> Visitor<'de> for All {
    type Value = Polygons;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a sequence")
    }

    /// Once per body of the file, and so where reading stops.
    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Polygons, A::Error> {
        stop::point();
        let mut polygons = Polygons::default();
        while list.next_element_seed(One(&mut polygons.corners))?.is_some() {
            polygons.ends.push(polygons.corners.len());
        }
        Ok(polygons)
    }
}

/// Appends the corners of one polygon.
struct One<'a>(&'a mut Vec<u32>);

impl<'de> DeserializeSeed<'de> for One<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for One<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a sequence")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<(), A::Error> {
        while let Some(corner) = list.next_element()? {
            self.0.push(corner);
        }
        Ok(())
    }
}
