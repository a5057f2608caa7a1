#!/usr/bin/env bash
# opensection 1.0.0: the fibers of create_fiber_mesh() leave out a strip of the section; their areas do not sum up to it.
# n fibers along a side have the distance of n - 1 parts and the width of n parts, and those on two of the four sides are
# left out as lying outside.
# Seen: a section of 0.3 by 0.5 m has 94.7 % of its area in fibers at the default size, 84.4 % at 10 cm2, and their centroid
# lies 5 mm or 17 mm off both axes of symmetry. The second moment of area is 94.8 % and 85.1 % of b h^3 / 12.
# Sums of stresses over the fibers are as much too low.
# Fix: own fibers at the centers of cells.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps opensection==1.0.0 matplotlib==3.11.2 contourpy==1.3.3 cycler==0.12.1 fonttools==4.68.0 kiwisolver==1.5.1 packaging==26.4 pillow==13.0.0 pyparsing==3.3.3 python-dateutil==4.0.0 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata

import numpy as np
from opensection.geometry.section import RectangularSection

width, height = 0.3, 0.5
section = RectangularSection(width, height)
assert np.isclose(section.properties.area, width * height)
seen = {}
for size in (1e-4, 1e-3):
    y, z, area = section.create_fiber_mesh(size).T
    share = area.sum() / (width * height)
    center = (y @ area / area.sum(), z @ area / area.sum())
    stiffness = z**2 @ area / (width * height**3 / 12)
    seen[size] = np.round([share, *center, stiffness], 4).tolist()
    print(" fibers of", size, "m2:", len(area), "share of the area, centroid, share of the second moment:", seen[size])
print("opensection", importlib.metadata.version("opensection"))
assert seen[1e-4] == [0.9473, 0.0052, 0.0051, 0.9481]
assert seen[1e-3] == [0.8437, 0.0167, 0.0167, 0.8513] or seen[1e-3] == [0.8437, 0.0167, 0.0167, 0.8512]
PYTHON
