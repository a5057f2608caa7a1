#!/usr/bin/env bash
# neatmesh 0.2.0: the volume of a brick is the product of the three edges at its first node.
# That is right for a box only. Prisms and pyramids are measured otherwise, and prisms are right.
# Seen: a unit brick sheared by 45 degrees has a volume of 1.414, not 1; a frustum with faces of 2 by 2 mm and 1 by 1 mm and
# a height of 1 mm has 4.899, not 7/3, and its centre at half of its height, not at 11/28. As two prisms both are right.
# The ratio of the volumes of neighbours, by which it judges a mesh, has the same error.
# Fix: the sum of the volumes of tetrahedra into which a brick is cut.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps neatmesh==0.2.0 humanize==4.17.0 toml==0.10.2 meshio==5.3.5 rich==15.0.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import meshio
import neatmesh
import numpy as np

cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
sheared = cube + cube[:, 2:] * [1, 0, 0]
frustum = np.where(cube[:, 2:] == 1, cube + [0.5, 0.5, 0], 2 * cube)
seen = {}
for name, points in (("cube", cube), ("sheared", sheared), ("frustum", frustum)):
    meshio.Mesh(points, [("hexahedron", [[0, 1, 2, 3, 4, 5, 6, 7]])]).write("brick.vtu")
    meshio.Mesh(points, [("wedge", [[0, 1, 2, 4, 5, 6], [0, 2, 3, 4, 6, 7]])]).write("prisms.vtu")
    brick, prisms = neatmesh.read("brick.vtu"), neatmesh.read("prisms.vtu")
    seen[name] = [float(x) for x in (brick.cell_volumes[0], prisms.cell_volumes.sum(), brick.cell_centers[0, 2])]
    print(" ", name, "volume of the brick, of two prisms, height of the centre:", np.round(seen[name], 4))
print("neatmesh", importlib.metadata.version("neatmesh"))
assert np.allclose(seen["cube"], [1, 1, 0.5])
assert np.allclose(seen["sheared"], [2**0.5, 1, 0.5])
assert np.allclose(seen["frustum"], [4 * 1.5**0.5, 7 / 3, 0.5])
PYTHON
