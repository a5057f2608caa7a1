//! Run time against error of collision tests: `cargo bench -p meso-core --bench accuracy`.
//!
//! Bodies of 20 to 30 points at a known gap or depth; then the same near-touching pairs at other scales, far from the
//! origin, stretched, and with more vertices. Truth is exact arithmetic. CSV and SVG files go to `benches/results/`.
//! `--quick` takes small cases.
#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

mod collision;

use collision::bodies::{Dice, Grain};
use collision::ccd::Ccd;
use collision::clock::seconds;
use collision::literal::{self, Outcome};
use collision::plot::{Line, Plot};
use collision::table::{count, save};
use collision::{Measured, machine};
use meso_collision::gjk::{self, Algorithm};
use meso_collision::math::Vec3;
use parry3d_f64::math::{Pose, Vector};
use parry3d_f64::query;
use parry3d_f64::shape::ConvexPolyhedron;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Pairs per value on an axis.
const PAIRS: usize = 100;
const FEW: usize = 4;

/// Two bodies where they are, with the truth about them.
struct Case {
    a: Vec<Vec3>,
    b: Vec<Vec3>,
    /// Points inside, for libccd.
    centres: [Vec3; 2],
    /// parry's forms, where its hull builder makes them.
    shapes: Option<[ConvexPolyhedron; 2]>,
    overlap: bool,
    distance: f64,
    size: f64,
}

impl Case {
    fn new(a: Vec<Vec3>, b: Vec<Vec3>) -> Self {
        let overlap = Algorithm::Exact.intersects(&a, &b).expect("in range");
        let distance = gjk::distance(&a, &b).expect("in range");
        let size = a.iter().chain(&b).map(|p| (p - a[0]).norm()).fold(0.0, f64::max);
        let shape = |s: &[Vec3]| {
            ConvexPolyhedron::from_convex_hull(&s.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect::<Vec<_>>())
        };
        let shapes = catch_unwind(AssertUnwindSafe(|| Some([shape(&a)?, shape(&b)?]))).ok().flatten();
        let centres = [&a, &b].map(|s| s.iter().sum::<Vec3>() / s.len() as f64);
        Self { a, b, centres, shapes, overlap, distance, size }
    }
}

/// What a contestant says of a case; `None`: nothing, or nothing in time.
type Ask<'a> = Box<dyn Fn(&Case) -> Option<bool> + 'a>;

fn contestants(ccd: Option<&Ccd>) -> Vec<(&'static str, Ask<'_>)> {
    let own = |method: Algorithm| -> Ask<'_> { Box::new(move |c| method.intersects(&c.a, &c.b).ok()) };
    let mut all: Vec<(&str, Ask<'_>)> = vec![
        ("enhanced", own(Algorithm::Enhanced)),
        ("classical (Johnson)", own(Algorithm::Classical)),
        ("signed volumes", own(Algorithm::SignedVolumes)),
        (
            "as printed",
            Box::new(|c| match literal::gjk_intersect(&c.a, &c.b, &Vec3::zeros()) {
                Outcome::Overlap => Some(true),
                Outcome::Apart => Some(false),
                Outcome::Endless => None,
            }),
        ),
        (
            "parry",
            Box::new(|c| {
                let [a, b] = c.shapes.as_ref()?;
                query::intersection_test(&Pose::IDENTITY, a, &Pose::IDENTITY, b).ok().map(|answer| answer.intersecting)
            }),
        ),
    ];
    if let Some(ccd) = ccd {
        all.push(("libccd MPR", Box::new(|c| ccd.mpr_of(&c.a, &c.b, &c.centres))));
        all.push(("libccd GJK", Box::new(|c| ccd.gjk_of(&c.a, &c.b, &c.centres))));
    }
    all
}

/// A pair whose distance along a face's normal is `gap` (negative: depth), over a size of about 1.
fn at_gap(dice: &mut Dice, n: usize, gap: f64) -> (Vec<Vec3>, Vec<Vec3>) {
    let mut body = || Grain::on_ellipsoid(dice, n, &Vec3::new(0.25, 0.22, 0.18)).points;
    let (a, b) = (body(), body());
    let v = dice.direction();
    let farthest = |s: &[Vec3], v: &Vec3| *s.iter().max_by(|p, q| p.dot(v).total_cmp(&q.dot(v))).expect("points");
    // The lowest corner of B above the highest of A, moved by the gap: both stay supports, so that the gap is exact
    // up to rounding.
    let (top, bottom) = (farthest(&a, &v), farthest(&b, &-v));
    let by = top - bottom + v * gap;
    (a, b.iter().map(|p| p + by).collect())
}

fn mapped(pair: (Vec<Vec3>, Vec<Vec3>), f: impl Fn(&Vec3) -> Vec3) -> (Vec<Vec3>, Vec<Vec3>) {
    (pair.0.iter().map(&f).collect(), pair.1.iter().map(&f).collect())
}

/// Makes a pair for a value on an axis.
type MakePair = Box<dyn Fn(&mut Dice, f64) -> (Vec<Vec3>, Vec<Vec3>)>;

/// One question: an axis with its values, and how a value makes pairs.
struct Question<'a> {
    name: &'a str,
    axis: &'a str,
    values: Vec<f64>,
    pair: MakePair,
}

fn questions() -> Vec<Question<'static>> {
    let decades = |from: i32, to: i32, step: usize| {
        (from..=to).step_by(step).map(|e| format!("1e{e}").parse().expect("a number")).collect()
    };
    // Around touching: gaps and depths of 1e-4 to 1e-10 of the size.
    let near = |dice: &mut Dice, n: usize| {
        let gap = libm::pow(10.0, dice.between(-10.0, -4.0)) * if dice.below(2) == 0 { 1.0 } else { -1.0 };
        at_gap(dice, n, gap)
    };
    let count = |dice: &mut Dice| 20 + dice.below(11);
    let near_touch = |name, axis, sign: f64| Question {
        name,
        axis,
        values: decades(-15, -1, 1),
        pair: Box::new(move |dice, size| {
            let n = count(dice);
            at_gap(dice, n, sign * size)
        }),
    };
    vec![
        near_touch("gap", "gap over size", 1.0),
        near_touch("depth", "depth over size", -1.0),
        Question {
            name: "scale",
            axis: "size",
            values: decades(-12, 12, 2),
            pair: Box::new(move |dice, scale| {
                let n = count(dice);
                mapped(near(dice, n), |p| p * scale)
            }),
        },
        Question {
            name: "offset",
            axis: "distance from the origin over size",
            values: decades(0, 12, 1),
            pair: Box::new(move |dice, far| {
                let (n, by) = (count(dice), dice.direction() * far);
                mapped(near(dice, n), |p| p + by)
            }),
        },
        Question {
            name: "aspect",
            axis: "aspect ratio",
            values: decades(0, 6, 1),
            pair: Box::new(move |dice, ratio| {
                let n = count(dice);
                mapped(near(dice, n), |p| Vec3::new(p.x, p.y, p.z / ratio))
            }),
        },
        Question {
            name: "vertices",
            axis: "vertices per body",
            values: vec![8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0],
            pair: Box::new(move |dice, n| near(dice, n as usize)),
        },
    ]
}

/// Asks everybody everything; a CSV and two plots per question.
fn answer(question: &Question<'_>, ccd: Option<&Ccd>) {
    let mut table = Measured::new("value,contestant,pairs,missed_overlaps,false_overlaps,no_answer,ns_per_query");
    let (mut wrong_lines, mut time_lines): (Vec<Line>, Vec<Line>) = (Vec::new(), Vec::new());
    let mut distances = Measured::new("value,contestant,largest_error_over_size,ns_per_query");
    let mut totals: Vec<(&str, usize)> = Vec::new();
    let pairs = count(PAIRS, FEW);
    for &value in &question.values {
        let mut dice = Dice::new(value.to_bits());
        let cases: Vec<Case> =
            (0..pairs).map(|_| (question.pair)(&mut dice, value)).map(|(a, b)| Case::new(a, b)).collect();
        for (i, (name, ask)) in contestants(ccd).iter().enumerate() {
            let (answers, time) = timed(&cases, ask);
            let how_many =
                |f: &dyn Fn(&Case, &Option<bool>) -> bool| cases.iter().zip(&answers).filter(|(c, a)| f(c, a)).count();
            let missed = how_many(&|c, a| c.overlap && *a == Some(false));
            let made_up = how_many(&|c, a| !c.overlap && *a == Some(true));
            let none = how_many(&|_, a| a.is_none());
            table.row(&[
                format!("{value:e}"),
                (*name).into(),
                pairs.to_string(),
                missed.to_string(),
                made_up.to_string(),
                none.to_string(),
                format!("{time:.0}"),
            ]);
            if i == wrong_lines.len() {
                wrong_lines.push(((*name).into(), Vec::new()));
                time_lines.push(((*name).into(), Vec::new()));
                totals.push((*name, 0));
            }
            totals[i].1 += missed + made_up + none;
            wrong_lines[i].1.push((value, 100.0 * (missed + made_up + none) as f64 / pairs as f64));
            time_lines[i].1.push((value, time));
        }
        distance_errors(value, &cases, &mut distances);
    }
    println!("{:10} wrong or no answer of {}: {totals:?}", question.name, pairs * question.values.len());
    table.save(&format!("accuracy_{}.csv", question.name));
    distances.save(&format!("accuracy_{}_distance.csv", question.name));
    let plot = |y, log_y, lines| Plot { title: "", x: question.axis, y, log_x: true, log_y, lines }.svg();
    save(&format!("accuracy_{}.svg", question.name), &plot("% wrong or no answer", false, &wrong_lines));
    save(&format!("accuracy_{}_time.svg", question.name), &plot("ns per query", true, &time_lines));
}

/// The answers, and the median of three turns in ns per query.
fn timed<T>(cases: &[Case], ask: impl Fn(&Case) -> T) -> (Vec<T>, f64) {
    let turn = || {
        let start = seconds();
        let answers: Vec<T> = cases.iter().map(&ask).collect();
        (answers, (seconds() - start) * 1e9 / cases.len() as f64)
    };
    let mut turns = [turn(), turn(), turn()];
    turns.sort_by(|p, q| p.1.total_cmp(&q.1));
    let [_, (answers, time), _] = turns;
    (answers, time)
}

/// parry's largest error of the distance over the size, where the bodies are apart, and both times.
///
/// The yardstick is mesocrete's own distance, so its error is not measured here: the tests do that, against a brute-force
/// minimum in integers.
fn distance_errors(value: f64, cases: &[Case], table: &mut Measured) {
    let parry = |c: &Case| {
        let [a, b] = c.shapes.as_ref()?;
        query::distance(&Pose::IDENTITY, a, &Pose::IDENTITY, b).ok().map(|answer| answer.distance)
    };
    let (found, time) = timed(cases, parry);
    let apart = cases.iter().zip(found).filter(|(c, _)| !c.overlap);
    let error = |(c, d): (&Case, Option<f64>)| d.map_or(f64::INFINITY, |d| (d - c.distance).abs() / c.size);
    let worst = apart.map(error).fold(0.0, f64::max);
    table.row(&[format!("{value:e}"), "parry".into(), format!("{worst:.2e}"), format!("{time:.0}")]);
    let (_, time) = timed(cases, |c| gjk::distance(&c.a, &c.b));
    table.row(&[format!("{value:e}"), "mesocrete".into(), String::new(), format!("{time:.0}")]);
}

/// A named way to make pairs.
type Family = (&'static str, fn(&mut Dice) -> (Vec<Vec3>, Vec<Vec3>));

/// The pairs on which the printed algorithms are counted.
const FAMILIES: [Family; 4] = [
    ("20 to 30 vertices, gap or depth 1e-9 to 1e-1", |dice| {
        let gap = libm::pow(10.0, dice.between(-9.0, -1.0)) * if dice.below(2) == 0 { 1.0 } else { -1.0 };
        let n = 20 + dice.below(11);
        at_gap(dice, n, gap)
    }),
    ("small integers", |dice| {
        let b = integers(dice, 3);
        let by = Vec3::from_fn(|_, _| dice.below(11) as f64 - 5.0);
        (integers(dice, 3), b.iter().map(|p| p + by).collect())
    }),
    ("the same in tenths", |dice| {
        let (a, b) = FAMILIES[1].1(dice);
        mapped((a, b), |p| p * 0.1)
    }),
    ("small integers, touching in a vertex", |dice| {
        let (a, b) = (integers(dice, 3), integers(dice, 3));
        let v = Vec3::new(1.0, 0.3, -0.2) + Vec3::from_fn(|_, _| dice.below(9) as f64 - 4.0);
        let highest = |s: &[Vec3], v: &Vec3| *s.iter().max_by(|p, q| p.dot(v).total_cmp(&q.dot(v))).expect("points");
        let by = highest(&a, &v) - highest(&b, &-v);
        (a, b.iter().map(|p| p + by).collect())
    }),
];

/// Four to nine points with coordinates up to `largest`.
fn integers(dice: &mut Dice, largest: usize) -> Vec<Vec3> {
    let n = 4 + dice.below(6);
    (0..n).map(|_| Vec3::from_fn(|_, _| dice.below(2 * largest + 1) as f64 - largest as f64)).collect()
}

/// How often the paper's algorithms, as printed, go round for ever or answer wrongly.
fn as_printed() {
    let all = count(20_000, 100);
    let mut table = Measured::new("pairs,count,overlapping,endless,missed_overlaps,false_overlaps");
    for (name, pair) in FAMILIES {
        let mut dice = Dice::new(3883);
        // Overlapping, endless, missed, made up.
        let mut counts = [0; 4];
        for _ in 0..all {
            let (a, b) = pair(&mut dice);
            let truth = gjk::intersects(&a, &b).expect("in range");
            let said = literal::gjk_intersect(&a, &b, &Vec3::zeros());
            counts[0] += usize::from(truth);
            counts[1] += usize::from(said == Outcome::Endless);
            counts[2] += usize::from(truth && said == Outcome::Apart);
            counts[3] += usize::from(!truth && said == Outcome::Overlap);
        }
        println!("as printed, {name}: of {all} overlapping, endless, missed, made up {counts:?}");
        let mut row = vec![name.replace(',', ""), all.to_string()];
        row.extend(counts.map(|count| count.to_string()));
        table.row(&row);
    }
    table.save("accuracy_as_printed.csv");
}

fn main() {
    machine::choose_isa();
    let ccd = Ccd::load().inspect_err(|reason| println!("{reason}")).ok();
    // parry's hull builder panics on some flat bodies; that is its answer, not ours to print.
    std::panic::set_hook(Box::new(|_| {}));
    for question in questions() {
        answer(&question, ccd.as_ref());
    }
    as_printed();
}
