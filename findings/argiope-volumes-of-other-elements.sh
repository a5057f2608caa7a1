#!/usr/bin/env bash
# argiope 0.3: centroids_and_volumes() and angles() give elements whose labels are not in order the values of other elements.
# split() returns the parts in the order of labels; both take them in the order of the table. edges() keeps the labels, so that
# stats(), which has all three, mixes them. Labels of any order are valid in Abaqus and are taken by Mesh().
# Seen: a tetrahedron of 1/6 with label 2 and one of 4/3 with label 1, given in this order, have 4/3 and 1/6, and centroids as
# far off; longest edges are right. Beside a flat one, the small one has its least angle of 5.7 degrees in place of 45.
# With labels 1 and 2 all are right. No message.
# Fix: mesh.elements.sort_index(inplace=True) before.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps argiope==0.3 matplotlib==3.8.4 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.1.4 pandas==1.5.3 pytz==2026.6 python-dateutil==2.9.0 six==1.17.0 scipy==1.17.1 numpy==1.26.4
cd "$folder"
"$folder/venv/bin/python" -W ignore - <<'PYTHON'
import importlib.metadata

import numpy as np
from argiope.mesh import Mesh

small = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
large = np.array([[5, 0, 0], [7, 0, 0], [5, 2, 0], [5, 0, 2]], float)
flat = small * [1, 1, 0.1] + [9, 0, 0]
print("argiope", importlib.metadata.version("argiope"))


def measure(labels, bodies, in_order=False):
    mesh = Mesh(
        nlabels=np.arange(4 * len(bodies)) + 1,
        coords=np.vstack(bodies),
        elabels=labels,
        types=["tetra4"] * len(bodies),
        stypes=["C3D4"] * len(bodies),
        conn=np.arange(4 * len(bodies)).reshape(-1, 4) + 1,
        materials=["stone"] * len(bodies),
    )
    if in_order:
        mesh.elements.sort_index(inplace=True)
    sizes, angles, edges = mesh.centroids_and_volumes(), mesh.angles(), mesh.edges()
    result = []
    for label, body in zip(labels, bodies):
        right = abs(np.linalg.det(body[1:] - body[0])) / 6, body.mean(axis=0)[0]
        seen = float(sizes.loc[label, ("volume", "")]), float(sizes.loc[label, ("centroid", "x")])
        longest, least = float(edges.loc[label, ("stats", "lmax")]), float(angles.loc[label, ("stats", "min_angle")])
        print(f"  label {label}: volume {seen[0]:.4f}, right {right[0]:.4f}; x {seen[1]:.3f}, right {right[1]:.3f};", end=" ")
        print(f"longest edge {longest:.3f}, least angle {least:.2f}")
        result.append((seen, right, longest, least))
    return result


a, b = measure([1, 2], [small, large])
c, d = measure([2, 1], [small, large])
assert np.allclose([a[0], b[0]], [a[1], b[1]])
assert np.allclose([c[0], d[0]], [d[1], c[1]]) and not np.isclose(c[1][0], d[1][0])
assert np.isclose(c[2], np.sqrt(2)) and np.isclose(d[2], np.sqrt(8))
e, f = measure([2, 1], [small, flat])
assert e[3] < 6 and np.isclose(f[3], 45)
g, h = measure([2, 1], [small, large], in_order=True)
assert np.allclose([g[0], h[0]], [g[1], h[1]])
PYTHON
