//! Bodies with dents, against a reference in whole numbers that compares every edge with every triangle.

use crate::dice::Dice;
use meso_collision::dents::SelfCrossing;
use meso_collision::geometry::{BodyForm, Polyhedron, TriangleMesh, Triangles, convex_hull};
use meso_collision::math::Vec3;

type Point = [i128; 3];

/// A closed surface whose corners are whole numbers.
#[derive(Clone)]
struct Whole {
    corners: Vec<[Point; 3]>,
    body: Polyhedron,
}

impl Whole {
    /// The surface with its corners rounded; `None` where that folds it.
    fn rounded(mesh: &TriangleMesh) -> Option<Self> {
        let vertices: Vec<Vec3> = mesh.vertices.iter().map(|v| v.map(f64::round)).collect();
        let mesh = TriangleMesh { vertices, triangles: mesh.triangles.clone() };
        let facets = Triangles::new(corners(&mesh));
        let is_sound = mesh.check_closed().is_ok() && SelfCrossing { mesh: &mesh, facets: &facets }.find().is_none();
        let whole = |v: Vec3| -> Point { [v.x as i128, v.y as i128, v.z as i128] };
        let all = corners(&mesh).into_iter().map(|t| t.map(whole)).collect();
        is_sound.then(|| Self { corners: all, body: Polyhedron::of_surface(&mesh) })
    }

    fn moved(&self, by: Point) -> Self {
        let shift = Vec3::new(by[0] as f64, by[1] as f64, by[2] as f64);
        let corners = self.corners.iter().map(|t| t.map(|p| plus(p, by))).collect();
        Self { corners, body: self.body.translated(&shift) }
    }
}

fn corners(mesh: &TriangleMesh) -> Vec<[Vec3; 3]> {
    mesh.triangles.iter().map(|t| t.map(|i| mesh.vertices[i as usize])).collect()
}

fn plus(p: Point, q: Point) -> Point {
    [0, 1, 2].map(|i| p[i] + q[i])
}

fn minus(p: Point, q: Point) -> Point {
    [0, 1, 2].map(|i| p[i] - q[i])
}

/// Six volumes of the tetrahedron.
fn side([a, b, c]: &[Point; 3], p: Point) -> i128 {
    let [u, v, w] = [minus(*b, *a), minus(*c, *a), minus(p, *a)];
    (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] + (u[0] * v[1] - u[1] * v[0]) * w[2]
}

/// Twice the area of a triangle seen along an axis.
fn turn(axis: usize, a: Point, b: Point, c: Point) -> i128 {
    let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
    (b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i])
}

/// Does a closed segment meet a closed triangle?
fn pierces(from: Point, to: Point, t: &[Point; 3]) -> bool {
    let (p, q) = (side(t, from), side(t, to));
    if p.signum() * q.signum() > 0 {
        return false;
    }
    if p == 0 && q == 0 {
        return meets_in_plane(from, to, t);
    }
    let [a, b, c] = *t;
    let around = [(a, b), (b, c), (c, a)].map(|(u, v)| side(&[from, to, u], v).signum());
    around.iter().all(|s| *s >= 0) || around.iter().all(|s| *s <= 0)
}

fn meets_in_plane(from: Point, to: Point, t: &[Point; 3]) -> bool {
    let [a, b, c] = *t;
    let axis = (0..3).find(|&axis| turn(axis, a, b, c) != 0).expect("no triangle is flat");
    let holds = |p: Point| {
        let around = [(a, b), (b, c), (c, a)].map(|(u, v)| turn(axis, u, v, p).signum());
        around.iter().all(|s| *s >= 0) || around.iter().all(|s| *s <= 0)
    };
    let within = |p: Point, u: Point, v: Point| (0..3).all(|i| p[i] >= u[i].min(v[i]) && p[i] <= u[i].max(v[i]));
    let crosses = |u: Point, v: Point| {
        let of_own = [turn(axis, from, to, u), turn(axis, from, to, v)].map(i128::signum);
        let of_other = [turn(axis, u, v, from), turn(axis, u, v, to)].map(i128::signum);
        let touches =
            [(of_own[0], u, from, to), (of_own[1], v, from, to), (of_other[0], from, u, v), (of_other[1], to, u, v)];
        of_own[0] * of_own[1] < 0 && of_other[0] * of_other[1] < 0
            || touches.iter().any(|&(s, p, u, v)| s == 0 && within(p, u, v))
    };
    holds(from) || holds(to) || crosses(a, b) || crosses(b, c) || crosses(c, a)
}

fn extent(t: &[Point; 3]) -> [[i128; 2]; 3] {
    [0, 1, 2].map(|i| [t[0][i].min(t[1][i]).min(t[2][i]), t[0][i].max(t[1][i]).max(t[2][i])])
}

fn triangles_meet(p: &[Point; 3], q: &[Point; 3]) -> bool {
    let (own, other) = (extent(p), extent(q));
    if (0..3).any(|i| own[i][1] < other[i][0] || other[i][1] < own[i][0]) {
        return false;
    }
    let edges = |t: &[Point; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
    edges(p).iter().any(|&(u, v)| pierces(u, v, q)) || edges(q).iter().any(|&(u, v)| pierces(u, v, p))
}

/// Is a point that lies on no triangle within the surface? A ray in a direction that meets no edge counts crossings.
fn holds(surface: &Whole, point: Point) -> bool {
    let directions = [[1_000_003, 1_009, 131], [997, 1_000_033, -571], [-1_511, 811, 1_000_037]];
    let count = |direction: Point| -> Option<usize> {
        let to = plus(point, direction);
        let mut crossings = 0;
        for t in &surface.corners {
            let [p, q] = [side(t, point), side(t, to)].map(i128::signum);
            if p == 0 && q == 0 {
                return None;
            }
            let [a, b, c] = *t;
            let around = [(a, b), (b, c), (c, a)].map(|(u, v)| side(&[point, to, u], v).signum());
            let is_through = around.iter().all(|s| *s > 0) || around.iter().all(|s| *s < 0);
            let is_beside = around.contains(&1) && around.contains(&-1);
            match (is_through, is_beside) {
                (true, _) => crossings += usize::from(p * q <= 0),
                (_, true) => {}
                _ => return None,
            }
        }
        Some(crossings)
    };
    directions.iter().find_map(|direction| count(*direction)).expect("a direction that meets no edge") % 2 == 1
}

/// Do the closed bodies share a point?
fn meet(a: &Whole, b: &Whole) -> bool {
    a.corners.iter().any(|p| b.corners.iter().any(|q| triangles_meet(p, q)))
        || holds(a, b.corners[0][0])
        || holds(b, a.corners[0][0])
}

/// The surface of cubes of this edge.
fn cubes(cells: &[[i32; 3]], edge: f64) -> TriangleMesh {
    let mut corners = Vec::new();
    for cell in cells {
        for (axis, step) in (0..3).flat_map(|axis| [(axis, 1), (axis, -1)]) {
            let mut beyond = *cell;
            beyond[axis] += step;
            if cells.contains(&beyond) {
                continue;
            }
            let at = |i: i32, j: i32| {
                let mut corner = cell.map(f64::from);
                corner[axis] += f64::from((step + 1) / 2);
                corner[(axis + 1) % 3] += f64::from(i);
                corner[(axis + 2) % 3] += f64::from(j);
                Vec3::from(corner) * edge
            };
            let square = if step > 0 {
                [at(0, 0), at(1, 0), at(1, 1), at(0, 1)]
            } else {
                [at(0, 0), at(0, 1), at(1, 1), at(1, 0)]
            };
            corners.extend([square[0], square[1], square[2], square[0], square[2], square[3]]);
        }
    }
    TriangleMesh::welded(&corners)
}

/// A ring about the z axis.
fn ring(radius: f64, tube: f64, around: usize, about: usize) -> TriangleMesh {
    let at = |i: usize, j: usize| {
        let [u, v] =
            [(i % around, around), (j % about, about)].map(|(k, n)| std::f64::consts::TAU * k as f64 / n as f64);
        let reach = radius + tube * libm::cos(v);
        Vec3::new(reach * libm::cos(u), reach * libm::sin(u), tube * libm::sin(v))
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [a, b, c, a, c, d]
    };
    let all: Vec<Vec3> = (0..around).flat_map(|i| (0..about).flat_map(move |j| square(i, j))).collect();
    TriangleMesh::welded(&all)
}

/// A ball whose radius goes up and down.
fn stone(radius: f64, depth: f64, dice: &mut Dice) -> TriangleMesh {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let directions: Vec<Vec3> = (0..50)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 50.0;
            let (r, angle) = ((1.0 - z * z).sqrt(), golden * f64::from(i));
            Vec3::new(r * libm::cos(angle), r * libm::sin(angle), z)
        })
        .collect();
    let waves: Vec<Vec3> = (0..4).map(|_| dice.vector() * 4.0).collect();
    let sphere = convex_hull(&directions).unwrap();
    let wavy = |d: &Vec3| d * radius * (1.0 + depth * waves.iter().map(|w| libm::sin(w.dot(d) + w.x)).sum::<f64>());
    TriangleMesh { vertices: sphere.vertices().iter().map(wavy).collect(), triangles: sphere.triangles().collect() }
}

fn cross() -> Vec<[i32; 3]> {
    let arms = (0..3).flat_map(|axis| [-2, -1, 1, 2].map(|k| std::array::from_fn(|i| if i == axis { k } else { 0 })));
    arms.chain([[0, 0, 0]]).collect()
}

fn horseshoe() -> Vec<[i32; 3]> {
    let square = (-2..=2_i32).flat_map(|i| (-2..=2).map(move |j: i32| [i, j, 0]));
    square.filter(|[i, j, _]| i.abs() == 2 || j.abs() == 2).filter(|[i, j, _]| *j != 2 || i.abs() == 2).collect()
}

fn bowl() -> Vec<[i32; 3]> {
    let block = (-2..=2_i32).flat_map(|i| (-2..=2_i32).flat_map(move |j: i32| (-1..=1).map(move |k| [i, j, k])));
    block.filter(|[i, j, k]| i.abs() == 2 || j.abs() == 2 || *k == -1).collect()
}

fn frame() -> Vec<[i32; 3]> {
    let square = (-2..=2_i32).flat_map(|i| (-2..=2).map(move |j: i32| [i, j, 0]));
    square.filter(|[i, j, _]| i.abs() == 2 || j.abs() == 2).collect()
}

fn turned(mesh: &TriangleMesh, dice: &mut Dice) -> TriangleMesh {
    let turn = dice.rotation();
    TriangleMesh { vertices: mesh.vertices.iter().map(|v| turn * v).collect(), triangles: mesh.triangles.clone() }
}

/// Shapes of about the same size: upright ones whose faces, edges and corners meet often, and turned ones.
fn shapes(dice: &mut Dice) -> Vec<Whole> {
    let blocks = [cross(), horseshoe(), bowl(), frame(), vec![[0, 0, 0]]];
    let mut shapes: Vec<Whole> = blocks.iter().filter_map(|cells| Whole::rounded(&cubes(cells, 2.0))).collect();
    assert_eq!(shapes.len(), 5);
    for cells in &blocks {
        shapes.extend(Whole::rounded(&turned(&cubes(cells, 90.0), dice)));
    }
    for _ in 0..4 {
        shapes.extend(Whole::rounded(&turned(&ring(200.0, 60.0, 10, 6), dice)));
        shapes.extend(Whole::rounded(&stone(150.0, 0.12, dice)));
        shapes.extend(Whole::rounded(&stone(70.0, 0.05, dice)));
    }
    assert!(shapes.len() > 15, "{}", shapes.len());
    shapes
}

fn is_apart(a: &Whole, b: &Whole) -> bool {
    a.body.surface().is_apart(&b.body.surface(), 0.0)
}

#[test]
fn pairs_of_bodies_with_dents_are_judged_as_whole_numbers_judge_them() {
    judge(2_000);
}

#[test]
#[ignore = "slow tier: ten seconds of processor time"]
fn ten_thousand_pairs_of_bodies_with_dents_are_judged_as_whole_numbers_judge_them() {
    judge(10_000);
}

fn judge(pairs: usize) {
    let mut dice = Dice::new(50);
    let shapes = shapes(&mut dice);
    let (mut apart, mut linked) = (0, 0);
    for pair in 0..pairs {
        // Upright ones among themselves touch; others are near each other.
        let (a, b, reach) = if pair % 2 == 0 {
            (&shapes[dice.below(5)], &shapes[dice.below(5)], 9)
        } else {
            (&shapes[5 + dice.below(shapes.len() - 5)], &shapes[5 + dice.below(shapes.len() - 5)], 330)
        };
        let b = b.moved([0; 3].map(|_: i32| dice.integer(reach) as i128));
        let answer = is_apart(a, &b);
        assert_eq!(answer, !meet(a, &b), "pair {pair}");
        assert_eq!(answer, is_apart(&b, a), "pair {pair}");
        apart += usize::from(answer);
        let hulls = [a, &b].map(|it| it.body.hull().unwrap());
        linked +=
            usize::from(answer && meso_collision::gjk::intersects(hulls[0].vertices(), hulls[1].vertices()).unwrap());
    }
    let is_mixed = (pairs * 3 / 10..pairs * 7 / 10).contains(&apart) && linked > pairs / 33;
    assert!(is_mixed, "{apart} apart, {linked} of them within each other's hull");
}

#[test]
fn linked_rings_and_held_balls_are_apart_until_they_touch() {
    let whole = |mesh: &TriangleMesh| Whole::rounded(mesh).unwrap();
    let frame = whole(&cubes(&frame(), 2.0));
    let upright = |mesh: TriangleMesh| TriangleMesh {
        vertices: mesh.vertices.iter().map(|v| Vec3::new(v.x, -v.z, v.y)).collect(),
        ..mesh
    };
    let other = whole(&upright(cubes(&self::frame(), 2.0)));
    // The frame's opening is 6 wide, and the other's bar 2 by 2.
    assert!(is_apart(&frame, &other.moved([5, 2, 1])));
    assert!(!is_apart(&frame, &other.moved([5, 6, 1])));
    let (bowl, horseshoe, cube) =
        (whole(&cubes(&bowl(), 2.0)), whole(&cubes(&horseshoe(), 2.0)), whole(&cubes(&[[0, 0, 0]], 2.0)));
    assert!(is_apart(&bowl, &cube.moved([0, 0, 1])) && !is_apart(&bowl, &cube.moved([0, 0, 0])));
    assert!(is_apart(&horseshoe, &cube) && !is_apart(&horseshoe, &cube.moved([2, 0, 0])));
    // One body within the other: no triangles meet.
    let shell = whole(&cubes(&[[0, 0, 0]], 9.0));
    assert!(!is_apart(&shell, &cube.moved([2, 2, 2])) && !is_apart(&cube.moved([2, 2, 2]), &shell));
}

#[test]
fn gaps_of_bodies_with_dents_are_exact() {
    let whole = |cells: &[[i32; 3]]| Whole::rounded(&cubes(cells, 2.0)).unwrap().body;
    let (bowl, cube) = (whole(&bowl()), whole(&[[0, 0, 0]]).translated(&Vec3::new(0.0, 0.0, 1.0)));
    let [bowl, cube] = [bowl, cube].map(|body| body.surface());
    assert!(bowl.is_apart(&cube, 1.0 - f64::EPSILON) && !bowl.is_apart(&cube, 1.0));
    assert_eq!(bowl.distance_below(&cube, 5.0), 1.0);
}

#[test]
fn rows_depths_and_volumes_of_bodies_with_dents_are_those_of_their_cubes() {
    let cells = bowl();
    let body = Polyhedron::of_surface(&cubes(&cells, 2.0));
    assert!((body.volume() - 8.0 * cells.len() as f64).abs() < 1e-9 && body.form() == BodyForm::Surface);
    let surface = body.surface();
    for (j, k) in (-3..=3).flat_map(|j| (-2..=2).map(move |k| (j, k))) {
        let row = surface.row(2.0 * f64::from(j) + 1.0, 2.0 * f64::from(k) + 1.0);
        let length: f64 = row.iter().map(|[from, to]| to - from).sum();
        assert!((length - 2.0 * cells.iter().filter(|cell| cell[1..] == [j, k]).count() as f64).abs() < 1e-12);
        for i in -4..=4 {
            let middle = Vec3::new(f64::from(i), f64::from(j), f64::from(k)) * 2.0 + Vec3::repeat(1.0);
            assert_eq!(body.contains(&middle), cells.contains(&[i, j, k]));
            assert_eq!(row.iter().any(|[from, to]| (from..to).contains(&&middle.x)), cells.contains(&[i, j, k]));
        }
    }
    let (deepest, depth) = body.skin(0.0).deepest();
    assert!(depth > 1.0 / 1.05 && (surface.depth(&deepest) - depth).abs() < 1e-12, "{depth}");
    assert!(body.inward_offset(0.1).is_err() && body.sieve_size() == body.hull().unwrap().sieve_size());
}
