#!/usr/bin/env bash
# iso2mesh 0.6.7: surfinterior() of a block with a pore returns a point inside the pore; it should be inside the material.
# The documentation has it as a point that the closed surface encloses. A line through the body crosses the surface in
# four points; the stretches between the first and the third and between the second and the fourth are taken, not those
# between the first two and the last two. surfseeds(), whose points name the regions of a mesh, calls it.
# Seen: a block of 10 mm with a pore from 2.2 to 7.9 mm has its inner point at a depth of 3.95 mm, in the pore.
# A block without the pore has a right point, at the half of its depth.
# Fix: of the distances t, sorted, take the middle of t[0] and t[1].
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps iso2mesh==0.6.7 jdata==0.9.5 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0 scipy==1.17.1 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from iso2mesh.trait import surfinterior

sides = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]]
triangles = np.array([t for a, b, c, d in sides for t in ([a, b, c], [a, c, d])])


def corners(low, high):
    return np.array([[x, y, z] for z in (low, high) for y in (low, high) for x in (low, high)], float)


def inside(point, low, high):
    return bool(np.all((point > low) & (point < high)))


block, pore = corners(0, 10), corners(2.2, 7.9)
plain = surfinterior(block, triangles)[0]
point, start, way, t, _ = surfinterior(np.vstack([block, pore]), np.vstack([triangles, triangles + 8]))
depths = np.sort((start + np.outer(t, way))[:, 2]).round(3)
print("iso2mesh", importlib.metadata.version("iso2mesh"), "plain block:", plain, "with a pore:", point, "crossings:", depths)
assert inside(plain, 0, 10) and np.isclose(plain[2], 5)
assert np.allclose(depths, [0, 2.2, 7.9, 10]) and inside(point, 2.2, 7.9) and np.isclose(point[2], 3.95)
PYTHON
