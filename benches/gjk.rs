//! Run time of collision tests: `cargo bench -p meso-collision --bench gjk -- [--isa scalar|avx2|avx512] [--only SET] [--quick]`.
//!
//! `--only "near touch"` measures this pair set alone, and writes no file.
//! The paper's Fig. 4 with every variant and the peers, and the pair sets of a packing. Medians of
//! processor time in one run, contestants taking turns; CSV and SVG files, one for each instruction set, go to `benches/results/`.
#![allow(clippy::print_stdout, reason = "a bench reports on stdout")]

mod collision;

use collision::bodies::Grain;
use collision::ccd::Ccd;
use collision::clock::{Contestant, compare};
use collision::contestants::{AskOne, contestants, everybody};
use collision::pairs::{self, Query, Stream};
use collision::plot::{Line, Plot};
use collision::table::{count, save};
use collision::{Measured, machine};
use meso_collision::gjk::{self, Impact, Penetration};
use meso_collision::math::Vec3;
use meso_collision::{gjk::Counters, simd::isa};

const CHUNK: usize = 500;
const ROUNDS: usize = 9;

/// The pair sets of a packing: ns per query of everybody, and the ratios the project asks for.
fn pair_sets(ccd: Option<&Ccd>) {
    let grains = pairs::grains(count(4000, 500));
    let mut table = Measured::new("pairs,contestant,ns_per_query,yes");
    let sets = [
        ("intersecting", pairs::intersecting(&grains)),
        ("separated", pairs::separated(&grains)),
        ("near touch", pairs::near_touch(&grains)),
    ];
    let only = only();
    for (name, queries) in sets.iter().filter(|(name, _)| only.as_deref().is_none_or(|only| only == *name)) {
        report(name, &grains, queries, ccd, &mut table);
    }
    if only.is_some() {
        return;
    }
    let stream = pairs::placement_stream(count(100, 40) as f64, 0.40, count(20_000, 1000));
    report("placement stream", &stream.grains, &stream.queries[..stream.queries.len().min(20_000)], ccd, &mut table);
    attempts(&stream, ccd, &mut table);
    table.save(&format!("gjk_pairs_{}.csv", isa().name()));
}

fn report(name: &str, grains: &[Grain], queries: &[Query], ccd: Option<&Ccd>, table: &mut Measured) {
    let mut counters = Counters::default();
    for q in queries {
        counters.overlap(&grains[q.a as usize].body, &grains[q.b as usize].body, &q.x);
    }
    println!(
        "\n{name}: {} pairs, {} after the spheres, {} after the ellipsoids, {} exact",
        counters.pairs, counters.after_spheres, counters.after_ellipsoids, counters.exact_calls
    );
    let all = contestants(grains, ccd);
    let times = compare(&all, queries, CHUNK, count(ROUNDS, 1));
    for ((contestant, run), time) in all.iter().zip(&times) {
        let yes = run(queries);
        println!("  {contestant:28} {:8.1} ns   {yes} overlap", time * 1e9);
        table.row(&[name.into(), contestant.replace(',', ""), format!("{:.1}", time * 1e9), yes.to_string()]);
    }
    let time = |name: &str| all.iter().position(|c| c.0 == name).map(|i| times[i]);
    for peer in ["libccd MPR", "parry"].iter().filter_map(|peer| time(peer).map(|t| (peer, t))) {
        println!("  against {}: {:.1} x", peer.0, peer.1 / times[0]);
    }
}

/// What a witness costs: microseconds per pair of plain points, intersecting ones for the depth, separated ones for the rest.
fn witnesses() {
    let grains = pairs::grains(count(1000, 50));
    let mut table = Measured::new("question,us_per_pair,widest_bounds_over_size");
    let moved = |q: &Query| grains[q.b as usize].points.iter().map(|p| p + q.x).collect::<Vec<Vec3>>();
    let points = |queries: Vec<Query>| -> Vec<_> {
        queries.iter().map(|q| (grains[q.a as usize].points.as_slice(), moved(q), q.x)).collect()
    };
    type Asked<'a> = (&'a [Vec3], Vec<Vec3>, Vec3);
    let (deep, apart) = (points(pairs::intersecting(&grains)), points(pairs::separated(&grains)));
    let size = |(a, b, _): &Asked<'_>| a.iter().chain(b).map(|p| p.norm()).fold(0.0, f64::max);
    type Ask<'f> = &'f dyn Fn(&Asked<'_>) -> f64;
    let ask_all: [(&str, &[Asked<'_>], Ask); 4] = [
        ("penetration", &deep, &|(a, b, _)| {
            let found = Penetration::of(a, b).expect("finite").expect("overlap");
            found.depth - found.at_least
        }),
        ("distance", &apart, &|(a, b, _)| 0.0 * gjk::distance(a, b).expect("finite")),
        ("closest points", &apart, &|(a, b, _)| 0.0 * gjk::closest_points(a, b).expect("finite")[0].x),
        ("time of impact", &apart, &|(a, b, x)| {
            let found = Impact::of(a, b, &-x).expect("finite").expect("it hits");
            found.by.map_or(f64::INFINITY, |by| (by - found.not_before) * x.norm())
        }),
    ];
    println!();
    for (question, asked, ask) in ask_all {
        let run = |asked: &[Asked<'_>]| asked.iter().filter(|asked| ask(asked) >= 0.0).count();
        let times = compare(&[(question.to_owned(), Box::new(run))], asked, CHUNK, count(ROUNDS, 1));
        let widest = asked.iter().map(|asked| ask(asked) / size(asked)).fold(0.0, f64::max);
        println!("  {question:28} {:8.2} us   bounds {widest:.1e} of the size apart at most", times[0] * 1e6);
        table.row(&[question.into(), format!("{:.2}", times[0] * 1e6), format!("{widest:.2e}")]);
    }
    table.save(&format!("gjk_witnesses_{}.csv", isa().name()));
}

/// Whole placement attempts: the peers stop at the first overlap, in the grid's order.
fn attempts(stream: &Stream, ccd: Option<&Ccd>, table: &mut Measured) {
    let ranges: Vec<[u32; 2]> =
        (0..stream.ends.len()).map(|i| [if i == 0 { 0 } else { stream.ends[i - 1] }, stream.ends[i]]).collect();
    let clear_one = |ask: &AskOne<'_>, range: &[u32; 2]| {
        let queries = &stream.queries[range[0] as usize..range[1] as usize];
        !queries.iter().any(|q| ask(q, &stream.grains[q.a as usize], &stream.grains[q.b as usize]))
    };
    let mut all: Vec<Contestant<'_, [u32; 2]>> = Vec::new();
    for (name, ask) in
        everybody(ccd).into_iter().filter(|(name, _)| ["mesocrete", "parry", "libccd MPR"].contains(&name.as_str()))
    {
        all.push((name, Box::new(move |ranges| ranges.iter().filter(|r| clear_one(&ask, r)).count())));
    }
    let times = compare(&all, &ranges, CHUNK, count(ROUNDS, 1));
    println!("\nper placement attempt, {:.1} neighbours:", stream.queries.len() as f64 / ranges.len() as f64);
    for ((name, run), time) in all.iter().zip(&times) {
        println!("  {name:28} {:8.1} ns   {:.1} x mesocrete's   {} clear", time * 1e9, time / times[0], run(&ranges));
        table.row(&["attempt".into(), name.replace(',', ""), format!("{:.1}", time * 1e9), run(&ranges).to_string()]);
    }
}

/// The paper's Fig. 4: one of three polyhedra against N intersecting ones.
fn figure_4(ccd: Option<&Ccd>) {
    let grains = pairs::grains(count(22_000, 500));
    let mut table = Measured::new("initial,n,contestant,ms");
    let mut lines: Vec<Line> = Vec::new();
    for initial in 0..3 {
        let queries = pairs::intersecting_with(&grains, initial);
        let all = contestants(&grains, ccd);
        let mut at_22_000 = Vec::new();
        for &n in &[500, 2_000, 5_000, 10_000, 16_000, 22_000][..count(6, 1)] {
            at_22_000 = compare(&all, &queries[..n], CHUNK, 3);
            for ((name, _), time) in all.iter().zip(&at_22_000) {
                table.row(&[
                    (initial + 1).to_string(),
                    n.to_string(),
                    name.replace(',', ""),
                    format!("{:.4}", time * n as f64 * 1e3),
                ]);
                if initial == 0 {
                    match lines.iter_mut().find(|line| line.0 == *name) {
                        Some(line) => line.1.push((n as f64, time * n as f64 * 1e3)),
                        None => lines.push((name.clone(), vec![(n as f64, time * n as f64 * 1e3)])),
                    }
                }
            }
        }
        println!("\nFig. 4, initial polyhedron {}, 22,000 intersecting pairs:", initial + 1);
        for ((name, _), time) in all.iter().zip(&at_22_000) {
            println!("  {name:28} {:8.2} ms", time * 22_000.0 * 1e3);
        }
        let [enhanced, johnson, volumes] = [2, 3, 4].map(|i| at_22_000[i]);
        println!(
            "  enhanced over classical: {:.2} x with Johnson, {:.2} x with signed volumes",
            johnson / enhanced,
            volumes / enhanced
        );
    }
    table.save(&format!("gjk_fig4_{}.csv", isa().name()));
    let plot = Plot {
        title: "One polyhedron against N intersecting ones",
        x: "N",
        y: "ms, one thread",
        log_x: false,
        log_y: true,
        lines: &lines,
    };
    save(&format!("gjk_fig4_{}.svg", isa().name()), &plot.svg());
}

/// The pair set of `--only`.
fn only() -> Option<String> {
    std::env::args().skip_while(|arg| arg != "--only").nth(1)
}

fn main() {
    println!("{}", machine::choose_isa().name());
    let ccd = Ccd::load().inspect_err(|reason| println!("{reason}")).ok();
    pair_sets(ccd.as_ref());
    if only().is_some() {
        return;
    }
    witnesses();
    figure_4(ccd.as_ref());
}
