#!/usr/bin/env bash
# FElupe 11.3.0: mesh.read() of a file with two blocks of cells gives each block its own copy of all points.
# Bodies that share a face in the file are apart in the container. Seen: 5 points in the file, 10 in the container.
# Mends it: mesh.read(name, merge=True).
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile felupe==11.3.0 meshio==5.3.5 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import felupe
import meshio
import numpy as np

points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], float)
meshio.write("two.inp", meshio.Mesh(points, [("tetra", [[0, 1, 2, 3]]), ("tetra", [[1, 2, 3, 4]])]))
apart = felupe.mesh.read("two.inp")
together = felupe.mesh.read("two.inp", merge=True)
shared = [set.intersection(*(set(np.unique(m.cells).tolist()) for m in found.meshes)) for found in (apart, together)]
points = [[len(m.points) for m in found.meshes] for found in (apart, together)]
print("felupe", felupe.__version__, "shared nodes as read:", shared[0], "with merge:", shared[1], "points:", points)
assert shared == [set(), {1, 2, 3}] and points == [[10, 10], [5, 5]]
PYTHON
