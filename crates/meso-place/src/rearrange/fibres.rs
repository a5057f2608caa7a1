//! Fibres among the moving bodies: their contacts lie far from their centres.
//!
//! Moved apart along their centres, a fibre that pierces a grain would be drawn out along its own axis, by up to half
//! its length. Moved apart from the nearest point of its axis, it is pushed aside.

use super::contact::{V, add_scaled, dot};
use meso_concrete::aggregate::Grain;
use meso_concrete::aggregate::Kind;

/// From the centre of every fibre to its end, before it is turned, mm; zero for all else, empty without fibres.
pub(super) fn axes<'a>(grains: impl Iterator<Item = &'a Grain> + Clone) -> Vec<V> {
    let axis = |grain: &Grain| match grain.kind {
        Kind::Fibre => grain.half_length().map(|x| x as f32).into(),
        Kind::Aggregate | Kind::Void => [0.0; 3],
    };
    if grains.clone().any(|grain| grain.kind == Kind::Fibre) { grains.map(axis).collect() } else { Vec::new() }
}

/// Factor by which a fibre counts more than its volume, as mass and as crowding: grains must yield to it. A 75 mm
/// cube at 0.50 with 1 % of fibres of 0.5 x 30 mm (factor 20 here) jammed with a factor of 1, a third of the fibres
/// left out. With 10, 20 and 40 it took 361, 265 and 241 sweeps; with 100 it jammed. It also jammed with 20 for the
/// mass and none for the crowding, which sets the momentum.
pub(super) fn weight(grain: &Grain) -> f64 {
    match grain.kind {
        Kind::Fibre => (SLENDER * f64::from(grain.outer_radius) / f64::from(grain.inner_radius)).max(1.0),
        Kind::Aggregate | Kind::Void => 1.0,
    }
}

const SLENDER: f64 = 1.0 / 3.0;

/// Moment of inertia for a mass: of a hollow ball of the same volume; of two halves at the ends of a fibre (153 sweeps
/// where that of a rod, a third of it, took 265).
pub(super) fn inertia(grain: &Grain, mass: f64) -> f64 {
    let (ball_radius, outer_radius) = (grain.ball_radius(), f64::from(grain.outer_radius));
    match grain.kind {
        Kind::Fibre => mass * outer_radius * outer_radius,
        Kind::Aggregate | Kind::Void => 0.8 * mass * ball_radius * ball_radius,
    }
}

/// Vector between the nearest points of two axes, from the one through the origin to the one through `x`. Each axis
/// extends by `p` or `q` to both sides of its middle (C. Ericson, Real-Time Collision Detection, 2005, Sec. 5.1.9).
pub(super) fn between_axes(p: V, q: V, x: V) -> V {
    let (pp, qq, pq) = (dot(p, p), dot(q, q), dot(p, q));
    let (px, qx) = (dot(p, x), dot(q, x));
    let ratio = |above: f32, below: f32| if below > 0.0 { (above / below).clamp(-1.0, 1.0) } else { 0.0 };
    // Where both are lines: s p - t q - x is least. Parallel ones have many such points; the middle is one of them.
    let s = ratio(px * qq - qx * pq, pp * qq - pq * pq);
    let t = ratio(s * pq - qx, qq);
    let s = ratio(px + t * pq, pp);
    add_scaled(add_scaled(x, q, t), p, -s)
}

#[cfg(test)]
mod tests {
    use super::*;
    use meso_collision::math::Vec3;
    use meso_concrete::aggregate::random::{Draw, Stream};

    #[test]
    fn no_points_of_two_axes_are_nearer_than_those_found() {
        let mut stream = Stream::new(1, Draw::Sample, 0, 0);
        let mut inside = 0;
        for _ in 0..2000 {
            let [p, q, x] = [3.0, 2.0, 3.0].map(|long| stream.direction() * long);
            let narrow = |v: Vec3| -> V { [v.x as f32, v.y as f32, v.z as f32] };
            let found = between_axes(narrow(p), narrow(q), narrow(x));
            let found = Vec3::from_fn(|i, _| f64::from(found[i])).norm();
            let steps = || (-20..=20).map(|k| f64::from(k) / 20.0);
            let least = steps().flat_map(|s| steps().map(move |t| (x + q * t - p * s).norm())).fold(f64::MAX, f64::min);
            assert!(found < least + 1e-4, "{found} {least}");
            assert!(found > least - 0.2, "{found} is less than any pair of points allows, {least}");
            inside += u32::from(found < x.norm() - 0.5);
        }
        assert!(inside > 200, "axes that pass each other are among them: {inside}");
    }

    #[test]
    fn bodies_without_axes_are_apart_from_centre_to_centre() {
        let x = [0.3, -0.0, 7.1];
        assert_eq!(between_axes([0.0; 3], [0.0; 3], x).map(f32::to_bits), x.map(|x| (x + 0.0).to_bits()));
    }
}
