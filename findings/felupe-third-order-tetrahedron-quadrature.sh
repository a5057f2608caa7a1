#!/usr/bin/env bash
# FElupe 11.3.0: TetrahedronQuadrature(order=3) has the point (1/2, 1/2, 1/6), outside of it, for (1/6, 1/6, 1/2).
# Its weights are those of the rule of five points, so that volumes are right and even linear functions are not.
# Seen: a unit cube of ten-node tetrahedra has a volume of 1 and its centre at (0.525, 0.575, 0.55); its stiffness has
# negative eigenvalues. There is a warning of negative volumes, which is about the negative weight of the rule.
# Mends it: order=5, or a Scheme with the point (1/6, 1/6, 1/2).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile felupe==11.3.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import warnings
from math import factorial

import felupe
import numpy as np

warnings.simplefilter("ignore")
mesh = felupe.mesh.add_midpoints_edges(felupe.mesh.triangulate(felupe.Cube(n=3)))


def worst(scheme, degree):
    powers = [(a, b, degree - a - b) for a in range(degree + 1) for b in range(degree + 1 - a)]
    right = [np.prod([factorial(power) for power in each]) / factorial(degree + 3) for each in powers]
    seen = [scheme.weights @ np.prod(scheme.points ** np.array(each), axis=1) for each in powers]
    return round(float(np.max(np.abs(np.array(seen) / right - 1))), 6)


def cube(scheme):
    region = felupe.RegionQuadraticTetra(mesh, quadrature=scheme)
    place = felupe.Field(region, dim=3, values=mesh.points).interpolate()
    body = felupe.SolidBody(felupe.NeoHooke(mu=1, bulk=2), felupe.FieldContainer([felupe.Field(region, dim=3)]))
    lowest = np.linalg.eigvalsh(body.assemble.matrix().toarray())[0]
    centre = (place * region.dV).sum(axis=(1, 2)).round(6).tolist()
    return round(float(region.dV.sum()), 6), centre, round(float(lowest), 3) + 0.0


third = felupe.TetrahedronQuadrature(order=3)
moved = third.points.copy()
moved[3] = 1 / 6, 1 / 6, 1 / 2
schemes = {"2": felupe.TetrahedronQuadrature(order=2), "3": third, "5": felupe.TetrahedronQuadrature(order=5)}
schemes["3 with the point moved"] = felupe.quadrature.Scheme(moved, third.weights)
seen = {}
print("FElupe", felupe.__version__)
for name, scheme in schemes.items():
    errors, outside = [worst(scheme, degree) for degree in range(4)], round(float(scheme.points.sum(axis=1).max()), 3)
    seen[name] = errors, outside, *cube(scheme)
    print(" order", name, "errors of degree 0 to 3:", errors, "x + y + z up to", outside)
    print("   volume, centre and lowest eigenvalue:", *seen[name][2:])
assert seen["3"] == ([0.0, 0.6, 2.0, 3.25], 1.167, 1.0, [0.525, 0.575, 0.55], -0.104)
assert seen["5"] == ([0.0] * 4, 1.0, 1.0, [0.5] * 3, 0.0) and seen["2"][2:] == seen["5"][2:]
assert seen["3 with the point moved"][0] == [0.0] * 4 and seen["3 with the point moved"][3] == [0.5] * 3
PYTHON
