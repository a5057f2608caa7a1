//! Bodies like the paper's aggregates, in every form that a contestant asks for.

use meso_collision::geometry::{Polyhedron, convex_hull};
use meso_collision::gjk::Body;
use meso_collision::math::{Mat3, Rotation, Vec3};
use parry3d_f64::math::Vector;
use parry3d_f64::shape::ConvexPolyhedron;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// A seeded source of numbers.
pub struct Dice(ChaCha8Rng);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub fn below(&mut self, n: usize) -> usize {
        (self.0.next_u64() % n as u64) as usize
    }

    pub fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Uniform on the sphere.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let v = Vec3::from_fn(|_, _| self.between(-1.0, 1.0));
            if (1e-4..1.0).contains(&v.norm_squared()) {
                return v.normalize();
            }
        }
    }

    /// Uniform among all rotations: four normal variables would do; so does a point in the unit ball of four dimensions.
    pub fn rotation(&mut self) -> Rotation {
        loop {
            let q = nalgebra::Vector4::from_fn(|_, _| self.between(-1.0, 1.0));
            if (1e-4..1.0).contains(&q.norm_squared()) {
                return Rotation::new_normalize(nalgebra::Quaternion::from(q));
            }
        }
    }
}

/// A body and its forms. The frame's origin is the ellipsoid's centre.
pub struct Grain {
    pub points: Vec<Vec3>,
    pub body: Body,
    pub parry: ConvexPolyhedron,
    /// Radius about the origin.
    pub radius: f64,
    pub volume: f64,
}

impl Grain {
    /// Vertices on an ellipsoid of semi-axis 2.5 to 10 mm (log-uniform), a/c at most 2; six of them on the axes.
    pub fn aggregate(dice: &mut Dice) -> Self {
        let a = 2.5 * libm::pow(4.0, dice.unit());
        let extra = dice.below(11);
        let semi_axes = Vec3::new(a, a * dice.between(0.7, 1.0), a * dice.between(0.5, 0.7));
        Self::on_ellipsoid(dice, 20 + extra, &semi_axes)
    }

    /// `n` vertices on an ellipsoid, turned at random.
    pub fn on_ellipsoid(dice: &mut Dice, n: usize, semi_axes: &Vec3) -> Self {
        let turn = dice.rotation().to_rotation_matrix();
        let mut unit: Vec<Vec3> = (0..3).flat_map(|i| [1.0, -1.0].map(|s| Vec3::ith(i, s))).collect();
        unit.extend((6..n).map(|_| dice.direction()));
        let points: Vec<Vec3> = unit.iter().map(|d| turn * d.component_mul(semi_axes)).collect();
        Self::new(points, semi_axes, turn.matrix())
    }

    fn new(points: Vec<Vec3>, semi_axes: &Vec3, turn: &Mat3) -> Self {
        let hull: Polyhedron = convex_hull(&points).expect("a solid");
        let body = Body::on_ellipsoid(&points, semi_axes, turn).with_inside_of(&hull);
        let corners: Vec<Vector> = points.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
        let parry = ConvexPolyhedron::from_convex_hull(&corners).expect("a solid");
        let radius = points.iter().map(Vec3::norm).fold(0.0, f64::max);
        Self { points, body, parry, radius, volume: hull.volume() }
    }
}
