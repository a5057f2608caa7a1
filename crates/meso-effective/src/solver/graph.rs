//! Networks of any shape. Groups of a coarse level are pairs of pairs of pairs along the strongest links (Notay, Electron. Trans.
//! Numer. Anal. 37, 2010, 123).

use super::network::{Network, over};
use super::stencil::{Real, dot, layers_mut};
use meso_concrete::parallel;

/// Unknowns of a layer.
const LAYER: usize = 1 << 12;
/// A level of so few unknowns is the last.
const FEWEST: usize = 64;
/// Pairings of a level: groups have eight unknowns.
const PAIRINGS: usize = 3;
/// Links below this share of an unknown's strongest one make no pair.
const WEAK: f32 = 0.25;
/// The group of an unknown without links.
const NONE: u32 = u32::MAX;

/// Links between unknowns, some of them negative.
pub(crate) struct Graph {
    rows: Rows<f32>,
    /// Links to given potentials.
    ground: Vec<f32>,
    /// Unknowns of the finer level by their group.
    groups: Groups,
}

/// Entries of a sparse matrix without its diagonal, by rows.
pub(crate) struct Rows<T> {
    /// Place of each row's first entry, and the end of the last row.
    starts: Vec<usize>,
    /// Column of every entry, ascending in a row.
    columns: Vec<u32>,
    values: Vec<T>,
}

impl<T: Copy + Send> Rows<T> {
    /// `count` rows of entries in any order; entries of one column are added up in theirs.
    pub(crate) fn new(
        count: usize,
        of: impl Fn(usize, &mut Vec<(u32, T)>) + Sync,
        add: impl Fn(&mut T, T) + Sync,
    ) -> Self {
        let layer = |layer: usize| {
            let (mut rows, mut row, mut ends) = (Vec::new(), Vec::new(), Vec::new());
            for number in layer * LAYER..count.min((layer + 1) * LAYER) {
                row.clear();
                of(number, &mut row);
                row.sort_by_key(|entry| entry.0);
                row.dedup_by(|next, first| {
                    let same = next.0 == first.0;
                    if same {
                        add(&mut first.1, next.1);
                    }
                    same
                });
                rows.extend_from_slice(&row);
                ends.push(row.len());
            }
            (rows, ends)
        };
        let layers = parallel::map(count.div_ceil(LAYER), layer);
        let total = layers.iter().map(|(rows, _)| rows.len()).sum();
        let mut all = Self {
            starts: Vec::with_capacity(count + 1),
            columns: Vec::with_capacity(total),
            values: Vec::with_capacity(total),
        };
        let mut end = 0;
        all.starts.push(0);
        for (rows, lengths) in layers {
            for length in lengths {
                end += length;
                all.starts.push(end);
            }
            all.columns.extend(rows.iter().map(|entry| entry.0));
            all.values.extend(rows.iter().map(|entry| entry.1));
        }
        all
    }

    /// Rows of other values.
    pub(crate) fn map<U>(&self, of: impl Fn(&T) -> U) -> Rows<U> {
        let values = self.values.iter().map(of).collect();
        Rows { starts: self.starts.clone(), columns: self.columns.clone(), values }
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Columns and values of a row.
    #[inline]
    pub(crate) fn row(&self, number: usize) -> (&[u32], &[T]) {
        let range = self.starts[number]..self.starts[number + 1];
        (&self.columns[range.clone()], &self.values[range])
    }
}

/// Unknowns of the finer level by their group.
#[derive(Default)]
struct Groups {
    of: Vec<u32>,
    starts: Vec<usize>,
    members: Vec<u32>,
}

impl Groups {
    fn new(of: Vec<u32>, count: usize) -> Self {
        let mut starts = vec![0; count + 1];
        of.iter().filter(|group| **group != NONE).for_each(|group| starts[*group as usize + 1] += 1);
        (0..count).for_each(|group| starts[group + 1] += starts[group]);
        let mut next = starts.clone();
        let mut members = vec![0; starts[count]];
        for (unknown, group) in (0..).zip(&of).filter(|(_, group)| **group != NONE) {
            members[next[*group as usize]] = unknown;
            next[*group as usize] += 1;
        }
        Self { of, starts, members }
    }

    fn members(&self, group: usize) -> &[u32] {
        &self.members[self.starts[group]..self.starts[group + 1]]
    }
}

impl Graph {
    /// The network of some links, and of the links to given potentials.
    pub(crate) fn new(rows: Rows<f32>, ground: Vec<f32>) -> Self {
        Self { rows, ground, groups: Groups::default() }
    }

    /// Sum of the amounts of an unknown's links.
    fn scale(&self, number: usize) -> f32 {
        self.rows.row(number).1.iter().fold(self.ground[number].abs(), |sum, link| sum + link.abs())
    }

    /// Pairs of unknowns along strong links; unknowns without links are in none.
    fn pairs(&self) -> Groups {
        let mut group = vec![NONE; self.len()];
        let mut count = 0;
        for unknown in 0..self.len() {
            if group[unknown] != NONE || self.scale(unknown) == 0.0 {
                continue;
            }
            let (columns, links) = self.rows.row(unknown);
            let strongest = links.iter().copied().fold(0.0, f32::max);
            let mut best = (WEAK * strongest, None);
            for (column, link) in columns.iter().zip(links) {
                if *link > best.0 && group[*column as usize] == NONE {
                    best = (*link, Some(*column));
                }
            }
            group[unknown] = count;
            if let Some(mate) = best.1 {
                group[mate as usize] = count;
            }
            count += 1;
        }
        Groups::new(group, count as usize)
    }

    /// The network of groups.
    fn of_groups(&self, groups: Groups) -> Self {
        let count = groups.starts.len() - 1;
        let row = |group: usize, row: &mut Vec<(u32, f64)>| {
            for member in groups.members(group) {
                let (columns, links) = self.rows.row(*member as usize);
                let entries = columns.iter().zip(links).map(|(column, link)| (groups.of[*column as usize], *link));
                let outward = entries.filter(|(to, _)| *to != NONE && *to != group as u32);
                row.extend(outward.map(|(to, link)| (to, f64::from(link))));
            }
        };
        let rows = Rows::new(count, row, |to, from| *to += from);
        let rows = rows.map(|link| *link as f32);
        let ground = |group: usize| groups.members(group).iter().map(|member| self.ground[*member as usize]).sum();
        let ground = parallel::map_short(count, ground);
        Self { rows, ground, groups }
    }

    /// Calls `visit` with every unknown of layer `k`: its number in the layer, and the flux out of it.
    #[inline]
    fn fluxes<T: Real>(&self, u: &[T], k: usize, mut visit: impl FnMut(usize, f64)) {
        let first = k * LAYER;
        for number in first..self.len().min(first + LAYER) {
            let own: f64 = u[number].into();
            let mut flux = f64::from(self.ground[number]) * own;
            let (columns, links) = self.rows.row(number);
            for (column, link) in columns.iter().zip(links) {
                flux += f64::from(*link) * (own - u[*column as usize].into());
            }
            visit(number - first, flux);
        }
    }
}

impl Network for Graph {
    fn len(&self) -> usize {
        self.rows.len()
    }

    fn layer_len(&self) -> usize {
        LAYER
    }

    fn apply(&self, u: &[f32], out: &mut [f32]) -> f64 {
        layers_mut(out, LAYER, |k, out| self.fluxes(u, k, |at, flux| out[at] = flux as f32));
        dot(u, out, LAYER)
    }

    fn residual(&self, u: &[f64], rhs: &[f64], out: &mut [f32]) {
        layers_mut(out, LAYER, |k, out| self.fluxes(u, k, |at, flux| out[at] = (rhs[k * LAYER + at] - flux) as f32));
    }

    fn over_scales(&self) -> Vec<f32> {
        parallel::map_short(self.len(), |number| over(self.scale(number)))
    }

    fn sweep(&self, x: &[f32], rhs: &[f32], over: &[f32], weight: f32, next: &mut [f32]) {
        layers_mut(next, LAYER, |k, next| {
            let [own, rhs, over] = [x, rhs, over].map(|all| &all[k * LAYER..]);
            self.fluxes(x, k, |at, flux| next[at] = own[at] + weight * over[at] * (rhs[at] - flux as f32));
        });
    }

    fn coarse(&self) -> Option<Self> {
        if self.len() <= FEWEST {
            return None;
        }
        let mut graph = self.of_groups(self.pairs());
        for _ in 1..PAIRINGS {
            let next = graph.of_groups(graph.pairs());
            let through = |group: &u32| if *group == NONE { NONE } else { next.groups.of[*group as usize] };
            let of = graph.groups.of.iter().map(through).collect();
            let groups = Groups::new(of, next.len());
            graph = Self { groups, ..next };
        }
        // Isolated unknowns that are left make no smaller network.
        (graph.len() < self.len() / 2).then_some(graph)
    }

    fn restrict(&self, coarse: &Self, x: &[f32], rhs: &[f32], into: &mut [f32]) {
        let mut residual = vec![0.0; self.len()];
        layers_mut(&mut residual, LAYER, |k, residual| {
            let rhs = &rhs[k * LAYER..];
            self.fluxes(x, k, |at, flux| residual[at] = rhs[at] - flux as f32);
        });
        layers_mut(into, LAYER, |k, into| {
            for (number, into) in into.iter_mut().enumerate() {
                let members = coarse.groups.members(k * LAYER + number);
                *into = members.iter().map(|member| residual[*member as usize]).sum();
            }
        });
    }

    fn correct(&self, coarse: &Self, x: &mut [f32], correction: &[f32]) {
        layers_mut(x, LAYER, |k, x| {
            let groups = &coarse.groups.of[k * LAYER..];
            for (x, group) in x.iter_mut().zip(groups).filter(|(_, group)| **group != NONE) {
                *x += correction[*group as usize];
            }
        });
    }
}
