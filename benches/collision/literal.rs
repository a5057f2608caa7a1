//! The paper's Algorithms 1 and 2 as printed, cycles and wrong answers included: a baseline, not for use.
//!
//! `OriginInTetrahedron` is the usual same-side test; "the face closest to the origin" is read as the face whose plane
//! is nearest, of those that have the origin outside. The paper sets no limit of steps: reaching ours is a cycle.

use meso_collision::math::Vec3;

const LIMIT: usize = 1000;

/// What the pseudo-code answers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    Overlap,
    Apart,
    /// It would go on for ever.
    Endless,
}

/// Algorithm 1.
pub fn gjk_intersect(a: &[Vec3], b: &[Vec3], x: &Vec3) -> Outcome {
    let support = |v: &Vec3| extreme(a, v) - extreme(b, &-v) - x;
    let centre = |points: &[Vec3]| points.iter().sum::<Vec3>() / points.len() as f64;
    let p = support(&(centre(b) + x - centre(a)));
    let mut simplex = vec![p];
    let mut v = -p;
    for _ in 0..LIMIT {
        let p = support(&v);
        if p.dot(&v) < 0.0 {
            return Outcome::Apart;
        }
        simplex.push(p);
        if update_simplex(&mut simplex, &mut v) {
            return Outcome::Overlap;
        }
    }
    Outcome::Endless
}

fn extreme(points: &[Vec3], v: &Vec3) -> Vec3 {
    let mut best = (f64::NEG_INFINITY, points[0]);
    for p in points {
        let height = p.dot(v);
        if height > best.0 {
            best = (height, *p);
        }
    }
    best.1
}

/// Algorithm 2.
fn update_simplex(simplex: &mut Vec<Vec3>, v: &mut Vec3) -> bool {
    let a = simplex[simplex.len() - 1];
    let ao = -a;
    match simplex.len() {
        2 => {
            let ab = simplex[0] - a;
            *v = ab.cross(&ao).cross(&ab);
        }
        3 => {
            let normal = (simplex[1] - a).cross(&(simplex[0] - a));
            *v = if normal.dot(&ao) > 0.0 { normal } else { -normal };
        }
        _ => return origin_in_tetrahedron(simplex) || reduce_tetrahedron(simplex, v),
    }
    false
}

/// The faces as corner indices, with the corner opposite.
const FACES: [([usize; 3], usize); 4] = [([0, 1, 2], 3), ([0, 1, 3], 2), ([0, 2, 3], 1), ([1, 2, 3], 0)];

fn origin_in_tetrahedron(s: &[Vec3]) -> bool {
    FACES.iter().all(|([i, j, k], opposite)| {
        let normal = (s[*j] - s[*i]).cross(&(s[*k] - s[*i]));
        normal.dot(&(s[*opposite] - s[*i])) * normal.dot(&-s[*i]) >= 0.0
    })
}

/// Keeps the face closest to the origin and searches along its outward normal.
fn reduce_tetrahedron(simplex: &mut Vec<Vec3>, v: &mut Vec3) -> bool {
    let mut best = (f64::INFINITY, [0; 3], Vec3::zeros());
    for ([i, j, k], opposite) in FACES {
        let normal = (simplex[j] - simplex[i]).cross(&(simplex[k] - simplex[i]));
        let outward = if normal.dot(&(simplex[opposite] - simplex[i])) > 0.0 { -normal } else { normal };
        let height = outward.dot(&-simplex[i]);
        let distance = height / outward.norm();
        if height > 0.0 && distance < best.0 {
            best = (distance, [i, j, k], outward);
        }
    }
    *simplex = best.1.map(|i| simplex[i]).to_vec();
    *v = best.2;
    false
}
