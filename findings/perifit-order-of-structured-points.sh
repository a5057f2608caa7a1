#!/usr/bin/env bash
# perifit 2.0.1: load_mesh() of structured points in a legacy .vtk gives the volumes of points to other points.
# In that format the first coordinate varies fastest. Points are made with the last one fastest, and the values of the file
# are then taken in their order.
# Seen: of 3 x 2 x 2 points whose volume is 1 + x + 10 y + 100 z, 2 of 12 have their own; the sum is right. No message.
# The same points as an unstructured grid with POINTS are right.
# Fix: the unstructured form, or .csv with vol_col=3.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps perifit==2.0.1 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from perifit.mesh.readers import load_mesh

# The first coordinate varies fastest, as the format has it.
points = np.array([[x, y, z] for z in range(2) for y in range(2) for x in range(3)], float)
volumes = 1 + points @ [1, 10, 100]
data = f"POINT_DATA {len(points)}\nSCALARS volume double 1\nLOOKUP_TABLE default\n" + "\n".join(map(str, volumes)) + "\n"
head = "# vtk DataFile Version 3.0\na mesh\nASCII\n"
with open("structured.vtk", "w") as file:
    file.write(head + "DATASET STRUCTURED_POINTS\nDIMENSIONS 3 2 2\nORIGIN 0 0 0\nSPACING 1 1 1\n" + data)
with open("unstructured.vtk", "w") as file:
    file.write(head + f"DATASET UNSTRUCTURED_GRID\nPOINTS {len(points)} double\n")
    file.write("\n".join(" ".join(map(str, p)) for p in points) + "\n" + data)
right = {}
for name in ("structured", "unstructured"):
    place, volume = load_mesh(name + ".vtk")
    right[name] = np.isclose(volume, 1 + place @ [1, 10, 100])
    assert sorted(map(tuple, place)) == sorted(map(tuple, points)) and np.isclose(volume.sum(), volumes.sum())
    print(" ", name, "points with their own volume:", int(right[name].sum()), "of", len(points))
print("perifit", importlib.metadata.version("perifit"))
assert right["unstructured"].all()
assert right["structured"].sum() == 2
PYTHON
