#!/usr/bin/env bash
# iso2mesh 0.6.7: elemvolume() of nodes with a fourth column divides by 4! rather than 3!; volumes are a quarter.
# readmedit() of the same library returns such nodes: the last column is the reference number of a Medit file. Only the
# first three columns are read as coordinates, so that the volume of a tetrahedron is the determinant over six.
# Seen: a unit cube of six tetrahedra, written as .mesh by meshio and read by readmedit(), has a volume of 0.25, and
# nodevolume() sums up to the same. With node[:, :3] both are 1. Areas of triangles are right.
# Fix: elemvolume(node[:, :3], elem).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps iso2mesh==0.6.7 jdata==0.9.5 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0 scipy==1.17.1 numpy==2.4.6 meshio==5.3.5 rich==15.0.0
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata
import itertools

import meshio
import numpy as np
from iso2mesh.io import readmedit
from iso2mesh.trait import elemvolume, nodevolume

points = np.array(list(itertools.product((0, 1), repeat=3)), float)
cells = []
for order in itertools.permutations((4, 2, 1)):
    cells.append([0, order[0], order[0] + order[1], 7])
meshio.Mesh(points, [("tetra", cells)]).write("cube.mesh")
node, elem, _ = readmedit("cube.mesh")
assert np.allclose(node[:, :3], points) and np.array_equal(elem[:, :4] - 1, cells)
four = elemvolume(node, elem[:, :4]).sum(), nodevolume(node, elem[:, :4]).sum()
three = elemvolume(node[:, :3], elem[:, :4]).sum(), nodevolume(node[:, :3], elem[:, :4]).sum()
area = elemvolume(node, np.array([[1, 3, 7]]))[0]
print("iso2mesh", importlib.metadata.version("iso2mesh"), node.shape, "of four columns:", four, "of three:", three, area)
assert node.shape == (8, 4) and np.allclose(four, 0.25) and np.allclose(three, 1) and np.isclose(area, 0.5)
PYTHON
