//! Which voxels have their centres outside the specimen.

use meso_collision::math::Vec3;
use meso_concrete::specimen::Container;
use meso_mesh::location::PointGrid;

/// Gives `value` to the voxels of layer `k` that lie outside.
pub(super) fn mark<T: Copy>(container: &dyn Container, grid: &PointGrid, k: usize, layer: &mut [T], value: T) {
    let z = grid.coordinate(2, k);
    let aabb = container.aabb();
    let columns = grid.range(0, aabb.min.x, aabb.max.x);
    for (j, row) in layer.chunks_exact_mut(grid.counts[0]).enumerate() {
        let y = grid.coordinate(1, j);
        if !(z >= aabb.min.z && z <= aabb.max.z && y >= aabb.min.y && y <= aabb.max.y) {
            row.fill(value);
            continue;
        }
        row[..columns.start].fill(value);
        row[columns.end..].fill(value);
        if !container.is_box() {
            mark_row(container, |i| Vec3::new(grid.coordinate(0, i), y, z), grid.spacing.x, row, value);
        }
    }
}

/// Every voxel within the depth of one that is inside is inside, too, and need not be asked about.
fn mark_row<T: Copy>(container: &dyn Container, centre: impl Fn(usize) -> Vec3, h: f64, row: &mut [T], value: T) {
    let mut i = 0;
    while i < row.len() {
        let point = centre(i);
        if container.contains(&point) {
            // A voxel less, against rounding.
            i += ((container.depth(&point) / h) as usize).max(2) - 1;
        } else {
            row[i] = value;
            i += 1;
        }
    }
}
