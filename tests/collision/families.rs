//! Pairs of bodies of the kinds that have broken collision libraries, seeded.

use crate::dice::Dice;
use meso_collision::math::Vec3;

/// The points of two bodies.
pub(super) type Pair = (Vec<Vec3>, Vec<Vec3>);

/// A named kind of pairs.
pub(super) type Family = (&'static str, fn(&mut Dice) -> Pair);

/// Every kind.
pub(super) const ALL: &[Family] = &[
    ("random bodies", random_bodies),
    ("near touch", near_touch),
    ("small integers", small_integers),
    ("exact touch", exact_touch),
    ("one ulp from touch", one_ulp_from_touch),
    ("scaled", scaled),
    ("far from the origin", far_from_the_origin),
    ("needles and plates", needles_and_plates),
    ("low dimension", low_dimension),
    ("tiny and huge", tiny_and_huge),
    ("lattice boxes", lattice_boxes),
    ("reflected", reflected),
    ("regular solids", regular_solids),
    ("contained", contained),
    ("thin boxes face to face", thin_boxes),
    ("nearly coplanar", nearly_coplanar),
    ("mixed magnitudes", mixed_magnitudes),
    ("extreme magnitudes", extreme_magnitudes),
    ("fine spheres", fine_spheres),
];

fn moved(points: &[Vec3], by: &Vec3) -> Vec<Vec3> {
    points.iter().map(|p| p + by).collect()
}

pub(super) fn random_bodies(dice: &mut Dice) -> Pair {
    let n = 4 + dice.below(27);
    let (a, b) = (dice.body(n, 1.0), dice.body(24, 1.0));
    let x = dice.direction() * (2.2 * dice.unit());
    (a, moved(&b, &x))
}

/// Moves B along a direction until the supports along it are `gap` apart, up to rounding.
fn at_gap(a: &[Vec3], b: &[Vec3], v: &Vec3, gap: f64) -> Vec<Vec3> {
    let top = a.iter().map(|p| p.dot(v)).fold(f64::NEG_INFINITY, f64::max);
    let bottom = b.iter().map(|p| p.dot(v)).fold(f64::INFINITY, f64::min);
    moved(b, &(v * (top - bottom + gap)))
}

fn near_touch(dice: &mut Dice) -> Pair {
    let (a, b) = (dice.body(20, 1.0), dice.body(25, 1.0));
    // A face of A as the contact plane, B by a vertex; sometimes by a face of its own, turned to fit.
    let normal = (a[1] - a[0]).cross(&(a[2] - a[0])).normalize();
    let gap = dice.decade(-16.0, -3.0) * if dice.below(2) == 0 { 1.0 } else { -1.0 };
    let b = at_gap(&a, &b, &normal, gap);
    // Above the face or corner it rests on, so that the gap is the distance.
    let top = *a.iter().max_by(|p, q| p.dot(&normal).total_cmp(&q.dot(&normal))).expect("points");
    let low = *b.iter().min_by(|p, q| p.dot(&normal).total_cmp(&q.dot(&normal))).expect("points");
    let side = (top - low) - normal * normal.dot(&(top - low));
    (a, moved(&b, &side))
}

fn small_integers(dice: &mut Dice) -> Pair {
    let range = 1 + dice.below(4) as i64;
    let mut body = |max: usize| -> Vec<Vec3> { (0..1 + dice.below(max)).map(|_| dice.integers(range)).collect() };
    let (a, b) = (body(9), body(9));
    let shift = dice.integers(2 * range);
    (a, moved(&b, &shift))
}

/// Below and above a plane through the origin, with common points in it: touching in a vertex, an edge or a face.
fn exact_touch(dice: &mut Dice) -> Pair {
    let shear = [dice.integer(3), dice.integer(3)];
    let tilt = |p: Vec3| Vec3::new(p.x, p.y + shear[0] * p.x, p.z + shear[1] * p.y + shear[0] * p.x);
    let flat = |dice: &mut Dice| Vec3::new(dice.integer(5), dice.integer(5), 0.0);
    let common = flat(dice);
    let mut half = |sign: f64| -> Vec<Vec3> {
        let mut body: Vec<Vec3> = (0..dice.below(4)).map(|_| flat(dice)).collect();
        body.extend(
            (0..1 + dice.below(6))
                .map(|_| Vec3::new(dice.integer(6), dice.integer(6), sign * (1.0 + dice.below(5) as f64))),
        );
        let partner = flat(dice);
        // The common point is a corner, or the middle of two.
        body.extend(if dice.below(2) == 0 { vec![common] } else { vec![common + partner, common - partner] });
        body.into_iter().map(tilt).collect()
    };
    let pair = (half(-1.0), half(1.0));
    let scale = [1.0, 0.1, 1.0 / 3.0, 1e-9][dice.below(4)];
    (pair.0.iter().map(|p| p * scale).collect(), pair.1.iter().map(|p| p * scale).collect())
}

fn one_ulp_from_touch(dice: &mut Dice) -> Pair {
    let (a, mut b) = exact_touch(dice);
    let up = dice.below(2) == 0;
    let nudge = |v: f64| if up { v.next_up() } else { v.next_down() };
    for p in &mut b {
        if p.z != 0.0 {
            p.z = nudge(p.z);
        }
    }
    (a, b)
}

fn any_basic(dice: &mut Dice) -> Pair {
    let basic: [fn(&mut Dice) -> Pair; 6] =
        [random_bodies, near_touch, small_integers, exact_touch, one_ulp_from_touch, low_dimension];
    basic[dice.below(6)](dice)
}

fn scaled(dice: &mut Dice) -> Pair {
    let (a, b) = any_basic(dice);
    let factor = if dice.below(2) == 0 { libm::exp2(dice.integer(60)) } else { dice.decade(-9.0, 9.0) };
    (a.iter().map(|p| p * factor).collect(), b.iter().map(|p| p * factor).collect())
}

fn far_from_the_origin(dice: &mut Dice) -> Pair {
    let (a, b) = any_basic(dice);
    let by = dice.direction() * dice.decade(3.0, 14.0);
    (moved(&a, &by), moved(&b, &by))
}

fn needles_and_plates(dice: &mut Dice) -> Pair {
    let (a, b) = if dice.below(2) == 0 { near_touch(dice) } else { random_bodies(dice) };
    let thin = Vec3::new(1.0, dice.decade(-6.0, 0.0), dice.decade(-6.0, 0.0));
    (a.iter().map(|p| p.component_mul(&thin)).collect(), b.iter().map(|p| p.component_mul(&thin)).collect())
}

/// A point, a segment, a polygon or a solid, with repeated points.
fn low_dimension(dice: &mut Dice) -> Pair {
    let rational = dice.below(2) == 0;
    let vector = |dice: &mut Dice| if rational { dice.integers(3) } else { dice.vector() };
    let body = |dice: &mut Dice| -> Vec<Vec3> {
        let (o, u, v) = (vector(dice), vector(dice), vector(dice));
        let mut points: Vec<Vec3> = match dice.below(4) {
            0 => vec![o],
            1 => (0..2 + dice.below(3)).map(|_| o + u * dice.integer(2)).collect(),
            2 => (0..3 + dice.below(4)).map(|_| o + u * dice.integer(2) + v * dice.integer(2)).collect(),
            _ => (0..4 + dice.below(4)).map(|_| vector(dice)).collect(),
        };
        let again = points[dice.below(points.len())];
        points.extend((0..dice.below(3)).map(|_| again));
        points
    };
    (body(dice), body(dice))
}

fn tiny_and_huge(dice: &mut Dice) -> Pair {
    let (a, small) = (dice.body(20, 1.0), dice.decade(-8.0, -3.0));
    let b = dice.body(20, small);
    let normal = dice.direction();
    let gap = small * dice.signed() * dice.decade(-12.0, 0.0);
    (a.clone(), at_gap(&a, &b, &normal, gap))
}

fn box_at(corner: &Vec3, size: &Vec3) -> Vec<Vec3> {
    (0..8)
        .map(|i| corner + Vec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)).component_mul(size))
        .collect()
}

fn lattice_boxes(dice: &mut Dice) -> Pair {
    let step = [1.0, 0.5, 0.1, 0.3][dice.below(4)];
    let mut one = || {
        let size = Vec3::new(1.0 + dice.below(3) as f64, 1.0 + dice.below(3) as f64, 1.0 + dice.below(3) as f64);
        box_at(&(dice.integers(3) * step), &(size * step))
    };
    (one(), one())
}

/// B = 2p - A for a vertex, an edge's middle, or any p; and A itself, moved or not.
fn reflected(dice: &mut Dice) -> Pair {
    let whole = dice.below(2) == 0;
    let n = 4 + dice.below(12);
    let a: Vec<Vec3> = if whole { (0..n).map(|_| dice.integers(4)).collect() } else { dice.body(n, 1.0) };
    let (p, q) = (a[dice.below(n)], a[dice.below(n)]);
    let centre = [p, (p + q) * 0.5, dice.vector(), Vec3::zeros()][dice.below(4)];
    let b = if dice.below(3) == 0 { moved(&a, &(p - q)) } else { a.iter().map(|v| centre * 2.0 - v).collect() };
    (a, b)
}

fn regular_solids(dice: &mut Dice) -> Pair {
    let golden = 1.618_033_988_749_895;
    let octahedron = [Vec3::x(), -Vec3::x(), Vec3::y(), -Vec3::y(), Vec3::z(), -Vec3::z()];
    let mut icosahedron = Vec::new();
    for i in 0..3 {
        for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut p = Vec3::zeros();
            p[i] = s;
            p[(i + 1) % 3] = t * golden;
            icosahedron.push(p);
        }
    }
    let truncated: Vec<Vec3> = (0..48u32)
        .map(|i| {
            let sign = |k: u32| if i >> k & 1 == 0 { 1.0 } else { -1.0 };
            let (j, swap) = ((i >> 2) as usize % 3, i >= 24);
            let mut p = Vec3::zeros();
            p[j] = sign(0);
            p[(j + if swap { 2 } else { 1 }) % 3] = 2.0 * sign(1);
            p
        })
        .collect();
    let solids = [octahedron.to_vec(), icosahedron, truncated, box_at(&Vec3::repeat(-1.0), &Vec3::repeat(2.0))];
    let (a, b) = (&solids[dice.below(4)], &solids[dice.below(4)]);
    let pick = |dice: &mut Dice, s: &[Vec3]| s[dice.below(s.len())];
    let shift = pick(dice, a) - pick(dice, b) * [1.0, 1.0, 0.5][dice.below(3)];
    (a.clone(), moved(b, &shift))
}

fn contained(dice: &mut Dice) -> Pair {
    let (a, factor) = (dice.body(25, 1.0), dice.decade(-6.0, -0.5));
    let b = a.iter().map(|p| p * factor).collect();
    if dice.below(2) == 0 { (a, b) } else { (b, a) }
}

fn thin_boxes(dice: &mut Dice) -> Pair {
    let thickness = dice.decade(-8.0, -1.0);
    let a = box_at(&Vec3::new(-1.0, -1.0, -thickness), &Vec3::new(2.0, 2.0, thickness));
    let gap = [0.0, dice.decade(-17.0, -8.0), -dice.decade(-17.0, -8.0)][dice.below(3)];
    let b = box_at(&Vec3::new(dice.signed(), dice.signed(), gap), &Vec3::new(2.0, 2.0, thickness));
    let turn = nalgebra::UnitQuaternion::from_scaled_axis(dice.vector() * 3.0);
    let turned = dice.below(2) == 0;
    let place = |p: &Vec3| if turned { turn * p } else { *p };
    (a.iter().map(place).collect(), b.iter().map(place).collect())
}

fn nearly_coplanar(dice: &mut Dice) -> Pair {
    let (height, gap) = (dice.decade(-15.0, -4.0), dice.decade(-16.0, -3.0));
    let mut sheet = |z: f64| -> Vec<Vec3> {
        (0..8).map(|_| Vec3::new(dice.signed(), dice.signed(), z + height * dice.signed())).collect()
    };
    (sheet(0.0), sheet(gap))
}

fn mixed_magnitudes(dice: &mut Dice) -> Pair {
    let reach = 1.0 + 59.0 * dice.unit();
    let mut coordinate = || if dice.below(5) == 0 { 0.0 } else { dice.signed() * dice.decade(-reach, reach) };
    let mut accepted =
        move || Some(coordinate()).filter(|v| *v == 0.0 || (1e-60..1e60).contains(&v.abs())).unwrap_or(1.0);
    let mut body = |n: usize| -> Vec<Vec3> { (0..n).map(|_| Vec3::new(accepted(), accepted(), accepted())).collect() };
    (body(5), body(7))
}

fn extreme_magnitudes(dice: &mut Dice) -> Pair {
    let (a, b) = any_basic(dice);
    let factor = if dice.below(2) == 0 { 1e58 } else { 1e-50 };
    let keep = |p: &Vec3| p.map(|v| if (v * factor).abs() < 1e-60 { 0.0 } else { v * factor });
    (a.iter().map(keep).collect(), b.iter().map(keep).collect())
}

fn fine_spheres(dice: &mut Dice) -> Pair {
    let (a, b) = (dice.body(200, 1.0), dice.body(150, 1.0));
    let (v, gap) = (dice.direction(), dice.decade(-14.0, -1.0) * dice.signed());
    (a.clone(), at_gap(&a, &b, &v, gap))
}
