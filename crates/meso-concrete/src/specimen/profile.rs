//! Plates of one thickness between two lines over their length: the surfaces of notched prisms and dog-bones.

use super::container::Surface;
use meso_collision::math::Vec3;
use std::collections::BTreeMap;

/// The lower and the upper line at `x`; two stations at the same `x` are a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Station {
    pub(super) x: f64,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Corners in the plane of the profile by their coordinates' bits, in the order in which they were met.
#[derive(Default)]
struct Corners {
    known: BTreeMap<[u64; 2], u32>,
    points: Vec<[f64; 2]>,
}

impl Corners {
    fn index(&mut self, point: [f64; 2]) -> u32 {
        *self.known.entry(point.map(f64::to_bits)).or_insert_with(|| {
            self.points.push(point);
            self.points.len() as u32 - 1
        })
    }
}

/// The surface between `stations`, `thickness` mm thick: the profile's plane is x and y and the thickness along z, or,
/// `upright`, x and z with the thickness along y.
pub(super) fn surface(stations: &[Station], thickness: f64, upright: bool) -> Surface {
    let mut corners = Corners::default();
    let columns: Vec<Vec<u32>> = columns(stations, &mut corners);
    let count = corners.points.len() as u32;
    let top = |column: &Vec<u32>| column.iter().map(|i| i + count).collect::<Vec<u32>>();
    let mut faces: Vec<Vec<u32>> = columns.iter().map(|column| column.iter().rev().copied().collect()).collect();
    faces.extend(columns.iter().map(top));
    faces.extend(rim(&columns).map(|(a, b)| vec![a, b, b + count, a + count]));
    if upright {
        faces.iter_mut().for_each(|face| face.reverse());
    }
    let point = |&[u, v]: &[f64; 2], w: f64| if upright { Vec3::new(u, w, v) } else { Vec3::new(u, v, w) };
    let layer = |w: f64| corners.points.iter().map(move |corner| point(corner, w));
    Surface { points: layer(0.0).chain(layer(thickness)).collect(), faces }
}

/// The trapezoids between the stations, counter-clockwise, with the corners that a step beside them has on their sides.
fn columns(stations: &[Station], corners: &mut Corners) -> Vec<Vec<u32>> {
    let pairs = stations.windows(2).enumerate().filter(|(_, pair)| pair[0].x < pair[1].x);
    let column = |(i, pair): (usize, &[Station])| {
        let (left, right) = (pair[0], pair[1]);
        let mut side = |own: Station, beside: Option<&Station>| {
            let step = beside.filter(|beside| beside.x == own.x).map_or([own.low; 2], |b| [b.low, b.high]);
            let mut heights = vec![own.low];
            heights.extend(step.into_iter().filter(|y| *y > own.low && *y < own.high));
            heights.push(own.high);
            heights.into_iter().map(|y| corners.index([own.x, y])).collect::<Vec<u32>>()
        };
        let (up, down) = (side(right, stations.get(i + 2)), side(left, i.checked_sub(1).map(|k| &stations[k])));
        up.into_iter().chain(down.into_iter().rev()).collect()
    };
    pairs.map(column).collect()
}

/// The edges that only one column has.
fn rim(columns: &[Vec<u32>]) -> impl Iterator<Item = (u32, u32)> {
    let edges = |column: &Vec<u32>| {
        let next = column.iter().cycle().skip(1);
        column.iter().copied().zip(next.copied()).collect::<Vec<_>>()
    };
    let all: Vec<(u32, u32)> = columns.iter().flat_map(edges).collect();
    let mut sorted = all.clone();
    sorted.sort_unstable();
    all.into_iter().filter(move |&(a, b)| sorted.binary_search(&(b, a)).is_err())
}
