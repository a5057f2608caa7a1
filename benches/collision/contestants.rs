//! Who answers pair queries: our variants, and the peers that are there.

use super::bodies::Grain;
use super::ccd::Ccd;
use super::clock::Contestant;
use super::literal::{self, Outcome};
use super::pairs::Query;
use meso_collision::gjk::Algorithm;
use parry3d_f64::math::Pose;
use parry3d_f64::query;

/// How one pair is asked.
pub type AskOne<'a> = Box<dyn Fn(&Query, &Grain, &Grain) -> bool + 'a>;

fn mesocrete<'a>() -> AskOne<'a> {
    Box::new(|q, a, b| a.body.overlaps(&b.body, &q.x))
}

fn method<'a>(method: Algorithm) -> AskOne<'a> {
    Box::new(move |q, a, b| method.overlap(&a.body, &b.body, &q.x))
}

fn parry<'a>() -> AskOne<'a> {
    Box::new(|q, a, b| {
        let at = Pose::translation(q.x.x, q.x.y, q.x.z);
        query::intersection_test(&Pose::IDENTITY, &a.parry, &at, &b.parry).expect("supported").intersecting
    })
}

fn as_printed<'a>() -> AskOne<'a> {
    Box::new(|q, a, b| literal::gjk_intersect(&a.points, &b.points, &q.x) == Outcome::Overlap)
}

/// Mesocrete, its variants, and the peers that are there.
pub fn everybody<'a>(ccd: Option<&'a Ccd>) -> Vec<(String, AskOne<'a>)> {
    let mut all: Vec<(String, AskOne<'a>)> = vec![
        ("mesocrete".into(), mesocrete()),
        ("enhanced".into(), method(Algorithm::Enhanced)),
        ("classical, Johnson".into(), method(Algorithm::Classical)),
        ("classical, signed volumes".into(), method(Algorithm::SignedVolumes)),
        ("as printed".into(), as_printed()),
        ("parry".into(), parry()),
    ];
    if let Some(ccd) = ccd {
        all.push(("libccd MPR".into(), Box::new(move |q, a, b| ccd.mpr(&a.points, &b.points, &q.x))));
        all.push(("libccd GJK".into(), Box::new(move |q, a, b| ccd.gjk(&a.points, &b.points, &q.x))));
    }
    all
}

/// Every contestant over slices of queries, mesocrete first.
pub fn contestants<'a>(grains: &'a [Grain], ccd: Option<&'a Ccd>) -> Vec<Contestant<'a, Query>> {
    let contestant = |(name, ask): (String, AskOne<'a>)| {
        let run = move |queries: &[Query]| {
            queries.iter().filter(|q| ask(q, &grains[q.a as usize], &grains[q.b as usize])).count()
        };
        (name, Box::new(run) as _)
    };
    everybody(ccd).into_iter().map(contestant).collect()
}
