//! Principal axes of symmetric tensors.

use crate::math::Mat3;

/// Unit eigenvectors of a symmetric tensor as columns, by ascending eigenvalue (for an inertia tensor: the longest axis
/// of the body first).
///
/// Jacobi's method: it needs no trigonometric function, so it gives the same bits everywhere.
pub fn principal_axes(tensor: &Mat3) -> Mat3 {
    let (mut diagonal, mut axes) = (*tensor, Mat3::identity());
    // Six sweeps square the off-diagonal part far below rounding; more change nothing.
    for _ in 0..6 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let turn = jacobi_rotation(&diagonal, p, q);
            diagonal = turn.transpose() * diagonal * turn;
            axes *= turn;
        }
    }
    let mut order = [0, 1, 2];
    order.sort_by(|&i, &j| diagonal[(i, i)].total_cmp(&diagonal[(j, j)]));
    // Where two axes are equal, turns by rounding leave numbers so small that no hull takes points turned by them.
    Mat3::from_columns(&order.map(|k| axes.column(k).into_owned())).map(|x| if x.abs() < 1e-30 { 0.0 } else { x })
}

/// The rotation in the plane (p, q) that makes the element (p, q) zero.
fn jacobi_rotation(a: &Mat3, p: usize, q: usize) -> Mat3 {
    let mut turn = Mat3::identity();
    if a[(p, q)] != 0.0 {
        let theta = (a[(q, q)] - a[(p, p)]) / (2.0 * a[(p, q)]);
        let tangent = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
        let cos = 1.0 / (tangent * tangent + 1.0).sqrt();
        let sin = tangent * cos;
        (turn[(p, p)], turn[(q, q)], turn[(p, q)], turn[(q, p)]) = (cos, cos, sin, -sin);
    }
    turn
}
