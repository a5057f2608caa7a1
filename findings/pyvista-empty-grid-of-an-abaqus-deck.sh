#!/usr/bin/env bash
# PyVista 0.49.1: read() of an Abaqus deck (.inp) returns a grid without points and cells, and no error.
# The extension is taken for AVS UCD, whose files have it, too.
# Mends it: pyvista.from_meshio(meshio.read("deck.inp")).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile pyvista==0.49.1 vtk==9.7.2
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import pyvista

with open("deck.inp", "w") as file:
    file.write("*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n4, 0., 0., 1.\n*ELEMENT, TYPE=C3D4\n1, 1, 2, 3, 4\n")
grid = pyvista.read("deck.inp")
print("pyvista", pyvista.__version__, type(grid).__name__, grid.n_points, "points", grid.n_cells, "cells")
assert (type(grid).__name__, grid.n_points, grid.n_cells) == ("UnstructuredGrid", 0, 0)
PYTHON
