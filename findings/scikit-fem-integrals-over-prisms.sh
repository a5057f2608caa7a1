#!/usr/bin/env bash
# scikit-fem 12.0.2: integrals over MeshWedge1 take the two coordinates of the triangle for independent ones.
# The weights of a prism sum up to 1/4, not 1/2, and points lie outside of it; every form is assembled so, no message.
# Seen: a unit cube of prisms has a volume of 0.5 and z z dV of 0.125 at any order; right are 1 and 1/3.
# A field u = z has the energy of 0.5, not 1. Tetrahedra and bricks are right.
# Mends it: Basis(..., quadrature=) with points and weights of a triangle times a line, or mesh.to_meshtet().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile scikit-fem==12.0.2 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
import skfem
from skfem.helpers import dot, grad
from skfem.quadrature import get_quadrature
from skfem.refdom import RefLine, RefTri, RefWedge

cube = skfem.MeshTri().refined(1) * skfem.MeshLine().refined(1)


@skfem.BilinearForm
def laplace(u, v, _):
    return dot(grad(u), grad(v))


def measures(mesh, element, **options):
    basis = skfem.Basis(mesh, element, **options)
    volume = skfem.Functional(lambda w: 1 + 0 * w.x[0]).assemble(basis)
    moment = skfem.Functional(lambda w: w.x[2] ** 2).assemble(basis)
    field = mesh.p[2]
    return np.round([volume, moment, field @ laplace.assemble(basis) @ field], 6).tolist()


print("scikit-fem", importlib.metadata.version("scikit-fem"), "volume, z z dV and energy of u = z; right: 1, 1/3, 1")
for order in (2, 4, 6):
    points, weights = get_quadrature(RefWedge, order)
    seen = measures(cube, skfem.ElementWedge1(), intorder=order)
    total, outside = round(float(weights.sum()), 6), round(float((points[0] + points[1]).max()), 3)
    print(" order", order, "sum of the weights", total, "x + y of a point up to", outside, "seen:", seen)
    assert total == 0.25 and outside > 1.4 and seen == [0.5, 0.125, 0.5]
(line, line_weights), (triangle, triangle_weights) = get_quadrature(RefLine, 4), get_quadrature(RefTri, 4)
points = np.vstack([np.tile(triangle, line.shape[1]), np.repeat(line[0], triangle.shape[1])])
own = measures(cube, skfem.ElementWedge1(), quadrature=(points, np.outer(line_weights, triangle_weights).ravel()))
tetra = measures(cube.to_meshtet(), skfem.ElementTetP1(), intorder=4)
brick = measures(skfem.MeshHex().refined(1), skfem.ElementHex1(), intorder=4)
print(" own points:", own, "tetrahedra:", tetra, "bricks:", brick)
assert own == tetra == brick == [1.0, 0.333333, 1.0]
PYTHON
