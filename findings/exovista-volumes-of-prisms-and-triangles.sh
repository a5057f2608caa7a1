#!/usr/bin/env bash
# exovista 1.3.0: compute_element_volumes() has -6 times the volume of a prism and an area of triangles from the origin.
# The three determinants of a prism are neither divided by 6 nor of the right sign. The area of a triangle is half of
# |x0 y1 - y0 x1|, which is right only where its third corner is at (0, 0).
# Seen: a unit cube of two prisms, written by its own write_exo(), has a volume of -6; cubes as a brick and as six tetrahedra
# have 1. A unit square of two triangles has an area of 0 at the origin, 1.5 at (1, 2) and 2.5 at (5, 1).
# compute_node_volumes(), compute_element_length() and averages weighted by volume take them. No message.
# Fix: volumes of prisms / -6; read_exo() and compute_cell_sizes() of PyVista.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile exovista==1.3.0 pyvista==0.49.1 vtk==9.7.2 netCDF4==1.7.5.1.post1 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata
import logging

import exovista
import numpy as np
import pyvista

corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
logging.disable(logging.WARNING)  # it warns that there are no side sets
kinds = {
    "brick": (pyvista.CellType.HEXAHEDRON, [[0, 1, 2, 3, 4, 5, 6, 7]]),
    "tetrahedra": (
        pyvista.CellType.TETRA,
        [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]],
    ),
    "prisms": (pyvista.CellType.WEDGE, [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]]),
}
print("exovista", importlib.metadata.version("exovista"))


def measure(kind, cells, points):
    cells = np.array(cells)
    listed = np.insert(cells, 0, cells.shape[1], axis=1).ravel()
    grid = pyvista.UnstructuredGrid(listed, np.full(len(cells), kind), points)
    grid.cell_data["region"] = np.ones(len(cells), int)
    exovista.write_exo("body.exo", grid)
    file = exovista.exodusii_file("body.exo")
    seen = sum(exovista.compute_element_volumes(file, block).sum() for block in file.get_element_block_ids())
    nodes = exovista.compute_node_volumes(file).sum()
    file.close()
    sizes = exovista.read_exo("body.exo").compute_cell_sizes(length=False).cell_data
    return float(seen), float(nodes), float(np.abs(sizes["Volume"]).sum() + sizes["Area"].sum())


seen = {}
for name, (kind, cells) in kinds.items():
    seen[name] = measure(kind, cells, corners)
for x, y in ((0, 0), (1, 2), (5, 1)):
    square = corners[:4] + [x, y, 0]
    seen[f"triangles at ({x}, {y})"] = measure(pyvista.CellType.TRIANGLE, [[0, 1, 2], [0, 2, 3]], square)
for name, (volume, nodes, right) in seen.items():
    print(f"  {name}: {volume:.3f}, sum over nodes {nodes:.3f}, as PyVista reads the file {right:.3f}")
    assert np.isclose(right, 1) and np.isclose(volume, nodes)
assert np.isclose(seen["brick"][0], 1) and np.isclose(seen["tetrahedra"][0], 1)
assert np.isclose(seen["prisms"][0], -6)


def half(a, b):
    return abs(a[0] * b[1] - a[1] * b[0]) / 2


for x, y in ((0, 0), (1, 2), (5, 1)):
    a, b, c, d = corners[:4, :2] + [x, y]
    assert np.isclose(seen[f"triangles at ({x}, {y})"][0], half(a, b) + half(a, c))
PYTHON
