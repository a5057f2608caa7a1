//! Small models made by hand, for tests of the work on a model.

use meso_core::Model;
use meso_core::aggregate::{Aggregate, Kind};
use meso_core::geometry::Polyhedron;
use meso_core::math::Vec3;
use meso_core::packing::{ClassReport, Report, Seconds, SpecimenReport, StopReason, Work};
use meso_core::spec::Spec;
use parry3d_f64::math::Vector;
use parry3d_f64::shape::ConvexPolyhedron;

/// The faces of a box whose corner i has the coordinates' upper limits where i's bits are set.
const BOX_FACES: [[u32; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// An axis-parallel box as a polyhedron.
pub(crate) fn box_body(min: [f64; 3], max: [f64; 3]) -> Polyhedron {
    let corner = |i: usize| Vec3::from_fn(|axis, _| if i >> axis & 1 == 1 { max[axis] } else { min[axis] });
    Polyhedron::from_parts((0..8).map(corner).collect(), BOX_FACES)
}

/// A model of the default spec that holds `bodies`, all in the finest class, with an ITZ of a third of a millimetre.
pub(crate) fn model_of(bodies: Vec<Polyhedron>) -> Model {
    let spec = Spec::default();
    let report = report_of(&spec, bodies.len());
    let aggregate = |(i, body)| Aggregate {
        id: i as u32,
        kind: Kind::Aggregate,
        own: None,
        class: 0,
        itz_thickness_mm: 1.0 / 3.0,
        shells: Vec::new(),
        body,
    };
    Model { spec, aggregates: bodies.into_iter().enumerate().map(aggregate).collect(), inclusions: Vec::new(), report }
}

/// Two boxes of 1,000 and 343 mm3 with coordinates that no short decimal hits.
pub(crate) fn two_boxes() -> Model {
    let third = 1.0 / 3.0;
    model_of(vec![box_body([third; 3], [10.0 + third; 3]), box_body([20.0, 1e-3, 0.1 + 0.2], [27.0, 7.001, 7.3])])
}

/// The aggregates as parry sees them.
pub(crate) fn parry_shapes(model: &Model) -> Vec<ConvexPolyhedron> {
    let points = |aggregate: &Aggregate| -> Vec<_> {
        aggregate.body.vertices().iter().map(|v| Vector::new(v.x, v.y, v.z)).collect()
    };
    let shape = |points: Vec<_>| ConvexPolyhedron::from_convex_hull(&points).expect("an aggregate is solid");
    model.aggregates.iter().map(|aggregate| shape(points(aggregate))).collect()
}

fn report_of(spec: &Spec, aggregates: usize) -> Report {
    let classes = spec.grading.classes().into_iter().enumerate().map(|(i, class)| ClassReport {
        d_min_mm: class.d_min_mm,
        d_max_mm: class.d_max_mm,
        target_fraction: class.share * spec.fraction,
        fraction: 0.0,
        aggregates: if i == 0 { aggregates } else { 0 },
    });
    Report {
        version: "0.1.0".into(),
        seed: spec.seed,
        target_fraction: spec.fraction,
        fraction: 0.0,
        coated_fraction: None,
        aggregates,
        discarded: 0,
        specimen: SpecimenReport::new(&spec.specimen),
        grading: "by hand".into(),
        strategy: "by hand".into(),
        classes: classes.collect(),
        phases: Vec::new(),
        own_phases: Vec::new(),
        shells: Vec::new(),
        itz_limited: Vec::new(),
        itz_thin: Vec::new(),
        reduced: Vec::new(),
        labels: None,
        stop_reason: StopReason::AttemptsExhausted,
        stop_detail: "made by hand".into(),
        seconds: Seconds::default(),
        work: Work { candidates: u64::MAX, ..Work::default() },
    }
}
