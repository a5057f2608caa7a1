//! The f64 types every floor shares: nalgebra aliases and the axis-aligned box.

/// A position or a displacement, mm.
pub type Vec3 = nalgebra::Vector3<f64>;
/// A 3x3 matrix.
pub type Mat3 = nalgebra::Matrix3<f64>;
/// A proper rotation.
pub type Rotation = nalgebra::UnitQuaternion<f64>;

/// Axis-aligned box, both corners included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// The box that holds nothing; grown by [`Aabb::include`].
    pub fn empty() -> Self {
        Self { min: Vec3::repeat(f64::INFINITY), max: Vec3::repeat(f64::NEG_INFINITY) }
    }

    /// The box that holds everything.
    pub fn everywhere() -> Self {
        Self { min: Vec3::repeat(f64::NEG_INFINITY), max: Vec3::repeat(f64::INFINITY) }
    }

    /// The smallest box around `points`.
    pub fn around<'a>(points: impl IntoIterator<Item = &'a Vec3>) -> Self {
        let mut aabb = Self::empty();
        for point in points {
            aabb.include(point);
        }
        aabb
    }

    /// Grows the box so that it holds `point`.
    pub fn include(&mut self, point: &Vec3) {
        self.min = self.min.inf(point);
        self.max = self.max.sup(point);
    }

    /// The smallest box around this one and `other`.
    #[must_use]
    pub fn with(&self, other: &Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// Distance to `point`; 0 where the box holds it.
    pub fn distance(&self, point: &Vec3) -> f64 {
        (self.min - point).sup(&(point - self.max)).sup(&Vec3::zeros()).norm()
    }

    /// Edge lengths.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }

    /// The coordinate of a side: the lower and the upper one along x, y and z.
    pub fn end(&self, side: usize) -> f64 {
        [self.min, self.max][side % 2][side / 2]
    }

    /// The box with those sides alone that have a bit, in the order of [`end`](Self::end); unbounded elsewhere.
    #[must_use]
    pub fn bounded_at(&self, sides: u8) -> Self {
        let has = |side: usize| sides >> side & 1 == 1;
        let min = Vec3::from_fn(|axis, _| if has(2 * axis) { self.min[axis] } else { f64::NEG_INFINITY });
        let max = Vec3::from_fn(|axis, _| if has(2 * axis + 1) { self.max[axis] } else { f64::INFINITY });
        Self { min, max }
    }

    /// The box with `margin` more on every side.
    #[must_use]
    pub fn grown(&self, margin: f64) -> Self {
        Self { min: self.min.add_scalar(-margin), max: self.max.add_scalar(margin) }
    }

    /// The box displaced by `shift`.
    #[must_use]
    pub fn moved(&self, shift: &Vec3) -> Self {
        Self { min: self.min + shift, max: self.max + shift }
    }

    /// True when the closed boxes share a point.
    pub fn intersects(&self, other: &Self) -> bool {
        (0..3).all(|i| self.min[i] <= other.max[i] && other.min[i] <= self.max[i])
    }
}

/// The longest distance between two of the points, mm.
pub fn longest_distance(points: &[Vec3]) -> f64 {
    let squares = points.iter().enumerate().flat_map(|(i, p)| points[i..].iter().map(move |q| (p - q).norm_squared()));
    squares.fold(0.0, f64::max).sqrt()
}
