//! Gauges: weighted sums of nodes' displacements.

use crate::error::{SolveError, TEST};
use crate::march::supports::contact::ACROSS;
use meso_collision::math::Aabb;
use meso_mesh::Mesh;
use meso_mesh::cells::Sides;
use meso_trial::Gauge;
use meso_trial::Sample;
use meso_trial::nodes::area;

/// A gauge on the engine's nodes.
#[derive(Clone, Debug)]
pub(crate) struct Reader {
    /// Name of its column.
    pub(crate) name: String,
    /// Whether it measures the opening that a path may turn at.
    pub(crate) is_mouth: bool,
    /// Whether its value is the momentum of the nodes, whose weights are masses.
    pub(crate) is_momentum: bool,
    /// Nodes by the engine's numbers, with the weights of their displacements.
    weights: Vec<(u32, [f64; 3])>,
}

impl Reader {
    /// One that reads no node yet.
    fn new(name: &str) -> Self {
        Self { name: name.to_owned(), is_mouth: false, is_momentum: false, weights: Vec::new() }
    }

    /// Its value at some displacements.
    pub(crate) fn read(&self, displacement: &[[f64; 3]]) -> f64 {
        let of = |(node, weight): &(u32, [f64; 3])| {
            let u = displacement[*node as usize];
            (0..3).map(|k| weight[k] * u[k]).sum::<f64>()
        };
        self.weights.iter().map(of).sum()
    }

    /// Adds the displacement along `axis` of nodes with their shares, times a factor.
    fn weigh(&mut self, nodes: Vec<(u32, f64)>, axis: usize, factor: f64) {
        let weigh = |(node, share): (u32, f64)| {
            let mut weight = [0.0; 3];
            weight[axis] = factor * share;
            (node, weight)
        };
        self.weights.extend(nodes.into_iter().map(weigh));
    }

    /// Adds the mean displacement along `axis` of some nodes, times a factor.
    fn add(&mut self, nodes: &[u32], axis: usize, factor: f64) {
        let mut weight = [0.0; 3];
        weight[axis] = factor / nodes.len() as f64;
        self.weights.extend(nodes.iter().map(|&node| (node, weight)));
    }
}

/// Nodes that some gauges read, ascending.
pub(crate) fn watched(gauges: &[Reader]) -> Vec<u32> {
    let mut nodes: Vec<u32> = gauges.iter().flat_map(|gauge| gauge.weights.iter().map(|(node, _)| *node)).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Sets gauges on the nodes of a specimen that is loaded along `axis`; `sign` is that of the test.
pub(crate) struct Setter<'a> {
    pub(crate) sample: &'a Sample<'a>,
    pub(crate) axis: usize,
    pub(crate) sign: f64,
    /// Whether the test has a path, along which strains count in its sense.
    pub(crate) has_path: bool,
    /// The engine's numbers of the mesh's nodes.
    pub(crate) number: &'a [u32],
    /// Masses by these numbers, tonne.
    pub(crate) mass: &'a [f64],
}

impl Setter<'_> {
    /// The readers of all `gauges`.
    ///
    /// # Errors
    /// Names the gauge that finds no nodes on the specimen.
    pub(crate) fn all(&self, gauges: &[Gauge]) -> Result<Vec<Reader>, SolveError> {
        gauges.iter().map(|gauge| self.set(gauge)).collect()
    }

    fn set(&self, gauge: &Gauge) -> Result<Reader, SolveError> {
        let name = gauge.name();
        gauge.suits(&self.sample.geometry().size_mm)?;
        let reader = match *gauge {
            Gauge::Lvdt { axis, from_mm, to_mm, .. } => self.lvdt(name, axis as usize, [from_mm, to_mm]),
            Gauge::Sides { axis, .. } => self.sides(name, axis as usize),
            Gauge::Side { on, .. } => self.side(name, on.bit().unwrap_or_default()),
            Gauge::Part { axis, from_mm, to_mm, .. } => self.part(name, axis as usize, [from_mm, to_mm]),
            Gauge::LateralStrain { .. } => self.lateral(name),
            Gauge::CrackMouth { over_mm, .. } => self.mouth(name, over_mm),
        };
        reader.map(|mut reader| {
            reader.weights.iter_mut().for_each(|(node, _)| *node = self.number[*node as usize]);
            reader
        })
    }

    fn mesh(&self) -> &Mesh {
        self.sample.mesh
    }

    /// Displacement along `axis` of some nodes against others, over their distance, times a factor.
    fn add_strain(&self, reader: &mut Reader, axis: usize, [low, high]: [&[u32]; 2], factor: f64) {
        let place = |nodes: &[u32]| {
            nodes.iter().map(|&node| self.mesh().points[node as usize][axis]).sum::<f64>() / nodes.len() as f64
        };
        let scale = factor / (place(high) - place(low));
        reader.add(high, axis, scale);
        reader.add(low, axis, -scale);
    }

    fn lvdt(&self, name: &str, axis: usize, planes: [f64; 2]) -> Result<Reader, SolveError> {
        let aabb = Aabb::around(&self.mesh().points);
        let size = aabb.size()[axis];
        let mut surface = self.surface();
        surface.sort_unstable();
        surface.dedup();
        let near = |plane: f64| -> Vec<u32> {
            let off = |node: u32| (self.mesh().points[node as usize][axis] - aabb.min[axis] - plane).abs();
            let least = surface.iter().map(|&node| off(node)).fold(f64::INFINITY, f64::min);
            let half = least.max(0.5 * self.sample.element_size_mm) + 1e-9 * size;
            surface.iter().copied().filter(|&node| off(node) <= half).collect()
        };
        let mut reader = Reader::new(name);
        let factor = if axis == self.axis && self.has_path { self.sign } else { 1.0 };
        let [low, high] = planes.map(near);
        if low.iter().any(|node| high.contains(node)) {
            let [planes, size] = [format!("{} to {}", planes[0], planes[1]), self.sample.element_size_mm.to_string()];
            let why = format!("its planes meet the same nodes; take planes further apart than the elements, {size} mm");
            return Err(TEST.error(format!("gauges.{name}"), planes, why).into());
        }
        self.add_strain(&mut reader, axis, [&low, &high], factor);
        Ok(reader)
    }

    fn sides(&self, name: &str, axis: usize) -> Result<Reader, SolveError> {
        let sides = Sides::of(self.mesh());
        let [low, high] = [2 * axis, 2 * axis + 1].map(|bit| shares(self.mesh(), &sides.faces()[bit]));
        if low.is_empty() || high.is_empty() {
            let why = "a side across this axis has no face; take another axis";
            return Err(TEST.error(format!("gauges.{name}"), ["x", "y", "z"][axis], why).into());
        }
        let mut reader = Reader::new(name);
        let factor = if axis == self.axis && self.has_path { self.sign } else { 1.0 };
        let place = |side: &[(u32, f64)]| -> f64 {
            side.iter().map(|(node, share)| share * self.mesh().points[*node as usize][axis]).sum()
        };
        let scale = factor / (place(&high) - place(&low));
        reader.weigh(high, axis, scale);
        reader.weigh(low, axis, -scale);
        Ok(reader)
    }

    /// Mean displacement of a side out of the specimen.
    fn side(&self, name: &str, bit: usize) -> Result<Reader, SolveError> {
        let sides = Sides::of(self.mesh());
        let nodes = shares(self.mesh(), &sides.faces()[bit]);
        if nodes.is_empty() {
            let why = "this side has no face; take another side";
            return Err(TEST.error(format!("gauges.{name}"), "side", why).into());
        }
        let mut reader = Reader::new(name);
        let outward = if bit % 2 == 1 { 1.0 } else { -1.0 };
        reader.weigh(nodes, bit / 2, outward);
        Ok(reader)
    }

    /// Momentum along `axis` of all nodes between two planes.
    fn part(&self, name: &str, axis: usize, [from, to]: [f64; 2]) -> Result<Reader, SolveError> {
        let aabb = Aabb::around(&self.mesh().points);
        let slack = 1e-9 * aabb.size()[axis];
        let within = |place: f64| from - slack <= place - aabb.min[axis] && place - aabb.min[axis] <= to + slack;
        let nodes = (0..).zip(&self.mesh().points).filter(|(_, point)| within(point[axis]));
        let masses: Vec<(u32, f64)> =
            nodes.map(|(node, _): (u32, _)| (node, self.mass[self.number[node as usize] as usize])).collect();
        if masses.is_empty() {
            let why = "no node lies between its planes; take planes further apart than the elements";
            return Err(TEST.error(format!("gauges.{name}"), format!("{from} to {to}"), why).into());
        }
        let mut reader = Reader { is_momentum: true, ..Reader::new(name) };
        reader.weigh(masses, axis, 1.0);
        Ok(reader)
    }

    /// Nodes of the surface, some of them several times.
    fn surface(&self) -> Vec<u32> {
        let cells = self.mesh().by_owner();
        self.mesh().outer_faces().into_iter().flat_map(|(cell, face)| cells.face(cell, face)).collect()
    }

    fn lateral(&self, name: &str) -> Result<Reader, SolveError> {
        let sides = Sides::of(self.mesh());
        let aabb = Aabb::around(&self.mesh().points);
        let (middle, quarter) = (0.5 * (aabb.min + aabb.max)[self.axis], 0.25 * aabb.size()[self.axis]);
        let mut reader = Reader::new(name);
        for axis in ACROSS[self.axis] {
            let at = |node: &u32| (self.mesh().points[*node as usize][self.axis] - middle).abs() <= quarter;
            let of = |bit: usize| -> Vec<u32> { sides.members(bit).filter(at).collect() };
            let [low, high] = [of(2 * axis), of(2 * axis + 1)];
            if low.is_empty() || high.is_empty() {
                let why = "it finds no nodes on the sides in the middle half of the height; take smaller elements";
                return Err(TEST.error(format!("gauges.{name}"), "lateral-strain", why).into());
            }
            self.add_strain(&mut reader, axis, [&low, &high], 0.5);
        }
        Ok(reader)
    }

    /// The nodes of the lower side at the notch's lips, or at both ends of a gauge length around it, right against left.
    fn mouth(&self, name: &str, over_mm: Option<f64>) -> Result<Reader, SolveError> {
        let (points, aabb) = (&self.mesh().points, Aabb::around(&self.mesh().points));
        let middle = 0.5 * (aabb.min + aabb.max).x + self.sample.notch_at_mm;
        let at_lips = if self.sample.notches_mm[0] > 0.0 { 0.0 } else { aabb.size().z };
        let half = 0.5 * over_mm.unwrap_or(at_lips);
        let sides = Sides::of(self.mesh());
        let mut reader = Reader { is_mouth: true, ..Reader::new(name) };
        for sense in [1.0, -1.0] {
            let along = |node: u32| sense * (points[node as usize].x - middle);
            // The row of nodes nearest to the gauge's end among those on one side of it, and its mean place.
            let row = |is_beyond: bool| -> Option<(Vec<u32>, f64)> {
                let own = || sides.members(4).filter(|&node| along(node) > 0.0 && (along(node) >= half) == is_beyond);
                let nearest = own().map(along).min_by(|a, b| (a - half).abs().total_cmp(&(b - half).abs()))?;
                let nodes: Vec<u32> =
                    own().filter(|&node| (along(node) - nearest).abs() <= 0.25 * self.sample.element_size_mm).collect();
                let mean = nodes.iter().map(|&node| along(node)).sum::<f64>() / nodes.len() as f64;
                Some((nodes, mean))
            };
            match (row(false), row(true)) {
                (Some((inner, low)), Some((outer, high))) => {
                    let share = ((half - low) / (high - low)).clamp(0.0, 1.0);
                    reader.add(&inner, 0, sense * (1.0 - share));
                    reader.add(&outer, 0, sense * share);
                }
                (Some((only, _)), None) | (None, Some((only, _))) => reader.add(&only, 0, sense),
                (None, None) => {
                    let why = "it finds no nodes on the lower side; take smaller elements";
                    return Err(TEST.error(format!("gauges.{name}"), "crack-mouth", why).into());
                }
            }
        }
        Ok(reader)
    }
}

/// Nodes of some faces, each with its share of their area.
fn shares(mesh: &Mesh, faces: &[(u32, usize)]) -> Vec<(u32, f64)> {
    let cells = mesh.by_owner();
    let mut shares = Vec::new();
    for &(cell, face) in faces {
        let nodes: Vec<u32> = cells.face(cell, face).collect();
        let share = area(mesh, &nodes).norm() / nodes.len() as f64;
        shares.extend(nodes.into_iter().map(|node| (node, share)));
    }
    shares.sort_by_key(|(node, _)| *node);
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let of_node = |own: &[(u32, f64)]| (own[0].0, own.iter().map(|(_, share)| share).sum::<f64>() / total);
    shares.chunk_by(|a, b| a.0 == b.0).map(of_node).collect()
}
