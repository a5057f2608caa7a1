//! Solutions for units of a mean gradient or strain: the columns of a tensor, and its errors.
//!
//! Scalar properties and stiffness differ in their equations, in which entries of a tensor are alike, and in the bounds of an entry.

use crate::estimate::{Estimate, Sizes};
use crate::field::PropertyField;
use meso_concrete::watch::{Stage, Watch};

/// A tensor by rows; entries that were not asked for are `None`.
pub(crate) type Entries<const N: usize> = [[Option<f64>; N]; N];
/// Entries with their errors.
pub(crate) type Estimates<const N: usize> = [[Option<Estimate>; N]; N];

/// The solution for a unit of one component of the mean gradient or strain.
pub(crate) struct Column<const N: usize> {
    pub(crate) component: usize,
    /// Mean flux or stress.
    pub(crate) mean: [f64; N],
    /// Mean of the eigenstress times the strain.
    pub(crate) eigenstress: f64,
    pub(crate) iterations: usize,
    pub(crate) error: f64,
    /// Bounds of the exact value on the diagonal.
    pub(crate) bounds: Option<[f64; 2]>,
    /// Most by which the value on the diagonal exceeds the exact one, where neither bounds nor other sizes say it.
    pub(crate) excess: Option<f64>,
    pub(crate) field: Option<PropertyField>,
}

impl<const N: usize> Column<N> {
    /// A solution with its iterations and its error.
    pub(crate) fn new(component: usize, mean: [f64; N], (iterations, error): (usize, f64)) -> Self {
        Self { component, mean, eigenstress: 0.0, iterations, error, bounds: None, excess: None, field: None }
    }
}

/// Reports the iterations of solution number `done` of `stages`, if there are any.
pub(crate) fn reporting(watch: &dyn Watch, done: usize, stages: usize) -> impl Fn(usize, f64) {
    move |iteration, _| {
        // Some 20 iterations are usual.
        let share = (done as f64 + 1.0 - 1.0 / (1.0 + iteration as f64 / 10.0)) / stages as f64;
        if stages > 0 {
            watch.stage(Stage::Solve, share);
        }
    }
}

/// Solutions on fine cells, and on coarser ones of some sizes.
pub(crate) struct Solutions<const N: usize> {
    pub(crate) fine: Vec<Column<N>>,
    pub(crate) coarser: Vec<Vec<Column<N>>>,
    pub(crate) sizes: Sizes,
}

/// Kinds of entries that are alike.
const KINDS: usize = 4;

impl<const N: usize> Solutions<N> {
    /// Takes the fields out.
    pub(crate) fn fields(&mut self) -> Vec<PropertyField> {
        self.fine.iter_mut().filter_map(|column| column.field.take()).collect()
    }

    /// Iterations of the fine solutions.
    pub(crate) fn iterations(&self) -> Vec<usize> {
        self.fine.iter().map(|column| column.iterations).collect()
    }

    /// Largest error of the fine equations.
    pub(crate) fn error(&self) -> f64 {
        self.fine.iter().map(|column| column.error).fold(0.0, f64::max)
    }

    /// The tensor on fine cells, and on those of twice the size.
    pub(crate) fn tensors(&self) -> (Entries<N>, Option<Entries<N>>) {
        (tensor(&self.fine), self.coarser.first().map(|columns| tensor(columns)))
    }

    /// Estimates of like quantities of the columns.
    pub(crate) fn like(&self, of: impl Fn(&[Column<N>]) -> Vec<f64>) -> Vec<Estimate> {
        let (fine, coarser) = (of(&self.fine), self.coarser.iter().map(|columns| of(columns)).collect::<Vec<_>>());
        let on = |number: usize, at: usize| coarser.get(number).map(|of| of[at]);
        self.sizes.estimates(&(0..fine.len()).map(|at| (fine[at], on(0, at), on(1, at))).collect::<Vec<_>>())
    }

    /// Estimates of all entries. Those of a `kind` are alike.
    pub(crate) fn estimates(&self, kind: impl Fn(usize, usize) -> usize) -> Estimates<N> {
        let mut found = [[None; N]; N];
        for number in 0..KINDS {
            let entries = |columns: &[Column<N>]| -> Vec<((usize, usize), f64)> {
                let tensor = tensor(columns);
                let places = (0..N * N).map(|place| (place / N, place % N)).filter(|at| kind(at.0, at.1) == number);
                places.filter_map(|at| Some((at, tensor[at.0][at.1]?))).collect()
            };
            let estimates = self.like(|columns| entries(columns).into_iter().map(|(_, value)| value).collect());
            let entries = entries(&self.fine).into_iter().zip(estimates);
            entries.for_each(|(((row, column), _), estimate)| found[row][column] = Some(estimate));
        }
        found
    }

    /// Values and errors of the entries, with the errors of the equations, and within the bounds of an entry if it has such.
    pub(crate) fn settled(
        &self,
        found: &Estimates<N>,
        bounds: impl Fn(usize, usize) -> Option<[f64; 2]>,
    ) -> [Entries<N>; 2] {
        let (error, (fine, _)) = (self.error(), self.tensors());
        let entry = |row: usize, column: usize| {
            let estimate = found[row][column]?.solved(error, fine[column][column]?);
            Some(bounds(row, column).map_or(estimate, |[low, high]| estimate.within(low, high)))
        };
        let each = |of: fn(Estimate) -> f64| {
            std::array::from_fn(|row| std::array::from_fn(|column| entry(row, column).map(of)))
        };
        [each(|estimate| estimate.value), each(|estimate| estimate.error)]
    }
}

fn tensor<const N: usize>(columns: &[Column<N>]) -> Entries<N> {
    let mut tensor = [[None; N]; N];
    for column in columns {
        (0..N).for_each(|row| tensor[row][column.component] = Some(column.mean[row]));
    }
    tensor
}
