#!/usr/bin/env bash
# meshio 5.3.5: an Exodus file that it writes has the middle nodes of 20-node bricks in meshio's order.
# Exodus lists the upright edges before the upper ones, meshio after them; the reader of VTK (ParaView) keeps to Exodus.
# Seen: a unit brick has a volume of 1/12 there, and meshio alone reads its file as it was. Tetrahedra are right.
# Mends it: swap the nodes 12 to 15 and 16 to 19 of each brick before writing.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile meshio==5.3.5 netCDF4==1.7.5.1.post1 vtk==9.7.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import meshio
import numpy as np
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
edges = np.array([(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)])
brick = np.vstack([corners, corners[edges].mean(axis=1)])
flat = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
ten = np.vstack([flat, flat[np.array([(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)])].mean(axis=1)])


def volume(kind, points, order):
    meshio.write("own.exo", meshio.Mesh(points, [(kind, [order])]))
    own = meshio.read("own.exo")
    assert np.array_equal(own.cells[0].data[0], order)
    reader = vtk.vtkExodusIIReader()
    reader.SetFileName("own.exo")
    reader.Update()
    size = vtk.vtkCellSizeFilter()
    size.SetInputData(reader.GetOutput().GetBlock(0).GetBlock(0))
    size.Update()
    return round(float(vtk_to_numpy(size.GetOutput().GetCellData().GetArray("Volume"))[0]), 6)


straight = list(range(20))
swapped = [*range(12), *range(16, 20), *range(12, 16)]
seen = volume("tetra10", ten, list(range(10))), volume("hexahedron20", brick, straight), volume("hexahedron20", brick, swapped)
print("meshio", meshio.__version__, "VTK", vtk.VTK_VERSION, "volumes of tetrahedron, brick, brick with nodes swapped:", seen)
assert seen == (0.166667, 0.083333, 1.0)
PYTHON
