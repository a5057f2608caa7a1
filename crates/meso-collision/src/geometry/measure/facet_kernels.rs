//! Plane and volume kernels over eight triangles at a time; bit-identical to the scalar loop.

use crate::geometry::measure::sum::Sum;
use crate::geometry::measure::tetrahedron::{is_close, six_volumes};
use crate::geometry::plane::{Facet, Plane};
use crate::math::Vec3;
use crate::simd::Wide;

/// Triangles looked at together.
pub(crate) const LANES: usize = 8;
/// A number of each.
type Eight = [f64; LANES];
/// Eights that are filled before the first is looked at: numbers just stored one by one are slow to load together.
pub(crate) const AHEAD: usize = 4;

/// A coordinate of each corner, by axis.
#[derive(Default)]
struct Corner([Eight; 3]);

/// The corners of eight triangles.
#[derive(Default)]
struct Triangles {
    a: Corner,
    b: Corner,
    c: Corner,
}

impl Triangles {
    /// Takes the corners of up to eight; the other lanes keep their values.
    #[inline(always)]
    fn take(&mut self, vertices: &[Vec3], triangles: &[[u8; 3]]) {
        for (lane, &[a, b, c]) in triangles.iter().enumerate() {
            self.a.set(lane, &vertices[usize::from(a)]);
            self.b.set(lane, &vertices[usize::from(b)]);
            self.c.set(lane, &vertices[usize::from(c)]);
        }
    }
}

/// Several eights of triangles.
#[derive(Default)]
struct Eights([Triangles; AHEAD]);

impl Eights {
    /// With the corners of up to as many triangles.
    #[inline(always)]
    fn taken(&mut self, vertices: &[Vec3], triangles: &[[u8; 3]]) -> &[Triangles; AHEAD] {
        for (eight, some) in self.0.iter_mut().zip(triangles.chunks(LANES)) {
            eight.take(vertices, some);
        }
        &self.0
    }
}

impl Corner {
    #[inline(always)]
    fn set(&mut self, lane: usize, vertex: &Vec3) {
        let Self([x, y, z]) = self;
        (x[lane], y[lane], z[lane]) = (vertex.x, vertex.y, vertex.z);
    }

    #[inline(always)]
    fn from(&self, origin: &Self) -> Self {
        let mut difference = Self::default();
        for axis in 0..3 {
            for lane in 0..LANES {
                difference.0[axis][lane] = self.0[axis][lane] - origin.0[axis][lane];
            }
        }
        difference
    }
}

/// The facets of a body of triangles; [`widest`](crate::simd::widest) runs it.
pub(crate) struct Facets<'a> {
    pub(crate) vertices: &'a [Vec3],
    pub(crate) triangles: &'a [[u8; 3]],
}

impl Wide for Facets<'_> {
    type Output = Vec<Facet>;

    #[inline(always)]
    fn run(self) -> Vec<Facet> {
        let mut facets = Vec::with_capacity(self.triangles.len());
        let mut eights = Eights::default();
        for many in self.triangles.chunks(AHEAD * LANES) {
            for (eight, some) in eights.taken(self.vertices, many).iter().zip(many.chunks(LANES)) {
                let (areas, normals, offsets) = eight.planes();
                for lane in 0..some.len() {
                    let normal = Vec3::new(normals[0][lane], normals[1][lane], normals[2][lane]);
                    let plane = Plane { normal, offset: offsets[lane] };
                    facets.push(Facet { plane, area: areas[lane], corners: 3 });
                }
            }
        }
        facets
    }
}

impl Triangles {
    /// Areas, unit normals by axis, and offsets that leave all corners inside.
    #[inline(always)]
    fn planes(&self) -> (Eight, [Eight; 3], Eight) {
        let (Corner([ux, uy, uz]), Corner([vx, vy, vz])) = (self.b.from(&self.a), self.c.from(&self.a));
        let [mut nx, mut ny, mut nz, mut areas, mut offsets] = [[0.0; LANES]; 5];
        for lane in 0..LANES {
            nx[lane] = (uy[lane] * vz[lane] - uz[lane] * vy[lane]) * 0.5;
            ny[lane] = (uz[lane] * vx[lane] - ux[lane] * vz[lane]) * 0.5;
            nz[lane] = (ux[lane] * vy[lane] - uy[lane] * vx[lane]) * 0.5;
        }
        for lane in 0..LANES {
            areas[lane] = (nx[lane] * nx[lane] + ny[lane] * ny[lane] + nz[lane] * nz[lane]).sqrt();
        }
        for normal in [&mut nx, &mut ny, &mut nz] {
            for lane in 0..LANES {
                normal[lane] /= areas[lane];
            }
        }
        for (corner, Corner([x, y, z])) in [&self.a, &self.b, &self.c].into_iter().enumerate() {
            for lane in 0..LANES {
                let along = nx[lane] * x[lane] + ny[lane] * y[lane] + nz[lane] * z[lane];
                offsets[lane] = if corner == 0 || along > offsets[lane] { along } else { offsets[lane] };
            }
        }
        (areas, [nx, ny, nz], offsets)
    }
}

/// The sum of six times the volumes of the tetrahedra from `apex` over the triangles, in their order;
/// [`widest`](crate::simd::widest) runs it.
pub(crate) struct SixVolumes<'a> {
    pub(crate) apex: Vec3,
    pub(crate) vertices: &'a [Vec3],
    pub(crate) triangles: &'a [[u8; 3]],
}

impl Wide for SixVolumes<'_> {
    type Output = Sum;

    #[inline(always)]
    fn run(self) -> Sum {
        let (mut eights, mut sum) = (Eights::default(), Sum::default());
        for many in self.triangles.chunks(AHEAD * LANES) {
            for (eight, some) in eights.taken(self.vertices, many).iter().zip(many.chunks(LANES)) {
                let (terms, magnitudes) = eight.six_volumes(&self.apex);
                for lane in 0..some.len() {
                    sum.add(terms[lane], magnitudes[lane]);
                }
            }
        }
        sum
    }
}

/// The volume of the tetrahedra from `apex` over the triangles, and its moment about the apex;
/// [`widest`](crate::simd::widest) runs it.
pub(crate) struct Moment<'a> {
    pub(crate) apex: Vec3,
    pub(crate) vertices: &'a [Vec3],
    pub(crate) triangles: &'a [[u8; 3]],
}

impl Wide for Moment<'_> {
    type Output = (f64, Vec3);

    #[inline(always)]
    fn run(self) -> (f64, Vec3) {
        let Self { apex, vertices, triangles } = self;
        let (mut eights, mut volume, mut moment) = (Eights::default(), 0.0, Vec3::zeros());
        for many in triangles.chunks(AHEAD * LANES) {
            for (eight, some) in eights.taken(vertices, many).iter().zip(many.chunks(LANES)) {
                let (mut six, magnitudes) = eight.six_volumes(&apex);
                for lane in 0..some.len() {
                    if !is_close(six[lane], magnitudes[lane]) {
                        six[lane] = six_volumes(&apex, &some[lane].map(|i| vertices[usize::from(i)]));
                    }
                }
                let (volumes, moments) = eight.moments(&apex, &six);
                for lane in 0..some.len() {
                    volume += volumes[lane];
                    moment += Vec3::new(moments[0][lane], moments[1][lane], moments[2][lane]);
                }
            }
        }
        (volume, moment)
    }
}

impl Triangles {
    #[inline(always)]
    fn six_volumes(&self, apex: &Vec3) -> (Eight, Eight) {
        let (Corner([ux, uy, uz]), Corner([vx, vy, vz])) = (self.b.from(&self.a), self.c.from(&self.a));
        let Corner([x, y, z]) = &self.a;
        let [mut terms, mut magnitudes] = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let (px, qx) = (uy[lane] * vz[lane], uz[lane] * vy[lane]);
            let (py, qy) = (uz[lane] * vx[lane], ux[lane] * vz[lane]);
            let (pz, qz) = (ux[lane] * vy[lane], uy[lane] * vx[lane]);
            let (wx, wy, wz) = (x[lane] - apex.x, y[lane] - apex.y, z[lane] - apex.z);
            terms[lane] = (px - qx) * wx + (py - qy) * wy + (pz - qz) * wz;
            magnitudes[lane] =
                (px.abs() + qx.abs()) * wx.abs() + (py.abs() + qy.abs()) * wy.abs() + (pz.abs() + qz.abs()) * wz.abs();
        }
        (terms, magnitudes)
    }

    /// Volumes and moments of the tetrahedra, from six times their volumes.
    #[inline(always)]
    fn moments(&self, apex: &Vec3, six: &Eight) -> (Eight, [Eight; 3]) {
        let (mut volumes, mut moments) = ([0.0; LANES], [[0.0; LANES]; 3]);
        for lane in 0..LANES {
            volumes[lane] = six[lane] / 6.0;
        }
        for axis in 0..3 {
            let (a, b, c, apex) = (&self.a.0[axis], &self.b.0[axis], &self.c.0[axis], apex[axis]);
            for lane in 0..LANES {
                let sum = (a[lane] - apex) + (b[lane] - apex) + (c[lane] - apex);
                moments[axis][lane] = sum * (volumes[lane] / 4.0);
            }
        }
        (volumes, moments)
    }
}
