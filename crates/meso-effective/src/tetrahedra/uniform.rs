//! A uniform flux through all walls.
//!
//! Solutions for unit fluxes along x, y and z have mean gradients, the columns of the mean resistance. Its inverse is the tensor.

use super::domain::Unknowns;
use super::flux::Task;
use crate::error::EffectiveError;
use crate::solutions::Column;
use crate::solver::Energy;
use meso_collision::math::{Mat3, Vec3};
use meso_concrete::Ranges;

impl Task<'_> {
    /// The columns of the axes asked for. All three solutions count in each.
    pub(super) fn columns_of_uniform_flux(&self) -> Result<Vec<Column<3>>, EffectiveError> {
        let conduction = &self.conduction;
        let domain = conduction.domain;
        let unknowns = domain.unknowns(0, |cell| conduction.conducts(cell));
        let graph = conduction.graph(&unknowns);
        let loads = self.loads(&unknowns)?;
        let nothing = vec![0.0; unknowns.nodes.len()];
        let mut resistance = Mat3::zeros();
        let mut columns = Vec::new();
        for (axis, load) in loads.iter().enumerate() {
            let voigt = conduction.mean(&unknowns.of, axis, &nothing)[axis];
            let least = Energy::rising(domain.volume / voigt);
            let found = self.solve(&graph, load.clone(), least, axis)?;
            let u = &found.potential;
            for (row, load) in loads.iter().enumerate() {
                resistance[(row, axis)] = load.iter().zip(u).map(|(load, u)| load * u).sum::<f64>() / domain.volume;
            }
            // On the diagonal, twice the work less the energy: its error is the square of the potential's.
            let [.., energy] = conduction.sums(&unknowns.of, &Vec3::zeros(), u);
            resistance[(axis, axis)] = 2.0 * resistance[(axis, axis)] - energy / domain.volume;
            let field = || conduction.field((self.options.what, &unknowns.of), axis, &Vec3::zeros(), u);
            let field = (self.fields && self.options.axes[axis]).then(field);
            columns.push(Column { field, ..Column::new(axis, [0.0; 3], (found.iterations, found.error)) });
        }
        let tensor = resistance.try_inverse().unwrap_or_default();
        columns.iter_mut().for_each(|column| column.mean = tensor.column(column.component).into());
        columns.retain(|column| self.options.axes[column.component]);
        Ok(columns)
    }

    /// Flux into each unknown's node through the walls, for unit fluxes along x, y and z.
    fn loads(&self, unknowns: &Unknowns) -> Result<[Vec<f64>; 3], EffectiveError> {
        let domain = self.conduction.domain;
        let mut loads = [0, 1, 2].map(|_| vec![0.0; unknowns.nodes.len()]);
        for (side, faces) in domain.sides.faces().iter().enumerate() {
            let (axis, sign) = (side / 2, if side % 2 == 0 { -1.0 } else { 1.0 });
            for (cell, face) in faces {
                if !self.conduction.conducts(*cell as usize) {
                    let accepted = "a phase without conduction meets a wall, and no flux enters there";
                    return Err(Ranges("effective").error("boundary", "uniform-flux", accepted).into());
                }
                let nodes = domain.face(*cell as usize, *face);
                let [a, b, c] = nodes.map(|node| domain.mesh.points[node]);
                let share = sign * (b - a).cross(&(c - a)).norm() / 6.0;
                nodes.iter().for_each(|node| loads[axis][unknowns.of[*node] as usize] += share);
            }
        }
        Ok(loads)
    }
}
