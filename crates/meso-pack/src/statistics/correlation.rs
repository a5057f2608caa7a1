//! Two-point correlation and lineal path of the aggregates, from random lines through the specimen.
//!
//! S2(r) is the chance that two points at distance r, both in the specimen, both lie in aggregates; the lineal path
//! L(r) that the whole segment between them lies in one aggregate. Along a line both follow exactly from the chords of
//! the aggregates, so that the only error is that of the choice of lines. Known limits: S2(0) = L(0) = f; both fall at
//! first with a quarter of the specific surface, and S2 tends to f^2 (Torquato, Random Heterogeneous Materials, 2002).
//! Where there are walls, which no aggregate reaches, the curves fall less: the share of the pairs that lose one of
//! their points to the empty rim grows with r.

use super::{Sample, in_order};
use meso_collision::geometry::{BodyForm, Polyhedron, Triangles};
use meso_collision::math::{Aabb, Mat3, Vec3};
use meso_concrete::aggregate::random::{Draw, Stream};
use serde::{Deserialize, Serialize};

/// Lines to a batch: each batch has its own random stream.
const BATCH: u32 = 64;
/// Halvings of the bracket of a line's end: to 1e-12 of the specimen.
const HALVINGS: u32 = 40;

/// More lags than that resolve nothing.
const MOST_LAGS: f64 = 10_000.0;

/// The correlation functions at equidistant lags.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Correlation {
    /// Lags r, mm.
    pub lag_mm: Vec<f64>,
    /// S2(r), from pairs of points that both lie in the specimen.
    pub two_point: Vec<f64>,
    /// Lineal path L(r).
    pub lineal_path: Vec<f64>,
    /// Slope of the pairs' measure at r = 0, from the number of chord ends, 1/mm: minus a quarter of the specific
    /// surface.
    pub slope_per_mm: f64,
    /// Mean length of the chords, mm.
    pub mean_chord_mm: f64,
    /// Random lines looked at.
    pub lines: u32,
}

/// A line through the specimen: its length there, and the parts of it that lie in aggregates, ascending.
struct Line {
    length: f64,
    chords: Vec<(f64, f64)>,
    /// Ends of chords at an aggregate's surface. A specimen that repeats itself cuts chords at its faces: these ends
    /// are none.
    ends: u32,
}

/// Sums over lines.
#[derive(Clone)]
struct Sums {
    pairs: Vec<f64>,
    segments: Vec<f64>,
    lengths: Vec<f64>,
    chords: f64,
    chord_length: f64,
    length: f64,
}

pub(super) fn correlation(sample: &Sample) -> Correlation {
    let (options, lags) = (sample.options, lags(sample));
    let mut total = Sums::new(lags);
    in_order(options.lines.div_ceil(BATCH), |batch| sums(sample, batch), |sums| total.join(&sums));
    // Lags longer than every line have no pair.
    let lags: Vec<usize> = (0..lags).filter(|&k| total.lengths[k] > 0.0).collect();
    let shares = |counted: &[f64]| lags.iter().map(|&k| counted[k] / total.lengths[k]).collect();
    Correlation {
        lag_mm: lags.iter().map(|&k| k as f64 * lag(sample)).collect(),
        two_point: shares(&total.pairs),
        lineal_path: shares(&total.segments),
        slope_per_mm: if total.length > 0.0 { -total.chords / total.length } else { 0.0 },
        mean_chord_mm: if total.chords > 0.0 { total.chord_length / total.chords } else { 0.0 },
        lines: options.lines,
    }
}

/// The step between lags; 0 where the one asked for is none.
fn lag(sample: &Sample) -> f64 {
    let lag = sample.options.lag_mm;
    if lag.is_finite() && lag > 0.0 { lag } else { 0.0 }
}

/// As many lags as asked and as the specimen's size allows; only r = 0 where there is no step.
fn lags(sample: &Sample) -> usize {
    let lag = lag(sample);
    let most = if lag > 0.0 { sample.container.aabb().size().norm() / lag } else { 0.0 };
    (sample.options.lags as usize).min(1 + most.min(MOST_LAGS) as usize)
}

fn sums(sample: &Sample, batch: u32) -> Sums {
    let mut stream = Stream::new(sample.options.seed, Draw::Sample, 1, u64::from(batch));
    let mut sums = Sums::new(lags(sample));
    for _ in 0..BATCH.min(sample.options.lines - batch * BATCH) {
        sums.add(&line(sample, &mut stream), lag(sample));
    }
    sums
}

impl Sums {
    fn new(lags: usize) -> Self {
        let zeros = vec![0.0; lags];
        Self {
            pairs: zeros.clone(),
            segments: zeros.clone(),
            lengths: zeros,
            chords: 0.0,
            chord_length: 0.0,
            length: 0.0,
        }
    }

    /// Lines were chosen through uniform points, so in proportion to their length; its inverse as weight undoes that.
    fn add(&mut self, line: &Line, lag: f64) {
        let weight = 1.0 / line.length;
        for k in 0..self.pairs.len() {
            let r = k as f64 * lag;
            self.lengths[k] += weight * (line.length - r).max(0.0);
            self.pairs[k] += weight * line.overlap_with_itself(r);
            self.segments[k] += weight * line.chords.iter().map(|(from, to)| (to - from - r).max(0.0)).sum::<f64>();
        }
        self.chords += weight * f64::from(line.ends) / 2.0;
        self.chord_length += weight * line.chords.iter().map(|(from, to)| to - from).sum::<f64>();
        self.length += weight * line.length;
    }

    fn join(&mut self, other: &Self) {
        for (mine, others) in [
            (&mut self.pairs, &other.pairs),
            (&mut self.segments, &other.segments),
            (&mut self.lengths, &other.lengths),
        ] {
            mine.iter_mut().zip(others).for_each(|(x, y)| *x += y);
        }
        self.chords += other.chords;
        self.chord_length += other.chord_length;
        self.length += other.length;
    }
}

impl Line {
    /// The parts of the chords `whole` that lie between 0 and `length`.
    fn of(length: f64, whole: impl Iterator<Item = (f64, f64)>) -> Self {
        let reaching: Vec<(f64, f64)> = whole.filter(|&(from, to)| from < length && to > 0.0).collect();
        let ends = reaching.iter().map(|&(from, to)| u32::from(from > 0.0) + u32::from(to < length)).sum();
        let mut chords: Vec<(f64, f64)> =
            reaching.into_iter().map(|(from, to)| (from.max(0.0), to.min(length))).collect();
        chords.sort_by(|x, y| x.0.total_cmp(&y.0));
        Self { length, chords, ends }
    }

    /// Length of the points that lie in a chord and, `r` further on, in a chord again.
    fn overlap_with_itself(&self, r: f64) -> f64 {
        let (mut sum, mut first) = (0.0, 0);
        for &(from, to) in &self.chords {
            // Chords that end before this one starts, moved on, end before every later one.
            while first < self.chords.len() && self.chords[first].1 <= from + r {
                first += 1;
            }
            let reached = self.chords[first..].iter().take_while(|chord| chord.0 < to + r);
            sum += reached.map(|chord| (chord.1.min(to + r) - chord.0.max(from + r)).max(0.0)).sum::<f64>();
        }
        sum
    }
}

/// A line in a random direction through a random point of the specimen up to where it leaves the specimen first.
fn line(sample: &Sample, stream: &mut Stream) -> Line {
    let bounds = sample.container.aabb();
    let point = loop {
        let point = stream.point(&bounds.min, &bounds.max);
        if inside(sample, &point) {
            break point;
        }
    };
    let direction = stream.rotation() * Vec3::z();
    let (ahead, behind) = (reach(sample, &point, &direction), reach(sample, &point, &-direction));
    let origin = point - direction * behind;
    let length = ahead + behind;
    let whole = near_line(sample, &origin, &direction, length)
        .into_iter()
        .flat_map(|a| chords(&sample.aggregates[a as usize].body, &origin, &direction));
    Line::of(length, whole)
}

/// True for points of the specimen; of one that repeats itself, in its box alone.
fn inside(sample: &Sample, point: &Vec3) -> bool {
    let bounds = sample.container.aabb();
    (0..3).all(|i| point[i] >= bounds.min[i] && point[i] <= bounds.max[i]) && sample.container.contains(point)
}

/// How far the specimen reaches from a point of it before it ends for the first time.
fn reach(sample: &Sample, point: &Vec3, direction: &Vec3) -> f64 {
    let (mut low, mut high) = bracket(sample, point, direction);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if inside(sample, &(point + direction * middle)) { &mut low } else { &mut high }) = middle;
    }
    high
}

/// Two distances with the end between them: where the specimen is not convex, by steps that no surface is nearer than.
fn bracket(sample: &Sample, point: &Vec3, direction: &Vec3) -> (f64, f64) {
    let size = sample.container.aabb().size().norm();
    if sample.container.is_convex() {
        return (0.0, size);
    }
    let (least, mut low) = (1e-6 * size, 0.0);
    loop {
        let position = point + direction * low;
        let step = sample.container.depth(&position).max(least);
        if !inside(sample, &(position + direction * step)) {
            return (low, low + step);
        }
        low += step;
    }
}

/// The aggregates whose boxes a line may cross.
fn near_line(sample: &Sample, origin: &Vec3, direction: &Vec3, length: f64) -> Vec<u32> {
    let steps = (length / sample.index.cell()).ceil().max(1.0);
    let at = |step: f64| origin + direction * (length * step / steps);
    let mut near = Vec::new();
    for step in 0..steps as u32 {
        let (from, to) = (at(f64::from(step)), at(f64::from(step) + 1.0));
        sample.index.near(&Aabb { min: from.inf(&to), max: from.sup(&to) }, &mut near);
    }
    near.sort_unstable();
    near.dedup();
    near
}

/// Where a line enters and leaves a body: once, unless the body has dents.
fn chords(body: &Polyhedron, origin: &Vec3, direction: &Vec3) -> Vec<(f64, f64)> {
    match body.form() {
        BodyForm::Hull => chord(body, origin, direction).into_iter().collect(),
        BodyForm::Round(round) => round.chord(origin, direction).into_iter().collect(),
        BodyForm::Surface => chords_of_surface(body, origin, direction),
    }
}

fn chords_of_surface(body: &Polyhedron, origin: &Vec3, direction: &Vec3) -> Vec<(f64, f64)> {
    if !meets(&body.aabb(), origin, direction) {
        return Vec::new();
    }
    let turn = along_x(direction);
    let along: Vec<Vec3> = body.vertices().iter().map(|vertex| turn * (vertex - origin)).collect();
    let around_line = |corners: &[Vec3; 3]| {
        (1..3).all(|axis| {
            corners.iter().any(|corner| corner[axis] <= 0.0) && corners.iter().any(|corner| corner[axis] >= 0.0)
        })
    };
    // A tree of all triangles takes a hundred times as long as the few that the line may cross.
    let few: Vec<[Vec3; 3]> = body.triangles().map(|t| t.map(|i| along[i as usize])).filter(around_line).collect();
    if few.is_empty() {
        return Vec::new();
    }
    Triangles::new(few).row(0.0, 0.0).into_iter().map(|[from, to]| (from, to)).collect()
}

/// True where a line may meet a box; one that only rounding lets pass by has no chord there.
fn meets(aabb: &Aabb, origin: &Vec3, direction: &Vec3) -> bool {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for axis in 0..3 {
        let ends = [aabb.min, aabb.max].map(|end| (end[axis] - origin[axis]) / direction[axis]);
        // A line parallel to the sides gives infinite ends, or none.
        if ends.iter().all(|end| !end.is_nan()) {
            (from, to) = (from.max(ends[0].min(ends[1])), to.min(ends[0].max(ends[1])));
        }
    }
    from <= to
}

/// The rotation of a direction onto the x axis. `Rotation3::rotation_between` of nalgebra calls the platform's arc cosine,
/// which clippy.toml cannot see.
fn along_x(direction: &Vec3) -> Mat3 {
    let least = Vec3::ith(direction.iamin(), 1.0);
    let across = direction.cross(&least).normalize();
    Mat3::from_rows(&[direction.transpose(), across.transpose(), direction.cross(&across).transpose()])
}

/// Where a line enters and leaves a convex body.
fn chord(body: &Polyhedron, origin: &Vec3, direction: &Vec3) -> Option<(f64, f64)> {
    let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
    for plane in body.planes() {
        let (speed, height) = (plane.normal.dot(direction), plane.offset - plane.normal.dot(origin));
        if speed > 0.0 {
            to = to.min(height / speed);
        } else if speed < 0.0 {
            from = from.max(height / speed);
        } else if height < 0.0 {
            return None;
        }
        if from >= to {
            return None;
        }
    }
    Some((from, to))
}
