//! The bodies that a mesh is made of, with their periodic images.

use crate::cells::NO_BODY;
use meso_concrete::Parts;
use meso_concrete::aggregate::Aggregate;
use meso_concrete::images::numbered;
use meso_concrete::parallel;
use std::cmp::Ordering;
use std::ops::Range;

/// Bodies and their periodic images; a body and its images are in a row, sorted by their positions.
pub(crate) struct BodyImages {
    /// All of them. Builders decide by their order, which images at opposite faces share.
    pub(crate) all: Vec<Aggregate>,
    /// Ids by the bodies' indices.
    pub(crate) id_of: Vec<u32>,
    /// For each of `all` the index of its body, ascending.
    body: Vec<u32>,
}

impl BodyImages {
    pub(crate) fn of(parts: &Parts) -> Self {
        let Parts { bodies, specimen, .. } = parts;
        let mut all = numbered(bodies, specimen, 0.0);
        all.sort_by(before);
        let (body, all) = all.into_iter().unzip();
        Self { all, id_of: bodies.iter().map(|body| body.id).collect(), body }
    }

    /// Places in `all` of a body and its images.
    pub(crate) fn places(&self, body: u32) -> Range<usize> {
        let start = self.body.partition_point(|other| *other < body);
        start..start + self.body[start..].partition_point(|other| *other == body)
    }

    /// A body and its images.
    pub(crate) fn images(&self, body: u32) -> &[Aggregate] {
        &self.all[self.places(body)]
    }

    /// The caps of a body, a bit for each of the [`SIDES`](crate::cells::SIDES); its images have the same ones.
    pub(crate) fn caps(&self, body: u32) -> u8 {
        self.images(body).first().map_or(0, |body| body.body.caps())
    }

    /// Replaces places in `all` by the indices of their bodies.
    pub(crate) fn name_bodies(&self, owner: &mut [u32]) {
        parallel::each_short_mut(owner, |_, owner| {
            if *owner != NO_BODY {
                *owner = self.body[*owner as usize];
            }
        });
    }
}

fn before((a, one): &(u32, Aggregate), (b, other): &(u32, Aggregate)) -> Ordering {
    let [low, high] = [one, other].map(|body| body.body.aabb().min);
    let along = |axis: usize| low[axis].total_cmp(&high[axis]);
    a.cmp(b).then_with(|| along(0).then(along(1)).then(along(2)))
}
