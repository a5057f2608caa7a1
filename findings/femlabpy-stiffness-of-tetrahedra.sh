#!/usr/bin/env bash
# femlabpy 0.6.2: the stiffness of a tetrahedron, keT4e() and kT4e(), is 12 times too high, and negative in the usual order.
# It has 2 det(J) where the volume, det(J) / 6, belongs; the internal forces of qT4e() have det(J), 6 times the volume, so that
# they are half of the stiffness times the displacements. J is positive where the first three nodes run clockwise as seen from
# the fourth one, the reverse of the order of gmsh, VTK and Abaqus. The mass mT4e() takes the volume in either order.
# Seen: a cube of six tetrahedra in the order of gmsh, pulled with a stress of 0.01 E, gets shorter by 0.000833 of its length,
# in the reverse order longer by as much. Right is longer by 0.01, which the brick kh8e() has. No message.
# Fix: the reverse order, and K / 12 and q / 6.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps femlabpy==0.6.2 scipy==1.17.1 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0 six==1.17.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from femlabpy.elements import solids

points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
usual = np.array([[1, 2, 3, 7], [1, 3, 4, 7], [1, 4, 8, 7], [1, 8, 5, 7], [1, 5, 6, 7], [1, 6, 2, 7]])
cells = {"tetrahedra": usual, "reversed": usual[:, [0, 2, 1, 3]], "brick": np.arange(1, 9)[None]}
material = np.array([[1.0, 0.25, 2.0]])  # E, nu, density
stress = 0.01
held = [3 * node + axis for axis in range(3) for node in range(8) if points[node, axis] == 0]
free = np.setdiff1d(np.arange(24), held)
load = np.zeros(24)
lengths = np.zeros((24, 1))
lengths[0::3, 0] = stress * points[:, 0]  # the strain (0.01, 0, 0, ...)
# The face x = 1 is cut from node 1 to node 6, so that two of its nodes carry a third of the load and two a sixth.
for face in ([1, 2, 6], [1, 6, 5]):
    load[3 * np.array(face)] += stress / 6
print("femlabpy", importlib.metadata.version("femlabpy"))
longer = {}
for name, topology in cells.items():
    topology = np.column_stack([topology, np.ones(len(topology))])
    kind = "h8" if name == "brick" else "T4"
    stiffness = getattr(solids, f"k{kind}e")(np.zeros((24, 24)), topology, points, material)
    forces, stresses, _ = getattr(solids, f"q{kind}e")(np.zeros((24, 1)), topology, points, material, lengths)
    mass = getattr(solids, f"m{kind}e")(np.zeros((24, 24)), topology, points, material).sum() / 3
    pull = np.full(24, 0.0)
    pull[[3, 6, 15, 18]] = stress / 4
    moved = np.zeros(24)
    moved[free] = np.linalg.solve(stiffness[np.ix_(free, free)], (pull if name == "brick" else load)[free])
    longer[name] = moved[[3, 6, 15, 18]]
    share = float(np.vdot(lengths, forces) / np.vdot(lengths, stiffness @ lengths))
    print(f"  {name}: longer by {longer[name].round(6)}, forces over K u: {share:.3f}, mass {mass:.3f}")
    assert np.isclose(mass, 2) and np.isclose(share, 1 if name == "brick" else 0.5)
first = points[usual[0] - 1]
assert np.linalg.det(first[1:] - first[0]) > 0
assert np.allclose(longer["brick"], stress)
assert np.allclose(longer["reversed"], stress / 12) and np.allclose(longer["tetrahedra"], -stress / 12)
PYTHON
