//! The inward offset against erosions to hundreds of digits.

use crate::dice::Dice;
use crate::erosion::Planes;
use crate::hull::assert_closed;
use crate::solids::{Cloud, block, coplanar, duplicates, hard, issues, lattices, near_flat, paper, scaled};
use meso_collision::geometry::{OffsetError, Polyhedron, convex_hull};
use meso_collision::math::Vec3;

/// How the offsets of a family came out.
#[derive(Debug, Default)]
struct Score {
    right: usize,
    vanished: usize,
    refused: usize,
    worst: f64,
}

/// Compares offsets at shares of the inradius, below and above 1, with the reference; panics where a vanishing is wrong.
fn score(clouds: &[Cloud]) -> Score {
    let mut score = Score::default();
    for cloud in clouds {
        let body = convex_hull(&cloud.points).unwrap();
        let planes = Planes::of(&body);
        let radius = body.inscribed_ball().radius;
        for share in [0.05, 0.3, 0.7, 0.95, 0.999, 1.001, 1.5] {
            let thickness = radius * share;
            compare(&mut score, &body, body.inward_offset(thickness), planes.eroded_volume(thickness), &cloud.name);
        }
    }
    score
}

fn compare(
    score: &mut Score,
    body: &Polyhedron,
    core: Result<Option<Polyhedron>, OffsetError>,
    expected: f64,
    name: &str,
) {
    match core {
        Ok(None) => {
            assert_eq!(expected, 0.0, "{name}: said to vanish");
            score.vanished += 1;
        }
        Ok(Some(core)) => {
            assert!(expected > 0.0, "{name}: a ghost of {} mm3", core.volume());
            let error = (core.volume() / expected - 1.0).abs();
            score.worst = score.worst.max(error);
            score.right += 1;
        }
        Err(error) => {
            assert!(matches!(error, OffsetError::IllConditioned { .. }), "{name}: {error}");
            assert!(expected > 0.0, "{name}: no answer where there is one, nothing");
            // Thinner than the spacing of f64 numbers there shows.
            let reach = body.vertices().iter().map(Vec3::amax).fold(0.0, f64::max);
            assert!(expected <= 4e-13 * reach * body.area(), "{name}: {error}, of {expected:e} mm3");
            score.refused += 1;
        }
    }
}

#[test]
fn well_shaped_bodies_keep_twelve_digits() {
    keep_twelve_digits(1);
}

#[test]
#[ignore = "slow tier"]
fn many_well_shaped_bodies_keep_twelve_digits() {
    keep_twelve_digits(6);
}

/// Asserts twelve digits, on `many` times the least number of bodies.
fn keep_twelve_digits(many: usize) {
    let mut dice = Dice::new(30);
    let few = |clouds: Vec<Cloud>| clouds.into_iter().filter(|c| c.points.len() < 16).collect::<Vec<_>>();
    let families = [
        few(paper(&mut dice, 4 * many)),
        few(lattices(&mut dice, 10 * many)),
        few(duplicates(&mut dice, 6 * many)),
        few(coplanar(&mut dice)),
        few(scaled(&mut dice, 8 * many)),
    ];
    for family in families {
        let score = score(&family);
        assert!(score.worst <= 1e-12 && score.refused == 0, "{}: {score:?}", family[0].name);
        assert!(score.vanished >= 2 * family.len(), "{}: {score:?}", family[0].name);
    }
}

/// A turned, scaled and moved solid of which every face touches the largest ball inside: an erosion by the share s of that
/// radius is the solid itself, scaled by 1 - s.
struct Regular {
    name: String,
    points: Vec<Vec3>,
    /// Radius of that ball, mm.
    radius: f64,
}

/// Corners with coordinates of every sign.
fn mirrored(corners: &[[f64; 3]]) -> Vec<Vec3> {
    let signs = |corner: &[f64; 3]| block(*corner);
    let mut all: Vec<Vec3> = corners.iter().flat_map(signs).collect();
    all.sort_by(|p, q| p.as_slice().partial_cmp(q.as_slice()).unwrap());
    all.dedup();
    all
}

/// The platonic solids, and prisms as high as their sides are apart.
fn regular_solids() -> Vec<(String, Vec<Vec3>)> {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let tetrahedron = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let dodecahedron =
        [[1.0; 3], [0.0, 1.0 / golden, golden], [1.0 / golden, golden, 0.0], [golden, 0.0, 1.0 / golden]];
    let mut all = vec![
        ("tetrahedron".to_owned(), tetrahedron.map(Vec3::from).to_vec()),
        ("cube".to_owned(), block([1.0; 3])),
        ("octahedron".to_owned(), mirrored(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])),
        ("icosahedron".to_owned(), mirrored(&[[0.0, 1.0, golden], [1.0, golden, 0.0], [golden, 0.0, 1.0]])),
        ("dodecahedron".to_owned(), mirrored(&dodecahedron)),
    ];
    for sides in [3, 5, 6, 7, 12, 24, 60, 200] {
        let apothem = libm::cos(std::f64::consts::PI / sides as f64);
        let corner = |k: usize| {
            let (y, x) = libm::sincos(std::f64::consts::TAU * (k / 2) as f64 / sides as f64);
            Vec3::new(x / apothem, y / apothem, if k.is_multiple_of(2) { -1.0 } else { 1.0 })
        };
        all.push((format!("prism of {sides} sides"), (0..2 * sides).map(corner).collect()));
    }
    all
}

/// `count` of them, turned, scaled and moved; every third with up to 2,000 points strewn over its faces, up to `noise` off.
fn solids_of_known_erosion(dice: &mut Dice, count: usize, noise: f64) -> Vec<Regular> {
    let kinds = regular_solids();
    let regular = |k: usize| {
        let (name, corners) = &kinds[k % kinds.len()];
        let (turn, scale, away) = (dice.rotation(), 1.0 + 9.0 * dice.unit(), dice.direction() * 10.0 * dice.unit());
        let body = convex_hull(corners).unwrap();
        let radius = body.inscribed_ball().radius;
        let strewn = if k.is_multiple_of(3) { [100, 500, 2000][k / 3 % 3] } else { 0 };
        let points: Vec<Vec3> = corners.iter().copied().chain(on_faces(dice, &body, strewn, noise)).collect();
        let points = points.iter().map(|p| turn * p * scale + away).collect();
        Regular { name: format!("{name} {k}, {strewn} points on it"), points, radius: radius * scale }
    };
    (0..count).map(regular).collect()
}

/// Points of the faces, each up to `noise` inside or outside.
fn on_faces(dice: &mut Dice, body: &Polyhedron, count: usize, noise: f64) -> Vec<Vec3> {
    let triangles: Vec<[Vec3; 3]> = body.triangles().map(|t| t.map(|i| body.vertices()[i as usize])).collect();
    (0..count)
        .map(|k| {
            let [a, b, c] = triangles[k % triangles.len()];
            let (u, v) = (dice.unit(), dice.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            a + (b - a) * u + (c - a) * v + dice.direction() * noise * dice.unit()
        })
        .collect()
}

/// The worst relative error of the volumes at shares of the radius.
fn worst_of_regular(solids: &[Regular]) -> f64 {
    let mut worst: f64 = 0.0;
    for solid in solids {
        let body = convex_hull(&solid.points).unwrap();
        for share in [0.02, 0.3, 0.9] {
            let core =
                body.inward_offset(share * solid.radius).unwrap_or_else(|error| panic!("{}: {error}", solid.name));
            let core = core.unwrap_or_else(|| panic!("{} vanished", solid.name));
            assert_closed(&core, &solid.name);
            worst = worst.max((core.volume() / (body.volume() * (1.0 - share).powi(3)) - 1.0).abs());
        }
        assert_eq!(body.inward_offset(1.001 * solid.radius).unwrap(), None, "{}", solid.name);
    }
    worst
}

#[test]
fn turned_prisms_and_platonic_solids_shrink_as_geometry_says() {
    let worst = worst_of_regular(&solids_of_known_erosion(&mut Dice::new(37), 300, 0.0));
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
#[ignore = "slow tier"]
fn a_thousand_turned_prisms_platonic_solids_and_nearly_flat_hulls_shrink_as_geometry_says() {
    let worst = worst_of_regular(&solids_of_known_erosion(&mut Dice::new(38), 1000, 0.0));
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn nearly_coplanar_clouds_have_an_offset_at_every_noise() {
    for noise in [1e-15, 1e-13, 1e-11] {
        let worst = worst_of_regular(&solids_of_known_erosion(&mut Dice::new(39), 40, noise));
        assert!(worst < 1e-12 + 1e2 * noise, "{noise:e}: {worst:e}");
    }
}

#[test]
fn plates_keep_nine_digits_or_are_refused() {
    let mut plates = near_flat(&mut Dice::new(31), 12);
    plates.extend(issues());
    plates.retain(|cloud| cloud.points.len() < 20);
    let score = score(&plates);
    assert!(score.worst <= 1e-9, "{score:?}");
    assert!(score.right > plates.len(), "{score:?}");
    assert!(score.vanished >= 2 * plates.len(), "{score:?}");
}

#[test]
fn vanishing_is_decided_to_the_last_bit() {
    let mut dice = Dice::new(32);
    let families = [
        paper(&mut dice, 6),
        lattices(&mut dice, 6),
        coplanar(&mut dice),
        near_flat(&mut dice, 6),
        scaled(&mut dice, 6),
    ];
    let (mut vanished, mut left) = (0, 0);
    for cloud in families.into_iter().flatten().filter(|cloud| cloud.points.len() < 14) {
        let body = convex_hull(&cloud.points).unwrap();
        let planes = Planes::of(&body);
        let radius = body.inscribed_ball().radius;
        for step in -3..=3 {
            let thickness = f64::from_bits(radius.to_bits().wrapping_add_signed(step));
            let vanishes = matches!(body.inward_offset(thickness), Ok(None));
            assert_eq!(vanishes, planes.eroded_volume(thickness) == 0.0, "{} by {thickness:e}", cloud.name);
            *(if vanishes { &mut vanished } else { &mut left }) += 1;
        }
    }
    assert!(vanished > 60 && left > 60, "{vanished} vanished, {left} left");
}

/// Offsets of hard sets, at shares of the inradius and at its neighbours, against the reference.
fn score_hard_sets(seed: u64, sets: usize) -> Score {
    let mut dice = Dice::new(seed);
    let mut score = Score::default();
    for kind in (0..sets).filter(|kind| kind % 7 != 3) {
        let cloud = hard(&mut dice, kind);
        let Some(body) = convex_hull(&cloud.points).ok().filter(|body| body.faces().len() < 20) else { continue };
        let planes = Planes::of(&body);
        let radius = body.inscribed_ball().radius;
        for thickness in [0.4 * radius, 0.99 * radius, radius.next_down(), radius, radius.next_up()] {
            compare(&mut score, &body, body.inward_offset(thickness), planes.eroded_volume(thickness), &cloud.name);
        }
    }
    score
}

#[test]
fn offsets_of_hard_sets_are_right_or_refused() {
    let score = score_hard_sets(35, 50);
    assert!(score.worst <= 1e-9 && score.right > 15 && score.vanished > 25, "{score:?}");
}

#[test]
#[ignore = "slow tier"]
fn offsets_of_many_hard_sets_are_right_or_refused() {
    let score = score_hard_sets(36, 3000);
    assert!(score.worst <= 1e-9, "{score:?}");
}

#[test]
fn cores_are_closed_and_inside_their_bodies() {
    let mut dice = Dice::new(33);
    let families = [paper(&mut dice, 60), lattices(&mut dice, 60), coplanar(&mut dice)];
    for cloud in families.into_iter().flatten() {
        let body = convex_hull(&cloud.points).unwrap();
        let radius = body.inscribed_ball().radius;
        let volumes = [0.1, 0.5, 0.9].map(|share| {
            let core = body.inward_offset(share * radius).unwrap().unwrap();
            assert_closed(&core, &cloud.name);
            assert!(core.vertices().iter().all(|v| body.contains(v)), "{}", cloud.name);
            core.volume()
        });
        assert!(volumes[0] > volumes[1] && volumes[1] > volumes[2], "{}: {volumes:?}", cloud.name);
        assert_eq!(body.inward_offset(0.0).unwrap().unwrap(), body);
    }
}

#[test]
fn faces_that_shrink_to_an_edge_disappear() {
    // |x|, |y| <= 4, |z| <= 3 and 3x + 4y <= 27: moved inwards by 0.5, the chamfer touches the corner it cut off.
    // (11/3 is no f64, so the event is met but for a rounding.)
    let outline = [[-4.0, -4.0], [4.0, -4.0], [4.0, 3.75], [11.0 / 3.0, 4.0], [-4.0, 4.0]];
    let points: Vec<Vec3> = outline.iter().flat_map(|[x, y]| [-3.0, 3.0].map(|z| Vec3::new(*x, *y, z))).collect();
    let body = convex_hull(&points).unwrap();
    for (thickness, faces) in [(0.25, 7), (0.75, 6)] {
        assert_eq!(body.inward_offset(thickness).unwrap().unwrap().faces().len(), faces);
    }
    let core = body.inward_offset(0.5).unwrap().unwrap();
    assert_closed(&core, "event");
    assert!((core.volume() / (7.0 * 7.0 * 5.0) - 1.0).abs() < 1e-14, "{}", core.volume());
}

#[test]
fn an_octahedron_keeps_its_six_vertices() {
    let points: Vec<Vec3> = [Vec3::x(), Vec3::y(), Vec3::z()].iter().flat_map(|axis| [*axis, -axis]).collect();
    let turn = Dice::new(34).rotation();
    let body = convex_hull(&points.iter().map(|p| turn * p * 3.0 + Vec3::repeat(70.0)).collect::<Vec<_>>()).unwrap();
    let core = body.inward_offset(0.7).unwrap().unwrap();
    // Four planes meet in every vertex: rounding must not split them.
    assert_eq!((core.vertices().len(), core.faces().len()), (6, 8));
}

#[test]
fn an_octahedron_is_right_when_1e30ths_of_it_are_left() {
    // |x| + |y| + |z| <= p, moved inwards by q. By Pell's equation, p^2 - 3 q^2 = 1, the rest of p is
    // p - sqrt(3) q = 1 / (p + sqrt(3) q).
    let (mut p, mut q) = (2_u64, 1_u64);
    while p < 1 << 51 {
        let reach = p as f64;
        let corners: Vec<Vec3> = (0..3).flat_map(|i| [reach, -reach].map(|x| Vec3::ith(i, x))).collect();
        let core = convex_hull(&corners).unwrap().inward_offset(q as f64).unwrap().expect("something is left");
        let left = 1.0 / (reach + 3_f64.sqrt() * q as f64);
        assert!((core.volume() / (4.0 / 3.0 * left.powi(3)) - 1.0).abs() < 1e-14, "{p}: {:e}", core.volume());
        assert_eq!((core.vertices().len(), core.faces().len()), (6, 8));
        (p, q) = (2 * p + 3 * q, p + 2 * q);
    }
}

#[test]
fn thin_cores_far_from_the_origin_are_right_or_refused() {
    let turn = Dice::new(37).rotation();
    let corners = (0..3).flat_map(|i| [1.0, -1.0].map(|x| turn * Vec3::ith(i, x) + Vec3::repeat(1e6)));
    let body = convex_hull(&corners.collect::<Vec<_>>()).unwrap();
    let radius = body.inscribed_ball().radius;
    let (mut shown, mut refused) = (0, 0);
    for left in (8..50).map(|power| 0.75 * 0.5_f64.powi(power)) {
        match body.inward_offset(radius * (1.0 - left)) {
            Ok(Some(core)) => {
                let at = |i: u32| core.vertices()[i as usize] - core.vertices()[0];
                let six: f64 = core.triangles().map(|[a, b, c]| at(a).dot(&at(b).cross(&at(c)))).sum();
                assert!((six / 6.0 / core.volume() - 1.0).abs() < 1e-2, "{left:e}: {six:e} / 6, {:e}", core.volume());
                shown += 1;
            }
            Ok(None) => {}
            Err(error) => {
                assert!(matches!(error, OffsetError::IllConditioned { .. }), "{error}");
                refused += 1;
            }
        }
    }
    assert!(shown > 5 && refused > 5, "{shown} shown, {refused} refused");
}

#[test]
fn a_shrunk_cube_is_a_cube() {
    let body = convex_hull(&block([1.0; 3])).unwrap();
    for thickness in [0.0, 0.1, 0.25, 0.9, 0.999] {
        let core = body.inward_offset(thickness).unwrap().unwrap();
        let side = 2.0 - 2.0 * thickness;
        assert!((core.volume() / side.powi(3) - 1.0).abs() < 1e-13, "{} at {thickness}", core.volume());
        assert_eq!((core.vertices().len(), core.faces().len()), (8, 6));
    }
}

#[test]
fn a_cube_vanishes_at_half_its_side_and_not_before() {
    let body = convex_hull(&block([1.0; 3])).unwrap();
    assert_eq!(body.inscribed_ball().radius, 1.0);
    assert_eq!(body.inward_offset(1.0).unwrap(), None);
    assert_eq!(body.inward_offset(1.0 + f64::EPSILON).unwrap(), None);
    let almost = 1.0 - f64::EPSILON * 1e5;
    let core = body.inward_offset(almost).unwrap().unwrap();
    assert!((core.volume() / (2.0 - 2.0 * almost).powi(3) - 1.0).abs() < 1e-12);
    assert!(!matches!(body.inward_offset(1.0 - f64::EPSILON / 2.0), Ok(None)));
}

#[test]
fn thicknesses_that_are_none_are_refused() {
    let cube = convex_hull(&block([4.0; 3])).unwrap();
    for thickness in [f64::NAN, f64::INFINITY, -1e-9] {
        assert!(matches!(cube.inward_offset(thickness), Err(OffsetError::Thickness { .. })), "{thickness}");
    }
}
