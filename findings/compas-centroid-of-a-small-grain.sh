#!/usr/bin/env bash
# COMPAS 2.15.1: centroid_polyhedron() of a body with a volume below 1e-9 is not divided by the volume.
# The bound has no unit, and a grain of 0.9 mm in a model in metres lies below it. No message.
# Seen: a cube of 0.9 mm around (0.05, 0.05, 0.05) m has its centroid at (3.6e-11, 3.6e-11, 3.6e-11); that is its volume times
# its centroid. One of 1.1 mm at the same place is right, and so is that of 0.9 mm given in mm. The volume is right in all.
# It also adds the midpoints of faces of four corners to the list of vertices that it was given: 8 become 14.
# Fix: a list of its own in mm, or coordinates scaled by the size of the body.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile compas==2.15.1 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata
import itertools

import numpy as np
from compas.geometry import centroid_polyhedron, volume_polyhedron

sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


def cube(size, center):
    return [[center + size * (x - 0.5) for x in corner] for corner in itertools.product((0, 1), repeat=3)]


print("COMPAS", importlib.metadata.version("compas"))
seen = {}
for size, center in ((0.9e-3, 0.05), (1.1e-3, 0.05), (0.9, 50.0)):
    volume = volume_polyhedron((cube(size, center), sides))
    vertices = cube(size, center)
    seen[size] = np.array(centroid_polyhedron((vertices, sides)))
    print("  size", size, "volume", volume, "centroid", seen[size], "right", center, "vertices", len(vertices))
    assert np.isclose(volume, size**3) and len(vertices) == 14
assert np.allclose(seen[0.9e-3], 0.9e-3**3 * 0.05, rtol=1e-3, atol=0)
assert np.allclose(seen[1.1e-3], 0.05, rtol=1e-6) and np.allclose(seen[0.9], 50.0, rtol=1e-6)
PYTHON
