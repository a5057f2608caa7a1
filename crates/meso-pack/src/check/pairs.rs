//! Every pair of bodies, by a grid of buckets and the exact verdict.

use super::Finding;
use meso_collision::geometry::{BodyForm, Polyhedron, Round, Triangles, convex_hull};
use meso_collision::gjk;
use meso_collision::math::{Aabb, Vec3};
use meso_collision::round_bodies::Other;
use meso_concrete::parallel;
use std::borrow::Cow;

/// A body or an image of one, by the number of the body.
pub(super) struct Placed<'a> {
    pub(super) body: u32,
    pub(super) vertices: Cow<'a, [Vec3]>,
    /// The body itself; only its faces count.
    pub(super) of: &'a Polyhedron,
}

impl Placed<'_> {
    /// A round body is at its place: its first vertices are its ends.
    fn form(&self) -> BodyForm {
        match self.of.form() {
            BodyForm::Round(_) => BodyForm::Round(Round::of_ends(&self.vertices)),
            form @ (BodyForm::Hull | BodyForm::Surface) => form,
        }
    }

    fn aabb(&self) -> Aabb {
        if let BodyForm::Round(round) = self.form() { round.aabb() } else { Aabb::around(&*self.vertices) }
    }

    /// The surface: that of the body with these vertices, or of their hull.
    fn surface(&self) -> Option<Triangles> {
        let corners = |t: [u32; 3]| t.map(|i| self.vertices[i as usize]);
        match self.form() {
            BodyForm::Surface => Some(Triangles::new(self.of.triangles().map(corners).collect())),
            BodyForm::Hull | BodyForm::Round(_) => convex_hull(&self.vertices).ok().map(|hull| hull.surface()),
        }
    }
}

/// The surfaces of two bodies where one has dents: their hulls decide nothing.
fn surfaces(a: &Placed, b: &Placed) -> Option<[Triangles; 2]> {
    let is_one = [a, b].iter().any(|it| it.of.form() == BodyForm::Surface);
    if is_one { Some([a.surface()?, b.surface()?]) } else { None }
}

/// The number of pairs put to the exact test, and the pairs that share a point or are nearer than `gap` mm.
///
/// `all` begins with the bodies themselves, in their order; images follow. Every body meets those after it and their
/// images, and images of its own.
pub(super) fn check(all: &[Placed], bodies: usize, gap: f64) -> (u64, Vec<Finding>) {
    // A little more than half the gap each, to cover rounding.
    let margin = gap / 2.0 * (1.0 + 1e-9);
    let boxes: Vec<Aabb> = parallel::map_each(all, |it| it.aabb().grown(margin));
    let buckets = BoxCells::new(&boxes);
    let answers = parallel::map(bodies, |a| check_one(a, all, &boxes, &buckets, gap));
    let tested = answers.iter().map(|answer| answer.0).sum();
    (tested, answers.into_iter().flat_map(|answer| answer.1).collect())
}

fn check_one(a: usize, all: &[Placed], boxes: &[Aabb], buckets: &BoxCells, gap: f64) -> (u64, Vec<Finding>) {
    let is_due = |b: usize| b > a && all[b].body as usize >= a && boxes[a].intersects(&boxes[b]);
    let mut others: Vec<usize> = buckets.near(&boxes[a]).filter(|&b| is_due(b)).collect();
    others.sort_unstable();
    let mut findings: Vec<Finding> = others.iter().filter_map(|&b| verdict(&all[a], &all[b], gap)).collect();
    // Two bodies may meet in several images; each pair is named once.
    findings.sort_by_key(Finding::pair);
    findings.dedup_by_key(|finding| finding.pair());
    (others.len() as u64, findings)
}

fn verdict(a: &Placed, b: &Placed, gap: f64) -> Option<Finding> {
    match (a.form(), b.form()) {
        (BodyForm::Round(round), _) => return round_verdict(&round, b, [a.body, b.body], gap),
        (_, BodyForm::Round(round)) => return round_verdict(&round, a, [a.body, b.body], gap),
        (BodyForm::Hull | BodyForm::Surface, _) => {}
    }
    let (p, q) = (&*a.vertices, &*b.vertices);
    // Bodies whose coordinates exceed the accepted magnitudes are not proved apart.
    let hulls_meet = gjk::intersects(p, q).unwrap_or(true);
    let surfaces = if hulls_meet || gap > 0.0 { surfaces(a, b) } else { None };
    if hulls_meet && !surfaces.as_ref().is_some_and(|[a, b]| a.is_apart(b, 0.0)) {
        return Some(Finding::Overlap { a: a.body, b: b.body });
    }
    if gap == 0.0 {
        return None;
    }
    let distance_mm = match surfaces {
        Some([a, b]) => a.distance_below(&b, gap),
        None => gjk::distance(p, q).unwrap_or(0.0),
    };
    nearer([a.body, b.body], distance_mm, gap)
}

fn nearer([a, b]: [u32; 2], distance_mm: f64, gap: f64) -> Option<Finding> {
    (distance_mm < gap).then_some(Finding::Gap { a, b, distance_mm })
}

/// The verdict where one body is a ball or an ellipsoid.
fn round_verdict(round: &Round, other: &Placed, [a, b]: [u32; 2], gap: f64) -> Option<Finding> {
    let surface = if other.of.form() == BodyForm::Surface { other.surface() } else { None };
    let other = match (other.form(), &surface) {
        (BodyForm::Round(other), _) => Other::Round(other),
        (BodyForm::Surface, Some(surface)) => Other::Surface(surface),
        (BodyForm::Hull | BodyForm::Surface, _) => Other::Hull(&other.vertices),
    };
    if !round.is_apart(&other, 0.0) {
        return Some(Finding::Overlap { a, b });
    }
    if gap == 0.0 || round.is_apart(&other, gap) {
        return None;
    }
    nearer([a, b], round.distance(&other), gap)
}

/// Boxes sorted by the cell of their lowest corner.
struct BoxCells {
    origin: Vec3,
    cell: f64,
    /// Edge of the largest box, and a little more to cover rounding.
    largest: f64,
    counts: [usize; 3],
    /// `starts[c]..starts[c + 1]` is the range of cell c in `members`.
    starts: Vec<u32>,
    members: Vec<u32>,
}

/// Cells per edge of the largest box, inverted.
const CELL: f64 = 0.5;
/// No more cells than this, whatever the sizes.
const MOST_CELLS: f64 = 16e6;

impl BoxCells {
    fn new(boxes: &[Aabb]) -> Self {
        let mut all = Aabb::empty();
        let mut largest: f64 = 0.0;
        for aabb in boxes {
            all.include(&aabb.min);
            all.include(&aabb.max);
            largest = largest.max(aabb.size().max());
        }
        let extent = if boxes.is_empty() { Vec3::zeros() } else { all.size() };
        let cell = (CELL * largest).max(libm::cbrt(extent.product() / MOST_CELLS)).max(f64::MIN_POSITIVE);
        let counts = [0, 1, 2].map(|i| ((extent[i] / cell) as usize).min(MOST_CELLS as usize) + 1);
        let mut buckets = Self {
            origin: all.min,
            cell,
            largest: largest * (1.0 + 1e-9),
            counts,
            starts: Vec::new(),
            members: Vec::new(),
        };
        buckets.fill(boxes);
        buckets
    }

    /// Counting sort by cell.
    fn fill(&mut self, boxes: &[Aabb]) {
        let cells: Vec<usize> = boxes.iter().map(|aabb| self.flat(self.cell_of(&aabb.min))).collect();
        let mut starts = vec![0u32; self.counts.iter().product::<usize>() + 1];
        cells.iter().for_each(|&cell| starts[cell + 1] += 1);
        for cell in 1..starts.len() {
            starts[cell] += starts[cell - 1];
        }
        let mut next = starts.clone();
        self.members = vec![0; boxes.len()];
        for (body, cell) in cells.into_iter().enumerate() {
            self.members[next[cell] as usize] = body as u32;
            next[cell] += 1;
        }
        self.starts = starts;
    }

    fn cell_of(&self, point: &Vec3) -> [usize; 3] {
        [0, 1, 2].map(|i| (((point[i] - self.origin[i]) / self.cell) as usize).min(self.counts[i] - 1))
    }

    fn flat(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    /// The bodies that may meet `aabb`: their lowest corner lies at most the largest edge before it, and not behind it.
    fn near(&self, aabb: &Aabb) -> impl Iterator<Item = usize> {
        let first = self.cell_of(&(aabb.min - Vec3::repeat(self.largest)));
        let last = self.cell_of(&aabb.max);
        let rows = (first[2]..=last[2]).flat_map(move |z| (first[1]..=last[1]).map(move |y| (y, z)));
        rows.flat_map(move |(y, z)| {
            let (from, to) = (self.flat([first[0], y, z]), self.flat([last[0], y, z]));
            self.members[self.starts[from] as usize..self.starts[to + 1] as usize].iter().map(|&body| body as usize)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_that_cannot_be_asked_is_not_proved_apart() {
        let at = |x: f64| [0.0, 1.0, 2.0, 3.0].map(|k| Vec3::new(x, k, k * k)).to_vec();
        let of = convex_hull(&[Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()]).unwrap();
        let placed = |body, x| Placed { body, vertices: Cow::Owned(at(x)), of: &of };
        assert_eq!(verdict(&placed(0, 0.0), &placed(1, 1.0), 0.0), None);
        assert_eq!(verdict(&placed(0, 0.0), &placed(1, f64::NAN), 0.0), Some(Finding::Overlap { a: 0, b: 1 }));
    }
}
