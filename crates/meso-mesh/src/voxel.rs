//! Voxel mesh: a regular grid of hexahedra, each of the phase of its centre, or as its sub-samples say.
//!
//! A centre is in an aggregate when all face planes have it inside, and in the ITZ when it is also outside the inward
//! offset by the shell's thickness: max_i (n_i . x - d_i) > -t. By default t is at least the voxel's edge, so that along
//! every axis one ITZ voxel or more lies between core and mortar (a shell h thick is crossed over a length of at least h).
//!
//! Where each voxel has several samples, a body takes as many as its samples fill, the fullest ones first ([`assign`]). The
//! majority of the samples in each voxel would shrink convex bodies, since less than half of a voxel centred on a curved
//! surface lies inside: the aggregates of the paper's specimen lost 5.8 % in voxels of 2 mm. So volumes are kept instead,
//! body by body to half a voxel, and over all bodies of a kind. Core and shell divide a body's voxels in the same way.
//! Bodies that are alike are all rounded the same way: each fibre of 1.93 voxels got two, 3.5 % too much. So a kind that got too
//! much gives voxels back.

use super::options::MeshOptions;
use crate::cells::{CellKind, Mesh, NO_BODY, Phase};
use crate::location::{Facets, Label, PointGrid, Scan};
use meso_collision::math::Vec3;
use meso_concrete::aggregate::{Aggregate, Kind};
use meso_concrete::parallel;
use meso_concrete::specimen::Specimen;
use meso_concrete::stop;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Samples of a voxel along an axis where there are fibres, at least. Few voxels have their centre in a fibre thinner than they
/// are: which ones is chance, and all fibres of a 100 mm cube together were 1.2 % off.
const FIBRE_SAMPLES: u32 = 4;

/// The voxel mesh of `bodies` in `specimen`.
pub(super) fn build(
    bodies: &[Aggregate],
    specimen: &Specimen,
    options: &MeshOptions,
    thin_itz: bool,
    subsamples: u32,
) -> Mesh {
    let voxels = Voxels::of(specimen, options.element_size_mm);
    let facets =
        Facets::all(bodies, |a| shell_thickness(a, if thin_itz { 0.0 } else { voxels.spacing.max() }, options));
    let has_fibres = bodies.iter().any(|body| body.kind == Kind::Fibre);
    let labels = voxels.labels(bodies, &facets, subsamples.max(if has_fibres { FIBRE_SAMPLES } else { 1 }) as usize);
    let mut phase = vec![Phase::Mortar; labels.len()];
    parallel::each_short_mut(&mut phase, |voxel, phase| *phase = phase_of(labels[voxel], &facets));
    let owner = parallel::map_short(labels.len(), |voxel| labels[voxel].body().unwrap_or(NO_BODY));
    Mesh::of(CellKind::Hexahedron, voxels.points(), voxels.cells(), phase, owner)
}

/// The thickness an aggregate's shell has in a voxel mesh, `least` mm or more; 0 for none.
fn shell_thickness(aggregate: &Aggregate, least: f64, options: &MeshOptions) -> f64 {
    match options.shell_mm(aggregate) {
        0.0 => 0.0,
        thickness => thickness.max(least),
    }
}

fn phase_of(label: Label, facets: &[Facets]) -> Phase {
    match label.body() {
        None => Phase::Mortar,
        Some(_) if label.in_shell() => Phase::Itz,
        Some(body) => facets[body as usize].phase,
    }
}

/// Whole voxels that fill the specimen's box.
struct Voxels {
    min: Vec3,
    max: Vec3,
    spacing: Vec3,
    counts: [usize; 3],
}

impl Voxels {
    fn of(specimen: &Specimen, element_size: f64) -> Self {
        let aabb = specimen.aabb();
        let counts = [0, 1, 2].map(|i| (aabb.size()[i] / element_size).round().max(1.0) as usize);
        let spacing = Vec3::from_fn(|i, _| aabb.size()[i] / counts[i] as f64);
        Self { min: aabb.min, max: aabb.max, spacing, counts }
    }

    fn labels(&self, bodies: &[Aggregate], facets: &[Facets], n: usize) -> Vec<Label> {
        let spacing = self.spacing / n as f64;
        let grid = PointGrid { origin: self.min + spacing / 2.0, spacing, counts: self.counts.map(|c| c * n) };
        let scan = Scan::new(grid, facets);
        let mut labels = vec![Label::MORTAR; self.counts.iter().product()];
        let of_layer = self.counts[0] * self.counts[1];
        if n == 1 {
            parallel::chunks_mut(&mut labels, of_layer, |k, layer| scan.label_layer(k, layer));
        } else {
            let mut layers: Vec<_> = labels.chunks_mut(of_layer).map(|layer| (layer, Vec::new())).collect();
            parallel::each_mut(&mut layers, |k, (layer, claims)| {
                *claims = self.sample_layer(&scan, grid, n, k, layer);
            });
            let claims: Vec<_> = layers.into_iter().map(|(_, claims)| claims).collect();
            assign(claims.concat(), n * n * n, bodies, &mut labels);
        }
        labels
    }

    /// Labels the voxels of layer `k` whose n x n x n samples agree; the claims on the others.
    fn sample_layer(&self, scan: &Scan, fine: PointGrid, n: usize, k: usize, layer: &mut [Label]) -> Vec<Claim> {
        let mut samples = vec![Label::MORTAR; fine.layer_len() * n];
        for (sub, labels) in samples.chunks_exact_mut(fine.layer_len()).enumerate() {
            scan.label_layer(k * n + sub, labels);
        }
        let first = (k * layer.len()) as u32;
        let (mut claims, mut of_voxel) = (Vec::new(), Vec::with_capacity(n * n * n));
        for (voxel, label) in layer.iter_mut().enumerate() {
            let (i, j) = (voxel % self.counts[0] * n, voxel / self.counts[0] * n);
            of_voxel.clear();
            for row in (0..n * n).map(|r| r / n * fine.layer_len() + (j + r % n) * fine.counts[0] + i) {
                of_voxel.extend_from_slice(&samples[row..row + n]);
            }
            if of_voxel.iter().all(|sample| *sample == of_voxel[0]) {
                *label = of_voxel[0];
            } else {
                of_voxel.sort_unstable();
                claims.extend(Claim::of(first + voxel as u32, &of_voxel));
            }
        }
        claims
    }

    fn points(&self) -> Vec<Vec3> {
        // The last plane takes the box's own coordinate: a rounded multiple would miss the face.
        let at = |axis: usize, i: usize| {
            if i == self.counts[axis] { self.max[axis] } else { self.min[axis] + i as f64 * self.spacing[axis] }
        };
        let [nx, ny, nz] = self.counts.map(|c| c + 1);
        let point = |p: usize| {
            if p.is_multiple_of(nx) {
                stop::point();
            }
            Vec3::new(at(0, p % nx), at(1, p / nx % ny), at(2, p / (nx * ny)))
        };
        parallel::map_short(nx * ny * nz, point)
    }

    fn cells(&self) -> Vec<u32> {
        let [nx, ny, nz] = self.counts;
        let (row, layer) = (nx as u32 + 1, (nx as u32 + 1) * (ny as u32 + 1));
        let mut cells = vec![0; 8 * nx * ny * nz];
        parallel::chunks_mut(&mut cells, 8 * nx, |r, of_row| {
            let (j, k) = ((r % ny) as u32, (r / ny) as u32);
            for (a, cell) in (k * layer + j * row..).zip(of_row.chunks_exact_mut(8)) {
                let bottom = [a, a + 1, a + 1 + row, a + row];
                cell[..4].copy_from_slice(&bottom);
                cell[4..].copy_from_slice(&bottom.map(|node| node + layer));
            }
        });
        cells
    }
}

/// Rounding may give the bodies of a kind this share of their volume too much. Kinds of many shapes stay far below.
const ACCEPTED_EXCESS: f64 = 0.005;

/// A body's samples in a voxel that does not have one label alone.
#[derive(Clone, Copy, Debug)]
struct Claim {
    voxel: u32,
    body: u32,
    /// In the body.
    inside: u16,
    /// In its core.
    core: u16,
}

impl Claim {
    /// The claims of all bodies on a voxel; `samples` are sorted.
    fn of(voxel: u32, samples: &[Label]) -> impl Iterator<Item = Self> {
        let bodies = samples.chunk_by(|a, b| a.body() == b.body());
        bodies.filter_map(move |samples| {
            let body = samples[0].body()?;
            let core = samples.iter().filter(|label| !label.in_shell()).count() as u16;
            Some(Self { voxel, body, inside: samples.len() as u16, core })
        })
    }
}

/// Samples of a body, claimed or in its core, and the voxels it got.
#[derive(Clone, Copy, Default)]
struct Account {
    inside: i64,
    core: i64,
    voxels: i64,
    cores: i64,
}

impl Account {
    /// Whether half a voxel or more of its samples have none yet; a voxel has so many samples.
    fn wants_voxel(&self, samples: i64) -> bool {
        2 * (self.inside - self.voxels * samples) >= samples
    }

    /// Whether its core has half a voxel or more to come, of the voxels that the body got.
    fn wants_core(&self) -> bool {
        (2 * self.cores + 1) * self.inside <= 2 * self.voxels * self.core
    }
}

/// Gives the voxels of `claims` their labels; the others have theirs. Voxels have `samples` each.
fn assign(mut claims: Vec<Claim>, samples: usize, bodies: &[Aggregate], labels: &mut [Label]) {
    let samples = samples as i64;
    let mut accounts = vec![Account::default(); bodies.len()];
    for claim in &claims {
        let account = &mut accounts[claim.body as usize];
        account.inside += i64::from(claim.inside);
        account.core += i64::from(claim.core);
    }
    let volumes = volumes(bodies, &accounts, labels, samples);
    // By voxel and body where shares are equal: the same on any number of threads.
    claims.par_sort_unstable_by_key(|claim| (u16::MAX - claim.inside, claim.voxel, claim.body));
    let mut taken = Vec::with_capacity(claims.len());
    let mut left = Vec::new();
    let mut missing: BTreeMap<Kind, i64> = BTreeMap::new();
    for claim in claims {
        let account = &mut accounts[claim.body as usize];
        let is_free = labels[claim.voxel as usize] == Label::MORTAR;
        if is_free && account.wants_voxel(samples) {
            take(claim, account, labels, &mut taken);
        } else if is_free {
            left.push(claim);
        }
    }
    for (account, body) in accounts.iter().zip(bodies) {
        *missing.entry(body.kind).or_default() += account.inside - account.voxels * samples;
    }
    // Voxels that several bodies wanted left some of them short.
    for claim in left {
        let missing = missing.entry(bodies[claim.body as usize].kind).or_default();
        if 2 * *missing >= samples && labels[claim.voxel as usize] == Label::MORTAR {
            *missing -= samples;
            take(claim, &mut accounts[claim.body as usize], labels, &mut taken);
        }
    }
    for (kind, missing) in missing {
        if -missing as f64 > ACCEPTED_EXCESS * volumes[&kind] as f64 {
            let is_kind = |claim: &Claim| bodies[claim.body as usize].kind == kind;
            give_back(-missing, samples, is_kind, &mut taken, &mut accounts, labels);
        }
    }
    divide(taken, &mut accounts, labels);
}

/// The samples of every kind, those of voxels that have one label alone as well.
fn volumes(bodies: &[Aggregate], accounts: &[Account], labels: &[Label], samples: i64) -> BTreeMap<Kind, i64> {
    let mut volumes = BTreeMap::new();
    for (account, body) in accounts.iter().zip(bodies) {
        *volumes.entry(body.kind).or_default() += account.inside;
    }
    for body in labels.iter().filter_map(|label| label.body()) {
        *volumes.entry(bodies[body as usize].kind).or_default() += samples;
    }
    volumes
}

/// Takes voxels from bodies that were rounded up, those with the fewest samples first, until `excess` samples are gone.
fn give_back(
    mut excess: i64,
    samples: i64,
    is_kind: impl Fn(&Claim) -> bool,
    taken: &mut Vec<Claim>,
    accounts: &mut [Account],
    labels: &mut [Label],
) {
    taken.sort_unstable_by_key(|claim| (claim.inside, claim.voxel));
    taken.retain(|claim| {
        let account = &mut accounts[claim.body as usize];
        let goes = 2 * excess >= samples && is_kind(claim) && account.voxels * samples > account.inside;
        if goes {
            excess -= samples;
            account.voxels -= 1;
            labels[claim.voxel as usize] = Label::MORTAR;
        }
        !goes
    });
}

/// The voxel is the body's shell until its core asks for it.
fn take(claim: Claim, account: &mut Account, labels: &mut [Label], taken: &mut Vec<Claim>) {
    labels[claim.voxel as usize] = Label::shell(claim.body);
    account.voxels += 1;
    taken.push(claim);
}

/// Gives each core its share of its body's voxels, those with the most samples of it first.
fn divide(mut taken: Vec<Claim>, accounts: &mut [Account], labels: &mut [Label]) {
    taken.par_sort_unstable_by_key(|claim| (u16::MAX - claim.core, claim.voxel));
    for claim in taken {
        let account = &mut accounts[claim.body as usize];
        if account.wants_core() {
            account.cores += 1;
            labels[claim.voxel as usize] = Label::core(claim.body);
        }
    }
}
