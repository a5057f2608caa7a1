#!/usr/bin/env bash
# abaqus2dyna 0.0.5: a rotated *INSTANCE is neither turned about its axis nor moved before, and is distorted by a long axis.
# Abaqus translates an instance first and then turns it about the axis from a point a to a point b, of any length.
# The translation is done last here, a is taken for the origin, and b - a is taken for a vector of length 1.
# Seen: a unit brick turned by 90 degrees from (0, 0, 0) to (0, 0, 2) has a volume of 16, not 1, and from (0, 0, 0) to
# (0, 0, 1) 1. Turned about the edge at x = 1 from (1, 0, 0) to (1, 0, 1), its first node goes to (0, 0, 0), not to
# (1, -1, 0). Moved by (3, 0, 0) and turned about the axis z, it goes to (3, 0, 0), not to (0, 3, 0). No message.
# Fix: apply the translation and the rotation to the nodes of the deck before.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip --disable-pip-version-check install --quiet --no-compile --no-deps abaqus2dyna==0.0.5 numpy==2.4.6
cd "$folder"
"$folder/venv/bin/python" - <<'PYTHON'
import contextlib
import importlib.metadata
import io

import numpy as np
from abaqus2dyna.__main__ import convert

cube = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def converted(move, a, b, angle):
    nodes = "".join(f"{i}, {x}, {y}, {z}\n" for i, (x, y, z) in enumerate(cube, 1))
    lines = ", ".join(map(str, move)), ", ".join(map(str, [*a, *b, angle]))
    deck = f"*Part, name=Brick\n*Node\n{nodes}*Element, type=C3D8R\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*End Part\n"
    deck += f"*Assembly, name=All\n*Instance, name=One, part=Brick\n{lines[0]}\n{lines[1]}\n*End Instance\n*End Assembly\n"
    with open("brick.inp", "w") as file:
        file.write(deck)
    out = io.StringIO()
    with open("brick.inp") as file, contextlib.redirect_stdout(io.StringIO()):
        convert(file, out)
    rows = out.getvalue().split("*NODE\n")[1].split("*ELEMENT")[0].splitlines()
    return np.array([[float(row[8 + 16 * k : 24 + 16 * k]) for k in range(3)] for row in rows])


def right(move, a, b, angle):
    axis = np.subtract(b, a) / np.linalg.norm(np.subtract(b, a))
    cross, angle = np.cross(np.eye(3), axis), np.radians(angle)
    turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    return (cube + move - a) @ turn.T + a


def volume(points):
    return abs(float(np.linalg.det(points[[1, 3, 4]] - points[0])))


cases = {
    "unit axis": ([0, 0, 0], [0, 0, 0], [0, 0, 1], 90),
    "long axis": ([0, 0, 0], [0, 0, 0], [0, 0, 2], 90),
    "axis off the origin": ([0, 0, 0], [1, 0, 0], [1, 0, 1], 90),
    "moved and turned": ([3, 0, 0], [0, 0, 0], [0, 0, 1], 90),
}
seen = {name: converted(*case) for name, case in cases.items()}
print("abaqus2dyna", importlib.metadata.version("abaqus2dyna"))
for name, case in cases.items():
    print(" ", name, "volume", round(volume(seen[name]), 3), "first node", seen[name][0].round(3) + 0.0, "right", right(*case)[0].round(3) + 0.0)
assert np.allclose(seen["unit axis"], right(*cases["unit axis"]), atol=1e-6)
assert all(np.isclose(volume(right(*case)), 1) for case in cases.values())
assert not np.isclose(volume(seen["long axis"]), 1)
assert np.allclose(seen["axis off the origin"], right(*cases["unit axis"]), atol=1e-6)
assert np.allclose(seen["moved and turned"][0], [3, 0, 0], atol=1e-6) and np.allclose(right(*cases["moved and turned"])[0], [0, 3, 0])
PYTHON
