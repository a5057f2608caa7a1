#!/usr/bin/env bash
# frd2vtu 0.2.1: 15-node prisms (C3D15 of CalculiX) keep the order of .frd, which is another one than that of VTK.
# A .frd lists the middles of the upright edges before those of the upper ones; VTK has them last. Bricks are put right.
# Seen: a prism of volume 1 has 0.083, and the middle of an upright edge lies where VTK has an upper edge; no message.
# Mends it: swap the nodes 9 to 11 and 12 to 14 of each cell of type 26.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile frd2vtu==0.2.1 pyvista==0.49.1 vtk==9.7.2 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import importlib.metadata
import struct

import numpy as np
import pyvista
from frd2vtu.core import frdbin2vtu

prism = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 2], [1, 0, 2], [0, 1, 2]], float)
brick = np.array([[x, y, z] for z in (0, 2) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))], float)
shapes = {
    # type in .frd, corners, edges in the order of .frd, where to find them in that of VTK
    "brick": (4, brick, [0, 1, 2, 3, 8, 9, 10, 11, 4, 5, 6, 7]),
    "prism": (5, prism, [0, 1, 2, 6, 7, 8, 3, 4, 5]),
}
seen = {}
for name, (kind, corners, in_frd) in shapes.items():
    n = len(corners) // 2
    below = [(i, (i + 1) % n) for i in range(n)]
    edges = below + [(a + n, b + n) for a, b in below] + [(i, i + n) for i in range(n)]
    middles = np.array([corners[list(edge)].mean(axis=0) for edge in edges])
    points = np.vstack([corners, middles[in_frd]])
    with open(name + ".frd", "wb") as file:
        file.write(b"    1C\n    2C%30d%38d\n" % (len(points), 3))
        for number, point in enumerate(points, 1):
            file.write(struct.pack("<i3d", number, *point))
        file.write(b"    3C%30d%38d\n" % (1, 2))
        file.write(struct.pack("<%di" % (4 + len(points)), 1, kind, 0, 1, *range(1, len(points) + 1)))
        file.write(b"    1PSTEP%26d%12d%12d          \n" % (1, 1, 1))
        file.write(b"  100CL  101 1.000000000%12d%22d%5d%12d\n -4  DISP        4    1\n" % (len(points), 0, 1, 2))
        file.write(b"".join(b" -5  D%d          1    2%5d    0\n" % (i, i) for i in (1, 2, 3)))
        file.write(b" -5  ALL         1    2    0    0    1ALL\n")
        file.write(b"".join(struct.pack("<i3f", number, 0, 0, 0) for number in range(1, len(points) + 1)))
        file.write(b" 9999\n")
    grid = frdbin2vtu(name + ".frd")
    cell = grid.points[grid.cells[1:]]
    astray = np.linalg.norm(cell[len(corners) :] - middles, axis=1).max()
    cell[len(corners) :] = middles
    right = pyvista.UnstructuredGrid(grid.cells, grid.celltypes, cell[np.argsort(grid.cells[1:])])
    seen[name] = [round(float(x), 3) for x in (grid.volume, right.volume, astray)]
print("frd2vtu", importlib.metadata.version("frd2vtu"), "volume seen, right, a middle node astray by:", seen)
assert seen == {"brick": [2.0, 2.0, 0.0], "prism": [0.083, 1.0, 1.225]}
PYTHON
