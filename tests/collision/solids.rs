//! Point sets that hulls, offsets and collision tests get wrong elsewhere, in named families.

use crate::dice::Dice;
use meso_collision::math::Vec3;

/// A named point set.
pub(crate) struct Cloud {
    pub(crate) name: String,
    pub(crate) points: Vec<Vec3>,
}

fn cloud(name: impl Into<String>, points: Vec<Vec3>) -> Cloud {
    Cloud { name: name.into(), points }
}

fn vectors(rows: &[[f64; 3]]) -> Vec<Vec3> {
    rows.iter().map(|row| Vec3::from(*row)).collect()
}

/// The corners of a box around the origin.
pub(crate) fn block(half: [f64; 3]) -> Vec<Vec3> {
    (0..8).map(|i| Vec3::from([0, 1, 2].map(|k| if i >> k & 1 == 1 { half[k] } else { -half[k] }))).collect()
}

/// Every solid family; `size` sets of each random kind.
pub(crate) fn solids(size: usize) -> Vec<Cloud> {
    let mut dice = Dice::new(20);
    let mut all = Vec::new();
    all.extend(paper(&mut dice, size));
    all.extend(lattices(&mut dice, size));
    all.extend(duplicates(&mut dice, size));
    all.extend(coplanar(&mut dice));
    all.extend(near_flat(&mut dice, size));
    all.extend(scaled(&mut dice, size));
    all.extend(spheres(&mut dice));
    all.extend(issues());
    all
}

pub(crate) fn paper(dice: &mut Dice, size: usize) -> Vec<Cloud> {
    (0..size).map(|k| cloud(format!("paper {k}"), dice.grain(4 + k % 27))).collect()
}

pub(crate) fn lattices(dice: &mut Dice, size: usize) -> Vec<Cloud> {
    let lattice = |k: usize| {
        let mut points = dice.lattice(8 + k % 25, 2 + k % 5);
        points.extend(vectors(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]));
        cloud(format!("lattice {k}"), points)
    };
    (0..size).map(lattice).collect()
}

pub(crate) fn duplicates(dice: &mut Dice, size: usize) -> Vec<Cloud> {
    (0..size)
        .map(|k| {
            let mut points = if k % 2 == 0 { dice.grain(6 + k % 20) } else { dice.lattice(10, 3) };
            points.extend(block([0.5, 0.75, 0.25]));
            for _ in 0..1 + k % 20 {
                points.push(points[dice.below(points.len())]);
            }
            dice.shuffle(&mut points);
            cloud(format!("duplicates {k}"), points)
        })
        .collect()
}

/// Many points in few planes: prisms, pyramids, boxes with points in faces and edges; some turned exactly.
pub(crate) fn coplanar(dice: &mut Dice) -> Vec<Cloud> {
    let mut all = Vec::new();
    for n in [3, 4, 5, 8, 12, 24, 60, 240] {
        let ring = |z: f64, radius: f64| -> Vec<Vec3> {
            let at = |k: usize| libm::sincos(std::f64::consts::TAU * k as f64 / n as f64);
            (0..n).map(|k| Vec3::new(radius * at(k).1, radius * at(k).0, z)).collect()
        };
        all.push(cloud(format!("prism {n}"), [ring(-1.0, 1.0), ring(1.0, 1.0)].concat()));
        all.push(cloud(format!("frustum {n}"), [ring(-1.0, 2.0), ring(1.0, 1.0)].concat()));
        all.push(cloud(format!("pyramid {n}"), [ring(0.0, 1.0), vectors(&[[0.1, 0.0, 1.0]])].concat()));
        all.push(cloud(
            format!("bipyramid {n}"),
            [ring(0.0, 1.0), vectors(&[[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])].concat(),
        ));
    }
    for k in 0..12 {
        let mut points = block([2.0, 3.0, 4.0]);
        for _ in 0..4 * k {
            let mut p = [dice.below(5) as f64 - 2.0, dice.below(7) as f64 - 3.0, dice.below(9) as f64 - 4.0];
            let axis = dice.below(3);
            p[axis] = [2.0, 3.0, 4.0][axis] * if dice.below(2) == 0 { 1.0 } else { -1.0 };
            points.push(p.into());
        }
        // A rotation by the quaternion (1, 2, 3, k) without its denominator keeps integers integers.
        let (w, x, y, z) = (1.0, 2.0, 3.0, k as f64);
        let turn = nalgebra::Matrix3::new(
            w * w + x * x - y * y - z * z,
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
            2.0 * (x * y + w * z),
            w * w - x * x + y * y - z * z,
            2.0 * (y * z - w * x),
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            w * w - x * x - y * y + z * z,
        );
        all.push(cloud(format!("turned box {k}"), points.iter().map(|p| turn * p).collect()));
        all.push(cloud(format!("box with points in its faces {k}"), points));
    }
    all
}

/// Plates from 1e-4 to 1e-15 of their width, level and tilted.
pub(crate) fn near_flat(dice: &mut Dice, size: usize) -> Vec<Cloud> {
    (0..size)
        .map(|k| {
            let thickness = libm::exp10(-4.0 - (k % 12) as f64);
            let turn = dice.rotation();
            let points: Vec<Vec3> = (0..10 + k % 20)
                .map(|_| Vec3::new(dice.signed(), dice.signed(), thickness * dice.signed()))
                .map(|p| if k % 2 == 0 { p } else { turn * p })
                .collect();
            cloud(format!("plate {k} of thickness {thickness:e}"), points)
        })
        .collect()
}

/// Sizes from 1e-57 to 1e57, and bodies up to 1e8 sizes from the origin.
pub(crate) fn scaled(dice: &mut Dice, size: usize) -> Vec<Cloud> {
    (0..size)
        .map(|k| {
            let grain = dice.grain(8 + k % 20);
            if k % 2 == 0 {
                let scale = libm::exp10([-50.0, -23.0, -9.0, -3.0, 3.0, 9.0, 23.0, 57.0][k / 2 % 8]);
                cloud(format!("grain times {scale:e}"), grain.iter().map(|p| p * scale).collect())
            } else {
                let away = dice.direction() * libm::exp10((2 + k / 2 % 8) as f64);
                cloud(format!("grain {k} at {:e}", away.norm()), grain.iter().map(|p| p + away).collect())
            }
        })
        .collect()
}

pub(crate) fn spheres(dice: &mut Dice) -> Vec<Cloud> {
    let mut all = Vec::new();
    for n in [50, 150, 400] {
        all.push(cloud(format!("random sphere {n}"), (0..n).map(|_| dice.direction()).collect()));
    }
    for n in [4, 8, 12] {
        let at = |i: usize, j: usize| {
            let (sin, cos) = libm::sincos(std::f64::consts::PI * i as f64 / n as f64);
            let (y, x) = libm::sincos(std::f64::consts::PI * j as f64 / n as f64);
            Vec3::new(sin * x, sin * y, cos)
        };
        all.push(cloud(
            format!("globe {n}"),
            (0..=n).flat_map(|i| (0..2 * n).map(move |j| (i, j))).map(|(i, j)| at(i, j)).collect(),
        ));
    }
    all
}

/// Inputs that broke published hull codes.
pub(crate) fn issues() -> Vec<Cloud> {
    let tiny = vectors(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let nearly_collinear = vectors(&[
        [103.05024, 303.44974, 106.125],
        [103.21692, 303.44974, 106.125015],
        [104.16538, 303.44974, 106.125],
        [106.55025, 303.44974, 106.125],
        [106.55043, 303.44974, 106.125],
        [104.0, 303.449_740_000_1, 106.125],
    ]);
    let angstrom = block([0.5e-10; 3]);
    let boxes = (0..9).flat_map(|k| {
        let shift = Vec3::new(f64::from(k % 3), f64::from(k / 3), 0.0);
        block([0.5; 3]).into_iter().map(move |p| p + shift)
    });
    let needle =
        vectors(&[[0.0, 0.0, 0.0], [200.0, 0.0, 0.0], [100.0, 0.03, 0.0], [100.0, 0.0, 1e-9], [50.0, 1e-7, 1e-8]]);
    let mixed =
        vectors(&[[1e60, 0.0, 0.0], [0.0, 1e60, 1e-60], [1e-60, 1e-60, 1e-60], [0.0, 0.0, 1e60], [-1e-60, 1.0, 1e30]]);
    vec![
        cloud("a simplex of 1e-23", tiny.iter().map(|p| p * 1e-23).collect()),
        cloud("nearly collinear", nearly_collinear),
        cloud("a cube of one Angstrom", angstrom),
        cloud("nine boxes on a grid", boxes.collect()),
        cloud("a needle", needle),
        cloud("magnitudes from 1e-60 to 1e60", mixed),
        cloud("one ulp above a plane", one_ulp_above_a_plane()),
        cloud("cylinder plus sphere", cylinder_plus_sphere()),
    ]
}

fn one_ulp_above_a_plane() -> Vec<Vec3> {
    let mut points = Vec::new();
    for i in 0..5 {
        for j in 0..5 {
            points.push(Vec3::new(f64::from(i), f64::from(j), f64::from(i + j) / 3.0));
        }
    }
    points[12].z = points[12].z.next_up();
    points.push(Vec3::new(2.0, 2.0, -7.0));
    points
}

/// Vertex sums of a coarse cylinder and a coarse sphere: large clusters that are coplanar or nearly so.
fn cylinder_plus_sphere() -> Vec<Vec3> {
    let circle = |k: usize| libm::sincos(std::f64::consts::FRAC_PI_4 * k as f64);
    let cylinder = (0..16).map(|k| Vec3::new(circle(k % 8).0, circle(k % 8).1, (k / 8) as f64));
    cylinder
        .flat_map(|p| (0..8).flat_map(move |i| (0..5).map(move |j| (p, i, j))))
        .map(|(p, i, j)| p + 0.3 * Vec3::new(circle(j).0 * circle(i).0, circle(j).0 * circle(i).1, circle(j).1))
        .collect()
}

/// A random set of one of the kinds that are hard to decide: lattices nudged by ulps, points nearly in planes or on
/// lines, magnitudes from 1e-60 to 1e60, few planes, repeated and reflected points.
pub(crate) fn hard(dice: &mut Dice, kind: usize) -> Cloud {
    let n = 5 + dice.below(20);
    let mut points = dice.lattice(n, 2 + kind % 4);
    match kind % 7 {
        0 => points.iter_mut().for_each(|p| *p = p.map(|x| nudged(dice, x))),
        1 => points.iter_mut().for_each(|p| *p = p.map(|x| nudged(dice, x / 3.0 + 100.0))),
        2 => points.iter_mut().for_each(|p| p.z = nudged(dice, (p.x + 2.0 * p.y) / 7.0)),
        3 => points.iter_mut().for_each(|p| *p = p.map(|_| wild(dice))),
        4 => {
            let turn = dice.rotation();
            points.iter_mut().for_each(|p| *p = turn * *p);
        }
        5 => {
            let center = points[0] * 2.0;
            points.extend(points.clone().iter().map(|p| center - p));
        }
        _ => {
            let along = dice.direction();
            points.iter_mut().for_each(|p| *p = along * p.x + along.yzx() * (p.y * 1e-9) + along.zxy() * (p.z * 1e-12));
        }
    }
    cloud(format!("hard {kind}"), points)
}

fn nudged(dice: &mut Dice, x: f64) -> f64 {
    match dice.below(4) {
        0 if x != 0.0 => x.next_up(),
        1 if x != 0.0 => x.next_down(),
        _ => x,
    }
}

fn wild(dice: &mut Dice) -> f64 {
    let magnitude = libm::exp10(120.0 * dice.unit() - 60.0).clamp(1e-60, 1e60);
    [0.0, magnitude, -magnitude][dice.below(3)]
}

/// Sets of fewer than three dimensions, each with its dimension.
pub(crate) fn lower_dimensional() -> Vec<(u8, Cloud)> {
    let mut dice = Dice::new(21);
    let mut all = Vec::new();
    for k in 0..40 {
        // Steps in integers times a power of two: sums are exact, and so is the dimension.
        let mut step = || Vec3::from([(); 3].map(|()| dice.below(2001) as f64 - 1000.0)) + Vec3::new(0.0, 0.0, 1500.0);
        let (origin, u, v) = (step(), step(), step().xzy().component_mul(&Vec3::new(1.0, -1.0, 3.0)));
        let scale = libm::scalbn(1.0, 13 * (k % 20) - 130);
        let n = 1 + k as usize % 30;
        let mut set = |dimension: u8| -> Vec<Vec3> {
            let mut coefficient = |on: bool| if on { dice.below(200) as f64 } else { 0.0 };
            let mut points: Vec<Vec3> = (0..n)
                .map(|_| (origin + u * coefficient(dimension > 0) + v * coefficient(dimension > 1)) * scale)
                .collect();
            points.push(origin * scale);
            points.extend((dimension > 0).then(|| (origin + u) * scale));
            points.extend((dimension > 1).then(|| (origin + v) * scale));
            points
        };
        for dimension in 0..3 {
            all.push((dimension, cloud(format!("dimension {dimension}, set {k}"), set(dimension))));
        }
    }
    all
}
