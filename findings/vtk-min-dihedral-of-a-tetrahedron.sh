#!/usr/bin/env bash
# VTK 9.7.2: the quality "min angle" of a tetrahedron is not its smallest dihedral angle.
# At the edges 0-2 and 1-3 the supplement of the angle is taken. Seen: 200 random tetrahedra, whose angles are computed
# from the normals of their faces; VTK's answer is the smallest of the six with these two replaced.
# Mends it: compute the angles from the normals of the faces.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile vtk==9.7.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import vtk
from vtkmodules.util.numpy_support import vtk_to_numpy

rng = np.random.default_rng(1)
wrong, worst = 0, 0.0
for _ in range(200):
    points = rng.random((4, 3))
    if np.linalg.det(points[1:] - points[0]) < 0:
        points[[0, 1]] = points[[1, 0]]
    normals = []
    for left in range(4):
        a, b, c = points[[i for i in range(4) if i != left]]
        n = np.cross(b - a, c - a)
        normals.append(n / np.linalg.norm(n) * np.sign(n @ (a - points[left])))
    # The faces opposite i and j meet in the edge of the other two corners.
    angles = {(i, j): 180 - np.degrees(np.arccos(normals[i] @ normals[j])) for i in range(4) for j in range(i + 1, 4)}
    supplemented = min(180 - angle if pair in ((0, 2), (1, 3)) else angle for pair, angle in angles.items())
    grid = vtk.vtkUnstructuredGrid()
    own = vtk.vtkPoints()
    own.SetDataTypeToDouble()
    for point in points:
        own.InsertNextPoint(point)
    grid.SetPoints(own)
    ids = vtk.vtkIdList()
    for i in range(4):
        ids.InsertNextId(i)
    grid.InsertNextCell(vtk.VTK_TETRA, ids)
    quality = vtk.vtkMeshQuality()
    quality.SetInputData(grid)
    quality.SetTetQualityMeasureToMinAngle()
    quality.Update()
    seen = vtk_to_numpy(quality.GetOutput().GetCellData().GetArray("Quality"))[0]
    assert abs(seen - supplemented) < 1e-6, (seen, angles)
    wrong += abs(seen - min(angles.values())) > 1e-6
    worst = max(worst, abs(seen - min(angles.values())))
print("VTK", vtk.VTK_VERSION, "of 200 tetrahedra", wrong, "have another smallest angle, by up to", round(worst, 2), "degrees")
assert wrong == 65
PYTHON
