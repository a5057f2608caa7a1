#!/usr/bin/env bash
# VTK 9.7.2: vtkDataSetSurfaceFilter, PyVista's extract_surface() of today, turns the faces of a six-node prism inward.
# Tetrahedra and bricks come out right; vtkGeometryFilter has the prism right as well.
# Seen: the surface of a prism of volume 0.5 encloses -0.5; its nodes are in the order that VTK's volume and quality want.
# Mends it: extract_surface(algorithm="geometry"), or vtkPolyDataNormals with AutoOrientNormalsOn().
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile pyvista==0.49.1 vtk==9.7.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
import pyvista
from pyvista import CellType

corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
brick = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def enclosed(surface):
    surface = surface.triangulate()
    a, b, c = surface.points[surface.faces.reshape(-1, 4)[:, 1:]].transpose(1, 0, 2)
    return round(float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6), 6)


seen = {}
for name, kind, points in (
    ("tetrahedron", CellType.TETRA, corners[:4]),
    ("brick", CellType.HEXAHEDRON, brick),
    ("prism", CellType.WEDGE, corners),
):
    grid = pyvista.UnstructuredGrid([len(points), *range(len(points))], [kind], points)
    volume = round(float(grid.compute_cell_sizes()["Volume"][0]), 6)
    jacobian = grid.cell_quality("scaled_jacobian")["scaled_jacobian"][0]
    assert jacobian > 0
    seen[name] = volume, *(enclosed(grid.extract_surface(algorithm=a)) for a in ("dataset_surface", "geometry"))
print("pyvista", pyvista.__version__, "vtk", pyvista.vtk_version_info, "volume, by dataset_surface, by geometry:", seen)
assert seen["tetrahedron"] == (0.166667, 0.166667, 0.166667) and seen["brick"] == (1, 1, 1)
assert seen["prism"] == (0.5, -0.5, 0.5)
PYTHON
